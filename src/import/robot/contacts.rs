//! Contacts of a robot as contacts of the scene: balls, and the corners and discs that solids have in the plane of motion.

use nalgebra::{Isometry3, Point3, Vector3};

use super::closing;
use super::planar::LinkPoint;
use super::write::{RobotWriter, number, pair};
use super::{ContactKind, ContactShape, SpatialContact};
use crate::import::options::{ContactChoice, ImportOptions};

/// How far the normal of a floor, or the axis of a cylinder, may be out of the plane or off its normal.
const IN_PLANE: f64 = 1e-6;

/// The place and the normal of a plane of the world.
type Floor = (Point3<f64>, Vector3<f64>);

impl RobotWriter<'_> {
    pub fn contact(&mut self, contact: &SpatialContact, options: &ImportOptions) {
        let friction = match contact.friction {
            mu if mu > 0.0 => format!("friction = {{ mu = {} }}\n", number(mu)),
            _ => String::new(),
        };
        match &contact.kind {
            ContactKind::Plane { at, normal, body, shape } => {
                if self.planar.link_of[*body].is_some_and(|link| link != 0) {
                    self.floor(&contact.name, (*at, *normal), (*body, shape), &friction);
                }
            }
            ContactKind::Balls(balls, radii) => {
                if options.contacts != ContactChoice::All {
                    self.report.missing("contact of two balls (--contacts all imports it)", &contact.name);
                    return;
                }
                let [Some(a), Some(b)] = balls.each_ref().map(|ball| self.planar.point(ball)) else { return };
                if a.0 == b.0 {
                    return;
                }
                let name = self.fresh(&contact.name, "contact", "contact");
                let [a, b] = self.ends([a, b], &name);
                self.joint_text += &format!(
                    "\n[joints.{name}]\ntype    = \"contact\"\nbetween = [\"{a}\", \"{b}\"]\ncircle  = {}\nradius  = {}\n{friction}",
                    number(radii[0]),
                    number(radii[1])
                );
                self.report.exact("contact of two balls, without rebound");
            }
        }
    }

    /// A contact with a plane of the world for each ball, corner or disc.
    fn floor(&mut self, called: &str, (at, normal): Floor, (body, shape): (usize, &ContactShape), friction: &str) {
        let planar = self.planar;
        let along_normal = planar.plane.normal.dot(&normal).abs();
        if along_normal > 1.0 - IN_PLANE {
            self.report.idle("contact with a plane that is parallel to the plane of motion");
            return;
        }
        if along_normal > IN_PLANE {
            self.report.missing("contact with a plane that is oblique to the plane of motion", called);
            return;
        }
        let Some(points) = self.section(body, shape) else {
            self.report.missing("contact of a plane with a cylinder that is oblique to the plane of motion", called);
            return;
        };
        let [x, y] = planar.plane.components(&normal);
        let (near, idle): (Vec<_>, Vec<_>) = points.into_iter().partition(|(point, _)| self.moves(*point, [x, y]));
        if near.is_empty() && !idle.is_empty() {
            self.report.idle("contact with a plane that its points never approach");
        }
        for (point, radius) in near {
            let name = self.fresh(called, "contact", "contact");
            let [a, b] = self.ends([(0, planar.at(&at)), point], &name);
            // Where it cannot slide, friction has nothing to act against.
            let touching = (point.0, [point.1[0] - radius * x, point.1[1] - radius * y]);
            let friction = if self.moves(touching, [y, -x]) { friction } else { "" };
            self.joint_text += &format!(
                "\n[joints.{name}]\ntype    = \"contact\"\nbetween = [\"{a}\", \"{b}\"]\naxis    = {}\nradius  = {}\n{friction}",
                pair([y, -x]),
                number(radius)
            );
            self.report.exact("contact with a plane, without rebound");
        }
    }

    /// The points and radii by which a shape touches lines of the plane; none if no points and discs are its outline there.
    fn section(&self, body: usize, shape: &ContactShape) -> Option<Vec<(LinkPoint, f64)>> {
        let planar = self.planar;
        let link = planar.link_of[body]?;
        let at = |point: &Point3<f64>| planar.at(&(planar.world[body] * point));
        let corners = |points: &[Point3<f64>]| {
            let places = outermost(points.iter().map(at).collect(), 1e-9 * planar.size);
            places.into_iter().map(|place| ((link, place), 0.0)).collect()
        };
        match shape {
            ContactShape::Balls(centres, radius) => {
                let centres = outermost(centres.iter().map(at).collect(), 1e-9 * planar.size);
                Some(centres.into_iter().map(|place| ((link, place), *radius)).collect())
            }
            ContactShape::Corners(points) => Some(corners(points)),
            ContactShape::Cylinder { pose, radius, half } => {
                let normal = (planar.world[body] * pose).inverse() * planar.plane.normal;
                if normal.z.abs() > 1.0 - IN_PLANE {
                    return Some(vec![((link, at(&Point3::from(pose.translation.vector))), *radius)]);
                }
                let across = Vector3::new(-normal.y, normal.x, 0.0);
                (normal.z.abs() < IN_PLANE).then(|| corners(&rectangle(pose, across * *radius, *half)))
            }
        }
    }

    /// Does any coordinate move a point along a direction?
    fn moves(&self, (link, at): LinkPoint, [x, y]: [f64; 2]) -> bool {
        let planar = self.planar;
        let height = |values: &[f64]| {
            let place = closing::place_of(&closing::poses(planar, values)[link], planar.links[link].origin, at);
            place[0] * x + place[1] * y
        };
        let mut values = vec![0.0; planar.coordinates.len()];
        let rest = height(&values);
        (0..values.len()).any(|index| {
            values[index] = 0.3;
            let moved = height(&values);
            values[index] = 0.0;
            (moved - rest).abs() > 1e-9 * planar.size
        })
    }
}

/// The corners of the section of a cylinder through its axis, which is z of its pose.
fn rectangle(pose: &Isometry3<f64>, across: Vector3<f64>, half: f64) -> [Point3<f64>; 4] {
    [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]]
        .map(|[side, end]| pose * Point3::from(across * side + Vector3::z() * (end * half)))
}

/// The corners of the convex hull of points (Andrew's monotone chain): those inside never touch a line first. Points that are nearer than a distance are one.
fn outermost(mut points: Vec<[f64; 2]>, near: f64) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut distinct: Vec<[f64; 2]> = Vec::new();
    for point in points {
        if distinct.iter().all(|other| (other[0] - point[0]).hypot(other[1] - point[1]) > near) {
            distinct.push(point);
        }
    }
    if distinct.len() < 3 {
        return distinct;
    }
    let right = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        u[0] * v[1] - u[1] * v[0] <= near * u[0].hypot(u[1])
    };
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && right(a, b, point)
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut distinct.iter().copied());
    hull.extend(half(&mut distinct.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_turned_cube_is_a_hexagon() {
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.4, 0.3, 0.2);
        let corners = (0..8).map(|bits| [1, 2, 4].map(|bit| if bits & bit == 0 { -1.0 } else { 1.0 }));
        let places: Vec<[f64; 2]> =
            corners.map(|[x, y, z]| turn * Vector3::new(x, y, z)).map(|corner| [corner.x, corner.y]).collect();
        let hull = outermost(places.clone(), 1e-9);
        assert_eq!(hull.len(), 6);
        // The support of the hull in each direction is that of all corners.
        for step in 0..100 {
            let (y, x) = (0.0628 * f64::from(step)).sin_cos();
            let far =
                |points: &[[f64; 2]]| points.iter().map(|point| point[0] * x + point[1] * y).fold(f64::MIN, f64::max);
            assert!((far(&hull) - far(&places)).abs() < 1e-12);
        }
        let flat = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1e-12]];
        assert_eq!(outermost(flat.to_vec(), 1e-9), [[0.0, 0.0], [1.0, 0.0]]);
    }
}
