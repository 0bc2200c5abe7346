//! One simulation: what the command line and the FMI functions use.
//!
//! The order of calls: [`Instance::setup`], any number of [`Instance::set`], [`Instance::initialise`], then [`Instance::step_to`] again and
//! again. Values can be read as soon as setup is done; the initial state is solved for when it is first needed and again after a
//! change. A failure leaves the instance as it was: other values may be tried.

mod batch;
mod crossing;
mod derivatives;
mod differences;
mod drift;
mod error;
mod exchange;
mod inputs;
mod instants;
mod limits;
mod passage;
mod snapshot;
mod variational;

use std::f64::consts::TAU;
use std::sync::Arc;

pub(crate) use crate::failure::number;
pub use crate::integrator::accuracy::Inaccuracy;
pub use batch::Batch;
pub use crossing::Crossing;
pub use derivatives::DERIVATIVE_ORDER;
pub use error::InstanceError;
pub use instants::{Handled, Happening, Impact};
pub use passage::PassageError;
pub use snapshot::{Snapshot, TOLERANCES};
pub use variational::{Variational, Varied};

use crate::constraints::domains::{out_of_range, undefined};
use crate::constraints::expansion::Expansion;
use crate::constraints::initial::{solve_from, solve_initial};
use crate::constraints::tangent::Tangent;
use crate::context::{Deadline, Settings, Statistics};
use crate::failure::Failure;
use crate::integrator::accelerations::Accelerations;
use crate::integrator::accuracy::Accuracy;
use crate::integrator::stepping::Stepper;
use crate::machine::Machine;
use crate::math::{maximum, minimum};
use crate::model::{Model, State};
use crate::motion::Passage;
use crate::pace::MOST_WORK;
use crate::program::{Contact, Engine, Source};
use crate::singular::dependence::not_singular;
use crossing::Watch;
use instants::Instants;
use limits::{Limits, is_beside_pose};
use snapshot::Phase;

/// The tolerance of the steps of a driven mechanism: what they leave is closed to rounding errors wherever it is read. Longer steps would be as many, for they end at singular
/// poses.
const DRIVEN: f64 = 1e-6;

/// By how much communication points are off in an importer's sums of steps, relative to the step: from the time reached, and beyond the stop time.
pub(crate) const ROUNDING_OF_POINTS: f64 = 1e-3;

/// What has been computed for the present state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Computed {
    /// Is the state consistent?
    state: bool,
    accelerations: bool,
    /// Are accelerations limits beside a singular pose?
    limits: bool,
    /// Outputs, and with them those that need accelerations?
    outputs: Option<bool>,
}

/// One simulation of a model.
#[derive(Clone, Debug)]
pub struct Instance {
    model: Arc<Model>,
    now: Snapshot,
    machine: Machine,
    stepper: Stepper,
    accelerations: Accelerations,
    /// Of a driven mechanism.
    limits: Option<Box<Limits>>,
    tangent: Tangent,
    expansion: Expansion,
    /// Model Exchange only.
    watch: Watch,
    /// The pose of a driven mechanism that fits a change of time, parameters or inputs, before the change has become a step.
    shown: State,
    outputs: Vec<f64>,
    computed: Computed,
    /// Have all keys been found in their ranges with the present parameters?
    in_range: bool,
    /// Where something happens at instants.
    instants: Option<Box<Instants>>,
    /// Most work of one step, in instructions of tapes.
    most_work: u64,
    /// Has time moved on along the last step's polynomial, and the rest of the state not yet?
    behind: bool,
    /// A pose for other values, from which the first one is followed instead of being sought from the guesses.
    origin: Option<State>,
}

impl Instance {
    /// A simulation with the defaults of the program.
    pub fn new(model: Arc<Model>) -> Self {
        let (now, machine) = (Snapshot::new(&model), Machine::new(&model));
        Self {
            instants: Instants::of(&model, machine.registers().len(), &now),
            now,
            machine,
            stepper: Stepper::new(&model),
            accelerations: Accelerations::new(&model),
            limits: model.is_driven().then(|| Box::new(Limits::new(&model))),
            tangent: Tangent::new(&model),
            expansion: Expansion::default(),
            watch: Watch::default(),
            shown: model.default_state(0.0),
            outputs: vec![0.0; model.program().tapes.outputs.results.len()],
            computed: Computed::default(),
            in_range: false,
            most_work: MOST_WORK,
            behind: false,
            origin: None,
            model,
        }
    }

    /// The same on the heap. Its parts move through several frames on their way: they are not to be those of the caller.
    #[inline(never)]
    pub fn boxed(model: Arc<Model>) -> Box<Self> {
        Box::new(Self::new(model))
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Time [s].
    pub fn time(&self) -> f64 {
        self.now.state.time()
    }

    /// A copy of the state; consistent once initialised.
    pub fn state(&self) -> State {
        // Not on the fast path of a step.
        if self.behind { self.clone().save().state } else { self.now.state.clone() }
    }

    /// What the solver has done so far.
    pub fn statistics(&self) -> Statistics {
        let mut statistics = self.stepper.statistics();
        statistics.work += self.instants.as_ref().map_or(0, |instants| instants.work(self.model.program()));
        statistics
    }

    /// Permits less work for each step than usual, in the instructions of [`Statistics::work`].
    pub fn limit_work(&mut self, most: u64) {
        self.most_work = most.min(MOST_WORK);
    }

    /// Singular poses that the motion has passed since the last communication point; each is reported once.
    pub fn take_passages(&mut self) -> Vec<Passage> {
        let time = self.time();
        self.now.run.take_passages(time)
    }

    /// That rounding errors are larger than the tolerance or decide a comparison, or that a singular pose was passed as if branches met that do not; reported once. What
    /// is reported of a passage here is not reported by [`Instance::take_passages`] any more.
    pub fn take_inaccuracy(&mut self) -> Option<Inaccuracy> {
        let inexact = self.now.run.take_inexact_passages(self.now.state.time());
        let accuracy = self.stepper.accuracy();
        accuracy.note_passages(inexact);
        accuracy.take(&self.model)
    }

    /// Relative accuracy of the accelerations that rounding errors permit, the coarsest of the steps measured so far; 0 if none was.
    pub fn attainable_accuracy(&mut self) -> f64 {
        self.stepper.accuracy().attainable()
    }

    /// Index of the variable with that name.
    pub fn variable(&self, name: &str) -> Option<usize> {
        self.model.program().variables.iter().position(|variable| variable.name == name)
    }

    /// Start time, stop time if there is one, tolerance if it is not the default.
    pub fn setup(&mut self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> Result<(), InstanceError> {
        if self.is_running() {
            return Err(InstanceError::Phase { running: true });
        }
        let refuse = |reason| Err(InstanceError::Experiment { reason });
        if !start.is_finite() {
            return refuse("the start time is not finite");
        }
        if stop.is_some_and(|stop| !stop.is_finite() || stop < start) {
            return refuse("the stop time is not after the start time");
        }
        if tolerance.is_some_and(|tolerance| !(tolerance > 0.0 && tolerance.is_finite())) {
            return refuse("the tolerance is not positive");
        }
        let tolerance = tolerance.unwrap_or(self.model.program().experiment.tolerance);
        self.now.tolerance = tolerance.clamp(TOLERANCES[0], TOLERANCES[1]);
        self.now.stop = stop;
        self.now.state.registers_mut()[self.model.layout().time()] = start;
        self.invalidate();
        Ok(())
    }

    /// The tolerance of the run.
    pub fn tolerance(&self) -> f64 {
        self.now.tolerance
    }

    /// Replaces the integrator that the program names, until the next reset; the run then takes no other.
    ///
    /// # Errors
    /// After initialisation.
    pub fn set_engine(&mut self, engine: Engine) -> Result<(), InstanceError> {
        if self.now.phase == Phase::Running {
            return Err(InstanceError::Phase { running: true });
        }
        if engine == Engine::Radau {
            self.stepper.permit_implicit(&self.model);
        }
        self.now.engine = engine;
        self.now.automatic = false;
        Ok(())
    }

    /// Is it an input?
    pub fn is_input(&self, variable: usize) -> bool {
        matches!(self.settable(variable), Ok(Settable::Input(_)))
    }

    /// Would [`Instance::set`] accept this?
    pub fn check_set(&self, variable: usize, value: f64) -> Result<(), InstanceError> {
        let (name, min, max) = match self.settable(variable)? {
            Settable::Parameter(index) => {
                let parameter = &self.model.program().parameters[index];
                if self.is_running() && !parameter.tunable {
                    return Err(InstanceError::Fixed { name: parameter.name.clone() });
                }
                (&parameter.name, parameter.min, parameter.max)
            }
            Settable::Input(index) => {
                let input = &self.model.program().inputs[index];
                (&input.name, input.min, input.max)
            }
        };
        if !value.is_finite() {
            return Err(InstanceError::NotANumber { name: name.clone(), value });
        }
        if min.is_some_and(|min| value < min) || max.is_some_and(|max| value > max) {
            return Err(InstanceError::OutOfRange { name: name.clone(), value, min, max });
        }
        Ok(())
    }

    /// Sets a parameter or an input. Derivatives of an input become zero, unless they were set at this very communication point, or follow from the values before.
    pub fn set(&mut self, variable: usize, value: f64) -> Result<(), InstanceError> {
        self.check_set(variable, value)?;
        self.catch_up();
        match self.settable(variable)? {
            Settable::Parameter(index) => {
                if self.now.state.parameters()[index].to_bits() != value.to_bits() {
                    self.invalidate();
                    if self.is_running() {
                        self.now.run.change(&self.now.state);
                    }
                    self.now.state.parameters_mut()[index] = value;
                    self.in_range = false;
                }
            }
            Settable::Input(index) => {
                if !self.set_differenced(index, value) {
                    let [_, rate, acceleration] = self.kept_polynomial(index);
                    self.set_polynomial(index, [value, rate, acceleration]);
                }
            }
        }
        Ok(())
    }

    /// Would [`Instance::set_derivative`] accept this?
    pub fn check_set_derivative(&self, variable: usize, order: i32, value: f64) -> Result<(), InstanceError> {
        let name = || self.model.program().variables[variable].name.clone();
        match self.settable(variable) {
            Err(unknown @ InstanceError::UnknownVariable { .. }) => Err(unknown),
            Ok(Settable::Input(_)) if (1..=2).contains(&order) => match value.is_finite() {
                true => Ok(()),
                false => Err(InstanceError::NotANumber { name: name(), value }),
            },
            _ => Err(InstanceError::Derivative { name: name(), order }),
        }
    }

    /// Sets the first or second time derivative of an input. It holds from this communication point on, until the input is set again at
    /// a later one.
    pub fn set_derivative(&mut self, variable: usize, order: i32, value: f64) -> Result<(), InstanceError> {
        self.check_set_derivative(variable, order, value)?;
        self.catch_up();
        if let Settable::Input(index) = self.settable(variable)? {
            self.give_derivatives(index);
            let mut polynomial = self.kept_polynomial(index);
            polynomial[if order == 1 { 1 } else { 2 }] = value;
            self.now.derivatives[index] = true;
            self.set_polynomial(index, polynomial);
        }
        Ok(())
    }

    /// An input's value, and its derivatives if they were set at this communication point.
    fn kept_polynomial(&self, index: usize) -> [f64; 3] {
        let polynomial = self.now.state.input_polynomial(index);
        if self.now.derivatives[index] { polynomial } else { [polynomial[0], 0.0, 0.0] }
    }

    fn set_polynomial(&mut self, index: usize, polynomial: [f64; 3]) {
        if self.now.state.input_polynomial(index).map(f64::to_bits) != polynomial.map(f64::to_bits) {
            self.invalidate();
            self.now.state.set_input_polynomial(index, polynomial);
            self.model.follow(self.now.state.registers_mut());
        }
    }

    /// To be called before parameters, inputs or the time change.
    fn invalidate(&mut self) {
        self.computed = Computed::default();
        let driven = self.model.is_driven();
        self.now.at_start &= !self.is_running();
        match &mut self.now.phase {
            Phase::Initial { solved } => *solved = false,
            Phase::Running => self.now.run.change(&self.now.state),
            Phase::Exchange if driven => self.now.run.change(&self.now.state),
            // The importer's own integrator carries the motion on.
            Phase::Exchange => {}
        }
    }

    fn is_running(&self) -> bool {
        self.now.is_running()
    }

    /// Is the state that can be seen the one in `shown`?
    fn is_shown(&self) -> bool {
        self.is_running() && self.now.run.is_changed() && self.model.is_driven()
    }

    fn settable(&self, variable: usize) -> Result<Settable, InstanceError> {
        let found = self.model.program().variables.get(variable);
        let found = found.ok_or(InstanceError::UnknownVariable { index: variable })?;
        match (found.source, found.initial) {
            (Source::Parameter(index), _) => Ok(Settable::Parameter(index as usize)),
            (Source::Input(index), _) => Ok(Settable::Input(index as usize)),
            (_, Some(index)) => Ok(Settable::Parameter(index as usize)),
            _ => Err(InstanceError::Calculated { name: found.name.clone() }),
        }
    }

    /// The first pose is to be the one to which the change of what is set leads from this one, which is consistent for other values, whatever the guesses say.
    ///
    /// # Errors
    /// After initialisation.
    pub fn start_from(&mut self, pose: State) -> Result<(), InstanceError> {
        let Phase::Initial { solved } = &mut self.now.phase else {
            return Err(InstanceError::Phase { running: true });
        };
        *solved = false;
        self.computed = Computed::default();
        self.origin = Some(pose);
        Ok(())
    }

    /// Solves for the initial state and starts the simulation.
    pub fn initialise(&mut self) -> Result<(), InstanceError> {
        self.solve()?;
        self.now.phase = Phase::Running;
        self.now.run.start(&self.model, &self.now.state);
        self.now.memory.start();
        self.stepper.forget();
        self.begin_instants().inspect_err(|_| self.now.phase = Phase::Initial { solved: false })?;
        // The run begins anew where something happens at the start.
        let settings = self.settings();
        let run = (&mut self.now.run, &self.now.memory);
        self.stepper.prepare(&self.model, &mut self.machine, run, &settings);
        Ok(())
    }

    /// Makes the state consistent, if it is not.
    fn solve(&mut self) -> Result<(), InstanceError> {
        if self.now.phase == (Phase::Initial { solved: false }) {
            let mut state = self.now.state.clone();
            let motion = self.model.layout().followers();
            state.registers_mut()[motion..].fill(0.0);
            self.check_ranges().map_err(|failure| self.unlike_the_scene(failure))?;
            let solved = match &self.origin {
                Some(pose) => solve_from(&self.model, &mut state, pose),
                None => solve_initial(&self.model, &mut state),
            };
            solved.map_err(|failure| self.unlike_the_scene(failure))?;
            self.machine.load(&self.model, &state);
            if let Some(failure) = undefined(&self.model, &mut self.machine) {
                return Err(self.unlike_the_scene(failure));
            }
            self.begin_discrete(&mut state)?;
            self.now.state = state;
            self.now.phase = Phase::Initial { solved: true };
            self.computed = Computed::default();
        }
        Ok(())
    }

    /// Does the implicit method take the steps now?
    pub fn is_stiff(&self) -> bool {
        self.now.engine == Engine::Radau || self.now.memory.is_stiff()
    }

    /// Moves on to a later time; less far if that is more work than one step may take, which is an error: the run can go on from there.
    pub fn step_to(&mut self, time: f64) -> Result<(), InstanceError> {
        self.check_step(time)?;
        self.go_to(time)
    }

    /// May a communication step from here end at this time? Rounding errors may take its end a little behind the stop.
    pub(crate) fn check_step(&self, time: f64) -> Result<(), InstanceError> {
        let from = self.time();
        if self.now.phase != Phase::Running {
            return Err(InstanceError::Phase { running: false });
        }
        if !(time.is_finite() && time > from) {
            return Err(InstanceError::Step { from, to: time });
        }
        match self.now.stop {
            Some(stop) if time > stop + ROUNDING_OF_POINTS * (time - from) => {
                Err(InstanceError::Stop { to: time, stop })
            }
            _ => Ok(()),
        }
    }

    /// Moves on to a later time within a communication step that has been checked.
    pub(crate) fn go_to(&mut self, time: f64) -> Result<(), InstanceError> {
        if self.instants.is_some() { self.pass_instants(time, false) } else { self.advance(time) }
    }

    /// The same as long as nothing happens on the way.
    fn advance(&mut self, time: f64) -> Result<(), InstanceError> {
        let from = self.time();
        if self.follow_last_step(time) {
            return Ok(());
        }
        let settings = self.settings_of_step();
        let Snapshot { state, run, memory, .. } = &mut self.now;
        let done = self.stepper.step_to(&self.model, &mut self.machine, state, (run, memory), time, &settings);
        self.note_advance(from, done)
    }

    /// Moves time on along the last step's polynomial, if that reaches so far.
    fn follow_last_step(&mut self, time: f64) -> bool {
        self.computed = Computed::default();
        let known = self.now.interpolate(time);
        if known {
            self.behind = true;
            self.now.derivatives.fill(false);
        }
        known
    }

    /// The settings of the steps to the next communication point.
    fn settings_of_step(&self) -> Settings {
        let deadline = match &self.instants {
            Some(instants) => instants.deadline,
            None => Deadline::after(self.model.program().experiment.budget),
        };
        Settings { deadline, max_step: self.longest_step(), ..self.settings() }
    }

    /// After the steps from that time on.
    fn note_advance(&mut self, from: f64, done: Result<(), Failure>) -> Result<(), InstanceError> {
        if self.now.state.time() == from {
            return done.map_err(|failure| self.explained(failure));
        }
        self.now.at_start = false;
        self.behind = false;
        self.now.derivatives.fill(false);
        done.map_err(InstanceError::Solver)
    }

    /// Where the last step of the method ended \[s\], not before the present time: so far the motion is known.
    pub fn end_of_step(&self) -> f64 {
        self.now.run.last.end_time.max(self.time())
    }

    /// Moves on to a later time along the last step's polynomial, if that is all there is to do and nothing is to be reported; the time must be finite.
    /// What most communication points cost: a handful of comparisons, none of which can panic.
    #[inline]
    pub(crate) fn interpolate(&mut self, time: f64) -> bool {
        let quiet = self.instants.is_none();
        let allowed = quiet && time > self.time() && self.now.stop.is_none_or(|stop| time <= stop);
        let interpolated =
            allowed && self.now.phase == Phase::Running && self.now.run.has_no_report() && self.now.interpolate(time);
        if interpolated {
            self.computed = Computed::default();
            self.behind = true;
            self.now.derivatives.fill(false);
        }
        interpolated
    }

    /// Brings the state to its time, if only time has moved on.
    fn catch_up(&mut self) {
        if self.behind {
            let Snapshot { state, run, .. } = &mut self.now;
            self.stepper.catch_up(&self.model, &mut self.machine, state, run);
            self.behind = false;
        }
    }

    fn settings(&self) -> Settings {
        let moves = self.model.coordinates() > 0;
        let engine = match self.model.program().arms {
            _ if moves => self.now.engine,
            // Where there is nothing to solve for, every step is a step in time.
            Some(_) => Engine::Taylor,
            None => Engine::Dop853,
        };
        Settings {
            engine,
            automatic: self.now.automatic && moves,
            tolerance: if self.model.is_driven() { DRIVEN } else { self.now.tolerance },
            least_rate: self.model.least_rate(self.now.stop),
            max_step: self.model.program().experiment.max_step,
            stop: self.limit(),
            most_work: self.most_work,
            deadline: None,
        }
    }

    /// The longest step [s]. Events and contacts are searched for in some places of a step, and what nothing accelerates has no other limit.
    fn longest_step(&self) -> f64 {
        let program = self.model.program();
        let longest = program.experiment.max_step;
        let is_gap = |contact: &Contact| contact.slip.is_none() && !contact.of_rate;
        if program.instants.events.is_empty() && !program.instants.contacts().iter().any(is_gap) {
            return longest;
        }
        // A turn, in scales of coordinates: the places of the search are 18 degrees apart.
        minimum(longest, TAU / self.now.run.speed(&self.model))
    }

    /// No step goes beyond this time, if there is one. A communication point that rounding errors have taken behind the stop is the stop.
    fn limit(&self) -> Option<f64> {
        let instants = self.instants.as_ref();
        let tick = instants.map(|instants| instants.limit).filter(|limit| limit.is_finite());
        let stop = self.now.stop.map(|stop| instants.map_or(stop, |instants| maximum(stop, instants.target)));
        match (stop, tick) {
            (Some(stop), Some(tick)) => Some(stop.min(tick)),
            (stop, tick) => stop.or(tick),
        }
    }

    /// The value of a variable at the present time. A change of an input shows in accelerations at once; in positions and velocities from
    /// the next step on if they are states, and at once in those of a driven mechanism, which has none.
    pub fn get(&mut self, variable: usize) -> Result<f64, InstanceError> {
        let found = self.model.program().variables.get(variable);
        let found = found.ok_or(InstanceError::UnknownVariable { index: variable })?;
        let (source, imposed) = (found.source, found.initial.map(|index| index as usize));
        if let Some(parameter) = imposed.filter(|&index| self.now.at_start && self.model.is_imposed(index)) {
            // What the state adds up to may differ from it by rounding errors.
            self.reproject()?;
            return Ok(self.now.state.parameters()[parameter]);
        }
        let value = match source {
            Source::Time => return Ok(self.now.state.time()),
            Source::Parameter(index) => return Ok(self.now.state.parameters()[index as usize]),
            Source::Input(index) => {
                self.catch_up();
                return Ok(self.now.state.inputs()[index as usize]);
            }
            Source::Discrete(index) => {
                self.catch_up();
                return Ok(self.now.state.discrete()[index as usize]);
            }
            Source::Coordinate(index) => self.seen()?.positions()[index as usize],
            Source::Rate(index) => self.seen()?.rates()[index as usize],
            Source::Acceleration(index) => {
                self.accelerate()?;
                self.accelerations.accelerations()[index as usize]
            }
            Source::Output { result, accelerated } => {
                self.evaluate_outputs(accelerated)?;
                self.outputs[result as usize]
            }
        };
        if value.is_finite() { Ok(value) } else { Err(self.undefined(variable)) }
    }

    /// The same, and not a number where the variable has no value at this instant: what is only read never ends a run.
    pub fn reading(&mut self, variable: usize) -> Result<f64, InstanceError> {
        match self.get(variable) {
            Err(error) if error.is_without_value() => Ok(f64::NAN),
            found => found,
        }
    }

    /// Why a variable has no value: a law of the motion, if there is one without a value.
    fn undefined(&mut self, variable: usize) -> InstanceError {
        self.catch_up();
        self.machine.load(&self.model, &self.now.state);
        let name = self.model.program().variables[variable].name.clone();
        let undefined = InstanceError::Undefined { name, time: self.time() };
        self::undefined(&self.model, &mut self.machine).map_or(undefined, InstanceError::Solver)
    }

    /// The consistent state of the present time.
    fn seen(&mut self) -> Result<&State, InstanceError> {
        self.reproject()?;
        Ok(if self.is_shown() { &self.shown } else { &self.now.state })
    }

    fn reproject(&mut self) -> Result<(), InstanceError> {
        if self.computed.state {
            return Ok(());
        }
        self.catch_up();
        self.solve()?;
        self.check_ranges().map_err(InstanceError::Solver)?;
        if self.is_shown() {
            let settings = self.settings();
            self.shown.copy_from(&self.now.state);
            let before = self.now.run.before();
            let reprojected =
                self.stepper.reproject(&self.model, &mut self.machine, before, &mut self.shown, &settings);
            reprojected.map_err(|failure| self.explained(failure))?;
        }
        self.computed.state = true;
        Ok(())
    }

    /// Nothing is computed from parameters that give a key a value which it must not have.
    fn check_ranges(&mut self) -> Result<(), Failure> {
        if !self.in_range {
            self.machine.load_constant(&self.model, &self.now.state);
            out_of_range(&self.model, &mut self.machine).map_or(Ok(()), Err)?;
            self.in_range = true;
        }
        Ok(())
    }

    /// A failure of the solver; at the present time already, it comes from what was set here.
    fn explained(&self, failure: Failure) -> InstanceError {
        let failure = not_singular(&self.model, &self.now.run, self.settings().is_named(), failure);
        let now = matches!(failure, Failure::LockUp { time, .. } if time <= self.time());
        let jumps = if now && self.now.run.is_changed() { self.jumps() } else { Vec::new() };
        if jumps.is_empty() { InstanceError::Solver(failure) } else { InstanceError::Jump { jumps, cause: failure } }
    }

    /// A failure of the search for the start: it may come from what was set here.
    fn unlike_the_scene(&self, cause: Failure) -> InstanceError {
        let (program, state) = (self.model.program(), &self.now.state);
        let parameters =
            program.parameters.iter().map(|parameter| (&parameter.name, parameter.start)).zip(state.parameters());
        let inputs = program.inputs.iter().map(|input| (&input.name, input.start)).zip(state.inputs());
        let changed = parameters.chain(inputs).filter(|((_, start), now)| start != *now);
        let set: Vec<_> = changed.map(|((name, start), &now)| (name.clone(), start, now)).collect();
        if set.is_empty() { InstanceError::Solver(cause) } else { InstanceError::Start { set, cause } }
    }

    /// Parameters, discrete variables and inputs that have changed since the last step: name, value before, value now.
    fn jumps(&self) -> Vec<(String, f64, f64)> {
        let (before, now) = (self.now.run.before(), &self.now.state);
        let value = |state: &State, source: Source| match source {
            Source::Parameter(index) => state.parameters().get(index as usize).copied(),
            Source::Input(index) => state.inputs().get(index as usize).copied(),
            Source::Discrete(index) => state.discrete().get(index as usize).copied(),
            _ => None,
        };
        let changed = self.model.program().variables.iter().filter_map(|variable| {
            let (from, to) = (value(before, variable.source)?, value(now, variable.source)?);
            (from != to).then(|| (variable.name.clone(), from, to))
        });
        changed.collect()
    }

    /// Brings the state that can be seen into the registers. Accelerations and reactions stay there.
    fn load(&mut self) -> Result<(), InstanceError> {
        self.reproject()?;
        let seen = if self.is_shown() { &self.shown } else { &self.now.state };
        self.machine.load(&self.model, seen);
        Ok(())
    }

    fn accelerate(&mut self) -> Result<(), InstanceError> {
        if !self.computed.accelerations {
            self.load()?;
            let evaluated = self.accelerations.evaluate(&self.model, &mut self.machine);
            let beside = match &evaluated {
                Ok(()) => is_beside_pose(&self.model, &self.machine),
                Err(failure) => matches!(failure, Failure::Undetermined { .. }),
            };
            self.computed.limits = beside && self.find_limits()?;
            if !self.computed.limits {
                evaluated?;
            }
            self.computed.accelerations = true;
        }
        Ok(())
    }

    /// Finds accelerations and loads beside a singular pose as limits, if that is where the accelerations have been evaluated.
    fn find_limits(&mut self) -> Result<bool, InstanceError> {
        let Some(mut limits) = self.limits.take() else { return Ok(false) };
        let is_shown = self.is_shown();
        // After a change at the same time no motion is known that leads there.
        let moved = is_shown && self.now.run.before().time() < self.shown.time();
        let carried = if moved { self.stepper.carried().cloned() } else { None };
        let along = if is_shown { (carried.as_ref(), &self.shown) } else { (Some(&self.now.run), &self.now.state) };
        let found = limits.find(&self.model, &mut self.machine, &mut self.stepper, along);
        self.load()?;
        // What was evaluated in other places is in the registers; without a value in the pose it still is.
        _ = self.accelerations.evaluate(&self.model, &mut self.machine);
        if found {
            limits.replace(self.accelerations.accelerations_mut());
        }
        self.limits = Some(limits);
        Ok(found)
    }

    /// Evaluates outputs, with accelerations and reactions only if they are wanted.
    fn evaluate_outputs(&mut self, accelerated: bool) -> Result<(), InstanceError> {
        if self.computed.outputs < Some(accelerated) {
            if accelerated {
                self.accelerate()?;
            }
            self.load()?;
            self.machine.evaluate(&self.model.program().tapes.outputs, &mut self.outputs);
            if let Some(limits) = self.limits.as_ref().filter(|_| self.computed.limits) {
                limits.replace_outputs(&mut self.outputs);
            }
            self.computed.outputs = Some(self.computed.accelerations);
        }
        Ok(())
    }

    /// Back to the defaults, as a new instance.
    pub fn reset(&mut self) {
        self.now = Snapshot::new(&self.model);
        self.begin_life();
        *self.stepper.accuracy() = Accuracy::new(&self.model);
    }

    /// A copy of all that the future depends on.
    pub fn save(&mut self) -> Snapshot {
        self.catch_up();
        self.now.clone()
    }

    /// The same into a snapshot of the same model, without allocating.
    pub fn save_into(&mut self, snapshot: &mut Snapshot) {
        self.catch_up();
        snapshot.copy_from(&self.now);
    }

    /// Goes back (or on) to a saved state.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), InstanceError> {
        // What is in memory was saved by an instance; bytes are checked when they are read.
        if snapshot.model != self.now.model {
            return Err(InstanceError::ForeignState);
        }
        if snapshot.engine == Engine::Radau {
            self.stepper.permit_implicit(&self.model);
        }
        self.now.copy_from(snapshot);
        self.begin_life();
        if self.now.phase == Phase::Exchange && !self.model.is_driven() {
            self.watch.resume(&self.model, &self.now.state);
        }
        Ok(())
    }
}

impl Instance {
    /// The snapshot was replaced by one of another run, of which nothing else is known.
    fn begin_life(&mut self) {
        self.forget_continuation();
        // All fields are named, so that nobody adds one without deciding whether it is of one run. The first are not: the model, what is permitted, and storage that is written before it is read.
        // The next four are replaced already.
        let Self {
            model: _,
            most_work: _,
            machine: _,
            accelerations: _,
            limits: _,
            tangent: _,
            expansion: _,
            shown: _,
            outputs: _,
            now: _,
            computed: _,
            behind: _,
            stepper: _,
            instants,
            in_range,
            watch,
            origin,
        } = self;
        if let Some(instants) = instants {
            instants.forget_record(0);
        }
        (*in_range, *watch, *origin) = (false, Watch::default(), None);
    }

    /// What is known of the motion but for the snapshot is of another continuation.
    fn forget_continuation(&mut self) {
        self.computed = Computed::default();
        self.behind = false;
        self.stepper.forget();
        if let Some(instants) = &mut self.instants {
            instants.forget(&self.now.happened);
        }
    }
}

/// What can be set.
enum Settable {
    Parameter(usize),
    Input(usize),
}
