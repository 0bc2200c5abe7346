//! Linkages for a task: found, judged, driven, ranked, written as scenes.

mod candidates;
mod drive;
mod family;
pub mod report;
mod scene;
pub mod six;

use std::collections::BTreeMap;

use cotree::scene::Faults;
use cotree::task::{Task, TaskKind};
use cotree::typeset::number;
use cotree_synthesis::path::{CouplerPath, PathEffort, PathFollower};
use cotree_synthesis::within::{Wish, bounded_followers, smaller_followers};
use cotree_synthesis::{
    Defect, Dyad, Linkage, LinkageLimit, LinkageLimits, Point, Pose, Side, Verdict, extent, judge, reach,
};

use drive::{PoseStation, largest_miss};
use six::{SixSolution, six_bars};

/// The linkages for a task.
#[derive(Clone, Debug)]
pub struct Answer {
    pub task: Task,
    /// The dyads of poses; of other tasks there are none.
    pub dyads: Vec<Dyad>,
    /// Good ones, best first; then the others, if they are asked for.
    pub solutions: Vec<Solution>,
    /// Good ones for a path that are smaller and have larger errors, one after the other.
    pub shorter: Vec<Solution>,
    /// Six-bars, best first, if they are asked for or no four-bar is within what is accepted.
    pub six_bars: Vec<SixSolution>,
    /// How many linkages were left out for each reason.
    pub left_out: BTreeMap<String, usize>,
    /// How many were looked at.
    pub looked_at: usize,
    /// What the last of them missed, and by how much the nearest did.
    pub last: Option<String>,
    /// What linkages without one of the limits reach, where that is more.
    pub costs: Vec<String>,
}

/// A linkage for a task.
#[derive(Clone, Debug)]
pub struct Solution {
    pub linkage: Linkage,
    /// Its two dyads in the list, for poses.
    pub dyads: Option<[usize; 2]>,
    /// Ground, first bar, coupler, second bar, as far as there are \[m\].
    pub lengths: [Option<f64>; 4],
    /// The largest distance of two points of one link, the ground and the point that draws a path included \[m\].
    pub size: f64,
    pub class: &'static str,
    /// By how much the task is missed at most; of a path also how far its curve leaves it between the points \[m or rad\].
    pub error: f64,
    /// The smallest transmission angle over the part used \[rad\].
    pub transmission: f64,
    pub full_turn: bool,
    pub defects: Vec<Defect>,
    /// The limits that it has just reached.
    pub active: Vec<LinkageLimit>,
    /// By how much its root mean square error falls per metre by which the limit of lengths gives way.
    pub price: f64,
    /// Why it is not good; none: it is.
    pub reason: Option<String>,
    /// The body at the poses or points of the task.
    pub poses: Vec<Pose>,
    /// How far the driven scene was from them, as a share of the size.
    pub driven: Option<f64>,
    /// The scene.
    pub scene: Option<String>,
}

/// A linkage before it is judged.
pub(crate) struct CandidateLinkage {
    linkage: Linkage,
    /// The body at the task's poses or points, exactly on the linkage.
    poses: Vec<Pose>,
    error: f64,
    dyads: Option<[usize; 2]>,
    /// May the second dyad be the input too?
    both: bool,
    /// By how much its root mean square error falls per metre by which the limit of lengths gives way.
    price: f64,
}

/// What candidates come with.
pub(crate) struct Candidates {
    dyads: Vec<Dyad>,
    candidates: Vec<CandidateLinkage>,
    /// Only so many good ones are shown, not alike: the others are beside them.
    most: Option<usize>,
    left_out: BTreeMap<String, usize>,
}

/// How far a driven linkage may be from its poses, as a share of the size.
const MET: f64 = 1e-9;
/// A bar that is shorter than this share of the longest is none.
const NO_BAR: f64 = 1e-4;

/// Where the task says nothing of lengths, a bar of a function's linkage that is longer than this many grounds counts as none: its end hardly leaves a straight line.
const FAR: f64 = 20.0;

/// The stages of a search for linkages.
const STAGES: usize = 4;

/// Finds the linkages for a task; with `all`, those that are not good too.
///
/// # Errors
/// Why the task has no answer at all.
pub fn synthesize(task: &Task, all: bool) -> Result<Answer, Faults> {
    synthesize_watched(task, all, &|_, _| {})
}

/// The same; whoever watches is told of each stage that is done, and of how many: linkages are found, judged, driven, and varied.
///
/// # Errors
/// Those of [`synthesize`].
pub fn synthesize_watched(task: &Task, all: bool, watch: &dyn Fn(usize, usize)) -> Result<Answer, Faults> {
    let limits = &task.limits.linkage;
    let found = candidates::of(task, limits)?;
    watch(1, STAGES);
    let mut answer = Answer {
        task: task.clone(),
        dyads: found.dyads,
        solutions: Vec::new(),
        shorter: Vec::new(),
        six_bars: Vec::new(),
        left_out: found.left_out,
        looked_at: found.candidates.len(),
        last: None,
        costs: Vec::new(),
    };
    let mut judged: Vec<Judged> =
        found.candidates.iter().filter_map(|candidate| best(candidate, limits, task)).collect();
    let refined = family::refined(task, limits, &judged);
    judged.extend(refined.iter().filter_map(|candidate| best(candidate, limits, task)));
    watch(2, STAGES);
    answer.looked_at += answer.left_out.values().sum::<usize>() + refined.len();
    for judgement in judged.iter().filter(|judged| judged.reason.is_some()) {
        *answer.left_out.entry(judgement.reason.clone().unwrap_or_default()).or_default() += 1;
    }
    judged.sort_by(|a, b| a.rank(task).total_cmp(&b.rank(task)));
    let most = found.most.unwrap_or(usize::MAX);
    let (good, bad): (Vec<Judged>, Vec<Judged>) = judged.into_iter().partition(|judgement| judgement.reason.is_none());
    answer.last = last(task, &bad, good.is_empty());
    answer.costs = costs(task, &bad, good.first());
    for judgement in good {
        let lengths = judgement.linkage.lengths();
        let is_like = |other: &Solution| is_beside(&other.lengths, &lengths);
        if found.most.is_some() && (answer.solutions.len() >= most || answer.solutions.iter().any(is_like)) {
            *answer.left_out.entry(MORE.to_owned()).or_default() += 1;
            continue;
        }
        let solution = solution(task, judgement, answer.solutions.len() + 1);
        match &solution.reason {
            None => answer.solutions.push(solution),
            Some(reason) => *answer.left_out.entry(reason.clone()).or_default() += 1,
        }
    }
    watch(3, STAGES);
    answer.shorter = shorter(task, limits, &answer.solutions);
    if task.limits.bars == Some(6)
        || (task.limits.bars.is_none() && task.limits.within.is_some() && answer.solutions.is_empty())
    {
        answer.six_bars = six_bars(task, limits, &near(task, limits, &answer.solutions));
        answer
            .six_bars
            .retain(|six_bar| task.limits.within.is_none_or(|within| six_bar.error <= within * (1.0 + 1e-9)));
    }
    if all {
        let shown = bad.into_iter().take(found.most.map_or(usize::MAX, |most| 4 * most));
        answer.solutions.extend(shown.map(undriven));
    }
    watch(STAGES, STAGES);
    Ok(answer)
}

/// Smaller linkages for a path, from good ones on: what size costs.
fn shorter(task: &Task, limits: &LinkageLimits, good: &[Solution]) -> Vec<Solution> {
    let TaskKind::Path(path) = &task.kind else { return Vec::new() };
    if path.pivots.is_some() || task.limits.within.is_some() {
        return Vec::new();
    }
    let known: Vec<PathFollower> = good
        .iter()
        .map(|good| PathFollower {
            linkage: good.linkage,
            poses: good.poses.clone(),
            largest: good.error,
            rms: good.error,
        })
        .collect();
    let found = smaller_followers(path, &candidates::path_limits(path, limits), &known, SMALLER);
    let judged = found.into_iter().filter_map(|candidate| best(&candidates::bounded(candidate, path), limits, task));
    let driven = judged
        .filter(|judged| judged.reason.is_none())
        .enumerate()
        .map(|(index, judgement)| solution(task, judgement, index + 1));
    let all: Vec<Solution> = driven.filter(|driven| driven.reason.is_none()).collect();
    // One that is larger than a later one and has a larger error is no choice.
    let is_choice = |candidate: &Solution| {
        good.iter().take(1).chain(&all).all(|other| other.size >= candidate.size || other.error > candidate.error)
            && !good.iter().take(1).any(|best| candidate.size > 0.99 * best.size)
    };
    let mut choices: Vec<Solution> = Vec::new();
    for candidate in all.iter().filter(|candidate| is_choice(candidate)) {
        if choices.last().is_none_or(|last| candidate.size < 0.99 * last.size) {
            choices.push(candidate.clone());
        }
    }
    choices
}

/// Four-bars near a path, within what is accepted or not: six-bars start from them.
fn near(task: &Task, limits: &LinkageLimits, good: &[Solution]) -> Vec<Solution> {
    let TaskKind::Path(path) = &task.kind else { return good.to_vec() };
    if !good.is_empty() {
        return good.to_vec();
    }
    let limits = candidates::path_limits(path, limits);
    let found = bounded_followers(path, &limits, Wish::Accuracy, &[], &PathEffort::default());
    found
        .into_iter()
        .filter_map(|candidate| best(&candidates::bounded(candidate, path), &limits, task))
        .map(undriven)
        .collect()
}

/// So many smaller and smaller linkages are looked for.
const SMALLER: usize = 8;

/// A candidate with its better input.
struct Judged {
    linkage: Linkage,
    verdict: Verdict,
    poses: Vec<Pose>,
    size: f64,
    error: f64,
    dyads: Option<[usize; 2]>,
    reason: Option<String>,
    /// How far it came: the more the later was the reason; and by how much it misses a limit.
    stage: usize,
    miss: f64,
    /// The limits that it misses, and by how much.
    misses: Vec<(LinkageLimit, f64)>,
    active: Vec<LinkageLimit>,
    price: f64,
}

impl Judged {
    /// The only limit that it misses.
    fn alone(&self) -> Option<LinkageLimit> {
        match &self.misses[..] {
            [(limit, _)] if self.verdict.defects.is_empty() => Some(*limit),
            _ => None,
        }
    }

    /// The less the better: what is preferred where errors are small enough; the error where tasks are met nearly, else the transmission angle.
    fn rank(&self, task: &Task) -> f64 {
        match candidates::wish(task) {
            Wish::Accuracy => {}
            Wish::Size(_) => return self.size,
            Wish::Transmission(_) => return -self.verdict.transmission,
        }
        let size = extent(self.poses.iter().map(|pose| pose.at)).1;
        let nearly = matches!(task.kind, TaskKind::Path(_) | TaskKind::Function { .. }) || self.error > 1e-7 * size;
        if nearly && self.error > 1e-7 * size {
            self.error / size - 1e-6 * self.verdict.transmission
        } else {
            -self.verdict.transmission
        }
    }
}

/// Judged with the input that serves best; none if there is no input.
fn best(candidate: &CandidateLinkage, limits: &LinkageLimits, task: &Task) -> Option<Judged> {
    let swapped = candidate.dyads.map(|[i, j]| [j, i]);
    let ways = [(candidate.linkage, candidate.dyads), (candidate.linkage.swapped(), swapped)];
    let count = if candidate.both { 2 } else { 1 };
    let judged = ways.into_iter().take(count).filter(|(linkage, _)| linkage.has_input()).map(|(linkage, dyads)| {
        let verdict = judged(&linkage, &candidate.poses, limits.crank || is_turn(task), task);
        let (error, size) = (error(candidate, &linkage, &verdict, task), linkage.size(limits.tracer));
        let misses = limits.misses(&linkage, &verdict);
        let defect = verdict.defects.first().map(|defect| (*defect as usize + 1, reason_of(*defect).to_owned(), 0.0));
        let odd = disproportion(task, candidate, &linkage, &verdict).map(|reason| (0, reason, 0.0));
        let limit =
            misses.first().map(|(limit, miss)| (*limit as usize + 4, format!("limit `{}`", limit.name()), *miss));
        let within = task.limits.within.filter(|within| error > within * (1.0 + 1e-9));
        let within = within.map(|within| (WITHIN, "error above `within`".to_owned(), error - within));
        let (stage, reason, miss) = match odd.or(defect).or(limit).or(within) {
            Some((stage, reason, miss)) => (stage, Some(reason), miss),
            None => (WITHIN + 1, None, 0.0),
        };
        let (active, poses, price) = (limits.active(&linkage, &verdict), candidate.poses.clone(), candidate.price);
        Judged { linkage, verdict, poses, size, error, dyads, reason, stage, miss, misses, active, price }
    });
    judged.max_by(|a, b| {
        (a.stage, a.verdict.transmission)
            .partial_cmp(&(b.stage, b.verdict.transmission))
            .unwrap_or(std::cmp::Ordering::Equal)
    })
}

/// How far a linkage came that keeps all limits and is off by too much.
const WITHIN: usize = 10;

/// By how much a task is missed: of a path also how far the curve leaves it between its points.
fn error(candidate: &CandidateLinkage, linkage: &Linkage, verdict: &Verdict, task: &Task) -> f64 {
    match &task.kind {
        TaskKind::Path(path) => candidate.error.max(path.departure(linkage, verdict)),
        TaskKind::Poses { .. } | TaskKind::Function { .. } | TaskKind::Stroke { .. } => candidate.error,
    }
}

/// Why a linkage is none: a bar that vanishes, a closed path without a full turn, or, where the task says nothing of lengths, bars out of all proportion.
fn disproportion(task: &Task, candidate: &CandidateLinkage, linkage: &Linkage, verdict: &Verdict) -> Option<String> {
    let lengths = || linkage.lengths().into_iter().flatten();
    let (longest, shortest) = (lengths().fold(0.0, f64::max), lengths().fold(f64::INFINITY, f64::min));
    if shortest < NO_BAR * longest {
        return Some("a bar is shorter than 0.0001 of the longest".to_owned());
    }
    if is_turn(task) && !verdict.full_turn && matches!(task.kind, TaskKind::Path(_)) {
        return Some("the input does not turn fully, as a closed path needs".to_owned());
    }
    if task.limits.linkage.length.is_some() {
        return None;
    }
    let no_limit = "give `length` in `[limits]` to permit it";
    match &task.kind {
        TaskKind::Function { ground, is_slider: false, .. } if longest > FAR * ground => {
            Some(format!("a bar is more than {FAR} times as long as the ground; {no_limit}"))
        }
        TaskKind::Path(CouplerPath { points, pivots: None, .. }) => {
            let reach = reach(points);
            let is_it = points.len() >= DETERMINED && candidate.error <= 1e-7 * reach;
            let far = linkage.size(true) > candidates::SIZES * reach && !is_it;
            far.then(|| format!("a link is more than {} times as large as the path; {no_limit}", candidates::SIZES))
        }
        TaskKind::Function { .. } | TaskKind::Poses { .. } | TaskKind::Path(_) | TaskKind::Stroke { .. } => None,
    }
}

/// So many points of a path are met by one four-bar and its cognates only.
const DETERMINED: usize = 10;

fn reason_of(defect: Defect) -> &'static str {
    match defect {
        Defect::Circuit => "circuit defect: the poses are in different circuits",
        Defect::Branch => "branch defect: the input passes a dead point between poses",
        Defect::Order => "order defect: the poses are reached in another order",
    }
}

/// Points of a path are looked at for their order only where they are well apart: noise may exchange neighbours.
const APART: usize = 8;

fn judged(linkage: &Linkage, poses: &[Pose], turn: bool, task: &Task) -> Verdict {
    let mut verdict = judge(linkage, poses, turn);
    if !matches!(task.kind, TaskKind::Path(_)) || !verdict.defects.contains(&Defect::Order) {
        return verdict;
    }
    let thin: Vec<Pose> = poses.iter().step_by(poses.len().div_ceil(APART)).copied().collect();
    let sparse = judge(linkage, &thin, turn);
    if !sparse.defects.contains(&Defect::Order) {
        verdict.defects.retain(|defect| *defect != Defect::Order);
        if let (true, [first, second, ..]) = (verdict.full_turn, &sparse.inputs[..]) {
            let sense = (second - first).signum();
            let turned = |input: &f64| first + sense * (sense * (input - first)).rem_euclid(std::f64::consts::TAU);
            verdict.inputs = verdict.inputs.iter().map(turned).collect();
        }
    }
    verdict
}

/// An error in the task's own unit.
fn written(task: &Task, error: f64) -> String {
    if task.is_angular() {
        format!("{} deg", number(error.to_degrees(), 0.0))
    } else {
        format!("{} mm", number(1e3 * error, 0.0))
    }
}

/// What removed the last linkages, and how near the nearest came.
fn last(task: &Task, bad: &[Judged], none_is_good: bool) -> Option<String> {
    let stage = bad.iter().map(|bad| bad.stage).max().filter(|_| none_is_good)?;
    let those = || bad.iter().filter(|bad| bad.stage == stage);
    let nearest = those().min_by(|a, b| a.miss.total_cmp(&b.miss))?;
    let reason = nearest.reason.as_deref()?;
    let count = those().count();
    let near = match reason {
        "limit `transmission`" => {
            let angle = nearest.verdict.transmission.to_degrees();
            format!("; the best has {angle:.1} deg")
        }
        "limit `ground`" | "limit `moving`" | "limit `length`" => {
            format!("; the closest misses it by {} mm", number(1e3 * nearest.miss, 0.0))
        }
        _ if stage == WITHIN => format!("; the closest has an error of {}", written(task, nearest.error)),
        _ => String::new(),
    };
    Some(format!("the closest {count}: {reason}{near}"))
}

/// Of each limit what the best linkage reaches that misses it alone, if that is more than the best one that misses none.
fn costs(task: &Task, bad: &[Judged], best: Option<&Judged>) -> Vec<String> {
    if !matches!(task.kind, TaskKind::Path(_) | TaskKind::Function { .. }) {
        return Vec::new();
    }
    let all = [
        LinkageLimit::Ground,
        LinkageLimit::Moving,
        LinkageLimit::Length,
        LinkageLimit::Crank,
        LinkageLimit::Transmission,
    ];
    let cost = |limit: LinkageLimit| {
        let alone = bad.iter().filter(|bad| bad.alone() == Some(limit));
        let nearest = alone.min_by(|a, b| a.error.total_cmp(&b.error))?;
        if best.is_some_and(|best| best.error <= nearest.error) {
            return None;
        }
        let (error, size) = (written(task, nearest.error), number(1e3 * nearest.size, 0.0));
        let angle = number(nearest.verdict.transmission.to_degrees(), 0.0);
        let name = limit.name();
        Some(format!(
            "without the limit `{name}` a linkage has an error of {error}: its size is {size} mm, its transmission angle at least {angle} deg"
        ))
    };
    all.into_iter().filter_map(cost).collect()
}

/// Why good linkages of a sampled family are not shown.
const MORE: &str = "also good, but similar to a listed one, or after the last listed one";

/// Are two linkages of a sampled family neighbours?
fn is_beside(a: &[Option<f64>; 4], b: &[Option<f64>; 4]) -> bool {
    let size = a.iter().flatten().copied().fold(0.0, f64::max);
    a.iter().zip(b).all(|(a, b)| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() < 0.1 * size,
        _ => a.is_none() && b.is_none(),
    })
}

fn undriven(judged: Judged) -> Solution {
    Solution {
        linkage: judged.linkage,
        dyads: judged.dyads,
        lengths: judged.linkage.lengths(),
        size: judged.size,
        class: class(&judged.linkage, &judged.verdict),
        error: judged.error,
        transmission: judged.verdict.transmission,
        full_turn: judged.verdict.full_turn,
        defects: judged.verdict.defects,
        active: judged.active,
        price: judged.price,
        reason: judged.reason,
        poses: judged.poses,
        driven: None,
        scene: None,
    }
}

/// Written as a scene, and driven by the program: what it does not do is no solution.
fn solution(task: &Task, judged: Judged, number: usize) -> Solution {
    let inputs = &judged.verdict.inputs;
    let (_, size) = extent(judged.poses.iter().map(|pose| pose.at));
    let (first, last) = (inputs.first().copied().unwrap_or(0.0), inputs.last().copied().unwrap_or(0.0));
    let sense = if last < first { -1.0 } else { 1.0 };
    let start = inputs.iter().map(|input| sense * input).fold(f64::INFINITY, f64::min) * sense;
    let end = inputs.iter().map(|input| sense * input).fold(f64::NEG_INFINITY, f64::max) * sense;
    let turns = matches!(judged.linkage.first, Dyad::Bar { .. });
    let whole = turns && judged.verdict.full_turn && (task.limits.linkage.crank || is_turn(task));
    let end = if whole { start + sense * std::f64::consts::TAU } else { end };
    let duration = if turns { (end - start).abs() } else { 1.0 };
    let time = |input: f64| (input - start) / (end - start) * duration;
    let mut stations: Vec<PoseStation> =
        inputs.iter().zip(&judged.poses).map(|(input, pose)| PoseStation { time: time(*input), pose: *pose }).collect();
    stations.sort_by(|a, b| a.time.total_cmp(&b.time));
    let begin = stations.first().map_or(Pose::new(0.0, 0.0, 0.0), |station| station.pose);
    let name = format!("{}_{number}", cotree::model::identifier(&task.name));
    let about = format!("{} for the task {}", class(&judged.linkage, &judged.verdict), task.name);
    let driven = scene::DrivenLinkage {
        name: &name,
        about: &about,
        linkage: &judged.linkage,
        start: begin,
        way: [start, end],
        duration,
    };
    let text = scene::text(&driven);
    let miss = largest_miss(&text, &stations, size);
    let mut solution = undriven(judged);
    match miss {
        Ok(miss) if miss <= MET => solution.driven = Some(miss),
        Ok(_) => solution.reason = Some("misses its poses in the simulation".to_owned()),
        Err(_) => solution.reason = Some("cannot be driven through its poses".to_owned()),
    }
    solution.scene = Some(text);
    solution
}

fn is_turn(task: &Task) -> bool {
    match &task.kind {
        TaskKind::Stroke { .. } => true,
        TaskKind::Path(path) => path.closed,
        TaskKind::Poses { .. } | TaskKind::Function { .. } => false,
    }
}

/// What people call it, its input first.
fn class(linkage: &Linkage, verdict: &Verdict) -> &'static str {
    let [ground, first, body, second] = linkage.lengths();
    match (linkage.first, linkage.second) {
        (Dyad::Bar { .. }, Dyad::Bar { .. }) => {}
        (Dyad::Bar { .. }, Dyad::Slider { .. }) => return "slider-crank",
        (Dyad::Slider { .. }, Dyad::Bar { .. }) => return "slider-crank, driven at the slider",
        (Dyad::Slider { .. }, Dyad::Slider { .. }) => return "double slider",
        (Dyad::Slot { .. }, _) | (_, Dyad::Slot { .. }) => return "linkage with a slot",
    }
    let shortest = [ground, first, body, second].into_iter().flatten().fold(f64::INFINITY, f64::min);
    match verdict.grashof {
        None => "four-bar at a change point",
        Some(false) => "triple rocker",
        Some(true) if ground == Some(shortest) => "double crank",
        Some(true) if first == Some(shortest) => "crank-rocker",
        Some(true) if second == Some(shortest) => "crank-rocker, driven at the rocker",
        Some(true) => "double rocker",
    }
}

impl Solution {
    /// The curve of the body's origin: over the whole circuit, and where the body is at the task's poses.
    pub fn curve(&self) -> Vec<Point> {
        let Some(first) = self.poses.first() else { return Vec::new() };
        if !matches!(self.linkage.first, Dyad::Bar { .. }) {
            return self.poses.iter().map(|pose| pose.at).collect();
        }
        let circuit: Vec<(f64, Side)> = self.linkage.circuit(first, 240);
        let mut points: Vec<Point> = circuit
            .into_iter()
            .filter_map(|(input, side)| self.linkage.pose(input, side))
            .map(|pose| pose.at)
            .collect();
        points.extend(points.first().copied());
        points
    }
}
