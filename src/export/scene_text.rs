//! The files that a scene is made of, inside an FMU: where they are, and how they name each other there.

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

use crate::diagnostic::Source;

/// The text of a scene file.
#[derive(Clone, Copy, Debug)]
pub struct SceneText<'a> {
    /// `toml` or `json`.
    pub extension: &'a str,
    /// The files that it is made of, with their texts, its own first.
    pub source: &'a Source,
}

/// A file of a scene.
struct SceneFile {
    /// Where its author has it, without detours.
    written: PathBuf,
    /// Where the FMU has it.
    inside: PathBuf,
}

impl SceneText<'_> {
    /// Its files with their names in the FMU: where they are relative to the scene, so that it can be run from there. What lies elsewhere gets a place of its
    /// own, and who names it finds it there: no path of the author's stays in their texts.
    pub(super) fn files(self) -> Vec<(String, String)> {
        let places = self.places();
        let texts = self.source.files().map(|(_, text)| text);
        let renamed =
            places.iter().zip(texts).map(|(place, text)| (spelled(&place.inside), references(text, place, &places)));
        renamed.collect()
    }

    fn places(self) -> Vec<SceneFile> {
        let folder = normal(Path::new(&self.source.name)).parent().map(Path::to_owned).unwrap_or_default();
        let mut taken = HashSet::from([PathBuf::from(cotree_fmu::PROGRAM_FILE)]);
        let mut places = Vec::new();
        for (index, (path, _)) in self.source.files().enumerate() {
            let written = normal(Path::new(path));
            let below = written.strip_prefix(&folder).ok().filter(|below| is_below(below));
            let inside = match below {
                _ if index == 0 => format!("resources/scene.{}", self.extension).into(),
                Some(below) if !taken.contains(&Path::new("resources").join(below)) => {
                    Path::new("resources").join(below)
                }
                _ => Path::new("resources/elsewhere")
                    .join(index.to_string())
                    .join(written.file_name().unwrap_or_default()),
            };
            taken.insert(inside.clone());
            places.push(SceneFile { written, inside });
        }
        places
    }
}

/// Is it a way down, in letters that every archive has?
fn is_below(path: &Path) -> bool {
    path.to_str().is_some() && path.components().all(|part| matches!(part, Component::Normal(_)))
}

/// A path without `.`, and without `..` after a folder.
fn normal(path: &Path) -> PathBuf {
    let mut parts: Vec<Component> = Vec::new();
    for part in path.components() {
        match (part, parts.last()) {
            (Component::CurDir, _) => {}
            (Component::ParentDir, Some(Component::Normal(_))) => _ = parts.pop(),
            _ => parts.push(part),
        }
    }
    parts.into_iter().collect()
}

/// With slashes, as archives and scenes have them.
fn spelled(path: &Path) -> String {
    path.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// The text of a file with the names of others as they are from its place in the FMU. They stand in quotation marks, alone or in a law; what would lead to the
/// same place there stays as its author wrote it.
fn references(text: &str, of: &SceneFile, places: &[SceneFile]) -> String {
    let mut written = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find(['"', '\'']) {
        let (before, quoted) = rest.split_at(start + 1);
        written += before;
        let mark = if before.ends_with('"') { '"' } else { '\'' };
        let end = quoted.find([mark, '\n']).filter(|end| quoted[*end..].starts_with(mark));
        let name = end.map(|end| quoted[..end].trim_end_matches('\\'));
        let named = name.and_then(|name| Some((name, renamed(name, of, places)?)));
        rest = match named {
            Some((name, new)) => {
                written += &new;
                &quoted[name.len()..]
            }
            None => quoted,
        };
    }
    written + rest
}

/// What a name must be inside the FMU, if it is one of a file there and would lead elsewhere.
fn renamed(name: &str, of: &SceneFile, places: &[SceneFile]) -> Option<String> {
    let from = |folder: &Path, name: &str| normal(&folder.parent().unwrap_or(Path::new("")).join(name));
    let plain = name.replace("\\\\", "\\");
    let named = from(&of.written, &plain);
    let place = places.iter().find(|place| place.written == named)?;
    (from(&of.inside, &plain) != place.inside).then(|| {
        let up = of.inside.components().count() - 2;
        "../".repeat(up) + &spelled(place.inside.strip_prefix("resources").unwrap_or(&place.inside))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detours_are_left_out() {
        for (path, plain) in
            [("a/../b.toml", "b.toml"), ("./a/b", "a/b"), ("../../a", "../../a"), ("/a/../b", "/b"), ("/..", "/..")]
        {
            assert_eq!(normal(Path::new(path)), Path::new(plain), "{path}");
        }
    }
}
