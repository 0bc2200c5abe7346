//! Planar mechanisms to FMUs, in branch coordinates.

pub mod mechanism;
pub mod scene;
