//! Values over time, read from a file.

use std::collections::HashSet;

use crate::diagnostic::{Fault, Span, degrees, suggest};
use crate::model::Unit;
use crate::sheet::{Heading, Sheet, SheetError};

#[derive(Clone, Debug, PartialEq)]
pub struct CsvTable {
    names: Vec<String>,
    /// The units that the header names.
    units: Vec<Option<Unit>>,
    time: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

/// Why columns make no table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct TableError(pub String);

/// What the columns of a table stand for.
pub struct Naming<'a> {
    /// The unit of the variable of a name, if there is one.
    pub unit_of: &'a dyn Fn(&str) -> Option<Unit>,
    /// Variables and the headings of their columns; if there are any, no other columns than these and the time are read.
    pub chosen: &'a [(String, String)],
}

/// How the cell of a row and a column is read.
type Reading = fn(&Sheet, usize, usize) -> Result<f64, SheetError>;

/// A column that is read: its place, what it stands for, and the SI value of one in it.
struct SourceColumn {
    place: usize,
    name: String,
    unit: Option<Unit>,
}

impl SourceColumn {
    fn is_time(&self) -> bool {
        is_time(&self.name)
    }

    fn factor(&self) -> f64 {
        self.unit.as_ref().and_then(|unit| unit.display.as_ref()).map_or(1.0, |display| display.factor)
    }
}

fn is_time(name: &str) -> bool {
    name.eq_ignore_ascii_case("time") || name == "t"
}

impl CsvTable {
    /// Reads a [sheet](Sheet::read) with the columns `time` (or `t`) and those of variables, in any order. The times do not decrease; two rows with the same time are a jump. The
    /// values of the table are SI; numbers without a unit are.
    ///
    /// # Errors
    /// The first thing that is wrong, with its place.
    pub fn read(text: &str, naming: &Naming<'_>) -> Result<Self, SheetError> {
        Self::read_cells(text, naming, Sheet::number)
    }

    /// The same, where an empty cell is a value that was not measured: not a number.
    ///
    /// # Errors
    /// As there.
    pub fn read_with_gaps(text: &str, naming: &Naming<'_>) -> Result<Self, SheetError> {
        Self::read_cells(text, naming, |sheet, row, column| {
            if sheet.cell(row, column).is_empty() { Ok(f64::NAN) } else { sheet.number(row, column) }
        })
    }

    fn read_cells(text: &str, naming: &Naming<'_>, value: Reading) -> Result<Self, SheetError> {
        let sheet = Sheet::read(text)?;
        let mut sources = sources(&sheet, naming)?;
        let Some(time) = sources.iter().position(SourceColumn::is_time) else {
            let first = sheet.headings().first().map_or("", |heading| heading.text.as_str());
            return Err(fault(1, 1, format!("no column is `time`; the first is `{first}`")));
        };
        let time = sources.remove(time);
        if let Some(unit) = time.unit.as_ref().filter(|unit| unit.exponents != Unit::time().exponents) {
            let message = format!("the time is in `{}`, which is not a unit of time", unit.shown());
            return Err(sheet.headings()[time.place].fault(message));
        }
        different(&sheet, &sources)?;
        let mut table = CsvTable {
            names: Vec::new(),
            units: Vec::new(),
            time: Vec::new(),
            columns: vec![Vec::new(); sources.len()],
        };
        for row in 0..sheet.rows() {
            table.push(&sheet, row, (&time, &sources), value)?;
        }
        if table.time.is_empty() {
            return Err(fault(2, 1, "the table has no rows"));
        }
        (table.names, table.units) = sources.into_iter().map(|source| (source.name, source.unit)).unzip();
        Ok(table)
    }

    fn push(
        &mut self,
        sheet: &Sheet,
        row: usize,
        (time, sources): (&SourceColumn, &[SourceColumn]),
        value: Reading,
    ) -> Result<(), SheetError> {
        sheet.has_cells(row, sheet.headings().len())?;
        let at = sheet.number(row, time.place)? * time.factor();
        if self.time.last().is_some_and(|&last| at < last) {
            return Err(fault(
                sheet.line(row),
                time.place + 1,
                format!("time {at:?} is earlier than in the previous row"),
            ));
        }
        self.time.push(at);
        for (source, column) in sources.iter().zip(&mut self.columns) {
            column.push(value(sheet, row, source.place)? * source.factor());
        }
        Ok(())
    }

    /// [`CsvTable::read`] where each column is called as its variable.
    ///
    /// # Errors
    /// As there.
    pub fn parse(text: &str) -> Result<Self, SheetError> {
        CsvTable::read(text, &Naming { unit_of: &|_| None, chosen: &[] })
    }

    /// A table of these columns.
    ///
    /// # Errors
    /// Columns of other lengths than `time`, no rows, numbers that are not finite, times that decrease.
    pub fn new(names: Vec<String>, time: Vec<f64>, columns: Vec<Vec<f64>>) -> Result<Self, TableError> {
        let finite = |column: &Vec<f64>| column.iter().all(|value| value.is_finite());
        if let Some(name) = names.iter().zip(&columns).find(|(_, column)| !finite(column)).map(|(name, _)| name) {
            return Err(TableError(format!("`{name}` has a value that is not finite")));
        }
        CsvTable::with_gaps(names, time, columns)
    }

    /// The same, where a value that is not a number is one that was not measured.
    ///
    /// # Errors
    /// Columns of other lengths than `time`, no rows, infinite numbers, times that decrease.
    pub fn with_gaps(names: Vec<String>, time: Vec<f64>, columns: Vec<Vec<f64>>) -> Result<Self, TableError> {
        if time.is_empty() {
            return Err(TableError("the table has no rows".to_owned()));
        }
        if names.len() != columns.len() {
            return Err(TableError(format!("{} names for {} columns", names.len(), columns.len())));
        }
        for (name, column) in names.iter().zip(&columns) {
            let name = || name.clone();
            if column.len() != time.len() {
                return Err(TableError(format!("`{}` has {} values at {} times", name(), column.len(), time.len())));
            }
            if column.iter().any(|value| value.is_infinite()) {
                return Err(TableError(format!("`{name}` has a value that is infinite", name = name())));
            }
        }
        let finite = |column: &Vec<f64>| column.iter().all(|value| value.is_finite());
        if !finite(&time) || time.windows(2).any(|pair| pair[1] < pair[0]) {
            return Err(TableError("the times must be finite and increasing".to_owned()));
        }
        Ok(Self { units: vec![None; names.len()], names, time, columns })
    }

    /// The columns' names, without `time`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The units that the header names, without that of the time.
    pub fn units(&self) -> &[Option<Unit>] {
        &self.units
    }

    /// A warning for each column without a unit that stands for an angle and looks like degrees; `own` is the unit of a variable.
    pub fn suspect_degrees(&self, unit_of: &dyn Fn(&str) -> Option<Unit>) -> Vec<Fault> {
        let is_angle = |name: &str| unit_of(name).is_some_and(|unit| unit.exponents == Unit::angle().exponents);
        let columns = self.names.iter().zip(&self.units).zip(&self.columns);
        let bare = columns.filter(|((name, unit), _)| unit.is_none() && is_angle(name));
        let warning = |((name, _), values): ((&String, _), &Vec<f64>)| {
            let angle = degrees::among(values)?;
            Some(degrees::of_column(&format!("the column `{name}`"), name, angle, Span::default()))
        };
        bare.filter_map(warning).collect()
    }

    /// The values of a column, one for each time, in SI if the header names a unit.
    pub fn column(&self, column: usize) -> &[f64] {
        &self.columns[column]
    }

    pub fn times(&self) -> &[f64] {
        &self.time
    }

    /// Sets one value of a column; nothing where there is none.
    pub fn set(&mut self, column: usize, row: usize, value: f64) {
        if let Some(place) = self.columns.get_mut(column).and_then(|column| column.get_mut(row)) {
            *place = value;
        }
    }

    /// Value and rate of a column just after a time. Before the first row and after the last the value is constant.
    pub fn at(&self, column: usize, time: f64) -> (f64, f64) {
        self.columns.get(column).map_or((f64::NAN, f64::NAN), |values| self.after(time, |row| values[row]))
    }

    /// Rate of a column just before a time.
    pub fn rate_before(&self, column: usize, time: f64) -> f64 {
        self.columns.get(column).map_or(f64::NAN, |values| self.before(time, |row| values[row]))
    }

    /// How value and rate just after a time change with the value of one row; the rate is that before the time if nothing follows.
    pub fn share(&self, row: usize, time: f64, is_last: bool) -> [f64; 2] {
        let unit = |other: usize| if other == row { 1.0 } else { 0.0 };
        let (value, rate) = self.after(time, unit);
        [value, if is_last { self.before(time, unit) } else { rate }]
    }

    fn after(&self, time: f64, value: impl Fn(usize) -> f64) -> (f64, f64) {
        let next = self.time.partition_point(|&row| row <= time);
        let before = next.checked_sub(1).map(|row| (self.time[row], value(row)));
        let after = self.time.get(next).map(|&row| (row, value(next)));
        match (before, after) {
            (Some((t0, v0)), Some((t1, v1))) => {
                let rate = (v1 - v0) / (t1 - t0);
                (v0 + rate * (time - t0), rate)
            }
            (Some((_, value)), None) | (None, Some((_, value))) => (value, 0.0),
            (None, None) => (f64::NAN, f64::NAN),
        }
    }

    fn before(&self, time: f64, value: impl Fn(usize) -> f64) -> f64 {
        match self.time.partition_point(|&row| row < time) {
            next if next > 0 && next < self.time.len() => {
                (value(next) - value(next - 1)) / (self.time[next] - self.time[next - 1])
            }
            _ => 0.0,
        }
    }
}

/// The columns that are read.
fn sources(sheet: &Sheet, naming: &Naming<'_>) -> Result<Vec<SourceColumn>, SheetError> {
    let headings = sheet.headings();
    if headings.is_empty() {
        let what = if sheet.rows() == 0 { "the table is empty" } else { "the table has no line of names" };
        return Err(fault(1, 1, format!("{what}; add a header line such as `time,name`")));
    }
    if !naming.chosen.is_empty() {
        return chosen(headings, naming.chosen);
    }
    let unit_of = |name: &str| if is_time(name) { Some(Unit::time()) } else { (naming.unit_of)(name) };
    let source = |(place, heading): (usize, &Heading)| {
        let (name, unit) = heading.of_variable(unit_of)?;
        Ok(SourceColumn { place, name, unit })
    };
    headings.iter().enumerate().map(source).collect()
}

/// The chosen columns, and the time.
fn chosen(headings: &[Heading], chosen: &[(String, String)]) -> Result<Vec<SourceColumn>, SheetError> {
    let source = |place: usize, name: &str| {
        let (_, unit) = headings[place].read()?;
        Ok(SourceColumn { place, name: name.to_owned(), unit })
    };
    let called = |name: &str| {
        let whole = headings.iter().position(|heading| heading.text == name);
        whole.or_else(|| {
            headings.iter().position(|heading| heading.read().is_ok_and(|(heading_name, _)| heading_name == name))
        })
    };
    let mut sources = Vec::new();
    for (name, heading) in chosen {
        let place = called(heading).ok_or_else(|| {
            let name = |heading: &Heading| heading.read().map_or_else(|_| heading.text.clone(), |(name, _)| name);
            let names: Vec<String> = headings.iter().map(name).collect();
            let known = suggest::known(heading, names.iter().map(String::as_str));
            fault(1, 1, format!("there is no column `{heading}`; {known}"))
        })?;
        sources.push(source(place, name)?);
    }
    if !sources.iter().any(SourceColumn::is_time) {
        let time = headings.iter().position(|heading| heading.read().is_ok_and(|(name, _)| is_time(&name)));
        sources.extend(time.map(|place| source(place, "time")).transpose()?);
    }
    Ok(sources)
}

/// No two columns have the same name, and none has no name.
fn different(sheet: &Sheet, sources: &[SourceColumn]) -> Result<(), SheetError> {
    let mut seen = HashSet::new();
    for SourceColumn { place, name, .. } in sources {
        let wrong = match name.as_str() {
            "" => "the column has no name".to_owned(),
            name if !seen.insert(name) || is_time(name) => format!("there are two columns `{name}`"),
            _ => continue,
        };
        return Err(sheet.headings()[*place].fault(wrong));
    }
    Ok(())
}

fn fault(line: usize, column: usize, message: impl Into<String>) -> SheetError {
    SheetError { line, column, message: message.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_between_rows_and_held_outside() {
        let table = CsvTable::parse("time,a\n1,10\n3,20\n4,0\n").unwrap();
        assert_eq!(table.at(0, 0.0), (10.0, 0.0));
        assert_eq!(table.at(0, 1.0), (10.0, 5.0));
        assert_eq!(table.at(0, 2.0), (15.0, 5.0));
        assert_eq!(table.at(0, 3.0), (20.0, -20.0));
        assert_eq!(table.at(0, 4.0), (0.0, 0.0));
        assert_eq!(table.at(0, 9.0), (0.0, 0.0));
        assert_eq!([0.0, 1.0, 3.0, 3.5, 4.0, 9.0].map(|t| table.rate_before(0, t)), [0.0, 0.0, 5.0, -20.0, -20.0, 0.0]);
    }

    #[test]
    fn empty_cells_are_gaps_where_they_may_be() {
        let (text, naming) = ("time,a,b\n1,10,\n2,,5\n", Naming { unit_of: &|_| None, chosen: &[] });
        let table = CsvTable::read_with_gaps(text, &naming).unwrap();
        assert!(table.column(0)[1].is_nan() && table.column(1)[0].is_nan());
        assert_eq!((table.column(0)[0], table.column(1)[1]), (10.0, 5.0));
        assert!(CsvTable::read(text, &naming).unwrap_err().to_string().contains("empty"));
        assert!(CsvTable::read_with_gaps("time,a\n,1\n", &naming).is_err());
    }

    #[test]
    fn two_rows_at_one_time_are_a_jump() {
        let table = CsvTable::parse("time,a\n0,1\n1,1\n1,5\n2,5\n").unwrap();
        assert_eq!(table.at(0, 0.999), (1.0, 0.0));
        assert_eq!(table.at(0, 1.0), (5.0, 0.0));
    }

    #[test]
    fn spreadsheets_are_read() {
        let table = CsvTable::parse("\u{feff}time, \"gas, force\"\r\n0, 1e3\r\n\r\n1,\"-2\"\r\n").unwrap();
        assert_eq!(table.names(), ["gas, force"]);
        assert_eq!(table.at(0, 1.0).0, -2.0);
    }

    #[test]
    fn columns_have_units_and_stand_in_any_order() {
        let table = CsvTable::parse("gas_force [kN]; time [ms]; share\n1,5; 0; 2\n-2; 500; 3\n").unwrap();
        assert_eq!(
            (table.names(), table.times()),
            (&["gas_force".to_owned(), "share".to_owned()][..], &[0.0, 0.5][..])
        );
        assert_eq!(table.at(0, 0.0), (1500.0, -7000.0));
        assert_eq!((table.at(1, 0.5).0, table.units()[0].as_ref().unwrap().si.as_str()), (3.0, "N"));
        assert_eq!(CsvTable::parse("a\tt [s]\n7\t1\n").unwrap().at(0, 1.0).0, 7.0);
    }

    #[test]
    fn a_header_may_be_wide() {
        let names: Vec<String> = (0..200_000).map(|column| format!("c{column}")).collect();
        let (header, row) = (names.join(","), vec!["1"; names.len()].join(","));
        assert_eq!(CsvTable::parse(&format!("time,{header}\n0,{row}\n")).unwrap().names(), names);
        let fault = CsvTable::parse(&format!("time,{header},c7\n")).unwrap_err();
        assert_eq!((fault.column, fault.message.as_str()), (names.len() + 2, "there are two columns `c7`"));
    }

    #[test]
    fn faults_say_where() {
        let cases = [
            ("", 1, 1, "empty"),
            ("x,a\n", 1, 1, "no column is `time`"),
            ("time,t\n0,1\n", 1, 2, "two columns"),
            ("time [mm],a\n0,1\n", 1, 1, "not a unit of time"),
            ("time,a [furlong]\n0,1\n", 1, 2, "unknown unit `furlong`"),
            ("time;a\n0;1,2,3\n", 2, 2, "not a number"),
            ("time,a,a\n0,1,2\n", 1, 3, "two columns `a`"),
            ("time,a,\n0,1,2\n", 1, 3, "no name"),
            ("time,a\n", 2, 1, "no rows"),
            ("time,a\n0,1\n1,x\n", 3, 2, "`x` is not a number"),
            ("0,1\n", 1, 1, "no line of names"),
            ("time,a\n0,1\n1,\n", 3, 2, "empty"),
            ("time,a\ns,furlong\n0,1\n", 2, 2, "unknown unit `furlong`"),
            ("time,a\n0,NaN\n", 2, 2, "finite"),
            ("time,a\n0\n", 2, 1, "1 fields"),
            ("time,a\n0,1,2\n", 2, 2, "3 fields"),
            ("time,a\n1,0\n0.5,0\n", 3, 1, "earlier"),
            ("time,a\n0,\"1\n", 2, 1, "not closed"),
            ("time,a\n0,1\"2\"\n", 2, 2, "middle"),
        ];
        for (text, line, column, message) in cases {
            let error = CsvTable::parse(text).unwrap_err();
            assert_eq!((error.line, error.column), (line, column), "{text:?}: {error}");
            assert!(error.message.contains(message), "{text:?}: {error}");
        }
    }
}
