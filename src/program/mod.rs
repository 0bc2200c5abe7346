//! From equations to the program that the runtime moves.
//!
//! First the kernels of positions and velocities ([`positions`]): with them the mechanism is assembled and its redundant loop
//! equations are found. Then, with the independent loop equations known, the whole program (`program`).

mod contacts;
mod dependencies;
mod dependency_sets;
mod initial;
mod instants;
mod kernels;
mod lowered;
mod table;
mod variable;

pub(crate) use contacts::contour;
pub(crate) use dependencies::LISTED;
pub use initial::{Conditions, conditions};
pub use lowered::{Lowered, positions, program};
pub use table::{Of, TableRow, VariableTable};
pub use variable::{Causality, ScalarVariable, StartValue, Type, Variability};
