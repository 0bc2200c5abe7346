//! Robots and drawings as scenes: masses, axes, loops and forces as MuJoCo, elementary formulas and two spellings of one robot say; what cannot be imported is refused by name.

use crate::outside::command;
use crate::support::ROOT;

use std::fs;
use std::path::Path;

use command::{code, cotree, stderr, stdout};
use cotree::import::{AttributeClass, ContactChoice, ImportOptions, WorldPlane, class_of, import_file};

pub fn imported(file: &str, text: &str, options: &ImportOptions) -> Result<String, String> {
    import_file("scene", file, text.as_bytes(), options, &|_| None).map(|own| own.scene).map_err(|all| all.join("\n"))
}

fn scene(text: &str) -> String {
    imported("robot.xml", text, &ImportOptions::default()).unwrap_or_else(|why| panic!("{why}"))
}

pub fn refused(text: &str, options: &ImportOptions) -> String {
    match imported("robot.xml", text, options) {
        Err(why) => why,
        Ok(scene) => panic!("is imported:\n{scene}"),
    }
}

/// The last row of a run, by the names of the variables.
pub fn run<const N: usize>(scene: &str, stop: f64, names: [&str; N]) -> [f64; N] {
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

pub fn close(a: f64, b: f64, share: f64) {
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
            &["would leave the plane", "--in-plane"],
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
        own.contains("# joint `wrist` is locked") && own.contains("left out, although it acts: actuator muscle `m`"),
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

/// A wheel (a cylinder about the hinges) and a box that stands on an incline as steep as the angle of friction allows or not; corners inside the outline are none.
#[test]
fn cylinders_and_boxes_touch_planes() {
    let text = |tilt: f64, geom: &str| {
        format!(
            r#"<mujoco><default><geom friction="0.5"/></default><worldbody><geom name="floor" type="plane" size="1 1 1" euler="0 {tilt} 0"/>
      <body name="own" pos="0 0 0.1"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint axis="0 1 0"/>{geom}</body></worldbody></mujoco>"#
        )
    };
    let slope = 10f64.to_radians();
    let wheel = scene(&text(10.0, r#"<geom type="cylinder" size="0.1 0.02" euler="90 0 0" mass="2"/>"#));
    assert_eq!(wheel.matches("\"contact\"").count(), 1, "{wheel}");
    // A disc that is laid on the incline rolls: 2/3 g sin.
    let laid = wheel.replace("\"own.y\" = 0.1", &format!("\"own.y\" = {:?}", 0.1 / slope.cos()));
    let [ax] = run(&laid, 0.5, ["own.ax"]);
    close(ax, 2.0 / 3.0 * 9.81 * slope.sin() * slope.cos(), 1e-7);
    let box_of = |tilt: f64| scene(&text(tilt, r#"<geom type="box" size="0.1 0.2 0.1" mass="2"/>"#));
    assert_eq!(box_of(0.0).matches("\"contact\"").count(), 4, "{}", box_of(0.0));
    let [y, vx] = run(&box_of(0.0), 0.3, ["own.y", "own.vx"]);
    assert!((y - 0.1).abs() < 1e-9 && vx.abs() < 1e-9, "{y} {vx}");
    let oblique = scene(&text(0.0, r#"<geom name="g" type="cylinder" size="0.1 0.2" euler="20 0 0"/>"#));
    assert!(
        oblique.contains("left out, although it can act: 1 x contact of a plane with a cylinder that is oblique")
            && oblique.contains("`floor_g`"),
        "{oblique}"
    );
}

/// Rates that are zero in the file are given, too: a scene chooses those that it is not given.
#[test]
fn a_start_has_all_rates() {
    let text = r#"<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><worldbody><body name="a"><joint name="j" axis="0 -1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0.4 0 0"/>
      <body name="b" pos="0.4 0 0"><joint name="k" axis="0 1 0"/><geom type="capsule" size="0.03" fromto="0 0 0 0.2 0 0"/></body></body></worldbody>
      <keyframe><key qpos="0.3 -0.4" qvel="0 1"/></keyframe></mujoco>"#;
    let [omega, other] = run(&scene(text), 1e-9, ["j.omega", "b.omega"]);
    assert!(omega.abs() < 1e-7 && (other + 1.0).abs() < 1e-7, "{omega} {other}");
}

/// Couplings of joints that have no body in common, of a hinge and a slide elsewhere, and of two slides.
#[test]
fn couplings_are_linear_wherever_their_joints_are() {
    let link = |name: &str| {
        format!(
            r#"<link name="{name}"><inertial><mass value="1"/><origin xyz="0 0 0.2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>"#
        )
    };
    let joint = |name: &str, kind: &str, parent: &str, child: &str, axis: &str, mimic: &str| {
        format!(
            r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="0.1 0 0.4"/><axis xyz="{axis}"/>{mimic}</joint>"#
        )
    };
    let links: String = ["a", "b", "c", "d", "e", "f"].into_iter().map(link).collect();
    let text = format!(
        r#"<robot name="chain"><link name="base"/>{links}{}{}{}{}{}{}</robot>"#,
        joint("ja", "continuous", "base", "a", "0 1 0", ""),
        joint("jb", "continuous", "a", "b", "0 1 0", r#"<mimic joint="ja" multiplier="-2" offset="0.1"/>"#),
        joint("jc", "continuous", "b", "c", "0 -1 0", r#"<mimic joint="jb" multiplier="0.5"/>"#),
        joint("jd", "prismatic", "c", "d", "1 0 0", r#"<mimic joint="ja" multiplier="0.2" offset="0.05"/>"#),
        joint("je", "prismatic", "base", "e", "0 0 1", r#"<mimic joint="jd" multiplier="-3"/>"#),
        joint("jf", "continuous", "e", "f", "0 1 0", r#"<mimic joint="je" multiplier="0.7" offset="-0.2"/>"#),
    );
    let own = scene(&text);
    let [energy] = run(&own, 1e-9, ["energy.total"]);
    let [a, b, c, d, e, f, after] = run(&own, 0.4, ["q_ja", "q_jb", "q_jc", "q_jd", "q_je", "q_jf", "energy.total"]);
    assert!(a.abs() > 0.1, "it moves: {a}");
    let (b_known, d_known) = (0.1 - 2.0 * a, 0.05 + 0.2 * a);
    for (value, known) in
        [(b, b_known), (c, 0.5 * b_known), (d, d_known), (e, -3.0 * d_known), (f, -0.2 - 2.1 * d_known)]
    {
        assert!((value - known).abs() < 1e-8, "{a} {b} {c} {d} {e} {f}");
    }
    assert!((after - energy).abs() < 1e-7, "{energy} {after}");
}

/// MuJoCo has one default for all kinds of actuators, and `ctrl` and `act` have numbers for those that are left out.
#[test]
fn actuators_share_defaults_and_places_in_keyframes() {
    let text = |actuators: &str| {
        format!(
            r#"<mujoco><default><general ctrlrange="-1 1" gear="3"/></default><worldbody><body name="a"><joint name="j" axis="0 0 1"/><geom size="0.1"/></body></worldbody>
      <actuator>{actuators}</actuator><keyframe><key ctrl="0.1 0.2 0.3" act="0.4 0.5"/></keyframe></mujoco>"#
        )
    };
    let three = r#"<motor name="m" joint="j"/><muscle name="pull" joint="j"/><intvelocity name="v" joint="j" kp="2" actrange="-1 1"/>"#;
    let options = ImportOptions { leave_out: vec!["pull".to_owned()], ..ImportOptions::default() };
    let own = imported("robot.xml", &text(three), &options).unwrap();
    for line in [
        "m = { start = 0.1, min = -1.0, max = 1.0 }",
        "v = { start = 0.3, min = -1.0, max = 1.0 }",
        "v_act = { start = 0.5",
        "3.0*(",
    ] {
        assert!(own.contains(line), "no {line}\n{own}");
    }
    let short = three.replace("<muscle name=\"pull\" joint=\"j\"/>", "");
    assert!(refused(&text(&short), &options).contains("`ctrl` has 3 numbers, but the model has 2"));
    let mixed = text(three).replace("gear=\"3\"", "gainprm=\"3\"").replace(" kp=\"2\"", "");
    assert!(
        imported("robot.xml", &mixed, &options).unwrap_err().contains("`gainprm` from the default of another kind")
    );
}

/// What acts along a joint that closes a loop is the scene's, with the signs of the file: a four-bar whose closing hinge has a spring, a damper and a limit is the one whose
/// closing hinge is another one.
#[test]
fn joints_that_close_loops_keep_their_laws() {
    let link = |name: &str, pose: &str| {
        format!(
            r#"<link name="{name}"><pose>{pose}</pose><inertial><pose>0.05 0 0.02 0 0 0</pose><mass>0.4</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial></link>"#
        )
    };
    let joint = |name: &str, parent: &str, child: &str, pose: &str, laws: &str| {
        format!(
            r#"<joint name="{name}" type="revolute"><pose relative_to="__model__">{pose}</pose><parent>{parent}</parent><child>{child}</child><axis><xyz expressed_in="__model__">0 1 0</xyz>{laws}</axis></joint>"#
        )
    };
    let laws = "<dynamics><damping>0.02</damping><spring_stiffness>0.8</spring_stiffness><spring_reference>0.3</spring_reference></dynamics>";
    let sdf = |joints: &[String]| {
        let links =
            [link("crank", "0 0 0 0 0 0"), link("rod", "0.05 0 0.2 0 0 0"), link("rocker", "0.4 0 0 0 0 0")].concat();
        format!(
            r#"<sdf version="1.9"><world name="w"><gravity>0 0 -9.81</gravity><model name="m">{links}{}</model></world></sdf>"#,
            joints.concat()
        )
    };
    let (a, b, d) = (
        joint("a", "world", "crank", "0 0 0 0 0 0", ""),
        joint("b", "crank", "rod", "0.05 0 0.2 0 0 0", ""),
        joint("d", "world", "rocker", "0.4 0 0 0 0 0", ""),
    );
    let c = joint("c", "rod", "rocker", "0.45 0 0.3 0 0 0", laws);
    // The rocker has its parent `world` first, so that c closes the loop; then c is in the tree, and d closes it.
    let closing = scene(&sdf(&[a.clone(), b.clone(), d.clone(), c.clone()]));
    let tree = scene(&sdf(&[a, b, c, d]));
    assert!(closing.contains("torsion_spring") && closing.contains("damping = 0.02"), "{closing}");
    let [first, second] = [closing, tree].map(|own| run(&own, 0.4, ["crank.angle", "rod.angle", "rocker.angle"]));
    for (one, other) in first.iter().zip(second) {
        assert!((one - other).abs() < 1e-8 && one.abs() > 0.01, "{first:?} {second:?}");
    }
}

/// Robots of the kinds that are public: grippers with two four-bars, five-bars with meshes, acrobats, hoppers and fingers run; what a fluid or a slider-crank transmission moves is
/// refused by name, and runs with what the message says.
#[test]
fn kinds_of_public_robots_run_or_are_refused_by_name() {
    let gripper = {
        let side = |s: &str, x: f64| {
            format!(
                r#"<body name="{s}_driver" pos="{x} 0 0.05"><joint name="{s}_driver" class="driver"/><inertial mass="0.009" pos="0 0 0.02" quat="1 0 0 0" diaginertia="2e-6 2e-6 1e-6"/>
            <body name="{s}_coupler" pos="0 0 0.04"><joint name="{s}_coupler" class="coupler"/><inertial mass="0.014" pos="0 0 0.01" diaginertia="3e-6 3e-6 1e-6"/><geom type="mesh" mesh="pad" class="visual"/></body></body>
          <body name="{s}_spring" pos="{} 0 0.05"><joint name="{s}_spring" class="spring"/><inertial mass="0.02" pos="0 0 0.02" diaginertia="3e-6 3e-6 1e-6"/>
            <body name="{s}_follower" pos="0 0 0.04"><joint name="{s}_follower" class="follower"/><inertial mass="0.013" pos="0 0 0.01" diaginertia="2e-6 2e-6 1e-6"/></body></body>"#,
                0.6 * x
            )
        };
        format!(
            r#"<mujoco model="gripper"><compiler angle="radian" meshdir="assets" autolimits="true"/><option cone="elliptic" impratio="10"/><asset><mesh name="pad" file="pad.stl"/></asset>
        <default><default class="gripper"><joint axis="0 1 0"/><general biastype="affine"/>
          <default class="visual"><geom contype="0" conaffinity="0" mass="0" group="2"/></default>
          <default class="driver"><joint range="0 0.8" armature="0.005" damping="0.1" solreflimit="0.005 1"/></default>
          <default class="follower"><joint range="-0.87 0.87" solreflimit="0.005 1"/></default>
          <default class="spring"><joint range="-0.3 0.8" stiffness="0.05" springref="2.62" damping="0.00125"/></default>
          <default class="coupler"><joint range="-1.57 1"/></default></default></default>
        <worldbody><body name="base" childclass="gripper"><geom class="visual" type="mesh" mesh="pad"/>{}{}</body></worldbody>
        <contact><exclude body1="base" body2="left_driver"/></contact>
        <tendon><fixed name="split"><joint joint="left_driver" coef="0.5"/><joint joint="right_driver" coef="0.5"/></fixed></tendon>
        <equality><connect anchor="0.01 0 0.03" body1="left_coupler" body2="left_follower" solimp="0.95 0.99 0.001" solref="0.005 1"/>
          <connect anchor="-0.01 0 0.03" body1="right_coupler" body2="right_follower"/><joint joint1="right_driver" joint2="left_driver" polycoef="0 1 0 0 0"/></equality>
        <actuator><general class="gripper" name="fingers" tendon="split" forcerange="-5 5" ctrlrange="0 255" gainprm="0.0018" biasprm="0 -1 -0.1"/></actuator></mujoco>"#,
            side("left", -0.03),
            side("right", 0.03)
        )
    };
    let hopper = r#"<mujoco model="hopper"><compiler settotalmass="14"/><default><default class="hop"><joint type="hinge" axis="0 1 0" limited="true" damping=".05" armature=".2"/><geom type="capsule" material="self"/></default></default>
      <option timestep="0.005"/><asset><material name="self" rgba="1 1 0 1"/></asset><worldbody><geom name="floor" type="plane" conaffinity="1" pos="48 0 0" size="50 1 .2"/>
      <body name="torso" pos="0 0 1" childclass="hop"><joint name="rootx" type="slide" pos="0 0 0" axis="1 0 0" damping="0" armature="0" limited="false"/><joint name="rootz" type="slide" axis="0 0 1" damping="0" armature="0" limited="false"/>
       <joint name="rooty" axis="0 1 0" damping="0" armature="0" limited="false"/><geom name="torso" fromto="0 0 -.05 0 0 .2" size="0.0653"/>
       <body name="thigh" pos="0 0 -.2"><joint name="hip" range="-170 10"/><geom name="thigh" fromto="0 0 0 0 0 -.33" size="0.039"/>
       <body name="calf" pos="0 0 -.33"><joint name="knee" range="5 150"/><geom name="calf" fromto="0 0 0 0 0 -.32" size="0.035"/>
       <body name="foot" pos="0 0 -.32"><joint name="ankle" range="-45 45"/><geom name="foot" fromto="-.08 0 0 .17 0 0" size="0.04"/></body></body></body></body></worldbody>
      <actuator><motor name="hip" joint="hip" gear="30" ctrllimited="true" ctrlrange="-1 1"/><motor name="knee" joint="knee" gear="40" ctrlrange="-1 1"/></actuator></mujoco>"#;
    let finger = r#"<mujoco model="finger"><option gravity="0 0 -9.81" cone="elliptic"/><default><geom solimp="0 0.9 0.01" solref=".02 1"/><joint type="hinge" axis="0 -1 0"/><motor ctrllimited="true" ctrlrange="-1 1"/></default>
      <worldbody><body name="proximal" pos="-.2 0 .4"><geom name="base" type="cylinder" fromto="0 -.033 0 0 .033 0" size=".034" mass="0"/><joint name="proximal" range="-110 110" ref="-90"/><geom name="prox" type="capsule" fromto="0 0 0 0 0 -.17" size=".03"/>
       <body name="distal" pos="0 0 -.18"><joint name="distal" range="-110 110"/><geom name="dist" type="capsule" fromto="0 0 0 0 0 -.16" size=".028"/></body></body>
       <body name="spinner" pos=".2 0 .4"><joint name="hinge" frictionloss=".1" damping=".5"/><geom name="cap" type="capsule" fromto=".04 0 .09 0 0 0" size=".04"/></body></worldbody>
      <actuator><motor name="proximal" joint="proximal" gear="30"/><motor name="distal" joint="distal" gear="15"/></actuator></mujoco>"#;
    let five_bar = r#"<mujoco><compiler angle="radian" autolimits="true"/><asset><mesh name="arm" file="arm.stl"/></asset><worldbody><body name="base"><inertial pos="0 0 0" mass="1" fullinertia="1 1 1 0 0 0"/>
      <body name="left" pos="0 -0.05 0"><inertial pos="0 0 0.05" mass="0.1" fullinertia="1e-4 1e-4 1e-5 0 0 1e-7"/><joint name="l1" axis="1 1e-16 0" frictionloss="0.01" armature="0.005" range="-3 3"/><geom type="mesh" mesh="arm" contype="0"/>
       <body name="left_fore" pos="0.01 -0.03 0.1"><inertial pos="0 0.03 0.05" mass="0.1" diaginertia="1e-4 1e-4 1e-5"/><joint name="l2" axis="1 0 -2e-16"/><site name="end_left" pos="0 0.08 0.1"/></body></body>
      <body name="right" pos="0 0.05 0"><inertial pos="0 0 0.05" mass="0.1" diaginertia="1e-4 1e-4 1e-5"/><joint name="r1" axis="-1 0 0"/>
       <body name="right_fore" pos="0.01 0.03 0.1"><inertial pos="0 -0.03 0.05" mass="0.1" diaginertia="1e-4 1e-4 1e-5"/><joint name="r2" axis="1 0 0"/><site name="end_right" pos="0 -0.08 0.1"/></body></body></body></worldbody>
      <equality><connect site1="end_left" site2="end_right"/></equality></mujoco>"#;
    let split = r#"<robot name="split"><link name="base"/>
      <link name="a"><inertial><mass value="1"/><origin xyz="0.05 0.02 0"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="b1"><inertial><mass value="0.5"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <link name="b2"><inertial><mass value="0.5"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="c"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="ja" type="continuous"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/></joint><joint name="jb" type="continuous"><parent link="a"/><child link="b1"/><origin xyz="0.02 0 0.2"/><axis xyz="0 1 0"/></joint>
      <joint name="jc" type="continuous"><parent link="base"/><child link="c"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/></joint><joint name="jd" type="continuous"><parent link="c"/><child link="b2"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/></joint>
      <gazebo><joint name="weld" type="fixed"><parent>b1</parent><child>b2</child></joint></gazebo></robot>"#;
    let drake = r#"<sdf version="1.7"><model name="FourBar"><link name="A"><inertial><pose>2 0 0 0 0 0</pose><mass>20</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
      <link name="B"><pose relative_to="joint_AB">0 0 0 0 0 0</pose><inertial><pose>2 0 0 0 0 0</pose><mass>20</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial><visual name="v"><geometry><cylinder><radius>.1</radius><length>4</length></cylinder></geometry></visual></link>
      <joint name="joint_WA" type="revolute"><parent>world</parent><child>A</child><axis><xyz expressed_in="__model__">0 -1 0</xyz><initial_position>0.5</initial_position></axis></joint>
      <joint name="joint_AB" type="revolute"><pose relative_to="A">4 0 0 0 0 0</pose><parent>A</parent><child>B</child><axis><xyz>0 -1 0</xyz><limit><effort>0</effort></limit></axis></joint></model></sdf>"#;
    for (called, text, bodies) in [
        ("gripper", gripper.as_str(), 8),
        ("hopper", hopper, 4),
        ("finger", finger, 3),
        ("five-bar", five_bar, 4),
        ("split", split, 4),
        ("drake", drake, 2),
    ] {
        let own = scene(text);
        assert!(own.matches("\n[bodies.").count() >= bodies, "{called}:\n{own}");
        let [before] = run(&own, 1e-6, ["energy.total"]);
        let [after] = run(&own, 0.02, ["energy.total"]);
        assert!(before.is_finite() && after.is_finite(), "{called}");
    }
    let total: f64 = ["torso", "thigh", "calf", "foot"]
        .map(|body| number(&scene(hopper), &format!("bodies.{body}"), "mass"))
        .iter()
        .sum();
    close(total, 14.0, 1e-12);
    // What is included comes from beside the file.
    let acrobot = r#"<mujoco><include file="./common/materials.xml"/><default><joint damping=".05"/><geom type="capsule" mass="1"/></default><worldbody><geom name="floor" size="3 3 .2" type="plane" material="grid"/>
      <body name="upper" pos="0 0 2"><joint name="shoulder" axis="0 1 0"/><geom name="bolt" fromto="0 -.1 0 0 .1 0" size=".05" mass="0"/><geom fromto="0 0 0 0 0 1" size=".05"/><body name="lower" pos="0 0 1"><joint name="elbow" axis="0 1 0"/><geom fromto="0 0 0 0 0 1" size=".049"/></body></body></worldbody>
      <actuator><motor name="elbow" joint="elbow" gear="2" ctrllimited="true" ctrlrange="-1 1"/></actuator></mujoco>"#;
    let materials = |path: &str| {
        (path == "./common/materials.xml")
            .then(|| b"<mujoco><asset><material name=\"grid\"/></asset></mujoco>".to_vec())
    };
    assert!(import_file("acrobot", "acrobot.xml", acrobot.as_bytes(), &ImportOptions::default(), &materials).is_ok());
    assert!(refused(acrobot, &ImportOptions::default()).contains("`./common/materials.xml` cannot be read"));
    let swimmer = hopper.replace("<option timestep=\"0.005\"/>", "<option density=\"3000\"/>");
    let piston = finger.replace(
        "<motor name=\"distal\" joint=\"distal\" gear=\"15\"/>",
        "<general name=\"distal\" cranksite=\"s\" slidersite=\"t\" cranklength=\"0.1\"/>",
    );
    for (text, words, leave) in
        [(swimmer, ["fluid", "--leave-out fluid"], "fluid"), (piston, ["slider-crank", "--leave-out distal"], "distal")]
    {
        let why = refused(&text, &ImportOptions::default());
        words.iter().for_each(|word| assert!(why.contains(word), "no `{word}` in:\n{why}"));
        let options = ImportOptions { leave_out: vec![leave.to_owned()], ..ImportOptions::default() };
        assert!(imported("robot.xml", &text, &options).is_ok());
    }
}

/// Too many of anything is one error at once, and long values are cut.
#[test]
fn files_that_are_no_mechanism_are_refused_at_once() {
    let many: String = (0..1500)
        .map(|i| format!("<body name=\"b{i}\"><joint name=\"j{i}\" axis=\"0 1 0\"/><geom size=\".1\"/></body>"))
        .collect();
    let why = refused(&format!("<mujoco><worldbody>{many}</worldbody></mujoco>"), &ImportOptions::default());
    assert!(why.contains("1500 joints") && why.contains("--root"), "{why}");
    let long = format!("<mujoco><worldbody><geom pos=\"{}\"/></worldbody></mujoco>", "0 ".repeat(100_000));
    assert!(refused(&long, &ImportOptions::default()).len() < 300);
    let lines: String =
        (0..3000).map(|i| line("BARS", [f64::from(i), 0.0, f64::from(i + 1), f64::from(i % 7)])).collect();
    let why = imported("sketch.dxf", &drawing(&lines), &ImportOptions::default()).unwrap_err();
    assert!(why.contains("more than 1000 bodies") && why.starts_with("sketch.dxf:"), "{why}");
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
        &["does not touch a pin", "500.000000,0.000000"],
    );
    refuse("0 TEXT 8 NOTES 1 hello", &options, &["no body", "--layer"]);
    refuse("0 LINE 8 BARS 10 1e400 20 0 11 1 21 1", &options, &["sketch.dxf:", "1e400"]);
    let cut = drawing(&whole);
    let why = imported("sketch.dxf", &cut[..cut.len() - 12], &options).unwrap_err();
    assert!(why.contains("truncated"), "{why}");
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
