//! Every variable of the naming table as an expression of time, inputs, coordinates, rates, accelerations and reactions.

use super::form::{Coefficient, Form};
use super::inertias::{inertia, mass};
use super::kinematics::{Kinematics, PointMotion, ScalarMotion};
use super::vector::Vector;
use super::{Constraint, Equations};
use crate::expr::{Binary, Expr, Order, Symbol, Unary};
use crate::model::{BodyId, Dimension, DriverId, JointId, LoadId, Owner, Place, Quantity, Variable};
use crate::network::{
    Angle, Curve, Direction, ElementId, Force, Origin, Port, RNode, RotationalRow, System, TNode, Torque,
    TranslationalRow,
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
        let trivial: Vec<usize> =
            (0..self.constraints.len()).filter(|&row| self.constraints[row].is_trivial()).collect();
        let before = (self.dynamics.take(), self.through.take(), std::mem::take(&mut self.known));
        trivial.iter().for_each(|&row| self.constraints[row].repeats = true);
        let values = variables.iter().map(|&variable| self.variable(variable)).collect();
        trivial.iter().for_each(|&row| self.constraints[row].repeats = false);
        (self.dynamics, self.through, self.known) = before;
        values
    }

    pub(crate) fn redefine(&mut self, variable: Variable, expr: Expr) {
        self.known.insert(variable, expr);
    }

    fn of_place(&mut self, place: Place, quantity: Quantity) -> Expr {
        match quantity {
            Quantity::Angle | Quantity::Omega | Quantity::Alpha => {
                let node = self.system.r_node(place.body());
                let angle = self.kinematics.angle(node).clone();
                self.of_angle(&angle, quantity)
            }
            _ if let Some(total) = self.total_of(place, quantity) => total,
            Quantity::X | Quantity::Y => {
                let position = self.kinematics.position(&mut self.system, place);
                self.of_motion(&PointMotion { position, ..PointMotion::default() }, quantity)
            }
            _ => {
                let motion = self.kinematics.place(&mut self.system, place);
                self.of_motion(&motion, quantity)
            }
        }
    }

    /// A component of the motion of a place at the end of a deep path.
    fn total_of(&mut self, place: Place, quantity: Quantity) -> Option<Expr> {
        let (order, axis) = component(quantity)?;
        Some(self.kinematics.total_of_place(&mut self.system, place, order)?[axis])
    }

    fn of_motion(&mut self, motion: &PointMotion, quantity: Quantity) -> Expr {
        let Some((order, axis)) = component(quantity) else { return Expr::ZERO };
        let axis = if axis == 0 { Vector::x() } else { Vector::y() };
        match order {
            Order::Position => self.dot(&motion.position, &axis),
            Order::Velocity => self.component(&motion.velocity, &axis),
            Order::Acceleration => self.component(&motion.acceleration, &axis),
        }
    }

    fn of_angle(&mut self, angle: &ScalarMotion, quantity: Quantity) -> Expr {
        let arena = &mut self.system.arena;
        match quantity {
            Quantity::Angle => angle.position.total(arena),
            Quantity::Omega => angle.velocity.total(arena),
            Quantity::Alpha => angle.acceleration.total(arena),
            _ => Expr::ZERO,
        }
    }

    fn angle_across(&mut self, id: ElementId, quantity: Quantity) -> Expr {
        let Some(ends) = self.system.element(id).rotation.as_ref().map(|row| row.ends) else { return Expr::ZERO };
        let angle = self.kinematics.angle_across(&mut self.system.arena, ends);
        self.of_angle(&angle, quantity)
    }

    fn of_joint(&mut self, joint: JointId, quantity: Quantity) -> Expr {
        let Some(id) = self.system.find(Origin::Joint(joint)) else { return Expr::ZERO };
        if let Some((ends, curve)) = self.system.curve(id) {
            return self.of_curve(id, (ends, curve), quantity);
        }
        match quantity {
            Quantity::Angle | Quantity::Omega | Quantity::Alpha => self.angle_across(id, quantity),
            Quantity::S | Quantity::V | Quantity::A => self.slide(id, quantity),
            Quantity::Fx => self.force_along(id, Direction::X),
            Quantity::Fy => self.force_along(id, Direction::Y),
            Quantity::Fn => self.normal_force(joint, id),
            Quantity::Ft => self.coupling_reaction(id),
            Quantity::Force | Quantity::Torque => self.joint_effort(id, quantity),
            Quantity::Power => self.power(id),
            _ => Expr::ZERO,
        }
    }

    /// What is said of a coupling by a function of an angle: the angle within its turn, the contact, and the loads.
    fn of_curve(&mut self, id: ElementId, (ends, curve): ([RNode; 2], Curve), quantity: Quantity) -> Expr {
        let within = self.system.arena.symbol(Symbol::Argument);
        let of = match quantity {
            Quantity::Angle => within,
            Quantity::PressureAngle => curve.pressure,
            Quantity::Curvature => curve.curvature,
            Quantity::Fn => curve.leverage,
            Quantity::Torque => curve.value[1],
            _ => return Expr::ZERO,
        };
        let arena = &mut self.system.arena;
        let angle = self.kinematics.angle_across(arena, ends).position.total(arena);
        let value = Curve::at(arena, of, angle);
        match quantity {
            Quantity::Fn => {
                let reaction = self.coupling_reaction(id);
                self.system.arena.divide(reaction, value)
            }
            Quantity::Torque => {
                let terms = self.system.element(id).coupling.iter().flat_map(|coupling| &coupling.terms);
                let factor = terms
                    .copied()
                    .find(|term| matches!(term.port, Port::Curve(..)))
                    .map_or(Expr::ZERO, |term| term.factor);
                let reaction = self.coupling_reaction(id);
                let arena = &mut self.system.arena;
                let lever = arena.multiply(factor, value);
                arena.multiply(lever, reaction)
            }
            _ => value,
        }
    }

    /// s = r . u, s' = v . u, s'' = a . u + s omega^2, with r = s u the across variable without its known part.
    fn slide(&mut self, id: ElementId, quantity: Quantity) -> Expr {
        let Some(row) = self.system.element(id).translation.clone() else { return Expr::ZERO };
        let Some(&(direction, _)) = row.motion.first() else { return Expr::ZERO };
        let known = self.kinematics.known(&mut self.system, &row.known);
        let across = self.kinematics.across(&mut self.system.arena, row.ends);
        let across = PointMotion::between(&mut self.system.arena, &known, &across);
        let (frame, axis) = self.kinematics.direction(&mut self.system, direction);
        match quantity {
            Quantity::S => self.dot(&across.position, &axis),
            Quantity::V => self.component(&across.velocity, &axis),
            _ => {
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

    /// The force along a joint's free or coupled direction; its reaction torque, or the torque about its free or coupled axis.
    fn joint_effort(&mut self, id: ElementId, quantity: Quantity) -> Expr {
        let element = self.system.element(id).clone();
        let row = element.rotation.as_ref();
        match (quantity, element.coupling) {
            (Quantity::Force, None) => self.resisting_force(element.translation.as_ref()),
            (Quantity::Force, Some(_)) => self.coupling_reaction(id),
            (_, None) if row.is_some_and(|row| matches!(row.angle, Angle::Constant(_))) => self.torque_of(id),
            (_, None) => self.resisting_torque(row),
            (_, Some(coupling)) => {
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
        match self.constraints.iter().position(of_coupling) {
            Some(index) => self.system.arena.symbol(Symbol::Reaction(index)),
            None => Expr::ZERO,
        }
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
        match quantity {
            Quantity::Torque => self.torque_of(id),
            Quantity::Fx => self.force_along(id, Direction::X),
            Quantity::Fy => self.force_along(id, Direction::Y),
            Quantity::Force => {
                let axis = self.system.element(id).translation.as_ref().and_then(|row| row.reaction.first().copied());
                axis.map_or(Expr::ZERO, |axis| self.force_along(id, axis))
            }
            Quantity::Power => self.power(id),
            _ => Expr::ZERO,
        }
    }

    fn of_load(&mut self, load: LoadId, quantity: Quantity) -> Expr {
        let Some(id) = self.system.find(Origin::Load(load)) else { return Expr::ZERO };
        match quantity {
            Quantity::Angle | Quantity::Omega | Quantity::Alpha => self.angle_across(id, quantity),
            Quantity::Torque => self.laws.torques.get(&id).copied().unwrap_or(Expr::ZERO),
            Quantity::Rate if let Some(centred) = self.centred(id) => {
                self.rate_from_together(id, !centred.damped.is_empty())
            }
            Quantity::Length | Quantity::Rate => self.ends(id).map_or(Expr::ZERO, |ends| self.line(ends, quantity)),
            Quantity::Acceleration => self.spanned(id, Quantity::Ax),
            _ if component(quantity).is_some() => self.spanned(id, quantity),
            Quantity::Fx => self.load_force(id, &Vector::x()),
            Quantity::Fy => self.load_force(id, &Vector::y()),
            Quantity::Force => self.line_law(load, id),
            Quantity::Power => self.power(id),
            _ => Expr::ZERO,
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
    fn spanned(&mut self, id: ElementId, quantity: Quantity) -> Expr {
        let Some(ends) = self.ends(id) else { return Expr::ZERO };
        let across = self.kinematics.across(&mut self.system.arena, ends);
        self.of_motion(&across, quantity)
    }

    /// |d| and d|d|/dt in the plane; x_b - x_a and its rate on a line.
    fn line(&mut self, ends: [TNode; 2], quantity: Quantity) -> Expr {
        let across = self.kinematics.spanned(&mut self.system, ends);
        if self.system.mechanism.dimension == Dimension::One {
            let of = if quantity == Quantity::Length { Quantity::X } else { Quantity::Vx };
            return self.of_motion(&across, of);
        }
        let length = self.length(&across.position);
        if quantity == Quantity::Length || length.is_zero() {
            return length;
        }
        let product = self.component(&across.velocity, &across.position);
        self.system.arena.divide(product, length)
    }

    /// d|d|/dt, or |v| where the ends are together: so fast they part.
    fn rate_from_together(&mut self, id: ElementId, guided: bool) -> Expr {
        let Some(ends) = self.ends(id) else { return Expr::ZERO };
        let [length, rate] = [Quantity::Length, Quantity::Rate].map(|quantity| self.line(ends, quantity));
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
        let Some(Force::Line(law)) = self.system.element(id).translation.as_ref().map(|row| row.through.clone()) else {
            return Expr::ZERO;
        };
        self.formula(&law)
    }

    fn of_system(&mut self, quantity: Quantity) -> Expr {
        match quantity {
            Quantity::KineticEnergy => self.kinetic_energy(),
            Quantity::PotentialEnergy => self.potential_energy(),
            Quantity::TotalEnergy => {
                let (kinetic, potential) = (self.kinetic_energy(), self.potential_energy());
                self.system.arena.add(kinetic, potential)
            }
            Quantity::PositionResidual => {
                let rows: Vec<Expr> = self.constraints.iter().map(|row| row.value).collect();
                self.largest(&rows)
            }
            Quantity::VelocityResidual => {
                let rows: Vec<Expr> = (0..self.constraints.len()).map(|index| self.constraint_rate(index)).collect();
                self.largest(&rows)
            }
            _ => Expr::ZERO,
        }
    }

    /// 1/2 sum (m v^2 + I omega^2)
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
        self.system.arena.multiply(half, total)
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

    pub(super) fn component(&mut self, form: &Form<Vector>, direction: &Vector) -> Expr {
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

/// A component of the motion of a point: its order, and 0 for x or 1 for y.
fn component(quantity: Quantity) -> Option<(Order, usize)> {
    match quantity {
        Quantity::X => Some((Order::Position, 0)),
        Quantity::Y => Some((Order::Position, 1)),
        Quantity::Vx => Some((Order::Velocity, 0)),
        Quantity::Vy => Some((Order::Velocity, 1)),
        Quantity::Ax => Some((Order::Acceleration, 0)),
        Quantity::Ay => Some((Order::Acceleration, 1)),
        _ => None,
    }
}

impl Kinematics {
    /// The component of a linear form along a direction, as one expression.
    pub(super) fn component(&self, system: &mut System, form: &Form<Vector>, direction: &Vector) -> Expr {
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
