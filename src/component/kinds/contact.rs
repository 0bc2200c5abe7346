//! Contact (k): a point, or a disc about it, on the left of a line of the first body: n.r >= radius, with n = k x u across the line; or outside or inside of a circle about the first point. It presses and
//! never pulls: fn >= 0, and fn = 0 while it is open. Or it touches a profile, a chain of lines and arcs: then the lines and arcs that it touches are contacts, which events choose. Impacts follow Newton's law: it leaves with the share `restitution` of the speed with which it came.

use crate::component::frame::{Placed, minus, sum};
use crate::component::key::{BETWEEN_POINTS, Form, Key, Record};
use crate::component::{Component, Icon, IconStroke, Rubs};
use crate::diagnostic::Fault;
use crate::expr::Expr;
use crate::model::measure::{FORCE, LENGTH, NUMBER, VELOCITY};
use crate::model::{Formula, GapLaw, Mechanism, Part, Pressed, Quantity as Q, Range};
use crate::network::{Coupling, CouplingTerm, Direction, Port, Rows, System};
use crate::scene::{Corner, Joint, Quantity, Vector, constant};

/// Where the point can be, seen along the line; the first by default.
const SIDES: [&str; 2] = ["left", "right"];
/// Where it can be of a circle; the first by default.
const OF_CIRCLE: [&str; 2] = ["outside", "inside"];
const ALL_SIDES: [&str; 4] = [SIDES[0], SIDES[1], OF_CIRCLE[0], OF_CIRCLE[1]];
/// What distinguishes the places where a profile is touched at once.
const SLOTS: [&str; 3] = ["", "second", "third"];
const ZERO: Formula = Formula::Number(0.0);

pub(crate) const CONTACT: Component = Component {
    about: "unilateral contact of a point, or a disc about it, with a line, a circle or a profile of the first body",
    equations: "n.r >= radius, or |r| >= circle + radius, or |r| <= circle - radius; at a profile each of its lines and arcs; fn >= 0",
    keys: &[
        BETWEEN_POINTS,
        Key::one_of("axis", Form::Axis, "`axis = [1.0, 0.0]` is the direction of a line through the first point"),
        Key::one_of(
            "circle",
            Form::Constant(LENGTH, Range::Positive),
            "`circle = \"0.5 m\"` is the radius of a circle about the first point",
        ),
        Key::one_of(
            "profile",
            Form::Profile,
            "`profile = [[0, 0], [0.1, 0], { to = [0.2, 0.1], radius = \"0.1 m\" }]` is a chain of lines and arcs from the first point, in the axes of its body",
        ),
        Key::default("closed", Form::Switch, "true for a `profile` whose last corner leads to the first", "false"),
        Key::optional(
            "radius",
            Form::Constant(LENGTH, Range::NotNegative),
            "the radius of a disc about the second point",
        ),
        Key::optional(
            "friction",
            Form::Record(Record::Friction([FORCE, VELOCITY], Pressed::Contact)),
            "Coulomb friction along the line or the circle",
        ),
        Key::optional("restitution", Form::Constant(NUMBER, Range::Share), "the coefficient of restitution"),
        Key::optional(
            "side",
            Form::Choice(
                &ALL_SIDES,
                "a point stays on the `left` or the `right` of its line or profile, `outside` or `inside` of its circle",
            ),
            "on which side of the line the point stays, seen along the axis, or of the profile, seen along it; or of the circle, `outside` by default",
        ),
    ],
    variables: &[Q::Gap, Q::S, Q::V, Q::A, Q::Fn, Q::Ft, Q::Impulse, Q::Mode, Q::Sliding],
    reactions: &[],
    undriven: ["a contact", "a driver moves a revolute or prismatic joint"],
    gaps,
    relation,
    rubs: Rubs::joint(Pressed::Contact, slip),
    check,
    ..Component::joint("contact", rows, placed, icon)
};

/// In a mirror the point is on the other side of its line.
fn placed(placed: &mut Placed<'_>) {
    if placed.part.contour().is_some() && placed.frame.is_placed() {
        const HELP: &str = "write the contact in the scene itself, with the coordinates that its profile has there";
        placed.refuse("profile", "its profile, which has numbers for its coordinates", HELP);
        return;
    }
    placed.axis("axis", placed.part.between[0]);
    if !is_circle(placed.part) {
        placed.side("side", SIDES);
    }
}

fn rows(_: &Part, _: &mut System) -> Rows {
    Rows { letter: "k", ..Rows::default() }
}

fn is_circle(part: &Part) -> bool {
    part.value("circle").is_some()
}

fn is_inside(part: &Part) -> bool {
    part.choice("side") == Some(OF_CIRCLE[1])
}

/// Its side must be one of a line, or of a circle, that has room for the disc.
fn check(part: &Part, mechanism: &Mechanism) -> Vec<Fault> {
    let (words, what) = match (is_circle(part), part.contour()) {
        (true, _) => (OF_CIRCLE, "circle"),
        (false, Some(_)) => (SIDES, "profile"),
        (false, None) => (SIDES, "line"),
    };
    let fault = |message: String| Fault::new("scene::wrong_value", message, part.span);
    if let Some(side) = part.choice("side").filter(|side| !words.contains(side)) {
        let message = format!("`side` of joint `{}` is `{side}`, but it touches a {what}", part.name);
        let help = format!("write `side = \"{}\"` or `side = \"{}\"`", words[0], words[1]);
        return vec![fault(message).label(format!("not a side of a {what}")).help(help)];
    }
    let parameters = mechanism.parameter_values();
    let [circle, radius] = ["circle", "radius"].map(|key| constant::evaluate(part.formula(key), &parameters));
    if is_circle(part) && is_inside(part) && radius >= circle {
        let message = format!("the disc of joint `{}` does not fit into its circle", part.name);
        return vec![fault(message).label("too large").help("make `radius` smaller than `circle`")];
    }
    Vec::new()
}

fn icon(part: &Part) -> Icon {
    if is_circle(part) || part.contour().is_some() {
        return Icon::Line(|length| vec![IconStroke::open(vec![[0.0, 0.0], [length, 0.0]])]);
    }
    let axis = part.vector("axis");
    // What is drawn on a line is on its left.
    let is_right = part.choice("side") == Some(SIDES[1]);
    let axis = if is_right { axis.map(|component| Formula::Number(-1.0) * component) } else { axis };
    Icon::Rolling { axis, radius: part.formula("radius").clone() }
}

fn gaps(part: &Part, _: &Mechanism) -> Vec<GapLaw> {
    if let Some(contour) = part.contour() {
        let restitution = part.key("restitution");
        let of = |word| GapLaw { word, sign: 1.0, bound: ZERO, restitution: restitution.clone(), of_rate: false };
        return SLOTS.into_iter().take(contour.most_places()).map(of).collect();
    }
    let (radius, circle, restitution) = (part.key("radius"), part.key("circle"), part.key("restitution"));
    let (sign, bound) = match (is_circle(part), is_inside(part)) {
        (false, _) => (1.0, radius),
        (true, false) => (1.0, sum(radius, circle)),
        (true, true) => (-1.0, minus(circle, radius)),
    };
    vec![GapLaw { word: "", sign, bound, restitution, of_rate: false }]
}

/// n.r, or |r|
fn relation(part: &Part, system: &mut System) -> Option<Coupling> {
    if part.contour().is_some() {
        // Each place where it is touched has the relation of its own feature.
        return None;
    }
    if is_circle(part) {
        return Some(Coupling::of(Port::Length(part.between.map(|place| system.t_node(place)))));
    }
    let [ux, uy] = system.values(&part.vector("axis"));
    let normal = match part.choice("side") == Some(SIDES[1]) {
        true => [uy, system.arena.negate(ux)],
        false => [system.arena.negate(uy), ux],
    };
    let ends = part.between.map(|place| system.t_node(place));
    Some(Coupling::of(Port::Along(ends, Direction::Fixed(part.between[0].body(), normal))))
}

/// s + radius theta: where the disc touches, as [`super::rolling`] has it. On the right of the line radius theta has the other sign.
fn slip(part: &Part, system: &mut System) -> Option<Coupling> {
    if is_circle(part) {
        return Some(slip_on_circle(part, system));
    }
    let along = Direction::Fixed(part.between[0].body(), system.values(&part.vector("axis")));
    let mut relation = Coupling::of(Port::Along(part.between.map(|place| system.t_node(place)), along));
    let radius = system.value(part.formula("radius"));
    if radius != Expr::ZERO {
        let factor = if part.choice("side") == Some(SIDES[1]) { system.arena.negate(radius) } else { radius };
        let turn = part.bodies().map(|body| system.r_node(body));
        relation.terms.push(CouplingTerm { factor, port: Port::Angle(turn) });
    }
    Some(relation)
}

/// (circle + radius) phi - circle theta_1 - radius theta_2, with the heading phi of the second point seen from the first: the way on which the disc slides about the circle, for where they touch its rate is
/// that of the disc there against the circle. Inside the radius has the other sign.
fn slip_on_circle(part: &Part, system: &mut System) -> Coupling {
    let [circle, radius] = ["circle", "radius"].map(|key| system.value(part.formula(key)));
    let radius = if is_inside(part) { system.arena.negate(radius) } else { radius };
    let heading = Port::Heading(part.between.map(|place| system.t_node(place)));
    let mut terms = vec![CouplingTerm { factor: system.arena.add(circle, radius), port: heading }];
    let ground = system.r_node(None);
    for (body, offset) in part.bodies().into_iter().zip([circle, radius]) {
        if body.is_some() && offset != Expr::ZERO {
            let port = Port::Angle([ground, system.r_node(body)]);
            terms.push(CouplingTerm { factor: system.arena.negate(offset), port });
        }
    }
    Coupling { terms, offset: Expr::ZERO }
}

impl Joint {
    /// A point, the second, that stays on the left of a chain of straight lines between these corners, from the first point in the axes of its body.
    pub fn contact_with_profile<C: Into<Corner>>(
        first: &str,
        second: &str,
        corners: impl IntoIterator<Item = C>,
    ) -> Joint {
        Joint::new("contact", first, second).set("profile", Corner::list(corners))
    }

    /// A point, the second, that stays outside of a circle about the first point.
    pub fn contact_with_circle(first: &str, second: &str, radius: impl Into<Quantity>) -> Joint {
        Joint::new("contact", first, second).set("circle", radius.into())
    }

    /// A point, the second, that stays on the left of a line through the first point.
    pub fn contact(first: &str, second: &str, axis: impl Into<Vector>) -> Joint {
        Joint::new("contact", first, second).set("axis", axis.into())
    }
}
