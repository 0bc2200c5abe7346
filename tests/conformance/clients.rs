//! The dynamic cases once more, through an importer that others have written: fmpy.

use crate::support::ROOT;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::table::{Outcome, Row};
use super::{REQUIREMENTS, python};

/// What came of each case with each model.
pub struct Client {
    outcomes: Vec<BTreeMap<String, Outcome>>,
}

const NAME: &str = "fmpy";
/// Cases of the importer alone.
pub const OWN: [(&str, &str); 1] = [("X07", "the importer finds no fault in the description")];
/// Cases of the raw interface alone.
pub const RAW: [&str; 6] = ["X06", "X08", "X09", "X10", "X11", "X12"];

/// Runs all cases in fmpy, unless it is left out.
pub fn fmpy(folders: &[PathBuf]) -> Option<Client> {
    let (_, python) = python::python(NAME, REQUIREMENTS)?;
    let script = Path::new(ROOT).join("tests/fmpy/catalogue/main.py");
    let outcomes = folders.iter().map(|folder| {
        let report = python::run(Command::new(&python).arg(&script).arg(folder))
            .unwrap_or_else(|report| panic!("the catalogue could not be run in {NAME}:\n{report}"));
        report.lines().map(outcome).collect()
    });
    Some(Client { outcomes: outcomes.collect() })
}

impl Client {
    /// Adds what the importer says of a case.
    pub fn add(&self, row: &mut Row) {
        if RAW.contains(&row.case) {
            return;
        }
        for (here, outcomes) in row.outcomes.iter_mut().zip(&self.outcomes) {
            let other = outcomes.get(row.case).cloned().unwrap_or(Outcome::Failed("it was not run".to_owned()));
            match other {
                Outcome::Failed(reason) => *here = Outcome::Failed(format!("{NAME}: {reason}")),
                other
                    if matches!(
                        (&*here, &other),
                        (Outcome::Passed, Outcome::Nothing(_)) | (Outcome::Nothing(_), Outcome::Passed)
                    ) =>
                {
                    *here = Outcome::Failed(format!("{NAME} disagrees on whether there is something to check"));
                }
                _ => {}
            }
        }
        row.clients.push(NAME);
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
        _ => Outcome::Failed(format!("{word} {reason}").replace(" | ", "\n")),
    };
    (case, outcome)
}
