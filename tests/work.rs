//! How much work the models are: it may shrink, but not grow unnoticed. And that `cotree bench` measures it.
//!
//! `UPDATE_WORK=1 cargo test --test all work::` writes `tests/work.txt` anew; whoever makes a number larger says why.

use crate::support::ROOT;
use crate::support::run;

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use run::{models, sound};

/// Communication points of a run; driven mechanisms take a step to each.
const POINTS: u32 = 50;

fn root() -> PathBuf {
    PathBuf::from(ROOT)
}

/// Operations of the kernel of the motion, then steps, rejected steps and evaluations of the scene's experiment, communication points included.
fn work(scene: &Path) -> [u64; 4] {
    let program = sound(Scene::read(scene).and_then(|scene| compile(&scene))).program;
    let operations = program.tapes.acceleration.instructions().len() as u64;
    let (start, stop) = (program.experiment.start, program.experiment.stop);
    let mut instance = Instance::new(Arc::new(Model::new(program).expect("a sound program")));
    instance.setup(start, Some(stop), None).expect("times");
    instance.initialise().expect("consistent");
    for point in 1..=POINTS {
        let time = if point == POINTS { stop } else { start + (stop - start) * f64::from(point) / f64::from(POINTS) };
        instance.step_to(time).expect("regular");
    }
    let done = instance.statistics();
    [operations, done.steps, done.rejected, done.evaluations]
}

fn scenes() -> Vec<(String, PathBuf)> {
    let scene = |name: String| (name.clone(), root().join("models").join(name).join("scene.toml"));
    let mut list: Vec<_> = models().into_iter().map(scene).collect();
    list.push(("stiff_slider_crank".into(), root().join("benches/scenes/stiff_slider_crank.toml")));
    list.sort();
    list
}

#[test]
fn no_model_takes_more_work_than_it_did() {
    let path = root().join("tests/work.txt");
    let mut table =
        format!("{:24}{:>12}{:>12}{:>12}{:>12}\n", "model", "operations", "steps", "rejected", "evaluations");
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    let mut grown = Vec::new();
    for (name, scene) in scenes() {
        let now = work(&scene);
        let _ = writeln!(table, "{name:24}{:>12}{:>12}{:>12}{:>12}", now[0], now[1], now[2], now[3]);
        let line = known.lines().find(|line| line.split_whitespace().next() == Some(&name));
        let before: Vec<u64> =
            line.map_or_else(Vec::new, |line| line.split_whitespace().skip(1).flat_map(str::parse).collect());
        if before.len() != now.len() || now.iter().zip(&before).any(|(now, before)| now > before) {
            grown.push(format!("{name}: {before:?} became {now:?}"));
        }
    }
    if std::env::var_os("UPDATE_WORK").is_some() {
        std::fs::write(path, table).expect("written");
    } else {
        assert!(grown.is_empty(), "more work, or a model without an entry in tests/work.txt:\n{}", grown.join("\n"));
    }
}

#[test]
fn bench_measures_errors_and_work_of_every_method() {
    let folder = tempfile::tempdir().expect("a folder");
    let (scene, plot) = (folder.path().join("short.toml"), folder.path().join("short.svg"));
    let text = std::fs::read_to_string(root().join("models/double_pendulum/scene.toml")).expect("a scene");
    let (before, _) = text.split_once("[experiment]").expect("an experiment");
    std::fs::write(&scene, format!("{before}[experiment]\nstop = 0.5\n")).expect("written");
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_cotree")).arg("bench").arg(&scene).args(arguments).output();
        let output = output.expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    };
    let json: serde_json::Value =
        serde_json::from_str(&run(&["--json", "--plot", plot.to_str().expect("a path")])).expect("JSON");
    let runs = json["runs"].as_array().expect("runs");
    for method in ["auto", "taylor", "explicit", "implicit"] {
        let of: Vec<_> = runs.iter().filter(|run| run["method"] == method).collect();
        assert_eq!(of.len(), 10, "{method}");
        let number = |index: usize, key: &str| of[index][key].as_f64().unwrap_or_else(|| panic!("{method} {key}"));
        // Between 1e-4 and 1e-8.
        assert!(number(5, "error") < 1e-2 * number(1, "error"), "{method}");
        assert!(number(5, "error") < 1e-5, "{method}");
        assert!(number(5, "steps") > 0.0 && number(5, "evaluations") >= number(5, "steps"), "{method}");
        assert!(number(5, "cpu_seconds") > 0.0);
        assert_eq!(number(5, "factorisations") > 0.0, method == "implicit");
    }
    assert!(json["reference"]["error"].as_f64().is_some_and(|error| error < 1e-9));
    assert!(json["reference"]["other"]["distance"].as_f64().is_some_and(|distance| distance < 1e-8));
    assert_eq!(json["reference"]["confirmed"], true);
    let svg = std::fs::read_to_string(plot).expect("a picture");
    assert!(svg.contains(">implicit<") && svg.ends_with("</svg>\n") && !svg.contains("NaN"));
    let table = run(&[]);
    assert!(table.contains("explicit") && table.contains("evaluations"), "{table}");
}
