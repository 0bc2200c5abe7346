//! `cotree schema`, `cotree completions` and `cotree man`: what editors, shells and `man` are to know of cotree.

use std::path::{Path, PathBuf};

use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;
use cotree::{component, files, task};

use super::failure::Failure;
use super::output;

/// Print the JSON Schema of scene files or of tasks, by which editors complete and check them
///
/// It is made from the keys that cotree itself reads. A TOML scene names it in its first line: `#:schema scene.schema.json`.
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree schema -o scene.schema.json\n  cotree schema --task -o task.schema.json")]
pub struct SchemaCommand {
    /// The schema of tasks for `cotree synthesize`
    #[arg(long)]
    task: bool,
    /// Output file; `-` is standard output [default: -]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl SchemaCommand {
    pub fn run(self) -> Result<(), Failure> {
        let schema = if self.task { task::schema() } else { component::schema() };
        output::put(output::file(self.output.as_deref()), &schema)
    }
}

/// Print the completions of a shell: commands and options at the press of a key
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree completions bash > ~/.local/share/bash-completion/completions/cotree\n  \
                  cotree completions zsh > ~/.zfunc/_cotree\n  cotree completions fish > ~/.config/fish/completions/cotree.fish")]
pub struct CompletionsCommand {
    /// Which shell
    shell: Shell,
}

impl CompletionsCommand {
    pub fn run(self, mut command: Command) -> Result<(), Failure> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut command, "cotree", &mut text);
        output::print_file(&String::from_utf8_lossy(&text))
    }
}

/// Write the manual pages of cotree and of each of its commands into a folder
#[derive(Args)]
#[command(after_help = "Example:\n  cotree man ~/.local/share/man/man1 && man cotree-simulate")]
pub struct ManualCommand {
    /// The folder; it is created if it does not exist
    folder: PathBuf,
}

impl ManualCommand {
    pub fn run(self, mut command: Command) -> Result<(), Failure> {
        // Gives the commands their full names, such as `cotree-show`.
        command.build();
        std::fs::create_dir_all(&self.folder).map_err(|error| Failure::file("make", &self.folder, error))?;
        let mut written = page(&self.folder, command.clone())?;
        for subcommand in command.get_subcommands().filter(|subcommand| subcommand.get_name() != "help") {
            written += &page(&self.folder, subcommand.clone())?;
        }
        output::print(&written)
    }
}

/// Writes one page; its file.
fn page(folder: &Path, command: Command) -> Result<String, Failure> {
    let path = folder.join(format!("{}.1", command.get_display_name().unwrap_or(command.get_name())));
    let failed = |error| Failure::file("write", &path, error);
    let mut text = Vec::new();
    Man::new(command).render(&mut text).map_err(failed)?;
    files::write(&path, &text).map_err(failed)?;
    Ok(format!("{}\n", path.display()))
}
