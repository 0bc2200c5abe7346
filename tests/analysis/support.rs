//! What the tests of the analysis share.

use cotree::formulate::{Formulated, formulate};
use cotree::scene::Resolved;
use cotree_fmu::model::Model;
use cotree_study::analysis::{AnalysisFailure, Equilibrium, OperatingPoint, StateSpace, Variation, at_rest};

pub use super::run::{block_with_law, scene_of};
use super::run::{formulated, resolved};

/// A compound pendulum; `GUESS` is to be replaced.
pub const PENDULUM: &str = r#"
    format = 1
    name = "pendulum"
    gravity = [0, -9.81]
    [bodies.arm]
    mass = 2.0
    inertia = 0.3
    points = { pivot = [-0.7, 0] }
    [joints.pivot]
    type = "revolute"
    between = ["ground", "arm.pivot"]
    [initial]
    "arm.angle" = "GUESS"
"#;

/// Formulates a scene.
pub fn with<T>(text: &str, then: impl FnOnce(&mut Formulated) -> T) -> T {
    then(&mut formulated(&resolved(text)))
}

/// The equilibrium of a scene.
pub fn resting<T>(
    text: &str,
    then: impl FnOnce(&mut Formulated, &Variation, Result<Equilibrium, AnalysisFailure>) -> T,
) -> T {
    let Resolved { mechanism, outputs, .. } = resolved(text);
    let mut formulated = formulate(&at_rest(&mechanism), &outputs).unwrap();
    let variation = Variation::new(&mut formulated);
    let equilibrium = Equilibrium::find(&formulated, &variation, &[]);
    then(&mut formulated, &variation, equilibrium)
}

/// The linear system at the equilibrium of a scene.
pub fn at_equilibrium(text: &str, then: impl FnOnce(&Formulated, &StateSpace)) {
    resting(text, |formulated, variation, equilibrium| {
        let point = equilibrium.unwrap().point;
        then(formulated, &StateSpace::new(formulated, variation, &point, None).unwrap());
    });
}

/// The linear system at the start of the motion.
pub fn at_start(formulated: &mut Formulated) -> StateSpace {
    let variation = Variation::new(formulated);
    let model = Model::new(formulated.lowered.program.clone()).unwrap();
    let point = OperatingPoint::moving(&model, &formulated.state).unwrap();
    StateSpace::new(formulated, &variation, &point, None).unwrap()
}

/// Within a share of the expected value or of a typical one.
pub fn close(name: &str, value: f64, expected: f64, share: f64, typical: f64) {
    let permitted = share * (expected.abs() + typical.max(1.0));
    assert!((value - expected).abs() <= permitted, "{name}: {value} instead of {expected}");
}
