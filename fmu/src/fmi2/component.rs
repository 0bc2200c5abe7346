//! The state machines of FMI 2.0, for Co-Simulation and for Model Exchange, over one instance.

use super::logging::{Category, Logger};
use super::types::{fmi2Status, fmi2StatusKind};
use crate::instance::{DERIVATIVE_ORDER, Instance, InstanceError, Snapshot, number};
use crate::program::seal::Mark;

/// How far a communication point may be from the time reached, relative to the step.
const OFFSET: f64 = 1e-3;
/// The same, in units of the rounding of times.
const ROUNDING: f64 = 64.0;

/// Longest communication step [s]: thirty years. More is a mistake of the importer, and would take for ever.
const LONGEST: f64 = 1e9;

/// Modes of the standard's state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    Instantiated,
    Initialization,
    /// Co-Simulation only.
    StepComplete,
    Terminated,
    /// Model Exchange only.
    Event,
    /// Model Exchange only.
    ContinuousTime,
}

/// Modes in which values can be read.
const READABLE: [Mode; 5] =
    [Mode::Initialization, Mode::StepComplete, Mode::Event, Mode::ContinuousTime, Mode::Terminated];

/// Who integrates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interface {
    ModelExchange,
    CoSimulation,
}

/// Why a call is refused.
#[derive(Debug)]
pub struct Refusal {
    pub reason: String,
    /// Nothing is broken: other values will do (2.1.3 of the standard)?
    discards: bool,
}

impl Refusal {
    pub fn new(reason: String) -> Self {
        Self { reason, discards: false }
    }

    /// What the importer may try again with other values.
    fn discard(reason: String) -> Self {
        Self { reason, discards: true }
    }

    pub fn status(&self) -> fmi2Status {
        if self.discards { fmi2Status::fmi2Discard } else { fmi2Status::fmi2Error }
    }
}

impl From<InstanceError> for Refusal {
    fn from(error: InstanceError) -> Self {
        let discards = matches!(error, InstanceError::OutOfRange { .. });
        Self { reason: error.to_string(), discards }
    }
}

impl From<&str> for Refusal {
    fn from(reason: &str) -> Self {
        Self::new(reason.to_owned())
    }
}

type Outcome<T = ()> = Result<T, Refusal>;

/// What an importer holds.
pub struct Component {
    pub logger: Logger,
    interface: Interface,
    mode: Mode,
    /// Has the experiment been set up since instantiation or reset?
    set_up: bool,
    instance: Instance,
}

/// What `fmi2GetFMUstate` hands out.
#[derive(Clone)]
pub struct SavedState {
    interface: Interface,
    mode: Mode,
    set_up: bool,
    snapshot: Snapshot,
}

impl Component {
    pub fn new(logger: Logger, interface: Interface, instance: Instance) -> Self {
        Self { logger, interface, mode: Mode::Instantiated, set_up: false, instance }
    }

    pub fn refuse(&self, reason: &Refusal) {
        self.logger.log(reason.status(), Category::Errors, &reason.reason);
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
            Mode::Event => "in event mode",
            Mode::ContinuousTime => "in continuous-time mode",
        };
        Err(Refusal::new(format!("{call} is not allowed {now}")))
    }

    /// What an integrator outside tries may lie where the model has no value: it may try again, with a shorter step.
    fn trial<T>(&self, result: Result<T, InstanceError>) -> Outcome<T> {
        result.map_err(|error| match self.interface {
            Interface::ModelExchange if error.is_numerical() => {
                Refusal::discard(format!("{error}; in Model Exchange a shorter step may help"))
            }
            _ => error.into(),
        })
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
        self.mode = match self.interface {
            Interface::CoSimulation => {
                self.instance.initialise()?;
                Mode::StepComplete
            }
            Interface::ModelExchange => {
                self.instance.initialise_exchange()?;
                Mode::Event
            }
        };
        self.event(|| format!("initialised at t = {} s", self.instance.time()));
        Ok(())
    }

    pub fn terminate(&mut self) -> Outcome {
        self.allow("fmi2Terminate", &[Mode::StepComplete, Mode::Event, Mode::ContinuousTime])?;
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
        self.allow("fmi2GetReal", &READABLE)?;
        for (value, &reference) in values.iter_mut().zip(references) {
            let found = self.instance.get(reference as usize);
            *value = self.trial(found)?;
        }
        Ok(())
    }

    /// All values or none.
    pub fn set(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        let modes = [Mode::Instantiated, Mode::Initialization, Mode::StepComplete, Mode::Event, Mode::ContinuousTime];
        self.allow("fmi2SetReal", &modes)?;
        for (&value, &reference) in values.iter().zip(references) {
            self.instance.check_set(reference as usize, value)?;
            if self.mode == Mode::ContinuousTime && !self.instance.is_input(reference as usize) {
                return Err("parameters change in event mode only".into());
            }
        }
        for (&value, &reference) in values.iter().zip(references) {
            self.instance.set(reference as usize, value)?;
        }
        Ok(())
    }

    /// All derivatives or none.
    pub fn set_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Outcome {
        let modes = [Mode::Instantiated, Mode::Initialization, Mode::StepComplete];
        self.allow_only(Interface::CoSimulation, "fmi2SetRealInputDerivatives", &modes)?;
        let all = || references.iter().zip(orders).zip(values);
        for ((&reference, &order), &value) in all() {
            self.instance.check_set_derivative(reference as usize, order, value)?;
        }
        for ((&reference, &order), &value) in all() {
            self.instance.set_derivative(reference as usize, order, value)?;
        }
        Ok(())
    }

    /// Derivatives along a direction of what can be set and of the states.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        derivatives: &mut [f64],
        knowns: &[u32],
        direction: &[f64],
    ) -> Outcome {
        self.allow("fmi2GetDirectionalDerivative", &READABLE)?;
        self.instance.begin_direction();
        for (&reference, &change) in knowns.iter().zip(direction) {
            self.instance.add_direction(reference as usize, change)?;
        }
        let differentiated = self.instance.differentiate();
        self.trial(differentiated)?;
        for (derivative, &reference) in derivatives.iter_mut().zip(unknowns) {
            let found = self.instance.derivative(reference as usize);
            *derivative = self.trial(found)?;
        }
        Ok(())
    }

    /// Derivatives of calculated variables by time.
    pub fn output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Outcome {
        let modes = [Mode::StepComplete, Mode::Terminated];
        self.allow_only(Interface::CoSimulation, "fmi2GetRealOutputDerivatives", &modes)?;
        if let Some(order) = orders.iter().find(|order| !(1..=DERIVATIVE_ORDER).contains(*order)) {
            let reason =
                format!("derivatives of order {order} are not provided, only of orders 1 to {DERIVATIVE_ORDER}");
            return Err(Refusal::new(reason));
        }
        let Some(&highest) = orders.iter().max() else { return Ok(()) };
        self.instance.differentiate_motion(highest)?;
        for ((value, &reference), &order) in values.iter_mut().zip(references).zip(orders) {
            *value = self.instance.motion_derivative(reference as usize, order)?;
        }
        Ok(())
    }

    pub fn set_time(&mut self, time: f64) -> Outcome {
        self.allow("fmi2SetTime", &[Mode::Event, Mode::ContinuousTime])?;
        Ok(self.instance.set_time(time)?)
    }

    pub fn set_states(&mut self, states: &[f64]) -> Outcome {
        self.allow("fmi2SetContinuousStates", &[Mode::ContinuousTime])?;
        let set = self.instance.set_states(states);
        self.trial(set)
    }

    pub fn states(&mut self, states: &mut [f64]) -> Outcome {
        self.allow_only(Interface::ModelExchange, "fmi2GetContinuousStates", &READABLE)?;
        Ok(self.instance.states(states)?)
    }

    pub fn state_derivatives(&mut self, derivatives: &mut [f64]) -> Outcome {
        self.allow_only(Interface::ModelExchange, "fmi2GetDerivatives", &READABLE)?;
        let found = self.instance.state_derivatives(derivatives);
        self.trial(found)
    }

    pub fn indicators(&mut self, indicators: &mut [f64]) -> Outcome {
        self.allow_only(Interface::ModelExchange, "fmi2GetEventIndicators", &READABLE)?;
        let found = self.instance.indicators(indicators);
        self.trial(found)
    }

    pub fn nominals(&mut self, nominals: &mut [f64]) -> Outcome {
        self.allow_only(Interface::ModelExchange, "fmi2GetNominalsOfContinuousStates", &MODES)?;
        Ok(self.instance.nominals(nominals)?)
    }

    /// For calls whose modes alone do not tell the interface.
    fn allow_only(&self, interface: Interface, call: &str, modes: &[Mode]) -> Outcome {
        match (interface, self.interface == interface) {
            (_, true) => self.allow(call, modes),
            (Interface::ModelExchange, false) => Err(Refusal::new(format!("{call} is for Model Exchange only"))),
            (Interface::CoSimulation, false) => Err(Refusal::new(format!("{call} is for Co-Simulation only"))),
        }
    }

    pub fn enter_event_mode(&mut self) -> Outcome {
        self.allow("fmi2EnterEventMode", &[Mode::ContinuousTime])?;
        self.mode = Mode::Event;
        Ok(())
    }

    /// Says whether the states have changed.
    pub fn new_discrete_states(&mut self) -> Outcome<bool> {
        self.allow("fmi2NewDiscreteStates", &[Mode::Event])?;
        Ok(self.instance.close_loops()?)
    }

    pub fn enter_continuous_time_mode(&mut self) -> Outcome {
        self.allow("fmi2EnterContinuousTimeMode", &[Mode::Event])?;
        self.mode = Mode::ContinuousTime;
        Ok(())
    }

    /// Says whether the importer should enter event mode.
    pub fn completed_integrator_step(&mut self) -> Outcome<bool> {
        self.allow("fmi2CompletedIntegratorStep", &[Mode::ContinuousTime])?;
        Ok(self.instance.complete_step()?)
    }

    /// The usual step: from the very time reached, along what is known of the motion. False if there is more to it.
    #[inline]
    pub fn glide(&mut self, point: f64, step: f64) -> bool {
        let usual = (point - self.instance.time()).abs() <= OFFSET * step && step > 0.0 && step <= LONGEST;
        usual && self.mode == Mode::StepComplete && self.instance.glide(point + step)
    }

    pub fn do_step(&mut self, point: f64, step: f64) -> Outcome {
        self.allow("fmi2DoStep", &[Mode::StepComplete])?;
        if !(point.is_finite() && step > 0.0 && step <= LONGEST) {
            let (step, point, most) = (number(step), number(point), number(LONGEST));
            let why = format!("it must be longer than zero and at most {most} s");
            return Err(Refusal::new(format!("a step of {step} s from t = {point} s is impossible: {why}")));
        }
        let time = self.instance.time();
        if (point - time).abs() > OFFSET * step + ROUNDING * f64::EPSILON * time.abs() {
            let (point, time) = (number(point), number(time));
            return Err(Refusal::new(format!(
                "the step starts at t = {point} s, but the simulation is at t = {time} s"
            )));
        }
        let done = self.instance.step_to(point + step);
        for passage in self.instance.take_passages() {
            self.logger.log(fmi2Status::fmi2OK, Category::Events, &passage.to_string());
        }
        Ok(done?)
    }

    /// The last communication point reached, if that is what is asked for.
    pub fn real_status(&self, kind: fmi2StatusKind) -> Option<f64> {
        let known = kind == super::types::fmi2LastSuccessfulTime && self.mode != Mode::Instantiated;
        known.then(|| self.instance.time())
    }

    pub fn save(&mut self) -> SavedState {
        let Self { interface, mode, set_up, .. } = *self;
        SavedState { interface, mode, set_up, snapshot: self.instance.save() }
    }

    pub fn save_into(&mut self, state: &mut SavedState) {
        (state.interface, state.mode, state.set_up) = (self.interface, self.mode, self.set_up);
        self.instance.save_into(&mut state.snapshot);
    }

    pub fn restore(&mut self, state: &SavedState) -> Outcome {
        if state.interface != self.interface {
            return Err("the state was saved by an instance of the other interface".into());
        }
        self.instance.restore(&state.snapshot)?;
        (self.mode, self.set_up) = (state.mode, state.set_up);
        Ok(())
    }

    pub fn deserialize(&self, bytes: &[u8]) -> Outcome<SavedState> {
        let changed = || Refusal::from("the saved state has been changed");
        let content =
            MARK.open(bytes).map_err(|error| Refusal::new(format!("the saved state cannot be read: {error}")))?;
        let (&[interface, mode, set_up], rest) = content.split_first_chunk::<3>().ok_or_else(changed)?;
        let interface = INTERFACES.into_iter().find(|known| *known as u8 == interface).ok_or_else(changed)?;
        let mode = MODES.into_iter().find(|known| *known as u8 == mode).ok_or_else(changed)?;
        let snapshot = Snapshot::from_bytes(self.instance.model(), rest)?;
        let state = SavedState { interface, mode, set_up: set_up != 0, snapshot };
        if set_up <= 1 && state.is_sound() { Ok(state) } else { Err(changed()) }
    }
}

const MARK: Mark = Mark { magic: *b"cotI", name: "a saved state of a cotree FMU" };
const INTERFACES: [Interface; 2] = [Interface::ModelExchange, Interface::CoSimulation];
const MODES: [Mode; 6] =
    [Mode::Instantiated, Mode::Initialization, Mode::StepComplete, Mode::Terminated, Mode::Event, Mode::ContinuousTime];

impl SavedState {
    /// Does the mode fit the rest?
    fn is_sound(&self) -> bool {
        let running = !matches!(self.mode, Mode::Instantiated | Mode::Initialization);
        let exchange = match self.mode {
            Mode::Event | Mode::ContinuousTime => true,
            Mode::StepComplete => false,
            _ => self.interface == Interface::ModelExchange,
        };
        exchange == (self.interface == Interface::ModelExchange)
            && self.snapshot.is_running() == running
            && self.snapshot.is_exchange() == (running && exchange)
            && (self.set_up || self.mode == Mode::Instantiated)
    }

    /// The interface, the mode, whether the experiment is set up, the snapshot.
    pub fn to_bytes(&self) -> Outcome<Vec<u8>> {
        let mut bytes = vec![self.interface as u8, self.mode as u8, u8::from(self.set_up)];
        bytes.extend(self.snapshot.to_bytes()?);
        Ok(MARK.seal(&bytes))
    }
}
