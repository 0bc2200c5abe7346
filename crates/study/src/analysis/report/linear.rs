//! Linear systems at one or many points.

use cotree::output::report::Accuracy::Noise;
use cotree::output::report::{Cell, ROUNDING, Report, Table, number, per, unit};
use cotree::row;
use nalgebra::DMatrix;
use serde_json::{Value, json};

use super::{at, exact};
use crate::analysis::{Signal, StateSpace};

#[derive(Clone, Debug)]
pub struct Linearization {
    pub name: String,
    pub points: Vec<StateSpace>,
}

/// A name and its unit.
type Label<'a> = (String, &'a str);

/// A matrix with its name and the labels of its rows and columns.
type Named<'a> = (&'static str, &'a DMatrix<f64>, Vec<Label<'a>>, Vec<Label<'a>>);

impl StateSpace {
    /// Rates are by the second: they have the units of their states.
    fn matrices(&self) -> [Named<'_>; 4] {
        fn labels(signals: &[Signal]) -> Vec<Label<'_>> {
            signals.iter().map(|own| (own.name.clone(), &*own.unit.si)).collect()
        }
        let rates = || labels(&self.states).into_iter().map(|(name, si)| (format!("d({name})/dt"), si)).collect();
        let (states, inputs, outputs) = (labels(&self.states), labels(&self.inputs), labels(&self.outputs));
        [
            ("A", &self.a, rates(), states.clone()),
            ("B", &self.b, rates(), inputs.clone()),
            ("C", &self.c, outputs.clone(), states),
            ("D", &self.d, outputs, inputs),
        ]
    }

    fn data(&self) -> Value {
        let rows = |matrix: &DMatrix<f64>| {
            matrix.row_iter().map(|row| row.iter().copied().collect::<Value>()).collect::<Value>()
        };
        let signal = |own: &Signal| json!({"name": own.name, "unit": own.unit.si, "value": own.value});
        let signals = |signals: &[Signal]| signals.iter().map(signal).collect::<Value>();
        let [states, inputs, outputs] = [&self.states, &self.inputs, &self.outputs].map(|own| signals(own));
        let mut data = json!({"time": self.time, "states": states, "inputs": inputs, "outputs": outputs});
        for (name, matrix, ..) in self.matrices() {
            data[name] = rows(matrix);
        }
        data
    }

    /// Signals and matrices below the time.
    fn tables(&self) -> Vec<Table> {
        let signal =
            |own: &Signal| row![own.name, number(own.value, &own.unit.si).within(Noise(ROUNDING)), unit(&own.unit.si)];
        let signals = [("states", &self.states), ("inputs", &self.inputs), ("outputs", &self.outputs)];
        let signals = signals.map(|(title, signals)| Table::list(title, signals.iter().map(signal)));
        let matrices = self.matrices().into_iter().filter(|(_, matrix, ..)| !matrix.is_empty());
        let matrices = matrices.map(|(name, matrix, rows, columns)| {
            let noise = Noise(ROUNDING * matrix.amax());
            let entry = |row: usize, column: usize| {
                number(matrix[(row, column)], &per(rows[row].1, columns[column].1)).within(noise)
            };
            let [above, beside] = [&columns, &rows].map(|labels| labels.iter().map(|own| &own.0).collect::<Vec<_>>());
            Table::matrix(name, &beside, &above, entry)
        });
        let shown = signals.into_iter().filter(|table| !table.rows.is_empty()).chain(matrices);
        std::iter::once(Table { heading: Some(at(self.time)), ..Table::default() }).chain(shown).collect()
    }

    /// One value a line.
    fn entries(&self) -> impl Iterator<Item = Vec<Cell>> {
        self.matrices().into_iter().flat_map(|(name, matrix, rows, columns)| {
            let entry = |(place, value): (usize, &f64)| {
                let (row, column) = (&rows[place / columns.len()].0, &columns[place % columns.len()].0);
                row![number(self.time, "s"), name, row, column, exact(*value)]
            };
            matrix.transpose().iter().enumerate().map(entry).collect::<Vec<_>>()
        })
    }
}

impl Linearization {
    pub fn report(&self) -> Report {
        let rows = self.points.iter().flat_map(StateSpace::entries);
        let mut title = row![format!("{}: dx/dt = A x + B u, y = C x + D u", self.name)];
        title.extend(self.points.first().map(|first| at(first.time)));
        Report {
            // The first time stands in the title.
            tables: self.points.iter().flat_map(StateSpace::tables).skip(1).collect(),
            sheet: Table::new(row!["time", "matrix", "row", "column", "value"], rows),
            data: self.data(),
            ..Report::new(title)
        }
    }

    /// One point is an object with the matrices, more are a list of those.
    fn data(&self) -> Value {
        match self.points.as_slice() {
            [point] => {
                let mut value = point.data();
                value["name"] = json!(self.name);
                value
            }
            points => json!({"name": self.name, "points": points.iter().map(StateSpace::data).collect::<Value>()}),
        }
    }
}
