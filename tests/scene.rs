//! Scenes that are right: the three ways to write one, and what they resolve to.

use crate::support::run;

use cotree::expr::{Binary, Function, Unary};
use cotree::model::{
    BodyId, CoordinateChoice, Dimension, Exponents, Formula, InputId, JointId, LoadId, Mechanism, Motion, Owner,
    ParameterId, Place, Quantity, Unit, Variable,
};
use cotree::scene::{Body, Driver, InputAs, Joint, Load, Parameter, Resolved, Scene};

use run::{mechanism, resolved};

const SLIDER_CRANK: &str = include_str!("scenes/slider_crank.toml");

fn built() -> Scene {
    Scene::new("slider_crank")
        .description("In-line slider-crank, McPhee 1998, Fig. 1")
        .gravity([0.0, -9.81])
        .parameter("crank_length", "0.5 m")
        .parameter("rod_length", Parameter::new("1.5 m").min("0.6 m").description("between the pins"))
        .parameter("load_stiffness", Parameter::new(0.0).unit("N/m").tunable())
        .input("gas_force", cotree::scene::Input::new("0 N").description("along -x"))
        .ground_point("bearing", [0.0, 0.0])
        .ground_point("guide", [0.0, 0.0])
        .body(
            "crank",
            Body::new()
                .mass(2.0)
                .inertia(0.0416667)
                .point("inner", ("-crank_length/2", 0))
                .point("outer", ("crank_length/2", 0)),
        )
        .body(
            "rod",
            Body::new()
                .mass(3.0)
                .inertia(0.5625)
                .point("big_end", ("-rod_length/2", 0))
                .point("small_end", ("rod_length/2", 0)),
        )
        .body("slider", Body::new().mass(1.0))
        .revolute("main_bearing", "ground.bearing", "crank.inner")
        .revolute("crank_pin", "crank.outer", "rod.big_end")
        .revolute("wrist_pin", "rod.small_end", "slider")
        .joint("cylinder", Joint::prismatic("ground.guide", "slider", [1.0, 0.0]).angle(0.0))
        .load("gas", Load::force("slider", ("-gas_force", 0.0)))
        .load("return_spring", Load::spring("ground.bearing", "slider", "load_stiffness").free(1.0).damping(0.0))
        .initial("crank.angle", "0.6 rad")
        .guess("rod.angle", "-0.19 rad")
        .initial("crank.omega", 0.0)
        .output("crank.angle")
        .output("rod.angle")
        .output("cylinder.s")
        .output("cylinder.fn")
        .output("energy.total")
        .output_expression("tip", "rod.small_end.x - 0.1")
        .start(0.0)
        .stop("10 s")
        .step("1 ms")
        .tolerance(1e-6)
}

#[test]
fn toml_json_and_rust_give_the_same_scene() {
    let toml = Scene::from_toml(SLIDER_CRANK).unwrap();
    let json = include_str!("scenes/slider_crank.json");
    assert_eq!(toml, Scene::from_json(json).unwrap());
    // Some editors begin a file with a mark.
    assert_eq!(toml, Scene::from_toml(&format!("\u{feff}{SLIDER_CRANK}")).unwrap());
    assert_eq!(toml, Scene::from_json(&format!("\u{feff}{json}")).unwrap());
    assert_eq!(toml, built());
    assert_eq!(toml.resolve().unwrap(), built().resolve().unwrap());
    assert_ne!(toml, built().output("rod.omega"));
}

fn minus(formula: Formula) -> Formula {
    Formula::Call(Function::One(Unary::Negate), vec![formula])
}

#[test]
fn the_slider_crank_resolves() {
    let Resolved { mechanism, outputs, .. } = resolved(SLIDER_CRANK);
    assert_eq!(mechanism.dimension, Dimension::Two);
    assert_eq!(mechanism.gravity, [Formula::Number(0.0), Formula::Number(-9.81)]);
    assert_eq!(mechanism.bodies.iter().map(|body| body.name.as_str()).collect::<Vec<_>>(), ["crank", "rod", "slider"]);
    let half = |negative: bool, index| {
        let parameter = Formula::Parameter(ParameterId(index));
        let length = if negative { minus(parameter) } else { parameter };
        length / Formula::Number(2.0)
    };
    assert_eq!(mechanism.bodies[0].points[0].at, [half(true, 0), Formula::Number(0.0)]);
    assert_eq!(mechanism.bodies[1].points[1].at, [half(false, 1), Formula::Number(0.0)]);
    assert_eq!(mechanism.joints[2].between, [Place::Point(BodyId(1), 1), Place::Centre(BodyId(2))]);
    assert_eq!(mechanism.joints[0].between, [Place::Ground(0), Place::Point(BodyId(0), 0)]);
    let rod = &mechanism.parameters[1];
    assert_eq!((rod.value, rod.min, rod.unit.si.as_str(), rod.tunable), (1.5, Some(0.6), "m", false));
    assert!(mechanism.parameters[2].tunable);
    let force = &mechanism.loads[0];
    assert_eq!(
        (force.component().name, force.between[1], force.choice("frame")),
        ("force", Place::Centre(BodyId(2)), None)
    );
    assert_eq!(force.vector("vector")[0], minus(Formula::Input(InputId(0))));
    assert!(!mechanism.initial[1].known && mechanism.initial[0].known);
    let outputs: Vec<_> = outputs
        .iter()
        .map(|output| (output.name.as_str(), output.unit.si.as_str(), output.description.as_str()))
        .collect();
    assert_eq!(
        outputs,
        [
            ("crank.angle", "rad", "angle of `crank`"),
            ("rod.angle", "rad", "angle of `rod`"),
            ("cylinder.s", "m", "displacement of `cylinder`"),
            ("cylinder.fn", "N", "normal force of `cylinder`"),
            ("energy.total", "J", "total energy"),
            ("tip", "m", "rod.small_end.x - 0.1"),
        ]
    );
    let experiment = mechanism.experiment;
    assert_eq!((experiment.start, experiment.stop, experiment.step, experiment.tolerance), (0.0, 10.0, 1e-3, 1e-6));
}

/// A crank on the ground, with more to come.
fn crank(more: &str) -> String {
    format!(
        "name = \"crank\"\n[parameters]\na = \"3 mm\"\nb = \"4 mm\"\nc = \"2*a + b\"\nratio = 0.5\n[inputs]\nu = 0.0\n\
         [ground.points]\npin = [0, 0]\n[bodies.crank]\nmass = 1\ninertia = 1\ncom = [0.1, 0]\n\
         points = {{ pin = [0, 0], end = [\"a\", \"b\"] }}\n[bodies.block]\nmass = 1\ninertia = 1\n\
         [joints.pin]\ntype = \"revolute\"\nbetween = [\"ground.pin\", \"crank.pin\"]\n{more}"
    )
}

#[test]
fn outputs_have_units_and_descriptions() {
    let text = crank(
        "[outputs]\nstroke = { value = \"crank.end.x - block.x\", unit = \"mm\", description = \"how far\" }\n\
         bare = { value = \"2*crank.x\", unit = \"cm\" }\npower = { value = \"crank.omega*pin.fx*a\" }\nunknown = \"2*crank.x\"\n",
    );
    let outputs = resolved(&text).outputs;
    let shown = |index: usize| {
        let output = &outputs[index];
        let display = output.unit.display.as_ref().map(|display| (display.name.as_str(), display.factor));
        (output.name.as_str(), output.unit.si.as_str(), display, output.description.as_str())
    };
    assert_eq!(shown(0), ("stroke", "m", Some(("mm", 1e-3)), "how far"));
    assert_eq!(shown(1), ("bare", "m", Some(("cm", 1e-2)), "2*crank.x"));
    assert_eq!(outputs[2].unit.exponents, Exponents::WATT.times(Exponents::RADIAN), "rad/s N m");
    assert_eq!(shown(3), ("unknown", "", None, "2*crank.x"));
    let scene = Scene::from_toml(&text).unwrap();
    let built = Scene::new("crank").output_expression_in("mm", "stroke", "crank.end.x - block.x", "how far");
    assert_eq!(built.outputs.expressions[0], scene.outputs.expressions[0]);
    for (entry, told) in [
        ("wrong = { value = \"crank.x\", unit = \"s\" }", "is in `m`, which cannot be converted to `s`"),
        ("wrong = { value = \"crank.x\", unit = \"mn\" }", "mn"),
        ("wrong = { unit = \"mm\" }", "value"),
        ("wrong = { value = \"crank.x\", units = \"mm\" }", "units"),
    ] {
        let faults = Scene::from_toml(&crank(&format!("[outputs]\n{entry}\n"))).and_then(|scene| scene.resolve());
        let message = faults.unwrap_err().list[0].message.clone();
        assert!(message.contains(told), "{message}");
    }
}

#[test]
fn points_are_relative_to_the_mass_centre() {
    let mechanism = mechanism(&crank(""));
    let crank = &mechanism.bodies[0];
    assert_eq!(crank.points[0].at, [Formula::Number(-0.1), Formula::Number(0.0)]);
    let a = Formula::Parameter(ParameterId(0));
    assert_eq!(crank.points[1].at[0], a - Formula::Number(0.1));
}

#[test]
fn parameters_may_be_expressions_of_parameters() {
    let mechanism = mechanism(&crank(""));
    let found = mechanism.calculated.iter().map(|own| own.parameter.value).collect::<Vec<f64>>();
    assert!(matches!(found[..], [value] if (value - 0.01).abs() < 1e-15), "{found:?}");
    let display = mechanism.parameters[0].unit.display.as_ref().unwrap();
    assert_eq!((display.name.as_str(), display.factor), ("mm", 1e-3));
}

#[test]
fn a_bare_number_is_in_the_declared_unit() {
    let text = "name = \"x\"\n[parameters]\nl = { value = 120, unit = \"mm\", min = 100, max = \"1 m\" }\n\
                [inputs]\nspeed = { start = 60, unit = \"rpm\" }\n[bodies.m]\nmass = 1\n";
    let mechanism = mechanism(text);
    let length = &mechanism.parameters[0];
    assert_eq!((length.value, length.min, length.max), (0.12, Some(0.1), Some(1.0)));
    assert!((mechanism.inputs[0].start - std::f64::consts::TAU).abs() < 1e-12);
}

#[test]
fn an_axis_becomes_a_unit_vector() {
    let slide = |axis: &str| {
        crank(&format!("[joints.slide]\ntype = \"prismatic\"\nbetween = [\"crank.end\", \"block\"]\naxis = {axis}\n"))
    };
    let axis = |mechanism: &Mechanism| mechanism.joints[1].vector("axis");
    assert_eq!(axis(&mechanism(&slide("[3, 4]"))), [Formula::Number(0.6), Formula::Number(0.8)]);
    assert!(matches!(&axis(&mechanism(&slide("[\"a\", \"b\"]")))[0], Formula::Call(Function::Two(Binary::Divide), _)));
}

#[test]
fn drivers_follow_inputs_and_laws() {
    let mechanism = mechanism(&crank(
        "[drivers.motor]\njoint = \"pin\"\nangle = { input = \"u\", as = \"velocity\" }\n\
         [drivers.path]\non = \"block\"\nposition = [\"0.1*sin(t)\", \"0\"]\n\
         [drivers.turn]\nbetween = [\"ground\", \"block\"]\nangle = \"0.4356 + 4*pi*t\"\n",
    ));
    let motor = &mechanism.drivers[0];
    assert_eq!((motor.component().name, motor.bodies()), ("angle", [None, Some(BodyId(0))]));
    assert_eq!((motor.motion(), motor.joint()), (Some(&Motion::Velocity(InputId(0))), Some(JointId(0))));
    let path = &mechanism.drivers[1];
    assert_eq!((path.component().name, path.between[1]), ("position", Place::Centre(BodyId(1))));
    let built = Driver::angle("pin", cotree::scene::Motion::follows("u", InputAs::Velocity));
    let built = Scene::from_toml(&crank("")).unwrap().driver("motor", built).resolve().unwrap().mechanism;
    assert_eq!(built.drivers[0].values, motor.values);
}

#[test]
fn laws_know_their_own_variables_and_those_of_the_scene() {
    let mechanism = mechanism(&crank(
        "[loads.muscle]\ntype = \"actuator\"\nbetween = [\"ground.pin\", \"block\"]\nforce = \"-10*(length - a) - 3*rate^3 + 2*block.x\"\n\
         [loads.law]\ntype = \"torsion_actuator\"\nbetween = [\"ground\", \"crank\"]\ntorque = \"-ratio*tanh(omega/0.01) + 4*pin.angle*muscle.rate\"\n\
         [loads.motor]\ntype = \"torque\"\non = \"crank\"\nvalue = \"if(t < 1, u, -u)\"\n",
    ));
    let force = &mechanism.loads[0].law().unwrap();
    let own = Variable { owner: Owner::Load(LoadId(0)), quantity: Quantity::Length };
    assert!(format!("{force:?}").contains(&format!("{own:?}")));
    assert_eq!((mechanism.loads[2].component().name, mechanism.loads[2].bodies()), ("torque", [None, Some(BodyId(0))]));
}

#[test]
fn initial_values_may_be_nested_tables() {
    let nested = mechanism(&crank("[initial]\ncrank.angle = 0.6\npin.omega = { guess = \"1 rad/s\" }\n"));
    let quoted = mechanism(&crank("[initial]\n\"crank.angle\" = 0.6\n\"pin.omega\" = { guess = \"1 rad/s\" }\n"));
    assert_eq!(nested, quoted);
    assert_eq!(nested.initial.len(), 2);
}

#[test]
fn one_dimension_has_springs_masses_and_no_turning() {
    let text = "name = \"chain\"\ndimension = 1\ngravity = [-9.81]\n[ground.points]\nwall = [0]\n\
         [bodies.a]\nmass = 1\ninertia = 5\npoints = { end = [0.1, 0] }\n[bodies.b]\nmass = 1\n\
         [loads.k]\ntype = \"spring\"\nbetween = [\"ground.wall\", \"a.end\"]\nstiffness = 10\n\
         [loads.f]\ntype = \"force\"\non = \"b\"\nvector = [\"sin(t)\"]\n\
         [drivers.d]\non = \"b\"\nposition = [\"0.1*t\"]\n\
         [initial]\n\"a.x\" = 0.1\n\"k.length\" = 0.2\n\
         [outputs]\nvariables = [\"a.x\", \"a.vx\", \"k.force\", \"d.fx\"]\n";
    let Resolved { mechanism, outputs, .. } = resolved(text);
    assert_eq!(mechanism.dimension, Dimension::One);
    assert_eq!(mechanism.gravity, [Formula::Number(-9.81), Formula::Number(0.0)]);
    assert_eq!(outputs.len(), 4);
}

#[test]
fn every_variable_of_the_naming_table_exists() {
    let text = crank(
        "[bodies.tip]\nmass = 1\ninertia = 1\n\
         [joints.slide]\ntype = \"prismatic\"\nbetween = [\"crank.end\", \"block\"]\naxis = [1, 0]\n\
         [joints.glue]\ntype = \"weld\"\nbetween = [\"block\", \"tip\"]\n\
         [drivers.motor]\njoint = \"pin\"\nangle = \"t\"\n[drivers.push]\njoint = \"slide\"\ndisplacement = \"t\"\n\
         [drivers.path]\non = \"tip\"\nposition = [0, 0]\n\
         [loads.k]\ntype = \"spring\"\nbetween = [\"ground\", \"block\"]\nstiffness = 1\n\
         [loads.h]\ntype = \"torsion_spring\"\nbetween = [\"ground\", \"crank\"]\nstiffness = 1\n\
         [loads.m]\ntype = \"actuator\"\nbetween = [\"ground\", \"block\"]\nforce = 1\n\
         [loads.l]\ntype = \"torsion_actuator\"\nbetween = [\"ground\", \"crank\"]\ntorque = 1\n",
    );
    let table = [
        ("crank", "x y angle vx vy omega ax ay alpha"),
        ("crank.end", "x y vx vy ax ay"),
        ("ground.pin", "x y vx vy ax ay"),
        ("pin", "angle omega alpha fx fy"),
        ("slide", "s v a fn torque"),
        ("glue", "fx fy torque"),
        ("motor", "torque power"),
        ("push", "force power"),
        ("path", "fx fy power"),
        ("k", "length rate force"),
        ("m", "length rate force"),
        ("h", "angle omega torque"),
        ("l", "angle omega torque"),
        ("energy", "kinetic potential total"),
        ("constraint", "position velocity"),
    ];
    let names: Vec<String> = table
        .iter()
        .flat_map(|(owner, words)| words.split(' ').map(move |word| format!("\"{owner}.{word}\"")))
        .collect();
    let resolved = resolved(&format!("{text}[outputs]\nvariables = [{}]\n", names.join(", ")));
    assert_eq!(resolved.outputs.len(), names.len());
}

#[test]
fn trees_can_be_chosen() {
    let chosen = mechanism(&crank("[coordinates]\ntranslation = [\"pin\", \"block\"]\n"));
    let CoordinateChoice::Chosen { translation: Some(translation), rotation: None } = chosen.coordinates else {
        panic!()
    };
    assert_eq!(translation.len(), 2);
    assert_eq!(mechanism(&crank("[coordinates]\npreset = \"absolute\"\n")).coordinates, CoordinateChoice::Absolute);
}

/// Time is a number of seconds, and bare numbers go with everything.
#[test]
fn units_are_checked_only_where_both_sides_are_known() {
    for law in ["0.1*sin(t)", "sin(t)", "a + 0.1", "a*u", "a*sin(t/2) + 3*t", "a*ratio^2", "sqrt(a^2 + b^2)"] {
        mechanism(&crank(&format!("[drivers.path]\non = \"block\"\nposition = [\"{law}\", 0]\n")));
    }
    for law in ["a*b", "a^2", "a + crank_speed", "pin.angle", "sin(a)", "min(a, crank_speed)"] {
        let text = crank("").replace("ratio = 0.5", "ratio = 0.5\ncrank_speed = \"1 rpm\"");
        let scene = format!("{text}[loads.push]\ntype = \"force\"\non = \"block\"\nvector = [\"{law}\", 0]\n");
        let faults = Scene::from_toml(&scene).unwrap().resolve().unwrap_err();
        assert!(faults.list.iter().any(|fault| fault.code == "scene::wrong_unit"), "{law}");
    }
}

/// A number as a factor is a pure number; before what moves it may be a coefficient with a unit.
#[test]
fn a_number_as_a_factor_does_not_switch_the_check_off() {
    let force = |law: &str| {
        let text = crank("").replace("ratio = 0.5", "ratio = 0.5\nk = \"3 N/m\"\nf = \"2 N\"");
        let scene = format!("{text}[loads.push]\ntype = \"force\"\non = \"block\"\nvector = [\"{law}\", 0]\n");
        let faults = Scene::from_toml(&scene).unwrap().resolve().err().into_iter().flat_map(|faults| faults.list);
        faults.filter(|fault| fault.code == "scene::wrong_unit").count()
    };
    let right = [
        "2*k*a",
        "0.5*f",
        "f/2",
        "f*sin(2*t)",
        "3",
        "2*pi",
        "-0.5*crank.omega",
        "1e3*t^2",
        "2*(crank.x - 0.1)",
        "f*tanh(crank.omega/0.01)",
        "ratio*a",
        "sqrt(2*f*f)",
        "f + 3",
        "u*a",
        "min(2*f, 3)",
        "if(2*a < b, f, 0)",
    ];
    right.into_iter().for_each(|law| assert_eq!(force(law), 0, "{law}"));
    let wrong = [
        "2*a",
        "a*2",
        "a/2",
        "f + 2*a",
        "2*f*a",
        "sin(1)*a",
        "(2*a)^2",
        "sqrt(2*a*a)",
        "max(2*a, b)",
        "if(2*a < f, f, 0)",
        "f*sin(2*a)",
        "2*(a + b)",
        "abs(3*a)",
        "a*sin(t)",
    ];
    wrong.into_iter().for_each(|law| assert_eq!(force(law), 1, "{law}"));
    for (mass, right) in [("2*a", false), ("sin(0.5)*a", false), ("2*f*a^0", false), ("2*3", true), ("2*ratio", true)] {
        let text =
            crank("").replacen("mass = 1", &format!("mass = \"{mass}\""), 1).replace("ratio =", "f = \"2 N\"\nratio =");
        assert_eq!(Scene::from_toml(&text).unwrap().resolve().is_ok(), right, "{mass}");
    }
}

#[test]
fn a_number_in_an_expression_may_carry_its_unit() {
    let mass = |law: &str| {
        let text = crank("").replacen("mass = 1", &format!("mass = \"{law}\""), 1);
        let resolved = Scene::from_toml(&text).unwrap().resolve().ok()?;
        let mass = resolved.mechanism.bodies[0].mass.clone().expect("a mass");
        Some(cotree::scene::constant::evaluate(&mass, &resolved.mechanism.parameter_values()))
    };
    let near = |law: &str, value: f64| assert!(mass(law).is_some_and(|own| (own - value).abs() < 1e-15), "{law}");
    near("a*2[kg/m]", 6e-3);
    near("2*500 [g]", 1.0);
    near("1.3[kg/m]*500[mm]", 0.65);
    near("2[kg] + ratio", 2.5);
    for law in ["a*2[kg]", "2[kg/m]", "1[kg] + 1[m]", "2[kg]*3[rpm]", "2[kgs]"] {
        assert_eq!(mass(law), None, "{law}");
    }
}

#[test]
fn the_mass_in_a_moment_of_inertia_may_be_a_number() {
    for (inertia, right) in
        [("0.5*2.0*a^2", true), ("3*a*b/12", true), ("a^2", false), ("2*a", false), ("2*a^3", false)]
    {
        let text = crank("").replacen("inertia = 1", &format!("inertia = \"{inertia}\""), 1);
        assert_eq!(Scene::from_toml(&text).unwrap().resolve().is_ok(), right, "{inertia}");
    }
}

#[test]
fn t_and_time_are_the_time() {
    let law = |name: &str| {
        mechanism(&crank(&format!(
            "[drivers.path]\non = \"block\"\nposition = [\"0.1*sin(2*{name}) + 0.2*{name}^2\", 0]\n"
        )))
    };
    assert_eq!(law("t").drivers[0].values, law("time").drivers[0].values);
}

#[test]
fn every_branch_coordinate_is_a_variable() {
    let text = "[loads.gas]\ntype = \"force\"\non = \"crank.end\"\nvector = [1, 0]\n\
                [loads.coil]\ntype = \"spring\"\nbetween = [\"crank\", \"block\"]\nstiffness = 3\n\
                [loads.turn]\ntype = \"torsion_spring\"\nbetween = [\"crank\", \"block\"]\nstiffness = 3\n";
    let plane = ["gas.x", "gas.vy", "gas.ax", "coil.x", "coil.y", "coil.ay", "turn.angle", "turn.omega", "turn.alpha"];
    let names: Vec<String> = plane.iter().map(|name| format!("\"{name}\"")).collect();
    let resolved = resolved(&crank(&format!("{text}[outputs]\nvariables = [{}]\n", names.join(", "))));
    assert_eq!(resolved.outputs.len(), plane.len());
    let line = "name = \"line\"\ndimension = 1\n[bodies.m]\nmass = 1\n[loads.k13]\ntype = \"spring\"\n\
                between = [\"ground\", \"m\"]\nstiffness = 3\n[outputs]\nvariables = [\"k13.length\", \"k13.rate\", \"k13.acceleration\"]\n";
    assert!(Scene::from_toml(line).unwrap().resolve().is_ok());
}

/// The coordinates of loads are differences of the motion of their ends, whether the load is a branch or not.
#[test]
fn branch_coordinates_of_loads_are_what_they_are_called() {
    let text = "[loads.coil]\ntype = \"spring\"\nbetween = [\"crank.end\", \"block\"]\nstiffness = 3\nlength = 0.1\n\
                [loads.gas]\ntype = \"force\"\non = \"block\"\nvector = [1, 0.3]\n[initial]\n\"block.x\" = 0.4\n\
                [experiment]\nstop = 0.5\nstep = 0.1\n[outputs]\nvariables = [\"coil.x\", \"coil.vy\", \"coil.ay\", \"gas.ax\"]\n\
                x = \"block.x - crank.end.x\"\nvy = \"block.vy - crank.end.vy\"\nay = \"block.ay - crank.end.ay\"\nax = \"block.ax\"\n";
    for trees in
        ["", "[coordinates]\ntranslation = [\"pin\", \"coil\"]\n", "[coordinates]\ntranslation = [\"pin\", \"gas\"]\n"]
    {
        let results = Scene::from_toml(&crank(&format!("{text}{trees}"))).unwrap().simulate().unwrap();
        for (coordinate, difference) in [("coil.x", "x"), ("coil.vy", "vy"), ("coil.ay", "ay"), ("gas.ax", "ax")] {
            let pairs = results.get(coordinate).unwrap().iter().zip(results.get(difference).unwrap());
            let (mut moved, mut apart) = (0.0, 0.0);
            pairs.for_each(|(a, b): (&f64, &f64)| {
                (moved, apart) = (f64::max(moved, a.abs()), f64::max(apart, (a - b).abs()))
            });
            assert!(apart < 1e-12 && moved > 1e-3, "{coordinate} {trees}: {moved} {apart}");
        }
    }
}

#[test]
fn results_can_be_shown_in_other_units() {
    let length = |text: &str| {
        let mechanism = mechanism(&crank(text));
        [Unit::length(), Unit::length().per_second(), Unit::angle(), Unit::time()]
            .map(|unit| mechanism.units.of(&unit).name)
    };
    // The scene is written in millimetres.
    assert_eq!(length(""), ["mm", "mm/s", "rad", "s"]);
    assert_eq!(length("[display]\nunits = [\"cm\", \"deg\"]\ntime = \"ms\"\n"), ["cm", "cm/s", "deg", "ms"]);
    for wrong in ["length = \"deg\"", "units = [\"Nm\"]", "lenght = \"mm\"", "force = 3"] {
        let scene = Scene::from_toml(&crank(&format!("[display]\n{wrong}\n")));
        assert!(scene.and_then(|scene| scene.resolve()).is_err(), "{wrong}");
    }
}

#[test]
fn five_thousand_bodies_resolve() {
    let mut text = String::from("name = \"chain\"\n[ground.points]\np = [0, 0]\n");
    for body in 0..5000 {
        let before = if body == 0 { "ground.p".to_string() } else { format!("b{}.q", body - 1) };
        text += &format!(
            "[bodies.b{body}]\nmass = 1\ninertia = 1\npoints = {{ p = [0, 0], q = [\"1 mm\", 0] }}\n\
             [joints.j{body}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"b{body}.p\"]\n"
        );
    }
    assert_eq!(mechanism(&text).joints.len(), 5000);
}

#[test]
fn uses_of_a_name_given_twice_are_no_further_faults() {
    let text = "name = 'twice'\nparameters.arm = 1\nbodies.arm = { mass = 1, inertia = 1, points = { p = [1, 0] } }\n\
                joints.pin = { type = 'revolute', between = ['ground', 'arm.p'] }\noutputs.variables = ['arm.angle']";
    let faults = Scene::from_toml(text).unwrap().resolve().unwrap_err();
    let codes: Vec<&str> = faults.list.iter().map(|fault| fault.code).collect();
    assert_eq!(codes, ["scene::duplicate_name"]);
}
