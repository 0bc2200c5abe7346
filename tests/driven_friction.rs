//! Dry friction of what drivers move: the power that it takes, textbooks' screws, rest and locking.

use crate::outside::command::cotree;
use crate::support::run::{compiled, model, started, value};

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_study::motion::{Figures, MotionRequest, study};

/// A press: friction in three pins and in a guide that carries a torque.
const PRESS: &str = r#"
name = "press"
gravity = [0, -9.81]
[bodies.crank]
mass = 1.0
inertia = 0.01
points = { tip = [0.1, 0] }
[bodies.rod]
mass = 0.8
inertia = 0.008
points = { big = [-0.15, 0], small = [0.15, 0] }
[bodies.slider]
mass = 2.0
inertia = 0.01
points = { pin = [0, 0.03] }
[joints.main]
type = "revolute"
between = ["ground", "crank"]
friction = { mu = 0.2, radius = "15 mm" }
[joints.big]
type = "revolute"
between = ["crank.tip", "rod.big"]
friction = { mu = 0.15, radius = "12 mm" }
[joints.small]
type = "revolute"
between = ["rod.small", "slider.pin"]
friction = { mu = 0.1, radius = "10 mm", coulomb = 0.02 }
[joints.guide]
type = "prismatic"
between = ["ground", "slider"]
axis = [1, 0]
friction = { mu = 0.25, length = "80 mm" }
[loads.work]
type = "force"
on = "slider"
vector = ["-30", 0]
[drivers.turn]
joint = "main"
angle = "5*t"
[initial]
"rod.angle" = { guess = -0.1 }
[outputs]
variables = ["turn.torque", "slider.ax", "guide.force", "guide.fn", "guide.torque", "guide.v", "main.torque", "main.fx", "main.fy", "main.omega", "big.torque", "big.fx", "big.fy", "big.omega", "small.torque", "small.fx", "small.fy", "small.omega"]
[experiment]
stop = 2.0
tolerance = 1e-10
"#;

fn is_undefined(run: &mut Instance, name: &str) -> bool {
    let variable = run.variable(name).unwrap();
    matches!(run.get(variable), Err(InstanceError::Undefined { .. }))
}

fn frictionless(text: &str) -> String {
    text.lines().filter(|line| !line.starts_with("friction")).map(|line| format!("{line}\n")).collect()
}

fn levels(run: &mut Instance) -> f64 {
    let mut of = |name: &str| value(run, name);
    let mut pin = |joint: &str| of(&format!("{joint}.fx")).hypot(of(&format!("{joint}.fy")));
    let pins = [("main", 0.0, 0.2 * 0.015), ("big", 0.0, 0.15 * 0.012), ("small", 0.02, 0.1 * 0.01)];
    let pins = pins.map(|(joint, coulomb, share)| (joint, coulomb + share * pin(joint)));
    let (normal, torque) = (of("guide.fn"), of("guide.torque"));
    let guide = 0.25 * ((0.5 * normal + torque / 0.08).abs() + (0.5 * normal - torque / 0.08).abs());
    let mut power = guide * of("guide.v").abs();
    assert!((of("guide.force").abs() - guide).abs() < 1e-9 * guide, "{guide}");
    for (joint, level) in pins {
        let torque = of(&format!("{joint}.torque"));
        let rate = of(&format!("{joint}.omega"));
        assert!(torque * rate < 0.0, "{joint}: {torque} at {rate}");
        // The driver lies beside the pin that it turns.
        assert!((torque.abs() - level).abs() < 1e-9 * level, "{joint}: {torque}, {level}");
        power += level * rate.abs();
    }
    power
}

/// The motion is the same with friction and without, so the drive's power differs by that of what slides, whose levels follow from the reactions; the slider's own balance holds the reactions to that.
#[test]
fn the_drive_gives_what_friction_takes() {
    let mut with = started(&model(PRESS), None, 2.0, 1e-10);
    let mut without = started(&model(&frictionless(PRESS)), None, 2.0, 1e-10);
    for step in 0..40 {
        let time = 0.05 * f64::from(step);
        [&mut with, &mut without]
            .into_iter()
            .filter(|run| run.time() < time)
            .for_each(|run| run.step_to(time).unwrap());
        let [driven, ideal] = [&mut with, &mut without].map(|run| 5.0 * value(run, "turn.torque"));
        let power = levels(&mut with);
        assert!((driven - ideal - power).abs() < 1e-9 * (driven.abs() + power), "{time}: {driven} {ideal} {power}");
        let mut of = |name: &str| value(&mut with, name);
        let along = of("guide.force") + of("small.fx") - 30.0 - 2.0 * of("slider.ax");
        let across = of("guide.fn") + of("small.fy") - 2.0 * 9.81;
        assert!(along.abs() < 1e-9 && across.abs() < 1e-9, "{time}: {along} {across}");
    }
}

/// To and fro about 0.4 rad: where the drive turns around friction is that of the way on, and where it stays there is none that is determined.
#[test]
fn what_turns_around_has_the_friction_of_the_way_on() {
    let wheel = |law: &str| {
        format!(
            r#"
name = "wheel"
gravity = [0, -9.81]
[bodies.wheel]
mass = 4.0
inertia = 0.05
[joints.pin]
type = "revolute"
between = ["ground", "wheel"]
friction = {{ mu = 0.3, radius = "12 mm" }}
[drivers.turn]
joint = "pin"
angle = "{law}"
[outputs]
variables = ["turn.torque", "wheel.omega"]
[experiment]
stop = 4.0
"#
        )
    };
    let level = 0.3 * 0.012 * 4.0 * 9.81;
    let mut run = started(&model(&wheel("0.4*cos(t)")), None, 4.0, 1e-8);
    for (time, way) in [(0.0, -1.0), (1.0, -1.0), (3.0, -1.0), (3.5, 1.0)] {
        if time > 0.0 {
            run.step_to(time).unwrap();
        }
        let expected = -0.05 * 0.4 * time.cos() + way * level;
        let found = value(&mut run, "turn.torque");
        assert!((found - expected).abs() < 1e-12, "{time}: {found}, expected {expected}");
    }
    let mut run = started(&model(&wheel("if(t < 1, 0.2*(1 - t)^3, 0)")), None, 4.0, 1e-8);
    run.step_to(0.5).unwrap();
    let expected = 0.05 * 0.6 - level;
    assert!((value(&mut run, "turn.torque") - expected).abs() < 1e-12);
    run.step_to(2.0).unwrap();
    assert!(is_undefined(&mut run, "turn.torque"));
    assert_eq!(value(&mut run, "wheel.omega"), 0.0);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("still.toml"), wheel("0.2")).unwrap();
    let checked = String::from_utf8(cotree(folder.path(), &["check", "still.toml"]).stdout).unwrap();
    assert!(
        checked.contains("`pin.friction`: kept at rest by drivers at the start") && checked.contains("not determined"),
        "{checked}"
    );
    let said = String::from_utf8(cotree(folder.path(), &["simulate", "still.toml"]).stderr).unwrap();
    assert!(said.contains("`turn.torque` has no value") && said.contains("dry friction of a driven motion"), "{said}");
}

fn jack(lead: f64, rate: f64) -> String {
    format!(
        r#"
name = "jack"
gravity = [0, -9.81]
[bodies.screw]
mass = 0.5
inertia = 0.001
[bodies.nut]
mass = 50.0
[joints.shaft]
type = "revolute"
between = ["ground", "screw"]
[joints.rail]
type = "prismatic"
between = ["ground", "nut"]
axis = [0, 1]
[joints.thread]
type = "screw"
between = ["screw", "nut"]
axis = [0, 1]
lead = {lead:?}
friction = {{ mu = 0.15, radius = "10 mm" }}
[drivers.turn]
joint = "shaft"
angle = "{rate}*t"
[outputs]
variables = ["turn.torque", "nut.y"]
[experiment]
stop = 3
"#
    )
}

fn of_motion(text: &str, request: &MotionRequest) -> Result<Figures, String> {
    let scene = Scene::from_toml(text).unwrap();
    study(&scene, request).map_err(|failure| failure.to_string())
}

/// Raising and lowering torques of a square thread, and its efficiency (Norton, *Machine Design*, section 15.2).
#[test]
fn a_jack_has_the_torques_of_textbooks() {
    let (radius, mu, weight) = (0.01, 0.15, 50.0 * 9.81);
    let turn = std::f64::consts::TAU;
    for lead in [0.005, 0.05] {
        let raise = weight * radius * (turn * mu * radius + lead) / (turn * radius - mu * lead);
        let lower = weight * radius * (turn * mu * radius - lead) / (turn * radius + mu * lead);
        for (rate, expected) in [(2.0, raise), (-2.0, -lower)] {
            let mut run = started(&model(&jack(lead, rate)), None, 3.0, 1e-8);
            run.step_to(1.0).unwrap();
            let found = value(&mut run, "turn.torque");
            assert!((found - expected).abs() < 1e-10 * expected.abs(), "{lead} {rate}: {found}, expected {expected}");
        }
        let figures =
            of_motion(&jack(lead, 2.0), &MotionRequest { output: Some("rail".into()), ..MotionRequest::default() })
                .unwrap();
        let friction = figures.friction.unwrap();
        let efficiency = weight * lead / (turn * raise);
        assert!((friction.efficiency.unwrap() - efficiency).abs() < 1e-9, "{friction:?} {efficiency}");
        assert!((friction.loss - (turn * raise - weight * lead)).abs() < 1e-8, "{friction:?}");
        assert_eq!(friction.locked, Some(if lower > 0.0 { 1.0 } else { 0.0 }), "{lead}");
    }
}

/// A wedge of two sliders and a rod: the driven one goes along x, the other carries a load along y in a guide with mu. The rod pushes at the angle a from x, and locks where tan a is below mu.
const WEDGE: &str = r#"
name = "wedge"
gravity = [0, 0]
[bodies.low]
mass = 1e-9
[bodies.high]
mass = 1e-9
[bodies.rod]
mass = 1e-9
inertia = 1e-12
points = { a = [0.5, 0], b = [-0.5, 0] }
[joints.slide]
type = "prismatic"
between = ["ground", "low"]
axis = [1, 0]
[joints.wall]
type = "prismatic"
between = ["ground", "high"]
axis = [0, 1]
friction = { mu = 0.5 }
[joints.one]
type = "revolute"
between = ["low", "rod.a"]
[joints.other]
type = "revolute"
between = ["high", "rod.b"]
[loads.weight]
type = "force"
on = "high"
vector = [0, -100]
[drivers.push]
joint = "slide"
displacement = "0.99 - 0.2*t"
[initial]
"high.y" = { guess = 0.14 }
[outputs]
variables = ["push.force", "high.y", "wall.fn"]
[experiment]
stop = 4
step = 0.1
tolerance = 1e-10
"#;

#[test]
fn a_wedge_locks_where_its_slope_is_below_mu() {
    let compiled = compiled(WEDGE);
    let mut run = started(&model(WEDGE), None, 4.0, 1e-10);
    let mut locked = 0;
    for step in 1..=40 {
        run.step_to(0.1 * f64::from(step)).unwrap();
        let x: f64 = 0.99 - 0.02 * f64::from(step);
        let y = (1.0 - x * x).sqrt();
        assert!((value(&mut run, "high.y") - y).abs() < 1e-9);
        // Up: S sin a = 100 + mu S cos a, and the drive pushes with S cos a towards the wall.
        let rest = y - 0.5 * x;
        if rest > 0.0 {
            let (expected, found) = (-100.0 * x / rest, value(&mut run, "push.force"));
            assert!((found - expected).abs() < 1e-4 * expected.abs(), "{x}: {found}, expected {expected}");
        } else {
            assert!(is_undefined(&mut run, "push.force"), "{x}");
            locked += 1;
        }
    }
    assert!(locked > 3, "{}", compiled.program.constraints.len());
    let request = MotionRequest { range: Some([0.99, 0.5]), output: Some("wall".into()), ..MotionRequest::default() };
    let said = of_motion(WEDGE, &request).unwrap_err();
    assert!(said.contains("between 0.99") && said.contains("friction locks it") && said.contains("`wall`"), "{said}");
    let free = MotionRequest { range: Some([0.85, 0.5]), ..request };
    assert!(of_motion(WEDGE, &free).unwrap().friction.unwrap().loss > 0.0);
}

/// With friction the transmission angle is that of the linkage, and the drive's effort without it stands beside.
#[test]
fn figures_of_the_linkage_do_not_depend_on_friction() {
    let request = MotionRequest { output: Some("guide".into()), ..MotionRequest::default() };
    let [with, without] = [PRESS.to_owned(), frictionless(PRESS)].map(|text| of_motion(&text, &request).unwrap());
    assert_eq!(with.transmission.len(), without.transmission.len());
    for (one, other) in with.transmission.iter().zip(&without.transmission) {
        assert!((one.min.value - other.min.value).abs() < 1e-9 && (one.max.value - other.max.value).abs() < 1e-9);
    }
    let column = |figures: &Figures, name: &str| {
        figures.table.iter().find(|column| column.name == name).unwrap_or_else(|| panic!("{name}")).values.clone()
    };
    let (ideal, beside) = (column(&without, "drive"), column(&with, "drive without friction"));
    assert!(ideal.iter().zip(&beside).all(|(one, other)| (one - other).abs() < 1e-9));
    let friction = with.friction.unwrap();
    assert!(friction.efficiency.is_none() && friction.work.abs() < 1e-6 && friction.loss > 1.0, "{friction:?}");
    assert!(without.friction.is_none());
    let still = MotionRequest { speed: Some(0.0), ..request };
    let said = of_motion(PRESS, &still).unwrap_err();
    assert!(said.contains("give a positive speed"), "{said}");
}

/// The press with a light pendulum that hangs on its slider: what the drive gives is as without it, though the mechanism moves freely now, and what the linkage rubs turns at events.
#[test]
fn friction_of_what_drivers_move_counts_beside_free_motion() {
    let pendulum = "[bodies.bob]\nmass = 1e-9\ninertia = 1e-10\npoints = { top = [0, 0.3] }\n[joints.hinge]\ntype = \"revolute\"\nbetween = [\"slider\", \"bob.top\"]\n[drivers.turn]";
    let text = PRESS.replace("[drivers.turn]", pendulum);
    let text = text.replace("[initial]", "[initial]\n\"bob.angle\" = 0.2\n\"bob.omega\" = 0.0");
    let [mut alone, mut beside] = [PRESS, &text].map(|text| started(&model(text), None, 2.0, 1e-10));
    for step in 1..40 {
        let time = 0.05 * f64::from(step);
        for name in ["turn.torque", "main.torque", "guide.force", "small.fx"] {
            let [one, other] = [&mut alone, &mut beside].map(|run| {
                if run.time() < time {
                    run.step_to(time).unwrap();
                }
                value(run, name)
            });
            assert!((one - other).abs() < 1e-6 * one.abs().max(1.0), "{name} at {time}: {one} {other}");
        }
    }
}

/// A cart on a rough rail that a driver moves to and fro, with a pendulum on it: the drive gives mu times the force between cart and rail more than without friction, against the motion; nothing at rest is known.
#[test]
fn a_driven_cart_rubs_below_its_pendulum() {
    let cart = |friction: &str, more: &str| {
        format!(
            r#"
name = "cart"
gravity = [0, -9.81]
[bodies.cart]
mass = 2.0
inertia = 1.0
[bodies.bob]
mass = 1.5
inertia = 0.1
points = {{ top = [0, 0.4] }}
[joints.rail]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
{friction}
[joints.hinge]
type = "revolute"
between = ["cart", "bob.top"]
{more}
[drivers.push]
joint = "rail"
displacement = "0.3*sin(2*t)"
[initial]
"bob.angle" = 0.4
"bob.omega" = 0.0
[outputs]
variables = ["push.force", "rail.force", "rail.fn", "rail.v", "rail.sliding", "bob.angle", "bob.omega"]
[experiment]
stop = 4.0
tolerance = 1e-11
"#
        )
    };
    for pin in ["", "friction = { mu = 0.2, radius = 0.01 }"] {
        let [mut rough, mut smooth] = ["friction = { mu = 0.3 }", ""].map(|rail| {
            let text = cart(rail, pin);
            let text = if rail.is_empty() { text.replace("\"rail.sliding\", ", "") } else { text };
            started(&model(&text), Some(cotree_fmu::program::Engine::Dop853), 4.0, 1e-11)
        });
        for time in [0.1, 0.7, 0.9, 1.5, 2.3, 3.9] {
            [&mut rough, &mut smooth].into_iter().for_each(|run| run.step_to(time).unwrap());
            let rate = 0.6 * (2.0 * time).cos();
            let level = 0.3 * value(&mut rough, "rail.fn").abs();
            let more = value(&mut rough, "push.force") - value(&mut smooth, "push.force");
            assert!((more - level * rate.signum()).abs() < 1e-8 * level, "{pin} {time}: {more} {level}");
            assert_eq!(value(&mut rough, "rail.sliding"), rate.signum());
            let [one, other] = [&mut rough, &mut smooth].map(|run| value(run, "bob.angle"));
            assert!((one - other).abs() < 1e-8, "{pin} {time}: {one} {other}");
        }
    }
    // At its turn the force is that of the way on; where it stays there is none.
    let still = cart("friction = { mu = 0.3 }", "").replace("0.3*sin(2*t)", "0.3*smoothstep(t/1[s])");
    let mut run = started(&model(&still), None, 2.0, 1e-9);
    run.step_to(0.5).unwrap();
    assert!(value(&mut run, "push.force").is_finite());
    run.step_to(1.5).unwrap();
    assert!(is_undefined(&mut run, "push.force") && value(&mut run, "bob.angle").is_finite());
    // Where what moves freely follows from that force it is refused, with the way out.
    let carried = "friction = { mu = 0.2, radius = 0.01 }\n[loads.brake]\ntype = \"torque\"\non = \"bob\"\nvalue = \"0.01*push.force\"";
    let refused = Scene::from_toml(&cart("friction = { mu = 0.3 }", carried)).and_then(|scene| compile(&scene));
    let refused = refused.unwrap_err().to_string();
    for word in ["scene::friction", "`rail.friction` has dry friction in a driven motion", "velocity"] {
        assert!(refused.contains(word), "{refused}");
    }
    for arguments in [&["linearize", "scene.toml"][..], &["show", "scene.toml", "--equations", "text"]] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("scene.toml"), cart("friction = { mu = 0.3 }", "")).unwrap();
        let output = cotree(folder.path(), arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.contains("`rail"), "{said}");
    }
}

/// At rest nothing says what drivers have to overcome.
#[test]
fn analysis_of_driven_friction_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("press.toml"), PRESS).unwrap();
    for command in ["equilibrium", "linearize", "modes"] {
        let output = cotree(folder.path(), &[command, "press.toml"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.contains("acts on a driven motion"), "{command}: {said}");
    }
}
