//! Armatures: what the accelerations of joints' coordinates alone move.

use super::{Arm, ArmEquations, ArmFactor, Equations, NoSeries};
use crate::equations::vector::FrameId;
use crate::expr::Expr;
use crate::network::{ElementId, RotationalRow, TranslationalRow};

impl Equations {
    /// Adds each armature to what has its rate: against a frame that does not turn, the inertia of the other; along an axis that does not turn, the mass of the
    /// displacement.
    ///
    /// # Errors
    /// An armature whose rate is that of no frame and no displacement.
    pub(super) fn armatures(&mut self, arms: &mut ArmEquations) -> Result<(), NoSeries> {
        for (index, element) in self.system.elements.clone().iter().enumerate() {
            let fits = match (&element.rotation, &element.translation) {
                (Some(row), _) if row.armature != Expr::ZERO => self.turning_armature(row, arms),
                (_, Some(row)) if row.armature != Expr::ZERO => self.sliding_armature(row, index, arms),
                _ => true,
            };
            if !fits {
                return Err(NoSeries(format!(
                    "the armature of `{joint}` is between two bodies that turn, or along an axis that turns",
                    joint = element.name
                )));
            }
        }
        Ok(())
    }

    fn turning_armature(&mut self, row: &RotationalRow, arms: &mut ArmEquations) -> bool {
        let [first, second] = row.ends.map(|node| self.kinematics.placement(node).0);
        let frame = match (first == FrameId::WORLD, second == FrameId::WORLD) {
            (true, true) => return true,
            (true, false) => second,
            (false, true) => first,
            (false, false) => return first == second,
        };
        let Some(turning) = arms.frames.iter_mut().find(|turning| turning.frame == frame) else { return false };
        turning.inertia = self.system.arena.add(turning.inertia, row.armature);
        true
    }

    fn sliding_armature(&mut self, row: &TranslationalRow, element: usize, arms: &mut ArmEquations) -> bool {
        let Some(&(direction, _)) = row.motion.first() else { return false };
        let (frame, _) = self.kinematics.direction(&mut self.system, direction);
        let place = self.coordinates.iter().position(|coordinate| coordinate.element == ElementId(element));
        let Some(index) = place.filter(|&index| frame == FrameId::WORLD && !self.coordinates[index].angular) else {
            return false;
        };
        let arm = Arm { frame: FrameId::WORLD, factor: ArmFactor::Displacement(index) };
        let arena = &mut self.system.arena;
        if arms.links.is_empty() {
            let [along, _] = arms.coupling.entry((arm, arm)).or_insert([Expr::ZERO; 2]);
            *along = arena.add(*along, row.armature);
            return true;
        }
        let Some(link) = arms.links.iter_mut().find(|link| link.arm == arm) else { return false };
        link.carried.inertia = arena.add(link.carried.inertia, row.armature);
        true
    }
}
