//! What reaches outside of the test program: other processes, files, Python, the archives and descriptions of FMUs.
#![allow(dead_code, reason = "not every system has every test")]

pub mod archive_rules;
pub mod command;
pub mod fmi3_functions;
pub mod fmu_description;
pub mod fresh;
pub mod process;
pub mod python;
pub mod xml;
