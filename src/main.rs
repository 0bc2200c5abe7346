//! The `cotree` command.

fn main() -> std::process::ExitCode {
    cotree::cli::run()
}
