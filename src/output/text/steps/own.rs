//! In plain text nothing but its letters tells a variable of the lesson, such as `g` or `F_h9`, from a parameter that the user called so:
//! the lesson's gets an underscore more.

use std::collections::HashSet;

use crate::component::System;
use crate::output::text::document::{Block, Piece};
use crate::output::text::name::Name;
use crate::output::text::tree::Tree;

/// Renames what would be read as a name of the user's.
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

/// Is it a letter of the lesson? Those of the user's are neither bold nor joined to what stands below by a line.
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
        Piece::Words(_) | Piece::Code(_) => None,
    }
}
