//! Slips of the pen in a scene: the message says how the line is written, and what it says can be read.

use cotree::scene::{Faults, Scene, Severity};

/// A scene with a line in the table of its only body.
fn scene(line: &str) -> String {
    format!(
        "name = \"plate\"\n[bodies.plate]\n{line}\ninertia = 0.02\n[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"plate\"]\n"
    )
}

fn faults(text: &str) -> Option<Faults> {
    Scene::from_toml(text).and_then(|scene| scene.resolve()).err()
}

/// The advice of the only fault of a scene.
fn advice(text: &str) -> String {
    let faults = faults(text).unwrap_or_else(|| panic!("no fault: {text}"));
    let errors: Vec<_> = faults.list.iter().filter(|fault| fault.severity == Severity::Error).collect();
    assert_eq!(errors.len(), 1, "{}", faults.render(false, 100));
    errors[0].help.to_string()
}

#[test]
fn a_line_that_cannot_be_read_is_shown_as_it_can_be() {
    let cases = [
        ("mass = 2 // kg", "mass = 2 # kg"),
        ("mass = 2 % kg", "mass = 2 # kg"),
        ("mass = 2 /* kg */", "mass = 2 # kg"),
        ("mass = 2;", "mass = 2"),
        ("mass = 2,", "mass = 2"),
        ("mass = 2; # kg", "mass = 2 # kg"),
        ("mass: 2", "mass = 2"),
        ("mass := 2", "mass = 2"),
        ("mass == 2", "mass = 2"),
        ("mass 2", "mass = 2"),
        ("mass = “2 kg”", "mass = \"2 kg\""),
        ("mass = „2 kg“", "mass = \"2 kg\""),
        ("mass = «2 kg»", "mass = \"2 kg\""),
        ("mass = ``2 kg''", "mass = \"2 kg\""),
        ("mass = \"2 kg”", "mass = \"2 kg\""),
        ("mass = \"2 kg", "mass = \"2 kg\""),
        ("mass = 2 kg\"", "mass = \"2 kg\""),
        ("mass = '2 kg\"", "mass = \"2 kg\""),
        ("mass = 2 kg", "mass = \"2 kg\""),
        ("mass = 2,5", "mass = 2.5"),
        ("mass = 2,5 kg", "mass = \"2.5 kg\""),
        ("mass = 1 000", "mass = 1000"),
        ("mass = .5", "mass = 0.5"),
        ("mass = 5.", "mass = 5.0"),
        ("mass = 2 [kg]", "mass = \"2 kg\""),
        ("mass [kg] = 2", "mass = \"2 kg\""),
        ("mass ＝ ２．５", "mass = 2.5"),
        ("mass\u{a0}= 2", "mass = 2"),
        ("mass = 2\u{200b}", "mass = 2"),
        ("mass = 2\ncom = [0, −1]", "com = [0, -1]"),
        ("mass = 2\ncom = [0; 1]", "com = [0, 1]"),
        ("mass = 2\ncom = [0 1]", "com = [0, 1]"),
        ("mass = 2\ncom = (0, 1)", "com = [0, 1]"),
        ("mass = 2\ncom = [20 mm, 1/2]", "com = [\"20 mm\", \"1/2\"]"),
        ("mass = 2\npoints = { a: [0, 0], b: [1, 0] }", "points = { a = [0, 0], b = [1, 0] }"),
        ("// of steel\nmass = 2", "# of steel"),
        ("; of steel\nmass = 2", "# of steel"),
    ];
    for (wrong, right) in cases {
        let text = scene(wrong);
        assert_eq!(advice(&text), format!("write `{right}`"), "{wrong}");
        let is_wrong = |line: &&str| Scene::from_toml(&scene(line)).is_err();
        let line = wrong.lines().find(is_wrong).unwrap_or(wrong);
        let mended = faults(&text.replace(line, right));
        assert!(mended.is_none(), "{right}: {}", mended.unwrap().render(false, 100));
    }
}

#[test]
fn names_and_headers_are_shown_as_they_can_be() {
    let wanted = [
        ("[bodies.plate ü]", "[bodies.plate_ue]"),
        ("[bodies.my plate]", "[bodies.my_plate]"),
        ("[bodies plate]", "[bodies.plate]"),
        ("[bodies:plate]", "[bodies.plate]"),
        ("{bodies.plate}", "[bodies.plate]"),
        ("［bodies.plate］", "[bodies.plate]"),
    ];
    for (wrong, right) in wanted {
        assert_eq!(advice(&scene("mass = 2").replace("[bodies.plate]", wrong)), format!("write `{right}`"), "{wrong}");
    }
    let quoted =
        scene("mass = 2").replace("[bodies.plate]", "[bodies.\"Größe-2\"]").replace("\"plate\"", "\"Größe-2\"");
    assert!(advice(&quoted).starts_with("write `Groesse_2`: "), "{}", advice(&quoted));
}

/// Nothing is proposed that is wrong again.
#[test]
fn where_nobody_knows_what_is_meant_no_line_is_proposed() {
    for wrong in ["mass = 2 ± 1", "mass = None", "mass = ", "mass = ]", "import steel"] {
        let faults = faults(&scene(wrong)).unwrap();
        assert!(faults.list.iter().all(|fault| !fault.help.starts_with("write `")), "{}", faults.render(false, 100));
    }
}

#[test]
fn the_same_slip_in_many_lines_is_one_fault() {
    let every = scene("mass = 2")
        .lines()
        .map(|line| if line.contains('=') { format!("{line};\n") } else { format!("{line}\n") })
        .collect::<String>();
    assert_eq!(advice(&every), "write `name = \"plate\"`");
    // A table whose header is missing: its keys are there twice.
    let twice = scene("mass = 2\nmass = 3\ninertia = 3");
    assert!(advice(&twice).contains("write its header above"), "{}", advice(&twice));
    let lost = format!("[ground.points]\n{}", scene("mass = 2").replace("[bodies.plate]\n", ""));
    let lost = lost.replace("name = \"plate\"\n", "");
    let faults = faults(&format!("name = \"plate\"\n[bodies.plate]\nmass = 2\n{lost}")).unwrap();
    let of_points: Vec<_> = faults.list.iter().filter(|fault| fault.message.contains("`ground.")).collect();
    assert_eq!(of_points.len(), 1, "{}", faults.render(false, 100));
}

#[test]
fn characters_that_look_like_operators_are_told() {
    for (wrong, right) in [("2×pi", "`*`"), ("2·pi", "`*`"), ("−2", "`-`"), ("2*π", "`pi`"), ("1÷2", "`/`")] {
        let help = advice(&scene(&format!("mass = 2\ncom = [0, \"{wrong}\"]")));
        assert_eq!(help, format!("write {right}"), "{wrong}");
    }
}

/// A table by the name that it has elsewhere is read as what it is: one slip, one fault.
#[test]
fn tables_by_other_names_are_one_fault() {
    for (own, others) in
        [("bodies", &["body", "link", "links", "Bodies"][..]), ("joints", &["joint", "constraints", "hinges"])]
    {
        for other in others {
            let text = scene("mass = 2").replace(&format!("[{own}."), &format!("[{other}."));
            assert_eq!(advice(&text), format!("did you mean `{own}`?"), "{other}");
        }
    }
    // What it is, nobody knows, but its names are there.
    let unknown = scene("mass = 2").replace("[bodies.", "[things.");
    assert!(advice(&unknown).contains("`coordinates`"), "all keys are listed: {}", advice(&unknown));
    let list = scene("mass = 2") + "[outputs]\nvariable = [\"plate.angle\"]\n";
    assert_eq!(advice(&list), "did you mean `variables`?");
    let doubled = scene("mass = 2").replace("[bodies.plate]", "[[bodies.plate]]");
    assert!(advice(&doubled).contains("single brackets"), "{}", advice(&doubled));
}

/// Advice speaks of what is written, not of another scene.
#[test]
fn advice_shows_the_values_that_are_there() {
    for (wrong, right) in [
        ("com = \"20 mm\"", "give x and y: `[\"20 mm\", 0]`, or `[0, \"20 mm\"]`"),
        ("com = { x = 0.1, y = \"5 mm\" }", "give x and y as a list: `[0.1, \"5 mm\"]`"),
    ] {
        assert_eq!(advice(&scene(&format!("mass = 2\n{wrong}"))), right);
    }
    let between = scene("mass = 2").replace("[\"ground\", \"plate\"]", "\"ground, plate\"");
    assert_eq!(advice(&between), "write `[\"ground\", \"plate\"]`");
}

#[test]
fn what_follows_from_a_fault_is_not_said() {
    let driver =
        "[drivers.motor]\njoint = \"pin\"\ndisplacement = \"t*1[m/s]\"\n[outputs]\nvariables = [\"motor.torque\"]\n";
    assert_eq!(advice(&(scene("mass = 2") + driver)), "give `angle = ...` instead of `displacement`");
    // Each is twice as long as the one before when written out: the first that is too long is told.
    let mut text = scene("mass = \"q20\"") + "[parameters]\nq0 = 1\n";
    for index in 1..=20 {
        text += &format!("q{index} = \"(q{0} + q{0})/2\"\n", index - 1);
    }
    let faults = faults(&text).unwrap();
    assert_eq!(faults.list.len(), 1, "{}", faults.render(false, 100));
    assert!(faults.list[0].message.contains("parameter `q12` takes more than"), "{}", faults.list[0].message);
}
