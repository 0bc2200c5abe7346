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
