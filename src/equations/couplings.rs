//! Couplings: relations between across variables of both graphs, or functions of them. Each term is a chord in every tree; its
//! through variable is the transposed relation, factor x reaction (times the slope of a function), so that the power of all terms together vanishes.

use std::collections::HashMap;

use super::constraints::{Constraint, Gap, RowKind, SlidingRow, assemble};
use super::course;
use super::feature;
use super::form::{Coefficient, LinearForm};
use super::kinematics::{Kinematics, PointMotion, project};
use super::vector::{Scalar, Vector};
use crate::expr::{Arena, Binary, Expr, Order, Symbol, Unary};
use crate::model::BodyId;
use crate::network::{Coupling, CouplingTerm, Curve, ElementId, Port, RNode, System, TNode};

/// How the reaction of a coupling acts between two nodes, on the second from the first.
#[derive(Clone, Debug)]
pub enum CoupledChord {
    /// A force of reaction x vector; the vector may turn with a body.
    Force([TNode; 2], Vector, Option<BodyId>),
    Torque([RNode; 2], Expr),
}

/// The points of a rope, a ring or a removed rod may coincide, where their distance has no derivative. This is added to its square \[m2\]: a distance of more than 1e-12 m keeps all its digits, and
/// where it has no direction it is 1e-20 m, without a rate.
const COINCIDENT: f64 = 1e-40;

/// Value, rate and acceleration of a scalar across variable.
type ScalarMotion = (Expr, LinearForm<Scalar>, LinearForm<Scalar>);

/// Appends the relations of all couplings to the loop equations.
pub(super) fn append(system: &mut System, kinematics: &Kinematics, rows: &mut Vec<Constraint>) {
    for index in 0..system.elements.len() {
        if let Some(coupling) = system.elements[index].coupling.clone() {
            rows.extend(relation(system, kinematics, ElementId(index), &coupling));
        }
    }
}

/// Phi = offset - sum of factor x across.
fn relation(
    system: &mut System,
    kinematics: &Kinematics,
    element: ElementId,
    coupling: &Coupling,
) -> Option<Constraint> {
    let constrained = coupling.terms.first()?.port.constrained();
    let (mut value, mut velocity, mut acceleration) = (coupling.offset, LinearForm::default(), LinearForm::default());
    let mut coupled = Vec::new();
    let may_open = system.element(element).closed.is_some();
    for term in &coupling.terms {
        let ((position, rate, second), chord) = across(system, kinematics, (term.port, term.factor), may_open);
        let arena = &mut system.arena;
        let minus = arena.negate(term.factor);
        value = arena.add_product(value, minus, position);
        velocity.accumulate(arena, minus, &rate);
        acceleration.accumulate(arena, minus, &second);
        coupled.push(chord);
    }
    let row = assemble(&mut system.arena, kinematics, (element, constrained), value, &velocity, &acceleration);
    Some(Constraint { coupled, period: coupling.period(&mut system.arena), ..row })
}

/// A derivative of a sum of factor x across.
pub(super) fn along(system: &mut System, kinematics: &Kinematics, terms: &[CouplingTerm], order: Order) -> Expr {
    let mut total = Expr::ZERO;
    for term in terms {
        let ((position, rate, second), _) = across(system, kinematics, (term.port, term.factor), true);
        let arena = &mut system.arena;
        let of = |arena: &mut Arena, form: &LinearForm<Scalar>| {
            form.map(arena, |arena, part| part.total(arena, &kinematics.frames)).total(arena)
        };
        let value = match order {
            Order::Position => position,
            Order::Velocity => of(arena, &rate),
            Order::Acceleration => of(arena, &second),
        };
        total = arena.add_product(total, term.factor, value);
    }
    total
}

impl Constraint {
    /// This loop equation while `closed` is 1; where that is 0 nothing is left of it. So all modes are one matrix \[M J^T; J D\], whose entry D = closed - 1 makes the reaction zero while it is
    /// open: its factors L D L^T exist in any order in which a row comes after its unknowns.
    pub(super) fn while_closed(self, arena: &mut Arena, closed: Expr, slip: Option<Expr>) -> Constraint {
        let Constraint { value, time_rate, gamma, .. } = self;
        let open = self.gap(arena);
        let slip = slip.map(|direction| SlidingRow { direction, coupled: self.coupled.clone() });
        let gap = Gap { closed, value: open, jacobian: self.jacobian.clone(), time_rate, gamma, slip };
        let chord = |arena: &mut Arena, chord| match chord {
            CoupledChord::Force(ends, vector, carrier) => {
                CoupledChord::Force(ends, vector.scaled(arena, closed), carrier)
            }
            CoupledChord::Torque(ends, factor) => CoupledChord::Torque(ends, arena.multiply(closed, factor)),
        };
        let coupled = self.coupled.clone().into_iter().map(|coupled| chord(arena, coupled)).collect();
        let mut times = |entries: &[(usize, Expr)]| -> Vec<(usize, Expr)> {
            entries.iter().map(|&(column, entry)| (column, arena.multiply(closed, entry))).collect()
        };
        let (jacobian, followers) = (times(&self.jacobian), times(&self.followers));
        let [value, time_rate, gamma] = [value, time_rate, gamma].map(|part| arena.multiply(closed, part));
        Constraint { coupled, jacobian, followers, value, time_rate, gamma, kind: RowKind::Contact(gap), ..self }
    }
}

/// The across variable of a port, and the chord that carries factor x reaction. Points whose relation `may_open` may coincide.
fn across(
    system: &mut System,
    kinematics: &Kinematics,
    (port, factor): (Port, Expr),
    may_open: bool,
) -> (ScalarMotion, CoupledChord) {
    match port {
        Port::Angle(ends) => {
            let arena = &mut system.arena;
            let angle = kinematics.angle_across(arena, ends);
            let [rate, second] =
                [&angle.velocity, &angle.acceleration].map(|form| form.map(arena, |_, &c| Scalar::plain(c)));
            ((angle.position.total(arena), rate, second), CoupledChord::Torque(ends, factor))
        }
        Port::Curve(ends, curve) => {
            let (motion, slope) = on_curve(&mut system.arena, kinematics, ends, &curve);
            (motion, CoupledChord::Torque(ends, system.arena.multiply(factor, slope)))
        }
        Port::Along(ends, direction) => {
            let along = kinematics.direction(system, direction);
            let arena = &mut system.arena;
            let gap = kinematics.across(arena, ends);
            let (value, rate, second) = project(kinematics, arena, &gap, &along);
            let value = value.total(arena, &kinematics.frames);
            let vector = along.1.scaled(arena, factor);
            ((value, rate, second), CoupledChord::Force(ends, vector, direction.carrier()))
        }
        Port::Feature(ends, body, touched) => {
            let (motion, normal) = feature::distance(system, kinematics, (ends, body), touched);
            let vector = normal.scaled(&mut system.arena, factor);
            (motion, CoupledChord::Force(ends, vector, body))
        }
        Port::Length(ends) => {
            let gap = kinematics.across(&mut system.arena, ends);
            let (motion, unit) = length(system, kinematics, (&gap, may_open));
            let vector = unit.scaled(&mut system.arena, factor);
            (motion, CoupledChord::Force(ends, vector, None))
        }
        Port::Span(ends, tangent) => {
            let gap = kinematics.across(&mut system.arena, ends);
            let (motion, unit) = course::tangent(system, kinematics, &gap, tangent);
            let vector = unit.scaled(&mut system.arena, factor);
            (motion, CoupledChord::Force(ends, vector, None))
        }
        Port::Heading(ends) => {
            let gap = kinematics.across(&mut system.arena, ends);
            let (motion, across) = heading(system, kinematics, (&gap, may_open));
            let vector = across.scaled(&mut system.arena, factor);
            (motion, CoupledChord::Force(ends, vector, None))
        }
    }
}

/// f(theta) with its derivatives f' theta' and f' theta'' + f'' theta'^2, and the slope f'.
fn on_curve(arena: &mut Arena, kinematics: &Kinematics, ends: [RNode; 2], curve: &Curve) -> (ScalarMotion, Expr) {
    let angle = kinematics.angle_across(arena, ends);
    let theta = angle.position.total(arena);
    let [value, slope, second] = curve.value.map(|expr| Curve::at(arena, expr, theta));
    let [rate, mut acceleration] = [&angle.velocity, &angle.acceleration]
        .map(|form| form.map(arena, |arena, &coefficient| Scalar::plain(arena.multiply(slope, coefficient))));
    let omega = angle.velocity.total(arena);
    let square = arena.square(omega);
    acceleration.add_term(arena, square, &Scalar::plain(second));
    ((value, rate, acceleration), slope)
}

/// The square of a distance.
fn square(arena: &mut Arena, kinematics: &Kinematics, (gap, may_open): (&PointMotion, bool)) -> Expr {
    let square = gap.position.dot(arena, &gap.position).total(arena, &kinematics.frames);
    let least = arena.constant(if may_open { COINCIDENT } else { 0.0 });
    arena.add(square, least)
}

/// |r| with its derivatives v.e and a.e + (v.v - (v.e)^2)/|r|, and the unit vector e = r/|r|.
fn length(
    system: &mut System,
    kinematics: &Kinematics,
    (gap, may_open): (&PointMotion, bool),
) -> (ScalarMotion, Vector) {
    let speeds = [Vector::x(), Vector::y()].map(|axis| kinematics.component(system, &gap.velocity, &axis));
    let arena = &mut system.arena;
    let square = square(arena, kinematics, (gap, may_open));
    let length = arena.unary(Unary::Sqrt, square);
    let inverse = arena.divide(Expr::ONE, length);
    let unit = gap.position.scaled(arena, inverse);
    let rate = gap.velocity.map(arena, |arena, v| v.dot(arena, &unit));
    let mut second = gap.acceleration.map(arena, |arena, a| a.dot(arena, &unit));
    let along = rate.map(arena, |arena, c| c.total(arena, &kinematics.frames)).total(arena);
    let [xx, yy, along] = [speeds[0], speeds[1], along].map(|speed| arena.square(speed));
    let all = arena.add(xx, yy);
    let beside = arena.subtract(all, along);
    let turning = arena.multiply(beside, inverse);
    second.add_term(arena, turning, &Scalar::plain(Expr::ONE));
    ((length, rate, second), unit)
}

/// The direction angle of r with its derivatives v.t/|r| and (a.t - 2 (v.e) (v.t)/|r|)/|r|, and t/|r|: e = r/|r|, and t = k x e.
fn heading(
    system: &mut System,
    kinematics: &Kinematics,
    (gap, may_open): (&PointMotion, bool),
) -> (ScalarMotion, Vector) {
    let [x, y] = [Vector::x(), Vector::y()].map(|axis| {
        let arena = &mut system.arena;
        gap.position.dot(arena, &axis).total(arena, &kinematics.frames)
    });
    let arena = &mut system.arena;
    let angle = arena.binary(Binary::Atan2, y, x);
    let square = square(arena, kinematics, (gap, may_open));
    let inverse = arena.divide(Expr::ONE, square);
    let across = gap.position.turned(arena).scaled(arena, inverse);
    let rate = gap.velocity.map(arena, |arena, v| v.dot(arena, &across));
    let mut second = gap.acceleration.map(arena, |arena, a| a.dot(arena, &across));
    let outward = gap.velocity.map(arena, |arena, v| v.dot(arena, &gap.position));
    let [turning, parting] =
        [&rate, &outward].map(|form| form.map(arena, |arena, part| part.total(arena, &kinematics.frames)).total(arena));
    let parting = arena.multiply(parting, inverse);
    let both = arena.multiply(turning, parting);
    let minus_two = arena.constant(-2.0);
    let coriolis = arena.multiply(minus_two, both);
    second.add_term(arena, coriolis, &Scalar::plain(Expr::ONE));
    ((angle, rate, second), across)
}

/// The contributions of the couplings to the cutset equations: sums at the nodes of both graphs.
#[derive(Clone, Debug, Default)]
pub(super) struct Couplings {
    pub forces: HashMap<usize, LinearForm<Vector>>,
    pub torques: HashMap<usize, LinearForm<Scalar>>,
    turning: Vec<(BodyId, [TNode; 2], LinearForm<Vector>)>,
}

impl Couplings {
    pub fn new(arena: &mut Arena, constraints: &[Constraint]) -> Self {
        let mut couplings = Couplings::default();
        for (index, constraint) in constraints.iter().enumerate() {
            for chord in constraint.coupled.iter().filter(|_| !constraint.is_trivial()) {
                couplings.add_chord(arena, (index, Expr::ONE), chord);
            }
            let slip = constraint.contact().into_iter().filter_map(|gap| gap.slip.as_ref());
            for (slip, chord) in slip.flat_map(|slip| slip.coupled.iter().map(move |chord| (slip, chord))) {
                couplings.add_chord(arena, (index + 1, slip.direction), chord);
            }
        }
        couplings
    }

    /// The reaction of a row, times a share, acts through a chord.
    fn add_chord(&mut self, arena: &mut Arena, (row, share): (usize, Expr), chord: &CoupledChord) {
        let reaction = arena.symbol(Symbol::Reaction(row));
        match chord {
            CoupledChord::Force(ends, vector, carrier) => {
                let vector = vector.scaled(arena, share);
                let force = LinearForm::term(arena, reaction, &vector);
                add(arena, &mut self.forces, ends.map(TNode::index), &force);
                self.turning.extend(carrier.map(|body| (body, *ends, force)));
            }
            CoupledChord::Torque(ends, factor) => {
                let factor = arena.multiply(share, *factor);
                let torque = LinearForm::term(arena, reaction, &Scalar::plain(factor));
                add(arena, &mut self.torques, ends.map(RNode::index), &torque);
            }
        }
    }

    /// sum r x F over the forces that turn with each body (Eq. 6).
    pub fn add_moments(
        &self,
        system: &mut System,
        kinematics: &Kinematics,
        moments: &mut HashMap<BodyId, LinearForm<Scalar>>,
    ) {
        let arena = &mut system.arena;
        for (body, ends, force) in &self.turning {
            let arm = kinematics.across(arena, *ends).position;
            let moment = force.map(arena, |arena, f| arm.cross(arena, f));
            moments.entry(*body).or_default().accumulate(arena, Expr::ONE, &moment);
        }
    }
}

/// A chord's through variable at its two nodes: positive at the second, negative at the first.
pub(super) fn add<C: Coefficient>(
    arena: &mut Arena,
    sums: &mut HashMap<usize, LinearForm<C>>,
    [a, b]: [usize; 2],
    through: &LinearForm<C>,
) {
    let minus = arena.constant(-1.0);
    sums.entry(b).or_default().accumulate(arena, Expr::ONE, through);
    sums.entry(a).or_default().accumulate(arena, minus, through);
}
