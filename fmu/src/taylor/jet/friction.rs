//! Friction limits of a motion, order by order.
//!
//! With limits s the solution of an order is x = x0 + sum X_j s_j: x0 without friction of that order, and X_j what a limit of one adds, by the same factors. Normal forces are made of sums
//! w = w0 + Y s. At order zero s = free + share |w| is solved by Newton's method; at every further order k the newest coefficients enter linearly, |w|_k = n . w_k + known with n = w_0/|w_0|, so that
//! one factorisation of 1 - share n Y serves all of them.

use super::{Coefficient, Jet, Shape, flat};
use crate::linalg::lane::{Lane, splat};
use crate::linalg::number::Elementary;
use crate::math::maximum;
use crate::program::arm_form::{ArmForm, Friction, NormalForce, ORDERS, Slope, Solved, SolvedSum};
use crate::taylor::products::{convolution, inner_square, tail};
use crate::taylor::tape::{Numbers, Scalars};

/// Newton's steps at most: each squares an error, which begins with the share of friction in the normal force.
const STEPS: usize = 12;
/// Limits are known where a step has changed them by no more than this share of the largest: its square is below rounding errors.
const KNOWN: f64 = 1e-9;

/// All limits of a form.
#[derive(Clone, Debug, Default)]
pub(super) struct Limits<N, const L: usize> {
    all: Vec<Limit<N>>,
    /// What a limit of one adds to the solution, for each limit.
    responses: Vec<Vec<Lane<N, L>>>,
    /// What sums are made of, and its newest coefficients without the newest limits.
    places: Vec<Place>,
    values: Vec<N>,
    /// What is multiplied by a series, by orders.
    solved: Vec<(Place, Numbers<N>)>,
    /// By rows: 1 - share n Y, then its factors.
    matrix: Vec<N>,
    right: Vec<N>,
    /// The newest coefficients.
    newest: Vec<N>,
}

/// One of them.
#[derive(Clone, Debug)]
struct Limit<N> {
    data: Friction,
    normals: Vec<Normal<N>>,
    series: Numbers<N>,
    /// The normal force, by orders.
    normal: Numbers<N>,
    share: Numbers<N>,
}

/// Part of a normal force.
#[derive(Clone, Debug)]
struct Normal<N> {
    /// Where the sign is among the coefficients; none for a magnitude.
    sign: Option<u32>,
    sums: Vec<Sum<N>>,
    /// The magnitude, by orders.
    size: Numbers<N>,
}

#[derive(Clone, Debug)]
struct Sum<N> {
    rest: u32,
    terms: Vec<Term<N>>,
    /// Y: what each limit changes in it.
    changes: Vec<N>,
    /// The derivative of the magnitude by it.
    along: N,
    series: Numbers<N>,
}

#[derive(Clone, Copy, Debug)]
struct Term<N> {
    /// Its number among the places.
    of: usize,
    slope: Slope,
    /// The slope where the step begins.
    start: N,
    /// Where its orders are among `solved`, if the slope is a series.
    kept: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// In the solution.
    Solution(usize),
    /// The second derivative of an arm.
    X(usize),
    Y(usize),
    Limit(usize),
}

impl<N: Elementary, const L: usize> Limits<N, L> {
    pub(super) fn new(form: &ArmForm, shape: &Shape) -> Self {
        let contacts: Vec<(u32, &Friction)> = (0..)
            .zip(&form.contacts)
            .filter_map(|(place, contact)| Some((place, contact.friction.as_ref()?)))
            .collect();
        let count = contacts.len();
        let place = |solved: Solved| match solved {
            Solved::Unknown(unknown) => Place::Solution(shape.place(unknown)),
            Solved::X(arm) => Place::X(shape.place(arm)),
            Solved::Y(arm) => Place::Y(shape.place(arm)),
            Solved::Row(row) => Place::Solution(shape.places() + row as usize),
            Solved::Limit(contact) => {
                Place::Limit(contacts.iter().position(|(place, _)| *place == contact).unwrap_or_default())
            }
        };
        let (mut places, mut solved): (Vec<Place>, Vec<(Place, Numbers<N>)>) = (Vec::new(), Vec::new());
        let mut term = |(solved_for, slope): &(Solved, Slope)| {
            let (place, slope) = (place(*solved_for), *slope);
            let of = places.iter().position(|known| *known == place).unwrap_or(places.len());
            if of == places.len() {
                places.push(place);
            }
            let kept = solved.iter().position(|(kept, _)| *kept == place).unwrap_or(solved.len());
            if kept == solved.len() && matches!(slope, Slope::Series(_)) {
                solved.push((place, [N::ZERO; ORDERS]));
            }
            Term { of, slope, start: N::ZERO, kept }
        };
        let mut sum = |sum: &SolvedSum| Sum {
            rest: sum.rest,
            terms: sum.terms.iter().map(&mut term).collect(),
            changes: vec![N::ZERO; count],
            along: N::ZERO,
            series: [N::ZERO; ORDERS],
        };
        let mut normal = |force: &NormalForce| {
            let (sign, sums) = match force {
                NormalForce::Signed(sign, one) => (Some(*sign), vec![sum(one)]),
                NormalForce::Magnitude(components) => (None, components.iter().map(&mut sum).collect()),
            };
            Normal { sign, sums, size: [N::ZERO; ORDERS] }
        };
        let zeros = || [N::ZERO; ORDERS];
        let mut limit = |(_, data): &(u32, &Friction)| Limit {
            data: (*data).clone(),
            normals: data.normal.iter().map(&mut normal).collect(),
            series: zeros(),
            normal: zeros(),
            share: zeros(),
        };
        let all = contacts.iter().map(&mut limit).collect();
        let room = shape.all() + form.rows.len().div_ceil(L);
        Self {
            all,
            values: vec![N::ZERO; places.len()],
            places,
            solved,
            responses: vec![vec![splat(N::ZERO); room]; count],
            matrix: vec![N::ZERO; count * count],
            right: vec![N::ZERO; count],
            newest: vec![N::ZERO; count],
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The limits where the series begins, by rows of the program.
    pub(super) fn at_start(&self) -> impl Iterator<Item = (usize, N)> {
        self.all.iter().map(|limit| (limit.data.constraint as usize, limit.series[0]))
    }
}

/// What the sums of one order are made of.
#[derive(Clone, Copy)]
struct Known<'a, N: Elementary, const L: usize> {
    scalars: &'a Scalars<N, L>,
    coefficients: &'a [N],
    /// The solution without the newest limits.
    solution: &'a [N],
    /// Arms where the step begins, and their second derivatives without the newest accelerations.
    arms: [&'a [Lane<N, L>]; 2],
    second: [&'a [Lane<N, L>]; 2],
}

impl<N: Elementary, const L: usize> Known<'_, N, L> {
    /// One order of a factor.
    #[inline(always)]
    fn factor(&self, factor: Slope, k: usize) -> N {
        match factor {
            Slope::Constant(place) if k == 0 => self.coefficients[place as usize],
            Slope::Constant(_) => N::ZERO,
            Slope::Series(slot) => self.scalars.get(slot, k),
        }
    }

    /// The newest coefficient of what is solved for, without the newest limits.
    #[inline(always)]
    fn newest(&self, of: Place) -> N {
        match of {
            Place::Solution(place) => self.solution[place],
            Place::X(place) => self.second[0].as_flattened()[place] + self.change(of, self.solution),
            Place::Y(place) => self.second[1].as_flattened()[place] + self.change(of, self.solution),
            Place::Limit(_) => N::ZERO,
        }
    }

    /// What a change of the solution changes in it: a frame turns its arm.
    #[inline(always)]
    fn change(&self, of: Place, solution: &[N]) -> N {
        match of {
            Place::Solution(place) => solution[place],
            Place::X(place) => -(solution[place] * self.arms[1].as_flattened()[flat::<L>(place, 0)]),
            Place::Y(place) => solution[place] * self.arms[0].as_flattened()[flat::<L>(place, 0)],
            Place::Limit(_) => N::ZERO,
        }
    }
}

impl<N: Elementary, const L: usize> Limits<N, L> {
    /// The limits of an order; those before it are known.
    fn find(&mut self, k: usize, known: Known<N, L>) {
        for (value, place) in self.values.iter_mut().zip(&self.places) {
            *value = known.newest(*place);
        }
        for limit in &mut self.all {
            limit.share[k] = known.factor(limit.data.share, k);
            for sum in limit.normals.iter_mut().flat_map(|normal| &mut normal.sums) {
                if k == 0 {
                    sum.respond(&self.places, &self.responses, known);
                }
                sum.series[k] = sum.without_newest(k, (&self.values, &self.solved), known);
            }
        }
        if k == 0 { self.begin(known) } else { self.advance(k, known) }
    }

    /// Order zero, by Newton's method. Where it does not converge, or a pivot is not positive (the mechanism locks itself), no limit is a number.
    fn begin(&mut self, known: Known<N, L>) {
        self.newest.fill(N::ZERO);
        for step in 0..=STEPS {
            self.linearize(known);
            let (mut change, mut size) = (0.0, 0.0);
            let regular = self.factor();
            if step == 0 {
                // Without what friction does to the normal forces.
                self.newest.iter_mut().zip(&self.right).for_each(|(newest, law)| *newest = *law);
                continue;
            }
            self.solve();
            for (newest, step) in self.newest.iter_mut().zip(&self.right) {
                *newest += *step;
                change = maximum(change, step.value().abs());
                size = maximum(size, newest.value().abs());
            }
            if regular && change <= KNOWN * size {
                // What the other orders are found by.
                self.linearize(known);
                self.factor();
                break;
            }
            if !regular || step == STEPS {
                self.newest.fill(N::all(f64::NAN));
                break;
            }
        }
        for (index, limit) in self.all.iter_mut().enumerate() {
            limit.series[0] = self.newest[index];
            limit.keep(0, &self.newest);
        }
    }

    /// At the newest limits: by how much the laws differ from them, and 1 - share n Y.
    fn linearize(&mut self, known: Known<N, L>) {
        let count = self.all.len();
        for (index, limit) in self.all.iter_mut().enumerate() {
            let row = &mut self.matrix[index * count..][..count];
            row.fill(N::ZERO);
            row[index] = N::all(1.0);
            let (share, mut total) = (limit.share[0], N::ZERO);
            for normal in &mut limit.normals {
                total += normal.at(&self.newest, known.coefficients);
                for sum in &normal.sums {
                    for (entry, change) in row.iter_mut().zip(&sum.changes) {
                        *entry -= share * sum.along * *change;
                    }
                }
            }
            self.right[index] = known.factor(limit.data.free, 0) + share * total - self.newest[index];
        }
    }

    /// Factors the matrix; false if a pivot is not positive.
    fn factor(&mut self) -> bool {
        let (count, matrix) = (self.all.len(), &mut self.matrix);
        let mut regular = true;
        for pivot in 0..count {
            regular &= matrix[pivot * count + pivot].value() > 0.0;
            for row in pivot + 1..count {
                let factor = matrix[row * count + pivot].over(matrix[pivot * count + pivot]);
                matrix[row * count + pivot] = factor;
                for column in pivot + 1..count {
                    let upper = matrix[pivot * count + column];
                    matrix[row * count + column] -= factor * upper;
                }
            }
        }
        regular
    }

    /// The solution for the right-hand side, in its place.
    fn solve(&mut self) {
        let (count, matrix, right) = (self.all.len(), &self.matrix, &mut self.right);
        for row in 0..count {
            for column in 0..row {
                let lower = matrix[row * count + column] * right[column];
                right[row] -= lower;
            }
        }
        for row in (0..count).rev() {
            for column in row + 1..count {
                let upper = matrix[row * count + column] * right[column];
                right[row] -= upper;
            }
            right[row] = right[row].over(matrix[row * count + row]);
        }
    }

    /// Order k > 0, which is linear.
    fn advance(&mut self, k: usize, known: Known<N, L>) {
        for (index, limit) in self.all.iter_mut().enumerate() {
            limit.normal[k] = limit.normals.iter_mut().fold(N::ZERO, |total, normal| total + normal.predict(k));
            let pressed = match limit.data.share {
                Slope::Constant(_) => limit.share[0] * limit.normal[k],
                Slope::Series(_) => convolution(&limit.share, &limit.normal, k),
            };
            self.right[index] = known.factor(limit.data.free, k) + pressed;
        }
        self.solve();
        self.newest.copy_from_slice(&self.right);
        for (index, limit) in self.all.iter_mut().enumerate() {
            limit.series[k] = self.newest[index];
            limit.keep(k, &self.newest);
        }
    }

    /// Keeps what was solved for.
    fn keep(&mut self, k: usize, solution: &[N]) {
        for (place, series) in &mut self.solved {
            series[k] = match *place {
                Place::Limit(limit) => self.newest[limit],
                // Arms have constant slopes.
                Place::Solution(place) | Place::X(place) | Place::Y(place) => solution[place],
            };
        }
    }
}

/// What the search for changes of friction reads of a step.
impl<const L: usize> Limits<f64, L> {
    /// Series that are kept: of each limit, and of the sums that its normal force is made of.
    pub(super) fn kept(form: &ArmForm) -> usize {
        form.contacts.iter().filter_map(|contact| contact.friction.as_ref()).map(series_of).sum()
    }

    /// Writes them up to an order, and zeros behind it.
    pub(super) fn write(&self, order: usize, polynomials: &mut [f64]) {
        let series = self.all.iter().flat_map(|limit| {
            let sums = limit.normals.iter().flat_map(|normal| &normal.sums);
            std::iter::once(&limit.series).chain(sums.map(|sum| &sum.series))
        });
        for (place, series) in polynomials.as_chunks_mut::<ORDERS>().0.iter_mut().zip(series) {
            let (known, rest) = place.split_at_mut(order + 1);
            known.copy_from_slice(&series[..=order]);
            rest.fill(0.0);
        }
    }
}

/// A limit, and the sums of the normal force.
fn series_of(friction: &Friction) -> usize {
    let count = |force: &NormalForce| match force {
        NormalForce::Signed(..) => 1,
        NormalForce::Magnitude(components) => components.len(),
    };
    1 + friction.normal.iter().map(count).sum::<usize>()
}

/// The polynomials of one friction in a step.
pub(crate) struct FrictionAlong<'a> {
    pub limit: &'a [f64],
    /// The sums of which the normal force is made.
    pub sums: &'a [[f64; ORDERS]],
}

impl Jet {
    /// The polynomials of the friction whose limit is the multiplier of a row.
    pub(crate) fn friction<'a>(&self, polynomial: &'a [f64], row: u32, order: usize) -> Option<FrictionAlong<'a>> {
        let mut rest = polynomial[self.friction_in()..].as_chunks::<ORDERS>().0;
        for friction in self.form.contacts.iter().filter_map(|contact| contact.friction.as_ref()) {
            let (series, others) = rest.split_at_checked(series_of(friction))?;
            if let ([limit, sums @ ..], true) = (series, friction.constraint == row) {
                // Accelerations have two orders less than positions.
                return Some(FrictionAlong { limit: &limit[..order - 1], sums });
            }
            rest = others;
        }
        None
    }

    /// True if there is friction and [`Jet::solved`] has all multipliers: a series has just begun, and each loop equation is one of the program.
    pub(crate) fn is_solved_with_friction(&self) -> bool {
        !self.limits.is_empty() && self.at_start && self.form.auxiliary.is_empty() && self.form.rods.is_empty()
    }
}

impl<N: Elementary> Limit<N> {
    /// The sums, magnitudes and normal force of an order, with the newest limits.
    fn keep(&mut self, k: usize, newest: &[N]) {
        self.normal[k] = N::ZERO;
        for normal in &mut self.normals {
            for sum in &mut normal.sums {
                let change = sum.change(newest);
                sum.series[k] += change;
                if k > 0 {
                    normal.size[k] += sum.along * change;
                }
            }
            self.normal[k] += normal.size[k];
        }
    }
}

impl<N: Elementary> Normal<N> {
    /// Its value at order zero with these limits; keeps its derivatives by its sums.
    fn at(&mut self, newest: &[N], coefficients: &[N]) -> N {
        let value = |sum: &Sum<N>| sum.series[0] + sum.change(newest);
        self.size[0] = match (self.sign, &mut self.sums[..]) {
            (Some(sign), sums) => {
                let sign = coefficients[sign as usize];
                sums.iter_mut().for_each(|sum| sum.along = sign);
                sums.iter().fold(N::ZERO, |total, sum| total + sign * value(sum))
            }
            (None, [one]) => {
                one.along = N::all(if value(one).value() < 0.0 { -1.0 } else { 1.0 });
                one.along * value(one)
            }
            (None, sums) => {
                let square = sums.iter().fold(N::ZERO, |total, sum| total + value(sum) * value(sum));
                let size = square.root();
                for sum in sums {
                    // A vector without a length has no direction.
                    sum.along = if size.value() > 0.0 { value(sum).over(size) } else { N::ZERO };
                }
                size
            }
        };
        self.size[0]
    }

    /// Order k > 0 of it without the newest limits.
    fn predict(&mut self, k: usize) -> N {
        let linear = self.sums.iter().fold(N::ZERO, |total, sum| total + sum.along * sum.series[k]);
        self.size[k] = linear;
        if self.sums.len() > 1 {
            let squares = self.sums.iter().fold(N::ZERO, |total, sum| total + inner_square(&sum.series, k));
            self.size[k] += (squares - inner_square(&self.size, k)).over(self.size[0] + self.size[0]);
        }
        self.size[k]
    }
}

impl<N: Elementary> Sum<N> {
    /// Order k of it without the newest limits.
    #[inline(always)]
    fn without_newest<const L: usize>(
        &self,
        k: usize,
        (values, solved): (&[N], &[(Place, Numbers<N>)]),
        known: Known<N, L>,
    ) -> N {
        let mut sum = known.scalars.get(self.rest, k);
        for term in &self.terms {
            sum += term.start * values[term.of];
            if let Slope::Series(slot) = term.slope {
                sum += tail(known.scalars.series(slot), &solved[term.kept].1, k);
            }
        }
        sum
    }

    /// The slopes where the step begins, and what each limit changes in it.
    fn respond<const L: usize>(&mut self, places: &[Place], responses: &[Vec<Lane<N, L>>], known: Known<N, L>) {
        for term in &mut self.terms {
            term.start = known.factor(term.slope, 0);
        }
        for (limit, (change, response)) in self.changes.iter_mut().zip(responses).enumerate() {
            *change = self.terms.iter().fold(N::ZERO, |total, term| match places[term.of] {
                Place::Limit(of) if of == limit => total + term.start,
                of => total + term.start * known.change(of, response.as_flattened()),
            });
        }
    }

    /// What these limits change in it.
    #[inline(always)]
    fn change(&self, limits: &[N]) -> N {
        self.changes.iter().zip(limits).fold(N::ZERO, |total, (change, limit)| total + *change * *limit)
    }
}

#[expect(private_bounds, reason = "there are two kinds of numbers")]
impl<N: Coefficient, const L: usize> Jet<N, L> {
    /// What each limit adds to the solution, by the factors at hand.
    pub(super) fn respond_to_limits(&mut self) {
        let mut limits = std::mem::take(&mut self.limits);
        for (limit, response) in limits.all.iter().zip(&mut limits.responses) {
            self.residual_lanes.fill(splat(N::ZERO));
            for (arm, along) in &limit.data.arms {
                let force = along.map(|part| self.coefficients[part as usize]);
                self.press(self.shape.place(*arm), force);
            }
            for (unknown, factor) in &limit.data.unknowns {
                let place = self.shape.place(*unknown);
                self.residual_lanes.as_flattened_mut()[place] -= self.coefficients[*factor as usize];
            }
            self.residual.fill(N::ZERO);
            for (place, unknown) in self.residual.iter_mut().zip(&self.unknowns) {
                *place = -self.residual_lanes.as_flattened()[*unknown];
            }
            self.row_residual.fill(N::ZERO);
            self.close_rows();
            self.solve();
            response.copy_from_slice(&self.solution);
        }
        self.limits = limits;
    }

    /// Takes the work of a force on an arm off the residuals of the unknowns.
    fn press(&mut self, place: usize, [fx, fy]: [N; 2]) {
        let [frames, products, _] = self.shape.lanes.map(|lanes| lanes * L);
        let of = flat::<L>(place, 0);
        let moment = self.x.as_flattened()[of] * fy - self.y.as_flattened()[of] * fx;
        let residual = self.residual_lanes.as_flattened_mut();
        let frame = match place.checked_sub(frames) {
            None => place,
            Some(index) if index < products => {
                let unit = flat::<L>(index, 0);
                residual[place] -= self.unit[0].as_flattened()[unit] * fx + self.unit[1].as_flattened()[unit] * fy;
                self.form.products[index].frame as usize
            }
            Some(_) => {
                residual[place] -= fx;
                return;
            }
        };
        if let Some(turned) = self.turned_by[frame] {
            residual[turned] -= moment;
        }
    }

    /// The limits of order k, and what they add to the solution and to the loads.
    pub(super) fn solve_limits(&mut self, k: usize) {
        if self.limits.is_empty() {
            return;
        }
        let mut limits = std::mem::take(&mut self.limits);
        let Self { scalars, coefficients, solution, x, y, second, .. } = self;
        let known = Known {
            scalars,
            coefficients,
            solution: solution.as_flattened(),
            arms: [x, y],
            second: [&second[0], &second[1]],
        };
        limits.find(k, known);
        for (newest, response) in limits.newest.iter().zip(&limits.responses) {
            for (place, change) in self.solution.as_flattened_mut().iter_mut().zip(response.as_flattened()) {
                *place += *newest * *change;
            }
        }
        limits.keep(k, self.solution.as_flattened());
        for (newest, limit) in limits.newest.iter().zip(&limits.all) {
            for (arm, along) in &limit.data.arms {
                let place = self.shape.place(*arm);
                for (axis, part) in along.iter().enumerate() {
                    self.applied[axis].as_flattened_mut()[place] -= self.coefficients[*part as usize] * *newest;
                }
            }
        }
        self.limits = limits;
    }
}
