//! Values of a component that are written together, as a table with keys of its own: `friction = { coulomb = 2, mu = 0.1 }`.
//!
//! A record says which keys its table has and which of them must be there; the schema, the reference of the scene and the reading of a scene ask it.

use super::key::Range;
use crate::model::Pressed;
use crate::model::measure::Wanted;

/// Values that are written together.
#[derive(Clone, Copy, Debug)]
pub enum Record {
    /// Dry friction: the measures of its level and of the velocity below which it fades, and what presses.
    Friction([Wanted; 2], Pressed),
    /// Where a motion of this measure ends, and how it rebounds there.
    Limits(Wanted),
    /// By how much a relation of this measure gives way, and how it rebounds at either end.
    Play(Wanted),
    /// That a relation presses only, and how it rebounds.
    Rebound,
}

/// A key of a record: an expression, or a number in a range.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub name: &'static str,
    pub range: Range,
}

const fn entry(name: &'static str, range: Range) -> Entry {
    Entry { name, range }
}

const RESTITUTION: Entry = entry("restitution", Range::Share);
const FRICTION: [Entry; 6] = [
    entry("coulomb", Range::Any),
    entry("velocity", Range::Any),
    entry("mu", Range::NotNegative),
    entry("static", Range::FromOne),
    entry("radius", Range::Any),
    entry("length", Range::Any),
];
const FRICTION_OF_BELT: [Entry; 6] = [
    entry("coulomb", Range::Any),
    entry("velocity", Range::Any),
    entry("mu", Range::NotNegative),
    entry("static", Range::FromOne),
    entry("wrap", Range::Any),
    entry("pretension", Range::Any),
];
const LIMITS: [Entry; 3] = [entry("min", Range::Any), entry("max", Range::Any), RESTITUTION];
const PLAY: [Entry; 2] = [entry("play", Range::Positive), RESTITUTION];

impl Record {
    /// The keys of its table.
    pub const fn entries(self) -> &'static [Entry] {
        match self {
            Self::Friction(_, Pressed::Belt) => &FRICTION_OF_BELT,
            Self::Friction(..) => &FRICTION,
            Self::Limits(_) => &LIMITS,
            Self::Play(_) => &PLAY,
            Self::Rebound => &[RESTITUTION],
        }
    }

    /// The names of its keys.
    pub fn names(self) -> Vec<&'static str> {
        self.entries().iter().map(|entry| entry.name).collect()
    }

    /// Keys of which one at least must be there, if any must.
    pub const fn needed(self) -> &'static [&'static str] {
        match self {
            Self::Friction(..) => &["coulomb", "mu"],
            Self::Limits(_) => &["min", "max"],
            Self::Play(_) => &["play"],
            Self::Rebound => &[],
        }
    }

    /// How it may be written, for the reference.
    pub const fn patterns(self) -> &'static [&'static str] {
        match self {
            Self::Friction(_, Pressed::Belt) => {
                &["{ mu = ..., wrap = ..., pretension = ..., static = ... }", "{ coulomb = ..., static = ... }"]
            }
            Self::Friction(..) => &["{ coulomb = ..., mu = ..., static = ... }", "{ coulomb = ..., velocity = ... }"],
            Self::Limits(_) => &["{ min = ..., max = ..., restitution = ... }"],
            Self::Play(_) => &["{ play = ..., restitution = ... }"],
            Self::Rebound => &["{ restitution = ... }"],
        }
    }

    /// The measures of its values, but for those that are numbers.
    pub fn measures(self) -> Vec<Wanted> {
        match self {
            Self::Friction(both, _) => both.to_vec(),
            Self::Limits(wanted) | Self::Play(wanted) => vec![wanted],
            Self::Rebound => Vec::new(),
        }
    }

    /// True if it makes a joint hold something on one side only.
    pub const fn is_one_sided(self) -> bool {
        match self {
            Self::Friction(..) => false,
            Self::Limits(_) | Self::Play(_) | Self::Rebound => true,
        }
    }
}
