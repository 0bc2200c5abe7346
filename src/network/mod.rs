//! The two linear graphs of a mechanism: elements with their terminal equations, the edges that they are, and the spanning trees.
//!
//! Nodes of the translational graph are points, those of the rotational graph bodies (McPhee 1998, section 2).

mod arm;
mod body;
mod coupled;
pub(crate) mod course;
mod element;
mod graph;
mod implied;
mod resistance;
mod system;
mod topology;
mod trees;

pub use coupled::CoupledEdge;
pub use element::*;
pub use graph::{ElementId, LinearGraph, Node, RNode, Rotation, TNode, Translation, Tree};
pub use implied::{Implied, ImpliedMeasure};
pub use resistance::Resistance;
pub use system::System;
pub use topology::{OutwardNode, SignedRow, Topology};
pub use trees::Trees;
