//! Linear equations by Gauss and Jordan, in numbers that know their rounding errors: which unknowns they determine, and how.

use crate::expr::Rounded;

/// \[A\]{x} + {b} = {0} for several {b}, reduced: each row begins with an unknown that is in no other row.
#[derive(Clone, Debug)]
pub(super) struct Reduced {
    /// Rows of \[A b\].
    rows: Vec<Vec<Rounded>>,
    columns: usize,
    /// The row that begins with each unknown.
    places: Vec<Option<usize>>,
}

impl Reduced {
    /// From the rows of \[A\] and the columns of \[b\].
    pub fn new(matrix: &[Vec<Rounded>], right: &[Vec<Rounded>]) -> Self {
        let columns = matrix.first().map_or(0, Vec::len);
        let with_right = |(index, row): (usize, &Vec<Rounded>)| -> Vec<Rounded> {
            row.iter().copied().chain(right.iter().map(|column| column[index])).collect()
        };
        let rows = matrix.iter().enumerate().map(with_right).collect();
        let mut reduced = Reduced { rows, columns, places: vec![None; columns] };
        let mut open: Vec<usize> = (0..matrix.len()).collect();
        while let Some((row, column)) = reduced.pivot(&open) {
            open.retain(|&other| other != row);
            reduced.places[column] = Some(row);
            reduced.eliminate(row, column);
        }
        reduced
    }

    /// The largest entry of rows that begin with nothing yet.
    fn pivot(&self, open: &[usize]) -> Option<(usize, usize)> {
        let places = open.iter().flat_map(|&row| (0..self.columns).map(move |column| (row, column)));
        let entry = |&(row, column): &(usize, usize)| self.rows[row][column];
        let possible = places.filter(|place| !entry(place).is_zero() && entry(place).is_finite());
        possible.max_by(|a, b| entry(a).value.abs().total_cmp(&entry(b).value.abs()))
    }

    fn eliminate(&mut self, row: usize, column: usize) {
        let pivot = self.rows[row][column];
        let scaled: Vec<Rounded> = self.rows[row].iter().map(|&entry| entry / pivot).collect();
        for (index, other) in self.rows.iter_mut().enumerate().filter(|(_, other)| other[column] != Rounded::default())
        {
            if index == row {
                other.clone_from(&scaled);
            } else {
                let factor = other[column];
                for (entry, &by) in other.iter_mut().zip(&scaled).filter(|(_, by)| **by != Rounded::default()) {
                    *entry = *entry - factor * by;
                }
            }
            other[column] = Rounded::exact(f64::from(index == row));
        }
    }

    /// Does this unknown follow from the equations?
    pub fn determines(&self, column: usize) -> bool {
        let others = |row: &Vec<Rounded>| (0..self.columns).all(|other| other == column || row[other].is_zero());
        self.places.get(column).copied().flatten().is_some_and(|row| others(&self.rows[row]))
    }

    /// An unknown, if those that are left open are zero.
    pub fn solution(&self, column: usize, right: usize) -> Rounded {
        let place = self.places.get(column).copied().flatten();
        place.map_or(Rounded::default(), |row| -self.rows[row][self.columns + right])
    }

    /// Do the rows that begin with no unknown hold, for the first {b}?
    pub fn is_consistent(&self) -> bool {
        /// What is left when the others hold to rounding.
        const REST: f64 = 1e-11;
        let begins = |row: usize| self.places.contains(&Some(row));
        let rest = self.rows.iter().enumerate().filter(|(row, _)| !begins(*row)).map(|(_, row)| row[self.columns]);
        rest.into_iter().all(|rest| rest.is_zero() || rest.value.abs() < REST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(numbers: &[f64]) -> Vec<Rounded> {
        numbers.iter().copied().map(Rounded::exact).collect()
    }

    #[test]
    fn what_follows_is_told_from_what_is_left_open() {
        // x + y + z = 3, x + y - z = 1, and their sum: z = 1, x + y = 2
        let matrix = [[1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [2.0, 2.0, 0.0]].map(|row| exact(&row));
        let reduced = Reduced::new(&matrix, &[exact(&[-3.0, -1.0, -4.0])]);
        assert_eq!([0, 1, 2].map(|column| reduced.determines(column)), [false, false, true]);
        assert!((reduced.solution(2, 0).value - 1.0).abs() < 1e-15);
        assert!(reduced.is_consistent());
        assert!(!Reduced::new(&matrix, &[exact(&[-3.0, -1.0, -5.0])]).is_consistent());
    }

    #[test]
    fn rounding_errors_are_no_equation() {
        let third = Rounded::exact(1.0) / Rounded::exact(3.0);
        let matrix = [vec![third, third], vec![third + third + third, Rounded::exact(1.0)]];
        let reduced = Reduced::new(&matrix, &[vec![third, Rounded::exact(1.0)]]);
        assert!(!reduced.determines(0) && !reduced.determines(1));
        assert!(reduced.is_consistent());
    }

    #[test]
    fn nothing_is_determined_by_no_equation() {
        let reduced = Reduced::new(&[], &[Vec::new()]);
        assert!(!reduced.determines(0));
        assert_eq!(reduced.solution(0, 0), Rounded::default());
    }
}
