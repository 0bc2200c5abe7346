//! The functions of FMI 2.0 for Co-Simulation and Model Exchange (FMI standard 2.0.4, chapters 2.1, 3.2 and 4.2).
//!
//! [`types`] are the C types; `functions` are what the importer calls; `component` is what this version asks of the component that all versions
//! share (`crate::fmi`); `logging` and `resource` are what their names say.
//!
//! Every variable is a Real. Derivatives of inputs (orders 1 and 2) hold from the communication point at which they are set until the input is
//! set again at a later one without them: then they are zero again.

mod component;
mod functions;
mod logging;
mod resource;
pub mod types;

pub use functions::*;
