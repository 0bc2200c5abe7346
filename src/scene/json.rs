//! A JSON reader that knows where each value is written.

use super::document::{Content, DocumentNode, duplicate_key, inside_quotes, syntax};
use crate::diagnostic::fault::{Fault, Sink};
use crate::diagnostic::span::{Span, Text};
use std::collections::HashSet;

/// Deeper nesting is refused, so that no text can exhaust the stack.
const DEEPEST: usize = 80;

/// Reads one JSON value; the first syntax error ends the reading.
pub(crate) fn read(text: &str, faults: &mut Sink) -> Option<DocumentNode> {
    let mut reader = JsonReader { text, at: 0, faults };
    let result = reader.value(0).and_then(|node| {
        reader.skip_space();
        if reader.at == text.len() { Ok(node) } else { Err(reader.expected("the end of the file")) }
    });
    match result {
        Ok(node) => Some(node),
        Err(fault) => {
            faults.push(fault);
            None
        }
    }
}

struct JsonReader<'t, 'f> {
    text: &'t str,
    at: usize,
    faults: &'f mut Sink,
}

impl JsonReader<'_, '_> {
    fn value(&mut self, depth: usize) -> Result<DocumentNode, Fault> {
        self.skip_space();
        let start = self.at;
        if depth > DEEPEST {
            return Err(syntax("nested too deeply", Span::new(start, start + 1)));
        }
        let kind = match self.peek() {
            Some('{') => self.table(depth)?,
            Some('[') => self.array(depth)?,
            Some('"') => {
                let Text { text, span } = self.string()?;
                return Ok(DocumentNode { span, kind: Content::Text(text) });
            }
            Some('-' | '0'..='9') => self.number()?,
            Some('a'..='z' | 'A'..='Z') => self.word()?,
            _ => return Err(self.expected("a value")),
        };
        Ok(DocumentNode { span: Span::new(start, self.at), kind })
    }

    fn table(&mut self, depth: usize) -> Result<Content, Fault> {
        self.at += 1;
        let mut entries: Vec<(Text, DocumentNode)> = Vec::new();
        let mut seen = HashSet::new();
        self.skip_space();
        if self.take('}') {
            return Ok(Content::Table(entries));
        }
        loop {
            self.skip_space();
            if self.peek() != Some('"') {
                return Err(self.expected("a key in double quotes").help("JSON permits no comma before `}`"));
            }
            let key = self.string()?;
            self.skip_space();
            if !self.take(':') {
                return Err(self.expected("`:` after the key"));
            }
            let value = self.value(depth + 1)?;
            if seen.insert(key.text.clone()) {
                entries.push((key, value));
            } else {
                self.faults.push(duplicate_key(&key.text, key.span));
            }
            self.skip_space();
            if self.take('}') {
                return Ok(Content::Table(entries));
            }
            if !self.take(',') {
                return Err(self.expected("`,` or `}`"));
            }
        }
    }

    fn array(&mut self, depth: usize) -> Result<Content, Fault> {
        self.at += 1;
        let mut items = Vec::new();
        self.skip_space();
        if self.take(']') {
            return Ok(Content::Array(items));
        }
        loop {
            items.push(self.value(depth + 1)?);
            self.skip_space();
            if self.take(']') {
                return Ok(Content::Array(items));
            }
            if !self.take(',') {
                return Err(self.expected("`,` or `]`"));
            }
        }
    }

    fn string(&mut self) -> Result<Text, Fault> {
        let start = self.at;
        self.at += 1;
        let mut text = String::new();
        loop {
            match self.next() {
                Some('"') => break,
                Some('\\') => text.push(self.escape()?),
                Some(c) if c >= ' ' => text.push(c),
                _ => {
                    return Err(syntax("this text has no closing `\"` on its line", Span::new(start, start + 1)));
                }
            }
        }
        let span = inside_quotes(self.text, Span::new(start, self.at), &text);
        Ok(Text { text, span })
    }

    fn escape(&mut self) -> Result<char, Fault> {
        let start = self.at - 1;
        let character = match self.next() {
            Some(c @ ('"' | '\\' | '/')) => Some(c),
            Some('b') => Some('\u{8}'),
            Some('f') => Some('\u{c}'),
            Some('n') => Some('\n'),
            Some('r') => Some('\r'),
            Some('t') => Some('\t'),
            Some('u') => self.unicode(),
            _ => None,
        };
        character.ok_or_else(|| syntax("not an escape that JSON knows", Span::new(start, self.at)))
    }

    /// Four hexadecimal digits, or a surrogate pair of them.
    fn unicode(&mut self) -> Option<char> {
        let first = self.hexadecimal()?;
        if !(0xd800..0xdc00).contains(&first) {
            return char::from_u32(first);
        }
        if !(self.take('\\') && self.take('u')) {
            return None;
        }
        let second = self.hexadecimal().filter(|second| (0xdc00..0xe000).contains(second))?;
        char::from_u32(0x10000 + ((first - 0xd800) << 10) + (second - 0xdc00))
    }

    fn hexadecimal(&mut self) -> Option<u32> {
        (0..4).try_fold(0, |sum, _| Some(sum * 16 + self.next()?.to_digit(16)?))
    }

    fn number(&mut self) -> Result<Content, Fault> {
        let rest = &self.text[self.at..];
        let length = rest.find(|c: char| !matches!(c, '0'..='9' | '+' | '-' | '.' | 'e' | 'E')).unwrap_or(rest.len());
        let digits = &rest[..length];
        let span = Span::new(self.at, self.at + length);
        self.at += length;
        digits.parse().map(Content::Number).map_err(|_| syntax("not a number", span).label("not a number"))
    }

    fn word(&mut self) -> Result<Content, Fault> {
        let rest = &self.text[self.at..];
        let length = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
        let kind = match &rest[..length] {
            "true" => Content::Boolean(true),
            "false" => Content::Boolean(false),
            "null" => Content::Null,
            word => {
                let message = format!("`{word}` is not a value; write texts in double quotes");
                return Err(syntax(&message, Span::new(self.at, self.at + length)));
            }
        };
        self.at += length;
        Ok(kind)
    }

    fn expected(&self, what: &str) -> Fault {
        let end = self.at + self.peek().map_or(0, char::len_utf8);
        syntax(&format!("expected {what}"), Span::new(self.at, end)).label(format!("expected {what}"))
    }

    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn next(&mut self) -> Option<char> {
        let next = self.peek()?;
        self.at += next.len_utf8();
        Some(next)
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        if found {
            self.at += wanted.len_utf8();
        }
        found
    }

    fn skip_space(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start_matches([' ', '\t', '\n', '\r']).len();
    }
}
