//! Derivatives: of an equilibrium, of vibrations, of peaks and crossings.

use cotree::cells;
use cotree::columns::titled;
use cotree::compile::shown;
use cotree::mechanism::Units;
use serde_json::{Value, json};

use super::modes::ratio;
use super::{Report, csv, exact, number, page, told};
use crate::analysis::{Changes, Feature, FeatureKind, Mode, ModeChanges, Sensitivities};

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

fn by_name(parameters: &[(String, String)], values: &[f64]) -> Value {
    parameters.iter().zip(values).map(|((name, _), value)| (name.clone(), *value)).collect()
}

impl Sensitivities {
    /// At its first time, that of an equilibrium: each output with its unit, its value and its derivatives.
    fn rows(&self) -> impl Iterator<Item = (&str, &str, f64, Vec<f64>)> {
        self.values.iter().zip(&self.derivatives).take(1).flat_map(|(values, derivatives)| {
            let by = |row: usize| derivatives.row(row).iter().copied().collect();
            let outputs = self.outputs.iter().enumerate();
            outputs.map(move |(row, (name, unit))| (name.as_str(), unit.as_str(), values[row], by(row)))
        })
    }
}

impl Report for Sensitivities {
    fn text(&self, units: &Units) -> String {
        let parameters = shown_by(&self.parameters, units);
        let mut rows = vec![cells!["output", "value", "unit"]];
        rows[0].extend(parameters.iter().map(|(name, _)| format!("d/d({name})")));
        for (name, si, value, derivatives) in self.rows() {
            let unit = shown(units, si);
            let most = |of: &dyn Fn((f64, Vec<f64>)) -> f64| {
                let same = self.rows().filter(|(_, other, ..)| *other == si);
                same.map(|(.., value, derivatives)| of((value, derivatives)).abs()).fold(0.0, f64::max)
            };
            let size = most(&|(value, _)| value).max(if si == "rad" { 1.0 } else { 0.0 });
            let mut row = cells![name, number(value / unit.factor, size / unit.factor), unit.name];
            row.extend(derivatives.iter().zip(&parameters).enumerate().map(|(column, (value, (_, by)))| {
                number(value * by / unit.factor, most(&|(_, derivatives)| derivatives[column]) * by / unit.factor)
            }));
            rows.push(row);
        }
        page(&format!("Where it rests{}:", told(units)), [("", rows)], "")
    }

    fn json(&self) -> Value {
        let outputs = self.rows().map(|(name, unit, value, derivatives)| {
            json!({ "name": name, "unit": unit, "value": value, "derivatives": by_name(&self.parameters, &derivatives) })
        });
        json!({ "time": self.times.first(), "outputs": outputs.collect::<Value>() })
    }

    fn csv(&self, _: &Units) -> String {
        let lines = self.rows().flat_map(|(name, _, value, derivatives)| {
            let parameters = self.parameters.iter().zip(derivatives);
            parameters.map(move |((parameter, _), by)| cells![name, exact(value), parameter, exact(by)])
        });
        csv("output,value,parameter,derivative", lines)
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
        let mut rows = vec![cells![
            "mode",
            "frequency [Hz]",
            "damping ratio",
            "with respect to",
            "d(frequency)",
            "d(damping ratio)"
        ]];
        for (index, mode) in self.modes.iter().enumerate() {
            let relative = mode.eigenvalue.norm() / std::f64::consts::TAU;
            for ((_, parts), (name, by)) in self.cells(index).zip(&parameters) {
                // A damping ratio changes with the frequency over itself.
                let shown = |[_, _, frequency, damping]: [f64; 4]| {
                    let most = frequency.abs().max(relative * damping.abs());
                    [number(frequency * by, most * by), number(damping * by, most * by / relative)]
                };
                let [frequency, damping] = parts.map_or(["-", "-"].map(str::to_owned), shown);
                rows.push(cells![index + 1, number(mode.frequency(), 0.0), ratio(mode), name, frequency, damping]);
            }
        }
        let note = "A mode without derivatives moves freely, or its eigenvalue is there twice.\n";
        let note = if self.derivatives.iter().any(Option::is_none) { note } else { "" };
        page(&format!("{}: vibration about its equilibrium{}", self.name, told(units)), [("", rows)], note)
    }

    fn json(&self) -> Value {
        let mode = |(index, mode): (usize, &Mode)| {
            let derivatives = self.cells(index).map(|(name, parts)| {
                let parts = parts.map(|[real, imaginary, frequency, damping]| {
                    json!({ "eigenvalue": [real, imaginary], "frequency": frequency, "damping_ratio": damping })
                });
                (name, parts)
            });
            let derivatives: Value = derivatives.collect();
            let (value, frequency) = (mode.eigenvalue, mode.frequency());
            json!({ "eigenvalue": [value.re, value.im], "frequency": frequency, "derivatives": derivatives })
        };
        json!({ "name": self.name, "modes": self.modes.iter().enumerate().map(mode).collect::<Value>() })
    }

    fn csv(&self, _: &Units) -> String {
        let lines = self.modes.iter().enumerate().flat_map(|(index, mode)| {
            self.cells(index).map(move |(name, parts)| {
                let parts = parts.map_or_else(|| vec![String::new(); 4], |parts| parts.map(exact).to_vec());
                [cells![index + 1, exact(mode.frequency()), name], parts].concat()
            })
        });
        csv("mode,frequency,parameter,real,imaginary,d_frequency,d_damping_ratio", lines)
    }
}

fn word(kind: FeatureKind) -> &'static str {
    match kind {
        FeatureKind::Largest => "max",
        FeatureKind::Smallest => "min",
        FeatureKind::Crossing => "crossing",
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
        let mut rows = vec![cells!["output", "", "value", "unit", at, "with respect to", "d(value)", "d(time)"]];
        for ((own, column, by), (parameter, size)) in self.cells().zip(parameters.iter().cycle()) {
            let unit = shown(units, &own.output.1);
            let scaled = |[value, time]: [f64; 2], by: f64, most: f64| {
                [number(value * by / unit.factor, most * by / unit.factor), number(time * by / second.factor, 0.0)]
            };
            let [value, time] = scaled([own.value, own.time], 1.0, 0.0);
            let same = self.cells().filter(|(other, name, _)| other.output.1 == own.output.1 && *name == column);
            let most = same.filter_map(|(.., by)| by).fold(0.0, |most: f64, [value, _]| most.max(value.abs()));
            let [d_value, d_time] = by.map_or(["-", "-"].map(str::to_owned), |by| scaled(by, *size, most));
            rows.push(cells![own.output.0, word(own.kind), value, unit.name, time, parameter, d_value, d_time]);
        }
        let why = |own: &Feature| {
            let what = own.changes.as_ref().err()?;
            Some(format!("  no derivatives of the {} of {}: {what}\n", word(own.kind), own.output.0))
        };
        let notes: String = self.features.iter().filter_map(why).collect();
        page(&format!("{}: peaks and crossings{}", self.name, told(units)), [("", rows)], &notes)
    }

    fn json(&self) -> Value {
        let feature = |own: &Feature| {
            let by = |pick: fn(&Changes) -> &Vec<f64>| {
                own.changes.as_ref().ok().map(|by| by_name(&self.parameters, pick(by)))
            };
            json!({ "output": own.output.0, "unit": own.output.1, "kind": word(own.kind), "value": own.value, "time": own.time,
                    "d_value": by(|by| &by.value), "d_time": by(|by| &by.time), "refused": own.changes.as_ref().err() })
        };
        json!({ "name": self.name, "features": self.features.iter().map(feature).collect::<Value>() })
    }

    fn csv(&self, _: &Units) -> String {
        let lines = self.cells().map(|(own, parameter, by)| {
            let (name, kind) = (&own.output.0, word(own.kind));
            let [value, time] = by.map_or_else(Default::default, |by| by.map(exact));
            cells![name, kind, exact(own.value), exact(own.time), parameter, value, time]
        });
        csv("output,kind,value,time,parameter,d_value,d_time", lines)
    }
}
