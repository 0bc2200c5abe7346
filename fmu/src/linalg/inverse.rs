//! The inverse of the symmetric matrix [M J^T; J 0], once a step.

mod independent;

use independent::Choice;

use super::SINGULAR;
use super::lane::{
    Lane, WIDTH, ZERO, add, at_each, by_width, lanes, larger, largest, minus, multiply, plus, splat, subtract,
};
use super::matrix::{Entries, Lanes, Places};
use crate::math;

/// The smallest share of a mass that may be left as a pivot where rows are eliminated together: multiplying by the inverse of a block loses digits in
/// proportion to the square of what one row after the other loses.
pub(crate) const LEFT: f64 = 1e-3;
/// An entry of the diagonal that is larger than this, in the same units, is the pivot without looking for a larger one.
pub(crate) const GOOD: f64 = 0.1;

/// A square matrix by rows. Equations have their own places among the rows and columns; what is left over is the identity.
#[derive(Clone, Debug)]
pub(crate) struct Inverse {
    /// Lanes of a row.
    width: usize,
    /// Are all equations of masses, so that every pivot of the diagonal is positive?
    definite: bool,
    /// Place of each equation.
    places: Vec<usize>,
    rows: Vec<Lane>,
    /// For each place a row of ones with a zero there: no single number is written into a row that is read in lanes right after.
    others: Vec<Lane>,
    /// The row that is the pivot.
    pivot: Vec<Lane>,
    /// Row that was the pivot of each equation.
    pivots: Vec<usize>,
    /// One over the largest entry that each row began with.
    scales: Vec<f64>,
    /// The smallest pivot of each place that counts where rows are eliminated together.
    least: Vec<f64>,
    /// If loop equations repeat others.
    choice: Option<Box<Choice>>,
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

impl Lanes<f64, WIDTH> for Inverse {
    #[inline(always)]
    fn put(&mut self, row: usize, lane: usize, entries: Lane) {
        self.rows[row * self.width + lane] = entries;
    }
}

impl Inverse {
    /// For equations at these places, among so many; a `definite` matrix has no loop equations.
    pub fn new(places: Vec<usize>, room: usize, definite: bool) -> Self {
        let width = lanes(room);
        let count = width * WIDTH;
        let mut others = vec![splat(1.0); count * width];
        for (place, row) in others.chunks_exact_mut(width.max(1)).enumerate() {
            row.as_flattened_mut()[place] = 0.0;
        }
        let mut rows = vec![ZERO; count * width];
        for place in (0..count).filter(|place| !places.contains(place)) {
            rows.as_flattened_mut()[place * count + place] = 1.0;
        }
        Self {
            width,
            definite,
            others,
            rows,
            pivot: vec![ZERO; width],
            pivots: vec![0; places.len()],
            scales: vec![1.0; count],
            least: vec![0.0; count],
            choice: None,
            places,
        }
    }

    /// Zero.
    #[inline(always)]
    pub fn clear(&mut self) {
        for &place in &self.places {
            self.rows[place * self.width..][..self.width].fill(ZERO);
        }
    }

    /// Number of equations.
    pub fn size(&self) -> usize {
        self.places.len()
    }

    /// Where an entry and its mirror image are kept.
    pub fn places(&self, row: usize, column: usize) -> Places {
        let (count, row, column) = (self.width * WIDTH, self.places[row], self.places[column]);
        [row * count + column, column * count + row]
    }

    /// An entry, by equations.
    #[inline]
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.rows.as_flattened()[self.places[row] * self.width * WIDTH + self.places[column]]
    }

    /// Takes an inverse over, by rows of equations.
    pub fn take(&mut self, entries: &[f64]) {
        let (size, count) = (self.places.len(), self.width * WIDTH);
        for (row, entries) in self.places.iter().zip(entries.chunks_exact(size.max(1))) {
            let row = &mut self.rows.as_flattened_mut()[row * count..][..count];
            for (place, entry) in self.places.iter().zip(entries) {
                row[*place] = *entry;
            }
        }
    }

    /// An entry of the diagonal.
    pub fn diagonal(&self, equation: usize) -> f64 {
        self.entry(equation, equation)
    }

    /// Adds the sizes of the entries of an equation's row, times a factor, to sums by places.
    pub fn add_sizes(&self, equation: usize, factor: f64, sums: &mut [Lane]) {
        let row = &self.rows[self.places[equation] * self.width..][..self.width];
        for (sum, entries) in sums.iter_mut().zip(row) {
            *sum = plus(*sum, splat(factor), entries.map(f64::abs));
        }
    }

    /// Its rows by places, in lanes of L; none if they are not E of these wide.
    #[inline(always)]
    pub fn rows<const L: usize, const E: usize>(&self) -> &[[Lane<f64, L>; E]] {
        if self.width * WIDTH == E * L { self.rows.as_flattened().as_chunks().0.as_chunks().0 } else { &[] }
    }

    /// The inverse times a vector by equations, in lanes.
    #[inline(always)]
    pub fn times(&self, vector: &[f64], product: &mut [Lane]) {
        // Four lanes are found together.
        let (groups, rest) = product.as_chunks_mut::<4>();
        let mut first = 0;
        for group in groups {
            *group = self.times_group(vector, first);
            first += group.len();
        }
        for (lane, result) in (first..).zip(rest) {
            [*result] = self.times_group(vector, lane);
        }
    }

    /// Minus the inverse times a vector that is zero before the equation `first`.
    #[inline(always)]
    pub fn minus_times_from(&self, first: usize, vector: &[f64], product: &mut [Lane]) {
        let width = self.width;
        let product = &mut product[..width];
        product.fill(ZERO);
        for (place, value) in self.places[first..].iter().zip(vector) {
            let row = &self.rows[place * width..][..width];
            for lane in 0..width {
                product[lane] = minus(product[lane], row[lane], splat(*value));
            }
        }
    }

    /// The inverse times several vectors side by side, where the place of each equation is its number.
    #[inline(always)]
    pub fn times_all<const D: usize>(&self, vectors: &[[f64; D]], products: &mut [[f64; D]]) {
        for (lane, products) in products.chunks_mut(WIDTH).enumerate() {
            let mut sums = [[0.0; D]; WIDTH];
            for (row, vector) in self.rows.chunks_exact(self.width).zip(vectors) {
                let factors = row[lane];
                for j in 0..WIDTH {
                    at_each!(D, i => sums[j][i] += factors[j] * vector[i]);
                }
            }
            products.copy_from_slice(&sums[..products.len()]);
        }
    }

    /// Some lanes of the product, from the first one on: even and odd terms apart, so that they do not wait for each other.
    #[inline(always)]
    fn times_group<const G: usize>(&self, vector: &[f64], first: usize) -> [Lane; G] {
        let (mut even, mut odd) = ([ZERO; G], [ZERO; G]);
        let count = self.places.len().min(vector.len());
        let (places, values) = (&self.places[..count], &vector[..count]);
        let mut i = 0;
        while i + 1 < count {
            even = self.more(even, places[i], first, values[i]);
            odd = self.more(odd, places[i + 1], first, values[i + 1]);
            i += 2;
        }
        if i < count {
            even = self.more(even, places[i], first, values[i]);
        }
        for g in 0..G {
            even[g] = add(even[g], odd[g]);
        }
        even
    }

    /// sum + row x value, from the first lane on.
    #[inline(always)]
    fn more<const G: usize>(&self, mut sum: [Lane; G], place: usize, first: usize, value: f64) -> [Lane; G] {
        let row = &self.rows[place * self.width + first..][..G];
        for g in 0..G {
            sum[g] = plus(sum[g], row[g], splat(value));
        }
        sum
    }

    by_width! {
        /// Replaces the matrix by its inverse, four rows and columns at a time without looking for pivots: as good as any other way where the masses
        /// are alike and come before the loop equations, for then every pivot is a mass that is left, or minus the square of a distance between loop
        /// equations. False if there is none, or if too little is left of a mass; the matrix is lost then.
        pub fn invert_in_order(&mut self: Inverse) -> bool = invert_in_order_any
    }

    #[inline(always)]
    fn invert_in_order_any(&mut self) -> bool {
        // The same for every width; small ones are known to the compiler.
        match self.width {
            2 => self.eliminate_in_order(2),
            3 => self.eliminate_in_order(3),
            4 => self.eliminate_in_order(4),
            width => self.eliminate_in_order(width),
        }
    }

    #[inline(always)]
    fn eliminate_in_order(&mut self, width: usize) -> bool {
        self.bound(width);
        for four in 0..width {
            if !self.eliminate_four(four, width) {
                return false;
            }
        }
        true
    }

    /// One lane of columns, and its rows.
    #[inline(always)]
    fn eliminate_four(&mut self, four: usize, width: usize) -> bool {
        let (before, rest) = self.rows.split_at_mut(four * WIDTH * width);
        let (pivots, after) = rest.split_at_mut(WIDTH * width);
        let (mut block, mut least) = ([ZERO; WIDTH], ZERO);
        for row in 0..WIDTH {
            (block[row], pivots[row * width + four]) = (pivots[row * width + four], UNITS[row]);
            least[row] = self.least[four * WIDTH + row];
        }
        let Some(inverse) = invert_four(block, least) else { return false };
        for lane in 0..width {
            let mut old = [ZERO; WIDTH];
            for row in 0..WIDTH {
                old[row] = pivots[row * width + lane];
            }
            for row in 0..WIDTH {
                let [a, b, c, d] = inverse[row];
                let left = plus(multiply(splat(a), old[0]), splat(b), old[1]);
                pivots[row * width + lane] = add(left, plus(multiply(splat(c), old[2]), splat(d), old[3]));
            }
        }
        let (a, rest) = pivots.split_at(width);
        let (b, rest) = rest.split_at(width);
        let (c, d) = rest.split_at(width);
        for rows in before.chunks_exact_mut(2 * width).chain(after.chunks_exact_mut(2 * width)) {
            let (first, second) = rows.split_at_mut(width);
            let (left, right) = (first[four], second[four]);
            (first[four], second[four]) = (ZERO, ZERO);
            let pivots = a.iter().zip(b).zip(c.iter().zip(d));
            for ((one, two), ((a, b), (c, d))) in first.iter_mut().zip(second).zip(pivots) {
                *one = less(*one, left, [*a, *b, *c, *d]);
                *two = less(*two, right, [*a, *b, *c, *d]);
            }
        }
        true
    }

    by_width! {
        /// Replaces the matrix by its inverse, by Gauss and Jordan with row pivots. False if there is none.
        pub fn invert(&mut self: Inverse) -> bool = invert_any
    }

    #[inline(always)]
    fn invert_any(&mut self) -> bool {
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
        self.scale(width);
        for column in 0..self.places.len() {
            // Elimination of a definite matrix in order loses no more digits than M_kk (M^-1)_kk says, however unlike its masses are (Demmel 1989); with rows
            // exchanged it does.
            let enough = if self.definite { SINGULAR } else { GOOD };
            let good = self.weight(column, column, width) > enough;
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
    fn scale(&mut self, width: usize) {
        for &place in &self.places {
            self.scales[place] = 1.0 / largest_entry(&self.rows[place * width..][..width]);
        }
    }

    /// A loop equation has no entry on the diagonal.
    #[inline(always)]
    fn bound(&mut self, width: usize) {
        for &place in &self.places {
            let row = &self.rows[place * width..][..width];
            self.least[place] = math::maximum(SINGULAR * largest_entry(row), LEFT * row.as_flattened()[place]);
        }
    }

    #[inline(always)]
    fn weight(&self, row: usize, column: usize, width: usize) -> f64 {
        let row = self.places[row];
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
            let [a, b] = [a, b].map(|row| self.places[row]);
            let (upper, lower) = self.rows.split_at_mut(b * width);
            upper[a * width..][..width].swap_with_slice(&mut lower[..width]);
            self.scales.swap(a, b);
        }
    }

    #[inline(always)]
    fn eliminate(&mut self, column: usize, width: usize) {
        let place = self.places[column];
        let Self { rows, places, pivot, others, .. } = self;
        let (pivot, others) = (&mut pivot[..width], &others[place * width..][..width]);
        let row = &rows[place * width..][..width];
        let inverse = splat(1.0 / row.as_flattened()[place]);
        for lane in 0..width {
            pivot[lane] = multiply(plus(subtract(splat(1.0), others[lane]), row[lane], others[lane]), inverse);
        }
        for &other in places.iter() {
            let row = &mut rows[other * width..][..width];
            if other == place {
                row.copy_from_slice(pivot);
                continue;
            }
            let factor = row.as_flattened()[place];
            if factor != 0.0 {
                for lane in 0..width {
                    row[lane] = minus(multiply(row[lane], others[lane]), splat(factor), pivot[lane]);
                }
            }
        }
    }
}

#[inline(always)]
fn largest_entry(row: &[Lane]) -> f64 {
    let mut worst = ZERO;
    for lane in 0..row.len() {
        worst = larger(worst, row[lane]);
    }
    largest(worst)
}

/// sum - factors . rows
#[inline(always)]
fn less(sum: Lane, factors: Lane, [a, b, c, d]: [Lane; WIDTH]) -> Lane {
    let sum = minus(minus(sum, splat(factors[0]), a), splat(factors[1]), b);
    minus(minus(sum, splat(factors[2]), c), splat(factors[3]), d)
}

/// Rows of the identity.
const UNITS: [Lane; WIDTH] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// The inverse of a block of the diagonal, by Gauss and Jordan in order; none if a pivot is less than it must be.
#[inline(always)]
fn invert_four(mut block: [Lane; WIDTH], least: Lane) -> Option<[Lane; WIDTH]> {
    for column in 0..WIDTH {
        let pivot = block[column][column];
        // Written so that NaN is singular too.
        let regular = pivot.abs() > least[column];
        if !regular {
            return None;
        }
        let mut factors = ZERO;
        for row in 0..WIDTH {
            (factors[row], block[row][column]) = (block[row][column], UNITS[row][column]);
        }
        block[column] = multiply(block[column], splat(1.0 / pivot));
        for row in 0..WIDTH {
            if row != column {
                block[row] = minus(block[row], splat(factors[row]), block[column]);
            }
        }
    }
    Some(block)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(places: &[usize], room: usize, entries: &[(usize, usize, f64)]) -> Inverse {
        let mut matrix = Inverse::new(places.to_vec(), room, false);
        matrix.clear();
        for &(row, column, value) in entries {
            matrix.add(matrix.places(row, column), value);
        }
        matrix
    }

    /// How far the matrix of these entries times its inverse is from the identity.
    fn error(inverse: &Inverse, places: &[usize], entries: &[(usize, usize, f64)]) -> f64 {
        let size = places.len();
        let mut dense = vec![vec![0.0; size]; size];
        for &(row, column, value) in entries {
            dense[row][column] += value;
            if row != column {
                dense[column][row] += value;
            }
        }
        let width = inverse.width * WIDTH;
        let mut worst = 0.0_f64;
        for (row, values) in dense.iter().enumerate() {
            for (column, place) in places.iter().enumerate() {
                let terms = values.iter().zip(places);
                let entry: f64 = terms.map(|(value, k)| value * inverse.rows.as_flattened()[k * width + place]).sum();
                worst = worst.max((entry - f64::from(u8::from(row == column))).abs());
            }
        }
        worst
    }

    #[test]
    fn a_saddle_point_matrix_has_its_inverse() {
        // Two masses, one of them zero, held together: zero pivots on the diagonal.
        let entries = [(0, 0, 2.0), (0, 2, 1.0), (1, 2, -1.0), (1, 3, 1.0), (0, 3, 0.5)];
        let places = [0, 1, 4, 5];
        let mut matrix = filled(&places, 8, &entries);
        assert!(!matrix.invert_in_order());
        let mut matrix = filled(&places, 8, &entries);
        assert!(matrix.invert());
        assert!(error(&matrix, &places, &entries) < 1e-14);
    }

    #[test]
    fn masses_and_loop_equations_are_inverted_in_order() {
        for (unknowns, loops) in [(3, 1), (7, 6), (9, 2), (18, 11)] {
            let mut entries: Vec<(usize, usize, f64)> = (0..unknowns).map(|i| (i, i, 9.0)).collect();
            for i in 0..unknowns {
                entries
                    .extend((0..i).map(|j| (j, i, 2.0 * (1.7 * i as f64 + 0.3 * j as f64).cos() / (1.0 + i as f64))));
                entries
                    .extend((0..loops).map(|row| (i, unknowns + row, (0.61 * ((i + 2) * (i + row + 3)) as f64).sin())));
            }
            let first = lanes(unknowns) * WIDTH;
            let places: Vec<usize> = (0..unknowns).chain(first..first + loops).collect();
            let (mut by_order, mut by_pivots) =
                (filled(&places, first + loops, &entries), filled(&places, first + loops, &entries));
            assert!(by_order.invert_in_order() && by_pivots.invert());
            assert!(error(&by_order, &places, &entries) < 1e-9, "{unknowns} {loops}");
            let vector: Vec<f64> = (0..places.len()).map(|i| (i as f64).sin()).collect();
            let [mut one, mut other] = [(); 2].map(|()| vec![ZERO; by_order.width]);
            by_order.times(&vector, &mut one);
            by_pivots.times(&vector, &mut other);
            for (a, b) in one.as_flattened().iter().zip(other.as_flattened()) {
                assert!((a - b).abs() < 1e-9 * a.abs().max(1.0), "{unknowns} {loops}: {a} {b}");
            }
        }
    }

    /// Five masses that move almost only together: of each but the first little is left.
    #[test]
    fn a_mass_of_which_little_is_left_is_inverted_row_by_row() {
        for (common, in_order) in [(1e2, true), (1e6, false)] {
            let entries: Vec<(usize, usize, f64)> =
                (0..5).flat_map(|i| (i..5).map(move |j| (i, j, common + f64::from(u8::from(i == j))))).collect();
            let places = [0, 1, 2, 3, 4];
            assert_eq!(filled(&places, 5, &entries).invert_in_order(), in_order, "{common}");
            let mut inverse = filled(&places, 5, &entries);
            assert!(inverse.invert());
            let expected = 1.0 - common / (1.0 + 5.0 * common);
            (0..5).for_each(|i| assert!((inverse.diagonal(i) - expected).abs() < 1e-15 * common, "{common} {i}"));
        }
    }

    #[test]
    fn a_singular_matrix_has_none() {
        let entries = [(0, 0, 1.0), (0, 1, 1.0), (1, 1, 1.0)];
        assert!(!filled(&[0, 1], 4, &entries).invert());
        assert!(!filled(&[0, 1], 4, &entries).invert_in_order());
    }
}
