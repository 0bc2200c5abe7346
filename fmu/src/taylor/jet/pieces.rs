//! Laws in pieces along a step.

use super::{Jet, vectors};
use crate::events::ONE_SWITCH;
use crate::events::switch::{Choices, SwitchSign, first_fall, known};
use crate::math::horner;
use crate::program::arm_form::Slot;
use crate::taylor::products::move_start;

impl Jet {
    /// Choices that the next series begins with; the others follow from the signs of their switching functions.
    pub fn force(&mut self, choices: Choices) {
        self.scalars.force(choices);
    }

    /// Takes what is known of choices over from another series.
    pub fn force_like(&mut self, other: &Self) {
        self.scalars.force(other.scalars.forced());
    }

    /// Choices of the present series.
    pub fn chosen(&self) -> Choices {
        self.scalars.chosen()
    }

    /// Finds the last order of what depends on rates, which the accelerations do not need.
    pub fn complete(&mut self, order: usize) {
        if order >= 2 && !self.scalars.is_steady() {
            let lanes = self.shape.all();
            self.scalars.rates(order - 1, vectors(&self.x, &self.y, &self.values, lanes));
        }
    }

    /// One scalar series.
    pub fn scalar(&self, slot: Slot) -> &[f64] {
        self.scalars.series(slot)
    }

    /// Has any law switching functions?
    pub fn has_switches(&self) -> bool {
        self.scalars.switches(0).next().is_some()
    }

    /// How far within h all switching functions are known, to a share of their values. To be called after [`Jet::complete`].
    pub fn sighted(&self, order: usize, h: f64, share: f64) -> f64 {
        self.scalars.switches(order - 1).fold(h, |h, (_, series)| known(series, h, share))
    }

    /// Where the first piece of a step of length h ends that begins so long after the series, and the choices after it. To be called after [`Jet::complete`].
    pub fn end_of_piece(&mut self, order: usize, begin: f64, h: f64) -> Option<(f64, Choices)> {
        self.scalars.switches(0).next()?;
        let chosen = self.chosen();
        let falls = self.scalars.switches(order - 1).filter_map(|(switch, series)| {
            let side = chosen.get(switch)?;
            let sign = match if side == SwitchSign::Equal {
                self.left_for(switch, series, begin + ONE_SWITCH * h)?
            } else {
                side
            } {
                SwitchSign::Above => 1.0,
                SwitchSign::Below => -1.0,
                SwitchSign::Equal => return Some(0.0),
            };
            let mut towards = [0.0; crate::program::arm_form::MAX_ORDER + 1];
            let towards = &mut towards[..series.len()];
            towards.iter_mut().zip(series).for_each(|(place, value)| *place = sign * value);
            if begin != 0.0 {
                move_start(towards, 1, begin);
            }
            first_fall(towards, h)
        });
        let first = falls.fold(f64::INFINITY, f64::min);
        (first <= h).then(|| (first, self.choices_after(order, begin + first + ONE_SWITCH * h)))
    }

    /// The side to which a function goes that begins at zero, if it does not stay there: what holds on it, if that is what holds at zero; else `Equal`, for that piece
    /// ends at once. A little later the function shows.
    fn left_for(&self, switch: u32, series: &[f64], later: f64) -> Option<SwitchSign> {
        let side = SwitchSign::of(horner(series, later));
        let [above, below] = self.scalars.pieces(switch).apart;
        match side {
            SwitchSign::Equal => None,
            SwitchSign::Above if above => Some(SwitchSign::Equal),
            SwitchSign::Below if below => Some(SwitchSign::Equal),
            same => Some(same),
        }
    }

    /// Choices that differ from the present ones at a time. Where a function follows from what another one chooses anew, its value will tell.
    fn choices_after(&self, order: usize, time: f64) -> Choices {
        let (present, mut after) = (self.chosen(), Choices::default());
        for (switch, series) in self.scalars.switches(order - 1) {
            let side = SwitchSign::of(horner(series, time));
            if present.get(switch).is_some_and(|present| side != SwitchSign::Equal && side != present) {
                after.set(switch, side);
            }
        }
        after.without(self.following(after))
    }

    /// The switching functions that follow from what these choose.
    pub fn following(&self, choices: Choices) -> u64 {
        let chosen = self.scalars.switches(0).filter(|(switch, _)| choices.get(*switch).is_some());
        chosen.fold(0, |bits, (switch, _)| bits | self.scalars.pieces(switch).later)
    }
}
