//! Nonlinear least squares with bounds: Levenberg (1944) and Marquardt (1963), with the scaling of Moré (1978). Steps are cut at the bounds, and what is pushed
//! against its bound stays there.

use nalgebra::{DMatrix, DVector};

use crate::analysis::AnalysisFailure;
use crate::analysis::decompose::least_squares;

/// A step that changes the values by less than this share is the last.
const SETTLED: f64 = 1e-9;
/// The residuals are perpendicular to all changes within this.
const PERPENDICULAR: f64 = 1e-9;
/// The sum of squares can be made smaller by no more than this share.
const FLAT: f64 = 1e-14;
/// Damping at first, in units of the scaled system.
const FIRST: f64 = 1e-3;
/// The first damping after a step that made it worse.
const WORSE: f64 = 1e-6;

/// Residuals, and their derivatives: a row for each, a column for each value.
#[derive(Clone, Debug)]
pub struct Residuals {
    pub values: DVector<f64>,
    pub derivatives: DMatrix<f64>,
}

/// Where the sum of squares is least; with what was evaluated beside the residuals there.
#[derive(Clone, Debug)]
pub struct Minimum<T> {
    pub values: Vec<f64>,
    pub beside: T,
    pub ended: FitEnded,
    /// Why there is no motion on the other side, where the search could not go on: no minimum.
    pub blocked: Option<String>,
    /// How often the residuals were evaluated.
    pub evaluations: usize,
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitEnded {
    /// At a minimum: no step makes the sum of squares smaller.
    Settled,
    /// After as many evaluations as were permitted.
    Exhausted,
    /// Somebody has asked for it.
    Stopped,
}

/// Values that were tried.
#[derive(Clone, Copy, Debug)]
pub struct FitTrial<'a> {
    /// SI.
    pub values: &'a [f64],
    /// The root of the sum of the squares of the residuals; none where there are none.
    pub length: Option<f64>,
    /// Does the search go on from there?
    pub is_accepted: bool,
}

/// Searches from a start within the bounds. The values to be evaluated come with what was evaluated beside the residuals where the search is. Whoever is told of a trial says
/// whether the search goes on.
///
/// # Errors
/// There are no residuals at the start.
pub fn minimise<T>(
    start: &[f64],
    bounds: &[[f64; 2]],
    most: usize,
    mut evaluate: impl FnMut(&[f64], Option<&T>) -> Result<(Residuals, T), AnalysisFailure>,
    mut goes_on: impl FnMut(FitTrial) -> bool,
) -> Result<Minimum<T>, AnalysisFailure> {
    let mut values = DVector::from_column_slice(start);
    let (mut here, mut beside) = evaluate(start, None)?;
    let mut stopped = !goes_on(FitTrial { values: start, length: Some(here.values.norm()), is_accepted: true });
    let mut scales = DVector::zeros(start.len());
    let (mut damping, mut evaluations, mut blocked) = (FIRST, 1, None);
    let ended = 'search: loop {
        for (scale, column) in scales.iter_mut().zip(here.derivatives.column_iter()) {
            *scale = column.norm().max(*scale);
        }
        let Some(step) = DampedSteps::new(&here, &values, bounds, &scales) else { break FitEnded::Settled };
        let moved = loop {
            let next = step.at(damping);
            let change = &next - &values;
            let size = |values: &DVector<f64>| values.component_mul(&scales).norm();
            if size(&change) <= SETTLED * size(&values) {
                break 'search FitEnded::Settled;
            }
            if stopped {
                break 'search FitEnded::Stopped;
            }
            if evaluations == most {
                break 'search FitEnded::Exhausted;
            }
            evaluations += 1;
            let sum = here.values.norm_squared();
            let predicted = sum - (&here.values + &here.derivatives * &change).norm_squared();
            // Where there is no motion it is worse than anything.
            let there = evaluate(next.as_slice(), Some(&beside));
            blocked = there.as_ref().err().map(AnalysisFailure::to_string);
            let length = there.as_ref().ok().map(|(there, _)| there.values.norm());
            let there = there.ok().filter(|(there, _)| there.values.norm_squared() < sum);
            stopped = !goes_on(FitTrial { values: next.as_slice(), length, is_accepted: there.is_some() });
            let Some(there) = there else {
                if predicted <= FLAT * sum {
                    // However the trial ended, no step could have been better.
                    blocked = None;
                    break 'search FitEnded::Settled;
                }
                damping = (4.0 * damping).max(WORSE);
                continue;
            };
            let gain = (sum - there.0.values.norm_squared()) / predicted;
            if gain > 0.75 {
                damping *= 0.1;
            } else if gain < 0.25 {
                damping = (4.0 * damping).max(WORSE);
            }
            break (next, there);
        };
        (values, (here, beside)) = moved;
    };
    // A search that was ended by something else would have gone on with a shorter step.
    let blocked = blocked.filter(|_| ended == FitEnded::Settled);
    Ok(Minimum { values: values.as_slice().to_vec(), beside, ended, blocked, evaluations })
}

/// The steps from a point, for any damping.
struct DampedSteps<'a> {
    here: &'a Residuals,
    values: &'a DVector<f64>,
    bounds: &'a [[f64; 2]],
    scales: &'a DVector<f64>,
    /// What is not kept at its bound.
    free: Vec<usize>,
}

impl<'a> DampedSteps<'a> {
    /// None where nothing makes the sum of squares smaller.
    fn new(
        here: &'a Residuals,
        values: &'a DVector<f64>,
        bounds: &'a [[f64; 2]],
        scales: &'a DVector<f64>,
    ) -> Option<Self> {
        let length = here.values.norm();
        let uphill = here.derivatives.tr_mul(&here.values);
        let is_free = |&index: &usize| {
            let [low, high] = bounds[index];
            let outwards = values[index] <= low && uphill[index] > 0.0 || values[index] >= high && uphill[index] < 0.0;
            scales[index] > 0.0 && !outwards
        };
        let free: Vec<usize> = (0..values.len()).filter(is_free).collect();
        let across =
            |&index: &usize| uphill[index].abs() > PERPENDICULAR * length * here.derivatives.column(index).norm();
        free.iter().any(across).then_some(DampedSteps { here, values, bounds, scales, free })
    }

    /// The values after a step: what would leave its bounds goes as far as they permit, and the others make the best of that.
    fn at(&self, damping: f64) -> DVector<f64> {
        let (mut next, mut free) = (self.values.clone(), self.free.clone());
        while let Some(step) = self.solved(&next, &free, damping) {
            let wanted = |place: usize| self.values[free[place]] - step[place] / self.scales[free[place]];
            let is_within = |place: &usize| {
                let [low, high] = self.bounds[free[*place]];
                (low..=high).contains(&wanted(*place))
            };
            let (within, outside): (Vec<usize>, Vec<usize>) = (0..free.len()).partition(is_within);
            let stays = outside.is_empty();
            for place in if stays { &within } else { &outside } {
                let [low, high] = self.bounds[free[*place]];
                next[free[*place]] = wanted(*place).clamp(low, high);
            }
            if stays {
                break;
            }
            free = within.into_iter().map(|place| free[place]).collect();
        }
        next
    }

    /// The damped step of some of them, downhill with a minus, in their scales; the others are where they are in `next`.
    fn solved(&self, next: &DVector<f64>, free: &[usize], damping: f64) -> Option<DVector<f64>> {
        if free.is_empty() {
            return None;
        }
        let Residuals { values, derivatives } = self.here;
        let scaled = DMatrix::from_fn(values.len(), free.len(), |row, column| {
            derivatives[(row, free[column])] / self.scales[free[column]]
        });
        least_squares(&scaled, &(values + derivatives * (next - self.values)), damping).ok()
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;

    const OPEN: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// The minimum of residuals beside which nothing is evaluated.
    fn least(
        start: &[f64],
        bounds: &[[f64; 2]],
        most: usize,
        mut evaluate: impl FnMut(&[f64]) -> Result<Residuals, AnalysisFailure>,
    ) -> Minimum<()> {
        minimise(start, bounds, most, |x, _| Ok((evaluate(x)?, ())), |_| true).unwrap()
    }

    fn rosenbrock(x: &[f64]) -> Result<Residuals, AnalysisFailure> {
        let values = DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
        Ok(Residuals { values, derivatives: DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]) })
    }

    #[test]
    fn the_valley_of_rosenbrock_leads_to_its_minimum() {
        let found = least(&[-1.2, 1.0], &[OPEN; 2], 200, rosenbrock);
        assert!(found.ended == FitEnded::Settled && found.values.iter().all(|x| (x - 1.0).abs() < 1e-8), "{found:?}");
        let short = least(&[-1.2, 1.0], &[OPEN; 2], 3, rosenbrock);
        assert_eq!((short.ended, short.evaluations), (FitEnded::Exhausted, 3));
    }

    #[test]
    fn bounds_are_kept_and_left_again() {
        // Within x0 <= 0.5 the minimum is on the bound, with x1 = x0^2.
        let found = least(&[-1.2, 1.0], &[[-2.0, 0.5], OPEN], 200, rosenbrock);
        assert!((found.values[0] - 0.5).abs() < 1e-12 && (found.values[1] - 0.25).abs() < 1e-8, "{found:?}");
        let found = least(&[-2.0, 4.0], &[[-2.0, 3.0], OPEN], 200, rosenbrock);
        assert!(found.values.iter().all(|x| (x - 1.0).abs() < 1e-8), "{found:?}");
    }

    /// Of an exponential, with values where it has none: the search keeps away from there.
    #[test]
    fn points_without_residuals_are_avoided() {
        let times = [0.0, 1.0, 2.0, 3.0];
        let found = least(&[5.0], &[OPEN], 100, |x| {
            if x[0] < 0.0 {
                return Err(AnalysisFailure::Range);
            }
            let values = times.iter().map(|t| (-x[0] * t).exp() - (-0.3 * t).exp());
            let derivatives = times.iter().map(|t| -t * (-x[0] * t).exp());
            Ok(Residuals {
                values: DVector::from_iterator(4, values),
                derivatives: DMatrix::from_iterator(4, 1, derivatives),
            })
        });
        assert!((found.values[0] - 0.3).abs() < 1e-8);
    }

    #[test]
    fn what_has_no_effect_stays() {
        let found = least(&[7.0, 2.0], &[OPEN; 2], 50, |x| {
            let derivatives = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 1.0]);
            Ok(Residuals { values: DVector::from_vec(vec![x[1] - 1.0, x[1] - 2.0]), derivatives })
        });
        assert!(found.values[0] == 7.0 && (found.values[1] - 1.5).abs() < 1e-8, "{found:?}");
    }

    /// Each trial starts from what was evaluated where the search is, and whoever watches ends it.
    #[test]
    fn trials_begin_where_the_search_is_and_can_be_stopped() {
        let (accepted, mut told) = (RefCell::new(None), 0);
        let evaluate = |x: &[f64], beside: Option<&Vec<f64>>| {
            assert_eq!(beside, accepted.borrow().as_ref());
            Ok((rosenbrock(x)?, x.to_vec()))
        };
        let watch = |trial: FitTrial| {
            if trial.is_accepted {
                accepted.replace(Some(trial.values.to_vec()));
            }
            told += 1;
            told < 5
        };
        let found = minimise(&[-1.2, 1.0], &[OPEN; 2], 200, evaluate, watch).unwrap();
        assert_eq!((found.ended, found.evaluations, told), (FitEnded::Stopped, 5, 5));
        assert_eq!((Some(&found.values), &found.beside), (accepted.borrow().as_ref(), &found.values));
    }
}
