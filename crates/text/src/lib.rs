//! Equations for people and for other programs.

#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        reason = "no input may cause a panic"
    )
)]

// Public for the crates above, the command and the tests of this repository.
#[doc(hidden)]
pub mod assumptions;
#[doc(hidden)]
pub mod code;
pub(crate) mod contract;
pub(crate) mod document;
pub(crate) mod factor;
pub(crate) mod feedback;
pub(crate) mod json;
pub(crate) mod matrices;
pub(crate) mod minimal;
pub(crate) mod modes;
pub(crate) mod motion;
pub(crate) mod name;
pub(crate) mod normal;
pub(crate) mod notation;
pub(crate) mod number;
pub(crate) mod read;
pub(crate) mod signals;
#[doc(hidden)]
pub mod source;
pub(crate) mod steps;
#[doc(hidden)]
pub mod symbols;
#[doc(hidden)]
pub mod tikz;
pub(crate) mod tree;
pub(crate) mod weight;
#[doc(hidden)]
pub mod written;

use cotree::equations::Equations;
use cotree::expr::Symbol;

pub use document::html_page;
pub use json::json;
pub use minimal::{SingularStart, minimal};
use motion::MotionEquations;
pub use notation::latex::escape as latex_text;
pub use steps::steps;
pub use symbols::SymbolNotation;

/// A document for people.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prose {
    /// For people.
    Text,
    /// A LaTeX document.
    Latex,
    /// A self-contained HTML page.
    Html,
}

impl Prose {
    /// The words for them, and what each means.
    pub const WORDS: [(&'static str, &'static str, Self); 3] = [
        ("text", "For people", Self::Text),
        ("latex", "A LaTeX document", Self::Latex),
        ("html", "A self-contained HTML page", Self::Html),
    ];
}

/// What a symbol is called in the user's words.
pub fn symbol_name(equations: &Equations, symbol: Symbol) -> String {
    name::symbol_name(equations, symbol).plain
}

/// The equations of motion for people: coordinates, reactions, abbreviations, then M, Q, Phi, Phi_q, Phi_t, gamma and the
/// displacements that the loops determine. A kinematic model whose bodies have no mass has no M and Q.
pub fn motion(equations: &mut Equations, prose: Prose) -> String {
    titled(equations, Vec::new(), prose)
}

/// The same behind other blocks.
pub(crate) fn titled(equations: &mut Equations, mut blocks: Vec<document::DocumentBlock>, prose: Prose) -> String {
    blocks.extend(MotionEquations::new(equations).blocks(equations));
    let title = format!("Equations of motion of {}", equations.system.mechanism.name);
    page(&title, &blocks, prose)
}

/// The equations of motion as a piece of HTML with MathML, to be put into a page.
pub fn mathml(equations: &mut Equations) -> String {
    let blocks = MotionEquations::new(equations).blocks(equations);
    document::fragment(&blocks)
}

fn page(title: &str, blocks: &[document::DocumentBlock], prose: Prose) -> String {
    match prose {
        Prose::Text => document::text(title, blocks),
        Prose::Latex => document::latex(title, blocks),
        Prose::Html => document::html(title, blocks),
    }
}
