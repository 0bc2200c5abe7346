//! How time, memory and size grow with the number of bodies: `cargo run --release --example growth` prints the tables of `docs/scale.md`.
//!
//! Each scene is measured in a process of its own, so that its peak of memory is its own: `growth SCENE SIZE` measures one and prints its row.
#![allow(missing_docs, reason = "a program, not a library")]

#[path = "../../benches/performance/scenes.rs"]
#[allow(dead_code, reason = "the benchmark has more scenes")]
mod scenes;

use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cotree::compile::compile;
use cotree::export::FmiVersion;
use cotree::formulate::formulate;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::Model;
use cotree_fmu::program::Program;

type Failure = Box<dyn std::error::Error>;

/// Links of a chain, or loops of a ladder.
const SIZES: [(&str, &[usize]); 2] =
    [("chain", &[10, 50, 100, 200, 500, 1000, 2000, 5000, 10_000]), ("ladder", &[50, 100, 250, 500, 1000, 2500, 5000])];
/// The motion that is simulated [s].
const SPAN: f64 = 0.01;
/// Repetitions of an evaluation.
const EVALUATIONS: u32 = 20;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [scene, size] = &arguments[..] {
        println!("{}", row(scene, size.parse()?)?);
        return Ok(());
    }
    println!(
        "| scene | bodies | loop equations | formulate | export | peak memory | program | FMU | load and start | instructions | accelerations | a step | of it a body |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for (scene, sizes) in SIZES {
        for size in sizes {
            let output = Command::new(std::env::current_exe()?).args([scene, &size.to_string()]).output()?;
            match output.status.success() {
                true => print!("{}", String::from_utf8_lossy(&output.stdout)),
                false => println!("| {scene} of {size} | {} |", String::from_utf8_lossy(&output.stderr).trim()),
            }
        }
    }
    Ok(())
}

fn row(name: &str, size: usize) -> Result<String, Failure> {
    let text = if name == "chain" { scenes::chain(size) } else { scenes::four_bars(size) };
    let start = Instant::now();
    let scene = Scene::from_toml(&text)?;
    let resolved = scene.resolve()?;
    let formulated = formulate(&resolved.mechanism, &resolved.outputs).map_err(|faults| format!("{faults:?}"))?;
    let formulating = start.elapsed();
    drop(formulated);

    let program = compile(&scene)?.program;
    let file = std::env::temp_dir().join(format!("cotree_growth_{name}_{size}.fmu"));
    let start = Instant::now();
    cotree_page::export_fmu(&scene, FmiVersion::V2, &file)?;
    let exporting = start.elapsed();
    let bytes = std::fs::metadata(&file)?.len();
    std::fs::remove_file(&file)?;
    let memory = peak_memory();

    let (loops, instructions) = (program.constraints.len(), program.tapes.acceleration.instructions().len());
    let file = program.to_bytes()?;
    drop(program);
    let start = Instant::now();
    let model = Arc::new(Model::new(Program::from_bytes(&file)?)?);
    let mut instance = Instance::new(model.clone());
    instance.setup(0.0, Some(SPAN), Some(1e-6))?;
    instance.initialise()?;
    let starting = start.elapsed();
    let (evaluation, step) = (evaluation(&model), step(instance)?);
    let bodies = resolved.mechanism.bodies.len();
    Ok(format!(
        "| {name} of {size} | {bodies} | {loops} | {} s | {} s | {memory} | {} kB | {} kB | {} s | {instructions} | {:.0} us | {:.0} us | {:.2} us |",
        seconds(formulating),
        seconds(exporting),
        file.len() / 1000,
        bytes / 1000,
        seconds(starting),
        1e6 * evaluation.as_secs_f64(),
        1e6 * step.as_secs_f64(),
        1e6 * step.as_secs_f64() / bodies as f64,
    ))
}

fn seconds(time: Duration) -> String {
    format!("{:.2}", time.as_secs_f64())
}

/// The most memory that this process has had, where the system tells.
fn peak_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    peak.map_or_else(|| "unknown".into(), |kilobytes| format!("{} MB", kilobytes / 1000))
}

/// The fastest of many evaluations of the accelerations.
fn evaluation(model: &Arc<Model>) -> Duration {
    let mut machine = Machine::new(model);
    machine.load(model, &model.default_state(0.0));
    let mut values = vec![0.0; model.coordinates() + model.program().constraints.len()];
    let times = (0..EVALUATIONS).map(|_| {
        let start = Instant::now();
        machine.evaluate(&model.program().tapes.acceleration, &mut values);
        start.elapsed()
    });
    times.min().unwrap_or_default()
}

/// A step of the solver, with its projections.
fn step(mut instance: Instance) -> Result<Duration, Failure> {
    let start = Instant::now();
    instance.step_to(SPAN)?;
    let steps = instance.statistics().steps.max(1);
    Ok(start.elapsed() / u32::try_from(steps)?)
}
