//! Cam (j): the guide of a follower is moved by a law of the cam's angle theta against the carrier, s = start + law(theta) for a sliding
//! follower, psi = start -+ law(theta) for a turning one. The reaction is the force or torque on the follower; the cam gets law'(theta)
//! times as much, and the contact a normal force that is never a pull only as long as the follower does not lift off; a groove or a conjugate cam
//! (`closure = "form"`) also pulls. With `unilateral` the relation holds on one side only: the follower lifts off where it would have to be pulled.

mod breaks;
mod check;
mod geometry;
mod mounting;
mod profile;

pub use profile::Phase;
pub use profile::Profile;

use crate::component::frame::Placed;
use crate::component::key::{BODY_AND_POINT, Form, Key, Record};
use crate::component::{Component, Icon, limits};
use crate::expr::Expr;
use crate::model::measure::{ANGLE, LENGTH};
use crate::model::{Formula, GapLaw, JointId, Mechanism, Part, Quantity as Q, Range};
use crate::network::{Bearing, Coupling, CouplingTerm, Curve, Direction, Port, Rows, System};
use crate::scene::{Joint, Quantity, Vector};
use geometry::{CamContact, CamGeometry};
use mounting::{FollowerGuide, Mounting};

/// Where a turning follower can touch; the first by default.
const SIDES: [&str; 2] = ["left", "right"];

/// What keeps a follower on its cam; a force by default.
const CLOSURES: [&str; 2] = ["force", "form"];

pub(crate) const CAM: Component = Component {
    about: "a cam, the first body, whose profile moves the second point with its body by a law of the cam's angle",
    equations: "s = s0 + law(theta), or psi = psi0 -+ law(theta)",
    keys: &[
        Key::required(
            "between",
            Form::BodyAndPoint,
            "the cam and the follower's point: the roller's centre, the knife edge, or a point of the face",
            BODY_AND_POINT,
        ),
        Key::required(
            "shaft",
            Form::OtherJoint,
            "the revolute joint in which the cam turns on the carrier",
            "name the joint in which the cam turns: `shaft = \"JOINT\"`",
        ),
        Key::required(
            "guide",
            Form::OtherJoint,
            "the joint in which the follower moves on the carrier: prismatic, from the carrier to the follower, or revolute",
            "name the joint in which the follower moves: `guide = \"JOINT\"`",
        ),
        Key::required(
            "base",
            Form::Constant(LENGTH, Range::Positive),
            "the radius of the base circle, on which the follower is where the law is zero",
            "give the radius of the base circle: `base = \"30 mm\"`",
        ),
        Key::optional(
            "roller",
            Form::Constant(LENGTH, Range::NotNegative),
            "the radius of the follower's roller; a knife edge if absent",
        ),
        Key::optional(
            "face",
            Form::Axis,
            "the direction of a flat follower's face in its frame; the follower is on its left",
        ),
        Key::optional(
            "side",
            Form::Choice(&SIDES, "a follower touches on the `left` or the `right`"),
            "where a turning follower touches, seen from the shaft towards its pivot",
        ),
        Key::optional(
            "closure",
            Form::Choice(&CLOSURES, "`closure` is \"force\" (the default) or \"form\""),
            "what keeps the follower on the cam: a `force`, or the `form` of a groove or of a conjugate cam, which also pulls",
        ),
        Key::optional(
            "unilateral",
            Form::Record(Record::Rebound),
            "allows lift-off: a unilateral contact with the coefficient of restitution `restitution`",
        ),
        Key::required(
            "law",
            Form::Curve("guide", [LENGTH, ANGLE]),
            "how far the follower rises, in terms of `angle`, the cam's from 0 to 360 deg against the carrier",
            "give the rise as a function of the cam's angle: `law = \"0.01*(1 - cos(angle))\"`",
        ),
    ],
    variables: &[Q::Angle, Q::Gap, Q::Fn, Q::Torque, Q::PressureAngle, Q::Curvature, Q::Mode],
    law_variables: &[Q::Angle],
    reactions: &[Q::Fn, Q::Torque],
    pose: &[Q::Angle, Q::PressureAngle],
    undriven: ["a cam", "name the joint in which the cam turns"],
    gaps,
    gap_lever,
    relation,
    check: check::check,
    profile: |part, mechanism, parameters| Profile::of(part, mechanism, parameters).ok(),
    ..Component::joint("cam", rows, placed, |_| Icon::Cam)
};

/// In a mirror a turning follower touches on the other side, and a face that has the follower on its left points the other way.
fn placed(placed: &mut Placed<'_>) {
    if placed.turns {
        placed.side("side", SIDES);
    }
    placed.axis("face", placed.part.between[1]);
    let frame = placed.frame;
    placed.vector("face", |face| face.map(|component| frame.signed(component)));
}

fn rows(part: &Part, system: &mut System) -> Rows {
    Rows { letter: "j", coupling: limits::always(part, || relation(part, system)), ..Rows::default() }
}

fn relation(part: &Part, system: &mut System) -> Option<Coupling> {
    let mechanism = &*system.mechanism.clone();
    // The check has refused other joints.
    let mounting = Mounting::of(part, mechanism).ok()?;
    let base = system.value(part.formula("base"));
    let geometry = CamGeometry::of(&mut system.arena, mechanism, part, &mounting, base);
    Some(coupling(part, &mounting, &geometry, system))
}

/// A follower that is only pressed lifts off the way that it rises.
fn gaps(part: &Part, mechanism: &Mechanism) -> Vec<GapLaw> {
    let (Some(limits), Ok(mounting)) = (part.limits(), Mounting::of(part, mechanism)) else { return Vec::new() };
    let sign = geometry::sense(part, &mounting);
    vec![GapLaw {
        word: "",
        sign,
        bound: Formula::Number(0.0),
        restitution: limits.restitution.clone(),
        of_rate: false,
    }]
}

/// The gap is measured along the way of the follower's point: on a circle about the pivot where it turns.
fn gap_lever(part: &Part, system: &mut System) -> Expr {
    let mechanism = &*system.mechanism.clone();
    match Mounting::of(part, mechanism).map(|mounting| mounting.guide) {
        Ok(FollowerGuide::Pivot([_, pivot])) => {
            geometry::distance(&mut system.arena, mechanism, pivot, part.between[1])
        }
        Ok(FollowerGuide::Slide(_)) | Err(_) => Expr::ONE,
    }
}

/// The guide's coordinate less sense x law(theta) is where it starts.
fn coupling(part: &Part, mounting: &Mounting, geometry: &CamGeometry, system: &mut System) -> Coupling {
    let [cam, follower] = part.between;
    let bodies = |other| [system.r_node(mounting.carrier), system.r_node(other)];
    let port = match mounting.guide {
        FollowerGuide::Slide(guide) => {
            let axis = mounting::values(&mut system.arena, &guide.vector("axis"));
            let points = [mounting.shaft[0], follower].map(|place| system.t_node(place));
            Port::Along(points, Direction::Fixed(mounting.carrier, axis))
        }
        FollowerGuide::Pivot(_) => Port::Angle(bodies(follower.body())),
    };
    let [value, slope, second, _] = geometry.law;
    let contact = geometry.contact;
    let bearings = bearings(mounting, &contact, system);
    let curve = Curve {
        value: [value, slope, second],
        leverage: contact.leverage,
        pressure: contact.pressure,
        curvature: contact.curvature,
        carrier: mounting.carrier,
        bearings,
    };
    let turn = [system.r_node(mounting.carrier), system.r_node(cam.body())];
    let factor = system.arena.constant(-geometry.sense);
    let terms = vec![CouplingTerm { factor: Expr::ONE, port }, CouplingTerm { factor, port: Port::Curve(turn, curve) }];
    Coupling { terms, offset: geometry.start }
}

/// The contact pushes the follower and pushes back on the cam: the shaft carries all of that, the guide what is not along it.
fn bearings(mounting: &Mounting, contact: &CamContact, system: &mut System) -> [Bearing; 2] {
    let arena = &mut system.arena;
    let (rest, torque) = contact.guide;
    let loads = [(contact.push, Expr::ZERO), (rest, torque)];
    let mut bearing = |(joint, is_second): (JointId, bool), (force, torque): ([Expr; 2], Expr)| {
        let mut signed = |load: Expr| if is_second { load } else { arena.negate(load) };
        Bearing { joint, force: force.map(&mut signed), torque: signed(torque) }
    };
    [bearing(mounting.joints[0], loads[0]), bearing(mounting.joints[1], loads[1])]
}

impl Joint {
    /// A cam, the first body, that moves the second point with its body. `shaft` and `guide` are the joints in which both move on
    /// their carrier; `law` is the rise over the base circle in terms of `angle`. It touches a knife edge, unless the follower has a roller or a face.
    pub fn cam(
        cam: &str,
        follower: &str,
        [shaft, guide]: [&str; 2],
        base: impl Into<Quantity>,
        law: impl Into<Quantity>,
    ) -> Joint {
        let joint = Joint::new("cam", cam, follower).set("shaft", shaft).set("guide", guide);
        joint.set("base", base.into()).set("law", law.into())
    }

    /// The radius of the roller of a cam's follower, about its point.
    #[must_use]
    pub fn roller(self, radius: impl Into<Quantity>) -> Joint {
        self.set("roller", radius.into())
    }

    /// The direction of the face of a cam's flat follower in its frame; the follower is on its left.
    #[must_use]
    pub fn face(self, direction: impl Into<Vector>) -> Joint {
        self.set("face", direction.into())
    }

    /// A cam's follower that turns touches it on the right, seen from the shaft towards its pivot.
    #[must_use]
    pub fn on_the_right(self) -> Joint {
        self.set("side", "right")
    }
}
