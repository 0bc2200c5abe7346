//! Taylor series against the accelerations of the explicit method, which come from the symbolic elimination of the same equations: two
//! formulations that share the kinematics only.

use crate::support::cam::{Cam, Random};
use crate::support::hanging::{self, ROOTS};
use crate::support::random::{Family, random_case};
use crate::support::run::{file, mechanism, models, scene_of};
use cotree::formulate::formulate;
use cotree::model::{CoordinateChoice, Mechanism};
use cotree::scene::Body;
use cotree_fmu::machine::Machine;
use cotree_fmu::model::{Model, State};
use cotree_fmu::taylor::Jet;

const ORDER: usize = 14;

/// The polynomial of the series at the state: coefficients by orders.
fn series(model: &Model, state: &State, jet: &mut Jet) -> Vec<Vec<f64>> {
    let n = model.coordinates();
    let mut machine = Machine::new(model);
    machine.load(model, state);
    jet.update(machine.registers());
    let motion: Vec<f64> = state.positions().iter().chain(state.rates()).copied().collect();
    let open = jet.begin(model, machine.registers(), &motion).expect("a regular pose");
    assert!(open < 1e-10, "open by {open}");
    jet.advance(1, ORDER - 2);
    let mut coefficients = vec![vec![0.0; n]; ORDER + 1];
    coefficients.iter_mut().enumerate().for_each(|(k, values)| jet.coordinates(k, values));
    coefficients
}

/// The largest difference between the second derivative of the polynomial and the accelerations at the polynomial's own state.
fn defect(model: &Model, state: &State, coefficients: &[Vec<f64>], dt: f64) -> f64 {
    let n = model.coordinates();
    let at = |i: usize, derivative: usize| {
        coefficients.iter().enumerate().rev().fold(0.0, |sum, (k, values)| {
            let falling: f64 = (0..derivative).map(|d| k as f64 - d as f64).product();
            if k < derivative { sum } else { sum * dt + falling * values[i] }
        })
    };
    let mut machine = Machine::new(model);
    machine.load(model, state);
    machine.load_signals(model, state, state.time() + dt);
    let motion: Vec<f64> = (0..n).map(|i| at(i, 0)).chain((0..n).map(|i| at(i, 1))).collect();
    machine.load_motion(model, &motion);
    let mut results = vec![0.0; n + model.program().constraints.len()];
    machine.evaluate(&model.program().tapes.acceleration, &mut results);
    let largest = (0..n).map(|i| at(i, 2).abs()).fold(1.0, f64::max);
    (0..n).map(|i| (results[i] - at(i, 2)).abs() / largest).fold(0.0, f64::max)
}

/// A step that uses all orders but leaves the last term small.
fn step(coefficients: &[Vec<f64>]) -> f64 {
    let size = |k: usize| coefficients[k].iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
    let first = size(2).max(1.0);
    let radius = (ORDER - 3..=ORDER).map(|k| (first / size(k).max(1e-300)).powf(1.0 / (k - 2) as f64));
    radius.fold(1.0, f64::min) * 0.2
}

/// Upright bars of different lengths side by side, each tied to the next by another: loops that share bars.
fn ladder(loops: usize) -> String {
    let mut text = String::from("format = 1\nname = \"ladder\"\ngravity = [0, -9.81]\n[ground.points]\n");
    let (mut at, mut tops, mut rest) = (0.0, Vec::new(), String::new());
    for pivot in 0..=loops {
        let (length, mass) = (1.0 + 0.2 * (pivot as f64).sin(), 1.0 + 0.5 * (2.0 * pivot as f64).cos());
        text += &format!("p{pivot} = [{at}, 0]\n");
        rest += &format!("[bodies.v{pivot}]\nmass = {mass}\ninertia = 0.1\ncom = [0.4, 0.1]\n");
        rest += &format!("points = {{ a = [0, 0], b = [{length}, 0] }}\n");
        rest += &format!("[joints.f{pivot}]\ntype = \"revolute\"\nbetween = [\"ground.p{pivot}\", \"v{pivot}.a\"]\n");
        tops.push([at, length]);
        at += 1.0 + 0.1 * (3.0 * pivot as f64).cos();
    }
    let mut guesses = String::from("[initial]\n\"v0.angle\" = \"80 deg\"\n\"v0.omega\" = -1\n");
    for (tie, tops) in (1..).zip(tops.windows(2)) {
        let (x, y) = (tops[1][0] - tops[0][0], tops[1][1] - tops[0][1]);
        rest += &format!("[bodies.h{tie}]\nmass = 1\ninertia = 0.05\ncom = [0.5, 0]\n");
        rest += &format!("points = {{ a = [0, 0], b = [{}, 0] }}\n", x.hypot(y));
        for (joint, upright, end) in [("l", tie - 1, "a"), ("r", tie, "b")] {
            rest += &format!(
                "[joints.{joint}{tie}]\ntype = \"revolute\"\nbetween = [\"v{upright}.b\", \"h{tie}.{end}\"]\n"
            );
        }
        guesses +=
            &format!("\"v{tie}.angle\" = {{ guess = \"80 deg\" }}\n\"h{tie}.angle\" = {{ guess = {} }}\n", y.atan2(x));
    }
    text + &rest + &guesses + "[experiment]\nstop = 1\n"
}

fn check(name: &str, mechanism: &mut Mechanism, coordinates: CoordinateChoice) -> bool {
    mechanism.coordinates = coordinates;
    let Ok(formulated) = formulate(mechanism, &[]) else { return false };
    let program = formulated.lowered.program.clone();
    // Series know nothing of friction that sticks and of ropes over pulleys.
    if program.is_driven() || ["barrier", "chain_hoist", "clutch_start", "stick_slip", "worm_hoist"].contains(&name) {
        return false;
    }
    let name = format!("{name} {:?}", mechanism.coordinates);
    if program.arms.is_none() {
        panic!("{name}: {:?}", formulated.lowered.no_series);
    }
    let model = Model::new(program).unwrap_or_else(|fault| panic!("{name}: {fault}"));
    let mut jet = Jet::new(&model).expect("an arm form");
    let coefficients = series(&model, &formulated.state, &mut jet);
    let h = step(&coefficients);
    jet.complete(ORDER);
    let h = jet.end_of_piece(ORDER, 0.0, h).map_or(h, |(end, _)| end);
    for (share, tolerance) in [(0.0, 1e-9), (0.5, 1e-9), (1.0, 2e-6)] {
        let defect = defect(&model, &formulated.state, &coefficients, share * h);
        assert!(defect < tolerance, "{name} at {share} of {h}: {defect}");
    }
    true
}

#[test]
fn series_of_all_models_solve_the_equations() {
    let mut checked = 0;
    for name in models() {
        let text = scene_of(&name);
        for coordinates in [CoordinateChoice::Recommended, CoordinateChoice::Absolute, CoordinateChoice::Joint] {
            checked += usize::from(check(&name, &mut mechanism(&text), coordinates));
        }
    }
    assert!(checked >= 15, "only {checked}");
}

#[test]
fn series_of_random_mechanisms_solve_the_equations() {
    let mut checked = 0;
    for family in [Family::Chain, Family::Tree, Family::Loops, Family::Driven] {
        for seed in 0..40 {
            let case = random_case(seed, family);
            let name = format!("{family:?} {seed}");
            for coordinates in [CoordinateChoice::Recommended, CoordinateChoice::Absolute, CoordinateChoice::Joint] {
                checked += usize::from(check(&name, &mut mechanism(&case.scene), coordinates));
            }
        }
    }
    assert!(checked >= 300, "only {checked}");
}

#[test]
fn series_of_many_loops_solve_the_equations() {
    for loops in [5, 12, 25] {
        let name = format!("ladder of {loops}");
        for coordinates in [CoordinateChoice::Recommended, CoordinateChoice::Absolute] {
            assert!(check(&name, &mut mechanism(&ladder(loops)), coordinates));
        }
    }
}

/// A cam's law is a loop equation that is no sum of arms: rollers, edges and faces, followers that slide and turn, in the middle of laws of all kinds.
#[test]
fn series_of_random_cams_solve_the_equations() {
    let mut random = Random(9);
    for case in 0..24 {
        let flat = case % 4 > 1;
        let cam = if case % 2 == 0 { Cam::sliding(&mut random, flat) } else { Cam::turning(&mut random, flat) };
        let (angle, omega) = (random.between(0.1, 6.1), random.between(-20.0, 20.0));
        let start = format!("[initial]\n\"cam.angle\" = {angle}\n\"cam.omega\" = {omega}\n[experiment]\nstop = 1\n");
        let text = cam.scene(["left", "right"][case / 4 % 2], &start);
        for coordinates in [CoordinateChoice::Recommended, CoordinateChoice::Absolute, CoordinateChoice::Joint] {
            assert!(check(&format!("cam {case}"), &mut mechanism(&text), coordinates));
        }
    }
}

/// A boom and an arm with a hydraulic cylinder each: the gap of a cylinder is closed across an axis that turns, by one equation.
#[test]
fn a_slide_between_two_bodies_is_one_loop_equation() {
    let text = file("tests/scenes/excavator.toml");
    for (coordinates, unknowns) in [
        (CoordinateChoice::Recommended, [4, 0, 2]),
        (CoordinateChoice::Joint, [6, 0, 4]),
        (CoordinateChoice::Absolute, [6, 12, 16]),
    ] {
        let mut mechanism = mechanism(&text);
        assert!(check("excavator", &mut mechanism, coordinates));
        let formulated = formulate(&mechanism, &[]).expect("a sound scene");
        let form = formulated.lowered.program.arms.expect("an arm form");
        assert_eq!(form.unknowns_and_equations(), unknowns, "{:?}", mechanism.coordinates);
    }
}

#[test]
fn a_light_body_among_many_loops_asks_for_pivots() {
    let light = ladder(12).replacen("mass = 1\ninertia = 0.05", "mass = 1e-6\ninertia = 1e-8", 1);
    assert!(check("ladder with a light body", &mut mechanism(&light), CoordinateChoice::Recommended));
}

/// Bars that hang from each other, none in line with the one before; some carry another one besides.
fn hanging(bars: usize, mass: impl Fn(usize) -> f64, branches: &[usize]) -> Mechanism {
    let mut scene = crate::support::chain::chain_of(bars, |bar| [mass(bar), 0.07 * mass(bar)]);
    for &bar in branches {
        let body = Body::new().mass(0.4).inertia(0.02).point("a", [-0.2, 0.1]);
        let name = format!("side{bar}");
        scene = scene.body(&name, body).revolute(&format!("at{bar}"), &format!("b{bar}.b"), &format!("{name}.a"));
    }
    scene.resolve().expect("a sound scene").mechanism
}

#[test]
fn series_of_chains_solve_the_equations() {
    for bars in [13, 16, 30] {
        for coordinates in [CoordinateChoice::Recommended, CoordinateChoice::Absolute] {
            let mut chain = hanging(bars, |bar| 1.3 - 0.02 * bar as f64, &[]);
            assert!(check(&format!("chain of {bars}"), &mut chain, coordinates));
        }
    }
    let masses = |bar: usize| if bar.is_multiple_of(3) { 1e-2 } else { 1.0 };
    assert!(check("chain of light and heavy bars", &mut hanging(20, masses, &[]), CoordinateChoice::Recommended));
    assert!(check("branched chain", &mut hanging(14, |_| 1.0, &[3, 9]), CoordinateChoice::Recommended));
}

/// Has the arm form of a scene its arms as a tree?
fn is_tree(text: &str) -> bool {
    let form = formulate(&mechanism(text), &[]).expect("a sound scene").lowered.program.arms.expect("an arm form");
    assert!(form.links.is_empty() != form.coupling.is_empty());
    !form.links.is_empty()
}

/// Chains and trees on what is fixed, moved or moves, in any order of the file.
#[test]
fn series_of_bars_that_hang_from_each_other_solve_the_equations() {
    for root in ROOTS {
        let mut trees = 0;
        for (seed, (bars, spread)) in [(16, 1), (21, 1), (40, 2), (30, 4), (60, 3), (90, 2)].into_iter().enumerate() {
            let text = hanging::hanging(seed as u64, bars, spread, root);
            let name = format!("{bars} bars on {root:?}, the last {spread}");
            for coordinates in [CoordinateChoice::Recommended, CoordinateChoice::Absolute] {
                assert!(check(&name, &mut mechanism(&text), coordinates), "{name}");
            }
            trees += usize::from(is_tree(&text));
        }
        assert!(trees >= 3, "only {trees} trees on {root:?}");
    }
}

#[test]
fn a_step_costs_so_much_for_each_bar() {
    let cost = |bars: usize| {
        let program = formulate(&hanging(bars, |_| 1.0, &[]), &[]).expect("a chain").lowered.program;
        Jet::new(&Model::new(program).expect("a model")).expect("an arm form").cost()
    };
    // From some length on the masses of every two bars would be too many to be stored.
    let costs = [40, 120, 200].map(cost);
    assert!((costs[2] - costs[1]) < 2.1 * (costs[1] - costs[0]), "{costs:?}");
}

#[test]
fn a_step_costs_so_much_for_each_loop() {
    let cost = |loops: usize| {
        let program = formulate(&mechanism(&ladder(loops)), &[]).expect("a ladder").lowered.program;
        Jet::new(&Model::new(program).expect("a model")).expect("an arm form").cost()
    };
    let costs = [100, 200, 400].map(cost);
    assert!((costs[2] - costs[1]) < 2.1 * (costs[1] - costs[0]), "{costs:?}");
}
