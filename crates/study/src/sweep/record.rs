//! The table of a sweep: rows are written at once to a temporary file next to the final one, so that an interrupted sweep loses no finished run.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, BufWriter, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use cotree::files::Draft;
use cotree::report::csv::field;
use csv::{ReaderBuilder, StringRecord};

use super::design::Digest;
use super::part::ROWS;
use super::{Outcome, OutcomeError, Sweep};

/// The table of a sweep in a file. Until it is finished it is called `NAME.part`; its first line there says which sweep it belongs to.
#[derive(Debug)]
pub struct SweepRecord {
    out: BufWriter<File>,
    part: PathBuf,
    place: PathBuf,
    /// Bytes before what the finished file has: the line that says which sweep it is, unless it is a part, where that stays.
    head: u64,
    /// Bytes of that line.
    mark: u64,
    done: usize,
    /// The runs that it is to have.
    runs: Range<usize>,
}

/// Why a table cannot be continued.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct RecordError(pub String);

/// Begins a table with the line of names.
///
/// # Errors
/// `out` cannot be written.
pub fn begin(out: &mut impl Write, sweep: &Sweep) -> io::Result<()> {
    writeln!(out, "{}", heading(sweep))
}

/// Writes outcomes from run `first` on, and hands them over to the operating system.
///
/// # Errors
/// `out` cannot be written.
pub fn write(out: &mut impl Write, sweep: &Sweep, first: usize, outcomes: &[Outcome]) -> io::Result<()> {
    let factors = factors(sweep);
    for (index, outcome) in outcomes.iter().enumerate() {
        writeln!(out, "{}", row(sweep, &factors, first + index, outcome))?;
    }
    out.flush()
}

impl SweepRecord {
    /// Begins the table, or continues one that was stopped.
    ///
    /// # Errors
    /// There is one of another sweep or one that is not to be continued, or a file cannot be written.
    pub fn open(place: &Path, sweep: &Sweep, resume: bool) -> Result<Self, RecordError> {
        let mut name = place.as_os_str().to_owned();
        name.push(".part");
        let part = PathBuf::from(name);
        let failed = |error: io::Error| RecordError(format!("cannot write `{}`: {error}", (part.clone()).display()));
        let first = format!("# {}\n", fingerprint(sweep));
        // The mark of a part stays: `join` reads it.
        let mark = first.len() as u64;
        let head = if sweep.part.is_whole() { mark } else { 0 };
        if !part.exists() {
            let file = OpenOptions::new().read(true).write(true).create_new(true).open(&part).map_err(failed)?;
            let mut out = BufWriter::new(file);
            out.write_all(first.as_bytes()).map_err(failed)?;
            begin(&mut out, sweep).and_then(|()| out.flush()).map_err(failed)?;
            return Ok(SweepRecord {
                out,
                part,
                place: place.to_owned(),
                head,
                mark,
                done: sweep.runs().start,
                runs: sweep.runs(),
            });
        }
        if !resume {
            return Err(RecordError(format!(
                "`{}` has the rows of a sweep that was stopped: continue it with --resume, or remove it",
                part.display()
            )));
        }
        let mut file = OpenOptions::new().read(true).write(true).open(&part).map_err(failed)?;
        let Some((done, end)) = kept(&file, &first, sweep).map_err(failed)? else {
            return Err(RecordError(format!(
                "`{}` is of another sweep: scene, runs, outputs or times differ; remove it, or choose another file",
                part.display()
            )));
        };
        // A last line that was cut off is written anew.
        file.set_len(end).and_then(|()| file.seek(SeekFrom::Start(end))).map_err(failed)?;
        Ok(SweepRecord {
            out: BufWriter::new(file),
            part,
            place: place.to_owned(),
            head,
            mark,
            done,
            runs: sweep.runs(),
        })
    }

    /// The run that comes next: all before it in this part have been kept.
    pub fn done(&self) -> usize {
        self.done
    }

    /// Those that have been kept, read again.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn outcomes(&self, sweep: &Sweep) -> Result<Vec<Outcome>, RecordError> {
        let failed =
            |error: io::Error| RecordError(format!("cannot write `{}`: {error}", (self.part.clone()).display()));
        let mut reader = ReaderBuilder::new();
        // The first line says which sweep it is, the next one names the columns.
        let reader = reader.comment(Some(b'#')).flexible(true).from_path(&self.part);
        let reader = reader.map_err(|error| failed(error.into()))?;
        let factors = factors(sweep);
        // The number of the run and its parameters come first.
        let (given, factors) = (1 + sweep.design.factors().len(), &factors[sweep.design.factors().len()..]);
        let outcome = |row: csv::Result<StringRecord>| {
            let row = row.map_err(|error| failed(error.into()))?;
            match row.get(given + factors.len()) {
                Some(failure) if !failure.is_empty() => {
                    return Ok(Err(OutcomeError(failure.to_string())));
                }
                _ => {}
            }
            let values = row.iter().skip(given).zip(factors).map(|(field, by)| Ok(field.parse::<f64>()? * by));
            let values: Result<Vec<f64>, std::num::ParseFloatError> = values.collect();
            values.map(Ok).map_err(|error| failed(io::Error::new(io::ErrorKind::InvalidData, error)))
        };
        reader.into_records().take(self.done - self.runs.start).map(outcome).collect()
    }

    /// Keeps outcomes.
    pub fn write(&mut self, sweep: &Sweep, first: usize, outcomes: &[Outcome]) -> io::Result<()> {
        self.done = first + outcomes.len();
        write(&mut self.out, sweep, first, outcomes)
    }

    /// Puts the finished table in its place.
    pub fn finish(self) -> Result<(), RecordError> {
        let failed =
            |error: io::Error| RecordError(format!("cannot write `{}`: {error}", (self.place.clone()).display()));
        let mut draft = Draft::new(&self.place).map_err(failed)?;
        let mut file = self.out.into_inner().map_err(|error| failed(error.into_error()))?;
        file.seek(SeekFrom::Start(self.head)).map_err(failed)?;
        if self.head == 0 {
            sealed(&file, &mut draft).map_err(failed)?;
            file.seek(SeekFrom::Start(self.mark)).map_err(failed)?;
        }
        io::copy(&mut file, &mut draft).and_then(|_| draft.commit()).map_err(failed)?;
        drop(file); // an open file cannot be removed everywhere
        fs::remove_file(&self.part).map_err(failed)
    }

    /// Where the rows are until then.
    pub fn part(&self) -> &Path {
        &self.part
    }
}

/// The first line of a finished part: with a digest of its rows, by which `join` sees that they are those that were written.
fn sealed(file: &File, out: &mut impl Write) -> io::Result<()> {
    let (mut lines, mut line, mut digest) = (BufReader::new(file), Vec::new(), Digest::default());
    lines.read_until(b'\n', &mut line)?;
    let mark = String::from_utf8_lossy(&line).trim_end().to_owned();
    line.clear();
    while lines.read_until(b'\n', &mut line)? > 0 {
        digest.add(&line);
        line.clear();
    }
    writeln!(out, "{mark}{ROWS}{:016x}", digest.0)
}

/// How many rows of this sweep a file has, and where the last one ends.
fn kept(file: &File, first: &str, sweep: &Sweep) -> io::Result<Option<(usize, u64)>> {
    let factors = factors(sweep);
    let mut lines = BufReader::new(file);
    let runs = sweep.runs();
    let (mut line, mut end, mut done) = (Vec::new(), 0, runs.start);
    for expected in [first.to_owned(), format!("{}\n", heading(sweep))] {
        line.clear();
        end += lines.read_until(b'\n', &mut line)? as u64;
        if line != expected.as_bytes() {
            return Ok(None);
        }
    }
    loop {
        line.clear();
        let length = lines.read_until(b'\n', &mut line)?;
        if line.last() != Some(&b'\n') {
            return Ok(Some((done, end)));
        }
        if done == runs.end || !line.starts_with(given(sweep, &factors, done).as_bytes()) {
            return Ok(None);
        }
        end += length as u64;
        done += 1;
    }
}

fn heading(sweep: &Sweep) -> String {
    let columns: Vec<String> = sweep.columns().iter().map(|column| field(column)).collect();
    format!("run,{},failure", columns.join(","))
}

fn factors(sweep: &Sweep) -> Vec<f64> {
    sweep.shown().iter().map(|unit| unit.factor).collect()
}

/// Number and parameters of a run, with the comma behind them.
fn given(sweep: &Sweep, factors: &[f64], run: usize) -> String {
    let values = sweep.design.values(run);
    let values: String = values.iter().zip(factors).map(|(value, factor)| format!("{:?},", value / factor)).collect();
    format!("{run},{values}")
}

fn row(sweep: &Sweep, factors: &[f64], run: usize, outcome: &Outcome) -> String {
    let mut line = given(sweep, factors, run);
    let factors = &factors[sweep.design.factors().len()..];
    match outcome {
        Ok(values) => {
            values.iter().zip(factors).for_each(|(value, factor)| line.push_str(&format!("{:?},", value / factor)));
        }
        Err(failure) => {
            line.push_str(&",".repeat(sweep.measures.len()));
            // One line a run: whoever counts lines counts runs.
            line.push_str(&field(&failure.to_string().replace(['\n', '\r'], " ")));
        }
    }
    line
}

/// Names the sweep: the same scene, times, measures and runs.
fn fingerprint(sweep: &Sweep) -> String {
    let cotree::model::Experiment { start, stop, step, tolerance } = sweep.experiment;
    let (guid, runs) = (&sweep.compiled.program.guid, sweep.design.len());
    let mark =
        format!("sweep of {guid}: {runs} runs, {start:?} s to {stop:?} s by {step:?} s, tolerance {tolerance:?}");
    match sweep.part.is_whole() {
        true => mark,
        // Parts lie apart, so that their rows cannot tell whether the runs are the same.
        false => format!("{mark}, values {:016x}, part {}", sweep.design.digest(), sweep.part),
    }
}
