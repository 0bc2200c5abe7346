//! Pictures of mechanisms and of what is found of them: SVG, PNG, DXF, plots, linear graphs.

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

mod alike;
mod carrier;
// Public for the crates above, the command and the tests of this repository.
#[doc(hidden)]
pub mod drawing;
#[doc(hidden)]
pub mod dxf;
#[doc(hidden)]
pub mod graph;
#[doc(hidden)]
pub mod letters;
#[doc(hidden)]
pub mod line;
#[doc(hidden)]
pub mod plot;
#[doc(hidden)]
pub mod png;
#[doc(hidden)]
pub mod pose;
#[doc(hidden)]
pub mod study;
#[doc(hidden)]
pub mod svg;
