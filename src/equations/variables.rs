//! Every variable of the naming table as an expression of time, inputs, coordinates, rates, accelerations and reactions.

use super::couplings;
use super::form::{Coefficient, LinearForm};
use super::inertias::{inertia, mass};
use super::kinematics::{Kinematics, PointMotion, ScalarMotion};
use super::vector::Vector;
use super::{Constraint, Equations, RowKind, Standing};
use crate::expr::{Binary, Expr, Order, Symbol, Unary};
use crate::model::{
    Aspect, Axis, BodyId, ContactQuantity, Dimension, DiscreteId, DriverId, Effort, JointId, LoadId, Owner, Part,
    Place, Quantity, Variable, Whole,
};
use crate::network::{
    Angle, Constrained, Coupling, CouplingTerm, Curve, Direction, ElementId, Force, Origin, Port, RNode, RotationalRow,
    System, TNode, Torque, TranslationalRow,
};

/// Ends are together where the square of their distance is no more than a few of the smallest numbers, so that its root has lost digits.
const LEAST_LENGTH: f64 = 1e-150;

impl Equations {
    /// The expression of a variable; zero if its owner has no such quantity (the scene refuses that).
    pub fn variable(&mut self, variable: Variable) -> Expr {
        if let Some(&expr) = self.known.get(&variable) {
            return expr;
        }
        let expr = match variable.owner {
            Owner::Place(place) => self.of_place(place, variable.quantity),
            Owner::Joint(joint) => self.of_joint(joint, variable.quantity),
            Owner::Driver(driver) => self.of_driver(driver, variable.quantity),
            Owner::Load(load) => self.of_load(load, variable.quantity),
            Owner::System => self.of_system(variable.quantity),
        };
        self.known.insert(variable, expr);
        expr
    }

    /// Expressions of variables in which trivial loop equations have multipliers too: a joint that repeats a parallel one shares its load.
    pub(crate) fn with_all_reactions(&mut self, variables: &[Variable]) -> Vec<Expr> {
        let trivial: Vec<usize> = self.rows_of(Standing::Trivial);
        let before = (self.dynamics.take(), self.through.take(), std::mem::take(&mut self.known));
        trivial.iter().for_each(|&row| self.constraints[row].kind = RowKind::Loop(Standing::Repeats));
        let values = variables.iter().map(|&variable| self.variable(variable)).collect();
        trivial.iter().for_each(|&row| self.constraints[row].kind = RowKind::Loop(Standing::Trivial));
        (self.dynamics, self.through, self.known) = before;
        values
    }

    pub(crate) fn redefine(&mut self, variable: Variable, expr: Expr) {
        self.known.insert(variable, expr);
    }

    fn of_place(&mut self, place: Place, quantity: Quantity) -> Expr {
        match quantity.aspect() {
            Aspect::Angle(order) => {
                let node = self.system.r_node(place.body());
                let angle = self.kinematics.angle(node).clone();
                self.of_angle(&angle, order)
            }
            Aspect::Along(axis, order) => self.of_point(place, axis, order),
            Aspect::Slide(_) | Aspect::Length(_) | Aspect::PressureAngle | Aspect::Curvature | Aspect::State => {
                Expr::ZERO
            }
            Aspect::Effort(_) | Aspect::Contact(_) | Aspect::Whole(_) => Expr::ZERO,
        }
    }

    /// A component of the motion of a place; at the end of a deep path its sums are known.
    fn of_point(&mut self, place: Place, axis: Axis, order: Order) -> Expr {
        if let Some([x, y]) = self.kinematics.total_of_place(&mut self.system, place, order) {
            return match axis {
                Axis::X => x,
                Axis::Y => y,
            };
        }
        let motion = match order {
            Order::Position => {
                let position = self.kinematics.position(&mut self.system, place);
                PointMotion { position, ..PointMotion::default() }
            }
            Order::Velocity | Order::Acceleration => self.kinematics.place(&mut self.system, place),
        };
        self.of_motion(&motion, axis, order)
    }

    fn of_motion(&mut self, motion: &PointMotion, axis: Axis, order: Order) -> Expr {
        let axis = match axis {
            Axis::X => Vector::x(),
            Axis::Y => Vector::y(),
        };
        match order {
            Order::Position => self.dot(&motion.position, &axis),
            Order::Velocity => self.component(&motion.velocity, &axis),
            Order::Acceleration => self.component(&motion.acceleration, &axis),
        }
    }

    fn of_angle(&mut self, angle: &ScalarMotion, order: Order) -> Expr {
        let arena = &mut self.system.arena;
        match order {
            Order::Position => angle.position.total(arena),
            Order::Velocity => angle.velocity.total(arena),
            Order::Acceleration => angle.acceleration.total(arena),
        }
    }

    fn angle_across(&mut self, id: ElementId, order: Order) -> Expr {
        let Some(ends) = self.system.element(id).rotation.as_ref().map(|row| row.ends) else { return Expr::ZERO };
        let angle = self.kinematics.angle_across(&mut self.system.arena, ends);
        self.of_angle(&angle, order)
    }

    fn of_joint(&mut self, joint: JointId, quantity: Quantity) -> Expr {
        let Some(id) = self.system.find(Origin::Joint(joint)) else { return Expr::ZERO };
        let is_contact = matches!(quantity.aspect(), Aspect::Contact(_));
        let relation = self.system.relation(id).filter(|coupling| coupling.curve().is_some() && !is_contact);
        if let Some(coupling) = relation {
            return self.of_curve(id, &coupling, quantity);
        }
        match quantity.aspect() {
            Aspect::Angle(order) if self.system.element(id).rotation.is_none() => self.slip(joint, order),
            Aspect::Angle(order) => self.angle_across(id, order),
            Aspect::Slide(order) if self.system.element(id).translation.is_none() => self.slip(joint, order),
            Aspect::Slide(order) => self.slide(id, order),
            Aspect::Effort(effort) => match effort {
                Effort::X => self.force_along(id, Direction::X),
                Effort::Y => self.force_along(id, Direction::Y),
                Effort::Normal if self.system.element(id).translation.is_none() => self.pressure(Owner::Joint(joint)),
                Effort::Normal => self.normal_force(joint, id),
                Effort::Tangential if self.rubs(joint) || self.system.element(id).translation.is_none() => {
                    self.rubbing(Origin::Joint(joint))
                }
                Effort::Tangential => self.coupling_reaction(id),
                Effort::Force => self.joint_force(id),
                Effort::Torque => self.joint_torque(id),
                Effort::Power => self.power(id),
            },
            Aspect::Length(order) => self.coupled_length(id, order),
            Aspect::Along(..) | Aspect::PressureAngle | Aspect::Curvature => Expr::ZERO,
            Aspect::Contact(ContactQuantity::Impulse | ContactQuantity::LostEnergy)
                if self.system.mechanism.engaging(Owner::Joint(joint)).is_some() =>
            {
                self.engaging_impulse(Owner::Joint(joint), quantity)
            }
            Aspect::Contact(contact) => self.contact_quantity(Owner::Joint(joint), contact),
            Aspect::State | Aspect::Whole(_) => Expr::ZERO,
        }
    }

    /// What is said of a coupling by a function of an angle: the angle within its turn, the contact, and the loads.
    fn of_curve(&mut self, id: ElementId, coupling: &Coupling, quantity: Quantity) -> Expr {
        let Some((ends, curve)) = coupling.curve() else { return Expr::ZERO };
        let within = self.system.arena.symbol(Symbol::Argument);
        match quantity.aspect() {
            Aspect::Angle(Order::Position) => self.at_angle(ends, within),
            Aspect::PressureAngle => self.at_angle(ends, curve.pressure),
            Aspect::Curvature => self.at_angle(ends, curve.curvature),
            Aspect::Effort(Effort::Normal) => {
                let leverage = self.at_angle(ends, curve.leverage);
                let reaction = self.coupling_reaction(id);
                self.system.arena.divide(reaction, leverage)
            }
            Aspect::Effort(Effort::Torque) => {
                let slope = self.at_angle(ends, curve.value[1]);
                let factor = coupling
                    .terms
                    .iter()
                    .find(|term| matches!(term.port, Port::Curve(..)))
                    .map_or(Expr::ZERO, |term| term.factor);
                let reaction = self.coupling_reaction(id);
                let arena = &mut self.system.arena;
                let lever = arena.multiply(factor, slope);
                arena.multiply(lever, reaction)
            }
            Aspect::Angle(Order::Velocity | Order::Acceleration) | Aspect::Along(..) | Aspect::Slide(_) => Expr::ZERO,
            Aspect::Length(_) | Aspect::State | Aspect::Contact(_) | Aspect::Whole(_) => Expr::ZERO,
            Aspect::Effort(Effort::X | Effort::Y | Effort::Tangential | Effort::Force | Effort::Power) => Expr::ZERO,
        }
    }

    /// A function of the angle between two nodes.
    fn at_angle(&mut self, ends: [RNode; 2], function: Expr) -> Expr {
        let arena = &mut self.system.arena;
        let angle = self.kinematics.angle_across(arena, ends).position.total(arena);
        Curve::at(arena, function, angle)
    }

    /// s = r . u, s' = v . u, s'' = a . u + s omega^2, with r = s u the across variable without its known part.
    fn slide(&mut self, id: ElementId, order: Order) -> Expr {
        let Some(row) = self.system.element(id).translation.clone() else { return Expr::ZERO };
        let Some(&(direction, _)) = row.motion.first() else { return Expr::ZERO };
        let known = self.kinematics.known(&mut self.system, &row.known);
        let across = self.kinematics.across(&mut self.system.arena, row.ends);
        let across = PointMotion::between(&mut self.system.arena, &known, &across);
        let (frame, axis) = self.kinematics.direction(&mut self.system, direction);
        match order {
            Order::Position => self.dot(&across.position, &axis),
            Order::Velocity => self.component(&across.velocity, &axis),
            Order::Acceleration => {
                let along = self.component(&across.acceleration, &axis);
                let displacement = self.dot(&across.position, &axis);
                let omega = self.kinematics.frames.get(frame).omega;
                let arena = &mut self.system.arena;
                let square = arena.square(omega);
                let centrifugal = arena.multiply(displacement, square);
                arena.add(along, centrifugal)
            }
        }
    }

    /// The force along a joint's free or coupled direction.
    fn joint_force(&mut self, id: ElementId) -> Expr {
        match self.system.relation(id) {
            None => {
                let element = self.system.element(id);
                let (row, origin) = (element.translation.clone(), element.origin);
                let resisting = self.resisting_force(row.as_ref());
                let rubbing = self.rubbing(origin);
                self.system.arena.add(resisting, rubbing)
            }
            // What holds an angle alone exerts no force.
            Some(coupling) if matches!(coupling.terms[..], [CouplingTerm { port: Port::Angle(_), .. }]) => Expr::ZERO,
            Some(_) => self.coupling_reaction(id),
        }
    }

    /// True if a joint has dry friction that sticks.
    fn rubs(&self, joint: JointId) -> bool {
        self.system.mechanism.slip_of(Owner::Joint(joint)).is_some()
    }

    /// What dry friction that sticks exerts along the motion of its joint.
    pub(super) fn rubbing(&mut self, origin: Origin) -> Expr {
        let Origin::Joint(joint) = origin else { return Expr::ZERO };
        let mechanism = self.system.mechanism.clone();
        let Some((index, ..)) = mechanism.slip_of(Owner::Joint(joint)) else { return Expr::ZERO };
        let rows = self.row_of_contact(index).zip(self.row_of_level(index));
        let Some((row, level)) = rows else { return Expr::ZERO };
        let gap = self.constraints[row].contact();
        let Some(direction) = gap.and_then(|gap| gap.slip.as_ref()).map(|slip| slip.direction) else {
            return Expr::ZERO;
        };
        let arena = &mut self.system.arena;
        let [held, level] = [row, level].map(|row| arena.symbol(Symbol::Reaction(row)));
        let total = arena.add_product(held, direction, level);
        arena.negate(total)
    }

    /// A joint's reaction torque, or the torque about its free or coupled axis.
    fn joint_torque(&mut self, id: ElementId) -> Expr {
        let element = self.system.element(id).clone();
        let row = element.rotation.as_ref();
        match self.system.relation(id) {
            None if row.is_some_and(|row| matches!(row.angle, Angle::Constant(_))) => self.torque_of(id),
            None => {
                let resisting = self.resisting_torque(row);
                let rubbing = self.rubbing(element.origin);
                self.system.arena.add(resisting, rubbing)
            }
            Some(coupling) => {
                let factor = coupling.terms.iter().find(|term| matches!(term.port, Port::Angle(_)));
                let reaction = self.coupling_reaction(id);
                factor.map_or(Expr::ZERO, |term| self.system.arena.multiply(term.factor, reaction))
            }
        }
    }

    /// Damping and friction along the only direction of the motion space.
    pub(super) fn resisting_force(&mut self, row: Option<&TranslationalRow>) -> Expr {
        let Some((row, &(direction, _))) = row.and_then(|row| Some((row, row.motion.first()?))) else {
            return Expr::ZERO;
        };
        let Force::Resistance(law) = row.through else { return Expr::ZERO };
        let speed = self.kinematics.speed_along(&mut self.system, row.ends, direction);
        law.at(&mut self.system.arena, speed)
    }

    pub(super) fn resisting_torque(&mut self, row: Option<&RotationalRow>) -> Expr {
        let Some((row, Torque::Resistance(law))) = row.map(|row| (row, &row.through)) else { return Expr::ZERO };
        let arena = &mut self.system.arena;
        let omega = self.kinematics.angle_across(arena, row.ends).velocity.total(arena);
        law.at(arena, omega)
    }

    fn coupling_reaction(&mut self, id: ElementId) -> Expr {
        let of_coupling = |row: &Constraint| row.element == id && !row.coupled.is_empty() && !row.is_trivial();
        match (self.constraints.iter().position(of_coupling), self.system.element(id).origin) {
            (Some(index), _) => self.system.arena.symbol(Symbol::Reaction(index)),
            (None, Origin::Joint(joint)) => self.contact_quantity(Owner::Joint(joint), ContactQuantity::Reaction),
            (None, _) => Expr::ZERO,
        }
    }

    /// Of what an owner holds on one side: a sum over both of its sides, each with the sign of the motion that it stops.
    fn contact_quantity(&mut self, owner: Owner, what: ContactQuantity) -> Expr {
        let mechanism = self.system.mechanism.clone();
        if what == ContactQuantity::Engaged {
            let engaged = mechanism.engaging(owner).map(|engaging| Symbol::Discrete(engaging.engaged.0));
            return engaged.map_or(Expr::ZERO, |engaged| self.system.arena.symbol(engaged));
        }
        let mut total = Expr::ZERO;
        let direction = mechanism.slip_of(owner).and_then(|(_, friction, _)| friction.state.direction);
        let rubs_only = mechanism.gaps_of(owner).next().is_none();
        if let (Some(direction), true) =
            (direction, what == ContactQuantity::Sliding || what == ContactQuantity::Mode && rubs_only)
        {
            return self.direction(owner, direction);
        }
        if let (Some(contour), ContactQuantity::Gap) = (mechanism.part_of(owner).and_then(Part::contour), what) {
            return self.gap_at_profile(owner, contour);
        }
        if what == ContactQuantity::Gap && mechanism.gaps_of(owner).next().is_none() {
            return self.gap_apart(owner);
        }
        for (index, contact) in mechanism.gaps_of(owner) {
            let row = self.row_of_contact(index);
            let sign = contact.gap.sign;
            let arena = &mut self.system.arena;
            let value = match what {
                ContactQuantity::Gap => {
                    let gap = row.and_then(|row| self.constraints[row].contact()).map(|gap| gap.value);
                    let lever = gap_lever(&mut self.system, owner);
                    self.system.arena.multiply(gap.unwrap_or(Expr::ZERO), lever)
                }
                ContactQuantity::Reaction => row.map_or(Expr::ZERO, |row| {
                    let reaction = arena.symbol(Symbol::Reaction(row));
                    let factor = arena.constant(-sign);
                    arena.multiply(factor, reaction)
                }),
                ContactQuantity::Sliding | ContactQuantity::Engaged | ContactQuantity::LostEnergy => Expr::ZERO,
                ContactQuantity::Impulse => {
                    // A contact presses, whichever side it is on.
                    let presses = contact.gap.word.is_empty() && !contact.gap.of_rate;
                    let sign = if presses { 1.0 } else { sign };
                    let (factor, impulse) =
                        (arena.constant(sign), arena.symbol(Symbol::Discrete(contact.state.impulse.0)));
                    arena.multiply(factor, impulse)
                }
                ContactQuantity::Mode => {
                    let (factor, closed) =
                        (arena.constant(-sign), arena.symbol(Symbol::Discrete(contact.state.closed.0)));
                    let counts = contact.gap.word.is_empty() || contact.state.feature.is_some();
                    if counts { closed } else { arena.multiply(factor, closed) }
                }
            };
            total = self.system.arena.add(total, value);
        }
        total
    }

    /// An impulse of the last engagement of a joint, or the energy lost by it.
    fn engaging_impulse(&mut self, owner: Owner, quantity: Quantity) -> Expr {
        let mechanism = self.system.mechanism.clone();
        let Some(engaging) = mechanism.engaging(owner) else { return Expr::ZERO };
        let of_impulse = || engaging.impulses.iter().find(|(other, _)| *other == quantity).map(|(_, id)| *id);
        let id = if quantity == Quantity::LostEnergy { engaging.lost } else { of_impulse() };
        id.map_or(Expr::ZERO, |id| self.system.arena.symbol(Symbol::Discrete(id.0)))
    }

    /// The distance of the points of a rod, whether it holds or not.
    fn coupled_length(&mut self, id: ElementId, order: Order) -> Expr {
        match self.system.relation(id) {
            Some(coupling) if matches!(coupling.terms[..], [CouplingTerm { port: Port::Length(_), .. }]) => {
                couplings::along(&mut self.system, &self.kinematics, &coupling.terms, order)
            }
            _ => Expr::ZERO,
        }
    }

    /// Which way something slides; 0 once an event has removed it.
    fn direction(&mut self, owner: Owner, direction: DiscreteId) -> Expr {
        let there = self.system.mechanism.there(owner);
        let arena = &mut self.system.arena;
        let direction = arena.symbol(Symbol::Discrete(direction.0));
        match there {
            Some(there) => {
                let there = arena.symbol(Symbol::Discrete(there.0));
                arena.multiply(there, direction)
            }
            None => direction,
        }
    }

    /// The gap of something whose relation is among no loop equations: sign x (what it is off by - bound).
    fn gap_apart(&mut self, owner: Owner) -> Expr {
        let mechanism = self.system.mechanism.clone();
        let Owner::Joint(joint) = owner else { return Expr::ZERO };
        let part = &mechanism.joints[joint.0];
        let gap = (part.component().gaps)(part, &mechanism).into_iter().next();
        let relation = self.system.find(Origin::Joint(joint)).and_then(|id| self.system.relation(id));
        let (Some(gap), Some(relation)) = (gap, relation) else { return Expr::ZERO };
        let along = couplings::along(&mut self.system, &self.kinematics, &relation.terms, Order::Position);
        let bound = self.system.value(&gap.bound);
        let arena = &mut self.system.arena;
        let bound = arena.add(relation.offset, bound);
        let off = arena.subtract(along, bound);
        let sign = arena.constant(gap.sign);
        arena.multiply(sign, off)
    }

    /// The motion of a contact along its line, with the turning of its disc.
    pub(super) fn slip(&mut self, joint: JointId, order: Order) -> Expr {
        let mechanism = self.system.mechanism.clone();
        let part = &mechanism.joints[joint.0];
        let Some(rubs) = part.component().rubs else { return Expr::ZERO };
        let Some(Coupling { terms, .. }) = (rubs.along)(part, &mut self.system) else { return Expr::ZERO };
        couplings::along(&mut self.system, &self.kinematics, &terms, order)
    }

    /// The force with which something presses, whichever side it is on; at a profile the sum of those in all places where it is touched.
    fn pressure(&mut self, owner: Owner) -> Expr {
        let mechanism = self.system.mechanism.clone();
        let at_profile = mechanism.part_of(owner).is_some_and(|part| part.contour().is_some());
        let most = if at_profile { usize::MAX } else { 1 };
        let mut total = Expr::ZERO;
        for (index, _) in mechanism.gaps_of(owner).take(most) {
            let Some(row) = self.row_of_contact(index) else { continue };
            let arena = &mut self.system.arena;
            let reaction = arena.symbol(Symbol::Reaction(row));
            total = arena.subtract(total, reaction);
        }
        total
    }

    /// True for a loop equation of something that only presses.
    pub(crate) fn presses(&self, row: &Constraint) -> bool {
        matches!(self.system.element(row.element).origin, Origin::Contact(_))
    }

    /// True for a loop equation of a joint that is open at the start, and of a rate that events set.
    pub(crate) fn opens_at_start(&self, row: &Constraint) -> bool {
        let mechanism = &self.system.mechanism;
        match self.system.element(row.element).origin {
            Origin::SetRate(_) => true,
            Origin::Joint(joint) => mechanism.engaging(Owner::Joint(joint)).is_some_and(|engaging| !engaging.begins),
            _ => false,
        }
    }

    /// True if what is held on one side moves, as drivers say.
    pub(crate) fn drivers_move_contact(&self, index: usize) -> bool {
        let id = self.system.find(Origin::Contact(index));
        let row = self.constraints.iter().find(|row| Some(row.element) == id);
        row.is_some_and(|row| !row.time_rate.is_zero() || !row.followers.is_empty())
    }

    /// The loop equation of something that is held on one side; none if nothing that moves is.
    pub fn row_of_contact(&self, index: usize) -> Option<usize> {
        let id = self.system.find(Origin::Contact(index))?;
        self.constraints.iter().position(|row| row.element == id && row.contact().is_some())
    }

    /// The row whose multiplier is the friction limit of a contact; none without friction.
    pub fn row_of_level(&self, index: usize) -> Option<usize> {
        let id = self.system.find(Origin::Contact(index))?;
        self.constraints.iter().position(|row| row.element == id && matches!(row.kind, RowKind::FrictionLimit))
    }

    /// The loop equation of something that may hold or stick; none where drivers lead it, which never does.
    pub fn row_that_may_hold(&self, index: usize) -> Option<usize> {
        self.row_of_contact(index).filter(|&row| matches!(self.constraints[row].kind, RowKind::Contact(_)))
    }

    /// True for what rubs where drivers lead it.
    pub fn is_led(&self, index: usize) -> bool {
        self.row_of_contact(index).is_some_and(|row| matches!(self.constraints[row].kind, RowKind::DrivenContact(_)))
    }

    /// The first thing that rubs where drivers lead it.
    pub fn first_led(&self) -> Option<usize> {
        (0..self.system.mechanism.contacts.len()).find(|&index| self.is_led(index))
    }

    /// A displacement driver as a branch carries the joint's normal force too: the two lie side by side.
    fn normal_force(&mut self, joint: JointId, id: ElementId) -> Expr {
        let Some(&normal) = self.system.element(id).translation.as_ref().and_then(|row| row.reaction.first()) else {
            return Expr::ZERO;
        };
        let mut total = self.force_along(id, normal);
        for (index, driver) in self.system.mechanism.clone().drivers.iter().enumerate() {
            if driver.joint() == Some(joint)
                && let Some(beside) = self.system.find(Origin::Driver(DriverId(index)))
            {
                let share = self.force_along(beside, normal);
                total = self.system.arena.add(total, share);
            }
        }
        total
    }

    fn of_driver(&mut self, driver: DriverId, quantity: Quantity) -> Expr {
        let Some(id) = self.system.find(Origin::Driver(driver)) else { return Expr::ZERO };
        let Aspect::Effort(effort) = quantity.aspect() else { return Expr::ZERO };
        match effort {
            Effort::Torque => self.torque_of(id),
            Effort::X => self.force_along(id, Direction::X),
            Effort::Y => self.force_along(id, Direction::Y),
            Effort::Force => {
                let axis = self.system.element(id).translation.as_ref().and_then(|row| row.reaction.first().copied());
                axis.map_or(Expr::ZERO, |axis| self.force_along(id, axis))
            }
            Effort::Power => self.power(id),
            Effort::Normal | Effort::Tangential => Expr::ZERO,
        }
    }

    fn of_load(&mut self, load: LoadId, quantity: Quantity) -> Expr {
        let Some(id) = self.system.find(Origin::Load(load)) else { return Expr::ZERO };
        if let Aspect::Length(order) = quantity.aspect()
            && let Some(length) = self.course_length(Owner::Load(load), order)
        {
            return length;
        }
        match quantity.aspect() {
            Aspect::Angle(order) => self.angle_across(id, order),
            Aspect::Length(Order::Position) => self.ends(id).map_or(Expr::ZERO, |ends| self.line(ends)),
            Aspect::Length(Order::Velocity) => match self.centred(id) {
                Some(centred) => self.rate_from_together(id, !centred.damped.is_empty()),
                None => self.ends(id).map_or(Expr::ZERO, |ends| self.line_rate(ends)),
            },
            Aspect::Length(Order::Acceleration) => self.spanned(id, Axis::X, Order::Acceleration),
            Aspect::Along(axis, order) => self.spanned(id, axis, order),
            Aspect::Effort(effort) => match effort {
                Effort::X => self.load_force(id, &Vector::x()),
                Effort::Y => self.load_force(id, &Vector::y()),
                Effort::Force => self.line_law(load, id),
                Effort::Torque => self.laws.torques.get(&id).copied().unwrap_or(Expr::ZERO),
                Effort::Power => self.power(id),
                Effort::Normal | Effort::Tangential => Expr::ZERO,
            },
            Aspect::State => {
                let variable = Some(Variable { owner: Owner::Load(load), quantity });
                let place = self.system.mechanism.states.iter().position(|state| state.variable == variable);
                place.map_or(Expr::ZERO, |index| self.system.arena.symbol(Symbol::State(index, Order::Position)))
            }
            Aspect::Contact(contact) => self.contact_quantity(Owner::Load(load), contact),
            Aspect::Slide(_) | Aspect::PressureAngle | Aspect::Curvature | Aspect::Whole(_) => Expr::ZERO,
        }
    }

    /// A component of a load's force on its second point.
    fn load_force(&mut self, id: ElementId, axis: &Vector) -> Expr {
        match self.laws.forces.get(&id).cloned() {
            Some(force) => self.component(&force, axis),
            None => Expr::ZERO,
        }
    }

    fn ends(&self, id: ElementId) -> Option<[TNode; 2]> {
        self.system.element(id).translation.as_ref().map(|row| row.ends)
    }

    /// A component of the motion of a load's second point against its first.
    fn spanned(&mut self, id: ElementId, axis: Axis, order: Order) -> Expr {
        let Some(ends) = self.ends(id) else { return Expr::ZERO };
        let across = self.kinematics.across(&mut self.system.arena, ends);
        self.of_motion(&across, axis, order)
    }

    /// |d| in the plane; x_b - x_a on a line.
    fn line(&mut self, ends: [TNode; 2]) -> Expr {
        let across = self.kinematics.spanned(&mut self.system, ends);
        match self.system.mechanism.dimension {
            Dimension::One => self.of_motion(&across, Axis::X, Order::Position),
            Dimension::Two => self.length(&across.position),
        }
    }

    /// d|d|/dt in the plane; the rate of x_b - x_a on a line.
    fn line_rate(&mut self, ends: [TNode; 2]) -> Expr {
        let across = self.kinematics.spanned(&mut self.system, ends);
        if self.system.mechanism.dimension == Dimension::One {
            return self.of_motion(&across, Axis::X, Order::Velocity);
        }
        let length = self.length(&across.position);
        if length.is_zero() {
            return length;
        }
        let product = self.component(&across.velocity, &across.position);
        self.system.arena.divide(product, length)
    }

    /// d|d|/dt, or |v| where the ends are together: so fast they part.
    fn rate_from_together(&mut self, id: ElementId, guided: bool) -> Expr {
        let Some(ends) = self.ends(id) else { return Expr::ZERO };
        let (length, rate) = (self.line(ends), self.line_rate(ends));
        let across = self.kinematics.spanned(&mut self.system, ends);
        let [x, y] = [Vector::x(), Vector::y()].map(|axis| self.component(&across.velocity, &axis));
        let product = self.component(&across.velocity, &across.position);
        let arena = &mut self.system.arena;
        let [xx, yy] = [x, y].map(|component| arena.square(component));
        let square = arena.add(xx, yy);
        let speed = arena.unary(Unary::Sqrt, square);
        if guided {
            // Beside the guide there is nothing but rounding.
            let (is_closing, closing) = (arena.binary(Binary::Less, product, Expr::ZERO), arena.negate(speed));
            return arena.select(is_closing, closing, speed);
        }
        let least = arena.constant(LEAST_LENGTH);
        let is_apart = arena.binary(Binary::Less, least, length);
        arena.select(is_apart, rate, speed)
    }

    /// Force with the sign of the scene: positive in compression in the plane; on a line a spring's in tension and an actuator's in compression.
    fn line_law(&mut self, load: LoadId, id: ElementId) -> Expr {
        if self.system.mechanism.dimension == Dimension::One {
            let along = self.load_force(id, &Vector::x());
            let pulls = self.system.mechanism.loads[load.0].component().pulls;
            return if pulls { self.system.arena.negate(along) } else { along };
        }
        let through = self.system.element(id).translation.as_ref().map(|row| row.through.clone());
        let Some(Force::Line(law) | Force::Tangent(law, _)) = through else { return Expr::ZERO };
        self.law(id, Constrained::Length, &law)
    }

    fn of_system(&mut self, quantity: Quantity) -> Expr {
        let Aspect::Whole(whole) = quantity.aspect() else { return Expr::ZERO };
        match whole {
            Whole::KineticEnergy => self.kinetic_energy(),
            Whole::PotentialEnergy => self.potential_energy(),
            Whole::TotalEnergy => {
                let (kinetic, potential) = (self.kinetic_energy(), self.potential_energy());
                self.system.arena.add(kinetic, potential)
            }
            Whole::PositionResidual => {
                let rows: Vec<Expr> = self.constraints.iter().map(|row| row.value).collect();
                self.largest(&rows)
            }
            Whole::VelocityResidual => {
                let rows: Vec<Expr> = (0..self.constraints.len()).map(|index| self.constraint_rate(index)).collect();
                self.largest(&rows)
            }
        }
    }

    /// 1/2 sum (m v^2 + I omega^2), with the armatures of joints.
    fn kinetic_energy(&mut self) -> Expr {
        let half = self.system.arena.constant(0.5);
        let mut total = Expr::ZERO;
        for index in 0..self.system.mechanism.bodies.len() {
            let body = BodyId(index);
            let [vx, vy, omega] = [Quantity::Vx, Quantity::Vy, Quantity::Omega]
                .map(|quantity| self.variable(Variable { owner: Owner::Place(Place::Centre(body)), quantity }));
            let (mass, inertia) = (mass(&mut self.system, body), inertia(&mut self.system, body));
            let arena = &mut self.system.arena;
            let [vx, vy, omega] = [vx, vy, omega].map(|rate| arena.square(rate));
            let speed = arena.add(vx, vy);
            let (moving, turning) = (arena.multiply(mass, speed), arena.multiply(inertia, omega));
            total = arena.sum([total, moving, turning]);
        }
        for (armature, rate) in self.armature_rates() {
            let arena = &mut self.system.arena;
            let square = arena.square(rate);
            total = arena.add_product(total, armature, square);
        }
        self.system.arena.multiply(half, total)
    }

    /// The armature of each joint that has one, with the rate that it moves at.
    fn armature_rates(&mut self) -> Vec<(Expr, Expr)> {
        let mut rates = Vec::new();
        for element in self.system.elements.clone() {
            if let Some(row) = element.rotation.filter(|row| row.armature != Expr::ZERO) {
                let arena = &mut self.system.arena;
                rates.push((row.armature, self.kinematics.angle_across(arena, row.ends).velocity.total(arena)));
            }
            if let Some(row) = element.translation.filter(|row| row.armature != Expr::ZERO)
                && let Some(&(direction, _)) = row.motion.first()
            {
                rates.push((row.armature, self.kinematics.speed_along(&mut self.system, row.ends, direction)));
            }
        }
        rates
    }

    /// Gravity (zero at the origin), and the energy stored in components.
    fn potential_energy(&mut self) -> Expr {
        let mechanism = &*self.system.mechanism.clone();
        let gravity = mechanism.gravity.each_ref().map(|component| self.system.value(component));
        let mut total = Expr::ZERO;
        for index in 0..mechanism.bodies.len() {
            let body = BodyId(index);
            for (quantity, component) in [Quantity::X, Quantity::Y].into_iter().zip(gravity) {
                if component.is_zero() || mechanism.bodies[index].weightless {
                    continue;
                }
                let position = self.variable(Variable { owner: Owner::Place(Place::Centre(body)), quantity });
                let mass = mass(&mut self.system, body);
                let arena = &mut self.system.arena;
                let weight = arena.multiply(mass, component);
                total = arena.subtract_product(total, weight, position);
            }
        }
        for energy in mechanism.parts().filter_map(|part| part.energy()) {
            let energy = self.formula(&energy);
            total = self.system.arena.add(total, energy);
        }
        total
    }

    fn largest(&mut self, rows: &[Expr]) -> Expr {
        let arena = &mut self.system.arena;
        rows.iter().fold(Expr::ZERO, |largest, &row| {
            let size = arena.unary(Unary::Abs, row);
            if largest.is_zero() { size } else { arena.binary(Binary::Max, largest, size) }
        })
    }

    fn dot(&mut self, vector: &Vector, direction: &Vector) -> Expr {
        let arena = &mut self.system.arena;
        vector.dot(arena, direction).total(arena, &self.kinematics.frames)
    }

    pub(super) fn component(&mut self, form: &LinearForm<Vector>, direction: &Vector) -> Expr {
        self.kinematics.component(&mut self.system, form, direction)
    }

    pub(super) fn force_along(&mut self, id: ElementId, direction: Direction) -> Expr {
        let (_, along) = self.kinematics.direction(&mut self.system, direction);
        match self.loads().force(id).cloned() {
            Some(force) => self.component(&force, &along),
            None => Expr::ZERO,
        }
    }

    pub(super) fn torque_of(&mut self, id: ElementId) -> Expr {
        let Some(torque) = self.loads().torque(id).cloned() else { return Expr::ZERO };
        let arena = &mut self.system.arena;
        let frames = &self.kinematics.frames;
        torque.map(arena, |arena, scalar| scalar.total(arena, frames)).total(arena)
    }
}

impl Kinematics {
    /// The component of a linear form along a direction, as one expression.
    pub(super) fn component(&self, system: &mut System, form: &LinearForm<Vector>, direction: &Vector) -> Expr {
        let arena = &mut system.arena;
        let projected = form.map(arena, |arena, vector| vector.dot(arena, direction));
        projected.map(arena, |arena, scalar| scalar.total(arena, &self.frames)).total(arena)
    }

    pub(super) fn speed_along(&self, system: &mut System, ends: [TNode; 2], direction: Direction) -> Expr {
        let across = self.across(&mut system.arena, ends);
        let (_, along) = self.direction(system, direction);
        self.component(system, &across.velocity, &along)
    }
}

/// The length by which a gap in an angle is a way; 1 of what is a way itself.
fn gap_lever(system: &mut System, owner: Owner) -> Expr {
    let mechanism = system.mechanism.clone();
    let Owner::Joint(joint) = owner else { return Expr::ONE };
    let part = &mechanism.joints[joint.0];
    (part.component().gap_lever)(part, system)
}
