//! What the choice of trees does to the cost of the equations of motion: every model and 100 random mechanisms, and chains of many
//! lengths. Run with `cargo run --release --example tree_study`; `docs/trees.md` holds its results.

#[path = "../tests/support/mod.rs"]
mod support;

use crate::support::ROOT;
use std::collections::HashSet;
use std::path::Path;
use std::time::Instant;

use cotree::component::{Origin, System};
use cotree::equations::Equations;
use cotree::formulate::tree_search::{self, Effort};
use cotree::formulate::{formulate, formulate_with};
use cotree::graph::ElementId;
use cotree::lower::{Cost, MotionSystem, Pose, kernel_cost};
use cotree::mechanism::{Coordinates, Mechanism};
use cotree::scene::Scene;
use cotree::tree::Trees;
use cotree_fmu::model::Model;
use cotree_fmu::program::Motion;
use nalgebra::{DMatrix, DVector};
use support::chain::chain;
use support::random::{Family, random_case};

/// So many random mechanisms are studied.
const RANDOM: u64 = 100;
/// So many trees of a mechanism are formulated in the search for the best.
const TREES: usize = 250;

fn main() {
    match std::env::args().nth(1).as_deref() {
        Some("chains") => chains(),
        Some("fit") => fit(),
        _ => {
            study();
            chains();
        }
    }
}

fn study() {
    let mut random = Vec::new();
    let families = [Family::Tree, Family::Loops, Family::Loops, Family::Loops];
    let mut seed = 0;
    while random.len() < RANDOM as usize {
        let case = random_case(seed, families[seed as usize % families.len()]);
        random.extend(Scene::from_toml(&case.scene).ok().and_then(|scene| losses(&scene)));
        seed += 1;
    }
    println!("loss against the best trees found, {} random mechanisms", random.len());
    table(&random);
    println!("\nloss against the best trees found, models [%]");
    let mut folders: Vec<_> = std::fs::read_dir(Path::new(ROOT).join("models"))
        .map(|entries| entries.filter_map(Result::ok).map(|entry| entry.path()).collect())
        .unwrap_or_default();
    folders.sort();
    for folder in folders {
        let Ok(scene) = Scene::read(folder.join("scene.toml")) else { continue };
        if let Some(losses) = losses(&scene) {
            let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let cells: Vec<String> = losses.iter().map(|loss| format!("{:>8.1}", 100.0 * (loss - 1.0))).collect();
            println!("{name:24}{}", cells.concat());
        }
    }
}

const KINDS: [&str; 5] = ["breadth first", "file order", "joint", "unsubstituted", "cheapest"];

/// Geometric mean, 90 % and worst of each kind of trees.
fn table(cases: &[[f64; 5]]) {
    println!("{:16}{:>8}{:>8}{:>8}", "[%]", "mean", "90 %", "worst");
    for (kind, name) in KINDS.iter().enumerate() {
        let mut losses: Vec<f64> = cases.iter().map(|case| case[kind]).filter(|loss| loss.is_finite()).collect();
        losses.sort_by(f64::total_cmp);
        let mean = (losses.iter().map(|loss| loss.ln()).sum::<f64>() / losses.len() as f64).exp();
        let at = |share: f64| losses[((losses.len() - 1) as f64 * share).round() as usize];
        let percent = |loss: f64| format!("{:.1}", 100.0 * (loss - 1.0));
        println!("{name:16}{:>8}{:>8}{:>8}", percent(mean), percent(at(0.9)), percent(at(1.0)));
    }
}

/// Cost of each kind of trees over that of the best found; `None` for a mechanism whose motion takes no forces.
fn losses(scene: &Scene) -> Option<[f64; 5]> {
    let mechanism = scene.resolve().ok()?.mechanism;
    let system = System::new(&mechanism);
    let start = Trees::select(&system, &Coordinates::Recommended).ok()?;
    let kinds = [
        start.clone(),
        file_order(&system, &start),
        Trees::select(&system, &Coordinates::Joint).ok()?,
        start.with_bodies(&system, |_| true),
    ];
    let costs: Vec<Option<f64>> = kinds.iter().map(|trees| cost(&system, trees)).collect();
    costs[0]?;
    let cheapest_trees = {
        let mut mechanism = mechanism.clone();
        mechanism.coordinates = Coordinates::Cheapest;
        tree_search::formulate(&mechanism).ok()?.equations.trees
    };
    let cheapest = cost(&system, &cheapest_trees)?;
    let known = costs.iter().copied().flatten().fold(cheapest, f64::min);
    let best = kinds.iter().fold(known, |best, trees| best.min(descend(&system, trees, TREES / kinds.len())));
    let ratio = |cost: Option<f64>| cost.map_or(f64::NAN, |cost| cost / best);
    Some([ratio(costs[0]), ratio(costs[1]), ratio(costs[2]), ratio(costs[3]), cheapest / best])
}

/// Kruskal's algorithm with the elements in the order of the file.
fn file_order(system: &System, start: &Trees) -> Trees {
    let mut order: Vec<ElementId> = system.translation.edges().map(|(id, _)| id).collect();
    order.sort_by_key(|id| system.element(*id).translation.as_ref().map_or(u8::MAX, |row| row.priority));
    Trees { translation: system.translation.tree(order), rotation: start.rotation.clone() }
}

/// The effort of the kernels in branch coordinates [ns].
fn cost(system: &System, trees: &Trees) -> Option<f64> {
    let mut formulated = formulate_with(Equations::new(system.clone(), trees.clone()), None).ok()?;
    if formulated.lowered.program.motion == Motion::Kinematic {
        return None;
    }
    if formulated.lowered.solve_tree.is_none() {
        return Some(Effort::of(&formulated).nanoseconds);
    }
    let state = &formulated.state;
    let (positions, followers) = (state.positions().to_vec(), state.follower_positions().to_vec());
    let pose = Pose { time: state.time(), positions, followers };
    let equations = &mut formulated.equations;
    let active: Vec<bool> = (0..equations.constraints.len()).map(|i| !formulated.redundant.contains(&i)).collect();
    let system = MotionSystem::in_branch_coordinates(equations, &active, formulated.lowered.program.length);
    let solver = system.factorise(equations, &pose).ok()?;
    let results = solver.motion(&mut equations.system.arena, active.len());
    Some(kernel_cost(equations, &results).nanoseconds())
}

/// The cheapest trees that exchanges of one branch for one chord lead to, of whatever weight.
fn descend(system: &System, start: &Trees, most: usize) -> f64 {
    let Some(mut best) = cost(system, start) else { return f64::INFINITY };
    let (mut trees, mut counted) = (start.clone(), 0);
    let mut seen: HashSet<Vec<ElementId>> = HashSet::new();
    loop {
        let mut better = None;
        for pair in trees.exchanges(system) {
            let other = trees.exchanged(system, pair);
            let mut key = other.translation.branches.clone();
            key.sort_unstable();
            if counted >= most || !seen.insert(key) {
                continue;
            }
            counted += 1;
            if let Some(found) = cost(system, &other).filter(|&found| found < best) {
                best = found;
                better = Some(other);
            }
        }
        match better {
            Some(other) => trees = other,
            None => return best,
        }
    }
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
        let Ok(formulated) = formulate(&resolved.mechanism) else { continue };
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
    let trees = Trees::select(&system, &Coordinates::Recommended).ok()?;
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
        let Ok(formulated) = formulate(&resolved.mechanism) else { continue };
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
