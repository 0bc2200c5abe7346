//! The laws of the formulation: the trees change the size of the equations, never the motion; and every matrix is what it claims to be.

mod agreement;
mod energy;
mod graphs;
mod redundant;
mod structure;
mod trees;

use crate::support::random::{Case, Family, Random, random_case};
use crate::support::run::{mechanism, resolved};
use cotree::model::{CoordinateChoice, Mechanism};
use trees::random_trees;

/// Random mechanisms of a family, with their seeds.
fn cases(family: Family, count: u64) -> impl Iterator<Item = (u64, Case)> {
    (0..count).map(move |seed| (seed, random_case(seed, family)))
}

/// The presets, and some random trees.
fn choices(mechanism: &Mechanism, seed: u64, random_pairs: usize) -> Vec<CoordinateChoice> {
    let mut random = Random(seed ^ 0x7265_6573);
    let mut choices = vec![CoordinateChoice::Recommended, CoordinateChoice::Absolute, CoordinateChoice::Joint];
    choices.extend((0..random_pairs).map(|_| random_trees(mechanism, &mut random)));
    choices
}
