//! `cotree synthesize`: tasks that are made from known linkages, and what cannot be answered.

use crate::outside::command;

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use command::{code, cotree, stderr, stdout};
use cotree::task::{Task, TaskKind};
use cotree_study::synthesis::{Answer, Solution, synthesize};
use cotree_synthesis::path::CouplerPath;
use cotree_synthesis::{Dyad, Linkage, Point, Pose, RandomNumbers};
use serde_json::Value;

fn point(random: &mut RandomNumbers) -> Point {
    Point::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0))
}

/// Poses of a random four-bar at inputs in order, and its lengths.
fn made(random: &mut RandomNumbers, count: usize) -> (Linkage, Vec<Pose>) {
    loop {
        let mut bar = || Dyad::Bar { moving: point(random), ground: point(random), length: random.between(0.2, 1.2) };
        let linkage = Linkage { first: bar(), second: bar() };
        let mut inputs: Vec<f64> = (0..count).map(|_| random.between(0.0, TAU)).collect();
        inputs.sort_by(f64::total_cmp);
        let poses: Option<Vec<Pose>> = inputs.iter().map(|input| linkage.pose(*input, 1.0)).collect();
        if let Some(poses) = poses {
            return (linkage, poses);
        }
    }
}

fn task(poses: &[Pose], more: &str) -> String {
    let all: Vec<String> =
        poses.iter().map(|own| format!("[{:?}, {:?}, {:?}]", own.at.re, own.at.im, own.angle)).collect();
    format!("name = \"task\"\n[poses]\nat = [{}]\n{more}", all.join(", "))
}

fn answered(text: &str) -> Answer {
    let task = Task::from_text(text).unwrap_or_else(|faults| panic!("{faults}\n{text}"));
    synthesize(&task, true).unwrap_or_else(|faults| panic!("{faults}\n{text}"))
}

#[test]
fn five_poses_have_the_known_four_bar_among_them_and_no_good_one_has_a_defect() {
    let mut random = RandomNumbers::new(40);
    let mut good = 0;
    for number in 0..60 {
        let (linkage, poses) = made(&mut random, 5);
        let answer = answered(&task(&poses, ""));
        let known = linkage.lengths();
        let is_known = |lengths: &[Option<f64>; 4]| {
            let near = |order: [usize; 4]| {
                (0..4).all(|i| match (lengths[i], known[order[i]]) {
                    (Some(one), Some(other)) => (one - other).abs() < 1e-6,
                    _ => false,
                })
            };
            near([0, 1, 2, 3]) || near([0, 3, 2, 1])
        };
        let there = answer.solutions.iter().any(|own| is_known(&own.lengths));
        assert!(
            there,
            "{number}: {known:?} is not among {:?}",
            answer.solutions.iter().map(|own| own.lengths).collect::<Vec<_>>()
        );
        assert_eq!(answer.looked_at, answer.good().count() + answer.left_out.values().sum::<usize>());
        assert!(
            !answer.left_out.keys().any(|reason| reason.contains("driven") || reason.contains("drives")),
            "{number}: {:?}",
            answer.left_out
        );
        for own in answer.good() {
            assert!(own.defects.is_empty() && own.driven.is_some_and(|miss| miss <= 1e-9));
            good += 1;
        }
    }
    assert!(good >= 60, "{good}");
}

/// What `--json` prints of a task in a folder.
fn printed(folder: &Path, text: &str, arguments: &[&str]) -> Value {
    fs::write(folder.join("task.toml"), text).unwrap();
    let run = cotree(folder, &[&["synthesize", "task.toml", "--json"], arguments].concat());
    assert_eq!(code(&run), 0, "{}", stderr(&run));
    serde_json::from_str(&stdout(&run)).unwrap()
}

#[test]
fn scenes_are_written_and_run_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let text = "name = \"lid\"\n[poses]\nat = [[0, 0, 0], [\"35 mm\", \"120 mm\", \"20 deg\"], [\"130 mm\", \"260 mm\", \"52 deg\"]]\n\
                [limits]\ntransmission = \"40 deg\"\nlength = [\"60 mm\", \"600 mm\"]\n";
    let answer = printed(folder.path(), text, &["-o", "lids"]);
    let solutions = answer["solutions"].as_array().unwrap();
    assert!(!solutions.is_empty());
    for own in solutions {
        assert!(own["transmission"].as_f64().unwrap() >= 40f64.to_radians() * (1.0 - 1e-9));
        let lengths = own["lengths"].as_array().unwrap().iter().filter_map(Value::as_f64);
        assert!(lengths.into_iter().all(|length| (0.06 - 1e-9..0.6 + 1e-9).contains(&length)));
        let scene = format!("lids/{}", own["scene"].as_str().unwrap());
        let run = cotree(folder.path(), &["simulate", &scene, "--units", "si"]);
        assert_eq!(code(&run), 0, "{}", stderr(&run));
    }
    let picture = fs::read_to_string(folder.path().join("lids/solutions.svg")).unwrap();
    assert!(picture.starts_with("<svg") && !picture.contains("NaN"));
}

#[test]
fn a_swing_has_its_angle_and_its_time_ratio_when_it_is_driven() {
    let folder = tempfile::tempdir().unwrap();
    let text = "name = \"quick\"\n[stroke]\ntime_ratio = 1.25\nswing = \"40 deg\"\nground = \"200 mm\"\n";
    let answer = printed(folder.path(), text, &["-o", "out"]);
    assert_eq!(answer["solutions"].as_array().unwrap().len(), 1);
    let run = cotree(
        folder.path(),
        &["motion", "out/1.toml", "--input", "first_pivot", "--output", "second_pivot", "--json"],
    );
    assert_eq!(code(&run), 0, "{}", stderr(&run));
    let said = stdout(&run);
    let figures: Value = serde_json::from_str(&said).unwrap();
    let ratio = figures["time_ratio"].as_f64().unwrap_or_else(|| panic!("{said:.2000}"));
    assert!((ratio - 1.25).abs() < 1e-6, "{ratio}");
}

#[test]
fn functions_and_paths_have_answers() {
    let law = answered(
        "name = \"law\"\n[function]\noutput = \"x^2\"\nx = [0, 1]\ninput = [\"0 deg\", \"70 deg\"]\nrange = [\"0 deg\", \"60 deg\"]\n",
    );
    let best = law.good().next().expect("a four-bar");
    assert!(best.error < 5e-3, "{}", best.error);
    let slider = answered(
        "name = \"slider\"\n[function]\ninput = [0, 0.5, 1.0, 1.6, 2.2]\noutput = [\"0 mm\", \"-12 mm\", \"-40 mm\", \"-81 mm\", \"-117 mm\"]\n",
    );
    assert!(slider.looked_at > 0);
    let known = Linkage {
        first: Dyad::Bar { moving: Point::new(-0.5, -0.4), ground: Point::new(0.1, 0.0), length: 0.3 },
        second: Dyad::Bar { moving: Point::new(0.4, -0.3), ground: Point::new(1.1, 0.2), length: 0.8 },
    };
    let first = known.pose(0.0, 1.0).expect("a crank turns");
    let curve = known.circuit(&first, 30);
    let points: Vec<String> = curve
        .into_iter()
        .filter_map(|(input, side)| known.pose(input, side))
        .map(|pose| format!("[{:?}, {:?}]", pose.at.re, pose.at.im))
        .collect();
    let path = answered(&format!("name = \"path\"\n[path]\nclosed = true\npoints = [{}]\n", points.join(", ")));
    assert!(path.good().count() >= 1, "{:?}", path.left_out);
    // The points are met; between them the curve is inside the path but for rounding of its sharpest turn.
    let best = path.good().map(|own| own.error).fold(f64::INFINITY, f64::min);
    assert!(best < 2e-3, "{best}");
}

#[test]
fn what_cannot_be_answered_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str| {
        fs::write(folder.path().join("task.toml"), text).unwrap();
        let run = cotree(folder.path(), &["synthesize", "task.toml"]);
        assert_eq!(code(&run), 1, "{text}\n{}", stdout(&run));
        stderr(&run)
    };
    let poses = |at: &str| refused(&format!("name = \"x\"\n[poses]\nat = [{at}]\n"));
    assert!(poses("[0, 0, 0], [1, 0, 0.2], [0, 0, 0]").contains("poses 1 and 3 are the same"));
    assert!(poses("[0, 0, 0], [1, 1, 0], [2, 2, 0]").contains("on a line"));
    assert!(poses("[0, 0, 0], [1, 1, 0], [2, 3, 0]").contains("does not turn"));
    assert!(poses("[1, 0, 0], [0, 1, \"90 deg\"], [-1, 0, \"180 deg\"]").contains("one point"));
    assert!(poses("[1, 0, 0], [0, 1, \"90 deg\"], [-1, 0, \"180 deg\"]").contains("(0 m, 0 m)"));
    assert!(poses("[1, 0, 0]").contains("at least two poses"));
    assert!(poses("[1, 0], [0, 1, 1]").contains("2 numbers, but must have three"));
    let limits = |limit: &str| {
        refused(&format!("name = \"x\"\n[poses]\nat = [[0, 0, 0], [1, 0, 0.3], [2, 1, 0.9]]\n[limits]\n{limit}\n"))
    };
    assert!(limits("length = [2, 1]").contains("its lower bound is above the upper one"));
    assert!(limits("transmission = \"95 deg\"").contains("below 90 degrees"));
    assert!(limits("speed = 1").contains("no key `speed`"));
    assert!(refused("name = \"x\"\n").contains("no table `[poses]`, `[function]`, `[path]` or `[stroke]`"));
    let scene = refused("format = 1\nname = \"x\"\ngravity = [0, -9.81]\n[bodies.bar]\nmass = 1\n");
    assert!(scene.contains("this is a scene, not a task: it has the key `format`"), "{scene}");
    let two = refused("name = \"x\"\n[path]\npoints = [[0, 0], [1, 1], [2, 0]]\n[stroke]\nswing = 1\n");
    assert!(two.contains("2 tables are written: `[path]`, `[stroke]`"), "{two}");
    let path = |more: &str| refused(&format!("name = \"x\"\n[path]\n{more}\n"));
    assert!(path("points = [[0, 0], [1, 1], [1, 1], [2, 0]]").contains("points 2 and 3 are the same"));
    let pivots = path("points = [[0, 0], [1, 1], [2, 0]]\npivots = [[0, -1], [0, -1]]");
    assert!(pivots.contains("both pivots are the same point"), "{pivots}");
    let function = refused("name = \"x\"\n[function]\ninput = [0, 0.3, 0.3]\noutput = [0, 0.2, 0.5]\n");
    assert!(function.contains("pairs 2 and 3 have the same input"), "{function}");
    let stroke = |more: &str| refused(&format!("name = \"x\"\n[stroke]\ntime_ratio = 1.2\n{more}\n"));
    let swing = stroke("swing = \"200 deg\"");
    assert!(swing.contains("`swing` is 200 deg, but must be between 0 and 180 deg"), "{swing}");
    assert!(stroke("stroke = \"-5 mm\"").contains("`stroke` is -0.005, but must be positive"));
    assert!(stroke("swing = 0.5\n[limits]\nwithin = \"1 mm\"").contains("no effect on a stroke"));
    assert!(stroke("swing = 0.5\n[limits]\nbars = 6").contains("six-bars are found for paths"));
    assert!(path("points = [[0, 0], [1, 1], [2, 0]]\n[limits]\nprefer = \"size\"").contains("without `within`"));
    assert!(path("points = [[0, 0], [1, 1], [2, 0]]\n[limits]\nwithin = \"1 deg\"").contains("`within` is not in m"));
    assert!(path("points = [[0, 0], [1, 1], [2, 0]]\n[limits]\nbars = 5").contains("must be 4 or 6"));
    assert!(stroke("swing = 0.5\noffset = 0.1").contains("`offset` of `stroke` has no effect on a swing"));
    assert!(stroke("stroke = 0.5\nground = 0.1").contains("`ground` of `stroke` has no effect on a slider"));
    assert!(stroke("swing = 0.5\n[choose]\nground_a = [0, 0]").contains("`choose` of the task has no effect"));
    let function = |more: &str| refused(&format!("name = \"x\"\n[function]\ninput = [0, 0.5, 1]\n{more}\n"));
    assert!(function("output = [0, 0.4, 1]\nrange = [0, 1]").contains("`range` of `function` has no effect"));
    assert!(function("output = [0, \"4 mm\", \"9 mm\"]\noutput_zero = 1").contains("no effect on a slider"));
}

#[test]
fn the_limit_that_removed_the_last_one_is_named() {
    let mut random = RandomNumbers::new(41);
    let (_, poses) = made(&mut random, 5);
    let answer = answered(&task(&poses, "[limits]\nlength = [\"10 m\", \"20 m\"]\n"));
    assert_eq!(answer.good().count(), 0);
    let text = answer.report().text(&cotree_study::synthesis::report::usual());
    assert!(
        text.contains("candidates meet the limits;") && text.contains("limit `length`; the closest misses it by"),
        "{text}"
    );
}

/// Seven poses, which no four-bar takes a body through: the link of a six-bar does within 1 mm, driven by the program, its frame being that of the body.
#[test]
fn a_six_bar_takes_a_body_through_more_poses_than_a_four_bar() {
    let at = [
        [0.0, 0.0, 0.0],
        [40.0, 25.0, 2.0],
        [80.0, 42.0, 6.0],
        [120.0, 50.0, 14.0],
        [160.0, 48.0, 28.0],
        [195.0, 35.0, 45.0],
        [225.0, 10.0, 62.0],
    ];
    let rows: Vec<String> =
        at.iter().map(|[x, y, angle]| format!("[\"{x} mm\", \"{y} mm\", \"{angle} deg\"]")).collect();
    let limits = "length = [\"20 mm\", \"600 mm\"]\ntransmission = \"25 deg\"\nbars = 6";
    let answer = answered(&format!("name = \"seven\"\n[poses]\nat = [{}]\n[limits]\n{limits}\n", rows.join(", ")));
    let best = &answer.six_bars[0];
    assert!(best.error < 1e-3 && best.driven < 1e-9, "{} {}", best.error, best.driven);
    assert!(best.lengths.iter().all(|length| (0.02 - 1e-9..=0.6 + 1e-9).contains(length)), "{:?}", best.lengths);
    assert!(best.transmission.iter().all(|angle| angle.to_degrees() > 24.9), "{:?}", best.transmission);
    // At its start the body is in the first or the last pose, up to the error.
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("six.toml"), &best.scene).unwrap();
    let variables = "link.tracer.x,link.tracer.y,link.angle";
    let output =
        cotree(folder.path(), &["simulate", "six.toml", "--stop", "1e-6", "--step", "1e-6", "--variables", variables]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let row = stdout(&output).lines().nth(1).unwrap().to_owned();
    let first: Vec<f64> = row.split(',').skip(1).map(|own| own.parse().unwrap()).collect();
    let near = |pose: &[f64; 3]| {
        let off = [first[0] - pose[0] * 1e-3, first[1] - pose[1] * 1e-3, first[2] - pose[2].to_radians()];
        off.iter().all(|own| own.abs() < 5e-3)
    };
    assert!(near(&at[0]) || near(&at[6]), "{first:?}");
}

/// The figures of `cotree motion` for the best six-bar of a task.
fn moved_six_bar(answer: &Answer, arguments: &[&str]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("six.toml"), &answer.six_bars[0].scene).unwrap();
    let run = cotree(folder.path(), &[&["motion", "six.toml", "--input", "first_pivot", "--json"], arguments].concat());
    assert_eq!(code(&run), 0, "{}", stderr(&run));
    serde_json::from_str(&stdout(&run)).unwrap()
}

/// A rocker that stays within 0.5 deg for 60 deg of the crank, twenty times as near as the best four-bar: `motion` drives a full turn and finds the dwell.
#[test]
fn a_six_bar_dwells() {
    let text = "name = \"dwell\"\n[function]\n\
                input = [\"0 deg\", \"10 deg\", \"20 deg\", \"30 deg\", \"40 deg\", \"50 deg\", \"60 deg\", \"150 deg\", \"180 deg\", \"210 deg\"]\n\
                output = [0, 0, 0, 0, 0, 0, 0, \"18 deg\", \"26 deg\", \"18 deg\"]\n\
                [limits]\nlength = [\"0.05 m\", \"4 m\"]\ntransmission = \"20 deg\"\ncrank = true\nbars = 6\n";
    let answer = answered(text);
    let best = &answer.six_bars[0];
    let four = answer.good().map(|own| own.error).fold(f64::INFINITY, f64::min);
    assert!(best.error.to_degrees() < 0.05 && four > 20.0 * best.error, "{} {four}", best.error);
    let figures = moved_six_bar(&answer, &["--output", "pin_6", "--dwell", "0.5 deg"]);
    assert!(figures["full_turn"] == true && figures["dead_points"] == false);
    let [from, to] = ["from", "to"].map(|end| figures["dwell"][end].as_f64().unwrap());
    assert!((to - from).to_degrees() >= 60.0, "{from} {to}");
}

/// A straight line of 200 mm within 0.05 mm, by bars of at most 400 mm with transmission angles of at least 40 deg: `motion` follows the point.
#[test]
fn a_six_bar_draws_a_straight_line() {
    let points: Vec<String> = (0..=10).map(|k| format!("[\"{} mm\", 0]", 20 * k)).collect();
    let limits = "length = [\"20 mm\", \"400 mm\"]\ntransmission = \"40 deg\"\nbars = 6";
    let text = format!("name = \"line\"\n[path]\npoints = [{}]\n[limits]\n{limits}\n", points.join(", "));
    let answer = answered(&text);
    let best = &answer.six_bars[0];
    assert!(best.error < 5e-5 && best.lengths.iter().all(|length| *length < 0.4 + 1e-9), "{best:?}");
    assert!(best.transmission.iter().all(|angle| angle.to_degrees() > 39.9), "{:?}", best.transmission);
    let number = |key: &str| {
        let line = best.scene.lines().find_map(|line| line.strip_prefix(key)).unwrap();
        line.split(' ').next().unwrap().parse::<f64>().unwrap()
    };
    let (start, stop) = (number("angle = \""), number("stop = "));
    let sign = if best.scene.contains("(-1.0)*t") { -1.0 } else { 1.0 };
    let range = format!("{start:?} rad..{:?} rad", start + sign * stop);
    let figures = moved_six_bar(&answer, &["--point", "link.tracer", "--range", &range]);
    let part = |key: &str| -> Vec<f64> {
        figures["path"][key].as_array().unwrap().iter().map(|own| own.as_f64().unwrap()).collect()
    };
    let (x, y) = (part("x"), part("y"));
    assert!(y.iter().all(|own| own.abs() < 5e-5), "{y:?}");
    let [least, most] = [f64::min, f64::max].map(|of| x.iter().copied().reduce(of).unwrap());
    assert!(least < 5e-5 && most > 0.2 - 5e-5, "{least} {most}");
}

/// An output that goes there and back twice in one turn of the crank, which no four-bar does.
#[test]
fn a_six_bar_has_more_extremes_than_a_four_bar() {
    let input: Vec<String> = (0..12).map(|k| format!("\"{} deg\"", 30 * k)).collect();
    let output: Vec<String> =
        (0..12).map(|k| format!("\"{:.4} deg\"", 10.0 * (TAU * f64::from(k) / 6.0).sin())).collect();
    let text = format!(
        "name = \"twice\"\n[function]\ninput = [{}]\noutput = [{}]\n[limits]\nlength = [\"0.05 m\", \"4 m\"]\ncrank = true\nbars = 6\n",
        input.join(", "),
        output.join(", ")
    );
    let answer = answered(&text);
    let best = &answer.six_bars[0];
    let four = answer.good().map(|own| own.error).fold(f64::INFINITY, f64::min);
    assert!(best.error.to_degrees() < 0.1 && four.to_degrees() > 5.0, "{} {four}", best.error);
    let figures = moved_six_bar(&answer, &["--output", "pin_6"]);
    assert!(figures["full_turn"] == true && figures["dead_points"] == false);
    assert_eq!(figures["limits"].as_array().unwrap().len(), 4, "{}", figures["limits"]);
}

/// Poses that no four-bar comes near: that there are more than five of them is said.
#[test]
fn too_many_poses_are_named() {
    let at = "[0, 0, 0], [0.1, 0.1, 0.1], [0.15, 0.2, 0.3], [0.2, 0.3, 0.35], [0.3, 0.3, 0.6], [0.35, 0.25, 0.8], [0.4, 0.1, 1]";
    let answer = answered(&format!("name = \"x\"\n[poses]\nat = [{at}]\n"));
    assert_eq!(answer.good().count(), 0);
    let text = answer.report().text(&cotree_study::synthesis::report::usual());
    assert!(text.contains("at most five general poses"), "{text}");
}

/// Between given pivots five points have finitely many four-bars: this many, as Morgan and Wampler 1990 published, and all are looked at.
#[test]
fn five_points_between_given_pivots_have_all_their_four_bars() {
    let answer = answered(
        "name = \"five\"\n[path]\npoints = [[0.5, 1.06], [-0.83, -0.27], [-0.34, 0.22], [-0.13, 0.43], [0.22, 0.78]]\npivots = [[0, 0], [1, 0]]\n",
    );
    assert_eq!(answer.looked_at, 15, "{:?}", answer.left_out);
}

/// A task whose poses or points stand in a table is the same task.
#[test]
fn tables_of_poses_and_points_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).unwrap();
        folder.path().join(name)
    };
    put("poses.csv", "x [mm]; y [mm]; angle [deg]; weight\n0;0;0;1\n35;120;20;1\n130;260;52;2\n");
    put("curve.csv", "x,y,crank [deg]\n0,0,10\n1,0,40\n1,1,70\n");
    let read = |text: &str| Task::read(&put("task.toml", text));
    let TaskKind::Poses { at, tolerance, weight } = read("[poses]\nat = \"poses.csv\"\n").unwrap().kind else {
        panic!()
    };
    assert!((at[2].at.re - 0.13).abs() < 1e-15 && (at[2].angle - 52f64.to_radians()).abs() < 1e-15, "{at:?}");
    assert_eq!((tolerance, weight), (None, Some(vec![1.0, 1.0, 2.0])));
    let TaskKind::Path(CouplerPath { points, crank, .. }) = read("[path]\npoints = \"curve.csv\"\n").unwrap().kind
    else {
        panic!()
    };
    assert_eq!(points, [Point::new(0.0, 0.0), Point::new(1.0, 0.0), Point::new(1.0, 1.0)]);
    assert!((crank.unwrap()[2] - 60f64.to_radians()).abs() < 1e-15);
    let refused = |table: &str, more: &str| {
        put("poses.csv", table);
        read(&format!("[poses]\nat = \"poses.csv\"\n{more}")).unwrap_err().to_string()
    };
    let right = "x [mm],y [mm],angle [deg],weight\n0,0,0,1\n35,120,20,1\n";
    assert!(refused(right, "weight = 2\n").contains("poses whose table has it"));
    assert!(refused(&right.replace("mm],angle", "deg],angle"), "").contains("must be in m"));
    assert!(refused(&right.replace("angle [deg]", "turn [deg]"), "").contains("no task has a column `turn`"));
    assert!(refused("x,y\n0,0\n1,1\n", "").contains("no column is `angle`"));
    assert!(refused(&right.replace(",20,", ",,"), "").contains("the cell is empty"));
    assert!(read("[poses]\nat = \"none.csv\"\n").unwrap_err().to_string().contains("none.csv"));
}

/// A parabola is followed best by bars hundreds of times as long as the ground, of which nobody can make one: they are left out with their number, and asked for by `length` they come.
#[test]
fn bars_out_of_all_proportion_are_left_out_and_said() {
    let law = "name = \"square\"\n[function]\noutput = \"x^2\"\nx = [0, 1]\ninput = [\"0 deg\", \"90 deg\"]\nrange = [\"0 deg\", \"90 deg\"]\nground = \"0.5 m\"\n";
    let answer = answered(law);
    let longest = |answer: &Answer| {
        let lengths = answer.good().flat_map(|own| own.lengths).flatten();
        lengths.fold(0.0, f64::max)
    };
    assert!(answer.good().count() > 0 && longest(&answer) <= 20.0 * 0.5, "{}", longest(&answer));
    assert!(answer.good().all(|own| own.driven.is_some_and(|miss| miss <= 1e-9)));
    assert!(
        answer.left_out.iter().any(|(reason, count)| reason.contains("20 times") && *count > 0),
        "{:?}",
        answer.left_out
    );
    let requested = answered(&format!("{law}[limits]\nlength = [\"1 mm\", \"1 km\"]\n"));
    assert!(requested.left_out.keys().all(|reason| !reason.contains("20 times")), "{:?}", requested.left_out);
    // A size that the task does not give is said.
    let text = |text: &str| answered(text).report().text(&cotree::model::Units::default());
    let swing =
        "name = \"even\"\n[stroke]\ntime_ratio = 1\nswing = \"40 deg\"\n[limits]\nlength = [\"50 mm\", \"2 m\"]\n";
    for (task, ground) in [(law, "0.5 m"), (swing, "1 m"), (&law.replace("ground = \"0.5 m\"\n", ""), "1 m")] {
        assert!(text(task).contains(&format!("a ground of {ground} (")), "{}", text(task));
    }
    // What is written is driven once more by the command, over the whole way.
    let folder = tempfile::tempdir().unwrap();
    printed(folder.path(), law, &["-o", "found"]);
    for index in 1..=answer.good().count() {
        let output = cotree(folder.path(), &["simulate", &format!("found/{index}.toml"), "-o", "run.csv"]);
        assert_eq!(code(&output), 0, "{index}: {}", stderr(&output));
    }
}

/// A path as feet of walking machines have it.
const FOOT: &str = "name = \"foot\"\n[path]\npoints = [[\"0 mm\", 0], [\"40 mm\", 0], [\"80 mm\", 0], [\"120 mm\", 0], [\"160 mm\", 0], [\"190 mm\", \"15 mm\"], \
    [\"180 mm\", \"45 mm\"], [\"140 mm\", \"65 mm\"], [\"80 mm\", \"72 mm\"], [\"20 mm\", \"65 mm\"], [\"-20 mm\", \"45 mm\"], [\"-30 mm\", \"15 mm\"]]\nclosed = true\n\
    [limits]\nlength = [\"15 mm\", \"500 mm\"]\ncrank = true\ntransmission = \"25 deg\"\n";

/// A bar with its pin in the body, its pivot and its length.
fn bar(dyad: &Dyad) -> (Point, Point, f64) {
    match *dyad {
        Dyad::Bar { moving, ground, length } => (moving, ground, length),
        _ => panic!("a four-bar"),
    }
}

/// The curve of the body's origin in a full turn of the crank: the second pin is where two circles meet, on the side on which it is in the first pose.
fn curve(solution: &Solution) -> Vec<Point> {
    let ((a, a0, r), (b, b0, s)) = (bar(&solution.linkage.first), bar(&solution.linkage.second));
    let long = (b - a).norm();
    let cross = |u: Point, v: Point| u.re * v.im - u.im * v.re;
    let first = solution.poses[0];
    let side = cross(b0 - first.carry(a), first.carry(b) - first.carry(a)).signum();
    let place = |angle: f64| {
        let pin = a0 + Point::from_polar(r, angle);
        let between = b0 - pin;
        let cosine = (long * long + between.norm_sqr() - s * s) / (2.0 * long * between.norm());
        let along = between / between.norm() * Point::from_polar(1.0, side * cosine.clamp(-1.0, 1.0).acos());
        pin - along * (long / (b - a)) * a
    };
    (0..2000).map(|k| place(TAU * f64::from(k) / 2000.0)).collect()
}

/// The largest distance of points from a closed polygon.
fn farthest(points: &[Point], polygon: &[Point]) -> f64 {
    let distance = |p: &Point, k: usize| {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        let share = ((p - a) * (b - a).conj()).re / (b - a).norm_sqr();
        (p - a - (b - a) * share.clamp(0.0, 1.0)).norm()
    };
    let nearest = |p: &Point| (0..polygon.len()).map(|k| distance(p, k)).fold(f64::INFINITY, f64::min);
    points.iter().map(nearest).fold(0.0, f64::max)
}

/// What is said to be the error of a closed path is the distance both ways: it is no less than either, but for 2 % of the size that the path may be rounder than its polygon.
#[test]
fn the_curve_of_a_linkage_is_as_near_to_a_closed_path_as_its_error_says() {
    let answer = answered(FOOT);
    let TaskKind::Path(CouplerPath { points, .. }) = &answer.task.kind else { panic!("a path") };
    assert!(answer.good().count() + answer.shorter.len() >= 3);
    for own in answer.good().chain(&answer.shorter) {
        let curve = curve(own);
        let [to, from] = [farthest(points, &curve), farthest(&curve, points)];
        assert!(own.error > to - 1e-5 && own.error > from - 0.02 * 0.22 - 1e-5, "{} {to} {from}", own.error);
        assert!(own.error < to.max(from) + 1e-5, "{} {to} {from}", own.error);
    }
}

/// The same for an open path: a line is drawn between its ends, and not around them.
#[test]
fn an_open_path_counts_between_its_ends() {
    let points: Vec<String> = (0..4).map(|k| format!("[\"{} mm\", 0]", 100 * k)).collect();
    let answer = answered(&format!(
        "name = \"line\"\n[path]\npoints = [{}]\n[limits]\nlength = [\"20 mm\", \"400 mm\"]\n",
        points.join(", ")
    ));
    for own in answer.good() {
        let ends = [own.poses[0], own.poses[3]].map(|pose| own.linkage.input(&pose));
        let (side, way) = (own.linkage.side(&own.poses[0]), cotree_synthesis::way(ends[0], ends[1]));
        let sample = |way: f64| -> f64 {
            let place = |k: i32| own.linkage.pose(ends[0] + way * f64::from(k) / 500.0, side);
            (0..=500).map(|k| place(k).map_or(f64::INFINITY, |pose| pose.at.im.abs())).fold(0.0, f64::max)
        };
        // The crank goes one way or the other.
        let off = sample(way).min(sample(way - way.signum() * TAU));
        assert!(own.error >= off - 1e-6, "{} {off}", own.error);
    }
}

/// The size of a linkage counts the point that draws: it is bounded by `length`, what is called shorter is smaller, and the smallest is the first.
#[test]
fn the_size_of_a_linkage_has_its_coupler_point_in_it() {
    let size = |own: &Solution| {
        let ((a, a0, r), (b, b0, s)) = (bar(&own.linkage.first), bar(&own.linkage.second));
        [(b0 - a0).norm(), r, (b - a).norm(), s, a.norm(), b.norm()].into_iter().fold(0.0, f64::max)
    };
    let foot = answered(FOOT);
    let first = foot.good().next().expect("a linkage").size;
    for own in foot.good().chain(&foot.shorter) {
        assert!((own.size - size(own)).abs() < 1e-12 && own.size <= 0.5 * (1.0 + 1e-9), "{} {}", own.size, size(own));
    }
    assert!(foot.shorter.iter().all(|own| own.size < first));
    let points: Vec<String> = (0..7).map(|k| format!("[0, \"{} mm\"]", 25 * k)).collect();
    let line = answered(&format!(
        "name = \"lift\"\n[path]\npoints = [{}]\n[limits]\nground = {{ x = [\"50 mm\", \"500 mm\"], y = [\"-150 mm\", \"300 mm\"] }}\n\
         within = \"1 mm\"\nprefer = \"size\"\ntransmission = \"40 deg\"\n",
        points.join(", ")
    ));
    let sizes: Vec<f64> = line.good().map(size).collect();
    assert!(sizes.len() > 1 && sizes.iter().all(|other| sizes[0] <= other * (1.0 + 1e-9)), "{sizes:?}");
}

/// Millimetres without their unit beside limits in millimetres: what to write is said, and nothing ends in a panic.
#[test]
fn a_path_in_bare_millimetres_is_refused_with_what_to_write() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str| {
        fs::write(folder.path().join("task.toml"), text).unwrap();
        let run = cotree(folder.path(), &["synthesize", "task.toml"]);
        assert_eq!(code(&run), 1, "{}", stdout(&run));
        stderr(&run)
    };
    let bare = "name = \"s\"\n[path]\npoints = [[0, 0], [50, 0], [100, 0], [150, 0], [200, 0]]\n[limits]\nlength = [\"20 mm\", \"1 m\"]\n";
    let said = refused(bare);
    assert!(said.contains("the path is 200 m long, but no link may be longer than 1 m"), "{said}");
    assert!(said.contains("write `\"50 mm\"` instead of `50`") && !said.contains("internal"), "{said}");
    assert!(said.contains("`points` is 50 metres"), "{said}");
    let units = refused(
        "name = \"s\"\n[path]\npoints = [[0, 0], [\"5 m\", 0], [\"9 m\", 0]]\n[limits]\nlength = [\"20 mm\", \"1 m\"]\n",
    );
    assert!(units.contains("make `length` longer"), "{units}");
}
