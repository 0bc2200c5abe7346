//! Planar mechanisms to FMUs, in branch coordinates.

pub mod assembly;
pub mod cli;
pub mod element;
pub mod equations;
pub mod export;
pub mod expr;
pub mod files;
pub mod formulate;
pub mod graph;
pub mod lower;
pub mod mechanism;
pub mod pipeline;
pub mod print;
pub mod report;
pub mod scene;
pub mod simulation;
pub mod size;
pub mod translate;
pub mod tree;
