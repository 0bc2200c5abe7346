//! Weld (w): r = 0 and the angle is held. A revolute joint in the translational graph, a prismatic one in the rotational.

use crate::component::frame::Placed;
use crate::component::key::{ANGLE_BETWEEN, AT, BETWEEN_POINTS, ENGAGED};
use crate::component::{Component, Icon, Room};
use crate::model::{Captured, Dimension, Part, Quantity as Q, relative_angle};
use crate::network::{RotationalRow, Rows, System, TranslationalRow};
use crate::scene::{Joint, Scene};

pub(crate) const WELD: Component = Component {
    about: "no motion",
    equations: "r = 0, theta = angle",
    keys: &[BETWEEN_POINTS, ANGLE_BETWEEN, ENGAGED, AT],
    variables: &[Q::Fx, Q::Fy, Q::Torque],
    reactions: &[Q::Fx, Q::Fy, Q::Torque],
    captures: &[Captured::Point, Captured::Key("angle", relative_angle)],
    engaging: &[Q::Engaged, Q::ImpulseX, Q::ImpulseY, Q::ImpulseTorque, Q::LostEnergy],
    room: Room::Line,
    undriven: ["a weld", "a weld does not move: name a revolute or a prismatic joint"],
    ..Component::joint("weld", rows, placed, |_| Icon::Fixed)
};

fn placed(placed: &mut Placed<'_>) {
    placed.angle("angle");
}

fn rows(part: &Part, system: &mut System) -> Rows {
    let plane = system.mechanism.dimension == Dimension::Two;
    let angle = system.value(part.formula("angle"));
    Rows {
        letter: "w",
        translation: Some(TranslationalRow::pin(system, part)),
        rotation: plane.then(|| RotationalRow::held(system, part, angle)),
        ..Rows::default()
    }
}

impl Joint {
    /// No motion.
    pub fn weld(first: &str, second: &str) -> Joint {
        Joint::new("weld", first, second)
    }
}

impl Scene {
    /// Adds a weld between two points.
    #[must_use]
    pub fn weld(self, name: &str, first: &str, second: &str) -> Scene {
        self.joint(name, Joint::weld(first, second))
    }
}
