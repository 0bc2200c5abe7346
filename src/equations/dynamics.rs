//! Through variables, and Step 1: the cutset equations of branches, projected on their motion spaces.
//!
//! Every force and torque is a linear form in the accelerations of the coordinates, the reactions, products of rates, and
//! loads. The chord transformation (Eq. 9) is evaluated from the leaves of the tree inwards, which is the recursion that the paper
//! finds in Eqs (49)-(55).

use std::collections::HashMap;

use super::constraints::{Constraint, Standing, split};
use super::couplings::{self, Couplings};
use super::form::{Coefficient, LinearForm};
use super::inertias::{inertia, mass};
use super::kinematics::Kinematics;
use super::shares::Share;
use super::vector::{FrameId, Scalar, Vector};
use crate::expr::{Arena, Expr, ExprNode, Order, Symbol};
use crate::model::BodyId;
use crate::network::{
    Angle, Constrained, Curve, Direction, ElementId, Force, Origin, OutwardNode, Resistance, Rotation, RotationalRow,
    System, Topology, Torque, Translation, TranslationalRow, Tree,
};

/// Forces and torques of all elements, and the projected cutset equations.
#[derive(Clone, Debug, Default)]
pub struct Dynamics {
    forces: HashMap<ElementId, LinearForm<Vector>>,
    torques: HashMap<ElementId, LinearForm<Scalar>>,
    /// \[M\], by rows: (column, entry).
    pub mass: Vec<Vec<(usize, Expr)>>,
    /// The coefficients of the reactions in the cutset equations, by rows: (constraint, entry). Equal to \[Phi_q\]^T.
    pub reactions: Vec<Vec<(usize, Expr)>>,
    /// {Q}
    pub load: Vec<Expr>,
}

/// Constitutive loads as expressions of positions and velocities: the terminal equations of loads.
#[derive(Clone, Debug, Default)]
pub struct Laws {
    pub forces: HashMap<ElementId, LinearForm<Vector>>,
    pub torques: HashMap<ElementId, Expr>,
    /// What is left of all forces and torques; everything if there is nothing.
    pub only: Option<Share>,
}

pub(super) type Rooted<'a> =
    ((&'a Tree<Translation>, &'a Topology<Translation>), (&'a Tree<Rotation>, &'a Topology<Rotation>));

/// How forces and torques are summed along the trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sums {
    /// By accelerations, reactions and frames, so that \[M\] can be read off.
    ByKey,
    /// As components in the axes of the world, one expression each: long paths share theirs.
    InWorld,
}

impl Sums {
    fn of_force(self, system: &mut System, kinematics: &Kinematics, force: LinearForm<Vector>) -> LinearForm<Vector> {
        match self {
            Sums::ByKey => force,
            Sums::InWorld => {
                let components = [Vector::x(), Vector::y()].map(|axis| kinematics.component(system, &force, &axis));
                LinearForm::term(&mut system.arena, Expr::ONE, &Vector::fixed(FrameId::WORLD, components))
            }
        }
    }

    fn of_torque(self, system: &mut System, kinematics: &Kinematics, torque: LinearForm<Scalar>) -> LinearForm<Scalar> {
        match self {
            Sums::ByKey => torque,
            Sums::InWorld => {
                let arena = &mut system.arena;
                let total = torque.map(arena, |arena, part| part.total(arena, &kinematics.frames)).total(arena);
                LinearForm::term(arena, Expr::ONE, &Scalar::plain(total))
            }
        }
    }
}

impl Dynamics {
    /// Evaluates both cotrees, then both trees, then the rows.
    pub(super) fn new(
        system: &mut System,
        kinematics: &Kinematics,
        trees: Rooted,
        constraints: &[Constraint],
        laws: &Laws,
    ) -> Self {
        let ((t_tree, _), (r_tree, _)) = trees;
        let (mut dynamics, moments) = Dynamics::through(system, kinematics, trees, constraints, laws, Sums::ByKey);
        for &branch in &t_tree.branches {
            dynamics.translational_rows(system, kinematics, laws, branch);
        }
        for &branch in &r_tree.branches {
            dynamics.rotational_row(system, kinematics, laws, &moments, branch);
        }
        dynamics.add_bearings(system, kinematics, constraints);
        dynamics
    }

    /// What contacts make the joints carry beside what the couplings in their place do. All of it together does no work and is in
    /// balance, so the equations are the same.
    pub(super) fn add_bearings(&mut self, system: &mut System, kinematics: &Kinematics, constraints: &[Constraint]) {
        for (index, constraint) in constraints.iter().enumerate().filter(|(_, constraint)| !constraint.is_trivial()) {
            let Some((ends, curve)) = system.curve(constraint.element).filter(|_| !constraint.coupled.is_empty())
            else {
                continue;
            };
            let angle = kinematics.angle_across(&mut system.arena, ends).position.total(&mut system.arena);
            // The first term of a relation has the factor one, and the sign of its side where it holds on one side only.
            let coupling = system.element(constraint.element).coupling.as_ref();
            let side = coupling.and_then(|coupling| coupling.terms.first()).map_or(Expr::ONE, |term| term.factor);
            let reaction = system.arena.symbol(Symbol::Reaction(index));
            let reaction = system.arena.multiply(side, reaction);
            for bearing in curve.bearings {
                let Some(id) = system.find(Origin::Joint(bearing.joint)) else { continue };
                let force = bearing.force.map(|load| Curve::at(&mut system.arena, load, angle));
                let torque = Curve::at(&mut system.arena, bearing.torque, angle);
                let (_, force) = kinematics.direction(system, Direction::Fixed(curve.carrier, force));
                self.forces.entry(id).or_default().add_term(&mut system.arena, reaction, &force);
                self.torques.entry(id).or_default().add_term(&mut system.arena, reaction, &Scalar::plain(torque));
            }
        }
    }

    /// The forces and torques alone, and sum r x F of each body.
    pub(super) fn through(
        system: &mut System,
        kinematics: &Kinematics,
        ((t_tree, t_topology), (r_tree, r_topology)): Rooted,
        constraints: &[Constraint],
        laws: &Laws,
        sums: Sums,
    ) -> (Self, HashMap<BodyId, LinearForm<Scalar>>) {
        let mut dynamics = Dynamics::default();
        let held = by_chord(constraints);
        let of = |chord: ElementId| held.get(&chord).into_iter().flatten().map(|&index| (index, &constraints[index]));
        let couplings = Couplings::new(&mut system.arena, constraints);
        for &chord in &t_tree.chords {
            let mut force = match sums {
                Sums::ByKey => constitutive_force(system, kinematics, laws, chord),
                Sums::InWorld => shared_force(system, kinematics, laws, chord),
            };
            for (index, constraint) in of(chord) {
                add_reaction(system, kinematics, (index, constraint), &mut force);
            }
            dynamics.forces.insert(chord, sums.of_force(system, kinematics, force));
        }
        chord_transformation(&mut system.arena, t_tree, t_topology, &couplings.forces, &mut dynamics.forces);
        let mut moments = dynamics.moments(system, kinematics);
        couplings.add_moments(system, kinematics, &mut moments);
        for &chord in &r_tree.chords {
            let mut torque = constitutive_torque(system, kinematics, laws, &moments, chord);
            for (index, _) in of(chord).filter(|(_, constraint)| constraint.constrained == Constrained::Angle) {
                let reaction = system.arena.symbol(Symbol::Reaction(index));
                torque.add_term(&mut system.arena, reaction, &Scalar::plain(Expr::ONE));
            }
            dynamics.torques.insert(chord, sums.of_torque(system, kinematics, torque));
        }
        chord_transformation(&mut system.arena, r_tree, r_topology, &couplings.torques, &mut dynamics.torques);
        (dynamics, moments)
    }

    /// Force that an element exerts on its second node: for a branch from its cutset.
    pub fn force(&self, element: ElementId) -> Option<&LinearForm<Vector>> {
        self.forces.get(&element)
    }

    /// Torque that an element exerts on its second body: for a branch from its cutset.
    pub fn torque(&self, element: ElementId) -> Option<&LinearForm<Scalar>> {
        self.torques.get(&element)
    }

    /// sum r x F over the arms of each body and the slides whose axis is fixed in it (Eq. 6).
    fn moments(&self, system: &mut System, kinematics: &Kinematics) -> HashMap<BodyId, LinearForm<Scalar>> {
        let mut moments: HashMap<BodyId, LinearForm<Scalar>> = HashMap::new();
        for index in 0..system.elements.len() {
            let Some(row) = &system.elements[index].translation else { continue };
            let (Some(body), Some(force)) = (row.carrier(), self.forces.get(&ElementId(index))) else {
                continue;
            };
            let arm = kinematics.across(&mut system.arena, row.ends).position;
            let moment = force.map(&mut system.arena, |arena, f| arm.cross(arena, f));
            moments.entry(body).or_default().accumulate(&mut system.arena, Expr::ONE, &moment);
        }
        moments
    }

    fn translational_rows(&mut self, system: &mut System, kinematics: &Kinematics, laws: &Laws, branch: ElementId) {
        let Some(row) = system.elements[branch.0].translation.clone() else { return };
        if row.motion.is_empty() {
            return;
        }
        let mut balance = constitutive_force(system, kinematics, laws, branch);
        let minus = system.arena.constant(-1.0);
        balance.accumulate(&mut system.arena, minus, &self.forces[&branch]);
        for (direction, _) in row.motion {
            let (_, along) = kinematics.direction(system, direction);
            let projected = balance.map(&mut system.arena, |arena, f| f.dot(arena, &along));
            self.push_row(&mut system.arena, kinematics, &projected);
        }
    }

    fn rotational_row(
        &mut self,
        system: &mut System,
        kinematics: &Kinematics,
        laws: &Laws,
        moments: &HashMap<BodyId, LinearForm<Scalar>>,
        branch: ElementId,
    ) {
        let free = system.elements[branch.0].rotation.as_ref().is_some_and(|row| matches!(row.angle, Angle::Free(_)));
        if free {
            let mut balance = constitutive_torque(system, kinematics, laws, moments, branch);
            let minus = system.arena.constant(-1.0);
            balance.accumulate(&mut system.arena, minus, &self.torques[&branch]);
            self.push_row(&mut system.arena, kinematics, &balance);
        }
    }

    /// Splits 0 = -M a - Phi_q^T lambda + Q.
    fn push_row(&mut self, arena: &mut Arena, kinematics: &Kinematics, balance: &LinearForm<Scalar>) {
        let (accelerations, rest) = split(arena, kinematics, balance, Order::Acceleration);
        let mut reactions = Vec::new();
        for (key, coefficient) in balance.terms() {
            if let ExprNode::Symbol(Symbol::Reaction(index)) = arena.node(key) {
                let total = coefficient.total(arena, &kinematics.frames);
                reactions.push((index, arena.negate(total)));
            }
        }
        reactions.retain(|(_, entry)| !entry.is_zero());
        self.mass.push(accelerations.into_iter().map(|(column, entry)| (column, arena.negate(entry))).collect());
        self.load.push(without_reactions(arena, kinematics, balance, rest));
        self.reactions.push(reactions);
    }
}

/// {F}_b = -\[A\]{F}_c (Eq. 9), and the same of torques, from the leaves inwards: what acts on the subtree behind a node passes through its branch.
pub(super) fn chord_transformation<D, C: Coefficient>(
    arena: &mut Arena,
    tree: &Tree<D>,
    topology: &Topology<D>,
    coupled: &HashMap<usize, LinearForm<C>>,
    through: &mut HashMap<ElementId, LinearForm<C>>,
) {
    let mut sums = coupled.clone();
    for &chord in &tree.chords {
        couplings::add(arena, &mut sums, topology.ends(chord).map(|node| node.index()), &through[&chord]);
    }
    for OutwardNode { node, parent, branch, sign } in topology.outward().rev() {
        let sum = sums.remove(&node.index()).unwrap_or_default();
        let opposite = arena.constant(-f64::from(sign));
        through.insert(branch, sum.scaled(arena, opposite));
        sums.entry(parent.index()).or_default().accumulate(arena, Expr::ONE, &sum);
    }
}

/// The loads: the balance without accelerations and reactions.
fn without_reactions(arena: &mut Arena, kinematics: &Kinematics, balance: &LinearForm<Scalar>, rest: Expr) -> Expr {
    if !balance.terms().any(|(key, _)| matches!(arena.node(key), ExprNode::Symbol(Symbol::Reaction(_)))) {
        return rest;
    }
    let mut load: LinearForm<Expr> = LinearForm::default();
    for (key, coefficient) in balance.terms() {
        let solved = matches!(arena.node(key), ExprNode::Symbol(symbol) if symbol.is_solved());
        if !solved {
            let total = coefficient.total(arena, &kinematics.frames);
            load.add_term(arena, key, &total);
        }
    }
    load.total(arena)
}

/// The nontrivial circuit equations, and trivial ones that are to share a load, by their chord; couplings act through other elements' chords.
fn by_chord(constraints: &[Constraint]) -> HashMap<ElementId, Vec<usize>> {
    let mut held: HashMap<ElementId, Vec<usize>> = HashMap::new();
    let counts = |constraint: &Constraint| constraint.is_loop() && constraint.standing() != Some(Standing::Trivial);
    let is_plain = |constraint: &Constraint| counts(constraint) && constraint.coupled.is_empty();
    for (index, constraint) in constraints.iter().enumerate().filter(|(_, constraint)| is_plain(constraint)) {
        held.entry(constraint.element).or_default().push(index);
    }
    held
}

/// lambda x direction, if the loop equation is one of the translational graph.
fn add_reaction(
    system: &mut System,
    kinematics: &Kinematics,
    (index, constraint): (usize, &Constraint),
    force: &mut LinearForm<Vector>,
) {
    if let Constrained::Along(direction) = constraint.constrained {
        let (_, along) = kinematics.direction(system, direction);
        let reaction = system.arena.symbol(Symbol::Reaction(index));
        force.add_term(&mut system.arena, reaction, &along);
    }
}

/// The constitutive part of a force, with that of an armature.
fn constitutive_force(system: &mut System, kinematics: &Kinematics, laws: &Laws, id: ElementId) -> LinearForm<Vector> {
    let Some(row) = system.elements[id.0].translation.clone() else { return LinearForm::default() };
    let mut force = force_of_law(system, kinematics, laws, (id, &row));
    if row.armature != Expr::ZERO && laws.counts(id, Share::Velocity) {
        let armature = armature_force(system, kinematics, &row);
        force.accumulate(&mut system.arena, Expr::ONE, &armature);
    }
    force
}

/// F = -armature s'' u, where s = r . u and r has no part across u: s'' = r'' . u + omega^2 s.
fn armature_force(system: &mut System, kinematics: &Kinematics, row: &TranslationalRow) -> LinearForm<Vector> {
    let direction = row.motion.first().map_or(Direction::X, |(direction, _)| *direction);
    let (frame, along) = kinematics.direction(system, direction);
    let across = kinematics.across(&mut system.arena, row.ends);
    let (arena, frames) = (&mut system.arena, &kinematics.frames);
    let mut acceleration = across.acceleration.map(arena, |arena, part| part.dot(arena, &along));
    let square = arena.square(frames.get(frame).omega);
    let displacement = across.position.dot(arena, &along);
    acceleration.add_term(arena, square, &displacement);
    let minus = arena.negate(row.armature);
    acceleration.map(arena, |arena, part| {
        let part = part.total(arena, frames);
        let force = arena.multiply(minus, part);
        along.scaled(arena, force)
    })
}

/// The part of a force that its law gives.
fn force_of_law(
    system: &mut System,
    kinematics: &Kinematics,
    laws: &Laws,
    (id, row): (ElementId, &TranslationalRow),
) -> LinearForm<Vector> {
    match &row.through {
        Force::None => LinearForm::default(),
        Force::Inertia(body) => {
            let counts = [Share::Velocity, Share::Gravity].map(|share| laws.counts(id, share));
            let node = kinematics.node(&mut system.arena, row.ends[1]);
            inertia_force(system, &if counts[0] { node.acceleration } else { LinearForm::default() }, *body, counts[1])
        }
        Force::Resistance(_) if !laws.counts(id, Share::Resistance) => LinearForm::default(),
        Force::Resistance(law) => resisting_force(system, kinematics, row, *law),
        Force::World(_) | Force::InBody(..) | Force::Line(_) | Force::Tangent(..) => {
            laws.forces.get(&id).cloned().unwrap_or_default()
        }
    }
}

/// The same, with the acceleration of a body's centre in the axes of the world.
fn shared_force(system: &mut System, kinematics: &Kinematics, laws: &Laws, id: ElementId) -> LinearForm<Vector> {
    let row = system.elements[id.0].translation.clone();
    match row.as_ref().map(|row| (row, &row.through)) {
        Some((row, &Force::Inertia(body))) => match kinematics.known_total(row.ends[1], Order::Acceleration) {
            Some(acceleration) => {
                let acceleration = Vector::fixed(FrameId::WORLD, acceleration);
                let acceleration = LinearForm::term(&mut system.arena, Expr::ONE, &acceleration);
                inertia_force(system, &acceleration, body, true)
            }
            None => constitutive_force(system, kinematics, laws, id),
        },
        Some((
            _,
            Force::None
            | Force::Resistance(_)
            | Force::World(_)
            | Force::InBody(..)
            | Force::Line(_)
            | Force::Tangent(..),
        ))
        | None => constitutive_force(system, kinematics, laws, id),
    }
}

/// F = -m (a - g) (Eq. 5; gravity is a force actuator beside the body).
fn inertia_force(
    system: &mut System,
    acceleration: &LinearForm<Vector>,
    body: BodyId,
    falls: bool,
) -> LinearForm<Vector> {
    let mass = mass(system, body);
    let weightless = system.mechanism.bodies[body.0].weightless;
    let gravity = system.mechanism.clone().gravity.each_ref().map(|component| system.value(component));
    let arena = &mut system.arena;
    let minus_mass = arena.negate(mass);
    let mut force = acceleration.scaled(arena, minus_mass);
    if weightless || !falls {
        return force;
    }
    for (component, axis) in gravity.into_iter().zip([Vector::x(), Vector::y()]) {
        let weight = arena.multiply(mass, component);
        let along = axis.scaled(arena, weight);
        force.add_term(arena, Expr::ONE, &along);
    }
    force
}

/// F = f(v . u) u
pub fn resisting_force(
    system: &mut System,
    kinematics: &Kinematics,
    row: &TranslationalRow,
    law: Resistance,
) -> LinearForm<Vector> {
    let direction = row.motion.first().map_or(Direction::X, |(direction, _)| *direction);
    let speed = kinematics.speed_along(system, row.ends, direction);
    let (_, along) = kinematics.direction(system, direction);
    let resisting = law.at(&mut system.arena, speed);
    LinearForm::term(&mut system.arena, resisting, &along)
}

/// The constitutive part of a torque, with that of an armature: -armature alpha.
fn constitutive_torque(
    system: &mut System,
    kinematics: &Kinematics,
    laws: &Laws,
    moments: &HashMap<BodyId, LinearForm<Scalar>>,
    id: ElementId,
) -> LinearForm<Scalar> {
    let Some(row) = system.elements[id.0].rotation.clone() else { return LinearForm::default() };
    let mut torque = torque_of_law(system, kinematics, laws, moments, (id, &row));
    if row.armature != Expr::ZERO && laws.counts(id, Share::Velocity) {
        let arena = &mut system.arena;
        let minus = arena.negate(row.armature);
        let across = kinematics.angle_across(arena, row.ends).acceleration;
        let across = across.map(arena, |arena, &part| Scalar::plain(arena.multiply(minus, part)));
        torque.accumulate(arena, Expr::ONE, &across);
    }
    torque
}

/// The part of a torque that its law gives.
fn torque_of_law(
    system: &mut System,
    kinematics: &Kinematics,
    laws: &Laws,
    moments: &HashMap<BodyId, LinearForm<Scalar>>,
    (id, row): (ElementId, &RotationalRow),
) -> LinearForm<Scalar> {
    let plain = |arena: &mut Arena, value: Expr| LinearForm::term(arena, value, &Scalar::plain(Expr::ONE));
    match row.through {
        Torque::None => LinearForm::default(),
        Torque::Inertia(body) => {
            let turns = laws.counts(id, Share::Velocity);
            inertia_torque(system, kinematics, (row.ends[1], turns), body, moments)
        }
        Torque::Resistance(_) if !laws.counts(id, Share::Resistance) => LinearForm::default(),
        Torque::Resistance(law) => {
            let arena = &mut system.arena;
            let omega = kinematics.angle_across(arena, row.ends).velocity.total(arena);
            let resisting = law.at(arena, omega);
            plain(arena, resisting)
        }
        Torque::Law(_) => {
            let torque = laws.torques.get(&id).copied().unwrap_or(Expr::ZERO);
            plain(&mut system.arena, torque)
        }
    }
}

/// T = -I alpha - sum r x F (Eq. 6).
fn inertia_torque(
    system: &mut System,
    kinematics: &Kinematics,
    (node, turns): (crate::network::RNode, bool),
    body: BodyId,
    moments: &HashMap<BodyId, LinearForm<Scalar>>,
) -> LinearForm<Scalar> {
    let inertia = if turns { inertia(system, body) } else { Expr::ZERO };
    let arena = &mut system.arena;
    let minus_inertia = arena.negate(inertia);
    let mut torque =
        kinematics.angle(node).acceleration.map(arena, |arena, &c| Scalar::plain(arena.multiply(minus_inertia, c)));
    if let Some(moment) = moments.get(&body) {
        let minus = arena.constant(-1.0);
        torque.accumulate(arena, minus, moment);
    }
    torque
}
