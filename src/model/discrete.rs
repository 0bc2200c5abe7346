//! Discrete variables: what sample times, events and contacts change at instants, and is constant in between. The list of a mechanism has all of them, whoever changes them.

use super::{CourseValue, DiscreteId, Formula, Mechanism, Owner, Unit};
use crate::diagnostic::Span;

/// A discrete variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Discrete {
    /// Its name.
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    /// Unit as the user sees it.
    pub unit: Unit,
    /// Whose it is.
    pub kind: DiscreteKind,
    /// What it begins with; positions, velocities, states, inputs and parameters may occur. Of a contact it is a number.
    pub begin: Formula,
    /// Where it stands in the file.
    pub span: Span,
}

/// Whose a discrete variable is. Those of contacts come last in a mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiscreteKind {
    /// A sampled value of the scene, or of a transfer.
    Sampled,
    /// When an event happened last \[s\]; less than zero before that.
    Time,
    /// Whether a joint, driver or load is there: 1, or 0 after an event has removed it.
    Presence(Owner),
    /// A variable in the state of a contact.
    Contact,
    /// What a joint adds to its constants, to hold the pose in which it engages.
    Captured(Owner),
    /// The impulse of a joint that engages and the energy that it takes, or the impulse along a rate that an event sets.
    Impulse,
    /// A rate that an event sets, and whether it does so now.
    Setting,
    /// Where the course of a rope or band counts from.
    Course(Owner, CourseValue),
}

impl Discrete {
    /// True for the state of a contact, and for what says whether a joint or driver is there: with others the mechanism is another one.
    pub fn is_of_mode(&self) -> bool {
        match self.kind {
            DiscreteKind::Contact | DiscreteKind::Setting => true,
            DiscreteKind::Presence(owner) => !owner.is_load(),
            DiscreteKind::Sampled | DiscreteKind::Time | DiscreteKind::Captured(_) => false,
            DiscreteKind::Impulse => false,
            DiscreteKind::Course(..) => false,
        }
    }

    /// The number that it begins with, SI; zero if that is no number.
    pub fn start(&self) -> f64 {
        if let Formula::Number(start) = self.begin { start } else { 0.0 }
    }
}

impl Mechanism {
    /// The discrete variables with their places.
    pub fn discrete_variables(&self) -> impl Iterator<Item = (DiscreteId, &Discrete)> {
        self.discrete.iter().enumerate().map(|(index, discrete)| (DiscreteId(index), discrete))
    }

    /// The variable that is 1 until an event removes this part, then 0; none if no event does.
    pub fn there(&self, owner: Owner) -> Option<DiscreteId> {
        self.discrete_variables().find(|(_, discrete)| discrete.kind == DiscreteKind::Presence(owner)).map(|(id, _)| id)
    }

    /// True if the scene has sampled values, events or what these remove: more than contacts and ropes change.
    pub fn has_instants(&self) -> bool {
        let is_of_scene = |kind| !matches!(kind, DiscreteKind::Contact | DiscreteKind::Course(..));
        self.discrete.iter().any(|discrete| is_of_scene(discrete.kind))
    }
}
