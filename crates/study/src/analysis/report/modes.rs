//! Natural vibrations.

use cotree::output::report::{Cell, Report, Table, named, plain};
use cotree::{line, row};
use serde_json::{Value, json};

use super::{at, exact};
use crate::analysis::Mode;

/// Parts of a shape below this do not show in the table.
const STILL: f64 = 1e-9;

#[derive(Clone, Debug, PartialEq)]
pub struct Vibration {
    pub name: String,
    /// What about \[s\]: the time, and whether the mechanism is at rest.
    pub time: f64,
    /// At rest, or frozen in its motion?
    pub resting: bool,
    pub coordinates: Vec<String>,
    pub modes: Vec<Mode>,
}

impl Vibration {
    pub fn report(&self) -> Report {
        let about =
            if self.resting { "about its equilibrium" } else { "about its motion, as if the point stood still" };
        let none = self.modes.is_empty();
        let still = "\nThe drivers determine the motion: nothing can vibrate.";
        Report {
            tables: if none { Vec::new() } else { vec![self.table(), self.shapes()] },
            notes: none.then(|| still.into()).into_iter().collect(),
            sheet: self.sheet(),
            data: self.data(),
            ..Report::new(vec![line![self.name, ": vibration ", about, ", ", at(self.time)]])
        }
    }

    fn table(&self) -> Table {
        let row = |(index, mode): (usize, &Mode)| {
            let (value, size) = (mode.eigenvalue, mode.eigenvalue.norm());
            let [real, imaginary] =
                [(value.re, 1e-10), (value.im, 1e-13)].map(|(part, noise)| plain(part, noise * size));
            match value.im > 0.0 {
                true => {
                    let pair = line![real, " +- ", imaginary, "i"];
                    row![index + 1, exact(mode.frequency()), ratio(mode), pair, kind(mode)]
                }
                false => row![index + 1, "-", ratio(mode), real, kind(mode)],
            }
        };
        let columns = row!["mode", named("frequency", "Hz"), "damping ratio", named("eigenvalue", "1/s"), ""];
        Table::new(columns, self.modes.iter().enumerate().map(row))
    }

    fn shapes(&self) -> Table {
        let modes: Vec<String> = (1..=self.modes.len()).map(|mode| format!("mode {mode}")).collect();
        Table::matrix("shape (SI)", &self.coordinates, &modes, |row, mode| part(self.modes[mode].shape[row]))
    }

    fn sheet(&self) -> Table {
        let rows = self.modes.iter().enumerate().flat_map(|(index, mode)| {
            let (value, ratio) = (mode.eigenvalue, mode.damping_ratio().unwrap_or(f64::NAN));
            let own = [value.re, value.im, mode.frequency(), mode.natural_frequency(), ratio].map(exact);
            let head = [row![index + 1], own.to_vec()].concat();
            let parts = self.coordinates.iter().zip(&mode.shape);
            parts.map(move |(name, part)| [head.clone(), row![name, exact(part.re), exact(part.im)]].concat())
        });
        let head = row!["mode", "real", "imaginary", "frequency", "natural_frequency", "damping_ratio"];
        Table::new([head, row!["coordinate", "shape_real", "shape_imaginary"]].concat(), rows)
    }

    fn data(&self) -> Value {
        let mode = |mode: &Mode| {
            let parts = self.coordinates.iter().zip(&mode.shape);
            let shape: Value = parts.map(|(name, value)| (name.clone(), vec![value.re, value.im])).collect();
            json!({
                "eigenvalue": [mode.eigenvalue.re, mode.eigenvalue.im],
                "frequency": mode.frequency(),
                "natural_frequency": mode.natural_frequency(),
                "damping_ratio": mode.damping_ratio(),
                "free": mode.is_free(),
                "shape": shape,
            })
        };
        let modes: Value = self.modes.iter().map(mode).collect();
        json!({"name": self.name, "time": self.time, "at_rest": self.resting, "modes": modes})
    }
}

pub(super) fn ratio(mode: &Mode) -> Cell {
    plain(mode.damping_ratio().unwrap_or(f64::NAN), 1e-10)
}

/// Amplitude with its sign if all move in step, otherwise amplitude and phase.
fn part(value: nalgebra::Complex<f64>) -> Cell {
    match value.im.abs() > STILL * value.re.abs().max(STILL) && value.norm() > STILL {
        true => line![plain(value.norm(), 1e-13), format!(" /_ {:.1} deg", value.arg().to_degrees())],
        false => plain(value.re, STILL),
    }
}

fn kind(mode: &Mode) -> &'static str {
    match (mode.is_free(), mode.damping_ratio()) {
        (true, _) => "free motion",
        (false, Some(ratio)) if ratio < -1e-9 => "grows",
        (false, _) => "",
    }
}
