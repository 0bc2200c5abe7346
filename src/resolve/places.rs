//! Points and bodies that elements refer to.

use super::Resolver;
use super::names::Named;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::diagnostic::suggest;
use crate::model::{BodyId, Place};

impl Resolver<'_> {
    /// A point: `ground`, `ground.bearing`, `rod`, `rod.big_end`. `user` is who refers to it.
    pub(super) fn place(&mut self, name: &Text, user: &str) -> Option<Place> {
        let (owner, point) = match name.text.split_once('.') {
            Some((owner, point)) => (owner, Some(point)),
            None => (name.text.as_str(), None),
        };
        let points = if owner == "ground" {
            &self.names.ground
        } else {
            let body = self.body_of(owner, name, user)?;
            &self.names.points[body.0]
        };
        let body = self.names.get(owner);
        match (point.map(|point| points.get(point)), body) {
            (None, Some(Named::Body(body))) => Some(Place::Centre(body)),
            (None, _) => Some(self.frame().origin),
            (Some(Some(&index)), Some(Named::Body(body))) => Some(Place::Point(body, index)),
            (Some(Some(&index)), _) => {
                self.used_ground.insert(index);
                Some(Place::Ground(index))
            }
            (Some(None), _) => {
                self.unknown_point(name, owner, point.unwrap_or_default(), user);
                None
            }
        }
    }

    /// A point, without a word if there is none.
    pub(super) fn known_place(&self, name: &str) -> Option<Place> {
        let (owner, point) = name.split_once('.').map_or((name, None), |(owner, point)| (owner, Some(point)));
        match (owner, self.names.get(owner), point) {
            ("ground", _, None) => Some(self.frame().origin),
            ("ground", _, Some(point)) => self.names.ground.get(point).map(|&index| Place::Ground(index)),
            (_, Some(Named::Body(body)), None) => Some(Place::Centre(body)),
            (_, Some(Named::Body(body)), Some(point)) => {
                self.names.points[body.0].get(point).map(|&index| Place::Point(body, index))
            }
            _ => None,
        }
    }

    fn unknown_point(&mut self, name: &Text, owner: &str, point: &str, user: &str) {
        if self.is_reported(name, &name.text) {
            return;
        }
        let map = match self.names.get(owner) {
            Some(Named::Body(body)) => &self.names.points[body.0],
            _ => &self.names.ground,
        };
        let mut points: Vec<&str> = map.keys().copied().collect();
        points.sort_unstable();
        let whose = if owner == "ground" { "the ground".to_string() } else { format!("body `{owner}`") };
        let has = match points.len() {
            0 => format!(
                "{whose} has no points; its bare name `{owner}` is its {}",
                if owner == "ground" { "origin" } else { "mass centre" }
            ),
            1 => format!("{whose} has the point {}", suggest::list(points.iter().copied())),
            _ => format!("{whose} has the points {}", suggest::list(points.iter().copied())),
        };
        let near = suggest::nearest(point, points.iter().copied());
        let help = near.map_or(has.clone(), |near| format!("did you mean `{owner}.{near}`? {has}"));
        let message = format!("{user} uses a point that is not in the scene: `{}`", name.text);
        self.faults.push_about(
            &name.text,
            Fault::new("scene::unknown_point", message, name.span).label("no such point").help(help),
        );
    }

    /// The body with a name that is not `ground`.
    fn body_of(&mut self, body: &str, name: &Text, user: &str) -> Option<BodyId> {
        let named = self.names.get(body);
        if let Some(Named::Body(id)) = named {
            return Some(id);
        }
        if self.is_reported(name, body) {
            return None;
        }
        let bodies = self.names.all(|named| matches!(named, Named::Body(_)));
        let span = name.part(0, body.len());
        let fault = match named {
            Some(other) => {
                let message = format!("{user} uses `{body}` as a body, but it is a {}", other.word());
                Fault::new("scene::unknown_body", message, span).label(format!("a {}", other.word()))
            }
            None => {
                let message = format!("{user} uses a body that is not in the scene: `{body}`");
                Fault::new("scene::unknown_body", message, span).label("no such body")
            }
        };
        let otherwise = match bodies.is_empty() {
            true => format!("the scene has no bodies; give one as `[bodies.{body}]`"),
            false => format!("the bodies are {}; `ground` is always there", suggest::list(bodies.iter().copied())),
        };
        let help = suggest::hint(body, bodies.iter().copied().chain(["ground"]), otherwise);
        self.faults.push_about(body, fault.help(help));
        None
    }

    /// A whole body; the outer `None` is a fault, the inner the ground.
    pub(super) fn body(&mut self, name: &Text, user: &str) -> Option<Option<BodyId>> {
        let (owner, point) = name.text.split_once('.').unwrap_or((&name.text, ""));
        let body = if owner == "ground" { self.frame().on } else { Some(self.body_of(owner, name, user)?) };
        if !point.is_empty() {
            self.faults.push(
                Fault::new(
                    "scene::not_a_body",
                    format!("{user} connects bodies, but `{}` is a point", name.text),
                    name.span,
                )
                .label("a point")
                .help(format!("write `{owner}`")),
            );
            return None;
        }
        Some(body)
    }

    pub(super) fn places(&mut self, between: &[Text; 2], user: &str) -> Option<[Place; 2]> {
        let (first, second) = (self.place(&between[0], user), self.place(&between[1], user));
        let (first, second) = (first?, second?);
        self.different(first.body(), second.body(), between, user)?;
        Some([first, second])
    }

    pub(super) fn body_pair(&mut self, between: &[Text; 2], user: &str) -> Option<[Option<BodyId>; 2]> {
        let (first, second) = (self.body(&between[0], user), self.body(&between[1], user));
        let (first, second) = (first?, second?);
        self.different(first, second, between, user)?;
        Some([first, second])
    }

    pub(super) fn different(
        &mut self,
        a: Option<BodyId>,
        b: Option<BodyId>,
        between: &[Text; 2],
        user: &str,
    ) -> Option<()> {
        if a != b {
            return Some(());
        }
        let whom = match a {
            Some(body) => format!("body `{}`", self.scene.bodies[body.0].name.text),
            None => "the ground".to_string(),
        };
        let span = if between[0].span.is_nowhere() {
            between[1].span
        } else {
            Span::new(between[0].span.start, between[1].span.end.max(between[0].span.end))
        };
        self.faults.push(
            Fault::new("scene::self_connection", format!("{user} connects {whom} to itself"), span)
                .label("both are the same body")
                .help("name two different bodies, or `ground`"),
        );
        None
    }

    pub(super) fn moving_place(&mut self, name: &Text, user: &str) -> Option<Place> {
        let place = self.place(name, user)?;
        if place.body().is_none() {
            self.faults.push(
                Fault::new("scene::on_ground", format!("{user} acts on the ground, where it has no effect"), name.span)
                    .label("the ground")
                    .help("name a body or a point of a body"),
            );
            return None;
        }
        Some(place)
    }
}
