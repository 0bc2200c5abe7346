//! Planar mechanisms to FMUs, in branch coordinates.
