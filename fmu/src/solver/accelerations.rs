//! Accelerations and reactions at a state: Eq. (22) for dynamic motion, Eqs. (21) and (14) for kinematic motion.

use super::Failure;
use super::loops::Loops;
use crate::machine::Machine;
use crate::model::Model;
use crate::program::Motion;

/// Storage for accelerations and reactions.
#[derive(Clone, Debug)]
pub struct Accelerations {
    /// a, then lambda.
    values: Vec<f64>,
    gamma: Vec<f64>,
    loops: Option<Loops>,
}

impl Accelerations {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let (n, m) = (model.coordinates(), model.program().constraints.len());
        let loops = (model.program().motion == Motion::Kinematic).then(|| Loops::new(model));
        Self { values: vec![0.0; n + m], gamma: vec![0.0; m], loops }
    }

    /// Evaluates a and lambda at the state in the registers, and leaves them there.
    pub fn evaluate(&mut self, model: &Model, machine: &mut Machine) -> Result<(), Failure> {
        let n = model.coordinates();
        match &mut self.loops {
            None => machine.evaluate(&model.program().tapes.acceleration, &mut self.values),
            Some(loops) => {
                let tapes = &model.program().tapes;
                let regular = loops.factor(model, machine).is_ok();
                machine.evaluate(&tapes.gamma, &mut self.gamma);
                let (accelerations, reactions) = self.values.split_at_mut(n);
                if regular {
                    accelerations.copy_from_slice(loops.solve(model, &self.gamma));
                } else {
                    accelerations.fill(f64::NAN);
                }
                reactions.fill(0.0);
                machine.load_accelerations(model, accelerations, reactions);
                if let (Some(inverse), true) = (&tapes.inverse, regular) {
                    machine.evaluate(inverse, &mut self.gamma[..n]);
                    loops.reactions(model, &self.gamma[..n], reactions);
                }
            }
        }
        let (accelerations, reactions) = self.values.split_at(n);
        machine.load_accelerations(model, accelerations, reactions);
        finite(model, machine, accelerations)
    }

    /// The accelerations last evaluated.
    pub fn accelerations(&self) -> &[f64] {
        &self.values[..self.values.len() - self.gamma.len()]
    }
}

/// An error that names the first coordinate whose acceleration is not finite.
pub(crate) fn finite(model: &Model, machine: &Machine, accelerations: &[f64]) -> Result<(), Failure> {
    match accelerations.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(Failure::NotFinite {
            time: machine.registers()[model.layout().time()],
            coordinate: model.program().coordinates[index].name.clone(),
        }),
    }
}
