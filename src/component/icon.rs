//! What is drawn for components: signs that the drawing puts together without knowing for which component.

use crate::model::{BodyId, Formula, Place};

/// A sign of a drawing. Where nothing else is said it is at the two points of the part.
#[derive(Clone)]
pub enum Icon {
    /// A pin that holds the points together.
    Pin,
    /// A block that slides along an axis of the first body.
    Slider([Formula; 2]),
    /// A pin in a slot along an axis of the first body.
    Slot([Formula; 2]),
    /// Both bodies as one.
    Fixed,
    /// A rod with a pin at each end.
    Link,
    /// Two toothed wheels that turn in a ratio on a carrier.
    Gears { ratio: Formula, carrier: Option<BodyId> },
    /// Two smooth wheels on a carrier with a band around them.
    Band { carrier: Option<BodyId>, radii: [Formula; 2], crossed: bool },
    /// A toothed wheel on a toothed bar that moves along an axis of the carrier.
    Rack { carrier: Place, axis: [Formula; 2], radius: Formula },
    /// A disc on a line along an axis of the first body.
    Rolling { axis: [Formula; 2], radius: Formula },
    /// A cam with its profile, and what of the follower touches it.
    Cam,
    /// Strokes along the line between the points.
    Line(Glyph),
    /// An arrow on the second point, in the world's axes or the body's.
    Arrow { vector: [Formula; 2], in_body: bool },
    /// A round arrow, at a joint between the bodies if there is one.
    Turn,
    /// Strokes around such a joint.
    Round(RoundGlyph),
    /// An arrow along the joint that slides between the points.
    Push,
    /// Cross hairs on the second point, and where it goes.
    Target([Formula; 2]),
}

/// The strokes of a sign of this length, from (0, 0) to (length, 0). One is the radius of a pin.
pub type Glyph = fn(f64) -> Vec<IconStroke>;

/// The strokes of a sign around (0, 0), y up. One is the radius of a pin.
pub type RoundGlyph = fn() -> Vec<IconStroke>;

/// A line of a sign.
#[derive(Clone, Debug, PartialEq)]
pub struct IconStroke {
    pub points: Vec<[f64; 2]>,
    /// Is it an area with this outline? Else a line.
    pub closed: bool,
}

impl IconStroke {
    /// An arc about (0, 0) from one radius and angle \[rad\] to another.
    pub fn arc(radii: [f64; 2], angles: [f64; 2]) -> IconStroke {
        let steps = 4 + (12.0 * (angles[1] - angles[0]).abs()) as usize;
        let at = |[from, to]: [f64; 2], share: f64| from + share * (to - from);
        let point = |step: usize| {
            let share = step as f64 / steps as f64;
            let (sine, cosine) = libm::sincos(at(angles, share));
            [at(radii, share) * cosine, at(radii, share) * sine]
        };
        IconStroke::open((0..=steps).map(point).collect())
    }

    pub fn open(points: Vec<[f64; 2]>) -> IconStroke {
        IconStroke { points, closed: false }
    }
}
