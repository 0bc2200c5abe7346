//! What Drake adds to SDF and URDF between two bodies: ball constraints, bushings, springs. SDF writes values as texts, URDF as attributes.

use nalgebra::{Isometry3, Point3};

use super::options::ImportOptions;
use super::refusal::Fallible;
use super::report::ImportReport;
use super::robot::{BodyPoint, Closure, ClosureKind, Course, JointLaws, PointSpring, SpatialBushing, SpatialModel};
use super::xml::{self, XmlElement};

pub const OF_BALLS: &str =
    "drake:ball_constraint_body_A drake:ball_constraint_body_B drake:ball_constraint_p_AP drake:ball_constraint_p_BQ";
pub const OF_BUSHINGS: &str = "drake:bushing_frameA drake:bushing_frameC drake:bushing_force_stiffness drake:bushing_force_damping \
    drake:bushing_torque_stiffness drake:bushing_torque_damping";
pub const OF_SPRINGS: &str = "drake:linear_spring_damper_body_A drake:linear_spring_damper_body_B drake:linear_spring_damper_p_AP \
    drake:linear_spring_damper_p_BQ drake:linear_spring_damper_free_length drake:linear_spring_damper_stiffness \
    drake:linear_spring_damper_damping";

/// Of a surface: what is read, and how soft a contact is, which has no part in an exact one.
pub const OF_SURFACES: &str = "drake:mu_dynamic drake:mu_static";
pub const SOFT_SURFACES: &str = "drake:mesh_resolution_hint drake:rigid_hydroelastic drake:compliant_hydroelastic drake:hydroelastic_modulus \
    drake:hunt_crossley_dissipation drake:relaxation_time drake:point_contact_stiffness drake:hydroelastic_margin";
/// What [`read`] reads.
const READ: [&str; 3] = ["drake:ball_constraint", "drake:linear_bushing_rpy", "drake:linear_spring_damper"];

/// True for elements that [`read`] reads.
pub fn is_read(name: &str) -> bool {
    READ.contains(&name)
}

/// Refuses what joins bodies and has no counterpart, unless the user leaves it out: without it the mechanism has other degrees of freedom.
pub fn refuse(element: &XmlElement, options: &ImportOptions, report: &mut ImportReport) {
    if element.name.contains("constraint") || matches!(element.name.as_str(), "drake:joint" | "coupling") {
        let why = format!("<{}> joins bodies and has no counterpart", element.name);
        report.refuse_or_leave(element, options, &[&element.name], &why);
    }
}

/// A body of the model and a pose in its frame, by the name of a link or a frame.
pub type FrameOf<'a> = &'a dyn Fn(&XmlElement, &str) -> Fallible<(usize, Isometry3<f64>)>;

/// What joins two bodies, to be added to a model.
pub enum DrakePart {
    Ball(Closure),
    Spring(PointSpring),
    /// With what is said of its numbers.
    Bushing(SpatialBushing, Vec<String>),
}

impl DrakePart {
    pub fn add(self, model: &mut SpatialModel, report: &mut ImportReport) {
        match self {
            DrakePart::Ball(closure) => model.closures.push(closure),
            DrakePart::Spring(spring) => model.springs.push(spring),
            DrakePart::Bushing(bushing, said) => {
                model.bushings.push(bushing);
                said.into_iter().for_each(|line| report.approximated(line));
            }
        }
    }
}

/// Reads an element of Drake's that acts between two bodies; none if it is none of those.
///
/// # Errors
/// Names that are not in the file, what is not a number.
pub fn read(element: &XmlElement, frame: FrameOf) -> Fallible<Option<DrakePart>> {
    Ok(Some(match element.name.as_str() {
        "drake:ball_constraint" => ball(element, frame)?,
        "drake:linear_bushing_rpy" => bushing(element, frame)?,
        "drake:linear_spring_damper" => spring(element, frame)?,
        _ => return Ok(None),
    }))
}

/// A part of an element: its text, or its `name` or `value`.
fn value<'a>(element: &'a XmlElement, key: &str) -> Fallible<&'a str> {
    let part = element
        .child(key)
        .ok_or_else(|| element.refuse(format!("<{}> (line {}) has no <{key}>", element.name, element.place.line)))?;
    Ok(part.get("name").or_else(|| part.get("value")).unwrap_or(part.text.trim()))
}

fn numbers<const N: usize>(element: &XmlElement, key: &str) -> Fallible<[f64; N]> {
    let text = value(element, key)?;
    let numbers = xml::numbers(text).map_err(|why| element.refuse(format!("<{key}>: {why}")))?;
    <[f64; N]>::try_from(numbers).map_err(|_| {
        let count = if N == 1 { "one number".to_owned() } else { format!("{N} numbers") };
        element.refuse(format!("<{key}> is `{text}`, but must be {count}"))
    })
}

/// The points of two bodies, `p_AP` and `p_BQ`; the origin of the body where there is none.
fn points(element: &XmlElement, prefix: &str, frame: FrameOf) -> Fallible<[BodyPoint; 2]> {
    let end = |body: &str, point: &str| -> Fallible<BodyPoint> {
        let (body, pose) = frame(element, value(element, &format!("{prefix}_{body}"))?)?;
        let key = format!("{prefix}_{point}");
        let at = if element.child(&key).is_some() { numbers(element, &key)? } else { [0.0; 3] };
        Ok(BodyPoint { body, at: pose * Point3::from(at) })
    };
    Ok([end("body_A", "p_AP")?, end("body_B", "p_BQ")?])
}

fn name_of(element: &XmlElement) -> String {
    element.get("name").unwrap_or_default().to_owned()
}

fn ball(element: &XmlElement, frame: FrameOf) -> Fallible<DrakePart> {
    let ends = points(element, "drake:ball_constraint", frame)?;
    let (name, place) = (name_of(element), element.place.clone());
    Ok(DrakePart::Ball(Closure { name, place, kind: ClosureKind::Point, ends, laws: JointLaws::default() }))
}

fn spring(element: &XmlElement, frame: FrameOf) -> Fallible<DrakePart> {
    let ends = points(element, "drake:linear_spring_damper", frame)?;
    let number = |key: &str| numbers::<1>(element, &format!("drake:linear_spring_damper_{key}")).map(|[number]| number);
    Ok(DrakePart::Spring(PointSpring {
        name: name_of(element),
        place: element.place.clone(),
        course: Course::straight(ends),
        stiffness: number("stiffness")?,
        damping: number("damping")?,
        relaxed: [number("free_length")?; 2],
        longest: None,
    }))
}

/// Stiffness and damping between two frames; in the plane both directions have one number here.
fn bushing(element: &XmlElement, frame: FrameOf) -> Fallible<DrakePart> {
    let end = |key: &str| frame(element, value(element, key)?);
    let frames = [end("drake:bushing_frameA")?, end("drake:bushing_frameC")?];
    let three = |key: &str| numbers::<3>(element, &format!("drake:bushing_{key}"));
    let [force, force_damping] = [three("force_stiffness")?, three("force_damping")?];
    let [torque, torque_damping] = [three("torque_stiffness")?, three("torque_damping")?];
    let largest = |values: [f64; 3]| values.into_iter().fold(0.0, f64::max);
    let unequal = [("force stiffness", force), ("force damping", force_damping)]
        .into_iter()
        .filter(|(_, values)| values.iter().any(|value| *value != values[0]));
    let line = element.place.line;
    let said = unequal.map(|(name, values)| {
        format!("the {name} of a bushing (line {line}) is {values:?} by axes; its largest is taken in both directions of the plane")
    });
    let bushing = SpatialBushing {
        name: name_of(element),
        ends: frames.map(|(body, pose)| BodyPoint { body, at: Point3::from(pose.translation.vector) }),
        stiffness: largest(force),
        damping: largest(force_damping),
        torsion_stiffness: largest(torque),
        torsion_damping: largest(torque_damping),
    };
    Ok(DrakePart::Bushing(bushing, said.collect()))
}
