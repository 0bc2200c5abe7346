//! The importer of the crate `fmi` with our FMUs, in both versions and both interfaces.

use std::path::Path;

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{self as fmi2, CoSimulation as _, Common as _};
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::instance as fmi3;
use fmi::fmi3::{CoSimulation as _, Fmi3Model, GetSet};
use fmi::schema::traits::DefaultExperiment;
use fmi::traits::{FmiImport, FmiInstance, FmiModelExchange, FmiStatus};
use fmi::{Error, EventFlags, import, schema};

/// Communication steps of a run.
pub const POINTS: u32 = 100;
/// What Model Exchange is integrated over at most \[s\]; a tenth of the experiment otherwise.
const EXCHANGE: f64 = 0.05;
/// With so many steps of the midpoint rule.
const STEPS: u32 = 2000;

/// The outputs of an FMU and their values.
pub struct Run {
    /// `modelDescription.xml`.
    pub description: String,
    pub names: Vec<String>,
    /// Between communication points \[s\].
    pub step: f64,
    /// Bits at each communication point.
    pub rows: Vec<Vec<u64>>,
    /// After a while, with Co-Simulation and with Model Exchange, if that is offered.
    pub end: Option<[Vec<f64>; 2]>,
}

impl Run {
    /// Does the importer's own integrator arrive where Co-Simulation does, within this share?
    pub fn exchange_agrees(&self, share: f64) -> bool {
        let Some([simulated, exchanged]) = &self.end else { return true };
        agree(simulated, exchanged, share)
    }

    /// Are these the rows of a table, each with its time first?
    pub fn agrees(&self, table: &[Vec<f64>]) -> bool {
        let rows = self.rows.iter().map(|row| row.iter().map(|&bits| f64::from_bits(bits)).collect::<Vec<_>>());
        table.len() == self.rows.len()
            && table.iter().zip(rows).all(|(simulated, row)| agree(&simulated[1..], &row, 1e-6))
    }
}

fn agree(left: &[f64], right: &[f64], share: f64) -> bool {
    left.len() == right.len() && left.iter().zip(right).all(|(a, b)| (a - b).abs() <= share * a.abs().max(1.0))
}

fn started<I: FmiInstance>(mut instance: I) -> Result<I, Error>
where
    Error: From<<I::Status as FmiStatus>::Err>,
{
    instance.enter_initialization_mode(None, 0.0, None)?;
    instance.exit_initialization_mode()?;
    Ok(instance)
}

/// Integrates by the midpoint rule; the instance is in event mode.
fn exchanged<I: FmiModelExchange>(instance: &mut I, states: usize, end: f64) -> Result<(), Error>
where
    Error: From<<I::Status as FmiStatus>::Err>,
{
    let h = end / f64::from(STEPS);
    settled(instance)?;
    let [mut x, mut rates] = [vec![0.0; states], vec![0.0; states]];
    for step in 0..STEPS {
        let t = h * f64::from(step);
        instance.get_continuous_states(&mut x)?;
        for part in [0.5, 1.0] {
            instance.get_continuous_state_derivatives(&mut rates)?;
            let moved: Vec<f64> = x.iter().zip(&rates).map(|(x, rate)| x + part * h * rate).collect();
            instance.set_time(t + part * h)?;
            instance.set_continuous_states(&moved)?;
        }
        let (mut event, mut end) = (false, false);
        instance.completed_integrator_step(true, &mut event, &mut end)?;
        if event {
            instance.enter_event_mode()?;
            settled(instance)?;
        }
    }
    Ok(())
}

/// From event mode to continuous-time mode.
fn settled<I: FmiModelExchange>(instance: &mut I) -> Result<(), Error>
where
    Error: From<<I::Status as FmiStatus>::Err>,
{
    let mut flags = EventFlags { discrete_states_need_update: true, ..EventFlags::default() };
    while flags.discrete_states_need_update {
        flags = EventFlags::default();
        instance.update_discrete_states(&mut flags)?;
    }
    instance.enter_continuous_time_mode()?;
    Ok(())
}

/// What both versions do in ways of their own.
trait Own {
    fn read(&mut self, references: &[u32]) -> Result<Vec<f64>, Error>;
}

impl<Tag> Own for fmi2::Instance<Tag>
where
    Self: fmi2::Common,
{
    fn read(&mut self, references: &[u32]) -> Result<Vec<f64>, Error> {
        let mut values = vec![f64::NAN; references.len()];
        self.get_real(references, &mut values)?;
        Ok(values)
    }
}

impl<Tag> Own for fmi3::Instance<Tag>
where
    Self: GetSet,
{
    fn read(&mut self, references: &[u32]) -> Result<Vec<f64>, Error> {
        let mut values = vec![f64::NAN; references.len()];
        self.get_float64(references, &mut values)?;
        Ok(values)
    }
}

trait Slave: Own {
    fn step(&mut self, t: f64, h: f64) -> Result<(), Error>;
}

impl Slave for fmi2::InstanceCS {
    fn step(&mut self, t: f64, h: f64) -> Result<(), Error> {
        self.do_step(t, h, true)?;
        Ok(())
    }
}

impl Slave for fmi3::InstanceCS {
    fn step(&mut self, t: f64, h: f64) -> Result<(), Error> {
        let (mut event, mut end, mut early, mut time) = (false, false, false, f64::NAN);
        self.do_step(t, h, true, &mut event, &mut end, &mut early, &mut time)?;
        assert!(!event && !end && !early && time == t + h);
        Ok(())
    }
}

/// An FMU of FMI 2.0.
pub fn version_2(file: &Path) -> Result<Run, Error> {
    let fmu: Fmi2Import = import::from_path(file)?;
    let description = fmu.model_description();
    let outputs = description.get_model_variables().filter(|one| one.causality == schema::fmi2::Causality::Output);
    let outputs = outputs.map(|one| (one.name.clone(), one.value_reference)).collect();
    let model = description.model_exchange.as_ref().map(|_| fmu.instantiate_me("model", false, true)).transpose()?;
    let slave = || fmu.instantiate_cs("slave", false, true);
    let run = run(outputs, description, slave, model, description.num_states())?;
    Ok(Run { description: std::fs::read_to_string(fmu.archive_path().join("modelDescription.xml"))?, ..run })
}

/// An FMU of FMI 3.0.
pub fn version_3(file: &Path) -> Result<Run, Error> {
    let folder = tempfile::tempdir()?;
    zip::ZipArchive::new(std::fs::File::open(file)?)?.extract(&folder)?;
    let text = std::fs::read_to_string(folder.path().join("modelDescription.xml"))?;
    let fmu = Fmi3Import::new(folder, &readable(&text))?;
    let description = fmu.model_description();
    let outputs = description.model_variables.iter_abstract();
    let outputs = outputs.filter(|one| one.causality() == schema::fmi3::Causality::Output);
    let outputs = outputs.map(|one| (one.name().to_owned(), one.value_reference())).collect();
    let model = description.model_exchange.as_ref().map(|_| fmu.instantiate_me("model", false, true)).transpose()?;
    let slave = || fmu.instantiate_cs("slave", false, true, false, false, &[]);
    let states = description.model_structure.continuous_state_derivatives().count();
    let run = run(outputs, description, slave, model, states)?;
    Ok(Run { description: std::fs::read_to_string(fmu.archive_path().join("modelDescription.xml"))?, ..run })
}

/// A description as the crate can read it: without the units of its variables, which it takes for an error (2.4.7.5 has them), and with the ampere as `a` (2.4.4 has `A`).
fn readable(description: &str) -> String {
    let mut lines = Vec::new();
    for line in description.lines() {
        let mut line = line.to_owned();
        if line.contains("<BaseUnit ") {
            line = line.replace(" A=\"", " a=\"");
        }
        for key in [" unit=\"", " displayUnit=\""] {
            if let Some((before, after)) = line.split_once(key).filter(|_| line.contains("<Float64 ")) {
                line = format!("{before}{}", after.split_once('"').map_or("", |(_, rest)| rest));
            }
        }
        lines.push(line);
    }
    lines.join("\n")
}

fn run<S: Slave + FmiInstance, X: Own + FmiModelExchange>(
    outputs: Vec<(String, u32)>,
    experiment: &impl DefaultExperiment,
    slave: impl Fn() -> Result<S, Error>,
    model: Option<X>,
    states: usize,
) -> Result<Run, Error>
where
    Error: From<<S::Status as FmiStatus>::Err> + From<<X::Status as FmiStatus>::Err>,
{
    let (names, references): (Vec<_>, Vec<_>) = outputs.into_iter().unzip();
    let h = experiment.step_size().expect("always written");
    let mut stepped = started(slave()?)?;
    let mut rows = Vec::new();
    for point in 0..=POINTS {
        rows.push(stepped.read(&references)?.into_iter().map(f64::to_bits).collect());
        if point < POINTS {
            stepped.step(f64::from(point) * h, h)?;
        }
    }
    stepped.terminate()?;
    let mut end = None;
    if let Some(model) = model {
        let (mut simulated, mut model) = (started(slave()?)?, started(model)?);
        let time = EXCHANGE.min(0.1 * experiment.stop_time().expect("always written"));
        simulated.step(0.0, time)?;
        exchanged(&mut model, states, time)?;
        end = Some([simulated.read(&references)?, model.read(&references)?]);
    }
    Ok(Run { description: String::new(), names, step: h, rows, end })
}
