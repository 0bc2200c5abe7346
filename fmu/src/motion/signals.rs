//! Parameters and inputs of a run: where they continue from, and whether they have changed.

use serde::{Deserialize, Serialize};

use crate::model::{Model, State};

/// Inputs are polynomials of time about the last state at which anything changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Signals {
    /// The last state at which parameters, inputs or their derivatives changed; signals continue from here.
    pub origin: State,
    /// The state before the first change at this communication point.
    pub before: State,
    /// Has anything changed at this communication point?
    pub changed: bool,
    /// Had anything changed at the last one?
    pub changed_before: bool,
}

impl Signals {
    pub fn new(state: &State) -> Self {
        Self { origin: state.clone(), before: state.clone(), changed: false, changed_before: false }
    }

    /// To be called before an input or parameter of the state changes.
    pub fn change(&mut self, state: &State) {
        if !self.changed {
            self.changed = true;
            self.before.copy_from(state);
        }
    }

    /// The communication point has been passed.
    pub fn pass(&mut self) {
        self.changed_before = self.changed;
        self.changed = false;
    }

    pub fn copy_from(&mut self, other: &Self) {
        self.origin.copy_from(&other.origin);
        self.before.copy_from(&other.before);
        (self.changed, self.changed_before) = (other.changed, other.changed_before);
    }

    pub fn belongs_to(&self, model: &Model) -> bool {
        [&self.origin, &self.before].into_iter().all(|state| state.belongs_to(model) && state.is_finite())
    }
}
