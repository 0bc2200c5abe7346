//! Sensitivities of the initial state: from the given initial values and the loop equations.

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use super::super::AnalysisFailure;
use super::super::decompose::svd;
use super::super::variation::{ColumnBlock, Numbers, RowBlock};

/// Singular values count as zero below this share of the largest.
const RANK: f64 = 1e-10;
/// Equations contradict each other where more than this share of a change is left.
const CONTRADICTION: f64 = 1e-8;

/// Why there are no derivatives at the start.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct StartError(pub String);

cotree::diagnostic::from_messages!(StartError as StartError: AnalysisFailure);

/// q_p and v_p at the start, given how rows change with the parameters; `speeds` are the rates of the mechanism's coordinates there: states begin with values of their own.
pub fn start(
    numbers: &Numbers,
    by: impl Fn(RowBlock) -> DMatrix<f64>,
    speeds: &DVector<f64>,
) -> Result<(DMatrix<f64>, DMatrix<f64>), StartError> {
    let of = |row: RowBlock, column: ColumnBlock| numbers.block(row, column);
    let known = stacked(&of(RowBlock::Loops, ColumnBlock::Positions), &of(RowBlock::Starts, ColumnBlock::Positions));
    let (positions, _) = least(&known, &-stacked(&by(RowBlock::Loops), &by(RowBlock::Starts)))?;
    let turning = |row: RowBlock| product(&of(row, ColumnBlock::Positions), &positions) + by(row);
    let known = stacked(&of(RowBlock::Rates, ColumnBlock::Rates), &of(RowBlock::StartRates, ColumnBlock::Rates));
    let (changes, full) = least(&known, &-stacked(&turning(RowBlock::Rates), &turning(RowBlock::StartRates)))?;
    // The rates that were left open are the smallest ones; where they are not zero, their derivative needs the curvature of the loops.
    if !full && speeds.norm() > 0.0 {
        return Err(StartError(
            "`[initial]` does not determine the velocities of a mechanism that moves at the start: give them"
                .to_owned(),
        ));
    }
    Ok((positions, changes))
}

/// Of loop equations that repeat others: do they still do so when parameters change? They change by so much with these.
pub fn check_repeated(numbers: &Numbers, by_parameters: &DMatrix<f64>, positions: &DMatrix<f64>) -> Result<(), usize> {
    let followed = numbers.block(RowBlock::Repeated, ColumnBlock::Positions) * positions;
    let left = by_parameters + &followed;
    let contradicts = |&column: &usize| {
        left.column(column).amax()
            > CONTRADICTION * (1.0 + by_parameters.column(column).amax() + followed.column(column).amax())
    };
    (0..by_parameters.ncols()).find(contradicts).map_or(Ok(()), Err)
}

/// True if the loop equations that repeat others still do so: with other lengths they may not.
pub fn still_repeat(numbers: &Numbers) -> Result<bool, AnalysisFailure> {
    let of = |row: RowBlock| numbers.block(row, ColumnBlock::Positions);
    let (imposed, repeated) = (of(RowBlock::Loops), of(RowBlock::Repeated));
    if imposed.is_empty() || repeated.is_empty() {
        return Ok(repeated.iter().all(|entry| *entry == 0.0));
    }
    let parts = svd(imposed, false, true)?;
    let Some(along) = parts.v_t else { return Err(AnalysisFailure::Range) };
    let left = &repeated - (&repeated * along.transpose()) * along;
    Ok((0..left.nrows()).all(|row| left.row(row).amax() <= CONTRADICTION * repeated.row(row).amax()))
}

/// The smallest solution of A X = B, and whether it is the only one.
fn least(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<(DMatrix<f64>, bool), StartError> {
    let n = a.ncols();
    if a.nrows() == 0 || n == 0 {
        return Ok((DMatrix::zeros(n, b.ncols()), n == 0));
    }
    let parts = svd(a.clone(), true, true)?;
    let limit = RANK * parts.singular_values.max();
    let rank = parts.singular_values.iter().filter(|value| **value > limit).count();
    let mut solution = DMatrix::zeros(n, b.ncols());
    for (mut place, column) in solution.column_iter_mut().zip(b.column_iter()) {
        place.copy_from(&parts.solve(&column, limit).map_err(|error| StartError(error.to_string()))?);
    }
    let left = product(a, &solution) - b;
    if left.amax() > CONTRADICTION * (1.0 + b.amax()) {
        return Err(StartError("the initial values and the loops are compatible for these values only".to_owned()));
    }
    Ok((solution, rank == n))
}

/// A B, each column by itself: its bits do not depend on the others.
fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(a.nrows(), b.ncols());
    for (mut place, column) in product.column_iter_mut().zip(b.column_iter()) {
        place.copy_from(&(a * column));
    }
    product
}

/// One matrix above another.
pub(super) fn stacked(above: &DMatrix<f64>, below: &DMatrix<f64>) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(above.nrows() + below.nrows(), above.ncols());
    all.rows_mut(0, above.nrows()).copy_from(above);
    all.rows_mut(above.nrows(), below.nrows()).copy_from(below);
    all
}
