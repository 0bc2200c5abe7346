//! Equilibria, linear systems, modes, and the structure of driven mechanisms.

mod command;
mod driven;
mod equilibrium;
mod linear;
mod slopes;
mod support;

#[path = "../support/run.rs"]
mod run;
#[path = "../support/command.rs"]
mod shell;
