//! The dynamic cases once more, through importers that others have written.

use crate::support::ROOT;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::table::{Outcome, Row};
use super::{REQUIREMENTS, fmi_rs, python};

/// An importer, and what came of each case with each model.
pub struct Client {
    pub name: &'static str,
    outcomes: Vec<BTreeMap<String, Outcome>>,
}

/// Cases of the importers alone.
pub const OWN: [(&str, &str); 1] = [("X07", "the importer finds no fault in the description")];
/// Cases of the raw interface alone.
pub const RAW: [&str; 6] = ["X06", "X08", "X09", "X10", "X11", "X12"];

/// Runs all cases in every importer that is at hand.
pub fn run(folders: &[PathBuf]) -> Vec<Client> {
    let mut clients = Vec::new();
    if let Some((_, python)) = python::python("fmpy", REQUIREMENTS) {
        let script = Path::new(ROOT).join("tests/fmpy/catalogue/main.py");
        clients.push(Client::run("fmpy", folders, |folder| {
            let mut command = Command::new(&python);
            command.arg(&script).arg(folder);
            command
        }));
    }
    clients.push(Client::run("fmi-rs", folders, |folder| {
        let mut command = fmi_rs::client();
        command.arg("catalogue").arg(folder);
        command
    }));
    clients
}

impl Client {
    fn run(name: &'static str, folders: &[PathBuf], command: impl Fn(&Path) -> Command) -> Self {
        let outcomes = folders.iter().map(|folder| {
            let report = python::run(&mut command(folder)).unwrap_or_else(|report| {
                panic!("{name} could not be built or run; its packages are needed from the network once:\n{report}")
            });
            report.lines().map(outcome).collect()
        });
        Self { name, outcomes: outcomes.collect() }
    }

    /// Adds what this importer says of a case.
    pub fn add(&self, row: &mut Row) {
        if RAW.contains(&row.case) {
            return;
        }
        let mut ran = false;
        for (here, outcomes) in row.outcomes.iter_mut().zip(&self.outcomes) {
            let other = outcomes.get(row.case).cloned().unwrap_or(Outcome::Failed("it was not run".to_owned()));
            ran |= !matches!(other, Outcome::Beyond(_));
            match other {
                Outcome::Failed(reason) => *here = Outcome::Failed(format!("{}: {reason}", self.name)),
                Outcome::Beyond(reason) => drop(row.beyond.insert(self.name, reason)),
                other
                    if matches!(
                        (&*here, &other),
                        (Outcome::Passed, Outcome::Nothing(_)) | (Outcome::Nothing(_), Outcome::Passed)
                    ) =>
                {
                    *here = Outcome::Failed(format!("{} disagrees on whether there is something to check", self.name));
                }
                _ => {}
            }
        }
        if ran {
            row.clients.push(self.name);
        }
    }
}

/// A line of an importer's report: case, outcome, reason.
fn outcome(line: &str) -> (String, Outcome) {
    let mut fields = line.splitn(3, '\t').map(str::to_owned);
    let mut next = || fields.next().unwrap_or_default();
    let (case, word, reason) = (next(), next(), next());
    let outcome = match word.as_str() {
        "pass" => Outcome::Passed,
        "nothing" => Outcome::Nothing(reason),
        "beyond" => Outcome::Beyond(reason),
        _ => Outcome::Failed(format!("{word} {reason}").replace(" | ", "\n")),
    };
    (case, outcome)
}
