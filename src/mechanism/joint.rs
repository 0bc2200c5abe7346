//! Joints: what they permit, and the reactions with which they hold.

use super::{BodyId, Dimension, Formula, Place, Quantity};
use crate::scene::Span;

/// A joint: the second point (and body) relative to the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// The user's name.
    pub name: String,
    /// The points joined.
    pub between: [Place; 2],
    /// What it permits.
    pub kind: JointKind,
    /// Where it stands in the file.
    pub span: Span,
}

impl Joint {
    /// The points that it uses.
    pub fn places(&self) -> Vec<Place> {
        let [first, second] = self.between;
        match self.kind {
            JointKind::Rack { carrier, .. } => vec![first, second, carrier],
            _ => vec![first, second],
        }
    }
}

/// What a joint permits.
#[derive(Clone, Debug, PartialEq)]
pub enum JointKind {
    /// Turning about the common point.
    Revolute {
        /// [N.m.s]
        damping: Formula,
        /// Dry friction.
        friction: Option<Friction>,
    },
    /// Sliding along an axis fixed in the first body.
    Prismatic {
        /// Unit vector in the first body's axes.
        axis: [Formula; 2],
        /// Second body's angle minus the first's \[rad\].
        angle: Formula,
        /// [N.s/m]
        damping: Formula,
        /// Dry friction.
        friction: Option<Friction>,
    },
    /// Nothing.
    Weld {
        /// Second body's angle minus the first's \[rad\].
        angle: Formula,
    },
    /// The second point slides along a line fixed in the first body and turns freely.
    Slot {
        /// Unit vector in the first body's axes.
        axis: [Formula; 2],
        /// [N.s/m]
        damping: Formula,
        /// Dry friction.
        friction: Option<Friction>,
    },
    /// A disc about the second point rolls without slip on a line fixed in the first body, to the left of its axis.
    Rolling {
        /// Unit vector in the first body's axes.
        axis: [Formula; 2],
        /// Of the disc \[m\].
        radius: Formula,
        /// Of the centre along the axis where the relative angle is zero \[m\].
        displacement: Formula,
    },
    /// A constant distance between the points.
    Distance {
        /// \[m\]
        length: Formula,
    },
    /// The second body turns `ratio` times as far as the first, both against the carrier.
    Gear {
        /// `None` is the ground.
        carrier: Option<BodyId>,
        /// Negative if they turn against each other.
        ratio: Formula,
        /// Second wheel's angle where the first's is zero \[rad\].
        angle: Formula,
    },
    /// The second point moves along an axis of the carrier by `radius` times the angle that the first body, the pinion, turns against it.
    Rack {
        /// The point from which the displacement counts.
        carrier: Place,
        /// Unit vector in the carrier's axes.
        axis: [Formula; 2],
        /// Of the pinion \[m\]; negative if the rack goes back when the pinion turns forward.
        radius: Formula,
        /// Where the pinion's angle is zero \[m\].
        displacement: Formula,
    },
}

impl JointKind {
    /// The forces and torques with which it holds or couples.
    pub fn reactions(&self, dimension: Dimension) -> &'static [Quantity] {
        match self {
            JointKind::Weld { .. } if dimension == Dimension::One => &[Quantity::Fx],
            JointKind::Revolute { .. } => &[Quantity::Fx, Quantity::Fy],
            JointKind::Prismatic { .. } => &[Quantity::Fn, Quantity::Torque],
            JointKind::Weld { .. } => &[Quantity::Fx, Quantity::Fy, Quantity::Torque],
            JointKind::Slot { .. } => &[Quantity::Fn],
            JointKind::Rolling { .. } => &[Quantity::Fn, Quantity::Ft],
            JointKind::Distance { .. } => &[Quantity::Force],
            JointKind::Gear { .. } => &[Quantity::Torque],
            JointKind::Rack { .. } => &[Quantity::Force, Quantity::Torque],
        }
    }
}

/// Dry friction of a constant level, smooth through zero velocity: level x tanh(v / velocity).
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Level [N.m] or \[N\].
    pub coulomb: Formula,
    /// Velocity at which three quarters of the level act [rad/s] or [m/s].
    pub velocity: Formula,
}
