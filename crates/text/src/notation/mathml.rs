//! Formulas as MathML Core.

use cotree::expr::Shown;
use cotree_draw::svg::escape;

use super::lines::printed_part;
use super::{Binding, Notation, compound, greek, shown};
use crate::name::Name;
use crate::number::{decimal, rounded};

/// Within `math` or `mrow`.
pub const MATHML: Notation = Notation {
    pi: "<mi>π</mi>",
    comma: "<mo>,</mo>",
    number,
    name,
    parenthesised: |inside| format!("<mrow><mo>(</mo>{inside}<mo>)</mo></mrow>"),
    row: |inside| format!("<mrow>{inside}</mrow>"),
    signs: ["<mo>−</mo>", "<mo>−</mo>", "<mo>+</mo>"],
    times: ["<mo>&#x2062;</mo>", "<mo rspace=\"0.2em\">&#x2062;</mo>", "<mo>×</mo>"],
    relation: |sign| format!("<mo>{}</mo>", escape(relation(sign))),
    quotient: (|over, under| format!("<mfrac>{over}{under}</mfrac>"), [Binding::Relation; 2]),
    power: (|base, exponent| format!("<msup>{base}{exponent}</msup>"), Binding::Relation),
    root: |inside| format!("<msqrt>{inside}</msqrt>"),
    brackets,
    call: |name, [open, close], arguments| format!("<mrow>{name}<mo>{open}</mo>{arguments}<mo>{close}</mo></mrow>"),
    open: |name, open| format!("{name}<mo stretchy=\"false\">{open}</mo>"),
    close: |close| format!("<mo stretchy=\"false\">{close}</mo>"),
    over: "<mo>/</mo>",
    line: |parts| parts,
    width: printed_part,
};

fn brackets(function: &str) -> (String, [&'static str; 2]) {
    let name = match shown(function) {
        Shown::Between(open, close) => return (String::new(), [open, close]),
        _ if function.is_empty() => return (String::new(), ["(", ")"]),
        Shown::Command(name) => name,
        Shown::Word | Shown::Operator => function,
    };
    (format!("<mi>{name}</mi><mo>&#x2061;</mo>"), ["(", ")"])
}

fn relation(sign: &str) -> &str {
    match sign {
        "<=" => "≤",
        "." => "·",
        "x" => "×",
        other => other,
    }
}

fn number(value: f64) -> String {
    let digits = decimal(rounded(value));
    match digits.split_once('e') {
        Some((mantissa, exponent)) => {
            format!("<mrow><mn>{mantissa}</mn><mo>·</mo><msup><mn>10</mn><mn>{exponent}</mn></msup></mrow>")
        }
        None => format!("<mn>{digits}</mn>"),
    }
}

fn name(name: &Name) -> String {
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
    match name.subscript.as_str() {
        "" => dotted,
        below => format!("<msub>{dotted}<mtext>{}</mtext></msub>", escape(below)),
    }
}

fn letter(base: &str, bold: bool) -> String {
    let sign = if base == "->" { Some("→") } else { greek(base) };
    let sign = sign.map_or_else(|| escape(base), str::to_owned);
    let style = if bold { " style=\"font-weight:bold\"" } else { "" };
    format!("<mi{style}>{sign}</mi>")
}
