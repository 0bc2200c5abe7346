//! Symbolic LDL^T of the equations of motion \[M J^T; J 0\], in an order that is safe for every pose.
//!
//! Safe pivots: (a) a coordinate that moves mass, at any time; (b) a multiplier, once all its coordinates are eliminated; (c) a light coordinate
//! together with a multiplier whose entry for it is a constant: the pair's determinant is minus the square of that constant,
//! whatever the pose and however small the mass. Among those the cheapest (least fill) goes first.

use std::collections::{BTreeMap, BTreeSet};

use crate::expr::{Arena, Expr};

/// Rows of a symmetric matrix, both triangles stored.
type Rows = Vec<BTreeMap<usize, Expr>>;

/// A factorised system of n coordinates and the active multipliers.
#[derive(Clone, Debug)]
pub struct Factor {
    steps: Vec<Step>,
    size: usize,
}

#[derive(Clone, Debug)]
enum Step {
    /// A pivot: its inverse, and (row, multiplier of the pivot's row).
    One { index: usize, inverse: Expr, below: Vec<(usize, Expr)> },
    /// A pair \[a b; b 0\] with constant b, and (row, multipliers of the pair's rows).
    Two { pair: [usize; 2], diagonal: Expr, inverse: Expr, below: Vec<(usize, [Expr; 2])> },
}

/// A coordinate that moves no mass, so that its acceleration is not determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Undetermined(pub usize);

/// The matrix to be eliminated.
#[derive(Clone, Debug)]
pub struct System<'a> {
    /// \[M\] by rows.
    pub mass: &'a [Vec<(usize, Expr)>],
    /// \[Phi_q\] by rows, active constraints only.
    pub jacobian: &'a [Vec<(usize, Expr)>],
    /// Which coordinates move so little mass that their pivot would be poor.
    pub light: &'a [bool],
}

impl Factor {
    /// Orders and factorises.
    ///
    /// # Errors
    /// A coordinate moves no mass and no constraint holds it.
    pub fn new(arena: &mut Arena, system: &System) -> Result<Factor, Undetermined> {
        let size = system.mass.len() + system.jacobian.len();
        let mut elimination = Elimination::new(system);
        let mut steps = Vec::with_capacity(size);
        while elimination.left > 0 {
            let step = match elimination.choose(arena) {
                Some(Pivot::One(index)) => elimination.eliminate_one(arena, index),
                Some(Pivot::Two(pair)) => elimination.eliminate_two(arena, pair),
                None => return Err(Undetermined(elimination.stuck())),
            };
            steps.push(step);
        }
        Ok(Factor { steps, size })
    }

    /// Solves for one right-hand side: first the coordinates' entries, then the multipliers'.
    pub fn solve(&self, arena: &mut Arena, right: &[Expr]) -> Vec<Expr> {
        let mut x = right.to_vec();
        x.resize(self.size, Expr::ZERO);
        for step in &self.steps {
            match step {
                Step::One { index, below, .. } => {
                    for (row, factor) in below {
                        x[*row] = minus_product(arena, x[*row], *factor, x[*index]);
                    }
                }
                Step::Two { pair: [i, k], below, .. } => {
                    for (row, [fi, fk]) in below {
                        let first = minus_product(arena, x[*row], *fi, x[*i]);
                        x[*row] = minus_product(arena, first, *fk, x[*k]);
                    }
                }
            }
        }
        for step in self.steps.iter().rev() {
            step.substitute_back(arena, &mut x);
        }
        x
    }
}

impl Step {
    fn substitute_back(&self, arena: &mut Arena, x: &mut [Expr]) {
        match self {
            Step::One { index, inverse, below } => {
                let mut value = arena.multiply(x[*index], *inverse);
                for (row, factor) in below {
                    value = minus_product(arena, value, *factor, x[*row]);
                }
                x[*index] = value;
            }
            Step::Two { pair: [i, k], diagonal, inverse, below } => {
                // [a b; b 0]^-1 (y_i, y_k) = (y_k / b, (y_i - a y_k / b) / b)
                let mut first = arena.multiply(x[*k], *inverse);
                let rest = minus_product(arena, x[*i], *diagonal, first);
                let mut second = arena.multiply(rest, *inverse);
                for (row, [fi, fk]) in below {
                    first = minus_product(arena, first, *fi, x[*row]);
                    second = minus_product(arena, second, *fk, x[*row]);
                }
                x[*i] = first;
                x[*k] = second;
            }
        }
    }
}

enum Pivot {
    One(usize),
    Two([usize; 2]),
}

struct Elimination<'a> {
    rows: Rows,
    gone: Vec<bool>,
    /// How many rows are not eliminated yet.
    left: usize,
    /// For each coordinate the multipliers that wait for it.
    waiting: Vec<Vec<usize>>,
    /// For each multiplier how many of its coordinates are left.
    awaited: Vec<usize>,
    /// Safe pivots, the cheapest first.
    safe: BTreeSet<(usize, usize)>,
    /// The cost under which a row is among the safe ones.
    costs: Vec<Option<usize>>,
    light: &'a [bool],
    coordinates: usize,
}

impl<'a> Elimination<'a> {
    fn new(system: &System<'a>) -> Self {
        let coordinates = system.mass.len();
        let size = coordinates + system.jacobian.len();
        let mut waiting = vec![Vec::new(); coordinates];
        for (index, row) in system.jacobian.iter().enumerate() {
            row.iter().for_each(|&(column, _)| waiting[column].push(coordinates + index));
        }
        let mut elimination = Elimination {
            rows: rows(system),
            gone: vec![false; size],
            left: size,
            waiting,
            awaited: system.jacobian.iter().map(Vec::len).collect(),
            safe: BTreeSet::new(),
            costs: vec![None; size],
            light: system.light,
            coordinates,
        };
        (0..size).for_each(|index| elimination.refresh(index));
        elimination
    }

    /// The cheapest safe pivot; if there is none, the least unsafe one.
    fn choose(&self, arena: &Arena) -> Option<Pivot> {
        if let Some(&(_, index)) = self.safe.first() {
            return Some(Pivot::One(index));
        }
        let left = || (0..self.rows.len()).filter(|&index| !self.gone[index]);
        let pairs = left().filter(|&index| self.is_light(index)).flat_map(|index| {
            let row = &self.rows[index];
            row.iter()
                .filter(|(other, entry)| self.is_fresh_multiplier(**other) && arena.as_constant(**entry).is_some())
                .map(move |(&other, _)| [index, other])
        });
        if let Some(pair) = pairs.min_by_key(|&[i, k]| (self.cost(i) + self.cost(k), i)) {
            return Some(Pivot::Two(pair));
        }
        left().filter(|&index| self.has_pivot(index)).min_by_key(|&i| (self.cost(i), i)).map(Pivot::One)
    }

    fn cost(&self, index: usize) -> usize {
        self.rows[index].len() * self.rows[index].len()
    }

    fn is_safe(&self, index: usize) -> bool {
        if index < self.coordinates {
            !self.light[index]
        } else {
            self.has_pivot(index) && self.awaited[index - self.coordinates] == 0
        }
    }

    /// Notes anew whether a row is a safe pivot, and at what cost.
    fn refresh(&mut self, index: usize) {
        if let Some(cost) = self.costs[index].take() {
            self.safe.remove(&(cost, index));
        }
        if !self.gone[index] && self.is_safe(index) {
            let cost = self.cost(index);
            self.costs[index] = Some(cost);
            self.safe.insert((cost, index));
        }
    }

    fn is_light(&self, index: usize) -> bool {
        index < self.coordinates && self.light[index]
    }

    /// A multiplier whose diagonal is still zero.
    fn is_fresh_multiplier(&self, index: usize) -> bool {
        index >= self.coordinates && !self.has_pivot(index)
    }

    fn has_pivot(&self, index: usize) -> bool {
        self.rows[index].contains_key(&index)
    }

    fn stuck(&self) -> usize {
        (0..self.coordinates).find(|&index| !self.gone[index]).unwrap_or_default()
    }

    fn eliminate_one(&mut self, arena: &mut Arena, index: usize) -> Step {
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
        Step::One { index, inverse, below }
    }

    fn eliminate_two(&mut self, arena: &mut Arena, [i, k]: [usize; 2]) -> Step {
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
            let rest = minus_product(arena, entry(&first), diagonal, of_first);
            below.insert(row, [of_first, arena.multiply(rest, inverse)]);
        }
        for (&row, &[of_first, of_second]) in &below {
            for (column, factor) in [(&first, of_first), (&second, of_second)] {
                for (&other, &entry) in column.range(row..) {
                    self.subtract(arena, [row, other], factor, entry);
                }
            }
        }
        below.keys().for_each(|&row| self.refresh(row));
        Step::Two { pair: [i, k], diagonal, inverse, below: below.into_iter().collect() }
    }

    /// Takes a row out of the matrix.
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
        let old = self.rows[row].get(&column).copied().unwrap_or(Expr::ZERO);
        let new = minus_product(arena, old, factor, entry);
        for [row, column] in [[row, column], [column, row]] {
            if new == Expr::ZERO {
                self.rows[row].remove(&column);
            } else {
                self.rows[row].insert(column, new);
            }
        }
    }
}

/// a - b c
fn minus_product(arena: &mut Arena, a: Expr, b: Expr, c: Expr) -> Expr {
    let product = arena.multiply(b, c);
    arena.subtract(a, product)
}

fn rows(system: &System) -> Rows {
    let coordinates = system.mass.len();
    let mut rows: Rows = system.mass.iter().map(|row| row.iter().copied().collect()).collect();
    for (index, constraint) in system.jacobian.iter().enumerate() {
        let mut row = BTreeMap::new();
        for &(column, entry) in constraint {
            row.insert(column, entry);
            rows[column].insert(coordinates + index, entry);
        }
        rows.push(row);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Solves a system of numbers and compares with what it was made from.
    fn check(mass: &[&[f64]], jacobian: &[&[f64]], light: &[bool]) {
        let mut arena = Arena::default();
        let mut sparse = |rows: &[&[f64]]| -> Vec<Vec<(usize, Expr)>> {
            rows.iter()
                .map(|row| {
                    row.iter().enumerate().filter(|(_, x)| **x != 0.0).map(|(i, &x)| (i, arena.constant(x))).collect()
                })
                .collect()
        };
        let (mass_rows, jacobian_rows) = (sparse(mass), sparse(jacobian));
        let system = System { mass: &mass_rows, jacobian: &jacobian_rows, light };
        let factor = Factor::new(&mut arena, &system).unwrap();
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
        check(
            &[&[4.0, 1.0, 0.0], &[1.0, 3.0, 0.5], &[0.0, 0.5, 2.0]],
            &[&[1.0, 2.0, 0.0], &[0.0, 1.0, -1.0]],
            &[false; 3],
        );
    }

    #[test]
    fn a_coordinate_without_mass_goes_with_its_multiplier() {
        check(&[&[4.0, 1.0, 0.0], &[1.0, 3.0, 0.0], &[0.0, 0.0, 0.0]], &[&[0.3, 0.2, 1.0]], &[false, false, true]);
    }

    #[test]
    fn a_coordinate_that_nothing_holds_is_reported() {
        let mut arena = Arena::default();
        let system = System { mass: &[vec![(0, Expr::ONE)], vec![]], jacobian: &[], light: &[false, true] };
        assert_eq!(Factor::new(&mut arena, &system).unwrap_err(), Undetermined(1));
    }
}
