//! `cotree motion --tolerance`: what deviations do to a scene, against closed forms, differences of runs, and the synthesis, which has formulas of its own.

use crate::outside::command;

use std::fs;
use std::path::Path;

use command::{code, cotree, stderr, stdout};
use serde_json::Value;

/// A slider-crank in line: s = r cos(phi) + sqrt(l^2 - r^2 sin(phi)^2).
const SLIDER_CRANK: &str = r#"
name = "slider_crank"
parameters.rod_length = { value = "150 mm" }
ground.points = { o = [0, 0] }
[bodies]
crank  = { points = { o = [0, 0], a = ["50 mm", 0] } }
rod    = { points = { a = [0, 0], b = ["rod_length", 0] } }
slider = { }
[joints]
shaft = { type = "revolute", between = ["ground.o", "crank.o"] }
A     = { type = "revolute", between = ["crank.a", "rod.a"] }
B     = { type = "revolute", between = ["rod.b", "slider"] }
guide = { type = "prismatic", between = ["ground", "slider"], axis = [1, 0] }
[initial]
"crank.angle" = "0 deg"
"rod.angle"   = { guess = 0 }
"#;

const FOUR_BAR: &str = r#"
name = "four_bar"
parameters.coupler_length = { value = "120 mm" }
ground.points = { a = [0, 0], d = ["100 mm", 0] }
[bodies]
crank   = { points = { o = [0, 0], a = ["40 mm", 0] } }
coupler = { points = { a = [0, 0], b = ["coupler_length", 0], p = ["60 mm", "50 mm"] } }
rocker  = { points = { o = [0, 0], b = ["80 mm", 0] } }
[joints]
shaft = { type = "revolute", between = ["ground.a", "crank.o"] }
A     = { type = "revolute", between = ["crank.a", "coupler.a"] }
B     = { type = "revolute", between = ["coupler.b", "rocker.b"] }
D     = { type = "revolute", between = ["ground.d", "rocker.o"] }
[initial]
"crank.angle"   = "60 deg"
"coupler.angle" = { guess = 0.32 }
"rocker.angle"  = { guess = 1.13 }
"#;

fn told(folder: &Path, text: &str, arguments: &[&str]) -> Value {
    fs::write(folder.join("scene.toml"), text).unwrap();
    let run = cotree(folder, &[&["motion", "scene.toml", "--json"], arguments].concat());
    assert_eq!(code(&run), 0, "{}", stderr(&run));
    serde_json::from_str(&stdout(&run)).unwrap()
}

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap_or_else(|| panic!("{key} of {of}"))
}

fn contribution(of: &Value, name: &str) -> f64 {
    let all = of["contributions"].as_array().unwrap();
    number(all.iter().find(|own| own["dimension"] == name).unwrap_or_else(|| panic!("{name} in {of}")), "error")
}

/// Each length by its closed form: ds/dr = cos - r sin^2/w, ds/dl = l/w, and the pivot beside the line of the guide: ds/dy = r sin/w where w = sqrt(l^2 - r^2 sin^2).
#[test]
fn a_slider_crank_deviates_as_its_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let arguments =
        ["--input", "shaft", "--output", "guide", "--tolerance", "length=0.1mm", "--tolerance", "pivot=0.05mm"];
    let own = told(folder.path(), SLIDER_CRANK, &arguments)["tolerances"][0].clone();
    let (r, l) = (0.05f64, 0.15f64);
    let slopes = |phi: f64| {
        let w = (l * l - (r * phi.sin()).powi(2)).sqrt();
        [phi.cos() - r * phi.sin().powi(2) / w, l / w, 1.0, r * phi.sin() / w]
    };
    let each = [1e-4, 1e-4, 5e-5, 5e-5];
    let all = || (0..72).map(|k| slopes(f64::from(k) * std::f64::consts::TAU / 72.0));
    let most = |of: &dyn Fn([f64; 4]) -> f64| all().map(of).fold(0.0, f64::max);
    let names = ["crank.o to crank.a", "rod.a to rod.b", "ground.o x", "ground.o y"];
    for (index, name) in names.into_iter().enumerate() {
        let known = most(&|slopes| (slopes[index] * each[index]).abs());
        assert!((contribution(&own, name) - known).abs() < 1e-9 * known, "{name}: {known} in {own}");
    }
    let worst = most(&|slopes| (0..4).map(|i| (slopes[i] * each[i]).abs()).sum());
    let sigma = most(&|slopes| (0..4).map(|i| (slopes[i] * each[i]).powi(2)).sum::<f64>().sqrt());
    assert!((number(&own, "worst") - worst).abs() < 1e-9 * worst, "{worst} in {own}");
    assert!((number(&own, "three_sigma") - sigma).abs() < 1e-9 * sigma, "{sigma} in {own}");
    // The largest error of the whole turn lies a little above that of its worst position.
    let sampled = number(&own, "sampled") / sigma;
    assert!((0.9..1.25).contains(&sampled) && number(&own, "jammed") == 0.0, "{own}");
}

/// The same dimension as a parameter of the scene and as a length, and both against differences of runs with other values.
#[test]
fn a_parameter_deviates_as_differences_of_runs() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--input", "shaft", "--output", "D", "--point", "coupler.p"];
    let with = |more: &[&str]| told(folder.path(), FOUR_BAR, &[&arguments[..], more].concat());
    let own = with(&["--tolerance", "coupler_length=0.2mm", "--tolerance", "length=0.2mm"])["tolerances"].clone();
    let name = |index: usize| own[index]["of"].as_str().unwrap().to_owned();
    assert_eq!([name(0), name(1)], ["D", "coupler.p across its path"]);
    let [one, other] = ["coupler_length", "coupler.a to coupler.b"].map(|name| contribution(&own[0], name));
    assert!((one - other).abs() < 1e-9 * one, "{one} {other}");
    let values = |length: &str| {
        let figures = with(&["--set", &format!("coupler_length={length}")]);
        let column = figures["table"].as_array().unwrap().iter().find(|column| column["name"] == "D").unwrap();
        let values: Vec<f64> = column["values"].as_array().unwrap().iter().map(|own| own.as_f64().unwrap()).collect();
        values
    };
    let pairs = values("120.001 mm").into_iter().zip(values("119.999 mm"));
    // One sample in ten of a turn is looked at.
    let most = pairs.step_by(10).map(|(more, less)| 0.5 * (more - less).abs() / 1e-6 * 2e-4).fold(0.0, f64::max);
    assert!((one - most).abs() < 1e-6 * most, "{one} {most}");
}

/// An answer of the synthesis as a scene: the program's derivatives are those of the formulas of the synthesis.
#[test]
fn an_answer_of_the_synthesis_deviates_alike_as_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    // A point at each position that the motion looks at: 72 steps of the crank.
    let crank: Vec<String> = (0..=12).map(|k| format!("\"{} deg\"", 5 * k)).collect();
    let [a, b, c, d] = [0.04f64, 0.12, 0.08, 0.1];
    let place = |k: i32| {
        let pin = cotree_synthesis::polar(a, (40.0 + 5.0 * f64::from(k)).to_radians());
        let way = cotree_synthesis::Point::new(d, 0.0) - pin;
        let angle = ((b * b + way.norm_sqr() - c * c) / (2.0 * b * way.norm())).acos();
        pin + way / way.norm() * cotree_synthesis::polar(1.0, angle) * cotree_synthesis::Point::new(0.06, 0.05)
    };
    let points: Vec<String> = (0..=12).map(place).map(|own| format!("[{:?}, {:?}]", own.re, own.im)).collect();
    let task = format!("name = \"known\"\n[path]\npoints = [{}]\ncrank = [{}]\n", points.join(", "), crank.join(", "));
    fs::write(folder.path().join("task.toml"), task).unwrap();
    let deviations = ["--tolerance", "length=0.1mm", "--tolerance", "pivot=0.05mm"];
    let run = cotree(folder.path(), &[&["synthesize", "task.toml", "-o", "out", "--json"], &deviations[..]].concat());
    assert_eq!(code(&run), 0, "{}", stderr(&run));
    let answer: Value = serde_json::from_str(&stdout(&run)).unwrap();
    let known = &answer["tolerances"][0];
    let scene = fs::read_to_string(folder.path().join("out/1.toml")).unwrap();
    let start = scene.lines().find_map(|line| line.strip_prefix("angle = \"")).unwrap();
    let start: f64 = start.split(' ').next().unwrap().parse().unwrap();
    let sign = if scene.contains("(-1.0)*t") { -1.0 } else { 1.0 };
    let range = format!("{start:?} rad..{:?} rad", start + sign * 60f64.to_radians());
    let arguments =
        ["--input", "first_pivot", "--output", "second_pivot", "--point", "coupler.origin", "--range", &range];
    let own = told(folder.path(), &scene, &[&arguments[..], &deviations[..]].concat())["tolerances"].clone();
    let output = &own[0];
    let path = &own[1];
    // With the turns of the crank given the synthesis counts the whole distance: what is across the path is at most that.
    assert!(number(path, "worst") <= number(known, "worst") * (1.0 + 1e-9), "{path} {known}");
    assert!(number(output, "worst") > 0.0 && number(path, "worst") > 0.3 * number(known, "worst"), "{own} {known}");
    let sums = |of: &Value| {
        let all = of["contributions"].as_array().unwrap();
        all.iter().map(|own| number(own, "error")).sum::<f64>()
    };
    assert!(sums(path) <= sums(known) * (1.0 + 1e-9), "{path} {known}");
}

/// Without the turns of the crank both count what is across the path, at the same positions: alike to rounding.
#[test]
fn what_is_across_a_path_is_counted_alike() {
    let folder = tempfile::tempdir().unwrap();
    let points: Vec<String> = (0..=12).map(|k| format!("[\"{} mm\", 0]", 25 * k)).collect();
    let limits = "length = [\"20 mm\", \"1 m\"]\ntransmission = \"40 deg\"";
    let task = format!("name = \"line\"\n[path]\npoints = [{}]\n[limits]\n{limits}\n", points.join(", "));
    fs::write(folder.path().join("task.toml"), task).unwrap();
    let deviations = ["--tolerance", "length=0.1mm", "--tolerance", "pivot=0.05mm"];
    let run = cotree(folder.path(), &[&["synthesize", "task.toml", "-o", "out", "--json"], &deviations[..]].concat());
    assert_eq!(code(&run), 0, "{}", stderr(&run));
    let answer: Value = serde_json::from_str(&stdout(&run)).unwrap();
    let known = &answer["tolerances"][0];
    let scene = fs::read_to_string(folder.path().join("out").join(known["scene"].as_str().unwrap())).unwrap();
    let start = scene.lines().find_map(|line| line.strip_prefix("angle = \"")).unwrap();
    let start: f64 = start.split(' ').next().unwrap().parse().unwrap();
    let stop = scene.lines().find_map(|line| line.strip_prefix("stop = ")).unwrap().parse::<f64>().unwrap();
    let sign = if scene.contains("(-1.0)*t") { -1.0 } else { 1.0 };
    let range = format!("{start:?} rad..{:?} rad", start + sign * stop);
    let arguments = ["--input", "first_pivot", "--point", "coupler.origin", "--range", &range];
    let own = told(folder.path(), &scene, &[&arguments[..], &deviations[..]].concat())["tolerances"][1].clone();
    // The largest ones lie at the ends, which both look at, or between the points.
    for key in ["worst", "three_sigma"] {
        let [own, known] = [number(&own, key), number(known, key)];
        assert!(own >= known * (1.0 - 1e-9) && own < 1.02 * known, "{key}: {own} {known}");
    }
    let [sampled, other] = [number(&own, "sampled"), number(known, "sampled")];
    assert!((sampled / other - 1.0).abs() < 0.2, "{sampled} {other}");
}

/// What has no deviation, or none that is known, is refused by its name.
#[test]
fn what_cannot_deviate_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str, arguments: &[&str]| {
        fs::write(folder.path().join("scene.toml"), text).unwrap();
        let run = cotree(folder.path(), &[&["motion", "scene.toml", "--input", "shaft"], arguments].concat());
        assert_ne!(code(&run), 0, "{arguments:?}: {}", stdout(&run));
        stderr(&run)
    };
    let four_bar = |arguments: &[&str]| refused(FOUR_BAR, arguments);
    assert!(four_bar(&["--tolerance", "coupler_lenght=1mm"]).contains("`coupler_length`"));
    assert!(four_bar(&["--tolerance", "length=-1mm"]).contains("must be positive"));
    assert!(four_bar(&["--tolerance", "length=1kg"]).contains("not in m"));
    assert!(four_bar(&["--tolerance", "length"]).contains("length=0.1mm"));
    let triple = FOUR_BAR.replace("40 mm", "75 mm").replace("100 mm", "130 mm");
    let message = refused(&triple, &["--tolerance", "length=0.1mm"]);
    assert!(message.contains("dead point") && message.contains("--range"), "{message}");
    let named = FOUR_BAR.replace("coupler_length", "length");
    assert!(refused(&named, &["--tolerance", "length=0.1mm"]).contains("also a parameter"));
}
