//! The same mechanism once more, as arms: what its Taylor series are found from.
//!
//! Every position is a constant combination of products sigma e: a scalar (1, a displacement, a signal of time) times the unit vector
//! of a frame. Virtual work then needs masses between arms, loads along arms and nothing else; see `cotree_fmu::series`.

use std::collections::BTreeMap;

use super::Equations;
use super::dynamics::{inertia, mass, resisting_force};
use super::form::Coefficient;
use super::kinematics::{ScalarMotion, is_constant, known_angle};
use super::vector::{FrameId, Vector};
use crate::element::{Angle, Coupling, Direction, Force, Held, Origin, Port, Torque, TranslationalRow};
use crate::expr::{Arena, Binary, Expr, Node, Order, Symbol, Unary};
use crate::graph::{ElementId, RNode, TNode};
use crate::mechanism::{BodyId, Owner, Quantity, Variable};

/// Why there is no arm form: a clause about the mechanism.
pub type Reason = String;

/// The scalar of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Factor {
    /// 1
    One,
    /// A displacement: that coordinate, or beyond their number an auxiliary one.
    Displacement(usize),
    /// A function of time.
    Signal(Expr),
}

/// sigma e
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arm {
    /// e
    pub frame: FrameId,
    /// sigma
    pub factor: Factor,
}

/// A vector: constant complex numbers by arms.
pub type Arms = BTreeMap<Arm, [Expr; 2]>;

/// A turning frame.
#[derive(Clone, Debug)]
pub struct Turning {
    /// Which.
    pub frame: FrameId,
    /// Coordinates that its angle is made of, with their signs.
    pub coordinates: BTreeMap<usize, f64>,
    /// The part of its angle that is a function of time.
    pub signal: Expr,
    /// Inertia of what turns with it.
    pub inertia: Expr,
    /// cos and sin.
    pub unit: [Expr; 2],
}

/// A loop equation.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Which.
    pub constraint: usize,
    /// p . b
    pub arms: Arms,
    /// Displacements with their factors.
    pub displacements: Vec<(usize, Expr)>,
    /// Angles of frames, without their signals.
    pub angles: Vec<(FrameId, Expr)>,
    /// Signals with their factors.
    pub signals: Vec<(Expr, Expr)>,
    /// Constant term.
    pub constant: Vec<Expr>,
}

/// value x along, acting along a displacement.
#[derive(Clone, Debug)]
pub struct Load {
    /// The displacement that the force works along.
    pub across: Arms,
    /// A scalar of the motion.
    pub value: Expr,
    /// A vector.
    pub along: Arms,
}

/// A scalar load on what it works along.
#[derive(Clone, Debug)]
pub struct Push {
    /// Works on the angle of a frame, or on a displacement.
    pub on: Result<FrameId, usize>,
    /// The load.
    pub value: Expr,
    /// Its factor.
    pub factor: Expr,
}

/// A gap that a direction fixed in a turning frame holds: the displacement across is free.
#[derive(Clone, Debug)]
pub struct Auxiliary {
    /// Number of the displacement.
    pub displacement: usize,
    /// Frame of the direction.
    pub frame: FrameId,
    /// Direction in which the gap is free.
    pub free: [Expr; 2],
    /// First of its two rows.
    pub row: usize,
}

/// A massless rod between two points: its angle follows from theirs.
#[derive(Clone, Debug)]
pub struct Rod {
    /// The frame that turns with it.
    pub frame: FrameId,
    /// First of its two rows.
    pub row: usize,
    /// Its length.
    pub length: Expr,
}

/// A mechanism as arms.
#[derive(Clone, Debug, Default)]
pub struct ArmEquations {
    /// Frames but the world.
    pub frames: Vec<Turning>,
    /// A_kl
    pub coupling: BTreeMap<(Arm, Arm), [Expr; 2]>,
    /// Loop equations.
    pub rows: Vec<Row>,
    /// Displacements that are no coordinates.
    pub auxiliary: Vec<Auxiliary>,
    /// Frames whose angles are no coordinates.
    pub rods: Vec<Rod>,
    /// Forces.
    pub loads: Vec<Load>,
    /// Torques, and forces along a displacement.
    pub pushes: Vec<Push>,
    /// Lengths of lines with their rates.
    pub lines: Vec<(Expr, Expr, Arms)>,
}

impl Equations<'_> {
    /// The arm form; only the `active` loop equations enter.
    ///
    /// # Errors
    /// A displacement that is no constant combination of arms.
    pub fn arms(&mut self, active: &[bool]) -> Result<ArmEquations, Reason> {
        let mut arms = ArmEquations { frames: self.turning()?, ..ArmEquations::default() };
        self.masses(&mut arms)?;
        for (index, _) in active.iter().enumerate().filter(|(_, active)| **active) {
            self.row(index, &mut arms)?;
        }
        for index in 0..self.system.elements.len() {
            self.force(ElementId(index), &mut arms)?;
            self.torque(ElementId(index), &mut arms);
        }
        Ok(arms)
    }

    fn turning(&mut self) -> Result<Vec<Turning>, Reason> {
        let frames: Vec<_> = self.kinematics.frames.iter().skip(1).map(|(id, f)| (id, f.angle, f.unit)).collect();
        let mut turning = Vec::new();
        for (frame, angle, unit) in frames {
            let mut terms = Vec::new();
            linear(&mut self.system.arena, angle, Expr::ONE, &mut terms)?;
            let mut part =
                Turning { frame, coordinates: BTreeMap::new(), signal: Expr::ZERO, inertia: Expr::ZERO, unit };
            for (factor, coefficient) in terms {
                match (factor, self.system.arena.as_constant(coefficient)) {
                    (Factor::Displacement(index), Some(sign)) => {
                        part.coordinates.insert(index, sign);
                    }
                    (Factor::Signal(signal), _) => {
                        let arena = &mut self.system.arena;
                        let term = arena.multiply(coefficient, signal);
                        part.signal = arena.add(part.signal, term);
                    }
                    // The constant part of a function of time.
                    (Factor::One, _) => part.signal = self.system.arena.add(part.signal, coefficient),
                    (Factor::Displacement(_), None) => return Err("an angle is scaled by a parameter".into()),
                }
            }
            turning.push(part);
        }
        Ok(turning)
    }

    /// Inertia of frames, and masses between arms.
    fn masses(&mut self, arms: &mut ArmEquations) -> Result<(), Reason> {
        for index in 0..self.system.mechanism.bodies.len() {
            let body = BodyId(index);
            let element = self.system.elements.iter().find(|element| element.origin == Origin::Body(body));
            let Some((translation, rotation)) =
                element.map(|e| (e.translation.as_ref().map(|t| t.ends), e.rotation.as_ref().map(|r| r.ends)))
            else {
                continue;
            };
            if let Some(ends) = rotation {
                let (frame, _) = self.kinematics.placement(ends[1]);
                if let Some(turning) = arms.frames.iter_mut().find(|turning| turning.frame == frame) {
                    let inertia = inertia(&mut self.system, body);
                    turning.inertia = self.system.arena.add(turning.inertia, inertia);
                }
            }
            if let Some(ends) = translation {
                let centre = self.kinematics.node(&mut self.system.arena, ends[1]).position.clone();
                let centre = self.decompose(&centre)?;
                self.mass(body, &centre, arms);
            }
        }
        Ok(())
    }

    fn mass(&mut self, body: BodyId, centre: &Arms, arms: &mut ArmEquations) {
        let moving: Vec<(Arm, [Expr; 2])> =
            centre.iter().filter(|(arm, _)| !arm.is_constant()).map(|(a, z)| (*a, *z)).collect();
        if moving.is_empty() {
            return;
        }
        let mass = mass(&mut self.system, body);
        let arena = &mut self.system.arena;
        for &(k, z) in &moving {
            for &(l, y) in &moving {
                let product = conjugate_product(arena, z, y).map(|part| arena.multiply(mass, part));
                match arms.frames.iter_mut().find(|turning| k == l && k == Arm::of(turning.frame)) {
                    Some(turning) => turning.inertia = arena.add(turning.inertia, product[0]),
                    None => {
                        let entry = arms.coupling.entry((k, l)).or_insert([Expr::ZERO; 2]);
                        *entry = [arena.add(entry[0], product[0]), arena.add(entry[1], product[1])];
                    }
                }
            }
        }
    }

    fn row(&mut self, index: usize, arms: &mut ArmEquations) -> Result<(), Reason> {
        let (element, held) = (self.constraints[index].element, self.constraints[index].held);
        let element = self.system.element(element).clone();
        if let (Some(coupling), false) = (element.coupling, self.constraints[index].coupled.is_empty()) {
            return self.coupled_row(index, &coupling, arms);
        }
        match (held, element.translation, element.rotation) {
            (Held::Along(direction), Some(row), _) => {
                let mut gap = self.kinematics.known(&mut self.system, &row.known).position;
                let across = self.kinematics.across(&mut self.system.arena, row.ends).position;
                let minus = self.system.arena.constant(-1.0);
                let across = across.scaled(&mut self.system.arena, minus);
                gap.accumulate(&mut self.system.arena, &across);
                let gap = self.decompose(&gap)?;
                let (frame, along) = self.along(direction);
                self.translational_row(index, gap, (frame, along), arms);
            }
            (Held::Angle, _, Some(row)) => {
                let ends = row.ends.map(|node| self.kinematics.placement(node));
                self.rotational_row(index, &row.angle, ends, arms)?;
            }
            _ => {}
        }
        Ok(())
    }

    fn along(&mut self, direction: Direction) -> (FrameId, [Expr; 2]) {
        let (frame, along) = self.kinematics.direction(&mut self.system, direction);
        (frame, along.parts().next().map_or([Expr::ZERO; 2], |(_, components)| components))
    }

    /// offset - sum of factor x across.
    fn coupled_row(&mut self, constraint: usize, coupling: &Coupling, arms: &mut ArmEquations) -> Result<(), Reason> {
        let mut row = Row { constraint, constant: vec![coupling.offset], ..Row::default() };
        for term in &coupling.terms {
            let factor = self.system.arena.negate(term.factor);
            match term.port {
                Port::Angle(ends) => self.angle_between(ends, factor, arms, &mut row),
                Port::Along(ends, direction) => self.displacement_between(ends, direction, factor, arms, &mut row)?,
                Port::Length(ends) => return self.rod(constraint, ends, coupling, arms),
            }
        }
        arms.rows.push(row);
        Ok(())
    }

    /// factor x the angle of the second node seen from the first.
    fn angle_between(&mut self, ends: [RNode; 2], factor: Expr, arms: &ArmEquations, row: &mut Row) {
        let arena = &mut self.system.arena;
        let minus = arena.negate(factor);
        for (node, factor) in ends.into_iter().zip([minus, factor]) {
            let (frame, offset) = self.kinematics.placement(node);
            row.constant.push(arena.multiply(factor, offset));
            if let Some(turning) = arms.frames.iter().find(|turning| turning.frame == frame) {
                row.angles.push((frame, factor));
                row.signals.push((turning.signal, factor));
            }
        }
    }

    /// factor x the part along a direction of the way from the first node to the second.
    fn displacement_between(
        &mut self,
        ends: [TNode; 2],
        direction: Direction,
        factor: Expr,
        arms: &mut ArmEquations,
        row: &mut Row,
    ) -> Result<(), Reason> {
        let gap = self.kinematics.across(&mut self.system.arena, ends).position;
        let gap = self.decompose(&gap)?;
        let (frame, line) = self.along(direction);
        let arena = &mut self.system.arena;
        let along = line.map(|component| arena.multiply(factor, component));
        let part = match frame == FrameId::WORLD {
            true => Some(projected_row(arena, row.constraint, gap.clone(), along)),
            false => row_in_frame(arena, row.constraint, gap.clone(), (frame, along)),
        };
        let Some(part) = part else {
            // Displacements along the line and across it close the gap, and both components hold.
            let across = [arena.negate(line[1]), line[0]];
            let first = self.close(row.constraint, gap, frame, &[line, across], arms);
            let [square, _] = conjugate_product(&mut self.system.arena, line, along);
            row.displacements.push((first, self.system.arena.negate(square)));
            return Ok(());
        };
        row.arms.extend(part.arms);
        row.displacements.extend(part.displacements);
        row.signals.extend(part.signals);
        row.constant.extend(part.constant);
        Ok(())
    }

    /// Closes a gap by displacements in directions fixed in a frame: both of its components hold. Returns the number of
    /// the first displacement.
    fn close(
        &mut self,
        constraint: usize,
        mut gap: Arms,
        frame: FrameId,
        directions: &[[Expr; 2]],
        arms: &mut ArmEquations,
    ) -> usize {
        let first = self.coordinates.len() + arms.auxiliary.len();
        for (displacement, &free) in (first..).zip(directions) {
            arms.auxiliary.push(Auxiliary { displacement, frame, free, row: arms.rows.len() });
            gap.insert(Arm { frame, factor: Factor::Displacement(displacement) }, free);
        }
        self.vanishes(constraint, gap, arms);
        first
    }

    /// Both components of a gap are zero.
    fn vanishes(&mut self, constraint: usize, gap: Arms, arms: &mut ArmEquations) {
        for axis in [[Expr::ONE, Expr::ZERO], [Expr::ZERO, Expr::ONE]] {
            arms.rows.push(projected_row(&mut self.system.arena, constraint, gap.clone(), axis));
        }
    }

    /// offset - factor x the distance of two points: a massless rod lies between them.
    fn rod(
        &mut self,
        constraint: usize,
        ends: [TNode; 2],
        coupling: &Coupling,
        arms: &mut ArmEquations,
    ) -> Result<(), Reason> {
        let [term] = &coupling.terms[..] else { return Err("a distance is coupled with something else".into()) };
        let gap = self.kinematics.across(&mut self.system.arena, ends).position;
        let mut gap = self.decompose(&gap)?;
        let length = self.system.arena.divide(coupling.offset, term.factor);
        let frame = self.kinematics.frames.other(arms.rods.len());
        arms.rods.push(Rod { frame, row: arms.rows.len(), length });
        gap.insert(Arm::of(frame), [self.system.arena.negate(length), Expr::ZERO]);
        self.vanishes(constraint, gap, arms);
        Ok(())
    }

    fn translational_row(
        &mut self,
        constraint: usize,
        gap: Arms,
        (frame, along): (FrameId, [Expr; 2]),
        arms: &mut ArmEquations,
    ) {
        let arena = &mut self.system.arena;
        if frame == FrameId::WORLD {
            arms.rows.push(projected_row(arena, constraint, gap, along));
        } else if let Some(row) = row_in_frame(arena, constraint, gap.clone(), (frame, along)) {
            arms.rows.push(row);
        } else {
            // Across the direction the gap is free: a displacement closes it, and both components hold.
            let free = [arena.negate(along[1]), along[0]];
            self.close(constraint, gap, frame, &[free], arms);
        }
    }

    fn rotational_row(
        &mut self,
        constraint: usize,
        angle: &Angle,
        ends: [(FrameId, Expr); 2],
        arms: &mut ArmEquations,
    ) -> Result<(), Reason> {
        let arena = &mut self.system.arena;
        let mut row = Row { constraint, ..Row::default() };
        let known: ScalarMotion = known_angle(arena, angle);
        let known = known.position.total(arena);
        let mut terms = Vec::new();
        linear(arena, known, Expr::ONE, &mut terms)?;
        for ((frame, offset), sign) in ends.into_iter().zip([1.0, -1.0]) {
            let sign = arena.constant(sign);
            terms.push((Factor::One, arena.multiply(sign, offset)));
            if let Some(turning) = arms.frames.iter().find(|turning| turning.frame == frame) {
                row.angles.push((frame, sign));
                terms.push((Factor::Signal(turning.signal), sign));
            }
        }
        for (factor, coefficient) in terms {
            match factor {
                Factor::One => row.constant.push(coefficient),
                Factor::Signal(signal) => row.signals.push((signal, coefficient)),
                Factor::Displacement(_) => return Err("a prescribed angle depends on a coordinate".into()),
            }
        }
        arms.rows.push(row);
        Ok(())
    }

    fn force(&mut self, id: ElementId, arms: &mut ArmEquations) -> Result<(), Reason> {
        let Some(row) = self.system.element(id).translation.clone() else { return Ok(()) };
        let across = self.kinematics.across(&mut self.system.arena, row.ends).position;
        let across = self.decompose(&across)?;
        for (value, vector) in self.applied(id, &row) {
            let along = self.decompose(&vector)?;
            match self.slides(&across, &along) {
                Some(slides) => {
                    arms.pushes.extend(slides.into_iter().map(|(index, factor)| Push { on: Err(index), value, factor }))
                }
                None => arms.loads.push(Load { across: across.clone(), value, along }),
            }
        }
        if let (Force::Line(_), Origin::Load(load)) = (&row.through, self.system.element(id).origin) {
            let [length, rate] = [Quantity::Length, Quantity::Rate]
                .map(|quantity| self.variable(Variable { owner: Owner::Load(load), quantity }));
            arms.lines.push((length, rate, across));
        }
        Ok(())
    }

    /// Forces on the second node that are no reactions, by the scalars that they are made of; weight among them.
    fn applied(&mut self, id: ElementId, row: &TranslationalRow) -> Vec<(Expr, Vector)> {
        let force = match &row.through {
            Force::None => return Vec::new(),
            Force::Inertia(body) => return self.weight(*body, row),
            Force::Resistance(law) => resisting_force(&mut self.system, &self.kinematics, row, *law),
            Force::World(_) | Force::InBody(..) | Force::Line(_) => {
                self.laws.forces.get(&id).cloned().unwrap_or_default()
            }
        };
        force.terms().map(|(value, vector)| (value, vector.clone())).collect()
    }

    fn weight(&mut self, body: BodyId, row: &TranslationalRow) -> Vec<(Expr, Vector)> {
        let gravity = self.system.mechanism.gravity.each_ref().map(|component| self.system.value(component));
        let moves = self.kinematics.node(&mut self.system.arena, row.ends[1]).position != Vector::default();
        if gravity == [Expr::ZERO; 2] || !moves || self.system.mechanism.bodies[body.0].weightless {
            return Vec::new();
        }
        let mass = mass(&mut self.system, body);
        let arena = &mut self.system.arena;
        let vector = Vector::fixed(FrameId::WORLD, gravity.map(|component| arena.multiply(mass, component)));
        vec![(Expr::ONE, vector)]
    }

    /// A force parallel to a slide works along its displacement only: displacements with the factors of the force. None if it is
    /// any other force.
    fn slides(&mut self, across: &Arms, along: &Arms) -> Option<Vec<(usize, Expr)>> {
        let (force, direction) = along.iter().next().filter(|_| along.len() == 1)?;
        let arena = &mut self.system.arena;
        let mut slides = Vec::new();
        for (arm, &z) in across {
            let [parallel, beside] = conjugate_product(arena, z, *direction);
            let same = *force == Arm::of(arm.frame) && arm.frame != FrameId::WORLD;
            if !same || !beside.is_zero() {
                return None;
            }
            if let Factor::Displacement(index) = arm.factor {
                slides.push((index, parallel));
            }
        }
        Some(slides)
    }

    fn torque(&mut self, id: ElementId, arms: &mut ArmEquations) {
        let Some(row) = self.system.element(id).rotation.clone() else { return };
        let arena = &mut self.system.arena;
        let value = match row.through {
            Torque::None | Torque::Inertia(_) => return,
            Torque::Resistance(law) => {
                let rate = self.kinematics.angle_across(arena, row.ends).velocity.total(arena);
                law.at(arena, rate)
            }
            Torque::Law(_) => self.laws.torques.get(&id).copied().unwrap_or(Expr::ZERO),
        };
        for (node, sign) in row.ends.into_iter().zip([-1.0, 1.0]) {
            let (frame, _) = self.kinematics.placement(node);
            if frame != FrameId::WORLD && !value.is_zero() {
                let factor = self.system.arena.constant(sign);
                arms.pushes.push(Push { on: Ok(frame), value, factor });
            }
        }
    }

    fn decompose(&mut self, vector: &Vector) -> Result<Arms, Reason> {
        let mut arms = Arms::new();
        for (frame, components) in vector.parts() {
            for (axis, component) in components.into_iter().enumerate() {
                let mut terms = Vec::new();
                linear(&mut self.system.arena, component, Expr::ONE, &mut terms)?;
                for (factor, coefficient) in terms {
                    let z = arms.entry(Arm { frame, factor }).or_insert([Expr::ZERO; 2]);
                    z[axis] = self.system.arena.add(z[axis], coefficient);
                }
            }
        }
        arms.retain(|_, z| *z != [Expr::ZERO; 2]);
        Ok(arms)
    }
}

impl Arm {
    /// The unit vector of a frame.
    pub fn of(frame: FrameId) -> Self {
        Arm { frame, factor: Factor::One }
    }

    /// Fixed in the world?
    pub fn is_constant(&self) -> bool {
        *self == Arm::of(FrameId::WORLD)
    }
}

/// direction . gap, with the direction fixed in the world.
fn projected_row(arena: &mut Arena, constraint: usize, gap: Arms, direction: [Expr; 2]) -> Row {
    let mut row = Row { constraint, ..Row::default() };
    for (arm, z) in gap {
        // Re(conj(n) z b) = p . b with p = conj(conj(n) z) = conj(z) n
        let p = conjugate_product(arena, z, direction);
        if arm.is_constant() {
            row.constant.push(p[0]);
        } else {
            row.arms.insert(arm, p);
        }
    }
    row
}

/// direction . gap, if the gap and its direction are fixed in the same turning frame but for displacements.
fn row_in_frame(arena: &mut Arena, constraint: usize, gap: Arms, (frame, along): (FrameId, [Expr; 2])) -> Option<Row> {
    let mut row = Row { constraint, ..Row::default() };
    for (arm, z) in gap {
        if arm.frame != frame {
            return None;
        }
        let [factor, _] = conjugate_product(arena, along, z);
        match arm.factor {
            Factor::One => row.constant.push(factor),
            Factor::Displacement(index) => row.displacements.push((index, factor)),
            Factor::Signal(signal) => row.signals.push((signal, factor)),
        }
    }
    Some(row)
}

/// conj(a) b
pub fn conjugate_product(arena: &mut Arena, a: [Expr; 2], b: [Expr; 2]) -> [Expr; 2] {
    let [rr, ii, ri, ir] = [(a[0], b[0]), (a[1], b[1]), (a[0], b[1]), (a[1], b[0])].map(|(x, y)| arena.multiply(x, y));
    [arena.add(rr, ii), arena.subtract(ri, ir)]
}

/// Splits an expression that is linear in displacements: factors with constant coefficients.
fn linear(arena: &mut Arena, expr: Expr, coefficient: Expr, terms: &mut Vec<(Factor, Expr)>) -> Result<(), Reason> {
    if is_constant(arena, expr) {
        let term = arena.multiply(coefficient, expr);
        if !term.is_zero() {
            terms.push((Factor::One, term));
        }
        return Ok(());
    }
    match arena.node(expr) {
        Node::Symbol(Symbol::Coordinate(index, Order::Position)) => {
            terms.push((Factor::Displacement(index), coefficient));
            Ok(())
        }
        Node::Unary(Unary::Negate, a) => {
            let minus = arena.negate(coefficient);
            linear(arena, a, minus, terms)
        }
        Node::Binary(Binary::Add, a, b) => {
            linear(arena, a, coefficient, terms)?;
            linear(arena, b, coefficient, terms)
        }
        Node::Binary(Binary::Subtract, a, b) => {
            linear(arena, a, coefficient, terms)?;
            let minus = arena.negate(coefficient);
            linear(arena, b, minus, terms)
        }
        Node::Binary(Binary::Multiply, a, b) if is_constant(arena, a) || is_constant(arena, b) => {
            let (constant, moving) = if is_constant(arena, a) { (a, b) } else { (b, a) };
            let product = arena.multiply(coefficient, constant);
            linear(arena, moving, product, terms)
        }
        Node::Binary(Binary::Divide, a, b) if is_constant(arena, b) => {
            let quotient = arena.divide(coefficient, b);
            linear(arena, a, quotient, terms)
        }
        _ if arena.symbols([expr]).iter().all(|symbol| !matches!(symbol, Symbol::Coordinate(..))) => {
            terms.push((Factor::Signal(expr), coefficient));
            Ok(())
        }
        _ => Err("a displacement is no linear function of the coordinates".into()),
    }
}
