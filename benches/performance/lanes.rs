//! Many runs of one model side by side.

use std::fmt::Write;
use std::sync::Arc;
use std::time::Instant;

use cotree_fmu::instance::{Instance, Lanes, MOST_LANES, Member};
use cotree_fmu::model::Model;

use crate::{Failure, model, scenes, started};

const TOLERANCE: f64 = 1e-6;
const RUNS: usize = 64;
/// In turns, so that a busy moment of the machine does not count for one of them only.
const ROUNDS: usize = 7;
/// None: by single simulations.
const LANES: [usize; 4] = [0, 1, 2, MOST_LANES];

struct Whole {
    instance: Instance,
    stop: f64,
    failed: bool,
}

impl Member for Whole {
    fn instance(&mut self) -> &mut Instance {
        &mut self.instance
    }

    fn next(&mut self) -> Option<f64> {
        (self.instance.time() < self.stop && !self.failed).then_some(self.stop)
    }

    fn reach(&mut self) {
        self.failed = self.instance.step_to(self.stop).is_err();
    }
}

/// Microseconds for each run, from its start to its end without points between, and the gain by lanes.
pub fn write(text: &mut String) -> Result<(), Failure> {
    *text += "\n## Many runs side by side\n\nMicroseconds of one thread for each of 64 runs at 1e-6, starts apart. Single: without lanes.\n\n\
              | scene | single | 1 lane | 2 lanes | 4 lanes | 4 lanes to 1 lane | 4 lanes to single |\n\
              |---|---|---|---|---|---|---|\n";
    let cases = [
        ("S1 slider-crank, 10 s", scenes::model("bench_slider_crank")),
        ("S2 Andrews, 0.03 s", scenes::model("andrews")),
        ("slider-crank of the gallery", scenes::model("slider_crank")),
        ("double pendulum", scenes::model("double_pendulum")),
        ("S3 one four-bar, 1 s", scenes::four_bars(1)),
        ("S3 five four-bars, 1 s", scenes::four_bars(5)),
    ];
    for (title, scene) in cases {
        let found = times(&model(&scene)?)?;
        let [single, one, two, four] = found.map(|seconds| 1e6 * seconds);
        writeln!(
            text,
            "| {title} | {single:.1} | {one:.1} | {two:.1} | {four:.1} | {:.1} | {:.1} |",
            one / four,
            single / four
        )?;
    }
    Ok(())
}

/// Seconds for each run.
fn times(model: &Arc<Model>) -> Result<[f64; 4], Failure> {
    let stop = model.program().experiment.stop;
    let mut best = [f64::INFINITY; 4];
    for _ in 0..ROUNDS {
        for (best, &lanes) in best.iter_mut().zip(&LANES) {
            let start = || Ok(Whole { instance: started(model, None, TOLERANCE)?, stop, failed: false });
            let members = (0..RUNS).map(|_| start()).collect::<Result<Vec<_>, Failure>>()?;
            let mut lanes = Lanes::new(model, TOLERANCE, lanes);
            let mut ended = Vec::with_capacity(RUNS);
            let begin = Instant::now();
            lanes.run(members.into_iter(), |member| ended.push(member));
            let seconds = begin.elapsed().as_secs_f64();
            if ended.iter().any(|member| member.failed) {
                return Err("a run has failed".into());
            }
            *best = best.min(seconds / RUNS as f64);
        }
    }
    Ok(best)
}
