//! A program ready to run, and the state that it moves.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::math;
use crate::program::check::ProgramError;
use crate::program::{Constraint, FollowerOrder, Layout, Program, Role, time_switches};

/// In runs that last longer, slow rates count as well [s].
const LASTING: f64 = 10.0;

/// A checked program with its register layout. Immutable: instances share it.
#[derive(Clone, Debug)]
pub struct Model {
    program: Program,
    layout: Layout,
    active: Vec<usize>,
    /// Rows among which independent ones are chosen in every pose; none if there is no choice.
    eligible: Vec<usize>,
    driven: bool,
    lever: f64,
    /// Of each parameter: is it the known value of a variable at the start?
    imposed: Vec<bool>,
    /// Inputs that drivers follow and whose rates are needed, in order.
    followed: Vec<usize>,
    time_switches: Vec<usize>,
}

/// Loop equations of lengths change by so much with an angle: the length of the mechanism. One where slides count among the coordinates, or angles among the loop equations: some rows are shares already.
fn lever(program: &Program) -> f64 {
    let turns = program.coordinates.iter().all(|coordinate| coordinate.scale == 1.0);
    let lengths = program.constraints.iter().all(|row| !row.is_angle());
    if turns && lengths { program.length } else { 1.0 }
}

impl Model {
    /// Checks a program and prepares it.
    pub fn new(program: Program) -> Result<Self, ProgramError> {
        program.check()?;
        Ok(Self::prepare(program))
    }

    /// For the exporter: a model whose kernels of the motion need not exist yet. It serves the search
    /// for a consistent start, and for what each loop equation restricts, only.
    pub fn of_positions(program: Program) -> Result<Self, ProgramError> {
        program.check_positions()?;
        Ok(Self::prepare(program))
    }

    fn prepare(program: Program) -> Self {
        let layout = program.layout();
        let rows = |of: fn(&Constraint) -> bool| {
            let rows = program.constraints.iter().enumerate();
            rows.filter(|(_, constraint)| of(constraint)).map(|(row, _)| row).collect::<Vec<usize>>()
        };
        let active = rows(Constraint::is_imposed);
        let eligible = rows(|constraint| constraint.role != Role::LeftOut);
        let eligible = if eligible.len() > active.len() { eligible } else { Vec::new() };
        let mut imposed = vec![false; program.parameters.len()];
        let initial = &program.initial;
        for (conditions, tape) in [(&initial.positions, &initial.position), (&initial.velocities, &initial.velocity)] {
            let targets = conditions.iter().zip(tape.results.iter().skip(conditions.len()));
            for (_, &register) in targets.filter(|(condition, _)| condition.known) {
                let parameter = (register as usize).checked_sub(layout.parameters());
                if let Some(place) = parameter.and_then(|parameter| imposed.get_mut(parameter)) {
                    *place = true;
                }
            }
        }
        let followed = program.inputs_with_rates();
        let time_switches = time_switches::of_laws(&program, &layout);
        let (driven, lever) = (program.is_driven(), lever(&program));
        Self { driven, lever, program, layout, active, eligible, imposed, followed, time_switches }
    }

    /// The program.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Where things lie in the register file.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Comparisons of laws that change over at a time known beforehand: their indices among the results of the laws.
    pub(crate) fn time_switches(&self) -> &[usize] {
        &self.time_switches
    }

    /// Rows of the active constraints.
    pub fn active(&self) -> &[usize] {
        &self.active
    }

    /// Rows among which as many as are active are chosen in every pose; none if these are the active ones everywhere.
    pub(crate) fn eligible(&self) -> &[usize] {
        &self.eligible
    }

    /// Do drivers determine the motion?
    pub fn is_driven(&self) -> bool {
        self.driven
    }

    /// By what the distances of loop equations from each other are divided to be shares of one, see [`lever`].
    pub(crate) fn lever(&self) -> f64 {
        self.lever
    }

    /// The inputs that drivers follow, in order.
    pub fn followed(&self) -> &[usize] {
        &self.followed
    }

    /// Is that parameter the known value of a variable at the start, which must read back as it was set?
    pub fn is_imposed(&self, parameter: usize) -> bool {
        self.imposed.get(parameter).copied().unwrap_or_default()
    }

    /// So many scales a second are the least rate that counts relative to itself: wrong by a tolerance, it moves the mechanism by some tolerances in a run that ends at
    /// this time, or when the scene says if that is later.
    pub fn least_rate(&self, stop: Option<f64>) -> f64 {
        let experiment = &self.program.experiment;
        let end = stop.map_or(experiment.stop, |stop| math::maximum(stop, experiment.stop));
        math::minimum(LASTING / (end - experiment.start), 1.0)
    }

    /// Number of coordinates, n.
    pub fn coordinates(&self) -> usize {
        self.program.coordinates.len()
    }

    /// Number of coordinates of the mechanism: those before the integrals of states.
    pub fn mechanical(&self) -> usize {
        self.program.mechanical()
    }

    /// Takes the integrals of states out of a motion (q, v): nobody reads them, and what grows without end would count as rounding errors of the others.
    pub(crate) fn forget_integrals(&self, motion: &mut [f64]) {
        motion[self.mechanical()..self.coordinates()].fill(0.0);
    }

    /// The state before anything is solved: everything zero but the defaults of parameters, discrete variables and inputs.
    pub fn default_state(&self, time: f64) -> State {
        let mut state = State { layout: self.layout, registers: vec![0.0; self.layout.accelerations()] };
        state.registers[self.layout.time()] = time;
        for (value, parameter) in state.parameters_mut().iter_mut().zip(&self.program.parameters) {
            *value = parameter.start;
        }
        for (value, discrete) in state.discrete_mut().iter_mut().zip(&self.program.discrete) {
            *value = discrete.start;
        }
        for (value, input) in state.inputs_mut().iter_mut().zip(&self.program.inputs) {
            *value = input.start;
        }
        self.follow(&mut state.registers);
        state
    }

    /// Writes time, and inputs and followers at that time, to the registers. Inputs are the polynomials of time of
    /// `origin`; followers are their exact integrals.
    pub fn advance_signals(&self, origin: &State, time: f64, registers: &mut [f64]) {
        let layout = &self.layout;
        let from = &origin.registers;
        let dt = time - from[layout.time()];
        registers[layout.time()] = time;
        for index in 0..self.program.inputs.len() {
            let [value, rate, acceleration] = origin.input_polynomial(index);
            registers[layout.inputs() + index] = value + dt * (rate + dt * (0.5 * acceleration));
            registers[layout.input_rates() + index] = rate + dt * acceleration;
            registers[layout.input_accelerations() + index] = acceleration;
        }
        for (index, follower) in self.program.followers.iter().enumerate() {
            let [value, rate, acceleration] = origin.input_polynomial(follower.input as usize);
            let integral = dt * (value + dt * (rate / 2.0 + dt * (acceleration / 6.0)));
            let position = from[layout.followers() + index];
            registers[layout.followers() + index] = match follower.order {
                FollowerOrder::Velocity => position + integral,
                FollowerOrder::Acceleration => {
                    let start = from[layout.follower_rates() + index];
                    registers[layout.follower_rates() + index] = start + integral;
                    let twice = dt * (value / 2.0 + dt * (rate / 6.0 + dt * (acceleration / 24.0)));
                    position + dt * (start + twice)
                }
            };
        }
        self.follow(registers);
    }

    /// Writes what followers take from the inputs at this time: the rate or the acceleration.
    pub fn follow(&self, registers: &mut [f64]) {
        let layout = &self.layout;
        for (index, follower) in self.program.followers.iter().enumerate() {
            let input = follower.input as usize;
            let value = registers[layout.inputs() + input];
            match follower.order {
                FollowerOrder::Velocity => {
                    registers[layout.follower_rates() + index] = value;
                    registers[layout.follower_accelerations() + index] = registers[layout.input_rates() + input];
                }
                FollowerOrder::Acceleration => registers[layout.follower_accelerations() + index] = value,
            }
        }
    }
}

/// Everything that the motion from now on depends on: time, parameters, discrete variables, inputs as polynomials of time about now,
/// followers, q and v. It is the first part of the register file, so saving a state is one copy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    layout: Layout,
    registers: Vec<f64>,
}

impl State {
    /// Time [s].
    pub fn time(&self) -> f64 {
        self.registers[self.layout.time()]
    }

    /// Moves time on, and nothing else.
    pub(crate) fn set_time(&mut self, time: f64) {
        let place = self.layout.time();
        self.registers[place] = time;
    }

    /// Parameters.
    pub fn parameters(&self) -> &[f64] {
        &self.registers[self.layout.parameters()..self.layout.discrete()]
    }

    /// Parameters, to be changed.
    pub fn parameters_mut(&mut self) -> &mut [f64] {
        &mut self.registers[self.layout.parameters()..self.layout.discrete()]
    }

    /// Discrete variables.
    pub fn discrete(&self) -> &[f64] {
        &self.registers[self.layout.discrete()..self.layout.inputs()]
    }

    /// Discrete variables, to be changed.
    pub fn discrete_mut(&mut self) -> &mut [f64] {
        &mut self.registers[self.layout.discrete()..self.layout.inputs()]
    }

    /// Parameters and discrete variables: what is constant between instants.
    pub fn constant_between_instants(&self) -> &[f64] {
        &self.registers[self.layout.constant_between_instants()]
    }

    /// Inputs.
    pub fn inputs(&self) -> &[f64] {
        &self.registers[self.layout.inputs()..self.layout.input_rates()]
    }

    /// Inputs, to be changed; followers then hear of it by [`Model::follow`].
    pub fn inputs_mut(&mut self) -> &mut [f64] {
        &mut self.registers[self.layout.inputs()..self.layout.input_rates()]
    }

    /// Value, rate and acceleration of an input.
    pub fn input_polynomial(&self, index: usize) -> [f64; 3] {
        let layout = &self.layout;
        [layout.inputs(), layout.input_rates(), layout.input_accelerations()].map(|first| self.registers[first + index])
    }

    /// Sets value, rate and acceleration of an input; followers then hear of it by [`Model::follow`].
    pub fn set_input_polynomial(&mut self, index: usize, polynomial: [f64; 3]) {
        let layout = &self.layout;
        let firsts = [layout.inputs(), layout.input_rates(), layout.input_accelerations()];
        for (first, value) in firsts.into_iter().zip(polynomial) {
            self.registers[first + index] = value;
        }
    }

    /// Follower positions.
    pub fn follower_positions(&self) -> &[f64] {
        &self.registers[self.layout.followers()..self.layout.follower_rates()]
    }

    /// Follower positions, to be changed.
    pub fn follower_positions_mut(&mut self) -> &mut [f64] {
        &mut self.registers[self.layout.followers()..self.layout.follower_rates()]
    }

    /// Follower rates.
    pub fn follower_rates(&self) -> &[f64] {
        &self.registers[self.layout.follower_rates()..self.layout.follower_accelerations()]
    }

    /// Follower rates, to be changed.
    pub fn follower_rates_mut(&mut self) -> &mut [f64] {
        &mut self.registers[self.layout.follower_rates()..self.layout.follower_accelerations()]
    }

    /// Coordinates q.
    pub fn positions(&self) -> &[f64] {
        &self.registers[self.layout.positions()..self.layout.rates()]
    }

    /// Coordinates q, to be changed.
    pub fn positions_mut(&mut self) -> &mut [f64] {
        &mut self.registers[self.layout.positions()..self.layout.rates()]
    }

    /// Rates v.
    pub fn rates(&self) -> &[f64] {
        &self.registers[self.layout.rates()..self.layout.accelerations()]
    }

    /// Rates v, to be changed.
    pub fn rates_mut(&mut self) -> &mut [f64] {
        &mut self.registers[self.layout.rates()..self.layout.accelerations()]
    }

    /// States of the scene.
    pub fn states(&self) -> &[f64] {
        &self.registers[self.layout.states()..self.layout.accelerations()]
    }

    /// All of it, as it lies at the start of the register file.
    pub fn registers(&self) -> &[f64] {
        &self.registers
    }

    /// All of it, to be changed.
    pub fn registers_mut(&mut self) -> &mut [f64] {
        &mut self.registers
    }

    /// Copies another state of the same model without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.layout = other.layout;
        self.registers.clone_from(&other.registers);
    }

    /// Is this a state of that model?
    pub fn belongs_to(&self, model: &Model) -> bool {
        self.layout == model.layout && self.registers.len() == model.layout.accelerations()
    }

    /// Does every number have a value?
    pub fn is_finite(&self) -> bool {
        self.registers.iter().all(|value| value.is_finite())
    }
}

/// Registers of q and v together.
pub(crate) fn motion(layout: &Layout) -> Range<usize> {
    layout.positions()..layout.accelerations()
}
