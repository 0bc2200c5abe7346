//! Where laws switch: v_p jumps by (a(-) - a(+)) t_s,p, where a does (Aizerman and Gantmakher 1958).

use cotree::expr::Order;
use cotree_fmu::model::State;
use nalgebra::{DVector, RowDVector};

use super::super::AnalysisFailure;
use super::super::variation::{ColumnBlock, RowBlock};
use super::corner::Switched;
use super::step::{DifferentiatedMotion, move_on, sides, switches};

/// Halvings of the interval that a crossing lies in.
const HALVINGS: usize = 60;
/// The laws before and after are read that far from the crossing, as a share of the interval it was found in, and no nearer than so many roundings of the time:
/// nearer, rounding decides which law it is. The derivatives are not integrated over that interval, an error that grows with the stiffness: the smallest
/// share at which both laws are clear is taken.
const BESIDE: [f64; 5] = [1e-12, 1e-11, 1e-10, 1e-9, 1e-8];
const ROUNDINGS: f64 = 64.0;
/// A switching function that has this share of its value just behind a crossing has jumped there.
const JUMPED: f64 = 0.5;
/// Accelerations are the same within this share.
const SAME: f64 = 1e-6;

/// A switching function changes sign.
#[derive(Clone, Copy, Debug)]
pub struct SwitchCrossing {
    pub switch: usize,
    /// Just before it \[s\].
    pub time: f64,
    /// From there to the crossing, and on to where the laws after it are read \[s\].
    beside: f64,
    /// The interval that it was found in \[s\].
    interval: f64,
    /// What the switching function reaches at the end of the interval.
    reached: f64,
}

impl DifferentiatedMotion<'_> {
    /// The first crossing between two times, if a switching function has another sign at the second; `known` are the sides before, and then those after.
    pub(super) fn first_crossing(
        &self,
        known: &mut [Option<bool>],
        after: &DVector<f64>,
        [from, to]: [f64; 2],
    ) -> Result<Option<SwitchCrossing>, AnalysisFailure> {
        let mut first: Option<SwitchCrossing> = None;
        for (switch, new) in sides(after).into_iter().enumerate() {
            let old = known[switch];
            known[switch] = new.or(old);
            let (Some(old), Some(new)) = (old, new) else { continue };
            if old == new {
                continue;
            }
            let located = self.located(switch, old, [from, to])?;
            let (interval, reached) = (to - from, after[switch].abs());
            let beside = self.beside(switch, old, located, interval)?;
            let time = (located - beside).max(self.motion.time());
            if first.is_none_or(|first| time < first.time) {
                first = Some(SwitchCrossing { switch, time, beside, interval, reached });
            }
        }
        Ok(first)
    }

    /// The last time at which a switching function is still on its side.
    fn located(&self, switch: usize, side: bool, [mut low, mut high]: [f64; 2]) -> Result<f64, AnalysisFailure> {
        let mut before = self.motion.clone();
        for _ in 0..HALVINGS {
            let middle = low + 0.5 * (high - low);
            if middle <= low || middle >= high {
                break;
            }
            let mut motion = before.clone();
            move_on(&mut motion, middle)?;
            if (switches(&mut motion)?[switch] > 0.0) == side {
                (low, before) = (middle, motion);
            } else {
                high = middle;
            }
        }
        Ok(low)
    }

    /// How far from a crossing the law is the one before or after it: there and twice as far the accelerations are the same.
    fn beside(&self, switch: usize, side: bool, located: f64, interval: f64) -> Result<f64, AnalysisFailure> {
        let shortest = ROUNDINGS * f64::EPSILON * located.abs();
        let [.., longest] = BESIDE.map(|share| (share * interval).max(shortest));
        for distance in BESIDE.map(|share| (share * interval).max(shortest)) {
            let mut motion = self.motion.clone();
            let mut read = |shift: f64| -> Result<_, AnalysisFailure> {
                let (point, numbers) = self.at(&mut motion, (located + shift * distance).max(self.motion.time()))?;
                let is_before = (numbers.values(RowBlock::Switches)[switch] > 0.0) == side;
                Ok((is_before, self.values(&point, Order::Acceleration)))
            };
            let [farther, before, after, beyond] = [read(-2.0)?, read(-1.0)?, read(1.0)?, read(2.0)?];
            let same =
                |one: &DVector<f64>, other: &DVector<f64>| (one - other).amax() <= SAME * one.amax().max(other.amax());
            if before.0 && !after.0 && same(&farther.1, &before.1) && same(&after.1, &beyond.1) {
                return Ok(distance);
            }
        }
        Ok(longest)
    }

    /// How fast a switching function changes with time and with the inputs that follow it; `own` are its derivatives by the signals.
    fn by_time(&self, partials: &RowDVector<f64>, state: &State) -> f64 {
        let moving = self.driven.inputs().iter().zip(partials.iter().skip(self.parameters + 1));
        partials[self.parameters] + moving.map(|(&input, by)| by * state.input_polynomial(input)[1]).sum::<f64>()
    }

    /// Goes over a crossing; the motion and its derivatives are those just before it.
    pub(super) fn cross(&mut self, crossing: &SwitchCrossing) -> Result<(), AnalysisFailure> {
        let SwitchCrossing { switch, time, beside, interval, reached } = *crossing;
        let mut motion = self.motion.clone();
        let (before, numbers) = self.at(&mut motion, time)?;
        let (beginning, state) = (motion.clone(), motion.state());
        let old = sides(&numbers.values(RowBlock::Switches));
        let (rates, accelerations) = (self.values(&before, Order::Velocity), self.values(&before, Order::Acceleration));
        // How a switching function changes with the parameters, and how fast.
        let of = |switch: usize| {
            let row = |column: ColumnBlock| numbers.block(RowBlock::Switches, column).row(switch).into_owned();
            let by_signals = row(ColumnBlock::Signals);
            let change = row(ColumnBlock::Positions) * &self.positions
                + row(ColumnBlock::Rates) * &self.rates
                + self.by_parameters(&by_signals.rows(0, 1).into_owned(), time);
            let speed = (row(ColumnBlock::Positions) * &rates)[0]
                + (row(ColumnBlock::Rates) * &accelerations)[0]
                + self.by_time(&by_signals, &state);
            (change, speed)
        };
        let (change, speed) = of(switch);
        let is_same = |other: usize| {
            let (others, rate) = of(other);
            (&others * speed - &change * rate).amax()
                <= SAME * (change.amax() * rate.abs()).max(others.amax() * speed.abs())
        };
        let (after, numbers) = self.at(&mut motion, time + 2.0 * beside)?;
        let (new, values) = (self.values(&after, Order::Acceleration), numbers.values(RowBlock::Switches));
        // Speeds that jump with a driver take what is not driven along.
        let now = self.values(&after, Order::Velocity);
        let largest = accelerations.amax().max(new.amax());
        // Where the motion turns back its rates are small, and so is what steps of the motion leave between them.
        let usual = now.amax().max(rates.amax()).max(interval * largest);
        if (&now - &rates).amax() - 2.0 * beside * largest > SAME.max(self.tolerance) * usual {
            return Err(refused(
                time,
                "the rate of a driver is discontinuous, and so are the speeds; make its law smooth",
            ));
        }
        let jump = &accelerations - &new;
        // Crossed at an angle it gets about as far as its speed takes it; one that jumps itself, where an angle begins a new turn, goes on far from zero.
        let beyond = values[switch].abs();
        let jumps = speed != 0.0 && beyond > JUMPED * reached && beyond > 4.0 * beside * speed.abs();
        let crosses = jumps || speed.abs() * interval > self.tolerance.sqrt() * reached;
        if jump.amax() > SAME * largest {
            // Laws that switch for the same reason do so at the same time for all parameters.
            let now = sides(&values);
            let mut switched = (0..now.len()).filter(|&other| old[other] != now[other]);
            if switched.any(|other| !is_same(other)) {
                return Err(refused(time, "two laws switch at the same time"));
            }
            if !crosses {
                return Err(refused(time, "a discontinuity of a law is touched without being crossed"));
            }
            self.rates -= &jump * &change / speed;
        }
        if crosses {
            let times = [time, time + 2.0 * beside];
            self.switched.push(Switched { times, changes: (-&change / speed).iter().copied().collect() });
        }
        self.sides = sides(&values);
        self.clear = time + 2.0 * beside;
        self.motion = beginning;
        Ok(())
    }
}

fn refused(time: f64, what: &str) -> AnalysisFailure {
    AnalysisFailure::NoDerivative { time, what: what.to_owned() }
}
