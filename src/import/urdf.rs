//! URDF, the robots of ROS, as a model in space; with what Gazebo, Isaac Sim, Drake and onshape-to-robot add to close loops.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};

use super::options::ImportOptions;
use super::refusal::{Fallible, ImportRefusal};
use super::report::ImportReport;
use super::robot::{
    Activation, BodyMass, BodyPoint, Closure, ClosureKind, JointFollower, JointLaws, JointMotion, SpatialActuator,
    SpatialBody, SpatialBushing, SpatialJoint, SpatialModel, Transmission,
};
use super::sdf;
use super::xml::XmlElement;

struct UrdfReader<'a> {
    root: &'a XmlElement,
    model: SpatialModel,
    options: &'a ImportOptions,
    report: &'a mut ImportReport,
    /// The body of each link.
    bodies: BTreeMap<&'a str, usize>,
    efforts: BTreeMap<usize, f64>,
}

/// The model in a document.
///
/// # Errors
/// What is no tree of links, or cannot be imported.
pub fn read(root: &XmlElement, options: &ImportOptions, report: &mut ImportReport) -> Fallible<SpatialModel> {
    refuse_xacro(root)?;
    let name = root.get("name").unwrap_or_default();
    let model = SpatialModel::new("URDF", name, Vector3::new(0.0, 0.0, -9.81));
    let mut reader = UrdfReader { root, model, options, report, bodies: BTreeMap::new(), efforts: BTreeMap::new() };
    reader.report.note("URDF has no gravity: 9.81 m/s2 along -z is assumed");
    reader.tree()?;
    reader.mimics()?;
    reader.closures()?;
    reader.inputs()?;
    reader.others(root);
    Ok(reader.model)
}

fn refuse_xacro(element: &XmlElement) -> Fallible<()> {
    let of_attribute = element.attributes.iter().find(|attribute| attribute.value.contains("${"));
    let place = of_attribute
        .map(|of_attribute| &of_attribute.place)
        .or_else(|| element.name.starts_with("xacro:").then_some(&element.place));
    if let Some(place) = place {
        return Err(ImportRefusal::new("it is a xacro file, which must be expanded first")
            .at(place)
            .help("run `xacro FILE > out.urdf`, and import out.urdf"));
    }
    element.children.iter().try_for_each(refuse_xacro)
}

/// `xyz` and `rpy` of an element; none of either is zero.
fn origin(element: Option<&XmlElement>) -> Fallible<Isometry3<f64>> {
    let Some(element) = element else { return Ok(Isometry3::identity()) };
    let three = |name: &str| element.attribute(name).map_or(Ok([0.0; 3]), |attribute| attribute.array::<3>());
    let ([x, y, z], [roll, pitch, yaw]) = (three("xyz")?, three("rpy")?);
    Ok(Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_euler_angles(roll, pitch, yaw)))
}

fn optional(element: Option<&XmlElement>, name: &str, default: f64) -> Fallible<f64> {
    element.and_then(|element| element.attribute(name)).map_or(Ok(default), |attribute| attribute.number())
}

impl<'a> UrdfReader<'a> {
    /// Links by the joints from the root outwards.
    fn tree(&mut self) -> Fallible<()> {
        let root = self.root;
        let mut links: BTreeMap<&str, &XmlElement> = BTreeMap::new();
        for link in root.all("link") {
            if links.insert(link.must("name")?, link).is_some() {
                return Err(link.refuse(format!("two links have the name `{}`", link.must("name")?)));
            }
        }
        let mut joints: BTreeMap<&str, Vec<&XmlElement>> = BTreeMap::new();
        let mut parents: BTreeMap<&str, &XmlElement> = BTreeMap::new();
        for joint in root.all("joint") {
            let [parent, child] = [self.link_of(joint, "parent")?, self.link_of(joint, "child")?];
            if let Some(name) = [parent, child].into_iter().find(|name| !links.contains_key(name)) {
                return Err(joint.refuse(format!("{}: there is no link `{name}`", joint.called())));
            }
            if let Some(other) = parents.insert(child, joint) {
                return Err(joint.refuse(format!("link `{child}` has two parents: {} and {}", other.called(), joint.called()))
                    .help("URDF is a tree; close the loop by a <gazebo><joint>, a <loop_joint> or a pair of frames closing_NAME_1, closing_NAME_2"));
            }
            joints.entry(parent).or_default().push(joint);
        }
        let mut roots = root.all("link").filter_map(|link| link.get("name")).filter(|name| !parents.contains_key(name));
        let Some(first) = roots.next() else {
            return Err(root.refuse(match links.is_empty() {
                true => "it has no link",
                false => "its joints form a cycle: every link has a parent",
            }));
        };
        if let Some(second) = roots.next() {
            return Err(
                links[second].refuse(format!("it has two roots: links `{first}` and `{second}` have no parent joint"))
            );
        }
        self.report.note(format!("link `{first}` is the root and is held as ground"));
        // The ground needs no mass.
        links[first].mark();
        self.bodies.insert(first, 0);
        let mut next = vec![first];
        while let Some(parent) = next.pop() {
            for joint in joints.get(parent).into_iter().flatten() {
                let child = self.link_of(joint, "child")?;
                self.link(joint, self.bodies[parent], links[child])?;
                next.push(child);
            }
        }
        if let Some(link) =
            root.all("link").find(|link| link.get("name").is_some_and(|name| !self.bodies.contains_key(name)))
        {
            return Err(link.refuse(format!("{} is in a cycle of joints", link.called())));
        }
        Ok(())
    }

    fn link_of(&self, joint: &'a XmlElement, key: &str) -> Fallible<&'a str> {
        let reference = joint.child(key).ok_or_else(|| joint.refuse(format!("{} has no <{key}>", joint.called())))?;
        reference.must("link")
    }

    fn link(&mut self, joint: &'a XmlElement, parent: usize, link: &'a XmlElement) -> Fallible<()> {
        let name = link.must("name")?;
        let body = self.model.bodies.len();
        self.bodies.insert(name, body);
        self.model.bodies.push(SpatialBody {
            name: name.to_owned(),
            place: Some(link.place.clone()),
            parent,
            pose: origin(joint.child("origin"))?,
            mass: mass(link)?,
            weightless: false,
            joints: Vec::new(),
            points: Vec::new(),
        });
        let kind = match joint.must("type")? {
            "revolute" | "continuous" => JointMotion::Hinge,
            "prismatic" => JointMotion::Slide,
            "fixed" => return Ok(()),
            "planar" => JointMotion::Planar,
            "floating" => JointMotion::Free,
            other => return Err(joint.refuse(format!("{} has the unknown type `{other}`", joint.called()))),
        };
        let name = joint.must("name")?;
        if self.model.joints.iter().any(|other| other.name == name) {
            return Err(joint.refuse(format!("two joints have the name `{name}`")));
        }
        let mut spatial_joint = SpatialJoint::new(name, &joint.place, kind, body);
        let axis = joint
            .child("axis")
            .and_then(|axis| axis.attribute("xyz"))
            .map_or(Ok([1.0, 0.0, 0.0]), |attribute| attribute.array::<3>())?;
        spatial_joint.axis = Vector3::from(axis)
            .try_normalize(1e-12)
            .ok_or_else(|| joint.refuse(format!("{}: its axis has the length zero", joint.called())))?;
        spatial_joint.laws.damping = optional(joint.child("dynamics"), "damping", 0.0)?;
        spatial_joint.laws.friction = optional(joint.child("dynamics"), "friction", 0.0)?;
        self.limits(joint, &mut spatial_joint)?;
        if matches!(kind, JointMotion::Free | JointMotion::Planar) {
            spatial_joint.free = Some((self.model.bodies[body].pose, Vector3::zeros(), Vector3::zeros()));
        }
        self.model.bodies[body].joints.push(self.model.joints.len());
        self.model.joints.push(spatial_joint);
        Ok(())
    }

    fn limits(&mut self, joint: &'a XmlElement, spatial_joint: &mut SpatialJoint) -> Fallible<()> {
        let limit = joint.child("limit");
        let range = [optional(limit, "lower", 0.0)?, optional(limit, "upper", 0.0)?];
        if matches!(joint.get("type"), Some("revolute" | "prismatic")) && limit.is_some() {
            if range[0] >= range[1] {
                return Err(joint.refuse(format!(
                    "{}: its limits {} to {} do not increase",
                    joint.called(),
                    range[0],
                    range[1]
                )));
            }
            spatial_joint.laws.range = Some(range);
        }
        let effort = optional(limit, "effort", 0.0)?;
        if effort > 0.0 {
            self.efforts.insert(self.model.joints.len(), effort);
        }
        if optional(limit, "velocity", 0.0)? > 0.0 {
            self.report.idle("largest velocity of a joint, which a controller keeps");
        }
        Ok(())
    }

    fn joint_named(&self, element: &XmlElement, name: &str) -> Fallible<usize> {
        let known = self.model.joints.iter().position(|joint| joint.name == name);
        known.ok_or_else(|| element.refuse(format!("{}: there is no joint `{name}` that moves", element.called())))
    }

    /// Joints that follow others, through those that follow, too: q = multiplier q_leader + offset.
    fn mimics(&mut self) -> Fallible<()> {
        let mut follow: BTreeMap<usize, (usize, f64, f64, &XmlElement)> = BTreeMap::new();
        for joint in self.root.all("joint") {
            let Some(mimic) = joint.child("mimic") else { continue };
            let follower = self.joint_named(joint, joint.must("name")?)?;
            let leader = self.joint_named(joint, mimic.must("joint")?)?;
            let (ratio, offset) = (optional(Some(mimic), "multiplier", 1.0)?, optional(Some(mimic), "offset", 0.0)?);
            follow.insert(follower, (leader, ratio, offset, joint));
        }
        for (&follower, &(mut leader, mut ratio, mut offset, joint)) in &follow {
            for _ in 0..=follow.len() {
                let Some(&(next, factor, shift, _)) = follow.get(&leader) else { break };
                (leader, offset, ratio) = (next, offset + ratio * shift, ratio * factor);
            }
            if follow.contains_key(&leader) {
                return Err(joint.refuse(format!("{} follows itself through other joints", joint.called())));
            }
            self.model.joints[follower].start = offset;
            let name = format!("{}_mimic", joint.must("name")?);
            let place = joint.place.clone();
            self.model.followers.push(JointFollower {
                name,
                place,
                joint: follower,
                leader: Some(leader),
                offset,
                ratio,
            });
        }
        Ok(())
    }

    fn body(&self, element: &XmlElement, name: &str) -> Fallible<usize> {
        if name == "world" {
            return Ok(0);
        }
        self.bodies
            .get(name)
            .copied()
            .ok_or_else(|| element.refuse(format!("{}: there is no link `{name}`", element.called())))
    }

    fn world(&self, body: usize) -> Isometry3<f64> {
        let body_data = &self.model.bodies[body];
        if body == 0 { Isometry3::identity() } else { self.world(body_data.parent) * body_data.pose }
    }

    /// What closes loops, by each convention.
    fn closures(&mut self) -> Fallible<()> {
        let root = self.root;
        for gazebo in root.all("gazebo") {
            for joint in gazebo.all("joint") {
                self.gazebo_joint(joint)?;
            }
            for plugin in gazebo.all("plugin") {
                let file = plugin.get("filename").unwrap_or_default();
                if ["loop", "mimic", "attach"].iter().any(|word| file.to_lowercase().contains(word)) {
                    self.report.note(format!("the Gazebo plugin `{file}` (line {}) may close a loop or couple joints that the file does not describe", plugin.place.line));
                }
            }
        }
        for joint in root.all("loop_joint") {
            self.loop_joint(joint)?;
        }
        for constraint in root.all("drake:ball_constraint") {
            self.ball_constraint(constraint)?;
        }
        for bushing in root.all("drake:linear_bushing_rpy") {
            self.bushing(bushing)?;
        }
        self.closing_frames();
        Ok(())
    }

    fn close(&mut self, element: &XmlElement, kind: ClosureKind, ends: [BodyPoint; 2], laws: JointLaws) {
        let name = element.get("name").unwrap_or_default().to_owned();
        self.model.closures.push(Closure { name, place: element.place.clone(), kind, ends, laws });
    }

    /// A joint as in SDF: its pose in the frame of its child.
    fn gazebo_joint(&mut self, joint: &'a XmlElement) -> Fallible<()> {
        let text = |name: &str| {
            joint
                .child(name)
                .map(|content| content.text.trim())
                .ok_or_else(|| joint.refuse(format!("{} has no <{name}>", joint.called())))
        };
        let [parent, child] = [self.body(joint, text("parent")?)?, self.body(joint, text("child")?)?];
        let pose = match joint.child("pose") {
            Some(position) => match position.text_numbers()?[..] {
                [x, y, z, roll, pitch, yaw] => Isometry3::from_parts(
                    Translation3::new(x, y, z),
                    UnitQuaternion::from_euler_angles(roll, pitch, yaw),
                ),
                _ => return Err(position.refuse("<pose> must be six numbers")),
            },
            None => Isometry3::identity(),
        };
        let place = self.world(child) * pose;
        let into = self.world(parent).inverse() * place;
        let ends = [
            BodyPoint { body: parent, at: Point3::from(into.translation.vector) },
            BodyPoint { body: child, at: Point3::from(pose.translation.vector) },
        ];
        let axis = match joint.child("axis").and_then(|axis| axis.child("xyz")) {
            Some(position) => match position.text_numbers()?[..] {
                [x, y, z] => Vector3::new(x, y, z),
                _ => return Err(position.refuse("<xyz> must be three numbers")),
            },
            None => Vector3::z(),
        };
        let axis = into.rotation
            * axis
                .try_normalize(1e-12)
                .ok_or_else(|| joint.refuse(format!("{}: its axis has the length zero", joint.called())))?;
        let kind = match joint.must("type")? {
            "revolute" | "continuous" => ClosureKind::Hinge(axis),
            "prismatic" => ClosureKind::Slide(axis),
            "fixed" => ClosureKind::Weld(self.world(parent).inverse() * self.world(child)),
            "ball" => ClosureKind::Point,
            other => {
                return Err(joint.refuse(format!(
                    "{} closes a loop and is of type `{other}`, which a planar mechanism cannot have",
                    joint.called()
                )));
            }
        };
        let ends = match &kind {
            ClosureKind::Weld(pose) => [
                BodyPoint { body: parent, at: Point3::from(pose.translation.vector) },
                BodyPoint { body: child, at: Point3::origin() },
            ],
            _ => ends,
        };
        self.report.unknown(joint, sdf::OF_JOINTS, "a joint");
        let laws = joint.child("axis").map_or(Ok(JointLaws::default()), sdf::axis_laws)?;
        self.close(joint, kind, ends, laws);
        Ok(())
    }

    fn loop_joint(&mut self, joint: &'a XmlElement) -> Fallible<()> {
        let mut ends = Vec::new();
        for key in ["link1", "link2"] {
            let reference =
                joint.child(key).ok_or_else(|| joint.refuse(format!("{} has no <{key}>", joint.called())))?;
            ends.push((self.body(joint, reference.must("link")?)?, origin(Some(reference))?));
        }
        let [(first, pose), (second, other)] = ends[..] else { return Ok(()) };
        let axis = joint
            .child("axis")
            .and_then(|axis| axis.attribute("xyz"))
            .map_or(Ok([1.0, 0.0, 0.0]), |attribute| attribute.array::<3>())?;
        let axis = pose.rotation
            * Vector3::from(axis).try_normalize(1e-12).ok_or_else(|| joint.refuse("its axis has the length zero"))?;
        let kind = match joint.get("type").unwrap_or("revolute") {
            "revolute" | "continuous" => ClosureKind::Hinge(axis),
            "spherical" | "ball" => ClosureKind::Point,
            "prismatic" => ClosureKind::Slide(axis),
            "fixed" => ClosureKind::Weld(pose * other.inverse()),
            other => {
                return Err(joint
                    .refuse(format!("{} is of type `{other}`, which a planar mechanism cannot have", joint.called())));
            }
        };
        let ends = match &kind {
            ClosureKind::Weld(pose) => [
                BodyPoint { body: first, at: Point3::from(pose.translation.vector) },
                BodyPoint { body: second, at: Point3::origin() },
            ],
            _ => [(first, pose), (second, other)]
                .map(|(body, pose)| BodyPoint { body, at: Point3::from(pose.translation.vector) }),
        };
        let dynamics = |key: &str| optional(joint.child("dynamics"), key, 0.0);
        let laws = JointLaws { damping: dynamics("damping")?, friction: dynamics("friction")?, ..JointLaws::default() };
        self.close(joint, kind, ends, laws);
        Ok(())
    }

    fn ball_constraint(&mut self, element: &'a XmlElement) -> Fallible<()> {
        let part =
            |key: &str| element.child(key).ok_or_else(|| element.refuse(format!("<{}> has no <{key}>", element.name)));
        let bodies = [
            self.body(element, part("drake:ball_constraint_body_A")?.must("name")?)?,
            self.body(element, part("drake:ball_constraint_body_B")?.must("name")?)?,
        ];
        let point = |key: &str| -> Fallible<Point3<f64>> {
            let Some(point) = element.child(key) else { return Ok(Point3::origin()) };
            point.attribute("value").map_or(Ok(Point3::origin()), |value| Ok(Point3::from(value.array::<3>()?)))
        };
        let ends = [
            BodyPoint { body: bodies[0], at: point("drake:ball_constraint_p_AP")? },
            BodyPoint { body: bodies[1], at: point("drake:ball_constraint_p_BQ")? },
        ];
        self.close(element, ClosureKind::Point, ends, JointLaws::default());
        Ok(())
    }

    /// A frame by its name: a link, or a frame of Drake's.
    fn frame(&self, element: &XmlElement, name: &str) -> Fallible<(usize, Isometry3<f64>)> {
        match self.root.all("frame").find(|frame| frame.get("name") == Some(name)) {
            Some(frame) => Ok((self.body(frame, frame.must("link")?)?, origin(Some(frame))?)),
            None => Ok((self.body(element, name)?, Isometry3::identity())),
        }
    }

    fn bushing(&mut self, element: &'a XmlElement) -> Fallible<()> {
        let part =
            |key: &str| element.child(key).ok_or_else(|| element.refuse(format!("<{}> has no <{key}>", element.name)));
        let frames = [
            self.frame(element, part("drake:bushing_frameA")?.must("name")?)?,
            self.frame(element, part("drake:bushing_frameC")?.must("name")?)?,
        ];
        let three = |key: &str| -> Fallible<[f64; 3]> {
            part(key)?.attribute("value").map_or(Ok([0.0; 3]), |value| value.array::<3>())
        };
        let (force, force_damping) = (three("drake:bushing_force_stiffness")?, three("drake:bushing_force_damping")?);
        let (torque, torque_damping) =
            (three("drake:bushing_torque_stiffness")?, three("drake:bushing_torque_damping")?);
        let largest = |values: [f64; 3]| values.into_iter().fold(0.0, f64::max);
        for (name, values) in [("force stiffness", force), ("force damping", force_damping)] {
            if values.iter().any(|value| *value != values[0]) {
                self.report.approximated(format!("the {name} of a bushing (line {}) is {values:?} by axes; its largest is taken in both directions of the plane", element.place.line));
            }
        }
        self.model.bushings.push(SpatialBushing {
            name: element.get("name").unwrap_or_default().to_owned(),
            ends: frames.map(|(body, pose)| BodyPoint { body, at: Point3::from(pose.translation.vector) }),
            stiffness: largest(force),
            damping: largest(force_damping),
            torsion_stiffness: largest(torque),
            torsion_damping: largest(torque_damping),
        });
        Ok(())
    }

    /// Pairs of frames that coincide, as onshape-to-robot writes them.
    fn closing_frames(&mut self) {
        let links: Vec<(&str, &XmlElement)> =
            self.root.all("link").filter_map(|link| Some((link.attribute("name")?.value.as_str(), link))).collect();
        for (first, link) in &links {
            let Some(name) = first.strip_prefix("closing_").and_then(|rest| rest.strip_suffix("_1")) else { continue };
            let second = format!("closing_{name}_2");
            let bodies = (self.bodies.get(first).copied(), self.bodies.get(second.as_str()).copied());
            if let (Some(first), Some(second)) = bodies {
                let ends = [first, second].map(|body| BodyPoint { body, at: Point3::origin() });
                self.model.closures.push(Closure {
                    name: name.to_owned(),
                    place: link.place.clone(),
                    kind: ClosureKind::Point,
                    ends,
                    laws: JointLaws::default(),
                });
            }
        }
    }

    /// Interfaces of efforts become inputs.
    fn inputs(&mut self) -> Fallible<()> {
        for transmission in self.root.all("transmission") {
            let Some(joint) = transmission.child("joint") else { continue };
            let name = joint.must("name")?;
            let interfaces = transmission.children.iter().flat_map(|interface| interface.all("hardwareInterface"));
            let is_effort =
                interfaces.map(|interface| interface.text.to_lowercase()).any(|text| text.contains("effort"));
            if !is_effort {
                self.report.note(format!(
                    "the transmission of joint `{name}` does not have an effort interface: its controller is not in the file"
                ));
                continue;
            }
            let actuator = transmission.child("actuator");
            let reduction = actuator
                .and_then(|actuator| actuator.child("mechanicalReduction"))
                .or_else(|| transmission.child("mechanicalReduction"));
            let reduction = reduction.map_or(Ok(1.0), XmlElement::text_number)?;
            let index = self.joint_named(joint, name)?;
            let range = self.efforts.get(&index).map(|effort| [-effort / reduction.abs(), effort / reduction.abs()]);
            let called = actuator.and_then(|actuator| actuator.get("name")).unwrap_or(name);
            self.input(called, index, reduction, range);
        }
        for control in self.root.all("ros2_control") {
            for joint in control.all("joint") {
                let name = joint.must("name")?;
                let Some(effort) =
                    joint.all("command_interface").find(|interface| interface.get("name") == Some("effort"))
                else {
                    continue;
                };
                let index = self.joint_named(joint, name)?;
                let bound = |key: &str| {
                    effort
                        .all("param")
                        .find(|param| param.get("name") == Some(key))
                        .map(XmlElement::text_number)
                        .transpose()
                };
                let given = bound("min")?.zip(bound("max")?).map(|(min, max)| [min, max]);
                let range = given.or_else(|| self.efforts.get(&index).map(|effort| [-effort, *effort]));
                self.input(&format!("{name}_effort"), index, 1.0, range);
            }
        }
        Ok(())
    }

    fn input(&mut self, name: &str, joint: usize, gear: f64, control: Option<[f64; 2]>) {
        self.model.actuators.push(SpatialActuator {
            name: name.to_owned(),
            transmission: Transmission::Joints(vec![(joint, 1.0)]),
            gear,
            gain: 1.0,
            rate_gain: 0.0,
            bias: [0.0; 3],
            activation: Activation::Direct,
            control,
            force: None,
            start: 0.0,
        });
    }

    /// What else is in the file: without effect on the motion, or not known.
    fn others(&mut self, root: &XmlElement) {
        const KNOWN: &[&str] = &[
            "link",
            "joint",
            "transmission",
            "ros2_control",
            "loop_joint",
            "frame",
            "drake:ball_constraint",
            "drake:linear_bushing_rpy",
        ];
        const IDLE: &[&str] = &["gazebo", "material", "mujoco", "sensor", "visual", "collision"];
        for child in root.children.iter().filter(|child| !KNOWN.contains(&child.name.as_str())) {
            match IDLE.contains(&child.name.as_str()) {
                true => self.report.idle(format!("<{}>", child.name)),
                false if self.options.leaves_out(&[&child.name]) => self.report.left_out.push(child.called()),
                false => self
                    .report
                    .note(format!("unknown element <{}> (line {}) is left out", child.name, child.place.line)),
            }
        }
        for child in root.all("link").flat_map(|link| &link.children).filter(|child| child.name != "inertial") {
            self.report.idle(format!("<{}>", child.name));
        }
        let mut unread = Vec::new();
        let idle = ["calibration", "safety_controller"];
        for joint in root.all("joint") {
            joint.attribute("name").map(|attribute| attribute.value());
            joint.children.iter().filter(|child| idle.contains(&child.name.as_str())).for_each(XmlElement::mark);
        }
        root.all("link")
            .filter_map(|link| link.child("inertial"))
            .chain(root.all("joint"))
            .chain(root.all("loop_joint"))
            .for_each(|child| child.unread(&mut unread));
        for (called, attribute) in unread {
            self.report.note(format!("unknown attribute `{attribute}` of {called} is left out"));
        }
        const OF_JOINTS: &[&str] = &["origin", "parent", "child", "axis", "limit", "dynamics", "mimic"];
        for child in root
            .all("joint")
            .flat_map(|joint| &joint.children)
            .filter(|child| !OF_JOINTS.contains(&child.name.as_str()))
        {
            match idle.contains(&child.name.as_str()) {
                true => self.report.idle(format!("<{}>", child.name)),
                false => self.report.note(format!(
                    "unknown element <{}> (line {}) of a joint is left out",
                    child.name, child.place.line
                )),
            }
        }
    }
}

/// Mass, mass centre and inertia of a link.
fn mass(link: &XmlElement) -> Fallible<BodyMass> {
    let Some(inertial) = link.child("inertial") else { return Ok(BodyMass::default()) };
    let mass = inertial.child("mass").and_then(|mass_attribute| mass_attribute.attribute("value"));
    let mass =
        mass.ok_or_else(|| inertial.refuse(format!("the <inertial> of {} has no mass", link.called())))?.number()?;
    if mass < 0.0 {
        return Err(inertial.refuse(format!("the mass of {} is {mass}, but must not be negative", link.called())));
    }
    let part = |name: &str| optional(inertial.child("inertia"), name, 0.0);
    let (xx, yy, zz) = (part("ixx")?, part("iyy")?, part("izz")?);
    let (xy, xz, yz) = (part("ixy")?, part("ixz")?, part("iyz")?);
    let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    Ok(BodyMass { mass, centre: Vector3::zeros(), tensor }.moved(&origin(inertial.child("origin"))?))
}
