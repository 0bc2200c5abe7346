//! The inverse of the symmetric matrix [M J^T; J 0], once a step.

use super::lane::{Lane, WIDTH, ZERO, add, lanes, minus, multiply, plus, splat};

/// The smallest pivot that counts, relative to the largest entry of its row.
const SINGULAR: f64 = 1e-13;

/// A square matrix by rows, whose rows and columns may have their own places.
#[derive(Clone, Debug)]
pub(super) struct Inverse {
    /// Lanes of a row.
    width: usize,
    /// Place of each column in its row.
    places: Vec<usize>,
    rows: Vec<Lane>,
    /// Row that was the pivot of each column.
    pivots: Vec<usize>,
    largest: Vec<f64>,
}

impl Inverse {
    /// For columns at these places of rows with room for so many.
    pub fn new(places: Vec<usize>, room: usize) -> Self {
        let (size, width) = (places.len(), lanes(room));
        Self { width, places, rows: vec![ZERO; size * width], pivots: vec![0; size], largest: vec![0.0; size] }
    }

    /// Zero.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.rows.fill(ZERO);
    }

    /// Adds to an entry and its mirror image.
    #[inline(always)]
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        let (width, [at_row, at_column]) = (self.width * WIDTH, [row, column].map(|index| self.places[index]));
        let flat = self.rows.as_flattened_mut();
        flat[row * width + at_column] += value;
        if row != column {
            flat[column * width + at_row] += value;
        }
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
        match self.width {
            1 => self.invert_rows::<1>(),
            2 => self.invert_rows::<2>(),
            3 => self.invert_rows::<3>(),
            4 => self.invert_rows::<4>(),
            _ => self.invert_any(),
        }
    }

    #[inline(always)]
    fn invert_rows<const N: usize>(&mut self) -> bool {
        let (rows, _) = self.rows.as_chunks_mut::<N>();
        Elimination { rows, places: &self.places, pivots: &mut self.pivots, largest: &mut self.largest }.run()
    }

    #[inline(always)]
    fn invert_any(&mut self) -> bool {
        let mut rows: Vec<&mut [Lane]> = self.rows.chunks_exact_mut(self.width).collect();
        Elimination { rows: &mut rows, places: &self.places, pivots: &mut self.pivots, largest: &mut self.largest }
            .run()
    }
}

/// A matrix on its way to its inverse.
struct Elimination<'a, R> {
    rows: &'a mut [R],
    places: &'a [usize],
    pivots: &'a mut [usize],
    largest: &'a mut [f64],
}

impl<R: AsRef<[Lane]> + AsMut<[Lane]>> Elimination<'_, R> {
    #[inline(always)]
    fn run(&mut self) -> bool {
        for (row, largest) in self.rows.iter().zip(&mut *self.largest) {
            let entries = row.as_ref().as_flattened();
            *largest = entries.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
        }
        for column in 0..self.places.len() {
            let pivot = self.heaviest(column);
            // Written so that NaN is singular too.
            let regular = self.weight(pivot, column) > SINGULAR;
            if !regular {
                return false;
            }
            self.swap(column, pivot);
            self.pivots[column] = pivot;
            self.eliminate(column);
        }
        // Rows were swapped on the way in, so columns are on the way out.
        for column in (0..self.places.len()).rev() {
            let (a, b) = (self.places[column], self.places[self.pivots[column]]);
            if a != b {
                self.rows.iter_mut().for_each(|row| row.as_mut().as_flattened_mut().swap(a, b));
            }
        }
        true
    }

    #[inline(always)]
    fn weight(&self, row: usize, column: usize) -> f64 {
        self.rows[row].as_ref().as_flattened()[self.places[column]].abs() / self.largest[row]
    }

    /// The row whose entry is the largest in relation to its others.
    #[inline(always)]
    fn heaviest(&self, column: usize) -> usize {
        let (mut pivot, mut weight) = (column, self.weight(column, column));
        for row in column + 1..self.rows.len() {
            let other = self.weight(row, column);
            if other > weight {
                (pivot, weight) = (row, other);
            }
        }
        pivot
    }

    #[inline(always)]
    fn swap(&mut self, a: usize, b: usize) {
        let (upper, lower) = self.rows.split_at_mut(b);
        if let (true, Some(a), Some(b)) = (a < b, upper.get_mut(a), lower.first_mut()) {
            a.as_mut().swap_with_slice(b.as_mut());
        }
        self.largest.swap(a, b);
    }

    #[inline(always)]
    fn eliminate(&mut self, column: usize) {
        let place = self.places[column];
        let (before, rest) = self.rows.split_at_mut(column);
        let Some((pivot, after)) = rest.split_first_mut() else { return };
        let pivot = pivot.as_mut();
        let inverse = splat(1.0 / pivot.as_flattened()[place]);
        pivot.as_flattened_mut()[place] = 1.0;
        pivot.iter_mut().for_each(|entries| *entries = multiply(*entries, inverse));
        for row in before.iter_mut().chain(after) {
            let row = row.as_mut();
            let factor = row.as_flattened()[place];
            if factor == 0.0 {
                continue;
            }
            row.as_flattened_mut()[place] = 0.0;
            for (entries, above) in row.iter_mut().zip(&*pivot) {
                *entries = minus(*entries, splat(factor), *above);
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
            matrix.add(row, column, value);
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
            matrix.add(row, column, 1.0);
        }
        assert!(!matrix.invert());
    }
}
