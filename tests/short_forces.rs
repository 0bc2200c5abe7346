//! Forces and contacts that are over within a step are felt, whichever method takes it, and whatever the tolerance is.

use crate::support::run;

const TOLERANCES: [f64; 5] = [1e-5, 1e-6, 1e-7, 1e-8, 1e-10];

/// Variables at a time.
fn values(scene: &str, names: &[&str], [time, tolerance]: [f64; 2]) -> Vec<f64> {
    let mut instance = run::started(&run::model(scene), None, time, tolerance);
    instance.step_to(time).unwrap_or_else(|error| panic!("{tolerance:e}: {error}"));
    names.iter().map(|name| run::value(&mut instance, name)).collect()
}

/// A block of 1 kg on a guide with this friction, under a force, from this place and rate.
fn guided(friction: &str, force: &str, [place, rate]: [f64; 2]) -> String {
    format!(
        r#"
format = 1
name = "guided"
[bodies.block]
mass = 1.0
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
{friction}
[loads.push]
type = "force"
on = "block"
vector = ["{force}", 0]
[initial]
"guide.s" = {place}
"guide.v" = {rate}
[outputs]
variables = ["block.x", "block.vx"]
"#
    )
}

/// What rests by friction is set free: 40 N for 10 ms against 5 N. Implicit steps, which friction at rest asks for, used to pass over it. The rest is a block
/// that slides until friction has taken its momentum, 0.37 N s at 3 N: 2.28 cm, and 1.85 mm during the push.
#[test]
fn a_push_within_a_step_sets_free_what_rests() {
    for law in [
        "2 + 40*if(t > 1, if(t < 1.01, 1, 0), 0)",
        "2 + 40*max(0, min(1, min((t - 0.9999)/2e-4, (1.0101 - t)/2e-4)))",
        "2 + 40*(smoothstep((t - 0.9999)/2e-4) - smoothstep((t - 1.0099)/2e-4))",
    ] {
        let scene = guided("friction = { coulomb = 5.0, velocity = 1e-4 }", law, [0.0; 2]);
        let found = TOLERANCES.map(|tolerance| values(&scene, &["block.x"], [2.0, tolerance])[0]);
        let [speed, slide] = [0.37, 0.5 * 0.37 * 0.37 / 3.0];
        assert!((found[4] - (0.5 * speed * 0.01 + slide)).abs() < 2e-4, "{law}: {found:?}");
        for (value, tolerance) in found.iter().zip(TOLERANCES) {
            assert!((value - found[4]).abs() < 100.0 * tolerance, "{law}, {tolerance:e}: {found:?}");
        }
    }
}

/// Between two elastic stops, beside a block that friction holds: the speed stays.
#[test]
fn a_contact_shorter_than_a_step_keeps_the_energy() {
    for (speed, stiffness) in [(0.63, 2e8), (0.91, 3e6), (0.32, 7e9)] {
        let scene = format!(
            r#"
format = 1
name = "stops"
[ground.points]
wall = [-1, 0]
[bodies.held]
mass = 1
[bodies.free]
mass = 1
[joints.rail]
type = "prismatic"
between = ["ground", "held"]
axis = [1, 0]
friction = {{ coulomb = 5.0, velocity = 1.2e-6 }}
[joints.track]
type = "prismatic"
between = ["ground", "free"]
axis = [1, 0]
[loads.push]
type = "force"
on = "held"
vector = [2, 0]
[loads.above]
type = "spring"
between = ["ground.wall", "free"]
stiffness = {stiffness}
length = 1.17
side = "above"
[loads.below]
type = "spring"
between = ["ground.wall", "free"]
stiffness = {stiffness}
length = 0.83
side = "below"
[initial]
"free.vx" = {speed}
[outputs]
variables = ["free.vx", "energy.total"]
"#
        );
        for tolerance in &TOLERANCES[..4] {
            let energy = values(&scene, &["energy.total"], [4.0, *tolerance])[0];
            let error = energy / (0.5 * speed * speed) - 1.0;
            assert!(error.abs() < 1000.0 * tolerance, "{stiffness}, {tolerance:e}: {error:e}");
        }
    }
}

/// A body on a rope flies freely while the rope is slack: nothing shortens its steps but the rope's length, whose series converges for a while only. Where it
/// comes taut used to be read from beyond.
#[test]
fn a_rope_comes_taut_at_its_time() {
    for (stiffness, length, x, y, speed) in
        [(194_061.0, 1.716, -0.1804, 0.4859, 0.708), (5e4, 1.2, 0.3, -0.7, 1.9), (3e6, 0.8, 0.11, 0.02, 0.5)]
    {
        let scene = format!(
            r#"
format = 1
name = "rope"
[bodies.ball]
mass = 1.0
inertia = 1.0
[loads.rope]
type = "spring"
between = ["ground", "ball"]
stiffness = {stiffness}
length = {length}
side = "above"
[initial]
"ball.x" = {x}
"ball.y" = {y}
"ball.vx" = {speed}
[outputs]
variables = ["energy.total"]
"#
        );
        for tolerance in TOLERANCES {
            let energy = values(&scene, &["energy.total"], [4.0, tolerance])[0];
            let error = energy / (0.5 * speed * speed) - 1.0;
            assert!(error.abs() < 1000.0 * tolerance, "{stiffness}, {tolerance:e}: {error:e}");
        }
    }
}

/// A pulse made of two logistic functions, or of the reciprocal of a hyperbolic cosine: on either side of it nothing tells of it. A push of 0.2 N s about
/// t = 1.1 s, and of 5 ms pi N about 1 s.
#[test]
fn a_smooth_pulse_with_exponentials_in_divisors_is_felt() {
    let logistic = |at: &str| format!("1/(1 + exp(-(t - {at})/0.005))");
    let cases = [
        (format!("{} - {}", logistic("1"), logistic("1.2")), [0.2 * 1.9, 0.2]),
        (
            "1/cosh(max(-300, min(300, (t - 1)/0.005)))".into(),
            [2.0 * 0.005 * std::f64::consts::PI, 0.005 * std::f64::consts::PI],
        ),
    ];
    for (law, [way, speed]) in cases {
        let scene = guided("", &law, [0.0; 2]);
        for tolerance in TOLERANCES {
            let found = values(&scene, &["block.x", "block.vx"], [3.0, tolerance]);
            let (expected, bound) = ([way, speed], 30.0 * tolerance + 1e-12);
            let near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < bound);
            assert!(near, "{law}, {tolerance:e}: {found:?} for {expected:?}");
        }
    }
}

/// Continuous laws that have no series where their argument is zero, which the motion passes again and again: they were refused as switching back and forth without end.
#[test]
fn powers_that_are_no_whole_numbers_are_passed_at_zero() {
    for law in [
        "-40*sign(block.x)*abs(block.x)^1.5",
        "-9*block.x - 0.3*sign(block.vx)*abs(block.vx)^1.5",
        "-9*block.x - block.vx*sqrt(abs(block.vx))",
        "-50*max(0, block.x)^1.5 - 3*block.x",
    ] {
        let scene = guided("", law, [0.4, 0.3]);
        let found = TOLERANCES.map(|tolerance| values(&scene, &["block.x", "block.vx"], [4.0, tolerance]));
        for (value, tolerance) in found.iter().zip(TOLERANCES) {
            let off = value.iter().zip(&found[4]).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            assert!(off < 100.0 * tolerance, "{law}, {tolerance:e}: {found:?}");
        }
    }
}
