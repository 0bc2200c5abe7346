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
