//! `cotree completions`

use clap::{Args, Command};
use clap_complete::Shell;

use super::failure::Failure;
use super::output;

/// Print the completions of a shell: commands and options at the press of a key
#[derive(Args)]
#[command(after_help = "Examples:\n  cotree completions bash > ~/.local/share/bash-completion/completions/cotree\n  \
                  cotree completions zsh > ~/.zfunc/_cotree\n  cotree completions fish > ~/.config/fish/completions/cotree.fish")]
pub struct Completions {
    /// Which shell
    shell: Shell,
}

impl Completions {
    pub fn run(self, mut command: Command) -> Result<(), Failure> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut command, "cotree", &mut text);
        output::print_file(&String::from_utf8_lossy(&text))
    }
}
