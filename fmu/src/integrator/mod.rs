//! From a consistent initial state to the state at any later time.
//!
//! * [`stepping`]: from one communication point to the next.
//! * `taylor`, `explicit` (DOP853), `implicit` (Radau IIA): the methods, each with what it remembers between steps.
//! * `control`: bounds of the length of a step; `stiffness`: which method takes the next step.
//! * `accuracy`: how accurate rounding errors let a motion be.
//! * `times`: steps that end where a law jumps at a time known beforehand; `together`: comparisons that rounding errors decide.
//! * `memory`: what the methods remember of a run between steps.
//! * `right_hand_side`, `range`: the equations of motion, as the Runge-Kutta methods see them; [`accelerations`]: at a state.

pub mod accelerations;
pub(crate) mod accuracy;
pub(crate) mod control;
pub(crate) mod explicit;
pub(crate) mod implicit;
pub(crate) mod memory;
pub(crate) mod range;
pub(crate) mod right_hand_side;
pub mod stepping;
pub(crate) mod stiffness;
pub(crate) mod taylor;
mod times;
mod together;
