//! The equations at the start: values of expressions, accelerations and multipliers.

use cotree::equations::Equations;
use cotree::expr::{Expr, Order, Symbol, Values};
use cotree::model::Mechanism;
use cotree_fmu::model::State;
use cotree_study::analysis::{dense, saddle};
use nalgebra::{DMatrix, DVector};

use super::Lesson;

/// A moment of the motion, where the values of symbols come from: a state, or one with other rates, and what has been solved for.
#[derive(Clone, Debug, Default)]
pub struct Moment {
    pub time: f64,
    pub parameters: Vec<f64>,
    pub inputs: Vec<f64>,
    pub followers: [Vec<f64>; 2],
    pub positions: Vec<f64>,
    pub rates: Vec<f64>,
    pub states: Vec<f64>,
    pub accelerations: Vec<f64>,
    /// By the index of the loop equation.
    pub reactions: Vec<f64>,
}

impl Values for Moment {
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
            Symbol::State(i, Order::Position) => of(&self.states, i),
            Symbol::Input(..) | Symbol::Follower(..) | Symbol::State(..) => 0.0,
            Symbol::Missing(..) | Symbol::Argument => 0.0,
        }
    }
}

impl Moment {
    /// Those of a state, for a mechanism with further parameters.
    pub fn new(mechanism: &Mechanism, state: &State) -> Moment {
        Moment {
            time: state.time(),
            parameters: mechanism.parameter_values(),
            inputs: state.inputs().to_vec(),
            followers: [state.follower_positions().to_vec(), state.follower_rates().to_vec()],
            positions: state.positions().to_vec(),
            rates: state.rates().to_vec(),
            states: state.states().to_vec(),
            ..Moment::default()
        }
    }

    pub fn of(&self, equations: &Equations, exprs: &[Expr]) -> Vec<f64> {
        equations.system.arena.evaluate(exprs, self)
    }

    /// Some rows of Phi_q.
    pub fn jacobian(&self, equations: &Equations, rows: &[usize]) -> DMatrix<f64> {
        let rows = rows.iter().map(|&row| &equations.constraints[row].jacobian);
        dense(rows, equations.coordinates.len(), |exprs| self.of(equations, exprs))
    }

    /// Accelerations and multipliers of \[M Phi_q^T; Phi_q 0\], without loop equations that repeat others; none where it is singular.
    pub fn solve(&mut self, equations: &mut Equations) -> Option<()> {
        let (n, dynamics) = (equations.coordinates.len(), equations.dynamics().clone());
        let rows: Vec<usize> = equations.loops().filter(|(_, row)| !row.repeats()).map(|(index, _)| index).collect();
        if n + rows.len() == 0 {
            self.reactions = vec![0.0; equations.constraints.len()];
            return Some(());
        }
        let mass = dense(&dynamics.mass, n, |exprs| self.of(equations, exprs));
        let jacobian = self.jacobian(equations, &rows);
        let matrix = saddle(&mass, &jacobian.transpose(), &jacobian);
        let gammas = rows.iter().map(|&row| equations.constraints[row].gamma);
        let right: Vec<Expr> = dynamics.load.into_iter().chain(gammas).collect();
        let right = DVector::from_vec(self.of(equations, &right));
        let solution = matrix.lu().solve(&right).filter(|solution| solution.iter().all(|value| value.is_finite()))?;
        self.accelerations = solution.rows(0, n).iter().copied().collect();
        self.reactions = vec![0.0; equations.constraints.len()];
        rows.iter().enumerate().for_each(|(place, &row)| self.reactions[row] = solution[n + place]);
        Some(())
    }
}

impl Lesson<'_> {
    pub fn start(&self) -> Moment {
        Moment::new(&self.equations.system.mechanism, &self.source.state)
    }

    /// The start with other rates, so that nothing vanishes because it is at rest.
    pub fn moving(&self) -> Moment {
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
