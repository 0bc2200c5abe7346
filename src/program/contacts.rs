//! What is held on one side only: the kernels by which the runtime opens and closes it.

use cotree_fmu::program::contour::Contours;
use cotree_fmu::program::{self, Contact, Contacts, Slip};
use cotree_fmu::tape::Tape;

use crate::equations::Equations;
use crate::expr::{Arena, Expr, Order, Symbol};
use crate::model::{self, ContactVariables, DiscreteId, FeatureJoint, Formula, Mechanism, Part};
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
    pub row_sizes: Vec<Expr>,
    pub places: Vec<Expr>,
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
fn state(state: &ContactVariables) -> program::ContactState {
    let place = |id: DiscreteId| id.0 as u32;
    program::ContactState {
        closed: place(state.closed),
        impulse: place(state.impulse),
        place: state.place.map(place),
        direction: state.direction.map(place),
        signs: state.signs.iter().copied().map(place).collect(),
    }
}

/// The profiles that contacts touch, with the tape of where they are.
fn contours(mechanism: &Mechanism, all: &[Contact], places: Tape) -> Option<Contours> {
    let of = |part: &Part| {
        let slot = |contact: &model::Contact| {
            let held = contact.state.feature.filter(|_| contact.owner == part.owner)?.map(|id| id.0 as u32);
            let place = all.iter().position(|other| other.name == contact.name)?;
            Some(program::contour::Slot { contact: place as u32, held })
        };
        Some(program::contour::Contour {
            slots: mechanism.contacts.iter().filter_map(slot).collect(),
            there: mechanism.there(part.owner).map(|there| there.0 as u32),
            ..contour(part)?
        })
    };
    let all: Vec<_> = mechanism.parts().filter_map(of).collect();
    (!all.is_empty()).then_some(Contours { all, places })
}

/// The profile of a part as the program has it, without its slots.
pub(crate) fn contour(part: &Part) -> Option<program::contour::Contour> {
    let contour = part.contour()?;
    Some(program::contour::Contour {
        name: part.name.clone(),
        features: contour.features().into_iter().map(feature).collect(),
        closed: contour.closed,
        radius: contour.radius,
        slots: Vec::new(),
        there: None,
    })
}

/// A feature as the program has it.
fn feature(feature: model::Feature) -> program::contour::Feature {
    let end = |end: usize| program::contour::End {
        at: feature.ends[end],
        joint: match feature.joints[end] {
            FeatureJoint::Smooth(other) => program::contour::Joint::Smooth(other as u32),
            FeatureJoint::Concave => program::contour::Joint::Concave,
            FeatureJoint::Free => program::contour::Joint::Free,
        },
    };
    let model::Feature { at, normal, curvature, half, .. } = feature;
    program::contour::Feature { at, normal, curvature, half, ends: [0, 1].map(end) }
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
        for part in mechanism.parts().filter(|part| part.contour().is_some()) {
            kernels.places.extend(equations.place_at_profile(part.owner).into_iter().flatten());
        }
        if !kernels.gaps.is_empty() || mechanism.has_impulses() {
            let arena = &mut equations.system.arena;
            let requested: Vec<Expr> =
                (0..equations.constraints.len()).map(|row| arena.symbol(Symbol::Reaction(row))).collect();
            let without = solver.impact(arena, &requested);
            kernels.impact = levels.solve(arena, without, true).values;
            // States have no impulses.
            let first = equations.motion_layout().states().start;
            kernels.impact.splice(first..first, equations.states.iter().map(|_| Expr::ZERO));
            kernels.row_sizes = solver.row_sizes(&mut equations.system.arena);
        }
        kernels
    }

    /// With the tapes of its kernels.
    pub fn lower(
        equations: &Equations,
        [gaps, rates, accelerations, restitutions, impact, pressing, locks, row_sizes, places]: [Tape; 9],
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
        let contours = contours(mechanism, &all, places);
        let contacts =
            Contacts { all, gaps, rates, accelerations, restitutions, impact, pressing, locks, row_sizes, contours };
        let has_impulses = !contacts.impact.results.is_empty();
        (contacts.gaps.results.len() == contacts.all.len() && has_impulses).then_some(contacts)
    }
}
