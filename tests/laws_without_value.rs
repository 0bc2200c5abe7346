//! Where a law has no value, the message says which one, where it stands in the scene, and what left its domain.

use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::{Body, Driver, Load, Quantity, Scene};
use cotree_fmu::failure::Failure;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use cotree_fmu::program::domain::Limit;

fn guided(law: &str) -> Scene {
    let force: [Quantity; 2] = [law.into(), 0.0.into()];
    Scene::new("guided")
        .input("drive", 0.0)
        .parameter("reach", 0.5)
        .body("block", Body::new().mass(2.0))
        .prismatic("guide", "ground", "block", [1.0, 0.0])
        .load("push", Load::force("block", force))
        .initial("block.x", 0.0)
        .initial("block.vx", 1.0)
        .stop(1.0)
}

fn turning(law: &str) -> Scene {
    Scene::new("turning")
        .body("arm", Body::new().mass(2.0).inertia(1.0))
        .revolute("pin", "ground", "arm")
        .driver("motor", Driver::angle("pin", law))
        .output("arm.angle")
        .stop(1.0)
}

/// The failure of a run.
fn failure(scene: &Scene, engine: Option<Engine>) -> InstanceError {
    let compiled = compile(scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    let mut instance = Instance::new(Arc::new(Model::new(compiled.program).expect("a sound program")));
    instance.setup(0.0, Some(1.0), Some(1e-7)).expect("times");
    if let Some(engine) = engine {
        instance.set_engine(engine).expect("not begun");
    }
    let observed = instance.variable("arm.angle").or(instance.variable("block.x")).expect("a variable");
    let mut run = || {
        instance.initialise()?;
        for point in 1..=40 {
            instance.step_to(0.025 * f64::from(point))?;
            instance.get(observed)?;
        }
        Ok(())
    };
    run().expect_err("the law has no value")
}

#[test]
fn the_law_its_place_and_the_value_are_named() {
    let cases = [
        ("1/drive", "divides by `drive`, which is 0 there", 0.0),
        ("-2/(drive*t)", "divides by `drive*t`, which is 0 there", 0.0),
        ("3/(0.5-t)", "divides by `0.5-t`, which is 0 there", 0.5),
        ("sqrt(reach-t)", "takes the square root of `reach-t`, which is -", 0.5),
        ("0.1*log(1-2*t)", "takes the logarithm of `1-2*t`, which is ", 0.5),
        ("asin(2*t)/1", "takes the arc sine or cosine of `2*t`, which is 1.", 0.5),
        ("(0.5-t)^1.5", "raises `0.5-t`, which is -", 0.5),
        ("if(t < 0.5, 0, sqrt(-t))", "takes the square root of `-t`, which is -0.5", 0.5),
        ("if(t < 2, 1, sqrt(-1-t)) + sqrt(0.3 - t)", "takes the square root of `0.3-t`", 0.3),
    ];
    for (law, said, at) in cases {
        for engine in [None, Some(Engine::Taylor), Some(Engine::Dop853), Some(Engine::Radau)] {
            let error = failure(&guided(law), engine);
            let InstanceError::Solver(Failure::NoValue { time, .. }) = &error else {
                panic!("{law}, {engine:?}: {error}")
            };
            assert!((time - at).abs() < 1e-3, "{law}, {engine:?}: {error}");
            let message = error.to_string();
            assert!(message.contains("`loads.push.vector` ") && message.contains(said), "{law}, {engine:?}: {message}");
        }
    }
}

#[test]
fn so_are_drivers_and_springs_without_a_direction() {
    for (law, said) in [("sqrt(0.5-t)", "the square root of `0.5-t`"), ("0.1/(t-0.5)", "divides by `t-0.5`")] {
        let message = failure(&turning(law), None).to_string();
        assert!(message.contains("`drivers.motor.angle` ") && message.contains(said), "{law}: {message}");
    }
    let spring = guided("0")
        .ground_point("hook", [0.0, 0.0])
        .load("spring", Load::spring("ground.hook", "block", 10.0).free(0.3));
    let InstanceError::Solver(Failure::NoValue { law, .. }) = failure(&spring, None) else { panic!("not named") };
    assert_eq!(law.domain.limit, Limit::Distance);
    assert!(law.to_string().contains("`loads.spring` acts along the line between `ground.hook` and `block`"), "{law}");
}

/// Nobody looks at the driven arm, and nothing that is looked at depends on it.
#[test]
fn a_driver_without_a_value_that_moves_nothing_else_is_named_too() {
    let driven = |scene: Scene, law: &str| {
        scene
            .body("arm", Body::new().mass(2.0).inertia(1.0))
            .revolute("pin", "ground", "arm")
            .driver("motor", Driver::angle("pin", law))
    };
    let kinematic = |law: &str| {
        let other =
            Scene::new("two").body("other", Body::new().mass(2.0).inertia(1.0)).revolute("hinge", "ground", "other");
        driven(other.driver("second", Driver::angle("hinge", "t")), law).output("other.angle").stop(1.0)
    };
    let dynamic = |law: &str| driven(guided("1"), law).output("block.x");
    let engines = [None, Some(Engine::Taylor), Some(Engine::Dop853), Some(Engine::Radau)];
    for (law, said, at) in [
        ("sqrt(0.5-t)", "the square root of `0.5-t`", 0.5),
        ("sqrt(t-0.5)", "the square root of `t-0.5`, which is -0.5 there", 0.0),
    ] {
        let runs = engines.iter().map(|engine| (dynamic(law), *engine)).chain([(kinematic(law), None)]);
        for (scene, engine) in runs {
            let compiled = compile(&scene).expect("a sound scene");
            let mut instance = Instance::new(Arc::new(Model::new(compiled.program).expect("a sound program")));
            instance.setup(0.0, None, Some(1e-7)).expect("times");
            engine.map_or(Ok(()), |engine| instance.set_engine(engine)).expect("not begun");
            let reached = |instance: &Instance| instance.time();
            let error = (instance.initialise())
                .and_then(|()| (1..=40).try_for_each(|point| instance.step_to(0.025 * f64::from(point))))
                .expect_err("the law has no value");
            let message = error.to_string();
            assert!(message.contains("`drivers.motor.angle` ") && message.contains(said), "{engine:?}: {message}");
            // What comes before is not refused: it has its value.
            assert!((reached(&instance) - at).abs() < 1e-9, "{engine:?}: {message} after {}", reached(&instance));
        }
    }
}

#[test]
fn a_law_that_grows_beyond_all_bounds_is_named() {
    for law in ["exp(2000*t)", "exp(exp(20*t))"] {
        // (The implicit method counts ten million steps first.)
        for engine in [None, Some(Engine::Taylor), Some(Engine::Dop853)] {
            let message = failure(&guided(law), engine).to_string();
            assert!(message.contains(&format!("`loads.push.vector` is `{law}`, which is ")), "{engine:?}: {message}");
        }
    }
}
