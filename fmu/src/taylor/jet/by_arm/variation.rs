//! The series of one motion and of its derivatives by parameters: the same operations in dual numbers, so that the variational equations need no equations of
//! their own (Barrio, *SIAM J. Sci. Comput.* 27(6), 2006).

use super::{Arm, ByArm};
use crate::linalg::dual::Dual;
use crate::linalg::lane::{Lane, WIDTH, by_width};
use crate::linalg::number::Number;
use crate::math;
use crate::model::Model;
use crate::program::arm_form::ORDERS;

/// So many directions at once, at most.
pub(crate) const DIRECTIONS: usize = 8;
/// Share of the step that the last coefficients permit: the terms after the last one count too.
const SAFETY: f64 = 0.9;
/// So many last coefficients count: some vanish by symmetry.
const LAST: usize = 4;
/// A step is made that much shorter, so often.
const SHORTER: f64 = 0.7;
const MOST_CUTS: usize = 60;
/// What derivatives may be wrong by, as a multiple of what values may: their coefficients are larger by about their order, and they do not choose the step unless they
/// must, so that derivatives by one parameter do not depend on what else is asked for.
const LOOSER: f64 = 1e3;

/// The tangents of a register file along four directions, and along four more.
pub(crate) type Tangents = [Vec<Lane>; DIRECTIONS / WIDTH];

/// The series of a motion along some directions.
pub(crate) trait Variations: std::fmt::Debug {
    /// Takes the coefficients over from the registers after the parameter stage ran.
    fn enter(&mut self, registers: &[f64], tangents: &Tangents);

    /// The series at the signals, q and v in the registers up to an order, if it needs no pivots there. Loops are closed first, and those of the derivatives with them.
    fn begin(&mut self, model: &Model, order: usize, registers: &[f64], tangents: &Tangents) -> bool;

    /// The step that a tolerance on rates permits if the coefficients shrink as the last ones do (Jorba and Zou, 2005). The values choose it; it is shorter where
    /// derivatives, relative to the largest of their direction, demand that; zero if they demand too much.
    fn step_length(&self, order: usize, tolerance: f64, limit: f64) -> f64;

    /// The difference between the second derivatives where the series before has been continued to, so long after its start, and those with which this one begins, as a
    /// share of the rates that count: in the motion, and in its derivatives as a share of what they may be wrong by.
    fn defect(&self, order: usize, dt: f64) -> f64;

    /// Hands over the tangent of q, v along each direction so long after the start of the series: (place, direction, tangent).
    fn continued(&mut self, order: usize, dt: f64, report: &mut dyn FnMut(usize, usize, f64));
}

/// Storage for as many directions as are needed; none if the laws of the model have no such series.
pub(crate) fn variations(model: &Model, directions: usize) -> Option<Box<dyn Variations>> {
    Some(match directions {
        ..=4 => Box::new(VariedMotion::<4>::new(model)?),
        _ => Box::new(VariedMotion::<DIRECTIONS>::new(model)?),
    })
}

/// A motion with its derivatives.
#[derive(Debug)]
struct VariedMotion<const D: usize> {
    series: ByArm<Dual<D>>,
    /// (q, v)
    state: Vec<Dual<D>>,
}

impl<const D: usize> VariedMotion<D> {
    fn new(model: &Model) -> Option<Self> {
        Some(Self { series: ByArm::new(model)?, state: vec![Dual::ZERO; 2 * model.coordinates()] })
    }

    fn load(&mut self, model: &Model, registers: &[f64], tangents: &Tangents) {
        let first = model.layout().positions();
        for (index, place) in self.state.iter_mut().enumerate() {
            *place = Dual::new(registers[first + index], along(tangents, first + index));
        }
        self.series.laws.give_duals(model, registers, |register| along(tangents, register));
    }
}

/// The tangents of a register.
fn along<const D: usize>(tangents: &Tangents, register: usize) -> [f64; D] {
    std::array::from_fn(|i| tangents[i / WIDTH][register][i % WIDTH])
}

macro_rules! with_directions {
    ($directions:literal) => {
        impl VariedMotion<$directions> {
            by_width! {
                fn begin_series(&mut self: VariedMotion<$directions>, order: usize) -> bool = begin_any
            }

            by_width! {
                fn expand(&mut self: VariedMotion<$directions>, order: usize) -> bool = expand_any
            }

            by_width! {
                fn evaluate(&mut self: VariedMotion<$directions>, order: usize, dt: f64) = evaluate_any
            }
        }

        impl Variations for VariedMotion<$directions> {
            fn enter(&mut self, registers: &[f64], tangents: &Tangents) {
                let ByArm { form, coefficients, .. } = &mut self.series;
                for (place, &register) in coefficients.iter_mut().zip(&form.coefficients.results) {
                    let register = register as usize;
                    *place = Dual::new(registers[register], along(tangents, register));
                }
            }

            fn begin(&mut self, model: &Model, order: usize, registers: &[f64], tangents: &Tangents) -> bool {
                self.load(model, registers, tangents);
                self.begin_series(order) && self.expand(order)
            }

            by_width! {
                fn step_length(&self: VariedMotion<$directions>, order: usize, tolerance: f64, limit: f64) -> f64 = step_length_any
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
    };
}

with_directions!(4);
with_directions!(8);

impl<const D: usize> VariedMotion<D> {
    #[inline(always)]
    fn begin_any(&mut self, order: usize) -> bool {
        self.series.begin_any(order, &self.state)
    }

    /// All orders. Are they finite?
    #[inline(always)]
    fn expand_any(&mut self, order: usize) -> bool {
        let series = &mut self.series;
        series.advance_all(0, order - 2);
        let unknowns = series.unknowns.iter().map(|&arm| &series.arms[arm].value[..=order]);
        unknowns
            .flatten()
            .all(|own| own.value().is_finite() && own.tangents().iter().all(|tangent| tangent.is_finite()))
    }

    #[inline(always)]
    fn evaluate_any(&mut self, order: usize, dt: f64) {
        self.series.evaluate_any(order, Dual::all(dt), &mut self.state);
    }

    #[inline(always)]
    fn step_length_any(&self, order: usize, tolerance: f64, limit: f64) -> f64 {
        let mut length = f64::INFINITY;
        for k in order + 1 - LAST..=order {
            let size = k as f64 * self.largest(k);
            length = length.min(math::rough_exp2(math::rough_log2(tolerance / size) / (k - 1) as f64));
        }
        length = f64::min(SAFETY * length, limit);
        let sizes: [[f64; D]; ORDERS] = std::array::from_fn(|k| if k > order { [0.0; D] } else { self.tangents(k) });
        for _ in 0..MOST_CUTS {
            if excess(&sizes[..=order], length) <= LOOSER * tolerance {
                return length;
            }
            length *= SHORTER;
        }
        0.0
    }

    /// As [`Variations::defect`].
    fn defect_any(&self, order: usize, dt: f64) -> f64 {
        let share = dt / order as f64;
        let (mut worst, mut changes, mut reached) = (0.0, [0.0; D], [0.0; D]);
        for &arm in &self.series.unknowns {
            let Arm { end, value, weight, .. } = &self.series.arms[arm];
            let change = end[2] - (value[2] + value[2]);
            worst = math::maximum(worst, share * (change.value() * weight.value()).abs());
            for direction in 0..D {
                let own = |of: &Dual<D>| of.tangents()[direction].abs();
                changes[direction] = math::maximum(changes[direction], share * own(&change));
                let largest = math::maximum(own(&value[1]), math::maximum(own(&value[0]), share * own(&value[2])));
                reached[direction] = math::maximum(reached[direction], largest);
            }
        }
        for (change, reached) in changes.iter().zip(&reached).filter(|(change, _)| **change > 0.0) {
            worst = math::maximum(worst, change / reached / LOOSER);
        }
        worst
    }

    /// The largest coefficient of one order, relative to what counts of rates.
    #[inline(always)]
    fn largest(&self, k: usize) -> f64 {
        let mut largest: f64 = 0.0;
        for &arm in &self.series.unknowns {
            let arm = &self.series.arms[arm];
            largest = largest.max((arm.value[k].value() * arm.weight.value()).abs());
        }
        largest
    }

    /// The largest tangent of each direction at one order.
    #[inline(always)]
    fn tangents(&self, k: usize) -> [f64; D] {
        let mut largest = [0.0; D];
        for &arm in &self.series.unknowns {
            let tangents = self.series.arms[arm].value[k].tangents();
            for direction in 0..D {
                largest[direction] = f64::max(largest[direction], tangents[direction].abs());
            }
        }
        largest
    }
}

/// The last terms of v_p, relative to what it or q_p reaches within the step; of all directions the largest.
#[inline(always)]
fn excess<const D: usize>(sizes: &[[f64; D]], length: f64) -> f64 {
    let (mut reached, mut last, mut power) = (sizes[0], [0.0; D], 1.0);
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
