//! SDFormat, the models of Gazebo, as a model in space: frames by their names, axes by the version, joints that close loops.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::import::options::ImportOptions;
use crate::import::refusal::{Fallible, ImportRefusal};
use crate::import::report::ImportReport;
use crate::import::robot::{
    BodyMass, BodyPoint, Closure, ClosureKind, JointLaws, JointMotion, SpatialBody, SpatialJoint, SpatialModel,
};
use crate::import::xml::{self, XmlElement};
use crate::import::{Includes, drake, levels};

mod collisions;
mod couplings;
mod known;

/// Gravity of a world without one.
const GRAVITY: [f64; 3] = [0.0, 0.0, -9.8];
/// A limit this far out is none.
const UNLIMITED: f64 = 1e16;
/// How deep includes may be nested.
const DEEPEST: usize = 20;

/// What has a pose by a name: a model, a link, a frame, a joint.
struct SdfFrame<'a> {
    pose: Isometry3<f64>,
    /// The full name of the frame that the pose is in.
    relative_to: String,
    /// The full name of what it is attached to; a link is attached to itself.
    attached_to: String,
    element: &'a XmlElement,
}

struct SdfReader<'a> {
    version: f64,
    frames: BTreeMap<String, SdfFrame<'a>>,
    /// Links and joints with their full names and scopes, in the order of the file.
    links: Vec<(String, &'a XmlElement, bool)>,
    joints: Vec<(String, String, &'a XmlElement)>,
    /// The joints of the model by their full names.
    moving: BTreeMap<String, usize>,
    /// Elements of Drake's that act between bodies, with their scopes.
    drake: Vec<(String, &'a XmlElement)>,
    options: &'a ImportOptions,
    report: &'a mut ImportReport,
}

/// The model in a document.
///
/// # Errors
/// Frames that are not there or in a cycle, or what cannot be imported.
pub fn read(
    root: &mut XmlElement,
    options: &ImportOptions,
    includes: Includes,
    report: &mut ImportReport,
) -> Fallible<SpatialModel> {
    Expansion { options, includes, report }.of(root, 0)?;
    let version = root.attribute("version").map(|attribute| attribute.value()).unwrap_or("1.6");
    let version = version
        .parse::<f64>()
        .ok()
        .filter(|number| number.is_finite())
        .ok_or_else(|| root.refuse(format!("the version `{version}` is not a number")))?;
    // 1.10 is after 1.9.
    let version = match root.get("version").and_then(|version_text| version_text.split_once('.')) {
        Some(("1", minor)) => 1.0 + minor.parse::<f64>().unwrap_or(0.0) / 100.0,
        _ => version,
    };
    let worlds: Vec<&XmlElement> = root.all("world").collect();
    let (gravity, models, name) = match worlds[..] {
        [] => (Vector3::from(GRAVITY), root.all("model").collect::<Vec<_>>(), ""),
        [world] => {
            // Before version 1.6 it was one of the settings of the physics.
            let given = world.child("gravity").or_else(|| world.child("physics")?.child("gravity"));
            let gravity = vector(given)?.map_or(Vector3::from(GRAVITY), Vector3::from);
            (gravity, world.all("model").collect(), world.get("name").unwrap_or_default())
        }
        _ => return Err(root.refuse("it has more than one world").help("keep the one to import")),
    };
    if models.is_empty() {
        return Err(root.refuse("it has no model"));
    }
    levels::check(root, known::LEVELS, report);
    let mut reader = SdfReader {
        version,
        frames: BTreeMap::new(),
        links: Vec::new(),
        joints: Vec::new(),
        moving: BTreeMap::new(),
        drake: Vec::new(),
        options,
        report,
    };
    for model in &models {
        reader.model(model, "", false, 0)?;
    }
    for element in worlds {
        for joint in element.all("joint") {
            let full = joint.must("name")?.to_owned();
            reader.frame(&full, joint, "", None)?;
            reader.joints.push((full, String::new(), joint));
        }
        for frame in element.all("frame") {
            reader.frame(frame.must("name")?, frame, "", None)?;
        }
    }
    if worlds_absent(root) {
        reader.report.note("the file has no world: gravity of 9.8 m/s2 along -z, the default of SDF, is assumed");
    }
    // The first that moves: a world begins with its floor.
    let first = models.iter().find(|model| !is_static(model)).or(models.first());
    let name = first.and_then(|model| model.get("name")).unwrap_or(name).to_owned();
    reader.build(SpatialModel::new("SDF", &name, gravity))
}

fn is_static(model: &XmlElement) -> bool {
    model.child("static").is_some_and(|element| matches!(element.text.trim(), "true" | "1"))
}

fn worlds_absent(root: &XmlElement) -> bool {
    root.child("world").is_none()
}

/// Gazebo's floor: a plane at the height of its model, rough.
const GROUND_PLANE: &str = "<sdf version='1.6'><model name='ground_plane'><static>true</static><link name='link'><collision name='collision'>\
    <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>\
    <surface><friction><ode><mu>100</mu></ode></friction></surface></collision></link></model></sdf>";

/// Puts included models into the tree.
struct Expansion<'a> {
    options: &'a ImportOptions,
    includes: Includes<'a>,
    report: &'a mut ImportReport,
}

impl Expansion<'_> {
    fn of(&mut self, element: &mut XmlElement, depth: usize) -> Fallible<()> {
        let mut children = Vec::new();
        for mut child in std::mem::take(&mut element.children) {
            if child.name == "include" {
                children.extend(self.included(child, depth)?);
                continue;
            }
            if matches!(child.name.as_str(), "world" | "model") {
                self.of(&mut child, depth)?;
            }
            children.push(child);
        }
        element.children = children;
        Ok(())
    }

    /// The model that an include stands for; none of a light, or of what the user leaves out.
    fn included(&mut self, mut include: XmlElement, depth: usize) -> Fallible<Option<XmlElement>> {
        let uri = include
            .child("uri")
            .map(|element| element.text.trim().to_owned())
            .ok_or_else(|| include.refuse("<include> has no <uri>"))?;
        if depth >= DEEPEST {
            return Err(include.refuse(format!("`{uri}` is included {DEEPEST} deep: it includes itself")));
        }
        let path = uri.trim_start_matches("model://").trim_start_matches("file://");
        let found = [path.to_owned(), format!("{path}/model.sdf")]
            .into_iter()
            .find_map(|path| Some(((self.includes)(&path)?, path)));
        let usual = path.rsplit('/').next().unwrap_or(path).to_lowercase().replace(' ', "_");
        let (text, file) = match (found, usual.as_str()) {
            (Some((bytes, file)), _) => {
                (xml::decode(&bytes).map_err(|why| include.refuse(format!("`{file}`: {why}")))?, file)
            }
            (None, "sun") => {
                self.report.idle("<include> of `sun`, a light");
                return Ok(None);
            }
            (None, "ground_plane") => (GROUND_PLANE.to_owned(), "ground_plane".to_owned()),
            (None, _) => return self.missing(&include, &uri),
        };
        let mut included = xml::parse(&file, &text)?;
        self.of(&mut included, depth + 1)?;
        let mut models: Vec<XmlElement> =
            included.children.into_iter().filter(|candidate| candidate.name == "model").collect();
        let Some(mut model) = (models.len() == 1).then(|| models.remove(0)) else {
            return Err(include.refuse(format!("`{file}` must have one model, but has {}", models.len())));
        };
        // What the include says wins over the model.
        for key in ["pose", "static"] {
            if let Some(at) = include.children.iter().position(|candidate| candidate.name == key) {
                model.children.retain(|candidate| candidate.name != key);
                model.children.push(include.children.remove(at));
            }
        }
        if let Some(name) = include.child("name").map(|element| element.text.trim().to_owned())
            && let Some(attribute) = model.attributes.iter_mut().find(|attribute| attribute.name == "name")
        {
            attribute.value = name;
        }
        for child in include.children.iter().filter(|child| !matches!(child.name.as_str(), "uri" | "name")) {
            self.report.acting(&format!("<{}>", child.name), child.place.line, &format!("the include of `{uri}`"));
        }
        Ok(Some(model))
    }

    /// An included model that is not there may be anything.
    fn missing(&mut self, include: &XmlElement, uri: &str) -> Fallible<Option<XmlElement>> {
        let short = uri.rsplit('/').next().unwrap_or(uri);
        let why = format!("the included model `{uri}` cannot be read");
        if self.options.leaves_out(&[short, uri, "include"]) {
            self.report.left_out.push(format!("{why} (line {})", include.place.line));
            return Ok(None);
        }
        Err(include.refuse(why).help(format!(
            "--model-path FOLDER names the folder that has `{short}`; --leave-out {short} imports the file without it"
        )))
    }
}

fn vector(element: Option<&XmlElement>) -> Fallible<Option<[f64; 3]>> {
    let Some(element) = element else { return Ok(None) };
    match element.text_numbers()?[..] {
        [x, y, z] => Ok(Some([x, y, z])),
        _ => Err(element.refuse(format!("<{}> is `{}`, but must be three numbers", element.name, element.text.trim()))),
    }
}

fn number(element: Option<&XmlElement>, default: f64) -> Fallible<f64> {
    element.map_or(Ok(default), XmlElement::text_number)
}

/// A pose in Euler angles or with a quaternion.
fn pose(element: Option<&XmlElement>) -> Fallible<Isometry3<f64>> {
    let Some(element) = element else { return Ok(Isometry3::identity()) };
    let unit = if element.get("degrees") == Some("true") { 1f64.to_radians() } else { 1.0 };
    match (element.get("rotation_format").unwrap_or("euler_rpy"), &element.text_numbers()?[..]) {
        (_, []) => Ok(Isometry3::identity()),
        ("euler_rpy", &[x, y, z, roll, pitch, yaw]) => {
            let turn = UnitQuaternion::from_euler_angles(roll * unit, pitch * unit, yaw * unit);
            Ok(Isometry3::from_parts(Translation3::new(x, y, z), turn))
        }
        ("quat_xyzw", &[x, y, z, i, j, k, w]) => {
            let turn = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-12);
            let turn = turn.ok_or_else(|| element.refuse("the quaternion of a <pose> has the length zero"))?;
            Ok(Isometry3::from_parts(Translation3::new(x, y, z), turn))
        }
        _ => Err(element.refuse(format!(
            "<pose> is `{}`, but must be six numbers, or seven with rotation_format=\"quat_xyzw\"",
            element.text.trim()
        ))),
    }
}

fn joined(scope: &str, name: &str) -> String {
    if scope.is_empty() { name.to_owned() } else { format!("{scope}::{name}") }
}

/// A joint of a model: its full name, and that of the model.
#[derive(Clone, Copy)]
struct NamedJoint<'n, 'a> {
    name: &'n str,
    scope: &'n str,
    element: &'a XmlElement,
}

impl<'a> SdfReader<'a> {
    /// A frame with the name that others call it by.
    fn frame(&mut self, full: &str, element: &'a XmlElement, scope: &str, own_default: Option<String>) -> Fallible<()> {
        let posed = element.child("pose");
        let reference = |name: &str| match name {
            "" => None,
            "__model__" => Some(scope.to_owned()),
            "world" => Some(String::new()),
            name => Some(joined(scope, name)),
        };
        let given = posed.and_then(|posed| posed.get("relative_to")).and_then(reference);
        let attached = element.get("attached_to").and_then(reference);
        let default = own_default.unwrap_or_else(|| scope.to_owned());
        let relative_to = given.or_else(|| attached.clone()).unwrap_or_else(|| default.clone());
        let attached_to = match element.name.as_str() {
            "link" => full.to_owned(),
            _ => attached.unwrap_or(default),
        };
        let frame = SdfFrame { pose: pose(posed)?, relative_to, attached_to, element };
        if self.frames.insert(full.to_owned(), frame).is_some() {
            return Err(element.refuse(format!("two frames, links, joints or models have the name `{full}`")));
        }
        Ok(())
    }

    fn model(&mut self, model: &'a XmlElement, scope: &str, fixed: bool, depth: usize) -> Fallible<()> {
        if depth > DEEPEST {
            return Err(model.refuse("models are nested too deep"));
        }
        let full = joined(scope, model.must("name")?);
        if let Some(frame_attribute) = model.attribute("placement_frame") {
            return Err(ImportRefusal::new("a model that is placed by one of its frames is not imported")
                .at(&frame_attribute.place)
                .help("give the pose of the model itself"));
        }
        let fixed = fixed || is_static(model);
        self.frame(&full, model, scope, Some(scope.to_owned()))?;
        for child in &model.children {
            match child.name.as_str() {
                "link" => {
                    let name = joined(&full, child.must("name")?);
                    self.frame(&name, child, &full, None)?;
                    self.links.push((name, child, fixed));
                }
                "frame" => self.frame(&joined(&full, child.must("name")?), child, &full, None)?,
                "joint" => {
                    let relative_to = child
                        .child("child")
                        .map(|relative_to| relative_to.text.trim())
                        .ok_or_else(|| child.refuse(format!("{} has no <child>", child.called())))?;
                    let name = joined(&full, child.must("name")?);
                    self.frame(&name, child, &full, Some(joined(&full, relative_to)))?;
                    self.joints.push((name, full.clone(), child));
                }
                "model" => self.model(child, &full, fixed, depth + 1)?,
                _ => self.drake(child, &full),
            }
        }
        Ok(())
    }

    /// What Drake adds acts between bodies, which are read first.
    fn drake(&mut self, element: &'a XmlElement, scope: &str) {
        match drake::is_read(&element.name) {
            true => self.drake.push((scope.to_owned(), element)),
            false => drake::refuse(element, self.options, self.report),
        }
    }

    /// The pose of a frame in the world.
    fn world(&self, name: &str, from: &XmlElement) -> Fallible<Isometry3<f64>> {
        let (mut pose, mut at) = (Isometry3::identity(), name.to_owned());
        for _ in 0..=self.frames.len() {
            if at.is_empty() {
                return Ok(pose);
            }
            let frame = self
                .frames
                .get(&at)
                .ok_or_else(|| from.refuse(format!("{}: there is no link or frame `{at}`", from.called())))?;
            (pose, at) = (frame.pose * pose, frame.relative_to.clone());
        }
        let frame = self.frames.get(&at);
        let element = frame.map_or(from, |frame| frame.element);
        let other = frame.map_or(name, |frame| &frame.relative_to);
        Err(element.refuse(format!("the poses of `{at}` and `{other}` are relative to each other")))
    }

    /// The link that a frame moves with; none is the world.
    fn link_of(&self, name: &str, from: &XmlElement) -> Fallible<Option<usize>> {
        let mut at = name.to_owned();
        for _ in 0..=self.frames.len() {
            if at.is_empty() {
                return Ok(None);
            }
            if let Some(link) = self.links.iter().position(|(link_name, ..)| *link_name == at) {
                return Ok(Some(link));
            }
            // A model moves with its first link.
            if let Some(frame) = self.frames.get(&at)
                && frame.element.name == "model"
            {
                let inside = format!("{at}::");
                return Ok(self.links.iter().position(|(link_name, ..)| link_name.starts_with(&inside)));
            }
            at = self
                .frames
                .get(&at)
                .ok_or_else(|| from.refuse(format!("{}: there is no link or frame `{at}`", from.called())))?
                .attached_to
                .clone();
        }
        Err(from.refuse(format!("frame `{name}` is attached to itself")))
    }

    /// Links become bodies: the first joint of a child is in the tree, others close loops.
    fn build(&mut self, mut model: SpatialModel) -> Fallible<SpatialModel> {
        let count = self.links.len();
        let worlds =
            self.links.iter().map(|(name, element, _)| self.world(name, element)).collect::<Fallible<Vec<_>>>()?;
        let mut ends = Vec::new();
        for (name, scope, joint) in self.joints.iter().filter(|(.., joint)| !is_gearbox(joint)) {
            let end = |key: &str| -> Fallible<Option<usize>> {
                let end = joint.child(key).ok_or_else(|| joint.refuse(format!("{} has no <{key}>", joint.called())))?;
                match end.text.trim() {
                    "world" => Ok(None),
                    "__model__" => self.link_of(scope, joint),
                    text => self.link_of(&joined(scope, text), joint),
                }
            };
            ends.push((name.clone(), scope.clone(), *joint, end("parent")?, end("child")?));
        }
        // The joint by which each link hangs in the tree.
        let mut hung: Vec<Option<usize>> = vec![None; count];
        let mut closing = Vec::new();
        for (index, (.., parent, child)) in ends.iter().enumerate() {
            let mut above = *parent;
            let mut cycle = false;
            while let Some(link) = above {
                cycle |= Some(link) == *child;
                above = if cycle { None } else { hung[link].and_then(|joint: usize| ends[joint].3) };
            }
            match child {
                Some(child) if hung[*child].is_none() && !cycle => hung[*child] = Some(index),
                _ => closing.push(index),
            }
        }
        let bodies = self.bodies(&mut model, &hung, &ends.iter().map(|end| end.3).collect::<Vec<_>>(), &worlds)?;
        for (link, joint) in hung.iter().enumerate() {
            let Some(joint) = joint.filter(|_| !self.links[link].2) else { continue };
            let (name, scope, element, ..) = ends[joint].clone();
            self.joint(&mut model, NamedJoint { name: &name, scope: &scope, element }, bodies[link])?;
        }
        for (body, link) in bodies.iter().zip(0..).filter(|(_, link)| hung[*link].is_none() && !self.links[*link].2) {
            let (name, element, _) = &self.links[link];
            let mut free = SpatialJoint::new(&format!("{name}_free"), &element.place, JointMotion::Free, *body);
            free.free = Some((model.bodies[*body].pose, Vector3::zeros(), Vector3::zeros()));
            model.bodies[*body].joints.push(model.joints.len());
            model.joints.push(free);
        }
        for index in closing {
            let (name, scope, element, parent, child) = ends[index].clone();
            let of = |link: Option<usize>| link.map_or(0, |link| bodies[link]);
            self.close(&mut model, NamedJoint { name: &name, scope: &scope, element }, [of(parent), of(child)])?;
        }
        self.followers(&mut model)?;
        self.gearboxes(&mut model, &bodies)?;
        for (scope, element) in std::mem::take(&mut self.drake) {
            let frame = |from: &XmlElement, name: &str| self.frame_in_body(&model, &bodies, (&scope, name), from);
            if let Some(part) = drake::read(element, &frame)? {
                part.add(&mut model, self.report);
            }
        }
        self.collisions(&mut model, &bodies)?;
        self.soft_stops();
        Ok(model)
    }

    /// What is said of laws that have a counterpart only in part.
    fn soft_stops(&mut self) {
        for (.., joint) in &self.joints {
            let limits = joint.all("axis").filter_map(|axis| axis.child("limit"));
            if limits
                .flat_map(|limit| &limit.children)
                .any(|part| matches!(part.name.as_str(), "stiffness" | "dissipation"))
            {
                self.report.approximated("stiffness and dissipation of limits, by exact stops without rebound");
            }
        }
        for (_, link, _) in self.links.iter().filter(|(_, link, _)| link.child("velocity_decay").is_some()) {
            self.report.left_out.push(format!("`velocity_decay` of {}", link.called()));
        }
    }

    /// The body of a link or frame of a scope, and its pose there.
    fn frame_in_body(
        &self,
        model: &SpatialModel,
        bodies: &[usize],
        (scope, name): (&str, &str),
        from: &XmlElement,
    ) -> Fallible<(usize, Isometry3<f64>)> {
        if name == "world" {
            return Ok((0, Isometry3::identity()));
        }
        let full = joined(scope, name);
        let body = self.link_of(&full, from)?.map_or(0, |link| bodies[link]);
        Ok((body, model.world(body).inverse() * self.world(&full, from)?))
    }

    /// Bodies from the roots outwards; returns the body of each link.
    fn bodies(
        &self,
        model: &mut SpatialModel,
        hung: &[Option<usize>],
        parents: &[Option<usize>],
        worlds: &[Isometry3<f64>],
    ) -> Fallible<Vec<usize>> {
        let mut bodies = vec![0; hung.len()];
        let mut placed = vec![false; hung.len()];
        let many = self.links.iter().filter(|(name, ..)| name.matches("::").count() == 1).count() != self.links.len();
        loop {
            let ready = |link: &usize| {
                !placed[*link] && hung[*link].and_then(|joint| parents[joint]).is_none_or(|parent| placed[parent])
            };
            let Some(link) = (0..hung.len()).find(ready) else { break };
            let (name, element, fixed) = &self.links[link];
            let parent = hung[link]
                .and_then(|joint| parents[joint])
                .filter(|_| !fixed)
                .map(|parent| (bodies[parent], worlds[parent]));
            let (parent, before) = parent.unwrap_or((0, Isometry3::identity()));
            bodies[link] = model.bodies.len();
            placed[link] = true;
            // With one flat model, links keep their own names.
            let short = name.rsplit("::").next().unwrap_or(name);
            model.bodies.push(SpatialBody {
                name: if many { name.replace("::", "_") } else { short.to_owned() },
                place: Some(element.place.clone()),
                parent,
                pose: before.inverse() * worlds[link],
                mass: mass(element)?,
                weightless: element
                    .child("gravity")
                    .is_some_and(|gravity| matches!(gravity.text.trim(), "false" | "0")),
                joints: Vec::new(),
                points: Vec::new(),
            });
        }
        Ok(bodies)
    }

    /// An axis of a joint in the frame of a body, by the version of the file.
    fn axis(
        &self,
        NamedJoint { name, scope, element: joint }: NamedJoint<'_, 'a>,
        axis: &'a XmlElement,
        body: &Isometry3<f64>,
    ) -> Fallible<Vector3<f64>> {
        let xyz = axis.child("xyz");
        let direction = vector(xyz)?.map_or(Vector3::z(), Vector3::from);
        let in_model =
            axis.child("use_parent_model_frame").is_some_and(|flag| matches!(flag.text.trim(), "true" | "1"));
        let frame = match xyz.and_then(|xyz| xyz.get("expressed_in")) {
            Some("__model__") => scope.to_owned(),
            Some("world") => String::new(),
            Some("") => name.to_owned(),
            Some(other) => joined(scope, other),
            None if self.version < 1.045 || in_model => scope.to_owned(),
            None => name.to_owned(),
        };
        let turn = self.world(&frame, joint)?.rotation;
        let direction = direction
            .try_normalize(1e-12)
            .ok_or_else(|| axis.refuse(format!("{}: its axis has the length zero", joint.called())))?;
        Ok(body.rotation.inverse() * (turn * direction))
    }

    fn joint(&mut self, model: &mut SpatialModel, named: NamedJoint<'_, 'a>, body: usize) -> Fallible<()> {
        let NamedJoint { name, element, .. } = named;
        let kind = match element.must("type")? {
            "revolute" | "continuous" => JointMotion::Hinge,
            "prismatic" => JointMotion::Slide,
            "ball" => JointMotion::Ball,
            "fixed" => return Ok(()),
            "screw" => JointMotion::Other("screw"),
            "universal" => JointMotion::Other("universal"),
            "revolute2" => JointMotion::Other("revolute2"),
            other => return Err(element.refuse(format!("{} has the unknown type `{other}`", element.called()))),
        };
        let short = name.rsplit("::").next().unwrap_or(name);
        let known = |name: &str| model.joints.iter().any(|joint| joint.name == name);
        let called = if known(short) { name.replace("::", "_") } else { short.to_owned() };
        let mut joint = SpatialJoint::new(&called, &element.place, kind, body);
        let world = model.world(body);
        joint.anchor = world.inverse() * Point3::from(self.world(name, element)?.translation.vector);
        if let Some(axis) = element.child("axis") {
            joint.axis = self.axis(named, axis, &world)?;
            joint.laws = axis_laws(axis)?;
            joint.laws.armature = rotor(element)?;
            joint.start = number(axis.child("initial_position"), 0.0)?;
        } else if matches!(kind, JointMotion::Hinge | JointMotion::Slide) {
            return Err(element.refuse(format!("{} has no <axis>", element.called())));
        }
        self.moving.insert(name.to_owned(), model.joints.len());
        model.bodies[body].joints.push(model.joints.len());
        model.joints.push(joint);
        Ok(())
    }

    fn close(
        &mut self,
        model: &mut SpatialModel,
        named: NamedJoint<'_, 'a>,
        [parent, child]: [usize; 2],
    ) -> Fallible<()> {
        let NamedJoint { name, element, .. } = named;
        let place = self.world(name, element)?;
        let at =
            |body: usize| BodyPoint { body, at: model.world(body).inverse() * Point3::from(place.translation.vector) };
        let axis = |this: &Self| -> Fallible<Vector3<f64>> {
            let axis =
                element.child("axis").ok_or_else(|| element.refuse(format!("{} has no <axis>", element.called())))?;
            this.axis(named, axis, &model.world(parent))
        };
        let kind = match element.must("type")? {
            "revolute" | "continuous" => ClosureKind::Hinge(axis(self)?),
            "prismatic" => ClosureKind::Slide(axis(self)?),
            "ball" => ClosureKind::Point,
            "fixed" => ClosureKind::Weld(model.world(parent).inverse() * model.world(child)),
            other => {
                return Err(element.refuse(format!(
                    "{} closes a loop and is of type `{other}`, which a planar mechanism cannot have",
                    element.called()
                )));
            }
        };
        let ends = match &kind {
            ClosureKind::Weld(pose) => [
                BodyPoint { body: parent, at: Point3::from(pose.translation.vector) },
                BodyPoint { body: child, at: Point3::origin() },
            ],
            _ => [at(parent), at(child)],
        };
        let short = name.rsplit("::").next().unwrap_or(name).to_owned();
        let laws = element.child("axis").map_or(Ok(JointLaws::default()), axis_laws)?;
        model.closures.push(Closure { name: short, place: element.place.clone(), kind, ends, laws });
        Ok(())
    }
}

fn is_gearbox(joint: &XmlElement) -> bool {
    joint.get("type") == Some("gearbox")
}

/// Drake's rotor: its inertia by the square of the ratio of its gear.
fn rotor(joint: &XmlElement) -> Fallible<f64> {
    let (inertia, ratio) =
        (number(joint.child("drake:rotor_inertia"), 0.0)?, number(joint.child("drake:gear_ratio"), 1.0)?);
    Ok(inertia * ratio * ratio)
}

/// What acts along an axis.
///
/// # Errors
/// What is not a number, limits that do not increase.
pub fn axis_laws(axis: &XmlElement) -> Fallible<JointLaws> {
    let dynamics = |key: &str| number(axis.child("dynamics").and_then(|dynamics| dynamics.child(key)), 0.0);
    let stiffness = dynamics("spring_stiffness")?;
    Ok(JointLaws {
        damping: dynamics("damping")?,
        friction: dynamics("friction")?,
        armature: 0.0,
        spring: (stiffness != 0.0).then_some([stiffness, dynamics("spring_reference")?]),
        range: range(axis)?,
    })
}

/// The limits of an axis; far out there are none.
fn range(axis: &XmlElement) -> Fallible<Option<[f64; 2]>> {
    let Some(limit) = axis.child("limit") else { return Ok(None) };
    let bound = |key: &str, none: f64| -> Fallible<f64> {
        let Some(bound) = limit.child(key) else { return Ok(none) };
        match bound.text.trim().to_lowercase().trim_start_matches(['+', '-']) {
            "inf" | "infinity" => Ok(none),
            _ => bound.text_number(),
        }
    };
    let [low, high] = [bound("lower", -UNLIMITED)?, bound("upper", UNLIMITED)?];
    match (low > -UNLIMITED, high < UNLIMITED) {
        (false, false) => Ok(None),
        _ if low < high => Ok(Some([low, high])),
        _ => Err(limit.refuse(format!("the limits {low} to {high} do not increase"))),
    }
}

/// Mass, mass centre and inertia of a link; without them those that SDF gives a link.
fn mass(link: &XmlElement) -> Fallible<BodyMass> {
    let inertial = link.child("inertial");
    let mass = number(inertial.and_then(|inertial| inertial.child("mass")), 1.0)?;
    if mass <= 0.0 {
        return Err(link.refuse(format!("the mass of {} is {mass}, but must be positive", link.called())));
    }
    let inertia = inertial.and_then(|inertial| inertial.child("inertia"));
    let part = |name: &str, default: f64| number(inertia.and_then(|inertia| inertia.child(name)), default);
    let (xx, yy, zz) = (part("ixx", 1.0)?, part("iyy", 1.0)?, part("izz", 1.0)?);
    let (xy, xz, yz) = (part("ixy", 0.0)?, part("ixz", 0.0)?, part("iyz", 0.0)?);
    let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    Ok(BodyMass { mass, centre: Vector3::zeros(), tensor }
        .moved(&pose(inertial.and_then(|inertial| inertial.child("pose")))?))
}
