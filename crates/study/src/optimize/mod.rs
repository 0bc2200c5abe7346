//! Which values are best: measures of a motion made small or large, or a curve met, within limits. Searches from many starts, with the derivatives of the motion.

mod around;
mod course;
mod goal;
mod motion;
mod quadratic;
mod report;
mod request;
mod resumed;
mod search;
mod starts;
mod turn;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use cotree::diagnostic::lines;
use cotree::model::Unit;
use cotree::scene::Scene;
use cotree_fmu::model::State;
use thiserror::Error;

use crate::analysis::{AnalysisFailure, Guess, Study, StudyError, Varying};
use crate::motion::DifferentiatedTurn;
use crate::request::RequestFault;
pub use crate::request::{GoalError, LimitError};
pub use around::NearOptimum;
pub use goal::{Goal, MeasureLimit, Relation};
use motion::Motions;
use request::Checked;
pub use request::{Aim, OptimizeRequest};
pub use resumed::searched;
pub use search::Ended;
use search::{EndPoint, MET, search};
use starts::Starts;
use turn::Turns;

/// Motions of one search: so many at most, and so many more for each quantity.
const MOST_EVALUATIONS: [usize; 2] = [150, 20];
/// Optima are the same one if their goals differ by no more than this share, and their values by no more than that share of their ranges.
const SAME: [f64; 2] = [1e-5, 1e-3];
/// A quantity is at its bound within this share of its range.
const AT_BOUND: f64 = 1e-9;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// The name of the scene.
    pub name: String,
    /// What was asked for, in words, and its unit.
    pub goal: (String, String),
    /// It at the scene's values, if there is a motion, and at the best ones, SI.
    pub values: [Option<f64>; 2],
    pub quantities: Vec<OptimizedQuantity>,
    pub limits: Vec<LimitAt>,
    /// The best first.
    pub optima: Vec<Optimum>,
    /// How the search ended that found the best.
    pub ended: Ended,
    /// All searches, in the order of their numbers.
    pub searches: Vec<Search>,
    /// Was it one turn or stroke, and not the experiment?
    pub is_turn: bool,
    /// How often a motion was computed, with its derivatives.
    pub evaluations: usize,
    /// Guesses of the scene that are far from the start of the best motion.
    pub guesses: Vec<Guess>,
}

/// A quantity that was varied, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct OptimizedQuantity {
    pub name: String,
    pub unit: String,
    pub start: f64,
    pub value: f64,
    pub is_at_bound: bool,
}

/// A limit at the best values, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitAt {
    pub text: String,
    pub unit: String,
    pub bound: f64,
    pub value: f64,
    /// How much the goal rises for each unit by which the bound is higher; none where the limit is not active.
    pub multiplier: Option<f64>,
}

/// Values that no small change makes better, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimum {
    pub goal: f64,
    pub values: Vec<f64>,
    /// How many searches ended there.
    pub reached: usize,
}

/// One search.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    pub values: Vec<f64>,
    /// None where there was no motion.
    pub goal: Option<f64>,
    /// How it ended, in words.
    pub ended: String,
}

/// How far the searches are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchProgress {
    pub done: usize,
    pub all: usize,
    pub evaluations: usize,
    /// The best goal so far that meets the limits.
    pub best: Option<f64>,
}

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum OptimizeError {
    /// The scene.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// What was asked for; everything that is wrong with it.
    #[error("{}", lines(.0))]
    Request(Vec<RequestFault>),
    /// No values meet the limits.
    #[error("no values were found that meet all constraints; the closest, {nearest}, violate {missed}")]
    Unmet {
        /// The nearest values.
        nearest: String,
        /// The limits that they miss, and by how much.
        missed: String,
    },
    /// The search was stopped too early.
    #[error("stopped before the first motion was computed")]
    Stopped,
    /// The scene moves otherwise than the search.
    #[error(
        "no plot around the best values: with them the scene starts in another assembly mode; write them with -o and search from there"
    )]
    OtherBranch,
}

/// Searches for the best values of a scene. Its study has what is measured as outputs, and other values that were set. Whoever watches is told how far it is, and says whether it goes on; the best values so far are kept.
/// The same request gives the same answer, in any number of threads.
///
/// # Errors
/// Something is wrong with the scene or with what is asked for, or no values meet the limits.
pub fn optimize(
    scene: &Scene,
    study: &mut Study,
    request: &OptimizeRequest,
    watch: &(dyn Fn(SearchProgress) -> bool + Sync),
) -> Result<Best, OptimizeError> {
    resume(scene, study, request, &[], watch)
}

/// The same, where searches with these numbers begin at these values: where they ended before.
///
/// # Errors
/// As there.
pub fn resume(
    scene: &Scene,
    study: &mut Study,
    request: &OptimizeRequest,
    from: &[(usize, Vec<f64>)],
    watch: &(dyn Fn(SearchProgress) -> bool + Sync),
) -> Result<Best, OptimizeError> {
    let name = study.name().to_owned();
    searching(scene, study, request, from, |searches| {
        let ended = searches.run(watch);
        searches.best(name, ended)
    })
}

/// What is seen around the best values: one quantity after the other goes from bound to bound, the others stay.
///
/// # Errors
/// As of the search; or the scene's own branch of the motion is another one than that of the best values.
pub fn around(
    scene: &Scene,
    study: &mut Study,
    request: &OptimizeRequest,
    best: &Best,
) -> Result<Vec<NearOptimum>, OptimizeError> {
    searching(scene, study, request, &[], |searches| searches.around(best))
}

/// With all that searches need.
fn searching<T>(
    scene: &Scene,
    study: &mut Study,
    request: &OptimizeRequest,
    from: &[(usize, Vec<f64>)],
    of: impl FnOnce(&Searches) -> Result<Result<T, OptimizeError>, AnalysisFailure>,
) -> Result<T, OptimizeError> {
    let names: Vec<String> = request.vary.iter().map(|vary| vary.name.clone()).collect();
    let experiment = study.experiment();
    let set = study.clone();
    study.varying(&names, |varying| {
        let known: Vec<(String, Unit)> = match &request.turn {
            Some(turn) => turn::known(scene, &set, turn)?,
            None => varying.outputs().map(|(name, unit)| (name.to_owned(), unit.clone())).collect(),
        };
        let checked = match request.checked(varying, &known, experiment) {
            Ok(checked) => checked,
            Err(faults) => return Ok(Err(OptimizeError::Request(faults))),
        };
        let (bounds, ranges) = (checked.problem.bounds.clone(), checked.problem.ranges.clone());
        let motions = match &request.turn {
            Some(turn) => {
                let measured = checked.outputs.iter().map(|&place| known[place].0.clone()).collect();
                let (study, names) = (&set, names.clone());
                let differentiated = DifferentiatedTurn::new(scene, study, turn, &names);
                let request = turn;
                MeasuredMotion::Turn(Box::new(Turns {
                    scene,
                    study,
                    request,
                    names,
                    bounds,
                    ranges,
                    measured,
                    differentiated,
                }))
            }
            None => {
                let table = request.table().map(|table| (table, checked.columns.clone()));
                MeasuredMotion::Experiment(Box::new(Motions::new(varying, experiment, checked.outputs.clone(), table)))
            }
        };
        of(&Searches { varying, request, checked: &checked, motions: &motions, from })
    })?
}

/// What is moved to be measured.
enum MeasuredMotion<'a, 'f> {
    Experiment(Box<Motions<'a, 'f>>),
    Turn(Box<Turns<'a>>),
}

/// How the motion of an experiment starts; of a turn this is not kept.
type Start = Option<State>;

impl MeasuredMotion<'_, '_> {
    fn seen(&self, values: &[f64], from: Option<&Start>) -> Result<(search::SeenCourses, Start), AnalysisFailure> {
        match self {
            MeasuredMotion::Experiment(motions) => {
                let (seen, start) = motions.seen(values, from.and_then(Option::as_ref))?;
                Ok((seen, Some(start)))
            }
            MeasuredMotion::Turn(turns) => Ok((turns.seen(values)?, None)),
        }
    }
}

struct Searches<'a, 'f> {
    varying: &'a Varying<'f>,
    request: &'a OptimizeRequest,
    checked: &'a Checked,
    motions: &'a MeasuredMotion<'a, 'f>,
    /// Where searches with these numbers ended before.
    from: &'a [(usize, Vec<f64>)],
}

/// How a search ended: where, or why there was no motion at any of its starts.
type Outcome = Result<EndPoint<Start>, AnalysisFailure>;

/// What all searches share while they run.
struct SharedProgress<'w> {
    next: AtomicUsize,
    progress: Mutex<SearchProgress>,
    watch: &'w (dyn Fn(SearchProgress) -> bool + Sync),
}

impl SharedProgress<'_> {
    /// Takes note, and tells whoever watches; does the search go on?
    fn note(&self, of: impl FnOnce(&mut SearchProgress)) -> bool {
        let mut progress = self.progress.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        of(&mut progress);
        (self.watch)(*progress)
    }
}

impl Searches<'_, '_> {
    /// All searches, in the order of their numbers; those that were not begun before somebody ended it are not there.
    fn run(&self, watch: &(dyn Fn(SearchProgress) -> bool + Sync)) -> Vec<Outcome> {
        let all = self.request.starts;
        let progress = SearchProgress { done: 0, all, evaluations: 0, best: None };
        let shared = SharedProgress { next: AtomicUsize::new(0), progress: Mutex::new(progress), watch };
        let processors = || thread::available_parallelism().map_or(1, usize::from);
        let threads = if self.request.threads == 0 { processors() } else { self.request.threads };
        let work = || {
            let mut ended = Vec::new();
            loop {
                let number = shared.next.fetch_add(1, Ordering::Relaxed);
                if number >= all || !shared.note(|_| {}) {
                    return ended;
                }
                ended.push((number, self.one(number, &shared)));
            }
        };
        let mut ended: Vec<(usize, Outcome)> = thread::scope(|scope| {
            let others: Vec<_> = (1..threads.min(all)).map(|_| scope.spawn(work)).collect();
            let mut ended = work();
            ended.extend(others.into_iter().filter_map(|other| other.join().ok()).flatten());
            ended
        });
        ended.sort_by_key(|(number, _)| *number);
        ended.into_iter().map(|(_, outcome)| outcome).collect()
    }

    /// One search, from the first of its starts that has a motion.
    fn one(&self, number: usize, shared: &SharedProgress) -> Outcome {
        let Checked { problem, start, .. } = self.checked;
        let starts =
            Starts { scene: start, bounds: &problem.bounds, count: self.request.starts, seed: self.request.seed };
        let most = MOST_EVALUATIONS[0] + MOST_EVALUATIONS[1] * start.len();
        let mut outcome = Err(AnalysisFailure::Range);
        let before = self.from.iter().filter(|(start, _)| *start == number).map(|(_, values)| values.clone());
        for point in before.chain(starts.of(number)) {
            let evaluate = |values: &[f64], from: Option<&Start>| {
                shared.note(|progress| progress.evaluations += 1);
                self.motions.seen(values, from)
            };
            outcome = search(problem, &point, most, evaluate, || shared.note(|_| {}));
            if outcome.is_ok() || !shared.note(|_| {}) {
                break;
            }
        }
        shared.note(|progress| {
            progress.done += 1;
            if let Some(found) = outcome.as_ref().ok().filter(|found| found.violation() <= MET) {
                let goal = self.checked.sign * found.goal;
                let is_better = |best: f64| self.checked.sign * goal < self.checked.sign * best;
                if progress.best.is_none_or(is_better) {
                    progress.best = Some(goal);
                }
            }
        });
        outcome
    }

    fn best(&self, name: String, outcomes: Vec<Outcome>) -> Result<Result<Best, OptimizeError>, AnalysisFailure> {
        let found: Vec<&EndPoint<Start>> = outcomes.iter().filter_map(|outcome| outcome.as_ref().ok()).collect();
        let better = |one: &&&EndPoint<Start>, other: &&&EndPoint<Start>| one.goal.total_cmp(&other.goal);
        let Some(best) = found.iter().filter(|optimum| optimum.violation() <= MET).min_by(better) else {
            return Ok(Err(self.nothing(outcomes)));
        };
        let Checked { goal: named, problem, start, sign, .. } = self.checked;
        let quantity = |(index, varied): (usize, &crate::analysis::VariedQuantity)| {
            let value = best.values[index];
            let is_at = |bound: &f64| (value - bound).abs() <= AT_BOUND * problem.ranges[index];
            OptimizedQuantity {
                name: varied.name.clone(),
                unit: varied.unit.si.clone(),
                start: start[index],
                value,
                is_at_bound: problem.bounds[index].iter().any(is_at),
            }
        };
        let (seen, _) = self.motions.seen(&best.values, Some(&best.beside))?;
        let at_start = self.motions.seen(start, None).ok().and_then(|(seen, _)| problem.worth(&seen));
        Ok(Ok(Best {
            name,
            goal: named.clone(),
            values: [at_start.map(|(goal, _)| sign * goal), Some(sign * best.goal)],
            quantities: self.varying.parameters().iter().enumerate().map(quantity).collect(),
            limits: self.checked.limits_at(best, &seen),
            optima: self.optima(&found),
            ended: best.ended.clone(),
            searches: outcomes.iter().map(|outcome| self.told(outcome)).collect(),
            is_turn: self.request.turn.is_some(),
            evaluations: found.iter().map(|optimum| optimum.evaluations).sum(),
            guesses: best.beside.as_ref().map_or(Ok(Vec::new()), |start| self.varying.moved_guesses(start))?,
        }))
    }

    /// The optima that differ, the best first.
    fn optima(&self, found: &[&EndPoint<Start>]) -> Vec<Optimum> {
        let mut ends: Vec<&&EndPoint<Start>> =
            found.iter().filter(|optimum| optimum.ended == Ended::Settled && optimum.violation() <= MET).collect();
        ends.sort_by(|a, b| a.goal.total_cmp(&b.goal));
        let (mut optima, ranges): (Vec<Optimum>, _) = (Vec::new(), &self.checked.problem.ranges);
        for end in ends {
            let goal = self.checked.sign * end.goal;
            let is_same = |other: &&mut Optimum| {
                let pairs = end.values.iter().zip(&other.values).zip(ranges);
                (goal - other.goal).abs() <= SAME[0] * other.goal.abs()
                    && pairs.into_iter().all(|((one, other), range)| (one - other).abs() <= SAME[1] * range)
            };
            match optima.iter_mut().find(is_same) {
                Some(known) => known.reached += 1,
                None => optima.push(Optimum { goal, values: end.values.clone(), reached: 1 }),
            }
        }
        optima
    }

    fn told(&self, outcome: &Outcome) -> Search {
        match outcome {
            Ok(found) => {
                let ended = match (&found.ended, found.violation() <= MET) {
                    (Ended::Stopped, _) => "stopped".to_owned(),
                    (_, false) => "constraints not met".to_owned(),
                    (Ended::Settled, true) => "optimum".to_owned(),
                    (Ended::Exhausted, true) => "limit of motions reached".to_owned(),
                    (Ended::Stuck(None), true) => "steps became too short".to_owned(),
                    (Ended::Stuck(Some(cause)), true) => format!("no motion beyond: {cause}"),
                };
                Search { values: found.values.clone(), goal: Some(self.checked.sign * found.goal), ended }
            }
            Err(cause) => Search { values: Vec::new(), goal: None, ended: format!("no motion at its starts: {cause}") },
        }
    }

    /// Why there are no values.
    fn nothing(&self, outcomes: Vec<Outcome>) -> OptimizeError {
        let nearest = outcomes.iter().filter_map(|outcome| outcome.as_ref().ok());
        let Some(nearest) = nearest.min_by(|a, b| a.violation().total_cmp(&b.violation())) else {
            return match outcomes.into_iter().find_map(Result::err) {
                Some(cause) => OptimizeError::Study(cause.into()),
                None => OptimizeError::Stopped,
            };
        };
        self.checked.nearest(nearest, self.varying)
    }
}
