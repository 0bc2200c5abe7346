//! Why a command failed, and how that is told.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::path::Path;

use cotree::diagnostic::visible::visible;
use cotree::diagnostic::{Fault, Source, every};
use cotree::export::ExportError;
use cotree::run::RunError;
use cotree::scene::Faults;
use cotree_fmu::instance::InstanceError;

use super::{MessageFormat, output};

const SCENE: u8 = 1;
/// Exit code for wrong usage and for files that cannot be read or written.
pub const USAGE: u8 = 2;
const NUMERICAL: u8 = 3;
/// Exit code where standard output is closed before everything is written.
pub const UNREAD: u8 = 1;
/// What shells give for SIGINT.
const STOPPED: u8 = 130;

/// Why a command failed.
#[derive(Debug)]
pub enum Failure {
    Scene(Faults),
    /// The command line, or a file that it names.
    Usage(String),
    /// The solver could not go on.
    Numerical(String),
    /// The mechanism does not keep a limit that its scene sets.
    Limit(String),
    /// The user pressed Ctrl-C; what was kept.
    Stopped(String),
    /// Several scenes were looked at, and what is wrong was told with each; the exit code.
    Told(u8),
    /// Whoever reads the output has seen enough, or standard output is closed: nothing more is said.
    ClosedPipe,
}

impl Failure {
    /// A panic: an error of the program itself.
    pub fn internal(panic: &str) -> Self {
        let fault = Fault::internal(format!("internal error: {panic}"));
        Failure::Scene(Faults::new(Source::new("", ""), vec![fault]))
    }

    /// A file that cannot be read or written.
    pub fn file(action: &str, path: &Path, error: impl Display) -> Self {
        Failure::Usage(format!("cannot {action} `{}`: {error}", path.display()))
    }

    /// All of them, or every message: a line for each.
    pub fn every<T, E: Display>(results: impl Iterator<Item = Result<T, E>>) -> Result<Vec<T>, Failure> {
        every(results).map_err(|messages| Failure::usage(&messages))
    }

    /// Several faults of the command line.
    pub fn usage(messages: &[impl Display]) -> Self {
        let messages: Vec<String> = messages.iter().map(ToString::to_string).collect();
        Failure::Usage(messages.join("\nerror: "))
    }

    /// Adds what else there is to know.
    pub fn with_note(self, note: &str) -> Self {
        match self {
            Failure::Numerical(message) => Failure::Numerical(format!("{message}\n{note}")),
            Failure::Usage(message) => Failure::Usage(format!("{message}\n{note}")),
            other => other,
        }
    }

    /// Tells why, and gives the exit code.
    pub fn report(self, format: MessageFormat) -> u8 {
        match self {
            Failure::Scene(faults) => {
                match format {
                    MessageFormat::Human => warn(&faults),
                    // When nothing else can be done about an error.
                    MessageFormat::Json => drop(output::print(&format!("{:#}\n", faults.to_json()))),
                }
                SCENE
            }
            Failure::Usage(message) => {
                say(&format!("error: {message}\n"));
                USAGE
            }
            Failure::Limit(message) => {
                say(&format!("error: {message}\n"));
                SCENE
            }
            Failure::Numerical(message) => {
                say(&format!("error: {message}\n"));
                NUMERICAL
            }
            Failure::Stopped(message) => {
                say(&format!("{message}\n"));
                STOPPED
            }
            Failure::Told(code) => code,
            Failure::ClosedPipe => UNREAD,
        }
    }
}

impl From<Faults> for Failure {
    fn from(faults: Faults) -> Self {
        Failure::Scene(faults)
    }
}

cotree::diagnostic::from_messages!(Failure as Failure::Usage: ExportError);

/// Faults of standard output.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Failure::ClosedPipe,
            _ => Failure::Usage(format!("cannot write the output: {error}")),
        }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Instance(
                error @ (InstanceError::Solver(_)
                | InstanceError::Start { .. }
                | InstanceError::Jump { .. }
                | InstanceError::Undefined { .. }),
            ) => Failure::Numerical(error.to_string()),
            RunError::Instance(error) => Failure::Usage(error.to_string()),
            RunError::Program(fault) => Failure::Usage(fault.to_string()),
            RunError::Output(error) => error.into(),
        }
    }
}

/// Shows faults on standard error.
pub fn warn(faults: &Faults) {
    let colour = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    write(&faults.render(colour, 100));
}

/// Writes to standard error; nothing in the text can make a terminal do or show something else.
pub fn say(text: &str) {
    write(&visible(text));
}

fn write(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes()); // there is no other place to complain
}
