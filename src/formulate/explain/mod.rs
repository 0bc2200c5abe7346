//! Why a mechanism cannot be assembled or solved, in the words of the scene.

pub mod assembly;
pub mod attempt;
pub mod size;
pub(crate) mod suspect;
