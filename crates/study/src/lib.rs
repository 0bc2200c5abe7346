//! What is asked of a mechanism beyond its motion: equilibria, linear systems, modes, sensitivities; sweeps and fits; one turn of an
//! input; what other trees and methods cost.

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
pub mod analysis;
#[doc(hidden)]
pub mod bench;
#[doc(hidden)]
pub mod compare;
#[doc(hidden)]
pub mod contact;
#[doc(hidden)]
pub mod fit;
#[doc(hidden)]
pub mod motion;
#[doc(hidden)]
pub mod optimize;
#[doc(hidden)]
pub mod request;
#[doc(hidden)]
pub mod sweep;
#[doc(hidden)]
pub mod synthesis;
