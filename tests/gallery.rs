//! The models of known linkages against closed forms: every output of each is computed here again, by intersecting circles, triangles and plain
//! formulas, and each has one number that books say of it. The other tests compare the FMUs with `expected.csv`.
//!
//! `COTREE_WRITE_EXPECTED=1 cargo test --test library gallery::` writes the files.

use crate::support::ROOT;
use crate::support::run;

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2, TAU};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use run::{sound, value};

type Place = [f64; 2];

fn at(from: Place, length: f64, angle: f64) -> Place {
    [from[0] + length * angle.cos(), from[1] + length * angle.sin()]
}

fn distance([ax, ay]: Place, [bx, by]: Place) -> f64 {
    (bx - ax).hypot(by - ay)
}

/// The direction from one place to another.
fn bearing([ax, ay]: Place, [bx, by]: Place) -> f64 {
    (by - ay).atan2(bx - ax)
}

/// Where two circles meet, on the left of the line from the first centre to the second or on its right.
fn meet(a: Place, first: f64, b: Place, second: f64, left: bool) -> Place {
    let d = distance(a, b);
    let along = (d * d + first * first - second * second) / (2.0 * d);
    let aside = (first * first - along * along).sqrt() * if left { 1.0 } else { -1.0 };
    let [x, y] = [(b[0] - a[0]) / d, (b[1] - a[1]) / d];
    [a[0] + along * x - aside * y, a[1] + along * y + aside * x]
}

/// A place in the frame of a bar from a to b.
fn beside(a: Place, b: Place, [x, y]: Place) -> Place {
    let (s, c) = bearing(a, b).sin_cos();
    [a[0] + c * x - s * y, a[1] + s * x + c * y]
}

fn folder(model: &str) -> PathBuf {
    Path::new(ROOT).join("models").join(model)
}

fn scene(model: &str) -> Scene {
    sound(Scene::read(folder(model).join("scene.toml")))
}

/// Runs a model over its experiment.
fn instance(model: &str, stop: f64) -> Instance {
    let program = sound(compile(&scene(model))).program;
    run::started(&Arc::new(Model::new(program).expect("sound")), None, stop, 1e-9)
}

/// Compares every output of a model with its closed form, and with `expected.csv`; angles up to whole turns, which add up.
fn check(model: &str, rows: usize, stop: f64, limit: f64, expected: impl Fn(f64) -> Vec<f64>) {
    let resolved = sound(scene(model).resolve());
    let names: Vec<String> = resolved.outputs.iter().map(|output| output.name.clone()).collect();
    let mut run = instance(model, stop);
    let mut table: Vec<Vec<f64>> = Vec::new();
    for row in 0..rows {
        let time = stop * row as f64 / (rows - 1) as f64;
        if row > 0 {
            run.step_to(time).expect("regular");
        }
        let mut values = expected(time);
        assert_eq!(values.len(), names.len(), "{model}: {names:?}");
        for (column, name) in names.iter().enumerate() {
            let near = table.last().map_or_else(|| value(&mut run, name), |before| before[1 + column]);
            if name.ends_with(".angle") {
                values[column] += TAU * ((near - values[column]) / TAU).round();
            }
        }
        table.push(std::iter::once(time).chain(values).collect());
        let scale = |column: usize| table.iter().fold(0.0_f64, |most, row| most.max(row[column].abs())).max(1e-3);
        for (column, name) in names.iter().enumerate() {
            let (found, expected) = (value(&mut run, name), table[row][1 + column]);
            let error = (found - expected).abs() / scale(1 + column);
            assert!(error <= limit, "{model}: {name} at {time} s is {found}, not {expected}");
        }
    }
    stored(model, &names, &table);
}

/// `expected.csv` holds the closed form.
fn stored(model: &str, names: &[String], table: &[Vec<f64>]) {
    let path = folder(model).join("expected.csv");
    if std::env::var_os("COTREE_WRITE_EXPECTED").is_some() {
        let mut text = format!("time,{}\n", names.join(","));
        for row in table {
            let digits = |value: &f64| format!("{value:.14e}").parse::<f64>().expect("a number").to_string();
            let _ = writeln!(text, "{}", row.iter().map(digits).collect::<Vec<_>>().join(","));
        }
        std::fs::write(&path, text).expect("written");
    }
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let lines: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!(lines.len(), table.len(), "{model}");
    for (line, row) in lines.iter().zip(table) {
        for (number, expected) in line.split(',').zip(row) {
            let number: f64 = number.parse().expect("a number");
            assert!((number - expected).abs() <= 1e-11 * expected.abs().max(1.0), "{model}: {number} {expected}");
        }
    }
}

const LIMIT: f64 = 1e-9;

/// The tip stays at x = (long^2 - side^2)/(2 crank).
#[test]
fn peaucellier_draws_a_straight_line() {
    let (crank, long, side) = (0.15_f64, 0.4_f64, 0.2_f64);
    check("peaucellier", 201, 1.0, LIMIT, |t| {
        let turn = (TAU * t).sin();
        let pin = at([crank, 0.0], crank, turn);
        let upper = meet([0.0, 0.0], long, pin, side, true);
        let lower = meet([0.0, 0.0], long, pin, side, false);
        let line = (long * long - side * side) / (2.0 * crank);
        vec![turn, line, line * (0.5 * turn).tan(), bearing([0.0, 0.0], upper), bearing([0.0, 0.0], lower)]
    });
    let mut run = instance("peaucellier", 1.0);
    for step in 1..=100 {
        run.step_to(f64::from(step) / 100.0).expect("regular");
        let x = value(&mut run, "upper_far.tip.x");
        assert!((x - 0.4).abs() < 1e-14, "{x} at step {step}");
    }
}

fn chebyshev(t: f64) -> (Place, Place, Place, Place) {
    let pin = at([0.0, 0.0], 0.1, TAU * t);
    let joint = meet(pin, 0.25, [0.2, 0.0], 0.25, true);
    (pin, joint, [2.0 * joint[0] - pin[0], 2.0 * joint[1] - pin[1]], [0.2, 0.0])
}

#[test]
fn chebyshev_goes_straight_for_half_a_turn() {
    check("chebyshev", 201, 1.0, LIMIT, |t| {
        let (pin, joint, tracer, pivot) = chebyshev(t);
        vec![TAU * t, tracer[0], tracer[1], bearing(pivot, joint), bearing(pin, joint)]
    });
    let half: Vec<Place> = (0..=1000).map(|k| chebyshev(0.25 + 0.5 * f64::from(k) / 1000.0).2).collect();
    let range = |axis: usize| {
        let values = half.iter().map(|place| place[axis]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    println!("chebyshev: {} along, {} across", range(0), range(1));
    assert!((chebyshev(0.5).2[1] - 0.4).abs() < 1e-15);
    assert!(range(1) < 0.01 * range(0), "{} {}", range(1), range(0));
}

/// Crank, knees, back, ankle and toe of Jansen's leg.
fn jansen(t: f64) -> [Place; 7] {
    let [a, b, c, d, e, f, g, h, i, j, k, l, m] =
        [38.0, 41.5, 39.3, 40.1, 55.8, 39.4, 36.7, 65.7, 49.0, 50.0, 61.9, 7.8, 15.0].map(|length| 1e-3 * length);
    let (pin, hip) = (at([0.0, 0.0], m, TAU * t), [-a, -l]);
    let upper = meet(pin, j, hip, b, false);
    let lower = meet(pin, k, hip, c, true);
    let back = meet(hip, d, upper, e, true);
    let ankle = meet(back, f, lower, g, false);
    let toe = meet(lower, i, ankle, h, true);
    [hip, pin, upper, lower, back, ankle, toe]
}

#[test]
fn jansens_leg_stays_closed_for_a_thousand_turns() {
    check("jansen", 201, 1.0, LIMIT, |t| {
        let [hip, _, upper, lower, back, ankle, toe] = jansen(t);
        vec![TAU * t, toe[0], toe[1], bearing(hip, upper), bearing(hip, lower), bearing(back, ankle)]
    });
    let mut run = instance("jansen", 1000.0);
    let [.., toe] = jansen(0.3);
    for turn in [1.0, 10.0, 100.0, 999.0] {
        run.step_to(turn + 0.3).expect("regular");
        let found = ["foot.toe.x", "foot.toe.y"].map(|name| value(&mut run, name));
        assert!(distance(found, toe) < 1e-9, "{found:?} {toe:?} in turn {turn}");
    }
}

/// The rocker of a cam with its first two derivatives by the cam's angle, and its roller's centre seen from the shaft.
fn rocker(theta: f64) -> ([f64; 3], Place) {
    let [swing, rise, back, way] = [20.0_f64, 100.0, 150.0, 130.0].map(f64::to_radians);
    let theta = theta.rem_euclid(TAU);
    let up = match theta / rise {
        x if x < 1.0 => {
            [x - (TAU * x).sin() / TAU, (1.0 - (TAU * x).cos()) / rise, TAU * (TAU * x).sin() / (rise * rise)]
        }
        _ => [1.0, 0.0, 0.0],
    };
    let x = ((theta - back) / way).clamp(0.0, 1.0);
    let down = [
        x.powi(4) * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x))),
        140.0 * (x * (1.0 - x)).powi(3) / way,
        420.0 * (x * (1.0 - x)).powi(2) * (1.0 - 2.0 * x) / (way * way),
    ];
    let law = [0, 1, 2].map(|order| swing * (up[order] - down[order]));
    // On the base circle shaft, pivot and roller are a triangle.
    let start = ((0.038_f64.powi(2) - 0.08 * 0.08 - 0.07 * 0.07) / (2.0 * 0.08 * 0.07)).acos();
    let psi = [start - law[0], -law[1], -law[2]];
    (psi, at([0.08, 0.0], 0.07, psi[0]))
}

#[test]
fn a_cam_turns_a_rocker_by_its_law() {
    let speed = 10.0;
    check("cam_oscillating", 201, 1.256_637_061_435_917_2, 1e-8, |t| {
        let theta = speed * t;
        let ([psi, slope, second], centre) = rocker(theta);
        // The pitch curve's tangent, seen in the carrier: the centre's motion less that of the cam below it.
        let arm = [centre[0] - 0.08, centre[1]];
        let tangent = [-slope * arm[1] + centre[1], slope * arm[0] - centre[0]];
        let long = tangent[0].hypot(tangent[1]);
        let out = [-tangent[1] / long, tangent[0] / long];
        // The rocker rises clockwise.
        let path = [arm[1] / 0.07, -arm[0] / 0.07];
        let [along, aside] = [path[0] * out[0] + path[1] * out[1], path[0] * out[1] - path[1] * out[0]];
        let alpha = second * speed * speed;
        let pressed = 5e-4 * alpha + 2.0 * (psi - 190_f64.to_radians());
        let force = -pressed / (0.07 * along);
        vec![theta, psi, slope * speed, alpha, aside.atan2(along), force, pressed * slope]
    });
    let fastest = (0..36_000).map(|step| (speed * rocker(TAU * f64::from(step) / 36_000.0).0[1]).abs());
    let fastest = fastest.fold(0.0, f64::max);
    assert!((fastest - 4.0).abs() < 1e-6, "2 h/beta x speed is {fastest}");
}

/// The foot of Klann's leg, and the angles of its arm, rockers and leg from where the patent draws them.
fn klann(turn: f64) -> (Place, [f64; 4]) {
    let [shaft, upper, lower] = [[1.599, 0.75], [1.366, 1.366], [1.009, 0.574]];
    let [drawn_pin, drawn_elbow, drawn_knee, drawn_hip] = [[1.331, 0.75], [0.741, 0.75], [0.232, 0.866], [0.866, 1.5]];
    let from = |[x, y]: Place, [u, v]: Place| [x - u, y - v];
    let pin = at(shaft, 0.268, PI + turn);
    let elbow = meet(pin, distance(drawn_pin, drawn_elbow), lower, distance(lower, drawn_elbow), false);
    // In the patent the line from pin to elbow points to the left.
    let [x, y] = from(drawn_knee, drawn_pin);
    let knee = beside(pin, elbow, [-x, -y]);
    let hip = meet(knee, distance(drawn_knee, drawn_hip), upper, distance(upper, drawn_hip), true);
    let leg = bearing(hip, knee) - bearing(drawn_hip, drawn_knee);
    let (sine, cosine) = leg.sin_cos();
    let [x, y] = from([0.0, 0.0], drawn_hip);
    let foot = [hip[0] + cosine * x - sine * y, hip[1] + sine * x + cosine * y];
    let turned = |a: Place, b: Place, c: Place, d: Place| bearing(a, b) - bearing(c, d);
    let arm = turned(pin, elbow, drawn_pin, drawn_elbow);
    (foot, [arm, turned(lower, elbow, lower, drawn_elbow), turned(upper, hip, upper, drawn_hip), leg])
}

#[test]
fn klanns_leg_makes_a_stride_in_half_a_turn() {
    check("klann", 201, 1.0, LIMIT, |t| {
        let (foot, angles) = klann(TAU * t);
        [TAU * t, foot[0], foot[1]].into_iter().chain(angles).collect()
    });
    let foot = |degrees: f64| klann(degrees.to_radians()).0;
    assert!(distance(foot(0.0), [0.0, 0.0]) < 1e-12, "in the patent's first figure the foot is at the origin");
    let path: Vec<Place> = (0..36_000).map(|step| foot(0.01 * f64::from(step))).collect();
    let range = |path: &[Place], axis: usize| {
        let values = path.iter().map(|place| place[axis]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    let stride = range(&path, 0);
    assert!((stride - 1.008_844_95).abs() < 1e-8, "{stride}");
    assert!(range(&path[17_800..35_800], 1) < 0.06 * stride && range(&path, 1) > 0.5 * stride);
    let mut run = instance("klann", 100.0);
    for turn in [1.0, 99.0] {
        run.step_to(turn + 0.3).expect("regular");
        let found = ["leg.foot.x", "leg.foot.y"].map(|name| value(&mut run, name));
        assert!(distance(found, foot(108.0)) < 1e-9, "{found:?} in turn {turn}");
    }
}

#[test]
fn whitworth_returns_quickly() {
    let (crank, offset, arm, rod) = (0.075_f64, 0.03, 0.06, 0.2_f64);
    let places = |t: f64| {
        let pin = at([0.0, -offset], crank, TAU * t);
        let end = at([0.0, 0.0], arm, bearing([0.0, 0.0], pin));
        (pin, end, end[0] + (rod * rod - end[1] * end[1]).sqrt())
    };
    check("whitworth", 201, 1.0, LIMIT, |t| {
        let (pin, end, ram) = places(t);
        vec![TAU * t, bearing([0.0, 0.0], pin), distance([0.0, 0.0], pin), ram, bearing(end, [ram, 0.0])]
    });
    // The crank's angles at both ends of the stroke; between them it turns by 180 degrees and twice asin(offset/crank) more or less.
    let limit = (offset / crank).asin();
    let (out, back) = (places(limit / TAU).2, places((PI - limit) / TAU).2);
    assert!((out - back - 2.0 * arm).abs() < 1e-12, "{out} {back}");
    let ratio = (PI + 2.0 * limit) / (PI - 2.0 * limit);
    assert!((ratio - 1.709_952_782).abs() < 1e-9, "{ratio}");
}

#[test]
fn a_pin_turns_a_geneva_wheel_by_a_quarter() {
    let crank = 0.1;
    let base = crank * SQRT_2;
    check("geneva_slot", 201, 1.0, LIMIT, |t| {
        let turn = -0.25 * PI + FRAC_PI_2 * t;
        let pin = at([0.0, 0.0], crank, turn);
        let length = distance(pin, [base, 0.0]);
        // d/dt of the bearing: the pin's velocity across the slot over its distance.
        let velocity = [-crank * FRAC_PI_2 * turn.sin(), crank * FRAC_PI_2 * turn.cos()];
        let along = [(base - pin[0]) / length, -pin[1] / length];
        let omega = -(along[0] * velocity[1] - along[1] * velocity[0]) / length;
        vec![turn, bearing(pin, [base, 0.0]), omega, length]
    });
    let mut run = instance("geneva_slot", 1.0);
    run.step_to(0.5).expect("regular");
    let ratio = value(&mut run, "wheel.omega") / FRAC_PI_2;
    assert!((ratio + 1.0 / (SQRT_2 - 1.0)).abs() < 1e-12, "{ratio}");
}

#[test]
fn a_toggle_press_stands_still_where_its_knee_is_straight() {
    let ram = |turn: f64| {
        let pin = at([-0.17, -0.2], 0.03, turn);
        let knee = meet(pin, 0.15, [0.0, 0.0], 0.2, false);
        (pin, knee, knee[1] - (0.25_f64.powi(2) - knee[0] * knee[0]).sqrt())
    };
    check("toggle_press", 201, 1.0, LIMIT, |t| {
        let turn = 100_f64.to_radians() + TAU * t;
        let (pin, knee, y) = ram(turn);
        vec![turn, y, bearing(pin, knee), bearing([0.0, 0.0], knee), bearing(knee, [0.0, y])]
    });
    let straight = ((0.03_f64.powi(2) + 0.17_f64.powi(2) - 0.15_f64.powi(2)) / (2.0 * 0.03 * 0.17)).acos();
    assert!((straight.to_degrees() - 44.300_529_89).abs() < 1e-8);
    assert!((ram(straight).2 + 0.45).abs() < 1e-9 && (ram(-straight).2 + 0.45).abs() < 1e-9);
}

fn swing(angle: impl Fn(f64) -> f64) -> f64 {
    let values: Vec<f64> = (0..7200).map(|k| angle(TAU * f64::from(k) / 7200.0)).collect();
    let most = values.iter().copied().fold(f64::MIN, f64::max) - values.iter().copied().fold(f64::MAX, f64::min);
    most.to_degrees()
}

/// The angle at a corner of a triangle with these sides at it and that one opposite.
fn corner(a: f64, b: f64, opposite: f64) -> f64 {
    ((a * a + b * b - opposite * opposite) / (2.0 * a * b)).acos()
}

#[test]
fn watts_six_bar() {
    let places = |turn: f64| {
        let pin = at([0.0, 0.0], 0.1, turn);
        let joint = meet(pin, 0.3, [0.3, 0.0], 0.2, true);
        let plate = beside([0.3, 0.0], joint, [0.2, -0.1]);
        (pin, joint, plate, meet(plate, 0.35, [0.7, 0.0], 0.25, true))
    };
    check("watt_six_bar", 201, 1.0, LIMIT, |t| {
        let (pin, joint, plate, end) = places(TAU * t);
        let pivots = [bearing([0.3, 0.0], joint), bearing(plate, end), bearing([0.7, 0.0], end)];
        [vec![TAU * t, bearing(pin, joint)], pivots.to_vec()].concat()
    });
    // The rocker's limits: crank and coupler in one line, stretched or folded.
    let exact = (corner(0.2, 0.3, 0.4) - corner(0.2, 0.3, 0.2)).to_degrees();
    let rocker = swing(|turn| bearing([0.3, 0.0], places(turn).1));
    assert!((rocker - exact).abs() < 1e-4 && (exact - 63.07).abs() < 0.005, "{rocker} {exact}");
    let output = swing(|turn| bearing([0.7, 0.0], places(turn).3));
    assert!((output - 53.69).abs() < 0.005, "{output}");
}

#[test]
fn stephensons_six_bar() {
    let places = |turn: f64| {
        let pin = at([0.0, 0.0], 0.1, turn);
        let joint = meet(pin, 0.3, [0.3, 0.0], 0.2, true);
        let plate = beside(pin, joint, [0.2, 0.15]);
        (joint, plate, meet(plate, 0.4, [0.55, 0.45], 0.25, false))
    };
    check("stephenson_six_bar", 201, 1.0, LIMIT, |t| {
        let (joint, plate, end) = places(TAU * t);
        let angles = [bearing([0.3, 0.0], joint), bearing(plate, end), bearing([0.55, 0.45], end)];
        [vec![TAU * t, plate[0], plate[1]], angles.to_vec()].concat()
    });
    let output = swing(|turn| bearing([0.55, 0.45], places(turn).2).rem_euclid(TAU));
    assert!((output - 61.61).abs() < 0.005, "{output}");
}

#[test]
fn a_wiper_sweeps_what_the_law_of_cosines_says() {
    let places = |turn: f64| {
        let pin = at([0.0, 0.0], 0.04, turn);
        let arm = meet(pin, 0.3, [0.3, 0.02], 0.07, true);
        let other = beside([0.3, 0.02], arm, [-0.06, 0.0]);
        (arm, meet(other, 0.45, [0.75, 0.02], 0.06, false))
    };
    check("wiper", 201, 1.0, LIMIT, |t| {
        let (arm, right) = places(TAU * t);
        let tip = beside([0.3, 0.02], arm, [0.5, 0.0]);
        vec![TAU * t, bearing([0.3, 0.02], arm), bearing([0.75, 0.02], right), tip[0], tip[1]]
    });
    let base = 0.3_f64.hypot(0.02);
    let exact = (corner(0.07, base, 0.34) - corner(0.07, base, 0.26)).to_degrees();
    let sweep = swing(|turn| bearing([0.3, 0.02], places(turn).0));
    assert!((sweep - exact).abs() < 1e-4 && (exact - 69.99).abs() < 0.005, "{sweep} {exact}");
}

#[test]
fn a_robot_with_five_bars() {
    check("five_bar_robot", 201, 1.0, LIMIT, |t| {
        let turns = [TAU / 3.0 + 0.3 * (TAU * t).sin(), PI / 3.0 + 0.3 * (TAU * t).cos()];
        let (left, right) = (at([-0.1, 0.0], 0.2, turns[0]), at([0.1, 0.0], 0.2, turns[1]));
        let tool = meet(left, 0.3, right, 0.3, true);
        vec![turns[0], turns[1], tool[0], tool[1], bearing(left, tool), bearing(right, tool)]
    });
}

#[test]
fn landing_gear_folds_its_brace() {
    let brace = [0.55, 0.05];
    check("landing_gear", 201, 1.0, LIMIT, |t| {
        let share = t * t * t * (10.0 - t * (15.0 - 6.0 * t));
        let turn = -FRAC_PI_2 + 1.4 * share;
        let (pin, axle) = (at([0.0, 0.0], 0.7, turn), at([0.0, 0.0], 1.2, turn));
        let knee = meet(brace, 0.5, pin, 0.46, false);
        vec![turn, bearing(brace, knee), bearing(knee, pin), axle[0], axle[1]]
    });
    let mut run = instance("landing_gear", 1.0);
    let knee = PI - (value(&mut run, "lower_brace.angle") - value(&mut run, "upper_brace.angle")).abs();
    let exact = corner(0.5, 0.46, 0.55_f64.hypot(0.75));
    assert!((knee - exact).abs() < 1e-12, "{} {}", knee.to_degrees(), exact.to_degrees());
    println!("landing gear: {} degrees", exact.to_degrees());
}

#[test]
fn an_excavator_follows_its_cylinders() {
    check("excavator", 201, 5.0, LIMIT, |t| {
        let oil = [1.55 + 0.25 * (0.4 * PI * t).sin(), 1.55 + 0.2 * (0.4 * PI * t + 1.0).sin()];
        let (foot, eye): (Place, Place) = ([0.4, -0.3], [1.4, 0.3]);
        let opening = corner(foot[0].hypot(foot[1]), eye[0].hypot(eye[1]), oil[0]);
        let boom = foot[1].atan2(foot[0]) + opening - eye[1].atan2(eye[0]);
        let end = at([0.0, 0.0], 3.0, boom);
        let second = beside([0.0, 0.0], end, [1.5, 0.5]);
        let back = bearing(end, second) - corner(distance(end, second), 0.4, oil[1]);
        let tip = at(end, 1.6, back + PI);
        vec![oil[0], oil[1], boom, back + PI, tip[0], tip[1]]
    });
}

#[test]
fn inertias_behind_gears_count_by_the_square_of_the_ratio() {
    let torque: f64 = (0.001 + 0.01 / 9.0 + 0.05 / 81.0) * 30.0;
    assert!((torque - 0.081_851_851_851).abs() < 1e-11);
    check("gear_train", 201, 1.0, LIMIT, |t| {
        let turn = 15.0 * t * t;
        vec![turn, -turn / 3.0, turn / 9.0, 30.0 * t / 9.0, torque, 0.05 * 30.0 / 9.0]
    });
}

#[test]
fn an_isolator_passes_what_its_transmissibility_says() {
    let (m, k, c, force, w): (f64, f64, f64, f64, f64) = (20.0, 8000.0, 80.0, 50.0, 60.0);
    let (natural, damping) = ((k / m).sqrt(), c / (2.0 * (k * m).sqrt()));
    let damped = natural * (1.0 - damping * damping).sqrt();
    let (real, imaginary) = (k - m * w * w, c * w);
    let size = real * real + imaginary * imaginary;
    let (a, b) = (force * real / size, -force * imaginary / size);
    // x = a sin wt + b cos wt + exp(-d t)(p cos + q sin), at rest at first.
    let decay = damping * natural;
    let (p, q) = (-b, -(a * w + decay * b) / damped);
    let motion = move |t: f64| {
        let (s, co) = (damped * t).sin_cos();
        let fade = (-decay * t).exp();
        let x = a * (w * t).sin() + b * (w * t).cos() + fade * (p * co + q * s);
        let slow = fade * (-decay * (p * co + q * s) + damped * (q * co - p * s));
        [x, w * (a * (w * t).cos() - b * (w * t).sin()) + slow]
    };
    check("vibration_isolator", 401, 4.0, 1e-7, |t| {
        let [x, v] = motion(t);
        vec![x, v, k * x + c * v]
    });
    let r = w / natural;
    let transmissibility =
        ((1.0 + (2.0 * damping * r).powi(2)) / ((1.0 - r * r).powi(2) + (2.0 * damping * r).powi(2))).sqrt();
    assert!((transmissibility - 0.145_366).abs() < 1e-6, "{transmissibility}");
    let late = (0..1000).map(|step| {
        let [x, v] = motion(20.0 + f64::from(step) * TAU / w / 1000.0);
        (k * x + c * v).abs()
    });
    let largest = late.fold(0.0, f64::max);
    assert!((largest / force - transmissibility).abs() < 1e-5, "{largest}");
}

#[test]
fn the_torque_of_an_engine_is_that_of_virtual_work() {
    let (crank, rod, speed): (f64, f64, f64) = (0.04, 0.14, 200.0);
    check("engine", 201, 0.06283, 1e-8, |t| {
        let turn = speed * t;
        let (s, c) = turn.sin_cos();
        // The rod's root and its derivatives by the angle.
        let root = (rod * rod - crank * crank * s * s).sqrt();
        let slope = -crank * crank * s * c / root;
        let bend = (-crank * crank * (c * c - s * s) - slope * slope) / root;
        let (x, rate, curve) = (crank * c + root, -crank * s + slope, -crank * c + bend);
        let gas = -600.0 * ((0.012 + 2.0 * crank) / (0.012 + crank + rod - x)).powf(1.3);
        let torque = (0.5 * speed * speed * curve - gas) * rate;
        vec![turn, x, speed * rate, -(crank * s / rod).asin(), torque]
    });
}

/// A cycloidal rise of 20 mm in 90 degrees, rest, return in 120 degrees, rest.
fn cycloidal_lift(turn: f64) -> [f64; 2] {
    let rise =
        |beta: f64, share: f64| [0.02 * (share - (TAU * share).sin() / TAU), 0.02 / beta * (1.0 - (TAU * share).cos())];
    let turn = turn.rem_euclid(TAU);
    let [up, rest, down] = [90.0, 150.0, 270.0].map(f64::to_radians);
    match turn {
        turn if turn < up => rise(up, turn / up),
        turn if turn < rest => [0.02, 0.0],
        turn if turn < down => {
            let [lift, slope] = rise(down - rest, (turn - rest) / (down - rest));
            [0.02 - lift, -slope]
        }
        _ => [0.0, 0.0],
    }
}

/// The second derivatives of a periodic spline with equal steps, by Gauss and Seidel: m[k-1] + 4 m[k] + m[k+1] = 6 (y[k+1] - 2 y[k] + y[k-1])/h^2.
fn second_derivatives(y: &[f64], h: f64) -> Vec<f64> {
    let n = y.len();
    let mut second = vec![0.0; n];
    for _ in 0..200 {
        for k in 0..n {
            let (before, after) = ((k + n - 1) % n, (k + 1) % n);
            let bend = 6.0 * (y[after] - 2.0 * y[k] + y[before]) / (h * h);
            second[k] = (bend - second[before] - second[after]) / 4.0;
        }
    }
    second
}

#[test]
fn a_cam_lifts_its_follower_by_a_spline_of_measured_places() {
    let text = std::fs::read_to_string(folder("cam_follower").join("lift.csv")).expect("a table");
    let rows = text.lines().skip(2).filter_map(|line| line.split_once(','));
    let mut y: Vec<f64> = rows.map(|(_, lift)| 1e-3 * lift.trim().parse::<f64>().expect("a number")).collect();
    assert_eq!((y.len(), y.pop()), (37, Some(0.0)));
    let h = TAU / 36.0;
    let second = second_derivatives(&y, h);
    let spline = |turn: f64| {
        let turn = turn.rem_euclid(TAU);
        let k = ((turn / h) as usize).min(35);
        let (next, d) = ((k + 1) % 36, turn - k as f64 * h);
        let slope = (y[next] - y[k]) / h - h * (2.0 * second[k] + second[next]) / 6.0;
        let cubic = (second[next] - second[k]) / (6.0 * h);
        let value = y[k] + d * (slope + d * (0.5 * second[k] + d * cubic));
        [value, slope + d * (second[k] + 3.0 * d * cubic), second[k] + 6.0 * d * cubic]
    };
    let stop = 0.4 * PI;
    check("cam_follower", 201, stop, 1e-8, |t| {
        let [lift, slope, bend] = spline(10.0 * t);
        // The mass, the weight and the spring, which is 90 mm - 70 mm - lift shorter than free.
        let length = 0.12 - (0.03 + lift + 0.04);
        let force = 0.3 * (100.0 * bend + 9.81) + 2000.0 * (0.06 - length);
        vec![10.0 * t, lift, 10.0 * slope, 100.0 * bend, force]
    });
    let (mut apart, mut fastest) = (0.0_f64, 0.0_f64);
    for step in 0..3600 {
        let turn = TAU * f64::from(step) / 3600.0;
        apart = apart.max((spline(turn)[0] - cycloidal_lift(turn)[0]).abs());
        fastest = fastest.max(spline(turn)[1]);
    }
    println!("cam: {apart} m from the cycloid, {} of its peak", fastest / (0.04 / FRAC_PI_2));
    assert!(apart < 4e-5 && (fastest / (0.04 / FRAC_PI_2) - 1.0).abs() < 0.01, "{apart} {fastest}");
}

/// The sheave turns alone until the chain is taut, loses as much of its speed as the load then has, and lifts it with a constant acceleration.
#[test]
fn the_differential_hoist_lifts_by_the_difference_of_its_drums() {
    let (torque, inertia, mass, gravity) = (-31.0, 0.15, 200.0, 9.81);
    let by_radian = (0.150 - 0.120) / 2.0;
    let together = inertia + mass * by_radian * by_radian;
    // 30 mm of slack are one radian.
    let taut = f64::sqrt(2.0 * inertia / -torque);
    let begin = torque / inertia * taut * inertia / together;
    let acceleration = (torque + mass * gravity * by_radian) / together;
    check("chain_hoist", 201, 2.0, LIMIT, |t| {
        if t < taut {
            return vec![torque / inertia * t, -1.2, 0.0, 0.0];
        }
        let omega = begin + acceleration * (t - taut);
        let turned = (begin + 0.5 * acceleration * (t - taut)) * (t - taut);
        let tension = 0.5 * mass * (gravity - by_radian * acceleration);
        vec![omega, -1.2 - by_radian * turned, -by_radian * omega, -tension]
    });
}

/// Both keep their angular momentum about the pin where the gripper closes, and move as one body until it opens.
#[test]
fn the_gripper_takes_a_part_and_throws_it() {
    let hand = |t: f64| at([0.0, 0.0], 0.7, PI - 2.0 * t);
    let part = |t: f64| [-1.0 + 1.25 * t, 0.62];
    let (mut far, mut near) = (0.4, 0.54);
    for _ in 0..60 {
        let middle = 0.5 * (far + near);
        *if distance(hand(middle), part(middle)) < 0.015 { &mut near } else { &mut far } = middle;
    }
    let (close, [x, y]) = (near, part(near));
    let (arm, mass, inertia) = (0.5 + 6.0 * 0.35 * 0.35, 1.5, 0.004);
    let omega = (-2.0 * arm - mass * y * 1.25) / (arm + mass * (x * x + y * y) + inertia);
    let open = close + 0.8;
    check("gripper", 201, 2.0, LIMIT, |t| {
        if t < close {
            let [x, y] = part(t);
            return vec![PI - 2.0 * t, -2.0, x, y, 0.0, 0.0];
        }
        let turned = omega * (t - close);
        let from = bearing([0.0, 0.0], [x, y]) + omega * (t.min(open) - close);
        let held = at([0.0, 0.0], x.hypot(y), from);
        let flown = omega * (t - open).max(0.0);
        let [x, y] = [held[0] - flown * held[1], held[1] + flown * held[0]];
        vec![PI - 2.0 * close + turned, omega, x, y, turned, f64::from(t < open)]
    });
}
