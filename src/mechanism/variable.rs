//! The naming table: variables that the user can name, and their names.

use super::{DriverId, JointId, LoadId, Mechanism, Place};

/// A variable of the naming table, such as `crank.angle`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Variable {
    /// Whose.
    pub owner: Owner,
    /// Which.
    pub quantity: Quantity,
}

/// Who owns a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Owner {
    /// A point of a body or of the ground; `Place::Centre` is the body itself.
    Place(Place),
    /// A joint.
    Joint(JointId),
    /// A driver.
    Driver(DriverId),
    /// A load.
    Load(LoadId),
    /// `energy.*`, `constraint.*`.
    System,
}

/// What is said of the owner: the last word of a variable's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the names are those of the naming table")]
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
    KineticEnergy,
    PotentialEnergy,
    TotalEnergy,
    PositionResidual,
    VelocityResidual,
}

impl Quantity {
    /// The last word of a variable's name; the whole name for those of the system.
    pub fn word(self) -> &'static str {
        match self {
            Quantity::X => "x",
            Quantity::Y => "y",
            Quantity::Angle => "angle",
            Quantity::Vx => "vx",
            Quantity::Vy => "vy",
            Quantity::Omega => "omega",
            Quantity::Ax => "ax",
            Quantity::Ay => "ay",
            Quantity::Alpha => "alpha",
            Quantity::S => "s",
            Quantity::V => "v",
            Quantity::A => "a",
            Quantity::Fx => "fx",
            Quantity::Fy => "fy",
            Quantity::Fn => "fn",
            Quantity::Ft => "ft",
            Quantity::Force => "force",
            Quantity::Torque => "torque",
            Quantity::Power => "power",
            Quantity::Length => "length",
            Quantity::Rate => "rate",
            Quantity::KineticEnergy => "energy.kinetic",
            Quantity::PotentialEnergy => "energy.potential",
            Quantity::TotalEnergy => "energy.total",
            Quantity::PositionResidual => "constraint.position",
            Quantity::VelocityResidual => "constraint.velocity",
        }
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
            Owner::System => return variable.quantity.word().to_string(),
        };
        format!("{owner}.{}", variable.quantity.word())
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
