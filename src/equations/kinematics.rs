//! Across variables. The branch transformation (Eq. 12) gives every node's motion from those of the branches; since "the
//! derivative of an across variable is another across variable", one walk through each tree serves positions, velocities and
//! accelerations.

use std::collections::BTreeMap;

use super::form::{Coefficient, Form};
use super::vector::{Frame, FrameId, Frames, Scalar, Vector};
use crate::element::{Angle, Direction, Element, Known, Signal, System, TranslationalRow};
use crate::expr::{Arena, Expr, Node, Order, Symbol};
use crate::graph::{ElementId, RNode, Rotation, TNode, Topology, Translation};
use crate::mechanism::{BodyId, Place};

/// Position, velocity and acceleration of a point, or across an element.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// r
    pub position: Vector,
    /// v, linear in the rates.
    pub velocity: Form<Vector>,
    /// a, linear in the accelerations.
    pub acceleration: Form<Vector>,
}

impl Motion {
    /// self += factor x other
    pub fn accumulate(&mut self, arena: &mut Arena, factor: Expr, other: &Motion) {
        let position = other.position.scaled(arena, factor);
        self.position.accumulate(arena, &position);
        self.velocity.accumulate(arena, factor, &other.velocity);
        self.acceleration.accumulate(arena, factor, &other.acceleration);
    }

    /// to - from
    pub fn between(arena: &mut Arena, from: &Motion, to: &Motion) -> Motion {
        let mut motion = to.clone();
        let minus = arena.constant(-1.0);
        motion.accumulate(arena, minus, from);
        motion
    }
}

/// An angle or a displacement along an axis, with its derivatives as linear forms.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScalarMotion {
    /// Value.
    pub position: Form<Expr>,
    /// Linear in the rates.
    pub velocity: Form<Expr>,
    /// Linear in the accelerations.
    pub acceleration: Form<Expr>,
}

impl ScalarMotion {
    fn constant(arena: &mut Arena, value: Expr) -> Self {
        ScalarMotion { position: Form::term(arena, Expr::ONE, &value), ..Default::default() }
    }

    fn coordinate(arena: &mut Arena, index: usize) -> Self {
        let [q, v, a] = [Order::Position, Order::Velocity, Order::Acceleration].map(|order| {
            let symbol = arena.symbol(Symbol::Coordinate(index, order));
            Form::term(arena, symbol, &Expr::ONE)
        });
        ScalarMotion { position: q, velocity: v, acceleration: a }
    }

    fn signal(arena: &mut Arena, signal: Signal) -> Self {
        let [position, velocity, acceleration] =
            [signal.value, signal.rate, signal.acceleration].map(|value| Form::term(arena, value, &Expr::ONE));
        ScalarMotion { position, velocity, acceleration }
    }

    /// self += factor x other
    pub fn accumulate(&mut self, arena: &mut Arena, factor: Expr, other: &ScalarMotion) {
        self.position.accumulate(arena, factor, &other.position);
        self.velocity.accumulate(arena, factor, &other.velocity);
        self.acceleration.accumulate(arena, factor, &other.acceleration);
    }
}

/// The coordinates that each branch brings: index of the first.
pub type FirstCoordinate = BTreeMap<ElementId, usize>;

/// Paths with more turning frames and displacements are not summed by frames anew for each of their nodes.
const DEEP: usize = 30;

/// Position, velocity and acceleration of a node in the axes of the world, as single expressions.
#[derive(Clone, Copy, Debug, Default)]
struct Totals([Option<[Expr; 2]>; 3]);

/// Motion of every node of both graphs, in terms of the branch coordinates.
#[derive(Clone, Debug)]
pub struct Kinematics {
    /// Independent angles.
    pub frames: Frames,
    angles: Vec<ScalarMotion>,
    /// For each rotational node its frame, and the constant angle from the frame to the body.
    placement: Vec<(FrameId, Expr)>,
    /// For each translational node but the datum, the step to it.
    steps: Vec<Option<Step>>,
    /// What has been asked for of nodes at the end of deep paths.
    totals: Vec<Totals>,
}

/// The branch between a node and the one before it. Sums along paths are made where they are needed: of a deep tree only
/// few are.
#[derive(Clone, Debug)]
struct Step {
    parent: TNode,
    /// Branches between the node and the datum.
    depth: usize,
    /// Displacements on the path from the datum.
    slides: usize,
    /// How often the path from the datum changes to another turning frame, and the frame it comes in.
    angles: usize,
    frame: FrameId,
    /// Motion of the node relative to the one before it.
    across: Motion,
}

impl Kinematics {
    /// Walks both trees.
    pub fn new(
        system: &mut System,
        translation: &Topology<Translation>,
        rotation: &Topology<Rotation>,
        t_coordinates: &FirstCoordinate,
        r_coordinates: &FirstCoordinate,
    ) -> Self {
        let angles = angles(system, rotation, r_coordinates);
        let (frames, placement) = frames(&mut system.arena, &angles);
        let steps = vec![None; system.translation.nodes()];
        let totals = vec![Totals::default(); steps.len()];
        let mut kinematics = Kinematics { frames, angles, placement, steps, totals };
        for (node, parent, branch, sign) in translation.outward() {
            let Some(row) = system.elements[branch.0].translation.clone() else { continue };
            let unsigned = kinematics.across_branch(system, &row, t_coordinates.get(&branch).copied());
            let sign = system.arena.constant(f64::from(sign));
            let mut across = Motion::default();
            across.accumulate(&mut system.arena, sign, &unsigned);
            let before = kinematics.steps[parent.index()].as_ref();
            let (depth, angles, frame) = before.map_or((0, 0, FrameId::WORLD), |s| (s.depth, s.angles, s.frame));
            let slides = before.map_or(0, |s| s.slides) + row.motion.len();
            let turned = across.position.frames().find(|&own| own != FrameId::WORLD && own != frame);
            let (angles, frame) = turned.map_or((angles, frame), |own| (angles + 1, own));
            kinematics.steps[node.index()] = Some(Step { parent, depth: depth + 1, slides, angles, frame, across });
        }
        kinematics
    }

    /// Motion of a node of the translational graph.
    pub fn node(&self, arena: &mut Arena, node: TNode) -> Motion {
        self.relative(arena, TNode::DATUM, node)
    }

    /// How many turning frames lie on the path between two nodes.
    pub fn angles_between(&self, ends: [TNode; 2]) -> usize {
        let angles = |node: TNode| self.steps[node.index()].as_ref().map_or(0, |step| step.angles);
        angles(ends[0]) + angles(ends[1]) - 2 * angles(self.meeting(ends))
    }

    fn depth(&self, node: TNode) -> usize {
        self.steps[node.index()].as_ref().map_or(0, |step| step.depth)
    }

    /// Motion of a node relative to one that its path to the datum passes.
    fn relative(&self, arena: &mut Arena, base: TNode, node: TNode) -> Motion {
        let mut motion = Motion::default();
        for across in self.path(base, node) {
            motion.accumulate(arena, Expr::ONE, across);
        }
        motion
    }

    /// Across variables of the branches on the way to a node from one that its path to the datum passes.
    fn path(&self, base: TNode, node: TNode) -> impl Iterator<Item = &Motion> {
        let mut path = Vec::new();
        let mut at = node;
        while let (true, Some(step)) = (at != base, &self.steps[at.index()]) {
            path.push(&step.across);
            at = step.parent;
        }
        path.into_iter().rev()
    }

    /// Does a path lead from the datum to a node through so many frames that sums along it must be shared?
    pub fn is_deep(&self, node: TNode) -> bool {
        self.moving(node) > DEEP
    }

    /// How many turning frames and displacements lie on the path from the datum to a node.
    pub fn moving(&self, node: TNode) -> usize {
        self.steps[node.index()].as_ref().map_or(0, |step| step.angles + step.slides)
    }

    /// Position, velocity or acceleration of a node in the axes of the world, made from that of the node before it: what the nodes of one path
    /// share is the same expression, so that all of them together grow with their number and not with its square.
    pub fn total(&mut self, system: &mut System, node: TNode, order: Order) -> [Expr; 2] {
        let mut pending = Vec::new();
        let mut at = node;
        let mut sum = loop {
            match (self.totals[at.index()].0[order as usize], &self.steps[at.index()]) {
                (Some(known), _) => break known,
                (None, Some(step)) => {
                    pending.push(at);
                    at = step.parent;
                }
                (None, None) => break [Expr::ZERO; 2],
            }
        };
        for node in pending.into_iter().rev() {
            let Some(step) = &self.steps[node.index()] else { continue };
            let part = self.in_world(system, &step.across, order);
            sum = [0, 1].map(|axis| system.arena.add(sum[axis], part[axis]));
            self.totals[node.index()].0[order as usize] = Some(sum);
        }
        sum
    }

    /// A total that has been asked for before.
    pub fn known_total(&self, node: TNode, order: Order) -> Option<[Expr; 2]> {
        self.totals[node.index()].0[order as usize]
    }

    /// Position and velocity across an element that is not part of the equations of motion itself: shared sums if it spans a deep path.
    pub fn spanned(&mut self, system: &mut System, ends: [TNode; 2]) -> Motion {
        let [from, to] = ends.map(|end| self.moving(end));
        if from + to <= DEEP + 2 * self.moving(self.meeting(ends)) {
            return self.across(&mut system.arena, ends);
        }
        let mut between = |system: &mut System, order: Order| {
            let [from, to] = ends.map(|end| self.total(system, end, order));
            Vector::fixed(FrameId::WORLD, [0, 1].map(|axis| system.arena.subtract(to[axis], from[axis])))
        };
        let (position, velocity) = (between(system, Order::Position), between(system, Order::Velocity));
        let velocity = Form::term(&mut system.arena, Expr::ONE, &velocity);
        Motion { position, velocity, acceleration: Form::default() }
    }

    /// Components of a motion in the axes of the world.
    fn in_world(&self, system: &mut System, motion: &Motion, order: Order) -> [Expr; 2] {
        [Vector::x(), Vector::y()].map(|axis| match order {
            Order::Position => motion.position.dot(&mut system.arena, &axis).total(&mut system.arena, &self.frames),
            Order::Velocity => self.component(system, &motion.velocity, &axis),
            Order::Acceleration => self.component(system, &motion.acceleration, &axis),
        })
    }

    /// [`Kinematics::total`] for a point of the scene at the end of a deep path, whether an element uses it or not.
    pub fn total_of_place(&mut self, system: &mut System, place: Place, order: Order) -> Option<[Expr; 2]> {
        if system.has_node(place) {
            let node = system.t_node(place);
            return self.is_deep(node).then(|| self.total(system, node, order));
        }
        let Place::Point(body, point) = place else { return None };
        let centre = system.t_node(Place::Centre(body));
        if !self.is_deep(centre) {
            return None;
        }
        let at = system.mechanism.bodies[body.0].points[point].at.each_ref().map(|formula| system.value(formula));
        let arm = self.fixed(system, Some(body), at);
        let (sum, part) = (self.total(system, centre, order), self.in_world(system, &arm, order));
        Some([0, 1].map(|axis| system.arena.add(sum[axis], part[axis])))
    }

    /// Where the paths of two nodes to the datum meet.
    fn meeting(&self, [mut a, mut b]: [TNode; 2]) -> TNode {
        if a == TNode::DATUM || b == TNode::DATUM {
            return TNode::DATUM;
        }
        while a != b {
            let deeper = if self.depth(a) >= self.depth(b) { &mut a } else { &mut b };
            match &self.steps[deeper.index()] {
                Some(step) => *deeper = step.parent,
                None => return TNode::DATUM,
            }
        }
        a
    }

    /// Angle of a body, or of the ground.
    pub fn angle(&self, node: RNode) -> &ScalarMotion {
        &self.angles[node.index()]
    }

    /// Across variable of an element from the branches that connect its nodes (Eq. 12).
    pub fn across(&self, arena: &mut Arena, ends: [TNode; 2]) -> Motion {
        let base = self.meeting(ends);
        let [from, to] = ends.map(|end| self.relative(arena, base, end));
        Motion::between(arena, &from, &to)
    }

    /// Angle across an element from those of its nodes.
    pub fn angle_across(&self, arena: &mut Arena, ends: [RNode; 2]) -> ScalarMotion {
        let mut angle = self.angle(ends[1]).clone();
        let minus = arena.constant(-1.0);
        angle.accumulate(arena, minus, self.angle(ends[0]));
        angle
    }

    /// A vector fixed in a body.
    pub fn fixed(&self, system: &mut System, body: Option<BodyId>, at: [Expr; 2]) -> Motion {
        let unit = ScalarMotion::constant(&mut system.arena, Expr::ONE);
        self.along(system, body, at, &unit)
    }

    /// Motion of any point of the scene, whether an element uses it or not.
    pub fn place(&self, system: &mut System, place: Place) -> Motion {
        let mechanism = system.mechanism;
        match place {
            _ if system.has_node(place) => {
                let node = system.t_node(place);
                self.node(&mut system.arena, node)
            }
            Place::Ground(point) => {
                let at = mechanism.ground[point].at.each_ref().map(|formula| system.value(formula));
                self.fixed(system, None, at)
            }
            Place::Point(body, point) => {
                let at = mechanism.bodies[body.0].points[point].at.each_ref().map(|formula| system.value(formula));
                let centre = system.t_node(Place::Centre(body));
                let mut motion = self.node(&mut system.arena, centre);
                let arm = self.fixed(system, Some(body), at);
                motion.accumulate(&mut system.arena, Expr::ONE, &arm);
                motion
            }
            Place::Origin | Place::Centre(_) => Motion::default(),
        }
    }

    /// Position of any point of the scene: [`Kinematics::place`] without what a drawing does not need.
    pub fn position(&self, system: &mut System, place: Place) -> Vector {
        let sum = |arena: &mut Arena, node: TNode| {
            let mut position = Vector::default();
            self.path(TNode::DATUM, node).for_each(|across| position.accumulate(arena, &across.position));
            position
        };
        let node = system.t_node(place);
        match place {
            _ if system.has_node(place) => sum(&mut system.arena, node),
            Place::Point(body, point) => {
                let at = system.mechanism.bodies[body.0].points[point].at.each_ref();
                let at = at.map(|formula| system.value(formula));
                let centre = system.t_node(Place::Centre(body));
                let mut position = sum(&mut system.arena, centre);
                let arm = self.fixed(system, Some(body), at).position;
                position.accumulate(&mut system.arena, &arm);
                position
            }
            Place::Ground(_) | Place::Origin | Place::Centre(_) => self.place(system, place).position,
        }
    }

    /// The frame of a body, and components given in its axes in those of the frame.
    pub fn in_frame(&self, system: &mut System, body: Option<BodyId>, [x, y]: [Expr; 2]) -> (FrameId, Vector) {
        let (frame, offset) = self.placement[system.r_node(body).index()];
        let arena = &mut system.arena;
        let (c, s) = (arena.cos(offset), arena.sin(offset));
        let [cx, sy, sx, cy] = [(c, x), (s, y), (s, x), (c, y)].map(|(a, b)| arena.multiply(a, b));
        let components = [arena.subtract(cx, sy), arena.add(sx, cy)];
        (frame, Vector::fixed(frame, components))
    }

    /// The frame that a body (or the ground) turns with, and the constant angle from the frame to the body.
    pub fn placement(&self, node: RNode) -> (FrameId, Expr) {
        self.placement[node.index()]
    }

    /// A direction as a vector, and the frame that it turns with.
    pub fn direction(&self, system: &mut System, direction: Direction) -> (FrameId, Vector) {
        match direction {
            Direction::X => (FrameId::WORLD, Vector::x()),
            Direction::Y => (FrameId::WORLD, Vector::y()),
            Direction::Fixed(body, unit) => self.in_frame(system, body, unit),
        }
    }

    /// The known part of an element's across variable.
    pub fn known(&self, system: &mut System, known: &Known) -> Motion {
        match *known {
            Known::Zero => Motion::default(),
            Known::Fixed(body, at) => self.fixed(system, body, at),
            Known::Along(body, unit, signal) => {
                let displacement = ScalarMotion::signal(&mut system.arena, signal);
                self.along(system, body, unit, &displacement)
            }
            Known::Given([x, y]) => {
                let [x, y] = [x, y].map(|signal| ScalarMotion::signal(&mut system.arena, signal));
                let mut motion = self.along(system, None, [Expr::ONE, Expr::ZERO], &x);
                let vertical = self.along(system, None, [Expr::ZERO, Expr::ONE], &y);
                motion.accumulate(&mut system.arena, Expr::ONE, &vertical);
                motion
            }
        }
    }

    fn across_branch(&self, system: &mut System, row: &TranslationalRow, first: Option<usize>) -> Motion {
        let mut motion = self.known(system, &row.known);
        for (offset, (direction, _)) in row.motion.iter().enumerate() {
            let coordinate = ScalarMotion::coordinate(&mut system.arena, first.unwrap_or_default() + offset);
            let (body, unit) = match *direction {
                Direction::X => (None, [Expr::ONE, Expr::ZERO]),
                Direction::Y => (None, [Expr::ZERO, Expr::ONE]),
                Direction::Fixed(body, unit) => (body, unit),
            };
            let along = self.along(system, body, unit, &coordinate);
            motion.accumulate(&mut system.arena, Expr::ONE, &along);
        }
        motion
    }

    /// Terminal equations of r = s u, with u fixed in a body that turns with omega:
    /// v = s' u + s omega (k x u), a = s'' u + 2 s' omega (k x u) + s alpha (k x u) - s omega^2 u.
    /// A rigid arm is the case of constant s (Table 1).
    fn along(&self, system: &mut System, body: Option<BodyId>, unit: [Expr; 2], s: &ScalarMotion) -> Motion {
        let (frame, u) = self.in_frame(system, body, unit);
        let arena = &mut system.arena;
        let frame = self.frames.get(frame);
        let across = u.turned(arena);
        let length = s.position.total(arena);
        let (position, tangent) = (u.scaled(arena, length), across.scaled(arena, length));
        let mut velocity = s.velocity.map(arena, |arena, &c| u.scaled(arena, c));
        let turning = frame.rate.map(arena, |arena, &c| tangent.scaled(arena, c));
        velocity.accumulate(arena, Expr::ONE, &turning);
        let mut acceleration = s.acceleration.map(arena, |arena, &c| u.scaled(arena, c));
        let coriolis = s.velocity.times(arena, frame.omega).map(arena, |arena, &c| across.scaled(arena, c));
        let two = arena.constant(2.0);
        acceleration.accumulate(arena, two, &coriolis);
        let tangential = frame.acceleration.map(arena, |arena, &c| tangent.scaled(arena, c));
        acceleration.accumulate(arena, Expr::ONE, &tangential);
        let square = arena.square(frame.omega);
        let centripetal = Form::term(arena, square, &position);
        let minus = arena.constant(-1.0);
        acceleration.accumulate(arena, minus, &centripetal);
        Motion { position, velocity, acceleration }
    }
}

/// A displacement projected on a direction that turns, with its total derivatives:
/// g.d, g'.d + omega g.(k x d), g''.d + 2 omega g'.(k x d) + alpha g.(k x d) - omega^2 g.d.
pub fn project(
    kinematics: &Kinematics,
    arena: &mut Arena,
    gap: &Motion,
    (frame, direction): &(FrameId, Vector),
) -> (Scalar, Form<Scalar>, Form<Scalar>) {
    let frame = kinematics.frames.get(*frame);
    let across = direction.turned(arena);
    let (along, beside) = (gap.position.dot(arena, direction), gap.position.dot(arena, &across));
    let mut velocity = gap.velocity.map(arena, |arena, v| v.dot(arena, direction));
    let turning = frame.rate.map(arena, |arena, &c| beside.scaled(arena, c));
    velocity.accumulate(arena, Expr::ONE, &turning);
    let mut acceleration = gap.acceleration.map(arena, |arena, a| a.dot(arena, direction));
    let coriolis = gap.velocity.times(arena, frame.omega).map(arena, |arena, v| v.dot(arena, &across));
    let two = arena.constant(2.0);
    acceleration.accumulate(arena, two, &coriolis);
    let tangential = frame.acceleration.map(arena, |arena, &c| beside.scaled(arena, c));
    acceleration.accumulate(arena, Expr::ONE, &tangential);
    let square = arena.square(frame.omega);
    let centripetal = Form::term(arena, square, &along);
    let minus = arena.constant(-1.0);
    acceleration.accumulate(arena, minus, &centripetal);
    (along, velocity, acceleration)
}

/// Known part of the angle across an element, or its coordinate.
fn angle_of(arena: &mut Arena, element: &Element, coordinate: Option<usize>) -> ScalarMotion {
    match element.rotation.as_ref().map(|row| &row.angle) {
        Some(Angle::Free(_)) => ScalarMotion::coordinate(arena, coordinate.unwrap_or_default()),
        Some(known) => known_angle(arena, known),
        None => ScalarMotion::default(),
    }
}

/// The part of an angle across an element that its own equation makes known.
pub fn known_angle(arena: &mut Arena, angle: &Angle) -> ScalarMotion {
    match angle {
        Angle::Free(_) => ScalarMotion::default(),
        Angle::Constant(value) => ScalarMotion::constant(arena, *value),
        Angle::Given(signal) => ScalarMotion::signal(arena, *signal),
    }
}

/// Does an expression depend on nothing but parameters?
pub fn is_constant(arena: &Arena, expr: Expr) -> bool {
    match arena.node(expr) {
        Node::Constant(_) => true,
        Node::Symbol(symbol) => matches!(symbol, Symbol::Parameter(_)),
        _ => arena.symbols([expr]).iter().all(|symbol| matches!(symbol, Symbol::Parameter(_))),
    }
}

fn angles(system: &mut System, rotation: &Topology<Rotation>, coordinates: &FirstCoordinate) -> Vec<ScalarMotion> {
    let mut angles = vec![ScalarMotion::default(); system.rotation.nodes()];
    for (node, parent, branch, sign) in rotation.outward() {
        let across = angle_of(&mut system.arena, &system.elements[branch.0], coordinates.get(&branch).copied());
        let mut angle = angles[parent.index()].clone();
        let sign = system.arena.constant(f64::from(sign));
        angle.accumulate(&mut system.arena, sign, &across);
        angles[node.index()] = angle;
    }
    angles
}

/// Bodies whose angles differ by a constant share a frame.
fn frames(arena: &mut Arena, angles: &[ScalarMotion]) -> (Frames, Vec<(FrameId, Expr)>) {
    let mut frames = Frames::default();
    let mut known: BTreeMap<Vec<(Expr, Expr)>, FrameId> = BTreeMap::from([(Vec::new(), FrameId::WORLD)]);
    let mut placement = Vec::new();
    for angle in angles {
        let mut moving = Form::default();
        let mut offset = Expr::ZERO;
        for (key, &coefficient) in angle.position.terms() {
            if is_constant(arena, key) {
                let term = arena.multiply(key, coefficient);
                offset = arena.add(offset, term);
            } else {
                moving.add_term(arena, key, &coefficient);
            }
        }
        let key: Vec<(Expr, Expr)> = moving.terms().map(|(k, &c)| (k, c)).collect();
        let frame = known.entry(key).or_insert_with(|| {
            let total = moving.total(arena);
            let unit = [arena.cos(total), arena.sin(total)];
            let omega = angle.velocity.total(arena);
            let (rate, acceleration) = (angle.velocity.clone(), angle.acceleration.clone());
            frames.push(Frame { unit, rate, acceleration, omega, angle: total })
        });
        placement.push((*frame, offset));
    }
    (frames, placement)
}
