//! Formulas as LaTeX.

use cotree::expr::Shown;

use super::lines::printed_part;
use super::{Binding, Notation, compound, greek, shown};
use crate::name::Name;
use crate::number::{decimal, rounded};

/// For math mode.
pub const LATEX: Notation = Notation {
    pi: r"\pi",
    comma: ", ",
    number,
    name,
    parenthesised: |inside| format!(r"\left({inside}\right)"),
    row: |inside| inside,
    signs: ["-", " - ", " + "],
    times: [r"\,", r"\,", r"\times "],
    relation: |sign| format!(" {} ", relation(sign)),
    quotient: (|over, under| format!(r"\frac{{{over}}}{{{under}}}"), [Binding::Relation; 2]),
    // A dot or a subscript binds more tightly than an exponent, a fraction does not.
    power: (|base, exponent| format!("{base}^{{{exponent}}}"), Binding::Relation),
    root: |inside| format!(r"\sqrt{{{inside}}}"),
    brackets,
    call: |name, [open, close], arguments| format!(r"{name}\left{open}{arguments}\right{close}"),
    open: |name, open| format!(r"{name}\Bigl{open}"),
    close: |close| format!(r"\Bigr{close}"),
    over: r"\Big/ ",
    line: |parts| parts,
    width: printed_part,
};

/// Text outside math mode.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' => escaped.push_str(r"\textbackslash{}"),
            '^' => escaped.push_str(r"\textasciicircum{}"),
            '~' => escaped.push_str(r"\textasciitilde{}"),
            '<' => escaped.push_str(r"\textless{}"),
            '>' => escaped.push_str(r"\textgreater{}"),
            '#' | '$' | '%' | '&' | '_' | '{' | '}' => escaped.extend(['\\', c]),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// The same where long names may be broken.
pub fn breakable(text: &str) -> String {
    let is_inside = |rest: &str| rest.chars().nth(1).is_some_and(char::is_alphanumeric);
    let mut broken = String::with_capacity(text.len());
    for (index, c) in text.char_indices() {
        broken.push_str(&escape(c.encode_utf8(&mut [0; 4])));
        if matches!(c, '.' | '_') && is_inside(&text[index..]) {
            broken.push_str(r"\allowbreak{}");
        }
    }
    broken
}

/// A root that is broken into lines has an exponent behind its parenthesis.
fn brackets(function: &str) -> (String, [&'static str; 2]) {
    let name = match shown(function) {
        Shown::Between("⌊", "⌋") => return (String::new(), [r"\lfloor ", r"\rfloor"]),
        Shown::Between(open, close) => return (String::new(), [open, close]),
        Shown::Command(name) => format!(r"\{name}"),
        _ if function == "sqrt" => return (String::new(), ["(", ")^{1/2}"]),
        Shown::Word if function.is_empty() => String::new(),
        Shown::Word | Shown::Operator => format!(r"\operatorname{{{function}}}"),
    };
    (name, ["(", ")"])
}

fn relation(sign: &str) -> &str {
    match sign {
        "<=" => r"\le",
        "." => r"\cdot",
        "x" => r"\times",
        other => other,
    }
}

fn number(value: f64) -> String {
    let digits = decimal(rounded(value));
    match digits.split_once('e') {
        Some((mantissa, exponent)) => format!(r"{mantissa}\cdot 10^{{{exponent}}}"),
        None => digits,
    }
}

fn name(name: &Name) -> String {
    let letter = match compound(name) {
        // In braces: a bracket behind a line break would be its argument.
        Some((letter, below)) => format!("{{[{}_{below}]}}", self::letter(letter)),
        None => self::letter(&name.base),
    };
    let letter = match (name.bold, greek(&name.base)) {
        (true, Some(_)) => format!(r"\boldsymbol{{{letter}}}"),
        (true, None) => format!(r"\mathbf{{{letter}}}"),
        (false, _) => letter,
    };
    let dotted = match name.dots {
        0 => letter,
        1 => format!(r"\dot{{{letter}}}"),
        _ => format!(r"\ddot{{{letter}}}"),
    };
    if name.subscript.is_empty() { dotted } else { format!("{dotted}_{{{}}}", below(&name.subscript)) }
}

fn below(subscript: &str) -> String {
    let upright = subscript.len() > 1 && subscript.chars().any(char::is_alphabetic);
    if upright { format!(r"\mathrm{{{}}}", escape(subscript)) } else { escape(subscript) }
}

fn letter(base: &str) -> String {
    match base.len() {
        1 => escape(base),
        _ if base == "->" => r"\to".to_owned(),
        _ if greek(base).is_some() => format!(r"\{base}"),
        _ => format!(r"\mathit{{{}}}", escape(base)),
    }
}
