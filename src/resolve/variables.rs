//! The naming table of variables.

use std::collections::HashMap;

use super::Resolver;
use super::names::Named;
use crate::component::body::{POINT_VARIABLES as POINT, VARIABLES as BODY};
use crate::component::{ENERGIES, RESIDUALS, Section};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::model::{Aspect, ContactQuantity, JointId, Owner, Place, Quantity, Variable};
use crate::scene::document::Content;
use crate::scene::key::Form;
use crate::scene::model::Scene;
use crate::scene::part::Part;
use crate::scene::record::Record;

fn of_part(part: &Part, section: Section) -> Option<(String, Vec<Quantity>)> {
    let component = part.component(section)?;
    // Limits that are not there are never reached.
    let limits = component.keys.iter().find(|key| key.form.is_one_sided());
    // A key that is misspelt may be meant for them: that fault is enough.
    let is_known = |key: &Text| key.text == "type" || component.keys.iter().any(|known| known.name == key.text);
    let is_understood = match &part.node.kind {
        Content::Table(entries) => entries.iter().all(|(key, _)| is_known(key)),
        _ => true,
    };
    let is_free = is_understood && limits.is_some_and(|key| part.get(key.name).is_none());
    let sticks = component.keys.iter().find(|key| matches!(key.form, Form::Record(Record::Friction(..))));
    let sticks = sticks.and_then(|key| part.get(key.name)).is_some_and(|node| match &node.kind {
        Content::Table(entries) => entries.iter().all(|(key, _)| key.text != "velocity"),
        _ => false,
    });
    let rubs_on_pulley = match part.get("over").map(|node| &node.kind) {
        Some(Content::Array(items)) => items.iter().any(|item| match &item.kind {
            Content::Table(entries) => entries.iter().any(|(key, _)| key.text == "mu"),
            _ => false,
        }),
        _ => false,
    };
    let sticks = sticks || rubs_on_pulley || !is_understood;
    // A brake rubs without a key for it; a rolling disc has no impacts.
    let rubs = component.keys.iter().all(|key| !matches!(key.form, Form::Record(Record::Friction(..))))
        && component.keys.iter().all(|key| !matches!(key.form, Form::Course))
        && component.rubs.is_some();
    let impulses = [Quantity::Impulse, Quantity::AngularImpulse];
    let is_one_sided =
        !is_free && (limits.is_some() || component.variables.iter().any(|variable| impulses.contains(variable)));
    // Along a profile no displacement is counted.
    let at_profile = component.keys.iter().any(|key| matches!(key.form, Form::Profile) && part.get(key.name).is_some());
    let along = [Quantity::S, Quantity::V, Quantity::A, Quantity::Ft];
    let has = |quantity: &Quantity| match quantity.aspect() {
        _ if at_profile && along.contains(quantity) => false,
        Aspect::Contact(ContactQuantity::Sliding) => sticks || rubs,
        Aspect::Contact(ContactQuantity::Mode) => sticks || rubs || is_one_sided,
        Aspect::Contact(_) => !is_free,
        _ => true,
    };
    let quantities = component.variables.iter().copied().filter(has);
    Some((component.words(), quantities.chain([Quantity::Power]).collect()))
}

impl Scene {
    /// What a part is called, and its variables; those of a joint that engages among them.
    pub(super) fn of_part(&self, part: &Part, section: Section) -> Option<(String, Vec<Quantity>)> {
        let (words, mut has) = of_part(part, section)?;
        let component = part.component(section)?;
        let joint =
            self.joints.iter().position(|joint| std::ptr::eq(joint, part)).map(|index| Owner::Joint(JointId(index)));
        if joint.is_some_and(|joint| self.engaging(joint).is_some()) {
            has.extend(
                component.engaging.iter().filter(|quantity| !has.contains(quantity)).copied().collect::<Vec<_>>(),
            );
        }
        if component.engaging.contains(&Quantity::Impulse) && component.engaging.contains(&Quantity::AngularImpulse) {
            // It holds an angle or a displacement.
            let others = match self.slides(part) {
                true => [Quantity::AngularImpulse, Quantity::Torque],
                false => [Quantity::Impulse, Quantity::Force],
            };
            has.retain(|quantity| !others.contains(quantity));
        }
        Some((words, has))
    }

    /// True if a part acts on a joint that slides.
    pub(super) fn slides(&self, part: &Part) -> bool {
        let joint = part.text("joint").and_then(|name| self.joints.iter().find(|joint| joint.name.text == name.text));
        let component = joint.and_then(|joint| joint.component(Section::Joints));
        component.is_some_and(|component| component.drivers == ["displacement"])
    }
}

/// An owner of variables, what to call it, and what it has.
pub(super) struct FoundOwner {
    owner: Owner,
    called: String,
    pub(super) has: Vec<Quantity>,
}

impl Resolver<'_> {
    /// The variable with a name such as `crank.angle` or `rod.small_end.x`; a fault with this code if there is none.
    pub(super) fn variable(&mut self, name: &Text, user: &str, code: &'static str) -> Option<Variable> {
        let (owner, last) = name.text.rsplit_once('.').unwrap_or((&name.text, ""));
        let Some(found) = self.find_owner(owner) else {
            self.unknown_owner(name, user, code);
            return None;
        };
        let one_dimensional = self.one_dimensional();
        let mut has = found.has.iter().copied().filter(|quantity| !one_dimensional || quantity.is_on_a_line());
        if let Some(quantity) = has.clone().find(|quantity| quantity.word() == last) {
            let variable = Variable { owner: found.owner, quantity };
            self.called.entry(variable).or_insert_with(|| name.text.clone());
            return Some(variable);
        }
        if self.is_reported(name, &name.text) {
            return None;
        }
        let names: Vec<&str> = has.by_ref().map(|quantity| quantity.word()).collect();
        let has = match names.is_empty() {
            true => format!("{} has no variables", found.called),
            false => format!("{} has {}", found.called, suggest::list(names.iter().copied())),
        };
        let near = meant(last, &names).or_else(|| suggest::nearest(last, names.iter().copied()));
        let bare = last.split(['[', '(', ' ', '/']).next().unwrap_or_default();
        let help = match near {
            _ if bare != last && names.contains(&bare) => format!(
                "write `{owner}.{bare}`, without a unit; choose units by `units = [\"deg\", \"mm\"]` in `[display]`, or by `--units deg,mm`"
            ),
            _ if name.text.contains('.') && self.find_owner(&name.text).is_some() => {
                format!("`{0}` is a point; write `{0}.x` or `{0}.y`", name.text)
            }
            Some(near) => format!("did you mean `{owner}.{near}`? {has}"),
            None => has,
        };
        let message = format!("{user} names a variable that does not exist: `{}`", name.text);
        self.faults.push_about(&name.text, Fault::new(code, message, name.span).label("no such variable").help(help));
        None
    }

    pub(super) fn find_owner(&self, owner: &str) -> Option<FoundOwner> {
        let place = |place, called: String, has: &[Quantity]| {
            Some(FoundOwner { owner: Owner::Place(place), called, has: has.to_vec() })
        };
        if let Some((body, point)) = owner.split_once('.') {
            return match (body, self.names.get(body)) {
                ("ground", _) => {
                    let index = *self.names.ground.get(point)?;
                    place(Place::Ground(index), format!("point `{owner}`"), POINT)
                }
                (_, Some(Named::Body(id))) => {
                    let index = *self.names.points[id.0].get(point)?;
                    place(Place::Point(id, index), format!("point `{owner}`"), POINT)
                }
                _ => None,
            };
        }
        let system = |has: &[Quantity]| {
            Some(FoundOwner { owner: Owner::System, called: format!("`{owner}`"), has: has.to_vec() })
        };
        let dimension = self.scene.dimension;
        let part = |id, part: &Part, section| {
            let (words, mut has) = self.scene.of_part(part, section)?;
            let coordinates = part.component(section)?.coordinates(dimension).iter().copied();
            coordinates.for_each(|quantity| {
                if !has.contains(&quantity) {
                    has.push(quantity)
                }
            });
            Some(FoundOwner { owner: id, called: format!("{words} `{owner}`"), has })
        };
        match owner {
            "energy" => return system(ENERGIES),
            "constraint" => return system(RESIDUALS),
            _ => {}
        }
        match self.names.get(owner)? {
            Named::Body(id) => place(Place::Centre(id), format!("body `{owner}`"), BODY),
            Named::Joint(id) => part(Owner::Joint(id), &self.scene.joints[id.0], Section::Joints),
            Named::Driver(id) => part(Owner::Driver(id), &self.scene.drivers[id.0], Section::Drivers),
            Named::Load(id) => part(Owner::Load(id), &self.scene.loads[id.0], Section::Loads),
            Named::Parameter(_) | Named::Input(_) | Named::State(_) | Named::Sampled(_) | Named::Signal(_) => None,
        }
    }

    fn unknown_owner(&mut self, name: &Text, user: &str, code: &'static str) {
        let (first, rest) = name.text.split_once('.').unwrap_or((&name.text, ""));
        let named = self.names.get(first);
        // One fault for each point or element that is missing, wherever it is used.
        let owner = name.text.rsplit_once('.').map_or(name.text.as_str(), |(owner, _)| owner);
        let subject = if named.is_some() || first == "ground" { owner } else { first };
        if self.is_reported(name, subject) {
            return;
        }
        let help = match named {
            Some(Named::Body(id)) => self.points_hint(first, rest, &self.names.points[id.0]),
            _ if first == "ground" => self.points_hint(first, rest, &self.names.ground),
            Some(Named::Input(_)) => {
                format!("`{first}` is an input, which is always a variable of the FMU")
            }
            Some(Named::Parameter(_)) => {
                format!("`{first}` is a parameter, which is always a variable of the FMU")
            }
            Some(Named::Signal(_)) => format!("`{first}` is a signal without variables: write `{first}` alone"),
            _ => {
                let known = self.names.all(|named| !named.is_number());
                let otherwise =
                    "variables are named `BODY.angle`, `BODY.POINT.x`, `JOINT.fx`, `energy.total` and the like";
                let known = known.into_iter().chain(["energy", "constraint", "ground"]);
                suggest::nearest(first, known).map_or(otherwise.to_owned(), |near| self.whole_name(near, rest))
            }
        };
        let message = format!("{user} names a variable that does not exist: `{}`", name.text);
        self.faults.push_about(subject, Fault::new(code, message, name.span).label("no such variable").help(help));
    }

    fn points_hint(&self, owner: &str, rest: &str, points: &HashMap<&str, usize>) -> String {
        let (point, last) = rest.split_once('.').unwrap_or((rest, ""));
        let mut points: Vec<&str> = points.keys().copied().collect();
        points.sort_unstable();
        match (suggest::nearest(point, points.iter().copied()), points.first()) {
            (Some(near), _) => self.whole_name(&format!("{owner}.{near}"), last),
            (None, None) => format!("`{owner}` has no points"),
            (None, Some(first)) => {
                let list = suggest::list(points.iter().copied());
                format!("`{owner}` has the points {list}, with variables such as `{owner}.{first}.x`")
            }
        }
    }

    /// "did you mean `hinge.fx`?", of the name that its owner should have and what follows it; variables that there are where that is none.
    fn whole_name(&self, owner: &str, rest: &str) -> String {
        let (owner, last) = match rest.rsplit_once('.') {
            Some((point, last)) => (format!("{owner}.{point}"), last),
            None => (owner.to_owned(), rest),
        };
        let variables = self.variables_of(&owner);
        let near = variables.iter().find(|variable| **variable == last).copied();
        let near =
            near.or_else(|| meant(last, &variables)).or_else(|| suggest::nearest(last, variables.iter().copied()));
        match near.or(variables.first().copied()) {
            Some(variable) => format!("did you mean `{owner}.{variable}`?"),
            None => format!("did you mean `{owner}`?"),
        }
    }

    /// The last words of the variables of an owner.
    pub(super) fn variables_of(&self, owner: &str) -> Vec<&'static str> {
        let one_dimensional = self.one_dimensional();
        let has = self.find_owner(owner).map_or_else(Vec::new, |found| found.has);
        has.iter()
            .filter(|quantity| !one_dimensional || quantity.is_on_a_line())
            .map(|quantity| quantity.word())
            .collect()
    }

    /// "angle of `crank`"
    pub(super) fn describe(variable: Variable, name: &str) -> String {
        let words = variable.quantity.words();
        match variable.owner {
            Owner::System => words.to_string(),
            Owner::Place(_) | Owner::Joint(_) | Owner::Driver(_) | Owner::Load(_) => {
                format!("{words} `{}`", name.rsplit_once('.').map_or(name, |(owner, _)| owner))
            }
        }
    }
}

/// Which point may have been meant, or which there are.
/// What variables are called elsewhere.
const CALLED: [(&str, &[&str]); 6] = [
    ("angle", &["theta", "phi", "rotation", "q"]),
    ("omega", &["w", "theta_dot", "thetadot", "angular_velocity", "qd"]),
    ("alpha", &["angular_acceleration", "qdd"]),
    ("vx", &["dx", "xdot", "x_dot"]),
    ("vy", &["dy", "ydot", "y_dot"]),
    ("fn", &["normal_force", "n"]),
];

/// The one of the variables that is meant by a word that is none of them.
fn meant<'n>(word: &str, names: &[&'n str]) -> Option<&'n str> {
    let called = CALLED.iter().filter(|(_, words)| words.contains(&word.to_lowercase().as_str()));
    called.filter_map(|(name, _)| names.iter().find(|candidate| *candidate == name)).next().copied()
}
