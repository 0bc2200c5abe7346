//! Sweeps: many runs of one scene with other parameters, constant inputs or initial values, and a few numbers of each.

mod design;
mod factor;
mod part;
mod record;
mod sample;
mod table;

use std::io;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use cotree::compile::{Compiled, compile_asking};
use cotree::model::{DisplayUnit, Experiment, Units};
use cotree::report::data::shown;
use cotree::report::statistics::Accumulator;
use cotree::run::{Ended, Ensemble, Measure, Run, RunError, Settings};
use cotree::scene::{Faults, Requested, Scene};
use cotree::typeset::titled;
use cotree_fmu::instance::Inaccuracy;
use cotree_fmu::model::Model;

pub use design::{Design, DesignError};
pub use factor::{DesignFactor, FactorError, FactorValues};
pub use part::{JoinError, PartError, SweepPart, join};
pub use record::{RecordError, SweepRecord, begin, write};
pub use sample::Sampling;

/// Rows are handed over about as often.
const PACE: Duration = Duration::from_millis(250);
/// At most so many runs between two of them.
const MOST: usize = 1 << 14;

/// A scene that computes what is measured, and the design.
#[derive(Debug)]
pub struct Sweep {
    pub compiled: Compiled,
    pub experiment: Experiment,
    pub measures: Vec<Measure>,
    pub design: Design,
    /// Which of the runs are made.
    pub part: SweepPart,
    /// What its table and its picture are in.
    pub units: Units,
}

/// The numbers of a run, one for each measure; or why there are none.
pub type Outcome = Result<Vec<f64>, OutcomeError>;

/// Why a run has no numbers.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct OutcomeError(pub String);

cotree::diagnostic::from_messages!(OutcomeError as OutcomeError: RunError);

/// Runs whose rounding errors are larger than their tolerance.
#[derive(Clone, Debug)]
pub struct Inaccurate {
    /// How many there are.
    pub runs: usize,
    /// What was found of the first one.
    pub first: Inaccuracy,
}

/// The scene, computing these variables instead of its own outputs.
///
/// # Errors
/// Everything that is wrong with it; variables that it does not have.
pub fn measured(scene: &Scene, measures: &[Measure]) -> Result<Compiled, Faults> {
    let requested = Requested::these(measures.iter().map(|measure| measure.variable.as_str()));
    compile_asking(scene, &requested).map(|(compiled, _)| compiled)
}

impl Sweep {
    /// The heading of each column: parameters, measures, with their units.
    pub fn columns(&self) -> Vec<String> {
        let names = self.design.factors().iter().map(|factor| factor.name.clone());
        let names = names.chain(self.measures.iter().map(ToString::to_string));
        names.zip(self.shown()).map(|(name, unit)| titled(&name, &unit.name)).collect()
    }

    /// How the values of each column are shown.
    pub fn shown(&self) -> Vec<DisplayUnit> {
        let factors = self.design.factors().iter().map(|factor| shown(&self.units, &factor.unit));
        let measures = self.measures.iter().map(|measure| shown(&self.units, measure.unit(self.unit(measure))));
        factors.chain(measures).collect()
    }

    /// The unit of the measured variable.
    pub fn unit(&self, measure: &Measure) -> &str {
        let variable = self.place(measure).map(|index| &self.compiled.description.variables[index]);
        variable.map_or("", |variable| &variable.unit.si)
    }

    fn place(&self, measure: &Measure) -> Option<usize> {
        self.compiled.description.variables.iter().position(|variable| variable.name == measure.variable)
    }

    /// The runs of this part.
    pub fn runs(&self) -> Range<usize> {
        self.part.runs(self.design.len())
    }

    /// Runs the members of the part from `first` on and hands their outcomes over in their order, some at a time, until all are done or `stop` is set. Says which of them are
    /// less accurate than their tolerance.
    ///
    /// # Errors
    /// The program is refused, there are no threads, or `report` fails.
    pub fn run(
        &self,
        first: usize,
        threads: usize,
        stop: &AtomicBool,
        mut report: impl FnMut(usize, Vec<Outcome>) -> io::Result<()>,
    ) -> Result<Option<Inaccurate>, RunError> {
        let model = Arc::new(Model::new(self.compiled.program.clone())?);
        let reported: Vec<usize> = self.measures.iter().filter_map(|measure| self.place(measure)).collect();
        let description = &self.compiled.description;
        let run = Run { description, experiment: self.points(), settings: Vec::new(), inputs: None, reported };
        let ensemble = Ensemble::new(run, model, threads, stop).map_err(io::Error::other)?;
        let (mut next, mut size, mut inaccurate) = (first, ensemble.threads(), None);
        let last = self.runs().end;
        while next < last && !ensemble.is_stopped() {
            let begin = Instant::now();
            let end = last.min(next + size);
            let members: Vec<Settings> = (next..end).map(|index| self.design.settings(index)).collect();
            let ended = ensemble.run(&members, Vec::new, Accumulator::add_all);
            if ensemble.is_stopped() {
                break; // some of them were cut short
            }
            inaccurate = note(inaccurate, &ended);
            report(next, self.outcomes(ended))?;
            next = end;
            if begin.elapsed() < PACE {
                size = (2 * size).min(MOST);
            }
        }
        Ok(inaccurate)
    }

    /// Without communication points within, where the ends of a run say everything.
    fn points(&self) -> Experiment {
        let Experiment { start, stop, step, .. } = self.experiment;
        let ends = self.measures.iter().all(Measure::is_of_ends);
        Experiment { step: if ends && stop > start { stop - start } else { step }, ..self.experiment }
    }

    fn outcomes(&self, ended: Vec<(Vec<Accumulator>, Ended)>) -> Vec<Outcome> {
        let outcome = |(kept, ended): (Vec<Accumulator>, Ended)| match ended {
            Ok(_) => self.measures.iter().zip(&kept).map(|(measure, kept)| measured_value(measure, kept)).collect(),
            Err(failed) => Err(failed.error.into()),
        };
        ended.into_iter().map(outcome).collect()
    }
}

/// A number of a run; or that it has none.
fn measured_value(measure: &Measure, kept: &Accumulator) -> Result<f64, OutcomeError> {
    let value = measure.of(kept);
    if value.is_nan() { Err(OutcomeError(format!("`{0}` has no value", measure.clone()))) } else { Ok(value) }
}

/// Counts further runs that are not as accurate as they should be.
fn note<C>(before: Option<Inaccurate>, ended: &[(C, Ended)]) -> Option<Inaccurate> {
    let found = ended.iter().filter_map(|(_, ended)| ended.as_ref().ok()?.inaccuracy.as_ref());
    found.fold(before, |before, inaccuracy| match before {
        Some(Inaccurate { runs, first }) => Some(Inaccurate { runs: runs + 1, first }),
        None => Some(Inaccurate { runs: 1, first: inaccuracy.clone() }),
    })
}
