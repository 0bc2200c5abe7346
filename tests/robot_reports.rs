//! What an import says of a robot's file is true: an element that nobody knows is never called without effect, at any level of any format; floors, couplings, loops
//! and tendons act as closed forms and other spellings say.

use crate::robots::{close, imported, refused, run};

use cotree::import::{ContactChoice, ImportOptions, Imported, import_file};

const INERTIAL: &str =
    "<inertial><mass>1</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>";

fn read(text: &str) -> Imported {
    import_file("robot", "robot.xml", text.as_bytes(), &ImportOptions::default(), &|_| None)
        .unwrap_or_else(|all| panic!("{}\n{text}", all.join("\n")))
}

/// Puts the element behind the end of each opening tag; it must be refused by its name, or be listed as what can act.
fn unknown_elements_are_named(text: &str) {
    let mut tried = 0;
    for (at, _) in text.match_indices('>') {
        let tag = &text[text[..at].rfind('<').unwrap()..=at];
        if tag.ends_with("/>") || tag.starts_with("</") {
            continue;
        }
        let damaged = format!("{}<mystery/>{}", &text[..=at], &text[at + 1..]);
        match imported("robot.xml", &damaged, &ImportOptions::default()) {
            Err(why) => assert!(why.contains("mystery"), "{tag}: {why}"),
            Ok(_) => {
                let notes = read(&damaged).notes;
                let named: Vec<&String> = notes.iter().filter(|note| note.contains("mystery")).collect();
                assert!(!named.is_empty(), "{tag}: nothing is said:\n{}", notes.join("\n"));
                assert!(named.iter().all(|note| note.starts_with("left out, although it can act")), "{tag}: {named:?}");
            }
        }
        tried += 1;
    }
    assert!(tried >= 12, "only {tried} places");
}

#[test]
fn what_no_format_has_is_named_at_every_level() {
    let sdf = format!(
        r#"<sdf version="1.9"><world name="w"><gravity>0 0 -9.8</gravity><physics name="p" type="ode"></physics><model name="m"><frame name="f"><pose>0 0 0 0 0 0</pose></frame>
        <link name="a"><pose>0 0 1 0 0 0</pose>{INERTIAL}<collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry><surface><friction><ode><mu>0.5</mu></ode></friction><contact></contact></surface></collision></link>
        <joint name="h" type="revolute"><parent>world</parent><child>a</child><axis><xyz>0 1 0</xyz><dynamics><damping>0.1</damping></dynamics><limit><lower>-1</lower></limit></axis></joint>
        <link name="b"><pose>0.3 0 1 0 0 0</pose>{INERTIAL}</link><joint name="k" type="revolute"><parent>world</parent><child>b</child><axis><xyz>0 1 0</xyz><mimic joint="h"><multiplier>1</multiplier></mimic></axis></joint></model></world></sdf>"#
    );
    unknown_elements_are_named(&sdf);
    let inertial = "<inertial><origin xyz=\"0 0 -0.1\"></origin><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>";
    let urdf = format!(
        r#"<robot name="r"><link name="base"></link><link name="a">{inertial}<collision><geometry><sphere radius="0.1"/></geometry></collision></link>
        <joint name="h" type="revolute"><parent link="base"></parent><child link="a"></child><axis xyz="0 1 0"></axis><limit lower="-1" upper="1"></limit><dynamics damping="0.1"></dynamics></joint>
        <transmission name="t"><joint name="h"></joint><actuator name="motor"></actuator></transmission><gazebo reference="a"></gazebo><gazebo></gazebo></robot>"#
    );
    unknown_elements_are_named(&urdf);
    let mjcf = r#"<mujoco><option></option><default><joint></joint></default><worldbody><body name="a"><joint name="h" axis="0 1 0"></joint><geom size=".1"></geom><site name="s"></site><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"></inertial></body></worldbody>
        <tendon><fixed name="t"><joint joint="h" coef="1"></joint></fixed></tendon><equality></equality><actuator><motor joint="h"></motor></actuator><contact></contact><keyframe><key></key></keyframe></mujoco>"#;
    unknown_elements_are_named(mjcf);
}

/// Attributes, plugins, and settings that act where they are not zero.
#[test]
fn what_can_act_is_not_called_without_effect() {
    let link = |inside: &str| {
        format!(
            "<sdf version=\"1.9\"><model name=\"m\"><link name=\"a\">{INERTIAL}{inside}</link><joint name=\"h\" type=\"revolute\"><parent>world</parent><child>a</child><axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"
        )
    };
    let acting = |text: &str, word: &str| {
        let notes = read(text).notes;
        notes.iter().any(|note| note.contains(word) && note.starts_with("left out, although it can act"))
    };
    for (inside, word) in [
        ("<kinematic>true</kinematic>", "<kinematic>"),
        ("<enable_wind>1</enable_wind>", "<enable_wind>"),
        ("<plugin name=\"p\" filename=\"libspring.so\"/>", "libspring.so"),
        (
            "<collision name=\"c\"><geometry><sphere><radius>1</radius></sphere></geometry><surface><bounce><restitution_coefficient>0.5</restitution_coefficient></bounce></surface></collision>",
            "restitution_coefficient",
        ),
        ("<pose turned=\"true\">0 0 0 0 0 0</pose>", "`turned`"),
    ] {
        assert!(acting(&link(inside), word), "{inside}: {:?}", read(&link(inside)).notes);
    }
    for inside in [
        "<kinematic>false</kinematic>",
        "<enable_wind>0</enable_wind>",
        "<visual name=\"v\"/>",
        "<plugin name=\"p\" filename=\"gz-sim-imu-system\"/>",
    ] {
        let notes = read(&link(inside)).notes.join("\n");
        assert!(!notes.contains("although"), "{inside}: {notes}");
    }
    // A constraint that has no counterpart would change the degrees of freedom.
    let held = link("").replace("</model>", "<drake:weld_constraint><body>a</body></drake:weld_constraint></model>");
    let why = refused(&held, &ImportOptions::default());
    assert!(why.contains("drake:weld_constraint") && why.contains("--leave-out"), "{why}");
    let options = ImportOptions { leave_out: vec!["drake:weld_constraint".to_owned()], ..ImportOptions::default() };
    assert!(imported("robot.xml", &held, &options).unwrap().contains("although it acts"));
}

/// A ball of 0.1 m that falls from 1 m is on the floor after sqrt(2 0.9/g), and stays there.
#[test]
fn collisions_with_a_floor_are_contacts() {
    let ball = format!(
        r#"<model name="ball"><link name="ball"><pose>0 0 1 0 0 0</pose>{INERTIAL}<collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link>
        <joint name="z" type="prismatic"><parent>world</parent><child>ball</child><axis><xyz>0 0 1</xyz></axis></joint></model>"#
    );
    let floor = r#"<model name="ground_plane"><static>true</static><link name="link"><collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>"#;
    let plain = format!("<sdf version=\"1.9\"><world name=\"w\">{floor}{ball}</world></sdf>");
    let included = format!(
        "<sdf version=\"1.9\"><world name=\"w\"><include><uri>model://sun</uri></include><include><uri>model://ground_plane</uri></include>{ball}</world></sdf>"
    );
    let urdf = r#"<robot name="r"><link name="base"><collision><geometry><plane normal="0 0 1"/></geometry></collision></link>
        <link name="ball"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
        <link name="mast"><inertial><mass value="0"/></inertial></link>
        <joint name="fixed" type="fixed"><parent link="base"/><child link="mast"/><origin xyz="0 0 1"/></joint>
        <joint name="z" type="prismatic"><parent link="mast"/><child link="ball"/><axis xyz="0 0 1"/></joint></robot>"#;
    for text in [&plain, &included] {
        let scene = read(text).scene;
        assert_eq!(scene.matches("type    = \"contact\"").count(), 1, "{scene}");
        let fall = (2.0 * 0.9 / 9.8f64).sqrt();
        let [speed] = run(&scene, fall - 1e-4, ["z.v"]);
        close(speed, -9.8 * (fall - 1e-4), 1e-8);
        let [place, speed] = run(&scene, 1.0, ["z.s", "z.v"]);
        assert!((place + 0.9).abs() < 1e-9 && speed.abs() < 1e-9, "{place} {speed}");
    }
    let scene = read(urdf).scene;
    assert_eq!(scene.matches("type    = \"contact\"").count(), 1, "{scene}");
    let [place] = run(&scene, 1.0, ["z.s"]);
    assert!((place + 0.9).abs() < 1e-9, "{place}");
    let none = ImportOptions { contacts: ContactChoice::None, ..ImportOptions::default() };
    assert!(!imported("robot.xml", &plain, &none).unwrap().contains("\"contact\""));
}

/// Links of one model touch where it says `self_collide`, by the masks of both.
#[test]
fn masks_and_self_collision_are_obeyed() {
    let link = |name: &str, x: f64, surface: &str| {
        format!(
            "<link name=\"{name}\"><pose>{x} 0 1 0 0 0</pose>{INERTIAL}<collision name=\"c\"><geometry><sphere><radius>0.1</radius></sphere></geometry>{surface}</collision></link><joint name=\"{name}_z\" type=\"prismatic\"><parent>world</parent><child>{name}</child><axis><xyz>1 0 0</xyz></axis></joint>"
        )
    };
    let model = |own: &str, mask: &str| {
        let surface = format!("<surface><contact><collide_bitmask>{mask}</collide_bitmask></contact></surface>");
        format!(
            "<sdf version=\"1.9\"><model name=\"m\"><self_collide>{own}</self_collide>{}{}</model></sdf>",
            link("a", 0.0, &surface),
            link("b", 1.0, "<surface><contact><collide_bitmask>0x02</collide_bitmask></contact></surface>")
        )
    };
    let all = ImportOptions { contacts: ContactChoice::All, ..ImportOptions::default() };
    for (own, mask, contacts) in [("true", "3", 1), ("true", "1", 0), ("false", "3", 0)] {
        let scene = imported("robot.xml", &model(own, mask), &all).unwrap();
        assert_eq!(scene.matches("type    = \"contact\"").count(), contacts, "{own} {mask}");
    }
}

/// theta_2 = -ratio theta_1 of a gearbox, q = multiplier q_leader of a mimic, and each of two equal models follows its own joint.
#[test]
fn gearboxes_and_mimics_couple_their_own_joints() {
    let wheel = |name: &str, x: f64, offset: f64| {
        format!(
            "<link name=\"{name}\"><pose>{x} 0 1 0 0 0</pose><inertial><pose>{offset} 0 0 0 0 0</pose><mass>1</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link>"
        )
    };
    let hinge = |name: &str, child: &str, inside: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent>frame</parent><child>{child}</child><axis><xyz>0 1 0</xyz>{inside}</axis></joint>"
        )
    };
    let fixed = format!(
        "<link name=\"frame\">{INERTIAL}</link><joint name=\"fix\" type=\"fixed\"><parent>world</parent><child>frame</child></joint>"
    );
    let gearbox = "<joint name=\"box\" type=\"gearbox\"><parent>first</parent><child>second</child><gearbox_ratio>2.5</gearbox_ratio><gearbox_reference_body>frame</gearbox_reference_body><axis><xyz>0 1 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint>";
    let geared = format!(
        "<sdf version=\"1.9\"><model name=\"m\">{fixed}{}{}{}{}{gearbox}</model></sdf>",
        wheel("first", 0.0, 0.2),
        wheel("second", 0.5, 0.0),
        hinge("h1", "first", ""),
        hinge("h2", "second", "")
    );
    // I theta'' = m g r cos theta about +y with I = I1 + m r^2 + 2.5^2 I2: the energy tells the rate.
    let [first, second, rate] = run(&read(&geared).scene, 0.7, ["q_h1", "q_h2", "first.omega"]);
    close(second, -2.5 * first, 1e-9);
    let inertia = 0.1 + 0.04 + 6.25 * 0.1;
    close(0.5 * inertia * rate * rate, 9.8 * 0.2 * first.sin().abs(), 1e-8);
    let opposite = geared.replace("<axis2><xyz>0 1 0</xyz></axis2>", "<axis2><xyz>0 -1 0</xyz></axis2>");
    let [first, second] = run(&read(&opposite).scene, 0.7, ["q_h1", "q_h2"]);
    close(second, 2.5 * first, 1e-9);
    let finger = |model: &str, ratio: f64, offset: f64| {
        format!(
            "<model name=\"{model}\"><pose>{offset} 0 0 0 0 0</pose>{fixed}{}{}{}{}</model>",
            wheel("first", 0.0, 0.1),
            wheel("second", 0.5, 0.1),
            hinge("h1", "first", ""),
            hinge("h2", "second", &format!("<mimic joint=\"h1\"><multiplier>{ratio}</multiplier></mimic>"))
        )
    };
    let two = format!(
        "<sdf version=\"1.11\"><world name=\"w\">{}{}</world></sdf>",
        finger("left", 2.0, 0.0),
        finger("right", -0.5, 3.0)
    );
    let scene = read(&two).scene;
    let outputs: Vec<&str> =
        scene.lines().filter(|line| line.starts_with("q_")).filter_map(|line| line.split(' ').next()).collect();
    let [a, b, c, d] = run(&scene, 0.5, [0, 1, 2, 3].map(|index| outputs[index]));
    let mut ratios = [b / a, d / c];
    ratios.sort_by(f64::total_cmp);
    close(ratios[0], -0.5, 1e-8);
    close(ratios[1], 2.0, 1e-8);
}

/// A loop by Drake's ball constraint moves as the one by a joint; a spring of Drake's swings as sqrt(k/m) says, in both formats.
#[test]
fn loops_and_springs_of_drake_are_exact() {
    let bar = |name: &str, x: f64, z: f64, com: [f64; 2]| {
        format!(
            "<link name=\"{name}\"><pose>{x} 0 {z} 0 0 0</pose><inertial><pose>{} 0 {} 0 0 0</pose><mass>1</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial></link>",
            com[0], com[1]
        )
    };
    let hinge = |name: &str, parent: &str, child: &str, pose: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\">{pose}<parent>{parent}</parent><child>{child}</child><axis><xyz>0 1 0</xyz></axis></joint>"
        )
    };
    let four_bar = |closure: &str| {
        format!(
            "<sdf version=\"1.9\"><model name=\"m\">{}{}{}{}{}{}{closure}</model></sdf>",
            bar("a", 0.0, 0.0, [0.05, -0.1]),
            bar("b", 0.3, 0.0, [0.0, -0.15]),
            bar("c", 0.0, -0.2, [0.15, -0.05]),
            hinge("ja", "world", "a", ""),
            hinge("jb", "world", "b", ""),
            hinge("jc", "a", "c", "")
        )
    };
    let ball = four_bar(
        "<drake:ball_constraint><drake:ball_constraint_body_A>b</drake:ball_constraint_body_A><drake:ball_constraint_p_AP>0 0 -0.3</drake:ball_constraint_p_AP><drake:ball_constraint_body_B>c</drake:ball_constraint_body_B><drake:ball_constraint_p_BQ>0.3 0 -0.1</drake:ball_constraint_p_BQ></drake:ball_constraint>",
    );
    let joint = four_bar(&hinge("jd", "c", "b", "<pose>0 0 -0.3 0 0 0</pose>"));
    let angles = [ball, joint].map(|text| run(&read(&text).scene, 0.4, ["q_ja", "q_jb", "q_jc"]));
    assert!(angles[0][0].abs() > 0.05);
    for (a, b) in angles[0].iter().zip(angles[1]) {
        close(*a, b, 1e-8);
    }
    let (stiffness, free) = (90.0, 0.5);
    let spring = |text: bool| {
        ["body_A", "p_AP", "body_B", "p_BQ", "free_length", "stiffness", "damping"]
            .into_iter()
            .zip(["world", "0 0 0", "car", "0 0 0", "0.5", "90", "0"])
            .map(|(key, value)| match text {
                true => format!("<drake:linear_spring_damper_{key}>{value}</drake:linear_spring_damper_{key}>"),
                false => {
                    let attribute = if key.starts_with("body") { "name" } else { "value" };
                    format!("<drake:linear_spring_damper_{key} {attribute}=\"{value}\"/>")
                }
            })
            .collect::<String>()
    };
    let sdf = format!(
        "<sdf version=\"1.9\"><model name=\"m\"><link name=\"car\"><pose>0.7 0 0 0 0 0</pose>{INERTIAL}</link><joint name=\"x\" type=\"prismatic\"><parent>world</parent><child>car</child><axis><xyz>1 0 0</xyz></axis></joint><drake:linear_spring_damper>{}</drake:linear_spring_damper></model></sdf>",
        spring(true)
    );
    let urdf = format!(
        "<robot name=\"r\"><link name=\"car\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link><joint name=\"x\" type=\"prismatic\"><origin xyz=\"0.7 0 0\"/><parent link=\"world\"/><child link=\"car\"/><axis xyz=\"1 0 0\"/><limit effort=\"1\" velocity=\"1\"/></joint><drake:linear_spring_damper>{}</drake:linear_spring_damper></robot>",
        spring(false)
    );
    let omega = f64::sqrt(stiffness);
    for text in [sdf, urdf] {
        let [place] = run(&read(&text).scene, 0.8, ["x.s"]);
        close(place, (0.7 - free) * ((omega * 0.8).cos() - 1.0), 1e-8);
    }
}

/// A rope over two eyes is an Atwood machine; about a cylinder it is one, too. Its winding sign is that of the shorter way.
#[test]
fn tendons_run_over_sites_and_cylinders() {
    let weights = r#"<body name="w" pos="0.5 0 0.5"><joint name="z" type="slide" axis="0 0 1"/><geom size="0.05" mass="1"/><site name="hook"/></body>
        <body name="c" pos="0 0 0.4"><joint name="y" type="slide" axis="0 0 1"/><geom size="0.05" mass="1.5"/><site name="h2"/></body>"#;
    let eyes = format!(
        r#"<mujoco><worldbody><site name="top" pos="0 0 1"/><site name="eye" pos="0.5 0 1"/>{weights}</worldbody>
        <tendon><spatial name="rope" limited="true" range="0 1.6"><site site="hook"/><site site="eye"/><site site="top"/><site site="h2"/></spatial></tendon></mujoco>"#
    );
    let length = 0.5 + 0.6 + std::f64::consts::PI * 0.25;
    let wheel = format!(
        r#"<mujoco><worldbody><geom name="wheel" type="cylinder" size="0.25 0.1" pos="0.25 0 1" euler="90 0 0" contype="0" conaffinity="0"/><site name="over" pos="0.25 0 2"/>{weights}</worldbody>
        <tendon><spatial name="rope" limited="true" range="0 {length}"><site site="hook"/><geom geom="wheel" sidesite="over"/><site site="h2"/></spatial></tendon></mujoco>"#
    );
    let acceleration = 0.5 / 2.5 * 9.81;
    for (text, word) in [(&eyes, "radius = 0 }"), (&wheel, "radius = 0.25")] {
        let scene = read(text).scene;
        assert!(scene.contains("over    = [") && scene.contains(word), "{scene}");
        let [up, down] = run(&scene, 0.3, ["z.s", "y.s"]);
        close(up, 0.045 * acceleration, 1e-7);
        close(down, -0.045 * acceleration, 1e-7);
    }
    // Beside the cylinder at the start: MuJoCo lets it run straight there.
    let beside = wheel.replace("pos=\"0.25 0 1\"", "pos=\"0.25 0 9\"").replace(" sidesite=\"over\"", "");
    let why = refused(&beside, &ImportOptions::default());
    assert!(why.contains("`wheel`") && why.contains("does not touch"), "{why}");
}

/// An equality of one fixed tendon holds the sum of its joints: c1 q1 + c2 q2 = 0.
#[test]
fn an_equality_of_a_fixed_tendon_is_a_gear() {
    let text = r#"<mujoco><compiler angle="radian"/><worldbody><body name="a"><joint name="p" axis="0 1 0"/><geom size=".1" pos=".3 0 0"/></body><body name="b" pos="1 0 0"><joint name="q" axis="0 1 0"/><geom size=".1"/></body></worldbody>
        <tendon><fixed name="t"><joint joint="p" coef="1"/><joint joint="q" coef="2"/></fixed></tendon><equality><tendon tendon1="t"/></equality></mujoco>"#;
    let [p, q] = run(&read(text).scene, 0.4, ["q_p", "q_q"]);
    assert!(p.abs() > 0.1);
    close(q, -0.5 * p, 1e-9);
    let two = text.replace("tendon1=\"t\"", "tendon1=\"t\" tendon2=\"t\"");
    assert!(refused(&two, &ImportOptions::default()).contains("--leave-out"));
}

/// What has no name in the file is called by what it moves, or by its number; no message has an empty name.
#[test]
fn what_has_no_name_gets_one() {
    let text = r#"<mujoco><worldbody><body><joint name="hip" axis="0 1 0"/><geom size="0.1" mass="1" pos="0 0 -0.2"/><body pos="0 0 -0.3"><joint axis="0 1 0"/><geom size="0.1" mass="1"/></body></body></worldbody><actuator><motor joint="hip"/></actuator></mujoco>"#;
    let scene = read(text).scene;
    assert!(scene.contains("hip_input = { start = 0.0 }") && scene.contains("[joints.joint_2]"), "{scene}");
    let skew = text.replace("<joint axis=\"0 1 0\"/>", "<joint axis=\"1 0 0\"/>");
    let why = refused(&skew, &ImportOptions::default());
    assert!(why.contains("joint `joint_2`") && why.contains("--lock joint_2 locks it"), "{why}");
    let locked = ImportOptions { lock: vec!["joint_2".to_owned()], ..ImportOptions::default() };
    assert!(imported("robot.xml", &skew, &locked).is_ok());
    let generated = r#"<mujoco><worldbody><site name="a"/><replicate count="3"><body><joint axis="0 1 0"/><geom size=".1"/><site name="b"/></body></replicate></worldbody><tendon><spatial><site site="a"/><site site="b0"/></spatial></tendon></mujoco>"#;
    let why = refused(generated, &ImportOptions::default());
    assert!(why.contains("robot.xml:1:") && why.contains("<replicate>"), "{why}");
}

/// A loop of two frames that lie 2 cm apart is assembled, and the distance is said; one that is open by half its size is refused.
#[test]
fn frames_that_lie_apart_are_assembled() {
    let robot = |gap: f64| {
        let link = |name: &str, x: f64, z: f64| {
            format!(
                "<link name=\"{name}\"><inertial><origin xyz=\"{x} 0 {z}\"/><mass value=\"1\"/><inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\"/></inertial></link>"
            )
        };
        let hinge = |name: &str, parent: &str, child: &str, at: [f64; 2]| {
            format!(
                "<joint name=\"{name}\" type=\"continuous\"><origin xyz=\"{} 0 {}\"/><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"0 1 0\"/></joint>",
                at[0], at[1]
            )
        };
        format!(
            "<robot name=\"r\"><link name=\"base\"/>{}{}{}{}{}{}<loop name=\"closing\" type=\"continuous\"><predecessor link=\"c\"><origin xyz=\"{} 0 0\"/></predecessor><successor link=\"b\"><origin xyz=\"0 0 -0.2\"/></successor><axis xyz=\"0 1 0\"/></loop></robot>",
            link("a", 0.05, -0.1),
            link("b", 0.0, -0.1),
            link("c", 0.15, 0.0),
            hinge("ja", "base", "a", [0.0, 0.0]),
            hinge("jb", "base", "b", [0.3, 0.0]),
            hinge("jc", "a", "c", [0.0, -0.2]),
            0.3 + gap
        )
    };
    let closed = read(&robot(0.0));
    assert!(!closed.notes.iter().any(|note| note.contains("has a gap")));
    let apart = read(&robot(0.02));
    assert!(
        apart.notes.iter().any(|note| note.contains("loop `closing` has a gap of 2.000e-2 m")),
        "{:?}",
        apart.notes
    );
    // The bars are what the file says: the ends of the coupler and of the rocker coincide in the scene.
    let [energy, later] = [1e-3, 0.3].map(|stop| run(&apart.scene, stop, ["energy.total"])[0]);
    close(later, energy, 1e-7);
    assert!(refused(&robot(0.25), &ImportOptions::default()).contains("assembly mode would be a guess"));
}
