//! What the methods remember of a run between its steps, each its own.

use serde::{Deserialize, Serialize};

use super::explicit::Explicit;
use super::implicit;
use super::stiffness::Choice;
use super::taylor::{self, Taylor};
use crate::model::Model;

/// Together with the state and the [`Run`](crate::motion::Run) it determines the rest of the run bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    pub(super) taylor: taylor::TaylorMemory,
    pub(super) implicit: implicit::ImplicitMemory,
    pub(super) choice: Choice,
}

impl Memory {
    /// True if the last step is one of the implicit method.
    pub fn is_implicit(&self) -> bool {
        self.implicit.is_last()
    }

    /// At the beginning of a run.
    pub fn new(model: &Model) -> Self {
        Self {
            taylor: taylor::TaylorMemory::default(),
            implicit: implicit::ImplicitMemory::new(model),
            choice: Choice::new(),
        }
    }

    /// Begins anew.
    pub fn start(&mut self) {
        self.forget();
        self.choice = Choice::new();
    }

    /// The run goes on differently than its last step.
    pub fn forget(&mut self) {
        self.taylor = taylor::TaylorMemory::default();
        self.implicit.forget();
    }

    /// Does the implicit method take the next step, whatever method the run began with?
    pub(crate) fn is_stiff(&self) -> bool {
        self.choice.is_stiff()
    }

    /// Does a law change over to another smooth branch at the end of the last step?
    pub(crate) fn switches(&self) -> bool {
        self.taylor.branches.known != 0
    }

    /// Copies that of another run of the same model without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.taylor = other.taylor;
        self.implicit.copy_from(&other.implicit);
        self.choice = other.choice;
    }

    /// Is this one of that model, with nothing in it that a run would not write?
    pub fn belongs_to(&self, model: &Model) -> bool {
        self.implicit.belongs_to(model) && self.choice.is_sound()
    }
}

/// Room for the dense output of any method.
pub fn room(model: &Model) -> usize {
    let explicit = Explicit::dense_length(model);
    if model.program().arms.is_some() { explicit.max(Taylor::dense_length(model)) } else { explicit }
}
