//! Long formulas on several lines, broken before signs, also within parentheses.

use super::{Binding, binding, compound, greek, relation_binding, side_binding};
use crate::name::Name;
use crate::number::{decimal, rounded};
use crate::tree::FormulaTree;

/// Terms of the whole formula that take less of a line stay in one piece.
const TERM: f64 = 0.9;
const FACTOR: f64 = 0.5;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FormulaPart<'t> {
    /// A formula in one piece, in parentheses if it binds less tightly.
    Whole(&'t FormulaTree, Binding),
    /// The sign of a term; a first term has one only if it is minus.
    Sign {
        minus: bool,
        first: bool,
    },
    Times,
    Comma,
    Relation(&'static str),
    /// An opening parenthesis, behind the name of a function.
    Open(Option<&'static str>),
    /// The closing parenthesis of a function, or of a base with its exponent.
    Close(Option<&'static str>, Option<&'t FormulaTree>),
    Over,
}

/// A part, how deep in parentheses it stands, and how wide it is.
struct PlacedPart<'t> {
    part: FormulaPart<'t>,
    depth: usize,
    width: f64,
}

/// The parts of a formula on lines of at most a width, as far as it can be broken.
pub fn lines<'t>(tree: &'t FormulaTree, limit: f64, width: fn(&FormulaPart) -> f64) -> Vec<Vec<FormulaPart<'t>>> {
    let mut breaker = Breaker { width, limit, parts: Vec::new(), depth: 0 };
    breaker.add(tree, Binding::Relation);
    breaker.lines()
}

struct Breaker<'t> {
    width: fn(&FormulaPart) -> f64,
    limit: f64,
    parts: Vec<PlacedPart<'t>>,
    depth: usize,
}

impl<'t> Breaker<'t> {
    fn push(&mut self, part: FormulaPart<'t>) {
        self.parts.push(PlacedPart { part, depth: self.depth, width: (self.width)(&part) });
    }

    fn fits(&self, tree: &'t FormulaTree, least: Binding) -> bool {
        let share = match self.depth {
            _ if self.parts.is_empty() => 1.0,
            0 => TERM,
            _ => FACTOR,
        };
        (self.width)(&FormulaPart::Whole(tree, least)) <= share * self.limit
    }

    /// An operand that must bind at least so tightly.
    fn add(&mut self, tree: &'t FormulaTree, least: Binding) {
        if self.fits(tree, least) {
            return self.push(FormulaPart::Whole(tree, least));
        }
        match tree {
            FormulaTree::Number(_) | FormulaTree::Pi | FormulaTree::Name(_) => {
                self.push(FormulaPart::Whole(tree, least))
            }
            FormulaTree::Sum(terms) => self.within(Binding::Sum < least, |breaker| breaker.sum(terms)),
            FormulaTree::Product(factors) => self.within(Binding::Product < least, |breaker| {
                for (index, factor) in factors.iter().enumerate() {
                    if index > 0 {
                        breaker.push(FormulaPart::Times);
                    }
                    breaker.add(factor, Binding::Product);
                }
            }),
            FormulaTree::Quotient(parts) => self.within(Binding::Product < least, |breaker| {
                let [over, under] = parts.as_ref();
                breaker.add(over, Binding::Product);
                breaker.push(FormulaPart::Over);
                breaker.add(under, Binding::Power);
            }),
            FormulaTree::Power(parts) => {
                let [base, exponent] = parts.as_ref();
                self.parenthesized(None, Some(exponent), |breaker| breaker.add(base, Binding::Relation));
            }
            FormulaTree::Root(inside) => {
                self.parenthesized(Some("sqrt"), None, |breaker| breaker.add(inside, Binding::Relation));
            }
            FormulaTree::Call(function, arguments) => self.parenthesized(Some(function), None, |breaker| {
                for (index, argument) in arguments.iter().enumerate() {
                    if index > 0 {
                        breaker.push(FormulaPart::Comma);
                    }
                    breaker.add(argument, Binding::Relation);
                }
            }),
            FormulaTree::Relation(sign, parts) => {
                let ([left, right], side) = (parts.as_ref(), side_binding(sign));
                self.within(relation_binding(sign) < least, |breaker| {
                    breaker.add(left, side);
                    breaker.push(FormulaPart::Relation(sign));
                    breaker.add(right, side);
                });
            }
        }
    }

    fn sum(&mut self, terms: &'t [(bool, FormulaTree)]) {
        for (index, (minus, term)) in terms.iter().enumerate() {
            self.push(FormulaPart::Sign { minus: *minus, first: index == 0 });
            self.add(term, Binding::Product);
        }
    }

    fn within(&mut self, parentheses: bool, inside: impl FnOnce(&mut Self)) {
        match parentheses {
            true => self.parenthesized(None, None, inside),
            false => inside(self),
        }
    }

    fn parenthesized(
        &mut self,
        function: Option<&'static str>,
        exponent: Option<&'t FormulaTree>,
        inside: impl FnOnce(&mut Self),
    ) {
        self.push(FormulaPart::Open(function));
        self.depth += 1;
        inside(self);
        self.depth -= 1;
        self.push(FormulaPart::Close(function, exponent));
    }

    /// Fills the lines; each is broken where little space is lost and few parentheses are open.
    fn lines(self) -> Vec<Vec<FormulaPart<'t>>> {
        let mut lines = Vec::new();
        let mut rest = self.parts.as_slice();
        while let Some(count) = line_end(rest, self.limit) {
            let (line, others) = rest.split_at(count);
            lines.push(line.iter().map(|placed| placed.part).collect());
            rest = others;
        }
        lines.push(rest.iter().map(|placed| placed.part).collect());
        lines
    }
}

/// How many parts stand on the first line; none if all of them do.
fn line_end(parts: &[PlacedPart], limit: f64) -> Option<usize> {
    let mut width = 0.0;
    let mut best: Option<(f64, usize)> = None;
    for (index, placed) in parts.iter().enumerate() {
        let behind_comma = index > 0 && parts[index - 1].part == FormulaPart::Comma;
        if index > 0
            && let Some(cost) = cost(&placed.part, behind_comma)
        {
            let score = width / limit - 0.4 * placed.depth as f64 - cost;
            best = best.filter(|(other, _)| *other >= score).or(Some((score, index)));
        }
        width += placed.width;
        if width > limit
            && let Some((_, index)) = best
        {
            return Some(index);
        }
    }
    None
}

/// The cost of a break before a part, if it is permitted.
fn cost(part: &FormulaPart, behind_comma: bool) -> Option<f64> {
    match part {
        FormulaPart::Sign { first: false, .. } | FormulaPart::Relation(_) => Some(0.0),
        FormulaPart::Times => Some(0.3),
        _ => behind_comma.then_some(0.1),
    }
}

/// How wide parts are where letters are proportional and subscripts are small.
pub fn printed_part(part: &FormulaPart) -> f64 {
    match part {
        FormulaPart::Whole(tree, least) => bound(tree, *least),
        FormulaPart::Sign { minus: false, first: true } => 0.0,
        FormulaPart::Sign { first: true, .. } => 1.7,
        FormulaPart::Sign { .. } | FormulaPart::Relation(_) => 2.6,
        FormulaPart::Times => 0.4,
        FormulaPart::Comma | FormulaPart::Over => 1.2,
        FormulaPart::Open(function) => 1.2 + function.map_or(0.0, |name| name.len() as f64),
        FormulaPart::Close(_, exponent) => 1.2 + exponent.map_or(0.0, |tree| 0.75 * printed(tree)),
    }
}

/// The width of a formula in a serif font, in digits.
fn printed(tree: &FormulaTree) -> f64 {
    let all = |trees: &[FormulaTree]| trees.iter().map(printed).sum::<f64>();
    match tree {
        FormulaTree::Number(value) => decimal(rounded(*value)).len() as f64,
        FormulaTree::Pi => 1.2,
        FormulaTree::Name(name) => name_width(name),
        FormulaTree::Sum(terms) => terms.iter().map(|(_, term)| 2.6 + bound(term, Binding::Product)).sum(),
        FormulaTree::Product(factors) => factors.iter().map(|factor| 0.4 + bound(factor, Binding::Product)).sum(),
        FormulaTree::Quotient(parts) => 0.6 + printed(&parts[0]).max(printed(&parts[1])),
        FormulaTree::Power(parts) => bound(&parts[0], Binding::Atom) + 0.75 * printed(&parts[1]),
        FormulaTree::Root(inside) => 2.0 + printed(inside),
        FormulaTree::Call(function, arguments) => {
            function.len() as f64 + 2.0 + all(arguments) + 1.2 * arguments.len() as f64
        }
        FormulaTree::Relation(_, parts) => 4.6 + all(parts.as_ref()),
    }
}

fn bound(tree: &FormulaTree, least: Binding) -> f64 {
    printed(tree) + if binding(tree) < least { 1.8 } else { 0.0 }
}

fn name_width(name: &Name) -> f64 {
    let letters = match compound(name) {
        Some(_) => 3.6,
        None if greek(&name.base).is_some() => 1.3,
        None => 1.1 * name.base.chars().count() as f64,
    };
    letters + 0.8 * name.subscript.chars().count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notation::plain::PLAIN;

    fn name(word: &str) -> FormulaTree {
        FormulaTree::Name(Name::word(word))
    }

    /// a*(b1 + ... + b9)
    fn long() -> FormulaTree {
        let terms = (1..10).map(|index| (index % 2 == 0, name(&format!("b{index}"))));
        FormulaTree::Product(vec![name("a"), FormulaTree::Sum(terms.collect())])
    }

    #[test]
    fn long_parentheses_are_broken_before_signs() {
        let lines = PLAIN.wrapped(&long(), 22.0);
        assert_eq!(lines, ["a*(b1 - b2 + b3 - b4", "+ b5 - b6 + b7 - b8", "+ b9)"]);
        assert_eq!(PLAIN.wrapped(&long(), 100.0), [PLAIN.formula(&long())]);
    }

    #[test]
    fn functions_fractions_and_powers_are_broken_inside() {
        let root = FormulaTree::Root(Box::new(long()));
        let quotient = FormulaTree::Quotient(Box::new([root, FormulaTree::power(long(), FormulaTree::Number(2.0))]));
        let formula = FormulaTree::Call("min", vec![quotient, name("c")]);
        let lines = PLAIN.wrapped(&formula, 24.0);
        assert!(lines.iter().all(|line| line.chars().count() <= 24), "{lines:#?}");
        let bare = |text: &str| text.replace(' ', "");
        let whole = bare(&PLAIN.formula(&formula));
        assert_eq!(bare(&lines.concat()), whole);
    }

    #[test]
    fn what_cannot_be_broken_stays_whole() {
        let lines = PLAIN.wrapped(&name("a_very_long_name_indeed"), 5.0);
        assert_eq!(lines, ["a_very_long_name_indeed"]);
    }
}
