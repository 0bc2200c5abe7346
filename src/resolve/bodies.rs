//! Gravity, the ground and the bodies.

use super::Resolver;
use super::lower::Context;
use crate::diagnostic::fault::Fault;
use crate::mechanism::{BinaryOperator, Body, Formula, Point};
use crate::scene::constant;
use crate::scene::dimension::{ACCELERATION, INERTIA, LENGTH, MASS};
use crate::scene::model;

impl Resolver<'_> {
    pub(super) fn gravity(&mut self) -> [Formula; 2] {
        match &self.scene.gravity {
            Some(gravity) => self.vector(gravity, "`gravity`", &ACCELERATION, Context::Constant),
            None => [Formula::Number(0.0), Formula::Number(0.0)],
        }
    }

    pub(super) fn ground(&mut self) -> Vec<Point> {
        let origin = [Formula::Number(0.0), Formula::Number(0.0)];
        self.points(&self.scene.ground, "ground", &origin)
    }

    pub(super) fn bodies(&mut self) -> Vec<Body> {
        let scene = self.scene;
        if scene.bodies.is_empty() && scene.broken.is_empty() {
            self.faults.push(
                Fault::new("scene::no_bodies", "the scene has no bodies", scene.name.span)
                    .help("give at least one: `[bodies.crank]` with `mass`, `inertia` and `points`"),
            );
        }
        scene.bodies.iter().map(|body| self.one_body(body)).collect()
    }

    fn one_body(&mut self, body: &model::Body) -> Body {
        let name = &body.name.text;
        let mass = body.mass.as_ref().map(|mass| self.not_negative(mass, &format!("`mass` of body `{name}`"), &MASS));
        let inertia = body
            .inertia
            .as_ref()
            .map(|inertia| self.not_negative(inertia, &format!("`inertia` of body `{name}`"), &INERTIA));
        if let (true, Some(given)) = (self.one_dimensional(), &body.inertia) {
            self.faults.push(
                Fault::warning(
                    "scene::unused",
                    format!("`inertia` of body `{name}` has no effect in one dimension"),
                    given.span,
                )
                .label("nothing turns")
                .help("remove it"),
            );
        }
        let centre = match &body.com {
            Some(com) => self.vector(com, &format!("`com` of body `{name}`"), &LENGTH, Context::Constant),
            None => [Formula::Number(0.0), Formula::Number(0.0)],
        };
        let points = self.points(&body.points, name, &centre);
        Body { name: name.clone(), mass, inertia, weightless: body.weightless, points, span: body.name.span }
    }

    fn points(&mut self, points: &[model::Point], owner: &str, centre: &[Formula; 2]) -> Vec<Point> {
        points
            .iter()
            .map(|point| {
                let what = format!("point `{owner}.{}`", point.name.text);
                let [x, y] = self.vector(&point.at, &what, &LENGTH, Context::Constant);
                let from = |at, centre: &Formula| constant::combine(BinaryOperator::Subtract, at, centre.clone());
                let at = [from(x, &centre[0]), from(y, &centre[1])];
                Point { name: point.name.text.clone(), at, span: point.name.span }
            })
            .collect()
    }
}
