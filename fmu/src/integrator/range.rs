//! The range over a step of how close the loop equations come to depending on each other.

use super::right_hand_side::{Derivative, RightHandSide};
use crate::constraints::reciprocals::{is_jump, read};
use crate::linalg::lane::Lane;
use crate::machine::{Machine, ROUNDING};
use crate::math;
use crate::model::Model;

/// The range of 1 / r^2 of each loop equation over a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Range {
    start: Vec<f64>,
    end: Vec<f64>,
    least: Vec<f64>,
    most: Vec<f64>,
}

impl Range {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let rows = || vec![0.0; model.program().tapes.reciprocal_pivots.len()];
        Self { start: rows(), end: rows(), least: rows(), most: rows() }
    }

    /// A step begins where the accelerations have just been evaluated.
    pub fn begin(&mut self, model: &Model, machine: &Machine) {
        read(model, machine, &mut self.start);
    }

    /// Where the step begins.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// Before another attempt from the same start.
    pub fn restart(&mut self) {
        self.least.copy_from_slice(&self.start);
        self.most.copy_from_slice(&self.start);
    }

    /// The end of the step, which was the last to be noted, becomes the start of the next one.
    pub fn roll(&mut self) {
        self.start.copy_from_slice(&self.end);
    }

    /// Does no loop equation come so much closer to the others, or go so much further from them, that there could be a singular pose in the step?
    pub fn is_steady(&self) -> bool {
        // What is no number makes the largest none.
        let largest = self.most.iter().fold(0.0, |largest, most| math::maximum(largest, *most));
        let rows = self.least.iter().zip(&self.most);
        largest.is_finite()
            // 1 / r^2 of a body without mass is nothing but rounding errors (a four-bar with a massless coupler: 1e-16).
            && rows.into_iter().all(|(least, most)| *most <= ROUNDING * largest || !is_jump(*least, *most))
    }

    /// Takes note of the nodes of a step, whose registers lie side by side.
    pub fn note_nodes(&mut self, model: &Model, nodes: &[Lane]) {
        for (row, &register) in model.program().tapes.reciprocal_pivots.iter().enumerate() {
            for value in nodes[register as usize].map(f64::abs) {
                self.least[row] = math::minimum(self.least[row], value);
                self.most[row] = math::maximum(self.most[row], value);
            }
        }
    }

    fn note(&mut self, model: &Model, machine: &Machine) {
        read(model, machine, &mut self.end);
        for ((least, most), value) in self.least.iter_mut().zip(&mut self.most).zip(&self.end) {
            *least = math::minimum(*least, *value);
            *most = math::maximum(*most, *value);
        }
    }
}

/// (q, v)' at the stages of a step, with the range of 1 / r^2 there.
pub(crate) struct Ranged<'a> {
    motion: RightHandSide<'a>,
    range: &'a mut Range,
}

impl<'a> Ranged<'a> {
    pub fn new(motion: RightHandSide<'a>, range: &'a mut Range) -> Self {
        Self { motion, range }
    }
}

impl Derivative for Ranged<'_> {
    fn evaluate(&mut self, time: f64, y: &[f64], derivative: &mut [f64]) {
        self.motion.evaluate(time, y, derivative);
        self.range.note(self.motion.model, self.motion.machine);
    }
}
