//! The bodies, joints, drivers and loads of a part where it is placed: axes, angles, torques and forces, by the forms of their keys.

use super::operand::Operand;
use super::placed::Placing;
use crate::component::{Component, Section, shape};
use crate::diagnostic::span::{Span, Text};
use crate::mechanism::measure::{ANGLE, ANYTHING, FORCE, LENGTH, TORQUE, Wanted};
use crate::scene::document::{Kind, Node};
use crate::scene::expression::substituted;
use crate::scene::key::{Form, Range};
use crate::scene::model::Scene;
use crate::scene::part::Part;

/// What an element is between, as far as its place matters.
struct Ends {
    names: [String; 2],
    /// The body in whose frame its axis is.
    frame: String,
    has_carrier: bool,
}

fn is_ground(name: &str) -> bool {
    name == "ground" || name.starts_with("ground.")
}

impl Placing<'_> {
    pub(super) fn elements(&mut self, part: &mut Scene) {
        let joints = part.joints.clone();
        for (section, parts) in sections(part) {
            for element in parts {
                let Some(component) = element.component(section) else { continue };
                let turned = self.turned_by(&ends(element, component, &joints));
                self.turned.insert(element.name.text.clone(), turned);
            }
        }
        for (section, parts) in sections(part) {
            for element in parts {
                if let Some(component) = element.component(section) {
                    self.element(element, component, &joints);
                }
            }
        }
    }

    /// What is added to the angle of the second end against the first.
    fn turned_by(&self, ends: &Ends) -> Option<Operand> {
        match ends.names.each_ref().map(|name| is_ground(name)) {
            [true, false] => self.angle.clone(),
            [false, true] => self.angle.clone().map(Operand::negated),
            _ => None,
        }
    }

    fn element(&mut self, element: &mut Part, component: &Component, joints: &[Part]) {
        let ends = ends(element, component, joints);
        let turned = self.turned_by(&ends);
        let in_body = element.text("frame").is_some_and(|frame| frame.text == "body");
        let axis = component.keys.iter().any(|key| matches!(key.form, Form::Axis));
        for key in component.keys {
            let angle_of_two = matches!(key.form, Form::Constant(wanted, _) if wanted.exponents == ANGLE.exponents);
            if angle_of_two && ends.has_carrier && self.angle.is_some() && is_ground(&ends.frame) {
                self.refuse(&format!("`{}`", element.name.text), element.name.span, "let a body carry the wheels");
                continue;
            }
            if angle_of_two && turned.is_some() && !ends.has_carrier && element.get(key.name).is_none() {
                element.insert(key.name, Node::from(Operand::Number(0.0).at(element.name.span)));
            }
            let owner = element.name.text.clone();
            let Some(node) = element.get_mut(key.name) else { continue };
            self.substitute(node, key.form, component, &owner);
            match key.form {
                Form::Axis if is_ground(&ends.frame) => {
                    Placing::change_both(node, &ANYTHING, |axis| self.direction(axis))
                }
                Form::Axis => Placing::change_both(node, &ANYTHING, |[x, y]| [self.signed(x), y]),
                Form::Constant(wanted, _) if angle_of_two => {
                    Placing::change(node, &wanted, |angle| sum(turned.clone(), self.signed(angle)));
                }
                // The teeth of a rack and the thread of a screw are on the other side.
                Form::Constant(wanted, Range::NotZero) if wanted.exponents == LENGTH.exponents => {
                    Placing::change(node, &wanted, |length| self.signed(length));
                }
                Form::Constant(wanted, Range::Positive)
                    if axis && self.used.mirror && wanted.exponents == LENGTH.exponents =>
                {
                    let span = node.span;
                    self.refuse(
                        &format!("`{owner}`, which is on the left of its line"),
                        span,
                        "mirror it by parameters",
                    );
                }
                Form::Law(wanted) if wanted.exponents == TORQUE.exponents => {
                    Placing::change(node, &wanted, |torque| self.signed(torque));
                }
                // The cam's angle would count from elsewhere, or the other way round.
                Form::Curve(..) if self.used.mirror || self.angle.is_some() => {
                    let span = node.span;
                    self.refuse(
                        &format!("`{owner}`, whose law counts from the carrier's x"),
                        span,
                        "turn it by parameters",
                    );
                }
                Form::Vector(wanted) => self.components(node, wanted, in_body, &owner),
                Form::Motion([wanted, ..]) if wanted.exponents == ANGLE.exponents => {
                    self.motion(node, turned.clone(), &owner)
                }
                _ => {}
            }
        }
        self.ground(element, component);
    }

    /// A force or a place in the world or in a body.
    fn components(&mut self, node: &mut Node, wanted: Wanted, in_body: bool, owner: &str) {
        let is_force = wanted.exponents == FORCE.exponents;
        if is_force && in_body {
            Placing::change_both(node, &wanted, |[x, y]| [self.signed(x), y]);
        } else if self.on.is_some() && (self.is_moved() || !is_force) {
            let span = node.span;
            self.refuse(
                &format!("`{owner}`, which is in the world's axes"),
                span,
                "give the force in the body's frame",
            );
        } else if is_force {
            Placing::change_both(node, &wanted, |force| self.direction(force));
        } else {
            Placing::change_both(node, &wanted, |place| self.world(place));
        }
    }

    fn motion(&mut self, node: &mut Node, turned: Option<Operand>, owner: &str) {
        let is_input = matches!(node.kind, Kind::Table(_));
        if is_input && (turned.is_some() || self.used.mirror) {
            let help = "give the motion as an expression of the input";
            self.refuse(&format!("`{owner}`, which follows an input"), node.span, help);
        } else {
            Placing::change(node, &ANGLE, |angle| sum(turned, self.signed(angle)));
        }
    }

    /// Laws say what a part's variables are in the part; the scene's are others.
    fn substitute(&mut self, node: &mut Node, form: Form, component: &Component, owner: &str) {
        let span = node.span;
        match (form, &mut node.kind) {
            (Form::Law(_) | Form::Motion(_), Kind::Text(text)) => self.law(text, component, owner, span),
            (Form::Vector(_), Kind::Array(items)) => {
                for item in items {
                    if let Kind::Text(text) = &mut item.kind {
                        self.law(text, component, owner, span);
                    }
                }
            }
            _ => {}
        }
    }

    fn law(&mut self, text: &mut String, component: &Component, owner: &str, span: Span) {
        if !self.is_moved() {
            return;
        }
        let unknown = std::cell::Cell::new(false);
        let whole = Text::from(text.as_str());
        if !matches!(crate::scene::quantity::read(&whole), Ok(crate::scene::quantity::Reading::Expression)) {
            return;
        }
        *text = substituted(text, |name| {
            let (of, word) = name.rsplit_once('.').unwrap_or((owner, name));
            let is_own = component.own.iter().any(|own| own.word() == name);
            let of_body = self.bodies.iter().any(|body| of.split('.').next() == Some(body));
            if of_body && self.on.is_some() {
                unknown.set(true);
            }
            let is_element = self.turned.contains_key(of) && (name.contains('.') || is_own);
            self.in_the_part(name, word, of_body, is_element.then_some(of))
        });
        if unknown.get() {
            self.refuse(
                &format!("the law of `{owner}`"),
                span,
                "let it depend on variables of joints and springs only",
            );
        }
    }

    /// What a variable of the part is in terms of the scene's.
    fn in_the_part(&self, name: &str, word: &str, of_body: bool, element: Option<&str>) -> Option<String> {
        let pair =
            |words: [&str; 2]| words.map(|other| Operand::Text(format!("{}{other}", &name[..name.len() - word.len()])));
        let itself = Operand::Text(name.to_owned());
        let back = |[x, y]: [Operand; 2]| self.direction_back([x, y]);
        let local = match word {
            "omega" if of_body || element.is_some() => self.signed(itself),
            "angle" if of_body => self.signed(sum(self.angle.clone().map(Operand::negated), itself)),
            "angle" => {
                let turned = self.turned.get(element?).cloned().flatten();
                self.signed(sum(turned.map(Operand::negated), itself))
            }
            "x" | "y" if of_body => {
                let [x, y] = pair(["x", "y"]);
                let [at_x, at_y] = self.at.clone().unwrap_or([Operand::Number(0.0), Operand::Number(0.0)]);
                let [x, y] = back([x.plus(at_x.negated()), y.plus(at_y.negated())]);
                if word == "x" { x } else { y }
            }
            "vx" | "vy" if of_body => {
                let [x, y] = back(pair(["vx", "vy"]));
                if word == "vx" { x } else { y }
            }
            _ => return None,
        };
        Some(format!("({})", local.text()))
    }

    /// F R^T v
    fn direction_back(&self, [x, y]: [Operand; 2]) -> [Operand; 2] {
        let [x, y] = match &self.angle {
            None => [x, y],
            Some(angle) => {
                let (sine, cosine) = (angle.of_function("sin"), angle.of_function("cos"));
                [
                    cosine.clone().times(x.clone()).plus(sine.clone().times(y.clone())),
                    cosine.times(y).plus(sine.times(x).negated()),
                ]
            }
        };
        [self.signed(x), y]
    }

    /// Its ends on the ground are on the part's.
    fn ground(&self, element: &mut Part, component: &Component) {
        let (origin, on) = (self.has_origin().then(|| self.origin()), self.on.map(|on| on.text.clone()));
        let place = |node: &mut Node, to: &Option<String>| match (&mut node.kind, to) {
            (Kind::Text(text), Some(to)) if text == "ground" => text.clone_from(to),
            _ => {}
        };
        for key in component.keys {
            let node = element.get_mut(key.name);
            match (key.form, node) {
                (Form::Points, Some(Node { kind: Kind::Array(items), .. })) => {
                    items.iter_mut().for_each(|item| place(item, &origin));
                }
                (Form::Bodies, Some(Node { kind: Kind::Array(items), .. })) => {
                    items.iter_mut().for_each(|item| place(item, &on));
                }
                (Form::BodyAndPoint, Some(Node { kind: Kind::Array(items), .. })) => {
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
                (Form::Body, Some(Node { kind: Kind::Text(body), .. })) => {
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
        let mirrored = |node: &mut Node| Placing::change_both(node, &LENGTH, |[x, y]| [x.negated(), y]);
        if let Some(node) = body.get_mut("com") {
            mirrored(node);
        }
        if let Some(Node { kind: Kind::Table(points), .. }) = body.get_mut("points") {
            points.iter_mut().for_each(|(_, node)| mirrored(node));
        }
        let Some(Node { kind: Kind::Table(entries), .. }) = body.get_mut("shape") else { return };
        for (key, node) in entries {
            let places = shape::ALL.iter().map(|shape| shape.place);
            match places.into_iter().find(|place| place.name == key.text).map(|place| place.form) {
                Some(Form::Corner) => mirrored(node),
                Some(Form::Corners(..)) => {
                    if let Kind::Array(corners) = &mut node.kind {
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

fn sum(turned: Option<Operand>, angle: Operand) -> Operand {
    match turned {
        Some(turned) => turned.plus(angle),
        None => angle,
    }
}

pub(super) fn sections(scene: &mut Scene) -> [(Section, &mut Vec<Part>); 3] {
    [(Section::Joints, &mut scene.joints), (Section::Drivers, &mut scene.drivers), (Section::Loads, &mut scene.loads)]
}

/// Its ends: its own, those of the joint that it moves, or the ground and the body that it acts on.
fn ends(element: &Part, component: &Component, joints: &[Part]) -> Ends {
    let own = || element.between().map(|pair| pair.map(|end| end.text));
    let of_joint = || {
        let name = element.text("joint")?;
        let joint = joints.iter().find(|joint| joint.name.text == name.text)?;
        Some(joint.between()?.map(|end| end.text))
    };
    let on = || Some(["ground".to_owned(), element.text("on")?.text]);
    let names = own().or_else(of_joint).or_else(on).unwrap_or_default();
    let has_carrier = component.keys.iter().any(|key| key.form.is_carrier());
    let carrier = element.text("carrier").map_or("ground".to_owned(), |carrier| carrier.text);
    let frame = if has_carrier { carrier } else { names[0].clone() };
    Ends { names, frame, has_carrier }
}
