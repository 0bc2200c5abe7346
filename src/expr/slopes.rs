//! Which symbols change an expression: not those that it contains, but those whose derivative is not zero, neither by itself nor because terms
//! cancel. Decided by the values of the derivatives at a state (polynomial identity testing), with their rounding errors.
//!
//! Where an expression has branches, all of them count: a choice is a mixture of what is chosen from, and what decides it counts as well.

use std::collections::HashMap;

use super::rounded::Rounded;
use super::{Arena, Binary, Expr, Node, Symbol, Unary, evaluate};

/// The slopes of one operation: operand and partial derivative.
type Partials = [(usize, Rounded); 3];

/// The share of the first branch in a mixture, and the slope of what jumps.
const MIXTURE: f64 = 0.381_966_011_250_105;

/// Expressions evaluated at a state, ready for derivatives.
#[derive(Debug)]
pub struct Slopes {
    /// Results in the order of evaluation.
    steps: Vec<Step>,
    /// Where each expression's result is.
    places: HashMap<Expr, usize>,
    values: Vec<Rounded>,
}

#[derive(Debug)]
enum Step {
    Symbol(Symbol),
    Operation(Partials),
}

impl Slopes {
    /// Evaluates the expressions, those for solved symbols first, with the values of the other symbols.
    pub fn new(
        arena: &Arena,
        solved: &HashMap<Symbol, Expr>,
        roots: &[Expr],
        values: impl Fn(Symbol) -> Rounded,
    ) -> Self {
        let mut slopes = Slopes { steps: Vec::new(), places: HashMap::new(), values: Vec::new() };
        for roots in [&solved.values().copied().collect::<Vec<_>>(), roots] {
            for expr in arena.reachable(roots.iter().copied()) {
                if !slopes.places.contains_key(&expr) {
                    slopes.add(arena, solved, expr, &values);
                }
            }
        }
        slopes
    }

    /// Evaluates these expressions, operands first.
    pub fn along(arena: &Arena, order: &[Expr], values: impl Fn(Symbol) -> Rounded) -> Self {
        let mut slopes = Slopes { steps: Vec::new(), places: HashMap::new(), values: Vec::new() };
        let none = HashMap::new();
        order.iter().for_each(|&expr| slopes.add(arena, &none, expr, &values));
        slopes
    }

    fn add(&mut self, arena: &Arena, solved: &HashMap<Symbol, Expr>, expr: Expr, values: &impl Fn(Symbol) -> Rounded) {
        let none = (0, Rounded::default());
        let node = arena.node(expr);
        if let Node::Symbol(symbol) = node
            && let Some(place) = solved.get(&symbol).and_then(|value| self.places.get(value))
        {
            self.places.insert(expr, *place);
            return;
        }
        let of = |operand: Expr| self.places.get(&operand).map_or(none, |&place| (place, self.values[place]));
        let (value, step) = match node {
            Node::Constant(bits) => (Rounded::exact(f64::from_bits(bits)), Step::Operation([none; 3])),
            Node::Symbol(symbol) => (values(symbol), Step::Symbol(symbol)),
            Node::Unary(function, a) => {
                let (place, a) = of(a);
                let (value, slope) = unary(function, a);
                (value, Step::Operation([(place, slope), none, none]))
            }
            Node::Binary(function, a, b) => {
                let ((first, a), (second, b)) = (of(a), of(b));
                let (value, [in_a, in_b]) = binary(function, a, b);
                (value, Step::Operation([(first, in_a), (second, in_b), none]))
            }
            Node::Select(condition, a, b) => {
                let ((decides, _), (first, a), (second, b)) = (of(condition), of(a), of(b));
                let (share, rest) = mixture();
                (share * a + rest * b, Step::Operation([(decides, a - b), (first, share), (second, rest)]))
            }
        };
        self.places.insert(expr, self.values.len());
        self.values.push(value);
        self.steps.push(step);
    }

    /// How many operations there are.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Is there none?
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Which of the roots change with a known value, given how much each symbol changes with it. Nothing if that cannot be told here.
    pub fn changing(&self, roots: &[Expr], change: impl Fn(Symbol) -> f64) -> Vec<Option<bool>> {
        let slopes = self.slopes(roots, |symbol| Rounded::exact(change(symbol)));
        slopes.into_iter().map(Rounded::is_not_zero).collect()
    }

    /// The values of the roots.
    pub fn values(&self, roots: &[Expr]) -> Vec<Rounded> {
        roots.iter().map(|root| self.places.get(root).map(|&place| self.values[place]).unwrap_or_default()).collect()
    }

    /// How much each of the roots changes, given how much each symbol does.
    pub fn slopes(&self, roots: &[Expr], change: impl Fn(Symbol) -> Rounded) -> Vec<Rounded> {
        let mut slopes: Vec<Rounded> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            slopes.push(match step {
                Step::Symbol(symbol) => change(*symbol),
                Step::Operation(partials) => {
                    let moved = partials
                        .iter()
                        .filter(|(place, _)| slopes.get(*place).is_some_and(|slope| *slope != Rounded::default()));
                    moved.fold(Rounded::default(), |sum, &(place, partial)| partial * slopes[place] + sum)
                }
            });
        }
        roots.iter().map(|root| self.places.get(root).map(|&place| slopes[place]).unwrap_or_default()).collect()
    }
}

fn mixture() -> (Rounded, Rounded) {
    (Rounded::exact(MIXTURE), Rounded::exact(1.0 - MIXTURE))
}

/// f(a) and f'(a).
fn unary(function: Unary, a: Rounded) -> (Rounded, Rounded) {
    let one = Rounded::exact(1.0);
    let value = evaluate::apply_unary(function, a.value);
    let with = |slope: Rounded| (a.apply(value, slope.value), slope);
    let cosine = |a: Rounded| a.apply(a.value.cos(), a.value.sin());
    match function {
        Unary::Negate => (-a, -one),
        Unary::Sqrt => with(Rounded::exact(0.5) / a.sqrt()),
        Unary::Sin => with(cosine(a)),
        Unary::Cos => with(-a.apply(a.value.sin(), a.value.cos())),
        Unary::Tan => with(one / cosine(a).square()),
        Unary::Asin => with(one / (one - a.square()).sqrt()),
        Unary::Acos => with(-(one / (one - a.square()).sqrt())),
        Unary::Atan => with(one / (one + a.square())),
        Unary::Exp => with(a.apply(value, value)),
        Unary::Log => with(one / a),
        Unary::Tanh => with(one - a.apply(value, 1.0 - value * value).square()),
        Unary::Abs => with(Rounded::exact(evaluate::apply_unary(Unary::Sign, a.value))),
        // They jump.
        Unary::Sign | Unary::Floor => (Rounded::exact(value), Rounded::exact(MIXTURE)),
    }
}

/// f(a, b) and both its slopes.
fn binary(function: Binary, a: Rounded, b: Rounded) -> (Rounded, [Rounded; 2]) {
    let one = Rounded::exact(1.0);
    match function {
        Binary::Add => (a + b, [one, one]),
        Binary::Subtract => (a - b, [one, -one]),
        Binary::Multiply => (a * b, [b, a]),
        Binary::Divide => {
            let quotient = a / b;
            (quotient, [one / b, -(quotient / b)])
        }
        Binary::Power => power(a, b),
        Binary::Atan2 => {
            let norm = a.square() + b.square();
            let slopes = [b / norm, -(a / norm)];
            let value = evaluate::apply_binary(function, a.value, b.value);
            // The error is that of its parts.
            (a.apply(value, slopes[0].value) + b.apply(0.0, slopes[1].value), slopes)
        }
        Binary::Min | Binary::Max => {
            let (share, rest) = mixture();
            (share * a + rest * b, [share, rest])
        }
        // They jump where a - b changes its sign.
        Binary::Less | Binary::LessEqual => {
            (Rounded::exact(MIXTURE), [Rounded::exact(MIXTURE), Rounded::exact(-MIXTURE)])
        }
    }
}

/// a^b, b a^(b-1), a^b ln(a)
fn power(a: Rounded, b: Rounded) -> (Rounded, [Rounded; 2]) {
    let raised = |exponent: f64| evaluate::apply_binary(Binary::Power, a.value, exponent);
    let value = raised(b.value);
    let steep = (b.value - 1.0) * raised(b.value - 2.0);
    let in_a = b * a.apply(raised(b.value - 1.0), steep);
    let log = a.apply(a.value.ln(), 1.0 / a.value);
    let in_b = a.apply(value, in_a.value) * log;
    (a.apply(value, in_a.value) + b.apply(0.0, in_b.value), [in_a, in_b])
}
