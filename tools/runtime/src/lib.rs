//! The runtime as a shared library: the FMI functions of `cotree-fmu`, exported.

pub use cotree_fmu::*;
