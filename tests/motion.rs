//! `cotree motion` against five mechanisms whose numbers were found in another way: by Newton's method in absolute coordinates with Lagrange
//! multipliers, at a pose again from positions in closed form at 40 digits, and by free-body balances.

use crate::outside::command;

use std::path::Path;

use serde_json::Value;

use command::{code, cotree, stderr, stdout};

const CRANK_ROCKER: &str = r#"
name = "crank_rocker"
ground.points = { O2 = [0, 0], O4 = ["100 mm", 0] }
[bodies]
crank   = { mass = 0.3, inertia = 8e-5, com = ["10 mm", 0], points = { o = [0, 0], a = ["40 mm", 0] } }
coupler = { mass = 0.6, inertia = 1.2e-3, com = ["60 mm", "20 mm"], points = { a = [0, 0], b = ["120 mm", 0], p = ["60 mm", "50 mm"], n = ["60 mm", "-50 mm"], k = ["755.926824431 mm", "671.709272844 mm"] } }
rocker  = { mass = 0.5, inertia = 4e-4, com = ["35 mm", 0], points = { o = [0, 0], b = ["80 mm", 0] } }
[joints]
O2 = { type = "revolute", between = ["ground.O2", "crank.o"] }
A  = { type = "revolute", between = ["crank.a", "coupler.a"] }
B  = { type = "revolute", between = ["coupler.b", "rocker.b"] }
O4 = { type = "revolute", between = ["ground.O4", "rocker.o"] }
[initial]
"crank.angle"   = "60 deg"
"coupler.angle" = { guess = 0.32 }
"rocker.angle"  = { guess = 1.13 }
"#;

const SLIDER_CRANK: &str = r#"
name = "slider_crank"
ground.points = { O2 = [0, 0], line = [0, "20 mm"] }
[bodies]
crank  = { mass = 1, inertia = 1e-3, com = ["10 mm", 0], points = { o = [0, 0], a = ["50 mm", 0] } }
rod    = { mass = 0.8, inertia = 2.5e-3, com = ["50 mm", 0], points = { a = [0, 0], b = ["150 mm", 0] } }
slider = { mass = 1.2 }
[joints]
O2    = { type = "revolute", between = ["ground.O2", "crank.o"] }
A     = { type = "revolute", between = ["crank.a", "rod.a"] }
B     = { type = "revolute", between = ["rod.b", "slider"] }
guide = { type = "prismatic", between = ["ground.line", "slider"], axis = [1, 0] }
[initial]
"crank.angle" = "50 deg"
"rod.angle"   = { guess = -0.12 }
"#;

const WHITWORTH: &str = r#"
name = "whitworth"
ground.points = { O4 = [0, 0], O2 = [0, "-30 mm"] }
[bodies]
crank = { mass = 0.5, inertia = 1e-3, com = ["30 mm", 0], points = { o = [0, 0], p = ["75 mm", 0] } }
block = { mass = 0.1, inertia = 2e-5 }
arm   = { mass = 1.2, inertia = 2e-3, com = ["20 mm", 0], points = { o = [0, 0], e = ["60 mm", 0] } }
rod   = { mass = 0.4, inertia = 1.4e-3, com = ["100 mm", 0], points = { e = [0, 0], r = ["200 mm", 0] } }
ram   = { mass = 2 }
[joints]
O2    = { type = "revolute", between = ["ground.O2", "crank.o"] }
pin   = { type = "revolute", between = ["crank.p", "block"] }
slide = { type = "prismatic", between = ["arm.o", "block"], axis = [1, 0] }
O4    = { type = "revolute", between = ["ground.O4", "arm.o"] }
E     = { type = "revolute", between = ["arm.e", "rod.e"] }
R     = { type = "revolute", between = ["rod.r", "ram"] }
guide = { type = "prismatic", between = ["ground", "ram"], axis = [1, 0] }
[initial]
"crank.angle" = "40 deg"
"arm.angle"   = { guess = 0.3 }
"rod.angle"   = { guess = 0 }
"ram.x"       = { guess = 0.25 }
"#;

const PRESS: &str = r#"
name = "press"
ground.points = { O2 = ["-170 mm", "-200 mm"], O4 = [0, 0] }
[bodies]
crank = { mass = 0.5, inertia = 2e-4, points = { o = [0, 0], a = ["30 mm", 0] } }
link  = { mass = 0.6, inertia = 1.2e-3, com = ["75 mm", 0], points = { a = [0, 0], k = ["150 mm", 0] } }
upper = { mass = 0.9, inertia = 3.2e-3, com = ["100 mm", 0], points = { o = [0, 0], k = ["200 mm", 0] } }
lower = { mass = 1.1, inertia = 6e-3, com = ["125 mm", 0], points = { k = [0, 0], r = ["250 mm", 0] } }
ram   = { mass = 8 }
[joints]
O2    = { type = "revolute", between = ["ground.O2", "crank.o"] }
A     = { type = "revolute", between = ["crank.a", "link.a"] }
K1    = { type = "revolute", between = ["link.k", "upper.k"] }
O4    = { type = "revolute", between = ["ground.O4", "upper.o"] }
K2    = { type = "revolute", between = ["upper.k", "lower.k"] }
R     = { type = "revolute", between = ["lower.r", "ram"] }
guide = { type = "prismatic", between = ["ground", "ram"], axis = [0, 1] }
[initial]
"crank.angle" = "100 deg"
"link.angle"  = { guess = 0.1 }
"upper.angle" = { guess = "-100 deg" }
"lower.angle" = { guess = "-80 deg" }
"ram.y"       = { guess = -0.446 }
"#;

fn motion(scene: &str, more: &[&str]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), scene).unwrap();
    let input: &[&str] = if more.contains(&"--input") { &[] } else { &["--input", "O2"] };
    let output = cotree(folder.path(), &[&["motion", "a.toml", "--json"], input, more].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {path}"))
}

/// Values at paths, to eight digits.
fn check(figures: &Value, wanted: &[(&str, f64)]) {
    check_to(1e-8, figures, wanted);
}

fn check_to(tolerance: f64, figures: &Value, wanted: &[(&str, f64)]) {
    for (path, value) in wanted {
        let found = number(figures, path);
        assert!((found - value).abs() < tolerance * (1e-3 + value.abs()), "{path}: {found}, not {value}");
    }
}

/// A column of the table at an angle of the crank [deg].
fn at(figures: &Value, column: &str, degrees: usize) -> f64 {
    let columns = figures["table"].as_array().unwrap();
    let found = columns.iter().find(|own| own["name"] == column);
    let found = found
        .unwrap_or_else(|| panic!("no {column} in {:?}", columns.iter().map(|own| &own["name"]).collect::<Vec<_>>()));
    found["values"][2 * degrees].as_f64().unwrap()
}

fn joint<'f>(figures: &'f Value, name: &str) -> &'f Value {
    figures["joints"].as_array().unwrap().iter().find(|joint| joint["joint"] == name).unwrap()
}

fn near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-8 * (1e-3 + wanted.abs()), "{found}, not {wanted}");
}

const DEG: f64 = std::f64::consts::PI / 180.0;

#[test]
fn the_crank_rocker() {
    let figures = motion(CRANK_ROCKER, &["--output", "O4", "--speed", "20 rad/s", "--point", "coupler.p"]);
    assert!(figures["four_bar"].as_str().unwrap().starts_with("crank-rocker"));
    assert_eq!(figures["full_turn"], true);
    check(
        &figures,
        &[
            ("/limits/0/input", 24.146848 * DEG),
            ("/limits/0/value", 54.9003678 * DEG),
            ("/limits/1/input", 231.3178125 * DEG),
            ("/limits/1/value", 128.6821875 * DEG),
            ("/stroke", 73.78181965 * DEG),
            ("/time_ratio", 1.355573330),
            ("/transmission/0/min/value", 26.38432975 * DEG),
            ("/transmission/0/max/value", 86.41667830 * DEG),
            ("/joint_force_index/value", 28.12843386),
            ("/drive/max/value", 0.7714716509),
            ("/drive/min/value", -1.322299642),
            ("/drive/rms", 0.4019258918),
            ("/power/min/value", -26.44599284),
            ("/power/max/value", 15.42943302),
            ("/inertia/max/value", 3.575934385e-3),
            ("/inertia/min/value", 4.912461999e-4),
            ("/fluctuation/free", 0.9183400920),
            ("/shaking_force/max/value", 35.09489424),
            ("/shaking_force/rms", 15.63759878),
            ("/shaking_moment/max/value", 1.514380240),
            ("/shaking_moment/min/value", -3.191240115),
            ("/path/length", 0.2588948063),
            ("/path/area", 3.997331781e-3),
            ("/path/radius/120", 34.57686861e-3),
            ("/path/x/120", 61.17789112e-3),
            ("/path/y/120", 101.0065289e-3),
        ],
    );
    for (column, value) in [
        ("O4", 1.133477573),
        ("O4'", 0.4573488370),
        ("O4''", 0.3198967285),
        ("advantage", 2.186514798),
        ("transmission at B", 46.56746344 * DEG),
        ("inertia", 1.177035398e-3),
        ("drive", 0.2027745407),
        ("shaking fx", 10.49388136),
        ("shaking fy", 6.503409352),
        ("shaking moment", -0.3860855329),
        ("|O2|", 10.66668843f64.hypot(8.336519275)),
        ("|B|", 2.821442921f64.hypot(2.211131837)),
    ] {
        near(at(&figures, column, 60), value);
    }
    check(joint(&figures, "O2"), &[("/max/value", 63.56645148), ("/rms", 22.33319590)]);
    check(joint(&figures, "B"), &[("/max/value", 46.96669452), ("/rms", 14.74239918)]);
    let coupler = figures["instant_centres"].as_array().unwrap().iter().find(|body| body["body"] == "coupler").unwrap();
    check(coupler, &[("/at/120/0", 0.5256230590), ("/at/120/1", 0.9104058438)]);
    let pairs = figures["relative_centres"].as_array().unwrap();
    let rocker = pairs.iter().find(|pair| pair["bodies"] == serde_json::json!(["crank", "rocker"])).unwrap();
    check(rocker, &[("/at/120/0", -84.28044905e-3)]);
    assert!(number(rocker, "/at/120/1").abs() < 1e-12);
    assert_eq!(figures["path"]["crunodes"].as_array().unwrap().len(), 0);
}

#[test]
fn coupler_curves_have_cusps_and_crossings() {
    let crossing = motion(CRANK_ROCKER, &["--point", "coupler.n"]);
    check(
        &crossing,
        &[
            ("/path/crunodes/0/x", 0.1003271997),
            ("/path/crunodes/0/y", 2.011196833e-3),
            ("/path/crunodes/0/inputs/0", 47.21761892 * DEG),
            ("/path/crunodes/0/inputs/1", 315.0792190 * DEG),
        ],
    );
    let cusp = motion(CRANK_ROCKER, &["--point", "coupler.k"]);
    check_to(1e-5, &cusp, &[("/path/cusps/0", 60.0 * DEG)]);
}

#[test]
fn the_offset_slider_crank() {
    let figures = motion(SLIDER_CRANK, &["--speed", "60 rad/s"]);
    check(
        &figures,
        &[
            ("/limits/0/input", 5.739170477 * DEG),
            ("/limits/0/value", 0.1989974874),
            ("/limits/1/input", 191.5369590 * DEG),
            ("/limits/1/value", 0.09797958971),
            ("/stroke", 0.1010178977),
            ("/time_ratio", 1.066563892),
            ("/transmission/0/min/value", (90.0 - 27.81813928) * DEG),
            ("/drive/max/value", 8.771336396),
            ("/drive/min/value", -10.41547384),
            ("/drive/rms", 5.675431841),
            ("/inertia/max/value", 6.938041000e-3),
            ("/inertia/min/value", 2.266387577e-3),
            ("/shaking_force/max/value", 486.7929030),
            ("/shaking_moment/max/value", 4.509475619),
            ("/shaking_moment/min/value", -7.061208608),
        ],
    );
    for (column, value) in [
        ("guide", 0.1810186224),
        ("guide'", -42.25322348e-3),
        ("guide''", -34.47371807e-3),
        ("transmission at B", (90.0 - 7.008397542) * DEG),
        ("drive", 7.984212582),
        ("shaking fx", 266.8691959),
        ("shaking moment", -2.282100893),
    ] {
        near(at(&figures, column, 50), value);
    }
    check(joint(&figures, "O2"), &[("/max/value", 489.0552471), ("/rms", 309.4078485)]);
    check(joint(&figures, "B"), &[("/max/value", 293.7724325), ("/rms", 170.2035159)]);
}

/// A value of `[initial]` that is set chooses the assembly: the slider stands left of the crank's pin, where the rod points back.
#[test]
fn what_is_set_at_the_start_chooses_the_assembly() {
    let range = ["--range", "50 deg..90 deg"];
    let place = |figures: &Value| at(figures, "guide", 0);
    let (pin, rod) = ([0.05 * (50.0 * DEG).cos(), 0.05 * (50.0 * DEG).sin()], 0.15);
    let way = (rod * rod - (0.02 - pin[1]) * (0.02 - pin[1])).sqrt();
    near(place(&motion(SLIDER_CRANK, &range)), pin[0] + way);
    near(place(&motion(SLIDER_CRANK, &[&range[..], &["--set", "rod.angle=185 deg"]].concat())), pin[0] - way);
}

#[test]
fn a_flywheel_for_a_load_on_one_stroke() {
    let load = "[loads.cut]\ntype = \"force\"\non = \"slider\"\nvector = [\"if(slider.vx > 0, -1000, 0)\", 0]\n";
    let figures = motion(&format!("{SLIDER_CRANK}{load}"), &["--speed", "60 rad/s", "--fluctuation", "0.02"]);
    // The load's torque has kinks at the limits, between samples.
    check_to(
        2e-5,
        &figures,
        &[
            ("/fluctuation/mean_torque", 16.07749776),
            ("/fluctuation/energy", 57.73205632),
            ("/fluctuation/flywheel", 0.8018341155),
        ],
    );
    // With that flywheel and the inertia of the mechanism the speed fluctuates a little more.
    let arguments = ["--speed", "60 rad/s", "--fluctuation", "0.02006615634"];
    let figures = motion(&format!("{SLIDER_CRANK}{load}"), &arguments);
    check_to(2e-5, &figures, &[("/fluctuation/added_inertia", 0.8018341155)]);
}

#[test]
fn the_whitworth_quick_return() {
    let figures = motion(WHITWORTH, &["--speed", "10 rad/s", "--output", "guide"]);
    check(
        &figures,
        &[
            ("/limits/0/input", 23.57817848 * DEG),
            ("/limits/1/input", 156.4218215 * DEG),
            ("/stroke", 0.12),
            ("/time_ratio", 1.709952782),
            ("/drive/max/value", 2.475334649),
            ("/drive/min/value", -2.345022533),
            ("/drive/rms", 0.9026864300),
            ("/inertia/max/value", 0.03411808223),
            ("/inertia/min/value", 4.650061403e-3),
            ("/shaking_force/max/value", 36.91152071),
            ("/shaking_moment/max/value", 1.349977176),
            ("/shaking_moment/min/value", -1.274547099),
        ],
    );
    let rod = figures["transmission"].as_array().unwrap().iter().find(|angle| angle["joint"] == "R").unwrap();
    check(rod, &[("/min/value", (90.0 - 17.45760312) * DEG)]);
    for (column, value) in
        [("guide", 0.2563728730), ("guide'", -26.84206802e-3), ("guide''", -0.1098270100), ("drive", 0.8714572544)]
    {
        near(at(&figures, column, 40), value);
    }
    check(joint(&figures, "O2"), &[("/max/value", 33.63815514), ("/rms", 12.37431730)]);
}

#[test]
fn the_toggle_press() {
    let figures = motion(PRESS, &["--speed", "5 rad/s", "--output", "guide", "--dwell", "0.5 mm"]);
    let [from, to] = ["/dwell/from", "/dwell/to"].map(|end| number(&figures, end));
    assert!((from.rem_euclid(360.0 * DEG) - 293.6855562 * DEG).abs() < 1e-6, "{from}");
    assert!((to - from - 132.8285243 * DEG).abs() < 1e-6, "{from} to {to}");
    let mut limits: Vec<(f64, f64)> = figures["limits"]
        .as_array()
        .unwrap()
        .iter()
        .map(|limit| (number(limit, "/input") / DEG, number(limit, "/value")))
        .collect();
    limits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted =
        [(0.07962452555, -0.4495497798), (44.30052989, -0.45), (183.0548062, -0.4385191652), (315.6994701, -0.45)];
    assert_eq!(limits.len(), 4);
    for ((input, value), (at, wanted)) in limits.into_iter().zip(wanted) {
        assert!((input - at).abs() < 1e-6 && (value - wanted).abs() < 1e-9, "{input} {value}");
    }
    assert!(figures["time_ratio"].is_null(), "four limits have no single time ratio");
    check(
        &figures,
        &[
            ("/drive/max/value", 0.02183011299),
            ("/drive/min/value", -0.01703074881),
            ("/inertia/max/value", 1.823994847e-3),
            ("/shaking_force/max/value", 2.811152690),
            ("/shaking_moment/max/value", 0.4312904401),
        ],
    );
    near(at(&figures, "guide'", 100), 7.015047112e-3);
    near(at(&figures, "advantage", 100), 142.5507176);
    near(at(&figures, "drive", 100), -9.893176037e-4);
}

#[test]
fn a_triple_rocker_has_dead_points_at_both_ends() {
    let scene = CRANK_ROCKER
        .replace("40 mm", "80 mm")
        .replace("120 mm", "60 mm")
        .replace("b = [\"80 mm\", 0]", "b = [\"50 mm\", 0]");
    let scene = scene
        .replace("\"60 deg\"", "\"20 deg\"")
        .replace("guess = 0.32", "guess = 0.5")
        .replace("guess = 1.13", "guess = 1.5");
    let figures = motion(&scene, &["--output", "O4"]);
    assert!(figures["four_bar"].as_str().unwrap().starts_with("triple rocker"), "{}", figures["four_bar"]);
    assert_eq!((&figures["full_turn"], &figures["dead_points"]), (&Value::Bool(false), &Value::Bool(true)));
    check_to(1e-6, &figures, &[("/range/0", -74.41010189 * DEG), ("/range/1", 74.41010189 * DEG)]);
}

/// It may start anywhere up to there, and the other rocker swings as far: cos of the limits by the triangles of the links in line, and the output, between its own limit and the
/// farther dead point of the input, by the same triangles.
#[test]
fn a_double_rocker_may_start_next_to_a_dead_point() {
    for start in ["50 deg", "82.7 deg", "82.81 deg"] {
        let scene = CRANK_ROCKER
            .replace("\"100 mm\", 0] }", "\"125 mm\", 0] }")
            .replace("40 mm", "100 mm")
            .replace("120 mm", "50 mm")
            .replace("b = [\"80 mm\", 0]", "b = [\"100 mm\", 0]")
            .replace("60 deg", start)
            .replace("guess = 0.32", "guess = \"30 deg\"")
            .replace("guess = 1.13", "guess = \"140 deg\"");
        let figures = motion(&scene, &["--output", "O4"]);
        check_to(1e-5, &figures, &[("/range/0", 0.925f64.acos()), ("/range/1", 0.125f64.acos())]);
        check_to(1e-4, &figures, &[("/stroke", 0.125f64.acos() - 0.75f64.acos())]);
    }
}

/// A damper takes the same power all along a range, on either side of where the scene starts.
#[test]
fn the_input_moves_forwards_all_along_a_range() {
    let scene = r#"
name = "damped"
[bodies]
bar = { mass = 1, inertia = 0.05, points = { o = [-0.3, 0] } }
[joints]
O2 = { type = "revolute", between = ["ground", "bar.o"], damping = 1.5 }
[initial]
"bar.angle" = 0.1
[outputs]
variables = ["bar.angle"]
"#;
    let figures = motion(scene, &["--speed", "2 rad/s", "--range", "-30 deg..30 deg"]);
    check(&figures, &[("/drive/min/value", 3.0), ("/drive/max/value", 3.0)]);
}

/// The scene's driver of the crank gives way, and the pose that it chose remains; without masses too.
#[test]
fn another_input_replaces_the_driver_of_the_scene() {
    let free = CRANK_ROCKER.replace("\"60 deg\"", "{ guess = \"60 deg\" }");
    let driven = CRANK_ROCKER.replace("\"crank.angle\"   = \"60 deg\"\n", "")
        + "[drivers.motor]\njoint = \"O2\"\nangle = \"60*pi/180 + 3*t\"\n";
    let light = ["mass = 0.3, inertia = 8e-5, ", "mass = 0.6, inertia = 1.2e-3, ", "mass = 0.5, inertia = 4e-4, "];
    let light = light.into_iter().fold(free.clone(), |scene, masses| scene.replace(masses, ""));
    // Crank and coupler in line: cos by the triangle with the ground.
    let ends = [160.0f64, 80.0].map(|reach| ((reach * reach - 1e4 - 6.4e3) / (2.0 * 100.0 * 80.0)).acos());
    let speed = ["--input", "O4", "--output", "O2", "--speed", "3 rad/s"];
    for scene in [&free, &driven, &light] {
        let figures = motion(scene, &speed);
        check_to(1e-6, &figures, &[("/range/0", ends[0]), ("/range/1", ends[1])]);
    }
}

/// Ends of the range of the angle between 0 and 90 degrees, at which it is reflected.
#[test]
fn a_transmission_angle_passes_90_degrees() {
    let scene = CRANK_ROCKER.replace("[\"100 mm\", 0] }\n[bodies]", "[\"125 mm\", 0] }\n[bodies]");
    let figures = motion(&scene, &["--output", "O4"]);
    check(&figures, &[("/transmission/0/max/value", 90.0 * DEG)]);
}

/// A slide that is driven goes as far as the links reach: sqrt((l +- r)^2 - e^2).
#[test]
fn a_driven_slide_has_its_dead_points_too() {
    let figures = motion(SLIDER_CRANK, &["--input", "guide", "--output", "O2"]);
    assert_eq!(figures["dead_points"], true);
    check_to(1e-6, &figures, &[("/range/0", 0.09797958971), ("/range/1", 0.1989974874)]);
}

/// Its branches cross where all links lie in line. It turns all the same, and nothing is unequal between crank and rocker.
#[test]
fn a_parallelogram_turns_through_its_change_points() {
    let scene = CRANK_ROCKER.replace("\"100 mm\"", "\"300 mm\"").replace("\"40 mm\"", "\"100 mm\"");
    let scene = scene.replace("\"120 mm\"", "\"300 mm\"").replace("b = [\"80 mm\", 0]", "b = [\"100 mm\", 0]");
    let scene = scene.replace("\"60 deg\"", "\"50.1 deg\"").replace("0.32", "0").replace("1.13", "0.87");
    let figures = motion(&scene, &["--point", "coupler.p"]);
    for flag in ["full_turn", "change_points"] {
        assert_eq!(figures[flag], true, "{flag}");
    }
    assert!(figures["four_bar"].as_str().unwrap().starts_with("change point"));
    for radius in figures["path"]["radius"].as_array().unwrap() {
        near(radius.as_f64().unwrap(), 0.1);
    }
    check(&figures, &[("/path/length", std::f64::consts::TAU * 0.1)]);
}

#[test]
fn the_report_is_a_text_a_table_and_a_plot() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), CRANK_ROCKER).unwrap();
    let run = |more: &[&str]| cotree(folder.path(), &[&["motion", "a.toml"], more].concat());
    let arguments = [
        "--input", "O2", "--output", "O4", "--speed", "20 rad/s", "--every", "60 deg", "-o", "a.csv", "--plot", "a.png",
    ];
    let text = stdout(&run(&arguments));
    for part in [
        "crank-rocker",
        "turns fully",
        "swing 73.7818 deg",
        "time ratio 1.35557",
        "26.3843 deg",
        ": below 40 deg",
        "0.771472 N.m",
        "46.9667 N",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert_eq!(text.lines().rev().take_while(|line| !line.is_empty()).count(), 7, "a head and six rows\n{text}");
    let table = std::fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert!(
        table.starts_with("O2 [deg],O4 [deg],O4',O4'' [1/rad],advantage,") && table.lines().count() == 721,
        "{table:.300}"
    );
    assert!(std::fs::read(folder.path().join("a.png")).unwrap().starts_with(b"\x89PNG"));
    for (more, message) in [
        (&["--input", "O9"][..], "did you mean `O2`?"),
        (&[][..], "--input"),
        (&["--input", "O2", "--output", "A"][..], "on the ground"),
        (&["--input", "O2", "--output", "A"][..], "`A.angle`"),
        (&["--input", "O2", "--output", "O2.angle"][..], "is the input"),
        (&["--input", "O2", "--output", "coupler.p.z"][..], "point `coupler.p` has `x`"),
        (&["--input", "O2", "--output", "couplr"][..], "did you mean `coupler`?"),
        (&["--input", "O2", "--output", "coupler"][..], "such as `coupler.angle`"),
        (&["--input", "O2", "--point", "coupler.q"][..], "no point `coupler.q`"),
        (&["--input", "O2", "--range", "3"][..], "from..to"),
        (&["--input", "O2", "--range", "-30 deg..10 mm"][..], "not in rad"),
        (&["--input", "O2", "--range", "-30 deg..10"][..], "`10` has no unit"),
        (&["--input", "O2", "--speed", "5 mm/s"][..], "not in rad/s"),
        (&["--input", "O2", "--dwell", "1 mm"][..], "not in rad"),
    ] {
        let output = run(more);
        assert!(code(&output) == 2 && stderr(&output).contains(message), "{more:?}: {}", stderr(&output));
    }
    // Without masses there are no forces.
    let light = CRANK_ROCKER.replace("mass = 0.3, inertia = 8e-5, ", "");
    let driven = format!("{light}[drivers.motor]\njoint = \"O2\"\nangle = \"60/57.29577951308232 + 2*t\"\n");
    std::fs::write(
        folder.path().join("b.toml"),
        driven.replace("mass = 0.6, inertia = 1.2e-3, ", "").replace("mass = 0.5, inertia = 4e-4, ", ""),
    )
    .unwrap();
    let kinematic = stdout(&cotree(Path::new(folder.path()), &["motion", "b.toml"]));
    assert!(
        kinematic.contains("time ratio 1.35557")
            && kinematic.contains("there are no forces")
            && kinematic.contains("transmission angle at `B` 26.3843 deg")
            && !kinematic.contains("torque"),
        "{kinematic}"
    );
}

/// A second slider hangs on the rocker and carries nothing: its joint transmits nothing, and what rounding errors leave of its force is zero.
#[test]
fn joints_that_carry_nothing_have_no_figures() {
    let hanging = CRANK_ROCKER
        .replace("[joints]", "idle  = { points = { c = [0, 0], d = [\"150 mm\", 0] } }\nblock = {}\n[joints]")
        .replace("o = [0, 0], b = [\"80 mm\", 0] }", "o = [0, 0], b = [\"80 mm\", 0], c = [\"30 mm\", \"10 mm\"] }")
        .replace(
            "[initial]",
            r#"C = { type = "revolute", between = ["rocker.c", "idle.c"] }
D = { type = "revolute", between = ["idle.d", "block"] }
guide = { type = "prismatic", between = ["ground.O4", "block"], axis = [1, 0] }
[initial]
"block.x" = { guess = 0.26 }"#,
        );
    let light = "mass = 0, inertia = 0, ";
    let hanging =
        hanging.replace("idle  = { ", &format!("idle  = {{ {light}")).replace("block = {}", "block = { mass = 0 }");
    let figures = motion(&hanging, &["--output", "O4"]);
    let joints: Vec<&str> =
        figures["transmission"].as_array().unwrap().iter().map(|own| own["joint"].as_str().unwrap()).collect();
    assert_eq!(joints, ["B"], "{figures:.400}");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), hanging).unwrap();
    let text = stdout(&cotree(folder.path(), &["motion", "a.toml", "--input", "O2", "--output", "O4"]));
    assert!(text.contains("joint `D`: peak 0 N at"), "{text}");
    assert!(!text.contains("e-1") && !text.contains("e-2"), "rounding errors as figures\n{text}");
    let (_, table) = text.split_once("\n\n").unwrap();
    assert!(table.lines().all(|line| line.chars().count() <= 100), "too wide\n{table}");
    assert!(
        table.split("\n\n").count() > 1 && table.split("\n\n").all(|block| block.starts_with("O2 [deg]")),
        "{table}"
    );
}

#[test]
fn a_point_of_a_rocker_goes_to_and_fro_on_an_arc() {
    let path = &motion(CRANK_ROCKER, &["--point", "rocker.b"])["path"];
    assert_eq!(path["to_and_fro"], true, "{path:.400}");
    check(path, &[("/arc/radius", 0.08), ("/arc/x", 0.1)]);
    assert!(number(path, "/arc/y").abs() < 1e-9);
    // Twice the swing of the rocker.
    check_to(1e-5, path, &[("/length", 2.0 * 0.08 * 73.7818 * DEG)]);
    assert!(["crunodes", "cusps", "inflections"].iter().all(|key| path[*key] == serde_json::json!([])), "{path:.400}");
    let crank = &motion(CRANK_ROCKER, &["--point", "crank.a"])["path"];
    assert!(crank["to_and_fro"] == false && (number(crank, "/arc/radius") - 0.04).abs() < 1e-9);
    assert!(motion(CRANK_ROCKER, &["--point", "coupler.p"])["path"]["arc"].is_null());
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), CRANK_ROCKER).unwrap();
    let text = stdout(&cotree(folder.path(), &["motion", "a.toml", "--input", "O2", "--point", "rocker.b"]));
    assert!(text.contains("to and fro, on an arc of radius 80 mm about (100 mm, 0 mm)"), "{text}");
    assert!(!text.contains("crosses itself"), "{text}");
}

/// A scotch yoke: the table stands at r sin(phi), the pin at r cos(phi) along its slot.
const SCOTCH_YOKE: &str = r#"
name = "scotch_yoke"
ground.points = { o = [0, 0], k = [0, "-100 mm"] }
[bodies]
table = { mass = 2 }
crank = { mass = 1, inertia = 1e-3, points = { o = [0, 0], p = ["50 mm", 0] } }
[joints]
guide = { type = "prismatic", between = ["ground", "table"], axis = [0, 1] }
O     = { type = "revolute", between = ["ground.o", "crank.o"] }
pin   = { type = "slot", between = ["table", "crank.p"], axis = [1, 0] }
[loads]
gauge = { type = "spring", between = ["ground.k", "table"], stiffness = 0, length = 0 }
[outputs]
height = "table.y*table.y"
[initial]
"crank.angle" = "60 deg"
"#;

fn values(figures: &Value, column: &str) -> Vec<f64> {
    let found = figures["table"].as_array().unwrap().iter().find(|own| own["name"] == column).expect(column);
    found["values"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

/// Values of a column at each input.
fn follows(figures: &Value, column: &str, tolerance: f64, of: impl Fn(f64) -> f64) {
    let input = figures["input"]["name"].as_str().unwrap();
    for (at, found) in values(figures, input).into_iter().zip(values(figures, column)) {
        let wanted = of(at);
        assert!((found - wanted).abs() < tolerance * (1.0 + wanted.abs()), "{column} at {at}: {found}, not {wanted}");
    }
}

#[test]
fn any_variable_is_an_output() {
    const R: f64 = 0.05;
    let table = motion(SCOTCH_YOKE, &["--input", "O", "--output", "table.y", "--speed", "3 rad/s", "--dwell", "1 mm"]);
    check(
        &table,
        &[("/stroke", 2.0 * R), ("/limits/0/input", 90.0 * DEG), ("/limits/1/value", -R), ("/time_ratio", 1.0)],
    );
    // Within 1 mm of its end: cos(half of the way) = 1 - 1/50.
    let way = number(&table, "/dwell/to") - number(&table, "/dwell/from");
    assert!((way - 2.0 * f64::acos(1.0 - 0.001 / R)).abs() < 1e-9, "{way}");
    follows(&table, "table.y'", 1e-11, |phi| R * phi.cos());
    follows(&table, "table.y''", 1e-11, |phi| -R * phi.sin());
    assert_eq!(table["transmission"], serde_json::json!([]));
    assert_eq!(table["output"], serde_json::json!({ "name": "table.y", "angular": false, "unit": "m" }));
    // A length whose rate there is, not its acceleration.
    let gauge = motion(SCOTCH_YOKE, &["--input", "O", "--output", "gauge.length", "--speed", "3 rad/s"]);
    follows(&gauge, "gauge.length", 1e-11, |phi| 0.1 + R * phi.sin());
    follows(&gauge, "gauge.length''", 1e-8, |phi| -R * phi.sin());
    // A formula has no rates of its own; a turning angle has no jump.
    let height = motion(SCOTCH_YOKE, &["--input", "O", "--output", "height"]);
    follows(&height, "height'", 1e-9, |phi| R * R * (2.0 * phi).sin());
    follows(&height, "height''", 1e-7, |phi| 2.0 * R * R * (2.0 * phi).cos());
    assert_eq!(height["limits"].as_array().unwrap().len(), 4, "{}", height["limits"]);
    let angle = motion(SCOTCH_YOKE, &["--input", "O", "--output", "crank.angle"]);
    follows(&angle, "crank.angle'", 1e-11, |_| 1.0);
    // Forces: the table's inertia.
    let force = motion(SCOTCH_YOKE, &["--input", "O", "--output", "pin.fn", "--speed", "3 rad/s"]);
    let sign = values(&force, "pin.fn")[180].signum();
    follows(&force, "pin.fn", 1e-9, |phi| sign * 2.0 * 9.0 * R * phi.sin());
    check(&force, &[("/stroke", 2.0 * 2.0 * 9.0 * R)]);
}

#[test]
fn a_slot_is_driven_by_its_displacement() {
    const R: f64 = 0.05;
    let range = ["--range", "-30 mm..45 mm", "--speed", "2 m/s"];
    let figures = motion(SCOTCH_YOKE, &[&["--input", "pin.s", "--output", "O"], &range[..]].concat());
    let y = |s: f64| (R * R - s * s).sqrt();
    follows(&figures, "O", 1e-9, |s| f64::acos(s / R));
    follows(&figures, "O'", 1e-9, |s| -1.0 / y(s));
    // Half the derivative of the generalised inertia I/y^2 + m s^2/y^2, by the square of the speed.
    follows(&figures, "inertia", 1e-9, |s| (1e-3 + 2.0 * s * s) / y(s).powi(2));
    follows(&figures, "drive", 1e-8, |s| 0.5 * 4.0 * (2e-3 * s + 4.0 * s * R * R) / y(s).powi(4));
    assert_eq!(figures["input"]["unit"], "m");
    // Without a range: to the ends of its slot's use, where it is at a dead point.
    let whole = motion(SCOTCH_YOKE, &["--input", "pin.s", "--output", "table.y"]);
    assert_eq!(whole["dead_points"], true);
    check_to(1e-6, &whole, &[("/range/0", -R), ("/range/1", R), ("/stroke", R)]);
    // The same by a driver of the scene, which says what is driven; and the slot's other motion.
    let driven = format!("{SCOTCH_YOKE}[drivers.d]\njoint = \"pin\"\ndisplacement = \"0.025 + 2*t\"\n");
    let driven =
        driven.replace("[initial]\n\"crank.angle\" = \"60 deg\"", "[initial]\n\"crank.angle\" = { guess = 1 }");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), driven).unwrap();
    let run = |more: &[&str]| cotree(folder.path(), &[&["motion", "a.toml", "--output", "O"], more].concat());
    for input in [&[][..], &["--input", "d"]] {
        let text = stdout(&run(&[input, &["--range", "-30 mm..45 mm"]].concat()));
        let first = "scotch_yoke: `pin.s` moves from -30 mm to 45 mm, at 2000 mm/s as at the start of the scene\n";
        assert!(text.starts_with(first), "{text}");
    }
    let text = stdout(&run(&["--input", "pin"]));
    assert!(text.starts_with("scotch_yoke: `pin` turns fully"), "{text}");
    let guide = motion(SCOTCH_YOKE, &["--input", "guide.s", "--output", "O", "--range", "-20 mm..45 mm"]);
    follows(&guide, "O", 1e-9, |s| f64::asin(s / R));
}

#[test]
fn an_output_that_the_replaced_driver_computes_is_refused() {
    let driven = format!(
        "{}[drivers.motor]\njoint = \"O\"\nangle = \"1 + 3*t\"\n",
        SCOTCH_YOKE.replace("table.y*table.y", "2*motor.torque").replace("\"crank.angle\" = \"60 deg\"", "")
    );
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), driven).unwrap();
    let output = cotree(folder.path(), &["motion", "a.toml", "--output", "height"]);
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    assert!(
        stderr(&output).contains("while `O` is driven") && stderr(&output).contains("motor.torque"),
        "{}",
        stderr(&output)
    );
}

/// The elbow of an arm is held while its shoulder turns: T = m c (g cos + w^2 l sin 0.5). The driver of the elbow stays when that of the shoulder gives way.
#[test]
fn the_other_drivers_keep_what_is_asked_of_them() {
    const ARM: &str = r#"
name = "arm"
gravity = [0, -9.81]
[bodies]
upper = { mass = 1, inertia = 0.01, points = { o = [0, 0], e = ["400 mm", 0] } }
lower = { mass = 2, inertia = 0.02, com = ["300 mm", 0], points = { e = [0, 0] } }
[joints]
shoulder = { type = "revolute", between = ["ground", "upper.o"] }
elbow    = { type = "revolute", between = ["upper.e", "lower.e"] }
[drivers]
turn = { joint = "shoulder", angle = "0.2 + 3*t" }
hold = { joint = "elbow", angle = 0.5 }
[outputs]
twice = "2*hold.torque"
"#;
    let figures = motion(ARM, &["--input", "shoulder", "--output", "twice", "--range", "20 deg..60 deg"]);
    let gravity = 9.81 * (20.0 * DEG + 0.5).cos();
    near(values(&figures, "twice")[0], 2.0 * 2.0 * 0.3 * (gravity + 9.0 * 0.4 * 0.5f64.sin()));
}

/// A lever that is lifted from any start: its weight's torque is m g l cos, its tip at l sin.
fn lever(start: &str) -> String {
    format!(
        "name = \"lever\"\ngravity = [0, -10]\n[bodies]\nbar = {{ mass = 2, inertia = 0, com = [0.5, 0], points = {{ o = [0, 0], tip = [0.8, 0] }} }}\n\
         [joints]\npin = {{ type = \"revolute\", between = [\"ground\", \"bar.o\"] }}\n[initial]\n\"bar.angle\" = \"{start}\"\n"
    )
}

#[test]
fn a_range_is_sampled_from_end_to_end_wherever_the_scene_starts() {
    let arguments = ["--input", "pin", "--output", "bar.tip.y", "--speed", "1e-5 rad/s"];
    for start in ["7 deg", "0 deg", "-31 deg", "77 deg"] {
        for [from, to] in [[-10.0, 40.0], [40.0, -10.0]] {
            let range = format!("{from} deg..{to} deg");
            let figures = motion(&lever(start), &[&arguments[..], &["--range", &range]].concat());
            let inputs = values(&figures, "pin");
            assert_eq!(inputs.len(), 721);
            for (found, wanted) in [(inputs[0], from), (inputs[720], to), (inputs[360], 15.0)] {
                assert!((found - wanted * DEG).abs() < 1e-12, "{start} {range}: {found}");
            }
            follows(&figures, "drive", 1e-8, |angle| 10.0 * angle.cos());
            follows(&figures, "bar.tip.y'", 1e-9, |angle| 0.8 * angle.cos());
            let stroke = 0.8 * ((40.0 * DEG).sin() + (10.0 * DEG).sin());
            check(&figures, &[("/stroke", stroke), ("/drive/min/value", 10.0 * (40.0 * DEG).cos())]);
        }
    }
}

/// Numbers of the first column of the printed table.
fn rows(text: &str) -> Vec<f64> {
    let table = text.split("\n\n").nth(1).unwrap();
    table.lines().skip(1).map(|line| line.split_whitespace().next().unwrap().parse().unwrap()).collect()
}

#[test]
fn rows_stand_where_they_were_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), lever("3 deg")).unwrap();
    std::fs::write(folder.path().join("b.toml"), CRANK_ROCKER).unwrap();
    let run = |scene: &str, more: &[&str]| stdout(&cotree(folder.path(), &[&["motion", scene], more].concat()));
    let lever = |range: &str, every: &str| {
        rows(&run("a.toml", &["--input", "pin", "--output", "bar.tip.y", "--range", range, "--every", every]))
    };
    assert_eq!(lever("0 deg..50 deg", "20 deg"), [0.0, 20.0, 40.0, 50.0]);
    assert_eq!(lever("50 deg..1 deg", "17 deg"), [50.0, 33.0, 16.0, 1.0]);
    assert_eq!(lever("0 deg..5 deg", "7 deg"), [0.0, 5.0]);
    let turn = run("b.toml", &["--input", "O2", "--output", "O4", "--every", "51.3 deg"]);
    assert_eq!(rows(&turn), [0.0, 51.3, 102.6, 153.9, 205.2, 256.5, 307.8, 359.1]);
    // Between dead points at round places, and at both ends of what is sampled.
    let rocker = run("b.toml", &["--input", "O4", "--output", "O2", "--every", "20 deg"]);
    let places = rows(&rocker);
    assert_eq!(places[1..places.len() - 1], [60.0, 80.0, 100.0, 120.0], "{rocker}");
    for wrong in ["0 deg", "-3 deg", "1e-9 deg"] {
        let output = cotree(folder.path(), &["motion", "a.toml", "--input", "pin", "--every", wrong]);
        assert!(code(&output) == 2 && stderr(&output).contains("--every"), "{wrong}: {}", stderr(&output));
    }
}

/// The output turns from 100 degrees on, as 0.8 - 0.3 sin(in): near the dead points everything that moves there grows.
#[test]
fn what_grows_without_bound_at_dead_points_has_no_peak() {
    let figures = motion(SLIDER_CRANK, &["--input", "guide", "--output", "O2", "--speed", "0.4 m/s"]);
    let ends = [number(&figures, "/range/0"), number(&figures, "/range/1")];
    for own in ["drive", "power", "inertia", "shaking_force", "joint_force_index"] {
        let unbounded = &figures[own]["unbounded"];
        assert_eq!(unbounded["at"], serde_json::json!(ends), "{own}");
        let distance = number(unbounded, "/distance");
        assert!(distance > 0.02 * (ends[1] - ends[0]) && distance < 0.022 * (ends[1] - ends[0]), "{own} {distance}");
    }
    // The crank with the slider at s: by the law of cosines; its inertia as the slide feels it grows as 1/distance.
    let distance = number(&figures, "/inertia/unbounded/distance");
    let inner = [ends[0] + distance, ends[1] - distance].map(|end| format!("{:?} m", end)).join("..");
    let inside = motion(SLIDER_CRANK, &["--input", "guide", "--output", "O2", "--speed", "0.4 m/s", "--range", &inner]);
    assert!(inside["inertia"]["unbounded"].is_null());
    for path in ["/inertia/max/value", "/drive/max/value", "/drive/min/value"] {
        check_to(1e-6, &figures, &[(path, number(&inside, path))]);
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), SLIDER_CRANK).unwrap();
    let text = stdout(&cotree(folder.path(), &["motion", "a.toml", "--input", "guide", "--output", "O2"]));
    assert!(text.contains("drive force grows without bound towards 97.9796 mm and 198.997 mm; at least 2."), "{text}");
    // With a crank that turns fully everything stays bounded.
    assert!(motion(SLIDER_CRANK, &[])["drive"]["unbounded"].is_null());
}

/// A crank slides in its guide: at the dead point of the rocker the links are in line, where the transmission angle is zero.
#[test]
fn a_transmission_angle_is_followed_into_the_dead_point() {
    let figures = motion(CRANK_ROCKER, &["--input", "O4", "--output", "O2"]);
    let angle = figures["transmission"].as_array().unwrap().iter().find(|own| own["joint"] == "A").unwrap();
    assert!(number(angle, "/min/value") < 1e-3, "{angle}");
}

/// A cam raises a lever and lets it rest; a link stands on the lever, whose direction of motion at rest is that of a turn about its pivot.
#[test]
fn a_follower_at_rest_transmits_as_next_to_its_rest() {
    let scene = r#"
name = "dwelling"
ground.points = { pivot = ["200 mm", 0], guide = ["330 mm", 0] }
[bodies]
cam   = {}
lever = { points = { o = [0, 0], roller = ["-200 mm", "70 mm"], out = ["150 mm", 0] } }
link  = { points = { top = [0, "100 mm"], low = [0, "-100 mm"] } }
ram   = {}
[joints]
shaft = { type = "revolute", between = ["ground", "cam"] }
pivot = { type = "revolute", between = ["ground.pivot", "lever.o"] }
track = { type = "cam", between = ["cam", "lever.roller"], shaft = "shaft", guide = "pivot", base = "50 mm", roller = "15 mm", side = "right", law = "10[deg]*(cycloidal(angle/2) - cycloidal((angle - 3)/2))" }
top   = { type = "revolute", between = ["lever.out", "link.top"] }
low   = { type = "revolute", between = ["link.low", "ram"] }
guide = { type = "prismatic", between = ["ground.guide", "ram"], axis = [0, 1] }
[drivers]
motor = { joint = "shaft", angle = "t" }
"#;
    let figures = motion(scene, &["--input", "shaft", "--output", "guide"]);
    let angles = values(&figures, "transmission at low");
    let [least, most] = [f64::min, f64::max].map(|of| angles.iter().copied().reduce(of).unwrap());
    // In its guide the ram moves upright: the angle is that of the link from the horizontal.
    let links = values(&figures, "guide");
    assert_eq!(links.len(), angles.len());
    assert!(least > 60.0 * DEG && most <= 90.0 * DEG, "{least} to {most}");
    let jumps = angles.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    assert!(jumps < 0.01, "{jumps}");
    assert!((number(&figures["transmission"][0], "/min/value") - least).abs() < 1e-3, "{}", figures["transmission"]);
}

/// 300 N on the slide: the crank's torque is 300 N times the influence coefficient of the slide, by virtual work.
#[test]
fn without_masses_the_loads_still_act() {
    let heavy = [", inertia = 1e-3, com = [\"10 mm\", 0]", ", inertia = 2.5e-3, com = [\"50 mm\", 0]"];
    let light = heavy.iter().fold(SLIDER_CRANK.to_owned(), |scene, own| scene.replace(own, ""));
    let light = light.replace("mass = 1,", "").replace("mass = 0.8,", "").replace("mass = 1.2 ", "");
    let load = "[loads.push]\ntype = \"force\"\non = \"slider\"\nvector = [-300, 0]\n";
    let scene = format!("{light}{load}");
    for speed in ["0", "5 rad/s"] {
        let figures = motion(&scene, &["--output", "guide", "--speed", speed]);
        let wanted: Vec<f64> = values(&figures, "guide'").iter().map(|slope| 300.0 * slope).collect();
        let found = values(&figures, "drive");
        assert!(found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{speed}");
        assert_eq!(figures["lacking"], serde_json::json!(["crank", "rod", "slider"]));
        assert!(
            figures["inertia"].is_null() && figures["shaking_force"].is_null() && figures["transmission"].is_array()
        );
        check(joint(&figures, "O2"), &[("/max/value", 300.0 / (1.0 - (7.0f64 / 15.0).powi(2)).sqrt())]);
    }
    // All the way round, wherever the turn begins.
    let turned = scene.replace("\"50 deg\"", "\"170 deg\"").replace("-0.12", "0");
    let figures = motion(&turned, &["--output", "guide", "--speed", "0"]);
    assert_eq!(values(&figures, "drive").len(), 720);
    // Gravity alone at rest: with masses, and with them the torque is that of their weights.
    let still = motion(&lever("3 deg"), &["--input", "pin", "--output", "bar.tip.y", "--speed", "0"]);
    follows(&still, "drive", 1e-9, |angle| 10.0 * angle.cos());
    assert!(still["power"].is_null() && still["shaking_force"].is_null());
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), &scene).unwrap();
    let run = |more: &[&str]| cotree(folder.path(), &[&["motion", "a.toml", "--input", "O2"], more].concat());
    let text = stdout(&run(&[]));
    assert!(text.lines().next().unwrap().ends_with(", at 57.2958 deg/s (assumed; give --speed)"), "{text}");
    assert!(text.contains("no mass or no inertia is given for `crank`, `rod`, `slider`: forces are without"), "{text}");
    let still = stdout(&run(&["--speed", "0"]));
    assert!(still.lines().next().unwrap().ends_with(", static forces in each configuration"), "{still}");
    for (more, message) in [
        (&["--speed", "0", "--output", "slider.vx"][..], "`slider.vx` is 0 at rest"),
        (&["--speed", "0", "--fluctuation", "0.1"][..], "cannot fluctuate"),
        (&["--speed", "-1 rad/s"][..], "backward motion"),
        (&["--range", "5 deg..5 deg"][..], "is empty"),
    ] {
        let output = run(more);
        assert!(code(&output) == 2 && stderr(&output).contains(message), "{more:?}: {}", stderr(&output));
    }
}

#[test]
fn powers_have_the_prefix_of_forces_and_areas_no_sign() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), CRANK_ROCKER).unwrap();
    let run = |more: &[&str]| {
        stdout(&cotree(folder.path(), &[&["motion", "a.toml", "--input", "O2", "--speed", "20 rad/s"], more].concat()))
    };
    let text = run(&["--units", "kN"]);
    assert!(text.contains("drive power -0.026446 kW (at"), "{text}");
    assert!(run(&[]).contains("drive power -26.446 W (at"));
    let path = run(&["--point", "crank.a"]);
    assert!(path.contains(", encloses 5026.55 mm2 counter-clockwise"), "{path}");
    let clockwise = run(&["--point", "coupler.n"]);
    assert!(!clockwise.contains("encloses -"), "{clockwise}");
}
