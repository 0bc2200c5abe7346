//! The two linear graphs of a mechanism beside its drawing, as in the paper's Figs 1-3: tree edges bold, elements by their labels.

mod covered;
mod dot;
mod layout;
mod picture;

use cotree::diagnostic::Faults;
use cotree::formulate::{Formulated, formulate};
use cotree::model::Dimension;
use cotree::network::{CoupledEdge, ElementId, LinearGraph, System, Tree};
use cotree::scene::Scene;

use super::drawing::Drawing;
use super::pose;

#[derive(Clone, Debug)]
pub struct GraphDrawing {
    pub title: String,
    pub elements: Vec<(String, String)>,
    pub translation: Graph,
    /// Of the bodies; a mechanism on a line has none.
    pub rotation: Option<Graph>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Graph {
    /// The user's names of the nodes; the datum is the first.
    pub nodes: Vec<String>,
    /// Where they are, in units of the length of an ordinary edge, y upwards.
    pub places: Vec<[f64; 2]>,
    pub edges: Vec<DrawnEdge>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct DrawnEdge {
    /// Such as `h9`.
    pub label: String,
    pub name: String,
    /// Nodes: from, to.
    pub ends: [usize; 2],
    pub branch: bool,
}

impl GraphDrawing {
    /// Lays out the graphs of a mechanism: points near their place at the start, bodies around the ground.
    pub fn new(formulated: &mut Formulated) -> Self {
        let places = formulated.equations.system.places();
        let places = pose::positions(formulated, places);
        let equations = &formulated.equations;
        let (system, trees) = (&equations.system, &equations.trees);
        let mut translation = graph(system, &system.translation, &trees.translation, system.coupled_points());
        translation.places = match system.mechanism.dimension {
            Dimension::One => layout::around(&translation),
            Dimension::Two => layout::near(&translation, &places),
        };
        let mut rotation = graph(system, &system.rotation, &trees.rotation, system.coupled_bodies());
        rotation.places = layout::around(&rotation);
        GraphDrawing {
            title: system.mechanism.name.clone(),
            elements: (0..system.elements.len())
                .map(ElementId)
                .filter(|&id| system.has_edges(id))
                .map(|id| (system.element(id).label.clone(), system.name(id).to_owned()))
                .collect(),
            translation,
            rotation: (rotation.nodes.len() > 1).then_some(rotation),
        }
    }

    pub fn svg(&self, drawing: &Drawing) -> String {
        picture::svg(self, Some(drawing))
    }

    /// The two graphs alone.
    pub fn graphs_alone(&self) -> String {
        picture::svg(self, None)
    }

    /// Both graphs as clusters in the language of Graphviz.
    pub fn dot(&self) -> String {
        dot::dot(self)
    }
}

fn graph<D>(system: &System, graph: &LinearGraph<D>, tree: &Tree<D>, coupled: Vec<CoupledEdge<D>>) -> Graph {
    let edge = |(id, ends): (ElementId, [cotree::network::Node<D>; 2])| {
        let element = system.element(id);
        DrawnEdge {
            label: element.label.clone(),
            name: system.name(id).to_owned(),
            ends: ends.map(|node| node.index()),
            branch: tree.branches.contains(&id),
        }
    };
    let term = |edge: CoupledEdge<D>| DrawnEdge {
        name: system.name(edge.element).to_owned(),
        ends: edge.ends.map(|node| node.index()),
        label: edge.label,
        branch: false,
    };
    Graph {
        nodes: graph.node_names().map(str::to_owned).collect(),
        places: Vec::new(),
        edges: graph.edges().map(edge).chain(coupled.into_iter().map(term)).collect(),
    }
}

/// The linear graphs of a scene with their trees, and the mechanism at its start.
///
/// # Errors
/// Everything that is wrong with the scene.
pub fn linear_graphs(scene: &Scene) -> Result<(GraphDrawing, Drawing), Faults> {
    let resolved = scene.resolve()?;
    let mut formulated =
        formulate(&resolved.mechanism, &resolved.outputs).map_err(|errors| resolved.refused(&scene.source, errors))?;
    Ok((GraphDrawing::new(&mut formulated), pose::draw(&mut formulated)))
}
