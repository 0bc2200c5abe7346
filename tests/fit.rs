//! `cotree fit`: values that are known come back from noisy motions, with errors that are true.

use crate::outside::command;

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use command::{code, cotree, stderr, stdout};
use cotree::Scene;
use cotree::report::csv::CsvTable;
use cotree::scene::Requested;
use cotree_study::analysis::Study;
use cotree_study::fit::{Fit, FitEnded, FitRequest, FitTrial, Vary, fit, fit_watched};

const SCENE: &str = r#"# A mass on a spring.
format    = 1
name      = "oscillator"
dimension = 1

[parameters]
stiffness = "0.3 N/mm"      # a guess
damping   = { value = 4.0, unit = "N.s/m", min = 0.0 }
offset    = 0.0
idle      = "1 kg"

[bodies.block]
mass = 2.0

[loads.spring]
type      = "spring"
between   = ["ground", "block"]
stiffness = "stiffness"
length    = 0.0
damping   = "damping"

[initial]
"block.x" = "0.1 m"
"block.vx" = 0.0

[outputs]
variables = ["block.x", "block.vx"]
seen      = "block.x + offset"
double    = "2*block.x"

[experiment]
stop = "2 s"
tolerance = 1e-7
"#;

/// What the measured motion was made with.
const TRUTH: [f64; 3] = [250.0, 6.0, 0.12];
const COUNT: usize = 60;

/// Position and speed of a free vibration, by its closed form.
fn exact(t: f64) -> [f64; 2] {
    let [stiffness, damping, start] = TRUTH;
    let (decay, square) = (damping / 4.0, stiffness / 2.0);
    let turning = (square - decay * decay).sqrt();
    let (sine, cosine) = (turning * t).sin_cos();
    let fading = (-decay * t).exp();
    [start * fading * (cosine + decay / turning * sine), -start * fading * square / turning * sine]
}

/// SplitMix64 and Box and Muller's transform.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Position with an error of 2 mm, speed with one of 0.1 m/s.
fn measured(seed: u64) -> CsvTable {
    let mut noise = Noise(seed.wrapping_mul(0x1234_5678_9abc_def1));
    let times: Vec<f64> = (0..COUNT).map(|index| 2.0 * index as f64 / COUNT as f64).collect();
    let rows: Vec<[f64; 2]> = times.iter().map(|&t| exact(t)).collect();
    let x = rows.iter().map(|row| row[0] + 0.002 * noise.normal()).collect();
    let v = rows.iter().map(|row| row[1] + 0.1 * noise.normal()).collect();
    // Not in the order of the scene.
    CsvTable::new(vec!["block.vx".to_owned(), "block.x".to_owned()], times, vec![v, x]).unwrap()
}

fn request(table: CsvTable, vary: &[&str]) -> FitRequest {
    let vary = vary.iter().map(|text| Vary::read(text).unwrap()).collect();
    FitRequest { tables: vec![table], vary, deviations: Vec::new() }
}

fn fitted(request: &FitRequest) -> Fit {
    let scene = Scene::from_toml(SCENE).unwrap();
    let requested = Requested::these(request.tables[0].names());
    fit(&mut [Study::asking(&scene, &requested).unwrap()], request).unwrap()
}

/// Of 3 times 40 intervals that hold the truth in 95 of 100 cases 114 do so, give or take 2.4: the noise is the same every time.
#[test]
fn truth_is_within_its_limits_as_often_as_they_say() {
    let (mut inside, mut farthest) = (0, 0.0_f64);
    let mut squares = [0.0; 3];
    for seed in 1..=40 {
        let found = fitted(&request(measured(seed), &["stiffness", "damping", "block.x"]));
        assert_eq!(found.ended, FitEnded::Settled);
        for (place, (own, truth)) in found.quantities.iter().zip(TRUTH).enumerate() {
            let ([low, high], error) = (own.limits.unwrap(), own.error.unwrap());
            inside += usize::from((low..=high).contains(&truth));
            farthest = farthest.max((own.value - truth).abs() / error);
            squares[place] += ((own.value - truth) / error).powi(2) / 40.0;
        }
        for (column, deviation) in found.measured[0].columns.iter().zip([0.1, 0.002]) {
            assert!((column.deviation / deviation - 1.0).abs() < 0.3, "{}: {}", column.name, column.deviation);
        }
    }
    assert!((107..=119).contains(&inside), "{inside} of 120");
    assert!(farthest < 4.0, "{farthest}");
    // Errors in units of the standard error have the variance one.
    assert!(squares.iter().all(|square| (0.5..1.6).contains(square)), "{squares:?}");
}

/// The covariance of linear least squares is known: amplitude and offset of a motion that is not varied otherwise.
#[test]
fn errors_and_correlations_are_those_of_linear_least_squares() {
    let times: Vec<f64> = (0..40).map(|index| 0.01 + 0.05 * f64::from(index)).collect();
    let scene = Scene::from_toml(SCENE).unwrap();
    let mut study = Study::asking(&scene, &Requested::these(["block.x"])).unwrap();
    let unit: Vec<f64> = {
        let found = study.sensitivities(&["block.x".to_owned()], &times).unwrap();
        found.derivatives.iter().map(|row| row[(0, 0)]).collect()
    };
    let mut noise = Noise(9);
    let seen: Vec<f64> = unit.iter().map(|unit| 0.3 * unit + 0.05 + 0.01 * noise.normal()).collect();
    let table = CsvTable::new(vec!["seen".to_owned()], times, vec![seen.clone()]).unwrap();
    let found = fitted(&request(table, &["block.x", "offset"]));
    // Normal equations of y = a u + b.
    let n = unit.len() as f64;
    let [su, sy] = [&unit, &seen].map(|values| values.iter().sum::<f64>());
    let suu: f64 = unit.iter().map(|u| u * u).sum();
    let suy: f64 = unit.iter().zip(&seen).map(|(u, y)| u * y).sum();
    let determinant = n * suu - su * su;
    let (a, b) = ((n * suy - su * sy) / determinant, (suu * sy - su * suy) / determinant);
    let rest: f64 = unit.iter().zip(&seen).map(|(u, y)| (y - a * u - b).powi(2)).sum();
    let variance = rest / (n - 2.0);
    let errors = [(variance * n / determinant).sqrt(), (variance * suu / determinant).sqrt()];
    for ((own, value), error) in found.quantities.iter().zip([a, b]).zip(errors) {
        assert!((own.value - value).abs() < 1e-5 * error, "{}: {} instead of {value}", own.name, own.value);
        assert!((own.error.unwrap() / error - 1.0).abs() < 1e-6, "{}: {:?} instead of {error}", own.name, own.error);
        // Student, 38 degrees of freedom: R's qt(0.975, 38).
        assert!((own.limits.unwrap()[1] - value - 2.024_394_164_6 * error).abs() < 1e-6 * error);
    }
    assert!((found.correlation[(0, 1)] + su / (n * suu).sqrt()).abs() < 1e-6, "{}", found.correlation);
}

#[test]
fn bounds_are_kept_and_said() {
    let found = fitted(&request(measured(3), &["stiffness=0.26 N/mm..1 N/mm", "damping"]));
    let stiffness = &found.quantities[0];
    assert!(stiffness.value == 260.0 && stiffness.error.is_none() && stiffness.limits.is_none(), "{stiffness:?}");
    let text = found.report().text(&cotree::model::Units::default());
    assert!(text.contains("at its bound"), "{text}");
    assert!(found.quantities[1].error.is_some() && found.correlation[(0, 1)].is_nan());
}

/// A limit that the search cannot see is no minimum.
#[test]
fn a_search_that_comes_to_where_there_is_no_motion_says_so() {
    let limited = SCENE.replace("[parameters]\n", "[parameters]\ntwice = { value = \"2*stiffness\", min = 520 }\n");
    let mut study = Study::new(&Scene::from_toml(&limited).unwrap()).unwrap();
    let error = fit(std::slice::from_mut(&mut study), &request(measured(3), &["stiffness", "damping"]))
        .unwrap_err()
        .to_string();
    assert!(error.contains("without a minimum") && error.contains("parameter `twice` must be at least 520"), "{error}");
}

fn csv(path: &Path) {
    let table = measured(5);
    let mut text = "block.x [mm];time [ms];block.vx\n".to_owned();
    for (row, time) in table.times().iter().enumerate() {
        text += &format!("{:?};{:?};{:?}\n", 1e3 * table.column(1)[row], 1e3 * time, table.column(0)[row]);
    }
    fs::write(path, text).unwrap();
}

#[test]
fn the_command_reports_draws_and_writes_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    csv(&folder.path().join("measured.csv"));
    let arguments = ["fit", "scene.toml", "--to", "measured.csv", "--vary", "stiffness,damping,block.x"];
    let output = cotree(folder.path(), &[&arguments[..], &["--plot", "fit.svg", "-o", "fitted.toml"]].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    for word in
        ["std. error", "95 % from", "correlation", "residual RMS", "stiffness", "N/m", "ended at a minimum", "95 %"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
    let picture = fs::read_to_string(folder.path().join("fit.svg")).unwrap();
    assert!(picture.matches("<circle").count() > 4 * COUNT && picture.contains("residual of block.x [m]"));
    // Only the values have changed.
    let fitted = fs::read_to_string(folder.path().join("fitted.toml")).unwrap();
    let changed: Vec<(&str, &str)> = SCENE.lines().zip(fitted.lines()).filter(|(old, new)| old != new).collect();
    assert!(changed.len() == 3 && fitted.lines().count() == SCENE.lines().count(), "{changed:?}");
    assert!(changed[0].1.ends_with("N/m\"      # a guess") && changed[1].1.contains("min = 0.0"), "{changed:?}");
    // From there nothing is left to do, and JSON says the same.
    let again = ["fit", "fitted.toml", "--to", "measured.csv", "--vary", "stiffness,damping,block.x", "--json"];
    let output = cotree(folder.path(), &again);
    let json: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    for own in json["quantities"].as_array().unwrap() {
        let [start, value, error] = ["start", "value", "error"].map(|key| own[key].as_f64().unwrap());
        assert!((start - value).abs() < 1e-3 * error, "{own}");
    }
    assert_eq!(json["columns"][0]["residuals"].as_array().unwrap().len(), COUNT);
}

/// Columns may be called as the instrument calls them, with units as it writes them; those that are not chosen are left alone.
#[test]
fn columns_have_other_names_and_units() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    csv(&folder.path().join("measured.csv"));
    let table = measured(5);
    let rows = |line: &dyn Fn(usize, f64) -> String| {
        table.times().iter().enumerate().map(|(row, time)| line(row, *time)).collect::<String>()
    };
    let (places, speeds) = (table.column(1), table.column(0));
    let named = rows(&|row, time| format!("{:?},{:?},{:?},20.5\n", 1e3 * places[row], 1e3 * time, speeds[row]));
    let named = format!("Displacement (mm),Clock (ms),Speed (m/s),Temperature (C)\n{named}");
    fs::write(folder.path().join("named.csv"), named).unwrap();
    let tails = rows(&|row, time| format!("{:?}\t{:?}\t{:?}\n", 1e3 * places[row], 1e3 * time, speeds[row]));
    fs::write(folder.path().join("tails.csv"), format!("block.x_mm\ttime_ms\tblock.vx (m/s)\n{tails}")).unwrap();
    let value = |more: &[&str]| {
        let arguments = ["fit", "scene.toml", "--vary", "stiffness,damping", "--json", "--to"];
        let output = cotree(folder.path(), &[&arguments[..], more].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let json: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
        json["quantities"][0]["value"].as_f64().unwrap()
    };
    let wanted = value(&["measured.csv"]);
    let chosen = ["--column", "block.x=Displacement", "--column", "block.vx=Speed (m/s)", "--column", "time=Clock"];
    assert!((value(&[&["named.csv"][..], &chosen].concat()) / wanted - 1.0).abs() < 1e-9);
    assert!((value(&["tails.csv"]) / wanted - 1.0).abs() < 1e-9);
    let wrong = ["fit", "scene.toml", "--vary", "damping", "--to", "named.csv", "--column", "block.x=Displacment"];
    let output = cotree(folder.path(), &wrong);
    assert!(code(&output) == 2 && stderr(&output).contains("did you mean `Displacement`?"), "{}", stderr(&output));
}

#[test]
fn given_deviations_weigh_the_columns() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    csv(&folder.path().join("measured.csv"));
    let arguments = ["fit", "scene.toml", "--to", "measured.csv", "--vary", "damping,stiffness,block.x", "--json"];
    let error = |sigmas: &[&str]| {
        let sigmas = sigmas.iter().flat_map(|sigma| ["--sigma", sigma]);
        let output = cotree(folder.path(), &arguments.iter().copied().chain(sigmas).collect::<Vec<_>>());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let json: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
        json["quantities"][0]["error"].as_f64().unwrap()
    };
    let given = error(&["block.x=2 mm", "block.vx=0.1"]);
    assert!((error(&[]) / given - 1.0).abs() < 0.2);
    // Twice the errors of what was measured are twice those of what is fitted.
    assert!((error(&["block.x=4 mm", "block.vx=0.2"]) / given - 2.0).abs() < 1e-6);
}

#[test]
fn what_is_wrong_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("scene.toml", SCENE);
    csv(&folder.path().join("measured.csv"));
    write("unknown.csv", "time,blok.x,blok.vx\n0,1,1\n1,2,2\n");
    write("outside.csv", "time,block.x\n-1,0.1\n0,0.1\n1,0.1\n3,0\n4,0\n");
    write("unit.csv", "time,block.x [kg]\n0,0.1\n1,0.1\n1.5,0\n");
    write("one.csv", "time,block.x\n0,0.1\n");
    for (to, vary, more, exit, messages) in [
        ("unknown.csv", "damping", "", 2, &["`unknown.csv` names", "blok.x", "did you mean `block.x`"][..]),
        ("outside.csv", "damping", "", 2, &["3 of 5 times", "-1.0 s"]),
        ("unit.csv", "damping", "", 2, &["`kg`"]),
        ("one.csv", "damping", "", 2, &["1 measured values"]),
        ("measured.csv", "dampng", "", 2, &["did you mean `damping`"]),
        ("measured.csv", "damping,damping", "", 2, &["varied twice"]),
        ("measured.csv", "damping=5..4,stiffness=1..2 m", "", 2, &["is not below", "not in N/m"]),
        ("measured.csv", "damping=5..9", "", 2, &["starts at 4.0"]),
        ("measured.csv", "damping=-1..9", "", 2, &["at least 0.0"]),
        ("measured.csv", "damping=5", "", 2, &["low..high"]),
        ("measured.csv", "stiffness=1 N/mm..2", "", 2, &["`2` has no unit"]),
        ("measured.csv", "stiffness=400..900 N/m", "", 2, &["starts at 300.0 N/m, outside 400.0..900.0 N/m"]),
        ("measured.csv", "damping", "--column=block.x", 2, &["name=column"]),
        ("measured.csv", "damping", "--sigma=block.y=1", 2, &["no column `block.y`"]),
        ("measured.csv", "damping", "--sigma=block.x=0", 2, &["must be positive"]),
        ("measured.csv", "damping,stiffness,idle", "", 3, &["do not determine `idle`"]),
        ("double.csv", "block.x,damping", "--set=stiffness=250", 0, &["double"]),
        ("seen.csv", "offset,double_offset,damping", "", 3, &["`offset`, `double_offset`"]),
        ("measured.csv", "damping", "--plot=x.pdf", 2, &["`.svg`"]),
    ] {
        let scene = SCENE
            .replace("idle      =", "double_offset = 0.0\nidle      =")
            .replace("+ offset", "+ offset + 2*double_offset");
        write("scene.toml", &scene);
        for name in ["double", "seen"] {
            let rows: String = (0..50)
                .map(|row| format!("{:?},{:?}\n", 0.03 * f64::from(row), exact(0.03 * f64::from(row))[0]))
                .collect();
            write(&format!("{name}.csv"), &format!("time,{name}\n{rows}"));
        }
        let mut arguments = vec!["fit", "scene.toml", "--to", to, "--vary", vary];
        arguments.extend(Some(more).filter(|more| !more.is_empty()));
        let output = cotree(folder.path(), &arguments);
        let said = stderr(&output) + &stdout(&output);
        assert!(code(&output) == exit && messages.iter().all(|text| said.contains(text)), "{arguments:?}: {said}");
    }
}

/// A four-bar whose frame is turned by 2.5 rad, far from where its guesses are good: every step of the search begins where the one before has come to.
#[test]
fn lengths_that_move_far_take_their_guesses_along() {
    let scene = |turn: f64, coupler: f64, rocker: f64| {
        format!(
            r#"
name = "turned"
[parameters]
turn = {turn:?}          # of the frame
[ground.points]
a = [0, 0]
b = ["cos(turn)", "sin(turn)"]
[bodies]
crank   = {{ mass = 1, inertia = 0.1, points = {{ a = [0, 0], b = [0.3, 0] }} }}
coupler = {{ mass = 1, inertia = 0.1, points = {{ b = [0, 0], c = [0.9, 0], tip = [0.4, 0.3] }} }}
rocker  = {{ mass = 1, inertia = 0.1, points = {{ d = [0, 0], c = [0.7, 0] }} }}
[joints]
A = {{ type = "revolute", between = ["ground.a", "crank.a"] }}
B = {{ type = "revolute", between = ["crank.b", "coupler.b"] }}
C = {{ type = "revolute", between = ["coupler.c", "rocker.c"] }}
D = {{ type = "revolute", between = ["ground.b", "rocker.d"] }}
[drivers.motor]
joint = "A"
angle = "turn + 0.6 + t"
[initial]
"crank.angle" = {{ guess = "turn + 0.6" }}
"coupler.angle" = {{ guess = {coupler:?} }}
"rocker.angle" = {{ guess = {rocker:?} }}
[outputs]
variables = ["coupler.tip.x", "coupler.tip.y"]
[experiment]
stop = 6.0
step = 0.5
"#
        )
    };
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("truth.toml", &scene(2.5, 3.13, 4.1));
    write("start.toml", &scene(0.0, 0.63, 1.6));
    let run = |arguments: &[&str]| {
        let output = cotree(folder.path(), arguments);
        assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
        stdout(&output)
    };
    run(&["simulate", "truth.toml", "-o", "measured.csv"]);
    let arguments = ["fit", "start.toml", "--to", "measured.csv", "--vary", "turn", "-o", "fitted.toml", "--json"];
    let json: serde_json::Value = serde_json::from_str(&run(&arguments)).unwrap();
    let found = json["quantities"][0]["value"].as_f64().unwrap();
    // A whole turn of the frame is the same frame.
    let turns = (found - 2.5) / TAU;
    assert!((turns - turns.round()).abs() < 1e-7, "{json}");
    let names: Vec<&str> =
        json["guesses"].as_array().unwrap().iter().map(|own| own["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["coupler.angle", "rocker.angle"], "{json}");
    // What is written assembles from its own guesses, and is what was measured.
    run(&["check", "fitted.toml"]);
    run(&["simulate", "fitted.toml", "-o", "fitted.csv"]);
    let rows = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let numbers = |text: &str| -> Vec<f64> { text.split([',', '\n']).filter_map(|cell| cell.parse().ok()).collect() };
    let (truth, fitted) = (numbers(&rows("measured.csv")), numbers(&rows("fitted.csv")));
    assert!(truth.len() == fitted.len() && truth.iter().zip(&fitted).all(|(one, other)| (one - other).abs() < 1e-5));
}

/// What is known when somebody ends the search is kept.
#[test]
fn a_search_that_is_stopped_keeps_the_best_values() {
    let scene = Scene::from_toml(SCENE).unwrap();
    let request = request(measured(3), &["stiffness", "damping"]);
    let mut study = Study::asking(&scene, &Requested::these(request.tables[0].names())).unwrap();
    let (mut best, mut lengths) = (Vec::new(), Vec::new());
    let found = fit_watched(std::slice::from_mut(&mut study), &request, &mut |trial: FitTrial| {
        if trial.is_accepted {
            best = trial.values.to_vec();
        }
        lengths.extend(trial.length);
        lengths.len() < 3
    })
    .unwrap();
    let values: Vec<f64> = found.quantities.iter().map(|own| own.value).collect();
    assert_eq!((found.ended, values), (FitEnded::Stopped, best));
    assert!(lengths.len() == 3 && lengths[2] < lengths[0], "{lengths:?}");
    assert!(found.report().text(&cotree::model::Units::default()).contains("it was stopped"));
}

/// A motion whose work is limited is refused where it is more.
#[test]
fn a_motion_that_costs_more_than_it_may_is_refused() {
    let mut study = Study::new(&Scene::from_toml(SCENE).unwrap()).unwrap();
    let names = ["stiffness".to_owned()];
    study
        .varying(&names, |varying| {
            let whole = varying.along(&[300.0], &[2.0], None, u64::MAX)?;
            let again = varying.along(&[300.0], &[2.0], None, whole.work)?;
            assert_eq!(again.rows, whole.rows);
            let refused = varying.along(&[300.0], &[2.0], None, whole.work / 4).unwrap_err().to_string();
            assert!(refused.contains("they exceed the limit of"), "{refused}");
            Ok(())
        })
        .unwrap();
}

/// A mass of 2 kg that a force over time pushes: where it is seen now and then, and its speed at other times, its mass comes back. Rows without a value count as if they were not there.
#[test]
fn a_driven_mass_is_found_from_values_with_gaps() {
    let scene = "name = \"cart\"\ndimension = 1\n[parameters]\nm = \"3 kg\"\n[inputs]\npush = { start = 0.0, unit = \"N\" }\n[bodies.c]\nmass = \"m\"\n[loads.f]\ntype = \"force\"\non = \"c\"\n\
                 vector = [\"push\"]\n[outputs]\nvariables = [\"c.x\"]\n[experiment]\nstop = 2\ntolerance = 1e-9\n";
    let folder = tempfile::tempdir().unwrap();
    let [path, input, seen] = ["cart.toml", "push.csv", "seen.csv"].map(|name| folder.path().join(name));
    fs::write(&path, scene).unwrap();
    // The force rises until it jumps to zero: x = t^3, and 3 t - 2 from one second on.
    fs::write(&input, "time [ms],push [kN]\n0,0\n1000,0.012\n1000,0\n").unwrap();
    let rows =
        [(0.0, 0.0, 0.0), (0.5, 0.125, 0.75), (0.9, 0.729, 2.43), (1.0, 1.0, 3.0), (1.5, 2.5, 3.0), (2.0, 4.0, 3.0)];
    let row = |(index, (time, x, v)): (usize, &(f64, f64, f64))| match index % 2 {
        0 => format!("{time},{x},\n"),
        _ => format!("{time},,{v}\n"),
    };
    let table: String = rows.iter().enumerate().map(row).collect();
    fs::write(&seen, format!("time,c.x,c.vx\n{table}")).unwrap();
    let run = |options: &[&str]| {
        let arguments = ["fit", path.to_str().unwrap(), "--to", seen.to_str().unwrap(), "--vary", "m", "--input"];
        cotree(folder.path(), &[&arguments[..], &[input.to_str().unwrap()], options].concat())
    };
    let found = run(&["--json"]);
    assert_eq!(code(&found), 0, "{}", stderr(&found));
    let found: serde_json::Value = serde_json::from_str(&stdout(&found)).unwrap();
    let value = found["quantities"][0]["value"].as_f64().unwrap();
    assert!((value - 2.0).abs() < 1e-6, "{value}");
    assert!(found["columns"][0]["residuals"][1].is_null() && !found["columns"][0]["fitted"][1].is_null(), "{found}");
    assert!(stdout(&run(&[])).contains("fitted to 6 measured ones"));
    for (options, told) in
        [(["--set", "push=3"], "given by --set and by the input table"), (["--vary", "push"], "input over time")]
    {
        assert!(stderr(&run(&options)).contains(told), "{}", stderr(&run(&options)));
    }
    fs::write(&input, "time,pull\n0,0\n").unwrap();
    assert!(stderr(&run(&[])).contains("the scene has no input `pull`"));
    fs::write(&input, "time,push [m]\n0,0\n").unwrap();
    assert!(stderr(&run(&[])).contains("but the input in `N`"));
}

/// A mass on a spring, seen alone and with three kilograms more: each vibration tells one quotient only, k / m and k / (m + 3 kg).
const LOADED: &str = r#"
name = "loaded"
dimension = 1
[parameters]
k = "200 N/m"
m = "1.5 kg"
more = "0 kg"
[bodies.block]
mass = "m + more"
[loads.spring]
type = "spring"
between = ["ground", "block"]
stiffness = "k"
length = 0.0
[initial]
"block.x" = "0.1 m"
"block.vx" = 0.0
[outputs]
variables = ["block.x"]
[experiment]
stop = "1 s"
tolerance = 1e-10
"#;

/// Where the block is at these times: stiffness 250 N/m, mass 2 kg and what is added.
fn vibration(start: f64, more: f64, times: &[f64]) -> Vec<f64> {
    times.iter().map(|time| start * ((250.0 / (2.0 + more)).sqrt() * time).cos()).collect()
}

#[test]
fn two_experiments_determine_together_what_neither_does_alone() {
    let scene = Scene::from_toml(LOADED).unwrap();
    let times: Vec<f64> = (1..20).map(|index| 0.05 * f64::from(index)).collect();
    let name = || vec!["block.x".to_owned()];
    let alone = CsvTable::new(name(), times.clone(), vec![vibration(0.1, 0.0, &times)]).unwrap();
    let mut seen = vibration(0.04, 3.0, &times[..15]);
    seen[4] = f64::NAN;
    let loaded = CsvTable::with_gaps(name(), times[..15].to_vec(), vec![seen]).unwrap();
    let study = |settings: &[(&str, f64)]| {
        let mut study = Study::asking(&scene, &Requested::these(name())).unwrap();
        settings.iter().for_each(|(name, value)| study.set(name, |_| Ok(*value)).unwrap());
        study
    };
    let vary = || vec![Vary::read("k").unwrap(), Vary::read("m").unwrap()];
    let requested = |tables: Vec<CsvTable>| FitRequest { tables, vary: vary(), deviations: Vec::new() };
    let set = [("more", 3.0), ("block.x", 0.04)];
    for (table, settings) in [(&alone, &[][..]), (&loaded, &set[..])] {
        let error = fit(&mut [study(settings)], &requested(vec![table.clone()])).unwrap_err().to_string();
        assert!(error.contains("do not determine `k`, `m`"), "{error}");
    }
    let found = fit(&mut [study(&[]), study(&set)], &requested(vec![alone.clone(), loaded.clone()])).unwrap();
    let values: Vec<f64> = found.quantities.iter().map(|own| own.value).collect();
    assert!((values[0] - 250.0).abs() < 1e-4 && (values[1] - 2.0).abs() < 1e-6, "{values:?}");
    let counts: Vec<usize> = found.measured.iter().map(|own| own.columns[0].count()).collect();
    assert_eq!((counts, found.measured[1].times.len()), (vec![19, 14], 15));
    let text = found.report().text(&cotree::model::Units::default());
    assert!(text.contains("fitted to 33 measured ones of 2 experiments") && text.contains("block.x (2)"), "{text}");
    // What is varied cannot be set to different values; the times of each experiment are checked.
    let error =
        fit(&mut [study(&[]), study(&[("m", 3.0)])], &requested(vec![alone.clone(), loaded.clone()])).unwrap_err();
    assert!(error.to_string().contains("experiment 2: `m` is varied, but set to 3.0 kg here"), "{error}");
    let late = CsvTable::new(name(), vec![2.0], vec![vec![0.0]]).unwrap();
    let error = fit(&mut [study(&[]), study(&[])], &requested(vec![alone, late])).unwrap_err().to_string();
    assert!(error.contains("experiment 2: 1 of 1 times"), "{error}");
}

/// The same measured twice has the same minimum, and errors smaller by the root of two.
#[test]
fn an_experiment_that_is_repeated_counts_twice() {
    let scene = Scene::from_toml(SCENE).unwrap();
    let study = || Study::asking(&scene, &Requested::these(measured(3).names())).unwrap();
    let requested = |count: usize| FitRequest {
        tables: vec![measured(3); count],
        deviations: vec![("block.x".to_owned(), "2 mm".to_owned()), ("block.vx".to_owned(), "0.1 m/s".to_owned())],
        ..request(measured(3), &["stiffness", "damping"])
    };
    let [once, twice] = [1, 2].map(|count| fit(&mut vec![study(); count], &requested(count)).unwrap());
    for (one, two) in once.quantities.iter().zip(&twice.quantities) {
        assert!((one.value / two.value - 1.0).abs() < 1e-7, "{one:?} {two:?}");
        let ratio = one.error.unwrap() / two.error.unwrap();
        assert!((ratio - 2.0_f64.sqrt()).abs() < 1e-6, "{ratio}");
    }
}

#[test]
fn the_command_fits_several_tables() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("loaded.toml"), LOADED).unwrap();
    let times: Vec<f64> = (1..20).map(|index| 0.05 * f64::from(index)).collect();
    for (file, start, more) in [("alone.csv", 0.1, 0.0), ("loaded.csv", 0.04, 3.0)] {
        let row = |(time, x): (&f64, f64)| format!("{time},{x}\n");
        let rows: String = times.iter().zip(vibration(start, more, &times)).map(row).collect();
        fs::write(folder.path().join(file), format!("time,block.x\n{rows}")).unwrap();
    }
    let both = ["fit", "loaded.toml", "--to", "alone.csv", "--to", "loaded.csv", "--vary", "k,m"];
    let run = |options: &[&str]| cotree(folder.path(), &[&both[..], options].concat());
    let own = ["--set", "2:more=3 kg", "--set", "2:block.x=40 mm"];
    let found = run(&[&own[..], &["--json", "--plot", "seen.svg"]].concat());
    assert_eq!(code(&found), 0, "{}", stderr(&found));
    let found: serde_json::Value = serde_json::from_str(&stdout(&found)).unwrap();
    let value = |index: usize| found["quantities"][index]["value"].as_f64().unwrap();
    assert!((value(0) - 250.0).abs() < 1e-4 && (value(1) - 2.0).abs() < 1e-6, "{found}");
    assert_eq!(found["experiments"].as_array().map(Vec::len), Some(2));
    assert!(found["experiments"][1]["columns"][0]["residuals"][3].is_number() && found["times"].is_null(), "{found}");
    let picture = fs::read_to_string(folder.path().join("seen.svg")).unwrap();
    assert!(picture.contains("block.x (2) [m]"));
    let told = |options: &[&str]| stderr(&run(options));
    assert!(told(&["--set", "3:more=3"]).contains("there is no experiment 3: --to is given 2 times"));
    assert!(told(&["--input", "alone.csv"]).contains("--input is given 1 time, --to 2 times"));
    assert!(told(&["--set", "2:m=3"]).contains("experiment 2: `m` is varied"));
}
