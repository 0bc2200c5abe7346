//! Planar mechanisms to FMUs, in branch coordinates.

pub mod cli;
pub mod export;
pub mod files;
pub mod mechanism;
pub mod pipeline;
pub mod report;
pub mod scene;
pub mod simulation;
