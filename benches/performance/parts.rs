//! The parts of a step by Taylor series.

use std::fmt::Write;
use std::hint::black_box;

use cotree_fmu::machine::Machine;
use cotree_fmu::taylor::Jet;

use crate::{Failure, fastest, model, scenes, started};

/// The order that a tolerance of 1e-6 takes.
const ORDER: usize = 16;
const STEPS: u32 = 100;

/// What it takes to begin, to find the orders, and to end a step.
pub fn write(text: &mut String) -> Result<(), Failure> {
    *text += "\n## Parts of a step by series\n\nOrder 16. Begin: pose, matrix, its inverse, loops closed, accelerations. Orders: the rest of the series. \
              End: length of the step, motion at its end.\n\n| scene | begin [ns] | orders [ns] | each [ns] | end [ns] |\n|---|---|---|---|---|\n";
    for (title, scene) in scenes::all() {
        let model = model(&scene)?;
        let Some(mut jet) = Jet::new(&model) else { continue };
        let state = started(&model, None, 1e-6)?.state();
        let mut motion = [state.positions(), state.rates()].concat();
        let mut machine = Machine::new(&model);
        machine.load(&model, &state);
        jet.update(machine.registers());
        let repeated = |work: &mut dyn FnMut()| {
            let once = |(): &mut ()| {
                (0..STEPS).for_each(|_| work());
                Ok(())
            };
            fastest(|| Ok(()), once).map(|seconds| 1e9 * seconds / f64::from(STEPS))
        };
        let begin = repeated(&mut || _ = black_box(jet.begin(&model, machine.registers(), black_box(&motion))))?;
        let orders = repeated(&mut || black_box(&mut jet).advance(1, ORDER - 2))?;
        let room = model.program().arms.as_ref().map_or(0, |form| Jet::room(&model, form));
        let mut polynomial = vec![0.0; room];
        jet.write_polynomial(ORDER, &mut polynomial);
        let end = repeated(&mut || {
            let h = black_box(&mut jet).reach(ORDER, 1e-8, 1);
            jet.evaluate(black_box(&polynomial), ORDER, 0.5 * h, &mut motion);
        })?;
        let each = orders / (ORDER - 2) as f64;
        writeln!(text, "| {title} | {begin:.0} | {orders:.0} | {each:.1} | {end:.0} |")?;
    }
    Ok(())
}
