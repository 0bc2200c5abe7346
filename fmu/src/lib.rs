//! The runtime inside every FMU that cotree exports: the model as data, its solver, the FMI functions.

pub mod math;
pub mod program;
pub mod tape;
