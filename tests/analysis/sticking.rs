//! Linear systems, vibrations and rests of what rubs and of freewheels: closed forms, and differences of the runtime's own accelerations.

use super::run::scene_of;
use super::slopes::against_differences;
use super::support::close;
use crate::support::linkage::linkage;
use cotree::scene::Scene;
use cotree_study::analysis::report::Statics;
use cotree_study::analysis::{LinearisedAt, Stability, StateSpace, Study, StudyError};
use nalgebra::DMatrix;

fn study(text: &str, modes: &[(&str, &str)]) -> Study {
    let mut study = Study::new(&Scene::from_toml(text).unwrap()).unwrap();
    let modes: Vec<(String, String)> =
        modes.iter().map(|(name, word)| ((*name).to_owned(), (*word).to_owned())).collect();
    study.set_modes(&modes).unwrap();
    study
}

fn linear(text: &str, time: f64, modes: &[(&str, &str)]) -> Result<StateSpace, StudyError> {
    study(text, modes).linearize(&LinearisedAt::Times(vec![time])).map(|mut found| found.points.remove(0))
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
    system.statuses.iter().map(|own| (own.name.as_str(), own.word())).collect()
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
        assert_eq!(system.statuses[0].direction(), Some(rate.signum()));
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
    close("holds", system.statuses[0].force, 2.4, 1e-12, 1.0);
    close("at most", system.statuses[0].most().unwrap(), 2.5, 1e-12, 1.0);
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
    because(&moving, ("guide", "sticks"), "`guide.friction` cannot stick: it slides at 0.3 m/s");
    because(&moving, ("guide", "idle"), "slides at 0.3 m/s, so its friction cannot be idle");
    because(&moving, ("guide", "slides-"), "slides in the other direction, at 0.3 m/s");
    because(&still, ("guide", "slides"), "write slides+ or slides-");
    assert_eq!(words(&linear(&moving, 0.0, &[("guide", "slides")]).unwrap()), [("guide.friction", "slides+")]);
    let unknown = |name: &str, word: &str| {
        let mut study = Study::new(&Scene::from_toml(&moving).unwrap()).unwrap();
        study.set_modes(&[(name.to_owned(), word.to_owned())]).unwrap_err().to_string()
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

/// Two links on pins that rub by what they carry.
const LINKS: &str = r#"
name = "links"
gravity = [0, -9.81]
[inputs]
hand = { unit = "N", start = 1.5 }
[bodies.upper]
mass = 1.2
inertia = 0.02
points = { a = [-0.2, 0], b = [0.25, 0] }
[bodies.lower]
mass = 0.7
inertia = 0.01
points = { a = [-0.15, 0], tip = [0.2, 0] }
[joints.first]
type = "revolute"
between = ["ground", "upper.a"]
friction = { mu = 0.5, radius = "30 mm" }
[joints.second]
type = "revolute"
between = ["upper.b", "lower.a"]
friction = { mu = 0.4, radius = "20 mm", static = 1.2 }
[loads.pull]
type = "force"
on = "lower.tip"
vector = ["hand", 0]
[initial]
"upper.angle" = "20 deg"
"upper.omega" = 2.0
"lower.angle" = "-40 deg"
"lower.omega" = LOWER
[outputs]
variables = ["first.fx", "second.fy", "first.torque", "second.torque"]
[experiment]
stop = 5
tolerance = 1e-10
"#;

/// A drawer that is pushed beside the middle of its long guide.
const DRAWER: &str = r#"
name = "drawer"
gravity = [0, -3.0]
[bodies.drawer]
mass = 2.0
inertia = 0.1
points = { knob = [0, 0.2] }
[joints.guide]
type = "prismatic"
between = ["ground", "drawer"]
axis = [1, 0]
friction = { mu = 0.45, length = "0.4 m" }
limits = { max = "0.9 m" }
[loads.push]
type = "force"
on = "drawer.knob"
vector = ["20 + 15*guide.s", 0]
[initial]
"guide.s" = 0.1
"guide.v" = 0.3
[outputs]
variables = ["guide.force", "guide.torque"]
"#;

/// A disc on a lane that rises, with a spring: `JOINT` is a contact or rolls.
const DISC: &str = r#"
name = "disc"
gravity = [0, -9.81]
[ground.points]
post = [1.0, 0.6]
[bodies.disc]
mass = 3.0
inertia = 0.015
[joints.lane]
type = "JOINT"
between = ["ground", "disc"]
axis = [1, 0.1]
radius = 0.1
friction = { mu = 0.2 }
[loads.spring]
type = "spring"
between = ["ground.post", "disc"]
stiffness = 20.0
length = 0.3
[initial]
START
"disc.omega" = 0.0
[outputs]
variables = ["lane.fn", "lane.ft", "disc.alpha"]
"#;

/// A worm and its wheel, a clutch with a law, and a freewheel.
const TRAIN: &str = r#"
name = "train"
[inputs]
grip = { unit = "N.m", start = 0.1 }
[ground.points]
right = [0.2, 0]
far = [0.5, 0]
[bodies.worm]
mass = 1.0
inertia = 0.002
[bodies.wheel]
mass = 2.0
inertia = 0.05
points = { pin = [0.1, 0] }
[bodies.fan]
mass = 1.0
inertia = 0.03
[bodies.ring]
mass = 1.0
inertia = 0.02
[joints.first]
type = "revolute"
between = ["ground", "worm"]
[joints.second]
type = "revolute"
between = ["ground.right", "wheel"]
[joints.third]
type = "revolute"
between = ["ground.far", "fan"]
[joints.fourth]
type = "revolute"
between = ["ground.far", "ring"]
[joints.mesh]
type = "gear"
between = ["worm", "wheel"]
ratio = 0.2
friction = { mu = 0.3 }
[joints.clutch]
type = "clutch"
between = ["wheel", "fan"]
level = "0.5 + 0.2*sin(3*t) + grip"
[joints.ratchet]
type = "one_way"
between = ["fan", "ring"]
[loads.motor]
type = "torque"
on = "worm"
value = "0.4 - 0.02*worm.omega"
[loads.drag]
type = "torque"
on = "ring"
value = "-0.1*ring.omega - 0.2*ring.angle"
[loads.spring]
type = "spring"
between = ["ground", "wheel.pin"]
stiffness = 12.0
length = 0.1
[initial]
"worm.omega" = 20.0
"fan.omega" = 0.0
"ring.omega" = RING
[outputs]
variables = ["mesh.torque", "clutch.torque", "ratchet.stop", "ring.alpha"]
[experiment]
stop = 5
tolerance = 1e-10
"#;

#[test]
fn everything_that_rubs_or_is_caught_has_the_slopes_of_the_runtime() {
    for lower in ["-3.0", "2.0"] {
        against_differences(&LINKS.replace("LOWER", lower), &[0.0, 0.4]);
    }
    against_differences(DRAWER, &[0.0, 0.1]);
    let contact = "\"disc.x\" = 0.0\n\"lane.gap\" = 0.0\n\"lane.v\" = 2.0\n\"disc.angle\" = 0.0";
    for (joint, start) in [("rolling", "\"lane.s\" = 0.0\n\"lane.v\" = 2.0"), ("contact", contact)] {
        against_differences(&DISC.replace("JOINT", joint).replace("START", start), &[0.05, 1.0]);
    }
    let modes = |ring: &str| {
        let text = TRAIN.replace("RING", ring);
        against_differences(&text, &[0.005, 0.1]);
        let system = linear(&text, 0.005, &[]).unwrap();
        words(&system).into_iter().map(|(_, word)| word.to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(modes("0.0"), ["caught", "slides+", "slides-"]);
    assert_eq!(modes("9.0"), ["free", "slides+", "slides-"]);
}

/// A block on a slope, in a guide or on it.
fn slope(degrees: f64, mu: f64, is_guide: bool) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let joint = if is_guide { "prismatic" } else { "contact" };
    let start = if is_guide {
        "\"plane.s\" = 0.7".to_owned()
    } else {
        format!("\"block.x\" = {:?}\n\"block.y\" = {{ guess = {:?} }}", 0.7 * cos, 0.7 * sin + 0.01)
    };
    format!(
        r#"
name = "slope"
gravity = [0, -9.81]
[bodies.block]
mass = 5.0
[joints.plane]
type = "{joint}"
between = ["ground", "block"]
axis = [{cos:?}, {sin:?}]
friction = {{ mu = {mu:?}{} }}
[initial]
{start}
"#,
        if is_guide { ", static = 1.2" } else { "" }
    )
}

#[test]
fn a_block_holds_on_a_slope_or_slides() {
    let weight = 5.0 * 9.81;
    let (sin, cos) = 10.0_f64.to_radians().sin_cos();
    for (is_guide, ratio) in [(true, 1.2), (false, 1.0)] {
        let statics = resting(&slope(10.0, 0.3, is_guide));
        let (holds, most) = (weight * sin, ratio * 0.3 * weight * cos);
        let expected = [("plane.friction", holds), ("plane.friction.most", most)];
        for ((name, value), expected) in told(&statics, "sticks").iter().zip(expected) {
            assert_eq!(name, expected.0);
            close(name, *value, expected.1, 1e-11, 1.0);
        }
        let loads = told(&statics, "margins");
        close("from", loads[0].1, holds - most, 1e-11, 1.0);
        close("to", loads[1].1, holds + most, 1e-11, 1.0);
        // Guessed above the slope, it is put where its foot is along it.
        let place = if is_guide { 0.7 } else { 0.7 + 0.01 * sin };
        close("place", statics.value("block.x").unwrap(), place * cos, 1e-11, 1.0);
        assert_eq!(
            (statics.stability.clone(), &statics.standing[..]),
            (Stability::Held, &["plane.friction".to_owned()][..])
        );
        let message = refused(&slope(20.0, 0.3, is_guide), &[]);
        let needed = format!("`plane.friction` would need {:.2} N", weight * 20.0_f64.to_radians().sin());
        assert!(message.contains(&needed) && message.contains("it slides"), "{message}");
    }
}

/// What its margins say is what it holds in that very scene: loads along a guide, about a pin, on a worm.
#[test]
fn it_holds_up_to_its_margins() {
    let block = |load: f64| {
        let [x, y] = ["cos", "sin"].map(|part| format!("{load:?}*{part}(10[deg])"));
        format!(
            "{}\n[loads.push]\ntype = \"force\"\non = \"block\"\nvector = [\"{x}\", \"{y}\"]\n",
            slope(10.0, 0.3, true)
        )
    };
    let bar =
        |load: f64| format!("{}[loads.hand]\ntype = \"torque\"\non = \"bar\"\nvalue = {load:?}\n", braked(&[9.0]));
    let worm = |load: f64| {
        let bodies = TRAIN.split("[bodies.fan]").next().unwrap();
        let wheels = TRAIN.split("[joints.first]").nth(1).unwrap().split("[joints.third]").next().unwrap();
        format!(
            r#"{bodies}[joints.first]{wheels}
[joints.mesh]
type = "gear"
between = ["worm", "wheel"]
ratio = 0.2
friction = {{ mu = 1.2 }}
[loads.weight]
type = "torque"
on = "wheel"
value = -3.0
[loads.hand]
type = "torque"
on = "worm"
value = {load:?}
"#
        )
    };
    for text in [&block as &dyn Fn(f64) -> String, &bar, &worm] {
        let margins = told(&resting(&text(0.0)), "margins");
        assert_eq!(margins.len(), 2);
        for (name, load) in margins {
            for (share, holds) in [(1.0, true), (1.0 + 1e-6, false)] {
                assert_eq!(study(&text(share * load), &[]).equilibrium().is_ok(), holds, "{name} {load}");
            }
        }
    }
}

#[test]
fn a_spring_leaves_a_zone_of_rest() {
    for place in [-0.0208, -0.01, 0.0, 0.0208] {
        let statics = resting(&oscillator(place, 0.0));
        close("place", statics.value("guide.s").unwrap(), place, 1e-14, 1.0);
        close("holds", told(&statics, "sticks")[0].1, 120.0 * place, 1e-11, 1.0);
    }
    for place in [-0.0209, 0.0209] {
        assert!(refused(&oscillator(place, 0.0), &[]).contains("slides from this configuration"));
    }
}

/// The ends of the zones of rest: where it is about to slide.
#[test]
fn a_rest_is_found_in_which_something_is_about_to_slide() {
    let about = |text: &str, name: &str, word: &str| {
        let statics = study(text, &[(name, word)]).equilibrium().unwrap();
        assert_eq!((statics.verging.len(), statics.shared.len(), statics.standing.len()), (1, 0, 1), "{word}");
        let [force, most] = [0, 1].map(|place| told(&statics, "sticks")[place].1);
        close("all that it can", force.abs(), most, 1e-9, 0.0);
        statics
    };
    // Forwards, friction pulls back: the spring pushes, at the near end of the zone.
    for (word, place) in [("slides+", -2.5 / 120.0), ("slides-", 2.5 / 120.0)] {
        for from in [0.01, 0.4] {
            let statics = about(&oscillator(from, 0.0), "guide", word);
            close("end", statics.value("guide.s").unwrap(), place, 1e-11, 1.0);
            assert_eq!(statics.stability, Stability::Held);
        }
    }
    // A pin whose force depends on the pose: sin(angle) = mu r / l, of a weight that is carried whole.
    let pendulum = "name = \"pendulum\"\ngravity = [0, -9.81]\n[bodies.bar]\nmass = 1.5\ninertia = 0.03\npoints = { top = [0, 0.4] }\n[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"bar.top\"]\nfriction = { mu = 0.4, radius = \"50 mm\" }\n[initial]\n\"bar.angle\" = { guess = 0.3 }\n";
    for (word, angle) in [("slides+", -(0.05_f64.asin())), ("slides-", 0.05_f64.asin())] {
        close("angle", about(pendulum, "pin", word).value("bar.angle").unwrap(), angle, 1e-10, 1.0);
    }
    // What presses the other way: the guide of a block that a spring pulls up.
    let text =
        pressed(0.0).replace("\"guide.s\" = 0.4", "\"guide.s\" = { guess = 0.1 }").replace("\"guide.v\" = 0.0\n", "");
    for word in ["slides+", "slides-"] {
        let s = about(&text, "guide", word).value("guide.s").unwrap();
        let length = s.hypot(0.5);
        let [along, normal] = [s, 0.5].map(|part| 150.0 * (1.0 - 0.2 / length) * part);
        close("Coulomb", along.abs(), 0.3 * (normal - 2.0 * 9.81).abs(), 1e-9, 1.0);
        assert_eq!(s < 0.0, word == "slides+");
    }
    // Nothing brings a weight on level ground to its level.
    let message = refused(&slope(0.0, 0.3, true), &[("plane", "slides+")]);
    assert!(message.contains("still accelerating there: `plane.s`"), "{message}");
}

#[test]
fn a_pin_holds_a_pendulum_out_of_the_vertical() {
    // Up to sin(angle) = mu r / l.
    let pendulum = |sine: f64| {
        format!(
            r#"
name = "pendulum"
gravity = [0, -9.81]
[bodies.bar]
mass = 1.5
inertia = 0.03
points = {{ top = [0, 0.4] }}
[joints.pin]
type = "revolute"
between = ["ground", "bar.top"]
friction = {{ mu = 0.4, radius = "50 mm" }}
[initial]
"bar.angle" = {:?}
"#,
            sine.asin()
        )
    };
    let statics = resting(&pendulum(0.0499));
    let expected = [1.5 * 9.81 * 0.4 * 0.0499, 0.4 * 0.05 * 1.5 * 9.81];
    for ((name, value), expected) in told(&statics, "sticks").iter().zip(expected) {
        close(name, *value, expected, 1e-11, 1.0);
    }
    assert!(refused(&pendulum(0.0501), &[]).contains("`pin.friction` would need"));
    assert!(refused(&pendulum(-0.0501), &[]).contains("`pin.friction` would need"));
}

/// A nut with a weight on a thread of slope 0.398: it locks itself from that coefficient on.
#[test]
fn a_thread_locks_itself() {
    let thread = |mu: f64| {
        format!(
            r#"
name = "thread"
gravity = [0, -9.81]
[bodies.spindle]
mass = 1.0
inertia = 1e-3
[bodies.nut]
mass = 5.0
[joints.bearing]
type = "revolute"
between = ["ground", "spindle"]
[joints.rail]
type = "prismatic"
between = ["ground", "nut"]
axis = [0, 1]
[joints.thread]
type = "screw"
between = ["spindle", "nut"]
axis = [0, 1]
lead = "20 mm"
friction = {{ mu = {mu:?}, radius = "8 mm" }}
"#
        )
    };
    let slope = 0.02 / (std::f64::consts::TAU * 0.008);
    for mu in [slope + 1e-6, 0.41, 0.8] {
        assert_eq!(resting(&thread(mu)).standing, ["thread.friction"], "{mu}");
    }
    for mu in [0.1, 0.39, slope - 1e-6] {
        assert!(refused(&thread(mu), &[]).contains("`thread.friction` would need"), "{mu}");
    }
}

/// A bar with a weight that brakes hold.
fn braked(levels: &[f64]) -> String {
    let brake = |(index, level): (usize, &f64)| {
        format!("[joints.brake{index}]\ntype = \"brake\"\nbetween = [\"ground\", \"bar\"]\nlevel = {level:?}\n")
    };
    let brakes: String = levels.iter().enumerate().map(brake).collect();
    format!(
        r#"
name = "braked"
gravity = [0, -9.81]
[bodies.bar]
mass = 3.0
inertia = 0.1
points = {{ root = [-0.3, 0] }}
[joints.axle]
type = "revolute"
between = ["ground", "bar.root"]
{brakes}
[initial]
"bar.angle" = 0.2
"#
    )
}

#[test]
fn a_brake_holds_a_weight() {
    let torque = 3.0 * 9.81 * 0.3 * 0.2_f64.cos();
    let statics = resting(&braked(&[9.0]));
    let sticks = told(&statics, "sticks");
    close("holds", sticks[0].1, torque, 1e-12, 1.0);
    close("at most", sticks[1].1, 9.0, 1e-12, 1.0);
    assert!(refused(&braked(&[8.0]), &[]).contains("`brake0.friction` would need"));
    let message = refused(&braked(&[9.0]), &[("brake0", "slides")]);
    assert!(message.contains("request this mode at a time of the motion"), "{message}");
    let message = linear(&braked(&[9.0, 12.0]), 0.0, &[("brake0", "sticks"), ("brake1", "sticks")]).unwrap_err();
    assert!(message.to_string().contains("is overconstrained"), "{message}");
    // A run from there stays there.
    let mut study = study(&braked(&[9.0]), &[]);
    study.begin_at_rest().unwrap();
    let model = std::sync::Arc::new(cotree_fmu::model::Model::new(study.compiled().unwrap().program).unwrap());
    let mut run = super::run::started(&model, None, 1.0, 1e-10);
    run.step_to(1.0).unwrap();
    assert!((super::run::value(&mut run, "bar.angle") - 0.2).abs() < 1e-13);
}

#[test]
fn brakes_share_a_weight_in_one_way_of_many() {
    let torque = 3.0 * 9.81 * 0.3 * 0.2_f64.cos();
    let names = |count: usize| (0..count).map(|index| format!("brake{index}.friction")).collect::<Vec<_>>();
    for (levels, holds) in [
        (&[9.0, 12.0][..], &[torque][..]),
        (&[5.0, 4.0], &[5.0, torque - 5.0]),
        (&[3.0, 4.0, 2.0], &[3.0, 4.0, torque - 7.0]),
    ] {
        let statics = resting(&braked(levels));
        let found = told(&statics, "sticks").into_iter().filter(|(name, _)| !name.ends_with("most"));
        let found: Vec<f64> = found.map(|(_, value)| value).collect();
        assert_eq!(found.len(), holds.len(), "{levels:?} {found:?}");
        found.iter().zip(holds).for_each(|(found, expected)| close("share", *found, *expected, 1e-11, 1.0));
        assert_eq!((&statics.shared, told(&statics, "margins")), (&names(levels.len()), Vec::new()));
        assert_eq!(told(&statics, "idle").len(), levels.len() - holds.len());
    }
    let message = refused(&braked(&[5.0, 3.6]), &[]);
    assert!(message.contains("`brake0.friction`, `brake1.friction` would exceed their friction limits"), "{message}");
    let statics = study(&braked(&[9.0, 12.0]), &[("brake0", "idle")]).equilibrium().unwrap();
    assert_eq!((statics.standing.len(), statics.shared.len()), (1, 0));
    close("holds", told(&statics, "sticks")[0].1, torque, 1e-12, 1.0);
    let message = refused(&braked(&[9.0, 12.0]), &[("brake0", "slides+")]);
    assert!(message.contains("`brake1.friction` share one load: which of them is at its friction limit"), "{message}");
    let message = refused(&braked(&[9.0, 8.0]), &[("brake0", "idle")]);
    assert!(message.contains("without `brake0.friction`, which `--mode` makes idle"), "{message}");
}

/// The flattest ladder that stands: both ends are about to slide. The moments about the foot, and the friction at floor and wall, against the program's search.
#[test]
fn a_ladder_stands_where_both_its_ends_are_about_to_slide() {
    let ladder = |floor: f64, wall: f64, up: f64, begin: f64| {
        format!(
            "name = \"ladder\"\ngravity = [0, -9.81]\n[ground.points]\nbase = [0, 0]\n[bodies.ladder]\nmass = 12\ninertia = 16\npoints = {{ low = [-2.5, 0], high = [2.5, 0], man = [{:?}, 0] }}\n[joints.floor_pad]\ntype = \"contact\"\nbetween = [\"ground.base\", \"ladder.low\"]\naxis = [1, 0]\nfriction = {{ mu = {floor:?} }}\n[joints.wall_pad]\ntype = \"contact\"\nbetween = [\"ground.base\", \"ladder.high\"]\naxis = [0, 1]\nside = \"left\"\nfriction = {{ mu = {wall:?} }}\n[loads.man]\ntype = \"force\"\non = \"ladder.man\"\nvector = [0, \"-70[kg]*9.81[m/s2]\"]\n[initial]\n\"ladder.angle\" = {begin:?}\n\"ladder.x\" = {:?}\n\"ladder.y\" = {:?}\n",
            up - 2.5,
            -2.5 * begin.cos(),
            2.5 * begin.sin()
        )
    };
    for (floor, wall, up) in [(0.5_f64, 0.3_f64, 3.5_f64), (0.4, 0.2, 2.0), (0.6, 0.1, 4.5), (0.35, 0.5, 3.0)] {
        // Floor: N + mu_w W = weight, W = mu_f N; moments about the foot: W sin + mu_w W cos = (12 2.5 + 70 up) g cos/5.
        let weight = 82.0 * 9.81;
        let pushed = floor * weight / (1.0 + floor * wall);
        let tangent = (12.0 * 2.5 + 70.0 * up) * 9.81 / (5.0 * pushed) - wall;
        let angle = tangent.atan();
        let ends = [("floor_pad.friction", "slides-"), ("wall_pad.friction", "slides-")];
        let ways = [("slides-", "slides-"), ("slides-", "slides+"), ("slides+", "slides-"), ("slides+", "slides+")];
        let found = ways.iter().filter_map(|&(low, high)| {
            let requested = [(ends[0].0, low), (ends[1].0, high)];
            let statics = study(&ladder(floor, wall, up, angle + 0.03), &requested).equilibrium().ok()?;
            Some((statics.value("ladder.angle").unwrap(), statics.stability == Stability::Held))
        });
        let found: Vec<(f64, bool)> = found.collect();
        assert!(found.iter().any(|(own, held)| (own - angle).abs() < 1e-9 && *held), "{angle} {found:?}");
        // It stands a little steeper, and not a little flatter.
        assert!(study(&ladder(floor, wall, up, angle + 1e-4), &[]).equilibrium().is_ok());
        assert!(study(&ladder(floor, wall, up, angle - 1e-4), &[]).equilibrium().is_err());
    }
}

/// A box that is pushed at its ear rests where the runtime finds that it does, on one foot, on both or on neither.
#[test]
fn random_boxes_rest_where_the_runtime_lets_them() {
    let mut random = crate::support::hard::random::Random(5);
    let mut seen = [0; 2];
    for case in 0..40 {
        let (angle, mu) = (random.between(-0.4, 0.4_f64), random.between(0.1, 0.9));
        let (x, y) = (random.between(-12.0, 12.0), random.between(-10.0, 25.0));
        let (sin, cos) = angle.sin_cos();
        let foot = |name: &str| {
            format!(
                "[joints.{name}_foot]\ntype = \"contact\"\nbetween = [\"ground\", \"box.{name}\"]\naxis = [{cos:?}, {sin:?}]\nfriction = {{ mu = {mu:?} }}\n"
            )
        };
        let text = format!(
            r#"
name = "box"
gravity = [0, -9.81]
[bodies.box]
mass = 3.0
inertia = 0.1
points = {{ left = [-0.25, -0.2], right = [0.25, -0.2], ear = [0.3, 0.1] }}
{}{}
[loads.push]
type = "force"
on = "box.ear"
vector = [{x:?}, {y:?}]
[initial]
"left_foot.gap" = 0.0
"left_foot.s" = 0.0
"box.angle" = {angle:?}
"box.vx" = 0.0
"box.vy" = 0.0
"box.omega" = 0.0
[outputs]
variables = ["box.ax", "box.ay", "box.alpha", "left_foot.fn", "right_foot.fn", "box.x", "box.y"]
"#,
            foot("left"),
            foot("right")
        );
        let mut run = super::run::started(&super::run::model(&text), None, 1.0, 1e-9);
        let mut value = |name: &str| super::run::value(&mut run, name);
        let rests = ["box.ax", "box.ay", "box.alpha"].iter().all(|name| value(name).abs() < 1e-9);
        let found = study(&text, &[]).equilibrium();
        let stays = found.as_ref().is_ok_and(|statics| {
            ["box.x", "box.y"].iter().all(|name| (statics.value(name).unwrap() - value(name)).abs() < 1e-9)
        });
        assert_eq!(stays, rests, "{case}: {:?}", found.map(|statics| statics.groups));
        for (name, force) in found.iter().filter(|_| rests).flat_map(|statics| told(statics, "closed")) {
            close(&name, force, value(&format!("{name}.fn")), 1e-8, 1.0);
        }
        seen[usize::from(rests)] += 1;
    }
    assert!(seen.iter().all(|count| *count > 5), "{seen:?}");
}

/// Two braked bars: each pair of brakes shares a freedom of its own.
#[test]
fn each_freedom_is_shared_by_its_own() {
    let second = |text: &str| {
        let own = text.split("[bodies.bar]").nth(1).unwrap().split("[initial]").next().unwrap().to_owned();
        let own = own.replace("bar", "arm").replace("axle", "hinge").replace("joints.brake", "joints.stop");
        text.replace("[initial]", &format!("[bodies.arm]{own}[initial]\n\"arm.angle\" = 0.2"))
    };
    let torque = 3.0 * 9.81 * 0.3 * 0.2_f64.cos();
    let statics = resting(&second(&braked(&[5.0, 4.0])));
    for (name, expected) in [("brake0", 5.0), ("brake1", torque - 5.0), ("stop0", 5.0), ("stop1", torque - 5.0)] {
        let own = told(&statics, "sticks").into_iter().find(|(known, _)| *known == format!("{name}.friction"));
        close(name, own.unwrap().1, expected, 1e-11, 1.0);
    }
    assert_eq!(statics.shared.len(), 4);
    let weak = second(&braked(&[5.0, 4.0]))
        .replace("between = [\"ground\", \"arm\"]\nlevel = 4.0", "between = [\"ground\", \"arm\"]\nlevel = 3.0");
    assert!(
        refused(&weak, &[]).contains("`stop0.friction`, `stop1.friction` would exceed their friction limits"),
        "{weak}"
    );
}

/// Blocks in a row, each on the one before: each friction carries what acts on all that hang on it.
#[test]
fn random_chains_rest_where_every_friction_suffices() {
    let mut random = crate::support::hard::random::Random(77);
    let mut seen = [0; 2];
    for case in 0..60 {
        let count = 1 + case % 4;
        let mut text = "name = \"chain\"\n".to_owned();
        let mut blocks = Vec::new();
        for index in 0..count {
            let (load, level, ratio) = (random.between(-3.0, 3.0), random.between(1.0, 8.0), random.between(1.0, 1.5));
            let before = if index == 0 { "ground".to_owned() } else { format!("b{}", index - 1) };
            text += &format!(
                "[bodies.b{index}]\nmass = 1.0\n[joints.j{index}]\ntype = \"prismatic\"\nbetween = [\"{before}\", \"b{index}\"]\naxis = [1, 0]\nfriction = {{ coulomb = {level:?}, static = {ratio:?} }}\n\
                 [loads.f{index}]\ntype = \"force\"\non = \"b{index}\"\nvector = [{load:?}, 0]\n"
            );
            blocks.push((load, level * ratio));
        }
        let carried = |index: usize| -> f64 { blocks[index..].iter().map(|(load, _)| load).sum() };
        let holds = (0..count).all(|index| carried(index).abs() <= blocks[index].1);
        match study(&text, &[]).equilibrium() {
            Ok(statics) => {
                let forces = told(&statics, "sticks").into_iter().filter(|(name, _)| !name.ends_with("most"));
                for (index, (name, force)) in forces.enumerate() {
                    close(&name, force, -carried(index), 1e-12, 1.0);
                }
                assert!(holds, "{case}");
            }
            Err(error) => assert!(!holds && error.to_string().contains("slides"), "{case}: {error}"),
        }
        seen[usize::from(holds)] += 1;
    }
    assert!(seen.iter().all(|count| *count > 10), "{seen:?}");
}

/// A box on two rough feet on a slope, beside whose middle its weight acts: what it holds along the slope is determined, the share of each foot is not.
#[test]
fn a_box_stands_on_two_rough_feet() {
    let (slope, foot) = (15.0_f64.to_radians(), 0.25);
    let (sin, cos) = slope.sin_cos();
    let case = |mu: f64| {
        format!(
            r#"
name = "box"
gravity = [0, -9.81]
[bodies.box]
mass = 6.0
inertia = 0.3
points = {{ left = [-{foot}, -0.2], right = [{foot}, -0.2] }}
[joints.left_foot]
type = "contact"
between = ["ground", "box.left"]
axis = [{cos:?}, {sin:?}]
friction = {{ mu = {mu:?} }}
[joints.right_foot]
type = "contact"
between = ["ground", "box.right"]
axis = [{cos:?}, {sin:?}]
friction = {{ mu = {mu:?} }}
[initial]
"box.angle" = {slope:?}
"box.x" = {{ guess = {:?} }}
"box.y" = {{ guess = {:?} }}
"#,
            -0.2 * sin,
            0.2 * cos
        )
    };
    let weight = 6.0 * 9.81;
    let statics = resting(&case(0.3));
    // Moments about the middle between the feet.
    let off = 0.5 * weight * sin * 0.2 / foot;
    close("left", told(&statics, "closed")[0].1, 0.5 * weight * cos + off, 1e-10, 1.0);
    close("right", told(&statics, "closed")[1].1, 0.5 * weight * cos - off, 1e-10, 1.0);
    let holds = told(&statics, "sticks");
    let total: f64 = holds.iter().filter(|(name, _)| name.ends_with("friction")).map(|(_, value)| value).sum();
    close("both", total, weight * sin, 1e-10, 1.0);
    assert_eq!(statics.shared, ["left_foot.friction", "right_foot.friction"]);
    for mu in [slope.tan() + 1e-6, 0.8] {
        assert_eq!(resting(&case(mu)).stability, Stability::Held);
    }
    for mu in [slope.tan() - 1e-6, 0.1] {
        assert!(refused(&case(mu), &[]).contains("would exceed their friction limits together"), "{mu}");
    }
}

/// A drawer that leans on its stop, with friction: the stop can hold all of it.
#[test]
fn what_a_stop_holds_need_not_stick() {
    let drawer = |push: f64| {
        DRAWER
            .replace("20 + 15*guide.s", &format!("{push:?}"))
            .replace("\"guide.s\" = 0.1\n\"guide.v\" = 0.3", "\"guide.s\" = 0.9")
    };
    let statics = resting(&drawer(30.0));
    close("stop", told(&statics, "closed")[0].1, 30.0, 1e-11, 1.0);
    assert_eq!(statics.shared, ["guide.max", "guide.friction"]);
    // Pulled off its stop a little its friction holds, and more than it can moves it.
    let statics = resting(&drawer(-1.0));
    assert_eq!((told(&statics, "closed").len(), told(&statics, "sticks")[0].1.abs().round()), (0, 1.0));
    assert!(refused(&drawer(-30.0), &[]).contains("`guide.friction` would need"));
}

#[test]
fn a_drawer_jams_or_slides() {
    // 0.45 x 2 x 0.5 / 0.4 > 1 of any push.
    for push in [1.0, 20.0, 1e5] {
        let text = DRAWER.replace("20 + 15*guide.s", &format!("{push:?}")).replace("\"guide.v\" = 0.3\n", "");
        let statics = resting(&text.replace("[0, 0.2]", "[0, 0.5]"));
        close("friction", told(&statics, "sticks")[0].1, -push, 1e-11, 1.0);
        // The ends press by half the weight more or less, or against each other.
        let at_ends = f64::max(6.0, 2.0 * push * 0.5 / 0.4);
        close("at most", told(&statics, "sticks")[1].1, 0.45 * at_ends, 1e-11, 1.0);
        assert_eq!(study(&text, &[]).equilibrium().is_ok(), push < 0.45 * f64::max(6.0, 2.0 * push * 0.2 / 0.4));
    }
}

/// A four-bar whose pins rub rests where the runtime finds that it does: both fill the shares of the pins in ways of their own.
#[test]
fn pins_hold_a_four_bar_where_it_stays() {
    let mut seen = [0; 2];
    for torque in (0..12).map(|step| 0.5 * f64::from(step)) {
        let text = linkage(torque);
        let found = study(&text, &[]).equilibrium();
        let mut run = super::run::started(&super::run::model(&text), None, 0.1, 1e-9);
        let stays = super::run::value(&mut run, "crank.alpha").abs() < 1e-9;
        assert_eq!(found.is_ok(), stays, "{torque}: {:?}", found.err().map(|error| error.to_string()));
        seen[usize::from(stays)] += 1;
    }
    assert!(seen.iter().all(|count| *count > 1), "{seen:?}");
}

/// A ladder on a rough floor at a smooth wall: the floor's friction is half the weight by the tangent.
#[test]
fn a_ladder_stands_or_slides() {
    let angle = 60.0_f64.to_radians();
    let ladder = |mu: f64| {
        format!(
            r#"
name = "ladder"
gravity = [0, -9.81]
[bodies.ladder]
mass = 10.0
inertia = 7.5
points = {{ foot = [-1.5, 0], head = [1.5, 0] }}
[joints.floor_line]
type = "contact"
between = ["ground", "ladder.foot"]
axis = [1, 0]
friction = {{ mu = {mu:?} }}
[joints.wall_line]
type = "contact"
between = ["ground", "ladder.head"]
axis = [0, 1]
[initial]
"ladder.angle" = {:?}
"ladder.x" = {{ guess = {:?} }}
"ladder.y" = {{ guess = {:?} }}
"#,
            angle,
            -1.5 * angle.cos(),
            1.5 * angle.sin()
        )
    };
    let weight = 10.0 * 9.81;
    let statics = resting(&ladder(0.3));
    close("friction", told(&statics, "sticks")[0].1, weight / (2.0 * angle.tan()), 1e-10, 1.0);
    close("floor", told(&statics, "closed")[0].1, weight, 1e-10, 1.0);
    close("wall", told(&statics, "closed")[1].1, weight / (2.0 * angle.tan()), 1e-10, 1.0);
    let message = refused(&ladder(0.28), &[]);
    assert!(message.contains("`floor_line.friction` would need"), "{message}");
    // The flattest ladder: tan(angle) = 1/(2 mu).
    let flattest = study(&ladder(0.4), &[("floor_line", "slides-")]).equilibrium().unwrap();
    close("angle", flattest.value("ladder.angle").unwrap(), (1.0_f64 / 0.8).atan(), 1e-9, 1.0);
    assert_eq!(flattest.verging, ["floor_line.friction"]);
}

/// A pendulum on a block that sticks swings as one on the ground does.
#[test]
fn what_does_not_rub_swings_beside_what_sticks() {
    let text = r#"
name = "crane"
gravity = [0, -9.81]
[bodies.trolley]
mass = 2.0
[bodies.hook]
mass = 1.0
inertia = 0.02
points = { top = [0, 0.8] }
[joints.rail]
type = "prismatic"
between = ["ground", "trolley"]
axis = [1, 0]
friction = { mu = 0.1 }
[joints.pin]
type = "revolute"
between = ["trolley", "hook.top"]
[initial]
"rail.s" = 0.3
"hook.angle" = { guess = 0.4 }
"#;
    let statics = resting(text);
    assert!((statics.value("hook.angle").unwrap()).abs() < 1e-9);
    assert_eq!(statics.stability, Stability::Stable);
    close("at most", told(&statics, "sticks")[1].1, 0.1 * 3.0 * 9.81, 1e-11, 1.0);
    let modes = study(text, &[]).modes(None).unwrap().modes;
    assert_eq!(modes.len(), 1);
    let omega = (9.81_f64 * 0.8 / (0.64 + 0.02)).sqrt();
    close("frequency", modes[0].frequency(), omega / std::f64::consts::TAU, 1e-9, 1.0);
    let message = study(text, &[]).equilibrium_sensitivities(&["rail.s".to_owned()]).unwrap_err().to_string();
    assert!(message.contains("the dry friction of prismatic joint `rail`"), "{message}");
}

#[test]
fn a_freewheel_drives_or_turns_until_nothing_does() {
    let ratchet = |torque: &str, angle: f64| {
        format!(
            r#"
name = "ratchet"
[bodies.disc]
mass = 1.0
inertia = 0.4
[joints.axle]
type = "revolute"
between = ["ground", "disc"]
[joints.ratchet]
type = "one_way"
between = ["ground", "disc"]
[loads.drive]
type = "torque"
on = "disc"
value = "{torque}"
[initial]
"disc.angle" = {angle:?}
"#
        )
    };
    let statics = resting(&ratchet("1[N.m] - disc.angle*1[N.m/rad]", 1.5));
    assert_eq!(told(&statics, "caught"), [("ratchet".to_owned(), 0.5)]);
    assert_eq!((statics.value("disc.angle").unwrap(), &statics.standing[..]), (1.5, &["ratchet".to_owned()][..]));
    let statics = resting(&ratchet("1[N.m] - disc.angle*1[N.m/rad]", 0.2));
    close("angle", statics.value("disc.angle").unwrap(), 1.0, 1e-12, 1.0);
    assert_eq!(told(&statics, "free")[0].0, "ratchet");
    assert!(statics.standing.is_empty());
    let message = refused(&ratchet("0.3", 0.0), &[]);
    assert!(message.contains("`ratchet` would resist with 0.3 N.m"), "{message}");
    assert!(message.contains("there is no equilibrium in any of the 2 combinations"), "{message}");
    let message = refused(&ratchet("0.3", 0.0), &[("ratchet", "free")]);
    assert!(message.contains("still accelerating there: `disc.angle`"), "{message}");
}

#[test]
fn asking_for_the_mode_that_it_is_in_changes_nothing() {
    let names = [("main", "slides+"), ("big.friction", "slides-"), ("guide", "slides-")];
    let natural = linear(CRANK, 0.0, &[]).unwrap();
    let found: Vec<(&str, &str)> = words(&natural);
    assert_eq!(found, [("main.friction", "slides+"), ("big.friction", "slides-"), ("guide.friction", "slides-")]);
    let requested = linear(CRANK, 0.0, &names).unwrap();
    for (one, other) in [(&natural.a, &requested.a), (&natural.b, &requested.b), (&natural.c, &requested.c)] {
        assert_eq!(one, other);
    }
}

/// A heavy pendulum on a rough rail: how the cart slides changes what the bob pulls with, and so on which side the rail presses.
#[test]
fn what_presses_turns_with_the_mode_that_is_asked_for() {
    let cart = r#"
name = "cart"
gravity = [0, -9.81]
[bodies.cart]
mass = 0.5
[bodies.bob]
mass = 4.0
inertia = 0.01
points = { top = [-0.5, 0.5] }
[joints.rail]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
friction = { mu = 0.3 }
[joints.pin]
type = "revolute"
between = ["cart", "bob.top"]
[loads.lift]
type = "force"
on = "cart"
vector = [0, LIFT]
[initial]
"rail.s" = 0.0
"rail.v" = 0.0
"bob.angle" = 0.1
"bob.omega" = 0.5
[outputs]
variables = ["rail.fn", "rail.force"]
"#;
    let mut turned = 0;
    for lift in (0..60).map(|step| 10.0 + 0.5 * f64::from(step)) {
        let of = |mode: &str| linear(&cart.replace("LIFT", &format!("{lift:?}")), 0.0, &[("rail", mode)]);
        let found = ["sticks", "slides+", "slides-"].map(|mode| of(mode).ok());
        for (system, way) in found.iter().zip([0.0, 1.0, -1.0]) {
            let Some(system) = system else { continue };
            let [normal, friction] = [system.outputs[0].value, system.outputs[1].value];
            if way != 0.0 {
                close("friction", friction, -way * 0.3 * normal.abs(), 1e-11, 1.0);
            }
        }
        let signs = found.iter().flatten().map(|system| system.outputs[0].value.signum());
        turned += usize::from(signs.clone().any(|sign| sign > 0.0) && signs.clone().any(|sign| sign < 0.0));
    }
    assert!(turned > 0);
}

#[test]
fn contacts_and_freewheels_are_asked_for_too() {
    let contact = "\"disc.x\" = 0.0\n\"lane.gap\" = 0.0\n\"lane.v\" = 2.0\n\"disc.angle\" = 0.0";
    let disc = DISC.replace("JOINT", "contact").replace("START", contact);
    let flies = linear(&disc, 0.0, &[("lane", "open")]).unwrap();
    assert_eq!((words(&flies), flies.states.len()), (vec![("lane", "open"), ("lane.friction", "idle")], 6));
    // As without friction.
    let smooth = disc.replace("friction = { mu = 0.2 }\n", "").replace(", \"lane.ft\"", "");
    let smooth = smooth.replace("\"lane.v\" = 2.0\n", "\"disc.vx\" = 2.0\n");
    let free = linear(&smooth, 0.0, &[("lane", "open")]).unwrap();
    assert!((&flies.a - &free.a).amax() < 1e-12 && flies.a.amax() > 1.0);
    let because = |text: &str, modes: &[(&str, &str)], why: &str| {
        let message = linear(text, 0.0, modes).unwrap_err().to_string();
        assert!(message.contains(why), "{message}");
    };
    because(
        &disc,
        &[("lane", "open"), ("lane.friction", "slides+")],
        "has no friction force: its contact `lane` is open",
    );
    because(&TRAIN.replace("RING", "9.0"), &[("ratchet", "caught")], "`ratchet` cannot be caught: it turns by 9 rad/s");
    let train = TRAIN.replace("RING", "0.0");
    let [caught, free] = ["caught", "free"].map(|word| linear(&train, 0.0, &[("ratchet", word)]).unwrap());
    assert_eq!((caught.states.len() + 2, free.statuses[0].word()), (free.states.len(), "free"));
}
