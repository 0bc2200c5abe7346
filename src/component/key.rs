//! Keys that several components have.

pub(super) use crate::model::Range;
pub(super) use crate::scene::key::{Form, Key};
pub(super) use crate::scene::record::Record;

use crate::model::measure::{ANGLE, LENGTH};

pub(super) const BETWEEN_POINTS: Key = Key::required("between", Form::Points, "the two points", TWO_POINTS);
pub(super) const BETWEEN_WHEELS: Key =
    Key::required("between", Form::Bodies, "the two wheels", "give two bodies: `between = [\"BODY\", \"BODY\"]`");
pub(super) const BETWEEN_BODIES: Key = Key::required("between", Form::Bodies, "the two bodies", TWO_BODIES);
const TWO_POINTS: &str =
    "give two points: `between = [\"BODY.POINT\", \"BODY.POINT\"]`; the ground is a body, too: `ground.POINT`";
pub(super) const BODY_AND_POINT: &str = "give a body and a point: `between = [\"BODY\", \"BODY.POINT\"]`";
const TWO_BODIES: &str = "give two bodies: `between = [\"ground\", \"BODY\"]`";
pub(super) const ON_POINT: Key =
    Key::required("on", Form::Point, "the point", "give a point: `on = \"BODY\"` or `on = \"BODY.POINT\"`");
pub(super) const TWO_COMPONENTS: &str = "give two components, such as `[\"-20 N\", 0]`";
pub(super) const ENGAGED: Key = Key::default(
    "engaged",
    Form::Switch,
    "whether it is engaged at the start; [events](#events) engage and release it",
    "`true`",
);
pub(super) const AT: Key = Key::optional(
    "at",
    Form::Choice(
        &["here", "named"],
        "a joint engages \"here\", where it stands, or \"named\", in the pose that its constants give",
    ),
    "where it engages: where it stands, or in the pose that its constants give",
);
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
