//! Damaged programs: whatever passes the check must run without a panic.

use crate::ROOT;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::model::Model;
use cotree_fmu::program::Program;

use crate::Target;
use crate::mutate::{Random, bytes};
use crate::scene::move_a_little;

/// Programs of the repository's models, to be damaged.
pub struct Programs {
    corpus: Vec<Vec<u8>>,
}

impl Programs {
    pub fn new() -> Self {
        let models = Path::new(ROOT).join("models");
        let mut folders: Vec<_> =
            fs::read_dir(models).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
        folders.sort();
        let scenes = folders.iter().map(|folder| folder.join("scene.toml")).filter(|path| path.exists());
        let programs = scenes.filter_map(|path| compile(&Scene::read(&path).ok()?).ok());
        let corpus = programs.filter_map(|compiled| postcard::to_allocvec(&compiled.program).ok()).collect();
        Self { corpus }
    }
}

impl Target for Programs {
    /// Only what can be decoded is of interest: a seal with a checksum keeps the rest out.
    fn next(&mut self, random: &mut Random) -> Vec<u8> {
        loop {
            let mut program = random.pick(&self.corpus).clone();
            for _ in 0..=random.below(3) {
                bytes(random, &mut program);
            }
            if postcard::from_bytes::<Program>(&program).is_ok() {
                return program;
            }
        }
    }

    fn attempt(&self, input: &[u8]) -> bool {
        let Ok(program) = postcard::from_bytes::<Program>(input) else { return false };
        let Ok(sealed) = program.to_bytes() else { return false };
        let Ok(read) = Program::from_bytes(&sealed) else { return false };
        let Ok(model) = Model::new(read) else { return false };
        move_a_little(Arc::new(model));
        true
    }
}
