//! What changes at instants: values at ticks, and what happens when a comparison begins to hold.
//!
//! All of it acts through held values: the last inputs of a mechanism, which nobody outside sets. In between they are constant.

use super::{Comparison, Formula, InputId, LoadId, Mechanism, Owner};
use crate::diagnostic::Span;
use crate::model::Input;

/// A value that only ticks and events change.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// What it is.
    pub what: HeldWhat,
    /// What it begins with; positions, velocities, states, inputs and parameters may occur.
    pub begin: Formula,
}

/// What a held value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeldWhat {
    /// A sampled value of the scene.
    Sampled,
    /// When an event happened last \[s\]; less than zero before that.
    Time,
    /// Whether a load is there: 1, or 0 after an event has removed it.
    Presence(LoadId),
}

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
    pub writes: Vec<(InputId, Formula)>,
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
    /// What held values become, seen from just before it.
    pub writes: Vec<(InputId, Formula)>,
    /// Joints and drivers that are there no longer.
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
    /// The inputs that somebody outside sets: those before the held ones.
    pub fn open_inputs(&self) -> &[Input] {
        &self.inputs[..self.inputs.len().saturating_sub(self.held.len())]
    }

    /// The held values with their inputs.
    pub fn held_inputs(&self) -> impl Iterator<Item = (InputId, &Input, &Held)> {
        let first = self.open_inputs().len();
        let held = self.inputs[first..].iter().zip(&self.held);
        held.enumerate().map(move |(index, (input, held))| (InputId(first + index), input, held))
    }

    /// Every formula that is read at ticks and events, and what reads it.
    pub fn read_at_instants(&self) -> impl Iterator<Item = (String, &Formula)> {
        let ticks = self.samplers.iter().flat_map(|sampler| {
            sampler.writes.iter().map(|(_, written)| (format!("sampler `{}`", sampler.name), written))
        });
        let events = self.events.iter().flat_map(|event| {
            let read = event.sides.iter().chain(event.writes.iter().map(|(_, written)| written));
            read.map(|read| (format!("event `{}`", event.name), read))
        });
        ticks.chain(events)
    }

    /// The held value that says whether a load is there, if an event can remove it.
    pub fn presence(&self, load: LoadId) -> Option<InputId> {
        let mut held = self.held_inputs();
        held.find(|(.., held)| held.what == HeldWhat::Presence(load)).map(|(input, ..)| input)
    }
}
