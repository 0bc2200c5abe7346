//! What is held on one side only: the kernels by which the runtime opens and closes it.

use cotree_fmu::program::{self, Contact, Contacts, Slip};
use cotree_fmu::tape::Tape;

use crate::equations::Equations;
use crate::expr::{Arena, Expr, Order, Symbol};
use crate::model::{ContactState, DiscreteId, Formula};
use crate::solve::{Levels, MotionSolver};

/// The expressions behind [`Contacts`].
#[derive(Clone, Debug, Default)]
pub(super) struct ContactKernels {
    pub gaps: Vec<Expr>,
    pub rates: Vec<Expr>,
    pub accelerations: Vec<Expr>,
    pub restitutions: Vec<Expr>,
    pub impact: Vec<Expr>,
    pub pressing: Vec<Expr>,
    pub locks: Vec<Expr>,
}

/// A gap, its rate and its second derivative until an event removes what holds it. From then on the gap is 1 and never closes; what is `held_anywhere`, friction and freewheels, has no gap but a rate:
/// that is 1, as if it slipped or ran free for ever.
fn while_there(arena: &mut Arena, there: Expr, motion: [Expr; 3], held_anywhere: bool) -> [Expr; 3] {
    let gone = arena.subtract(Expr::ONE, there);
    let [gap, rate, acceleration] = motion.map(|motion| arena.multiply(there, motion));
    let (gap, rate) = match held_anywhere {
        true => (gap, arena.add(rate, gone)),
        false => (arena.add(gap, gone), rate),
    };
    [gap, rate, acceleration]
}

/// The discrete variables of a contact as the program names them.
fn state(state: &ContactState) -> program::ContactState {
    let place = |id: DiscreteId| id.0 as u32;
    program::ContactState {
        closed: place(state.closed),
        impulse: place(state.impulse),
        place: state.place.map(place),
        direction: state.direction.map(place),
        signs: state.signs.iter().copied().map(place).collect(),
    }
}

impl ContactKernels {
    /// The kernels of a mechanism that moves freely; `solver` has the factors of its equations of motion, and `locks` must be positive in its solution with these levels.
    pub fn new(equations: &mut Equations, solver: &MotionSolver, (levels, locks): (&Levels, Vec<Expr>)) -> Self {
        let mut kernels = Self { locks, ..Self::default() };
        let mechanism = equations.system.mechanism.clone();
        for (index, contact) in mechanism.contacts.iter().enumerate() {
            let row = equations.row_that_may_hold(index).map(|row| equations.constraints[row].clone());
            let Some(gap) = row.as_ref().and_then(|row| row.contact()) else { continue };
            let arena = &mut equations.system.arena;
            let acceleration = |arena: &mut Arena, index| arena.symbol(Symbol::Coordinate(index, Order::Acceleration));
            let mut motion = [gap.value, gap.rate(arena), gap.acceleration(arena, acceleration)];
            if let Some(there) = mechanism.there(contact.owner) {
                let there = arena.symbol(Symbol::Discrete(there.0));
                motion = while_there(arena, there, motion, contact.state.place.is_some());
            }
            kernels.gaps.push(motion[0]);
            kernels.rates.push(motion[1]);
            kernels.accelerations.push(motion[2]);
            kernels.restitutions.push(match &contact.slip {
                Some(slip) => equations.static_ratio(slip),
                None => equations.system.value(&contact.gap.restitution),
            });
        }
        let has_signs = |place: usize| !mechanism.contacts[place].state.signs.is_empty();
        let signed = levels.signed().filter(|(place, _)| has_signs(*place));
        kernels.pressing = signed.flat_map(|(_, signed)| signed).map(|(_, sum)| *sum).collect();
        if !kernels.gaps.is_empty() || mechanism.has_impulses() {
            let arena = &mut equations.system.arena;
            let requested: Vec<Expr> =
                (0..equations.constraints.len()).map(|row| arena.symbol(Symbol::Reaction(row))).collect();
            let without = solver.impact(arena, &requested);
            kernels.impact = levels.solve(arena, without, true).values;
            // States have no impulses.
            let first = equations.coordinates.len();
            kernels.impact.splice(first..first, equations.states.iter().map(|_| Expr::ZERO));
        }
        kernels
    }

    /// With the tapes of its kernels.
    pub fn lower(
        equations: &Equations,
        [gaps, rates, accelerations, restitutions, impact, pressing, locks]: [Tape; 7],
    ) -> Option<Contacts> {
        let mechanism = &equations.system.mechanism;
        let rows: Vec<Option<usize>> =
            (0..mechanism.contacts.len()).map(|index| equations.row_that_may_hold(index)).collect();
        let mut first = 0;
        let mut all = Vec::new();
        for (index, (contact, row)) in mechanism.contacts.iter().zip(&rows).enumerate() {
            let Some(row) = *row else { continue };
            let slip = contact.slip.as_ref().zip(equations.row_of_level(index)).map(|(slip, level)| {
                let counted = |place: usize| rows[..place].iter().flatten().count() as u32;
                let signs = contact.state.signs.len() as u32;
                first += signs;
                Slip {
                    level: level as u32,
                    on: slip.on.map(counted),
                    sums: first - signs,
                    follows: slip.law.mu != Formula::Number(0.0),
                }
            });
            let (name, of_rate) = (contact.name.clone(), contact.gap.of_rate);
            all.push(Contact { name, constraint: row as u32, state: state(&contact.state), of_rate, slip });
        }
        let contacts = Contacts { all, gaps, rates, accelerations, restitutions, impact, pressing, locks };
        let has_impulses = !contacts.impact.results.is_empty();
        (contacts.gaps.results.len() == contacts.all.len() && has_impulses).then_some(contacts)
    }
}
