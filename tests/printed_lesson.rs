//! The lesson of scenes that the paper has no example for: couplings, one dimension, inputs, and drivers that prescribe everything.

use cotree::compile::{self, Notation};
use cotree::output::text::Prose;
use cotree::scene::Scene;

fn scene(path: &str) -> Scene {
    Scene::read(format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))).unwrap_or_else(|faults| panic!("{faults}"))
}

fn written(text: &str) -> Scene {
    Scene::from_toml(text).unwrap_or_else(|faults| panic!("{faults}"))
}

fn lesson(scene: &Scene) -> String {
    compile::steps(scene, Prose::Text).unwrap_or_else(|faults| panic!("{faults}"))
}

fn equations(scene: &Scene) -> String {
    compile::equations(scene, Notation::Text).unwrap_or_else(|faults| panic!("{faults}"))
}

/// Lines without the spaces that align their signs.
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
fn a_gear_pair_is_two_chords_of_the_rotational_graph() {
    let text = lesson(&scene("tests/scenes/components/gear.toml"));
    assert_has(
        &text,
        &[
            "g6 `mesh` coupling - g6a: arm -> planet, g6b: arm -> ground",
            "theta_g6a = -sun_teeth/planet_teeth*theta_g6b",
            "T_g6a = lambda[1]",
            "T_g6b = sun_teeth/planet_teeth*lambda[1]",
            "T_m1 + T_h4 - T_h5 + T_T7 - T_g6a - T_g6b = 0",
            "T_m2 + T_h5 + T_g6a = 0",
            "theta_g6a = theta_m2 - theta_m1",
        ],
    );
}

#[test]
fn a_rack_is_a_chord_of_both_graphs() {
    let text = lesson(&scene("tests/scenes/components/rack.toml"));
    let expected = [
        "r_k6 . u_k6 = 0.05*theta_k6 + 0.3",
        "F_k6 = lambda[1]*u_k6",
        "T_k6 = -0.05*lambda[1]",
        "(F_s5 + F_m2 + F_k6) . u_s5 = 0",
        "T_m1 + T_h4 + T_T7 + T_k6 = 0",
    ];
    assert_has(&text, &expected);
}

#[test]
fn a_rolling_disc_has_its_tangential_force_and_its_torque() {
    let text = lesson(&scene("tests/scenes/components/rolling.toml"));
    assert_has(&text, &["s_o2 = 0.1 - radius*theta_o2", "F_o2 . u_o2 = lambda[1]", "T_o2 = radius*lambda[1]"]);
    assert!(!lines(&text).contains(&"T_o2 = 0".to_owned()), "{text}");
}

#[test]
fn a_distance_link_pushes_along_itself() {
    let text = lesson(&scene("tests/scenes/components/distance.toml"));
    let expected = [
        "abs(r_d2) = 1.3",
        "F_d2 = lambda[1]*r_d2/abs(r_d2)",
        "(F_m1 + F_d2) . i = 0",
        "r_d2 = r_m1",
        "g = (0, -9.81)",
    ];
    assert_has(&text, &expected);
}

#[test]
fn what_slides_in_a_turning_slot_turns_its_body() {
    let text = lesson(&scene("tests/scenes/components/slot.toml"));
    assert_has(&text, &["T_m1 = -rod.inertia*alpha_m1 - r_p4 x F_p4", "u_p4 = R(rod.angle)*(0, 1)"]);
}

#[test]
fn on_a_line_there_is_one_component() {
    let text = lesson(&scene("models/vibration/scene.toml"));
    let expected = ["F_m1 = -m1.mass*a_m1", "F_F17 = 10*sin(3*t)", "F_k13 = -35*k13.length", "a_m2 = a_m3 + a_k13"];
    assert_has(&text, &expected);
    assert!(!text.contains(" . i") && !text.contains(", 0)"), "{text}");
}

const SHAKEN: &str = r#"
    name = "shaken"
    dimension = 1
    gravity = [-2.0]
    [bodies.base]
    mass = 1.0
    [bodies.block]
    mass = 3.0
    [drivers.shake]
    on = "base"
    position = ["0.1*sin(5*t)"]
    [loads.spring]
    type = "spring"
    between = ["base", "block"]
    stiffness = 40.0
    length = 0.5
    damping = 7.0
    [outputs]
    variables = ["block.x"]
"#;

#[test]
fn a_driver_on_a_line_moves_to_the_right_side() {
    // 3 x'' = 40 (0.5 - (x - d)) - 7 (x' - d') - 6 with d = sin(5 t)/10.
    let text = equations(&written(SHAKEN));
    assert_has(&text, &["M[1,1] = 3", "D[1,1] = 7", "K[1,1] = 40"]);
    let force = lines(&text).into_iter().find(|line| line.starts_with("F[1] =")).unwrap();
    let value = |t: f64| 40.0 * (0.5 + 0.1 * (5.0 * t).sin()) + 7.0 * 0.5 * (5.0 * t).cos() - 6.0;
    assert_eq!(value(0.0), 17.5);
    for part in ["14", "4*sin(5*t)", "3.5*cos(5*t)"] {
        assert!(force.contains(part), "{force}");
    }
}

#[test]
fn a_law_of_the_motion_is_why_there_are_no_matrices() {
    let text = SHAKEN.replace(
        "[outputs]",
        "[loads.drag]\ntype = \"force\"\non = \"block\"\nvector = [\"-2*block.vx^3\"]\n[outputs]",
    );
    let page = equations(&written(&text));
    assert!(page.contains("There are no matrices D and K (24): the law of `drag` depends on the motion"), "{page}");
    let page = equations(&written(&SHAKEN.replace("length = 0.5", "length = 0.5\ncubic = 3.0")));
    assert!(page.contains("the spring `spring` is not linear"), "{page}");
}

const DRIVEN: &str = r#"
    name = "driven"
    [inputs]
    speed = { start = "2 rad/s" }
    [bodies.arm]
    mass = 2.0
    inertia = 0.5
    [joints.shoulder]
    type = "revolute"
    between = ["ground", "arm"]
    [drivers.motor]
    joint = "shoulder"
    angle = "3*t^2"
    [outputs]
    variables = ["arm.angle"]
"#;

#[test]
fn where_drivers_prescribe_everything_their_efforts_are_shown() {
    let text = equations(&written(DRIVEN));
    assert!(text.contains("there are no coordinates") && !text.contains("M*a = Q"), "{text}");
    assert_has(&text, &["motor.torque = 3"]);
}

#[test]
fn drivers_that_follow_an_input_are_explained() {
    let following = DRIVEN.replace("angle = \"3*t^2\"", "angle = { input = \"speed\", as = \"velocity\" }");
    let text = equations(&written(&following));
    assert_has(
        &text,
        &[
            "motor.torque = 0.5*motor''",
            "motor'' rad/s^2 acceleration of the driver `motor` = rate of the input `speed`",
        ],
    );
    let code = compile::equations(&written(&following), Notation::C).unwrap();
    assert!(code.contains("motor (its rate is the input speed)"), "{code}");
    let json = compile::equations(&written(&following), Notation::Json).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["followers"][0]["driver"], "motor");
    assert_eq!(json["followers"][0]["rate"], "motor'");
    assert_eq!(json["followers"][0]["input"], "speed");
    assert_eq!(json["followers"][0]["given"], "rate");
}

#[test]
fn parentheses_of_latex_pages_close_on_other_lines() {
    for model in ["andrews", "planetary_gear", "trammel"] {
        let scene = scene(&format!("models/{model}/scene.toml"));
        let page = compile::steps(&scene, Prose::Latex).unwrap_or_else(|faults| panic!("{faults}"));
        assert_eq!(page.matches(r"\Bigl").count(), page.matches(r"\Bigr").count(), "{model}");
        assert_eq!(page.matches(r"\left").count(), page.matches(r"\right").count(), "{model}");
    }
    let page = compile::steps(&written(&chain(6, "joint")), Prose::Latex).unwrap();
    assert!(page.contains(r"\Bigl("), "long formulas are broken");
    assert_eq!(page.matches(r"\Bigl").count(), page.matches(r"\Bigr").count());
}

#[test]
fn a_driver_in_the_tree_exerts_what_its_cutset_says() {
    let text = lesson(&written(DRIVEN));
    assert_has(&text, &["T_Theta3 = -T_m1 - T_h2"]);
}

#[test]
fn a_length_that_is_used_again_gets_a_name_and_the_root_of_a_square_is_no_root() {
    let text = equations(&scene("models/trammel/scene.toml"));
    assert_has(
        &text,
        &[
            "z1 = sqrt(level_rail.s^2 + upright_rail.s^2)",
            "spring.length = abs(0.9 - level_rail.s)",
            "Phi[1] = rod_length - z1",
            "Phi_q[1,1] = -level_rail.s/z1",
        ],
    );
}

/// A chain of rods.
fn chain(links: usize, preset: &str) -> String {
    let mut text = format!("name = 'chain'\ngravity = [0, -9.81]\ncoordinates.preset = '{preset}'\n");
    for link in 0..links {
        let before = if link == 0 { "ground".to_owned() } else { format!("b{}.b", link - 1) };
        text.push_str(&format!(
            "bodies.b{link} = {{ mass = 1, inertia = 0.1, points = {{ a = [-0.5, 0], b = [0.5, 0] }} }}\n\
             joints.j{link} = {{ type = 'revolute', between = ['{before}', 'b{link}.a'] }}\n"
        ));
    }
    text
}

#[test]
fn long_pages_say_so_and_how_they_get_shorter() {
    let [long, short] = ["joint", "recommended"].map(|preset| equations(&written(&chain(20, preset))));
    assert!(long.contains(" formulas. Other coordinates give other equations"), "{}", &long[..2000]);
    assert!(!short.contains(" formulas."), "{}", &short[..2000]);
}
