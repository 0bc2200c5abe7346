//! Loads: forces, torques, springs and actuators.

use super::{BodyId, Formula, Place};
use crate::scene::Span;

/// A load.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// The user's name.
    pub name: String,
    /// What it is.
    pub kind: LoadKind,
    /// Where it stands in the file.
    pub span: Span,
}

/// What a load is.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadKind {
    /// A force on a point \[N\].
    Force {
        /// The point.
        on: Place,
        /// Components; the second is the number 0 in one dimension.
        vector: [Formula; 2],
        /// Are the components in the body's axes? Otherwise in the world's.
        in_body: bool,
    },
    /// A torque on the second body, its opposite on the first [N.m].
    Torque {
        /// `None` is the ground.
        between: [Option<BodyId>; 2],
        /// Counter-clockwise.
        value: Formula,
    },
    /// A spring and damper along the line between two points.
    Spring {
        /// The points.
        between: [Place; 2],
        /// Force by length \[N\] and \[m\].
        law: SpringLaw,
    },
    /// A torsion spring and damper.
    TorsionSpring {
        /// `None` is the ground.
        between: [Option<BodyId>; 2],
        /// Torque by angle [N.m] and \[rad\].
        law: SpringLaw,
    },
    /// A force law along the line between two points.
    Actuator {
        /// The points.
        between: [Place; 2],
        /// Positive pushes the points apart \[N\]. `length` and `rate` are resolved to this load's own variables.
        force: Formula,
    },
    /// A torque law between two bodies.
    TorsionActuator {
        /// `None` is the ground.
        between: [Option<BodyId>; 2],
        /// On the second body [N.m]. `angle` and `omega` are resolved to this load's own variables.
        torque: Formula,
    },
}

/// What a spring or torsion spring says: the force -k x - k3 x^3 - c x', with x from the free length (or angle).
#[derive(Clone, Debug, PartialEq)]
pub struct SpringLaw {
    /// k [N/m] or [N.m/rad]
    pub stiffness: Formula,
    /// k3 [N/m3] or [N.m/rad3]
    pub cubic: Formula,
    /// c [N.s/m] or [N.m.s]
    pub damping: Formula,
    /// Length \[m\] or angle \[rad\] where x is zero.
    pub free: Formula,
    /// Where it acts.
    pub side: Side,
}

/// On which side of its free length (or angle) a spring acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// Everywhere.
    #[default]
    Both,
    /// Where it is longer than free; it only pulls.
    Above,
    /// Where it is shorter than free; it only pushes.
    Below,
}
