//! Whether a scene that was just written moves, and how far: what locks up is said where the linkage is read, not in the middle of its first run.

use crate::compile::compile;
use crate::scene::Scene;

/// What became of the run of a scene.
pub enum Trial {
    Runs,
    /// It has no motion, and why.
    Stays(String),
    /// The time of the last row before its motion ended, and why it ended.
    Ends(f64, String),
}

/// Runs the experiment of a scene.
pub fn of(text: &str) -> Trial {
    let compiled = match Scene::from_toml(text).and_then(|scene| compile(&scene)) {
        Ok(compiled) => compiled,
        Err(faults) => {
            let first = faults.list.first().map(|fault| fault.message.clone()).unwrap_or_default();
            return Trial::Stays(first);
        }
    };
    let mut last = None;
    let ended = compiled.run(|time, _| {
        last = Some(time);
        Ok(())
    });
    match (ended, last) {
        (Ok(_), _) => Trial::Runs,
        (Err(error), Some(time)) if time > 0.0 => Trial::Ends(time, error.to_string()),
        (Err(error), _) => Trial::Stays(error.to_string()),
    }
}
