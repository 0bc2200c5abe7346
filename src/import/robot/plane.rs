//! The plane that a robot moves in: found from the axes of its hinges, or given. Parallel axes in one configuration are enough, since planar motion keeps them
//! parallel.

use nalgebra::{Isometry3, Vector3};

use super::{ClosureKind, JointMotion, SpatialModel};
use crate::import::options::{ImportOptions, WorldPlane};
use crate::import::refusal::{Fallible, ImportRefusal};

/// How far axes may be off parallel, or off the plane: CAD programs write 1e-6 to 1e-16.
const PARALLEL: f64 = 1e-4;

/// The plane of motion: its axes as those of the scene, and its normal.
#[derive(Clone, Copy, Debug)]
pub struct MotionPlane {
    pub x: Vector3<f64>,
    pub y: Vector3<f64>,
    pub normal: Vector3<f64>,
}

impl MotionPlane {
    pub fn of(plane: WorldPlane) -> Self {
        let [x, y] = match plane {
            WorldPlane::Xy => [Vector3::x(), Vector3::y()],
            WorldPlane::Xz => [Vector3::x(), Vector3::z()],
            WorldPlane::Yz => [Vector3::y(), Vector3::z()],
        };
        MotionPlane { x, y, normal: x.cross(&y) }
    }

    /// With this normal, up to its sign. Along an axis of the world the scene's axes are the other two; else the scene's y is against gravity's part in the
    /// plane, or the most upright axis of the world, and its x has a positive component along the world's x.
    fn across(normal: Vector3<f64>, gravity: Vector3<f64>) -> Self {
        let along = |axis: Vector3<f64>| normal.cross(&axis).norm() < PARALLEL;
        for (axis, plane) in
            [(Vector3::z(), WorldPlane::Xy), (Vector3::y(), WorldPlane::Xz), (Vector3::x(), WorldPlane::Yz)]
        {
            if along(axis) {
                return MotionPlane::of(plane);
            }
        }
        let within = |vector: Vector3<f64>| vector - normal * normal.dot(&vector);
        let up = within(-gravity);
        let y = match up.norm() > PARALLEL * gravity.norm() && up.norm() > 0.0 {
            true => up.normalize(),
            false => within(Vector3::z()).normalize(),
        };
        let x = y.cross(&normal);
        let x = if x.x < 0.0 { -x } else { x };
        MotionPlane { x, y, normal: x.cross(&y) }
    }

    pub fn components(&self, vector: &Vector3<f64>) -> [f64; 2] {
        [self.x.dot(vector), self.y.dot(vector)]
    }

    /// Its name: `x-z`, or the normal.
    pub fn called(&self) -> String {
        let axis = |vector: &Vector3<f64>| {
            ["x", "y", "z"]
                .into_iter()
                .zip(vector.iter())
                .find(|(_, part)| (**part - 1.0).abs() < PARALLEL)
                .map(|(name, _)| name)
        };
        match (axis(&self.x), axis(&self.y)) {
            (Some(x), Some(y)) => format!("{x}-{y}"),
            _ => format!("across ({:.4}, {:.4}, {:.4})", self.normal.x, self.normal.y, self.normal.z),
        }
    }

    /// The angle of a vector to the normal, deg.
    fn tilt(&self, vector: &Vector3<f64>) -> f64 {
        self.normal.cross(vector).norm().atan2(self.normal.dot(vector).abs()).to_degrees()
    }
}

/// Finds the plane of the joints that are left.
///
/// # Errors
/// Nothing says which plane it is.
pub fn find(model: &SpatialModel, world: &[Isometry3<f64>], options: &ImportOptions) -> Fallible<MotionPlane> {
    if let Some(plane) = options.plane {
        return Ok(MotionPlane::of(plane));
    }
    let axes = |kind: JointMotion| {
        let joints = model.moving_joints().filter(move |joint| joint.kind == kind);
        joints.map(|joint| world[joint.body] * joint.axis).collect::<Vec<_>>()
    };
    let hinges = axes(JointMotion::Hinge);
    if let Some(first) = hinges.first() {
        return Ok(MotionPlane::across(*first, model.gravity));
    }
    if let Some(first) = axes(JointMotion::Planar).first() {
        return Ok(MotionPlane::across(*first, model.gravity));
    }
    let slides = axes(JointMotion::Slide);
    let other = model.moving_joints().find_map(|joint| match joint.kind {
        JointMotion::Other(kind) => Some((joint, kind)),
        _ => None,
    });
    if let (true, Some((joint, kind))) = (slides.is_empty(), other) {
        let message = format!("joint `{}` is of type `{kind}`, which a planar mechanism cannot have", joint.name);
        return Err(ImportRefusal::new(message)
            .at(&joint.place)
            .help(format!("--lock {} locks it; --root BODY imports a part of the robot", joint.name)));
    }
    let Some(first) = slides.first() else {
        return Err(ImportRefusal::new("nothing moves in one plane: it has no hinge and no slide").help(
            "name the plane with --plane xy, xz or yz; a free body also needs --in-plane unless gravity and its inertia keep it there",
        ));
    };
    let across = slides.iter().map(|other| first.cross(other)).find(|normal| normal.norm() > PARALLEL);
    let with_gravity = first.cross(&model.gravity);
    let upright = [Vector3::z(), Vector3::y(), Vector3::x()].into_iter().map(|axis| first.cross(&axis));
    let upright = upright.max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
    let normal = across.or(Some(with_gravity).filter(|normal| normal.norm() > PARALLEL * model.gravity.norm()));
    Ok(MotionPlane::across(normal.unwrap_or(upright).normalize(), model.gravity))
}

/// What does not move in the plane, each by its name with the angle.
pub fn outside(
    model: &SpatialModel,
    world: &[Isometry3<f64>],
    plane: &MotionPlane,
    options: &ImportOptions,
) -> Vec<ImportRefusal> {
    let mut refused = Vec::new();
    let lock = |name: &str| format!("--lock {name} locks it; --root BODY imports a part of the robot");
    for joint in model.moving_joints() {
        let axis = world[joint.body] * joint.axis;
        let called = format!("joint `{}`", joint.name);
        let [x, y, z] = [axis.x, axis.y, axis.z];
        let tilt = plane.tilt(&axis);
        let refusal = match joint.kind {
            JointMotion::Hinge | JointMotion::Planar if tilt.to_radians() > PARALLEL => Some(format!(
                "{called} turns about ({x:.4}, {y:.4}, {z:.4}), {tilt:.2} deg off the normal of the plane {}",
                plane.called()
            )),
            JointMotion::Slide if (90.0 - tilt).to_radians() > PARALLEL => Some(format!(
                "{called} slides along ({x:.4}, {y:.4}, {z:.4}), {:.2} deg out of the plane {}",
                90.0 - tilt,
                plane.called()
            )),
            JointMotion::Ball if !options.in_plane => {
                Some(format!("{called} is a ball joint, which turns out of the plane"))
            }
            JointMotion::Other(kind) => {
                Some(format!("{called} is of type `{kind}`, which a planar mechanism cannot have"))
            }
            JointMotion::Hinge | JointMotion::Slide | JointMotion::Planar | JointMotion::Ball | JointMotion::Free => {
                None
            }
        };
        if let Some(message) = refusal {
            let ball = if joint.kind == JointMotion::Ball { "--in-plane lets it turn in the plane only; " } else { "" };
            refused.push(ImportRefusal::new(message).at(&joint.place).help(format!("{ball}{}", lock(&joint.name))));
        }
    }
    for closure in &model.closures {
        let ClosureKind::Hinge(axis) = &closure.kind else { continue };
        let tilt = plane.tilt(&(world[closure.ends[0].body] * axis));
        if tilt.to_radians() > PARALLEL {
            let message = format!(
                "{} is closed by a hinge that turns {tilt:.2} deg off the normal of the plane",
                closure.called()
            );
            refused
                .push(ImportRefusal::new(message).at(&closure.place).help("--root BODY imports a part of the robot"));
        }
    }
    refused
}
