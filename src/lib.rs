//! Planar mechanisms to FMUs, in the branch coordinates of J. J. McPhee, *Mech. Mach. Theory* 33(6), 805-823, 1998.
//!
//! A [`Scene`] is read from a file or built in Rust. [`Scene::simulate`] runs its experiment with the very code that runs in an FMU,
//! [`Scene::export_fmu`] writes that FMU, [`compile`](compile()) gives what both are made of: the program, the description of its variables, the figures of
//! the mechanism. Whatever is wrong with a scene is collected and returned at once, as [`Faults`], each with its place and what to do.
//!
//! A slider-crank, simulated and written as an FMU:
//!
//! ```
//! use cotree::{Body, Scene};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let bar = |length: f64| {
//!     let body = Body::new().mass(length).inertia(length.powi(3) / 12.0);
//!     body.point("a", [-length / 2.0, 0.0]).point("b", [length / 2.0, 0.0])
//! };
//! let scene = Scene::new("slider_crank")
//!     .gravity([0.0, -9.81])
//!     .body("crank", bar(0.5))
//!     .body("rod", bar(1.5))
//!     .body("slider", Body::new().mass(3.0))
//!     .revolute("bearing", "ground", "crank.a")
//!     .revolute("crank_pin", "crank.b", "rod.a")
//!     .revolute("wrist_pin", "rod.b", "slider")
//!     .prismatic("cylinder", "ground", "slider", [1.0, 0.0])
//!     .initial("crank.angle", "35 deg")
//!     .guess("rod.angle", "-11 deg")
//!     .output("cylinder.s")
//!     .stop("0.5 s");
//!
//! // Two angles: absolute coordinates would be nine.
//! let compiled = cotree::compile(&scene)?;
//! assert_eq!(compiled.program.coordinates.len(), 2);
//!
//! let results = scene.simulate()?;
//! let stroke = results.column("cylinder.s").ok_or("no such variable")?;
//! assert_eq!(stroke.unit, "m");
//! assert!(stroke.values.iter().all(|s| (1.0..2.0).contains(s)));
//!
//! # let folder = tempfile::tempdir()?;
//! scene.export_fmu(folder.path().join("slider_crank.fmu"))?;
//! # Ok(())
//! # }
//! ```
//!
//! # The way from a scene to an FMU
//!
//! Data flows one way; each stage is a plain value that can be printed and compared:
//!
//! 1. `scene`: text, units and expressions; `component`: one file for each kind of joint, load and driver, with its row of Table 1;
//!    `mechanism`: names and values resolved.
//! 2. `graph`, `tree`: the translational and the rotational linear graph, and their spanning trees (Tables 2 and 3, a preset, or the user's).
//! 3. `equations`: cutsets and circuits projected, secondary variables eliminated, M, Q, Phi, Phi_q and gamma assembled over the shared
//!    expressions of `expr`; `formulate` finds trees and the initial pose.
//! 4. `lower`: elimination in a safe order, tapes, series: a [`cotree_fmu::program::Program`].
//! 5. `export`: `modelDescription.xml` and the archive around that program and the runtime (package `cotree-fmu`).
//!
//! `simulate` runs it, `analysis` finds equilibria, linear systems and modes, `output` shows and measures, `cli` is the command line. These
//! rooms are public for the command and the tests of this repository; what others may rely on is listed below.

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

// Public for the command and the tests of this repository.
#[doc(hidden)]
pub mod analysis;
#[doc(hidden)]
pub mod cli;
#[doc(hidden)]
pub mod compile;
#[doc(hidden)]
pub mod component;
#[doc(hidden)]
pub mod diagnostic;
#[doc(hidden)]
pub mod equations;
#[doc(hidden)]
pub mod export;
#[doc(hidden)]
pub mod expr;
mod files;
#[doc(hidden)]
pub mod formulate;
#[doc(hidden)]
pub mod graph;
#[doc(hidden)]
pub mod lower;
#[doc(hidden)]
pub mod mechanism;
#[doc(hidden)]
pub mod output;
mod resolve;
#[doc(hidden)]
pub mod scene;
#[doc(hidden)]
pub mod simulate;
#[doc(hidden)]
pub mod tree;

pub use compile::{Compiled, ExportFailure, Notation, compile, equations};
pub use diagnostic::{Fault, Faults, Severity};
pub use scene::{Body, Driver, Joint, Load, Scene};
pub use simulate::{Column, Results, RunError, SimulateError};

/// The README's Rust code is compiled by the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
