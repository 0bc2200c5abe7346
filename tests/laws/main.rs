//! The laws of the formulation: the trees change the size of the equations, never the motion; and every matrix is what it claims to be.

#[path = "../support/mod.rs"]
mod support;

mod agreement;
mod energy;
mod structure;
mod trees;

use cotree::mechanism::Mechanism;
use cotree::scene::Scene;
use support::random::{Case, Family, random_case};

/// All families, and those whose reactions are unique.
const FAMILIES: [Family; 5] = [Family::Chain, Family::Tree, Family::Loops, Family::Driven, Family::Redundant];

/// The mechanism of a scene.
fn mechanism(scene: &str) -> Mechanism {
    let resolved = Scene::from_toml(scene).and_then(|scene| scene.resolve());
    resolved.unwrap_or_else(|faults| panic!("{}", faults.render(false, 100))).mechanism
}

/// Random mechanisms of a family, with their seeds.
fn cases(family: Family, count: u64) -> impl Iterator<Item = (u64, Case)> {
    (0..count).map(move |seed| (seed, random_case(seed, family)))
}
