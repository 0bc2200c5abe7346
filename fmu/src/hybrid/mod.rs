//! Instants at which something happens: ticks, known beforehand, and events, when a comparison begins to hold.
//!
//! What happens changes discrete variables only; between instants they are constant, so that every method integrates as if they were inputs at rest. Nothing here remembers anything.

mod ahead;
pub(crate) mod contact;
pub(crate) mod contour;
pub(crate) mod descent;
pub(crate) mod engage;
mod islands;
pub(crate) mod modes;
pub(crate) mod onset;
mod redundant;
pub(crate) mod tick;
