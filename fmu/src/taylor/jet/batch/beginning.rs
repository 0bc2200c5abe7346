//! The beginnings of series that motions are going to ask for: at the ends of the steps that they are about to take.

use std::ops::Range;

use super::{Batch, MEMBERS, POSITIONS};
use crate::linalg::inverses::Members;
use crate::linalg::lane::{WIDTH, by_width};
use crate::linalg::matrix::Matrix;
use crate::linalg::number::Number;
use crate::linalg::quad::Quad;
use crate::math;
use crate::model::Model;
use crate::taylor::jet::Jet;
use crate::taylor::jet::start::{CLOSED, SMALL, flattened};
use crate::taylor::tape::polynomial;

/// What a batch has found for the series of one motion.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    /// The last order of the unknowns that is known already; 0 if none.
    pub orders: usize,
    /// A tolerance on rates, and the step that it permits along these orders.
    pub length: [f64; 2],
    /// Where the series begins, if that is in a batch: the jet has the unknowns and the inverse of the beginning, but not its arms.
    holder: Holder,
    /// The beginning that the motion is expected to ask for.
    next: Option<Box<Beginning>>,
}

/// Where a beginning is: the number of a batch and of the beginnings there; zeros for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Holder {
    batch: u64,
    count: u64,
}

/// What a motion needs of the beginning of a series.
#[derive(Clone, Debug, Default)]
struct Beginning {
    /// (q, v) and the time; NaN if there is none.
    time: f64,
    motion: Vec<f64>,
    holder: Holder,
    /// How far loops are open.
    open: f64,
    /// How long the step is that ends there; NaN if its end must be found again.
    length: f64,
    /// Twice the accelerations of the step's polynomial there, as [`Jet::evaluate`] leaves them.
    end: Vec<f64>,
    /// The first orders of the unknowns.
    values: Vec<f64>,
    inverse: Vec<f64>,
}

/// How poses are to be inverted, and what permits to do that together.
#[derive(Debug)]
pub(super) struct Rules {
    /// True if beginnings can be found together.
    begins: bool,
    /// True if there are frames only, and states.
    frames: bool,
    /// The masses of these members are alike.
    alike: Members,
    /// Integrals among the coordinates.
    integrals: Range<usize>,
}

impl Rules {
    /// The rules of a model.
    pub fn new(model: &Model, alone: &Jet) -> Self {
        let begins = alone.form.repeating() == 0 && alone.direction_rows.is_empty() && alone.limits.is_empty();
        let integrals = model.mechanical()..model.coordinates();
        Self { begins, frames: alone.frames[0] > 0, alike: [false; WIDTH], integrals }
    }

    /// Takes over what depends on one motion's parameters.
    pub fn take(&mut self, member: usize, jet: &Jet) {
        self.alike[member] = jet.layout.is_some_and(|layout| layout.alike);
    }
}

impl Found {
    /// The series begins elsewhere.
    pub fn leave(&mut self) {
        (self.orders, self.holder) = (0, Holder::default());
    }

    /// The step that a tolerance on rates permits, if that is known.
    #[inline(always)]
    pub fn length(&self, order: usize, tolerance: f64) -> Option<f64> {
        let [known, length] = self.length;
        (self.orders == order && known == tolerance).then_some(length)
    }

    /// True if its arms are in a batch.
    pub fn is_held(&self) -> bool {
        self.holder != Holder::default()
    }

    /// True if a batch has them.
    pub fn is_held_by(&self, holder: Holder) -> bool {
        self.holder == holder
    }
}

impl Jet {
    /// True if the series begins in a batch: the jet cannot find further orders than [`Self::known_orders`].
    pub fn is_held(&self) -> bool {
        self.found.is_held()
    }

    /// The last order that a batch has found.
    pub fn known_orders(&self) -> usize {
        self.found.orders
    }

    /// No beginning found before counts any longer.
    pub fn forget_beginning(&mut self) {
        if let Some(next) = &mut self.found.next {
            next.time = f64::NAN;
        }
    }

    /// (q, v) at the end of a step along the orders that a batch has found, and its accelerations as [`Jet::evaluate`] leaves them; false if the batch has not been there.
    pub fn end_found(&mut self, time: f64, length: f64, motion: &mut [f64]) -> bool {
        let Some(next) = self.found.next.as_deref().filter(|next| next.time == time && next.length == length) else {
            return false;
        };
        motion.copy_from_slice(&next.motion);
        self.end[2].as_flattened_mut().copy_from_slice(&next.end);
        true
    }

    /// Begins where a batch has begun for this motion, if it has; says how far the loops were open.
    pub fn begin_found(&mut self, time: f64, motion: &[f64]) -> Option<f64> {
        let next = self.found.next.as_deref_mut().filter(|next| next.time == time)?;
        let Matrix::Whole(inverse) = &mut self.matrix else { return None };
        let same = next.motion.iter().zip(motion).all(|(known, value)| known.to_bits() == value.to_bits());
        if !same {
            return None;
        }
        next.time = f64::NAN;
        inverse.take(&next.inverse);
        self.values.as_flattened_mut()[..next.values.len()].copy_from_slice(&next.values);
        (self.found.orders, self.found.holder) = (0, next.holder);
        let open = next.open;
        self.weigh();
        Some(open)
    }
}

impl Batch {
    /// True if beginnings can be found here.
    pub fn begins(&self) -> bool {
        self.rules.begins
    }

    /// True if anything depends on time or inputs.
    pub fn has_signals(&self) -> bool {
        self.series.scalars.has_given()
    }

    /// Takes the signals over with which the series of one motion is to begin.
    pub fn set_signals(&mut self, member: usize, model: &Model, registers: &[f64]) {
        self.series.scalars.set_given(member, |given| polynomial(model, registers, given));
    }

    /// Begins the series of members at the ends of steps of these lengths, along the orders just found; those that cannot go on together leave. Says how far their loops are open.
    pub fn begin(&mut self, steps: Quad, members: &mut Members) -> Quad {
        for holder in &mut self.holders {
            self.count += 1;
            *holder = Holder { batch: self.number, count: self.count };
        }
        self.taken = false;
        self.begin_together(steps, members)
    }

    by_width! {
        fn begin_together(&mut self: Batch, steps: Quad, members: &mut Members) -> Quad = begin_any
    }

    #[inline(always)]
    fn begin_any(&mut self, steps: Quad, members: &mut Members) -> Quad {
        let Self { series, motion, rules, order, .. } = self;
        let polynomial = std::mem::take(&mut series.values);
        series.evaluate_any(polynomial.as_flattened(), *order, steps, motion);
        series.values = polynomial;
        motion[rules.integrals.clone()].fill(Quad::ZERO);
        let (q, v) = motion.split_at(motion.len() / 2);
        series.scalars.restart(2);
        series.load(0, q);
        series.turn();
        series.factor_together(rules, members);
        series.load(1, v);
        let open = series.close_together(0, members);
        series.turn_rates();
        series.close_together(1, members);
        series.follow(0);
        series.follow(1);
        series.respond_together();
        series.advance_together(0, 0);
        open
    }

    /// Hands a beginning over to the motion that is expected to ask for it, at this time.
    pub fn give_beginning(&self, member: usize, jet: &mut Jet, [time, length]: [f64; 2], open: Quad) {
        let (count, all) = (self.places.len(), jet.shape.places());
        let next = jet.found.next.get_or_insert_default();
        next.motion.resize(self.motion.len(), 0.0);
        next.values.resize(POSITIONS[1] * all, 0.0);
        next.inverse.resize(self.series.residual.len().pow(2), 0.0);
        next.end.resize(all, 0.0);
        next.length = if self.rules.integrals.is_empty() { length } else { f64::NAN };
        for ([value], place) in self.series.end[2].iter().zip(&self.places) {
            next.end[*place] = value.get(member);
        }
        (next.time, next.open, next.holder) = (time, open.get(member), self.holders[member]);
        for (place, value) in next.motion.iter_mut().zip(&self.motion) {
            *place = value.get(member);
        }
        let found = self.series.values.as_flattened();
        for order in 0..POSITIONS[1] {
            let values = &mut next.values[order * all..][..all];
            for (value, place) in found[order * count..].iter().zip(&self.places) {
                values[*place] = value.get(member);
            }
        }
        self.series.matrix.give(member, &mut next.inverse);
    }
}

impl Jet<Quad, 1> {
    /// [`Jet::factor`] of the motions that go on.
    #[inline(always)]
    fn factor_together(&mut self, rules: &Rules, members: &mut Members) {
        self.differentiate();
        let Self { matrix, terms, coefficients, derivatives, coupling, .. } = self;
        matrix.clear();
        if rules.frames {
            terms.assemble_frames(matrix, coefficients, derivatives, coupling.entries());
        } else {
            terms.assemble(matrix, coefficients, flattened(derivatives));
        }
        let first = (0..MEMBERS).find(|member| members[*member]);
        let alike = first.is_some_and(|first| rules.alike[first]);
        (0..MEMBERS).for_each(|member| members[member] &= rules.alike[member] == alike);
        if alike && self.residual.len() > WIDTH {
            matrix.invert_in_order(members);
        } else {
            matrix.invert(members);
        }
    }

    /// One Newton step onto the loops for the motions whose loops are open; a motion that needs another way than the others leaves. Returns how far they were open.
    #[inline(always)]
    fn close_together(&mut self, order: usize, members: &mut Members) -> Quad {
        if self.form.rows.is_empty() {
            return Quad::ZERO;
        }
        self.gap(order);
        let mut open = Quad::ZERO;
        for (gap, scale) in self.gaps.as_flattened().iter().zip(&self.row_scales) {
            open = open.with(gap.map(|gap| gap.abs() / scale), math::maximum);
        }
        let mut moves = *members;
        for member in 0..MEMBERS {
            // Written so that NaN is open.
            let is_closed = open.get(member) <= CLOSED;
            moves[member] &= !is_closed;
        }
        if moves == [false; WIDTH] {
            return open;
        }
        self.respond_to_gaps();
        let all = self.shape.all();
        for (value, change) in self.values[order * all..].iter_mut().zip(&mut self.solution[..all]) {
            change[0] = Quad::ZERO.replaced(change[0], moves);
            value[0] = value[0].replaced(value[0] + change[0], moves);
        }
        if order == 1 {
            self.turn_rates();
        } else if self.special.is_empty() && self.moves_little(&moves, members) {
            self.turn_a_little();
        } else {
            self.turn();
        }
        open
    }

    /// Are the changes that the solution holds small? The motions that move otherwise than the first one leave.
    #[inline(always)]
    fn moves_little(&self, moves: &Members, members: &mut Members) -> bool {
        let mut change = Quad::ZERO;
        for [part] in &self.solution[..self.shape.all()] {
            change = change.larger(*part);
        }
        let mut first = None;
        for member in (0..MEMBERS).filter(|member| moves[*member]) {
            let is_small = change.get(member) < SMALL;
            members[member] &= *first.get_or_insert(is_small) == is_small;
        }
        first.unwrap_or(true)
    }
}
