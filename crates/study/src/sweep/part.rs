//! A sweep in parts, for job arrays: each part has a block of the runs and a file of its own, and the files are joined to the table that one run of all would have written.
//!
//! The first line of a file is the mark of its campaign: scene, number and values of the runs, times, which part of how many it is, and a digest of the lines behind it. What does not belong together
//! or has been edited is refused.

use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use cotree::files::Draft;

use super::design::Digest;

/// The n-th of so many parts, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SweepPart {
    number: usize,
    of: usize,
}

/// A text is no part.
#[derive(Debug, thiserror::Error)]
#[error("write a part as 7/100: its number, from 1, and how many there are")]
pub struct PartError;

/// Why files are not joined.
#[derive(Debug, thiserror::Error)]
pub enum JoinError {
    #[error("`{}` is not a finished part of a sweep: `cotree sweep --part` writes them, and --resume finishes those that were stopped", .0.display())]
    NoPart(PathBuf),
    #[error("`{}` and `{}` are parts of different sweeps: scene, runs, outputs, times or number of parts differ", .0.display(), .1.display())]
    Other(PathBuf, PathBuf),
    #[error("`{}` has been changed since it was written: its rows are not those of its first line; run that part again", .0.display())]
    Edited(PathBuf),
    #[error("`{}` and `{}` are the same part", .0.display(), .1.display())]
    Twice(PathBuf, PathBuf),
    #[error("parts {0} are missing")]
    Missing(String),
    #[error("cannot read or write `{}`: {error}", .path.display())]
    File { path: PathBuf, error: io::Error },
}

impl SweepPart {
    /// All runs.
    pub const WHOLE: SweepPart = SweepPart { number: 1, of: 1 };

    pub fn is_whole(self) -> bool {
        self.of == 1
    }

    /// Its runs of so many: blocks whose lengths differ by one at most.
    pub fn runs(self, all: usize) -> Range<usize> {
        let before = |number: usize| (number as u128 * all as u128 / self.of as u128) as usize;
        before(self.number - 1)..before(self.number)
    }
}

impl FromStr for SweepPart {
    type Err = PartError;

    fn from_str(text: &str) -> Result<Self, PartError> {
        let (number, of) = text.split_once('/').ok_or(PartError)?;
        let (number, of) = (number.parse().map_err(|_| PartError)?, of.parse().map_err(|_| PartError)?);
        if (1..=of).contains(&number) { Ok(SweepPart { number, of }) } else { Err(PartError) }
    }
}

impl fmt::Display for SweepPart {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.number, self.of)
    }
}

/// Stands before the digest of the rows.
pub(super) const ROWS: &str = ", rows ";

/// A file with a part.
struct PartFile {
    path: PathBuf,
    part: SweepPart,
    /// The campaign without the part, and the line of names.
    mark: String,
    heading: String,
    /// Of heading and rows, as they were written.
    digest: u64,
    lines: BufReader<File>,
}

impl PartFile {
    fn open(path: &Path) -> Result<Self, JoinError> {
        let failed = |error| JoinError::File { path: path.to_owned(), error };
        let mut lines = BufReader::new(File::open(path).map_err(failed)?);
        let (mut mark, mut heading) = (String::new(), String::new());
        lines.read_line(&mut mark).and_then(|_| lines.read_line(&mut heading)).map_err(failed)?;
        let split = mark.trim_end().rsplit_once(", part ").filter(|(mark, _)| mark.starts_with("# sweep of "));
        let part = split.and_then(|(mark, part)| {
            let (part, digest) = part.split_once(ROWS)?;
            Some((mark.to_owned(), part.parse().ok()?, u64::from_str_radix(digest, 16).ok()?))
        });
        let (mark, part, digest) = part.ok_or_else(|| JoinError::NoPart(path.to_owned()))?;
        Ok(PartFile { path: path.to_owned(), part, mark, heading, digest, lines })
    }

    /// How many runs all parts have together.
    fn all(&self) -> Option<usize> {
        self.mark.split_once(": ")?.1.split_once(" runs")?.0.parse().ok()
    }

    /// Copies its rows: exactly those of its part.
    fn copy(mut self, out: &mut impl Write) -> Result<(), JoinError> {
        let failed = |error| JoinError::File { path: self.path.clone(), error };
        let unfinished = || JoinError::NoPart(self.path.clone());
        let runs = self.part.runs(self.all().ok_or_else(unfinished)?);
        let (mut next, mut line, mut digest) = (runs.start, Vec::new(), Digest::default());
        digest.add(self.heading.as_bytes());
        while self.lines.read_until(b'\n', &mut line).map_err(failed)? > 0 {
            let is_next = line.starts_with(format!("{next},").as_bytes()) && line.ends_with(b"\n");
            if next == runs.end || !is_next {
                return Err(unfinished());
            }
            digest.add(&line);
            out.write_all(&line).map_err(failed)?;
            line.clear();
            next += 1;
        }
        if next != runs.end {
            return Err(unfinished());
        }
        if digest.0 == self.digest { Ok(()) } else { Err(JoinError::Edited(self.path.clone())) }
    }
}

/// Joins all parts of a sweep to the table that one run of all would have written; returns how many runs there are. Rows are copied one at a time.
///
/// # Errors
/// Parts are missing, unfinished, there twice or of different sweeps; or a file cannot be read or written.
pub fn join(paths: &[PathBuf], place: &Path) -> Result<usize, JoinError> {
    let mut files = paths.iter().map(|path| PartFile::open(path)).collect::<Result<Vec<_>, _>>()?;
    files.sort_by_key(|file| file.part);
    let Some(first) = files.first() else { return Err(JoinError::Missing("of a sweep".to_owned())) };
    let all = first.all().ok_or_else(|| JoinError::NoPart(first.path.clone()))?;
    for pair in files.windows(2) {
        let [one, other] = pair else { continue };
        if (&one.mark, &one.heading, one.part.of) != (&other.mark, &other.heading, other.part.of) {
            return Err(JoinError::Other(one.path.clone(), other.path.clone()));
        }
        if one.part == other.part {
            return Err(JoinError::Twice(one.path.clone(), other.path.clone()));
        }
    }
    let missing: Vec<String> = (1..=first.part.of)
        .filter(|number| files.binary_search_by_key(number, |file| file.part.number).is_err())
        .map(|number| number.to_string())
        .collect();
    if !missing.is_empty() {
        return Err(JoinError::Missing(missing.join(", ")));
    }
    let failed = |error| JoinError::File { path: place.to_owned(), error };
    let mut draft = Draft::new(place).map_err(failed)?;
    draft.write_all(first.heading.as_bytes()).map_err(failed)?;
    files.into_iter().try_for_each(|file| file.copy(&mut draft))?;
    draft.commit().map_err(failed)?;
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_each_run_once_and_differ_by_one_at_most() {
        for (all, of) in [(1, 1), (10, 3), (7, 100), (1_000_003, 97)] {
            let parts: Vec<_> = (1..=of).map(|number| SweepPart { number, of }.runs(all)).collect();
            assert!(parts.first().unwrap().start == 0 && parts.last().unwrap().end == all);
            assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start));
            assert!(parts.iter().all(|part| (all / of..=all.div_ceil(of)).contains(&part.len())));
        }
    }

    #[test]
    fn what_is_no_part_is_refused() {
        for text in ["", "7", "0/3", "4/3", "1/0", "a/b", "1/2/3", "-1/2"] {
            assert!(text.parse::<SweepPart>().is_err(), "{text}");
        }
        assert_eq!("7/100".parse::<SweepPart>().unwrap().to_string(), "7/100");
    }

    #[test]
    fn parts_are_joined_and_what_does_not_belong_together_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, mark: &str, rows: &str| {
            let path = folder.path().join(name);
            let mut digest = Digest::default();
            digest.add(format!("run,a,failure\n{rows}").as_bytes());
            let mark = format!("# sweep of g: 3 runs, values {mark}{ROWS}{:016x}", digest.0);
            std::fs::write(&path, format!("{mark}\nrun,a,failure\n{rows}")).unwrap();
            path
        };
        let one = file("1", "v, part 1/2", "0,1.0,\n");
        let two = file("2", "v, part 2/2", "1,2.0,\n2,3.0,\n");
        let place = folder.path().join("all.csv");
        assert_eq!(join(&[two.clone(), one.clone()], &place).unwrap(), 3);
        assert_eq!(std::fs::read_to_string(&place).unwrap(), "run,a,failure\n0,1.0,\n1,2.0,\n2,3.0,\n");
        let refused = |paths: &[PathBuf]| join(paths, &folder.path().join("none.csv")).unwrap_err();
        assert!(matches!(refused(std::slice::from_ref(&one)), JoinError::Missing(list) if list == "2"));
        assert!(matches!(refused(&[one.clone(), one.clone(), two.clone()]), JoinError::Twice(..)));
        let other = file("3", "w, part 2/2", "1,2.0,\n2,3.0,\n");
        assert!(matches!(refused(&[one.clone(), other]), JoinError::Other(..)));
        for rows in ["1,2.0,\n", "1,2.0,\n2,3.0", "2,3.0,\n1,2.0,\n", "1,2.0,\n2,3.0,\n3,4.0,\n"] {
            let cut = file("4", "v, part 2/2", rows);
            assert!(matches!(refused(&[one.clone(), cut]), JoinError::NoPart(_)), "{rows}");
        }
        let edited = file("5", "v, part 2/2", "1,2.0,\n2,3.0,\n");
        std::fs::write(&edited, std::fs::read_to_string(&edited).unwrap().replace("2,3.0", "2,3.1")).unwrap();
        assert!(matches!(refused(&[one.clone(), edited]), JoinError::Edited(_)));
        assert!(!folder.path().join("none.csv").exists());
    }
}
