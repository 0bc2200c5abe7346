//! Messages to the importer.

use std::ffi::CStr;

use thiserror::Error;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogSeverity {
    Fine,
    Warning,
    Discard,
    Error,
}

/// The declared log categories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Changes of mode.
    Events,
    /// What the solver did.
    Solver,
    /// Why a call failed.
    Errors,
}

impl Category {
    pub const ALL: [Self; 3] = [Self::Events, Self::Solver, Self::Errors];

    /// The categories of these names, in the spelling of a version of the standard.
    pub fn named(names: &[&CStr], spelling: fn(Self) -> &'static CStr) -> Result<Vec<Self>, UnknownCategory> {
        let known = |wanted: &&CStr| {
            let found = Self::ALL.into_iter().find(|category| spelling(*category) == *wanted);
            let text = |name: &CStr| name.to_string_lossy().into_owned();
            found.ok_or_else(|| UnknownCategory { name: text(wanted), known: Self::ALL.map(spelling).map(text) })
        };
        names.iter().map(known).collect()
    }
}

/// A name that is that of no category.
#[derive(Debug, Error)]
#[error("`{name}` is not a log category; there are {}, {} and {}", known[0], known[1], known[2])]
pub struct UnknownCategory {
    name: String,
    known: [String; 3],
}

/// Passes a message on, in the form that a version of the standard wants.
pub trait Sink {
    fn pass(&self, severity: LogSeverity, category: Category, message: &str);
}

/// Where messages go.
pub struct Logger {
    sink: Box<dyn Sink>,
    enabled: [bool; 3],
}

impl Logger {
    /// With these categories, in the order of [`Category::ALL`].
    pub fn new(sink: Box<dyn Sink>, enabled: [bool; 3]) -> Self {
        Self { sink, enabled }
    }

    /// Switches categories; all of them if none is named.
    pub fn switch(&mut self, on: bool, categories: &[Category]) {
        let chosen = if categories.is_empty() { &Category::ALL[..] } else { categories };
        chosen.iter().for_each(|&category| self.enabled[category as usize] = on);
    }

    pub fn is_enabled(&self, category: Category) -> bool {
        self.enabled[category as usize]
    }

    /// Passes one finished message on, if anybody wants it.
    pub fn log(&self, severity: LogSeverity, category: Category, message: &str) {
        if self.is_enabled(category) {
            self.sink.pass(severity, category, message.trim_end());
        }
    }
}
