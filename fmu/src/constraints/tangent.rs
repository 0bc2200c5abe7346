//! Derivatives of the motion and the outputs along one direction, exactly.
//!
//! A direction says how time, parameters, inputs and followers change, and where they are states also how q and v do: each on its own, as the
//! states of an explicit differential equation; the loops hold q and v together, but a derivative by one of them is taken at fixed others.
//! Where drivers determine the motion, q and v follow from the loops, and so do their derivatives.
//! Derivatives by time, also of higher order, are those of [`super::expansion`].

use super::initial;
use crate::failure::Failure;
use crate::machine::Machine;
use crate::model::{Model, motion};

/// The derivative of a whole register file, with storage for evaluating it.
#[derive(Clone, Debug)]
pub struct Tangent {
    registers: Vec<f64>,
    /// Residuals of all m loop equations, then n corrections.
    corrections: Vec<f64>,
    /// Of a, then lambda.
    solved: Vec<f64>,
    /// Derivatives of the first values of discrete variables.
    begin: Vec<f64>,
    outputs: Vec<f64>,
}

/// Where the derivatives of q and v come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Movement {
    /// From the direction, or from the loops if they determine the motion.
    Continued,
    /// From the conditions on the initial state and the loops.
    Assembled,
}

impl Tangent {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let program = model.program();
        let (n, m) = (model.coordinates(), program.constraints.len());
        Self {
            registers: vec![0.0; program.registers as usize],
            corrections: vec![0.0; m + n],
            solved: vec![0.0; n + m],
            begin: vec![0.0; program.instants.begin.results.len()],
            outputs: vec![0.0; program.tapes.outputs.results.len()],
        }
    }

    /// No direction at all.
    pub fn begin(&mut self) {
        self.registers.fill(0.0);
    }

    /// The direction, in the layout of the register file.
    pub fn direction(&mut self) -> &mut [f64] {
        &mut self.registers
    }

    /// Evaluates everything along the direction, at the state in the registers of the machine with its accelerations and reactions.
    pub fn evaluate(&mut self, model: &Model, machine: &mut Machine, movement: Movement) -> Result<(), Failure> {
        model.follow(&mut self.registers);
        let layout = model.layout();
        self.stage(model, machine);
        if movement == Movement::Assembled {
            initial::tangent::assemble(model, machine, &mut self.registers)?;
            self.begin_discrete(model, machine);
        }
        if movement == Movement::Continued && model.is_driven() {
            self.follow_loops(model, machine);
        }
        machine.differentiate(&model.program().tapes.acceleration, &mut self.registers, &mut self.solved);
        self.registers[layout.accelerations()..layout.constants()].copy_from_slice(&self.solved);
        machine.differentiate(&model.program().tapes.outputs, &mut self.registers, &mut self.outputs);
        Ok(())
    }

    /// The parameter stage, if anything that it reads changes.
    fn stage(&mut self, model: &Model, machine: &mut Machine) {
        if self.registers[model.layout().constant_between_instants()].iter().any(|tangent| *tangent != 0.0) {
            machine.differentiate(&model.program().tapes.parameters, &mut self.registers, &mut []);
        }
    }

    /// Derivatives of what discrete variables begin with.
    fn begin_discrete(&mut self, model: &Model, machine: &mut Machine) {
        if self.begin.is_empty() {
            return;
        }
        let (program, layout) = (model.program(), model.layout());
        machine.differentiate(&program.instants.begin, &mut self.registers, &mut self.begin);
        self.registers[layout.discrete()..][..self.begin.len()].copy_from_slice(&self.begin);
        self.stage(model, machine);
    }

    /// Derivatives of the motion of a driven mechanism: where the loops are closed, those of the corrections that close them,
    /// dq = -Phi_q^-1 dPhi and likewise dv.
    fn follow_loops(&mut self, model: &Model, machine: &mut Machine) {
        let Self { registers, corrections, .. } = self;
        let (tapes, layout, m) = (&model.program().tapes, model.layout(), model.program().constraints.len());
        registers[motion(layout)].fill(0.0);
        for (tape, first) in [(&tapes.project_position, layout.positions()), (&tapes.project_velocity, layout.rates())]
        {
            if !model.active().is_empty() {
                machine.differentiate(tape, registers, corrections);
                registers[first..][..model.coordinates()].copy_from_slice(&corrections[m..]);
            }
        }
    }

    /// Derivatives of all registers up to the constants, in the layout of the register file.
    pub fn registers(&self) -> &[f64] {
        &self.registers
    }

    /// Derivatives of the results of the output tape.
    pub fn outputs(&self) -> &[f64] {
        &self.outputs
    }
}
