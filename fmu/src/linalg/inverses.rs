//! The inverses of the matrices of four poses, each with the bits that [`Inverse`] finds for it alone.

use std::ops::Range;

use super::SINGULAR;
use super::inverse::{GOOD, Inverse, LEFT};
use super::lane::{Lane, WIDTH};
use super::matrix::{Entries, Lanes, Places, Solve};
use super::number::Number;
use super::quad::Quad;
use crate::math;

/// Which of the four motions go on together.
pub(crate) type Members = [bool; WIDTH];

/// Square matrices by rows.
#[derive(Clone, Debug)]
pub(crate) struct Inverses {
    /// Where the solution of each equation goes.
    targets: Vec<usize>,
    /// Equations that one motion eliminates together.
    blocks: Vec<Range<usize>>,
    definite: bool,
    entries: Vec<Quad>,
    /// The row that is the pivot.
    pivot: Vec<Quad>,
    /// Row that was the pivot of each equation.
    pivots: Vec<usize>,
    scales: Vec<Quad>,
    least: Vec<Quad>,
}

impl Inverses {
    /// For solutions at these places; those of one motion's own inverse are at others.
    pub fn new(targets: Vec<usize>, alone: &[usize], definite: bool) -> Self {
        let size = targets.len();
        let blocks = alone.chunk_by(|a, b| a / WIDTH == b / WIDTH).scan(0, |end, block| {
            let first = *end;
            *end += block.len();
            Some(first..*end)
        });
        let zeros = |count: usize| vec![Quad::ZERO; count];
        Self {
            blocks: blocks.collect(),
            definite,
            entries: zeros(size * size),
            pivot: zeros(size),
            pivots: vec![0; size],
            scales: zeros(size),
            least: zeros(size),
            targets,
        }
    }

    /// Takes the inverse of one motion over.
    pub fn take(&mut self, member: usize, inverse: &Inverse) {
        let size = self.targets.len();
        for (row, entries) in self.entries.chunks_exact_mut(size.max(1)).enumerate() {
            for (column, entry) in entries.iter_mut().enumerate() {
                entry.set(member, inverse.entry(row, column));
            }
        }
    }

    /// The inverse of one motion, by rows.
    pub fn give(&self, member: usize, entries: &mut [f64]) {
        for (place, entry) in entries.iter_mut().zip(&self.entries) {
            *place = entry.get(member);
        }
    }

    /// Where an entry and its mirror image are kept.
    pub fn places(&self, row: usize, column: usize) -> Places {
        let size = self.targets.len();
        [row * size + column, column * size + row]
    }

    /// Zero.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.entries.fill(Quad::ZERO);
    }

    /// [`Inverse::invert_in_order`]; a motion for which that does not work leaves the others.
    #[inline(always)]
    pub fn invert_in_order(&mut self, members: &mut Members) {
        let size = self.targets.len();
        for row in 0..size {
            let entries = &self.entries[row * size..][..size];
            let left = entries[row].times(LEFT);
            self.least[row] = largest(entries).times(SINGULAR).with(left, math::maximum);
        }
        for index in 0..self.blocks.len() {
            self.eliminate_block(self.blocks[index].clone(), members);
        }
    }

    /// The equations of one block.
    #[inline(always)]
    fn eliminate_block(&mut self, block: Range<usize>, members: &mut Members) {
        let (size, first, count) = (self.targets.len(), block.start, block.len().min(WIDTH));
        let mut inverse = [[Quad::ZERO; WIDTH]; WIDTH];
        for row in 0..count {
            let entries = &mut self.entries[(first + row) * size + first..][..count];
            for column in 0..count {
                inverse[row][column] = entries[column];
                entries[column] = Quad::all(if row == column { 1.0 } else { 0.0 });
            }
        }
        invert_block(&mut inverse, count, &self.least[first..], members);
        for column in 0..size {
            let mut old = [Quad::ZERO; WIDTH];
            for row in 0..count {
                old[row] = self.entries[(first + row) * size + column];
            }
            for row in 0..count {
                let [a, b, c, d] = inverse[row];
                let sum = a * old[0] + b * old[1];
                self.entries[(first + row) * size + column] =
                    if count > 2 { sum + (c * old[2] + d * old[3]) } else { sum };
            }
        }
        for row in (0..first).chain(first + count..size) {
            let mut factors = [Quad::ZERO; WIDTH];
            for k in 0..count {
                factors[k] = std::mem::take(&mut self.entries[row * size + first + k]);
            }
            for column in 0..size {
                let mut sum = self.entries[row * size + column];
                for k in 0..count {
                    sum -= factors[k] * self.entries[(first + k) * size + column];
                }
                self.entries[row * size + column] = sum;
            }
        }
    }

    /// [`Inverse::invert`] with the pivots of the first of these motions; one with other pivots, or without an inverse, leaves the others.
    #[inline(always)]
    pub fn invert(&mut self, members: &mut Members) {
        let size = self.targets.len();
        for row in 0..size {
            self.scales[row] = Quad::all(1.0).over(largest(&self.entries[row * size..][..size]));
        }
        for column in 0..size {
            let Some(pivot) = self.choose(column, members) else { return };
            if pivot != column {
                for place in 0..size {
                    self.entries.swap(column * size + place, pivot * size + place);
                }
                self.scales.swap(column, pivot);
            }
            self.pivots[column] = pivot;
            self.eliminate(column);
        }
        for column in (0..size).rev() {
            let pivot = self.pivots[column];
            if pivot != column {
                self.entries.chunks_exact_mut(size).for_each(|row| row.swap(column, pivot));
            }
        }
    }

    /// The pivot of a column on which the motions agree that go on; none if there is none.
    #[inline(always)]
    fn choose(&self, column: usize, members: &mut Members) -> Option<usize> {
        let enough = if self.definite { SINGULAR } else { GOOD };
        let weight = self.weight(column, column);
        let mut chosen = None;
        for member in 0..WIDTH {
            if !members[member] {
                continue;
            }
            let pivot = if weight.get(member) > enough { Some(column) } else { self.heaviest(column, member) };
            chosen = chosen.or(pivot);
            members[member] = pivot.is_some() && pivot == chosen;
        }
        chosen
    }

    /// The row whose entry is the largest in relation to its others, if that is not singular.
    fn heaviest(&self, column: usize, member: usize) -> Option<usize> {
        let weight = |row: usize| self.weight(row, column).get(member);
        let (mut pivot, mut most) = (column, weight(column));
        for row in column + 1..self.targets.len() {
            let other = weight(row);
            if other > most {
                (pivot, most) = (row, other);
            }
        }
        (most > SINGULAR).then_some(pivot)
    }

    #[inline(always)]
    fn weight(&self, row: usize, column: usize) -> Quad {
        self.entries[row * self.targets.len() + column].map(f64::abs) * self.scales[row]
    }

    #[inline(always)]
    fn eliminate(&mut self, column: usize) {
        let size = self.targets.len();
        let Self { entries, pivot, .. } = self;
        let row = &mut entries[column * size..][..size];
        let inverse = Quad::all(1.0).over(row[column]);
        for place in 0..size {
            row[place] = if place == column { inverse } else { row[place] * inverse };
        }
        pivot.copy_from_slice(row);
        for other in (0..size).filter(|other| *other != column) {
            let row = &mut entries[other * size..][..size];
            let factor = std::mem::take(&mut row[column]);
            for place in 0..size {
                row[place] -= factor * pivot[place];
            }
        }
    }
}

impl Entries<Quad> for Inverses {
    #[inline(always)]
    fn add(&mut self, [place, mirror]: Places, value: Quad) {
        self.entries[place] += value;
        if place != mirror {
            self.entries[mirror] += value;
        }
    }
}

impl Lanes<Quad, 1> for Inverses {
    #[inline(always)]
    fn put(&mut self, row: usize, column: usize, [entry]: [Quad; 1]) {
        self.entries[row * self.targets.len() + column] = entry;
    }
}

impl Solve<Quad> for Inverses {
    fn none() -> Self {
        Self::new(Vec::new(), &[], true)
    }

    /// In the order of [`Inverse::times`].
    #[inline(always)]
    fn solve(&mut self, vector: &[Quad], solution: &mut [Quad]) {
        let size = self.targets.len();
        let vector = &vector[..size];
        for (column, &target) in self.targets.iter().enumerate() {
            let (mut even, mut odd) = (Quad::ZERO, Quad::ZERO);
            let mut rows = self.entries.chunks_exact(2 * size.max(1));
            let mut pairs = vector.chunks_exact(2);
            for (rows, values) in (&mut rows).zip(&mut pairs) {
                even += rows[column] * values[0];
                odd += rows[size + column] * values[1];
            }
            if let ([value], row) = (pairs.remainder(), rows.remainder()) {
                even += row[column] * *value;
            }
            solution[target] = even + odd;
        }
    }

    /// In the order of [`Inverse::minus_times_from`].
    #[inline(always)]
    fn solve_rest(&self, first: usize, vector: &[Quad], solution: &mut [Quad]) -> bool {
        let size = self.targets.len();
        for (column, &target) in self.targets.iter().enumerate() {
            let mut sum = Quad::ZERO;
            for (row, value) in (first..size).zip(vector) {
                sum -= self.entries[row * size + column] * *value;
            }
            solution[target] = sum;
        }
        true
    }

    #[inline(always)]
    fn rows<const L: usize, const E: usize>(&self) -> Option<&[[Lane<Quad, L>; E]]> {
        (self.targets.len() == E * L).then(|| self.entries.as_chunks().0.as_chunks().0)
    }
}

/// The largest magnitudes of a row.
#[inline(always)]
fn largest(row: &[Quad]) -> Quad {
    row.iter().fold(Quad::ZERO, |largest, entry| largest.larger(*entry))
}

/// The inverse of a block of the diagonal; a motion with a pivot that is less than it must be leaves the others.
#[inline(always)]
fn invert_block(block: &mut [[Quad; WIDTH]; WIDTH], count: usize, least: &[Quad], members: &mut Members) {
    for column in 0..count {
        let pivot = block[column][column];
        for member in 0..WIDTH {
            // Written so that NaN is singular too.
            members[member] &= pivot.get(member).abs() > least[column].get(member);
        }
        let inverse = Quad::all(1.0).over(pivot);
        let mut factors = [Quad::ZERO; WIDTH];
        for row in 0..count {
            factors[row] = block[row][column];
            block[row][column] = Quad::all(if row == column { 1.0 } else { 0.0 });
        }
        for place in 0..count {
            block[column][place] = block[column][place] * inverse;
        }
        for row in (0..count).filter(|row| *row != column) {
            for place in 0..count {
                block[row][place] -= factors[row] * block[column][place];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;

    /// Entries of masses, the first of which is given, and of loop equations.
    fn entries(random: &mut Random, [masses, loops]: [usize; 2], first: f64) -> Vec<(usize, usize, f64)> {
        let mut entries = Vec::new();
        for row in 0..masses {
            let mass = if row == 0 { first } else { 3.0 + random.symmetric() };
            entries.push((row, row, mass));
            entries.extend((0..row).map(|column| (row, column, 0.3 * random.symmetric())));
            entries.extend((masses..masses + loops).map(|column| (row, column, random.symmetric())));
        }
        entries
    }

    /// Inverts four matrices together and alone, and compares; says which went on together.
    fn compare(random: &mut Random, sizes: [usize; 2], firsts: [f64; WIDTH], in_order: bool) -> Members {
        let [masses, loops] = sizes;
        let lanes = masses.div_ceil(WIDTH) * WIDTH;
        let targets: Vec<usize> = (0..masses).chain(lanes..lanes + loops).collect();
        let mut together = Inverses::new((0..masses + loops).collect(), &targets, loops == 0);
        let mut alone = [(); WIDTH].map(|()| Inverse::new(targets.clone(), lanes + loops, loops == 0));
        for (member, inverse) in alone.iter_mut().enumerate() {
            inverse.clear();
            for (row, column, value) in entries(random, sizes, firsts[member]) {
                inverse.add(inverse.places(row, column), value);
                let mut added = Quad::ZERO;
                added.set(member, value);
                together.add(together.places(row, column), added);
            }
        }
        let mut members = [true; WIDTH];
        if in_order {
            together.invert_in_order(&mut members)
        } else {
            together.invert(&mut members)
        }
        for (member, inverse) in alone.iter_mut().enumerate() {
            let regular = if in_order { inverse.invert_in_order() } else { inverse.invert() };
            assert!(regular || !members[member]);
            for (place, entry) in together.entries.iter().enumerate().filter(|_| members[member]) {
                let size = masses + loops;
                let expected = inverse.entry(place / size, place % size);
                assert_eq!(entry.get(member).to_bits(), expected.to_bits(), "{sizes:?}, {member}");
            }
        }
        members
    }

    #[test]
    fn every_matrix_has_the_inverse_that_it_has_alone() {
        let mut random = Random::new(5);
        for sizes in [[1, 0], [2, 0], [2, 1], [3, 2], [4, 3], [7, 6], [9, 2]] {
            for in_order in [false, true] {
                let members = compare(&mut random, sizes, [3.0; WIDTH], in_order);
                assert!(members[0] && (!in_order || members == [true; WIDTH]), "{sizes:?}");
            }
        }
    }

    #[test]
    fn a_matrix_with_other_pivots_leaves_the_others() {
        let mut random = Random::new(6);
        let [first, second, ..] = compare(&mut random, [3, 2], [3.0, 0.0, 3.0, 3.0], false);
        assert!(first && !second);
        assert_eq!(compare(&mut random, [3, 2], [3.0, 3.0, 3.0, 0.0], true), [true, true, true, false]);
    }
}
