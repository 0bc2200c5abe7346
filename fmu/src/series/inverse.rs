//! The inverse of the symmetric matrix [M J^T; J 0], once a step.

use super::lane::{Lane, WIDTH, ZERO, add, lanes, larger, largest, minus, multiply, plus, splat, subtract};
use super::matrix::{Entries, Places};

/// The smallest pivot that counts, relative to the largest entry of its row.
const SINGULAR: f64 = 1e-13;
/// An entry of the diagonal that is larger than this, in the same units, is the pivot without looking for a larger one.
const GOOD: f64 = 0.1;

/// A square matrix by rows, whose rows and columns may have their own places.
#[derive(Clone, Debug)]
pub(super) struct Inverse {
    /// Lanes of a row.
    width: usize,
    /// Place of each column in its row.
    places: Vec<usize>,
    rows: Vec<Lane>,
    /// For each column a row of ones with a zero at its place: no single number is written into a row that is read in lanes right after.
    others: Vec<Lane>,
    /// Row that was the pivot of each column.
    pivots: Vec<usize>,
    /// One over the largest entry that each row began with.
    scales: Vec<f64>,
}

impl Entries for Inverse {
    #[inline(always)]
    fn add(&mut self, [place, mirror]: Places, value: f64) {
        let flat = self.rows.as_flattened_mut();
        flat[place] += value;
        if place != mirror {
            flat[mirror] += value;
        }
    }
}

impl Inverse {
    /// For columns at these places of rows with room for so many.
    pub fn new(places: Vec<usize>, room: usize) -> Self {
        let (size, width) = (places.len(), lanes(room));
        let mut others = vec![splat(1.0); size * width];
        for (row, place) in others.chunks_exact_mut(width.max(1)).zip(&places) {
            row.as_flattened_mut()[*place] = 0.0;
        }
        Self { width, others, rows: vec![ZERO; size * width], pivots: vec![0; size], scales: vec![0.0; size], places }
    }

    /// Zero.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.rows.fill(ZERO);
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.places.len()
    }

    /// Where an entry and its mirror image are kept.
    pub fn places(&self, row: usize, column: usize) -> Places {
        let width = self.width * WIDTH;
        [row * width + self.places[column], column * width + self.places[row]]
    }

    /// An entry of the diagonal.
    pub fn diagonal(&self, row: usize) -> f64 {
        self.rows.as_flattened()[row * self.width * WIDTH + self.places[row]]
    }

    /// Row (and column) of the inverse, in lanes.
    #[cfg(test)]
    fn row(&self, row: usize) -> &[Lane] {
        &self.rows[row * self.width..][..self.width]
    }

    /// Its rows; none if they are not N lanes wide.
    #[inline(always)]
    pub fn rows<const N: usize>(&self) -> &[[Lane; N]] {
        if self.width == N { self.rows.as_chunks().0 } else { &[] }
    }

    /// The inverse times a vector by equations, in lanes.
    #[inline(always)]
    pub fn times(&self, vector: &[f64], product: &mut [Lane]) {
        for (lane, place) in product.iter_mut().enumerate() {
            let (mut even, mut odd) = (ZERO, ZERO);
            let mut rows = self.rows.chunks_exact(2 * self.width);
            let mut values = vector.chunks_exact(2);
            for (rows, values) in (&mut rows).zip(&mut values) {
                even = plus(even, rows[lane], splat(values[0]));
                odd = plus(odd, rows[self.width + lane], splat(values[1]));
            }
            if let (row @ [_, ..], [value]) = (rows.remainder(), values.remainder()) {
                even = plus(even, row[lane], splat(*value));
            }
            *place = add(even, odd);
        }
    }

    /// Replaces the matrix by its inverse, by Gauss and Jordan with row pivots. False if it has none.
    #[inline(always)]
    pub fn invert(&mut self) -> bool {
        // The same for every width; small ones are known to the compiler.
        match self.width {
            1 => self.eliminate_all(1),
            2 => self.eliminate_all(2),
            3 => self.eliminate_all(3),
            4 => self.eliminate_all(4),
            width => self.eliminate_all(width),
        }
    }

    #[inline(always)]
    fn eliminate_all(&mut self, width: usize) -> bool {
        for (row, scale) in self.rows.chunks_exact(width).zip(&mut self.scales) {
            *scale = 1.0 / largest(row.iter().fold(ZERO, |largest, entries| larger(largest, *entries)));
        }
        for column in 0..self.places.len() {
            let good = self.weight(column, column, width) > GOOD;
            let pivot = if good { column } else { self.heaviest(column, width) };
            // Written so that NaN is singular too.
            let regular = good || self.weight(pivot, column, width) > SINGULAR;
            if !regular {
                return false;
            }
            self.swap(column, pivot, width);
            self.pivots[column] = pivot;
            self.eliminate(column, width);
        }
        // Rows were swapped on the way in, so columns are on the way out.
        for column in (0..self.places.len()).rev() {
            let (a, b) = (self.places[column], self.places[self.pivots[column]]);
            if a != b {
                self.rows.as_flattened_mut().chunks_exact_mut(width * WIDTH).for_each(|row| row.swap(a, b));
            }
        }
        true
    }

    #[inline(always)]
    fn weight(&self, row: usize, column: usize, width: usize) -> f64 {
        self.rows.as_flattened()[row * width * WIDTH + self.places[column]].abs() * self.scales[row]
    }

    /// The row whose entry is the largest in relation to its others.
    #[inline(always)]
    fn heaviest(&self, column: usize, width: usize) -> usize {
        let (mut pivot, mut weight) = (column, self.weight(column, column, width));
        for row in column + 1..self.places.len() {
            let other = self.weight(row, column, width);
            if other > weight {
                (pivot, weight) = (row, other);
            }
        }
        pivot
    }

    #[inline(always)]
    fn swap(&mut self, a: usize, b: usize, width: usize) {
        if a != b {
            let (upper, lower) = self.rows.split_at_mut(b * width);
            upper[a * width..][..width].swap_with_slice(&mut lower[..width]);
            self.scales.swap(a, b);
        }
    }

    #[inline(always)]
    fn eliminate(&mut self, column: usize, width: usize) {
        let place = self.places[column];
        let (before, rest) = self.rows.split_at_mut(column * width);
        let (pivot, after) = rest.split_at_mut(width);
        let others = &self.others[column * width..][..width];
        let inverse = splat(1.0 / pivot.as_flattened()[place]);
        for (entries, others) in pivot.iter_mut().zip(others) {
            *entries = multiply(plus(subtract(splat(1.0), *others), *entries, *others), inverse);
        }
        for row in before.chunks_exact_mut(width).chain(after.chunks_exact_mut(width)) {
            let factor = row.as_flattened()[place];
            if factor == 0.0 {
                continue;
            }
            for ((entries, above), others) in row.iter_mut().zip(&*pivot).zip(others) {
                *entries = minus(multiply(*entries, *others), splat(factor), *above);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saddle_point_matrix_has_its_inverse() {
        // Two masses, one of them zero, held together: zero pivots on the diagonal.
        let entries = [(0, 0, 2.0), (0, 2, 1.0), (1, 2, -1.0), (1, 3, 1.0), (0, 3, 0.5)];
        let places = [0, 1, 4, 5];
        let mut matrix = Inverse::new(places.to_vec(), 8);
        let mut dense = [[0.0; 4]; 4];
        for (row, column, value) in entries {
            matrix.add(matrix.places(row, column), value);
            dense[row][column] = value;
            dense[column][row] = value;
        }
        assert!(matrix.invert());
        for (row, values) in dense.iter().enumerate() {
            for (column, place) in places.iter().enumerate() {
                let entry: f64 = (0..4).map(|k| values[k] * matrix.row(k).as_flattened()[*place]).sum();
                assert!((entry - f64::from(u8::from(row == column))).abs() < 1e-14, "{row} {column}: {entry}");
            }
        }
    }

    #[test]
    fn a_singular_matrix_has_none() {
        let mut matrix = Inverse::new(vec![0, 1], 4);
        for (row, column) in [(0, 0), (0, 1), (1, 1)] {
            matrix.add(matrix.places(row, column), 1.0);
        }
        assert!(!matrix.invert());
    }
}
