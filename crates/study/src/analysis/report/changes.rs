//! Derivatives: of an equilibrium, of vibrations, of peaks and crossings.

use cotree::output::report::Accuracy::Noise;
use cotree::output::report::{ROUNDING, Report, Table, named, number, per, unit};
use cotree::{line, row};
use serde_json::{Value, json};

use super::exact;
use super::modes::ratio;
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

    pub fn report(&self) -> Report {
        let by = self.parameters.iter().map(|(name, si)| line!["d/d(", named(name, si), ")"]);
        let mut table = Table::new(row!["output", "value", "unit"].into_iter().chain(by).collect(), []);
        let mut sheet = Table::new(row!["output", "value", "parameter", "derivative"], []);
        for (name, si, value, derivatives) in self.rows() {
            let mut row = row![name, number(value, si), unit(si)];
            for ((parameter, by), derivative) in self.parameters.iter().zip(derivatives) {
                row.push(number(derivative, &per(si, by)));
                sheet.rows.push(row![name, exact(value), parameter, exact(derivative)]);
            }
            table.rows.push(row);
        }
        Report { tables: vec![table], sheet, data: self.data(), ..Report::new(row!["Where it rests:"]) }
    }

    fn data(&self) -> Value {
        let outputs = self.rows().map(|(name, unit, value, derivatives)| {
            json!({ "name": name, "unit": unit, "value": value, "derivatives": by_name(&self.parameters, &derivatives) })
        });
        json!({ "time": self.times.first(), "outputs": outputs.collect::<Value>() })
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

    fn cells(&self, mode: usize) -> impl Iterator<Item = (&(String, String), Option<[f64; 4]>)> {
        self.parameters.iter().enumerate().map(move |(index, parameter)| (parameter, self.parts(mode, index)))
    }

    pub fn report(&self) -> Report {
        let columns = row!["mode", named("frequency", "Hz"), "damping ratio", "with respect to", "d(frequency)"];
        let mut table = Table::new([columns, row!["d(damping ratio)"]].concat(), []);
        let keys = row!["mode", "frequency", "parameter", "real", "imaginary", "d_frequency", "d_damping_ratio"];
        let mut sheet = Table::new(keys, []);
        for (index, mode) in self.modes.iter().enumerate() {
            let (place, own) = (index + 1, exact(mode.frequency()));
            let size = mode.eigenvalue.norm() / std::f64::consts::TAU;
            for ((name, by), parts) in self.cells(index) {
                let [real, imaginary, frequency, damping] = parts.unwrap_or([f64::NAN; 4]);
                // A damping ratio changes with the frequency over itself.
                let noise = ROUNDING * frequency.abs().max(size * damping.abs());
                let of = |value, si, noise| number(value, &per(si, by)).within(Noise(noise));
                let [faster, damped] = [of(frequency, "Hz", noise), of(damping, "", noise / size)];
                table.rows.push(row![place, own, ratio(mode), named(name, by), faster, damped]);
                sheet.rows.push(row![place, own, name, exact(real), exact(imaginary), faster, damped]);
            }
        }
        let free = "A mode without derivatives moves freely, or its eigenvalue is there twice.";
        Report {
            tables: vec![table],
            notes: self.derivatives.iter().any(Option::is_none).then(|| free.into()).into_iter().collect(),
            sheet,
            data: self.data(),
            ..Report::new(vec![line![self.name, ": vibration about its equilibrium"]])
        }
    }

    fn data(&self) -> Value {
        let mode = |(index, mode): (usize, &Mode)| {
            let derivatives = self.cells(index).map(|((name, _), parts)| {
                let parts = parts.map(|[real, imaginary, frequency, damping]| {
                    json!({ "eigenvalue": [real, imaginary], "frequency": frequency, "damping_ratio": damping })
                });
                (name.clone(), parts)
            });
            let derivatives: Value = derivatives.collect();
            let (value, frequency) = (mode.eigenvalue, mode.frequency());
            json!({ "eigenvalue": [value.re, value.im], "frequency": frequency, "derivatives": derivatives })
        };
        json!({ "name": self.name, "modes": self.modes.iter().enumerate().map(mode).collect::<Value>() })
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
    pub fn report(&self) -> Report {
        let columns = row!["output", "", "value", "unit", named("at", "s"), "with respect to", "d(value)", "d(time)"];
        let mut table = Table::new(columns, []);
        let mut sheet = Table::new(row!["output", "kind", "value", "time", "parameter", "d_value", "d_time"], []);
        for own in &self.features {
            let ((output, of), kind) = (&own.output, word(own.kind));
            let [value, time] =
                [(own.value, &**of), (own.time, "s")].map(|(own, si)| number(own, si).within(Noise(0.0)));
            for (index, (name, si)) in self.parameters.iter().enumerate() {
                let by = |of: fn(&Changes) -> &Vec<f64>| own.changes.as_ref().map_or(f64::NAN, |by| of(by)[index]);
                let d_value = number(by(|by| &by.value), &per(of, si));
                let d_time = number(by(|by| &by.time), &per("s", si)).within(Noise(0.0));
                table.rows.push(row![output, kind, value, unit(of), time, named(name, si), d_value, d_time]);
                sheet.rows.push(row![output, kind, value, time, name, d_value, d_time]);
            }
        }
        let why = |own: &Feature| {
            let what = own.changes.as_ref().err()?;
            Some(format!("  no derivatives of the {} of {}: {what}", word(own.kind), own.output.0).into())
        };
        Report {
            tables: vec![table],
            notes: self.features.iter().filter_map(why).collect(),
            sheet,
            data: self.data(),
            ..Report::new(vec![line![self.name, ": peaks and crossings"]])
        }
    }

    fn data(&self) -> Value {
        let feature = |own: &Feature| {
            let by = |pick: fn(&Changes) -> &Vec<f64>| {
                own.changes.as_ref().ok().map(|by| by_name(&self.parameters, pick(by)))
            };
            json!({ "output": own.output.0, "unit": own.output.1, "kind": word(own.kind), "value": own.value, "time": own.time,
                    "d_value": by(|by| &by.value), "d_time": by(|by| &by.time), "refused": own.changes.as_ref().err() })
        };
        json!({ "name": self.name, "features": self.features.iter().map(feature).collect::<Value>() })
    }
}
