//! The distance of a point from a line or an arc of a profile, which discrete variables say.
//!
//! With r from a point of it, its normal n there and its curvature kappa, positive where it is convex: y = n.r, b = 2 y + kappa r.r and the distance b/(1 + D), D = sqrt(1 + kappa b). The direction in
//! which it grows is (n + kappa r)/D, and it bends by kappa/D times the square of what is across that.

use super::Equations;
use super::form::{Coefficient, LinearForm};
use super::kinematics::{Kinematics, project};
use super::vector::{Scalar, Vector};
use crate::expr::{ArenaTerm, Binary, Expr, Unary, build, build_all};
use crate::model::{BodyId, Contour, Feature, FeatureJoint, Owner};
use crate::network::{Direction, System, TNode, Touched};

/// Value, rate and acceleration of a scalar across variable.
type ScalarMotion = (Expr, LinearForm<Scalar>, LinearForm<Scalar>);

/// The distance with its derivatives, and the direction in which it grows, which turns with the body.
pub(super) fn distance(
    system: &mut System,
    kinematics: &Kinematics,
    (ends, body): ([TNode; 2], Option<BodyId>),
    touched: Touched,
) -> (ScalarMotion, Vector) {
    let axes = [[Expr::ONE, Expr::ZERO], [Expr::ZERO, Expr::ONE]]
        .map(|axis| kinematics.direction(system, Direction::Fixed(body, axis)));
    let arena = &mut system.arena;
    let gap = kinematics.across(arena, ends);
    let [x, y] = axes.each_ref().map(|axis| project(kinematics, arena, &gap, axis));
    let at = [&x.0, &y.0].map(|value| value.total(arena, &kinematics.frames));
    let Touched { normal: [nx, ny], at: [ox, oy], curvature, away } = touched;
    let [value, gx, gy, bend] =
        build_all(arena, [at[0], at[1], nx, ny, ox, oy, curvature, away], |[x, y, nx, ny, ox, oy, curvature, away]| {
            let (rx, ry) = (x - ox, y - oy);
            let two = rx.number(2.0);
            let one = rx.number(1.0);
            let along = nx * rx + ny * ry + away;
            let b = two * along + curvature * (rx * rx + ry * ry);
            let d = (one + curvature * b).of(Unary::Sqrt);
            [b / (one + d), (nx + curvature * rx) / d, (ny + curvature * ry) / d, curvature / d]
        });
    let mut rate = LinearForm::default();
    let mut second = LinearForm::default();
    for (slope, of) in [(gx, &x), (gy, &y)] {
        rate.accumulate(arena, slope, &of.1);
        second.accumulate(arena, slope, &of.2);
    }
    let [vx, vy] =
        [&x.1, &y.1].map(|form| form.map(arena, |arena, part| part.total(arena, &kinematics.frames)).total(arena));
    let across = build(arena, [vx, vy, gx, gy], |[vx, vy, gx, gy]| gx * vy - gy * vx);
    let square = arena.square(across);
    let turning = arena.multiply(bend, square);
    second.add_term(arena, turning, &Scalar::plain(Expr::ONE));
    let mut grows = axes[0].1.scaled(arena, gx);
    let other = axes[1].1.scaled(arena, gy);
    grows.accumulate(arena, &other);
    ((value, rate, second), grows)
}

/// A feature ends this share of its half beyond its ends, so that a point just there is not far from both of two that meet.
const SLACK: f64 = 1e-9;
/// No feature is as far \[m\].
const FAR: f64 = 1e9;

impl Equations {
    /// Where the second point of a contact is, from the first in the axes of its body.
    pub(crate) fn place_at_profile(&mut self, owner: Owner) -> Option<[Expr; 2]> {
        let mechanism = self.system.mechanism.clone();
        let part = mechanism.part_of(owner)?;
        let (ends, body) = (part.between.map(|place| self.system.t_node(place)), part.between[0].body());
        let Equations { system, kinematics, .. } = self;
        let gap = kinematics.across(&mut system.arena, ends);
        Some([[Expr::ONE, Expr::ZERO], [Expr::ZERO, Expr::ONE]].map(|axis| {
            let axis = kinematics.direction(system, Direction::Fixed(body, axis));
            let along = project(kinematics, &mut system.arena, &gap, &axis).0;
            along.total(&mut system.arena, &kinematics.frames)
        }))
    }

    /// How far the disc of a contact is from its profile: the least of its distances from lines and arcs.
    pub(crate) fn gap_at_profile(&mut self, owner: Owner, contour: &Contour) -> Expr {
        let Some(place) = self.place_at_profile(owner) else { return Expr::ZERO };
        let arena = &mut self.system.arena;
        let mut least = arena.constant(FAR);
        for feature in contour.features() {
            let gap = build(arena, place, |[x, y]| {
                let (rx, ry) = (x - x.number(feature.at[0]), y - y.number(feature.at[1]));
                gap_within(&feature, contour.radius, rx, ry)
            });
            least = arena.binary(Binary::Min, least, gap);
            for (end, _) in feature.ends.iter().zip(feature.joints).filter(|(_, joint)| is_end(*joint)) {
                let corner = build(arena, place, |[x, y]| {
                    let (rx, ry) = (x - x.number(end[0]), y - y.number(end[1]));
                    (rx * rx + ry * ry).of(Unary::Sqrt) - rx.number(contour.radius)
                });
                least = arena.binary(Binary::Min, least, corner);
            }
        }
        least
    }
}

/// True for an end that no other feature goes on from with the same tangent.
fn is_end(joint: FeatureJoint) -> bool {
    joint == FeatureJoint::Free
}

/// The distance from a feature, on either side of it, where its nearest point is; else far.
fn gap_within<'a>(feature: &Feature, radius: f64, rx: ArenaTerm<'a>, ry: ArenaTerm<'a>) -> ArenaTerm<'a> {
    let number = |value: f64| rx.number(value);
    let [nx, ny] = feature.normal.map(number);
    let (curvature, one) = (number(feature.curvature), number(1.0));
    let (y, along) = (nx * rx + ny * ry, ny * rx - nx * ry);
    let b = number(2.0) * y + curvature * (rx * rx + ry * ry);
    let gap = b / (one + (one + curvature * b).and(Binary::Max, number(0.0)).of(Unary::Sqrt));
    let foot = match feature.curvature {
        0.0 => along,
        _ => (curvature * along).and(Binary::Atan2, one + curvature * y) / curvature,
    };
    let within = (number(feature.half * (1.0 + SLACK)) - foot.of(Unary::Abs)).and(Binary::Max, number(0.0));
    let other_side = -gap - number(2.0 * radius);
    within.select(gap.and(Binary::Max, other_side), number(FAR))
}
