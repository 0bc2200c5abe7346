//! What was found, as a table for people and as JSON.

use cotree::compile;
use cotree::mechanism::Units;
use serde_json::{Value, json};

use super::{Ended, Fit, Quantity};
use crate::analysis::report::align;

impl Fit {
    /// For people, in these units.
    pub fn text(&self, units: &Units) -> String {
        let (quantities, values) = (self.quantities.len(), self.times.len() * self.columns.len());
        let all = format!("{}: {quantities} of its values fitted to {values} measured ones", self.name);
        let ended = match self.ended {
            Ended::Settled => "at a minimum: no step makes the residuals smaller",
            Ended::Exhausted => "without a minimum: as many motions as are permitted were computed",
        };
        let [estimates, correlation, columns] =
            [self.estimates(units), self.correlations(), self.residuals(units)].map(|l| align(&l));
        let search = format!("ended {ended}; {} motions were computed with their derivatives", self.evaluations);
        format!("{all}\n\n{estimates}\n{correlation}\n{columns}\n{search}\n")
    }

    fn estimates(&self, units: &Units) -> Vec<Vec<String>> {
        let titles = ["quantity", "value", "std. error", "95 % from", "to", "unit", "start"];
        let line = |own: &Quantity| {
            let unit = compile::shown(units, &own.unit);
            let [value, start] = [own.value, own.start].map(|value| value / unit.factor);
            let limits = own.limits.map(|limits| limits.map(|limit| limit / unit.factor));
            let known = own.error.map(|error| error / unit.factor).zip(limits);
            let numbers = match known {
                Some((error, [low, high])) => {
                    let digits = Some(error);
                    vec![shown(value, digits), shown(error, digits), shown(low, digits), shown(high, digits)]
                }
                None => vec![shown(value, None), "at its bound".to_owned(), "-".to_owned(), "-".to_owned()],
            };
            let ends = [unit.name, format!("{start}")];
            [own.name.clone()].into_iter().chain(numbers).chain(ends).collect()
        };
        [titles.map(str::to_owned).to_vec()].into_iter().chain(self.quantities.iter().map(line)).collect()
    }

    fn correlations(&self) -> Vec<Vec<String>> {
        let names = || self.quantities.iter().map(|own| own.name.clone());
        let mut lines = vec![["correlation".to_owned()].into_iter().chain(names()).collect::<Vec<_>>()];
        for (row, name) in names().enumerate() {
            let cell = |column: usize| match self.correlation[(row, column)] {
                value if value.is_nan() => "-".to_owned(),
                value => format!("{value:.4}"),
            };
            lines.push([name].into_iter().chain((0..self.quantities.len()).map(cell)).collect());
        }
        lines
    }

    fn residuals(&self, units: &Units) -> Vec<Vec<String>> {
        let mut lines =
            vec![["measured", "values", "residual RMS", "std. deviation", "unit"].map(str::to_owned).to_vec()];
        for column in &self.columns {
            let given = if column.is_given { " (given)" } else { "" };
            let unit = compile::shown(units, &column.unit);
            lines.push(vec![
                column.name.clone(),
                column.measured.len().to_string(),
                format!("{:.4e}", column.rms() / unit.factor),
                format!("{:.4e}{given}", column.deviation / unit.factor),
                unit.name,
            ]);
        }
        lines
    }

    /// For scripts; SI.
    pub fn json(&self) -> Value {
        let quantity = |(index, own): (usize, &Quantity)| {
            let correlation: Vec<Option<f64>> =
                self.correlation.row(index).iter().map(|value| value.is_finite().then_some(*value)).collect();
            json!({ "name": own.name, "unit": own.unit, "start": own.start, "value": own.value, "error": own.error,
                    "limits": own.limits, "correlation": correlation })
        };
        let column = |own: &super::Column| {
            let residuals: Vec<f64> = own.measured.iter().zip(&own.fitted).map(|(own, fitted)| own - fitted).collect();
            json!({ "name": own.name, "unit": own.unit, "rms": own.rms(), "deviation": own.deviation,
                    "given": own.is_given, "fitted": own.fitted, "residuals": residuals })
        };
        let ended = match self.ended {
            Ended::Settled => "minimum",
            Ended::Exhausted => "evaluations",
        };
        json!({
            "name": self.name, "ended": ended, "evaluations": self.evaluations, "times": self.times,
            "quantities": self.quantities.iter().enumerate().map(quantity).collect::<Vec<_>>(),
            "columns": self.columns.iter().map(column).collect::<Vec<_>>(),
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
