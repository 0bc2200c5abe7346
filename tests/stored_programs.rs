//! The programs by which the runtime is tested alone, `fmu/tests/programs`, are what the models compile to.
//!
//! `COTREE_WRITE_EXPECTED=1 cargo test --test library stored_programs::` writes them anew. The motions that they must make stay: `models/*/expected.csv`.

use crate::support::ROOT;
use std::fs;
use std::path::PathBuf;

use cotree::compile::compile;
use cotree::scene::Scene;

use crate::support::run::{models, sound};

#[test]
fn the_stored_programs_are_those_of_the_models() {
    let root = PathBuf::from(ROOT);
    let mut other = Vec::new();
    for model in models() {
        let scene = Scene::read(root.join("models").join(&model).join("scene.toml"));
        let program = sound(scene.and_then(|scene| compile(&scene))).program;
        let bytes = program.to_bytes().expect("a program");
        let path = root.join("fmu/tests/programs").join(&model).with_extension("bin");
        if std::env::var_os("COTREE_WRITE_EXPECTED").is_some() {
            fs::write(&path, &bytes).expect("a file");
        } else if fs::read(&path).ok() != Some(bytes) {
            other.push(model);
        }
    }
    assert!(other.is_empty(), "other programs are stored for {other:?}: see the head of this file");
}
