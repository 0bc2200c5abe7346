//! Singular configurations: poses at which the loop equations depend on each other and branches of the motion may cross.
//!
//! * `detect`: how far they are, and where.
//! * `crossing`, `passing`: whether branches meet there, and what a run notes of it.
//! * `branch`, `leaving`: which way leads on, and whether the run stayed on it.
//! * `dependence`: what is said where there is no way.

pub(crate) mod branch;
pub(crate) mod crossing;
pub(crate) mod dependence;
pub(crate) mod detect;
pub(crate) mod leaving;
pub(crate) mod passing;
