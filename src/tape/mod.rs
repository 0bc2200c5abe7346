//! From expressions to the straight-line code of the runtime, and what it costs.

mod assembler;
mod cost;

pub use assembler::{Assembler, symbol_register};
pub(crate) use cost::layout;
pub use cost::{Cost, kernel_cost};
