//! The state machines of the standard, for Co-Simulation and for Model Exchange, over one instance.

use std::collections::BTreeSet;

use super::logging::{Category, LogSeverity, Logger};
pub(crate) use crate::instance::number;
use crate::instance::{DERIVATIVE_ORDER, Handled, Instance, InstanceError, ROUNDING_OF_POINTS, Snapshot, TOLERANCES};
use crate::program::seal::Mark;

/// How far a communication point may be from the time reached, in units of the rounding of times, besides [`ROUNDING_OF_POINTS`].
const ROUNDING_OF_TIMES: f64 = 64.0;

/// Longest communication step [s]: thirty years. More is a mistake of the importer, and would take for ever.
const LONGEST_COMMUNICATION_STEP: f64 = 1e9;

/// Modes of the standard's state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    Instantiated,
    Initialization,
    /// Co-Simulation only: between steps.
    Step,
    Terminated,
    /// Model Exchange; since FMI 3.0 also Co-Simulation.
    Event,
    /// Model Exchange only.
    ContinuousTime,
    /// Co-Simulation since FMI 3.0: within a step, while the importer looks at intermediate values.
    Intermediate,
}

pub const MODES: [Mode; 7] = [
    Mode::Instantiated,
    Mode::Initialization,
    Mode::Step,
    Mode::Terminated,
    Mode::Event,
    Mode::ContinuousTime,
    Mode::Intermediate,
];
/// Modes in which the motion can be read.
pub const READABLE: [Mode; 5] = [Mode::Initialization, Mode::Step, Mode::Event, Mode::ContinuousTime, Mode::Terminated];
/// Modes in which something can be set.
const SETTABLE: [Mode; 5] = [Mode::Instantiated, Mode::Initialization, Mode::Step, Mode::Event, Mode::ContinuousTime];

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
    /// Nothing is broken: other values will do?
    pub discards: bool,
}

impl Refusal {
    pub fn new(reason: impl ToString) -> Self {
        Self { reason: reason.to_string(), discards: false }
    }

    /// What the importer may try again with other values.
    fn discard(reason: String) -> Self {
        Self { reason, discards: true }
    }
}

impl From<InstanceError> for Refusal {
    fn from(error: InstanceError) -> Self {
        let discards = error.is_without_value()
            || error.is_unfinished()
            || error.is_end()
            || matches!(error, InstanceError::OutOfRange { .. } | InstanceError::NoDerivative { .. });
        Self { reason: error.to_string(), discards }
    }
}

impl From<&str> for Refusal {
    fn from(reason: &str) -> Self {
        Self::new(reason.to_owned())
    }
}

pub type Outcome<T = ()> = Result<T, Refusal>;

/// A version of the standard: where it differs from the others in every call.
pub trait Version: Sized {
    type Status: Copy;
    const OK: Self::Status;
    const WARNING: Self::Status;
    const ERROR: Self::Status;
    /// Says which version a saved state belongs to.
    const NUMBER: u8;
    /// Modes in which variables can be read.
    const READABLE: &'static [Mode];

    /// What a refused call returns, and what becomes of the component.
    fn refuse(component: &mut FmiComponent<Self>, refusal: &Refusal) -> Self::Status;

    /// The variable of the program that a value reference stands for.
    fn variable(_component: &FmiComponent<Self>, reference: u32) -> Result<usize, InstanceError> {
        Ok(reference as usize)
    }

    /// The value of a variable.
    fn get(component: &mut FmiComponent<Self>, reference: u32) -> Result<f64, InstanceError> {
        component.instance.get(reference as usize)
    }

    /// Would [`Version::set`] accept this in the present mode?
    fn check_set(component: &FmiComponent<Self>, reference: u32, value: f64) -> Outcome {
        component.instance.check_set(reference as usize, value)?;
        component.allow_change(component.instance.is_input(reference as usize))
    }

    /// Sets a variable.
    fn set(component: &mut FmiComponent<Self>, reference: u32, value: f64) -> Result<(), InstanceError> {
        component.instance.set(reference as usize, value)
    }

    /// Adds a change of a known variable to the direction of a derivative.
    fn add_direction(component: &mut FmiComponent<Self>, reference: u32, change: f64) -> Result<(), InstanceError> {
        component.instance.add_direction(reference as usize, change)
    }
}

/// What a warning is about that is given once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Said {
    /// A variable, by its reference, has no value.
    WithoutValue(u32),
    /// An input that a driver follows jumps.
    Jump(usize),
    /// An input that a driver follows changes without derivatives while the importer integrates.
    NoRate(usize),
}

/// What an importer holds.
pub struct FmiComponent<V> {
    pub logger: Logger,
    /// The function under way, for messages.
    pub call: &'static str,
    pub interface: Interface,
    pub mode: Mode,
    /// Has the experiment been set up since instantiation or reset?
    pub set_up: bool,
    /// On the heap, where it is made: an importer's thread may have a small stack.
    pub instance: Box<Instance>,
    /// What warnings have been about.
    said: BTreeSet<Said>,
    /// What only this version knows.
    pub version: V,
}

/// What an importer that saves a state is handed.
#[derive(Clone)]
pub struct SavedState {
    version: u8,
    interface: Interface,
    mode: Mode,
    set_up: bool,
    snapshot: Snapshot,
}

impl<V: Version> FmiComponent<V> {
    pub fn new(logger: Logger, interface: Interface, version: V, instance: Box<Instance>) -> Self {
        Self {
            logger,
            call: "",
            interface,
            mode: Mode::Instantiated,
            set_up: false,
            instance,
            said: BTreeSet::new(),
            version,
        }
    }

    pub fn allow(&self, modes: &[Mode]) -> Outcome {
        if modes.contains(&self.mode) {
            return Ok(());
        }
        let now = match self.mode {
            Mode::Instantiated => "before initialization mode",
            Mode::Initialization => "in initialization mode",
            Mode::Step => "during the simulation",
            Mode::Terminated => "after termination",
            Mode::Event => "in event mode",
            Mode::ContinuousTime => "in continuous-time mode",
            Mode::Intermediate => "during an intermediate update",
        };
        Err(Refusal::new(format!("{} is not allowed {now}", self.call)))
    }

    /// Inputs change at any time, parameters not while an integrator outside is at work.
    pub fn allow_change(&self, is_input: bool) -> Outcome {
        match self.mode == Mode::ContinuousTime && !is_input {
            true => Err("parameters change in event mode only".into()),
            false => Ok(()),
        }
    }

    /// What an integrator outside tries may lie where the model has no value: it may try again, with a shorter step.
    fn trial<T>(&self, result: Result<T, InstanceError>) -> Outcome<T> {
        result.map_err(|error| match self.interface {
            Interface::ModelExchange if error.is_numerical() => {
                Refusal::discard(format!("{error}; in Model Exchange, try a shorter step"))
            }
            _ => error.into(),
        })
    }

    pub fn event(&self, message: impl FnOnce() -> String) {
        if self.logger.is_enabled(Category::Events) {
            self.logger.log(LogSeverity::Fine, Category::Events, &message());
        }
    }

    pub fn setup_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Outcome {
        self.allow(&[Mode::Instantiated])?;
        self.instance.setup(start, stop, tolerance)?;
        let used = self.instance.tolerance();
        if let Some(tolerance) = tolerance.filter(|tolerance| *tolerance != used) {
            let [finest, coarsest] = TOLERANCES;
            let message =
                format!("a tolerance of {tolerance:e} is not between {finest:e} and {coarsest}; {used:e} is used");
            self.logger.log(LogSeverity::Warning, Category::Errors, &message);
        }
        self.set_up = true;
        Ok(())
    }

    pub fn exit_initialization(&mut self) -> Outcome {
        self.allow(&[Mode::Initialization])?;
        self.mode = match self.interface {
            Interface::CoSimulation => {
                self.instance.initialise()?;
                Mode::Step
            }
            Interface::ModelExchange => {
                self.instance.initialise_exchange_with_rates()?;
                Mode::Event
            }
        };
        self.event(|| format!("initialised at t = {} s", self.instance.time()));
        Ok(())
    }

    pub fn terminate(&mut self) -> Outcome {
        self.allow(&[Mode::Step, Mode::Event, Mode::ContinuousTime])?;
        self.mode = Mode::Terminated;
        self.event(|| format!("terminated at t = {} s", self.instance.time()));
        self.report();
        Ok(())
    }

    fn report(&self) {
        if self.logger.is_enabled(Category::Solver) {
            let done = self.instance.statistics();
            let message = format!(
                "{} steps, {} rejected, {} evaluations, {} projections, about {:.1e} operations",
                done.steps, done.rejected, done.evaluations, done.projections, done.work as f64
            );
            self.logger.log(LogSeverity::Fine, Category::Solver, &message);
        }
    }

    pub fn reset(&mut self) -> Outcome {
        self.instance.reset();
        self.said.clear();
        self.mode = Mode::Instantiated;
        self.set_up = false;
        Ok(())
    }

    /// The values of variables. One that has none at this instant is not a number, and the call a warning.
    pub fn get(&mut self, references: &[u32], values: &mut [f64]) -> Outcome<V::Status> {
        self.allow(V::READABLE)?;
        let mut status = V::OK;
        for (value, &reference) in values.iter_mut().zip(references) {
            let found = V::get(self, reference);
            *value = match found {
                Err(error) if error.is_without_value() => {
                    status = V::WARNING;
                    let message = format!("{error}; it is NaN there, and the run continues");
                    self.warn_once(Said::WithoutValue(reference), &message);
                    f64::NAN
                }
                found => self.trial(found)?,
            };
        }
        Ok(status)
    }

    /// A warning that is given for the first time only.
    fn warn_once(&mut self, about: Said, message: &str) {
        if self.said.insert(about) {
            self.logger.log(LogSeverity::Warning, Category::Errors, message);
        }
    }

    /// All values or none.
    pub fn set(&mut self, references: &[u32], values: &[f64]) -> Outcome {
        self.allow(&SETTABLE)?;
        for (&value, &reference) in values.iter().zip(references) {
            V::check_set(self, reference, value)?;
        }
        for (&value, &reference) in values.iter().zip(references) {
            V::set(self, reference, value)?;
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
        self.allow(&READABLE)?;
        self.instance.begin_direction();
        for (&reference, &change) in knowns.iter().zip(direction) {
            V::add_direction(self, reference, change)?;
        }
        let differentiated = self.instance.differentiate();
        self.trial(differentiated)?;
        for (derivative, &reference) in derivatives.iter_mut().zip(unknowns) {
            let found = V::variable(self, reference).and_then(|variable| self.instance.derivative(variable));
            *derivative = self.trial(found)?;
        }
        Ok(())
    }

    /// Derivatives of calculated variables by time.
    pub fn output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Outcome {
        let modes = [Mode::Step, Mode::Terminated];
        self.allow_only(Interface::CoSimulation, &modes)?;
        if let Some(order) = orders.iter().find(|order| !(1..=DERIVATIVE_ORDER).contains(*order)) {
            let reason =
                format!("derivatives of order {order} are not provided, only of orders 1 to {DERIVATIVE_ORDER}");
            return Err(Refusal::new(reason));
        }
        let Some(&highest) = orders.iter().max() else { return Ok(()) };
        self.instance.differentiate_motion(highest)?;
        for ((value, &reference), &order) in values.iter_mut().zip(references).zip(orders) {
            let variable = V::variable(self, reference)?;
            *value = self.instance.motion_derivative(variable, order)?;
        }
        Ok(())
    }

    pub fn set_time(&mut self, time: f64) -> Outcome {
        self.allow(&[Mode::Event, Mode::ContinuousTime])?;
        Ok(self.instance.set_time(time)?)
    }

    pub fn set_states(&mut self, states: &[f64]) -> Outcome {
        self.allow(&[Mode::ContinuousTime])?;
        let set = self.instance.set_states(states);
        self.trial(set)
    }

    pub fn states(&mut self, states: &mut [f64]) -> Outcome {
        self.allow_only(Interface::ModelExchange, &READABLE)?;
        Ok(self.instance.states(states)?)
    }

    pub fn state_derivatives(&mut self, derivatives: &mut [f64]) -> Outcome {
        self.allow_only(Interface::ModelExchange, &READABLE)?;
        let found = self.instance.state_derivatives(derivatives);
        self.trial(found)
    }

    pub fn indicators(&mut self, indicators: &mut [f64]) -> Outcome {
        self.allow_only(Interface::ModelExchange, &READABLE)?;
        let found = self.instance.indicators(indicators);
        self.trial(found)
    }

    pub fn nominals(&mut self, nominals: &mut [f64]) -> Outcome {
        self.allow_only(Interface::ModelExchange, &MODES)?;
        Ok(self.instance.nominals(nominals)?)
    }

    /// For calls whose modes alone do not tell the interface.
    pub fn allow_only(&self, interface: Interface, modes: &[Mode]) -> Outcome {
        let name = match interface {
            _ if self.interface == interface => return self.allow(modes),
            Interface::ModelExchange => "Model Exchange",
            Interface::CoSimulation => "Co-Simulation",
        };
        Err(Refusal::new(format!("{} is for {name} only", self.call)))
    }

    pub fn enter_event_mode(&mut self) -> Outcome {
        self.allow(&[Mode::ContinuousTime])?;
        self.mode = Mode::Event;
        Ok(())
    }

    pub fn new_discrete_states(&mut self) -> Outcome<Handled> {
        self.allow(&[Mode::Event])?;
        let handled = self.instance.handle_event();
        self.report_events();
        Ok(handled?)
    }

    /// Reports what has happened since the last time.
    pub fn report_events(&mut self) {
        let logger = &self.logger;
        self.instance.report_events(|event, time| {
            logger.log(LogSeverity::Fine, Category::Events, &format!("event `{event}` at t = {time} s"));
        });
    }

    pub fn enter_continuous_time_mode(&mut self) -> Outcome {
        self.allow(&[Mode::Event])?;
        self.mode = Mode::ContinuousTime;
        Ok(())
    }

    /// Says whether the importer should enter event mode.
    pub fn completed_integrator_step(&mut self) -> Outcome<bool> {
        self.allow(&[Mode::ContinuousTime])?;
        if let Some(input) = self.instance.without_derivatives() {
            let name = self.instance.input_name(input);
            let message = format!(
                "input `{name}`, which a driver follows, changes, but its derivatives were never set: velocities and forces are those of a constant input; set `der({name})` and `der({name},2)` too, or use Co-Simulation"
            );
            self.warn_once(Said::NoRate(input), &message);
        }
        Ok(self.instance.complete_step()?)
    }

    /// The usual step: from the very time reached, along what is known of the motion. False if there is more to it.
    #[inline]
    pub fn interpolate(&mut self, point: f64, step: f64) -> bool {
        let usual = (point - self.instance.time()).abs() <= ROUNDING_OF_POINTS * step
            && step > 0.0
            && step <= LONGEST_COMMUNICATION_STEP;
        let allowed = usual && self.mode == Mode::Step && !self.instance.has_differences();
        allowed && self.instance.interpolate(point + step)
    }

    pub fn do_step(&mut self, point: f64, step: f64) -> Outcome {
        self.allow(&[Mode::Step])?;
        self.check_step(point, step)?;
        self.note_inputs();
        let done = self.instance.step_to(point + step);
        self.report_step();
        Ok(done?)
    }

    /// Remembers the values of inputs that drivers follow where a step begins.
    pub fn note_inputs(&mut self) {
        if let Some(input) = self.instance.note_inputs() {
            let (name, time) = (self.instance.input_name(input), self.instance.time());
            let message = format!(
                "at t = {time} s input `{name}`, which a driver follows, changes after it was constant: without derivatives this is taken as a jump, with zero rate and acceleration; set its derivatives, or a value at every communication point"
            );
            self.warn_once(Said::Jump(input), &message);
        }
    }

    /// Is this a step from the time reached?
    pub fn check_step(&self, point: f64, step: f64) -> Outcome {
        if !(point.is_finite() && step > 0.0 && step <= LONGEST_COMMUNICATION_STEP) {
            let (step, point, most) = (number(step), number(point), number(LONGEST_COMMUNICATION_STEP));
            let why = format!("it must be positive and at most {most} s");
            return Err(Refusal::new(format!("a step of {step} s from t = {point} s is impossible: {why}")));
        }
        let time = self.instance.time();
        if (point - time).abs() > ROUNDING_OF_POINTS * step + ROUNDING_OF_TIMES * f64::EPSILON * time.abs() {
            let (point, time) = (number(point), number(time));
            return Err(Refusal::new(format!(
                "the step starts at t = {point} s, but the simulation is at t = {time} s"
            )));
        }
        Ok(())
    }

    /// Reports the singular poses that the last step has passed, and why the motion may be less accurate than asked for: a warning that nobody must have
    /// asked for.
    pub fn report_step(&mut self) {
        if let Some(inaccuracy) = self.instance.take_inaccuracy() {
            self.logger.log(LogSeverity::Warning, Category::Errors, &format!("{inaccuracy}; {}", inaccuracy.help()));
        }
        self.report_events();
        for passage in self.instance.take_passages() {
            self.logger.log(LogSeverity::Fine, Category::Events, &passage.to_string());
        }
    }

    pub fn save(&mut self) -> SavedState {
        let Self { interface, mode, set_up, .. } = *self;
        SavedState { version: V::NUMBER, interface, mode, set_up, snapshot: self.instance.save() }
    }

    pub fn save_into(&mut self, state: &mut SavedState) {
        (state.version, state.interface, state.mode, state.set_up) =
            (V::NUMBER, self.interface, self.mode, self.set_up);
        self.instance.save_into(&mut state.snapshot);
    }

    pub fn restore(&mut self, state: &SavedState) -> Outcome {
        if (state.version, state.interface) != (V::NUMBER, self.interface) {
            return Err(FOREIGN.into());
        }
        self.instance.restore(&state.snapshot)?;
        (self.mode, self.set_up) = (state.mode, state.set_up);
        Ok(())
    }

    pub fn deserialize(&self, bytes: &[u8]) -> Outcome<SavedState> {
        let changed = || Refusal::from("the saved state has been changed");
        let content =
            MARK.open(bytes).map_err(|error| Refusal::new(format!("the saved state cannot be read: {error}")))?;
        let (&[version, interface, mode, set_up], rest) = content.split_first_chunk::<4>().ok_or_else(changed)?;
        if version != V::NUMBER {
            return Err(FOREIGN.into());
        }
        let interface = INTERFACES.into_iter().find(|known| *known as u8 == interface).ok_or_else(changed)?;
        let mode = MODES.into_iter().find(|known| *known as u8 == mode).ok_or_else(changed)?;
        let snapshot = Snapshot::from_bytes(self.instance.model(), rest)?;
        let state = SavedState { version, interface, mode, set_up: set_up != 0, snapshot };
        if set_up <= 1 && state.is_sound() { Ok(state) } else { Err(changed()) }
    }
}

const MARK: Mark = Mark { magic: *b"cotI", name: "a saved state of a cotree FMU" };
const FOREIGN: &str = "the state was saved by an instance of another interface or FMI version";
const INTERFACES: [Interface; 2] = [Interface::ModelExchange, Interface::CoSimulation];

impl SavedState {
    /// Does the mode fit the rest?
    fn is_sound(&self) -> bool {
        let exchange = self.interface == Interface::ModelExchange;
        let running = self.snapshot.is_running();
        let fits = match self.mode {
            Mode::Instantiated | Mode::Initialization => !running,
            Mode::Step => running && !exchange,
            Mode::Event => running,
            Mode::ContinuousTime => running && exchange,
            // A failed start ends here as well.
            Mode::Terminated => true,
            Mode::Intermediate => false,
        };
        fits && self.snapshot.is_exchange() == (running && exchange) && (self.set_up || !running)
    }

    /// The version, the interface, the mode, whether the experiment is set up, the snapshot.
    pub fn to_bytes(&self) -> Outcome<Vec<u8>> {
        let mut bytes = vec![self.version, self.interface as u8, self.mode as u8, u8::from(self.set_up)];
        bytes.extend(self.snapshot.to_bytes()?);
        Ok(MARK.seal(&bytes))
    }
}
