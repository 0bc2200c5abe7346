//! The decimal sign of a table.

use super::{Row, SheetError};

/// A table has one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Decimal {
    Point,
    Comma,
}

impl Decimal {
    /// Commas between semicolons are decimal; elsewhere they may be between thousands, unless one number shows that they are not.
    pub fn of(rows: &[Row], separator: u8) -> Result<Decimal, SheetError> {
        let (mut found, mut is_sure) = ([None, None], separator == b';');
        for row in rows {
            for (column, cell) in row.cells.iter().enumerate() {
                let Some(sign) = sign(cell.trim()) else { continue };
                found[usize::from(sign == ',')].get_or_insert((row.line, column + 1, cell));
                is_sure |= sign == ',' && !is_grouped(cell.trim());
            }
        }
        let fault = |(line, column, _): (usize, usize, &str), what: String| Err(SheetError::new(line, column, what));
        match found {
            [Some(point), Some(comma)] => {
                let (later, earlier) = if point > comma { (point, comma) } else { (comma, point) };
                let (later_number, other) = (later.2.trim(), earlier.2.trim());
                fault(
                    later,
                    format!(
                        "`{later_number}` has another decimal sign than `{other}` in line {}; use the same in the whole file",
                        earlier.0
                    ),
                )
            }
            [None, Some(comma)] if !is_sure => {
                let (comma_number, bare) = (comma.2.trim(), comma.2.trim().replace(',', ""));
                let point = comma_number.replacen(',', ".", 1);
                fault(comma, format!("`{comma_number}` could be {bare} or {point}: write it with a decimal point"))
            }
            [None, Some(_)] => Ok(Decimal::Comma),
            [_, None] => Ok(Decimal::Point),
        }
    }

    /// A cell with a point for its decimal sign.
    pub fn plain(self, cell: &str) -> String {
        match self {
            Decimal::Point => cell.to_owned(),
            Decimal::Comma => cell.replacen(',', ".", 1),
        }
    }
}

/// The first sign behind the digits of a number, if it has one.
fn sign(cell: &str) -> Option<char> {
    let rest = cell.trim_start_matches(['+', '-']).trim_start_matches(|c: char| c.is_ascii_digit());
    let sign = rest.chars().next().filter(|c| matches!(c, '.' | ','))?;
    rest[1..].starts_with(|c: char| c.is_ascii_digit()).then_some(sign)
}

/// May it be a number with commas between its thousands, such as `1,234`?
fn is_grouped(cell: &str) -> bool {
    let cell = cell.trim_start_matches(['+', '-']);
    let number = &cell[..cell.find(|c: char| !c.is_ascii_digit() && c != ',').unwrap_or(cell.len())];
    let mut groups = number.split(',');
    let first = groups.next().unwrap_or_default();
    (1..=3).contains(&first.len()) && !first.starts_with('0') && groups.all(|group| group.len() == 3)
}
