//! Singular poses in Model Exchange: an integrator outside that meets one is told so, and nobody else is.

use std::f64::consts::FRAC_PI_2;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::support::ROOT;
use crate::support::exchange::integrate;

use cotree::compile::compile;
use cotree::scene::{Body, Scene};
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;

fn bar(length: f64) -> Body {
    let body = Body::new().mass(1.0).inertia(length * length / 12.0);
    body.point("a", [-length / 2.0, 0.0]).point("b", [length / 2.0, 0.0])
}

fn slider_crank(rod: f64, angle: f64) -> Instance {
    let scene = Scene::new("slider_crank")
        .body("crank", bar(1.0))
        .body("rod", bar(rod))
        .body("slider", Body::new().mass(0.7))
        .revolute("bearing", "ground", "crank.a")
        .revolute("pin", "crank.b", "rod.a")
        .revolute("wrist", "rod.b", "slider")
        .prismatic("guide", "ground", "slider", [1.0, 0.0])
        .initial("crank.angle", angle)
        .initial("crank.omega", 3.0)
        .guess("rod.angle", -angle)
        .output("crank.angle");
    let compiled = compile(&scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    Instance::new(Arc::new(Model::new(compiled.program).expect("a sound program")))
}

/// With crank and rod of the same length the slider could stay in the bearing once the crank is upright.
#[test]
fn a_step_through_a_singular_pose_is_an_error_that_names_the_joints() {
    let mut inside = slider_crank(1.0, 0.5);
    inside.initialise().expect("consistent");
    inside.step_to(1.0).expect("passes");
    let passage = inside.take_passages().remove(0);
    for h in [1e-3, 3.7e-3, 1e-2, 3e-2] {
        let mut instance = slider_crank(1.0, 0.5);
        let found = integrate(&mut instance, 2.0, h).expect_err("two branches cross");
        let InstanceError::Crossing(crossing) = &found else { panic!("{found:?}") };
        assert!((crossing.time - passage.time).abs() < 1e-3, "{found}, but it is at {}", passage.time);
        assert!(found.to_string().contains("use Co-Simulation"), "{found}");
        assert!(passage.joints.iter().any(|joint| crossing.joints.contains(joint)), "{found}");
        assert!(instance.time() - h <= crossing.time && crossing.time <= instance.time(), "in the last step");
    }
}

#[test]
fn no_other_step_is() {
    for (rod, h) in [(1.01, 1e-3), (1.2, 1e-2), (2.0, 3e-2)] {
        let mut instance = slider_crank(rod, 0.5);
        instance.setup(0.0, None, Some(1e-5)).expect("possible");
        integrate(&mut instance, 6.0, h).unwrap_or_else(|failure| panic!("{rod}: {failure}"));
        assert!(instance.take_passages().is_empty());
    }
}

/// The tumbling mechanism of Andrews turns once in some 8 ms: long steps open its loops farther than can be closed, which is no lock-up, and shorter ones do not.
#[test]
fn steps_that_are_too_long_for_a_fast_mechanism_are_said_to_be() {
    let path = Path::new(ROOT).join("models/andrews/scene.toml");
    let compiled = compile(&Scene::from_toml(&fs::read_to_string(path).unwrap()).unwrap()).unwrap();
    let model = Arc::new(Model::new(compiled.program).expect("a sound program"));
    for h in [5e-3, 1e-2] {
        let mut instance = Instance::new(Arc::clone(&model));
        let found = integrate(&mut instance, 0.1, h).expect_err("the loops are torn");
        assert!(matches!(found, InstanceError::Apart { .. }), "{h}: {found:?}");
        let said = found.to_string();
        for part in ["steps are too long for how fast", "shorter steps", "controls its steps", "use Co-Simulation"] {
            assert!(said.contains(part), "{said}");
        }
        assert!(!said.contains("change the lengths"), "{said}");
    }
    integrate(&mut Instance::new(model), 0.03, 1e-5).expect("short steps keep the loops closed");
}

#[test]
fn a_start_in_a_singular_pose_is_refused() {
    let mut instance = slider_crank(1.0, FRAC_PI_2);
    let found = integrate(&mut instance, 1.0, 1e-3).expect_err("nobody knows where to go");
    assert!(matches!(found, InstanceError::Crossing(_) | InstanceError::Solver(_)), "{found}");
    // Other values may then be tried.
    let angle = instance.variable("crank.angle").expect("known");
    instance.set(angle, 0.3).expect("settable");
    instance.initialise_exchange().expect("regular");
}

/// A pendulum on a trolley that an input moves: no loop, but the trolley's rates, which an importer cannot tell. As a force it is no obstacle.
#[test]
fn a_driver_that_follows_an_input_is_for_co_simulation_only() {
    let scene = |follows: &str| {
        let text = format!(
            r#"
            format = 1
            name = "trolley"
            gravity = [0, -9.81]
            [inputs]
            signal = 0.1
            [bodies.trolley]
            mass = 1.0
            [bodies.rod]
            mass = 1.0
            inertia = 0.1
            points = {{ top = [0, 0.5] }}
            [joints.rail]
            type = "prismatic"
            between = ["ground", "trolley"]
            axis = [1, 0]
            [joints.hook]
            type = "revolute"
            between = ["trolley", "rod.top"]
            {follows}
            [outputs]
            variables = ["rod.alpha"]
            "#
        );
        compile(&Scene::from_toml(&text).expect("a scene")).expect("a model")
    };
    let force = scene("[loads.push]\ntype = \"force\"\non = \"trolley\"\nvector = [\"signal\", 0]");
    assert!(force.description.exchange.is_some());
    for order in ["position", "velocity", "acceleration"] {
        let driver =
            format!("[drivers.winch]\njoint = \"rail\"\ndisplacement = {{ input = \"signal\", as = \"{order}\" }}");
        let driven = scene(&driver);
        assert_eq!(driven.description.exchange, None, "{order}");
        let mut instance = Instance::new(Arc::new(Model::new(driven.program).expect("a sound program")));
        assert!(matches!(instance.initialise_exchange(), Err(InstanceError::NoExchange)), "{order}");
    }
}
