//! Sums along deep paths, made once and shared: all of them together grow with the number of nodes and not with its square.

use super::paths::DEEP;
use super::{Kinematics, PointMotion};
use crate::equations::form::LinearForm;
use crate::equations::vector::{FrameId, Vector};
use crate::expr::{Expr, Order};
use crate::model::Place;
use crate::network::{System, TNode};

/// Position, velocity and acceleration of a node in the axes of the world, as single expressions.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Totals([Option<[Expr; 2]>; 3]);

impl Kinematics {
    /// Position, velocity or acceleration of a node in the axes of the world, from that of the node before it: the nodes of one path share
    /// subexpressions, so that the cost grows with their number and not with its square.
    pub fn total(&mut self, system: &mut System, node: TNode, order: Order) -> [Expr; 2] {
        let mut pending = Vec::new();
        let mut at = node;
        let mut sum = loop {
            match (self.totals[at.index()].0[order as usize], &self.steps[at.index()]) {
                (Some(known), _) => break known,
                (None, Some(step)) => {
                    pending.push(at);
                    at = step.parent;
                }
                (None, None) => break [Expr::ZERO; 2],
            }
        };
        for node in pending.into_iter().rev() {
            let Some(step) = &self.steps[node.index()] else { continue };
            let part = self.in_world(system, &step.across, order);
            sum = [0, 1].map(|axis| system.arena.add(sum[axis], part[axis]));
            self.totals[node.index()].0[order as usize] = Some(sum);
        }
        sum
    }

    pub fn known_total(&self, node: TNode, order: Order) -> Option<[Expr; 2]> {
        self.totals[node.index()].0[order as usize]
    }

    /// Position and velocity across an element that is not part of the equations of motion itself: shared sums if it spans a deep path.
    pub fn spanned(&mut self, system: &mut System, ends: [TNode; 2]) -> PointMotion {
        let [from, to] = ends.map(|end| self.moving(end));
        if from + to <= DEEP + 2 * self.moving(self.meeting(ends)) {
            return self.across(&mut system.arena, ends);
        }
        let mut between = |system: &mut System, order: Order| {
            let [from, to] = ends.map(|end| self.total(system, end, order));
            Vector::fixed(FrameId::WORLD, [0, 1].map(|axis| system.arena.subtract(to[axis], from[axis])))
        };
        let (position, velocity) = (between(system, Order::Position), between(system, Order::Velocity));
        let velocity = LinearForm::term(&mut system.arena, Expr::ONE, &velocity);
        PointMotion { position, velocity, acceleration: LinearForm::default() }
    }

    /// Components of a motion in the axes of the world.
    fn in_world(&self, system: &mut System, motion: &PointMotion, order: Order) -> [Expr; 2] {
        [Vector::x(), Vector::y()].map(|axis| match order {
            Order::Position => motion.position.dot(&mut system.arena, &axis).total(&mut system.arena, &self.frames),
            Order::Velocity => self.component(system, &motion.velocity, &axis),
            Order::Acceleration => self.component(system, &motion.acceleration, &axis),
        })
    }

    /// [`Kinematics::total`] for a point of the scene at the end of a deep path, whether an element uses it or not.
    pub fn total_of_place(&mut self, system: &mut System, place: Place, order: Order) -> Option<[Expr; 2]> {
        if system.has_node(place) {
            let node = system.t_node(place);
            return self.is_deep(node).then(|| self.total(system, node, order));
        }
        let Place::Point(body, point) = place else { return None };
        let centre = system.t_node(Place::Centre(body));
        if !self.is_deep(centre) {
            return None;
        }
        let at =
            system.mechanism.clone().bodies[body.0].points[point].at.each_ref().map(|formula| system.value(formula));
        let arm = self.fixed(system, Some(body), at);
        let (sum, part) = (self.total(system, centre, order), self.in_world(system, &arm, order));
        Some([0, 1].map(|axis| system.arena.add(sum[axis], part[axis])))
    }
}
