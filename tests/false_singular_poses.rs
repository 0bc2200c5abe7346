//! What only looks like a singular pose is none.

use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::{Body, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

const STOP: f64 = 4.0;

fn heavy_slider(preset: Option<&str>) -> Scene {
    let bar = |half: f64, inertia: f64| {
        Body::new().mass(1.0).inertia(inertia).point("a", [-half, 0.0]).point("b", [half, 0.0])
    };
    let scene = Scene::new("heavy_slider")
        .gravity([0.0, -9.81])
        .ground_point("axle", [0.0, 0.0])
        .body("crank", bar(0.2, 0.02))
        .body("rod", bar(0.6, 0.15))
        .body("slider", Body::new().mass(5e5).point("pin", [0.0, 0.0]))
        .revolute("main", "ground.axle", "crank.a")
        .revolute("crank_pin", "crank.b", "rod.a")
        .revolute("slider_pin", "rod.b", "slider.pin")
        .prismatic("guide", "ground", "slider", [1.0, 0.0])
        .initial("crank.angle", 0.8)
        .initial("crank.omega", 4.0)
        .guess("rod.angle", -0.24)
        .guess("slider.x", 1.44)
        .output("crank.angle")
        .stop(STOP);
    match preset {
        Some(preset) => scene.preset(preset),
        None => scene,
    }
}

fn model(scene: &Scene) -> Arc<Model> {
    let compiled = compile(scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    Arc::new(Model::new(compiled.program).expect("a sound program"))
}

/// The crank's angle at 100 points.
fn run(model: &Arc<Model>, tolerance: f64) -> Vec<f64> {
    let mut instance = Instance::new(model.clone());
    instance.setup(0.0, Some(STOP), Some(tolerance)).expect("times");
    instance.initialise().expect("consistent");
    let variable = instance.variable("crank.angle").expect("an output");
    let value = |point: u32| {
        instance.step_to(0.01 * STOP * f64::from(point)).unwrap_or_else(|error| panic!("{tolerance:e}: {error}"));
        instance.get(variable).expect("defined")
    };
    (1..=100).map(value).collect()
}

fn difference(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).fold(0.0, |worst, (one, other)| worst.max((one - other).abs()))
}

/// Masses of which one is a million times the other change how close the loop equations seem to be to each other, and nothing else.
#[test]
fn very_different_masses_are_no_singular_pose() {
    let [absolute, recommended] = [Some("absolute"), None].map(|preset| model(&heavy_slider(preset)));
    for tolerance in [1e-6, 1e-8, 1e-10] {
        let angles = [&absolute, &recommended].map(|model| run(model, tolerance));
        let error = difference(&angles[0], &angles[1]);
        assert!(error < 1000.0 * tolerance + 1e-6, "{tolerance:e}: {error:e}");
    }
}
