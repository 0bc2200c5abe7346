//! The series of one motion and of its derivatives by parameters: the same operations in dual numbers, so that the variational equations need no equations of
//! their own (Barrio, *SIAM J. Sci. Comput.* 27(6), 2006).

use super::Members;
use crate::linalg::dual::{DIRECTIONS, Dual};
use crate::linalg::lane::by_width;
use crate::linalg::many::Number;
use crate::math;
use crate::model::Model;
use crate::taylor::ORDERS;

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

impl Members<Dual> {
    /// Takes the coefficients over from the registers after the parameter stage ran, with their tangents.
    pub fn enter_duals(&mut self, registers: &[f64], tangents: impl Fn(usize) -> [f64; DIRECTIONS]) {
        let results = &self.form.coefficients.results;
        for (place, &register) in self.coefficients.iter_mut().zip(results) {
            *place = Dual { value: registers[register as usize], tangents: tangents(register as usize) };
        }
    }

    /// Takes the signals at the start of the series over, with the tangents of inputs.
    pub fn signal_duals(&mut self, model: &Model, registers: &[f64], input: impl Fn(usize) -> [f64; DIRECTIONS]) {
        self.laws.give_duals(model, registers, input);
    }

    by_width! {
        /// The series at (q, v) up to an order, if it needs no pivots there. Loops are closed first, and those of the derivatives with them.
        pub fn expand(&mut self: Members<Dual>, order: usize, motion: &[Dual]) -> bool = expand_any
    }

    #[inline(always)]
    fn expand_any(&mut self, order: usize, motion: &[Dual]) -> bool {
        if !self.begin_any(order, motion).regular {
            return false;
        }
        self.advance_all(1, order - 2);
        let unknowns = self.unknowns.iter().map(|&arm| &self.arms[arm].value[..=order]);
        unknowns.flatten().all(|own| own.value.is_finite() && own.tangents.iter().all(|tangent| tangent.is_finite()))
    }

    by_width! {
        /// The step that a tolerance on rates permits if the coefficients shrink as the last ones do (Jorba and Zou, 2005). The values choose it; it is shorter where
        /// derivatives, relative to the largest of their direction, demand that; zero if they demand too much.
        pub fn step_length(&self: Members<Dual>, order: usize, tolerance: f64, limit: f64) -> f64 = step_length_any
    }

    #[inline(always)]
    fn step_length_any(&self, order: usize, tolerance: f64, limit: f64) -> f64 {
        let mut length = f64::INFINITY;
        for k in order + 1 - LAST..=order {
            let size = k as f64 * self.largest(k);
            length = length.min(math::rough_exp2(math::rough_log2(tolerance / size) / (k - 1) as f64));
        }
        length = f64::min(SAFETY * length, limit);
        let sizes: [[f64; DIRECTIONS]; ORDERS] =
            std::array::from_fn(|k| if k > order { [0.0; DIRECTIONS] } else { self.tangents(k) });
        for _ in 0..MOST_CUTS {
            if excess(&sizes[..=order], length) <= LOOSER * tolerance {
                return length;
            }
            length *= SHORTER;
        }
        0.0
    }

    /// The largest coefficient of one order, relative to what counts of rates.
    #[inline(always)]
    fn largest(&self, k: usize) -> f64 {
        let mut largest: f64 = 0.0;
        for &arm in &self.unknowns {
            let arm = &self.arms[arm];
            largest = largest.max((arm.value[k].value * arm.weight.value).abs());
        }
        largest
    }

    /// The largest tangent of each direction at one order.
    #[inline(always)]
    fn tangents(&self, k: usize) -> [f64; DIRECTIONS] {
        let mut largest = [0.0; DIRECTIONS];
        for &arm in &self.unknowns {
            let tangents = &self.arms[arm].value[k].tangents;
            for direction in 0..DIRECTIONS {
                largest[direction] = f64::max(largest[direction], tangents[direction].abs());
            }
        }
        largest
    }

    by_width! {
        /// The motion and its derivatives so long after the start of the series.
        pub fn state(&mut self: Members<Dual>, order: usize, dt: f64, motion: &mut [Dual]) = state_any
    }

    #[inline(always)]
    fn state_any(&mut self, order: usize, dt: f64, motion: &mut [Dual]) {
        self.evaluate_any(order, Dual::all(dt), motion);
    }
}

/// The last terms of v_p, relative to what it or q_p reaches within the step; of all directions the largest.
#[inline(always)]
fn excess(sizes: &[[f64; DIRECTIONS]], length: f64) -> f64 {
    let (mut reached, mut last, mut power) = (sizes[0], [0.0; DIRECTIONS], 1.0);
    for (k, size) in sizes.iter().enumerate().skip(1) {
        let kind = if k + LAST < sizes.len() { &mut reached } else { &mut last };
        for direction in 0..DIRECTIONS {
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
