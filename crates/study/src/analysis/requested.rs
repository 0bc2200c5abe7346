//! The requested modes, and the modes at a point of a motion.

use cotree::diagnostic::suggest;
use cotree::equations::Pressing;
use cotree::expr::Expr;
use cotree::formulate::Formulated;
use cotree::model::{Contact, Mechanism};
use cotree_fmu::integrator::accelerations::Accelerations;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::{Model, State};
use thiserror::Error;

use super::contacts::{ContactKind, ContactStatus, statuses, told};
use super::supports::is_held_twice;
use super::variation::Variation;
use super::{AnalysisFailure, OperatingPoint};

/// Why a part cannot be asked to be something.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct ModeError(pub String);

/// Why a part cannot be at a point of a motion what it is asked to be.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
struct Unfit(String);

/// Signs of what presses are tried: of no more than this.
const MOST_SIGNS: usize = 12;
/// A sum has its sign within this share of the largest.
const SIGNED: f64 = 1e-9;

/// What a part is to be where something rests or is linearised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WantedMode {
    /// Closed, caught, or sticking.
    Holds,
    /// Open or free.
    LetsGo,
    /// Sliding: 1 or -1 for the way, or none for that in which it slides.
    Slides(Option<f64>),
    /// Something else holds what it could.
    Idle,
}

/// A part that is to be something: its place among the mechanism's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RequestedMode {
    pub index: usize,
    pub wanted: WantedMode,
}

/// How a part is held: 1 or -1 if it slides that way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct HeldMode {
    closed: bool,
    direction: f64,
}

const IDLE: HeldMode = HeldMode { closed: false, direction: 0.0 };
const STICKS: HeldMode = HeldMode { closed: true, direction: 0.0 };

/// What a part can be asked to be: the words, and what they mean.
fn words(contact: &Contact) -> &'static [(&'static str, WantedMode)] {
    match (&contact.slip, contact.gap.of_rate) {
        (Some(_), _) => &[
            ("sticks", WantedMode::Holds),
            ("slides", WantedMode::Slides(None)),
            ("slides+", WantedMode::Slides(Some(1.0))),
            ("slides-", WantedMode::Slides(Some(-1.0))),
            ("idle", WantedMode::Idle),
        ],
        (None, true) => &[("caught", WantedMode::Holds), ("free", WantedMode::LetsGo)],
        (None, false) => &[("closed", WantedMode::Holds), ("open", WantedMode::LetsGo)],
    }
}

/// The parts that are named, with what they are to be: where a word fits one thing of a joint only, the joint may be named itself.
///
/// # Errors
/// There is no such part, or it cannot be that.
pub(super) fn requested(mechanism: &Mechanism, modes: &[(String, String)]) -> Result<Vec<RequestedMode>, ModeError> {
    modes.iter().map(|(name, word)| find(mechanism, name, word)).collect()
}

fn find(mechanism: &Mechanism, name: &str, word: &str) -> Result<RequestedMode, ModeError> {
    let all = &mechanism.contacts;
    let is_named =
        |contact: &Contact| contact.name == name || contact.name.rsplit_once('.').is_some_and(|(part, _)| part == name);
    let named: Vec<usize> = (0..all.len()).filter(|&index| is_named(&all[index])).collect();
    let known = || suggest::known(name, all.iter().map(|candidate| candidate.name.as_str()));
    let engages = mechanism.parts().any(|part| part.name == name && mechanism.engaging(part.owner).is_some());
    if named.is_empty() && engages {
        return Err(ModeError(format!(
            "`{name}` is engaged and released by events only; choose a time at which it is `{word}`"
        )));
    }
    if named.is_empty() {
        return Err(ModeError(format!(
            "no unilateral constraint or dry friction has the name `{name}`; {known}",
            known = known()
        )));
    }
    let meant =
        |index: &usize| words(&all[*index]).iter().find(|(mode_word, _)| *mode_word == word).map(|(_, wanted)| *wanted);
    let fitting: Vec<(usize, WantedMode)> =
        named.iter().filter_map(|index| meant(index).map(|wanted| (*index, wanted))).collect();
    let exact = fitting.iter().find(|(index, _)| all[*index].name == name);
    match (exact, &fitting[..]) {
        (Some(&(index, wanted)), _) | (None, &[(index, wanted)]) => Ok(RequestedMode { index, wanted }),
        (None, []) => {
            let words: Vec<String> = named
                .iter()
                .flat_map(|&index| words(&all[index]))
                .map(|(mode_word, _)| format!("{name}={mode_word}"))
                .collect();
            Err(ModeError(format!("`{name}` cannot be `{word}`; write {permitted}", permitted = words.join(" or "))))
        }
        (None, _) => Err(ModeError(format!("`{name}` is ambiguous; {known}", known = known()))),
    }
}

/// A point of a motion, with parts as they are asked to be.
///
/// # Errors
/// What is to be closed does not touch there, or moves away or in; what is to stick slides, or the other way; nothing presses; friction would lock.
pub(super) fn put(
    (formulated, variation): (&Formulated, &Variation),
    model: &Model,
    state: &mut State,
    requested: &[RequestedMode],
) -> Result<OperatingPoint, AnalysisFailure> {
    let point = OperatingPoint::moving(model, state)?;
    let sticks = statuses(formulated, &point).iter().any(|status| status.most().is_some());
    if requested.is_empty() && sticks && is_held_twice(formulated, variation, &point)? {
        return Err(AnalysisFailure::Other(format!(
            "at t = {} s several sticking frictions are redundant (statically indeterminate); set those that carry no load by `--mode NAME=idle`",
            point.time()
        )));
    }
    if requested.is_empty() {
        return Ok(point);
    }
    let here = statuses(formulated, &point);
    let mechanism = &*formulated.equations.system.mechanism;
    let target = target(mechanism, &here, requested)
        .map_err(|why| AnalysisFailure::Other(format!("at t = {} s {why}; choose another time", point.time())))?;
    for (status, holding) in here.iter().zip(target) {
        hold(mechanism, state, status, holding);
    }
    with_signs((formulated, variation), model, state)
}

/// What everything is once some of it is what is asked for, or why it cannot be.
fn target(mechanism: &Mechanism, here: &[ContactStatus], requested: &[RequestedMode]) -> Result<Vec<HeldMode>, Unfit> {
    let fastest = here.iter().fold(0.0, |most: f64, status| most.max(status.rate.abs()));
    let wanted =
        |status: &ContactStatus| requested.iter().rev().find(|part| part.index == status.index).map(|part| part.wanted);
    let mut target: Vec<HeldMode> = here
        .iter()
        .map(|here| HeldMode { closed: here.closed, direction: here.direction().unwrap_or_default() })
        .collect();
    let is_friction = |status: &ContactStatus| matches!(status.kind, ContactKind::Friction { .. });
    for (place, status) in here.iter().enumerate().filter(|(_, status)| !is_friction(status)) {
        let Some(wanted) = wanted(status) else { continue };
        let holds = wanted == WantedMode::Holds;
        target[place].closed = holds;
        if let Some(why) = why_open(mechanism, status, fastest).filter(|_| holds) {
            let word = if status.kind == ContactKind::Freewheel { "caught" } else { "closed" };
            return Err(Unfit(format!("`{name}` cannot be {word}: it {why}", name = status.name)));
        }
    }
    for (place, status) in here.iter().enumerate().filter(|(_, status)| is_friction(status)) {
        let on = mechanism.contacts[status.index].slip.as_ref().and_then(|slip| slip.on);
        let on = on.and_then(|on| here.iter().position(|status| status.index == on));
        if let Some(on) = on.filter(|&on| !target[on].closed) {
            if wanted(status).is_some_and(|wanted| wanted != WantedMode::Idle) {
                return Err(Unfit(format!(
                    "`{}` has no friction force: its contact `{}` is open",
                    status.name, here[on].name
                )));
            }
            target[place] = IDLE;
            continue;
        }
        let begins = on.is_some_and(|on| !here[on].closed);
        target[place] = rubs(mechanism, (status, target[place]), (wanted(status), begins), fastest)?;
    }
    Ok(target)
}

/// Why a stop or a freewheel cannot be closed.
fn why_open(mechanism: &Mechanism, status: &ContactStatus, fastest: f64) -> Option<String> {
    let rate = || told(mechanism, status.rate, status.unit_of_rate());
    if status.kind == ContactKind::Freewheel {
        return (!status.closed && status.moves(fastest)).then(|| format!("turns by {}", rate()));
    }
    if !status.touches() {
        return Some(format!("is open by {}", told(mechanism, status.gap, status.units()[0])));
    }
    status.moves(fastest).then(|| format!("touches, but its gap changes by {}", rate()))
}

/// How something rubs that can: as asked, or as it does; what `begins` to be pressed sticks if it stands.
fn rubs(
    mechanism: &Mechanism,
    (status, natural): (&ContactStatus, HeldMode),
    (wanted, begins): (Option<WantedMode>, bool),
    fastest: f64,
) -> Result<HeldMode, Unfit> {
    let (name, moves) = (status.name.clone(), status.moves(fastest));
    let rate = || told(mechanism, status.rate, status.unit_of_rate());
    let slides = |direction: f64| HeldMode { closed: false, direction };
    match wanted {
        None if begins => Ok(if moves { slides(status.rate.signum()) } else { STICKS }),
        None => Ok(natural),
        Some(WantedMode::Holds | WantedMode::LetsGo) if moves => {
            Err(Unfit(format!("`{name}` cannot stick: it slides at {rate}", rate = rate())))
        }
        Some(WantedMode::Holds | WantedMode::LetsGo) => Ok(STICKS),
        Some(WantedMode::Idle) if moves => {
            Err(Unfit(format!("`{name}` slides at {rate}, so its friction cannot be idle", rate = rate())))
        }
        Some(WantedMode::Idle) => Ok(IDLE),
        Some(WantedMode::Slides(None)) if moves => Ok(slides(status.rate.signum())),
        Some(WantedMode::Slides(None)) => Err(Unfit(format!(
            "`{name}` is at rest: write slides+ or slides- for the direction in which it starts to slide"
        ))),
        Some(WantedMode::Slides(Some(direction))) if moves && status.rate * direction < 0.0 => {
            Err(Unfit(format!("`{name}` slides in the other direction, at {rate}", rate = rate())))
        }
        Some(WantedMode::Slides(Some(direction))) => Ok(slides(direction)),
    }
}

/// Holds one part so in a state: what begins to be held is held where it stands.
fn hold(mechanism: &Mechanism, state: &mut State, status: &ContactStatus, holding: HeldMode) {
    let contact = &mechanism.contacts[status.index];
    let discrete = state.discrete_mut();
    discrete[contact.state.closed.0] = f64::from(u8::from(holding.closed));
    if let Some(direction) = contact.state.direction {
        discrete[direction.0] = holding.direction;
    }
    if let Some(place) = contact.state.place.filter(|_| !status.closed) {
        discrete[place.0] += status.gap;
    }
}

/// The point at a state, with the signs that what presses has in its mode.
fn with_signs(
    (formulated, variation): (&Formulated, &Variation),
    model: &Model,
    state: &mut State,
) -> Result<OperatingPoint, AnalysisFailure> {
    let refused = |time: f64, why: &str| AnalysisFailure::Other(format!("at t = {time} s the requested mode {why}"));
    if is_held_twice(formulated, variation, &OperatingPoint::resting(model, state))? {
        return Err(refused(state.time(), "is overconstrained; set one of its constraints to open, free or idle"));
    }
    let contacts = &formulated.equations.system.mechanism.contacts;
    let rubbing = variation.rubbing().iter().map(|rubbing| &contacts[rubbing.place]);
    let signs: Vec<usize> = rubbing.flat_map(|friction| friction.state.signs.iter().map(|sign| sign.0)).collect();
    if signs.len() > MOST_SIGNS {
        return Err(refused(state.time(), "has too many combinations of signs of normal forces to be tried"));
    }
    let natural: Vec<f64> = signs.iter().map(|&sign| state.discrete()[sign]).collect();
    let (mut first, mut locks) = (None, false);
    for trial in 0..1_usize << signs.len() {
        for (place, (&sign, natural)) in signs.iter().zip(&natural).enumerate() {
            state.discrete_mut()[sign] = if trial >> place & 1 == 1 { -natural } else { *natural };
        }
        let point = match OperatingPoint::moving(model, state) {
            Ok(point) => point,
            Err(failure) => {
                first = first.or(Some(failure));
                continue;
            }
        };
        if have_signs(formulated, variation, &point) {
            if !is_locked(model, state)? {
                return Ok(point);
            }
            locks = true;
        }
    }
    let why = if locks {
        "has no motion: friction locks the mechanism (self-locking)"
    } else {
        "has no motion: no normal forces are consistent with their friction"
    };
    Err(first.unwrap_or_else(|| refused(state.time(), why)))
}

/// True if what presses has the signs that its levels assume.
fn have_signs(formulated: &Formulated, variation: &Variation, point: &OperatingPoint) -> bool {
    let signed: Vec<Expr> = (variation.rubbing().iter())
        .flat_map(|friction| match &friction.level.pressing {
            Pressing::Sum(signed) => signed.iter().flat_map(|&(sign, sum)| [sign, sum]).collect(),
            Pressing::Sizes(_) => Vec::new(),
        })
        .collect();
    let values = formulated.equations.system.arena.evaluate(&signed, point);
    let largest = values.chunks(2).fold(0.0, |most: f64, pair| most.max(pair[1].abs()));
    values.chunks(2).all(|value| value[0] * value[1] >= -SIGNED * largest)
}

/// True where friction permits no accelerations that follow from it steadily.
fn is_locked(model: &Model, state: &State) -> Result<bool, AnalysisFailure> {
    let Some(contacts) = &model.program().instants.contacts else { return Ok(false) };
    let mut machine = Machine::new(model);
    machine.load(model, state);
    Accelerations::new(model).evaluate(model, &mut machine)?;
    let mut locks = vec![0.0; contacts.locks.results.len()];
    machine.evaluate(&contacts.locks, &mut locks);
    // What is not a number is not positive.
    Ok(!locks.iter().all(|&lock| lock > 0.0))
}
