//! The reference: a converged run of one method that another method confirms.

use cotree_fmu::program::Engine;
use serde::Serialize;

use super::Method;
use super::runs::{BenchError, BenchSubject, Budget, TimedMotion};

/// Tolerances that are tried, from the finest on.
const TOLERANCES: [f64; 4] = [1e-13, 1e-11, 1e-9, 1e-7];
/// Results of methods that differ by more than this [relative] confirm nothing.
const CONFIRMED: f64 = 1e-6;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reference {
    pub method: &'static str,
    pub tolerance: f64,
    /// How far it is from a run at ten times the tolerance, or from the run of the other method if that is more.
    pub error: f64,
    /// The run of another method that agrees with it best.
    pub other: Option<ReferenceComparison>,
    /// Is there such a run, and is the error small?
    pub confirmed: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferenceComparison {
    pub method: &'static str,
    pub tolerance: f64,
    pub distance: f64,
}

struct Converged {
    method: &'static str,
    engine: Option<Engine>,
    tolerance: f64,
    found: TimedMotion,
    /// Distance of a run at ten times the tolerance.
    error: f64,
}

/// The times at which results are compared, the reference's results, and what is known of it.
///
/// Of all methods the two that agree best are taken; the one that the model does not choose by itself is the reference, so that its choice is judged by
/// another method.
pub(super) fn find(
    subject: &BenchSubject,
    methods: &[Method],
) -> Result<(Vec<f64>, TimedMotion, Reference), BenchError> {
    let times = times(subject)?;
    let chosen = subject.model.program().engine;
    let named = methods.iter().filter(|(_, engine)| engine.is_some());
    let mut converged: Vec<Converged> = named.filter_map(|method| finest(subject, method, &times).ok()).collect();
    let Some(ClosestPair { mut first, mut second, distance }) = closest(&converged) else {
        // The model by itself, which may use several methods, or the only one there is.
        let finest_run = finest(subject, &methods[0], &times)?;
        let Converged { method, tolerance, error, .. } = finest_run;
        return Ok((times, finest_run.found, Reference { method, tolerance, error, other: None, confirmed: false }));
    };
    if converged[first].engine == Some(chosen) {
        std::mem::swap(&mut first, &mut second);
    }
    let Converged { method, tolerance, .. } = converged[second];
    let other = ReferenceComparison { method, tolerance, distance };
    let Converged { method, tolerance, error, found, .. } = converged.swap_remove(first);
    let error = error.max(distance);
    let confirmed = error <= CONFIRMED;
    Ok((times, found, Reference { method, tolerance, error, other: Some(other), confirmed }))
}

fn times(subject: &BenchSubject) -> Result<Vec<f64>, BenchError> {
    first(&[1e-9, 1e-6, 1e-4], |tolerance| subject.times(None, tolerance))
}

fn finest(subject: &BenchSubject, &(method, engine): &Method, times: &[f64]) -> Result<Converged, BenchError> {
    first(&TOLERANCES, |tolerance| {
        let run = |tolerance| subject.run(engine, tolerance, Budget::Reference, times);
        let (coarser, found) = (run(10.0 * tolerance)?, run(tolerance)?);
        let error = coarser.trajectory.distance(&found.trajectory);
        Ok(Converged { method, engine, tolerance, found, error })
    })
}

/// What is found at the first of the tolerances at which anything is.
fn first<T>(tolerances: &[f64], found: impl Fn(f64) -> Result<T, BenchError>) -> Result<T, BenchError> {
    let mut problem = BenchError::TooLong;
    for &tolerance in tolerances {
        match found(tolerance) {
            Ok(found) => return Ok(found),
            Err(error) => problem = error,
        }
    }
    Err(BenchError::Other(format!("there is no reference to compare with: {problem}")))
}

/// The two whose results are closest.
struct ClosestPair {
    first: usize,
    second: usize,
    distance: f64,
}

fn closest(converged: &[Converged]) -> Option<ClosestPair> {
    let pairs = (0..converged.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    let apart = |(first, second): (usize, usize)| {
        let distance = converged[first].found.trajectory.distance(&converged[second].found.trajectory);
        ClosestPair { first, second, distance }
    };
    pairs.map(apart).min_by(|one, other| one.distance.total_cmp(&other.distance))
}
