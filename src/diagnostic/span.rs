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

    /// The span of a text with its quotes.
    pub fn whole(self, text: &str) -> Span {
        let quote = |place: usize| text.as_bytes().get(place).copied().filter(|mark| matches!(mark, b'"' | b'\''));
        let before = self.start.checked_sub(1).and_then(quote);
        match before {
            Some(mark) if quote(self.end) == Some(mark) => Span::new(self.start - 1, self.end + 1),
            _ => self,
        }
    }

    /// The span in a text that begins so much further on.
    pub(crate) fn shifted(self, by: usize) -> Span {
        Span::new(self.start + by, self.end + by)
    }

    /// The same within a file whose text begins here.
    pub(super) fn within(self, start: usize) -> Span {
        Span::new(self.start.saturating_sub(start), self.end.saturating_sub(start))
    }

    /// Is this the span of something that no file contains?
    pub fn is_nowhere(self) -> bool {
        self.start == 0 && self.end == 0
    }
}

/// The text of a scene and its name; both empty for a scene built in Rust. All sources are equal, as all spans are.
///
/// The texts of the files that a scene uses follow its own, so that a span says which file it is in.
#[derive(Clone, Debug)]
pub struct Source {
    pub name: String,
    pub text: Arc<str>,
    /// The files whose texts follow, in the order of their texts.
    pub further: Arc<[Further]>,
}

/// A file that a scene uses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Further {
    /// Its path.
    pub name: String,
    /// Where its text begins in that of the source.
    pub start: usize,
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
        Source { name: name.into(), text: text.into(), further: Arc::default() }
    }

    /// Adds a file behind the others; where its text begins.
    pub(crate) fn append(&mut self, name: &str, text: &str) -> usize {
        // What ends at the end of one file must not begin the next.
        let start = self.text.len() + 1;
        self.text = format!("{}\n{text}", self.text).into();
        let one_more = Further { name: name.to_owned(), start };
        self.further = self.further.iter().cloned().chain([one_more]).collect();
        start
    }

    /// Each file: its path and its text, the scene's own first.
    pub fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        let starts = std::iter::once((self.name.as_str(), 0));
        let starts = starts.chain(self.further.iter().map(|file| (file.name.as_str(), file.start)));
        starts.map(|(name, start)| (name, &self.text[start..self.end_of(start)]))
    }

    /// The text of one of the further files, and where it begins.
    pub(crate) fn text_of(&self, name: &str) -> Option<(&str, usize)> {
        let start = self.further.iter().find(|file| file.name == name)?.start;
        Some((&self.text[start..self.end_of(start)], start))
    }

    /// The text of the scene's own file.
    pub fn own_text(&self) -> &str {
        &self.text[..self.end_of(0)]
    }

    /// The file that an offset lies in, and where its text begins.
    pub(super) fn file_at(&self, offset: usize) -> (Source, usize) {
        let file = self.further.iter().rev().find(|file| file.start <= offset);
        let (name, start) = file.map_or((&self.name, 0), |file| (&file.name, file.start));
        (Source::new(name, &self.text[start..self.end_of(start)]), start)
    }

    /// Where the text of the file ends that begins here.
    fn end_of(&self, start: usize) -> usize {
        self.further.iter().find(|file| file.start > start).map_or(self.text.len(), |next| next.start - 1)
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
