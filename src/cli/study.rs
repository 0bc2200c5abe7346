//! What `equilibrium`, `linearize` and `modes` share: the scene with its settings, and where results go.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use super::MessageFormat;
use super::failure::Failure;
use super::output;
use crate::analysis::report::{Report, Style};
use crate::analysis::{self, Equilibrium, Point, Variation, at_rest};
use crate::compile;
use crate::diagnostic::suggest;
use crate::formulate::{Formulated, formulate_written};
use crate::mechanism::{Mechanism, Unit};
use crate::scene::{Faults, Scene};

/// The scene, its settings, and the form of the result.
#[derive(Args)]
pub struct Study {
    /// Scene file (TOML or JSON)
    scene: PathBuf,
    /// Set a parameter or an input, such as rod_length="1.2 m"; may be given several times
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// The result as JSON, for scripts
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// The result as CSV, one value a line
    #[arg(long)]
    csv: bool,
    /// Where the result goes; `-` is standard output [default: -]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Study {
    /// Reads the scene, applies the settings.
    pub fn open(&self, format: MessageFormat) -> Result<(Scene, Mechanism), Failure> {
        output::apart(&[Some(&self.scene)], &[output::file(self.output.as_deref())])?;
        let scene = output::load(&self.scene)?;
        let resolved = scene.resolve()?;
        if !resolved.warnings.is_empty() {
            output::warn(&Faults::new(scene.source.clone(), resolved.warnings), format);
        }
        let mut mechanism = resolved.mechanism;
        for setting in &self.settings {
            set(&mut mechanism, setting).map_err(|message| Failure::Usage(format!("--set {setting}: {message}")))?;
        }
        Ok((scene, mechanism))
    }

    /// Writes a result.
    pub fn write(&self, report: &impl Report) -> Result<(), Failure> {
        let style = match (self.json, self.csv) {
            (true, _) => Style::Json,
            (_, true) => Style::Csv,
            _ => Style::Text,
        };
        let text = report.write(style);
        match output::file(self.output.as_deref()) {
            Some(path) => output::write(path, &text),
            None => output::print(&text),
        }
    }
}

/// Formulates the equations of a mechanism.
pub fn equations<'m>(
    scene: &Scene,
    mechanism: &'m Mechanism,
    format: MessageFormat,
) -> Result<Formulated<'m>, Failure> {
    let mut formulated = formulate_written(mechanism).map_err(|list| Faults::new(scene.source.clone(), list))?;
    let warnings = std::mem::take(&mut formulated.warnings);
    if !warnings.is_empty() {
        output::warn(&Faults::new(scene.source.clone(), warnings), format);
    }
    Ok(formulated)
}

/// Hands over the equations of a mechanism at rest with its equilibrium.
pub fn rest<T>(
    scene: &Scene,
    mechanism: &Mechanism,
    format: MessageFormat,
    then: impl FnOnce(&mut Formulated, &Variation, &Equilibrium) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let resting = at_rest(mechanism);
    let mut formulated = equations(scene, &resting, format)?;
    let variation = Variation::new(&mut formulated);
    let equilibrium = Equilibrium::find(&formulated, &variation)?;
    then(&mut formulated, &variation, &equilibrium)
}

/// A motion from its start on.
pub struct Motion {
    model: Arc<Model>,
    instance: Instance,
}

impl Motion {
    /// Assembles the mechanism at the start of its experiment.
    pub fn new(formulated: &Formulated) -> Result<Self, analysis::Failure> {
        let program = formulated.lowered.program.clone();
        let experiment = program.experiment;
        let model = Arc::new(Model::new(program)?);
        let mut instance = Instance::new(Arc::clone(&model));
        instance.setup(experiment.start, None, Some(experiment.tolerance))?;
        instance.initialise()?;
        Ok(Motion { model, instance })
    }

    /// Moves on to a time, not before the last one.
    pub fn point(&mut self, time: f64) -> Result<Point, analysis::Failure> {
        if time > self.instance.time() {
            self.instance.step_to(time)?;
        }
        Point::moving(&self.model, &self.instance.state())
    }
}

/// A time given on the command line, not before the start.
pub fn time(option: &str, text: &str, start: f64) -> Result<f64, Failure> {
    let wrong = |message: String| Failure::Usage(format!("--{option}: {message}"));
    let time = compile::quantity(text, &Unit::time()).map_err(wrong)?;
    match time.is_finite() && time >= start {
        true => Ok(time),
        false => Err(wrong(format!("{time:?} s is before the start, {start:?} s"))),
    }
}

/// `name=value` for a parameter or an input: the new default.
fn set(mechanism: &mut Mechanism, setting: &str) -> Result<(), String> {
    let (name, text) = setting.split_once('=').ok_or("write name=value")?;
    let (name, text) = (name.trim(), text.trim());
    let known: Vec<String> = (mechanism.parameters.iter().map(|parameter| parameter.name.clone()))
        .chain(mechanism.inputs.iter().map(|input| input.name.clone()))
        .collect();
    let parameters =
        mechanism.parameters.iter_mut().map(|own| (&own.name, &own.unit, [own.min, own.max], &mut own.value));
    let inputs = mechanism.inputs.iter_mut().map(|own| (&own.name, &own.unit, [own.min, own.max], &mut own.start));
    let Some((_, unit, bounds, place)) = parameters.chain(inputs).find(|(known, ..)| *known == name) else {
        let known = suggest::known(name, known.iter().map(String::as_str));
        return Err(format!("the scene has no parameter or input `{name}`; {known}"));
    };
    let value = compile::quantity(text, unit)?;
    match bounds {
        _ if !value.is_finite() => return Err("is not a finite number".to_owned()),
        [Some(min), _] if value < min => return Err(format!("must be at least {min:?} {}", unit.si)),
        [_, Some(max)] if value > max => return Err(format!("must be at most {max:?} {}", unit.si)),
        _ => *place = value,
    }
    Ok(())
}

impl From<analysis::Failure> for Failure {
    fn from(error: analysis::Failure) -> Self {
        Failure::Numerical(error.to_string())
    }
}
