//! What an import did with the file: each line in one of four classes, so that nothing is dropped unnoticed.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::options::ImportOptions;
use super::refusal::ImportRefusal;
use super::xml::XmlElement;

/// How many names a line lists.
const LISTED: usize = 5;

/// Exact, approximated, left out; what is refused ends the import.
#[derive(Clone, Debug, Default)]
pub struct ImportReport {
    /// What the file is and what became of it.
    pub head: Vec<String>,
    /// Kinds of what is exact, with their numbers.
    exact: BTreeMap<String, usize>,
    /// Which number of the file was replaced by which law.
    pub approximated: Vec<String>,
    /// What has no effect on the motion, counted.
    idle: BTreeMap<String, usize>,
    /// What may act and is never imported, with the names of each.
    missing: BTreeMap<String, Vec<String>>,
    /// What acts and was left out, as the user asked.
    pub left_out: Vec<String>,
    /// What the reader should know beside.
    pub notes: Vec<String>,
    pub refused: Vec<ImportRefusal>,
}

impl ImportReport {
    pub fn exact(&mut self, what: impl Into<String>) {
        *self.exact.entry(what.into()).or_default() += 1;
    }

    pub fn idle(&mut self, what: impl Into<String>) {
        *self.idle.entry(what.into()).or_default() += 1;
    }

    pub fn missing(&mut self, what: impl Into<String>, name: &str) {
        self.missing.entry(what.into()).or_default().push(format!("`{name}`"));
    }

    /// What the reader does not know and may act, with its line and the element that it is in.
    pub fn acting(&mut self, what: &str, line: usize, within: &str) {
        self.missing.entry(what.to_owned()).or_default().push(format!("of {within} (line {line})"));
    }

    /// Refuses what acts, unless the user leaves it out by one of its names.
    pub fn refuse_or_leave(&mut self, element: &XmlElement, options: &ImportOptions, names: &[&str], why: &str) {
        let names: Vec<&str> = names.iter().copied().filter(|name| !name.is_empty()).collect();
        if options.leaves_out(&names) {
            self.left_out.push(format!("{why} (line {})", element.place.line));
            return;
        }
        let option = names.first().copied().unwrap_or("all");
        self.refuse(element.refuse(why).help(format!("--leave-out {option} imports the file without it")));
    }

    pub fn approximated(&mut self, what: impl Into<String>) {
        let what = what.into();
        if !self.approximated.contains(&what) {
            self.approximated.push(what);
        }
    }

    pub fn note(&mut self, what: impl Into<String>) {
        let what = what.into();
        if !self.notes.contains(&what) {
            self.notes.push(what);
        }
    }

    pub fn refuse(&mut self, refusal: ImportRefusal) {
        self.refused.push(refusal);
    }

    /// Its lines.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = self.head.clone();
        let listed = |counts: &BTreeMap<String, usize>| {
            let mut text = String::new();
            for (what, count) in counts {
                let separator = if text.is_empty() { "" } else { ", " };
                // Writing to a string cannot fail.
                let _ = match count {
                    1 => write!(text, "{separator}{what}"),
                    _ => write!(text, "{separator}{count} x {what}"),
                };
            }
            text
        };
        if !self.exact.is_empty() {
            lines.push(format!("exact: {}", listed(&self.exact)));
        }
        lines.extend(self.approximated.iter().map(|line| format!("approximated: {line}")));
        if !self.idle.is_empty() {
            lines.push(format!("left out, no effect on the motion: {}", listed(&self.idle)));
        }
        for (what, names) in &self.missing {
            let first = names.iter().take(LISTED).map(String::as_str).collect::<Vec<_>>().join(", ");
            let more = if names.len() > LISTED { ", ..." } else { "" };
            lines.push(format!("left out, although it can act: {} x {what}: {first}{more}", names.len()));
        }
        lines.extend(self.left_out.iter().map(|line| format!("left out, although it acts: {line}")));
        lines.extend(self.notes.iter().cloned());
        lines
    }
}
