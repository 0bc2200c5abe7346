//! The bodies, joints, drivers and loads of a part where it is placed: the laws that they are given, the names of their ends, and what their components
//! make of their keys.

use super::placed::Placing;
use crate::component::{Component, Section, change_both, shape, sum, within_a_turn};
use crate::diagnostic::span::Text;
use crate::mechanism::Quantity as Variable;
use crate::mechanism::measure::LENGTH;
use crate::scene::document::{Content, Node};
use crate::scene::expression::substituted;
use crate::scene::key::Form;
use crate::scene::model::{Scene, Signal};
use crate::scene::operand::Operand;
use crate::scene::part::Part;
use crate::scene::quantity::{Quantity, Reading, Value, read};

impl Placing<'_> {
    pub(super) fn elements(&mut self, part: &mut Scene) {
        for (section, parts) in sections(part) {
            for element in parts {
                let Some(component) = element.component(section) else { continue };
                let turned = self.frame.turned_of(element, component);
                let within = component.keys.iter().any(|key| matches!(key.form, Form::Curve(..)));
                self.turned.insert(element.name.text.clone(), (turned, within));
            }
        }
        for (section, parts) in sections(part) {
            for element in parts {
                if let Some(component) = element.component(section) {
                    self.element(element, component);
                }
            }
        }
        for Signal { name, value, .. } in &mut part.signals {
            let Quantity { value: Value::Text(text), span } = value else { continue };
            if self.law(text, &[], &name.text) | has_direction(text) {
                let help = "let it depend on positions and velocities of joints and springs only";
                self.refuse(&format!("signal `{}`", name.text), *span, help);
            }
        }
    }

    fn element(&mut self, element: &mut Part, component: &'static Component) {
        let owner = element.name.text.clone();
        for key in component.keys {
            if let Some(node) = element.get_mut(key.name) {
                self.substitute(node, key.form, component, &owner);
            }
        }
        for (why, span, help) in component.place(element, &self.frame) {
            self.refuse(&format!("`{owner}`: {why}"), span, help);
        }
        self.ground(element, component);
    }

    /// Laws say what a part's variables are in the part; the scene's are others.
    fn substitute(&mut self, node: &mut Node, form: Form, component: &Component, owner: &str) {
        let span = node.span;
        let unknown = match (form, &mut node.kind) {
            (Form::Law(_) | Form::Motion(_), Content::Text(text)) => self.law(text, component.own, owner),
            (Form::Vector(_), Content::Array(items)) => {
                let law = |item: &mut Node| match &mut item.kind {
                    Content::Text(text) => self.law(text, component.own, owner),
                    _ => false,
                };
                items.iter_mut().map(law).fold(false, |any, unknown| any | unknown)
            }
            _ => false,
        };
        if unknown {
            let help = "let it depend on variables of joints and springs only";
            self.refuse(&format!("the law of `{owner}`"), span, help);
        }
    }

    /// Writes a law in the scene's variables; true if it uses what is not known where the part is.
    fn law(&self, text: &mut String, own: &[Variable], owner: &str) -> bool {
        if !is_expression(text) {
            return false;
        }
        let unknown = std::cell::Cell::new(false);
        *text = substituted(text, |name| {
            let (of, word) = name.rsplit_once('.').unwrap_or((owner, name));
            let is_own = own.iter().any(|own| own.word() == name);
            let is_element = self.turned.contains_key(of) && (name.contains('.') || is_own);
            if is_element {
                // Where a load is, as its coordinates say, depends on both of its ends.
                unknown.set(unknown.get() || matches!(word, "x" | "y" | "vx" | "vy"));
                return self.of_element(name, word, of);
            }
            let of_body = self.bodies.iter().any(|body| of.split('.').next() == Some(body));
            let of_place = of_body || of.starts_with("ground.");
            unknown.set(unknown.get() || of_place && self.on.is_some());
            if of_place { self.of_place(name, word) } else { None }
        });
        unknown.get()
    }

    /// What the variable of an element is in terms of the scene's.
    fn of_element(&self, name: &str, word: &str, element: &str) -> Option<String> {
        let itself = Operand::Text(name.to_owned());
        let local = match word {
            "omega" | "pressure_angle" | "torque" => self.frame.signed(itself).text(),
            "angle" => {
                let (turned, within) = self.turned.get(element).cloned()?;
                let angle = self.frame.signed(sum(itself, turned.map(Operand::negated))).text();
                if within { within_a_turn(&angle) } else { angle }
            }
            _ => return None,
        };
        Some(format!("({local})"))
    }

    /// What the variable of a body or of a point is in terms of the scene's.
    fn of_place(&self, name: &str, word: &str) -> Option<String> {
        let itself = Operand::Text(name.to_owned());
        let other = |other: &str| Operand::Text(format!("{}{other}", &name[..name.len() - word.len()]));
        let local = match word {
            "omega" => self.frame.signed(itself),
            "angle" => self.frame.signed(sum(itself, self.frame.angle.clone().map(Operand::negated))),
            "x" | "y" => {
                let [at_x, at_y] = self.frame.at.clone().unwrap_or([Operand::Number(0.0), Operand::Number(0.0)]);
                let [x, y] =
                    self.frame.direction_back([other("x").plus(at_x.negated()), other("y").plus(at_y.negated())]);
                if word == "x" { x } else { y }
            }
            "vx" | "vy" => {
                let [x, y] = self.frame.direction_back([other("vx"), other("vy")]);
                if word == "vx" { x } else { y }
            }
            _ => return None,
        };
        Some(format!("({})", local.text()))
    }

    /// Its ends on the ground are on the part's.
    fn ground(&self, element: &mut Part, component: &Component) {
        let (origin, on) = (self.has_origin().then(|| self.origin()), self.on.map(|on| on.text.clone()));
        let place = |node: &mut Node, to: &Option<String>| match (&mut node.kind, to) {
            (Content::Text(text), Some(to)) if text == "ground" => text.clone_from(to),
            _ => {}
        };
        for key in component.keys {
            let node = element.get_mut(key.name);
            match (key.form, node) {
                (Form::Points, Some(Node { kind: Content::Array(items), .. })) => {
                    items.iter_mut().for_each(|item| place(item, &origin));
                }
                (Form::Bodies, Some(Node { kind: Content::Array(items), .. })) => {
                    items.iter_mut().for_each(|item| place(item, &on));
                }
                (Form::BodyAndPoint, Some(Node { kind: Content::Array(items), .. })) => {
                    let targets = [&on, &origin];
                    items.iter_mut().zip(targets).for_each(|(item, to)| place(item, to));
                }
                (Form::Point | Form::CarrierPoint, Some(node)) => place(node, &origin),
                (Form::CarrierBody, Some(node)) => place(node, &on),
                (Form::CarrierPoint, None) => {
                    origin.iter().for_each(|to| element.insert(key.name, Node::from(to.as_str())))
                }
                (Form::CarrierBody, None) => on.iter().for_each(|to| element.insert(key.name, Node::from(to.as_str()))),
                // It acts between the ground and the body.
                (Form::Body, Some(Node { kind: Content::Text(body), .. })) => {
                    if let Some(on) = &on {
                        let between = Node::from([on.as_str(), body.as_str()]);
                        element.remove(key.name);
                        element.insert("between", between);
                    }
                }
                _ => {}
            }
        }
    }

    pub(super) fn mirror_body(&self, body: &mut Part) {
        let mirrored = |node: &mut Node| change_both(node, &LENGTH, |[x, y]| [x.negated(), y]);
        if let Some(node) = body.get_mut("com") {
            mirrored(node);
        }
        if let Some(Node { kind: Content::Table(points), .. }) = body.get_mut("points") {
            points.iter_mut().for_each(|(_, node)| mirrored(node));
        }
        let Some(Node { kind: Content::Table(entries), .. }) = body.get_mut("shape") else { return };
        for (key, node) in entries {
            let places = shape::ALL.iter().map(|shape| shape.place);
            match places.into_iter().find(|place| place.name == key.text).map(|place| place.form) {
                Some(Form::Corner) => mirrored(node),
                Some(Form::Corners(..)) => {
                    if let Content::Array(corners) = &mut node.kind {
                        corners.iter_mut().for_each(mirrored);
                        // They stay counter-clockwise.
                        corners.reverse();
                    }
                }
                _ => {}
            }
        }
    }
}

fn is_expression(text: &str) -> bool {
    matches!(read(&Text::from(text)), Ok(Reading::Expression))
}

/// Does an expression use what has a direction in the scene, and none in the part: a component of a reaction or of an acceleration?
fn has_direction(text: &str) -> bool {
    let found = std::cell::Cell::new(false);
    let is_one = |name: &str| {
        let (_, word) = name.rsplit_once('.').unwrap_or_default();
        found.set(found.get() || matches!(word, "fx" | "fy" | "fn" | "ft" | "ax" | "ay" | "alpha"));
        None
    };
    if is_expression(text) {
        substituted(text, is_one);
    }
    found.get()
}

pub(super) fn sections(scene: &mut Scene) -> [(Section, &mut Vec<Part>); 3] {
    [(Section::Joints, &mut scene.joints), (Section::Drivers, &mut scene.drivers), (Section::Loads, &mut scene.loads)]
}
