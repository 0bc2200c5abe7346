//! The row of what turns a body against another (T): body -> body; T = T(theta, omega, t).

use crate::model::{Formula, Part};
use crate::network::{RotationalRow, Rows, System, Torque, table3};

/// The part's law turns the second body.
pub(super) fn rows(part: &Part, system: &mut System) -> Rows {
    let law = part.law().unwrap_or(Formula::Number(0.0));
    let row =
        RotationalRow { priority: table3::TORQUE, through: Torque::Law(law), ..RotationalRow::free(system, part) };
    Rows { letter: "T", rotation: Some(row), ..Rows::default() }
}
