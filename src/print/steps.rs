//! The derivation as a lesson, in the order of the paper: elements and graphs, trees, cutsets and circuits, terminal equations, then
//! Steps 1 to 4.

mod terminal;

use super::document::{Block, Piece};
use super::motion::Motion;
use super::name::Name;
use super::tree::Tree;
use super::{Prose, page};
use crate::element::{Angle, Direction, Element, Held, Origin};
use crate::equations::Equations;
use crate::graph::{ElementId, LinearGraph, Topology};

/// Wider tables are left out: nobody reads them.
const WIDEST: usize = 40;

/// The derivation of the equations of motion.
pub fn steps(equations: &mut Equations, prose: Prose) -> String {
    let motion = Motion::new(equations);
    let mut blocks = elements(equations);
    blocks.extend(graphs(equations));
    blocks.extend(topology(equations));
    blocks.push(heading("Terminal equations (Table 1)"));
    blocks.push(words("What each element says by itself; u and n are unit vectors along and across an axis."));
    blocks.push(Block::Equations(terminal::equations(equations, motion.dynamic)));
    if motion.dynamic {
        blocks.extend(cutset_equations(equations));
    }
    blocks.extend(circuit_equations(equations));
    blocks.extend(eliminations(equations, motion.dynamic));
    blocks.push(heading("Step 4: the equations of motion"));
    blocks.push(words("With all secondary variables eliminated, in the branch coordinates alone:"));
    blocks.extend(motion.blocks(equations));
    let title = format!("How the equations of motion of {} are derived", equations.system.mechanism.name);
    page(&title, &blocks, prose)
}

fn heading(text: &str) -> Block {
    Block::Heading(text.into())
}

fn words(text: impl Into<String>) -> Block {
    Block::Text(vec![Piece::words(text)])
}

/// `F_h9`: a through or across variable of an element, with its label below.
fn of(letter: &str, element: &Element) -> Tree {
    Tree::Name(Name::bold(letter, &element.label))
}

/// An angle or torque: a scalar in the plane.
fn scalar(letter: &str, element: &Element) -> Tree {
    Tree::Name(Name::letter(letter, &element.label))
}

fn elements(equations: &Equations) -> Vec<Block> {
    let system = &equations.system;
    let (t_ends, r_ends) = (ends(&system.translation), ends(&system.rotation));
    let rows = system.elements.iter().enumerate().map(|(index, element)| {
        let id = ElementId(index);
        let between = |ends: &[(ElementId, String)]| {
            ends.iter().find(|(other, _)| *other == id).map_or_else(|| "-".to_owned(), |(_, ends)| ends.clone())
        };
        vec![
            Piece::words(&element.label),
            Piece::Code(element.name.clone()),
            Piece::words(kind(element)),
            Piece::words(between(&t_ends)),
            Piece::words(between(&r_ends)),
        ]
    });
    let head = ["element", "name", "kind", "translational graph", "rotational graph"].map(str::to_owned);
    vec![
        heading("Elements"),
        words("Each part of the mechanism is an edge of one or both linear graphs: from a node to a node."),
        Block::Table(head.into(), rows.collect()),
    ]
}

fn kind(element: &Element) -> &'static str {
    match element.origin {
        Origin::Body(_) => "rigid body",
        Origin::Arm(..) => "rigid arm",
        Origin::GroundVector(_) => "ground vector",
        Origin::Driver(_) => "driver",
        Origin::Load(_) => "load",
        // What relates motions of other elements is no edge.
        Origin::Joint(_) if element.coupling.is_some() && element.translation.is_none() => "coupling",
        Origin::Joint(_) if element.coupling.is_some() => "rolling disc",
        Origin::Joint(_) => match (&element.translation, &element.rotation) {
            (Some(row), Some(turn)) if !row.motion.is_empty() && matches!(turn.angle, Angle::Free(_)) => "pin in slot",
            (Some(row), _) if !row.motion.is_empty() => "prismatic joint",
            (_, Some(row)) if matches!(row.angle, Angle::Free(_)) => "revolute joint",
            _ => "weld",
        },
    }
}

fn ends<D>(graph: &LinearGraph<D>) -> Vec<(ElementId, String)> {
    let names: Vec<&str> = graph.node_names().collect();
    graph.edges().map(|(id, [a, b])| (id, format!("{} -> {}", names[a.index()], names[b.index()]))).collect()
}

fn graphs(equations: &Equations) -> Vec<Block> {
    let system = &equations.system;
    let mut blocks = vec![heading("Incidence matrices")];
    blocks.push(words(
        "-1: the edge leaves the node, 1: it arrives; the row of the ground, minus the sum of the others, is left out.",
    ));
    blocks.extend(incidence(equations, "Translational graph", &system.translation));
    blocks.extend(incidence(equations, "Rotational graph", &system.rotation));
    blocks
}

fn incidence<D>(equations: &Equations, title: &str, graph: &LinearGraph<D>) -> Vec<Block> {
    let edges: Vec<(ElementId, [usize; 2])> =
        graph.edges().map(|(id, ends)| (id, ends.map(|node| node.index()))).collect();
    let rows = graph.node_names().enumerate().skip(1).map(|(node, name)| {
        let sign = |ends: [usize; 2]| i8::from(ends[1] == node) - i8::from(ends[0] == node);
        (name.to_owned(), edges.iter().map(|(_, ends)| sign(*ends)).collect())
    });
    let columns = edges.iter().map(|(id, _)| equations.system.element(*id).label.clone()).collect();
    matrix(title, columns, rows.collect())
}

/// A matrix of signs with names beside the rows and above the columns.
fn matrix(title: &str, columns: Vec<String>, rows: Vec<(String, Vec<i8>)>) -> Vec<Block> {
    if rows.is_empty() || columns.is_empty() {
        return Vec::new();
    }
    if columns.len() > WIDEST {
        return vec![words(format!("{title}: {} x {}, too large to be shown.", rows.len(), columns.len()))];
    }
    let cell = |sign: i8| Piece::words(if sign == 0 { ".".to_owned() } else { sign.to_string() });
    let rows = rows
        .into_iter()
        .map(|(name, signs)| std::iter::once(Piece::words(name)).chain(signs.into_iter().map(cell)).collect());
    let head = std::iter::once(title.to_owned()).chain(columns).collect();
    vec![Block::Table(head, rows.collect())]
}

/// Trees, cutset and circuit matrices.
fn topology(equations: &Equations) -> Vec<Block> {
    let (system, trees) = (&equations.system, &equations.trees);
    let names = |ids: &[ElementId]| -> String {
        let names: Vec<&str> = ids.iter().map(|&id| system.element(id).label.as_str()).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    };
    let coordinates: Vec<&str> = equations.coordinates.iter().map(|q| q.name.position.as_str()).collect();
    let mut blocks = vec![heading("Trees")];
    blocks.push(words(format!(
        "Translational tree: branches {}; chords {}.",
        names(&trees.translation.branches),
        names(&trees.translation.chords)
    )));
    if system.rotation.nodes() > 1 {
        blocks.push(words(format!(
            "Rotational tree: branches {}; chords {}.",
            names(&trees.rotation.branches),
            names(&trees.rotation.chords)
        )));
    }
    blocks.push(words(format!(
        "The unknown displacements and angles of the branches are the coordinates: {}.",
        coordinates.join(", ")
    )));
    blocks.push(heading("Cutset and circuit matrices"));
    blocks.push(words("Forces and torques: {F}_branches = -[A]{F}_chords (9). Displacements and angles: {r}_chords = -[B]{r}_branches (12). [B] is minus [A] transposed (13)."));
    let t = Topology::new(&system.translation, &trees.translation);
    let r = Topology::new(&system.rotation, &trees.rotation);
    let labels =
        |ids: &[ElementId]| -> Vec<String> { ids.iter().map(|&id| system.element(id).label.clone()).collect() };
    let dense = |rows: Vec<crate::graph::SignedRow>, names: &[ElementId], columns: &[ElementId]| {
        let sign = |row: &crate::graph::SignedRow, column: ElementId| {
            row.iter().find(|(id, _)| *id == column).map_or(0, |(_, sign)| *sign)
        };
        let row = |row: &crate::graph::SignedRow| columns.iter().map(|&column| sign(row, column)).collect();
        labels(names).into_iter().zip(rows.iter().map(row)).collect::<Vec<(String, Vec<i8>)>>()
    };
    let tree = &trees.translation;
    blocks.extend(matrix(
        "[A], translation",
        labels(&tree.chords),
        dense(t.cutsets(tree), &tree.branches, &tree.chords),
    ));
    blocks.extend(matrix(
        "[B], translation",
        labels(&tree.branches),
        dense(t.circuits(tree), &tree.chords, &tree.branches),
    ));
    let tree = &trees.rotation;
    blocks.extend(matrix("[A], rotation", labels(&tree.chords), dense(r.cutsets(tree), &tree.branches, &tree.chords)));
    blocks.extend(matrix(
        "[B], rotation",
        labels(&tree.branches),
        dense(r.circuits(tree), &tree.chords, &tree.branches),
    ));
    blocks
}

/// A sum of variables of elements with the signs of a row.
fn signed(
    equations: &Equations,
    own: Option<ElementId>,
    row: &[(ElementId, i8)],
    letter: fn(&Element) -> Tree,
) -> Tree {
    let element = |id: ElementId| letter(equations.system.element(id));
    let others = row.iter().map(|&(id, sign)| (sign < 0, element(id)));
    Tree::sum(own.map(|id| (false, element(id))).into_iter().chain(others).collect())
}

fn force(element: &Element) -> Tree {
    of("F", element)
}
fn torque(element: &Element) -> Tree {
    scalar("T", element)
}
fn displacement(element: &Element) -> Tree {
    of("r", element)
}
fn acceleration(element: &Element) -> Tree {
    of("a", element)
}
fn angle(element: &Element) -> Tree {
    scalar("theta", element)
}

/// The unit vector of a direction, with the element whose axis it is.
fn direction(direction: Direction, element: &Element, along: bool) -> Tree {
    Tree::Name(match direction {
        Direction::X => Name::bold("i", ""),
        Direction::Y => Name::bold("j", ""),
        Direction::Fixed(..) => Name::bold(if along { "u" } else { "n" }, &element.label),
    })
}

fn dot(a: Tree, b: Tree) -> Tree {
    Tree::Relation(".", Box::new([a, b]))
}

/// Step 1: cutsets of branches, projected on what the branch leaves free.
fn cutset_equations(equations: &Equations) -> Vec<Block> {
    let (system, trees) = (&equations.system, &equations.trees);
    let mut rows = Vec::new();
    let topology = Topology::new(&system.translation, &trees.translation);
    for (&branch, cutset) in trees.translation.branches.iter().zip(topology.cutsets(&trees.translation)) {
        let element = system.element(branch);
        for (along, _) in element.translation.iter().flat_map(|row| &row.motion) {
            let sum = signed(equations, Some(branch), &cutset, force);
            rows.push((dot(sum, direction(*along, element, true)), Tree::zero()));
        }
    }
    let topology = Topology::new(&system.rotation, &trees.rotation);
    for (&branch, cutset) in trees.rotation.branches.iter().zip(topology.cutsets(&trees.rotation)) {
        let free = system.element(branch).rotation.as_ref().is_some_and(|row| matches!(row.angle, Angle::Free(_)));
        if free {
            rows.push((signed(equations, Some(branch), &cutset, torque), Tree::zero()));
        }
    }
    vec![
        heading("Step 1: cutset equations on the motion spaces"),
        words(
            "For each coordinate, the balance of its branch's cutset, projected on the direction in which the branch can move (14):",
        ),
        Block::Equations(rows),
    ]
}

/// Step 2: circuits of chords, projected on what the chord holds; and the displacements of slides.
fn circuit_equations(equations: &Equations) -> Vec<Block> {
    let (system, trees) = (&equations.system, &equations.trees);
    let t = Topology::new(&system.translation, &trees.translation);
    let r = Topology::new(&system.rotation, &trees.rotation);
    // A coupling is no circuit: its relation is its loop equation itself, among the final equations.
    let circuits = equations.constraints.iter().filter(|constraint| constraint.coupled.is_empty());
    let held = circuits.map(|constraint| {
        let element = system.element(constraint.element);
        match constraint.held {
            Held::Along(along) => {
                let sum = signed(equations, Some(constraint.element), &t.circuit(constraint.element), displacement);
                (dot(sum, direction(along, element, matches!(element.origin, Origin::Driver(_)))), Tree::zero())
            }
            Held::Angle | Held::Length => {
                (signed(equations, Some(constraint.element), &r.circuit(constraint.element), angle), Tree::zero())
            }
        }
    });
    let held: Vec<(Tree, Tree)> = held.collect();
    let mut blocks = vec![heading("Step 2: circuit equations on the reaction spaces")];
    let coupled = equations.constraints.iter().filter(|constraint| !constraint.coupled.is_empty());
    let coupled: Vec<&str> =
        coupled.map(|constraint| equations.system.element(constraint.element).label.as_str()).collect();
    if !coupled.is_empty() {
        blocks.push(words(format!(
            "Couplings ({}) are no circuits: each is one relation between across variables, which is its loop equation in step 4, and \
             adds the transposed loads, its reaction times Phi_q, to the equations of step 1.",
            coupled.join(", ")
        )));
    }
    if held.is_empty() {
        if !coupled.is_empty() {
            return blocks;
        }
        blocks.push(words("No chord holds anything: there are no loop equations."));
        return blocks;
    }
    blocks.push(words("For each direction that a chord holds, its circuit projected on that direction (15); the reaction in that direction is its multiplier:"));
    blocks.push(Block::Equations(held));
    let slides = trees.translation.chords.iter().filter_map(|&chord| {
        let element = system.element(chord);
        let along = match (element.origin, &element.translation) {
            (Origin::Joint(_), Some(row)) => row.motion.first().map(|(along, _)| *along)?,
            _ => return None,
        };
        let path: Vec<(ElementId, i8)> = t.circuit(chord).into_iter().map(|(id, sign)| (id, -sign)).collect();
        let sum = signed(equations, None, &path, displacement);
        Some((scalar("s", element), dot(sum, direction(along, element, true))))
    });
    let slides: Vec<(Tree, Tree)> = slides.collect();
    if !slides.is_empty() {
        blocks.push(words("Projected on the direction in which it slides, the circuit gives the slide itself:"));
        blocks.push(Block::Equations(slides));
    }
    blocks
}

/// Step 3: arm forces by chords; chord accelerations and angles by branches.
fn eliminations(equations: &Equations, dynamic: bool) -> Vec<Block> {
    let (system, trees) = (&equations.system, &equations.trees);
    let t = Topology::new(&system.translation, &trees.translation);
    let r = Topology::new(&system.rotation, &trees.rotation);
    let minus =
        |row: &[(ElementId, i8)]| -> Vec<(ElementId, i8)> { row.iter().map(|&(id, sign)| (id, -sign)).collect() };
    let mut blocks = vec![heading("Step 3: secondary variables are eliminated")];
    if dynamic {
        let arms = trees.translation.branches.iter().zip(t.cutsets(&trees.translation));
        let arms = arms.filter(|(branch, _)| matches!(system.element(**branch).origin, Origin::Arm(..)));
        let rows: Vec<(Tree, Tree)> = arms
            .map(|(&branch, cutset)| (force(system.element(branch)), signed(equations, None, &minus(&cutset), force)))
            .collect();
        if !rows.is_empty() {
            blocks.push(words("Forces in rigid arms, by the chord transformation (16):"));
            blocks.push(Block::Equations(rows));
        }
    }
    let letter = if dynamic { acceleration } else { displacement };
    let bodies =
        trees.translation.chords.iter().filter(|&&chord| matches!(system.element(chord).origin, Origin::Body(_)));
    let rows: Vec<(Tree, Tree)> = bodies
        .map(|&chord| (letter(system.element(chord)), signed(equations, None, &minus(&t.circuit(chord)), letter)))
        .collect();
    if !rows.is_empty() {
        let what = if dynamic { "Accelerations of mass centres" } else { "Positions of mass centres" };
        let arms = if dynamic { "; an arm's is alpha x r - omega^2 r of its body" } else { "" };
        blocks.push(words(format!("{what}, by the branch transformation of the translational tree (17){arms}:")));
        blocks.push(Block::Equations(rows));
    }
    let free = trees.rotation.chords.iter().filter(|&&chord| {
        system.element(chord).rotation.as_ref().is_some_and(|row| matches!(row.angle, Angle::Free(_)))
    });
    let rows: Vec<(Tree, Tree)> = free
        .map(|&chord| (angle(system.element(chord)), signed(equations, None, &minus(&r.circuit(chord)), angle)))
        .collect();
    if !rows.is_empty() {
        blocks.push(words("Angles of chords, and in the same way their rates, by the branch transformation of the rotational tree (18):"));
        blocks.push(Block::Equations(rows));
    }
    blocks
}
