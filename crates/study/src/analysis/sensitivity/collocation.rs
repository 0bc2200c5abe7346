//! A step by collocation, for motions without series and those that are stiff.

use nalgebra::{DMatrix, Dyn, LU};

use super::super::variation::{ColumnBlock, Numbers, RowBlock};
use super::super::{AnalysisFailure, decompose};
use super::rule::NODES;
use super::step::{At, DifferentiatedMotion, move_on, read, sides, until};

/// The last coefficients of a_p may be this share of all, times the tolerance; no smaller than rounding permits.
pub(super) const SMALLEST: f64 = 1e-12;
/// Sweeps over the nodes of a step.
const SWEEPS: usize = 100;
/// A sweep that changes v_p by less than this share is the last.
const SETTLED: f64 = 1e-14;

/// The variational equations at a node: a_p = by_positions q_p + by_rates v_p + by_parameters.
pub(super) struct CollocationNode {
    by_positions: DMatrix<f64>,
    by_rates: DMatrix<f64>,
    by_parameters: DMatrix<f64>,
}

impl CollocationNode {
    /// The factors of 1 - s (d/dv) - s^2 (d/dq): the accelerations of a node have a share s in its own rates, and those in its own positions.
    fn factors(&self, share: f64) -> LU<f64, Dyn, Dyn> {
        let n = self.by_rates.nrows();
        (DMatrix::identity(n, n) - &self.by_rates * share - &self.by_positions * (share * share)).lu()
    }
}

/// A step that was tried: v_p and a_p, a column for each node, and by how much the last coefficients of a_p exceed what is permitted.
pub(super) struct Tried {
    rates: DMatrix<f64>,
    accelerations: DMatrix<f64>,
    pub excess: f64,
}

impl DifferentiatedMotion<'_> {
    /// Tries a step. `None` if it does not settle.
    pub(super) fn attempt(&mut self, length: f64) -> Result<Option<Tried>, AnalysisFailure> {
        (self.tried, self.points) = (self.tried + 1, self.points + NODES as u64);
        let nodes = self.nodes(length)?;
        Ok(self.solve(&nodes, length))
    }

    /// The equations at the nodes of a step.
    fn nodes(&mut self, length: f64) -> Result<Vec<CollocationNode>, AnalysisFailure> {
        let mut motion = self.motion.clone();
        let begin = motion.time();
        let (n, parameters) = self.positions.shape();
        let mut matrix = DMatrix::zeros(n, 2 * n + parameters);
        let nodes = self.rule.nodes.iter().map(|node| {
            move_on(&mut motion, begin + node * length)?;
            self.variational.accelerations(&mut motion, matrix.as_mut_slice())?;
            let columns = |first: usize, count: usize| matrix.columns(first, count).into_owned();
            Ok(CollocationNode {
                by_positions: columns(0, n),
                by_rates: columns(n, n),
                by_parameters: columns(2 * n, parameters),
            })
        });
        nodes.collect()
    }

    /// Collocation by sweeps from node to node, each of which solves for its own accelerations: the equations are linear, and what is stiff in them settles as fast as the rest.
    fn solve(&self, nodes: &[CollocationNode], length: f64) -> Option<Tried> {
        let (n, parameters) = self.positions.shape();
        let integrals = self.rule.integrals.transpose() * length;
        let sweep = self.rule.sweep.transpose() * length;
        let rest = &integrals - &sweep;
        let factors: Vec<_> =
            nodes.iter().enumerate().map(|(index, node)| node.factors(sweep[(index, index)])).collect();
        let mut rates = DMatrix::zeros(n * parameters, NODES);
        let mut accelerations = rates.clone();
        for _ in 0..SWEEPS {
            let mut known_rates = integrated(&self.rates, &accelerations, &rest);
            let mut known_positions = integrated(&self.positions, &rates, &rest);
            let mut moved: f64 = 0.0;
            for (index, (node, factors)) in nodes.iter().zip(&factors).enumerate() {
                let earlier = sweep.view((0, index), (index, 1));
                known_rates.column_mut(index).gemv(1.0, &accelerations.columns(0, index), &earlier.column(0), 1.0);
                known_positions.column_mut(index).gemv(1.0, &rates.columns(0, index), &earlier.column(0), 1.0);
                let at = |all: &DMatrix<f64>| DMatrix::from_column_slice(n, parameters, all.column(index).as_slice());
                let (known, entry) = (at(&known_rates), sweep[(index, index)]);
                let mut next = node.by_parameters.clone();
                next.gemm(1.0, &node.by_positions, &(at(&known_positions) + &known * entry), 1.0);
                next.gemm(1.0, &node.by_rates, &known, 1.0);
                if !factors.solve_mut(&mut next) {
                    return None;
                }
                moved = moved.max(self.share(&(&next - at(&accelerations)), &next, length));
                accelerations.column_mut(index).copy_from_slice(next.as_slice());
                rates.column_mut(index).copy_from_slice((known + next * entry).as_slice());
            }
            if !accelerations.iter().all(|value| value.is_finite()) {
                return None;
            }
            if moved <= SETTLED * NODES as f64 {
                let excess = self.excess(&accelerations, length);
                return Some(Tried {
                    rates: integrated(&self.rates, &accelerations, &integrals),
                    accelerations,
                    excess,
                });
            }
        }
        None
    }

    /// What a change of a_p would make of v_p in a step, as a share of what that reaches; the worst parameter.
    fn share(&self, change: &DMatrix<f64>, accelerations: &DMatrix<f64>, length: f64) -> f64 {
        let worst = |column: usize| {
            let size = |matrix: &DMatrix<f64>| matrix.column(column).amax();
            let moved = length * size(change);
            if moved == 0.0 { 0.0 } else { moved / self.reached[column].max(length * size(accelerations)) }
        };
        (0..self.parameters).map(worst).fold(0.0, f64::max)
    }

    /// The last coefficients of a_p against the tolerance, the worst parameter.
    fn excess(&self, accelerations: &DMatrix<f64>, length: f64) -> f64 {
        let n = self.positions.nrows();
        let last = accelerations * self.rule.tail().transpose();
        let worst = |column: usize| {
            let part = |all: &DMatrix<f64>| all.rows(column * n, n).into_owned();
            let error = length * part(&last).column_iter().map(|column| column.amax()).sum::<f64>();
            let scale = self.reached[column].max(length * part(accelerations).amax());
            error / (self.tolerance.max(SMALLEST) * scale)
        };
        (0..self.parameters).map(worst).fold(0.0, f64::max)
    }

    /// Takes a step: reports what is due in it, then moves on to its end and back onto the varied loops.
    pub(super) fn accept(
        &mut self,
        tried: &Tried,
        length: f64,
        due: &mut &[f64],
        report: &mut impl FnMut(At),
    ) -> Result<(), AnalysisFailure> {
        let begin = self.motion.time();
        let end = begin + length;
        let (n, parameters) = self.positions.shape();
        let state = |place: f64| {
            let shares = DMatrix::from_column_slice(NODES, 1, (self.rule.up_to(place) * length).as_slice());
            let moved = |from: &DMatrix<f64>, rates: &DMatrix<f64>| {
                DMatrix::from_column_slice(n, parameters, integrated(from, rates, &shares).as_slice())
            };
            (moved(&self.positions, &tried.rates), moved(&self.rates, &tried.accelerations))
        };
        let mut motion = self.motion.clone();
        let (now, later) = due.split_at(until(due, end));
        for &time in now {
            let (positions, rates) = state(((time - begin) / length).min(1.0));
            move_on(&mut motion, time)?;
            report(read(&mut self.variational, &mut motion, &self.outputs, [&positions, &rates], None)?);
        }
        *due = later;
        let (positions, rates) = state(1.0);
        let (_, numbers) = self.at(&mut motion, end)?;
        let (positions, rates) = self.projected((&numbers, end), positions, rates)?;
        let sides = sides(&numbers.values(RowBlock::Switches));
        let kept = self.sides.iter().zip(sides).map(|(old, new)| new.or(*old)).collect();
        (self.positions, self.rates, self.sides, self.motion) = (positions, rates, kept, motion);
        self.reach();
        Ok(())
    }

    /// The nearest derivatives that fulfil the varied loop equations and their rates.
    fn projected(
        &self,
        (numbers, end): (&Numbers, f64),
        mut positions: DMatrix<f64>,
        mut rates: DMatrix<f64>,
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), AnalysisFailure> {
        let jacobian = numbers.block(RowBlock::Loops, ColumnBlock::Positions);
        if jacobian.is_empty() {
            return Ok((positions, rates));
        }
        let parts = decompose::svd(jacobian.clone(), true, true)?;
        let by_signals = |row: RowBlock| self.by_parameters(&numbers.block(row, ColumnBlock::Signals), end);
        let nearest = |gap: DMatrix<f64>| parts.solve(&gap, f64::EPSILON * parts.singular_values.max());
        let gap = &jacobian * &positions + by_signals(RowBlock::Loops);
        positions -= nearest(gap).map_err(|_| AnalysisFailure::Range)?;
        let gap = &jacobian * &rates
            + numbers.block(RowBlock::Rates, ColumnBlock::Positions) * &positions
            + by_signals(RowBlock::Rates);
        rates -= nearest(gap).map_err(|_| AnalysisFailure::Range)?;
        Ok((positions, rates))
    }
}

/// What begins with `from` and changes at these rates, a column for each node; a column for each place that the integrals go to.
fn integrated(from: &DMatrix<f64>, rates: &DMatrix<f64>, integrals: &DMatrix<f64>) -> DMatrix<f64> {
    let mut all = rates * integrals;
    for mut column in all.column_iter_mut() {
        column.iter_mut().zip(from).for_each(|(place, value)| *place += value);
    }
    all
}
