//! What changes at instants: values at ticks, and what happens when a comparison begins to hold.
//!
//! All of it acts through discrete variables, which are constant in between.

use super::{Comparison, DiscreteId, Formula, Mechanism, Owner, StateId};
use crate::diagnostic::Span;

/// Values that change together at offset + k period, k = 0, 1, ...
#[derive(Clone, Debug, PartialEq)]
pub struct Sampler {
    /// The user's name.
    pub name: String,
    /// From tick to tick \[s\]; constants and parameters only.
    pub period: Formula,
    /// The first tick \[s\]; constants and parameters only.
    pub offset: Formula,
    /// What each value is from a tick on, seen from just before it.
    pub writes: Vec<(DiscreteId, Formula)>,
    /// Where it stands in the file.
    pub span: Span,
}

/// What happens when a comparison begins to hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The user's name.
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    /// How the sides are compared.
    pub comparison: Comparison,
    /// The sides of the comparison.
    pub sides: [Formula; 2],
    /// What discrete variables become, seen from just before it.
    pub writes: Vec<(DiscreteId, Formula)>,
    /// What states become, seen from just before it.
    pub states: Vec<(StateId, Formula)>,
    /// Joints that engage.
    pub engages: Vec<Owner>,
    /// Joints that are released, and joints, drivers and loads that are there no longer.
    pub removes: Vec<Owner>,
    /// True if the event happens once only.
    pub once: bool,
    /// True if the event ends the run.
    pub stop: bool,
    /// Where it stands in the file.
    pub span: Span,
}

impl Event {
    /// The sides, that one first which is larger where the comparison holds.
    pub fn ordered(&self) -> [&Formula; 2] {
        let [left, right] = &self.sides;
        match self.comparison {
            Comparison::Less | Comparison::LessEqual => [right, left],
            Comparison::Greater | Comparison::GreaterEqual => [left, right],
        }
    }

    /// True if the comparison holds only where the sides differ.
    pub fn is_strict(&self) -> bool {
        matches!(self.comparison, Comparison::Less | Comparison::Greater)
    }
}

impl Mechanism {
    /// Every formula that is read at ticks and events, and what reads it.
    pub fn read_at_instants(&self) -> impl Iterator<Item = (String, &Formula)> {
        let ticks = self.samplers.iter().flat_map(|sampler| {
            sampler.writes.iter().map(|(_, written)| (format!("sampler `{}`", sampler.name), written))
        });
        let events = self.events.iter().flat_map(|event| {
            let written = event.writes.iter().map(|(_, written)| written);
            let read = event.sides.iter().chain(written).chain(event.states.iter().map(|(_, written)| written));
            read.map(|read| (format!("event `{}`", event.name), read))
        });
        ticks.chain(events)
    }
}
