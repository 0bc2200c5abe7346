//! A scene's text as a tree of values, each with its place in the text; TOML and JSON give the same tree.

use toml::de::{DeTable, DeValue};

use super::json;
use crate::diagnostic::fault::{Fault, Sink};
use crate::diagnostic::span::{Span, Text};

/// A value of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Where it is written; a text without its quotes if it is written verbatim.
    pub span: Span,
    pub kind: Content,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// In the order of the text.
    Table(Vec<(Text, Node)>),
    Array(Vec<Node>),
    Text(String),
    Number(f64),
    Boolean(bool),
    /// TOML's date and time.
    Date,
    /// JSON's null.
    Null,
}

impl Node {
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
pub(crate) fn from_toml(text: &str, keys: &[&str], faults: &mut Sink) -> Option<Node> {
    let (table, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty()
        && let Some(fault) = super::brackets::unclosed(text, keys)
    {
        faults.push(fault);
        return None;
    }
    let strange = |error: &&toml::de::Error| !error.message().starts_with("duplicate key");
    if let Some(first) = errors.iter().find(strange)
        && (!keys.iter().any(|key| table.get_ref().contains_key(*key)) || mostly_wrong(text, &errors))
    {
        faults.push(something_else(first, text));
        return None;
    }
    let mut usable = true;
    let mut last_line = None;
    let mut repeated_table = 0;
    for error in errors {
        let span = error.span().map_or(Span::new(0, text.len().min(1)), |range| Span::new(range.start, range.end));
        let line = text.get(..span.start).map_or(0, |before| before.rfind('\n').map_or(0, |at| at + 1));
        if !error.message().starts_with("duplicate key") {
            usable = false;
            // What follows on the same line comes from the first error.
            if last_line != Some(line) {
                faults.push(toml_syntax(text, error.message().trim_end_matches(", expected nothing"), span));
            }
            last_line = Some(line);
        } else if span.start >= repeated_table {
            let name = text.get(span.start..span.end).unwrap_or_default();
            faults.push(duplicate_key(name, span));
            // The keys of a table that is there twice are there twice as well.
            if text[line..].trim_start().starts_with('[') {
                repeated_table = text[span.end..].find("\n[").map_or(text.len(), |length| span.end + length);
            }
        }
    }
    let span = Span::new(table.span().start, table.span().end);
    usable.then(|| Node { span, kind: table_of(text, table.into_inner()) })
}

/// Reads JSON, likewise.
pub(crate) fn from_json(text: &str, faults: &mut Sink) -> Option<Node> {
    json::read(text, faults)
}

/// Does more than half of the lines have an error, and are there a few of them?
fn mostly_wrong(text: &str, errors: &[toml::de::Error]) -> bool {
    let starts = errors.iter().filter_map(|error| Some(error.span()?.start));
    let mut lines: Vec<usize> =
        starts.map(|at| text.get(..at).map_or(0, |before| before.rfind('\n').unwrap_or(0))).collect();
    lines.dedup();
    let written = text.lines().filter(|line| !line.trim().is_empty() && !line.trim_start().starts_with('#')).count();
    lines.len() > 4 && 2 * lines.len() > written
}

/// The fault of a file that is not meant to be TOML.
fn something_else(first: &toml::de::Error, text: &str) -> Fault {
    let span = first.span().map_or(Span::new(0, text.len().min(1)), |range| Span::new(range.start, range.end));
    let label = first.message().trim_end_matches(", expected nothing").to_owned();
    Fault::new("scene::not_a_scene", "this is not a scene: it is neither TOML nor JSON", span)
        .label(label)
        .help("`cotree new NAME` writes a scene to start from")
}

/// A fault of TOML's syntax; what is usually meant there.
fn toml_syntax(text: &str, message: &str, span: Span) -> Fault {
    let fault = syntax(message, span);
    let start = text.get(..span.start).and_then(|before| before.rfind('\n')).map_or(0, |at| at + 1);
    let line = text.get(start..).unwrap_or_default().lines().next().unwrap_or_default();
    let line = line.split('#').next().unwrap_or_default();
    let Some((_, value)) = line.split_once('=') else { return fault };
    let value = value.trim();
    let is_plain = !value.is_empty() && !value.contains(['"', '\'', '[', '{', '=']);
    let decimal = value.replacen(',', ".", 1);
    match is_plain {
        true if value.contains(',') && decimal.parse::<f64>().is_ok() => {
            fault.help(format!("the decimal sign is a point: `{decimal}`"))
        }
        true => fault.help(format!("texts, numbers with a unit and expressions stand in quotes: `\"{value}\"`")),
        false => fault,
    }
}

/// A fault of the file's syntax.
pub(crate) fn syntax(message: &str, span: Span) -> Fault {
    Fault::new("scene::syntax", format!("the file cannot be read: {message}"), span).label("here")
}

/// The same key twice in one table.
pub(crate) fn duplicate_key(name: &str, span: Span) -> Fault {
    Fault::new("scene::duplicate_name", format!("`{name}` is there twice"), span)
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
    let mut entries: Vec<(Text, Node)> = table
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

fn node_of(source: &str, span: Span, value: DeValue<'_>) -> Node {
    let kind = match value {
        DeValue::String(text) => {
            let span = inside_quotes(source, span, &text);
            return Node { span, kind: Content::Text(text.into_owned()) };
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
    Node { span, kind }
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
