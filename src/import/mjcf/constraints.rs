//! Equality constraints and tendons.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::{ContactGeom, MjcfReader};
use crate::import::refusal::{Fallible, ImportRefusal};
use crate::import::robot::{
    BodyPoint, Closure, ClosureKind, Course, CourseBend, JointFollower, JointLaws, JointMotion, PointSpring,
    SolidShape, Tendon,
};
use crate::import::xml::XmlElement;

/// A site: the index of its body, and its pose in it.
type PlacedSite = (usize, Isometry3<f64>);

impl<'a> MjcfReader<'a> {
    pub fn constraints(&mut self, root: &'a XmlElement) -> Fallible<()> {
        for section in root.all("equality") {
            for element in &section.children {
                let resolved = self.defaults.of(element, "equality", None)?;
                let active = resolved.get("active") != Some("false");
                if !active || !self.enabled.equality {
                    element.mark();
                    self.report.idle(format!("{}, which is not active", element.called()));
                    continue;
                }
                match element.name.as_str() {
                    "connect" => self.connect(element)?,
                    "weld" => self.weld(element)?,
                    "joint" => self.coupling(element)?,
                    "tendon" => self.tendon_coupling(element)?,
                    kind => {
                        self.refuse_or_leave(
                            element,
                            kind,
                            format!("the equality {} has no counterpart", element.called()),
                        );
                    }
                }
            }
        }
        Ok(())
    }

    /// A body by its name; without one the world.
    fn body_of(&self, element: &XmlElement, key: &str) -> Fallible<usize> {
        let Some(name) = element.get(key) else { return Ok(0) };
        let known = self.body_names.get(name).copied().or((name == "world").then_some(0));
        known.ok_or_else(|| {
            element.refuse(format!("{}: `{key}` is `{name}`, but there is no such body", element.called()))
        })
    }

    pub fn joint_named(&self, element: &XmlElement, name: &str) -> Fallible<usize> {
        let known = self.joint_names.get(name).copied();
        known.ok_or_else(|| element.refuse(format!("{}: there is no joint `{name}`", element.called())))
    }

    fn site_named(&self, element: &XmlElement, name: &str) -> Fallible<(usize, Isometry3<f64>)> {
        let known = self.sites.get(name).copied();
        known.ok_or_else(|| element.refuse(format!("{}: there is no site `{name}`", element.called())))
    }

    /// The pose of a body where the springs of all joints are relaxed.
    fn relaxed_world(&self, body: usize) -> Isometry3<f64> {
        let body_data = &self.model.bodies[body];
        if body == 0 {
            return Isometry3::identity();
        }
        let one = body_data
            .joints
            .iter()
            .filter(|&&joint| matches!(self.model.joints[joint].kind, JointMotion::Hinge | JointMotion::Slide));
        let moved = one.fold(Isometry3::identity(), |pose, &joint| {
            let joint_data = &self.model.joints[joint];
            pose * joint_data.motion(self.relaxed_joints[joint] - joint_data.zero)
        });
        self.relaxed_world(body_data.parent) * body_data.pose * moved
    }

    fn sites_of(&self, element: &'a XmlElement) -> Fallible<Option<[PlacedSite; 2]>> {
        match (element.get("site1"), element.get("site2")) {
            (Some(first), Some(second)) => {
                Ok(Some([self.site_named(element, first)?, self.site_named(element, second)?]))
            }
            (None, None) => Ok(None),
            _ => Err(element.refuse(format!("{} has one site, but needs both", element.called()))),
        }
    }

    fn connect(&mut self, element: &'a XmlElement) -> Fallible<()> {
        let ends = match self.sites_of(element)? {
            Some(sites) => sites.map(|(body, pose)| BodyPoint { body, at: Point3::from(pose.translation.vector) }),
            None => {
                element.must("body1")?;
                let [first, second] = [self.body_of(element, "body1")?, self.body_of(element, "body2")?];
                let anchor = element.attribute("anchor").ok_or_else(|| element.refuse("<connect> has no `anchor`"))?;
                let at = Point3::from(anchor.array::<3>()?);
                let there = self.model.world(second).inverse() * (self.model.world(first) * at);
                [BodyPoint { body: first, at }, BodyPoint { body: second, at: there }]
            }
        };
        self.close(element, ClosureKind::Point, ends);
        Ok(())
    }

    fn weld(&mut self, element: &'a XmlElement) -> Fallible<()> {
        let (bodies, pose) = match self.sites_of(element)? {
            // Both frames coincide.
            Some([(first, a), (second, b)]) => ([first, second], a * b.inverse()),
            None => {
                element.must("body1")?;
                let [first, second] = [self.body_of(element, "body1")?, self.body_of(element, "body2")?];
                let given = element.attribute("relpose").map(|attribute| attribute.array::<7>()).transpose()?;
                let given = given.and_then(|[x, y, z, w, i, j, k]| {
                    let turn = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-12)?;
                    Some(Isometry3::from_parts(Translation3::new(x, y, z), turn))
                });
                element.attribute("anchor").map(|attribute| attribute.value());
                ([first, second], given.unwrap_or_else(|| self.model.world(first).inverse() * self.model.world(second)))
            }
        };
        let at = Point3::from(pose.translation.vector);
        let ends = [BodyPoint { body: bodies[0], at }, BodyPoint { body: bodies[1], at: Point3::origin() }];
        self.close(element, ClosureKind::Weld(pose), ends);
        Ok(())
    }

    fn close(&mut self, element: &XmlElement, kind: ClosureKind, ends: [BodyPoint; 2]) {
        let name = element.get("name").unwrap_or_default().to_owned();
        self.model.closures.push(Closure {
            name,
            place: element.place.clone(),
            kind,
            ends,
            laws: JointLaws::default(),
        });
        let soft = "soft in MuJoCo (solref, solimp), exact here";
        self.report.note(format!("equality constraints: {soft}"));
    }

    /// joint1 - ref1 = a0 + a1 (joint2 - ref2) + ...
    fn coupling(&mut self, element: &'a XmlElement) -> Fallible<()> {
        let name = element.get("name").unwrap_or_default();
        let joint = self.joint_named(element, element.must("joint1")?)?;
        let leader = element.get("joint2").map(|name| self.joint_named(element, name)).transpose()?;
        let mut factors = [0.0, 1.0, 0.0, 0.0, 0.0];
        if let Some(attribute) = element.attribute("polycoef") {
            let given = attribute.numbers()?;
            if given.len() > 5 {
                return Err(ImportRefusal::new("`polycoef` has at most 5 numbers").at(&attribute.place));
            }
            factors.iter_mut().zip(given).for_each(|(factor, number)| *factor = number);
        }
        let named = [Some(joint), leader].into_iter().flatten().map(|joint| &self.model.joints[joint]);
        if let Some(wrong) =
            named.into_iter().find(|joint| !matches!(joint.kind, JointMotion::Hinge | JointMotion::Slide))
        {
            return Err(element.refuse(format!(
                "{} couples `{}`, which is neither a hinge nor a slide",
                element.called(),
                wrong.name
            )));
        }
        if factors[2..].iter().any(|factor| *factor != 0.0) && leader.is_some() {
            let called =
                if name.is_empty() { "a joint equality".to_owned() } else { format!("joint equality `{name}`") };
            let text = element.attribute("polycoef").map_or("", |attribute| &attribute.value);
            self.refuse_or_leave(element, "equality", format!("{called} is not linear: its polycoef is {text}"));
            return Ok(());
        }
        let [offset, ratio, ..] = factors;
        let place = element.place.clone();
        self.model.followers.push(JointFollower { name: name.to_owned(), place, joint, leader, offset, ratio });
        Ok(())
    }

    pub fn tendons(&mut self, root: &'a XmlElement) -> Fallible<()> {
        for section in root.all("tendon") {
            for element in &section.children {
                match element.name.as_str() {
                    "fixed" => self.fixed_tendon(element)?,
                    _ => self.spatial_tendon(element)?,
                }
            }
        }
        Ok(())
    }

    /// The lengths between which a tendon is relaxed; by default its length in the reference configuration.
    fn relaxed(&self, resolved: &super::resolve::ResolvedElement, length: f64) -> Fallible<[f64; 2]> {
        let Some(attribute) = resolved.attribute("springlength") else { return Ok([length; 2]) };
        match attribute.numbers()?[..] {
            // What MuJoCo takes for no length.
            [-1.0] | [-1.0, -1.0] => Ok([length; 2]),
            [at] => Ok([at; 2]),
            [low, high] if low <= high => Ok([low, high]),
            _ => Err(ImportRefusal::new(format!(
                "`springlength` is `{}`, but must be one or two increasing lengths",
                attribute.value
            ))
            .at(&attribute.place)),
        }
    }

    fn fixed_tendon(&mut self, element: &'a XmlElement) -> Fallible<()> {
        let resolved = self.defaults.of(element, "tendon", None)?;
        let mut terms = Vec::new();
        for child in element.all("joint") {
            let joint = self.joint_named(child, child.must("joint")?)?;
            terms.push((
                joint,
                child.attribute("coef").ok_or_else(|| child.refuse("the joint of a tendon has no `coef`"))?.number()?,
            ));
        }
        // MuJoCo's default length is that in the configuration where the springs of the joints are relaxed.
        let length = terms.iter().map(|(joint, factor)| factor * self.relaxed_joints[*joint]).sum();
        let tendon = Tendon {
            name: element.get("name").unwrap_or_default().to_owned(),
            terms,
            stiffness: if self.enabled.spring { resolved.number("stiffness", 0.0)? } else { 0.0 },
            damping: if self.enabled.damper { resolved.number("damping", 0.0)? } else { 0.0 },
            relaxed: self.relaxed(&resolved, length)?,
        };
        if tendon.stiffness != 0.0 || tendon.damping != 0.0 {
            self.model.tendons.push(tendon.clone());
        }
        self.fixed_tendons.insert(tendon.name.clone(), tendon);
        Ok(())
    }

    /// The sites and cylinders of a tendon in their order; none if it has what has no counterpart.
    fn course(&mut self, element: &'a XmlElement) -> Fallible<Option<Course>> {
        let mut points = Vec::new();
        let plain = |at: BodyPoint| CourseBend { at, radius: 0.0, axis: None, side: None, called: String::new() };
        for child in &element.children {
            match child.name.as_str() {
                "site" => {
                    let (body, pose) = self.site_named(child, child.must("site")?)?;
                    points.push(plain(BodyPoint { body, at: Point3::from(pose.translation.vector) }));
                }
                "geom" => points.push(self.bend(child)?),
                _ => {
                    let why =
                        format!("{} has branches over <{}>, which have no counterpart", element.called(), child.name);
                    self.refuse_or_leave(element, "tendon", why);
                    return Ok(None);
                }
            }
        }
        let ends_are_sites = points.first().zip(points.last()).is_some_and(|(a, b)| a.radius == 0.0 && b.radius == 0.0);
        if points.len() < 2 || !ends_are_sites {
            return Err(
                element.refuse(format!("{} must begin and end at a site, and have two at least", element.called()))
            );
        }
        let last = points.pop().map(|point| point.at);
        let first = points.remove(0).at;
        Ok(last.map(|last| Course { ends: [first, last], over: points }))
    }

    /// A cylinder or ball that a tendon runs about.
    fn bend(&mut self, element: &'a XmlElement) -> Fallible<CourseBend> {
        let name = element.must("geom")?;
        let geom = self.geoms.iter().find(|geom| geom.solid.name == name);
        let Some(ContactGeom { solid, .. }) = geom else {
            return Err(element.refuse(format!("there is no geom `{name}` for a tendon to run about")));
        };
        let (radius, axis) = match solid.shape {
            SolidShape::Cylinder(radius, _) => (radius, Some(solid.pose * Vector3::z())),
            SolidShape::Sphere(radius) => (radius, None),
            _ => {
                return Err(
                    element.refuse(format!("a tendon runs about `{name}`, which is neither a cylinder nor a sphere"))
                );
            }
        };
        let at = BodyPoint { body: solid.body, at: Point3::from(solid.pose.translation.vector) };
        let side = match element.get("sidesite") {
            Some(site) => {
                let (body, pose) = self.site_named(element, site)?;
                Some(BodyPoint { body, at: Point3::from(pose.translation.vector) })
            }
            None => None,
        };
        Ok(CourseBend { at, radius, axis, side, called: name.to_owned() })
    }

    fn spatial_tendon(&mut self, element: &'a XmlElement) -> Fallible<()> {
        let resolved = self.defaults.of(element, "tendon", None)?;
        let name = element.get("name").unwrap_or_default();
        let Some(course) = self.course(element)? else { return Ok(()) };
        let range = resolved.range("range", "limited", self.settings.autolimits)?.filter(|_| self.enabled.limit);
        if range.is_some_and(|range| range[0] > 0.0) {
            self.refuse_or_leave(
                element,
                "tendon",
                format!("{} has a minimum length, which a rope does not have", element.called()),
            );
        }
        let stiffness = if self.enabled.spring { resolved.number("stiffness", 0.0)? } else { 0.0 };
        let given =
            resolved.attribute("springlength").is_some_and(|length| !matches!(length.value.trim(), "-1" | "-1 -1"));
        if stiffness != 0.0 && !given && course.over.iter().any(|bend| bend.radius > 0.0) {
            let why = format!(
                "the relaxed length of {} is the one about its cylinders where MuJoCo compiles the model",
                element.called()
            );
            self.report.refuse_or_leave(
                element,
                self.options,
                &[name, "tendon"],
                &format!("{why}: give `springlength`"),
            );
            return Ok(());
        }
        let places: Vec<Point3<f64>> = course.points().map(|point| self.relaxed_world(point.body) * point.at).collect();
        let length = places.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
        let spring = PointSpring {
            name: name.to_owned(),
            place: element.place.clone(),
            course: course.clone(),
            stiffness,
            damping: if self.enabled.damper { resolved.number("damping", 0.0)? } else { 0.0 },
            relaxed: self.relaxed(&resolved, length)?,
            longest: range.map(|range| range[1]),
        };
        self.spatial_tendons.insert(name.to_owned(), course);
        if spring.stiffness != 0.0 || spring.damping != 0.0 || spring.longest.is_some() {
            self.model.springs.push(spring);
        }
        Ok(())
    }

    /// An equality of one fixed tendon: the sum of its joints keeps its length, as two joints in gear do.
    fn tendon_coupling(&mut self, element: &'a XmlElement) -> Fallible<()> {
        let name = element.must("tendon1")?;
        let factors = element.attribute("polycoef").map_or(Ok(vec![0.0]), |attribute| attribute.numbers())?;
        let offset = factors.first().copied().unwrap_or(0.0);
        let terms = self.fixed_tendons.get(name).map(|tendon| tendon.terms.clone());
        let (place, called) = (element.place.clone(), element.get("name").unwrap_or(name).to_owned());
        let follower = match (element.get("tendon2"), terms.as_deref()) {
            (None, Some(&[(joint, factor)])) if factor != 0.0 => {
                JointFollower { name: called, place, joint, leader: None, offset: offset / factor, ratio: 0.0 }
            }
            (None, Some(&[(leader, other), (joint, factor)])) if factor != 0.0 && other != 0.0 => {
                let (leader, offset, ratio) = (Some(leader), offset / factor, -other / factor);
                JointFollower { name: called, place, joint, leader, offset, ratio }
            }
            _ => {
                let why =
                    format!("{} holds the length of `{name}`, which is not the sum of two joints", element.called());
                self.refuse_or_leave(element, "equality", why);
                return Ok(());
            }
        };
        self.model.followers.push(follower);
        Ok(())
    }
}
