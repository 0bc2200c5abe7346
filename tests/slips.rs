//! Slips that leave a scene right and its motion not what was meant: `check` says so, with the name.

use cotree::compile::{compile, compile_with_equations};
use cotree::report::figures::summarise;
use cotree::scene::Scene;
use cotree_text::assumptions::assumptions;

const CRANK: &str = r#"
name = "crank"
[bodies.rod]
mass = 1.0
inertia = 0.1
points = { o = [0, 0], p = [0.4, 0] }
[joints.pin]
type = "revolute"
between = ["ground", "rod.o"]
"#;

/// Codes and messages of what is said of a scene that is right.
fn said(more: &str) -> Vec<String> {
    let scene = Scene::from_toml(&format!("{CRANK}{more}")).unwrap();
    let compiled = compile(&scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    let warnings = compiled.warnings.into_iter().flat_map(|faults| faults.list);
    warnings.map(|fault| format!("{} {}", fault.code, fault.message)).collect()
}

#[test]
fn an_input_that_nothing_uses() {
    let unused = "[inputs]\npush = \"0 N\"\nturn = { start = \"0 N.m\" }\n";
    let load = "[loads.motor]\ntype = \"torque\"\non = \"rod\"\nvalue = \"2*turn\"\n";
    assert_eq!(said(&format!("{unused}{load}")), ["scene::unused nothing uses input `push`"]);
    let followed = "[inputs]\nspeed = \"0 rad/s\"\n[drivers.motor]\njoint = \"pin\"\nangle = { input = \"speed\", as = \"velocity\" }\n";
    assert!(said(followed).iter().all(|warning| !warning.starts_with("scene::unused")), "{:?}", said(followed));
    let shown = "[inputs]\nwanted = \"0 rad\"\n[outputs]\nmissing = \"rod.angle - wanted\"\n";
    assert_eq!(said(shown), [""; 0]);
}

#[test]
fn a_step_longer_than_the_run() {
    let long = said("[experiment]\nstop = \"2 s\"\nstep = \"3 s\"\n");
    assert!(long.len() == 1 && long[0].contains("`step` of `[experiment]` is 3 s, longer"), "{long:?}");
    assert_eq!(said("[experiment]\nstop = \"2 s\"\nstep = \"2 s\"\n"), [""; 0]);
}

/// Where the driver prescribes all there is too.
#[test]
fn a_driver_that_jumps() {
    let driven = |law: &str| said(&format!("[drivers.motor]\njoint = \"pin\"\nangle = \"{law}\"\n"));
    let jump = driven("if(t < 1, 0, 1)");
    assert!(jump.len() == 1 && jump[0].contains("`motor` is discontinuous: at t = 1 s"), "{jump:?}");
    assert_eq!(driven("if(t < 1, t, 1)"), [""; 0], "a corner of a driven position is no jump");
}

/// The format still has the word.
#[test]
fn a_search_for_trees_that_is_gone() {
    let cheapest = said("[coordinates]\npreset = \"cheapest\"\n");
    assert!(
        cheapest.len() == 1 && cheapest[0].contains("`cheapest` is obsolete and means the recommended trees"),
        "{cheapest:?}"
    );
    assert_eq!(said("[coordinates]\npreset = \"joint\"\n"), [""; 0]);
}

/// What is assumed of a scene.
fn assumed(scene: &str) -> Vec<String> {
    let scene = Scene::from_toml(scene).unwrap();
    assumptions(&mut compile_with_equations(&scene).unwrap().1, &scene)
}

#[test]
fn an_output_whose_unit_nobody_can_tell() {
    let open = |value: &str| {
        let text = format!("{CRANK}[parameters]\nstiff = 3\n[outputs]\nmoment = {value}\n");
        assumed(&text).iter().any(|sentence| sentence.starts_with("output `moment` has no unit"))
    };
    for value in ["\"3*rod.omega\"", "\"stiff*rod.angle\"", "\"200*rod.angle + 2*rod.omega\""] {
        assert!(open(value), "{value}");
    }
    for value in [
        "\"3[N.m.s/rad]*rod.omega\"",
        "{ value = \"3*rod.omega\", unit = \"N.m\" }",
        "\"rod.omega/rod.omega\"",
        "\"2*3\"",
        "\"sin(rod.angle)\"",
    ] {
        assert!(!open(value), "{value}");
    }
}

/// Sentences without holes, numbers with the digits that are worth reading, zeros without a sign.
#[test]
fn assumptions_read_well() {
    let scene = format!("{CRANK}[outputs]\nmoment = \"3*rod.omega\"\n[experiment]\nstop = 0.3333333333333333\n");
    let sentences = assumed(&scene);
    for sentence in &sentences {
        assert!(!sentence.contains("  ") && !sentence.contains("-0.000000"), "{sentence}");
        assert!(sentence.split(' ').all(|word| !word.starts_with("0.3333333")), "{sentence}");
    }
    assert!(sentences.iter().any(|own| own.contains("give `unit`, or units of the numbers")), "{sentences:?}");
}

/// The hook is moved and has no mass: no length and no mass depends on anything but parameters.
#[test]
fn what_keeps_a_motion_from_series_is_named() {
    let scene = "name = \"hung\"\ndimension = 1\n[bodies]\nload = { mass = 3 }\nhook = {}\n\
                 [drivers.lift]\non = \"hook\"\nposition = [\"0.1*sin(t)\"]\n\
                 [loads.rope]\ntype = \"force\"\non = \"load\"\nvector = [\"-50*(load.x - hook.x)\"]\n";
    let formulated = compile_with_equations(&Scene::from_toml(scene).unwrap()).unwrap().1;
    assert!(summarise(&formulated).solver.ends_with("body `hook` has no `mass`"), "{}", summarise(&formulated).solver);
}

#[test]
fn a_pose_far_from_its_guess_is_told() {
    let told = |guess: &str| {
        let scene = format!("{CRANK}[initial]\n\"rod.x\" = {{ guess = \"{guess}\" }}\n");
        assumed(&scene).into_iter().find(|sentence| sentence.contains("far from its guess"))
    };
    let sentence = told("26 m").unwrap();
    assert!(sentence.starts_with("`rod.x` is 0 m at the start, far from its guess of 26 m"), "{sentence}");
    assert_eq!(told("0.1 m"), None);
}

#[test]
fn a_mass_centre_that_nobody_has_placed() {
    let wanted = "the mass centre of `rod` is its origin, at its point `o`";
    assert!(assumed(CRANK).iter().any(|sentence| sentence == wanted), "{:?}", assumed(CRANK));
    for placed in [
        "com = [0.2, 0]\npoints = { o = [0, 0], p = [0.4, 0] }",
        "points = { o = [-0.2, 0], p = [0.2, 0] }",
        "shape = { rod = [\"o\", \"p\"] }\npoints = { o = [0, 0], p = [0.4, 0] }",
    ] {
        let scene = CRANK.replace("points = { o = [0, 0], p = [0.4, 0] }", placed);
        assert!(assumed(&scene).iter().all(|sentence| !sentence.contains("mass centre")), "{placed}");
    }
}

#[test]
fn a_parameter_or_a_point_of_the_ground_that_nothing_uses() {
    assert_eq!(said("[parameters]\nlever = \"80 mm\"\n"), ["scene::unused nothing uses parameter `lever`"]);
    // What only another parameter uses is used.
    assert_eq!(
        said("[parameters]\nhalf = \"40 mm\"\nlever = \"2*half\"\n"),
        ["scene::unused nothing uses parameter `lever`"]
    );
    for used in [
        "[outputs]\nfar = \"lever*2\"\n",
        "[experiment]\nstop = \"lever*3[s/m]\"\n",
        "[initial]\n\"rod.angle\" = \"lever*1[rad/m]\"\n",
    ] {
        assert_eq!(said(&format!("[parameters]\nlever = \"80 mm\"\n{used}")), [""; 0], "{used}");
    }
    let points = "[ground.points]\nwall = [1, 0]\n";
    assert_eq!(said(points), ["scene::unused nothing uses point `ground.wall`"]);
    let spring =
        "[loads.coil]\ntype = \"spring\"\nbetween = [\"ground.wall\", \"rod.p\"]\nstiffness = 10\nlength = 1\n";
    assert_eq!(said(&format!("{points}{spring}")), [""; 0]);
    assert_eq!(said(&format!("{points}[outputs]\nvariables = [\"ground.wall.x\"]\n")), [""; 0]);
}

/// Both may be the cause, so both are told.
#[test]
fn warnings_stand_beside_the_error_of_a_later_step() {
    let lever = CRANK.replace("[joints.pin]", "[bodies.arm]\nmass = 1\ninertia = 0.1\npoints = { a = [0, 0], b = [0.5, 0] }\n[ground.points]\nfar = [2, 0]\n[joints.pin]");
    let text = format!(
        "{lever}[joints.knee]\ntype = \"revolute\"\nbetween = [\"rod.p\", \"arm.a\"]\n[joints.foot]\ntype = \"revolute\"\nbetween = [\"arm.b\", \"ground.far\"]\n\
         [initial]\n\"rod.angle\" = {{ guess = 30 }}\n"
    );
    let faults = compile(&Scene::from_toml(&text).unwrap()).unwrap_err();
    let codes: Vec<&str> = faults.list.iter().map(|fault| fault.code).collect();
    assert!(codes.contains(&"scene::degrees") && codes.contains(&"assembly::open_loop"), "{codes:?}");
}
