//! Section 5.1 of the paper: four masses on a line. Each matrix of Eq. (33) is a product of cutset columns and a diagonal.

use crate::support::ROOT;
use std::path::Path;

use cotree::equations::Equations;
use cotree::expr::{Expr, Order, Symbol};
use cotree::model::Mechanism;
use cotree::network::{Origin, System, Topology, Trees};
use cotree::scene::Scene;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

const BRANCHES: [&str; 4] = ["m1", "m3", "k13", "k15"];

fn scene() -> String {
    std::fs::read_to_string(Path::new(ROOT).join("models/vibration/scene.toml")).unwrap()
}

/// Without the springs and dampers to the ground.
fn floating() -> String {
    let text = scene();
    let grounded = |section: &&str| section.starts_with("[loads.") && section.contains("\"ground\"");
    let kept: Vec<&str> = text.split_inclusive("\n\n").filter(|section| !grounded(section)).collect();
    let text = kept.concat();
    assert!(!text.contains("\"ground\"") && text.contains("[loads.k13]"));
    text
}

fn mechanism(text: &str) -> Mechanism {
    Scene::from_toml(text).and_then(|scene| scene.resolve()).unwrap().mechanism
}

fn equations(mechanism: &Mechanism) -> Equations {
    let system = System::new(mechanism);
    let trees = Trees::select(&system, &mechanism.coordinates).unwrap();
    Equations::new(system, trees)
}

/// Columns of \[A_f\] of the named elements.
fn cutset_columns(equations: &Equations, names: &[&str]) -> DMatrix<f64> {
    let tree = &equations.trees.translation;
    let rows = Topology::new(&equations.system.translation, tree).cutsets(tree);
    let mut columns = DMatrix::zeros(tree.branches.len(), names.len());
    for (row, (branch, cutset)) in tree.branches.iter().zip(rows).enumerate() {
        for (element, sign) in cutset.into_iter().chain([(*branch, 1)]) {
            if let Some(column) = names.iter().position(|name| equations.system.element(element).name == *name) {
                columns[(row, column)] = f64::from(sign);
            }
        }
    }
    columns
}

/// Up to the orientation of elements: each column may have either sign, and so may each row.
fn assert_same_up_to_orientation(found: &DMatrix<f64>, printed: &DMatrix<f64>) {
    assert_eq!(found.map(f64::abs), *printed);
    let signs: Vec<f64> = found.iter().copied().filter(|entry| *entry != 0.0).collect();
    assert!(signs.iter().all(|sign| *sign == 1.0), "here even the signs are those of the print: {found}");
}

#[test]
fn the_coordinates_are_wittenburgs() {
    let mechanism = mechanism(&scene());
    let names: Vec<String> = equations(&mechanism).coordinates.iter().map(|c| c.name.position.clone()).collect();
    assert_eq!(names, ["m1.x", "m3.x", "k13.length", "k15.length"]);
}

#[test]
fn eq26_masses() {
    let mechanism = mechanism(&scene());
    let columns = cutset_columns(&equations(&mechanism), &["m1", "m2", "m3", "m4"]);
    let printed = DMatrix::from_row_slice(
        4,
        4,
        &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    );
    assert_same_up_to_orientation(&columns, &printed);
}

#[test]
fn eq27_dampers() {
    let mechanism = mechanism(&scene());
    let columns = cutset_columns(&equations(&mechanism), &["d5", "d6", "d7"]);
    let printed = DMatrix::from_row_slice(4, 3, &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0]);
    assert_same_up_to_orientation(&columns, &printed);
}

/// A_i i A_i^T with the constants of the scene.
fn product(equations: &Equations, elements: &[(String, f64)]) -> DMatrix<f64> {
    let names: Vec<&str> = elements.iter().map(|(name, _)| name.as_str()).collect();
    let columns = cutset_columns(equations, &names);
    let diagonal = DVector::from_iterator(elements.len(), elements.iter().map(|(_, value)| *value));
    &columns * DMatrix::from_diagonal(&diagonal) * columns.transpose()
}

/// Names and constants of masses, dampers and springs.
fn constants(equations: &mut Equations) -> [Vec<(String, f64)>; 3] {
    let mechanism = &*equations.system.mechanism.clone();
    let mut number = |formula| {
        let expr = equations.system.value(formula);
        equations.system.arena.as_constant(expr).unwrap()
    };
    let masses = mechanism.bodies.iter().map(|body| (body.name.clone(), number(body.mass.as_ref().unwrap()))).collect();
    let (mut dampers, mut springs) = (Vec::new(), Vec::new());
    for load in &mechanism.loads {
        if load.component().name == "spring" {
            dampers.push((load.name.clone(), number(load.formula("damping"))));
            springs.push((load.name.clone(), number(load.formula("stiffness"))));
        }
    }
    [masses, dampers, springs]
}

/// Minus the derivative of {Q} by the coordinates of one order, at a point.
fn stiffness(equations: &mut Equations, order: Order, values: &impl Fn(Symbol) -> f64) -> DMatrix<f64> {
    let load = equations.dynamics().load.clone();
    let n = load.len();
    let arena = &mut equations.system.arena;
    let entries: Vec<Expr> = load
        .iter()
        .flat_map(|&q| (0..n).map(move |c| (q, c)))
        .map(|(q, c)| arena.derivative(q, Symbol::Coordinate(c, order)))
        .collect();
    -DMatrix::from_row_slice(n, n, &arena.evaluate(&entries, values))
}

fn check_eq33(text: &str, q: &[f64], v: &[f64], t: f64) {
    let mechanism = mechanism(text);
    let mut equations = equations(&mechanism);
    let values = |symbol: Symbol| match symbol {
        Symbol::Coordinate(i, Order::Position) => q[i],
        Symbol::Coordinate(i, Order::Velocity) => v[i],
        Symbol::Input(0, Order::Position) => 3.0,
        Symbol::Input(1, Order::Position) => -2.5,
        Symbol::Time => t,
        other => panic!("the equations must not contain {other:?}"),
    };
    let [masses, dampers, springs] = constants(&mut equations);
    let (m, d, k) = (product(&equations, &masses), product(&equations, &dampers), product(&equations, &springs));
    let dynamics = equations.dynamics().clone();
    let mut mass = DMatrix::zeros(4, 4);
    for (row, entries) in dynamics.mass.iter().enumerate() {
        for &(column, entry) in entries {
            mass[(row, column)] = equations.system.arena.evaluate(&[entry], &values)[0];
        }
    }
    near(&mass, &m);
    near(&stiffness(&mut equations, Order::Velocity, &values), &d);
    near(&stiffness(&mut equations, Order::Position, &values), &k);
    let vibration = equations.vibration().unwrap();
    for (symbolic, product) in [(&vibration.mass, &m), (&vibration.damping, &d), (&vibration.stiffness, &k)] {
        let entries: Vec<f64> = equations.system.arena.evaluate(&symbolic.concat(), &values);
        near(&DMatrix::from_row_slice(4, 4, &entries), product);
    }
    // The whole equation: Q = A_F F - D v - K q.
    let forces: Vec<(String, f64)> = [10.0 * (3.0 * t).sin(), 5.0 * (-0.2 * t).exp() * (7.0 * t).cos(), 3.0, -2.5]
        .into_iter()
        .enumerate()
        .map(|(index, force)| (format!("F{}", 17 + index), force))
        .collect();
    let names: Vec<&str> = forces.iter().map(|(name, _)| name.as_str()).collect();
    let applied =
        cutset_columns(&equations, &names) * DVector::from_iterator(4, forces.iter().map(|(_, force)| *force));
    let forces = equations.system.arena.evaluate(&vibration.force, &values);
    near(&DMatrix::from_vec(4, 1, forces), &DMatrix::from_column_slice(4, 1, applied.as_slice()));
    let expected = applied - d * DVector::from_column_slice(v) - k * DVector::from_column_slice(q);
    let load = equations.system.arena.evaluate(&dynamics.load, &values);
    near(&DMatrix::from_vec(4, 1, load), &DMatrix::from_column_slice(4, 1, expected.as_slice()));
}

fn near(found: &DMatrix<f64>, expected: &DMatrix<f64>) {
    let error = (found - expected).amax();
    assert!(error <= 1e-13 * (1.0 + expected.amax()), "{found} instead of {expected}");
}

proptest! {
    #[test]
    fn eq33(q in prop::collection::vec(-1.0..1.0, 4), v in prop::collection::vec(-1.0..1.0, 4), t in 0.0..9.0) {
        check_eq33(&scene(), &q, &v, t);
    }

    #[test]
    fn eq33_floating(q in prop::collection::vec(-1.0..1.0, 4), v in prop::collection::vec(-1.0..1.0, 4), t in 0.0..9.0) {
        check_eq33(&floating(), &q, &v, t);
    }
}

/// Springs and dampers between the masses alone reach no ground: the tree of the floating system needs a mass (or a force on one).
#[test]
fn the_floating_system_needs_a_mass_in_its_tree() {
    let mechanism = mechanism(&floating());
    let system = System::new(&mechanism);
    let is_spring = |id: &cotree::network::ElementId| match system.element(*id).origin {
        Origin::Load(load) => mechanism.loads[load.0].component().name == "spring",
        _ => false,
    };
    let springs: Vec<_> = system.translation.edges().map(|(id, _)| id).filter(is_spring).collect();
    let tree = system.translation.tree(springs);
    assert_eq!(tree.branches.len(), BRANCHES.len() - 1);
    assert_eq!(system.translation.unreached(&tree.branches), ["m1", "m2", "m3", "m4"]);
}
