//! Faults of a scene: where they are, what is wrong, what to do; and how they are shown.

pub mod degrees;
mod every;
pub mod fault;
mod layout;
mod messages;
pub(crate) mod metres;
pub(crate) mod render;
pub mod span;
pub mod suggest;
pub mod visible;

pub use every::{every, lines};
pub use fault::{Fault, FaultKind, Faults, Severity};
pub use messages::from_messages;
pub use span::{Source, Span, Text};
