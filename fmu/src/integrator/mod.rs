//! From a consistent initial state to the state at any later time.
//!
//! * [`stepping`]: from one communication point to the next.
//! * `taylor`, `dynamic` with [`explicit`] and `dop853`, `implicit` with `radau`: the methods.
//! * `control`: bounds of the length of a step; `stiffness`: which method takes the next step.
//! * `continuation`: what a run remembers between steps.

pub(crate) mod abreast;
pub(crate) mod continuation;
pub(crate) mod control;
pub(crate) mod dop853;
pub(crate) mod dynamic;
pub(crate) mod each_stage;
pub mod explicit;
pub(crate) mod implicit;
pub(crate) mod radau;
pub mod stepping;
pub(crate) mod stiffness;
pub(crate) mod taylor;
