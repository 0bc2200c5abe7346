//! Formulas as plain text, with the fewest parentheses.

use super::{Binding, relation_binding};
use crate::print::number::{decimal, rounded};
use crate::print::tree::Tree;

/// A formula on one line.
pub fn plain(tree: &Tree) -> String {
    inner(tree).0
}

/// A formula on lines of about a width, broken before signs.
pub fn wrapped(tree: &Tree, width: usize) -> Vec<String> {
    let Tree::Sum(terms) = tree else { return vec![plain(tree)] };
    let mut lines = vec![String::new()];
    for (index, (minus, term)) in terms.iter().enumerate() {
        let text = bound(term, Binding::Product);
        let sign = match (index, minus) {
            (0, true) => "-",
            (0, false) => "",
            (_, true) => "- ",
            (_, false) => "+ ",
        };
        let last = lines.len() - 1;
        if index > 0 && lines[last].chars().count() + text.chars().count() + 3 > width {
            lines.push(format!("{sign}{text}"));
        } else {
            let gap = if index > 0 { " " } else { "" };
            lines[last].push_str(&format!("{gap}{sign}{text}"));
        }
    }
    lines
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
