//! What joints keep from turning: laws of its rate do no work, however steep they are.

use crate::support::run;

use cotree_fmu::program::Engine;

const STOP: f64 = 2.0;
const ENGINES: [Option<Engine>; 3] = [None, Some(Engine::Dop853), Some(Engine::Radau)];

/// A platform on two equal links never turns.
fn swing(law: &str, preset: &str, angle: f64) -> String {
    format!(
        r#"
format = 1
name = "swing"
gravity = [0, -9.81]
[bodies.left]
mass = 0.3
inertia = 0.002
points = {{ foot = [0, 0.2], head = [0, -0.2] }}
[bodies.right]
mass = 0.4
inertia = 0.003
points = {{ foot = [0, 0.2], head = [0, -0.2] }}
[bodies.platform]
mass = 2
inertia = 0.05
points = {{ left = [-0.3, 0.05], right = [0.3, 0.05] }}
[ground.points]
left = [-0.3, 0]
right = [0.3, 0]
[joints.a]
type = "revolute"
between = ["ground.left", "left.foot"]
[joints.b]
type = "revolute"
between = ["ground.right", "right.foot"]
[joints.c]
type = "revolute"
between = ["left.head", "platform.left"]
[joints.d]
type = "revolute"
between = ["right.head", "platform.right"]
[loads.drag]
type = "torque"
on = "platform"
value = "{law}"
[initial]
"left.angle" = {angle}
"left.omega" = 0
[outputs]
variables = ["left.angle", "left.omega"]
[experiment]
stop = 1000
[coordinates]
preset = "{preset}"
"#
    )
}

const LAWS: [&str; 5] = [
    "-0.2*platform.omega*abs(platform.omega)",
    "-0.2*sign(platform.omega)",
    "-3*if(platform.omega > 0, 1, -1)",
    "-50*max(0, platform.omega)",
    "0.5*abs(platform.angle)",
];

/// What differs from the swing without a law, or is refused, from a start at this angle.
fn differing(angle: f64, tolerances: &[f64]) -> Vec<String> {
    let mut differing = Vec::new();
    let presets = ["recommended", "joint", "absolute"];
    for (preset, engine) in presets.iter().flat_map(|preset| ENGINES.map(|engine| (preset, engine))) {
        for &tolerance in tolerances {
            let end = |law: &str| {
                let mut instance = run::started(&run::model(&swing(law, preset, angle)), engine, STOP, tolerance);
                instance.step_to(STOP).map_err(|error| error.to_string())?;
                Ok::<_, String>(["left.angle", "left.omega"].map(|name| run::value(&mut instance, name)))
            };
            let free = end("0").expect("regular");
            for law in LAWS {
                let found = end(law);
                if !found.as_ref().is_ok_and(|found| run::distance(found, &free) < 100.0 * tolerance) {
                    differing.push(format!("{preset} {engine:?} {tolerance:e} {law}: {found:?} {free:?}"));
                }
            }
        }
    }
    differing
}

#[test]
fn laws_of_a_rate_that_loops_hold_at_zero_have_no_effect() {
    let differing = differing(0.7, &[1e-4, 1e-6, 1e-8, 1e-10, 1e-12]);
    assert!(differing.is_empty(), "{}\n{}", differing.len(), differing.join("\n"));
}

#[test]
fn nor_have_they_at_rest() {
    let differing = differing(0.0, &[1e-4, 1e-6, 1e-8, 1e-10]);
    assert!(differing.is_empty(), "{}\n{}", differing.len(), differing.join("\n"));
}

/// A bar that a pin and a slot hold still, and a pendulum on it with a drag that turns back with it.
fn held(preset: &str) -> String {
    format!(
        r#"
format = 1
name = "held"
gravity = [0, -9.81]
[parameters]
weight = {{ value = 1, unit = "kg" }}
swept = {{ value = 0.02, unit = "kg.m2" }}
reach = "0.4 m"
[ground.points]
a = [0, 0]
b = [0.5, 0]
[bodies.bar]
mass = "weight"
inertia = "swept"
points = {{ a = [-0.25, 0], b = [0.25, 0], c = [0.1, 0] }}
[bodies.ball]
mass = 1
inertia = 0.01
points = {{ top = [0, "reach"] }}
[joints.pin]
type = "revolute"
between = ["ground.a", "bar.a"]
[joints.slot]
type = "slot"
axis = [1, 0]
between = ["ground.b", "bar.b"]
[joints.hang]
type = "revolute"
between = ["bar.c", "ball.top"]
[loads.drag]
type = "torque"
on = "ball"
value = "-0.02*ball.omega*abs(ball.omega)"
[initial]
"ball.angle" = 0.7
"ball.omega" = 0
[outputs]
variables = ["ball.angle", "pin.fy", "bar.angle"]
[experiment]
stop = {STOP}
[coordinates]
preset = "{preset}"
"#
    )
}

/// What a parameter does not move has derivatives of rounding errors, which no step makes smaller.
#[test]
fn what_joints_hold_still_has_sensitivities() {
    let names = ["weight", "swept", "reach", "ball.angle"].map(str::to_owned);
    let by = |preset: &str| {
        let scene = cotree::Scene::from_toml(&held(preset)).expect("a sound scene");
        let mut study = cotree_study::analysis::Study::new(&scene).expect("a sound scene");
        let found = study.sensitivities(&names, &[STOP]).unwrap_or_else(|error| panic!("{preset}: {error}"));
        found.derivatives[0].clone()
    };
    let expected = by("recommended");
    // Half of the bar's weight is the slot's.
    assert!((expected[(1, 0)] - 0.5 * 9.81).abs() < 1e-9, "{expected}");
    for preset in ["recommended", "joint", "absolute"] {
        let found = by(preset);
        for moved in [(0, 0), (0, 1), (2, 0), (2, 1), (1, 1)] {
            assert!(found[moved].abs() < 1e-9, "{preset}: {found}");
        }
        assert!((&found - &expected).amax() < 1e-6, "{preset}: {found} {expected}");
    }
}
