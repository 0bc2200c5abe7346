//! The constraint equations of a mechanism and what follows from them at one state.
//!
//! * [`initial`]: the first state that fulfils them.
//! * [`projection`]: back onto the loop equations after a step.
//! * [`expansion`], [`tangent`]: derivatives of the motion by time and by the independent inputs.
//! * `reciprocals`: how close loop equations are to depending on each other.
//! * `domains`: which law has no value.
//! * [`poses`]: the loop equations as equations for the pose.

pub(crate) mod domains;
pub mod expansion;
pub mod initial;
pub mod poses;
pub mod projection;
pub(crate) mod reciprocals;
pub mod tangent;
