//! Which loop equations must be added to the mass matrix before its coordinates can be eliminated.
//!
//! A coordinate may move no mass, and two coordinates may move the same mass only: then \[M\] is singular although the motion is determined. Because
//! J a = gamma, the equations (M + w J_k^T J_k) a + J^T lambda = Q + w J_k^T gamma_k have the same solution for every weight w. With enough rows k the
//! matrix in brackets is positive definite in every pose, so that coordinates can be eliminated in any order. Rows are found at one
//! pose numerically: each is the one that constrains a massless motion most.

use std::collections::{BTreeMap, BTreeSet};

use super::eliminate::Undetermined;

pub(crate) type SparseRow = BTreeMap<usize, f64>;

/// Coordinates with less than this share of the largest mass are light: a better pivot is wanted.
pub(crate) const LIGHT: f64 = 1e-4;
/// A pivot that keeps less than this share of its mass is poor: a better one is wanted.
const POOR: f64 = 1e-6;
/// A pivot that keeps less than this share is zero but for rounding.
const ZERO: f64 = 1e-12;
/// A loop equation constrains a motion if this share of its terms does not cancel.
const CONSTRAINS: f64 = 1e-6;

/// Loop equations by index, each with its weight. `mass` may have empty rows for coordinates that are not wanted.
///
/// # Errors
/// A massless motion that no loop equation constrains.
pub(crate) fn additions(
    mut mass: Vec<SparseRow>,
    loops: &BTreeMap<usize, SparseRow>,
) -> Result<Vec<(usize, f64)>, Undetermined> {
    let heaviest = (0..mass.len()).map(|i| diagonal(&mass, i)).fold(0.0, f64::max);
    let heaviest = if heaviest > 0.0 { heaviest } else { 1.0 };
    let mut added = Vec::new();
    let mut taken = BTreeSet::new();
    let mut accepted = BTreeSet::new();
    let by_column = by_column(loops);
    loop {
        let found = weak(&mass, heaviest, &accepted);
        if found.is_empty() {
            return Ok(added);
        }
        for (place, Weak { coordinate, motion, is_zero }) in found.into_iter().enumerate() {
            let touched: BTreeSet<usize> =
                motion.keys().filter_map(|column| by_column.get(column)).flatten().copied().collect();
            let fresh = touched.into_iter().filter(|index| !taken.contains(index));
            let best = fresh
                .map(|index| (index, &loops[&index], rate(&loops[&index], &motion)))
                .filter(|(.., rate)| *rate > 0.0)
                .max_by(|(.., a), (.., b)| a.total_cmp(b));
            match best {
                Some((index, row, _)) => {
                    let weight = weight(heaviest, row);
                    add(&mut mass, weight, row);
                    added.push((index, weight));
                    taken.insert(index);
                }
                // The equations just added may constrain it.
                None if place > 0 => {}
                None if is_zero => return Err(Undetermined(largest(&motion).unwrap_or(coordinate))),
                None => {
                    accepted.insert(coordinate);
                }
            }
        }
    }
}

/// The loop equations in which each coordinate occurs.
fn by_column(loops: &BTreeMap<usize, SparseRow>) -> BTreeMap<usize, Vec<usize>> {
    let mut by_column: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (&index, row) in loops {
        row.keys().for_each(|&column| by_column.entry(column).or_default().push(index));
    }
    by_column
}

struct Weak {
    coordinate: usize,
    motion: SparseRow,
    is_zero: bool,
}

/// Up to so many coordinates one poor pivot is treated in each factorisation; of more, all of them, or the factorisations would be too many.
const FEW: usize = 600;

/// The first poor pivots of a Cholesky factorisation in minimum degree order.
fn weak(mass: &[SparseRow], heaviest: f64, accepted: &BTreeSet<usize>) -> Vec<Weak> {
    let most = if mass.len() <= FEW { 1 } else { mass.len() };
    let mut found = Vec::new();
    let mut rows = mass.to_vec();
    let mut left: BTreeSet<(usize, usize)> =
        (0..rows.len()).filter(|&i| !rows[i].is_empty()).map(|i| (rows[i].len(), i)).collect();
    let mut steps: Vec<(usize, SparseRow)> = Vec::new();
    let mut followers = vec![Vec::new(); mass.len()];
    while let Some((_, index)) = left.pop_first() {
        let mut row = std::mem::take(&mut rows[index]);
        let mut pivot = row.remove(&index).unwrap_or_default();
        let inertia = diagonal(mass, index);
        let poor = inertia <= LIGHT * heaviest || pivot <= POOR * inertia;
        let is_zero = pivot <= ZERO * inertia.max(ZERO * heaviest);
        if (poor && !accepted.contains(&index)) || is_zero {
            found.push(Weak { coordinate: index, motion: motion(index, &steps, &followers), is_zero });
            if found.len() == most {
                return found;
            }
            // As it will be when a loop equation has been added.
            pivot += heaviest;
        }
        let below: SparseRow = row.iter().map(|(&other, entry)| (other, entry / pivot)).collect();
        for (&other, factor) in &below {
            left.remove(&(rows[other].len(), other));
            rows[other].remove(&index);
            for (&column, entry) in &row {
                *rows[other].entry(column).or_default() -= factor * entry;
            }
            left.insert((rows[other].len(), other));
        }
        below.keys().for_each(|&other| followers[other].push(steps.len()));
        steps.push((index, below));
    }
    found
}

/// The motion of one coordinate at rate 1 with which the eliminated ones go so as to move the least mass. `followers`: the steps in which a
/// coordinate was left, from which the eliminated one follows.
fn motion(index: usize, steps: &[(usize, SparseRow)], followers: &[Vec<usize>]) -> SparseRow {
    let mut motion = SparseRow::from([(index, 1.0)]);
    let mut due: BTreeSet<usize> = followers[index].iter().copied().collect();
    while let Some(last) = due.pop_last() {
        let (eliminated, below) = &steps[last];
        let rate: f64 =
            below.iter().map(|(other, factor)| -factor * motion.get(other).copied().unwrap_or_default()).sum();
        if rate != 0.0 {
            motion.insert(*eliminated, rate);
            due.extend(&followers[*eliminated]);
        }
    }
    motion
}

/// How fast a loop equation of unit length opens with a motion; 0 if it stays closed.
fn rate(row: &SparseRow, motion: &SparseRow) -> f64 {
    let terms = || row.iter().map(|(index, entry)| entry * motion.get(index).copied().unwrap_or_default());
    let (sum, size) = (terms().sum::<f64>().abs(), terms().map(f64::abs).sum::<f64>());
    let length = row.values().map(|entry| entry * entry).sum::<f64>().sqrt();
    if sum > CONSTRAINS * size { sum / length } else { 0.0 }
}

/// A power of two that makes the row's share of the mass as large as the largest mass.
fn weight(heaviest: f64, row: &SparseRow) -> f64 {
    let largest = row.values().map(|entry| entry * entry).fold(0.0, f64::max);
    (heaviest / largest).log2().round().exp2()
}

fn add(mass: &mut [SparseRow], weight: f64, row: &SparseRow) {
    for (&i, a) in row {
        for (&j, b) in row {
            *mass[i].entry(j).or_default() += weight * a * b;
        }
    }
}

fn diagonal(mass: &[SparseRow], index: usize) -> f64 {
    mass[index].get(&index).copied().unwrap_or_default()
}

fn largest(motion: &SparseRow) -> Option<usize> {
    motion.iter().max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs())).map(|(&index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(dense: &[&[f64]]) -> Vec<SparseRow> {
        dense.iter().map(|row| row.iter().copied().enumerate().filter(|(_, x)| *x != 0.0).collect()).collect()
    }

    fn loops(dense: &[&[f64]]) -> BTreeMap<usize, SparseRow> {
        rows(dense).into_iter().enumerate().collect()
    }

    #[test]
    fn nothing_is_added_to_a_definite_mass_matrix() {
        assert_eq!(additions(rows(&[&[2.0, 1.0], &[1.0, 2.0]]), &loops(&[&[1.0, 1.0]])), Ok(vec![]));
    }

    /// Only the sum of both rates moves mass; the first equation does not constrain their difference.
    #[test]
    fn the_equation_that_constrains_the_massless_motion_is_added() {
        let mass = rows(&[&[1.0, 1.0], &[1.0, 1.0]]);
        assert_eq!(additions(mass, &loops(&[&[3.0, 3.0], &[2.0, 0.0]])), Ok(vec![(1, 0.25)]));
    }

    #[test]
    fn a_massless_motion_that_is_not_constrained_is_undetermined() {
        let mass = rows(&[&[4.0, 2.0], &[2.0, 1.0]]);
        assert_eq!(additions(mass, &loops(&[&[6.0, 3.0]])), Err(Undetermined(1)));
    }

    #[test]
    fn light_coordinates_stay_if_they_are_not_constrained() {
        assert_eq!(additions(rows(&[&[1.0, 0.0], &[0.0, 1e-9]]), &loops(&[&[1.0, 0.0]])), Ok(vec![]));
        assert_eq!(additions(rows(&[&[1.0, 0.0], &[0.0, 1e-9]]), &loops(&[&[1.0, 1.0]])), Ok(vec![(0, 1.0)]));
    }
}
