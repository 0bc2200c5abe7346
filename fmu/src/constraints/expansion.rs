//! Taylor series in time of everything that can be read, at one state: derivatives of outputs of any order up to [`ORDER`].
//!
//! The accelerations are evaluated on series; each round adds one order to them, and so one to the rates and positions. With kinematic
//! motion they follow from Phi_q a = gamma, and the reactions from Phi_q^T lambda = Q - M a, order by order with one factorisation.

use super::loops::Loops;
use crate::failure::Failure;
use crate::machine::Machine;
use crate::model::{Model, State};
use crate::program::{FollowerOrder, Motion};
use crate::tape::{ORDER, Series, Tape};

/// A register file of series, allocated when it is first needed.
#[derive(Clone, Debug, Default)]
pub struct Expansion {
    registers: Vec<Series>,
    outputs: Vec<Series>,
    jacobian: Vec<Series>,
    /// gamma, by loop equations.
    gamma: Vec<Series>,
    /// Q - M a, by coordinates.
    loads: Vec<Series>,
    /// One order of a right side.
    right: Vec<f64>,
    /// One order of the reactions.
    reactions: Vec<f64>,
    loops: Option<Loops>,
}

impl Expansion {
    /// Expands everything up to an order about the state in the registers of the machine, with its accelerations and reactions.
    pub fn evaluate(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        state: &State,
        order: usize,
    ) -> Result<(), Failure> {
        self.begin(model, machine, state);
        match model.program().motion {
            Motion::Dynamic => self.integrate(model, order),
            Motion::Kinematic => self.follow_loops(model, machine, order)?,
        }
        let Self { registers, outputs, .. } = self;
        copy_results(&model.program().tapes.outputs, registers, outputs);
        Ok(())
    }

    /// The series of all registers up to the constants.
    pub fn registers(&self) -> &[Series] {
        &self.registers
    }

    /// The series of the results of the output tape.
    pub fn outputs(&self) -> &[Series] {
        &self.outputs
    }

    /// Constants, signals, and what is known of the motion.
    fn begin(&mut self, model: &Model, machine: &Machine, state: &State) {
        self.allocate(model);
        let layout = *model.layout();
        let Self { registers, .. } = self;
        for (series, &value) in registers.iter_mut().zip(machine.registers()) {
            *series = Series::constant(value);
        }
        registers[layout.time()].0[1] = 1.0;
        let input = |index: usize| {
            let [value, rate, acceleration] = state.input_polynomial(index);
            Series([value, rate, acceleration / 2.0, 0.0, 0.0])
        };
        for index in 0..model.program().inputs.len() {
            let series = input(index);
            registers[layout.inputs() + index] = series;
            registers[layout.input_rates() + index] = series.rate();
            registers[layout.input_accelerations() + index] = series.rate().rate();
        }
        for (index, follower) in model.program().followers.iter().enumerate() {
            let signal = input(follower.input as usize);
            let [position, rate] = [state.follower_positions()[index], state.follower_rates()[index]];
            let rate = match follower.order {
                FollowerOrder::Velocity => signal,
                FollowerOrder::Acceleration => signal.integral(rate),
            };
            registers[layout.followers() + index] = rate.integral(position);
            registers[layout.follower_rates() + index] = rate;
            registers[layout.follower_accelerations() + index] = rate.rate();
        }
    }

    fn allocate(&mut self, model: &Model) {
        let (program, n) = (model.program(), model.coordinates());
        if self.registers.is_empty() {
            self.registers = vec![Series::default(); program.registers as usize];
            self.outputs = vec![Series::default(); program.tapes.outputs.results.len()];
            if program.motion == Motion::Kinematic {
                self.jacobian = vec![Series::default(); program.tapes.jacobian.entries.len()];
                self.gamma = vec![Series::default(); program.constraints.len()];
                self.loads = vec![Series::default(); n];
                self.right = vec![0.0; n.max(program.constraints.len())];
                self.reactions = vec![0.0; program.constraints.len()];
                self.loops = Some(Loops::new(model));
            }
        }
    }

    /// One more order of q and v from an order of the accelerations.
    fn advance(&mut self, model: &Model, k: usize, acceleration: impl Fn(&[Series], usize) -> f64) {
        let layout = model.layout();
        for index in 0..model.coordinates() {
            let value = acceleration(&self.registers, index);
            self.registers[layout.accelerations() + index].0[k] = value;
            if k < ORDER {
                let rate = self.registers[layout.rates() + index].0[k];
                self.registers[layout.rates() + index].0[k + 1] = value / (k + 1) as f64;
                self.registers[layout.positions() + index].0[k + 1] = rate / (k + 1) as f64;
            }
        }
    }

    fn integrate(&mut self, model: &Model, order: usize) {
        let (tape, layout) = (&model.program().tapes.acceleration, model.layout());
        for k in 0..=order {
            tape.run_series(&mut self.registers);
            self.advance(model, k, |registers, index| registers[tape.results[index] as usize].0[k]);
        }
        for (place, &result) in (layout.accelerations()..layout.constants()).zip(&tape.results) {
            self.registers[place] = self.registers[result as usize];
        }
    }

    /// Phi_q a = gamma, then Phi_q^T lambda = Q - M a.
    fn follow_loops(&mut self, model: &Model, machine: &mut Machine, order: usize) -> Result<(), Failure> {
        let Some(mut loops) = self.loops.take() else { return Ok(()) };
        let factored = loops.factor_regular(model, machine);
        if factored.is_ok() {
            self.accelerate(model, &mut loops, order);
            self.react(model, &mut loops, order);
        }
        self.loops = Some(loops);
        factored
    }

    fn accelerate(&mut self, model: &Model, loops: &mut Loops, order: usize) {
        let (tapes, layout, n) = (&model.program().tapes, *model.layout(), model.coordinates());
        for k in 0..=order {
            let Self { registers, jacobian, gamma, right, .. } = self;
            copy_results(&tapes.jacobian.tape, registers, jacobian);
            copy_results(&tapes.gamma, registers, gamma);
            right.iter_mut().zip(gamma.iter()).for_each(|(right, gamma)| *right = gamma.0[k]);
            for (entry, &(row, column)) in jacobian.iter().zip(&tapes.jacobian.entries) {
                if (column as usize) < n {
                    let known = &registers[layout.accelerations() + column as usize];
                    right[row as usize] -= (1..=k).map(|j| entry.0[j] * known.0[k - j]).sum::<f64>();
                }
            }
            let solved = loops.solve(&self.right[..self.gamma.len()]);
            self.advance(model, k, |_, index| solved[index]);
        }
    }

    fn react(&mut self, model: &Model, loops: &mut Loops, order: usize) {
        let (tapes, layout, n) = (&model.program().tapes, *model.layout(), model.coordinates());
        let Some(inverse) = &tapes.inverse else { return };
        let Self { registers, jacobian, loads, right, reactions, .. } = self;
        copy_results(inverse, registers, loads);
        for k in 0..=order {
            right.iter_mut().zip(loads.iter()).for_each(|(right, load)| *right = load.0[k]);
            for (entry, &(row, column)) in jacobian.iter().zip(&tapes.jacobian.entries) {
                if (column as usize) < n {
                    let known = &registers[layout.reactions() + row as usize];
                    right[column as usize] -= (1..=k).map(|j| entry.0[j] * known.0[k - j]).sum::<f64>();
                }
            }
            loops.reactions(&right[..n], reactions);
            let places = registers[layout.reactions()..].iter_mut();
            places.zip(reactions.iter()).for_each(|(place, reaction)| place.0[k] = *reaction);
        }
    }
}

fn copy_results(tape: &Tape, registers: &mut [Series], results: &mut [Series]) {
    tape.run_series(registers);
    results.iter_mut().zip(&tape.results).for_each(|(place, &register)| *place = registers[register as usize]);
}
