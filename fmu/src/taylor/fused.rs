//! Scalar operations that occur together, found when a model is loaded and run as one: what the law of a spring between two points takes.

use super::tape::{Numbers, Vectors};
use crate::linalg::lane::{Lane, WIDTH, add, plus, splat};
use crate::linalg::number::{Elementary, Number};
use crate::program::arm_form::ORDERS;
use crate::program::arm_form::{SeriesOperation, SeriesStep, SeriesTape, Slot, Source};

/// What is run at each order.
#[derive(Clone, Debug)]
pub(crate) enum Task<N> {
    Sums(Box<Sums<N>>),
    Length(Box<Length<N>>),
    Along(Box<Along<N>>),
    Single(SeriesStep),
}

/// The tasks of some steps.
pub(crate) fn tasks<N: Elementary>(tape: &SeriesTape, steps: &[SeriesStep]) -> Vec<Task<N>> {
    let (sums, mut rest) = Sums::gather(tape, steps);
    let mut tasks: Vec<Task<N>> = sums.into_iter().map(|sums| Task::Sums(Box::new(sums))).collect();
    while !rest.is_empty() {
        let step = rest.remove(0);
        tasks.push(if let Some(length) = Length::find(step, &mut rest) {
            Task::Length(Box::new(length))
        } else if let Some(along) = Along::find(step, &mut rest) {
            Task::Along(Box::new(along))
        } else {
            Task::Single(step)
        });
    }
    tasks
}

/// Up to four linear steps that read no other series, side by side.
#[derive(Clone, Debug)]
pub(crate) struct Sums<N> {
    targets: Vec<Slot>,
    columns: Vec<Source>,
    /// By columns.
    factors: Vec<Lane<N>>,
    constants: Lane<N>,
    /// For each term: its column, its place in the lane, its number.
    terms: Vec<(usize, usize, usize)>,
    /// Constant terms: place in the lane, coefficient.
    given: Vec<(usize, u32)>,
}

impl<N: Number> Sums<N> {
    /// The sums among these steps, and the other steps in their order. They need nothing of the others, so they may come first.
    fn gather(tape: &SeriesTape, steps: &[SeriesStep]) -> (Vec<Self>, Vec<SeriesStep>) {
        let is_sum = |step: &&SeriesStep| match step.operation {
            SeriesOperation::Linear { first, count, .. } => {
                let terms = &tape.terms[first as usize..(first + count) as usize];
                terms.iter().all(|term| !matches!(term.source, Source::Slot(_)))
            }
            _ => false,
        };
        let (linear, rest): (Vec<&SeriesStep>, Vec<&SeriesStep>) = steps.iter().partition(is_sum);
        (linear.chunks(WIDTH).map(|steps| Self::new(tape, steps)).collect(), rest.into_iter().copied().collect())
    }

    fn new(tape: &SeriesTape, steps: &[&SeriesStep]) -> Self {
        let mut sums = Self {
            targets: vec![],
            columns: vec![],
            factors: vec![],
            constants: splat(N::ZERO),
            terms: vec![],
            given: vec![],
        };
        for (place, step) in steps.iter().enumerate() {
            let SeriesOperation::Linear { first, count, constant } = step.operation else { continue };
            sums.targets.push(step.target);
            sums.given.extend(constant.map(|constant| (place, constant)));
            for index in first as usize..(first + count) as usize {
                let source = tape.terms[index].source;
                let known = sums.columns.iter().position(|column| *column == source);
                let column = known.unwrap_or(sums.columns.len());
                if known.is_none() {
                    sums.columns.push(source);
                    sums.factors.push(splat(N::ZERO));
                }
                sums.terms.push((column, place, index));
            }
        }
        sums
    }

    /// Takes the coefficients over.
    fn fill(&mut self, factors: &[N], coefficients: &[N]) {
        self.factors.fill(splat(N::ZERO));
        self.constants = splat(N::ZERO);
        for &(column, place, term) in &self.terms {
            self.factors[column][place] += factors[term];
        }
        for &(place, constant) in &self.given {
            self.constants[place] += coefficients[constant as usize];
        }
    }

    #[inline(always)]
    pub fn advance<const L: usize>(&self, values: &mut [Numbers<N>], k: usize, vectors: Vectors<N, L>) {
        let mut sums = if k == 0 { self.constants } else { splat(N::ZERO) };
        let columns = &self.columns[..self.factors.len()];
        for i in 0..columns.len() {
            sums = plus(sums, self.factors[i], splat(vectors.read(columns[i], k)));
        }
        for i in 0..self.targets.len().min(WIDTH) {
            values[self.targets[i] as usize][k] = sums[i];
        }
    }
}

/// r = sqrt(x^2 + y^2)
#[derive(Clone, Debug)]
pub(crate) struct Length<N> {
    of: [usize; 2],
    square: usize,
    target: usize,
    /// (x, y, r, 0)
    lanes: [Lane<N>; ORDERS],
}

impl<N: Elementary> Length<N> {
    /// The square root of this sum of squares, if it follows at once.
    fn find(step: SeriesStep, rest: &mut Vec<SeriesStep>) -> Option<Self> {
        let SeriesOperation::SquareSum(x, y) = step.operation else { return None };
        let next = rest.first().filter(|next| next.operation == SeriesOperation::SquareRoot(step.target))?;
        let of = [x as usize, y as usize];
        let length =
            Self { of, square: step.target as usize, target: next.target as usize, lanes: [splat(N::ZERO); ORDERS] };
        rest.remove(0);
        Some(length)
    }

    #[inline(always)]
    pub fn advance(&mut self, values: &mut [Numbers<N>], k: usize) {
        let k = k.min(ORDERS - 1);
        let (x, y) = (values[self.of[0]][k], values[self.of[1]][k]);
        let (square, length) = if k == 0 {
            let square = x * x + y * y;
            (square, square.root())
        } else {
            let inner = inner_square(&self.lanes[1..k]);
            let [x0, y0, length, _] = self.lanes[0];
            let square = (inner[0] + inner[1]) + (x0 * x + y0 * y).times(2.0);
            (square, (square - inner[2]).over(length + length))
        };
        self.lanes[k] = [x, y, length, N::ZERO];
        values[self.square][k] = square;
        values[self.target][k] = length;
    }
}

/// sum of a_j a_(n+1-j) over 1 <= j <= n
#[inline(always)]
fn inner_square<N: Number>(a: &[Lane<N>]) -> Lane<N> {
    let (mut sum, mut j) = (splat(N::ZERO), 0);
    while j < a.len() / 2 {
        sum = plus(sum, a[j], a[a.len() - 1 - j]);
        j += 1;
    }
    let twice = add(sum, sum);
    if a.len() % 2 == 1 { plus(twice, a[j], a[j]) } else { twice }
}

/// q = f / r, and the products of q with up to two others
#[derive(Clone, Debug)]
pub(crate) struct Along<N> {
    /// f and r
    of: [usize; 2],
    target: usize,
    /// (factor, target)
    products: Vec<[usize; 2]>,
    /// q
    quotient: Numbers<N>,
    /// r and the factors, by orders the other way round.
    lanes: [Lane<N>; ORDERS],
}

impl<N: Number> Along<N> {
    /// The quotient of this step with products that follow and read nothing that is not known by then.
    fn find(step: SeriesStep, rest: &mut Vec<SeriesStep>) -> Option<Self> {
        let SeriesOperation::Divide(numerator, divisor) = step.operation else { return None };
        let mut along = Self {
            of: [numerator as usize, divisor as usize],
            target: step.target as usize,
            products: Vec::new(),
            quotient: [N::ZERO; ORDERS],
            lanes: [splat(N::ZERO); ORDERS],
        };
        let mut index = 0;
        while index < rest.len() && along.products.len() < 2 {
            let factor = match rest[index].operation {
                SeriesOperation::Multiply(a, b) if a == step.target && b != step.target => Some(b),
                SeriesOperation::Multiply(a, b) if b == step.target && a != step.target => Some(a),
                _ => None,
            };
            let known = |slot: Slot| rest.iter().all(|later| !later.writes(slot));
            if let Some(factor) = factor.filter(|factor| known(*factor)) {
                along.products.push([factor as usize, rest.remove(index).target as usize]);
            } else {
                index += 1;
            }
        }
        (!along.products.is_empty()).then_some(along)
    }

    #[inline(always)]
    pub fn advance(&mut self, values: &mut [Numbers<N>], k: usize) {
        let k = k.min(ORDERS - 1);
        let first = ORDERS - 1 - k;
        let (numerator, divisor) = (values[self.of[0]][k], values[self.of[1]][k]);
        let mut newest = [divisor, N::ZERO, N::ZERO, N::ZERO];
        for i in 0..self.products.len().min(2) {
            newest[i + 1] = values[self.products[i][0]][k];
        }
        let (quotient, products) = if k == 0 {
            let quotient = numerator.over(divisor);
            (quotient, [quotient * newest[1], quotient * newest[2]])
        } else {
            let (quotients, lanes) = (&self.quotient[1..k], &self.lanes[first + 1..ORDERS - 1]);
            let (mut inner, mut j) = (splat(N::ZERO), 0);
            while j < quotients.len().min(lanes.len()) {
                inner = plus(inner, lanes[j], splat(quotients[j]));
                j += 1;
            }
            let (start, lead) = (self.quotient[0], self.lanes[ORDERS - 1]);
            inner = plus(inner, newest, splat(start));
            let quotient = (numerator - inner[0]).over(lead[0]);
            (quotient, [inner[1] + quotient * lead[1], inner[2] + quotient * lead[2]])
        };
        self.quotient[k] = quotient;
        self.lanes[first] = newest;
        values[self.target][k] = quotient;
        for i in 0..self.products.len().min(2) {
            values[self.products[i][1]][k] = products[i];
        }
    }
}

impl SeriesStep {
    /// Is this series one of its results?
    fn writes(&self, slot: Slot) -> bool {
        let second = match self.operation {
            SeriesOperation::SineCosine(_, second) | SeriesOperation::HyperbolicTangent(_, second) => Some(second),
            SeriesOperation::Floor { function, .. } => Some(function),
            _ => None,
        };
        self.target == slot || second == Some(slot)
    }
}

impl<N: Number> Task<N> {
    /// Takes the coefficients over.
    pub fn fill(&mut self, factors: &[N], coefficients: &[N]) {
        if let Self::Sums(sums) = self {
            sums.fill(factors, coefficients);
        }
    }
}
