//! A flat rectangle with its sides along the body's axes: I = m (w^2 + h^2)/12.

use super::{Flaw, Shape, Solid, difference, middle, square};
use crate::expr::{Function, Unary};
use crate::model::{Formula, Outline};
use crate::scene::key::{Form, Key};
use crate::scene::{Corner, Shape as Built, constant};

pub(super) const PLATE: Shape = Shape {
    about: "a flat rectangle",
    equations: "m = density width height, I = m (width^2 + height^2)/12",
    example: "{ plate = [[-0.1, -0.02], [0.1, 0.02]], density = \"21 kg/m2\" }",
    flaw,
    ..Shape::flat(
        Key::one_of("plate", Form::Corners(2, 2), "two opposite corners; its sides are along the body's axes"),
        solid,
    )
};

fn solid(corners: &[[Formula; 2]], _value: &dyn Fn(&str) -> Formula) -> Solid {
    let ends = [&corners[1], &corners[0]];
    let [width, height] = difference(ends);
    let [[left, low], [right, high]] = [corners[0].clone(), corners[1].clone()];
    let outline = vec![corners[0].clone(), [right, low], corners[1].clone(), [left, high]];
    Solid {
        size: constant::apply(Function::One(Unary::Abs), vec![width.clone() * height.clone()]),
        centre: middle(ends),
        gyration: square([width, height]) / Formula::Number(12.0),
        outline: Outline::Polygon(outline),
    }
}

fn flaw(corners: &[[f64; 2]]) -> Option<Flaw> {
    let flat = (0..2).any(|axis| corners[0][axis] == corners[1][axis]);
    flat.then(|| (1, "has no area".to_string(), "give two opposite corners, such as `[[0, 0], [0.4, 0.1]]`"))
}

impl Built {
    /// A flat rectangle between two opposite corners, with its sides along the body's axes.
    pub fn plate(first: impl Into<Corner>, second: impl Into<Corner>) -> Built {
        Built::new("plate", vec![first.into(), second.into()])
    }
}
