//! Results of a simulation: the reported variables by name, with their units.

use std::io::{self, Write};
use std::sync::Arc;

use cotree_fmu::instance::{Inaccuracy, Instance};
use cotree_fmu::model::Model;

use super::{Finish, Run, RunError, SettingError};
use crate::compile::{Compiled, compile};
use crate::diagnostic::{Faults, lines};
use crate::report::csv::CsvWriter;
use crate::scene::Scene;

/// Variables over time, in SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Results {
    times: Vec<f64>,
    columns: Vec<Column>,
    finish: Finish,
}

/// One variable over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The variable's name, such as `rod.angle`.
    pub name: String,
    /// Its SI unit, such as `rad/s`; empty if it has none or none is known.
    pub unit: String,
    /// Its value at each of [`Results::times`]; NaN where it has none, such as a quotient with nothing below.
    pub values: Vec<f64>,
}

/// Why there are no results.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// The scene is at fault.
    #[error(transparent)]
    Scene(#[from] Faults),
    /// The motion cannot be found or continued.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Names or values that a run cannot be given.
    #[error("{}", lines(.0))]
    Settings(Vec<SettingError>),
}

impl Results {
    /// Those of a scene, before anything is known.
    pub(super) fn of(compiled: &Compiled) -> Self {
        let variables = compiled.reported().into_iter().map(|index| &compiled.description.variables[index]);
        let column = |name: &str, unit: &str| Column { name: name.into(), unit: unit.into(), values: Vec::new() };
        let columns = variables.map(|variable| column(&variable.name, &variable.unit.si)).collect();
        Results { times: Vec::new(), columns, finish: Finish::default() }
    }

    /// Adds a communication point.
    pub(super) fn push(&mut self, time: f64, values: &[f64]) {
        self.times.push(time);
        self.columns.iter_mut().zip(values).for_each(|(column, &value)| column.values.push(value));
    }

    /// The same with how the run ended.
    pub(super) fn with(self, finish: Finish) -> Self {
        Results { finish, ..self }
    }

    /// Communication points \[s\]: start, every full step, and stop.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// All variables, in the order of the scene's outputs.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The variable of that name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The values of the variable of that name, one for each of [`Results::times`].
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        self.column(name).map(|column| column.values.as_slice())
    }

    /// That rounding errors are larger than the tolerance, if they are.
    pub fn inaccuracy(&self) -> Option<&Inaccuracy> {
        self.finish.inaccuracy.as_ref()
    }

    /// How often the events of the scene have happened, and whether one has ended the run.
    pub fn finish(&self) -> &Finish {
        &self.finish
    }

    /// Writes a table as `cotree simulate` does: CSV, `time` first.
    ///
    /// # Errors
    /// `out` cannot be written.
    pub fn write_csv(&self, out: impl Write) -> io::Result<()> {
        let names = self.columns.iter().map(|column| column.name.as_str());
        let mut writer = CsvWriter::new(out, ["time"].into_iter().chain(names).map(|name| (name, 1.0)))?;
        for (index, time) in self.times.iter().enumerate() {
            writer.row([time].into_iter().chain(self.columns.iter().map(|column| &column.values[index])))?;
        }
        writer.finish().map(drop)
    }
}

impl Compiled {
    /// The outputs that have no value at the start of the motion; none if there is no start.
    pub fn without_value_at_start(&self) -> Vec<&str> {
        let start = self.description.experiment.start;
        let mut missing = Vec::new();
        let begun = Model::new(self.program.clone()).map_err(RunError::from).and_then(|model| {
            let mut instance = Instance::new(Arc::new(model));
            instance.setup(start, None, None)?;
            Ok(instance.initialise().map(|()| instance)?)
        });
        if let Ok(mut instance) = begun {
            let variables = self.reported().into_iter();
            missing.extend(variables.filter(|&index| instance.reading(index).is_ok_and(f64::is_nan)));
        }
        missing.into_iter().map(|index| self.description.variables[index].name.as_str()).collect()
    }

    /// Runs the experiment of the scene with the code that runs in the FMU.
    ///
    /// # Errors
    /// The motion cannot be found or continued.
    pub fn simulate(&self) -> Result<Results, RunError> {
        let mut results = Results::of(self);
        let finish = self.run(|time, values| {
            results.push(time, values);
            Ok(())
        })?;
        Ok(results.with(finish))
    }

    /// The same, handing over time and the values of [`Compiled::reported`] at every communication point as they come.
    ///
    /// # Errors
    /// The motion cannot be found or continued, or `report` fails.
    pub fn run(&self, report: impl FnMut(f64, &[f64]) -> io::Result<()>) -> Result<Finish, RunError> {
        let model = Arc::new(Model::new(self.program.clone())?);
        let (experiment, reported) = (self.description.experiment, self.reported());
        Run { description: &self.description, experiment, settings: Vec::new(), inputs: None, reported }
            .start(model, report)
    }
}

impl Scene {
    /// Runs the experiment of the scene with the code that runs in its FMU.
    ///
    /// # Errors
    /// Everything that is wrong with the scene, or a motion that cannot be found or continued.
    pub fn simulate(&self) -> Result<Results, SimulateError> {
        Ok(compile(self)?.simulate()?)
    }
}
