//! Laws in pieces and steep laws along a step.
//!
//! * `switch`: switching functions of laws in pieces, and their roots; `bernstein`: bounds of polynomials.
//! * `course`: where the argument of a steep law may hide it from the ends of a step.
//! * `sliding`: switches that a motion does not leave.
//! * `layers`, `monitor`: the same along the polynomial of a series, and along the dense output of a Runge-Kutta step.
//!
//! A truncated series, or a few stages, know a law near where they evaluate it, not its values far away: dry friction F tanh(v/v0) is constant to
//! rounding on either side of a layer about v = 0, and so is a narrow bump on either side of itself. But the *argument* of the law is known over
//! the whole step. It is followed there, and the law is evaluated where the argument says that it may be steep.

pub(crate) mod bernstein;
mod course;
mod layers;
mod monitor;
pub(crate) mod sliding;
pub(crate) mod switch;

pub(crate) use course::SECTIONS;
pub(crate) use layers::Layers;
pub(crate) use monitor::{Monitor, ONE_SWITCH, Objection, Overlooked, Span, work_of_laws};
pub use switch::{Choices, SwitchSign};

/// Half width of the layer about zero outside which a saturating function differs from its limits by no more than a share of them: 1 - tanh a
/// is 2 exp(-2 a), its first coefficient twice that.
pub(crate) fn half_width(share: f64) -> f64 {
    0.5 * libm::log(4.0 / share)
}
