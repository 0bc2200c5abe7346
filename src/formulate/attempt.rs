//! The best attempt at a mechanism whose loops cannot be closed.

use cotree_fmu::constraints::initial::solve_initial;
use cotree_fmu::failure::Failure;
use cotree_fmu::model::{Model, State};

use super::{equations, typical_length};
use crate::equations::Equations;
use crate::lower;
use crate::mechanism::Mechanism;

/// Where the bodies are when no search brings them closer together.
#[derive(Debug)]
pub struct Attempt {
    pub equations: Equations,
    pub state: State,
}

/// The best attempt, if it is the loops that cannot be closed.
pub fn attempt(mechanism: &Mechanism) -> Option<Attempt> {
    let mut equations = equations(mechanism, &mechanism.coordinates).ok()?;
    let length = typical_length(&mut equations);
    let model = Model::of_positions(lower::positions(&mut equations, length)).ok()?;
    let mut state = model.default_state(mechanism.experiment.start);
    // Its pose stays in the state.
    let failure = solve_initial(&model, &mut state).err()?;
    matches!(failure, Failure::LoopsOpen { .. }).then_some(Attempt { equations, state })
}
