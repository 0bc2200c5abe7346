//! Robots and drawings as scenes: masses, axes, loops and forces as MuJoCo, elementary formulas and two spellings of one robot say; what cannot be imported is refused by name.

use crate::outside::command;
use crate::support::ROOT;

use std::fs;
use std::path::Path;

use command::{code, cotree, stderr, stdout};
use cotree::import::{AttributeClass, ContactChoice, ImportOptions, WorldPlane, class_of, import_file};

fn imported(file: &str, text: &str, options: &ImportOptions) -> Result<String, String> {
    import_file("scene", file, text.as_bytes(), options, &|_| None).map(|own| own.scene).map_err(|all| all.join("\n"))
}

fn scene(text: &str) -> String {
    imported("robot.xml", text, &ImportOptions::default()).unwrap_or_else(|why| panic!("{why}"))
}

fn refused(text: &str, options: &ImportOptions) -> String {
    match imported("robot.xml", text, options) {
        Err(why) => why,
        Ok(scene) => panic!("is imported:\n{scene}"),
    }
}

/// The last row of a run, by the names of the variables.
fn run<const N: usize>(scene: &str, stop: f64, names: [&str; N]) -> [f64; N] {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let (stop, names_text) = (format!("{stop}"), names.join(","));
    let output = cotree(
        folder.path(),
        &[
            "simulate",
            "scene.toml",
            "--stop",
            &stop,
            "--step",
            &stop,
            "--tolerance",
            "1e-10",
            "--variables",
            &names_text,
        ],
    );
    assert_eq!(code(&output), 0, "{}\n{scene}", stderr(&output));
    let table = stdout(&output);
    let row: Vec<f64> = table.lines().last().unwrap().split(',').map(|value| value.parse().unwrap()).collect();
    std::array::from_fn(|index| row[index + 1])
}

/// The number of a key in the section of a body.
fn number(scene: &str, section: &str, key: &str) -> f64 {
    let (_, rest) = scene.split_once(&format!("[{section}]\n")).unwrap_or_else(|| panic!("no {section}:\n{scene}"));
    let line = rest.lines().take_while(|line| !line.starts_with('[')).find(|line| line.split(' ').next() == Some(key));
    let line = line.unwrap_or_else(|| panic!("{section} has no {key}:\n{scene}"));
    line.split_once('=').unwrap().1.trim().parse().unwrap()
}

fn close(a: f64, b: f64, share: f64) {
    assert!((a - b).abs() <= share * b.abs().max(1e-12), "{a} is not {b}");
}

/// Every attribute that MuJoCo 4.0.0 prints as its schema is in a class.
#[test]
fn every_attribute_of_the_schema_of_mujoco_has_a_class() {
    let schema = fs::read_to_string(Path::new(ROOT).join("tests/import/mjcf_schema.txt")).unwrap();
    let mut path: Vec<String> = Vec::new();
    let (mut known, mut missing) = (0, Vec::new());
    for line in schema.lines().filter(|line| !line.trim().is_empty()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let depth = (line.len() - line.trim_start().len()) / 3;
        // Names of elements are followed by how often they may occur.
        let is_element = words.get(1).is_some_and(|word| word.starts_with('(') && word.ends_with(')'));
        if is_element {
            path.truncate(depth);
            path.push(words[0].replace("(world)", ""));
        }
        let names: Vec<&str> = path.iter().map(String::as_str).collect();
        for attribute in &words[if is_element { 2 } else { 0 }..] {
            match class_of(&names, attribute) {
                Some(_) => known += 1,
                None => missing.push(format!("{} {attribute}", names.join("/"))),
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
    assert!(known > 1000, "{known}");
    assert_eq!(class_of(&["mujoco", "worldbody", "body", "joint"], "damping"), Some(AttributeClass::Exact));
    assert_eq!(class_of(&["mujoco", "worldbody", "body", "joint"], "dampnig"), None);
}

/// A uniform bar of 2 kg and 0.6 m on a hinge, with a rotor, falls as a physical pendulum whose inertia has the rotor's, until it strikes its stop.
#[test]
fn an_armature_is_inertia_of_the_joint_beside_a_limit() {
    let text = |armature: &str, limit: &str| {
        format!(
            r#"<mujoco><worldbody><body name="bar" pos="0 0 1"><joint name="pin" axis="0 -1 0" {armature} {limit}/>
            <inertial pos="0.3 0 0" mass="2" diaginertia="0.01 0.06 0.06"/></body></worldbody></mujoco>"#
        )
    };
    let free = scene(&text("armature=\"0.5\"", ""));
    assert_eq!(number(&free, "joints.pin", "armature"), 0.5);
    let [alpha] = run(&free, 1e-9, ["pin.alpha"]);
    close(alpha, -2.0 * 9.81 * 0.3 / (0.06 + 2.0 * 0.09 + 0.5), 1e-9);
    let [angle, omega, energy] = run(&free, 0.4, ["pin.angle", "pin.omega", "energy.kinetic"]);
    close(energy, 0.5 * (0.06 + 0.18 + 0.5) * omega * omega, 1e-9);
    // What it has gained is what its weight has done.
    close(energy, -2.0 * 9.81 * 0.3 * angle.sin(), 1e-8);
    let stopped = scene(&text("armature=\"0.5\"", "range=\"-30 60\""));
    let [angle, omega] = run(&stopped, 2.0, ["pin.angle", "pin.omega"]);
    close(angle, -30f64.to_radians(), 1e-9);
    assert!(omega.abs() < 1e-9, "{omega}");
}

/// Two bars; the rotor between them as two massless wheels that turn with the difference of their angles.
#[test]
fn an_armature_between_two_moving_bodies_is_that_of_a_geared_wheel() {
    let arms = |armature: &str| {
        format!(
            r#"format = 1
name = "arms"
gravity = [0, -9.81]
[bodies.upper]
mass = 0.7
inertia = 0.02
com = [0, -0.15]
points = {{ top = [0, 0], elbow = [0, -0.3] }}
[bodies.lower]
mass = 0.3
inertia = 0.004
com = [0.02, -0.1]
points = {{ elbow = [0, 0] }}
[joints.shoulder]
type = "revolute"
between = ["ground", "upper.top"]
[joints.elbow]
type = "revolute"
between = ["upper.elbow", "lower.elbow"]
{armature}
[initial]
"shoulder.angle" = 0.9
"shoulder.omega" = 0
"elbow.angle" = 0.4
"elbow.omega" = 3
"#
        )
    };
    let wheels = r#"[bodies.back]
mass = 0
inertia = 0
[bodies.rotor]
mass = 0
inertia = 0.08
[joints.back_pin]
type = "revolute"
between = ["ground", "back"]
[joints.rotor_pin]
type = "revolute"
between = ["ground", "rotor"]
[joints.back_gear]
type = "gear"
between = ["upper", "back"]
ratio = -1
[joints.rotor_gear]
type = "gear"
between = ["lower", "rotor"]
carrier = "back"
ratio = 0.5"#;
    let names = ["upper.angle", "lower.angle", "lower.omega", "energy.total"];
    let own = run(&arms("armature = 0.02"), 1.0, names);
    let other = run(&arms(wheels), 1.0, names);
    for (a, b) in own.into_iter().zip(other) {
        assert!((a - b).abs() < 1e-7, "{own:?} {other:?}");
    }
}

/// A slide that carries a slide: the armature of the second counts along it only.
#[test]
fn an_armature_of_a_slide_is_mass_along_it() {
    let text = r#"<mujoco><option gravity="0 0 -9.81"/><worldbody>
      <body name="cart"><joint name="rail" type="slide" axis="1 0 0"/><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>
      <body name="lift"><joint name="mast" type="slide" axis="0 0 1" armature="5"/><inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/></body></body>
      </worldbody></mujoco>"#;
    let [rail, mast] = run(&scene(text), 1e-9, ["rail.a", "mast.a"]);
    close(mast, -3.0 * 9.81 / (3.0 + 5.0), 1e-9);
    assert!(rail.abs() < 1e-12, "{rail}");
    let [fall, energy] = run(&scene(text), 0.5, ["mast.s", "energy.total"]);
    close(fall, -0.5 * 3.0 * 9.81 / 8.0 * 0.25, 1e-9);
    assert!(energy.abs() < 1e-9, "{energy}");
}

/// The same two bars as MJCF, URDF and SDF fall alike, with hinges along y and turned frames.
#[test]
fn one_robot_in_three_formats_moves_alike() {
    let mjcf = r#"<mujoco><compiler angle="radian"/><option gravity="0 0 -9.81"/><worldbody>
      <body name="upper" pos="0.1 0 1" euler="0 0.4 0"><joint name="a" axis="0 1 0" damping="0.05"/><inertial pos="0.2 0.1 0" mass="1.2" diaginertia="0.01 0.02 0.02"/>
      <body name="lower" pos="0.4 0 0" euler="0 0.7 0"><joint name="b" axis="0 -1 0"/><inertial pos="0.1 0 0.02" mass="0.5" diaginertia="0.001 0.004 0.004"/></body></body>
      </worldbody></mujoco>"#;
    let urdf = r#"<robot name="arm"><link name="base"/>
      <link name="upper"><inertial><origin xyz="0.2 0.1 0"/><mass value="1.2"/><inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <link name="lower"><inertial><origin xyz="0.1 0 0.02"/><mass value="0.5"/><inertia ixx="0.001" iyy="0.004" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="a" type="continuous"><parent link="base"/><child link="upper"/><origin xyz="0.1 0 1" rpy="0 0.4 0"/><axis xyz="0 1 0"/><dynamics damping="0.05"/></joint>
      <joint name="b" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0" rpy="0 0.7 0"/><axis xyz="0 -1 0"/></joint></robot>"#;
    let sdf = r#"<sdf version="1.9"><world name="w"><gravity>0 0 -9.81</gravity><model name="arm">
      <link name="upper"><pose>0.1 0 1 0 0.4 0</pose><inertial><pose>0.2 0.1 0 0 0 0</pose><mass>1.2</mass><inertia><ixx>0.01</ixx><iyy>0.02</iyy><izz>0.02</izz></inertia></inertial></link>
      <link name="lower"><pose relative_to="upper">0.4 0 0 0 0.7 0</pose><inertial><pose>0.1 0 0.02 0 0 0</pose><mass>0.5</mass><inertia><ixx>0.001</ixx><iyy>0.004</iyy><izz>0.004</izz></inertia></inertial></link>
      <joint name="a" type="revolute"><parent>world</parent><child>upper</child><axis><xyz>0 1 0</xyz><dynamics><damping>0.05</damping></dynamics></axis></joint>
      <joint name="b" type="revolute"><parent>upper</parent><child>lower</child><axis><xyz>0 -1 0</xyz></axis></joint></model></world></sdf>"#;
    let names = ["q_a", "q_b", "lower.x", "lower.y"];
    let [first, second, third] = [mjcf, urdf, sdf].map(|text| run(&scene(text), 0.7, names));
    for other in [second, third] {
        for (a, b) in first.iter().zip(other) {
            assert!((a - b).abs() < 1e-8, "{first:?} {other:?}");
        }
    }
}

/// A loop, a coupling, an actuator and a spring tendon: what MuJoCo 4.0.0 computes as accelerations at the start with constraints that are made exact
/// (`tests/import/random_robots.py`) is what the imported scene has.
#[test]
fn a_four_bar_with_rotors_falls_as_energy_says() {
    let text = fs::read_to_string(Path::new(ROOT).join("tests/import/four_bar.xml")).unwrap();
    let scene = scene(&text);
    for line in [
        "type    = \"revolute\"",
        "armature = 0.002",
        "limits",
        "[inputs]\ndrive = { start = 0.0, min = -1.0, max = 1.0 }",
    ] {
        assert!(scene.contains(line), "{line}\n{scene}");
    }
    let undamped = scene.lines().filter(|line| !line.starts_with("damping")).collect::<Vec<_>>().join("\n");
    let [before] = run(&undamped, 1e-9, ["energy.total"]);
    let [after, closed] = run(&undamped, 0.3, ["energy.total", "constraint.position"]);
    assert!((after - before).abs() < 1e-8 * before.abs() && closed < 1e-9, "{before} {after} {closed}");
}

#[test]
fn capsules_and_boxes_have_the_mass_that_formulas_give() {
    let text = r#"<mujoco><worldbody><body name="a"><joint name="j" axis="0 0 1"/>
      <geom type="capsule" size="0.1" fromto="-0.2 0 0 0.2 0 0" density="500"/><geom type="box" size="0.1 0.2 0.3" pos="0 1 0" mass="3"/></body></worldbody></mujoco>"#;
    let scene = scene(text);
    let pi = std::f64::consts::PI;
    let (tube, ball) = (500.0 * pi * 0.01 * 0.4, 500.0 * 4.0 / 3.0 * pi * 0.001);
    close(number(&scene, "bodies.a", "mass"), tube + ball + 3.0, 1e-14);
    // About z through the mass centre, whose y is 3/mass; the halves of the ball are beside the tube's ends, 3 r/8 from their flat side.
    let capsule = tube * (3.0 * 0.01 + 0.16) / 12.0 + ball * (0.4 * 0.01 + 0.4 * (0.3 + 0.8) / 8.0);
    let shared = (tube + ball) * 3.0 / (tube + ball + 3.0);
    close(number(&scene, "bodies.a", "inertia"), capsule + 3.0 * (0.01 + 0.04) / 3.0 + shared, 1e-13);
}

#[test]
fn what_cannot_be_imported_is_refused_with_its_place_and_an_option() {
    let body = |inside: &str| {
        format!(
            "<mujoco>\n<worldbody><body name=\"arm\"><joint name=\"pin\" axis=\"0 1 0\"/>{inside}<geom name=\"g\" size=\".1\"/></body></worldbody></mujoco>"
        )
    };
    let tip = |joint: &str| body(&format!("<body name=\"tip\" pos=\".3 0 0\">{joint}<geom size=\".1\"/></body>"));
    for (text, words) in [
        (
            tip("<joint name=\"skew\" axis=\"1 0 0\"/>"),
            &["robot.xml:2:", "joint `skew`", "90.00 deg", "--lock skew"][..],
        ),
        (tip("<joint name=\"out\" type=\"slide\" axis=\"0 1 0\"/>"), &["slides along", "--lock out"]),
        (tip("<joint name=\"socket\" type=\"ball\"/>"), &["`socket`", "ball", "--in-plane"]),
        (tip("<joint name=\"j\" axis=\"0 0 0\"/>"), &["axis", "length zero"]),
        (tip("<joint name=\"j\" axis=\"0 1 nan\"/>"), &["robot.xml:2:", "`nan`", "finite"]),
        (tip("<joint name=\"j\" axis=\"0 1,5 0\"/>"), &["`1,5`", "comma"]),
        (tip("<joint name=\"j\" axis=\"0 1 0\" dampnig=\"2\"/>"), &["no attribute `dampnig`"]),
        (tip("<joint name=\"j\" axis=\"0 1 0\" range=\"20 10\"/>"), &["`range`", "must increase"]),
        (tip("<joint name=\"j\" axis=\"0 1 0\" springdamper=\"1 1\"/>"), &["springdamper", "--leave-out"]),
        (body("<geom type=\"mesh\" mesh=\"part\"/>"), &["body `arm` needs an inertial", "mass=\"0\""]),
        (
            body("<body name=\"b\"><freejoint/><geom size=\".1\" pos=\"0 .1 .1\"/><geom size=\".1\"/></body>"),
            &["does not stay in the plane", "--in-plane"],
        ),
        (
            body("").replace("</mujoco>", "<actuator><muscle name=\"m\" joint=\"pin\"/></actuator></mujoco>"),
            &["muscle `m`", "--leave-out m"],
        ),
        (body("").replace("<worldbody>", "<option density=\"1000\"/><worldbody>"), &["fluid", "--leave-out fluid"]),
        (body("").replace("<worldbody>", "<worldbody><replicate count=\"3\"/>"), &["<replicate>", "mj_saveLastXML"]),
        (body("")[..60].to_owned(), &["robot.xml:2:", "breaks off"]),
        ("<robot><link name=\"a\"/><link name=\"b\"/></robot>".to_owned(), &["two roots", "`a`", "`b`"]),
        ("<robot><xacro:include filename=\"x\"/></robot>".to_owned(), &["xacro FILE > out.urdf"]),
        ("<svg/>".to_owned(), &["root element is <svg>"]),
    ] {
        let why = refused(&text, &ImportOptions::default());
        words.iter().for_each(|word| assert!(why.contains(word), "no `{word}` in:\n{why}"));
    }
}

#[test]
fn options_import_what_is_refused_without_them() {
    let text = r#"<mujoco><worldbody><body name="arm"><joint name="pin" axis="0 1 0"/><geom size=".1"/>
      <body name="tip" pos=".3 0 0"><joint name="wrist" axis="1 0 0"/><geom size=".05"/></body></body></worldbody>
      <actuator><muscle name="m" joint="pin"/><motor name="drive" joint="pin"/></actuator></mujoco>"#;
    let options = ImportOptions {
        lock: vec!["wrist".to_owned()],
        leave_out: vec!["muscle".to_owned()],
        ..ImportOptions::default()
    };
    let own = imported("robot.xml", text, &options).unwrap();
    assert!(
        own.contains("# joint `wrist` is held") && own.contains("left out, although it acts: actuator muscle `m`"),
        "{own}"
    );
    assert!(!own.contains("[bodies.tip]") && own.contains("drive = { start = 0.0 }"), "{own}");
    let sphere = 4.0 / 3.0 * std::f64::consts::PI * 1000.0;
    close(number(&own, "bodies.arm", "mass"), sphere * (0.001 + 0.000_125), 1e-14);
    let rooted = ImportOptions {
        root: Some("arm".to_owned()),
        leave_out: vec!["all".to_owned()],
        plane: Some(WorldPlane::Yz),
        ..ImportOptions::default()
    };
    let own = imported("robot.xml", text, &rooted).unwrap();
    assert!(own.contains("[bodies.tip]") && !own.contains("[bodies.arm]"), "{own}");
    let wrong =
        ImportOptions { lock: vec!["elbow".to_owned()], leave_out: vec!["all".to_owned()], ..ImportOptions::default() };
    assert!(refused(text, &wrong).contains("--lock elbow: the file has no such joint"));
}

/// A ball with two slides and a hinge is a free body; it falls on the floor and stays there. Without contacts it falls on.
#[test]
fn a_free_ball_falls_on_the_floor() {
    let text = r#"<mujoco><worldbody><geom type="plane" size="1 1 1" pos="0 0 -0.5"/>
      <body name="ball"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint axis="0 1 0"/><geom size="0.1" mass="1"/></body>
      </worldbody></mujoco>"#;
    let own = scene(text);
    assert!(!own.contains("prismatic") && own.contains("type    = \"contact\""), "{own}");
    let [y] = run(&own, 1.0, ["ball.y"]);
    close(y, -0.4, 1e-9);
    let none = ImportOptions { contacts: ContactChoice::None, ..ImportOptions::default() };
    let [y] = run(&imported("robot.xml", text, &none).unwrap(), 1.0, ["ball.y"]);
    close(y, -0.5 * 9.81, 1e-9);
}

/// Pairs of codes and values of a drawing in millimetres.
fn drawing(entities: &str) -> String {
    let text = format!("0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES {entities} 0 ENDSEC 0 EOF");
    text.split_whitespace().map(|word| format!("{word}\n")).collect()
}

fn line(layer: &str, [a, b, c, d]: [f64; 4]) -> String {
    format!("0 LINE 8 {layer} 10 {a} 20 {b} 11 {c} 21 {d} ")
}

fn circle(layer: &str, [x, y]: [f64; 2]) -> String {
    format!("0 CIRCLE 8 {layer} 10 {x} 20 {y} 40 2 ")
}

#[test]
fn a_drawn_pendulum_swings_as_a_rod() {
    let text =
        drawing(&(line("BARS", [0.0, 0.0, 300.0, 0.0]) + &circle("PINS", [0.0, 0.0]) + &circle("GROUND", [0.0, 0.0])));
    let options = ImportOptions { gravity: Some([0.0, -9.81]), ..ImportOptions::default() };
    let own = imported("sketch.dxf", &text, &options).unwrap();
    close(number(&own, "bodies.link_1", "mass"), 0.3, 1e-12);
    let [alpha] = run(&own, 1e-9, ["link_1.alpha"]);
    // A rod on its end: 3 g/(2 l).
    close(alpha, -1.5 * 9.81 / 0.3, 1e-8);
    assert!(own.contains("# joint = \"P1\""), "{own}");
}

#[test]
fn a_drawing_that_leaves_something_open_is_refused_with_both_places() {
    let bars = line("BARS", [0.0, 0.0, 30.0, 40.0]) + &line("BARS", [30.3, 40.0, 90.0, 40.0]);
    let pins = circle("PINS", [0.0, 0.0]) + &circle("PINS", [30.0, 40.0]) + &circle("PINS", [90.0, 40.0]);
    let grounds = circle("GROUND", [0.0, 0.0]) + &circle("GROUND", [90.0, 40.0]);
    let whole = [bars.as_str(), &pins, &grounds].concat();
    let mut options = ImportOptions::default();
    let refuse = |text: &str, options: &ImportOptions, words: &[&str]| {
        let why = imported("sketch.dxf", &drawing(text), options).unwrap_err();
        words.iter().for_each(|word| assert!(why.contains(word), "no `{word}` in:\n{why}"));
    };
    refuse(&whole, &options, &["0.3000 mm", "30.300000,40.000000", "30.000000,40.000000", "--snap 0.4mm"]);
    options.dxf.snap = Some(4e-4);
    assert!(imported("sketch.dxf", &drawing(&whole), &options).is_ok());
    refuse(&[bars.as_str(), &pins].concat(), &options, &["ground", "--ground X,Y", "0.000000,0.000000"]);
    refuse(
        &(whole.clone() + &line("BARS", [500.0, 0.0, 600.0, 0.0])),
        &options,
        &["touches no pin", "500.000000,0.000000"],
    );
    refuse("0 TEXT 8 NOTES 1 hello", &options, &["no body", "--layer"]);
    refuse("0 LINE 8 BARS 10 1e400 20 0 11 1 21 1", &options, &["sketch.dxf:", "1e400"]);
    let cut = drawing(&whole);
    let why = imported("sketch.dxf", &cut[..cut.len() - 12], &options).unwrap_err();
    assert!(why.contains("breaks off"), "{why}");
}

/// Cut and changed files give one error each, and never a panic; this is a sample of what a fuzzer tries.
#[test]
fn damaged_files_are_errors() {
    let four_bar = fs::read_to_string(Path::new(ROOT).join("tests/import/four_bar.xml")).unwrap();
    let sketch =
        drawing(&(line("BARS", [0.0, 0.0, 30.0, 40.0]) + &circle("PINS", [0.0, 0.0]) + &circle("GROUND", [0.0, 0.0])));
    for (file, text) in [("robot.xml", four_bar), ("sketch.dxf", sketch)] {
        for cut in (0..text.len()).step_by(7) {
            let _ = imported(file, &text[..cut], &ImportOptions::default());
            for wrong in ["-1e308", "nan", "<", "\"", "0 0 0"] {
                let _ = imported(
                    file,
                    &[&text[..cut], wrong, &text[(cut + 3).min(text.len())..]].concat(),
                    &ImportOptions::default(),
                );
            }
        }
    }
}
