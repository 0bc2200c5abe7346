//! The choice of the trees, edge by edge (Tables 2 and 3).

use std::collections::BTreeMap;

use cotree::equations::Edge;
use cotree::network::{Element, ElementId, Origin, System, Tree as SpanningTree, Trees};
use cotree_draw::graph::GraphDrawing;

use super::graphs::shortened;
use super::projection::is_free;
use super::view::GraphView;
use super::{Lesson, check, heading, words};
use crate::document::{DocumentBlock, Piece};
use crate::name::Name;
use crate::tree::FormulaTree;

/// What was decided about edges that are decided alike.
struct Decision {
    rank: u8,
    labels: Vec<String>,
    unknowns: usize,
    branch: bool,
    reasons: Vec<String>,
    /// How many pieces are left.
    pieces: usize,
}

/// What an edge is in its graph: its place in the table, its unknowns, whether an arm, whether it holds anything.
struct EdgeFacts {
    rank: u8,
    unknowns: usize,
    is_fixed: bool,
    holds: bool,
}

impl EdgeFacts {
    fn of_points(element: &Element) -> EdgeFacts {
        let row = element.translation.as_ref();
        EdgeFacts {
            rank: row.map_or(u8::MAX, |row| row.priority),
            unknowns: row.map_or(0, |row| row.motion.len()),
            is_fixed: matches!(element.origin, Origin::Arm(..) | Origin::GroundVector(_)),
            holds: row.is_some_and(|row| !row.reaction.is_empty()),
        }
    }

    fn of_bodies(element: &Element) -> EdgeFacts {
        let (rank, free) = (element.rotation.as_ref().map_or(u8::MAX, |row| row.priority), is_free(element));
        EdgeFacts { rank, unknowns: usize::from(free), is_fixed: false, holds: !free }
    }
}

impl Lesson<'_> {
    pub fn trees(&mut self) -> Vec<DocumentBlock> {
        let mut graphs = GraphDrawing::new(self.source);
        graphs.translation.nodes.clone_from(&self.translation.nodes);
        graphs.rotation.iter_mut().for_each(|graph| graph.nodes.clone_from(&self.rotation.nodes));
        let mut blocks = vec![
            heading("3. Which unknowns? The two trees"),
            DocumentBlock::Picture(graphs.graphs_alone(), "--graph"),
            words(
                "A tree joins all nodes without a closed path. Its edges' unknown displacements become the coordinates, so edges with \
                 few unknowns go first; an edge that would close a path is a chord.",
            ),
        ];
        let (system, trees) = (&self.equations.system, &self.equations.trees);
        let least = Trees::recommended(system);
        let recommended = least == *trees;
        if !recommended {
            blocks.push(words(
                "The scene chose these trees itself (`[coordinates]`): what it names comes first, in its order; Tables 2 and 3 are \
                 not asked.",
            ));
        }
        let (points, bodies) = Trees::order(system);
        let points = ordered(points, &trees.translation, recommended);
        blocks.extend(table("T (Table 2)", (system, &self.translation), points, EdgeFacts::of_points));
        let bodies = ordered(bodies, &trees.rotation, recommended);
        blocks.extend(table("R (Table 3)", (system, &self.rotation), bodies, EdgeFacts::of_bodies));
        blocks.push(self.coordinates());
        blocks.push(words(self.weights(&least)));
        let spans = |branches: usize, nodes: usize| branches + 1 == nodes;
        let holds = spans(self.translation.record.cutsets.len(), self.translation.nodes.len())
            && spans(self.rotation.record.cutsets.len(), self.rotation.nodes.len());
        let text = format!(
            "{} branches for {} nodes in T, {} for {} in R",
            self.translation.record.cutsets.len(),
            self.translation.nodes.len(),
            self.rotation.record.cutsets.len(),
            self.rotation.nodes.len()
        );
        blocks.push(check(&text, holds));
        blocks
    }

    /// {q} = {theta_1, theta_2}
    fn coordinates(&self) -> DocumentBlock {
        let coordinates = &self.equations.coordinates;
        if coordinates.is_empty() {
            return words("No displacement or angle of a branch is unknown: there are no coordinates.");
        }
        let mut pieces = vec![Piece::words("Coordinates: ")];
        for (index, coordinate) in coordinates.iter().enumerate() {
            let element = self.equations.system.element(coordinate.element);
            let what = if coordinate.angular { "angle of" } else { "displacement of" };
            if index == 12 && coordinates.len() > 16 {
                pieces.push(Piece::words(format!(", and {} more in the same way", coordinates.len() - index)));
                break;
            }
            pieces.push(Piece::words(if index > 0 { ", " } else { "" }));
            pieces.push(Piece::Math(FormulaTree::Name(Name::symbol(&coordinate.name.position))));
            pieces.push(Piece::words(format!(" ({what} {}, {})", element.label, element.name)));
        }
        pieces.push(Piece::words("."));
        DocumentBlock::Text(pieces)
    }

    /// The numbers of unknowns against those of the recommended trees, which no others have fewer than.
    fn weights(&self, least: &Trees) -> String {
        let coordinates = &self.equations.coordinates;
        let r = coordinates.iter().filter(|coordinate| coordinate.angular).count();
        let t = coordinates.len() - r;
        let unknowns =
            |id: &ElementId, facts: fn(&Element) -> EdgeFacts| facts(self.equations.system.element(*id)).unknowns;
        let t_least: usize = least.translation.branches.iter().map(|id| unknowns(id, EdgeFacts::of_points)).sum();
        let r_least: usize = least.rotation.branches.iter().map(|id| unknowns(id, EdgeFacts::of_bodies)).sum();
        let verdict = match (t + r).cmp(&(t_least + r_least)) {
            std::cmp::Ordering::Greater => format!("Tables 2 and 3 would give {t_least} + {r_least}"),
            _ => "no pair of trees has fewer coordinates (minimum-weight spanning trees)".to_owned(),
        };
        let is_pin = |element: &Element| {
            matches!(element.origin, Origin::Joint(_))
                && element.translation.as_ref().is_some_and(|row| row.motion.is_empty() && row.reaction.len() == 2)
        };
        let refused = self.translation.elements(&self.equations.system, is_pin).next().is_some();
        let tie = match (refused, *least == self.equations.trees, self.letters.has_two_components()) {
            (.., false) => "",
            (false, ..) => " All revolute joints were taken: no tie about where to cut a loop.",
            (_, true, _) => {
                " Revolute joints were taken breadth first from the ground, so that loops are cut in their middle."
            }
            (_, false, _) => "",
        };
        format!("Tree weights {t} + {r}: {verdict}.{tie}")
    }
}

/// The order of the table, or that in which the scene's own trees take their branches.
fn ordered<D>(table: Vec<ElementId>, tree: &SpanningTree<D>, recommended: bool) -> Vec<ElementId> {
    if recommended { table } else { tree.branches.iter().chain(&tree.chords).copied().collect() }
}

/// Kruskal's algorithm once more, with a reason for each edge.
fn table<D>(
    title: &str,
    (system, view): (&System, &GraphView<D>),
    order: Vec<ElementId>,
    facts: fn(&Element) -> EdgeFacts,
) -> Vec<DocumentBlock> {
    if view.nodes.len() < 2 {
        return vec![words("Nothing turns: there is no rotational tree.")];
    }
    let edges: BTreeMap<ElementId, &Edge<D>> =
        view.record.edges.iter().filter(|edge| edge.term.is_none()).map(|edge| (edge.element, edge)).collect();
    let mut class: Vec<usize> = (0..view.nodes.len()).collect();
    let mut pieces = class.len();
    let mut decisions: Vec<Decision> = Vec::new();
    for (id, edge) in order.iter().filter_map(|id| Some((*id, *edges.get(id)?))) {
        let known = facts(system.element(id));
        let [a, b] = edge.ends.map(|node| class[node.index()]);
        let branch = a != b;
        let reason = match branch {
            true if known.is_fixed => "always".to_owned(),
            true => format!("joins {} to {}", piece(view, &class, b), piece(view, &class, a)),
            false => refusal(view, id, &known),
        };
        if branch {
            pieces -= 1;
            class.iter_mut().filter(|other| **other == b).for_each(|other| *other = a);
        }
        let decision = Decision {
            rank: known.rank,
            labels: vec![edge.label.clone()],
            unknowns: known.unknowns,
            branch,
            reasons: vec![reason],
            pieces,
        };
        add(&mut decisions, decision, known.is_fixed || edges.len() > 24);
    }
    let head = [title, "unknowns", "verdict", "reason", "pieces left"].map(str::to_owned);
    vec![DocumentBlock::captioned(
        format!("The tree of {title}, edge by edge"),
        head.into(),
        decisions.iter().map(row).collect(),
    )]
}

/// Edges that are decided alike share a row.
fn add(decisions: &mut Vec<Decision>, new: Decision, many: bool) {
    if let Some(last) = decisions.last_mut()
        && (last.rank, last.branch, last.unknowns) == (new.rank, new.branch, new.unknowns)
        && (many || !new.branch || last.reasons == new.reasons)
    {
        last.labels.extend(new.labels);
        if last.reasons != new.reasons {
            last.reasons.extend(new.reasons);
        }
        last.pieces = new.pieces;
    } else {
        decisions.push(new);
    }
}

fn row(decision: &Decision) -> Vec<Piece> {
    let labels: Vec<&str> = decision.labels.iter().map(String::as_str).collect();
    let each = if labels.len() > 1 && decision.unknowns > 0 { " each" } else { "" };
    let reason = match decision.reasons.as_slice() {
        [only] => only.clone(),
        [first, others @ ..] if others.len() < 5 => {
            let others = others.iter().map(|other| format!("; {}", other.trim_start_matches("closes a loop ")));
            format!("{first}{}", others.collect::<String>())
        }
        [first, .., last] => format!("{first}; ...; {}", last.trim_start_matches("closes a loop ")),
        [] => String::new(),
    };
    let pieces = match (decision.branch, decision.pieces) {
        (false, _) => String::new(),
        (true, 1) => "1: complete".to_owned(),
        (true, pieces) => pieces.to_string(),
    };
    vec![
        Piece::words(format!("{} {}", decision.rank, shortened(&labels))),
        Piece::words(format!("{}{each}", decision.unknowns)),
        Piece::words(if decision.branch { "branch" } else { "chord" }),
        Piece::words(reason),
        Piece::words(pieces),
    ]
}

/// The nodes of a piece.
fn piece<D>(view: &GraphView<D>, class: &[usize], which: usize) -> String {
    let nodes = class.iter().zip(&view.nodes).filter(|(class, _)| **class == which).map(|(_, name)| name.as_str());
    match nodes.collect::<Vec<&str>>().as_slice() {
        [only] => (*only).to_owned(),
        list if list.len() <= 6 => format!("{{{}}}", list.join(" ")),
        list => format!("{{{} ... {}}}", list[..3].join(" "), list[list.len() - 1]),
    }
}

fn refusal<D>(view: &GraphView<D>, id: ElementId, edge_facts: &EdgeFacts) -> String {
    let circuit = view.record.circuit(id).map(|row| view.labels(row)).unwrap_or_default();
    match circuit.as_slice() {
        [] | [_] => "closes a loop with itself".to_owned(),
        [_, others @ ..] => {
            let cut = if edge_facts.holds { ": the loop is cut here" } else { "" };
            format!("closes a loop with {}{cut}", shortened(others))
        }
    }
}
