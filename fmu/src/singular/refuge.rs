//! Where the motion was before it came near a singular pose: from there another method can take the steps again that do not pass it.

use serde::{Deserialize, Serialize};

use super::branch::{progress, sizes};
use crate::model::Model;

/// States lie at least so far apart, in units of the scales.
const APART: f64 = 0.3;

/// The last two states so far apart, since the last singular pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Refuge {
    /// So many are known.
    count: usize,
    times: [f64; 2],
    /// (q, v), the older one first.
    states: Vec<f64>,
}

impl Refuge {
    pub fn new(model: &Model) -> Self {
        Self { count: 0, times: [0.0; 2], states: vec![0.0; 2 * sizes(model).1] }
    }

    /// Nothing is known before.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Takes note of the end of a step.
    pub fn note(&mut self, model: &Model, time: f64, end: &[f64]) {
        let size = self.states.len() / 2;
        if size == 0 || self.count > 0 && progress(model, &self.states[(self.count - 1) * size..][..size], end) < APART
        {
            return;
        }
        if self.count == 2 {
            self.states.copy_within(size.., 0);
            self.times[0] = self.times[1];
        }
        self.count = usize::min(self.count + 1, 2);
        self.times[self.count - 1] = time;
        self.states[(self.count - 1) * size..][..size].copy_from_slice(end);
    }

    /// The older state, with its time.
    pub fn first(&self) -> Option<(f64, &[f64])> {
        (self.count > 0).then(|| (self.times[0], &self.states[..self.states.len() / 2]))
    }

    pub fn copy_from(&mut self, other: &Self) {
        (self.count, self.times) = (other.count, other.times);
        self.states.clone_from(&other.states);
    }

    pub fn belongs_to(&self, model: &Model) -> bool {
        self.count <= 2
            && self.states.len() == 2 * sizes(model).1
            && self.states.iter().chain(&self.times).all(|value| value.is_finite())
    }
}
