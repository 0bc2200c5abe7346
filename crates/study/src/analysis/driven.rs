//! Inputs as functions of time in analysed motions.

use cotree::diagnostic::suggest;
use cotree::model::{Mechanism, Unit};
use cotree::report::csv::CsvTable;
use cotree::run::{SettingError, knots, set_inputs};
use cotree_fmu::instance::{Instance, InstanceError};
use thiserror::Error;

/// Why a table gives no inputs over time.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct InputTableError(pub String);

cotree::diagnostic::from_messages!(InputTableError as InputTableError: SettingError);

/// Inputs over time: linear between the rows of a table, constant before and after it. Without columns all inputs stay as they are.
#[derive(Clone, Debug, Default)]
pub(super) struct DrivenInputs {
    table: Option<CsvTable>,
    /// The input of each column.
    inputs: Vec<usize>,
}

/// A row of a column of inputs over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct InputRow {
    /// The input.
    pub input: usize,
    column: usize,
    row: usize,
}

impl DrivenInputs {
    /// # Errors
    /// A column that is no input, or in another kind of unit.
    pub fn new(mechanism: &Mechanism, table: CsvTable) -> Result<Self, InputTableError> {
        let names = || mechanism.inputs.iter().map(|input| input.name.as_str());
        let place = |(name, unit): (&String, &Option<Unit>)| {
            let unknown = || {
                SettingError(format!("the scene has no input `{name}`; {known}", known = suggest::known(name, names())))
            };
            let place = names().position(|candidate| candidate == name).ok_or_else(unknown)?;
            let input_unit = &mechanism.inputs[place].unit;
            match unit.as_ref().filter(|unit| !input_unit.si.is_empty() && !unit.is_compatible(input_unit)) {
                Some(unit) => Err(InputTableError(format!(
                    "`{input}` is in `{unit}`, but the input in `{si}`",
                    input = name,
                    unit = unit.shown(),
                    si = input_unit.si
                ))),
                None => Ok(place),
            }
        };
        let inputs = table.names().iter().zip(table.units()).map(place).collect::<Result<_, _>>()?;
        Ok(Self { inputs, table: Some(table) })
    }

    /// The inputs that are given over time.
    pub fn inputs(&self) -> &[usize] {
        &self.inputs
    }

    /// The row that a name such as `push[3]` means, from 0 on; none if it is not that of an input over time.
    pub fn row(&self, name: &str) -> Option<Result<InputRow, SettingError>> {
        let table = self.table.as_ref()?;
        let (input, index) = name.strip_suffix(']')?.split_once('[')?;
        let column = table.names().iter().position(|known| known == input)?;
        let (rows, input) = (table.times().len(), self.inputs[column]);
        let row = index.parse().ok().filter(|&row| row < rows).ok_or_else(|| {
            SettingError(format!(
                "`{name}`: the table of inputs has the rows 0 to {last}",
                last = rows.saturating_sub(1)
            ))
        });
        Some(row.map(|row| InputRow { input, column, row }))
    }

    /// Its value \[SI\].
    pub fn row_value(&self, row: InputRow) -> f64 {
        self.table.as_ref().and_then(|table| table.column(row.column).get(row.row)).copied().unwrap_or(f64::NAN)
    }

    pub fn set_row(&mut self, row: InputRow, value: f64) {
        if let Some(table) = &mut self.table {
            table.set(row.column, row.row, value);
        }
    }

    /// How the input and its rate change with the value of a row, from a time on; `stops` as in [`DrivenInputs::set`].
    pub fn share(&self, row: InputRow, time: f64, stops: bool) -> [f64; 2] {
        self.table.as_ref().map_or([0.0; 2], |table| table.share(row.row, time, stops))
    }

    /// When they bend or jump: after the start of a motion and up to its end \[s\].
    pub fn knots(&self, span: [f64; 2]) -> Vec<f64> {
        self.table.as_ref().map_or_else(Vec::new, |table| knots(table, span))
    }

    /// Sets them at the start of a motion or at one of their knots; where the motion stops nothing follows, and rates are those of the way there, as in a simulation that stops there.
    ///
    /// # Errors
    /// A value that is out of bounds.
    pub fn set(&self, motion: &mut Instance, time: f64, stops: bool) -> Result<(), InstanceError> {
        let Some(table) = &self.table else { return Ok(()) };
        let program = motion.model().program();
        let variable = |&input: &usize| {
            let name = &program.inputs[input].name;
            program.variables.iter().position(|variable| variable.name == *name).unwrap_or(program.variables.len())
        };
        let variables: Vec<usize> = self.inputs.iter().map(variable).collect();
        set_inputs(motion, (table, &variables), time, stops)
    }
}
