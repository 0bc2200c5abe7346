//! What the functions of all versions of FMI share.
//!
//! `boundary` is between C and Rust, `environment` the processor's settings, `component` the state machines over an
//! [`crate::instance::Instance`], `logging`, `resource` and `states` are what their names say. What the versions differ in is in [`component::Version`], a few
//! methods of the component, and their tables of functions: `fmi2`, `fmi3`.
//!
//! Value references are places in [`crate::program::Program::variables`], in FMI 3.0 counted from 1. A change of an input acts from its communication point on.

pub(crate) mod boundary;
pub(crate) mod component;
mod environment;
pub(crate) mod logging;
pub(crate) mod resource;
pub(crate) mod states;
