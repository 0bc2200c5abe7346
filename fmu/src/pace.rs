//! Whether a communication point will be reached in reasonable time, and with reasonable work.

use crate::context::{Context, Statistics};
use crate::failure::Failure;

/// Most attempts at steps between two communication points.
const MOST_STEPS: u64 = 10_000_000;
/// Most work between two communication points, in instructions of tapes. A core of 2026 does so much in about half a minute (forty loops that turn ever faster: 0.3 ms a
/// step), and in up to a minute where a damaged program consists of slow instructions; of small mechanisms it is more than [`MOST_STEPS`].
pub(crate) const MOST_WORK: u64 = 5_000_000_000;
/// So many attempts show at what pace the motion goes.
const SAMPLE: u64 = 4096;

/// Attempts and time when the pace was last measured, and how many attempts may still be made.
pub(crate) struct Pace {
    attempts: u64,
    time: f64,
    left: u64,
    /// Attempts that have been counted as work, and the work before them.
    counted: u64,
    begin: u64,
}

impl Pace {
    pub fn new(context: &Context, time: f64) -> Self {
        let attempts = attempts(context.statistics);
        Self { attempts, time, left: MOST_STEPS, counted: attempts, begin: context.statistics.work }
    }

    /// Counts the attempts since the last time as work, each so much: fails if that is more than one communication step may take. A step of a large mechanism is work
    /// for thousands of a small one.
    pub fn spend(&mut self, context: &mut Context, [time, target]: [f64; 2], each: f64) -> Result<(), Failure> {
        self.count(context, each);
        let done = context.statistics.work - self.begin;
        if done > context.settings.most_work { Err(Failure::TooMuchWork { time, target }) } else { Ok(()) }
    }

    /// Counts the attempts since the last time as work, each so much: the last ones before a communication point, too, for it may take many calls with one step each to get there.
    pub fn count(&mut self, context: &mut Context, each: f64) {
        let made = attempts(context.statistics);
        context.statistics.work += ((made - self.counted) as f64 * each) as u64;
        self.counted = made;
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
