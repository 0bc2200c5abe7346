//! Laws of loads as they stand in the scene: in terms of the load's own across variables.

use crate::component::Origin;
use crate::equations::Equations;
use crate::expr::{Binary, Function};
use crate::mechanism::{BinaryOperator, Comparison, Formula, Owner, Quantity, Variable};
use crate::output::text::name::{Name, symbol_name};
use crate::output::text::steps::letters::Letters;
use crate::output::text::tree::Tree;

/// A law as a tree; what is zero is left out.
pub fn tree(equations: &Equations, letters: Letters, formula: &Formula) -> Tree {
    let of = |formula: &Formula| tree(equations, letters, formula);
    match formula {
        Formula::Number(value) => Tree::number(*value),
        Formula::Time => Tree::Name(Name::word("t")),
        Formula::Parameter(id) => Tree::Name(symbol_name(equations, crate::expr::Symbol::Parameter(id.0))),
        Formula::Input(id) => {
            Tree::Name(symbol_name(equations, crate::expr::Symbol::Input(id.0, crate::expr::Order::Position)))
        }
        Formula::Variable(own) => variable(equations, letters, *own),
        Formula::Negate(inner) => negated(of(inner)),
        Formula::Binary(operator, sides) => {
            let [a, b] = sides.each_ref().map(of);
            binary(*operator, a, b)
        }
        Formula::Call(function, arguments) => call(*function, arguments.iter().map(of).collect()),
        Formula::If(comparison, parts) => {
            let [left, right, then, otherwise] = parts.each_ref().map(of);
            let (sign, sides) = match comparison {
                Comparison::Less => ("<", [left, right]),
                Comparison::LessEqual => ("<=", [left, right]),
                Comparison::Greater => ("<", [right, left]),
                Comparison::GreaterEqual => ("<=", [right, left]),
            };
            Tree::Call("if", vec![Tree::Relation(sign, Box::new(sides)), then, otherwise])
        }
    }
}

/// A law times a tree.
pub fn times(law: Tree, tree: Tree) -> Tree {
    match law {
        Tree::Sum(mut only) if only.len() == 1 => {
            let (minus, inner) = only.remove(0);
            Tree::Sum(vec![(minus, Tree::product(vec![inner, tree]))])
        }
        law => Tree::product(vec![law, tree]),
    }
}

/// |r| and its rate, theta and omega of the load's own edge; other variables by their names.
fn variable(equations: &Equations, letters: Letters, own: Variable) -> Tree {
    let label = match own.owner {
        Owner::Load(load) => equations.system.find(Origin::Load(load)),
        _ => None,
    };
    let plane = letters.has_two_components();
    let named = || Tree::Name(Name::variable(&equations.system.mechanism.variable_name(own)));
    let Some(label) = label.map(|id| equations.system.element(id).label.as_str()) else { return named() };
    match (own.quantity, plane) {
        (Quantity::Length, true) => Tree::Call("abs", vec![letters.displacement(label)]),
        (Quantity::Length, false) => letters.displacement(label),
        (Quantity::Rate, true) => {
            let name = Name::edge("r", label, false);
            Tree::Name(Name { plain: format!("{}'", name.plain), dots: 1, ..name })
        }
        (Quantity::Rate, false) => letters.velocity(label),
        (Quantity::Angle, _) => letters.angle(label),
        (Quantity::Omega, _) => letters.omega(label),
        _ => named(),
    }
}

fn is_negative(tree: &Tree) -> bool {
    matches!(tree, Tree::Sum(terms) if matches!(terms.as_slice(), [(true, _)]))
}

fn negated(tree: Tree) -> Tree {
    match tree {
        Tree::Sum(terms) if terms.len() == 1 => terms
            .into_iter()
            .map(|(minus, term)| if minus { term } else { Tree::Sum(vec![(true, term)]) })
            .collect::<Vec<_>>()
            .remove(0),
        tree if tree == Tree::zero() => tree,
        tree => Tree::Sum(vec![(true, tree)]),
    }
}

fn binary(operator: BinaryOperator, a: Tree, b: Tree) -> Tree {
    let zero = Tree::zero();
    match operator {
        BinaryOperator::Add if a == zero => b,
        BinaryOperator::Add | BinaryOperator::Subtract if b == zero => a,
        BinaryOperator::Subtract if a == zero => negated(b),
        BinaryOperator::Add => Tree::Sum(vec![(false, a), (false, b)]),
        BinaryOperator::Subtract => Tree::Sum(vec![(false, a), (true, b)]),
        BinaryOperator::Multiply if a == zero || b == zero => zero,
        BinaryOperator::Multiply if a == Tree::Number(1.0) => b,
        BinaryOperator::Multiply if is_negative(&a) => negated(binary(operator, negated(a), b)),
        BinaryOperator::Multiply => Tree::product(vec![a, b]),
        BinaryOperator::Divide => Tree::Quotient(Box::new([a, b])),
        BinaryOperator::Power => Tree::power(a, b),
    }
}

fn call(function: Function, arguments: Vec<Tree>) -> Tree {
    match (function, arguments.as_slice()) {
        (Function::Two(Binary::Less), [a, b]) => Tree::Relation("<", Box::new([a.clone(), b.clone()])),
        (Function::Two(Binary::LessEqual), [a, b]) => Tree::Relation("<=", Box::new([a.clone(), b.clone()])),
        _ => Tree::Call(function.name(), arguments),
    }
}
