//! What the equations of motion determine: the coordinates of the mechanism, then the states of the scene, each as the rate of its integral. Integrators want
//! one list of both; which of them an entry is, is decided here only.

use std::ops::Range;

use super::Equations;
use crate::expr::{Order, Symbol};

/// An entry of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionVariable {
    /// Of [`Equations::coordinates`], by its index.
    Coordinate(usize),
    /// Of [`Equations::states`], by its index.
    State(usize),
}

impl MotionVariable {
    /// Its value, its rate or its acceleration as a symbol of the equations. Nothing depends on the integral of a state.
    pub fn symbol(self, order: Order) -> Symbol {
        match (self, order) {
            (Self::Coordinate(index), order) => Symbol::Coordinate(index, order),
            (Self::State(_), Order::Position) => Symbol::Argument,
            (Self::State(state), Order::Velocity) => Symbol::State(state, Order::Position),
            (Self::State(state), Order::Acceleration) => Symbol::State(state, Order::Velocity),
        }
    }
}

/// How the list is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionLayout {
    coordinates: usize,
    states: usize,
}

impl MotionLayout {
    /// The length of the list.
    pub fn count(self) -> usize {
        self.coordinates + self.states
    }

    /// The indices of the coordinates of the mechanism.
    pub fn coordinates(self) -> Range<usize> {
        0..self.coordinates
    }

    /// The indices of the states.
    pub fn states(self) -> Range<usize> {
        self.coordinates..self.count()
    }

    /// The index of a state.
    pub fn state(self, state: usize) -> usize {
        self.coordinates + state
    }

    pub fn variable(self, index: usize) -> MotionVariable {
        index.checked_sub(self.coordinates).map_or(MotionVariable::Coordinate(index), MotionVariable::State)
    }
}

impl Equations {
    pub fn motion_layout(&self) -> MotionLayout {
        MotionLayout { coordinates: self.coordinates.len(), states: self.states.len() }
    }
}
