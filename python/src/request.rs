//! What is asked of a run: values by name, times, inputs over time.

use cotree::compile::quantity;
use cotree::export::description::Description;
use cotree::mechanism::{Experiment, Unit};
use cotree::output::csv::Table;
use cotree::simulate::{self, settings};
use pyo3::prelude::*;

use crate::outcome::wrong;

/// More values than this at one go are a mistake in `step` or `stop`.
const MOST_POINTS: u64 = 100_000_000;

/// A number in SI units, or a text such as `"1.2 m"`.
#[derive(FromPyObject)]
pub enum Value {
    Number(f64),
    Text(String),
}

impl Value {
    /// In SI units.
    pub fn read(&self, unit: &Unit) -> Result<f64, String> {
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
        let stop = time("stop", &self.stop, scene.stop)?;
        let step = time("step", &self.step, scene.step)?;
        let tolerance = self.tolerance.unwrap_or(scene.tolerance);
        let experiment = Experiment { start, stop, step, tolerance };
        if !start.is_finite() || !stop.is_finite() || stop < start {
            return Err(wrong(format!("stop: {stop:?} s is not after the start, {start:?} s")));
        }
        if !(step > 0.0 && step.is_finite()) {
            return Err(wrong(format!("step: {step:?} s is not above zero")));
        }
        if simulate::count(experiment) > MOST_POINTS {
            return Err(wrong(format!("step: {step:?} s up to {stop:?} s gives more than {MOST_POINTS} points")));
        }
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(wrong(format!("tolerance: {tolerance:?} is not between 0 and 1")));
        }
        Ok(experiment)
    }
}

/// Variables and their values, checked against their bounds.
pub fn settings(description: &Description, values: &[(String, Value)]) -> PyResult<Vec<(usize, f64)>> {
    let setting = |(name, value): &(String, Value)| {
        let index = settings::settable(description, name)?;
        let variable = &description.variables[index];
        let value = value.read(&variable.unit)?;
        settings::permitted(variable, value).map_err(|message| format!("{value:?} {message}"))?;
        Ok((index, value))
    };
    values
        .iter()
        .map(|value| setting(value).map_err(|message: String| wrong(format!("{}: {message}", value.0))))
        .collect()
}

/// Inputs over time: times, names, columns.
pub type Columns = (Vec<f64>, Vec<String>, Vec<Vec<f64>>);

/// The table and the variable of each column.
pub fn inputs(description: &Description, columns: Option<Columns>) -> PyResult<Option<(Table, Vec<usize>)>> {
    let Some((times, names, columns)) = columns else { return Ok(None) };
    let known = settings::Inputs::new(description);
    let variables: Result<Vec<usize>, String> = names.iter().map(|name| known.find(name)).collect();
    let variables = variables.map_err(|message| wrong(format!("inputs: {message}")))?;
    let table = Table::new(names, times, columns).map_err(|message| wrong(format!("inputs: {message}")))?;
    Ok(Some((table, variables)))
}
