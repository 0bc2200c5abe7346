//! Where a part is: its left and right exchanged, turned, moved, and fixed to a body, in this order. A place p of the part is at + R(angle) F p in
//! the frame of that body, with F = diag(-1, 1) if it is mirrored; its bodies then have the angles angle + s theta, s = -1 if mirrored.

use std::collections::HashMap;

use super::renamed;
use crate::component::{Frame, sum, within_a_turn};
use crate::diagnostic::fault::{Fault, Sink};
use crate::diagnostic::span::{Span, Text};
use crate::mechanism::Dimension;
use crate::mechanism::measure::{ANGLE, ANGULAR_VELOCITY, ANYTHING, LENGTH};
use crate::scene::model::{Initial, Point, Scene, Use, Vector};
use crate::scene::operand::Operand;
use crate::scene::quantity::Quantity;

/// A part that is being placed.
pub(super) struct Placing<'a> {
    pub used: &'a Use,
    pub faults: &'a mut Sink,
    /// The body that its ground is fixed to, if that is not the ground.
    pub on: Option<&'a Text>,
    pub frame: Frame<'a>,
    /// What is added to the own angle of each element, and whether that is an angle within a turn.
    pub turned: HashMap<String, (Option<Operand>, bool)>,
    /// The names of its bodies.
    pub bodies: Vec<String>,
}

/// Puts a part where the scene that uses it wants it.
pub(super) fn place(used: &Use, faults: &mut Sink, part: &mut Scene, host: &mut Scene) {
    let (at, angle) = (origin(used, faults), angle(used, faults));
    let on = used.on.as_ref().filter(|on| on.text != "ground");
    if at.is_none() && angle.is_none() && !used.mirror && on.is_none() {
        return;
    }
    if part.dimension == Dimension::One {
        let message = format!("part `{}` cannot be placed on a line", used.name.text);
        let fault = Fault::new("scene::one_dimension", message, used.name.span).label("not with `dimension = 1`");
        faults.push(fault.help("give the places as parameters of the part"));
        return;
    }
    let joints = part.joints.clone();
    let frame = Frame { mirror: used.mirror, angle, at, on_body: on.is_some(), joints: &joints };
    let bodies = part.bodies.iter().map(|body| body.name.text.clone()).collect();
    Placing { used, faults, on, frame, turned: HashMap::new(), bodies }.place(part, host);
}

fn origin(used: &Use, faults: &mut Sink) -> Option<[Operand; 2]> {
    let written = used.at.as_ref()?;
    let component = |axis: usize| Operand::of(written.components.get(axis)?, &LENGTH);
    let at = component(0).zip(component(1)).map(|(x, y)| [x, y]);
    if at.is_none() {
        let fault = Fault::new("scene::wrong_value", "`at` of a part is no place", written.span);
        faults.push(fault.label("two lengths are wanted").help("such as `at = [\"0.5 m\", 0]`"));
    }
    at
}

fn angle(used: &Use, faults: &mut Sink) -> Option<Operand> {
    let written = used.angle.as_ref()?;
    let angle = Operand::of(written, &ANGLE);
    if angle.is_none() {
        let fault = Fault::new("scene::wrong_unit", "`angle` of a part is no angle", written.span);
        faults.push(fault.label("not an angle").help("such as `angle = \"30 deg\"`"));
    }
    angle
}

impl Placing<'_> {
    fn place(mut self, part: &mut Scene, host: &mut Scene) {
        for point in &mut part.ground {
            point.at = self.point(&point.at);
        }
        if self.needs_origin(part) {
            let zero = || Operand::Number(0.0).at(Span::default());
            let at = self.point(&Vector { components: vec![zero(), zero()], span: Span::default() });
            part.ground.push(Point { name: Text::from(self.origin_name()), at });
        }
        self.elements(part);
        if self.frame.mirror {
            part.bodies.iter_mut().for_each(|body| self.mirror_body(body));
        }
        self.initial(&mut part.initial);
        self.begin(part);
        if let Some(on) = self.on {
            self.fix(part, host, on);
        }
    }

    /// Is it elsewhere than its own ground says?
    pub fn is_moved(&self) -> bool {
        self.frame.at.is_some() || self.frame.angle.is_some() || self.frame.mirror
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
        self.frame.at.is_some() || self.on.is_some()
    }

    fn needs_origin(&self, part: &Scene) -> bool {
        self.has_origin() && [&part.joints, &part.drivers, &part.loads].iter().any(|parts| !parts.is_empty())
    }

    /// A point of the part's ground; as it is if it is no such vector.
    fn point(&self, at: &Vector) -> Vector {
        let [x, y] = &at.components[..] else { return at.clone() };
        let (Some(a), Some(b)) = (Operand::of(x, &LENGTH), Operand::of(y, &LENGTH)) else { return at.clone() };
        let [a, b] = self.frame.place([a, b]);
        Vector { components: vec![a.at(x.span), b.at(y.span)], span: at.span }
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
                Operand::of(&found?.value, &ANYTHING)
            };
            let placed = match word {
                "angle" => self.angle_of(owner, of_body, &value.value),
                "omega" => Operand::of(&value.value, &ANGULAR_VELOCITY).map(|omega| self.frame.signed(omega)),
                "x" | "y" if of_body => {
                    self.component(word == "y", [place("x"), place("y")], |at| self.frame.place(at))
                }
                "vx" | "vy" if of_body => {
                    self.component(word == "vy", [place("vx"), place("vy")], |velocity| self.frame.direction(velocity))
                }
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

    /// What nobody gives begins at zero, as the part sees it.
    fn begin(&mut self, part: &mut Scene) {
        let is_known = |name: &str| part.begins.iter().any(|begin| begin.variable.text == name);
        let names = self.bodies.iter().flat_map(|body| ["x", "y", "angle"].map(|word| format!("{body}.{word}")));
        let zero = |name: String| Initial { variable: Text::from(name), value: Quantity::from(0.0), known: false };
        let more: Vec<Initial> = names.filter(|name| !is_known(name)).map(zero).collect();
        part.begins.extend(more);
        self.initial(&mut part.begins);
    }

    /// One component of a place or a velocity, of which the other may be unknown unless the part is turned.
    fn component(
        &self,
        second: bool,
        [x, y]: [Option<Operand>; 2],
        map: impl Fn([Operand; 2]) -> [Operand; 2],
    ) -> Option<Operand> {
        let zero = self.frame.angle.is_none().then_some(Operand::Number(0.0));
        let [x, y] = map([x.or(zero.clone())?, y.or(zero)?]);
        Some(if second { y } else { x })
    }

    fn angle_of(&self, owner: &str, of_body: bool, value: &Quantity) -> Option<Operand> {
        let angle = self.frame.signed(Operand::of(value, &ANGLE)?);
        let (turned, within) = match of_body {
            true => (self.frame.angle.clone(), false),
            false => self.turned.get(owner).cloned().unwrap_or_default(),
        };
        let angle = sum(angle, turned);
        Some(if within { Operand::Text(within_a_turn(&angle.text())) } else { angle })
    }

    /// Makes the points of the part's ground points of a body.
    fn fix(&mut self, part: &mut Scene, host: &mut Scene, on: &Text) {
        let Some(body) = host.bodies.iter_mut().find(|body| body.name.text == on.text) else {
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
}
