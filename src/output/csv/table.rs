//! Values over time, read from a file.

use std::collections::HashSet;

#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    names: Vec<String>,
    time: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

/// A fault of a table and its place. Lines and columns count from 1; columns are fields.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("line {line}, column {column}: {message}")]
pub struct TableError {
    pub line: usize,
    pub column: usize,
    pub message: String,
}

type Row = (usize, Vec<String>);

impl Table {
    /// Reads `time,name,...` and rows of numbers whose times do not decrease. Two rows with the same time are a jump.
    ///
    /// # Errors
    /// The first thing that is wrong, with its place.
    pub fn parse(text: &str) -> Result<Self, TableError> {
        let mut rows = rows(text.strip_prefix('\u{feff}').unwrap_or(text))?.into_iter();
        let header = rows.next().ok_or_else(|| fault(1, 1, "the table is empty; begin with `time,name`"))?;
        let names = names(header)?;
        let mut table = Self { columns: vec![Vec::new(); names.len()], names, time: Vec::new() };
        for row in rows {
            table.push(row)?;
        }
        if table.time.is_empty() {
            return Err(fault(2, 1, "the table has no rows"));
        }
        Ok(table)
    }

    /// A table of these columns.
    ///
    /// # Errors
    /// Columns of other lengths than `time`, no rows, numbers that are not finite, times that decrease.
    pub fn new(names: Vec<String>, time: Vec<f64>, columns: Vec<Vec<f64>>) -> Result<Self, String> {
        if time.is_empty() {
            return Err("the table has no rows".to_owned());
        }
        if names.len() != columns.len() {
            return Err(format!("{} names for {} columns", names.len(), columns.len()));
        }
        for (name, column) in names.iter().zip(&columns) {
            if column.len() != time.len() {
                return Err(format!("`{name}` has {} values at {} times", column.len(), time.len()));
            }
        }
        let finite = |column: &Vec<f64>| column.iter().all(|value| value.is_finite());
        if let Some(name) = names.iter().zip(&columns).find(|(_, column)| !finite(column)).map(|(name, _)| name) {
            return Err(format!("`{name}` has a value that is not finite"));
        }
        if !finite(&time) || time.windows(2).any(|pair| pair[1] < pair[0]) {
            return Err("the times are not finite and ascending".to_owned());
        }
        Ok(Self { names, time, columns })
    }

    /// The columns' names, without `time`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    pub fn times(&self) -> &[f64] {
        &self.time
    }

    /// Value and rate of a column just after a time. Before the first row and after the last the value is constant.
    pub fn at(&self, column: usize, time: f64) -> (f64, f64) {
        let Some(values) = self.columns.get(column) else {
            return (f64::NAN, f64::NAN);
        };
        let next = self.time.partition_point(|&row| row <= time);
        let before = next.checked_sub(1).map(|row| (self.time[row], values[row]));
        let after = self.time.get(next).map(|&row| (row, values[next]));
        match (before, after) {
            (Some((t0, v0)), Some((t1, v1))) => {
                let rate = (v1 - v0) / (t1 - t0);
                (v0 + rate * (time - t0), rate)
            }
            (Some((_, value)), None) | (None, Some((_, value))) => (value, 0.0),
            (None, None) => (f64::NAN, f64::NAN),
        }
    }

    fn push(&mut self, (line, fields): Row) -> Result<(), TableError> {
        if fields.len() != self.names.len() + 1 {
            let (found, wanted) = (fields.len(), self.names.len() + 1);
            return Err(fault(line, found.min(wanted), format!("{found} fields, but the header has {wanted}")));
        }
        for (index, field) in fields.iter().enumerate() {
            let value = number(line, index + 1, field)?;
            match index.checked_sub(1) {
                Some(column) => self.columns[column].push(value),
                None if self.time.last().is_some_and(|&last| value < last) => {
                    return Err(fault(line, 1, format!("time {value:?} is earlier than in the row before")));
                }
                None => self.time.push(value),
            }
        }
        Ok(())
    }
}

/// The header without `time`.
fn names((line, fields): Row) -> Result<Vec<String>, TableError> {
    let names: Vec<String> = fields.iter().map(|field| field.trim().to_owned()).collect();
    if names[0] != "time" {
        let hint = if names[0].contains([';', '\t']) { "; separate the columns with commas" } else { "" };
        return Err(fault(line, 1, format!("the first column is `{}`, not `time`{hint}", names[0])));
    }
    let mut seen = HashSet::new();
    for (index, name) in names.iter().enumerate() {
        if name.is_empty() {
            return Err(fault(line, index + 1, "the column has no name"));
        }
        if !seen.insert(name) {
            return Err(fault(line, index + 1, format!("there are two columns `{name}`")));
        }
    }
    Ok(names[1..].to_vec())
}

fn number(line: usize, column: usize, field: &str) -> Result<f64, TableError> {
    let value = field.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| fault(line, column, format!("`{}` is not a finite number", field.trim())))
}

fn fault(line: usize, column: usize, message: impl Into<String>) -> TableError {
    TableError { line, column, message: message.into() }
}

/// The rows of a text as fields, each with the line it begins on; empty lines are skipped.
///
/// # Errors
/// A quote that is not closed or stands in the middle of a field.
pub fn records(text: &str) -> Result<Vec<Row>, TableError> {
    rows(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// The rows of a text, each with the line it begins on; empty lines are skipped.
fn rows(text: &str) -> Result<Vec<Row>, TableError> {
    let mut rows = Vec::new();
    let mut lines = text.split('\n').enumerate().map(|(index, line)| (index + 1, line));
    while let Some((line, first)) = lines.next() {
        let mut record = first.to_owned();
        // A line break inside quotes belongs to the field.
        let mut quotes = first.matches('"').count();
        while quotes % 2 == 1 {
            let (_, next) = lines.next().ok_or_else(|| fault(line, 1, "a quote is not closed"))?;
            quotes += next.matches('"').count();
            record.push('\n');
            record.push_str(next);
        }
        let record = record.strip_suffix('\r').unwrap_or(&record);
        if !record.trim().is_empty() {
            rows.push((line, fields(record, line)?));
        }
    }
    Ok(rows)
}

/// The fields of a record, without their quotes.
fn fields(record: &str, line: usize) -> Result<Vec<String>, TableError> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    let mut characters = record.chars().peekable();
    while let Some(c) = characters.next() {
        let column = fields.len();
        let Some(field) = fields.last_mut() else {
            break;
        };
        match c {
            '"' if quoted && characters.peek() == Some(&'"') => {
                characters.next();
                field.push('"');
            }
            '"' if quoted => quoted = false,
            '"' if field.trim().is_empty() => {
                field.clear();
                quoted = true;
            }
            '"' => return Err(fault(line, column, "a quote in the middle of a field")),
            ',' if !quoted => fields.push(String::new()),
            c => field.push(c),
        }
    }
    Ok(fields)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_rows_and_held_outside() {
        let table = Table::parse("time,a\n1,10\n3,20\n4,0\n").unwrap();
        assert_eq!(table.at(0, 0.0), (10.0, 0.0));
        assert_eq!(table.at(0, 1.0), (10.0, 5.0));
        assert_eq!(table.at(0, 2.0), (15.0, 5.0));
        assert_eq!(table.at(0, 3.0), (20.0, -20.0));
        assert_eq!(table.at(0, 4.0), (0.0, 0.0));
        assert_eq!(table.at(0, 9.0), (0.0, 0.0));
    }

    #[test]
    fn two_rows_at_one_time_are_a_jump() {
        let table = Table::parse("time,a\n0,1\n1,1\n1,5\n2,5\n").unwrap();
        assert_eq!(table.at(0, 0.999), (1.0, 0.0));
        assert_eq!(table.at(0, 1.0), (5.0, 0.0));
    }

    #[test]
    fn spreadsheets_are_read() {
        let table = Table::parse("\u{feff}time, \"gas, force\"\r\n0, 1e3\r\n\r\n1,\"-2\"\r\n").unwrap();
        assert_eq!(table.names(), ["gas, force"]);
        assert_eq!(table.at(0, 1.0).0, -2.0);
    }

    #[test]
    fn a_header_may_be_wide() {
        let names: Vec<String> = (0..200_000).map(|column| format!("c{column}")).collect();
        let (header, row) = (names.join(","), vec!["1"; names.len()].join(","));
        assert_eq!(Table::parse(&format!("time,{header}\n0,{row}\n")).unwrap().names(), names);
        let fault = Table::parse(&format!("time,{header},c7\n")).unwrap_err();
        assert_eq!((fault.column, fault.message.as_str()), (names.len() + 2, "there are two columns `c7`"));
    }

    #[test]
    fn faults_say_where() {
        let cases = [
            ("", 1, 1, "empty"),
            ("t,a\n", 1, 1, "`t`, not `time`"),
            ("time;a\n0;1\n", 1, 1, "commas"),
            ("time,a,a\n0,1,2\n", 1, 3, "two columns `a`"),
            ("time,a,\n", 1, 3, "no name"),
            ("time,a\n", 2, 1, "no rows"),
            ("time,a\n0,1\n1,x\n", 3, 2, "`x` is not a finite number"),
            ("time,a\n0,NaN\n", 2, 2, "finite"),
            ("time,a\n0\n", 2, 1, "1 fields"),
            ("time,a\n0,1,2\n", 2, 2, "3 fields"),
            ("time,a\n1,0\n0.5,0\n", 3, 1, "earlier"),
            ("time,a\n0,\"1\n", 2, 1, "not closed"),
            ("time,a\n0,1\"2\"\n", 2, 2, "middle"),
        ];
        for (text, line, column, message) in cases {
            let error = Table::parse(text).unwrap_err();
            assert_eq!((error.line, error.column), (line, column), "{text:?}: {error}");
            assert!(error.message.contains(message), "{text:?}: {error}");
        }
    }
}
