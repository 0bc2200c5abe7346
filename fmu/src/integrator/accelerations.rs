//! Accelerations and reactions at a state, Eq. (22); where drivers determine the motion they follow from Eqs. (21) and (14).

use crate::constraints::domains::outside;
use crate::failure::Failure;
use crate::machine::Machine;
use crate::model::Model;
use crate::singular::dependence::undetermined;
use crate::taylor::Jet;

/// Storage for accelerations and reactions.
#[derive(Clone, Debug)]
pub struct Accelerations {
    /// a, then lambda.
    values: Vec<f64>,
    coordinates: usize,
    /// Where loop equations repeat others: its factors are of those that are independent in the pose, those of the tape of the same ones in every pose.
    jet: Option<Jet>,
}

impl Accelerations {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let (n, m) = (model.coordinates(), model.program().constraints.len());
        // The series of a driven mechanism know no masses, and so no reactions.
        let form = model.program().arms.as_ref().filter(|_| !model.is_driven());
        let jet = form.filter(|form| form.repeating() > 0 && form.tape.switches.is_empty());
        let jet = jet.map(|form| Jet::of(model, form).without_kernels());
        Self { values: vec![0.0; n + m], coordinates: n, jet }
    }

    /// Evaluates a and lambda at the state in the registers, and leaves them there.
    pub fn evaluate(&mut self, model: &Model, machine: &mut Machine) -> Result<(), Failure> {
        let n = model.coordinates();
        let regular = self.jet.as_mut().is_some_and(|jet| {
            jet.update(machine.registers());
            jet.accelerations(model, machine.registers(), &mut self.values).is_ok()
        });
        if !regular {
            machine.evaluate(&model.program().tapes.acceleration, &mut self.values);
        }
        let (accelerations, reactions) = self.values.split_at(n);
        machine.load_accelerations(model, accelerations);
        machine.load_reactions(model, reactions);
        let time = machine.registers()[model.layout().time()];
        finite(model, time, accelerations)
            .map_err(|failure| outside(model, machine).or_else(|| undetermined(model, machine)).unwrap_or(failure))
    }

    /// Leaves those in the registers that `known` writes; false if it knows none.
    pub fn take(&mut self, model: &Model, machine: &mut Machine, known: impl FnOnce(&mut [f64]) -> bool) -> bool {
        let is_known = known(&mut self.values) && self.values.iter().all(|value| value.is_finite());
        if is_known {
            let (accelerations, reactions) = self.values.split_at(self.coordinates);
            machine.load_accelerations(model, accelerations);
            machine.load_reactions(model, reactions);
        }
        is_known
    }

    /// The accelerations last evaluated, to be changed.
    pub fn accelerations_mut(&mut self) -> &mut [f64] {
        &mut self.values[..self.coordinates]
    }

    /// The accelerations last evaluated.
    pub fn accelerations(&self) -> &[f64] {
        &self.values[..self.coordinates]
    }
}

/// An error that names the first coordinate whose acceleration is not finite.
pub(crate) fn finite(model: &Model, time: f64, accelerations: &[f64]) -> Result<(), Failure> {
    match accelerations.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(Failure::NotFinite { time, coordinate: model.program().coordinates[index].name.clone() }),
    }
}
