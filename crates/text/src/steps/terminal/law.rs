//! Laws of loads as written in the scene: in terms of the across variables of the load.

use cotree::equations::Equations;
use cotree::expr::Order;
use cotree::expr::{Binary, Function, Unary};
use cotree::model::{Aspect, Comparison, Formula, Owner, Variable};
use cotree::network::Origin;

use crate::name::{Name, symbol_name};
use crate::steps::letters::Letters;
use crate::tree::FormulaTree;

/// A law as a tree; what is zero is left out.
pub fn tree(equations: &Equations, letters: Letters, formula: &Formula) -> FormulaTree {
    let of = |formula: &Formula| tree(equations, letters, formula);
    match formula {
        Formula::Number(value) => FormulaTree::number(*value),
        Formula::Time => FormulaTree::Name(Name::word("t")),
        Formula::Parameter(id) => FormulaTree::Name(symbol_name(equations, cotree::expr::Symbol::Parameter(id.0))),
        Formula::Discrete(id) => FormulaTree::Name(symbol_name(equations, cotree::expr::Symbol::Discrete(id.0))),
        Formula::Input(id) => {
            FormulaTree::Name(symbol_name(equations, cotree::expr::Symbol::Input(id.0, cotree::expr::Order::Position)))
        }
        Formula::State(id) => {
            FormulaTree::Name(symbol_name(equations, cotree::expr::Symbol::State(id.0, cotree::expr::Order::Position)))
        }
        Formula::Variable(id) => variable(equations, letters, *id),
        Formula::Call(function, arguments) => call(*function, arguments.iter().map(of).collect()),
        Formula::If(comparison, parts) => {
            let [left, right, then, otherwise] = parts.each_ref().map(of);
            let (sign, sides) = match comparison {
                Comparison::Less => ("<", [left, right]),
                Comparison::LessEqual => ("<=", [left, right]),
                Comparison::Greater => ("<", [right, left]),
                Comparison::GreaterEqual => ("<=", [right, left]),
            };
            FormulaTree::Call("if", vec![FormulaTree::Relation(sign, Box::new(sides)), then, otherwise])
        }
    }
}

/// |r| and its rate, theta and omega of the load's own edge; other variables by their names.
fn variable(equations: &Equations, letters: Letters, variable: Variable) -> FormulaTree {
    let label = match variable.owner {
        Owner::Load(load) => equations.system.find(Origin::Load(load)),
        Owner::Place(_) | Owner::Joint(_) | Owner::Driver(_) | Owner::System => None,
    };
    let plane = letters.has_two_components();
    let named = || FormulaTree::Name(Name::variable(&equations.system.mechanism.variable_name(variable)));
    let Some(label) = label.map(|id| equations.system.element(id).label.as_str()) else { return named() };
    match (variable.quantity.aspect(), plane) {
        (Aspect::Length(Order::Position), true) => FormulaTree::Call("abs", vec![letters.displacement(label)]),
        (Aspect::Length(Order::Position), false) => letters.displacement(label),
        (Aspect::Length(Order::Velocity), true) => {
            let name = Name::edge("r", label, false);
            FormulaTree::Name(Name { plain: format!("abs({})'", name.plain), dots: 1, ..name })
        }
        (Aspect::Length(Order::Velocity), false) => letters.velocity(label),
        (Aspect::Angle(Order::Position), _) => letters.angle(label),
        (Aspect::Angle(Order::Velocity), _) => letters.omega(label),
        (Aspect::Length(Order::Acceleration) | Aspect::Angle(Order::Acceleration), _) => named(),
        (Aspect::Along(..) | Aspect::Slide(_) | Aspect::PressureAngle | Aspect::Curvature | Aspect::State, _) => {
            named()
        }
        (Aspect::Effort(_) | Aspect::Contact(_) | Aspect::Whole(_), _) => named(),
    }
}

fn is_negative(tree: &FormulaTree) -> bool {
    matches!(tree, FormulaTree::Sum(terms) if matches!(terms.as_slice(), [(true, _)]))
}

fn negated(tree: FormulaTree) -> FormulaTree {
    match tree {
        FormulaTree::Sum(terms) if terms.len() == 1 => terms
            .into_iter()
            .map(|(minus, term)| if minus { term } else { FormulaTree::Sum(vec![(true, term)]) })
            .collect::<Vec<_>>()
            .remove(0),
        tree if tree == FormulaTree::zero() => tree,
        tree => FormulaTree::Sum(vec![(true, tree)]),
    }
}

fn call(function: Function, mut arguments: Vec<FormulaTree>) -> FormulaTree {
    match (function, arguments.len()) {
        (Function::One(Unary::Negate), 1) => negated(arguments.remove(0)),
        (Function::Two(operator), 2) => {
            let b = arguments.remove(1);
            binary(operator, arguments.remove(0), b)
        }
        _ => FormulaTree::Call(function.name(), arguments),
    }
}

fn binary(operator: Binary, a: FormulaTree, b: FormulaTree) -> FormulaTree {
    let zero = FormulaTree::zero();
    match operator {
        Binary::Add if a == zero => b,
        Binary::Add | Binary::Subtract if b == zero => a,
        Binary::Subtract if a == zero => negated(b),
        Binary::Add => FormulaTree::Sum(vec![(false, a), (false, b)]),
        Binary::Subtract => FormulaTree::Sum(vec![(false, a), (true, b)]),
        Binary::Multiply if a == zero || b == zero => zero,
        Binary::Multiply if a == FormulaTree::Number(1.0) => b,
        Binary::Multiply if is_negative(&a) => negated(binary(operator, negated(a), b)),
        Binary::Multiply => FormulaTree::product(vec![a, b]),
        Binary::Divide => FormulaTree::Quotient(Box::new([a, b])),
        Binary::Power => FormulaTree::power(a, b),
        function => FormulaTree::Call(function.definition().name, vec![a, b]),
    }
}
