//! Standard errors and correlations: how well the measurements determine the quantities.

use cotree::diagnostic::suggest;
use nalgebra::{DMatrix, DVector};

use super::levenberg::Residuals;
use super::request::Weighed;
use super::student::{NORMAL, limits_95};
use super::{FittedQuantity, Unidentified};
use crate::analysis::Varying;
use crate::analysis::decompose::svd;

/// Quantities are not determined where a combination of them has less than this share of the effect of others.
const UNDETERMINED: f64 = 1e-6;
/// Of such a combination those that take this share of it.
const TAKES_PART: f64 = 0.1;
/// A quantity has no effect if its whole size changes what was measured by less than this share of its standard deviation.
const NO_EFFECT: f64 = 1e-6;

/// Variances and covariances of the quantities.
pub(super) struct Estimates {
    /// What is not at its bound.
    free: Vec<usize>,
    covariance: DMatrix<f64>,
    /// So many standard errors to either side.
    limits: f64,
}

impl Estimates {
    /// From the residuals at the minimum, in standard deviations.
    ///
    /// # Errors
    /// Which quantities are not determined.
    pub fn new(
        residuals: &Residuals,
        values: &[f64],
        weighed: &Weighed,
        varying: &Varying,
    ) -> Result<Self, Unidentified> {
        let is_free =
            |&index: &usize| values[index] > weighed.bounds[index][0] && values[index] < weighed.bounds[index][1];
        let free: Vec<usize> = (0..values.len()).filter(is_free).collect();
        let names: Vec<&str> = free.iter().map(|&index| varying.parameters()[index].name.as_str()).collect();
        let jacobian = residuals.derivatives.select_columns(&free);
        let norms: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
        let idle = free.iter().zip(&norms).map(|(&index, norm)| norm * values[index].abs().max(f64::MIN_POSITIVE));
        let idle = idle
            .zip(&norms)
            .map(|(effect, norm)| *norm == 0.0 || effect > f64::MIN_POSITIVE * norm && effect < NO_EFFECT);
        let idle = suggest::list(names.iter().zip(idle).filter(|(_, idle)| *idle).map(|(name, _)| name));
        if !idle.is_empty() {
            return Err(Unidentified(format!(
                "the measured values do not determine {names}: no measured value depends on it: remove it from --vary, or measure something that it changes",
                names = idle
            )));
        }
        let covariance = covariance(&jacobian, &norms).map_err(|direction| {
            let takes_part = direction.iter().zip(&names).filter(|(share, _)| share.abs() > TAKES_PART);
            Unidentified(format!("the measured values do not determine {names}: only a combination of them has an effect: remove one from --vary, or measure something else too", names = suggest::list(takes_part.map(|(_, name)| name))))
        })?;
        let all_given = weighed.deviations.iter().all(|(_, is_given)| *is_given);
        let degrees = residuals.values.len().saturating_sub(free.len()).max(1);
        Ok(Estimates { free, covariance, limits: if all_given { NORMAL } else { limits_95(degrees) } })
    }

    pub fn quantities(&self, start: &[f64], values: &[f64], varying: &Varying) -> Vec<FittedQuantity> {
        let quantity = |(index, varied): (usize, &crate::analysis::VariedQuantity)| {
            let place = self.free.iter().position(|&free| free == index);
            let error = place.map(|place| self.covariance[(place, place)].sqrt());
            let value = values[index];
            FittedQuantity {
                name: varied.name.clone(),
                unit: varied.unit.si.clone(),
                start: start[index],
                value,
                error,
                limits: error.map(|error| [value - self.limits * error, value + self.limits * error]),
            }
        };
        varying.parameters().iter().enumerate().map(quantity).collect()
    }

    /// Not a number where a quantity is at its bound.
    pub fn correlation(&self, count: usize) -> DMatrix<f64> {
        let place = |index: usize| self.free.iter().position(|&free| free == index);
        DMatrix::from_fn(count, count, |row, column| match (place(row), place(column)) {
            (Some(row), Some(column)) => {
                let [variance, other] = [row, column].map(|index| self.covariance[(index, index)]);
                if row == column { 1.0 } else { self.covariance[(row, column)] / (variance * other).sqrt() }
            }
            _ => f64::NAN,
        })
    }
}

/// The inverse of J^T J by the singular values of J with columns of length one.
///
/// # Errors
/// The combination that has no effect.
fn covariance(jacobian: &DMatrix<f64>, norms: &[f64]) -> Result<DMatrix<f64>, DVector<f64>> {
    let count = norms.len();
    if count == 0 {
        return Ok(DMatrix::zeros(0, 0));
    }
    let scaled = DMatrix::from_fn(jacobian.nrows(), count, |row, column| jacobian[(row, column)] / norms[column]);
    let everything = || DVector::from_element(count, 1.0);
    let parts = svd(scaled, false, true).map_err(|_| everything())?;
    let Some(right) = &parts.v_t else { return Err(everything()) };
    let singular = &parts.singular_values;
    let last = singular.len() - 1;
    // Written so that what is not a number is not determined.
    let is_determined = singular[last] > UNDETERMINED * singular[0];
    if !is_determined {
        return Err(right.row(last).transpose());
    }
    Ok(DMatrix::from_fn(count, count, |row, column| {
        let along = (0..=last).map(|part| right[(part, row)] * right[(part, column)] / singular[part].powi(2));
        along.sum::<f64>() / (norms[row] * norms[column])
    }))
}
