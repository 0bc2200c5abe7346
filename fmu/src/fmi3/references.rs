//! What belongs to which value reference: first the variables of the program, then what only this version has.
//!
//! References are the places of the variables in the description, counted from 1. The standard leaves the numbers free, but some importers take those in its
//! lists of dependencies for places.

use crate::program::Program;

/// Highest order of the derivatives of an input.
pub const INPUT_ORDERS: usize = 2;

/// The reference of the variable that the description lists at a place, counted from 0.
pub fn reference(place: usize) -> usize {
    place + 1
}

/// The numbers of things that value references are counted by.
#[derive(Clone, Debug)]
pub struct References {
    variables: usize,
    /// The inputs of the program that have derivatives.
    followed: Vec<usize>,
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
    /// An event indicator.
    Indicator(usize),
    /// The independent variable.
    Time,
}

impl References {
    /// For so many variables of the program, the inputs that have derivatives, and so many event indicators.
    pub fn new(variables: usize, followed: Vec<usize>, indicators: usize) -> Self {
        Self { variables, followed, indicators }
    }

    /// Those of a program.
    pub fn of(program: &Program) -> Self {
        Self::new(program.variables.len(), program.followed_inputs(), program.indicators())
    }

    /// The derivative of an order from 1 to [`INPUT_ORDERS`] of an input: of the one at this place among those that have derivatives.
    pub fn input_derivative(&self, place: usize, order: usize) -> usize {
        reference(self.variables + INPUT_ORDERS * place + order - 1)
    }

    /// An event indicator.
    pub fn indicator(&self, index: usize) -> usize {
        self.input_derivative(self.followed.len(), 1) + index
    }

    /// The independent variable, unless it is a variable of the program.
    pub fn time(&self) -> usize {
        self.indicator(self.indicators)
    }

    /// What a value reference stands for, if for anything.
    pub fn find(&self, reference: u32) -> Option<Referent> {
        let place = (reference as usize).checked_sub(1)?;
        let Some(further) = place.checked_sub(self.variables) else { return Some(Referent::Variable(place)) };
        if let Some(&input) = self.followed.get(further / INPUT_ORDERS) {
            return Some(Referent::InputDerivative { input, order: further % INPUT_ORDERS + 1 });
        }
        match further - INPUT_ORDERS * self.followed.len() {
            index if index < self.indicators => Some(Referent::Indicator(index)),
            index => (index == self.indicators).then_some(Referent::Time),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reference_is_found_again() {
        let references = References::new(3, vec![0, 2], 2);
        let derivative = |input, order| Some(Referent::InputDerivative { input, order });
        let found: Vec<_> = (0..=11).map(|reference| references.find(reference)).collect();
        let variables = (0..3).map(|index| Some(Referent::Variable(index)));
        let inputs = [derivative(0, 1), derivative(0, 2), derivative(2, 1), derivative(2, 2)];
        let others = [Some(Referent::Indicator(0)), Some(Referent::Indicator(1)), Some(Referent::Time), None];
        assert_eq!(found, std::iter::once(None).chain(variables).chain(inputs).chain(others).collect::<Vec<_>>());
        assert_eq!(references.find(references.input_derivative(1, 2) as u32), derivative(2, 2));
        assert_eq!(references.find(references.indicator(1) as u32), Some(Referent::Indicator(1)));
        assert_eq!(references.find(references.time() as u32), Some(Referent::Time));
        assert_eq!(references.find(u32::MAX), None);
    }
}
