//! Where a cam touches its follower, as formulas of the cam's angle theta. In the carrier, with the shaft as origin, the follower is
//! where its law says; seen from the cam, which turns by theta, its roller or face envelops the profile (Norton, *Design of Machinery*;
//! VDI 2142). A roller's centre p draws the pitch curve with the tangent T = p' - k x p; a face with the normal m touches at h m + (dh/deta) k x m, where h
//! is its distance from the shaft and eta the angle of m in the cam.

use super::mounting::{FollowerGuide, Mounting, place, value, values};
use crate::expr::{Arena, ArenaTerm, Binary, Expr, Symbol, Unary, build, build_all};
use crate::model::{KeyValue, Mechanism, Part, Place};

/// Everything that is known of a cam, in terms of [`Symbol::Argument`].
#[derive(Clone, Copy, Debug)]
pub(super) struct CamGeometry {
    /// The law and its first three derivatives.
    pub law: [Expr; 4],
    /// Where the guide is on the base circle: how far the follower's point is from the shaft along the slide, or the follower's angle.
    pub start: Expr,
    /// How the guide's coordinate grows with the law: 1 or -1.
    pub sense: f64,
    pub contact: CamContact,
}

/// Where cam and follower touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct CamContact {
    /// On the cam, in its own axes from its mass centre.
    pub at: [Expr; 2],
    /// The follower's point there.
    pub point: [Expr; 2],
    /// The guide's reaction for a normal force of one.
    pub leverage: Expr,
    /// From the direction in which the follower rises to the common normal.
    pub pressure: Expr,
    /// Of the profile.
    pub curvature: Expr,
    /// Of the curve that the follower's point draws in the cam, if it has a roller or an edge.
    pub pitch: Expr,
    /// Above zero where the profile is not undercut: 1 - radius x curvature of the pitch curve, or a face's radius of curvature.
    pub excess: Expr,
    /// From the follower's point along its face.
    pub reach: Expr,
    /// For a reaction of one, in the carrier's axes: the force of the contact on the follower, and what the guide exerts on it beside the
    /// reaction, as a force on its second point and a torque.
    pub push: [Expr; 2],
    pub guide: ([Expr; 2], Expr),
}

type Vector<'a> = [ArenaTerm<'a>; 2];

fn dot<'a>(a: Vector<'a>, b: Vector<'a>) -> ArenaTerm<'a> {
    a[0] * b[0] + a[1] * b[1]
}

fn cross<'a>(a: Vector<'a>, b: Vector<'a>) -> ArenaTerm<'a> {
    a[0] * b[1] - a[1] * b[0]
}

/// k x a
fn normal(a: Vector<'_>) -> Vector<'_> {
    [-a[1], a[0]]
}

fn scaled<'a>(factor: ArenaTerm<'a>, a: Vector<'a>) -> Vector<'a> {
    a.map(|component| factor * component)
}

fn sum<'a>(a: Vector<'a>, b: Vector<'a>) -> Vector<'a> {
    [a[0] + b[0], a[1] + b[1]]
}

fn difference<'a>(a: Vector<'a>, b: Vector<'a>) -> Vector<'a> {
    [a[0] - b[0], a[1] - b[1]]
}

fn turned<'a>(angle: ArenaTerm<'a>, a: Vector<'a>) -> Vector<'a> {
    let [along, across] = [scaled(angle.cos(), a), scaled(angle.sin(), normal(a))];
    sum(along, across)
}

fn direction(a: Vector<'_>) -> ArenaTerm<'_> {
    a[1].and(Binary::Atan2, a[0])
}

/// The guide with its places as expressions.
#[derive(Clone, Copy)]
enum Lead {
    /// Along an axis; where the follower's point is from the shaft when the guide is at zero, and the guide's point of the follower from there.
    Slide { axis: [Expr; 2], zero: [Expr; 2], seat: [Expr; 2] },
    /// About a point of the carrier, from the shaft; the follower's point from there in the follower's axes.
    Pivot { pivot: [Expr; 2], arm: [Expr; 2] },
}

/// What touches the cam: a circle (of radius zero, if it is an edge) or a line along a direction of the follower.
#[derive(Clone, Copy)]
enum FollowerTouch {
    Roller(Expr),
    Face([Expr; 2]),
}

/// The follower's point from the shaft with its first two derivatives, and how it moves with the guide.
struct FollowerPath<'a> {
    p: [Vector<'a>; 3],
    moves: Vector<'a>,
}

/// The distance of a face from the shaft with its first two derivatives, its normal, and the derivatives of the normal's angle in the cam.
struct FollowerFace<'a> {
    h: [ArenaTerm<'a>; 3],
    normal: Vector<'a>,
    eta: [ArenaTerm<'a>; 2],
    along: Vector<'a>,
    p: Vector<'a>,
}

/// How the guide's coordinate grows with the law: 1 or -1.
pub(super) fn sense(part: &Part, mounting: &Mounting) -> f64 {
    let on_right = part.choice("side") == Some("right");
    if matches!(mounting.guide, FollowerGuide::Slide(_)) || on_right { 1.0 } else { -1.0 }
}

impl CamGeometry {
    /// The geometry of a part whose base circle has this radius.
    pub fn of(arena: &mut Arena, mechanism: &Mechanism, part: &Part, mounting: &Mounting, base: Expr) -> CamGeometry {
        let first = value(arena, part.formula("law"));
        let mut law = [first; 4];
        for order in 1..4 {
            law[order] = arena.derivative(law[order - 1], Symbol::Argument);
        }
        let sense = sense(part, mounting);
        let (lead, touch) = (lead(arena, mechanism, part, mounting), touch(arena, part, mounting));
        let start = start(arena, lead, touch, base, sense);
        let contact = match touch {
            FollowerTouch::Roller(radius) => roller(arena, lead, radius, (&law, start, sense)),
            FollowerTouch::Face(face) => flat(arena, lead, face, (&law, start, sense)),
        };
        let hub = place(arena, mechanism, mounting.shaft[1]);
        let theta = arena.symbol(Symbol::Argument);
        let [x, y, u, v] = build_all(arena, [theta], |[theta]| {
            let in_cam = |at: [Expr; 2]| {
                sum(
                    hub.map(|component| theta.other(component)),
                    turned(-theta, at.map(|component| theta.other(component))),
                )
            };
            let ([x, y], [u, v]) = (in_cam(contact.at), in_cam(contact.point));
            [x, y, u, v]
        });
        CamGeometry { law, start, sense, contact: CamContact { at: [x, y], point: [u, v], ..contact } }
    }
}

fn lead(arena: &mut Arena, mechanism: &Mechanism, part: &Part, mounting: &Mounting) -> Lead {
    let shaft = place(arena, mechanism, mounting.shaft[0]);
    let foot = place(arena, mechanism, part.between[1]);
    match mounting.guide {
        FollowerGuide::Slide(guide) => {
            let axis = values(arena, &guide.vector("axis"));
            let [from, to] = guide.between.map(|end| place(arena, mechanism, end));
            let angle = value(arena, guide.formula("angle"));
            let [x, y, u, v] = build_all(arena, [angle], |[angle]| {
                let [shaft, foot, from, to] = [shaft, foot, from, to].map(|at| at.map(|c| angle.other(c)));
                let foot = turned(angle, difference(foot, to));
                let [x, y] = difference(sum(from, foot), shaft);
                [x, y, -foot[0], -foot[1]]
            });
            Lead::Slide { axis, zero: [x, y], seat: [u, v] }
        }
        FollowerGuide::Pivot(ends) => {
            let [on, of] = ends.map(|end| place(arena, mechanism, end));
            let mut minus = |a: [Expr; 2], b: [Expr; 2]| [0, 1].map(|axis| arena.subtract(a[axis], b[axis]));
            Lead::Pivot { pivot: minus(on, shaft), arm: minus(foot, of) }
        }
    }
}

/// How far apart two points of a body are.
pub(super) fn distance(arena: &mut Arena, mechanism: &Mechanism, from: Place, to: Place) -> Expr {
    let [from, to] = [from, to].map(|at| place(arena, mechanism, at));
    let [x, y] = [0, 1].map(|axis| arena.subtract(to[axis], from[axis]));
    build(arena, [x, y], |[x, y]| (x.square() + y.square()).of(Unary::Sqrt))
}

fn touch(arena: &mut Arena, part: &Part, mounting: &Mounting) -> FollowerTouch {
    if !matches!(part.value("face"), Some(KeyValue::Vector(_))) {
        return FollowerTouch::Roller(value(arena, part.formula("roller")));
    }
    let face = values(arena, &part.vector("face"));
    match mounting.guide {
        // The follower keeps its angle: its face is known in the carrier.
        FollowerGuide::Slide(guide) => {
            let angle = value(arena, guide.formula("angle"));
            FollowerTouch::Face(build_all(arena, [angle], |[angle]| turned(angle, face.map(|c| angle.other(c)))))
        }
        FollowerGuide::Pivot(_) => FollowerTouch::Face(face),
    }
}

/// Where the guide is when the follower touches the base circle.
fn start(arena: &mut Arena, lead: Lead, touch: FollowerTouch, base: Expr, sense: f64) -> Expr {
    build(arena, [base], |[base]| {
        let of = |pair: [Expr; 2]| pair.map(|component| base.other(component));
        match (lead, touch) {
            (Lead::Slide { axis, zero, .. }, FollowerTouch::Roller(radius)) => {
                let beside = cross(of(axis), of(zero));
                ((base + base.other(radius)).square() - beside.square()).of(Unary::Sqrt)
            }
            (Lead::Slide { axis, zero, .. }, FollowerTouch::Face(face)) => {
                let (axis, m) = (of(axis), normal(of(face)));
                let beside = cross(axis, of(zero));
                (base - beside * dot(normal(axis), m)) / dot(axis, m)
            }
            (Lead::Pivot { pivot, arm }, touch) => {
                let (pivot, arm) = (of(pivot), of(arm));
                let away = dot(pivot, pivot);
                let (cosine, turned) = match touch {
                    FollowerTouch::Roller(radius) => {
                        let (long, reach) = (dot(arm, arm), base + base.other(radius));
                        let both = (away * long).of(Unary::Sqrt);
                        ((reach.square() - away - long) / (2.0 * both), direction(arm))
                    }
                    FollowerTouch::Face(face) => {
                        let m = normal(of(face));
                        ((base - dot(arm, m)) / away.of(Unary::Sqrt), direction(m))
                    }
                };
                let angle = direction(pivot) - turned - base.number(sense) * cosine.of(Unary::Acos);
                direction([angle.cos(), angle.sin()])
            }
        }
    })
}

/// The follower's angle about its pivot with its first two derivatives.
fn turning<'a>(law: [ArenaTerm<'a>; 3], start: ArenaTerm<'a>, sense: f64) -> [ArenaTerm<'a>; 3] {
    let sense = start.number(sense);
    [start + sense * law[0], sense * law[1], sense * law[2]]
}

fn path<'a>(lead: Lead, law: [ArenaTerm<'a>; 3], start: ArenaTerm<'a>, sense: f64) -> FollowerPath<'a> {
    let of = |pair: [Expr; 2]| pair.map(|component| start.other(component));
    match lead {
        Lead::Slide { axis, zero, .. } => {
            let axis = of(axis);
            let beside = cross(axis, of(zero));
            let at = sum(scaled(start + law[0], axis), scaled(beside, normal(axis)));
            FollowerPath { p: [at, scaled(law[1], axis), scaled(law[2], axis)], moves: axis }
        }
        Lead::Pivot { pivot, arm } => {
            let psi = turning(law, start, sense);
            let arm = turned(psi[0], of(arm));
            let moves = normal(arm);
            let second = difference(scaled(psi[2], moves), scaled(psi[1].square(), arm));
            FollowerPath { p: [sum(of(pivot), arm), scaled(psi[1], moves), second], moves }
        }
    }
}

/// What the contact exerts on the follower, and the guide beside its reaction: a force on its point and a torque; for a reaction of one.
fn loads<'a>(lead: Lead, moves: Vector<'a>, out: Vector<'a>, reach: ArenaTerm<'a>) -> [ArenaTerm<'a>; 5] {
    let leverage = dot(moves, out);
    let push = out.map(|component| component / leverage);
    match lead {
        Lead::Slide { seat, .. } => {
            // The rest of the force across the slide, and its moment.
            let rest = difference(moves, push);
            let torque = -(reach / leverage) - cross(seat.map(|component| reach.other(component)), rest);
            [push[0], push[1], rest[0], rest[1], torque]
        }
        Lead::Pivot { .. } => [push[0], push[1], -push[0], -push[1], reach.number(0.0)],
    }
}

/// A law, where the guide starts, and its sense.
type Lift<'g> = (&'g [Expr; 4], Expr, f64);

fn roller(arena: &mut Arena, lead: Lead, radius: Expr, (law, start, sense): Lift) -> CamContact {
    let made = build_all(arena, [start, radius, law[0], law[1], law[2]], |[start, radius, s, v, a]| {
        let FollowerPath { p: [p, first, second], moves } = path(lead, [s, v, a], start, sense);
        let tangent = difference(first, normal(p));
        let bend = difference(difference(second, scaled(start.number(2.0), normal(first))), p);
        let square = dot(tangent, tangent);
        let long = square.of(Unary::Sqrt);
        let out = normal(tangent).map(|component| component / long);
        let pitch = -cross(tangent, bend) / (square * long);
        let excess = 1.0 - radius * pitch;
        let at = difference(p, scaled(radius, out));
        let rise = scaled(start.number(sense), moves);
        let leverage = dot(moves, out);
        let pressure = cross(rise, out).and(Binary::Atan2, dot(rise, out));
        let [fx, fy, gx, gy, torque] = loads(lead, moves, out, start.number(0.0));
        [at[0], at[1], p[0], p[1], leverage, pressure, pitch / excess, pitch, excess, fx, fy, gx, gy, torque]
    });
    let [x, y, u, v, leverage, pressure, curvature, pitch, excess, fx, fy, gx, gy, torque] = made;
    let (push, guide, reach) = ([fx, fy], ([gx, gy], torque), Expr::ZERO);
    CamContact { at: [x, y], point: [u, v], leverage, pressure, curvature, pitch, excess, reach, push, guide }
}

fn line<'a>(
    lead: Lead,
    face: Vector<'a>,
    law: [ArenaTerm<'a>; 3],
    start: ArenaTerm<'a>,
    sense: f64,
) -> FollowerFace<'a> {
    let of = |pair: [Expr; 2]| pair.map(|component| start.other(component));
    let FollowerPath { p: [p, ..], moves } = path(lead, law, start, sense);
    match lead {
        Lead::Slide { .. } => {
            let m = normal(face);
            let steep = dot(moves, m);
            let h = [dot(m, p), steep * law[1], steep * law[2]];
            FollowerFace { h, normal: m, eta: [start.number(-1.0), start.number(0.0)], along: face, p }
        }
        Lead::Pivot { pivot, .. } => {
            let psi = turning(law, start, sense);
            let along = turned(psi[0], face);
            let m = normal(along);
            let [near, beside] = [m, normal(m)].map(|axis| dot(of(pivot), axis));
            let second = psi[2] * beside - psi[1].square() * near;
            FollowerFace {
                h: [dot(m, p), psi[1] * beside, second],
                normal: m,
                eta: [psi[1] - start.number(1.0), psi[2]],
                along,
                p,
            }
        }
    }
}

fn flat(arena: &mut Arena, lead: Lead, face: [Expr; 2], (law, start, sense): Lift) -> CamContact {
    let made = build_all(arena, [start, law[0], law[1], law[2]], |[start, s, v, a]| {
        let face = face.map(|component| start.other(component));
        let FollowerFace { h: [h, first, second], normal: m, eta, along, p } =
            line(lead, face, [s, v, a], start, sense);
        let slope = first / eta[0];
        let radius = h + (second * eta[0] - first * eta[1]) / (eta[0].square() * eta[0]);
        let at = sum(scaled(h, m), scaled(slope, normal(m)));
        let moves = match lead {
            Lead::Slide { axis, .. } => axis.map(|component| start.other(component)),
            Lead::Pivot { pivot, .. } => normal(difference(at, pivot.map(|component| start.other(component)))),
        };
        let rise = scaled(start.number(sense), moves);
        let pressure = cross(rise, m).and(Binary::Atan2, dot(rise, m));
        let reach = dot(difference(at, p), along);
        let [fx, fy, gx, gy, torque] = loads(lead, moves, m, reach);
        [at[0], at[1], p[0], p[1], dot(moves, m), pressure, 1.0 / radius, radius, reach, fx, fy, gx, gy, torque]
    });
    let [x, y, u, v, leverage, pressure, curvature, excess, reach, fx, fy, gx, gy, torque] = made;
    let (push, guide, pitch) = ([fx, fy], ([gx, gy], torque), Expr::ZERO);
    CamContact { at: [x, y], point: [u, v], leverage, pressure, curvature, pitch, excess, reach, push, guide }
}
