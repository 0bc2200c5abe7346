//! Joints that events engage and release, and rates that they set.

use super::Resolver;
use super::context::Context;
use super::names::Named;
use crate::component::Section;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::expr::Order;
use crate::model::{
    Aspect, Class, Discrete, DiscreteId, DiscreteKind, Engaging, JointId, Owner, Part, RateChange, Variable,
};
use crate::scene::document::Content;
use crate::scene::model::{Event, Scene};
use crate::scene::part as written;
use crate::scene::quantity::Quantity;

/// Keys whose laws act whether a joint is engaged or not, and which it therefore cannot have.
const NOT_ENGAGING: [&str; 5] = ["damping", "friction", "armature", "limits", "backlash"];

impl Scene {
    /// True at the start if that joint is engaged then; none if no event engages or releases it, and it does not say.
    pub(super) fn engaging(&self, owner: Owner) -> Option<bool> {
        let Owner::Joint(JointId(index)) = owner else { return None };
        let part = self.joints.get(index)?;
        let component = part.component(Section::Joints).filter(|component| !component.engaging.is_empty())?;
        let engaged = part.get("engaged").filter(|_| component.keys.iter().any(|key| key.name == "engaged"));
        let is_named = |names: &[Text]| names.iter().any(|name| name.text == part.name.text);
        let changes = self.events.iter().any(|event| is_named(&event.engage) || is_named(&event.release));
        let begins = !matches!(engaged.map(|node| &node.kind), Some(Content::Boolean(false)));
        (changes || engaged.is_some()).then_some(begins)
    }
}

impl written::Part {
    /// True if it engages where it stands, later.
    pub(super) fn engages_here(&self) -> bool {
        let is_open = matches!(self.get("engaged").map(|node| &node.kind), Some(Content::Boolean(false)));
        is_open && self.text("at").is_none_or(|at| at.text != "named")
    }
}

impl Resolver<'_> {
    /// A joint is engaged and released by two events, not by one.
    pub(super) fn check_once(&mut self, event: &Event, what: &str) {
        for name in &event.release {
            if event.engage.iter().any(|engaged| engaged.text == name.text) {
                let message = format!("{what} both engages and releases `{}`", name.text);
                let fault = Fault::new("scene::engage", message, name.span).label("engaged by the same event");
                self.faults.push(fault.help("let one event engage it and another release it"));
            }
        }
    }

    /// The joint with that name, if events can engage it.
    pub(super) fn engaged(&mut self, name: &Text, (does, done): (&str, &str), what: &str) -> Option<Owner> {
        let scene = self.scene;
        let named = self.names.get(&name.text);
        if let Some(Named::Joint(joint)) = named {
            let component = scene.joints[joint.0].component(Section::Joints)?;
            if !component.engaging.is_empty() {
                return Some(Owner::Joint(joint));
            }
            let message =
                format!("{what} {does} `{}`, but a joint of type `{}` cannot be {done}", name.text, component.name);
            let kinds = Section::Joints.components().filter(|component| !component.engaging.is_empty());
            let kinds = suggest::list(kinds.map(|component| component.name));
            let fault = Fault::new("scene::engage", message, name.span).label(format!("cannot be {done}"));
            self.faults.push(fault.help(format!("the types that engage are {kinds}; `remove` works for all")));
            return None;
        }
        if self.is_reported(name, &name.text) {
            return None;
        }
        let (message, help) = match named {
            Some(named @ (Named::Driver(_) | Named::Load(_))) => (
                format!("{what} {does} the {} `{}`, but only joints can be {done}", named.word(), name.text),
                "multiply its law by a sampled value that the event sets".to_owned(),
            ),
            Some(named) => (
                format!("{what} {does} the {} `{}`, but only joints can be {done}", named.word(), name.text),
                "name a joint".to_owned(),
            ),
            None => {
                let joints: Vec<&str> = scene.joints.iter().map(|joint| joint.name.text.as_str()).collect();
                let otherwise = format!("the joints are {}", suggest::list(joints.iter().copied()));
                let message = format!("{what} {does} `{}`, which is not in the scene", name.text);
                (message, suggest::hint(&name.text, joints, otherwise))
            }
        };
        let fault = Fault::new("scene::unknown_name", message, name.span).label(format!("cannot be {done}"));
        self.faults.push(fault.help(help));
        None
    }

    /// A rate that an event sets, with its value.
    pub(super) fn set_rate(&mut self, name: &Text, value: &Quantity, what: &str) -> Option<RateChange> {
        let variable = self.variable(name, what, "scene::unknown_variable")?;
        let is_held_by = |word: &str| match variable.owner {
            Owner::Joint(joint) => {
                let component = self.scene.joints[joint.0].component(Section::Joints);
                component.is_some_and(|component| component.drivers.contains(&word))
            }
            Owner::Place(place) => place.body().is_some(),
            Owner::Driver(_) | Owner::Load(_) | Owner::System => false,
        };
        let can_be_set = match variable.quantity.aspect() {
            Aspect::Angle(Order::Velocity) => is_held_by("angle"),
            Aspect::Slide(Order::Velocity) => is_held_by("displacement"),
            Aspect::Along(_, Order::Velocity) => is_held_by(""),
            _ => false,
        };
        if !can_be_set {
            self.refuse_to_set(name, variable, what);
            return None;
        }
        if self.frame().is_placed() {
            self.refuse_place(what, name.span, "set the rate in the scene itself");
            return None;
        }
        let what = format!("`set.\"{}\"` of {what}", name.text);
        let formula = self.formula(value, &what, &variable.quantity.measure(), Context::Instant(None));
        Some(RateChange { variable, value: formula, span: name.span })
    }

    fn refuse_to_set(&mut self, name: &Text, variable: Variable, what: &str) {
        let (why, help) = match variable.quantity.class() {
            Class::Position => {
                ("a position, which cannot change at once", "set its rate, move it by a driver, or let a joint engage")
            }
            Class::Velocity => (
                "a rate that no single impulse sets",
                "set the `vx`, `vy` or `omega` of a body, or the `omega` or `v` of a joint",
            ),
            Class::Acceleration | Class::Effort | Class::Contact | Class::State | Class::System => {
                ("a result of the motion", "set a rate, a state or a sampled value")
            }
        };
        let message = format!("{what} sets `{}`, {why}", name.text);
        self.faults.push(Fault::new("scene::engage", message, name.span).label("cannot be set").help(help));
    }

    /// The joints that events engage or release, and those that say whether they are engaged.
    pub(super) fn engaging(&mut self, joints: &[Part], discrete: &[Discrete]) -> Vec<Engaging> {
        let scene = self.scene;
        let mut all = Vec::new();
        for part in joints {
            let Some(begins) = scene.engaging(part.owner) else { continue };
            let kind = DiscreteKind::Presence(part.owner);
            let Some(engaged) = discrete.iter().position(|discrete| discrete.kind == kind) else { continue };
            for key in NOT_ENGAGING {
                if part.value(key).is_some() {
                    let message = format!("joint `{}` engages by an event, and has `{key}`", part.name);
                    let fault = Fault::new("scene::engage", message, part.span).label("cannot have both");
                    let help = format!("leave out `{key}`, or give it to a second joint that does not engage");
                    self.faults.push(fault.help(help));
                }
            }
            all.push(Engaging {
                owner: part.owner,
                engaged: DiscreteId(engaged),
                begins,
                here: part.choice("at") != Some("named"),
                impulses: Vec::new(),
                lost: None,
                left_out: Vec::new(),
            });
        }
        all
    }
}
