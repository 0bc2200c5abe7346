//! A flat disc about a place: I = m r^2/2.

use std::f64::consts::PI;

use super::{Shape, Solid};
use crate::model::measure::LENGTH;
use crate::model::{Formula, Outline, Range};
use crate::scene::key::{Form, Key};
use crate::scene::{Corner, Quantity, Shape as Built};

pub(super) const DISC: Shape = Shape {
    keys: &[Key::required(
        "radius",
        Form::Constant(LENGTH, Range::Positive),
        "its radius",
        "give the radius of the disc: `radius = \"60 mm\"`",
    )],
    about: "a flat disc",
    equations: "m = density pi radius^2, I = m radius^2/2",
    example: "{ disc = [0, 0], radius = \"60 mm\", thickness = \"12 mm\", density = \"7850 kg/m3\" }",
    ..Shape::flat(Key::one_of("disc", Form::Corner, "its centre"), solid)
};

fn solid(corners: &[[Formula; 2]], value: &dyn Fn(&str) -> Formula) -> Solid {
    let radius = value("radius");
    let square = radius.clone() * radius.clone();
    Solid {
        size: Formula::Number(PI) * square.clone(),
        centre: corners[0].clone(),
        gyration: square / Formula::Number(2.0),
        outline: Outline::Disc(corners[0].clone(), radius),
    }
}

impl Built {
    /// A flat disc.
    pub fn disc(centre: impl Into<Corner>, radius: impl Into<Quantity>) -> Built {
        Built::about("disc", centre.into()).set("radius", radius.into())
    }
}
