//! Springs and dampers whose ends come together: where their force has a limit it is that limit, whatever the guess; where it has none they are refused.
//! Everything is compared with closed forms.

use crate::support::hard::random as split_mix;
use crate::support::run;

use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::model::Model;
use cotree_study::analysis::{LinearisedAt, Study};

use run::sound;
use split_mix::Random;

const MEMBERS: u64 = 60;

/// A body on a rail, held by springs of free length zero and dampers that end where it rests.
struct Guided {
    mass: f64,
    stiffness: f64,
    damping: f64,
    text: String,
}

/// The rail has any direction, its ends are anywhere, and half of the rails are on an arm that is welded somewhere.
fn guided(random: &mut Random, start: f64, speed: f64) -> Guided {
    let [mass, stiffness, damping] = [(0.5, 3.0), (20.0, 200.0), (0.5, 15.0)].map(|(a, b)| random.between(a, b));
    let (angle, turned) = (random.between(-3.0, 3.0), random.between(-3.0, 3.0));
    let (axis, along) = if random.unit() < 0.5 { ([1.0, 0.0], 0.0) } else { ([angle.cos(), angle.sin()], 0.3) };
    let at = [along * axis[0], along * axis[1]];
    let apart = random.unit() < 0.5;
    let loads = match apart {
        true => format!(
            "[loads.k]\ntype = \"spring\"\nbetween = [\"rail.at\", \"b\"]\nstiffness = {stiffness:e}\n[loads.c]\ntype = \"damper\"\nbetween = [\"b\", \"rail.at\"]\ndamping = {damping:e}\n"
        ),
        false => format!(
            "[loads.k]\ntype = \"spring\"\nbetween = [\"b\", \"rail.at\"]\nstiffness = {stiffness:e}\ndamping = {damping:e}\n"
        ),
    };
    let text = format!(
        "name = \"g\"\n[bodies.rail]\nmass = 1\ninertia = 1\npoints = {{ at = [{:e}, {:e}] }}\n[bodies.b]\nmass = {mass:e}\ninertia = 1\n\
         [joints.foot]\ntype = \"weld\"\nbetween = [\"ground\", \"rail\"]\nangle = {turned:e}\n\
         [joints.g]\ntype = \"prismatic\"\nbetween = [\"rail\", \"b\"]\naxis = [{:e}, {:e}]\n{loads}\
         [initial]\n\"g.s\" = {:e}\n\"g.v\" = {speed:e}\n[outputs]\nvariables = [\"g.s\", \"g.v\", \"g.a\", \"k.length\", \"k.rate\", \"k.force\", \"k.power\"]\n",
        at[0],
        at[1],
        axis[0],
        axis[1],
        along + start
    );
    Guided { mass, stiffness, damping, text }
}

/// A distance of any size, or none.
fn near(random: &mut Random) -> f64 {
    match random.unit() {
        share if share < 0.1 => 0.0,
        _ => 10.0_f64.powf(random.between(-300.0, -3.0)) * if random.unit() < 0.5 { -1.0 } else { 1.0 },
    }
}

#[test]
fn along_a_guide_the_modes_are_those_of_a_spring_and_a_damper() {
    for seed in 0..MEMBERS {
        let random = &mut Random(seed);
        let start = near(random);
        let own = guided(random, start, 0.0);
        let scene = sound(Scene::from_toml(&own.text));
        let found =
            sound(Study::new(&scene)).modes(None).unwrap_or_else(|error| panic!("{seed}: {error}\n{}", own.text));
        let expected = own.damping / (2.0 * (own.stiffness * own.mass).sqrt());
        let ratios: Vec<f64> = found.modes.iter().filter_map(|mode| mode.damping_ratio()).collect();
        let squares: f64 = found.modes.iter().map(|mode| mode.eigenvalue.norm()).product();
        let speed = (own.stiffness / own.mass).sqrt();
        if expected < 1.0 {
            assert!(ratios.len() == 1 && (ratios[0] - expected).abs() < 1e-9, "{seed}: {ratios:?} {expected}");
            assert!((squares / speed - 1.0).abs() < 1e-9, "{seed}: {squares} {speed}");
        } else {
            assert!((squares / speed.powi(2) - 1.0).abs() < 1e-9, "{seed}: {squares} {speed}");
        }
    }
}

#[test]
fn linear_systems_along_a_guide_have_the_closed_form() {
    for seed in 0..MEMBERS / 3 {
        let random = &mut Random(100 + seed);
        let start = near(random);
        let own = guided(random, start, 0.0);
        let text = own.text.replace(", \"k.length\", \"k.rate\", \"k.force\", \"k.power\"", "");
        let mut study = sound(Study::new(&sound(Scene::from_toml(&text))));
        let system = study.linearize(&LinearisedAt::Equilibrium).unwrap_or_else(|error| panic!("{seed}: {error}"));
        let a = &system.points[0].a;
        let expected = [[0.0, 1.0], [-own.stiffness / own.mass, -own.damping / own.mass]];
        for (row, entries) in expected.iter().enumerate() {
            for (column, entry) in entries.iter().enumerate() {
                assert!((a[(row, column)] - entry).abs() < 1e-9 * (1.0 + entry.abs()), "{seed}: {a}");
            }
        }
        if start == 0.0 {
            // The length itself has a corner there.
            let mut study = sound(Study::new(&sound(Scene::from_toml(&own.text))));
            let system = study.linearize(&LinearisedAt::Equilibrium).expect("a linear system").points.remove(0);
            let length = system.outputs.iter().position(|output| output.name == "k.length").expect("an output");
            assert!(system.c[(length, 0)].is_nan(), "{seed}: {}", system.c);
            let warned = study.take_warnings().expect("a warning").to_string();
            assert!(warned.contains("`d(k.length)` has no value"), "{seed}: {warned}");
        }
    }
}

/// x(t) and x'(t) of a damped oscillator.
fn oscillator([mass, stiffness, damping]: [f64; 3], [x, v]: [f64; 2], t: f64) -> [f64; 2] {
    let (rate, square) = (damping / (2.0 * mass), stiffness / mass);
    let discriminant = rate * rate - square;
    // cosh and sinh/omega, or cos and sin/omega.
    let omega = discriminant.abs().sqrt();
    let (c, s) = match discriminant > 0.0 {
        true => ((omega * t).cosh(), (omega * t).sinh() / omega),
        false => ((omega * t).cos(), (omega * t).sin() / omega),
    };
    let decay = (-rate * t).exp();
    [decay * (x * c + (v + rate * x) * s), decay * (v * c - (square * x + rate * v) * s)]
}

fn ran(text: &str, stop: f64, names: &[&str]) -> Vec<f64> {
    let model = Arc::new(Model::new(sound(compile(&sound(Scene::from_toml(text)))).program).expect("sound"));
    let mut instance = run::started(&model, None, 1.0, 1e-9);
    if stop > 0.0 {
        instance.step_to(stop).unwrap_or_else(|failure| panic!("{failure:?}\n{text}"));
    }
    names.iter().map(|name| run::value(&mut instance, name)).collect()
}

#[test]
fn motions_along_a_guide_start_and_pass_where_the_ends_are_together() {
    for seed in 0..MEMBERS / 2 {
        let random = &mut Random(200 + seed);
        let (start, speed) = (if seed % 3 == 0 { 0.0 } else { near(random) }, random.between(-2.0, 2.0));
        let own = guided(random, start, speed);
        let along = if own.text.contains("axis = [1e0, 0e0]") { 0.0 } else { 0.3 };
        for stop in [0.0, 0.7] {
            let found = ran(&own.text, stop, &["g.s", "g.v", "g.a", "k.length", "k.rate"]);
            let [x, v] = oscillator([own.mass, own.stiffness, own.damping], [start, speed], stop);
            let a = -(own.stiffness * x + own.damping * v) / own.mass;
            let expected = [along + x, v, a, x.abs()];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6 * (1.0 + expected.abs()), "{seed} {stop}: {found} {expected}");
            }
            // Of a spring alone, next to its end, what is beside the guide is rounding, and may turn the line.
            let is_certain = x == 0.0 || x.abs() > 1e-9;
            let (rate, speed) = (found[4].abs(), v.abs());
            assert!(
                rate < speed + 1e-6 && (!is_certain || rate > speed - 1e-6 || x == 0.0),
                "{seed} {stop}: {rate} {v}"
            );
        }
    }
}

/// A free body on a spring of free length zero: F = -k r is smooth in the plane.
#[test]
fn in_the_plane_a_spring_of_no_length_is_smooth_and_a_damper_is_refused() {
    for seed in 0..MEMBERS / 3 {
        let random = &mut Random(300 + seed);
        let (mass, stiffness) = (random.between(0.5, 3.0), random.between(20.0, 200.0));
        let [x, y] = [near(random), near(random)];
        let [vx, vy] = [random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
        let scene = |damping: f64, [vx, vy]: [f64; 2]| {
            format!(
                "name = \"p\"\n[bodies.b]\nmass = {mass:e}\ninertia = 1\n[loads.k]\ntype = \"spring\"\nbetween = [\"ground\", \"b\"]\nstiffness = {stiffness:e}\ndamping = {damping:e}\n\
                 [loads.turn]\ntype = \"torsion_spring\"\nbetween = [\"ground\", \"b\"]\nstiffness = 3\n\
                 [initial]\n\"b.x\" = {x:e}\n\"b.y\" = {y:e}\n\"b.angle\" = 0\n\"b.vx\" = {vx:e}\n\"b.vy\" = {vy:e}\n\"b.omega\" = 0\n[outputs]\nvariables = [\"b.x\", \"b.y\"]\n"
            )
        };
        let modes = |text: &str| sound(Study::new(&sound(Scene::from_toml(text)))).modes(None);
        let found = modes(&scene(0.0, [0.0; 2])).unwrap_or_else(|error| panic!("{seed}: {error}"));
        let omega = (stiffness / mass).sqrt();
        let same = found.modes.iter().filter(|mode| (mode.eigenvalue.im - omega).abs() < 1e-9 * omega);
        assert_eq!(same.count(), 2, "{seed}: {:?}", found.modes);
        for stop in [0.0, 0.9] {
            let place = ran(&scene(0.0, [vx, vy]), stop, &["b.x", "b.y", "b.ax"]);
            let expected = [[x, vx], [y, vy]].map(|start| oscillator([mass, stiffness, 0.0], start, stop)[0]);
            assert!(
                (place[0] - expected[0]).abs() < 1e-7 && (place[1] - expected[1]).abs() < 1e-7,
                "{seed}: {place:?}"
            );
            assert!((place[2] + stiffness / mass * place[0]).abs() < 1e-9, "{seed}: {place:?}");
        }
        let refused = modes(&scene(2.0, [0.0; 2]));
        let why = refused.map_or_else(|error| error.to_string(), |found| format!("{:?}", found.modes));
        assert!(why.contains("coincide"), "{seed}: {why}");
        let linear =
            sound(Study::new(&sound(Scene::from_toml(&scene(2.0, [0.0; 2]))))).linearize(&LinearisedAt::Equilibrium);
        assert!(linear.is_err(), "{seed}");
    }
}
