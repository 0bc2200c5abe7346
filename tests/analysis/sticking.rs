//! Linear systems, vibrations and rests of what rubs and of freewheels: closed forms, and differences of the runtime's own accelerations.

use super::run::scene_of;
use super::slopes::against_differences;
use super::support::close;
use cotree::scene::Scene;
use cotree_study::analysis::report::Statics;
use cotree_study::analysis::{At, Stability, StateSpace, Study, StudyError};
use nalgebra::DMatrix;

fn study(text: &str, modes: &[(&str, &str)]) -> Study {
    let mut study = Study::new(&Scene::from_toml(text).unwrap()).unwrap();
    let modes: Vec<(String, String)> =
        modes.iter().map(|(name, word)| ((*name).to_owned(), (*word).to_owned())).collect();
    study.set_modes(&modes).unwrap();
    study
}

fn linear(text: &str, time: f64, modes: &[(&str, &str)]) -> Result<StateSpace, StudyError> {
    study(text, modes).linearize(&At::Times(vec![time])).map(|mut found| found.points.remove(0))
}

fn resting(text: &str) -> Statics {
    study(text, &[]).equilibrium().unwrap()
}

fn refused(text: &str, modes: &[(&str, &str)]) -> String {
    study(text, modes).equilibrium().unwrap_err().to_string()
}

/// What holds so, with its values.
fn told(statics: &Statics, title: &str) -> Vec<(String, f64)> {
    let group = statics.groups.iter().find(|group| group.title == title);
    let values = group.into_iter().flat_map(|group| &group.values);
    values.map(|(name, value, _)| (name.clone(), *value)).collect()
}

fn words(system: &StateSpace) -> Vec<(&str, &str)> {
    system.closures.iter().map(|own| (own.name.as_str(), own.word())).collect()
}

fn same_matrix(name: &str, found: &DMatrix<f64>, expected: &[&[f64]]) {
    assert_eq!(found.shape(), (expected.len(), expected.first().map_or(0, |row| row.len())), "{name}");
    for (i, row) in expected.iter().enumerate() {
        for (j, &value) in row.iter().enumerate() {
            close(&format!("{name}[{i}, {j}]"), found[(i, j)], value, 1e-11, found.amax());
        }
    }
}

/// A mass on a spring that rubs.
const OSCILLATOR: &str = r#"
name = "oscillator"
[ground.points]
wall = [-1, 0]
[bodies.block]
mass = 3.0
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
friction = { coulomb = "2 N", static = 1.25 }
[inputs]
push = { unit = "N", start = 0.0 }
[loads.spring]
type = "spring"
between = ["ground.wall", "block"]
stiffness = "120 N/m"
length = "1 m"
[loads.hand]
type = "force"
on = "block"
vector = ["push", 0]
[initial]
"guide.s" = PLACE
"guide.v" = RATE
[outputs]
variables = ["guide.s", "guide.force"]
"#;

fn oscillator(place: f64, rate: f64) -> String {
    OSCILLATOR.replace("PLACE", &format!("{place:?}")).replace("RATE", &format!("{rate:?}"))
}

#[test]
fn a_level_that_nothing_presses_for_is_a_constant_force() {
    for (rate, word, force) in [(0.3, "slides+", -2.0), (-0.3, "slides-", 2.0)] {
        let system = linear(&oscillator(0.1, rate), 0.0, &[]).unwrap();
        same_matrix("A", &system.a, &[&[0.0, 1.0], &[-40.0, 0.0]]);
        same_matrix("B", &system.b, &[&[0.0], &[1.0 / 3.0]]);
        same_matrix("C", &system.c, &[&[1.0, 0.0], &[0.0, 0.0]]);
        assert_eq!(words(&system), [("guide.friction", word)]);
        close("force", system.outputs[1].value, force, 1e-14, 1.0);
        close("acceleration", system.rates[1], (-12.0 + force) / 3.0, 1e-13, 1.0);
        assert_eq!(system.closures[0].direction(), Some(rate.signum()));
        let modes = study(&oscillator(0.1, rate), &[]).modes(Some(0.0)).unwrap().modes;
        close("frequency", modes[0].frequency(), 40.0_f64.sqrt() / std::f64::consts::TAU, 1e-12, 1.0);
    }
}

#[test]
fn what_sticks_takes_its_freedom_away() {
    let text = oscillator(0.02, 0.0);
    let system = linear(&text, 0.0, &[]).unwrap();
    assert_eq!((system.states.len(), words(&system)), (0, vec![("guide.friction", "sticks")]));
    // The friction answers a push alone.
    same_matrix("D", &system.d, &[&[0.0], &[-1.0]]);
    close("holds", system.closures[0].force, 2.4, 1e-12, 1.0);
    close("at most", system.closures[0].most().unwrap(), 2.5, 1e-12, 1.0);
    for at in [Some(0.0), None] {
        let message = study(&text, &[]).modes(at).unwrap_err().to_string();
        assert!(message.contains("`guide.friction` sticks") && message.contains("slides+"), "{message}");
    }
    // As it begins to slide.
    let begins = linear(&text, 0.0, &[("guide", "slides-")]).unwrap();
    same_matrix("A", &begins.a, &[&[0.0, 1.0], &[-40.0, 0.0]]);
    close("acceleration", begins.rates[1], (-2.4 + 2.0) / 3.0, 1e-12, 1.0);
    let idle = linear(&text, 0.0, &[("guide.friction", "idle")]).unwrap();
    close("acceleration", idle.rates[1], -0.8, 1e-12, 1.0);
}

#[test]
fn modes_that_do_not_fit_are_refused_with_the_reason() {
    let because = |text: &str, mode: (&str, &str), why: &str| {
        let message = linear(text, 0.0, &[mode]).unwrap_err().to_string();
        assert!(message.contains(why), "{message}");
    };
    let (moving, still) = (oscillator(0.1, 0.3), oscillator(0.02, 0.0));
    because(&moving, ("guide", "sticks"), "`guide.friction` cannot stick: it slides by 0.3 m/s");
    because(&moving, ("guide", "idle"), "cannot be idle: it slides by 0.3 m/s");
    because(&moving, ("guide", "slides-"), "slides the other way, by 0.3 m/s");
    because(&still, ("guide", "slides"), "write slides+ or slides-");
    assert_eq!(words(&linear(&moving, 0.0, &[("guide", "slides")]).unwrap()), [("guide.friction", "slides+")]);
    let unknown = |name: &str, word: &str| {
        let mut study = Study::new(&Scene::from_toml(&moving).unwrap()).unwrap();
        study.set_modes(&[(name.to_owned(), word.to_owned())]).unwrap_err()
    };
    let message = unknown("guide", "closed");
    assert!(message.contains("cannot be `closed`") && message.contains("guide=sticks or guide=slides"), "{message}");
    assert!(unknown("guid", "sticks").contains("`guide.friction`"));
}

/// A block that a stretched spring presses against its guide, the more the nearer it is.
fn pressed(rate: f64) -> String {
    format!(
        r#"
name = "pressed"
gravity = [0, -9.81]
[ground.points]
above = [0, 0.5]
[bodies.block]
mass = 2.0
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
friction = {{ mu = 0.3 }}
[loads.spring]
type = "spring"
between = ["ground.above", "block"]
stiffness = "150 N/m"
length = "0.2 m"
[initial]
"guide.s" = 0.4
"guide.v" = {rate:?}
[outputs]
variables = ["guide.fn", "guide.force"]
"#
    )
}

#[test]
fn a_level_follows_what_presses() {
    let (m, k, h, l0, mu, s) = (2.0, 150.0, 0.5, 0.2, 0.3, 0.4_f64);
    let length = s.hypot(h);
    // fn = m g - k (1 - l0/L) h presses downwards or upwards; its slope is -k h l0 s / L^3.
    let normal = m * 9.81 - k * (1.0 - l0 / length) * h;
    let slope = -k * h * l0 * s / length.powi(3);
    assert!(normal < 0.0);
    for rate in [0.7, -0.7_f64] {
        let system = linear(&pressed(rate), 0.0, &[]).unwrap();
        let friction = -rate.signum() * mu * normal.signum() * slope;
        let stiffness = -k * (1.0 - l0 / length) - k * l0 * s * s / length.powi(3) + friction;
        same_matrix("A", &system.a, &[&[0.0, 1.0], &[stiffness / m, 0.0]]);
        same_matrix("C", &system.c, &[&[slope, 0.0], &[friction, 0.0]]);
        close("force", system.outputs[1].value, -rate.signum() * mu * normal.abs(), 1e-13, 1.0);
    }
}

/// A slider-crank with friction in its guide and in two of its pins.
const CRANK: &str = r#"
name = "crank"
gravity = [0, -9.81]
[inputs]
torque = { unit = "N.m", start = 3.0 }
[bodies.crank]
mass = 1.0
inertia = 0.02
points = { a = [-0.1, 0], b = [0.1, 0] }
[bodies.rod]
mass = 0.8
inertia = 0.03
points = { a = [-0.3, 0], b = [0.3, 0] }
[bodies.slider]
mass = 1.5
[joints.main]
type = "revolute"
between = ["ground", "crank.a"]
friction = { mu = 0.2, radius = "25 mm" }
[joints.big]
type = "revolute"
between = ["crank.b", "rod.a"]
friction = { mu = 0.15, radius = "30 mm", coulomb = 0.02 }
[joints.small]
type = "revolute"
between = ["rod.b", "slider"]
[joints.guide]
type = "prismatic"
between = ["ground", "slider"]
axis = [1, 0]
friction = { mu = 0.25 }
[loads.motor]
type = "torque"
on = "crank"
value = "torque - 0.3*main.omega"
[loads.gas]
type = "force"
on = "slider"
vector = ["-30 - 10*guide.s", 0]
[initial]
"crank.angle" = "40 deg"
"crank.omega" = 6.0
"rod.angle" = { guess = "-10 deg" }
[outputs]
variables = ["main.fx", "main.torque", "big.torque", "guide.force", "crank.alpha"]
[experiment]
stop = 2
tolerance = 1e-10
"#;

#[test]
fn matrices_with_friction_are_the_slopes_of_the_runtime() {
    against_differences(CRANK, &[0.0, 0.2, 0.5]);
    against_differences(&pressed(0.4), &[0.0, 0.1]);
    against_differences(&oscillator(0.17, 0.0), &[0.1, 0.6]);
    against_differences(&scene_of("stick_slip"), &[0.3, 0.8]);
}
