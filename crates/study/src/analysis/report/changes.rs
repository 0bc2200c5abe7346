//! Derivatives: of an equilibrium, of vibrations, of peaks and crossings.

use cotree::report::data::ReliableDigits::Noise;
use cotree::report::data::{ROUNDING, Report, Table, named, number, per, unit};
use cotree::{line, row};
use serde_json::{Value, json};

use super::exact;
use super::modes::ratio;
use crate::analysis::{Feature, FeatureDerivatives, FeatureKind, ModeChanges, Sensitivities};

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
    pub fn report(&self) -> Report {
        let by = self.parameters.iter().map(|(name, si)| line!["d/d(", named(name, si), ")"]);
        let mut table = Table::new(row!["output", "value", "unit"].into_iter().chain(by).collect(), []);
        let mut sheet = Table::new(row!["output", "value", "parameter", "derivative"], []);
        let mut outputs = Vec::new();
        let first = self.values.iter().zip(&self.derivatives).take(1);
        let lines = first.flat_map(|(values, matrix)| values.iter().zip(matrix.row_iter())).zip(&self.outputs);
        for ((&value, derivatives), (name, si)) in lines {
            let derivatives: Vec<f64> = derivatives.iter().copied().collect();
            let by = by_name(&self.parameters, &derivatives);
            outputs.push(json!({ "name": name, "unit": si, "value": value, "derivatives": by }));
            let mut row = row![name, number(value, si), unit(si)];
            for ((parameter, by), derivative) in self.parameters.iter().zip(derivatives) {
                row.push(number(derivative, &per(si, by)));
                sheet.rows.push(row![name, exact(value), parameter, exact(derivative)]);
            }
            table.rows.push(row);
        }
        let data = json!({ "time": self.times.first(), "outputs": outputs });
        Report { tables: vec![table], sheet, data, ..Report::new(row!["Equilibrium:"]) }
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

    pub fn report(&self) -> Report {
        let columns = row!["mode", "frequency [Hz]", "damping ratio", "with respect to", "d(frequency)"];
        let mut table = Table::new([columns, row!["d(damping ratio)"]].concat(), []);
        let keys = row!["mode", "frequency", "parameter", "real", "imaginary", "d_frequency", "d_damping_ratio"];
        let mut sheet = Table::new(keys, []);
        let mut modes = Vec::new();
        for (index, mode) in self.modes.iter().enumerate() {
            let (place, eigenfrequency, value) = (index + 1, exact(mode.frequency()), mode.eigenvalue);
            let size = value.norm() / std::f64::consts::TAU;
            let mut derivatives = json!({});
            for (parameter, (name, by)) in self.parameters.iter().enumerate() {
                let parts = self.parts(index, parameter);
                let [real, imaginary, frequency, damping] = parts.unwrap_or([f64::NAN; 4]);
                derivatives[name] = json!(parts.map(
                    |_| json!({ "eigenvalue": [real, imaginary], "frequency": frequency, "damping_ratio": damping })
                ));
                // A damping ratio changes with the frequency over itself.
                let noise = ROUNDING * frequency.abs().max(size * damping.abs());
                let of = |value, si, noise| number(value, &per(si, by)).within(Noise(noise));
                let [faster, damped] = [of(frequency, "Hz", noise), of(damping, "", noise / size)];
                table.rows.push(row![place, eigenfrequency, ratio(mode), named(name, by), faster, damped]);
                sheet.rows.push(row![place, eigenfrequency, name, exact(real), exact(imaginary), faster, damped]);
            }
            modes.push(json!({ "eigenvalue": [value.re, value.im], "frequency": mode.frequency(), "derivatives": derivatives }));
        }
        let free = "A mode without derivatives is a rigid-body mode, or has a double eigenvalue.";
        Report {
            tables: vec![table],
            notes: self.derivatives.iter().any(Option::is_none).then(|| free.into()).into_iter().collect(),
            sheet,
            data: json!({ "name": self.name, "modes": modes }),
            ..Report::new(vec![line![self.name, ": vibration about its equilibrium"]])
        }
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
        let (mut features, mut notes) = (Vec::new(), Vec::new());
        for feature in &self.features {
            let ((output, of), kind) = (&feature.output, word(feature.kind));
            let [value, time] = [(feature.value, &**of), (feature.time, "s")]
                .map(|(derivative, si)| number(derivative, si).within(Noise(0.0)));
            let changes = feature.changes.as_ref().ok();
            for (index, (name, si)) in self.parameters.iter().enumerate() {
                let [value_by, time_by] =
                    changes.map_or([f64::NAN; 2], |by: &FeatureDerivatives| [by.value[index], by.time[index]]);
                let d_value = number(value_by, &per(of, si));
                let d_time = number(time_by, &per("s", si)).within(Noise(0.0));
                table.rows.push(row![output, kind, value, unit(of), time, named(name, si), d_value, d_time]);
                sheet.rows.push(row![output, kind, value, time, name, d_value, d_time]);
            }
            let [by_value, by_time] = [changes.map(|by| &by.value), changes.map(|by| &by.time)]
                .map(|by| by.map(|by| by_name(&self.parameters, by)));
            features.push(json!({ "output": output, "unit": of, "kind": kind, "value": feature.value, "time": feature.time,
                                  "d_value": by_value, "d_time": by_time, "refused": feature.changes.as_ref().err().map(ToString::to_string) }));
            let refused = feature.changes.as_ref().err();
            notes.extend(refused.map(|what| format!("  no derivatives of the {kind} of {output}: {what}").into()));
        }
        Report {
            tables: vec![table],
            notes,
            sheet,
            data: json!({ "name": self.name, "features": features }),
            ..Report::new(vec![line![self.name, ": peaks and crossings"]])
        }
    }
}
