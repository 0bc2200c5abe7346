//! Contacts of planes of the world with spheres, capsules, boxes and cylinders, and of spheres with each other.

use super::MjcfReader;
use crate::import::options::ContactChoice;
use crate::import::refusal::Fallible;
use crate::import::robot::{Solid, SolidShape};
use crate::import::xml::XmlElement;

/// Pairs of more geoms than these are not counted.
const MANY: usize = 1000;

/// A geom as far as contacts ask.
#[derive(Clone, Debug)]
pub struct ContactGeom {
    pub solid: Solid,
    pub contype: i64,
    pub conaffinity: i64,
    pub condim: i64,
    pub priority: i64,
    pub friction: f64,
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
                let known = self.geoms.iter().position(|geom| geom.solid.name == name);
                known.ok_or_else(|| element.refuse(format!("{}: there is no geom `{name}`", element.called())))
            };
            let (first, second) = (find(names[0])?, find(names[1])?);
            let given = friction.and_then(|friction| friction.first().copied());
            let mu = given.unwrap_or(self.geoms[first].friction.max(self.geoms[second].friction));
            self.touch(first, second, if condim == 1.0 { 0.0 } else { mu });
        }
        // Of very many geoms only those that are imported are looked at.
        let all = self.geoms.len() <= MANY;
        let plane = |index: usize, this: &Self| this.geoms[index].solid.shape == SolidShape::Plane;
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

    /// The friction of two geoms that may touch: filtered by their types, by bodies that are one, by parents and exclusions.
    fn friction_of(&self, first: usize, second: usize, excluded: &[[&str; 2]]) -> Option<f64> {
        let (a, b) = (&self.geoms[first], &self.geoms[second]);
        let [one, other] = [a, b].map(|geom| self.model.mover(geom.solid.body));
        let parent = |body: usize| self.model.mover(self.model.bodies[body].parent);
        let related = one != 0 && other != 0 && (parent(one) == other || parent(other) == one);
        let names = [a, b].map(|geom| self.model.bodies[geom.solid.body].name.as_str());
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
        let [a, b] = [first, second].map(|geom| self.geoms[geom].solid.clone());
        self.model.touch([&a, &b], friction, self.report);
    }
}
