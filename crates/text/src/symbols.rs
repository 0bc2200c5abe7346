//! Equations in which every number has a name, and the table of the values.

use cotree::equations::Equations;
use cotree::expr::Symbol;
use cotree::model::Unit;
use cotree::network::System;
use cotree::resolve::symbolic::{NamedNumber, Style, Symbolic};

use super::document::{DocumentBlock, Piece};
use super::modes::words_of_mode;
use super::name::symbol_name;
use super::tree::{FormulaTree, plain};
use super::{Prose, json, titled};

/// How equations with names for numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymbolNotation {
    /// For people.
    Prose(Prose),
    /// For other programs.
    Json,
}

/// The equations of motion of a mechanism in the same trees, with a name for every number.
pub fn symbols(equations: &Equations, written: SymbolNotation) -> String {
    let symbolic = Symbolic::new(&equations.system, Style::Owners);
    let mut renamed = with_names(equations, &symbolic);
    match written {
        SymbolNotation::Prose(prose) => {
            let blocks = values(&mut renamed, &symbolic.named);
            titled(&mut renamed, blocks, prose)
        }
        SymbolNotation::Json => json(&mut renamed),
    }
}

/// The same equations for the mechanism with names.
pub fn with_names(equations: &Equations, symbolic: &Symbolic) -> Equations {
    let mut renamed =
        Equations::new(System::new(&symbolic.mechanism).implying(&equations.system.implied), equations.trees.clone());
    for (constraint, other) in renamed.constraints.iter_mut().zip(&equations.constraints) {
        constraint.adopt(other);
    }
    renamed.symbolic = true;
    renamed
}

/// A table of names and values: the user's parameters, then those of the page.
pub fn values(equations: &mut Equations, named: &[NamedNumber]) -> Vec<DocumentBlock> {
    let mechanism = &*equations.system.mechanism.clone();
    let first = mechanism.parameters.len() - named.len();
    let mut rows: Vec<Vec<Piece>> = Vec::new();
    for (index, parameter) in mechanism.parameters.iter().enumerate() {
        let name = Piece::Math(FormulaTree::Name(symbol_name(equations, Symbol::Parameter(index))));
        let mut row = vec![name, number(parameter.value, &parameter.unit)];
        match index.checked_sub(first).and_then(|index| named.get(index)) {
            None => row.extend([Piece::words("parameter"), Piece::words(&parameter.description)]),
            Some(named) => {
                row.push(Piece::Code(named.element.clone().unwrap_or_else(|| "scene".to_owned())));
                row.push(match definition(equations, named) {
                    None => Piece::words(named.what),
                    Some(tree) => Piece::Row(vec![Piece::words(format!("{}: ", named.what)), Piece::Math(tree)]),
                });
            }
        }
        rows.push(row);
    }
    // Discrete variables of modes, without those that no equation reads.
    for (id, _) in mechanism.discrete_variables() {
        let name = Piece::Math(FormulaTree::Name(symbol_name(equations, Symbol::Discrete(id.0))));
        let cells = |words| [name, Piece::words(""), Piece::words("mode"), Piece::words(words)];
        rows.extend(words_of_mode(equations, id).map(|words| cells(words).into()));
    }
    if rows.is_empty() {
        return Vec::new();
    }
    let head = ["name", "value", "of", ""].map(str::to_owned);
    vec![
        DocumentBlock::Heading("Values".into()),
        DocumentBlock::table(head.into(), rows),
        DocumentBlock::Heading("Equations".into()),
    ]
}

/// A number of a table, with its unit.
pub fn number(value: f64, unit: &Unit) -> Piece {
    let number = FormulaTree::number(value);
    let unit = if unit.si.is_empty() { String::new() } else { format!(" {}", unit.si) };
    Piece::Row(vec![Piece::Math(number), Piece::words(unit)])
}

/// What a name stands for, if that is more than a number.
pub fn definition(equations: &mut Equations, named: &NamedNumber) -> Option<FormulaTree> {
    let value = equations.system.value(named.definition.as_ref()?);
    plain(equations, &[value]).pop()
}
