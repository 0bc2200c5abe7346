//! `cotree demo`

use std::process::{Command, Stdio};

use clap::Args;
use cotree::export::runtime;
use cotree::gallery::FILES;
use cotree::scene::Scene;
use cotree_page::moving;

use super::failure::Failure;
use super::{MessageFormat, new, output, serve};

/// See a mechanism move: one of the models, in a browser
///
/// This machine serves the page, with its solver in this program, and opens it in a browser; Ctrl-C ends it. `cotree new NAME --from MODEL` writes the scene.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree demo\n  cotree demo four_bar\n  cotree demo excavator --no-browser")]
pub struct DemoCommand {
    /// The model
    #[arg(default_value = "jansen")]
    model: String,
    /// Print the address only
    #[arg(long)]
    no_browser: bool,
}

impl DemoCommand {
    pub fn run(self, format: MessageFormat) -> Result<(), Failure> {
        let (compiled, page) = moving::page(&scene(&self.model)?, Some(Vec::new()))?;
        output::warn(compiled.warnings.as_ref(), format);
        let page = page.map_err(|error| Failure::Numerical(error.to_string()))?;
        let desk = serve::desk(&runtime::default_folder())?;
        serve::page(page.served_html(), desk, |address| {
            if !self.no_browser {
                open(address);
            }
        })
    }
}

/// A model with the files of its parts and tables.
fn scene(name: &str) -> Result<Scene, Failure> {
    let scene = [("scene.toml".to_owned(), new::model(name)?)].into_iter();
    let further = FILES.iter().filter(|(of, ..)| *of == name);
    let files: Vec<_> = scene.chain(further.map(|(_, file, text)| ((*file).to_owned(), (*text).to_owned()))).collect();
    Ok(Scene::from_files(&files)?)
}

/// Opens an address in the browser that the system prefers. Where there is none, the address has been printed.
fn open(address: &str) {
    let (program, arguments): (_, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("cmd", &["/C", "start", ""]),
        _ => ("xdg-open", &[]),
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let _ = command.spawn(); // the address is printed, too
}

#[cfg(test)]
mod tests {
    use super::*;
    use cotree::gallery::MODELS;

    #[test]
    fn every_model_has_its_files() {
        for (name, _) in MODELS {
            scene(name).unwrap().resolve().unwrap_or_else(|faults| panic!("{name}: {faults}"));
        }
        assert!(scene("fourbar").is_err());
    }
}
