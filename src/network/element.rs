//! Elements: a component's edge in one or both graphs, its row of Table 1 (McPhee 1998) with its motion and reaction spaces, and its
//! place in Tables 2 and 3.

use std::f64::consts::TAU;

use super::graph::{RNode, TNode};
use super::{Resistance, System};
use crate::expr::{Arena, Expr, Symbol, Unary, build};
use crate::model::{BodyId, Dimension, DriverId, Formula, JointId, LoadId, Mechanism, Owner, Part, Quantity, Variable};

/// Priorities of Table 2: which elements the translational tree takes first.
pub mod table2 {
    pub const ARM: u8 = 1;
    pub const POSITION_DRIVER: u8 = 2;
    pub const REVOLUTE: u8 = 3;
    pub const PRISMATIC: u8 = 4;
    pub const BODY: u8 = 5;
    pub const FORCE: u8 = 6;
}

/// Priorities of Table 3: which elements the rotational tree takes first.
pub mod table3 {
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
    Body(BodyId),
    /// The vector from a body's mass centre to one of its points.
    Arm(BodyId, usize),
    /// The vector from the origin to a ground point.
    GroundVector(usize),
    Joint(JointId),
    Driver(DriverId),
    Load(LoadId),
    /// One of the relations that the joints imply.
    Implied(usize),
    /// One of what parts hold on one side only.
    Contact(usize),
    /// One of the rates that events set.
    SetRate(usize),
}

impl Origin {
    /// The element of a joint, driver or load; nothing else that owns variables is a part.
    pub fn of(owner: Owner) -> Option<Self> {
        match owner {
            Owner::Joint(joint) => Some(Origin::Joint(joint)),
            Owner::Driver(driver) => Some(Origin::Driver(driver)),
            Owner::Load(load) => Some(Origin::Load(load)),
            Owner::Place(_) | Owner::System => None,
        }
    }
}

/// The rows of a component in Table 1, before it has a number.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// Its letter in the paper.
    pub letter: &'static str,
    /// Its edge in the translational graph.
    pub translation: Option<TranslationalRow>,
    /// Its edge in the rotational graph.
    pub rotation: Option<RotationalRow>,
    /// A relation that it imposes beside what its edges hold.
    pub coupling: Option<Coupling>,
    /// Further edges of the same part, each an element of its own.
    pub others: Vec<Rows>,
}

/// A component of the scene: an edge in one or both graphs.
#[derive(Clone, Debug)]
pub struct Element {
    /// Letter and number as in the paper, such as `h9`.
    pub label: String,
    /// The user's name for it.
    pub name: String,
    pub origin: Origin,
    pub translation: Option<TranslationalRow>,
    pub rotation: Option<RotationalRow>,
    /// A relation that it imposes beside what its edges hold.
    pub coupling: Option<Coupling>,
    /// If it does not always hold: 1 while it does, else 0. It is a chord in every tree.
    pub closed: Option<Expr>,
    /// If it rubs while it does not hold: 1 or -1 while it slips that way, else 0.
    pub slip: Option<Expr>,
}

/// A linear relation between across variables of either graph: sum of factor x across = offset. Every term stands for a chord
/// whose through variable is factor x reaction (the transposed relation), so that a coupling does no work.
#[derive(Clone, Debug)]
pub struct Coupling {
    /// At least one; the first gives the reaction its unit and direction.
    pub terms: Vec<CouplingTerm>,
    /// The constant on the right.
    pub offset: Expr,
}

impl Coupling {
    /// An across variable alone: it is zero.
    pub(crate) fn of(port: Port) -> Coupling {
        Coupling { terms: vec![CouplingTerm { factor: Expr::ONE, port }], offset: Expr::ZERO }
    }

    /// The function by which it couples, and between which bodies.
    pub fn curve(&self) -> Option<([RNode; 2], Curve)> {
        self.terms
            .iter()
            .find_map(|term| if let Port::Curve(ends, curve) = term.port { Some((ends, curve)) } else { None })
    }

    /// Where it holds, it does so again where its value is this much more: a curve repeats every turn, and the angle that it gives to another body is that of a direction, as a heading is.
    pub fn period(&self, arena: &mut Arena) -> Option<Expr> {
        let is_angle = |term: &CouplingTerm| matches!(term.port, Port::Angle(_));
        let is_curve = |term: &CouplingTerm| matches!(term.port, Port::Curve(..));
        let heading = self.terms.iter().find(|term| matches!(term.port, Port::Heading(_))).map(|term| term.factor);
        let turns = self.terms.iter().any(is_angle) && self.terms.iter().any(is_curve);
        let turn = arena.constant(TAU);
        heading.map(|factor| arena.multiply(turn, factor)).or(turns.then_some(turn))
    }
}

/// A term of a coupling.
#[derive(Clone, Copy, Debug)]
pub struct CouplingTerm {
    pub factor: Expr,
    /// What is multiplied.
    pub port: Port,
}

/// A pair of nodes, and which part of the across variable between them a coupling uses.
#[derive(Clone, Copy, Debug)]
pub enum Port {
    Angle([RNode; 2]),
    /// The displacement between two points along a direction.
    Along([TNode; 2], Direction),
    Length([TNode; 2]),
    /// The direction angle of the displacement between two points, which have a distance.
    Heading([TNode; 2]),
    /// A function of the angle between two bodies.
    Curve([RNode; 2], Curve),
    /// The distance of the second point from a line or an arc, which is given from the first point in the axes of a body.
    Feature([TNode; 2], Option<BodyId>, Touched),
    /// The tangent of two circles about two points: its length L and, with its direction phi, L - (R_2 - R_1) phi. Its derivative by the displacement is the unit tangent.
    Span([TNode; 2], CircleTangent),
}

/// The tangent of two circles, with the radii R_1 and R_2: positive where the centre is on its left, zero of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CircleTangent {
    /// R_2 - R_1
    pub difference: Expr,
    /// The direction from which its own counts, less than half a turn away \[rad\].
    pub reference: Expr,
}

/// A line or an arc that a point touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Touched {
    /// Its normal in a point of it.
    pub normal: [Expr; 2],
    /// That point.
    pub at: [Expr; 2],
    /// Positive where it is convex.
    pub curvature: Expr,
    /// By how much the point is further from it: from no feature, whose normal is zero.
    pub away: Expr,
}

/// A function of an angle that repeats every turn, with what is known of the contact that it stands for. All of it is in terms of
/// [`Symbol::Argument`], the angle within the turn.
#[derive(Clone, Copy, Debug)]
pub struct Curve {
    /// The function, its first and its second derivative.
    pub value: [Expr; 3],
    /// The reaction of the coupling for a normal force of one.
    pub leverage: Expr,
    /// From the direction in which the contact moves what is coupled to the common normal.
    pub pressure: Expr,
    /// Curvature of the profile, positive where it is convex.
    pub curvature: Expr,
    /// The body in whose axes the loads of the bearings are; `None` is the ground.
    pub carrier: Option<BodyId>,
    /// What the contact makes other joints carry.
    pub bearings: [Bearing; 2],
}

/// What a joint carries because a force passes through it that its coupling replaces by the load along a guide, for a reaction of one.
#[derive(Clone, Copy, Debug)]
pub struct Bearing {
    pub joint: JointId,
    /// The force on its second point.
    pub force: [Expr; 2],
    /// The torque on its second body.
    pub torque: Expr,
}

impl Curve {
    /// One of its expressions at an angle.
    pub fn at(arena: &mut Arena, expr: Expr, angle: Expr) -> Expr {
        let within = build(arena, [angle], |[angle]| {
            let turn = angle.number(TAU);
            angle - turn * (angle / turn).of(Unary::Floor)
        });
        arena.substituted(expr, Symbol::Argument, within)
    }
}

/// What a loop equation constrains of an across variable, so that its reaction is along or about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constrained {
    /// An angle; the reaction is a torque.
    Angle,
    /// A displacement along a direction; the reaction is a force.
    Along(Direction),
    /// The distance between two points; the reaction is a force along the line through them.
    Length,
}

impl Port {
    /// What it contributes to a loop equation.
    pub fn constrained(self) -> Constrained {
        match self {
            Port::Angle(_) | Port::Curve(..) => Constrained::Angle,
            Port::Along(_, direction) => Constrained::Along(direction),
            Port::Length(_) | Port::Heading(_) | Port::Span(..) | Port::Feature(..) => Constrained::Length,
        }
    }
}

/// A known function of time with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FunctionOfTime {
    pub value: Expr,
    pub rate: Expr,
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

impl Direction {
    /// The body that it turns with.
    pub fn carrier(self) -> Option<BodyId> {
        self.in_body().0
    }

    /// The body that it turns with, and its unit vector there.
    pub fn in_body(self) -> (Option<BodyId>, [Expr; 2]) {
        match self {
            Direction::X => (None, [Expr::ONE, Expr::ZERO]),
            Direction::Y => (None, [Expr::ZERO, Expr::ONE]),
            Direction::Fixed(body, unit) => (body, unit),
        }
    }
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
    pub(crate) fn of(mechanism: &Mechanism, variables: [Variable; 3]) -> Self {
        let [position, rate, acceleration] = variables.map(|variable| mechanism.variable_name(variable));
        CoordinateName { position, rate, acceleration }
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
    /// Motion space: what the element leaves free, with the coordinate that it brings as a branch, its rate and its acceleration.
    pub motion: Vec<(Direction, [Variable; 3])>,
    /// Reaction space: what it holds; a multiplier each as a chord.
    pub reaction: Vec<Direction>,
    /// The part of the through variable that is no reaction.
    pub through: Force,
    /// The rotor inertia that resists the acceleration along the only direction of the motion space \[kg\].
    pub armature: Expr,
}

impl TranslationalRow {
    /// The body that the across variable turns with: r x F appears in its torque equation (Eq. 6).
    pub fn carrier(&self) -> Option<BodyId> {
        let known = match self.known {
            Known::Fixed(body, _) | Known::Along(body, ..) => body,
            Known::Zero | Known::Given(_) => None,
        };
        let directions = self.motion.iter().map(|(direction, _)| direction).chain(&self.reaction);
        known.or_else(|| directions.copied().find_map(Direction::carrier))
    }
}

/// The known part of a displacement.
#[derive(Clone, Debug)]
pub enum Known {
    /// r = 0.
    Zero,
    /// r = R(theta) r', fixed in a body or the ground.
    Fixed(Option<BodyId>, [Expr; 2]),
    /// r = r(t) in the world.
    Given([FunctionOfTime; 2]),
    /// r = s(t) u, with u fixed in a body or the ground.
    Along(Option<BodyId>, [Expr; 2], FunctionOfTime),
}

/// Constitutive force: the load on the element's second node.
#[derive(Clone, Debug)]
pub enum Force {
    /// Reaction only.
    None,
    /// F = -m (a - g).
    Inertia(BodyId),
    /// Against the motion along the only direction of the motion space.
    Resistance(Resistance),
    /// Components in the world.
    World([Formula; 2]),
    /// Components in a body's axes.
    InBody(BodyId, [Formula; 2]),
    /// Pushes the nodes apart along the line through them.
    Line(Formula),
    /// Pushes the nodes apart along a tangent of circles about them.
    Tangent(Formula, CircleTangent),
}

impl Force {
    /// Multiplies a law.
    pub(super) fn scale(&mut self, factor: &Formula) {
        let laws = match self {
            Force::World(laws) | Force::InBody(_, laws) => &mut laws[..],
            Force::Line(law) | Force::Tangent(law, _) => std::slice::from_mut(law),
            Force::None | Force::Inertia(_) | Force::Resistance(_) => return,
        };
        laws.iter_mut().for_each(|law| *law = std::mem::replace(law, Formula::Time) * factor.clone());
    }
}

/// An element's row of Table 1 in the rotational graph.
#[derive(Clone, Debug)]
pub struct RotationalRow {
    /// From, to.
    pub ends: [RNode; 2],
    /// Place in Table 3.
    pub priority: u8,
    pub angle: Angle,
    /// The part of the through variable that is no reaction.
    pub through: Torque,
    /// The rotor inertia that resists the acceleration of the angle [kg.m2].
    pub armature: Expr,
}

/// The angle across an element.
#[derive(Clone, Debug)]
pub enum Angle {
    /// Free: a coordinate as a branch.
    Free([Variable; 3]),
    Constant(Expr),
    Given(FunctionOfTime),
}

/// Constitutive torque: the load on the element's second node.
#[derive(Clone, Debug)]
pub enum Torque {
    /// Reaction only.
    None,
    /// T = -I alpha - sum r x F over the body's arms and prismatic axes.
    Inertia(BodyId),
    /// Against the motion.
    Resistance(Resistance),
    Law(Formula),
}

impl Torque {
    /// Multiplies a law.
    pub(super) fn scale(&mut self, factor: &Formula) {
        match self {
            Torque::Law(law) => *law = std::mem::replace(law, Formula::Time) * factor.clone(),
            Torque::None | Torque::Inertia(_) | Torque::Resistance(_) => {}
        }
    }
}

impl TranslationalRow {
    /// r = 0: the points stay together.
    pub(crate) fn pin(system: &System, part: &Part) -> TranslationalRow {
        let plane = system.mechanism.dimension == Dimension::Two;
        TranslationalRow {
            ends: part.between.map(|place| system.t_node(place)),
            priority: table2::REVOLUTE,
            known: Known::Zero,
            motion: Vec::new(),
            reaction: if plane { vec![Direction::X, Direction::Y] } else { vec![Direction::X] },
            through: Force::None,
            armature: Expr::ZERO,
        }
    }

    /// A force between two points, or on one: it holds nothing, so as a branch its displacement is a pair of coordinates (one in one
    /// dimension).
    pub(crate) fn force(system: &System, part: &Part, ends: [TNode; 2], through: Force) -> TranslationalRow {
        let along = |direction, quantities| (direction, part.owner.motion(quantities));
        let motion = match system.mechanism.dimension {
            Dimension::One => vec![along(Direction::X, Quantity::STRETCH)],
            Dimension::Two => vec![along(Direction::X, Quantity::ALONG_X), along(Direction::Y, Quantity::ALONG_Y)],
        };
        let (priority, known, reaction) = (table2::FORCE, Known::Zero, Vec::new());
        TranslationalRow { ends, priority, known, motion, reaction, through, armature: Expr::ZERO }
    }
}

impl RotationalRow {
    /// The angle is free.
    pub(crate) fn free(system: &System, part: &Part) -> RotationalRow {
        RotationalRow {
            ends: part.bodies().map(|body| system.r_node(body)),
            priority: table3::REVOLUTE,
            angle: Angle::Free(part.owner.motion(Quantity::TURN)),
            through: Torque::None,
            armature: Expr::ZERO,
        }
    }

    /// The angle is held.
    pub(crate) fn held(system: &System, part: &Part, angle: Expr) -> RotationalRow {
        RotationalRow {
            priority: table3::PRISMATIC,
            angle: Angle::Constant(angle),
            ..RotationalRow::free(system, part)
        }
    }
}
