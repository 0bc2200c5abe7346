//! Formulas as LaTeX.

use super::lines::{Part, Printed, lines};
use super::{Binding, compound, drawn_binding, greek, relation_binding, shown};
use crate::expr::Shown;
use crate::output::text::name::Name;
use crate::output::text::number::{decimal, rounded};
use crate::output::text::tree::Tree;

pub fn latex(tree: &Tree) -> String {
    match tree {
        Tree::Number(value) => number(*value),
        Tree::Pi => r"\pi".to_owned(),
        Tree::Name(name) => self::name(name),
        Tree::Sum(terms) => sum(terms).concat(),
        Tree::Product(factors) => {
            let factors: Vec<String> = factors.iter().map(|factor| bound(factor, Binding::Product)).collect();
            factors.join(r"\,")
        }
        Tree::Quotient(parts) => {
            let [over, under] = parts.as_ref();
            format!(r"\frac{{{}}}{{{}}}", latex(over), latex(under))
        }
        Tree::Power(parts) => {
            let [base, exponent] = parts.as_ref();
            // A dot or a subscript binds more tightly than an exponent, a fraction does not.
            format!("{}^{{{}}}", bound(base, Binding::Atom), latex(exponent))
        }
        Tree::Root(inside) => format!(r"\sqrt{{{}}}", latex(inside)),
        Tree::Call(function, arguments) => call(function, arguments),
        Tree::Relation(sign, parts) => {
            let [left, right] = parts.as_ref();
            let least = relation_binding(sign);
            format!("{} {} {}", bound(left, least), relation(sign), bound(right, least))
        }
    }
}

/// A formula on lines of about a width, in digits.
pub fn wrapped(tree: &Tree, width: f64) -> Vec<String> {
    let line = |parts: Vec<Part>| parts.iter().enumerate().map(|(index, part)| written(part, index == 0)).collect();
    lines(tree, width, &Printed).into_iter().map(line).collect()
}

fn written(part: &Part, begins_line: bool) -> String {
    match part {
        Part::Whole(tree, least) => bound(tree, *least),
        Part::Sign { minus, first: true } => if *minus { "-" } else { "" }.to_owned(),
        Part::Sign { minus, .. } => if *minus { " - " } else { " + " }.to_owned(),
        Part::Relation(sign) => format!(" {} ", relation(sign)),
        Part::Times => if begins_line { r"\times " } else { r"\," }.to_owned(),
        Part::Comma => ", ".to_owned(),
        Part::Over => r"\Big/ ".to_owned(),
        Part::Open(Some("sqrt") | None) => r"\Bigl(".to_owned(),
        Part::Open(Some(function)) => {
            let (name, [open, _]) = call_signs(function);
            format!(r"{name}\Bigl{open}")
        }
        Part::Close(Some("sqrt"), _) => r"\Bigr)^{1/2}".to_owned(),
        Part::Close(function, exponent) => {
            let close = function.map_or(")", |function| call_signs(function).1[1]);
            let exponent = exponent.map_or_else(String::new, |exponent| format!("^{{{}}}", latex(exponent)));
            format!(r"\Bigr{close}{exponent}")
        }
    }
}

pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' => escaped.push_str(r"\textbackslash{}"),
            '^' => escaped.push_str(r"\textasciicircum{}"),
            '~' => escaped.push_str(r"\textasciitilde{}"),
            '<' => escaped.push_str(r"\textless{}"),
            '>' => escaped.push_str(r"\textgreater{}"),
            '#' | '$' | '%' | '&' | '_' | '{' | '}' => {
                escaped.push('\\');
                escaped.push(c);
            }
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

fn sum(terms: &[(bool, Tree)]) -> Vec<String> {
    let term = |(index, (minus, term)): (usize, &(bool, Tree))| {
        let sign = match (index, minus) {
            (0, true) => "-",
            (0, false) => "",
            (_, true) => " - ",
            (_, false) => " + ",
        };
        format!("{sign}{}", bound(term, Binding::Product))
    };
    terms.iter().enumerate().map(term).collect()
}

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

fn bound(tree: &Tree, least: Binding) -> String {
    let text = latex(tree);
    if drawn_binding(tree) < least { format!(r"\left({text}\right)") } else { text }
}

fn call(function: &str, arguments: &[Tree]) -> String {
    let inside: Vec<String> = arguments.iter().map(latex).collect();
    let (name, [open, close]) = call_signs(function);
    format!(r"{name}\left{open}{}\right{close}", inside.join(", "))
}

fn call_signs(function: &str) -> (String, [&'static str; 2]) {
    let name = match shown(function) {
        Shown::Between(open, close) => return (String::new(), [bracket(open), bracket(close)]),
        Shown::Command(name) => format!(r"\{name}"),
        Shown::Word if function.is_empty() => String::new(),
        Shown::Word | Shown::Operator => format!(r"\operatorname{{{function}}}"),
    };
    (name, ["(", ")"])
}

fn bracket(sign: &'static str) -> &'static str {
    match sign {
        "⌊" => r"\lfloor ",
        "⌋" => r"\rfloor",
        other => other,
    }
}

fn relation(sign: &'static str) -> &'static str {
    match sign {
        "<=" => r"\le",
        "." => r"\cdot",
        "x" => r"\times",
        other => other,
    }
}

fn number(value: f64) -> String {
    match decimal(rounded(value)).split_once('e') {
        Some((mantissa, exponent)) => format!(r"{mantissa}\cdot 10^{{{exponent}}}"),
        None => decimal(rounded(value)),
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
        _ if greek(base).is_some() => format!(r"\{base}"),
        _ => format!(r"\mathit{{{}}}", escape(base)),
    }
}
