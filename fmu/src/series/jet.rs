//! Taylor series of one motion: one factorisation, then order by order.
//!
//! Virtual work on arms b_k = sigma_k e_k, with forces G_k = sum A_kl b_l'' + sum p lambda - loads, gives for each unknown
//!
//! * an angle: I alpha + sum b_k x G_k = torques, over the arms of its frames;
//! * a displacement: e_k . G_k = loads;
//!
//! and the loop equations are constant combinations of the b_k themselves. At every order the newest coefficients enter linearly, with the
//! matrix \[M J^T; J 0\] of the start: see McPhee's Eq. (22).

use super::MAX_ORDER;
use super::columns::Columns;
use super::form::{ArmForm, Auxiliary, Factor, Place, Slot};
use super::inverse::Inverse;
use super::lane::{Lane, WIDTH, ZERO, add, lanes, minus, multiply, plus, splat, subtract};
use super::tape::{Scalars, Vectors};
use crate::math;
use crate::model::Model;

/// Storage for the series of positions, orders 0 to [`MAX_ORDER`].
const ORDERS: usize = MAX_ORDER + 1;
/// Loops that are open less than this, relative to their scales, are left alone.
const CLOSED: f64 = 1e-13;

/// Place of one order of a lane: the orders of a lane lie side by side.
#[inline(always)]
fn at(lane: usize, order: usize) -> usize {
    lane * ORDERS + order
}

/// The same for a single number.
#[inline(always)]
fn flat(place: usize, order: usize) -> usize {
    at(place / WIDTH, order) * WIDTH + place % WIDTH
}

/// Orders 0 to k of a lane.
#[inline(always)]
fn series(lanes: &[Lane], lane: usize, k: usize) -> &[Lane] {
    &lanes[at(lane, 0)..][..=k]
}

/// Lanes and places of arms.
#[derive(Clone, Copy, Debug)]
struct Shape {
    /// Lanes of frames, of products, of world arms.
    lanes: [usize; 3],
    counts: [usize; 3],
}

impl Shape {
    fn new(form: &ArmForm) -> Self {
        let counts = [form.frames.len(), form.products.len(), form.world.len()];
        Self { lanes: counts.map(lanes), counts }
    }

    fn all(&self) -> usize {
        self.lanes.iter().sum()
    }

    /// Place of an arm.
    fn place(&self, arm: u32) -> usize {
        let (mut arm, mut first) = (arm as usize, 0);
        for (count, lanes) in self.counts.into_iter().zip(self.lanes) {
            if arm < count {
                return first + arm;
            }
            arm -= count;
            first += lanes * WIDTH;
        }
        first
    }
}

/// How an arm changes with an unknown: unknown (by equation), place of the derivative.
type Touch = (usize, usize);

/// One term of M: derivative . A derivative.
#[derive(Clone, Copy, Debug)]
struct MassTerm {
    row: usize,
    column: usize,
    left: usize,
    right: usize,
    mass: [u32; 2],
}

/// One term of J: p . derivative.
#[derive(Clone, Copy, Debug)]
struct LoopTerm {
    row: usize,
    column: usize,
    derivative: usize,
    p: [u32; 2],
}

/// value x (x, y) on places.
#[derive(Clone, Copy, Debug)]
struct Scatter {
    place: usize,
    value: Option<Slot>,
    factors: [u32; 2],
}

/// The series of one motion.
#[derive(Clone, Debug)]
pub struct Jet {
    form: ArmForm,
    shape: Shape,
    /// Coordinates, what carries an angle before what it carries.
    chain: Vec<usize>,
    /// Places of the unknowns, in the order of their equations.
    unknowns: Vec<usize>,
    /// Place of each frame's unknown.
    turned_by: Vec<Option<usize>>,
    /// Frames whose unknown is another frame's, or that have none, or a signal: handled one by one.
    special: Vec<usize>,
    mass_terms: Vec<MassTerm>,
    inertia_terms: Vec<(usize, u32)>,
    loop_terms: Vec<LoopTerm>,
    linear_terms: Vec<(usize, usize, u32)>,
    pushes: Vec<Scatter>,
    loads: Vec<Scatter>,
    /// So many of them, the first ones, are constant.
    constant_pushes: usize,
    constant_loads: usize,
    coupling: Columns,
    rows: Columns,
    reactions: Columns,
    scalars: Scalars,
    coefficients: Vec<f64>,
    inertia: Vec<Lane>,
    inverse: Inverse,
    /// World components of arms, by orders.
    x: Vec<Lane>,
    y: Vec<Lane>,
    /// Rates of frames, by orders.
    omega: Vec<Lane>,
    /// Lengths and unit vectors of products, by orders.
    sigma: Vec<Lane>,
    unit: [Vec<Lane>; 2],
    /// Forces on arms, by orders.
    force: [Vec<Lane>; 2],
    /// Minus the loads on arms at the present order.
    applied: [Vec<Lane>; 2],
    /// Unknowns, by orders.
    values: Vec<Lane>,
    /// Second derivatives of arms at the present order.
    second: [Vec<Lane>; 2],
    /// Known part of the second derivatives of products: all but their ends.
    inner: [Vec<Lane>; 2],
    /// What the equations lack, by equation.
    lack: Vec<f64>,
    lack_lanes: Vec<Lane>,
    gaps: Vec<Lane>,
    solution: Vec<Lane>,
    /// Derivatives of arms: first by the angle, then by the length.
    derivatives: [Vec<Lane>; 2],
}

/// There is no inverse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular;

impl Jet {
    /// Storage for a model with an arm form.
    pub fn new(model: &Model) -> Option<Self> {
        let form = model.program().arms.clone()?;
        let shape = Shape::new(&form);
        let all = shape.all();
        let turned_by: Vec<Option<usize>> =
            form.frames.iter().map(|frame| frame.unknown.map(|unknown| unknown as usize)).collect();
        let special = (0..form.frames.len())
            .filter(|&index| turned_by[index] != Some(index) || form.frames[index].signal.is_some())
            .collect();
        let unknowns = unknowns(&form, &shape);
        let equations: Vec<usize> =
            (unknowns.iter().copied()).chain((0..form.rows.len()).map(|row| all * WIDTH + row)).collect();
        let room = (all + lanes(form.rows.len())) * WIDTH;
        let count = form.coefficients.results.len();
        let place = |arm: u32| shape.place(arm);
        let arms_of_rows: Vec<(usize, usize, [u32; 2])> = form
            .rows
            .iter()
            .enumerate()
            .flat_map(|(row, data)| data.arms.iter().map(move |&(arm, p)| (row, shape.place(arm), p)))
            .collect();
        let transposed: Vec<(usize, usize, [u32; 2])> =
            arms_of_rows.iter().map(|&(row, arm, p)| (arm, row, p)).collect();
        let masses: Vec<(usize, usize, [u32; 2])> =
            form.coupling.iter().map(|entry| (place(entry.on), place(entry.from), entry.mass)).collect();
        let one = |slot, factor| Scatter { place: slot, value: None, factors: [factor, 0] };
        let pushes =
            form.pushes.iter().map(|push| Scatter { value: push.value, ..one(place(push.unknown), push.factor) });
        let loads =
            form.loads.iter().map(|load| Scatter { place: place(load.arm), value: load.value, factors: load.along });
        let orders = |lanes: usize| vec![ZERO; ORDERS * lanes];
        let (mut pushes, mut loads): (Vec<Scatter>, Vec<Scatter>) = (pushes.collect(), loads.collect());
        pushes.sort_by_key(|push| push.value.is_some());
        loads.sort_by_key(|load| load.value.is_some());
        let constants = |list: &[Scatter]| list.partition_point(|entry| entry.value.is_none());
        let mut jet = Self {
            coupling: Columns::new(all, &masses),
            rows: Columns::new(lanes(form.rows.len()), &arms_of_rows),
            reactions: Columns::new(all, &transposed),
            scalars: Scalars::new(&form.tape, ORDERS, count, place, |arm| flat(place(arm), 0)),
            coefficients: vec![f64::NAN; count],
            inertia: vec![ZERO; shape.lanes[0]],
            inverse: Inverse::new(equations.clone(), room),
            mass_terms: Vec::new(),
            inertia_terms: Vec::new(),
            loop_terms: Vec::new(),
            linear_terms: Vec::new(),
            constant_pushes: constants(&pushes),
            constant_loads: constants(&loads),
            pushes,
            loads,
            applied: [vec![ZERO; all], vec![ZERO; all]],
            chain: chain(&form),
            x: orders(all),
            y: orders(all),
            omega: orders(shape.lanes[0]),
            sigma: orders(shape.lanes[1]),
            unit: [orders(shape.lanes[1]), orders(shape.lanes[1])],
            force: [orders(all), orders(all)],
            values: orders(all),
            second: [vec![ZERO; all], vec![ZERO; all]],
            inner: [vec![ZERO; shape.lanes[1]], vec![ZERO; shape.lanes[1]]],
            lack: vec![0.0; equations.len()],
            lack_lanes: vec![ZERO; all],
            gaps: vec![ZERO; lanes(form.rows.len())],
            solution: vec![ZERO; room / WIDTH],
            derivatives: [vec![ZERO; 2 * all], vec![ZERO; 2 * all]],
            unknowns,
            turned_by,
            special,
            shape,
            form,
        };
        jet.prepare_terms();
        Some(jet)
    }

    /// Unknowns that move an arm, with the places of the derivatives.
    fn touches(&self, arm: u32) -> Vec<Touch> {
        let place = self.shape.place(arm);
        let equation = |place: usize| self.unknowns.iter().position(|unknown| *unknown == place);
        let [frames, products, _] = self.shape.counts;
        let index = arm as usize;
        let (frame, factor) = if index < frames {
            (Some(index), None)
        } else if index < frames + products {
            let product = self.form.products[index - frames];
            (Some(product.frame as usize), Some(product.factor))
        } else {
            (None, Some(self.form.world[index - frames - products]))
        };
        let turn = frame.and_then(|frame| self.turned_by[frame]).and_then(equation).map(|row| (row, place));
        let slide = (factor == Some(Factor::Unknown)).then(|| equation(place)).flatten();
        let slide = slide.map(|row| (row, self.shape.all() * WIDTH + place));
        turn.into_iter().chain(slide).collect()
    }

    fn prepare_terms(&mut self) {
        let equation = |place: usize| self.unknowns.iter().position(|unknown| *unknown == place).unwrap_or_default();
        let (mut masses, mut loops, mut inertia, mut linear) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for entry in &self.form.coupling {
            for (row, left) in self.touches(entry.on) {
                for (column, right) in self.touches(entry.from) {
                    if row <= column {
                        masses.push(MassTerm { row, column, left, right, mass: entry.mass });
                    }
                }
            }
        }
        for (frame, turned_by) in self.form.frames.iter().zip(&self.turned_by) {
            if let Some(place) = turned_by {
                inertia.push((equation(*place), frame.inertia));
            }
        }
        let first = self.unknowns.len();
        for (index, row) in self.form.rows.iter().enumerate() {
            for &(arm, p) in &row.arms {
                for (column, derivative) in self.touches(arm) {
                    loops.push(LoopTerm { row: first + index, column, derivative, p });
                }
            }
            for &(unknown, factor) in &row.unknowns {
                linear.push((first + index, equation(self.shape.place(unknown)), factor));
            }
        }
        (self.mass_terms, self.loop_terms, self.inertia_terms, self.linear_terms) = (masses, loops, inertia, linear);
    }

    /// Takes the coefficients over from the registers, after the parameter stage ran.
    pub fn update(&mut self, registers: &[f64]) {
        let results = self.form.coefficients.results(registers);
        let same = self.coefficients.iter().zip(results).all(|(old, new)| old.to_bits() == new.to_bits());
        if same {
            return;
        }
        for (place, value) in self.coefficients.iter_mut().zip(self.form.coefficients.results(registers)) {
            *place = value;
        }
        let c = &self.coefficients;
        self.coupling.fill(c);
        self.rows.fill(c);
        self.reactions.fill(c);
        self.scalars.fill(c);
        for (place, frame) in self.inertia.as_flattened_mut().iter_mut().zip(&self.form.frames) {
            *place = c[frame.inertia as usize];
        }
    }

    /// Begins at q and v: factors the matrix, and puts the motion back on the loops. The registers hold the signals of this time.
    /// Returns how far the loops were open, relative to their scales.
    pub fn begin(&mut self, model: &Model, registers: &[f64], order: usize, motion: &[f64]) -> Result<f64, Singular> {
        self.scalars.begin(model, registers, order);
        let (q, v) = motion.split_at(self.form.coordinates.len());
        self.load(0, q);
        self.load(1, v);
        self.turn();
        self.factor()?;
        let open = self.close(model, 0);
        self.turn_rates();
        self.close(model, 1);
        Ok(open)
    }

    /// The unknowns of coordinates.
    fn load(&mut self, order: usize, values: &[f64]) {
        let first = order * self.shape.all() * WIDTH;
        let unknowns = &mut self.values.as_flattened_mut()[first..];
        for &index in &self.chain {
            let value = values[index];
            match self.form.coordinates[index] {
                Place::Displacement { arm } => unknowns[self.shape.place(arm)] = value,
                Place::Angle { arm, parent, reversed } => {
                    let carried = parent.map_or(0.0, |parent| unknowns[parent as usize]);
                    unknowns[arm as usize] = if reversed { carried - value } else { carried + value };
                }
            }
        }
    }

    /// Coefficients of the coordinates.
    pub fn coordinates(&self, order: usize, values: &mut [f64]) {
        let first = order * self.shape.all() * WIDTH;
        let unknowns = &self.values.as_flattened()[first..];
        for (value, place) in values.iter_mut().zip(&self.form.coordinates) {
            *value = match *place {
                Place::Displacement { arm } => unknowns[self.shape.place(arm)],
                Place::Angle { arm, parent, reversed } => {
                    let angle = unknowns[arm as usize] - parent.map_or(0.0, |parent| unknowns[parent as usize]);
                    if reversed { -angle } else { angle }
                }
            };
        }
    }

    /// One coefficient of a signal, zero if there is none.
    fn signal(&self, slot: Option<Slot>, order: usize) -> f64 {
        slot.map_or(0.0, |slot| self.scalars.get(slot, order))
    }

    /// Poses of arms from the unknowns.
    fn turn(&mut self) {
        for index in 0..self.shape.counts[0] {
            let angle = self.angle_of(index, 0);
            let (sine, cosine) = math::sin_cos(angle);
            self.x.as_flattened_mut()[flat(index, 0)] = cosine;
            self.y.as_flattened_mut()[flat(index, 0)] = sine;
        }
        self.find_auxiliary(0);
        self.stretch(0);
    }

    /// Rates of arms from the rates of the unknowns.
    fn turn_rates(&mut self) {
        for index in 0..self.shape.counts[0] {
            let omega = self.angle_of(index, 1);
            let (now, next) = (flat(index, 0), flat(index, 1));
            self.omega.as_flattened_mut()[now] = omega;
            let (c, s) = (self.x.as_flattened()[now], self.y.as_flattened()[now]);
            self.x.as_flattened_mut()[next] = -omega * s;
            self.y.as_flattened_mut()[next] = omega * c;
        }
        self.find_auxiliary(1);
        self.stretch(1);
    }

    /// One coefficient of a frame's angle.
    fn angle_of(&self, frame: usize, order: usize) -> f64 {
        let first = order * self.shape.all() * WIDTH;
        let own = self.turned_by[frame].map_or(0.0, |place| self.values.as_flattened()[first + place]);
        own + self.signal(self.form.frames[frame].signal, order)
    }

    /// One coefficient of products and world arms, of the first two orders.
    fn stretch(&mut self, order: usize) {
        let all = self.shape.all() * WIDTH;
        let (first, count) = (self.shape.lanes[0] * WIDTH, self.shape.lanes[1] * WIDTH);
        for index in 0..self.shape.counts[1] {
            let product = self.form.products[index];
            let sigma = match product.factor {
                Factor::Unknown => self.values.as_flattened()[order * all + first + index],
                Factor::Signal(slot) => self.scalars.get(slot, order),
            };
            self.sigma.as_flattened_mut()[flat(index, order)] = sigma;
            for axis in 0..2 {
                let arms = if axis == 0 { &mut self.x } else { &mut self.y }.as_flattened_mut();
                let units = self.unit[axis].as_flattened_mut();
                units[flat(index, order)] = arms[flat(product.frame as usize, order)];
                let [(s0, e0), (s1, e1)] =
                    [0, 1].map(|k| (self.sigma.as_flattened()[flat(index, k)], units[flat(index, k)]));
                arms[flat(first + index, order)] = if order == 0 { s0 * e0 } else { s1 * e0 + s0 * e1 };
            }
        }
        let first = first + count;
        for index in 0..self.shape.counts[2] {
            self.x.as_flattened_mut()[flat(first + index, order)] = match self.form.world[index] {
                Factor::Unknown => self.values.as_flattened()[order * all + first + index],
                Factor::Signal(slot) => self.scalars.get(slot, order),
            };
        }
    }

    /// Auxiliary displacements (or their rates) from the gaps that they leave.
    fn find_auxiliary(&mut self, order: usize) {
        if self.form.auxiliary.is_empty() {
            return;
        }
        let first = order * self.shape.all() * WIDTH;
        for index in 0..self.form.auxiliary.len() {
            let place = self.shape.place(self.form.auxiliary[index].arm);
            self.values.as_flattened_mut()[first + place] = 0.0;
        }
        self.stretch(order);
        self.gap(order);
        for index in 0..self.form.auxiliary.len() {
            let Auxiliary { arm, row, direction } = self.form.auxiliary[index];
            let place = self.shape.place(arm);
            let product = self.form.products[arm as usize - self.shape.counts[0]];
            let frame = product.frame as usize;
            let (c, s) = (self.x.as_flattened()[flat(frame, 0)], self.y.as_flattened()[flat(frame, 0)]);
            let [a, b] = direction.map(|part| self.coefficients[part as usize]);
            let (nx, ny) = (a * c - b * s, a * s + b * c);
            let gaps = self.gaps.as_flattened();
            let along = nx * gaps[row as usize] + ny * gaps[row as usize + 1];
            self.values.as_flattened_mut()[first + place] = -along / (nx * nx + ny * ny);
        }
    }

    /// One coefficient of the loop equations, of the first two orders.
    fn gap(&mut self, order: usize) {
        let (all, equations) = (self.shape.all(), self.unknowns.len());
        for lane in 0..all {
            (self.second[0][lane], self.second[1][lane]) = (self.x[at(lane, order)], self.y[at(lane, order)]);
        }
        let [x, y] = [&self.second[0], &self.second[1]].map(|lanes| lanes.as_flattened());
        for (lane, gaps) in self.gaps.iter_mut().enumerate() {
            *gaps = self.rows.dot(lane, x, y, ZERO);
        }
        let gaps = self.gaps.as_flattened_mut();
        let values = self.values[order * all..].as_flattened();
        for &(row, column, factor) in &self.linear_terms {
            gaps[row - equations] += self.coefficients[factor as usize] * values[self.unknowns[column]];
        }
        for (gap, row) in gaps.iter_mut().zip(&self.form.rows) {
            if order == 0 {
                *gap += self.coefficients[row.constant as usize];
            }
            for &(slot, factor) in &row.signals {
                *gap += self.coefficients[factor as usize] * self.scalars.get(slot, order);
            }
        }
    }

    /// The largest gap of the loops at the pose in the unknowns, relative to their scales.
    fn largest_gap(&self, model: &Model) -> f64 {
        let constraints = &model.program().constraints;
        let sizes = self.gaps.as_flattened().iter().zip(&self.form.rows);
        sizes.fold(0.0, |largest, (gap, row)| {
            math::maximum(largest, gap.abs() / constraints[row.constraint as usize].scale)
        })
    }

    /// One Newton step of positions or rates onto the loops, in the metric of the masses.
    fn close(&mut self, model: &Model, order: usize) -> f64 {
        if self.form.rows.is_empty() {
            return 0.0;
        }
        self.gap(order);
        let open = self.largest_gap(model);
        if open <= CLOSED {
            return open;
        }
        self.lack.fill(0.0);
        let gaps = self.gaps.as_flattened();
        for (place, gap) in self.lack[self.unknowns.len()..].iter_mut().zip(gaps) {
            *place = -gap;
        }
        self.solve();
        let all = self.shape.all();
        for (value, change) in self.values[order * all..][..all].iter_mut().zip(&self.solution) {
            *value = add(*value, *change);
        }
        if order == 0 {
            self.turn()
        } else {
            self.turn_rates()
        }
        open
    }

    /// Builds and inverts the matrix of this pose.
    fn factor(&mut self) -> Result<(), Singular> {
        self.differentiate();
        self.inverse.clear();
        let c = &self.coefficients;
        let [dx, dy] = [&self.derivatives[0], &self.derivatives[1]].map(|lanes| lanes.as_flattened());
        for &(row, inertia) in &self.inertia_terms {
            self.inverse.add(row, row, c[inertia as usize]);
        }
        for term in &self.mass_terms {
            let (ax, ay, bx, by) = (dx[term.left], dy[term.left], dx[term.right], dy[term.right]);
            let [re, im] = term.mass.map(|part| c[part as usize]);
            self.inverse.add(term.row, term.column, re * (ax * bx + ay * by) - im * (ax * by - ay * bx));
        }
        for term in &self.loop_terms {
            let [px, py] = term.p.map(|part| c[part as usize]);
            let value = px * dx[term.derivative] + py * dy[term.derivative];
            self.inverse.add(term.row, term.column, value);
        }
        for &(row, column, factor) in &self.linear_terms {
            self.inverse.add(row, column, c[factor as usize]);
        }
        if self.inverse.invert() { Ok(()) } else { Err(Singular) }
    }

    /// Derivatives of the arms by angles (k x b), then by displacements (e).
    fn differentiate(&mut self) {
        let (all, [frames, products, world]) = (self.shape.all(), self.shape.lanes);
        let [dx, dy] = &mut self.derivatives;
        for lane in 0..all {
            dx[lane] = multiply(splat(-1.0), self.y[at(lane, 0)]);
            dy[lane] = self.x[at(lane, 0)];
        }
        for lane in 0..products {
            dx[all + frames + lane] = self.unit[0][at(lane, 0)];
            dy[all + frames + lane] = self.unit[1][at(lane, 0)];
        }
        for lane in 0..world {
            dx[all + frames + products + lane] = splat(1.0);
        }
    }

    /// To be called once after [`Jet::begin`], before the first order.
    pub fn begin_orders(&mut self) {
        for k in 0..2 {
            self.follow(k);
        }
    }

    /// Order k of accelerations, order k + 2 of positions; all lower ones are known.
    pub fn advance(&mut self, k: usize) {
        let vectors = Vectors {
            x: self.x.as_flattened(),
            y: self.y.as_flattened(),
            unknowns: self.values.as_flattened(),
            stride: self.shape.all() * WIDTH,
        };
        self.scalars.rates(k, vectors);
        self.predict(k);
        self.apply_loads(k);
        self.lack_of_balance(k);
        self.solve();
        self.correct(k);
        self.follow(k + 2);
    }

    /// Scalar series of positions.
    fn follow(&mut self, k: usize) {
        let vectors = Vectors {
            x: self.x.as_flattened(),
            y: self.y.as_flattened(),
            unknowns: self.values.as_flattened(),
            stride: self.shape.all() * WIDTH,
        };
        self.scalars.positions(k, vectors);
    }

    /// Second derivatives of the arms without the new accelerations.
    fn predict(&mut self, k: usize) {
        let frames = self.shape.lanes[0];
        let scale = ((k + 1) * (k + 2)) as f64;
        for lane in 0..frames {
            let omega = series(&self.omega, lane, k);
            let [x, y] = [&self.x, &self.y].map(|arms| &series(arms, lane, k + 1)[1..]);
            self.second[0][lane] = multiply(splat(-((k + 1) as f64)), convolve(omega, y));
            self.second[1][lane] = multiply(splat((k + 1) as f64), convolve(omega, x));
        }
        for index in 0..self.special.len() {
            let frame = self.special[index];
            let alpha = scale * self.signal(self.form.frames[frame].signal, k + 2);
            self.accelerate(frame, alpha);
        }
        self.second[0][frames..].fill(ZERO);
        self.second[1][frames..].fill(ZERO);
        if self.shape.counts[1] > 0 {
            self.place_frames(k + 2, scale);
            for lane in 0..self.shape.lanes[1] {
                self.convolve_product(k, lane);
            }
            self.lengthen(k, scale, false);
        }
        if self.shape.counts[2] > 0 {
            self.shift(k, scale, false);
        }
    }

    /// Adds an angular acceleration to the second derivative of a frame's arm.
    #[inline(always)]
    fn accelerate(&mut self, frame: usize, alpha: f64) {
        let (c, s) = (self.x.as_flattened()[flat(frame, 0)], self.y.as_flattened()[flat(frame, 0)]);
        self.second[0].as_flattened_mut()[frame] -= alpha * s;
        self.second[1].as_flattened_mut()[frame] += alpha * c;
    }

    /// Coefficients of the frames' arms from their second derivatives.
    #[inline(always)]
    fn place_frames(&mut self, order: usize, scale: f64) {
        let inverse = splat(1.0 / scale);
        for lane in 0..self.shape.lanes[0] {
            self.x[at(lane, order)] = multiply(inverse, self.second[0][lane]);
            self.y[at(lane, order)] = multiply(inverse, self.second[1][lane]);
        }
    }

    /// sum of sigma_j e_(k+2-j) without its ends.
    #[inline(always)]
    fn convolve_product(&mut self, k: usize, lane: usize) {
        let sigma = &series(&self.sigma, lane, k + 1)[1..];
        for axis in 0..2 {
            self.inner[axis][lane] = convolve(sigma, &series(&self.unit[axis], lane, k + 1)[1..]);
        }
    }

    /// Products at order k + 2, with or without the displacements just found.
    fn lengthen(&mut self, k: usize, scale: f64, found: bool) {
        let (all, order) = (self.shape.all(), k + 2);
        let (first, products) = (self.shape.lanes[0], self.shape.lanes[1]);
        for index in 0..self.shape.counts[1] {
            let product = self.form.products[index];
            self.sigma.as_flattened_mut()[flat(index, order)] = match product.factor {
                Factor::Unknown if found => self.values.as_flattened()[(order * all + first) * WIDTH + index],
                Factor::Unknown => 0.0,
                Factor::Signal(slot) => self.scalars.get(slot, order),
            };
            let frame = flat(product.frame as usize, order);
            self.unit[0].as_flattened_mut()[flat(index, order)] = self.x.as_flattened()[frame];
            self.unit[1].as_flattened_mut()[flat(index, order)] = self.y.as_flattened()[frame];
        }
        for lane in 0..products {
            let sigma = [self.sigma[at(lane, 0)], self.sigma[at(lane, order)]];
            for axis in 0..2 {
                let unit = [self.unit[axis][at(lane, 0)], self.unit[axis][at(lane, order)]];
                let b = plus(plus(self.inner[axis][lane], sigma[1], unit[0]), sigma[0], unit[1]);
                self.second[axis][first + lane] = multiply(splat(scale), b);
                let arms = if axis == 0 { &mut self.x } else { &mut self.y };
                arms[at(first + lane, order)] = b;
            }
        }
    }

    /// World arms at order k + 2, with or without the displacements just found.
    fn shift(&mut self, k: usize, scale: f64, found: bool) {
        let (all, order) = (self.shape.all(), k + 2);
        let first = (self.shape.lanes[0] + self.shape.lanes[1]) * WIDTH;
        for index in 0..self.shape.counts[2] {
            let sigma = match self.form.world[index] {
                Factor::Unknown if found => self.values.as_flattened()[order * all * WIDTH + first + index],
                Factor::Unknown => 0.0,
                Factor::Signal(slot) => self.scalars.get(slot, order),
            };
            self.x.as_flattened_mut()[flat(first + index, order)] = sigma;
            self.second[0].as_flattened_mut()[first + index] = scale * sigma;
        }
    }

    /// Minus the loads on arms, and what torques leave.
    fn apply_loads(&mut self, k: usize) {
        self.applied.iter_mut().for_each(|lanes| lanes.fill(ZERO));
        let [x, y] = &mut self.applied;
        let (x, y) = (x.as_flattened_mut(), y.as_flattened_mut());
        for load in &self.loads[if k == 0 { 0 } else { self.constant_loads }..] {
            let value = load.value.map_or(1.0, |slot| self.scalars.get(slot, k));
            let [fx, fy] = load.factors.map(|factor| self.coefficients[factor as usize]);
            x[load.place] -= fx * value;
            y[load.place] -= fy * value;
        }
    }

    /// What the equations lack without the new accelerations and reactions.
    fn lack_of_balance(&mut self, k: usize) {
        let (all, [frames, products, _]) = (self.shape.all(), self.shape.lanes);
        let [x, y] = [&self.second[0], &self.second[1]].map(|lanes| lanes.as_flattened());
        for lane in 0..all {
            let applied = [self.applied[0][lane], self.applied[1][lane]];
            [self.force[0][at(lane, k)], self.force[1][at(lane, k)]] = self.coupling.complex(lane, x, y, applied);
        }
        for lane in 0..self.gaps.len() {
            self.gaps[lane] = self.rows.dot(lane, x, y, ZERO);
        }
        for lane in 0..frames {
            self.lack_lanes[lane] = self.moment(k, lane);
        }
        for lane in 0..products {
            self.lack_lanes[frames + lane] = self.pull(k, lane);
        }
        for lane in frames + products..all {
            self.lack_lanes[lane] = self.force[0][at(lane, k)];
        }
        self.scatter_moments(k);
        let lack = self.lack_lanes.as_flattened_mut();
        for push in &self.pushes[if k == 0 { 0 } else { self.constant_pushes }..] {
            let value = push.value.map_or(1.0, |slot| self.scalars.get(slot, k));
            lack[push.place] -= self.coefficients[push.factors[0] as usize] * value;
        }
        for (place, unknown) in self.lack.iter_mut().zip(&self.unknowns) {
            *place = -lack[*unknown];
        }
        let scale = ((k + 1) * (k + 2)) as f64;
        let gaps = self.gaps.as_flattened();
        for ((place, gap), row) in self.lack[self.unknowns.len()..].iter_mut().zip(gaps).zip(&self.form.rows) {
            *place = -gap;
            for &(slot, factor) in &row.signals {
                *place -= self.coefficients[factor as usize] * (scale * self.scalars.get(slot, k + 2));
            }
        }
    }

    /// Order k of b x G.
    #[inline(always)]
    fn moment(&self, k: usize, lane: usize) -> Lane {
        let left = convolve(series(&self.x, lane, k), series(&self.force[1], lane, k));
        let right = convolve(series(&self.y, lane, k), series(&self.force[0], lane, k));
        subtract(left, right)
    }

    /// Order k of e . G for products.
    #[inline(always)]
    fn pull(&self, k: usize, lane: usize) -> Lane {
        let arm = self.shape.lanes[0] + lane;
        let left = convolve(series(&self.unit[0], lane, k), series(&self.force[0], arm, k));
        let right = convolve(series(&self.unit[1], lane, k), series(&self.force[1], arm, k));
        add(left, right)
    }

    /// Moments that belong to the unknown of another place: those of products and of frames that share an angle.
    fn scatter_moments(&mut self, k: usize) {
        let scale = ((k + 1) * (k + 2)) as f64;
        for &frame in &self.special {
            let Some(place) = self.turned_by[frame] else { continue };
            let alpha = scale * self.signal(self.form.frames[frame].signal, k + 2);
            let own = self.lack_lanes.as_flattened()[frame];
            let lack = self.lack_lanes.as_flattened_mut();
            lack[place] += self.inertia.as_flattened()[frame] * alpha + if place == frame { 0.0 } else { own };
        }
        let frames = self.shape.lanes[0];
        for lane in 0..self.shape.lanes[1] {
            let moment = self.moment(k, frames + lane);
            let first = lane * WIDTH;
            let count = self.shape.counts[1].saturating_sub(first).min(WIDTH);
            for (product, moment) in self.form.products[first..first + count].iter().zip(moment) {
                if let Some(place) = self.turned_by[product.frame as usize] {
                    self.lack_lanes.as_flattened_mut()[place] += moment;
                }
            }
        }
    }

    /// Accelerations and reactions from what the equations lack.
    #[inline(always)]
    fn solve(&mut self) {
        self.inverse.times(&self.lack, &mut self.solution);
    }

    /// Everything at the new order.
    fn correct(&mut self, k: usize) {
        let (all, frames) = (self.shape.all(), self.shape.lanes[0]);
        let scale = ((k + 1) * (k + 2)) as f64;
        let (inverse, share) = (splat(1.0 / scale), splat(1.0 / (k + 1) as f64));
        for lane in 0..all {
            self.values[(k + 2) * all + lane] = multiply(inverse, self.solution[lane]);
        }
        for lane in 0..frames {
            let alpha = self.solution[lane];
            self.omega[at(lane, k + 1)] = multiply(share, alpha);
            self.second[0][lane] = minus(self.second[0][lane], alpha, self.y[at(lane, 0)]);
            self.second[1][lane] = plus(self.second[1][lane], alpha, self.x[at(lane, 0)]);
        }
        for index in 0..self.special.len() {
            let frame = self.special[index];
            let own = self.turned_by[frame].map_or(0.0, |place| self.solution.as_flattened()[place]);
            let signal = scale * self.signal(self.form.frames[frame].signal, k + 2);
            self.omega.as_flattened_mut()[flat(frame, k + 1)] = (own + signal) * share[0];
            if self.turned_by[frame] != Some(frame) {
                self.accelerate(frame, own);
            }
        }
        self.place_frames(k + 2, scale);
        if self.shape.counts[1] > 0 {
            self.lengthen(k, scale, true);
        }
        if self.shape.counts[2] > 0 {
            self.shift(k, scale, true);
        }
        let [x, y] = [&self.second[0], &self.second[1]].map(|lanes| lanes.as_flattened());
        let reactions = self.solution[all..].as_flattened();
        for lane in 0..all {
            let applied = [self.applied[0][lane], self.applied[1][lane]];
            let force = self.reactions.real(lane, reactions, applied);
            [self.force[0][at(lane, k)], self.force[1][at(lane, k)]] = self.coupling.complex(lane, x, y, force);
        }
    }
}

/// sum a_j b_(k-j)
#[inline(always)]
fn convolve(a: &[Lane], b: &[Lane]) -> Lane {
    let (mut even, mut odd) = (ZERO, ZERO);
    let (mut left, mut right) = (a.chunks_exact(2), b.rchunks_exact(2));
    for (a, b) in (&mut left).zip(&mut right) {
        even = plus(even, a[0], b[1]);
        odd = plus(odd, a[1], b[0]);
    }
    if let ([a], [b]) = (left.remainder(), right.remainder()) {
        even = plus(even, *a, *b);
    }
    add(even, odd)
}

/// Places of the unknowns: angles, then displacements.
fn unknowns(form: &ArmForm, shape: &Shape) -> Vec<usize> {
    let own =
        |(index, frame): (usize, &super::form::Frame)| (frame.unknown == Some(index as u32)).then_some(index as u32);
    let frames = form.frames.iter().enumerate().filter_map(own);
    let products = form.products.iter().map(|product| product.factor);
    let lengths = products.chain(form.world.iter().copied()).enumerate();
    let displacements = lengths.filter(|(_, factor)| *factor == Factor::Unknown);
    let displacements = displacements.map(|(index, _)| (form.frames.len() + index) as u32);
    frames.chain(displacements).map(|arm| shape.place(arm)).collect()
}

/// Coordinates, what carries an angle before what it carries.
pub(super) fn chain(form: &ArmForm) -> Vec<usize> {
    let mut known = vec![false; form.frames.len()];
    let mut rest: Vec<usize> = (0..form.coordinates.len()).collect();
    let mut chain = Vec::new();
    while !rest.is_empty() {
        let before = rest.len();
        rest.retain(|&index| {
            let ready = match form.coordinates[index] {
                Place::Angle { parent: Some(parent), .. } => known[parent as usize],
                _ => true,
            };
            if let (true, Place::Angle { arm, .. }) = (ready, form.coordinates[index]) {
                known[arm as usize] = true;
            }
            if ready {
                chain.push(index);
            }
            !ready
        });
        if rest.len() == before {
            break;
        }
    }
    chain
}
