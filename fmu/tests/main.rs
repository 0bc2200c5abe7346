//! One program for all tests of the runtime.

mod counting;
mod support;

mod batch;
mod call_sequences;
mod communication;
mod derivatives;
mod exchange;
mod fmi2;
mod initial;
mod models;
mod motion;
mod no_allocation;
mod program_file;
