//! The keys of components: how each is written, in which unit, and what it says.

use crate::mechanism::measure::{ANGLE, LENGTH, Wanted};

/// A key of a component.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    pub name: &'static str,
    pub form: Form,
    pub need: Need,
    /// What it says, for the reference of the scene.
    pub about: &'static str,
}

/// Must a key be there?
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Need {
    /// Yes; the words say what to write.
    Required(&'static str),
    /// No; a number is zero then.
    Optional,
    /// Exactly one of those with this need; the words say what each does.
    OneOf(&'static str),
}

/// How the value of a key is written.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Form {
    /// Two points of different bodies.
    Points,
    /// Two different bodies.
    Bodies,
    /// A body and a point of another.
    BodyAndPoint,
    /// A point that can move.
    Point,
    /// A body; it is the second, the ground the first.
    Body,
    /// A joint that permits the motion: its bodies are those of this component.
    Joint,
    /// A third body, neither of the two; the ground if absent.
    CarrierBody,
    /// A point of such a body.
    CarrierPoint,
    /// A number of this measure that does not change.
    Constant(Wanted, Range),
    /// A law of this measure: whatever a load or a driver may depend on.
    Law(Wanted),
    /// A law with two components.
    Vector(Wanted),
    /// A direction.
    Axis,
    /// Dry friction with a level and a velocity.
    Friction([Wanted; 2]),
    /// A prescribed motion, its rate and its acceleration.
    Motion([Wanted; 3]),
    /// One of several words, the first by default; what to say of them, and what one of them is called.
    Choice(&'static [&'static str], &'static str),
}

impl Form {
    /// Does it say what the part is between?
    pub fn is_end(self) -> bool {
        use Form::{Bodies, Body, BodyAndPoint, Joint, Point, Points};
        matches!(self, Points | Bodies | BodyAndPoint | Point | Body | Joint)
    }

    /// Does it name a third body?
    pub fn is_carrier(self) -> bool {
        matches!(self, Form::CarrierBody | Form::CarrierPoint)
    }
}

/// Which values a number may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Range {
    Any,
    Positive,
    NotZero,
}

impl Key {
    pub const fn required(name: &'static str, form: Form, about: &'static str, help: &'static str) -> Key {
        Key { name, form, need: Need::Required(help), about }
    }

    pub const fn optional(name: &'static str, form: Form, about: &'static str) -> Key {
        Key { name, form, need: Need::Optional, about }
    }

    pub const fn one_of(name: &'static str, form: Form, about: &'static str) -> Key {
        Key { name, form, need: Need::OneOf(about), about }
    }
}

pub(super) const BETWEEN_POINTS: Key = Key::required("between", Form::Points, "the two points", TWO_POINTS);
pub(super) const BETWEEN_BODIES: Key = Key::required("between", Form::Bodies, "the two bodies", TWO_BODIES);
pub(super) const TWO_POINTS: &str = "give two points: `between = [\"ground.bearing\", \"crank.inner\"]`";
const TWO_BODIES: &str = "give two bodies: `between = [\"ground\", \"crank\"]`";
pub(super) const ON_POINT: Key =
    Key::required("on", Form::Point, "the point", "give a point: `on = \"slider\"` or `on = \"crank.outer\"`");
pub(super) const TWO_COMPONENTS: &str = "give two components, such as `[\"-gas_force\", 0.0]`";
pub(super) const AXIS: Key = Key::required(
    "axis",
    Form::Axis,
    "the direction in the first body's frame",
    "give the direction in the first body's frame: `axis = [1.0, 0.0]`",
);
pub(super) const ANGLE_BETWEEN: Key =
    Key::optional("angle", Form::Constant(ANGLE, Range::Any), "the second body's angle minus the first's");
pub(super) const DISPLACEMENT: Key =
    Key::optional("displacement", Form::Constant(LENGTH, Range::Any), "the displacement where the angle is zero");
pub(super) const CARRIER_BODY: Key = Key::optional(
    "carrier",
    Form::CarrierBody,
    "the body in which the wheels have their bearings; the ground if absent",
);
pub(super) const CARRIER_POINT: Key = Key::optional(
    "carrier",
    Form::CarrierPoint,
    "the point from which the displacement counts; the ground's origin if absent",
);
pub(super) const AXIS_OF_CARRIER: Key = Key::required(
    "axis",
    Form::Axis,
    "the direction in the carrier's frame",
    "give the direction in the carrier's frame: `axis = [1.0, 0.0]`",
);
