//! Elements, incidence matrices, trees, cutset and circuit matrices.

use super::view::{Edge, Row, View};
use super::{Lesson, heading, words};
use crate::component::{Angle, Element, Origin};
use crate::graph::ElementId;
use crate::output::text::document::{Block, Piece};

/// Wider tables are left out.
const WIDEST: usize = 40;

impl Lesson<'_, '_> {
    pub fn elements(&self) -> Vec<Block> {
        let rows = self.equations.system.elements.iter().enumerate().map(|(index, element)| {
            let id = ElementId(index);
            vec![
                Piece::words(&element.label),
                Piece::Code(element.name.clone()),
                Piece::words(kind(element)),
                Piece::words(ends(&self.translation, id)),
                Piece::words(ends(&self.rotation, id)),
            ]
        });
        let head = ["element", "name", "kind", "translational graph", "rotational graph"].map(str::to_owned);
        vec![
            heading("Elements"),
            words("Each part of the mechanism is an edge of one or both linear graphs: from a node to a node."),
            Block::Table(head.into(), rows.collect()),
        ]
    }

    pub fn incidence(&self) -> Vec<Block> {
        let mut blocks = vec![heading("Incidence matrices")];
        blocks.push(words(
            "-1: the edge leaves the node, 1: it arrives; the row of the ground, minus the sum of the others, is left out.",
        ));
        blocks.extend(incidence("Translational graph", &self.translation));
        blocks.extend(incidence("Rotational graph", &self.rotation));
        blocks
    }

    pub fn topology(&self) -> Vec<Block> {
        let coordinates: Vec<&str> =
            self.equations.coordinates.iter().map(|coordinate| coordinate.name.position.as_str()).collect();
        let mut blocks = vec![heading("Trees"), words(format!("Translational tree: {}", tree(&self.translation)))];
        if self.rotation.nodes.len() > 1 {
            blocks.push(words(format!("Rotational tree: {}", tree(&self.rotation))));
        }
        if self.equations.coordinates.is_empty() {
            blocks.push(words("No displacement or angle of a branch is unknown: there are no coordinates."));
        } else {
            blocks.push(words(format!(
                "The unknown displacements and angles of the branches are the coordinates: {}.",
                coordinates.join(", ")
            )));
        }
        blocks.push(heading("Cutset and circuit matrices"));
        blocks.push(words("Forces and torques: {F}_branches = -[A]{F}_chords (9). Displacements and angles: {r}_chords = -[B]{r}_branches (12). [B] is minus [A] transposed (13)."));
        blocks.extend(matrices("translation", &self.translation));
        blocks.extend(matrices("rotation", &self.rotation));
        blocks
    }
}

fn kind(element: &Element) -> &'static str {
    match element.origin {
        Origin::Body(_) => "rigid body",
        Origin::Arm(..) => "rigid arm",
        Origin::GroundVector(_) => "ground vector",
        Origin::Driver(_) => "driver",
        Origin::Load(_) => "load",
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

/// The nodes of an element; those of each term of a coupling behind the term's label.
fn ends<D>(view: &View<D>, element: ElementId) -> String {
    let edges: Vec<&Edge<D>> = view.edges().into_iter().filter(|edge| edge.element == element).collect();
    let one = |edge: &Edge<D>| {
        let [a, b] = edge.ends.map(|node| view.nodes[node.index()].as_str());
        if edges.len() > 1 { format!("{}: {a} -> {b}", edge.label) } else { format!("{a} -> {b}") }
    };
    let all: Vec<String> = edges.iter().map(|edge| one(edge)).collect();
    if all.is_empty() { "-".to_owned() } else { all.join(", ") }
}

fn tree<D>(view: &View<D>) -> String {
    let names = |edges: &[Edge<D>]| match labels(edges).join(", ") {
        names if names.is_empty() => "none".to_owned(),
        names => names,
    };
    format!("branches {}; chords {}.", names(&view.branches), names(&view.chords))
}

fn labels<D>(edges: &[Edge<D>]) -> Vec<String> {
    edges.iter().map(|edge| edge.label.clone()).collect()
}

fn incidence<D>(title: &str, view: &View<D>) -> Vec<Block> {
    let edges = view.edges();
    let rows = view.nodes.iter().enumerate().skip(1).map(|(node, name)| {
        let at = |edge: &&Edge<D>| edge.ends.map(|end| i8::from(end.index() == node));
        (name.clone(), edges.iter().map(at).map(|[from, to]| to - from).collect())
    });
    matrix(title, edges.iter().map(|edge| edge.label.clone()).collect(), rows.collect())
}

fn matrices<D>(which: &str, view: &View<D>) -> Vec<Block> {
    let (branches, chords) = (labels(&view.branches), labels(&view.chords));
    let circuits = view.chords.iter().map(|chord| view.circuit(chord)).collect();
    let mut blocks = matrix(&format!("[A], {which}"), chords.clone(), dense(&branches, view.cutsets(), &chords));
    blocks.extend(matrix(&format!("[B], {which}"), branches.clone(), dense(&chords, circuits, &branches)));
    blocks
}

fn dense(names: &[String], rows: Vec<Row>, columns: &[String]) -> Vec<(String, Vec<i8>)> {
    let sign = |row: &Row, column: &String| row.iter().find(|(label, _)| label == column).map_or(0, |(_, sign)| *sign);
    let signs = rows.iter().map(|row| columns.iter().map(|column| sign(row, column)).collect());
    names.iter().cloned().zip(signs).collect()
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
