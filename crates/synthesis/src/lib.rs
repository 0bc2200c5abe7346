//! Dimensional synthesis of planar linkages: motion, function and path generation, and linkages with a given stroke.
//!
//! Points of the plane are complex numbers \[m\], angles are in radians. Nothing here reads a clock or a file, or starts a thread.
//!
//! | | |
//! |---|---|
//! | [`dyads`] | all dyads that take a body through poses: bars, sliders, slots |
//! | [`couplers`] | four-bars and slider-cranks whose output follows their input |
//! | [`path`] | four-bars whose coupler point follows a path |
//! | [`within`], [`bounded_couplers`] | the same within limits, which are bounds of the search |
//! | [`six`] | six-bars for paths, functions and poses |
//! | [`stroke`] | crank-rockers and slider-cranks with a given swing, time ratio and the best transmission angle |
//! | [`tolerance`] | what deviations of lengths and pivots do |
//! | [`judge`] | does a linkage reach all poses, in one motion and in order? |
//! | [`LinkageLimits`] | what else is asked of a linkage |

#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        reason = "no input may cause a panic"
    )
)]

mod atlas;
mod bounded;
mod chain;
mod cognates;
mod conics;
mod corridor;
mod defects;
mod dyad;
mod function;
mod function_within;
mod least;
mod limits;
mod linkage;
pub mod path;
mod poses;
mod random;
mod sextic;
pub mod six;
pub mod stroke;
pub mod tolerance;
mod valley;
pub mod within;

pub use cognates::{cognates, coupler_cognates};
pub use corridor::reach;
pub use defects::{Defect, Verdict, judge};
pub use dyad::{Dyad, DyadCondition, Family, circle_dyad, dyads, nearest_dyads};
pub use function::{
    Coupler, Pair, Zero, couplers, freudenstein, nearest_couplers, nearest_slider_cranks, slider_cranks,
};
pub use function_within::bounded_couplers;
pub use limits::{LinkageLimit, LinkageLimits, Region};
pub use linkage::{Linkage, Side};
pub use nalgebra::Complex;
pub use poses::{Pose, Special, extent, special, way};
pub use random::RandomNumbers;

/// A point of the plane, or a vector \[m\].
pub type Point = Complex<f64>;

/// A vector by its length and its angle.
pub fn polar(length: f64, angle: f64) -> Point {
    Point::from_polar(length, angle)
}

/// a . b
pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a.re * b.re + a.im * b.im
}

/// a x b
pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a.re * b.im - a.im * b.re
}
