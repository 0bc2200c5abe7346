//! Why a file is not imported: one error with its place, and what to do.

use std::fmt;
use std::rc::Rc;

/// A place in a file; lines and columns count from 1, columns in characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilePlace {
    pub file: Rc<str>,
    pub line: usize,
    pub column: usize,
}

impl fmt::Display for FilePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// What cannot be imported, where it is, and how it could be.
#[derive(Clone, Debug)]
pub struct ImportRefusal {
    pub place: Option<FilePlace>,
    pub message: String,
    pub help: Option<String>,
}

impl ImportRefusal {
    pub fn new(message: impl Into<String>) -> Self {
        ImportRefusal { place: None, message: message.into(), help: None }
    }

    pub fn at(mut self, place: &FilePlace) -> Self {
        self.place.get_or_insert_with(|| place.clone());
        self
    }

    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for ImportRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{place}: ")?;
        }
        f.write_str(&shortened(&self.message))?;
        match &self.help {
            Some(help) => write!(f, "\n  help: {help}"),
            None => Ok(()),
        }
    }
}

/// The most letters of a file that a message repeats at once.
const LONGEST: usize = 100;

/// With long values of the file cut: they stand between backticks.
fn shortened(message: &str) -> String {
    let cut = |(index, part): (usize, &str)| match part.char_indices().nth(LONGEST) {
        Some((end, _)) if index % 2 == 1 => format!("{}...", &part[..end]),
        _ => part.to_owned(),
    };
    message.split('`').enumerate().map(cut).collect::<Vec<_>>().join("`")
}

pub type Fallible<T> = Result<T, ImportRefusal>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_values_are_cut() {
        let long =
            ImportRefusal::new(format!("`pos` is `{}`, but must be 3 numbers", "0 ".repeat(1_000_000))).to_string();
        assert!(long.len() < 200 && long.starts_with("`pos` is `0 0") && long.ends_with("...`, but must be 3 numbers"));
        assert_eq!(ImportRefusal::new("`a` is `b`").to_string(), "`a` is `b`");
    }
}
