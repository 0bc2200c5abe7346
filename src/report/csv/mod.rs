//! Tables as comma-separated values: results out, inputs in.

mod table;

pub use table::{CsvTable, Naming, TableError};

use std::io::{self, Write};

/// Writes results, a row for each time. Fields are quoted as in RFC 4180; lines end with a line feed alone, because that is what command-line
/// tools expect.
#[derive(Debug)]
pub struct CsvWriter<W> {
    out: W,
    /// The SI value of one in each column.
    factors: Vec<f64>,
}

impl<W: Write> CsvWriter<W> {
    /// Begins with the headings, such as `time [ms]`; beside each stands the SI value of one in its column.
    pub fn new(mut out: W, columns: impl IntoIterator<Item = (impl AsRef<str>, f64)>) -> io::Result<Self> {
        let (fields, factors): (Vec<String>, Vec<f64>) =
            columns.into_iter().map(|(heading, factor)| (field(heading.as_ref()), factor)).unzip();
        writeln!(out, "{}", fields.join(","))?;
        Ok(Self { out, factors })
    }

    /// Writes a row of SI values. Every number is the shortest text that reads back as the same number; where there is none the cell is empty.
    pub fn row<'v>(&mut self, values: impl IntoIterator<Item = &'v f64>) -> io::Result<()> {
        for (column, (value, factor)) in values.into_iter().zip(&self.factors).enumerate() {
            let separator = if column == 0 { "" } else { "," };
            match value.is_nan() {
                true => write!(self.out, "{separator}")?,
                false => write!(self.out, "{separator}{:?}", value / factor)?,
            }
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
        let columns = ["time", "crank.angle", "odd, \"name\""].map(|name| (name, 1.0));
        let mut writer = CsvWriter::new(Vec::new(), columns).unwrap();
        for (time, values) in &rows {
            writer.row([time].into_iter().chain(values)).unwrap();
        }
        let text = String::from_utf8(writer.finish().unwrap()).unwrap();
        assert!(text.starts_with("time,crank.angle,\"odd, \"\"name\"\"\"\n0.0,0.3333333333333333,-0.0\n"), "{text}");
        let table = CsvTable::parse(&text).unwrap();
        assert_eq!(table.names(), ["crank.angle", "odd, \"name\""]);
        for (time, values) in rows {
            for (column, value) in values.into_iter().enumerate() {
                assert_eq!(table.at(column, time).0, value);
            }
        }
    }
}
