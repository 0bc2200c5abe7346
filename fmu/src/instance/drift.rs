//! Loops that come apart in Model Exchange, and when the importer is asked for an event at which they are closed.
//!
//! The importer integrates accelerations, and its errors let the loops drift. After an event its solver restarts with short steps of order 1, whose errors add up: closing the loops after each step costs
//! more accuracy than the drift does. Each step leaves an error of about the importer's tolerance, so that those of N steps come to N tolerances at most; only beyond that the drift has become
//! larger than what the steps leave in the motion itself. Many importers keep their tolerance for themselves: where the loops come apart faster, the errors of the steps are what has been seen.

use serde::{Deserialize, Serialize};

use super::instants::LARGER;
use super::snapshot::TOLERANCES;
use crate::math::{maximum, minimum};

/// The loops are not closed more often than after so many steps, which may add up their errors.
const STEPS_APART: u32 = 100;

/// What is known of the drift.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Drift {
    /// The errors of a step where they have been seen to be larger than the tolerance, as a share of the scales.
    errors: f64,
    /// How many steps the importer has completed since the loops were closed.
    steps: u32,
}

impl Drift {
    pub fn is_sound(&self) -> bool {
        self.errors.is_finite() && self.errors >= 0.0
    }

    /// The loops have been closed.
    pub fn close(&mut self) {
        self.steps = 0;
    }

    /// True if the loops, which are apart by `gap` after a step of the importer, must be closed.
    pub fn is_due(&mut self, gap: f64, tolerance: f64) -> bool {
        self.steps = self.steps.saturating_add(1);
        if gap > self.limit(tolerance) && self.steps < STEPS_APART {
            self.errors = LARGER * minimum(gap, TOLERANCES[1]) / f64::from(self.steps);
        }
        gap > self.limit(tolerance)
    }

    /// How far the loops may be apart; never further than by the coarsest tolerance.
    fn limit(&self, tolerance: f64) -> f64 {
        minimum(f64::from(STEPS_APART) * maximum(self.errors, tolerance), TOLERANCES[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How often loops are closed that drift by `rate` with each step.
    fn closings(rate: f64, tolerance: f64, steps: u32) -> u32 {
        let (mut drift, mut gap, mut count) = (Drift::default(), 0.0, 0);
        for _ in 0..steps {
            gap += rate;
            if drift.is_due(gap, tolerance) {
                (gap, count) = (0.0, count + 1);
                drift.close();
            }
        }
        count
    }

    #[test]
    fn loops_are_closed_where_the_errors_of_many_steps_have_added_up() {
        assert_eq!(closings(1e-9, 1e-6, 10_000), 0, "within the tolerance");
        assert_eq!(closings(1e-6, 1e-6, 10_000), 99, "as the tolerance says");
        let unknown = closings(1e-6, 1e-9, 10_000);
        assert!((5..=20).contains(&unknown), "a tolerance that the importer does not use: {unknown}");
    }

    #[test]
    fn no_drift_exceeds_the_coarsest_tolerance() {
        assert_eq!(closings(4e-3, 1e-9, 300), 100);
        assert_eq!(closings(f64::NAN, 1e-9, 10), 0);
    }
}
