//! Time at a wanted error, against the targets of the project.

use std::fmt::Write;

use cotree_fmu::instance::Instance;

use crate::{Failure, error_at_end, fastest, model, scenes, started};

/// Scene, wanted error, target and a program written by hand \[ms\].
fn list() -> [(&'static str, String, f64, f64, f64); 5] {
    let ten_seconds = scenes::four_bars(40).replace("stop = 1\n", "stop = 10\n");
    [
        ("S1 slider-crank, 10 s", scenes::model("bench_slider_crank"), 1e-6, 0.15, 0.24),
        ("S2 Andrews, 0.03 s", scenes::model("andrews"), 1e-8, 0.08, 0.13),
        ("S3 40 four-bars, 10 s", ten_seconds, 1e-2, 1.2, 0.63),
        ("S4 chain of 50, 1 s", scenes::chain(50), 1e-8, 2.3, 2.34),
        ("S6 stiff slider-crank, 10 s", scenes::stiff(), 1e-6, 9.0, 9.1),
    ]
}

/// The time of the loosest tolerance whose error is small enough.
pub fn write(text: &mut String) -> Result<(), Failure> {
    *text += "\n## Targets\n\nTime at the loosest tolerance of 1e-3, 1e-4, ... whose error at the end, in coordinates and against a run at 1e-12, is the wanted one. By \
              hand: C++ with Runge-Kutta of order 8, written for the one mechanism; measured once, on a machine of the same kind.\n\n\
              | scene | error | tolerance | error found | time [ms] | target [ms] | by hand [ms] |\n|---|---|---|---|---|---|---|\n";
    for (title, scene, wanted, target, hand) in list() {
        let model = model(&scene)?;
        let stop = model.program().experiment.stop;
        let run = |instance: &mut Instance| -> Result<(), Failure> { Ok(instance.step_to(stop)?) };
        let mut exact = started(&model, None, 1e-12)?;
        run(&mut exact)?;
        for exponent in 3..=11 {
            let tolerance = 10.0_f64.powi(-exponent);
            let mut instance = started(&model, None, tolerance)?;
            run(&mut instance)?;
            let error = error_at_end(&instance, &exact);
            if error <= wanted {
                let time = 1e3 * fastest(|| started(&model, None, tolerance), run)?;
                writeln!(
                    text,
                    "| {title} | {wanted:.0e} | {tolerance:.0e} | {error:.0e} | {time:.3} | {target} | {hand} |"
                )?;
                break;
            }
        }
    }
    Ok(())
}
