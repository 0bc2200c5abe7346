//! Scenes: a mechanism in the words of the workshop, before any name is resolved.
//!
//! A [`Scene`] is read from TOML or JSON, or built in Rust; [`Scene::resolve`] turns it into a
//! [`Mechanism`](crate::mechanism::Mechanism). Whatever is wrong is collected and reported at once, as [`Faults`].

mod builder;
mod constant;
mod decode;
mod dimension;
mod document;
mod expression;
mod fault;
mod joints;
mod json;
mod model;
mod quantity;
mod render;
mod resolve;
mod span;
pub(crate) mod suggest;
mod unit;

pub use crate::mechanism::Side;
pub use fault::{Fault, Faults, Severity};
pub use model::{
    Body, Coordinates, Driver, DriverKind, Experiment, Friction, Initial, Input, InputAs, Joint, JointKind, Load,
    LoadKind, Motion, Outputs, Parameter, Point, Scene, Solver, Turning, Vector,
};
pub use quantity::{Quantity, Value};
pub(crate) use quantity::{Reading, read};
pub use resolve::Resolved;
pub use span::{Source, Span, Text};
