//! Natural vibrations.

use cotree::report::data::{Cell, Report, Table, plain};
use cotree::{line, row};
use serde_json::json;

use super::{at, contact_data, contact_tables, exact};
use crate::analysis::{ContactStatus, VibrationMode};

/// Parts of a shape below this do not show in the table.
const STILL: f64 = 1e-9;

#[derive(Clone, Debug, PartialEq)]
pub struct VibrationModes {
    pub name: String,
    /// What about \[s\]: the time, and whether the mechanism is at rest.
    pub time: f64,
    /// At rest, or frozen in its motion?
    pub resting: bool,
    /// Names of the coordinates, then of the states of the scene.
    pub coordinates: Vec<String>,
    /// How many of them are states: their sizes are others.
    pub states: usize,
    /// What is held on one side only, as it is there.
    pub statuses: Vec<ContactStatus>,
    pub modes: Vec<VibrationMode>,
}

impl VibrationModes {
    pub fn report(&self) -> Report {
        let mut table = Table::new(row!["mode", "frequency [Hz]", "damping ratio", "eigenvalue [1/s]", ""], []);
        let keys = row!["mode", "real", "imaginary", "frequency", "natural_frequency", "damping_ratio"];
        let mut sheet = Table::new([keys, row!["coordinate", "shape_real", "shape_imaginary"]].concat(), []);
        let mut modes = Vec::new();
        for (index, mode) in self.modes.iter().enumerate() {
            let (place, value, frequency) = (index + 1, mode.eigenvalue, mode.frequency());
            let told = exact(if value.im > 0.0 { frequency } else { f64::NAN });
            table.rows.push(row![place, told, ratio(mode), eigenvalue(mode), kind(mode)]);
            let numbers = [value.re, value.im, frequency, mode.natural_frequency()].map(exact).to_vec();
            let mut shape = json!({});
            for (name, part) in self.coordinates.iter().zip(&mode.shape) {
                shape[name] = json!([part.re, part.im]);
                let part = row![ratio(mode), name, exact(part.re), exact(part.im)];
                sheet.rows.push([row![place], numbers.clone(), part].concat());
            }
            modes.push(json!({
                "eigenvalue": [value.re, value.im],
                "frequency": frequency,
                "natural_frequency": mode.natural_frequency(),
                "damping_ratio": mode.damping_ratio(),
                "free": mode.is_free(),
                "shape": shape,
            }));
        }
        let held = match self.statuses.iter().any(|status| status.closed) {
            true => "\nDrivers, closed contacts and engaged freewheels leave 0 degrees of freedom: there are no modes.",
            false => "\nThe drivers determine the motion: there are no modes.",
        };
        let still = modes.is_empty().then(|| held.into());
        let about = if self.resting {
            "about its equilibrium"
        } else {
            "about a point of its motion, with frozen coefficients"
        };
        let mut tables = if modes.is_empty() { Vec::new() } else { vec![table, self.shapes()] };
        tables.extend(contact_tables(&self.statuses));
        let mut data = json!({"name": self.name, "time": self.time, "at_rest": self.resting, "modes": modes});
        contact_data(&self.statuses, &mut data);
        Report {
            tables,
            notes: still.into_iter().collect(),
            sheet,
            data,
            ..Report::new(vec![line![self.name, ": vibration ", about, ", ", at(self.time)]])
        }
    }

    fn shapes(&self) -> Table {
        let modes: Vec<String> = (1..=self.modes.len()).map(|mode| format!("mode {mode}")).collect();
        // Where all are coordinates, one is the largest.
        let largest = |row: usize| match self.states {
            0 => 1.0,
            _ => self.modes.iter().map(|mode| mode.shape[row].norm()).fold(0.0, f64::max),
        };
        let value = |row: usize, mode: usize| part(self.modes[mode].shape[row], STILL * largest(row));
        Table::matrix("shape (SI)", &self.coordinates, &modes, value)
    }
}

/// A pair as its real and imaginary part.
fn eigenvalue(mode: &VibrationMode) -> Cell {
    let (value, size) = (mode.eigenvalue, mode.eigenvalue.norm());
    let [real, imaginary] = [(value.re, 1e-10), (value.im, 1e-13)].map(|(part, noise)| plain(part, noise * size));
    if value.im > 0.0 { line![real, " +- ", imaginary, "i"] } else { real }
}

pub(super) fn ratio(mode: &VibrationMode) -> Cell {
    plain(mode.damping_ratio().unwrap_or(f64::NAN), 1e-10)
}

/// Amplitude with its sign if all move in step, otherwise amplitude and phase.
fn part(value: nalgebra::Complex<f64>, still: f64) -> Cell {
    match value.im.abs() > STILL * value.re.abs().max(still) && value.norm() > still {
        true => line![plain(value.norm(), 1e-4 * still), format!(" /_ {:.1} deg", value.arg().to_degrees())],
        false => plain(value.re, still),
    }
}

fn kind(mode: &VibrationMode) -> &'static str {
    match (mode.is_free(), mode.damping_ratio()) {
        (true, _) => "free motion",
        (false, Some(ratio)) if ratio < -1e-9 => "grows",
        (false, _) => "",
    }
}
