//! Coordinates of other trees in terms of these.

use super::constraints::split;
use super::form::LinearForm;
use super::kinematics::{PointMotion, ScalarMotion};
use super::vector::Scalar;
use super::{Coordinate, Equations};
use crate::expr::{Expr, ExprNode, Order, Symbol};
use crate::model::{BodyId, Place};
use crate::network::{Direction, Known, TNode};

impl Equations {
    /// The position or rate that a coordinate of other trees of the same mechanism has.
    pub fn value_of(&mut self, coordinate: &Coordinate, order: Order) -> Expr {
        if let Some(index) = self.coordinate_of(coordinate) {
            return self.system.arena.symbol(Symbol::Coordinate(index, order));
        }
        if let Some(angle) = self.angle_of(coordinate) {
            let arena = &mut self.system.arena;
            return if order == Order::Velocity { angle.velocity.total(arena) } else { angle.position.total(arena) };
        }
        if let Some(total) = self.total_across(coordinate, order) {
            return total;
        }
        let Some((across, direction)) = self.free_motion(coordinate) else { return Expr::ZERO };
        let (_, axis) = self.kinematics.direction(&mut self.system, direction);
        if order == Order::Velocity {
            return self.kinematics.component(&mut self.system, &across.velocity, &axis);
        }
        let arena = &mut self.system.arena;
        across.position.dot(arena, &axis).total(arena, &self.kinematics.frames)
    }

    /// The angle across the element of a coordinate that is an angle.
    fn angle_of(&mut self, coordinate: &Coordinate) -> Option<ScalarMotion> {
        let row = self.system.element(coordinate.element).rotation.as_ref().filter(|_| coordinate.angular)?;
        let ends = row.ends;
        Some(self.kinematics.angle_across(&mut self.system.arena, ends))
    }

    /// A displacement from the datum, along an axis of the world, to the end of a deep path.
    fn total_across(&mut self, coordinate: &Coordinate, order: Order) -> Option<Expr> {
        let row = self.system.element(coordinate.element).translation.as_ref()?;
        let &(direction, _) = row.motion.iter().find(|(_, variables)| *variables == coordinate.variables)?;
        let axis = match direction {
            Direction::X => 0,
            Direction::Y => 1,
            Direction::Fixed(..) => return None,
        };
        let ends = row.ends;
        let deep = matches!(row.known, Known::Zero) && ends[0] == TNode::DATUM && self.kinematics.is_deep(ends[1]);
        deep.then(|| self.kinematics.total(&mut self.system, ends[1], order)[axis])
    }

    /// The acceleration that a coordinate of other trees has: coefficients by these coordinates' accelerations, and the rest. The
    /// coefficients are those of small displacements too.
    pub fn acceleration_of(&mut self, coordinate: &Coordinate) -> (Vec<(usize, Expr)>, Expr) {
        if let Some(index) = self.coordinate_of(coordinate) {
            return (vec![(index, Expr::ONE)], Expr::ZERO);
        }
        let form = self.acceleration_form(coordinate);
        split(&mut self.system.arena, &self.kinematics, &form, Order::Acceleration)
    }

    /// alpha, or s'' = a . u + s omega^2 along an axis that turns.
    fn acceleration_form(&mut self, coordinate: &Coordinate) -> LinearForm<Scalar> {
        if let Some(angle) = self.angle_of(coordinate) {
            return angle.acceleration.map(&mut self.system.arena, |_, &coefficient| Scalar::plain(coefficient));
        }
        let Some((across, direction)) = self.free_motion(coordinate) else { return LinearForm::default() };
        let (frame, axis) = self.kinematics.direction(&mut self.system, direction);
        let arena = &mut self.system.arena;
        let mut form = across.acceleration.map(arena, |arena, vector| vector.dot(arena, &axis));
        let square = arena.square(self.kinematics.frames.get(frame).omega);
        let displacement = across.position.dot(arena, &axis);
        form.add_term(arena, square, &displacement);
        form
    }

    /// The coordinates that move a body's centre, and its own angle.
    pub fn moved_by(&mut self, body: BodyId) -> Vec<usize> {
        let centre = self.system.t_node(Place::Centre(body));
        let velocity = self.kinematics.node(&mut self.system.arena, centre).velocity;
        let turning = &self.kinematics.angle(self.system.r_node(Some(body))).velocity;
        let keys = velocity.terms().map(|(key, _)| key).chain(turning.terms().map(|(key, _)| key));
        let mut coordinates: Vec<usize> = keys
            .filter_map(|key| match self.system.arena.node(key) {
                ExprNode::Symbol(Symbol::Coordinate(index, _)) => Some(index),
                _ => None,
            })
            .collect();
        coordinates.sort_unstable();
        coordinates.dedup();
        coordinates
    }

    /// How many angles a body's centre moves with through the translational tree.
    pub fn depth(&self, body: BodyId) -> usize {
        let centre = self.system.t_node(Place::Centre(body));
        self.kinematics.angles_between([TNode::DATUM, centre])
    }

    /// How many angles and displacements a body's centre moves with through the translational tree.
    pub fn moving(&self, body: BodyId) -> usize {
        self.kinematics.moving(self.system.t_node(Place::Centre(body)))
    }

    /// A coordinate of the element that a coordinate of other trees belongs to, or of any other if it has none.
    pub fn counterpart(&self, coordinate: &Coordinate) -> usize {
        let of = |angular| self.first.get(&(coordinate.element, angular)).copied();
        self.coordinate_of(coordinate).or_else(|| of(true)).or_else(|| of(false)).unwrap_or_default()
    }

    /// How many angles the largest loop that a chord closes has.
    pub fn largest_loop(&self) -> usize {
        let rows = self.trees.translation.chords.iter().filter_map(|&id| self.system.element(id).translation.as_ref());
        let holding = rows.filter(|row| !row.reaction.is_empty());
        holding.map(|row| self.kinematics.angles_between(row.ends)).max().unwrap_or(0)
    }

    /// Which of these coordinates it is, if it is one.
    fn coordinate_of(&self, coordinate: &Coordinate) -> Option<usize> {
        let first = *self.first.get(&(coordinate.element, coordinate.angular))?;
        let mut candidates =
            self.coordinates[first..].iter().take_while(|candidate| candidate.element == coordinate.element);
        candidates.position(|candidate| candidate.variables == coordinate.variables).map(|place| first + place)
    }

    /// The across variable of a coordinate's element without its known part, and the direction of the coordinate.
    fn free_motion(&mut self, coordinate: &Coordinate) -> Option<(PointMotion, Direction)> {
        let row = self.system.element(coordinate.element).translation.clone()?;
        let direction = row.motion.iter().find(|(_, variables)| *variables == coordinate.variables)?.0;
        let known = self.kinematics.known(&mut self.system, &row.known);
        let arena = &mut self.system.arena;
        let across = self.kinematics.across(arena, row.ends);
        Some((PointMotion::between(arena, &known, &across), direction))
    }
}
