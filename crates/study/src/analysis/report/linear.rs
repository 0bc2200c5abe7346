//! Linear systems at one or many points.

use cotree::cells;
use cotree::mechanism::Units;
use nalgebra::DMatrix;
use serde_json::{Value, json};

use super::{Report, Table, at, csv, exact, largest, number, page};
use crate::analysis::{Signal, StateSpace};

#[derive(Clone, Debug)]
pub struct Linearization {
    pub name: String,
    pub points: Vec<StateSpace>,
}

/// A matrix with its name and the names of its rows and columns.
type Named<'a> = (&'static str, &'a DMatrix<f64>, Vec<String>, Vec<String>);

impl StateSpace {
    fn matrices(&self) -> [Named<'_>; 4] {
        let names = |signals: &[Signal]| signals.iter().map(|signal| signal.name.clone()).collect::<Vec<_>>();
        let rates = || self.states.iter().map(|signal| format!("d({})/dt", signal.name)).collect::<Vec<_>>();
        let (states, inputs, outputs) = (names(&self.states), names(&self.inputs), names(&self.outputs));
        [
            ("A", &self.a, rates(), states.clone()),
            ("B", &self.b, rates(), inputs.clone()),
            ("C", &self.c, outputs.clone(), states),
            ("D", &self.d, outputs, inputs),
        ]
    }

    /// For states, inputs and outputs in these units; rates are by the second.
    fn in_units(&self, units: &Units) -> StateSpace {
        let factors = |signals: &[Signal]| signals.iter().map(|own| units.of(&own.unit).factor).collect::<Vec<_>>();
        let [x, u, y] = [&self.states, &self.inputs, &self.outputs].map(|signals| factors(signals));
        let scaled = |matrix: &DMatrix<f64>, rows: &[f64], columns: &[f64]| {
            DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
                matrix[(row, column)] * columns[column] / rows[row]
            })
        };
        let [a, b] = [(&self.a, &x), (&self.b, &u)].map(|(matrix, columns)| scaled(matrix, &x, columns));
        let [c, d] = [(&self.c, &x), (&self.d, &u)].map(|(matrix, columns)| scaled(matrix, &y, columns));
        StateSpace { a, b, c, d, ..self.clone() }
    }

    fn json(&self) -> Value {
        let rows = |matrix: &DMatrix<f64>| {
            matrix.row_iter().map(|row| row.iter().copied().collect::<Value>()).collect::<Value>()
        };
        let signal = |own: &Signal| json!({"name": own.name, "unit": own.unit.si, "value": own.value});
        let signals = |signals: &[Signal]| signals.iter().map(signal).collect::<Value>();
        json!({
            "time": self.time,
            "states": signals(&self.states),
            "inputs": signals(&self.inputs),
            "outputs": signals(&self.outputs),
            "A": rows(&self.a),
            "B": rows(&self.b),
            "C": rows(&self.c),
            "D": rows(&self.d),
        })
    }

    fn text(&self, units: &Units) -> String {
        let line = |signal: &Signal| {
            let unit = units.of(&signal.unit);
            cells![signal.name, number(signal.value / unit.factor, 1.0 / unit.factor), unit.name]
        };
        let signals = [("states", &self.states), ("inputs", &self.inputs), ("outputs", &self.outputs)];
        let signals = signals.map(|(title, signals)| (title, signals.iter().map(line).collect()));
        let matrices = self.matrices().into_iter().filter(|(_, matrix, ..)| !matrix.is_empty());
        let matrices = matrices.map(|(name, matrix, rows, columns)| {
            let largest = largest(matrix.iter());
            let mut lines = vec![[cells![name], columns].concat()];
            for (row, label) in matrix.row_iter().zip(rows) {
                lines.push([label].into_iter().chain(row.iter().map(|&value| number(value, largest))).collect());
            }
            ("", lines)
        });
        let tables = signals.into_iter().chain(matrices).filter(|(_, rows): &Table| !rows.is_empty());
        page(&at(self.time, units), tables, "")
    }
}

impl Report for Linearization {
    fn text(&self, units: &Units) -> String {
        let points: Vec<String> = self.points.iter().map(|point| point.in_units(units).text(units)).collect();
        format!("{}: dx/dt = A x + B u, y = C x + D u\n{}", self.name, points.join("\n"))
    }

    /// One point is an object with the matrices, more are a list of those.
    fn json(&self) -> Value {
        match self.points.as_slice() {
            [point] => {
                let mut value = point.json();
                value["name"] = json!(self.name);
                value
            }
            points => json!({"name": self.name, "points": points.iter().map(StateSpace::json).collect::<Value>()}),
        }
    }

    fn csv(&self, _: &Units) -> String {
        let matrices = self.points.iter().flat_map(|own| own.matrices().map(|of| (own.time, of)));
        let lines = matrices.flat_map(|(time, (name, matrix, rows, columns))| {
            let entry = |(place, value): (usize, &f64)| {
                let (row, column) = (&rows[place / columns.len()], &columns[place % columns.len()]);
                cells![exact(time), name, row, column, exact(*value)]
            };
            matrix.transpose().iter().enumerate().map(entry).collect::<Vec<_>>()
        });
        csv("time,matrix,row,column,value", lines)
    }
}
