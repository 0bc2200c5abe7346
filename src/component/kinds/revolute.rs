//! Revolute joint (h): r = 0, T resists.

use crate::component::frame::Placed;
use crate::component::key::{AT, BETWEEN_POINTS, ENGAGED, Form, Key, Record};
use crate::component::{Component, Icon, Room, Rubs, limits};
use crate::model::measure::{ANGULAR_VELOCITY, INERTIA, TORQUE, TORSION_DAMPING};
use crate::model::{Captured, Part, Pressed, Quantity as Q, Range};
use crate::network::{Resistance, RotationalRow, Rows, System, Torque, TranslationalRow};
use crate::scene::{Joint, Scene};

pub(crate) const REVOLUTE: Component = Component {
    about: "turning about the common point",
    equations: "r = 0, T = -damping omega - friction - armature alpha",
    keys: &[
        BETWEEN_POINTS,
        Key::optional("damping", Form::Constant(TORSION_DAMPING, Range::Any), "viscous friction"),
        Key::optional(
            "friction",
            Form::Record(Record::Friction([TORQUE, ANGULAR_VELOCITY], Pressed::Pin)),
            "dry friction",
        ),
        Key::optional(
            "armature",
            Form::Constant(INERTIA, Range::NotNegative),
            "moment of inertia that turns with the joint's angle only, such as a geared rotor's times the square of its ratio",
        ),
        limits::OF_ANGLE,
        ENGAGED,
        AT,
    ],
    variables: &[
        Q::Angle,
        Q::Omega,
        Q::Alpha,
        Q::Fx,
        Q::Fy,
        Q::Torque,
        Q::StopTorque,
        Q::AngularImpulse,
        Q::Mode,
        Q::Sliding,
    ],
    reactions: &[Q::Fx, Q::Fy],
    captures: &[Captured::Point],
    engaging: &[Q::Engaged, Q::ImpulseX, Q::ImpulseY, Q::LostEnergy],
    pose: &[Q::Angle],
    room: Room::Turning,
    undriven: ["revolute", "give `angle = ...` instead of `displacement`"],
    drivers: &["angle"],
    gaps: limits::gaps,
    relation: limits::angle,
    rubs: Rubs::joint(Pressed::Pin, limits::angle),
    ..Component::joint("revolute", rows, placed, |_| Icon::Pin)
};

/// The limits are those of the second body's angle against the first's.
fn placed(placed: &mut Placed<'_>) {
    placed.limits("limits");
}

fn rows(part: &Part, system: &mut System) -> Rows {
    let resistance = Resistance::of(system, part);
    let armature = system.value(part.formula("armature"));
    let turn = RotationalRow { armature, ..RotationalRow::free(system, part) };
    Rows {
        letter: "h",
        translation: Some(TranslationalRow::pin(system, part)),
        rotation: Some(RotationalRow { through: resistance.map_or(Torque::None, Torque::Resistance), ..turn }),
        ..Rows::default()
    }
}

impl Joint {
    /// Turning about the common point.
    pub fn revolute(first: &str, second: &str) -> Joint {
        Joint::new("revolute", first, second)
    }
}

impl Scene {
    /// Adds a revolute joint between two points.
    #[must_use]
    pub fn revolute(self, name: &str, first: &str, second: &str) -> Scene {
        self.joint(name, Joint::revolute(first, second))
    }
}
