//! Bushing (F and T): a ring of rubber between two points, with an edge in both graphs. It pulls the points together, the same in all directions, and turns the
//! second body to a free angle: two springs across each other and a torsion spring.

use std::f64::consts::TAU;

use crate::component::frame::Placed;
use crate::component::key::{BETWEEN_POINTS, Form, Key};
use crate::component::{Component, Icon, IconStroke, Room, torsion};
use crate::model::measure::{ANGLE, DAMPING, STIFFNESS, TORSION_DAMPING, TORSION_STIFFNESS};
use crate::model::{Formula, Part, Quantity as Q, Range};
use crate::network::{Force, Rows, System, TranslationalRow};
use crate::scene::{Load, Quantity};

pub(crate) const BUSHING: Component = Component {
    about: "a rubber ring that holds two points together, and their bodies at an angle",
    equations: "F = -stiffness r - damping r', T = -torsion_stiffness (theta - angle) - torsion_damping theta'",
    keys: &[
        BETWEEN_POINTS,
        Key::required(
            "stiffness",
            Form::Constant(STIFFNESS, Range::Any),
            "the stiffness, the same in all directions",
            "give the stiffness [N/m]: `stiffness = 2e5`",
        ),
        Key::optional("damping", Form::Constant(DAMPING, Range::Any), "the damping coefficient"),
        Key::optional("torsion_stiffness", Form::Constant(TORSION_STIFFNESS, Range::Any), "the torsional stiffness"),
        Key::optional("torsion_damping", Form::Constant(TORSION_DAMPING, Range::Any), "the torsional damping"),
        Key::optional("angle", Form::Constant(ANGLE, Range::Any), "the free angle"),
    ],
    variables: &[Q::X, Q::Y, Q::Vx, Q::Vy, Q::Angle, Q::Omega, Q::Fx, Q::Fy, Q::Torque],
    pose: &[Q::Fx, Q::Fy, Q::Torque],
    room: Room::Turning,
    law: |part| Some(torque(part)),
    energy: |part| Some(energy(part)),
    ..Component::load("bushing", rows, |placed: &mut Placed<'_>| placed.angle("angle"), |_| Icon::Round(rings))
};

fn rows(part: &Part, system: &mut System) -> Rows {
    let ends = part.between.map(|place| system.t_node(place));
    let row = TranslationalRow::force(system, part, ends, Force::World(force(part)));
    Rows { letter: "F", translation: Some(row), ..torsion::rows(part, system) }
}

/// -k r - c r'
fn force(part: &Part) -> [Formula; 2] {
    [[Q::X, Q::Vx], [Q::Y, Q::Vy]].map(|[place, rate]| {
        -(part.key("stiffness") * part.variable(place) + part.key("damping") * part.variable(rate))
    })
}

fn torque(part: &Part) -> Formula {
    let turned = part.variable(Q::Angle) - part.key("angle");
    -(part.key("torsion_stiffness") * turned + part.key("torsion_damping") * part.variable(Q::Omega))
}

fn energy(part: &Part) -> Formula {
    let square = part.variable(Q::X).raised(2.0) + part.variable(Q::Y).raised(2.0);
    let turned = (part.variable(Q::Angle) - part.key("angle")).raised(2.0);
    Formula::Number(0.5) * (part.key("stiffness") * square + part.key("torsion_stiffness") * turned)
}

/// The sleeve, and the rubber within it.
fn rings() -> Vec<IconStroke> {
    [1.6, 2.6].map(|radius| IconStroke::arc([radius; 2], [0.0, TAU])).into()
}

impl Load {
    /// A ring of rubber between two points; see also [`Load::damping`] and [`Load::free`].
    pub fn bushing(first: &str, second: &str, stiffness: impl Into<Quantity>) -> Load {
        Load::new("bushing").set("between", [first, second]).set("stiffness", stiffness.into())
    }

    /// The torsional stiffness of a bushing [N.m/rad].
    #[must_use]
    pub fn torsion_stiffness(self, value: impl Into<Quantity>) -> Load {
        self.set("torsion_stiffness", value.into())
    }

    /// The torsional damping of a bushing [N.m.s].
    #[must_use]
    pub fn torsion_damping(self, value: impl Into<Quantity>) -> Load {
        self.set("torsion_damping", value.into())
    }
}
