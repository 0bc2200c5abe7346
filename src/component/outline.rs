//! Outlines of bodies and of the ground, for clearance and for pictures: corners, and how far the outline reaches beyond what they enclose.
//! Nothing else in the program knows which kinds there are.

use super::shape::flaw_of_outline;
use crate::model::measure::LENGTH;
use crate::model::{Formula, Outline, Range};
use crate::scene::constant::evaluate;
use crate::scene::key::{Form, Key};
use crate::scene::{Corner, Outline as Built, Quantity};

/// Each two outlines have so many pairs of sides at most: the square of this.
const MOST: usize = 1000;

/// Every kind of outline.
pub(crate) const ALL: &[&OutlineKind] = &[&POLYGON, &ROD, &DISC];

/// One kind of outline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutlineKind {
    /// Its corners in the frame of the points; its name is the kind's.
    pub place: Key,
    /// The key that says how far it reaches beyond them.
    pub offset: Key,
    /// The reach is this share of the key's value.
    pub share: f64,
    /// What it is, in a few words.
    pub about: &'static str,
    /// What one writes for it.
    pub example: &'static str,
}

impl OutlineKind {
    pub fn keys(&self) -> [Key; 2] {
        [self.place, self.offset]
    }
}

const POLYGON: OutlineKind = OutlineKind {
    place: Key::one_of("polygon", Form::Corners(3, MOST), "its corners, in order"),
    offset: Key::default(
        "round",
        Form::Constant(LENGTH, Range::NotNegative),
        "the distance of the outline from the polygon, and the radius of its convex corners",
        "0",
    ),
    share: 1.0,
    about: "a polygon, convex or not",
    example: "{ polygon = [\"inner\", [0.3, -0.05], \"outer\"], round = \"2 mm\" }",
};

const ROD: OutlineKind = OutlineKind {
    place: Key::one_of("rod", Form::Corners(2, 2), "its two ends"),
    offset: Key::default(
        "width",
        Form::Constant(LENGTH, Range::NotNegative),
        "its width, with a semicircle at each end",
        "0",
    ),
    share: 0.5,
    about: "a straight bar with round ends",
    example: "{ rod = [\"inner\", \"outer\"], width = \"20 mm\" }",
};

const DISC: OutlineKind = OutlineKind {
    place: Key::one_of("disc", Form::Corner, "its centre"),
    offset: Key::required(
        "radius",
        Form::Constant(LENGTH, Range::NotNegative),
        "its radius",
        "give the radius of the disc: `radius = \"60 mm\"`",
    ),
    share: 1.0,
    about: "a disc",
    example: "{ disc = [0, 0], radius = \"60 mm\" }",
};

/// The corners of an outline and how far it reaches beyond them, with these values of the parameters.
///
/// # Errors
/// What is wrong with it then.
pub fn outline_at(outline: &Outline, parameters: &[f64]) -> Result<(Vec<[f64; 2]>, f64), String> {
    let value = |formula: &Formula| evaluate(formula, parameters);
    let point = |at: &[Formula; 2]| at.each_ref().map(value);
    let (corners, offset): (Vec<[f64; 2]>, f64) = match outline {
        Outline::Polygon(corners) => (corners.iter().map(point).collect(), 0.0),
        Outline::Disc(centre, radius) => (vec![point(centre)], value(radius)),
        Outline::Rounded(corners, offset) => (corners.iter().map(point).collect(), value(offset)),
    };
    if !corners.iter().flatten().chain([&offset]).all(|value| value.is_finite()) {
        return Err("has a coordinate that is not finite".to_owned());
    }
    if offset < 0.0 {
        return Err(format!("has a negative radius or width: it reaches {offset} m beyond its corners"));
    }
    flaw_of_outline(&corners).map_or(Ok((corners, offset)), |(_, problem, _)| Err(problem))
}

impl Built {
    /// A polygon with its corners in order.
    pub fn polygon<C: Into<Corner>>(corners: impl IntoIterator<Item = C>) -> Built {
        Built::new(POLYGON.place.name, corners.into_iter().map(Into::into).collect())
    }

    /// How far the outline lies outside its polygon; convex corners are rounded with this radius \[m\].
    #[must_use]
    pub fn round(self, radius: impl Into<Quantity>) -> Built {
        self.set(POLYGON.offset.name, radius.into())
    }

    /// A straight bar between two ends, of this width, with round ends \[m\].
    pub fn rod(first: impl Into<Corner>, second: impl Into<Corner>, width: impl Into<Quantity>) -> Built {
        Built::new(ROD.place.name, vec![first.into(), second.into()]).set(ROD.offset.name, width.into())
    }

    /// A disc with a centre and a radius \[m\].
    pub fn disc(centre: impl Into<Corner>, radius: impl Into<Quantity>) -> Built {
        Built::about(DISC.place.name, centre.into()).set(DISC.offset.name, radius.into())
    }
}
