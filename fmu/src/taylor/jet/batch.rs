//! The series of four motions of one model at a time, with the bits that each motion's own jet finds.
//!
//! How long a step is and whether it is accepted is up to each motion. The series that is to begin at the end of its step is found here before the motion asks for it.

mod beginning;
mod steps;

use std::sync::atomic::{AtomicU64, Ordering};

use super::{Coefficient, Jet, ORDERS, Shape, flat, vectors};
use crate::linalg::inverses::Inverses;
use crate::linalg::lane::{Lane, WIDTH, by_width};
use crate::linalg::matrix::Matrix;
use crate::linalg::quad::Quad;
use crate::model::Model;
pub(super) use beginning::Found;
use beginning::{Holder, Rules};
use steps::Steps;

/// Motions whose series are found together.
pub(crate) const MEMBERS: usize = WIDTH;

/// The orders that the beginning of a series leaves: of positions, of rates, and of forces. The last two are stored the other way round.
const POSITIONS: [usize; 2] = [0, 3];
const RATES: [usize; 2] = [ORDERS - 2, ORDERS];
const FORCES: [usize; 2] = [ORDERS - 1, ORDERS];

/// What a method for so many frames, and so many equations in all, gives; none for other numbers of them.
macro_rules! of_few {
    ($jet:ident.$method:ident($($argument:expr),*)) => {
        match $jet.frames {
            [1, 1, 1] => Some($jet.$method::<1, 1, 1>($($argument),*)),
            [2, 2, 2] => Some($jet.$method::<2, 2, 2>($($argument),*)),
            [2, 2, 3] => Some($jet.$method::<2, 2, 3>($($argument),*)),
            [3, 3, 3] => Some($jet.$method::<3, 3, 3>($($argument),*)),
            [3, 3, 5] => Some($jet.$method::<3, 3, 5>($($argument),*)),
            [4, 4, 4] => Some($jet.$method::<4, 4, 4>($($argument),*)),
            [4, 4, 6] => Some($jet.$method::<4, 4, 6>($($argument),*)),
            _ => None,
        }
    };
}

/// Batches are numbered: a beginning is found again where it was left.
static BATCHES: AtomicU64 = AtomicU64::new(1);

impl Coefficient for Quad {
    type Matrix = Inverses;
}

/// The series of some motions, each with its own parameters and its own pose.
#[derive(Debug)]
pub(crate) struct Batch {
    series: Jet<Quad, 1>,
    /// Where the arms of a motion's own series lie.
    places: Vec<usize>,
    /// Have coefficients changed?
    changed: bool,
    /// Has a beginning been taken over since the last orders?
    taken: bool,
    rules: Rules,
    steps: Steps,
    /// The last order found.
    order: usize,
    /// The number of the batch and of its last beginnings, and which of them the numbers of each member are.
    number: u64,
    count: u64,
    holders: [Holder; MEMBERS],
    /// (q, v) where the next series begin.
    motion: Vec<Quad>,
}

impl Batch {
    /// Storage, if a model's series need no decisions and no operation that the series of one motion makes in another way.
    pub fn new(model: &Model) -> Option<Self> {
        let form = model.program().arms.as_ref()?;
        let tape = &form.tape;
        let is_plain = tape.switches.is_empty() && tape.steep_laws().is_empty() && form.contacts.is_empty();
        let alone = Jet::new(model).filter(|_| is_plain)?;
        if alone.coupling.may_have_sums() || !alone.curves.is_empty() {
            return None;
        }
        let mut series = Jet::<Quad, 1>::with_storage(model, form);
        let definite = series.unknowns.len() == series.residual.len();
        series.matrix = Inverses::new(series.targets().0, &alone.targets().0, definite);
        if alone.has_kernel() {
            let frames = series.shape.lanes[0];
            series.frames = [frames, series.shape.all(), series.solution.len()];
            series.make_response();
            // The series of one motion is found in another way where there are more frames, or states beside them.
            if alone.frames[0] > 1 || frames < series.shape.all() || !series.has_kernel_of_few() {
                return None;
            }
        }
        let Jet { matrix, terms, .. } = &mut series;
        terms.aim(|row, column| matrix.places(row, column));
        let shape = Shape::new(form, WIDTH);
        let places = (0..series.shape.places() as u32).map(|arm| shape.place(arm)).collect();
        Some(Self {
            rules: Rules::new(model, &alone),
            steps: Steps::new(&series),
            order: 0,
            motion: vec![Quad::default(); 2 * model.coordinates()],
            series,
            places,
            changed: true,
            taken: true,
            number: BATCHES.fetch_add(1, Ordering::Relaxed),
            count: 0,
            holders: [Holder::default(); MEMBERS],
        })
    }

    /// Takes over what one motion's series begins with, unless it has been found here, for steps with this tolerance. False if it cannot be continued here.
    pub fn take(&mut self, member: usize, jet: &Jet, tolerance: f64) -> bool {
        self.steps.tolerances[member] = tolerance;
        self.steps.least_rates.set(member, jet.least_rate);
        let Matrix::Whole(inverse) = &jet.matrix else { return false };
        if jet.found.is_held() {
            return jet.found.is_held_by(self.holders[member]);
        }
        self.holders[member] = Holder::default();
        self.taken = true;
        self.rules.take(member, jet);
        let Self { series, places, changed, .. } = self;
        for (place, value) in series.coefficients.iter_mut().zip(&jet.coefficients) {
            *changed |= place.get(member).to_bits() != value.to_bits();
            place.set(member, *value);
        }
        series.matrix.take(member, inverse);
        series.terms.pairs.take(member, &jet.terms.pairs);
        series.scalars.take_given(member, &jet.scalars);
        let arms = || places.iter().copied();
        let [frames, products, _] = series.shape.counts;
        take(&mut series.x, &jet.x, member, arms(), POSITIONS);
        take(&mut series.y, &jet.y, member, arms(), POSITIONS);
        take(&mut series.omega, &jet.omega, member, 0..frames, RATES);
        take(&mut series.sigma, &jet.sigma, member, 0..products, POSITIONS);
        for axis in 0..2 {
            take(&mut series.unit[axis], &jet.unit[axis], member, 0..products, POSITIONS);
            take(&mut series.force[axis], &jet.force[axis], member, arms(), FORCES);
        }
        let [begin, end] = POSITIONS;
        for order in begin..end {
            let values = series.values[order * places.len()..].as_flattened_mut();
            let alone = jet.values[order * jet.shape.all()..].as_flattened();
            for (value, &place) in values.iter_mut().zip(places.iter()) {
                value.set(member, alone[place]);
            }
        }
        true
    }

    /// Hands the orders up to this one over to a motion's own series, if the last ones are numbers.
    pub fn give(&self, member: usize, jet: &mut Jet, order: usize) {
        let (count, all) = (self.places.len(), jet.shape.places());
        let (found, alone) = (self.series.values.as_flattened(), jet.values.as_flattened_mut());
        let first = POSITIONS[1];
        for (index, place) in self.places.iter().enumerate() {
            let found = found[first * count + index..].iter().step_by(count);
            let orders = alone[first * all + place..].iter_mut().step_by(all);
            orders.zip(found).take(order + 1 - first).for_each(|(known, value)| *known = value.get(member));
        }
        // The series itself finds out what is not finite: its jet has the beginning still, or begins anew.
        let length = self.steps.lengths.get(member);
        jet.found.orders = if length.is_nan() { 0 } else { order };
        jet.found.length = [self.steps.tolerances[member], length];
    }

    by_width! {
        /// The series of all motions up to an order.
        pub fn expand(&mut self: Batch, order: usize) = expand_any
    }

    #[inline(always)]
    fn expand_any(&mut self, order: usize) {
        self.order = order;
        let series = &mut self.series;
        if std::mem::take(&mut self.changed) {
            series.fill();
        }
        series.scalars.restart(order);
        series.follow(0);
        series.follow(1);
        series.scalars.rates(0, vectors(&series.x, &series.y, &series.values, series.shape.all()));
        series.follow(2);
        if std::mem::take(&mut self.taken) {
            series.respond_together();
        }
        series.advance_together(1, order - 2);
        self.steps.find_lengths(series, order);
    }
}

impl Jet<Quad, 1> {
    /// True for a mechanism of few frames whose orders [`Jet::advance_frames`] finds.
    fn has_kernel_of_few(&mut self) -> bool {
        of_few!(self.respond_frames()).is_some()
    }

    /// Finds how the poses respond, if the mechanism is one of few frames.
    #[inline(always)]
    fn respond_together(&mut self) {
        of_few!(self.respond_frames());
    }

    /// Orders from the first to the last.
    #[inline(always)]
    fn advance_together(&mut self, first: usize, last: usize) {
        if of_few!(self.advance_frames(first, last)).flatten().is_none() {
            for k in first..last + 1 {
                self.advance_general(k);
            }
        }
    }
}

/// Takes orders of one motion over, from these places.
#[inline(always)]
fn take(
    lanes: &mut [Lane<Quad, 1>],
    alone: &[Lane],
    member: usize,
    places: impl Iterator<Item = usize>,
    [begin, end]: [usize; 2],
) {
    let (lanes, alone) = (lanes.as_flattened_mut(), alone.as_flattened());
    for (index, place) in places.enumerate() {
        for order in begin..end {
            lanes[flat::<1>(index, order)].set(member, alone[flat::<WIDTH>(place, order)]);
        }
    }
}
