//! Solids that may touch: the shapes that all robot files have, and the contacts of two of them.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use super::{BodyPoint, ContactKind, ContactShape, SpatialContact, SpatialModel};
use crate::import::report::ImportReport;

/// The coefficient of friction of a surface without one, as in Gazebo.
pub const FRICTION: f64 = 1.0;

/// The pose of a plane through the origin across a normal; none for the length zero.
pub fn across(normal: [f64; 3]) -> Option<Isometry3<f64>> {
    let normal = Vector3::from(normal).try_normalize(1e-12)?;
    // Opposite directions are joined by no unique rotation; any half turn does.
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    Some(Isometry3::from_parts(Translation3::identity(), turn))
}

/// A shape about the origin of its pose; round ones are about z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SolidShape {
    /// Through the origin, across z.
    Plane,
    Sphere(f64),
    /// Radius and half length of the cylinder between its ends.
    Capsule(f64, f64),
    Cylinder(f64, f64),
    /// Half sizes.
    Box([f64; 3]),
    Ellipsoid([f64; 3]),
    /// A mesh, a height field, or a signed distance function: its volume is in another file.
    File,
}

/// A solid of a body.
#[derive(Clone, Debug)]
pub struct Solid {
    /// May be empty.
    pub name: String,
    pub body: usize,
    pub shape: SolidShape,
    /// In the frame of its body.
    pub pose: Isometry3<f64>,
}

impl Solid {
    /// How it touches a plane; none of what has no corners and discs.
    fn touching(&self) -> Option<ContactShape> {
        let at = |x: f64, y: f64, z: f64| self.pose * Point3::new(x, y, z);
        Some(match self.shape {
            SolidShape::Sphere(radius) => ContactShape::Balls(vec![at(0.0, 0.0, 0.0)], radius),
            SolidShape::Capsule(radius, half) => {
                ContactShape::Balls([-half, half].map(|z| at(0.0, 0.0, z)).to_vec(), radius)
            }
            SolidShape::Box([a, b, c]) => {
                let corners = (0..8).map(|bits| [1, 2, 4].map(|bit| if bits & bit == 0 { -1.0 } else { 1.0 }));
                ContactShape::Corners(corners.map(|[x, y, z]| at(a * x, b * y, c * z)).collect())
            }
            SolidShape::Cylinder(radius, half) => ContactShape::Cylinder { pose: self.pose, radius, half },
            SolidShape::Plane | SolidShape::Ellipsoid(_) | SolidShape::File => return None,
        })
    }
}

impl SpatialModel {
    /// The body that a body is fixed to; the world is the first.
    pub fn mover(&self, body: usize) -> usize {
        let body_data = &self.bodies[body];
        if body == 0 || !body_data.joints.is_empty() { body } else { self.mover(body_data.parent) }
    }

    /// The pose of a body in the world, in the reference configuration.
    pub fn world(&self, body: usize) -> Isometry3<f64> {
        let body_data = &self.bodies[body];
        if body == 0 { Isometry3::identity() } else { self.world(body_data.parent) * body_data.pose }
    }

    /// The contacts of solids with their coefficients of friction, of which the smaller counts; `may_touch` tells which pairs the file lets touch. Bodies that a
    /// joint joins do not touch, but for planes of the world.
    pub fn touch_all(
        &mut self,
        solids: &[(Solid, f64)],
        may_touch: impl Fn(usize, usize) -> bool,
        report: &mut ImportReport,
    ) {
        let of_joints = self.joints.iter().map(|joint| [joint.body, self.mover(self.bodies[joint.body].parent)]);
        let of_loops = self.closures.iter().map(|closure| closure.ends.each_ref().map(|end| self.mover(end.body)));
        let joined: Vec<[usize; 2]> = of_joints.chain(of_loops).collect();
        for (first, (a, mu)) in solids.iter().enumerate() {
            for (second, (b, other)) in solids.iter().enumerate().skip(first + 1) {
                let movers = [a, b].map(|solid| self.mover(solid.body));
                let is_floor = [a, b].iter().any(|solid| solid.shape == SolidShape::Plane);
                let neighbours = joined.iter().any(|pair| *pair == movers || *pair == [movers[1], movers[0]]);
                if movers[0] != movers[1] && (is_floor || !neighbours) && may_touch(first, second) {
                    self.touch([a, b], mu.min(*other), report);
                }
            }
        }
    }

    /// A contact for each point at which two solids may touch; what has no counterpart is in the report.
    pub fn touch(&mut self, [a, b]: [&Solid; 2], friction: f64, report: &mut ImportReport) {
        let (a, b) = if b.shape == SolidShape::Plane { (b, a) } else { (a, b) };
        let called = |solid: &Solid| match solid.name.is_empty() {
            true => format!("{}_geom", self.bodies[solid.body].name),
            false => solid.name.clone(),
        };
        let name = format!("{}_{}", called(a), called(b));
        if a.shape == SolidShape::Plane {
            let pose = self.world(a.body) * a.pose;
            let (at, normal) = (Point3::from(pose.translation.vector), pose * Vector3::z());
            match b.touching() {
                Some(shape) => {
                    let kind = ContactKind::Plane { at, normal, body: b.body, shape };
                    self.contacts.push(SpatialContact { name, kind, friction });
                }
                None => report.missing("contact of a plane with an ellipsoid or a mesh", &name),
            }
            return;
        }
        if let (SolidShape::Sphere(r), SolidShape::Sphere(s)) = (a.shape, b.shape) {
            let centre =
                |solid: &Solid| BodyPoint { body: solid.body, at: Point3::from(solid.pose.translation.vector) };
            let kind = ContactKind::Balls([centre(a), centre(b)], [r, s]);
            self.contacts.push(SpatialContact { name, kind, friction });
            return;
        }
        report.missing("contact of two bodies other than planes and spheres", &name);
    }
}
