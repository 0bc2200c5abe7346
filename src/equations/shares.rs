//! Parts of the loads: {Q} is linear in what acts, so each part has a column of its own.

use super::Equations;
use super::dynamics::{Dynamics, Laws};
use crate::expr::Expr;
use crate::network::{ElementId, Origin};

/// A part of what acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Share {
    /// Forces, torques, actuators: laws without stored energy.
    Applied,
    /// Weights.
    Gravity,
    /// Inertia: accelerations, and with them centrifugal and Coriolis forces.
    Velocity,
    /// Springs, with their dampers.
    Elastic,
    /// Damping and friction in joints.
    Resistance,
    /// One element alone.
    Element(ElementId),
}

impl Laws {
    /// Does a part of an element's force or torque count?
    pub fn counts(&self, id: ElementId, share: Share) -> bool {
        match self.only {
            None => true,
            Some(Share::Element(only)) => only == id,
            Some(only) => only == share,
        }
    }
}

impl Equations {
    /// {Q} in parts; those that are zero are left out.
    pub fn load_shares(&mut self) -> Vec<(Share, Vec<Expr>)> {
        let all = [Share::Applied, Share::Gravity, Share::Velocity, Share::Elastic, Share::Resistance];
        let shares = all.into_iter().map(|share| (share, self.share_of(share).load));
        shares.filter(|(_, load)| load.iter().any(|entry| *entry != Expr::ZERO)).collect()
    }

    pub fn share_of(&mut self, share: Share) -> Dynamics {
        let mut laws = Laws { only: Some(share), ..self.laws.clone() };
        laws.forces.retain(|id, _| self.acts(*id, share));
        laws.torques.retain(|id, _| self.acts(*id, share));
        let (translation, rotation) = self.topologies();
        let trees = ((&self.trees.translation, &translation), (&self.trees.rotation, &rotation));
        Dynamics::new(&mut self.system, &self.kinematics, trees, &self.constraints, &laws)
    }

    /// Does the law of a load belong to a part?
    fn acts(&self, id: ElementId, share: Share) -> bool {
        let mechanism = &self.system.mechanism;
        let stores =
            matches!(self.system.element(id).origin, Origin::Load(load) if mechanism.loads[load.0].energy().is_some());
        match share {
            Share::Element(only) => only == id,
            Share::Elastic => stores,
            Share::Applied => !stores,
            Share::Gravity | Share::Velocity | Share::Resistance => false,
        }
    }
}
