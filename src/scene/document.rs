//! A scene's text as a tree of values, each with its place in the text; TOML and JSON give the same tree.

use toml::de::{DeTable, DeValue};

use super::json;
use super::slips::{self, Mended};
use crate::diagnostic::fault::{Fault, Sink};
use crate::diagnostic::span::{Span, Text};

/// A value of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct DocumentNode {
    /// Where it is written; a text without its quotes if it is written verbatim.
    pub span: Span,
    pub kind: Content,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// In the order of the text.
    Table(Vec<(Text, DocumentNode)>),
    Array(Vec<DocumentNode>),
    Text(String),
    Number(f64),
    Boolean(bool),
    /// TOML's date and time.
    Date,
    /// JSON's null.
    Null,
}

impl DocumentNode {
    /// Moves the places of a text that begins so much further on.
    pub fn shift(&mut self, by: usize) {
        self.span = self.span.shifted(by);
        match &mut self.kind {
            Content::Table(entries) => entries.iter_mut().for_each(|(key, node)| {
                key.span = key.span.shifted(by);
                node.shift(by);
            }),
            Content::Array(items) => items.iter_mut().for_each(|item| item.shift(by)),
            Content::Text(_) | Content::Number(_) | Content::Boolean(_) | Content::Date | Content::Null => {}
        }
    }
}

impl Content {
    /// What it is, with its article.
    pub fn name(&self) -> &'static str {
        match self {
            Content::Table(_) => "a table",
            Content::Array(_) => "a list",
            Content::Text(_) => "a text",
            Content::Number(_) => "a number",
            Content::Boolean(_) => "true or false",
            Content::Date => "a date",
            Content::Null => "null",
        }
    }
}

/// Reads TOML. What is wrong goes to `faults`; there is no tree if its shape cannot be trusted. A text that is wrong and has none of the
/// `keys` at its top, or that is wrong in most lines, is something else: that is said once.
pub(crate) fn from_toml(text: &str, keys: &[&str], faults: &mut Sink) -> Option<DocumentNode> {
    let (table, mut errors) = DeTable::parse_recoverable(text);
    errors.sort_by_key(|error| span_of(error, text).start);
    if !errors.is_empty()
        && let Some(fault) = super::brackets::unclosed(text, keys)
    {
        faults.push(fault);
        return None;
    }
    let strange = |error: &&toml::de::Error| !error.message().starts_with("duplicate key");
    if let Some(first) = errors.iter().find(strange)
        && (!super::brackets::mentions(text, keys) || mostly_wrong(text, &errors, keys))
    {
        faults.push(something_else(first, text));
        return None;
    }
    let mut usable = true;
    let mut last: Option<TextLine<'_>> = None;
    let mut repeated: Option<TextLine<'_>> = None;
    for error in errors {
        let span = span_of(&error, text);
        let line = TextLine::at(text, span.start);
        if !error.message().starts_with("duplicate key") {
            usable = false;
            // What follows on the same line comes from the first error, and what follows a key without its value is that value.
            if last.is_none_or(|last| last.start != line.start && !last.continues(line)) {
                toml_syntax(line, without_nothing(&error), span, keys, faults);
            }
            last = Some(line);
        } else {
            let name = text.get(span.start..span.end).unwrap_or_default();
            let table = TextLine { start: text[..line.start].rfind("\n[").map_or(0, |at| at + 1), ..line };
            match repeated {
                // The keys of a table that is there twice are there twice as well.
                Some(table) if span.start < table.start + table.text.len() => {}
                _ if line.text.trim_start().starts_with('[') => {
                    let end = text[span.end..].find("\n[").map_or(text.len(), |length| span.end + length);
                    repeated = Some(TextLine { start: line.start, text: &text[line.start..end] });
                    faults.push(duplicate_key(name, span));
                }
                _ => repeated_key(name, span, table, faults),
            }
        }
    }
    let span = Span::new(table.span().start, table.span().end);
    usable.then(|| DocumentNode { span, kind: table_of(text, table.into_inner()) })
}

/// Reads JSON, likewise.
pub(crate) fn from_json(text: &str, faults: &mut Sink) -> Option<DocumentNode> {
    json::read(text, faults)
}

/// A line of a text, without its end.
#[derive(Clone, Copy)]
struct TextLine<'t> {
    start: usize,
    text: &'t str,
}

impl<'t> TextLine<'t> {
    /// The line with this place.
    fn at(text: &'t str, place: usize) -> TextLine<'t> {
        let start = text.get(..place).and_then(|before| before.rfind('\n')).map_or(0, |at| at + 1);
        TextLine { start, text: text.get(start..).unwrap_or_default().lines().next().unwrap_or_default() }
    }

    /// Does it end with a `=` whose value stands on the next line?
    fn continues(self, next: TextLine<'_>) -> bool {
        self.text.trim_end().ends_with('=') && next.start == self.start + self.text.len() + 1
    }
}

fn span_of(error: &toml::de::Error, text: &str) -> Span {
    error.span().map_or(Span::new(0, text.len().min(1)), |range| Span::new(range.start, range.end))
}

fn without_nothing(error: &toml::de::Error) -> &str {
    error.message().trim_end_matches(", expected nothing")
}

/// Does more than half of the lines have an error that is no usual slip, and are there a few of them?
fn mostly_wrong(text: &str, errors: &[toml::de::Error], keys: &[&str]) -> bool {
    let mut lines: Vec<TextLine<'_>> =
        errors.iter().map(|error| TextLine::at(text, span_of(error, text).start)).collect();
    lines.dedup_by_key(|line| line.start);
    let written = text.lines().filter(|line| !line.trim().is_empty() && !line.trim_start().starts_with('#')).count();
    let strange = || lines.iter().filter(|line| slips::mended(line.text, keys).is_none()).count();
    lines.len() > 4 && 2 * lines.len() > written && 2 * strange() > lines.len()
}

/// The fault of a file that is not meant to be TOML.
fn something_else(first: &toml::de::Error, text: &str) -> Fault {
    Fault::new("scene::not_a_scene", "this is not a scene: it is neither TOML nor JSON", span_of(first, text))
        .label(without_nothing(first))
        .help("`cotree new NAME` writes a scene to start from")
}

/// A fault of TOML's syntax, with what is usually meant there; the same slip in other lines is the same fault.
fn toml_syntax(line: TextLine<'_>, message: &str, span: Span, keys: &[&str], faults: &mut Sink) {
    if let Some(Mended { what, place: (from, to), line: better }) = slips::mended(line.text, keys) {
        let span = Span::new(line.start + from, line.start + to);
        if !faults.again(&what, span) {
            let better = better.replace('\n', "` and, in a line of its own, `");
            faults.push_about(&what, syntax(&what, span).help(format!("write `{better}`")));
        }
        return;
    }
    let help = match line.text.split('#').next().unwrap_or_default().trim() {
        _ if message.starts_with("carriage return") => "save the file with the line endings of Linux or Windows".to_owned(),
        code if code.ends_with('=') => format!("write the value of `{}` on the same line", code.trim_end_matches('=').trim()),
        code if !code.contains('=') => {
            "a line is a key with its value (`mass = 1.5`), the header of a table (`[bodies.NAME]`), or a comment (`# ...`)".to_owned()
        }
        _ => String::new(),
    };
    faults.push(syntax(message, span).help(help));
}

/// A key that a table has twice: where several are, the header of another table may be missing.
fn repeated_key(name: &str, span: Span, table: TextLine<'_>, faults: &mut Sink) {
    let subject = format!("table at {}", table.start);
    if !faults.again(&subject, span) {
        let help = "remove one; or, if another table begins here, write its header above, such as `[bodies.NAME]`";
        faults.push_about(&subject, duplicate_key(name, span).help(help));
    }
}

/// A fault of the file's syntax.
pub(crate) fn syntax(message: &str, span: Span) -> Fault {
    Fault::new("scene::syntax", format!("the file cannot be read: {message}"), span).label("here")
}

/// The same key twice in one table.
pub(crate) fn duplicate_key(name: &str, span: Span) -> Fault {
    Fault::new("scene::duplicate_name", format!("`{name}` is defined twice"), span)
        .label("second time")
        .help("give each its own name, or remove one")
}

/// The span of a text's content between its quotes if it is written there verbatim, else `whole`.
pub(crate) fn inside_quotes(source: &str, whole: Span, text: &str) -> Span {
    [1, 3, 4]
        .into_iter()
        .map(|quotes| whole.start + quotes)
        .find(|&start| start + text.len() < whole.end && source.get(start..start + text.len()) == Some(text))
        .map_or(whole, |start| Span::new(start, start + text.len()))
}

/// The depth of the tree is limited by the parser, so recursion is safe.
fn table_of(source: &str, table: DeTable<'_>) -> Content {
    let mut entries: Vec<(Text, DocumentNode)> = table
        .into_iter()
        .map(|(key, value)| {
            let key_span = Span::new(key.span().start, key.span().end);
            let span = Span::new(value.span().start, value.span().end);
            let key = Text::new(key.into_inner(), key_span);
            (key, node_of(source, span, value.into_inner()))
        })
        .collect();
    entries.sort_by_key(|(key, _)| key.span.start);
    Content::Table(entries)
}

fn node_of(source: &str, span: Span, value: DeValue<'_>) -> DocumentNode {
    let kind = match value {
        DeValue::String(text) => {
            let span = inside_quotes(source, span, &text);
            return DocumentNode { span, kind: Content::Text(text.into_owned()) };
        }
        DeValue::Integer(integer) => Content::Number(integer_of(integer.as_str(), integer.radix())),
        // A number beyond the largest float parses as infinite, which is refused where it is used.
        DeValue::Float(float) => Content::Number(float.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(value) => Content::Boolean(value),
        DeValue::Datetime(_) => Content::Date,
        DeValue::Array(items) => Content::Array(
            items
                .into_iter()
                .map(|item| {
                    let span = Span::new(item.span().start, item.span().end);
                    node_of(source, span, item.into_inner())
                })
                .collect(),
        ),
        DeValue::Table(table) => table_of(source, table),
    };
    DocumentNode { span, kind }
}

/// Digits of any length as a float.
fn integer_of(digits: &str, radix: u32) -> f64 {
    if radix == 10 {
        return digits.parse().unwrap_or(f64::NAN);
    }
    digits
        .chars()
        .filter_map(|digit| digit.to_digit(radix))
        .fold(0.0, |sum, digit| sum * f64::from(radix) + f64::from(digit))
}
