//! A scene in motion, and what it is compared with.

use std::sync::Arc;

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use super::run::{sound, value};

/// A scene in motion.
pub struct Run(Instance);

impl Run {
    pub fn new(scene: &Scene) -> Run {
        let compiled = sound(compile(scene));
        assert!(compiled.warnings.is_none(), "{}", compiled.warnings.unwrap().render(false, 100));
        let mut instance = Instance::new(Arc::new(Model::new(compiled.program).unwrap()));
        instance.setup(0.0, None, Some(1e-10)).unwrap();
        instance.initialise().unwrap();
        Run(instance)
    }

    pub fn to(&mut self, time: f64) -> &mut Run {
        if time > self.0.time() {
            self.0.step_to(time).unwrap();
        }
        self
    }

    pub fn get(&mut self, name: &str) -> f64 {
        value(&mut self.0, name)
    }

    pub fn check(&mut self, name: &str, expected: f64) {
        let (value, time) = (self.get(name), self.0.time());
        assert!(
            (value - expected).abs() <= 1e-7 * (1.0 + expected.abs()),
            "{name} at {time} s: {value}, not {expected}"
        );
    }
}
