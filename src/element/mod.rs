//! Components: each file is one component's row of Table 1 (McPhee 1998), with its motion and reaction spaces and its
//! place in Tables 2 and 3. Nothing else in the program knows what components there are.

mod arm;
mod body;
mod displacement_driver;
mod force;
mod line;
mod position_driver;
mod prismatic;
mod revolute;
mod rotation_driver;
mod system;
mod torque;
mod weld;

pub use system::System;

use crate::expr::Expr;
use crate::graph::{RNode, TNode};
use crate::mechanism::{BodyId, DriverId, Formula, JointId, LoadId};

/// Priorities of Table 2: which elements the translational tree takes first.
pub mod table2 {
    #![allow(missing_docs, reason = "the names are those of the table")]
    pub const ARM: u8 = 1;
    pub const POSITION_DRIVER: u8 = 2;
    pub const REVOLUTE: u8 = 3;
    pub const PRISMATIC: u8 = 4;
    pub const BODY: u8 = 5;
    pub const FORCE: u8 = 6;
}

/// Priorities of Table 3: which elements the rotational tree takes first.
pub mod table3 {
    #![allow(missing_docs, reason = "the names are those of the table")]
    pub const ROTATION_DRIVER: u8 = 1;
    pub const PRISMATIC: u8 = 2;
    pub const BODY_WITH_ARMS: u8 = 3;
    pub const BODY: u8 = 4;
    pub const REVOLUTE: u8 = 5;
    pub const TORQUE: u8 = 6;
}

/// What an element stands for in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Origin {
    /// A rigid body.
    Body(BodyId),
    /// The vector from a body's mass centre to one of its points.
    Arm(BodyId, usize),
    /// The vector from the origin to a ground point.
    GroundVector(usize),
    /// A joint.
    Joint(JointId),
    /// A driver.
    Driver(DriverId),
    /// A load.
    Load(LoadId),
}

/// A component of the scene: an edge in one or both graphs.
#[derive(Clone, Debug)]
pub struct Element {
    /// Letter and number as in the paper, such as `h9`.
    pub label: String,
    /// The user's name for it.
    pub name: String,
    /// What it stands for.
    pub origin: Origin,
    /// Its edge in the translational graph.
    pub translation: Option<TranslationalRow>,
    /// Its edge in the rotational graph.
    pub rotation: Option<RotationalRow>,
}

/// A known function of time with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// Its value.
    pub value: Expr,
    /// First time derivative.
    pub rate: Expr,
    /// Second time derivative.
    pub acceleration: Expr,
}

/// A direction in which a displacement or force is projected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// World X.
    X,
    /// World Y.
    Y,
    /// A unit vector fixed in a body (or the ground).
    Fixed(Option<BodyId>, [Expr; 2]),
}

/// The names of a branch coordinate, its rate and its acceleration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CoordinateName {
    /// Such as `crank.angle`.
    pub position: String,
    /// Such as `crank.omega`.
    pub rate: String,
    /// Such as `crank.alpha`.
    pub acceleration: String,
}

impl CoordinateName {
    fn new(owner: &str, [position, rate, acceleration]: [&str; 3]) -> Self {
        CoordinateName {
            position: format!("{owner}.{position}"),
            rate: format!("{owner}.{rate}"),
            acceleration: format!("{owner}.{acceleration}"),
        }
    }
}

/// An element's row of Table 1 in the translational graph.
#[derive(Clone, Debug)]
pub struct TranslationalRow {
    /// From, to.
    pub ends: [TNode; 2],
    /// Place in Table 2.
    pub priority: u8,
    /// The part of the across variable that is no coordinate.
    pub known: Known,
    /// Motion space: what the element leaves free, with the coordinate that it brings as a branch.
    pub motion: Vec<(Direction, CoordinateName)>,
    /// Reaction space: what it holds; a multiplier each as a chord.
    pub reaction: Vec<Direction>,
    /// The part of the through variable that is no reaction.
    pub through: Force,
}

/// The known part of a displacement.
#[derive(Clone, Debug)]
pub enum Known {
    /// r = 0.
    Zero,
    /// r = R(theta) r', fixed in a body or the ground.
    Fixed(Option<BodyId>, [Expr; 2]),
    /// r = r(t) in the world.
    Given([Signal; 2]),
    /// r = s(t) u, with u fixed in a body or the ground.
    Along(Option<BodyId>, [Expr; 2], Signal),
}

/// Constitutive force: the load on the element's second node.
#[derive(Clone, Debug)]
pub enum Force {
    /// Reaction only.
    None,
    /// F = -m (a - g).
    Inertia(BodyId),
    /// F = -c v along the only direction of the motion space.
    Damping(Expr),
    /// Components in the world.
    World([Formula; 2]),
    /// Components in a body's axes.
    InBody(BodyId, [Formula; 2]),
    /// Pushes the nodes apart along the line through them.
    Line(Formula),
}

/// An element's row of Table 1 in the rotational graph.
#[derive(Clone, Debug)]
pub struct RotationalRow {
    /// From, to.
    pub ends: [RNode; 2],
    /// Place in Table 3.
    pub priority: u8,
    /// The angle.
    pub angle: Angle,
    /// The part of the through variable that is no reaction.
    pub through: Torque,
}

/// The angle across an element.
#[derive(Clone, Debug)]
pub enum Angle {
    /// Free: a coordinate as a branch.
    Free(CoordinateName),
    /// Held constant.
    Constant(Expr),
    /// Prescribed.
    Given(Signal),
}

/// Constitutive torque: the load on the element's second node.
#[derive(Clone, Debug)]
pub enum Torque {
    /// Reaction only.
    None,
    /// T = -I alpha - sum r x F over the body's arms and prismatic axes.
    Inertia(BodyId),
    /// T = -c omega.
    Damping(Expr),
    /// A law.
    Law(Formula),
}
