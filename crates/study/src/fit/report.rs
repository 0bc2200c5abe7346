//! What was found, as a table for people and as JSON.

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
        let columns = self.measured.iter().flat_map(|own| &own.columns);
        let (quantities, values) = (self.quantities.len(), columns.map(MeasuredVariable::count).sum::<usize>());
        let ended = match self.ended {
            FitEnded::Settled => "at a minimum",
            FitEnded::Exhausted => "without a minimum: the limit of motions is reached",
            FitEnded::Stopped => "without a minimum: it was stopped",
        };
        let mut search = format!("\nended {ended}; {} motions were computed with their derivatives", self.evaluations);
        if !self.guesses.is_empty() {
            let names = list(self.guesses.iter().map(|own| &own.name));
            search += &format!("\nthe start has moved away from the guess of {names}; -o writes the new guess too");
        }
        for (index, own) in self.measured.iter().enumerate() {
            let of = if self.measured.len() > 1 { format!("experiment {}: ", index + 1) } else { String::new() };
            search +=
                &rows_left_out(&own.left_out, own.times.len()).map(|said| format!("\n{of}{said}")).unwrap_or_default();
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
        let row = |own: &FittedQuantity| {
            let told = |value: f64| number(value, &own.unit).within(Error(own.error.unwrap_or(0.0)));
            let [size, low, high] = match own.error.zip(own.limits) {
                Some((error, [low, high])) => [error, low, high].map(told),
                None => ["at its bound", "-", "-"].map(Cell::from),
            };
            row![own.name, told(own.value), size, low, high, unit(&own.unit), number(own.start, &own.unit)]
        };
        let columns = row!["quantity", "value", "std. error", "95 % from", "to", "unit", "start"];
        Table::new(columns, self.quantities.iter().map(row))
    }

    fn correlations(&self) -> Table {
        let names: Vec<&String> = self.quantities.iter().map(|own| &own.name).collect();
        let entry = |row: usize, column: usize| plain(self.correlation[(row, column)], 0.0).within(Error(CORRELATION));
        Table::matrix("correlation", &names, &names, entry)
    }

    fn residuals(&self) -> Table {
        let row = |(experiment, own): (usize, &MeasuredVariable)| {
            let [rms, deviation] = [own.rms(), own.deviation].map(|value| number(value, &own.unit));
            let given = if own.is_given { " (given)" } else { "" };
            let name = if self.measured.len() > 1 { format!("{} ({experiment})", own.name) } else { own.name.clone() };
            row![name, own.count(), rms, deviation, line![unit(&own.unit), given]]
        };
        let columns = row!["measured", "values", "residual RMS", "std. deviation", "unit"];
        let measured = self.measured.iter().enumerate();
        let all = measured.flat_map(|(index, own)| own.columns.iter().map(move |column| (index + 1, column)));
        Table::new(columns, all.map(row))
    }

    fn data(&self) -> Value {
        let quantity = |(index, own): (usize, &FittedQuantity)| {
            let correlation: Value = self.correlation.row(index).iter().copied().collect();
            json!({ "name": own.name, "unit": own.unit, "start": own.start, "value": own.value, "error": own.error,
                    "limits": own.limits, "correlation": correlation })
        };
        let ended = match self.ended {
            FitEnded::Settled => "minimum",
            FitEnded::Exhausted => "evaluations",
            FitEnded::Stopped => "stopped",
        };
        let mut data = json!({
            "name": self.name, "ended": ended, "evaluations": self.evaluations,
            "guesses": self.guesses.iter().map(|own| json!({ "name": own.name, "unit": own.unit.si, "guess": own.guessed, "found": own.found })).collect::<Value>(),
            "quantities": self.quantities.iter().enumerate().map(quantity).collect::<Value>(),
        });
        match self.measured.as_slice() {
            [one] => {
                if let (Value::Object(data), Value::Object(own)) = (&mut data, one.data()) {
                    data.extend(own);
                }
            }
            all => data["experiments"] = all.iter().map(MeasuredExperiment::data).collect(),
        }
        data
    }
}

impl MeasuredExperiment {
    fn data(&self) -> Value {
        let column = |own: &MeasuredVariable| {
            let residuals: Value = own.measured.iter().zip(&own.fitted).map(|(own, fitted)| own - fitted).collect();
            json!({ "name": own.name, "unit": own.unit, "rms": own.rms(), "deviation": own.deviation,
                    "given": own.is_given, "fitted": own.fitted, "residuals": residuals })
        };
        let columns: Value = self.columns.iter().map(column).collect();
        json!({ "times": self.times, "left_out": self.left_out, "columns": columns })
    }
}
