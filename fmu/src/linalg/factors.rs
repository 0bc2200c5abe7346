//! L D L^T of the symmetric matrix [M J^T; J 0] of a large mechanism, once a step: cost follows the entries, not the square of the size.
//!
//! The pattern is that of the mechanism and stays. Equations with the fewest neighbours go first, a loop equation only
//! after all unknowns that it contains: by then its pivot is that of -J M^-1 J^T, so that no pivot vanishes but in singular poses.

use std::collections::BTreeSet;

use super::SINGULAR;
use super::lane::at_each;
use super::matrix::{Entries, Places, most};

/// The order of elimination and the entries that are not zero: columns of L, each from its diagonal down.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    /// Equation of each column.
    equations: Vec<usize>,
    /// Column of each equation.
    columns: Vec<usize>,
    /// First entry of each column, and the end.
    first: Vec<usize>,
    /// Column that each entry stands in the row of, ascending.
    rows: Vec<u32>,
    /// First of the products of each column, and the end.
    first_product: Vec<usize>,
    /// For each entry of a column and each one below it: the entry that their product is taken off.
    products: Vec<u32>,
    /// (row, column) of all entries, by columns.
    by_columns: Vec<[u32; 2]>,
    /// The same by rows, from the last one up, and which entry of the columns each is. No loop over a single row or column: its end cannot be
    /// foreseen by the processor.
    by_rows: Vec<[u32; 2]>,
    turned: Vec<u32>,
}

impl Pattern {
    /// For the places (row, column) of the entries, either triangle or both; equations from `unknowns` on are loop equations.
    pub fn new(size: usize, unknowns: usize, places: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut neighbours = vec![BTreeSet::new(); size];
        for (row, column) in places.filter(|(row, column)| row != column) {
            neighbours[row].insert(column);
            neighbours[column].insert(row);
        }
        let (equations, below) = eliminate(neighbours, unknowns);
        let mut columns = vec![0; size];
        equations.iter().enumerate().for_each(|(column, &equation)| columns[equation] = column);
        let (mut first, mut rows) = (vec![0], Vec::new());
        for equations in below {
            let mut entries: Vec<u32> = equations.iter().map(|&equation| columns[equation] as u32).collect();
            entries.sort_unstable();
            rows.extend(entries);
            first.push(rows.len());
        }
        let by_columns: Vec<[u32; 2]> = (0..size)
            .flat_map(|column| rows[first[column]..first[column + 1]].iter().map(move |&row| [row, column as u32]))
            .collect();
        let mut turned: Vec<u32> = (0..rows.len() as u32).collect();
        turned.sort_by_key(|&entry| std::cmp::Reverse(by_columns[entry as usize]));
        let by_rows: Vec<[u32; 2]> = turned.iter().map(|&entry| by_columns[entry as usize]).collect();
        let (first_product, products) = (vec![0], Vec::new());
        let mut pattern =
            Self { equations, columns, first, rows, first_product, products, by_columns, by_rows, turned };
        for column in 0..size {
            let entries = pattern.first[column]..pattern.first[column + 1];
            for upper in entries.clone() {
                let targets =
                    (upper + 1..entries.end).map(|lower| pattern.entry(pattern.rows[upper], pattern.rows[lower]));
                let targets: Vec<u32> = targets.map(|target| target as u32).collect();
                pattern.products.extend(targets);
            }
            pattern.first_product.push(pattern.products.len());
        }
        pattern
    }

    /// Multiplications of a factorisation, and of a solution.
    pub fn work(&self) -> [usize; 2] {
        [self.products.len() + 2 * self.rows.len(), 2 * self.rows.len() + self.equations.len()]
    }

    /// The entry below the diagonal of a column, in the row of a later one.
    fn entry(&self, column: u32, row: u32) -> usize {
        let (first, end) = (self.first[column as usize], self.first[column as usize + 1]);
        first + self.rows[first..end].partition_point(|entry| *entry < row)
    }

    /// Where an entry of the matrix is kept: diagonals first.
    fn place(&self, row: usize, column: usize) -> usize {
        let (a, b) = (self.columns[row], self.columns[column]);
        if a == b { a } else { self.equations.len() + self.entry(a.min(b) as u32, a.max(b) as u32) }
    }
}

/// The order of elimination, and for each equation those that it is coupled with when its turn comes.
fn eliminate(mut neighbours: Vec<BTreeSet<usize>>, unknowns: usize) -> (Vec<usize>, Vec<BTreeSet<usize>>) {
    let mut waits: Vec<usize> = (0..neighbours.len())
        .map(|index| if index < unknowns { 0 } else { neighbours[index].range(..unknowns).count() })
        .collect();
    // Among equals the one that waits for the fewest others before it, so that neighbours in time do not wait for each other.
    let mut height = vec![0; neighbours.len()];
    let key = |index: usize, neighbours: &[BTreeSet<usize>], height: &[usize]| {
        (neighbours[index].len(), height[index], index)
    };
    let ready = (0..neighbours.len()).filter(|&index| waits[index] == 0);
    let mut next: BTreeSet<(usize, usize, usize)> = ready.map(|index| key(index, &neighbours, &height)).collect();
    let original = neighbours.clone();
    let (mut order, mut below) = (Vec::with_capacity(neighbours.len()), Vec::with_capacity(neighbours.len()));
    while let Some((_, _, index)) = next.pop_first() {
        let coupled = std::mem::take(&mut neighbours[index]);
        for &other in &coupled {
            next.remove(&key(other, &neighbours, &height));
            height[other] = height[other].max(height[index] + 1);
            neighbours[other].remove(&index);
            neighbours[other].extend(coupled.iter().copied().filter(|fill| *fill != other));
        }
        if index < unknowns {
            original[index].range(unknowns..).for_each(|&row| waits[row] -= 1);
        }
        let ready = coupled.iter().filter(|&&other| waits[other] == 0);
        next.extend(ready.map(|&other| key(other, &neighbours, &height)));
        order.push(index);
        below.push(coupled);
    }
    (order, below)
}

/// The factors of one matrix.
#[derive(Clone, Debug)]
pub(crate) struct Factors {
    pattern: Pattern,
    /// Where each equation's part of a solution goes.
    targets: Vec<usize>,
    /// D, from the matrix; then 1 / D.
    diagonal: Vec<f64>,
    /// Entries of the matrix, then of L.
    entries: Vec<f64>,
    /// What each pivot is the difference of.
    sizes: Vec<f64>,
    /// Columns whose part of the inverse is needed.
    wanted: Vec<bool>,
    /// The inverse where the factors have entries.
    inverse_diagonal: Vec<f64>,
    inverse: Vec<f64>,
    /// L by rows, from the last one up.
    by_rows: Vec<f64>,
    solution: Vec<f64>,
}

impl Entries for Factors {
    #[inline(always)]
    fn add(&mut self, [place, _]: Places, value: f64) {
        match place.checked_sub(self.diagonal.len()) {
            None => self.diagonal[place] += value,
            Some(entry) => self.entries[entry] += value,
        }
    }
}

impl Factors {
    /// Storage; the inverse will be asked for the diagonal of the equations from `unknowns` on, solutions go to `targets`.
    pub fn new(pattern: Pattern, unknowns: usize, targets: Vec<usize>) -> Self {
        let size = targets.len();
        let mut wanted: Vec<bool> = pattern.equations.iter().map(|equation| *equation >= unknowns).collect();
        for column in 0..size {
            let below = &pattern.rows[pattern.first[column]..pattern.first[column + 1]];
            below.iter().for_each(|&row| wanted[row as usize] |= wanted[column]);
        }
        Self {
            targets,
            wanted,
            diagonal: vec![0.0; size],
            sizes: vec![0.0; size],
            inverse_diagonal: vec![0.0; size],
            entries: vec![0.0; pattern.rows.len()],
            inverse: vec![0.0; pattern.rows.len()],
            by_rows: vec![0.0; pattern.rows.len()],
            solution: vec![0.0; size],
            pattern,
        }
    }

    /// Where its entries are.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Where an entry of the matrix is kept, which is its mirror image too.
    pub fn places(&self, row: usize, column: usize) -> Places {
        [self.pattern.place(row, column); 2]
    }

    /// Zero.
    pub fn clear(&mut self) {
        self.diagonal.fill(0.0);
        self.entries.fill(0.0);
    }

    /// Replaces the matrix by its factors; has it some?
    #[inline(always)]
    pub fn factor(&mut self) -> bool {
        for (size, entry) in self.sizes.iter_mut().zip(&self.diagonal) {
            *size = entry.abs();
        }
        let Pattern { first, rows, first_product, products, .. } = &self.pattern;
        for column in 0..self.diagonal.len() {
            let pivot = self.diagonal[column];
            // Not a number is singular too.
            let regular = pivot.abs() > SINGULAR * self.sizes[column];
            if !regular {
                return false;
            }
            let inverse = 1.0 / pivot;
            self.diagonal[column] = inverse;
            let range = first[column]..first[column + 1];
            let (entries, others) = self.entries.split_at_mut(range.end);
            let (entries, rows) = (&mut entries[range.start..], &rows[range.clone()]);
            let mut targets = &products[first_product[column]..first_product[column + 1]];
            for upper in 0..entries.len() {
                let value = entries[upper];
                let factor = value * inverse;
                let product = value * factor;
                self.diagonal[rows[upper] as usize] -= product;
                self.sizes[rows[upper] as usize] += product.abs();
                let below = &entries[upper + 1..];
                let (now, later) = targets.split_at(below.len());
                for (target, entry) in now.iter().zip(below) {
                    others[*target as usize - range.end] -= *entry * factor;
                }
                targets = later;
                entries[upper] = factor;
            }
        }
        for (factor, &entry) in self.by_rows.iter_mut().zip(&self.pattern.turned) {
            *factor = self.entries[entry as usize];
        }
        self.invert();
        true
    }

    /// The inverse where the factors have entries, from the last column to the first (Takahashi, Fagan and Chin, 1973).
    #[inline(always)]
    fn invert(&mut self) {
        let Pattern { first, rows, first_product, products, .. } = &self.pattern;
        for column in (0..self.diagonal.len()).rev().filter(|&column| self.wanted[column]) {
            let range = first[column]..first[column + 1];
            let (entries, others) = self.inverse.split_at_mut(range.end);
            let (current, rows, factors) =
                (&mut entries[range.start..], &rows[range.clone()], &self.entries[range.clone()]);
            let mut sources = &products[first_product[column]..first_product[column + 1]];
            for ((entry, row), factor) in current.iter_mut().zip(rows).zip(factors) {
                *entry = -(*factor * self.inverse_diagonal[*row as usize]);
            }
            for upper in 0..current.len() {
                for lower in upper + 1..current.len() {
                    let entry = others[sources[lower - upper - 1] as usize - range.end];
                    current[lower] -= factors[upper] * entry;
                    current[upper] -= factors[lower] * entry;
                }
                sources = &sources[current.len() - upper - 1..];
            }
            let products = factors.iter().zip(&*current);
            self.inverse_diagonal[column] =
                products.fold(self.diagonal[column], |sum, (factor, entry)| sum - *factor * *entry);
        }
    }

    /// An entry of the diagonal of the inverse.
    pub fn diagonal(&self, equation: usize) -> f64 {
        self.inverse_diagonal[self.pattern.columns[equation]]
    }

    /// Solutions for several right-hand sides, by equations.
    #[inline(always)]
    pub fn solve_all<const D: usize>(&self, vectors: &[[f64; D]], solutions: &mut [[f64; D]]) {
        let Pattern { equations, by_columns, by_rows, columns, .. } = &self.pattern;
        solutions.copy_from_slice(vectors);
        for (&[row, column], factor) in by_columns.iter().zip(&self.entries) {
            let value = solutions[equations[column as usize]];
            at_each!(D, i => solutions[equations[row as usize]][i] -= factor * value[i]);
        }
        for (value, column) in solutions.iter_mut().zip(columns) {
            at_each!(D, i => value[i] *= self.diagonal[*column]);
        }
        for (&[row, column], factor) in by_rows.iter().zip(&self.by_rows) {
            let value = solutions[equations[row as usize]];
            at_each!(D, i => solutions[equations[column as usize]][i] -= factor * value[i]);
        }
    }

    /// How much larger than the pivot of an equation that is which it is the difference of.
    fn growth(&self, equation: usize) -> f64 {
        let column = self.pattern.columns[equation];
        self.sizes[column] * self.diagonal[column].abs()
    }

    /// The largest share of what the pivot of an equation before `unknowns` is the difference of in that pivot, and the equation.
    pub fn cancellation(&self, unknowns: usize) -> (f64, usize) {
        most((0..unknowns).map(|equation| self.growth(equation)))
    }

    /// The solution for right-hand sides by equations, at its places.
    #[inline(always)]
    pub fn solve(&mut self, vector: &[f64], solution: &mut [f64]) {
        let Pattern { equations, by_columns, by_rows, .. } = &self.pattern;
        let x = &mut self.solution[..];
        for (place, &equation) in x.iter_mut().zip(equations) {
            *place = vector[equation];
        }
        for (&[row, column], factor) in by_columns.iter().zip(&self.entries) {
            x[row as usize] -= *factor * x[column as usize];
        }
        for (value, inverse) in x.iter_mut().zip(&self.diagonal) {
            *value *= *inverse;
        }
        for (&[row, column], factor) in by_rows.iter().zip(&self.by_rows) {
            x[column as usize] -= *factor * x[row as usize];
        }
        for (value, &equation) in x.iter().zip(equations) {
            solution[self.targets[equation]] = *value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// A ladder: unknowns in a row, each coupled with the next, and a loop equation over three of them.
    fn ladder(unknowns: usize) -> (usize, Vec<(usize, usize, f64)>) {
        let mut entries = Vec::new();
        let mut equation = unknowns;
        for index in 0..unknowns {
            entries.push((index, index, 2.0 + (index as f64).sin()));
            if index + 1 < unknowns {
                entries.push((index, index + 1, 0.3 * (3.0 * index as f64).cos()));
            }
            if index % 2 == 0 && index + 2 < unknowns {
                let row = [1.0, (index as f64).cos(), -0.7];
                entries.extend((0..3).map(|offset| (equation, index + offset, row[offset])));
                equation += 1;
            }
        }
        (equation, entries)
    }

    fn dense(size: usize, entries: &[(usize, usize, f64)]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(size, size);
        for &(row, column, value) in entries {
            matrix[(row, column)] = value;
            matrix[(column, row)] = value;
        }
        matrix
    }

    fn factors(size: usize, unknowns: usize, entries: &[(usize, usize, f64)]) -> Factors {
        let pattern = Pattern::new(size, unknowns, entries.iter().map(|&(row, column, _)| (row, column)));
        let mut factors = Factors::new(pattern, unknowns, (0..size).collect());
        for &(row, column, value) in entries {
            factors.add(factors.places(row, column), value);
        }
        factors
    }

    #[test]
    fn factors_solve_and_know_the_inverse() {
        let unknowns = 17;
        let (size, entries) = ladder(unknowns);
        let matrix = dense(size, &entries);
        let mut factors = factors(size, unknowns, &entries);
        assert!(factors.factor());
        let expected = DVector::from_fn(size, |row, _| 1.0 / (1.0 + row as f64));
        let mut solution = vec![0.0; size];
        factors.solve((&matrix * &expected).as_slice(), &mut solution);
        assert!((DVector::from_vec(solution) - expected).amax() < 1e-13);
        let inverse = matrix.try_inverse().unwrap();
        for row in unknowns..size {
            assert!((factors.diagonal(row) - inverse[(row, row)]).abs() < 1e-13, "{row}");
        }
    }

    #[test]
    fn work_grows_with_the_entries_only() {
        let work = |unknowns: usize| {
            let (size, entries) = ladder(unknowns);
            let places = entries.iter().map(|&(row, column, _)| (row, column));
            Pattern::new(size, unknowns, places).work().map(|count| count as f64 / unknowns as f64)
        };
        let (few, many) = (work(100), work(3000));
        few.iter().zip(many).for_each(|(few, many)| assert!(many < 1.1 * few, "{few} {many}"));
    }

    #[test]
    fn loop_equations_that_depend_on_each_other_have_none() {
        let twice = [(0, 0, 1.0), (1, 1, 2.0), (2, 0, 1.0), (2, 1, 0.3), (3, 0, -2.0), (3, 1, -0.6)];
        assert!(!factors(4, 2, &twice).factor());
        assert!(!factors(1, 1, &[(0, 0, f64::NAN)]).factor());
    }
}
