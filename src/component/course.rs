//! What runs over pulleys and onto drums: ropes, and springs, dampers and actuators between their ends.

use super::frame::Placed;
use super::key::{Form, Key};
use crate::model::{Formula, KeyValue, Part};
use crate::network::course::{drums, spans};
use crate::network::{Force, RotationalRow, Rows, System, Torque, TranslationalRow, table3};

pub(super) const ENDS: Key = Key::required(
    "between",
    Form::Ends,
    "the two ends: points, or drums: `{ drum = \"BODY\", radius = \"60 mm\", side = \"right\" }`",
    "give two points: `between = [\"BODY.POINT\", \"BODY.POINT\"]`; the ground is a body, too: `ground.POINT`",
);
pub(super) const OVER: Key =
    Key::optional("over", Form::Course, "the [pulleys](#over) that it runs over, from the first end to the last");

/// A mirror exchanges the sides.
pub(super) fn placed(placed: &mut Placed<'_>) {
    let is_mirror = placed.frame.mirror;
    for (_, value) in &mut placed.part.values {
        if let (KeyValue::Course(course), true) = (value, is_mirror) {
            course.pulleys_mut().for_each(|pulley| pulley.is_left = !pulley.is_left);
        }
    }
}

/// The rows of a load that runs over pulleys: the same force along each straight part, and its torque on each drum.
pub(super) fn rows(part: &Part, system: &mut System) -> Option<Rows> {
    let stations = part.stations()?;
    let law = part.law().unwrap_or(Formula::Number(0.0));
    let spans = spans(part, &stations, system);
    let along = spans.into_iter().map(|(ends, tangent)| {
        let row = TranslationalRow::force(system, part, ends, Force::Tangent(law.clone(), tangent));
        Rows { letter: "F", translation: Some(row), ..Rows::default() }
    });
    let mut all: Vec<Rows> = along.collect();
    for (station, ends, sign) in drums(&stations, system) {
        let lever = Formula::Number(sign) * station.radius.clone();
        let row = RotationalRow {
            ends,
            priority: table3::TORQUE,
            through: Torque::Law(lever * law.clone()),
            ..RotationalRow::free(system, part)
        };
        all.push(Rows { letter: "T", rotation: Some(row), ..Rows::default() });
    }
    let mut rest = all.into_iter();
    let first = rest.next()?;
    Some(Rows { others: rest.collect(), ..first })
}
