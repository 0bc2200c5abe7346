//! Brackets that are not closed: a reader of TOML notices them only where the next table begins, or not at all.

use super::document::syntax;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Span;

/// What stands open at some place of a text.
#[derive(Clone, Copy)]
struct OpenBracket {
    bracket: char,
    at: usize,
}

/// Does a line of the text begin with one of the keys, as a scene's would?
pub(super) fn mentions(text: &str, keys: &[&str]) -> bool {
    let begins = |line: &str, key: &str| {
        line.strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with(['=', '.', ']']))
    };
    let mut lines = text.lines().map(|line| line.trim_start().trim_start_matches('['));
    lines.any(|line| keys.iter().any(|key| begins(line, key)))
}

/// The bracket behind which a new table or key begins before it is closed; none in a text that has none of the `keys`.
pub(super) fn unclosed(text: &str, keys: &[&str]) -> Option<Fault> {
    if !mentions(text, keys) {
        return None;
    }
    let mut open: Vec<OpenBracket> = Vec::new();
    let mut start = 0;
    let mut quote: Option<&str> = None;
    for line in text.split_inclusive('\n') {
        if let Some(last) = open.last().filter(|_| quote.is_none() && begins_anew(line, open.last())) {
            let message = format!("this `{}` is not closed", last.bracket);
            let closing = if last.bracket == '[' { ']' } else { '}' };
            let fault = syntax(&message, Span::new(last.at, last.at + 1)).label("opened here");
            let line = text[..start].matches('\n').count();
            return Some(fault.help(format!(
                "add `{closing}` before the end of line {line}: line {} begins another entry",
                line + 1
            )));
        }
        scan(line, start, &mut open, &mut quote);
        start += line.len();
    }
    None
}

/// Is this line the header of a table, or a key with its value?
fn begins_anew(line: &str, last: Option<&OpenBracket>) -> bool {
    let line = line.split('#').next().unwrap_or_default().trim();
    let is_word = |text: &str| {
        let text = text.trim().trim_matches('"');
        !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '.'))
    };
    let header = line.strip_prefix('[').and_then(|line| line.strip_suffix(']'));
    // In a list of lists `[0]` is an item, not a table.
    let header = header.is_some_and(|name| is_word(name) && name.starts_with(|c: char| c.is_alphabetic() || c == '_'));
    let key = line.split_once('=').is_some_and(|(key, value)| is_word(key) && !value.trim_start().starts_with('='));
    // The keys of a table in braces may stand in lines of their own.
    header || key && last.is_some_and(|open| open.bracket == '[')
}

/// Follows brackets and quotes through a line.
fn scan<'t>(line: &'t str, start: usize, open: &mut Vec<OpenBracket>, quote: &mut Option<&'t str>) {
    let mut at = 0;
    while at < line.len() {
        let rest = &line[at..];
        let first = rest.chars().next().map_or(1, char::len_utf8);
        if let Some(closing) = *quote {
            let escaped = closing.starts_with('"') && rest.starts_with('\\');
            let length = if escaped { 1 + rest[1..].chars().next().map_or(0, char::len_utf8) } else { first };
            let closed = rest.starts_with(closing);
            *quote = quote.filter(|_| !closed);
            at += if closed { closing.len() } else { length };
            continue;
        }
        let found = ["\"\"\"", "'''", "\"", "'"].into_iter().find(|mark| rest.starts_with(mark));
        match (found, rest.as_bytes()[0]) {
            (Some(mark), _) => *quote = Some(&rest[..mark.len()]),
            (None, b'#') => return,
            (None, b'[' | b'{') => open.push(OpenBracket { bracket: char::from(rest.as_bytes()[0]), at: start + at }),
            (None, b']' | b'}') => _ = open.pop(),
            _ => {}
        }
        at += found.map_or(first, str::len);
    }
    // A text in one line ends with it, closed or not.
    *quote = quote.filter(|mark| mark.len() == 3);
}
