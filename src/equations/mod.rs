//! The equations of motion in branch coordinates (McPhee 1998, section 4):
//!
//! M qdd + Phi_q^T lambda = Q,  Phi(q, t) = 0   (22)

mod centred;
mod constraints;
pub(crate) mod couplings;
mod course;
pub(crate) mod dynamics;
mod feature;
mod feedback;
pub(crate) mod form;
pub(crate) mod inertias;
pub(crate) mod kinematics;
pub(crate) mod laws;
mod levels;
mod linear_law;
mod motion;
mod power;
mod record;
pub(crate) mod shares;
mod transfer;
pub(crate) mod variables;
pub(crate) mod vector;
mod vibration;

use std::collections::{BTreeMap, HashMap};

pub use constraints::{Constraint, Gap, RowKind, Standing, impulse_of};
pub use couplings::CoupledChord;
pub use dynamics::Dynamics;
use dynamics::{Laws, Sums};
pub use feedback::Feedback;
use kinematics::Kinematics;
pub(crate) use levels::if_positive;
pub use levels::{Level, Pressing};
pub use motion::{MotionLayout, MotionVariable};
pub use record::{Edge, EdgeRow, GraphRecord};
pub use shares::Share;
pub use vector::FrameId;
pub use vibration::{ElementColumn, NonlinearLoad, Vibration};

use crate::expr::{Expr, Order, Symbol};
use crate::model::{BodyId, Place, Variable};
use crate::network::{Angle, CoordinateName, ElementId, Rotation, System, TNode, Topology, Translation, Trees};

#[derive(Clone, Debug)]
pub struct Coordinate {
    pub element: ElementId,
    /// It, its rate and its acceleration.
    pub variables: [Variable; 3],
    pub name: CoordinateName,
    /// An angle \[rad\]? Otherwise a displacement \[m\].
    pub angular: bool,
}

#[derive(Clone, Debug)]
pub struct Equations {
    /// Elements, graphs and the arena of all expressions.
    pub system: System,
    pub trees: Trees,
    /// {q}: those of the translational tree first.
    pub coordinates: Vec<Coordinate>,
    /// {Phi}, with its derivatives.
    pub constraints: Vec<Constraint>,
    /// Rates of the states of the scene; they stand after {q} in the program.
    pub states: Vec<Expr>,
    pub(crate) kinematics: Kinematics,
    pub(crate) laws: Laws,
    dynamics: Option<Dynamics>,
    /// Forces and torques without \[M\], where paths are too deep for it.
    through: Option<Dynamics>,
    known: HashMap<Variable, Expr>,
    /// Do the numbers of the scene have names? Then the laws of loads keep theirs in formulas, and {Q} is shown in parts.
    pub symbolic: bool,
    /// The first coordinate of each element, and of angles.
    first: HashMap<(ElementId, bool), usize>,
}

impl Equations {
    /// True if drivers determine the motion: there are as many independent loop equations as coordinates.
    pub fn is_driven(&self) -> bool {
        self.rows_of(Standing::Imposed).len() == self.coordinates.len()
    }

    /// Steps 2 and 3: the kinematics. Step 1 is evaluated lazily ([`Equations::dynamics`]).
    pub fn new(mut system: System, trees: Trees) -> Self {
        let translation = Topology::new(&system.translation, &trees.translation);
        let rotation = Topology::new(&system.rotation, &trees.rotation);
        let BranchCoordinates { coordinates, t_first, r_first } = coordinates(&system, &trees);
        let kinematics = Kinematics::new(&mut system, &translation, &rotation, &t_first, &r_first);
        let constraints = constraints::constraints(&mut system, &kinematics, &trees.translation, &trees.rotation);
        let first = coordinates.iter().enumerate().rev();
        let first = first.map(|(index, coordinate)| ((coordinate.element, coordinate.angular), index)).collect();
        let mut equations = Equations {
            first,
            system,
            trees,
            coordinates,
            constraints,
            states: Vec::new(),
            kinematics,
            laws: Laws::default(),
            dynamics: None,
            through: None,
            known: HashMap::new(),
            symbolic: false,
        };
        equations.evaluate_laws();
        equations
    }

    /// Steps 1 and 4: \[M\], \[Phi_q\]^T and {Q}; formulated when first asked for.
    pub fn dynamics(&mut self) -> &Dynamics {
        let dynamics = match self.dynamics.take() {
            Some(dynamics) => dynamics,
            None => {
                let (translation, rotation) = self.topologies();
                let trees = ((&self.trees.translation, &translation), (&self.trees.rotation, &rotation));
                Dynamics::new(&mut self.system, &self.kinematics, trees, &self.constraints, &self.laws)
            }
        };
        self.dynamics.insert(dynamics)
    }

    fn topologies(&self) -> (Topology<Translation>, Topology<Rotation>) {
        let translation = Topology::new(&self.system.translation, &self.trees.translation);
        (translation, Topology::new(&self.system.rotation, &self.trees.rotation))
    }

    /// Forces and torques of all elements: with deep paths, without \[M\] and {Q}, which would grow with the square of the depth.
    fn loads(&mut self) -> &Dynamics {
        let nodes: Vec<TNode> = (0..self.system.mechanism.bodies.len())
            .map(|body| self.system.t_node(Place::Centre(BodyId(body))))
            .collect();
        if !nodes.iter().any(|&node| self.kinematics.is_deep(node)) {
            return self.dynamics();
        }
        let through = match self.through.take() {
            Some(through) => through,
            None => {
                for node in nodes {
                    self.kinematics.total(&mut self.system, node, Order::Acceleration);
                }
                let (translation, rotation) = self.topologies();
                let trees = ((&self.trees.translation, &translation), (&self.trees.rotation, &rotation));
                let Equations { system, kinematics, constraints, laws, .. } = self;
                let mut through = Dynamics::through(system, kinematics, trees, constraints, laws, Sums::InWorld).0;
                through.add_bearings(system, kinematics, constraints);
                through
            }
        };
        self.through.insert(through)
    }

    /// The loop equations of one standing.
    pub fn rows_of(&self, standing: Standing) -> Vec<usize> {
        let rows = self.constraints.iter().enumerate();
        rows.filter(|(_, row)| row.standing() == Some(standing)).map(|(index, _)| index).collect()
    }

    /// The loop equations that constrain the motion, with their indices: where a driver is parallel to its joint, the joint's circuit is an identity.
    pub fn loops(&self) -> impl Iterator<Item = (usize, &Constraint)> {
        self.constraints.iter().enumerate().filter(|(_, row)| !row.is_trivial() || !row.followers.is_empty())
    }

    /// By how much one constraint is open.
    pub fn gap(&mut self, row: usize) -> Expr {
        self.constraints[row].gap(&mut self.system.arena)
    }

    /// By how much each constraint is open.
    pub fn gaps(&mut self) -> Vec<Expr> {
        let arena = &mut self.system.arena;
        self.constraints.iter().map(|constraint| constraint.gap(arena)).collect()
    }

    /// {Phi_t} + \[Phi_q\]{v} of one constraint.
    pub fn constraint_rate(&mut self, index: usize) -> Expr {
        let Constraint { jacobian, time_rate, .. } = self.constraints[index].clone();
        let arena = &mut self.system.arena;
        let mut rate = time_rate;
        for (column, entry) in jacobian {
            let speed = arena.symbol(Symbol::Coordinate(column, Order::Velocity));
            rate = arena.add_product(rate, entry, speed);
        }
        rate
    }
}

/// The coordinates, and which is the first of each branch of both trees.
struct BranchCoordinates {
    coordinates: Vec<Coordinate>,
    t_first: BTreeMap<ElementId, usize>,
    r_first: BTreeMap<ElementId, usize>,
}

/// Numbers the coordinates.
fn coordinates(system: &System, trees: &Trees) -> BranchCoordinates {
    let of = |element, variables, angular| {
        let name = CoordinateName::of(&system.mechanism, variables);
        Coordinate { element, variables, name, angular }
    };
    let mut coordinates = Vec::new();
    let (mut t_first, mut r_first) = (BTreeMap::new(), BTreeMap::new());
    for &branch in &trees.translation.branches {
        if let Some(row) = &system.element(branch).translation {
            t_first.insert(branch, coordinates.len());
            for &(_, variables) in &row.motion {
                coordinates.push(of(branch, variables, false));
            }
        }
    }
    for &branch in &trees.rotation.branches {
        if let Some(&Angle::Free(variables)) = system.element(branch).rotation.as_ref().map(|row| &row.angle) {
            r_first.insert(branch, coordinates.len());
            coordinates.push(of(branch, variables, true));
        }
    }
    BranchCoordinates { coordinates, t_first, r_first }
}
