//! Rows of a matrix with few entries, solved for as many unknowns as rows are independent: what they leave free are short vectors.

/// Entries that are not zero by ascending places: place and value.
pub(crate) type EntryList = Vec<(usize, f64)>;

/// A pivot is at least this share of the largest entry of its row, so that no solved row holds large numbers (Duff, Erisman and Reid, Direct Methods for Sparse
/// Matrices, 2017, 7.3).
const LARGE: f64 = 0.3;
/// Smaller entries are what rounding errors leave where rows of size 1 cancel.
const ZERO_ENTRY: f64 = f64::EPSILON;

/// A row that does not depend on those before it: x_column + rest x = 0, where the rest has no pivots.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    pub column: usize,
    pub rest: EntryList,
    /// The combination of rows that it is.
    pub shares: EntryList,
}

/// A row that depends on others, without what they say: rest x = 0, where the rest has no pivots.
#[derive(Clone, Debug)]
pub(crate) struct Dependent {
    pub rest: EntryList,
    /// The combination of rows that it is; its own share is 1.
    pub shares: EntryList,
}

/// Rows solved for their pivots.
#[derive(Clone, Debug)]
pub(crate) struct Elimination {
    pub solved: Vec<Solved>,
    pub dependent: Vec<Dependent>,
    /// By rows: is it solved?
    pub independent: Vec<bool>,
    /// By columns: which row is solved for it.
    pivots: Vec<Option<usize>>,
    /// By columns: solved rows that have had an entry there.
    holders: Vec<Vec<usize>>,
}

/// A sum of entries in the making.
#[derive(Default)]
struct Sum {
    values: Vec<f64>,
    places: Vec<usize>,
}

impl Sum {
    fn new(size: usize) -> Self {
        Self { values: vec![0.0; size], places: Vec::new() }
    }

    fn add(&mut self, place: usize, value: f64) {
        // What has cancelled may be in the list twice.
        if self.values[place] == 0.0 {
            self.places.push(place);
        }
        self.values[place] += value;
    }

    fn add_all(&mut self, entries: &[(usize, f64)], factor: f64) {
        entries.iter().for_each(|&(place, value)| self.add(place, factor * value));
    }

    /// Takes the sum out.
    fn take(&mut self) -> EntryList {
        self.places.sort_unstable();
        self.places.dedup();
        let values = &mut self.values;
        let mut entries = EntryList::with_capacity(self.places.len());
        entries.extend(self.places.drain(..).map(|place| (place, std::mem::take(&mut values[place]))));
        entries.retain(|(_, value)| is_something(*value));
        entries
    }
}

impl Elimination {
    /// Of rows with so many columns, of which the first `unknowns` may be pivots. `depends` says of a row whether it depends on those before it, from its number and
    /// what is left of it. None if an independent row has no pivot.
    pub fn new(
        rows: &[EntryList],
        [unknowns, columns]: [usize; 2],
        mut depends: impl FnMut(usize, &[(usize, f64)]) -> bool,
    ) -> Option<Self> {
        let mut counts = vec![0_usize; columns];
        rows.iter().flatten().for_each(|(column, _)| counts[*column] += 1);
        let (mut sum, mut shares) = (Sum::new(columns), Sum::new(rows.len()));
        let mut found = Self {
            solved: Vec::with_capacity(rows.len()),
            dependent: Vec::new(),
            independent: vec![false; rows.len()],
            pivots: vec![None; columns],
            holders: vec![Vec::new(); columns],
        };
        for (index, row) in rows.iter().enumerate() {
            found.reduce(row, &mut sum, &mut shares);
            shares.add(index, 1.0);
            let (rest, shares_of_row) = (sum.take(), shares.take());
            if depends(index, &rest) {
                found.dependent.push(Dependent { rest, shares: shares_of_row });
                continue;
            }
            found.independent[index] = true;
            let column = pivot(&rest, unknowns, &counts)?;
            found.take_out(solve_for(column, rest, shares_of_row));
        }
        for mut row in std::mem::take(&mut found.dependent) {
            found.reduce(&row.rest, &mut sum, &mut shares);
            shares.add_all(&row.shares, 1.0);
            (row.rest, row.shares) = (sum.take(), shares.take());
            found.dependent.push(row);
        }
        Some(found)
    }

    /// Takes the pivot of one more solved row out of those before it.
    fn take_out(&mut self, solved: Solved) {
        let place = self.solved.len();
        for holder in std::mem::take(&mut self.holders[solved.column]) {
            let before = &mut self.solved[holder];
            let Ok(place) = before.rest.binary_search_by_key(&solved.column, |entry| entry.0) else { continue };
            let (_, factor) = before.rest.remove(place);
            before.rest = less(&before.rest, factor, &solved.rest);
            before.shares = less(&before.shares, factor, &solved.shares);
            solved.rest.iter().for_each(|(column, _)| self.holders[*column].push(holder));
        }
        solved.rest.iter().for_each(|(column, _)| self.holders[*column].push(place));
        self.pivots[solved.column] = Some(place);
        self.solved.push(solved);
    }

    /// Adds a row without pivots, and the shares of other rows that this takes.
    fn reduce(&self, row: &[(usize, f64)], sum: &mut Sum, shares: &mut Sum) {
        for &(column, value) in row {
            match self.solved_for(column) {
                Some(solved) => {
                    sum.add_all(&solved.rest, -value);
                    shares.add_all(&solved.shares, -value);
                }
                None => sum.add(column, value),
            }
        }
    }

    /// The row that is solved for a column; none if the column is free.
    pub fn solved_for(&self, column: usize) -> Option<&Solved> {
        self.pivots[column].map(|row| &self.solved[row])
    }

    /// How a column changes with a free one, if all solved rows stay zero.
    pub fn along(&self, column: usize, free: usize) -> f64 {
        match self.solved_for(column) {
            Some(solved) => -entry(&solved.rest, free),
            None if column == free => 1.0,
            None => 0.0,
        }
    }
}

/// The column of the pivot: of the large entries the one whose column has the fewest.
fn pivot(rest: &[(usize, f64)], unknowns: usize, counts: &[usize]) -> Option<usize> {
    let may_be = rest.iter().filter(|(column, _)| *column < unknowns);
    let largest = may_be.clone().fold(0.0_f64, |largest, (_, value)| largest.max(value.abs()));
    let large = may_be.filter(|(_, value)| value.abs() > LARGE * largest);
    large.min_by_key(|(column, _)| counts[*column]).map(|(column, _)| *column)
}

fn solve_for(column: usize, mut rest: EntryList, mut shares: EntryList) -> Solved {
    let factor = 1.0 / entry(&rest, column);
    rest.retain(|(place, _)| *place != column);
    rest.iter_mut().chain(&mut shares).for_each(|(_, value)| *value *= factor);
    Solved { column, rest, shares }
}

/// Not a number counts.
fn is_something(value: f64) -> bool {
    let nothing = value.abs() <= ZERO_ENTRY;
    !nothing
}

/// The value at a place.
fn entry(entries: &[(usize, f64)], place: usize) -> f64 {
    entries.binary_search_by_key(&place, |entry| entry.0).map_or(0.0, |found| entries[found].1)
}

/// a - factor b
fn less(a: &[(usize, f64)], factor: f64, b: &[(usize, f64)]) -> EntryList {
    let mut difference = EntryList::with_capacity(a.len() + b.len());
    let (mut a, mut b) = (a.iter().copied().peekable(), b.iter().copied().peekable());
    loop {
        let next = match (a.peek().copied(), b.peek().copied()) {
            (Some(one), Some(other)) if one.0 == other.0 => (one.0, one.1 - factor * other.1),
            (Some(one), Some(other)) if other.0 < one.0 => (other.0, -factor * other.1),
            (Some(one), _) => one,
            (None, Some(other)) => (other.0, -factor * other.1),
            (None, None) => return difference,
        };
        _ = a.next_if(|one| one.0 == next.0);
        _ = b.next_if(|other| other.0 == next.0);
        if is_something(next.1) {
            difference.push(next);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(rest: &[(usize, f64)]) -> f64 {
        rest.iter().fold(0.0, |size: f64, (_, value)| size.max(value.abs()))
    }

    /// Bands of random entries, of which some rows are sums of others.
    #[test]
    fn dependent_rows_are_combinations_of_others_and_the_rest_is_solved() {
        let (unknowns, mut random) = (30, crate::math::Random::new(5));
        let mut rows: Vec<EntryList> =
            (0..18).map(|row| (0..4).map(|step| (row + 3 * step, random.symmetric() + 2.0)).collect()).collect();
        for (place, [one, other]) in [(9, [2, 7]), (19, [0, 16])] {
            rows.insert(place, less(&rows[one].clone(), -0.5, &rows[other].clone()));
        }
        let found = Elimination::new(&rows, [unknowns; 2], |_, rest| size(rest) < 1e-9).unwrap();
        let dependent: Vec<usize> = (0..rows.len()).filter(|row| !found.independent[*row]).collect();
        assert_eq!(dependent.len(), 2, "{dependent:?}");
        let combined = |shares: &EntryList| {
            let mut sum = Sum::new(unknowns);
            shares.iter().for_each(|(row, share)| sum.add_all(&rows[*row], *share));
            sum.take()
        };
        for row in &found.dependent {
            assert!(size(&combined(&row.shares)) < 1e-12 && size(&row.rest) < 1e-12, "{row:?}");
        }
        for solved in &found.solved {
            let combined_row = less(&combined(&solved.shares), 1.0, &solved.rest);
            let [(column, one), rest @ ..] =
                &combined_row.iter().copied().filter(|(_, value)| value.abs() > 1e-12).collect::<Vec<_>>()[..]
            else {
                panic!("{combined_row:?}")
            };
            assert!(*column == solved.column && (one - 1.0).abs() < 1e-12 && rest.is_empty(), "{combined_row:?}");
            assert!(solved.rest.iter().all(|(column, _)| found.solved_for(*column).is_none()), "{solved:?}");
        }
        let free = (0..unknowns).filter(|column| found.solved_for(*column).is_none());
        for free in free {
            let open =
                |row: &EntryList| row.iter().map(|(column, value)| value * found.along(*column, free)).sum::<f64>();
            assert!(rows.iter().all(|row| open(row).abs() < 1e-11), "{free}");
        }
    }

    #[test]
    fn a_row_of_zeros_has_no_pivot() {
        assert!(Elimination::new(&[EntryList::new()], [2; 2], |_, _| false).is_none());
        assert!(Elimination::new(&[EntryList::new()], [2; 2], |_, _| true).is_some());
        assert!(Elimination::new(&[vec![(2, 1.0)]], [2, 3], |_, _| false).is_none());
    }
}
