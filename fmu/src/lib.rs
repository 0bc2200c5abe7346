//! The runtime inside every FMU that cotree exports: the model as data, its solver, the FMI functions.
//!
//! From the bottom up:
//! * [`math`], `linalg`, [`tape`]: arithmetic with the same bits everywhere, linear algebra, straight-line programs over registers.
//! * [`program`]: the model as data, what must hold for it, its file.
//! * [`model`], [`machine`]: a program ready to run, its state, the registers it runs on.
//! * [`taylor`], [`events`]: Taylor series of a motion from the arm form of its mechanism, laws in pieces and steep laws.
//! * [`motion`]: what is known of a run, as plain data.
//! * [`constraints`]: consistent initial values, projection.
//! * `hybrid`: when sampled values change, when a comparison begins to hold.
//! * [`integrator`], [`singular`]: from one communication point to the next, also through singular configurations.
//! * [`instance`]: one simulation, as the command line and the FMI functions use it.
//! * [`contain`]: where panics end.
//! * `fmi`, [`fmi2`], [`fmi3`]: the functions of FMI 2.0 and 3.0 for Co-Simulation and Model Exchange.

#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        reason = "no input may cause a panic"
    )
)]
#![allow(rustdoc::broken_intra_doc_links, reason = "square brackets hold units: [m], [rad]")]

pub mod constraints;
pub mod contain;
pub mod context;
pub mod events;
pub mod failure;
pub(crate) mod fmi;
pub mod fmi2;
pub mod fmi3;
pub(crate) mod hybrid;
pub mod instance;
pub mod integrator;
pub mod linalg;
pub mod machine;
pub mod math;
pub mod model;
pub mod motion;
mod pace;
pub mod program;
pub mod singular;
pub mod tape;
pub mod taylor;

/// Where an FMU keeps its program, relative to the root of the archive.
pub const PROGRAM_FILE: &str = "resources/program.bin";
