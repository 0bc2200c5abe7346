//! Edits of a mechanism in its text: what a tool of the drawing page does.

use serde::Deserialize;

use super::super::document::{Content, DocumentNode};
use super::text::{EntryPlace, SceneText, at, quoted};
use super::{EditError, spliced};
use crate::diagnostic::Span;
use crate::scene::Scene;
use crate::scene::decode::is_json;
use std::path::Path;

/// An edit of a scene's text; values are written in TOML, and become JSON where the scene is.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "edit", rename_all = "snake_case")]
pub enum Edit {
    /// Other texts at these places, which count bytes of the text as it is before all edits.
    Write {
        /// Each place with the text that it gets.
        places: Vec<(usize, usize, String)>,
    },
    /// A key with its value, such as an initial value.
    Set {
        /// Its table and its name.
        path: Vec<String>,
        /// The value.
        value: String,
    },
    /// A point of a body or of the ground.
    Point {
        /// The body, or `ground`.
        owner: String,
        /// The name of the point.
        name: String,
        /// Its coordinates.
        at: String,
    },
    /// A table with its keys.
    Add {
        /// Its path, such as `bodies` and a name.
        path: Vec<String>,
        /// Its keys with their values.
        keys: Vec<(String, String)>,
    },
    /// One more output, unless it is there.
    Output {
        /// The variable.
        name: String,
    },
    /// An element is removed, with its initial values and outputs, and with the joints, drivers and loads that name it.
    Remove {
        /// The element.
        name: String,
        /// The tables in which it may be.
        tables: Vec<String>,
    },
    /// A point is removed, with what names it; with its body, if the shape or the outline of that needs the point or the text does not write it.
    RemovePoint {
        /// The body, or `ground`.
        owner: String,
        /// The name of the point.
        name: String,
    },
    /// A motor begins elsewhere: the driver of a joint whose law begins with an angle.
    Turn {
        /// The joint.
        joint: String,
        /// What is added to the angle \[rad\].
        by: f64,
    },
}

/// The tables whose entries name other elements.
const USERS: [&str; 3] = ["joints", "drivers", "loads"];

/// A scene's text after edits, one after the other.
///
/// # Errors
/// An edit that does not fit the text.
pub fn edited(text: &str, edits: &[Edit]) -> Result<String, EditError> {
    let mut scene = SceneText::new(text, false);
    for edit in edits {
        scene.apply(edit)?;
    }
    Ok(scene.text)
}

impl Scene {
    /// Where the text of the scene's own file gets more entries of a table, such as `initial`.
    ///
    /// # Errors
    /// A text that has none, or writes the table in no way that can be added to.
    pub fn gap(&self, table: &str) -> Result<EntryPlace, EditError> {
        let (name, text) = self.source.files().next().unwrap_or_default();
        let scene = SceneText::new(text, is_json(Path::new(name)));
        scene.gap(&scene.layout()?, &path(&[table]))
    }
}

impl SceneText {
    fn apply(&mut self, edit: &Edit) -> Result<(), EditError> {
        match edit {
            Edit::Write { places } => {
                let is_good = |start: usize, end: usize| self.text.get(start..end).is_some();
                if places.iter().any(|&(start, end, _)| !is_good(start, end)) {
                    return Err(EditError::Text("a place is not in the text".to_owned()));
                }
                let places = places.iter().map(|(start, end, new)| (Span::new(*start, *end), new.clone()));
                self.text = spliced(&self.text, places.collect())?;
                Ok(())
            }
            Edit::Set { path, value } => self.set(path, value),
            Edit::Point { owner, name, at } => self.point(owner, name, at),
            Edit::Add { path, keys } => self.add(path, keys),
            Edit::Output { name } => self.output(name),
            Edit::Remove { name, tables } => self.remove_element(name, tables),
            Edit::RemovePoint { owner, name } => self.remove_point(owner, name),
            Edit::Turn { joint, by } => self.turn(joint, *by),
        }
    }

    fn point(&mut self, owner: &str, name: &str, at: &str) -> Result<(), EditError> {
        if owner == "ground" {
            return self.set(&path(&["ground", "points", name]), at);
        }
        if !self.layout()?.has(&path(&["bodies", owner])) {
            let told = format!("`{owner}` has no table [bodies.{owner}] in this text: add the point there yourself");
            return Err(EditError::Text(told));
        }
        self.set(&path(&["bodies", owner, "points", name]), at)
    }

    fn output(&mut self, name: &str) -> Result<(), EditError> {
        let (list, tree) = (path(&["outputs", "variables"]), self.tree()?);
        match at(&tree, &list) {
            Some(known) if texts(known).contains(&name) => Ok(()),
            _ => self.append(&list, &quoted(name)),
        }
    }

    fn remove_element(&mut self, name: &str, tables: &[String]) -> Result<(), EditError> {
        for table in tables {
            self.remove(&path(&[table, name]))?;
        }
        self.remove_values(name)?;
        self.remove_pairs(name)?;
        self.remove_users(name)
    }

    /// Removes the pairs of `[clearance]` that name a body.
    fn remove_pairs(&mut self, name: &str) -> Result<(), EditError> {
        let (list, tree) = (path(&["clearance", "pairs"]), self.tree()?);
        let Some(Content::Array(pairs)) = at(&tree, &list).map(|node| &node.kind) else { return Ok(()) };
        let pairs: Vec<Vec<&str>> = pairs.iter().map(texts).collect();
        let left: Vec<&Vec<&str>> = pairs.iter().filter(|pair| !pair.contains(&name)).collect();
        if left.len() == pairs.len() {
            return Ok(());
        }
        let pair =
            |pair: &Vec<&str>| format!("[{}]", pair.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(", "));
        let text = left.into_iter().map(pair).collect::<Vec<_>>().join(", ");
        self.set(&list, &format!("[{text}]"))
    }

    /// Removes initial values and outputs of an element or a point.
    fn remove_values(&mut self, name: &str) -> Result<(), EditError> {
        let begin = format!("{name}.");
        let tree = self.tree()?;
        for key in at(&tree, &path(&["initial"])).map(keys).unwrap_or_default() {
            if key.starts_with(&begin) {
                self.remove(&path(&["initial", key]))?;
            }
        }
        self.remove_items(&path(&["outputs", "variables"]), |variable| variable.starts_with(&begin))
    }

    /// Removes the joints, drivers and loads that name an element or a point, and what names these.
    fn remove_users(&mut self, name: &str) -> Result<(), EditError> {
        loop {
            let tree = self.tree()?;
            let entries = USERS.iter().flat_map(|table| {
                let all = at(&tree, &path(&[table])).map(keys).unwrap_or_default();
                all.into_iter().map(|element| path(&[table, element]))
            });
            let names =
                |text: &&str| text.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
            let user =
                entries.into_iter().find(|entry| at(&tree, entry).is_some_and(|node| texts(node).iter().any(names)));
            let Some(user) = user else { return Ok(()) };
            self.remove(&user)?;
            let [_, gone] = &user[..] else { return Ok(()) };
            self.remove_values(gone)?;
            self.remove_users(gone)?;
        }
    }

    fn remove_point(&mut self, owner: &str, name: &str) -> Result<(), EditError> {
        let point = format!("{owner}.{name}");
        if owner == "ground" {
            let outline = path(&["ground", "outline"]);
            if at(&self.tree()?, &outline).map(texts).unwrap_or_default().contains(&name) {
                self.remove(&outline)?;
            }
            self.remove(&path(&["ground", "points", name]))?;
            return self.remove_users(&point);
        }
        let tree = self.tree()?;
        let used = |key: &str| at(&tree, &path(&["bodies", owner, key])).map(texts).unwrap_or_default();
        let used = [used("shape"), used("outline")].concat();
        let point_path = path(&["bodies", owner, "points", name]);
        if used.contains(&name) || at(&tree, &point_path).is_none() {
            return self.remove_element(owner, &path(&["bodies"]));
        }
        self.remove(&point_path)?;
        self.remove_values(&point)?;
        self.remove_users(&point)
    }

    fn turn(&mut self, joint: &str, by: f64) -> Result<(), EditError> {
        let tree = self.tree()?;
        let drivers = at(&tree, &path(&["drivers"])).map(keys).unwrap_or_default();
        let is_own = |driver: &&str| {
            let joint_node = at(&tree, &path(&["drivers", driver, "joint"]));
            matches!(joint_node.map(|node| &node.kind), Some(Content::Text(text)) if text == joint)
        };
        let Some(driver) = drivers.into_iter().find(is_own) else { return Ok(()) };
        let law = path(&["drivers", driver, "angle"]);
        let Some(Content::Text(text)) = at(&tree, &law).map(|node| &node.kind) else { return Ok(()) };
        match turned(text, by) {
            Some(new) => self.set(&law, &quoted(&new)),
            None => Ok(()),
        }
    }
}

/// A law that begins with a number, in degrees or in radians, to which something is added; with this much more of it.
fn turned(law: &str, by: f64) -> Option<String> {
    let of_number =
        |(index, letter): (usize, char)| letter.is_ascii_digit() || letter == '.' || (index == 0 && letter == '-');
    let digits = law.char_indices().find(|&character| !of_number(character)).map_or(law.len(), |(index, _)| index);
    let (number, rest) = law.split_at(digits);
    let (unit, rest) = rest.strip_prefix("[deg]").map_or(("", rest), |rest| ("[deg]", rest));
    if !rest.trim_start().starts_with(['+', '-']) {
        return None;
    }
    let by = if unit.is_empty() { by } else { by.to_degrees() };
    Some(format!("{}{unit}{rest}", drawn(number.parse::<f64>().ok()? + by)))
}

/// Digits of what is drawn: configurations are known to some more. What is a short number but for rounding is that number.
fn drawn(value: f64) -> f64 {
    let digits = |count: usize| format!("{value:.count$e}").parse().unwrap_or(value);
    let short: f64 = digits(5);
    if (short - value).abs() <= 2e-9 * value.abs() { short } else { digits(9) }
}

fn path(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn keys(node: &DocumentNode) -> Vec<&str> {
    match &node.kind {
        Content::Table(entries) => entries.iter().map(|(key, _)| key.text.as_str()).collect(),
        _ => Vec::new(),
    }
}

/// All texts in a value.
fn texts(node: &DocumentNode) -> Vec<&str> {
    match &node.kind {
        Content::Table(entries) => entries.iter().flat_map(|(_, value)| texts(value)).collect(),
        Content::Array(items) => items.iter().flat_map(texts).collect(),
        Content::Text(text) => vec![text],
        Content::Number(_) | Content::Boolean(_) | Content::Date | Content::Null => Vec::new(),
    }
}
