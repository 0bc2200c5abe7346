//! Names of a part in the scene that uses it: `arm` of the part `left` is `left_arm`, which the scene may also call `left.arm`.

use std::collections::HashSet;

use crate::component::{Section, body, outline, shape, transfer};
use crate::diagnostic::span::Text;
use crate::model::Quantity as Variable;
use crate::scene::document::{Content, DocumentNode};
use crate::scene::expression::{substituted, with_files as with_files_of};
use crate::scene::key::{Form, Key};
use crate::scene::model::{Scene, Vector};
use crate::scene::part::Part;
use crate::scene::quantity::{Quantity, QuantityReading, Value, read};
use crate::scene::tables::{CORNER, DRUM, PULLEY};

/// What is written for a name instead, if anything is.
type Map<'m> = &'m dyn Fn(&str) -> Option<String>;

/// What is done to the texts of a scene: to its names, and to its expressions, with the own variables that their part has.
struct Walk<'w> {
    name: &'w mut dyn FnMut(&mut String),
    law: &'w mut dyn FnMut(&mut String, &[Variable]),
}

/// The names of everything that a scene has a name for, but for its points.
pub(super) fn names(scene: &Scene) -> HashSet<String> {
    let parts = [&scene.bodies, &scene.joints, &scene.drivers, &scene.loads].into_iter().flatten();
    let parts = parts.map(|part| &part.name);
    let parameters = scene.parameters.iter().map(|parameter| &parameter.name);
    let inputs = scene.inputs.iter().map(|input| &input.name);
    let states = scene.states.iter().map(|state| &state.name);
    let signals = scene.signals.iter().map(|signal| &signal.name);
    let sampled = scene.sampled.iter().flat_map(|sampler| &sampler.values).map(|value| &value.name);
    let named = parts.chain(parameters).chain(inputs).chain(states).chain(sampled).chain(signals);
    named.map(|name| name.text.clone()).collect()
}

/// Writes `left_arm` wherever a scene says `left.arm` of its part `left`.
pub(super) fn with_underscores(scene: &mut Scene) {
    let parts: Vec<String> = scene.uses.iter().map(|used| used.name.text.clone()).collect();
    let map = |name: &str| {
        let (ground, rest) = name.strip_prefix("ground.").map_or(("", name), |rest| ("ground.", rest));
        let (first, rest) = rest.split_once('.')?;
        parts.iter().any(|part| part == first).then(|| format!("{ground}{first}_{rest}"))
    };
    renaming(&map, |walk| {
        walk.scene(scene);
        let trees = [&mut scene.coordinates.translation, &mut scene.coordinates.rotation];
        trees.into_iter().flatten().flatten().for_each(|branch| (walk.name)(&mut branch.text));
    });
}

/// Gives the files of its tables other paths.
pub(super) fn with_files(scene: &mut Scene, replace: &mut dyn FnMut(&str) -> String) {
    Walk { name: &mut |_| {}, law: &mut |text, _| *text = with_files_of(text, &mut *replace) }.scene(scene);
}

/// Puts the name of the part before every name of its scene.
pub(super) fn with_prefix(scene: &mut Scene, prefix: &str) {
    let local_names = names(scene);
    let events: HashSet<String> = scene.events.iter().map(|event| event.name.text.clone()).collect();
    let map = |name: &str| match name.split_once('.').unwrap_or((name, "")) {
        ("ground", "") => None,
        ("ground", point) => Some(format!("ground.{prefix}_{point}")),
        ("events", rest) => {
            let event = rest.split('.').next()?;
            events.contains(event).then(|| format!("events.{prefix}_{rest}"))
        }
        (first, _) => local_names.contains(first).then(|| format!("{prefix}_{name}")),
    };
    renaming(&map, |walk| walk.scene(scene));
    let add = |name: &mut Text| name.text.insert_str(0, &format!("{prefix}_"));
    scene.uses.iter_mut().for_each(|used| add(&mut used.name));
    scene.parameters.iter_mut().for_each(|parameter| add(&mut parameter.name));
    scene.inputs.iter_mut().for_each(|input| add(&mut input.name));
    scene.states.iter_mut().for_each(|state| add(&mut state.name));
    for sampler in &mut scene.sampled {
        add(&mut sampler.name);
        sampler.values.iter_mut().for_each(|value| add(&mut value.name));
    }
    scene.events.iter_mut().for_each(|event| add(&mut event.name));
    scene.signals.iter_mut().for_each(|signal| add(&mut signal.name));
    scene.ground.iter_mut().for_each(|point| add(&mut point.name));
    scene.ground_outlines.iter_mut().for_each(|outline| prefix_points(&mut outline.node, prefix));
    let parts = [&mut scene.bodies, &mut scene.joints, &mut scene.drivers, &mut scene.loads];
    parts.into_iter().flatten().for_each(|part| add(&mut part.name));
    scene.outputs.expressions.iter_mut().for_each(|output| add(&mut output.name));
    scene.broken.iter_mut().for_each(|name| name.insert_str(0, &format!("{prefix}_")));
}

/// Puts the name of the part before the points of its ground that an outline names: these have it already.
fn prefix_points(outline: &mut DocumentNode, prefix: &str) {
    let Content::Table(entries) = &mut outline.kind else { return };
    for (key, node) in entries {
        let places = match &mut node.kind {
            _ if outline::ALL.iter().all(|kind| kind.place.name != key.text) => continue,
            Content::Array(items) => &mut items[..],
            _ => std::slice::from_mut(node),
        };
        for place in places {
            if let Content::Text(point) = &mut place.kind {
                point.insert_str(0, &format!("{prefix}_"));
            }
        }
    }
}

/// Writes the name of a body wherever a scene names a point of the ground.
pub(super) fn with_ground(scene: &mut Scene, body: &str) {
    let map = |name: &str| name.strip_prefix("ground.").map(|point| format!("{body}.{point}"));
    renaming(&map, |walk| walk.scene(scene));
}

/// A walk that gives names other texts; the own variables of parts keep theirs.
fn renaming(map: Map<'_>, walk: impl FnOnce(&mut Walk<'_>)) {
    let mut name = |text: &mut String| {
        if let Some(other) = map(text) {
            *text = other;
        }
    };
    let mut law = |text: &mut String, variables: &[Variable]| {
        let is_own = |name: &str| variables.iter().any(|variable| variable.word() == name);
        *text = substituted(text, |name| if is_own(name) { None } else { map(name) });
    };
    walk(&mut Walk { name: &mut name, law: &mut law });
}

/// Any value that is written as an expression.
const ANY: Form = Form::Law(crate::model::measure::ANYTHING);

impl Walk<'_> {
    /// All texts of a scene but the names of its own elements.
    fn scene(&mut self, scene: &mut Scene) {
        for parameter in &mut scene.parameters {
            let values = [Some(&mut parameter.value), parameter.min.as_mut(), parameter.max.as_mut()];
            values.into_iter().flatten().for_each(|value| self.quantity(value));
        }
        for input in &mut scene.inputs {
            let values = [input.start.as_mut(), input.min.as_mut(), input.max.as_mut()];
            values.into_iter().flatten().for_each(|value| self.quantity(value));
        }
        for state in &mut scene.states {
            let values = [Some(&mut state.rate), state.start.as_mut(), state.nominal.as_mut()];
            values.into_iter().flatten().for_each(|value| self.quantity(value));
        }
        for sampler in &mut scene.sampled {
            [Some(&mut sampler.period), sampler.offset.as_mut()]
                .into_iter()
                .flatten()
                .for_each(|quantity| self.quantity(quantity));
            let values = sampler.values.iter_mut().flat_map(|value| [value.start.as_mut(), value.next.as_mut()]);
            values.flatten().for_each(|value| self.quantity(value));
        }
        for event in &mut scene.events {
            (self.law)(&mut event.when.text, &[]);
            let parts = [&mut event.remove, &mut event.engage, &mut event.release];
            parts.into_iter().flatten().for_each(|name| (self.name)(&mut name.text));
            for (name, value) in &mut event.set {
                (self.name)(&mut name.text);
                self.quantity(value);
            }
        }
        scene.ground.iter_mut().for_each(|point| self.vector(&mut point.at));
        scene.ground_outlines.iter_mut().for_each(|outline| self.value(&mut outline.node, Form::Outline, &[]));
        scene.bodies.iter_mut().for_each(|part| self.entries(part, body::KEYS, &[]));
        let sections = [
            (Section::Joints, &mut scene.joints),
            (Section::Drivers, &mut scene.drivers),
            (Section::Loads, &mut scene.loads),
        ];
        for (section, parts) in sections {
            for part in parts {
                if let Some(component) = part.component(section) {
                    self.entries(part, component.keys, component.law_variables);
                }
            }
        }
        for used in &mut scene.uses {
            used.on.iter_mut().chain([&mut used.origin]).for_each(|place| (self.name)(&mut place.text));
            used.at.iter_mut().for_each(|at| self.vector(at));
            let values = used.angle.iter_mut().chain(used.parameters.iter_mut().map(|(_, value)| value));
            values.for_each(|value| self.quantity(value));
        }
        for initial in &mut scene.initial {
            (self.name)(&mut initial.variable.text);
            self.quantity(&mut initial.value);
        }
        scene.outputs.variables.iter_mut().for_each(|variable| (self.name)(&mut variable.text));
        let signals = scene.signals.iter_mut().chain(&mut scene.outputs.expressions);
        for signal in signals {
            self.quantity(&mut signal.value);
            if let Some(part) = &mut signal.part {
                let keys: Vec<Key> = part.transfer().map(transfer::Transfer::all_keys).unwrap_or_default();
                self.entries(part, &keys, &[]);
            }
        }
    }

    /// The values of a table with these keys.
    fn entries(&mut self, part: &mut Part, keys: &[Key], variables: &[Variable]) {
        let Content::Table(entries) = &mut part.node.kind else { return };
        for (key, node) in entries {
            if let Some(known) = keys.iter().find(|known| known.name == key.text) {
                self.value(node, known.form, variables);
            }
        }
    }

    fn value(&mut self, node: &mut DocumentNode, form: Form, variables: &[Variable]) {
        use Form::{
            Axis, Bodies, Body, BodyAndPoint, CarrierBody, CarrierPoint, Constant, ConstantVector, Corner, Corners,
            Curve, Joint, Law, Motion, NamedPoints, Names, OtherJoint, Point, Points, Record,
        };
        match (form, &mut node.kind) {
            (Points | Bodies | BodyAndPoint | Names, Content::Array(items)) => {
                items.iter_mut().for_each(|item| self.value(item, Point, variables));
            }
            (Point | Body | Joint | OtherJoint | CarrierBody | CarrierPoint, Content::Text(text)) => (self.name)(text),
            (Constant(..) | Law(_) | Curve(..) | Motion(_), Content::Text(text)) => self.law(text, variables),
            // In a list of places a text is the name of a point of the body.
            (Form::Vector(_) | ConstantVector(_) | Axis | Corner, Content::Array(items)) => {
                items.iter_mut().for_each(|item| self.value(item, ANY, variables));
            }
            (Motion(_), Content::Table(entries)) => {
                let input = entries.iter_mut().find(|(key, _)| key.text == "input");
                input.into_iter().for_each(|(_, node)| self.value(node, Point, variables));
            }
            (Record(_), Content::Table(entries)) => {
                entries.iter_mut().for_each(|(_, node)| self.value(node, ANY, variables));
            }
            (NamedPoints, Content::Table(entries)) => {
                entries.iter_mut().for_each(|(_, node)| self.value(node, Axis, variables));
            }
            (Corners(..), Content::Array(items)) => {
                items.iter_mut().for_each(|item| self.value(item, Corner, variables))
            }
            (Form::Ends, Content::Array(items)) => {
                items.iter_mut().for_each(|item| match item.kind {
                    Content::Table(_) => self.table(item, DRUM),
                    _ => self.value(item, Point, variables),
                });
            }
            (Form::Course, Content::Array(items)) => items.iter_mut().for_each(|item| self.table(item, PULLEY)),
            (Form::Profile, Content::Array(items)) => items.iter_mut().for_each(|item| match item.kind {
                Content::Table(_) => self.table(item, CORNER),
                _ => self.value(item, Axis, variables),
            }),
            (Form::Shape, Content::Table(entries)) => entries.iter_mut().for_each(|(key, node)| {
                let keys = shape::ALL.iter().flat_map(|shape| shape.all_keys());
                if let Some(known) = keys.into_iter().find(|known| known.name == key.text) {
                    self.value(node, known.form, variables);
                }
            }),
            (Form::Outline, Content::Table(entries)) => entries.iter_mut().for_each(|(key, node)| {
                let keys = outline::ALL.iter().flat_map(|kind| kind.keys());
                if let Some(known) = keys.into_iter().find(|known| known.name == key.text) {
                    self.value(node, known.form, variables);
                }
            }),
            // Words that are no names; or the wrong type, which is reported where it is read.
            _ => {}
        }
    }

    /// The values of a table with these keys.
    fn table(&mut self, node: &mut DocumentNode, keys: &[Key]) {
        let Content::Table(entries) = &mut node.kind else { return };
        for (key, node) in entries {
            if let Some(known) = keys.iter().find(|known| known.name == key.text) {
                self.value(node, known.form, &[]);
            }
        }
    }

    fn vector(&mut self, vector: &mut Vector) {
        vector.components.iter_mut().for_each(|component| self.quantity(component));
    }

    fn quantity(&mut self, quantity: &mut Quantity) {
        if let Value::Text(text) = &mut quantity.value {
            self.law(text, &[]);
        }
    }

    fn law(&mut self, text: &mut String, variables: &[Variable]) {
        if matches!(read(&Text::from(text.as_str())), Ok(QuantityReading::Expression)) {
            (self.law)(text, variables);
        }
    }
}
