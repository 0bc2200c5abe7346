//! Elements of a part where it is placed. The ground of a part is a frame of its own: mirrored, turned, moved, and fixed to the scene's ground or to a
//! body. Whatever an element counts from that ground, the scene counts from the other. With s = -1 in a mirror, else 1, the angle of one end against
//! another is s times that in the part, plus the part's angle if the first end alone is its ground, minus it if the second alone is. Every component
//! says what that makes of its keys, so that none can be forgotten; where its ends are is the business of names.

use super::Component;
use crate::diagnostic::span::Span;
use crate::mechanism::measure::{ANGLE, ANYTHING, LENGTH, Wanted};
use crate::scene::document::{Content, Node};
use crate::scene::expression::substituted;
use crate::scene::key::Form;
use crate::scene::operand::Operand;
use crate::scene::part::Part;
use crate::scene::quantity::{Quantity, Value};

/// How the ground of a part lies in that of the scene, or in a body.
#[derive(Debug)]
pub struct Frame<'a> {
    /// Are left and right exchanged?
    pub mirror: bool,
    /// By how much it is turned then.
    pub angle: Option<Operand>,
    /// Where its origin is.
    pub at: Option<[Operand; 2]>,
    /// Is it in a body?
    pub on_body: bool,
    /// The joints of the part.
    pub joints: &'a [Part],
}

/// Is this the name of the ground or of one of its points?
fn is_ground(name: &str) -> bool {
    name == "ground" || name.starts_with("ground.")
}

impl Frame<'_> {
    /// A value that a mirror makes its opposite.
    pub fn signed(&self, operand: Operand) -> Operand {
        if self.mirror { operand.negated() } else { operand }
    }

    /// The same of a vector in the axes of a body of the part.
    pub fn mirrored(&self, [x, y]: [Operand; 2]) -> [Operand; 2] {
        [self.signed(x), y]
    }

    /// A vector in the part's axes.
    pub fn direction(&self, vector: [Operand; 2]) -> [Operand; 2] {
        let [x, y] = self.mirrored(vector);
        let Some(angle) = &self.angle else { return [x, y] };
        let (sine, cosine) = (angle.of_function("sin"), angle.of_function("cos"));
        [
            cosine.clone().times(x.clone()).plus(sine.clone().times(y.clone()).negated()),
            sine.times(x).plus(cosine.times(y)),
        ]
    }

    /// A vector in the scene's axes, in the part's.
    pub fn direction_back(&self, [x, y]: [Operand; 2]) -> [Operand; 2] {
        let Some(angle) = &self.angle else { return self.mirrored([x, y]) };
        let (sine, cosine) = (angle.of_function("sin"), angle.of_function("cos"));
        self.mirrored([
            cosine.clone().times(x.clone()).plus(sine.clone().times(y.clone())),
            cosine.times(y).plus(sine.times(x).negated()),
        ])
    }

    /// A place in the part's ground.
    pub fn place(&self, place: [Operand; 2]) -> [Operand; 2] {
        let [x, y] = self.direction(place);
        match self.at.clone() {
            Some([at_x, at_y]) => [at_x.plus(x), at_y.plus(y)],
            None => [x, y],
        }
    }

    /// What is added to the angle of the second of two ends against the first.
    pub fn turned(&self, ends: [&str; 2]) -> Option<Operand> {
        match ends.map(is_ground) {
            [true, false] => self.angle.clone(),
            [false, true] => self.angle.clone().map(Operand::negated),
            _ => None,
        }
    }

    /// What is added to the angle that an element calls its own.
    pub fn turned_of(&self, element: &Part, component: &Component) -> Option<Operand> {
        let [first, second] = self.ends(element, component);
        self.turned([&first, &second])
    }

    fn joint(&self, name: &str) -> Option<&Part> {
        self.joints.iter().find(|joint| joint.name.text == name)
    }

    /// Between which ends an element's angle is: its own, those of the joint that it moves, the shaft's if it is a cam, or the ground and a body.
    fn ends(&self, element: &Part, component: &Component) -> [String; 2] {
        let of_joint = |key: &str| Some(self.joint(&element.text(key)?.text)?.between()?.map(|end| end.text));
        let own = element.between().map(|pair| pair.map(|end| end.text));
        let other = component.keys.iter().find(|key| matches!(key.form, Form::OtherJoint));
        if let (Some([cam, _]), Some([a, b])) = (&own, other.and_then(|key| of_joint(key.name))) {
            return if body_of(&a) == body_of(cam) { [b, a] } else { [a, b] };
        }
        let on = || Some(["ground".to_owned(), element.text("on")?.text]);
        own.or_else(|| of_joint("joint")).or_else(on).unwrap_or_default()
    }
}

fn body_of(name: &str) -> &str {
    name.split('.').next().unwrap_or_default()
}

/// Why an element cannot be placed: what of it, where that is written, and what to do instead.
pub(crate) type Refusal = (&'static str, Span, &'static str);

/// An element that is being placed.
pub struct Placed<'a> {
    pub frame: &'a Frame<'a>,
    component: &'static Component,
    element: &'a mut Part,
    refused: Vec<Refusal>,
}

impl Component {
    /// Makes an element of a part what the scene sees of it.
    pub fn place(&'static self, element: &mut Part, frame: &Frame) -> Vec<Refusal> {
        let mut placed = Placed { frame, component: self, element, refused: Vec::new() };
        (self.placed)(&mut placed);
        placed.refused
    }
}

/// For components that count nothing from the ground, and have neither a left nor a sense of rotation.
pub(super) fn anywhere(_: &mut Placed<'_>) {}

impl Placed<'_> {
    /// Its two ends.
    pub fn ends(&self) -> [String; 2] {
        self.frame.ends(self.element, self.component)
    }

    /// The body from which it counts, if that is a third one.
    pub fn carrier(&self) -> String {
        self.element.text("carrier").map_or("ground".to_owned(), |carrier| carrier.text)
    }

    /// What is added to the angle of one end against another; zero if it is none.
    pub fn turned(&self, ends: [&str; 2]) -> Operand {
        self.frame.turned(ends).unwrap_or(Operand::Number(0.0))
    }

    /// A direction in the axes of one of its ends.
    pub fn axis(&mut self, key: &str, of: &str) {
        let frame = self.frame;
        let map = |axis| if is_ground(of) { frame.direction(axis) } else { frame.mirrored(axis) };
        self.with_both(key, &ANYTHING, map);
    }

    /// The angle of its second end against its first.
    pub fn angle(&mut self, key: &str) {
        let turned = self.frame.turned_of(self.element, self.component);
        self.with(key, &ANGLE, |frame, angle| sum(frame.signed(angle), turned));
    }

    /// A value that a mirror makes its opposite.
    pub fn sign(&mut self, key: &str, wanted: &Wanted) {
        self.with(key, wanted, |frame, value| frame.signed(value));
    }

    /// More of a value that may be absent.
    pub fn add(&mut self, key: &str, wanted: &Wanted, more: Operand) {
        self.with(key, wanted, |_, value| value.plus(more));
    }

    /// One of two words, of which a mirror makes the other; the first if it is absent.
    pub fn side(&mut self, key: &str, words: [&str; 2]) {
        if self.frame.mirror && self.element.get(key).is_none() {
            self.put(key, Node::from(words[1]));
        } else {
            self.exchange(key, words);
        }
    }

    /// Two words that a mirror exchanges, if one of them is there.
    pub fn exchange(&mut self, key: &str, words: [&str; 2]) {
        let place = words.iter().position(|word| self.is(key, word));
        if let Some(place) = place.filter(|_| self.frame.mirror) {
            self.put(key, Node::from(words[1 - place]));
        }
    }

    /// The joint that a key names.
    pub fn joint(&self, key: &str) -> Option<&Part> {
        self.frame.joint(&self.element.text(key)?.text)
    }

    pub fn is(&self, key: &str, word: &str) -> bool {
        self.element.text(key).is_some_and(|text| text.text == word)
    }

    /// What a key says; zero if it is absent.
    pub fn operand(&self, key: &str, wanted: &Wanted) -> Operand {
        self.element.get(key).and_then(|node| quantity(node, wanted)).unwrap_or(Operand::Number(0.0))
    }

    /// A length that is to be a factor of the angle by which the part is turned; zero if it is absent.
    pub fn length(&self, key: &str) -> Operand {
        let length = self.operand(key, &LENGTH);
        if self.frame.angle.as_ref().is_some_and(Operand::is_text) { length.in_metres() } else { length }
    }

    /// A value by a map; one that is not there, or is no such value, stays so unless the map makes it another than zero.
    pub fn with(&mut self, key: &str, wanted: &Wanted, map: impl FnOnce(&Frame, Operand) -> Operand) {
        let Some(node) = self.element.get(key) else {
            let made = map(self.frame, Operand::Number(0.0));
            if made != Operand::Number(0.0) && made != Operand::Number(-0.0) {
                let span = self.element.name.span;
                self.put(key, Node::from(made.at(span)));
            }
            return;
        };
        if let Some(value) = quantity(node, wanted) {
            let made = map(self.frame, value.clone());
            if made != value {
                let span = node.span;
                self.put(key, Node::from(made.at(span)));
            }
        }
    }

    /// Two components by a map.
    pub fn with_both(&mut self, key: &str, wanted: &Wanted, map: impl FnOnce([Operand; 2]) -> [Operand; 2]) {
        if let Some(node) = self.element.get_mut(key) {
            change_both(node, wanted, map);
        }
    }

    /// A prescribed angle: one that integrates an input begins where it is, and turns the way that the input says.
    pub fn motion(&mut self, key: &str) {
        let turned = self.frame.turned_of(self.element, self.component);
        let Some(Node { kind: Content::Table(entries), .. }) = self.element.get(key) else { return self.angle(key) };
        if turned.is_none() && !self.frame.mirror {
            return;
        }
        let text = |name: &str| entries.iter().find(|(key, _)| key.text == name).and_then(|(_, node)| node.text());
        match (text("input"), text("as")) {
            (Some(input), Some(word)) if word.text == "position" => {
                self.put(key, Node::from(Operand::Text(input.text).at(input.span)));
                self.angle(key);
            }
            _ => self.refuse(
                key,
                "its motion, which integrates an input",
                "let the input be the angle itself: `as = \"position\"`",
            ),
        }
    }

    /// A law of the element's own angle that repeats every turn.
    pub fn curve(&mut self, key: &str) {
        let turned = self.frame.turned_of(self.element, self.component);
        let Some(node) = self.element.get(key) else { return };
        let Content::Text(text) = &node.kind else { return };
        if turned.is_none() && !self.frame.mirror {
            return;
        }
        let own = self.frame.signed(sum(Operand::Text("angle".to_owned()), turned.map(Operand::negated)));
        let within = within_a_turn(&own.text());
        let text = substituted(text, |name| (name == "angle").then(|| within.clone()));
        self.put(key, Node::from(Quantity { value: Value::Text(text), span: node.span }));
    }

    pub fn refuse(&mut self, key: &str, why: &'static str, help: &'static str) {
        let span = self.element.get(key).map_or(self.element.name.span, |node| node.span);
        self.refused.push((why, span, help));
    }

    fn put(&mut self, key: &str, node: Node) {
        match self.element.get_mut(key) {
            Some(old) => *old = node,
            None => self.element.insert(key, node),
        }
    }
}

/// The angle from 0 to 2 pi, as a text.
pub(crate) fn within_a_turn(angle: &str) -> String {
    format!("({angle} - 2*pi*floor({angle}/(2*pi)))")
}

pub(crate) fn sum(value: Operand, more: Option<Operand>) -> Operand {
    match more {
        Some(more) => more.plus(value),
        None => value,
    }
}

/// What a node says, if it is a quantity.
fn quantity(node: &Node, wanted: &Wanted) -> Option<Operand> {
    match &node.kind {
        Content::Number(number) => Some(Operand::Number(*number)),
        Content::Text(text) => Operand::of(&Quantity::from(text.as_str()), wanted),
        _ => None,
    }
}

/// Two quantities in a list by a map of both.
pub(crate) fn change_both(node: &mut Node, wanted: &Wanted, map: impl FnOnce([Operand; 2]) -> [Operand; 2]) {
    let Content::Array(items) = &mut node.kind else { return };
    let [x, y] = &mut items[..] else { return };
    let (Some(a), Some(b)) = (quantity(x, wanted), quantity(y, wanted)) else { return };
    let [a, b] = map([a, b]);
    (*x, *y) = (Node::from(a.at(x.span)), Node::from(b.at(y.span)));
}
