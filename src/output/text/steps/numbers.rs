//! The equations at the start: values of expressions, accelerations and multipliers.

use nalgebra::{DMatrix, DVector};

use super::Lesson;
use crate::equations::Equations;
use crate::expr::{Expr, Order, Symbol};
use crate::mechanism::Mechanism;
use cotree_fmu::model::State;

/// Where values come from: a state, other rates than its own if there are any, and what has been solved for.
#[derive(Clone, Debug, Default)]
pub struct Values {
    pub time: f64,
    pub parameters: Vec<f64>,
    pub inputs: Vec<f64>,
    pub followers: [Vec<f64>; 2],
    pub positions: Vec<f64>,
    pub rates: Vec<f64>,
    pub accelerations: Vec<f64>,
    /// By the index of the loop equation.
    pub reactions: Vec<f64>,
}

impl Values {
    /// Those of a state, for a mechanism with further parameters.
    pub fn new(mechanism: &Mechanism, state: &State) -> Values {
        Values {
            time: state.time(),
            parameters: mechanism.parameter_values(),
            inputs: state.inputs().to_vec(),
            followers: [state.follower_positions().to_vec(), state.follower_rates().to_vec()],
            positions: state.positions().to_vec(),
            rates: state.rates().to_vec(),
            ..Values::default()
        }
    }

    fn value(&self, symbol: Symbol) -> f64 {
        let of = |list: &[f64], index: usize| list.get(index).copied().unwrap_or(0.0);
        match symbol {
            Symbol::Time => self.time,
            Symbol::Parameter(i) => of(&self.parameters, i),
            Symbol::Input(i, Order::Position) => of(&self.inputs, i),
            Symbol::Follower(i, Order::Position) => of(&self.followers[0], i),
            Symbol::Follower(i, Order::Velocity) => of(&self.followers[1], i),
            Symbol::Coordinate(i, Order::Position) => of(&self.positions, i),
            Symbol::Coordinate(i, Order::Velocity) => of(&self.rates, i),
            Symbol::Coordinate(i, Order::Acceleration) => of(&self.accelerations, i),
            Symbol::Reaction(i) => of(&self.reactions, i),
            Symbol::Input(..) | Symbol::Follower(..) | Symbol::Missing(..) | Symbol::Argument => 0.0,
        }
    }

    pub fn of(&self, equations: &Equations, exprs: &[Expr]) -> Vec<f64> {
        equations.system.arena.evaluate(exprs, &|symbol| self.value(symbol))
    }

    /// Accelerations and multipliers of \[M Phi_q^T; Phi_q 0\], without loop equations that repeat others; none where it is singular.
    pub fn solve(&mut self, equations: &mut Equations) -> Option<()> {
        let (n, dynamics) = (equations.coordinates.len(), equations.dynamics().clone());
        let rows: Vec<usize> = equations.loops().filter(|(_, row)| !row.repeats).map(|(index, _)| index).collect();
        let m = rows.len();
        if n + m == 0 {
            self.reactions = vec![0.0; equations.constraints.len()];
            return Some(());
        }
        let mut matrix = DMatrix::zeros(n + m, n + m);
        for (row, entries) in dynamics.mass.iter().enumerate() {
            let values = self.of(equations, &entries.iter().map(|(_, entry)| *entry).collect::<Vec<_>>());
            entries.iter().zip(values).for_each(|((column, _), value)| matrix[(row, *column)] = value);
        }
        let mut right = DVector::zeros(n + m);
        right.rows_mut(0, n).copy_from_slice(&self.of(equations, &dynamics.load));
        for (place, &row) in rows.iter().enumerate() {
            let constraint = equations.constraints[row].clone();
            let values = self.of(equations, &constraint.jacobian.iter().map(|(_, entry)| *entry).collect::<Vec<_>>());
            for ((column, _), value) in constraint.jacobian.iter().zip(values) {
                matrix[(n + place, *column)] = value;
                matrix[(*column, n + place)] = value;
            }
            right[n + place] = self.of(equations, &[constraint.gamma])[0];
        }
        let solution = matrix.lu().solve(&right).filter(|solution| solution.iter().all(|value| value.is_finite()))?;
        self.accelerations = solution.rows(0, n).iter().copied().collect();
        self.reactions = vec![0.0; equations.constraints.len()];
        rows.iter().enumerate().for_each(|(place, &row)| self.reactions[row] = solution[n + place]);
        Some(())
    }
}

impl Lesson<'_, '_, '_> {
    pub fn start(&self) -> Values {
        Values::new(self.equations.system.mechanism, &self.source.state)
    }

    /// The start with other rates, so that nothing vanishes because it is at rest.
    pub fn moving(&self) -> Values {
        let mut values = self.start();
        values.rates = (0..values.rates.len()).map(|index| 1.3 + 0.7 * (2.1 * index as f64).sin()).collect();
        values
    }

    pub fn at_start(&self, exprs: &[Expr]) -> Vec<f64> {
        self.start().of(&self.equations, exprs)
    }
}

/// Do two columns agree, relative to the larger of their entries?
pub fn agree(a: &[f64], b: &[f64]) -> bool {
    let size = a.iter().chain(b).fold(1e-9_f64, |size, value| size.max(value.abs()));
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-7 * size)
}

/// Six digits.
pub fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
