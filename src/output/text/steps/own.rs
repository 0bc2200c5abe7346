//! In plain text a variable of the derivation, such as `g` or `F_h9`, could be read as a parameter of the same name: the former gets an underscore.

use std::collections::HashSet;

use crate::component::System;
use crate::output::text::document::{Block, Piece};
use crate::output::text::name::Name;
use crate::output::text::tree::Tree;

/// Renames variables of the derivation that would be read as names of the user's.
pub fn tell_apart(blocks: &mut [Block], system: &System) {
    let mechanism = system.mechanism;
    let parameters = mechanism.parameters.iter().map(|own| own.name.as_str());
    let inputs = mechanism.inputs.iter().map(|own| own.name.as_str());
    let drivers = mechanism.drivers.iter().map(|own| own.name.as_str());
    let taken: HashSet<&str> = parameters.chain(inputs).chain(drivers).collect();
    let mut rename = |name: &mut Name| {
        while is_own(name) && taken.contains(name.plain.as_str()) {
            name.plain.push('_');
        }
    };
    for tree in blocks.iter_mut().flat_map(trees) {
        tree.visit_names(&mut rename);
    }
}

/// Is it a variable of the derivation? Names of the user's are neither bold nor a letter, an underscore and a subscript.
fn is_own(name: &Name) -> bool {
    name.bold
        || (!name.subscript.is_empty()
            && name.plain.trim_end_matches('_') == format!("{}_{}", name.base, name.subscript))
}

fn trees(block: &mut Block) -> Vec<&mut Tree> {
    match block {
        Block::Heading(_) => Vec::new(),
        Block::Text(pieces) => pieces.iter_mut().filter_map(math).collect(),
        Block::Equations(rows) => rows.iter_mut().flat_map(|(left, right)| [left, right]).collect(),
        Block::Table(_, rows) => rows.iter_mut().flatten().filter_map(math).collect(),
    }
}

fn math(piece: &mut Piece) -> Option<&mut Tree> {
    match piece {
        Piece::Math(tree) => Some(tree),
        Piece::Words(_) | Piece::Code(_) | Piece::Row(_) => None,
    }
}
