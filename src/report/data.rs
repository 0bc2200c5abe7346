//! A result as plain data, and the one way in which results are written: for people in their units, with the digits that are worth reading and zeros instead of
//! rounding errors; for spreadsheets as a table of exact numbers; for scripts as JSON in SI.

use std::collections::HashMap;
use std::fmt::Display;

use serde_json::Value;

use super::csv::field;
use crate::model::{DisplayUnit, Units};
use crate::scene::Text;
use crate::scene::unit::parse;
use crate::typeset;
use crate::typeset::{aligned, titled};

/// What rounding errors leave of zero is below this share of the largest number in its unit.
pub const ROUNDING: f64 = 1e-13;

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Lines above the tables.
    pub title: Vec<Cell>,
    pub tables: Vec<Table>,
    /// Lines below them.
    pub notes: Vec<Cell>,
    /// The table for spreadsheets.
    pub sheet: Table,
    /// What scripts read, in SI.
    pub data: Value,
    /// The share of the largest number in its unit below which a number is an error of zero, where that is more than rounding leaves.
    pub noise: f64,
    /// What the lines of tables begin with.
    pub indent: &'static str,
}

/// Rows below a heading and names of columns, both of which may be absent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    pub heading: Option<Cell>,
    pub columns: Vec<Cell>,
    pub rows: Vec<Vec<Cell>>,
    /// How many columns stand to the left; the others stand to the right.
    pub left: usize,
    /// So many characters fit beside the first column; what does not goes below, beside the first column again.
    pub width: Option<usize>,
}

/// A part of a table or of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    Text(String),
    /// A value in an SI unit, and how accurate it is; no number where there is none.
    Number(f64, String, ReliableDigits),
    /// The name of an SI unit, as it is shown.
    Unit(String),
    /// A name with its SI unit: `time [ms]`.
    Named(String, String),
    /// Parts one behind the other; numbers have their units behind them.
    Line(Vec<Cell>),
}

/// Which digits of a number say something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReliableDigits {
    /// Six; none if it is small beside the largest in its unit.
    Beside,
    /// Six; none up to this.
    Noise(f64),
    /// Those that this standard error permits.
    Error(f64),
}

/// A number in an SI unit.
pub fn number(value: f64, si: &str) -> Cell {
    Cell::Number(value, si.to_owned(), ReliableDigits::Beside)
}

/// A number without unit that is zero up to this noise.
pub fn plain(value: f64, noise: f64) -> Cell {
    number(value, "").within(ReliableDigits::Noise(noise))
}

pub fn unit(si: &str) -> Cell {
    Cell::Unit(si.to_owned())
}

pub fn named(name: impl Display, si: &str) -> Cell {
    Cell::Named(name.to_string(), si.to_owned())
}

impl Cell {
    /// A number as accurate as this.
    #[must_use]
    pub fn within(self, accuracy: ReliableDigits) -> Cell {
        if let Cell::Number(value, si, _) = self { Cell::Number(value, si, accuracy) } else { self }
    }
}

impl<T: Display> From<T> for Cell {
    fn from(text: T) -> Cell {
        Cell::Text(text.to_string())
    }
}

impl From<&Cell> for Cell {
    fn from(cell: &Cell) -> Cell {
        cell.clone()
    }
}

/// A row of a table: cells, and whatever can be displayed.
#[doc(hidden)]
#[macro_export]
macro_rules! row {
    ($($cell:expr),* $(,)?) => { vec![$($crate::report::data::Cell::from(&$cell)),*] };
}

/// The same one behind the other, as a line.
#[doc(hidden)]
#[macro_export]
macro_rules! line {
    ($($cell:expr),+ $(,)?) => { $crate::report::data::Cell::Line($crate::row![$($cell),+]) };
}

impl Table {
    /// With names of its columns, the first of which stands to the left.
    pub fn new(columns: Vec<Cell>, rows: impl IntoIterator<Item = Vec<Cell>>) -> Table {
        Table { columns, rows: rows.into_iter().collect(), left: 1, ..Table::default() }
    }

    /// Lines below a heading.
    pub fn list(heading: &str, rows: impl IntoIterator<Item = Vec<Cell>>) -> Table {
        Table { heading: Some(heading.into()), ..Table::new(Vec::new(), rows) }
    }

    /// Entries beside the names of their rows and below those of their columns.
    pub fn matrix<N: Display>(name: &str, rows: &[N], columns: &[N], entry: impl Fn(usize, usize) -> Cell) -> Table {
        let line = |row: usize| {
            let entries = (0..columns.len()).map(|column| entry(row, column));
            row![rows[row]].into_iter().chain(entries).collect()
        };
        let columns = row![name].into_iter().chain(columns.iter().map(Cell::from)).collect();
        Table::new(columns, (0..rows.len()).map(line))
    }
}

impl Report {
    /// One with a title, whose tables are indented.
    pub fn new(title: Vec<Cell>) -> Report {
        Report { title, indent: "  ", ..Report::default() }
    }

    /// For people, in these units; ends with a line break, as CSV does.
    pub fn text(&self, units: &Units) -> String {
        let mut largest: HashMap<&str, f64> = HashMap::new();
        for cell in self.tables.iter().flat_map(|table| &table.rows).flatten() {
            if let Cell::Number(value, si, ReliableDigits::Beside) = cell
                && value.is_finite()
            {
                let most = largest.entry(si).or_default();
                *most = most.max(value.abs());
            }
        }
        let writer = ReportWriter { units, largest, noise: self.noise.max(ROUNDING), indent: self.indent };
        let lines = |lines: &[Cell]| lines.iter().map(|line| writer.cell(line) + "\n").collect::<String>();
        let tables: String = self.tables.iter().map(|table| writer.table(table)).collect();
        (lines(&self.title) + &tables + &lines(&self.notes)).trim_start_matches('\n').to_owned()
    }

    /// For spreadsheets: in these units if the table names units, else in SI.
    pub fn csv(&self, units: &Units) -> String {
        let rows = || std::iter::once(&self.sheet.columns).chain(&self.sheet.rows);
        let names_units = rows().flatten().any(|cell| matches!(cell, Cell::Unit(_) | Cell::Named(..)));
        let units = if names_units { units } else { &Units::default() };
        let writer = ReportWriter { units, largest: HashMap::new(), noise: 0.0, indent: "" };
        let exact = |cell: &Cell| match cell {
            Cell::Number(value, ..) if value.is_nan() => String::new(),
            Cell::Number(value, si, _) => format!("{:?}", value / composed(units, si).factor),
            other => field(&writer.cell(other)),
        };
        rows().map(|row| row.iter().map(exact).collect::<Vec<String>>().join(",") + "\n").collect()
    }

    /// For scripts, in SI.
    pub fn json(&self) -> String {
        format!("{:#}\n", self.data)
    }
}

struct ReportWriter<'r> {
    units: &'r Units,
    /// The largest number of the tables in each unit.
    largest: HashMap<&'r str, f64>,
    noise: f64,
    indent: &'static str,
}

impl ReportWriter<'_> {
    fn cell(&self, cell: &Cell) -> String {
        match cell {
            Cell::Text(text) => text.clone(),
            Cell::Number(value, si, accuracy) => self.number(*value, si, *accuracy),
            Cell::Unit(si) => composed(self.units, si).name,
            Cell::Named(name, si) => titled(name, &composed(self.units, si).name),
            Cell::Line(parts) => parts.iter().map(|part| self.part(part)).collect(),
        }
    }

    fn part(&self, part: &Cell) -> String {
        let Cell::Number(_, si, _) = part else { return self.cell(part) };
        let unit = composed(self.units, si).name.replace("/(", " per ").replace(')', "");
        format!("{} {unit}", self.cell(part)).trim_end().to_owned()
    }

    fn number(&self, value: f64, si: &str, accuracy: ReliableDigits) -> String {
        let factor = composed(self.units, si).factor;
        let up_to = |noise: f64| typeset::number(value / factor, noise / factor);
        match accuracy {
            _ if value.is_nan() => "-".to_owned(),
            ReliableDigits::Beside => up_to(self.noise * self.largest(si)),
            ReliableDigits::Noise(noise) => up_to(noise),
            ReliableDigits::Error(error) => typeset::measured(value / factor, Some(error / factor)),
        }
    }

    /// The largest number in a unit. Angles count as large as a radian, torques and energies as forces at their arms; lengths, forces and torques below a millionth
    /// are not magnified.
    fn largest(&self, si: &str) -> f64 {
        let of = |si: &str| self.largest.get(si).copied().unwrap_or_default();
        match si {
            "rad" => of(si).max(1.0),
            "m" | "N" => of(si).max(1e-6),
            "N.m" | "J" => of("N.m").max(of("N") * of("m")).max(of(si)).max(1e-6),
            _ => of(si),
        }
    }

    fn table(&self, table: &Table) -> String {
        let heading = table.heading.as_ref().map_or(String::new(), |heading| self.cell(heading) + "\n");
        let rows = Some(&table.columns).filter(|columns| !columns.is_empty()).into_iter().chain(&table.rows);
        let rows: Vec<Vec<String>> = rows.map(|row| row.iter().map(|cell| self.cell(cell)).collect()).collect();
        let parts = table.width.map_or_else(|| vec![rows.clone()], |width| folded(&rows, width));
        let parts: Vec<String> = parts.iter().map(|rows| aligned(rows, table.left, self.indent)).collect();
        format!("\n{heading}{}", parts.join("\n"))
    }
}

/// As many columns side by side as have room beside the first one.
fn folded(rows: &[Vec<String>], width: usize) -> Vec<Vec<Vec<String>>> {
    let first: Vec<Vec<String>> = rows.iter().map(|row| row.iter().take(1).cloned().collect()).collect();
    let (mut parts, mut room) = (vec![first.clone()], width);
    for column in 1..rows.first().map_or(0, Vec::len) {
        let cells = || rows.iter().map(|row| row.get(column).map_or("", String::as_str));
        let column_width = cells().map(|cell| cell.chars().count()).max().unwrap_or(0) + 2;
        if column_width > room {
            parts.push(first.clone());
            room = width;
        }
        room = room.saturating_sub(column_width);
        parts.last_mut().into_iter().flatten().zip(cells()).for_each(|(row, cell)| row.push(cell.to_owned()));
    }
    parts
}

/// How a value in this SI unit is shown; a unit that is made of others, such as `N/m`, stays as it is.
pub fn shown(units: &Units, si: &str) -> DisplayUnit {
    let known = if *units == Units::default() { None } else { parse(&Text::from(si)).ok() };
    known.map_or_else(|| DisplayUnit { name: si.to_owned(), factor: 1.0 }, |unit| units.of(&unit))
}

/// The same in a report: areas, and ratios of lengths and angles, are made of what is shown, but radians below the line stay; so are derivatives, such as `N/(kg)`, as
/// a whole.
pub fn composed(units: &Units, si: &str) -> DisplayUnit {
    let made = |name: String, factor: f64| DisplayUnit { name, factor };
    if let Some((of, by)) = si.strip_suffix(')').and_then(|si| si.split_once("/(")) {
        let [of, by] = [of, by].map(|part| composed(units, part));
        let one = if of.name.is_empty() { "1" } else { &of.name };
        let name = if by.name.is_empty() { of.name } else { format!("{one}/({})", by.name) };
        return made(name, of.factor / by.factor);
    }
    match si.split_once('/') {
        Some((above @ ("1" | "rad" | "m"), below @ ("rad" | "rad2" | "m" | "m2"))) => {
            let part = |si: &str| if si.starts_with('m') { composed(units, si) } else { made(si.to_owned(), 1.0) };
            let [above, below] = [above, below].map(part);
            made(format!("{}/{}", above.name, below.name), above.factor / below.factor)
        }
        // The power of forces in kilonewtons is one in kilowatts.
        None if si == "W" && shown(units, si).name == si => {
            let force = shown(units, "N");
            match force.name.strip_suffix('N') {
                Some(prefix @ ("k" | "M")) => made(format!("{prefix}W"), force.factor),
                Some(_) | None => made(si.to_owned(), 1.0),
            }
        }
        None if si == "m2" => {
            let metre = shown(units, "m");
            made(format!("{}2", metre.name), metre.factor * metre.factor)
        }
        _ => shown(units, si),
    }
}

/// The unit of a derivative.
pub fn per(of: &str, by: &str) -> String {
    format!("{of}/({by})")
}
