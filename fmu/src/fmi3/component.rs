//! What FMI 3.0 alone asks of a component.

use super::references::{References, Referent};
use super::types::{
    fmi3FMUState, fmi3False, fmi3InstanceEnvironment, fmi3IntermediateUpdateCallback, fmi3Status, fmi3True,
};
use crate::fmi::component::{self, Interface, MODES, Mode, Outcome, Refusal, Version};
use crate::fmi::logging::{Category, LogSeverity};
use crate::fmi::states;
use crate::hybrid::tick::is_later;
use crate::instance::{Handled, Instance, InstanceError};

/// What an instance of this version was made with, and its step under way.
pub struct Fmi3 {
    pub references: References,
    /// Does the importer of a Co-Simulation handle events?
    pub event_mode_used: bool,
    /// May a step end before the communication point?
    pub early_return_allowed: bool,
    pub intermediate_update: fmi3IntermediateUpdateCallback,
    pub environment: fmi3InstanceEnvironment,
    /// No time may be before this one [s].
    pub start: f64,
    pub indicators: Vec<f64>,
    /// The communication point that the step under way goes to, and whether anything had changed before it.
    pub step: Option<(f64, bool)>,
}

/// An instance of this version.
pub type Fmi3Component = component::FmiComponent<Fmi3>;

impl Fmi3 {
    /// For an instance whose importer wants nothing special.
    pub fn new(instance: &Instance) -> Self {
        let references = References::of(instance.model().program());
        Self {
            references,
            event_mode_used: false,
            early_return_allowed: false,
            intermediate_update: None,
            environment: std::ptr::null_mut(),
            start: f64::NEG_INFINITY,
            indicators: vec![0.0; instance.model().program().indicators()],
            step: None,
        }
    }

    /// What the importer is asked with in the middle of a step.
    pub fn callback(&self) -> Callback {
        Callback { function: self.intermediate_update, environment: self.environment }
    }
}

/// What the importer is asked with in the middle of a step.
#[derive(Clone, Copy)]
pub struct Callback {
    function: fmi3IntermediateUpdateCallback,
    environment: fmi3InstanceEnvironment,
}

impl Callback {
    /// Shows the end of an integrator's step; when the importer wants to have the step ended, if so.
    pub fn ask(self, time: f64, can_return: bool) -> Option<f64> {
        let (mut requested, mut until) = (fmi3False, time);
        let function = self.function?;
        // SAFETY: the importer gave this function for this purpose and keeps it alive as long as the instance; both places outlive the call.
        unsafe {
            function(
                self.environment,
                time,
                fmi3False,
                fmi3True,
                fmi3True,
                can_return.into(),
                &raw mut requested,
                &raw mut until,
            );
        }
        (can_return && requested != fmi3False).then_some(until)
    }
}

impl Version for Fmi3 {
    type Status = fmi3Status;
    const OK: fmi3Status = fmi3Status::fmi3OK;
    const WARNING: fmi3Status = fmi3Status::fmi3Warning;
    const ERROR: fmi3Status = fmi3Status::fmi3Error;
    const NUMBER: u8 = 3;
    const READABLE: &'static [Mode] = &MODES;

    fn refuse(component: &mut Fmi3Component, refusal: &Refusal) -> fmi3Status {
        let (severity, status) = match refusal.discards {
            true => (LogSeverity::Discard, fmi3Status::fmi3Discard),
            false => (LogSeverity::Error, fmi3Status::fmi3Error),
        };
        component.logger.log(severity, Category::Errors, &refusal.reason);
        if !refusal.discards {
            component.mode = Mode::Terminated;
        }
        status
    }

    fn variable(component: &Fmi3Component, reference: u32) -> Result<usize, InstanceError> {
        match component.version.references.find(reference) {
            Some(Referent::Variable(variable)) => Ok(variable),
            _ => Err(unknown(reference)),
        }
    }

    fn get(component: &mut Fmi3Component, reference: u32) -> Result<f64, InstanceError> {
        let instance = &mut component.instance;
        match component.version.references.find(reference) {
            Some(Referent::Variable(variable)) => match instance.initial_value(variable) {
                Some(value) if component.mode == Mode::Instantiated => Ok(value),
                _ => instance.get(variable),
            },
            Some(Referent::InputDerivative { input, order }) => Ok(instance.input(input, order)),
            Some(Referent::Time) => Ok(instance.time()),
            Some(Referent::Indicator(index)) => {
                let indicators = &mut component.version.indicators;
                instance.indicators(indicators)?;
                Ok(indicators[index])
            }
            None => Err(unknown(reference)),
        }
    }

    fn check_set(component: &Fmi3Component, reference: u32, value: f64) -> Outcome {
        let instance = &component.instance;
        match component.version.references.find(reference) {
            Some(Referent::Variable(variable)) => {
                instance.check_set(variable, value)?;
                if component.mode == Mode::Initialization && instance.is_guess(variable) {
                    return Err("guesses of initial values are set before initialization mode".into());
                }
                component.allow_change(instance.is_input(variable))
            }
            Some(Referent::InputDerivative { input, .. }) if !value.is_finite() => {
                Err(InstanceError::NotANumber { name: instance.input_name(input), value }.into())
            }
            Some(Referent::InputDerivative { .. }) => Ok(()),
            Some(Referent::Time) => Err("`time` is the independent variable: it cannot be set".into()),
            Some(Referent::Indicator(_)) => Err("event indicators are calculated: they cannot be set".into()),
            None => Err(unknown(reference).into()),
        }
    }

    fn set(component: &mut Fmi3Component, reference: u32, value: f64) -> Result<(), InstanceError> {
        let instance = &mut component.instance;
        match component.version.references.find(reference) {
            Some(Referent::Variable(variable)) => match instance.input_of(variable) {
                Some(input) => instance.set_input(input, 0, value),
                None => instance.set(variable, value)?,
            },
            Some(Referent::InputDerivative { input, order }) => instance.set_input(input, order, value),
            _ => return Err(unknown(reference)),
        }
        Ok(())
    }

    fn add_direction(component: &mut Fmi3Component, reference: u32, change: f64) -> Result<(), InstanceError> {
        let instance = &mut component.instance;
        match component.version.references.find(reference) {
            Some(Referent::Variable(variable)) => instance.add_direction(variable, change),
            Some(Referent::InputDerivative { input, order }) => {
                instance.add_input_direction(input, order, change);
                Ok(())
            }
            Some(Referent::Time) => {
                instance.add_time_direction(change);
                Ok(())
            }
            _ => Err(unknown(reference)),
        }
    }
}

fn unknown(reference: u32) -> InstanceError {
    InstanceError::UnknownVariable { index: reference as usize }
}

/// How far a step has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// The importer may look at intermediate values, and if that is true also end the step here.
    Underway {
        can_return: bool,
    },
    Done(StepEnd),
}

/// How a step has ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepEnd {
    /// Is this an event that the importer must handle?
    pub event: bool,
    /// Is this before the communication point?
    pub early: bool,
    /// True if an event of the scene has ended the run here.
    pub ended: bool,
    /// Where it is [s].
    pub time: f64,
}

impl Fmi3Component {
    pub fn enter_initialization(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Outcome {
        self.setup_experiment(tolerance, start, stop)?;
        self.version.start = start;
        self.mode = Mode::Initialization;
        Ok(())
    }

    /// Ends initialization mode in the mode that this version wants.
    pub fn start(&mut self) -> Outcome {
        self.exit_initialization()?;
        if self.version.event_mode_used {
            self.mode = Mode::Event;
        }
        Ok(())
    }

    pub fn go_to_event_mode(&mut self) -> Outcome {
        match self.interface {
            Interface::ModelExchange => self.enter_event_mode(),
            Interface::CoSimulation => {
                self.allow_event_mode(Mode::Step)?;
                self.mode = Mode::Event;
                Ok(())
            }
        }
    }

    pub fn enter_step_mode(&mut self) -> Outcome {
        self.allow_only(Interface::CoSimulation, &[Mode::Event])?;
        self.allow_event_mode(Mode::Event)?;
        self.mode = Mode::Step;
        Ok(())
    }

    fn allow_event_mode(&self, from: Mode) -> Outcome {
        if !self.version.event_mode_used {
            return Err("the instance was made without event mode".into());
        }
        self.allow(&[from])
    }

    pub fn update_discrete_states(&mut self) -> Outcome<Handled> {
        match self.interface {
            Interface::ModelExchange => self.new_discrete_states(),
            // What was set acts from here on, whoever integrates: the next step begins with it. What happened has happened in the step.
            Interface::CoSimulation => {
                self.allow(&[Mode::Event])?;
                Ok(Handled { next: self.instance.next_event_time()?, ..Handled::default() })
            }
        }
    }

    /// How many states and event indicators there are.
    pub fn numbers(&self) -> Outcome<(usize, usize)> {
        self.allow_only(Interface::ModelExchange, &MODES)?;
        Ok((self.instance.state_count(), self.version.indicators.len()))
    }

    pub fn restore_state(&mut self, state: fmi3FMUState) -> Outcome {
        if self.mode == Mode::Intermediate {
            return self.allow(&[]);
        }
        states::restore(self, state)?;
        // It may come from an instance that began earlier.
        self.version.start = self.version.start.min(self.instance.time());
        Ok(())
    }

    pub fn move_time(&mut self, time: f64) -> Outcome {
        self.allow(&[Mode::ContinuousTime])?;
        if time < self.version.start {
            let (time, start) = (component::number(time), component::number(self.version.start));
            return Err(Refusal::new(format!("t = {time} s is before the start at {start} s")));
        }
        self.set_time(time)
    }

    /// Derivatives of a weighted sum of calculated variables by what is known.
    pub fn adjoint_derivative(&mut self, unknowns: &[u32], knowns: &[u32], seed: &[f64], sums: &mut [f64]) -> Outcome {
        let mut column = vec![0.0; unknowns.len()];
        for (known, sum) in knowns.iter().zip(sums) {
            self.directional_derivative(unknowns, &mut column, std::slice::from_ref(known), &[1.0])?;
            *sum = column.iter().zip(seed).map(|(entry, weight)| entry * weight).sum();
        }
        Ok(())
    }

    /// Does nobody care for what happens within a step?
    pub fn is_undivided(&self) -> bool {
        self.version.intermediate_update.is_none() && !self.version.early_return_allowed
    }

    /// Begins a step, and goes as far as nobody outside needs to know of it.
    pub fn begin_step(&mut self, point: f64, step: f64) -> Outcome<Progress> {
        self.allow(&[Mode::Step])?;
        if self.is_undivided() {
            let done = self.do_step(point, step);
            let (ended, time) = (self.instance.is_ended(), self.instance.time());
            return match done {
                Err(refusal) if !ended => Err(refusal),
                _ => Ok(Progress::Done(StepEnd::new([false, ended, false], time, point + step))),
            };
        }
        self.check_step(point, step)?;
        self.instance.check_step(point + step)?;
        self.note_inputs();
        self.version.step = Some((point + step, self.instance.is_changed()));
        self.advance()
    }

    /// Goes on after intermediate values, or ends the step at a time that the importer asks for.
    pub fn continue_step(&mut self, early_return: Option<f64>) -> Outcome<Progress> {
        self.allow(&[Mode::Intermediate])?;
        self.mode = Mode::Step;
        let (now, Some((target, changed))) = (self.instance.time(), self.version.step) else {
            return Err("no step is in progress".into());
        };
        match early_return {
            Some(time) if self.version.early_return_allowed && now < target => {
                // NaN is no time.
                let time = time.clamp(now, target);
                if time > now {
                    self.instance.go_to(time)?;
                }
                Ok(self.end(changed, target, false))
            }
            _ if now >= target => Ok(self.end(changed, target, false)),
            _ => self.advance(),
        }
    }

    /// Goes to the end of the integrator's next step, or to the communication point if that comes first.
    fn advance(&mut self) -> Outcome<Progress> {
        let Some((target, changed)) = self.version.step else {
            return Err("no step is in progress".into());
        };
        loop {
            let advanced = self.instance.step_towards(target);
            self.report_step();
            if self.instance.is_ended() {
                return Ok(self.end(changed, target, false));
            }
            let event = advanced?;
            let early = self.instance.time() < target;
            if event && early && self.version.early_return_allowed {
                return Ok(self.end(changed, target, self.version.event_mode_used));
            }
            if self.version.intermediate_update.is_some() {
                self.mode = Mode::Intermediate;
                return Ok(Progress::Underway { can_return: early && self.version.early_return_allowed });
            }
            if !early {
                return Ok(self.end(changed, target, false));
            }
        }
    }

    fn end(&mut self, changed: bool, target: f64, event: bool) -> Progress {
        self.version.step = None;
        self.instance.join_steps(changed);
        let is_ended = self.instance.is_ended();
        let reasons = [event, is_ended, self.version.early_return_allowed];
        Progress::Done(StepEnd::new(reasons, self.instance.time(), target))
    }
}

impl StepEnd {
    /// A tick that differs from the communication point by rounding errors only is that point. Where an event of the scene ends the run before it and the step may not return early, it
    /// does not, and nothing happens from the event on.
    fn new([event, ended, may_be_early]: [bool; 3], time: f64, target: f64) -> Self {
        let is_before = is_later(target, time);
        Self { event, early: is_before && may_be_early, ended, time: if is_before { time } else { target } }
    }
}
