//! The results of the catalogue as a table.

use std::env;
use std::fmt::Write;

/// What came of a case with a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    Passed,
    /// With the reason.
    Failed(String),
    /// The model has nothing that the case is about; with the reason.
    Nothing(String),
}

impl Outcome {
    pub fn of_complaints(complaints: Vec<String>) -> Self {
        if complaints.is_empty() { Self::Passed } else { Self::Failed(complaints.join("\n")) }
    }

    fn word(&self) -> &'static str {
        match self {
            Self::Passed => "pass",
            Self::Failed(_) => "FAIL",
            Self::Nothing(_) => "-",
        }
    }
}

/// A case with its outcome for each model.
pub struct Row {
    pub case: &'static str,
    pub what: &'static str,
    pub outcomes: Vec<Outcome>,
    /// Who has run it; nobody for rules of the archive.
    pub clients: Vec<&'static str>,
}

impl Row {
    pub fn new(case: &'static str, what: &'static str, outcomes: Vec<Outcome>, clients: Vec<&'static str>) -> Self {
        Self { case, what, outcomes, clients }
    }

    fn nothing(&self) -> impl Iterator<Item = (usize, &str)> {
        let outcomes = self.outcomes.iter().enumerate();
        outcomes.filter_map(|(model, outcome)| match outcome {
            Outcome::Nothing(reason) => Some((model, reason.as_str())),
            _ => None,
        })
    }
}

/// The table for a terminal.
pub fn plain(models: &[&str], rows: &[Row]) -> String {
    let heads: String = models.iter().map(|model| format!("{model:>14}")).collect();
    let mut text = format!("case {heads}  what\n");
    for Row { case, what, outcomes, clients, .. } in rows {
        let words: String = outcomes.iter().map(|outcome| format!("{:>14}", outcome.word())).collect();
        let _ = writeln!(text, "{case:5}{words}  {what} ({})", clients.join(", "));
    }
    text
}

/// What failed, and what no model could show.
pub fn failures(models: &[&str], rows: &[Row]) -> Vec<String> {
    let mut failures = Vec::new();
    for Row { case, what, outcomes, .. } in rows {
        for (outcome, model) in outcomes.iter().zip(models) {
            if let Outcome::Failed(reason) = outcome {
                failures.push(format!("{case} {model}: {what}\n{reason}"));
            }
        }
        // The schema is left out when the user asks for that.
        if *case != "S01" && outcomes.iter().all(|outcome| matches!(outcome, Outcome::Nothing(_))) {
            failures.push(format!("{case}: no model shows: {what}"));
        }
    }
    failures
}

/// The table as a page of the documentation. Date and commit come from the script that asks for it.
pub fn markdown(models: &[&str], rows: &[Row], glibc: &str) -> String {
    let said = |name: &str| env::var(name).unwrap_or_else(|_| "unknown".to_owned());
    let counted =
        |word: &str| rows.iter().flat_map(|row| &row.outcomes).filter(|outcome| outcome.word() == word).count();
    let mut text = format!(
        "# Conformance\n\nWritten by `tools/conformance.sh` on {}, commit {}. Do not edit.\n\n\
         {} cases with {} models: {} passed, {} failed, {} where the model has nothing that the case is about.\n\
         S: rules for the archive. D: calls, each case in a fresh process. M: Model Exchange. X: beyond the catalogue.\n\
         Clients: the raw C interface, and an importer that others have written, fmpy. A model passes if it passes with both of them.\n\
         The newest version of the C library that the shared library for this platform asks for: {glibc}.\n\n",
        said("COTREE_DATE"),
        said("COTREE_COMMIT"),
        rows.len(),
        models.len(),
        counted("pass"),
        counted("FAIL"),
        counted("-"),
    );
    let _ = writeln!(text, "| case | what | clients | {} |", models.join(" | "));
    let _ = writeln!(text, "|---|---|---|{}", "---|".repeat(models.len()));
    for Row { case, what, outcomes, clients, .. } in rows {
        let words: Vec<&str> = outcomes.iter().map(Outcome::word).collect();
        let _ = writeln!(text, "| {case} | {what} | {} | {} |", clients.join(", "), words.join(" | "));
    }
    text.push_str("\n## Nothing to check\n\n");
    for row in rows {
        for (model, reason) in row.nothing() {
            let _ = writeln!(text, "- {} with {}: {reason}", row.case, models[model]);
        }
    }
    text
}
