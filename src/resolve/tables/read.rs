//! Two columns of a file, in SI.

use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Span;
use crate::model::Exponents;
use crate::sheet::{Sheet, SheetError};

/// How tables are written.
const FORM: &str = "a table has two columns of numbers, the first increasing: `0.5, 12.3`; names and units may stand above them: `angle [deg], lift [mm]`";

/// Two columns in SI.
#[derive(Clone, Debug)]
pub(in crate::resolve) struct Table {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// The units of both, if they are said.
    pub units: [Option<Exponents>; 2],
    /// Where each row is written; empty if in no text that is known.
    pub places: Vec<Span>,
}

impl Table {
    /// The table in a text; `start` is where that begins in the source.
    pub fn read(file: &str, text: &str, start: Option<usize>) -> Result<Table, Fault> {
        if !text.lines().any(is_of_numbers) && !text.trim().is_empty() {
            // It may be any file of this machine: nothing of it is shown to whoever has sent the scene.
            let message = format!("`{file}` is not a table: it has no line of numbers");
            return Err(Fault::new("scene::bad_table", message, Span::default()).help(FORM));
        }
        let lines = LinePlaces::of(text, start);
        let faulty = |SheetError { line, column, message }| {
            Fault::new(
                "scene::bad_table",
                format!("line {line} of `{file}`, column {column}: {message}"),
                lines.of_line(line),
            )
            .label("this line")
            .help(FORM)
        };
        let sheet = Sheet::read(text).map_err(faulty)?;
        if sheet.rows() == 0 {
            return Err(Fault::new("scene::bad_table", format!("`{file}` has no rows"), Span::default()));
        }
        let places = (0..sheet.rows()).filter(|_| start.is_some()).map(|row| lines.of_line(sheet.line(row))).collect();
        let [x, y] = columns(&sheet).map_err(faulty)?;
        Ok(Table { x: x.0, y: y.0, units: [x.1, y.1], places })
    }

    /// Where a row is written.
    pub fn place(&self, row: usize) -> Option<Span> {
        self.places.get(row).copied()
    }
}

/// True for a line of numbers, in any of the ways in which tables are written.
fn is_of_numbers(line: &str) -> bool {
    let is_of_number = |sign: char| sign.is_ascii_digit() || "+-.,;eE\t \"'".contains(sign);
    line.contains(|sign: char| sign.is_ascii_digit()) && line.chars().all(is_of_number)
}

/// Numbers in SI, and their unit if it is said.
type Column = (Vec<f64>, Option<Exponents>);

fn columns(sheet: &Sheet) -> Result<[Column; 2], SheetError> {
    let (mut columns, mut factors): ([Column; 2], [f64; 2]) = (Default::default(), [1.0; 2]);
    for (place, heading) in sheet.headings().iter().enumerate() {
        let (_, unit) = heading.read()?;
        let Some(column) = columns.get_mut(place) else {
            return Err(heading.fault("a third column, but a table has two"));
        };
        column.1 = unit.as_ref().map(|unit| unit.exponents);
        factors[place] = unit.and_then(|unit| unit.display).map_or(1.0, |display| display.factor);
    }
    for row in 0..sheet.rows() {
        sheet.has_cells(row, 2)?;
        for (place, column) in columns.iter_mut().enumerate() {
            column.0.push(sheet.number(row, place)? * factors[place]);
        }
        if let [.., before, last] = columns[0].0[..]
            && last <= before
        {
            let what = "the numbers of the first column must increase";
            return Err(SheetError { line: sheet.line(row), column: 1, message: what.to_owned() });
        }
    }
    Ok(columns)
}

/// Where the lines of a file stand in the source.
struct LinePlaces(Vec<Span>);

impl LinePlaces {
    fn of(text: &str, start: Option<usize>) -> LinePlaces {
        let mut offset = start.unwrap_or(0);
        let place = |line: &str| {
            let place = Span::new(offset, offset + line.trim_end().len());
            offset += line.len();
            place
        };
        let break_ = if text.contains('\n') { '\n' } else { '\r' };
        LinePlaces(if start.is_some() { text.split_inclusive(break_).map(place).collect() } else { Vec::new() })
    }

    /// Nowhere if the text is not known.
    fn of_line(&self, line: usize) -> Span {
        line.checked_sub(1).and_then(|index| self.0.get(index)).copied().unwrap_or_default()
    }
}
