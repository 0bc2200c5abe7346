//! The runs of a sweep as a table: a line of names, then a line of values for each run.

use cotree::compile::quantity;
use cotree::export::description::Description;
use cotree::mechanism::Unit;
use cotree::output::csv::{Cells, named};
use cotree::simulate::settings;

use super::factor::{Factor, Values};

/// More faults than these are not listed.
const MOST_FAULTS: usize = 20;

/// A column: what it sets, and the unit of its bare numbers if the header names one.
struct Column {
    factor: Factor,
    unit: Option<Unit>,
    values: Vec<f64>,
}

/// Factors and their values, a column for each.
type Columns = (Vec<Factor>, Vec<Vec<f64>>);

/// The columns of a table.
///
/// # Errors
/// Everything that is wrong with the table, with its lines.
pub fn columns(description: &Description, text: &str) -> Result<Columns, Vec<String>> {
    let cells = Cells::read(text).map_err(|error| vec![error.to_string()])?;
    let Some(((_, names), rows)) = cells.rows.split_first() else {
        return Err(vec!["the table is empty; begin with a line of names".to_owned()]);
    };
    let mut wrong = Vec::new();
    let found: Vec<Option<Column>> =
        names.iter().map(|name| column(description, name).map_err(|message| wrong.push(message)).ok()).collect();
    let mut columns: Vec<Column> = found.into_iter().flatten().collect();
    if columns.len() < names.len() {
        return Err(wrong); // what their values mean is not known
    }
    for (line, fields) in rows {
        if fields.len() != columns.len() {
            wrong.push(format!("line {line}: {} fields, but the header has {}", fields.len(), columns.len()));
            continue;
        }
        for (field, column) in fields.iter().zip(&mut columns) {
            match value(description, &cells.plain(field), column) {
                Ok(value) => column.values.push(value),
                Err(message) => wrong.push(format!("line {line}, `{}`: {message}", column.factor.name)),
            }
        }
    }
    if rows.is_empty() {
        wrong.push("the table has names but no runs".to_owned());
    }
    if wrong.is_empty() {
        return Ok(columns.into_iter().map(|column| (column.factor, column.values)).unzip());
    }
    let more = wrong.len().saturating_sub(MOST_FAULTS);
    wrong.truncate(MOST_FAULTS);
    wrong.extend((more > 0).then(|| format!("and {more} more")));
    Err(wrong)
}

/// The column called `name` or `name [unit]`.
fn column(description: &Description, heading: &str) -> Result<Column, String> {
    let (name, unit) = named(heading)?;
    let variable = settings::settable(description, &name)?;
    let known = &description.variables[variable];
    if let Some(unit) = unit.as_ref().filter(|unit| !known.unit.si.is_empty() && !unit.is_compatible(&known.unit)) {
        return Err(format!("the column `{}` is in {}, not in {}", heading.trim(), unit.shown(), known.unit.si));
    }
    let (name, si) = (known.name.clone(), known.unit.si.clone());
    let factor = Factor { variable, name, unit: si, values: Values::Levels(Vec::new()) };
    Ok(Column { factor, unit, values: Vec::new() })
}

/// A value, SI: a number in the unit of its column, or one with a unit of its own.
fn value(description: &Description, text: &str, column: &Column) -> Result<f64, String> {
    let variable = &description.variables[column.factor.variable];
    let factor = column.unit.as_ref().and_then(|unit| unit.display.as_ref()).map_or(1.0, |display| display.factor);
    let value = match text.parse::<f64>() {
        Ok(number) => number * factor,
        Err(_) => quantity(text, &variable.unit)?,
    };
    settings::permitted(variable, value).map_err(|message| format!("{value:?} {message}"))?;
    Ok(value)
}
