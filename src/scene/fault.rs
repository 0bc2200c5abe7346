//! What is wrong with a scene: collected first, reported together.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fmt;

use super::span::{Source, Span};

/// How bad a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The scene can be used.
    Warning,
    /// The scene cannot be used.
    Error,
}

/// One thing that is wrong with a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// What kind of fault, such as `scene::unknown_point`.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, in the user's names.
    pub message: String,
    /// Where.
    pub span: Span,
    /// What is said at that place; may be empty.
    pub label: String,
    /// What to do; may be empty.
    pub help: String,
    /// Further places with the same fault.
    pub also: Vec<Span>,
}

impl Fault {
    /// An error.
    pub fn new(code: &'static str, message: impl Into<String>, span: Span) -> Fault {
        Fault {
            code,
            severity: Severity::Error,
            message: message.into(),
            span,
            label: String::new(),
            help: String::new(),
            also: Vec::new(),
        }
    }

    /// A warning.
    pub fn warning(code: &'static str, message: impl Into<String>, span: Span) -> Fault {
        Fault { severity: Severity::Warning, ..Fault::new(code, message, span) }
    }

    /// Says something at the place.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Fault {
        self.label = label.into();
        self
    }

    /// Says what to do.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Fault {
        self.help = help.into();
        self
    }
}

/// The faults of a scene, in the order of its text, with the text that they speak of.
#[derive(Clone, Debug, PartialEq)]
pub struct Faults {
    /// The faults; at least one.
    pub list: Vec<Fault>,
    /// How many more there are beyond those listed.
    pub omitted: usize,
    /// The text that the spans refer to.
    pub source: Source,
}

impl Faults {
    /// Faults found in a text.
    pub fn new(source: Source, list: Vec<Fault>) -> Faults {
        Faults { list, omitted: 0, source }
    }
}

impl From<Faults> for Vec<Fault> {
    fn from(faults: Faults) -> Vec<Fault> {
        faults.list
    }
}

/// One line per fault, for logs.
impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.list.iter().enumerate() {
            let separator = if index == 0 { "" } else { "\n" };
            write!(f, "{separator}{}: {}", fault.code, fault.message)?;
        }
        Ok(())
    }
}

impl std::error::Error for Faults {}

/// Collects faults; keeps so many that nobody misses one, and so few that a hopeless file stays quick.
#[derive(Debug, Default)]
pub(crate) struct Sink {
    list: Vec<Fault>,
    omitted: usize,
    /// Errors by what they are about, so that a name which is missing in ten places is one fault.
    about: HashMap<(&'static str, String), usize>,
}

impl Sink {
    const MOST: usize = 200;
    const MOST_PLACES: usize = 8;

    pub fn push(&mut self, fault: Fault) {
        if self.is_full() {
            self.omitted += 1;
        } else {
            self.list.push(fault);
        }
    }

    /// Adds a fault about `subject`, or one more place to the fault of the same code about the same subject.
    pub fn push_about(&mut self, subject: impl Into<String>, fault: Fault) {
        match self.about.entry((fault.code, subject.into())) {
            Entry::Vacant(entry) if self.list.len() < Sink::MOST => {
                entry.insert(self.list.len());
                self.list.push(fault);
            }
            Entry::Vacant(_) => self.omitted += 1,
            Entry::Occupied(entry) => {
                if let Some(first) = self.list.get_mut(*entry.get())
                    && first.also.len() < Sink::MOST_PLACES
                {
                    first.also.push(fault.span);
                }
            }
        }
    }

    /// Are further faults only counted?
    pub fn is_full(&self) -> bool {
        self.list.len() >= Sink::MOST
    }

    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|fault| fault.severity == Severity::Error)
    }

    /// The faults in the order of the text.
    pub fn into_faults(mut self, source: Source) -> Faults {
        self.list.sort_by_key(|fault| (fault.span.start, fault.span.end));
        Faults { list: self.list, omitted: self.omitted, source }
    }

    /// What was found, if nothing worse than warnings.
    pub fn into_warnings(mut self) -> Vec<Fault> {
        self.list.sort_by_key(|fault| (fault.span.start, fault.span.end));
        self.list
    }
}
