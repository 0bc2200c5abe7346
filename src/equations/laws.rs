//! Loads as functions of positions, velocities, inputs and time.

use super::Equations;
use super::form::{Coefficient, LinearForm};
use super::vector::Vector;
use crate::expr::Expr;
use crate::model::translate::translate;
use crate::model::{BodyId, Formula};
use crate::network::{Constrained, Direction, ElementId, Force, TNode, Torque};

impl Equations {
    /// Evaluates the terminal equations of all force and torque actuators, and the rates of the states.
    pub(super) fn evaluate_laws(&mut self) {
        let mechanism = std::sync::Arc::clone(&self.system.mechanism);
        for index in 0..self.system.elements.len() {
            let id = ElementId(index);
            let element = &self.system.elements[index];
            let force = element.translation.as_ref().map(|row| (row.through.clone(), row.ends));
            let torque = element.rotation.as_ref().map(|row| row.through.clone());
            if let Some(force) = force.and_then(|(through, ends)| self.force_of_law(id, &through, ends)) {
                self.laws.forces.insert(id, force);
            }
            if let Some(Torque::Law(law)) = torque {
                let torque = self.law(id, Constrained::Angle, &law);
                self.laws.torques.insert(id, torque);
            }
        }
        self.states = mechanism.states.iter().map(|state| self.formula(&state.rate)).collect();
    }

    /// The force of a law; none of what exerts none by a law.
    fn force_of_law(&mut self, id: ElementId, through: &Force, ends: [TNode; 2]) -> Option<LinearForm<Vector>> {
        match through {
            Force::World(vector) => Some(self.components(id, None, vector)),
            Force::InBody(body, vector) => Some(self.components(id, Some(*body), vector)),
            Force::Line(law) => Some(self.line_force(id, ends, law)),
            Force::Tangent(law, tangent) => {
                let (value, unit) = (self.law(id, Constrained::Length, law), self.unit_tangent(ends, *tangent));
                Some(LinearForm::term(&mut self.system.arena, value, &unit))
            }
            Force::None | Force::Inertia(_) | Force::Resistance(_) => None,
        }
    }

    /// The values of all laws: forces, torques, damping and friction.
    pub fn law_values(&mut self) -> Vec<Expr> {
        let mut values: Vec<Expr> = self.laws.forces.values().flat_map(LinearForm::keys).collect();
        values.extend(self.laws.torques.values());
        values.extend(&self.states);
        values.extend(self.feedback().iter().map(|law| law.value));
        for index in 0..self.system.elements.len() {
            let element = &self.system.elements[index];
            let (translation, rotation) = (element.translation.clone(), element.rotation.clone());
            values.push(self.resisting_force(translation.as_ref()));
            values.push(self.resisting_torque(rotation.as_ref()));
        }
        values
    }

    pub fn formula(&mut self, formula: &Formula) -> Expr {
        // Variables need the whole formulation, not the arena alone: they are expressed first.
        formula.visit(&mut |part| {
            if let Formula::Variable(variable) = part {
                self.variable(*variable);
            }
        });
        let known = &self.known;
        translate(&mut self.system.arena, formula, &mut |_, variable| {
            known.get(&variable).copied().unwrap_or(Expr::ZERO)
        })
    }

    fn components(&mut self, id: ElementId, body: Option<BodyId>, vector: &[Formula; 2]) -> LinearForm<Vector> {
        let mut force = LinearForm::default();
        let axes = [(Direction::X, [Expr::ONE, Expr::ZERO]), (Direction::Y, [Expr::ZERO, Expr::ONE])];
        for (component, (along, axis)) in vector.iter().zip(axes) {
            let value = self.law(id, Constrained::Along(along), component);
            let (_, along) = self.kinematics.direction(&mut self.system, Direction::Fixed(body, axis));
            force.add_term(&mut self.system.arena, value, &along);
        }
        force
    }

    /// F = f d / |d|
    fn line_force(&mut self, id: ElementId, ends: [TNode; 2], law: &Formula) -> LinearForm<Vector> {
        if let Some(centred) = self.centred(id) {
            return centred.force(&mut self.system.arena);
        }
        if law.reads_the_motion() {
            // The multiplier that stands for the law is to be a term of its own, as those of reactions are.
            let value = self.law(id, Constrained::Length, law);
            let across = self.kinematics.spanned(&mut self.system, ends).position;
            let length = self.length(&across);
            let arena = &mut self.system.arena;
            let along = arena.divide(Expr::ONE, length);
            let along = across.scaled(arena, along);
            return LinearForm::term(arena, value, &along);
        }
        let (density, across) = self.density(id, ends, law);
        LinearForm::term(&mut self.system.arena, density, &across)
    }

    /// f / |d| and d
    pub(crate) fn density(&mut self, id: ElementId, ends: [TNode; 2], law: &Formula) -> (Expr, Vector) {
        if let Some(centred) = self.centred(id).filter(|centred| centred.damped.is_empty()) {
            return (centred.density, centred.across);
        }
        let value = self.formula(law);
        let across = self.kinematics.spanned(&mut self.system, ends).position;
        let length = self.length(&across);
        (self.system.arena.divide(value, length), across)
    }

    /// |d|^2 between two points.
    pub fn square_of_length(&mut self, ends: [TNode; 2]) -> Expr {
        let across = self.kinematics.spanned(&mut self.system, ends).position;
        let arena = &mut self.system.arena;
        across.dot(arena, &across).total(arena, &self.kinematics.frames)
    }

    pub(super) fn length(&mut self, across: &Vector) -> Expr {
        let arena = &mut self.system.arena;
        let square = across.dot(arena, across).total(arena, &self.kinematics.frames);
        if square.is_zero() { Expr::ZERO } else { arena.unary(crate::expr::Unary::Sqrt, square) }
    }
}
