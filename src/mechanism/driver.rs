//! Drivers: motions that are prescribed.

use super::{BodyId, Dimension, Formula, InputId, JointId, Place, Quantity};
use crate::scene::Span;

/// A prescribed motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Driver {
    /// The user's name.
    pub name: String,
    /// What is prescribed.
    pub kind: DriverKind,
    /// Where it stands in the file.
    pub span: Span,
}

/// What a driver prescribes.
#[derive(Clone, Debug, PartialEq)]
pub enum DriverKind {
    /// The angle of the second body minus the first's; `None` is the ground.
    Angle {
        /// First and second body.
        between: [Option<BodyId>; 2],
        /// The revolute joint named by the user, if one was.
        joint: Option<JointId>,
        /// The motion \[rad\].
        motion: Motion,
    },
    /// The displacement of a prismatic joint \[m\].
    Displacement {
        /// A prismatic joint.
        joint: JointId,
        /// The motion \[m\].
        motion: Motion,
    },
    /// The position of a point in the world \[m\]; one component in one dimension (the second is then the number 0).
    Position {
        /// The point.
        on: Place,
        /// World components.
        position: [Formula; 2],
    },
}

/// A scalar motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A function of time, parameters and inputs.
    Given(Formula),
    /// An input is the rate: integrated.
    Velocity(InputId),
    /// An input is the acceleration: integrated twice.
    Acceleration(InputId),
}

impl DriverKind {
    /// The forces and torques that it takes.
    pub fn efforts(&self, dimension: Dimension) -> &'static [Quantity] {
        match (self, dimension) {
            (DriverKind::Angle { .. }, _) => &[Quantity::Torque],
            (DriverKind::Displacement { .. }, _) => &[Quantity::Force],
            (DriverKind::Position { .. }, Dimension::One) => &[Quantity::Fx],
            (DriverKind::Position { .. }, Dimension::Two) => &[Quantity::Fx, Quantity::Fy],
        }
    }
}
