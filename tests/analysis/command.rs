//! The three commands as a user meets them.

use super::run::scene_of;
use super::shell::{cotree, stderr, stdout};
use serde_json::Value;

/// A folder with two models and a body that falls.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["cart_pole", "slider_crank"] {
        std::fs::write(folder.path().join(format!("{name}.toml")), scene_of(name)).unwrap();
    }
    let falling = "format = 1\nname = \"falling\"\ngravity = [0, -9.81]\n[bodies.ball]\nmass = 1\ninertia = 1\n";
    std::fs::write(folder.path().join("falling.toml"), falling).unwrap();
    std::fs::write(folder.path().join("broken.toml"), "format = 1\nname = 3\n").unwrap();
    folder
}

#[test]
fn every_command_explains_itself_with_an_example() {
    let folder = folder();
    for command in ["equilibrium", "linearize", "modes"] {
        let help = cotree(folder.path(), &[command, "--help"]);
        assert!(help.status.success());
        assert!(stdout(&help).contains(&format!("cotree {command} ")), "{}", stdout(&help));
    }
}

#[test]
fn exit_codes_say_who_is_at_fault() {
    let folder = folder();
    let cases: [(&[&str], i32, &str); 8] = [
        (&["equilibrium", "cart_pole.toml"], 0, ""),
        (&["equilibrium", "broken.toml"], 1, "broken.toml"),
        (&["linearize", "missing.toml"], 2, "missing.toml"),
        (&["modes", "cart_pole.toml", "--set", "mass=1"], 2, "`cart_mass`"),
        (&["modes", "cart_pole.toml", "--set", "cart_mass=0"], 2, "at least"),
        (&["linearize", "cart_pole.toml", "--at", "-1"], 2, "before the start"),
        (&["linearize", "cart_pole.toml", "--at", "1", "--along"], 2, "cannot be used"),
        (&["equilibrium", "falling.toml"], 3, "`ball.y`"),
    ];
    for (arguments, code, message) in cases {
        let output = cotree(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(message), "{arguments:?}: {}", stderr(&output));
    }
}

/// A force that is held on a free carriage, and on one with a spring: closed forms of the next instant. The first one's A is singular.
#[test]
fn held_inputs_give_the_next_instant() {
    let folder = folder();
    let carriage = |spring: &str| {
        format!(
            "name = \"carriage\"\n[inputs]\npush = \"0 N\"\n[ground.points]\nwall = [-1, 0]\n[bodies.cart]\nmass = 2\ninertia = 1\n[joints.rail]\ntype = \"prismatic\"\n\
             between = [\"ground\", \"cart\"]\naxis = [1, 0]\n[loads.hand]\ntype = \"force\"\non = \"cart\"\nvector = [\"push\", 0]\n{spring}[outputs]\nvariables = [\"cart.x\"]\n"
        )
    };
    let spring = "[loads.coil]\ntype = \"spring\"\nbetween = [\"ground.wall\", \"cart\"]\nstiffness = 18\nlength = 1\n";
    let close = |found: &Value, expected: &[&[f64]]| {
        let rows = found.as_array().unwrap();
        assert_eq!(rows.len(), expected.len());
        for (row, expected) in rows.iter().zip(expected) {
            for (entry, expected) in row.as_array().unwrap().iter().zip(*expected) {
                assert!((entry.as_f64().unwrap() - expected).abs() < 1e-12, "{found} for {expected:?}");
            }
        }
    };
    let (h, m, w) = (0.1, 2.0, 3.0_f64);
    let (sine, cosine) = (f64::sin(w * h), f64::cos(w * h));
    for (text, a, b) in [
        (carriage(""), [[1.0, h], [0.0, 1.0]], [h * h / (2.0 * m), h / m]),
        (carriage(spring), [[cosine, sine / w], [-w * sine, cosine]], [(1.0 - cosine) / (m * w * w), sine / (m * w)]),
    ] {
        std::fs::write(folder.path().join("carriage.toml"), text).unwrap();
        let output = cotree(folder.path(), &["linearize", "carriage.toml", "--discrete", "100 ms", "--json"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        close(&json["A"], &[&a[0], &a[1]]);
        close(&json["B"], &[&b[..1], &b[1..]]);
        close(&json["C"], &[&[1.0, 0.0]]);
        assert_eq!(json["step"], 0.1);
    }
    let output = cotree(folder.path(), &["linearize", "carriage.toml", "--discrete", "0.1", "-o", "plant.m"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let script = std::fs::read_to_string(folder.path().join("plant.m")).unwrap();
    for line in [
        "x(k+1) = A x(k) + B u(k)",
        "h = 0.1;",
        "inputs = {'push'};",
        "outputs = {'cart.x'};",
        "A = [\n 0.9553",
        "D = [\n 0.0\n];",
    ] {
        assert!(script.contains(line), "{line}\n{script}");
    }
    // A driver that follows the input would have to jump with it.
    let driven = carriage("[drivers.led]\njoint = \"rail\"\ndisplacement = \"0.1[m/N]*push\"\n")
        .replace("variables = [\"cart.x\"]", "variables = [\"led.force\"]");
    std::fs::write(folder.path().join("driven.toml"), driven).unwrap();
    let output = cotree(folder.path(), &["linearize", "driven.toml", "--discrete", "0.1"]);
    assert!(output.status.code() == Some(2) && stderr(&output).contains("d2(push)/dt2"), "{}", stderr(&output));
    for wrong in ["0", "-1 ms", "2 m"] {
        assert_eq!(cotree(folder.path(), &["linearize", "carriage.toml", "--discrete", wrong]).status.code(), Some(2));
    }
}

#[test]
fn settings_reach_the_analysis() {
    let folder = folder();
    let height = |arguments: &[&str]| {
        let output = cotree(folder.path(), &[&["equilibrium", "slider_crank.toml", "--json"], arguments].concat());
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        json["values"]["pose"]["crank.y"].as_f64().unwrap().abs()
    };
    assert!((height(&[]) - 0.25).abs() < 1e-12);
    assert!((height(&["--set", "crank_length=400 mm"]) - 0.2).abs() < 1e-12);
}

#[test]
fn results_are_the_same_in_every_form() {
    let folder = folder();
    let run = |form: &str| stdout(&cotree(folder.path(), &["linearize", "cart_pole.toml", form]));
    let json: Value = serde_json::from_str(&run("--json")).unwrap();
    let entry = json["A"][2][3].as_f64().unwrap();
    let csv = run("--csv");
    let line = csv.lines().find(|line| line.starts_with("0.0,A,d(rail.v)/dt,pole.omega,")).unwrap();
    assert_eq!(line.rsplit(',').next().unwrap().parse::<f64>().unwrap(), entry);
    assert_eq!(json["states"][1]["name"], "pole.angle");
    assert_eq!(json["outputs"].as_array().unwrap().len(), json["C"].as_array().unwrap().len());
    let table = stdout(&cotree(folder.path(), &["linearize", "cart_pole.toml"]));
    assert!(table.contains("d(pole.omega)/dt") && table.contains("push"), "{table}");
}

#[test]
fn along_a_motion_every_point_has_its_matrices() {
    let folder = folder();
    let arguments =
        ["linearize", "slider_crank.toml", "--along", "--stop", "0.3", "--step", "100 ms", "--json", "-o", "m.json"];
    let output = cotree(folder.path(), &arguments);
    assert!(output.status.success() && output.stdout.is_empty(), "{}", stderr(&output));
    let json: Value = serde_json::from_slice(&std::fs::read(folder.path().join("m.json")).unwrap()).unwrap();
    let times: Vec<f64> =
        json["points"].as_array().unwrap().iter().map(|point| point["time"].as_f64().unwrap()).collect();
    assert_eq!(times.len(), 4);
    assert_eq!(times[3], 0.3);
    // Where it moves the rates of the states are said: those of coordinates are states themselves.
    let point = &json["points"][3];
    let (states, rates) = (point["states"].as_array().unwrap(), point["rates"].as_array().unwrap());
    assert!(states.len() == 2 && rates[0] == states[1]["value"] && rates[0] != 0.0, "{point}");
    let text = stdout(&cotree(folder.path(), &["linearize", "slider_crank.toml", "--at", "0.3"]));
    assert!(text.contains("the point is not an equilibrium: this dx/dt is added to A x + B u"), "{text}");
    let rest = stdout(&cotree(folder.path(), &["linearize", "cart_pole.toml", "--equilibrium"]));
    assert!(!rest.contains("the point is not an equilibrium"), "{rest}");
    // One of them alone is the same.
    let single = cotree(folder.path(), &["linearize", "slider_crank.toml", "--at", "0.3", "--json"]);
    let single: Value = serde_json::from_slice(&single.stdout).unwrap();
    let [a, b] = [&json["points"][3]["A"][1][0], &single["A"][1][0]].map(|value| value.as_f64().unwrap());
    assert!((a - b).abs() < 1e-4 * a.abs(), "{a} {b}");
}

#[test]
fn modes_are_a_table() {
    let folder = folder();
    let output = stdout(&cotree(folder.path(), &["modes", "cart_pole.toml"]));
    assert!(output.contains("free motion") && output.contains("grows") && output.contains("rail.s"), "{output}");
    let csv = stdout(&cotree(folder.path(), &["modes", "cart_pole.toml", "--csv"]));
    assert!(
        csv.starts_with(
            "mode,real,imaginary,frequency,natural_frequency,damping_ratio,coordinate,shape_real,shape_imaginary\n1,0.0,"
        ),
        "{csv}"
    );
    assert!(!csv.contains("-0.0,") && !csv.contains("-0.0\n"), "{csv}");
}

/// Squares of such numbers are none: decompositions of matrices of them must end all the same.
#[test]
fn numbers_far_from_one_come_to_an_end() {
    let folder = tempfile::tempdir().unwrap();
    let scene = |gravity: &str, mass: &str, inertia: &str, stiffness: &str| {
        format!(
            "format = 1\nname = \"far\"\ngravity = [0, {gravity}]\n[ground.points]\no = [0, 0]\n\
             [bodies.a]\nmass = {mass}\ninertia = {inertia}\npoints = {{ p = [0.5, 0], q = [-0.5, 0.1] }}\n\
             [bodies.b]\nmass = 1\ninertia = 1\npoints = {{ p = [0.5, 0] }}\n\
             [joints.j]\ntype = \"revolute\"\nbetween = [\"ground.o\", \"a.p\"]\n\
             [joints.k]\ntype = \"revolute\"\nbetween = [\"a.q\", \"b.p\"]\n\
             [loads.s]\ntype = \"torsion_spring\"\nbetween = [\"ground\", \"b\"]\nstiffness = {stiffness}\nangle = 0\n"
        )
    };
    let cases = [
        scene("-1e300", "1", "1", "1"),
        scene("0", "1", "1e-160", "1"),
        scene("-9.81", "1e-300", "1e-300", "1e300"),
        scene("1e-300", "1e300", "1e300", "1e-300"),
        scene("-1e155", "1", "1", "1e155"),
        scene("-9.81", "1", "1e-300", "1e308"),
    ];
    for text in cases {
        std::fs::write(folder.path().join("far.toml"), &text).unwrap();
        for command in ["equilibrium", "modes", "linearize"] {
            let output = cotree(folder.path(), &[command, "far.toml"]);
            let code = output.status.code().unwrap();
            assert!([0, 1, 3].contains(&code), "{command} {text}: {}", stderr(&output));
            assert!(code == 0 || stderr(&output).contains("error") || code == 1, "{}", stderr(&output));
            assert!(!stdout(&output).contains("NaN") && !stdout(&output).contains("inf "), "{}", stdout(&output));
        }
    }
}

/// What rubs, in words, as data and in a script.
#[test]
fn modes_are_asked_for_and_told_in_words() {
    let folder = folder();
    std::fs::write(folder.path().join("belt.toml"), scene_of("stick_slip")).unwrap();
    let run = |arguments: &[&str]| cotree(folder.path(), arguments);
    let rest = stdout(&run(&["equilibrium", "belt.toml", "--set", "block.x=80 mm"]));
    assert!(rest.contains("one of many equilibria: `rubbing.friction` would stick elsewhere too"), "{rest}");
    let data: Value = serde_json::from_str(&stdout(&run(&["equilibrium", "belt.toml", "--json"]))).unwrap();
    assert_eq!((&data["standing"][0], &data["shared"]), (&"rubbing.friction".into(), &Value::Array(Vec::new())));
    let most = 0.3 * 1.5 * 1.5 * 9.81;
    assert!((data["values"]["margins"]["rubbing.friction.to"].as_f64().unwrap() - most).abs() < 1e-9);
    let arguments = ["linearize", "belt.toml", "--mode", "rubbing=slides-"];
    let data: Value = serde_json::from_str(&stdout(&run(&[&arguments[..], &["--json"]].concat()))).unwrap();
    assert_eq!(data["slides"]["rubbing.friction.direction"], -1.0);
    assert_eq!(data.get("closed"), None);
    assert!(run(&[&arguments[..], &["-o", "belt.m"]].concat()).status.success());
    let script = std::fs::read_to_string(folder.path().join("belt.m")).unwrap();
    assert!(script.contains("% rubbing.friction slides-\n"), "{script}");
    for (mode, code, message) in [
        ("rubbing", 2, "write NAME=WORD"),
        ("rubbing=closed", 2, "write rubbing=sticks or rubbing=slides"),
        ("rubbing=slides", 3, "write slides+ or slides-"),
    ] {
        let output = run(&["linearize", "belt.toml", "--mode", mode]);
        assert_eq!(output.status.code(), Some(code), "{mode}: {}", stderr(&output));
        assert!(stderr(&output).contains(message), "{mode}: {}", stderr(&output));
    }
}
