//! From a compiled mechanism to an FMU file.

pub mod runtime;
