//! The runs of a sweep as a table: a line of names, then a line of values for each run.

use cotree::compile::quantity;
use cotree::export::description::Description;
use cotree::model::Unit;
use cotree::run::{SettingError, settings};
use cotree::sheet::{Heading, Sheet, SheetError};

use super::design::DesignError;
use super::factor::{DesignFactor, FactorError, FactorValues};

/// More faults than these are not listed.
const MOST_FAULTS: usize = 20;

/// A column: what it sets, and the unit of its bare numbers if the header names one.
struct FactorColumn {
    factor: DesignFactor,
    unit: Option<Unit>,
    values: Vec<f64>,
}

/// Factors and their values, a column for each.
type Columns = (Vec<DesignFactor>, Vec<Vec<f64>>);

/// The columns of a table.
///
/// # Errors
/// Everything that is wrong with the table, with its lines.
pub fn columns(description: &Description, text: &str) -> Result<Columns, Vec<DesignError>> {
    let sheet = Sheet::read(text).map_err(|error| vec![error.into()])?;
    let headings = sheet.headings();
    if headings.is_empty() {
        return Err(vec![DesignError("the first line of the table must have the names".to_owned())]);
    }
    let (mut wrong, units) = (Vec::new(), description.units());
    let read = |heading: &Heading| {
        column(description, heading.of_variable(|name| units.get(name).copied().cloned()), &heading.text)
    };
    let found: Vec<Option<FactorColumn>> =
        headings.iter().map(|heading| read(heading).map_err(|error| wrong.push(error)).ok()).collect();
    let mut columns: Vec<FactorColumn> = found.into_iter().flatten().collect();
    if columns.len() < headings.len() {
        return Err(wrong); // what their values mean is not known
    }
    for row in 0..sheet.rows() {
        let line = sheet.line(row);
        if let Err(cause) = sheet.has_cells(row, columns.len()) {
            wrong.push(DesignError(format!("line {line}: {}", cause.message)));
            continue;
        }
        for (place, column) in columns.iter_mut().enumerate() {
            match value(description, &sheet.cell(row, place), column) {
                Ok(value) => column.values.push(value),
                Err(cause) => {
                    wrong.push(DesignError(format!("line {line}, `{name}`: {cause}", name = column.factor.name)))
                }
            }
        }
    }
    if sheet.rows() == 0 {
        wrong.push(DesignError("the table has names but no runs".to_owned()));
    }
    if wrong.is_empty() {
        return Ok(columns.into_iter().map(|column| (column.factor, column.values)).unzip());
    }
    let more = wrong.len().saturating_sub(MOST_FAULTS);
    wrong.truncate(MOST_FAULTS);
    wrong.extend((more > 0).then_some(DesignError(format!("and {more} more"))));
    Err(wrong)
}

/// The column of a variable, from its name and unit.
fn column(
    description: &Description,
    named: Result<(String, Option<Unit>), SheetError>,
    heading: &str,
) -> Result<FactorColumn, DesignError> {
    let (name, unit) = named?;
    let variable = settings::settable(description, &name).map_err(FactorError::from)?;
    let known = &description.variables[variable];
    if let Some(unit) = unit.as_ref().filter(|unit| !known.unit.si.is_empty() && !unit.is_compatible(&known.unit)) {
        let (column, unit, si) = (heading.to_owned(), unit.shown().to_owned(), known.unit.si.clone());
        return Err(DesignError(format!("the column `{column}` is in {unit}, not in {si}")));
    }
    let (name, si) = (known.name.clone(), known.unit.si.clone());
    let factor = DesignFactor { variable, name, unit: si, values: FactorValues::Levels(Vec::new()) };
    Ok(FactorColumn { factor, unit, values: Vec::new() })
}

/// A value, SI: a number in the unit of its column, or one with a unit of its own.
fn value(description: &Description, text: &str, column: &FactorColumn) -> Result<f64, FactorError> {
    let variable = &description.variables[column.factor.variable];
    let factor = column.unit.as_ref().and_then(|unit| unit.display.as_ref()).map_or(1.0, |display| display.factor);
    let value = match text.parse::<f64>() {
        Ok(number) => number * factor,
        Err(_) => quantity(text, &variable.unit)?,
    };
    settings::permitted(variable, value).map_err(|cause| SettingError::of_value(value, &cause))?;
    Ok(value)
}
