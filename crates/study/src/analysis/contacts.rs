//! Contacts at an operating point: open or closed, engaged or free, sticking or sliding.
//!
//! Each mode is a mechanism of its own: what is closed, caught or sticks is a loop equation, what is open or free does not count, what slides is a force against its motion.

use cotree::expr::{Order, Symbol, Values};
use cotree::formulate::Formulated;
use cotree::model::{Contact, Mechanism, Owner, Quantity, Slip, Variable};
use cotree::network::Constrained;
use cotree::report::data::shown;
use cotree_fmu::model::Model;

use super::OperatingPoint;

/// What is open by no more than this share of its scale touches, and what pulls by no more than this share of the largest force does not: an equilibrium is found to about as much.
pub(super) const TOUCHING: f64 = 1e-9;
/// The number of a feature among the discrete variables of a contact with a profile.
const FEATURE: usize = 6;

/// A contact at an operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactStatus {
    /// Such as `hinge.max`.
    pub name: String,
    /// True if it is closed, caught, or sticks.
    pub closed: bool,
    /// Its place among the mechanism's.
    pub(super) index: usize,
    pub(super) kind: ContactKind,
    /// By how much it is open, SI.
    pub gap: f64,
    /// With what it presses or drives; of what rubs its friction, on the second part along the motion; SI.
    pub force: f64,
    /// True for an angle and a torque.
    pub angular: bool,
    /// The size of its gap, SI.
    scale: f64,
    /// How fast it opens or slides, SI.
    pub rate: f64,
}

/// What kind of thing it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ContactKind {
    /// A limit, a contact, a rope.
    Stop,
    Freewheel,
    Friction {
        /// 1 or -1 while it slides that way, else 0.
        direction: f64,
        /// The force that it holds at most \[SI\].
        most: f64,
    },
    /// Dry friction of what drivers move.
    Led,
}

/// What is held on one side only, as it is at a point.
pub(super) fn statuses(formulated: &Formulated, point: &OperatingPoint) -> Vec<ContactStatus> {
    let all = formulated.equations.system.mechanism.contacts.iter().enumerate();
    all.filter_map(|(index, contact)| status(formulated, point, (index, contact))).collect()
}

fn status(
    formulated: &Formulated,
    point: &OperatingPoint,
    (index, contact): (usize, &Contact),
) -> Option<ContactStatus> {
    let equations = &formulated.equations;
    let row = equations.row_of_contact(index)?;
    if contact.state.feature.is_some_and(|held| point.value(Symbol::Discrete(held[FEATURE].0)) == 0.0) {
        return away_from_profile(formulated, point, (index, contact));
    }
    let constraint = &equations.constraints[row];
    let gap = constraint.contact()?;
    let columns = gap.jacobian.iter();
    let (rates, entries): (Vec<f64>, Vec<_>) =
        columns.map(|&(column, entry)| (point.value(Symbol::Coordinate(column, Order::Velocity)), entry)).unzip();
    let wanted = [[gap.value, gap.time_rate].as_slice(), &entries].concat();
    let values = equations.system.arena.evaluate(&wanted, point);
    let rate = values[2..].iter().zip(rates).fold(values[1], |sum, (entry, rate)| sum + entry * rate);
    let held = -point.value(Symbol::Reaction(row));
    let mut closed = point.value(Symbol::Discrete(contact.state.closed.0)) != 0.0;
    let (kind, force) = match &contact.slip {
        Some(_) if equations.is_led(index) => (ContactKind::Led, held),
        Some(slip) => {
            let direction = contact.state.direction.map_or(0.0, |way| point.value(Symbol::Discrete(way.0)));
            let level = equations.row_of_level(index).map_or(0.0, |row| point.value(Symbol::Reaction(row)));
            let most = static_ratio(formulated, point, slip) * level;
            // No sign of a zero.
            let force = held - direction * level + 0.0;
            // At rest it sticks with all that it can.
            closed |= point.rests() && direction != 0.0;
            (ContactKind::Friction { direction: if point.rests() { 0.0 } else { direction }, most }, force)
        }
        None if contact.gap.of_rate => (ContactKind::Freewheel, held),
        None => (ContactKind::Stop, held),
    };
    Some(ContactStatus {
        name: contact.name.clone(),
        closed,
        index,
        kind,
        gap: values[0],
        force,
        angular: constraint.constrained == Constrained::Angle,
        scale: constraint.scale(formulated.lowered.program.length),
        rate,
    })
}

/// A profile that is not touched where another place of it is not looked at: how far it is.
fn away_from_profile(
    formulated: &Formulated,
    point: &OperatingPoint,
    (index, contact): (usize, &Contact),
) -> Option<ContactStatus> {
    let mut equations = formulated.equations.clone();
    let mechanism = &formulated.equations.system.mechanism;
    let is_first = mechanism.gaps_of(contact.owner).next().is_some_and(|(first, _)| first == index);
    let closed = |(_, other): (usize, &Contact)| point.value(Symbol::Discrete(other.state.closed.0)) != 0.0;
    if !is_first || mechanism.gaps_of(contact.owner).any(closed) {
        return None;
    }
    let Owner::Joint(joint) = contact.owner else { return None };
    let gap = equations.variable(Variable { owner: contact.owner, quantity: Quantity::Gap });
    let gap = equations.system.arena.evaluate(&[gap], point)[0];
    Some(ContactStatus {
        name: mechanism.joints[joint.0].name.clone(),
        closed: false,
        index,
        kind: ContactKind::Stop,
        gap,
        force: 0.0,
        angular: false,
        scale: formulated.lowered.program.length,
        rate: 0.0,
    })
}

/// The ratio of the static to the kinetic friction limit at a point.
pub(super) fn static_ratio(formulated: &Formulated, point: &OperatingPoint, slip: &Slip) -> f64 {
    // A law has an expression of its own.
    let mut equations = formulated.equations.clone();
    let ratio = equations.static_ratio(slip);
    equations.system.arena.evaluate(&[ratio], point)[0]
}

/// What is held on one side only, as the motion begins with it; nothing if it does not begin.
pub fn at_start(formulated: &Formulated) -> Vec<ContactStatus> {
    if formulated.equations.system.mechanism.contacts.is_empty() {
        return Vec::new();
    }
    let start = formulated.lowered.program.experiment.start;
    let found = super::state_at(formulated, start).and_then(|state| {
        let model = Model::new(formulated.lowered.program.clone())?;
        OperatingPoint::moving(&model, &state)
    });
    found.map_or_else(|_| Vec::new(), |point| statuses(formulated, &point))
}

impl ContactStatus {
    /// What it is at the start, and what may come of it.
    pub fn told(&self, mechanism: &Mechanism) -> String {
        let ([length, force], name) = (self.units(), &self.name);
        let [gap, rate, force] = [(self.gap, length), (self.rate, self.unit_of_rate()), (self.force, force)]
            .map(|(value, si)| told(mechanism, value, si));
        match (self.kind, self.closed) {
            (ContactKind::Stop, true) => {
                format!("`{name}`: closed at the start, with a force of {force}")
            }
            (ContactKind::Stop, false) => {
                let from = if name.ends_with(".min") || name.ends_with(".max") { "the stop" } else { "contact" };
                format!("`{name}`: open at the start, {gap} from {from}")
            }
            (ContactKind::Freewheel, true) => {
                format!("`{name}`: engaged at the start, with a torque of {force}")
            }
            (ContactKind::Freewheel, false) => {
                format!("`{name}`: disengaged at the start, with a relative speed of {rate}")
            }
            (ContactKind::Friction { most, .. }, true) => {
                let most = told(mechanism, most, self.units()[1]);
                format!("`{name}`: sticks at the start, with {force} of at most {most}")
            }
            (ContactKind::Friction { direction, .. }, false) if direction != 0.0 && !self.moves(0.0) => {
                format!("`{name}`: begins to slide at the start")
            }
            (ContactKind::Friction { direction, .. }, false) if direction != 0.0 => {
                format!("`{name}`: slides at the start, at {rate}")
            }
            (ContactKind::Led, _) if !self.moves(0.0) => {
                format!("`{name}`: kept at rest by drivers at the start, so its friction force is not determined")
            }
            (ContactKind::Led, _) => format!("`{name}`: slides at the start, at {rate}, prescribed by drivers"),
            (ContactKind::Friction { .. }, false) => {
                format!(
                    "`{name}`: no friction at the start: the normal force is zero, or another constraint carries the load"
                )
            }
        }
    }

    /// What it is, in the word by which a mode is asked for.
    pub fn word(&self) -> &'static str {
        match self.kind {
            ContactKind::Friction { direction, .. } if direction > 0.0 => "slides+",
            ContactKind::Friction { direction, .. } if direction < 0.0 => "slides-",
            ContactKind::Stop | ContactKind::Freewheel | ContactKind::Friction { .. } | ContactKind::Led => {
                self.group()
            }
        }
    }

    /// What it is, as a sentence.
    pub(crate) fn sentence(&self) -> String {
        let verb = if matches!(self.group(), "sticks" | "slides") { "" } else { "is " };
        format!("{} {verb}{}", self.name, self.word())
    }

    /// What it is, in a word that is the same whichever way it slides.
    pub(crate) fn group(&self) -> &'static str {
        match (self.kind, self.closed) {
            (ContactKind::Stop, true) => "closed",
            (ContactKind::Stop, false) => "open",
            (ContactKind::Freewheel, true) => "caught",
            (ContactKind::Freewheel, false) => "free",
            (ContactKind::Friction { .. }, true) => "sticks",
            (ContactKind::Friction { direction, .. }, false) if direction != 0.0 => "slides",
            (ContactKind::Led, _) => "slides",
            (ContactKind::Friction { .. }, false) => "idle",
        }
    }

    /// If it sticks: the force that it holds at most, SI.
    pub fn most(&self) -> Option<f64> {
        match self.kind {
            ContactKind::Friction { most, .. } if self.closed => Some(most),
            ContactKind::Friction { .. } | ContactKind::Stop | ContactKind::Freewheel | ContactKind::Led => None,
        }
    }

    /// True if it sticks, and carries more than it can.
    pub(super) fn carries_too_much(&self) -> bool {
        self.most().is_some_and(|most| self.force.abs() > most)
    }

    /// 1 or -1 for what slides that way.
    pub fn direction(&self) -> Option<f64> {
        match self.kind {
            ContactKind::Friction { direction, .. } => Some(direction).filter(|direction| *direction != 0.0),
            ContactKind::Stop | ContactKind::Freewheel | ContactKind::Led => None,
        }
    }

    /// True for what holds where it was put: what sticks or is caught.
    pub(crate) fn stands(&self) -> bool {
        self.closed && self.kind != ContactKind::Stop
    }

    /// The units of its gap and of its force.
    pub fn units(&self) -> [&'static str; 2] {
        if self.angular { ["rad", "N.m"] } else { ["m", "N"] }
    }

    pub(crate) fn unit_of_rate(&self) -> &'static str {
        if self.angular { "rad/s" } else { "m/s" }
    }

    /// True for a stop that is closed, or could be where it is.
    pub(super) fn touches(&self) -> bool {
        self.kind == ContactKind::Stop && self.gap.abs() <= TOUCHING * self.scale
    }

    /// True if what is open has been passed.
    pub(super) fn is_passed(&self) -> bool {
        self.kind == ContactKind::Stop && !self.closed && self.gap < -TOUCHING * self.scale
    }

    /// True if it moves, beside the fastest of all.
    pub(super) fn moves(&self, fastest: f64) -> bool {
        self.rate.abs() > TOUCHING * fastest.max(self.scale)
    }
}

/// A value in the units of the scene.
pub(super) fn told(mechanism: &Mechanism, value: f64, si: &str) -> String {
    shown(&mechanism.units, si).show(value).to_string()
}
