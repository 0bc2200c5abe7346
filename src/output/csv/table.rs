//! Values over time, read from a file.

use std::collections::HashSet;

use crate::diagnostic::span::Text;
use crate::mechanism::Unit;
use crate::scene::unit;

#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    names: Vec<String>,
    /// The units that the header names.
    units: Vec<Option<Unit>>,
    time: Vec<f64>,
    columns: Vec<Vec<f64>>,
    layout: Layout,
}

/// How the rows are to be read.
#[derive(Clone, Debug, PartialEq)]
struct Layout {
    separator: char,
    /// The place of the time.
    time: usize,
    /// SI value of one in each column, that of the time too.
    factors: Vec<f64>,
}

/// A fault of a table and its place. Lines and columns count from 1; columns are fields.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("line {line}, column {column}: {message}")]
pub struct TableError {
    pub line: usize,
    pub column: usize,
    pub message: String,
}

type CsvRow = (usize, Vec<String>);

impl Table {
    /// Reads `time,name,...` and rows of numbers whose times do not decrease. Two rows with the same time are a jump. The columns may be
    /// in any order, and have units, as in `gas_force [kN]`: the values of the table are SI. Between the columns there are commas,
    /// semicolons (then the decimal sign may be a comma) or tabs.
    ///
    /// # Errors
    /// The first thing that is wrong, with its place.
    pub fn parse(text: &str) -> Result<Self, TableError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let separator = separator(text);
        let mut rows = rows(text, separator)?.into_iter();
        let header = rows.next().ok_or_else(|| fault(1, 1, "the table is empty; begin with `time,name`"))?;
        let mut table = Self::of_header(header, separator)?;
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
        let layout = Layout { separator: ',', time: 0, factors: vec![1.0; names.len() + 1] };
        Ok(Self { units: vec![None; names.len()], names, time, columns, layout })
    }

    /// An empty table.
    fn of_header((line, fields): CsvRow, separator: char) -> Result<Self, TableError> {
        let named = fields.iter().enumerate().map(|(index, field)| name_and_unit(line, index + 1, field));
        let mut named: Vec<(String, Option<Unit>)> = named.collect::<Result<_, _>>()?;
        let factor =
            |unit: &Option<Unit>| unit.as_ref().and_then(|unit| unit.display.as_ref()).map_or(1.0, |d| d.factor);
        let factors = named.iter().map(|(_, unit)| factor(unit)).collect();
        let is_time = |name: &str| name == "time" || name == "t";
        let Some(time) = named.iter().position(|(name, _)| is_time(name)) else {
            return Err(fault(line, 1, format!("no column is `time`; the first is `{}`", named[0].0)));
        };
        let (_, unit) = named.remove(time);
        if let Some(unit) = unit.filter(|unit| unit.exponents != Unit::time().exponents) {
            return Err(fault(line, time + 1, format!("the time is in `{}`, which is no unit of time", unit.shown())));
        }
        let mut seen = HashSet::new();
        for (index, (name, _)) in named.iter().enumerate() {
            let column = index + 1 + usize::from(index >= time);
            if name.is_empty() {
                return Err(fault(line, column, "the column has no name"));
            }
            if !seen.insert(name) || is_time(name) {
                return Err(fault(line, column, format!("there are two columns `{name}`")));
            }
        }
        let columns = vec![Vec::new(); named.len()];
        let (names, units) = named.into_iter().unzip();
        Ok(Self { names, units, time: Vec::new(), columns, layout: Layout { separator, time, factors } })
    }

    /// The columns' names, without `time`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The units that the header names, without that of the time.
    pub fn units(&self) -> &[Option<Unit>] {
        &self.units
    }

    /// The values of a column, one for each time, in SI if the header names a unit.
    pub fn column(&self, column: usize) -> &[f64] {
        &self.columns[column]
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

    /// Rate of a column just before a time.
    pub fn rate_before(&self, column: usize, time: f64) -> f64 {
        let Some(values) = self.columns.get(column) else { return f64::NAN };
        match self.time.partition_point(|&row| row < time) {
            next if next > 0 && next < values.len() => {
                (values[next] - values[next - 1]) / (self.time[next] - self.time[next - 1])
            }
            _ => 0.0,
        }
    }

    fn push(&mut self, (line, fields): CsvRow) -> Result<(), TableError> {
        let Layout { separator, time, ref factors } = self.layout;
        if fields.len() != factors.len() {
            let (found, wanted) = (fields.len(), factors.len());
            return Err(fault(line, found.min(wanted), format!("{found} fields, but the header has {wanted}")));
        }
        for (index, (field, factor)) in fields.iter().zip(factors).enumerate() {
            let value = number(line, index + 1, field, separator)? * factor;
            if index != time {
                self.columns[index - usize::from(index > time)].push(value);
            } else if self.time.last().is_some_and(|&last| value < last) {
                return Err(fault(line, index + 1, format!("time {value:?} is earlier than in the row before")));
            } else {
                self.time.push(value);
            }
        }
        Ok(())
    }
}

/// What is between the columns of a table: the first of `;`, tab and `,` that its header has outside of quotes.
fn separator(text: &str) -> char {
    let header = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    let outside: String = header.split('"').step_by(2).collect();
    [';', '\t'].into_iter().find(|separator| outside.contains(*separator)).unwrap_or(',')
}

/// `gas_force [kN]`
fn name_and_unit(line: usize, column: usize, field: &str) -> Result<(String, Option<Unit>), TableError> {
    let field = field.trim();
    let Some((name, unit)) = field.strip_suffix(']').and_then(|field| field.rsplit_once('[')) else {
        return Ok((field.to_owned(), None));
    };
    // A pure number may be said to have the unit 1, or none.
    let name = name.trim().to_owned();
    if matches!(unit.trim(), "" | "1" | "-") {
        return Ok((name, None));
    }
    match unit::parse(&Text::from(unit.trim())) {
        Ok(unit) => Ok((name, Some(unit))),
        Err(wrong) => Err(fault(line, column, format!("{}; {}", wrong.message, wrong.help))),
    }
}

fn number(line: usize, column: usize, field: &str, separator: char) -> Result<f64, TableError> {
    let field = field.trim();
    let value = plain(field, separator).parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| fault(line, column, format!("`{field}` is not a finite number")))
}

fn fault(line: usize, column: usize, message: impl Into<String>) -> TableError {
    TableError { line, column, message: message.into() }
}

/// The fields of a text, whatever they mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// Fields, and the line each row begins on; empty lines are skipped.
    pub rows: Vec<CsvRow>,
    separator: char,
}

impl Cells {
    /// Reads a table whose columns are separated by commas, semicolons or tabs.
    ///
    /// # Errors
    /// A quote that is not closed or stands in the middle of a field.
    pub fn read(text: &str) -> Result<Self, TableError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let separator = separator(text);
        Ok(Cells { rows: rows(text, separator)?, separator })
    }

    /// A field without blanks around it and with a point as its decimal sign: between semicolons it may be a comma.
    pub fn plain(&self, field: &str) -> String {
        plain(field.trim(), self.separator)
    }
}

fn plain(field: &str, separator: char) -> String {
    if separator == ';' { field.replacen(',', ".", 1) } else { field.to_owned() }
}

/// The name and the unit of a heading such as `gas_force [kN]`.
///
/// # Errors
/// The unit is none.
pub fn named(heading: &str) -> Result<(String, Option<Unit>), String> {
    name_and_unit(1, 1, heading).map_err(|fault| fault.message)
}

/// The rows of a text, each with the line it begins on; empty lines are skipped.
fn rows(text: &str, separator: char) -> Result<Vec<CsvRow>, TableError> {
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
            rows.push((line, fields(record, line, separator)?));
        }
    }
    Ok(rows)
}

/// The fields of a record, without their quotes.
fn fields(record: &str, line: usize, separator: char) -> Result<Vec<String>, TableError> {
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
            c if c == separator && !quoted => fields.push(String::new()),
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
        assert_eq!([0.0, 1.0, 3.0, 3.5, 4.0, 9.0].map(|t| table.rate_before(0, t)), [0.0, 0.0, 5.0, -20.0, -20.0, 0.0]);
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
    fn columns_have_units_and_stand_in_any_order() {
        let table = Table::parse("gas_force [kN]; time [ms]; share\n1,5; 0; 2\n-2; 500; 3\n").unwrap();
        assert_eq!(
            (table.names(), table.times()),
            (&["gas_force".to_owned(), "share".to_owned()][..], &[0.0, 0.5][..])
        );
        assert_eq!(table.at(0, 0.0), (1500.0, -7000.0));
        assert_eq!((table.at(1, 0.5).0, table.units()[0].as_ref().unwrap().si.as_str()), (3.0, "N"));
        assert_eq!(Table::parse("a\tt [s]\n7\t1\n").unwrap().at(0, 1.0).0, 7.0);
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
            ("x,a\n", 1, 1, "no column is `time`"),
            ("time,t\n0,1\n", 1, 2, "two columns"),
            ("time [mm],a\n0,1\n", 1, 1, "no unit of time"),
            ("time,a [furlong]\n0,1\n", 1, 2, "not a unit"),
            ("time;a\n0;1,2,3\n", 2, 2, "not a finite number"),
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
