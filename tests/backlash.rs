//! Couplings with play: closed forms of what flies from flank to flank, and a simulator in absolute coordinates.

use std::f64::consts::TAU;

use crate::support::ROOT;
use crate::support::one_sided::{Always, At, Motion, OneSided, Shape, World};
use crate::support::run::{model, scene_of, started, value};

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::program::Engine;

/// Two parts that a coupling with play joins: its text, what each weighs in its coordinate, how its relation depends on them, the names of the coordinates.
pub struct Pair {
    joint: String,
    weights: [f64; 2],
    factors: [f64; 2],
    slides: bool,
}

pub fn pairs(restitution: f64) -> Vec<Pair> {
    let backlash = format!("backlash = {{ play = 0.08, restitution = {restitution} }}");
    let wheels = |text: &str, ratio: f64| Pair {
        joint: format!("between = [\"first\", \"second\"]\n{text}\n{backlash}"),
        weights: [0.02, 0.05],
        factors: [-ratio, 1.0],
        slides: false,
    };
    let slides = |text: &str, factor: f64| Pair {
        joint: format!("between = [\"first\", \"second\"]\naxis = [1, 0]\n{text}\n{backlash}"),
        weights: [0.02, 0.7],
        factors: [-factor, 1.0],
        slides: true,
    };
    vec![
        wheels("type = \"gear\"\nratio = -0.6", -0.6),
        wheels("type = \"belt\"\nfirst_radius = 0.3\nsecond_radius = 0.2", 1.5),
        wheels("type = \"belt\"\nfirst_radius = 0.3\nsecond_radius = 0.2\nrun = \"crossed\"", -1.5),
        slides("type = \"rack\"\nradius = 0.25", 0.25),
        slides("type = \"screw\"\nlead = 1.1", 1.1 / TAU),
    ]
}

pub fn scene(pair: &Pair, start: [f64; 2], rates: [f64; 2]) -> String {
    let second = match pair.slides {
        true => "type = \"prismatic\"\nbetween = [\"ground\", \"second\"]\naxis = [1, 0]",
        false => "type = \"revolute\"\nbetween = [\"ground\", \"second\"]",
    };
    let [place, rate] = if pair.slides { ["b.s", "b.v"] } else { ["second.angle", "second.omega"] };
    let force = if pair.slides { "mesh.force" } else { "mesh.torque" };
    format!(
        r#"
name = "play"
[bodies]
first = {{ mass = 1.0, inertia = 0.02 }}
second = {{ mass = 0.7, inertia = 0.05 }}
[joints.a]
type = "revolute"
between = ["ground", "first"]
[joints.b]
{second}
[joints.mesh]
{}
[initial]
"first.angle" = {:?}
"{place}" = {:?}
"first.omega" = {:?}
"{rate}" = {:?}
[outputs]
variables = ["first.angle", "{place}", "first.omega", "{rate}", "{force}", "mesh.mode", "mesh.impulse"]
[experiment]
stop = "3 s"
tolerance = 1e-10
"#,
        pair.joint, start[0], start[1], rates[0], rates[1]
    )
}

/// By how much the relation is off, and its rate, where nothing acts but the flanks: it goes to and fro at constant rates.
fn off(mut at: f64, mut rate: f64, restitution: f64, time: f64) -> [f64; 2] {
    let (half, mut begin) = (0.04, 0.0);
    loop {
        let way = if rate > 0.0 { half - at } else { half + at };
        if rate == 0.0 || begin + way / rate.abs() > time {
            return [at + rate * (time - begin), rate];
        }
        (begin, at, rate) = (begin + way / rate.abs(), half.copysign(rate), -restitution * rate);
    }
}

#[test]
fn couplings_with_play_fly_from_flank_to_flank() {
    for restitution in [0.0, 0.5, 1.0] {
        for (kind, pair) in pairs(restitution).iter().enumerate() {
            let (start, rates) = ([0.3, 0.3 * -pair.factors[0] + 0.01], [1.1, -0.2]);
            let inverse: f64 = [0, 1].map(|i| pair.factors[i] * pair.factors[i] / pair.weights[i]).iter().sum();
            let rate = pair.factors[0] * rates[0] + pair.factors[1] * rates[1];
            let model = model(&scene(pair, start, rates));
            for engine in [Engine::Taylor, Engine::Dop853] {
                let mut run = started(&model, Some(engine), 3.0, 1e-10);
                for time in [0.02, 0.2, 0.61, 1.3, 2.94] {
                    run.step_to(time).unwrap();
                    let [place, now] = off(0.01, rate, restitution, time);
                    for i in 0..2 {
                        let share = pair.factors[i] / pair.weights[i] / inverse;
                        let expected = [
                            start[i] + rates[i] * time + share * (place - 0.01 - rate * time),
                            rates[i] + share * (now - rate),
                        ];
                        let names = match (i, pair.slides) {
                            (0, _) => ["first.angle", "first.omega"],
                            (_, true) => ["b.s", "b.v"],
                            (_, false) => ["second.angle", "second.omega"],
                        };
                        let found = names.map(|name| value(&mut run, name));
                        assert!(
                            (found[0] - expected[0]).abs() < 1e-11 && (found[1] - expected[1]).abs() < 1e-10,
                            "{kind} {restitution} {engine:?} {names:?} at {time} s: {found:?} {expected:?}"
                        );
                    }
                }
                // The last impulse acts on the second part, with the sign of its motion.
                let impulse = value(&mut run, "mesh.impulse");
                if restitution == 0.0 {
                    let expected = -rate / inverse;
                    assert!((impulse - expected).abs() < 1e-12, "{kind}: {impulse} {expected}");
                }
            }
        }
    }
}

/// A pressed flank is the coupling without play: same accelerations, same torques.
#[test]
fn a_pressed_flank_is_the_coupling_without_play() {
    let torque = "[loads.motor]\ntype = \"torque\"\non = \"first\"\nvalue = 0.3\n[initial]";
    for (kind, pair) in pairs(0.0).iter().enumerate() {
        // On the flank that the torque presses, at the same rates.
        let side = -pair.factors[0].signum();
        let start = [0.2, -0.2 * pair.factors[0] - 0.04 * side];
        let rates = [0.7, -0.7 * pair.factors[0]];
        let with = scene(pair, start, rates).replace("[initial]", torque);
        let key = if pair.slides { "displacement" } else { "angle" };
        let held = format!("{key} = {:?}", -0.04 * side);
        let (before, after) = with.split_once("backlash").unwrap();
        let after = after.split_once('\n').unwrap().1;
        let without = format!("{before}{held}\n{after}");
        let place = if pair.slides { "b.s" } else { "second.angle" };
        let without: String = without
            .lines()
            .filter(|line| {
                !["\"b.s\" =", "\"b.v\" =", "\"second.angle\" =", "\"second.omega\" ="]
                    .iter()
                    .any(|own| line.starts_with(own))
            })
            .map(|line| format!("{line}\n"))
            .collect();
        let without = without.replace(", \"mesh.mode\", \"mesh.impulse\"", "");
        let mut one = started(&model(&with), None, 3.0, 1e-10);
        let mut other = started(&model(&without), None, 3.0, 1e-10);
        let force = if pair.slides { "mesh.force" } else { "mesh.torque" };
        for time in [0.0, 0.4, 1.0] {
            if time > 0.0 {
                one.step_to(time).unwrap();
                other.step_to(time).unwrap();
            }
            for name in ["first.angle", place, "first.omega", force] {
                let (found, expected) = (value(&mut one, name), value(&mut other, name));
                assert!((found - expected).abs() < 1e-10, "{kind} {name} at {time} s: {found} {expected}");
            }
            assert_eq!(value(&mut one, "mesh.mode"), -side, "{kind} at {time} s");
        }
    }
}

fn wheel(body: usize, at: f64) -> [Always; 2] {
    let along = |axis: [f64; 2]| Always {
        shape: Shape::Along([At(None, [at, 0.0]), At(Some(body), [0.0, 0.0])], axis),
        bound: 0.0,
    };
    [along([1.0, 0.0]), along([0.0, 1.0])]
}

fn flanks(terms: Vec<(usize, f64)>, play: f64, restitution: f64) -> [OneSided; 2] {
    [1.0, -1.0].map(|sign| OneSided {
        shape: Shape::Angle(terms.clone()),
        sign,
        bound: -0.5 * sign * play,
        restitution,
        of_rate: false,
    })
}

/// The model `play_train`: a motor that reverses drives a flywheel through two pairs of wheels with play.
fn train() -> (World, Motion) {
    let mut world = World {
        bodies: vec![[0.5, 4e-4], [1.2, 2.5e-3], [3.0, 2e-2]],
        always: [wheel(0, 0.0), wheel(1, 0.12), wheel(2, 0.3)].concat(),
        torques: vec![(0, |t, _, _| 0.8 * (std::f64::consts::TAU * t).sin())],
        dampings: vec![([None, Some(2)], [0.0, 0.02])],
        ..World::default()
    };
    world.one_sided.extend(flanks(vec![(1, 1.0), (0, 0.5)], 0.03, 0.3));
    world.one_sided.extend(flanks(vec![(2, 1.0), (1, 0.5)], 0.02, 0.3));
    let q = vec![0.0, 0.0, 0.0, 0.12, 0.0, 0.0, 0.3, 0.0, 0.0];
    let start = world.start(q, vec![0.0; 9]);
    (world, start)
}

#[test]
fn a_train_with_play_follows_absolute_coordinates() {
    let path = format!("{ROOT}/models/play_train/expected.csv");
    let names = ["motor.angle", "motor.omega", "middle.angle", "middle.omega", "flywheel.angle", "flywheel.omega"];
    let (world, mut own) = train();
    let mut run = started(&model(&scene_of("play_train")), None, 2.0, 1e-10);
    let mut text = format!("time,{}\n", names.join(","));
    for row in 0..=100 {
        let time = 0.02 * f64::from(row);
        if row > 0 {
            world.go_to(&mut own, time);
            run.step_to(time).unwrap();
        }
        let expected = [own.q[2], own.v[2], own.q[5], own.v[5], own.q[8], own.v[8]];
        text += &format!("{time:.2}");
        for (name, expected) in names.iter().zip(expected) {
            let found = value(&mut run, name);
            assert!((found - expected).abs() < 1e-7 * (1.0 + expected.abs()), "{name} at {time} s: {found} {expected}");
            text += &format!(",{expected:.12e}");
        }
        text.push('\n');
    }
    assert!(own.impacts > 20, "{} impacts", own.impacts);
    if std::env::var_os("COTREE_WRITE_EXPECTED").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap();
    for (stored, text) in stored.lines().zip(text.lines()).skip(1) {
        let [stored, text] =
            [stored, text].map(|row| row.split(',').map(|cell| cell.parse::<f64>().unwrap()).collect::<Vec<_>>());
        assert!(stored.iter().zip(&text).all(|(a, b)| (a - b).abs() < 1e-9), "{stored:?} {text:?}");
    }
}

#[test]
fn what_is_wrong_with_play_is_said() {
    let fault = |text: &str| Scene::from_toml(text).and_then(|scene| compile(&scene)).expect_err("a fault").to_string();
    let gear = scene(&pairs(0.5)[0], [0.0, 0.0], [1.0, 0.0]);
    for (text, expected) in [
        ("{ play = 0, restitution = 0.5 }", "positive"),
        ("{ restitution = 0.5 }", "play"),
        ("{ play = \"1 mm\" }", "angle"),
        ("{ play = 0.1, restitution = 1.2 }", "from 0 to 1"),
        ("{ play = 0.1, min = 0.2 }", "min"),
    ] {
        let found = fault(&gear.replace("{ play = 0.08, restitution = 0.5 }", text));
        assert!(found.contains(expected), "{text}: {found}");
    }
    let beyond = fault(&gear.replace("\"second.angle\" = 0.0", "\"second.angle\" = 0.05"));
    assert!(beyond.contains("the start is beyond `mesh.max`"), "{beyond}");
    let without = fault(&gear.replace("backlash = { play = 0.08, restitution = 0.5 }", ""));
    assert!(without.contains("mesh.mode"), "{without}");
    let driven = gear
        .replace("\"first.omega\" = 1.0\n", "")
        .replace("\"first.angle\" = 0.0\n", "")
        .replace("\"second.angle\" = 0.0\n", "")
        .replace("\"second.omega\" = 0.0\n", "");
    let drivers =
        "[drivers]\none = { joint = \"a\", angle = \"t\" }\nother = { joint = \"b\", angle = \"-0.5*t\" }\n[initial]";
    let driven = fault(&driven.replace("[initial]", drivers));
    assert!(driven.contains("a prescribed motion cannot stop"), "{driven}");
}
