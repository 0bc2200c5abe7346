//! The naming table: variables that the user can name, and their names.

use super::measure::*;
use crate::expr::Order;

use super::{BodyId, DriverId, Formula, JointId, LoadId, Mechanism, Output, Place};

/// A variable of the naming table, such as `crank.angle`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Variable {
    pub owner: Owner,
    pub quantity: Quantity,
}

/// Who owns a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Owner {
    /// A point of a body or of the ground; `Place::Centre` is the body itself.
    Place(Place),
    Joint(JointId),
    Driver(DriverId),
    Load(LoadId),
    /// `energy.*`, `constraint.*`.
    System,
}

impl Owner {
    /// True for a load.
    pub fn is_load(self) -> bool {
        match self {
            Owner::Load(_) => true,
            Owner::Place(_) | Owner::Joint(_) | Owner::Driver(_) | Owner::System => false,
        }
    }

    /// A motion of this owner with its rate and its acceleration.
    pub fn motion(self, quantities: [Quantity; 3]) -> [Variable; 3] {
        quantities.map(|quantity| Variable { owner: self, quantity })
    }
}

/// What is said of the owner: the last word of a variable's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    X,
    Y,
    Angle,
    Vx,
    Vy,
    Omega,
    Ax,
    Ay,
    Alpha,
    S,
    V,
    A,
    Fx,
    Fy,
    Fn,
    Ft,
    Force,
    Torque,
    Power,
    Length,
    Rate,
    Acceleration,
    PressureAngle,
    Curvature,
    Current,
    CapPressure,
    RodPressure,
    Gap,
    StopForce,
    StopTorque,
    Impulse,
    AngularImpulse,
    Mode,
    Sliding,
    KineticEnergy,
    PotentialEnergy,
    TotalEnergy,
    PositionResidual,
    VelocityResidual,
    Engaged,
    LostEnergy,
    ImpulseX,
    ImpulseY,
    ImpulseTorque,
}

use Quantity::*;

/// What kind of thing a variable is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    Position,
    Velocity,
    Acceleration,
    Effort,
    State,
    /// What impacts leave, and whether something is closed.
    Contact,
    System,
}

/// An axis of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    X,
    Y,
}

/// What a quantity is of its owner: a motion with its order in time, a property of a contact, an effort, a state, or a property of the whole mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aspect {
    /// The motion of a point along an axis.
    Along(Axis, Order),
    Angle(Order),
    /// The displacement along a slide.
    Slide(Order),
    /// The distance of two points.
    Length(Order),
    PressureAngle,
    Curvature,
    Effort(Effort),
    /// A state that the owner brings.
    State,
    /// Of what the owner holds on one side only.
    Contact(ContactQuantity),
    Whole(Whole),
}

/// Forces, torques and their power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    X,
    Y,
    Normal,
    Tangential,
    Force,
    Torque,
    Power,
}

/// What is said of what an owner holds on one side only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactQuantity {
    /// How far it is open.
    Gap,
    /// The force or torque with which it presses, with the sign of the motion that it stops.
    Reaction,
    /// That of the last impact, likewise.
    Impulse,
    /// 0 while it is open, 1 at the upper limit or in contact, -1 at the lower limit; of what only rubs, as `Sliding`.
    Mode,
    /// 1 or -1 while it slides that way, 0 while it sticks, or does not touch.
    Sliding,
    /// 1 while it is engaged, else 0.
    Engaged,
    /// The energy that the impulses of its last engagement took.
    LostEnergy,
}

/// Properties of the whole mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whole {
    KineticEnergy,
    PotentialEnergy,
    TotalEnergy,
    PositionResidual,
    VelocityResidual,
}

impl Quantity {
    /// Motions, each with its rate and its acceleration.
    pub const TURN: [Quantity; 3] = [Angle, Omega, Alpha];
    pub const SLIDE: [Quantity; 3] = [S, V, A];
    pub const ALONG_X: [Quantity; 3] = [X, Vx, Ax];
    pub const ALONG_Y: [Quantity; 3] = [Y, Vy, Ay];
    pub const STRETCH: [Quantity; 3] = [Length, Rate, Acceleration];
    pub const MOTIONS: [[Quantity; 3]; 5] = [Self::TURN, Self::SLIDE, Self::ALONG_X, Self::ALONG_Y, Self::STRETCH];

    /// What it is of its owner.
    pub fn aspect(self) -> Aspect {
        match self {
            X => Aspect::Along(Axis::X, Order::Position),
            Y => Aspect::Along(Axis::Y, Order::Position),
            Angle => Aspect::Angle(Order::Position),
            Vx => Aspect::Along(Axis::X, Order::Velocity),
            Vy => Aspect::Along(Axis::Y, Order::Velocity),
            Omega => Aspect::Angle(Order::Velocity),
            Ax => Aspect::Along(Axis::X, Order::Acceleration),
            Ay => Aspect::Along(Axis::Y, Order::Acceleration),
            Alpha => Aspect::Angle(Order::Acceleration),
            S => Aspect::Slide(Order::Position),
            V => Aspect::Slide(Order::Velocity),
            A => Aspect::Slide(Order::Acceleration),
            Length => Aspect::Length(Order::Position),
            Rate => Aspect::Length(Order::Velocity),
            Acceleration => Aspect::Length(Order::Acceleration),
            PressureAngle => Aspect::PressureAngle,
            Curvature => Aspect::Curvature,
            Current | CapPressure | RodPressure => Aspect::State,
            Gap => Aspect::Contact(ContactQuantity::Gap),
            StopForce | StopTorque => Aspect::Contact(ContactQuantity::Reaction),
            Impulse | AngularImpulse | ImpulseX | ImpulseY | ImpulseTorque => Aspect::Contact(ContactQuantity::Impulse),
            Engaged => Aspect::Contact(ContactQuantity::Engaged),
            LostEnergy => Aspect::Contact(ContactQuantity::LostEnergy),
            Mode => Aspect::Contact(ContactQuantity::Mode),
            Sliding => Aspect::Contact(ContactQuantity::Sliding),
            Fx => Aspect::Effort(Effort::X),
            Fy => Aspect::Effort(Effort::Y),
            Fn => Aspect::Effort(Effort::Normal),
            Ft => Aspect::Effort(Effort::Tangential),
            Force => Aspect::Effort(Effort::Force),
            Torque => Aspect::Effort(Effort::Torque),
            Power => Aspect::Effort(Effort::Power),
            KineticEnergy => Aspect::Whole(Whole::KineticEnergy),
            PotentialEnergy => Aspect::Whole(Whole::PotentialEnergy),
            TotalEnergy => Aspect::Whole(Whole::TotalEnergy),
            PositionResidual => Aspect::Whole(Whole::PositionResidual),
            VelocityResidual => Aspect::Whole(Whole::VelocityResidual),
        }
    }

    /// The order in time of a motion.
    pub fn order(self) -> Option<Order> {
        match self.aspect() {
            Aspect::Along(_, order) | Aspect::Angle(order) | Aspect::Slide(order) | Aspect::Length(order) => {
                Some(order)
            }
            Aspect::Contact(ContactQuantity::Gap) => Some(Order::Position),
            Aspect::PressureAngle | Aspect::Curvature => None,
            Aspect::Effort(_) | Aspect::State | Aspect::Contact(_) | Aspect::Whole(_) => None,
        }
    }

    /// True for an angle and its derivatives.
    pub fn turns(self) -> bool {
        matches!(self.aspect(), Aspect::Angle(_))
    }

    /// The last word of a variable's name, what it is in words, its unit and its class.
    const fn row(self) -> (&'static str, &'static str, Wanted, Class) {
        use Class::*;
        match self {
            X => ("x", "x position of", LENGTH, Position),
            Y => ("y", "y position of", LENGTH, Position),
            Angle => ("angle", "angle of", ANGLE, Position),
            Vx => ("vx", "x velocity of", VELOCITY, Velocity),
            Vy => ("vy", "y velocity of", VELOCITY, Velocity),
            Omega => ("omega", "angular velocity of", ANGULAR_VELOCITY, Velocity),
            Ax => ("ax", "x acceleration of", ACCELERATION, Acceleration),
            Ay => ("ay", "y acceleration of", ACCELERATION, Acceleration),
            Alpha => ("alpha", "angular acceleration of", ANGULAR_ACCELERATION, Acceleration),
            S => ("s", "displacement of", LENGTH, Position),
            V => ("v", "velocity of", VELOCITY, Velocity),
            A => ("a", "acceleration of", ACCELERATION, Acceleration),
            Fx => ("fx", "x force of", FORCE, Effort),
            Fy => ("fy", "y force of", FORCE, Effort),
            Fn => ("fn", "normal force of", FORCE, Effort),
            Ft => ("ft", "tangential force of", FORCE, Effort),
            Force => ("force", "force of", FORCE, Effort),
            Torque => ("torque", "torque of", TORQUE, Effort),
            Power => ("power", "power of", POWER, Effort),
            Length => ("length", "length of", LENGTH, Position),
            Rate => ("rate", "rate of length of", VELOCITY, Velocity),
            Quantity::Acceleration => ("acceleration", "acceleration of length of", ACCELERATION, Class::Acceleration),
            PressureAngle => ("pressure_angle", "pressure angle of", ANGLE, Position),
            Curvature => ("curvature", "curvature of the profile of", CURVATURE, Position),
            Current => ("current", "current of", CURRENT, State),
            CapPressure => ("cap_pressure", "pressure behind the piston of", PRESSURE, State),
            RodPressure => ("rod_pressure", "pressure around the rod of", PRESSURE, State),
            Gap => ("gap", "gap of", LENGTH, Position),
            StopForce => ("stop", "force of the hard stop of", FORCE, Effort),
            StopTorque => ("stop", "torque of the hard stop of", TORQUE, Effort),
            Impulse => ("impulse", "impulse of the last impact of", IMPULSE, Contact),
            AngularImpulse => ("impulse", "angular impulse of the last impact of", ANGULAR_IMPULSE, Contact),
            Engaged => ("engaged", "engagement of", NUMBER, Contact),
            LostEnergy => ("lost_energy", "energy lost by the last engagement of", ENERGY, Contact),
            ImpulseX => ("impulse_x", "x impulse of the last engagement of", IMPULSE, Contact),
            ImpulseY => ("impulse_y", "y impulse of the last engagement of", IMPULSE, Contact),
            ImpulseTorque => ("impulse_torque", "angular impulse of the last engagement of", ANGULAR_IMPULSE, Contact),
            Mode => ("mode", "mode of", NUMBER, Contact),
            Sliding => ("sliding", "direction of sliding of", NUMBER, Contact),
            KineticEnergy => ("kinetic", "kinetic energy", ENERGY, System),
            PotentialEnergy => ("potential", "potential energy", ENERGY, System),
            TotalEnergy => ("total", "total energy", ENERGY, System),
            PositionResidual => ("position", "largest residual of the loop equations", LENGTH, System),
            VelocityResidual => ("velocity", "largest residual of the rates of the loop equations", VELOCITY, System),
        }
    }

    /// The last word of a variable's name.
    pub fn word(self) -> &'static str {
        self.row().0
    }

    /// The name of that variable of an owner, such as `crank.angle`.
    pub fn of(self, owner: &str) -> String {
        format!("{owner}.{}", self.word())
    }

    /// What it is, such as "angle of".
    pub fn words(self) -> &'static str {
        self.row().1
    }

    /// Its SI unit.
    pub fn measure(self) -> Wanted {
        self.row().2
    }

    pub fn class(self) -> Class {
        self.row().3
    }

    /// Is there such a thing on a line?
    pub fn is_on_a_line(self) -> bool {
        !matches!(
            self,
            Y | Vy
                | Ay
                | Fy
                | Angle
                | Omega
                | Alpha
                | Torque
                | PressureAngle
                | Curvature
                | StopTorque
                | AngularImpulse
                | ImpulseY
                | ImpulseTorque
        )
    }
}

impl Mechanism {
    /// The user's name of a variable, such as `crank.angle`.
    pub fn variable_name(&self, variable: Variable) -> String {
        variable.quantity.of(&self.owner_name(variable))
    }

    /// The user's name of the owner of a variable.
    pub fn owner_name(&self, variable: Variable) -> String {
        match variable.owner {
            Owner::Place(place) => self.place_name(place),
            Owner::Joint(joint) => self.joints[joint.0].name.clone(),
            Owner::Driver(driver) => self.drivers[driver.0].name.clone(),
            Owner::Load(load) => self.loads[load.0].name.clone(),
            Owner::System => match variable.quantity {
                PositionResidual | VelocityResidual => "constraint".to_string(),
                _ => "energy".to_string(),
            },
        }
    }

    /// The variable that an output is; none for an expression under a name of its own.
    pub fn variable_of(&self, output: &Output) -> Option<Variable> {
        match output.value {
            Formula::Variable(variable) => Some(variable).filter(|_| output.name == self.variable_name(variable)),
            _ => None,
        }
    }

    /// The mass centres of all bodies, each with the points of its body after it.
    pub fn body_places(&self) -> impl Iterator<Item = Place> {
        self.bodies.iter().enumerate().flat_map(|(index, body)| {
            let id = BodyId(index);
            std::iter::once(Place::Centre(id)).chain((0..body.points.len()).map(move |point| Place::Point(id, point)))
        })
    }

    /// The user's name of a point.
    pub fn place_name(&self, place: Place) -> String {
        match place {
            Place::Origin => "ground".to_string(),
            Place::Ground(point) => format!("ground.{}", self.ground[point].name),
            Place::Centre(body) => self.bodies[body.0].name.clone(),
            Place::Point(body, point) => {
                let body = &self.bodies[body.0];
                format!("{}.{}", body.name, body.points[point].name)
            }
        }
    }
}
