//! Derivatives of what can be read: along a direction of what can be set and of the states, and along the motion.

use super::{Instance, InstanceError};
use crate::program::{Motion, Source};
use crate::solver::tangent::Movement;

/// The highest order of [`Instance::motion_derivative`].
pub const DERIVATIVE_ORDER: i32 = 1;

impl Instance {
    /// Starts a direction along which [`Instance::derivative`] differentiates.
    pub fn begin_direction(&mut self) {
        self.tangent.begin();
    }

    /// Adds a change of a variable to the direction: of a parameter, an input, or a state of dynamic motion. Before initialisation the
    /// state follows from the initial values, which then take its place.
    pub fn add_direction(&mut self, variable: usize, change: f64) -> Result<(), InstanceError> {
        let register = self.known_register(variable)?;
        self.tangent.direction()[register] += change;
        Ok(())
    }

    fn known_register(&self, variable: usize) -> Result<usize, InstanceError> {
        let (program, layout) = (self.model.program(), self.model.layout());
        let found = program.variables.get(variable).ok_or(InstanceError::UnknownVariable { index: variable })?;
        if !self.is_running()
            && let Some(parameter) = found.initial
        {
            return Ok(layout.parameters() + parameter as usize);
        }
        let states = self.is_running() && program.motion == Motion::Dynamic;
        match found.source {
            Source::Parameter(index) => Ok(layout.parameters() + index as usize),
            Source::Input(index) => Ok(layout.inputs() + index as usize),
            Source::Coordinate(index) if states => Ok(layout.positions() + index as usize),
            Source::Rate(index) if states => Ok(layout.rates() + index as usize),
            _ => Err(InstanceError::NotIndependent { name: found.name.clone() }),
        }
    }

    /// Differentiates everything along the direction at the present state.
    pub fn differentiate(&mut self) -> Result<(), InstanceError> {
        let movement = if self.is_running() { Movement::Continued } else { Movement::Assembled };
        self.accelerate()?;
        self.load()?;
        self.tangent.evaluate(&self.model, &mut self.machine, movement)?;
        Ok(())
    }

    /// Differentiates everything along the motion.
    pub fn differentiate_motion(&mut self) -> Result<(), InstanceError> {
        self.accelerate()?;
        self.load()?;
        let seen = if self.is_shown() { &self.shown } else { &self.now.state };
        self.tangent.begin_motion(&self.model, seen, self.accelerations.accelerations());
        self.tangent.evaluate(&self.model, &mut self.machine, Movement::Continued)?;
        Ok(())
    }

    /// The derivative of a calculated variable, after [`Instance::differentiate`] or [`Instance::differentiate_motion`].
    pub fn derivative(&self, variable: usize) -> Result<f64, InstanceError> {
        let layout = self.model.layout();
        let found = self.model.program().variables.get(variable);
        let found = found.ok_or(InstanceError::UnknownVariable { index: variable })?;
        let registers = self.tangent.registers();
        let value = match found.source {
            Source::Coordinate(index) => registers[layout.positions() + index as usize],
            Source::Rate(index) => registers[layout.rates() + index as usize],
            Source::Acceleration(index) => registers[layout.accelerations() + index as usize],
            Source::Output { result, .. } => self.tangent.outputs()[result as usize],
            Source::Time | Source::Parameter(_) | Source::Input(_) => {
                return Err(InstanceError::NotCalculated { name: found.name.clone() });
            }
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(InstanceError::NoDerivative { name: found.name.clone(), time: self.time() })
        }
    }
}
