//! Formulas as plain text, with the fewest parentheses.

use super::lines::{Measure, Part, lines};
use super::{Binding, relation_binding};
use crate::output::text::number::{decimal, rounded};
use crate::output::text::tree::Tree;

pub fn plain(tree: &Tree) -> String {
    inner(tree).0
}

pub fn wrapped(tree: &Tree, width: f64) -> Vec<String> {
    let line = |parts: Vec<Part>| {
        let text: String = parts.iter().enumerate().map(|(index, part)| written(part, index == 0)).collect();
        text.trim_end().to_owned()
    };
    lines(tree, width, &Characters).into_iter().map(line).collect()
}

struct Characters;

impl Measure for Characters {
    fn width(&self, part: &Part) -> f64 {
        written(part, false).chars().count() as f64
    }
}

fn written(part: &Part, begins_line: bool) -> String {
    let gap = if begins_line { "" } else { " " };
    match part {
        Part::Whole(tree, least) => bound(tree, *least),
        Part::Sign { minus, first: true } => if *minus { "-" } else { "" }.to_owned(),
        Part::Sign { minus, .. } => format!("{gap}{} ", if *minus { "-" } else { "+" }),
        Part::Relation(sign) => format!("{gap}{sign} "),
        Part::Times => if begins_line { "* " } else { "*" }.to_owned(),
        Part::Comma => ", ".to_owned(),
        Part::Over => "/".to_owned(),
        Part::Open(function) => format!("{}(", function.unwrap_or("")),
        Part::Close(_, exponent) => match exponent {
            Some(exponent) => format!(")^{}", bound(exponent, Binding::Atom)),
            None => ")".to_owned(),
        },
    }
}

fn bound(tree: &Tree, least: Binding) -> String {
    let (text, binding) = inner(tree);
    if binding < least { format!("({text})") } else { text }
}

fn inner(tree: &Tree) -> (String, Binding) {
    match tree {
        Tree::Number(value) => (decimal(rounded(*value)), Binding::Atom),
        Tree::Pi => ("pi".to_owned(), Binding::Atom),
        Tree::Name(name) => (name.plain.clone(), Binding::Atom),
        Tree::Sum(terms) => (sum(terms), Binding::Sum),
        Tree::Product(factors) => {
            let factors: Vec<String> = factors.iter().map(|factor| bound(factor, Binding::Product)).collect();
            (factors.join("*"), Binding::Product)
        }
        Tree::Quotient(parts) => {
            let [over, under] = parts.as_ref();
            (format!("{}/{}", bound(over, Binding::Product), bound(under, Binding::Power)), Binding::Product)
        }
        Tree::Power(parts) => {
            let [base, exponent] = parts.as_ref();
            (format!("{}^{}", bound(base, Binding::Atom), bound(exponent, Binding::Atom)), Binding::Power)
        }
        Tree::Root(inside) => (format!("sqrt({})", plain(inside)), Binding::Atom),
        Tree::Call(name, arguments) => {
            let arguments: Vec<String> = arguments.iter().map(plain).collect();
            (format!("{name}({})", arguments.join(", ")), Binding::Atom)
        }
        Tree::Relation(sign, parts) => {
            let [left, right] = parts.as_ref();
            let binding = relation_binding(sign);
            let least = if binding == Binding::Product { Binding::Product } else { Binding::Sum };
            (format!("{} {sign} {}", bound(left, least), bound(right, least)), binding)
        }
    }
}

fn sum(terms: &[(bool, Tree)]) -> String {
    let mut text = String::new();
    for (index, (minus, term)) in terms.iter().enumerate() {
        text.push_str(match (index, minus) {
            (0, true) => "-",
            (0, false) => "",
            (_, true) => " - ",
            (_, false) => " + ",
        });
        text.push_str(&bound(term, Binding::Product));
    }
    text
}
