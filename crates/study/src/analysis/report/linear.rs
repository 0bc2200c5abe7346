//! Linear systems at one or many points.

use cotree::report::data::ReliableDigits::Noise;
use cotree::report::data::{Cell, ROUNDING, Report, Table, number, per, unit};
use cotree::row;
use nalgebra::DMatrix;
use serde_json::{Value, json};

use super::{at, contact_data, contact_tables, exact};
use crate::analysis::{AnalysisFailure, StateSpace, StateSpaceSignal};

#[derive(Clone, Debug)]
pub struct Linearization {
    pub name: String,
    pub points: Vec<StateSpace>,
    /// The time \[s\] from one instant to the next, if inputs are held in between; none for rates.
    pub step: Option<f64>,
}

/// Rates below this are those of a rest, SI: what an equilibrium is found to.
const AT_REST: f64 = 1e-9;

/// A name and its unit.
type Label<'a> = (String, &'a str);

/// A matrix with its name and the labels of its rows and columns.
type Named<'a> = (&'static str, &'a DMatrix<f64>, Vec<Label<'a>>, Vec<Label<'a>>);

impl StateSpace {
    /// Rates are by the second: they have the units of their states. Of inputs that are held the rows are states of the next instant.
    fn matrices(&self, held: bool) -> [Named<'_>; 4] {
        fn labels(signals: &[StateSpaceSignal]) -> Vec<Label<'_>> {
            signals.iter().map(|signal| (signal.name.clone(), &*signal.unit.si)).collect()
        }
        let row = |name| if held { format!("next({name})") } else { format!("d({name})/dt") };
        let rates = || labels(&self.states).into_iter().map(|(name, si)| (row(name), si)).collect();
        let (states, inputs, outputs) = (labels(&self.states), labels(&self.inputs), labels(&self.outputs));
        [
            ("A", &self.a, rates(), states.clone()),
            ("B", &self.b, rates(), inputs.clone()),
            ("C", &self.c, outputs.clone(), states),
            ("D", &self.d, outputs, inputs),
        ]
    }

    /// The usual sizes of the rows and of the columns of a matrix, where they are those of states.
    fn sizes(&self, matrix: &str) -> [Vec<f64>; 2] {
        let states = || self.states.iter().map(|state| state.size).collect();
        match matrix {
            "A" => [states(), states()],
            "B" => [states(), Vec::new()],
            _ => [Vec::new(), Vec::new()],
        }
    }

    fn data(&self, held: bool) -> Value {
        let rows = |matrix: &DMatrix<f64>| {
            matrix.row_iter().map(|row| row.iter().copied().collect::<Value>()).collect::<Value>()
        };
        let signal = |signal_data: &StateSpaceSignal| json!({"name": signal_data.name, "unit": signal_data.unit.si, "value": signal_data.value});
        let signals = |signals: &[StateSpaceSignal]| signals.iter().map(signal).collect::<Value>();
        let [states, inputs, outputs] = [&self.states, &self.inputs, &self.outputs].map(|list| signals(list));
        let mut data =
            json!({"time": self.time, "states": states, "rates": self.rates, "inputs": inputs, "outputs": outputs});
        for (name, matrix, ..) in self.matrices(held) {
            data[name] = rows(matrix);
        }
        contact_data(&self.statuses, &mut data);
        data
    }

    /// Signals and matrices below the time.
    fn tables(&self, held: bool) -> Vec<Table> {
        let signal = |signal_data: &StateSpaceSignal| {
            row![
                signal_data.name,
                number(signal_data.value, &signal_data.unit.si).within(Noise(ROUNDING)),
                unit(&signal_data.unit.si)
            ]
        };
        let signals = [("states", &self.states), ("inputs", &self.inputs), ("outputs", &self.outputs)];
        let signals = signals.map(|(title, signals)| Table::list(title, signals.iter().map(signal)));
        let rates = self.moves().then(|| self.rate_table());
        let matrices = self.matrices(held).into_iter().filter(|(_, matrix, ..)| !matrix.is_empty());
        let matrices = matrices.map(|(name, matrix, rows, columns)| {
            // Beside pressures, the rates of angles are small numbers in SI.
            let [tall, wide] = self.sizes(name);
            let scale = |row: usize, column: usize| {
                tall.get(row).copied().unwrap_or(1.0) / wide.get(column).copied().unwrap_or(1.0)
            };
            let places = (0..matrix.nrows()).flat_map(|row| (0..matrix.ncols()).map(move |column| (row, column)));
            let share = |(row, column): (usize, usize)| (matrix[(row, column)] / scale(row, column)).abs();
            let most = places.map(share).filter(|share| share.is_finite()).fold(0.0, f64::max);
            let entry = |row: usize, column: usize| {
                let noise = Noise(ROUNDING * most * scale(row, column));
                number(matrix[(row, column)], &per(rows[row].1, columns[column].1)).within(noise)
            };
            let [above, beside] =
                [&columns, &rows].map(|labels| labels.iter().map(|label| &label.0).collect::<Vec<_>>());
            Table::matrix(name, &beside, &above, entry)
        });
        let signals = signals.into_iter().filter(|table| !table.rows.is_empty());
        let shown = signals.chain(rates).chain(contact_tables(&self.statuses)).chain(matrices);
        std::iter::once(Table { heading: Some(at(self.time)), ..Table::default() }).chain(shown).collect()
    }

    /// Is the point one of a motion, not of a rest?
    fn moves(&self) -> bool {
        self.rates.iter().any(|rate| rate.abs() > AT_REST)
    }

    /// What the changes are changes of.
    fn rate_table(&self) -> Table {
        let rate = |(state, rate): (&StateSpaceSignal, &f64)| {
            let si = state.unit.per_second().si;
            row![format!("d({})/dt", state.name), number(*rate, &si).within(Noise(AT_REST)), unit(&si)]
        };
        let title = "the point is not an equilibrium: this dx/dt is added to A x + B u";
        Table::list(title, self.states.iter().zip(&self.rates).map(rate))
    }

    /// One value a line.
    fn entries(&self, held: bool) -> impl Iterator<Item = Vec<Cell>> {
        self.matrices(held).into_iter().flat_map(|(name, matrix, rows, columns)| {
            let entry = |(place, value): (usize, &f64)| {
                let (row, column) = (&rows[place / columns.len()].0, &columns[place % columns.len()].0);
                row![number(self.time, "s"), name, row, column, exact(*value)]
            };
            matrix.transpose().iter().enumerate().map(entry).collect::<Vec<_>>()
        })
    }
}

impl Linearization {
    /// For inputs that are held, each for `step` seconds.
    ///
    /// # Errors
    /// An input's rate counts, which a held input has not, or the numbers leave their range.
    pub fn held(self, step: f64) -> Result<Self, AnalysisFailure> {
        let rate = |signal_data: &&StateSpaceSignal| signal_data.name.contains(")/dt");
        if let Some(rate) = self.points.iter().flat_map(|point| &point.inputs).find(rate) {
            return Err(AnalysisFailure::Followed { input: rate.name.clone() });
        }
        let points = self.points.into_iter().map(|point| point.held(step)).collect::<Result<_, _>>()?;
        Ok(Linearization { points, step: Some(step), ..self })
    }

    /// What the matrices are of.
    fn law(&self) -> &'static str {
        if self.step.is_some() { "x(k+1) = A x(k) + B u(k), y = C x + D u" } else { "dx/dt = A x + B u, y = C x + D u" }
    }

    pub fn report(&self) -> Report {
        let held = self.step.is_some();
        let rows = self.points.iter().flat_map(|point| point.entries(held));
        let mut title = row![format!("{}: {}", self.name, self.law())];
        title.extend(self.points.first().map(|first| at(first.time)));
        Report {
            // The first time stands in the title.
            tables: self.points.iter().flat_map(|point| point.tables(held)).skip(1).collect(),
            sheet: Table::new(row!["time", "matrix", "row", "column", "value"], rows),
            data: self.data(),
            ..Report::new(title)
        }
    }

    /// A script of MATLAB and Octave that gives A, B, C, D and their names, in SI units; none for more points than one.
    pub fn matlab(&self) -> Option<String> {
        let [point] = &self.points[..] else { return None };
        let names = |name: &str, signals: &[StateSpaceSignal]| {
            let listed: Vec<String> =
                signals.iter().map(|signal| format!("'{}'", signal.name.replace('\'', "''"))).collect();
            format!("{name} = {{{}}};\n", listed.join(", "))
        };
        let mut text = format!("% {}: {}; at t = {:?} s, in SI units\n", self.name, self.law(), point.time);
        text += &self.step.map(|step| format!("h = {step:?}; % s from k to k + 1\n")).unwrap_or_default();
        text += &point.statuses.iter().map(|status| format!("% {}\n", status.sentence())).collect::<String>();
        text += &names("states", &point.states);
        text += &names("inputs", &point.inputs);
        text += &names("outputs", &point.outputs);
        for (name, matrix, ..) in point.matrices(self.step.is_some()) {
            let row = |row: usize| matrix.row(row).iter().map(|entry| format!(" {entry:?}")).collect::<String>();
            let rows: Vec<String> = (0..matrix.nrows()).map(row).collect();
            text += &match matrix.is_empty() {
                true => format!("{name} = zeros({}, {});\n", matrix.nrows(), matrix.ncols()),
                false => format!("{name} = [\n{}\n];\n", rows.join("\n")),
            };
        }
        Some(text)
    }

    /// One point is an object with the matrices, more are a list of those.
    fn data(&self) -> Value {
        let held = self.step.is_some();
        let mut value = match self.points.as_slice() {
            [point] => point.data(held),
            points => json!({"points": points.iter().map(|point| point.data(held)).collect::<Value>()}),
        };
        value["name"] = json!(self.name);
        if let Some(step) = self.step {
            value["step"] = json!(step);
        }
        value
    }
}
