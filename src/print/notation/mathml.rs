//! Formulas as MathML Core.

use std::fmt::Write;

use super::{Binding, compound, drawn_binding, greek, relation_binding};
use crate::print::name::Name;
use crate::print::number::{decimal, rounded};
use crate::print::tree::Tree;
use crate::report::svg::escape;

/// A formula within `math`.
pub fn mathml(tree: &Tree) -> String {
    let mut text = String::new();
    write(&mut text, tree);
    text
}

/// A row of a display: `left = right`, as the cells of a table that breaks long sums before signs.
pub fn equation(left: &Tree, right: &Tree, width: usize) -> String {
    let mut rows = format!("<mtr><mtd>{}</mtd><mtd><mrow><mo>=</mo>", mathml(left));
    match right {
        Tree::Sum(terms) => {
            let mut length = 0;
            for (index, term) in terms.iter().enumerate() {
                let printed = super::plain::plain(&term.1).chars().count() + 3;
                if length > 0 && length + printed > width {
                    rows.push_str("</mrow></mtd></mtr><mtr><mtd></mtd><mtd><mrow>");
                    length = 0;
                }
                length += printed;
                write_term(&mut rows, index, term);
            }
        }
        other => write(&mut rows, other),
    }
    rows.push_str("</mrow></mtd></mtr>");
    rows
}

fn write(text: &mut String, tree: &Tree) {
    match tree {
        Tree::Number(value) => number(text, *value),
        Tree::Pi => text.push_str("<mi>π</mi>"),
        Tree::Name(name) => self::name(text, name),
        Tree::Sum(terms) => {
            text.push_str("<mrow>");
            for (index, term) in terms.iter().enumerate() {
                write_term(text, index, term);
            }
            text.push_str("</mrow>");
        }
        Tree::Product(factors) => {
            text.push_str("<mrow>");
            for (index, factor) in factors.iter().enumerate() {
                if index > 0 {
                    // Words would run into each other.
                    let words = is_word(factor) || is_word(&factors[index - 1]);
                    text.push_str(if words { "<mo rspace=\"0.2em\">&#x2062;</mo>" } else { "<mo>&#x2062;</mo>" });
                }
                bound(text, factor, Binding::Product);
            }
            text.push_str("</mrow>");
        }
        Tree::Quotient(parts) => element(text, "mfrac", parts.as_ref(), Binding::Relation),
        Tree::Power(parts) => {
            text.push_str("<msup>");
            bound(text, &parts[0], Binding::Atom);
            write(text, &parts[1]);
            text.push_str("</msup>");
        }
        Tree::Root(inside) => element(text, "msqrt", std::slice::from_ref(inside.as_ref()), Binding::Relation),
        Tree::Call(function, arguments) => call(text, function, arguments),
        Tree::Relation(sign, parts) => {
            let printed = match *sign {
                "<=" => "≤",
                "." => "·",
                "x" => "×",
                other => other,
            };
            let least = relation_binding(sign);
            text.push_str("<mrow>");
            bound(text, &parts[0], least);
            // Writing to a string cannot fail.
            let _ = write!(text, "<mo>{}</mo>", escape(printed));
            bound(text, &parts[1], least);
            text.push_str("</mrow>");
        }
    }
}

/// Is it a name of more than one letter?
fn is_word(tree: &Tree) -> bool {
    match tree {
        Tree::Name(name) => greek(&name.base).is_none() && name.base.chars().nth(1).is_some(),
        Tree::Power(parts) => is_word(&parts[0]),
        _ => false,
    }
}

fn write_term(text: &mut String, index: usize, (minus, term): &(bool, Tree)) {
    match (index, minus) {
        (0, false) => {}
        (_, false) => text.push_str("<mo>+</mo>"),
        (_, true) => text.push_str("<mo>−</mo>"),
    }
    bound(text, term, Binding::Product);
}

fn element(text: &mut String, name: &str, parts: &[Tree], least: Binding) {
    // Writing to a string cannot fail.
    let _ = write!(text, "<{name}>");
    parts.iter().for_each(|part| bound(text, part, least));
    let _ = write!(text, "</{name}>");
}

fn bound(text: &mut String, tree: &Tree, least: Binding) {
    if drawn_binding(tree) < least {
        text.push_str("<mrow><mo>(</mo>");
        write(text, tree);
        text.push_str("<mo>)</mo></mrow>");
    } else {
        write(text, tree);
    }
}

fn call(text: &mut String, function: &str, arguments: &[Tree]) {
    let [open, close] = match function {
        "abs" => ["<mo>|</mo>", "<mo>|</mo>"],
        "floor" => ["<mo>⌊</mo>", "<mo>⌋</mo>"],
        _ => ["<mo>(</mo>", "<mo>)</mo>"],
    };
    text.push_str("<mrow>");
    if !matches!(function, "abs" | "floor" | "") {
        let name = match function {
            "log" => "ln",
            "asin" => "arcsin",
            "acos" => "arccos",
            "atan" => "arctan",
            other => other,
        };
        // Writing to a string cannot fail.
        let _ = write!(text, "<mi>{name}</mi><mo>&#x2061;</mo>");
    }
    text.push_str(open);
    for (index, argument) in arguments.iter().enumerate() {
        if index > 0 {
            text.push_str("<mo>,</mo>");
        }
        write(text, argument);
    }
    text.push_str(close);
    text.push_str("</mrow>");
}

fn number(text: &mut String, value: f64) {
    let digits = decimal(rounded(value));
    // Writing to a string cannot fail.
    let _ = match digits.split_once('e') {
        Some((mantissa, exponent)) => {
            write!(text, "<mrow><mn>{mantissa}</mn><mo>·</mo><msup><mn>10</mn><mn>{exponent}</mn></msup></mrow>")
        }
        None => write!(text, "<mn>{digits}</mn>"),
    };
}

fn name(text: &mut String, name: &Name) {
    let letter = match compound(&name.base) {
        Some((letter, below)) => {
            format!("<mrow><mo>[</mo><msub>{}<mi>{below}</mi></msub><mo>]</mo></mrow>", self::letter(letter, name.bold))
        }
        None => self::letter(&name.base, name.bold),
    };
    let dotted = match name.dots {
        0 => letter,
        1 => format!("<mover>{letter}<mo>˙</mo></mover>"),
        _ => format!("<mover>{letter}<mo>¨</mo></mover>"),
    };
    // Writing to a string cannot fail.
    let _ = match name.subscript.as_str() {
        "" => write!(text, "{dotted}"),
        below => write!(text, "<msub>{dotted}<mtext>{}</mtext></msub>", escape(below)),
    };
}

fn letter(base: &str, bold: bool) -> String {
    let sign = greek(base).map_or_else(|| escape(base), str::to_owned);
    let style = if bold { " style=\"font-weight:bold\"" } else { "" };
    format!("<mi{style}>{sign}</mi>")
}
