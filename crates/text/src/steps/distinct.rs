//! In plain text a vector such as `g` or `i` could be read as a parameter of the same name: it gets an underscore.

use std::collections::HashSet;

use cotree::model::Mechanism;

use crate::document::{DocumentBlock, Piece};
use crate::name::Name;
use crate::tree::FormulaTree;

/// Renames vectors that would be read as names of the user's.
pub fn tell_apart(blocks: &mut [DocumentBlock], mechanism: &Mechanism) {
    let parameters = mechanism.parameters.iter().map(|parameter| parameter.name.as_str());
    let inputs = mechanism.inputs.iter().map(|input| input.name.as_str());
    let drivers = mechanism.drivers.iter().map(|driver| driver.name.as_str());
    let taken: HashSet<&str> = parameters.chain(inputs).chain(drivers).collect();
    let mut rename = |name: &mut Name| {
        while name.bold && taken.contains(name.plain.as_str()) {
            name.plain.push('_');
        }
    };
    let mut rename_all = |tree: &mut FormulaTree| tree.visit_names(&mut rename);
    blocks.iter_mut().for_each(|block| trees(block, &mut rename_all));
}

fn trees(block: &mut DocumentBlock, visit: &mut dyn FnMut(&mut FormulaTree)) {
    match block {
        DocumentBlock::Heading(_) | DocumentBlock::Picture(..) => {}
        DocumentBlock::Text(pieces) => pieces.iter_mut().for_each(|piece| math(piece, visit)),
        DocumentBlock::Equations(rows) => rows.iter_mut().flat_map(|(left, right)| [left, right]).for_each(visit),
        DocumentBlock::Table(table) => table.rows.iter_mut().flatten().for_each(|piece| math(piece, visit)),
        DocumentBlock::Folded(_, blocks) => blocks.iter_mut().for_each(|block| trees(block, visit)),
    }
}

fn math(piece: &mut Piece, visit: &mut dyn FnMut(&mut FormulaTree)) {
    match piece {
        Piece::Math(tree) => visit(tree),
        Piece::Row(pieces) => pieces.iter_mut().for_each(|piece| math(piece, visit)),
        Piece::Words(_) | Piece::Code(_) => {}
    }
}
