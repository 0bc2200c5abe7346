//! What only looks like a singular pose is none.

use std::f64::consts::PI;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::{Body, Joint, Load, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use crate::support::random::Random;
use crate::support::run::{started, value};

const STOP: f64 = 4.0;

fn heavy_slider(preset: Option<&str>) -> Scene {
    let bar = |half: f64, inertia: f64| {
        Body::new().mass(1.0).inertia(inertia).point("a", [-half, 0.0]).point("b", [half, 0.0])
    };
    let scene = Scene::new("heavy_slider")
        .gravity([0.0, -9.81])
        .ground_point("axle", [0.0, 0.0])
        .body("crank", bar(0.2, 0.02))
        .body("rod", bar(0.6, 0.15))
        .body("slider", Body::new().mass(5e5).point("pin", [0.0, 0.0]))
        .revolute("main", "ground.axle", "crank.a")
        .revolute("crank_pin", "crank.b", "rod.a")
        .revolute("slider_pin", "rod.b", "slider.pin")
        .prismatic("guide", "ground", "slider", [1.0, 0.0])
        .initial("crank.angle", 0.8)
        .initial("crank.omega", 4.0)
        .guess("rod.angle", -0.24)
        .guess("slider.x", 1.44)
        .output("crank.angle")
        .stop(STOP);
    match preset {
        Some(preset) => scene.preset(preset),
        None => scene,
    }
}

fn model(scene: &Scene) -> Arc<Model> {
    let compiled = compile(scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    Arc::new(Model::new(compiled.program).expect("a sound program"))
}

/// The crank's angle at 100 points.
fn run(model: &Arc<Model>, tolerance: f64) -> Vec<f64> {
    let mut instance = Instance::new(model.clone());
    instance.setup(0.0, Some(STOP), Some(tolerance)).expect("times");
    instance.initialise().expect("consistent");
    let variable = instance.variable("crank.angle").expect("an output");
    let value = |point: u32| {
        instance.step_to(0.01 * STOP * f64::from(point)).unwrap_or_else(|error| panic!("{tolerance:e}: {error}"));
        instance.get(variable).expect("defined")
    };
    (1..=100).map(value).collect()
}

fn difference(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).fold(0.0, |worst, (one, other)| worst.max((one - other).abs()))
}

/// Masses of which one is a million times the other change how close the loop equations seem to be to each other, and nothing else.
#[test]
fn very_different_masses_are_no_singular_pose() {
    let [absolute, recommended] = [Some("absolute"), None].map(|preset| model(&heavy_slider(preset)));
    for tolerance in [1e-6, 1e-8, 1e-10] {
        let angles = [&absolute, &recommended].map(|model| run(model, tolerance));
        let error = difference(&angles[0], &angles[1]);
        assert!(error < 1000.0 * tolerance + 1e-6, "{tolerance:e}: {error:e}");
    }
}

/// Two gears on a turning arm, and a platform on three cranks, of any length [m] and mass [kg], that turn as fast as others.
fn of_size(length: f64, mass: f64) -> Scene {
    let inertia = 0.1 * mass * length * length;
    let weight = mass * length;
    let body = |name: &str, points: &str| {
        format!("[bodies.{name}]\nmass = {mass:e}\ninertia = {inertia:e}\npoints = {{ {points} }}\n")
    };
    let joint =
        |name: &str, kind: &str, ends: [&str; 2]| format!("[joints.{name}]\ntype = \"{kind}\"\nbetween = {ends:?}\n");
    let mut text = format!("format = 1\nname = \"of_size\"\ngravity = [0, {:e}]\n[ground.points]\n", -length);
    for k in 0..3 {
        text += &format!("g{k} = [{:e}, {:e}]\n", f64::from(k) * length, f64::from(k * k) * length);
    }
    text += &body("arm", &format!("e = [{length:e}, 0]"));
    text += &(body("a", "c = [0, 0]") + &body("b", "c = [0, 0]"));
    text += &body(
        "platform",
        &[0, 1, 2].map(|k| format!("p{k} = [{:e}, {:e}]", f64::from(k) * length, f64::from(k * k) * length)).join(", "),
    );
    text += &(joint("ja", "revolute", ["ground", "a"]) + &joint("jc", "revolute", ["ground", "arm"]));
    text += &joint("jb", "revolute", ["arm.e", "b"]);
    text += &(joint("mesh", "gear", ["a", "b"]) + "carrier = \"arm\"\nratio = -2\n");
    for k in 0..3 {
        text += &body(&format!("crank_{k}"), &format!("a = [0, 0], b = [{length:e}, 0]"));
        text += &joint(&format!("low_{k}"), "revolute", [&format!("ground.g{k}"), &format!("crank_{k}.a")]);
        text += &joint(&format!("high_{k}"), "revolute", [&format!("crank_{k}.b"), &format!("platform.p{k}")]);
    }
    text += &format!("[loads.motor]\ntype = \"torque\"\non = \"a\"\nvalue = {:e}\n", weight * length);
    text += "[initial]\n\"a.omega\" = 1.0\n\"arm.omega\" = 2.0\n\"crank_0.angle\" = 0.4\n\"crank_0.omega\" = 3.0\n";
    text += "\"crank_1.angle\" = { guess = 0.4 }\n\"crank_2.angle\" = { guess = 0.4 }\n\"platform.angle\" = { guess = 0 }\n";
    text += "[outputs]\nvariables = [\"arm.angle\", \"b.angle\", \"crank_0.angle\", \"low_1.fx\", \"high_2.fy\"]\n";
    Scene::from_toml(&text).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)))
}

/// Masses of a milligram beside lengths of a tenth of a millimetre, or of a kiloton beside kilometres, are as regular as any.
#[test]
fn a_mechanism_of_any_size_moves_alike() {
    let run = |length: f64, mass: f64| {
        let mut instance = Instance::new(model(&of_size(length, mass)));
        instance.setup(0.0, Some(1.0), Some(1e-9)).expect("times");
        instance.initialise().expect("consistent");
        instance.step_to(1.0).unwrap_or_else(|error| panic!("{length:e} m, {mass:e} kg: {error}"));
        let mut value = |name: &str| instance.get(instance.variable(name).expect("an output")).expect("defined");
        let angles = ["arm.angle", "b.angle", "crank_0.angle"].map(&mut value);
        let forces = ["low_1.fx", "high_2.fy"].map(|name| value(name) / (mass * length));
        [&angles[..], &forces].concat()
    };
    let expected = run(1.0, 1.0);
    assert!(expected.iter().all(|value| value.abs() > 1e-3), "{expected:?}");
    for (length, mass) in [(1e-4, 1e-6), (1e-6, 1e-12), (1.0, 1e-12), (1e4, 1e6), (1e3, 1e12), (1e-3, 1e6)] {
        let error = difference(&run(length, mass), &expected);
        assert!(error < 1e-7, "{length:e} m, {mass:e} kg: {error:e}");
    }
}

/// A wheel that drives another by a belt and lifts a block by a screw, of any length [m] and mass [kg]; drag grows with the power 1.5 of its speed, which has no
/// series at rest. Pushed by the weight times the length, times this law.
fn lifting(length: f64, mass: f64, push: &str, omega: f64) -> Scene {
    let unit = mass * length * length;
    let screw = Joint::screw("wheel", "block.foot", [0.0, 1.0], PI * length).carrier("ground.guide");
    let drag = format!("{unit:e}*({push} - 0.3*wheel.omega*sqrt(abs(wheel.omega)))");
    Scene::new("lifting")
        .gravity([0.0, -length])
        .ground_point("axle", [0.0, 0.0])
        .ground_point("second_axle", [3.0 * length, 0.0])
        .ground_point("guide", [-length, 0.0])
        .body("wheel", Body::new().mass(mass).inertia(0.1 * unit).point("centre", [0.0, 0.0]))
        .body("second", Body::new().mass(mass).inertia(0.05 * unit).point("centre", [0.0, 0.0]))
        .body("block", Body::new().mass(mass).point("foot", [0.0, 0.0]))
        .revolute("bearing", "ground.axle", "wheel.centre")
        .revolute("second_bearing", "ground.second_axle", "second.centre")
        .prismatic("guide", "ground.guide", "block.foot", [0.0, 1.0])
        .joint("belt", Joint::belt("wheel", "second", [0.8 * length, length]))
        .joint("screw", screw)
        .load("drag", Load::torque("ground", "wheel", drag.as_str()))
        .initial("wheel.angle", 0.0)
        .initial("wheel.omega", omega)
        .output("wheel.angle")
        .output("wheel.omega")
        .stop(STOP)
}

/// Angle and speed of the wheel after so long, by the classical Runge-Kutta method.
fn lifted(push: f64, mut omega: f64, time: f64) -> [f64; 2] {
    const STEPS: u32 = 200_000;
    let (inertia, h) = (0.1 + 0.05 * 0.64 + 0.25, time / f64::from(STEPS));
    let rate = |omega: f64| (push - 0.5 - 0.3 * omega * omega.abs().sqrt()) / inertia;
    let mut angle = 0.0;
    for _ in 0..STEPS {
        let one = rate(omega);
        let two = rate(omega + 0.5 * h * one);
        let three = rate(omega + 0.5 * h * two);
        angle += h * (omega + h * (one + two + three) / 6.0);
        omega += h * (one + 2.0 * (two + three) + rate(omega + h * three)) / 6.0;
    }
    [angle, omega]
}

fn values(instance: &mut Instance) -> [f64; 2] {
    ["wheel.angle", "wheel.omega"]
        .map(|name| instance.get(instance.variable(name).expect("an output")).expect("defined"))
}

/// Rows in radians and rows in metres have no common unit: a screw of a millimetre was a singular pose wherever the drag has no series.
#[test]
fn couplings_of_small_mechanisms_are_no_singular_poses() {
    let expected = lifted(0.0, 2.0, STOP);
    for (length, mass) in [(1.0, 1.0), (1e-3, 1e-6), (1e-6, 1.0), (1e3, 1.0)] {
        for preset in ["joint", "absolute"] {
            let model = model(&lifting(length, mass, "0", 2.0).preset(preset));
            for tolerance in [1e-4, 1e-7, 1e-10] {
                let mut instance = Instance::new(model.clone());
                instance.setup(0.0, Some(STOP), Some(tolerance)).expect("times");
                instance.initialise().expect("consistent");
                let run = format!("{length:e} m, {preset}, {tolerance:e}");
                instance.step_to(STOP).unwrap_or_else(|error| panic!("{run}: {error}"));
                let error = difference(&values(&mut instance), &expected);
                assert!(error < 10.0 * tolerance + 1e-9, "{run}: {error:e}");
            }
        }
    }
}

/// Each step from rest was a first one, of a microsecond, for the drag has no series there.
#[test]
fn what_rests_takes_few_steps() {
    let mut instance = Instance::new(model(&lifting(1.0, 1.0, "0.5 + if(t > 3.5, 2, 0)", 0.0)));
    instance.setup(0.0, Some(STOP), Some(1e-8)).expect("times");
    instance.initialise().expect("consistent");
    instance.step_to(3.4).expect("regular");
    assert_eq!(values(&mut instance), [0.0, 0.0]);
    let steps = instance.statistics().steps;
    assert!((1..200).contains(&steps), "{steps}");
    instance.step_to(STOP).expect("regular");
    let error = difference(&values(&mut instance), &lifted(2.5, 0.0, STOP - 3.5));
    assert!(error < 1e-7, "{error:e}");
}

/// A ladder of parallelograms on a line in this direction, with couplers of these lengths and cranks of 1 kg and this length.
fn ladder(couplers: &[f64], direction: f64, crank: f64) -> String {
    let half = 0.5 * crank;
    let mut text = "name = \"ladder\"\ngravity = [0, -9.81]\n[ground.points]\np0 = [0, 0]\n".to_owned();
    let mut along = 0.0;
    for (index, length) in couplers.iter().enumerate() {
        along += length;
        let [x, y] = [along * direction.cos(), along * direction.sin()];
        text += &format!("p{} = [{x:?}, {y:?}]\n", index + 1);
    }
    for index in 0..=couplers.len() {
        text += &format!(
            "[bodies.c{index}]\nmass = 1\ninertia = {:?}\npoints = {{ b = [{:?}, 0], t = [{half:?}, 0] }}\n\
             [joints.g{index}]\ntype = \"revolute\"\nbetween = [\"ground.p{index}\", \"c{index}.b\"]\n",
            crank * crank / 12.0,
            -half
        );
    }
    let mut initial = "[initial]\n\"c0.angle\" = 1.0\n\"c0.omega\" = 18\n".to_owned();
    for (before, length) in couplers.iter().enumerate() {
        let (index, end) = (before + 1, 0.5 * length);
        text += &format!(
            "[bodies.k{index}]\nmass = 1\ninertia = {end:?}\npoints = {{ l = [{:?}, 0], r = [{end:?}, 0] }}\n\
             [joints.l{index}]\ntype = \"revolute\"\nbetween = [\"c{before}.t\", \"k{index}.l\"]\n\
             [joints.r{index}]\ntype = \"revolute\"\nbetween = [\"k{index}.r\", \"c{index}.t\"]\n",
            -end
        );
        initial +=
            &format!("\"c{index}.angle\" = {{ guess = 1.0 }}\n\"k{index}.angle\" = {{ guess = {direction:?} }}\n");
    }
    let last = couplers.len();
    text + &initial
        + &format!(
            "[outputs]\nvariables = [\"c0.angle\", \"c0.omega\", \"c{last}.angle\", \"k{last}.angle\"]\n[experiment]\nstop = 1\n"
        )
}

/// Where all bars of a ladder lie on a line that is nearly upright or nearly level, the loop equations of a coupler that is short beside the ladder are small, and depend on each other no more than
/// those of a long one: the ladder goes on as parallelograms, which is one equation of the energy.
#[test]
fn ladders_with_short_couplers_pass_their_change_points() {
    let mut random = Random(31);
    for case in 0..8 {
        let loops = 8 + 12 * case / 7;
        let couplers: Vec<f64> = (0..loops).map(|_| random.number(0.08, 2.0)).collect();
        let direction = [-1.42, -0.13, 1.7, 3.0][case % 4] + random.number(-0.1, 0.1);
        let crank = random.number(0.03, 0.1);
        let model = model(&Scene::from_toml(&ladder(&couplers, direction, crank)).expect("a scene"));
        for tolerance in [1e-4, 1e-8] {
            let mut instance = started(&model, None, 1.0, tolerance);
            let (cranks, rods) = (loops as f64 + 1.0, loops as f64);
            let energy = |angle: f64, omega: f64| {
                let inertia = cranks * crank * crank / 3.0 + rods * crank * crank;
                0.5 * inertia * omega * omega + 9.81 * crank * (0.5 * cranks + rods) * angle.sin()
            };
            for time in [0.1, 0.5, 1.0] {
                instance
                    .step_to(time)
                    .unwrap_or_else(|failure| panic!("{loops} {direction} {crank} {tolerance}: {failure}"));
                let [crank_name, rod] = ["c", "k"].map(|word| format!("{word}{loops}.angle"));
                let names = ["c0.angle", "c0.omega", &crank_name, &rod];
                let [first, omega, last, coupler] = names.map(|name| value(&mut instance, name));
                let apart = (last - first).abs().max((coupler - direction).abs());
                let share = energy(first, omega) / energy(1.0, 18.0) - 1.0;
                assert!(
                    apart < 1e-6 && share.abs() < 100.0 * tolerance,
                    "{loops} {direction} {crank} {tolerance} at {time}: {apart} {share}"
                );
            }
        }
    }
}

/// Crank and rod of one length fold over each other, where a law that reads an acceleration leaves no series to cross that. No joint of it is redundant, and none is said to be.
#[test]
fn a_law_of_an_acceleration_is_no_redundant_joint() {
    let scene = r#"
name = "fold"
[bodies]
crank = { mass = 1, inertia = 0.1, points = { o = [-0.5, 0], a = [0.5, 0] } }
rod = { mass = 1, inertia = 0.1, points = { a = [-0.5, 0], b = [0.5, 0] } }
slider = { mass = 1, inertia = 0.1 }
[joints]
pin = { type = "revolute", between = ["ground", "crank.o"] }
elbow = { type = "revolute", between = ["crank.a", "rod.a"] }
wrist = { type = "revolute", between = ["rod.b", "slider"] }
guide = { type = "prismatic", between = ["ground", "slider"], axis = [1, 0] }
[loads.added]
type = "torque"
on = "crank"
value = "-0.05*crank.alpha"
[initial]
"crank.angle" = "60 deg"
"crank.omega" = 3
"#;
    let scene = Scene::from_toml(scene).unwrap();
    let model = Arc::new(Model::new(compile(&scene).unwrap().program).unwrap());
    let why = started(&model, None, 2.0, 1e-6).step_to(2.0).unwrap_err().to_string();
    assert!(why.contains("a singular configuration") && !why.contains("redundant"), "{why}");
}
