//! The equations at the start: values of expressions, accelerations and multipliers.

use cotree::equations::{Equations, Level};
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
    pub discrete: Vec<f64>,
    pub inputs: Vec<f64>,
    pub followers: [Vec<f64>; 2],
    pub positions: Vec<f64>,
    pub rates: Vec<f64>,
    pub states: Vec<f64>,
    pub accelerations: Vec<f64>,
    /// By the index of the loop equation.
    pub reactions: Vec<f64>,
}

/// The levels of friction are known after so many passes, or not found.
const PASSES: usize = 500;

impl Values for Moment {
    fn value(&self, symbol: Symbol) -> f64 {
        let of = |list: &[f64], index: usize| list.get(index).copied().unwrap_or(0.0);
        match symbol {
            Symbol::Time => self.time,
            Symbol::Parameter(i) => of(&self.parameters, i),
            Symbol::Discrete(i) => of(&self.discrete, i),
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
            discrete: state.discrete().to_vec(),
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

    /// Accelerations and multipliers of \[M Phi_q^T; Phi_q D\], without loop equations that repeat others, where D makes the multiplier of what is open zero; none where it is singular. The
    /// levels of friction follow from the solution, and the solution from them: one after the other, until nothing changes.
    pub fn solve(&mut self, equations: &mut Equations) -> Option<()> {
        let (n, dynamics) = (equations.coordinates.len(), equations.dynamics().clone());
        let rows: Vec<usize> = equations.loops().filter(|(_, row)| !row.repeats()).map(|(index, _)| index).collect();
        if n + rows.len() == 0 {
            self.reactions = vec![0.0; equations.constraints.len()];
            return Some(());
        }
        let mass = dense(&dynamics.mass, n, |exprs| self.of(equations, exprs));
        let jacobian = self.jacobian(equations, &rows);
        let mut matrix = saddle(&mass, &jacobian.transpose(), &jacobian);
        let arena = &mut equations.system.arena;
        let open: Vec<Expr> = rows.iter().map(|&row| equations.constraints[row].multiplier_diagonal(arena)).collect();
        for (place, entry) in self.of(equations, &open).into_iter().enumerate() {
            matrix[(n + place, n + place)] += entry;
        }
        let matrix = matrix.lu();
        let gammas = rows.iter().map(|&row| equations.constraints[row].gamma);
        let right: Vec<Expr> = dynamics.load.into_iter().chain(gammas).collect();
        let right = DVector::from_vec(self.of(equations, &right));
        let columns = dense(&dynamics.reactions, equations.constraints.len(), |exprs| self.of(equations, exprs));
        let levels: Vec<Level> = equations.levels().into_iter().map(|(_, level)| level).collect();
        let mut sizes = vec![0.0; levels.len()];
        for _ in 0..PASSES {
            let mut right = right.clone();
            for (level, size) in levels.iter().zip(&sizes) {
                (0..n).for_each(|row| right[row] -= columns[(row, level.row)] * size);
            }
            let solution = matrix.solve(&right).filter(|solution| solution.iter().all(|value| value.is_finite()))?;
            self.accelerations = solution.rows(0, n).iter().copied().collect();
            self.reactions = vec![0.0; equations.constraints.len()];
            rows.iter().enumerate().for_each(|(place, &row)| self.reactions[row] = solution[n + place]);
            levels.iter().zip(&sizes).for_each(|(level, &size)| self.reactions[level.row] = size);
            let next: Vec<f64> = levels.iter().map(|level| self.level(equations, level)).collect();
            let off = next.iter().zip(&sizes).fold(0.0_f64, |most, (next, size)| most.max((next - size).abs()));
            if off <= 1e-12 * next.iter().fold(0.0_f64, |most, value| most.max(value.abs())) {
                return Some(());
            }
            sizes = next;
        }
        None
    }

    /// The level of friction by its law.
    fn level(&self, equations: &Equations, level: &Level) -> f64 {
        let [free, share] = self.of(equations, &[level.free, level.share])[..] else { return f64::NAN };
        let sums = self.of(equations, &level.pressing.sums());
        free + share * level.pressing.size(&sums)
    }
}

impl Lesson<'_> {
    pub fn start(&self) -> Moment {
        self.in_mode(Moment::new(&self.equations.system.mechanism, &self.source.state))
    }

    /// The same with the modes in which the motion begins.
    pub fn in_mode(&self, mut moment: Moment) -> Moment {
        if let Some(modes) = self.modes.as_ref().ok().filter(|modes| !modes.is_empty()) {
            moment.discrete.clone_from(modes);
        }
        moment
    }

    /// The start with other rates and everything closed, so that nothing vanishes because it is at rest or open.
    pub fn moving(&self) -> Moment {
        let mut values = self.start();
        let mechanism = &self.equations.system.mechanism;
        let closed = mechanism.contacts.iter().map(|contact| contact.state.closed);
        let engaged = mechanism.engaging.iter().map(|engaging| engaging.engaged);
        let set = mechanism.set_rates.iter().map(|set| set.now);
        closed.chain(engaged).chain(set).for_each(|holds| values.discrete[holds.0] = 1.0);
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
