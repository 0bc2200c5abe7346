//! The search for a pose in which nothing accelerates: Q(q, 0, z, t0) - Phi_q^T lambda = 0, Phi = 0, g = 0; and s = F + mu p(lambda) of what rubs with all that it can.
//!
//! Levenberg-Marquardt from the guess, with the exact Jacobian. Where it stagnates at no solution (a level pendulum has zero stiffness), the mechanism is
//! moved along its accelerations from rest for a while, and the search continues from there; if it converges to the same point again, the motion from the
//! guess is followed longer and longer.

use cotree::equations::MotionVariable;
use cotree::formulate::Formulated;
use cotree::report::data::shown;
use nalgebra::{DMatrix, DVector};

use super::decompose::{least_squares, svd};
use super::variation::{ColumnBlock, Numbers, RowBlock, Variation};
use super::{AnalysisFailure, OperatingPoint};

const ITERATIONS: usize = 100;
/// Longest change of a coordinate in one iteration, in units of its scale.
const REACH: f64 = 0.5;
/// Damping at the start, and at which the search counts as stagnant.
const DAMPING: [f64; 2] = [1e-3, 1e8];
/// A pose is an equilibrium when a change of this size, in units of the scales, could cancel the residual.
const BALANCED: f64 = 1e-9;
/// Rounding error relative to the largest entry.
const ROUNDING: f64 = 1e-14;
/// How often the mechanism is released, and for how many moves of which size.
const RELEASES: usize = 15;
const MOVES: usize = 5;
const MOVE: f64 = 0.1;
/// Accelerations below this are those of nothing [scales of the coordinates by s2]: where the loops are regular, the loads are balanced then.
const STILL: f64 = 5e-4;

/// Why a pose in which the loads balance is no rest.
pub(super) struct Misfit {
    pub why: String,
    /// True if it slides from where it was put, and everything else fits: other poses are of no use then.
    pub slides: bool,
}

/// Searches for an equilibrium from a resting point; `unfit` says why a pose in which the loads balance is none, for reasons of its own.
pub(super) fn search(
    formulated: &Formulated,
    variation: &Variation,
    guess: OperatingPoint,
    unfit: impl Fn(&OperatingPoint) -> Option<Misfit>,
) -> Result<OperatingPoint, AnalysisFailure> {
    let mut search = EquilibriumSearch::new(formulated, variation, guess)?;
    let mut released = search.point.clone();
    let (mut stuck, mut wrong) = (None, None);
    for _ in 0..RELEASES {
        search.descend()?;
        if search.is_balanced()? {
            match unfit(&search.point) {
                None => return Ok(search.point),
                Some(misfit) if misfit.slides => return Err(AnalysisFailure::Unfit { why: misfit.why }),
                Some(misfit) => wrong = Some(misfit.why),
            }
            // Nothing moves it away from there.
            break;
        }
        stuck.get_or_insert_with(|| search.point.clone());
        for _ in 0..MOVES {
            search.release()?;
        }
    }
    // The search converges to the same point again: the released motion is continued, and the search starts from its end.
    for _ in 0..RELEASES {
        search.point = released;
        for _ in 0..MOVES {
            search.release()?;
        }
        released = search.point.clone();
        search.descend()?;
        if search.is_balanced()? {
            match unfit(&search.point) {
                None => return Ok(search.point),
                Some(misfit) => wrong = wrong.or(Some(misfit.why)),
            }
        }
    }
    if let Some(why) = wrong {
        return Err(AnalysisFailure::Unfit { why });
    }
    let point = stuck.unwrap_or(search.point);
    Err(stuck_at(formulated, variation, &point)?)
}

/// Accelerations of a point when it is released from rest.
fn accelerations(numbers: &Numbers, point: &OperatingPoint) -> Result<DVector<f64>, AnalysisFailure> {
    let coordinates = point.positions().len();
    let rows = [RowBlock::Motion, RowBlock::Accelerations, RowBlock::Levels].map(|row| numbers.values(row));
    let right = DVector::from_vec(rows.iter().flatten().map(|value| -value).collect());
    // The solution holds changes of the reactions too. In a singular pose: the solution of least norm.
    Ok(least_squares(&numbers.system(), &right, 0.0)?.rows(0, coordinates).into_owned())
}

/// Why the search ends at a point that is no equilibrium: something accelerates there, or branches of the motion cross, where least-norm accelerations vanish though the loads
/// are not balanced.
fn stuck_at(
    formulated: &Formulated,
    variation: &Variation,
    point: &OperatingPoint,
) -> Result<AnalysisFailure, AnalysisFailure> {
    let equations = &formulated.equations;
    let numbers = variation.motion_at(equations, point)?;
    let accelerations = accelerations(&numbers, point)?;
    let scales = scales(formulated);
    let (units, layout) = (&equations.system.mechanism.units, equations.motion_layout());
    let told = |index: usize, value: f64, [angular, straight]: [&str; 2]| match layout.variable(index) {
        MotionVariable::State(state) => {
            let state = &equations.system.mechanism.states[state];
            format!("`{}` ({value} {})", state.name, state.unit.per_second().si)
        }
        MotionVariable::Coordinate(index) => {
            let coordinate = &equations.coordinates[index];
            let unit = shown(units, if coordinate.angular { angular } else { straight });
            format!("`{}` ({})", coordinate.name.position, unit.show(value))
        }
    };
    let mut order: Vec<usize> = (0..scales.len()).collect();
    let size = |index: &usize| (accelerations[*index] / scales[*index]).abs();
    order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let most = order.first().map_or(0.0, size);
    if most < STILL {
        let pose: Vec<String> = order
            .iter()
            .filter(|index| layout.coordinates().contains(index))
            .take(3)
            .map(|&index| told(index, point.positions()[index], ["rad", "m"]))
            .collect();
        return Ok(AnalysisFailure::Crossing { pose: pose.join(", ") });
    }
    let named = order.iter().take(3).filter(|index| size(index) > 1e-3 * most);
    let named: Vec<String> = named.map(|&index| told(index, accelerations[index], ["rad/s2", "m/s2"])).collect();
    Ok(AnalysisFailure::NoEquilibrium { accelerating: named.join(", ") })
}

pub(super) fn scales(formulated: &Formulated) -> Vec<f64> {
    formulated.lowered.program.coordinates.iter().map(|coordinate| coordinate.scale).collect()
}

/// Orthonormal basis of the null space of a matrix: its right singular vectors whose singular values are at most a share of the largest.
pub(super) fn null_space(rows: &DMatrix<f64>, share: f64) -> Result<DMatrix<f64>, AnalysisFailure> {
    let n = rows.ncols();
    if rows.is_empty() {
        return Ok(DMatrix::identity(n, n));
    }
    // The decomposition gives as many directions as there are rows: empty rows make it give all.
    let square = rows.clone().resize_vertically(rows.nrows().max(n), 0.0);
    let svd = svd(square, false, true)?;
    let least = share * svd.singular_values.max();
    let free: Vec<usize> = (0..n).filter(|&index| svd.singular_values[index] <= least).collect();
    Ok(svd.v_t.map_or_else(|| DMatrix::zeros(n, 0), |v_t| v_t.select_rows(&free).transpose()))
}

struct EquilibriumSearch<'a> {
    formulated: &'a Formulated,
    variation: &'a Variation,
    point: OperatingPoint,
    scales: Vec<f64>,
    /// The independent loop equations that hold: what is open stays so.
    rows: Vec<usize>,
    /// Their scales.
    gaps: Vec<f64>,
    /// The rows of the levels that act, and the scales of what they act along.
    levels: Vec<(usize, f64)>,
    /// Forces are measured in units of this energy [J] by the scales.
    energy: f64,
    /// The number of coordinates of the mechanism; those after them stand for states of the scene, whose rates are to vanish.
    mechanical: usize,
}

impl<'a> EquilibriumSearch<'a> {
    fn new(
        formulated: &'a Formulated,
        variation: &'a Variation,
        point: OperatingPoint,
    ) -> Result<Self, AnalysisFailure> {
        let constraints = &formulated.lowered.program.constraints;
        let rows = variation.rows_at(&formulated.equations, &point);
        let gaps = rows.iter().map(|&row| constraints[row].scale).collect();
        let levels = variation.levels_at(&formulated.equations, &point);
        let levels = levels.into_iter().map(|row| (row, constraints[row].scale)).collect();
        let (mechanical, scales) = (formulated.equations.coordinates.len(), scales(formulated));
        let mut search =
            EquilibriumSearch { formulated, variation, point, scales, rows, gaps, levels, energy: 1.0, mechanical };
        let numbers = variation.motion_at(&formulated.equations, &search.point)?;
        let (jacobian, residual) = (search.jacobian(&numbers), search.scaled(&numbers.values(RowBlock::Motion)));
        let n = search.mechanical;
        let largest = jacobian.view((0, 0), (n, n)).amax().max(residual.rows(0, n).amax());
        if largest > 0.0 {
            search.energy = largest;
        }
        search.carry(&numbers)?;
        Ok(search)
    }

    /// Q in units of energy, for unit changes of the coordinates; rates of states in units of these.
    fn scaled(&self, forces: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(forces.len(), |row, _| forces[row] * self.weight(row))
    }

    fn weight(&self, row: usize) -> f64 {
        if row < self.mechanical { self.scales[row] / self.energy } else { 1.0 / self.scales[row] }
    }

    /// The reactions that balance the loads best, by least squares.
    fn carry(&mut self, numbers: &Numbers) -> Result<(), AnalysisFailure> {
        let reactions = numbers.block(RowBlock::Motion, ColumnBlock::Reactions);
        let change = least_squares(&reactions, &-numbers.values(RowBlock::Motion), 0.0)?;
        self.change_reactions(change.as_slice());
        Ok(())
    }

    fn change_reactions(&mut self, change: &[f64]) {
        let reactions = self.point.reactions_mut();
        for (&row, change) in self.rows.iter().zip(change) {
            reactions[row] += change;
        }
    }

    /// Unbalanced loads and gaps in natural units.
    fn residual(&self, point: &OperatingPoint) -> DVector<f64> {
        let equations = &self.formulated.equations;
        let motion = self.scaled(&self.variation.values(equations, point, RowBlock::Motion));
        let loops = self.variation.values(equations, point, RowBlock::Loops);
        let loops = loops.iter().zip(&self.gaps).map(|(gap, scale)| gap / scale);
        let levels = self.variation.values(equations, point, RowBlock::Levels);
        let levels = levels.iter().zip(&self.levels).map(|(level, (_, scale))| level * scale / self.energy);
        DVector::from_vec(motion.iter().copied().chain(loops).chain(levels).collect())
    }

    /// Derivatives of the residual by coordinates, reactions and levels in natural units.
    fn jacobian(&self, numbers: &Numbers) -> DMatrix<f64> {
        let (n, m, l) = (self.scales.len(), self.gaps.len(), self.levels.len());
        let by_positions = |row: RowBlock| {
            let mut slopes = numbers.block(row, ColumnBlock::Positions);
            let rates = numbers.block(row, ColumnBlock::Rates);
            (self.mechanical..n).for_each(|state| slopes.set_column(state, &rates.column(state)));
            slopes
        };
        let mut whole = DMatrix::zeros(n + m + l, n + m + l);
        let mut put =
            |(row, column): (usize, usize), block: DMatrix<f64>, scaled: &dyn Fn(f64, usize, usize) -> f64| {
                let block = DMatrix::from_fn(block.nrows(), block.ncols(), |i, j| scaled(block[(i, j)], i, j));
                whole.view_mut((row, column), block.shape()).copy_from(&block);
            };
        let (scales, gaps) = (&self.scales, &self.gaps);
        put((0, 0), by_positions(RowBlock::Motion), &|value, i, j| value * self.weight(i) * scales[j]);
        // A row of the motion by an effort: forces and efforts share the energy.
        let by_effort = |i: usize| if i < self.mechanical { scales[i] } else { self.energy / scales[i] };
        let reactions = numbers.block(RowBlock::Motion, ColumnBlock::Reactions);
        put((0, n), reactions, &|value, i, j| value * by_effort(i) / gaps[j]);
        put((n, 0), numbers.block(RowBlock::Loops, ColumnBlock::Positions), &|value, i, j| value * scales[j] / gaps[i]);
        if l > 0 {
            let of = |column: ColumnBlock| numbers.block(RowBlock::Levels, column);
            let level = |i: usize| self.levels[i].1;
            let acting = numbers.block(RowBlock::Motion, ColumnBlock::Levels);
            put((0, n + m), acting, &|value, i, j| value * by_effort(i) / level(j));
            put((n + m, 0), by_positions(RowBlock::Levels), &|value, i, j| value * scales[j] * level(i) / self.energy);
            put((n + m, n), of(ColumnBlock::Reactions), &|value, i, j| value * level(i) / gaps[j]);
            put((n + m, n + m), of(ColumnBlock::Levels), &|value, i, j| value * level(i) / level(j));
        }
        whole
    }

    fn is_balanced(&self) -> Result<bool, AnalysisFailure> {
        let numbers = self.variation.motion_at(&self.formulated.equations, &self.point)?;
        let (residual, jacobian) = (self.residual(&self.point), self.jacobian(&numbers));
        let noise = ROUNDING * jacobian.amax().max(1.0);
        let balanced = |(r, row): (&f64, nalgebra::DVectorView<f64>)| r.abs() <= BALANCED * row.amax() + noise;
        Ok(residual.iter().zip(jacobian.transpose().column_iter()).all(balanced))
    }

    /// Levenberg-Marquardt down to rounding, or until it stagnates.
    fn descend(&mut self) -> Result<(), AnalysisFailure> {
        let mut damping = DAMPING[0];
        let mut residual = self.residual(&self.point);
        for _ in 0..ITERATIONS {
            let numbers = self.variation.motion_at(&self.formulated.equations, &self.point)?;
            let jacobian = self.jacobian(&numbers);
            loop {
                let next = self.moved(&least_squares(&jacobian, &-&residual, damping)?);
                let rest = self.residual(&next);
                // Written so that NaN is no progress.
                if rest.norm() < residual.norm() {
                    (self.point, residual) = (next, rest);
                    damping *= 0.05;
                    break;
                }
                damping = 10.0 * damping.max(1e-16);
                if damping > DAMPING[1] {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// The point after a step, which is shortened if a coordinate would move too far.
    fn moved(&self, step: &DVector<f64>) -> OperatingPoint {
        let n = self.scales.len();
        let longest = step.rows(0, n).amax();
        let share = if longest > REACH { REACH / longest } else { 1.0 };
        let mut next = self.point.clone();
        let mut changes = self.scales.iter().zip(step.iter()).map(|(scale, change)| share * change * scale);
        let mechanical_changes: Vec<f64> = changes.by_ref().take(self.mechanical).collect();
        next.positions_mut().iter_mut().zip(mechanical_changes).for_each(|(q, change)| *q += change);
        next.states_mut().iter_mut().zip(changes).for_each(|(z, change)| *z += change);
        let reactions = next.reactions_mut();
        let levels = self.levels.iter().map(|(row, scale)| (row, scale));
        for ((&row, scale), change) in self.rows.iter().zip(&self.gaps).chain(levels).zip(step.iter().skip(n)) {
            reactions[row] += share * change * self.energy / scale;
        }
        next
    }

    /// A short move in the direction of the accelerations, with the loops closed again.
    fn release(&mut self) -> Result<(), AnalysisFailure> {
        let equations = &self.formulated.equations;
        let accelerations = accelerations(&self.variation.motion_at(equations, &self.point)?, &self.point)?;
        let sizes = accelerations.iter().zip(&self.scales).map(|(acceleration, scale)| (acceleration / scale).abs());
        let largest = sizes.fold(0.0, f64::max);
        if largest > 0.0 {
            let moves = self.point.positions_mut().iter_mut().zip(&accelerations).take(self.mechanical);
            moves.for_each(|(q, acceleration)| *q += MOVE * acceleration / largest);
            let states = self.point.states_mut().iter_mut().zip(accelerations.iter().skip(self.mechanical));
            states.for_each(|(z, rate)| *z += MOVE * rate / largest);
        }
        for _ in 0..MOVES {
            let numbers = self.variation.motion_at(equations, &self.point)?;
            let step = least_squares(
                &numbers.block(RowBlock::Loops, ColumnBlock::Positions),
                &-numbers.values(RowBlock::Loops),
                0.0,
            )?;
            self.point.positions_mut().iter_mut().zip(&step).for_each(|(q, change)| *q += change);
        }
        let numbers = self.variation.motion_at(equations, &self.point)?;
        self.carry(&numbers)
    }
}
