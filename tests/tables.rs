//! Tables of files in expressions: values, motions by all methods against closed forms, faults with their places, FMUs that need no file.

use crate::support::run;

use std::path::PathBuf;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::{Faults, Scene};
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;

use run::{sound, value};

/// A file that is removed again.
struct File(PathBuf);

impl File {
    fn new(name: &str, text: &str) -> File {
        let path = std::env::temp_dir().join(format!("cotree_table_{name}_{}.csv", std::process::id()));
        std::fs::write(&path, text).expect("a file");
        File(path)
    }

    fn scene(&self, law: &str) -> Result<Scene, Faults> {
        let law = law.replace("FILE", &self.0.display().to_string());
        let text = format!(
            "name = \"falling\"\n[bodies.mass]\nmass = 1\ninertia = 1\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"mass\"]\naxis = [1, 0]\n\
             [loads.push]\ntype = \"force\"\non = \"mass\"\nvector = ['{law}', 0]\n[initial]\n\"rail.s\" = 0\n\"rail.v\" = 2\n[outputs]\nvariables = [\"rail.s\", \"rail.v\"]\n"
        );
        Scene::from_toml(&text)
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn end(scene: &Scene, engine: Option<Engine>, stop: f64) -> [f64; 2] {
    let model = Arc::new(Model::new(sound(compile(scene)).program).expect("sound"));
    let mut instance = run::started(&model, engine, stop, 1e-10);
    instance.step_to(stop).expect("regular");
    ["rail.s", "rail.v"].map(|name| value(&mut instance, name))
}

const ENGINES: [Option<Engine>; 3] = [Some(Engine::Taylor), Some(Engine::Dop853), Some(Engine::Radau)];

/// A force of position is a potential: v^2/2 is its integral, piece by piece.
#[test]
fn straight_lines_do_the_work_of_their_trapezia() {
    let file = File::new("lines", "s [mm]; force [N]\n0; 1\n500; 3\n1500; -1\n2000; 0.5\n");
    let work = 0.5 * (1.0 + 3.0) * 0.5 + 1.0 * (3.0 - 1.0) * 0.5 + 0.5 * (-1.0 + 0.5) * 0.5;
    let scene = sound(file.scene("table(\"FILE\", rail.s)"));
    for engine in ENGINES {
        let [s, v] = end(&scene, engine, 1.2);
        assert!(s > 2.0, "{s}");
        let expected = (4.0 + 2.0 * (work + 0.5 * (s - 2.0))).sqrt();
        assert!((v - expected).abs() < 1e-7, "{engine:?}: {v} {expected}");
    }
}

/// The sine has no curvature at 0 and pi, so the natural spline through its places is near it everywhere: h^4/384 at most (de Boor).
#[test]
fn a_spline_through_a_sine_does_the_work_of_the_sine() {
    let rows: String =
        (0..=40).map(|k| std::f64::consts::PI * f64::from(k) / 40.0).map(|x| format!("{x}\t{}\n", x.sin())).collect();
    let file = File::new("sine", &rows);
    let scene = sound(file.scene("spline(\"FILE\", rail.s)"));
    for engine in ENGINES {
        let [s, v] = end(&scene, engine, 1.2);
        assert!((2.0..3.1).contains(&s), "{s}");
        let expected = (4.0 + 2.0 * (1.0 - s.cos())).sqrt();
        assert!((v - expected).abs() < 2e-7, "{engine:?}: {v} {expected}");
    }
    // Beyond its end it goes on straight, downwards as the sine does there.
    let [s, v] = end(&scene, None, 2.0);
    let beyond = s - std::f64::consts::PI;
    let expected = (4.0 + 4.0 - beyond * beyond).sqrt();
    assert!(beyond > 0.5 && (v - expected).abs() < 1e-4, "{s} {v} {expected}");
}

/// Around and around: the work of a closed period is zero if its mean is.
#[test]
fn a_periodic_spline_begins_anew() {
    let file = File::new("periodic", "0 0\n0.25 1\n0.5 0\n0.75 -1\n1 0\n");
    let scene = sound(file.scene("periodic_spline(\"FILE\", rail.s - 7)"));
    for engine in ENGINES {
        let [s, v] = end(&scene, engine, 2.0);
        // The same place in another period has the same speed: found by running back to it.
        let share = s - s.floor();
        let mut instance =
            run::started(&Arc::new(Model::new(sound(compile(&scene)).program).expect("sound")), engine, 2.0, 1e-10);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let [place, _] = end(&scene, None, middle);
            if place < share { low = middle } else { high = middle }
        }
        instance.step_to(0.5 * (low + high)).expect("regular");
        let before = value(&mut instance, "rail.v");
        assert!((before - v).abs() < 1e-6, "{engine:?}: {before} {v} at {s}");
    }
}

/// The same curve as laboratories, spreadsheets and other programs write it: the work is that of the force over the first half metre.
#[test]
fn a_curve_is_the_same_however_its_file_is_written() {
    let work = 0.5 * (2000.0 + 1000.0) * 0.5;
    for (index, text) in [
        "s [mm],force [kN]\n0,2\n500,1\n",
        "Travel (mm),Force (kN)\r\n0,2\r\n500,1\r\n",
        "Weg/mm;F/kN\n0;2,0\n500;1,0\n",
        "travel_mm\tforce_kN\n0\t2\n500\t1\n",
        "\u{feff}\"Travel\";\"Force\"\n\"mm\";\"kN\"\n\"0,0\";\"2,0\"\n\"500,0\";\"1,0\"\n",
        "# travel[mm] force[kN]\n0 2\n500 1\n",
        "Travel (mm) Force (kN)\n0,0 2,0\n500,0 1,0\n",
        "0,2000\n0.5,1000\n",
    ]
    .iter()
    .enumerate()
    {
        let file = File::new(&format!("written{index}"), text);
        let [s, v] = end(&sound(file.scene("table(\"FILE\", rail.s)")), None, 0.3);
        // Behind the last place the force keeps its value.
        let expected = (4.0 + 2.0 * (work + 1000.0 * (s - 0.5))).sqrt();
        assert!(s > 0.5 && (v - expected).abs() < 1e-6 * expected, "{text:?}: {s} {v} {expected}");
    }
}

#[test]
fn faults_of_a_table_have_their_line() {
    let cases = [
        ("", "has no rows"),
        ("0, 1\n1, x\n", "line 2"),
        ("0, 1\n1, 2\n\n0.5, 3\n", "line 4"),
        ("0, 1\n1, nan\n", "not a finite number"),
        ("0, 1\n1\n", "1 fields"),
        ("0, 1\n1, 2, 3\n", "3 fields"),
        ("0, 1\n1,\n", "line 2 of"),
        ("x (furlong), y\n0, 1\n1, 2\n", "unknown unit `furlong`"),
        ("x, y\nfurlong, N\n0, 1\n1, 2\n", "unknown unit `furlong`"),
        ("x, y_cm\n0, 1\n1, 2\n", "`y_cm [cm]`"),
        ("x (mm), y, z\n0, 1\n1, 2\n", "third column"),
        ("0\t1,234\n1\t2,345\n", "1234 or 1.234"),
        ("x [furlong], y\n0, 1\n", "unit"),
        ("0, 1\n", "at least 2"),
    ];
    for (index, (text, message)) in cases.iter().enumerate() {
        let file = File::new(&format!("fault{index}"), text);
        let scene = file.scene("table(\"FILE\", rail.s)");
        let faults = scene.and_then(|scene| scene.resolve()).expect_err(message).to_string();
        assert!(faults.contains(message), "{message}: {faults}");
        let place = if text.is_empty() { String::new() } else { format!("{}:", file.0.display()) };
        assert!(faults.contains(&place), "{message}: {faults}");
    }
    let missing = File(std::env::temp_dir().join("cotree_table_that_is_not_there.csv"));
    let faults = missing.scene("table(\"FILE\", rail.s)").and_then(|scene| scene.resolve()).unwrap_err().to_string();
    assert!(faults.contains("scene::unreadable"), "{faults}");
    let open = File::new("open", "0, 1\n1, 2\n");
    let faults =
        open.scene("periodic_table(\"FILE\", rail.s)").and_then(|scene| scene.resolve()).unwrap_err().to_string();
    assert!(faults.contains("does not close"), "{faults}");
    let unit = File::new("unit", "t [s], f [N]\n0, 1\n1, 2\n");
    let faults = unit.scene("table(\"FILE\", rail.s)").and_then(|scene| scene.resolve()).unwrap_err().to_string();
    assert!(faults.contains("scene::wrong_unit"), "{faults}");
    let faults = unit.scene("table(rail.s)").and_then(|scene| scene.resolve()).unwrap_err().to_string();
    assert!(faults.contains("must be a file"), "{faults}");
}

/// A scene may name any file of the machine that reads it: nothing of what is no table is shown.
#[test]
fn a_file_that_is_not_a_table_is_not_quoted() {
    for (name, secret) in [("users", "root:secret:0:0\nuser,secret\n"), ("words", "secret, other\n"), ("one", "secret")]
    {
        let faults = File::new(name, secret).scene(r#"table("FILE", t)"#).and_then(|scene| compile(&scene));
        let text = faults.expect_err("no table").render(false, 1000);
        assert!(text.contains("is not a table: it has no line of numbers") && !text.contains("secret"), "{text}");
    }
}
