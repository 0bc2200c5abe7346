//! The matrix of a pose with its derivatives: of K x = r follows K x' = r' - K' x, so that what solves for the values solves for every derivative.

use super::dual::Dual;
use super::lane::{WIDTH, at_each, lanes};
use super::matrix::{Assemble, Entries, Matrix, Places, Solve};
use super::number::Number;
use super::tree::Recursion;

/// Either way.
#[derive(Clone, Debug)]
pub(crate) enum VariedMatrix<const D: usize> {
    Entries(Box<VariedEntries<D>>),
    /// Of an open chain, or tree, of arms.
    Chained(Recursion<Dual<D>>),
}

/// A matrix by its entries.
#[derive(Clone, Debug)]
pub(crate) struct VariedEntries<const D: usize> {
    values: Matrix,
    entries: Vec<Entry<D>>,
    /// Where each equation's part of a solution goes.
    targets: Vec<usize>,
    /// Right-hand sides and a solution of the values.
    vector: Vec<f64>,
    found: Vec<f64>,
    /// The same of the derivatives.
    rest: Vec<[f64; D]>,
    changes: Vec<[f64; D]>,
}

/// One entry, which is its mirror image too, and where the values have it.
#[derive(Clone, Copy, Debug)]
struct Entry<const D: usize> {
    row: usize,
    column: usize,
    places: Places,
    value: Dual<D>,
}

impl<const D: usize> VariedEntries<D> {
    /// With these entries; `values` makes the matrix of the values, for solutions by equations among so much room.
    pub fn new(
        targets: Vec<usize>,
        entries: impl Iterator<Item = (usize, usize)>,
        values: impl FnOnce(Vec<usize>, usize) -> Matrix,
    ) -> Self {
        let mut places: Vec<(usize, usize)> = entries.map(|(row, column)| (row.max(column), row.min(column))).collect();
        places.sort_unstable();
        places.dedup();
        let size = targets.len();
        let room = lanes(size) * WIDTH;
        let values = values((0..size).collect(), room);
        let entry = |(row, column)| Entry { row, column, places: values.places(row, column), value: Dual::ZERO };
        Self {
            entries: places.into_iter().map(entry).collect(),
            values,
            targets,
            vector: vec![0.0; size],
            found: vec![0.0; room],
            rest: vec![[0.0; D]; size],
            changes: vec![[0.0; D]; size],
        }
    }

    /// Where an entry is kept.
    pub fn places(&self, row: usize, column: usize) -> Places {
        [self.entries.partition_point(|entry| (entry.row, entry.column) < (row.max(column), row.min(column))); 2]
    }

    /// Zero.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.entries.iter_mut().for_each(|entry| entry.value = Dual::ZERO);
    }

    /// Makes the matrix ready for solutions. False if it is singular.
    #[inline(always)]
    pub fn factor(&mut self, alike: bool) -> bool {
        self.values.factor(alike, &mut Values(&self.entries))
    }

    #[inline(always)]
    fn solve(&mut self, vector: &[Dual<D>], solution: &mut [Dual<D>]) {
        let Self { values, entries, targets, vector: right, found, rest, changes } = self;
        for ((right, rest), value) in right.iter_mut().zip(&mut *rest).zip(vector) {
            (*right, *rest) = (value.value(), *value.tangents());
        }
        values.solve(right, found);
        for Entry { row, column, value, .. } in entries {
            let (change, by_row, by_column) = (value.tangents(), found[*row], found[*column]);
            let rest_of_row = &mut rest[*row];
            at_each!(D, i => rest_of_row[i] -= change[i] * by_column);
            if row != column {
                let rest_of_column = &mut rest[*column];
                at_each!(D, i => rest_of_column[i] -= change[i] * by_row);
            }
        }
        values.solve_all(rest, changes);
        for ((&target, &value), &change) in targets.iter().zip(&*found).zip(&*changes) {
            solution[target] = Dual::new(value, change);
        }
    }
}

impl<const D: usize> Entries<Dual<D>> for VariedEntries<D> {
    #[inline(always)]
    fn add(&mut self, [place, _]: Places, value: Dual<D>) {
        self.entries[place].value += value;
    }
}

/// The entries without their derivatives.
struct Values<'a, const D: usize>(&'a [Entry<D>]);

impl<const D: usize> Assemble for Values<'_, D> {
    #[inline(always)]
    fn assemble(&mut self, matrix: &mut impl Entries) {
        self.0.iter().for_each(|entry| matrix.add(entry.places, entry.value.value()));
    }

    /// None: what is a chain is no matrix of entries.
    fn derivatives(&self) -> [&[f64]; 2] {
        [&[]; 2]
    }
}

impl<const D: usize> Solve<Dual<D>> for VariedMatrix<D> {
    fn none() -> Self {
        Self::Chained(Recursion::new(&[]))
    }

    #[inline(always)]
    fn solve(&mut self, vector: &[Dual<D>], solution: &mut [Dual<D>]) {
        match self {
            Self::Entries(entries) => entries.solve(vector, solution),
            Self::Chained(recursion) => recursion.solve(vector, solution),
        }
    }

    fn solve_rest(&self, _: usize, _: &[Dual<D>], _: &mut [Dual<D>]) -> bool {
        false
    }
}
