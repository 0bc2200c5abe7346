//! The register file on which a model's tapes run.

use crate::linalg::lane::Lane;
use crate::model::{Model, State, motion};
use crate::tape::{FEW_REGISTERS, Tape};

/// Rounding errors of what a tape computes, as a share of its size.
pub(crate) const ROUNDING: f64 = 1e-12;
/// Rounding errors that large numbers leave where they cancel, as a share of them: accelerations and reactions, impulses, gaps, and rates that loops hold.
pub(crate) const CANCELLED: f64 = 1e-9;

/// All times.
pub(crate) const EVER: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// A register file with the constants of one model in it. Allocated once; nothing allocates afterwards.
#[derive(Clone, Debug)]
pub struct Machine {
    registers: Vec<f64>,
    /// Has the parameter stage run for the parameters in the registers?
    staged: bool,
    /// Signals are those within this span, whichever time is wanted: that of a step between two jumps of laws.
    span: [f64; 2],
}

impl Machine {
    /// A register file for a model.
    pub fn new(model: &Model) -> Self {
        let program = model.program();
        let mut registers = vec![0.0; FEW_REGISTERS.max(program.registers as usize)];
        let first = model.layout().constants();
        registers[first..first + program.constants.len()].copy_from_slice(&program.constants);
        Self { registers, staged: false, span: EVER }
    }

    /// Brings a state into the registers, and the parameter stage up to date.
    pub fn load(&mut self, model: &Model, state: &State) {
        self.load_constant(model, state);
        self.registers[..state.registers().len()].copy_from_slice(state.registers());
    }

    /// Brings what is constant between instants into the registers, and the parameter stage up to date.
    pub fn load_constant(&mut self, model: &Model, state: &State) {
        let constant = state.constant_between_instants();
        let place = &mut self.registers[model.layout().constant_between_instants()];
        if self.staged && have_same_bits(place, constant) {
            return;
        }
        place.copy_from_slice(constant);
        model.program().tapes.parameters.run(&mut self.registers);
        self.staged = true;
    }

    /// Brings time, inputs and followers into the registers, continued from `origin`.
    pub fn load_signals(&mut self, model: &Model, origin: &State, time: f64) {
        let [from, to] = self.span;
        let time = if time < from { from } else { time };
        model.advance_signals(origin, if time > to { to } else { time }, &mut self.registers);
    }

    /// From now on signals are those within a span of time.
    pub fn confine(&mut self, span: [f64; 2]) {
        self.span = span;
    }

    /// Brings q and v into the registers.
    pub fn load_motion(&mut self, model: &Model, motion_values: &[f64]) {
        self.registers[motion(model.layout())].copy_from_slice(motion_values);
    }

    /// Brings q into the registers.
    pub fn load_positions(&mut self, model: &Model, positions: &[f64]) {
        let layout = model.layout();
        self.registers[layout.positions()..layout.rates()].copy_from_slice(positions);
    }

    /// Brings v into the registers.
    pub fn load_rates(&mut self, model: &Model, rates: &[f64]) {
        let layout = model.layout();
        self.registers[layout.rates()..layout.accelerations()].copy_from_slice(rates);
    }

    /// Brings a into the registers.
    pub fn load_accelerations(&mut self, model: &Model, accelerations: &[f64]) {
        let layout = model.layout();
        self.registers[layout.accelerations()..layout.reactions()].copy_from_slice(accelerations);
    }

    /// Brings lambda into the registers.
    pub fn load_reactions(&mut self, model: &Model, reactions: &[f64]) {
        let layout = model.layout();
        self.registers[layout.reactions()..layout.constants()].copy_from_slice(reactions);
    }

    /// Runs a tape.
    pub fn run(&mut self, tape: &Tape) {
        tape.run(&mut self.registers);
    }

    /// Runs a tape together with its derivative, and copies the derivatives of its first results out.
    pub fn differentiate(&mut self, tape: &Tape, tangents: &mut [f64], results: &mut [f64]) {
        tape.run_tangent(&mut self.registers, tangents);
        results.iter_mut().zip(tape.results(tangents)).for_each(|(place, value)| *place = value);
    }

    /// Runs a tape together with its derivatives along four directions.
    pub(crate) fn run_tangents(&mut self, tape: &Tape, tangents: &mut [Lane]) {
        tape.run_tangents(&mut self.registers, tangents);
    }

    /// Runs a tape and copies its first results out.
    pub fn evaluate(&mut self, tape: &Tape, results: &mut [f64]) {
        self.run(tape);
        results.iter_mut().zip(tape.results(&self.registers)).for_each(|(place, value)| *place = value);
    }

    /// Runs a tape together with bounds of the errors of what it computes; `errors` has those of what it reads.
    pub(crate) fn bound_errors(&mut self, tape: &Tape, errors: &mut [f64]) {
        tape.run_errors(&mut self.registers, errors);
    }

    /// One result of a tape that has just run.
    pub fn result(&self, tape: &Tape, index: usize) -> f64 {
        self.registers[tape.results[index] as usize]
    }

    /// The registers.
    pub fn registers(&self) -> &[f64] {
        &self.registers
    }
}

/// True if two lists of the same length have the same bits. All are compared, several at a time: they hardly ever differ.
fn have_same_bits(one: &[f64], other: &[f64]) -> bool {
    one.iter().zip(other).fold(0, |bits, (one, other)| bits | (one.to_bits() ^ other.to_bits())) == 0
}
