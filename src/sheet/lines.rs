//! The lines of a table: which of them are rows, and what stands between their cells.

use super::SheetError;

/// The rows of a text with one separator each between their cells.
#[derive(Debug)]
pub(super) struct SheetLines {
    pub separator: u8,
    /// A line for each row, as RFC 4180 has them.
    pub text: String,
    /// The line of the source that each begins on.
    pub numbers: Vec<usize>,
    /// The last comment above the first row, and its line.
    pub comment: Option<(usize, String)>,
}

/// What the reader of a row is at.
#[derive(Clone, Copy, PartialEq)]
enum CellState {
    Start,
    Bare,
    Quoted,
    /// Behind the second quotation mark, or the first of two.
    Closed,
    Behind,
}

impl SheetLines {
    pub fn of(text: &str) -> Result<SheetLines, SheetError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let (rows, comment) = rows(text)?;
        let mut lines = SheetLines { separator: separator(&rows), text: String::new(), numbers: Vec::new(), comment };
        rows.into_iter().try_for_each(|(line, row)| lines.push(line, row))?;
        Ok(lines)
    }

    /// Another row with the same separator, alone.
    pub fn only(&self, line: usize, row: &str) -> Result<SheetLines, SheetError> {
        let mut only =
            SheetLines { separator: self.separator, text: String::new(), numbers: Vec::new(), comment: None };
        only.push(line, row)?;
        Ok(only)
    }

    /// Adds a row: without blanks around its quotation marks, and with one blank for several if these separate.
    fn push(&mut self, line: usize, row: &str) -> Result<(), SheetError> {
        let by_blanks = self.separator == b' ';
        let row = if by_blanks { row.trim() } else { row.trim_matches([' ', '\r']) };
        let row = if by_blanks && !begins_with_number(row) { &with_units_joined(row) } else { row };
        let separates = |c: char| if by_blanks { c.is_whitespace() } else { c == char::from(self.separator) };
        let (mut at, mut column) = (CellState::Start, 1);
        for c in row.chars() {
            let next = match (at, c) {
                (CellState::Quoted, '"') => CellState::Closed,
                (CellState::Quoted, _) | (CellState::Closed, '"') => CellState::Quoted,
                (CellState::Start, c) if by_blanks && separates(c) => continue,
                (_, c) if separates(c) => {
                    column += 1;
                    CellState::Start
                }
                (CellState::Start, '"') => CellState::Quoted,
                (CellState::Start, c) if c.is_whitespace() => continue,
                (CellState::Closed | CellState::Behind, c) if c.is_whitespace() => {
                    at = CellState::Behind;
                    continue;
                }
                (CellState::Closed | CellState::Behind, _) => {
                    return Err(SheetError::new(line, column, "text after a closing quotation mark"));
                }
                (_, '"') => return Err(SheetError::new(line, column, "a quotation mark in the middle of a field")),
                (CellState::Start | CellState::Bare, _) => CellState::Bare,
            };
            at = next;
            self.text.push(if by_blanks && next == CellState::Start { ' ' } else { c });
        }
        self.text.push('\n');
        self.numbers.push(line);
        Ok(())
    }
}

type Rows<'t> = (Vec<(usize, &'t str)>, Option<(usize, String)>);

/// The rows with the lines that they begin on, and the last comment above them. A line break within quotation marks belongs to its row.
fn rows(text: &str) -> Result<Rows<'_>, SheetError> {
    let break_ = if text.contains('\n') { '\n' } else { '\r' };
    let (mut rows, mut comment) = (Vec::new(), None);
    let (mut line, mut rest) = (0, text);
    while !rest.is_empty() {
        line += 1;
        let is_comment = rest.trim_start_matches([' ', '\t']).starts_with('#');
        let (mut end, mut quotes) = (0, 0);
        for piece in rest.split(break_) {
            end += piece.len();
            quotes += if is_comment { 0 } else { piece.matches('"').count() };
            if quotes % 2 == 0 {
                break;
            }
            end += 1;
        }
        if quotes % 2 == 1 {
            return Err(SheetError::new(line, 1, "a quotation mark is not closed"));
        }
        let row = &rest[..end];
        if is_comment {
            let words = row.trim().trim_start_matches('#').to_owned();
            comment = if rows.is_empty() { Some((line, words)) } else { comment };
        } else if !row.trim().is_empty() {
            rows.push((line, row));
        }
        line += row.matches(break_).count();
        rest = rest.get(end + 1..).unwrap_or_default();
    }
    Ok((rows, comment))
}

/// The first of `;`, tab and `,` in the first row outside of quotation marks, or a blank. Commas do not separate numbers that blanks do: `0,5 1,5`.
fn separator(rows: &[(usize, &str)]) -> u8 {
    let outside = |row: &str| row.split('"').step_by(2).collect::<String>();
    let first = rows.first().map_or_else(String::new, |(_, row)| outside(row));
    let numbers = rows.iter().map(|(_, row)| outside(row)).find(|row| begins_with_number(row)).unwrap_or_default();
    let in_cell = |cell: &str| cell.split_whitespace().filter(|word| begins_with_number(word)).count();
    let by_blanks = numbers.split(',').any(|cell| in_cell(cell) > 1);
    let has = |separator: &u8| first.contains(char::from(*separator)) && !(*separator == b',' && by_blanks);
    [b';', b'\t', b','].into_iter().find(has).unwrap_or(b' ')
}

/// Names whose units would be columns of their own where blanks separate: `lift (mm)`, `lift / mm`.
fn with_units_joined(row: &str) -> String {
    let mut joined = row.split_whitespace().collect::<Vec<_>>().join(" ");
    let units = [(" (", "("), (" [", "["), (" /", "/"), ("/ ", "/")];
    // In a row of units they stand alone.
    for (apart, together) in units.into_iter().chain([(")(", ") ("), ("][", "] [")]) {
        joined = joined.replace(apart, together);
    }
    joined
}

fn begins_with_number(text: &str) -> bool {
    text.trim_start_matches([' ', '+', '-', '.', ',']).starts_with(|c: char| c.is_ascii_digit())
}
