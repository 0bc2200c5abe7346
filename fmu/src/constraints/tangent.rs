//! Derivatives of the motion and the outputs along one direction, exactly.
//!
//! A direction says how time, parameters, inputs and followers change, and with dynamic motion also how q and v do: each on its own, as the
//! states of an explicit differential equation; the loops hold q and v together, but a derivative by one of them is taken at fixed others.
//! With kinematic motion q and v follow from the loops, and so do their derivatives.
//! Derivatives by time, also of higher order, are those of [`super::expansion`].

use super::initial;
use super::loops::Loops;
use crate::failure::Failure;
use crate::machine::Machine;
use crate::model::{Model, motion};
use crate::program::Motion;

/// The derivative of a whole register file, with storage for evaluating it.
#[derive(Clone, Debug)]
pub struct Tangent {
    registers: Vec<f64>,
    /// Residuals of all m loop equations.
    residuals: Vec<f64>,
    /// Of a, then lambda.
    solved: Vec<f64>,
    /// Of Q - M a.
    loads: Vec<f64>,
    jacobian: Vec<f64>,
    outputs: Vec<f64>,
    loops: Option<Loops>,
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
            residuals: vec![0.0; m],
            solved: vec![0.0; n + m],
            loads: vec![0.0; n],
            jacobian: vec![0.0; program.tapes.jacobian.entries.len()],
            outputs: vec![0.0; program.tapes.outputs.results.len()],
            loops: (program.motion == Motion::Kinematic).then(|| Loops::new(model)),
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
        if self.registers[layout.parameters()..layout.inputs()].iter().any(|tangent| *tangent != 0.0) {
            machine.differentiate(&model.program().tapes.parameters, &mut self.registers, &mut []);
        }
        if movement == Movement::Assembled {
            initial::tangent::assemble(model, machine, &mut self.registers)?;
        }
        match self.loops {
            None => {
                machine.differentiate(&model.program().tapes.acceleration, &mut self.registers, &mut self.solved);
            }
            Some(_) => self.follow_loops(model, machine, movement)?,
        }
        self.registers[layout.accelerations()..layout.constants()].copy_from_slice(&self.solved);
        machine.differentiate(&model.program().tapes.outputs, &mut self.registers, &mut self.outputs);
        Ok(())
    }

    /// Derivatives of the motion of a driven mechanism.
    fn follow_loops(&mut self, model: &Model, machine: &mut Machine, movement: Movement) -> Result<(), Failure> {
        let Self { registers, residuals, solved, loads, jacobian, loops, .. } = self;
        let Some(loops) = loops else { return Ok(()) };
        let (tapes, layout) = (&model.program().tapes, model.layout());
        loops.factor_regular(model, machine)?;
        if movement == Movement::Continued {
            registers[motion(layout)].fill(0.0);
            for (tape, first) in [(&tapes.constraint, layout.positions()), (&tapes.constraint_rate, layout.rates())] {
                machine.differentiate(tape, registers, residuals);
                let places = registers[first..].iter_mut();
                places.zip(loops.solve(residuals)).for_each(|(place, value)| *place = -value);
            }
        }
        let n = model.coordinates();
        let (accelerations, reactions) = solved.split_at_mut(n);
        // Phi_q a = gamma
        machine.differentiate(&tapes.jacobian.tape, registers, jacobian);
        machine.differentiate(&tapes.gamma, registers, residuals);
        let entries = || tapes.jacobian.entries.iter().map(|&(row, column)| (row as usize, column as usize));
        let coordinates =
            |(&derivative, (row, column)): (&f64, (usize, usize))| (column < n).then_some((derivative, row, column));
        for (derivative, row, column) in jacobian.iter().zip(entries()).filter_map(coordinates) {
            residuals[row] -= derivative * machine.registers()[layout.accelerations() + column];
        }
        accelerations.copy_from_slice(loops.solve(residuals));
        registers[layout.accelerations()..layout.reactions()].copy_from_slice(accelerations);
        // Phi_q^T lambda = Q - M a
        reactions.fill(0.0);
        if let Some(inverse) = &tapes.inverse {
            machine.differentiate(inverse, registers, loads);
            for (derivative, row, column) in jacobian.iter().zip(entries()).filter_map(coordinates) {
                loads[column] -= derivative * machine.registers()[layout.reactions() + row];
            }
            loops.reactions(loads, reactions);
        }
        Ok(())
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
