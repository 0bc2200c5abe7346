//! Tables as they are written: two columns, separated by commas, semicolons, tabs or blanks, with a line of names and units above them or without.

use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::scene::unit::{self, Exponents};

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

/// A line that is being read.
struct Line<'t> {
    file: &'t str,
    number: usize,
    text: &'t str,
    span: Span,
}

impl Table {
    /// The table in a text; `start` is where that begins in the source.
    pub fn read(file: &str, text: &str, start: Option<usize>) -> Result<Table, Fault> {
        let mut table = Table { x: Vec::new(), y: Vec::new(), units: [None; 2], places: Vec::new() };
        let (mut factors, mut offset, mut begun) = ([1.0; 2], 0, false);
        for (index, whole) in text.split('\n').enumerate() {
            let place = Span::new(offset, offset + whole.trim_end().len());
            offset += whole.len() + 1;
            let content = whole.trim();
            if content.is_empty() || content.starts_with('#') {
                continue;
            }
            let span = start.map_or(Span::default(), |start| place.shifted(start));
            let line = Line { file, number: index + 1, text: content, span };
            let fields = line.fields();
            let is_header = !begun && fields.first().is_some_and(|field| field.parse::<f64>().is_err());
            begun = true;
            if is_header {
                (table.units, factors) = line.units()?;
            } else {
                table.push(&line, &fields, factors)?;
                table.places.extend(start.map(|_| line.span));
            }
        }
        if table.x.is_empty() {
            return Err(Fault::new("scene::bad_table", format!("`{file}` has no rows"), Span::default()));
        }
        Ok(table)
    }

    fn push(&mut self, line: &Line<'_>, fields: &[&str], factors: [f64; 2]) -> Result<(), Fault> {
        let [x, y] = fields else {
            return Err(line.fault(&format!("has {} columns instead of two", fields.len())));
        };
        let number = |field: &str| match field.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(line.fault(&format!("has `{field}`, which is no finite number"))),
            Err(_) => Err(line.fault(&format!("has `{field}`, which is no number"))),
        };
        let (x, y) = (number(x)? * factors[0], number(y)? * factors[1]);
        if self.x.last().is_some_and(|last| *last >= x) {
            return Err(line.fault("does not increase: its first value is not above the one before"));
        }
        self.x.push(x);
        self.y.push(y);
        Ok(())
    }

    /// Where a row is written.
    pub fn place(&self, row: usize) -> Option<Span> {
        self.places.get(row).copied()
    }
}

impl<'t> Line<'t> {
    fn fields(&self) -> Vec<&'t str> {
        let separator = [';', ',', '\t'].into_iter().find(|separator| self.text.contains(*separator));
        match separator {
            Some(separator) => self.text.split(separator).map(str::trim).collect(),
            None => self.text.split_whitespace().collect(),
        }
    }

    /// The units in the brackets of the names of both columns, and what makes their numbers SI.
    fn units(&self) -> Result<([Option<Exponents>; 2], [f64; 2]), Fault> {
        let (mut units, mut factors) = ([None; 2], [1.0; 2]);
        for (column, field) in self.text.split([';', ',', '\t']).take(2).enumerate() {
            let Some((_, rest)) = field.split_once('[') else { continue };
            let name = rest.split_once(']').map_or(rest, |(name, _)| name).trim();
            let unit = unit::parse(&Text::new(name, self.span));
            let unit = unit.map_err(|fault| self.fault(&format!("has a unit that is not known: {}", fault.message)))?;
            factors[column] = unit.display.as_ref().map_or(1.0, |display| display.factor);
            units[column] = Some(unit.exponents);
        }
        Ok((units, factors))
    }

    fn fault(&self, what: &str) -> Fault {
        let message = format!("line {} of `{}` {what}", self.number, self.file);
        Fault::new("scene::bad_table", message, self.span)
            .label("this line")
            .help("a table has two columns of numbers, the first increasing: `0.5, 12.3`")
    }
}
