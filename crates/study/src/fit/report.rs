//! What was found, as a table for people and as JSON.

use cotree::cells;
use cotree::compile;
use cotree::mechanism::Units;
use serde_json::{Value, json};

use super::{Column, Ended, Fit, Quantity};
use crate::analysis::report::page;

impl Fit {
    /// For people, in these units.
    pub fn text(&self, units: &Units) -> String {
        let (quantities, values) = (self.quantities.len(), self.times.len() * self.columns.len());
        let all = format!("{}: {quantities} of its values fitted to {values} measured ones", self.name);
        let ended = match self.ended {
            Ended::Settled => "at a minimum: no step makes the residuals smaller",
            Ended::Exhausted => "without a minimum: as many motions as are permitted were computed",
        };
        let tables = [self.estimates(units), self.correlations(), self.residuals(units)].map(|rows| ("", rows));
        let search = format!("\nended {ended}; {} motions were computed with their derivatives\n", self.evaluations);
        page(&all, tables, &search)
    }

    fn estimates(&self, units: &Units) -> Vec<Vec<String>> {
        let mut rows = vec![cells!["quantity", "value", "std. error", "95 % from", "to", "unit", "start"]];
        for own in &self.quantities {
            let unit = compile::shown(units, &own.unit);
            let [value, start] = [own.value, own.start].map(|value| value / unit.factor);
            let error = own.error.filter(|_| own.limits.is_some()).map(|error| error / unit.factor);
            let [error_shown, low, high] = match (error, own.limits) {
                (Some(size), Some([low, high])) => {
                    [size, low / unit.factor, high / unit.factor].map(|value| shown(value, error))
                }
                _ => ["at its bound", "-", "-"].map(str::to_owned),
            };
            rows.push(cells![own.name, shown(value, error), error_shown, low, high, unit.name, start]);
        }
        rows
    }

    fn correlations(&self) -> Vec<Vec<String>> {
        let cell = |value: &f64| if value.is_nan() { "-".to_owned() } else { format!("{value:.4}") };
        let names = || self.quantities.iter().map(|own| own.name.clone());
        let row = |(row, name)| std::iter::once(name).chain(self.correlation.row(row).iter().map(cell)).collect();
        let heads = std::iter::once("correlation".to_owned()).chain(names()).collect();
        std::iter::once(heads).chain(names().enumerate().map(row)).collect()
    }

    fn residuals(&self, units: &Units) -> Vec<Vec<String>> {
        let mut rows = vec![cells!["measured", "values", "residual RMS", "std. deviation", "unit"]];
        for own in &self.columns {
            let unit = compile::shown(units, &own.unit);
            let [rms, deviation] = [own.rms(), own.deviation].map(|value| format!("{:.4e}", value / unit.factor));
            let given = if own.is_given { " (given)" } else { "" };
            rows.push(cells![own.name, own.measured.len(), rms, deviation + given, unit.name]);
        }
        rows
    }

    /// For scripts; SI.
    pub fn json(&self) -> Value {
        let quantity = |(index, own): (usize, &Quantity)| {
            let correlation: Value = self.correlation.row(index).iter().copied().collect();
            json!({ "name": own.name, "unit": own.unit, "start": own.start, "value": own.value, "error": own.error,
                    "limits": own.limits, "correlation": correlation })
        };
        let column = |own: &Column| {
            let residuals: Value = own.measured.iter().zip(&own.fitted).map(|(own, fitted)| own - fitted).collect();
            json!({ "name": own.name, "unit": own.unit, "rms": own.rms(), "deviation": own.deviation,
                    "given": own.is_given, "fitted": own.fitted, "residuals": residuals })
        };
        let ended = match self.ended {
            Ended::Settled => "minimum",
            Ended::Exhausted => "evaluations",
        };
        json!({
            "name": self.name, "ended": ended, "evaluations": self.evaluations, "times": self.times,
            "quantities": self.quantities.iter().enumerate().map(quantity).collect::<Value>(),
            "columns": self.columns.iter().map(column).collect::<Value>(),
        })
    }
}

/// Two digits more than the error has before its first; ten without one.
fn shown(value: f64, error: Option<f64>) -> String {
    let exponent = |value: f64| if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    let last = match error.filter(|error| *error > 0.0 && error.is_finite()) {
        Some(error) => exponent(error) - 2,
        None => exponent(value) - 9,
    };
    // Fifteen digits are all there are.
    let last = last.max(exponent(value) - 14);
    match (-6..=6).contains(&exponent(value)) && last <= 0 {
        true => format!("{value:.*}", last.unsigned_abs() as usize),
        false => format!("{value:.*e}", (exponent(value) - last).max(0) as usize),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_the_digits_that_their_errors_permit() {
        for (value, error, text) in [
            (1.234_567, Some(0.001), "1.23457"),
            (0.001, Some(0.001), "0.00100"),
            (123_456.0, Some(20.0), "123456.0"),
            (1.5e9, Some(1e6), "1.50000e9"),
            (-0.5, None, "-0.5000000000"),
        ] {
            assert_eq!(shown(value, error), text);
        }
    }
}
