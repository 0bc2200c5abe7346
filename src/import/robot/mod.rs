//! A robot in space, as its file has it, and its planar reduction as a scene.
//!
//! Readers of MJCF, URDF and SDF make a [`SpatialModel`]; [`planar`] finds the plane and reduces it; [`write`] makes the scene. Coordinates count from the
//! reference configuration, in which scene angles are zero and bodies unturned.

mod closing;
mod contacts;
mod couplings;
mod forces;
mod planar;
mod plane;
mod solids;
mod write;

pub use planar::scene;
pub use solids::{FRICTION, Solid, SolidShape, across};

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, UnitVector3, Vector3};

use super::refusal::FilePlace;

/// What a file describes, before any plane is chosen. SI.
#[derive(Clone, Debug)]
pub struct SpatialModel {
    /// The format, as its users call it.
    pub format: &'static str,
    pub name: String,
    pub gravity: Vector3<f64>,
    /// The first is the world; parents come before their children.
    pub bodies: Vec<SpatialBody>,
    pub joints: Vec<SpatialJoint>,
    pub closures: Vec<Closure>,
    pub followers: Vec<JointFollower>,
    pub tendons: Vec<Tendon>,
    pub springs: Vec<PointSpring>,
    pub bushings: Vec<SpatialBushing>,
    pub actuators: Vec<SpatialActuator>,
    pub contacts: Vec<SpatialContact>,
}

impl SpatialModel {
    /// The joints that move something: neither locked nor outside of what is imported.
    pub fn moving_joints(&self) -> impl Iterator<Item = &SpatialJoint> {
        let joints = self.joints.iter().enumerate();
        joints.filter(|(index, joint)| self.bodies[joint.body].joints.contains(index)).map(|(_, joint)| joint)
    }

    pub fn new(format: &'static str, name: &str, gravity: Vector3<f64>) -> Self {
        let world = SpatialBody {
            name: "world".to_owned(),
            place: None,
            parent: 0,
            pose: Isometry3::identity(),
            mass: BodyMass::default(),
            weightless: false,
            joints: Vec::new(),
            points: Vec::new(),
        };
        SpatialModel {
            format,
            name: name.to_owned(),
            gravity,
            bodies: vec![world],
            joints: Vec::new(),
            closures: Vec::new(),
            followers: Vec::new(),
            tendons: Vec::new(),
            springs: Vec::new(),
            bushings: Vec::new(),
            actuators: Vec::new(),
            contacts: Vec::new(),
        }
    }
}

#[derive(Clone, Debug)]
pub struct SpatialBody {
    /// May be empty.
    pub name: String,
    pub place: Option<FilePlace>,
    pub parent: usize,
    /// In the parent's frame, in the reference configuration.
    pub pose: Isometry3<f64>,
    pub mass: BodyMass,
    /// Does gravity not act on it?
    pub weightless: bool,
    /// Its joints against the parent, in their order; none: it is fixed.
    pub joints: Vec<usize>,
    /// Named points of interest, in its frame.
    pub points: Vec<(String, Point3<f64>)>,
}

/// Mass, mass centre in the frame of the body, and the tensor of inertia about the mass centre in its axes.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMass {
    pub mass: f64,
    pub centre: Vector3<f64>,
    pub tensor: Matrix3<f64>,
}

impl Default for BodyMass {
    fn default() -> Self {
        BodyMass { mass: 0.0, centre: Vector3::zeros(), tensor: Matrix3::zeros() }
    }
}

impl BodyMass {
    /// The same in another frame, in which its own is at a pose.
    pub fn moved(&self, pose: &Isometry3<f64>) -> BodyMass {
        let turn = pose.rotation.to_rotation_matrix();
        BodyMass {
            mass: self.mass,
            centre: pose.transform_point(&Point3::from(self.centre)).coords,
            tensor: turn.matrix() * self.tensor * turn.matrix().transpose(),
        }
    }

    /// Both as one body, in the same frame; by the parallel axis theorem.
    pub fn with(&self, other: &BodyMass) -> BodyMass {
        let mass = self.mass + other.mass;
        if mass <= 0.0 {
            return BodyMass { mass, centre: self.centre, tensor: self.tensor + other.tensor };
        }
        let centre = (self.centre * self.mass + other.centre * other.mass) / mass;
        let about = |mass: &BodyMass| mass.tensor + steiner(mass.mass, mass.centre - centre);
        BodyMass { mass, centre, tensor: about(self) + about(other) }
    }
}

/// m (r.r - r r'): what a mass at r adds to the tensor of inertia.
pub fn steiner(mass: f64, r: Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * r.dot(&r) - r * r.transpose()) * mass
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointMotion {
    Hinge,
    Slide,
    /// Six degrees of freedom.
    Free,
    Ball,
    /// Free in the plane across its axis.
    Planar,
    /// One that no planar motion has, by its name.
    Other(&'static str),
}

/// A joint between a body and its parent. Its coordinate counts from the reference configuration: `q - zero` of the file.
#[derive(Clone, Debug)]
pub struct SpatialJoint {
    /// May be empty.
    pub name: String,
    pub place: FilePlace,
    pub kind: JointMotion,
    pub body: usize,
    /// In the frame of the body.
    pub anchor: Point3<f64>,
    /// A unit vector in the frame of the body.
    pub axis: Vector3<f64>,
    /// What the file's coordinate is in the reference configuration.
    pub zero: f64,
    pub start: f64,
    pub rate: f64,
    /// Where a free or planar joint starts, in the parent's frame, and its velocities: of the body's origin, and angular, in world axes.
    pub free: Option<(Isometry3<f64>, Vector3<f64>, Vector3<f64>)>,
    pub laws: JointLaws,
    /// What all actuators together exert at most.
    pub effort: Option<[f64; 2]>,
}

impl SpatialJoint {
    pub fn new(name: &str, place: &FilePlace, kind: JointMotion, body: usize) -> Self {
        SpatialJoint {
            name: name.to_owned(),
            place: place.clone(),
            kind,
            body,
            anchor: Point3::origin(),
            axis: Vector3::z(),
            zero: 0.0,
            start: 0.0,
            rate: 0.0,
            free: None,
            laws: JointLaws::default(),
            effort: None,
        }
    }

    /// How it moves the frame of its body.
    pub fn motion(&self, value: f64) -> Isometry3<f64> {
        if self.kind == JointMotion::Slide {
            return Isometry3::from_parts(Translation3::from(self.axis * value), UnitQuaternion::identity());
        }
        let turn = UnitQuaternion::from_axis_angle(&UnitVector3::new_normalize(self.axis), value);
        let back = self.anchor.coords - turn * self.anchor.coords;
        Isometry3::from_parts(Translation3::from(back), turn)
    }

    /// Does nothing act along it but what it leaves free?
    pub fn is_plain(&self) -> bool {
        let JointLaws { damping, friction, armature, spring, range } = self.laws;
        damping == 0.0 && friction == 0.0 && armature == 0.0 && spring.is_none() && range.is_none()
    }
}

/// A point of a body, in its frame.
#[derive(Clone, Debug)]
pub struct BodyPoint {
    pub body: usize,
    pub at: Point3<f64>,
}

/// What closes a loop.
#[derive(Clone, Debug)]
pub struct Closure {
    pub name: String,
    pub place: FilePlace,
    pub kind: ClosureKind,
    pub ends: [BodyPoint; 2],
    pub laws: JointLaws,
}

/// What acts along a joint.
#[derive(Clone, Copy, Debug, Default)]
pub struct JointLaws {
    pub damping: f64,
    pub friction: f64,
    pub armature: f64,
    /// Stiffness, and the coordinate at which the spring is relaxed.
    pub spring: Option<[f64; 2]>,
    pub range: Option<[f64; 2]>,
}

impl Closure {
    /// Its name, or where it is in the file.
    pub fn called(&self) -> String {
        match self.name.is_empty() {
            true => format!("the loop that line {} closes", self.place.line),
            false => format!("loop `{}`", self.name),
        }
    }
}

#[derive(Clone, Debug)]
pub enum ClosureKind {
    /// Two points coincide.
    Point,
    /// A hinge about an axis, in the frame of the first body.
    Hinge(Vector3<f64>),
    /// A slide along an axis, in the frame of the first body.
    Slide(Vector3<f64>),
    /// Two bodies move as one: the pose of the second in the frame of the first.
    Weld(Isometry3<f64>),
}

/// q_joint = offset + ratio q_leader, both from the reference configuration; without a leader the joint is held.
#[derive(Clone, Debug)]
pub struct JointFollower {
    pub name: String,
    pub place: FilePlace,
    pub joint: usize,
    pub leader: Option<usize>,
    pub offset: f64,
    pub ratio: f64,
}

/// A length that is a sum of joint coordinates, with a spring and a damper.
#[derive(Clone, Debug)]
pub struct Tendon {
    pub name: String,
    /// Joints and coefficients of their file coordinates.
    pub terms: Vec<(usize, f64)>,
    pub stiffness: f64,
    pub damping: f64,
    /// The lengths between which the spring is relaxed.
    pub relaxed: [f64; 2],
}

/// The way of a tendon: between two points, over others.
#[derive(Clone, Debug)]
pub struct Course {
    pub ends: [BodyPoint; 2],
    pub over: Vec<CourseBend>,
}

impl Course {
    pub fn straight(ends: [BodyPoint; 2]) -> Self {
        Course { ends, over: Vec::new() }
    }

    /// Its points from end to end; of round bends their centres.
    pub fn points(&self) -> impl Iterator<Item = &BodyPoint> + Clone {
        let [first, last] = self.ends.each_ref();
        std::iter::once(first).chain(self.over.iter().map(|bend| &bend.at)).chain(std::iter::once(last))
    }
}

/// Where a tendon bends: at an eye, or about a cylinder.
#[derive(Clone, Debug)]
pub struct CourseBend {
    pub at: BodyPoint,
    /// Zero for an eye.
    pub radius: f64,
    /// The axis of a cylinder in the frame of its body; a ball has none.
    pub axis: Option<Vector3<f64>>,
    /// A point on the side of the centre on which it passes; without one it takes the shorter way.
    pub side: Option<BodyPoint>,
    pub called: String,
}

/// A spring, damper and rope along a course.
#[derive(Clone, Debug)]
pub struct PointSpring {
    pub name: String,
    pub place: FilePlace,
    pub course: Course,
    pub stiffness: f64,
    pub damping: f64,
    pub relaxed: [f64; 2],
    /// The longest that it can be.
    pub longest: Option<f64>,
}

/// Stiffness and damping between two frames, in their axes.
#[derive(Clone, Debug)]
pub struct SpatialBushing {
    pub name: String,
    pub ends: [BodyPoint; 2],
    pub stiffness: f64,
    pub damping: f64,
    pub torsion_stiffness: f64,
    pub torsion_damping: f64,
}

/// What an actuator moves: its length is gear times a sum of file coordinates, or acts between two points.
#[derive(Clone, Debug)]
pub enum Transmission {
    Joints(Vec<(usize, f64)>),
    Along(Course),
}

/// force = (gain + rate_gain rate) u + bias[0] + bias[1] length + bias[2] rate, clamped; u the input or a state that follows it.
#[derive(Clone, Debug)]
pub struct SpatialActuator {
    pub name: String,
    pub place: FilePlace,
    pub transmission: Transmission,
    pub gear: f64,
    pub gain: f64,
    pub rate_gain: f64,
    pub bias: [f64; 3],
    pub activation: Activation,
    pub control: Option<[f64; 2]>,
    pub force: Option<[f64; 2]>,
    pub start: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Activation {
    Direct,
    /// The state's rate is the input; its range and its start.
    Integrator(Option<[f64; 2]>, f64),
    /// It follows the input with a time constant; its range and its start.
    Filter(f64, Option<[f64; 2]>, f64),
}

/// A solid on a plane of the world, or two balls.
#[derive(Clone, Debug)]
pub struct SpatialContact {
    pub name: String,
    pub kind: ContactKind,
    pub friction: f64,
}

#[derive(Clone, Debug)]
pub enum ContactKind {
    /// A point of the world and its normal, and what touches it.
    Plane { at: Point3<f64>, normal: Vector3<f64>, body: usize, shape: ContactShape },
    /// Two centres and radii.
    Balls([BodyPoint; 2], [f64; 2]),
}

/// What touches a plane, in the frame of its body.
#[derive(Clone, Debug)]
pub enum ContactShape {
    /// Balls of one radius about these centres: a sphere, or the ends of a capsule.
    Balls(Vec<Point3<f64>>, f64),
    Corners(Vec<Point3<f64>>),
    /// About z of its pose.
    Cylinder {
        pose: Isometry3<f64>,
        radius: f64,
        half: f64,
    },
}
