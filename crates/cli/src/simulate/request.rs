//! From the options of the command line to a run.

use cotree::compile;
use cotree::export::description::Description;
use cotree::model::Unit;
use cotree::report::csv::CsvTable;
use cotree::run::{Run, settings};

use super::super::argument::AssignmentError;
use super::super::failure::Failure;
use super::super::times;
use super::SimulateCommand;

/// The run that is asked for.
pub fn run<'a>(
    options: &SimulateCommand,
    description: &'a Description,
    table: Option<&'a CsvTable>,
    reported: Vec<usize>,
) -> Result<Run<'a>, Failure> {
    let inputs = match table {
        Some(table) => Some((table, columns(description, table)?)),
        None => None,
    };
    // A run from equilibrium has them in its scene.
    let settings = options.settings.iter().filter(|_| !options.from_equilibrium);
    let settings: Vec<(usize, f64)> = Failure::every(
        settings.map(|setting| set(description, setting).map_err(|error| format!("--set {setting}: {error}"))),
    )?;
    if let Some((_, columns)) = &inputs
        && let Some((index, _)) = settings.iter().find(|(index, _)| columns.contains(index))
    {
        let name = &description.variables[*index].name;
        return Err(Failure::Usage(format!("`{name}` is given by --set and by the input table")));
    }
    let mut experiment = options.times.experiment(description.experiment)?;
    if let Some(every) = options.every.as_ref().filter(|every| every.parse::<u64>().is_err()) {
        experiment.step = times::seconds("every", every)?;
        times::check(experiment)?;
    }
    Ok(Run { description, experiment, settings, inputs, reported })
}

/// Of how many rows one is reported.
pub fn thinning(options: &SimulateCommand) -> Result<u64, Failure> {
    match options.every.as_deref().map(str::parse::<u64>) {
        Some(Ok(0)) => Err(Failure::Usage("--every: must be at least 1".to_owned())),
        Some(Ok(every)) => Ok(every),
        _ => Ok(1),
    }
}

/// `name=value` as variable and SI value.
fn set(description: &Description, setting: &str) -> Result<(usize, f64), AssignmentError> {
    let (name, value) = setting.split_once('=').ok_or_else(|| AssignmentError("write name=value".to_owned()))?;
    let (name, value) = (name.trim(), value.trim());
    let index = settings::settable(description, name)?;
    let variable = &description.variables[index];
    let value = compile::quantity(value, &variable.unit)?;
    settings::permitted(variable, value)?;
    Ok((index, value))
}

/// The variable of each column of the table.
fn columns(description: &Description, table: &CsvTable) -> Result<Vec<usize>, Failure> {
    let inputs = settings::Inputs::new(description);
    let wrong = |message: String| Failure::Usage(format!("input table: {message}"));
    let column = |(name, unit): (&String, &Option<Unit>)| {
        let index = inputs.find(name).map_err(|error| wrong(error.to_string()))?;
        let input_unit = &description.variables[index].unit;
        match unit {
            Some(unit) if !input_unit.si.is_empty() && !unit.is_compatible(input_unit) => {
                Err(wrong(format!("`{name}` is in `{}`, but the input in `{}`", unit.shown(), input_unit.si)))
            }
            _ => Ok(index),
        }
    };
    table.names().iter().zip(table.units()).map(column).collect()
}
