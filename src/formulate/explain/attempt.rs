//! The pose that was found of a mechanism that cannot be assembled as its scene demands.

use cotree_fmu::constraints::initial::solve_initial;
use cotree_fmu::failure::Failure;
use cotree_fmu::model::{Model, State};

use crate::equations::Equations;
use crate::formulate::{equations, typical_length};
use crate::model::Mechanism;

/// Where the bodies are when no search brings them closer together, or nearer to what is guessed.
#[derive(Debug)]
pub struct Attempt {
    /// Are the loops closed there?
    pub is_closed: bool,
    pub equations: Equations,
    pub state: State,
}

/// The best attempt, if it is the pose of which the scene demands too much.
pub fn attempt(mechanism: &Mechanism) -> Option<Attempt> {
    let mut equations = equations(mechanism, &mechanism.coordinates).ok()?;
    let length = typical_length(&mut equations);
    let model = Model::of_positions(crate::program::positions(&mut equations, length)).ok()?;
    let mut state = model.default_state(mechanism.experiment.start);
    // Its pose stays in the state.
    let failure = solve_initial(&model, &mut state).err()?;
    let is_closed = matches!(failure, Failure::OtherBranch { .. });
    let is_open = matches!(failure, Failure::LoopsOpen { .. } | Failure::Contradiction { velocity: false, .. });
    (is_closed || is_open).then_some(Attempt { is_closed, equations, state })
}
