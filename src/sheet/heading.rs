//! What stands above a column: its name, and its unit in brackets (`lift [mm]`, `lift (mm)`), after a slash (`lift / mm`), as its last word (`lift_mm`, `lift mm`), or in a row of
//! its own. A unit that is said is never passed over: what could be one and cannot be read is a fault.

use super::{Row, SheetError};
use crate::diagnostic::span::Text;
use crate::model::Unit;
use crate::scene::unit::{self, UnitError};

/// What is written above a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading {
    /// As it is written.
    pub text: String,
    line: usize,
    column: usize,
    /// What the row of units says, and its line.
    below: Option<(String, usize)>,
}

/// A name, and the unit of its numbers if one is said.
type Named = (String, Option<Unit>);

/// Words at the end of a name that are also the ends of names without a unit: minimum, input, mean, mass centre, lower bound, reversed; and letters of quantities.
const MISTAKABLE: [&str; 8] = ["min", "in", "bar", "cm", "lb", "rev", "h", "g"];
/// Electrical units that name points and bodies more often: `x_A`, `lift C`. They are units where brackets, a slash or the row of units say so.
const POINTS: [&str; 6] = ["A", "V", "H", "F", "C", "T"];
const BRACKETS: [[char; 2]; 4] = [['[', ']'], ['(', ')'], ['{', '}'], ['<', '>']];
/// What stands between a name and its last word.
const BEFORE_LAST: [char; 7] = [' ', '_', ',', ':', '-', '=', '\u{a0}'];

/// Those of all columns, from the row of names and that of the units.
pub(super) fn all(names: &Row, units: Option<&Row>) -> Vec<Heading> {
    let unit = |column: usize| {
        let row = units?;
        Some((row.cell(column).to_owned(), row.line))
    };
    let heading = |(column, text): (usize, &str)| Heading {
        text: text.trim().to_owned(),
        line: names.line,
        column: column + 1,
        below: unit(column).filter(|(text, _)| !text.is_empty()),
    };
    names.cells.iter().enumerate().map(heading).collect()
}

impl Heading {
    /// Its name and its unit, whatever the name is.
    ///
    /// # Errors
    /// What stands where a unit would is none, or could be a part of the name.
    pub fn read(&self) -> Result<Named, SheetError> {
        let marked = self.marked()?;
        if let Some(named) = self.with_unit_below(marked.as_ref())? {
            return Ok(named);
        }
        let Some(named) = marked.map_or_else(|| self.unmarked(), |named| Ok(Some(named)))? else {
            return Ok((self.text.clone(), None));
        };
        Ok(named)
    }

    /// The same where names are those of variables; `own` is the unit of a variable with that name. A whole heading that is such a name has no unit in it.
    ///
    /// # Errors
    /// As above; and a variable's own name that ends with another unit than the SI unit of its numbers.
    pub fn of_variable(&self, unit_of: impl Fn(&str) -> Option<Unit>) -> Result<Named, SheetError> {
        if let Some(known_unit) = unit_of(&self.text) {
            let named = (self.text.clone(), None);
            if let Some(named) = self.with_unit_below(Some(&named))? {
                return Ok(named);
            }
            let said = self.last_word().map(|(_, unit)| unit);
            return match said
                .filter(|unit| factor(unit) != 1.0 && !known_unit.si.is_empty() && unit.is_compatible(&known_unit))
            {
                Some(unit) => Err(self.unclear(&unit, &known_unit)),
                None => Ok(named),
            };
        }
        if let Some(marked) = self.marked()? {
            return Ok(self.with_unit_below(Some(&marked))?.unwrap_or(marked));
        }
        let last = self.last_word().filter(|(name, _)| unit_of(name).is_some());
        let named = last.map_or_else(|| (self.text.clone(), None), |(name, unit)| (name, Some(unit)));
        Ok(self.with_unit_below(Some(&named))?.unwrap_or(named))
    }

    pub fn fault(&self, message: impl Into<String>) -> SheetError {
        SheetError::new(self.line, self.column, message)
    }

    /// With the unit of the row of units, if that has one: it must not be another than that of the name.
    fn with_unit_below(&self, named: Option<&Named>) -> Result<Option<Named>, SheetError> {
        let Some((text, line)) = &self.below else { return Ok(None) };
        let wrong = |message: String| SheetError::new(*line, self.column, message);
        let unit = inside(text).map_err(|error| wrong(error.to_string()))?;
        let (name, said) = named.cloned().unwrap_or_else(|| (self.text.clone(), None));
        let differs = |said: &Unit| unit.as_ref().is_none_or(|unit| !is_same(said, unit));
        match said.filter(differs) {
            Some(said) => Err(wrong(format!("`{text}` is not the same unit as `{}` in `{}`", said.shown(), self.text))),
            None => Ok(Some((name, unit))),
        }
    }

    /// In brackets, or after a slash with blanks.
    fn marked(&self) -> Result<Option<Named>, SheetError> {
        let groups = groups(&self.text);
        // Round brackets beside square ones belong to the name.
        let square: Vec<_> = groups.iter().filter(|(start, _)| self.text[*start..].starts_with('[')).copied().collect();
        let groups = if square.is_empty() { groups } else { square };
        let content = |(start, end): (usize, usize)| &self.text[start + 1..end - 1];
        let is_unit = |group: &&(usize, usize)| content(**group) != "1" && inside(content(**group)).is_ok();
        let units: Vec<_> = groups.iter().filter(is_unit).copied().collect();
        let (start, end) = match (&units[..], &groups[..]) {
            ([one], _) => *one,
            ([], [.., last]) if content(*last) == "1" && self.text[last.0..].starts_with('[') => *last,
            ([], [.., last]) => return Err(self.fault(self.no_unit(content(*last)))),
            ([], []) => return self.after_slash(),
            _ => return Err(self.fault(format!("`{}` has two units; write one, in square brackets", self.text))),
        };
        let name = format!("{}{}", name_alone(&self.text[..start]), &self.text[end..]);
        let unit = inside(content((start, end))).map_err(|wrong| self.fault(wrong.to_string()))?;
        Ok(Some((name.trim().to_owned(), unit)))
    }

    fn after_slash(&self) -> Result<Option<Named>, SheetError> {
        let blank = |c: Option<char>| c.is_some_and(char::is_whitespace);
        let spaced = |at: &usize| blank(self.text[..*at].chars().last()) || blank(self.text[at + 1..].chars().next());
        let Some(at) = self.text.match_indices('/').map(|(at, _)| at).find(spaced) else { return Ok(None) };
        let unit = inside(&self.text[at + 1..]).map_err(|_| self.fault(self.no_unit(&self.text[at + 1..])))?;
        Ok(Some((name_alone(&self.text[..at]).to_owned(), unit)))
    }

    /// After a slash without blanks, as the last word, or as the whole.
    fn unmarked(&self) -> Result<Option<Named>, SheetError> {
        let slashes = self.text.match_indices('/').map(|(at, _)| at);
        let behind = |at: usize| Some((name_alone(&self.text[..at]).to_owned(), parsed(&self.text[at + 1..])?));
        let has_slash = self.text.contains('/');
        let mut found: Vec<(String, Unit)> = slashes.filter_map(behind).collect();
        let last = self.last_word();
        // `F/kN` is a force in kilonewtons, not a capacitance by a force.
        let first = self.text.split('/').next().unwrap_or_default().trim();
        let is_whole = self.text.chars().count() > 1
            && !MISTAKABLE.contains(&self.text.as_str())
            && !(has_slash && POINTS.contains(&first));
        found.extend(last.clone());
        found.extend(parsed(&self.text).filter(|_| is_whole).map(|unit| (String::new(), unit)));
        let Some((name, unit)) = found.first().cloned() else {
            let rest = self.text.rsplit('/').next().unwrap_or_default();
            return if has_slash { Err(self.fault(self.no_unit(rest))) } else { Ok(None) };
        };
        let word = &self.text[self.text.rfind(BEFORE_LAST).map_or(0, |at| at + 1)..];
        let is_mistakable = last.is_some() && (MISTAKABLE.contains(&word) || ends_with_unit(&name));
        if is_mistakable || found.iter().any(|(_, other)| !is_same(&unit, other)) {
            return Err(self.unclear(&unit, &unit));
        }
        // Letters such as s and m are names of quantities as well; in SI the numbers are the same.
        let is_letter = word.chars().count() == 1 && !has_slash;
        Ok(Some((name, Some(unit).filter(|_| !is_letter))))
    }

    /// The last word, if it is a unit and no number, and the name before it.
    fn last_word(&self) -> Option<(String, Unit)> {
        let at = self.text.rfind(BEFORE_LAST)?;
        let separator = self.text[at..].chars().next().map_or(1, char::len_utf8);
        let unit = word(&self.text[at + separator..])?;
        let name = name_alone(&self.text[..at]);
        (!name.is_empty()).then(|| (name.to_owned(), unit))
    }

    fn no_unit(&self, text: &str) -> String {
        let why = inside(text).err().map_or_else(|| format!("`{text}` is not a unit"), |wrong| wrong.to_string());
        format!("the unit in `{}`: {why}", self.text)
    }

    fn unclear(&self, unit: &Unit, si: &Unit) -> SheetError {
        let (text, unit, si) = (&self.text, unit.shown(), if si.si.is_empty() { "1" } else { &si.si });
        self.fault(format!(
            "the end of `{text}` could be a unit or part of the name; write the unit in square brackets, such as `{text} [{unit}]` or `{text} [{si}]`"
        ))
    }
}

/// The places of brackets with what they hold that stand in no others.
fn groups(text: &str) -> Vec<(usize, usize)> {
    let mut groups = Vec::new();
    let mut open: Vec<(char, usize)> = Vec::new();
    for (at, c) in text.char_indices() {
        if let Some([_, closing]) = BRACKETS.iter().find(|[opening, _]| *opening == c) {
            open.push((*closing, at));
        } else if let Some((_, start)) = open.pop_if(|(closing, _)| *closing == c)
            && open.is_empty()
        {
            groups.push((start, at + c.len_utf8()));
        }
    }
    groups
}

/// What stands in brackets or in the row of units; a pure number has no unit.
fn inside(text: &str) -> Result<Option<Unit>, UnitError> {
    let text = text.trim();
    let bare = BRACKETS.iter().find_map(|[open, close]| text.strip_prefix(*open)?.strip_suffix(*close));
    let bare = bare.unwrap_or(text).trim();
    if matches!(bare, "" | "1" | "-") {
        return Ok(None);
    }
    unit::parse(&Text::from(bare)).map(Some).map_err(|wrong| UnitError(Box::new(wrong)))
}

/// The unit that a text is; none if it is a number.
fn parsed(text: &str) -> Option<Unit> {
    let text = text.trim();
    (!text.starts_with(|c: char| c.is_ascii_digit())).then(|| unit::parse(&Text::from(text)).ok())?
}

/// The unit that a word behind a name is.
fn word(text: &str) -> Option<Unit> {
    parsed(text).filter(|_| !POINTS.contains(&text.trim()))
}

/// A name without what leads to its unit.
fn name_alone(text: &str) -> &str {
    let text = text.trim().trim_end_matches([',', ':', '-', '_', '/', '=']).trim_end();
    text.strip_suffix(" in").unwrap_or(text).trim_end()
}

/// `torque N` of `torque N mm`
fn ends_with_unit(name: &str) -> bool {
    name.rfind(BEFORE_LAST).is_some_and(|at| word(name[at..].trim_start_matches(BEFORE_LAST)).is_some())
}

fn factor(unit: &Unit) -> f64 {
    unit.display.as_ref().map_or(1.0, |display| display.factor)
}

fn is_same(one: &Unit, other: &Unit) -> bool {
    one.exponents == other.exponents && factor(one) == factor(other)
}

#[cfg(test)]
mod tests {
    use super::super::Sheet;
    use super::*;

    fn heading(text: &str) -> Heading {
        let sheet = Sheet::read(&format!("time;{text}\n0;1\n")).unwrap();
        sheet.headings()[1].clone()
    }

    #[test]
    fn units_are_said_in_many_ways() {
        for text in [
            "Lift [mm]",
            "Lift (mm)",
            "Lift(mm)",
            "Lift {mm}",
            "Lift <mm>",
            "Lift / mm",
            "Lift/mm",
            "Lift/(mm)",
            "Lift_mm",
            "Lift mm",
            "Lift, mm",
            "Lift in mm",
            "Lift: mm",
            "Lift (left) [mm]",
            "Lift (mm) (left)",
        ] {
            let (name, unit) = heading(text).read().unwrap();
            assert_eq!(unit.map(|unit| factor(&unit)), Some(1e-3), "{text}");
            assert!(name.starts_with("Lift") && !name.contains("mm"), "{text}: {name}");
        }
        for (text, si, factor_) in [
            ("v / m/s", "m/s", 1.0),
            ("v (km/h)", "m/s", 1.0 / 3.6),
            ("n/rpm", "rad/s", std::f64::consts::TAU / 60.0),
            ("speed_rpm", "rad/s", std::f64::consts::TAU / 60.0),
            ("i [A]", "A", 1.0),
            ("i/A", "A", 1.0),
            ("i_mA", "A", 1e-3),
            ("u / kV", "V", 1e3),
        ] {
            let (_, unit) = heading(text).read().unwrap();
            let unit = unit.unwrap();
            assert_eq!(unit.si, si, "{text}");
            assert!((factor(&unit) - factor_).abs() < 1e-15 * factor_.max(1.0), "{text}");
        }
        for text in ["x_A", "lift C"] {
            assert_eq!(heading(text).read().unwrap(), (text.to_owned(), None), "a point, not a unit");
        }
        assert_eq!(heading("lift A mm").read().unwrap().0, "lift A");
        for text in ["Lift", "Lift [1]", "Lift (-)", "Lift [-]", "s", "h", "cam_s", "Lift 2", "lift_max"] {
            assert_eq!(heading(text).read().unwrap().1, None, "{text}");
        }
    }

    #[test]
    fn what_could_be_a_unit_and_is_none_is_refused() {
        for text in [
            "Lift (furlong)",
            "Lift [left]",
            "Lift (left)",
            "Lift (1)",
            "Lift/Stroke",
            "Lift / left",
            "Lift_min",
            "x_cm",
            "speed m/s",
            "Torque N mm",
            "Lift (mm) (deg)",
            "s/mm",
        ] {
            let error = heading(text).read().unwrap_err();
            assert_eq!((error.line, error.column), (1, 2), "{text}: {error}");
        }
    }

    #[test]
    fn names_of_variables_keep_their_ends() {
        let unit_of = |name: &str| match name {
            "x_cm" | "rod.x" => Some(Unit::length()),
            "share_mm" => Some(Unit::default()),
            "force_s" => Some(Unit::time()),
            _ => None,
        };
        let read =
            |text: &str| heading(text).of_variable(unit_of).map(|(name, unit)| (name, unit.map(|unit| factor(&unit))));
        assert_eq!(read("x_cm [m]"), Ok(("x_cm".to_owned(), Some(1.0))));
        assert_eq!(read("rod.x_cm"), Ok(("rod.x".to_owned(), Some(0.01))));
        assert_eq!(read("rod.x (mm)"), Ok(("rod.x".to_owned(), Some(1e-3))));
        assert_eq!(read("share_mm"), Ok(("share_mm".to_owned(), None)));
        assert_eq!(read("force_s"), Ok(("force_s".to_owned(), None)));
        assert_eq!(read("other_mm"), Ok(("other_mm".to_owned(), None)));
        assert!(read("x_cm").unwrap_err().message.contains("`x_cm [m]`"));
    }

    #[test]
    fn a_row_of_units_counts_and_must_agree() {
        let read = |text: &str| Sheet::read(text).unwrap().headings()[1].read();
        for text in
            ["t,Lift\ns,mm\n0,1\n", "t;Lift\n[s];[mm]\n0;1\n", "t,Lift [mm]\ns,mm\n0,1\n", "t Lift\n(s) (mm)\n0 1\n"]
        {
            assert_eq!(read(text).unwrap().1.map(|unit| factor(&unit)), Some(1e-3), "{text}");
        }
        assert_eq!(read("t,Lift\ns,-\n0,1\n").unwrap().1, None);
        let error = read("t,Lift\ns,furlong\n0,1\n").unwrap_err();
        assert_eq!((error.line, error.column), (2, 2), "{error}");
        assert!(read("t,Lift [cm]\ns,mm\n0,1\n").unwrap_err().message.contains("not the same unit"));
    }
}
