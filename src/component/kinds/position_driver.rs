//! Position driver (R): r = r(t), from the ground to a point.

use crate::component::frame::Placed;
use crate::component::key::{Form, Key};
use crate::component::{Component, Icon, Room};
use crate::model::measure::LENGTH;
use crate::model::{Part, Quantity as Q};
use crate::network::{Known, Rows, System, TranslationalRow, table2};
use crate::scene::{Driver, Vector};

pub(crate) const POSITION_DRIVER: Component = Component {
    about: "moves a point",
    equations: "r = r(t)",
    keys: &[
        Key::one_of("on", Form::Point, "`on = \"BODY.POINT\"` moves this point"),
        Key::required(
            "position",
            Form::Vector(LENGTH),
            "the motion in the world",
            "give two components: `position = [\"0.1*sin(t)\", 0.2]`",
        ),
    ],
    variables: &[Q::Fx, Q::Fy],
    reactions: &[Q::Fx, Q::Fy],
    room: Room::Line,
    ..Component::driver("position", rows, placed, |part| Icon::Target(part.vector("position")))
};

/// The world does not follow a body.
fn placed(placed: &mut Placed<'_>) {
    if placed.frame.on.is_some() {
        return placed.refuse(
            "position",
            "its motion, which is in the world's axes",
            "prescribe the motion of a joint",
        );
    }
    let frame = placed.frame;
    placed.vector("position", |place| frame.place(place));
}

fn rows(part: &Part, system: &mut System) -> Rows {
    let known = Known::Given(part.vector("position").map(|component| system.given(&component)));
    let row = TranslationalRow { priority: table2::POSITION_DRIVER, known, ..TranslationalRow::pin(system, part) };
    Rows { letter: "R", translation: Some(row), ..Rows::default() }
}

impl Driver {
    /// The position of a point in the world.
    pub fn position(on: &str, position: impl Into<Vector>) -> Driver {
        Driver::new().set("on", on).set("position", position.into())
    }
}
