//! The planar reduction: bodies merged, axes signed, components along the normal dropped.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use super::closing::{self, ClosedStart};
use super::plane::{self, MotionPlane};
use super::{BodyMass, BodyPoint, ClosureKind, JointMotion, SpatialJoint, SpatialModel, write};
use crate::import::options::ImportOptions;
use crate::import::refusal::{Fallible, FilePlace, ImportRefusal};
use crate::import::report::ImportReport;

/// Points of a loop that are apart by no more of the size are closed as a matter of course: the digits of a converter.
const OPEN: f64 = 1e-3;
/// Loops that are open by more of the size are not closed: which way they close would be a guess.
const ASSEMBLED: f64 = 0.1;
/// The most joints of a scene that is imported.
const MOST: usize = 1000;
/// Products of inertia with the normal, relative to the largest moment, with which a free body stays in the plane.
const PRINCIPAL: f64 = 1e-6;

/// A rigid body of the scene, in the reference configuration. The first is the ground.
#[derive(Clone, Debug, Default)]
pub struct PlanarLink {
    /// As the file has it; may be empty.
    pub name: String,
    /// Where the frame of its points is in the world.
    pub origin: [f64; 2],
    pub mass: f64,
    pub inertia: f64,
    /// Its mass centre, in the world.
    pub centre: [f64; 2],
    pub weightless: bool,
    /// Names and places in the world.
    pub points: Vec<(String, [f64; 2])>,
}

/// What a joint coordinate moves; `at` and `along` are those of the reference configuration.
#[derive(Clone, Copy, Debug)]
pub enum PlanarCoordinate {
    Turn {
        parent: usize,
        child: usize,
        at: [f64; 2],
        /// Of the scene's angle against the file's coordinate.
        sign: f64,
        joint: usize,
    },
    Slide {
        parent: usize,
        child: usize,
        at: [f64; 2],
        along: [f64; 2],
        joint: usize,
    },
    FreeX(usize),
    FreeY(usize),
    FreeAngle(usize),
}

impl PlanarCoordinate {
    pub fn child(&self) -> usize {
        match *self {
            PlanarCoordinate::Turn { child, .. } | PlanarCoordinate::Slide { child, .. } => child,
            PlanarCoordinate::FreeX(child) | PlanarCoordinate::FreeY(child) | PlanarCoordinate::FreeAngle(child) => {
                child
            }
        }
    }

    pub fn turns(&self) -> bool {
        matches!(self, PlanarCoordinate::Turn { .. } | PlanarCoordinate::FreeAngle(_))
    }

    pub fn joint(&self) -> Option<usize> {
        match *self {
            PlanarCoordinate::Turn { joint, .. } | PlanarCoordinate::Slide { joint, .. } => Some(joint),
            PlanarCoordinate::FreeX(_) | PlanarCoordinate::FreeY(_) | PlanarCoordinate::FreeAngle(_) => None,
        }
    }
}

/// A link and a place in the world, in the reference configuration.
pub type LinkPoint = (usize, [f64; 2]);

#[derive(Clone, Copy, Debug)]
pub enum PlanarClosure {
    Pin([LinkPoint; 2]),
    /// With the second's angle against the first.
    Weld([LinkPoint; 2], f64),
    Slide([LinkPoint; 2], [f64; 2]),
}

impl PlanarClosure {
    pub fn ends(&self) -> [LinkPoint; 2] {
        match *self {
            PlanarClosure::Pin(ends) | PlanarClosure::Weld(ends, _) | PlanarClosure::Slide(ends, _) => ends,
        }
    }
}

/// A coordinate that follows another, by their places among the coordinates.
#[derive(Clone, Copy, Debug)]
pub struct PlanarFollower {
    pub joint: usize,
    pub leader: usize,
    pub offset: f64,
    pub ratio: f64,
    /// Its place in the file's list.
    pub source: usize,
}

/// The mechanism in the plane.
pub struct PlanarModel<'a> {
    pub file: &'a SpatialModel,
    pub plane: MotionPlane,
    pub gravity: [f64; 2],
    pub links: Vec<PlanarLink>,
    pub coordinates: Vec<PlanarCoordinate>,
    /// Values and rates at the start, of the file.
    pub starts: Vec<(f64, f64)>,
    pub closures: Vec<PlanarClosure>,
    /// Their places in the file's list.
    pub closure_sources: Vec<usize>,
    pub followers: Vec<PlanarFollower>,
    /// The coordinate of each joint of the file, if it is one.
    pub coordinate_of: Vec<Option<usize>>,
    /// The link of each body of the file; none of what the import leaves out.
    pub link_of: Vec<Option<usize>>,
    /// The poses of the file's bodies in the reference configuration.
    pub world: Vec<Isometry3<f64>>,
    /// How large it is.
    pub size: f64,
}

impl PlanarModel<'_> {
    pub fn at(&self, point: &Point3<f64>) -> [f64; 2] {
        self.plane.components(&point.coords)
    }

    /// A point of a body of the file.
    pub fn point(&self, point: &BodyPoint) -> Option<LinkPoint> {
        Some((self.link_of[point.body]?, self.at(&(self.world[point.body] * point.at))))
    }

    /// The place of a joint of the file among the coordinates.
    pub fn coordinate_of(&self, joint: usize) -> Option<usize> {
        self.coordinate_of.get(joint).copied().flatten()
    }
}

/// The scene of a robot; what cannot be imported is in the report.
pub fn scene(
    name: &str,
    mut model: SpatialModel,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Option<String> {
    name_joints(&mut model);
    if let Err(refusal) = prepare(&mut model, options, report) {
        report.refuse(refusal);
        return None;
    }
    let joints = model.moving_joints().count();
    if joints > MOST {
        let refusal = ImportRefusal::new(format!("it has {joints} joints, but a scene has at most {MOST}"));
        report.refuse(refusal.help("--root BODY imports a part of the robot; --lock JOINT,... holds joints"));
        return None;
    }
    let world = poses(&model);
    let plane = match plane::find(&model, &world, options) {
        Ok(plane) => plane,
        Err(refusal) => {
            report.refuse(refusal);
            return None;
        }
    };
    plane::outside(&model, &world, &plane, options).into_iter().for_each(|refusal| report.refuse(refusal));
    if !report.refused.is_empty() {
        return None;
    }
    let planar = reduce(&model, plane, world, options, report);
    if !report.refused.is_empty() {
        return None;
    }
    let start = closed(&planar, report)?;
    Some(write::scene(name, &planar, &start, options, report))
}

/// A joint without a name gets the number that it has in the file, so that messages and options can name it. A body without a name has that of its joint, if the
/// file gives it one.
fn name_joints(model: &mut SpatialModel) {
    for index in 1..model.bodies.len() {
        let body = &model.bodies[index];
        let unnamed = |joint: &usize| model.joints[*joint].name.is_empty();
        if body.name.is_empty() && !body.joints.is_empty() && body.joints.iter().all(unnamed) {
            model.bodies[index].name = format!("body_{index}");
        }
    }
    for index in 0..model.joints.len() {
        if model.joints[index].name.is_empty() {
            let free = (index + 1..).map(|number| format!("joint_{number}"));
            let name = free.into_iter().find(|name| model.joints.iter().all(|joint| joint.name != *name));
            model.joints[index].name = name.unwrap_or_default();
        }
    }
}

/// Roots, locked joints and held joints, so that the rest need not know them.
fn prepare(model: &mut SpatialModel, options: &ImportOptions, report: &mut ImportReport) -> Fallible<()> {
    if let Some(root) = &options.root {
        take_root(model, root, report)?;
    }
    for name in &options.lock {
        let joint = model.joints.iter().position(|joint| joint.name == *name);
        let Some(joint) = joint else {
            let names: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
            return Err(ImportRefusal::new(format!("--lock {name}: the file has no such joint"))
                .help(format!("its joints are {}", names.join(", "))));
        };
        let value = model.joints[joint].start;
        lock(model, joint, value)?;
        report.note(format!("joint `{name}` is locked at {value:?} (--lock)"));
    }
    hold_followers(model, report)?;
    join_limits(model, report)?;
    for joint in &mut model.joints {
        let Some([low, high]) = joint.laws.range else { continue };
        let inside = joint.start.clamp(low, high);
        if inside != joint.start {
            report.approximated(format!(
                "joint `{}` starts at {:.6}, outside its limits {:.6} to {:.6}: it is moved to the hard stop",
                joint.name,
                joint.start + joint.zero,
                low + joint.zero,
                high + joint.zero
            ));
            joint.start = inside;
        }
    }
    Ok(())
}

/// Joints that follow nothing stay where they are held.
fn hold_followers(model: &mut SpatialModel, report: &mut ImportReport) -> Fallible<()> {
    let locked: Vec<bool> = model.joints.iter().enumerate().map(|(index, _)| is_locked(model, index)).collect();
    let starts: Vec<f64> = model.joints.iter().map(|joint| joint.start).collect();
    let mut kept = Vec::new();
    for follower in std::mem::take(&mut model.followers) {
        let leader = follower.leader.filter(|&leader| follower.ratio != 0.0 && !locked[leader]);
        let held =
            follower.leader.filter(|&leader| locked[leader]).map_or(0.0, |leader| follower.ratio * starts[leader]);
        match leader {
            Some(leader) if locked[follower.joint] => {
                let value = (starts[follower.joint] - follower.offset) / follower.ratio;
                lock(model, leader, value)?;
            }
            Some(_) => kept.push(follower),
            None if locked[follower.joint] => {}
            None => {
                let value = follower.offset + held;
                lock(model, follower.joint, value)?;
                let called = match follower.name.is_empty() {
                    true => format!("the coupling in line {}", follower.place.line),
                    false => format!("`{}`", follower.name),
                };
                report.note(format!("{called} holds joint `{}` at {value:?}", model.joints[follower.joint].name));
            }
        }
    }
    model.followers = kept;
    Ok(())
}

/// The limits of a joint that follows another become limits of the other: two stops that hold one motion at once would share their force by chance.
fn join_limits(model: &mut SpatialModel, report: &mut ImportReport) -> Fallible<()> {
    // As often as there are followers, so that limits come through chains of them.
    for _ in 0..model.followers.len() {
        for follower in &model.followers {
            let Some(leader) = follower.leader else { continue };
            let Some(range) = model.joints[follower.joint].laws.range.take() else { continue };
            let ends = range.map(|end| (end - follower.offset) / follower.ratio);
            let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            let [least, most] = model.joints[leader].laws.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            let joined = [least.max(low), most.min(high)];
            if joined[0] >= joined[1] {
                let [one, other] = [follower.joint, leader].map(|joint| &model.joints[joint].name);
                let message = format!("joint `{one}` follows `{other}`, and their limits leave no way to move");
                return Err(ImportRefusal::new(message).at(&follower.place));
            }
            model.joints[leader].laws.range = Some(joined);
            report.exact("limit of a joint that follows another, as one of the other");
        }
    }
    Ok(())
}

fn is_locked(model: &SpatialModel, joint: usize) -> bool {
    !model.bodies[model.joints[joint].body].joints.contains(&joint)
}

/// Only the subtree of a body, which becomes the ground.
fn take_root(model: &mut SpatialModel, root: &str, report: &mut ImportReport) -> Fallible<()> {
    let Some(root) = model.bodies.iter().position(|body| body.name == root) else {
        let names: Vec<&str> = model.bodies[1..].iter().map(|body| body.name.as_str()).collect();
        return Err(ImportRefusal::new(format!("--root {root}: the file has no such body"))
            .help(format!("its bodies are {}", names.join(", "))));
    };
    let mut inside = vec![false; model.bodies.len()];
    for index in 1..model.bodies.len() {
        inside[index] = index == root || inside[model.bodies[index].parent];
    }
    let all = model.bodies.len() - 1;
    let kept = inside.iter().filter(|is_inside| **is_inside).count();
    model.bodies[root].pose = poses(model)[root];
    model.bodies[root].parent = 0;
    model.bodies[root].joints.clear();
    for (index, body) in model.bodies.iter_mut().enumerate().skip(1).filter(|(index, _)| !inside[*index]) {
        // Outside, a body is fixed and has no mass: it is a part of the ground that nothing uses.
        (body.joints, body.mass) = (Vec::new(), BodyMass::default());
        body.name = format!("{} (outside {index})", body.name);
    }
    let used = |point: &BodyPoint| point.body == 0 || inside[point.body];
    let joints: Vec<bool> = model.joints.iter().map(|joint| inside[joint.body] && joint.body != root).collect();
    model.closures.retain(|closure| closure.ends.iter().all(used));
    model.springs.retain(|spring| spring.course.points().all(used));
    model.bushings.retain(|bushing| bushing.ends.iter().all(used));
    model.followers.retain(|follower| joints[follower.joint] && follower.leader.is_none_or(|leader| joints[leader]));
    model.tendons.retain(|tendon| tendon.terms.iter().all(|(joint, _)| joints[*joint]));
    model.actuators.retain(|actuator| match &actuator.transmission {
        super::Transmission::Joints(terms) => terms.iter().all(|(joint, _)| joints[*joint]),
        super::Transmission::Along(course) => course.points().all(used),
    });
    model.contacts.retain(|contact| match &contact.kind {
        super::ContactKind::Plane { body, .. } => inside[*body],
        super::ContactKind::Balls(balls, _) => balls.iter().all(used),
    });
    report.note(format!("only the subtree of `{}` is imported: {kept} of {all} bodies", model.bodies[root].name));
    Ok(())
}

/// Holds a joint at a value: its motion becomes a part of the body's pose, as the joints before it see it.
fn lock(model: &mut SpatialModel, joint: usize, value: f64) -> Fallible<()> {
    let joint_data = &model.joints[joint];
    let body = joint_data.body;
    let Some(at) = model.bodies[body].joints.iter().position(|&other| other == joint) else { return Ok(()) };
    let moved = match (joint_data.kind, &joint_data.free) {
        (JointMotion::Hinge | JointMotion::Slide, _) => joint_data.motion(value),
        (JointMotion::Free | JointMotion::Planar, Some((pose, ..))) => {
            model.bodies[body].pose = *pose;
            Isometry3::identity()
        }
        (JointMotion::Free | JointMotion::Planar | JointMotion::Ball | JointMotion::Other(_), _) => {
            Isometry3::identity()
        }
    };
    let back = moved.inverse();
    for index in 0..at {
        let before = model.bodies[body].joints[index];
        let before = &mut model.joints[before];
        (before.anchor, before.axis) = (back * before.anchor, back * before.axis);
    }
    model.bodies[body].pose *= moved;
    model.bodies[body].joints.remove(at);
    Ok(())
}

/// Poses of all bodies in the world, in the reference configuration.
fn poses(model: &SpatialModel) -> Vec<Isometry3<f64>> {
    let mut world: Vec<Isometry3<f64>> = vec![Isometry3::identity()];
    for body in &model.bodies[1..] {
        world.push(world[body.parent] * body.pose);
    }
    world
}

/// Bodies become links, joints coordinates.
fn reduce<'a>(
    model: &'a SpatialModel,
    plane: MotionPlane,
    world: Vec<Isometry3<f64>>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> PlanarModel<'a> {
    let mut planar = PlanarModel {
        file: model,
        plane,
        gravity: plane.components(&model.gravity).map(|part| if part.abs() < 1e-12 { 0.0 } else { part }),
        links: vec![PlanarLink { name: "ground".to_owned(), ..PlanarLink::default() }],
        coordinates: Vec::new(),
        starts: Vec::new(),
        closures: Vec::new(),
        closure_sources: Vec::new(),
        followers: Vec::new(),
        coordinate_of: vec![None; model.joints.len()],
        link_of: vec![Some(0); model.bodies.len()],
        world,
        size: 1.0,
    };
    let mut masses: Vec<BodyMass> = vec![BodyMass::default()];
    for (index, body) in model.bodies.iter().enumerate().skip(1) {
        let parent = planar.link_of[body.parent].unwrap_or(0);
        let link =
            if body.joints.is_empty() { parent } else { planar.chain(index, parent, options, report, &mut masses) };
        planar.link_of[index] = Some(link);
        masses[link] = masses[link].with(&body.mass.moved(&planar.world[index]));
        planar.links[link].weightless |= body.weightless && link != 0 && body.mass.mass > 0.0;
        let at = planar.at(&Point3::from(planar.world[index].translation.vector));
        if body.joints.is_empty() && !body.name.is_empty() && link != 0 {
            planar.links[link].points.push((body.name.clone(), at));
        }
        for (name, point) in &body.points {
            let at = planar.at(&(planar.world[index] * point));
            planar.links[link].points.push((name.clone(), at));
        }
    }
    planar.set_masses(&masses, report);
    planar.size = planar.extent();
    planar.join(report);
    planar
}

impl PlanarModel<'_> {
    /// The links that the joints of a body move, one each; the last is the body.
    fn chain(
        &mut self,
        body: usize,
        parent: usize,
        options: &ImportOptions,
        report: &mut ImportReport,
        masses: &mut Vec<BodyMass>,
    ) -> usize {
        let body_data = &self.file.bodies[body];
        let origin = self.at(&Point3::from(self.world[body].translation.vector));
        let named = match body_data.name.is_empty() {
            true => body_data.joints.last().map_or(String::new(), |&joint| self.file.joints[joint].name.clone()),
            false => body_data.name.clone(),
        };
        if self.is_free(body, parent) {
            let link = self.add_link(&named, origin, masses);
            self.free(body, link, options, report);
            return link;
        }
        let (mut parent, last) = (parent, body_data.joints.len() - 1);
        for (index, &joint) in body_data.joints.iter().enumerate() {
            let name = match index == last {
                true => named.clone(),
                false => format!("{named}_{}", index + 1),
            };
            let link = self.add_link(&name, origin, masses);
            let file = &self.file.joints[joint];
            let axis = self.world[body] * file.axis;
            let at = self.at(&(self.world[body] * file.anchor));
            let coordinate = match file.kind {
                JointMotion::Slide => {
                    let [x, y] = self.plane.components(&axis);
                    let length = x.hypot(y);
                    PlanarCoordinate::Slide { parent, child: link, at, along: [x / length, y / length], joint }
                }
                JointMotion::Ball => {
                    report.approximated(format!("ball joint `{}` turns in the plane only (--in-plane)", file.name));
                    PlanarCoordinate::Turn { parent, child: link, at, sign: 1.0, joint }
                }
                _ => {
                    let sign = if axis.dot(&self.plane.normal) < 0.0 { -1.0 } else { 1.0 };
                    PlanarCoordinate::Turn { parent, child: link, at, sign, joint }
                }
            };
            self.coordinate_of[joint] = Some(self.coordinates.len());
            self.coordinates.push(coordinate);
            self.starts.push((file.start, file.rate));
            parent = link;
        }
        parent
    }

    fn add_link(&mut self, name: &str, origin: [f64; 2], masses: &mut Vec<BodyMass>) -> usize {
        self.links.push(PlanarLink { name: name.to_owned(), origin, ..PlanarLink::default() });
        masses.push(BodyMass::default());
        self.links.len() - 1
    }

    /// Is it free in the plane: by a free joint, or by two slides and a hinge at which nothing acts?
    fn is_free(&self, body: usize, parent: usize) -> bool {
        let joints: Vec<&SpatialJoint> =
            self.file.bodies[body].joints.iter().map(|&joint| &self.file.joints[joint]).collect();
        if let [joint] = joints[..]
            && matches!(joint.kind, JointMotion::Free | JointMotion::Planar)
        {
            return true;
        }
        let kinds = joints.iter().map(|joint| joint.kind).collect::<Vec<_>>();
        let three = kinds == [JointMotion::Slide, JointMotion::Slide, JointMotion::Hinge];
        let used = |joint: &usize| self.acts_on(*joint);
        parent == 0
            && three
            && joints[0].axis.cross(&joints[1].axis).norm() > 0.999
            && joints.iter().all(|joint| joint.is_plain())
            && !self.file.bodies[body].joints.iter().any(used)
    }

    /// Does anything of the file use the coordinate of a joint?
    fn acts_on(&self, joint: usize) -> bool {
        let in_terms = |terms: &[(usize, f64)]| terms.iter().any(|(index, _)| *index == joint);
        let actuators = self.file.actuators.iter().any(|actuator| match &actuator.transmission {
            super::Transmission::Joints(terms) => in_terms(terms),
            super::Transmission::Along(_) => false,
        });
        let followers =
            self.file.followers.iter().any(|follower| follower.joint == joint || follower.leader == Some(joint));
        actuators || followers || self.file.tendons.iter().any(|tendon| in_terms(&tendon.terms))
    }

    /// The start of a body without joint: its displacement and angle from the reference configuration.
    fn free(&mut self, body: usize, link: usize, options: &ImportOptions, report: &mut ImportReport) {
        let body_data = &self.file.bodies[body];
        let joints: Vec<&SpatialJoint> = body_data.joints.iter().map(|&joint| &self.file.joints[joint]).collect();
        self.coordinates.extend([
            PlanarCoordinate::FreeX(link),
            PlanarCoordinate::FreeY(link),
            PlanarCoordinate::FreeAngle(link),
        ]);
        if let [first, second, hinge] = joints[..] {
            let sign = (self.world[body] * hinge.axis).dot(&self.plane.normal).signum();
            let axes = [first, second].map(|joint| self.plane.components(&(self.world[body] * joint.axis)));
            let along = |value: [f64; 2]| [0, 1].map(|part| value[0] * axes[0][part] + value[1] * axes[1][part]);
            // The hinge turns about its anchor, which the slides have moved.
            let arm = self.plane.components(&(self.world[body] * (-hinge.anchor.coords)));
            let (angle, omega) = (sign * hinge.start, sign * hinge.rate);
            let (sine, cosine) = angle.sin_cos();
            let arm_now = [cosine * arm[0] - sine * arm[1], sine * arm[0] + cosine * arm[1]];
            let (at, rate) = (along([first.start, second.start]), along([first.rate, second.rate]));
            let place = [0, 1].map(|part| at[part] + arm_now[part] - arm[part]);
            let speed = [rate[0] - omega * arm_now[1], rate[1] + omega * arm_now[0]];
            self.starts.extend([(place[0], speed[0]), (place[1], speed[1]), (angle, omega)]);
            return;
        }
        let [joint] = joints[..] else { return };
        let parent = self.world[body_data.parent];
        let (pose, velocity, omega) = joint.free.unwrap_or((body_data.pose, Vector3::zeros(), Vector3::zeros()));
        let now = parent * pose;
        let moved = self.plane.components(&(now.translation.vector - self.world[body].translation.vector));
        let turn = now.rotation * self.world[body].rotation.inverse();
        let turned = turn * self.plane.x;
        let angle = self.plane.y.dot(&turned).atan2(self.plane.x.dot(&turned));
        let speed = self.plane.components(&velocity);
        let spin = self.plane.normal.dot(&omega);
        self.starts.extend([(moved[0], speed[0]), (moved[1], speed[1]), (angle, spin)]);
        let called = if body_data.name.is_empty() {
            "a free body".to_owned()
        } else {
            format!("free body `{}`", body_data.name)
        };
        let out = [
            (joint.kind == JointMotion::Free, self.gravity_out(), "gravity has a component along the normal"),
            (true, turn.rotation_between_normal(&self.plane), "its initial orientation is out of the plane"),
            (
                joint.kind == JointMotion::Free,
                self.plane.normal.dot(&velocity).abs() > 1e-9,
                "its initial velocity is out of the plane",
            ),
            (
                joint.kind == JointMotion::Free,
                (omega - self.plane.normal * spin).norm() > 1e-9,
                "its initial angular velocity is out of the plane",
            ),
        ];
        for why in out.into_iter().filter(|(counts, is, _)| *counts && *is).map(|(.., why)| why) {
            self.keep_in_plane(&joint.place, &called, why, options, report);
        }
        if joint.kind == JointMotion::Free {
            self.check_principal(body, &joint.place, &called, options, report);
        }
    }

    fn gravity_out(&self) -> bool {
        self.plane.normal.dot(&self.file.gravity).abs() > 1e-9 * self.file.gravity.norm().max(1e-9)
    }

    fn keep_in_plane(
        &self,
        place: &FilePlace,
        called: &str,
        why: &str,
        options: &ImportOptions,
        report: &mut ImportReport,
    ) {
        match options.in_plane {
            true => report.approximated(format!("{called} moves in the plane only (--in-plane; {why})")),
            false => report.refuse(
                ImportRefusal::new(format!("{called} would leave the plane {}: {why}", self.plane.called()))
                    .at(place)
                    .help("--in-plane keeps it in the plane; --plane xy, xz or yz chooses another plane"),
            ),
        }
    }

    /// A free body with a product of inertia turns out of the plane.
    fn check_principal(
        &self,
        body: usize,
        place: &FilePlace,
        called: &str,
        options: &ImportOptions,
        report: &mut ImportReport,
    ) {
        let tensor = self.file.bodies[body].mass.moved(&self.world[body]).tensor;
        let of_normal = tensor * self.plane.normal;
        let beside = of_normal - self.plane.normal * self.plane.normal.dot(&of_normal);
        if beside.norm() > PRINCIPAL * tensor.norm() {
            let why = format!("its product of inertia with the normal is {:.3e} kg.m2", beside.norm());
            self.keep_in_plane(place, called, &why, options, report);
        }
    }

    /// Mass, moment of inertia about the normal, mass centre.
    fn set_masses(&mut self, masses: &[BodyMass], report: &mut ImportReport) {
        let normal = self.plane.normal;
        for (index, mass) in masses.iter().enumerate().skip(1) {
            let inertia = normal.dot(&(mass.tensor * normal));
            let (centre, link) = (self.plane.components(&mass.centre), &mut self.links[index]);
            (link.mass, link.inertia) = (mass.mass, inertia.max(0.0));
            link.centre = if mass.mass > 0.0 { centre } else { link.origin };
            let moments = mass.tensor.symmetric_eigenvalues();
            let largest = moments.max();
            if moments.sum() < 2.0 * largest * (1.0 - 1e-6) && largest > 0.0 {
                report.note(format!(
                    "body `{}`: one of its moments of inertia is larger than the sum of the others, which no rigid body has; only the one about the normal is used",
                    self.links[index].name
                ));
            }
        }
        let (mut moves, mut carries) = (vec![false; self.links.len()], vec![false; self.links.len()]);
        for coordinate in &self.coordinates {
            moves[coordinate.child()] = true;
            if let PlanarCoordinate::Turn { parent, .. } | PlanarCoordinate::Slide { parent, .. } = *coordinate {
                carries[parent] = true;
            }
        }
        for index in 1..self.links.len() {
            if moves[index] && !carries[index] && self.links[index].mass <= 0.0 && self.links[index].inertia <= 0.0 {
                let body = self.link_of.iter().rposition(|link| *link == Some(index)).unwrap_or(0);
                let refusal = ImportRefusal::new(format!(
                    "body `{}` moves, but has no mass: it needs an inertial",
                    self.links[index].name
                ));
                let place = self.file.bodies[body].place.clone();
                report.refuse(match place {
                    Some(place) => refusal.at(&place),
                    None => refusal,
                });
            }
        }
    }

    /// The diagonal of what the joints and mass centres span.
    fn extent(&self) -> f64 {
        let joints = self.coordinates.iter().filter_map(|coordinate| match *coordinate {
            PlanarCoordinate::Turn { at, .. } | PlanarCoordinate::Slide { at, .. } => Some(at),
            _ => None,
        });
        let places: Vec<[f64; 2]> = joints.chain(self.links[1..].iter().map(|link| link.centre)).collect();
        let span = |part: usize| {
            let values = places.iter().map(|place| place[part]);
            values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
        };
        let size = span(0).hypot(span(1));
        if size.is_finite() && size > 0.0 { size } else { 1.0 }
    }

    /// Closures and couplings.
    fn join(&mut self, report: &mut ImportReport) {
        for (source, closure) in self.file.closures.iter().enumerate() {
            let [Some(first), Some(second)] = closure.ends.each_ref().map(|end| self.point(end)) else { continue };
            if first.0 == second.0 {
                report.note(format!("{} joins parts of one body and is left out", closure.called()));
                continue;
            }
            let ends = [first, second];
            self.closure_sources.push(source);
            self.closures.push(match &closure.kind {
                ClosureKind::Point | ClosureKind::Hinge(_) => PlanarClosure::Pin(ends),
                ClosureKind::Slide(axis) => {
                    let [x, y] = self.plane.components(&(self.world[closure.ends[0].body] * axis));
                    let length = x.hypot(y);
                    PlanarClosure::Slide(ends, [x / length, y / length])
                }
                ClosureKind::Weld(pose) => {
                    let bodies = closure.ends.each_ref().map(|end| self.world[end.body].rotation);
                    let turn = (bodies[0] * pose.rotation * bodies[1].inverse()) * self.plane.x;
                    PlanarClosure::Weld(ends, self.plane.y.dot(&turn).atan2(self.plane.x.dot(&turn)))
                }
            });
            self.report_offset(closure, report);
        }
        for (source, follower) in self.file.followers.iter().enumerate() {
            let leader = follower.leader.and_then(|leader| self.coordinate_of(leader));
            if let (Some(joint), Some(leader)) = (self.coordinate_of(follower.joint), leader) {
                let (offset, ratio) = (follower.offset, follower.ratio);
                self.followers.push(PlanarFollower { joint, leader, offset, ratio, source });
            }
        }
    }

    /// Points that are apart along the normal are no gap in the plane, but MuJoCo pulls them together.
    fn report_offset(&self, closure: &super::Closure, report: &mut ImportReport) {
        let [a, b] = closure.ends.each_ref().map(|end| self.world[end.body] * end.at);
        let apart = self.plane.normal.dot(&(b - a)).abs();
        if apart > OPEN * self.size {
            report.approximated(format!(
                "{} joins points that are {apart:.4} m apart along the normal, which loads the hinges in space and not in the plane",
                closure.called()
            ));
        }
    }
}

/// Whether a rotation takes the normal elsewhere.
trait Tilts {
    fn rotation_between_normal(&self, plane: &MotionPlane) -> bool;
}

impl Tilts for UnitQuaternion<f64> {
    fn rotation_between_normal(&self, plane: &MotionPlane) -> bool {
        (self * plane.normal).cross(&plane.normal).norm() > 1e-6
    }
}

/// The start with closed loops; loops that are open in the reference configuration are refused with both points.
fn closed(planar: &PlanarModel, report: &mut ImportReport) -> Option<ClosedStart> {
    let start = closing::close(planar);
    let values: Vec<f64> = planar.starts.iter().map(|start| start.0).collect();
    let reference = vec![0.0; values.len()];
    let gaps = [values, reference.clone()].map(|values| gaps(planar, &values));
    let nearest = if gaps[0].iter().sum::<f64>() <= gaps[1].iter().sum() { &gaps[0] } else { &gaps[1] };
    if start.open < 1e-9 && nearest.iter().all(|gap| *gap <= ASSEMBLED * planar.size) {
        for (index, gap) in nearest.iter().enumerate().filter(|(_, gap)| **gap > OPEN * planar.size) {
            let file = &planar.file.closures[planar.closure_sources[index]];
            report.approximated(format!(
                "{} has a gap of {gap:.3e} m in the file: it is assembled from there, which moves dependent joint coordinates by at most {:.3e}",
                file.called(),
                start.moved
            ));
        }
        if start.moved > 1e-9 {
            report.note(format!(
                "the loops are not closed exactly where the file starts: closing them changes dependent joint coordinates by at most {:.3e}",
                start.moved
            ));
        }
        if start.contradiction > 1e-6 {
            report.note(format!(
                "the velocities at the start contradict the loops by {:.3e}: those of independent joints are taken",
                start.contradiction
            ));
        }
        return Some(start);
    }
    let poses = closing::poses(planar, &reference);
    for (index, gap) in nearest.iter().enumerate().filter(|(_, gap)| **gap > 1e-9 * planar.size) {
        let at = |(link, at): LinkPoint| closing::place_of(&poses[link], planar.links[link].origin, at);
        let [a, b] = planar.closures[index].ends().map(at);
        let file = &planar.file.closures[planar.closure_sources[index]];
        let ([ax, ay], [bx, by]) = (a, b);
        report.refuse(
            ImportRefusal::new(format!(
                "{} has a gap of {gap:.3e} m: its points are at ({ax:.6}, {ay:.6}) and ({bx:.6}, {by:.6}), and its assembly mode would be a guess",
                file.called()
            ))
            .at(&file.place)
            .help("correct the positions of the bodies, or start from a keyframe in which the loop is closed"),
        );
    }
    if report.refused.is_empty() {
        report.refuse(ImportRefusal::new(format!(
            "the couplings of joints contradict each other at the start by {:.3e}",
            start.open
        )));
    }
    None
}

/// How far the points of each closure are apart.
fn gaps(planar: &PlanarModel, values: &[f64]) -> Vec<f64> {
    let poses = closing::poses(planar, values);
    let at = |(link, at): LinkPoint| closing::place_of(&poses[link], planar.links[link].origin, at);
    let gap = |closure: &PlanarClosure| {
        let [a, b] = closure.ends().map(at);
        let gap = [b[0] - a[0], b[1] - a[1]];
        match closure {
            PlanarClosure::Slide(_, along) => (gap[1] * along[0] - gap[0] * along[1]).abs(),
            PlanarClosure::Pin(_) | PlanarClosure::Weld(..) => gap[0].hypot(gap[1]),
        }
    };
    planar.closures.iter().map(gap).collect()
}
