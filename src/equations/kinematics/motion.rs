//! The motion of a point and of a scalar, with derivatives as linear forms.

use crate::equations::form::{Coefficient, LinearForm};
use crate::equations::vector::Vector;
use crate::expr::{Arena, Expr, Order, Symbol};
use crate::network::FunctionOfTime;

/// Position, velocity and acceleration of a point, or across an element.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointMotion {
    pub position: Vector,
    /// v, linear in the rates.
    pub velocity: LinearForm<Vector>,
    /// a, linear in the accelerations.
    pub acceleration: LinearForm<Vector>,
}

impl PointMotion {
    /// self += factor x other
    pub fn accumulate(&mut self, arena: &mut Arena, factor: Expr, other: &PointMotion) {
        let position = other.position.scaled(arena, factor);
        self.position.accumulate(arena, &position);
        self.velocity.accumulate(arena, factor, &other.velocity);
        self.acceleration.accumulate(arena, factor, &other.acceleration);
    }

    pub fn between(arena: &mut Arena, from: &PointMotion, to: &PointMotion) -> PointMotion {
        let mut motion = to.clone();
        let minus = arena.constant(-1.0);
        motion.accumulate(arena, minus, from);
        motion
    }
}

/// An angle or a displacement along an axis, with its derivatives as linear forms.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScalarMotion {
    pub position: LinearForm<Expr>,
    pub velocity: LinearForm<Expr>,
    pub acceleration: LinearForm<Expr>,
}

impl ScalarMotion {
    pub(super) fn constant(arena: &mut Arena, value: Expr) -> Self {
        ScalarMotion { position: LinearForm::term(arena, Expr::ONE, &value), ..Default::default() }
    }

    pub(super) fn coordinate(arena: &mut Arena, index: usize) -> Self {
        let [q, v, a] = Order::ALL.map(|order| {
            let symbol = arena.symbol(Symbol::Coordinate(index, order));
            LinearForm::term(arena, symbol, &Expr::ONE)
        });
        ScalarMotion { position: q, velocity: v, acceleration: a }
    }

    pub(super) fn signal(arena: &mut Arena, signal: FunctionOfTime) -> Self {
        let [position, velocity, acceleration] =
            [signal.value, signal.rate, signal.acceleration].map(|value| LinearForm::term(arena, value, &Expr::ONE));
        ScalarMotion { position, velocity, acceleration }
    }

    /// self += factor x other
    pub fn accumulate(&mut self, arena: &mut Arena, factor: Expr, other: &ScalarMotion) {
        self.position.accumulate(arena, factor, &other.position);
        self.velocity.accumulate(arena, factor, &other.velocity);
        self.acceleration.accumulate(arena, factor, &other.acceleration);
    }
}
