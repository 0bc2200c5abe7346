//! Document to [`Scene`]: every key is known, every value has the right type. Names are left to `resolve`.

mod elements;
mod fields;
mod settings;

use std::path::Path;

pub(crate) use self::fields::{Fields, written};
use super::document::{self, Content, DocumentNode};
use super::key::names;
use super::model::Scene;
use super::part::Part;
use super::tables::SCENE;
use crate::diagnostic::fault::{Fault, Faults, Sink};
use crate::diagnostic::span::{Source, Span, Text};
use crate::files;
use crate::model::{CREDITS, Dimension};

impl Scene {
    /// The largest scene file \[bytes\]: some hundred thousand bodies.
    pub const LARGEST: u64 = 64 << 20;

    /// Reads a scene file: JSON if it begins with `{` or is called `.json`, else TOML.
    ///
    /// # Errors
    /// A file that cannot be read, and everything that is wrong with the scene's form.
    pub fn read(path: impl AsRef<Path>) -> Result<Scene, Faults> {
        let path = path.as_ref();
        let bytes = files::read(path, Self::LARGEST).map_err(|error| {
            let name = path.display();
            unreadable(
                path,
                Fault::new("scene::unreadable", format!("`{name}` cannot be read: {error}"), Span::default()),
            )
        })?;
        Scene::from_bytes(path, bytes)
    }

    /// Reads a scene from the content of a file.
    ///
    /// # Errors
    /// Everything that is wrong with its form; names and units too, if there is such a fault.
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Scene, Faults> {
        let text = text(path, bytes).map_err(|fault| unreadable(path, fault))?;
        Scene::from_source(Source::new(path.display().to_string(), text), is_json(path))
    }

    /// Reads a scene from files that have been read already, its own first, each with its path and its text, as [`Source::files`] gives them. What is among
    /// them is not looked for on the disk.
    ///
    /// # Errors
    /// Everything that is wrong with its form; names and units too, if there is such a fault.
    pub fn from_files(files: &[(String, String)]) -> Result<Scene, Faults> {
        let (name, text) = files.first().map(|(name, text)| (name.as_str(), text.as_str())).unwrap_or_default();
        let mut source = Source::new(name, text);
        for (name, text) in files.iter().skip(1) {
            source.append(name, text);
        }
        Scene::from_source(source, is_json(Path::new(name)))
    }

    /// Reads a scene from a text in TOML, or in JSON if it begins with `{`.
    ///
    /// # Errors
    /// Everything that is wrong with its form; names and units too, if there is such a fault.
    pub fn from_toml(text: &str) -> Result<Scene, Faults> {
        Scene::from_source(Source::new("", text), false)
    }

    /// Reads a scene from a text in JSON.
    ///
    /// # Errors
    /// Everything that is wrong with its form; names and units too, if there is such a fault.
    pub fn from_json(text: &str) -> Result<Scene, Faults> {
        Scene::from_source(Source::new("", text), true)
    }

    /// A scene as it is written, without its parts; none if its form cannot be trusted. `start` is where its text begins in the source. What is wrong
    /// goes to `faults`. A part needs no name.
    pub(crate) fn decode(text: &str, json: bool, start: usize, is_part: bool, faults: &mut Sink) -> Option<Scene> {
        let mut of_form = Sink::default();
        let begin = start + byte_order_mark(text);
        let document = read(text.strip_prefix(MARK).unwrap_or(text), json, &mut of_form);
        faults.take(of_form, begin);
        let mut document = document?;
        if begin > 0 {
            document.shift(begin);
        }
        let mut decoder = Decoder { faults: std::mem::take(faults), is_part, ..Decoder::default() };
        let mut scene = decoder.scene(&document);
        scene.broken = decoder.broken;
        *faults = decoder.faults;
        Some(scene)
    }
}

/// Reads TOML, or JSON where that is said or the text begins with `{`.
fn read(text: &str, json: bool, faults: &mut Sink) -> Option<DocumentNode> {
    if json || is_json_text(text) {
        document::from_json(text, faults)
    } else {
        document::from_toml(text, &names(SCENE), faults)
    }
}

/// The tree of a text, with its places in it; none if its form cannot be trusted.
pub(crate) fn tree(text: &str, json: bool) -> Option<DocumentNode> {
    let begin = byte_order_mark(text);
    let mut tree = read(&text[begin..], json, &mut Sink::default())?;
    tree.shift(begin);
    Some(tree)
}

/// What some editors begin a file with (byte order mark).
const MARK: char = '\u{feff}';

/// The length of the byte order mark that a text begins with.
pub(crate) fn byte_order_mark(text: &str) -> usize {
    if text.starts_with(MARK) { MARK.len_utf8() } else { 0 }
}

/// Does a text read as JSON: does it begin with `{`?
pub(crate) fn is_json_text(text: &str) -> bool {
    text.trim_start().starts_with('{')
}

/// Is it called a file in JSON?
pub(crate) fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
}

/// A fault of a file that has no text to show.
fn unreadable(path: &Path, fault: Fault) -> Faults {
    Faults::new(Source::new(path.display().to_string(), ""), vec![fault])
}

/// What to do with a text in another encoding.
const AS_UTF8: &str = "save it as UTF-8: editors ask for the encoding under \"Save as\" or in their status line; in PowerShell: `Set-Content -Encoding utf8`";

/// Is it text in UTF-16: by its byte order mark, or as every other byte of what is ASCII is zero?
fn is_utf16(bytes: &[u8]) -> bool {
    /// So many characters tell it from other files.
    const ENOUGH: usize = 16;
    let begin = bytes.get(..2 * ENOUGH).unwrap_or_default();
    let every_other = |first: usize| !begin.is_empty() && begin.iter().skip(first).step_by(2).all(|byte| *byte == 0);
    bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) || every_other(0) != every_other(1)
}

/// The text of a scene file, without a byte order mark.
pub(crate) fn text(path: &Path, bytes: Vec<u8>) -> Result<String, Fault> {
    let name = path.display();
    let fault = |code, message| Fault::new(code, message, Span::default());
    if bytes.starts_with(b"PK\x03\x04") {
        let message = format!("`{name}` is an archive, not a scene");
        return Err(fault("scene::archive", message).help("`cotree info` shows what is in an FMU, `--scene` its scene"));
    }
    if is_utf16(&bytes) {
        let message = format!("`{name}` is text in UTF-16, not in UTF-8");
        return Err(fault("scene::not_utf8", message).help(AS_UTF8));
    }
    if bytes.contains(&0) {
        return Err(fault("scene::not_text", format!("`{name}` is not a text, so it is not a scene")));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let before = String::from_utf8_lossy(&error.as_bytes()[..at]);
        let (line, column) =
            (before.matches('\n').count() + 1, before.chars().rev().take_while(|c| *c != '\n').count() + 1);
        let mut message = format!("`{name}` is not UTF-8 text: line {line}, column {column} has invalid bytes");
        // Latin-1 and Windows-1252 agree from here on, and there they have letters.
        if let Some(&byte) = error.as_bytes().get(at).filter(|byte| **byte >= 0xa0) {
            message += &format!("; in Latin-1 (Windows-1252) it is `{}`", char::from(byte));
        }
        fault("scene::not_utf8", message).help(AS_UTF8)
    })?;
    Ok(match text.strip_prefix(MARK) {
        Some(rest) => rest.to_owned(),
        None => text,
    })
}

/// Reads the parts of a scene from a document.
#[derive(Default)]
struct Decoder {
    faults: Sink,
    /// Names of elements that could not be read.
    broken: Vec<String>,
    /// Is the scene a part of another?
    is_part: bool,
}

impl Decoder {
    fn scene(&mut self, document: &DocumentNode) -> Scene {
        let mut scene = Scene::new("");
        let Some(top) = Fields::open(document, "the scene", Span::new(0, 0), &names(SCENE), &mut self.faults) else {
            return scene;
        };
        self.broken.extend(top.strange_names().map(str::to_owned));
        self.format(&top);
        match top.get("name") {
            Some(node) => {
                scene.name = self.faults.text(node, "`name`").unwrap_or_else(|| Text::new("unreadable", node.span))
            }
            None if self.is_part => {}
            None => {
                scene.name = Text::from("missing");
                self.faults.push(
                    Fault::new("scene::missing_key", "the scene has no name", Span::default())
                        .help("begin the file with `name = \"my_mechanism\"`, the name of the FMU"),
                );
            }
        }
        scene.description = top.get("description").and_then(|node| self.faults.text(node, "`description`"));
        for key in CREDITS {
            let text = top.get(key).and_then(|node| self.faults.text(node, &format!("`{key}`")));
            scene.credits.extend(text.map(|text| (key, text.text)));
        }
        scene.dimension = top.get("dimension").map_or(Dimension::Two, |node| self.dimension(node));
        scene.gravity = top.get("gravity").and_then(|node| self.faults.vector(node, "`gravity`"));
        scene.parameters = self.section(&top, "parameters", "parameter", Decoder::parameter);
        scene.inputs = self.section(&top, "inputs", "input", Decoder::input);
        scene.states = self.section(&top, "states", "state", Decoder::state);
        scene.sampled = self.samplers(&top);
        scene.events = self.section(&top, "events", "event", Decoder::event);
        scene.signals = self.section(&top, "signals", "signal", Decoder::signal);
        (scene.ground, scene.ground_outlines) = self.ground(&top);
        scene.bodies = self.parts(&top, "bodies");
        scene.joints = self.parts(&top, "joints");
        scene.drivers = self.parts(&top, "drivers");
        scene.loads = self.parts(&top, "loads");
        scene.uses = self.section(&top, "parts", "part", Decoder::part);
        self.settings(&top, &mut scene);
        scene
    }

    fn format(&mut self, top: &Fields<'_>) {
        let Some(node) = top.get("format") else {
            return;
        };
        if !matches!(node.kind, Content::Number(1.0)) {
            self.faults.push(
                Fault::new("scene::format", "this version of cotree reads format 1", node.span)
                    .label("another format")
                    .help("write `format = 1`"),
            );
        }
    }

    fn dimension(&mut self, node: &DocumentNode) -> Dimension {
        match node.kind {
            Content::Number(1.0) => Dimension::One,
            Content::Number(2.0) => Dimension::Two,
            _ => {
                self.faults.push(
                    Fault::new("scene::wrong_value", "`dimension` is neither 1 nor 2", node.span)
                        .label("1 or 2")
                        .help("write 2 for a planar mechanism (the default), or 1 for masses on a line"),
                );
                Dimension::Two
            }
        }
    }

    /// The named tables of a section whose keys their components know.
    fn parts(&mut self, top: &Fields<'_>, key: &'static str) -> Vec<Part> {
        let part = |(name, node): &(Text, DocumentNode)| Part::new(name.clone(), node.clone());
        self.entries(top, key).into_iter().map(part).collect()
    }

    fn entries<'n>(&mut self, top: &Fields<'n>, key: &str) -> Vec<&'n (Text, DocumentNode)> {
        let tables = top.all(key).filter_map(|(_, node)| self.faults.entries(node, &format!("`{key}`")));
        tables.flatten().collect()
    }

    /// The named tables of a section; what cannot be read is noted as broken.
    fn section<T>(
        &mut self,
        top: &Fields<'_>,
        key: &'static str,
        what: &str,
        read: fn(&mut Decoder, &Text, &DocumentNode, &str) -> Option<T>,
    ) -> Vec<T> {
        let mut elements = Vec::new();
        for (name, node) in self.entries(top, key) {
            let owner = format!("{what} `{}`", name.text);
            match read(self, name, node, &owner) {
                Some(element) => elements.push(element),
                None => self.broken.push(name.text.clone()),
            }
        }
        elements
    }
}
