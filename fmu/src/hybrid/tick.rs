//! When sampled values change: at offset + k period, k = 0, 1, ... Each time is computed from its number and never summed up, so that rounding errors do not grow.

use crate::integrator::control::shortest;

/// When the values of one sampler change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    /// \[s\]
    pub period: f64,
    /// Time of the first tick \[s\].
    pub offset: f64,
}

/// Times nearer to each other than the shortest step are one instant.
pub(crate) fn is_later(time: f64, than: f64) -> bool {
    time > than + shortest(than)
}

impl Clock {
    /// True if ticks are apart at this time.
    pub fn is_sound(self, time: f64) -> bool {
        self.offset.is_finite() && self.period.is_finite() && self.period > 4.0 * shortest(time.max(self.offset))
    }

    /// The first tick later than a time.
    pub fn after(self, time: f64) -> f64 {
        let mut number = ((time - self.offset) / self.period).floor().max(0.0);
        while !is_later(self.tick(number), time) {
            number += 1.0;
        }
        self.tick(number)
    }

    /// True at the instant of a tick.
    pub fn is_at(self, time: f64) -> bool {
        let number = self.number(time);
        let tick = self.tick(number);
        number >= 0.0 && !is_later(tick, time) && !is_later(time, tick)
    }

    /// The number of the tick next to a time, from zero.
    pub fn number(self, time: f64) -> f64 {
        ((time - self.offset) / self.period).round()
    }

    fn tick(self, number: f64) -> f64 {
        self.offset + number * self.period
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_follow_each_other_and_none_is_left_out() {
        for (period, offset) in [(0.1, 0.0), (1e-3, 0.2), (1.0 / 3.0, -7.0), (0.01, 1e4)] {
            let clock = Clock { period, offset };
            let mut time = offset - 0.5 * period;
            for number in 0..10_000 {
                time = clock.after(time);
                assert_eq!(time, offset + f64::from(number) * period);
                assert!(clock.is_at(time) && !clock.is_at(time + 0.5 * period));
            }
        }
    }

    #[test]
    fn ticks_of_different_samplers_are_one_instant_where_only_rounding_errors_differ() {
        let (tenth, third) = (Clock { period: 0.1, offset: 0.0 }, Clock { period: 0.3, offset: 0.0 });
        let time = 3.0 * 0.1;
        assert_ne!(time, 0.3);
        assert!(tenth.is_at(time) && third.is_at(time) && third.is_at(0.3) && tenth.is_at(0.3));
        assert!(tenth.after(0.3) > 0.39 && third.after(time) > 0.59);
    }

    #[test]
    fn a_period_that_rounding_errors_swallow_is_unsound() {
        assert!(Clock { period: 1e-6, offset: 0.0 }.is_sound(1e3));
        for period in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-13] {
            assert!(!Clock { period, offset: 0.0 }.is_sound(1e3), "{period}");
        }
    }
}
