//! The power balance of every family: what bodies gain in kinetic energy is what weights, joints, drivers and loads give. It shares nothing with the equations of motion but the variables that programs report.

use cotree::scene::Scene;

use crate::support::power::largest_gap;
use crate::support::random_parts::random_parts;
use crate::support::run::{models, scene_of, sound};

#[path = "../tools/constants/modes.rs"]
mod modes;

/// How far a balance may be open, as a share of the largest power: rates obey the loop equations to a share of the tolerance, and reactions do so much work.
const OPEN: f64 = 1e-7;
/// Where a run is looked at.
const PLACES: u32 = 23;

/// The balances that are open, and how many there are.
fn open(scenes: impl Iterator<Item = (String, Scene, f64)>) -> (Vec<String>, usize) {
    let (mut open, mut count) = (Vec::new(), 0);
    for (name, scene, stop) in scenes {
        let Some(gap) = largest_gap(&scene, stop, PLACES) else { continue };
        count += 1;
        if gap.is_nan() || gap > OPEN {
            open.push(format!("{name}: {gap:e}"));
        }
    }
    (open, count)
}

#[test]
fn powers_of_all_models_balance() {
    let scenes = models().into_iter().map(|name| {
        let scene = sound(Scene::from_toml(&scene_of(&name)));
        let stop = sound(cotree::compile::compile(&scene)).description.experiment.stop;
        (name, scene, stop.min(2.0))
    });
    let (open, count) = open(scenes);
    assert!(open.is_empty() && count >= 50, "{count} models\n{}", open.join("\n"));
}

#[test]
fn powers_of_scenes_with_modes_balance() {
    let scenes = modes::scenes().into_iter().map(|(scene, stop)| (scene.name.text.clone(), scene, stop));
    let (open, count) = open(scenes);
    assert!(open.is_empty() && count > 40, "{count} scenes\n{}", open.join("\n"));
}

#[test]
fn powers_of_random_parts_balance() {
    let scenes = (0..40).map(|seed| {
        let text = random_parts(seed, 4).scene;
        (format!("parts {seed}"), sound(Scene::from_toml(&text)), 0.2)
    });
    let (open, count) = open(scenes);
    assert!(open.is_empty() && count > 20, "{count} scenes\n{}", open.join("\n"));
}
