//! Active supports in an equilibrium: the modes of unilateral constraints are tried one after another, and friction sticks.
//!
//! A rest is one where what is open does not go in, what is closed presses, what is caught drives, and what sticks holds no more than it can.

use std::cell::RefCell;

use cotree::expr::{Symbol, Values};
use cotree::formulate::Formulated;
use cotree::model::{DiscreteId, Mechanism};
use nalgebra::DMatrix;

use super::contacts::{ContactKind, ContactStatus, TOUCHING, statuses, told};
use super::decompose::svd;
use super::requested::{RequestedMode, WantedMode};
use super::search::{Misfit, scales, search};
use super::sharing::{carry_all, share, sharing};
use super::variation::{ColumnBlock, RowBlock, Rubbing, Variation};
use super::{AnalysisFailure, OperatingPoint};

/// All modes are tried: of more parts than these there are too many.
const MOST: usize = 8;
/// Rows depend on each other where a singular value is below this share of the largest.
const DETERMINED: f64 = 1e-10;
/// Rounding error of a force by the largest that a change of the size of the mechanism makes.
const ROUNDING: f64 = 1e-14;

/// What to do where it slides.
pub(super) const ELSEWHERE: &str = "start elsewhere by `[initial]`, or let `simulate` find where it comes to rest";

/// Where something rests.
pub(super) struct Rest {
    pub point: OperatingPoint,
    /// What holds something together with others, so that how they share it is not determined: the point has one way.
    pub shared: Vec<String>,
}

/// What becomes of a search in one mode.
pub(super) enum Outcome {
    Rests(Rest),
    /// The loads balance and everything else fits, but what sticks holds more than it can at this point.
    Slides(AnalysisFailure, Box<OperatingPoint>),
    Fails(AnalysisFailure),
}

/// Searches for a rest in one mode after another, from that in which everything that touches at the guess is closed to those that differ from it most. What rubs sticks where the guess puts it. In other
/// modes than the guess's a rest that the slightest push would end (not `lasts`) counts only if there is no other.
///
/// # Errors
/// There is none in any mode, or what carries is not determined.
pub(super) fn rest(
    formulated: &Formulated,
    variation: &Variation,
    guess: &OperatingPoint,
    requested: &[RequestedMode],
    lasts: impl Fn(&OperatingPoint) -> Result<bool, AnalysisFailure>,
) -> Result<Rest, AnalysisFailure> {
    let mechanism = &*formulated.equations.system.mechanism;
    if mechanism.contacts.is_empty() {
        let point = search(formulated, variation, guess.clone(), |_| None)?;
        return Ok(Rest { point, shared: Vec::new() });
    }
    let modes = modes(formulated, guess, requested)?;
    let guess = standing(formulated, guess);
    let (mut first, mut slid, mut unsteady) = (None, None, None);
    for (place, mode) in modes.iter().enumerate() {
        let mut point = guess.clone();
        mode.iter().enumerate().for_each(|(index, &closed)| point.set_discrete(mask(mechanism, index, closed)));
        let outcome = in_mode(formulated, variation, point, requested).and_then(|outcome| {
            // Of forces that are not determined it is not known, either, whether what sticks can hold them.
            if let Outcome::Slides(_, point) = &outcome {
                check_determined(formulated, variation, point)?;
            }
            Ok(outcome)
        });
        match outcome {
            Ok(Outcome::Rests(rest)) => {
                check_determined(formulated, variation, &rest.point)?;
                if place == 0 || lasts(&rest.point)? {
                    return Ok(rest);
                }
                unsteady = unsteady.or(Some(rest));
            }
            // It slides from where it was put: a rest in another mode is somewhere else.
            Ok(Outcome::Slides(failure, _)) if place == 0 => return Err(without_idle(mechanism, requested, failure)),
            Ok(Outcome::Slides(failure, _)) => slid = slid.or(Some(without_idle(mechanism, requested, failure))),
            Ok(Outcome::Fails(failure)) => first = first.or(Some(failure)),
            Err(failure) if place == 0 => return Err(failure),
            Err(failure) => slid = slid.or(Some(failure)),
        }
    }
    if let Some(rest) = unsteady {
        return Ok(rest);
    }
    Err(match slid.or(first) {
        Some(cause) if modes.len() > 1 => AnalysisFailure::Other(format!(
            "{cause} (in the mode of the start; there is no equilibrium in any of the {} combinations of open or closed, free or engaged)",
            modes.len()
        )),
        Some(cause) => cause,
        None => AnalysisFailure::Other("the requested modes have no equilibrium".to_owned()),
    })
}

/// What could hold more is idle because that was asked for.
fn without_idle(mechanism: &Mechanism, requested: &[RequestedMode], failure: AnalysisFailure) -> AnalysisFailure {
    let idle = requested.iter().filter(|part| part.wanted == WantedMode::Idle);
    let idle: Vec<String> = idle.map(|idle| format!("`{}`", mechanism.contacts[idle.index].name)).collect();
    match failure {
        AnalysisFailure::Unfit { why } if !idle.is_empty() => {
            AnalysisFailure::Unfit { why: format!("without {}, which `--mode` makes idle, {why}", idle.join(", ")) }
        }
        failure => failure,
    }
}

/// Searches in the mode of a point; where several that rub hold the same, they share it. Where something is to be about to slide, from where it balances if it sticks.
fn in_mode(
    formulated: &Formulated,
    variation: &Variation,
    point: OperatingPoint,
    requested: &[RequestedMode],
) -> Result<Outcome, AnalysisFailure> {
    let mechanism = &*formulated.equations.system.mechanism;
    let verges = requested.iter().filter_map(|request| match request.wanted {
        WantedMode::Slides(way) => Some((request.index, way.unwrap_or_default())),
        WantedMode::Holds | WantedMode::LetsGo | WantedMode::Idle => None,
    });
    let verges: Vec<(usize, f64)> = verges.collect();
    let found = match sharing(formulated, variation, &point)? {
        None => attempt(formulated, variation, point),
        Some(sharing) if verges.is_empty() => return share(formulated, variation, point, sharing),
        Some(shared) => {
            // What carries all that it can has no share to be found.
            let mut others = point.clone();
            verges.iter().for_each(|&(index, _)| others.set_discrete(mask(mechanism, index, false)));
            let [all, left] = [&point, &others].map(|point| ranked(formulated, variation, point));
            // If the others hold it still, nothing is about to slide.
            if left?[1] == all?[1] || sharing(formulated, variation, &others)?.is_some() {
                return Err(shared.has_no_verge());
            }
            share(formulated, variation, point, shared)?
        }
    };
    match found {
        found if verges.is_empty() => Ok(found),
        Outcome::Rests(Rest { point, .. }) => verge(formulated, variation, point, &verges),
        Outcome::Slides(_, point) => verge(formulated, variation, *point, &verges),
        Outcome::Fails(failure) => Ok(Outcome::Fails(failure)),
    }
}

/// Searches for where these hold all that they can, against sliding this way; and holds them there: by those that stick, as many as are not held twice, and by the full force of the others.
fn verge(
    formulated: &Formulated,
    variation: &Variation,
    mut point: OperatingPoint,
    verges: &[(usize, f64)],
) -> Result<Outcome, AnalysisFailure> {
    verges.iter().for_each(|&(index, way)| carry_all(formulated, &mut point, index, way));
    let mut outcome = attempt(formulated, variation, point);
    if let Outcome::Rests(Rest { point, .. }) = &mut outcome {
        let here = statuses(formulated, point);
        for status in here.iter().filter(|here| verges.iter().any(|(index, _)| *index == here.index)) {
            let mut stuck = point.clone();
            stick(formulated, &mut stuck, status);
            if !is_held_twice(formulated, variation, &stuck)? {
                *point = stuck;
            }
        }
    }
    Ok(outcome)
}

/// Lets what carries all that it can stick where it is, with the same force.
fn stick(formulated: &Formulated, point: &mut OperatingPoint, status: &ContactStatus) {
    let contact = &formulated.equations.system.mechanism.contacts[status.index];
    point.set_discrete((contact.state.closed.0, 1.0));
    if let (Some(place), Some(direction)) = (contact.state.place, contact.state.direction) {
        point.set_discrete((place.0, point.value(Symbol::Discrete(place.0)) + status.gap));
        point.set_discrete((direction.0, 0.0));
    }
    if let Some(row) = formulated.equations.row_of_contact(status.index) {
        point.reactions_mut()[row] = -status.force;
    }
}

/// Searches from a point, in its mode.
pub(super) fn attempt(formulated: &Formulated, variation: &Variation, point: OperatingPoint) -> Outcome {
    let slides = RefCell::new(None);
    let found = search(formulated, variation, point, |point| {
        let levelled = levelled(formulated, variation, point);
        let misfit = unfit(formulated, variation, point, &levelled)?;
        slides.replace(misfit.slides.then(|| Box::new(levelled)));
        Some(misfit)
    });
    match (found, slides.into_inner()) {
        (Ok(point), _) => Outcome::Rests(Rest { point: levelled(formulated, variation, &point), shared: Vec::new() }),
        (Err(failure), Some(point)) => Outcome::Slides(failure, point),
        (Err(failure), None) => Outcome::Fails(failure),
    }
}

/// The discrete variable by which a part is open or closed, and its value.
pub(super) fn mask(mechanism: &Mechanism, index: usize, closed: bool) -> (usize, f64) {
    (mechanism.contacts[index].state.closed.0, f64::from(u8::from(closed)))
}

/// A point at which what is held wherever it stands is held where it stands, and nothing slides.
fn standing(formulated: &Formulated, guess: &OperatingPoint) -> OperatingPoint {
    let mut point = guess.clone();
    for status in statuses(formulated, guess) {
        let contact = &formulated.equations.system.mechanism.contacts[status.index];
        if let Some(place) = contact.state.place {
            point.set_discrete((place.0, guess.value(Symbol::Discrete(place.0)) + status.gap));
        }
        if let Some(direction) = contact.state.direction {
            point.set_discrete((direction.0, 0.0));
        }
    }
    point
}

/// The same point with the levels of what rubs, and the signs of what presses there.
fn levelled(formulated: &Formulated, variation: &Variation, point: &OperatingPoint) -> OperatingPoint {
    let mut found = point.clone();
    for rubbing in variation.rubbing() {
        let (level, sums) = level(formulated, rubbing, point);
        found.reactions_mut()[rubbing.level.row] = level;
        let friction = &formulated.equations.system.mechanism.contacts[rubbing.place];
        for (sign, sum) in friction.state.signs.iter().zip(sums) {
            found.set_discrete((sign.0, if sum < 0.0 { -1.0 } else { 1.0 }));
        }
    }
    found
}

/// The level of something that rubs, with the sums whose sizes press.
fn level(formulated: &Formulated, rubbing: &Rubbing, point: &OperatingPoint) -> (f64, Vec<f64>) {
    let wanted = [[rubbing.level.free, rubbing.level.share].as_slice(), &rubbing.level.pressing.sums()].concat();
    let values = formulated.equations.system.arena.evaluate(&wanted, point);
    let sums = values[2..].to_vec();
    (values[0] + values[1] * rubbing.level.pressing.size(&sums), sums)
}

/// Which parts are closed, in every mode that there can be: next to that of the guess first. What rubs sticks wherever something presses.
fn modes(
    formulated: &Formulated,
    guess: &OperatingPoint,
    requested: &[RequestedMode],
) -> Result<Vec<Vec<bool>>, AnalysisFailure> {
    let mechanism = &*formulated.equations.system.mechanism;
    let count = mechanism.contacts.len();
    let mut start = vec![false; count];
    // A freewheel stands still at rest, and so touches.
    statuses(formulated, guess)
        .iter()
        .for_each(|status| start[status.index] = status.touches() || status.kind == ContactKind::Freewheel);
    for request in requested {
        start[request.index] = request.wanted == WantedMode::Holds;
        if request.wanted == WantedMode::Slides(None) {
            return Err(AnalysisFailure::Other(format!(
                "`{}` does not slide at an equilibrium; request this mode at a time of the motion (`--at`)",
                mechanism.contacts[request.index].name
            )));
        }
    }
    let rubs = |index: usize| mechanism.contacts[index].slip.is_some();
    let is_free = |index: &usize| !rubs(*index) && requested.iter().all(|part| part.index != *index);
    let free: Vec<usize> = (0..count).filter(is_free).collect();
    if free.len() > MOST {
        return Err(AnalysisFailure::Other(format!(
            "{} unilateral constraints have too many combinations of open and closed (at most {MOST} constraints are tried); set some of them by --mode",
            free.len()
        )));
    }
    let mut changes: Vec<usize> = (0..1 << free.len()).collect();
    changes.sort_by_key(|change| change.count_ones());
    let is_idle = |index: usize| requested.iter().any(|part| part.index == index && part.wanted == WantedMode::Idle);
    let mode = |change: usize| {
        let mut mode = start.clone();
        free.iter().enumerate().for_each(|(place, &index)| mode[index] ^= change >> place & 1 == 1);
        for index in (0..count).filter(|&index| rubs(index)) {
            let on = mechanism.contacts[index].slip.as_ref().and_then(|slip| slip.on);
            mode[index] = on.is_none_or(|on| mode[on]) && !is_idle(index);
        }
        mode
    };
    // A joint is not at both of its limits, and what is to stick is pressed.
    let owner = |index: usize| mechanism.contacts[index].owner;
    let is_possible = |mode: &Vec<bool>| {
        let closed = || (0..count).filter(|&index| mode[index] && !rubs(index));
        closed().all(|one| closed().all(|other| one == other || owner(one) != owner(other)))
            && requested
                .iter()
                .all(|part| !matches!(part.wanted, WantedMode::Holds | WantedMode::Slides(_)) || mode[part.index])
    };
    Ok(changes.into_iter().map(mode).filter(is_possible).collect())
}

/// Rounding errors of forces along angles and along lengths: of a balance of what is as large as the stiffness makes it.
fn noise(formulated: &Formulated, variation: &Variation, point: &OperatingPoint) -> [f64; 2] {
    let numbers = variation.motion_at(&formulated.equations, point);
    let tangent =
        numbers.map_or_else(|_| DMatrix::zeros(0, 0), |blocks| blocks.block(RowBlock::Motion, ColumnBlock::Positions));
    let scales = &scales(formulated)[..formulated.equations.coordinates.len().min(tangent.nrows())];
    let places = (0..scales.len()).flat_map(|i| (0..scales.len()).map(move |j| (i, j)));
    let energy = places.fold(0.0, |most: f64, (i, j)| most.max((tangent[(i, j)] * scales[i] * scales[j]).abs()));
    [ROUNDING * energy, ROUNDING * energy / formulated.lowered.program.length]
}

/// Why a pose in which the loads balance is no rest; `searched` has the signs of what presses that the search has assumed.
fn unfit(
    formulated: &Formulated,
    variation: &Variation,
    searched: &OperatingPoint,
    point: &OperatingPoint,
) -> Option<Misfit> {
    let mechanism = &formulated.equations.system.mechanism;
    let here = statuses(formulated, point);
    let reactions = (0..formulated.equations.constraints.len()).map(|row| point.value(Symbol::Reaction(row)).abs());
    let least = TOUCHING * reactions.fold(0.0, f64::max);
    let noise = noise(formulated, variation, point);
    let stops = here.iter().find_map(|status| {
        let ([length, force], name) = (status.units(), &status.name);
        match status.kind {
            ContactKind::Stop if status.closed && status.force < -least => {
                Some(format!("`{name}` would pull with {}", told(mechanism, -status.force, force)))
            }
            ContactKind::Freewheel if status.closed && status.force < -least - noise[usize::from(!status.angular)] => {
                Some(format!("`{name}` would resist with {}", told(mechanism, -status.force, force)))
            }
            ContactKind::Stop if status.is_passed() => {
                Some(format!("`{name}` is exceeded by {}", told(mechanism, -status.gap, length)))
            }
            ContactKind::Stop | ContactKind::Freewheel | ContactKind::Friction { .. } | ContactKind::Led => None,
        }
    });
    let slides = here.iter().find_map(|status| {
        let (needed, most, unit) = (status.force.abs(), status.most()?, status.units()[1]);
        (needed > most + least + noise[usize::from(!status.angular)]).then(|| {
            let [needed, most] = [needed, most].map(|value| told(mechanism, value, unit));
            format!(
                "`{}` would need {needed}, but its friction limit is {most}: it slides from this configuration; {ELSEWHERE}",
                status.name
            )
        })
    });
    let turned = here.iter().find_map(|status| {
        let state = &mechanism.contacts[status.index].state;
        let acts = point.value(Symbol::Discrete(state.direction?.0)) != 0.0;
        let same = |sign: &DiscreteId| {
            let sign = Symbol::Discrete(sign.0);
            searched.value(sign) == point.value(sign)
        };
        (acts && !state.signs.iter().all(same))
            .then(|| format!("the normal force of `{}` has the opposite sign of the one assumed", status.name))
    });
    let slides = slides.map(|why| Misfit { why, slides: true });
    stops.or(turned).map(|why| Misfit { why, slides: false }).or(slides)
}

/// The Jacobian of the loop equations that hold at a point, in natural units, and which they are.
pub(super) fn rows(
    formulated: &Formulated,
    variation: &Variation,
    point: &OperatingPoint,
) -> Result<(DMatrix<f64>, Vec<usize>), AnalysisFailure> {
    let numbers = variation.loops_at(&formulated.equations, point)?;
    let (scales, jacobian) = (scales(formulated), numbers.block(RowBlock::Loops, ColumnBlock::Positions));
    let rows: Vec<usize> = numbers.rows().collect();
    let lengths: Vec<f64> = rows.iter().map(|&row| formulated.lowered.program.constraints[row].scale).collect();
    let scaled = |i: usize, j: usize| jacobian[(i, j)] * scales[j] / lengths[i];
    Ok((DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), scaled), rows))
}

/// How many loop equations hold at a point, and how many of them are independent.
pub(super) fn ranked(
    formulated: &Formulated,
    variation: &Variation,
    point: &OperatingPoint,
) -> Result<[usize; 2], AnalysisFailure> {
    let (rows, _) = rows(formulated, variation, point)?;
    Ok([rows.nrows(), rank(&rows)?])
}

fn rank(rows: &DMatrix<f64>) -> Result<usize, AnalysisFailure> {
    if rows.is_empty() {
        return Ok(0);
    }
    let values = svd(rows.clone(), false, false)?.singular_values;
    Ok(values.iter().filter(|value| **value > DETERMINED * values.max()).count())
}

/// True if the loop equations that hold at a point depend on each other.
pub(super) fn is_held_twice(
    formulated: &Formulated,
    variation: &Variation,
    point: &OperatingPoint,
) -> Result<bool, AnalysisFailure> {
    let [rows, rank] = ranked(formulated, variation, point)?;
    Ok(rank < rows)
}

/// Refuses a rest whose forces are not determined: more touches than is needed to hold it, or what sticks holds what does not rub.
fn check_determined(
    formulated: &Formulated,
    variation: &Variation,
    point: &OperatingPoint,
) -> Result<(), AnalysisFailure> {
    let mechanism = &*formulated.equations.system.mechanism;
    let here = statuses(formulated, point);
    let rubs = |status: &ContactStatus| matches!(status.kind, ContactKind::Friction { .. });
    let sticks = |status: &ContactStatus| {
        rubs(status) && point.value(Symbol::Discrete(mechanism.contacts[status.index].state.closed.0)) != 0.0
    };
    let stops = |status: &ContactStatus| !rubs(status) && (status.closed || status.touches());
    let all = |status: &ContactStatus| if rubs(status) { sticks(status) } else { status.closed };
    let ranked = |held: &dyn Fn(&ContactStatus) -> bool| {
        let mut point = point.clone();
        here.iter().for_each(|status| point.set_discrete(mask(mechanism, status.index, held(status))));
        ranked(formulated, variation, &point)
    };
    let always = ranked(&|_| false)?;
    for holds in [&stops as &dyn Fn(&ContactStatus) -> bool, &all] {
        let held = ranked(holds)?;
        if held[1] - always[1] == held[0] - always[0] {
            continue;
        }
        // Those without which the others hold as much.
        let mut names = Vec::new();
        for status in here.iter().filter(|here| holds(here)) {
            if ranked(&|other| holds(other) && other.index != status.index)?[1] == held[1] {
                names.push(status.name.clone());
            }
        }
        return Err(not_determined(&names));
    }
    Ok(())
}

/// What is said where several hold something twice.
pub(super) fn not_determined(names: &[String]) -> AnalysisFailure {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    AnalysisFailure::Other(format!(
        "supports {} are redundant (statically indeterminate); remove one of them, or give it a stiffness",
        names.join(", ")
    ))
}
