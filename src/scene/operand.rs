//! Sums and products of what is written, as text: numbers stay numbers.

use super::quantity::{Quantity, Reading, Value, read};
use super::unit::compatible;
use crate::diagnostic::span::{Span, Text};
use crate::mechanism::measure::Wanted;

/// What stands for one metre in expressions that are put together here: a number in them has no unit. No variable of a scene has this name.
pub(crate) const METRE: &str = "unit.m";

/// A number or an expression.
#[derive(Clone, Debug, PartialEq)]
pub enum Operand {
    Number(f64),
    /// A number with its unit as they are written, and the value in SI.
    Measure(f64, String, f64),
    /// In parentheses where it needs them.
    Text(String),
}

impl Operand {
    /// What is written; none if it is no such value, which is reported where it is read.
    pub fn of(quantity: &Quantity, wanted: &Wanted) -> Option<Operand> {
        let text = match &quantity.value {
            Value::Number(number) => return Some(Operand::Number(*number)),
            Value::Text(text) => text,
        };
        match read(&Text::from(text.as_str())).ok()? {
            Reading::Number(number) => Some(Operand::Number(number)),
            Reading::Measure(value, unit) => {
                let fits = wanted.exponents.is_none_or(|wanted| compatible(unit.exponents, wanted));
                let end = text.len() - text.trim_start_matches(is_of_number).len();
                let measure = |number| Operand::Measure(number, text[end..].trim().to_owned(), value);
                let is_whole = !text[end..].starts_with(['e', 'E']);
                let number = text[..end].trim().parse().ok().filter(|_| is_whole);
                fits.then(|| number.map_or(Operand::Number(value), measure))
            }
            Reading::Expression => Some(Operand::Text(format!("({text})"))),
        }
    }

    pub fn negated(self) -> Operand {
        match self {
            Operand::Number(number) => Operand::Number(-number),
            Operand::Measure(number, unit, value) => Operand::Measure(-number, unit, -value),
            Operand::Text(text) => Operand::Text(format!("(-{text})")),
        }
    }

    /// In SI, without the unit as it is written.
    fn plain(self) -> Operand {
        if let Operand::Measure(.., value) = self { Operand::Number(value) } else { self }
    }

    /// A number in metres, to be a factor of an expression.
    pub fn in_metres(self) -> Operand {
        match self.plain() {
            Operand::Number(number) => Operand::Text(format!("({number:e}*{METRE})")),
            other => other,
        }
    }

    pub fn is_text(&self) -> bool {
        matches!(self, Operand::Text(_))
    }

    pub fn plus(self, other: Operand) -> Operand {
        match (self.plain(), other.plain()) {
            (Operand::Number(a), Operand::Number(b)) => Operand::Number(a + b),
            (Operand::Number(0.0), other) | (other, Operand::Number(0.0)) => other,
            (a, b) => Operand::Text(format!("({} + {})", a.text(), b.text())),
        }
    }

    pub fn times(self, other: Operand) -> Operand {
        match (self.plain(), other.plain()) {
            (Operand::Number(0.0), _) | (_, Operand::Number(0.0)) => Operand::Number(0.0),
            (Operand::Number(a), Operand::Number(b)) => Operand::Number(a * b),
            (a, b) => Operand::Text(format!("{}*{}", a.text(), b.text())),
        }
    }

    pub fn over(self, other: Operand) -> Operand {
        match (self.plain(), other.plain()) {
            (Operand::Number(a), Operand::Number(b)) => Operand::Number(a / b),
            (a, b) => Operand::Text(format!("({}/{})", a.text(), b.text())),
        }
    }

    /// `sin` or `cos` of it.
    pub fn of_function(&self, name: &str) -> Operand {
        Operand::Text(format!("{name}({})", self.text()))
    }

    pub fn text(&self) -> String {
        match self {
            Operand::Number(number) | Operand::Measure(.., number) if *number < 0.0 => format!("({number:e})"),
            Operand::Number(number) | Operand::Measure(.., number) => format!("{number:e}"),
            Operand::Text(text) => text.clone(),
        }
    }

    /// As it would be written at a place.
    pub fn at(self, span: Span) -> Quantity {
        let value = match self {
            // Adding zero makes a negative zero positive.
            Operand::Number(number) => Value::Number(number + 0.0),
            Operand::Measure(number, unit, _) => Value::Text(format!("{} {unit}", number + 0.0)),
            Operand::Text(text) => Value::Text(text),
        };
        Quantity { value, span }
    }
}

/// May it stand in a number without an exponent?
fn is_of_number(c: char) -> bool {
    c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | ' ')
}
