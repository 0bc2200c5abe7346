//! stub
mod fault;
mod span;
pub use fault::{Fault, Faults, Severity};
pub use span::{Source, Span, Text};
