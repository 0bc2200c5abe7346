//! Signals with a memory: each file is one kind, with its keys, its states or sampled values, and what it gives. Nothing else in the program knows what kinds there are.

mod delay;
mod filter;
mod pid;

use crate::model::measure::ANYTHING;
use crate::model::{DiscreteId, Formula, Range, StateId};
use crate::scene::key::{Form, Key};
use crate::scene::tables::{DESCRIPTION, SIGNAL_UNIT};

/// Every kind.
pub(crate) const ALL: &[&Transfer] = &[&pid::PID, &filter::FILTER, &delay::DELAY];

/// A kind of signal that follows from what it has heard so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transfer {
    /// Its `type`.
    pub name: &'static str,
    /// What it gives, in a few words.
    pub about: &'static str,
    /// Its equations as a text.
    pub equations: &'static str,
    /// The law that it hears.
    pub hears: Key,
    /// Its other keys; none of their values changes while it runs.
    pub keys: &'static [Key],
    /// The units of its keys.
    pub terms: &'static [(&'static str, Like)],
    /// The key with which it is sampled. Without that key what it gives changes at once with what it hears. A kind that has no such key gives nothing at once.
    pub sampled_by: Option<&'static str>,
    pub made: MadeOf,
}

type MadeOf = fn(&TransferKeys<'_>) -> Result<TransferParts, Flaw>;

/// What the unit of a value is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Like {
    /// That of what is given.
    Given,
    /// That of what is given, by the second.
    Rate,
    /// That of what is heard.
    Heard,
    /// Times what is heard and so many times the second it has the unit of what is given.
    Gain(i8),
}

/// The values of the keys of one signal, and its states and sampled values.
pub(crate) struct TransferKeys<'g> {
    pub heard: Formula,
    pub values: &'g [(&'static str, Formula)],
    /// Its first state and its first sampled value.
    pub first: (usize, usize),
}

impl TransferKeys<'_> {
    /// The value of a key, if it is there.
    fn value(&self, key: &str) -> Option<Formula> {
        self.values.iter().find(|(name, _)| *name == key).map(|(_, value)| value.clone())
    }

    fn value_or(&self, key: &str, otherwise: f64) -> Formula {
        self.value(key).unwrap_or(Formula::Number(otherwise))
    }

    fn state(&self, place: usize) -> Formula {
        Formula::State(StateId(self.first.0 + place))
    }

    fn sampled(&self, place: usize) -> Formula {
        Formula::Discrete(DiscreteId(self.first.1 + place))
    }
}

/// What a signal is made of.
pub(crate) struct TransferParts {
    pub output: Formula,
    pub states: Vec<Inner>,
    pub sampled: Vec<Inner>,
    /// Period and first tick of its sampled values \[s\].
    pub ticks: Option<[Formula; 2]>,
    /// What must be positive at all parameters: what it is called, and of which key.
    pub positive: Vec<(&'static str, &'static str, Formula)>,
    /// The usual size of what it gives, if something says so.
    pub size: Option<Formula>,
}

impl TransferParts {
    fn of_states(output: Formula, states: Vec<Inner>) -> TransferParts {
        TransferParts { output, states, sampled: Vec::new(), ticks: None, positive: Vec::new(), size: None }
    }
}

/// A state or a sampled value of a signal.
pub(crate) struct Inner {
    /// Its name is the signal's with this word behind a point.
    word: String,
    /// What it is of the signal, whose name follows.
    about: &'static str,
    pub unit: Like,
    /// Constants and parameters only.
    pub start: Formula,
    /// The rate of a state; of a sampled value what it is from a tick on, seen from just before it.
    pub next: Formula,
}

impl Inner {
    fn new(word: &str, about: &'static str, start: Formula, next: Formula) -> Inner {
        Inner { word: word.to_owned(), about, unit: Like::Given, start, next }
    }

    /// What it is called where the signal has this name.
    pub fn name(&self, signal: &str) -> String {
        format!("{signal}.{}", self.word)
    }

    /// One line about it.
    pub fn description(&self, signal: &str) -> String {
        format!("{} `{signal}`", self.about)
    }
}

/// What is wrong with keys that are right each for itself.
pub(crate) struct Flaw {
    /// The key where it is shown; the signal if it is not there.
    pub key: &'static str,
    pub problem: String,
    pub help: &'static str,
}

impl Flaw {
    fn new(key: &'static str, problem: impl Into<String>, help: &'static str) -> Flaw {
        Flaw { key, problem: problem.into(), help }
    }
}

/// The usual size of what it gives.
pub(crate) const NOMINAL: Key = Key::default(
    "nominal",
    Form::Constant(ANYTHING, Range::Positive),
    "its nominal value: tolerances are relative to it",
    "the size of its limits or of its start, or 1",
);

impl Transfer {
    /// The keys of its own and those that all kinds have.
    pub fn all_keys(&self) -> Vec<Key> {
        let keys = std::iter::once(self.hears).chain(self.keys.iter().copied());
        keys.chain([NOMINAL, SIGNAL_UNIT, DESCRIPTION]).collect()
    }
}

const fn gain(name: &'static str, about: &'static str) -> Key {
    Key::default(name, Form::Constant(ANYTHING, Range::Any), about, "none")
}

const START: Key = Key::default("start", Form::Constant(ANYTHING, Range::Any), "its output at the start", "0");
