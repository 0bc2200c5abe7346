//! Formulas as LaTeX.

use super::{Binding, compound, drawn_binding, greek, relation_binding};
use crate::print::name::Name;
use crate::print::number::{decimal, rounded};
use crate::print::tree::Tree;

/// A formula, for math mode.
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
            let printed = match *sign {
                "<=" => r"\le",
                "." => r"\cdot",
                "x" => r"\times",
                other => other,
            };
            let least = relation_binding(sign);
            format!("{} {printed} {}", bound(left, least), bound(right, least))
        }
    }
}

/// A formula on lines of about so many characters, broken before signs.
pub fn wrapped(tree: &Tree, width: usize) -> Vec<String> {
    let Tree::Sum(terms) = tree else { return vec![latex(tree)] };
    let mut lines = vec![String::new()];
    let mut length = 0;
    for (text, (_, term)) in sum(terms).into_iter().zip(terms) {
        // Commands make the source longer than the print.
        let printed = super::plain::plain(term).chars().count() + 3;
        if length > 0 && length + printed > width {
            lines.push(String::new());
            length = 0;
        }
        length += printed;
        if let Some(line) = lines.last_mut() {
            line.push_str(&text);
        }
    }
    lines
}

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
            '#' | '$' | '%' | '&' | '_' | '{' | '}' => {
                escaped.push('\\');
                escaped.push(c);
            }
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

fn bound(tree: &Tree, least: Binding) -> String {
    let text = latex(tree);
    if drawn_binding(tree) < least { format!(r"\left({text}\right)") } else { text }
}

fn call(function: &str, arguments: &[Tree]) -> String {
    let inside: Vec<String> = arguments.iter().map(latex).collect();
    let inside = inside.join(", ");
    match function {
        "abs" => format!(r"\left|{inside}\right|"),
        "floor" => format!(r"\left\lfloor {inside}\right\rfloor"),
        "sin" | "cos" | "tan" | "exp" | "tanh" | "min" | "max" => format!(r"\{function}\left({inside}\right)"),
        "" => format!(r"\left({inside}\right)"),
        "log" => format!(r"\ln\left({inside}\right)"),
        "asin" | "acos" | "atan" => format!(r"\arc{}\left({inside}\right)", &function[1..]),
        _ => format!(r"\operatorname{{{function}}}\left({inside}\right)"),
    }
}

fn number(value: f64) -> String {
    match decimal(rounded(value)).split_once('e') {
        Some((mantissa, exponent)) => format!(r"{mantissa}\cdot 10^{{{exponent}}}"),
        None => decimal(rounded(value)),
    }
}

fn name(name: &Name) -> String {
    let letter = match compound(&name.base) {
        // In braces: a bracket behind a line break would be its argument.
        Some((letter, below)) => format!("{{[{}_{below}]}}", self::letter(letter)),
        None => self::letter(&name.base),
    };
    let letter = if name.bold { format!(r"\mathbf{{{letter}}}") } else { letter };
    let dotted = match name.dots {
        0 => letter,
        1 => format!(r"\dot{{{letter}}}"),
        _ => format!(r"\ddot{{{letter}}}"),
    };
    if name.subscript.is_empty() { dotted } else { format!("{dotted}_{{{}}}", below(&name.subscript)) }
}

fn below(subscript: &str) -> String {
    let upright = subscript.len() > 1 && subscript.chars().any(char::is_alphabetic);
    if upright { format!(r"\mathrm{{{}}}", escape(subscript)) } else { subscript.to_owned() }
}

fn letter(base: &str) -> String {
    match base.len() {
        1 => base.to_owned(),
        _ if greek(base).is_some() => format!(r"\{base}"),
        _ => format!(r"\mathit{{{}}}", escape(base)),
    }
}
