//! What is asked of a run: values by name, times, inputs over time.

use std::fmt;

use cotree::compile::{QuantityError, quantity};
use cotree::diagnostic::{every, lines};
use cotree::export::description::Description;
use cotree::model::{Experiment, Unit};
use cotree::report::csv::CsvTable;
use cotree::run as simulate;
use cotree::run::{SettingError, settings};
use cotree_study::analysis::SetError;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBool;

use crate::outcome::wrong;

/// A number in SI units, or a text such as `"1.2 m"`.
pub enum Value {
    Number(f64),
    Text(String),
}

impl<'py> FromPyObject<'_, 'py> for Value {
    type Error = PyErr;

    /// Whatever has a value as a float is a number (`Fraction`, `Decimal`, scalars of numpy), but truth values are not: `True` is an error nearly always.
    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let kind = object.get_type();
        if object.is_instance_of::<PyBool>()
            || (kind.module()? == "numpy" && kind.name()?.to_str()?.starts_with("bool"))
        {
            return Err(PyTypeError::new_err(format!("{} is neither a number nor a text with a unit", object.repr()?)));
        }
        match object.extract::<String>() {
            Ok(text) => Ok(Value::Text(text)),
            Err(_) => Ok(Value::Number(object.extract()?)),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(value) => write!(formatter, "{value:?}"),
            Value::Text(text) => formatter.write_str(text),
        }
    }
}

impl Value {
    /// In SI units.
    pub fn read(&self, unit: &Unit) -> Result<f64, QuantityError> {
        match self {
            Value::Number(value) => Ok(*value),
            Value::Text(text) => quantity(text, unit),
        }
    }
}

/// Times and tolerance; what is not given is the scene's.
#[derive(FromPyObject)]
pub struct Times {
    start: Option<Value>,
    stop: Option<Value>,
    step: Option<Value>,
    tolerance: Option<f64>,
    /// Communication points in place of `stop` and `step`.
    at: Option<Vec<f64>>,
}

impl Times {
    /// Together with those of the scene.
    pub fn experiment(&self, scene: Experiment) -> PyResult<Experiment> {
        let second = Unit::time();
        let time = |name: &str, value: &Option<Value>, default: f64| match value {
            Some(value) => value.read(&second).map_err(|message| wrong(format!("{name}: {message}"))),
            None => Ok(default),
        };
        let start = time("start", &self.start, scene.start)?;
        if let Some(at) = &self.at {
            let experiment = self.up_to_last(at, Experiment { start, ..scene })?;
            return possible(experiment);
        }
        let stop = time("stop", &self.stop, scene.stop)?;
        let step = time("step", &self.step, scene.step)?;
        let tolerance = self.tolerance.unwrap_or(scene.tolerance);
        let experiment = Experiment { start, stop, step, tolerance };
        possible(experiment)
    }

    /// An experiment that ends with the last of its communication points.
    fn up_to_last(&self, at: &[f64], scene: Experiment) -> PyResult<Experiment> {
        let start = scene.start;
        let Some(&stop) = at.last() else { return Err(wrong("times: give at least one")) };
        if at.iter().any(|time| !time.is_finite() || *time < start) || !at.is_sorted() {
            return Err(wrong(format!("times: must be increasing, from the start, {start:?} s, on")));
        }
        // Nothing is reported by steps.
        let step = if stop > start { stop - start } else { scene.step };
        Ok(Experiment { start, stop, step, tolerance: self.tolerance.unwrap_or(scene.tolerance) })
    }

    /// The communication points of an experiment.
    pub fn points(&self, experiment: Experiment) -> Vec<f64> {
        self.at.clone().unwrap_or_else(|| simulate::points(experiment).collect())
    }
}

/// The experiment, if a run can have its times and its tolerance.
fn possible(experiment: Experiment) -> PyResult<Experiment> {
    match simulate::check(experiment) {
        Ok(()) => Ok(experiment),
        Err((name, message)) => Err(wrong(format!("{name}: {message}"))),
    }
}

/// One of the words that an option of the command line takes.
pub fn word<T: Copy>(name: &str, text: &str, words: &[(&str, &str, T)]) -> PyResult<T> {
    words.iter().find(|(word, ..)| *word == text).map(|(.., value)| *value).ok_or_else(|| {
        let words: Vec<&str> = words.iter().map(|(word, ..)| *word).collect();
        wrong(format!("{name}: `{text}` is not one of {}", words.join(", ")))
    })
}

/// Variables and their values, checked against their bounds.
pub fn settings(description: &Description, values: &[(String, Value)]) -> PyResult<Vec<(usize, f64)>> {
    let setting = |(name, value): &(String, Value)| -> Result<(usize, f64), SetError> {
        let index = settings::settable(description, name)?;
        let variable = &description.variables[index];
        let value = value.read(&variable.unit)?;
        settings::permitted(variable, value).map_err(|cause| SettingError::of_value(value, &cause))?;
        Ok((index, value))
    };
    let settings = values.iter().map(|value| setting(value).map_err(|message| format!("{}: {message}", value.0)));
    every(settings).map_err(|faults| wrong(lines(&faults)))
}

/// Inputs over time: times, names, columns.
pub type Columns = (Vec<f64>, Vec<String>, Vec<Vec<f64>>);

/// The table and the variable of each column.
pub fn inputs(
    description: &Description,
    columns: Option<Columns>,
    settings: &[(String, Value)],
) -> PyResult<Option<(CsvTable, Vec<usize>)>> {
    let Some((times, names, columns)) = columns else { return Ok(None) };
    apart(&names, settings)?;
    let known = settings::Inputs::new(description);
    let variables: Result<Vec<usize>, SettingError> = names.iter().map(|name| known.find(name)).collect();
    let variables = variables.map_err(|message| wrong(format!("inputs: {message}")))?;
    Ok(Some((table(names, times, columns)?, variables)))
}

/// No input is given twice.
pub fn apart(names: &[String], settings: &[(String, Value)]) -> PyResult<()> {
    match names.iter().find(|name| settings.iter().any(|(set, _)| set == *name)) {
        Some(name) => Err(wrong(format!("inputs: `{name}` is given by `set`, too"))),
        None => Ok(()),
    }
}

/// Inputs over time as a table.
pub fn table(names: Vec<String>, times: Vec<f64>, columns: Vec<Vec<f64>>) -> PyResult<CsvTable> {
    CsvTable::new(names, times, columns).map_err(|message| wrong(format!("inputs: {message}")))
}
