//! Rests, linear systems and vibrations of what is a unilateral constraint: the same as where a joint or a driver stands for what is closed and nothing for what is open.

use super::run::scene_of;
use super::support::{PENDULUM, close};
use cotree::scene::Scene;
use cotree_study::analysis::report::Statics;
use cotree_study::analysis::{LinearisedAt, Stability, StateSpace, Study};
use nalgebra::{Complex, DMatrix};

fn study(text: &str, modes: &[(&str, &str)]) -> Study {
    let mut study = Study::new(&Scene::from_toml(text).unwrap()).unwrap();
    let modes: Vec<(String, String)> =
        modes.iter().map(|(name, word)| ((*name).to_owned(), (*word).to_owned())).collect();
    study.set_modes(&modes).unwrap();
    study
}

fn resting(text: &str) -> Statics {
    study(text, &[]).equilibrium().unwrap()
}

fn refused(text: &str, modes: &[(&str, &str)]) -> String {
    study(text, modes).equilibrium().unwrap_err().to_string()
}

/// What is closed, with its force, and what is open, with its gap.
fn told(statics: &Statics, title: &str) -> Vec<(String, f64)> {
    let group = statics.groups.iter().find(|group| group.title == title);
    let values = group.into_iter().flat_map(|group| &group.values);
    values.map(|(name, value, _)| (name.clone(), *value)).collect()
}

/// Whatever the states are, the same system answers its inputs in the same way.
fn answers(system: &StateSpace, s: f64) -> DMatrix<f64> {
    let n = system.a.nrows();
    let inner = DMatrix::identity(n, n) * s - &system.a;
    &system.c * inner.lu().solve(&system.b).unwrap() + &system.d
}

fn same(one: &StateSpace, other: &StateSpace) {
    assert_eq!(one.a.shape(), other.a.shape());
    for s in [0.37, 2.9, 11.0] {
        let (one, other) = (answers(one, s), answers(other, s));
        assert!((&one - &other).amax() < 1e-10 * one.amax().max(1.0), "{one} {other}");
    }
}

/// Two arms; the second is pressed against what `HOLD` has at 0.3 rad.
const ARMS: &str = r#"
name = "arms"
gravity = [0, -9.81]
[bodies.upper]
mass = 2.0
inertia = 0.1
points = { root = [-0.4, 0], tip = [0.5, 0] }
[bodies.lower]
mass = 1.2
inertia = 0.04
points = { root = [-0.3, 0.05] }
[joints.shoulder]
type = "revolute"
between = ["ground", "upper.root"]
[joints.elbow]
type = "revolute"
between = ["upper.tip", "lower.root"]
LIMITS
[inputs]
push = { unit = "N.m", start = PUSH }
[loads.muscle]
type = "torque"
on = "lower"
value = "push"
[initial]
"upper.angle" = -1.1
"upper.omega" = 0.4
START
[outputs]
variables = ["upper.alpha", "upper.angle", "lower.y"]
"#;

fn arms(limits: &str, start: &str, push: f64, more: &str) -> String {
    let text = ARMS.replace("LIMITS", limits).replace("START", start).replace("PUSH", &format!("{push:?}"));
    text + more
}

const LIMITS: &str = "limits = { min = -0.9, max = 0.3 }";

#[test]
fn what_is_closed_is_a_loop_equation_and_what_is_open_is_not_there() {
    let start = "\"elbow.angle\" = 0.3\n\"elbow.omega\" = 0.0";
    let driven = arms("", "", 9.0, "[drivers.hold]\njoint = \"elbow\"\nangle = 0.3\n");
    let free = arms("", start, 9.0, "");
    let limited = arms(LIMITS, start, 9.0, "");
    let at = LinearisedAt::Times(vec![0.0]);
    let of = |text: &str, modes: &[(&str, &str)]| {
        let mut found = study(text, modes).linearize(&at).unwrap();
        found.points.remove(0)
    };
    let closed = of(&limited, &[]);
    same(&closed, &of(&driven, &[]));
    let words: Vec<(&str, bool)> = closed.statuses.iter().map(|own| (own.name.as_str(), own.closed)).collect();
    assert_eq!(words, [("elbow.min", false), ("elbow.max", true)]);
    assert!(closed.statuses[1].force > 0.0 && (closed.statuses[0].gap - 1.2).abs() < 1e-12);
    let open = of(&limited, &[("elbow.max", "open")]);
    same(&open, &of(&free, &[]));
    assert_ne!(open.a.shape(), closed.a.shape());
    // Along the motion it is what it is at each time: pulled away, it opens at once.
    let leaving = arms(LIMITS, start, -9.0, "");
    same(&of(&leaving, &[]), &of(&arms("", start, -9.0, ""), &[]));
    let later =
        study(&leaving, &[("elbow.max", "closed")]).linearize(&LinearisedAt::Times(vec![0.1])).unwrap_err().to_string();
    assert!(later.contains("`elbow.max` cannot be closed: it is open by"), "{later}");
    let unknown = Study::new(&Scene::from_toml(&limited).unwrap())
        .unwrap()
        .set_modes(&[("elbow".to_owned(), "closed".to_owned())]);
    assert!(unknown.unwrap_err().to_string().contains("`elbow`"));
}

#[test]
fn vibrations_are_those_in_the_mode_of_the_rest() {
    let held = 0.3;
    let start = "\"elbow.angle\" = 0.3\n\"elbow.omega\" = 0.0".replace("\"elbow.omega\" = 0.0", "");
    let limited = arms(LIMITS, &start, 9.0, "").replace("\"upper.omega\" = 0.4", "");
    let driven = arms("", "", 9.0, &format!("[drivers.hold]\njoint = \"elbow\"\nangle = {held}\n"));
    let frequencies = |text: &str, modes: &[(&str, &str)]| {
        let found = study(text, modes).modes(None).unwrap();
        let mut all: Vec<Complex<f64>> = found.modes.iter().map(|mode| mode.eigenvalue).collect();
        all.sort_by(|a, b| a.im.total_cmp(&b.im));
        all
    };
    let (own, other) = (frequencies(&limited, &[]), frequencies(&driven, &[]));
    assert_eq!((own.len(), other.len()), (1, 1));
    assert!((own[0] - other[0]).norm() < 1e-9 * own[0].norm(), "{own:?} {other:?}");
    // Hanging with both free is another rest.
    let open = frequencies(&limited.replace("start = 9.0", "start = 0.0"), &[]);
    assert_eq!(open.len(), 2);
    // The rest that is asked for is none.
    let message = study(&limited, &[("elbow.max", "open")]).modes(None).unwrap_err().to_string();
    assert!(message.contains("`elbow.max` is exceeded by") || message.contains("accelerating"), "{message}");
}

#[test]
fn a_taut_rope_swings_as_a_rod_does() {
    let text = |joint: &str| {
        format!(
            r#"
name = "sling"
gravity = [0, -9.81]
[bodies.shot]
mass = 0.8
[joints.sling]
type = "{joint}"
between = ["ground", "shot"]
length = 1.3
[initial]
"shot.x" = {{ guess = 0.1 }}
"shot.y" = {{ guess = -1.0 }}
"#
        )
    };
    let statics = resting(&text("rope"));
    assert!((statics.value("shot.y").unwrap() + 1.3).abs() < 1e-9);
    assert_eq!(told(&statics, "closed").len(), 1);
    assert!((told(&statics, "closed")[0].1 - 0.8 * 9.81).abs() < 1e-9);
    let [rope, rod] = ["rope", "distance"].map(|joint| study(&text(joint), &[]).modes(None).unwrap().modes);
    assert_eq!((rope.len(), rod.len()), (1, 1));
    close("frequency", rope[0].frequency(), (9.81_f64 / 1.3).sqrt() / std::f64::consts::TAU, 1e-9, 1.0);
    close("frequency", rope[0].frequency(), rod[0].frequency(), 1e-10, 1.0);
}

#[test]
fn a_pendulum_rests_on_its_stop_or_hangs_free() {
    let pendulum = |limits: &str, guess: &str| {
        PENDULUM
            .replace(
                "between = [\"ground\", \"arm.pivot\"]",
                &format!("between = [\"ground\", \"arm.pivot\"]\nlimits = {limits}"),
            )
            .replace("GUESS", guess)
    };
    // m g d cos 60 deg on the stop; sin of what is left of it is the stiffness that does not count.
    let on_it = resting(&pendulum("{ min = \"-60 deg\" }", "-30 deg"));
    assert!((on_it.value("arm.angle").unwrap() + 60.0_f64.to_radians()).abs() < 1e-12);
    let closed = told(&on_it, "closed");
    assert_eq!(closed[0].0, "pivot.min");
    close("stop", closed[0].1, 2.0 * 9.81 * 0.7 * 0.5, 1e-12, 1.0);
    close("stop", on_it.value("pivot.stop").unwrap_or(closed[0].1), 2.0 * 9.81 * 0.7 * 0.5, 1e-12, 1.0);
    assert_eq!(on_it.stability, Stability::Held);
    // Within its limits it hangs, wherever it begins: also at a limit that it is pulled away from.
    for guess in ["-130 deg", "-30 deg", "-40 deg"] {
        let free = resting(&pendulum("{ min = \"-150 deg\", max = \"-30 deg\" }", guess));
        assert!((free.value("arm.angle").unwrap() + 90.0_f64.to_radians()).abs() < 1e-9, "{guess}");
        assert_eq!(told(&free, "closed"), []);
        assert!((told(&free, "open")[0].1 - 60.0_f64.to_radians()).abs() < 1e-9);
    }
    // The rest upright lies beyond the stop: it falls to the other side of it.
    let leaning = resting(&pendulum("{ min = \"95 deg\", max = \"170 deg\" }", "120 deg"));
    assert!((leaning.value("arm.angle").unwrap() - 170.0_f64.to_radians()).abs() < 1e-12);
    close("stop", told(&leaning, "closed")[0].1, 2.0 * 9.81 * 0.7 * 10.0_f64.to_radians().cos(), 1e-12, 1.0);
}

/// A block on two feet, whose centre of mass is not in the middle.
const BLOCK: &str = r#"
name = "block"
gravity = [0, -9.81]
[bodies.block]
mass = 3.0
inertia = 0.2
points = { left = [-0.2, -0.1], right = [0.3, -0.1], third = [0.1, -0.1], ear = [0.6, 0.0] }
[joints.left_foot]
type = "contact"
between = ["ground", "block.left"]
axis = [1, 0]
[joints.right_foot]
type = "contact"
between = ["ground", "block.right"]
axis = [1, 0]
[loads.hand]
type = "force"
on = "block.ear"
vector = [0, "LIFT"]
[loads.tether]
type = "spring"
between = ["ground.post", "block"]
stiffness = 40.0
length = 0.0
[ground.points]
post = [0.0, 0.1]
[initial]
"block.x" = { guess = 0.05 }
"block.y" = { guess = 0.4 }
"block.angle" = { guess = 0.1 }
"#;

#[test]
fn a_block_stands_on_two_feet_or_on_one() {
    let statics = resting(&BLOCK.replace("LIFT", "0.0"));
    let weight = 3.0 * 9.81;
    let closed = told(&statics, "closed");
    assert_eq!(closed.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["left_foot", "right_foot"]);
    close("left", closed[0].1, weight * 0.6, 1e-10, 1.0);
    close("right", closed[1].1, weight * 0.4, 1e-10, 1.0);
    assert!((statics.value("block.y").unwrap() - 0.1).abs() < 1e-10);
    assert_eq!(statics.stability, Stability::Stable);
    // A hand that lifts the ear takes the right foot's share: moments about the left foot.
    let statics = resting(&BLOCK.replace("LIFT", "6.0"));
    let closed = told(&statics, "closed");
    close("right", closed[1].1, (weight * 0.2 - 6.0 * 0.8) / 0.5, 1e-9, 1.0);
    close("left", closed[0].1, weight - 6.0 - closed[1].1, 1e-9, 1.0);
    // More than that lifts it: it stands on its left foot alone, and nothing else carries.
    let statics = resting(&BLOCK.replace("LIFT", "9.0").replace("mass = 3.0", "mass = 2.0"));
    let closed = told(&statics, "closed");
    assert_eq!(closed.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["left_foot"]);
    assert!(told(&statics, "open")[0].1 > 0.0);
}

#[test]
fn what_carries_must_be_determined_and_something_must_carry() {
    let third =
        "[joints.third_foot]\ntype = \"contact\"\nbetween = [\"ground\", \"block.third\"]\naxis = [1, 0]\n[loads.hand]";
    let message = refused(&BLOCK.replace("LIFT", "0.0").replace("[loads.hand]", third), &[]);
    assert!(message.contains("are redundant (statically indeterminate)"), "{message}");
    assert!(message.contains("`third_foot`"), "{message}");
    let flying = BLOCK.replace("LIFT", "60.0").replace("stiffness = 40.0", "stiffness = 0.0");
    let message = refused(&flying, &[]);
    assert!(message.contains("there is no equilibrium in any of the 4 combinations"), "{message}");
}

/// A torque T that presses a slider-crank against its stop: F ds = T d(angle).
#[test]
fn a_motor_presses_its_slider_against_the_stop() {
    let statics = resting(&scene_of("end_stop"));
    let (crank, rod, travel, torque) = (0.2_f64, 0.5_f64, 0.66_f64, 4.0);
    let cosine = (crank * crank + travel * travel - rod * rod) / (2.0 * crank * travel);
    let angle = -cosine.acos();
    let across = (rod * rod - (crank * angle.sin()).powi(2)).sqrt();
    let slope = -crank * angle.sin() - crank * crank * angle.sin() * angle.cos() / across;
    close("angle", statics.value("crank.angle").unwrap(), angle, 1e-11, 1.0);
    close("stop", told(&statics, "closed")[0].1, torque / slope, 1e-10, 1.0);
    assert_eq!(statics.stability, Stability::Held);
    // A run from there stays there.
    let mut study = study(&scene_of("end_stop"), &[]);
    study.begin_at_rest().unwrap();
    let model = std::sync::Arc::new(cotree_fmu::model::Model::new(study.compiled().unwrap().program).unwrap());
    let mut run = super::run::started(&model, None, 1.0, 1e-10);
    run.step_to(1.0).unwrap();
    assert!(super::run::value(&mut run, "guide.v").abs() < 1e-9);
    assert!((super::run::value(&mut run, "guide.stop").abs() - torque / slope).abs() < 1e-8);
}
