//! What the importer calls. Pointers are checked here, and nothing else is done here; nothing unwinds into the importer.
//!
//! The caller's part of the contract, which cannot be checked, is the same for all functions: an instance is one that was made here and
//! [`fmi3FreeInstance`] has not yet freed, used by one thread at a time; a state is one that this FMU handed out; arrays are as long as announced;
//! strings end with a zero byte.
#![allow(non_snake_case, non_upper_case_globals, reason = "the names of the standard")]
#![allow(clippy::missing_safety_doc, reason = "the contract is the standard's, in short at the head of this file")]

mod co_simulation;
mod common;
mod model_exchange;
mod no_variables;
mod states;
mod unsupported;
mod values;

pub use co_simulation::*;
pub use common::*;
pub use model_exchange::*;
pub use no_variables::*;
pub use states::*;
pub use unsupported::*;
pub use values::*;
