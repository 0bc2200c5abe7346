//! Formulas as they are printed, for all notations.

use std::collections::BTreeMap;

use cotree::equations::Equations;
use cotree::expr::{Binary, Expr, Unary};

use super::name::{Name, Names};
use super::normal::{CalledFunction, ProductTerm, Sum, TermFactor};
use super::number::{WrittenNumber, written};
use super::read::{Readable, ReadingContext};

#[derive(Clone, Debug, PartialEq)]
pub enum FormulaTree {
    /// A number that is not negative.
    Number(f64),
    /// The ratio of a circle's circumference to its diameter.
    Pi,
    Name(Name),
    /// Terms, each with a minus sign or without.
    Sum(Vec<(bool, FormulaTree)>),
    Product(Vec<FormulaTree>),
    Quotient(Box<[FormulaTree; 2]>),
    Power(Box<[FormulaTree; 2]>),
    Root(Box<FormulaTree>),
    Call(&'static str, Vec<FormulaTree>),
    /// a < b, a <= b, and of vectors a . b and a x b
    Relation(&'static str, Box<[FormulaTree; 2]>),
}

impl FormulaTree {
    /// A number of either sign, written in the shortest way.
    pub fn number(value: f64) -> FormulaTree {
        if value == 0.0 {
            return FormulaTree::zero();
        }
        let (over, under) = number(value.abs());
        let size = FormulaTree::quotient(over, under);
        if value < 0.0 { FormulaTree::Sum(vec![(true, size)]) } else { size }
    }

    /// a^2 and the like.
    pub fn power(base: FormulaTree, exponent: FormulaTree) -> FormulaTree {
        FormulaTree::Power(Box::new([base, exponent]))
    }

    /// A product of factors over others, if there are any.
    pub(crate) fn quotient(over: Vec<FormulaTree>, under: Vec<FormulaTree>) -> FormulaTree {
        let over = FormulaTree::product(over);
        if under.is_empty() { over } else { FormulaTree::Quotient(Box::new([over, FormulaTree::product(under)])) }
    }

    pub fn zero() -> FormulaTree {
        FormulaTree::Number(0.0)
    }

    pub fn product(mut factors: Vec<FormulaTree>) -> FormulaTree {
        match factors.pop() {
            None => FormulaTree::Number(1.0),
            Some(only) if factors.is_empty() => only,
            Some(last) => {
                factors.push(last);
                FormulaTree::Product(factors)
            }
        }
    }

    /// Is it a sum of names with this one among them?
    pub fn names(&self, name: &Name) -> bool {
        match self {
            FormulaTree::Name(other) => other == name,
            FormulaTree::Sum(terms) => terms.iter().any(|(_, term)| term.names(name)),
            _ => false,
        }
    }

    /// How many names occur.
    pub fn count_names(&self) -> usize {
        let all = |trees: &[FormulaTree]| trees.iter().map(FormulaTree::count_names).sum();
        match self {
            FormulaTree::Number(_) | FormulaTree::Pi => 0,
            FormulaTree::Name(_) => 1,
            FormulaTree::Sum(terms) => terms.iter().map(|(_, term)| term.count_names()).sum(),
            FormulaTree::Product(parts) | FormulaTree::Call(_, parts) => all(parts),
            FormulaTree::Quotient(parts) | FormulaTree::Power(parts) | FormulaTree::Relation(_, parts) => {
                all(parts.as_ref())
            }
            FormulaTree::Root(inside) => inside.count_names(),
        }
    }

    /// Calls `visit` with every name that occurs.
    pub fn visit_names(&mut self, visit: &mut dyn FnMut(&mut Name)) {
        match self {
            FormulaTree::Number(_) | FormulaTree::Pi => {}
            FormulaTree::Name(name) => visit(name),
            FormulaTree::Sum(terms) => terms.iter_mut().for_each(|(_, term)| term.visit_names(visit)),
            FormulaTree::Product(parts) | FormulaTree::Call(_, parts) => {
                parts.iter_mut().for_each(|part| part.visit_names(visit))
            }
            FormulaTree::Quotient(parts) | FormulaTree::Power(parts) | FormulaTree::Relation(_, parts) => {
                parts.iter_mut().for_each(|part| part.visit_names(visit));
            }
            FormulaTree::Root(inside) => inside.visit_names(visit),
        }
    }

    pub fn sum(mut terms: Vec<(bool, FormulaTree)>) -> FormulaTree {
        // A sum does not begin with a minus sign if it can begin without.
        if let Some(first) = terms.iter().position(|(minus, _)| !minus) {
            terms[..=first].rotate_right(1);
        }
        match terms.pop() {
            None => FormulaTree::zero(),
            Some((false, only)) if terms.is_empty() => only,
            Some(last) => {
                terms.push(last);
                FormulaTree::Sum(terms)
            }
        }
    }
}

/// Formulas in a row, with the abbreviations and definitions that they need.
#[derive(Clone, Debug, Default)]
pub struct Formulas {
    pub angles: Vec<(FormulaTree, FormulaTree)>,
    /// Other definitions, in the order of dependence.
    pub definitions: Vec<(FormulaTree, FormulaTree)>,
    pub formulas: Vec<FormulaTree>,
}

/// Formulas without abbreviations.
pub fn plain(equations: &Equations, exprs: &[Expr]) -> Vec<FormulaTree> {
    formulas(equations, exprs, &ReadingContext::default()).formulas
}

pub fn formulas(equations: &Equations, exprs: &[Expr], context: &ReadingContext) -> Formulas {
    let (reading, names) = (&Readable::new(&equations.system.arena, exprs, context), &Names::new(equations));
    let defined = definition_names(reading, names);
    let variables = defined.iter().scan(names.coordinates, |count, name| {
        *count += usize::from(name.is_variable());
        Some(name.is_variable().then_some(*count))
    });
    let mut layout = Layout { names, variables: variables.collect(), defined, angles: BTreeMap::new() };
    let used = reading.definitions.iter().enumerate().filter(|(_, definition)| definition.uses > 0);
    let definitions = used.map(|(index, definition)| {
        (index, (FormulaTree::Name(layout.defined[index].clone()), layout.sum(&definition.value)))
    });
    let definitions = definitions.collect::<Vec<_>>();
    let formulas = reading.roots.iter().map(|root| layout.sum(root)).collect();
    // The sine and cosine of an angle that is itself defined come right after it.
    let (mut angles, mut named) = (Vec::new(), BTreeMap::<usize, Vec<_>>::new());
    for ((factor, _), (name, value)) in layout.angles {
        let pair = (FormulaTree::Name(name), value);
        match factor {
            TermFactor::Named(index, _) => named.entry(index).or_default().push(pair),
            _ => angles.push(pair),
        }
    }
    let definitions = definitions
        .into_iter()
        .flat_map(|(index, pair)| std::iter::once(pair).chain(named.remove(&index).unwrap_or_default()))
        .collect();
    Formulas { angles, definitions, formulas }
}

fn definition_names(reading: &Readable, names: &Names<'_>) -> Vec<Name> {
    let mut count = 0;
    let name = |definition: &super::read::Definition| match &definition.variable {
        Some(variable) => Name::variable(variable),
        None => {
            count += usize::from(definition.uses > 0);
            names.shared(count)
        }
    };
    reading.definitions.iter().map(name).collect()
}

struct Layout<'a> {
    names: &'a Names<'a>,
    defined: Vec<Name>,
    /// Numbers of the definitions that have a name of the user's, after those of the coordinates.
    variables: Vec<Option<usize>>,
    /// Sines and cosines that got a short name: by angle, cosine first.
    angles: BTreeMap<(TermFactor, bool), (Name, FormulaTree)>,
}

impl Layout<'_> {
    fn sum(&mut self, sum: &Sum) -> FormulaTree {
        // A formula begins without a minus sign if the terms in one of its parentheses can change their signs.
        let mut flip = sum.0.iter().all(|term| term.number.0 < 0.0);
        let terms = sum.0.iter().map(|term| self.term(term, &mut flip)).collect();
        FormulaTree::sum(terms)
    }

    fn term(&mut self, term: &ProductTerm, flip: &mut bool) -> (bool, FormulaTree) {
        let mut minus = term.number.0 < 0.0;
        let (mut over, mut under) = number(term.number.0.abs());
        for (factor, power) in &term.factors {
            let tree = match factor {
                TermFactor::Sum(sum) if *flip && *power == 1 && sum.0.iter().any(|term| term.number.0 < 0.0) => {
                    (minus, *flip) = (false, false);
                    self.sum(&sum.scaled(-1.0))
                }
                _ => self.factor(factor),
            };
            let side = if *power > 0 { &mut over } else { &mut under };
            side.push(match power.unsigned_abs() {
                1 => tree,
                power => FormulaTree::power(tree, FormulaTree::Number(f64::from(power))),
            });
        }
        (minus, FormulaTree::quotient(over, under))
    }

    fn factor(&mut self, factor: &TermFactor) -> FormulaTree {
        match factor {
            TermFactor::Symbol(symbol, _) => FormulaTree::Name(self.names.symbol(*symbol)),
            TermFactor::Named(index, _) => FormulaTree::Name(self.defined[*index].clone()),
            TermFactor::Sum(sum) => self.sum(sum),
            TermFactor::Trigonometric(angle, sine) => self.trigonometric(angle, *sine),
            TermFactor::Call(function, arguments) => {
                let arguments: Vec<FormulaTree> = arguments.iter().map(|argument| self.sum(argument)).collect();
                call(*function, arguments)
            }
        }
    }

    /// `c1`, `s1` for the angle of a coordinate, higher numbers for other angles with a name.
    fn trigonometric(&mut self, angle: &Sum, sine: bool) -> FormulaTree {
        let value = FormulaTree::Call(if sine { "sin" } else { "cos" }, vec![self.sum(angle)]);
        let Some(factor) = angle.single() else { return value };
        let number = match factor {
            TermFactor::Symbol(symbol, _) => self.names.coordinate(*symbol),
            TermFactor::Named(index, _) => self.variables[*index],
            _ => None,
        };
        let Some(number) = number else { return value };
        let name = self.names.trigonometric(sine, number);
        self.angles.insert((factor.clone(), sine), (name.clone(), value));
        FormulaTree::Name(name)
    }
}

/// The number in front of a term, as factors above and below.
fn number(value: f64) -> (Vec<FormulaTree>, Vec<FormulaTree>) {
    match written(value) {
        WrittenNumber::Decimal(1.0) => (Vec::new(), Vec::new()),
        WrittenNumber::Decimal(value) => (vec![FormulaTree::Number(value)], Vec::new()),
        WrittenNumber::Fraction { over, under, pi } => {
            let whole = |value: u32| (value != 1).then(|| FormulaTree::Number(f64::from(value)));
            let power = match pi {
                0 => None,
                1 => Some(FormulaTree::Pi),
                _ => Some(FormulaTree::power(FormulaTree::Pi, FormulaTree::Number(f64::from(pi)))),
            };
            (whole(over).into_iter().chain(power).collect(), whole(under).into_iter().collect())
        }
    }
}

fn call(function: CalledFunction, mut arguments: Vec<FormulaTree>) -> FormulaTree {
    let name = match function {
        CalledFunction::One(Unary::Sqrt) => {
            return match arguments.pop().unwrap_or_else(FormulaTree::zero) {
                FormulaTree::Power(parts) if parts[1] == FormulaTree::Number(2.0) => {
                    FormulaTree::Call("abs", vec![parts[0].clone()])
                }
                inside => FormulaTree::Root(Box::new(inside)),
            };
        }
        CalledFunction::One(function) => function.definition().name,
        CalledFunction::Select => "if",
        CalledFunction::Two(function) => match (function, <[FormulaTree; 2]>::try_from(arguments)) {
            (Binary::Power, Ok(operands)) => return FormulaTree::Power(Box::new(operands)),
            (Binary::Less, Ok(operands)) => return FormulaTree::Relation("<", Box::new(operands)),
            (Binary::LessEqual, Ok(operands)) => return FormulaTree::Relation("<=", Box::new(operands)),
            (_, operands) => {
                arguments = operands.map_or_else(|arguments| arguments, Vec::from);
                function.definition().name
            }
        },
    };
    FormulaTree::Call(name, arguments)
}
