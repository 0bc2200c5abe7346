//! `cotree new`

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::failure::Failure;
use super::output;
use crate::mechanism::identifier;

const TEMPLATE: &str = include_str!("template.toml");

/// Write a commented scene to start from: a slider-crank that works as it is
#[derive(Args)]
#[command(after_help = "Example:\n  cotree new my_mechanism      writes my_mechanism.toml")]
pub struct New {
    /// Name of the mechanism; the file gets the ending `.toml`
    name: PathBuf,
}

impl New {
    pub fn run(self) -> Result<(), Failure> {
        let path = if self.name.extension().is_some_and(|end| end == "toml") {
            self.name
        } else {
            let mut name = self.name.into_os_string();
            name.push(".toml");
            name.into()
        };
        create(&path, &scene(&path)).map_err(|error| match error.kind() {
            std::io::ErrorKind::AlreadyExists => {
                Failure::Usage(format!("`{}` exists already; choose another name", path.display()))
            }
            _ => Failure::file("write", &path, error),
        })?;
        let path = path.display();
        output::print(&format!("{path}\nNext: cotree check {path}\n"))
    }
}

/// The template under the file's own name.
fn scene(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| identifier(&stem.to_string_lossy())).unwrap_or_default();
    TEMPLATE.replacen("slider_crank", &stem, 1)
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
    use crate::scene::Scene;

    #[test]
    fn the_template_is_a_scene_without_faults() {
        let text = scene(Path::new("folder/my mechanism.toml"));
        let resolved = Scene::from_toml(&text).unwrap().resolve().unwrap();
        assert_eq!(resolved.mechanism.name, "my_mechanism");
        assert_eq!(resolved.warnings, []);
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
