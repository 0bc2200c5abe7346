//! Speed, as the tables of `docs/performance.md`: `cargo bench --bench performance -- [FILE]` writes them to a file, or shows them.
//!
//! With `COTREE_PEERS` set to a folder that holds a runner of other programs, `run.sh SCENE PEER...`, what it prints becomes the last section;
//! `COTREE_PEERS_SCENES="S1 S2"` names the scenes, if not all.
#![allow(missing_docs, reason = "a program, not a library")]

mod compiled;
mod parts;
mod scenes;
mod targets;

use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::Instant;

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::Model;
use cotree_fmu::program::{Engine, Program, Source};

/// Repetitions of a measurement take so long together, at least [s].
const LONG_ENOUGH: f64 = 0.05;

/// Other programs that the runner is asked for.
const PEERS: [&str; 5] = ["hand", "mujoco", "exudyn", "sympy", "sundials"];

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    if let [only, program, runs] = &arguments[..]
        && only == "--only"
    {
        return repeat(program, runs.parse()?);
    }
    let mut text = heading();
    targets::write(&mut text)?;
    motions(&mut text)?;
    parts::write(&mut text)?;
    kernels(&mut text)?;
    communication(&mut text)?;
    export(&mut text)?;
    peers(&mut text);
    match arguments.first() {
        Some(file) => std::fs::write(file, text)?,
        None => print!("{text}"),
    }
    Ok(())
}

/// Runs the program in a file so often at a tolerance of 1e-6: what [`instructions`] counts.
fn repeat(file: &str, runs: u32) -> Result<(), Failure> {
    let model = Arc::new(Model::new(Program::from_bytes(&std::fs::read(file)?)?)?);
    for _ in 0..runs {
        started(&model, None, 1e-6)?.step_to(model.program().experiment.stop)?;
    }
    Ok(())
}

/// Instructions of the processor for one run at 1e-6 with its start, which are not noisy, counted by callgrind on this very program. None without
/// valgrind.
fn instructions(model: &Model) -> Result<Option<u64>, Failure> {
    let file = tempfile::NamedTempFile::new()?;
    std::fs::write(&file, model.program().to_bytes()?)?;
    let count = |runs: u32| {
        let mut valgrind = Command::new("valgrind");
        valgrind.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(std::env::current_exe().ok()?);
        let output = valgrind.arg("--only").arg(file.path()).arg(runs.to_string()).output().ok()?;
        let said = String::from_utf8_lossy(&output.stderr);
        said.lines().find_map(|line| line.split_once("Collected :")?.1.trim().parse::<u64>().ok())
    };
    let difference = |many: u64, one: u64| many.saturating_sub(one) / 5;
    Ok(count(6).zip(count(1)).map(|(many, one)| difference(many, one)))
}

fn heading() -> String {
    let say = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output().ok().filter(|output| output.status.success());
        output.map_or_else(|| "unknown".into(), |output| String::from_utf8_lossy(&output.stdout).trim().to_string())
    };
    let cpus = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let cpu = cpus
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(": "))
        .map_or("unknown", |(_, name)| name);
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    format!(
        "# Performance\n\nWritten by `cargo bench --bench performance -- docs/performance.md`; every figure is the fastest of many repetitions on one \
         thread, release build.\n\n- processor: {cpu}\n- date: {}\n- commit: {}\n- load of the machine at the start: {} (above the number of \
         processors, times are too long)\n",
        say("date", &["-u", "+%F"]),
        say("git", &["rev-parse", "--short", "HEAD"]),
        load.split_whitespace().next().unwrap_or("unknown"),
    )
}

fn model(text: &str) -> Result<Arc<Model>, Failure> {
    let scene = Scene::from_toml(text).map_err(|faults| faults.render(false, 100))?;
    let compiled = compile(&scene).map_err(|faults| faults.render(false, 100))?;
    Ok(Arc::new(Model::new(compiled.program)?))
}

fn started(model: &Arc<Model>, engine: Option<Engine>, tolerance: f64) -> Result<Instance, Failure> {
    let mut instance = Instance::new(model.clone());
    let experiment = model.program().experiment;
    instance.setup(experiment.start, Some(experiment.stop), Some(tolerance))?;
    if let Some(engine) = engine {
        instance.set_engine(engine)?;
    }
    instance.initialise()?;
    Ok(instance)
}

/// Seconds of the fastest repetition; each gets a fresh value of `prepare`.
fn fastest<T>(
    mut prepare: impl FnMut() -> Result<T, Failure>,
    mut work: impl FnMut(&mut T) -> Result<(), Failure>,
) -> Result<f64, Failure> {
    let (mut best, mut total) = (f64::INFINITY, 0.0);
    while total < LONG_ENOUGH {
        let mut value = prepare()?;
        let begin = Instant::now();
        work(&mut value)?;
        let seconds = begin.elapsed().as_secs_f64();
        best = best.min(seconds);
        total += seconds.max(1e-6);
    }
    Ok(best)
}

/// The largest difference of the coordinates.
fn error_at_end(instance: &Instance, exact: &Instance) -> f64 {
    let (end, exact) = (instance.state(), exact.state());
    let ends = end.positions().iter().zip(exact.positions());
    ends.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Whole runs: what the FMU does by itself, at four tolerances.
fn motions(text: &mut String) -> Result<(), Failure> {
    *text += "\n## Whole runs\n\nBy the engine that the model chooses. Error: of the coordinates at the end, against a run at 1e-12.\n\n\
              | scene | tolerance | time [ms] | error | steps | evaluations | per step [us] | instructions [1000] |\n|---|---|---|---|---|---|---|---|\n";
    for (title, scene) in scenes::all() {
        let model = model(&scene)?;
        let stop = model.program().experiment.stop;
        let run = |instance: &mut Instance| -> Result<(), Failure> { Ok(instance.step_to(stop)?) };
        let mut exact = started(&model, None, 1e-12)?;
        if let Err(error) = run(&mut exact) {
            writeln!(text, "| {title} | {error} | | | | | | |")?;
            continue;
        }
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
            let mut instance = started(&model, None, tolerance)?;
            run(&mut instance)?;
            let error = error_at_end(&instance, &exact);
            let seconds = fastest(|| started(&model, None, tolerance), run)?;
            let work = instance.statistics();
            let step = 1e6 * seconds / work.steps.max(1) as f64;
            let counted = if tolerance == 1e-6 { instructions(&model)? } else { None };
            let counted = counted.map_or_else(String::new, |count| (count / 1000).to_string());
            writeln!(
                text,
                "| {title} | {tolerance:.0e} | {:.3} | {error:.0e} | {} | {} | {step:.2} | {counted} |",
                1e3 * seconds,
                work.steps,
                work.evaluations
            )?;
        }
    }
    Ok(())
}

/// The parts of a step that are tapes.
fn kernels(text: &mut String) -> Result<(), Failure> {
    *text += "\n## Kernels in the interpreter\n\nThe last column: the time as a multiple of that of the C that cotree writes for the same \
              accelerations and reactions, compiled by `gcc -O2`.\n\n| scene | kernel | instructions | time [ns] | per instruction [ns] | against C |\n|---|---|---|---|---|---|\n";
    for (title, scene) in scenes::all() {
        let model = model(&scene)?;
        let tapes = &model.program().tapes;
        let mut machine = Machine::new(&model);
        let start = started(&model, None, 1e-6)?.state();
        machine.load(&model, &start);
        let list = [
            ("accelerations", &tapes.acceleration),
            ("projection of q", &tapes.project_position),
            ("outputs", &tapes.outputs),
        ];
        for (name, tape) in list.into_iter().filter(|(_, tape)| !tape.instructions().is_empty()) {
            const RUNS: u32 = 100;
            let seconds = fastest(
                || Ok(()),
                |()| {
                    (0..RUNS).for_each(|_| std::hint::black_box(&mut machine).run(tape));
                    Ok(())
                },
            )?;
            let (count, ns) = (tape.instructions().len(), 1e9 * seconds / f64::from(RUNS));
            let compiled = match name {
                "accelerations" => compiled::accelerations(&scene, &model, &start)?,
                _ => None,
            };
            let ratio = compiled.map_or_else(String::new, |compiled| format!("{:.1}", ns / compiled));
            writeln!(text, "| {title} | {name} | {count} | {ns:.0} | {:.2} | {ratio} |", ns / count as f64)?;
        }
    }
    Ok(())
}

/// Steps from one communication point to the next, below the C interface.
fn communication(text: &mut String) -> Result<(), Failure> {
    *text += "\n## Communication points\n\n1000 steps of 1 ms of the cart with a pendulum at a tolerance of 1e-6.\n\n| what | per point [us] |\n|---|---|\n";
    const POINTS: u32 = 1000;
    let model = model(&scenes::model("cart_pole"))?;
    let input = model.program().variables.iter().position(|variable| matches!(variable.source, Source::Input(_)));
    let input = input.ok_or("the scene has no input")?;
    for (title, changing) in [("step, the input constant", false), ("step, the input changed before", true)] {
        let seconds = fastest(
            || started(&model, None, 1e-6),
            |instance| {
                for point in 1..=POINTS {
                    if changing {
                        instance.set(input, f64::from(point % 7))?;
                    }
                    instance.step_to(f64::from(point) * 1e-3)?;
                }
                Ok(())
            },
        )?;
        writeln!(text, "| {title} | {:.3} |", 1e6 * seconds / f64::from(POINTS))?;
    }
    let copy = fastest(
        || {
            let mut instance = started(&model, None, 1e-6)?;
            let saved = instance.save();
            Ok((instance, saved))
        },
        |(instance, saved)| {
            for _ in 0..POINTS {
                std::hint::black_box(&mut *instance).save_into(saved);
            }
            Ok(())
        },
    )?;
    writeln!(text, "| saving the state | {:.3} |", 1e6 * copy / f64::from(POINTS))?;
    Ok(())
}

/// From the scene to the program.
fn export(text: &mut String) -> Result<(), Failure> {
    *text += "\n## From the scene to the program\n\nChains of bars.\n\n| bars | time [ms] |\n|---|---|\n";
    for links in [1, 10, 100, 1000, 5000] {
        let scene = Scene::from_toml(&scenes::chain(links)).map_err(|faults| faults.render(false, 100))?;
        let seconds = fastest(
            || Ok(()),
            |()| match compile(&scene) {
                Ok(_) => Ok(()),
                Err(faults) => Err(faults.render(false, 100).into()),
            },
        )?;
        writeln!(text, "| {links} | {:.1} |", 1e3 * seconds)?;
    }
    Ok(())
}

/// What other programs take, if their runner is there: one table for each scene, or what it complains of.
fn peers(text: &mut String) {
    let Some(folder) = std::env::var_os("COTREE_PEERS") else { return };
    *text += "\n## Other programs\n\nMilliseconds at equal error, measured in the same run by the runner in `COTREE_PEERS`.\n";
    let scenes = std::env::var("COTREE_PEERS_SCENES").unwrap_or_else(|_| "S1 S2 S3 S4 S6".into());
    for scene in scenes.split_whitespace() {
        let output =
            Command::new(Path::new(&folder).join("run.sh")).arg(scene).args(PEERS).current_dir(&folder).output();
        let said = output.map_or_else(
            |error| format!("the runner does not start: {error}"),
            |output| match output.status.success() {
                true => String::from_utf8_lossy(&output.stdout).into_owned(),
                false => String::from_utf8_lossy(&output.stderr).into_owned(),
            },
        );
        *text += &format!("\n{}\n", said.trim_end());
    }
}
