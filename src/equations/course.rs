//! Ropes and bands over pulleys: tangents of circles, their directions over many turns, and what both are at the start.
//!
//! With the centres apart by e, their radii by k = R_2 - R_1 and J e = (-e_y, e_x) a tangent has the length L = sqrt(e.e - k^2) and the direction t = (L e - k J e)/(e.e). On it e = L t + k J t,
//! so that L - k phi changes by t . de where phi, the angle of t, changes by (J t . de)/L.

use std::f64::consts::TAU;

use super::Equations;
use super::couplings;
use super::form::{Coefficient, LinearForm};
use super::kinematics::Kinematics;
use super::kinematics::PointMotion;
use super::vector::{Scalar, Vector};
use crate::expr::{Arena, Binary, Expr, Order, Unary, Values, build};
use crate::model::{CourseValue, Mechanism, Owner, Part, Station};
use crate::network::{CircleTangent, System, TNode, course};

/// A wrap that falls short of zero by less than this \[rad\] is zero: starts are solved for to rounding errors.
const TOUCHING: f64 = 1e-9;
/// From here on \[rad\] the direction from which that of a straight part counts is moved, well before half a turn.
const FAR: f64 = 2.0;

/// Value, rate and acceleration of a scalar across variable.
type ScalarMotion = (Expr, LinearForm<Scalar>, LinearForm<Scalar>);

/// The straight part between two circles.
struct Straight {
    /// Its length.
    length: Expr,
    /// Its direction.
    unit: Vector,
    /// The same times a positive factor, in the axes of the world.
    along: [Expr; 2],
    /// The square of its length.
    square: Expr,
}

/// A course at the configuration of the coordinates, without discrete variables: each straight part, and its angle from the first one on.
struct Laid {
    straight: Vec<Straight>,
    angles: Vec<Expr>,
    wraps: Vec<Expr>,
}

fn straight(system: &mut System, kinematics: &Kinematics, gap: &PointMotion, difference: Expr) -> Straight {
    let arena = &mut system.arena;
    let square = gap.position.dot(arena, &gap.position).total(arena, &kinematics.frames);
    let difference_squared = arena.square(difference);
    let length_squared = arena.subtract(square, difference_squared);
    let length = arena.unary(Unary::Sqrt, length_squared);
    let (forward, sideways) = (arena.divide(length, square), arena.divide(difference, square));
    let minus = arena.negate(sideways);
    let mut unit = gap.position.scaled(arena, forward);
    let across = gap.position.turned(arena).scaled(arena, minus);
    unit.accumulate(arena, &across);
    let along = [Vector::x(), Vector::y()].map(|axis| unit.dot(arena, &axis).total(arena, &kinematics.frames));
    Straight { length, unit, along, square: length_squared }
}

/// The angle of a direction from a reference, in the half turns on both sides of that.
fn angle_from(arena: &mut Arena, reference: Expr, [x, y]: [Expr; 2]) -> Expr {
    build(arena, [reference, x, y], |[reference, x, y]| {
        let (cosine, sine) = (reference.cos(), reference.sin());
        (cosine * y - sine * x).and(Binary::Atan2, cosine * x + sine * y)
    })
}

/// L - k phi with its derivatives v.t and a.t + (v.n)^2/L, n = J t, and t.
pub(super) fn tangent(
    system: &mut System,
    kinematics: &Kinematics,
    gap: &PointMotion,
    tangent: CircleTangent,
) -> (ScalarMotion, Vector) {
    let Straight { length, unit, along, .. } = straight(system, kinematics, gap, tangent.difference);
    let value = if tangent.difference.is_zero() {
        length
    } else {
        let arena = &mut system.arena;
        let angle = angle_from(arena, tangent.reference, along);
        let angle = arena.add(tangent.reference, angle);
        arena.subtract_product(length, tangent.difference, angle)
    };
    let normal = unit.turned(&mut system.arena);
    let transverse = kinematics.component(system, &gap.velocity, &normal);
    let arena = &mut system.arena;
    let rate = gap.velocity.map(arena, |arena, v| v.dot(arena, &unit));
    let mut second = gap.acceleration.map(arena, |arena, a| a.dot(arena, &unit));
    let square = arena.square(transverse);
    let turning = arena.divide(square, length);
    second.add_term(arena, turning, &Scalar::plain(Expr::ONE));
    ((value, rate, second), unit)
}

impl Equations {
    /// The straight part of a span.
    fn laid_span(&mut self, ends: [TNode; 2], difference: Expr) -> Straight {
        let Equations { system, kinematics, .. } = self;
        let gap = kinematics.across(&mut system.arena, ends);
        straight(system, kinematics, &gap, difference)
    }

    /// A unit vector along a straight part between circles.
    pub(super) fn unit_tangent(&mut self, ends: [TNode; 2], tangent: CircleTangent) -> Vector {
        self.laid_span(ends, tangent.difference).unit
    }

    /// A derivative of the length of a part that runs over pulleys; none of others.
    pub(super) fn course_length(&mut self, owner: Owner, order: Order) -> Option<Expr> {
        let mechanism = self.system.mechanism.clone();
        let part = mechanism.part_of(owner).filter(|part| part.course().is_some())?;
        let relation = course::length(part, &mut self.system)?;
        let total = couplings::along(&mut self.system, &self.kinematics, &relation.terms, order);
        Some(if order == Order::Position { self.system.arena.subtract(total, relation.offset) } else { total })
    }

    /// A course as its keys say, wherever it is now: wraps from zero to one turn, and the whole turns.
    fn laid(&mut self, stations: &[Station]) -> Laid {
        let mut laid = Laid { straight: Vec::new(), angles: Vec::new(), wraps: Vec::new() };
        for (number, pair) in stations.windows(2).enumerate() {
            let ends = [&pair[0], &pair[1]].map(|station| self.system.t_node(station.at));
            let [first, second] = [&pair[0], &pair[1]].map(|station| self.system.value(&station.radius));
            let difference = self.system.arena.subtract(second, first);
            let straight = self.laid_span(ends, difference);
            let arena = &mut self.system.arena;
            let angle = match laid.angles.last().zip(laid.straight.last()) {
                None => {
                    // Never zero, which it is before the start only.
                    let angle = arena.binary(Binary::Atan2, straight.along[1], straight.along[0]);
                    let turn = arena.constant(TAU);
                    arena.add(angle, turn)
                }
                Some((&before, Straight { along, .. })) => {
                    let (wrap, turn) = wrap(arena, [*along, straight.along], &stations[number]);
                    laid.wraps.push(wrap);
                    arena.add(before, turn)
                }
            };
            laid.angles.push(angle);
            laid.straight.push(straight);
        }
        laid
    }

    /// What a discrete variable of a course is at the start; zero of a part that is not there.
    pub(crate) fn begin_of_course(&mut self, owner: Owner, value: CourseValue) -> Expr {
        let mechanism = self.system.mechanism.clone();
        let Some(stations) = mechanism.part_of(owner).and_then(Part::stations) else { return Expr::ZERO };
        let laid = self.laid(&stations);
        match value {
            CourseValue::Turn(number) => laid.angles.get(number).copied().unwrap_or(Expr::ZERO),
            CourseValue::Wound => self.wound(&stations, &laid),
            CourseValue::Length => self.length_of(&stations, &laid),
        }
    }

    /// R (phi - theta) of a drum at the first end, R (theta - phi) at the last.
    fn wound(&mut self, stations: &[Station], laid: &Laid) -> Expr {
        let ends = [(stations.first(), laid.angles.first(), 1.0), (stations.last(), laid.angles.last(), -1.0)];
        let mut total = Expr::ZERO;
        for (station, angle, sign) in ends {
            let Some((station, &angle)) = station.filter(|station| station.is_drum).zip(angle) else { continue };
            let node = self.system.r_node(station.at.body());
            let radius = self.system.value(&station.radius);
            let arena = &mut self.system.arena;
            let turned = self.kinematics.angle(node).position.total(arena);
            let sign = arena.constant(sign);
            let lever = arena.multiply(sign, radius);
            let relative = arena.subtract(angle, turned);
            total = arena.add_product(total, lever, relative);
        }
        total
    }

    /// Straight parts and arcs; what is on drums does not count.
    fn length_of(&mut self, stations: &[Station], laid: &Laid) -> Expr {
        let mut total = self.system.arena.sum(laid.straight.iter().map(|straight| straight.length));
        for (number, station) in stations.iter().enumerate().skip(1).take(laid.wraps.len()) {
            let radius = self.system.value(&station.radius);
            let arena = &mut self.system.arena;
            let turn = arena.subtract(laid.angles[number], laid.angles[number - 1]);
            total = arena.add_product(total, radius, turn);
        }
        total
    }

    /// How far the directions of straight parts are from where they count from, squared and beside its limit, and what they are: the larger first where they count anew.
    pub(crate) fn course_turns(&mut self) -> (Vec<[Expr; 2]>, Vec<Expr>) {
        let mechanism = self.system.mechanism.clone();
        let (mut sides, mut written) = (Vec::new(), Vec::new());
        for (id, owner, number) in mechanism.turns() {
            let angle = self.deviation(&mechanism, owner, number);
            let reference = self.system.course_value(owner, CourseValue::Turn(number)).unwrap_or(Expr::ZERO);
            let arena = &mut self.system.arena;
            debug_assert_eq!(arena.symbol(crate::expr::Symbol::Discrete(id.0)), reference);
            let (square, limit) = (arena.square(angle), arena.constant(FAR * FAR));
            sides.push([square, limit]);
            written.push(arena.add(reference, angle));
        }
        (sides, written)
    }

    /// By how much ropes lift off from pulleys, each beside its limit.
    pub(crate) fn course_lifts(&mut self) -> Vec<[Expr; 2]> {
        let wraps = self.lying_wraps();
        let arena = &mut self.system.arena;
        wraps.into_iter().map(|(_, _, wrap)| [arena.negate(wrap), arena.constant(TOUCHING)]).collect()
    }

    /// By how much a pulley may still be left, with the place in the scene that it is.
    pub(crate) fn course_margins(&mut self) -> Vec<(String, Expr)> {
        let mechanism = self.system.mechanism.clone();
        let mut margins = Vec::new();
        for (owner, number, wrap) in self.lying_wraps() {
            // Laws are looked at before discrete variables have begun, too.
            let begun = self.system.course_value(owner, CourseValue::Turn(0)).unwrap_or(Expr::ZERO);
            let arena = &mut self.system.arena;
            let touching = arena.constant(TOUCHING);
            let margin = arena.add(wrap, touching);
            let margin = arena.select(begun, margin, Expr::ONE);
            let name = mechanism.part_of(owner).map_or("", |part| &part.name);
            margins.push((format!("the wrap of `{name}` on its pulley {}", number + 1), margin));
        }
        margins
    }

    /// The wraps of all pulleys that ropes lie on, with their numbers on their parts.
    fn lying_wraps(&mut self) -> Vec<(Owner, usize, Expr)> {
        let mechanism = self.system.mechanism.clone();
        let lying = mechanism.lying();
        lying.map(|(part, number)| (part.owner, number, self.wraps(part.owner)[number])).collect()
    }

    /// By how much the direction of a straight part has turned from where it counts from.
    fn deviation(&mut self, mechanism: &Mechanism, owner: Owner, number: usize) -> Expr {
        let spans = self.spans(mechanism, owner);
        let Some(&(ends, CircleTangent { difference, reference })) = spans.get(number) else { return Expr::ZERO };
        let straight = self.laid_span(ends, difference);
        angle_from(&mut self.system.arena, reference, straight.along)
    }

    /// The straight parts of a course; none of what is no course.
    fn spans(&mut self, mechanism: &Mechanism, owner: Owner) -> Vec<([TNode; 2], CircleTangent)> {
        let part = mechanism.part_of(owner).and_then(|part| Some((part, part.stations()?)));
        part.map_or(Vec::new(), |(part, stations)| course::spans(part, &stations, &mut self.system))
    }

    /// The wrap of the pulley with friction, if a part has one.
    pub(super) fn wrap_with_friction(&mut self, owner: Owner) -> Option<Expr> {
        let mechanism = self.system.mechanism.clone();
        let course = mechanism.part_of(owner)?.course()?;
        let number = course.over.iter().position(|pulley| pulley.mu.is_some())?;
        self.wraps(owner).get(number).copied()
    }

    /// Why a configuration that is not reached by a motion cannot be that of the courses: a rope is off a pulley, or turned so far that its wraps are not known.
    pub fn off_course(&mut self, values: &impl Values) -> Option<String> {
        let mechanism = self.system.mechanism.clone();
        for (_, owner, number) in mechanism.turns() {
            let deviation = self.deviation(&mechanism, owner, number);
            let turned = self.system.arena.evaluate(&[deviation], values)[0];
            if turned.is_nan() || turned.abs() > FAR {
                let name = &mechanism.part_of(owner)?.name;
                return Some(format!(
                    "straight part {} of `{name}` is turned by more than {FAR} rad from the start",
                    number + 1
                ));
            }
        }
        for (place, margin) in self.course_margins() {
            if self.system.arena.evaluate(&[margin], values)[0] < 0.0 {
                return Some(format!("{place} is less than zero"));
            }
        }
        None
    }

    /// The square of the length of each straight part, as far as circles have a tangent \[m2\].
    pub fn squares_of_straight_parts(&mut self, owner: Owner) -> Vec<Expr> {
        let mechanism = self.system.mechanism.clone();
        let spans = self.spans(&mechanism, owner);
        spans.into_iter().map(|(ends, tangent)| self.laid_span(ends, tangent.difference).square).collect()
    }

    /// The wraps of the pulleys of a part, positive where the rope lies on them \[rad\].
    pub fn wraps(&mut self, owner: Owner) -> Vec<Expr> {
        let mechanism = self.system.mechanism.clone();
        let Some(stations) = mechanism.part_of(owner).and_then(Part::stations) else { return Vec::new() };
        let angle = |equations: &mut Equations, number: usize| {
            let deviation = equations.deviation(&mechanism, owner, number);
            let reference = equations.system.course_value(owner, CourseValue::Turn(number)).unwrap_or(Expr::ZERO);
            equations.system.arena.add(reference, deviation)
        };
        let inner = 1..stations.len().saturating_sub(1);
        let wrap = |number: usize| {
            let [before, after] = [number - 1, number].map(|number| angle(self, number));
            let turn = self.system.arena.subtract(after, before);
            if stations[number].is_left { turn } else { self.system.arena.negate(turn) }
        };
        inner.map(wrap).collect()
    }
}

/// By how much a rope lies around a pulley, and by how much its direction turns there. At an eye it turns either way.
fn wrap(arena: &mut Arena, [before, after]: [[Expr; 2]; 2], station: &Station) -> (Expr, Expr) {
    let side = arena.constant(if station.is_left { 1.0 } else { -1.0 });
    let turns = arena.constant(TAU * f64::from(station.turns));
    let is_eye = station.is_eye();
    let wrap = build(arena, [before[0], before[1], after[0], after[1], side, turns], |[x, y, u, v, side, turns]| {
        let part = (side * (x * v - y * u)).and(Binary::Atan2, x * u + y * v);
        let whole = part + part.number(TAU);
        let is_short = part.and(Binary::Less, part.number(-TOUCHING));
        if is_eye { part } else { is_short.select(whole, part) + turns }
    });
    (wrap, arena.multiply(side, wrap))
}
