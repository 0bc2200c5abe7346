//! The command line: one file for each command, and one for those that print what others read of cotree.

#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        reason = "no input may cause a panic"
    )
)]

mod argument;
mod assemblies;
mod bench;
mod check;
mod columns;
mod demo;
mod draw;
mod environment;
mod equilibrium;
mod export;
mod failure;
mod fit;
mod import;
mod info;
mod join;
mod linearize;
mod modes;
mod motion;
mod new;
mod optimize;
mod output;
mod serve;
mod show;
mod simulate;
mod stop;
mod study;
mod sweep;
mod synthesize;
mod times;
mod trace;
mod units;
mod view;
mod watch;
mod words;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use cotree_fmu::contain::contain;

use failure::Failure;

/// Planar mechanisms to FMUs: describe bodies and joints in a scene file, get equations of motion, a simulation, and an
/// FMU for any tool that reads FMI 2.0 or 3.0.
#[derive(Parser)]
#[command(
    name = "cotree",
    version,
    arg_required_else_help = true,
    after_help = "First steps:\n  cotree demo                        see a mechanism move, in a browser\n  cotree new my_mechanism            write a commented scene to start from\n  \
                  cotree check my_mechanism.toml     check it for errors\n  \
                  cotree simulate my_mechanism.toml  print the motion as a table\n  \
                  cotree view my_mechanism.toml      show the motion in a browser\n  \
                  cotree export my_mechanism.toml    make my_mechanism.fmu\n\n\
                  Exit codes: 0 success, 1 the scene has errors (or cotree has: cotree::internal) or a clearance is too small, 2 usage or file error,\n            \
                  3 the solver failed, 130 stopped by Ctrl-C. Also 1, without a message, if standard output is closed before everything is written."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    global: Global,
}

#[derive(Args)]
struct Global {
    /// Format of errors and warnings: for people, or JSON on standard output for editors and scripts
    #[arg(long, global = true, value_name = "FORMAT", default_value = "human", display_order = 100)]
    message_format: MessageFormat,
}

/// How faults are reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MessageFormat {
    /// With the source lines
    Human,
    /// One JSON object
    Json,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::DemoCommand),
    New(new::NewCommand),
    Check(check::CheckCommand),
    Show(show::ShowCommand),
    Simulate(simulate::SimulateCommand),
    Sweep(sweep::SweepCommand),
    Join(join::JoinCommand),
    Fit(fit::FitCommand),
    Optimize(optimize::OptimizeCommand),
    View(view::ViewCommand),
    Watch(watch::WatchCommand),
    Draw(draw::DrawCommand),
    Trace(trace::TraceCommand),
    Equilibrium(equilibrium::EquilibriumCommand),
    Linearize(linearize::LinearizeCommand),
    Assemblies(assemblies::AssembliesCommand),
    Modes(modes::ModesCommand),
    Motion(motion::MotionCommand),
    Synthesize(synthesize::SynthesizeCommand),
    Export(export::ExportCommand),
    Import(import::ImportCommand),
    Bench(bench::BenchCommand),
    Info(info::InfoCommand),
    Schema(environment::SchemaCommand),
    Completions(environment::CompletionsCommand),
    Man(environment::ManualCommand),
}

/// Runs the command that the process was started with.
pub fn run() -> ExitCode {
    run_with(std::env::args_os()).into()
}

/// Runs a command, and gives its exit code; the first argument is the program's name.
pub fn run_with(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            let printed = error.print();
            return match (error.use_stderr(), printed) {
                (true, _) => failure::USAGE,
                (false, Ok(())) => 0,
                (false, Err(_)) => failure::UNREAD,
            };
        }
    };
    let format = cli.global.message_format;
    conclude(|| dispatch(cli.command, format), format)
}

/// The exit code of a command. A panic ends here, as a fault that is reported like others.
fn conclude(command: impl FnOnce() -> Result<(), Failure>, format: MessageFormat) -> u8 {
    match contain(command).unwrap_or_else(|panic| Err(Failure::internal(&panic))) {
        Ok(()) => 0,
        Err(failure) => failure.report(format),
    }
}

fn dispatch(command: Command, format: MessageFormat) -> Result<(), Failure> {
    match command {
        Command::Demo(command) => command.run(format),
        Command::New(command) => command.run(),
        Command::Check(command) => command.run(format),
        Command::Show(command) => command.run(format),
        Command::Simulate(command) => command.run(format),
        Command::Sweep(command) => command.run(format),
        Command::Join(command) => command.run(),
        Command::Fit(command) => command.run(format),
        Command::Optimize(command) => command.run(format),
        Command::View(command) => command.run(format),
        Command::Watch(command) => command.run(),
        Command::Draw(command) => command.run(),
        Command::Trace(command) => command.run(format),
        Command::Equilibrium(command) => command.run(format),
        Command::Linearize(command) => command.run(format),
        Command::Assemblies(command) => command.run(format),
        Command::Modes(command) => command.run(format),
        Command::Motion(command) => command.run(format),
        Command::Synthesize(command) => command.run(format),
        Command::Export(command) => command.run(format),
        Command::Import(command) => command.run(format),
        Command::Bench(command) => command.run(format),
        Command::Info(command) => command.run(),
        Command::Schema(command) => command.run(),
        Command::Completions(command) => command.run(Cli::command()),
        Command::Man(command) => command.run(Cli::command()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::{MessageFormat, conclude};

    #[test]
    fn a_panic_is_a_fault_with_an_exit_code() {
        let fails = || panic!("index out of bounds");
        assert_eq!(conclude(fails, MessageFormat::Human), 1);
        assert_eq!(conclude(fails, MessageFormat::Json), 1);
    }

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }
}
