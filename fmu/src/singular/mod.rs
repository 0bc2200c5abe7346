//! Singular configurations: poses at which the loop equations depend on each other and branches of the motion may cross.
//!
//! * `reciprocals`, `detect`: how far they are, and where.
//! * `supervisor`: what a run knows of them.
//! * `crossing`, `passing`: whether branches meet there, and what is said of it.
//! * `branch`, `leaving`: which way leads on, and whether the run stayed on it.
//! * `dependence`: what is said where there is no way.

pub(crate) mod branch;
pub(crate) mod crossing;
pub(crate) mod dependence;
pub(crate) mod detect;
pub(crate) mod leaving;
pub(crate) mod passing;
pub(crate) mod reciprocals;
pub(crate) mod supervisor;

pub use passing::Passage;
