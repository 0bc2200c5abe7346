//! Planar mechanisms to simulation models: equations of motion in the branch coordinates of J. J. McPhee (*Mech. Mach. Theory* 33(6), 805-823,
//! 1998), and FMUs that hold them.
//!
//! A [`Scene`] describes bodies, joints, drivers and loads. It is read from TOML or JSON, or built in Rust. [`Scene::simulate`] runs its
//! experiment with the code that runs in an FMU; [`Scene::export_fmu`] writes the FMU; [`compile()`] gives what both are made of.
//! Printed equations, pictures and studies are crates of their own, `cotree-text`, `cotree-draw` and `cotree-study`.
//!
//! # From a text to results
//!
//! Results are found by the names of the scene, each with its unit:
//!
//! ```
//! use cotree::Scene;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = Scene::from_toml(
//!     r#"
//!     name    = "pendulum"
//!     gravity = [0.0, -9.81]
//!
//!     [bodies.bar]
//!     points = { top = [0.0, 0.0], end = ["500 mm", 0.0] }
//!     shape  = { rod = ["top", "end"], density = "2 kg/m" }
//!
//!     [joints.hinge]
//!     type    = "revolute"
//!     between = ["ground", "bar.top"]
//!
//!     [initial]
//!     "bar.angle" = "-60 deg"
//!
//!     [outputs]
//!     variables = ["bar.angle", "hinge.fy", "energy.total"]
//!
//!     [experiment]
//!     stop = "2 s"
//!     "#,
//! )?;
//! let results = scene.simulate()?;
//! let angle = results.column("bar.angle").ok_or("no such variable")?;
//! assert_eq!(angle.unit, "rad");
//! // It hangs at -90 degrees and swings by 30 to either side.
//! let lowest = angle.values.iter().copied().fold(f64::MAX, f64::min);
//! assert!((lowest.to_degrees() + 120.0).abs() < 0.01);
//! assert_eq!(results.times().len(), angle.values.len());
//! # Ok(())
//! # }
//! ```
//!
//! # From Rust to an FMU
//!
//! The words of the builder are those of the file. Where a number is wanted, `0.5`, `"500 mm"` and `"length/2"` will do:
//!
//! ```
//! use cotree::{Body, Scene, Shape};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let bar = |length: f64| {
//!     let body = Body::new().point("a", [0.0, 0.0]).point("b", [length, 0.0]);
//!     body.shape(Shape::rod("a", "b").density("1 kg/m"))
//! };
//! let scene = Scene::new("slider_crank")
//!     .gravity([0.0, -9.81])
//!     .parameter("piston_mass", "3 kg")
//!     .body("crank", bar(0.5))
//!     .body("rod", bar(1.5))
//!     .body("slider", Body::new().mass("piston_mass"))
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
//! # let folder = tempfile::tempdir()?;
//! scene.export_fmu(folder.path().join("slider_crank.fmu"))?;
//! # Ok(())
//! # }
//! ```
//!
//! # Errors
//!
//! Whatever is wrong with a scene is collected and returned at once, as [`Faults`]: each [`Fault`] has a code, a place in the text and what to do.
//! [`Faults::render`] shows them with the lines they are about, [`Faults::to_json`] gives them to editors. No scene causes a panic.
//!
//! ```
//! # fn main() -> Result<(), cotree::Faults> {
//! let scene = cotree::Scene::from_toml("name = 'a'\n[bodies.bar]\nmas = 2")?;
//! let faults = cotree::compile(&scene).map(|_| ()).unwrap_err();
//! assert!(faults.render(false, 80).contains("did you mean `mass`?"));
//! # Ok(())
//! # }
//! ```
//!
//! A run can fail for reasons of its own ([`RunError`], [`SimulateError`]): a singular pose without a way on, laws without a finite value. Export
//! has [`ExportFailure`].
//!
//! # Where things are
//!
//! | | |
//! |---|---|
//! | what a scene can have | [`Scene`], [`Body`], [`Shape`], [`Joint`], [`Driver`], [`Load`], [`Parameter`], [`Input`] |
//! | numbers, vectors, places | [`Quantity`], [`Vector`], [`Corner`] |
//! | faults | [`Faults`], [`Fault`], [`Severity`] |
//! | results | [`Results`], [`Column`]; of many runs at once [`Scene::simulate_many`] |
//! | programs | [`compile()`], [`Compiled`] |
//!
//! The repository has a reference of the scene (`docs/scene-reference.md`), a page for each method in `docs`, and a map of the sources in
//! `CONTRIBUTING.md`. The other modules are public for the other crates and the tests of that repository only.

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

// Public for the crates above, the command and the tests of this repository.
#[doc(hidden)]
pub mod arms;
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
#[doc(hidden)]
pub mod files;
#[doc(hidden)]
pub mod formulate;
#[doc(hidden)]
pub mod gallery;
#[doc(hidden)]
pub mod import;
#[doc(hidden)]
pub mod laws;
#[doc(hidden)]
pub mod model;
#[doc(hidden)]
pub mod network;
#[doc(hidden)]
pub mod program;
#[doc(hidden)]
pub mod redundancy;
#[doc(hidden)]
pub mod report;
#[doc(hidden)]
pub mod resolve;
#[doc(hidden)]
pub mod run;
#[doc(hidden)]
pub mod scene;
#[doc(hidden)]
pub mod sheet;
#[doc(hidden)]
pub mod solve;
#[doc(hidden)]
pub mod tape;
#[doc(hidden)]
pub mod task;
#[doc(hidden)]
pub mod typeset;

pub use compile::{Compiled, ExportFailure, compile};
pub use diagnostic::{Fault, Faults, Severity};
pub use run::{Column, Results, RunError, SimulateError};
pub use scene::{
    Body, Corner, Driver, Input, InputAs, Joint, Load, Motion, Parameter, Quantity, Scene, Shape, Side, Solver, Vector,
};

/// The README's Rust code is compiled by the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
