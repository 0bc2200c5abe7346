//! Shapes of bodies: each file is one uniform shape, with its keys, its size, mass centre and moment of inertia in closed form.
//! Nothing else in the program knows what shapes there are.

mod disc;
mod plate;
mod polygon;
mod rod;

use crate::mechanism::measure::{AREA, AREA_DENSITY, DENSITY, LENGTH, LINE_DENSITY, Wanted};
use crate::mechanism::{Formula, Outline};
use crate::scene::key::{Form, Key, Range};

/// Every shape.
pub(crate) const ALL: &[&dyn Shape] = &[&rod::Rod, &disc::Disc, &plate::Plate, &polygon::Polygon];

/// What there is to say of a shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facts {
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
}

impl Facts {
    /// All its keys.
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

/// One shape, in one place.
pub(crate) trait Shape: Sync {
    /// What there is to say of it.
    fn facts(&self) -> &'static Facts;

    /// Its size, mass centre and inertia; `value` is that of a key.
    fn solid(&self, corners: &[[Formula; 2]], value: &dyn Fn(&str) -> Formula) -> Solid;

    /// What is wrong with corners at these places.
    fn flaw(&self, corners: &[[f64; 2]]) -> Option<Flaw>;
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
    "must be given with a density in `kg/m3`",
);

/// What flat shapes have in common.
const FLAT: Facts = Facts {
    place: Key::one_of("", Form::Corner, ""),
    keys: &[],
    depth: THICKNESS,
    density: AREA_DENSITY,
    about: "",
    equations: "",
    example: "",
};

/// What long shapes have in common.
const LONG: Facts = Facts {
    depth: Key::default(
        "area",
        Form::Constant(AREA, Range::Positive),
        "the area of its cross-section, with a density in `kg/m3`",
        "must be given with a density in `kg/m3`",
    ),
    density: LINE_DENSITY,
    ..FLAT
};

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
