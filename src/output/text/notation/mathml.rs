//! Formulas as MathML Core.

use std::fmt::Write;

use super::lines::{Part, Printed, lines};
use super::{Binding, compound, drawn_binding, greek, relation_binding, shown};
use crate::expr::Shown;
use crate::output::svg::escape;
use crate::output::text::name::Name;
use crate::output::text::number::{decimal, rounded};
use crate::output::text::tree::Tree;

/// A formula within `math`.
pub fn mathml(tree: &Tree) -> String {
    let mut text = String::new();
    write(&mut text, tree);
    text
}

/// A formula on lines of about a width, in digits, each the inside of an `mrow`.
pub fn wrapped(tree: &Tree, width: f64) -> Vec<String> {
    let line = |parts: Vec<Part>| {
        let mut text = String::new();
        for (index, part) in parts.iter().enumerate() {
            write_part(&mut text, part, index == 0);
        }
        text
    };
    lines(tree, width, &Printed).into_iter().map(line).collect()
}

fn write_part(text: &mut String, part: &Part, begins_line: bool) {
    match part {
        Part::Whole(tree, least) => bound(text, tree, *least),
        Part::Sign { minus: false, first: true } => {}
        Part::Sign { minus, .. } => text.push_str(if *minus { "<mo>−</mo>" } else { "<mo>+</mo>" }),
        Part::Relation(sign) => relation(text, sign),
        Part::Times if begins_line => text.push_str("<mo>×</mo>"),
        Part::Times => text.push_str("<mo rspace=\"0.2em\">&#x2062;</mo>"),
        Part::Comma => text.push_str("<mo>,</mo>"),
        Part::Over => text.push_str("<mo>/</mo>"),
        Part::Open(function) => {
            let (name, [open, _]) = call_signs(function.unwrap_or(""));
            // Writing to a string cannot fail.
            let _ = write!(text, "{name}<mo stretchy=\"false\">{open}</mo>");
        }
        Part::Close(function, exponent) => {
            let (_, [_, close]) = call_signs(function.unwrap_or(""));
            let sign = format!("<mo stretchy=\"false\">{close}</mo>");
            let _ = match exponent {
                Some(exponent) => write!(text, "<msup>{sign}{}</msup>", mathml(exponent)),
                None => write!(text, "{sign}"),
            };
        }
    }
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
            let least = relation_binding(sign);
            text.push_str("<mrow>");
            bound(text, &parts[0], least);
            relation(text, sign);
            bound(text, &parts[1], least);
            text.push_str("</mrow>");
        }
    }
}

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
    let (name, [open, close]) = call_signs(function);
    // Writing to a string cannot fail.
    let _ = write!(text, "<mrow>{name}<mo>{open}</mo>");
    for (index, argument) in arguments.iter().enumerate() {
        if index > 0 {
            text.push_str("<mo>,</mo>");
        }
        write(text, argument);
    }
    let _ = write!(text, "<mo>{close}</mo></mrow>");
}

fn call_signs(function: &str) -> (String, [&'static str; 2]) {
    let name = match shown(function) {
        Shown::Between(open, close) => return (String::new(), [open, close]),
        _ if function.is_empty() => return (String::new(), ["(", ")"]),
        Shown::Command(name) => name,
        Shown::Word | Shown::Operator => function,
    };
    (format!("<mi>{name}</mi><mo>&#x2061;</mo>"), ["(", ")"])
}

fn relation(text: &mut String, sign: &str) {
    let printed = match sign {
        "<=" => "≤",
        "." => "·",
        "x" => "×",
        other => other,
    };
    // Writing to a string cannot fail.
    let _ = write!(text, "<mo>{}</mo>", escape(printed));
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
    let letter = match compound(name) {
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
