//! Random mechanisms with couplings and slots, for random trees, against absolute coordinates.

use std::sync::Arc;

use crate::support::random::Random;
use crate::support::random_parts::random_parts;
use crate::support::run::resolved;
use cotree::equations::Equations;
use cotree::expr::{Expr, Symbol};
use cotree::formulate::formulate;
use cotree::model::CoordinateChoice;
use cotree::network::{ElementId, LinearGraph, Origin, System, Trees};
use cotree::scene::{Resolved, Span};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

const MECHANISMS: u64 = 40;
const TREES: usize = 3;

/// Arms first, then everything else in any order.
fn shuffled<D>(system: &System, graph: &LinearGraph<D>, random: &mut Random) -> Vec<ElementId> {
    let is_arm = |id: &ElementId| matches!(system.element(*id).origin, Origin::Arm(..) | Origin::GroundVector(_));
    let (arms, mut rest): (Vec<ElementId>, Vec<ElementId>) = graph.edges().map(|(id, _)| id).partition(is_arm);
    let mut order = arms;
    while !rest.is_empty() {
        order.push(rest.swap_remove(random.below(rest.len())));
    }
    order
}

fn random_trees(system: &System, random: &mut Random) -> Trees {
    Trees {
        translation: system.translation.tree(shuffled(system, &system.translation, random)),
        rotation: system.rotation.tree(shuffled(system, &system.rotation, random)),
    }
}

/// The same trees in the words of the scene.
fn chosen(system: &System, trees: &Trees) -> CoordinateChoice {
    let named = |branches: &[ElementId]| {
        let elements = branches.iter().map(|id| system.element(*id));
        let real = elements.filter(|element| !matches!(element.origin, Origin::Arm(..) | Origin::GroundVector(_)));
        Some(real.map(|element| (element.name.clone(), Span::default())).collect())
    };
    CoordinateChoice::Chosen {
        translation: named(&trees.translation.branches),
        rotation: named(&trees.rotation.branches),
    }
}

#[test]
fn random_mechanisms_agree_with_absolute_coordinates_for_random_trees() {
    for seed in 0..MECHANISMS {
        let case = random_parts(seed, 1 + (seed % 3) as usize);
        let Resolved { mut mechanism, outputs, .. } = resolved(&case.scene);
        let mut random = Random(seed);
        for tree in 0..=TREES {
            let system = System::new(&mechanism);
            let coordinates = chosen(&system, &random_trees(&system, &mut random));
            mechanism.coordinates = if tree == 0 { CoordinateChoice::Recommended } else { coordinates };
            let formulated =
                formulate(&mechanism, &outputs).unwrap_or_else(|faults| panic!("{seed} {tree}: {faults:?}"));
            let model = Model::new(formulated.lowered.program).unwrap();
            let mut instance = Instance::new(Arc::new(model));
            instance.setup(0.0, None, None).unwrap();
            instance.initialise().unwrap();
            let largest = case.expected.values().fold(1.0, |largest: f64, value| largest.max(value.abs()));
            for (name, expected) in &case.expected {
                let variable = instance.variable(name).unwrap();
                let value = instance.get(variable).unwrap();
                assert!(
                    (value - expected).abs() <= 1e-8 * largest,
                    "seed {seed}, tree {tree}: {name} is {value} instead of {expected}\n{:?}\n{}",
                    mechanism.coordinates,
                    case.scene
                );
            }
        }
    }
}

/// Reactions enter the cutset equations through the transposed Jacobian: couplings do no work, whatever the trees.
#[test]
fn couplings_do_no_work() {
    for seed in 0..MECHANISMS {
        let case = random_parts(seed, 2);
        let mechanism = resolved(&case.scene).mechanism;
        let mut random = Random(seed);
        let system = System::new(&mechanism);
        let trees = random_trees(&system, &mut random);
        let mut equations = Equations::new(system, trees);
        let reactions = equations.dynamics().reactions.clone();
        let size = equations.constraints.len();
        let mut numbers = Random(seed + 1);
        let values: Vec<f64> = (0..equations.coordinates.len()).map(|_| numbers.number(-2.0, 2.0)).collect();
        let value = |symbol: Symbol| match symbol {
            Symbol::Coordinate(i, _) => values[i],
            other => panic!("the Jacobian must not contain {other:?}"),
        };
        for (column, row) in reactions.iter().enumerate() {
            for index in 0..size {
                let entry = |entries: &[(usize, Expr)], at: usize| {
                    entries.iter().find(|(i, _)| *i == at).map_or(Expr::ZERO, |(_, entry)| *entry)
                };
                let pair = [entry(row, index), entry(&equations.constraints[index].jacobian, column)];
                let found = equations.system.arena.evaluate(&pair, &value);
                let name = &equations.coordinates[column].name.position;
                assert!((found[0] - found[1]).abs() < 1e-11, "seed {seed}: {name}, row {index}: {found:?}");
            }
        }
    }
}
