//! Values of parameters from measured motions: least squares with the derivatives of the motion.

mod estimate;
mod levenberg;
mod report;
mod request;
mod student;
mod written;

use std::cell::OnceCell;
use std::sync::Arc;

use cotree::diagnostic::lines;
use cotree::report::csv::CsvTable;
use cotree_fmu::model::State;
use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use crate::analysis::{
    Along, AlongAt as At, AnalysisFailure, Differentiated, Guess, Study, StudyError, Varying, is_finite,
};
use crate::request::RequestFault;
use estimate::Estimates;
pub(crate) use levenberg::Residuals;
use levenberg::minimise;
pub use levenberg::{FitEnded, FitTrial};
use report::rows_left_out;
pub use request::{FitRequest, Vary, VaryError};
use request::{TablePlaces, Weighed, too_few};
pub(crate) use request::{bounds, check_times, places};
pub use written::with_values;

/// Motions are computed at most so often, and so often more for each quantity.
const MOST_EVALUATIONS: [usize; 2] = [100, 20];

/// A round of a fit of so many values tries no more motions than this.
pub fn most_evaluations(values: usize) -> usize {
    MOST_EVALUATIONS[0] + MOST_EVALUATIONS[1] * values
}
/// Standard deviations of columns are found in at most so many rounds.
const ROUNDS: usize = 20;
/// They are known once they change by less than this share.
const KNOWN: f64 = 1e-3;
/// A column's standard deviation is no less than this share of its extent: nothing is simulated more accurately.
const LEAST: f64 = 1e-9;
/// A motion of more than this many times the work of the first one is neither one that fits nor one that is sought: what was measured has happened in a time like that of the first.
pub(crate) const DEAREST: u64 = 100;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The name of the scene.
    pub name: String,
    /// What was fitted.
    pub quantities: Vec<FittedQuantity>,
    /// Correlations of the errors of the quantities; none with one that is at its bound.
    pub correlation: DMatrix<f64>,
    /// What was measured, for each experiment.
    pub measured: Vec<MeasuredExperiment>,
    /// How many motions were computed, with their derivatives.
    pub evaluations: usize,
    /// Why the search ended.
    pub ended: FitEnded,
    /// Guesses of the scene that are far from the start that fits best; of several experiments from that of the first.
    pub guesses: Vec<Guess>,
}

/// What was measured in one experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredExperiment {
    /// \[s\]
    pub times: Vec<f64>,
    /// Times at which something was measured that has no value or no derivative there in the first motion: they are left out \[s\].
    pub left_out: Vec<f64>,
    /// Each variable.
    pub columns: Vec<MeasuredVariable>,
}

/// A fitted quantity, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedQuantity {
    /// The user's name.
    pub name: String,
    pub unit: String,
    /// Where the search began.
    pub start: f64,
    /// The value that fits best.
    pub value: f64,
    /// Its standard error; none at a bound.
    pub error: Option<f64>,
    /// The true value is between these in 95 of 100 cases; none at a bound.
    pub limits: Option<[f64; 2]>,
}

/// A measured variable, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredVariable {
    pub name: String,
    pub unit: String,
    /// What was measured, one value for each time; not a number where nothing was.
    pub measured: Vec<f64>,
    /// The same as simulated with the values that fit best.
    pub fitted: Vec<f64>,
    /// Standard deviation of what was measured: as given, or estimated.
    pub deviation: f64,
    /// Was it given?
    pub is_given: bool,
}

impl MeasuredVariable {
    /// How many values count: those that were measured and can be computed.
    pub fn count(&self) -> usize {
        self.measured
            .iter()
            .zip(&self.fitted)
            .filter(|(measured, fitted)| !(measured.is_nan() || fitted.is_nan()))
            .count()
    }

    /// Root of the mean square of the residuals.
    pub fn rms(&self) -> f64 {
        let residuals = self.measured.iter().zip(&self.fitted).map(|(measured, fitted)| measured - fitted);
        let squares = residuals.filter(|left| !left.is_nan()).map(|left| left.powi(2));
        (squares.sum::<f64>() / self.count().max(1) as f64).sqrt()
    }
}

/// Why there is no fit.
#[derive(Debug, Error)]
pub enum FitError {
    /// The scene, or its motion with the values at the start.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// What was asked for; everything that is wrong with it.
    #[error("{}", lines(.0))]
    Request(Vec<RequestFault>),
    /// The measured values do not determine the quantities.
    #[error(transparent)]
    Undetermined(#[from] Unidentified),
}

/// Why measured values do not determine quantities.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct Unidentified(pub String);

/// Fits quantities of a scene to measured outputs. Each experiment has a study, with what was set, the inputs and the times of its own, and a table of the request, whose columns are
/// outputs of that study.
///
/// # Errors
/// Something is wrong with the scene or with what is asked for, there is no motion at the start, or the measured values do not determine the quantities.
pub fn fit(studies: &mut [Study], request: &FitRequest) -> Result<Fit, FitError> {
    fit_watched(studies, request, &mut |_| true)
}

/// The same; whoever watches is told of each trial, with its residuals in standard deviations, and says whether the search goes on. What is known by then is kept.
///
/// # Errors
/// Those of [`fit`].
pub fn fit_watched(
    studies: &mut [Study],
    request: &FitRequest,
    watch: &mut dyn FnMut(FitTrial) -> bool,
) -> Result<Fit, FitError> {
    let names: Vec<String> = request.vary.iter().map(|vary| vary.name.clone()).collect();
    let all_differentiated: Vec<Arc<Differentiated>> =
        studies.iter_mut().map(|study| study.differentiated(&names)).collect::<Result<_, _>>()?;
    let varying: Vec<Varying> = studies
        .iter()
        .zip(&all_differentiated)
        .map(|(study, differentiated)| study.varying_of(differentiated))
        .collect();
    let experiments: Vec<_> = varying.iter().zip(studies.iter().map(Study::experiment)).collect();
    let weighed = request.weighed(&experiments).map_err(FitError::Request)?;
    let experiments = varying.iter().zip(&request.tables).zip(weighed.tables.iter().cloned());
    let experiments =
        experiments.map(|((varying, table), places)| FittedMotion { varying, table, places, first: OnceCell::new() });
    let problem = FitProblem { experiments: experiments.collect(), weighed };
    let name = studies.first().map(|study| study.name().to_owned()).unwrap_or_default();
    problem.solve(name, watch).map_err(StudyError::from)?
}

/// What is fitted.
struct FitProblem<'a, 'f> {
    experiments: Vec<FittedMotion<'a, 'f>>,
    weighed: Weighed,
}

/// One motion, and what was measured in it.
struct FittedMotion<'a, 'f> {
    varying: &'a Varying<'f>,
    table: &'a CsvTable,
    places: TablePlaces,
    first: OnceCell<First>,
}

/// What the first motion shows.
struct First {
    work: u64,
    /// Row and column of each measured value that has a value and derivatives there; the others are left out of all motions.
    kept: Vec<(usize, usize)>,
}

impl FitProblem<'_, '_> {
    fn solve(
        mut self,
        name: String,
        watch: &mut dyn FnMut(FitTrial) -> bool,
    ) -> Result<Result<Fit, FitError>, AnalysisFailure> {
        let start = self.start();
        let most = most_evaluations(start.len());
        let (mut values, mut evaluations, mut poses) = (start.clone(), 0, None);
        for _ in 0..ROUNDS {
            let weighed = &self.weighed;
            let evaluate = |values: &[f64], from: Option<&Vec<State>>| {
                let motions = self.motions(values, from.or(poses.as_ref()))?;
                Ok((self.residuals(&motions, values.len()).by(weighed, &self.kinds()), starts(motions)))
            };
            let found = minimise(&values, &weighed.bounds, most, evaluate, &mut *watch)?;
            (values, evaluations) = (found.values, evaluations + found.evaluations);
            let blocked = found.blocked.map(|cause| {
                Unidentified(format!(
                    "the search ended without a minimum, at values without a motion: {cause}; exclude them by bounds (NAME=LOW..HIGH)"
                ))
            });
            if let Some(why) = blocked.or_else(|| self.too_few_left(start.len())) {
                return Ok(Err(FitError::Undetermined(why)));
            }
            let motions = self.motions(&values, Some(&found.beside))?;
            let residuals = self.residuals(&motions, values.len());
            evaluations += 1;
            let kinds = self.kinds();
            let change = self.weighed.estimate((&residuals, &kinds), start.len());
            // Of a single column the weight has no influence.
            let is_last = self.weighed.deviations.len() == 1 || change < KNOWN;
            if !is_last && found.ended == FitEnded::Settled {
                poses = Some(starts(motions));
                continue;
            }
            let scaled = residuals.by(&self.weighed, &kinds);
            let Some(first) = self.experiments.first() else { break };
            let estimates = match Estimates::new(&scaled, &values, &self.weighed, first.varying) {
                Ok(estimates) => estimates,
                Err(why) => return Ok(Err(FitError::Undetermined(why))),
            };
            let guesses = motions.first().map(|motion| first.varying.moved_guesses(&motion.start)).transpose()?;
            return Ok(Ok(Fit {
                name,
                quantities: estimates.quantities(&start, &values, first.varying),
                correlation: estimates.correlation(start.len()),
                measured: self
                    .experiments
                    .iter()
                    .zip(&motions)
                    .map(|(experiment, motion)| experiment.measured(&motion.rows, &self.weighed))
                    .collect(),
                evaluations: evaluations * self.experiments.len(),
                ended: found.ended,
                guesses: guesses.unwrap_or_default(),
            }));
        }
        Ok(Err(FitError::Undetermined(Unidentified(
            "the standard deviations of the columns do not converge: give them (--sigma), or fit one column".to_owned(),
        ))))
    }

    /// Where the search begins: in all experiments at the same values.
    fn start(&self) -> Vec<f64> {
        let first = self.experiments.first().map_or(&[][..], |experiment| experiment.varying.parameters());
        first.iter().map(|first| first.start).collect()
    }

    /// The motion of each experiment with these values.
    fn motions(&self, values: &[f64], from: Option<&Vec<State>>) -> Result<Vec<Along>, AnalysisFailure> {
        let motion = |(index, experiment): (usize, &FittedMotion)| {
            let motion = experiment.motion(values, from.and_then(|poses| poses.get(index)));
            motion.map_err(|cause| match self.experiments.len() {
                1 => cause,
                _ => AnalysisFailure::Other(format!("experiment {}: {cause}", index + 1)),
            })
        };
        self.experiments.iter().enumerate().map(motion).collect()
    }

    /// Says that the values that count are too few, if they are.
    fn too_few_left(&self, quantities: usize) -> Option<Unidentified> {
        let few = too_few(self.experiments.iter().map(|experiment| experiment.kept().len()).sum(), quantities)?;
        let left_out: Vec<f64> = self.experiments.iter().flat_map(FittedMotion::left_out).collect();
        let rows = self.experiments.iter().map(|experiment| experiment.table.times().len()).sum();
        Some(Unidentified(format!("{few}; {left_out}", left_out = rows_left_out(&left_out, rows)?)))
    }

    /// The kind of each value that counts, in the order of the residuals.
    fn kinds(&self) -> Vec<usize> {
        let kinds = |experiment: &FittedMotion| {
            experiment.kept().iter().map(|&(_, column)| experiment.places.kinds[column]).collect::<Vec<_>>()
        };
        self.experiments.iter().flat_map(kinds).collect()
    }

    /// Simulated less measured values, SI: of each value that counts, experiment by experiment and row by row.
    fn residuals(&self, motions: &[Along], quantities: usize) -> Residuals {
        let count = self.experiments.iter().map(|experiment| experiment.kept().len()).sum();
        let mut residuals = Residuals { values: DVector::zeros(count), derivatives: DMatrix::zeros(count, quantities) };
        let mut index = 0;
        for (experiment, motion) in self.experiments.iter().zip(motions) {
            for &(row, column) in experiment.kept() {
                let ((outputs, derivatives), place) = (&motion.rows[row], experiment.places.outputs[column]);
                residuals.values[index] = outputs[place] - experiment.table.column(column)[row];
                residuals.derivatives.row_mut(index).copy_from(&derivatives.row(place));
                index += 1;
            }
        }
        residuals
    }
}

/// How motions began.
fn starts(motions: Vec<Along>) -> Vec<State> {
    motions.into_iter().map(|motion| motion.start).collect()
}

impl FittedMotion<'_, '_> {
    /// The motion with these values. It starts on the branch on which another one does: where lengths move far the guesses of the scene are near no branch, or another one.
    fn motion(&self, values: &[f64], from: Option<&State>) -> Result<Along, AnalysisFailure> {
        let most = self.first.get().map_or(u64::MAX, |first| DEAREST.saturating_mul(first.work));
        let found = self.varying.along(values, self.table.times(), from, most)?;
        self.judge(&found)?;
        Ok(found)
    }

    /// Finds out by the first motion what counts; another one that has fewer values would fit the better for it.
    fn judge(&self, found: &Along) -> Result<(), AnalysisFailure> {
        let is_missing = |&&(row, column): &&(usize, usize)| {
            let (values, derivatives) = &found.rows[row];
            !is_finite(values, derivatives, self.places.outputs[column])
        };
        let measured = &self.places.measured;
        let kept = || measured.iter().filter(|place| !is_missing(place)).copied().collect();
        let First { kept, .. } = self.first.get_or_init(|| First { work: found.work, kept: kept() });
        let lost = kept.iter().find(is_missing).or(if kept.is_empty() { measured.first() } else { None });
        let Some(&(row, column)) = lost else { return Ok(()) };
        Err(AnalysisFailure::NotFinite { time: self.table.times()[row], what: self.table.names()[column].clone() })
    }

    /// Row and column of each measured value that counts.
    fn kept(&self) -> &[(usize, usize)] {
        self.first.get().map_or(&[], |first| &first.kept)
    }

    /// The times of measured values that do not count.
    fn left_out(&self) -> Vec<f64> {
        let others = self.places.measured.iter().filter(|place| self.kept().binary_search(place).is_err());
        let mut rows: Vec<usize> = others.map(|&(row, _)| row).collect();
        rows.dedup();
        rows.into_iter().map(|row| self.table.times()[row]).collect()
    }

    /// Beside the motion that fits best.
    fn measured(&self, rows: &[At], weighed: &Weighed) -> MeasuredExperiment {
        let units: Vec<String> = self.varying.outputs().map(|(_, unit)| unit.si.clone()).collect();
        let column = |(index, name): (usize, &String)| {
            let output = self.places.outputs[index];
            let measured = self.table.column(index).to_vec();
            let value = |(row, (outputs, _)): (usize, &At)| {
                let is_left_out = !measured[row].is_nan() && self.kept().binary_search(&(row, index)).is_err();
                if is_left_out { f64::NAN } else { outputs[output] }
            };
            let fitted = rows.iter().enumerate().map(value).collect();
            let (deviation, is_given) = weighed.deviations[self.places.kinds[index]];
            MeasuredVariable { name: name.clone(), unit: units[output].clone(), measured, fitted, deviation, is_given }
        };
        MeasuredExperiment {
            times: self.table.times().to_vec(),
            left_out: self.left_out(),
            columns: self.table.names().iter().enumerate().map(column).collect(),
        }
    }
}

impl Residuals {
    /// In standard deviations of their kinds.
    fn by(&self, weighed: &Weighed, kinds: &[usize]) -> Residuals {
        let mut scaled = self.clone();
        for (row, kind) in kinds.iter().enumerate() {
            let (deviation, _) = weighed.deviations[*kind];
            scaled.values[row] /= deviation;
            scaled.derivatives.row_mut(row).scale_mut(1.0 / deviation);
        }
        scaled
    }
}
