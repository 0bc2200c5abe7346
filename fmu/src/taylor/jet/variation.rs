//! The series of one motion and of its derivatives by parameters: the same operations in dual numbers, so that the variational equations need no equations of
//! their own (Barrio, *SIAM J. Sci. Comput.* 27(6), 2006).

use super::start::flattened;
use super::{Coefficient, Jet, vectors};
use crate::events::{Layers, half_width};
use crate::linalg::dual::Dual;
use crate::linalg::lane::{Lane, WIDTH, by_width};
use crate::linalg::number::Number;
use crate::linalg::tree::Recursion;
use crate::linalg::varied::{VariedEntries, VariedMatrix};
use crate::math;
use crate::model::Model;
use crate::program::Steep;
use crate::program::arm_form::{ArmForm, Given, ORDERS};
use crate::taylor::tape::polynomial;

/// So many directions at once, at most.
pub(crate) const VARIED_DIRECTIONS: usize = 8;
/// Share of the step that the last coefficients permit: the terms after the last one count too.
pub(crate) const SERIES_SAFETY: f64 = 0.9;
/// So many last coefficients count: some vanish by symmetry.
const LAST: usize = 4;
/// A step is made that much shorter, so often.
const VARIATION_CUT: f64 = 0.7;
const MOST_CUTS: usize = 60;
/// What derivatives may be wrong by, as a multiple of what values may: their coefficients are larger by about their order, and they do not choose the step unless they
/// must, so that derivatives by one parameter do not depend on what else is asked for.
const LOOSER: f64 = 1e3;

/// The tangents of a register file along four directions, and along four more.
pub(crate) type Tangents = [Vec<Lane>; VARIED_DIRECTIONS / WIDTH];

/// The series of a motion along some directions.
pub(crate) trait Variations: std::fmt::Debug {
    /// Takes the coefficients over from the registers after the parameter stage ran.
    fn enter(&mut self, registers: &[f64], tangents: &Tangents);

    /// The series at the signals, q and v in the registers up to an order, if it has one there. Loops are closed first, and those of the derivatives with them. Tangents have reached
    /// so much along each direction.
    fn begin(&mut self, model: &Model, order: usize, registers: &[f64], tangents: &Tangents, reached: &[f64]) -> bool;

    /// The step that a tolerance on rates permits if the coefficients shrink as the last ones do (Jorba and Zou, 2005). The values choose it; it is shorter where
    /// derivatives, relative to the largest of their direction, demand that, or a law may be steep within it; zero if they demand too much.
    fn step_length(&mut self, order: usize, tolerance: f64, limit: f64) -> f64;

    /// The difference between the second derivatives where the series before has been continued to, so long after its start, and those with which this one begins, as a
    /// share of the rates that count: in the motion, and in its derivatives as a share of what they may be wrong by.
    fn defect(&self, order: usize, dt: f64) -> f64;

    /// Hands over the tangent of q, v along each direction so long after the start of the series: (place, direction, tangent).
    fn continued(&mut self, order: usize, dt: f64, report: &mut dyn FnMut(usize, usize, f64));
}

/// Storage for as many directions as are needed; none if the laws of the model have no such series.
pub(crate) fn variations(model: &Model, directions: usize) -> Option<Box<dyn Variations>> {
    let form = model.program().arms.as_ref().filter(|form| is_gentle(form))?;
    Some(match directions {
        ..=4 => Box::new(VariedMotion::<4>::new(model, form)),
        _ => Box::new(VariedMotion::<VARIED_DIRECTIONS>::new(model, form)),
    })
}

/// Are all laws analytic, and is there no friction that depends on reactions?
fn is_gentle(form: &ArmForm) -> bool {
    let has_friction = form.contacts.iter().any(|contact| contact.friction.is_some());
    form.tape.switches.is_empty() && !has_friction
}

impl<const D: usize> Coefficient for Dual<D> {
    type Matrix = VariedMatrix<D>;
}

/// A motion with its derivatives.
#[derive(Debug)]
struct VariedMotion<const D: usize> {
    series: Jet<Dual<D>, 1>,
    /// (q, v)
    state: Vec<Dual<D>>,
    /// What tangents have reached along each direction: they are wrong relative to that, as coordinates are relative to their scales.
    reached: [f64; D],
    /// Exponentials and what saturates: where they are steep within a step its end need not tell.
    layers: Layers,
}

impl<const D: usize> VariedMotion<D> {
    fn new(model: &Model, form: &ArmForm) -> Self {
        let state = vec![Dual::ZERO; 2 * model.coordinates()];
        let laws = form.tape.steep_laws().into_iter().filter(|(kind, _)| *kind != Steep::Vanishing);
        let layers = Layers::new(laws.collect());
        Self { series: Jet::with_storage(model, form), state, reached: [0.0; D], layers }
    }

    fn load(&mut self, model: &Model, order: usize, registers: &[f64], tangents: &Tangents) {
        let layout = model.layout();
        for (place, register) in self.state.iter_mut().zip(layout.positions()..) {
            *place = Dual::new(registers[register], along(tangents, register));
        }
        self.series.scalars.begin(order, |given| {
            let mut series = polynomial(model, registers, given).map(Dual::all);
            if let Given::Input(index, 0) = given {
                for (place, first) in series.iter_mut().zip([layout.inputs(), layout.input_rates()]) {
                    *place = Dual::new(place.value(), along(tangents, first + index as usize));
                }
            }
            series
        });
    }
}

impl<const D: usize> Jet<Dual<D>, 1> {
    /// Storage for the matrix. It allocates: once for a motion, for the parameters stay as they are.
    fn lay_out(&mut self) {
        let (layout, limbs) = self.wanted_layout();
        if self.layout != Some(layout) {
            self.layout = Some(layout);
            self.matrix = if layout.chained {
                VariedMatrix::Chained(Recursion::new(&limbs))
            } else {
                let values = |targets, room| self.matrix_for(layout, targets, room);
                let entries = VariedEntries::new(self.targets().0, self.terms.entries(), values);
                self.terms.aim(|row, column| entries.places(row, column));
                VariedMatrix::Entries(Box::new(entries))
            };
        }
        if let VariedMatrix::Chained(recursion) = &mut self.matrix {
            recursion.renew(&limbs);
        }
    }

    /// Builds the matrix of the pose and makes it ready. False if it is singular.
    #[inline(always)]
    fn factor(&mut self) -> bool {
        self.differentiate();
        let derivatives = flattened(&self.derivatives);
        match &mut self.matrix {
            VariedMatrix::Entries(entries) => {
                entries.clear();
                self.terms.assemble(&mut **entries, &self.coefficients, derivatives);
                entries.factor(self.layout.is_some_and(|layout| layout.alike))
            }
            VariedMatrix::Chained(recursion) => recursion.factor(derivatives),
        }
    }
}

/// The tangents of a register.
fn along<const D: usize>(tangents: &Tangents, register: usize) -> [f64; D] {
    std::array::from_fn(|i| tangents[i / WIDTH][register][i % WIDTH])
}

impl<const D: usize> Variations for VariedMotion<D> {
    fn enter(&mut self, registers: &[f64], tangents: &Tangents) {
        let Jet { form, coefficients, .. } = &mut self.series;
        for (place, &register) in coefficients.iter_mut().zip(&form.coefficients.results) {
            let register = register as usize;
            *place = Dual::new(registers[register], along(tangents, register));
        }
        self.series.fill();
        self.series.lay_out();
    }

    fn begin(&mut self, model: &Model, order: usize, registers: &[f64], tangents: &Tangents, reached: &[f64]) -> bool {
        self.reached = std::array::from_fn(|direction| reached.get(direction).copied().unwrap_or(0.0));
        self.load(model, order, registers, tangents);
        let is_finite = self.expand(order);
        if is_finite && !self.layers.is_empty() {
            self.follow_laws(order);
        }
        is_finite
    }

    fn step_length(&mut self, order: usize, tolerance: f64, limit: f64) -> f64 {
        let length = self.natural_length(order, tolerance, limit);
        if self.layers.is_empty() { length } else { self.gentle_length(length, tolerance) }
    }

    fn defect(&self, order: usize, dt: f64) -> f64 {
        self.defect_any(order, dt)
    }

    fn continued(&mut self, order: usize, dt: f64, report: &mut dyn FnMut(usize, usize, f64)) {
        self.evaluate(order, dt);
        for (index, dual) in self.state.iter().enumerate() {
            dual.tangents().iter().enumerate().for_each(|(direction, tangent)| report(index, direction, *tangent));
        }
    }
}

impl<const D: usize> VariedMotion<D> {
    /// Takes the arguments of laws that may be steep along the series over.
    fn follow_laws(&mut self, order: usize) {
        let Self { series, layers, .. } = self;
        if !series.scalars.is_steady() {
            // The accelerations do not need the last order of what depends on rates.
            let stride = series.shape.all();
            series.scalars.rates(order - 1, vectors(&series.x, &series.y, &series.values, stride));
        }
        layers.take(order - 1, |slot, place| {
            place.iter_mut().zip(series.scalars.series(slot)).for_each(|(target, dual)| *target = dual.value());
        });
    }

    /// As much of a step as no law can be steep in without its ends telling.
    fn gentle_length(&mut self, length: f64, tolerance: f64) -> f64 {
        let mut length = math::minimum(length, self.layers.first_cut(length, half_width(tolerance)));
        for _ in 0..MOST_CUTS {
            if self.layers.suspect((0, 0.0), length).is_none() {
                return length;
            }
            length *= VARIATION_CUT;
        }
        0.0
    }

    by_width! {
        fn natural_length[const D: usize](&self: VariedMotion<D>, order: usize, tolerance: f64, limit: f64) -> f64 = natural_length_any
    }

    by_width! {
        fn expand[const D: usize](&mut self: VariedMotion<D>, order: usize) -> bool = expand_any
    }

    by_width! {
        fn evaluate[const D: usize](&mut self: VariedMotion<D>, order: usize, dt: f64) = evaluate_any
    }

    /// All orders. Are they finite?
    #[inline(always)]
    fn expand_any(&mut self, order: usize) -> bool {
        let Self { series, state, .. } = self;
        let (positions, rates) = state.split_at(state.len() / 2);
        series.load(0, positions);
        series.turn();
        if !series.factor() {
            return false;
        }
        // Always: the derivatives may be open where the values are not.
        series.put_on_loops(rates, -1.0);
        series.weigh();
        // No closure around the orders: it would be compiled for any processor.
        series.follow(0);
        series.follow(1);
        for k in 0..order - 1 {
            series.advance_general(k);
        }
        let all = series.values[..(order + 1) * series.shape.all()].as_flattened().iter();
        all.copied()
            .all(|value| value.value().is_finite() && value.tangents().iter().all(|tangent| tangent.is_finite()))
    }

    #[inline(always)]
    fn evaluate_any(&mut self, order: usize, dt: f64) {
        let values = std::mem::take(&mut self.series.values);
        self.series.evaluate_any(values.as_flattened(), order, Dual::all(dt), &mut self.state);
        self.series.values = values;
    }

    #[inline(always)]
    fn natural_length_any(&self, order: usize, tolerance: f64, limit: f64) -> f64 {
        let mut length = f64::INFINITY;
        for k in order + 1 - LAST..=order {
            let size = k as f64 * self.largest(k);
            length = length.min(math::rough_exp2(math::rough_log2(tolerance / size) / (k - 1) as f64));
        }
        length = f64::min(SERIES_SAFETY * length, limit);
        let sizes: [[f64; D]; ORDERS] = std::array::from_fn(|k| if k > order { [0.0; D] } else { self.tangents(k) });
        for _ in 0..MOST_CUTS {
            if excess(self.reached, &sizes[..=order], length) <= LOOSER * tolerance {
                return length;
            }
            length *= VARIATION_CUT;
        }
        0.0
    }

    /// As [`Variations::defect`].
    fn defect_any(&self, order: usize, dt: f64) -> f64 {
        let share = dt / order as f64;
        let (mut worst, mut changes, mut reached) = (0.0, [0.0; D], self.reached);
        for &place in &self.series.unknowns {
            let value = [0, 1, 2].map(|k| self.value(place, k));
            let change = self.series.end[2][place][0] - (value[2] + value[2]);
            worst = math::maximum(worst, share * (change.value() * self.series.weights[place][0]).abs());
            for direction in 0..D {
                let change_along = |of: &Dual<D>| of.tangents()[direction].abs();
                changes[direction] = math::maximum(changes[direction], share * change_along(&change));
                let largest = math::maximum(
                    change_along(&value[1]),
                    math::maximum(change_along(&value[0]), share * change_along(&value[2])),
                );
                reached[direction] = math::maximum(reached[direction], largest);
            }
        }
        for (change, reached) in changes.iter().zip(&reached).filter(|(change, _)| **change > 0.0) {
            worst = math::maximum(worst, change / reached / LOOSER);
        }
        worst
    }

    /// One coefficient of an unknown.
    #[inline(always)]
    fn value(&self, place: usize, k: usize) -> Dual<D> {
        self.series.values[k * self.series.shape.all() + place][0]
    }

    /// The largest coefficient of one order, relative to what counts of rates.
    #[inline(always)]
    fn largest(&self, k: usize) -> f64 {
        let mut largest: f64 = 0.0;
        for &place in &self.series.unknowns {
            largest = largest.max((self.value(place, k).value() * self.series.weights[place][0]).abs());
        }
        largest
    }

    /// The largest tangent of each direction at one order.
    #[inline(always)]
    fn tangents(&self, k: usize) -> [f64; D] {
        let mut largest = [0.0; D];
        for &place in &self.series.unknowns {
            let value = self.value(place, k);
            let tangents = value.tangents();
            for direction in 0..D {
                largest[direction] = f64::max(largest[direction], tangents[direction].abs());
            }
        }
        largest
    }
}

/// The last terms of v_p, relative to what it or q_p reaches, so far or within the step; of all directions the largest.
#[inline(always)]
fn excess<const D: usize>(mut reached: [f64; D], sizes: &[[f64; D]], length: f64) -> f64 {
    let (mut last, mut power) = ([0.0; D], 1.0);
    for (k, size) in sizes.iter().enumerate().skip(1) {
        let kind = if k + LAST < sizes.len() { &mut reached } else { &mut last };
        for direction in 0..D {
            kind[direction] = f64::max(kind[direction], k as f64 * size[direction] * power);
        }
        power *= length;
    }
    let mut most = 0.0;
    for (last, reached) in last.iter().zip(&reached).filter(|(last, _)| **last > 0.0) {
        most = math::maximum(most, last / reached);
    }
    most
}
