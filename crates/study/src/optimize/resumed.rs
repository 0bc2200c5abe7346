//! End points of earlier searches, read from their table.

use cotree::sheet::{Heading, Sheet, SheetError};

use super::OptimizeRequest;

/// The searches of a table that had a motion: their numbers, and where they ended, SI.
///
/// # Errors
/// What is no such table, or the table of another request.
pub fn searched(text: &str, request: &OptimizeRequest) -> Result<Vec<(usize, Vec<f64>)>, SheetError> {
    let sheet = Sheet::read(text)?;
    // The place of a column, and what one in it is in SI.
    let column = |wanted: &str| {
        let of_column = |(place, heading): (usize, &Heading)| {
            let (_, unit) = heading.read().ok().filter(|(name, _)| name == wanted)?;
            Some((place, unit.and_then(|unit| unit.display).map_or(1.0, |display| display.factor)))
        };
        sheet.headings().iter().enumerate().find_map(of_column).ok_or_else(|| SheetError {
            line: 1,
            column: 1,
            message: format!("there is no column `{wanted}`: this is the table of other searches"),
        })
    };
    let (number, _) = column("search")?;
    let places: Vec<(usize, f64)> = request.vary.iter().map(|vary| column(&vary.name)).collect::<Result<_, _>>()?;
    let mut all = Vec::new();
    for row in 0..sheet.rows() {
        let search = sheet.number(row, number)?;
        if search.fract() != 0.0 || !(0.0..request.starts as f64).contains(&search) {
            let message = format!("search {search} is not one of {}", request.starts);
            return Err(SheetError { line: sheet.line(row), column: number + 1, message });
        }
        // A search without a motion has no values: it begins anew.
        let values = places.iter().map(|&(place, factor)| Ok(sheet.number(row, place)? * factor));
        if let Ok(values) = values.collect::<Result<Vec<f64>, SheetError>>() {
            all.push((search as usize, values));
        }
    }
    Ok(all)
}
