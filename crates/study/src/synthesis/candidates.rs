//! The linkages that meet a task, before limits are checked.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use cotree::scene::Faults;
use cotree::task::{Choose, Preference, Task, TaskKind};
use cotree::typeset::number;
use cotree_synthesis::path::{CouplerPath, PathEffort, PathFollower, followers};
use cotree_synthesis::stroke::{self, NoStroke, Stroke};
use cotree_synthesis::within::{Bounded, Wish, bounded_followers};
use cotree_synthesis::{
    Coupler, Dyad, DyadCondition, Family, Linkage, LinkageLimits, Pair, Point, Pose, Region, Special, Zero,
    bounded_couplers, circle_dyad, coupler_cognates, couplers, dyads, extent, nearest_couplers, nearest_dyads,
    nearest_slider_cranks, reach, slider_cranks, special,
};

use super::{CandidateLinkage, Candidates, MET};

/// Of sampled families and of what is met nearly, so many are shown.
const SHOWN: usize = 12;
/// Places of a pin that are tried in each direction, and lines on which it may be.
const PLACES: usize = 13;
const LINES: usize = 41;
/// Points are the same up to this share of the size, and angles \[rad\] up to this difference.
const ALIKE: f64 = 1e-9;
/// A bar that is longer than this many sizes of the task is a slider in all but name.
const LONGEST: f64 = 1e3;

pub fn of(task: &Task, limits: &LinkageLimits) -> Result<Candidates, Faults> {
    match &task.kind {
        TaskKind::Poses { at, tolerance, weight } => poses(task, limits, at, tolerance.as_deref(), weight.as_deref()),
        TaskKind::Function { pairs, is_slider, zero, ground } => {
            function(task, limits, pairs, *is_slider, *zero, *ground)
        }
        TaskKind::Path(path) => {
            refuse_special_path(task, path)?;
            Ok(path_followers(path, limits, task))
        }
        TaskKind::Stroke { crank_turn, way, is_slider, offset, ground } => {
            let found = if *is_slider {
                slider_stroke(limits, *crank_turn, *way, *offset)
            } else {
                rocker_stroke(limits, *crank_turn, *way, *ground)
            };
            found.map_err(|reason| no_stroke(task, reason))
        }
    }
}

fn found(dyads: Vec<Dyad>, candidates: Vec<CandidateLinkage>, most: Option<usize>) -> Candidates {
    Candidates { dyads, candidates, most, left_out: BTreeMap::new() }
}

fn poses(
    task: &Task,
    limits: &LinkageLimits,
    poses: &[Pose],
    tolerance: Option<&[f64]>,
    weight: Option<&[f64]>,
) -> Result<Candidates, Faults> {
    refuse_special(task, poses)?;
    let nearly = poses.len() > 5 || tolerance.is_some() || weight.is_some();
    if nearly && poses.len() < 5 {
        let message = format!("{} poses with tolerances do not determine a linkage", poses.len());
        return Err(task.fault(&message, "remove `tolerance` and `weight`, or give at least five poses"));
    }
    if nearly {
        let one = vec![1.0; poses.len()];
        let weights: Vec<f64> =
            (0..poses.len()).map(|i| weight.unwrap_or(&one)[i].sqrt() / tolerance.unwrap_or(&one)[i]).collect();
        let all: Vec<Dyad> = nearest_dyads(poses, &weights).into_iter().map(|(dyad, _)| dyad).collect();
        let both: Vec<usize> = (0..all.len()).collect();
        return Ok(paired(all, &both, &both, poses, None));
    }
    if poses.len() == 5 {
        let all = dyads(poses, &[]).map_err(|family| of_family(task, family))?;
        let both: Vec<usize> = (0..all.len()).collect();
        return Ok(paired(all, &both, &both, poses, None));
    }
    let sampled = sampled(task, limits, poses)?;
    let all: Vec<Dyad> = sampled.chosen.iter().chain(&sampled.free).copied().collect();
    let chosen: Vec<usize> = (0..sampled.chosen.len()).collect();
    let every: Vec<usize> = (0..all.len()).collect();
    let first = if chosen.is_empty() { &every } else { &chosen };
    let second = if sampled.only_chosen { &chosen } else { &every };
    Ok(paired(all, first, second, poses, Some(SHOWN)))
}

fn refuse_special(task: &Task, poses: &[Pose]) -> Result<(), Faults> {
    match special(poses) {
        None => Ok(()),
        Some(Special::Alike(first, second)) => {
            let message = format!("poses {} and {} are the same", first + 1, second + 1);
            Err(task.fault(&message, "remove one of them"))
        }
        Some(Special::Translation { on_a_line: true }) => Err(task.fault(
            "the body does not turn, and its poses are on a line: they do not determine a four-bar",
            "use a prismatic joint, or change an angle",
        )),
        Some(Special::Translation { on_a_line: false }) => Err(task.fault(
            "the body does not turn: the only linkages are parallelograms, and their pivots are free",
            "use a parallelogram on any two points of the body, or change an angle",
        )),
        Some(Special::OneCentre(centre)) => {
            let (_, size) = extent(poses.iter().map(|pose| pose.at));
            let [x, y] = [centre.re, centre.im].map(|part| number(part, ALIKE * size));
            let message = format!("all poses are turns about one point, ({x} m, {y} m)");
            Err(task.fault(&message, "use a pin there, or change a pose for a linkage"))
        }
    }
}

/// Points that are the same where no crank tells them apart, and pivots that are.
fn refuse_special_path(task: &Task, path: &CouplerPath) -> Result<(), Faults> {
    let (_, size) = extent(path.points.iter().copied());
    let alike = |a: Point, b: Point| (a - b).norm() <= ALIKE * size;
    let twice = path.points.windows(2).position(|two| alike(two[0], two[1])).filter(|_| path.crank.is_none());
    if let Some(place) = twice {
        let message = format!("points {} and {} are the same", place + 1, place + 2);
        return Err(task.fault(&message, "remove one of them"));
    }
    match path.pivots {
        Some([first, second]) if alike(first, second) => {
            Err(task.fault("both pivots are the same point", "move one of them"))
        }
        _ => Ok(()),
    }
}

fn of_family(task: &Task, family: Family) -> Faults {
    let message = match family {
        Family::Free(_) => "the poses are dependent: infinitely many linkages meet them",
        Family::Curve => "a whole curve of dyads meets all poses, as for the bar of a trammel",
    };
    task.fault(message, "remove a pose, so that the free parameters are sampled, or change one slightly")
}

/// Dyads of two to four poses: those that are chosen, and those that are tried.
struct SampledDyads {
    chosen: Vec<Dyad>,
    free: Vec<Dyad>,
    only_chosen: bool,
}

/// Where pins may be: within the limits, else around the poses.
fn region(region: Option<&Region>, middle: Point, size: f64) -> [Point; 2] {
    let around = Point::new(size, size) * 2.0;
    let [low, high] = region.map_or([middle - around, middle + around], Region::bounds);
    let within = |first: f64, other: f64| if first.is_finite() { first } else { other };
    let corner = |point: Point, other: Point| Point::new(within(point.re, other.re), within(point.im, other.im));
    [corner(low, middle - around), corner(high, middle + around)]
}

fn grid([low, high]: [Point; 2], count: usize) -> Vec<Point> {
    let share = |i: usize| (i as f64 + 0.5) / count as f64;
    let at =
        |i: usize, j: usize| Point::new(low.re + (high.re - low.re) * share(i), low.im + (high.im - low.im) * share(j));
    (0..count * count).map(|k| at(k / count, k % count)).collect()
}

fn sampled(task: &Task, limits: &LinkageLimits, poses: &[Pose]) -> Result<SampledDyads, Faults> {
    let (middle, size) = extent(poses.iter().map(|pose| pose.at));
    let ground = region(limits.ground.as_ref(), middle, size);
    let moving = region(limits.moving.as_ref(), Point::new(0.0, 0.0), size);
    let permitted = |dyad: &Dyad| {
        let inside =
            |region: &Option<Region>, pin: Point| region.as_ref().is_none_or(|region| region.outside(pin) == 0.0);
        match *dyad {
            Dyad::Bar { moving, ground, length } => {
                inside(&limits.ground, ground)
                    && inside(&limits.moving, moving)
                    && limits.length.is_none_or(|[low, high]| (low..=high).contains(&length))
                    && length < LONGEST * size
            }
            Dyad::Slider { moving, .. } => inside(&limits.moving, moving),
            Dyad::Slot { ground, .. } => inside(&limits.ground, ground),
        }
    };
    let choose = &task.choose;
    let chosen = chosen(task, choose, poses)?;
    let mut free: Vec<Dyad> = match poses {
        [first, second] => {
            grid(moving, PLACES).into_iter().flat_map(|pin| bisected(pin, first, second, size)).collect()
        }
        &[a, b, c] => {
            let three = [a, b, c];
            let inverse = three.map(|pose| pose.inverse());
            let by_moving = grid(moving, PLACES).into_iter().filter_map(|pin| circle_dyad(pin, &three));
            let by_ground =
                grid(ground, PLACES).into_iter().filter_map(|pin| Some(circle_dyad(pin, &inverse)?.inverse()));
            by_moving.chain(by_ground).collect()
        }
        _ => lines(poses, ground),
    };
    let tried = free.len();
    free.retain(permitted);
    if free.is_empty() && chosen.len() < 2 {
        let message = format!("0 of {tried} bars are within the limits of pins and lengths");
        return Err(task.fault(&message, "widen `ground`, `moving` or `length` of `[limits]`"));
    }
    let only_chosen = choose.lines.is_empty() && chosen.len() >= 2;
    Ok(SampledDyads { chosen, free, only_chosen })
}

/// Bars to the pivots on the line between two places of a pin.
fn bisected(pin: Point, first: &Pose, second: &Pose, size: f64) -> Vec<Dyad> {
    let [from, to] = [first, second].map(|pose| pose.carry(pin));
    let across = (to - from) * Point::new(0.0, 1.0) / (to - from).norm().max(f64::MIN_POSITIVE);
    let bar = |distance: f64| {
        let ground = (from + to) * 0.5 + across * (distance * size);
        Dyad::Bar { moving: pin, ground, length: (ground - from).norm() }
    };
    [-2.0, -1.0, -0.5, 0.5, 1.0, 2.0].map(bar).to_vec()
}

/// The dyads of four poses whose pivot is on one of many lines, and the sliders and slots.
fn lines(poses: &[Pose], [low, high]: [Point; 2]) -> Vec<Dyad> {
    let x = |line: usize| low.re + (high.re - low.re) * (line as f64 + 0.5) / LINES as f64;
    let on = |line: usize| DyadCondition::Ground { direction: Point::new(1.0, 0.0), value: x(line) };
    let conditions = (0..LINES).map(on).chain([DyadCondition::NoBar]);
    conditions.flat_map(|condition| dyads(poses, &[condition]).unwrap_or_default()).collect()
}

/// The dyads with pins that are chosen.
fn chosen(task: &Task, choose: &Choose, poses: &[Pose]) -> Result<Vec<Dyad>, Faults> {
    let mut all = Vec::new();
    for condition in &choose.lines {
        if poses.len() != 4 {
            let message = format!("a line for a pin cannot be combined with {} poses", poses.len());
            return Err(task.fault(&message, "use lines for four poses, and points for two and three"));
        }
        let found = dyads(poses, &[*condition]).map_err(|family| of_family(task, family))?;
        all.extend(found.into_iter().filter(|dyad| matches!(dyad, Dyad::Bar { .. })));
    }
    for side in 0..2 {
        let dyad = match (choose.ground[side], choose.moving[side]) {
            (None, None) => continue,
            (Some(ground), Some(moving)) if poses.len() == 2 => {
                let [from, to] = [0, 1].map(|i| (poses[i].carry(moving) - ground).norm());
                let same = (from - to).abs() < 1e-9 * from.max(to);
                same.then_some(Dyad::Bar { moving, ground, length: from })
            }
            (Some(ground), None) if poses.len() == 3 => {
                let inverse = [0, 1, 2].map(|i| poses[i].inverse());
                circle_dyad(ground, &inverse).map(|dyad| dyad.inverse())
            }
            (None, Some(moving)) if poses.len() == 3 => circle_dyad(moving, &[0, 1, 2].map(|i| poses[i])),
            _ => {
                let message = format!("these chosen pins cannot be combined with {} poses", poses.len());
                let help = "three poses: `ground_a` or `moving_a` (and `ground_b` or `moving_b`); two poses: both of a bar; four: a line";
                return Err(task.fault(&message, help));
            }
        };
        let none = || {
            task.fault(
                "no bar with a chosen pin meets the poses: the positions of the pin are not on a circle",
                "choose another pin",
            )
        };
        all.push(dyad.ok_or_else(none)?);
    }
    Ok(all)
}

/// All pairs of a first and a second dyad, each pair once, with the body exactly on both.
fn paired(all: Vec<Dyad>, first: &[usize], second: &[usize], poses: &[Pose], most: Option<usize>) -> Candidates {
    let mut candidates = Vec::new();
    for (place, &i) in first.iter().enumerate() {
        for &j in second {
            if j == i || first[..place].contains(&j) || (second.contains(&i) && first.contains(&j) && j < i) {
                continue;
            }
            let linkage = Linkage { first: all[i], second: all[j] };
            if !apart(&linkage) {
                continue;
            }
            let (exact, error) = settled(&linkage, poses);
            candidates.push(CandidateLinkage {
                linkage,
                poses: exact,
                error,
                dyads: Some([i, j]),
                both: true,
                price: 0.0,
            });
        }
    }
    found(all, candidates, most)
}

/// Are both pins of the body two pins?
fn apart(linkage: &Linkage) -> bool {
    match (linkage.first, linkage.second) {
        (Dyad::Bar { moving, ground, .. }, Dyad::Bar { moving: other, ground: pivot, .. }) => {
            moving != other && ground != pivot
        }
        (Dyad::Slot { .. }, Dyad::Slot { .. }) => false,
        _ => true,
    }
}

/// The body on the linkage at the inputs of given poses, and how far it is from them: places \[m\].
pub(super) fn settled(linkage: &Linkage, poses: &[Pose]) -> (Vec<Pose>, f64) {
    let linkage = if linkage.has_input() { *linkage } else { linkage.swapped() };
    let mut most: f64 = 0.0;
    let on = |pose: &Pose| {
        // Where a pose is met up to rounding, it is itself: dead points are no places to divide at.
        let met = linkage.first.error(pose).abs().max(linkage.second.error(pose).abs());
        let size = extent(poses.iter().map(|pose| pose.at)).1;
        let exact = (met > 1e-10 * size).then(|| linkage.pose(linkage.input(pose), linkage.side(pose))).flatten();
        let exact = exact.unwrap_or(*pose);
        most = most.max((exact.at - pose.at).norm()).max(if met > 1e-10 * size { met } else { 0.0 });
        exact
    };
    (poses.iter().map(on).collect(), most)
}

fn function(
    task: &Task,
    limits: &LinkageLimits,
    pairs: &[Pair],
    is_slider: bool,
    zero: Zero,
    ground: f64,
) -> Result<Candidates, Faults> {
    let given = usize::from(zero.input.is_some()) + usize::from(zero.output.is_some());
    let count = pairs.len() + if is_slider { usize::from(zero.input.is_some()) } else { given };
    if pairs.len() < 3 {
        return Err(task.fault("a function needs at least three pairs", "add pairs, or write a law"));
    }
    let twice = (0..pairs.len()).find_map(|second| {
        let alike = |pair: &Pair| (pair.input - pairs[second].input).abs() <= ALIKE;
        Some((pairs[..second].iter().position(alike)?, second))
    });
    if let Some((first, second)) = twice {
        let message = format!("pairs {} and {} have the same input", first + 1, second + 1);
        return Err(task.fault(&message, "remove one of them: a function has one output per input"));
    }
    let exact = count == 5;
    let all: Vec<Coupler> = match (is_slider, exact) {
        (false, true) => couplers(pairs, zero).map_err(|family| of_family(task, family))?,
        (true, true) => slider_cranks(pairs, zero.input).map_err(|family| of_family(task, family))?,
        (false, false) => nearest_couplers(pairs, zero),
        (true, false) => nearest_slider_cranks(pairs, zero.input),
    };
    let mut candidates: Vec<CandidateLinkage> =
        all.iter().take(200).filter_map(|coupler| followed(coupler, pairs, ground)).collect();
    let is_bounded = *limits != LinkageLimits::default() || task.limits.within.is_some();
    if is_bounded {
        let length = (!is_slider).then_some(ground);
        let within = bounded_couplers(pairs, zero, length, limits, wish(task));
        candidates.extend(within.iter().filter_map(|coupler| followed(coupler, pairs, ground)));
    }
    Ok(found(Vec::new(), candidates, (!exact || is_bounded).then_some(SHOWN)))
}

/// What a task prefers among linkages that keep its limits.
pub(super) fn wish(task: &Task) -> Wish {
    match (task.limits.within, task.limits.prefer) {
        (None, _) => Wish::Accuracy,
        (Some(within), Preference::Size) => Wish::Size(within),
        (Some(within), Preference::Transmission) => Wish::Transmission(within),
    }
}

/// The body of a coupler where the output is nearest to the pairs.
fn followed(coupler: &Coupler, pairs: &[Pair], ground: f64) -> Option<CandidateLinkage> {
    let coupler = coupler.with_ground(ground);
    let linkage = coupler.linkage;
    let sides: Vec<f64> = pairs.iter().map(|pair| linkage.side(&coupler.pose(pair))).collect();
    let poses: Option<Vec<Pose>> =
        pairs.iter().zip(&sides).map(|(pair, side)| linkage.pose(coupler.input_zero + pair.input, *side)).collect();
    let errors = pairs.iter().zip(&sides).map(|(pair, side)| coupler.error(pair, *side).unwrap_or(PI).abs());
    let error = errors.fold(0.0, f64::max);
    Some(CandidateLinkage { linkage, poses: poses?, error, dyads: None, both: false, price: 0.0 })
}

/// So many points determine finitely many four-bars between given pivots (Morgan, Wampler 1990).
const FINITE: usize = 5;

/// Where a path's task says nothing of lengths, links are at most so many times as large as the path.
pub(super) const SIZES: f64 = 5.0;

/// The limits of a path's search: bars of any length would be as long as a few points on a circle can be far away.
pub(super) fn path_limits(path: &CouplerPath, limits: &LinkageLimits) -> LinkageLimits {
    let mut bounded = limits.clone();
    if path.pivots.is_none() {
        bounded.length = bounded.length.or(Some([0.0, SIZES * reach(&path.points)]));
    }
    bounded
}

fn path_followers(path: &CouplerPath, limits: &LinkageLimits, task: &Task) -> Candidates {
    let mut candidates = Vec::new();
    let all = followers(path, &PathEffort::default());
    // Between given pivots five points have finitely many four-bars: all are shown, and nothing that is only near.
    let is_finite = path.pivots.is_some() && path.points.len() == FINITE;
    let (_, size) = extent(path.points.iter().copied());
    let exact = all.iter().filter(|deviation| is_finite && deviation.largest <= MET * size).count();
    let most = if exact > 0 { exact } else { SHOWN };
    let mut known = Vec::new();
    for follower in all.into_iter().take(most) {
        let PathFollower { linkage, poses, largest, rms } = follower;
        let mut add = |linkage: Linkage, poses: Vec<Pose>| {
            known.push(PathFollower { linkage, poses: poses.clone(), largest, rms });
            let both = path.crank.is_none();
            candidates.push(CandidateLinkage { linkage, poses, error: largest, dyads: None, both, price: 0.0 });
        };
        if path.pivots.is_none() && path.crank.is_none() {
            with_cognates(&linkage, &poses).into_iter().for_each(|(linkage, poses)| add(linkage, poses));
        }
        add(linkage, poses);
    }
    if exact == 0 {
        let limits = path_limits(path, limits);
        let within = bounded_followers(path, &limits, wish(task), &known, &PathEffort::default());
        candidates.extend(within.into_iter().map(|within| bounded(within, path)));
    }
    found(Vec::new(), candidates, (exact == 0).then_some(SHOWN))
}

/// A four-bar that was found within limits.
pub(super) fn bounded(bounded: Bounded, path: &CouplerPath) -> CandidateLinkage {
    let Bounded { follower: PathFollower { linkage, poses, largest, .. }, price } = bounded;
    CandidateLinkage { linkage, poses, error: largest, dyads: None, both: path.crank.is_none(), price }
}

/// Both cognates, their coupler at each place of the point.
fn with_cognates(linkage: &Linkage, poses: &[Pose]) -> Vec<(Linkage, Vec<Pose>)> {
    let origin = Point::new(0.0, 0.0);
    let at = |pose: &Pose| Some(coupler_cognates(linkage, origin, pose)?.map(|(cognate, _)| cognate));
    let Some(first) = poses.first().and_then(at) else { return Vec::new() };
    let pin = |linkage: &Linkage| match linkage.first {
        Dyad::Bar { moving, .. } | Dyad::Slider { moving, .. } => moving,
        Dyad::Slot { .. } => origin,
    };
    let cognate = |which: usize| {
        // A cognate is given in the turn that it has at a pose: its pin says by how much it is turned there.
        let turned = |pose: &Pose| {
            let here = at(pose)?;
            Some(Pose { at: pose.at, angle: (pin(&here[which]) / pin(&first[which])).arg() })
        };
        let all: Option<Vec<Pose>> = poses.iter().map(turned).collect();
        Some((first[which], all?))
    };
    [0, 1].into_iter().filter_map(cognate).collect()
}

/// A linkage on a pivot at the origin: the body between both pins, its frame at the first pin and along the second.
fn between([ground, crank, coupler, rocker]: [f64; 4]) -> Linkage {
    let origin = Point::new(0.0, 0.0);
    Linkage {
        first: Dyad::Bar { moving: origin, ground: origin, length: crank },
        second: Dyad::Bar { moving: Point::new(coupler, 0.0), ground: Point::new(ground, 0.0), length: rocker },
    }
}

/// The linkage at both of its dead centres, where crank and body lie along each other.
fn at_dead_centres(linkage: Linkage, far: Point, near: Point) -> CandidateLinkage {
    let along = |pin: Point, sign: f64| Pose { at: linkage.pin((pin * sign).arg()), angle: pin.arg() };
    let poses = vec![along(far, 1.0), along(near, -1.0)];
    CandidateLinkage { linkage, poses, error: 0.0, dyads: None, both: false, price: 0.0 }
}

/// Shares of the ground that the crank may have where half a turn leaves it free.
const CRANKS: [f64; 6] = [0.05, 0.1, 0.15, 0.2, 0.3, 0.4];

fn rocker_stroke(limits: &LinkageLimits, turn: f64, swing: f64, ground: f64) -> Result<Candidates, NoStroke> {
    let strokes: Vec<Stroke> = match stroke::rocker(turn, swing) {
        Ok(best) => vec![best],
        // At half a turn a shorter crank is always better: the limit of lengths decides.
        Err(NoStroke::NoBest) => {
            let [low, _] = limits.length.ok_or(NoStroke::NoBest)?;
            let least = Some(low / ground).filter(|share| *share > 0.0);
            let all: Vec<f64> = least.into_iter().chain(CRANKS).collect();
            all.into_iter().filter_map(|crank| stroke::central_rocker(swing, crank).ok()).collect()
        }
        Err(reason) => return Err(reason),
    };
    if strokes.is_empty() {
        return Err(NoStroke::NoCrank);
    }
    let candidate = |stroke: &Stroke| {
        let lengths = stroke.lengths.map(|length| length * ground);
        let [ground, crank, coupler, rocker] = lengths;
        // The pin of the rocker, as far from the pivot of the crank as coupler and crank together, and as their difference.
        let pin = |long: f64| {
            let cosine = (ground * ground + long * long - rocker * rocker) / (2.0 * ground * long);
            cotree_synthesis::polar(long, cosine.clamp(-1.0, 1.0).acos())
        };
        at_dead_centres(between(lengths), pin(coupler + crank), pin(coupler - crank))
    };
    Ok(found(Vec::new(), strokes.iter().map(candidate).collect(), None))
}

fn slider_stroke(limits: &LinkageLimits, turn: f64, way: f64, offset: Option<f64>) -> Result<Candidates, NoStroke> {
    let half = (turn - PI).abs() < 1e-9;
    let slider_stroke = match stroke::slider(turn, way, offset) {
        Err(NoStroke::NoBest) if half && offset.is_none_or(|offset| offset == 0.0) => {
            // The longer the rod, the better: the limit of lengths decides.
            let [_, rod] = limits.length.ok_or(NoStroke::NoBest)?;
            stroke::central_slider(way, rod)?
        }
        other => other?,
    };
    let [offset, crank, rod, _] = slider_stroke.lengths;
    let origin = Point::new(0.0, 0.0);
    let linkage = Linkage {
        first: Dyad::Bar { moving: origin, ground: origin, length: crank },
        second: Dyad::Slider { moving: Point::new(rod, 0.0), normal: Point::new(0.0, 1.0), offset },
    };
    let pin = |long: f64| Point::new((long * long - offset * offset).max(0.0).sqrt(), offset);
    let candidate = at_dead_centres(linkage, pin(rod + crank), pin(rod - crank));
    Ok(found(Vec::new(), vec![candidate], None))
}

fn no_stroke(task: &Task, reason: NoStroke) -> Faults {
    let [message, help] = match reason {
        NoStroke::Range => [
            "a turn, swing or stroke is out of range",
            "turns must be between 0 and 360 deg, swings between 0 and 180 deg, strokes positive",
        ],
        NoStroke::NoBest => [
            "at half a turn there is no best linkage: the shorter the crank, the better",
            "give `length` in `[limits]`, or another turn",
        ],
        NoStroke::NoCrank => [
            "no crank-rocker with a fully turning crank has this swing and turn",
            "make the swing smaller, or the turn nearer to 180 degrees",
        ],
        NoStroke::Offset => [
            "no slider-crank has this offset, stroke and turn",
            "make `offset` smaller, or remove it: the best offset is found",
        ],
    };
    task.fault(message, help)
}
