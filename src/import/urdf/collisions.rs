//! Collisions of URDF as contacts. The format has no floor; planes are an extension of Bullet.

use nalgebra::Isometry3;

use super::{UrdfReader, optional, origin};
use crate::import::options::ContactChoice;
use crate::import::refusal::Fallible;
use crate::import::robot::{FRICTION, Solid, SolidShape, across};
use crate::import::xml::{self, XmlElement};

impl<'a> UrdfReader<'a> {
    /// A contact for each pair of solids that may touch: not those of links that a joint joins.
    pub fn collisions(&mut self) -> Fallible<()> {
        if self.options.contacts == ContactChoice::None {
            return Ok(());
        }
        let mut all = Vec::new();
        for link in self.root.all("link") {
            let name = link.must("name")?;
            let Some(&body) = self.bodies.get(name) else { continue };
            let friction = self.friction(link, name)?;
            for collision in link.all("collision") {
                let Some((shape, pose)) = shape(collision)? else { continue };
                let called =
                    collision.get("name").map_or_else(|| format!("{name}_collision"), |part| format!("{name}_{part}"));
                let surface =
                    collision.child("drake:proximity_properties").and_then(|list| list.child("drake:mu_dynamic"));
                let solid = Solid { name: called, body, shape, pose };
                all.push((solid, optional(surface, "value", friction)?));
            }
        }
        self.model.touch_all(&all, |_, _| true, self.report);
        Ok(())
    }

    /// Coulomb friction of a link: Bullet's, or Gazebo's.
    fn friction(&self, link: &'a XmlElement, name: &str) -> Fallible<f64> {
        if let Some(lateral) = link.child("contact").and_then(|contact| contact.child("lateral_friction")) {
            return optional(Some(lateral), "value", FRICTION);
        }
        let gazebo = self.root.all("gazebo").filter(|gazebo| gazebo.get("reference") == Some(name));
        gazebo.filter_map(|gazebo| gazebo.child("mu1")).last().map_or(Ok(FRICTION), XmlElement::text_number)
    }
}

/// The shape of a collision and its pose in the link; none of what has none.
fn shape(collision: &XmlElement) -> Fallible<Option<(SolidShape, Isometry3<f64>)>> {
    let pose = origin(collision.child("origin"))?;
    let Some(geometry) = collision.child("geometry").and_then(|geometry| geometry.children.first()) else {
        return Ok(None);
    };
    let size =
        |key: &str| -> Fallible<f64> {
            let text = geometry.must(key)?;
            match xml::numbers(text) {
                Ok(numbers) if numbers.len() == 1 && numbers[0] > 0.0 => Ok(numbers[0]),
                _ => Err(geometry
                    .refuse(format!("`{key}` of a <{}> is `{text}`, but must be a positive number", geometry.name))),
            }
        };
    Ok(Some(match geometry.name.as_str() {
        "sphere" => (SolidShape::Sphere(size("radius")?), pose),
        "cylinder" => (SolidShape::Cylinder(size("radius")?, size("length")? / 2.0), pose),
        "capsule" | "drake:capsule" => (SolidShape::Capsule(size("radius")?, size("length")? / 2.0), pose),
        "box" => {
            let sizes =
                geometry.attribute("size").ok_or_else(|| geometry.refuse("a <box> has no `size`"))?.array::<3>()?;
            if sizes.iter().any(|size| *size <= 0.0) {
                return Err(geometry.refuse("each `size` of a <box> must be positive"));
            }
            (SolidShape::Box(sizes.map(|size| size / 2.0)), pose)
        }
        "plane" => {
            let normal = geometry.attribute("normal").map_or(Ok([0.0, 0.0, 1.0]), |normal| normal.array::<3>())?;
            let facing =
                across(normal).ok_or_else(|| geometry.refuse("the normal of a <plane> has the length zero"))?;
            (SolidShape::Plane, pose * facing)
        }
        _ => (SolidShape::File, pose),
    }))
}
