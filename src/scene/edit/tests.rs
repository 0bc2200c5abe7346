//! Edits against the texts that they shall give; and against what the text then says, in all the ways in which a table can be written.

use super::*;

fn after(text: &str, edits: &[Edit]) -> String {
    edited(text, edits).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn point(name: &str) -> Edit {
    Edit::Point { owner: "ground".to_owned(), name: name.to_owned(), at: "[1, \"2 mm\"]".to_owned() }
}

fn set(path: [&str; 2], value: &str) -> Edit {
    Edit::Set { path: path.map(str::to_owned).to_vec(), value: value.to_owned() }
}

fn add(table: &str, name: &str, keys: &[(&str, &str)]) -> Edit {
    let keys = keys.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
    Edit::Add { path: vec![table.to_owned(), name.to_owned()], keys: keys.collect() }
}

/// A table is added to where it is, in the way that it is written.
#[test]
fn a_point_of_the_ground_is_added_as_the_ground_is_written() {
    for (text, expected) in [
        (
            "[ground.points] # here\na = [0, 0] # first\n\n# Bodies.\n[bodies.bar]\n",
            "[ground.points] # here\na = [0, 0] # first\np = [1, \"2 mm\"]\n\n# Bodies.\n[bodies.bar]\n",
        ),
        ("[ground]\npoints = { a = [0, 0] } # here\n", "[ground]\npoints = { a = [0, 0], p = [1, \"2 mm\"] } # here\n"),
        (
            "ground = { points = { a = [0, 0] } }\n[bodies.bar]\n",
            "ground = { points = { a = [0, 0], p = [1, \"2 mm\"] } }\n[bodies.bar]\n",
        ),
        (
            "ground.points.a = [0, 0]\nname = 'x'\n",
            "ground.points.a = [0, 0]\nground.points.p = [1, \"2 mm\"]\nname = 'x'\n",
        ),
        (
            "[ground]\n  points.a = [\n  0,\n 0]\n[bodies.bar]",
            "[ground]\n  points.a = [\n  0,\n 0]\n  points.p = [1, \"2 mm\"]\n[bodies.bar]",
        ),
        ("ground.points = {}", "ground.points = { p = [1, \"2 mm\"] }"),
        ("[ground]\n", "[ground]\npoints = { p = [1, \"2 mm\"] }\n"),
        ("name = 'x'\n", "name = 'x'\n\n[ground.points]\np = [1, \"2 mm\"]\n"),
        (
            "name = 'x'\n\n[joints.pin]\r\ntype = 'y'",
            "name = 'x'\n\n[ground.points]\r\np = [1, \"2 mm\"]\r\n\r\n[joints.pin]\r\ntype = 'y'",
        ),
        (
            "{\"ground\": {\"points\": {\"a\": [0, 0]}}}",
            "{\"ground\": {\"points\": {\"a\": [0, 0], \"p\": [1, \"2 mm\"]}}}",
        ),
        (
            "{\n  \"name\": \"x\"\n}\n",
            "{\n  \"name\": \"x\",\n  \"ground\": { \"points\": { \"p\": [1, \"2 mm\"] } }\n}\n",
        ),
    ] {
        let changed = after(text, &[point("p")]);
        assert_eq!(changed, expected, "{text}");
        let tree = text::SceneText::new(&changed, false).tree().unwrap_or_else(|_| panic!("{changed}"));
        let point_path = ["ground", "points", "p"].map(str::to_owned);
        assert!(matches!(text::at(&tree, &point_path).map(|node| &node.kind), Some(Content::Array(_))), "{changed}");
    }
}

#[test]
fn tables_come_in_their_order_and_lists_get_one_more() {
    let text = "name = 'x'\n\n[bodies.a]\nmass = 1 # heavy\n\n# Why.\n[loads.push]\n\n[outputs]\nvariables = [\n  \"a.x\", # left\n  \"a.y\",\n]\n";
    let joint = add("joints", "pin", &[("type", "\"revolute\""), ("between", "[\"ground\", \"a\"]")]);
    let changed =
        after(text, &[joint, Edit::Output { name: "a.z".to_owned() }, Edit::Output { name: "a.x".to_owned() }]);
    let expected = text
        .replace("heavy\n", "heavy\n\n[joints.pin]\ntype    = \"revolute\"\nbetween = [\"ground\", \"a\"]\n")
        .replace("\"a.y\",\n", "\"a.y\",\n  \"a.z\"\n");
    assert_eq!(changed, expected);
    assert_eq!(
        after("joints = { a = 1 }\n", &[add("joints", "pin", &[("k", "2")])]),
        "joints = { a = 1, pin = { k = 2 } }\n"
    );
    assert_eq!(
        after("{}", &[add("joints", "pin", &[("k", "{ a = 'b' }")])]),
        "{ \"joints\": { \"pin\": { \"k\": { \"a\": \"b\" } } } }"
    );
    assert_eq!(after("", &[set(["initial", "bar.angle"], "1")]), "[initial]\n\"bar.angle\" = 1\n");
    assert_eq!(
        after("[initial]\n'bar.angle' = 2 # so\n", &[set(["initial", "bar.angle"], "1")]),
        "[initial]\n'bar.angle' = 1 # so\n"
    );
}

#[test]
fn an_element_goes_with_what_names_it_and_nothing_else_does() {
    let rest =
        "[outputs]\nvariables = [\"bar.x\", \"rod.x\"]\n[initial]\n\"bar.angle\" = 1\n\"rod.angle\" = 2 # kept\n";
    let left = "[outputs]\nvariables = [\"rod.x\"]\n[initial]\n\"rod.angle\" = 2 # kept\n";
    for (text, expected) in [
        (
            "# A scene.\n[bodies.bar]\nmass = 1\n[bodies.bar.points]\na = [0, 0]\n[bodies.rod]\nmass = 2\n\n# Joints.\n[joints.pin]\nbetween = ['ground', 'bar.a']\n[joints.other]\non = 'rod'\n[drivers.motor]\njoint = 'pin'\n",
            "# A scene.\n[bodies.rod]\nmass = 2\n\n# Joints.\n[joints.other]\non = 'rod'\n",
        ),
        (
            "joints.pin.type = 'revolute' # this\njoints.pin.between = ['ground', 'bar']\njoints.other.on = 'rod' # that\n[bodies]\nbar = { mass = 1 }\nrod = { mass = 2 }\n",
            "joints.other.on = 'rod' # that\n[bodies]\nrod = { mass = 2 }\n",
        ),
        (
            "bodies = { bar = { mass = 1 }, rod = { mass = 2 } }\njoints = { other = { on = 'rod' }, pin = { on = 'bar' } }\n",
            "bodies = { rod = { mass = 2 } }\njoints = { other = { on = 'rod' } }\n",
        ),
    ] {
        let remove = Edit::Remove { name: "bar".to_owned(), tables: vec!["bodies".to_owned()] };
        assert_eq!(after(&format!("{text}{rest}"), &[remove]), format!("{expected}{left}"), "{text}");
    }
}

#[test]
fn a_point_goes_unless_the_shape_needs_it() {
    let text = "[bodies.bar]\npoints = { a = [0, 0], b = [1, 0], c = [2, 0] }\nshape = { rod = ['a', 'b'] }\n[joints.pin]\nbetween = ['ground', 'bar.c']\n";
    let remove = |name: &str| Edit::RemovePoint { owner: "bar".to_owned(), name: name.to_owned() };
    assert_eq!(
        after(text, &[remove("c")]),
        "[bodies.bar]\npoints = { a = [0, 0], b = [1, 0] }\nshape = { rod = ['a', 'b'] }\n"
    );
    assert_eq!(after(text, &[remove("a")]).trim(), "");
}

#[test]
fn outlines_and_pairs_go_with_what_they_name() {
    let text = "[ground]\npoints = { p = [0, 0], q = [1, 0] }\noutline = { disc = 'p', radius = 1 }\n[bodies]\nbar = { points = { a = [0, 0] }, outline = { disc = 'a', radius = 1 } }\nrod = {}\n";
    let pairs = "[clearance]\npairs = [['bar', 'ground'], ['rod', 'ground']]\n";
    let of_ground = |name: &str| Edit::RemovePoint { owner: "ground".to_owned(), name: name.to_owned() };
    assert!(!after(text, &[of_ground("p")]).contains("'p'") && after(text, &[of_ground("q")]).contains("'p'"));
    let left = after(&format!("{text}{pairs}"), &[Edit::RemovePoint { owner: "bar".to_owned(), name: "a".to_owned() }]);
    assert!(!left.contains("bar") && left.contains("[clearance]\npairs = [[\"rod\", \"ground\"]]"), "{left}");
}

#[test]
fn a_motor_begins_elsewhere() {
    for (law, expected) in
        [("90[deg] + 2*pi*t", "120[deg] + 2*pi*t"), ("-1 - t", "-0.4764012244 - t"), ("0.5*t", "0.5*t"), ("w*t", "w*t")]
    {
        let text = |law: &str| format!("[drivers.motor]\njoint = \"pin\"\nangle = \"{law}\" # law\n");
        let turn = Edit::Turn { joint: "pin".to_owned(), by: std::f64::consts::FRAC_PI_6 };
        assert_eq!(after(&text(law), &[turn]), text(expected));
    }
}

/// Whatever is edited, the text can be read, and its bytes outside the edit are as they were.
#[test]
fn what_is_added_can_be_removed_again() {
    for text in [
        "name = 'x'\r\n\r\n[bodies.a]\r\nmass = 1 # heavy\r\n\r\n[loads.l]\r\non = 'a'\r\n",
        "a.x = 1\nb = 2\na.y = 3\n[joints]\nold = { k = 1 }\n",
        "\u{feff}[bodies.a]\nmass = 1\n",
        "{\n  \"name\": \"x\",\n  \"joints\": { \"old\": { \"k\": 1 } }\n}\n",
    ] {
        let added = after(text, &[add("joints", "pin", &[("k", "1")])]);
        assert!(added.len() > text.len());
        let remove = Edit::Remove { name: "pin".to_owned(), tables: vec!["joints".to_owned()] };
        assert_eq!(after(&added, &[remove]), text);
    }
    for text in ["a = [", "{", "x", "\u{feff}{"] {
        assert!(edited(text, &[point("p")]).is_err(), "{text}");
    }
    assert!(edited("ground = 3", &[point("p")]).is_err());
    assert!(edited("é = 1", &[Edit::Write { places: vec![(1, 2, String::new())] }]).is_err());
}

const SCENE: &str = "name = \"bar\"\ngravity = [0, -9.81] # down\n[parameters]\nlength = { value = \"1 m\", min = \"1 mm\" }\n[bodies.bob]\nmass = 2.0 # heavy\ninertia = 0.1\npoints = { top = [0.0, \"length\"] }\n[joints.hinge]\ntype = \"revolute\"\nbetween = [\"ground\", \"bob.top\"]\n[initial]\n\"bob.angle\" = { guess = 0.1 }\n[experiment]\nstop = '2 s'\n";

fn replaced(name: &str, value: &str) -> Result<String, EditError> {
    let scene = Scene::from_toml(SCENE).unwrap();
    let replaced = scene.replaced(&[(name.to_owned(), value.to_owned())]);
    replaced.map(|scene| scene.source.files().next().unwrap().1.to_owned())
}

#[test]
fn one_value_changes_and_nothing_else() {
    for (name, value, old, new) in [
        ("length", "\"2 m\"", "\"1 m\"", "\"2 m\""),
        ("length.min", "0.5", "\"1 mm\"", "0.5"),
        ("bob.mass", "3.5", "2.0", "3.5"),
        ("bodies.bob.mass", "\"4 kg\"", "2.0", "\"4 kg\""),
        ("bob.points.top", "[0, 1]", "[0.0, \"length\"]", "[0, 1]"),
        ("bob.angle", "0.2", "0.1 }", "0.2 }"),
        ("experiment.stop", "3", "'2 s'", "3"),
        ("gravity", "[0, -1.62]", "[0, -9.81]", "[0, -1.62]"),
    ] {
        assert_eq!(replaced(name, value).unwrap(), SCENE.replacen(old, new, 1), "{name}");
    }
}

#[test]
fn keys_that_are_not_written_are_added_to_their_tables() {
    for (name, value, old, new) in [
        ("hinge.damping", "0.5", "type = \"revolute\"", "damping = 0.5\ntype = \"revolute\""),
        ("experiment.step", "'1 ms'", "stop = ", "step = '1 ms'\nstop = "),
        ("hinge.friction.coulomb", "1", "type = \"revolute\"", "friction.coulomb = 1\ntype = \"revolute\""),
        ("length.max", "\"3 m\"", "{ value", "{ max = \"3 m\", value"),
        ("bob.points.low", "[0, 0]", "{ top", "{ low = [0, 0], top"),
        ("parameters.mass", "2", "length = {", "mass = 2\nlength = {"),
        ("bob.omega", "0.2", "\"bob.angle\" = ", "\"bob.omega\" = 0.2\n\"bob.angle\" = "),
        ("solver.safety", "0.5", "name = ", "solver.safety = 0.5\nname = "),
        ("description", "\"swings\"", "name = ", "description = \"swings\"\nname = "),
    ] {
        let tree = tree(SCENE, false).unwrap();
        let scene = Scene::from_toml(SCENE).unwrap();
        assert!(written(&tree, name).is_err(), "{name}");
        assert_eq!(scene.with_key(SCENE, false, (name, value)).unwrap(), SCENE.replacen(old, new, 1), "{name}");
    }
    let scene = Scene::from_toml(SCENE).unwrap();
    let several = [("solver.method", "'taylor'"), ("solver.bench", "1")];
    let text = several.iter().fold(SCENE.to_owned(), |text, addition| scene.with_key(&text, false, *addition).unwrap());
    assert!(text.starts_with("solver.bench = 1\nsolver.method = 'taylor'\nname"), "{text}");
    let empty = format!("{SCENE}[solver]\n");
    let added = scene.with_key(&empty, false, several[0]).unwrap();
    assert!(added.ends_with("[solver]\nmethod = 'taylor'\n"), "{added}");
    let json = r#"{"name": "bar", "parameters": {"length": 1}}"#;
    let added = scene.with_key(json, true, ("solver.method", "\"taylor\"")).unwrap();
    assert_eq!(added, r#"{"solver": {"method": "taylor"}, "name": "bar", "parameters": {"length": 1}}"#);
    let added = scene.with_key(json, true, ("parameters.mass", "2")).unwrap();
    assert_eq!(added, r#"{"name": "bar", "parameters": {"mass": 2, "length": 1}}"#);
}

#[test]
fn what_cannot_be_changed_is_refused() {
    for (name, value, told) in [
        ("bob.mas", "3", "did you mean `mass`"),
        ("lenght", "3", "did you mean `length`"),
        ("rod.mass", "3", "has no `rod.mass`"),
        ("bob", "3", "`bob` is a table; name one of its keys, such as `bob.mass`"),
        ("bob.mass", "3 kg", "cannot be read"),
    ] {
        let changed = Scene::from_toml(SCENE).unwrap().replaced(&[(name.to_owned(), value.to_owned())]);
        let error = match changed {
            Err(EditError::Scene(faults)) => faults.render(false, 200),
            Err(error) => error.to_string(),
            Ok(scene) => scene.resolve().unwrap_err().render(false, 200),
        };
        assert!(error.contains(told), "{name}: {error}");
    }
    let scene = Scene::from_toml(SCENE).unwrap();
    let twice =
        scene.replaced(&[("bob.mass", "1"), ("bodies.bob.mass", "2")].map(|(a, b)| (a.to_owned(), b.to_owned())));
    assert!(twice.unwrap_err().to_string().contains("the same value"));
    // A name in two tables is not the first of them.
    let tree = tree("[parameters]\nlength = 1\n[signals]\nlength = 2\n", false).unwrap();
    let both = written(&tree, "length").unwrap_err().to_string();
    assert!(both.contains("in several tables"), "{both}");
}
