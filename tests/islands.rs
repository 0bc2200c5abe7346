//! Many parts that do not act on each other move as each of them does alone, and are not refused for their number: rubbing pendulums, discs and boxes that land together, pairs of wheels, sliders between stops.

use crate::support::run::{model, started, value};

const GRAVITY: f64 = 9.81;
const TOLERANCE: f64 = 1e-9;
const TIMES: [f64; 4] = [0.3, 0.7, 1.1, 1.6];
/// By how much places and angles may differ [m, rad].
const APART: f64 = 1e-6;

/// A part of a scene: its tables, its initial values, and what is compared.
#[derive(Clone, Default)]
struct Part {
    points: String,
    tables: String,
    initial: String,
    names: Vec<String>,
}

/// A scene of several of them.
fn scene(parts: &[Part]) -> String {
    let all = |of: fn(&Part) -> &String| parts.iter().map(|part| of(part).as_str()).collect::<String>();
    let names: Vec<String> = parts.iter().flat_map(|part| &part.names).map(|name| format!("\"{name}\"")).collect();
    format!(
        "name = \"parts\"\ngravity = [0, -{GRAVITY:?}]\n[ground.points]\n{}{}[initial]\n{}[outputs]\nvariables = [{}]\n",
        all(|part| &part.points),
        all(|part| &part.tables),
        all(|part| &part.initial),
        names.join(", ")
    )
}

/// A pendulum whose pin rubs by the force that it carries.
fn pendulum(place: usize) -> Part {
    let angle = -0.2 - (0.13 * place as f64) % 1.2;
    Part {
        points: format!("pin{place} = [{place}, 5]\n"),
        tables: format!(
            "[bodies.bar{place}]\nmass = 1\ninertia = 0.02\npoints = {{ top = [-0.25, 0] }}\n[joints.pin{place}]\ntype = \"revolute\"\nbetween = [\"ground.pin{place}\", \"bar{place}.top\"]\nfriction = {{ mu = 0.3, radius = 0.06 }}\n"
        ),
        initial: format!("\"bar{place}.angle\" = {angle:?}\n"),
        names: vec![format!("bar{place}.angle")],
    }
}

/// A disc that falls onto the ground, where it bounces, slides and rolls; all of them land at one instant.
fn disc(place: usize) -> Part {
    let speed = 0.4 + 0.15 * place as f64;
    Part {
        points: String::new(),
        tables: format!(
            "[bodies.disc{place}]\nmass = {:?}\ninertia = 0.004\n[joints.land{place}]\ntype = \"contact\"\nbetween = [\"ground\", \"disc{place}\"]\naxis = [1, 0]\nradius = 0.1\nrestitution = 0.3\nfriction = {{ mu = 0.25 }}\n",
            1.0 + 0.1 * place as f64
        ),
        initial: format!("\"disc{place}.x\" = 0\n\"disc{place}.y\" = 0.4\n\"disc{place}.vx\" = {speed:?}\n"),
        names: vec![format!("disc{place}.x"), format!("disc{place}.y"), format!("disc{place}.angle")],
    }
}

/// A box that drops onto two rough feet and slides.
fn drop(place: usize) -> Part {
    let speed = 0.3 + 0.2 * place as f64;
    let foot = |name: &str| {
        format!(
            "[joints.{name}{place}]\ntype = \"contact\"\nbetween = [\"ground\", \"box{place}.{name}\"]\naxis = [1, 0]\nfriction = {{ mu = 0.4 }}\n"
        )
    };
    Part {
        points: String::new(),
        tables: format!(
            "[bodies.box{place}]\nmass = 2\ninertia = 0.03\npoints = {{ left = [-0.2, -0.05], right = [0.2, -0.05] }}\n{}{}",
            foot("left"),
            foot("right")
        ),
        initial: format!(
            "\"box{place}.x\" = 0\n\"box{place}.y\" = 0.25\n\"box{place}.angle\" = 0\n\"box{place}.vx\" = {speed:?}\n"
        ),
        names: vec![format!("box{place}.x"), format!("box{place}.y"), format!("box{place}.angle")],
    }
}

/// Two geared wheels, both of whose bearings stick and slip: one island, although no acceleration reads where anything is.
fn wheels(place: usize) -> Part {
    let wheel = |name: &str, level: f64| {
        format!(
            "[bodies.{name}{place}]\nmass = 1\ninertia = 0.02\n[joints.of_{name}{place}]\ntype = \"revolute\"\nbetween = [\"ground.{name}{place}\", \"{name}{place}\"]\nfriction = {{ coulomb = {level:?}, static = 1.3 }}\n"
        )
    };
    Part {
        points: format!("first{place} = [{place}, -5]\nsecond{place} = [{place}, -6]\n"),
        tables: format!(
            "{}{}[joints.mesh{place}]\ntype = \"gear\"\nbetween = [\"first{place}\", \"second{place}\"]\nratio = -0.6\n[loads.motor{place}]\ntype = \"torque\"\non = \"first{place}\"\nvalue = \"{:?}*sin(4*t)\"\n",
            wheel("first", 0.3),
            wheel("second", 0.4),
            1.5 + 0.2 * place as f64
        ),
        initial: String::new(),
        names: vec![format!("first{place}.angle")],
    }
}

/// Two carts that a belt ties, each before a stop of its own: what hits one moves the other, although their loop equation has constant factors.
fn carts(place: usize) -> Part {
    let cart = |name: &str, limit: f64| {
        format!(
            "[bodies.{name}{place}]\nmass = 1\n[joints.of_{name}{place}]\ntype = \"prismatic\"\nbetween = [\"ground\", \"{name}{place}\"]\naxis = [1, 0]\nlimits = {{ min = {:?}, max = {limit:?}, restitution = 0.7 }}\n",
            -limit
        )
    };
    Part {
        points: String::new(),
        tables: format!(
            "{}{}[bodies.roll{place}]\nmass = 1\ninertia = 0.01\n[joints.of_roll{place}]\ntype = \"revolute\"\nbetween = [\"ground\", \"roll{place}\"]\n[joints.near{place}]\ntype = \"rack\"\nbetween = [\"roll{place}\", \"one{place}\"]\naxis = [1, 0]\nradius = 0.1\n[joints.far{place}]\ntype = \"rack\"\nbetween = [\"roll{place}\", \"two{place}\"]\naxis = [1, 0]\nradius = 0.15\n",
            cart("one", 0.2),
            cart("two", 0.31)
        ),
        initial: format!("\"of_one{place}.v\" = {:?}\n", 0.9 + 0.1 * place as f64),
        names: vec![format!("one{place}.x"), format!("two{place}.x")],
    }
}

/// Compares parts that move together with each of them alone.
fn compare(parts: &[Part]) {
    let values = |parts: &[Part]| {
        let mut run = started(&model(&scene(parts)), None, 1.6, TOLERANCE);
        let names: Vec<&String> = parts.iter().flat_map(|part| &part.names).collect();
        let mut rows = Vec::new();
        for time in TIMES {
            run.step_to(time).unwrap_or_else(|error| panic!("{error}"));
            rows.push(names.iter().map(|name| value(&mut run, name)).collect::<Vec<f64>>());
        }
        rows
    };
    let together = values(parts);
    let mut first = 0;
    for part in parts {
        let alone = values(std::slice::from_ref(part));
        for ((time, together), alone) in TIMES.iter().zip(&together).zip(&alone) {
            for ((name, found), right) in part.names.iter().zip(&together[first..]).zip(alone) {
                assert!((found - right).abs() < APART, "{name} at {time} s: {found}, alone {right}");
            }
        }
        first += part.names.len();
    }
}

#[test]
fn many_rubbing_pendulums_move_as_one() {
    compare(&(0..12).map(pendulum).collect::<Vec<Part>>());
}

#[test]
fn many_discs_land_at_one_instant() {
    compare(&(0..18).map(disc).collect::<Vec<Part>>());
}

/// Without a bounce they slide to their stop: x = v t - mu g t^2 / 2 after the fall of 0.2 m.
#[test]
fn ten_boxes_drop_at_once() {
    let parts: Vec<Part> = (0..10).map(drop).collect();
    compare(&parts);
    let mut run = started(&model(&scene(&parts)), None, 1.6, TOLERANCE);
    run.step_to(1.6).unwrap_or_else(|error| panic!("{error}"));
    let fall = (2.0 * 0.2 / GRAVITY).sqrt();
    for place in 0..10 {
        let speed = 0.3 + 0.2 * place as f64;
        // The impact of both feet takes mu times what it takes of the fall.
        let slides = (speed - 0.4 * GRAVITY * fall).max(0.0);
        let right = speed * fall + slides * slides / (2.0 * 0.4 * GRAVITY);
        let found = value(&mut run, &format!("box{place}.x"));
        assert!((found - right).abs() < APART, "{place}: {found}, right is {right}");
    }
}

#[test]
fn what_belongs_together_is_decided_together() {
    compare(&(0..4).map(wheels).collect::<Vec<Part>>());
    compare(&(0..4).map(carts).collect::<Vec<Part>>());
}

#[test]
fn parts_of_all_kinds_move_as_each_alone() {
    let kinds = [pendulum, disc, drop, wheels, carts];
    compare(&(0..10).map(|place| kinds[place % kinds.len()](place)).collect::<Vec<Part>>());
}
