//! A point of the motion: the values of all symbols.

use cotree::expr::{Symbol, Values};
use cotree::tape::symbol_register;
use cotree_fmu::integrator::accelerations::Accelerations;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::{Model, State};
use cotree_fmu::program::Layout;

use super::AnalysisFailure;

/// Values of all symbols: time, parameters, inputs, followers, q, v, a and lambda.
#[derive(Clone, Debug)]
pub struct OperatingPoint {
    layout: Layout,
    /// The first part of the register file, up to and with the reactions.
    registers: Vec<f64>,
    /// True for a point at rest.
    rests: bool,
}

impl OperatingPoint {
    /// A moving point: accelerations and reactions follow from the state.
    ///
    /// # Errors
    /// The accelerations are not determined.
    pub fn moving(model: &Model, state: &State) -> Result<Self, AnalysisFailure> {
        let mut machine = Machine::new(model);
        machine.load(model, state);
        Accelerations::new(model).evaluate(model, &mut machine)?;
        let layout = *model.layout();
        Ok(OperatingPoint { layout, registers: machine.registers()[..layout.constants()].to_vec(), rests: false })
    }

    /// A point at rest in the pose of a state, with inputs that do not change and without reactions.
    pub fn resting(model: &Model, state: &State) -> Self {
        let layout = *model.layout();
        let mut registers = vec![0.0; layout.constants()];
        let kept = [
            0..layout.input_rates(), // time, parameters, discrete variables, inputs
            layout.followers()..layout.follower_rates(),
            layout.positions()..layout.rates(),
            layout.states()..layout.accelerations(),
        ];
        for range in kept {
            registers[range.clone()].copy_from_slice(&state.registers()[range]);
        }
        OperatingPoint { layout, registers, rests: true }
    }

    /// Time \[s\].
    pub fn time(&self) -> f64 {
        self.registers[self.layout.time()]
    }

    /// True for a point at rest: there nothing slides, and what rubs with all that it can sticks, too.
    pub(super) fn rests(&self) -> bool {
        self.rests
    }

    /// Sets a discrete variable: its place, and its value.
    pub(super) fn set_discrete(&mut self, (index, value): (usize, f64)) {
        let place = symbol_register(&self.layout, Symbol::Discrete(index));
        self.registers[place] = value;
    }

    pub fn positions(&self) -> &[f64] {
        &self.registers[self.layout.positions()..self.layout.rates()]
    }

    pub fn positions_mut(&mut self) -> &mut [f64] {
        &mut self.registers[self.layout.positions()..self.layout.rates()]
    }

    /// States of the scene, to be changed.
    pub fn states_mut(&mut self) -> &mut [f64] {
        &mut self.registers[self.layout.states()..self.layout.accelerations()]
    }

    /// States of the scene.
    pub fn states(&self) -> &[f64] {
        &self.registers[self.layout.states()..self.layout.accelerations()]
    }

    /// The reactions of all loop equations, to be changed.
    pub fn reactions_mut(&mut self) -> &mut [f64] {
        &mut self.registers[self.layout.reactions()..self.layout.constants()]
    }
}

impl Values for OperatingPoint {
    fn value(&self, symbol: Symbol) -> f64 {
        match symbol {
            // Only kinematic scenes lack masses, and then nothing that was asked for needs them.
            Symbol::Missing(..) => 0.0,
            Symbol::Time
            | Symbol::Parameter(_)
            | Symbol::Discrete(_)
            | Symbol::Input(..)
            | Symbol::Follower(..)
            | Symbol::Coordinate(..)
            | Symbol::State(..)
            | Symbol::Reaction(_)
            | Symbol::Argument => self.registers[symbol_register(&self.layout, symbol)],
        }
    }
}
