//! Runs that begin at another time than the scene, and starts far from the guess.

use crate::support::ROOT;
use std::path::Path;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::{Body, Driver, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

fn model_of(scene: &Scene) -> Arc<Model> {
    let compiled = compile(scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    Arc::new(Model::new(compiled.program).expect("a sound program"))
}

fn model(name: &str) -> Arc<Model> {
    let path = Path::new(ROOT).join("models").join(name).join("scene.toml");
    model_of(&Scene::read(&path).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100))))
}

fn started(model: &Arc<Model>, start: f64) -> Instance {
    let mut instance = Instance::new(model.clone());
    instance.setup(start, None, Some(1e-9)).expect("times");
    instance.initialise().unwrap_or_else(|error| panic!("{} at {start} s: {error}", model.program().name));
    instance
}

fn value(instance: &mut Instance, name: &str) -> f64 {
    let variable = instance.variable(name).unwrap_or_else(|| panic!("{name}"));
    instance.get(variable).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The guess belongs to where the scene starts: from there the drivers lead to where the run does, on the same branch as a run that has come there.
#[test]
fn a_run_begins_where_the_drivers_have_led() {
    let klann: &[&str] = &["leg.foot.x", "leg.foot.y", "arm.angle", "leg.angle", "lower_rocker.angle"];
    let gear: &[&str] = &["upper_brace.angle", "lower_brace.angle", "strut.axle.x", "strut.axle.y"];
    for (name, names, starts) in
        [("klann", klann, [0.31, 0.5, 0.77, 3.6]), ("landing_gear", gear, [0.25, 0.5, 0.75, 1.0])]
    {
        let model = model(name);
        let mut through = started(&model, 0.0);
        for start in starts {
            through.step_to(start).expect("the motion goes on");
            let mut begun = started(&model, start);
            for variable in names {
                let [found, expected] = [&mut begun, &mut through].map(|instance| value(instance, variable));
                // Turns of angles count from the start.
                let apart =
                    if variable.ends_with(".angle") { (0.5 * (found - expected)).sin() } else { found - expected };
                assert!(apart.abs() < 1e-7, "{name}, {variable} at {start} s: {found} instead of {expected}");
            }
        }
    }
}

/// Linear loops are closed in one step, however far away.
#[test]
fn gears_that_have_turned_often_close() {
    let model = model("gear_train");
    for start in [3.0, 5.0, 60.0, 1000.0] {
        let mut begun = started(&model, start);
        let first = 15.0 * start * start;
        for (name, expected) in [("first.angle", first), ("second.angle", -first / 3.0), ("third.angle", first / 9.0)] {
            let found = value(&mut begun, name);
            assert!((found - expected).abs() < 1e-12 * first, "{name} at {start} s: {found} instead of {expected}");
        }
    }
    let scene = Scene::new("turned")
        .ground_point("other", [1.0, 0.0])
        .body("driving", Body::new().mass(1.0).inertia(1.0))
        .body("driven", Body::new().mass(1.0).inertia(1.0))
        .revolute("bearing", "ground", "driving")
        .revolute("other_bearing", "ground.other", "driven")
        .joint("mesh", cotree::scene::Joint::gear("driving", "driven", -1.0))
        .driver("motor", Driver::angle("bearing", "101 + t"))
        .stop(1.0);
    let mut begun = started(&model_of(&scene), 0.0);
    assert!((value(&mut begun, "driven.angle") + 101.0).abs() < 1e-10);
}
