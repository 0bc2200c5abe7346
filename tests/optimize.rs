//! `cotree optimize`: optima that are known from other methods, limits with what they cost, and what is said where there is no optimum.

use crate::outside::command;

use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};

use command::{code, cotree, stderr, stdout};
use cotree::Scene;
use cotree::report::csv::CsvTable;
use cotree::scene::Requested;
use cotree_study::analysis::Study;
use cotree_study::fit::Vary;
use cotree_study::optimize::{Aim, Best, Ended, OptimizeError, OptimizeRequest, SearchProgress, optimize};

/// A mass on a bar that turns slowly from 10 to 110 degrees off the vertical, and a spring with a free length that balances it.
const BALANCE: &str = r#"
format = 1
name = "balance"
gravity = [0, -9.81]

[parameters]
stiffness = { value = "800 N/m", min = 0 }
post = "250 mm"
arm  = "150 mm"

[ground.points]
pivot = [0, 0]
hook  = [0, "post"]

[bodies.bar]
mass = 5
com = [0, 0.4]
inertia = 0.1
points = { pivot = [0, 0], eye = [0, "arm"] }

[joints.hinge]
type = "revolute"
between = ["ground.pivot", "bar.pivot"]

[drivers.motor]
joint = "hinge"
angle = "-(10[deg] + 100[deg/s]*t)"

[loads.spring]
type = "spring"
between = ["ground.hook", "bar.eye"]
stiffness = "stiffness"
length = "150 mm"

[experiment]
stop = 1.0
step = 0.0025
"#;
const BALANCED: f64 = 0.673_032_019;

/// A four-bar whose crank turns by a radian each second, from the line of its frame.
fn four_bar(names: &[(&str, f64, f64, f64)], experiment: &str, guesses: [f64; 2]) -> String {
    let of = |name: &str| names.iter().any(|own| own.0 == name);
    let parameters = names
        .iter()
        .map(|(name, value, low, high)| format!("{name} = {{ value = {value:?}, min = {low:?}, max = {high:?} }}\n"));
    let or = |name: &'static str| if of(name) { name } else { "0" };
    let [x, y, turn, ahead] = ["x", "y", "turn", "ahead"].map(or);
    format!(
        r#"
format = 1
name = "curve"
[parameters]
{parameters}
[ground.points]
a = ["{x}", "{y}"]
b = ["{x} + frame*cos({turn})", "{y} + frame*sin({turn})"]
[bodies]
crank   = {{ mass = 1, inertia = 1, points = {{ a = [0, 0], b = ["crank_length", 0] }} }}
coupler = {{ mass = 1, inertia = 1, points = {{ b = [0, 0], c = ["rod", 0], pen = ["along", "across"] }} }}
rocker  = {{ mass = 1, inertia = 1, points = {{ d = [0, 0], c = ["swing", 0] }} }}
[joints]
A = {{ type = "revolute", between = ["ground.a", "crank.a"] }}
B = {{ type = "revolute", between = ["crank.b", "coupler.b"] }}
C = {{ type = "revolute", between = ["coupler.c", "rocker.c"] }}
D = {{ type = "revolute", between = ["ground.b", "rocker.d"] }}
[drivers.motor]
joint = "A"
angle = "{turn} + {ahead} + t"
[initial]
"coupler.angle" = {{ guess = {:?} }}
"rocker.angle" = {{ guess = {:?} }}
[experiment]
{experiment}
"#,
        guesses[0],
        guesses[1],
        parameters = parameters.collect::<String>(),
    )
}

fn path(times: &[f64], points: &[[f64; 2]]) -> CsvTable {
    let column = |place: usize| points.iter().map(|point| point[place]).collect();
    CsvTable::new(
        vec!["coupler.pen.x".to_owned(), "coupler.pen.y".to_owned()],
        times.to_vec(),
        vec![column(0), column(1)],
    )
    .unwrap()
}

fn request(vary: &[&str], aim: Aim, limits: &[&str]) -> OptimizeRequest {
    OptimizeRequest {
        vary: vary.iter().map(|text| Vary::read(text).unwrap()).collect(),
        aim,
        limits: limits.iter().map(|text| text.parse().unwrap()).collect(),
        turn: None,
        starts: 64,
        seed: 0,
        threads: 0,
    }
}

fn least(goal: &str) -> Aim {
    Aim::Least(goal.parse().unwrap())
}

fn watched(
    scene: &str,
    request: &OptimizeRequest,
    watch: &(dyn Fn(SearchProgress) -> bool + Sync),
) -> Result<Best, OptimizeError> {
    let scene = Scene::from_toml(scene).unwrap();
    let mut study = Study::asking(&scene, &Requested::these(request.variables())).unwrap();
    optimize(&scene, &mut study, request, watch)
}

fn best(scene: &str, request: &OptimizeRequest) -> Best {
    watched(scene, request, &|_| true).unwrap_or_else(|error| panic!("{error}"))
}

/// A linear program with a simplex, and another method, agree in nine digits; where the largest torques are equally large their curve has corners.
#[test]
fn a_bar_is_balanced_with_every_seed() {
    for seed in 0..50 {
        let vary = ["stiffness=0..20000", "post=100..400 mm", "arm=50..300 mm"];
        let found =
            best(BALANCE, &OptimizeRequest { seed, starts: 8, ..request(&vary, least("peak(motor.torque)"), &[]) });
        let value = found.values[1].unwrap();
        assert!(
            (value - BALANCED).abs() < 1e-6 && found.ended == Ended::Settled,
            "seed {seed}: {value} {:?}",
            found.searches
        );
        let values: Vec<f64> = found.quantities.iter().map(|own| own.value).collect();
        assert!(
            (values[0] - 1_582.253_094).abs() < 1e-3
                && (values[1] - 0.4).abs() < 1e-9
                && (values[2] - 0.05).abs() < 1e-9,
            "{values:?}"
        );
        assert!(found.quantities[1].is_at_bound && !found.quantities[0].is_at_bound);
    }
}

/// Eighteen points of a curve, each with its crank angle: the optimum of thousands of least squares, which is half of what was published.
#[test]
fn eighteen_timed_points_are_met_as_well_as_they_can_be() {
    let points = [
        [0.5, 1.1],
        [0.4, 1.1],
        [0.3, 1.1],
        [0.2, 1.0],
        [0.1, 0.9],
        [0.05, 0.75],
        [0.02, 0.6],
        [0.0, 0.5],
        [0.0, 0.4],
        [0.03, 0.3],
        [0.1, 0.25],
        [0.15, 0.2],
        [0.2, 0.3],
        [0.3, 0.4],
        [0.4, 0.5],
        [0.5, 0.7],
        [0.6, 0.9],
        [0.6, 1.0],
    ];
    let times: Vec<f64> = (0..18).map(|index| std::f64::consts::TAU * f64::from(index) / 18.0).collect();
    let names = [
        ("frame", 2.0, 0.01, 50.0),
        ("crank_length", 0.4, 0.01, 50.0),
        ("rod", 2.0, 0.01, 50.0),
        ("swing", 1.5, 0.01, 50.0),
        ("along", 1.0, -50.0, 50.0),
        ("across", 0.5, -50.0, 50.0),
        ("x", 0.0, -50.0, 50.0),
        ("y", 0.0, -50.0, 50.0),
        ("turn", 0.3, -7.0, 7.0),
        ("ahead", 0.5, -7.0, 7.0),
    ];
    let vary = names.map(|own| own.0);
    let scene = four_bar(&names, "stop = 6.3\ntolerance = 1e-9", [1.0, 1.9]);
    let found = best(&scene, &request(&vary, Aim::Match(path(&times, &points)), &[]));
    let value = found.values[1].unwrap();
    assert!(
        (value / 0.009_028_884_63 - 1.0).abs() < 1e-6,
        "{value} {:#?}",
        found.optima.iter().take(4).collect::<Vec<_>>()
    );
}

/// Six points of a half circle within two boxes: the value of the first was published, and the second is better than what was.
#[test]
fn six_points_of_a_half_circle_are_met_within_their_boxes() {
    let points = [[0.0, 0.0], [1.9098, 5.8779], [6.9098, 9.5106], [13.09, 9.5106], [18.09, 5.8779], [20.0, 0.0]];
    let times: Vec<f64> = (1..=6).map(|index| std::f64::consts::PI * f64::from(index) / 6.0).collect();
    for (box_, optimum) in [(50.0, 2.580_355_625_5), (60.0, 2.231_030_081_3)] {
        let names = [
            ("frame", 40.0, 5.0, box_),
            ("crank_length", 8.0, 5.0, box_),
            ("rod", 20.0, 5.0, box_),
            ("swing", 40.0, 5.0, box_),
            ("along", 10.0, -box_, box_),
            ("across", 10.0, -box_, box_),
            ("x", 10.0, -box_, box_),
            ("y", -10.0, -box_, box_),
            ("turn", 0.1, -7.0, 7.0),
        ];
        let vary = names.map(|own| own.0);
        let scene = four_bar(&names, "start = 0.5\nstop = 3.15\ntolerance = 1e-9", [1.0, 1.8]);
        let found = best(&scene, &request(&vary, Aim::Match(path(&times, &points)), &[]));
        let value = found.values[1].unwrap();
        assert!(
            (value / optimum - 1.0).abs() < 1e-6,
            "{box_}: {value} {:#?}",
            found.optima.iter().take(4).collect::<Vec<_>>()
        );
    }
}

/// Five points: the best published design has 1.284e-6.
#[test]
fn five_timed_points_are_met_as_well_as_they_can_be() {
    let points = [[3.0, 3.0], [2.759, 3.363], [2.372, 3.663], [1.89, 3.862], [1.355, 3.943]];
    let times: Vec<f64> = (2..=6).map(|index| std::f64::consts::PI * f64::from(index) / 12.0).collect();
    let names = [
        ("frame", 4.0, 0.01, 50.0),
        ("crank_length", 1.5, 0.01, 50.0),
        ("rod", 4.5, 0.01, 50.0),
        ("swing", 3.0, 0.01, 50.0),
        ("along", 1.0, -50.0, 50.0),
        ("across", 1.0, -50.0, 50.0),
    ];
    let vary = names.map(|own| own.0);
    let scene = four_bar(&names, "start = 0.5\nstop = 1.6\ntolerance = 1e-10", [0.6, 1.5]);
    let found = best(&scene, &request(&vary, Aim::Match(path(&times, &points)), &[]));
    let value = found.values[1].unwrap();
    assert!(
        (value / 7.415_751_306_8e-7 - 1.0).abs() < 1e-6,
        "{value:e} {:#?}",
        found.optima.iter().take(6).collect::<Vec<_>>()
    );
}

/// A crank and a rod that push a carriage against a spring, with little that can be calculated wrongly by hand.
const CARRIAGE: &str = r#"
format = 1
name = "carriage"
[parameters]
crank = { value = "60 mm", min = "20 mm", max = "90 mm" }
rod   = { value = "300 mm", min = "150 mm", max = "600 mm" }
[bodies]
wheel    = { mass = 2, inertia = 0.01, points = { hub = [0, 0], pin = ["crank", 0] } }
link     = { mass = 1, inertia = 0.01, points = { pin = [0, 0], wrist = ["rod", 0] } }
carriage = { mass = 3 }
[joints]
shaft = { type = "revolute", between = ["ground", "wheel.hub"] }
pin   = { type = "revolute", between = ["wheel.pin", "link.pin"] }
wrist = { type = "revolute", between = ["link.wrist", "carriage"] }
slide = { type = "prismatic", between = ["ground", "carriage"], axis = [1, 0] }
[drivers.motor]
joint = "shaft"
angle = "5[rad/s]*t"
[initial]
"link.angle" = { guess = 0 }
[outputs]
variables = ["slide.s"]
way = "slide.s - 0.2"
[experiment]
stop = 1.26
step = 0.01
"#;

/// Of a rod in line with its crank the stroke is twice the crank and the farthest place crank and rod together: the least angle of the rod is had by the longest rod and the shortest crank.
#[test]
fn limits_are_met_and_cost_what_they_cost() {
    let vary = ["crank", "rod"];
    let requested = |stroke: &str| {
        let limits = [&*format!("range(slide.s) >= {stroke}"), "max(slide.s) <= 400 mm"];
        best(CARRIAGE, &OptimizeRequest { starts: 6, ..request(&vary, least("max(link.angle)"), &limits) })
    };
    let found = requested("100 mm");
    assert_eq!(found.ended, Ended::Settled);
    let [crank, rod] = [0, 1].map(|place: usize| found.quantities[place].value);
    assert!((crank - 0.05).abs() < 1e-4 && (rod - 0.35).abs() < 1e-4, "{crank} {rod}");
    let goal = |found: &Best| found.values[1].unwrap();
    assert!((goal(&found) - (0.05_f64 / 0.35).asin()).abs() < 1e-4);
    // What a limit costs is what it costs when it is changed.
    let step = 1e-4;
    let slope = (goal(&requested("100.1 mm")) - goal(&requested("99.9 mm"))) / (2.0 * step);
    let told = found.limits[0].multiplier.unwrap();
    assert!(slope > 0.0 && (told / slope - 1.0).abs() < 1e-2, "{told} {slope}");
    assert!(found.limits[1].multiplier.is_some() && (found.limits[1].value - 0.4).abs() < 1e-6);
    // Large is the opposite of small.
    let limits = ["max(slide.s) <= 400 mm", "min(slide.s) >= 260 mm"];
    let most = best(
        CARRIAGE,
        &OptimizeRequest { starts: 6, ..request(&vary, Aim::Most("range(slide.s)".parse().unwrap()), &limits) },
    );
    assert!((goal(&most) - 0.14).abs() < 1e-6 && most.limits.iter().all(|own| own.multiplier.is_some()), "{most:?}");
    assert!((most.limits[0].multiplier.unwrap() - 1.0).abs() < 1e-6, "{:?}", most.limits);
}

/// Two equations for three quantities leave a bent line, along which the rod leans less the lower the slide is: all searches follow it to its end, where both dead points have a triangle with a
/// right angle each.
#[test]
fn searches_follow_the_line_that_equations_leave() {
    let scene = CARRIAGE
        .replace("[parameters]", "[parameters]\noffset = { value = 0, min = \"-100 mm\", max = \"100 mm\" }")
        .replace("[bodies]", "[ground.points]\nguide = [0, \"offset\"]\n[bodies]")
        .replace("[\"ground\", \"carriage\"]", "[\"ground.guide\", \"carriage\"]");
    let limits = ["max(slide.s) = 400 mm", "range(slide.s) = 100 mm"];
    let vary = ["crank", "rod", "offset"];
    let found = best(&scene, &OptimizeRequest { starts: 8, ..request(&vary, least("max(link.angle)"), &limits) });
    let (far, near) = (0.4_f64.hypot(0.1), 0.3_f64.hypot(0.1));
    let known = [0.5 * (far - near), 0.5 * (far + near), -0.1];
    for own in &found.searches {
        let off = own.values.iter().zip(known).map(|(own, known)| (own - known).abs()).fold(0.0, f64::max);
        assert!(own.ended == "optimum" && off < 1e-6, "{known:?} {own:?}");
    }
    let angle = ((known[0] - 0.1) / known[1]).asin();
    assert!((found.values[1].unwrap() - angle).abs() < 1e-6, "{angle} {found:?}");
    // Each equation has one multiplier: what the goal changes by when the equation does.
    let told = found.limits[1].multiplier.unwrap();
    let with = |stroke: &str| {
        let limits = [limits[0], &*format!("range(slide.s) = {stroke}")];
        best(&scene, &OptimizeRequest { starts: 1, ..request(&vary, least("max(link.angle)"), &limits) }).values[1]
            .unwrap()
    };
    let slope = (with("100.1 mm") - with("99.9 mm")) / 2e-4;
    assert!((told / slope - 1.0).abs() < 1e-2, "{told} {slope}");
}

/// The same request gives the same answer, in any number of threads; whoever stops it keeps the best values.
#[test]
fn threads_change_nothing_and_a_stop_keeps_the_best() {
    let own = |threads| OptimizeRequest {
        starts: 6,
        seed: 7,
        threads,
        ..request(&["crank", "rod"], least("peak(motor.torque)"), &["range(slide.s) = 100 mm"])
    };
    let alone = best(CARRIAGE, &own(1));
    assert_eq!(alone, best(CARRIAGE, &own(3)));
    let told = AtomicUsize::new(0);
    let stopped = watched(CARRIAGE, &own(1), &|progress| {
        told.store(progress.evaluations, Ordering::Relaxed);
        progress.evaluations < 12
    });
    match stopped {
        Ok(found) => {
            let last = found.searches.last().map(|own| own.ended.as_str());
            assert!(found.searches.len() < 6 && found.evaluations <= 13 && last == Some("stopped"), "{found:?}");
        }
        Err(OptimizeError::Unmet { .. }) => {}
        Err(other) => panic!("{other}"),
    }
    assert!((12..=13).contains(&told.load(Ordering::Relaxed)));
}

#[test]
fn what_cannot_be_asked_is_refused_with_its_reason() {
    let refused = |request: &OptimizeRequest| watched(CARRIAGE, request, &|_| true).unwrap_err().to_string();
    let vary = ["crank", "rod"];
    let contradiction = ["range(slide.s) >= 120 mm", "range(slide.s) <= 100 mm"];
    let message =
        refused(&OptimizeRequest { starts: 3, ..request(&vary, least("peak(motor.torque)"), &contradiction) });
    assert!(
        message.contains("no values were found that meet all constraints") && message.contains("range(slide.s)"),
        "{message}"
    );
    let message = refused(&request(
        &["crank=20..", "rod=150..10000 mm"],
        least("peak(motor.torque)"),
        &["max(slide.s) + peak(motor.torque) <= 3"],
    ));
    assert!(message.contains("must be at most") || message.contains("cannot be added"), "{message}");
    let message = refused(&request(&vary, least("slide.s"), &["max(slide.s) <= 3 kg"]));
    assert!(message.contains("max(slide.s) <= 3 kg"), "{message}");
    let message = refused(&OptimizeRequest { starts: 0, ..request(&vary, least("slide.s"), &[]) });
    assert!(message.contains("0 starts"), "{message}");
}

/// The best transmission angle of a crank-rocker that swings by 40 degrees while its crank turns by 160 and 200: a cubic, a golden section and another program agree.
#[test]
fn a_crank_rocker_has_the_best_transmission_angle() {
    let names = [
        ("frame", 1.0, 0.5, 2.0),
        ("crank_length", 0.25, 0.05, 0.6),
        ("rod", 0.55, 0.2, 1.5),
        ("swing", 0.75, 0.2, 1.5),
        ("along", 0.1, -1.0, 1.0),
        ("across", 0.1, -1.0, 1.0),
    ];
    let scene = four_bar(&names, "stop = 6.3", [0.8, 1.6]);
    let turn = cotree_study::motion::MotionRequest {
        input: Some("A".to_owned()),
        output: Some("D".to_owned()),
        ..Default::default()
    };
    let limits = ["stroke = 40 deg", "time_ratio = 1.25"];
    let aim = Aim::Most("min(transmission)".parse().unwrap());
    let found = best(
        &scene,
        &OptimizeRequest { turn: Some(turn), starts: 2, ..request(&["crank_length", "rod", "swing"], aim, &limits) },
    );
    let value = found.values[1].unwrap().to_degrees();
    assert!((value - 31.854).abs() < 2e-3 && found.ended == Ended::Settled, "{value} {found:#?}");
    for (own, known) in found.quantities.iter().zip([0.256_819, 0.519_656, 0.785_139]) {
        assert!((own.value - known).abs() < 2e-4, "{found:#?}");
    }
}

/// Derivatives of a full turn are exact: forces, shaking and transmission angles have their optimum where differences of whole turns have theirs, in a table that is searched through.
#[test]
fn a_turn_has_its_optimum_where_a_scan_has_it() {
    let names = [
        ("frame", 1.0, 0.5, 2.0),
        ("crank_length", 0.25, 0.05, 0.6),
        ("rod", 0.9, 0.2, 1.5),
        ("swing", 0.75, 0.2, 1.5),
        ("along", 0.1, -1.0, 1.0),
        ("across", 0.1, -1.0, 1.0),
    ];
    let scene = four_bar(&names, "stop = 6.3", [0.8, 1.6]);
    let turn = cotree_study::motion::MotionRequest {
        input: Some("A".to_owned()),
        output: Some("D".to_owned()),
        ..Default::default()
    };
    let figure = |swing: f64, name: &str| {
        let scene = Scene::from_toml(&scene).unwrap();
        let mut study = Study::new(&scene).unwrap();
        study.set("swing", |_| Ok(swing)).unwrap();
        let found = cotree_study::motion::study_of(&scene, study.mechanism(), &turn).unwrap();
        let column = found.table.iter().find(|column| column.name == name).unwrap();
        column.values.iter().fold(0.0, |most: f64, own| most.max(own.abs()))
    };
    for name in ["drive", "|shaking force|"] {
        let aim = Aim::Least(format!("peak({name})").parse().unwrap());
        let found = best(
            &scene,
            &OptimizeRequest { turn: Some(turn.clone()), starts: 1, ..request(&["swing=0.6..0.9"], aim, &[]) },
        );
        let value = found.values[1].unwrap();
        let scan = (0..=30).map(|k| figure(0.6 + 0.01 * f64::from(k), name)).fold(f64::INFINITY, f64::min);
        // Extremes lie between the samples of the table, and the optimum between the values of the scan.
        assert!(value <= scan * (1.0 + 1e-4) && value > 0.97 * scan, "{name}: {value} {scan}");
    }
}

/// The command writes a scene that does what was promised, and a line for each search.
#[test]
fn the_command_writes_a_scene_that_keeps_its_promise() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("carriage.toml"), CARRIAGE).unwrap();
    let run = |arguments: &[&str]| {
        let output = cotree(folder.path(), arguments);
        assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
        stdout(&output)
    };
    let arguments = [
        "optimize",
        "carriage.toml",
        "--vary",
        "crank,rod",
        "--minimize",
        "peak(motor.torque)",
        "--subject-to",
        "range(slide.s) = 100 mm",
        "--starts",
        "4",
        "-o",
        "best.toml",
        "--table",
        "searches.csv",
        "--plot",
        "around.svg",
        "--units",
        "mm",
    ];
    let text = run(&arguments);
    for part in ["best of 4 searches", "range(slide.s) = 100 mm", "a local optimum"] {
        assert!(text.contains(part), "{text}");
    }
    let json: serde_json::Value = serde_json::from_str(&run(&[&arguments[..], &["--json"]].concat())).unwrap();
    let table = run(&[
        "sweep",
        "best.toml",
        "--step",
        "0.1 ms",
        "--output",
        "peak(motor.torque)",
        "--output",
        "range(slide.s)",
    ]);
    let row: Vec<f64> = table.lines().nth(1).unwrap().split(',').filter_map(|cell| cell.parse().ok()).collect();
    assert!(
        (row[1] / json["goal"]["value"].as_f64().unwrap() - 1.0).abs() < 1e-5 && (row[2] - 0.1).abs() < 1e-6,
        "{table} {json}"
    );
    assert_eq!(fs::read_to_string(folder.path().join("searches.csv")).unwrap().lines().count(), 5);
    // Resumed from its table, in whatever units, it is where it was, at once; what was not searched begins at its start.
    let table = fs::read_to_string(folder.path().join("searches.csv")).unwrap();
    let part: Vec<&str> = table.lines().take(3).collect();
    fs::write(folder.path().join("part.csv"), part.join("\n")).unwrap();
    for (file, fewer) in [("searches.csv", true), ("part.csv", false)] {
        let resumed = [&arguments[..10], &["--resume", file, "--json"]].concat();
        let again: serde_json::Value = serde_json::from_str(&run(&resumed)).unwrap();
        let [before, after] = [&json, &again].map(|own| own["goal"]["value"].as_f64().unwrap());
        assert!((after / before - 1.0).abs() < 1e-9, "{before} {after}");
        let [before, after] = [&json, &again].map(|own| own["evaluations"].as_u64().unwrap());
        assert!(after < before && (!fewer || after <= 4 * 4), "{before} {after}");
    }
    let other =
        [&arguments[..2], &["--vary", "crank,rod", "--minimize", "slide.s", "--starts", "1", "--resume", "part.csv"]]
            .concat();
    let output = cotree(folder.path(), &other);
    assert!(code(&output) == 2 && stderr(&output).contains("search 1 is not one of 1"), "{}", stderr(&output));
    let picture = fs::read_to_string(folder.path().join("around.svg")).unwrap();
    for part in ["peak(motor.torque)", "range(slide.s)", "crank", "rod", "bound", "best"] {
        assert!(picture.contains(part) && !picture.contains("NaN"), "{part}");
    }
    // What is not there is said by its name, and as no fault of the scene.
    let wrong =
        |more: &[&str]| cotree(folder.path(), &[&["optimize", "carriage.toml", "--vary", "crank,rod"], more].concat());
    let output = wrong(&["--minimize", "peak(motr.torque)"]);
    assert!(code(&output) == 2 && stderr(&output).contains("motr.torque"), "{}", stderr(&output));
    let output = wrong(&["--minimize", "when_max(slide.s)"]);
    assert!(code(&output) == 2 && stderr(&output).contains("discontinuous"), "{}", stderr(&output));
    assert_eq!(code(&wrong(&[])), 2);
}
