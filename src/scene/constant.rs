//! Values of constant formulas, and folding of numbers.

use crate::expr::Function;
use crate::mechanism::{BinaryOperator, Comparison, Formula};

/// The value of a formula of numbers and parameters; not a number if it uses anything else.
pub(crate) fn evaluate(formula: &Formula, parameters: &[f64]) -> f64 {
    let value = |formula: &Formula| evaluate(formula, parameters);
    match formula {
        Formula::Number(number) => *number,
        Formula::Parameter(id) => parameters.get(id.0).copied().unwrap_or(f64::NAN),
        Formula::Time | Formula::Input(_) | Formula::Variable(_) => f64::NAN,
        Formula::Negate(a) => -value(a),
        Formula::Binary(operator, sides) => binary(*operator, value(&sides[0]), value(&sides[1])),
        Formula::Call(function, arguments) => function.value(&arguments.iter().map(value).collect::<Vec<f64>>()),
        Formula::If(comparison, parts) => {
            let holds = compare(*comparison, value(&parts[0]), value(&parts[1]));
            value(&parts[if holds { 2 } else { 3 }])
        }
    }
}

fn binary(operator: BinaryOperator, a: f64, b: f64) -> f64 {
    match operator {
        BinaryOperator::Add => a + b,
        BinaryOperator::Subtract => a - b,
        BinaryOperator::Multiply => a * b,
        BinaryOperator::Divide => a / b,
        BinaryOperator::Power => a.powf(b),
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
    match number(&a) {
        Some(number) => Formula::Number(-number),
        None => Formula::Negate(Box::new(a)),
    }
}

/// a op b, a number if both are.
pub(crate) fn combine(operator: BinaryOperator, a: Formula, b: Formula) -> Formula {
    match (number(&a), number(&b)) {
        (Some(a), Some(b)) => Formula::Number(binary(operator, a, b)),
        (_, Some(0.0)) if matches!(operator, BinaryOperator::Add | BinaryOperator::Subtract) => a,
        _ => Formula::Binary(operator, Box::new([a, b])),
    }
}

/// Declares an operator of formulas.
macro_rules! operators {
    ($($name:ident $method:ident $operator:ident),*) => {$(
        impl std::ops::$name for Formula {
            type Output = Formula;

            fn $method(self, other: Formula) -> Formula {
                combine(BinaryOperator::$operator, self, other)
            }
        }
    )*};
}

operators!(Add add Add, Sub sub Subtract, Mul mul Multiply, Div div Divide);

/// f(...), a number if all arguments are.
pub(crate) fn apply(function: Function, arguments: Vec<Formula>) -> Formula {
    let formula = Formula::Call(function, arguments);
    match &formula {
        Formula::Call(_, arguments) if arguments.iter().all(|argument| number(argument).is_some()) => {
            Formula::Number(evaluate(&formula, &[]))
        }
        _ => formula,
    }
}
