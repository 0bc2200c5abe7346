//! Whether a communication point will be reached in reasonable time.

use crate::context::{Context, Statistics};
use crate::failure::Failure;

/// Most attempts at steps between two communication points.
const MOST_STEPS: u64 = 10_000_000;
/// So many attempts show at what pace the motion goes.
const SAMPLE: u64 = 4096;

/// Attempts and time when the pace was last measured, and how many attempts may still be made.
pub(crate) struct Pace {
    attempts: u64,
    time: f64,
    left: u64,
}

impl Pace {
    pub fn new(context: &Context, time: f64) -> Self {
        Self { attempts: attempts(context.statistics), time, left: MOST_STEPS }
    }

    /// Measures the pace now and then: fails if so many steps as would be too many are still to come at the pace since the last time.
    pub fn check(&mut self, context: &Context, time: f64, target: f64) -> Result<(), Failure> {
        let made = attempts(context.statistics) - self.attempts;
        if made < SAMPLE {
            return Ok(());
        }
        let to_come = (target - time) / (time - self.time) * made as f64;
        // Written so that a run that stands still is too slow too.
        let enough = to_come < self.left as f64;
        if !enough {
            let pace = (time - self.time) / made as f64;
            return Err(Failure::TooManySteps { time, pace, target, most: MOST_STEPS });
        }
        self.left = self.left.saturating_sub(made);
        (self.attempts, self.time) = (attempts(context.statistics), time);
        Ok(())
    }
}

fn attempts(statistics: &Statistics) -> u64 {
    statistics.steps + statistics.rejected
}
