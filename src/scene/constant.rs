//! Values of constant formulas, and folding of numbers.

use crate::expr::{Binary, Function, Unary};
use crate::model::{Comparison, Formula};

/// The value of a formula of numbers and parameters; not a number if it uses anything else.
pub fn evaluate(formula: &Formula, parameters: &[f64]) -> f64 {
    let value = |formula: &Formula| evaluate(formula, parameters);
    match formula {
        Formula::Number(number) => *number,
        Formula::Parameter(id) => parameters.get(id.0).copied().unwrap_or(f64::NAN),
        Formula::Time | Formula::Input(_) | Formula::Discrete(_) | Formula::State(_) | Formula::Variable(_) => f64::NAN,
        // The same on every platform; that of the runtime may differ in the last digit.
        Formula::Call(Function::Two(Binary::Power), sides) => libm::pow(value(&sides[0]), value(&sides[1])),
        Formula::Call(function, arguments) => function.value(&arguments.iter().map(value).collect::<Vec<f64>>()),
        Formula::If(comparison, parts) => {
            let holds = compare(*comparison, value(&parts[0]), value(&parts[1]));
            value(&parts[if holds { 2 } else { 3 }])
        }
    }
}

fn compare(comparison: Comparison, a: f64, b: f64) -> bool {
    match comparison {
        Comparison::Less => a < b,
        Comparison::LessEqual => a <= b,
        Comparison::Greater => a > b,
        Comparison::GreaterEqual => a >= b,
    }
}

/// Is the formula a number?
pub(crate) fn number(formula: &Formula) -> Option<f64> {
    match formula {
        Formula::Number(number) => Some(*number),
        _ => None,
    }
}

/// -a
pub(crate) fn negate(a: Formula) -> Formula {
    apply(Function::One(Unary::Negate), vec![a])
}

/// a op b
pub(crate) fn combine(operator: Binary, a: Formula, b: Formula) -> Formula {
    apply(Function::Two(operator), vec![a, b])
}

/// f(...), a number if all arguments are; without a zero that is added or subtracted.
pub(crate) fn apply(function: Function, mut arguments: Vec<Formula>) -> Formula {
    let adds = matches!(function, Function::Two(Binary::Add | Binary::Subtract));
    if arguments.iter().all(|argument| number(argument).is_some()) {
        Formula::Number(evaluate(&Formula::Call(function, arguments), &[]))
    } else if adds && number(&arguments[1]) == Some(0.0) {
        arguments.swap_remove(0)
    } else {
        Formula::Call(function, arguments)
    }
}

/// Declares an operator of formulas.
macro_rules! operators {
    ($($name:ident $method:ident $operator:ident),*) => {$(
        impl std::ops::$name for Formula {
            type Output = Formula;

            fn $method(self, other: Formula) -> Formula {
                combine(Binary::$operator, self, other)
            }
        }
    )*};
}

operators!(Add add Add, Sub sub Subtract, Mul mul Multiply, Div div Divide);

impl std::ops::Neg for Formula {
    type Output = Formula;

    fn neg(self) -> Formula {
        negate(self)
    }
}

impl Formula {
    /// f(self)
    pub(crate) fn of(self, function: Unary) -> Formula {
        apply(Function::One(function), vec![self])
    }

    /// self^exponent
    pub(crate) fn power(self, exponent: Formula) -> Formula {
        combine(Binary::Power, self, exponent)
    }

    /// The same for a number.
    pub(crate) fn raised(self, exponent: f64) -> Formula {
        self.power(Formula::Number(exponent))
    }

    /// The smaller of two.
    pub(crate) fn smaller(self, other: Formula) -> Formula {
        combine(Binary::Min, self, other)
    }

    /// The larger of two.
    pub(crate) fn larger(self, other: Formula) -> Formula {
        combine(Binary::Max, self, other)
    }
}
