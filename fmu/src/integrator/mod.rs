//! From a consistent initial state to the state at any later time.
//!
//! * [`stepping`]: from one communication point to the next.
//! * `taylor`, `explicit` (DOP853), `implicit` (Radau IIA): the methods, each with what it remembers between steps.
//! * `control`: bounds of the length of a step; `stiffness`: which method takes the next step.
//! * `together`: steps of several runs at once.
//! * `accuracy`: how accurate rounding errors let a motion be.
//! * `run`: what a run remembers between communication points: `signals`, the `last_step`, and the memories of the methods.
//! * `right_hand_side`: the equations of motion, as the Runge-Kutta methods see them.

pub(crate) mod accuracy;
pub(crate) mod control;
pub(crate) mod explicit;
pub(crate) mod implicit;
pub(crate) mod last_step;
pub(crate) mod right_hand_side;
pub(crate) mod run;
pub(crate) mod signals;
pub mod stepping;
pub(crate) mod stiffness;
pub(crate) mod taylor;
pub(crate) mod together;
