//! The lesson of scenes that the paper has no example for: couplings, one dimension, inputs, and drivers that prescribe everything.

use crate::support::ROOT;
use crate::support::run::RUBBING_IN_DRIVEN;
use cotree::scene::Scene;
use cotree_text::Prose;
use cotree_text::written::{self, EquationFormat};

fn scene(path: &str) -> Scene {
    Scene::read(format!("{ROOT}/{path}")).unwrap_or_else(|faults| panic!("{faults}"))
}

fn written(text: &str) -> Scene {
    Scene::from_toml(text).unwrap_or_else(|faults| panic!("{faults}"))
}

fn lesson(scene: &Scene) -> String {
    written::steps(scene, Prose::Text).unwrap_or_else(|faults| panic!("{faults}"))
}

fn equations(scene: &Scene) -> String {
    written::equations(scene, EquationFormat::Text).unwrap_or_else(|faults| panic!("{faults}"))
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

/// All checks of a lesson hold, and there are at least so many.
fn assert_checked(text: &str, least: usize) {
    let checks: Vec<&str> = text.lines().filter(|line| line.contains("Check: ")).collect();
    assert!(checks.len() >= least, "{checks:#?}");
    let failed: Vec<&&str> = checks.iter().filter(|line| line.contains("NOT")).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// The slider-crank of the paper: the crank's arms along its x axis, the rod's along its y axis, no gravity.
const SLIDER_CRANK: &str = r#"
    name = "slider_crank"
    [parameters]
    x4 = "0 m"
    [ground.points]
    guide = ["x4", 0]
    [bodies.crank]
    mass = 2.0
    inertia = 0.0416667
    points = { inner = [-0.25, 0], outer = [0.25, 0] }
    [bodies.rod]
    mass = 3.0
    inertia = 0.5625
    points = { big_end = [0, -0.75], small_end = [0, 0.75] }
    [bodies.slider]
    mass = 1.0
    [joints.main_bearing]
    type = "revolute"
    between = ["ground", "crank.inner"]
    [joints.crank_pin]
    type = "revolute"
    between = ["crank.outer", "rod.big_end"]
    [joints.wrist_pin]
    type = "revolute"
    between = ["rod.small_end", "slider"]
    [joints.cylinder]
    type = "prismatic"
    between = ["ground.guide", "slider"]
    axis = [1, 0]
    [loads.gas]
    type = "force"
    on = "slider"
    vector = [-100, 0]
    [initial]
    "crank.angle" = 0.6
    "rod.angle" = { guess = -1.76 }
    "crank.omega" = 10.0
    [outputs]
    variables = ["crank.angle"]
"#;

/// The numbers were found by hand from Eqs (57)-(62) at this pose.
#[test]
fn the_slider_crank_of_the_paper_line_by_line() {
    let text = lesson(&written(SLIDER_CRANK));
    let expected = [
        "3 moving bodies have 3*3 = 9 degrees of freedom; 1 prismatic joint takes 2, 3 revolute joints take 2 each: 8; 1 degree of freedom remains.",
        "h10 . 1 1 1 1",
        "m1 F[m1] = -m_1*a[m1]; T[m1] = -I_1*alpha[m1] - k . (r[r5] x F[r5] + r[r6] x F[r6]) r[m1], theta[m1]",
        "(r[s12] + r[R4] + r[r5] - r[r6] + r[r7] - r[r8] - r[h9] - r[h10] - r[h11]) . n[s12] = 0",
        "(r[r5] - r[r6] + r[r7] - r[r8]) . n[s12] = 0",
        "Phi[1] = -(l_5 + l_6)*s1 - (l_7 + l_8)*c2",
        "s[s12] = (l_5 + l_6)*c1 - x4 - (l_7 + l_8)*s2",
        "F[r5] = F[m1] + F[m2] + F[m3] + F[s12] + F[F13]",
        "M[1,1] = I_1 + m_1*l_5^2 + (l_5 + l_6)^2*(m_2 + m_3)",
        "M[1,2] = (l_5 + l_6)*(m_2*l_7 + m_3*(l_7 + l_8))*(s1*c2 - c1*s2)",
        "M[1,1] = 1.16667",
        "M[1,2] = 1.32058",
        "M[2,2] = 4.5",
        "Q[1] = 17.7879",
        "Q[2] = 104.872",
        "gamma[1] = -26.0169",
        "alpha_1 = -16.2186",
        "alpha_2 = 22.2033",
        "lambda[1] = -17.9037",
        "main_bearing.fx = -96.6674",
        "main_bearing.fy = -69.4089",
        "crank_pin.fx = -59.9795",
        "wrist_pin.fy = 17.9037",
        "all bodies in both (absolute coordinates) 9 8 17",
    ];
    assert_has(&text, &expected);
    assert!(text.contains("the kinetic energy grows by 361.405 W"), "{text}");
    assert_checked(&text, 14);
}

#[test]
fn the_quick_return_has_an_axis_that_turns() {
    let text = lesson(&scene("models/quick_return/scene.toml"));
    let expected = [
        "Phi[1] = (l7 + l8)*(s2*c5 - c2*s5) - l2*c2",
        "Phi[2] = l1 + l2 - (l3 + l4)*s2 - (l5 + l6)*c4",
        "s[s21] = (l3 + l4)*c2 - (l5 + l6)*s4",
        "theta_2 = 1.21261",
        "theta_4 = 1.56951",
        "omega_2 = 3.46469",
        "omega_4 = 1.61952",
        "alpha_2 = 19.2055",
        "alpha_4 = -6.01575",
        "tool_slide.s = -0.319539",
    ];
    assert_has(&text, &expected);
    assert!(
        text.contains("whose axis turns") && text.contains("theta_2 from Phi[1], then theta_4 from Phi[2]"),
        "{text}"
    );
    assert_checked(&text, 6);
}

#[test]
fn lessons_of_all_models_hold_and_have_pictures() {
    for folder in std::fs::read_dir(format!("{ROOT}/models")).unwrap() {
        let folder = folder.unwrap();
        if folder.file_name() == RUBBING_IN_DRIVEN {
            continue;
        }
        let scene = Scene::read(folder.path().join("scene.toml")).unwrap();
        assert_checked(&lesson(&scene), 5);
        let page = written::steps(&scene, Prose::Html).unwrap();
        let pictures = page.matches("<figure>").count();
        assert!((2..=4).contains(&pictures), "the mechanism and its graphs, in the plane also a cut and a circuit");
        let page = written::steps(&scene, Prose::Latex).unwrap();
        assert_eq!(page.matches("\\begin{tikzpicture}").count(), pictures);
    }
}

#[test]
fn the_lesson_of_a_chain_of_fifty_stays_readable() {
    let short = lesson(&written(&chain(5, "recommended"))).lines().count();
    let long = lesson(&written(&chain(50, "recommended"))).lines().count();
    assert!(long < 2 * short && long < 400, "{short} lines, {long} lines");
}

#[test]
fn a_gear_pair_is_two_chords_of_the_rotational_graph() {
    let text = lesson(&scene("tests/scenes/components/gear.toml"));
    assert_has(
        &text,
        &[
            "g6 `mesh` coupling - g6a: arm -> planet, g6b: arm -> O i_6 -2.5",
            "g6 theta[g6a] = i_6*theta[g6b]; T[g6a] = lambda[1]; T[g6b] = -i_6*lambda[1]",
            "T[m1] + T[h4] - T[h5] + T[T7] - T[g6a] - T[g6b] = 0",
            "T[m2] + T[h5] + T[g6a] = 0",
            "theta[g6a] = theta[m2] - theta[m1]",
        ],
    );
}

#[test]
fn a_rack_is_a_chord_of_both_graphs() {
    let text = lesson(&scene("tests/scenes/components/rack.toml"));
    let expected = [
        "k6 r[k6] . u[k6] = r_6*theta[k6] + l_6; u[k6] = (1, 0); F[k6] = lambda[1]*u[k6]; T[k6] = -r_6*lambda[1]",
        "(F[s5] + F[m2] + F[k6]) . u[s5] = 0",
        "T[m1] + T[h4] + T[T7] + T[k6] = 0",
    ];
    assert_has(&text, &expected);
}

#[test]
fn a_rolling_disc_has_its_tangential_force_and_its_torque() {
    let text = lesson(&scene("tests/scenes/components/rolling.toml"));
    for part in ["s[o2] = l_2 - radius*theta[o2];", "F[o2] . u[o2] = lambda[1];", "T[o2] = radius*lambda[1]"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(!text.contains("T[o2] = 0"), "{text}");
}

#[test]
fn a_distance_link_pushes_along_itself() {
    let text = lesson(&scene("tests/scenes/components/distance.toml"));
    let expected =
        ["d2 abs(r[d2]) = l_2; F[d2] = lambda[1]*r[d2]/abs(r[d2])", "(F[m1] + F[d2]) . i = 0", "r[d2] = r[m1]"];
    assert_has(&text, &expected);
}

#[test]
fn what_slides_in_a_turning_slot_turns_its_body() {
    let text = lesson(&scene("tests/scenes/components/slot.toml"));
    assert!(text.contains("T[m1] = -k . (r[p4] x F[p4])"), "a body without inertia:\n{text}");
    assert!(text.contains("u[p4] = R(theta[m1])*(0, 1)"), "{text}");
}

#[test]
fn on_a_line_there_is_one_component() {
    let text = lesson(&scene("models/vibration/scene.toml"));
    let expected = [
        "m1 F[m1] = -m_1*a[m1] x[m1]",
        "F17 F[F17] = a_17*sin(b_17*t) x[F17]",
        "k13 F[k13] = -k_13*x[k13] x[k13]",
        "a[m2] = a[m3] + a[k13]",
        "k13 . 1 . 1",
        "[A_m]*[m]*[A_m]^T*{q''} + [A_d]*[d]*[A_d]^T*{q'} + [A_k]*[k]*[A_k]^T*{q} = [A_F]*{F_F}",
        "M[2,3] = m_2 + m_4",
        "K[3,3] = k_9 + k_12 + k_13 + k_14 + k_16",
        "K[1,2] = -k_9 - k_10",
        "D[3,4] = d_6 + d_7",
    ];
    assert_has(&text, &expected);
    assert_checked(&text, 10);
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
    assert!(page.contains("the law of `spring` is not linear"), "{page}");
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
    let code = written::equations(&written(&following), EquationFormat::C).unwrap();
    assert!(code.contains("motor (its rate is the input speed)"), "{code}");
    let json = written::equations(&written(&following), EquationFormat::Json).unwrap();
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
        let page = written::steps(&scene, Prose::Latex).unwrap_or_else(|faults| panic!("{faults}"));
        assert_eq!(page.matches(r"\Bigl").count(), page.matches(r"\Bigr").count(), "{model}");
        assert_eq!(page.matches(r"\left").count(), page.matches(r"\right").count(), "{model}");
    }
    let page = written::equations(&written(&chain(6, "joint")), EquationFormat::Latex).unwrap();
    assert!(page.contains(r"\Bigl("), "long formulas are broken");
    assert_eq!(page.matches(r"\Bigl").count(), page.matches(r"\Bigr").count());
}

#[test]
fn a_driver_in_the_tree_exerts_what_its_cutset_says() {
    let text = lesson(&written(DRIVEN));
    assert_has(&text, &["T[Theta3] = -T[m1] - T[h2]"]);
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

/// The angle of the second rod is the sum of both joints' angles: the products of its sine and cosine with those of the first are one function of the
/// second joint's.
#[test]
fn angles_that_are_sums_are_contracted() {
    let text = equations(&written(&chain(2, "joint")));
    assert_has(&text, &["c2 = cos(j1.angle)", "s2 = sin(j1.angle)"]);
    assert!(!text.contains("c1*c") && !text.contains("s1*s"), "{text}");
}

#[test]
fn accelerations_are_written_out_and_what_moves_what_is_read() {
    let text = lesson(&written(SLIDER_CRANK));
    assert_has(&text, &["a[m1] = (-l_5*(omega_1^2*c1 + alpha_1*s1), l_5*(alpha_1*c1 - omega_1^2*s1))"]);
    assert!(text.contains("theta_1 moves crank, rod, slider; theta_2 moves rod, slider."), "{text}");
}

/// The mechanism with its angles, both graphs, the worked cut and the circuit of the loop.
#[test]
fn cut_and_circuit_are_drawn_into_the_mechanism() {
    let scene = written(SLIDER_CRANK);
    let html = written::steps(&scene, Prose::Html).unwrap();
    assert_eq!(html.matches("<figure>").count(), 4);
    for angle in ["\u{3b8}1", "\u{3b8}2"] {
        assert!(html.contains(&format!(">{angle}</text>")), "{angle}");
    }
    assert_eq!(html.matches("stroke-dasharray=\"7 4\"").count(), 2, "rod and slider are cut free");
    let latex = written::steps(&scene, Prose::Latex).unwrap();
    assert_eq!(latex.matches("\\begin{tikzpicture}").count(), 4);
}

/// Two masses and a spring between them: nothing holds them, until a second spring does.
#[test]
fn masses_that_float_freely_are_said_to() {
    let masses = "name = 'floats'\ndimension = 1\nbodies.a.mass = 1.0\nbodies.b.mass = 2.0\n\
                  loads.spring = { type = 'spring', between = ['a', 'b'], stiffness = 40.0 }\n";
    let held = "loads.wall = { type = 'spring', between = ['ground', 'a'], stiffness = 3.0 }\n";
    let [floating, held] = [masses.to_owned(), format!("{masses}{held}")].map(|text| lesson(&written(&text)));
    assert!(floating.contains("Free-floating: K and D times {q} = {1, 1}"), "{floating}");
    assert!(!held.contains("Free-floating"), "{held}");
}

#[test]
fn long_pages_say_so_and_how_they_get_shorter() {
    let [long, short] = ["joint", "recommended"].map(|preset| equations(&written(&chain(20, preset))));
    assert!(long.contains(" formulas. Other coordinates give other equations"), "{}", &long[..2000]);
    assert!(!short.contains(" formulas."), "{}", &short[..2000]);
}

/// A pendulum whose rod slides, tied to the ground and to its rod by laws: equations with many shared parts.
const SHARED: &str = r#"
    name = "shared"
    [ground.points]
    p1 = [-0.3818, 0.919]
    p5 = [-0.1853, -0.9221]
    [bodies.b0]
    mass = 0.3484
    inertia = 0.163
    com = [-0.1842, -0.2532]
    points = { p2 = [-0.2, -0.76], p3 = [-0.48, -2.06], p8 = [-0.39, -2.29] }
    [bodies.b1]
    mass = 1.4088
    inertia = 0.2007
    com = [-0.2816, -0.1396]
    points = { p4 = [-0.768, 0.265], p6 = [-0.906, -1.117], p7 = [-1.751, -0.866] }
    [joints.j0]
    type = "revolute"
    between = ["ground.p1", "b0.p2"]
    [joints.j1]
    type = "prismatic"
    between = ["b0.p3", "b1.p4"]
    axis = [-0.9019, 0.4319]
    angle = -2.7605
    friction = { coulomb = 0.1384, velocity = 0.5 }
    [joints.j2]
    type = "distance"
    between = ["ground.p5", "b1.p6"]
    length = 0.8577877243234483
    [loads.l0]
    type = "spring"
    between = ["b1.p7", "b0.p8"]
    stiffness = 21.2
    length = 0.7
    damping = 1.37
    cubic = 17.5
    side = "below"
    [initial]
    "b0.angle" = { guess = 1.6644 }
    "b1.angle" = { guess = -1.0961 }
    "b1.omega" = -0.37
    [coordinates]
    translation = ["j0", "j1"]
    rotation = ["b1", "j1"]
"#;

#[test]
fn an_abbreviation_stands_for_one_thing_all_through_a_lesson() {
    let models = ["four_bar", "slider_crank", "excavator", "quick_return", "gear_train", "trammel"];
    let models = models.map(|model| scene(&format!("models/{model}/scene.toml")));
    for scene in models.iter().chain([&written(SHARED)]) {
        let text = lesson(scene);
        let is_short = |word: &&str| word.strip_prefix(['z', 'c', 's']).is_some_and(|rest| rest.parse::<u32>().is_ok());
        let mut known = std::collections::HashMap::new();
        for line in lines(&text) {
            let Some((name, value)) = line.split_once(" = ").filter(|(name, _)| is_short(name)) else { continue };
            let before = known.insert(name.to_owned(), value.to_owned());
            assert!(before.is_none_or(|before| before == value), "{name} is defined twice:\n{text}");
        }
        let words = text.split(|letter: char| !(letter.is_alphanumeric() || letter == '_' || letter == '.'));
        // `s3` may be an edge too.
        for word in words.filter(|word| is_short(word) && word.starts_with('z')) {
            assert!(known.contains_key(word), "{word} is not defined:\n{text}");
        }
    }
}

/// The names of its nodes stand in the picture of the mechanism, as the graph has them, and its tables say what they show.
#[test]
fn the_picture_has_the_nodes_of_the_graph_and_tables_have_captions() {
    let html = written::steps(&written(SLIDER_CRANK), Prose::Html).unwrap_or_else(|faults| panic!("{faults}"));
    let picture = html.split_once("<figure>").unwrap().1.split_once("</figure>").unwrap().0;
    for names in ["O, G, A", "C1", "B, P", "C2", "C3, D"] {
        assert!(picture.contains(&format!(">{names}</text>")), "{names}: {picture}");
    }
    let tables = html.matches("<table>").count();
    let captions: Vec<&str> = html.split("<caption>").skip(1).map(|rest| rest.split_once('<').unwrap().0).collect();
    assert_eq!(captions.len(), tables, "{captions:?}");
    let text = lesson(&written(SLIDER_CRANK));
    assert!(
        captions.len() > 8 && captions.iter().all(|caption| text.contains(&format!("  {caption}:\n"))),
        "{captions:?}"
    );
    let latex = written::steps(&written(SLIDER_CRANK), Prose::Latex).unwrap_or_else(|faults| panic!("{faults}"));
    assert!(latex.contains("\\textbf{Edges of both graphs}") && latex.contains("B, P"));
}
