//! Planar mechanisms to FMUs, in branch coordinates.

pub mod export;
pub mod files;
pub mod mechanism;
pub mod report;
pub mod scene;
