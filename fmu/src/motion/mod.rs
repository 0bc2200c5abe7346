//! What is known of a run, as plain data, which every method continues.
//!
//! * `signals`: where parameters and inputs continue from.
//! * `last_step`: the ends of the last step, and the polynomial between them.
//! * `poses`, `passage`, `trail`: singular poses ahead and behind, and the states about them.
//! * `run`: all of it.

pub(crate) mod last_step;
pub(crate) mod passage;
pub(crate) mod poses;
pub(crate) mod run;
pub(crate) mod signals;
pub(crate) mod trail;

pub use passage::Passage;
pub use run::Run;
