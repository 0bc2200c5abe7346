//! The names of a scene: who is called what.

use std::collections::{HashMap, HashSet};

use crate::component::Section;
use crate::diagnostic::fault::{Fault, Sink};
use crate::diagnostic::span::Text;
use crate::expr::Function;
use crate::model::{BodyId, DiscreteId, DriverId, InputId, JointId, LoadId, StateId};
use crate::scene::lookalike::names_of;
use crate::scene::model::Scene;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Named {
    /// Its place in the scene.
    Parameter(usize),
    Input(InputId),
    State(StateId),
    /// A sampled value.
    Sampled(DiscreteId),
    /// Its place in the scene.
    Signal(usize),
    Body(BodyId),
    Joint(JointId),
    Driver(DriverId),
    Load(LoadId),
}

impl Named {
    pub fn word(self) -> &'static str {
        match self {
            Named::Parameter(_) => "parameter",
            Named::Input(_) => "input",
            Named::State(_) => "state",
            Named::Sampled(_) => "sampled value",
            Named::Signal(_) => "signal",
            Named::Body(_) => "body",
            Named::Joint(_) => "joint",
            Named::Driver(_) => "driver",
            Named::Load(_) => "load",
        }
    }

    /// Does the name alone stand for a number?
    pub fn is_number(self) -> bool {
        matches!(self, Named::Parameter(_) | Named::Input(_) | Named::State(_) | Named::Sampled(_) | Named::Signal(_))
    }
}

pub(super) struct SceneNames<'s> {
    named: HashMap<&'s str, (Named, &'s Text)>,
    pub ground: HashMap<&'s str, usize>,
    pub points: Vec<HashMap<&'s str, usize>>,
    /// What could not be read or stands for two things; its uses are no faults.
    broken: HashSet<&'s str>,
}

impl<'s> SceneNames<'s> {
    pub fn collect(scene: &'s Scene, faults: &mut Sink) -> SceneNames<'s> {
        let parts =
            [(Section::Joints, &scene.joints), (Section::Drivers, &scene.drivers), (Section::Loads, &scene.loads)];
        let unknown = parts.into_iter().flat_map(|(section, parts)| {
            parts.iter().filter(move |part| part.component(section).is_none()).map(|part| part.name.text.as_str())
        });
        let shapeless = scene.bodies.iter().filter(|body| !body.is_readable()).map(|body| body.name.text.as_str());
        let broken = scene.broken.iter().map(String::as_str).chain(unknown).chain(shapeless).collect();
        let mut names = SceneNames { named: HashMap::new(), ground: HashMap::new(), points: Vec::new(), broken };
        names.ground = points(scene.ground.iter().map(|point| &point.name), "the ground", faults);
        names.points = scene
            .bodies
            .iter()
            .map(|body| {
                let names = body.entries("points").iter().map(|(name, _)| name);
                points(names, &format!("body `{}`", body.name.text), faults)
            })
            .collect();
        let all = (scene.parameters.iter().enumerate().map(|(i, item)| (&item.name, Named::Parameter(i))))
            .chain(scene.inputs.iter().enumerate().map(|(i, item)| (&item.name, Named::Input(InputId(i)))))
            .chain(scene.states.iter().enumerate().map(|(i, item)| (&item.name, Named::State(StateId(i)))))
            .chain(scene.sampled_values().map(|(id, value)| (&value.name, Named::Sampled(id))))
            .chain(scene.signals.iter().enumerate().map(|(i, item)| (&item.name, Named::Signal(i))))
            .chain(scene.bodies.iter().enumerate().map(|(i, item)| (&item.name, Named::Body(BodyId(i)))))
            .chain(scene.joints.iter().enumerate().map(|(i, item)| (&item.name, Named::Joint(JointId(i)))))
            .chain(scene.drivers.iter().enumerate().map(|(i, item)| (&item.name, Named::Driver(DriverId(i)))))
            .chain(scene.loads.iter().enumerate().map(|(i, item)| (&item.name, Named::Load(LoadId(i)))));
        for (name, named) in all {
            names.add(name, named, faults);
        }
        unique(scene.sampled.iter().map(|sampler| &sampler.name), "sampler", "the scene", faults);
        unique(scene.events.iter().map(|event| &event.name), "event", "the scene", faults);
        names
    }

    fn add(&mut self, name: &'s Text, named: Named, faults: &mut Sink) {
        // A part is only ever named with a point or a variable, so it can be called like a function.
        if named.is_number() || !is_function(name) {
            check_identifier(name, named.word(), faults);
        }
        if let Some((first, first_name)) = self.named.get(name.text.as_str()) {
            let mut fault = Fault::new(
                "scene::duplicate_name",
                format!("the name `{}` is used twice: as {} and as {}", name.text, first.word(), named.word()),
                name.span,
            )
            .label("second time")
            .help("each parameter, input, state, sampled value, signal, body, joint, driver and load needs its own name, because the FMU's variables are named after them");
            if !first_name.span.is_nowhere() {
                fault.also.push(first_name.span);
            }
            faults.push(fault);
            // Which of the two its uses mean, nobody knows.
            self.broken.insert(&name.text);
        } else {
            self.named.insert(&name.text, (named, name));
        }
    }

    pub fn get(&self, name: &str) -> Option<Named> {
        self.named.get(name).map(|(named, _)| *named)
    }

    /// A fault has been reported for what has this name: its uses are none.
    pub fn spoil(&mut self, name: &'s str) {
        self.broken.insert(name);
    }

    /// Has a fault been reported for what has this name?
    pub fn is_broken(&self, name: &str) -> bool {
        !self.broken.is_empty()
            && (self.broken.contains(name)
                || name.match_indices('.').any(|(dot, _)| self.broken.contains(&name[..dot])))
    }

    /// The names that stand for something that `select` selects, in alphabetical order.
    pub fn all(&self, select: impl Fn(Named) -> bool) -> Vec<&'s str> {
        let mut names: Vec<&str> =
            self.named.iter().filter(|(_, (named, _))| select(*named)).map(|(name, _)| *name).collect();
        names.sort_unstable();
        names
    }
}

fn points<'s>(names: impl Iterator<Item = &'s Text>, owner: &str, faults: &mut Sink) -> HashMap<&'s str, usize> {
    unique(names, "point", owner, faults)
}

/// The places of names that are of one kind and their owner's alone.
fn unique<'s>(
    names: impl Iterator<Item = &'s Text>,
    what: &str,
    owner: &str,
    faults: &mut Sink,
) -> HashMap<&'s str, usize> {
    let mut map = HashMap::new();
    for (index, name) in names.enumerate() {
        check_word(name, what, faults);
        if map.insert(name.text.as_str(), index).is_some() {
            let message = format!("{owner} has two {what}s with the name `{}`", name.text);
            faults.push(Fault::new("scene::duplicate_name", message, name.span).label("second time"));
        }
    }
    map
}

/// A name must be a word and must not mean something already.
pub(super) fn check_identifier(name: &Text, what: &str, faults: &mut Sink) {
    check_word(name, what, faults);
    let function = is_function(name) || name.text == "if";
    let meaning = match name.text.as_str() {
        "ground" => "the ground",
        "t" | "time" => "the time",
        "pi" => "the number 3.14159...",
        "energy" | "constraint" => "the owner of the system's variables",
        _ if function => "a function",
        _ => return,
    };
    let message = format!("{} cannot be called `{}`: that is {meaning}", one(what), name.text);
    faults.push(Fault::new("scene::reserved_name", message, name.span).label("reserved").help("choose another name"));
}

fn is_function(name: &Text) -> bool {
    Function::named(&name.text).is_some_and(Function::is_reserved)
}

pub(super) fn one(what: &str) -> String {
    let article = if what.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {what}")
}

fn check_word(name: &Text, what: &str, faults: &mut Sink) {
    let mut characters = name.text.chars();
    let first = characters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
    if !first || !characters.all(|c| c.is_ascii_alphanumeric() || c == '_') {
        faults.push(
            Fault::new("scene::bad_name", format!("`{}` cannot be the name of {}", name.text, one(what)), name.span)
                .label("not a name")
                .help(format!("write `{}`: names are made of the letters a-z and A-Z, digits and `_`, and do not begin with a digit", names_of(&name.text))),
        );
    }
}
