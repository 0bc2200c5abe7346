//! Mass and inertia of MJCF's geoms, as MuJoCo computes them: uniform solids, or shells.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};

use super::resolve::{AngleUnits, ResolvedElement, along_z};
use crate::import::refusal::{Fallible, ImportRefusal};
use crate::import::robot::{BodyMass, SolidShape, steiner};

/// The density of geoms without one, kg/m3.
const DENSITY: f64 = 1000.0;

/// A geom in the frame of its body.
#[derive(Clone, Debug)]
pub struct Geom {
    pub shape: SolidShape,
    pub pose: Isometry3<f64>,
}

/// # Errors
/// A size that is not positive, an unknown type.
pub fn read(geom: &ResolvedElement, angles: &AngleUnits) -> Fallible<Geom> {
    let size = geom.some::<3>("size", [f64::NAN; 3])?;
    let kind = geom.get("type").unwrap_or("sphere");
    let kind = if geom.get("mesh").is_some() { "mesh" } else { kind };
    let ends = geom.array::<6>("fromto")?;
    let (pose, half) = match ends.filter(|_| matches!(kind, "capsule" | "cylinder" | "box" | "ellipsoid")) {
        None => (geom.pose(angles)?, None),
        Some([a, b, c, d, e, f]) => {
            let (from, to) = (Vector3::new(a, b, c), Vector3::new(d, e, f));
            let turn = along_z(from - to).ok_or_else(|| {
                geom.element.refuse(format!("{}: `fromto` has the length zero", geom.element.called()))
            })?;
            (Isometry3::from_parts(Translation3::from((from + to) / 2.0), turn), Some((from - to).norm() / 2.0))
        }
    };
    let positive = |index: usize, value: f64| match value > 0.0 {
        true => Ok(value),
        false => Err(geom.element.refuse(format!(
            "{}: size {} of a {kind} must be positive",
            geom.element.called(),
            index + 1
        ))),
    };
    let at = |index: usize| positive(index, size[index]);
    let three = || match half {
        Some(half) => Ok([at(0)?, at(0)?, half]),
        None => Ok::<[f64; 3], ImportRefusal>([at(0)?, at(1)?, at(2)?]),
    };
    let long = || half.map_or_else(|| at(1), Ok);
    let shape = match kind {
        "plane" => SolidShape::Plane,
        "sphere" => SolidShape::Sphere(at(0)?),
        "capsule" => SolidShape::Capsule(at(0)?, long()?),
        "cylinder" => SolidShape::Cylinder(at(0)?, long()?),
        "box" => SolidShape::Box(three()?),
        "ellipsoid" => SolidShape::Ellipsoid(three()?),
        "mesh" | "hfield" | "sdf" => SolidShape::File,
        other => return Err(geom.element.refuse(format!("{} has the unknown type `{other}`", geom.element.called()))),
    };
    Ok(Geom { shape, pose })
}

/// The mass of a geom and its tensor, in the frame of its body; none if it has none.
///
/// # Errors
/// A volume in another file, a negative mass, a shell of an ellipsoid.
pub fn mass(geom: &ResolvedElement, shape: &Geom, body: &str) -> Fallible<Option<BodyMass>> {
    let given = geom.attribute("mass").map(|mass| mass.number()).transpose()?;
    let density = geom.number("density", DENSITY)?;
    let shell = geom.flag("shellinertia", false)?;
    if shape.shape == SolidShape::Plane || given == Some(0.0) || given.is_none() && density == 0.0 {
        return Ok(None);
    }
    if given.unwrap_or(density) < 0.0 {
        return Err(geom.element.refuse(format!("{} has a negative mass or density", geom.element.called())));
    }
    let uniform = if shell { shell_of(shape.shape) } else { solid_of(shape.shape) };
    let Some((volume, moments)) = uniform else {
        let what = if shape.shape == SolidShape::File {
            "the volume of a mesh or height field is in another file"
        } else {
            "the shell of an ellipsoid is not computed"
        };
        return Err(geom
            .element
            .refuse(format!("body `{body}` needs an inertial: {what} ({})", geom.element.called()))
            .help("load the model in MuJoCo, save it with mj_saveLastXML, and import that file; or give the geom mass=\"0\""));
    };
    let mass = given.unwrap_or(density * volume);
    let tensor = Matrix3::from_diagonal(&Vector3::from(moments.map(|moment| moment * mass)));
    let own_frame = BodyMass { mass, centre: Vector3::zeros(), tensor };
    Ok(Some(own_frame.moved(&shape.pose)))
}

/// Volume, and moments of inertia for the unit of mass.
fn solid_of(shape: SolidShape) -> Option<(f64, [f64; 3])> {
    let square = |x: f64| x * x;
    Some(match shape {
        SolidShape::Plane | SolidShape::File => return None,
        SolidShape::Sphere(r) => (4.0 / 3.0 * PI * r * r * r, [0.4 * r * r; 3]),
        SolidShape::Cylinder(r, half) => {
            let across = (3.0 * r * r + square(2.0 * half)) / 12.0;
            (2.0 * PI * r * r * half, [across, across, r * r / 2.0])
        }
        SolidShape::Box([a, b, c]) => {
            (8.0 * a * b * c, [(b * b + c * c) / 3.0, (a * a + c * c) / 3.0, (a * a + b * b) / 3.0])
        }
        SolidShape::Ellipsoid([a, b, c]) => {
            (4.0 / 3.0 * PI * a * b * c, [(b * b + c * c) / 5.0, (a * a + c * c) / 5.0, (a * a + b * b) / 5.0])
        }
        SolidShape::Capsule(r, half) => {
            let (height, ball, tube) = (2.0 * half, 4.0 / 3.0 * PI * r * r * r, 2.0 * PI * r * r * half);
            let volume = ball + tube;
            let (ball, tube) = (ball / volume, tube / volume);
            let across = tube * (3.0 * r * r + height * height) / 12.0
                + ball * (0.4 * r * r + height * (3.0 * r + 2.0 * height) / 8.0);
            (volume, [across, across, tube * r * r / 2.0 + ball * 0.4 * r * r])
        }
    })
}

/// Area, and moments of inertia for the unit of mass, of the surface.
fn shell_of(shape: SolidShape) -> Option<(f64, [f64; 3])> {
    /// Area, tensor by area about the centre of the shape.
    type Piece = (f64, Matrix3<f64>);
    let diagonal =
        |area: f64, moments: [f64; 3]| (area, Matrix3::from_diagonal(&Vector3::from(moments.map(|m| m * area))));
    let beside = |(area, tensor): Piece, offset: Vector3<f64>| (area, tensor + steiner(area, offset));
    let tube = |r: f64, half: f64| {
        let across = r * r / 2.0 + half * half / 3.0;
        diagonal(4.0 * PI * r * half, [across, across, r * r])
    };
    let pieces: Vec<Piece> = match shape {
        SolidShape::Sphere(r) => vec![diagonal(4.0 * PI * r * r, [2.0 / 3.0 * r * r; 3])],
        SolidShape::Cylinder(r, half) => {
            let disc = diagonal(PI * r * r, [r * r / 4.0, r * r / 4.0, r * r / 2.0]);
            let ends = [half, -half].map(|z| beside(disc, Vector3::new(0.0, 0.0, z)));
            vec![tube(r, half), ends[0], ends[1]]
        }
        SolidShape::Capsule(r, half) => {
            // A hemisphere's centre is r/2 from its great circle; about that circle's centre its moments are those of the sphere.
            let moments = [2.0 / 3.0 * r * r; 3];
            let (area, about_centre) = diagonal(2.0 * PI * r * r, moments);
            let about_mass = about_centre - steiner(area, Vector3::new(0.0, 0.0, r / 2.0));
            let ends =
                [1.0, -1.0].map(|side| beside((area, about_mass), Vector3::new(0.0, 0.0, side * (half + r / 2.0))));
            vec![tube(r, half), ends[0], ends[1]]
        }
        SolidShape::Box([a, b, c]) => {
            let face = |normal: usize| {
                let half = [a, b, c];
                let [u, v] = [(normal + 1) % 3, (normal + 2) % 3];
                let mut moments = [0.0; 3];
                moments[normal] = (half[u] * half[u] + half[v] * half[v]) / 3.0;
                moments[u] = half[v] * half[v] / 3.0;
                moments[v] = half[u] * half[u] / 3.0;
                let mut offset = Vector3::zeros();
                offset[normal] = half[normal];
                let face = diagonal(4.0 * half[u] * half[v], moments);
                [beside(face, offset), beside(face, -offset)]
            };
            (0..3).flat_map(face).collect()
        }
        SolidShape::Plane | SolidShape::Ellipsoid(_) | SolidShape::File => return None,
    };
    let area: f64 = pieces.iter().map(|piece| piece.0).sum();
    let tensor = pieces.iter().fold(Matrix3::zeros(), |sum: Matrix3<f64>, piece| sum + piece.1) / area;
    Some((area, [tensor[(0, 0)], tensor[(1, 1)], tensor[(2, 2)]]))
}
