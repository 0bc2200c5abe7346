//! The frames that turn, their inertia, and the masses between arms.

use std::collections::BTreeMap;

use super::linear::{conjugate_product, linear};
use super::{Arm, ArmEquations, ArmFactor, Arms, Equations, NoSeries, Turning};
use crate::equations::inertias::{inertia, mass};
use crate::expr::Expr;
use crate::model::BodyId;
use crate::network::Origin;

impl Equations {
    pub(super) fn turning(&mut self) -> Result<Vec<Turning>, NoSeries> {
        let frames: Vec<_> = self.kinematics.frames.iter().skip(1).map(|(id, f)| (id, f.angle, f.unit)).collect();
        let mut turning = Vec::new();
        for (frame, angle, unit) in frames {
            let mut terms = Vec::new();
            linear(&mut self.system.arena, angle, Expr::ONE, &mut terms)?;
            let mut part =
                Turning { frame, coordinates: BTreeMap::new(), signal: Expr::ZERO, inertia: Expr::ZERO, unit };
            for (factor, coefficient) in terms {
                match (factor, self.system.arena.as_constant(coefficient)) {
                    (ArmFactor::Displacement(index), Some(sign)) => {
                        part.coordinates.insert(index, sign);
                    }
                    (ArmFactor::Signal(signal), _) => {
                        let arena = &mut self.system.arena;
                        part.signal = arena.add_product(part.signal, coefficient, signal);
                    }
                    // The constant part of a function of time.
                    (ArmFactor::One, _) => part.signal = self.system.arena.add(part.signal, coefficient),
                    (ArmFactor::Displacement(_), None) => {
                        return Err(NoSeries("an angle is scaled by a parameter".to_owned()));
                    }
                }
            }
            turning.push(part);
        }
        Ok(turning)
    }

    /// The frames' own inertias.
    pub(super) fn inertias(&mut self, arms: &mut ArmEquations) {
        for body in (0..self.system.mechanism.bodies.len()).map(BodyId) {
            let node = self.system.r_node(Some(body));
            if let Some(place) = arms.place(self.kinematics.placement(node).0) {
                let inertia = inertia(&mut self.system, body);
                arms.frames[place].inertia = self.system.arena.add(arms.frames[place].inertia, inertia);
            }
        }
    }

    pub(super) fn masses(&mut self, arms: &mut ArmEquations) -> Result<(), NoSeries> {
        for index in 0..self.system.mechanism.bodies.len() {
            let body = BodyId(index);
            let Some(element) = self.system.find(Origin::Body(body)).map(|id| self.system.element(id)) else {
                continue;
            };
            let rotation = element.rotation.as_ref().map(|row| row.ends);
            let translation = element.translation.as_ref().map(|row| row.ends);
            if let Some(place) = rotation.and_then(|ends| arms.place(self.kinematics.placement(ends[1]).0)) {
                let inertia = inertia(&mut self.system, body);
                let turning = &mut arms.frames[place];
                turning.inertia = self.system.arena.add(turning.inertia, inertia);
            }
            if let Some(ends) = translation {
                let centre = self.kinematics.node(&mut self.system.arena, ends[1]).position.clone();
                let centre = self.decompose(&centre)?;
                self.mass(body, &centre, arms);
            }
        }
        Ok(())
    }

    fn mass(&mut self, body: BodyId, centre: &Arms, arms: &mut ArmEquations) {
        let moving: Vec<(Arm, [Expr; 2])> =
            centre.iter().filter(|(arm, _)| !arm.is_constant()).map(|(a, z)| (*a, *z)).collect();
        if moving.is_empty() {
            return;
        }
        let mass = mass(&mut self.system, body);
        let arena = &mut self.system.arena;
        for &(k, z) in &moving {
            for &(l, y) in &moving {
                let product = conjugate_product(arena, z, y).map(|part| arena.multiply(mass, part));
                match arms.place(k.frame).filter(|_| k == l && k == Arm::of(k.frame)) {
                    Some(place) => arms.frames[place].inertia = arena.add(arms.frames[place].inertia, product[0]),
                    None => {
                        let entry = arms.coupling.entry((k, l)).or_insert([Expr::ZERO; 2]);
                        *entry = [arena.add(entry[0], product[0]), arena.add(entry[1], product[1])];
                    }
                }
            }
        }
    }
}
