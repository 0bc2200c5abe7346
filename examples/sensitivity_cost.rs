//! What derivatives of a motion cost: the time of a run of the program alone, and how many of those a run with derivatives by 1, 4 and 8 parameters takes.
//!
//! `cargo run --release --example sensitivity_cost`

use std::error::Error;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use cotree::Scene;
use cotree::analysis::Study;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

/// Each time is the shortest of so many.
const TIMES: usize = 9;

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:<20} {:>10} {:>10} {:>10} {:>10} {:>8}", "model", "run [us]", "1", "4", "8", "per one");
    for name in ["slider_crank", "double_pendulum", "andrews", "watt_six_bar", "quick_return", "gas_strut"] {
        measure(name)?;
    }
    Ok(())
}

fn measure(name: &str) -> Result<(), Box<dyn Error>> {
    let scene = Scene::from_toml(&std::fs::read_to_string(format!("models/{name}/scene.toml"))?)?;
    let compiled = cotree::compile(&scene)?;
    let model = Arc::new(Model::new(compiled.program.clone())?);
    let experiment = compiled.program.experiment;
    let stop = experiment.stop;
    let run = shortest(|| {
        let mut instance = Instance::new(Arc::clone(&model));
        instance.setup(experiment.start, None, None)?;
        instance.initialise()?;
        Ok(instance.step_to(stop)?)
    })?;
    let program = &compiled.program;
    let names = program.parameters.iter().map(|own| &own.name).chain(program.inputs.iter().map(|own| &own.name));
    let names: Vec<String> = names.take(8).cloned().collect();
    let mut study = Study::new(&scene)?;
    print!("{name:<20} {:>10.0}", 1e6 * run);
    let mut shares = Vec::new();
    for count in [1, 4, 8] {
        let to = &names[..count.min(names.len())];
        let time = study.varying(to, |varying| {
            let start: Vec<f64> = varying.parameters().iter().map(|own| own.start).collect();
            Ok(shortest(|| Ok(black_box(varying.at(&start, &[stop])?).len())).unwrap_or(f64::NAN))
        })?;
        shares.push(time / run);
        print!(" {:>10.2}", time / run);
    }
    println!(" {:>8.2} of {}", (shares[2] - shares[0]) / (names.len() - 1) as f64, names.len());
    Ok(())
}

fn shortest<T>(run: impl Fn() -> Result<T, Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let mut times = Vec::new();
    for _ in 0..TIMES {
        let start = Instant::now();
        black_box(run()?);
        times.push(start.elapsed().as_secs_f64());
    }
    Ok(times.into_iter().fold(f64::INFINITY, f64::min))
}
