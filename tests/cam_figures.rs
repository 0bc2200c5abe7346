//! What `cotree motion` says of cams, against closed forms and the tables of the literature.

use crate::outside::command;

use std::f64::consts::{PI, TAU};

use serde_json::Value;

use command::{code, cotree, stderr, stdout};

/// What `cotree motion --json` says of a scene.
fn figures(scene: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cam.toml"), scene).unwrap();
    let output = cotree(folder.path(), &["motion", "cam.toml", "--input", "shaft", "--json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

/// What it says of its cam.
fn motion(scene: &str) -> Value {
    figures(scene)["cams"][0].clone()
}

/// A cam of a text book.
fn book(offset: f64, follower: &str, law: &str) -> String {
    format!(
        r#"
name = "book"
ground.points = {{ shaft = [0, 0], guide = [{offset}, 0], pivot = [0.08, 0] }}
[bodies]
cam = {{ points = {{ hub = [0, 0] }} }}
follower = {{ points = {{ tip = [0, 0] }} }}
[joints]
shaft = {{ type = "revolute", between = ["ground.shaft", "cam.hub"] }}
guide = {{ type = "prismatic", between = ["ground.guide", "follower.tip"], axis = [0, 1] }}
contact = {{ type = "cam", between = ["cam", "follower.tip"], shaft = "shaft", guide = "guide", {follower}, law = "{law}" }}
[drivers.motor]
joint = "shaft"
angle = "t"
[outputs]
variables = ["contact.pressure_angle", "contact.curvature"]
"#
    )
}

fn near(found: &Value, expected: f64, limit: f64) {
    let found = found.as_f64().unwrap_or(f64::NAN);
    assert!((found - expected).abs() <= limit, "{found} is not {expected}");
}

/// Rise of 20 mm in 90 degrees, a long return: numbers found from closed forms at 40 digits.
#[test]
fn the_figures_of_sliding_followers_are_those_of_closed_forms() {
    let law = "0.02*(cycloidal(angle*2/pi) - cycloidal((angle - 1.8)/4.4))";
    let radial = motion(&book(0.0, "base = 0.03, roller = 0.01", law));
    near(&radial["pressure_angle"]["value"], 27.374_329_10_f64.to_radians(), 1e-9);
    near(&radial["pressure_angle"]["input"], 41.3122_f64.to_radians(), 2e-6);
    near(&radial["pitch_radius"]["value"], 0.031_610_820_40, 1e-11);
    near(&radial["pitch_radius"]["input"], 66.2020_f64.to_radians(), 2e-6);
    near(&radial["convex_radius"]["value"], 0.021_610_820_40, 1e-11);
    let beside = motion(&book(0.008, "base = 0.03, roller = 0.01", law));
    near(&beside["pressure_angle"]["value"], 19.758_164_93_f64.to_radians(), 1e-9);
    near(&beside["pitch_radius"]["value"], 0.030_065_548_72, 1e-11);
    let flat = motion(&book(0.0, "base = 0.03, face = [1, 0]", law));
    assert_eq!(flat["undercut"], true);
    near(&flat["least_base"], 0.032_852_625_57, 1e-10);
    near(&flat["face"][1]["value"], 0.025_464_790_89, 1e-10);
    let enough = motion(&book(0.0, "base = 0.0328527, face = [1, 0]", law));
    assert_eq!(enough["undercut"], false);
    assert_eq!(enough["least_base"], Value::Null);
}

/// The flat follower about a pivot at 80 mm that the literature's formula describes: 15 degrees in 100, from 18.
#[test]
fn the_figures_of_a_turning_flat_follower_are_those_of_closed_forms() {
    // sin 18 = (base - 5 mm)/80 mm.
    let base = 0.005 + 0.08 * 18_f64.to_radians().sin();
    let rise = 15_f64.to_radians();
    let law = format!("{rise}*(poly345(angle/{}) - poly345((angle - 2)/4.2))", 100_f64.to_radians());
    let scene = book(0.0, &format!("base = {base}, face = [1, 0]"), &law)
        .replace(
            "type = \"prismatic\", between = [\"ground.guide\", \"follower.tip\"], axis = [0, 1]",
            "type = \"revolute\", between = [\"ground.pivot\", \"follower.pivot\"]",
        )
        .replace("tip = [0, 0]", "tip = [0, 0], pivot = [0, -0.005]");
    let figures = motion(&scene);
    near(&figures["convex_radius"]["value"], 0.022_555_373_06, 1e-10);
    near(&figures["convex_radius"]["input"], 82.8602_f64.to_radians(), 2e-6);
    near(&figures["pressure_angle"]["value"].as_f64().map(f64::abs).into(), 5.112_260_283_f64.to_radians(), 1e-10);
    // From the pivot's foot on the face to the left, which is back along it.
    let ends = [0, 1].map(|end| figures["face"][end]["value"].as_f64().unwrap().abs());
    assert!((ends[0].min(ends[1]) - 0.055_888_831_09).abs() < 1e-10, "{ends:?}");
    let points = {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("cam.toml"), &scene).unwrap();
        stdout(&cotree(folder.path(), &["trace", "cam.toml", "contact"]))
    };
    // At 30 degrees, three tenths of the rise.
    let row: Vec<f64> = points.lines().nth(61).unwrap().split(',').map(|number| number.parse().unwrap()).collect();
    assert!((row[0] - 30_f64.to_radians()).abs() < 1e-12);
    assert!((row[1] - 0.033_306_764_81).abs() < 1e-11 && (row[2] - 0.011_409_820_76).abs() < 1e-11, "{row:?}");
}

/// Peak coefficients of velocity, acceleration and jerk of the laws in h/beta, h/beta^2, h/beta^3 (Norton; VDI 2143).
#[test]
#[allow(clippy::approx_constant, reason = "figures of published tables")]
fn laws_have_the_peaks_of_the_literature() {
    let known = [
        ("harmonic", [0.5 * PI, 4.934_802, 15.503_139]),
        ("cycloidal", [2.0, TAU, 39.478_418]),
        ("poly345", [1.875, 5.773_503, 60.0]),
        ("poly4567", [2.1875, 7.513_188, 52.5]),
        ("modified_trapezoid", [2.0, 4.888_124, 61.425_975]),
        ("modified_sine", [1.759_603, 5.527_957, 69.466_357]),
    ];
    for (law, peaks) in known {
        let both = format!("0.02*({law}(angle/1.5) - {law}((angle - 2.5)/2))");
        let figures = motion(&book(0.0, "base = 0.2, roller = 0.01", &both));
        let phases = figures["phases"].as_array().unwrap();
        assert_eq!(phases.len(), 2, "{law}: {phases:?}");
        for (phase, [from, to, rise]) in phases.iter().zip([[0.0, 1.5, 0.02], [2.5, 4.5, -0.02]]) {
            near(&phase["from"], from, 1e-6);
            near(&phase["to"], to, 1e-6);
            near(&phase["rise"], rise, 1e-12);
            for (found, expected) in phase["peaks"].as_array().unwrap().iter().zip(peaks) {
                near(found, expected, 2e-6 * f64::max(1.0, expected / 10.0));
            }
        }
    }
}

/// A quarter of a degree up, and as fast down: radius = base + s + s'' of a flat follower that slides.
#[test]
fn short_rises_are_not_passed_over() {
    let [from, beta, rise] = [1.7368_f64, 0.004, 1e-7];
    let law = format!("{rise}*(poly345((angle - {from})/{beta}) - poly345((angle - {})/{beta}))", from + beta);
    let all = figures(&book(0.0, "base = 0.03, face = [1, 0]", &law));
    near(&all["stroke"], rise, 1e-3 * rise);
    let cam = &all["cams"][0];
    assert_eq!(cam["undercut"], true);
    // The largest deceleration of the law is at (3 + sqrt(3))/6 of the rise.
    let c = (3.0 + 3f64.sqrt()) / 6.0;
    let least = 10.0 / 3f64.sqrt() * rise / beta.powi(2) - rise * c.powi(3) * (10.0 - 15.0 * c + 6.0 * c * c);
    near(&cam["least_base"], least, 1e-9);
    let phases = cam["phases"].as_array().unwrap();
    assert!(phases.len() == 2 && (phases[0]["rise"].as_f64().unwrap() - rise).abs() < 1e-12, "{phases:?}");
    let high = book(0.0, "base = 0.05, roller = 0.01", &law);
    // A roller that slides radially: the pitch curve in polar coordinates.
    let [r, bend] =
        [0.06 + rise * c.powi(3) * (10.0 - 15.0 * c + 6.0 * c * c), -10.0 / 3f64.sqrt() * rise / beta.powi(2)];
    let slope = 30.0 * rise / beta * (c * (1.0 - c)).powi(2);
    let tightest = (r * r + slope * slope).powf(1.5) / (r * r + 2.0 * slope * slope - r * bend);
    near(&motion(&high)["pitch_radius"]["value"], tightest, 1e-7);
}

/// Beyond 85 mm no base circle reaches the face.
#[test]
fn a_base_circle_out_of_reach_is_no_help() {
    let law = "0.3*(poly345(angle/0.2) - poly345((angle - 2)/4.2))";
    let scene = book(0.0, "base = 0.03, face = [1, 0]", law)
        .replace(
            "type = \"prismatic\", between = [\"ground.guide\", \"follower.tip\"], axis = [0, 1]",
            "type = \"revolute\", between = [\"ground.pivot\", \"follower.pivot\"]",
        )
        .replace("tip = [0, 0]", "tip = [0, 0], pivot = [0, -0.005]");
    let cam = motion(&scene);
    assert_eq!(cam["undercut"], true);
    assert_eq!(cam["least_base"], Value::Null);
}
