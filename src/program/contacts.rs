//! What is held on one side only: the kernels by which the runtime opens and closes it.

use cotree_fmu::program::{Contact, Contacts};
use cotree_fmu::tape::Tape;

use crate::equations::Equations;
use crate::expr::{Arena, Expr, Order, Symbol};
use crate::solve::Solver;

/// The expressions behind [`Contacts`].
#[derive(Clone, Debug, Default)]
pub(super) struct ContactKernels {
    pub gaps: Vec<Expr>,
    pub rates: Vec<Expr>,
    pub accelerations: Vec<Expr>,
    pub restitutions: Vec<Expr>,
    pub impact: Vec<Expr>,
}

impl ContactKernels {
    /// The kernels of a mechanism that moves freely; `solver` has the factors of its equations of motion.
    pub fn new(equations: &mut Equations, solver: &Solver) -> Self {
        let mut kernels = Self::default();
        let mechanism = equations.system.mechanism.clone();
        for (index, own) in mechanism.unilaterals.iter().enumerate() {
            let row = equations.row_of_unilateral(index).map(|row| equations.constraints[row].clone());
            let Some(gap) = row.and_then(|row| row.one_sided) else { continue };
            let arena = &mut equations.system.arena;
            let minus = arena.negate(gap.gamma);
            kernels.gaps.push(gap.value);
            kernels.rates.push(along(arena, &gap.jacobian, Order::Velocity, gap.time_rate));
            kernels.accelerations.push(along(arena, &gap.jacobian, Order::Acceleration, minus));
            kernels.restitutions.push(equations.system.value(&own.held.restitution));
        }
        if !kernels.gaps.is_empty() {
            let arena = &mut equations.system.arena;
            let asked: Vec<Expr> =
                (0..equations.constraints.len()).map(|row| arena.symbol(Symbol::Reaction(row))).collect();
            kernels.impact = solver.impact(arena, &asked);
        }
        kernels
    }

    /// With the tapes of its kernels.
    pub fn lower(
        equations: &Equations,
        [gaps, rates, accelerations, restitutions, impact]: [Tape; 5],
    ) -> Option<Contacts> {
        let all = equations.system.mechanism.unilaterals.iter().enumerate().filter_map(|(index, own)| {
            let constraint = equations.row_of_unilateral(index)? as u32;
            let caught = own.caught.map(|caught| caught.0 as u32);
            Some(Contact { name: own.name.clone(), constraint, closed: own.closed.0 as u32, caught })
        });
        let all: Vec<Contact> = all.collect();
        let contacts = Contacts { all, gaps, rates, accelerations, restitutions, impact };
        (contacts.gaps.results.len() == contacts.all.len() && !contacts.all.is_empty()).then_some(contacts)
    }
}

/// The sum of a row times a derivative of the coordinates, and a rest.
fn along(arena: &mut Arena, row: &[(usize, Expr)], order: Order, rest: Expr) -> Expr {
    row.iter().fold(rest, |sum, &(column, entry)| {
        let derivative = arena.symbol(Symbol::Coordinate(column, order));
        arena.add_product(sum, entry, derivative)
    })
}
