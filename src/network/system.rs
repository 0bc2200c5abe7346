//! All elements of a mechanism and the two graphs that they form.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use petgraph::unionfind::UnionFind;

use super::graph::{ElementId, LinearGraph, RNode, Rotation, TNode, Translation};
use super::{
    Angle, Coupling, CouplingTerm, Direction, Element, Force, FunctionOfTime, Implied, Known, Origin, Port,
    RotationalRow, Rows, Torque, Touched, arm, body, table3,
};
use crate::diagnostic::Span;
use crate::expr::{Arena, Expr, Order, Symbol};
use crate::model::translate::translate;
use crate::model::{
    Aspect, Axis, Body, BodyId, CourseValue, DiscreteId, DriverId, Formula, InputId, Mechanism, Motion, Owner, Part,
    Place, Variable,
};

/// The rows of an element of the scene: its component gives them.
type RowsOf = fn(&Part, &mut System) -> Rows;
/// The relation of what it holds on one side, or along which it slips.
type RelationOf = fn(&Part, bool, &mut System) -> Option<Coupling>;

/// The elements of a mechanism, its translational and its rotational graph, and the expressions in their terminal equations.
#[derive(Clone, Debug)]
pub struct System {
    /// What the elements come from.
    pub mechanism: Arc<Mechanism>,
    /// Owns every expression of the equations.
    pub arena: Arena,
    /// Elements in the paper's order: bodies, ground vectors, arms, joints, drivers, loads.
    pub elements: Vec<Element>,
    /// Nodes are points.
    pub translation: LinearGraph<Translation>,
    /// Nodes are bodies.
    pub rotation: LinearGraph<Rotation>,
    /// Drivers that integrate an input: the driver, the input, and which derivative the input prescribes.
    pub followers: Vec<(DriverId, InputId, Order)>,
    /// What the joints imply in second order, each an element of its own.
    pub implied: Vec<Implied>,
    pub(crate) used: BTreeSet<Place>,
    /// Classes of bodies that keep their relative angles.
    held: UnionFind<usize>,
    t_nodes: HashMap<Place, TNode>,
    r_nodes: HashMap<BodyId, RNode>,
    origins: HashMap<Origin, ElementId>,
    /// Names of the scene, which are the labels of nothing else, and the labels so far.
    names: HashSet<String>,
    labels: HashSet<String>,
    rows: RowsOf,
    relation: RelationOf,
}

impl System {
    /// Both graphs of a mechanism whose elements have these rows.
    pub(crate) fn of(mechanism: Arc<Mechanism>, rows: RowsOf, relation: RelationOf) -> Self {
        let mut system = System {
            arena: Arena::default(),
            elements: Vec::new(),
            translation: LinearGraph::default(),
            rotation: LinearGraph::default(),
            followers: Vec::new(),
            implied: Vec::new(),
            used: mechanism.parts().flat_map(Part::places).chain(mechanism.places_of_set_rates()).collect(),
            held: UnionFind::new(mechanism.bodies.len() + 1),
            t_nodes: HashMap::from([(Place::Origin, TNode::DATUM)]),
            r_nodes: HashMap::new(),
            origins: HashMap::new(),
            names: names(&mechanism),
            labels: HashSet::new(),
            rows,
            relation,
            mechanism,
        };
        system.add_nodes();
        system.add_bodies_and_arms();
        let mechanism = Arc::clone(&system.mechanism);
        for part in mechanism.parts() {
            system.add_part(part);
        }
        system.add_contacts();
        system.add_set_rates();
        system.hold_particles();
        system.find_held();
        system
    }

    /// The same with relations that the joints imply: couplings, which are chords in all trees.
    #[must_use]
    pub fn implying(mut self, relations: &[Implied]) -> Self {
        for relation in relations {
            let origin = Origin::Implied(self.implied.len());
            let label = self.label("c", &relation.name);
            let coupling = Some(relation.coupling(&mut self));
            let name = relation.name.clone();
            self.push(Element {
                label,
                name,
                origin,
                translation: None,
                rotation: None,
                coupling,
                closed: None,
                slip: None,
            });
            self.implied.push(relation.clone());
        }
        self
    }

    /// The same with expressions of its own.
    #[must_use]
    pub fn anew(&self) -> Self {
        Self::of(Arc::clone(&self.mechanism), self.rows, self.relation).implying(&self.implied)
    }

    pub fn element(&self, id: ElementId) -> &Element {
        &self.elements[id.0]
    }

    /// What an element is called: of what holds on one side only, or rubs, its own name, such as `guide.max`.
    pub fn name(&self, id: ElementId) -> &str {
        match self.element(id).origin {
            Origin::Contact(index) => &self.mechanism.contacts[index].name,
            _ => &self.element(id).name,
        }
    }

    /// True if it has edges. A joint that only touches or rubs has none: what it holds on one side has one.
    pub fn has_edges(&self, id: ElementId) -> bool {
        let element = self.element(id);
        let has_rows = element.translation.is_some() || element.rotation.is_some() || element.coupling.is_some();
        has_rows || !matches!(element.origin, Origin::Joint(_))
    }

    /// The element that stands for something of the scene.
    pub fn find(&self, origin: Origin) -> Option<ElementId> {
        self.origins.get(&origin).copied()
    }

    /// Where an element comes from in the scene's text.
    pub fn span(&self, id: ElementId) -> Span {
        let mechanism = &self.mechanism;
        match self.element(id).origin {
            Origin::Body(body) => mechanism.bodies[body.0].span,
            Origin::Arm(body, point) => mechanism.bodies[body.0].points[point].span,
            Origin::GroundVector(point) => mechanism.ground[point].span,
            Origin::Joint(joint) => mechanism.joints[joint.0].span,
            Origin::Driver(driver) => mechanism.drivers[driver.0].span,
            Origin::Load(load) => mechanism.loads[load.0].span,
            Origin::Implied(relation) => self.implied[relation].span(mechanism),
            Origin::Contact(index) => mechanism.contacts[index].span,
            Origin::SetRate(index) => mechanism.set_rates[index].span,
        }
    }

    pub fn t_node(&self, place: Place) -> TNode {
        // Every used place has a node; an unused one is only asked for by its body's centre.
        self.t_nodes.get(&place).copied().unwrap_or(TNode::DATUM)
    }

    /// Does a point have a node of its own?
    pub fn has_node(&self, place: Place) -> bool {
        self.t_nodes.contains_key(&place)
    }

    /// The places of the nodes of the translational graph.
    pub fn places(&self) -> Vec<Place> {
        let mut places = vec![Place::Origin; self.translation.nodes()];
        self.t_nodes.iter().for_each(|(&place, node)| places[node.index()] = place);
        places
    }

    /// The node of a body, or of the ground.
    pub fn r_node(&self, body: Option<BodyId>) -> RNode {
        body.and_then(|body| self.r_nodes.get(&body).copied()).unwrap_or(RNode::DATUM)
    }

    /// A formula of time, parameters and inputs.
    pub fn value(&mut self, formula: &Formula) -> Expr {
        // The scene permits no variable where this is used: resolving refuses it with a fault.
        translate(&mut self.arena, formula, &mut |_, _| Expr::ZERO)
    }

    pub(crate) fn values(&mut self, formulas: &[Formula; 2]) -> [Expr; 2] {
        formulas.each_ref().map(|formula| self.value(formula))
    }

    /// The user's name if it is a letter with a number already, else the letter and the number of the element: a label that no other has.
    pub(crate) fn label(&mut self, letter: &str, name: &str) -> String {
        let is_usable = is_label(name) && !self.labels.contains(name);
        let first = self.elements.len() + 1;
        let numbered = || {
            let mut labels = (first..).map(|number| format!("{letter}{number}"));
            labels.find(|label| !self.names.contains(&**label) && !self.labels.contains(label))
        };
        let label = if is_usable { name.to_owned() } else { numbered().unwrap_or_default() };
        self.labels.insert(label.clone());
        label
    }

    /// A discrete variable of what runs over pulleys.
    pub(crate) fn course_value(&mut self, owner: Owner, value: CourseValue) -> Option<Expr> {
        let id = self.mechanism.course_value(owner, value)?;
        Some(self.arena.symbol(Symbol::Discrete(id.0)))
    }

    /// The motion that a driver prescribes.
    pub(crate) fn signal(&mut self, part: &Part) -> FunctionOfTime {
        let value = match (part.motion(), part.owner) {
            (Some(Motion::Given(formula)), _) => self.value(formula),
            (Some(Motion::Velocity(input)), Owner::Driver(driver)) => self.follower(driver, *input, Order::Velocity),
            (Some(Motion::Acceleration(input)), Owner::Driver(driver)) => {
                self.follower(driver, *input, Order::Acceleration)
            }
            (
                Some(Motion::Velocity(_) | Motion::Acceleration(_)),
                Owner::Place(_) | Owner::Joint(_) | Owner::Load(_) | Owner::System,
            )
            | (None, _) => Expr::ZERO,
        };
        self.derivatives(value)
    }

    /// A function of time with its derivatives.
    pub(crate) fn given(&mut self, formula: &Formula) -> FunctionOfTime {
        let value = self.value(formula);
        self.derivatives(value)
    }

    fn derivatives(&mut self, value: Expr) -> FunctionOfTime {
        let rate = self.arena.time_derivative(value);
        let acceleration = self.arena.time_derivative(rate);
        FunctionOfTime { value, rate, acceleration }
    }

    fn follower(&mut self, driver: DriverId, input: InputId, order: Order) -> Expr {
        self.followers.push((driver, input, order));
        self.arena.symbol(Symbol::Follower(self.followers.len() - 1, Order::Position))
    }

    fn add_nodes(&mut self) {
        for (index, body) in self.mechanism.bodies.iter().enumerate() {
            let id = BodyId(index);
            self.t_nodes.insert(Place::Centre(id), self.translation.add_node(&body.name));
            if self.mechanism.dimension == crate::model::Dimension::Two {
                self.r_nodes.insert(id, self.rotation.add_node(&body.name));
            }
        }
        for &place in &self.used {
            if matches!(place, Place::Ground(_) | Place::Point(..)) {
                self.t_nodes.insert(place, self.translation.add_node(self.mechanism.place_name(place)));
            }
        }
    }

    fn add_bodies_and_arms(&mut self) {
        for index in 0..self.mechanism.bodies.len() {
            let element = body::element(self, BodyId(index));
            self.push(element);
        }
        for place in self.used.clone() {
            let element = match place {
                Place::Ground(point) => arm::of_ground(self, point),
                Place::Point(body, point) => arm::of_body(self, body, point),
                Place::Origin | Place::Centre(_) => continue,
            };
            self.push(element);
        }
    }

    fn add_part(&mut self, part: &Part) {
        let mut rows = (self.rows)(part, self);
        let others = std::mem::take(&mut rows.others);
        std::iter::once(rows).chain(others).for_each(|rows| self.add_rows(part, rows));
    }

    fn add_rows(&mut self, part: &Part, rows: Rows) {
        let Some(origin) = Origin::of(part.owner) else { return };
        let (label, name) = (self.label(rows.letter, &part.name), part.name.clone());
        let (mut translation, mut rotation, coupling) = (rows.translation, rows.rotation, rows.coupling);
        let there = self.mechanism.there(part.owner);
        let is_load = part.owner.is_load();
        if let (Some(there), true) = (there, is_load) {
            let there = Formula::Discrete(there);
            translation.iter_mut().for_each(|row| row.through.scale(&there));
            rotation.iter_mut().for_each(|row| row.through.scale(&there));
        }
        let closed = there.filter(|_| !is_load).map(|there| self.arena.symbol(Symbol::Discrete(there.0)));
        self.push(Element { label, name, origin, translation, rotation, coupling, closed, slip: None });
    }

    /// What an element couples, or does within what it holds on one side only.
    pub(crate) fn relation(&mut self, id: ElementId) -> Option<Coupling> {
        let Element { coupling, origin, translation, rotation, .. } = self.element(id);
        let couples_only = coupling.is_none() && translation.is_none() && rotation.is_none();
        if let (true, Origin::Joint(joint)) = (couples_only, *origin) {
            let mechanism = Arc::clone(&self.mechanism);
            let owner = Owner::Joint(joint);
            if mechanism.slip_of(owner).is_some() && mechanism.gaps_of(owner).next().is_none() {
                // What slips is held by nothing but its friction.
                return None;
            }
            return (self.relation)(&mechanism.joints[joint.0], false, self);
        }
        coupling.clone()
    }

    /// gap = sign x (sum of factor x across - offset - bound), each a chord of its own.
    fn add_contacts(&mut self) {
        let mechanism = Arc::clone(&self.mechanism);
        for (index, contact) in mechanism.contacts.iter().enumerate() {
            let Some(part) = mechanism.parts().find(|part| part.owner == contact.owner) else { continue };
            let minus = self.arena.constant(-contact.gap.sign);
            let bound = self.value(&contact.gap.bound);
            let touched = contact.state.feature.map(|held| self.touched(part, held));
            let relation = touched.or_else(|| (self.relation)(part, contact.slip.is_some(), self));
            let Some(relation) = relation else { continue };
            let terms = relation
                .terms
                .into_iter()
                .map(|term| CouplingTerm { factor: self.arena.multiply(minus, term.factor), port: term.port });
            let terms = terms.collect();
            let bound = self.arena.add(relation.offset, bound);
            let offset = self.arena.multiply(minus, bound);
            let closed = Some(self.arena.symbol(Symbol::Discrete(contact.state.closed.0)));
            let coupling = Some(Coupling { terms, offset });
            let label = self.label("k", &contact.name);
            let (name, origin) = (part.name.clone(), Origin::Contact(index));
            let slip = contact.state.direction.map(|direction| self.arena.symbol(Symbol::Discrete(direction.0)));
            self.push(Element { label, name, origin, translation: None, rotation: None, coupling, closed, slip });
        }
    }

    /// The distance from the feature of a profile that discrete variables say.
    fn touched(&mut self, part: &Part, held: [DiscreteId; 7]) -> Coupling {
        let [nx, ny, x, y, curvature, away, _] = held.map(|id| self.arena.symbol(Symbol::Discrete(id.0)));
        let touched = Touched { normal: [nx, ny], at: [x, y], curvature, away };
        let ends = part.between.map(|place| self.t_node(place));
        Coupling::of(Port::Feature(ends, part.between[0].body(), touched))
    }

    /// The rate of a motion that events set: a loop equation of that motion, which holds at the instant only.
    fn add_set_rates(&mut self) {
        let mechanism = Arc::clone(&self.mechanism);
        for (index, set) in mechanism.set_rates.iter().enumerate() {
            let Some(port) = self.port_of(set.variable) else { continue };
            let name = mechanism.variable_name(set.variable);
            let label = self.label("k", &name);
            let (coupling, origin) = (Some(Coupling::of(port)), Origin::SetRate(index));
            let closed = Some(self.arena.symbol(Symbol::Discrete(set.now.0)));
            self.push(Element { label, name, origin, translation: None, rotation: None, coupling, closed, slip: None });
        }
    }

    /// The motion whose rate a variable is.
    fn port_of(&mut self, variable: Variable) -> Option<Port> {
        let mechanism = Arc::clone(&self.mechanism);
        let from_ground = |system: &Self, place: Place| [RNode::DATUM, system.r_node(place.body())];
        Some(match (variable.owner, variable.quantity.aspect()) {
            (Owner::Place(place), Aspect::Angle(_)) => Port::Angle(from_ground(self, place)),
            (Owner::Place(place), Aspect::Along(axis, _)) => {
                let direction = match axis {
                    Axis::X => Direction::X,
                    Axis::Y => Direction::Y,
                };
                Port::Along([TNode::DATUM, self.t_node(place)], direction)
            }
            (Owner::Joint(joint), Aspect::Angle(_)) => {
                Port::Angle(mechanism.joints[joint.0].bodies().map(|body| self.r_node(body)))
            }
            (Owner::Joint(joint), Aspect::Slide(_)) => {
                let part = &mechanism.joints[joint.0];
                let axis = Direction::Fixed(part.between[0].body(), self.values(&part.vector("axis")));
                Port::Along(part.between.map(|place| self.t_node(place)), axis)
            }
            _ => return None,
        })
    }

    fn push(&mut self, element: Element) {
        let id = ElementId(self.elements.len());
        if let Some(row) = &element.translation {
            self.translation.add_edge(id, row.ends);
        }
        if let Some(row) = &element.rotation {
            self.rotation.add_edge(id, row.ends);
        }
        self.origins.entry(element.origin).or_insert(id);
        self.elements.push(element);
    }
}

/// A letter with a number, as the paper calls its elements.
fn is_label(name: &str) -> bool {
    let number = name.trim_start_matches(|c: char| c.is_ascii_alphabetic());
    let letters = &name[..name.len() - number.len()];
    (letters.len() == 1 || letters == "Theta")
        && (1..=3).contains(&number.len())
        && number.bytes().all(|digit| digit.is_ascii_digit())
}

/// The names of bodies and parts.
fn names(mechanism: &Mechanism) -> HashSet<String> {
    let bodies = mechanism.bodies.iter().map(|body| body.name.clone());
    bodies.chain(mechanism.parts().map(|part| part.name.clone())).collect()
}

/// Particles: bodies with an inertia of zero that nothing turns, and by whose axes nothing is directed. However they turned nothing else would change, so they keep
/// the angle of the ground.
impl System {
    fn hold_particles(&mut self) {
        let without_inertia = |body: &Body| body.inertia == Some(Formula::Number(0.0));
        if !self.mechanism.bodies.iter().any(without_inertia) {
            return;
        }
        for body in self.unturned() {
            let id = self.find(Origin::Body(body)).filter(|_| without_inertia(&self.mechanism.bodies[body.0]));
            if let Some(row) = id.and_then(|id| self.elements[id.0].rotation.as_mut()) {
                (row.priority, row.angle, row.through) = (table3::PRISMATIC, Angle::Constant(Expr::ZERO), Torque::None);
            }
        }
    }

    /// The bodies that nothing turns, by whose axes nothing is directed, and of whose angle nothing is given.
    pub fn unturned(&self) -> Vec<BodyId> {
        let given = self.mechanism.initial.iter().filter(|line| line.variable.quantity.turns());
        let given = given.filter_map(|line| match line.variable.owner {
            Owner::Place(Place::Centre(body)) => Some(body),
            Owner::Place(_) | Owner::Joint(_) | Owner::Driver(_) | Owner::Load(_) | Owner::System => None,
        });
        let turned = self.elements.iter().flat_map(|element| self.turned_by(element)).chain(given);
        let turned: HashSet<BodyId> = turned.collect();
        let bodies = (0..self.mechanism.bodies.len()).map(BodyId);
        bodies.filter(|body| self.r_nodes.contains_key(body) && !turned.contains(body)).collect()
    }

    /// The bodies that an element turns, or whose axes it uses.
    fn turned_by(&self, element: &Element) -> Vec<BodyId> {
        let is_free = |row: &RotationalRow| {
            matches!((&row.angle, &row.through), (Angle::Free(_), Torque::None)) && row.armature == Expr::ZERO
        };
        let rotation =
            element.rotation.iter().filter(|row| !is_free(row) && !matches!(element.origin, Origin::Body(_)));
        let mut nodes: Vec<RNode> = rotation.flat_map(|row| row.ends).collect();
        let mut bodies = Vec::new();
        if let Some(row) = &element.translation {
            let at_the_centre = matches!(row.known, Known::Fixed(_, at) if at == [Expr::ZERO; 2]);
            bodies.extend(row.carrier().filter(|_| !at_the_centre));
            bodies.extend(if let Force::InBody(body, _) = row.through { Some(body) } else { None });
        }
        for term in element.coupling.iter().flat_map(|coupling| &coupling.terms) {
            match term.port {
                Port::Angle(ends) | Port::Curve(ends, _) => nodes.extend(ends),
                Port::Along(_, direction) => bodies.extend(direction.carrier()),
                Port::Feature(_, body, _) => bodies.extend(body),
                Port::Length(_) | Port::Heading(_) | Port::Span(..) => {}
            }
        }
        // The nodes of the rotational graph are the ground and the bodies, in their order.
        bodies.extend(nodes.into_iter().filter_map(|node| node.index().checked_sub(1)).map(BodyId));
        bodies
    }

    /// Is a body's angle held to the ground's by prismatic joints and welds?
    pub fn cannot_turn(&self, body: BodyId) -> bool {
        self.held.equiv(RNode::DATUM.index(), self.r_node(Some(body)).index())
    }

    fn find_held(&mut self) {
        for element in &self.elements {
            if let Some(RotationalRow { ends: [a, b], angle: Angle::Constant(_), .. }) = &element.rotation {
                self.held.union(a.index(), b.index());
            }
        }
    }
}
