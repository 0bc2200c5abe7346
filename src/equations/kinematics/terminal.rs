//! Terminal equations of the across variables: rigid arms, displacements along an axis, prescribed motions (Table 1).

use super::{Kinematics, PointMotion, ScalarMotion};
use crate::equations::form::{Coefficient, LinearForm};
use crate::equations::vector::{FrameId, MovingFrame, Scalar, Vector};
use crate::expr::{Arena, Expr};
use crate::model::BodyId;
use crate::network::{Angle, Direction, Element, Known, System, TranslationalRow};

impl Kinematics {
    /// The frame of a body, and components given in its axes in those of the frame.
    pub fn in_frame(&self, system: &mut System, body: Option<BodyId>, [x, y]: [Expr; 2]) -> (FrameId, Vector) {
        let (frame, offset) = self.placement[system.r_node(body).index()];
        let arena = &mut system.arena;
        let (c, s) = (arena.cos(offset), arena.sin(offset));
        let [cx, sy, sx, cy] = [(c, x), (s, y), (s, x), (c, y)].map(|(a, b)| arena.multiply(a, b));
        let components = [arena.subtract(cx, sy), arena.add(sx, cy)];
        (frame, Vector::fixed(frame, components))
    }

    /// A direction as a vector, and the frame that it turns with.
    pub fn direction(&self, system: &mut System, direction: Direction) -> (FrameId, Vector) {
        match direction {
            Direction::X => (FrameId::WORLD, Vector::x()),
            Direction::Y => (FrameId::WORLD, Vector::y()),
            Direction::Fixed(body, unit) => self.in_frame(system, body, unit),
        }
    }

    /// The known part of an element's across variable.
    pub fn known(&self, system: &mut System, known: &Known) -> PointMotion {
        match *known {
            Known::Zero => PointMotion::default(),
            Known::Fixed(body, at) => self.fixed(system, body, at),
            Known::Along(body, unit, signal) => {
                let displacement = ScalarMotion::signal(&mut system.arena, signal);
                self.along(system, body, unit, &displacement)
            }
            Known::Given([x, y]) => {
                let [x, y] = [x, y].map(|signal| ScalarMotion::signal(&mut system.arena, signal));
                let mut motion = self.along(system, None, [Expr::ONE, Expr::ZERO], &x);
                let vertical = self.along(system, None, [Expr::ZERO, Expr::ONE], &y);
                motion.accumulate(&mut system.arena, Expr::ONE, &vertical);
                motion
            }
        }
    }

    pub fn fixed(&self, system: &mut System, body: Option<BodyId>, at: [Expr; 2]) -> PointMotion {
        let unit = ScalarMotion::constant(&mut system.arena, Expr::ONE);
        self.along(system, body, at, &unit)
    }

    pub(super) fn across_branch(
        &self,
        system: &mut System,
        row: &TranslationalRow,
        first: Option<usize>,
    ) -> PointMotion {
        let mut motion = self.known(system, &row.known);
        for (offset, (direction, _)) in row.motion.iter().enumerate() {
            let coordinate = ScalarMotion::coordinate(&mut system.arena, first.unwrap_or_default() + offset);
            let (body, unit) = direction.in_body();
            let along = self.along(system, body, unit, &coordinate);
            motion.accumulate(&mut system.arena, Expr::ONE, &along);
        }
        motion
    }

    /// Terminal equations of r = s u, with u fixed in a body that turns with omega:
    /// v = s' u + s omega (k x u), a = s'' u + 2 s' omega (k x u) + s alpha (k x u) - s omega^2 u.
    /// A rigid arm is the case of constant s (Table 1).
    fn along(&self, system: &mut System, body: Option<BodyId>, unit: [Expr; 2], s: &ScalarMotion) -> PointMotion {
        let (frame, u) = self.in_frame(system, body, unit);
        let arena = &mut system.arena;
        let frame = self.frames.get(frame);
        let across = u.turned(arena);
        let length = s.position.total(arena);
        let [position, tangent] = [&u, &across].map(|unit| unit.scaled(arena, length));
        let (velocity, acceleration) = turning(
            arena,
            frame,
            [&position, &tangent],
            [&s.velocity, &s.acceleration],
            |arena, &c| u.scaled(arena, c),
            |arena, &c| across.scaled(arena, c),
        );
        PointMotion { position, velocity, acceleration }
    }
}

/// A displacement projected on a direction that turns, with its total derivatives:
/// g.d, g'.d + omega g.(k x d), g''.d + 2 omega g'.(k x d) + alpha g.(k x d) - omega^2 g.d.
pub fn project(
    kinematics: &Kinematics,
    arena: &mut Arena,
    gap: &PointMotion,
    (frame, direction): &(FrameId, Vector),
) -> (Scalar, LinearForm<Scalar>, LinearForm<Scalar>) {
    let frame = kinematics.frames.get(*frame);
    let across = direction.turned(arena);
    let [along, beside] = [direction, &across].map(|direction| gap.position.dot(arena, direction));
    let (velocity, acceleration) = turning(
        arena,
        frame,
        [&along, &beside],
        [&gap.velocity, &gap.acceleration],
        |arena, v| v.dot(arena, direction),
        |arena, v| v.dot(arena, &across),
    );
    (along, velocity, acceleration)
}

/// First and second derivative of a product x u that is linear in a unit vector u which turns with a frame. Given are x u and x (k x u), the
/// derivatives of x, and the products of their coefficients with u and with k x u:
/// x' u + omega x (k x u), x'' u + 2 omega x' (k x u) + alpha x (k x u) - omega^2 x u.
fn turning<X: Coefficient, C: Coefficient>(
    arena: &mut Arena,
    frame: &MovingFrame,
    [along, across]: [&C; 2],
    [rate, second]: [&LinearForm<X>; 2],
    by_unit: impl Fn(&mut Arena, &X) -> C,
    by_normal: impl Fn(&mut Arena, &X) -> C,
) -> (LinearForm<C>, LinearForm<C>) {
    let mut velocity = rate.map(arena, &by_unit);
    let turning = frame.rate.map(arena, |arena, &c| across.scaled(arena, c));
    velocity.accumulate(arena, Expr::ONE, &turning);
    let mut acceleration = second.map(arena, &by_unit);
    let coriolis = rate.times(arena, frame.omega).map(arena, &by_normal);
    let two = arena.constant(2.0);
    acceleration.accumulate(arena, two, &coriolis);
    let tangential = frame.acceleration.map(arena, |arena, &c| across.scaled(arena, c));
    acceleration.accumulate(arena, Expr::ONE, &tangential);
    let square = arena.square(frame.omega);
    let centripetal = LinearForm::term(arena, square, along);
    let minus = arena.constant(-1.0);
    acceleration.accumulate(arena, minus, &centripetal);
    (velocity, acceleration)
}

/// Known part of the angle across an element, or its coordinate.
pub(super) fn angle_of(arena: &mut Arena, element: &Element, coordinate: Option<usize>) -> ScalarMotion {
    match element.rotation.as_ref().map(|row| &row.angle) {
        Some(Angle::Free(_)) => ScalarMotion::coordinate(arena, coordinate.unwrap_or_default()),
        Some(known) => known_angle(arena, known),
        None => ScalarMotion::default(),
    }
}

/// The part of an angle across an element that its terminal equation prescribes.
pub fn known_angle(arena: &mut Arena, angle: &Angle) -> ScalarMotion {
    match angle {
        Angle::Free(_) => ScalarMotion::default(),
        Angle::Constant(value) => ScalarMotion::constant(arena, *value),
        Angle::Given(signal) => ScalarMotion::signal(arena, *signal),
    }
}
