//! Edits of a scene's text: other values, keys that it does not write yet, and elements that are added or removed. All else in the text stays as it is, comments too.

mod elements;
mod layout;
#[cfg(test)]
mod tests;
mod text;

pub use elements::{Edit, edited};
pub use text::EntryPlace;

use super::decode::{is_json, is_json_text, tree};
use super::document::{Content, DocumentNode};
use super::tables::SCENE;
use super::{Faults, Scene};
use crate::diagnostic::{Span, suggest};
use std::path::Path;

/// Tables whose entries are named without them.
const TABLES: [&str; 9] =
    ["parameters", "inputs", "states", "initial", "signals", "bodies", "joints", "drivers", "loads"];
/// The key of an entry that is called by the entry's name.
const ITSELF: [&str; 3] = ["value", "start", "guess"];
/// The tables whose entries have positions and velocities, which `[initial]` knows by the same names.
const MOVING: [&str; 2] = ["bodies", "joints"];

/// Why a scene cannot be changed.
#[derive(Debug, thiserror::Error)]
pub enum EditError {
    /// The names do not fit the text.
    #[error("{0}")]
    Text(String),
    /// The scene does not write what is named.
    #[error("{0}")]
    Unknown(String),
    /// What is wrong with the scene once it is changed.
    #[error(transparent)]
    Scene(#[from] Faults),
}

impl EditError {
    fn unreadable() -> EditError {
        EditError::Text("the text of the scene cannot be read".to_owned())
    }

    fn no_table(path: &[String], form: &str) -> EditError {
        EditError::Text(format!("`{}` is not written as {form}", path.join(".")))
    }
}

impl Scene {
    /// The scene with other values: of a parameter, an input, a state, an initial value or a signal by its name, such as `rod_length`; of a key of a body, joint, driver or load such
    /// as `rod.mass`; of any other key by its whole path, such as `experiment.stop`. Values are written as in TOML and JSON: a number, a text in quotes, a list.
    ///
    /// A key that is not written is added to the table that it belongs to, and a position or velocity to `[initial]`.
    ///
    /// # Errors
    /// A name that belongs to nothing in the scene, or to several things; what is wrong with the changed scene.
    pub fn replaced(&self, changes: &[(String, String)]) -> Result<Scene, EditError> {
        let mut files: Vec<(String, String)> =
            self.source.files().map(|(name, text)| (name.to_owned(), text.to_owned())).collect();
        let Some((name, text)) = files.first_mut() else {
            return Err(EditError::Text("the scene has no text".to_owned()));
        };
        let json = is_json(Path::new(name)) || is_json_text(text);
        let tree = tree(text, json).ok_or_else(EditError::unreadable)?;
        let (mut places, mut new) = (Vec::new(), Vec::new());
        for (name, value) in changes {
            match written(&tree, name) {
                Ok(span) => places.push((span.whole(text), value.clone())),
                Err(unknown @ EditError::Unknown(_)) => new.push((name, value, unknown)),
                Err(error) => return Err(error),
            }
        }
        *text = spliced(text, places)?;
        for (name, value, unknown) in new {
            *text = self.with_key(text, json, (name, value)).ok_or(unknown)?;
        }
        Ok(Scene::from_files(&files)?)
    }

    /// A text of the scene with a key more; none if there is nothing that it could belong to.
    fn with_key(&self, text: &str, json: bool, (name, value): (&str, &str)) -> Option<String> {
        let tree = tree(text, json)?;
        let (table, keys) = self.home(&tree, name)?;
        let (at, entry) = if json { in_json(table, &keys, value)? } else { in_toml(text, table, &keys, value)? };
        spliced(text, vec![(Span::new(at, at), entry)]).ok()
    }

    /// The table that a key belongs to, and what it is called there.
    fn home<'n>(&self, tree: &'n DocumentNode, name: &'n str) -> Option<(&'n DocumentNode, Vec<&'n str>)> {
        let named = |path: &str| entries(tree)?.iter().find(|(key, _)| key.text == path).map(|(_, table)| table);
        let mut moving = MOVING.iter().filter_map(|table| named(table)).filter_map(entries).flatten();
        let is_of_a_body = name.rsplit_once('.').is_some_and(|(of, _)| moving.any(|(key, _)| key.text == of));
        if is_of_a_body && self.variables().is_ok_and(|known| known.contains_key(name)) {
            return Some(named("initial").map_or((tree, vec!["initial", name]), |initial| (initial, vec![name])));
        }
        for (dot, _) in name.rmatch_indices('.') {
            let (path, key) = (&name[..dot], &name[dot + 1..]);
            let tables = TABLES.iter().filter_map(|table| named(table));
            let mut found: Vec<_> = tables.filter_map(|table| at(table, path)).chain(at(tree, path)).collect();
            found.dedup_by_key(|node| node.span.start);
            if let [table] = found.as_slice() {
                return entries(table).map(|_| (*table, key.split('.').collect()));
            }
        }
        let first = name.split('.').next()?;
        (SCENE.iter().any(|key| key.name == first) && named(first).is_none()).then(|| (tree, name.split('.').collect()))
    }
}

/// Where a key goes into an object of JSON, and what is written there.
fn in_json(table: &DocumentNode, keys: &[&str], value: &str) -> Option<(usize, String)> {
    let quoted = |key: &&str| serde_json::to_string(key).ok();
    let (last, path) = keys.split_last()?;
    let open = path.iter().map(quoted).collect::<Option<Vec<_>>>()?;
    let open: String = open.iter().map(|key| format!("{key}: {{")).collect();
    let comma = if entries(table)?.is_empty() { "" } else { ", " };
    Some((table.span.start + 1, format!("{open}{}: {value}{}{comma}", quoted(last)?, "}".repeat(path.len()))))
}

/// Where a key goes into a table of TOML, and what is written there: inside its braces, before the first of its lines, or below its header.
fn in_toml(text: &str, table: &DocumentNode, keys: &[&str], value: &str) -> Option<(usize, String)> {
    let is_bare = |key: &str| key.chars().all(|letter| letter.is_ascii_alphanumeric() || "_-".contains(letter));
    let written = |key: &&str| if is_bare(key) { Some((*key).to_owned()) } else { serde_json::to_string(key).ok() };
    let entry = format!("{} = {value}", keys.iter().map(written).collect::<Option<Vec<_>>>()?.join("."));
    let entries_of_table = entries(table)?;
    if text.as_bytes().get(table.span.start) == Some(&b'{') {
        return Some((
            table.span.start + 1,
            if entries_of_table.is_empty() { format!(" {entry} ") } else { format!(" {entry},") },
        ));
    }
    let line_of = |place: usize| text[..place].rfind('\n').map_or(0, |end| end + 1);
    let lines = entries_of_table.iter().map(|(key, _)| key.span.whole(text).start).map(|key| (line_of(key), key));
    // The line of a key begins with the tables that it names; one that begins with a bracket is the header of another table.
    let first = lines.map(|(line, key)| (line, &text[line..key])).find(|(_, before)| !before.contains(['[', '{', ',']));
    if let Some((line, before)) = first {
        return Some((line, format!("{before}{entry}\n")));
    }
    let header = text.get(table.span.start..table.span.end).filter(|header| header.starts_with('['))?;
    Some((table.span.start + header.len(), format!("\n{entry}")))
}

/// A text with other texts at these places.
fn spliced(text: &str, mut places: Vec<(Span, String)>) -> Result<String, EditError> {
    places.sort_by_key(|(span, _)| span.start);
    if places.windows(2).any(|pair| pair[1].0.start < pair[0].0.end) {
        let twice = "two of the names mean the same value, or one contains the other";
        return Err(EditError::Text(twice.to_owned()));
    }
    let mut changed = text.to_owned();
    for (span, new) in places.into_iter().rev() {
        changed.replace_range(span.start..span.end, &new);
    }
    Ok(changed)
}

/// Where the value of a name is written.
fn written(tree: &DocumentNode, name: &str) -> Result<Span, EditError> {
    let tables = TABLES.iter().filter_map(|table| entries(tree)?.iter().find(|(key, _)| key.text == *table));
    let mut found: Vec<&DocumentNode> = tables.filter_map(|(_, table)| at(table, name)).chain(at(tree, name)).collect();
    // Spans are equal wherever they are.
    found.dedup_by_key(|node| node.span.start);
    Err(EditError::Text(match found.as_slice() {
        [node] => match own_value(node) {
            Some(value) => return Ok(value.span),
            None => {
                let (kind, key) = (node.kind.name(), first_key(node));
                format!("`{name}` is {kind}; name one of its keys, such as `{name}.{key}`")
            }
        },
        [] => {
            let known = suggest::known(name, names(tree).iter().map(String::as_str));
            return Err(EditError::Unknown(format!("the scene has no `{name}`; {known}")));
        }
        _ => format!("`{name}` occurs in several tables of the scene: write the name of the table before it"),
    }))
}

/// What a path leads to; keys may have dots of their own.
fn at<'n>(node: &'n DocumentNode, path: &str) -> Option<&'n DocumentNode> {
    entries(node)?.iter().find_map(|(key, value)| {
        let rest = path.strip_prefix(key.text.as_str())?;
        if rest.is_empty() { Some(value) } else { at(value, rest.strip_prefix('.')?) }
    })
}

fn entries(node: &DocumentNode) -> Option<&[(crate::diagnostic::Text, DocumentNode)]> {
    match &node.kind {
        Content::Table(entries) => Some(entries),
        Content::Array(_)
        | Content::Text(_)
        | Content::Number(_)
        | Content::Boolean(_)
        | Content::Date
        | Content::Null => None,
    }
}

/// A value, or that of a table which has its value beside other keys.
fn own_value(node: &DocumentNode) -> Option<&DocumentNode> {
    match entries(node) {
        Some(entries) => ITSELF
            .iter()
            .find_map(|key_name| entries.iter().find(|(key, _)| key.text == *key_name))
            .map(|(_, value)| value),
        None => Some(node),
    }
}

fn first_key(node: &DocumentNode) -> &str {
    entries(node).and_then(<[_]>::first).map_or("", |(key, _)| key.text.as_str())
}

/// All names that can be changed.
fn names(tree: &DocumentNode) -> Vec<String> {
    let mut all = Vec::new();
    for (table, entry) in entries(tree).unwrap_or_default() {
        for (name, value) in entries(entry).unwrap_or_default() {
            let names = if TABLES.contains(&table.text.as_str()) {
                name.text.clone()
            } else {
                format!("{}.{}", table.text, name.text)
            };
            match own_value(value) {
                Some(_) => all.push(names),
                None => all
                    .extend(entries(value).unwrap_or_default().iter().map(|(key, _)| format!("{names}.{}", key.text))),
            }
        }
    }
    all
}
