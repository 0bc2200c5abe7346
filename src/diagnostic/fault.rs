//! Faults of a scene: collected first, reported together.

use std::collections::HashMap;
use std::fmt;

use super::span::{Lines, Source, Span};

/// How bad a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The scene can be used.
    Warning,
    /// The scene cannot be used.
    Error,
}

/// What a fault is about, where more than its text counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// An output of a variable that does not exist.
    UnknownOutput,
    /// The mechanism cannot be assembled, or not be moved from there.
    Assembly,
    /// Anything else.
    Other,
}

/// One thing that is wrong with a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The code of the fault, such as `scene::unknown_point`.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, in the user's names.
    pub message: String,
    /// Where.
    pub span: Span,
    /// The label at that place; may be empty.
    pub label: Box<str>,
    /// What to do; may be empty.
    pub help: Box<str>,
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
            label: Box::default(),
            help: Box::default(),
            also: Vec::new(),
        }
    }

    /// An error of the program itself, which no scene should be able to cause.
    pub fn internal(what: impl Into<String>) -> Fault {
        Fault::new("cotree::internal", what, Span::default())
            .help("this is a bug in cotree, not an error of the scene: please report it with the scene file")
    }

    /// What it is about: the code is the only place where that is written.
    pub fn kind(&self) -> FaultKind {
        match self.code {
            "scene::unknown_output" => FaultKind::UnknownOutput,
            code if code.starts_with("assembly::") => FaultKind::Assembly,
            _ => FaultKind::Other,
        }
    }

    /// A warning.
    pub fn warning(code: &'static str, message: impl Into<String>, span: Span) -> Fault {
        Fault { severity: Severity::Warning, ..Fault::new(code, message, span) }
    }

    /// Sets the label of the place.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Fault {
        self.label = label.into().into_boxed_str();
        self
    }

    /// Sets the remedy.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Fault {
        self.help = help.into().into_boxed_str();
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
    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Faults found in a text.
    pub fn new(source: Source, list: Vec<Fault>) -> Faults {
        Faults { list, omitted: 0, source }
    }
}

/// Each fault with its place and what to do, for logs; [`Faults::render`] also shows the lines of the scene.
impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.list.iter().enumerate() {
            let separator = if index == 0 { "" } else { "\n" };
            write!(f, "{separator}{}: {}", fault.code, fault.message)?;
            if !fault.span.is_nowhere() {
                let (file, start) = self.source.file_at(fault.span.start);
                let (line, column) = Lines::new(&file.text).position(fault.span.start - start);
                write!(f, "\n  at {}:{line}:{column}", file.name)?;
            }
            if !fault.help.is_empty() {
                write!(f, "\n  help: {}", fault.help)?;
            }
        }
        if self.omitted > 0 {
            write!(f, "\n... and {} more", self.omitted)?;
        }
        Ok(())
    }
}

impl std::error::Error for Faults {}

/// Collects faults up to a limit.
#[derive(Debug, Default)]
pub(crate) struct Sink {
    list: Vec<Fault>,
    errors: usize,
    warnings: usize,
    omitted: usize,
    /// Errors by the name that they are about, so that a name which is missing in ten places is one fault.
    about: HashMap<String, usize>,
}

impl Sink {
    const MOST_ERRORS: usize = 200;
    const MOST_WARNINGS: usize = 50;
    const MOST_PLACES: usize = 8;

    pub fn push(&mut self, fault: Fault) {
        let (count, most) = match fault.severity {
            Severity::Error => (&mut self.errors, Sink::MOST_ERRORS),
            Severity::Warning => (&mut self.warnings, Sink::MOST_WARNINGS),
        };
        *count += 1;
        if *count <= most {
            self.list.push(fault);
        } else {
            self.omitted += 1;
        }
    }

    /// Adds the first fault about `subject`.
    pub fn push_about(&mut self, subject: &str, fault: Fault) {
        self.about.insert(subject.to_string(), self.list.len());
        self.push(fault);
    }

    /// Notes one more place of the fault about `subject`, if there is one. True as well when no further fault would
    /// be kept, to spare the work of finding out what may have been meant.
    pub fn again(&mut self, subject: &str, span: Span) -> bool {
        if let Some(first) = self.about.get(subject).and_then(|index| self.list.get_mut(*index)) {
            let is_another = (first.span.start, first.span.end) != (span.start, span.end);
            if is_another && first.also.len() < Sink::MOST_PLACES {
                first.also.push(span);
            }
            return true;
        }
        let full = self.errors >= Sink::MOST_ERRORS;
        self.omitted += usize::from(full);
        full
    }

    /// Adds the faults of a file whose text begins here in the source.
    pub fn take(&mut self, other: Sink, start: usize) {
        self.omitted += other.omitted;
        for mut fault in other.list {
            fault.span = fault.span.shifted(start);
            fault.also.iter_mut().for_each(|span| *span = span.shifted(start));
            self.push(fault);
        }
    }

    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// The faults in the order of the text.
    pub fn into_faults(self, source: Source) -> Faults {
        Faults { omitted: self.omitted, list: self.into_list(), source }
    }

    /// The same without their text.
    pub fn into_list(mut self) -> Vec<Fault> {
        self.list.sort_by_key(|fault| (fault.span.start, fault.span.end));
        self.list
    }
}
