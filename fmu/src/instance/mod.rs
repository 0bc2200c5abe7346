//! One simulation: what the command line and the FMI functions use.
//!
//! The order of calls: [`Instance::setup`], any number of [`Instance::set`], [`Instance::initialise`], then [`Instance::step_to`] again and
//! again. Values can be read as soon as setup is done; the initial state is solved for when it is first needed and again after a
//! change. A failure leaves the instance as it was: other values may be tried.

mod error;
mod snapshot;

use std::sync::Arc;

pub use error::InstanceError;
pub use snapshot::Snapshot;

use crate::machine::Machine;
use crate::model::{Model, State};
use crate::program::Source;
use crate::solver::accelerations::Accelerations;
use crate::solver::initial::solve_initial;
use crate::solver::stepping::Stepper;
use crate::solver::{Engine, Settings, Statistics};
use snapshot::{Phase, TOLERANCES};

/// How far a last step may overrun the stop time by rounding, relative to the step.
const OVERRUN: f64 = 1e-3;

/// What has been computed for the present state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Computed {
    Nothing,
    Outputs,
    AcceleratedOutputs,
}

/// One simulation of a model.
#[derive(Clone, Debug)]
pub struct Instance {
    model: Arc<Model>,
    now: Snapshot,
    machine: Machine,
    stepper: Stepper,
    accelerations: Accelerations,
    outputs: Vec<f64>,
    computed: Computed,
}

impl Instance {
    /// A simulation with the defaults of the program.
    pub fn new(model: Arc<Model>) -> Self {
        Self {
            now: Snapshot::new(&model),
            machine: Machine::new(&model),
            stepper: Stepper::new(&model),
            accelerations: Accelerations::new(&model),
            outputs: vec![0.0; model.program().tapes.outputs.results.len()],
            computed: Computed::Nothing,
            model,
        }
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Time [s].
    pub fn time(&self) -> f64 {
        self.now.state.time()
    }

    /// The state; consistent once initialised.
    pub fn state(&self) -> &State {
        &self.now.state
    }

    /// What the solver has done so far.
    pub fn statistics(&self) -> Statistics {
        self.stepper.statistics()
    }

    /// Index of the variable with that name.
    pub fn variable(&self, name: &str) -> Option<usize> {
        self.model.program().variables.iter().position(|variable| variable.name == name)
    }

    /// Start time, stop time if there is one, tolerance if it is not the default.
    pub fn setup(&mut self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> Result<(), InstanceError> {
        if self.now.phase == Phase::Running {
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
        self.touch();
        Ok(())
    }

    /// Would [`Instance::set`] accept this?
    pub fn check_set(&self, variable: usize, value: f64) -> Result<(), InstanceError> {
        let (name, min, max) = match self.settable(variable)? {
            Settable::Parameter(index) => {
                let parameter = &self.model.program().parameters[index];
                if self.now.phase == Phase::Running && !parameter.tunable {
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

    /// Sets a parameter or an input. Derivatives of an input become zero, unless they were set at this very communication point.
    pub fn set(&mut self, variable: usize, value: f64) -> Result<(), InstanceError> {
        self.check_set(variable, value)?;
        match self.settable(variable)? {
            Settable::Parameter(index) => {
                if self.now.state.parameters()[index].to_bits() != value.to_bits() {
                    self.touch();
                    self.now.state.parameters_mut()[index] = value;
                }
            }
            Settable::Input(index) => {
                let [_, rate, acceleration] = self.kept_polynomial(index);
                self.set_polynomial(index, [value, rate, acceleration]);
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
        if let Settable::Input(index) = self.settable(variable)? {
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
            self.touch();
            self.now.state.set_input_polynomial(index, polynomial);
            self.model.follow(self.now.state.registers_mut());
        }
    }

    /// To be called before parameters or inputs change.
    fn touch(&mut self) {
        self.computed = Computed::Nothing;
        match &mut self.now.phase {
            Phase::Initial { solved } => *solved = false,
            Phase::Running => self.now.run.change(&self.now.state),
        }
    }

    fn settable(&self, variable: usize) -> Result<Settable, InstanceError> {
        let found = self.model.program().variables.get(variable);
        let found = found.ok_or(InstanceError::UnknownVariable { index: variable })?;
        match found.source {
            Source::Parameter(index) => Ok(Settable::Parameter(index as usize)),
            Source::Input(index) => Ok(Settable::Input(index as usize)),
            _ => Err(InstanceError::Calculated { name: found.name.clone() }),
        }
    }

    /// Solves for the initial state and starts the simulation.
    pub fn initialise(&mut self) -> Result<(), InstanceError> {
        self.solve()?;
        self.now.phase = Phase::Running;
        self.now.run.start(&self.model, &self.now.state);
        self.stepper.forget();
        Ok(())
    }

    /// Makes the state consistent, if it is not.
    fn solve(&mut self) -> Result<(), InstanceError> {
        if self.now.phase == (Phase::Initial { solved: false }) {
            let mut state = self.now.state.clone();
            let motion = self.model.layout().followers();
            state.registers_mut()[motion..].fill(0.0);
            solve_initial(&self.model, &mut state)?;
            self.now.state = state;
            self.now.phase = Phase::Initial { solved: true };
            self.computed = Computed::Nothing;
        }
        Ok(())
    }

    /// Moves on to a later time.
    pub fn step_to(&mut self, time: f64) -> Result<(), InstanceError> {
        let from = self.time();
        if self.now.phase != Phase::Running {
            return Err(InstanceError::Phase { running: false });
        }
        if !(time.is_finite() && time > from) {
            return Err(InstanceError::Step { from, to: time });
        }
        if let Some(stop) = self.now.stop
            && time > stop + OVERRUN * (time - from)
        {
            return Err(InstanceError::Stop { to: time, stop });
        }
        let settings = Settings {
            engine: Engine::default(),
            tolerance: self.now.tolerance,
            max_step: self.model.program().experiment.max_step,
            stop: self.now.stop,
        };
        let Snapshot { state, run, .. } = &mut self.now;
        self.computed = Computed::Nothing;
        self.stepper.step_to(&self.model, &mut self.machine, state, run, time, &settings)?;
        self.now.derivatives.fill(false);
        Ok(())
    }

    /// The value of a variable at the present time. A change of an input shows in accelerations at once, in positions and
    /// velocities from the next step on.
    pub fn get(&mut self, variable: usize) -> Result<f64, InstanceError> {
        let found = self.model.program().variables.get(variable);
        let source = found.ok_or(InstanceError::UnknownVariable { index: variable })?.source;
        let state = &self.now.state;
        let value = match source {
            Source::Time => return Ok(state.time()),
            Source::Parameter(index) => return Ok(state.parameters()[index as usize]),
            Source::Input(index) => return Ok(state.inputs()[index as usize]),
            Source::Coordinate(index) => {
                self.solve()?;
                self.now.state.positions()[index as usize]
            }
            Source::Rate(index) => {
                self.solve()?;
                self.now.state.rates()[index as usize]
            }
            Source::Acceleration(index) => {
                self.compute(Computed::AcceleratedOutputs)?;
                self.accelerations.accelerations()[index as usize]
            }
            Source::Output { result, accelerated } => {
                self.compute(if accelerated { Computed::AcceleratedOutputs } else { Computed::Outputs })?;
                self.outputs[result as usize]
            }
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(InstanceError::Undefined {
                name: self.model.program().variables[variable].name.clone(),
                time: self.time(),
            })
        }
    }

    /// Computes outputs for the present state, with accelerations and reactions only if they are wanted.
    fn compute(&mut self, wanted: Computed) -> Result<(), InstanceError> {
        self.solve()?;
        if self.computed < wanted {
            self.machine.load(&self.model, &self.now.state);
            if wanted == Computed::AcceleratedOutputs {
                self.accelerations.evaluate(&self.model, &mut self.machine)?;
            }
            self.machine.evaluate(&self.model.program().tapes.outputs, &mut self.outputs);
            self.computed = wanted;
        }
        Ok(())
    }

    /// Back to the defaults, as a new instance.
    pub fn reset(&mut self) {
        self.now = Snapshot::new(&self.model);
        self.computed = Computed::Nothing;
        self.stepper.forget();
    }

    /// A copy of all that the future depends on.
    pub fn save(&self) -> Snapshot {
        self.now.clone()
    }

    /// The same into a snapshot of the same model, without allocating.
    pub fn save_into(&self, snapshot: &mut Snapshot) {
        snapshot.copy_from(&self.now);
    }

    /// Goes back (or on) to a saved state.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), InstanceError> {
        if !snapshot.belongs_to(&self.model) {
            return Err(InstanceError::ForeignState);
        }
        self.now.copy_from(snapshot);
        self.computed = Computed::Nothing;
        self.stepper.forget();
        Ok(())
    }
}

/// What can be set.
enum Settable {
    Parameter(usize),
    Input(usize),
}
