//! Applied forces and torques by arms: the displacements that they work along, and their values.

use super::linear::conjugate_product;
use super::{Arm, ArmEquations, Arms, Equations, Factor, Load, Push, Reason};
use crate::component::{Force, Origin, Torque, TranslationalRow};
use crate::equations::dynamics::resisting_force;
use crate::equations::form::Coefficient;
use crate::equations::inertias::mass;
use crate::equations::vector::{FrameId, Vector};
use crate::expr::Expr;
use crate::graph::ElementId;
use crate::mechanism::{BodyId, Owner, Quantity, Variable};

impl Equations<'_> {
    pub(super) fn force(&mut self, id: ElementId, arms: &mut ArmEquations) -> Result<(), Reason> {
        let Some(row) = self.system.element(id).translation.clone() else { return Ok(()) };
        let across = self.kinematics.across(&mut self.system.arena, row.ends).position;
        let across = self.decompose(&across)?;
        for (value, vector) in self.applied(id, &row) {
            let along = self.decompose(&vector)?;
            match self.slides(&across, &along) {
                Some(slides) => {
                    arms.pushes.extend(slides.into_iter().map(|(index, factor)| Push { on: Err(index), value, factor }))
                }
                None => arms.loads.push(Load { across: across.clone(), value, along }),
            }
        }
        if let (Force::Line(_), Origin::Load(load)) = (&row.through, self.system.element(id).origin) {
            let [length, rate] = [Quantity::Length, Quantity::Rate]
                .map(|quantity| self.variable(Variable { owner: Owner::Load(load), quantity }));
            arms.lines.push((length, rate, across));
        }
        Ok(())
    }

    /// Forces on the second node that are no reactions, by the scalars that they are made of; weight among them.
    fn applied(&mut self, id: ElementId, row: &TranslationalRow) -> Vec<(Expr, Vector)> {
        let force = match &row.through {
            Force::None => return Vec::new(),
            Force::Inertia(body) => return self.weight(*body, row),
            Force::Resistance(law) => resisting_force(&mut self.system, &self.kinematics, row, *law),
            Force::World(_) | Force::InBody(..) | Force::Line(_) => {
                self.laws.forces.get(&id).cloned().unwrap_or_default()
            }
        };
        force.terms().map(|(value, vector)| (value, vector.clone())).collect()
    }

    fn weight(&mut self, body: BodyId, row: &TranslationalRow) -> Vec<(Expr, Vector)> {
        let gravity = self.system.mechanism.gravity.each_ref().map(|component| self.system.value(component));
        let moves = self.kinematics.node(&mut self.system.arena, row.ends[1]).position != Vector::default();
        if gravity == [Expr::ZERO; 2] || !moves || self.system.mechanism.bodies[body.0].weightless {
            return Vec::new();
        }
        let mass = mass(&mut self.system, body);
        let arena = &mut self.system.arena;
        let vector = Vector::fixed(FrameId::WORLD, gravity.map(|component| arena.multiply(mass, component)));
        vec![(Expr::ONE, vector)]
    }

    /// A force parallel to a slide works along its displacement only: displacements with the factors of the force. None if it is
    /// any other force.
    fn slides(&mut self, across: &Arms, along: &Arms) -> Option<Vec<(usize, Expr)>> {
        let (force, direction) = along.iter().next().filter(|_| along.len() == 1)?;
        let arena = &mut self.system.arena;
        let mut slides = Vec::new();
        for (arm, &z) in across {
            let [parallel, beside] = conjugate_product(arena, z, *direction);
            let same = *force == Arm::of(arm.frame) && arm.frame != FrameId::WORLD;
            if !same || !beside.is_zero() {
                return None;
            }
            if let Factor::Displacement(index) = arm.factor {
                slides.push((index, parallel));
            }
        }
        Some(slides)
    }

    pub(super) fn torque(&mut self, id: ElementId, arms: &mut ArmEquations) {
        let Some(row) = self.system.element(id).rotation.clone() else { return };
        let arena = &mut self.system.arena;
        let value = match row.through {
            Torque::None | Torque::Inertia(_) => return,
            Torque::Resistance(law) => {
                let rate = self.kinematics.angle_across(arena, row.ends).velocity.total(arena);
                law.at(arena, rate)
            }
            Torque::Law(_) => self.laws.torques.get(&id).copied().unwrap_or(Expr::ZERO),
        };
        for (node, sign) in row.ends.into_iter().zip([-1.0, 1.0]) {
            let (frame, _) = self.kinematics.placement(node);
            if frame != FrameId::WORLD && !value.is_zero() {
                let factor = self.system.arena.constant(sign);
                arms.pushes.push(Push { on: Ok(frame), value, factor });
            }
        }
    }
}
