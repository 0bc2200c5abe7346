//! The same scene with other values, and with keys that it does not write yet: all else in its text stays as it is, comments too.

use super::decode::{is_json, tree};
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
    #[error("the scene has no `{name}`; {known}")]
    Unknown {
        /// The name.
        name: String,
        /// What may have been meant.
        known: String,
    },
    /// The scene writes what is named in several places.
    #[error("`{name}` occurs in several tables of the scene: write the name of the table before it")]
    Ambiguous {
        /// The name.
        name: String,
    },
    /// Two names are of one place.
    #[error("two of the names mean the same value, or one contains the other")]
    Twice,
    /// What is wrong with the scene once it is changed.
    #[error(transparent)]
    Scene(#[from] Faults),
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
            return Err(EditError::NoText);
        };
        let json = is_json(Path::new(name)) || text.trim_start().starts_with('{');
        let tree = tree(text, json).ok_or(EditError::Unreadable)?;
        let (mut places, mut new) = (Vec::new(), Vec::new());
        for (name, value) in changes {
            match written(&tree, name) {
                Ok(span) => places.push((span.whole(text), value.clone())),
                Err(unknown @ EditError::Unknown { .. }) => new.push((name, value, unknown)),
                Err(error) => return Err(error),
            }
        }
        *text = spliced(text, places).ok_or(EditError::Twice)?;
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
        spliced(text, vec![(Span::new(at, at), entry)])
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
            found.dedup_by_key(|node| node.span);
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
    let is_bare = |key: &str| key.chars().all(|own| own.is_ascii_alphanumeric() || "_-".contains(own));
    let written = |key: &&str| if is_bare(key) { Some((*key).to_owned()) } else { serde_json::to_string(key).ok() };
    let entry = format!("{} = {value}", keys.iter().map(written).collect::<Option<Vec<_>>>()?.join("."));
    let own = entries(table)?;
    if text.as_bytes().get(table.span.start) == Some(&b'{') {
        return Some((table.span.start + 1, if own.is_empty() { format!(" {entry} ") } else { format!(" {entry},") }));
    }
    let line_of = |place: usize| text[..place].rfind('\n').map_or(0, |end| end + 1);
    let lines = own.iter().map(|(key, _)| key.span.whole(text).start).map(|key| (line_of(key), key));
    // The line of a key begins with the tables that it names; one that begins with a bracket is the header of another table.
    let first = lines.map(|(line, key)| (line, &text[line..key])).find(|(_, before)| !before.contains(['[', '{', ',']));
    if let Some((line, before)) = first {
        return Some((line, format!("{before}{entry}\n")));
    }
    let header = text.get(table.span.start..table.span.end).filter(|header| header.starts_with('['))?;
    Some((table.span.start + header.len(), format!("\n{entry}")))
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
    fn keys_that_are_not_written_are_added_to_their_tables() {
        for (name, value, old, new) in [
            ("hinge.damping", "0.5", "type = \"revolute\"", "damping = 0.5\ntype = \"revolute\""),
            ("experiment.step", "'1 ms'", "stop = ", "step = '1 ms'\nstop = "),
            ("hinge.friction.coulomb", "1", "type = \"revolute\"", "friction.coulomb = 1\ntype = \"revolute\""),
            ("length.max", "\"3 m\"", "{ value", "{ max = \"3 m\", value"),
            ("bob.points.low", "[0, 0]", "{ top", "{ low = [0, 0], top"),
            ("parameters.mass", "2", "length = {", "mass = 2\nlength = {"),
            ("bob.omega", "0.2", "\"bob.angle\" = ", "\"bob.omega\" = 0.2\n\"bob.angle\" = "),
            ("solver.safety", "0.5", "name = ", "solver.safety = 0.5\nname = "),
            ("description", "\"swings\"", "name = ", "description = \"swings\"\nname = "),
        ] {
            let tree = tree(SCENE, false).unwrap();
            let scene = Scene::from_toml(SCENE).unwrap();
            assert!(written(&tree, name).is_err(), "{name}");
            assert_eq!(scene.with_key(SCENE, false, (name, value)).unwrap(), SCENE.replacen(old, new, 1), "{name}");
        }
        let scene = Scene::from_toml(SCENE).unwrap();
        let several = [("solver.method", "'taylor'"), ("solver.bench", "1")];
        let text = several.iter().fold(SCENE.to_owned(), |text, own| scene.with_key(&text, false, *own).unwrap());
        assert!(text.starts_with("solver.bench = 1\nsolver.method = 'taylor'\nname"), "{text}");
        let empty = format!("{SCENE}[solver]\n");
        let added = scene.with_key(&empty, false, several[0]).unwrap();
        assert!(added.ends_with("[solver]\nmethod = 'taylor'\n"), "{added}");
        let json = r#"{"name": "bar", "parameters": {"length": 1}}"#;
        let added = scene.with_key(json, true, ("solver.method", "\"taylor\"")).unwrap();
        assert_eq!(added, r#"{"solver": {"method": "taylor"}, "name": "bar", "parameters": {"length": 1}}"#);
        let added = scene.with_key(json, true, ("parameters.mass", "2")).unwrap();
        assert_eq!(added, r#"{"name": "bar", "parameters": {"mass": 2, "length": 1}}"#);
    }

    #[test]
    fn what_cannot_be_changed_is_refused() {
        for (name, value, told) in [
            ("bob.mas", "3", "did you mean `mass`"),
            ("lenght", "3", "did you mean `length`"),
            ("rod.mass", "3", "does not write `rod.mass`"),
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
