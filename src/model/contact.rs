//! Contacts: unilateral constraints, whose gap is never negative and whose reaction acts in one direction (Pfeiffer and Glocker 1996, section 5.1), and friction that sticks.
//!
//! Each is a relation between across variables, a chord in every tree. Closed or sticking, it is a loop equation; open, its reaction is zero. Which of the two it is, is a discrete variable:
//! events alone change it.

use super::{
    BodyId, Discrete, DiscreteId, DiscreteKind, Formula, Initial, KeyValue, Mechanism, Owner, ParameterId, Part,
    Pressed, Quantity, Slip, Unit,
};
use crate::diagnostic::Span;
use crate::model::measure::{ANGLE, ANGULAR_IMPULSE, IMPULSE, LENGTH, NUMBER, Wanted};

/// The discrete variables of a feature of a profile, as the program has them, and what they are without one.
const FEATURE: [(&str, f64, Wanted); 7] = [
    ("normal_x", 0.0, NUMBER),
    ("normal_y", 0.0, NUMBER),
    ("at_x", 0.0, LENGTH),
    ("at_y", 0.0, LENGTH),
    ("curvature", 0.0, NUMBER),
    ("away", 1.0, LENGTH),
    ("feature", 0.0, NUMBER),
];

/// The limits of what a joint leaves free, or of what its relation may be off by; at least one is there.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// The least and the largest value.
    pub ends: [Option<Formula>; 2],
    /// Share of the speed with which it rebounds, from 0 to 1.
    pub restitution: Formula,
}

/// The gap of a contact, as its component gives it: sign x (what its relation is off by - bound) is never negative.
#[derive(Clone, Debug, PartialEq)]
pub struct GapLaw {
    /// What distinguishes it from others of its part; may be empty.
    pub word: &'static str,
    /// 1 or -1
    pub sign: f64,
    pub bound: Formula,
    /// Share of the speed with which it rebounds, from 0 to 1.
    pub restitution: Formula,
    /// True for a freewheel: its rate is what is never negative, and the bound is where it was caught.
    pub of_rate: bool,
}

/// A contact of a part: a unilateral constraint, or dry friction.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    pub owner: Owner,
    /// Such as `hinge.max`, or the name of its part.
    pub name: String,
    pub gap: GapLaw,
    pub state: ContactVariables,
    /// How it slides, if it is friction. While it sticks, its relation holds on both sides, at `gap.bound`.
    pub slip: Option<Slip>,
    /// Where its part stands in the file.
    pub span: Span,
}

/// The discrete variables of a contact.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ContactVariables {
    /// 1 while it is closed, or sticks; else 0.
    pub closed: DiscreteId,
    /// The impulse of the last impact.
    pub impulse: DiscreteId,
    /// From where its gap counts: of friction and freewheels, which stick or engage wherever they are.
    pub place: Option<DiscreteId>,
    /// 1 or -1 while it slides that way, else 0: of friction.
    pub direction: Option<DiscreteId>,
    /// The signs of what presses on a guide.
    pub signs: Vec<DiscreteId>,
    /// The line or arc of a profile: its normal, a point of it, its curvature, 1 while there is none, and its number from 1 on.
    pub feature: Option<[DiscreteId; 7]>,
}

impl Limits {
    /// The limits as relations on one side.
    pub fn gaps(&self) -> Vec<GapLaw> {
        let ends = self.ends.iter().zip([("min", 1.0), ("max", -1.0)]);
        let of = |(end, (word, sign)): (&Option<Formula>, _)| {
            let (bound, restitution) = (end.clone()?, self.restitution.clone());
            Some(GapLaw { word, sign, bound, restitution, of_rate: false })
        };
        ends.filter_map(of).collect()
    }

    /// Every formula in it.
    pub fn formulas(&self) -> impl Iterator<Item = &Formula> {
        self.ends.iter().flatten().chain([&self.restitution])
    }

    pub fn formulas_mut(&mut self) -> impl Iterator<Item = &mut Formula> {
        self.ends.iter_mut().flatten().chain([&mut self.restitution])
    }
}

impl Contact {
    /// What its modes are called: that in which nothing holds it first, or that in which it sticks.
    pub fn modes(&self) -> Vec<&'static str> {
        match &self.slip {
            Some(Slip { on: Some(_), .. }) => vec!["sticks", "slides", "slides back", "apart"],
            Some(_) => vec!["sticks", "slides", "slides back"],
            None if self.gap.of_rate => vec!["free", "caught"],
            None => vec!["open", "closed"],
        }
    }

    /// Calls `visit` with every parameter in its bound, its restitution and its law of friction.
    pub fn visit_parameters(&self, visit: &mut dyn FnMut(ParameterId)) {
        let law = self.slip.iter().flat_map(|slip| slip.law.formulas());
        [&self.gap.bound, &self.gap.restitution]
            .into_iter()
            .chain(law)
            .for_each(|formula| formula.visit_parameters(visit));
    }
}

impl Mechanism {
    /// Adds the contacts of all parts, with the discrete variables of each.
    pub(crate) fn add_contacts(&mut self) {
        let mut all = Vec::new();
        for part in self.parts() {
            for gap in (part.component().gaps)(part, self) {
                let name = if gap.word.is_empty() { part.name.clone() } else { format!("{}.{}", part.name, gap.word) };
                let is_angular = part.component().variables.contains(&Quantity::AngularImpulse);
                let measure = if is_angular { ANGULAR_IMPULSE } else { IMPULSE };
                let begins = f64::from(u8::from(self.begins_on_its_cam(part)));
                let touches = part.contour().is_some();
                all.push((part.owner, name, (gap, begins, touches), Unit::of(&measure, None), part.span));
            }
        }
        for (owner, name, (mut gap, begins, touches), unit, span) in all {
            let mut hold = |word: &str, value: f64, unit: Unit| self.hold(format!("{name}.{word}"), value, unit, span);
            let (closed, impulse) = (hold("closed", begins, Unit::default()), hold("impulse", 0.0, unit));
            // Sign x the value at which it was caught.
            let place = gap.of_rate.then(|| hold("caught", 0.0, Unit::of(&ANGLE, None)));
            if let Some(caught) = place {
                gap.bound = Formula::Number(gap.sign) * Formula::Discrete(caught);
            }
            let feature =
                touches.then(|| FEATURE.map(|(word, value, measure)| hold(word, value, Unit::of(&measure, None))));
            let state = ContactVariables { closed, impulse, place, direction: None, signs: Vec::new(), feature };
            self.contacts.push(Contact { owner, name, gap, state, slip: None, span });
        }
        self.add_slips();
    }

    /// True for a cam whose follower starts where the cam has it: `[initial]` mentions neither the follower nor what joints connect it to without the ground and the cam.
    fn begins_on_its_cam(&self, part: &Part) -> bool {
        if part.component().name != "cam" {
            return false;
        }
        let [cam, follower] = part.bodies();
        let mut reached: Vec<BodyId> = follower.into_iter().collect();
        let mut next = 0;
        while let Some(&body) = reached.get(next) {
            next += 1;
            let joints = self.joints.iter().filter(|joint| joint.owner != part.owner);
            let neighbours = joints.filter(|joint| joint.bodies().contains(&Some(body))).flat_map(Part::bodies);
            for other in neighbours.flatten().filter(|other| Some(*other) != cam) {
                if !reached.contains(&other) {
                    reached.push(other);
                }
            }
        }
        let is_reached = |body: Option<BodyId>| body.is_some_and(|body| reached.contains(&body));
        let is_given = |initial: &Initial| match initial.variable.owner {
            Owner::Place(place) => is_reached(place.body()),
            Owner::Joint(joint) => self.joints[joint.0].bodies().into_iter().any(is_reached),
            Owner::Driver(_) | Owner::Load(_) | Owner::System => true,
        };
        !self.initial.iter().any(is_given)
    }

    /// Adds what sticks and slips, with the discrete variables of each: whether it sticks, the impulse of the last impact, where it sticks, in which direction it slips, and the signs of what presses.
    fn add_slips(&mut self) {
        let rubbing = self.parts().filter_map(|part| {
            let rubs = part.component().rubs?;
            let law = (rubs.law)(part)?;
            let on = self
                .contacts
                .iter()
                .position(|contact| rubs.pressed == Pressed::Contact && contact.owner == part.owner);
            let measures = if part.is_angular() { [ANGLE, ANGULAR_IMPULSE] } else { [LENGTH, IMPULSE] };
            Some((part.owner, part.name.clone(), (law, rubs.pressed, on), measures, part.span))
        });
        for (owner, part, (law, pressed, on), [along, impulse], span) in rubbing.collect::<Vec<_>>() {
            let name = format!("{part}.friction");
            let mut hold = |word: &str, value: f64, unit: Unit| self.hold(format!("{name}.{word}"), value, unit, span);
            let [along, impulse] = [along, impulse].map(|measure| Unit::of(&measure, None));
            let (closed, impulse) = (hold("sticks", 0.0, Unit::default()), hold("impulse", 0.0, impulse));
            let (place, direction) = (hold("place", 0.0, along), hold("direction", 0.0, Unit::default()));
            let signs = match (pressed, &law.length) {
                (Pressed::Guide { .. }, Some(_)) => 2,
                (Pressed::Guide { .. } | Pressed::Reaction(_), _) if law.mu != Formula::Number(0.0) => 1,
                (
                    Pressed::Guide { .. }
                    | Pressed::Reaction(_)
                    | Pressed::Nothing
                    | Pressed::Belt
                    | Pressed::Pin
                    | Pressed::Contact,
                    _,
                ) => 0,
            };
            let signs = (0..signs).map(|side| hold(&format!("sign_{side}"), 1.0, Unit::default())).collect();
            let (bound, restitution) = (Formula::Discrete(place), Formula::Number(0.0));
            let gap = GapLaw { word: "", sign: 1.0, bound, restitution, of_rate: false };
            let slip = Some(Slip { law, pressed, on });
            let (place, direction) = (Some(place), Some(direction));
            let state = ContactVariables { closed, impulse, place, direction, signs, feature: None };
            self.contacts.push(Contact { owner, name, gap, state, slip, span });
        }
    }

    /// Gives contacts the formulas of parts in which numbers have got names.
    pub(crate) fn rename_contacts(&mut self) {
        let mut all = std::mem::take(&mut self.contacts);
        for part in self.parts() {
            let contacts = all.iter_mut().filter(|contact| contact.owner == part.owner && contact.slip.is_none());
            for (contact, gap) in contacts.zip((part.component().gaps)(part, self)) {
                contact.gap.restitution = gap.restitution;
                if !gap.of_rate {
                    contact.gap.bound = gap.bound;
                }
            }
            let law = part.component().rubs.and_then(|rubs| (rubs.law)(part));
            let slip =
                all.iter_mut().filter(|contact| contact.owner == part.owner).find_map(|contact| contact.slip.as_mut());
            if let Some((slip, law)) = slip.zip(law) {
                slip.law = law;
            }
        }
        self.contacts = all;
    }

    /// What is 0 once a part has been removed: whether it is there, and the states of its contacts.
    pub(crate) fn values_of_presence(&self, owner: Owner) -> Vec<DiscreteId> {
        let contacts = self.contacts.iter().filter(|contact| contact.owner == owner);
        let of = |contact: &Contact| [Some(contact.state.closed), contact.state.direction];
        self.there(owner).into_iter().chain(contacts.flat_map(of).flatten()).collect()
    }

    /// Adds a discrete variable of a contact.
    fn hold(&mut self, name: String, value: f64, unit: Unit, span: Span) -> DiscreteId {
        let (begin, kind) = (Formula::Number(value), DiscreteKind::Contact);
        self.discrete.push(Discrete { name, description: String::new(), unit, kind, begin, span });
        DiscreteId(self.discrete.len() - 1)
    }

    /// The first of them that is not dry friction, as a message calls it.
    pub fn first_stop(&self) -> Option<String> {
        self.called(self.contacts.iter().find(|contact| contact.slip.is_none())?)
    }

    /// The first whose dry friction sticks, as a message calls it.
    pub fn first_slip(&self) -> Option<String> {
        self.called(self.contacts.iter().find(|contact| contact.slip.is_some())?)
    }

    /// The contact at this place, as a message calls it.
    pub fn what_holds(&self, index: usize) -> Option<String> {
        self.called(self.contacts.get(index)?)
    }

    /// The first of what is held wherever it stands, as a message calls it: friction that sticks, and freewheels.
    pub fn first_held_anywhere(&self) -> Option<String> {
        self.called(self.contacts.iter().find(|contact| contact.slip.is_some() || contact.gap.of_rate)?)
    }

    fn called(&self, contact: &Contact) -> Option<String> {
        let part = self.parts().find(|part| part.owner == contact.owner)?;
        let key = part.values.iter().find(|(_, value)| matches!(value, KeyValue::Limits(_))).map(|(key, _)| *key);
        Some(match key {
            _ if contact.slip.is_some() => {
                format!("the dry friction of {} `{}`", part.component().words(), part.name)
            }
            Some(key) => format!("the {key} of joint `{}`", part.name),
            None => format!("{} `{}`", part.component().name, part.name),
        })
    }

    /// The unilateral constraints of a part, with their places among all contacts.
    pub fn gaps_of(&self, owner: Owner) -> impl Iterator<Item = (usize, &Contact)> {
        self.contacts.iter().enumerate().filter(move |(_, contact)| contact.owner == owner && contact.slip.is_none())
    }

    /// The friction of a part, with its place among all contacts.
    pub fn slip_of(&self, owner: Owner) -> Option<(usize, &Contact, &Slip)> {
        let mut all = self.contacts.iter().enumerate();
        all.find_map(|(index, contact)| {
            Some((index, contact, contact.slip.as_ref().filter(|_| contact.owner == owner)?))
        })
    }
}
