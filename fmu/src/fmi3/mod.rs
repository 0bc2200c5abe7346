//! The functions of FMI 3.0 for Co-Simulation and Model Exchange (FMI standard 3.0.2, chapters 2 to 4).
//!
//! [`types`] are the C types; `functions` are what the importer calls; `component` is what this version asks of the component that all versions
//! share (`crate::fmi`); [`references`] says what belongs to which value reference; `logging` is what its name says.
//!
//! Every variable is a Float64. An illegal argument or call is an error, after which the instance is terminated (2.2.4, 2.3.1). Derivatives of
//! inputs are inputs themselves and keep their values as those do: an input with derivatives goes on along its polynomial.

mod component;
mod functions;
mod logging;
pub mod references;
pub mod types;

pub use functions::*;

/// The instantiation token of a program with this GUID. It is another text: a description of FMI 2.0 does not fit the functions of FMI 3.0.
pub fn token(guid: &str) -> String {
    format!("{guid}-fmi3")
}
