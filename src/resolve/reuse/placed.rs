//! Where a part is: its left and right exchanged, turned, moved, and fixed to a body, in this order. A place p of the part is at + R(angle) F p in
//! the frame of that body, with F = diag(-1, 1) if it is mirrored; its bodies then have the angles angle + s theta, s = -1 if mirrored.

use std::collections::HashMap;

use super::operand::Operand;
use super::renamed;
use crate::diagnostic::fault::{Fault, Sink};
use crate::diagnostic::span::{Span, Text};
use crate::mechanism::Dimension;
use crate::mechanism::measure::{ANGLE, LENGTH, Wanted};
use crate::scene::document::{Kind, Node};
use crate::scene::model::{Initial, Point, Scene, Use, Vector};
use crate::scene::quantity::Quantity;

/// How a part is placed.
pub(super) struct Placing<'a> {
    pub used: &'a Use,
    pub faults: &'a mut Sink,
    /// The body that its ground is fixed to, if that is not the ground.
    pub on: Option<&'a Text>,
    pub at: Option<[Operand; 2]>,
    pub angle: Option<Operand>,
    /// By how much the angle of the second end counts from more than before, for each element with an angle.
    pub turned: HashMap<String, Option<Operand>>,
    /// The names of its bodies.
    pub bodies: Vec<String>,
}

impl<'a> Placing<'a> {
    pub fn new(used: &'a Use, faults: &'a mut Sink) -> Self {
        let component = |vector: &Vector, axis: usize| Operand::of(vector.components.get(axis)?, &LENGTH);
        let at = used.at.as_ref().and_then(|at| Some([component(at, 0)?, component(at, 1)?]));
        if let (Some(written), None) = (&used.at, &at) {
            let fault = Fault::new("scene::wrong_value", "`at` of a part is no place", written.span);
            faults.push(fault.label("two lengths are wanted").help("such as `at = [\"0.5 m\", 0]`"));
        }
        let angle = used.angle.as_ref().and_then(|angle| Operand::of(angle, &ANGLE));
        if let (Some(written), None) = (&used.angle, &angle) {
            let fault = Fault::new("scene::wrong_unit", "`angle` of a part is no angle", written.span);
            faults.push(fault.label("not an angle").help("such as `angle = \"30 deg\"`"));
        }
        let on = used.on.as_ref().filter(|on| on.text != "ground");
        Placing { used, faults, on, at, angle, turned: HashMap::new(), bodies: Vec::new() }
    }

    pub fn place(mut self, part: &mut Scene, host: &mut Scene) {
        if !self.is_moved() && self.on.is_none() {
            return;
        }
        if part.dimension == Dimension::One {
            let message = format!("part `{}` cannot be placed on a line", self.used.name.text);
            let fault =
                Fault::new("scene::one_dimension", message, self.used.name.span).label("not with `dimension = 1`");
            self.faults.push(fault.help("give the places as parameters of the part"));
            return;
        }
        self.bodies = part.bodies.iter().map(|body| body.name.text.clone()).collect();
        for point in &mut part.ground {
            point.at = self.point(&point.at);
        }
        if self.needs_origin(part) {
            let zero = || Operand::Number(0.0).at(Span::default());
            let at = self.point(&Vector { components: vec![zero(), zero()], span: Span::default() });
            part.ground.push(Point { name: Text::from(self.origin_name()), at });
        }
        self.elements(part);
        if self.used.mirror {
            part.bodies.iter_mut().for_each(|body| self.mirror_body(body));
        }
        self.initial(&mut part.initial);
        if let Some(on) = self.on {
            self.fix(part, host, on);
        }
    }

    pub fn is_moved(&self) -> bool {
        self.at.is_some() || self.angle.is_some() || self.used.mirror
    }

    fn origin_name(&self) -> String {
        format!("{}_ground", self.used.name.text)
    }

    /// How the elements of the part call its origin.
    pub fn origin(&self) -> String {
        format!("ground.{}", self.origin_name())
    }

    /// Is the origin of the part another point than that of the ground, and is it used?
    pub fn has_origin(&self) -> bool {
        self.at.is_some() || self.on.is_some()
    }

    fn needs_origin(&self, part: &Scene) -> bool {
        self.has_origin() && [&part.joints, &part.drivers, &part.loads].iter().any(|parts| !parts.is_empty())
    }

    /// Its sign with the part's mirror.
    pub fn signed(&self, operand: Operand) -> Operand {
        if self.used.mirror { operand.negated() } else { operand }
    }

    /// R F v
    pub fn direction(&self, [x, y]: [Operand; 2]) -> [Operand; 2] {
        let x = self.signed(x);
        let Some(angle) = &self.angle else { return [x, y] };
        let (sine, cosine) = (angle.of_function("sin"), angle.of_function("cos"));
        [
            cosine.clone().times(x.clone()).plus(sine.clone().times(y.clone()).negated()),
            sine.times(x).plus(cosine.times(y)),
        ]
    }

    /// at + R F v
    pub fn world(&self, place: [Operand; 2]) -> [Operand; 2] {
        let [x, y] = self.direction(place);
        match self.at.clone() {
            Some([at_x, at_y]) => [at_x.plus(x), at_y.plus(y)],
            None => [x, y],
        }
    }

    fn point(&self, at: &Vector) -> Vector {
        self.vector(at, &LENGTH, |placing, place| placing.world(place))
    }

    /// A vector of two components by a map; as it is if it is no such vector.
    fn vector(&self, vector: &Vector, wanted: &Wanted, map: impl Fn(&Self, [Operand; 2]) -> [Operand; 2]) -> Vector {
        let [x, y] = &vector.components[..] else { return vector.clone() };
        let (Some(a), Some(b)) = (Operand::of(x, wanted), Operand::of(y, wanted)) else { return vector.clone() };
        let [a, b] = map(self, [a, b]);
        Vector { components: vec![a.at(x.span), b.at(y.span)], span: vector.span }
    }

    /// Initial values of the part as values of the scene.
    fn initial(&mut self, values: &mut [Initial]) {
        if !self.is_moved() {
            return;
        }
        let before = values.to_vec();
        for value in values {
            let Some((owner, word)) = value.variable.text.rsplit_once('.') else { continue };
            let of_body = self.bodies.iter().any(|body| owner.split('.').next() == Some(body));
            if of_body && self.on.is_some() && value.known {
                self.refuse(
                    &format!("the initial value of `{}`", value.variable.text),
                    value.value.span,
                    "its angle and place against the body are not known; give a guess, or the value of a joint",
                );
                continue;
            }
            let place = |word: &str| {
                let name = format!("{owner}.{word}");
                let found = before.iter().find(|other| other.variable.text == name && other.known == value.known);
                Operand::of(&found?.value, &crate::mechanism::measure::ANYTHING)
            };
            let placed = match word {
                "angle" => self.angle_of(owner, of_body, &value.value),
                "omega" => Operand::of(&value.value, &crate::mechanism::measure::ANGULAR_VELOCITY)
                    .map(|omega| self.signed(omega)),
                "x" | "y" if of_body => self.component(word == "y", [place("x"), place("y")], Self::world),
                "vx" | "vy" if of_body => self.component(word == "vy", [place("vx"), place("vy")], Self::direction),
                _ => continue,
            };
            match placed {
                Some(placed) => value.value = placed.at(value.value.span),
                None => self.refuse(
                    &format!("the initial value of `{}`", value.variable.text),
                    value.value.span,
                    "give both components, x and y",
                ),
            }
        }
    }

    /// One component of a place or a velocity, of which the other may be unknown unless the part is turned.
    fn component(
        &self,
        second: bool,
        [x, y]: [Option<Operand>; 2],
        map: impl Fn(&Self, [Operand; 2]) -> [Operand; 2],
    ) -> Option<Operand> {
        let zero = self.angle.is_none().then_some(Operand::Number(0.0));
        let [x, y] = map(self, [x.or(zero.clone())?, y.or(zero)?]);
        Some(if second { y } else { x })
    }

    fn angle_of(&self, owner: &str, of_body: bool, value: &Quantity) -> Option<Operand> {
        let angle = self.signed(Operand::of(value, &ANGLE)?);
        let turned = if of_body { self.angle.clone() } else { self.turned.get(owner).cloned().flatten() };
        Some(match turned {
            Some(turned) => turned.plus(angle),
            None => angle,
        })
    }

    /// Makes the points of the part's ground points of a body.
    fn fix(&mut self, part: &mut Scene, host: &mut Scene, on: &Text) {
        let bodies = host.bodies.iter_mut().chain(&mut part.bodies);
        let Some(body) = bodies.into_iter().find(|body| body.name.text == on.text) else {
            if !host.broken.contains(&on.text) {
                let message =
                    format!("part `{}` is on a body that is not in the scene: `{}`", self.used.name.text, on.text);
                let fault = Fault::new("scene::unknown_body", message, on.span).label("no such body");
                self.faults.push(fault.help("name a body of this scene, or of a part that stands before this one"));
            }
            return;
        };
        for point in part.ground.drain(..) {
            body.add_point(point.name, point.at);
        }
        renamed::with_ground(part, &on.text);
    }

    /// Says that something in the file of the part depends on its place in a way that is not known.
    pub fn refuse(&mut self, what: &str, span: Span, help: &str) {
        let part = &self.used.name.text;
        let message = format!("part `{part}` is mirrored, turned, moved or on a body, which does not go with {what}");
        let mut fault = Fault::new("scene::placed_part", message, span).label("depends on the place").help(help);
        fault.also.push(self.used.name.span);
        self.faults.push(fault);
    }

    /// A quantity in a tree of values by a map of operands.
    pub fn change(node: &mut Node, wanted: &Wanted, map: impl FnOnce(Operand) -> Operand) {
        let value = match &node.kind {
            Kind::Number(number) => Quantity::from(*number),
            Kind::Text(text) => Quantity::from(text.as_str()),
            _ => return,
        };
        if let Some(operand) = Operand::of(&value, wanted) {
            *node = Node::from(map(operand).at(node.span));
        }
    }

    /// Two quantities in a list likewise.
    pub fn change_both(node: &mut Node, wanted: &Wanted, map: impl FnOnce([Operand; 2]) -> [Operand; 2]) {
        let Kind::Array(items) = &mut node.kind else { return };
        let [x, y] = &mut items[..] else { return };
        let operand = |node: &Node| match &node.kind {
            Kind::Number(number) => Some(Operand::Number(*number)),
            Kind::Text(text) => Operand::of(&Quantity::from(text.as_str()), wanted),
            _ => None,
        };
        let (Some(a), Some(b)) = (operand(x), operand(y)) else { return };
        let [a, b] = map([a, b]);
        (*x, *y) = (Node::from(a.at(x.span)), Node::from(b.at(y.span)));
    }
}
