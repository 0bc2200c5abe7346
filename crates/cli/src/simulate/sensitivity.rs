//! `cotree simulate --sensitivity`: outputs and their derivatives.

use cotree::compile;
use cotree::output::csv::Writer;
use cotree::scene::Scene;
use cotree::simulate::points;
use cotree_study::analysis::Study;
use cotree_study::analysis::report::{Report, Style};

use super::super::failure::Failure;
use super::super::output::{self, Output};
use super::super::{MessageFormat, study};
use super::{Simulate, asked};

/// Writes a table with a column for each variable, and one for each derivative.
pub fn run(options: &Simulate, scene: Scene, format: MessageFormat) -> Result<(), Failure> {
    let crossed = options.crossing.iter().filter_map(|text| text.split('=').next()).map(str::trim);
    let scene = crossed.fold(asked::with_these_outputs(options, scene), asked::with_output);
    let mut study = study::with_settings(&scene, &options.settings)?;
    let experiment = options.times.experiment(study.experiment())?;
    study.set_experiment(experiment);
    let times: Vec<f64> = points(experiment).collect();
    if options.summary {
        return features(options, study, &times, format);
    }
    let found = study.sensitivities(&options.sensitivity, &times);
    output::warn(study.take_warnings().as_ref(), format);
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
    output::finish(writer, options.file())
}

/// Prints peaks and crossings with their derivatives.
fn features(options: &Simulate, mut study: Study, times: &[f64], format: MessageFormat) -> Result<(), Failure> {
    let level = |text: &String| {
        let wrong = |message: String| Failure::Usage(format!("--crossing {text}: {message}"));
        let (name, value) = text.split_once('=').ok_or_else(|| wrong("write name=value".to_owned()))?;
        let (name, value) = (name.trim().to_owned(), value.trim());
        let unit = study.output_unit(&name).ok_or_else(|| wrong("there is no such variable".to_owned()))?;
        Ok((name, compile::quantity(value, unit).map_err(wrong)?))
    };
    let levels = options.crossing.iter().map(level).collect::<Result<Vec<_>, Failure>>()?;
    let found = study.features(&options.sensitivity, times, &levels);
    output::warn(study.take_warnings().as_ref(), format);
    let text = found?.write(if options.json { Style::Json } else { Style::Text });
    output::put(options.file(), &text)
}
