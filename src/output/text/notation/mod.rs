//! Formulas in plain text, LaTeX and MathML.

pub mod latex;
pub mod lines;
pub mod mathml;
pub mod plain;
pub mod unicode;

use super::name::Name;
use super::tree::Tree;
use crate::expr::{Function, Shown};

/// How tightly what a formula is made of holds together.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Binding {
    Relation,
    Sum,
    Product,
    Power,
    Atom,
}

fn relation_binding(sign: &str) -> Binding {
    if matches!(sign, "." | "x") { Binding::Product } else { Binding::Relation }
}

/// How tightly a formula holds together where fractions and roots are drawn as such.
fn drawn_binding(tree: &Tree) -> Binding {
    match tree {
        Tree::Relation(sign, _) => relation_binding(sign),
        Tree::Sum(_) => Binding::Sum,
        Tree::Product(_) => Binding::Product,
        Tree::Power(_) => Binding::Power,
        Tree::Quotient(_) => Binding::Product,
        Tree::Number(_) | Tree::Pi | Tree::Name(_) | Tree::Root(_) | Tree::Call(..) => Binding::Atom,
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
/// nothing below.
fn compound(name: &Name) -> Option<(&str, &str)> {
    let (letter, below) = name.base.split_once('_')?;
    (letter == "Phi" && !name.subscript.is_empty()).then_some((letter, below))
}
