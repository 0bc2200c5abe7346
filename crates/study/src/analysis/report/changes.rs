//! Derivatives: of an equilibrium, of vibrations, of peaks and crossings.

use cotree::columns::titled;
use cotree::compile::shown;
use cotree::mechanism::Units;
use serde_json::{Map, Value, json};

use super::{Report, align, number, told};
use crate::analysis::{Changes, Feature, Kind, ModeChanges, Sensitivities};

/// What happens in a motion, and the parameters it is differentiated by, with their units.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// The name of the scene.
    pub name: String,
    /// With respect to what, with its unit.
    pub parameters: Vec<(String, String)>,
    pub features: Vec<Feature>,
}

/// The parameters as they are named and how large the units are that they are shown in.
fn shown_by(parameters: &[(String, String)], units: &Units) -> Vec<(String, f64)> {
    let one = |(name, si): &(String, String)| match shown(units, si) {
        unit if unit.factor == 1.0 => (name.clone(), 1.0),
        unit => (titled(name, &unit.name), unit.factor),
    };
    parameters.iter().map(one).collect()
}

fn by_name<'a>(parameters: &'a [(String, String)], values: impl IntoIterator<Item = f64> + 'a) -> Map<String, Value> {
    parameters.iter().zip(values).map(|((name, _), value)| (name.clone(), json!(value))).collect()
}

/// At one time: an equilibrium.
impl Report for Sensitivities {
    fn text(&self, units: &Units) -> String {
        let parameters = shown_by(&self.parameters, units);
        let per = parameters.iter().map(|(name, _)| format!("d/d({name})"));
        let titles = ["output", "value", "unit"].map(str::to_owned).into_iter().chain(per);
        let mut lines = vec![titles.collect::<Vec<String>>()];
        for (values, derivatives) in self.values.iter().zip(&self.derivatives) {
            for (row, (name, unit)) in self.outputs.iter().enumerate() {
                let unit = shown(units, unit);
                let mut line = vec![name.clone(), number(values[row] / unit.factor, 0.0), unit.name];
                let derivatives = derivatives.row(row);
                let derivatives = derivatives.iter().zip(&parameters).map(|(value, (_, by))| value * by / unit.factor);
                line.extend(derivatives.map(|value| number(value, 0.0)));
                lines.push(line);
            }
        }
        format!("Where it rests{}:\n\n{}", told(units), align(&lines))
    }

    fn json(&self) -> Value {
        let output = |(row, (name, unit)): (usize, &(String, String))| {
            let value = self.values.first().map(|values| values[row]);
            let derivatives = self
                .derivatives
                .iter()
                .take(1)
                .flat_map(|matrix| matrix.row(row).iter().copied().collect::<Vec<f64>>());
            json!({ "name": name, "unit": unit, "value": value, "derivatives": by_name(&self.parameters, derivatives.collect::<Vec<f64>>()) })
        };
        json!({ "time": self.times.first(), "outputs": self.outputs.iter().enumerate().map(output).collect::<Vec<_>>() })
    }

    fn csv(&self, _: &Units) -> String {
        let mut text = String::from("output,value,parameter,derivative\n");
        for (values, derivatives) in self.values.iter().zip(&self.derivatives) {
            for (row, (name, _)) in self.outputs.iter().enumerate() {
                for (column, (parameter, _)) in self.parameters.iter().enumerate() {
                    text.push_str(&format!("{name},{:?},{parameter},{:?}\n", values[row], derivatives[(row, column)]));
                }
            }
        }
        text
    }
}

impl ModeChanges {
    /// Derivatives of eigenvalue (two parts), frequency and damping ratio, if there are any.
    fn parts(&self, mode: usize, parameter: usize) -> Option<[f64; 4]> {
        let by = self.derivatives[mode].as_ref()?[parameter];
        let s = self.modes[mode].eigenvalue;
        let size = s.norm();
        let faster = (s.conj() * by).re / size;
        Some([by.re, by.im, by.im / std::f64::consts::TAU, -by.re / size + s.re * faster / (size * size)])
    }

    fn cells(&self, mode: usize) -> impl Iterator<Item = (&str, Option<[f64; 4]>)> {
        self.parameters.iter().enumerate().map(move |(index, (name, _))| (name.as_str(), self.parts(mode, index)))
    }
}

impl Report for ModeChanges {
    fn text(&self, units: &Units) -> String {
        let parameters = shown_by(&self.parameters, units);
        let titles = ["mode", "frequency [Hz]", "damping ratio", "with respect to", "d(frequency)", "d(damping ratio)"];
        let mut lines = vec![titles.map(str::to_owned).to_vec()];
        for (index, mode) in self.modes.iter().enumerate() {
            let ratio = mode.damping_ratio().map_or_else(|| "-".to_owned(), |ratio| number(ratio, 1e3));
            for ((_, parts), (name, by)) in self.cells(index).zip(&parameters) {
                let [frequency, damping] = match parts {
                    Some([_, _, frequency, damping]) => [frequency, damping].map(|value| number(value * by, 0.0)),
                    None => ["-".to_owned(), "-".to_owned()],
                };
                let own = [(index + 1).to_string(), number(mode.frequency(), 0.0), ratio.clone()];
                lines.push(own.into_iter().chain([name.to_owned(), frequency, damping]).collect());
            }
        }
        let note = "A mode without derivatives moves freely, or its eigenvalue is there twice.\n";
        let note = if self.derivatives.iter().any(Option::is_none) { note } else { "" };
        format!("{}: vibration about its equilibrium{}\n\n{}{note}", self.name, told(units), align(&lines))
    }

    fn json(&self) -> Value {
        let mode = |(index, mode): (usize, &crate::analysis::Mode)| {
            let derivatives: Map<String, Value> = self
                .cells(index)
                .map(|(name, parts)| {
                    let parts = parts.map(|[real, imaginary, frequency, damping]| {
                        json!({ "eigenvalue": [real, imaginary], "frequency": frequency, "damping_ratio": damping })
                    });
                    (name.to_owned(), json!(parts))
                })
                .collect();
            let (value, frequency) = (mode.eigenvalue, mode.frequency());
            json!({ "eigenvalue": [value.re, value.im], "frequency": frequency, "derivatives": derivatives })
        };
        json!({ "name": self.name, "modes": self.modes.iter().enumerate().map(mode).collect::<Vec<_>>() })
    }

    fn csv(&self, _: &Units) -> String {
        let mut text = String::from("mode,frequency,parameter,real,imaginary,d_frequency,d_damping_ratio\n");
        for (index, mode) in self.modes.iter().enumerate() {
            for (name, parts) in self.cells(index) {
                let parts =
                    parts.map_or_else(|| ",,,".to_owned(), |parts| parts.map(|part| format!("{part:?}")).join(","));
                text.push_str(&format!("{},{:?},{name},{parts}\n", index + 1, mode.frequency()));
            }
        }
        text
    }
}

fn word(kind: Kind) -> &'static str {
    match kind {
        Kind::Largest => "max",
        Kind::Smallest => "min",
        Kind::Crossing => "crossing",
    }
}

impl Features {
    /// Each feature with each parameter: derivatives of value and time, if there are any.
    fn cells(&self) -> impl Iterator<Item = (&Feature, &str, Option<[f64; 2]>)> {
        self.features.iter().flat_map(|own| {
            let by = |index: usize| own.changes.as_ref().ok().map(|by| [by.value[index], by.time[index]]);
            self.parameters.iter().enumerate().map(move |(index, (name, _))| (own, name.as_str(), by(index)))
        })
    }
}

impl Report for Features {
    fn text(&self, units: &Units) -> String {
        let (parameters, second) = (shown_by(&self.parameters, units), shown(units, "s"));
        let at = titled("at", &second.name);
        let titles = ["output", "", "value", "unit", &at, "with respect to", "d(value)", "d(time)"];
        let mut lines = vec![titles.map(str::to_owned).to_vec()];
        for ((own, _, by), (parameter, size)) in self.cells().zip(parameters.iter().cycle()) {
            let unit = shown(units, &own.output.1);
            let scaled = |[value, time]: [f64; 2]| [value / unit.factor, time / second.factor];
            let numbers = by.map(|by| scaled(by).map(|by| number(by * size, 0.0)));
            let numbers = numbers.unwrap_or_else(|| ["-".to_owned(), "-".to_owned()]);
            let [value, time] = scaled([own.value, own.time]).map(|value| number(value, 0.0));
            let own = [own.output.0.clone(), word(own.kind).to_owned(), value, unit.name, time];
            lines.push(own.into_iter().chain([parameter.clone()]).chain(numbers).collect());
        }
        let why = |own: &Feature| {
            let what = own.changes.as_ref().err()?;
            Some(format!("  no derivatives of the {} of {}: {what}\n", word(own.kind), own.output.0))
        };
        let notes: String = self.features.iter().filter_map(why).collect();
        format!("{}: peaks and crossings{}\n\n{}{notes}", self.name, told(units), align(&lines))
    }

    fn json(&self) -> Value {
        let feature = |own: &Feature| {
            let by = |pick: fn(&Changes) -> &Vec<f64>| {
                own.changes.as_ref().ok().map(|by| by_name(&self.parameters, pick(by).iter().copied()))
            };
            json!({ "output": own.output.0, "unit": own.output.1, "kind": word(own.kind), "value": own.value, "time": own.time,
                    "d_value": by(|by| &by.value), "d_time": by(|by| &by.time), "refused": own.changes.as_ref().err() })
        };
        json!({ "name": self.name, "features": self.features.iter().map(feature).collect::<Vec<_>>() })
    }

    fn csv(&self, _: &Units) -> String {
        let mut text = String::from("output,kind,value,time,parameter,d_value,d_time\n");
        for (own, parameter, by) in self.cells() {
            let (name, kind) = (&own.output.0, word(own.kind));
            let by = by.map_or_else(|| ",".to_owned(), |[value, time]| format!("{value:?},{time:?}"));
            text.push_str(&format!("{name},{kind},{:?},{:?},{parameter},{by}\n", own.value, own.time));
        }
        text
    }
}
