//! What the parts of a run work on together: the model, its machine, the settings, the counters.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::constraints::projection::Projection;
use crate::failure::Failure;
use crate::machine::Machine;
use crate::model::Model;
use crate::program::Engine;

/// How to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The method that takes the steps.
    pub engine: Engine,
    /// May the run change to the implicit method while the motion is stiff?
    pub automatic: bool,
    /// Relative tolerance on what the user sees.
    pub tolerance: f64,
    /// Rates below so many scales a second do not count relative to themselves: [`Model::least_rate`] [1/s].
    pub least_rate: f64,
    /// Longest step [s].
    pub max_step: f64,
    /// Nothing is evaluated after this time [s].
    pub stop: Option<f64>,
    /// Most work of one communication step, in instructions of tapes.
    pub most_work: u64,
    /// When the computer must be done.
    pub deadline: Option<Deadline>,
}

/// An end of patience.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deadline {
    at: Instant,
    /// How long it was from the beginning [s].
    budget: f64,
}

impl Deadline {
    /// So many seconds from now; none if that is for ever.
    pub fn after(budget: f64) -> Option<Self> {
        let patience = Duration::try_from_secs_f64(budget).ok()?;
        Some(Self { at: Instant::now().checked_add(patience)?, budget })
    }
}

/// Asked before every step, in the thread that takes it.
static LISTENER: OnceLock<fn() -> bool> = OnceLock::new();

/// Before every step of any motion in this process the listener is asked, in the thread that takes the step, whether the motion is to end. Only the first listener counts.
pub fn listen(listener: fn() -> bool) {
    LISTENER.get_or_init(|| listener);
}

/// Does whoever waits want the computation to end? For searches that solve many times: each solution ends by itself, and the search ends here.
pub fn is_interrupted() -> bool {
    LISTENER.get().is_some_and(|wants_end| wants_end())
}

impl Settings {
    /// Has the user named the method? By itself the program takes series, or may change to another method.
    pub(crate) fn is_named(&self) -> bool {
        !self.automatic && self.engine != Engine::Taylor
    }

    /// No step goes beyond this time, if the communication point does not [s].
    pub(crate) fn limit(&self) -> f64 {
        self.stop.unwrap_or(f64::INFINITY)
    }

    /// Fails when the time that the computer may take is over, or whoever waits wants the motion to end; `time` is that of the motion.
    pub(crate) fn check_patience(&self, time: f64) -> Result<(), Failure> {
        if is_interrupted() {
            return Err(Failure::Interrupted { time });
        }
        match self.deadline {
            Some(Deadline { at, budget }) if Instant::now() > at => Err(Failure::OutOfTime { time, budget }),
            _ => Ok(()),
        }
    }
}

/// What the solver has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Evaluations of the accelerations, or series of the motion.
    pub evaluations: u64,
    /// Factorisations of the implicit method; each is of a real and of a complex matrix.
    pub factorisations: u64,
    /// Jacobians of the accelerations.
    pub jacobians: u64,
    /// Projections that moved the state.
    pub projections: u64,
    /// Steps of the explicit method where there was no Taylor series.
    pub fallbacks: u64,
    /// About how much work all attempts at steps were, in instructions of tapes.
    pub work: u64,
}

/// What the parts of the solver work on together.
pub(crate) struct Context<'a> {
    pub(crate) model: &'a Model,
    pub(crate) machine: &'a mut Machine,
    pub(crate) projection: &'a mut Projection,
    pub(crate) statistics: &'a mut Statistics,
    pub(crate) settings: &'a Settings,
}
