//! What derivatives of a motion cost and how exact they are: the time of a run of the program alone, how many of those a run with derivatives by 1, 4 and 8 parameters
//! takes, and the largest error against central differences of the sixth order.
//!
//! `cargo run --release --example sensitivity_cost [MODEL...]`

use std::error::Error;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use cotree::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_study::analysis::Study;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Each time is the shortest of so many.
const TIMES: usize = 9;
/// Differences are taken after this share of the run, with runs of this tolerance and steps of this share of a value.
const SHARE: f64 = 0.1;
const FINE: f64 = 1e-13;
const STEP: f64 = 4e-3;

fn main() -> Outcome<()> {
    println!("| model | run | 1 | 4 | 8 | each of the last | error |");
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        let usual = ["slider_crank", "double_pendulum", "andrews", "quick_return", "friction"];
        names = usual.map(str::to_owned).to_vec();
    }
    for name in &names {
        measure(name)?;
    }
    Ok(())
}

fn measure(name: &str) -> Outcome<()> {
    let scene = Scene::from_toml(&std::fs::read_to_string(format!("models/{name}/scene.toml"))?)?;
    let compiled = cotree::compile(&scene)?;
    let program = &compiled.program;
    let (model, stop) = (Arc::new(Model::new(program.clone())?), program.experiment.stop);
    let run = shortest(|| run(&model, None, &[], stop, None))?;
    let names = program.parameters.iter().map(|own| &own.name).chain(program.inputs.iter().map(|own| &own.name));
    let names: Vec<String> = names.take(8).cloned().collect();
    let mut study = Study::new(&scene)?;
    print!("| {name} | {:.2} ms |", 1e3 * run);
    let mut shares = Vec::new();
    for count in [1, 4, 8].map(|count| names.len().min(count)) {
        let time = study.varying(&names[..count], |varying| {
            let start: Vec<f64> = varying.parameters().iter().map(|own| own.start).collect();
            Ok(shortest(|| Ok(varying.at(&start, &[stop])?)).unwrap_or(f64::NAN))
        })?;
        shares.push(time / run);
        print!(" {:.1} |", time / run);
    }
    let error = error(&mut study, &model, &names, SHARE * stop)?;
    println!(" {:.2} of {} | {error:.0e} |", shares[2] / names.len() as f64, names.len());
    Ok(())
}

/// A run to this time with a value changed; its outputs.
fn run(
    model: &Arc<Model>,
    tolerance: Option<f64>,
    outputs: &[usize],
    stop: f64,
    by: Option<(usize, f64)>,
) -> Outcome<Vec<f64>> {
    let mut instance = Instance::new(Arc::clone(model));
    instance.setup(model.program().experiment.start, None, tolerance)?;
    if let Some((variable, value)) = by {
        instance.set(variable, value)?;
    }
    instance.initialise()?;
    instance.step_to(stop)?;
    Ok(outputs.iter().map(|&output| instance.get(output)).collect::<Result<_, _>>()?)
}

/// The largest error of a derivative, relative to the largest of the same parameter.
fn error(study: &mut Study, model: &Arc<Model>, names: &[String], time: f64) -> Outcome<f64> {
    let found = study.sensitivities(names, &[time])?;
    let place = |name: &String| model.program().variables.iter().position(|own| own.name == *name).ok_or(name.clone());
    let outputs: Vec<usize> = found.outputs.iter().map(|(name, _)| place(name)).collect::<Result<_, _>>()?;
    let mut worst: f64 = 0.0;
    let starts =
        study.varying(names, |varying| Ok(varying.parameters().iter().map(|own| own.start).collect::<Vec<f64>>()))?;
    for (column, (name, start)) in names.iter().zip(starts).enumerate() {
        let step = STEP * if start == 0.0 { 1.0 } else { start.abs() };
        let mut sums = vec![0.0; outputs.len()];
        for (times, weight) in [(1.0, 45.0), (2.0, -9.0), (3.0, 1.0)] {
            for sign in [1.0, -1.0] {
                let by = Some((place(name)?, start + sign * times * step));
                let values = run(model, Some(FINE), &outputs, time, by)?;
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += sign * weight * value / (60.0 * step));
            }
        }
        let largest = sums.iter().fold(1.0, |largest: f64, value| largest.max(value.abs()));
        let errors = found.derivatives[0].column(column).into_iter().zip(&sums).map(|(one, two)| (one - two).abs());
        worst = worst.max(errors.fold(0.0, f64::max) / largest);
    }
    Ok(worst)
}

fn shortest<T>(run: impl Fn() -> Outcome<T>) -> Outcome<f64> {
    let mut least = f64::INFINITY;
    for _ in 0..TIMES {
        let start = Instant::now();
        black_box(run()?);
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(least)
}
