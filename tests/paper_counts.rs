//! How many equations each choice of trees gives: the counts of McPhee 1998 for his examples.

use crate::support::ROOT;
use std::path::Path;

use cotree::equations::Equations;
use cotree::model::CoordinateChoice;
use cotree::network::{Origin, System, Trees};
use cotree::scene::Scene;

/// Coordinates, loop equations of joints, and those of drivers. What holds by itself is no equation.
fn counts(model: &str, choice: CoordinateChoice) -> [usize; 3] {
    let path = Path::new(ROOT).join("models").join(model).join("scene.toml");
    let mechanism = Scene::read(&path).and_then(|scene| scene.resolve()).unwrap().mechanism;
    let system = System::new(&mechanism);
    let trees = Trees::select(&system, &choice).unwrap();
    let equations = Equations::new(system, trees);
    let rows = equations.constraints.iter().filter(|row| !row.is_trivial());
    let (drivers, joints): (Vec<_>, Vec<_>) =
        rows.partition(|row| matches!(equations.system.element(row.element).origin, Origin::Driver(_)));
    [equations.coordinates.len(), joints.len(), drivers.len()]
}

#[test]
fn slider_crank() {
    assert_eq!(counts("slider_crank", CoordinateChoice::Recommended), [2, 1, 0]);
    assert_eq!(counts("slider_crank", CoordinateChoice::Joint), [3, 2, 0]);
    assert_eq!(counts("slider_crank", CoordinateChoice::Absolute), [9, 8, 0]);
}

#[test]
fn quick_return() {
    assert_eq!(counts("quick_return", CoordinateChoice::Recommended), [2, 2, 0]);
    assert_eq!(counts("quick_return", CoordinateChoice::Joint), [5, 4, 1]);
    assert_eq!(counts("quick_return", CoordinateChoice::Absolute), [15, 14, 1]);
}
