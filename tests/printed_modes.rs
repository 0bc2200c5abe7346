//! Modes of limits, contacts, ropes, play, freewheels and dry friction, as equations and lessons print them.

use crate::support::run::{RUBBING, RUBBING_IN_DRIVEN, formulated, models, scene_of, sound};
use cotree::scene::{Faults, Scene};
use cotree_text::written::{self, EquationFormat};
use cotree_text::{Prose, SymbolNotation};
use serde_json::Value;

/// A slider-crank with friction in a pin and in a long guide, a limit, and a brake whose level is a law.
const CRANK: &str = r#"
name = "rubbing_crank"
gravity = [0, -9.81]
[bodies.crank]
mass = 1.2
inertia = 0.02
points = { inner = [-0.1, 0], outer = [0.1, 0] }
[bodies.rod]
mass = 2.0
inertia = 0.05
points = { big = [-0.25, 0], small = [0.25, 0] }
[bodies.slider]
mass = 1.5
[joints.pivot]
type = "revolute"
between = ["ground", "crank.inner"]
friction = { mu = 0.2, radius = "20 mm" }
[joints.crank_pin]
type = "revolute"
between = ["crank.outer", "rod.big"]
[joints.wrist]
type = "revolute"
between = ["rod.small", "slider"]
[joints.guide]
type = "prismatic"
between = ["ground", "slider"]
axis = [1, 0]
friction = { mu = 0.15, length = "80 mm", coulomb = "1 N" }
limits = { max = "0.72 m", restitution = 0.5 }
[joints.stop]
type = "brake"
between = ["ground", "crank"]
level = "if(t < 1, 0.1, 12)"
[initial]
"crank.angle" = 0.9
"crank.omega" = 5.0
"rod.angle" = { guess = -0.3 }
[outputs]
variables = ["crank.angle", "guide.fn", "guide.mode"]
[experiment]
stop = "1 s"
"#;

/// A ball on a floor with friction, a wheel with a ratchet, a bob on a rope.
const BALL: &str = r#"
name = "ball"
gravity = [0, -9.81]
[bodies]
ball  = { mass = 2.0, inertia = 0.01 }
wheel = { mass = 1.0, inertia = 0.2, points = { rim = [0.3, 0] } }
bob   = { mass = 0.4, inertia = 0.001 }
[joints.axle]
type = "revolute"
between = ["ground", "wheel"]
[joints.ratchet]
type = "one_way"
between = ["ground", "wheel"]
[joints.sling]
type = "rope"
between = ["wheel.rim", "bob"]
length = "0.7 m"
restitution = 0.2
[joints.floor_pad]
type = "contact"
between = ["ground", "ball"]
axis = [1, 0]
radius = "5 cm"
restitution = 0.8
friction = { mu = 0.3 }
[initial]
"ball.x" = 1
"ball.y" = 0.05
"ball.angle" = 0
"ball.vx" = 1
"ball.vy" = 0
"ball.omega" = 0
"wheel.angle" = 0
"wheel.omega" = 2
"bob.x" = 0.3
"bob.y" = -0.5
"bob.vx" = 0.1
"bob.vy" = 0
"bob.angle" = 0
"bob.omega" = 0
[outputs]
variables = ["ball.x", "ball.y", "floor_pad.mode", "sling.mode", "ratchet.mode"]
[experiment]
stop = "1 s"
"#;

/// A block that is pushed askew along a long guide.
const BLOCK: &str = r#"
name = "block"
[bodies.block]
mass = 3.0
inertia = 0.1
points = { corner = [0.1, 0.2] }
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
friction = { mu = 0.3, length = "0.5 m", coulomb = "2 N", static = 1.5 }
[loads.push]
type = "force"
on = "block.corner"
vector = [40, 25]
[initial]
"guide.s" = 0.0
"guide.v" = 0.1
[outputs]
variables = ["guide.s", "guide.force"]
[experiment]
stop = "1 s"
"#;

fn model(name: &str) -> Scene {
    sound(Scene::from_toml(&scene_of(name)))
}

fn scene(text: &str) -> Scene {
    sound(Scene::from_toml(text))
}

fn named(scene: &Scene) -> String {
    written::named(&mut formulated(&scene.resolve().unwrap()), SymbolNotation::Prose(Prose::Text)).unwrap()
}

/// Lines without the spaces that align them.
fn lines(text: &str) -> Vec<String> {
    text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

fn assert_has(text: &str, expected: &[&str]) {
    let lines = lines(text);
    for line in expected {
        assert!(lines.iter().any(|own| own == line), "`{line}` is missing:\n{text}");
    }
}

#[test]
fn a_limit_is_open_or_closed_and_strikes_with_its_restitution() {
    let text = named(&model("end_stop"));
    assert_has(
        &text,
        &[
            "lambda[2] `guide.max` N, force along its coupled direction",
            "guide.max.closed mode 1 while it is closed, else 0",
            "`guide.max` open guide.max.closed = 0, lambda[2] = 0 0 <= guide.max.gap impact: guide.max.rate_after = -restitution*guide.max.rate_before",
            "closed guide.max.closed = 1, guide.max.gap = 0 lambda[2] <= 0 it opens",
            "[M]*({v_after} - {v_before}) + [Phi_q]^T*{P} = 0",
            "guide.max.gap = travel - (l4 + l5)*c1 - (l6 + l7)*c2",
        ],
    );
    assert!(!text.contains("impulse "), "no equation reads the last impulse:\n{text}");
}

/// While it slides the friction is on the right of the equations of motion, by the level; at rest it is the multiplier.
#[test]
fn friction_stands_in_the_equations_with_its_level() {
    assert_has(
        &named(&model("stick_slip")),
        &[
            "[M]*{a} + [Phi_q]^T*{lambda} = {Q} + {Q_friction}",
            "Q_friction[1] = -rubbing.friction.direction*rubbing.friction.level",
            "`rubbing.friction` sticks rubbing.friction.sticks = 1, rubbing.friction.direction = 0, rubbing.friction.rate = 0 abs(lambda[1]) <= static_rubbing*rubbing.friction.level it slides in the direction of the load",
            "slides rubbing.friction.sticks = 0, rubbing.friction.direction = 1, lambda[1] = 0 0 <= rubbing.friction.rate it sticks, or slides back",
            "slides back rubbing.friction.sticks = 0, rubbing.friction.direction = -1, lambda[1] = 0 rubbing.friction.rate <= 0 it sticks, or slides on",
            "rubbing.friction.level = mu*abs(rubbing.fn)",
            "rubbing.friction.rate = rubbing.v",
        ],
    );
}

#[test]
fn levels_are_written_with_their_laws() {
    assert_has(
        &named(&scene(CRANK)),
        &[
            "pivot.friction.level = mu_pivot*r_pivot*sqrt(pivot.fx^2 + pivot.fy^2)",
            "guide.friction.level = max(0, C_guide) + mu_guide*(abs(guide.fn/2 + guide.torque/l_guide)",
            "+ abs(guide.fn/2 - guide.torque/l_guide))",
            "stop.friction.level = max(0, if(t < a_stop, b_stop, d_stop))",
            "[M]*({v_after} - {v_before}) + [Phi_q]^T*{P} - {P_friction} = 0",
            "Q_friction[2] = guide.friction.direction*(l6 + l7)*guide.friction.level*s2",
        ],
    );
    assert_has(
        &named(&scene(BALL)),
        &[
            "`ratchet` free ratchet.closed = 0, lambda[1] = 0 0 <= ratchet.rate it engages at the current angle; with an impact: ratchet.rate_after = 0",
            "caught ratchet.closed = 1, ratchet.rate = 0 lambda[1] <= 0 it disengages",
            "apart floor_pad.friction.sticks = 0, floor_pad.friction.direction = 0, lambda[4] = 0 `floor_pad` is open its friction acts",
            "floor_pad.friction.level = mu_floor_pad*abs(lambda[3])",
            "floor_pad.friction.rate = ball.vx + r_floor_pad*ball.omega",
            "floor_pad.gap = ball.y - r_floor_pad",
            "ratchet.rate = wheel.omega",
        ],
    );
}

/// Numbers of limits, of play and of restitution have names of their own, in the table and in the formulas.
#[test]
fn numbers_of_play_have_names() {
    let text = named(&model("play_train"));
    assert_has(
        &text,
        &[
            "min_first_mesh 0.015 `first_mesh` backlash",
            "Phi[1] = first_mesh.min.closed*(min_first_mesh + middle.angle - i_first_mesh*motor.angle)",
        ],
    );
    assert_has(&named(&model("valve_train")), &["e_cam 0.35 `cam` unilateral"]);
}

/// At the start of a lesson levels are solved for with the motion; they are what their printed laws give.
#[test]
fn printed_laws_of_levels_give_the_levels_of_the_solution() {
    let text = written::steps(&scene(BLOCK), Prose::Text).unwrap();
    let lines = lines(&text);
    let last = |name: &str| -> f64 {
        let start = format!("{name} = ");
        let mut values = lines.iter().filter_map(|line| line.strip_prefix(&start)?.parse().ok());
        values.next_back().unwrap_or_else(|| panic!("`{name}` has no value:\n{text}"))
    };
    let [level, force, torque] = ["guide.friction.level", "guide.fn", "guide.torque"].map(last);
    assert!(force.abs() > 20.0 && torque.abs() > 1.0, "{force} {torque}");
    let tilting = torque / 0.5;
    let law = 2.0 + 0.3 * ((0.5 * force + tilting).abs() + (0.5 * force - tilting).abs());
    assert!((level - law).abs() < 1e-4 * law, "{level} instead of {law}");
    // 3 a = 40 - level
    assert!((3.0 * last("s_3''") - (40.0 - level)).abs() < 1e-3, "{text}");
}

#[test]
fn other_programs_read_the_modes() {
    let json = |scene: &Scene| -> Value {
        serde_json::from_str(&written::equations(scene, EquationFormat::Json).unwrap()).unwrap()
    };
    let rubbing = json(&model("stick_slip"));
    let modes: Vec<&str> =
        rubbing["modes"].as_array().unwrap().iter().map(|own| own["mode"].as_str().unwrap()).collect();
    assert_eq!(modes, ["sticks", "slides", "slides back"]);
    assert_eq!(rubbing["levels"][0]["name"], "rubbing.friction.level");
    assert_eq!(rubbing["modes"][0]["while"]["tree"][0], "<=");
    let stop = json(&model("end_stop"));
    assert_eq!(stop["modes"][1]["of"], "guide.max");
    assert_eq!(stop["modes"][1]["holds"][1]["text"], "guide.max.gap = 0");
    assert_eq!(stop["reactions"][1]["owner"], "guide.max");
    assert!(json(&model("slider_crank")).get("modes").is_none());
}

/// Every check of a lesson holds: the equations in other trees give the same accelerations and reactions in the modes of the start, and the power is right.
#[test]
fn lessons_of_what_has_modes_are_checked() {
    let own = ["end_stop", "play_train", "valve_train", "stick_slip"].map(scene_of);
    for text in own.iter().map(String::as_str).chain([CRANK, BALL, BLOCK]) {
        let lesson = written::steps(&scene(text), Prose::Text).unwrap();
        let checks: Vec<&str> = lesson.lines().filter(|line| line.contains("Check: ")).collect();
        let failed: Vec<&&str> = checks.iter().filter(|line| line.contains("NOT")).collect();
        assert!(checks.len() > 12 && failed.is_empty(), "{failed:#?}");
        for wanted in ["absolute trees", "kinetic energy", "section 7 has the modes"] {
            assert!(lesson.contains(wanted), "`{wanted}` is missing:\n{lesson}");
        }
        assert!(!lesson.contains("singular: there are no numbers"), "{lesson}");
    }
}

#[test]
fn what_rubs_is_called_so_in_the_lesson() {
    let lesson = written::steps(&model("stick_slip"), Prose::Text).unwrap();
    assert_has(
        &lesson,
        &[
            "k8 `rubbing.friction` dry friction C1 -> C2 - mu, static_5 0.3, 1.5",
            "k8 F[k8] = -(lambda[1] + rubbing.friction.direction*rubbing.friction.level)*u[k8]; while it sticks: r[k8] . u[k8] = rubbing.friction.place; u[k8] = R(theta[m1])*(1, 0)",
            "k8 . -rubbing.friction.direction*rubbing.friction.level",
        ],
    );
    // Play: the second angle against the first is no less than the lower flank's, the same relation for the upper one with the other sign.
    let lesson = written::steps(&model("play_train"), Prose::Text).unwrap();
    for edge in ["k12", "k13"] {
        let rows = lines(&lesson);
        let row = rows.iter().find(|line| line.starts_with(edge) && line.contains("while it is closed")).unwrap();
        let relation = format!("theta[{edge}a] = i_9*theta[{edge}b]");
        assert!(row.contains(&relation), "`{relation}` is missing: {row}");
    }
    let lesson = written::steps(&model("end_stop"), Prose::Text).unwrap();
    assert_has(&lesson, &["k13 `guide.max` contact O -> C3 - travel, restitution 0.66 m, 0.6"]);
    // What only touches or rubs has no edge beside that.
    let lesson = written::steps(&scene(BALL), Prose::Text).unwrap();
    assert!(!lesson.contains("takes 0") && !lesson.contains("one-sided relation"), "{lesson}");
}

/// The linear graphs name each edge as the equations do, and list nothing that has no edge.
#[test]
fn graphs_name_what_has_modes() {
    let (graphs, drawing) = cotree_draw::graph::linear_graphs(&scene(BALL)).unwrap();
    let svg = graphs.svg(&drawing);
    for name in [">sling.max<", ">floor_pad<", ">floor_pad.friction<", ">ratchet<"] {
        assert!(svg.contains(name), "{name} is missing:\n{svg}");
    }
    assert!(!svg.contains(">y7<"), "{svg}");
}

#[test]
fn code_says_what_its_factors_are_and_is_refused_where_friction_sticks() {
    let code = written::equations(&model("end_stop"), EquationFormat::C).unwrap();
    assert!(code.contains("guide.max.closed: 1 in the mode in which it holds, else 0"), "{code}");
    assert!(code.contains("lambda: reactions: guide, guide.max\n"), "{code}");
    for notation in [EquationFormat::C, EquationFormat::Fortran, EquationFormat::Rust, EquationFormat::Python] {
        let said = written::equations(&model("stick_slip"), notation).unwrap_err();
        assert_fault(&said, "equations::friction", "`rubbing.friction` sticks or slides");
    }
}

#[test]
fn each_mode_has_reduced_equations_of_its_own() {
    for (name, what) in [("end_stop", "`guide.max` is a unilateral constraint"), ("stick_slip", "sticks or slides")] {
        let scene = model(name);
        let mut formulated = formulated(&scene.resolve().unwrap());
        let list = written::reduced(&mut formulated, SymbolNotation::Prose(Prose::Text), false).unwrap_err();
        assert_fault(&Faults::new(scene.source.clone(), list), "equations::modes", what);
    }
}

fn assert_fault(faults: &Faults, code: &str, message: &str) {
    let [fault] = &faults.list[..] else { panic!("{faults}") };
    assert_eq!(fault.code, code);
    assert!(fault.message.contains(message), "{faults}");
}

#[test]
fn only_what_has_modes_prints_them() {
    for name in models().into_iter().filter(|name| name != RUBBING_IN_DRIVEN) {
        let scene = model(&name);
        let text = written::equations(&scene, EquationFormat::Text).unwrap();
        let has = ["chain_hoist", "end_stop", "play_train", "valve_train"].contains(&name.as_str())
            || RUBBING.contains(&name.as_str());
        assert_eq!(text.contains("\nModes\n"), has, "{name}");
    }
}
