//! The objective when one quantity differs from its optimum.

use super::{AnalysisFailure, Best, OptimizeError, SAME, Searches, Start};

/// Steps from bound to bound; of turns, which take longer, fewer.
const STEPS: usize = 40;
const TURN_STEPS: usize = 20;

/// One quantity from bound to bound, or as much around its best value where it has none; SI.
#[derive(Clone, Debug, PartialEq)]
pub struct NearOptimum {
    /// The values of the quantity, ascending.
    pub values: Vec<f64>,
    /// The goal at each of them; not a number where there is no motion.
    pub goal: Vec<f64>,
    /// What each limit bounds.
    pub limits: Vec<Vec<f64>>,
}

impl Searches<'_, '_> {
    /// One for each quantity. Motions go on from their neighbours, from the best values outwards.
    pub(super) fn around(&self, best: &Best) -> Result<Result<Vec<NearOptimum>, OptimizeError>, AnalysisFailure> {
        let values: Vec<f64> = best.quantities.iter().map(|quantity| quantity.value).collect();
        let (seen, start) = self.motions.seen(&values, None)?;
        let goal = self.checked.problem.worth(&seen).map(|(goal, _)| self.checked.sign * goal);
        let is_it = goal.zip(best.values[1]).is_some_and(|(goal, best)| (goal - best).abs() <= SAME[0] * best.abs());
        if !is_it {
            return Ok(Err(OptimizeError::OtherBranch));
        }
        Ok(Ok((0..values.len()).map(|quantity| self.along(quantity, &values, &start)).collect()))
    }

    fn along(&self, quantity: usize, best: &[f64], start: &Start) -> NearOptimum {
        let problem = &self.checked.problem;
        let range = problem.ranges[quantity];
        let end = |bound: f64, side: f64| if bound.is_finite() { bound } else { best[quantity] + side * range };
        let [low, high] = problem.bounds[quantity];
        let [low, high] = [end(low, -1.0), end(high, 1.0)];
        let steps = if self.request.turn.is_some() { TURN_STEPS } else { STEPS };
        let mut values: Vec<f64> = (0..=steps).map(|step| low + (high - low) * step as f64 / steps as f64).collect();
        let place = values.partition_point(|value| *value < best[quantity]);
        values.insert(place, best[quantity]);
        let mut around = NearOptimum {
            goal: vec![f64::NAN; values.len()],
            limits: vec![vec![f64::NAN; values.len()]; problem.limits.len()],
            values,
        };
        let last = around.values.len();
        for places in [(place..last).collect::<Vec<_>>(), (0..place).rev().collect()] {
            let mut from = start.clone();
            for place in places {
                let mut all = best.to_vec();
                all[quantity] = around.values[place];
                let Ok((seen, start)) = self.motions.seen(&all, Some(&from)) else { break };
                around.goal[place] = problem.worth(&seen).map_or(f64::NAN, |(goal, _)| self.checked.sign * goal);
                for (value, limit) in around.limits.iter_mut().zip(&problem.limits) {
                    value[place] = limit.sum.of(&seen).unwrap_or(f64::NAN);
                }
                from = start;
            }
        }
        around
    }
}
