//! The power balance of a run: what bodies gain in kinetic energy beyond the work of gravity, joints, drivers and loads put in. Forces that the equations of motion leave out, and variables that report other
//! forces than those that act, break it.

use cotree::model::{Dimension, Formula, Mechanism};
use cotree_fmu::instance::Instance;

use super::run::value;

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
        let mut powers = Vec::new();
        for (body, mass, inertia, has_weight) in &self.bodies {
            let mut of = |word: &str| match self.is_line && !word.ends_with('x') {
                true => 0.0,
                false => value(instance, &format!("{body}.{word}")),
            };
            let weight = if *has_weight { self.gravity } else { [0.0; 2] };
            powers.push(-mass * of("vx") * (of("ax") - weight[0]));
            powers.push(-mass * of("vy") * (of("ay") - weight[1]));
            powers.push(-inertia * of("omega") * of("alpha"));
        }
        powers.extend(self.parts.iter().map(|part| value(instance, &format!("{part}.power"))));
        let largest = powers.iter().fold(0.0, |largest: f64, power| largest.max(power.abs()));
        let sum: f64 = powers.iter().sum();
        if largest == 0.0 { 0.0 } else { sum.abs() / largest }
    }
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
