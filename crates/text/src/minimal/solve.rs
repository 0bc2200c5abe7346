//! Rates and accelerations of dependent coordinates by those of the independent ones: symbolic elimination of Phi_q.

use cotree::equations::Equations;
use cotree::expr::Expr;
use cotree_study::analysis::independent_columns;

use crate::steps::Moment;

/// v_u = R v_w + r, a_u = R a_w + g, in the order of the dependent coordinates.
pub struct Solved {
    pub independent: Vec<usize>,
    pub dependent: Vec<usize>,
    /// R, by dependent coordinates.
    ratios: Vec<Vec<Expr>>,
    pub rates: Vec<Expr>,
    pub accelerations: Vec<Expr>,
}

impl Solved {
    /// How a coordinate's rate changes with that of an independent coordinate.
    pub fn ratio(&self, column: usize, place: usize) -> Expr {
        match self.dependent.iter().position(|other| *other == column) {
            Some(row) => self.ratios[row][place],
            None if self.independent[place] == column => Expr::ONE,
            None => Expr::ZERO,
        }
    }

    /// A coordinate's acceleration while the independent ones have none.
    pub fn acceleration(&self, column: usize) -> Expr {
        self.dependent.iter().position(|other| *other == column).map_or(Expr::ZERO, |row| self.accelerations[row])
    }
}

/// An augmented row: its coefficients by dependent coordinates, its right sides, and the former's values.
struct AugmentedRow {
    left: Vec<Expr>,
    right: Vec<Expr>,
    values: Vec<f64>,
}

/// The loops determine no choice of coordinates at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the loops do not determine the dependent coordinates at the start: it is a singular configuration")]
pub struct SingularStart;

/// Solves the loop equations `rows`.
///
/// # Errors
/// The loops determine no choice of coordinates at the start.
pub fn solve(equations: &mut Equations, start: &Moment, rows: &[usize]) -> Result<Solved, SingularStart> {
    let jacobian = start.jacobian(equations, rows);
    let (independent, dependent) = independent_columns(&jacobian).ok_or(SingularStart)?;
    let mut system: Vec<AugmentedRow> = rows
        .iter()
        .zip(jacobian.row_iter())
        .map(|(&index, numbers)| {
            let constraint = equations.constraints[index].clone();
            let entry = |column: &usize| {
                constraint.jacobian.iter().find(|(at, _)| at == column).map_or(Expr::ZERO, |(_, e)| *e)
            };
            let arena = &mut equations.system.arena;
            let mut right: Vec<Expr> = independent.iter().map(|column| arena.negate(entry(column))).collect();
            right.extend([arena.negate(constraint.time_rate), constraint.gamma]);
            AugmentedRow {
                left: dependent.iter().map(entry).collect(),
                right,
                values: dependent.iter().map(|&column| numbers[column]).collect(),
            }
        })
        .collect();
    let order = eliminate(equations, start, &mut system);
    let mut columns: Vec<Vec<Expr>> = vec![Vec::new(); dependent.len()];
    for (row, column) in order {
        columns[column].clone_from(&system[row].right);
    }
    let count = independent.len();
    Ok(Solved {
        rates: columns.iter().map(|right| right[count]).collect(),
        accelerations: columns.iter().map(|right| right[count + 1]).collect(),
        ratios: columns.into_iter().map(|right| right[..count].to_vec()).collect(),
        independent,
        dependent,
    })
}

/// Gauss-Jordan elimination: pivots with few other entries in their row and column come first. Returns rows with their columns.
fn eliminate(equations: &mut Equations, start: &Moment, system: &mut [AugmentedRow]) -> Vec<(usize, usize)> {
    let mut order: Vec<(usize, usize)> = Vec::new();
    while let Some((row, column)) = pivot(system, &order) {
        let arena = &mut equations.system.arena;
        let divisor = system[row].left[column];
        for entry in system[row].left.iter_mut().chain(&mut system[row].right) {
            *entry = arena.divide(*entry, divisor);
        }
        system[row].left[column] = Expr::ONE;
        let (left, right) = (system[row].left.clone(), system[row].right.clone());
        for other in (0..system.len()).filter(|other| *other != row) {
            let factor = system[other].left[column];
            if factor == Expr::ZERO {
                continue;
            }
            let lower = &mut system[other];
            for (entry, above) in lower.left.iter_mut().zip(&left).chain(lower.right.iter_mut().zip(&right)) {
                *entry = arena.subtract_product(*entry, factor, *above);
            }
            lower.left[column] = Expr::ZERO;
        }
        order.push((row, column));
        for row in system.iter_mut() {
            row.values = start.of(equations, &row.left);
        }
    }
    order
}

fn pivot(system: &[AugmentedRow], order: &[(usize, usize)]) -> Option<(usize, usize)> {
    let is_free = |row: usize, column: usize| !order.iter().any(|&(r, c)| r == row || c == column);
    let others = |row: usize, column: usize| {
        let across = system[row].left.iter().filter(|entry| **entry != Expr::ZERO).count() - 1;
        let down = system.iter().filter(|row| row.left[column] != Expr::ZERO).count() - 1;
        across * down
    };
    let free = (0..system.len()).flat_map(|row| (0..system[row].left.len()).map(move |column| (row, column)));
    let free: Vec<(usize, usize)> = free
        .filter(|&(row, column)| is_free(row, column) && system[row].left[column] != Expr::ZERO)
        .filter(|&(row, column)| system[row].values[column] != 0.0)
        .collect();
    let largest = free.iter().map(|&(row, column)| system[row].values[column].abs()).fold(0.0, f64::max);
    let good = free.into_iter().filter(|&(row, column)| system[row].values[column].abs() >= 0.01 * largest);
    good.min_by_key(|&(row, column)| others(row, column))
}
