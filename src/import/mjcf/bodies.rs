//! Bodies, their joints, geoms and sites.

use nalgebra::{Isometry3, Matrix3, Point3, SymmetricEigen, Vector3};

use super::geometry;
use super::resolve::ResolvedElement;
use super::{ContactGeom, MjcfReader};
use crate::import::refusal::{Fallible, ImportRefusal};
use crate::import::robot::{BodyMass, JointMotion, Solid, SolidShape, SpatialBody, SpatialJoint};
use crate::import::xml::XmlElement;

/// Where children of an element belong: the body, the pose of the frame that they are in, the class that they have.
#[derive(Clone)]
struct Within<'c> {
    body: usize,
    pose: Isometry3<f64>,
    class: Option<&'c str>,
}

impl<'a> MjcfReader<'a> {
    pub fn bodies(&mut self, root: &'a XmlElement) -> Fallible<()> {
        for world in root.all("worldbody") {
            let within = Within { body: 0, pose: Isometry3::identity(), class: world.get("childclass") };
            self.children(world, &within)?;
        }
        if let Some(total) = self.settings.total_mass {
            let sum: f64 = self.model.bodies[1..].iter().map(|body| body.mass.mass).sum();
            for body in self.model.bodies.iter_mut().skip(1).filter(|_| sum > 0.0) {
                body.mass.mass *= total / sum;
                body.mass.tensor *= total / sum;
            }
        }
        Ok(())
    }

    /// What is in a body or frame.
    fn children(&mut self, element: &'a XmlElement, within: &Within<'a>) -> Fallible<()> {
        for child in &element.children {
            match child.name.as_str() {
                "joint" | "freejoint" => self.joint(child, within)?,
                "geom" => self.geom(child, within)?,
                "site" => self.site(child, within)?,
                _ => {}
            }
            if child.name == "frame" {
                let resolved = self.defaults.of(child, "frame", None)?;
                let pose = within.pose * resolved.pose(&self.settings.angles)?;
                self.children(
                    child,
                    &Within { body: within.body, pose, class: child.get("childclass").or(within.class) },
                )?;
            }
            if child.name == "body" {
                self.body(child, within)?;
            }
        }
        Ok(())
    }

    fn body(&mut self, element: &'a XmlElement, within: &Within<'a>) -> Fallible<()> {
        let resolved = self.defaults.of(element, "body", None)?;
        let pose = within.pose * resolved.pose(&self.settings.angles)?;
        let name = element.get("name").unwrap_or_default();
        let number = self.model.bodies.len();
        if !name.is_empty() && self.body_names.insert(name.to_owned(), number).is_some() {
            return Err(element.refuse(format!("two bodies have the name `{name}`")));
        }
        let compensated = element.attribute("gravcomp").map_or(Ok(0.0), |attribute| attribute.number())?;
        if compensated != 0.0 && compensated != 1.0 {
            self.refuse_or_leave(
                element,
                "gravcomp",
                format!("body `{name}`: `gravcomp` is {compensated}, but only 0 and 1 have a counterpart"),
            );
        }
        if element.get("mocap") == Some("true") {
            self.report
                .note(format!("body `{name}` is moved by the program that runs MuJoCo (mocap): it is ground here"));
        }
        let index = self.model.bodies.len();
        self.model.bodies.push(SpatialBody {
            name: name.to_owned(),
            place: Some(element.place.clone()),
            parent: within.body,
            pose,
            mass: BodyMass::default(),
            weightless: compensated == 1.0,
            joints: Vec::new(),
            points: Vec::new(),
        });
        let class = element.get("childclass").or(within.class);
        let inner = Within { body: index, pose: Isometry3::identity(), class };
        let mut mass = None;
        if let Some(inertial) = element.child("inertial")
            && self.settings.from_geoms != Some(true)
        {
            mass = Some(self.inertial(inertial)?);
        } else if let Some(inertial) = element.child("inertial") {
            inertial.mark();
        }
        if mass.is_none() && self.settings.from_geoms != Some(false) {
            mass = Some(self.mass_of_geoms(element, &inner, name)?);
        }
        let mass = self.bounded(mass.unwrap_or_default());
        self.model.bodies[index].mass = mass;
        self.children(element, &inner)
    }

    /// Mass, mass centre and inertia as given.
    fn inertial(&self, element: &'a XmlElement) -> Fallible<BodyMass> {
        let resolved = self.defaults.of(element, "inertial", None)?;
        let mass = resolved.attribute("mass").ok_or_else(|| element.refuse("<inertial> has no `mass`"))?.number()?;
        if mass < 0.0 {
            return Err(element.refuse(format!("`mass` is {mass}, but must not be negative")));
        }
        let pose = resolved.pose(&self.settings.angles)?;
        let tensor = match (resolved.array::<6>("fullinertia")?, resolved.array::<3>("diaginertia")?) {
            (Some([xx, yy, zz, xy, xz, yz]), None) => Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            (None, Some(moments)) => Matrix3::from_diagonal(&Vector3::from(moments)),
            (None, None) => Matrix3::zeros(),
            (Some(_), Some(_)) => return Err(element.refuse("<inertial> has both `fullinertia` and `diaginertia`")),
        };
        Ok(BodyMass { mass, centre: Vector3::zeros(), tensor }.moved(&pose))
    }

    /// The sum of the geoms in a body, those in its frames too.
    fn mass_of_geoms(&self, element: &'a XmlElement, within: &Within<'a>, body: &str) -> Fallible<BodyMass> {
        let mut sum = BodyMass::default();
        for child in &element.children {
            if child.name == "frame" {
                let pose = within.pose * self.defaults.of(child, "frame", None)?.pose(&self.settings.angles)?;
                let class = child.get("childclass").or(within.class);
                sum = sum.with(&self.mass_of_geoms(child, &Within { body: within.body, pose, class }, body)?);
            }
            if child.name == "geom" {
                let resolved = self.defaults.of(child, "geom", within.class)?;
                let group = resolved.number("group", 0.0)?;
                if group < self.settings.groups[0] || group > self.settings.groups[1] {
                    continue;
                }
                let geom = geometry::read(&resolved, &self.settings.angles)?;
                let named = if body.is_empty() { "(without a name)" } else { body };
                if let Some(mass) = geometry::mass(&resolved, &geom, named)? {
                    sum = sum.with(&mass.moved(&within.pose));
                }
            }
        }
        Ok(sum)
    }

    /// The bounds and the balance of the compiler.
    fn bounded(&self, mut mass: BodyMass) -> BodyMass {
        mass.mass = mass.mass.max(self.settings.least_mass);
        let principal = SymmetricEigen::new(mass.tensor);
        let mut moments = principal.eigenvalues.map(|moment| moment.max(self.settings.least_inertia));
        let unbalanced = 2.0 * moments.max() > moments.sum();
        if unbalanced && self.settings.balance {
            moments = Vector3::repeat(moments.sum() / 3.0);
        }
        if moments != principal.eigenvalues {
            mass.tensor =
                principal.eigenvectors * Matrix3::from_diagonal(&moments) * principal.eigenvectors.transpose();
        }
        mass
    }

    fn joint(&mut self, element: &'a XmlElement, within: &Within<'a>) -> Fallible<()> {
        let name = element.get("name").unwrap_or_default();
        if within.body == 0 {
            return Err(element.refuse(format!("{} is in the world, which does not move", element.called())));
        }
        let number = self.model.joints.len();
        if !name.is_empty() && self.joint_names.insert(name.to_owned(), number).is_some() {
            return Err(element.refuse(format!("two joints have the name `{name}`")));
        }
        let free = element.name == "freejoint";
        let class = if free { None } else { within.class };
        let resolved = self.defaults.of(element, if free { "freejoint" } else { "joint" }, class)?;
        let kind = match resolved.get("type").unwrap_or(if free { "free" } else { "hinge" }) {
            "hinge" => JointMotion::Hinge,
            "slide" => JointMotion::Slide,
            "ball" => JointMotion::Ball,
            "free" => JointMotion::Free,
            other => return Err(element.refuse(format!("{} has the unknown type `{other}`", element.called()))),
        };
        let mut joint = SpatialJoint::new(name, &element.place, kind, within.body);
        if matches!(kind, JointMotion::Hinge | JointMotion::Slide) {
            self.one_coordinate(&resolved, within, &mut joint)?;
        }
        joint.laws.damping = if self.enabled.damper { resolved.number("damping", 0.0)? } else { 0.0 };
        joint.laws.friction = if self.enabled.frictionloss { resolved.number("frictionloss", 0.0)? } else { 0.0 };
        joint.laws.armature = resolved.number("armature", 0.0)?;
        for (key, value) in
            [("damping", joint.laws.damping), ("frictionloss", joint.laws.friction), ("armature", joint.laws.armature)]
        {
            if value < 0.0 {
                return Err(
                    element.refuse(format!("{}: `{key}` is {value}, but must not be negative", element.called()))
                );
            }
        }
        if kind == JointMotion::Ball || kind == JointMotion::Free {
            let pose = self.model.bodies[within.body].pose;
            joint.free = Some((pose, Vector3::zeros(), Vector3::zeros()));
            if kind == JointMotion::Free && (joint.laws.armature != 0.0 || joint.laws.damping != 0.0) {
                self.refuse_or_leave(
                    element,
                    "joint",
                    format!("{} is free and has damping or armature", element.called()),
                );
            }
        }
        let index = self.model.joints.len();
        self.model.bodies[within.body].joints.push(index);
        self.relaxed_joints.push(resolved.number("springref", 0.0)? * unit_of(kind, self.settings.angles.unit));
        self.model.joints.push(joint);
        Ok(())
    }

    /// A hinge or a slide: axis, zero, spring, range.
    fn one_coordinate(&self, resolved: &ResolvedElement, within: &Within, joint: &mut SpatialJoint) -> Fallible<()> {
        let called = resolved.element.called();
        let unit = unit_of(joint.kind, self.settings.angles.unit);
        let at = resolved.array::<3>("pos")?.unwrap_or_default();
        joint.anchor = within.pose * Point3::from(at);
        let axis = Vector3::from(resolved.some("axis", [0.0, 0.0, 1.0])?);
        joint.axis = within.pose.rotation
            * axis
                .try_normalize(1e-12)
                .ok_or_else(|| resolved.element.refuse(format!("{called}: `axis` has the length zero")))?;
        joint.zero = resolved.number("ref", 0.0)? * unit;
        let stiffness = resolved.number("stiffness", 0.0)?;
        let relaxed = resolved.number("springref", 0.0)? * unit;
        if stiffness != 0.0 && self.enabled.spring {
            joint.laws.spring = Some([stiffness, relaxed - joint.zero]);
        }
        let range = resolved.range("range", "limited", self.settings.autolimits)?;
        joint.laws.range =
            range.filter(|_| self.enabled.limit).map(|range| range.map(|value| value * unit - joint.zero));
        joint.effort = resolved.range("actuatorfrcrange", "actuatorfrclimited", self.settings.autolimits)?;
        Ok(())
    }

    fn geom(&mut self, element: &'a XmlElement, within: &Within<'a>) -> Fallible<()> {
        let resolved = self.defaults.of(element, "geom", within.class)?;
        let geom = geometry::read(&resolved, &self.settings.angles)?;
        // Their mass has been read where it counts; a mesh that is not a contact shape has no other part in the motion.
        ["mass", "density", "shellinertia", "group"].iter().for_each(|name| _ = resolved.get(name));
        let friction = resolved.some("friction", [1.0, 0.005, 0.0001])?[0];
        let number = |name: &str, default: f64| resolved.number(name, default);
        let solid = Solid {
            name: element.get("name").unwrap_or_default().to_owned(),
            body: within.body,
            shape: geom.shape,
            pose: within.pose * geom.pose,
        };
        let contact = ContactGeom {
            solid,
            contype: number("contype", 1.0)? as i64,
            conaffinity: number("conaffinity", 1.0)? as i64,
            condim: number("condim", 3.0)? as i64,
            priority: number("priority", 0.0)? as i64,
            friction,
        };
        if contact.solid.shape == SolidShape::Plane && within.body != 0 {
            return Err(ImportRefusal::new(format!("{} is a plane on a body that may move", element.called()))
                .at(&element.place));
        }
        self.geoms.push(contact);
        Ok(())
    }

    fn site(&mut self, element: &'a XmlElement, within: &Within<'a>) -> Fallible<()> {
        let resolved = self.defaults.of(element, "site", within.class)?;
        let pose = match resolved.array::<6>("fromto")? {
            Some([a, b, c, d, e, f]) => Isometry3::translation((a + d) / 2.0, (b + e) / 2.0, (c + f) / 2.0),
            None => resolved.pose(&self.settings.angles)?,
        };
        let pose = within.pose * pose;
        if let Some(name) = element.get("name") {
            self.sites.insert(name.to_owned(), (within.body, pose));
            if within.body != 0 {
                let at = Point3::from(pose.translation.vector);
                self.model.bodies[within.body].points.push((name.to_owned(), at));
            }
        }
        Ok(())
    }
}

/// What the unit of a joint's coordinate is in SI.
fn unit_of(kind: JointMotion, angle: f64) -> f64 {
    if kind == JointMotion::Hinge { angle } else { 1.0 }
}
