//! Collisions of SDF as contacts: planes with spheres, capsules, boxes and cylinders. As in Gazebo, links of one model touch only where it says `self_collide`,
//! and never those that a joint joins.

use nalgebra::Isometry3;

use super::{SdfReader, number, pose, vector};
use crate::import::options::ContactChoice;
use crate::import::refusal::Fallible;
use crate::import::robot::{FRICTION, Solid, SolidShape, SpatialModel, across};
use crate::import::xml::XmlElement;

struct Collision {
    solid: Solid,
    friction: f64,
    bitmask: u64,
    /// The outermost model that it belongs to.
    model: String,
    self_collides: bool,
}

impl SdfReader<'_> {
    /// A contact for each pair that may touch.
    pub fn collisions(&mut self, model: &mut SpatialModel, bodies: &[usize]) -> Fallible<()> {
        if self.options.contacts == ContactChoice::None {
            return Ok(());
        }
        let mut all = Vec::new();
        for (link, (name, element, _)) in self.links.iter().enumerate() {
            for collision in element.all("collision") {
                all.extend(read(collision, (name, bodies[link]), self.self_collides(name, element))?);
            }
        }
        let solids: Vec<(Solid, f64)> =
            all.iter().map(|collision| (collision.solid.clone(), collision.friction)).collect();
        let may_touch = |first: usize, second: usize| {
            let (a, b): (&Collision, &Collision) = (&all[first], &all[second]);
            (a.model != b.model || a.self_collides && b.self_collides) && a.bitmask & b.bitmask != 0
        };
        model.touch_all(&solids, may_touch, self.report);
        Ok(())
    }

    /// True if the links of the model of a link touch each other.
    fn self_collides(&self, name: &str, link: &XmlElement) -> bool {
        let is_true = |element: &XmlElement| matches!(element.text.trim(), "true" | "1");
        if let Some(of_link) = link.child("self_collide") {
            return is_true(of_link);
        }
        let model = name.rsplit_once("::").map_or("", |(model, _)| model);
        self.frames.get(model).and_then(|frame| frame.element.child("self_collide")).is_some_and(is_true)
    }
}

fn read(element: &XmlElement, (link, body): (&str, usize), self_collides: bool) -> Fallible<Option<Collision>> {
    let surface = element.child("surface");
    let contact = surface.and_then(|surface| surface.child("contact"));
    let ghost = contact.and_then(|contact| contact.child("collide_without_contact"));
    if ghost.is_some_and(|ghost| matches!(ghost.text.trim(), "true" | "1")) {
        return Ok(None);
    }
    let Some((shape, placed)) = shape(element)? else { return Ok(None) };
    let bitmask = match contact.and_then(|contact| contact.child("collide_bitmask")) {
        None => 0xffff,
        Some(mask) => {
            let text = mask.text.trim();
            let parsed =
                text.strip_prefix("0x").map_or_else(|| text.parse().ok(), |hex| u64::from_str_radix(hex, 16).ok());
            parsed.ok_or_else(|| mask.refuse(format!("<collide_bitmask> is `{text}`, but must be a whole number")))?
        }
    };
    let solid = Solid {
        name: element
            .get("name")
            .map(|name| format!("{}_{name}", link.rsplit("::").next().unwrap_or(link)))
            .unwrap_or_default(),
        body,
        shape,
        pose: pose(element.child("pose"))? * placed,
    };
    let model = link.split("::").next().unwrap_or_default().to_owned();
    Ok(Some(Collision { solid, friction: friction(element)?, bitmask, model, self_collides }))
}

/// Coulomb friction: that of ODE, of Bullet, or of Drake.
fn friction(element: &XmlElement) -> Fallible<f64> {
    let of_surface = element.child("surface").and_then(|surface| surface.child("friction"));
    let ode = of_surface.and_then(|friction| friction.child("ode")?.child("mu"));
    let bullet = of_surface.and_then(|friction| friction.child("bullet")?.child("friction"));
    let drake = element.child("drake:proximity_properties").and_then(|properties| properties.child("drake:mu_dynamic"));
    let mu = number(drake.or(ode).or(bullet), FRICTION)?;
    if mu < 0.0 {
        return Err(element.refuse(format!("{}: its friction is {mu}, but must not be negative", element.called())));
    }
    Ok(mu)
}

/// The shape of a collision, and its pose in the frame of the collision; none of what is empty.
fn shape(element: &XmlElement) -> Fallible<Option<(SolidShape, Isometry3<f64>)>> {
    let Some(geometry) = element.child("geometry").and_then(|geometry| geometry.children.first()) else {
        return Ok(None);
    };
    let size = |key: &str| -> Fallible<f64> {
        let part = geometry.child(key).ok_or_else(|| {
            geometry.refuse(format!("the <{}> of {} has no <{key}>", geometry.name, element.called()))
        })?;
        let value = part.text_number()?;
        match value > 0.0 {
            true => Ok(value),
            false => Err(part.refuse(format!("<{key}> is {value}, but must be positive"))),
        }
    };
    let plain = |shape: SolidShape| Ok(Some((shape, Isometry3::identity())));
    match geometry.name.as_str() {
        "empty" => Ok(None),
        "plane" => {
            let normal = vector(geometry.child("normal"))?.unwrap_or([0.0, 0.0, 1.0]);
            let pose = across(normal)
                .ok_or_else(|| geometry.refuse(format!("the normal of {} has the length zero", element.called())))?;
            Ok(Some((SolidShape::Plane, pose)))
        }
        "sphere" => plain(SolidShape::Sphere(size("radius")?)),
        "cylinder" => plain(SolidShape::Cylinder(size("radius")?, size("length")? / 2.0)),
        "capsule" | "drake:capsule" => plain(SolidShape::Capsule(size("radius")?, size("length")? / 2.0)),
        "box" => match vector(geometry.child("size"))? {
            Some(sizes) if sizes.iter().all(|size| *size > 0.0) => plain(SolidShape::Box(sizes.map(|size| size / 2.0))),
            _ => {
                Err(geometry
                    .refuse(format!("the <box> of {} needs a <size> of three positive numbers", element.called())))
            }
        },
        _ => plain(SolidShape::File),
    }
}
