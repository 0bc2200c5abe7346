//! All that the future of an instance depends on, as a value and as bytes.

use serde::{Deserialize, Serialize};

use super::InstanceError;
use super::differences::Followed;
use super::drift::Drift;
use super::instants::Happened;
use crate::integrator::memory::{Memory, room};
use crate::integrator::stepping::beginning;
use crate::model::{Model, State};
use crate::motion::Run;
use crate::program::Engine;
use crate::program::seal::{Mark, checksum};

const MARK: Mark = Mark { magic: *b"cotS", name: "a saved cotree state" };
/// The finest and the coarsest tolerance that mean something in double precision; others are replaced by the nearer one.
pub const TOLERANCES: [f64; 2] = [1e-13, 1e-2];

/// Before or after initialisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Phase {
    /// Values may still change; is the state consistent with them?
    Initial {
        solved: bool,
    },
    Running,
    /// The importer integrates.
    Exchange,
}

/// All that the future of an instance depends on. Saving is a copy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Which model.
    pub(super) model: u64,
    pub(super) phase: Phase,
    /// Has nothing changed or moved since the start?
    pub(super) at_start: bool,
    pub(super) state: State,
    pub(super) run: Run,
    pub(super) memory: Memory,
    /// Inputs whose derivatives were set at this communication point.
    pub(super) derivatives: Vec<bool>,
    /// Inputs that drivers follow, at the last communication points.
    pub(super) followed: Vec<Followed>,
    pub(super) stop: Option<f64>,
    pub(super) tolerance: f64,
    pub(super) engine: Engine,
    pub(super) automatic: bool,
    pub(super) happened: Happened,
    /// In Model Exchange.
    pub(super) drift: Drift,
}

impl Snapshot {
    pub(super) fn new(model: &Model) -> Self {
        let experiment = &model.program().experiment;
        let state = model.default_state(experiment.start);
        let (run, memory) = beginning(model, &state);
        Self {
            model: identity(model),
            phase: Phase::Initial { solved: false },
            at_start: true,
            run,
            memory,
            state,
            derivatives: vec![false; model.program().inputs.len()],
            followed: Followed::all(model),
            stop: None,
            engine: model.program().engine,
            automatic: model.program().automatic,
            happened: Happened::new(model),
            drift: Drift::default(),
            tolerance: experiment.tolerance.clamp(TOLERANCES[0], TOLERANCES[1]),
        }
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        self.model = other.model;
        self.phase = other.phase;
        self.at_start = other.at_start;
        self.state.copy_from(&other.state);
        self.run.copy_from(&other.run);
        self.memory.copy_from(&other.memory);
        self.derivatives.clone_from(&other.derivatives);
        self.followed.clone_from(&other.followed);
        self.stop = other.stop;
        self.tolerance = other.tolerance;
        self.engine = other.engine;
        self.automatic = other.automatic;
        self.happened.copy_from(&other.happened);
        self.drift = other.drift;
    }

    /// Moves time on, if a later state is already known as a polynomial.
    pub(super) fn interpolate(&mut self, time: f64) -> bool {
        let known = self.run.interpolates(time);
        if known {
            self.state.set_time(time);
            self.at_start = false;
        }
        known
    }

    pub(super) fn belongs_to(&self, model: &Model) -> bool {
        self.model == identity(model)
            && self.state.belongs_to(model)
            && self.state.is_finite()
            && self.run.belongs_to(model, room(model))
            && self.memory.belongs_to(model)
            && self.derivatives.len() == model.program().inputs.len()
            && self.followed.len() == model.followed().len()
            && self.followed.iter().all(Followed::is_sound)
            && self.happened.belongs_to(model)
            && self.drift.is_sound()
            && self.stop.is_none_or(f64::is_finite)
            && (TOLERANCES[0]..=TOLERANCES[1]).contains(&self.tolerance)
    }

    /// Was it saved after initialisation?
    pub fn is_running(&self) -> bool {
        matches!(self.phase, Phase::Running | Phase::Exchange)
    }

    /// Was it saved while the importer integrated?
    pub fn is_exchange(&self) -> bool {
        self.phase == Phase::Exchange
    }

    /// As bytes.
    pub fn to_bytes(&self) -> Result<Vec<u8>, InstanceError> {
        let payload = postcard::to_allocvec(self).map_err(|_| InstanceError::ForeignState)?;
        Ok(MARK.seal(&payload))
    }

    /// From bytes; a state of another model is refused.
    pub fn from_bytes(model: &Model, bytes: &[u8]) -> Result<Self, InstanceError> {
        let payload = MARK.open(bytes)?;
        match postcard::take_from_bytes::<Self>(payload) {
            Ok((snapshot, [])) if snapshot.belongs_to(model) => Ok(snapshot),
            _ => Err(InstanceError::ForeignState),
        }
    }
}

/// The GUID names the content of a program.
fn identity(model: &Model) -> u64 {
    checksum(model.program().guid.as_bytes())
}
