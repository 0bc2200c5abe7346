//! Accelerations and loads of a driven mechanism in a singular pose and beside it: their limits along the motion.
//!
//! Drivers lead the motion through the pose on one branch, and what a driver must do there is determined; but the equations of the pose alone do not tell it, and beside the
//! pose they amplify rounding errors. So values are found from those before and after, by polynomials through places at which the equations determine them. Several
//! polynomials, none of which shares a place with the next one, must agree; what grows without bound, and what the motion does not determine, has no value.

use crate::constraints::reciprocals::is_within;
use crate::integrator::stepping::Stepper;
use crate::machine::Machine;
use crate::math::maximum;
use crate::model::{Model, State};
use crate::motion::Run;
use crate::program::Source;
use crate::singular::detect::dependent;

/// Loop equations this close to depending on each other, as a share of the lever, amplify rounding errors in accelerations and loads, by up to the fourth power of that: at a tenth of it more than 1e-7 is lost.
const BESIDE: f64 = 3e-2;
/// Places of a polynomial.
const POLYNOMIAL_PLACES: usize = 8;
/// The places of the next polynomial lie this much closer to each other.
const CLOSER: f64 = 0.7;
/// Polynomials: the last ones lie within a hundredth of a step.
const ROUNDS: usize = 14;
/// Three polynomials in a row must agree to this, relative to the value and to what it is before and after.
const AGREE: f64 = 1e-8;
/// What is as good as zero beside the largest of all accelerations and loads.
const ZERO_LOAD: f64 = 1e-10;

/// Storage for limits.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    state: State,
    /// Which results of the outputs need accelerations or reactions.
    accelerated: Vec<usize>,
    /// Results of the acceleration tape, and of the output tape, at one place.
    solved: Vec<f64>,
    outputs: Vec<f64>,
    /// Accelerations, then outputs that need them: what polynomials give, the last one first.
    found: [Vec<f64>; 3],
    limits: Vec<Limit>,
    /// Is the state far enough from a singular pose for what polynomials do not agree on to be as the equations have it?
    determined: bool,
}

/// What is known of a limit.
#[derive(Clone, Copy, Debug)]
struct Limit {
    value: f64,
    /// By how much polynomials disagree.
    error: f64,
    /// How large the value is before and after.
    size: f64,
}

/// How close to a singular pose the accelerations in the registers were evaluated.
pub(crate) fn is_beside_pose(model: &Model, machine: &Machine) -> bool {
    let (pivots, share) = (&model.program().tapes.reciprocal_pivots, BESIDE * model.lever());
    let mut pivots = pivots.iter().map(|&place| machine.registers()[place as usize]);
    model.is_driven() && pivots.any(|pivot| !pivot.is_finite() || is_within(pivot, share))
}

impl Limits {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let accelerated = |source| match source {
            Source::Output { result, accelerated: true } => Some(result as usize),
            Source::Output { accelerated: false, .. }
            | Source::Time
            | Source::Parameter(_)
            | Source::Input(_)
            | Source::Discrete(_)
            | Source::Coordinate(_)
            | Source::Rate(_)
            | Source::Acceleration(_) => None,
        };
        let accelerated: Vec<usize> =
            model.program().variables.iter().filter_map(|variable| accelerated(variable.source)).collect();
        let tapes = &model.program().tapes;
        let count = model.coordinates() + accelerated.len();
        Self {
            state: model.default_state(0.0),
            solved: vec![0.0; tapes.acceleration.results.len()],
            outputs: vec![0.0; tapes.outputs.results.len()],
            found: [(); 3].map(|()| vec![f64::NAN; count]),
            limits: vec![Limit { value: f64::NAN, error: f64::INFINITY, size: 0.0 }; count],
            accelerated,
            determined: false,
        }
    }

    /// Finds the limits at the time of a state, along the last step of a run. False if the equations are all that is known, and determine everything.
    pub fn find(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        stepper: &mut Stepper,
        (run, state): (Option<&Run>, &State),
    ) -> bool {
        self.limits.fill(Limit { value: f64::NAN, error: f64::INFINITY, size: 0.0 });
        let time = state.time();
        let known = |run: &&Run| run.last.order > 0 && (run.last.start_time..=run.last.end_time).contains(&time);
        if let Some(run) = run.filter(known) {
            let [from, to] = [run.last.start_time, run.last.end_time];
            self.state.copy_from(state);
            self.found.iter_mut().for_each(|found| found.fill(f64::NAN));
            let longest = (to - from) / (POLYNOMIAL_PLACES + 1) as f64;
            for round in 0..ROUNDS {
                let spacing = longest * CLOSER.powi(round as i32);
                let fit = |room: f64| (room / spacing + 0.5).floor() as usize;
                // Not always alike on both sides: what grows without bound with opposite signs would cancel.
                let behind = (POLYNOMIAL_PLACES / 2 - round % 2)
                    .min(fit(time - from))
                    .max(POLYNOMIAL_PLACES.saturating_sub(fit(to - time)));
                self.found.rotate_right(1);
                self.found[0].fill(0.0);
                for (place, weight) in weights(behind) {
                    self.sample(model, machine, stepper, (run, time + place * spacing));
                    self.add(model.coordinates(), weight, round == 0);
                }
                self.compare();
            }
            self.judge();
        }
        let open = self.limits.iter().any(|limit| limit.value.is_nan());
        // Without a motion along which limits are found more is lost than is permitted.
        self.determined = open && dependent(model, state).0 >= 0.1 * BESIDE;
        !self.determined || self.limits.iter().any(|limit| !limit.value.is_nan())
    }

    /// Evaluates all at a time.
    fn sample(&mut self, model: &Model, machine: &mut Machine, stepper: &mut Stepper, (run, time): (&Run, f64)) {
        self.state.set_time(time);
        stepper.catch_up(model, machine, &mut self.state, run);
        machine.load(model, &self.state);
        machine.evaluate(&model.program().tapes.acceleration, &mut self.solved);
        let (accelerations, reactions) = self.solved.split_at(model.coordinates());
        machine.load_accelerations(model, accelerations);
        machine.load_reactions(model, reactions);
        machine.evaluate(&model.program().tapes.outputs, &mut self.outputs);
    }

    fn add(&mut self, coordinates: usize, weight: f64, sizes: bool) {
        let Self { accelerated, solved, outputs, found: [found, ..], limits, .. } = self;
        let values = solved[..coordinates].iter().copied().chain(accelerated.iter().map(|&result| outputs[result]));
        for ((sum, limit), value) in found.iter_mut().zip(limits).zip(values) {
            *sum += weight * value;
            // The smallest: one place may lie in the pose.
            if sizes {
                limit.size = if limit.size == 0.0 { value.abs() } else { limit.size.min(value.abs()) };
            }
        }
    }

    /// Keeps what the last three polynomials agree on best.
    fn compare(&mut self) {
        let [last, middle, first] = &self.found;
        for (((limit, last), middle), first) in self.limits.iter_mut().zip(last).zip(middle).zip(first) {
            let error = maximum((last - middle).abs(), (middle - first).abs());
            if error < limit.error {
                (limit.value, limit.error) = (*middle, error);
            }
        }
    }

    /// Takes away what polynomials do not agree on.
    fn judge(&mut self) {
        let sizes = self.limits.iter().map(|limit| limit.size).filter(|size| size.is_finite());
        let largest = sizes.fold(0.0, maximum);
        for limit in &mut self.limits {
            let size = maximum(limit.size, limit.value.abs());
            let agrees = limit.error <= AGREE * size + ZERO_LOAD * largest;
            if !agrees {
                limit.value = f64::NAN;
            }
        }
    }

    /// Puts limits in the place of accelerations, and what is no number where the pose does not determine one.
    pub fn replace(&self, accelerations: &mut [f64]) {
        let coordinates = accelerations.len();
        accelerations.iter_mut().zip(&self.limits[..coordinates]).for_each(|(value, limit)| self.put(limit, value));
    }

    /// The same for outputs that need accelerations or reactions.
    pub fn replace_outputs(&self, outputs: &mut [f64]) {
        let limits = &self.limits[self.limits.len() - self.accelerated.len()..];
        self.accelerated.iter().zip(limits).for_each(|(&result, limit)| self.put(limit, &mut outputs[result]));
    }

    fn put(&self, limit: &Limit, value: &mut f64) {
        if !(limit.value.is_nan() && self.determined) {
            *value = limit.value;
        }
    }
}

/// The places of a polynomial, as many behind as that and the others ahead, in units of their distance, and the weight of each for the value in between.
fn weights(behind: usize) -> [(f64, f64); POLYNOMIAL_PLACES] {
    let place = |index: usize| index as f64 + 0.5 - behind as f64;
    std::array::from_fn(|index| {
        let others = (0..POLYNOMIAL_PLACES).filter(|&other| other != index);
        (place(index), others.map(|other| place(other) / (place(other) - place(index))).product())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_as_many_places_is_found_exactly() {
        for behind in 0..=POLYNOMIAL_PLACES {
            let polynomial = |x: f64| 3.0 + x * (2.0 - x * (0.5 + 0.01 * x.powi(5)));
            let value: f64 = weights(behind).iter().map(|(place, weight)| weight * polynomial(*place)).sum();
            assert!((value - 3.0).abs() < 1e-7, "{behind}: {value}");
        }
    }
}
