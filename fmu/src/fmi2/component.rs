//! The state machine of FMI 2.0 for Co-Simulation, over one instance.

use super::logging::{Category, Logger};
use super::types::{fmi2Status, fmi2StatusKind};
use crate::instance::{Instance, InstanceError, Snapshot};

/// How far a communication point may be from the time reached, relative to the step.
const OFFSET: f64 = 1e-3;
/// The same, in units of the rounding of times.
const ROUNDING: f64 = 64.0;

/// Modes of the standard's state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    Instantiated,
    Initialization,
    StepComplete,
    Terminated,
}

/// Why a call is refused.
#[derive(Debug)]
pub struct Refusal(pub String);

impl From<InstanceError> for Refusal {
    fn from(error: InstanceError) -> Self {
        Self(error.to_string())
    }
}

impl From<&str> for Refusal {
    fn from(reason: &str) -> Self {
        Self(reason.to_owned())
    }
}

type Outcome<T = ()> = Result<T, Refusal>;

/// What an importer holds.
pub struct Component {
    pub logger: Logger,
    mode: Mode,
    /// Has the experiment been set up since instantiation or reset?
    set_up: bool,
    instance: Instance,
}

/// What `fmi2GetFMUstate` hands out.
#[derive(Clone)]
pub struct SavedState {
    mode: Mode,
    set_up: bool,
    snapshot: Snapshot,
}

impl Component {
    pub fn new(logger: Logger, instance: Instance) -> Self {
        Self { logger, mode: Mode::Instantiated, set_up: false, instance }
    }

    pub fn refuse(&self, reason: &Refusal) {
        self.logger.log(fmi2Status::fmi2Error, Category::Errors, &reason.0);
    }

    fn allow(&self, call: &str, modes: &[Mode]) -> Outcome {
        if modes.contains(&self.mode) {
            return Ok(());
        }
        let now = match self.mode {
            Mode::Instantiated => "before initialization mode",
            Mode::Initialization => "in initialization mode",
            Mode::StepComplete => "during the simulation",
            Mode::Terminated => "after termination",
        };
        Err(Refusal(format!("{call} is not allowed {now}")))
    }

    fn event(&self, message: impl FnOnce() -> String) {
        if self.logger.is_enabled(Category::Events) {
            self.logger.log(fmi2Status::fmi2OK, Category::Events, &message());
        }
    }

    pub fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Outcome {
        self.allow("fmi2SetupExperiment", &[Mode::Instantiated])?;
        self.instance.setup(start, stop, tolerance)?;
        self.set_up = true;
        Ok(())
    }

    pub fn enter_initialization(&mut self) -> Outcome {
        self.allow("fmi2EnterInitializationMode", &[Mode::Instantiated])?;
        if !self.set_up {
            return Err("fmi2SetupExperiment must be called before fmi2EnterInitializationMode".into());
        }
        self.mode = Mode::Initialization;
        Ok(())
    }

    pub fn exit_initialization(&mut self) -> Outcome {
        self.allow("fmi2ExitInitializationMode", &[Mode::Initialization])?;
        self.instance.initialise()?;
        self.mode = Mode::StepComplete;
        self.event(|| format!("initialised at t = {} s", self.instance.time()));
        Ok(())
    }

    pub fn terminate(&mut self) -> Outcome {
        self.allow("fmi2Terminate", &[Mode::StepComplete])?;
        self.mode = Mode::Terminated;
        self.event(|| format!("terminated at t = {} s", self.instance.time()));
        self.report();
        Ok(())
    }

    fn report(&self) {
        if self.logger.is_enabled(Category::Solver) {
            let done = self.instance.statistics();
            let message = format!(
                "{} steps, {} rejected, {} evaluations, {} projections",
                done.steps, done.rejected, done.evaluations, done.projections
            );
            self.logger.log(fmi2Status::fmi2OK, Category::Solver, &message);
        }
    }

    pub fn reset(&mut self) -> Outcome {
        self.instance.reset();
        self.mode = Mode::Instantiated;
        self.set_up = false;
        Ok(())
    }

    pub fn get(&mut self, references: &[u32], values: &mut [f64]) -> Outcome {
        self.allow("fmi2GetReal", &[Mode::Initialization, Mode::StepComplete, Mode::Terminated])?;
        for (value, &reference) in values.iter_mut().zip(references) {
            *value = self.instance.get(reference as usize)?;
        }
        Ok(())
    }

    /// All values or none.
    pub fn set(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        self.allow("fmi2SetReal", &[Mode::Instantiated, Mode::Initialization, Mode::StepComplete])?;
        for (&value, &reference) in values.iter().zip(references) {
            self.instance.check_set(reference as usize, value)?;
        }
        for (&value, &reference) in values.iter().zip(references) {
            self.instance.set(reference as usize, value)?;
        }
        Ok(())
    }

    /// All derivatives or none.
    pub fn set_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Outcome {
        let modes = [Mode::Instantiated, Mode::Initialization, Mode::StepComplete];
        self.allow("fmi2SetRealInputDerivatives", &modes)?;
        let all = || references.iter().zip(orders).zip(values);
        for ((&reference, &order), &value) in all() {
            self.instance.check_set_derivative(reference as usize, order, value)?;
        }
        for ((&reference, &order), &value) in all() {
            self.instance.set_derivative(reference as usize, order, value)?;
        }
        Ok(())
    }

    pub fn do_step(&mut self, point: f64, step: f64) -> Outcome {
        self.allow("fmi2DoStep", &[Mode::StepComplete])?;
        if !(point.is_finite() && step.is_finite() && step > 0.0) {
            return Err(Refusal(format!("a step of {step} s from t = {point} s is impossible")));
        }
        let time = self.instance.time();
        if (point - time).abs() > OFFSET * step + ROUNDING * f64::EPSILON * time.abs() {
            return Err(Refusal(format!("the step starts at t = {point} s, but the simulation is at t = {time} s")));
        }
        self.instance.step_to(point + step)?;
        Ok(())
    }

    /// The last communication point reached, if that is what is asked for.
    pub fn real_status(&self, kind: fmi2StatusKind) -> Option<f64> {
        let known = kind == super::types::fmi2LastSuccessfulTime && self.mode != Mode::Instantiated;
        known.then(|| self.instance.time())
    }

    pub fn save(&self) -> SavedState {
        SavedState { mode: self.mode, set_up: self.set_up, snapshot: self.instance.save() }
    }

    pub fn save_into(&self, state: &mut SavedState) {
        (state.mode, state.set_up) = (self.mode, self.set_up);
        self.instance.save_into(&mut state.snapshot);
    }

    pub fn restore(&mut self, state: &SavedState) -> Outcome {
        self.instance.restore(&state.snapshot)?;
        (self.mode, self.set_up) = (state.mode, state.set_up);
        Ok(())
    }

    pub fn deserialize(&self, bytes: &[u8]) -> Outcome<SavedState> {
        let truncated = || Refusal::from("the saved state is incomplete");
        let (&[mode, set_up], rest) = bytes.split_first_chunk::<2>().ok_or_else(truncated)?;
        let mode = match mode {
            0 => Mode::Instantiated,
            1 => Mode::Initialization,
            2 => Mode::StepComplete,
            3 => Mode::Terminated,
            _ => return Err("the saved state has been changed".into()),
        };
        let snapshot = Snapshot::from_bytes(self.instance.model(), rest)?;
        let running = matches!(mode, Mode::StepComplete | Mode::Terminated);
        if set_up > 1 || snapshot.is_running() != running || (mode != Mode::Instantiated && set_up == 0) {
            return Err("the saved state has been changed".into());
        }
        Ok(SavedState { mode, set_up: set_up == 1, snapshot })
    }
}

impl SavedState {
    /// The mode, whether the experiment is set up, the snapshot.
    pub fn to_bytes(&self) -> Outcome<Vec<u8>> {
        let mut bytes = vec![self.mode as u8, u8::from(self.set_up)];
        bytes.extend(self.snapshot.to_bytes()?);
        Ok(bytes)
    }
}
