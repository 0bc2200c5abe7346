//! Derivatives of what can be read: along a direction of what can be set and of the states, and along the motion.

use super::{Instance, InstanceError};
use crate::constraints::tangent::Movement;
use crate::program::Source;
use crate::tape::ORDER;

/// The highest order of [`Instance::motion_derivative`].
pub const DERIVATIVE_ORDER: i32 = ORDER as i32;

/// Where the value of a calculated variable is.
enum Calculated {
    Register(usize),
    Output(usize),
}

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
        let states = self.is_running() && !program.is_driven();
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

    /// Differentiates everything by time along the motion, up to an order.
    pub fn differentiate_motion(&mut self, order: i32) -> Result<(), InstanceError> {
        self.accelerate()?;
        self.load()?;
        let seen = if self.is_shown() { &self.shown } else { &self.now.state };
        let order = order.clamp(1, DERIVATIVE_ORDER) as usize;
        self.expansion.evaluate(&self.model, &self.machine, seen, order);
        Ok(())
    }

    /// The derivative of a calculated variable along the direction, after [`Instance::differentiate`].
    pub fn derivative(&self, variable: usize) -> Result<f64, InstanceError> {
        let value = match self.calculated(variable)? {
            Calculated::Register(register) => self.tangent.registers()[register],
            Calculated::Output(result) => self.tangent.outputs()[result],
        };
        self.defined(variable, value)
    }

    /// The derivative of a calculated variable by time, after [`Instance::differentiate_motion`] up to this order.
    pub fn motion_derivative(&self, variable: usize, order: i32) -> Result<f64, InstanceError> {
        let series = match self.calculated(variable)? {
            Calculated::Register(register) => self.expansion.registers()[register],
            Calculated::Output(result) => self.expansion.outputs()[result],
        };
        self.defined(variable, series.derivative(order.clamp(1, DERIVATIVE_ORDER) as usize))
    }

    fn calculated(&self, variable: usize) -> Result<Calculated, InstanceError> {
        let layout = self.model.layout();
        let found = self.model.program().variables.get(variable);
        let found = found.ok_or(InstanceError::UnknownVariable { index: variable })?;
        Ok(match found.source {
            Source::Coordinate(index) => Calculated::Register(layout.positions() + index as usize),
            Source::Rate(index) => Calculated::Register(layout.rates() + index as usize),
            Source::Acceleration(index) => Calculated::Register(layout.accelerations() + index as usize),
            Source::Output { result, .. } => Calculated::Output(result as usize),
            Source::Discrete(index) => Calculated::Register(layout.discrete() + index as usize),
            Source::Time | Source::Parameter(_) | Source::Input(_) => {
                return Err(InstanceError::NotCalculated { name: found.name.clone() });
            }
        })
    }

    pub(super) fn defined(&self, variable: usize, value: f64) -> Result<f64, InstanceError> {
        if value.is_finite() {
            return Ok(value);
        }
        let name = self.model.program().variables[variable].name.clone();
        Err(InstanceError::NoDerivative { name, time: self.time() })
    }
}
