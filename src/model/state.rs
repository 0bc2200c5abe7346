//! States beside those of the motion: currents, pressures, temperatures, integrals of controllers.

use super::{Formula, Unit, Variable};
use crate::diagnostic::Span;

/// A quantity z whose rate is given: z' = g(q, v, z, u, t). Joined to Eq. (22) of McPhee 1998, whose {Q} may depend on it.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// The user's name.
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    /// Its unit; the empty unit if it is not known.
    pub unit: Unit,
    /// Its value at the start; constants and parameters only.
    pub start: Formula,
    /// Its rate; positions, velocities, inputs, the time and all states may occur.
    pub rate: Formula,
    /// Its usual size, SI: tolerances are relative to it.
    pub nominal: f64,
    /// What it is of a component that brings it, such as the current of a motor.
    pub variable: Option<Variable>,
    /// Where it stands in the file.
    pub span: Span,
}
