//! Straight-line code in all languages: one walker, and a table of patterns for each language.

use cotree::expr::Symbol;

use super::{CodeBlock, Operand, Sizes, Statement, argument};

/// How a language writes lines of straight-line code. In its patterns `{x}` is a result, `{v}` a value and `{a}`, `{b}`, `{c}` operands.
#[derive(Debug)]
pub struct Syntax {
    pub column: usize,
    /// `{x} = {v}`
    pub assign: &'static str,
    /// `{v}` at the place `{x}` of an array.
    pub store: &'static str,
    /// `{b}` if `{a}` is not zero, else `{c}`
    pub select: &'static str,
    /// `{x}` and `{y}` are sine and cosine of `{a}`.
    pub sine_cosine: &'static str,
    /// The call of a function `{f}` with its arguments; `{a}` is the first of them and `{b}` the others.
    pub call: &'static str,
    pub special: [&'static str; 3],
    pub suffix: &'static str,
    /// Do negative numbers stand in parentheses?
    pub parentheses: bool,
    pub renamed: &'static [(&'static str, &'static str)],
    /// The place of an entry in a vector, or in a matrix with so many columns.
    pub place: fn([usize; 2], Option<usize>) -> String,
}

impl Syntax {
    pub fn array<'n>(&self, name: &'n str) -> &'n str {
        self.renamed.iter().find(|(reserved, _)| *reserved == name).map_or(name, |(_, renamed)| renamed)
    }

    pub fn lines(&self, steps: &[Statement], sizes: &Sizes) -> String {
        steps.iter().map(|step| self.line(step, sizes)).collect()
    }

    fn line(&self, step: &Statement, sizes: &Sizes) -> String {
        let assigned =
            |number: usize, value: String| fill(self.assign, &[("{x}", &format!("x{number}")), ("{v}", &value)]);
        match *step {
            Statement::One(number, function, a) => {
                assigned(number, self.called(function.definition().in_code(self.column), &[a]))
            }
            Statement::Two(number, function, a, b) => {
                assigned(number, self.called(function.definition().in_code(self.column), &[a, b]))
            }
            Statement::Select(number, a, b, c) => assigned(number, self.filled(self.select, &[a, b, c])),
            Statement::SineCosine([sine, cosine], angle) => fill(
                &self.filled(self.sine_cosine, &[angle]),
                &[("{x}", &format!("x{sine}")), ("{y}", &format!("x{cosine}"))],
            ),
            Statement::Store(output, [row, column], value) => {
                let columns = output.is_matrix().then(|| output.shape(sizes)[1]);
                let place = format!("{}{}", self.array(output.name()), (self.place)([row, column], columns));
                fill(self.store, &[("{x}", &place), ("{v}", &self.operand(value))])
            }
        }
    }

    fn filled(&self, pattern: &str, operands: &[Operand]) -> String {
        let operands: Vec<String> = operands.iter().map(|&operand| self.operand(operand)).collect();
        let places: Vec<(&str, &str)> =
            ["{a}", "{b}", "{c}"].into_iter().zip(operands.iter().map(String::as_str)).collect();
        fill(pattern, &places)
    }

    /// An operator or a function: a pattern, or a name.
    fn called(&self, function: &str, operands: &[Operand]) -> String {
        if function.contains('{') {
            return self.filled(function, operands);
        }
        let mut written = operands.iter().map(|&operand| self.operand(operand));
        let mut first = written.next().unwrap_or_default();
        // A method would bind more tightly than a minus.
        if self.call.starts_with("{a}") && first.starts_with('-') {
            first = format!("({first})");
        }
        let others: Vec<String> = written.collect();
        let comma = if others.is_empty() || self.call.starts_with("{a}") { "" } else { ", " };
        fill(self.call, &[("{f}", function), ("{a}", &first), ("{b}", &format!("{comma}{}", others.join(", ")))])
    }

    fn operand(&self, operand: Operand) -> String {
        let [nan, infinity, minus_infinity] = self.special;
        match operand {
            Operand::Number(value) if value.is_nan() => nan.to_owned(),
            Operand::Number(f64::INFINITY) => infinity.to_owned(),
            Operand::Number(f64::NEG_INFINITY) => minus_infinity.to_owned(),
            Operand::Number(value) if value < 0.0 && self.parentheses => format!("({value:e}{})", self.suffix),
            Operand::Number(value) => format!("{value:e}{}", self.suffix),
            Operand::Symbol(Symbol::Time) => "t".to_owned(),
            Operand::Symbol(symbol) => argument(symbol).map_or_else(
                || nan.to_owned(),
                |(array, index)| format!("{}{}", self.array(array), (self.place)([index, 0], None)),
            ),
            Operand::Result(index) => format!("x{index}"),
        }
    }
}

fn fill(pattern: &str, places: &[(&str, &str)]) -> String {
    places.iter().fold(pattern.to_owned(), |text, (mark, written)| text.replace(mark, written))
}

impl CodeBlock {
    pub fn described(self, sizes: &Sizes) -> String {
        let [rows, columns] = self.shape(sizes);
        if self.is_matrix() { format!("{} {rows} x {columns}", self.name()) } else { format!("{} {rows}", self.name()) }
    }
}
