//! Equilibria, linear systems, modes, and the structure of driven mechanisms.

use crate::outside::command as shell;
use crate::support::run;

mod command;
mod driven;
mod equilibrium;
mod feedback;
mod laws;
mod linear;
mod one_sided;
mod slopes;
mod sticking;
mod support;
