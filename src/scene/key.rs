//! The keys of a scene: how each is written, in which unit, and what it says. Tasks have keys of the same kind, written in forms of their own.

use super::record::Record;
pub use crate::model::Range;
use crate::model::measure::Wanted;

/// A key of a table.
#[derive(Clone, Copy, Debug)]
pub struct Key<F = Form> {
    pub name: &'static str,
    pub form: F,
    pub need: Need,
    /// What it says, for the reference of the scene.
    pub about: &'static str,
}

/// Must a key be there?
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Need {
    /// Yes; the words say what to write.
    Required(&'static str),
    /// No; a number is zero then.
    Optional,
    /// No; the words say what holds then.
    Default(&'static str),
    /// Exactly one of those with this need; the words say what each does.
    OneOf(&'static str),
    /// Yes, unless an event engages the joint where it stands; the words say what to write.
    Captured(&'static str),
    /// Yes, unless the part runs over pulleys or onto a drum; the words say what to write.
    RequiredAlone(&'static str),
}

/// How the value of a key is written.
#[derive(Clone, Copy, Debug)]
pub enum Form {
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
    /// A joint beside which it acts.
    OtherJoint,
    /// A third body, neither of the two; the ground if absent.
    CarrierBody,
    /// A point of such a body.
    CarrierPoint,
    /// A number of this measure that does not change.
    Constant(Wanted, Range),
    /// A law of this measure: whatever a load or a driver may depend on.
    Law(Wanted),
    /// A function of the part's own angle, of the first measure if the joint of this key slides, else of the second.
    Curve(&'static str, [Wanted; 2]),
    /// A law with two components.
    Vector(Wanted),
    /// Two components that do not change.
    ConstantVector(Wanted),
    /// A direction.
    Axis,
    /// Several values together, in a table with keys of its own.
    Record(Record),
    /// A prescribed motion, its rate and its acceleration.
    Motion([Wanted; 3]),
    /// One of several words, the first by default; what to say of them, and what one of them is called.
    Choice(&'static [&'static str], &'static str),
    /// True or false.
    Switch,
    /// A text.
    Text,
    /// A unit of this measure.
    UnitOf(Wanted),
    /// A list of names.
    Names,
    /// A table of names with points.
    NamedPoints,
    /// One place in a body: the name of one of its points, or two coordinates.
    Corner,
    /// So many places in a body, at least and at most.
    Corners(usize, usize),
    /// A shape with a density.
    Shape,
    /// An outline.
    Outline,
    /// A list of pairs of bodies or the ground.
    Pairs,
    /// A table with keys of its own, or several.
    Table,
    /// Two points of different bodies, or drums.
    Ends,
    /// A list of pulleys.
    Course,
    /// Corners that lines and arcs connect.
    Profile,
}

impl Form {
    /// Does it say what the part is between?
    pub fn is_end(self) -> bool {
        use Form::{Bodies, Body, BodyAndPoint, Ends, Joint, Point, Points};
        matches!(self, Ends | Points | Bodies | BodyAndPoint | Point | Body | Joint)
    }

    /// True if it makes a joint hold something on one side only.
    pub fn is_one_sided(self) -> bool {
        matches!(self, Form::Record(record) if record.is_one_sided())
    }

    /// Does it name a third body?
    pub fn is_carrier(self) -> bool {
        matches!(self, Form::CarrierBody | Form::CarrierPoint)
    }
}

impl<F> Key<F> {
    pub const fn required(name: &'static str, form: F, about: &'static str, help: &'static str) -> Key<F> {
        Key { name, form, need: Need::Required(help), about }
    }

    pub const fn optional(name: &'static str, form: F, about: &'static str) -> Key<F> {
        Key { name, form, need: Need::Optional, about }
    }

    /// One that only a part over pulleys or onto a drum can do without.
    pub const fn required_alone(name: &'static str, form: F, about: &'static str, help: &'static str) -> Key<F> {
        Key { name, form, need: Need::RequiredAlone(help), about }
    }

    /// One that may be left out; `otherwise` is what holds then.
    pub const fn default(name: &'static str, form: F, about: &'static str, otherwise: &'static str) -> Key<F> {
        Key { name, form, need: Need::Default(otherwise), about }
    }

    /// One that an event may give by where a joint engages.
    pub const fn captured(name: &'static str, form: F, about: &'static str, help: &'static str) -> Key<F> {
        Key { name, form, need: Need::Captured(help), about }
    }

    pub const fn one_of(name: &'static str, form: F, about: &'static str) -> Key<F> {
        Key { name, form, need: Need::OneOf(about), about }
    }

    /// What to write if it is missing; empty if it need not be there.
    pub fn help(&self) -> &'static str {
        if let Need::Required(help) | Need::RequiredAlone(help) = self.need { help } else { "" }
    }
}

/// The names of some keys.
pub(crate) fn names<F>(keys: &[Key<F>]) -> Vec<&'static str> {
    keys.iter().map(|key| key.name).collect()
}
