//! Loads and states that read accelerations and reactions: against masses in their place, closed forms, momenta and works, and in other trees.

use crate::outside::command::cotree;
use crate::support::linkage;
use crate::support::run::{model, started, value};

use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::program::Engine;
use cotree_study::analysis::Study;

/// A four-bar that falls, with a torque on its coupler, an inertia of that, and other tables at its end.
fn four_bar(torque: &str, inertia: f64, more: &str) -> String {
    let load = match torque {
        "" => String::new(),
        law => format!("[loads.extra]\ntype = \"torque\"\non = \"coupler\"\nvalue = {law:?}\n"),
    };
    // A driver gives the crank's angle itself.
    let is_driven = more.contains("drivers.turn");
    let (drive, crank) = match is_driven {
        true => ("\"turn.torque\", ", ""),
        false => ("", "\"crank.angle\" = \"50 deg\"\n\"crank.omega\" = 3.0\n"),
    };
    let rest = format!(
        r#"{load}[outputs]
variables = ["crank.angle", "rocker.omega", "coupler.alpha", "pin1.fx", "pin1.fy", "pin3.fx", "pin4.fy", {drive}"crank.vx", "crank.vy", "crank.y", "crank.omega", "coupler.vx", "coupler.vy", "coupler.y", "coupler.omega", "rocker.vx", "rocker.vy", "rocker.y"]
[experiment]
stop = 1.0
tolerance = 1e-11
{more}"#
    );
    linkage::four_bar(&[const { String::new() }; 4], inertia, crank, &rest)
}

const READ: [&str; 6] = ["crank.angle", "rocker.omega", "coupler.alpha", "pin1.fx", "pin1.fy", "pin3.fx"];

fn end(text: &str, engine: Option<Engine>, time: f64) -> (Instance, Vec<f64>) {
    let mut run = started(&model(text), engine, time, 1e-11);
    run.step_to(time).unwrap();
    let values = READ.map(|name| value(&mut run, name)).to_vec();
    (run, values)
}

fn close(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= tolerance * expected.abs().max(1.0), "{what}: {found}, {expected}");
    }
}

/// A torque of -J alpha is an inertia: the motion and every reaction are those of a heavier coupler, by all methods and in all trees.
#[test]
fn a_torque_against_its_acceleration_is_an_inertia() {
    let (_, heavier) = end(&four_bar("", 0.04 + 0.1, ""), None, 1.0);
    for engine in [Engine::Dop853, Engine::Radau] {
        let (_, found) = end(&four_bar("-0.1*coupler.alpha", 0.04, ""), Some(engine), 1.0);
        close(&format!("{engine:?}"), &found, &heavier, 2e-8);
    }
    for preset in ["absolute", "joint", "cheapest"] {
        let text = four_bar("-0.1*coupler.alpha", 0.04, &format!("[coordinates]\npreset = {preset:?}\n"));
        close(preset, &end(&text, None, 1.0).1, &heavier, 2e-8);
    }
}

/// What reads reactions has the same motion in all trees, though the reactions are other sums in each; the balance of the crank holds with the values that are reported.
#[test]
fn a_load_by_reactions_is_the_same_in_all_trees() {
    for law in
        ["0.02*pin1.fx - 0.01*pin3.fy", "-0.01*hypot(pin3.fx, pin3.fy)*tanh(coupler.angle)", "min(0.05*pin1.fy, 0.4)"]
    {
        let (_, recommended) = end(&four_bar(law, 0.04, ""), None, 1.0);
        for preset in ["absolute", "joint"] {
            let text = four_bar(law, 0.04, &format!("[coordinates]\npreset = {preset:?}\n"));
            close(law, &end(&text, None, 1.0).1, &recommended, 1e-8);
        }
    }
}

/// Friction by hand in a pin that turns one way is the friction that the program has itself.
#[test]
fn friction_by_hand_is_that_of_a_pin() {
    let scene = |friction: &str, load: &str| {
        format!(
            r#"
name = "pendulum"
gravity = [0, -9.81]
[bodies.bob]
mass = 2.0
inertia = 0.1
points = {{ hinge = [0, 0.5] }}
[joints.pin]
type = "revolute"
between = ["ground", "bob.hinge"]
{friction}
{load}
[initial]
"pin.angle" = 0.4
"pin.omega" = 9.0
[outputs]
variables = ["pin.angle", "pin.omega", "pin.fx", "pin.fy"]
[experiment]
stop = 0.4
tolerance = 1e-11
"#
        )
    };
    let by_hand = "[loads.rub]\ntype = \"torque\"\non = \"bob\"\nvalue = \"-0.3*0.02*hypot(pin.fx, pin.fy)\"\n";
    let [own, hand] = [scene("friction = { mu = 0.3, radius = 0.02 }", ""), scene("", by_hand)].map(|text| {
        let mut run = started(&model(&text), Some(Engine::Dop853), 0.4, 1e-11);
        run.step_to(0.4).unwrap();
        ["pin.angle", "pin.omega", "pin.fx", "pin.fy"].map(|name| value(&mut run, name))
    });
    assert!(own[1] > 1.0, "it still turns: {own:?}");
    close("pin", &hand, &own, 1e-9);
}

/// An inerter of 3 kg between a mass and the wall, by the acceleration of its own ends; and forces as vectors, in the axes of the world and of a body.
#[test]
fn forces_along_a_line_and_as_vectors_read_accelerations() {
    let scene = |load: &str| {
        format!(
            r#"
name = "mass"
gravity = [0, 0]
[ground.points]
wall = [-1, 0]
[bodies.block]
mass = 2.0
inertia = 1.0
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[loads.spring]
type = "spring"
between = ["ground.wall", "block"]
stiffness = 80.0
length = 1.0
[loads.inerter]
{load}
[initial]
"guide.s" = 0.1
[outputs]
variables = ["guide.s", "guide.v", "guide.a"]
[experiment]
stop = 1.0
tolerance = 1e-11
"#
        )
    };
    let laws = [
        "type = \"actuator\"\nbetween = [\"ground.wall\", \"block\"]\nforce = \"-3*inerter.ax\"",
        "type = \"force\"\non = \"block\"\nvector = [\"-3*guide.a\", \"guide.fn\"]",
        "type = \"force\"\non = \"block\"\nframe = \"body\"\nvector = [\"-3*block.ax\", 1]",
    ];
    let omega = (80.0_f64 / 5.0).sqrt();
    for law in laws {
        let mut run = started(&model(&scene(law)), None, 1.0, 1e-11);
        run.step_to(1.0).unwrap();
        let found = ["guide.s", "guide.v", "guide.a"].map(|name| value(&mut run, name));
        let (sine, cosine) = omega.sin_cos();
        close(law, &found, &[0.1 * cosine, -0.1 * omega * sine, -0.1 * omega * omega * cosine], 1e-9);
    }
}

/// The integral of a reaction is a change of momentum; where a driver turns the crank, the integral of its power is the change of the energy.
#[test]
fn states_integrate_reactions() {
    let states = "[states.px]\nrate = \"pin1.fx + pin4.fx\"\nunit = \"N.s\"\n[states.work]\nrate = \"pin2.fx*crank.b.vx + pin2.fy*crank.b.vy\"\nunit = \"J\"\n";
    let text = four_bar("", 0.04, states);
    let mut run = started(&model(&text), None, 1.0, 1e-11);
    let momentum = |run: &mut Instance| {
        let mut of = |name: &str| value(run, name);
        1.0 * of("crank.vx") + 1.5 * of("coupler.vx") + 1.2 * of("rocker.vx")
    };
    // Of the coupler and the rocker: what the crank does to them, less what gravity takes.
    let energy = |run: &mut Instance| {
        let mut of = |name: &str| value(run, name);
        let mut body = |name: &str, mass: f64, inertia: f64| {
            let [vx, vy, omega, y] = ["vx", "vy", "omega", "y"].map(|own| of(&format!("{name}.{own}")));
            0.5 * mass * (vx * vx + vy * vy) + 0.5 * inertia * omega * omega + mass * 9.81 * y
        };
        body("coupler", 1.5, 0.04) + body("rocker", 1.2, 0.03)
    };
    let before = [momentum(&mut run), energy(&mut run)];
    run.step_to(1.0).unwrap();
    let after = [momentum(&mut run), energy(&mut run)];
    let found = [value(&mut run, "px"), value(&mut run, "work")];
    close("integrals", &found, &[after[0] - before[0], after[1] - before[1]], 1e-8);
}

/// Where drivers determine the motion a load changes the effort of the drive at once, and a state that reads it takes the work.
#[test]
fn driven_mechanisms_have_such_loads_and_states() {
    let drive = "[drivers.turn]\njoint = \"pin1\"\nangle = \"50[deg] + 3*t + 2*t^2\"\n";
    let scene = |torque: &str, inertia: f64, more: &str| four_bar(torque, inertia, &format!("{drive}{more}"));
    let work = "[states.work]\nrate = \"turn.torque*crank.omega\"\nunit = \"J\"\n";
    let mut heavier = started(&model(&scene("", 0.14, work)), None, 1.0, 1e-11);
    let mut read = started(&model(&scene("-0.1*coupler.alpha", 0.04, work)), None, 1.0, 1e-11);
    let mut plain = started(&model(&scene("-0.1*coupler.alpha", 0.04, "")), None, 1.0, 1e-11);
    for time in [0.0, 0.3, 1.0] {
        let found: Vec<Vec<f64>> = [&mut heavier, &mut read, &mut plain]
            .into_iter()
            .map(|run| {
                if time > 0.0 {
                    run.step_to(time).unwrap();
                }
                ["turn.torque", "pin3.fx", "pin4.fy"].iter().map(|name| value(run, name)).collect()
            })
            .collect();
        close("with a state", &found[1], &found[0], 1e-9);
        close("without", &found[2], &found[0], 1e-9);
        close("work", &[value(&mut read, "work")], &[value(&mut heavier, "work")], 1e-9);
    }
}

/// Derivatives by a parameter of such a law against differences.
#[test]
fn sensitivities_are_those_of_differences() {
    let text = four_bar("0.02*pin1.fx - J*coupler.alpha", 0.04, "[parameters]\nJ = \"0.1 kg.m2\"\n");
    let study = |text: &str| Study::new(&Scene::from_toml(text).unwrap()).unwrap();
    let found = study(&text).sensitivities(&["J".to_owned()], &[0.5, 1.0]).unwrap();
    let at = |size: f64| {
        let text = text.replace("0.1 kg.m2", &format!("{} kg.m2", 0.1 + size));
        let mut run = started(&model(&text), None, 1.0, 1e-12);
        [0.5, 1.0].map(|time| {
            run.step_to(time).unwrap();
            READ.map(|name| value(&mut run, name))
        })
    };
    let (more, less) = (at(1e-4), at(-1e-4));
    for time in 0..2 {
        for (index, name) in READ.iter().enumerate() {
            let difference = (more[time][index] - less[time][index]) / 2e-4;
            let derivative = found.derivatives[time][(index, 0)];
            let size = difference.abs().max(1.0);
            assert!((derivative - difference).abs() < 2e-5 * size, "{name}: {derivative}, {difference}");
        }
    }
}

fn said(text: &str, arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    let output = cotree(folder.path(), arguments);
    assert!(!output.status.success(), "{arguments:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    said.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// What has no such value, or would have to act at an instant, is refused with the reason.
#[test]
fn what_cannot_be_read_is_refused() {
    let law = "0.02*pin1.fx";
    let stop = "[joints.p5]\ntype = \"prismatic\"\nbetween = [\"ground\", \"block\"]\naxis = [1, 0]\nlimits = { max = 1 }\n[bodies.block]\nmass = 1\n";
    let twice = "[joints.again]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank.a\"]\n";
    let own = "[loads.other]\ntype = \"torque\"\non = \"rocker\"\nvalue = \"2*other.torque\"\n";
    let kick = "[bodies.bar]\nmass = 1\ninertia = 1\n[joints.arm]\ntype = \"revolute\"\nbetween = [\"ground\", \"bar\"]\n[drivers.kick]\njoint = \"arm\"\nangle = \"abs(t - 0.5)\"\n";
    let cases = [
        (four_bar(law, 0.04, stop), "which are impulsive where `p5.max` closes"),
        (four_bar(law, 0.04, twice), "which the equations of motion do not determine: the joint is redundant"),
        (four_bar(law, 0.04, own), "depends on itself"),
        (four_bar(law, 0.04, kick), "which are impulsive where the law of driver `kick` is discontinuous"),
        (
            four_bar("1", 0.04, &format!("{twice}[states.z]\nrate = \"pin1.fx\"\n")),
            "`rate` of state `z` reads `pin1.fx`",
        ),
    ];
    for (text, words) in cases {
        let said = said(&text, &["check", "scene.toml"]);
        assert!(said.contains(words), "{words}: {said}");
    }
    let text = four_bar(law, 0.04, "");
    for arguments in [
        &["show", "scene.toml", "--equations", "c"][..],
        &["show", "scene.toml", "--equations", "text", "--minimal"],
        &["show", "scene.toml", "--steps", "text"],
    ] {
        let said = said(&text, arguments);
        assert!(said.contains("load `extra` reads an acceleration or a reaction"), "{arguments:?}: {said}");
    }
}

/// Of a wheel of inertia J under 0.5 + k |alpha| the acceleration is 0.5/(J - k), as long as that is positive; beyond there is none, and that is said.
#[test]
fn a_law_without_a_solution_is_refused() {
    let wheel = |k: f64| {
        format!(
            "name = \"wheel\"\n[bodies.wheel]\nmass = 1\ninertia = 1\n[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"wheel\"]\n\
             [loads.push]\ntype = \"torque\"\non = \"wheel\"\nvalue = \"0.5 + {k}*abs(wheel.alpha)\"\n[outputs]\nvariables = [\"wheel.omega\"]\n[experiment]\nstop = 1\n"
        )
    };
    let mut run = started(&model(&wheel(0.6)), None, 1.0, 1e-9);
    run.step_to(1.0).unwrap();
    close("omega", &[value(&mut run, "wheel.omega")], &[0.5 / 0.4], 1e-9);
    let said = said(&wheel(2.0), &["simulate", "scene.toml"]);
    assert!(said.contains("or read accelerations or reactions and have no solution"), "{said}");
}
