//! Expressions of the scene with their names resolved.

use super::{InputId, ParameterId, Variable};
use crate::expr::Function;

/// A parsed expression with its names resolved.
#[derive(Clone, Debug, PartialEq)]
pub enum Formula {
    /// A number, SI.
    Number(f64),
    /// `t`
    Time,
    /// A parameter.
    Parameter(ParameterId),
    /// An input.
    Input(InputId),
    /// A variable of the naming table.
    Variable(Variable),
    /// -a
    Negate(Box<Formula>),
    /// a op b
    Binary(BinaryOperator, Box<[Formula; 2]>),
    /// f(a) or f(a, b)
    Call(Function, Vec<Formula>),
    /// if(left op right, then, otherwise)
    If(Comparison, Box<[Formula; 4]>),
}

impl Formula {
    /// Calls `visit` with every parameter that occurs.
    pub fn visit_parameters(&self, visit: &mut dyn FnMut(ParameterId)) {
        match self {
            Formula::Number(_) | Formula::Time | Formula::Variable(_) | Formula::Input(_) => {}
            Formula::Parameter(id) => visit(*id),
            Formula::Negate(inner) => inner.visit_parameters(visit),
            Formula::Binary(_, operands) => operands.iter().for_each(|operand| operand.visit_parameters(visit)),
            Formula::Call(_, arguments) => arguments.iter().for_each(|argument| argument.visit_parameters(visit)),
            Formula::If(_, parts) => parts.iter().for_each(|part| part.visit_parameters(visit)),
        }
    }

    /// Calls `visit` with every variable that occurs.
    pub fn visit_variables(&self, visit: &mut dyn FnMut(Variable)) {
        match self {
            Formula::Number(_) | Formula::Time | Formula::Parameter(_) | Formula::Input(_) => {}
            Formula::Variable(variable) => visit(*variable),
            Formula::Negate(inner) => inner.visit_variables(visit),
            Formula::Binary(_, operands) => operands.iter().for_each(|operand| operand.visit_variables(visit)),
            Formula::Call(_, arguments) => arguments.iter().for_each(|argument| argument.visit_variables(visit)),
            Formula::If(_, parts) => parts.iter().for_each(|part| part.visit_variables(visit)),
        }
    }
}

/// + - * / ^
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum BinaryOperator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

/// < <= > >=
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Comparison {
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
}
