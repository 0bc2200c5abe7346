//! Shapes of bodies: each file is one uniform shape, with its keys, its size, mass centre and moment of inertia in closed form.
//! Nothing else in the program knows what shapes there are.

mod disc;
mod plate;
mod polygon;
mod rod;

use crate::model::measure::{AREA, AREA_DENSITY, DENSITY, LENGTH, LINE_DENSITY, Wanted};
use crate::model::{Formula, Outline, Range};
use crate::scene::key::{Form, Key};

/// Every shape.
pub(crate) const ALL: &[&Shape] = &[&rod::ROD, &disc::DISC, &plate::PLATE, &polygon::POLYGON];

/// One shape, in one place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// Where it is in the body's frame; its name is the shape's.
    pub place: Key,
    /// Its other keys.
    pub keys: &'static [Key],
    /// What a density in kg/m3 is multiplied by beside the size.
    pub depth: Key,
    /// The density of its size: per length or per area.
    pub density: Wanted,
    /// What it is, in a few words.
    pub about: &'static str,
    /// Size, mass centre and moment of inertia as a text.
    pub equations: &'static str,
    /// What one writes for it.
    pub example: &'static str,
    /// Its size, mass centre and inertia from its corners and the values of its keys.
    pub solid: SolidOf,
    /// What is wrong with corners at these places.
    pub flaw: fn(&[[f64; 2]]) -> Option<Flaw>,
}

type SolidOf = fn(&[[Formula; 2]], &dyn Fn(&str) -> Formula) -> Solid;

impl Shape {
    /// What flat shapes have in common.
    const fn flat(place: Key, solid: SolidOf) -> Shape {
        Shape {
            place,
            keys: &[],
            depth: THICKNESS,
            density: AREA_DENSITY,
            about: "",
            equations: "",
            example: "",
            solid,
            flaw: |_| None,
        }
    }

    /// What long shapes have in common.
    const fn long(place: Key, solid: SolidOf) -> Shape {
        Shape { depth: SECTION, density: LINE_DENSITY, ..Shape::flat(place, solid) }
    }

    pub fn all_keys(&self) -> Vec<Key> {
        let first = std::iter::once(self.place).chain(self.keys.iter().copied());
        first.chain([DENSITY_KEY, self.depth]).collect()
    }
}

/// A uniform shape with these corners.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    /// Its length or area.
    pub size: Formula,
    /// Its mass centre in the body's frame.
    pub centre: [Formula; 2],
    /// Its moment of inertia about the mass centre over its mass.
    pub gyration: Formula,
    /// What is drawn, in the body's frame.
    pub outline: Outline,
}

/// What is wrong with the corners of a shape: which of them, why, and what to do.
pub(crate) type Flaw = (usize, String, &'static str);

/// What is wrong with the corners of a polygon that may be listed in either order; the same of the two ends of a rod.
pub(crate) fn flaw_of_outline(corners: &[[f64; 2]]) -> Option<Flaw> {
    match corners.len() {
        0 | 1 => None,
        2 => (rod::ROD.flaw)(corners),
        _ => polygon::flaw_of_boundary(corners),
    }
}

/// How dense it is.
pub(crate) const DENSITY_KEY: Key = Key::default(
    "density",
    Form::Constant(DENSITY, Range::Positive),
    "its density: `kg/m3`, or per length or area in `kg/m` or `kg/m2`",
    "`mass` of the body",
);

const THICKNESS: Key = Key::default(
    "thickness",
    Form::Constant(LENGTH, Range::Positive),
    "its thickness, with a density in `kg/m3`",
    "required with a density in `kg/m3`",
);

const SECTION: Key = Key::default(
    "area",
    Form::Constant(AREA, Range::Positive),
    "the area of its cross-section, with a density in `kg/m3`",
    "required with a density in `kg/m3`",
);

/// The vector from one place to another.
fn difference([to, from]: [&[Formula; 2]; 2]) -> [Formula; 2] {
    [to[0].clone() - from[0].clone(), to[1].clone() - from[1].clone()]
}

/// x^2 + y^2
fn square([x, y]: [Formula; 2]) -> Formula {
    x.clone() * x + y.clone() * y
}

/// Half way between two places.
fn middle([a, b]: [&[Formula; 2]; 2]) -> [Formula; 2] {
    let half = |axis: usize| (a[axis].clone() + b[axis].clone()) / Formula::Number(2.0);
    [half(0), half(1)]
}
