//! Cutsets and circuits of both graphs against the incidence matrix, in exact integers.

use std::collections::HashMap;

use cotree::equations::{EdgeRow, Equations, GraphRecord};
use cotree::network::{ElementId, LinearGraph, Node, System, Topology, Tree, Trees};

use super::{cases, choices, mechanism};
use crate::support::random::Family;

#[test]
fn cutsets_and_circuits_are_orthogonal() {
    for family in [Family::Chain, Family::Tree, Family::Loops, Family::Driven, Family::Redundant] {
        for (seed, case) in cases(family, 40) {
            let mechanism = mechanism(&case.scene);
            for choice in choices(&mechanism, seed, 3) {
                let system = System::new(&mechanism);
                let trees = Trees::select(&system, &choice).unwrap();
                check(&system.translation, &trees.translation);
                check(&system.rotation, &trees.rotation);
                let equations = Equations::new(system, trees);
                let (points, bodies) = equations.record();
                check_record(&points, &equations.system.translation, &equations.trees.translation);
                check_record(&bodies, &equations.system.rotation, &equations.trees.rotation);
            }
        }
    }
}

/// Columns of the reduced incidence matrix: -1 at the first node, +1 at the second.
type Columns = HashMap<ElementId, Vec<i32>>;

fn incidence<D>(graph: &LinearGraph<D>) -> Columns {
    let column = |ends: [Node<D>; 2]| {
        let mut column = vec![0; graph.nodes()];
        column[ends[0].index()] -= 1;
        column[ends[1].index()] += 1;
        column.split_off(1)
    };
    graph.edges().map(|(element, ends)| (element, column(ends))).collect()
}

fn check<D>(graph: &LinearGraph<D>, tree: &Tree<D>) {
    assert_eq!(tree.branches.len(), graph.nodes() - 1, "a spanning tree");
    assert_eq!(tree.branches.len() + tree.chords.len(), graph.edges().count(), "every edge is a branch or a chord");
    let topology = Topology::new(graph, tree);
    let (cutsets, circuits) = (topology.cutsets(tree), topology.circuits(tree));
    let mut transposed: HashMap<(ElementId, ElementId), i8> = HashMap::new();
    for (branch, row) in tree.branches.iter().zip(&cutsets) {
        transposed.extend(row.iter().map(|&(chord, sign)| ((chord, *branch), sign)));
    }
    let columns = incidence(graph);
    for (chord, row) in tree.chords.iter().zip(&circuits) {
        // B = -A^T, entry by entry.
        assert_eq!(row.len(), transposed.keys().filter(|(of, _)| of == chord).count());
        assert!(row.iter().all(|(branch, sign)| transposed.get(&(*chord, *branch)) == Some(&-sign)));
        // N_chord = N_b A, so that [1 A] is the incidence matrix with its rows combined: cutsets are true cuts.
        // The same sum says that the circuit closes: N B_f^T = 0.
        let mut sum = columns[chord].clone();
        for (branch, sign) in row {
            sum.iter_mut().zip(&columns[branch]).for_each(|(sum, entry)| *sum += i32::from(*sign) * entry);
        }
        assert!(sum.iter().all(|&entry| entry == 0), "a circuit closes");
    }
    // A_f B_f^T = 0: every cutset with every circuit.
    for (branch, cutset) in tree.branches.iter().zip(&cutsets) {
        let cutset: HashMap<ElementId, i8> = cutset.iter().copied().chain([(*branch, 1)]).collect();
        for (chord, circuit) in tree.chords.iter().zip(&circuits) {
            let terms = circuit.iter().copied().chain([(*chord, 1)]);
            let product: i32 = terms.map(|(e, s)| i32::from(s) * i32::from(cutset.get(&e).copied().unwrap_or(0))).sum();
            assert_eq!(product, 0);
        }
    }
}

/// The record, whose cutsets come from the through variables, has the rows of both matrices; the circuits of coupled terms close, too.
fn check_record<D>(record: &GraphRecord<D>, graph: &LinearGraph<D>, tree: &Tree<D>) {
    let topology = Topology::new(graph, tree);
    let edges = |row: &EdgeRow| -> HashMap<ElementId, i8> {
        let own = row.iter().filter(|(edge, _)| record.edges[*edge].term.is_none());
        own.map(|&(edge, sign)| (record.edges[edge].element, sign)).collect()
    };
    let same = |rows: &[EdgeRow], owners: &[ElementId], expected: Vec<Vec<(ElementId, i8)>>| {
        for ((row, owner), expected) in rows.iter().zip(owners).zip(expected) {
            assert_eq!(record.edge_of(row).element, *owner);
            assert_eq!(edges(row), expected.into_iter().chain([(*owner, 1)]).collect());
        }
    };
    assert_eq!(
        [record.cutsets.len(), tree.chords.len()],
        [tree.branches.len(), graph.edges().count() - tree.branches.len()]
    );
    same(&record.cutsets, &tree.branches, topology.cutsets(tree));
    same(&record.circuits, &tree.chords, topology.circuits(tree));
    for circuit in &record.circuits {
        let mut sum = vec![0; graph.nodes()];
        for &(edge, sign) in circuit {
            let [from, to] = record.edges[edge].ends.map(Node::index);
            sum[from] -= i32::from(sign);
            sum[to] += i32::from(sign);
        }
        assert!(sum.iter().all(|&entry| entry == 0), "a circuit closes");
    }
    for (cutset, circuit) in record.cutsets.iter().flat_map(|row| record.circuits.iter().map(move |own| (row, own))) {
        let signs: HashMap<usize, i8> = cutset.iter().copied().collect();
        let product: i8 = circuit.iter().map(|(edge, sign)| sign * signs.get(edge).copied().unwrap_or(0)).sum();
        assert_eq!(product, 0, "A_f B_f^T = 0");
    }
}
