//! Where the rate of a driver is discontinuous, its impulse acts on what is not driven, whatever the coordinates and the method are.

use crate::support::run;

use cotree_fmu::program::Engine;

const STOP: f64 = 1.0;
const CORNER: f64 = 0.5;

/// A pen that turns freely at the end of a crank whose motor turns by this law.
fn pen(law: &str, preset: &str) -> String {
    format!(
        r#"
format = 1
name = "pen"
[bodies.crank]
mass = 1
inertia = 0.01
points = {{ axle = [0, 0], pin = [0.1, 0] }}
[bodies.pen]
mass = 2
inertia = 0.005
points = {{ pin = [-0.2, 0] }}
[joints.axle]
type = "revolute"
between = ["ground", "crank.axle"]
[joints.pin]
type = "revolute"
between = ["crank.pin", "pen.pin"]
[drivers.motor]
joint = "axle"
angle = "{law}"
[initial]
"pen.angle" = 0.5
"pen.omega" = 0
[outputs]
variables = ["pen.angle", "pen.omega"]
[experiment]
stop = 1
[coordinates]
preset = "{preset}"
"#
    )
}

/// The same with a motor that follows this input.
fn following(input: &str, unit: &str, follows: &str, preset: &str) -> String {
    pen("LAW", preset).replace("\"LAW\"", &format!("{{ input = \"{input}\", as = \"{follows}\" }}")).replacen(
        "[bodies",
        &format!("[inputs]\n{input} = {{ start = 0, unit = \"{unit}\" }}\n[bodies"),
        1,
    )
}

fn values(scene: &str, engine: Option<Engine>, [time, tolerance]: [f64; 2], communication: usize) -> [f64; 2] {
    let mut instance = run::started(&run::model(scene), engine, STOP, tolerance);
    for point in 1..=communication {
        let target = time * point as f64 / communication as f64;
        instance.step_to(target).unwrap_or_else(|error| panic!("{engine:?}, {tolerance:e}: {error}"));
    }
    ["pen.angle", "pen.omega"].map(|name| run::value(&mut instance, name))
}

/// The crank stops at the corner: the impulse of the pin goes through the pen's mass centre at its lever, and then the pen turns about a pin at rest.
fn expected() -> [f64; 2] {
    let [angle, omega] = values(&pen("5*t", "absolute"), None, [CORNER, 1e-12], 1);
    let (inertia, coupling) = (0.005 + 2.0 * 0.2 * 0.2, 2.0 * 0.2 * 0.1 * (5.0 * CORNER - angle).cos());
    let behind = omega + coupling / inertia * 5.0;
    [angle + (STOP - CORNER) * behind, behind]
}

#[test]
fn the_impulse_of_a_corner_does_not_depend_on_coordinates_nor_method() {
    let expected = expected();
    for preset in ["recommended", "joint", "absolute"] {
        let scene = pen("5*min(t, 0.5)", preset);
        for engine in [None, Some(Engine::Dop853), Some(Engine::Radau)] {
            for (tolerance, points) in [(1e-4, 1), (1e-6, 7), (1e-6, 1000), (1e-9, 3)] {
                let found = values(&scene, engine, [STOP, tolerance], points);
                let error = run::distance(&found, &expected);
                assert!(error < 10.0 * tolerance, "{preset}, {engine:?}, {tolerance:e}, {points}: {error:e}");
            }
        }
    }
}

/// A speed that an importer sets in small steps is felt like one that grows evenly: what is free kept the rate of its coordinate over each step.
#[test]
fn a_speed_in_steps_is_felt_like_an_even_one() {
    const STEPS: u32 = 1000;
    let even = values(&pen("2.5*t^2", "recommended"), None, [STOP, 1e-10], 1);
    for preset in ["recommended", "joint", "absolute"] {
        let scene = following("speed", "rad/s", "velocity", preset);
        let mut instance = run::started(&run::model(&scene), None, STOP, 1e-8);
        let speed = instance.variable("speed").expect("an input");
        for step in 0..STEPS {
            instance.set(speed, 5.0 * (f64::from(step) + 0.5) / f64::from(STEPS)).expect("an input");
            instance.step_to(f64::from(step + 1) / f64::from(STEPS)).expect("regular");
        }
        let found = ["pen.angle", "pen.omega"].map(|name| run::value(&mut instance, name));
        assert!(run::distance(&found, &even) < 2e-3, "{preset}: {found:?} {even:?}");
    }
}

/// The same of a position that follows a polyline: its rate jumps at each of its corners.
#[test]
fn a_position_along_a_polyline_is_felt_like_an_even_one() {
    const STEPS: u32 = 1000;
    let law = |time: f64| 2.5 * time * time;
    let even = values(&pen("2.5*t^2", "recommended"), None, [STOP, 1e-10], 1);
    for preset in ["recommended", "joint", "absolute"] {
        let scene = following("way", "rad", "position", preset);
        let mut instance = run::started(&run::model(&scene), None, STOP, 1e-8);
        let way = instance.variable("way").expect("an input");
        for step in 0..STEPS {
            let [begin, end] = [step, step + 1].map(|step| f64::from(step) / f64::from(STEPS));
            instance.set(way, law(begin)).expect("an input");
            instance.set_derivative(way, 1, (law(end) - law(begin)) / (end - begin)).expect("an input");
            instance.step_to(end).expect("regular");
        }
        let found = ["pen.angle", "pen.omega"].map(|name| run::value(&mut instance, name));
        // The rate that holds at the end is that of the last piece.
        assert!(run::distance(&found, &even) < 2e-3, "{preset}: {found:?} {even:?}");
    }
}

/// A motor whose speed is `fast` rad/s over the way from the corner on, which may be set at any time.
fn tunable(preset: &str) -> String {
    pen("5*t - (5 - fast)*(t - 0.5)", preset).replacen(
        "[bodies",
        "[parameters]\nfast = { value = 5, unit = \"1/s\", tunable = true }\n[bodies",
        1,
    )
}

/// A tunable parameter that is set in the run changes the speed as an input does.
#[test]
fn a_tunable_speed_is_felt_like_a_corner() {
    let expected = expected();
    for preset in ["recommended", "joint", "absolute"] {
        let mut instance = run::started(&run::model(&tunable(preset)), None, STOP, 1e-8);
        let fast = instance.variable("fast").expect("a parameter");
        instance.step_to(CORNER).expect("regular");
        instance.set(fast, 0.0).expect("tunable");
        instance.step_to(STOP).expect("regular");
        let found = ["pen.angle", "pen.omega"].map(|name| run::value(&mut instance, name));
        assert!(run::distance(&found, &expected) < 1e-7, "{preset}: {found:?} {expected:?}");
    }
}

/// The limit of ever faster turns is the corner.
#[test]
fn a_corner_is_a_very_fast_turn() {
    let turn = "2.5*t + 1.25 - 2.5*sqrt((t - 0.5)^2 + 1e-14)";
    let found = values(&pen(turn, "recommended"), None, [STOP, 1e-9], 1);
    assert!(run::distance(&found, &expected()) < 1e-5, "{found:?}");
}

/// Roots, quotients and arcs bend or jump without a comparison that would tell where.
#[test]
fn laws_that_jump_without_a_switch_are_found() {
    let said = |law: &str| {
        let warnings = run::compiled(&pen(law, "recommended")).warnings;
        warnings.map(|warnings| warnings.render(false, 400)).unwrap_or_default()
    };
    for (law, what) in [
        ("5*sqrt((t - 0.5)^2)", "at t = 0.5 s its rate goes from -5.000000 to 5.000000"),
        ("sqrt(1 - cos(2*pi*t + 3))", "its rate goes from -4.44"),
        ("sqrt(2 - 2*cos(pi*(t - 0.3)))", "its rate goes from -3.14"),
        ("asin(sin(2*pi*t))", "its rate goes from 6.28"),
        ("acos(cos(2*pi*t + 1))", "its rate goes from 6.28"),
        ("0.1*atan2(sin(2*pi*t), cos(2*pi*t))", "it goes from 0.314159 to -0.314159"),
        ("0.1*atan(tan(pi*t))", "it goes from 0.157080 to -0.157080"),
        ("0.01*tan(3*(t - 0.4))", "its rate is unbounded"),
    ] {
        assert!(said(law).contains(what), "{law}: {}", said(law));
    }
    for law in [
        "sqrt(1.001 - cos(2*pi*t + 3))",
        "2*sqrt((t - 0.3)^2 + 0.0001)",
        "asin(0.999*sin(2*pi*t))",
        "5*((t - 0.5)^2)^0.75",
        "5*t/(0.1 + t)",
        "0.1/(t + 0.01)",
        "log(t + 0.001)",
        "(t + 0.1)^0.3",
        "atan2(sin(t), cos(t))",
        "0.3*atan(40*(t - 0.5))",
        "sin(300*t)/(2 + cos(300*t))",
    ] {
        assert!(said(law).is_empty(), "{law}: {}", said(law));
    }
}

/// The root of a square is a size, and has the same corner.
#[test]
fn the_root_of_a_square_turns_like_a_size() {
    for engine in [None, Some(Engine::Dop853), Some(Engine::Radau)] {
        let [root, size] = ["5*sqrt((t - 0.5)^2)", "5*abs(t - 0.5)"]
            .map(|law| values(&pen(law, "recommended"), engine, [STOP, 1e-8], 10));
        assert_eq!(root, size, "{engine:?}");
    }
}

/// A law that begins in a corner has no rate there, whatever the coordinates.
#[test]
fn a_law_that_begins_in_a_corner_is_refused() {
    for preset in ["recommended", "joint", "absolute"] {
        let scene = cotree::Scene::from_toml(&pen("acos(cos(2*pi*t))", preset)).expect("a sound scene");
        let said = cotree::compile::compile(&scene).map(|_| ()).map_err(|faults| faults.render(false, 400));
        let expected = "the law of driver `motor` has no finite rate at t = 0 s";
        assert!(said.as_ref().is_err_and(|said| said.contains(expected)), "{preset}: {said:?}");
    }
}

/// Trees that a scene asks for are kept: the warning says what that means.
#[test]
fn the_warning_says_what_becomes_of_the_impulse() {
    let warning = |coordinates: &str| {
        let text = pen("5*min(t, 0.5)", "recommended").replace("preset = \"recommended\"", coordinates);
        run::compiled(&text).warnings.map(|warnings| warnings.render(false, 400)).unwrap_or_default()
    };
    let said = warning("preset = \"recommended\"");
    assert!(said.contains("the impulse changes the speeds"), "{said}");
    let said = warning("rotation = [\"motor\", \"pen\"]");
    assert!(said.contains("without the impulse"), "{said}");
}

/// Where nothing has a mass for the impulse to act on, a driver is a branch whatever its law, and is said to be one.
#[test]
fn a_driver_of_what_has_no_mass_stays_a_branch_with_a_warning() {
    let massless = |scene: String| scene.replacen("mass = 1\ninertia = 0.01\n", "", 1);
    let compiled = |scene: &str| {
        let compiled = run::compiled(scene);
        let said = compiled.warnings.map(|warnings| warnings.render(false, 400)).unwrap_or_default();
        (compiled.program.coordinates.len(), said)
    };
    let follows = following("speed", "rad/s", "velocity", "recommended");
    let (coordinates, said) = compiled(&massless(follows.clone()));
    assert!(coordinates == 1 && said.contains("follows an input"), "{coordinates}: {said}");
    let (coordinates, said) = compiled(&massless(tunable("recommended")));
    assert!(coordinates == 1 && said.contains("follows a tunable parameter"), "{coordinates}: {said}");
    let (coordinates, said) = compiled(&massless(pen("5*min(t, 0.5)", "recommended")));
    assert!(coordinates == 1 && said.contains("without the impulse"), "{coordinates}: {said}");
    let (coordinates, said) = compiled(&follows);
    assert!(coordinates == 2 && said.is_empty(), "{coordinates}: {said}");
}

/// How the impulse depends on parameters is not derived.
#[test]
fn sensitivities_end_at_a_corner() {
    let derivative = |law: &str, time: f64| {
        let scene = cotree::Scene::from_toml(&pen(law, "recommended")).expect("a sound scene");
        let mut study = cotree_study::analysis::Study::new(&scene).expect("a sound scene");
        study.sensitivities(&["pen.angle".into()], &[time])
    };
    assert!(derivative("5*t", STOP).is_ok());
    assert!(derivative("5*min(t, 0.5)", 0.9 * CORNER).is_ok());
    let refused = derivative("5*min(t, 0.5)", STOP).map(|_| ()).map_err(|error| error.to_string());
    assert!(refused.as_ref().is_err_and(|why| why.contains("the rate of a driver is discontinuous")), "{refused:?}");
}
