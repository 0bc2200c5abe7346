//! How a scene's text is laid out: which key stands where, and under which header or in which braces. TOML writes the same table in four ways - under a
//! header, in braces, by dotted keys, by the headers of its own tables - and JSON in one; an edit must keep to the way that is there.

use toml_parser::Source;
use toml_parser::parser::{Event, EventKind, parse_document};

use super::super::document::{Content, DocumentNode};
use crate::diagnostic::Span;

/// The keys of a text and what they stand in, in the order of the text.
#[derive(Default)]
pub(super) struct Layout {
    pub homes: Vec<Home>,
    pub entries: Vec<Entry>,
}

/// What entries stand in.
pub(super) struct Home {
    /// The table that it is, from the top of the text.
    pub path: Vec<String>,
    pub form: Form,
    /// Its header, or its braces; empty for the lines before the first header.
    pub span: Span,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// The lines under a header, or before the first one.
    Lines,
    /// One table of several under the same header in double brackets.
    Repeated,
    Braces,
}

/// A key with its value.
pub(super) struct Entry {
    /// From the top of the text.
    pub path: Vec<String>,
    /// Its place among the homes.
    pub home: usize,
    /// From its key to the end of its value.
    pub span: Span,
    /// With its quotes.
    pub value: Span,
    /// The items of a list.
    pub items: Option<Vec<Span>>,
}

impl Home {
    /// Is it what stands before the first header?
    pub fn is_top(&self) -> bool {
        self.form == Form::Lines && self.span.start == self.span.end
    }
}

impl Layout {
    /// The layout of a text in TOML that can be read.
    pub fn of_toml(text: &str, begin: usize) -> Layout {
        let source = Source::new(text.get(begin..).unwrap_or_default());
        let mut events: Vec<Event> = Vec::new();
        parse_document(&source.lex().into_vec(), &mut events, &mut ());
        let layout = Layout {
            homes: vec![Home { path: Vec::new(), form: Form::Lines, span: Span::new(begin, begin) }],
            entries: Vec::new(),
        };
        let mut reader = Reader { source, begin, layout, lines: 0, keys: Vec::new(), open: Vec::new(), within: 0 };
        events.iter().for_each(|event| reader.take(event));
        reader.layout
    }

    /// The layout of a text in JSON, from its tree.
    pub fn of_json(text: &str, tree: &DocumentNode) -> Layout {
        let mut layout = Layout::default();
        layout.braces(text, tree, Vec::new());
        layout
    }

    fn braces(&mut self, text: &str, node: &DocumentNode, path: Vec<String>) {
        let Content::Table(entries) = &node.kind else { return };
        let home = self.homes.len();
        self.homes.push(Home { path: path.clone(), form: Form::Braces, span: node.span });
        for (key, value) in entries {
            let path = [path.clone(), vec![key.text.clone()]].concat();
            let items = match &value.kind {
                Content::Array(items) => Some(items.iter().map(|item| item.span.whole(text)).collect()),
                _ => None,
            };
            let whole = value.span.whole(text);
            let span = Span::new(key.span.whole(text).start, whole.end);
            self.entries.push(Entry { path: path.clone(), home, span, value: whole, items });
            self.braces(text, value, path);
        }
    }

    /// The key that is written as this.
    pub fn entry(&self, path: &[String]) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.path == path)
    }

    /// The entries of a home.
    pub fn of(&self, home: usize) -> impl DoubleEndedIterator<Item = &Entry> {
        self.entries.iter().filter(move |entry| entry.home == home)
    }

    /// Is something of a table written?
    pub fn has(&self, path: &[String]) -> bool {
        self.homes
            .iter()
            .map(|home| &home.path)
            .chain(self.entries.iter().map(|entry| &entry.path))
            .any(|written_path| written_path.starts_with(path))
    }
}

/// Takes what the parser of TOML finds.
struct Reader<'t> {
    source: Source<'t>,
    /// Where the source begins in the text.
    begin: usize,
    layout: Layout,
    /// The home of the lines that follow.
    lines: usize,
    /// The keys of a header, or before a value.
    keys: Vec<(String, Span)>,
    /// The lists and braces that are open, by their entries.
    open: Vec<Open>,
    /// How deep in an item of a list.
    within: usize,
}

#[derive(Clone, Copy)]
enum Open {
    List { entry: usize, item: usize },
    Braces { entry: usize, home: usize },
}

impl Reader<'_> {
    fn take(&mut self, event: &Event) {
        let span = Span::new(event.span().start() + self.begin, event.span().end() + self.begin);
        match event.kind() {
            EventKind::StdTableOpen => self.header(Form::Lines, span),
            EventKind::ArrayTableOpen => self.header(Form::Repeated, span),
            EventKind::StdTableClose | EventKind::ArrayTableClose => self.header_ends(span),
            EventKind::SimpleKey if self.within == 0 => {
                let mut name = String::new();
                if let Some(raw) = self.source.get(event) {
                    raw.decode_key(&mut name, &mut ());
                }
                self.keys.push((name, span));
            }
            EventKind::Scalar => self.value(span, None),
            EventKind::ArrayOpen => self.value(span, Some(false)),
            EventKind::InlineTableOpen => self.value(span, Some(true)),
            EventKind::ArrayClose | EventKind::InlineTableClose => self.close(span.end),
            _ => {}
        }
    }

    fn header(&mut self, form: Form, span: Span) {
        self.keys.clear();
        self.lines = self.layout.homes.len();
        self.layout.homes.push(Home { path: Vec::new(), form, span });
    }

    fn header_ends(&mut self, span: Span) {
        if let Some(home) = self.layout.homes.get_mut(self.lines) {
            home.path = self.keys.drain(..).map(|(name, _)| name).collect();
            home.span.end = span.end;
        }
    }

    /// A value begins: a list, braces, or neither.
    fn value(&mut self, span: Span, braces: Option<bool>) {
        if self.within > 0 {
            self.within += usize::from(braces.is_some());
            return;
        }
        if let Some(Open::List { entry, item }) = self.open.last_mut() {
            *item = span.start;
            if braces.is_some() {
                self.within = 1;
            } else if let Some(items) = self.layout.entries.get_mut(*entry).and_then(|entry| entry.items.as_mut()) {
                items.push(span);
            }
            return;
        }
        let home = match self.open.last() {
            Some(Open::Braces { home, .. }) => *home,
            _ => self.lines,
        };
        let start = self.keys.first().map_or(span.start, |(_, key)| key.start);
        let mut path = self.layout.homes.get(home).map(|home| home.path.clone()).unwrap_or_default();
        path.extend(self.keys.drain(..).map(|(name, _)| name));
        let (entry, items) = (self.layout.entries.len(), (braces == Some(false)).then(Vec::new));
        match braces {
            Some(true) => {
                self.open.push(Open::Braces { entry, home: self.layout.homes.len() });
                self.layout.homes.push(Home { path: path.clone(), form: Form::Braces, span });
            }
            Some(false) => self.open.push(Open::List { entry, item: 0 }),
            None => {}
        }
        self.layout.entries.push(Entry { path, home, span: Span::new(start, span.end), value: span, items });
    }

    fn close(&mut self, end: usize) {
        if self.within > 0 {
            self.within -= 1;
            if let (0, Some(Open::List { entry, item })) = (self.within, self.open.last())
                && let Some(items) = self.layout.entries.get_mut(*entry).and_then(|entry| entry.items.as_mut())
            {
                items.push(Span::new(*item, end));
            }
            return;
        }
        let Some(Open::List { entry, .. } | Open::Braces { entry, .. }) = self.open.last().copied() else { return };
        if let Some(Open::Braces { home, .. }) = self.open.pop()
            && let Some(home) = self.layout.homes.get_mut(home)
        {
            home.span.end = end;
        }
        if let Some(entry_layout) = self.layout.entries.get_mut(entry) {
            (entry_layout.span.end, entry_layout.value.end) = (end, end);
        }
    }
}
