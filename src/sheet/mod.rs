//! Tables as people write them: rows of cells under names and units, in the ways of spreadsheets, measuring instruments and other programs. All that is
//! read from files with columns is read here.

mod decimal;
mod heading;
mod lines;

use csv::{ReaderBuilder, StringRecord};

use crate::diagnostic::span::Text;
use crate::scene::quantity::number_length;
use crate::scene::unit;
use decimal::Decimal;
pub use heading::Heading;
use lines::SheetLines;

/// A fault of a table and its place. Lines and columns count from 1; columns are cells.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("line {line}, column {column}: {message}")]
pub struct SheetError {
    pub line: usize,
    pub column: usize,
    pub message: String,
}

impl SheetError {
    pub(crate) fn new(line: usize, column: usize, message: impl Into<String>) -> Self {
        SheetError { line, column, message: message.into() }
    }
}

/// A table as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// What stands above the columns; empty if nothing does.
    headings: Vec<Heading>,
    rows: Vec<Row>,
    decimal: Decimal,
}

/// The cells of a row, and the line that it begins on.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    line: usize,
    cells: StringRecord,
}

impl Row {
    /// Without the blanks around it; empty if there is none.
    fn cell(&self, column: usize) -> &str {
        self.cells.get(column).unwrap_or_default().trim()
    }

    fn is_empty(&self) -> bool {
        self.cells.iter().all(|cell| cell.trim().is_empty())
    }

    /// Has it words, and no numbers?
    fn is_words(&self) -> bool {
        !self.is_empty() && !self.cells.iter().any(is_number)
    }
}

impl Sheet {
    /// Reads a table whose columns are separated by semicolons, tabs, commas or blanks, whichever its first line has in this order. A first row without a number has the names,
    /// a second one the units; so does the comment (`#`) just above the numbers. Empty rows, and a last column that is empty everywhere, count for nothing.
    ///
    /// # Errors
    /// A quotation mark that is not closed or stands within a cell, or numbers of which the decimal sign is not clear.
    pub fn read(text: &str) -> Result<Self, SheetError> {
        let lines = SheetLines::of(text)?;
        let mut rows = rows(&lines)?;
        let width = rows.iter().map(|row| row.cells.len()).max().unwrap_or(0);
        if width > 1 && rows.iter().all(|row| row.cell(width - 1).is_empty()) {
            rows.iter_mut().filter(|row| row.cells.len() == width).for_each(|row| row.cells.truncate(width - 1));
        }
        let names = match rows.first() {
            Some(first) if first.is_words() => Some(rows.remove(0)),
            Some(first) => commented(&lines, first.cells.len()),
            None => None,
        };
        let units = (names.is_some() && rows.first().is_some_and(Row::is_words)).then(|| rows.remove(0));
        let headings = names.map_or_else(Vec::new, |names| heading::all(&names, units.as_ref()));
        let decimal = Decimal::of(&rows, lines.separator)?;
        Ok(Sheet { headings, rows, decimal })
    }

    /// What stands above the columns; empty if nothing does.
    pub fn headings(&self) -> &[Heading] {
        &self.headings
    }

    /// How many rows there are beneath the headings.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// The line that a row begins on.
    pub fn line(&self, row: usize) -> usize {
        self.rows.get(row).map_or(0, |row| row.line)
    }

    /// Has a row so many cells?
    ///
    /// # Errors
    /// It has others.
    pub fn has_cells(&self, row: usize, wanted: usize) -> Result<(), SheetError> {
        let Some(Row { line, cells }) = self.rows.get(row) else { return Ok(()) };
        let (found, of) = (cells.len(), if self.headings.is_empty() { "table" } else { "header" });
        if found == wanted {
            return Ok(());
        }
        Err(SheetError::new(*line, found.min(wanted), format!("{found} fields, but the {of} has {wanted}")))
    }

    /// A cell, with a point for its decimal sign.
    pub fn cell(&self, row: usize, column: usize) -> String {
        self.rows.get(row).map_or_else(String::new, |row| self.decimal.plain(row.cell(column)))
    }

    /// The number in a cell.
    ///
    /// # Errors
    /// It is empty, or something else, or not finite.
    pub fn number(&self, row: usize, column: usize) -> Result<f64, SheetError> {
        let text = self.cell(row, column);
        let fault = |what: String| Err(SheetError::new(self.line(row), column + 1, what));
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => fault(format!("`{text}` is not a finite number")),
            Err(_) if text.is_empty() => fault("the cell is empty; give a number, or remove the row".to_owned()),
            Err(_) => fault(format!("`{text}` is not a number")),
        }
    }
}

/// The rows that are not empty.
fn rows(lines: &SheetLines) -> Result<Vec<Row>, SheetError> {
    let mut reader = ReaderBuilder::new();
    let reader = reader.has_headers(false).flexible(true).delimiter(lines.separator);
    let mut reader = reader.from_reader(lines.text.as_bytes());
    let mut rows = Vec::with_capacity(lines.numbers.len());
    for (cells, &line) in reader.records().zip(&lines.numbers) {
        let cells = cells.map_err(|error| SheetError::new(line, 1, error.to_string()))?;
        rows.push(Row { line, cells });
    }
    rows.retain(|row| !row.is_empty());
    Ok(rows)
}

/// The names in the comment just above the first row, if it has as many words as that has cells.
fn commented(lines: &SheetLines, width: usize) -> Option<Row> {
    let (line, comment) = lines.comment.as_ref()?;
    // What cannot be read as a row is a comment and nothing else.
    let cells = lines.only(*line, comment).ok()?;
    rows(&cells).ok()?.into_iter().next().filter(|row| row.cells.len() == width && row.is_words())
}

/// Is it one, alone or with its unit?
fn is_number(cell: &str) -> bool {
    let cell = cell.trim().replacen(',', ".", 1);
    let bare = cell.trim_start_matches(['+', '-']);
    let unit = number_length(bare).map(|length| bare[length..].trim());
    cell.parse::<f64>().is_ok() || unit.is_some_and(|unit| unit::parse(&Text::from(unit)).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str) -> Result<Vec<Vec<f64>>, SheetError> {
        let sheet = Sheet::read(text)?;
        let row = |row: usize| (0..2).map(|column| sheet.number(row, column)).collect();
        (0..sheet.rows()).map(row).collect()
    }

    #[test]
    fn one_table_in_many_ways() {
        let wanted = vec![vec![0.0, -1.5], vec![0.25, 20.0]];
        for text in [
            "0,-1.5\n0.25,20\n",
            "\u{feff}time,lift\r\n0, -1.5 \r\n\r\n .25,\"20\"\r\n",
            "time;lift\n0;-1,5\n0,25;20\n",
            "time;lift;\n0;-1,5;\n0,25;2e1;\n;;\n",
            "time;lift\ns;mm\n0;-1,5\n0,25;20\n",
            "\"time\"\t\"lift\"\n0\t-1,5\n0,25\t2E+1\n",
            "# made by hand, in May\n# time lift\n  0   -1.5\n# once more\n 0.25 20\n",
            "Time (s) Lift (mm)\n0 -1,5\n0,25 20\n",
            "0,0 -1,5\n0,25 20\n",
            "time,lift\n0,\"-1,5\"\n\"0,25\",20\n",
            "time,lift\r0,-1.5\r0.25,20\r",
            "a , \"b, \"\"c\"\"\"\n0,-1.5\n0.25,20",
        ] {
            assert_eq!(numbers(text).as_ref(), Ok(&wanted), "{text:?}");
        }
    }

    #[test]
    fn faults_say_where() {
        for (text, line, column, message) in [
            ("a,b\n0,\"1\n", 2, 1, "not closed"),
            ("a,b\n0,1\"2\"\n", 2, 2, "middle"),
            ("a,b\n0,\"1\"2\n", 2, 2, "after"),
            ("a,b\n\n0,1\n1,\n", 4, 2, "empty"),
            ("a,b\n0,1\n\n1,x\n", 4, 2, "`x` is not a number"),
            ("x,1\n2,3\n", 1, 1, "`x` is not a number"),
            ("0,1\n1,1e999\n", 2, 2, "finite"),
            ("0\t1,234\n1\t2,345\n", 1, 2, "1234 or 1.234"),
            ("0,\"1,234\"\n", 1, 2, "1234 or 1.234"),
            ("a;b\n0;1,5\n1;2.5\n", 3, 2, "decimal"),
            ("a;b\n0;1.234,5\n", 2, 2, "not a number"),
        ] {
            let error = numbers(text).unwrap_err();
            assert_eq!((error.line, error.column), (line, column), "{text:?}: {error}");
            assert!(error.message.contains(message), "{text:?}: {error}");
        }
    }
}
