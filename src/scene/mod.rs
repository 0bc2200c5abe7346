//! Scenes: a mechanism in the words of the workshop, before any name is resolved.
//!
//! A [`Scene`] is read from TOML or JSON, or built in Rust; [`Scene::resolve`] turns it into a
//! [`Mechanism`](crate::model::Mechanism). Whatever is wrong is collected and reported at once, as [`Faults`].

mod brackets;
mod builder;
pub mod constant;
pub(crate) mod decode;
pub(crate) mod dimension;
pub(crate) mod document;
mod edit;
pub(crate) mod expression;
mod json;
pub mod key;
pub(crate) mod lookalike;
pub(crate) mod model;
pub(crate) mod part;
pub mod quantity;
pub mod record;
mod requested;
mod slips;
pub(crate) mod tables;
pub(crate) mod unit;

pub use crate::diagnostic::{Fault, Faults, Severity, Source, Span, Text};
pub use edit::{Edit, EditError, EntryPlace, edited};
pub use model::{
    Clearance, Coordinates, Event, Experiment, Initial, Input, InputAs, Motion, Outputs, Parameter, Point, Sampled,
    SampledValue, Scene, Signal, Solver, State, Vector,
};
pub use part::{Body, Corner, Driver, Joint, Load, Outline, Part, Shape, Side};
pub use quantity::{Quantity, Value};
pub(crate) use quantity::{QuantityReading, read};
pub use requested::Requested;

/// A scene without faults.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// The mechanism.
    pub mechanism: crate::model::Mechanism,
    /// What is asked of it.
    pub outputs: Vec<crate::model::Output>,
    /// What is worth a look all the same.
    pub warnings: Vec<Fault>,
}

impl Resolved {
    /// Why a later step refuses the scene, beside the warnings so far: they may name the cause.
    pub fn refused(&self, source: &Source, errors: Vec<Fault>) -> Faults {
        let mut all = [self.warnings.clone(), errors].concat();
        all.sort_by_key(|fault| fault.span.start);
        Faults::new(source.clone(), all)
    }
}
