//! Contacts of planes of the world with spheres, capsules, boxes and cylinders, and of spheres with each other.

use nalgebra::{Isometry3, Point3, Vector3};

use super::MjcfReader;
use super::geometry::GeomShape;
use crate::import::options::ContactChoice;
use crate::import::refusal::Fallible;
use crate::import::robot::{BodyPoint, ContactKind, ContactShape, SpatialContact};
use crate::import::xml::XmlElement;

/// Pairs of more geoms than these are not counted.
const MANY: usize = 1000;

/// A geom as far as contacts ask.
#[derive(Clone, Debug)]
pub struct ContactGeom {
    pub name: String,
    pub body: usize,
    pub shape: GeomShape,
    /// In the frame of its body.
    pub pose: Isometry3<f64>,
    pub contype: i64,
    pub conaffinity: i64,
    pub condim: i64,
    pub priority: i64,
    pub friction: f64,
}

impl ContactGeom {
    /// How it touches a plane; none of what has no corners and discs.
    fn shape(&self) -> Option<ContactShape> {
        let at = |x: f64, y: f64, z: f64| self.pose * Point3::new(x, y, z);
        Some(match self.shape {
            GeomShape::Sphere(radius) => ContactShape::Balls(vec![at(0.0, 0.0, 0.0)], radius),
            GeomShape::Capsule(radius, half) => {
                ContactShape::Balls([-half, half].map(|z| at(0.0, 0.0, z)).to_vec(), radius)
            }
            GeomShape::Box([a, b, c]) => {
                let corners = (0..8).map(|bits| [1, 2, 4].map(|bit| if bits & bit == 0 { -1.0 } else { 1.0 }));
                ContactShape::Corners(corners.map(|[x, y, z]| at(a * x, b * y, c * z)).collect())
            }
            GeomShape::Cylinder(radius, half) => ContactShape::Cylinder { pose: self.pose, radius, half },
            GeomShape::Plane | GeomShape::Ellipsoid(_) | GeomShape::File => return None,
        })
    }
}

impl<'a> MjcfReader<'a> {
    pub fn contacts(&mut self, root: &'a XmlElement) -> Fallible<()> {
        let (mut excluded, mut pairs) = (Vec::new(), Vec::new());
        for section in root.all("contact") {
            for element in section.all("exclude") {
                excluded.push([element.must("body1")?, element.must("body2")?]);
            }
            for element in section.all("pair") {
                let resolved = self.defaults.of(element, "pair", None)?;
                let geoms = [element.must("geom1")?, element.must("geom2")?];
                let condim = resolved.number("condim", 3.0)?;
                pairs.push((
                    geoms,
                    resolved.attribute("friction").map(|attribute| attribute.numbers()).transpose()?,
                    condim,
                    element,
                ));
            }
        }
        if !self.enabled.contact || self.options.contacts == ContactChoice::None {
            return Ok(());
        }
        for (names, friction, condim, element) in pairs {
            let find = |name: &str| {
                let known = self.geoms.iter().position(|geom| geom.name == name);
                known.ok_or_else(|| element.refuse(format!("{}: there is no geom `{name}`", element.called())))
            };
            let (first, second) = (find(names[0])?, find(names[1])?);
            let given = friction.and_then(|friction| friction.first().copied());
            let mu = given.unwrap_or(self.geoms[first].friction.max(self.geoms[second].friction));
            self.touch(first, second, if condim == 1.0 { 0.0 } else { mu });
        }
        // Of very many geoms only those that are imported are looked at.
        let all = self.geoms.len() <= MANY;
        let plane = |index: usize, this: &Self| this.geoms[index].shape == GeomShape::Plane;
        for first in 0..self.geoms.len() {
            if !all && !plane(first, self) {
                continue;
            }
            for second in 0..self.geoms.len() {
                let twice = second == first || second < first && (all || plane(second, self));
                if twice {
                    continue;
                }
                if let Some(friction) = self.friction_of(first, second, &excluded) {
                    self.touch(first, second, friction);
                }
            }
        }
        Ok(())
    }

    /// The body that a body is fixed to.
    fn mover(&self, body: usize) -> usize {
        let body_data = &self.model.bodies[body];
        if body == 0 || !body_data.joints.is_empty() { body } else { self.mover(body_data.parent) }
    }

    /// The friction of two geoms that may touch: filtered by their types, by bodies that are one, by parents and exclusions.
    fn friction_of(&self, first: usize, second: usize, excluded: &[[&str; 2]]) -> Option<f64> {
        let (a, b) = (&self.geoms[first], &self.geoms[second]);
        let [one, other] = [a, b].map(|geom| self.mover(geom.body));
        let parent = |body: usize| self.mover(self.model.bodies[body].parent);
        let related = one != 0 && other != 0 && (parent(one) == other || parent(other) == one);
        let names = [a, b].map(|geom| self.model.bodies[geom.body].name.as_str());
        let is_excluded = excluded.iter().any(|pair| *pair == names || *pair == [names[1], names[0]]);
        let meets = a.contype & b.conaffinity != 0 || b.contype & a.conaffinity != 0;
        if one == other || related || is_excluded || !meets {
            return None;
        }
        let friction = match a.priority.cmp(&b.priority) {
            std::cmp::Ordering::Equal if a.condim.max(b.condim) == 1 => 0.0,
            std::cmp::Ordering::Equal => a.friction.max(b.friction),
            std::cmp::Ordering::Greater => {
                if a.condim == 1 {
                    0.0
                } else {
                    a.friction
                }
            }
            std::cmp::Ordering::Less => {
                if b.condim == 1 {
                    0.0
                } else {
                    b.friction
                }
            }
        };
        Some(friction)
    }

    /// A contact for each point that may touch.
    fn touch(&mut self, first: usize, second: usize, friction: f64) {
        let (a, b) = (self.geoms[first].clone(), self.geoms[second].clone());
        let (a, b) = if b.shape == GeomShape::Plane { (b, a) } else { (a, b) };
        let called = |geom: &ContactGeom| match geom.name.is_empty() {
            true => format!("{}_geom", self.model.bodies[geom.body].name),
            false => geom.name.clone(),
        };
        let name = format!("{}_{}", called(&a), called(&b));
        if a.shape == GeomShape::Plane {
            let pose = self.world(a.body) * a.pose;
            let (at, normal) = (Point3::from(pose.translation.vector), pose * Vector3::z());
            match b.shape() {
                Some(shape) => {
                    let kind = ContactKind::Plane { at, normal, body: b.body, shape };
                    self.model.contacts.push(SpatialContact { name, kind, friction });
                }
                None => self.report.missing("contact of a plane with an ellipsoid or a mesh", &name),
            }
            return;
        }
        if let (GeomShape::Sphere(r), GeomShape::Sphere(s)) = (a.shape, b.shape) {
            let centre =
                |geom: &ContactGeom| BodyPoint { body: geom.body, at: Point3::from(geom.pose.translation.vector) };
            let kind = ContactKind::Balls([centre(&a), centre(&b)], [r, s]);
            self.model.contacts.push(SpatialContact { name, kind, friction });
            return;
        }
        self.report.missing("contact of two bodies other than planes and spheres", &name);
    }
}
