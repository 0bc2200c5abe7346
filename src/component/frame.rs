//! Elements of a part where it is placed. The ground of a part is a frame of its own: mirrored, turned, moved, and fixed to the scene's ground or to a
//! body. Whatever an element counts from that ground, the scene counts from the other. With s = -1 in a mirror, else 1, the angle of one end against
//! another is s times that in the part, plus the part's angle if the first end alone is its ground, minus it if the second alone is. Every component
//! says what that makes of its keys, so that none can be forgotten; where its ends are is the business of names.

use crate::expr::Unary;
use crate::model::{BodyId, Formula, KeyValue, Motion, Part, Place};
use crate::scene::constant::number;

pub(super) const ZERO: Formula = Formula::Number(0.0);

/// How the ground of a part lies in that of the scene, or in a body: a place p of the part is at + R(angle) F p there, with F = diag(-1, 1) in a mirror.
#[derive(Clone, Debug, PartialEq)]
pub struct PartFrame {
    /// Are left and right exchanged?
    pub mirror: bool,
    /// By how much it is turned then.
    pub angle: Formula,
    /// Where its origin is.
    pub at: [Formula; 2],
    /// The body that it is fixed to, if that is not the ground.
    pub on: Option<BodyId>,
    /// The point that its origin is.
    pub origin: Place,
}

impl Default for PartFrame {
    fn default() -> PartFrame {
        PartFrame { mirror: false, angle: ZERO, at: [ZERO, ZERO], on: None, origin: Place::Origin }
    }
}

impl PartFrame {
    /// This frame of a part of a part, in what the other frame lies in.
    pub fn within(self, outer: &PartFrame) -> PartFrame {
        PartFrame {
            mirror: self.mirror != outer.mirror,
            angle: sum(outer.signed(self.angle), outer.angle.clone()),
            at: outer.place(self.at),
            ..outer.clone()
        }
    }

    /// Is it elsewhere than the frame that it is fixed to?
    pub fn is_moved(&self) -> bool {
        self.mirror || [&self.angle, &self.at[0], &self.at[1]].into_iter().any(|value| *value != ZERO)
    }

    /// Does the scene see anything otherwise than the part?
    pub fn is_placed(&self) -> bool {
        self.is_moved() || self.on.is_some()
    }

    /// A value that a mirror makes its opposite.
    pub fn signed(&self, value: Formula) -> Formula {
        match number(&value) {
            _ if !self.mirror => value,
            // Zero stays positive.
            Some(number) => Formula::Number(0.0 - number),
            None => -value,
        }
    }

    /// The same of a vector in the axes of a body of the part.
    pub fn mirrored(&self, [x, y]: [Formula; 2]) -> [Formula; 2] {
        [self.signed(x), y]
    }

    /// A vector in the part's axes.
    pub fn direction(&self, vector: [Formula; 2]) -> [Formula; 2] {
        turned(self.mirrored(vector), self.angle.clone())
    }

    /// A vector in the scene's axes, in the part's.
    pub fn direction_back(&self, vector: [Formula; 2]) -> [Formula; 2] {
        self.mirrored(turned(vector, -self.angle.clone()))
    }

    /// A place in the part's ground.
    pub fn place(&self, place: [Formula; 2]) -> [Formula; 2] {
        let ([x, y], [at_x, at_y]) = (self.direction(place), self.at.clone());
        [sum(at_x, x), sum(at_y, y)]
    }

    /// What is added to the angle of the second of two ends against the first.
    pub fn turned(&self, ends: [Option<BodyId>; 2]) -> Formula {
        match ends.map(|end| end == self.on) {
            [true, false] => self.angle.clone(),
            [false, true] => -self.angle.clone(),
            _ => ZERO,
        }
    }
}

/// A sum without zeros.
pub(crate) fn sum(a: Formula, b: Formula) -> Formula {
    if a == ZERO { b } else { a + b }
}

/// A difference without zeros.
pub(crate) fn minus(a: Formula, b: Formula) -> Formula {
    if a == ZERO { -b } else { a - b }
}

/// A product without zeros.
pub(super) fn times(a: Formula, b: Formula) -> Formula {
    if a == ZERO || b == ZERO { ZERO } else { a * b }
}

fn turned([x, y]: [Formula; 2], angle: Formula) -> [Formula; 2] {
    if angle == ZERO {
        return [x, y];
    }
    let (sine, cosine) = (angle.clone().of(Unary::Sin), angle.of(Unary::Cos));
    [minus(times(cosine.clone(), x.clone()), times(sine.clone(), y.clone())), sum(times(sine, x), times(cosine, y))]
}

/// Why an element cannot be placed: the key that cannot follow, what of it, and what to do instead.
pub(crate) type Refusal = (&'static str, &'static str, &'static str);

/// An element that is being placed.
pub struct Placed<'a> {
    pub frame: &'a PartFrame,
    pub part: &'a mut Part,
    /// What is added to the angle that it calls its own.
    pub turned: Formula,
    /// Does what its curve moves turn?
    pub turns: bool,
    pub refused: Vec<Refusal>,
}

/// For components that count nothing from the ground, and have neither a left nor a sense of rotation.
pub(super) fn anywhere(_: &mut Placed<'_>) {}

impl Placed<'_> {
    /// What is added to the angle of one of its two ends against the body from which it counts.
    pub fn turned_on_carrier(&self, end: usize) -> Formula {
        self.frame.turned([self.part.place("carrier").body(), self.part.between[end].body()])
    }

    /// A direction in the axes of a body.
    pub fn axis(&mut self, key: &'static str, of: Place) {
        let frame = self.frame;
        self.vector(key, |axis| if of.body() == frame.on { frame.direction(axis) } else { frame.mirrored(axis) });
    }

    /// The angle of its second end against its first.
    pub fn angle(&mut self, key: &'static str) {
        let turned = self.turned.clone();
        self.number(key, |frame, angle| sum(turned, frame.signed(angle)));
    }

    /// The limits of the angle of its second end against its first: a mirror exchanges them.
    pub fn limits(&mut self, key: &'static str) {
        let Some(KeyValue::Limits(mut limits)) = self.part.value(key).cloned() else { return };
        let turned = self.turned.clone();
        limits.ends = limits.ends.map(|end| end.map(|end| sum(turned.clone(), self.frame.signed(end))));
        if self.frame.mirror {
            limits.ends.reverse();
        }
        self.part.set(key, KeyValue::Limits(limits));
    }

    /// A value that a mirror makes its opposite.
    pub fn sign(&mut self, key: &'static str) {
        self.number(key, |frame, value| frame.signed(value));
    }

    /// One of two words, of which a mirror makes the other; the first if it is absent.
    pub fn side(&mut self, key: &'static str, words: [&'static str; 2]) {
        if self.frame.mirror && self.part.choice(key).is_none() {
            self.part.set(key, KeyValue::Choice(words[1]));
        } else {
            self.exchange(key, words);
        }
    }

    /// Two words that a mirror exchanges, if one of them is there.
    pub fn exchange(&mut self, key: &'static str, words: [&'static str; 2]) {
        let place = words.iter().position(|word| self.part.choice(key) == Some(word));
        if let Some(place) = place.filter(|_| self.frame.mirror) {
            self.part.set(key, KeyValue::Choice(words[1 - place]));
        }
    }

    /// A value by a map; one that is not there stays so unless the map makes it another than zero.
    pub fn number(&mut self, key: &'static str, map: impl FnOnce(&PartFrame, Formula) -> Formula) {
        let value = self.part.key(key);
        let made = map(self.frame, value.clone());
        if made != value {
            self.part.set(key, KeyValue::Formula(made));
        }
    }

    /// Two components by a map.
    pub fn vector(&mut self, key: &'static str, map: impl FnOnce([Formula; 2]) -> [Formula; 2]) {
        if self.part.value(key).is_some() {
            self.part.set(key, KeyValue::Vector(map(self.part.vector(key))));
        }
    }

    /// A prescribed angle: one that integrates an input begins where it is, and turns the way that the input says.
    pub fn motion(&mut self, key: &'static str) {
        let turned = self.turned.clone();
        match self.part.value(key).cloned() {
            Some(KeyValue::Motion(Motion::Given(angle))) => {
                let angle = sum(turned, self.frame.signed(angle));
                self.part.set(key, KeyValue::Motion(Motion::Given(angle)));
            }
            Some(_) if self.frame.mirror || turned != ZERO => self.refuse(
                key,
                "its motion, which integrates an input",
                "let the input be the position itself: `as = \"position\"`",
            ),
            _ => {}
        }
    }

    pub fn refuse(&mut self, key: &'static str, why: &'static str, help: &'static str) {
        self.refused.push((key, why, help));
    }
}
