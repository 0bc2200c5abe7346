//! Masses and inertias of bodies.

use crate::expr::{Expr, Property, Symbol};
use crate::model::BodyId;
use crate::network::System;

/// The mass of a body, or the mark that it is missing.
pub fn mass(system: &mut System, body: BodyId) -> Expr {
    match &system.mechanism.clone().bodies[body.0].mass {
        Some(mass) => system.value(mass),
        None => system.arena.symbol(Symbol::Missing(body.0, Property::Mass)),
    }
}

/// The inertia of a body, or the mark that it is missing; a body that cannot turn needs none.
pub fn inertia(system: &mut System, body: BodyId) -> Expr {
    match &system.mechanism.clone().bodies[body.0].inertia {
        Some(inertia) => system.value(inertia),
        None if system.cannot_turn(body) => Expr::ZERO,
        None => system.arena.symbol(Symbol::Missing(body.0, Property::Inertia)),
    }
}
