//! What an FMU carries beside the model, its page and its pictures; the page that shows a mechanism in motion, and films.

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

// Public for the crates above, the command and the tests of this repository.
#[doc(hidden)]
pub mod accuracy;
#[doc(hidden)]
pub mod desk;
#[doc(hidden)]
pub mod documentation;
mod export;
#[doc(hidden)]
pub mod film;
#[doc(hidden)]
pub mod icon;
mod motionless;
#[doc(hidden)]
pub mod moving;
#[doc(hidden)]
pub mod overview;
#[doc(hidden)]
pub mod page;
#[doc(hidden)]
pub mod pull;
#[doc(hidden)]
pub mod serve;
#[doc(hidden)]
pub mod sketch;

#[doc(hidden)]
pub use export::Made;
pub use export::export_fmu;
#[doc(hidden)]
pub use motionless::MotionlessError;
