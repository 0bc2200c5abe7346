//! `cotree new`

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use cotree::diagnostic::suggest;
use cotree::gallery::{FILES, MODELS};
use cotree::model::identifier;

use super::failure::Failure;
use super::output;

const TEMPLATE: &str = include_str!("template.toml");

/// Write a commented scene to start from: a slider-crank that runs
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree new my_mechanism                    writes my_mechanism.toml\n  \
                  cotree new my_mechanism --from four_bar    begins with a model instead of the commented slider-crank")]
pub struct NewCommand {
    /// Name of the mechanism; the file gets the ending `.toml`
    name: PathBuf,
    /// Start from one of the models
    #[arg(long, value_name = "MODEL")]
    from: Option<String>,
}

impl NewCommand {
    pub fn run(self) -> Result<(), Failure> {
        let text = match &self.from {
            None => TEMPLATE.to_string(),
            Some(name) => model(name)?,
        };
        let path = if self.name.extension().is_some_and(|end| end == "toml") {
            self.name
        } else {
            let mut name = self.name.into_os_string();
            name.push(".toml");
            name.into()
        };
        let mut files = vec![(path.clone(), scene(&text, &path))];
        let further = FILES.iter().filter(|(of, ..)| self.from.as_deref() == Some(of));
        files.extend(further.map(|(_, name, text)| (path.with_file_name(name), (*text).to_owned())));
        create_all(&files)?;
        let names: String = files.iter().map(|(path, _)| format!("{}\n", path.display())).collect();
        output::print(&format!("{names}Next: cotree check {}\n", path.display()))
    }
}

/// Writes files that must not exist: all of them or none.
fn create_all(files: &[(PathBuf, String)]) -> Result<(), Failure> {
    for (index, (path, text)) in files.iter().enumerate() {
        create(path, text).map_err(|error| {
            for (written, _) in &files[..index] {
                let _ = std::fs::remove_file(written); // the reason is told already
            }
            match error.kind() {
                std::io::ErrorKind::AlreadyExists => {
                    Failure::Usage(format!("`{}` exists already; choose another name", path.display()))
                }
                _ => Failure::file("write", path, error),
            }
        })?;
    }
    Ok(())
}

/// The scene of a model, without the place of its schema, which is another from elsewhere.
pub(super) fn model(name: &str) -> Result<String, Failure> {
    let found = MODELS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
    let text = found.ok_or_else(|| {
        let known = suggest::known(name, MODELS.iter().map(|(known, _)| *known));
        Failure::Usage(format!("there is no model `{name}`; {known}"))
    })?;
    Ok(text.lines().filter(|line| !line.starts_with("#:schema")).map(|line| format!("{line}\n")).collect())
}

/// A scene under the file's own name.
fn scene(text: &str, path: &Path) -> String {
    let stem = path.file_stem().map(|stem| identifier(&stem.to_string_lossy())).unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("name")).unwrap_or_default();
    let (key, _) = line.split_once('=').unwrap_or((line, ""));
    text.replacen(line, &format!("{key}= \"{stem}\""), 1)
}

/// Writes a file that must not exist; removed again if it cannot be written whole.
fn create(path: &Path, text: &str) -> std::io::Result<()> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(text.as_bytes()).inspect_err(|_| {
        let _ = std::fs::remove_file(path); // the reason is told already
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use cotree::scene::Scene;

    #[test]
    fn the_template_is_a_scene_without_faults() {
        let text = scene(TEMPLATE, Path::new("folder/my mechanism.toml"));
        let resolved = Scene::from_toml(&text).unwrap().resolve().unwrap();
        assert_eq!(resolved.mechanism.name, "my_mechanism");
        assert_eq!(resolved.warnings, []);
    }

    #[test]
    fn every_model_can_be_started_from() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
        let mut models: Vec<String> =
            folder.read_dir().unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        models.sort();
        assert_eq!(MODELS.iter().map(|(name, _)| *name).collect::<Vec<_>>(), models);
        let place = std::env::temp_dir().join(format!("cotree_new_{}", std::process::id()));
        for name in models {
            let path = place.join(&name).join("mine.toml");
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            NewCommand { name: path.clone(), from: Some(name.clone()) }.run().unwrap();
            assert_eq!(Scene::read(&path).unwrap().resolve().unwrap().mechanism.name, "mine", "{name}");
            assert!(NewCommand { name: path, from: Some(name) }.run().is_err());
        }
        std::fs::remove_dir_all(place).unwrap();
        assert!(model("fourbar").is_err());
    }

    #[test]
    fn what_the_template_comments_out_works_too() {
        let text: String = TEMPLATE.lines().map(|line| format!("{}\n", uncommented(line))).collect();
        let resolved = Scene::from_toml(&text).unwrap().resolve().unwrap();
        assert_eq!(resolved.mechanism.loads.len(), 2);
    }

    /// A line of TOML that is commented out; prose stays a comment.
    fn uncommented(line: &str) -> &str {
        line.strip_prefix("# ").filter(|rest| rest.starts_with('[') || rest.contains(" = ")).unwrap_or(line)
    }
}
