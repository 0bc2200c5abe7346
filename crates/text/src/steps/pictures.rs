//! Pictures of the lesson: the mechanism with its angles and the nodes of its graph, a free body, a circuit.

use std::collections::{BTreeMap, BTreeSet};

use cotree::model::{BodyId, Dimension};
use cotree::network::Origin;
use cotree_draw::drawing::{Drawing, Mark};
use cotree_draw::pose::{draw, frames, position, positions};

use super::{Lesson, words};
use crate::document::DocumentBlock;

/// Of larger mechanisms a circuit could not be followed.
const BODIES: usize = 30;
/// The names of more nodes would cover the mechanism.
const NODES: usize = 60;

impl Lesson<'_> {
    /// The mechanism, with the angles of bodies that are coordinates, and with its nodes.
    pub fn mechanism(&mut self) -> DocumentBlock {
        let mut drawing = draw(self.source);
        if self.is_plane() && self.equations.coordinates.len() <= BODIES {
            let poses = frames(self.source);
            let angle = |coordinate: &cotree::equations::Coordinate| match self
                .equations
                .system
                .element(coordinate.element)
                .origin
            {
                Origin::Body(BodyId(body)) if coordinate.name.position.starts_with("theta_") => {
                    let [x, y, angle] = poses[body];
                    Some(Mark::Angle { at: [x, y], angle, name: coordinate.name.position.replace("theta_", "\u{3b8}") })
                }
                _ => None,
            };
            drawing.marks = self.equations.coordinates.iter().filter_map(angle).collect();
            drawing.marks.extend(self.nodes());
        }
        DocumentBlock::Picture(drawing.svg(), "--drawing")
    }

    /// Where the nodes of the translational graph are, by their names in it.
    fn nodes(&mut self) -> Vec<Mark> {
        let names = self.translation.nodes.clone();
        if names.len() > NODES {
            return Vec::new();
        }
        let places = positions(self.source, self.equations.system.places());
        places.into_iter().zip(names).map(|(at, name)| Mark::Node { at, name }).collect()
    }

    /// The free body of a cutset, by its nodes: a line around each of its bodies.
    pub fn picture_of_cut(&mut self, nodes: &BTreeSet<usize>) -> Option<DocumentBlock> {
        let places = self.equations.system.places();
        let mut bodies: BTreeMap<BodyId, Vec<[f64; 2]>> = BTreeMap::new();
        for place in nodes.iter().map(|node| places[*node]) {
            if let Some(body) = place.body() {
                bodies.entry(body).or_default().push(position(self.source, place));
            }
        }
        self.marked(bodies.into_values().map(Mark::Cut).collect())
    }

    /// The circuit of the first loop equation.
    pub fn picture_of_circuit(&mut self) -> Vec<DocumentBlock> {
        let Some(element) = self.equations.loops().next().map(|(_, constraint)| constraint.element) else {
            return Vec::new();
        };
        let Some(circuit) = self.translation.record.circuit(element) else { return Vec::new() };
        let (label, walk) = (self.translation.record.edge_of(circuit).label.clone(), self.translation.walk(circuit));
        let places = self.equations.system.places();
        let corners = positions(self.source, walk.into_iter().map(|node| places[node]));
        let picture = self.marked(vec![Mark::Circuit(corners)]);
        picture.map_or_else(Vec::new, |picture| {
            vec![words(format!("The circuit of {label}, along the tree and back by {label} itself:")), picture]
        })
    }

    fn marked(&mut self, marks: Vec<Mark>) -> Option<DocumentBlock> {
        if marks.is_empty() || !self.is_plane() || self.equations.system.mechanism.bodies.len() > BODIES {
            return None;
        }
        let drawing = Drawing { marks, ..draw(self.source) };
        Some(DocumentBlock::Picture(drawing.svg(), ""))
    }

    fn is_plane(&self) -> bool {
        self.equations.system.mechanism.dimension == Dimension::Two
    }
}
