//! The linear system whose solution is the motion: \[M J^T; J 0\] {a; lambda} = {Q; gamma}, in the branch coordinates or in those of
//! a second pair of trees.

use cotree_fmu::model::State;

use super::eliminate::{self, Factorisation, Obstacle};
use crate::equations::Equations;
use crate::expr::{Arena, Expr, Order, Symbol, Values};

/// A system of equations of motion in some coordinates, and how the branch coordinates follow from its solution.
#[derive(Clone, Debug)]
pub struct MotionSystem {
    /// \[M\] by rows.
    pub mass: Vec<Vec<(usize, Expr)>>,
    /// {Q}
    pub load: Vec<Expr>,
    pub rows: Vec<LoopRow>,
    pub scales: Vec<f64>,
    pub branches: Vec<Branch>,
}

#[derive(Clone, Debug)]
pub struct LoopRow {
    /// Its row of \[Phi_q\].
    pub jacobian: Vec<(usize, Expr)>,
    /// Its gamma (Eq. 21).
    pub gamma: Expr,
    /// The same loop equation in branch coordinates; the others are identities there.
    pub branch: Option<usize>,
    /// The entry of its multiplier on the diagonal.
    pub diagonal: Expr,
}

/// Acceleration of a branch coordinate: a sum over the system's accelerations, and a rest.
#[derive(Clone, Debug)]
pub struct Branch {
    /// (coordinate of the system, coefficient)
    pub terms: Vec<(usize, Expr)>,
    pub rest: Expr,
}

#[derive(Clone, Debug)]
pub struct MotionSolver {
    system: MotionSystem,
    factor: Factorisation,
}

impl MotionSystem {
    /// The equations in branch coordinates themselves (Eq. 22).
    pub fn in_branch_coordinates(equations: &mut Equations, length: f64) -> Self {
        let dynamics = equations.dynamics();
        let (mass, load) = (dynamics.mass.clone(), dynamics.load.clone());
        let arena = &mut equations.system.arena;
        let imposed = equations.constraints.iter().enumerate().filter(|(_, row)| row.is_imposed());
        let rows = imposed.map(|(index, row)| LoopRow {
            jacobian: row.jacobian.clone(),
            gamma: row.gamma,
            branch: Some(index),
            diagonal: row.multiplier_diagonal(arena),
        });
        let rows = rows.collect();
        let itself = |index: usize| Branch { terms: vec![(index, Expr::ONE)], rest: Expr::ZERO };
        MotionSystem {
            scales: scales(equations, length),
            rows,
            branches: (0..load.len()).map(itself).collect(),
            mass,
            load,
        }
    }

    /// Orders and factorises.
    ///
    /// # Errors
    /// A coordinate of the system moves no mass and is not constrained.
    pub fn factorise(self, equations: &mut Equations, pose: &State) -> Result<MotionSolver, Obstacle> {
        let values = typical(pose);
        let jacobian: Vec<Vec<(usize, Expr)>> = self.rows.iter().map(|row| row.jacobian.clone()).collect();
        let diagonal: Vec<Expr> = self.rows.iter().map(|row| row.diagonal).collect();
        let matrix = eliminate::EliminationSystem {
            mass: &self.mass,
            jacobian: &jacobian,
            diagonal: &diagonal,
            scales: &self.scales,
            values: &values,
        };
        let factor = Factorisation::new(&mut equations.system.arena, &matrix)?;
        Ok(MotionSolver { system: self, factor })
    }
}

/// Values of symbols in the pose of a state and at rest. Missing masses count as 1: whether they are needed is checked later.
pub(crate) fn typical(pose: &State) -> impl Fn(Symbol) -> f64 + '_ {
    move |symbol| match symbol {
        Symbol::Missing(..) => 1.0,
        Symbol::Coordinate(_, Order::Velocity) | Symbol::Follower(_, Order::Velocity) => 0.0,
        Symbol::Input(_, Order::Velocity | Order::Acceleration) => 0.0,
        Symbol::Time
        | Symbol::Parameter(_)
        | Symbol::Discrete(_)
        | Symbol::Input(..)
        | Symbol::Coordinate(..)
        | Symbol::Follower(..)
        | Symbol::State(..)
        | Symbol::Reaction(_)
        | Symbol::Argument => pose.value(symbol),
    }
}

/// A unit mass on each coordinate, by rows: where no mass matters to a solution.
pub(crate) fn unit_masses(arena: &mut Arena, scales: &[f64]) -> Vec<Vec<(usize, Expr)>> {
    let unit = |(index, scale): (usize, &f64)| vec![(index, arena.constant(1.0 / (scale * scale)))];
    scales.iter().enumerate().map(unit).collect()
}

pub fn scales(equations: &Equations, length: f64) -> Vec<f64> {
    equations.coordinates.iter().map(|coordinate| if coordinate.angular { 1.0 } else { length }).collect()
}

impl MotionSolver {
    /// Accelerations of the branch coordinates, then the reactions of their loop equations: zero where not active.
    pub fn motion(&self, arena: &mut Arena, constraints: usize) -> Vec<Expr> {
        let mut right = self.system.load.clone();
        right.extend(self.system.rows.iter().map(|row| row.gamma));
        self.results(arena, &right, constraints, true)
    }

    /// What follows from a right-hand side for the branch coordinates and their loop equations, with the rests of accelerations or without.
    fn results(&self, arena: &mut Arena, right: &[Expr], constraints: usize, rests: bool) -> Vec<Expr> {
        let solution = self.factor.solve(arena, right);
        let rest = |branch: &Branch| if rests { branch.rest } else { Expr::ZERO };
        let mut results: Vec<Expr> =
            self.system.branches.iter().map(|branch| branch.value(arena, &solution, rest(branch))).collect();
        let mut reactions = vec![Expr::ZERO; constraints];
        for (row, &reaction) in self.system.rows.iter().zip(&solution[self.system.load.len()..]) {
            if let Some(index) = row.branch {
                reactions[index] = reaction;
            }
        }
        results.extend(reactions);
        results
    }

    /// What loads of the coordinates alone add to the accelerations and to the reactions of all loop equations.
    pub fn response(&self, arena: &mut Arena, loads: &[Expr], constraints: usize) -> Vec<Expr> {
        let mut right = loads.to_vec();
        right.resize(self.system.load.len() + self.system.rows.len(), Expr::ZERO);
        self.results(arena, &right, constraints, false)
    }

    /// Reciprocal pivots of the loop equations: they grow towards a singular configuration.
    pub fn reciprocal_pivots(&self, arena: &mut Arena) -> Vec<Expr> {
        self.factor.reciprocal_pivots(arena, self.system.load.len())
    }

    /// The size of the row of each reciprocal pivot before elimination.
    pub fn row_sizes(&self, arena: &mut Arena) -> Vec<Expr> {
        self.factor.row_sizes(arena, self.system.load.len())
    }

    /// Impulses: the change of the rates of branch coordinates, of least kinetic energy, that changes the rate of each loop equation by minus what is asked, and the multipliers of all loop equations.
    pub fn impact(&self, arena: &mut Arena, requested: &[Expr]) -> Vec<Expr> {
        let mut right = vec![Expr::ZERO; self.system.load.len()];
        right.extend(self.system.rows.iter().map(|row| {
            let requested = row.branch.map_or(Expr::ZERO, |index| arena.negate(requested[index]));
            // What is open is not asked for anything.
            if row.diagonal == Expr::ZERO {
                return requested;
            }
            let closed = arena.add(row.diagonal, Expr::ONE);
            arena.multiply(closed, requested)
        }));
        self.results(arena, &right, requested.len(), false)
    }

    /// Projection onto the loop equations: the correction of the branch coordinates of least norm in the mass metric that cancels the residuals.
    pub fn projection(&self, arena: &mut Arena, residuals: &[Expr]) -> Vec<Expr> {
        let mut right = vec![Expr::ZERO; self.system.load.len()];
        for row in &self.system.rows {
            right.push(row.branch.map_or(Expr::ZERO, |index| arena.negate(residuals[index])));
        }
        let solution = self.factor.solve(arena, &right);
        self.system.branches.iter().map(|branch| branch.value(arena, &solution, Expr::ZERO)).collect()
    }
}

impl Branch {
    fn value(&self, arena: &mut Arena, solution: &[Expr], rest: Expr) -> Expr {
        self.terms.iter().fold(rest, |sum, &(index, coefficient)| {
            let term = arena.multiply(coefficient, solution[index]);
            arena.add(sum, term)
        })
    }
}
