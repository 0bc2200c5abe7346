//! Taylor series in time of everything that can be read, at one state: derivatives of outputs of any order up to [`ORDER`].
//!
//! The accelerations are evaluated on series; each round adds one order to them, and so one to the rates and positions.

use crate::machine::Machine;
use crate::model::{Model, State};
use crate::program::FollowerOrder;
use crate::tape::{ORDER, Series, Tape};

/// A register file of series, allocated when it is first needed.
#[derive(Clone, Debug, Default)]
pub struct Expansion {
    registers: Vec<Series>,
    outputs: Vec<Series>,
}

impl Expansion {
    /// Expands everything up to an order about the state in the registers of the machine, with its accelerations and reactions.
    pub fn evaluate(&mut self, model: &Model, machine: &Machine, state: &State, order: usize) {
        self.begin(model, machine, state);
        self.integrate(model, order);
        let Self { registers, outputs, .. } = self;
        copy_results(&model.program().tapes.outputs, registers, outputs);
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
        let program = model.program();
        if self.registers.is_empty() {
            self.registers = vec![Series::default(); program.registers as usize];
            self.outputs = vec![Series::default(); program.tapes.outputs.results.len()];
        }
    }

    /// Order by order, q and v from the accelerations.
    fn integrate(&mut self, model: &Model, order: usize) {
        let (tape, layout) = (&model.program().tapes.acceleration, model.layout());
        let Self { registers, .. } = self;
        for k in 0..=order {
            tape.run_series(registers);
            for index in (0..model.coordinates()).filter(|_| k < ORDER) {
                let acceleration = registers[tape.results[index] as usize].0[k];
                let rate = registers[layout.rates() + index].0[k];
                registers[layout.rates() + index].0[k + 1] = acceleration / (k + 1) as f64;
                registers[layout.positions() + index].0[k + 1] = rate / (k + 1) as f64;
            }
        }
        for (place, &result) in (layout.accelerations()..layout.constants()).zip(&tape.results) {
            registers[place] = registers[result as usize];
        }
    }
}

fn copy_results(tape: &Tape, registers: &mut [Series], results: &mut [Series]) {
    tape.run_series(registers);
    results.iter_mut().zip(&tape.results).for_each(|(place, &register)| *place = registers[register as usize]);
}
