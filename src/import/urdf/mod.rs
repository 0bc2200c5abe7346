//! URDF, the robots of ROS, as a model in space; with what Gazebo, Isaac Sim, Drake and onshape-to-robot add to close loops.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::import::options::ImportOptions;
use crate::import::refusal::{Fallible, ImportRefusal};
use crate::import::report::ImportReport;
use crate::import::robot::{
    Activation, BodyMass, BodyPoint, Closure, ClosureKind, JointFollower, JointLaws, JointMotion, SpatialActuator,
    SpatialBody, SpatialJoint, SpatialModel, Transmission,
};
use crate::import::xml::XmlElement;
use crate::import::{drake, levels, sdf};

mod collisions;
mod known;

struct UrdfReader<'a> {
    root: &'a XmlElement,
    model: SpatialModel,
    options: &'a ImportOptions,
    report: &'a mut ImportReport,
    /// The body of each link.
    bodies: BTreeMap<&'a str, usize>,
    efforts: BTreeMap<usize, f64>,
    /// The link that is the ground, if the file has it.
    root_link: Option<&'a XmlElement>,
}

/// The model in a document.
///
/// # Errors
/// What is no tree of links, or cannot be imported.
pub fn read(root: &XmlElement, options: &ImportOptions, report: &mut ImportReport) -> Fallible<SpatialModel> {
    refuse_xacro(root)?;
    let name = root.get("name").unwrap_or_default();
    let model = SpatialModel::new("URDF", name, Vector3::new(0.0, 0.0, -9.81));
    levels::check(root, known::LEVELS, report);
    let mut reader =
        UrdfReader { root, model, options, report, bodies: BTreeMap::new(), efforts: BTreeMap::new(), root_link: None };
    reader.report.note("URDF has no gravity: 9.81 m/s2 along -z is assumed");
    reader.tree()?;
    reader.mimics()?;
    reader.closures()?;
    reader.inputs()?;
    reader.gazebo()?;
    reader.collisions()?;
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
        // Drake and Gazebo know a link `world` that no file has to name.
        let has_world = links.contains_key("world");
        let mut joints: BTreeMap<&str, Vec<&XmlElement>> = BTreeMap::new();
        let mut parents: BTreeMap<&str, &XmlElement> = BTreeMap::new();
        for joint in root.all("joint") {
            let [parent, child] = [self.link_of(joint, "parent")?, self.link_of(joint, "child")?];
            if let Some(name) = [parent, child].into_iter().find(|name| !links.contains_key(name) && *name != "world") {
                return Err(joint.refuse(format!("{}: there is no link `{name}`", joint.called())));
            }
            if let Some(other) = parents.insert(child, joint) {
                return Err(joint.refuse(format!("link `{child}` has two parents: {} and {}", other.called(), joint.called()))
                    .help("URDF is a tree; close the loop by a <gazebo><joint>, a <loop_joint> or a pair of frames closing_NAME_1, closing_NAME_2"));
            }
            joints.entry(parent).or_default().push(joint);
        }
        let implied = (!has_world && joints.contains_key("world")).then_some("world");
        let named = root.all("link").filter_map(|link| link.get("name"));
        let mut roots = implied.into_iter().chain(named).filter(|name| !parents.contains_key(name));
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
        if let Some(link) = links.get(first) {
            link.mark();
        }
        self.bodies.insert(first, 0);
        let mut next = vec![first];
        self.root_link = links.get(first).copied();
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

    /// Without `lower` and `upper`, as onshape-to-robot writes it, a joint has no limits; one of both is zero by default.
    fn limits(&mut self, joint: &'a XmlElement, spatial_joint: &mut SpatialJoint) -> Fallible<()> {
        let limit = joint.child("limit");
        let range = [optional(limit, "lower", 0.0)?, optional(limit, "upper", 0.0)?];
        let given = ["lower", "upper"].iter().any(|key| limit.is_some_and(|limit| limit.attribute(key).is_some()));
        if matches!(joint.get("type"), Some("revolute" | "prismatic")) && given {
            if range[0] >= range[1] {
                return Err(joint
                    .refuse(format!("{}: its limits {} to {} do not increase", joint.called(), range[0], range[1]))
                    .help("write `lower` below `upper`, or remove both"));
            }
            spatial_joint.laws.range = Some(range);
        } else if joint.get("type") != Some("continuous") && limit.is_some() {
            self.report.note(format!("{} has neither `lower` nor `upper`: it has no limits", joint.called()));
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

    /// What closes loops, by each convention.
    fn closures(&mut self) -> Fallible<()> {
        let root = self.root;
        for gazebo in root.all("gazebo") {
            for joint in gazebo.all("joint") {
                self.gazebo_joint(joint)?;
            }
        }
        for joint in root.all("loop_joint") {
            self.loop_joint(joint, ["link1", "link2"])?;
        }
        for joint in root.all("loop") {
            self.loop_joint(joint, ["predecessor", "successor"])?;
        }
        for element in &root.children {
            self.drake(element)?;
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
        let place = self.model.world(child) * pose;
        let into = self.model.world(parent).inverse() * place;
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
            "fixed" => ClosureKind::Weld(self.model.world(parent).inverse() * self.model.world(child)),
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
        let laws = joint.child("axis").map_or(Ok(JointLaws::default()), sdf::axis_laws)?;
        self.close(joint, kind, ends, laws);
        Ok(())
    }

    /// Two links whose frames a joint holds together: `<loop_joint>` of Isaac Sim, whose links have the pose themselves, and `<loop>` of URDF+.
    fn loop_joint(&mut self, joint: &'a XmlElement, keys: [&str; 2]) -> Fallible<()> {
        let mut ends = Vec::new();
        for key in keys {
            let reference =
                joint.child(key).ok_or_else(|| joint.refuse(format!("{} has no <{key}>", joint.called())))?;
            let pose = origin(reference.child("origin").or(Some(reference)))?;
            ends.push((self.body(joint, reference.must("link")?)?, pose));
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

    /// A body and a pose in it, by the name of a link or of a frame of Drake's.
    fn frame(&self, element: &XmlElement, name: &str) -> Fallible<(usize, Isometry3<f64>)> {
        match self.root.all("frame").find(|frame| frame.get("name") == Some(name)) {
            Some(frame) => Ok((self.body(frame, frame.must("link")?)?, origin(Some(frame))?)),
            None => Ok((self.body(element, name)?, Isometry3::identity())),
        }
    }

    /// What Drake and URDF+ add between bodies.
    fn drake(&mut self, element: &'a XmlElement) -> Fallible<()> {
        match drake::read(element, &|from: &XmlElement, name: &str| self.frame(from, name))? {
            Some(part) => part.add(&mut self.model, self.report),
            None => drake::refuse(element, self.options, self.report),
        }
        Ok(())
    }

    /// What Gazebo's extensions say of links and joints.
    fn gazebo(&mut self) -> Fallible<()> {
        for gazebo in self.root.all("gazebo") {
            let Some(name) = gazebo.get("reference") else { continue };
            let is =
                |key: &str, value: [&str; 2]| gazebo.child(key).is_some_and(|flag| value.contains(&flag.text.trim()));
            let joint = self.model.joints.iter().position(|joint| joint.name == name);
            if let Some(&body) = self.bodies.get(name)
                && (is("turnGravityOff", ["true", "1"]) || is("gravity", ["false", "0"]))
            {
                self.model.bodies[body].weightless = true;
            }
            if let (Some(joint), Some(stiffness)) = (joint, gazebo.child("springStiffness")) {
                let relaxed = gazebo.child("springReference").map_or(Ok(0.0), XmlElement::text_number)?;
                self.model.joints[joint].laws.spring = Some([stiffness.text_number()?, relaxed]);
            }
        }
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

    /// The inertia of a rotor behind its gear, as Drake writes it into a transmission.
    fn rotor(&mut self, transmission: &'a XmlElement, joint: usize) -> Fallible<()> {
        let Some(actuator) = transmission.child("actuator") else { return Ok(()) };
        let inertia = optional(actuator.child("drake:rotor_inertia"), "value", 0.0)?;
        let ratio = optional(actuator.child("drake:gear_ratio"), "value", 1.0)?;
        self.model.joints[joint].laws.armature += inertia * ratio * ratio;
        Ok(())
    }

    /// Interfaces of efforts become inputs.
    fn inputs(&mut self) -> Fallible<()> {
        for transmission in self.root.all("transmission") {
            let Some(joint) = transmission.child("joint") else { continue };
            let name = joint.must("name")?;
            if let Some(index) = self.model.joints.iter().position(|joint| joint.name == name) {
                self.rotor(transmission, index)?;
            }
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
            self.input((called, transmission), index, reduction, range);
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
                self.input((&format!("{name}_effort"), joint), index, 1.0, range);
            }
        }
        Ok(())
    }

    fn input(&mut self, (name, element): (&str, &XmlElement), joint: usize, gear: f64, control: Option<[f64; 2]>) {
        self.model.actuators.push(SpatialActuator {
            name: name.to_owned(),
            place: element.place.clone(),
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
