//! States in the arm form. z' = g is the equation of motion of a mass along an arm of its own: its rate is z, its force the mass times g, and where it is
//! nobody asks. So states are in every series, and in all that is made of them.

use super::tree::Carried;
use super::{Arm, ArmEquations, ArmFactor, ArmLink, ArmPush, Equations};
use crate::equations::vector::FrameId;
use crate::expr::Expr;

impl Equations {
    /// Adds an arm with this mass for each state.
    pub(super) fn state_arms(&mut self, mass: f64, arms: &mut ArmEquations) {
        let mass = self.system.arena.constant(mass);
        let along = [mass, Expr::ZERO];
        for (index, &rate) in self.motion_layout().states().zip(&self.states) {
            let arm = Arm { frame: FrameId::WORLD, factor: ArmFactor::Displacement(index) };
            if arms.links.is_empty() {
                arms.coupling.insert((arm, arm), along);
            } else {
                let carried = Carried { mass, moment: along, inertia: mass };
                let begin = [Expr::ZERO; 2];
                arms.links.push(ArmLink { arm, parent: None, begin, carried, heavy: Carried::default() });
            }
            arms.pushes.push(ArmPush { on: Err(index), value: rate, factor: mass });
        }
    }
}
