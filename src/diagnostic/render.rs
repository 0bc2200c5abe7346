//! Faults as text for people and as JSON for programs.

use std::borrow::Cow;

use serde_json::{Value, json};

use super::fault::{Fault, Faults, Severity};
use super::layout::{Label, Shown, Terminal};
use super::span::{Lines, Source, Span};
use super::visible::{masked, on_one_line, visible};

/// More than this is not read by anyone.
const MOST_RENDERED: usize = 50;

impl Faults {
    /// All faults with the lines they are about, for the terminal; `width` in characters.
    pub fn render(&self, colour: bool, width: usize) -> String {
        let terminal = Terminal { colour, width };
        let mut source = Source::new(visible(&self.source.name), masked(&self.source.text));
        source.further = self.source.further.clone();
        let mut text = String::new();
        for fault in self.list.iter().take(MOST_RENDERED) {
            let (fault, source) = in_its_file(fault, &source);
            let (message, help) = (visible(&fault.message), visible(&fault.help));
            terminal.show(&mut text, &shown(&fault, &source, [&message, &help]));
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

/// A fault fit for a terminal.
fn shown<'a>(fault: &'a Fault, source: &'a Source, [message, help]: [&'a str; 2]) -> Shown<'a> {
    let label = |text: &str, span: Span| Label { span, text: on_one_line(text) };
    let also = fault.also.iter().map(|&span| label("here too", span));
    let is_somewhere = !source.text.is_empty() && !fault.span.is_nowhere();
    let primary = is_somewhere.then(|| label(&fault.label, fault.span));
    let labels = primary.into_iter().chain(also.filter(|_| is_somewhere));
    // A place beyond the end shows nothing.
    let labels = labels.filter(|label| label.span.end <= source.text.len()).collect();
    Shown { is_error: fault.severity == Severity::Error, code: fault.code, message, help, source, labels }
}
