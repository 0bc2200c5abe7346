//! What belongs to which value reference: first the variables of the program, then what only this version has.

use crate::program::Program;

/// Highest order of the derivatives of an input.
pub const INPUT_ORDERS: usize = 2;

/// The numbers of things that value references are counted by.
#[derive(Clone, Copy, Debug)]
pub struct References {
    variables: usize,
    inputs: usize,
    indicators: usize,
}

/// What a value reference stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Referent {
    /// A variable of the program.
    Variable(usize),
    /// A derivative of an input of the program.
    InputDerivative {
        /// Which input.
        input: usize,
        /// From 1 to [`INPUT_ORDERS`].
        order: usize,
    },
    /// The independent variable.
    Time,
    /// An event indicator.
    Indicator(usize),
}

impl References {
    /// For so many variables of the program, inputs among them, and event indicators.
    pub fn new(variables: usize, inputs: usize, indicators: usize) -> Self {
        Self { variables, inputs, indicators }
    }

    /// Those of a program.
    pub fn of(program: &Program) -> Self {
        Self::new(program.variables.len(), program.inputs.len(), program.tapes.indicators.results.len())
    }

    /// The derivative of an input, of an order from 1 to [`INPUT_ORDERS`].
    pub fn input_derivative(&self, input: usize, order: usize) -> usize {
        self.variables + INPUT_ORDERS * input + order - 1
    }

    /// The independent variable.
    pub fn time(&self) -> usize {
        self.variables + INPUT_ORDERS * self.inputs
    }

    /// An event indicator.
    pub fn indicator(&self, index: usize) -> usize {
        self.time() + 1 + index
    }

    /// What a value reference stands for, if for anything.
    pub fn find(&self, reference: u32) -> Option<Referent> {
        let reference = reference as usize;
        if reference < self.variables {
            return Some(Referent::Variable(reference));
        }
        let further = reference - self.variables;
        if reference < self.time() {
            return Some(Referent::InputDerivative {
                input: further / INPUT_ORDERS,
                order: further % INPUT_ORDERS + 1,
            });
        }
        match reference - self.time() {
            0 => Some(Referent::Time),
            index if index <= self.indicators => Some(Referent::Indicator(index - 1)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reference_is_found_again() {
        let references = References::new(3, 2, 2);
        let derivative = |input, order| Some(Referent::InputDerivative { input, order });
        assert_eq!(references.find(2), Some(Referent::Variable(2)));
        for (input, order) in [(0, 1), (0, 2), (1, 1), (1, 2)] {
            assert_eq!(references.find(references.input_derivative(input, order) as u32), derivative(input, order));
        }
        assert_eq!(references.find(references.time() as u32), Some(Referent::Time));
        assert_eq!(references.find(references.indicator(1) as u32), Some(Referent::Indicator(1)));
        assert_eq!(references.find(references.indicator(2) as u32), None);
        assert_eq!(references.find(u32::MAX), None);
    }
}
