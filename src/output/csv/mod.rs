//! Tables as comma-separated values: results out, inputs in.

mod table;

pub use table::{Cells, Table, TableError, named};

use std::io::{self, Write};

/// Writes results: `time` first, then one column for each variable. Fields are quoted as in RFC 4180; lines end with a
/// line feed alone, because that is what command-line tools expect.
#[derive(Debug)]
pub struct Writer<W> {
    out: W,
}

impl<W: Write> Writer<W> {
    pub fn new<'a>(out: W, names: impl IntoIterator<Item = &'a str>) -> io::Result<Self> {
        Self::with_header(out, std::iter::once("time").chain(names))
    }

    /// The same with a header of one's own, such as `time [ms]`, `crank.angle [deg]`.
    pub fn with_header<'a>(mut out: W, header: impl IntoIterator<Item = &'a str>) -> io::Result<Self> {
        let fields: Vec<String> = header.into_iter().map(field).collect();
        writeln!(out, "{}", fields.join(","))?;
        Ok(Self { out })
    }

    /// Writes a row. Every number is the shortest text that reads back as the same number.
    pub fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        write!(self.out, "{time:?}")?;
        for value in values {
            write!(self.out, ",{value:?}")?;
        }
        writeln!(self.out)
    }

    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }
}

/// A text as a field: quoted if it must be.
pub fn field(text: &str) -> String {
    if text.contains(['"', ',', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back() {
        let rows = [(0.0, [1.0 / 3.0, -0.0]), (1e-7, [f64::MIN_POSITIVE, 1e300]), (2.0, [0.1 + 0.2, -5.0])];
        let mut writer = Writer::new(Vec::new(), ["crank.angle", "odd, \"name\""]).unwrap();
        for (time, values) in &rows {
            writer.row(*time, values).unwrap();
        }
        let text = String::from_utf8(writer.finish().unwrap()).unwrap();
        assert!(text.starts_with("time,crank.angle,\"odd, \"\"name\"\"\"\n0.0,0.3333333333333333,-0.0\n"), "{text}");
        let table = Table::parse(&text).unwrap();
        assert_eq!(table.names(), ["crank.angle", "odd, \"name\""]);
        for (time, values) in rows {
            for (column, value) in values.into_iter().enumerate() {
                assert_eq!(table.at(column, time).0, value);
            }
        }
    }
}
