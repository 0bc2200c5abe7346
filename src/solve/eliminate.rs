//! Symbolic LDL^T of the equations of motion \[M J^T; J 0\], in an order that is safe for every pose.
//!
//! First, each light coordinate forms a 2 x 2 pivot with a multiplier whose entry for it is a constant, if there is one: the determinant is minus the
//! square of that constant, in every pose and for any mass. Then loop equations are added to the mass matrix until it is positive
//! definite ([`super::augment`]). After that every pivot is safe that is (a) a coordinate, or (b) a multiplier whose coordinates have all been eliminated. Among
//! those the cheapest (least fill) goes first.

use std::collections::{BTreeMap, BTreeSet};

use super::augment::{LIGHT, SparseRow, additions};
use crate::expr::{Arena, Expr, Symbol, Unary};

/// Rows of a symmetric matrix, both triangles stored.
type Rows = Vec<BTreeMap<usize, Expr>>;

/// A factorised system of n coordinates and the active multipliers.
#[derive(Clone, Debug)]
pub struct Factorisation {
    steps: Vec<PivotStep>,
    size: usize,
    /// For each multiplier what its pivot is the sum of: products, with the entry that it began with.
    shares: Vec<Vec<[Expr; 2]>>,
}

#[derive(Clone, Debug)]
enum PivotStep {
    /// A pivot: its inverse, and (row, multiplier of the pivot's row).
    One { index: usize, inverse: Expr, below: Vec<(usize, Expr)> },
    /// A pair \[a b; b 0\] with constant b, and (row, multipliers of the pair's rows).
    Two { pair: [usize; 2], diagonal: Expr, inverse: Expr, below: Vec<(usize, [Expr; 2])> },
    /// A loop equation is added with a weight to rows of coordinates: (row, minus the factor).
    Add { index: usize, weight: f64, to: Vec<(usize, Expr)> },
}

/// A coordinate that moves no mass and is not constrained, so that its acceleration is not determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undetermined(pub usize);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    Undetermined(usize),
    TooLarge,
}

impl From<Undetermined> for Obstacle {
    fn from(Undetermined(index): Undetermined) -> Self {
        Obstacle::Undetermined(index)
    }
}

/// Most operations of an elimination: their instructions take half a gigabyte.
const OPERATIONS: usize = 5_000_000;

#[derive(Clone, Copy)]
pub struct EliminationSystem<'a> {
    /// \[M\] by rows.
    pub mass: &'a [Vec<(usize, Expr)>],
    /// \[Phi_q\] by rows, active constraints only.
    pub jacobian: &'a [Vec<(usize, Expr)>],
    /// What stands on the diagonal of each multiplier: zero, or minus one while a loop equation is open.
    pub diagonal: &'a [Expr],
    /// Natural sizes of the coordinates: a mass and an inertia compare by the energy of a motion of this size.
    pub scales: &'a [f64],
    /// Values of all symbols in a typical pose, by which pivots are judged.
    pub values: &'a dyn Fn(Symbol) -> f64,
}

impl Factorisation {
    /// Orders and factorises.
    ///
    /// # Errors
    /// A coordinate moves no mass and is not constrained, or the elimination takes too many operations.
    pub fn new(arena: &mut Arena, system: &EliminationSystem) -> Result<Factorisation, Obstacle> {
        let coordinates = system.mass.len();
        let size = coordinates + system.jacobian.len();
        let mut elimination = Elimination::new(system);
        elimination.eliminate_pairs(arena, system);
        elimination.augment(arena, system)?;
        elimination.find_safe();
        while elimination.left > 0 {
            let index = elimination.choose().ok_or_else(|| Undetermined(elimination.stuck()))?;
            elimination.eliminate_one(arena, index);
            if elimination.operations > OPERATIONS {
                return Err(Obstacle::TooLarge);
            }
        }
        Ok(Factorisation { steps: elimination.steps, size, shares: elimination.shares })
    }

    /// Solves for one right-hand side: first the coordinates' entries, then the multipliers'.
    pub fn solve(&self, arena: &mut Arena, right: &[Expr]) -> Vec<Expr> {
        let mut x = right.to_vec();
        x.resize(self.size, Expr::ZERO);
        for step in &self.steps {
            match step {
                PivotStep::One { index, below, .. } | PivotStep::Add { index, to: below, .. } => {
                    for (row, factor) in below {
                        x[*row] = arena.subtract_product(x[*row], *factor, x[*index]);
                    }
                }
                PivotStep::Two { pair: [i, k], below, .. } => {
                    for (row, [fi, fk]) in below {
                        let first = arena.subtract_product(x[*row], *fi, x[*i]);
                        x[*row] = arena.subtract_product(first, *fk, x[*k]);
                    }
                }
            }
        }
        for step in self.steps.iter().rev() {
            step.substitute_back(arena, &mut x);
        }
        x
    }

    /// The multipliers with a pivot of their own and its inverse, in the order of elimination. Constant ones are left out.
    fn varying_pivots(&self, arena: &Arena, coordinates: usize) -> Vec<(usize, Expr)> {
        let varies = |step: &PivotStep| match step {
            PivotStep::One { index, inverse, .. } => {
                (*index >= coordinates && arena.as_constant(*inverse).is_none()).then_some((*index, *inverse))
            }
            PivotStep::Two { .. } | PivotStep::Add { .. } => None,
        };
        self.steps.iter().filter_map(varies).collect()
    }

    /// For each multiplier with a pivot of its own minus one over the square of how far its loop equation is from those that were eliminated
    /// before, in the measure of the mass. Constant ones are left out.
    pub fn reciprocal_pivots(&self, arena: &mut Arena, coordinates: usize) -> Vec<Expr> {
        let mut weights = BTreeMap::new();
        for step in &self.steps {
            if let PivotStep::Add { index, weight, .. } = step {
                *weights.entry(*index).or_insert(0.0) += weight;
            }
        }
        let pivots = self.varying_pivots(arena, coordinates);
        let of = |(index, inverse)| {
            // An equation that was added makes its own pivot smaller: 1 / (1 / d + weight) instead of d.
            let weight = arena.constant(weights.get(&index).copied().unwrap_or_default());
            arena.add(inverse, weight)
        };
        pivots.into_iter().map(of).collect()
    }

    /// For each of the reciprocal pivots the size of its row before elimination: the sum of the sizes of what the pivot is the sum of, beside which a pivot is zero or not, whatever the units. Zeros
    /// that are left of a sum are rounding errors of this size.
    pub fn row_sizes(&self, arena: &mut Arena, coordinates: usize) -> Vec<Expr> {
        let pivots = self.varying_pivots(arena, coordinates);
        let size = |(index, _): (usize, Expr)| {
            let mut sum = Expr::ZERO;
            for &[factor, entry] in &self.shares[index - coordinates] {
                let product = arena.multiply(factor, entry);
                let share = arena.unary(Unary::Abs, product);
                sum = arena.add(sum, share);
            }
            sum
        };
        pivots.into_iter().map(size).collect()
    }
}

impl PivotStep {
    fn substitute_back(&self, arena: &mut Arena, x: &mut [Expr]) {
        match self {
            PivotStep::One { index, inverse, below } => {
                let mut value = arena.multiply(x[*index], *inverse);
                for (row, factor) in below {
                    value = arena.subtract_product(value, *factor, x[*row]);
                }
                x[*index] = value;
            }
            PivotStep::Two { pair: [i, k], diagonal, inverse, below } => {
                // [a b; b 0]^-1 (y_i, y_k) = (y_k / b, (y_i - a y_k / b) / b)
                let mut first = arena.multiply(x[*k], *inverse);
                let rest = arena.subtract_product(x[*i], *diagonal, first);
                let mut second = arena.multiply(rest, *inverse);
                for (row, [fi, fk]) in below {
                    first = arena.subtract_product(first, *fi, x[*row]);
                    second = arena.subtract_product(second, *fk, x[*row]);
                }
                x[*i] = first;
                x[*k] = second;
            }
            // The added equation is satisfied: the solution is that without it.
            PivotStep::Add { .. } => {}
        }
    }
}

struct Elimination {
    rows: Rows,
    coordinates: usize,
    gone: Vec<bool>,
    /// How many rows are not eliminated yet.
    left: usize,
    /// For each coordinate the multipliers that wait for it.
    waiting: Vec<Vec<usize>>,
    /// For each multiplier how many of its coordinates are left.
    awaited: Vec<usize>,
    safe: BTreeSet<(usize, usize)>,
    /// The cost under which a row is among the safe ones.
    costs: Vec<Option<usize>>,
    steps: Vec<PivotStep>,
    shares: Vec<Vec<[Expr; 2]>>,
    operations: usize,
}

impl Elimination {
    fn new(system: &EliminationSystem) -> Self {
        let coordinates = system.mass.len();
        let size = coordinates + system.jacobian.len();
        Elimination {
            rows: rows(system),
            coordinates,
            gone: vec![false; size],
            left: size,
            waiting: vec![Vec::new(); coordinates],
            awaited: vec![0; system.jacobian.len()],
            safe: BTreeSet::new(),
            costs: vec![None; size],
            steps: Vec::new(),
            shares: first_shares(system),
            operations: 0,
        }
    }

    /// Light coordinates whose multiplier has a constant entry for them.
    fn eliminate_pairs(&mut self, arena: &mut Arena, system: &EliminationSystem) {
        let diagonal: Vec<Expr> = (0..self.coordinates).map(|i| self.entry(i, i)).collect();
        let mut weights = arena.evaluate(&diagonal, &system.values);
        weights.iter_mut().zip(system.scales).for_each(|(weight, scale)| *weight *= scale * scale);
        let heaviest = weights.iter().copied().fold(0.0, f64::max);
        let light: Vec<usize> = (0..self.coordinates).filter(|&i| weights[i] <= LIGHT * heaviest).collect();
        loop {
            let cost = |index: usize| self.rows[index].len() * self.rows[index].len();
            let left = light.iter().filter(|&&index| !self.gone[index]);
            let pairs = left.flat_map(|&index| {
                let constant = |entry: Expr| arena.as_constant(entry).is_some_and(|value| value != 0.0);
                let row = self.rows[index].range(self.coordinates..);
                row.filter(move |(_, entry)| constant(**entry)).map(move |(&other, _)| [index, other])
            });
            let Some(pair) = pairs.min_by_key(|&[i, k]| (cost(i) + cost(k), i)) else { return };
            self.eliminate_two(arena, pair);
        }
    }

    /// Adds loop equations until the mass matrix is positive definite.
    fn augment(&mut self, arena: &mut Arena, system: &EliminationSystem) -> Result<(), Undetermined> {
        let mut places: Vec<(usize, usize)> = Vec::new();
        for index in (0..self.rows.len()).filter(|&index| !self.gone[index]) {
            places.extend(self.rows[index].range(..self.coordinates).map(|(&column, _)| (index, column)));
        }
        let entries: Vec<Expr> = places.iter().map(|&(row, column)| self.entry(row, column)).collect();
        let mut mass = vec![SparseRow::new(); self.coordinates];
        let mut loops: BTreeMap<usize, SparseRow> = BTreeMap::new();
        for index in (0..self.coordinates).filter(|&index| !self.gone[index]) {
            mass[index].insert(index, 0.0);
        }
        for ((row, column), value) in places.into_iter().zip(arena.evaluate(&entries, &system.values)) {
            let value = value * system.scales[column];
            if row < self.coordinates {
                mass[row].insert(column, value * system.scales[row]);
            } else if !self.has_pivot(row) {
                // What may be open must not carry a mass.
                loops.entry(row).or_default().insert(column, value);
            }
        }
        for (index, weight) in additions(mass, &loops)? {
            self.add(arena, index, weight);
        }
        Ok(())
    }

    /// From here on a multiplier waits for the coordinates that it now constrains.
    fn find_safe(&mut self) {
        for multiplier in self.coordinates..self.rows.len() {
            for &column in self.rows[multiplier].range(..self.coordinates).map(|(column, _)| column) {
                self.waiting[column].push(multiplier);
                self.awaited[multiplier - self.coordinates] += 1;
            }
        }
        (0..self.rows.len()).for_each(|index| self.refresh(index));
    }

    /// M + w J_k^T J_k
    fn add(&mut self, arena: &mut Arena, index: usize, weight: f64) {
        let row: Vec<(usize, Expr)> = self.rows[index].range(..self.coordinates).map(|(&c, &e)| (c, e)).collect();
        let minus_weight = arena.constant(-weight);
        let to: Vec<(usize, Expr)> = row.iter().map(|&(c, e)| (c, arena.multiply(minus_weight, e))).collect();
        for (place, &(column, factor)) in to.iter().enumerate() {
            for &(other, entry) in &row[place..] {
                self.subtract(arena, [column, other], factor, entry);
            }
        }
        self.steps.push(PivotStep::Add { index, weight, to });
    }

    fn choose(&self) -> Option<usize> {
        self.safe.first().map(|&(_, index)| index)
    }

    fn is_safe(&self, index: usize) -> bool {
        self.has_pivot(index) && (index < self.coordinates || self.awaited[index - self.coordinates] == 0)
    }

    /// Updates whether a row is a safe pivot, and its cost.
    fn refresh(&mut self, index: usize) {
        if let Some(cost) = self.costs[index].take() {
            self.safe.remove(&(cost, index));
        }
        if !self.gone[index] && self.is_safe(index) {
            let cost = self.rows[index].len() * self.rows[index].len();
            self.costs[index] = Some(cost);
            self.safe.insert((cost, index));
        }
    }

    fn entry(&self, row: usize, column: usize) -> Expr {
        self.rows[row].get(&column).copied().unwrap_or(Expr::ZERO)
    }

    fn has_pivot(&self, index: usize) -> bool {
        self.rows[index].contains_key(&index)
    }

    fn stuck(&self) -> usize {
        (0..self.coordinates).find(|&index| !self.gone[index]).unwrap_or_default()
    }

    fn eliminate_one(&mut self, arena: &mut Arena, index: usize) {
        let mut column = self.take(index);
        let pivot = column.remove(&index).unwrap_or(Expr::ZERO);
        let inverse = arena.divide(Expr::ONE, pivot);
        let below: Vec<(usize, Expr)> =
            column.iter().map(|(&row, &entry)| (row, arena.multiply(entry, inverse))).collect();
        for &(row, factor) in &below {
            for (&other, &entry) in column.range(row..) {
                self.subtract(arena, [row, other], factor, entry);
            }
        }
        below.iter().for_each(|&(row, _)| self.refresh(row));
        self.steps.push(PivotStep::One { index, inverse, below });
    }

    fn eliminate_two(&mut self, arena: &mut Arena, [i, k]: [usize; 2]) {
        let (mut first, mut second) = (self.take(i), self.take(k));
        let diagonal = first.remove(&i).unwrap_or(Expr::ZERO);
        let coupling = first.remove(&k).unwrap_or(Expr::ZERO);
        second.remove(&i);
        let inverse = arena.divide(Expr::ONE, coupling);
        let rows: Vec<usize> = first.keys().chain(second.keys()).copied().collect();
        let mut below: BTreeMap<usize, [Expr; 2]> = BTreeMap::new();
        for row in rows {
            let entry = |column: &BTreeMap<usize, Expr>| column.get(&row).copied().unwrap_or(Expr::ZERO);
            let of_first = arena.multiply(entry(&second), inverse);
            let rest = arena.subtract_product(entry(&first), diagonal, of_first);
            below.insert(row, [of_first, arena.multiply(rest, inverse)]);
        }
        for (&row, &[of_first, of_second]) in &below {
            for (column, factor) in [(&first, of_first), (&second, of_second)] {
                for (&other, &entry) in column.range(row..) {
                    self.subtract(arena, [row, other], factor, entry);
                }
            }
        }
        self.steps.push(PivotStep::Two { pair: [i, k], diagonal, inverse, below: below.into_iter().collect() });
    }

    fn take(&mut self, index: usize) -> BTreeMap<usize, Expr> {
        let row = std::mem::take(&mut self.rows[index]);
        for other in row.keys().filter(|&&other| other != index) {
            self.rows[*other].remove(&index);
        }
        self.gone[index] = true;
        self.left -= 1;
        self.refresh(index);
        if index < self.coordinates {
            for multiplier in std::mem::take(&mut self.waiting[index]) {
                self.awaited[multiplier - self.coordinates] -= 1;
                self.refresh(multiplier);
            }
        }
        row
    }

    fn subtract(&mut self, arena: &mut Arena, [row, column]: [usize; 2], factor: Expr, entry: Expr) {
        self.operations += 1;
        if row == column && row >= self.coordinates {
            self.shares[row - self.coordinates].push([factor, entry]);
        }
        let old = self.rows[row].get(&column).copied().unwrap_or(Expr::ZERO);
        let new = arena.subtract_product(old, factor, entry);
        for [row, column] in [[row, column], [column, row]] {
            if new == Expr::ZERO {
                self.rows[row].remove(&column);
            } else {
                self.rows[row].insert(column, new);
            }
        }
    }
}

/// What stands on the diagonal of each multiplier before anything is eliminated.
fn first_shares(system: &EliminationSystem) -> Vec<Vec<[Expr; 2]>> {
    let diagonal = |index: usize| system.diagonal.get(index).copied().unwrap_or(Expr::ZERO);
    (0..system.jacobian.len()).map(|index| vec![[diagonal(index), Expr::ONE]]).collect()
}

fn rows(system: &EliminationSystem) -> Rows {
    let coordinates = system.mass.len();
    let mut rows: Rows = system.mass.iter().map(|row| row.iter().copied().collect()).collect();
    for (index, constraint) in system.jacobian.iter().enumerate() {
        let mut row = BTreeMap::new();
        for &(column, entry) in constraint {
            row.insert(column, entry);
            rows[column].insert(coordinates + index, entry);
        }
        if let Some(&diagonal) = system.diagonal.get(index).filter(|diagonal| **diagonal != Expr::ZERO) {
            row.insert(coordinates + index, diagonal);
        }
        rows.push(row);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Solves a numeric system with a known solution.
    fn check(mass: &[&[f64]], jacobian: &[&[f64]]) {
        let mut arena = Arena::default();
        let mut sparse = |rows: &[&[f64]]| -> Vec<Vec<(usize, Expr)>> {
            rows.iter()
                .map(|row| {
                    row.iter().enumerate().filter(|(_, x)| **x != 0.0).map(|(i, &x)| (i, arena.constant(x))).collect()
                })
                .collect()
        };
        let (mass_rows, jacobian_rows) = (sparse(mass), sparse(jacobian));
        let system = EliminationSystem {
            mass: &mass_rows,
            jacobian: &jacobian_rows,
            diagonal: &[],
            scales: &vec![1.0; mass.len()],
            values: &|_| 0.0,
        };
        let factor = Factorisation::new(&mut arena, &system).unwrap();
        let (n, m) = (mass.len(), jacobian.len());
        let solution: Vec<f64> = (0..n + m).map(|i| 1.0 + i as f64 * 0.7).collect();
        let right: Vec<Expr> = (0..n + m)
            .map(|i| {
                let row: f64 = if i < n {
                    (0..n).map(|j| mass[i][j] * solution[j]).sum::<f64>()
                        + (0..m).map(|k| jacobian[k][i] * solution[n + k]).sum::<f64>()
                } else {
                    (0..n).map(|j| jacobian[i - n][j] * solution[j]).sum()
                };
                arena.constant(row)
            })
            .collect();
        for (x, expected) in factor.solve(&mut arena, &right).into_iter().zip(&solution) {
            assert!((arena.as_constant(x).unwrap() - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn coordinates_before_their_multipliers() {
        check(&[&[4.0, 1.0, 0.0], &[1.0, 3.0, 0.5], &[0.0, 0.5, 2.0]], &[&[1.0, 2.0, 0.0], &[0.0, 1.0, -1.0]]);
    }

    #[test]
    fn a_coordinate_without_mass_goes_with_its_multiplier() {
        check(&[&[4.0, 1.0, 0.0], &[1.0, 3.0, 0.0], &[0.0, 0.0, 0.0]], &[&[0.3, 0.2, 1.0]]);
    }

    #[test]
    fn coordinates_that_move_the_same_mass_need_their_loop_equation() {
        check(&[&[4.0, 4.0, 0.0], &[4.0, 4.0, 0.0], &[0.0, 0.0, 1.0]], &[&[0.3, 0.2, 1.0]]);
    }

    #[test]
    fn a_coordinate_that_nothing_holds_is_reported() {
        let mut arena = Arena::default();
        let system = EliminationSystem {
            mass: &[vec![(0, Expr::ONE)], vec![]],
            jacobian: &[],
            diagonal: &[],
            scales: &[1.0; 2],
            values: &|_| 0.0,
        };
        assert_eq!(Factorisation::new(&mut arena, &system).unwrap_err(), Obstacle::Undetermined(1));
    }
}
