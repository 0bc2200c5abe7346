//! Planar mechanisms to FMUs, in the branch coordinates of J. J. McPhee, *Mech. Mach. Theory* 33(6), 805-823, 1998.
//!
//! Data flows one way; each stage is a plain value that can be printed and compared:
//!
//! 1. [`scene`]: a scene file or the Rust builder, with every fault at its place; [`mechanism`]: the same with names, units and
//!    expressions resolved.
//! 2. [`element`]: each component's row of Table 1; together they form the translational and the rotational [`graph`].
//! 3. [`tree`]: the spanning trees (Tables 2 and 3, a preset, or the user's), and with them the branch coordinates.
//! 4. [`equations`]: cutsets and circuits projected, secondary variables eliminated, M, Q, Phi, Phi_q and gamma assembled, over
//!    the shared expressions of [`expr`].
//! 5. [`lower`]: elimination in a safe order, tapes, the table of variables: a [`cotree_fmu::program::Program`].
//! 6. [`export`]: `modelDescription.xml` and the archive around that program and the runtime (package `cotree-fmu`).
//!
//! [`pipeline`] joins the stages; [`simulation`] runs the very code that the FMU runs; [`analysis`] finds equilibria, linear systems and
//! modes; [`mod@bench`] measures; [`mod@print`] and [`report`] show; [`cli`] is the
//! command line.
//!
//! A slider-crank, simulated for its experiment and written as an FMU:
//!
//! ```
//! use cotree::pipeline::compile;
//! use cotree::scene::{Body, Scene};
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
//! let compiled = compile(&scene)?;
//! // Two angles: absolute coordinates would be nine.
//! assert_eq!(compiled.summary.counts.used.coordinates, 2);
//!
//! let mut last = 0.0;
//! compiled.simulate(|_time, values| {
//!     last = values[0];
//!     Ok(())
//! })?;
//! assert!(last > 1.0 && last < 2.0);
//!
//! # let folder = tempfile::tempdir()?;
//! scene.export_fmu(folder.path().join("slider_crank.fmu"))?;
//! # Ok(())
//! # }
//! ```

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

pub mod analysis;
mod assembly;
pub mod bench;
pub mod cheapest;
pub mod cli;
pub mod element;
pub mod equations;
pub mod export;
pub mod expr;
mod files;
pub mod formulate;
pub mod graph;
pub mod lower;
pub mod mechanism;
pub mod pipeline;
pub mod print;
pub mod report;
pub mod scene;
pub mod simulation;
mod size;
mod start;
mod translate;
pub mod tree;

/// The README's Rust code is compiled by the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
