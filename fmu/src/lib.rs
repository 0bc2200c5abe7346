//! The runtime inside every FMU that cotree exports: the model as data, its solver, the FMI functions.
//!
//! From the bottom up:
//! * [`math`], [`tape`]: arithmetic with the same bits everywhere, and straight-line programs over registers.
//! * [`program`], [`check`], [`storage`]: the model as data, what must hold for it, its file.
//! * [`model`], [`machine`]: a program ready to run, its state, the registers it runs on.
//! * [`series`]: Taylor series of a motion from the arm form of its mechanism.
//! * [`solver`]: consistent initial values, projection, integration, kinematic motion, communication points.
//! * [`instance`]: one simulation, as the command line and the FMI functions use it.
//! * [`fmi2`]: the functions of FMI 2.0 for Co-Simulation and Model Exchange.

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

pub mod check;
pub mod fmi2;
mod frame;
pub mod instance;
pub mod machine;
pub mod math;
pub mod model;
pub mod program;
pub mod series;
pub mod solver;
pub mod storage;
pub mod tape;

/// Where an FMU keeps its program, relative to the root of the archive.
pub const PROGRAM_FILE: &str = "resources/program.bin";
