//! Applied forces and torques by arms: the displacements that they work along, and their values.

use super::linear::conjugate_product;
use super::{Arm, ArmEquations, ArmFactor, ArmLoad, ArmPush, Arms, Equations, MOST, NoSeries};
use crate::equations::dynamics::resisting_force;
use crate::equations::form::Coefficient;
use crate::equations::inertias::mass;
use crate::equations::vector::{FrameId, Vector};
use crate::expr::Expr;
use crate::model::{BodyId, Owner, Quantity, Variable};
use crate::network::{ElementId, Force, Origin, Torque, TranslationalRow};

impl Equations {
    pub(super) fn force(&mut self, id: ElementId, arms: &mut ArmEquations) -> Result<(), NoSeries> {
        let Some(row) = self.system.element(id).translation.clone() else { return Ok(()) };
        if let Force::Tangent(..) = row.through {
            return Err(NoSeries(format!("`{}` runs over pulleys", self.system.element(id).name)));
        }
        if !arms.links.is_empty() {
            if matches!(row.through, Force::None | Force::Inertia(_)) {
                return Ok(());
            }
            arms.spanned += self.kinematics.angles_between(row.ends);
            if arms.spanned > MOST {
                return Err(NoSeries("it has many equations that are weakly coupled".to_owned()));
            }
        }
        let straight = self.kinematics.across(&mut self.system.arena, row.ends).position;
        let across = self.decompose(&straight)?;
        if let Some(value) = self.along_deep_line(id, &row, &straight) {
            arms.loads.push(ArmLoad { across: across.clone(), value, along: across.clone() });
        } else {
            for (value, vector) in self.applied(id, &row) {
                let along = self.decompose(&vector)?;
                match self.slides(&across, &along) {
                    Some(slides) => {
                        let push = |(index, factor)| ArmPush { on: Err(index), value, factor };
                        arms.pushes.extend(slides.into_iter().map(push));
                    }
                    None => arms.loads.push(ArmLoad { across: across.clone(), value, along }),
                }
            }
        }
        if let (Force::Line(_), Origin::Load(load)) = (&row.through, self.system.element(id).origin) {
            let [length, rate] = [Quantity::Length, Quantity::Rate]
                .map(|quantity| self.variable(Variable { owner: Owner::Load(load), quantity }));
            arms.lines.push((length, rate, across));
        }
        Ok(())
    }

    /// Force over length along a line whose ends are so far apart in the tree that what lies between is known by shared sums, which are no combination of arms.
    fn along_deep_line(&mut self, id: ElementId, row: &TranslationalRow, straight: &Vector) -> Option<Expr> {
        let Force::Line(law) = &row.through else { return None };
        let (density, across) = self.density(id, row.ends, law);
        (across != *straight).then_some(density)
    }

    /// Forces on the second node that are no reactions, by the scalars that they are made of; weight among them.
    fn applied(&mut self, id: ElementId, row: &TranslationalRow) -> Vec<(Expr, Vector)> {
        let force = match &row.through {
            Force::None => return Vec::new(),
            Force::Inertia(body) => return self.weight(*body, row),
            Force::Resistance(law) => resisting_force(&mut self.system, &self.kinematics, row, *law),
            Force::World(_) | Force::InBody(..) | Force::Line(_) | Force::Tangent(..) => {
                self.laws.forces.get(&id).cloned().unwrap_or_default()
            }
        };
        force.terms().map(|(value, vector)| (value, vector.clone())).collect()
    }

    /// Weights of bodies that hang from each other: on each link that of all that it carries.
    pub(super) fn weights(&mut self, arms: &mut ArmEquations) {
        let gravity = self.system.mechanism.clone().gravity.each_ref().map(|component| self.system.value(component));
        if gravity == [Expr::ZERO; 2] {
            return;
        }
        let along = Arms::from([(Arm::of(FrameId::WORLD), gravity)]);
        for link in arms.links.iter().filter(|link| link.heavy.moment != [Expr::ZERO; 2]) {
            let across = Arms::from([(link.arm, link.heavy.moment)]);
            arms.loads.push(ArmLoad { across, value: Expr::ONE, along: along.clone() });
        }
    }

    fn weight(&mut self, body: BodyId, row: &TranslationalRow) -> Vec<(Expr, Vector)> {
        let gravity = self.system.mechanism.clone().gravity.each_ref().map(|component| self.system.value(component));
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
            let [parallel, normal] = conjugate_product(arena, z, *direction);
            let same = *force == Arm::of(arm.frame) && arm.frame != FrameId::WORLD;
            if !same || !normal.is_zero() {
                return None;
            }
            if let ArmFactor::Displacement(index) = arm.factor {
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
                arms.pushes.push(ArmPush { on: Ok(frame), value, factor });
            }
        }
    }
}
