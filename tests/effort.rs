//! What the kernels cost, and that trees change nothing but the cost.

use std::fmt::Write;

use crate::support::chain::{chain, ring};
use crate::support::random::{Family, random_case};
use crate::support::run::{formulated, models, resolved, scene_of, sound};
use cotree::expr::{Expr, Order, Symbol};
use cotree::formulate::Formulated;
use cotree::model::BodyId;
use cotree::scene::{Resolved, Scene};
use cotree::solve::{MotionSystem, in_solve_tree};
use cotree::tape::Cost;
use cotree_fmu::tape::Tape;

fn resolve(scene: &Scene) -> Resolved {
    sound(scene.resolve())
}

/// Values at the initial state; `solved` are accelerations, then reactions.
fn values(formulated: &Formulated, exprs: &[Expr], solved: &[f64]) -> Vec<f64> {
    let (state, n) = (&formulated.state, formulated.equations.coordinates.len());
    let value = |symbol: Symbol| match symbol {
        Symbol::Time => state.time(),
        Symbol::Parameter(i) => state.parameters()[i],
        Symbol::Discrete(i) => state.discrete()[i],
        Symbol::Coordinate(i, Order::Position) => state.positions()[i],
        Symbol::Coordinate(i, Order::Velocity) => state.rates()[i],
        Symbol::Coordinate(i, Order::Acceleration) => solved[i],
        Symbol::Reaction(i) => solved[n + i],
        other => panic!("{other:?} has no value"),
    };
    formulated.equations.system.arena.evaluate(exprs, &value)
}

fn assert_close(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    let size = expected.iter().fold(1.0_f64, |size, value| size.max(value.abs()));
    for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= tolerance * size, "{what} {index}: {found} instead of {expected}");
    }
    assert_eq!(found.len(), expected.len(), "{what}");
}

/// Accelerations, reactions and a projection by a solve tree against those in branch coordinates.
fn check_solve_trees(resolved: &Resolved) {
    let mut formulated = formulated(resolved);
    if formulated.lowered.program.is_driven() {
        return;
    }
    let pose = formulated.state.clone();
    let length = formulated.lowered.program.length;
    let rows = formulated.equations.constraints.len();
    let residuals: Vec<Expr> =
        (0..rows).map(|i| formulated.equations.system.arena.constant(1e-3 * (1.0 + i as f64))).collect();
    let mut solutions = Vec::new();
    for stride in [None, Some(1), Some(2), Some(3)] {
        let equations = &mut formulated.equations;
        let system = match stride {
            None => MotionSystem::in_branch_coordinates(equations, length),
            Some(stride) => {
                let chosen = |body: BodyId| equations.depth(body).is_multiple_of(stride);
                let trees = equations.trees.with_bodies(&equations.system, chosen);
                in_solve_tree(equations, trees, length)
            }
        };
        let solver = system.factorise(equations, &pose).unwrap();
        let motion = solver.motion(&mut equations.system.arena, rows);
        let projection = solver.projection(&mut equations.system.arena, &residuals);
        solutions.push([values(&formulated, &motion, &[]), values(&formulated, &projection, &[])]);
    }
    for other in &solutions[1..] {
        for (found, expected) in other.iter().zip(&solutions[0]) {
            assert_close(&resolved.mechanism.name, found, expected, 1e-9);
        }
    }
}

#[test]
fn solve_trees_give_the_accelerations_reactions_and_projections_of_the_branch_coordinates() {
    for family in [Family::Chain, Family::Tree, Family::Loops, Family::Redundant, Family::Driven] {
        for seed in 0..15 {
            check_solve_trees(&resolved(&random_case(seed, family).scene));
        }
    }
    check_solve_trees(&resolve(&chain(12)));
    check_solve_trees(&resolve(&ring(13)));
}

#[test]
fn the_kernel_of_a_chain_grows_with_its_length() {
    let count = |n: usize| {
        let formulated = formulated(&resolve(&chain(n)));
        assert!(formulated.lowered.solve_tree.is_some());
        formulated.lowered.program.tapes.acceleration.instructions().len()
    };
    let [short, middle, long] = [30, 60, 90].map(count);
    let (first, second) = (middle - short, long - middle);
    assert!(second.abs_diff(first) * 20 <= first, "{short} {middle} {long}");
}

/// Instructions of every kernel of the models. A change that makes one longer must be worth it.
#[test]
fn the_kernels_of_the_models_have_the_known_lengths() {
    let mut table =
        format!("{:24}{:>10}{:>10}{:>10}{:>10}{:>10}\n", "model", "loops", "motion", "sines", "project", "outputs");
    for name in models() {
        let program = formulated(&resolved(&scene_of(&name))).lowered.program;
        let tapes = &program.tapes;
        let length = |tape: &Tape| tape.instructions().len();
        let loops = length(&tapes.constraint) + length(&tapes.jacobian.tape) + length(&tapes.gamma);
        let project = length(&tapes.project_position) + length(&tapes.project_velocity);
        let cost = Cost::of(&tapes.acceleration);
        let _ = writeln!(
            table,
            "{name:24}{loops:>10}{:>10}{:>10}{project:>10}{:>10}",
            length(&tapes.acceleration),
            cost.pairs,
            length(&tapes.outputs)
        );
    }
    insta::assert_snapshot!(table);
}
