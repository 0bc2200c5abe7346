//! How a cam and its follower are mounted on their carrier: what the shaft and the guide say.

use crate::expr::{Arena, Expr, Symbol};
use crate::model::translate::translate;
use crate::model::{BodyId, Formula, JointId, KeyValue, Mechanism, Part, Place};

/// The joints of a cam.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mounting<'m> {
    /// The body in which the cam turns and on which the follower moves; `None` is the ground.
    pub carrier: Option<BodyId>,
    /// The shaft's point of the carrier, and that of the cam.
    pub shaft: [Place; 2],
    pub guide: FollowerGuide<'m>,
    /// Both joints, and whether the cam and the follower are their second bodies.
    pub joints: [(JointId, bool); 2],
}

/// The joint in which the follower moves.
#[derive(Clone, Copy, Debug)]
pub(super) enum FollowerGuide<'m> {
    /// It slides in a prismatic joint.
    Slide(&'m Part),
    /// It turns about these points of the carrier and of itself.
    Pivot([Place; 2]),
}

/// Why the joints are not those of a cam, which key is to blame, and what to do.
pub(super) type Misfit = (&'static str, String, &'static str);

impl<'m> Mounting<'m> {
    /// The mounting of a part.
    ///
    /// # Errors
    /// Its joints do not connect cam, follower and carrier.
    pub fn of(part: &Part, mechanism: &'m Mechanism) -> Result<Mounting<'m>, Misfit> {
        let [cam, follower] = part.bodies();
        let name = |body: Option<BodyId>| body.map_or("ground", |body| mechanism.bodies[body.0].name.as_str());
        let joint = |key: &str| match part.value(key) {
            Some(KeyValue::Joint(JointId(index))) => mechanism.joints.get(*index),
            _ => None,
        };
        let known = |key: &str, body: Option<BodyId>| match part.value(key) {
            Some(KeyValue::Joint(id)) => {
                (*id, mechanism.joints.get(id.0).is_some_and(|joint| joint.bodies()[1] == body))
            }
            _ => (JointId(0), false),
        };
        let turns = |joint: &&Part| joint.component().name == "revolute";
        let shaft = joint("shaft").filter(turns).and_then(|shaft| ends_from(shaft, |body| body != cam));
        let Some(shaft) = shaft.filter(|[_, on]| on.body() == cam) else {
            let message = format!("does not turn `{}`", name(cam));
            return Err(("shaft", message, "name the revolute joint between the carrier and the cam"));
        };
        let carrier = shaft[0].body();
        let guide = joint("guide").and_then(|guide| match guide.component().name {
            "prismatic" if guide.bodies() == [carrier, follower] => Some(FollowerGuide::Slide(guide)),
            "revolute" => ends_from(guide, |body| body == carrier)
                .filter(|ends| ends.map(Place::body) == [carrier, follower])
                .map(FollowerGuide::Pivot),
            _ => None,
        });
        let misfit = || {
            let (carrier, follower) = (name(carrier), name(follower));
            let message = format!("does not guide `{follower}` on `{carrier}`, on which the cam turns");
            (
                "guide",
                message,
                "name a prismatic joint from the carrier to the follower, or a revolute joint between them",
            )
        };
        let joints = [known("shaft", cam), known("guide", follower)];
        Ok(Mounting { carrier, shaft, guide: guide.ok_or_else(misfit)?, joints })
    }
}

/// The points of a joint, that of the body which `first` selects before the other.
fn ends_from(joint: &Part, first: impl Fn(Option<BodyId>) -> bool) -> Option<[Place; 2]> {
    let [a, b] = joint.between;
    match [a, b].map(|place| first(place.body())) {
        [true, false] => Some([a, b]),
        [false, true] => Some([b, a]),
        _ => None,
    }
}

/// A formula as an expression; a variable of the part itself is the argument of its law.
pub(super) fn value(arena: &mut Arena, formula: &Formula) -> Expr {
    translate(arena, formula, &mut |arena, _| arena.symbol(Symbol::Argument))
}

/// Two formulas as expressions.
pub(super) fn values(arena: &mut Arena, formulas: &[Formula; 2]) -> [Expr; 2] {
    formulas.each_ref().map(|formula| value(arena, formula))
}

/// Where a point is in the axes of its body, from its mass centre, or on the ground.
pub(super) fn place(arena: &mut Arena, mechanism: &Mechanism, place: Place) -> [Expr; 2] {
    match place {
        Place::Origin | Place::Centre(_) => [Expr::ZERO; 2],
        Place::Ground(point) => values(arena, &mechanism.ground[point].at),
        Place::Point(body, point) => values(arena, &mechanism.bodies[body.0].points[point].at),
    }
}
