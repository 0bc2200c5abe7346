//! Formulas in plain text, LaTeX and MathML: one walker, and a table of patterns for each notation.

pub mod latex;
pub mod lines;
pub mod mathml;
pub mod plain;
pub mod unicode;

use cotree::expr::{Function, Shown};

use super::name::Name;
use super::tree::FormulaTree;
use lines::{FormulaPart, lines};

/// Precedence of the outermost operation of a formula, the weakest first.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Binding {
    Relation,
    Sum,
    Product,
    Power,
    Atom,
}

type Infix = fn(&str, &str) -> String;

/// How a notation writes operations; their operands are written already.
#[derive(Debug)]
pub struct Notation {
    pub pi: &'static str,
    pub comma: &'static str,
    pub number: fn(f64) -> String,
    pub name: fn(&Name) -> String,
    pub parenthesised: fn(&str) -> String,
    /// Operands with the signs between them.
    pub row: fn(String) -> String,
    /// A minus that begins a sum, minus, plus.
    pub signs: [&'static str; 3],
    /// Multiplication of letters, of words (which would run into each other), and at the beginning of a line.
    pub times: [&'static str; 3],
    pub relation: fn(&str) -> String,
    /// A quotient, and how tightly numerator and denominator must bind.
    pub quotient: (Infix, [Binding; 2]),
    /// A power, and how tightly the exponent must bind.
    pub power: (Infix, Binding),
    pub root: fn(&str) -> String,
    /// The name of a function and its parentheses.
    pub brackets: fn(&str) -> (String, [&'static str; 2]),
    /// A call: name, parentheses, arguments.
    pub call: fn(&str, [&str; 2], &str) -> String,
    /// What is broken into lines: the opening parenthesis behind a name, the closing one, and division.
    pub open: fn(&str, &str) -> String,
    pub close: fn(&str) -> String,
    pub over: &'static str,
    pub line: fn(String) -> String,
    /// The width of a part of a line, in digits.
    pub width: fn(&FormulaPart) -> f64,
}

impl Notation {
    pub fn formula(&self, tree: &FormulaTree) -> String {
        match tree {
            FormulaTree::Number(value) => (self.number)(*value),
            FormulaTree::Pi => self.pi.to_owned(),
            FormulaTree::Name(name) => (self.name)(name),
            FormulaTree::Sum(terms) => {
                let term = |(index, (minus, term)): (usize, &(bool, FormulaTree))| {
                    self.sign(*minus, index == 0).to_owned() + &self.bound(term, Binding::Product)
                };
                (self.row)(terms.iter().enumerate().map(term).collect())
            }
            FormulaTree::Product(factors) => {
                let factor = |(index, factor): (usize, &FormulaTree)| {
                    let before = index.checked_sub(1).map(|before| &factors[before]);
                    let words = before.map(|before| is_word(factor) || is_word(before));
                    let times = words.map_or("", |words| self.times[usize::from(words)]);
                    times.to_owned() + &self.bound(factor, Binding::Product)
                };
                (self.row)(factors.iter().enumerate().map(factor).collect())
            }
            FormulaTree::Quotient(parts) => {
                let (write, [over, under]) = self.quotient;
                write(&self.bound(&parts[0], over), &self.bound(&parts[1], under))
            }
            FormulaTree::Power(parts) => self.power(&self.bound(&parts[0], Binding::Atom), &parts[1]),
            FormulaTree::Root(inside) => (self.root)(&self.formula(inside)),
            FormulaTree::Call(function, arguments) => {
                let arguments: Vec<String> = arguments.iter().map(|argument| self.formula(argument)).collect();
                let (name, brackets) = (self.brackets)(function);
                (self.call)(&name, brackets, &arguments.join(self.comma))
            }
            FormulaTree::Relation(sign, parts) => {
                let [left, right] = parts.each_ref().map(|side| self.bound(side, side_binding(sign)));
                (self.row)(left + &(self.relation)(sign) + &right)
            }
        }
    }

    /// A formula on lines of about a width, in digits.
    pub fn wrapped(&self, tree: &FormulaTree, width: f64) -> Vec<String> {
        let line = |parts: Vec<FormulaPart>| {
            (self.line)(parts.iter().enumerate().map(|(index, part)| self.part(part, index == 0)).collect())
        };
        lines(tree, width, self.width).into_iter().map(line).collect()
    }

    fn part(&self, part: &FormulaPart, begins_line: bool) -> String {
        match part {
            FormulaPart::Whole(tree, least) => self.bound(tree, *least),
            FormulaPart::Sign { minus, first } => self.sign(*minus, *first).to_owned(),
            FormulaPart::Relation(sign) => (self.relation)(sign),
            FormulaPart::Times => self.times[if begins_line { 2 } else { 1 }].to_owned(),
            FormulaPart::Comma => self.comma.to_owned(),
            FormulaPart::Over => self.over.to_owned(),
            FormulaPart::Open(function) => {
                let (name, [open, _]) = (self.brackets)(function.unwrap_or(""));
                (self.open)(&name, open)
            }
            FormulaPart::Close(function, exponent) => {
                let close = (self.close)((self.brackets)(function.unwrap_or("")).1[1]);
                exponent.map_or_else(|| close.clone(), |exponent| self.power(&close, exponent))
            }
        }
    }

    /// An operand that must bind at least so tightly.
    fn bound(&self, tree: &FormulaTree, least: Binding) -> String {
        let text = self.formula(tree);
        if binding(tree) < least { (self.parenthesised)(&text) } else { text }
    }

    fn power(&self, base: &str, exponent: &FormulaTree) -> String {
        (self.power.0)(base, &self.bound(exponent, self.power.1))
    }

    fn sign(&self, minus: bool, first: bool) -> &'static str {
        match (minus, first) {
            (false, true) => "",
            (true, true) => self.signs[0],
            (true, false) => self.signs[1],
            (false, false) => self.signs[2],
        }
    }
}

fn binding(tree: &FormulaTree) -> Binding {
    match tree {
        FormulaTree::Relation(sign, _) => relation_binding(sign),
        FormulaTree::Sum(_) => Binding::Sum,
        FormulaTree::Product(_) | FormulaTree::Quotient(_) => Binding::Product,
        FormulaTree::Power(_) => Binding::Power,
        FormulaTree::Number(_)
        | FormulaTree::Pi
        | FormulaTree::Name(_)
        | FormulaTree::Root(_)
        | FormulaTree::Call(..) => Binding::Atom,
    }
}

/// Dot and cross products bind as products do.
fn relation_binding(sign: &str) -> Binding {
    if matches!(sign, "." | "x") { Binding::Product } else { Binding::Relation }
}

fn side_binding(sign: &str) -> Binding {
    if relation_binding(sign) == Binding::Product { Binding::Product } else { Binding::Sum }
}

/// Is it a name of more than one letter?
fn is_word(tree: &FormulaTree) -> bool {
    match tree {
        FormulaTree::Name(name) => greek(&name.base).is_none() && name.base.chars().nth(1).is_some(),
        FormulaTree::Power(parts) => is_word(&parts[0]),
        _ => false,
    }
}

/// How a function is shown; `if` and other words that are in no table by their name.
fn shown(function: &str) -> Shown {
    Function::named(function).map_or(Shown::Word, Function::shown)
}

/// Letters with a sign of their own, and that sign.
const GREEK: [(&str, &str); 24] = [
    ("alpha", "α"),
    ("beta", "β"),
    ("gamma", "γ"),
    ("delta", "δ"),
    ("epsilon", "ε"),
    ("zeta", "ζ"),
    ("eta", "η"),
    ("theta", "θ"),
    ("kappa", "κ"),
    ("lambda", "λ"),
    ("mu", "μ"),
    ("nu", "ν"),
    ("xi", "ξ"),
    ("rho", "ρ"),
    ("sigma", "σ"),
    ("tau", "τ"),
    ("phi", "φ"),
    ("chi", "χ"),
    ("psi", "ψ"),
    ("omega", "ω"),
    ("Phi", "Φ"),
    ("Psi", "Ψ"),
    ("Omega", "Ω"),
    ("Theta", "Θ"),
];

fn greek(name: &str) -> Option<&'static str> {
    GREEK.iter().find(|(known, _)| *known == name).map(|(_, sign)| *sign)
}

/// A matrix whose name has a subscript of its own, such as the `Phi_q` of an entry: letter and subscript. A user's own `Phi_q` has
/// no subscript.
fn compound(name: &Name) -> Option<(&str, &str)> {
    let (letter, below) = name.base.split_once('_')?;
    (letter == "Phi" && !name.subscript.is_empty()).then_some((letter, below))
}
