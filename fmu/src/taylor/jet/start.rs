//! The start of a step: the pose, the matrix of its equations, the motion put back on the loops.

use super::terms::Terms;
use super::{Coefficient, Jet, ORDERS, Singular, at, back, flat, vectors};
use crate::events::Choices;
use crate::linalg::columns::Columns;
use crate::linalg::inverse::Inverse;
use crate::linalg::lane::{Lane, above, add, by_width, minus, multiply, plus, splat, subtract, times};
use crate::linalg::matrix::{Assemble, Entries, Matrix, Solve};
use crate::math;
use crate::model::Model;
use crate::program::arm_form::{Auxiliary, CoordinatePlace, Factor, Rod, Slot};
use crate::taylor::tape::polynomial;

/// Loops that are open less than this, relative to their scales, are left alone.
pub(crate) const CLOSED: f64 = 1e-13;
/// The cube of a smaller angle, over six, is below the rounding errors of its cosine and sine.
pub(super) const SMALL: f64 = 1e-6;
/// Newton steps onto the loops where they must be closed tightly.
const CLOSINGS: usize = 4;

/// What the matrix of a pose is added up from.
struct Pose<'a> {
    terms: &'a mut Terms,
    coefficients: &'a [f64],
    derivatives: &'a [Vec<Lane>; 2],
    /// The masses between frames, if there is nothing else.
    frames: Option<&'a Columns>,
}

impl Assemble for Pose<'_> {
    #[inline(always)]
    fn assemble(&mut self, matrix: &mut impl Entries) {
        self.terms.assemble(matrix, self.coefficients, flattened(self.derivatives));
    }

    #[inline(always)]
    fn assemble_whole(&mut self, matrix: &mut Inverse) {
        match self.frames {
            Some(coupling) => self.terms.assemble_frames(matrix, self.coefficients, self.derivatives, coupling),
            None => self.assemble(matrix),
        }
    }

    #[inline(always)]
    fn derivatives(&self) -> [&[f64]; 2] {
        flattened(self.derivatives)
    }
}

/// Both components by places.
#[inline(always)]
pub(super) fn flattened<N, const L: usize>([x, y]: &[Vec<Lane<N, L>>; 2]) -> [&[N]; 2] {
    [x.as_flattened(), y.as_flattened()]
}

impl Jet {
    /// Begins at q and v: factors the matrix, puts the motion back on the loops, and finds its accelerations. The registers hold the
    /// signals of this time. Returns how far the loops were open, relative to their scales.
    pub fn begin(&mut self, model: &Model, registers: &[f64], motion: &[f64]) -> Result<f64, Singular> {
        let open = self.place(model, registers, motion)?;
        self.find_accelerations();
        Ok(open)
    }

    /// The first half of [`Self::begin`]: all but the accelerations.
    pub fn place(&mut self, model: &Model, registers: &[f64], motion: &[f64]) -> Result<f64, Singular> {
        // Where the series goes no further, as at the end of a step in which something happens, no other orders are needed.
        self.scalars.begin(2, |given| polynomial(model, registers, given));
        self.pose(motion)?;
        Ok(self.put_on_loops(&motion[self.form.coordinates.len()..], CLOSED))
    }

    /// The second half: the accelerations of the motion as it has been placed.
    pub fn find_accelerations(&mut self) {
        self.respond();
        self.respond_to_limits();
        self.weigh();
        (0..2).for_each(|k| self.follow(k));
        self.advance(0, 0);
    }

    /// Accelerations of the coordinates and reactions of the program's loop equations at the state in the registers, put on the loops; reactions of equations
    /// that are left out are zero. Not with the kernels of few frames.
    pub fn accelerations(&mut self, model: &Model, registers: &[f64], values: &mut [f64]) -> Result<(), Singular> {
        let layout = model.layout();
        self.begin(model, registers, &registers[layout.positions()..layout.accelerations()])?;
        self.solved(values);
        Ok(())
    }

    /// Accelerations and multipliers where the series begins, with zeros for equations that are left out.
    pub fn solved(&self, values: &mut [f64]) {
        let (accelerations, reactions) = values.split_at_mut(self.form.coordinates.len());
        self.coordinates(2, accelerations);
        accelerations.iter_mut().for_each(|coefficient| *coefficient *= 2.0);
        reactions.fill(0.0);
        let solution = &self.solution.as_flattened()[self.shape.places()..];
        for (row, reaction) in self.form.rows.iter().zip(solution) {
            reactions[row.constraint as usize] = *reaction * self.form.unit_of_mass;
        }
        for (row, limit) in self.limits.at_start() {
            reactions[row] = limit;
        }
    }

    /// The choices of laws at q and v, in a singular pose too: they need no accelerations.
    pub fn choices_at(&mut self, model: &Model, registers: &[f64], motion: &[f64]) -> Choices {
        let (q, v) = motion.split_at(self.form.coordinates.len());
        self.scalars.begin(1, |given| polynomial(model, registers, given));
        self.load(0, q);
        self.turn();
        self.load(1, v);
        self.turn_rates();
        (0..2).for_each(|k| self.follow(k));
        self.scalars.rates(0, vectors(&self.x, &self.y, &self.values, self.shape.all()));
        self.chosen()
    }

    /// The pose of q alone and its matrix, for [`Self::reciprocal_pivots`].
    pub fn probe(&mut self, model: &Model, registers: &[f64], motion: &[f64]) -> Result<(), Singular> {
        self.scalars.begin(0, |given| polynomial(model, registers, given));
        self.pose(motion)
    }

    by_width! {
        fn pose(&mut self: Jet, motion: &[f64]) -> Result<(), Singular> = pose_any
    }

    #[inline(always)]
    fn pose_any(&mut self, motion: &[f64]) -> Result<(), Singular> {
        self.load(0, &motion[..self.form.coordinates.len()]);
        self.turn();
        self.factor()
    }

    by_width! {
        fn respond(&mut self: Jet) = respond_any
    }

    /// Closes the loops of positions up to rounding, with the inverse at hand, and those of rates with them, after [`Self::place`].
    pub fn close_tightly(&mut self) {
        let mut before = f64::INFINITY;
        for _ in 0..CLOSINGS {
            let open = self.close(0, 0.0);
            if open <= f64::EPSILON || open > 0.5 * before {
                break;
            }
            before = open;
        }
        self.turn_rates();
        (0..2).for_each(|_| _ = self.close(1, 0.0));
    }

    /// How close the loop equations of each joint are to depending on the others: the sum of the inverse squares of their distances, in
    /// the metric of the masses. (A single one may be zero because no reaction of a weightless body points its way.)
    pub fn reciprocal_pivots(&self, values: &mut [f64]) {
        if let Matrix::Whole(inverse) = &self.matrix
            && let Some(reciprocal_pivots) = inverse.reciprocal_pivots()
        {
            return values.fill(reciprocal_pivots);
        }
        match self.is_of_flight() {
            true => values.copy_from_slice(&self.left_out),
            false => values.fill(0.0),
        }
        for ((scale, group), equation) in self.row_scales.iter().zip(&self.groups).zip(&self.equations) {
            let reciprocal = equation.map_or(0.0, |equation| self.matrix.inverse_diagonal(equation).abs());
            values[*group] += scale * scale * reciprocal;
        }
    }

    /// How many times the accelerations of this pose multiply rounding errors of the masses and forces, at least, and the coordinate in which they do:
    /// the largest M_ii (M^-1)_ii, which grows where what is left of an inertia is a small difference of large numbers. The pose must have been begun
    /// or probed.
    pub fn amplification(&mut self) -> (f64, Option<usize>) {
        let masses = &mut self.residual[..self.unknowns.len()];
        self.terms.diagonal(&self.coefficients, flattened(&self.derivatives), masses);
        let (size, equation) = self.matrix.cancellation(masses);
        let place = self.unknowns.get(equation);
        (size, self.reads.iter().position(|read| Some(&read.place()) == place))
    }

    /// Builds and inverts the matrix of this pose.
    #[inline(always)]
    fn factor(&mut self) -> Result<(), Singular> {
        self.differentiate();
        let alike = self.layout.is_some_and(|layout| layout.alike);
        // The mass of a state is along its arm.
        let frames = (self.frames[0] > 0 && self.form.world.is_empty()).then(|| self.coupling.entries());
        let Self { matrix, terms, coefficients, derivatives, .. } = self;
        let regular = matrix.factor(alike, &mut Pose { terms, coefficients, derivatives, frames });
        if regular { Ok(()) } else { Err(Singular) }
    }
}

#[expect(private_bounds, reason = "there are two kinds of numbers")]
impl<N: Coefficient, const L: usize> Jet<N, L> {
    /// Puts a pose on the loops, and its rates with it, where they are open by more than a goal. Returns how far those of positions were.
    #[inline(always)]
    pub(super) fn put_on_loops(&mut self, rates: &[N], goal: f64) -> f64 {
        self.load(1, rates);
        let open = self.close(0, goal);
        self.turn_rates();
        self.close(1, goal);
        open
    }

    by_width! {
        /// One Newton step of positions or rates onto the loops, in the metric of the masses.
        fn close[N: Coefficient, const L: usize](&mut self: Jet<N, L>, order: usize, goal: f64) -> f64 = close_any
    }

    by_width! {
        /// Poses of arms from the unknowns.
        pub(super) fn turn[N: Coefficient, const L: usize](&mut self: Jet<N, L>) = turn_any
    }

    by_width! {
        /// Rates of arms from the rates of the unknowns.
        pub(super) fn turn_rates[N: Coefficient, const L: usize](&mut self: Jet<N, L>) = turn_rates_any
    }

    /// The unknowns of coordinates.
    #[inline(always)]
    pub(super) fn load(&mut self, order: usize, values: &[N]) {
        // What a batch has found does not belong to this pose.
        self.found.leave();
        let first = order * self.shape.places();
        let unknowns = &mut self.values.as_flattened_mut()[first..];
        for &index in &self.chain {
            let value = values[index];
            match self.form.coordinates[index] {
                CoordinatePlace::Displacement { arm } => unknowns[self.shape.place(arm)] = value,
                CoordinatePlace::Angle { arm, parent, reversed } => {
                    let carried = parent.map_or(N::ZERO, |parent| unknowns[parent as usize]);
                    unknowns[arm as usize] = if reversed { carried - value } else { carried + value };
                }
            }
        }
    }

    /// One coefficient of a signal, zero if there is none.
    #[inline(always)]
    pub(super) fn signal(&self, slot: Option<Slot>, order: usize) -> N {
        slot.map_or(N::ZERO, |slot| self.scalars.get(slot, order))
    }

    #[inline(always)]
    fn turn_any(&mut self) {
        for lane in 0..self.shape.lanes[0] {
            let [cosine, sine] = N::cosines_and_sines(self.angles(lane, 0));
            self.x[at(lane, 0)] = multiply(cosine, self.present[lane]);
            self.y[at(lane, 0)] = multiply(sine, self.present[lane]);
        }
        self.turn_rods(0);
        self.find_auxiliary(0);
        self.stretch(0);
        self.follow_curves(0);
    }

    #[inline(always)]
    fn turn_rates_any(&mut self) {
        for lane in 0..self.shape.lanes[0] {
            let omega = self.angles(lane, 1);
            let (c, s) = (self.x[at(lane, 0)], self.y[at(lane, 0)]);
            self.omega[back(lane, 0)] = omega;
            self.x[at(lane, 1)] = multiply(times(-1.0, omega), s);
            self.y[at(lane, 1)] = multiply(omega, c);
        }
        self.turn_rods(1);
        self.find_auxiliary(1);
        self.stretch(1);
        self.follow_curves(1);
    }

    /// One coefficient of the angles of four frames.
    #[inline(always)]
    fn angles(&self, lane: usize, order: usize) -> Lane<N, L> {
        if self.special.is_empty() {
            return self.values[order * self.shape.all() + lane];
        }
        let mut angles = splat(N::ZERO);
        let first = lane * L;
        for frame in first..self.shape.counts[0].min(first + L) {
            angles[frame - first] = self.angle_of(frame, order);
        }
        angles
    }

    /// One coefficient of a frame's angle.
    #[inline(always)]
    fn angle_of(&self, frame: usize, order: usize) -> N {
        let first = order * self.shape.places();
        let angle = self.turned_by[frame].map_or(N::ZERO, |place| self.values.as_flattened()[first + place]);
        angle + self.signal(self.form.frames[frame].signal, order)
    }

    /// One coefficient of products and world arms, of the first two orders.
    #[inline(always)]
    fn stretch(&mut self, order: usize) {
        let all = self.shape.places();
        let (first, count) = (self.shape.lanes[0] * L, self.shape.lanes[1] * L);
        for index in 0..self.shape.counts[1] {
            let product = self.form.products[index];
            let sigma = match product.factor {
                Factor::Unknown => self.values.as_flattened()[order * all + first + index],
                Factor::Signal(slot) => self.scalars.get(slot, order),
            };
            self.sigma.as_flattened_mut()[flat::<L>(index, order)] = sigma;
            for axis in 0..2 {
                let arms = if axis == 0 { &mut self.x } else { &mut self.y }.as_flattened_mut();
                let units = self.unit[axis].as_flattened_mut();
                units[flat::<L>(index, order)] = arms[flat::<L>(product.frame as usize, order)];
                let [(s0, e0), (s1, e1)] =
                    [0, 1].map(|k| (self.sigma.as_flattened()[flat::<L>(index, k)], units[flat::<L>(index, k)]));
                arms[flat::<L>(first + index, order)] = if order == 0 { s0 * e0 } else { s1 * e0 + s0 * e1 };
            }
        }
        let first = first + count;
        for index in 0..self.shape.counts[2] {
            self.x.as_flattened_mut()[flat::<L>(first + index, order)] = match self.form.world[index] {
                Factor::Unknown => self.values.as_flattened()[order * all + first + index],
                Factor::Signal(slot) => self.scalars.get(slot, order),
            };
        }
    }

    /// Angles of rods (or their rates) from the gaps between the points that they lie between.
    #[inline(always)]
    fn turn_rods(&mut self, order: usize) {
        if self.form.rods.is_empty() {
            return;
        }
        for Rod { frame, .. } in &self.form.rods {
            let place = flat::<L>(*frame as usize, order);
            (self.x.as_flattened_mut()[place], self.y.as_flattened_mut()[place]) = (N::ZERO, N::ZERO);
        }
        self.stretch(order);
        self.gap(order);
        let first = order * self.shape.places();
        for Rod { frame, row, length } in &self.form.rods {
            let (frame, row) = (*frame as usize, *row as usize);
            let (gap_x, gap_y) = (self.gaps.as_flattened()[row], self.gaps.as_flattened()[row + 1]);
            let [x, y] = [&mut self.x, &mut self.y].map(|lanes| lanes.as_flattened_mut());
            let angle = if order == 0 {
                let distance = (gap_x * gap_x + gap_y * gap_y).root();
                (x[flat::<L>(frame, 0)], y[flat::<L>(frame, 0)]) = (gap_x.over(distance), gap_y.over(distance));
                gap_y.arc_tangent(gap_x)
            } else {
                let (c, s) = (x[flat::<L>(frame, 0)], y[flat::<L>(frame, 0)]);
                let rate = (c * gap_y - s * gap_x).over(self.coefficients[*length as usize]);
                (x[flat::<L>(frame, 1)], y[flat::<L>(frame, 1)]) = (-rate * s, rate * c);
                self.omega.as_flattened_mut()[flat::<L>(frame, ORDERS - 1)] = rate;
                rate
            };
            self.values.as_flattened_mut()[first + frame] = angle;
        }
    }

    /// Auxiliary displacements (or their rates) from the gaps that they leave.
    #[inline(always)]
    fn find_auxiliary(&mut self, order: usize) {
        if self.form.auxiliary.is_empty() {
            return;
        }
        let first = order * self.shape.places();
        for index in 0..self.form.auxiliary.len() {
            let place = self.shape.place(self.form.auxiliary[index].arm);
            self.values.as_flattened_mut()[first + place] = N::ZERO;
        }
        self.stretch(order);
        self.gap(order);
        for index in 0..self.form.auxiliary.len() {
            let Auxiliary { arm, row, direction } = self.form.auxiliary[index];
            let place = self.shape.place(arm);
            let product = self.form.products[arm as usize - self.shape.counts[0]];
            let frame = product.frame as usize;
            let (c, s) = (self.x.as_flattened()[flat::<L>(frame, 0)], self.y.as_flattened()[flat::<L>(frame, 0)]);
            let [a, b] = direction.map(|part| self.coefficients[part as usize]);
            let (nx, ny) = (a * c - b * s, a * s + b * c);
            let gaps = self.gaps.as_flattened();
            let along = nx * gaps[row as usize] + ny * gaps[row as usize + 1];
            self.values.as_flattened_mut()[first + place] = (-along).over(nx * nx + ny * ny);
        }
    }

    /// One coefficient of the loop equations, of the first two orders.
    #[inline(always)]
    pub(super) fn gap(&mut self, order: usize) {
        let all = self.shape.all();
        for lane in 0..all {
            (self.second[0][lane], self.second[1][lane]) = (self.x[at(lane, order)], self.y[at(lane, order)]);
        }
        let (x, y) = (self.second[0].as_flattened(), self.second[1].as_flattened());
        for (lane, gaps) in self.gaps.iter_mut().enumerate() {
            *gaps = self.rows.dot(lane, x, y);
        }
        let gaps = self.gaps.as_flattened_mut();
        let values = self.values[order * all..].as_flattened();
        for (row, place, factor) in self.terms.linear() {
            gaps[row] += self.coefficients[factor as usize] * values[place];
        }
        if order == 0 {
            for (gap, row) in gaps.iter_mut().zip(&self.form.rows) {
                *gap += self.coefficients[row.constant as usize];
            }
        }
        for &(row, slot, factor) in &self.row_signals {
            gaps[row] += self.coefficients[factor as usize] * self.scalars.get(slot, order);
        }
        if order == 0 {
            self.take_off_turns();
        }
    }

    /// The largest gap of the loops at the pose in the unknowns, relative to their scales.
    #[inline(always)]
    fn largest_gap(&self) -> f64 {
        let sizes = self.gaps.as_flattened().iter().zip(&self.row_scales).map(|(gap, scale)| gap.value().abs() / scale);
        sizes.fold(0.0, math::maximum)
    }

    #[inline(always)]
    fn close_any(&mut self, order: usize, goal: f64) -> f64 {
        if self.form.rows.is_empty() {
            return 0.0;
        }
        self.gap(order);
        let open = self.largest_gap();
        if open <= goal {
            return open;
        }
        self.respond_to_gaps();
        let all = self.shape.all();
        let values = &mut self.values[order * all..][..all];
        for lane in 0..all {
            values[lane] = add(values[lane], self.solution[lane]);
        }
        match order {
            0 if self.special.is_empty() && self.is_small_change() => self.turn_a_little(),
            0 => self.turn(),
            _ => self.turn_rates(),
        }
        open
    }

    /// The change of the unknowns that closes the loops to first order.
    #[inline(always)]
    pub(super) fn respond_to_gaps(&mut self) {
        let (first, gaps) = (self.unknowns.len(), self.gaps.as_flattened());
        if self.terms.pairs.is_empty() && self.matrix.solve_rest(first, gaps, self.solution.as_flattened_mut()) {
            return;
        }
        self.residual.fill(N::ZERO);
        self.residual_lanes.fill(splat(N::ZERO));
        self.row_residual.copy_from_slice(gaps);
        self.close_rows();
        self.solve();
    }

    /// Is every change of the unknowns that the solution holds so small? Not a number is not.
    #[inline(always)]
    fn is_small_change(&self) -> bool {
        let mut change = [0.0; L];
        for lane in &self.solution[..self.shape.all()] {
            for (change, tangent) in change.iter_mut().zip(lane) {
                *change = above(*change, tangent.value());
            }
        }
        change.into_iter().fold(0.0, above) < SMALL
    }

    /// Poses of arms after a small change of the unknowns, which the solution holds.
    #[inline(always)]
    pub(super) fn turn_a_little(&mut self) {
        for lane in 0..self.shape.lanes[0] {
            // Sine and cosine of the change up to rounding: d and 1 - d^2/2.
            let (d, c, s) = (self.solution[lane], self.x[at(lane, 0)], self.y[at(lane, 0)]);
            let half = times(0.5, multiply(d, d));
            self.x[at(lane, 0)] = subtract(c, plus(multiply(d, s), half, c));
            self.y[at(lane, 0)] = add(s, minus(multiply(d, c), half, s));
        }
        self.turn_rods(0);
        self.find_auxiliary(0);
        self.stretch(0);
        self.follow_curves(0);
    }

    /// Derivatives of the arms by angles (k x b), then by displacements (e); those of functions in loop equations.
    #[inline(always)]
    pub(super) fn differentiate(&mut self) {
        let (all, [frames, products, world]) = (self.shape.all(), self.shape.lanes);
        let [dx, dy] = &mut self.derivatives;
        for lane in 0..all {
            dx[lane] = times(-1.0, self.y[at(lane, 0)]);
            dy[lane] = self.x[at(lane, 0)];
        }
        for lane in 0..products {
            dx[all + frames + lane] = self.unit[0][at(lane, 0)];
            dy[all + frames + lane] = self.unit[1][at(lane, 0)];
        }
        for lane in 0..world {
            dx[all + frames + products + lane] = splat(N::all(1.0));
        }
        self.slope_curves();
    }
}
