//! Natural vibrations.

use cotree::cells;
use cotree::mechanism::Units;
use serde_json::{Value, json};

use super::{Report, Table, at, csv, exact, number, page};
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
    fn table(&self) -> Table {
        let mut rows = vec![cells!["mode", "frequency [Hz]", "damping ratio", "eigenvalue [1/s]", ""]];
        for (index, mode) in self.modes.iter().enumerate() {
            let (value, size) = (mode.eigenvalue, mode.eigenvalue.norm());
            let real = number(value.re, 1e3 * size);
            let eigenvalue = if value.im > 0.0 { format!("{real} +- {}i", number(value.im, size)) } else { real };
            let frequency = if value.im > 0.0 { number(mode.frequency(), 0.0) } else { "-".to_owned() };
            rows.push(cells![index + 1, frequency, ratio(mode), eigenvalue, kind(mode)]);
        }
        ("", rows)
    }

    fn shapes(&self, units: &Units) -> Table {
        let mut rows = vec![cells![if *units == Units::default() { "shape" } else { "shape (SI)" }]];
        rows[0].extend((1..=self.modes.len()).map(|mode| format!("mode {mode}")));
        for (row, coordinate) in self.coordinates.iter().enumerate() {
            let parts = self.modes.iter().map(|mode| part(mode.shape[row]));
            rows.push(std::iter::once(coordinate.clone()).chain(parts).collect());
        }
        ("", rows)
    }
}

pub(super) fn ratio(mode: &Mode) -> String {
    mode.damping_ratio().map_or_else(|| "-".to_owned(), |ratio| number(ratio, 1e3))
}

/// Amplitude with its sign if all move in step, otherwise amplitude and phase.
fn part(value: nalgebra::Complex<f64>) -> String {
    match value.im.abs() > STILL * value.re.abs().max(STILL) && value.norm() > STILL {
        true => format!("{} /_ {:.1} deg", number(value.norm(), 1.0), value.arg().to_degrees()),
        false => number(value.re, STILL / 1e-13),
    }
}

fn kind(mode: &Mode) -> &'static str {
    match (mode.is_free(), mode.damping_ratio()) {
        (true, _) => "free motion",
        (false, Some(ratio)) if ratio < -1e-9 => "grows",
        (false, _) => "",
    }
}

impl Report for Vibration {
    fn text(&self, units: &Units) -> String {
        let about =
            if self.resting { "about its equilibrium" } else { "about its motion, as if the point stood still" };
        let title = format!("{}: vibration {about}, {}", self.name, at(self.time, units));
        match self.modes.is_empty() {
            true => page(&title, [], "\nThe drivers determine the motion: nothing can vibrate.\n"),
            false => page(&title, [self.table(), self.shapes(units)], ""),
        }
    }

    fn json(&self) -> Value {
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

    fn csv(&self, _: &Units) -> String {
        let lines = self.modes.iter().enumerate().flat_map(|(index, mode)| {
            let ratio = mode.damping_ratio().map_or_else(String::new, exact);
            let value = mode.eigenvalue;
            let numbers = [value.re, value.im, mode.frequency(), mode.natural_frequency()].map(exact);
            let head = [cells![index + 1], numbers.to_vec(), vec![ratio]].concat();
            let parts = self.coordinates.iter().zip(&mode.shape);
            parts.map(move |(name, part)| [head.clone(), cells![name, exact(part.re), exact(part.im)]].concat())
        });
        csv(
            "mode,real,imaginary,frequency,natural_frequency,damping_ratio,coordinate,shape_real,shape_imaginary",
            lines,
        )
    }
}
