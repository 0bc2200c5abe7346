//! The naming table: variables that the user can name, and their names.

use super::measure::*;
use super::{BodyId, DriverId, JointId, LoadId, Mechanism, Place};

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
    KineticEnergy,
    PotentialEnergy,
    TotalEnergy,
    PositionResidual,
    VelocityResidual,
}

use Quantity::*;

/// What kind of thing a variable is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    Position,
    Velocity,
    Acceleration,
    Effort,
    System,
}

impl Quantity {
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
        !matches!(self, Y | Vy | Ay | Fy | Angle | Omega | Alpha | Torque | PressureAngle | Curvature)
    }
}

impl Mechanism {
    /// The user's name of a variable, such as `crank.angle`.
    pub fn variable_name(&self, variable: Variable) -> String {
        let owner = match variable.owner {
            Owner::Place(place) => self.place_name(place),
            Owner::Joint(joint) => self.joints[joint.0].name.clone(),
            Owner::Driver(driver) => self.drivers[driver.0].name.clone(),
            Owner::Load(load) => self.loads[load.0].name.clone(),
            Owner::System => match variable.quantity {
                PositionResidual | VelocityResidual => "constraint".to_string(),
                _ => "energy".to_string(),
            },
        };
        variable.quantity.of(&owner)
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
