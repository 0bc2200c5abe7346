//! The power balance of a run: what bodies gain in kinetic energy beyond the work of gravity, joints, drivers and loads put in. Forces that the equations of motion leave out, and variables that report other
//! forces than those that act, break it.

use std::sync::Arc;

use cotree::compile::compile_asking;
use cotree::model::{Dimension, Formula, Mechanism};
use cotree::scene::{Requested, Scene};
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;

use super::run::value;

/// Powers are compared with those at this speed at least [m/s, rad/s]: what is at rest moves by rounding errors.
const SLOW: f64 = 1e-5;
/// And with the largest of the run times this.
const AT_REST: f64 = 1e-6;

/// The variables of a mechanism from which its power balance is made, and its constants.
pub struct PowerBalance {
    /// Name, mass, inertia, and whether gravity acts.
    bodies: Vec<(String, f64, f64, bool)>,
    /// Joints, drivers and loads.
    parts: Vec<String>,
    gravity: [f64; 2],
    is_line: bool,
}

impl PowerBalance {
    pub fn new(mechanism: &Mechanism) -> Self {
        let number = |formula: &Formula| constant(mechanism, formula);
        let of = |formula: &Option<Formula>| formula.as_ref().map_or(0.0, number);
        let bodies = mechanism.bodies.iter();
        let bodies = bodies.map(|body| (body.name.clone(), of(&body.mass), of(&body.inertia), !body.weightless));
        let parts = mechanism.joints.iter().chain(&mechanism.drivers).chain(&mechanism.loads);
        Self {
            bodies: bodies.collect(),
            parts: parts.map(|part| part.name.clone()).collect(),
            gravity: mechanism.gravity.each_ref().map(number),
            is_line: mechanism.dimension == Dimension::One,
        }
    }

    /// The variables that a program must have for it.
    pub fn names(&self) -> Vec<String> {
        let motion: &[&str] = if self.is_line { &["vx", "ax"] } else { &["vx", "vy", "omega", "ax", "ay", "alpha"] };
        let motions = self.bodies.iter().flat_map(|(body, ..)| motion.iter().map(move |word| format!("{body}.{word}")));
        motions.chain(self.parts.iter().map(|part| format!("{part}.power"))).collect()
    }

    /// How far the balance is open at the present time, as a share of the largest power \[1\].
    pub fn gap(&self, instance: &mut Instance) -> f64 {
        let [sum, largest] = self.powers(instance);
        if largest == 0.0 { 0.0 } else { sum / largest }
    }

    /// The size of the sum of all powers at the present time, which is to be zero, and what it is compared with \[W\].
    fn powers(&self, instance: &mut Instance) -> [f64; 2] {
        let (mut powers, mut least) = (Vec::new(), 0.0_f64);
        for (body, mass, inertia, has_weight) in &self.bodies {
            let mut of = |word: &str| match self.is_line && !word.ends_with('x') {
                true => 0.0,
                false => value(instance, &format!("{body}.{word}")),
            };
            let weight = if *has_weight { self.gravity } else { [0.0; 2] };
            powers.push(-mass * of("vx") * (of("ax") - weight[0]));
            powers.push(-mass * of("vy") * (of("ay") - weight[1]));
            powers.push(-inertia * of("omega") * of("alpha"));
            least = least.max(mass * weight[0].hypot(weight[1])).max(mass * of("ax").hypot(of("ay")));
        }
        powers.extend(self.parts.iter().map(|part| value(instance, &format!("{part}.power"))));
        let largest = powers.iter().fold(SLOW * least, |largest: f64, power| largest.max(power.abs()));
        let sum: f64 = powers.iter().sum();
        [sum.abs(), largest]
    }
}

/// How far the balance of a run is open at the worst of so many places, as a share of the largest power there \[1\]; none where the scene is refused, as without masses, or its run.
pub fn largest_gap(scene: &Scene, stop: f64, places: u32) -> Option<f64> {
    let balance = PowerBalance::new(&scene.resolve().ok()?.mechanism);
    let (compiled, _) = compile_asking(scene, &Requested::Also(balance.names())).ok()?;
    let begin = compiled.program.experiment.start;
    let mut instance = Instance::new(Arc::new(Model::new(compiled.program).expect("a sound program")));
    instance.setup(begin, Some(stop), None).ok()?;
    instance.initialise().ok()?;
    let mut all = Vec::new();
    for place in 1..=places {
        instance.step_to(begin + (stop - begin) * f64::from(place) / f64::from(places)).ok()?;
        all.push(balance.powers(&mut instance));
    }
    let largest = all.iter().fold(0.0, |largest: f64, powers| largest.max(powers[1]));
    let gaps = all.iter().map(|[sum, own]| if largest == 0.0 { 0.0 } else { sum / own.max(AT_REST * largest) });
    Some(gaps.fold(0.0, |most: f64, gap| if gap <= most { most } else { gap }))
}

/// The value of a formula of numbers and parameters.
fn constant(mechanism: &Mechanism, formula: &Formula) -> f64 {
    match formula {
        Formula::Number(value) => *value,
        Formula::Parameter(id) => mechanism.parameters[id.0].value,
        Formula::Call(function, arguments) => {
            let values: Vec<f64> = arguments.iter().map(|argument| constant(mechanism, argument)).collect();
            function.value(&values)
        }
        other => panic!("{other:?} is not a constant"),
    }
}
