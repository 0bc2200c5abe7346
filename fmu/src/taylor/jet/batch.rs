//! The series of four motions of one model at a time, with the bits that each motion's own jet finds.
//!
//! Only the orders are found here: where a series begins, how long its step is and whether it is accepted is up to each motion.

use super::{Coefficient, Jet, ORDERS, Shape, flat, vectors};
use crate::linalg::lane::{Lane, WIDTH, by_width};
use crate::linalg::matrix::Matrix;
use crate::linalg::quad::{Inverses, Quad};
use crate::model::Model;

/// Motions whose series are found together.
pub(crate) const MEMBERS: usize = WIDTH;

/// The orders that the beginning of a series leaves: of positions, of rates, and of forces. The last two are stored the other way round.
const POSITIONS: [usize; 2] = [0, 3];
const RATES: [usize; 2] = [ORDERS - 2, ORDERS];
const FORCES: [usize; 2] = [ORDERS - 1, ORDERS];

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
}

impl Batch {
    /// Storage, if a model's series need no decisions and no operation that the series of one motion makes in another way.
    pub fn new(model: &Model) -> Option<Self> {
        let form = model.program().arms.as_ref()?;
        let tape = &form.tape;
        let is_plain = tape.switches.is_empty() && tape.steep_laws().is_empty() && form.contacts.is_empty();
        let alone = Jet::new(model).filter(|_| is_plain)?;
        if alone.coupling.may_have_sums() || alone.has_kernel() || !alone.curves.is_empty() {
            return None;
        }
        let mut series = Jet::<Quad, 1>::with_storage(model, form);
        series.matrix = Inverses::new(series.targets().0);
        let shape = Shape::new(form, WIDTH);
        let places = (0..series.shape.places() as u32).map(|arm| shape.place(arm)).collect();
        Some(Self { series, places, changed: true })
    }

    /// Takes over what one motion's series begins with. False if it cannot be continued here.
    pub fn take(&mut self, member: usize, jet: &Jet) -> bool {
        let Matrix::Whole(inverse) = &jet.matrix else { return false };
        let Self { series, places, changed } = self;
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

    /// Hands the orders up to this one over to a motion's own series, if they are numbers.
    pub fn give(&self, member: usize, jet: &mut Jet, order: usize) {
        let (count, all) = (self.places.len(), jet.shape.places());
        let (found, alone) = (self.series.values.as_flattened(), jet.values.as_flattened_mut());
        let mut finite = true;
        for k in POSITIONS[1]..=order {
            for (value, place) in found[k * count..].iter().zip(&self.places) {
                let value = value.get(member);
                finite &= value.is_finite();
                alone[k * all + place] = value;
            }
        }
        // The series itself finds out what is not finite: its jet has the beginning still.
        jet.ahead = if finite { order } else { 0 };
    }

    by_width! {
        /// The series of all motions up to an order.
        pub fn expand(&mut self: Batch, order: usize) = expand_any
    }

    #[inline(always)]
    fn expand_any(&mut self, order: usize) {
        let series = &mut self.series;
        if std::mem::take(&mut self.changed) {
            series.fill();
        }
        series.scalars.restart(order);
        series.follow(0);
        series.follow(1);
        series.scalars.rates(0, vectors(&series.x, &series.y, &series.values, series.shape.all()));
        series.follow(2);
        for k in 1..order - 1 {
            series.advance_general(k);
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
