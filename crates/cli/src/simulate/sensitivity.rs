//! `cotree simulate --sensitivity`: outputs and their derivatives.

use cotree::compile;
use cotree::model::Units;
use cotree::report::data::{composed, per};
use cotree::run::{Gaps, points};
use cotree::scene::Scene;
use cotree::typeset::titled;
use cotree_study::analysis::{Sensitivities, Study};

use super::super::failure::Failure;
use super::super::{MessageFormat, output, study};
use super::{SimulateCommand, requested};

/// Writes a table with a column for each variable, and one for each derivative.
pub fn run(options: &SimulateCommand, scene: &Scene, format: MessageFormat) -> Result<(), Failure> {
    let mut study = study::asking(scene, &requested::derived(options, scene), &options.settings)?;
    let experiment = options.times.experiment(study.experiment())?;
    study.set_experiment(experiment);
    let times: Vec<f64> = points(experiment).collect();
    if options.summary {
        return features(options, study, &times, format);
    }
    let found = study.sensitivities(&options.sensitivity, &times);
    output::warn(study.take_warnings().as_ref(), format);
    let found = found?;
    let mut gaps = Gaps::default();
    let mut writer = output::begin(options.file(), columns(&found, study.display()))?;
    for (time, (values, derivatives)) in found.times.iter().zip(found.values.iter().zip(&found.derivatives)) {
        // By columns: all derivatives by a parameter stand together.
        let row: Vec<f64> = values.iter().chain(derivatives.iter()).copied().collect();
        gaps.note(*time, &row);
        writer.row([time].into_iter().chain(&row))?;
    }
    output::finish(writer, options.file())?;
    let names = columns(&found, &Units::default());
    let names: Vec<&str> = names.iter().skip(1).map(|(name, _)| name.as_str()).collect();
    output::warn_gaps(scene, &gaps, &names, format);
    Ok(())
}

/// The columns of the table, by the units that they are shown in: derivatives stand after the values.
fn columns(found: &Sensitivities, units: &Units) -> Vec<(String, f64)> {
    let is_si = *units == Units::default();
    let column = |name: String, si: &str| {
        let unit = composed(units, si);
        (if is_si { name } else { titled(&name, &unit.name) }, unit.factor)
    };
    let mut columns = vec![column("time".to_owned(), "s")];
    columns.extend(found.outputs.iter().map(|(name, si)| column(name.clone(), si)));
    for (to, by) in &found.parameters {
        columns.extend(found.outputs.iter().map(|(of, si)| column(format!("d({of})/d({to})"), &per(si, by))));
    }
    columns
}

/// Prints peaks and crossings with their derivatives.
fn features(options: &SimulateCommand, mut study: Study, times: &[f64], format: MessageFormat) -> Result<(), Failure> {
    let level = |text: &String| {
        let wrong = |message: String| Failure::Usage(format!("--crossing {text}: {message}"));
        let (name, value) = text.split_once('=').ok_or_else(|| wrong("write name=value".to_owned()))?;
        let (name, value) = (name.trim().to_owned(), value.trim());
        let unit = study.output_unit(&name).ok_or_else(|| wrong("there is no such variable".to_owned()))?;
        Ok((name, compile::quantity(value, unit).map_err(|error| wrong(error.to_string()))?))
    };
    let levels = options.crossing.iter().map(level).collect::<Result<Vec<_>, Failure>>()?;
    let found = study.features(&options.sensitivity, times, &levels);
    output::warn(study.take_warnings().as_ref(), format);
    let report = found?.report();
    let text = if options.json { report.json() } else { report.text(study.display()) };
    output::put(options.file(), &text)
}
