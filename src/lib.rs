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
//! ```
//! use cotree::scene::{Body, Scene};
//!
//! let scene = Scene::new("pendulum")
//!     .gravity([0.0, -9.81])
//!     .body("bob", Body::new().mass(1.0).inertia(0.0).point("pivot", [-1.0, 0.0]))
//!     .revolute("hinge", "ground", "bob.pivot")
//!     .initial("bob.angle", "30 deg")
//!     .output("bob.angle");
//! let compiled = cotree::pipeline::compile(&scene)?;
//! assert_eq!(compiled.summary.counts.used.coordinates, 1);
//! # Ok::<(), cotree::scene::Faults>(())
//! ```

pub mod analysis;
pub mod assembly;
pub mod bench;
pub mod cheapest;
pub mod cli;
pub mod element;
pub mod equations;
pub mod export;
pub mod expr;
pub mod files;
pub mod formulate;
pub mod graph;
pub mod lower;
pub mod mechanism;
pub mod pipeline;
pub mod print;
pub mod report;
pub mod scene;
pub mod simulation;
pub mod size;
pub mod start;
pub mod translate;
pub mod tree;

/// The README's Rust code is compiled by the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
