//! `cotree motion` of mechanisms with limits, contacts and ropes: where the drive is stopped, against triangles, circles and bisection.

use std::f64::consts::{PI, TAU};

use crate::outside::command;
use crate::support::cam::Random;

use command::{code, cotree, stderr, stdout};
use cotree_study::motion::{self, MotionRequest};
use serde_json::Value;

const DEG: f64 = PI / 180.0;
const CRANK: f64 = 0.05;
const ROD: f64 = 0.15;

/// A slider-crank in line, with keys of its guide, more joints, and the angle at which it starts.
fn slider_crank(guide: &str, joints: &str, start: &str) -> String {
    format!(
        r#"
name = "slider_crank"
ground.points = {{ O2 = [0, 0], wall = ["170 mm", 0], post = ["30 mm", "-40 mm"] }}
[bodies]
crank  = {{ mass = 1, inertia = 1e-3, points = {{ o = [0, 0], a = [{CRANK}, 0] }} }}
rod    = {{ mass = 0.8, inertia = 2.5e-3, com = ["50 mm", 0], points = {{ a = [0, 0], b = [{ROD}, 0] }} }}
slider = {{ mass = 1.2 }}
[joints]
O2    = {{ type = "revolute", between = ["ground.O2", "crank.o"] }}
A     = {{ type = "revolute", between = ["crank.a", "rod.a"] }}
B     = {{ type = "revolute", between = ["rod.b", "slider"] }}
guide = {{ type = "prismatic", between = ["ground", "slider"], axis = [1, 0] {guide} }}
{joints}
[initial]
"crank.angle" = "{start}"
"rod.angle"   = {{ guess = -0.12 }}
"#
    )
}

/// Where the slider is, and its rate by the crank's angle.
fn slider(angle: f64) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    let rest = (ROD * ROD - (CRANK * sine).powi(2)).sqrt();
    [CRANK * cosine + rest, -CRANK * sine - CRANK * CRANK * sine * cosine / rest]
}

/// The crank's angle, above zero, at which the slider is there.
fn crank(slider: f64) -> f64 {
    ((slider * slider + CRANK * CRANK - ROD * ROD) / (2.0 * slider * CRANK)).acos()
}

fn told(scene: &str, more: &[&str]) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), scene).unwrap();
    let input: &[&str] = if more.contains(&"--input") { &[] } else { &["--input", "O2"] };
    let output = cotree(folder.path(), &[&["motion", "a.toml"], input, more].concat());
    if code(&output) == 0 { Ok(stdout(&output)) } else { Err(stderr(&output)) }
}

fn figures(scene: &str, more: &[&str]) -> Value {
    let text = told(scene, &[&["--json"], more].concat()).unwrap_or_else(|error| panic!("{error}"));
    serde_json::from_str(&text).unwrap()
}

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {path} in {}", value["stops"]))
}

fn near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-9, "{found}, not {wanted}");
}

/// What ends the range, from below and from above.
fn ends(figures: &Value, wanted: [Option<(&str, f64)>; 2]) {
    for (index, wanted) in wanted.into_iter().enumerate() {
        let end = &figures["stops"]["ends"][index];
        match wanted {
            Some((name, at)) => {
                assert_eq!(end["name"], name, "{}", figures["stops"]);
                near(end["input"].as_f64().unwrap(), at);
                near(number(figures, &format!("/range/{index}")), at);
            }
            None => assert!(end.is_null(), "{end}"),
        }
    }
}

#[test]
fn limits_of_the_slider_stop_the_crank() {
    let scene = slider_crank(r#", limits = { min = "110 mm", max = "180 mm" }"#, "", "100 deg");
    let found = figures(&scene, &[]);
    let [low, high] = [0.18, 0.11].map(crank);
    ends(&found, [Some(("guide.max", low)), Some(("guide.min", high))]);
    for (index, at) in [low, high].into_iter().enumerate() {
        // Virtual work: T dphi = F ds.
        let presses = number(&found, &format!("/stops/ends/{index}/presses"));
        assert!((presses * slider(at)[1].abs() - 1.0).abs() < 1e-7, "{presses}");
        assert_eq!(found["stops"]["ends"][index]["unit"], "N");
    }
    let inputs = found["table"][0]["values"].as_array().unwrap();
    near(inputs[0].as_f64().unwrap(), low);
    near(inputs.last().unwrap().as_f64().unwrap(), high);
    near(number(&found, "/stroke"), 0.07);
    // Beyond them it would be around either dead point of the crank, up to one turn from the lower end.
    let beyond = found["stops"]["beyond"].as_array().unwrap();
    assert_eq!(beyond.len(), 2, "{beyond:?}");
    for own in beyond {
        let wanted = if own["name"] == "guide.min" { [high, TAU - high] } else { [TAU - low, TAU + low] };
        near(number(own, "/from"), wanted[0]);
        near(number(own, "/to"), wanted[1]);
    }
    let text = told(&scene, &[]).unwrap();
    for part in [
        "`O2` moves from 46.4578 deg (`guide.max`) to 135.905 deg (`guide.min`)",
        "`guide.max` stops `O2` at 46.4578 deg: less is not reachable, and the force of the hard stop is not determined",
        "gives a force of 22.3115 N",
        "beyond `guide.min` it would be from 135.905 deg to 224.095 deg",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// Backwards, at rest, from elsewhere: always what is reachable, and the rest is said not to be.
#[test]
fn a_range_that_is_asked_for_ends_at_the_stops() {
    let scene = slider_crank(r#", limits = { min = "110 mm", max = "180 mm" }"#, "", "100 deg");
    let [low, high] = [0.18, 0.11].map(crank);
    for (range, wanted) in [
        ("0 deg..360 deg", [low, high]),
        ("150 deg..20 deg", [high, low]),
        ("120 deg..60 deg", [120.0 * DEG, 60.0 * DEG]),
        ("120 deg..200 deg", [120.0 * DEG, high]),
    ] {
        for speed in ["0", "2"] {
            let found = figures(&scene, &["--range", range, "--speed", speed]);
            near(number(&found, "/range/0"), wanted[0]);
            near(number(&found, "/range/1"), wanted[1]);
            assert_eq!(found["stops"]["asked"].is_null(), range == "120 deg..60 deg", "{range}");
        }
    }
    let text = told(&scene, &["--range", "0 deg..360 deg"]).unwrap();
    assert!(text.contains("the rest of the range from 0 deg to 360 deg is not reachable and not analysed"), "{text}");
    let none = told(&scene, &["--range", "150 deg..200 deg"]).unwrap_err();
    assert!(none.contains("`O2` cannot reach the range from 150 deg to 200 deg"), "{none}");
    assert!(none.contains("`guide.min` stops it at 135.9 deg"), "{none}");
}

/// The input itself may have limits, and needs no range then.
#[test]
fn limits_of_the_input_end_its_range() {
    let scene = slider_crank(r#", limits = { min = "110 mm", max = "180 mm" }"#, "", "100 deg");
    let found = figures(&scene, &["--input", "guide"]);
    ends(&found, [Some(("guide.min", 0.11)), Some(("guide.max", 0.18))]);
    near(number(&found, "/stroke"), crank(0.11) - crank(0.18));
    let rail = "name = \"rail\"\n[bodies]\ncar = { mass = 1 }\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"car\"]\naxis = [1, 0]\n[initial]\n\"rail.s\" = 2\n";
    let limited = rail.replace("axis = [1, 0]", "axis = [1, 0]\nlimits = { min = -3, max = 7 }");
    ends(&figures(&limited, &["--input", "rail"]), [Some(("rail.min", -3.0)), Some(("rail.max", 7.0))]);
    let one = told(&limited.replace("min = -3, ", ""), &["--input", "rail"]).unwrap_err();
    assert!(one.contains("has an unlimited range: give one"), "{one}");
    let half = figures(&limited.replace("min = -3, ", ""), &["--input", "rail", "--range", "0..9"]);
    ends(&half, [None, Some(("rail.max", 7.0))]);
}

/// Angles of a crank for which the rocker is there: the pin B is known, and the crank's pin is on two circles.
fn crank_angles([ground, crank, coupler, rocker]: [f64; 4], angle: f64) -> [f64; 2] {
    let [x, y] = [ground + rocker * angle.cos(), rocker * angle.sin()];
    let reach = (crank * crank + x * x + y * y - coupler * coupler) / (2.0 * crank * x.hypot(y));
    let turn = reach.acos();
    [y.atan2(x) + turn, y.atan2(x) - turn]
}

/// The rocker's angle in the assembly with the coupler's end above the line from the crank's pin to the rocker's pivot.
fn rocker_angle([ground, crank, coupler, rocker]: [f64; 4], angle: f64) -> Option<f64> {
    let [x, y] = [crank * angle.cos() - ground, crank * angle.sin()];
    let reach = (rocker * rocker + x * x + y * y - coupler * coupler) / (2.0 * rocker * x.hypot(y));
    (reach.abs() <= 1.0).then(|| y.atan2(x) - reach.acos())
}

fn four_bar([ground, crank, coupler, rocker]: [f64; 4], start: f64, [min, max]: [f64; 2]) -> String {
    let open = rocker_angle([ground, crank, coupler, rocker], start).unwrap();
    let [ax, ay] = [crank * start.cos(), crank * start.sin()];
    let along = (rocker * open.sin() - ay).atan2(ground + rocker * open.cos() - ax);
    let [min, max] = [min, max].map(|limit| limit / DEG);
    format!(
        r#"
name = "four_bar"
ground.points = {{ O2 = [0, 0], O4 = [{ground}, 0] }}
[bodies]
crank   = {{ points = {{ o = [0, 0], a = [{crank}, 0] }} }}
coupler = {{ points = {{ a = [0, 0], b = [{coupler}, 0] }} }}
rocker  = {{ points = {{ o = [0, 0], b = [{rocker}, 0] }} }}
[joints]
O2 = {{ type = "revolute", between = ["ground.O2", "crank.o"] }}
A  = {{ type = "revolute", between = ["crank.a", "coupler.a"] }}
B  = {{ type = "revolute", between = ["coupler.b", "rocker.b"] }}
O4 = {{ type = "revolute", between = ["ground.O4", "rocker.o"], limits = {{ min = "{min} deg", max = "{max} deg" }} }}
[drivers.motor]
joint = "O2"
angle = "{start} + 2*t"
[initial]
"coupler.angle" = {{ guess = {along} }}
"rocker.angle"  = {{ guess = {open} }}
"#
    )
}

/// Without masses, and with the driver of the scene, which `check` refuses.
#[test]
fn limits_of_the_rocker_stop_the_crank() {
    let links = [0.1, 0.04, 0.12, 0.08];
    let start = 80.0 * DEG;
    let open = rocker_angle(links, start).unwrap();
    let open = if open < -PI { open + TAU } else { open };
    let limits = [open - 8.0 * DEG, open + 11.0 * DEG];
    let scene = four_bar(links, start, limits);
    let found = figures(&scene, &[]);
    let wanted = limits.map(|limit| crank_angles(links, limit));
    for (index, both) in wanted.iter().enumerate() {
        let end = number(&found, &format!("/stops/ends/{index}/input"));
        assert!(both.iter().any(|at| ((end - at) / TAU - ((end - at) / TAU).round()).abs() < 1e-10), "{end} {both:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), &scene).unwrap();
    let checked = stderr(&cotree(folder.path(), &["check", "a.toml"]));
    assert!(
        checked.contains("prescribed motion cannot stop") && checked.contains("`cotree motion` reports"),
        "{checked}"
    );
}

/// Within what is reachable the rocker of closed form is within its limits, at both ends it is at one of them, or the crank turns fully.
#[test]
fn random_four_bars_are_stopped_where_circles_say() {
    let mut random = Random(65);
    let (mut stopped, mut whole, mut folds) = (0, 0, 0);
    for _ in 0..100 {
        let links = std::array::from_fn(|_| random.between(0.05, 0.2));
        let start = random.between(0.0, TAU);
        let Some(open) = rocker_angle(links, start) else { continue };
        let reach = random.between(0.02, 2.2);
        let limits = [open - reach, open + random.between(0.02, 2.2)];
        let request = MotionRequest { input: Some("O2".into()), ..MotionRequest::default() };
        let scene = cotree::scene::Scene::from_toml(&four_bar(links, start, limits)).unwrap();
        let found =
            motion::study(&scene, &request).unwrap_or_else(|error| panic!("{links:?} {start} {limits:?}: {error}"));
        let stops = found.stops.as_ref().unwrap();
        let inside = |angle: f64| {
            rocker_angle(links, angle).is_some_and(|own| {
                let off = (own - open) - TAU * ((own - open) / TAU).round();
                open + off > limits[0] - 1e-9 && open + off < limits[1] + 1e-9
            })
        };
        let range = found.range.unwrap_or([0.0, TAU]);
        let share = |index: usize| range[0] + (range[1] - range[0]) * (index as f64 + 0.5) / 500.0;
        assert!((0..500).all(|index| inside(share(index))), "{links:?} {start} {limits:?} {range:?}");
        for (end, side) in stops.ends.iter().zip([-1.0, 1.0]) {
            let Some(end) = end else { continue };
            stopped += 1;
            assert!(
                inside(end.input - side * 1e-7) && !inside(end.input + side * 1e-7),
                "{links:?} {start} {limits:?} {end:?}"
            );
            let limit = limits[usize::from(end.name == "O4.max")];
            let near = |at: f64| ((end.input - at) / TAU - ((end.input - at) / TAU).round()).abs() * TAU < 1e-9;
            assert!(crank_angles(links, limit).into_iter().any(near), "{end:?} {:?}", crank_angles(links, limit));
        }
        whole += usize::from(found.full_turn);
        folds += usize::from(found.dead_points && stops.ends.iter().any(Option::is_some));
    }
    assert!(stopped > 30 && whole > 2 && folds > 2, "{stopped} {whole} {folds}");
}

/// x less than 170 mm less the radius; farther than the circle; no farther than the rope is long; in the frame of the crank, s sin(phi) more than the radius.
#[test]
fn contacts_and_ropes_stop_the_crank() {
    let bisected = |gap: &dyn Fn(f64) -> f64, mut within: f64, mut beyond: f64| {
        for _ in 0..200 {
            let middle = 0.5 * (within + beyond);
            if gap(middle) > 0.0 { within = middle } else { beyond = middle }
        }
        within
    };
    let x = |angle: f64| slider(angle)[0];
    let post = |angle: f64| (x(angle) - 0.03).hypot(0.04);
    let start = 100.0 * DEG;
    type Case<'a> = (&'a str, &'a str, &'a dyn Fn(f64) -> f64, [f64; 2]);
    let cases: [Case; 4] = [
        (
            "between = [\"ground.wall\", \"slider\"], axis = [0, 1], radius = 0.008",
            "contact",
            &|angle| 0.162 - x(angle),
            [0.0, TAU],
        ),
        (
            "between = [\"ground.post\", \"slider\"], circle = 0.08, radius = 0.01",
            "contact",
            &|angle| post(angle) - 0.09,
            [PI, PI],
        ),
        ("between = [\"ground.post\", \"slider\"], length = 0.13", "rope", &|angle| 0.13 - post(angle), [0.0, TAU]),
        (
            "between = [\"crank.o\", \"slider\"], axis = [1, 0], side = \"right\", radius = 0.05",
            "contact",
            &|angle| x(angle) * angle.sin() - 0.05,
            [0.0, PI],
        ),
    ];
    for (keys, kind, gap, beyond) in cases {
        let scene = slider_crank("", &format!("stop = {{ type = \"{kind}\", {keys} }}"), "100 deg");
        let found = figures(&scene, &[]);
        let name = if kind == "rope" { "stop.max" } else { "stop" };
        let mirrored = beyond[0] == PI;
        let high = bisected(gap, start, beyond[1]);
        let low = if mirrored { high - TAU + 2.0 * (PI - high) } else { bisected(gap, start, beyond[0]) };
        ends(&found, [Some((name, low)), Some((name, high))]);
    }
}

/// A limit at the very end of the stroke is touched; a tenth of a micrometre before it is passed between two samples.
#[test]
fn what_is_touched_is_not_passed() {
    let with = |max: f64| figures(&slider_crank(&format!(", limits = {{ max = {max} }}"), "", "100.25 deg"), &[]);
    let touched = with(CRANK + ROD);
    assert_eq!((&touched["full_turn"], touched["stops"]["ends"][0].is_null()), (&Value::Bool(true), true));
    assert_eq!(touched["stops"]["clear"][0]["name"], "guide.max");
    assert!(number(&touched, "/stops/clear/0/value").abs() < 1e-12);
    let passed = with(CRANK + ROD - 1e-7);
    let at = crank(CRANK + ROD - 1e-7);
    assert!(at < 0.25 * DEG);
    let [low, high] = [0, 1].map(|index| number(&passed, &format!("/stops/ends/{index}/input")));
    assert!((low - at).abs() < 1e-8 && (high - (TAU - at)).abs() < 1e-8, "{low} {high} {at}");
    let clear = with(0.25);
    assert!((number(&clear, "/stops/clear/0/value") - 0.05).abs() < 1e-12, "{}", clear["stops"]);
}

#[test]
fn a_start_at_a_stop_goes_away_from_it_and_one_beyond_is_refused() {
    let at = crank(0.18) / DEG;
    let scene = |max: f64| slider_crank(&format!(", limits = {{ max = {max} }}"), "", &format!("{at} deg"));
    ends(&figures(&scene(0.18), &[]), [Some(("guide.max", at * DEG)), Some(("guide.max", TAU - at * DEG))]);
    let beyond = told(&scene(0.177), &[]).unwrap_err();
    assert!(beyond.contains("the scene starts beyond `guide.max`, by 3 mm"), "{beyond}");
}

#[test]
fn what_the_drive_does_not_determine_is_refused() {
    let free = slider_crank(
        "",
        "P = { type = \"revolute\", between = [\"slider\", \"bob.o\"], limits = { min = -1, max = 1 } }",
        "100 deg",
    )
    .replace("slider = {", "bob = { mass = 1, inertia = 1, points = { o = [0, \"80 mm\"] } }\nslider = {");
    let refused = told(&free, &[]).unwrap_err();
    assert!(refused.contains("the drive leaves other degrees of freedom") && refused.contains("`P.min`"), "{refused}");
    let caught = slider_crank("", "F = { type = \"one_way\", between = [\"ground\", \"crank\"] }", "100 deg");
    let refused = told(&caught, &[]).unwrap_err();
    assert!(refused.contains("freewheel `F`") && refused.contains("the direction of the drive"), "{refused}");
}

/// Relations hold always: the figures are those of the same without play, or without lifting off, which is said.
#[test]
fn couplings_hold_while_the_drive_moves_them() {
    let train = |backlash: &str| {
        format!(
            "name = \"train\"\n[bodies]\none = {{ mass = 1, inertia = 0.01 }}\nother = {{ mass = 1, inertia = 0.02 }}\n[joints]\nO2 = {{ type = \"revolute\", between = [\"ground\", \"one\"] }}\nout = {{ type = \"revolute\", between = [\"ground\", \"other\"] }}\nmesh = {{ type = \"gear\", between = [\"one\", \"other\"], ratio = -0.5 {backlash} }}\n[loads.drag]\ntype = \"torque\"\non = \"other\"\nvalue = \"0.02*cos(2*other.angle) - 0.01\"\n[initial]\n\"one.angle\" = 0\n\"other.angle\" = {{ guess = 0 }}\n"
        )
    };
    let with = figures(&train(", backlash = { play = 0.02, restitution = 0.3 }"), &["--range", "0 deg..360 deg"]);
    let without = figures(&train(""), &["--range", "0 deg..360 deg"]);
    assert_eq!(with["table"], without["table"]);
    assert!(without["stops"].is_null());
    // cos(phi) is a half.
    assert_eq!(with["stops"]["plays"][0]["name"], "mesh");
    let changes = with["stops"]["plays"][0]["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 2);
    near(changes[0].as_f64().unwrap(), 60.0 * DEG);
    near(changes[1].as_f64().unwrap(), 300.0 * DEG);
    let text = told(&train(", backlash = { play = 0.02, restitution = 0.3 }"), &["--range", "0 deg..360 deg"]).unwrap();
    assert!(
        text.contains("`mesh` is analysed in the middle of its backlash") && text.contains("60 deg, 300 deg"),
        "{text}"
    );
    let cam = |unilateral: &str| {
        format!(
            "name = \"cam\"\n[bodies]\ndisc = {{ mass = 1, inertia = 0.01 }}\nlifter = {{ mass = 0.3 }}\n[joints]\nO2 = {{ type = \"revolute\", between = [\"ground\", \"disc\"] }}\nguide = {{ type = \"prismatic\", between = [\"ground\", \"lifter\"], axis = [0, 1] }}\ncontact = {{ type = \"cam\", between = [\"disc\", \"lifter\"], shaft = \"O2\", guide = \"guide\", base = 0.03, roller = 0.01, law = \"0.005*(1 - cos(angle))\" {unilateral} }}\n[loads.spring]\ntype = \"force\"\non = \"lifter\"\nvector = [0, \"2400*(0.02 - lifter.y)\"]\n[initial]\n\"disc.angle\" = 0\n\"lifter.y\" = {{ guess = 0.04 }}\n"
        )
    };
    let fast = ["--speed", "300"];
    let lets_go = figures(&cam(", unilateral = { restitution = 0.2 }"), &fast);
    assert_eq!(lets_go["table"], figures(&cam(""), &fast)["table"]);
    // m a + k (s - s0) is zero: 0.3 0.005 300^2 cos + 2400 (0.025 - 0.005 cos) = 0.
    let off = (-60.0f64 / 123.0).acos() / DEG;
    let said = lets_go["contacts"][0].as_str().unwrap();
    assert!(said.contains("the follower would leave the cam") && said.contains(&format!("{off:.1} deg")), "{said}");
}
