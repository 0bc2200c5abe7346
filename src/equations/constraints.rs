//! Step 2: the circuit equations of chords with a reaction space, projected on it.

use std::collections::BTreeMap;

use super::Equations;
use super::couplings::{self, CoupledChord};
use super::feedback;
use super::form::{Coefficient, LinearForm};
use super::kinematics::{Kinematics, known_angle, project};
use super::vector::Scalar;
use crate::expr::{Arena, Expr, ExprNode, Order, Symbol, Unary};
use crate::model::{Engaging, Owner, Quantity};
use crate::network::{Angle, Constrained, Direction, ElementId, Origin, Rotation, System, Translation, Tree};

/// A row of the equations of motion: a scalar loop equation Phi = 0 with its derivatives and its reaction, or an unknown that appears among the reactions. See [`RowKind`].
#[derive(Clone, Debug)]
pub struct Constraint {
    /// The chord, or the element that couples others.
    pub element: ElementId,
    pub constrained: Constrained,
    /// The chords through which a coupling acts; none if it is the element's own circuit.
    pub coupled: Vec<CoupledChord>,
    /// Phi (Eq. 15): the projection of \[B_f\]{r}, so that the multiplier is the chord's through variable.
    pub value: Expr,
    /// Phi_q: (coordinate, entry).
    pub jacobian: Vec<(usize, Expr)>,
    /// Phi_t.
    pub time_rate: Expr,
    /// gamma of Eq. (21).
    pub gamma: Expr,
    /// d Phi / d position of each follower.
    pub followers: Vec<(usize, Expr)>,
    /// It holds where its value is a multiple of this, too. See [`Constraint::gap`].
    pub period: Option<Expr>,
    pub kind: RowKind,
}

/// What a row is. Each use of a row names all of these.
#[derive(Clone, Debug)]
pub enum RowKind {
    /// A loop equation that holds always.
    Loop(Standing),
    /// A loop equation of a contact: imposed while it is closed. Everything else in the row has the factor that is zero while it is open.
    Contact(Gap),
    /// A contact with friction that drivers move: it slides as they say and is no equation.
    DrivenContact(Gap),
    /// No equation: its multiplier is the limit of the friction of the row before it, a law of accelerations and reactions.
    FrictionLimit,
    /// No equation: its multiplier is the value of a load that reads accelerations or reactions.
    LoadValue,
}

/// A relation that holds on one side only: its value is never negative.
#[derive(Clone, Debug)]
pub struct Gap {
    /// 1 while it is closed, else 0.
    pub closed: Expr,
    pub value: Expr,
    /// Derivatives by the coordinates.
    pub jacobian: Vec<(usize, Expr)>,
    /// The part of its rate that no coordinate moves.
    pub time_rate: Expr,
    /// Its second derivative is jacobian . a - gamma.
    pub gamma: Expr,
    /// If it rubs while it is open.
    pub slip: Option<SlidingRow>,
}

/// How a relation acts while it slips: as with the reaction direction x level, where the level is the multiplier of the next row.
#[derive(Clone, Debug)]
pub struct SlidingRow {
    /// 1 or -1 while it slips that way, else 0.
    pub direction: Expr,
    /// The chords as while it is closed.
    pub coupled: Vec<CoupledChord>,
}

/// What a loop equation does for the motion, which is known once the mechanism has been assembled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// It is imposed; before the mechanism has been assembled, all are that have coordinates.
    Imposed,
    /// It follows from those that are imposed, in every pose of the motion.
    Repeats,
    /// It restricts in second order only: an implied relation stands for it.
    SecondOrder,
    /// No coordinate occurs in it: an identity, or a contradiction between two elements.
    Trivial,
}

impl Gap {
    /// Its rate.
    pub fn rate(&self, arena: &mut Arena) -> Expr {
        along(arena, &self.jacobian, self.time_rate, |arena, index| {
            arena.symbol(Symbol::Coordinate(index, Order::Velocity))
        })
    }

    /// Its second derivative, with these accelerations of the coordinates.
    pub fn acceleration(&self, arena: &mut Arena, of: impl FnMut(&mut Arena, usize) -> Expr) -> Expr {
        let rest = arena.negate(self.gamma);
        along(arena, &self.jacobian, rest, of)
    }
}

/// A row times derivatives of the coordinates, and a rest.
fn along(arena: &mut Arena, row: &[(usize, Expr)], rest: Expr, mut of: impl FnMut(&mut Arena, usize) -> Expr) -> Expr {
    row.iter().fold(rest, |sum, &(column, entry)| {
        let derivative = of(arena, column);
        arena.add_product(sum, entry, derivative)
    })
}

impl Constraint {
    /// True for a loop equation, of a contact too: its multiplier is a reaction, and not a law.
    pub fn is_loop(&self) -> bool {
        match self.kind {
            RowKind::Loop(_) | RowKind::Contact(_) => true,
            RowKind::DrivenContact(_) | RowKind::FrictionLimit | RowKind::LoadValue => false,
        }
    }

    /// A row without coordinates: an identity, or a contradiction between two parts of the scene.
    pub fn is_trivial(&self) -> bool {
        self.jacobian.is_empty()
    }

    /// True for an equation of the motion: one that holds on one side only is one in every mode.
    pub fn is_imposed(&self) -> bool {
        match self.kind {
            RowKind::Loop(standing) => standing == Standing::Imposed,
            RowKind::Contact(_) => true,
            RowKind::DrivenContact(_) | RowKind::FrictionLimit | RowKind::LoadValue => false,
        }
    }

    /// What a loop equation that holds always does for the motion; none for other rows.
    pub fn standing(&self) -> Option<Standing> {
        match self.kind {
            RowKind::Loop(standing) => Some(standing),
            RowKind::Contact(_) | RowKind::DrivenContact(_) | RowKind::FrictionLimit | RowKind::LoadValue => None,
        }
    }

    /// True for a loop equation with coordinates that is left out, because others stand for it.
    pub fn repeats(&self) -> bool {
        match self.kind {
            RowKind::Loop(Standing::Repeats | Standing::SecondOrder) => true,
            RowKind::Loop(Standing::Imposed | Standing::Trivial) | RowKind::Contact(_) => false,
            RowKind::DrivenContact(_) | RowKind::FrictionLimit | RowKind::LoadValue => false,
        }
    }

    /// The gap of a contact, driven or not.
    pub fn contact(&self) -> Option<&Gap> {
        match &self.kind {
            RowKind::Contact(gap) | RowKind::DrivenContact(gap) => Some(gap),
            RowKind::Loop(_) | RowKind::FrictionLimit | RowKind::LoadValue => None,
        }
    }

    /// From here on drivers move this contact.
    pub(crate) fn set_driven(&mut self) {
        if let RowKind::Contact(gap) = &self.kind {
            self.kind = RowKind::DrivenContact(gap.clone());
        }
    }

    /// Has the part in the motion of the same row of the same mechanism with other names.
    pub fn adopt(&mut self, other: &Constraint) {
        match other.kind {
            RowKind::Loop(standing) => self.kind = RowKind::Loop(standing),
            RowKind::DrivenContact(_) => self.set_driven(),
            RowKind::Contact(_) | RowKind::FrictionLimit | RowKind::LoadValue => {}
        }
    }

    /// The entry of its multiplier on the diagonal of the equations of motion: minus one while it is open, so that its reaction is zero.
    pub fn multiplier_diagonal(&self, arena: &mut Arena) -> Expr {
        self.contact().map_or(Expr::ZERO, |gap| arena.subtract(gap.closed, Expr::ONE))
    }

    /// The natural size of its value: 1 for an angle, the mechanism's own for a length.
    pub fn scale(&self, length: f64) -> f64 {
        if self.constrained == Constrained::Angle { 1.0 } else { length }
    }

    /// By how much it is open: its value, or how far that is from whole periods. Its derivatives are those of the value.
    pub fn gap(&self, arena: &mut Arena) -> Expr {
        let Some(period) = self.period else { return self.value };
        let half = arena.constant(0.5);
        let periods = arena.divide(self.value, period);
        let nearest = arena.add(periods, half);
        let whole = arena.unary(Unary::Floor, nearest);
        arena.subtract_product(self.value, period, whole)
    }

    /// The row of a law, which is no equation.
    pub(super) fn of_law(element: ElementId, constrained: Constrained, kind: RowKind) -> Constraint {
        Constraint {
            element,
            constrained,
            coupled: Vec::new(),
            value: Expr::ZERO,
            jacobian: Vec::new(),
            time_rate: Expr::ZERO,
            gamma: Expr::ZERO,
            followers: Vec::new(),
            period: None,
            kind,
        }
    }
}

impl Equations {
    /// Does an element's terminal equation (Table 1) alone say that its displacement is zero along a direction?
    pub fn is_zero(&mut self, id: ElementId, along: Direction) -> bool {
        let Equations { system, kinematics, .. } = self;
        let Some(row) = system.element(id).translation.clone() else { return false };
        let (_, axis) = kinematics.direction(system, along);
        let mut parts = vec![kinematics.known(system, &row.known).position];
        parts.extend(row.motion.iter().map(|(free, _)| kinematics.direction(system, *free).1));
        let arena = &mut system.arena;
        parts.iter().all(|part| part.dot(arena, &axis).total(arena, &kinematics.frames).is_zero())
    }
}

/// The loop equations of both graphs, then those of the couplings.
pub fn constraints(
    system: &mut System,
    kinematics: &Kinematics,
    t_tree: &Tree<Translation>,
    r_tree: &Tree<Rotation>,
) -> Vec<Constraint> {
    let mut rows = Vec::new();
    for &chord in &t_tree.chords {
        let Some(row) = system.elements[chord.0].translation.clone() else { continue };
        if row.reaction.is_empty() {
            continue;
        }
        let mut gap = kinematics.known(system, &row.known);
        let displacement = kinematics.across(&mut system.arena, row.ends);
        let minus = system.arena.constant(-1.0);
        gap.accumulate(&mut system.arena, minus, &displacement);
        for direction in row.reaction {
            let along = kinematics.direction(system, direction);
            let arena = &mut system.arena;
            let (value, velocity, acceleration) = project(kinematics, arena, &gap, &along);
            let value = value.total(arena, &kinematics.frames);
            let constrained = Constrained::Along(direction);
            rows.push(assemble(arena, kinematics, (chord, constrained), value, &velocity, &acceleration));
        }
    }
    for &chord in &r_tree.chords {
        let Some(row) = system.elements[chord.0].rotation.clone() else { continue };
        if matches!(row.angle, Angle::Free(_)) {
            continue;
        }
        let arena = &mut system.arena;
        let mut gap = known_angle(arena, &row.angle);
        let angle = kinematics.angle_across(arena, row.ends);
        let minus = arena.constant(-1.0);
        gap.accumulate(arena, minus, &angle);
        let value = gap.position.total(arena);
        let [velocity, acceleration] = [&gap.velocity, &gap.acceleration]
            .map(|form| form.map(arena, |_, &coefficient| Scalar::plain(coefficient)));
        rows.push(assemble(arena, kinematics, (chord, Constrained::Angle), value, &velocity, &acceleration));
    }
    couplings::append(system, kinematics, &mut rows);
    let loops = rows.into_iter().flat_map(|row| masked(system, row)).collect::<Vec<_>>();
    loops.into_iter().chain(feedback::rows(system)).collect()
}

/// The same, as what does not always hold, and after it the row of a level if it rubs.
fn masked(system: &mut System, row: Constraint) -> Vec<Constraint> {
    let element = system.element(row.element);
    let (Some(closed), slip) = (element.closed, element.slip) else { return vec![row] };
    if is_left_out(system, &row) {
        return Vec::new();
    }
    // What drivers alone move takes part in no motion, but what rubs there acts on them.
    if row.is_trivial() && slip.is_none() {
        return vec![row];
    }
    let level = slip.map(|_| Constraint::of_law(row.element, row.constrained, RowKind::FrictionLimit));
    std::iter::once(row.while_closed(&mut system.arena, closed, slip)).chain(level).collect()
}

/// True for an equation of a joint that engages, or of a rate that is set, which holds anyway.
fn is_left_out(system: &System, row: &Constraint) -> bool {
    let stands = row.is_trivial() && row.time_rate.is_zero() && row.followers.is_empty();
    match system.element(row.element).origin {
        Origin::SetRate(_) => row.is_trivial(),
        Origin::Joint(joint) => system.mechanism.engaging(Owner::Joint(joint)).is_some_and(|engaging| {
            let is_repeated =
                impulse_of(row.constrained, engaging).is_some_and(|impulse| engaging.left_out.contains(&impulse));
            stands && engaging.here || is_repeated
        }),
        _ => false,
    }
}

/// The impulse of a loop equation of a joint that engages.
pub fn impulse_of(constrained: Constrained, engaging: &Engaging) -> Option<Quantity> {
    let wanted: &[Quantity] = match constrained {
        Constrained::Along(Direction::X) => &[Quantity::ImpulseX],
        Constrained::Along(Direction::Y) => &[Quantity::ImpulseY],
        Constrained::Along(Direction::Fixed(..)) | Constrained::Length => &[Quantity::Impulse],
        Constrained::Angle => &[Quantity::ImpulseTorque, Quantity::AngularImpulse],
    };
    wanted.iter().copied().find(|wanted| engaging.impulses.iter().any(|(quantity, _)| quantity == wanted))
}

pub(super) fn assemble(
    arena: &mut Arena,
    kinematics: &Kinematics,
    (element, constrained): (ElementId, Constrained),
    value: Expr,
    velocity: &LinearForm<Scalar>,
    acceleration: &LinearForm<Scalar>,
) -> Constraint {
    let (rates, time_rate) = split(arena, kinematics, velocity, Order::Velocity);
    let (_, rest) = split(arena, kinematics, acceleration, Order::Acceleration);
    let gamma = arena.negate(rest);
    let followers = follower_rates(arena, kinematics, velocity);
    let standing = if rates.is_empty() { Standing::Trivial } else { Standing::Imposed };
    Constraint {
        element,
        constrained,
        coupled: Vec::new(),
        value,
        jacobian: rates,
        time_rate,
        gamma,
        followers,
        period: None,
        kind: RowKind::Loop(standing),
    }
}

/// Splits a form into its coefficients by the coordinates' derivatives of one order, and the rest.
pub fn split(
    arena: &mut Arena,
    kinematics: &Kinematics,
    form: &LinearForm<Scalar>,
    order: Order,
) -> (Vec<(usize, Expr)>, Expr) {
    let mut entries = Vec::new();
    let mut rest: LinearForm<Expr> = LinearForm::default();
    for (key, coefficient) in form.terms() {
        let total = coefficient.total(arena, &kinematics.frames);
        match arena.node(key) {
            ExprNode::Symbol(Symbol::Coordinate(index, of)) if of == order => entries.push((index, total)),
            _ => rest.add_term(arena, key, &total),
        }
    }
    entries.retain(|(_, entry)| !entry.is_zero());
    entries.sort_unstable();
    (entries, rest.total(arena))
}

fn follower_rates(arena: &mut Arena, kinematics: &Kinematics, velocity: &LinearForm<Scalar>) -> Vec<(usize, Expr)> {
    let mut entries: BTreeMap<usize, Expr> = BTreeMap::new();
    for (key, coefficient) in velocity.terms() {
        if let ExprNode::Symbol(Symbol::Follower(index, Order::Velocity)) = arena.node(key) {
            entries.insert(index, coefficient.total(arena, &kinematics.frames));
        }
    }
    entries.into_iter().collect()
}
