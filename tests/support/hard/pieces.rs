//! Motions of one coordinate under laws in pieces, each of which is integrated by itself: a method that finds a jump by its errors leaps over a part of it.

use super::closed_form::extrapolate;

/// Longest part of a motion \[s\]: no law is without effect for so long and acts in between.
const PART: f64 = 5e-4;
/// One switch after the other within this time would go on for ever \[s\].
const AT_ONCE: f64 = 1e-11;

/// x'' = law(t, (x, x'), which switches are positive): smooth in t and x as long as no switch(t, (x, x')) changes sign.
pub struct Pieces<S, L> {
    pub switches: S,
    pub law: L,
}

/// What goes on from a time.
struct Now<const N: usize> {
    t: f64,
    y: Vec<f64>,
    positive: [bool; N],
}

impl<const N: usize, S: Fn(f64, &[f64]) -> [f64; N], L: Fn(f64, &[f64], [bool; N]) -> f64> Pieces<S, L> {
    /// Coordinate and rate at each of the times, which ascend; nothing if a switch turns back at once, again and again.
    pub fn states(&self, start: [f64; 2], times: &[f64]) -> Option<Vec<Vec<f64>>> {
        let mut now = Now { t: 0.0, y: start.to_vec(), positive: self.positive(0.0, &start) };
        let mut state = |&time: &f64| {
            let (from, parts) = (now.t, ((time - now.t) / PART).ceil());
            for part in 1..=parts as u32 {
                self.follow(&mut now, from + (time - from) * f64::from(part) / parts)?;
            }
            Some(now.y.clone())
        };
        times.iter().map(&mut state).collect()
    }

    fn positive(&self, t: f64, y: &[f64]) -> [bool; N] {
        (self.switches)(t, y).map(|switch| switch > 0.0)
    }

    /// To the end of a part, from switch to switch.
    fn follow(&self, now: &mut Now<N>, end: f64) -> Option<()> {
        let mut switched = f64::NEG_INFINITY;
        while now.t < end {
            let mut next = self.later(now, end);
            if next.positive != now.positive {
                next = self.first_switch(now, next);
                if next.t - switched < AT_ONCE {
                    return None;
                }
                switched = next.t;
            }
            *now = next;
        }
        Some(())
    }

    /// By the present piece, beyond its end too.
    fn later(&self, now: &Now<N>, end: f64) -> Now<N> {
        let rates = |t: f64, y: &[f64]| vec![y[1], (self.law)(t, y, now.positive)];
        let y = extrapolate(&rates, [now.t, end], &now.y);
        Now { t: end, positive: self.positive(end, &y), y }
    }

    /// The first number behind a switch that something is behind.
    fn first_switch(&self, now: &Now<N>, mut behind: Now<N>) -> Now<N> {
        let mut before = now.t;
        loop {
            let middle = 0.5 * (before + behind.t);
            if middle <= before || middle >= behind.t {
                return behind;
            }
            let there = self.later(now, middle);
            if there.positive == now.positive {
                before = middle;
            } else {
                behind = there;
            }
        }
    }
}
