//! The linear systems of equations of motion, solved symbolically: elimination, solve trees, blocks of driven mechanisms, reactions of least norm.

mod augment;
mod blocks;
mod eliminate;
pub(crate) mod least_norm;
mod levels;
mod motion;
pub(crate) mod solve_tree;

pub use blocks::{Block, Incidence};
pub(crate) use blocks::{BlockLoops, blocks};
pub use eliminate::{EliminationSystem, Factorisation, Obstacle};
pub use least_norm::Shared;
pub(crate) use levels::{AffineSum, LevelSolution, Levels, solved_sums};
pub(crate) use motion::typical;
pub use motion::{MotionSolver, MotionSystem};
pub use solve_tree::{SolveTree, in_solve_tree};
