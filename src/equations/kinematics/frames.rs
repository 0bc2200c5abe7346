//! Angles of the bodies, and the frames that turn with them.

use std::collections::BTreeMap;

use super::terminal::angle_of;
use super::{FirstCoordinate, ScalarMotion};
use crate::equations::form::LinearForm;
use crate::equations::vector::{FrameId, Frames, MovingFrame};
use crate::expr::{Arena, Expr, ExprNode};
use crate::network::{OutwardNode, Rotation, System, Topology};

pub(super) fn angles(
    system: &mut System,
    rotation: &Topology<Rotation>,
    coordinates: &FirstCoordinate,
) -> Vec<ScalarMotion> {
    let mut angles = vec![ScalarMotion::default(); system.rotation.nodes()];
    for OutwardNode { node, parent, branch, sign } in rotation.outward() {
        let across = angle_of(&mut system.arena, &system.elements[branch.0], coordinates.get(&branch).copied());
        let mut angle = angles[parent.index()].clone();
        let sign = system.arena.constant(f64::from(sign));
        angle.accumulate(&mut system.arena, sign, &across);
        angles[node.index()] = angle;
    }
    angles
}

/// Bodies whose angles differ by a constant share a frame.
pub(super) fn frames(arena: &mut Arena, angles: &[ScalarMotion]) -> (Frames, Vec<(FrameId, Expr)>) {
    let mut frames = Frames::default();
    let mut known: BTreeMap<Vec<(Expr, Expr)>, FrameId> = BTreeMap::from([(Vec::new(), FrameId::WORLD)]);
    let mut placement = Vec::new();
    for angle in angles {
        let mut moving = LinearForm::default();
        let mut offset = Expr::ZERO;
        for (key, &coefficient) in angle.position.terms() {
            if is_constant(arena, key) {
                offset = arena.add_product(offset, key, coefficient);
            } else {
                moving.add_term(arena, key, &coefficient);
            }
        }
        let key: Vec<(Expr, Expr)> = moving.terms().map(|(k, &c)| (k, c)).collect();
        let frame = known.entry(key).or_insert_with(|| {
            let total = moving.total(arena);
            let unit = [arena.cos(total), arena.sin(total)];
            let omega = angle.velocity.total(arena);
            let (rate, acceleration) = (angle.velocity.clone(), angle.acceleration.clone());
            frames.push(MovingFrame { unit, rate, acceleration, omega, angle: total })
        });
        placement.push((*frame, offset));
    }
    (frames, placement)
}

/// Does an expression depend on nothing but parameters?
pub fn is_constant(arena: &Arena, expr: Expr) -> bool {
    match arena.node(expr) {
        ExprNode::Constant(_) => true,
        ExprNode::Symbol(symbol) => symbol.is_constant_between_instants(),
        _ => arena.symbols([expr]).iter().all(|symbol| symbol.is_constant_between_instants()),
    }
}
