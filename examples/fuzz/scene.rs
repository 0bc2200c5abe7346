//! Damaged scene files: read, resolve, compile, report, draw, move a little.

use crate::ROOT;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use cotree::compile::compile_with_equations;
use cotree::report::figures::summarise;
use cotree::scene::{Faults, Scene};
use cotree_draw::pose::draw;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use crate::Target;
use crate::mutate::{Random, bytes, text};

/// Scenes of the repository, to be damaged.
pub struct Scenes {
    corpus: Vec<String>,
}

impl Scenes {
    pub fn new() -> Self {
        let root = Path::new(ROOT);
        let mut files = Vec::new();
        for folder in ["models", "tests/faults", "tests/scenes", "examples/coupled"] {
            collect(&root.join(folder), &mut files);
        }
        files.sort();
        let corpus = files.into_iter().filter_map(|(_, text)| text).collect();
        Self { corpus }
    }
}

/// Every scene file in a folder and the folders in it, with its text.
fn collect(folder: &Path, files: &mut Vec<(String, Option<String>)>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let is_scene = path.extension().is_some_and(|extension| extension == "toml" || extension == "json");
        if path.is_dir() {
            collect(&path, files);
        } else if is_scene {
            files.push((path.display().to_string(), fs::read_to_string(&path).ok()));
        }
    }
}

impl Target for Scenes {
    fn next(&mut self, random: &mut Random) -> Vec<u8> {
        let mut scene = random.pick(&self.corpus).clone();
        for _ in 0..=random.below(4) {
            let other = random.pick(&self.corpus);
            scene = text(random, &scene, other);
        }
        let mut damaged = scene.into_bytes();
        if random.below(4) == 0 {
            bytes(random, &mut damaged);
        }
        damaged
    }

    fn attempt(&self, input: &[u8]) -> bool {
        let text = String::from_utf8_lossy(input);
        let scene = match text.trim_start().starts_with('{') {
            true => Scene::from_json(&text),
            false => Scene::from_toml(&text),
        };
        let (compiled, mut formulated) = match scene.and_then(|scene| compile_with_equations(&scene)) {
            Ok(made) => made,
            Err(faults) => return tell(&faults),
        };
        let _ = (draw(&mut formulated).svg(), summarise(&formulated).to_string());
        compiled.warnings.as_ref().map(tell);
        let Ok(model) = Model::new(compiled.program) else { panic!("the program of a compiled scene is refused") };
        move_a_little(Arc::new(model));
        true
    }
}

/// Faults can be told in both ways.
fn tell(faults: &Faults) -> bool {
    let _ = (faults.render(false, 100), faults.to_json().to_string());
    false
}

/// Evaluations that a damaged model may spend.
const BUDGET: u64 = 2000;
/// Work of one step in instructions of tapes: a tenth of what a user's step may be.
const WORK: u64 = 500_000_000;

/// A few steps, and every variable; errors are fine. The first steps are tiny, because damaged models can be absurdly fast.
pub fn move_a_little(model: Arc<Model>) {
    let variables = model.program().variables.len();
    let mut instance = Instance::new(model);
    instance.limit_work(WORK);
    let started = instance.setup(0.0, None, None).and_then(|()| instance.initialise());
    if started.is_ok() {
        for halvings in (10..300).rev() {
            if instance.step_to(0.5f64.powi(halvings)).is_err() || instance.statistics().evaluations > BUDGET {
                break;
            }
        }
    }
    for variable in 0..variables {
        let _ = instance.get(variable);
    }
    let _ = instance.save().to_bytes();
}
