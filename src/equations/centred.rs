//! Forces along a line whose ends come together. The direction of the line has no limit there, but these forces do: a spring of free length zero pulls with
//! -k r, and a damper between ends that can only part along a guide brakes with -c times the velocity along it. They are formulated so, without the length,
//! and are as smooth as the motion.

use super::Equations;
use super::form::{Coefficient, LinearForm};
use super::linear_law::{LinearLaw, OwnLaw};
use super::vector::{FrameId, Vector};
use crate::expr::{Arena, Expr, Order, Symbol};
use crate::model::{Dimension, Owner};
use crate::network::{ElementId, Force, Origin};

/// Directions are the same up to this angle: each component is a rotation of two products, so rounded by up to two units in the last place of the longer side.
const PARALLEL: f64 = 8.0 * f64::EPSILON;

/// A force that goes to a limit where its ends come together.
#[derive(Clone, Debug)]
pub struct Centred {
    /// From the first end to the second, and the force over it.
    pub across: Vector,
    pub density: Expr,
    /// The other terms: what is in proportion to the rate of a coordinate, and its direction.
    pub damped: Vec<(Expr, Vector)>,
}

impl Centred {
    pub fn force(&self, arena: &mut Arena) -> LinearForm<Vector> {
        let mut force = LinearForm::term(arena, self.density, &self.across);
        self.damped.iter().for_each(|(value, along)| force.add_term(arena, *value, along));
        force
    }
}

impl Equations {
    /// The force of an element, if it is one of these.
    pub fn centred(&mut self, id: ElementId) -> Option<Centred> {
        let element = self.system.element(id);
        let (Some(row), Origin::Load(load)) = (&element.translation, element.origin) else { return None };
        if !matches!(row.through, Force::Line(_)) || self.system.mechanism.dimension == Dimension::One {
            return None;
        }
        let ends = row.ends;
        if self.own_law(load) != OwnLaw::Centred || self.system.mechanism.there(Owner::Load(load)).is_some() {
            return None;
        }
        let across = self.kinematics.spanned(&mut self.system, ends).position;
        let LinearLaw { stiffness, damping, .. } = self.linear_law(load)?;
        let arena = &mut self.system.arena;
        let mut damped = Vec::new();
        if !damping.is_zero() {
            let (frame, slopes) = guide(arena, &across)?;
            for (coordinate, slope) in slopes {
                let rate = arena.symbol(Symbol::Coordinate(coordinate, Order::Velocity));
                let brake = arena.multiply(damping, rate);
                damped.push((arena.negate(brake), Vector::fixed(frame, slope)));
            }
        }
        Some(Centred { across, density: arena.negate(stiffness), damped })
    }
}

/// A coordinate, and the derivative of a displacement by it.
type Slope = (usize, [Expr; 2]);

/// The frame in which a displacement keeps its direction, and its derivatives by each coordinate that it depends on; none if it can turn there.
fn guide(arena: &mut Arena, across: &Vector) -> Option<(FrameId, Vec<Slope>)> {
    let mut parts = across.parts();
    let (frame, place) = parts.next().filter(|_| parts.next().is_none())?;
    let mut rest = place;
    let mut slopes = Vec::new();
    for symbol in arena.symbols(place) {
        match symbol {
            Symbol::Parameter(_) | Symbol::Discrete(_) => {}
            Symbol::Coordinate(index, Order::Position) => {
                let slope = place.map(|component| arena.derivative(component, symbol));
                rest = rest.map(|component| arena.substituted(component, symbol, Expr::ZERO));
                slopes.push((index, slope));
            }
            Symbol::Coordinate(..) | Symbol::Time | Symbol::Input(..) | Symbol::Follower(..) => return None,
            Symbol::State(..) | Symbol::Reaction(_) | Symbol::Missing(..) | Symbol::Argument => return None,
        }
    }
    let (_, first) = *slopes.first()?;
    let constant =
        |arena: &Arena, pair: [Expr; 2]| arena.symbols(pair).iter().all(|symbol| symbol.is_constant_between_instants());
    let along = slopes.iter().map(|(_, slope)| *slope).chain([rest]);
    let is_guide = along.into_iter().all(|along| constant(arena, along) && is_parallel(arena, first, along));
    is_guide.then_some((frame, slopes))
}

/// Is one pair of components a multiple of the other, up to rounding in turning both?
fn is_parallel(arena: &mut Arena, first: [Expr; 2], second: [Expr; 2]) -> bool {
    let number = |pair: [Expr; 2]| Some([arena.as_constant(pair[0])?, arena.as_constant(pair[1])?]);
    if let (Some([a, b]), Some([c, d])) = (number(first), number(second)) {
        return (a * d - b * c).abs() <= PARALLEL * a.hypot(b) * c.hypot(d);
    }
    arena.multiply(first[0], second[1]) == arena.multiply(first[1], second[0])
}
