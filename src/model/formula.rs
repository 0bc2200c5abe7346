//! Expressions of the scene with their names resolved.

use super::{Class, DiscreteId, InputId, ParameterId, StateId, Variable};
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
    /// A discrete variable.
    Discrete(DiscreteId),
    /// A state of the scene.
    State(StateId),
    /// A variable of the naming table.
    Variable(Variable),
    /// -a, a + b, f(a), f(a, b)
    Call(Function, Vec<Formula>),
    /// if(left op right, then, otherwise)
    If(Comparison, Box<[Formula; 4]>),
}

impl Formula {
    /// What it is made of, from left to right.
    pub fn parts(&self) -> &[Formula] {
        match self {
            Formula::Call(_, arguments) => arguments,
            Formula::If(_, parts) => &parts[..],
            _ => &[],
        }
    }

    /// The same, to be changed.
    pub fn parts_mut(&mut self) -> &mut [Formula] {
        match self {
            Formula::Call(_, arguments) => arguments,
            Formula::If(_, parts) => &mut parts[..],
            _ => &mut [],
        }
    }

    /// Calls `visit` with the formula and with everything in it, from left to right.
    pub fn visit(&self, visit: &mut dyn FnMut(&Formula)) {
        visit(self);
        self.parts().iter().for_each(|part| part.visit(visit));
    }

    /// How many numbers, names and functions it has.
    pub fn operations(&self) -> usize {
        let mut count = 0;
        self.visit(&mut |_| count += 1);
        count
    }

    /// How many of them lie within each other.
    pub fn depth(&self) -> usize {
        1 + self.parts().iter().map(Formula::depth).max().unwrap_or(0)
    }

    /// True if it reads accelerations or reactions, which follow from the equations of motion; forces of loads are laws.
    pub fn reads_the_motion(&self) -> bool {
        let mut reads = false;
        self.visit(&mut |part| {
            if let Formula::Variable(variable) = part {
                reads |= match variable.quantity.class() {
                    Class::Acceleration => true,
                    Class::Effort => !variable.owner.is_load(),
                    Class::Position | Class::Velocity | Class::State | Class::Contact | Class::System => false,
                };
            }
        });
        reads
    }

    /// True if it may change in a run: it reads more than numbers and parameters.
    pub fn varies(&self) -> bool {
        let mut varies = false;
        self.visit(&mut |part| {
            varies |= match part {
                Formula::Number(_) | Formula::Parameter(_) | Formula::Call(..) | Formula::If(..) => false,
                Formula::Time | Formula::Input(_) | Formula::Discrete(_) | Formula::State(_) | Formula::Variable(_) => {
                    true
                }
            };
        });
        varies
    }

    /// Calls `visit` with every parameter that occurs.
    pub fn visit_parameters(&self, visit: &mut dyn FnMut(ParameterId)) {
        self.visit(&mut |part| {
            if let Formula::Parameter(id) = part {
                visit(*id);
            }
        });
    }
}

/// < <= > >=
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
}
