//! What is held on one side only, where something rests or is linearised: open or closed.
//!
//! Each mode is a mechanism of its own: what is closed is a loop equation, what is open does not count. A rest is one where what is open does not go in, and what is closed presses.

use cotree::diagnostic::suggest;
use cotree::expr::{Order, Symbol, Values};
use cotree::formulate::Formulated;
use cotree::model::Mechanism;
use cotree::network::Held;
use cotree::report::data::shown;
use cotree::scene::constant;
use cotree_fmu::model::Model;
use nalgebra::DMatrix;

use super::decompose::svd;
use super::search::{scales, search};
use super::variation::{Column, RowBlock, Variation};
use super::{Failure, Point};

/// All modes are tried: of more parts than these there are too many.
const MOST: usize = 8;
/// What is open by no more than this share of its scale touches, and what pulls by no more than this share of the largest force does not: an equilibrium is found to about as much.
const TOUCHING: f64 = 1e-9;
/// Rows depend on each other where a singular value is below this share of the largest.
const DETERMINED: f64 = 1e-10;

/// What one part holds on one side, at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Closure {
    /// Such as `hinge.max`.
    pub name: String,
    pub closed: bool,
    /// What kind of thing it is.
    kind: Kind,
    /// By how much it is open, SI.
    pub gap: f64,
    /// With what it presses, SI.
    pub force: f64,
    /// True for an angle and a torque.
    pub angular: bool,
    /// The size of its gap, SI.
    scale: f64,
    /// How fast it opens, SI.
    rate: f64,
}

/// What may be open or closed, hold or let go.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// A limit, a contact, a rope.
    Stop,
    Freewheel,
    /// Dry friction: 1 or -1 while it slides that way, else 0; and the force that it holds at most.
    Friction {
        direction: f64,
        level: f64,
    },
    /// Dry friction of what drivers move.
    Led,
}

/// A part that is to be open or closed: its place among the mechanism's.
pub type Asked = (usize, bool);

/// What is held on one side only, as it is at a point.
pub(super) fn closures(formulated: &Formulated, point: &Point) -> Vec<Closure> {
    let equations = &formulated.equations;
    let length = formulated.lowered.program.length;
    let mechanism = &equations.system.mechanism;
    let parameters: Vec<f64> =
        (0..mechanism.parameters.len()).map(|index| point.value(Symbol::Parameter(index))).collect();
    mechanism
        .unilaterals
        .iter()
        .enumerate()
        .filter_map(|(index, own)| {
            let row = equations.row_of_unilateral(index)?;
            let constraint = &equations.constraints[row];
            let gap = constraint.one_sided.as_ref()?;
            let columns = gap.jacobian.iter();
            let (rates, entries): (Vec<f64>, Vec<_>) = columns
                .map(|&(column, entry)| (point.value(Symbol::Coordinate(column, Order::Velocity)), entry))
                .unzip();
            let wanted = [[gap.value, gap.time_rate].as_slice(), &entries].concat();
            let values = equations.system.arena.evaluate(&wanted, point);
            let rate = values[2..].iter().zip(rates).fold(values[1], |sum, (entry, rate)| sum + entry * rate);
            let kind = match &own.slip {
                Some(_) if equations.is_driven() => Kind::Led,
                Some(slip) => {
                    let ratio = constant::evaluate(&slip.law.ratio, &parameters);
                    let direction = point.value(Symbol::Parameter(slip.direction.0));
                    Kind::Friction { direction, level: ratio * point.value(Symbol::Reaction(row + 1)) }
                }
                None if own.held.of_rate => Kind::Freewheel,
                None => Kind::Stop,
            };
            Some(Closure {
                name: own.name.clone(),
                kind,
                closed: point.value(Symbol::Parameter(own.closed.0)) != 0.0,
                gap: values[0],
                force: -point.value(Symbol::Reaction(row)),
                angular: constraint.held == Held::Angle,
                scale: constraint.scale(length),
                rate,
            })
        })
        .collect()
}

/// What is held on one side only, as the motion begins with it; nothing if it does not begin.
pub fn at_start(formulated: &Formulated) -> Vec<Closure> {
    if formulated.equations.system.mechanism.unilaterals.is_empty() {
        return Vec::new();
    }
    let start = formulated.lowered.program.experiment.start;
    let found = super::state_at(formulated, start).and_then(|state| {
        let model = Model::new(formulated.lowered.program.clone())?;
        Point::moving(&model, &state)
    });
    found.map_or_else(|_| Vec::new(), |point| closures(formulated, &point))
}

impl Closure {
    /// What it is at the start, and what may come of it.
    pub fn told(&self, mechanism: &Mechanism) -> String {
        let ([length, force], name) = (self.units(), &self.name);
        let speed = if self.angular { "rad/s" } else { "m/s" };
        let [gap, rate, force] =
            [(self.gap, length), (self.rate, speed), (self.force, force)].map(|(value, si)| told(mechanism, value, si));
        match (self.kind, self.closed) {
            (Kind::Stop, true) => {
                format!("`{name}` is closed at the start and presses with {force}: it opens where that falls to zero")
            }
            (Kind::Stop, false) => {
                format!("`{name}` is open by {gap} at the start: it strikes where that falls to zero")
            }
            (Kind::Freewheel, true) => {
                format!("`{name}` is caught at the start and drives with {force}: it lets go where that falls to zero")
            }
            (Kind::Freewheel, false) => {
                format!("`{name}` turns freely at the start, by {rate}: it is caught where that falls to zero")
            }
            (Kind::Friction { level, .. }, true) => {
                let level = told(mechanism, level, self.units()[1]);
                format!("`{name}` sticks at the start and holds with {force}: it slides where that exceeds {level}")
            }
            (Kind::Friction { direction, .. }, false) if direction != 0.0 && self.is_still() => {
                format!("`{name}` begins to slide at the start")
            }
            (Kind::Friction { direction, .. }, false) if direction != 0.0 => {
                format!("`{name}` slides at the start, by {rate}: it may stick where that falls to zero")
            }
            (Kind::Led, _) if self.is_still() => {
                format!("`{name}` is at rest at the start: where drivers keep it still, its force is not determined")
            }
            (Kind::Led, _) => format!("`{name}` slides at the start, by {rate}, as drivers say"),
            (Kind::Friction { .. }, false) => format!("`{name}` does not rub at the start: nothing presses there"),
        }
    }

    pub fn word(&self) -> &'static str {
        if self.closed { "closed" } else { "open" }
    }

    /// The units of its gap and of its force.
    pub fn units(&self) -> [&'static str; 2] {
        if self.angular { ["rad", "N m"] } else { ["m", "N"] }
    }

    fn is_still(&self) -> bool {
        self.rate.abs() <= TOUCHING * self.scale
    }

    fn touches(&self) -> bool {
        self.gap.abs() <= TOUCHING * self.scale
    }
}

/// The parts that are named, with what they are to be: a joint that has but one limit may be named itself.
///
/// # Errors
/// There is no such part.
pub(super) fn asked(mechanism: &Mechanism, modes: &[(String, bool)]) -> Result<Vec<Asked>, String> {
    let names = || mechanism.unilaterals.iter().map(|own| own.name.as_str());
    let find = |(name, closed): &(String, bool)| {
        let of_part = |own: &str| own.rsplit_once('.').is_some_and(|(part, _)| part == name);
        let exact = names().position(|own| own == name);
        let alone = || (names().filter(|own| of_part(own)).count() == 1).then(|| names().position(of_part)).flatten();
        let found = exact.or_else(alone).map(|index| (index, *closed));
        found.ok_or_else(|| {
            let known = suggest::known(name, names());
            format!("nothing of the name `{name}` is held on one side only; {known}")
        })
    };
    modes.iter().map(find).collect()
}

/// Opens and closes at a point of a motion what is asked for.
///
/// # Errors
/// What is to be closed does not touch there, or moves away or in.
pub(super) fn put(formulated: &Formulated, point: &Point, asked: &[Asked]) -> Result<Vec<(usize, f64)>, Failure> {
    let here = closures(formulated, point);
    let fastest = here.iter().fold(0.0, |most: f64, own| most.max(own.rate.abs()));
    let mechanism = &formulated.equations.system.mechanism;
    for &(index, closed) in asked {
        let name = &mechanism.unilaterals[index].name;
        let Some(own) = here.iter().find(|own| closed && own.name == *name) else { continue };
        let why = if !own.touches() {
            format!("is open by {}", told(mechanism, own.gap, own.units()[0]))
        } else if own.rate.abs() > TOUCHING * fastest.max(own.scale) {
            let unit = if own.angular { "rad/s" } else { "m/s" };
            format!("touches, but its gap changes by {}", told(mechanism, own.rate, unit))
        } else {
            continue;
        };
        let what = format!("at t = {} s `{name}` cannot be closed: it {why}; choose another time", point.time());
        return Err(Failure::Instants(what));
    }
    Ok(asked.iter().map(|&(index, closed)| mask(mechanism, index, closed)).collect())
}

/// The parameter by which a part is open or closed, and its value.
fn mask(mechanism: &Mechanism, index: usize, closed: bool) -> (usize, f64) {
    (mechanism.unilaterals[index].closed.0, f64::from(u8::from(closed)))
}

/// Searches for a rest in one mode after another, from that in which everything that touches at the guess is closed to those that differ from it most. In other modes than the guess's a rest
/// that the slightest push would end (not `lasts`) counts only if there is no other.
///
/// # Errors
/// There is none in any mode, or what carries is not determined.
pub(super) fn rest(
    formulated: &Formulated,
    variation: &Variation,
    guess: &Point,
    asked: &[Asked],
    lasts: impl Fn(&Point) -> Result<bool, Failure>,
) -> Result<Point, Failure> {
    let mechanism = &formulated.equations.system.mechanism;
    if mechanism.unilaterals.is_empty() {
        return search(formulated, variation, guess.clone(), |_| None);
    }
    let modes = modes(formulated, guess, asked)?;
    let (mut first, mut unsteady) = (None, None);
    for (place, mode) in modes.iter().enumerate() {
        let mut point = guess.clone();
        mode.iter().enumerate().for_each(|(index, &closed)| point.set_parameter(mask(mechanism, index, closed)));
        let found = search(formulated, variation, point, |point| unfit(formulated, point));
        match found {
            Ok(point) => {
                check_determined(formulated, variation, &point)?;
                if place == 0 || lasts(&point)? {
                    return Ok(point);
                }
                unsteady = unsteady.or(Some(point));
            }
            Err(failure) => first = first.or(Some(failure)),
        }
    }
    if let Some(point) = unsteady {
        return Ok(point);
    }
    Err(match first {
        Some(cause) if modes.len() > 1 => Failure::NoModeRests { tried: modes.len(), cause: Box::new(cause) },
        Some(cause) => cause,
        None => Failure::Instants("no mode is asked for in which anything could rest".to_owned()),
    })
}

/// Which parts are closed, in every mode that there can be: next to that of the guess first.
fn modes(formulated: &Formulated, guess: &Point, asked: &[Asked]) -> Result<Vec<Vec<bool>>, Failure> {
    let mechanism = &formulated.equations.system.mechanism;
    let count = mechanism.unilaterals.len();
    let mut start: Vec<bool> = closures(formulated, guess).iter().map(Closure::touches).collect();
    start.resize(count, false);
    asked.iter().for_each(|&(index, closed)| start[index] = closed);
    let free: Vec<usize> = (0..count).filter(|index| asked.iter().all(|(own, _)| own != index)).collect();
    if free.len() > MOST {
        return Err(Failure::Instants(format!(
            "{} parts are held on one side only, and all their modes would be tried: of no more than {MOST} that is done; say by --mode which of them are open or closed",
            free.len()
        )));
    }
    let mut changes: Vec<usize> = (0..1 << free.len()).collect();
    changes.sort_by_key(|change| change.count_ones());
    let mode = |change: usize| {
        let mut mode = start.clone();
        free.iter().enumerate().for_each(|(place, &index)| mode[index] ^= change >> place & 1 == 1);
        mode
    };
    // A joint is not at both of its limits.
    let owner = |index: usize| mechanism.unilaterals[index].owner;
    let is_possible = |mode: &Vec<bool>| {
        (0..count).all(|one| (0..one).all(|other| !(mode[one] && mode[other] && owner(one) == owner(other))))
    };
    Ok(changes.into_iter().map(mode).filter(is_possible).collect())
}

/// What is wrong with a pose in which the loads balance.
fn unfit(formulated: &Formulated, point: &Point) -> Option<String> {
    let mechanism = &formulated.equations.system.mechanism;
    let here = closures(formulated, point);
    let reactions = (0..formulated.equations.constraints.len()).map(|row| point.value(Symbol::Reaction(row)).abs());
    let largest = reactions.fold(0.0, f64::max);
    here.iter().find_map(|own| {
        let [length, force] = own.units();
        if own.closed && own.force < -TOUCHING * largest {
            Some(format!("`{}` would pull with {}", own.name, told(mechanism, -own.force, force)))
        } else if !own.closed && own.gap < -TOUCHING * own.scale {
            Some(format!("`{}` is passed by {}", own.name, told(mechanism, -own.gap, length)))
        } else {
            None
        }
    })
}

/// A value in the units of the scene.
fn told(mechanism: &Mechanism, value: f64, si: &str) -> String {
    shown(&mechanism.units, si).show(value).to_string()
}

/// Refuses a rest whose forces are not determined: more touches than is needed to hold it.
fn check_determined(formulated: &Formulated, variation: &Variation, point: &Point) -> Result<(), Failure> {
    let mechanism = &formulated.equations.system.mechanism;
    let here = closures(formulated, point);
    let rank = |closed: &dyn Fn(&Closure) -> bool| -> Result<[usize; 2], Failure> {
        let mut point = point.clone();
        for (index, own) in mechanism.unilaterals.iter().enumerate() {
            let closes = here.iter().any(|held| held.name == own.name && closed(held));
            point.set_parameter(mask(mechanism, index, closes));
        }
        let numbers = variation.motion_at(&formulated.equations, &point)?;
        let (scales, rows) = (scales(formulated), numbers.block(RowBlock::Loops, Column::Positions));
        let lengths: Vec<f64> = numbers.rows().map(|row| formulated.lowered.program.constraints[row].scale).collect();
        let rows = DMatrix::from_fn(rows.nrows(), rows.ncols(), |i, j| rows[(i, j)] * scales[j] / lengths[i]);
        if rows.is_empty() {
            return Ok([0, 0]);
        }
        let values = svd(rows.clone(), false, false)?.singular_values;
        Ok([rows.nrows(), values.iter().filter(|value| **value > DETERMINED * values.max()).count()])
    };
    let [always, all] = [rank(&|_| false)?, rank(&|own| own.closed || own.touches())?];
    if all[1] - always[1] == all[0] - always[0] {
        return Ok(());
    }
    let names: Vec<String> =
        here.iter().filter(|own| own.closed || own.touches()).map(|own| format!("`{}`", own.name)).collect();
    Err(Failure::Instants(format!(
        "it rests on {}, which together hold something twice: what each of them carries is not determined; leave one out, or let one give by a spring",
        names.join(", ")
    )))
}
