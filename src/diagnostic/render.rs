//! Faults as text for people and as JSON for programs.

use std::borrow::Cow;
use std::fmt;

use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError, MietteSpanContents, SourceCode,
    SourceSpan, SpanContents,
};
use serde_json::{Value, json};

use super::fault::{Fault, Faults, Severity};
use super::span::{Lines, Source, Span};
use super::visible::{masked, visible};

/// More than this is not read by anyone.
const MOST_RENDERED: usize = 50;
/// A line longer than this is shown in part only.
const LONGEST_LINE: usize = 400;

impl Faults {
    /// All faults with the lines they are about, for the terminal; `width` in characters.
    pub fn render(&self, colour: bool, width: usize) -> String {
        let theme = if colour { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
        let handler = GraphicalReportHandler::new_themed(theme).with_width(width).with_links(false);
        let mut source = Source::new(visible(&self.source.name), masked(&self.source.text));
        source.further = self.source.further.clone();
        let mut text = String::new();
        for fault in self.list.iter().take(MOST_RENDERED) {
            let (fault, source) = in_its_file(fault, &source);
            let report = FaultReport { fault: &fault, source: &source };
            if handler.render_report(&mut text, &report).is_err() {
                // The layout failed: the message alone is better than nothing.
                text.push_str(&visible(&fault.message));
            }
            text.push('\n');
        }
        let further = self.list.len().saturating_sub(MOST_RENDERED) + self.omitted;
        if further > 0 {
            text.push_str(&format!("... and {further} more\n"));
        }
        text
    }

    /// All faults as a JSON object, for editors: lines and columns count from 1, columns in characters.
    pub fn to_json(&self) -> Value {
        let place = |span: Span| {
            let (file, start) = self.source.file_at(span.start);
            let (lines, span) = (Lines::new(&file.text), span.within(start));
            let ((line, column), (end_line, end_column)) = (lines.position(span.start), lines.position(span.end));
            let mut place = json!({ "line": line, "column": column, "end_line": end_line, "end_column": end_column,
                    "start": span.start, "end": span.end });
            if start > 0 {
                place["file"] = json!(file.name);
            }
            place
        };
        let faults: Vec<Value> = self
            .list
            .iter()
            .map(|fault| {
                json!({
                    "code": fault.code,
                    "severity": match fault.severity { Severity::Error => "error", Severity::Warning => "warning" },
                    "message": fault.message,
                    "label": fault.label,
                    "help": fault.help,
                    "place": (!fault.span.is_nowhere()).then(|| place(fault.span)),
                    "also": fault.also.iter().copied().map(place).collect::<Vec<_>>(),
                })
            })
            .collect();
        json!({ "file": self.source.name, "faults": faults, "omitted": self.omitted })
    }
}

/// A fault with the file that it is in: further places in other files are left out.
fn in_its_file<'f>(fault: &'f Fault, source: &Source) -> (Cow<'f, Fault>, Source) {
    if source.further.is_empty() || fault.span.is_nowhere() {
        return (Cow::Borrowed(fault), source.clone());
    }
    let (file, start) = source.file_at(fault.span.start);
    let here = |span: &&Span| (start..=start + file.text.len()).contains(&span.start);
    let also = fault.also.iter().filter(here).map(|span| span.within(start)).collect();
    // Beyond the end of the file there is nothing to show.
    let span = fault.span.within(start);
    let span = Span::new(span.start, span.end.min(file.text.len()));
    (Cow::Owned(Fault { span, also, ..fault.clone() }), file)
}

#[derive(Debug)]
struct FaultReport<'a> {
    fault: &'a Fault,
    source: &'a Source,
}

impl fmt::Display for FaultReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&visible(&self.fault.message))
    }
}

impl std::error::Error for FaultReport<'_> {}

impl Diagnostic for FaultReport<'_> {
    fn code(&self) -> Option<Box<dyn fmt::Display + '_>> {
        Some(Box::new(self.fault.code))
    }

    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.fault.severity {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
        })
    }

    fn help(&self) -> Option<Box<dyn fmt::Display + '_>> {
        (!self.fault.help.is_empty()).then(|| Box::new(visible(&self.fault.help)) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        (!self.source.text.is_empty()).then_some(self.source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        if self.source.text.is_empty() || self.fault.span.is_nowhere() {
            return None;
        }
        let label = |text: &str, span: Span, primary: bool| {
            let text = (!text.is_empty()).then(|| visible(text).into_owned());
            let range = SourceSpan::from((span.start, span.end.saturating_sub(span.start)));
            if primary {
                LabeledSpan::new_primary_with_span(text, range)
            } else {
                LabeledSpan::new_with_span(text, range)
            }
        };
        let also = self.fault.also.iter().map(move |&span| label("here too", span, false));
        Some(Box::new(std::iter::once(label(&self.fault.label, self.fault.span, true)).chain(also)))
    }
}

/// The lines around a span; of very long lines only what is near the span.
impl SourceCode for Source {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let text: &str = &self.text;
        let (start, end) = (span.offset(), span.offset() + span.len());
        if end > text.len() {
            return Err(MietteError::OutOfBounds);
        }
        let bytes = text.as_bytes();
        // miette asks for no lines before when it only wants to know the column.
        let from = if before == 0 { start } else { line_start(bytes, start, before) };
        let first = from.max(text.floor_char_boundary(start.saturating_sub(LONGEST_LINE)));
        let last = line_end(bytes, end, after).min(text.ceil_char_boundary(end + LONGEST_LINE));
        let preceding = &text[..first];
        let line = preceding.matches('\n').count();
        let column = preceding.rsplit('\n').next().map_or(0, |start_of_line| start_of_line.chars().count());
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            &bytes[first..last],
            SourceSpan::from((first, last - first)),
            line,
            column,
            line + 1,
        )))
    }
}

/// The start of the line that is `lines` lines above the one with `offset`.
fn line_start(bytes: &[u8], offset: usize, lines: usize) -> usize {
    (0..offset).rev().filter(|&at| bytes[at] == b'\n').nth(lines).map_or(0, |at| at + 1)
}

/// The end of the line that is `lines` lines below the one with `offset`, with its line break.
fn line_end(bytes: &[u8], offset: usize, lines: usize) -> usize {
    (offset..bytes.len()).filter(|&at| bytes[at] == b'\n').nth(lines).map_or(bytes.len(), |at| at + 1)
}
