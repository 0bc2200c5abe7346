//! Followers that lift off their cams: flights in closed form, the same cam held both ways up to where it would have to pull, and a simulator in absolute coordinates.

use std::f64::consts::TAU;

use crate::support::ROOT;
use crate::support::cam::{Cam, Random};
use crate::support::one_sided::{Always, At, OneSided, Shape, World};
use crate::support::run::{distance, model, motion, scene_of, started, value};

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::program::Engine;

const MASS: f64 = 0.3;
const STIFFNESS: f64 = 2400.0;
const LIFT: f64 = 0.01;
/// Of the follower over the shaft on the base circle, and where the spring is free.
const BASE: f64 = 0.04;
const FREE: f64 = 0.02;

pub fn lifter(speed: f64, restitution: f64) -> String {
    format!(
        r#"
name = "lifter"
[bodies.disc]
mass = 1.0
inertia = 0.01
[bodies.lifter]
mass = {MASS}
[joints.shaft]
type = "revolute"
between = ["ground", "disc"]
[joints.guide]
type = "prismatic"
between = ["ground", "lifter"]
axis = [0, 1]
[joints.contact]
type = "cam"
between = ["disc", "lifter"]
shaft = "shaft"
guide = "guide"
base = 0.03
roller = 0.01
law = "{LIFT}*(1 - cos(angle))/2"
unilateral = {{ restitution = {restitution} }}
[loads.spring]
type = "force"
on = "lifter"
vector = [0, "{STIFFNESS}*({FREE} - lifter.y)"]
[drivers.motor]
joint = "shaft"
angle = "{speed}*t"
[initial]
"guide.s" = {BASE}
"guide.v" = 0
[outputs]
variables = ["guide.s", "guide.v", "contact.fn", "contact.mode", "contact.pressure_angle"]
[experiment]
stop = "1 s"
tolerance = 1e-10
"#
    )
}

/// Height and speed of the cam under the follower.
fn cam(speed: f64, time: f64) -> [f64; 2] {
    let (sine, cosine) = (speed * time).sin_cos();
    [BASE + 0.5 * LIFT * (1.0 - cosine), 0.5 * LIFT * speed * sine]
}

/// What the cam presses with where the follower touches it.
fn pressure(speed: f64, time: f64) -> f64 {
    MASS * 0.5 * LIFT * speed * speed * (speed * time).cos() + STIFFNESS * (cam(speed, time)[0] - FREE)
}

/// The follower on its spring alone.
fn flight([s, v]: [f64; 2], time: f64) -> [f64; 2] {
    let omega = (STIFFNESS / MASS).sqrt();
    let (sine, cosine) = (omega * time).sin_cos();
    [FREE + (s - FREE) * cosine + v / omega * sine, (FREE - s) * omega * sine + v * cosine]
}

fn first_zero(mut from: f64, step: f64, end: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    while from < end {
        if f(from + step) < 0.0 {
            let [mut before, mut after] = [from, from + step];
            for _ in 0..60 {
                let middle = 0.5 * (before + after);
                *(if f(middle) < 0.0 { &mut after } else { &mut before }) = middle;
            }
            return Some(after);
        }
        from += step;
    }
    None
}

/// What the follower does: on the cam since a time, or flying since a time from a place. An impact that leaves less than 1e-7 m/s is the last.
fn follower(speed: f64, restitution: f64, times: &[f64]) -> Vec<[f64; 3]> {
    let (mut now, mut flying, mut apex): (f64, Option<[f64; 2]>, f64) = (0.0, None, 1e-6);
    let mut found = Vec::new();
    let mut next = times.iter().copied().peekable();
    while next.peek().is_some() {
        let end = match flying {
            None => first_zero(now, 1e-5, 1.1, |time| pressure(speed, time)).unwrap_or(1.1),
            Some(start) => {
                // At first it is above the cam by less than rounding errors.
                let gap = |time: f64| flight(start, time - now)[0] - cam(speed, time)[0];
                first_zero(now + apex, apex, 1.1, gap).unwrap_or(1.1)
            }
        };
        while let Some(time) = next.next_if(|time| *time <= end) {
            found.push(match flying {
                None => [cam(speed, time)[0], cam(speed, time)[1], pressure(speed, time)],
                Some(start) => {
                    let [s, v] = flight(start, time - now);
                    [s, v, 0.0]
                }
            });
        }
        let (force, [_, under]) = (pressure(speed, end), cam(speed, end));
        apex = 1e-6;
        flying = match flying {
            None => Some(cam(speed, end)),
            Some(start) => {
                let [s, v] = flight(start, end - now);
                let rebound = restitution * (under - v);
                // A short flight is highest where what presses has taken its speed.
                apex = if force > 0.0 { apex.min(rebound * MASS / force) } else { apex };
                if rebound < 1e-7 && force > 0.0 { None } else { Some([s, under + rebound]) }
            }
        };
        now = end;
    }
    found
}

#[test]
fn a_follower_on_a_spring_lifts_off_and_lands() {
    // On top the cam falls away as fast as the spring follows at this speed.
    let most = (STIFFNESS * (BASE + LIFT - FREE) / (MASS * 0.5 * LIFT)).sqrt();
    let times: Vec<f64> = (1..=40).map(|step| 0.005 * f64::from(step)).collect();
    for (speed, restitution) in [(0.98 * most, 0.3), (1.08 * most, 0.0), (1.08 * most, 0.4), (1.5 * most, 0.5)] {
        let expected = follower(speed, restitution, &times);
        let lifts = expected.iter().any(|[.., force]| *force == 0.0);
        assert_eq!(lifts, speed > most);
        for engine in [Engine::Taylor, Engine::Dop853, Engine::Radau] {
            let mut run = started(&model(&lifter(speed, restitution)), Some(engine), 1.0, 1e-10);
            for (&time, expected) in times.iter().zip(&expected) {
                run.step_to(time).unwrap();
                for (name, (expected, size)) in
                    ["guide.s", "guide.v", "contact.fn"].iter().zip(expected.iter().zip([0.01, 1.0, 100.0]))
                {
                    // The normal force has a part across the guide.
                    let share =
                        if *name == "contact.fn" { value(&mut run, "contact.pressure_angle").cos() } else { 1.0 };
                    let found = value(&mut run, name) * share;
                    assert!(
                        (found - expected).abs() < 1e-7 * size,
                        "{speed} {restitution} {engine:?} {name} at {time} s: {found} {expected}"
                    );
                }
            }
        }
    }
}

/// Nobody says where the follower is: then it is where the same cam has it that holds both ways, moves with it, and goes on from there.
#[test]
fn a_follower_without_a_place_starts_on_its_cam() {
    let unplaced = |angle: &str| {
        let text = lifter(20.0, 0.3).replace("angle = \"20*t\"", &format!("angle = \"{angle}\""));
        text.lines().filter(|line| !line.starts_with("\"guide.")).fold(String::new(), |all, line| all + line + "\n")
    };
    for angle in ["20*t", "20*t + 1", "20*t - 2"] {
        let text = unplaced(angle);
        let both_ways: String = text
            .lines()
            .filter(|line| !line.starts_with("unilateral"))
            .fold(String::new(), |all, line| all + line + "\n")
            .replace(", \"contact.mode\"", "");
        for engine in [Engine::Taylor, Engine::Dop853, Engine::Radau] {
            let mut runs = [&text, &both_ways].map(|text| started(&model(text), Some(engine), 1.0, 1e-10));
            for time in [0.0, 0.01, 0.1] {
                let found = runs.each_mut().map(|run| {
                    if time > 0.0 {
                        run.step_to(time).unwrap();
                    }
                    ["guide.s", "guide.v", "contact.fn"].map(|name| value(run, name))
                });
                for (own, (other, size)) in found[0].into_iter().zip(found[1].into_iter().zip([0.01, 1.0, 100.0])) {
                    assert!((own - other).abs() < 1e-7 * size, "{angle} {engine:?} at {time} s: {found:?}");
                }
            }
        }
    }
}

/// Random cams of all kinds, whose followers a force or a torque presses that ceases in time: up to where the same cam that holds both ways begins to pull, both move alike; there the follower is let go.
#[test]
fn followers_of_all_kinds_lift_off_where_they_would_be_pulled() {
    let mut random = Random(8);
    let mut lifted = 0;
    for case in 0..8 {
        let cam = if case % 2 == 0 {
            Cam::sliding(&mut random, case / 2 % 2 == 1)
        } else {
            Cam::turning(&mut random, case / 2 % 2 == 1)
        };
        let side = ["left", "right"][case / 4 % 2];
        let [place, rate] = if cam.turning { ["guide.angle", "guide.omega"] } else { ["guide.s", "guide.v"] };
        // Towards the cam: down a slide; the other way than a turning follower rises.
        let inwards = if cam.turning && side == "left" { 1.0 } else { -1.0 };
        let push = match cam.turning {
            true => format!(
                "[loads.push]\ntype = \"torque\"\nbetween = [\"ground\", \"follower\"]\nvalue = \"{}*(0.6 - t)\"\n",
                0.4 * inwards
            ),
            false => slide_push(&cam),
        };
        let more = format!(
            "{push}[drivers.motor]\njoint = \"shaft\"\nangle = \"0.3 + 6*t\"\n[outputs]\nvariables = [\"{place}\", \"{rate}\", \"contact.fn\"]\n[experiment]\nstop = 1.2\ntolerance = 1e-10\n"
        );
        let text = cam.scene(side, &more);
        let both = model(&text);
        let mut run = started(&both, None, 1.2, 1e-10);
        let begin = [place, rate].map(|name| value(&mut run, name));
        if value(&mut run, "contact.fn") <= 0.0 {
            continue;
        }
        let force = |time: f64| {
            let mut run = started(&both, None, 1.2, 1e-10);
            run.step_to(time).unwrap();
            value(&mut run, "contact.fn")
        };
        let mut time = 0.0;
        while time < 1.19 && value(&mut run, "contact.fn") > 0.0 {
            time += 0.01;
            run.step_to(time).unwrap();
        }
        if time >= 1.19 {
            continue;
        }
        let [mut from, mut to] = [time - 0.01, time];
        for _ in 0..24 {
            let middle = 0.5 * (from + to);
            *(if force(middle) > 0.0 { &mut from } else { &mut to }) = middle;
        }
        let one = text
            .replace("[joints.contact]\n", "[joints.contact]\nunilateral = { restitution = 0.2 }\n")
            .replace("\"contact.fn\"]", "\"contact.fn\", \"contact.mode\"]")
            .replace(
                "[drivers.motor]",
                &format!("[initial]\n\"{place}\" = {:?}\n\"{rate}\" = {:?}\n[drivers.motor]", begin[0], begin[1]),
            );
        let mut own = started(&model(&one), None, 1.2, 1e-10);
        let mut held = started(&both, None, 1.2, 1e-10);
        for time in [0.3 * to, 0.8 * to, to - 1e-6] {
            own.step_to(time).unwrap();
            held.step_to(time).unwrap();
            for name in [place, rate, "contact.fn"] {
                let (found, expected) = (value(&mut own, name), value(&mut held, name));
                assert!(
                    (found - expected).abs() < 1e-7 * (1.0 + expected.abs()),
                    "{case} {name} at {time} s: {found} {expected}"
                );
            }
            assert_eq!(value(&mut own, "contact.mode"), 1.0, "{case} at {time} s");
        }
        own.step_to(to + 1e-6).unwrap();
        assert_eq!(value(&mut own, "contact.mode"), 0.0, "{case}");
        // It moves away from the cam.
        let later = to + 2e-3;
        own.step_to(later).unwrap();
        held.step_to(later).unwrap();
        let away = -inwards * (value(&mut own, place) - value(&mut held, place));
        assert!(away > 0.0 || value(&mut own, "contact.mode") == 1.0, "{case}: {away}");
        lifted += 1;
    }
    assert!(lifted > 4, "{lifted} of 8");
}

/// A force on the follower against its axis, which ceases in time.
fn slide_push(cam: &Cam) -> String {
    let text = cam.scene("left", "");
    let axis = text.lines().find_map(|line| line.strip_prefix("axis = [")).unwrap().trim_end_matches(']').to_owned();
    let [x, y] = axis.split(", ").map(|part| part.parse::<f64>().unwrap()).collect::<Vec<_>>()[..] else {
        panic!("{axis}")
    };
    format!(
        "[loads.push]\ntype = \"force\"\non = \"follower\"\nvector = [\"{:?}*(0.6 - t)\", \"{:?}*(0.6 - t)\"]\n",
        -8.0 * x,
        -8.0 * y
    )
}

/// The model `valve_train`: a free shaft with a flywheel, slowed by what it does, and a valve on a spring.
#[test]
fn a_valve_train_follows_absolute_coordinates() {
    let along = |body: usize, axis: [f64; 2]| Always {
        shape: Shape::Along([At(None, [0.0, 0.0]), At(Some(body), [0.0, 0.0])], axis),
        bound: 0.0,
    };
    let world = World {
        bodies: vec![[1.0, 2e-3], [0.12, 1.0]],
        always: vec![
            along(0, [1.0, 0.0]),
            along(0, [0.0, 1.0]),
            along(1, [1.0, 0.0]),
            Always { shape: Shape::Angle(vec![(1, 1.0)]), bound: 0.0 },
        ],
        one_sided: vec![OneSided {
            shape: Shape::Cam { cam: 0, follower: 1, base: 0.033, lift: 0.009 },
            sign: 1.0,
            bound: 0.0,
            restitution: 0.35,
            of_rate: false,
        }],
        torques: vec![(0, |_, _, v| 2.0 - 0.004 * v[2])],
        lifts: vec![(1, |_, q, v| 2500.0 * (0.026 - q[4]) - 4.0 * v[4])],
        ..World::default()
    };
    let start = vec![0.0, 0.0, 0.0, 0.0, 0.033, 0.0];
    let mut own = world.start(start, vec![0.0, 0.0, 220.0, 0.0, 0.0, 0.0]);
    let names = ["camshaft.angle", "camshaft.omega", "guide.s", "guide.v"];
    let path = format!("{ROOT}/models/valve_train/expected.csv");
    let mut run = started(&model(&scene_of("valve_train")), None, 0.25, 1e-10);
    let mut text = format!("time,{}\n", names.join(","));
    for row in 0..=125 {
        let time = 0.002 * f64::from(row);
        if row > 0 {
            // Steps of an eighth of what is printed: the valve swings fast.
            for part in 1..=8 {
                world.go_to(&mut own, time - 0.002 + 0.00025 * f64::from(part));
            }
            run.step_to(time).unwrap();
        }
        text += &format!("{time:.3}");
        for (name, (expected, size)) in
            names.iter().zip([own.q[2], own.v[2], own.q[4], own.v[4]].into_iter().zip([1.0, 100.0, 0.01, 1.0]))
        {
            let found = value(&mut run, name);
            assert!((found - expected).abs() < 1e-6 * size, "{name} at {time} s: {found} {expected}");
            text += &format!(",{expected:.12e}");
        }
        text.push('\n');
    }
    assert!(own.impacts > 10, "{} impacts", own.impacts);
    if std::env::var_os("COTREE_WRITE_EXPECTED").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap();
    for (stored, text) in stored.lines().zip(text.lines()).skip(1) {
        let [stored, text] =
            [stored, text].map(|row| row.split(',').map(|cell| cell.parse::<f64>().unwrap()).collect::<Vec<_>>());
        assert!(stored.iter().zip(&text).all(|(a, b)| (a - b).abs() < 1e-9 * (1.0 + b.abs())), "{stored:?} {text:?}");
    }
}

/// With its 81 impacts and seven lift-offs.
#[test]
fn a_valve_train_moves_alike_by_series_and_by_runge_kutta() {
    let model = model(&scene_of("valve_train"));
    let mut runs = [Engine::Taylor, Engine::Dop853].map(|engine| started(&model, Some(engine), 0.25, 1e-13));
    for row in 1..=125 {
        let motions = runs.each_mut().map(|run| {
            run.step_to(0.002 * f64::from(row)).unwrap();
            motion(run)
        });
        let error = distance(&motions[0], &motions[1]);
        assert!(error < 1e-11, "row {row}: {error}");
    }
    assert_eq!(runs[0].statistics().fallbacks, 0);
}

#[test]
fn what_is_wrong_with_a_cam_that_lets_go_is_said() {
    let fault = |text: &str| Scene::from_toml(text).and_then(|scene| compile(&scene)).expect_err("a fault").to_string();
    let sound = lifter(TAU, 0.3);
    let both = fault(&sound.replace("roller = 0.01", "roller = 0.01\nclosure = \"form\""));
    assert!(both.contains("guides its follower in both directions"), "{both}");
    let below = fault(&sound.replace("\"guide.s\" = 0.04", "\"guide.s\" = 0.039"));
    assert!(below.contains("the start is beyond `contact`"), "{below}");
    let share = fault(&sound.replace("restitution = 0.3", "restitution = -0.3"));
    assert!(share.contains("from 0 to 1"), "{share}");
    let driven = fault(&sound.replace(
        "[initial]\n\"guide.s\" = 0.04\n\"guide.v\" = 0\n",
        "[drivers.lift]\njoint = \"guide\"\ndisplacement = \"0.06\"\n",
    ));
    assert!(driven.contains("a prescribed motion cannot stop"), "{driven}");
}
