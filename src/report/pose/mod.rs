//! The drawing of a mechanism at its start.

mod coupling;

use std::collections::HashMap;

use cotree_fmu::model::State;

use super::drawing::{Body, Drawing, Force, Joint, JointKind, Spring, Target, Turn};
use super::line;
use crate::equations::Equations;
use crate::expr::{Expr, Order, Symbol};
use crate::formulate::Formulated;
use crate::mechanism::{
    self, BodyId, Dimension, DriverKind, Formula, LoadKind, Mechanism, Owner, Place, Quantity, Variable,
};

/// Draws the initial pose.
pub fn draw(formulated: &mut Formulated) -> Drawing {
    let mechanism = formulated.equations.system.mechanism;
    let mut pose = Pose::new(formulated);
    let ground = fixed_points(mechanism).into_iter().map(|place| pose.at(place)).collect();
    let mut drawing = Drawing {
        title: mechanism.name.clone(),
        bodies: (0..mechanism.bodies.len()).map(|index| pose.body(BodyId(index))).collect(),
        ground,
        joints: mechanism.joints.iter().filter_map(|joint| pose.joint(joint)).collect(),
        couplings: pose.couplings(),
        springs: pose.springs(),
        forces: pose.forces(),
        turns: pose.turns(),
        targets: pose.targets(),
    };
    drawing.forces.extend(pushes(mechanism, &drawing.joints));
    if mechanism.dimension == Dimension::One {
        let pushed = drawing.targets.drain(..).map(|target| Force {
            name: target.name,
            on: target.on,
            at: target.at,
            direction: target.direction.unwrap_or([1.0, 0.0]),
        });
        drawing.forces.extend(pushed);
        line::lay_out(&mut drawing);
    }
    drawing
}

/// Drivers of prismatic joints, as arrows along the joint.
fn pushes(mechanism: &Mechanism, joints: &[Joint]) -> Vec<Force> {
    let drivers = mechanism.drivers.iter().filter_map(|driver| match driver.kind {
        DriverKind::Displacement { joint, .. } => {
            let name = &mechanism.joints[joint.0].name;
            joints.iter().find(|joint| joint.name == *name).map(|joint| (driver, joint))
        }
        DriverKind::Angle { .. } | DriverKind::Position { .. } => None,
    });
    let arrows = drivers.filter_map(|(driver, joint)| match joint.kind {
        JointKind::Prismatic(direction) | JointKind::Slot(direction) => {
            Some(Force { name: driver.name.clone(), on: joint.between[1], at: joint.at[1], direction })
        }
        JointKind::Revolute | JointKind::Weld => None,
    });
    arrows.collect()
}

/// Where a point is at the start.
pub fn position(formulated: &mut Formulated, place: Place) -> [f64; 2] {
    Pose::new(formulated).at(place)
}

/// Where joints and springs meet the ground.
fn fixed_points(mechanism: &Mechanism) -> Vec<Place> {
    let joints = mechanism.joints.iter().flat_map(|joint| joint.between);
    let springs = mechanism.loads.iter().flat_map(|load| match load.kind {
        LoadKind::Spring { between, .. } | LoadKind::Actuator { between, .. } => between.to_vec(),
        _ => Vec::new(),
    });
    let mut places: Vec<Place> = joints.chain(springs).filter(|place| place.body().is_none()).collect();
    places.sort_unstable();
    places.dedup();
    places
}

struct Pose<'a, 'm> {
    equations: &'a mut Equations<'m>,
    state: &'a State,
    /// Values of expressions: the places of a mechanism share most of theirs.
    known: HashMap<Expr, f64>,
}

/// Values of symbols at a state, if the inputs were changed like this.
fn values_at(state: &State, changed: impl Fn(f64) -> f64) -> impl Fn(Symbol) -> f64 {
    move |symbol| match symbol {
        Symbol::Time => state.time(),
        Symbol::Parameter(i) => state.parameters()[i],
        Symbol::Input(i, Order::Position) => changed(state.inputs()[i]),
        Symbol::Coordinate(i, Order::Position) => state.positions()[i],
        Symbol::Follower(i, Order::Position) => state.follower_positions()[i],
        _ => 0.0,
    }
}

impl<'a, 'm> Pose<'a, 'm> {
    fn new(formulated: &'a mut Formulated<'m>) -> Self {
        Pose { equations: &mut formulated.equations, state: &formulated.state, known: HashMap::new() }
    }

    fn values(&mut self, exprs: &[Expr]) -> Vec<f64> {
        self.equations.system.arena.evaluate_more(exprs, &values_at(self.state, |input| input), &mut self.known)
    }

    fn at(&mut self, place: Place) -> [f64; 2] {
        let of = |quantity| Variable { owner: Owner::Place(place), quantity };
        let exprs = [Quantity::X, Quantity::Y].map(|quantity| self.equations.variable(of(quantity)));
        let values = self.values(&exprs);
        [values[0], values[1]]
    }

    fn angle(&mut self, body: Option<BodyId>) -> f64 {
        let Some(body) = body else { return 0.0 };
        let angle = Variable { owner: Owner::Place(Place::Centre(body)), quantity: Quantity::Angle };
        let expr = self.equations.variable(angle);
        self.values(&[expr])[0]
    }

    fn body(&mut self, id: BodyId) -> Body {
        let body = &self.equations.system.mechanism.bodies[id.0];
        Body {
            name: body.name.clone(),
            points: (0..body.points.len()).map(|point| self.at(Place::Point(id, point))).collect(),
            centre: self.at(Place::Centre(id)),
        }
    }

    /// What holds points together; what only couples them is drawn as a coupling.
    fn joint(&mut self, joint: &mechanism::Joint) -> Option<Joint> {
        let kind = match &joint.kind {
            mechanism::JointKind::Revolute { .. } => JointKind::Revolute,
            mechanism::JointKind::Weld { .. } => JointKind::Weld,
            mechanism::JointKind::Prismatic { axis, .. } => {
                JointKind::Prismatic(self.direction(axis, joint.between[0].body()))
            }
            mechanism::JointKind::Slot { axis, .. } => JointKind::Slot(self.direction(axis, joint.between[0].body())),
            mechanism::JointKind::Rolling { .. }
            | mechanism::JointKind::Distance { .. }
            | mechanism::JointKind::Gear { .. }
            | mechanism::JointKind::Rack { .. } => return None,
        };
        Some(Joint {
            name: joint.name.clone(),
            kind,
            between: joint.between.map(|place| place.body().map(|body| body.0)),
            at: joint.between.map(|place| self.at(place)),
        })
    }

    /// A direction that is fixed in a body, in the world.
    fn direction(&mut self, axis: &[Formula; 2], body: Option<BodyId>) -> [f64; 2] {
        let axis = axis.each_ref().map(|component| self.equations.formula(component));
        let axis = self.values(&axis);
        let (sine, cosine) = self.angle(body).sin_cos();
        [cosine * axis[0] - sine * axis[1], sine * axis[0] + cosine * axis[1]]
    }

    fn springs(&mut self) -> Vec<Spring> {
        let loads = &self.equations.system.mechanism.loads;
        let lines = loads.iter().filter_map(|load| match load.kind {
            LoadKind::Spring { between, .. } | LoadKind::Actuator { between, .. } => Some((load.name.clone(), between)),
            _ => None,
        });
        let body = |place: Place| place.body().map(|body| body.0);
        lines
            .map(|(name, between)| Spring {
                name,
                between: between.map(body),
                ends: between.map(|place| self.at(place)),
            })
            .collect()
    }

    /// A force that is zero at the start is drawn as if its inputs were positive; if that does not help, along the
    /// components that can have another value.
    fn forces(&mut self) -> Vec<Force> {
        let mut forces = Vec::new();
        for load in &self.equations.system.mechanism.loads {
            let LoadKind::Force { on, vector, in_body } = &load.kind else { continue };
            let exprs = vector.each_ref().map(|component| self.equations.formula(component));
            let pushed = values_at(self.state, |input| if input == 0.0 { 1.0 } else { input });
            let values = self.equations.system.arena.evaluate(&exprs, &pushed);
            let mut direction = [values[0], values[1]];
            if direction == [0.0; 2] {
                direction = exprs.map(|expr| f64::from(u8::from(expr != Expr::ZERO)));
            }
            if *in_body {
                let (sine, cosine) = self.angle(on.body()).sin_cos();
                let [x, y] = direction;
                direction = [cosine * x - sine * y, sine * x + cosine * y];
            }
            forces.push(Force {
                name: load.name.clone(),
                on: on.body().map(|body| body.0),
                at: self.at(*on),
                direction,
            });
        }
        forces
    }

    /// Points whose position is prescribed, with the direction in which they leave.
    fn targets(&mut self) -> Vec<Target> {
        let mut targets = Vec::new();
        for driver in &self.equations.system.mechanism.drivers {
            let DriverKind::Position { on, position } = &driver.kind else { continue };
            let exprs = position.each_ref().map(|component| self.equations.formula(component));
            let (on_body, at) = (on.body().map(|body| body.0), self.at(*on));
            targets.push(Target { name: driver.name.clone(), on: on_body, at, direction: self.leaving(exprs) });
        }
        targets
    }

    /// Along the velocity at the start; if the point rests there, along its acceleration; if it does not accelerate either, along the
    /// components that can change at all.
    fn leaving(&mut self, position: [Expr; 2]) -> Option<[f64; 2]> {
        let arena = &mut self.equations.system.arena;
        let rate = position.map(|component| arena.time_derivative(component));
        let acceleration = rate.map(|component| arena.time_derivative(component));
        let values = [rate, acceleration].map(|pair| {
            let values = self.values(&pair);
            [values[0], values[1]]
        });
        let may_change = rate.map(|component| f64::from(u8::from(component != Expr::ZERO)));
        values.into_iter().chain([may_change]).find(|direction| direction.iter().any(|x| x.abs() > 1e-12))
    }

    /// Torques, torsion springs and motors, at a joint between the bodies or at the second body.
    fn turns(&mut self) -> Vec<Turn> {
        let mechanism = self.equations.system.mechanism;
        let loads = mechanism.loads.iter().filter_map(|load| match load.kind {
            LoadKind::Torque { between, .. }
            | LoadKind::TorsionSpring { between, .. }
            | LoadKind::TorsionActuator { between, .. } => Some((&load.name, between)),
            _ => None,
        });
        let drivers = mechanism.drivers.iter().filter_map(|driver| match driver.kind {
            DriverKind::Angle { between, .. } => Some((&driver.name, between)),
            DriverKind::Displacement { .. } | DriverKind::Position { .. } => None,
        });
        let turning: Vec<(&String, [Option<BodyId>; 2])> = loads.chain(drivers).collect();
        turning
            .into_iter()
            .map(|(name, between)| {
                let joint = mechanism.joints.iter().find(|joint| {
                    let bodies = joint.between.map(Place::body);
                    bodies == between || bodies == [between[1], between[0]]
                });
                let place =
                    joint.map_or_else(|| between[1].map_or(Place::Origin, Place::Centre), |joint| joint.between[1]);
                Turn { name: name.clone(), at: self.at(place) }
            })
            .collect()
    }
}
