//! The result of a fit as a table and as JSON.

use cotree::diagnostic::suggest::list;
use cotree::report::data::ReliableDigits::Error;
use cotree::report::data::{Cell, Report, Table, number, plain, unit};
use cotree::{line, row};
use serde_json::{Value, json};

use super::{Fit, FitEnded, FittedQuantity, MeasuredExperiment, MeasuredVariable};

/// Correlations are known to this at best: they have four decimals.
const CORRELATION: f64 = 0.01;

/// Says of how many of all rows of the table something is left out, if it is.
pub(super) fn rows_left_out(left_out: &[f64], all: usize) -> Option<String> {
    let (first, left) = (left_out.first()?, left_out.len());
    Some(format!(
        "{left} of {all} rows are left out, the first at t = {first} s: a column has no value or no derivative there"
    ))
}

impl Fit {
    pub fn report(&self) -> Report {
        let columns = self.measured.iter().flat_map(|experiment_data| &experiment_data.columns);
        let (quantities, values) = (self.quantities.len(), columns.map(MeasuredVariable::count).sum::<usize>());
        let ended = match self.ended {
            FitEnded::Settled => "at a minimum",
            FitEnded::Exhausted => "without a minimum: the limit of motions is reached",
            FitEnded::Stopped => "without a minimum: it was stopped",
        };
        let mut search = format!("\nended {ended}; {} motions were computed with their derivatives", self.evaluations);
        if !self.guesses.is_empty() {
            let names = list(self.guesses.iter().map(|guess| &guess.name));
            search += &format!("\nthe start has moved away from the guess of {names}; -o writes the new guess too");
        }
        for (index, experiment_data) in self.measured.iter().enumerate() {
            let of = if self.measured.len() > 1 { format!("experiment {}: ", index + 1) } else { String::new() };
            search += &rows_left_out(&experiment_data.left_out, experiment_data.times.len())
                .map(|said| format!("\n{of}{said}"))
                .unwrap_or_default();
        }
        let several = match self.measured.len() {
            1 => String::new(),
            count => format!(" of {count} experiments"),
        };
        Report {
            tables: vec![self.estimates(), self.correlations(), self.residuals()],
            notes: row![search],
            data: self.data(),
            ..Report::new(row![format!(
                "{}: {quantities} of its values fitted to {values} measured ones{several}",
                self.name
            )])
        }
    }

    /// Values have the digits that their errors permit.
    fn estimates(&self) -> Table {
        let row = |quantity_data: &FittedQuantity| {
            let told =
                |value: f64| number(value, &quantity_data.unit).within(Error(quantity_data.error.unwrap_or(0.0)));
            let [size, low, high] = match quantity_data.error.zip(quantity_data.limits) {
                Some((error, [low, high])) => [error, low, high].map(told),
                None => ["at its bound", "-", "-"].map(Cell::from),
            };
            row![
                quantity_data.name,
                told(quantity_data.value),
                size,
                low,
                high,
                unit(&quantity_data.unit),
                number(quantity_data.start, &quantity_data.unit)
            ]
        };
        let columns = row!["quantity", "value", "std. error", "95 % from", "to", "unit", "start"];
        Table::new(columns, self.quantities.iter().map(row))
    }

    fn correlations(&self) -> Table {
        let names: Vec<&String> = self.quantities.iter().map(|quantity| &quantity.name).collect();
        let entry = |row: usize, column: usize| plain(self.correlation[(row, column)], 0.0).within(Error(CORRELATION));
        Table::matrix("correlation", &names, &names, entry)
    }

    fn residuals(&self) -> Table {
        let row = |(experiment, variable): (usize, &MeasuredVariable)| {
            let [rms, deviation] = [variable.rms(), variable.deviation].map(|value| number(value, &variable.unit));
            let given = if variable.is_given { " (given)" } else { "" };
            let name = if self.measured.len() > 1 {
                format!("{} ({experiment})", variable.name)
            } else {
                variable.name.clone()
            };
            row![name, variable.count(), rms, deviation, line![unit(&variable.unit), given]]
        };
        let columns = row!["measured", "values", "residual RMS", "std. deviation", "unit"];
        let measured = self.measured.iter().enumerate();
        let all = measured.flat_map(|(index, variable)| variable.columns.iter().map(move |column| (index + 1, column)));
        Table::new(columns, all.map(row))
    }

    fn data(&self) -> Value {
        let quantity = |(index, quantity_data): (usize, &FittedQuantity)| {
            let correlation: Value = self.correlation.row(index).iter().copied().collect();
            json!({ "name": quantity_data.name, "unit": quantity_data.unit, "start": quantity_data.start, "value": quantity_data.value, "error": quantity_data.error,
                    "limits": quantity_data.limits, "correlation": correlation })
        };
        let ended = match self.ended {
            FitEnded::Settled => "minimum",
            FitEnded::Exhausted => "evaluations",
            FitEnded::Stopped => "stopped",
        };
        let mut data = json!({
            "name": self.name, "ended": ended, "evaluations": self.evaluations,
            "guesses": self.guesses.iter().map(|guess| json!({ "name": guess.name, "unit": guess.unit.si, "guess": guess.guessed, "found": guess.found })).collect::<Value>(),
            "quantities": self.quantities.iter().enumerate().map(quantity).collect::<Value>(),
        });
        match self.measured.as_slice() {
            [one] => {
                if let (Value::Object(data), Value::Object(other_data)) = (&mut data, one.data()) {
                    data.extend(other_data);
                }
            }
            all => data["experiments"] = all.iter().map(MeasuredExperiment::data).collect(),
        }
        data
    }
}

impl MeasuredExperiment {
    fn data(&self) -> Value {
        let column = |variable: &MeasuredVariable| {
            let residuals: Value =
                variable.measured.iter().zip(&variable.fitted).map(|(value, fitted)| value - fitted).collect();
            json!({ "name": variable.name, "unit": variable.unit, "rms": variable.rms(), "deviation": variable.deviation,
                    "given": variable.is_given, "fitted": variable.fitted, "residuals": residuals })
        };
        let columns: Value = self.columns.iter().map(column).collect();
        json!({ "times": self.times, "left_out": self.left_out, "columns": columns })
    }
}
