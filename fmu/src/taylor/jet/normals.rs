//! Normal forces of all frictions of a motion, order by order and side by side: magnitudes of vectors whose components are affine in accelerations, reactions and friction limits.
//!
//! A component is w = rest + sum slope x, where x is solved for at each order. With the newest limits s it is w + Y s: [`super::friction`] finds s between [`Normals::predict`], without them, and
//! [`Normals::add`].

use std::ops::Range;

use super::friction::{Known, Place};
use super::{ORDERS, at, flat};
use crate::linalg::columns::{Columns, Entry};
use crate::linalg::lane::{Lane, add, multiply, plus, splat, subtract, times};
use crate::linalg::number::Elementary;
use crate::program::arm_form::{NormalForce, Slope, Slot, Solved, SolvedSum};
use crate::taylor::products::tail;
use crate::taylor::tape::Numbers;

/// The vectors, in lanes.
#[derive(Clone, Debug, Default)]
pub(super) struct Normals<N, const L: usize> {
    vectors: Vec<Vector>,
    /// What components are made of, and its newest coefficients without the newest limits.
    places: Vec<Place>,
    values: Vec<N>,
    /// The slopes of both components, by places.
    terms: Columns<N, L>,
    /// Slopes, and their values where the step begins; the first one is zero.
    slopes: Vec<Slope>,
    starts: Vec<N>,
    /// Slopes that are series.
    series_terms: Vec<SeriesTerm>,
    /// What these multiply, by orders.
    solved: Vec<(Place, Numbers<N>)>,
    /// Y: what each limit changes in both components, by limits.
    changes: [Vec<Lane<N, L>>; 2],
    /// The derivatives of a magnitude by both components.
    along: [Vec<Lane<N, L>>; 2],
    /// 1 / (2 magnitude) of a vector of two components, else zero: magnitudes of one are linear.
    half: Vec<Lane<N, L>>,
    /// Components, by orders.
    components: [Vec<Lane<N, L>>; 2],
    /// Magnitudes, by orders.
    sizes: Vec<Lane<N, L>>,
}

#[derive(Clone, Copy, Debug)]
struct Vector {
    /// Where the sign is among the coefficients; none for a magnitude.
    sign: Option<u32>,
    /// The components without what is solved for.
    rests: [Option<Slot>; 2],
}

#[derive(Clone, Copy, Debug)]
struct SeriesTerm {
    /// Component and vector.
    of: [usize; 2],
    slope: Slot,
    /// Its number among what is kept by orders.
    kept: usize,
}

impl<N: Elementary, const L: usize> Normals<N, L> {
    pub(super) fn new<'a>(
        forces: impl Iterator<Item = &'a NormalForce>,
        place: impl Fn(Solved) -> Place,
        limits: usize,
    ) -> Self {
        let mut normals = Self { slopes: vec![Slope::Constant(0)], ..Self::default() };
        let mut entries = Vec::new();
        for force in forces {
            let (sign, sums) = match force {
                NormalForce::Signed(sign, one) => (Some(*sign), std::slice::from_ref(one)),
                NormalForce::Magnitude(components) => (None, &components[..]),
            };
            let rest = |component: usize| sums.get(component).map(|sum: &SolvedSum| sum.rest);
            let vector = normals.vectors.len();
            normals.vectors.push(Vector { sign, rests: [rest(0), rest(1)] });
            for (component, sum) in sums.iter().enumerate() {
                for (solved, slope) in &sum.terms {
                    entries.push(normals.entry([component, vector], place(*solved), *slope));
                }
            }
        }
        let lanes = normals.vectors.len().div_ceil(L);
        let zeros = |count: usize| vec![splat(N::ZERO); count];
        let pair = |count: usize| [zeros(count), zeros(count)];
        normals.values = vec![N::ZERO; normals.places.len()];
        normals.starts = vec![N::ZERO; normals.slopes.len()];
        normals.terms = Columns::new(lanes, &entries);
        normals.changes = pair(limits * lanes);
        normals.along = pair(lanes);
        normals.half = zeros(lanes);
        normals.components = pair(ORDERS * lanes);
        normals.sizes = zeros(ORDERS * lanes);
        normals
    }

    /// The slope of a component of a vector by what is solved for.
    fn entry(&mut self, of: [usize; 2], place: Place, slope: Slope) -> Entry {
        let [component, vector] = of;
        let column = self.places.iter().position(|known| *known == place).unwrap_or(self.places.len());
        if column == self.places.len() {
            self.places.push(place);
        }
        if let Slope::Series(slope) = slope {
            let kept = self.solved.iter().position(|(kept, _)| *kept == place).unwrap_or(self.solved.len());
            if kept == self.solved.len() {
                self.solved.push((place, [N::ZERO; ORDERS]));
            }
            self.series_terms.push(SeriesTerm { of, slope, kept });
        }
        let mut factors = [0; 2];
        factors[component] = self.slopes.len() as u32;
        self.slopes.push(slope);
        (vector, column, factors)
    }

    #[inline(always)]
    fn lanes(&self) -> usize {
        self.half.len()
    }

    /// The slopes where the step begins, and what a limit of one changes by its response.
    pub(super) fn begin(&mut self, responses: &[Vec<Lane<N, L>>], known: Known<N, L>) {
        for (start, slope) in self.starts.iter_mut().zip(&self.slopes).skip(1) {
            *start = known.factor(*slope, 0);
        }
        self.terms.fill(&self.starts);
        let lanes = self.lanes();
        for (limit, response) in responses.iter().enumerate() {
            for (value, place) in self.values.iter_mut().zip(&self.places) {
                *value = match *place {
                    Place::Limit(of) => N::all(if of == limit { 1.0 } else { 0.0 }),
                    of => known.change(of, response.as_flattened()),
                };
            }
            for lane in 0..lanes {
                let of = limit * lanes + lane;
                [self.changes[0][of], self.changes[1][of]] = self.terms.real(lane, &self.values, [splat(N::ZERO); 2]);
            }
        }
    }

    /// Components and magnitudes of order k without the newest limits; magnitudes of order zero follow from [`Self::linearize`].
    #[inline(always)]
    pub(super) fn predict(&mut self, k: usize, known: Known<N, L>, solution: &[N]) {
        for (value, place) in self.values.iter_mut().zip(&self.places) {
            *value = known.newest(*place, solution);
        }
        for lane in 0..self.lanes() {
            let of = at(lane, k);
            [self.components[0][of], self.components[1][of]] = self.terms.real(lane, &self.values, [splat(N::ZERO); 2]);
        }
        for (index, vector) in self.vectors.iter().enumerate() {
            for (components, rest) in self.components.iter_mut().zip(vector.rests) {
                if let Some(slot) = rest {
                    components.as_flattened_mut()[flat::<L>(index, k)] += known.scalars.get(slot, k);
                }
            }
        }
        for term in &self.series_terms {
            let [component, vector] = term.of;
            self.components[component].as_flattened_mut()[flat::<L>(vector, k)] +=
                tail(known.scalars.series(term.slope), &self.solved[term.kept].1, k);
        }
        if k > 0 {
            self.predict_sizes(k);
        }
    }

    /// |w|_k = n . w_k + (inner products of lower orders) / (2 |w|_0)
    #[inline(always)]
    fn predict_sizes(&mut self, k: usize) {
        let [x, y] = &self.components;
        for lane in 0..self.lanes() {
            let linear = multiply(self.along[0][lane], x[at(lane, k)]);
            let linear = plus(linear, self.along[1][lane], y[at(lane, k)]);
            let squares = add(inner_square(x, lane, k), inner_square(y, lane, k));
            let others = subtract(squares, inner_square(&self.sizes, lane, k));
            self.sizes[at(lane, k)] = plus(linear, self.half[lane], others);
        }
    }

    /// Adds what the newest limits change to components and magnitudes of order k.
    #[inline(always)]
    pub(super) fn add(&mut self, k: usize, newest: &[N]) {
        for lane in 0..self.lanes() {
            let [x, y] = self.changed(lane, newest, [splat(N::ZERO); 2]);
            let of = at(lane, k);
            self.components[0][of] = add(self.components[0][of], x);
            self.components[1][of] = add(self.components[1][of], y);
            if k > 0 {
                let size = plus(self.sizes[of], self.along[0][lane], x);
                self.sizes[of] = plus(size, self.along[1][lane], y);
            }
        }
    }

    /// w + Y s
    #[inline(always)]
    fn changed(&self, lane: usize, limits: &[N], [mut x, mut y]: [Lane<N, L>; 2]) -> [Lane<N, L>; 2] {
        let lanes = self.lanes();
        let [by_x, by_y] = &self.changes;
        for (limit, (by_x, by_y)) in
            limits.iter().zip(by_x[lane..].iter().step_by(lanes).zip(by_y[lane..].iter().step_by(lanes)))
        {
            (x, y) = (plus(x, *by_x, splat(*limit)), plus(y, *by_y, splat(*limit)));
        }
        [x, y]
    }

    /// Magnitudes of order zero with these limits, and their derivatives by components.
    pub(super) fn linearize(&mut self, limits: &[N], coefficients: &[N]) {
        for lane in 0..self.lanes() {
            let of = at(lane, 0);
            let start = [self.components[0][of], self.components[1][of]];
            let [x, y] = self.changed(lane, limits, start);
            for place in 0..L {
                let Some(vector) = self.vectors.get(lane * L + place) else { break };
                let (size, along, half) = vector.magnitude([x[place], y[place]], coefficients);
                self.sizes[of][place] = size;
                (self.along[0][lane][place], self.along[1][lane][place]) = (along[0], along[1]);
                self.half[lane][place] = half;
            }
        }
    }

    /// The derivative of the sum of some magnitudes by a limit.
    pub(super) fn slope(&self, vectors: Range<usize>, limit: usize) -> N {
        let first = limit * self.lanes();
        vectors.fold(N::ZERO, |sum, vector| {
            let (lane, place) = (vector / L, vector % L);
            let by = |axis: usize| self.along[axis][lane][place] * self.changes[axis][first + lane][place];
            sum + by(0) + by(1)
        })
    }

    /// The sum of some magnitudes.
    #[inline(always)]
    pub(super) fn total(&self, k: usize, vectors: Range<usize>) -> N {
        vectors.fold(N::ZERO, |sum, vector| sum + self.sizes.as_flattened()[flat::<L>(vector, k)])
    }

    /// Keeps what was solved for where slopes are series.
    #[inline(always)]
    pub(super) fn keep(&mut self, k: usize, limits: &[N], solution: &[N]) {
        for (place, series) in &mut self.solved {
            series[k] = match *place {
                Place::Limit(limit) => limits[limit],
                // Arms have constant slopes.
                Place::Solution(place) | Place::X(place) | Place::Y(place) => solution[place],
            };
        }
    }

    /// Components of a vector: which one, and of which.
    pub(super) fn sums(&self, vector: usize) -> impl Iterator<Item = [usize; 2]> {
        let count = self.vectors[vector].rests.iter().flatten().count();
        (0..count).map(move |component| [component, vector])
    }

    /// Order k of a component.
    pub(super) fn sum(&self, [component, vector]: [usize; 2], k: usize) -> N {
        self.components[component].as_flattened()[flat::<L>(vector, k)]
    }
}

impl Vector {
    /// The magnitude of these components, or the first one times its sign; its derivatives by them; and 1 / (2 magnitude) if there are two.
    fn magnitude<N: Elementary>(&self, [x, y]: [N; 2], coefficients: &[N]) -> (N, [N; 2], N) {
        match (self.sign, self.rests) {
            (Some(sign), _) => {
                let sign = coefficients[sign as usize];
                (sign * x, [sign, N::ZERO], N::ZERO)
            }
            (None, [_, None]) => {
                let sign = N::all(if x.value() < 0.0 { -1.0 } else { 1.0 });
                (sign * x, [sign, N::ZERO], N::ZERO)
            }
            (None, [_, Some(_)]) => {
                let size = (x * x + y * y).root();
                // A vector without a length has no direction.
                let along = if size.value() > 0.0 { [x.over(size), y.over(size)] } else { [N::ZERO; 2] };
                (size, along, N::all(0.5).over(size))
            }
        }
    }
}

/// Order k of the squares of a lane without the terms of the newest coefficients.
#[inline(always)]
fn inner_square<N: Elementary, const L: usize>(all: &[Lane<N, L>], lane: usize, k: usize) -> Lane<N, L> {
    let mut sum = splat(N::ZERO);
    if k < 2 {
        return sum;
    }
    let series = &all[at(lane, 0)..][..k];
    let half = k.div_ceil(2);
    for (left, right) in series[1..half].iter().zip(series[k + 1 - half..].iter().rev()) {
        sum = plus(sum, *left, *right);
    }
    sum = times(2.0, sum);
    if k.is_multiple_of(2) { plus(sum, series[k / 2], series[k / 2]) } else { sum }
}
