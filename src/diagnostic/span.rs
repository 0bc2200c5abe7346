//! Source positions.

use std::sync::Arc;

/// A range of bytes of the scene's text; empty at 0 for a scene built in Rust.
///
/// All spans are equal: where something is written is no part of what it is, so that a scene compares equal however it
/// was laid out or built.
#[derive(Clone, Copy, Debug, Default)]
pub struct Span {
    pub start: usize,
    pub end: usize,
}

impl PartialEq for Span {
    fn eq(&self, _: &Span) -> bool {
        true
    }
}

impl Eq for Span {}

impl Span {
    /// The span from `start` up to `end`.
    pub fn new(start: usize, end: usize) -> Span {
        Span { start, end }
    }

    /// The part of a text's span that its bytes `start..end` take. A text that is not written verbatim in the file (it
    /// has escapes) cannot be divided: the whole is its own part.
    pub fn part(self, text: &str, start: usize, end: usize) -> Span {
        if self.end - self.start == text.len() { Span::new(self.start + start, self.start + end) } else { self }
    }

    /// Is this the span of something that no file contains?
    pub fn is_nowhere(self) -> bool {
        self.start == 0 && self.end == 0
    }
}

/// The text of a scene and its name; both empty for a scene built in Rust. All sources are equal, as all spans are.
#[derive(Clone, Debug)]
pub struct Source {
    pub name: String,
    pub text: Arc<str>,
}

impl Default for Source {
    fn default() -> Source {
        Source::new("", "")
    }
}

impl PartialEq for Source {
    fn eq(&self, _: &Source) -> bool {
        true
    }
}

impl Source {
    pub fn new(name: impl Into<String>, text: impl Into<Arc<str>>) -> Source {
        Source { name: name.into(), text: text.into() }
    }
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Text {
    pub text: String,
    pub span: Span,
}

impl Text {
    pub fn new(text: impl Into<String>, span: Span) -> Text {
        Text { text: text.into(), span }
    }

    /// Where the bytes `start..end` of the text are written.
    pub fn part(&self, start: usize, end: usize) -> Span {
        self.span.part(&self.text, start, end)
    }
}

impl From<&str> for Text {
    fn from(text: &str) -> Text {
        Text::new(text, Span::default())
    }
}

impl From<String> for Text {
    fn from(text: String) -> Text {
        Text::new(text, Span::default())
    }
}

pub(super) struct Lines<'t> {
    text: &'t str,
    starts: Vec<usize>,
}

impl<'t> Lines<'t> {
    pub fn new(text: &'t str) -> Lines<'t> {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Lines { text, starts }
    }

    /// Line and column, from 1.
    pub fn position(&self, offset: usize) -> (usize, usize) {
        let line = self.starts.partition_point(|&start| start <= offset).max(1);
        let before = self.starts.get(line - 1).and_then(|&start| self.text.get(start..offset)).unwrap_or("");
        (line, before.chars().count() + 1)
    }
}
