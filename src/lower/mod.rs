//! From equations to the program that the runtime moves.
//!
//! First the kernels of positions and velocities ([`positions`]): with them the mechanism is assembled and its redundant loop
//! equations are found. Then, with the independent loop equations known, the whole program (`program`).

mod arms;
mod augment;
mod blocks;
mod cost;
mod dependencies;
mod dependency_sets;
mod domains;
mod eliminate;
mod indicators;
mod initial;
mod least_norm;
mod motion;
mod program;
mod series;
mod solve_tree;
mod steep;
mod table;
mod tape;

pub use blocks::Block;
pub use cost::Cost;
pub(crate) use dependencies::LISTED;
pub use eliminate::{Factor, Obstacle, System};
pub use indicators::motion_indicators;
pub use initial::{Conditions, conditions, order_of};
pub use least_norm::Shared;
pub use motion::{MotionSystem, Solver};
pub use program::{Lowered, Pose, kernel_cost, positions, program};
pub use solve_tree::{SolveTree, in_solve_tree};
pub(crate) use steep::divisor;
pub use table::{Start, Table, TableRow};
pub use tape::{Assembler, symbol_register};
