//! Tables of files in expressions: `table("cam.csv", x)` by straight lines, `spline("cam.csv", x)` by a cubic spline, and both periodic. A table becomes
//! a law in pieces, each a polynomial, so that its values, derivatives and Taylor series are exact, and where its pieces meet is found as with `if`.

mod pieces;
mod read;

use std::path::Path;
use std::rc::Rc;

use super::{Resolver, UNKNOWN, reuse};
use crate::diagnostic::degrees;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Span;
use crate::expr::{Function, Unary};
use crate::files;
use crate::model::measure::ANGLE;
use crate::model::{Comparison, Formula};
use crate::scene::decode::text;
use crate::scene::dimension::KnownUnit;
use crate::scene::expression::Lookup;
use crate::scene::unit::from_exponents;
use crate::scene::{Scene, constant};
pub(super) use read::Table;

/// Adds the files of its tables to the source of a scene: what cannot be read is reported where it is used.
pub(super) fn append(scene: &mut Scene) {
    for file in reuse::files_of_tables(scene) {
        if scene.source.files().all(|(known, _)| known != file) {
            let content = files::read(Path::new(&file), Scene::LARGEST).ok();
            let content = content.and_then(|bytes| text(Path::new(&file), bytes).ok());
            scene.source.append(&file, &content.unwrap_or_default());
        }
    }
}

impl Resolver<'_> {
    /// The formula of a table at an argument; `site` says whose expression it is in, and where.
    pub(super) fn lookup(
        &mut self,
        lookup: Lookup,
        file: &str,
        (argument, known): (Formula, KnownUnit),
        (what, place): (&str, Span),
    ) -> Option<(Formula, KnownUnit)> {
        let table = self.table(file, place)?;
        if let (Some(found), Some(wanted)) = (known.unit(), table.units[0])
            && !found.is_compatible(wanted)
        {
            let [found, wanted] = [found, wanted].map(|unit| from_exponents(unit).si);
            let message =
                format!("in {what}, the first column of `{file}` is in `{wanted}`, but its argument in `{found}`");
            self.faults.push(Fault::new("scene::wrong_unit", message, place).label("another unit"));
        }
        let is_bare = table.units[0].is_none() && known.unit() == ANGLE.exponents;
        if let Some(angle) = degrees::among(&table.x).filter(|_| is_bare) {
            let what = format!("in {what}, the first column of `{file}`");
            self.faults.push(degrees::of_column(&what, "angle", angle, place));
        }
        let pieces = match pieces::pieces(&table, lookup) {
            Ok(pieces) => pieces,
            Err((row, message)) => {
                let fault =
                    Fault::new("scene::bad_table", format!("`{file}` {message}"), table.place(row).unwrap_or(place));
                self.faults.push(fault.label("here"));
                return Some((UNKNOWN, KnownUnit::Nothing));
            }
        };
        let argument = if lookup.periodic { wrapped(argument, &table) } else { argument };
        Some((choice(&argument, &pieces), KnownUnit::moving(table.units[1])))
    }

    pub(super) fn table(&mut self, file: &str, place: Span) -> Option<Rc<Table>> {
        if let Some(known) = self.tables.get(file) {
            return known.clone();
        }
        let found = self.read_table(file, place).map(Rc::new);
        self.tables.insert(file.to_owned(), found.clone());
        found
    }

    fn read_table(&mut self, file: &str, place: Span) -> Option<Table> {
        let known = self.scene.source.text_of(file).filter(|(text, _)| !text.is_empty());
        if let Some((text, start)) = known {
            return self.reported(Table::read(file, text, Some(start)));
        }
        let path = Path::new(file);
        let unreadable = |message: String| Fault::new("scene::unreadable", message, place).label("this file");
        let bytes = files::read(path, Scene::LARGEST);
        let bytes = bytes.map_err(|error| unreadable(format!("`{file}` cannot be read: {error}")));
        let content = bytes.and_then(|bytes| text(path, bytes).map_err(|fault| Fault { span: place, ..fault }));
        let content = self.reported(content)?;
        // Without a source there is no text to show: the fault names the line.
        let table = Table::read(file, &content, None);
        self.reported(table.map_err(|fault| Fault { span: place, ..fault }))
    }

    fn reported<T>(&mut self, result: Result<T, Fault>) -> Option<T> {
        result.map_err(|fault| self.faults.push(fault)).ok()
    }
}

/// x - P floor((x - x0)/P)
fn wrapped(argument: Formula, table: &Table) -> Formula {
    let (first, last) = (table.x[0], table.x[table.x.len() - 1]);
    let period = Formula::Number(last - first);
    let turns = (argument.clone() - Formula::Number(first)) / period.clone();
    let whole = constant::apply(Function::One(Unary::Floor), vec![turns]);
    argument - period * whole
}

/// The piece that holds at the argument, by halving.
fn choice(argument: &Formula, pieces: &[pieces::PolynomialPiece]) -> Formula {
    match pieces {
        [] => UNKNOWN,
        [piece] => polynomial(argument, piece),
        _ => {
            let (below, above) = pieces.split_at(pieces.len() / 2);
            let parts =
                [argument.clone(), Formula::Number(above[0].start), choice(argument, below), choice(argument, above)];
            // Of numbers alone the value is known.
            match (constant::number(argument), parts) {
                (Some(argument), [_, Formula::Number(start), below, above]) => {
                    if argument < start {
                        below
                    } else {
                        above
                    }
                }
                (_, parts) => Formula::If(Comparison::Less, Box::new(parts)),
            }
        }
    }
}

/// c0 + d (c1 + d (c2 + d c3)), d = x - origin, without the coefficients that are zero at its end.
fn polynomial(argument: &Formula, piece: &pieces::PolynomialPiece) -> Formula {
    let d = match piece.origin {
        0.0 => argument.clone(),
        origin => argument.clone() - Formula::Number(origin),
    };
    let degree = piece.coefficients.iter().rposition(|c| *c != 0.0).unwrap_or(0);
    let mut value = Formula::Number(piece.coefficients[degree]);
    for &coefficient in piece.coefficients[..degree].iter().rev() {
        value = d.clone() * value;
        if coefficient != 0.0 {
            value = Formula::Number(coefficient) + value;
        }
    }
    value
}
