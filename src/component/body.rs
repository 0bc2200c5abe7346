//! Rigid body (m): datum -> mass centre; F = -m a, T = -I alpha - sum r x F (Eqs 5, 6).

use crate::model::measure::{INERTIA, LENGTH, MASS};
use crate::model::{Quantity as Q, Range};
use crate::scene::key::{Form, Key};

/// What it is and its terminal equations, for the reference.
pub(super) const ABOUT: [&str; 2] = ["a rigid body", "F = -m (a - g), T = -I alpha - sum r x F"];

/// The keys of a body.
pub(crate) const KEYS: &[Key] = &[
    Key::default("mass", Form::Constant(MASS, Range::NotNegative), "its mass", "that of the shape"),
    Key::default(
        "inertia",
        Form::Constant(INERTIA, Range::NotNegative),
        "its moment of inertia about the mass centre",
        "that of the shape",
    ),
    Key::default(
        "com",
        Form::ConstantVector(LENGTH),
        "its mass centre in the frame of the points",
        "that of the shape, or the origin",
    ),
    Key::default("gravity", Form::Switch, "whether gravity acts on it", "`true`"),
    Key::default("points", Form::NamedPoints, "its points, in a frame that is fixed in it", "none"),
    Key::default("shape", Form::Shape, "a uniform [shape](#shapes) in the frame of the points", "none"),
    Key::default(
        "outline",
        Form::Outline,
        "its [outline](#outlines) in the frame of the points, for pictures and [clearance](#clearance)",
        "that of the shape",
    ),
];

/// Its variables.
pub const VARIABLES: &[Q] = &[Q::X, Q::Y, Q::Angle, Q::Vx, Q::Vy, Q::Omega, Q::Ax, Q::Ay, Q::Alpha];

/// Those of its points.
pub const POINT_VARIABLES: &[Q] = &[Q::X, Q::Y, Q::Vx, Q::Vy, Q::Ax, Q::Ay];
