//! What the second tree of deep chains does to the cost of the equations of motion. Run with `cargo run --release --example tree_study`; `docs/trees.md` holds its results.

#[path = "../tests/support/mod.rs"]
mod support;

/// The folder of the whole project.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

use std::time::Instant;

use cotree::equations::Equations;
use cotree::formulate::{formulate, formulate_with};
use cotree::model::{CoordinateChoice, Mechanism};
use cotree::network::{Origin, System, Trees};
use cotree::scene::Scene;
use cotree::solve::MotionSystem;
use cotree::tape::{Cost, kernel_cost};
use cotree_fmu::model::Model;
use nalgebra::{DMatrix, DVector};
use support::chain::chain;
use support::random::{Family, random_case};

fn main() {
    match std::env::args().nth(1).as_deref() {
        Some("fit") => fit(),
        _ => chains(),
    }
}

/// The cost of the kernel in branch coordinates [ns].
fn cost(system: &System, trees: &Trees) -> Option<f64> {
    let mut formulated = formulate_with(Equations::new(system.clone(), trees.clone()), &[]).ok()?;
    if formulated.lowered.program.is_driven() {
        return None;
    }
    if formulated.lowered.solve_tree.is_none() {
        return Some(Cost::of(&formulated.lowered.program.tapes.acceleration).nanoseconds());
    }
    let state = formulated.state.clone();
    let equations = &mut formulated.equations;
    let system = MotionSystem::in_branch_coordinates(equations, formulated.lowered.program.length);
    let solver = system.factorise(equations, &state).ok()?;
    let results = solver.motion(&mut equations.system.arena, equations.constraints.len());
    Some(kernel_cost(equations, &results).nanoseconds())
}

/// Chains: the kernel in branch coordinates, the kernel that is exported, and what it takes to make it.
fn chains() {
    println!(
        "\n{:8}{:>14}{:>12}{:>12}{:>12}{:>12}",
        "bodies", "branch [ns]", "used [ns]", "operations", "branches", "seconds"
    );
    for n in [6, 8, 12, 20, 50, 100, 200, 500, 1000] {
        let scene = chain(n);
        let Ok(resolved) = scene.resolve() else { continue };
        let begin = Instant::now();
        let Ok(formulated) = formulate(&resolved.mechanism, &resolved.outputs) else { continue };
        let seconds = begin.elapsed().as_secs_f64();
        let tape = &formulated.lowered.program.tapes.acceleration;
        let substituted = if n <= 50 { in_branches(&resolved.mechanism) } else { None };
        let bodies =
            formulated.lowered.solve_tree.as_ref().map_or(0, |tree| bodies(&formulated.equations.system, &tree.trees));
        println!(
            "{n:<8}{:>14}{:>12.0}{:>12}{bodies:>12}{seconds:>12.2}",
            substituted.map_or("-".to_string(), |ns| format!("{ns:.0}")),
            Cost::of(tape).nanoseconds(),
            tape.instructions().len(),
        );
    }
}

fn in_branches(mechanism: &Mechanism) -> Option<f64> {
    let system = System::new(mechanism);
    let trees = Trees::select(&system, &CoordinateChoice::Recommended).ok()?;
    cost(&system, &trees)
}

fn bodies(system: &System, trees: &Trees) -> usize {
    trees.translation.branches.iter().filter(|id| matches!(system.element(**id).origin, Origin::Body(_))).count()
}

/// Fits the constants of the cost model to this machine: least relative squares over the acceleration kernels of chains and random
/// mechanisms.
fn fit() {
    let mut scenes: Vec<Scene> = (1..=16).chain([20, 25, 30, 40, 50, 80]).map(chain).collect();
    let families = [Family::Chain, Family::Tree, Family::Loops];
    scenes.extend(
        (0..60).filter_map(|seed| {
            Scene::from_toml(&random_case(seed, families[seed as usize % families.len()]).scene).ok()
        }),
    );
    let (mut rows, mut times) = (Vec::new(), Vec::new());
    for scene in scenes {
        let Ok(resolved) = scene.resolve() else { continue };
        let Ok(formulated) = formulate(&resolved.mechanism, &resolved.outputs) else { continue };
        let tape = formulated.lowered.program.tapes.acceleration.clone();
        if tape.instructions().len() < 10 {
            continue;
        }
        let cost = Cost::of(&tape);
        let Ok(model) = Model::new(formulated.lowered.program) else { continue };
        let mut registers = formulated.state.registers().to_vec();
        registers.resize(model.program().registers as usize, 0.0);
        let mut best = f64::INFINITY;
        for _ in 0..200 {
            let runs = 1 + 20_000 / tape.instructions().len();
            let begin = Instant::now();
            (0..runs).for_each(|_| tape.run(std::hint::black_box(&mut registers)));
            best = best.min(begin.elapsed().as_nanos() as f64 / runs as f64);
        }
        rows.push([cost.operations as f64 / best, cost.pairs as f64 / best, cost.cycles as f64 / best]);
        times.push((best, cost));
    }
    let matrix = DMatrix::from_fn(rows.len(), 3, |row, column| rows[row][column]);
    let Ok(constants) = matrix.clone().svd(true, true).solve(&DVector::from_element(rows.len(), 1.0), 0.0) else {
        return;
    };
    println!("ns = {:.3} operations + {:.2} pairs + {:.3} cycles", constants[0], constants[1], constants[2]);
    let errors = (&matrix * &constants).map(|ratio| ratio - 1.0);
    println!("{} kernels, rms error {:.1} %", rows.len(), 100.0 * errors.norm() / (rows.len() as f64).sqrt());
    for (time, cost) in times {
        println!(
            "{time:10.0} ns {:8} {:5} {:6}   model {:8.0}",
            cost.operations,
            cost.pairs,
            cost.cycles,
            cost.nanoseconds()
        );
    }
}
