//! The row of what turns a body against another (T): body -> body; T = T(theta, omega, t).

use super::{RotationalRow, Rows, System, Torque, table3};
use crate::mechanism::{Formula, Part};

/// The part's law turns the second body.
pub(super) fn rows(part: &Part, system: &mut System) -> Rows {
    let law = part.law().unwrap_or(Formula::Number(0.0));
    let row =
        RotationalRow { priority: table3::TORQUE, through: Torque::Law(law), ..RotationalRow::free(system, part) };
    Rows { letter: "T", rotation: Some(row), ..Rows::default() }
}
