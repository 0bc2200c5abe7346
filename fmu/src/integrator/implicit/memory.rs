//! What the method knows from the steps before.

use serde::{Deserialize, Serialize};

use crate::model::Model;

/// What the method knows from the steps before.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ImplicitMemory {
    /// Time, q and v at which the Jacobian was evaluated.
    pub(super) anchor: Vec<f64>,
    /// Is there one?
    pub(super) anchored: bool,
    /// Does the dense output end where the step begins, with the same signals?
    pub(super) smooth: bool,
    /// Contraction of the last Newton iterations.
    pub(super) contraction: f64,
    /// Length and error of the last step; length 0 if there was none.
    pub(super) step: f64,
    pub(super) error: f64,
}

impl ImplicitMemory {
    pub fn new(model: &Model) -> Self {
        let anchor = vec![0.0; 1 + 2 * model.coordinates()];
        Self { anchor, anchored: false, smooth: false, contraction: 0.0, step: 0.0, error: 0.0 }
    }

    /// The motion goes on differently from here.
    pub fn forget(&mut self) {
        self.anchored = false;
        self.smooth = false;
        self.step = 0.0;
    }

    pub fn copy_from(&mut self, other: &Self) {
        let Self { anchor, anchored, smooth, contraction, step, error } = other;
        self.anchor.clone_from(anchor);
        (self.anchored, self.smooth) = (*anchored, *smooth);
        (self.contraction, self.step, self.error) = (*contraction, *step, *error);
    }

    pub fn belongs_to(&self, model: &Model) -> bool {
        self.anchor.len() == 1 + 2 * model.coordinates()
            && self.anchor.iter().all(|value| value.is_finite())
            && self.step >= 0.0
            && [self.contraction, self.step, self.error].into_iter().all(f64::is_finite)
    }

    /// Is the dense output that of an implicit step which is the last one?
    pub fn is_last(&self) -> bool {
        self.smooth
    }
}
