//! Scalar series: signals of time and the laws of loads, one order at a time.

use super::form::{Given, Operation, SeriesTape, Slot, Source, Step};
use super::lane::WIDTH;
use super::switch::Choices;
use crate::math;
use crate::model::Model;
use crate::program::FollowerOrder;

/// What linear steps read besides scalar series: the k-th coefficients of arms and unknowns.
#[derive(Clone, Copy)]
pub(super) struct Vectors<'a> {
    pub x: &'a [f64],
    pub y: &'a [f64],
    pub unknowns: &'a [f64],
    /// Places of one order of the unknowns.
    pub stride: usize,
}

/// All series of a tape.
#[derive(Clone, Debug)]
pub(super) struct Scalars {
    tape: SeriesTape,
    /// By series, then by order.
    values: Vec<f64>,
    /// Room for the orders of one series.
    room: usize,
    /// Factors of the terms.
    factors: Vec<f64>,
    coefficients: Vec<f64>,
    /// What is known of the choices before a series begins, and what has been chosen since.
    forced: Choices,
    chosen: Choices,
}

impl Scalars {
    /// `place` says where an unknown lies among those of one order, `arm` where the first order of an arm lies.
    pub fn new(
        tape: &SeriesTape,
        room: usize,
        coefficients: usize,
        place: impl Fn(u32) -> usize,
        arm: impl Fn(u32) -> usize,
    ) -> Self {
        let mut tape = tape.clone();
        for term in &mut tape.terms {
            match &mut term.source {
                Source::X(index) | Source::Y(index) => *index = arm(*index) as u32,
                Source::Unknown(index) | Source::UnknownRate(index) => *index = place(*index) as u32,
                Source::Slot(_) => {}
            }
        }
        Self {
            values: vec![0.0; tape.slots as usize * room],
            factors: vec![0.0; tape.terms.len()],
            coefficients: vec![0.0; coefficients],
            room,
            forced: Choices::default(),
            chosen: Choices::default(),
            tape,
        }
    }

    /// Takes the coefficients over.
    #[inline(always)]
    pub fn fill(&mut self, coefficients: &[f64]) {
        self.coefficients.copy_from_slice(coefficients);
        for (factor, term) in self.factors.iter_mut().zip(&self.tape.terms) {
            *factor = coefficients[term.factor as usize];
        }
    }

    /// One coefficient of a series.
    #[inline(always)]
    pub fn get(&self, slot: Slot, order: usize) -> f64 {
        self.values[slot as usize * self.room + order]
    }

    /// Writes the given series and what depends on them only, up to an order. The registers hold the signals at the start.
    #[inline(always)]
    pub fn begin(&mut self, model: &Model, registers: &[f64], order: usize) {
        self.chosen = self.forced;
        for index in 0..self.tape.given.len() {
            let (slot, given) = self.tape.given[index];
            let polynomial = polynomial(model, registers, given);
            let values = &mut self.values[slot as usize * self.room..][..self.room];
            values.fill(0.0);
            values[..polynomial.len()].copy_from_slice(&polynomial);
        }
        if !self.tape.signals.is_empty() {
            let none = Vectors { x: &[], y: &[], unknowns: &[], stride: 0 };
            for k in 0..=order {
                for index in 0..self.tape.signals.len() {
                    self.step(self.tape.signals[index], k, none);
                }
            }
        }
    }

    /// Choices that the next series begins with; the others follow from the signs of their switching functions.
    pub fn force(&mut self, choices: Choices) {
        self.forced = choices;
    }

    /// The choices of the present series.
    pub fn chosen(&self) -> Choices {
        self.chosen
    }

    /// Numbers of the switching functions with their series up to an order.
    pub fn switches(&self, order: usize) -> impl Iterator<Item = (u32, &[f64])> {
        (0..).zip(&self.tape.switches).map(move |(switch, slot)| (switch, &self.series(*slot)[..=order]))
    }

    #[inline(always)]
    fn choose(&mut self, switch: u32) -> bool {
        if let Some(positive) = self.chosen.get(switch) {
            return positive;
        }
        let positive = self.get(self.tape.switches[switch as usize], 0) >= 0.0;
        self.chosen.set(switch, positive);
        positive
    }

    /// Does nothing depend on rates?
    #[inline(always)]
    pub fn is_steady(&self) -> bool {
        self.tape.rates.is_empty()
    }

    /// Does nothing depend on positions?
    #[inline(always)]
    pub fn is_still(&self) -> bool {
        self.tape.positions.is_empty()
    }

    /// Next order of what depends on positions.
    #[inline(always)]
    pub fn positions(&mut self, order: usize, vectors: Vectors) {
        for index in 0..self.tape.positions.len() {
            self.step(self.tape.positions[index], order, vectors);
        }
    }

    /// Next order of what depends on rates; positions must be one order further.
    #[inline(always)]
    pub fn rates(&mut self, order: usize, vectors: Vectors) {
        for index in 0..self.tape.rates.len() {
            self.step(self.tape.rates[index], order, vectors);
        }
    }

    #[inline(always)]
    fn series(&self, slot: Slot) -> &[f64] {
        &self.values[slot as usize * self.room..][..self.room]
    }

    #[inline(always)]
    fn step(&mut self, step: Step, k: usize, vectors: Vectors) {
        let value = match step.operation {
            Operation::Linear { first, count, constant } => self.linear(first, count, constant, k, vectors),
            Operation::Multiply(a, b) => convolution(self.series(a), self.series(b), k),
            Operation::SquareSum(a, b) => square(self.series(a), k) + square(self.series(b), k),
            Operation::Divide(a, b) => {
                let (a, b, quotient) = (self.series(a), self.series(b), self.series(step.target));
                (a[k] - tail(b, quotient, k)) / b[0]
            }
            Operation::Power(a, exponent) => {
                power(self.series(a), self.series(step.target), self.coefficients[exponent as usize], k)
            }
            Operation::SquareRoot(a) => {
                let (a, root) = (self.series(a), self.series(step.target));
                if k == 0 { a[0].sqrt() } else { (a[k] - inner_square(root, k)) / (root[0] + root[0]) }
            }
            Operation::SineCosine(a, cosine) => self.sine_cosine(a, step.target, cosine, k),
            Operation::Exponential(a) => {
                let (a, exponential) = (self.series(a), self.series(step.target));
                if k == 0 { libm::exp(a[0]) } else { weighted(a, exponential, k) / k as f64 }
            }
            Operation::Logarithm(a) => {
                let (a, logarithm) = (self.series(a), self.series(step.target));
                if k == 0 { libm::log(a[0]) } else { (a[k] - weighted_tail(logarithm, a, k) / k as f64) / a[0] }
            }
            Operation::HyperbolicTangent(a, slope) => self.hyperbolic_tangent(a, step.target, slope, k),
            Operation::ArcTangent(y, x, square) => self.arc_tangent([y, x, square], step.target, k),
            Operation::Rate(a) => (k + 1) as f64 * self.get(a, k + 1),
            Operation::Floor { argument, switch, function } => self.floor(argument, step.target, (switch, function), k),
            Operation::Choose { switch, above, below } => {
                let positive = self.choose(switch);
                self.get(if positive { above } else { below }, k)
            }
        };
        self.values[step.target as usize * self.room + k] = value;
    }

    #[inline(always)]
    fn linear(&self, first: u32, count: u32, constant: Option<u32>, k: usize, vectors: Vectors) -> f64 {
        let mut sum = constant.filter(|_| k == 0).map_or(0.0, |place| self.coefficients[place as usize]);
        let range = first as usize..(first + count) as usize;
        let at = k * vectors.stride;
        for (term, factor) in self.tape.terms[range.clone()].iter().zip(&self.factors[range]) {
            let value = match term.source {
                Source::Slot(slot) => self.get(slot, k),
                Source::X(place) => vectors.x[k * WIDTH + place as usize],
                Source::Y(place) => vectors.y[k * WIDTH + place as usize],
                Source::Unknown(place) => vectors.unknowns[at + place as usize],
                Source::UnknownRate(place) => (k + 1) as f64 * vectors.unknowns[at + vectors.stride + place as usize],
            };
            sum += factor * value;
        }
        sum
    }

    /// s' = c a', c' = -s a'
    #[inline(always)]
    fn sine_cosine(&mut self, a: Slot, sine: Slot, cosine: Slot, k: usize) -> f64 {
        let (value, other) = if k == 0 {
            math::sin_cos(self.get(a, 0))
        } else {
            let (a, s, c) = (self.series(a), self.series(sine), self.series(cosine));
            (weighted(a, c, k) / k as f64, -weighted(a, s, k) / k as f64)
        };
        self.values[cosine as usize * self.room + k] = other;
        value
    }

    /// n, and +-(b - b^2) with b = a - n. Which side of an integer is meant is told by whether n is even.
    #[inline(always)]
    fn floor(&mut self, argument: Slot, target: Slot, (switch, function): (u32, Slot), k: usize) -> f64 {
        let below = libm::floor(self.get(argument, 0));
        let even = self.chosen.get(switch).unwrap_or(below == 2.0 * libm::floor(0.5 * below));
        let (odd, sign) = if even { (0.0, 1.0) } else { (1.0, -1.0) };
        let a = self.series(argument);
        let (value, inside) = if k == 0 {
            let n = 2.0 * libm::rint(0.5 * (a[0] - 0.5 - odd)) + odd;
            let b = a[0] - n;
            (n, b - b * b)
        } else {
            let b = a[0] - self.get(target, 0);
            (0.0, a[k] - (inner_square(a, k) + 2.0 * (b * a[k])))
        };
        self.chosen.set(switch, even);
        self.values[function as usize * self.room + k] = sign * inside;
        value
    }

    /// u' = (1 - u^2) a'
    #[inline(always)]
    fn hyperbolic_tangent(&mut self, a: Slot, target: Slot, slope: Slot, k: usize) -> f64 {
        let value = if k == 0 {
            libm::tanh(self.get(a, 0))
        } else {
            weighted(self.series(a), self.series(slope), k) / k as f64
        };
        self.values[target as usize * self.room + k] = value;
        let square = square(self.series(target), k);
        self.values[slope as usize * self.room + k] = if k == 0 { 1.0 - square } else { -square };
        value
    }

    /// (x^2 + y^2) u' = x y' - y x'
    #[inline(always)]
    fn arc_tangent(&self, [y, x, square]: [Slot; 3], target: Slot, k: usize) -> f64 {
        let [y, x, square, u] = [y, x, square, target].map(|slot| self.series(slot));
        if k == 0 {
            return libm::atan2(y[0], x[0]);
        }
        ((weighted(y, x, k) - weighted(x, y, k)) - weighted_tail(u, square, k)) / (k as f64 * square[0])
    }
}

/// The polynomial of time about now that a given series is.
#[inline(always)]
fn polynomial(model: &Model, registers: &[f64], given: Given) -> [f64; 5] {
    let layout = model.layout();
    let input = |index: u32| {
        [layout.inputs(), layout.input_rates(), layout.input_accelerations()]
            .map(|first| registers[first + index as usize])
    };
    let (mut values, derivatives) = match given {
        Given::Time => ([registers[layout.time()], 1.0, 0.0, 0.0, 0.0], 0),
        Given::Input(index, derivatives) => {
            let [value, rate, acceleration] = input(index);
            ([value, rate, acceleration / 2.0, 0.0, 0.0], derivatives)
        }
        Given::Follower(index, derivatives) => {
            let follower = &model.program().followers[index as usize];
            let [value, rate, acceleration] = input(follower.input);
            let position = registers[layout.followers() + index as usize];
            let series = match follower.order {
                FollowerOrder::Velocity => [position, value, rate / 2.0, acceleration / 6.0, 0.0],
                FollowerOrder::Acceleration => {
                    let start = registers[layout.follower_rates() + index as usize];
                    [position, start, value / 2.0, rate / 6.0, acceleration / 24.0]
                }
            };
            (series, derivatives)
        }
    };
    for _ in 0..derivatives {
        for order in 0..4 {
            values[order] = (order + 1) as f64 * values[order + 1];
        }
        values[4] = 0.0;
    }
    values
}

/// sum a_j b_(k-j)
#[inline(always)]
fn convolution(a: &[f64], b: &[f64], k: usize) -> f64 {
    dot(&a[..=k], &b[..=k])
}

/// sum of the products of one end of a with the other end of b, in two sums that do not wait for each other.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (mut even, mut odd) = (0.0, 0.0);
    let (mut left, mut right) = (a.chunks_exact(2), b.rchunks_exact(2));
    for (a, b) in (&mut left).zip(&mut right) {
        even += a[0] * b[1];
        odd += a[1] * b[0];
    }
    if let ([a], [b]) = (left.remainder(), right.remainder()) {
        even += a * b;
    }
    even + odd
}

/// The k-th coefficient of a^2.
#[inline(always)]
fn square(a: &[f64], k: usize) -> f64 {
    inner_square(a, k) + if k == 0 { a[0] * a[0] } else { 2.0 * (a[0] * a[k]) }
}

/// The k-th coefficient of a^2 without the terms of a_k.
#[inline(always)]
fn inner_square(a: &[f64], k: usize) -> f64 {
    if k < 2 {
        return 0.0;
    }
    let half = k.div_ceil(2);
    let middle = if k.is_multiple_of(2) { a[k / 2] * a[k / 2] } else { 0.0 };
    2.0 * dot(&a[1..half], &a[k + 1 - half..k]) + middle
}

/// sum of b_j q_(k-j) over 1 <= j <= k
#[inline(always)]
fn tail(b: &[f64], q: &[f64], k: usize) -> f64 {
    dot(&b[1..=k], &q[..k])
}

/// sum of j a_j b_(k-j) over 1 <= j <= k
#[inline(always)]
fn weighted(a: &[f64], b: &[f64], k: usize) -> f64 {
    weighted_dot(&a[1..=k], &b[..k])
}

/// The same without j = k.
#[inline(always)]
fn weighted_tail(a: &[f64], b: &[f64], k: usize) -> f64 {
    if k == 0 { 0.0 } else { weighted_dot(&a[1..k], &b[1..k]) }
}

#[inline(always)]
fn weighted_dot(a: &[f64], b: &[f64]) -> f64 {
    let terms = a.iter().zip(b.iter().rev()).enumerate();
    terms.fold(0.0, |sum, (j, (a, b))| sum + (j + 1) as f64 * (a * b))
}

/// u = a^p: a u' = p u a'
#[inline(always)]
fn power(a: &[f64], u: &[f64], exponent: f64, k: usize) -> f64 {
    if k == 0 {
        return libm::pow(a[0], exponent);
    }
    let n = k as f64;
    let terms = a[1..=k].iter().zip(u[..k].iter().rev()).enumerate();
    let sum = terms.fold(0.0, |sum, (j, (a, u))| sum + ((exponent + 1.0) * (j + 1) as f64 - n) * (a * u));
    sum / (n * a[0])
}
