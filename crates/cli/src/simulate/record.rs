//! What a run has reported, in the units in which it is shown: as a plot and in figures.

use std::f64::consts::{PI, TAU};

use cotree::compile::Compiled;
use cotree::diagnostic::suggest;
use cotree::model::{DisplayUnit, Unit};
use cotree::report::csv::CsvTable;
use cotree::report::statistics::{RunStatistics, VariableFigures};
use cotree::run::Run;
use cotree::typeset::titled;
use cotree_draw::plot::{Plot, PlotSeries};

use super::super::failure::Failure;
use super::super::units::ShownUnits;
use super::SimulateCommand;

/// Values over time.
pub struct RunRecord {
    time: DisplayUnit,
    times: Vec<f64>,
    columns: Vec<RecordedVariable>,
}

/// A variable that a run does not report.
#[derive(Debug, thiserror::Error)]
#[error("`{name}` is not reported; {known}")]
struct NotReported {
    name: String,
    /// What may have been meant.
    known: String,
}

struct RecordedVariable {
    name: String,
    unit: DisplayUnit,
    si: Unit,
    values: Vec<f64>,
}

impl RunRecord {
    pub fn new(compiled: &Compiled, reported: &[usize], shown: &ShownUnits) -> RunRecord {
        let column = |&index: &usize| {
            let variable = &compiled.description.variables[index];
            RecordedVariable {
                name: variable.name.clone(),
                unit: shown.of(&variable.unit),
                si: variable.unit.clone(),
                values: Vec::new(),
            }
        };
        RunRecord { time: shown.of(&Unit::time()), times: Vec::new(), columns: reported.iter().map(column).collect() }
    }

    /// A row of the table, SI: the time, then the values with their angles within half a turn.
    pub fn wrapped(&self, time: f64, values: &[f64]) -> Vec<f64> {
        let shown =
            |(column, &value): (&RecordedVariable, &f64)| if is_angle(&column.si) { wrapped(value) } else { value };
        std::iter::once(time).chain(self.columns.iter().zip(values).map(shown)).collect()
    }

    /// Adds a row, SI.
    pub fn push(&mut self, row: &[f64]) {
        self.times.push(row[0] / self.time.factor);
        self.columns
            .iter_mut()
            .zip(&row[1..])
            .for_each(|(column, value)| column.values.push(value / column.unit.factor));
    }

    /// The names of the variables.
    pub fn names(&self) -> Vec<&str> {
        self.columns.iter().map(|column| column.name.as_str()).collect()
    }

    /// The columns of the table.
    pub fn table(&self, shown: &ShownUnits) -> Vec<(String, f64)> {
        let columns = self.columns.iter().map(|column| shown.column(&column.name, &column.si));
        std::iter::once(shown.column("time", &Unit::time())).chain(columns).collect()
    }

    pub fn statistics(&self) -> RunStatistics {
        let figures = |column: &RecordedVariable| {
            VariableFigures::of(&column.name, &column.unit.name, &self.times, &column.values)
        };
        let ends = [self.times.first(), self.times.last()].map(|time| time.copied().unwrap_or(0.0));
        RunStatistics {
            time_unit: self.time.name.clone(),
            span: ends,
            variables: self.columns.iter().filter_map(figures).collect(),
        }
    }

    /// The curves over time, or over another variable.
    pub fn plot(&self, options: &SimulateCommand, run: &Run, shown: &ShownUnits) -> Result<Plot, Failure> {
        let title = run.description.model_name.clone();
        if let Some(x) = options.x.as_deref().filter(|x| *x != "time") {
            return self.plot_over(title, self.axis(x)?, &options.y);
        }
        let wanted = |column: &&RecordedVariable| options.y.is_empty() || options.y.contains(&column.name);
        let mut series: Vec<PlotSeries> =
            self.columns.iter().filter(wanted).map(|column| self.series(column, options.wrap)).collect();
        series.extend(self.inputs(run, shown));
        let axis = titled("time", &self.time.name);
        Ok(Plot { title, axis, true_to_scale: None, time: self.times.clone(), series })
    }

    fn plot_over(&self, title: String, x: &RecordedVariable, wanted: &[String]) -> Result<Plot, Failure> {
        let columns: Vec<&RecordedVariable> = wanted.iter().map(|name| self.axis(name)).collect::<Result<_, _>>()?;
        let is_length = x.si.exponents == Unit::length().exponents;
        Ok(Plot {
            title,
            axis: titled(&x.name, &x.unit.name),
            true_to_scale: is_length.then(|| x.unit.name.clone()),
            time: x.values.clone(),
            series: columns.iter().map(|column| self.series(column, false)).collect(),
        })
    }

    /// The variable of that name.
    fn column(&self, name: &str) -> Result<&RecordedVariable, NotReported> {
        let known = || suggest::known(name, self.columns.iter().map(|column| column.name.as_str()));
        let not_reported = || NotReported { name: name.to_owned(), known: known() };
        self.columns.iter().find(|column| column.name == name).ok_or_else(not_reported)
    }

    fn axis(&self, name: &str) -> Result<&RecordedVariable, Failure> {
        self.column(name).map_err(|error| Failure::Usage(error.to_string()))
    }

    /// A curve; where a wrapped angle begins a new turn it has a gap.
    fn series(&self, column: &RecordedVariable, wrap: bool) -> PlotSeries {
        let curve = |values| PlotSeries::new(&column.name, &column.unit.name, values);
        if !(wrap && is_angle(&column.si)) {
            return curve(column.values.clone());
        }
        let half = PI / column.unit.factor;
        let (mut at, mut values) = (Vec::new(), Vec::new());
        for (&time, &value) in self.times.iter().zip(&column.values) {
            if values.last().is_some_and(|last: &f64| (value - last).abs() > half) {
                at.push(time);
                values.push(f64::NAN);
            }
            at.push(time);
            values.push(value);
        }
        PlotSeries { at: Some(at), ..curve(values) }
    }

    /// The inputs that the table gives, where they are not reported anyway.
    fn inputs(&self, run: &Run, shown: &ShownUnits) -> Vec<PlotSeries> {
        let Some((table, variables)) = &run.inputs else { return Vec::new() };
        let mut series = Vec::new();
        for (place, &index) in variables.iter().enumerate() {
            let variable = &run.description.variables[index];
            if self.columns.iter().all(|column| column.name != variable.name) {
                let unit = shown.of(&variable.unit);
                let value = |time: &f64| table.at(place, time * self.time.factor).0 / unit.factor;
                series.push(PlotSeries::new(&variable.name, &unit.name, self.times.iter().map(value).collect()));
            }
        }
        series
    }

    /// Measured values for the variables of the same names, and how far they are from these.
    pub fn overlay(&self, table: &CsvTable, file: &str) -> Result<(Vec<PlotSeries>, String), Failure> {
        let wrong = |message: String| Failure::Usage(format!("{file}: {message}"));
        let (mut measured, mut report) = (Vec::new(), String::new());
        for (place, (name, unit)) in table.names().iter().zip(table.units()).enumerate() {
            let column = (self.column(name))
                .map_err(|error| wrong(format!("the column `{name}` is not a reported variable; {}", error.known)))?;
            if let Some(unit) = unit.as_ref().filter(|unit| !unit.is_compatible(&column.si) && !column.si.si.is_empty())
            {
                return Err(wrong(format!(
                    "`{name}` is in `{}`, but the variable in `{}`",
                    unit.shown(),
                    column.si.si
                )));
            }
            let at: Vec<f64> = table.times().iter().map(|time| time / self.time.factor).collect();
            let values: Vec<f64> = table.column(place).iter().map(|value| value / column.unit.factor).collect();
            report += &self.difference(column, &at, &values);
            let dots = PlotSeries::new(&format!("{name} measured"), &column.unit.name, values);
            measured.push(PlotSeries { at: Some(at), measured: Some(name.clone()), ..dots });
        }
        Ok((measured, report))
    }

    /// How far a variable is from what was measured, at the measured times within the run.
    fn difference(&self, column: &RecordedVariable, at: &[f64], values: &[f64]) -> String {
        let (mut squares, mut most, mut count) = (0.0, [0.0, 0.0], 0);
        for (&time, &value) in at.iter().zip(values) {
            let next = self.times.partition_point(|&row| row < time);
            let (Some(&after), Some(&there)) = (self.times.get(next), column.values.get(next)) else { continue };
            let before = match next.checked_sub(1) {
                Some(last) => {
                    let part = (time - self.times[last]) / (after - self.times[last]);
                    column.values[last] + part * (there - column.values[last])
                }
                None if after == time => there,
                None => continue,
            };
            let difference: f64 = before - value;
            squares += difference * difference;
            count += 1;
            if difference.abs() > most[0] {
                most = [difference.abs(), time];
            }
        }
        let (unit, time) = (&column.unit.name, &self.time.name);
        if count == 0 {
            return format!("{}: no measured value within the run\n", column.name);
        }
        let rms = (squares / f64::from(count)).sqrt();
        format!(
            "{}: differs from {count} measured values by RMS {rms:.4e} {unit}, at most {:.4e} {unit} at {} {time}\n",
            column.name, most[0], most[1]
        )
    }
}

fn is_angle(unit: &Unit) -> bool {
    unit.exponents == Unit::angle().exponents
}

/// From minus half a turn up to half a turn.
fn wrapped(angle: f64) -> f64 {
    let turned = (angle + PI).rem_euclid(TAU) - PI;
    if turned <= -PI { PI } else { turned }
}
