//! `cotree simulate --sensitivity`: outputs and their derivatives.

use super::super::failure::Failure;
use super::super::output::{self, Output};
use super::super::{MessageFormat, study};
use super::{Simulate, asked};
use crate::output::csv::Writer;
use crate::scene::Scene;
use crate::simulate::points;

/// Writes a table with a column for each variable, and one for each derivative.
pub fn run(options: &Simulate, scene: Scene, format: MessageFormat) -> Result<(), Failure> {
    let scene = asked::with_outputs(options, scene);
    let mut study = study::with_settings(&scene, &options.settings)?;
    let experiment = options.times.experiment(study.experiment())?;
    study.set_experiment(experiment);
    let times: Vec<f64> = points(experiment).collect();
    let found = study.sensitivities(&options.sensitivity, &times);
    if let Some(warnings) = study.take_warnings() {
        output::warn(&warnings, format);
    }
    let found = found?;
    let outputs = || found.outputs.iter().map(|(name, _)| name);
    let derivatives = found.parameters.iter().flat_map(|(to, _)| outputs().map(move |of| format!("d({of})/d({to})")));
    let names: Vec<String> = outputs().cloned().chain(derivatives).collect();
    let mut writer = Writer::new(Output::new(options.file())?, names.iter().map(String::as_str))?;
    for (&time, (values, derivatives)) in found.times.iter().zip(found.values.iter().zip(&found.derivatives)) {
        // By columns: all derivatives by a parameter stand together.
        let row: Vec<f64> = values.iter().chain(derivatives.iter()).copied().collect();
        writer.row(time, &row)?;
    }
    let named = |error| match options.file() {
        Some(path) => Failure::file("write", path, error),
        None => Failure::from(error),
    };
    writer.finish().map_err(named)?.commit().map_err(named)
}
