//! Planar mechanisms to FMUs, in branch coordinates.

pub mod export;
