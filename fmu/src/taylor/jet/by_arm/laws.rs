//! Scalar series of a motion in any kind of numbers: signals of time and the laws of loads, as [`crate::taylor::tape`] has them.

use super::{Arm, Series};
use crate::linalg::dual::Dual;
use crate::linalg::number::{Elementary, Number};
use crate::model::Model;
use crate::program::arm_form::ORDERS;
use crate::program::arm_form::{Given, Operation, SeriesTape, Slot, Source, Step};
use crate::taylor::products::{convolution, inner_square, power, square, tail, weighted, weighted_tail};
use crate::taylor::tape::polynomial;

/// Order k of a source that is no scalar series.
#[inline(always)]
fn read<N: Number>(arms: &[Arm<N>], source: Source, k: usize) -> N {
    match source {
        Source::X(arm) => arms[arm as usize].x[k],
        Source::Y(arm) => arms[arm as usize].y[k],
        Source::Unknown(arm) => arms[arm as usize].value[k],
        Source::UnknownRate(arm) => arms[arm as usize].value[k + 1].times((k + 1) as f64),
        Source::Slot(_) => N::ZERO,
    }
}

/// All series of a tape.
#[derive(Clone, Debug)]
pub(super) struct Laws<N> {
    tape: SeriesTape,
    series: Vec<Series<N>>,
}

impl<const D: usize> Laws<Dual<D>> {
    /// The given series at a start, with the directions of inputs, which stay as they are.
    pub fn give_duals(&mut self, model: &Model, registers: &[f64], directions: impl Fn(usize) -> [f64; D]) {
        for &(slot, given) in &self.tape.given {
            let series = &mut self.series[slot as usize];
            for (place, value) in series.iter_mut().zip(polynomial(model, registers, given)) {
                *place = Dual::all(value);
            }
            if let Given::Input(index, 0) = given {
                series[0] = Dual::new(series[0].value(), directions(model.layout().inputs() + index as usize));
            }
        }
    }
}

impl<N: Elementary> Laws<N> {
    pub fn new(tape: &SeriesTape) -> Self {
        Self { series: vec![[N::ZERO; ORDERS]; tape.slots as usize], tape: tape.clone() }
    }

    #[inline(always)]
    pub fn get(&self, slot: Slot, order: usize) -> N {
        self.series[slot as usize][order]
    }

    /// Does nothing depend on positions, and nothing on rates?
    #[inline(always)]
    pub fn are_none(&self) -> bool {
        self.tape.positions.is_empty() && self.tape.rates.is_empty()
    }

    /// What depends on given series only, up to an order.
    #[inline(always)]
    pub fn begin(&mut self, c: &[N], order: usize) {
        for k in 0..=order {
            for index in 0..self.tape.signals.len() {
                self.step(self.tape.signals[index], c, k, &[]);
            }
        }
    }

    /// Next order of what depends on positions.
    #[inline(always)]
    pub fn positions(&mut self, c: &[N], k: usize, arms: &[Arm<N>]) {
        for index in 0..self.tape.positions.len() {
            self.step(self.tape.positions[index], c, k, arms);
        }
    }

    /// Next order of what depends on rates; positions must be one order further.
    #[inline(always)]
    pub fn rates(&mut self, c: &[N], k: usize, arms: &[Arm<N>]) {
        for index in 0..self.tape.rates.len() {
            self.step(self.tape.rates[index], c, k, arms);
        }
    }

    #[inline(always)]
    fn step(&mut self, step: Step, c: &[N], k: usize, arms: &[Arm<N>]) {
        let of = |slot: Slot| &self.series[slot as usize];
        let value = match step.operation {
            Operation::Linear { first, count, constant } => {
                let mut sum = constant.filter(|_| k == 0).map_or(N::ZERO, |place| c[place as usize]);
                for term in &self.tape.terms[first as usize..(first + count) as usize] {
                    let value = match term.source {
                        Source::Slot(slot) => of(slot)[k],
                        source => read(arms, source, k),
                    };
                    sum += c[term.factor as usize] * value;
                }
                sum
            }
            Operation::Multiply(a, b) => convolution(of(a), of(b), k),
            Operation::SquareSum(a, b) => square(of(a), k) + square(of(b), k),
            Operation::Divide(a, b) => {
                let (a, b, quotient) = (of(a), of(b), of(step.target));
                (a[k] - tail(b, quotient, k)).over(b[0])
            }
            Operation::Power(a, exponent) => {
                let (a, exponent) = (of(a), c[exponent as usize]);
                match k {
                    0 => a[0].power(exponent),
                    _ => power(a, of(step.target), exponent, k),
                }
            }
            Operation::SquareRoot(a) => {
                let (a, root) = (of(a), of(step.target));
                if k == 0 { a[0].root() } else { (a[k] - inner_square(root, k)).over(root[0] + root[0]) }
            }
            Operation::SineCosine(a, cosine) => {
                let (a, s, c) = (of(a), of(step.target), of(cosine));
                let [next, sine] = if k == 0 {
                    a[0].cosine_and_sine()
                } else {
                    [-weighted(a, s, k), weighted(a, c, k)].map(|sum| sum.times(1.0 / k as f64))
                };
                self.series[cosine as usize][k] = next;
                sine
            }
            Operation::Logarithm(a) => {
                let (a, logarithm) = (of(a), of(step.target));
                match k {
                    0 => a[0].logarithm(),
                    _ => (a[k] - weighted_tail(logarithm, a, k).times(1.0 / k as f64)).over(a[0]),
                }
            }
            Operation::ArcTangent(y, x, square) => {
                let [y, x, square, u] = [y, x, square, step.target].map(of);
                if k == 0 {
                    y[0].arc_tangent(x[0])
                } else {
                    let turning = weighted(y, x, k) - weighted(x, y, k) - weighted_tail(u, square, k);
                    turning.over(square[0].times(k as f64))
                }
            }
            Operation::Rate(a) => of(a)[k + 1].times((k + 1) as f64),
            // Steep laws and laws in pieces are not taken.
            Operation::Exponential(_)
            | Operation::HyperbolicTangent(..)
            | Operation::Floor { .. }
            | Operation::Choose { .. } => N::all(f64::NAN),
        };
        self.series[step.target as usize][k] = value;
    }
}
