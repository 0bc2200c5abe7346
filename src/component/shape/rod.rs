//! A thin straight rod between two places: I = m l^2/12.

use super::{Flaw, Shape, Solid, difference, middle, square};
use crate::expr::{Function, Unary};
use crate::model::{Formula, Outline};
use crate::scene::key::{Form, Key};
use crate::scene::{Corner, Shape as Built, constant};

pub(super) const ROD: Shape = Shape {
    about: "a thin straight rod",
    equations: "m = density length, I = m length^2/12",
    example: "{ rod = [\"inner\", \"outer\"], density = \"2.1 kg/m\" }",
    flaw,
    ..Shape::long(Key::one_of("rod", Form::Corners(2, 2), "its two ends"), solid)
};

fn solid(corners: &[[Formula; 2]], _value: &dyn Fn(&str) -> Formula) -> Solid {
    let ends = [&corners[0], &corners[1]];
    let square = square(difference(ends));
    Solid {
        size: constant::apply(Function::One(Unary::Sqrt), vec![square.clone()]),
        centre: middle(ends),
        gyration: square / Formula::Number(12.0),
        outline: Outline::Polygon(corners.to_vec()),
    }
}

fn flaw(corners: &[[f64; 2]]) -> Option<Flaw> {
    (corners[0] == corners[1]).then(|| (1, "has both ends at the same point".to_string(), "give two different ends"))
}

impl Built {
    /// A thin straight rod between two places.
    pub fn rod(first: impl Into<Corner>, second: impl Into<Corner>) -> Built {
        Built::new("rod", vec![first.into(), second.into()])
    }
}
