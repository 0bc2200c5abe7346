//! The same scene with other values: all else in its text stays as it is, comments too.

use super::decode::{is_json, tree};
use super::document::{Content, DocumentNode};
use super::{Faults, Scene};
use crate::diagnostic::{Span, suggest};
use std::path::Path;

/// Tables whose entries are named without them.
const TABLES: [&str; 9] =
    ["parameters", "inputs", "states", "initial", "signals", "bodies", "joints", "drivers", "loads"];
/// The key of an entry that is called by the entry's name.
const ITSELF: [&str; 3] = ["value", "start", "guess"];

/// Why a scene cannot be changed.
#[derive(Debug, thiserror::Error)]
pub enum EditError {
    /// The scene was not read from a text.
    #[error("the scene has no text")]
    NoText,
    /// The text is neither TOML nor JSON.
    #[error("the text of the scene cannot be read")]
    Unreadable,
    /// What is named has keys, but no value of its own.
    #[error("`{name}` is {kind}; name one of its keys, such as `{name}.{key}`")]
    NoValue {
        /// The name.
        name: String,
        /// What it is, such as "a table".
        kind: &'static str,
        /// Its first key.
        key: String,
    },
    /// The scene does not write what is named.
    #[error("the scene does not write `{name}`; {known}")]
    Unknown {
        /// The name.
        name: String,
        /// What may have been meant.
        known: String,
    },
    /// The scene writes what is named in several places.
    #[error("the scene writes `{name}` in several places: begin with the table that is meant")]
    Ambiguous {
        /// The name.
        name: String,
    },
    /// Two names are of one place.
    #[error("two of the names are the same value, or one is within another")]
    Twice,
    /// What is wrong with the scene once it is changed.
    #[error(transparent)]
    Scene(#[from] Faults),
}

impl Scene {
    /// The scene with other values: of a parameter, an input, a state, an initial value or a signal by its name, such as `rod_length`; of a key of a body, joint, driver or load such
    /// as `rod.mass`; of any other key by its whole path, such as `experiment.stop`. Values are written as in TOML and JSON: a number, a text in quotes, a list.
    ///
    /// # Errors
    /// A name that the scene does not write, or not in one place; what is wrong with the changed scene.
    pub fn replaced(&self, changes: &[(String, String)]) -> Result<Scene, EditError> {
        let mut files: Vec<(String, String)> =
            self.source.files().map(|(name, text)| (name.to_owned(), text.to_owned())).collect();
        let Some((name, text)) = files.first_mut() else {
            return Err(EditError::NoText);
        };
        let tree = tree(text, is_json(Path::new(name)));
        let tree = tree.ok_or(EditError::Unreadable)?;
        let mut places = Vec::new();
        for (name, value) in changes {
            let span = written(&tree, name)?;
            places.push((span.whole(text), value.clone()));
        }
        *text = spliced(text, places).ok_or(EditError::Twice)?;
        Ok(Scene::from_files(&files)?)
    }
}

/// A text with other texts at these places; none if two of them overlap.
pub fn spliced(text: &str, mut places: Vec<(Span, String)>) -> Option<String> {
    places.sort_by_key(|(span, _)| span.start);
    if places.windows(2).any(|pair| pair[1].0.start < pair[0].0.end) {
        return None;
    }
    let mut changed = text.to_owned();
    for (span, new) in places.into_iter().rev() {
        changed.replace_range(span.start..span.end, &new);
    }
    Some(changed)
}

/// Where the value of a name is written.
fn written(tree: &DocumentNode, name: &str) -> Result<Span, EditError> {
    let tables = TABLES.iter().filter_map(|table| entries(tree)?.iter().find(|(key, _)| key.text == *table));
    let mut found: Vec<&DocumentNode> = tables.filter_map(|(_, table)| at(table, name)).chain(at(tree, name)).collect();
    found.dedup_by_key(|node| node.span);
    let name = name.to_owned();
    match found.as_slice() {
        [node] => match own_value(node) {
            Some(value) => Ok(value.span),
            None => Err(EditError::NoValue { name, kind: node.kind.name(), key: first_key(node).to_owned() }),
        },
        [] => {
            let known = suggest::known(&name, names(tree).iter().map(String::as_str));
            Err(EditError::Unknown { name, known })
        }
        _ => Err(EditError::Ambiguous { name }),
    }
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
        Some(entries) => {
            ITSELF.iter().find_map(|own| entries.iter().find(|(key, _)| key.text == *own)).map(|(_, value)| value)
        }
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
            let own = if TABLES.contains(&table.text.as_str()) {
                name.text.clone()
            } else {
                format!("{}.{}", table.text, name.text)
            };
            match own_value(value) {
                Some(_) => all.push(own),
                None => {
                    all.extend(entries(value).unwrap_or_default().iter().map(|(key, _)| format!("{own}.{}", key.text)))
                }
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "name = \"bar\"\ngravity = [0, -9.81] # down\n[parameters]\nlength = { value = \"1 m\", min = \"1 mm\" }\n[bodies.bob]\nmass = 2.0 # heavy\ninertia = 0.1\npoints = { top = [0.0, \"length\"] }\n[joints.hinge]\ntype = \"revolute\"\nbetween = [\"ground\", \"bob.top\"]\n[initial]\n\"bob.angle\" = { guess = 0.1 }\n[experiment]\nstop = '2 s'\n";

    fn replaced(name: &str, value: &str) -> Result<String, EditError> {
        let scene = Scene::from_toml(SCENE).unwrap();
        let replaced = scene.replaced(&[(name.to_owned(), value.to_owned())]);
        replaced.map(|scene| scene.source.files().next().unwrap().1.to_owned())
    }

    #[test]
    fn one_value_changes_and_nothing_else() {
        for (name, value, old, new) in [
            ("length", "\"2 m\"", "\"1 m\"", "\"2 m\""),
            ("length.min", "0.5", "\"1 mm\"", "0.5"),
            ("bob.mass", "3.5", "2.0", "3.5"),
            ("bodies.bob.mass", "\"4 kg\"", "2.0", "\"4 kg\""),
            ("bob.points.top", "[0, 1]", "[0.0, \"length\"]", "[0, 1]"),
            ("bob.angle", "0.2", "0.1 }", "0.2 }"),
            ("experiment.stop", "3", "'2 s'", "3"),
            ("gravity", "[0, -1.62]", "[0, -9.81]", "[0, -1.62]"),
        ] {
            assert_eq!(replaced(name, value).unwrap(), SCENE.replacen(old, new, 1), "{name}");
        }
    }

    #[test]
    fn what_cannot_be_changed_is_refused() {
        for (name, value, told) in [
            ("bob.mas", "3", "did you mean `bob.mass`"),
            ("bob", "3", "`bob` is a table; name one of its keys, such as `bob.mass`"),
            ("bob.mass", "3 kg", "cannot be read"),
        ] {
            let error = replaced(name, value).unwrap_err().to_string();
            assert!(error.contains(told), "{name}: {error}");
        }
        let scene = Scene::from_toml(SCENE).unwrap();
        let twice =
            scene.replaced(&[("bob.mass", "1"), ("bodies.bob.mass", "2")].map(|(a, b)| (a.to_owned(), b.to_owned())));
        assert!(twice.unwrap_err().to_string().contains("the same value"));
    }
}
