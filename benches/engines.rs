//! Error and time of both integrators over whole runs: `cargo bench --bench engines`.
#![allow(missing_docs, reason = "a program, not a library")]

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use cotree::pipeline::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;

/// Fastest of so many runs.
const REPETITIONS: usize = 20;

fn main() {
    let file = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name).join("scene.toml");
        std::fs::read_to_string(path).unwrap_or_default()
    };
    measure("slider-crank, 10 s", &file("bench_slider_crank"));
    measure("Andrews, 0.03 s", &file("andrews"));
    measure("chain of 10, 1 s", &chain(10));
}

/// Bars of total length and mass 1 that hang from each other, released level.
fn chain(links: usize) -> String {
    let (length, mass) = (1.0 / links as f64, 1.0 / links as f64);
    let mut text = String::from("format = 1\nname = \"chain\"\ngravity = [0, -9.81]\n");
    for link in 0..links {
        let before = if link == 0 { "ground".to_string() } else { format!("b{}.tip", link - 1) };
        let half = length / 2.0;
        text += &format!(
            "[bodies.b{link}]\nmass = {mass}\ninertia = {}\npoints = {{ root = [-{half}, 0], tip = [{half}, 0] }}\n\
             [joints.j{link}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"b{link}.root\"]\n",
            mass * length * length / 12.0
        );
    }
    text += "[initial]\n";
    for link in 0..links {
        text += &format!("\"b{link}.angle\" = 0\n\"b{link}.omega\" = 0\n");
    }
    text + "[experiment]\nstop = 1\n"
}

fn measure(title: &str, text: &str) {
    let program = match Scene::from_toml(text).and_then(|scene| compile(&scene)) {
        Ok(compiled) => compiled.program,
        Err(faults) => return println!("{title}: {faults:?}"),
    };
    let Ok(model) = Model::new(program).map(Arc::new) else { return println!("{title}: no program") };
    let Some((reference, _)) = run(&model, Engine::Taylor, 1e-13) else { return println!("{title}: no reference") };
    println!("\n{title}\n{:>10} {:>10} {:>12} {:>12}", "engine", "tolerance", "error", "time [us]");
    for engine in [Engine::Dop853, Engine::Taylor] {
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
            let mut best = f64::INFINITY;
            let mut error = f64::NAN;
            for (end, time) in (0..REPETITIONS).filter_map(|_| run(&model, engine, tolerance)) {
                best = best.min(time);
                error = end.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            }
            println!("{:>10} {tolerance:>10.0e} {error:>12.1e} {best:>12.1}", format!("{engine:?}"));
        }
    }
}

/// Coordinates at the end, and the time that it took [us].
fn run(model: &Arc<Model>, engine: Engine, tolerance: f64) -> Option<(Vec<f64>, f64)> {
    let stop = model.program().experiment.stop;
    let mut instance = Instance::new(model.clone());
    instance.setup(0.0, Some(stop), Some(tolerance)).ok()?;
    instance.set_engine(engine).ok()?;
    instance.initialise().ok()?;
    let start = Instant::now();
    instance.step_to(stop).ok()?;
    let time = start.elapsed().as_secs_f64() * 1e6;
    Some((instance.state().positions().to_vec(), time))
}
