//! Scalar series: signals of time and the laws of loads, one order at a time.

use super::fused::{Task, tasks};
use super::products::{convolution, inner_square, power, square, tail, weighted, weighted_tail, weighted_up_to};
use crate::events::switch::{Choices, SwitchSign};
use crate::linalg::lane::{WIDTH, by_width};
use crate::linalg::number::{Elementary, Number};
use crate::linalg::quad::Quad;
use crate::model::Model;
use crate::program::FollowerOrder;
use crate::program::arm_form::ORDERS;
use crate::program::arm_form::{Given, SeriesOperation, SeriesStep, SeriesTape, Slot, Source, Term};

/// What linear steps read besides scalar series: the k-th coefficients of arms and unknowns.
#[derive(Clone, Copy)]
pub(crate) struct Vectors<'a, N, const L: usize> {
    pub x: &'a [N],
    pub y: &'a [N],
    pub unknowns: &'a [N],
    /// Places of one order of the unknowns.
    pub stride: usize,
}

impl<N: Number, const L: usize> Vectors<'_, N, L> {
    /// Order k of a source that is no scalar series.
    #[inline(always)]
    pub fn read(&self, source: Source, k: usize) -> N {
        match source {
            Source::X(place) => self.x[k * L + place as usize],
            Source::Y(place) => self.y[k * L + place as usize],
            Source::Unknown(place) => self.unknowns[k * self.stride + place as usize],
            Source::UnknownRate(place) => self.unknowns[(k + 1) * self.stride + place as usize].times((k + 1) as f64),
            Source::Slot(_) => N::ZERO,
        }
    }
}

/// Coefficients of a given series.
pub(crate) const GIVEN: usize = 5;

/// The coefficients of one series.
pub(crate) type Numbers<N> = [N; ORDERS];

/// All series of a tape.
#[derive(Clone, Debug)]
pub(crate) struct Scalars<N = f64, const L: usize = WIDTH> {
    /// What depends on positions, and on rates too.
    positions: Vec<Task<N>>,
    rates: Vec<Task<N>>,
    store: Store<N>,
    /// What is known of the choices before a series begins.
    forced: Choices,
    pieces: Vec<Pieces>,
}

/// What a switching function decides.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pieces {
    /// The switching functions that depend on what it chooses, one bit for each.
    pub later: u64,
    /// Does something else hold while it is zero than while it is positive, and than while it is negative?
    pub apart: [bool; 2],
}

/// The same of each switching function.
fn pieces(tape: &SeriesTape) -> Vec<Pieces> {
    let mut pieces = vec![Pieces::default(); tape.switches.len()];
    let mut causes = vec![0_u64; tape.slots as usize];
    for step in tape.steps() {
        let mut cause = 0;
        tape.each_read(step, |slot| cause |= causes[slot as usize]);
        let mut value = cause;
        match step.operation {
            SeriesOperation::Choose { switch, above, equal, below } => {
                let apart = &mut pieces[switch as usize].apart;
                *apart = [apart[0] || equal != above, apart[1] || equal != below];
                value |= 1 << switch;
            }
            SeriesOperation::Floor { switch, .. } => value |= 1 << switch,
            _ => {}
        }
        step.targets().for_each(|target| causes[target as usize] = cause);
        causes[step.target as usize] = value;
    }
    for (index, function) in tape.switches.iter().enumerate() {
        for (cause, piece) in pieces.iter_mut().enumerate() {
            piece.later |= (causes[*function as usize] >> cause & 1) << index;
        }
    }
    pieces
}

/// The degrees of given series and of their linear combinations; of the others the highest.
fn degrees(tape: &SeriesTape) -> Vec<usize> {
    let mut degrees = vec![ORDERS; tape.slots as usize];
    for &(slot, given) in &tape.given {
        degrees[slot as usize] = if given == Given::Time { 1 } else { GIVEN - 1 };
    }
    for step in &tape.signals {
        if let SeriesOperation::Linear { first, count, .. } = step.operation {
            let degree =
                |term: &Term| if let Source::Slot(slot) = term.source { degrees[slot as usize] } else { ORDERS };
            let terms = &tape.terms[first as usize..][..count as usize];
            degrees[step.target as usize] = terms.iter().map(degree).max().unwrap_or(0);
        }
    }
    degrees
}

/// The coefficients of all series, and what finds them one by one.
#[derive(Clone, Debug)]
struct Store<N> {
    tape: SeriesTape,
    /// By series.
    values: Vec<Numbers<N>>,
    /// Factors of the terms.
    factors: Vec<N>,
    coefficients: Vec<N>,
    /// No series has coefficients beyond its degree.
    degrees: Vec<usize>,
    /// The number of orders that are known of signals, which depend on the given series only.
    signals_known: usize,
    /// What has been chosen since the series began.
    chosen: Choices,
}

impl<N: Elementary, const L: usize> Scalars<N, L> {
    /// `place` says where an unknown lies among those of one order, `arm` where the first order of an arm lies.
    pub fn new(
        tape: &SeriesTape,
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
            positions: tasks(&tape, &tape.positions),
            rates: tasks(&tape, &tape.rates),
            forced: Choices::default(),
            pieces: pieces(&tape),
            store: Store {
                values: vec![[N::ZERO; ORDERS]; tape.slots as usize],
                factors: vec![N::ZERO; tape.terms.len()],
                coefficients: vec![N::ZERO; coefficients],
                degrees: degrees(&tape),
                signals_known: 0,
                chosen: Choices::default(),
                tape,
            },
        }
    }

    /// Takes the coefficients over.
    pub fn fill(&mut self, coefficients: &[N]) {
        let Store { tape, factors, coefficients: results, .. } = &mut self.store;
        results.copy_from_slice(coefficients);
        for (factor, term) in factors.iter_mut().zip(&tape.terms) {
            *factor = coefficients[term.factor as usize];
        }
        for task in self.positions.iter_mut().chain(&mut self.rates) {
            task.fill(factors, coefficients);
        }
    }

    /// One coefficient of a series.
    #[inline(always)]
    pub fn get(&self, slot: Slot, order: usize) -> N {
        self.store.get(slot, order)
    }

    /// All coefficients of a series.
    pub fn series(&self, slot: Slot) -> &[N] {
        self.store.series(slot)
    }

    /// Writes the given series, as polynomials, and what depends on them only, up to an order: see [`Self::signals`] for more.
    pub fn begin(&mut self, order: usize, polynomial: impl Fn(Given) -> [N; GIVEN]) {
        let store = &mut self.store;
        for &(slot, given) in &store.tape.given {
            let values = &mut store.values[slot as usize];
            values.fill(N::ZERO);
            values[..GIVEN].copy_from_slice(&polynomial(given));
        }
        self.restart(order);
    }

    /// Finds what depends on the given series only, up to an order, after these have changed.
    pub fn restart(&mut self, order: usize) {
        self.store.chosen = self.forced;
        self.store.signals_known = 0;
        self.signals(order);
    }

    /// What depends on the given series only, up to an order; lower ones may be known.
    #[inline(always)]
    pub fn signals(&mut self, order: usize) {
        let store = &mut self.store;
        if store.tape.signals.is_empty() {
            return;
        }
        let none = Vectors::<N, L> { x: &[], y: &[], unknowns: &[], stride: 0 };
        for k in store.signals_known..=order.min(ORDERS - 1) {
            for index in 0..store.tape.signals.len() {
                store.step(store.tape.signals[index], k, none);
            }
            store.signals_known = k + 1;
        }
    }

    /// Choices that the next series begins with; the others follow from the signs of their switching functions.
    pub fn force(&mut self, choices: Choices) {
        self.forced = choices;
    }

    /// What is known of choices before a series begins.
    pub fn forced(&self) -> Choices {
        self.forced
    }

    /// The choices of the present series.
    pub fn chosen(&self) -> Choices {
        self.store.chosen
    }

    /// Numbers of the switching functions with their series up to an order.
    pub fn switches(&self, order: usize) -> impl Iterator<Item = (u32, &[N])> {
        (0..).zip(&self.store.tape.switches).map(move |(switch, slot)| (switch, &self.store.series(*slot)[..=order]))
    }

    /// What a switching function decides.
    pub fn pieces(&self, switch: u32) -> Pieces {
        self.pieces.get(switch as usize).copied().unwrap_or_default()
    }

    /// Does nothing depend on rates?
    #[inline(always)]
    pub fn is_steady(&self) -> bool {
        self.rates.is_empty()
    }

    /// Does nothing depend on positions?
    #[inline(always)]
    pub fn is_still(&self) -> bool {
        self.positions.is_empty()
    }

    by_width! {
        /// Next order of what depends on positions.
        pub fn positions[N: Elementary, const L: usize](&mut self: Scalars<N, L>, order: usize, vectors: Vectors<N, L>) = positions_any
    }

    #[inline(always)]
    fn positions_any(&mut self, order: usize, vectors: Vectors<N, L>) {
        self.store.run(&mut self.positions, order, vectors);
    }

    by_width! {
        /// Next order of what depends on rates; positions must be one order further.
        pub fn rates[N: Elementary, const L: usize](&mut self: Scalars<N, L>, order: usize, vectors: Vectors<N, L>) = rates_any
    }

    #[inline(always)]
    fn rates_any(&mut self, order: usize, vectors: Vectors<N, L>) {
        self.store.run(&mut self.rates, order, vectors);
    }
}

impl Scalars<Quad, 1> {
    /// Does anything depend on time or inputs?
    pub fn has_given(&self) -> bool {
        !self.store.tape.given.is_empty()
    }

    /// Writes the given series of one motion, as polynomials.
    pub fn set_given(&mut self, member: usize, polynomial: impl Fn(Given) -> [f64; GIVEN]) {
        for &(slot, given) in &self.store.tape.given {
            let values = &mut self.store.values[slot as usize][..GIVEN];
            for (place, value) in values.iter_mut().zip(polynomial(given)) {
                place.set(member, value);
            }
        }
    }

    /// Takes the given series of one motion over.
    pub fn take_given(&mut self, member: usize, alone: &Scalars) {
        for &(slot, _) in &self.store.tape.given {
            let values = &mut self.store.values[slot as usize][..GIVEN];
            for (place, value) in values.iter_mut().zip(alone.series(slot)) {
                place.set(member, *value);
            }
        }
    }
}

impl<N: Elementary> Store<N> {
    #[inline(always)]
    fn get(&self, slot: Slot, order: usize) -> N {
        self.values[slot as usize][order]
    }

    #[inline(always)]
    fn series(&self, slot: Slot) -> &Numbers<N> {
        &self.values[slot as usize]
    }

    #[inline(always)]
    fn choose(&mut self, switch: u32) -> SwitchSign {
        if let Some(side) = self.chosen.get(switch) {
            return side;
        }
        let side = SwitchSign::of(self.get(self.tape.switches[switch as usize], 0).value());
        self.chosen.set(switch, side);
        side
    }

    #[inline(always)]
    fn run<const L: usize>(&mut self, tasks: &mut [Task<N>], order: usize, vectors: Vectors<N, L>) {
        let order = order.min(ORDERS - 1);
        for task in tasks {
            match task {
                Task::Sums(sums) => sums.advance(&mut self.values, order, vectors),
                Task::Length(length) => length.advance(&mut self.values, order),
                Task::Along(along) => along.advance(&mut self.values, order),
                Task::Single(step) => self.step(*step, order, vectors),
            }
        }
    }

    /// Out of line: the loop over the tasks stays small.
    #[inline(never)]
    fn step<const L: usize>(&mut self, step: SeriesStep, k: usize, vectors: Vectors<N, L>) {
        let value = match step.operation {
            SeriesOperation::Linear { first, count, constant } => self.linear(first, count, constant, k, vectors),
            SeriesOperation::Multiply(a, b) => convolution(self.series(a), self.series(b), k),
            SeriesOperation::SquareSum(a, b) => square(self.series(a), k) + square(self.series(b), k),
            SeriesOperation::Divide(a, b) => {
                let (a, b, quotient) = (self.series(a), self.series(b), self.series(step.target));
                (a[k] - tail(b, quotient, k)).over(b[0])
            }
            SeriesOperation::Power(a, exponent) => {
                let (a, exponent) = (self.series(a), self.coefficients[exponent as usize]);
                if k == 0 { a[0].power(exponent) } else { power(a, self.series(step.target), exponent, k) }
            }
            SeriesOperation::SquareRoot(a) => {
                let (a, root) = (self.series(a), self.series(step.target));
                if k == 0 { a[0].root() } else { (a[k] - inner_square(root, k)).over(root[0] + root[0]) }
            }
            SeriesOperation::SineCosine(a, cosine) => self.sine_cosine(a, step.target, cosine, k),
            SeriesOperation::Exponential(slot) => {
                let exponential = self.series(step.target);
                match k {
                    0 => self.get(slot, 0).exponential(),
                    // 1/(1 + exp a) is zero there, and all its coefficients with it.
                    _ if exponential[0].value() == f64::INFINITY => N::ZERO,
                    _ => self.weighted(slot, exponential, k).over(N::all(k as f64)),
                }
            }
            SeriesOperation::Logarithm(a) => {
                let (a, logarithm) = (self.series(a), self.series(step.target));
                match k {
                    0 => a[0].logarithm(),
                    _ => (a[k] - weighted_tail(logarithm, a, k).over(N::all(k as f64))).over(a[0]),
                }
            }
            SeriesOperation::HyperbolicTangent(a, slope) => self.hyperbolic_tangent(a, step.target, slope, k),
            SeriesOperation::ArcTangent(y, x, square) => self.arc_tangent([y, x, square], step.target, k),
            SeriesOperation::Rate(a) => self.get(a, k + 1).times((k + 1) as f64),
            SeriesOperation::Floor { argument, switch, function } => {
                self.floor(argument, step.target, (switch, function), k)
            }
            SeriesOperation::Choose { switch, above, equal, below } => {
                let chosen = match self.choose(switch) {
                    SwitchSign::Above => above,
                    SwitchSign::Equal => equal,
                    SwitchSign::Below => below,
                };
                self.get(chosen, k)
            }
        };
        self.values[step.target as usize][k] = value;
    }

    #[inline(always)]
    fn linear<const L: usize>(
        &self,
        first: u32,
        count: u32,
        constant: Option<u32>,
        k: usize,
        vectors: Vectors<N, L>,
    ) -> N {
        let mut sum = constant.filter(|_| k == 0).map_or(N::ZERO, |place| self.coefficients[place as usize]);
        let range = first as usize..(first + count) as usize;
        let (terms, factors) = (&self.tape.terms[range.clone()], &self.factors[range]);
        for i in 0..terms.len().min(factors.len()) {
            let value = match terms[i].source {
                Source::Slot(slot) => self.get(slot, k),
                source => vectors.read(source, k),
            };
            sum += factors[i] * value;
        }
        sum
    }

    /// sum of j a_j b_(k-j) over 1 <= j <= k: one term where a is a time.
    #[inline(always)]
    fn weighted(&self, a: Slot, b: &Numbers<N>, k: usize) -> N {
        weighted_up_to(self.degrees[a as usize], self.series(a), b, k)
    }

    /// s' = c a', c' = -s a'
    #[inline(always)]
    fn sine_cosine(&mut self, a: Slot, sine: Slot, cosine: Slot, k: usize) -> N {
        let [next, value] = if k == 0 {
            self.get(a, 0).cosine_and_sine()
        } else {
            let (s, c) = (self.series(sine), self.series(cosine));
            [-self.weighted(a, s, k), self.weighted(a, c, k)].map(|sum| sum.over(N::all(k as f64)))
        };
        self.values[cosine as usize][k] = next;
        value
    }

    /// n, and +-(b - b^2) with b = a - n. Which side of an integer is meant is told by whether n is even.
    #[inline(always)]
    fn floor(&mut self, argument: Slot, target: Slot, (switch, function): (u32, Slot), k: usize) -> N {
        let below = libm::floor(self.get(argument, 0).value());
        let even =
            self.chosen.get(switch).map_or(below == 2.0 * libm::floor(0.5 * below), |side| side == SwitchSign::Above);
        let (odd, sign) = if even { (0.0, 1.0) } else { (1.0, -1.0) };
        let a = self.series(argument);
        let (value, inside) = if k == 0 {
            let n = N::all(2.0 * libm::rint(0.5 * (a[0].value() - 0.5 - odd)) + odd);
            let b = a[0] - n;
            (n, b - b * b)
        } else {
            let b = a[0] - self.get(target, 0);
            (N::ZERO, a[k] - (inner_square(a, k) + (b * a[k]).times(2.0)))
        };
        self.chosen.set(switch, if even { SwitchSign::Above } else { SwitchSign::Below });
        self.values[function as usize][k] = inside.times(sign);
        value
    }

    /// u' = (1 - u^2) a'
    #[inline(always)]
    fn hyperbolic_tangent(&mut self, a: Slot, target: Slot, slope: Slot, k: usize) -> N {
        if k == 0 {
            let [value, steepness] = self.get(a, 0).hyperbolic_tangent();
            self.values[slope as usize][0] = steepness;
            return value;
        }
        let value = weighted(self.series(a), self.series(slope), k).over(N::all(k as f64));
        self.values[target as usize][k] = value;
        self.values[slope as usize][k] = -square(self.series(target), k);
        value
    }

    /// (x^2 + y^2) u' = x y' - y x'
    #[inline(always)]
    fn arc_tangent(&self, [y, x, square]: [Slot; 3], target: Slot, k: usize) -> N {
        let [y, x, square, u] = [y, x, square, target].map(|slot| self.series(slot));
        if k == 0 {
            return y[0].arc_tangent(x[0]);
        }
        ((weighted(y, x, k) - weighted(x, y, k)) - weighted_tail(u, square, k)).over(square[0].times(k as f64))
    }
}

/// The polynomial of time about now that a given series is.
#[inline(always)]
pub(super) fn polynomial(model: &Model, registers: &[f64], given: Given) -> [f64; GIVEN] {
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
