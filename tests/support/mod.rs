//! What several test files share: an independent formulation in absolute coordinates and random mechanisms for it.
#![allow(dead_code, reason = "each test file uses its own part")]

pub mod absolute;
pub mod cam;
pub mod chain;
pub mod exchange;
pub mod fine;
pub mod hanging;
pub mod hard;
pub mod jet;
pub mod large_scenes;
pub mod linkage;
pub mod loads;
pub mod motion;
pub mod one_freedom;
pub mod one_freedom_with_friction;
pub mod one_sided;
pub mod parts;
pub mod point;
pub mod power;
pub mod random;
pub mod random_parts;
pub mod run;
pub mod scene_text;
pub mod variables;

/// The folder of the whole project.
pub const ROOT: &str = crate::ROOT;
