//! An estimate of the cost of trees from the sparsity pattern of their equations.

use std::collections::BTreeSet;

use crate::equations::Equations;
use crate::mechanism::BodyId;

/// Operations of forming and eliminating the equations of motion, about.
pub fn estimate(equations: &mut Equations) -> usize {
    let coordinates = equations.coordinates.len();
    let mut pattern = vec![BTreeSet::new(); coordinates];
    let mut forming = 0;
    for body in 0..equations.system.mechanism.bodies.len() {
        let moving = equations.moved_by(BodyId(body));
        forming += 6 * moving.len();
        for &row in &moving {
            pattern[row].extend(moving.iter().copied());
        }
    }
    forming += 8 * pattern.iter().map(BTreeSet::len).sum::<usize>();
    let rows: Vec<Vec<usize>> = (equations.constraints.iter())
        .map(|constraint| constraint.jacobian.iter().map(|(column, _)| *column).collect())
        .collect();
    for row in &rows {
        forming += 8 * row.len();
        let index = pattern.len();
        pattern.push(row.iter().copied().collect());
        row.iter().for_each(|&column| {
            pattern[column].insert(index);
        });
    }
    forming + elimination(pattern, &rows, coordinates)
}

/// Operations of a symmetric elimination, a multiplier only after its coordinates.
fn elimination(mut pattern: Vec<BTreeSet<usize>>, rows: &[Vec<usize>], coordinates: usize) -> usize {
    let mut left: BTreeSet<usize> = (0..pattern.len()).collect();
    let mut operations = 0;
    loop {
        let safe =
            |index: usize| index < coordinates || rows[index - coordinates].iter().all(|column| !left.contains(column));
        let next = left.iter().copied().filter(|&index| safe(index)).min_by_key(|&index| (pattern[index].len(), index));
        let Some(index) = next else { return operations };
        left.remove(&index);
        let mut beside = std::mem::take(&mut pattern[index]);
        beside.remove(&index);
        operations += 8 + beside.len() * (beside.len() + 6);
        for &row in &beside {
            pattern[row].remove(&index);
            pattern[row].extend(beside.iter().copied());
        }
    }
}
