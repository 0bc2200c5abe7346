//! A scene's text while it is edited: keys are written, added and removed where the text has its own of that kind, and nothing else in it changes: not its
//! comments, its order, its spaces or the ends of its lines. That is why a text is cut at places and not written anew from a tree.

use super::super::decode::{byte_order_mark, is_json_text, tree};
use super::super::document::{Content, DocumentNode};
use super::EditError;
use super::layout::{Entry, Form, Home, Layout};
use crate::diagnostic::Span;

/// The order in which tables are added.
const ORDER: [&str; 12] = [
    "parameters",
    "inputs",
    "states",
    "ground",
    "bodies",
    "joints",
    "drivers",
    "loads",
    "signals",
    "initial",
    "outputs",
    "experiment",
];

/// A text in TOML or JSON that is edited.
pub(super) struct SceneText {
    pub text: String,
    json: bool,
}

/// Where entries of a table can be added, and what must stand around them.
#[derive(Clone, Debug, Default)]
pub struct EntryPlace {
    /// The place, in bytes.
    pub at: usize,
    /// Before the first one.
    pub head: String,
    /// Between two of them.
    pub separator: String,
    /// Behind the last one.
    pub tail: String,
    /// Before the name of each.
    prefix: String,
    /// Names are as wide as this, so that values begin below each other.
    width: usize,
    json: bool,
}

impl SceneText {
    pub fn new(text: &str, json: bool) -> SceneText {
        let json = json || is_json_text(text.get(byte_order_mark(text)..).unwrap_or_default());
        SceneText { text: text.to_owned(), json }
    }

    /// What the text says.
    pub fn tree(&self) -> Result<DocumentNode, EditError> {
        tree(&self.text, self.json).ok_or_else(EditError::unreadable)
    }

    pub fn layout(&self) -> Result<Layout, EditError> {
        let tree = self.tree()?;
        Ok(if self.json {
            Layout::of_json(&self.text, &tree)
        } else {
            Layout::of_toml(&self.text, byte_order_mark(&self.text))
        })
    }

    /// Gives a key a value, which is written in TOML: in place of its own, or as one more key of its table.
    pub fn set(&mut self, path: &[String], value: &str) -> Result<(), EditError> {
        let layout = self.layout()?;
        let value = self.value(value)?;
        if let Some(entry) = layout.entry(path) {
            self.text.replace_range(entry.value.start..entry.value.end, &value);
            return Ok(());
        }
        let Some((name, table)) = path.split_last() else { return Ok(()) };
        let gap = self.gap(&layout, table)?;
        let added = gap.filled(&[(name.clone(), value)]);
        self.text.insert_str(gap.at, &added);
        Ok(())
    }

    /// Adds a table with these keys.
    pub fn add(&mut self, path: &[String], keys: &[(String, String)]) -> Result<(), EditError> {
        let Some((name, table)) = path.split_last() else { return Ok(()) };
        let layout = self.layout()?;
        let values = keys.iter().map(|(key, value)| Ok((key.clone(), self.value(value)?)));
        let values: Vec<(String, String)> = values.collect::<Result<_, EditError>>()?;
        let gap = self.own_gap(&layout, table)?;
        let (gap, entries) = match gap {
            None if !self.json => {
                let longest = values.iter().map(|(key, _)| key.len()).max().unwrap_or_default();
                let gap = EntryPlace { width: longest, ..self.header(&layout, path) };
                (gap, values)
            }
            gap => {
                let gap = gap.unwrap_or_else(|| self.in_braces(&layout, 0, table));
                let keys: Vec<String> =
                    values.iter().map(|(key, value)| format!("{}{}{value}", gap.key(key), gap.sign())).collect();
                (gap, vec![(name.clone(), format!("{{ {} }}", keys.join(", ")))])
            }
        };
        let added = gap.filled(&entries);
        self.text.insert_str(gap.at, &added);
        Ok(())
    }

    /// Adds an item to a list, or writes the list.
    pub fn append(&mut self, path: &[String], item: &str) -> Result<(), EditError> {
        let layout = self.layout()?;
        let Some(entry) = layout.entry(path) else { return self.set(path, &format!("[{item}]")) };
        let Some(items) = &entry.items else { return Err(EditError::no_table(path, "a list")) };
        let Insertion { at, head, tail } = inside(&self.text, entry.value, items.last().copied());
        let item = self.value(item)?;
        let (head, tail) = if items.is_empty() { (String::new(), String::new()) } else { (head, tail) };
        self.text.insert_str(at, &format!("{head}{item}{tail}"));
        Ok(())
    }

    /// Removes a key or a table with all that it has.
    pub fn remove(&mut self, path: &[String]) -> Result<(), EditError> {
        loop {
            let layout = self.layout()?;
            let header = |home: &Home| home.form != Form::Braces && !home.is_top() && home.path.starts_with(path);
            let piece = match layout.homes.iter().position(header) {
                Some(home) => Some(self.block(&layout, home)),
                None => layout
                    .entries
                    .iter()
                    .find(|entry| entry.path.starts_with(path))
                    .map(|entry| self.piece(&layout, entry)),
            };
            let Some(piece) = piece else { return Ok(()) };
            self.text.replace_range(piece.start..piece.end, "");
        }
    }

    /// Removes the items of a list that are such texts; the key goes with the last of them.
    pub fn remove_items(&mut self, path: &[String], is_meant: impl Fn(&str) -> bool) -> Result<(), EditError> {
        loop {
            let (layout, tree) = (self.layout()?, self.tree()?);
            let Some(entry) = layout.entry(path) else { return Ok(()) };
            let (Some(Content::Array(nodes)), Some(items)) = (at(&tree, path).map(|node| &node.kind), &entry.items)
            else {
                return Ok(());
            };
            let texts = nodes.iter().map(|node| if let Content::Text(text) = &node.kind { text.as_str() } else { "" });
            let Some(index) = texts.into_iter().position(&is_meant) else { return Ok(()) };
            if items.len() == 1 {
                return self.remove(path);
            }
            let piece = cut(&self.text, items, index);
            self.text.replace_range(piece.start..piece.end, "");
        }
    }

    /// Where the entries of a table are added.
    pub fn gap(&self, layout: &Layout, table: &[String]) -> Result<EntryPlace, EditError> {
        Ok(match self.own_gap(layout, table)? {
            Some(gap) => gap,
            None if self.json => self.in_braces(layout, 0, table),
            None if table.is_empty() => self.in_lines(layout, 0, None, table),
            None => self.header(layout, table),
        })
    }

    /// The same where the text has the table, or one that it is in, in another way than by the headers of its own tables.
    fn own_gap(&self, layout: &Layout, table: &[String]) -> Result<Option<EntryPlace>, EditError> {
        for depth in (1..=table.len()).rev() {
            let (head, rest) = table.split_at(depth);
            if let Some(index) = layout.homes.iter().rposition(|home| home.path == head && home.form != Form::Repeated)
            {
                let home = &layout.homes[index];
                return Ok(Some(match home.form {
                    Form::Braces => self.in_braces(layout, index, rest),
                    Form::Lines | Form::Repeated => self.in_lines(layout, index, None, rest),
                }));
            }
            if layout.entry(head).is_some() {
                return Err(EditError::no_table(head, "a table"));
            }
            // Dotted keys: the table goes on where it is.
            let dotted = |entry: &&Entry| {
                entry.path.starts_with(head) && layout.homes.get(entry.home).is_some_and(|home| home.path.len() < depth)
            };
            if let Some(last) = layout.entries.iter().rfind(dotted) {
                let home = &layout.homes[last.home];
                let mut gap = match home.form {
                    Form::Braces => self.in_braces(layout, last.home, &[]),
                    Form::Lines | Form::Repeated => self.in_lines(layout, last.home, Some(last.span.end), &[]),
                };
                let names = table[home.path.len()..].iter().map(|name| gap.key(name) + ".");
                gap.prefix = names.collect();
                return Ok(Some(gap));
            }
        }
        Ok(None)
    }

    /// Behind the last entry within the braces, in tables of its own for the `rest` of the path.
    fn in_braces(&self, layout: &Layout, home: usize, rest: &[String]) -> EntryPlace {
        let last = layout.of(home).next_back().map(|entry| entry.span);
        let Insertion { at, head, tail } = inside(&self.text, layout.homes[home].span, last);
        let gap = EntryPlace { at, head, separator: ", ".to_owned(), tail, json: self.json, ..EntryPlace::default() };
        gap.wrapped(rest)
    }

    /// In a line behind the last one of a home, or behind the one that is given.
    fn in_lines(&self, layout: &Layout, home: usize, behind: Option<usize>, rest: &[String]) -> EntryPlace {
        let header = layout.homes[home].span;
        let last = layout.of(home).next_back();
        let is_first = last.is_none() && layout.homes[home].is_top();
        let at = if is_first {
            header.end
        } else {
            line_end(&self.text, behind.or(last.map(|entry| entry.span.end)).unwrap_or(header.end))
        };
        let indent = last.map_or("", |entry| indent(&self.text, entry.span.start));
        let eol = self.eol();
        let head = if is_first { String::new() } else { format!("{eol}{indent}") };
        let tail = if is_first || self.text[at..].is_empty() { eol } else { "" };
        let gap = EntryPlace {
            at,
            head,
            separator: format!("{eol}{indent}"),
            tail: tail.to_owned(),
            ..EntryPlace::default()
        };
        gap.wrapped(rest)
    }

    /// Under a header of its own, in the order of tables.
    fn header(&self, layout: &Layout, path: &[String]) -> EntryPlace {
        let (eol, rank) = (self.eol(), |path: &[String]| {
            ORDER.iter().position(|section| path.first().is_some_and(|name| name == section)).unwrap_or(ORDER.len())
        });
        let headers = || {
            (0..layout.homes.len())
                .filter(|&home| layout.homes[home].form != Form::Braces && !layout.homes[home].is_top())
        };
        let before = headers().rev().find(|&home| rank(&layout.homes[home].path) <= rank(path));
        let mut gap = EntryPlace { separator: eol.to_owned(), ..EntryPlace::default() };
        let name: Vec<String> = path.iter().map(|name| gap.key(name)).collect();
        let line = format!("[{}]{eol}", name.join("."));
        let first = headers().next();
        if let (None, Some(first)) = (before, first) {
            gap.at = layout.homes[first].span.start;
            (gap.head, gap.tail) = (line, format!("{eol}{eol}"));
            return gap;
        }
        gap.at = before.map_or(self.text.trim_end().len(), |home| {
            line_end(
                &self.text,
                layout.of(home).next_back().map_or(layout.homes[home].span.end, |entry| entry.span.end),
            )
        });
        gap.head = if gap.at == 0 { line } else { format!("{eol}{eol}{line}") };
        gap.tail = if self.text[gap.at..].contains('\n') { String::new() } else { eol.to_owned() };
        gap
    }

    /// The lines under a header, with the empty ones before it.
    fn block(&self, layout: &Layout, home: usize) -> Span {
        let header = layout.homes[home].span;
        let last = line_end(&self.text, layout.of(home).next_back().map_or(header.end, |entry| entry.span.end));
        let start = self.text[..header.start].trim_end().len();
        let start = if start == 0 {
            header.start
        } else {
            line_end(&self.text, start) + self.line_break(line_end(&self.text, start))
        };
        Span::new(start, (last + self.line_break(last)).min(self.text.len()))
    }

    /// An entry with its line, or with its comma; and the header, if nothing is left under it.
    fn piece(&self, layout: &Layout, entry: &Entry) -> Span {
        let home = &layout.homes[entry.home];
        let all: Vec<Span> = layout.of(entry.home).map(|entry_of_home| entry_of_home.span).collect();
        if home.form == Form::Braces {
            let index = all.iter().position(|span| span.start == entry.span.start).unwrap_or(0);
            return cut(&self.text, &all, index);
        }
        let end = line_end(&self.text, entry.span.end);
        let bare = |from: usize, to: usize| self.text.get(from..to).is_some_and(|between| between.trim().is_empty());
        if all.len() == 1 && !home.is_top() && bare(home.span.end, entry.span.start) {
            return self.block(layout, entry.home);
        }
        let start = self.text[..entry.span.start].rfind('\n').map_or(0, |at| at + 1);
        Span::new(start, end + self.line_break(end))
    }

    /// The length of the line end at a place.
    fn line_break(&self, at: usize) -> usize {
        match self.text.get(at..) {
            Some(rest) if rest.starts_with("\r\n") => 2,
            Some(rest) if rest.starts_with('\n') => 1,
            _ => 0,
        }
    }

    fn eol(&self) -> &'static str {
        if self.text.contains("\r\n") { "\r\n" } else { "\n" }
    }

    /// A value in TOML as this text writes it.
    fn value(&self, toml: &str) -> Result<String, EditError> {
        if !self.json {
            return Ok(toml.to_owned());
        }
        let node = tree(&format!("v = {toml}"), false).ok_or_else(EditError::unreadable)?;
        Ok(at(&node, &["v".to_owned()]).map(json).unwrap_or_default())
    }
}

impl EntryPlace {
    /// The text of these entries here, each a name and its value.
    fn filled(&self, entries: &[(String, String)]) -> String {
        let entries: Vec<String> = entries.iter().map(|(name, value)| self.entry(name, value)).collect();
        format!("{}{}{}", self.head, entries.join(&self.separator), self.tail)
    }

    /// The text of one of them: its name and its value, as the text writes values.
    pub fn entry(&self, name: &str, value: &str) -> String {
        format!("{}{:width$}{}{value}", self.prefix, self.key(name), self.sign(), width = self.width)
    }

    /// A table of one key as a value.
    pub fn table(&self, name: &str, value: &str) -> String {
        format!("{{ {}{}{value} }}", self.key(name), self.sign())
    }

    /// A name as a key.
    fn key(&self, name: &str) -> String {
        let is_bare =
            !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-'));
        if is_bare && !self.json { name.to_owned() } else { quoted(name) }
    }

    fn sign(&self) -> &'static str {
        if self.json { ": " } else { " = " }
    }

    /// In tables of these names, each within the one before.
    fn wrapped(mut self, rest: &[String]) -> EntryPlace {
        for name in rest {
            self.head += &format!("{}{}{{ ", self.key(name), self.sign());
            self.tail = format!(" }}{}", self.tail);
            self.separator = ", ".to_owned();
        }
        self
    }
}

/// A text in double quotes, as TOML and JSON read it.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A value in JSON.
fn json(node: &DocumentNode) -> String {
    match &node.kind {
        Content::Table(entries) => {
            let entries: Vec<String> =
                entries.iter().map(|(key, value)| format!("{}: {}", quoted(&key.text), json(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        Content::Array(items) => format!("[{}]", items.iter().map(json).collect::<Vec<_>>().join(", ")),
        Content::Text(text) => quoted(text),
        Content::Number(number) => number.to_string(),
        Content::Boolean(value) => value.to_string(),
        Content::Date | Content::Null => "null".to_owned(),
    }
}

/// What is at the end of a path.
pub(super) fn at<'n>(node: &'n DocumentNode, path: &[String]) -> Option<&'n DocumentNode> {
    path.iter().try_fold(node, |node, name| match &node.kind {
        Content::Table(entries) => entries.iter().find(|(key, _)| key.text == *name).map(|(_, value)| value),
        _ => None,
    })
}

/// Where one more entry goes, what comes before it and what behind.
struct Insertion {
    at: usize,
    head: String,
    tail: String,
}

/// One more entry within brackets or braces.
fn inside(text: &str, whole: Span, last: Option<Span>) -> Insertion {
    let Some(last) = last else {
        let is_tight = !text[whole.start + 1..].starts_with(char::is_whitespace);
        let tail = if is_tight { " " } else { "" }.to_owned();
        return Insertion { at: whole.start + 1, head: " ".to_owned(), tail };
    };
    let line = text[..last.start].rfind('\n').map_or(0, |at| at + 1);
    let own_line = line > whole.start && text[line..last.start].trim().is_empty();
    let gap = if own_line { format!("\n{}", &text[line..last.start]) } else { " ".to_owned() };
    match comma(text, last.end) {
        Some(comma) if comma < whole.end => Insertion { at: comma + 1, head: gap, tail: String::new() },
        _ => Insertion { at: last.end, head: format!(",{gap}"), tail: String::new() },
    }
}

/// The next comma, if nothing but spaces and comments is before it.
fn comma(text: &str, from: usize) -> Option<usize> {
    let mut at = from;
    loop {
        let rest = text.get(at..)?;
        let skipped = rest.len() - rest.trim_start().len();
        at += skipped;
        match rest.as_bytes().get(skipped) {
            Some(b',') => return Some(at),
            Some(b'#') => at = line_end(text, at),
            _ => return None,
        }
    }
}

/// One of several pieces with its comma.
fn cut(text: &str, all: &[Span], index: usize) -> Span {
    let span = all[index];
    let behind = comma(text, span.end).map(|comma| comma + 1);
    let Some(end) = behind else {
        let start = index.checked_sub(1).map_or(span.start, |before| all[before].end);
        return Span::new(start, span.end);
    };
    let line = text[..span.start].rfind('\n').map_or(0, |at| at + 1);
    let rest = &text[end..line_end(text, end)];
    let has_line =
        text[line..span.start].trim().is_empty() && (rest.trim().is_empty() || rest.trim_start().starts_with('#'));
    if has_line && line > 0 {
        return Span::new(line - 1 - usize::from(text[..line - 1].ends_with('\r')), line_end(text, end));
    }
    let spaces = rest.len() - rest.trim_start().len();
    Span::new(span.start, end + spaces)
}

/// The end of the line with this place, before its line break.
fn line_end(text: &str, at: usize) -> usize {
    let end = text[at..].find('\n').map_or(text.len(), |length| at + length);
    if end > at && text[..end].ends_with('\r') { end - 1 } else { end }
}

/// The spaces before what stands first in its line.
fn indent(text: &str, at: usize) -> &str {
    let before = &text[text[..at].rfind('\n').map_or(0, |at| at + 1)..at];
    if before.trim().is_empty() { before } else { "" }
}
