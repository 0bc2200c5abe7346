//! Planar mechanisms to FMUs, in branch coordinates.

pub mod element;
pub mod equations;
pub mod expr;
pub mod formulate;
pub mod graph;
pub mod lower;
pub mod mechanism;
pub mod print;
pub mod scene;
pub mod translate;
pub mod tree;
