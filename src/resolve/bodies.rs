//! Gravity, the ground and the bodies.

use super::context::Context;
use super::parts::KeyReader;
use super::{Resolver, UNKNOWN};
use crate::component::body::KEYS;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::model::measure::{ACCELERATION, LENGTH};
use crate::model::{Body, Formula, KeyValue, Point};
use crate::scene::decode::Fields;
use crate::scene::key::names;
use crate::scene::model as written;
use crate::scene::part::Part;

/// The origin of a body or of the ground.
const ORIGIN: [Formula; 2] = [Formula::Number(0.0), Formula::Number(0.0)];

impl Resolver<'_> {
    pub(super) fn gravity(&mut self) -> [Formula; 2] {
        match &self.scene.gravity {
            Some(gravity) => {
                let vector = self.vector(gravity, "`gravity`", &ACCELERATION, Context::Constant);
                self.suspect_upwards(&vector, gravity.span);
                vector
            }
            None => ORIGIN,
        }
    }

    /// Warns of gravity that acts upwards, as the sign of y is in the scene's pictures and pages.
    fn suspect_upwards(&mut self, [x, y]: &[Formula; 2], span: Span) {
        let [across, up] = [x, y].map(|part| self.value(part));
        if up > 0.0 && across == 0.0 {
            let fault = Fault::warning("scene::upwards", format!("gravity acts upwards: y is {up} m/s2"), span);
            self.faults.push(fault.label("along y").help(format!("write `[0, {}]`", -up)));
        }
    }

    pub(super) fn ground(&mut self) -> Vec<Point> {
        let scene = self.scene;
        let resolve = |point: &written::Point| {
            let what = format!("point `ground.{}`", point.name.text);
            let at = self.vector(&point.at, &what, &LENGTH, Context::Constant);
            let at = self.placements[point.within].frame.place(at);
            Point { name: point.name.text.clone(), at, span: point.name.span }
        };
        scene.ground.iter().map(resolve).collect()
    }

    pub(super) fn bodies(&mut self) -> Vec<Body> {
        let scene = self.scene;
        if scene.bodies.is_empty() && scene.broken.is_empty() {
            self.faults.push(
                Fault::new("scene::no_bodies", "the scene has no bodies", scene.name.span)
                    .help("give at least one: `[bodies.NAME]` with `mass`, `inertia` and `points`"),
            );
        }
        scene.bodies.iter().map(|body| self.within(body.within, |resolver| resolver.body_of_part(body))).collect()
    }

    fn body_of_part(&mut self, written: &Part) -> Body {
        let (name, span) = (written.name.text.clone(), written.name.span);
        let (called, frame) = (format!("body `{name}`"), self.frame());
        let mut body = Body { name, points: self.points_of(written), span, ..Body::default() };
        let Some(fields) = Fields::open(&written.node, &called, span, &names(KEYS), self.faults) else {
            body.mass = Some(UNKNOWN);
            return body;
        };
        if let Some(points) = fields.get("points") {
            self.faults.points(points, &fields.name_of("points"));
        }
        let mut centre = None;
        let reader = KeyReader { fields: &fields, user: &called, context: Context::Constant };
        for key in KEYS {
            match fields.get(key.name).and_then(|node| self.value_of(key, node, &reader)) {
                Some(KeyValue::Formula(mass)) if key.name == "mass" => body.mass = Some(mass),
                Some(KeyValue::Formula(inertia)) => body.inertia = Some(inertia),
                Some(KeyValue::Vector(at)) => centre = Some(at),
                Some(KeyValue::Switch(gravity)) => body.weightless = !gravity,
                _ => {}
            }
        }
        if let (true, Some(given)) = (self.one_dimensional(), fields.get("inertia")) {
            self.without_effect("`inertia`", &called, "in one dimension", given.span);
        }
        let shape = fields.get("shape").and_then(|node| self.shape(node, &fields, &body, centre.is_some()));
        let outline = fields.get("outline").and_then(|node| self.outline_of_body(node, &fields, &body));
        let solid_centre = shape.as_ref().map(|shape| shape.solid.centre.clone());
        let mirrored = |at| frame.mirrored(at);
        let centre = mirrored(centre.or(solid_centre).unwrap_or(ORIGIN));
        let from_centre = |[x, y]: [Formula; 2]| [x - centre[0].clone(), y - centre[1].clone()];
        if shape.is_none() && fields.get("shape").is_some() {
            body.mass = body.mass.or(Some(UNKNOWN));
        }
        if let Some(shape) = shape {
            body.mass = body.mass.or(shape.mass);
            let turning = body.mass.clone().map(|mass| mass * shape.solid.gyration);
            body.inertia = body.inertia.or(turning);
            body.outline = Some(shape.solid.outline.map(|at| from_centre(mirrored(at))));
        }
        if let Some(outline) = outline {
            body.outline = Some(outline.map(|at| from_centre(mirrored(at))));
        }
        for point in &mut body.points {
            point.at = from_centre(mirrored(std::mem::replace(&mut point.at, ORIGIN)));
        }
        body
    }

    /// The points of a body in the frame in which they are written.
    fn points_of(&mut self, body: &Part) -> Vec<Point> {
        let entries = body.entries("points");
        let point = |(name, node): &(Text, _)| {
            let what = format!("point `{}.{}`", body.name.text, name.text);
            let written = self.faults.vector(node, &what);
            let at = written.map(|at| self.vector(&at, &what, &LENGTH, Context::Constant));
            let at = at.unwrap_or([UNKNOWN, UNKNOWN]);
            let at = match body.carried.iter().find(|(carried, _)| *carried == name.text) {
                // All points of the body are mirrored when its shape is known.
                Some((_, part)) => self.frame().mirrored(self.placements[*part].frame.place(at)),
                None => at,
            };
            Point { name: name.text.clone(), at, span: name.span }
        };
        entries.iter().map(point).collect()
    }

    /// Warns of a key that changes nothing.
    pub(super) fn without_effect(&mut self, key: &str, user: &str, why: &str, span: Span) {
        let message = format!("{key} of {user} has no effect {why}");
        let label = if why == "in one dimension" { "nothing turns" } else { "not used" };
        self.faults.push(Fault::warning("scene::unused", message, span).label(label).help("remove it"));
    }
}
