//! From equations to the program that the runtime moves.
//!
//! First the kernels of positions and velocities ([`positions`]): with them the mechanism is assembled and its redundant loop
//! equations are found. Then, knowing which equations count, everything ([`program`]).

mod eliminate;
mod indicators;
mod initial;
mod program;
mod table;
mod tape;

pub use eliminate::{Factor, System, Undetermined};
pub use program::{Lowered, Pose, positions, program};
pub use table::{Row, Start, Table};
pub use tape::Assembler;
