//! Friction limits of a motion, order by order.
//!
//! With limits s the solution of an order is x = x0 + sum X_j s_j: x0 without friction of that order, and X_j what a limit of one adds, by the same factors. Normal forces are made of sums
//! w = w0 + Y s. At order zero s = free + share |w| is solved by Newton's method; at every further order k the newest coefficients enter linearly, |w|_k = n . w_k + known with n = w_0/|w_0|, so that
//! one factorisation of 1 - share n Y serves all of them.

use std::ops::Range;

use super::normals::Normals;
use super::{Coefficient, Jet, Shape, flat};
use crate::linalg::lane::{Lane, by_width, plus, splat};
use crate::linalg::number::Elementary;
use crate::math::{maximum, minimum};
use crate::program::arm_form::{ArmForm, Friction, NormalForce, ORDERS, Slope, Solved};
use crate::taylor::products::convolution;
use crate::taylor::tape::{Numbers, Scalars};

/// Newton's steps at most. Each squares an error, which begins with the share of friction in the normal force; as that share nears one, the limit grows without bound, and steps double it at first.
const STEPS: usize = 50;
/// Limits are known where a step has changed them by no more than this share of the largest: its square is below rounding errors.
const KNOWN: f64 = 1e-8;
/// A mechanism locks itself if its limits are not known up to this part of its shares of friction short of the whole: twenty halves.
const SHORTEST_PART_OF_SHARES: f64 = 1e-6;

/// All limits of a form.
#[derive(Clone, Debug, Default)]
pub(super) struct Limits<N, const L: usize> {
    all: Vec<Limit<N>>,
    /// What a limit of one adds to the solution, for each limit.
    responses: Vec<Vec<Lane<N, L>>>,
    normals: Normals<N, L>,
    /// By rows: 1 - share n Y, then its factors.
    matrix: Vec<N>,
    /// Its inverse, by columns.
    inverse: Vec<Lane<N, L>>,
    right: Vec<N>,
    /// The newest coefficients, and those of a smaller part of all shares.
    newest: Vec<Lane<N, L>>,
    kept: Vec<Lane<N, L>>,
}

/// One of them.
#[derive(Clone, Debug)]
struct Limit<N> {
    data: Friction,
    /// Its force for each unit of the limit, by places of arms.
    arms: Vec<(usize, [u32; 2])>,
    /// Its vectors among all normal forces.
    vectors: Range<usize>,
    series: Numbers<N>,
    /// The normal force, by orders.
    normal: Numbers<N>,
    share: Numbers<N>,
}

/// What normal forces are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
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
        let mut vectors = 0;
        let mut limit = |(_, data): &(u32, &Friction)| {
            let first = vectors;
            vectors += data.normal.len();
            Limit {
                data: (*data).clone(),
                arms: data.arms.iter().map(|&(arm, along)| (shape.place(arm), along)).collect(),
                vectors: first..vectors,
                series: [N::ZERO; ORDERS],
                normal: [N::ZERO; ORDERS],
                share: [N::ZERO; ORDERS],
            }
        };
        let all = contacts.iter().map(&mut limit).collect();
        let forces = contacts.iter().flat_map(|(_, data)| &data.normal);
        let (room, lanes) = (shape.all() + form.rows.len().div_ceil(L), count.div_ceil(L));
        Self {
            all,
            normals: Normals::new(forces, place, count),
            responses: vec![vec![splat(N::ZERO); room]; count],
            matrix: vec![N::ZERO; count * count],
            inverse: vec![splat(N::ZERO); count * lanes],
            right: vec![N::ZERO; count],
            newest: vec![splat(N::ZERO); lanes],
            kept: vec![splat(N::ZERO); lanes],
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

/// What normal forces of one order are made of.
#[derive(Clone, Copy)]
pub(super) struct Known<'a, N: Elementary, const L: usize> {
    pub scalars: &'a Scalars<N, L>,
    pub coefficients: &'a [N],
    /// Arms, by orders, and their second derivatives without the newest accelerations.
    pub arms: [&'a [Lane<N, L>]; 2],
    pub second: [&'a [Lane<N, L>]; 2],
}

impl<N: Elementary, const L: usize> Known<'_, N, L> {
    /// One order of a factor.
    #[inline(always)]
    pub(super) fn factor(&self, factor: Slope, k: usize) -> N {
        match factor {
            Slope::Constant(place) if k == 0 => self.coefficients[place as usize],
            Slope::Constant(_) => N::ZERO,
            Slope::Series(slot) => self.scalars.get(slot, k),
        }
    }

    /// The newest coefficient of what is solved for, without the newest limits.
    #[inline(always)]
    pub(super) fn newest(&self, of: Place, solution: &[N]) -> N {
        let change = self.change(of, solution);
        match of {
            Place::X(place) => self.second[0].as_flattened()[place] + change,
            Place::Y(place) => self.second[1].as_flattened()[place] + change,
            Place::Solution(_) | Place::Limit(_) => change,
        }
    }

    /// What a change of the solution changes in it: a frame turns its arm.
    #[inline(always)]
    pub(super) fn change(&self, of: Place, solution: &[N]) -> N {
        match of {
            Place::Solution(place) => solution[place],
            Place::X(place) => -(solution[place] * self.arms[1].as_flattened()[flat::<L>(place, 0)]),
            Place::Y(place) => solution[place] * self.arms[0].as_flattened()[flat::<L>(place, 0)],
            Place::Limit(_) => N::ZERO,
        }
    }
}

impl<N: Elementary, const L: usize> Limits<N, L> {
    by_width! {
        /// The limits of order k, and what they add to the solution without them and to the loads; orders before it are known.
        pub(super) fn solve[N: Elementary, const L: usize](&mut self: Limits<N, L>, k: usize, known: Known<'_, N, L>, solution: &mut [Lane<N, L>], applied: [&mut [Lane<N, L>]; 2]) = solve_any
    }

    #[inline(always)]
    fn solve_any(&mut self, k: usize, known: Known<N, L>, solution: &mut [Lane<N, L>], [x, y]: [&mut [Lane<N, L>]; 2]) {
        self.find(k, known, solution.as_flattened());
        self.complete(solution);
        self.normals.keep(k, self.newest.as_flattened(), solution.as_flattened());
        self.load(known.coefficients, [x.as_flattened_mut(), y.as_flattened_mut()]);
    }

    #[inline(always)]
    fn find(&mut self, k: usize, known: Known<N, L>, solution: &[N]) {
        for limit in &mut self.all {
            limit.share[k] = known.factor(limit.data.share, k);
        }
        if k == 0 {
            self.normals.begin(&self.responses, known);
        }
        self.normals.predict(k, known, solution);
        if k == 0 {
            self.begin(known)
        } else {
            self.advance(k, known)
        }
        self.normals.add(k, self.newest.as_flattened());
        let newest = self.newest.as_flattened();
        for (limit, newest) in self.all.iter_mut().zip(newest) {
            (limit.series[k], limit.normal[k]) = (*newest, self.normals.total(k, limit.vectors.clone()));
        }
    }

    /// Order zero, by Newton's method. Where it does not converge, or the determinant is not positive (the mechanism locks itself), no limit is a number.
    fn begin(&mut self, known: Known<N, L>) {
        self.newest.fill(splat(N::ZERO));
        self.linearize(known, 1.0);
        // Without what friction does to the normal forces.
        for (newest, law) in self.newest.as_flattened_mut().iter_mut().zip(&self.right) {
            *newest = *law;
        }
        if self.converge(known, 1.0) || self.follow(known) {
            self.invert(known);
        } else {
            self.newest.fill(splat(N::all(f64::NAN)));
        }
    }

    /// The limits as all shares grow from zero to what they are. Where they are zero, so is what friction presses, and the solution goes on continuously while the determinant of 1 - share n Y is positive
    /// (implicit function theorem): Newton's method converges from one share to another that is near enough. False if the solution ends before: the mechanism locks itself.
    fn follow(&mut self, known: Known<N, L>) -> bool {
        for (newest, limit) in self.newest.as_flattened_mut().iter_mut().zip(&self.all) {
            *newest = known.factor(limit.data.free, 0);
        }
        let (mut reached, mut stretch) = (0.0, 1.0);
        while reached < 1.0 && stretch > SHORTEST_PART_OF_SHARES {
            let part = minimum(1.0, reached + stretch);
            self.kept.copy_from_slice(&self.newest);
            if self.converge(known, part) {
                (reached, stretch) = (part, 2.0 * stretch);
            } else {
                self.newest.copy_from_slice(&self.kept);
                stretch *= 0.5;
            }
        }
        reached == 1.0
    }

    /// Newton's method from the newest limits, with this part of all shares. A determinant that is not positive ends it.
    fn converge(&mut self, known: Known<N, L>, part: f64) -> bool {
        let count = self.all.len();
        for _ in 0..STEPS {
            self.linearize(known, part);
            let regular = factor(&mut self.matrix, count) > 0.0;
            solve(&self.matrix, &mut self.right);
            let (mut change, mut size) = (0.0, 0.0);
            for (newest, step) in self.newest.as_flattened_mut().iter_mut().zip(&self.right) {
                *newest += *step;
                change = maximum(change, step.value().abs());
                size = maximum(size, newest.value().abs());
            }
            if !regular || change.is_nan() {
                return false;
            }
            if change <= KNOWN * size {
                return true;
            }
        }
        false
    }

    /// At the newest limits: by how much the laws, with this part of all shares, differ from them, and 1 - share n Y.
    fn linearize(&mut self, known: Known<N, L>, part: f64) {
        let count = self.all.len();
        let newest = self.newest.as_flattened();
        self.normals.linearize(newest, known.coefficients);
        for (index, limit) in self.all.iter().enumerate() {
            let (share, vectors) = (limit.share[0].times(part), limit.vectors.clone());
            for (column, entry) in self.matrix[index * count..][..count].iter_mut().enumerate() {
                let unit = if column == index { N::all(1.0) } else { N::ZERO };
                *entry = unit - share * self.normals.slope(vectors.clone(), column);
            }
            let law = known.factor(limit.data.free, 0) + share * self.normals.total(0, vectors);
            self.right[index] = law - newest[index];
        }
    }

    /// What all other orders are found by.
    fn invert(&mut self, known: Known<N, L>) {
        self.linearize(known, 1.0);
        factor(&mut self.matrix, self.all.len());
        let lanes = self.newest.len();
        for column in 0..self.all.len() {
            self.right.fill(N::ZERO);
            self.right[column] = N::all(1.0);
            solve(&self.matrix, &mut self.right);
            let inverse = self.inverse[column * lanes..][..lanes].as_flattened_mut();
            inverse.iter_mut().zip(&self.right).for_each(|(place, value)| *place = *value);
        }
    }

    /// Order k > 0, which is linear.
    #[inline(always)]
    fn advance(&mut self, k: usize, known: Known<N, L>) {
        for (limit, right) in self.all.iter_mut().zip(&mut self.right) {
            limit.normal[k] = self.normals.total(k, limit.vectors.clone());
            let pressed = match limit.data.share {
                Slope::Constant(_) => limit.share[0] * limit.normal[k],
                Slope::Series(_) => convolution(&limit.share, &limit.normal, k),
            };
            *right = known.factor(limit.data.free, k) + pressed;
        }
        self.newest.fill(splat(N::ZERO));
        let lanes = self.newest.len();
        for (column, right) in self.inverse.chunks_exact(lanes).zip(&self.right) {
            let right = splat(*right);
            self.newest.iter_mut().zip(column).for_each(|(newest, column)| *newest = plus(*newest, *column, right));
        }
    }

    /// What the newest limits add to a solution.
    #[inline(always)]
    fn complete(&self, solution: &mut [Lane<N, L>]) {
        for (newest, response) in self.newest.as_flattened().iter().zip(&self.responses) {
            let newest = splat(*newest);
            solution.iter_mut().zip(response).for_each(|(place, response)| *place = plus(*place, *response, newest));
        }
    }

    /// Takes their forces off the loads.
    #[inline(always)]
    fn load(&self, coefficients: &[N], [x, y]: [&mut [N]; 2]) {
        for (newest, limit) in self.newest.as_flattened().iter().zip(&self.all) {
            for &(place, [along_x, along_y]) in &limit.arms {
                x[place] -= coefficients[along_x as usize] * *newest;
                y[place] -= coefficients[along_y as usize] * *newest;
            }
        }
    }
}

/// Factors a matrix; its determinant.
fn factor<N: Elementary>(matrix: &mut [N], count: usize) -> f64 {
    let mut determinant = 1.0;
    for pivot in 0..count {
        let (upper, lower) = matrix.split_at_mut((pivot + 1) * count);
        let upper = &upper[pivot * count..];
        determinant *= upper[pivot].value();
        for row in lower.chunks_exact_mut(count) {
            let factor = row[pivot].over(upper[pivot]);
            row[pivot] = factor;
            for (entry, upper) in row.iter_mut().zip(upper).skip(pivot + 1) {
                *entry -= factor * *upper;
            }
        }
    }
    determinant
}

/// The solution by factors, in the place of the right-hand side.
fn solve<N: Elementary>(matrix: &[N], right: &mut [N]) {
    let count = right.len();
    let of = |row: usize| &matrix[row * count..][..count];
    for row in 0..count {
        let lower = of(row).iter().zip(&right[..row]).fold(N::ZERO, |sum, (factor, value)| sum + *factor * *value);
        right[row] -= lower;
    }
    for row in (0..count).rev() {
        let upper = of(row).iter().zip(&*right).skip(row + 1);
        let rest = right[row] - upper.fold(N::ZERO, |sum, (factor, value)| sum + *factor * *value);
        right[row] = rest.over(of(row)[row]);
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
        let mut places = polynomials.as_chunks_mut::<ORDERS>().0.iter_mut();
        for limit in &self.all {
            if let Some(place) = places.next() {
                place[..=order].copy_from_slice(&limit.series[..=order]);
                place[order + 1..].fill(0.0);
            }
            for (sum, place) in limit.vectors.clone().flat_map(|vector| self.normals.sums(vector)).zip(&mut places) {
                for (k, coefficient) in place.iter_mut().enumerate() {
                    *coefficient = if k <= order { self.normals.sum(sum, k) } else { 0.0 };
                }
            }
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

#[expect(private_bounds, reason = "there are two kinds of numbers")]
impl<N: Coefficient, const L: usize> Jet<N, L> {
    /// What each limit adds to the solution, by the factors at hand.
    pub(super) fn respond_to_limits(&mut self) {
        if self.limits.is_empty() {
            return;
        }
        let mut limits = std::mem::take(&mut self.limits);
        for (limit, response) in limits.all.iter().zip(&mut limits.responses) {
            self.residual_lanes.fill(splat(N::ZERO));
            for &(place, along) in &limit.arms {
                let force = along.map(|part| self.coefficients[part as usize]);
                self.press(place, force);
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
    #[inline(always)]
    pub(super) fn solve_limits(&mut self, k: usize) {
        let Self { limits, scalars, coefficients, solution, applied: [applied_x, applied_y], x, y, second, .. } = self;
        let known = Known { scalars, coefficients, arms: [x, y], second: [&second[0], &second[1]] };
        limits.solve(k, known, solution, [applied_x, applied_y]);
    }
}
