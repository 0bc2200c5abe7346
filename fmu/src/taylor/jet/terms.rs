//! What the entries of \[M J^T; J 0\] are made of.

use super::Shape;
use super::curves::CurveSlope;
use super::pairs::{Pairs, candidates};
use crate::linalg::columns::Columns;
use crate::linalg::lane::{Lane, minus, multiply, plus, splat};
use crate::linalg::matrix::{Entries, Lanes, Places};
use crate::linalg::number::{Elementary, Number};
use crate::program::arm_form::{ArmForm, Factor};

/// Masses that differ by more than this factor ask for a search for pivots.
const ALIKE: f64 = 1e4;

/// How an arm changes with an unknown: place of the unknown, place of the derivative.
type Touch = (usize, usize);

/// Part of an entry.
#[derive(Clone, Copy, Debug)]
struct Term<T> {
    row: usize,
    column: usize,
    places: Places,
    value: T,
}

/// derivative . A derivative
#[derive(Clone, Copy, Debug)]
struct Mass {
    left: usize,
    right: usize,
    mass: [u32; 2],
}

/// p . derivative
#[derive(Clone, Copy, Debug)]
pub(super) struct Slope {
    pub(super) derivative: usize,
    p: [u32; 2],
}

impl Slope {
    #[inline(always)]
    pub(super) fn value<N: Number>(&self, c: &[N], [dx, dy]: [&[N]; 2]) -> N {
        let (px, py) = (c[self.p[0] as usize], c[self.p[1] as usize]);
        px * dx[self.derivative] + py * dy[self.derivative]
    }

    /// The largest value for a derivative of length 1.
    pub(super) fn size(&self, c: &[f64]) -> f64 {
        let [x, y] = self.p.map(|part| c[part as usize]);
        (x * x + y * y).sqrt()
    }
}

/// All terms, by kind.
#[derive(Clone, Debug, Default)]
pub(super) struct Terms<N = f64> {
    inertia: Vec<Term<u32>>,
    masses: Vec<Term<Mass>>,
    loops: Vec<Term<Slope>>,
    linear: Vec<Term<u32>>,
    /// Slopes of loop equations that are no constants, by their numbers, and the slopes of the pose.
    curves: Vec<Term<usize>>,
    pub(super) curve_slopes: Vec<N>,
    /// Entries on the diagonal: of loop equations that hold on one side only.
    diagonal: Vec<Term<u32>>,
    pub(super) pairs: Pairs<N>,
    /// Row, place of the unknown, and its factor.
    sums: Vec<(usize, usize, u32)>,
    /// Storage of [`Self::are_alike`].
    resisting: Vec<(f64, bool)>,
}

impl<T> Term<T> {
    fn new(row: usize, column: usize, value: T) -> Self {
        Self { row, column, places: [0; 2], value }
    }
}

/// Where unknowns and arms lie.
pub(super) struct Plan<'a> {
    form: &'a ArmForm,
    shape: &'a Shape,
    turned_by: &'a [Option<usize>],
    /// The equation of the unknown at each place.
    equations: Vec<Option<usize>>,
    /// Places of the unknowns that have one, by equations.
    pub(super) unknowns: Vec<usize>,
    /// The equation of each row; none of the second one of a pair.
    pub(super) rows: Vec<Option<usize>>,
    /// First rows of pairs, and places of the unknowns that go with them.
    pairs: Vec<(usize, usize)>,
}

impl<'a> Plan<'a> {
    pub(super) fn new(form: &'a ArmForm, shape: &'a Shape, turned_by: &'a [Option<usize>], unknowns: &[usize]) -> Self {
        let mut plan = Self {
            form,
            shape,
            turned_by,
            equations: vec![None; shape.places()],
            unknowns: Vec::new(),
            rows: vec![None; form.rows.len()],
            pairs: Vec::new(),
        };
        for (row, place) in candidates(form, |arm| shape.place(arm)) {
            let is_new = plan.pairs.iter().all(|(known, _)| *known != row);
            if is_new && plan.is_free(row, place) {
                plan.pairs.push((row, place));
            }
        }
        plan.unknowns =
            unknowns.iter().copied().filter(|place| plan.pairs.iter().all(|pair| pair.1 != *place)).collect();
        for (equation, &place) in plan.unknowns.iter().enumerate() {
            plan.equations[place] = Some(equation);
        }
        let mut next = plan.unknowns.len();
        for row in 0..form.rows.len() {
            if plan.pairs.iter().all(|(first, _)| first + 1 != row) {
                plan.rows[row] = Some(next);
                next += 1;
            }
        }
        plan
    }

    /// Is there neither a mass at the unknown of a place, nor another row than these two that it is in?
    fn is_free(&self, row: usize, place: usize) -> bool {
        let moves = |arm: u32| self.touches(arm).any(|(unknown, _)| unknown == place);
        let masses = self.form.coupling.iter().any(|entry| moves(entry.on) || moves(entry.from));
        let others = (0..self.form.rows.len()).filter(|other| !(row..row + 2).contains(other));
        let mut others = others.flat_map(|other| {
            let linear = self.linear(other).map(|(unknown, _)| unknown);
            self.slopes(other).map(|(unknown, _)| unknown).chain(linear).collect::<Vec<usize>>()
        });
        let acts_on_row =
            (row..row + 2).flat_map(|row_index| self.linear(row_index)).any(|(unknown, _)| unknown == place);
        !masses && !acts_on_row && others.all(|unknown| unknown != place)
    }

    pub(super) fn equation(&self, place: usize) -> Option<usize> {
        self.equations.get(place).copied().flatten()
    }

    /// Places of the unknowns that move the arms of a row, and how.
    pub(super) fn slopes(&self, row: usize) -> impl Iterator<Item = (usize, Slope)> {
        let arms = self.form.rows[row].arms.iter();
        arms.flat_map(|&(arm, p)| self.touches(arm).map(move |(place, derivative)| (place, Slope { derivative, p })))
    }

    /// Places of the unknowns that a row contains themselves, and their factors.
    pub(super) fn linear(&self, row: usize) -> impl Iterator<Item = (usize, u32)> {
        self.form.rows[row].unknowns.iter().map(|&(unknown, factor)| (self.shape.place(unknown), factor))
    }

    /// Unknowns that move an arm, with the places of the derivatives.
    fn touches(&self, arm: u32) -> impl Iterator<Item = Touch> {
        let place = self.shape.place(arm);
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
        let turning = frame.and_then(|frame| self.turned_by[frame]);
        let slide = (factor == Some(Factor::Unknown)).then(|| (place, self.shape.places() + place));
        turning.map(|unknown| (unknown, place)).into_iter().chain(slide)
    }
}

impl<N: Elementary> Terms<N> {
    pub(super) fn new(plan: &Plan, curves: &[CurveSlope<N>]) -> Self {
        let mut terms = Self { curve_slopes: vec![N::ZERO; curves.len()], ..Self::default() };
        for (number, curve) in curves.iter().enumerate() {
            let entry = plan.rows[curve.row].zip(plan.equation(curve.place));
            terms.curves.extend(entry.map(|(row, column)| Term::new(row, column, number)));
        }
        let touches = |arm: u32| {
            let known = move |(unknown, derivative)| Some((plan.equation(unknown)?, derivative));
            plan.touches(arm).filter_map(known)
        };
        for entry in &plan.form.coupling {
            for (row, left) in touches(entry.on) {
                for (column, right) in touches(entry.from).filter(|(column, _)| row <= *column) {
                    terms.masses.push(Term::new(row, column, Mass { left, right, mass: entry.mass }));
                }
            }
        }
        for (frame, turned_by) in plan.form.frames.iter().zip(plan.turned_by) {
            if let Some(row) = turned_by.and_then(|place| plan.equation(place)) {
                terms.inertia.push(Term::new(row, row, frame.inertia));
            }
        }
        for (index, equation) in plan.rows.iter().enumerate() {
            terms.sums.extend(plan.linear(index).map(|(place, factor)| (index, place, factor)));
            let pair = plan.pairs.iter().find(|(first, _)| (*first..first + 2).contains(&index));
            let Some(row) = *equation else { continue };
            if let Some(&(_, place)) = pair {
                terms.pairs.add(plan, index, row, place);
                continue;
            }
            let column = |(place, value)| Some(Term::new(row, plan.equation(place)?, value));
            terms.loops.extend(plan.slopes(index).filter_map(column));
            let column = |(place, value)| Some(Term::new(row, plan.equation(place)?, value));
            terms.linear.extend(plan.linear(index).filter_map(column));
            let openings = plan.form.contacts.iter().filter(|contact| contact.row as usize == index);
            terms.diagonal.extend(openings.map(|contact| Term::new(row, row, contact.open)));
        }
        terms
    }

    /// Rows and columns of the entries.
    pub(super) fn entries(&self) -> impl Iterator<Item = (usize, usize)> {
        let masses = self.masses.iter().map(|term| (term.row, term.column));
        let loops = self.loops.iter().map(|term| (term.row, term.column));
        let curves = self.curves.iter().map(|term| (term.row, term.column));
        let rest = self.inertia.iter().chain(&self.linear).chain(&self.diagonal).map(|term| (term.row, term.column));
        masses.chain(loops).chain(curves).chain(rest).chain(self.pairs.entries())
    }

    /// Entries go to their places in this matrix from now on.
    pub(super) fn aim(&mut self, places: impl Fn(usize, usize) -> Places) {
        for term in self.inertia.iter_mut().chain(&mut self.linear).chain(&mut self.diagonal) {
            term.places = places(term.row, term.column);
        }
        for term in &mut self.masses {
            term.places = places(term.row, term.column);
        }
        for term in &mut self.curves {
            term.places = places(term.row, term.column);
        }
        for term in &mut self.loops {
            term.places = places(term.row, term.column);
        }
        self.pairs.aim(places);
    }

    /// Is none of the masses that resist the unknowns by themselves much smaller than another of its kind: inertias of angles, masses of
    /// displacements?
    pub(super) fn are_alike(&mut self, c: &[N], unknowns: usize, frames: usize) -> bool {
        // Storage is kept: coefficients change where an event opens or closes something.
        let mut masses = std::mem::take(&mut self.resisting);
        masses.clear();
        masses.resize(unknowns, (0.0, false));
        for term in &self.inertia {
            masses[term.row] = (masses[term.row].0 + c[term.value as usize].value(), true);
        }
        for term in self.masses.iter().filter(|term| term.row == term.column && term.value.left == term.value.right) {
            // The arm of a frame is as long as the mass is far away; that of a product changes, and its mass resists both unknowns.
            let (mass, turns) = (c[term.value.mass[0] as usize].value(), term.value.left < frames);
            masses[term.row] = (masses[term.row].0 + mass, masses[term.row].1 || turns);
        }
        let largest = |kind: bool| {
            let of_kind = masses.iter().filter(|(_, turns)| *turns == kind);
            of_kind.fold(0.0, |largest: f64, (mass, _)| largest.max(*mass))
        };
        let largest = [largest(false), largest(true)];
        let alike = masses.iter().all(|&(mass, turns)| mass > 0.0 && ALIKE * mass >= largest[usize::from(turns)]);
        self.resisting = masses;
        alike
    }

    /// The diagonal of the masses.
    pub(super) fn diagonal(&self, c: &[N], [dx, dy]: [&[N]; 2], masses: &mut [N]) {
        masses.fill(N::ZERO);
        for term in &self.inertia {
            masses[term.row] += c[term.value as usize];
        }
        for Term { row, value: Mass { left, right, mass }, .. } in
            self.masses.iter().filter(|term| term.row == term.column)
        {
            let (re, im) = (c[mass[0] as usize], c[mass[1] as usize]);
            let (ax, ay, bx, by) = (dx[*left], dy[*left], dx[*right], dy[*right]);
            masses[*row] += re * (ax * bx + ay * by) - im * (ax * by - ay * bx);
        }
    }

    /// (row, place, coefficient) of what loop equations contain of unknowns themselves.
    pub(super) fn linear(&self) -> impl Iterator<Item = (usize, usize, u32)> {
        self.sums.iter().copied()
    }

    /// Adds all entries up.
    #[inline(always)]
    pub(super) fn assemble(&mut self, matrix: &mut impl Entries<N>, c: &[N], derivatives: [&[N]; 2]) {
        self.add_masses(matrix, c, derivatives);
        self.assemble_rest(matrix, c, derivatives);
    }

    #[inline(always)]
    fn add_masses(&self, matrix: &mut impl Entries<N>, c: &[N], [dx, dy]: [&[N]; 2]) {
        for Term { places, value: Mass { left, right, mass }, .. } in &self.masses {
            let (ax, ay, bx, by) = (dx[*left], dy[*left], dx[*right], dy[*right]);
            let (re, im) = (c[mass[0] as usize], c[mass[1] as usize]);
            matrix.add(*places, re * (ax * bx + ay * by) - im * (ax * by - ay * bx));
        }
    }

    /// All but the masses between arms: inertias and loop equations.
    #[inline(always)]
    fn assemble_rest(&mut self, matrix: &mut impl Entries<N>, c: &[N], derivatives: [&[N]; 2]) {
        for term in &self.inertia {
            matrix.add(term.places, c[term.value as usize]);
        }
        for term in &self.loops {
            matrix.add(term.places, term.value.value(c, derivatives));
        }
        for term in self.linear.iter().chain(&self.diagonal) {
            matrix.add(term.places, c[term.value as usize]);
        }
        for term in &self.curves {
            matrix.add(term.places, self.curve_slopes[term.value]);
        }
        if !self.pairs.is_empty() {
            self.pairs.assemble(matrix, c, derivatives);
        }
    }
}

impl Terms {
    /// What the entries of loop equations are made of that changes: row, column, and how.
    pub(super) fn slopes(&self) -> impl Iterator<Item = (usize, usize, &Slope)> {
        self.loops.iter().map(|term| (term.row, term.column, &term.value))
    }
}

impl<N: Elementary> Terms<N> {
    /// The same of frames only, whose arms are x + i y: an entry of the masses for every two of them, a lane at a time.
    #[inline(always)]
    pub(super) fn assemble_frames<const L: usize>(
        &mut self,
        matrix: &mut impl Lanes<N, L>,
        c: &[N],
        derivatives: &[Vec<Lane<N, L>>; 2],
        coupling: &Columns<N, L>,
    ) {
        let [dx, dy] = derivatives;
        for lane in 0..dx.len().min(dy.len()).min(coupling.lanes()) {
            let (ax, ay) = (dx[lane], dy[lane]);
            let (columns, re, im) = coupling.lane(lane);
            for i in 0..columns.len() {
                let (bx, by) = (splat(dx.as_flattened()[columns[i]]), splat(dy.as_flattened()[columns[i]]));
                let along = plus(multiply(ax, bx), ay, by);
                let across = minus(multiply(ax, by), ay, bx);
                matrix.put(columns[i], lane, minus(multiply(re[i], along), im[i], across));
            }
        }
        self.assemble_rest(matrix, c, [dx.as_flattened(), dy.as_flattened()]);
    }
}
