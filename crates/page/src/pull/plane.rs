//! Rows of linear equations as an orthonormal basis: Gram and Schmidt's method, the largest row first, each made orthogonal twice.

/// Less than this is nothing of a direction.
const NOTHING: f64 = 1e-12;

pub fn length(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// So many independent rows.
pub struct Basis {
    ways: Vec<Vec<f64>>,
    /// By basis vector: its row, and what the row is of the basis vectors up to it.
    rows: Vec<(usize, Vec<f64>)>,
    /// How far the last row is from the others, relative to the rows: zero where they depend on each other.
    pub smallest: f64,
}

impl Basis {
    /// The basis of the rows, of which so many are independent, or fewer; `sizes` are what the rows are small or large against.
    pub fn new(mut rest: Vec<Vec<f64>>, sizes: &[f64], rank: usize) -> Self {
        let mut shares = vec![Vec::new(); rest.len()];
        let mut basis = Self { ways: Vec::new(), rows: Vec::new(), smallest: 1.0 };
        let mut left: Vec<usize> = (0..rest.len()).collect();
        while basis.ways.len() < rank {
            let relative = |row: usize| if sizes[row] > 0.0 { length(&rest[row]) / sizes[row] } else { 0.0 };
            let Some(place) = (0..left.len()).max_by(|&a, &b| relative(left[a]).total_cmp(&relative(left[b]))) else {
                basis.smallest = 0.0;
                break;
            };
            let row = left.swap_remove(place);
            basis.smallest = cotree_fmu::math::minimum(basis.smallest, relative(row));
            if relative(row) <= NOTHING {
                basis.smallest = 0.0;
                break;
            }
            let mut way = std::mem::take(&mut rest[row]);
            let mut share = std::mem::take(&mut shares[row]);
            for (known, share) in basis.ways.iter().zip(&mut share) {
                *share += remove(&mut way, known);
            }
            let size = length(&way);
            share.push(size);
            way.iter_mut().for_each(|value| *value /= size);
            for &other in &left {
                shares[other].push(remove(&mut rest[other], &way));
            }
            basis.ways.push(way);
            basis.rows.push((row, share));
        }
        basis
    }

    /// The smallest solution of the rows of the basis with these right sides.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut along: Vec<f64> = Vec::new();
        for (row, share) in &self.rows {
            let known = product(&along, share);
            let size = share.get(along.len()).copied().unwrap_or(1.0);
            along.push((right[*row] - known) / size);
        }
        let width = self.ways.first().map_or(0, Vec::len);
        (0..width).map(|place| self.ways.iter().zip(&along).map(|(way, share)| way[place] * share).sum()).collect()
    }

    /// The directions that no row holds, of so many unknowns.
    pub fn rest(&self, width: usize) -> Vec<Vec<f64>> {
        let mut free: Vec<Vec<f64>> = Vec::new();
        let count = width - self.ways.len();
        let mut units: Vec<Vec<f64>> = (0..width)
            .map(|place| {
                let mut unit = vec![0.0; width];
                unit[place] = 1.0;
                self.ways.iter().for_each(|way| {
                    remove(&mut unit, way);
                });
                unit
            })
            .collect();
        while free.len() < count {
            let Some(place) = (0..units.len()).max_by(|&a, &b| length(&units[a]).total_cmp(&length(&units[b]))) else {
                break;
            };
            let mut way = units.swap_remove(place);
            self.ways.iter().chain(&free).for_each(|known| {
                remove(&mut way, known);
            });
            let size = length(&way);
            way.iter_mut().for_each(|value| *value /= size);
            units.iter_mut().for_each(|unit| {
                remove(unit, &way);
            });
            free.push(way);
        }
        free
    }
}

/// Takes out of a vector what it is of a unit vector, which it returns.
fn remove(vector: &mut [f64], way: &[f64]) -> f64 {
    let share = product(vector, way);
    vector.iter_mut().zip(way).for_each(|(value, way)| *value -= share * way);
    share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_solution_and_the_free_directions() {
        let rows = vec![vec![1.0, 0.0, 2.0], vec![0.0, 3.0, 0.0], vec![2.0, 0.0, 4.0]];
        let basis = Basis::new(rows.clone(), &[3.0, 3.0, 5.0], 2);
        assert!(basis.smallest > 0.8);
        let solution = basis.solve(&[5.0, 6.0, 10.0]);
        for (value, wanted) in solution.iter().zip([1.0, 2.0, 2.0]) {
            assert!((value - wanted).abs() < 1e-14, "{solution:?}");
        }
        let free = basis.rest(3);
        assert_eq!(free.len(), 1);
        assert!(rows.iter().all(|row| product(row, &free[0]).abs() < 1e-14) && (length(&free[0]) - 1.0).abs() < 1e-14);
        // Of three that depend on each other no three are independent.
        assert!(Basis::new(rows, &[3.0, 3.0, 5.0], 3).smallest < 1e-12);
    }
}
