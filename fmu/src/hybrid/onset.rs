//! When a comparison begins to hold within a step.
//!
//! The excess of one side over the other is looked at in places so close that they tell what it is between them, which is checked at others; then it has at most one extremum between
//! three of them. Where an extremum could cross zero it is sought.

use crate::events::SECTIONS;
use crate::linalg::SPACINGS;
use crate::machine::ROUNDING;
use crate::math::{largest_between, maximum, minimum};

/// Parts of a step between which the excess is looked at.
pub(crate) const PARTS: usize = 16;
/// Places at which the others are checked: away from them, from the middle and from all round shares.
pub(crate) const CHECKS: [f64; 3] = [0.093_71, 0.541_37, 0.829_53];
/// A place tells what is beside it to this share of what the excess varies by: seven places in a period of a sine do.
const TELLING: f64 = 1e-3;
/// What is further from zero than ten times by how much the places are wrong does not reach it between them.
pub(super) const INTERPOLATION_ERROR: f64 = 0.1;
/// Halvings of an interval of one, to its last bit.
pub(crate) const ROOT_HALVINGS: usize = 60;
/// A place is nearer to the middle than the secant by this share of the width, times the share to which the width has shrunk: so the root is soon closed in from both sides.
const CENTRED: f64 = 0.2;

/// How far and how closely a piece is looked through, as shares of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    /// What begins later does not matter: another event has been found here.
    pub limit: f64,
    /// Times that are closer together than this are the same number.
    pub spacing: f64,
    /// An excess is known to no more than this: only further below zero it has ceased to hold.
    pub noise: f64,
}

impl Reach {
    /// The part of a piece up to a time in it.
    pub(crate) fn new([from, to]: [f64; 2], until: f64) -> Self {
        let whole = to - from;
        let spacing = f64::EPSILON * minimum(from.abs(), to.abs()) / whole;
        Self { limit: (until - from) / whole, spacing, noise: 0.0 }
    }
}

/// What a comparison does in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Onset {
    /// The share of the step at which it begins to hold, if it does.
    pub begin: Option<f64>,
    /// True if the comparison can begin to hold later: it did not hold at last.
    pub armed: bool,
}

/// True if the excess at a share of a piece is what the values in the six places about it say, to within what it is known to, or has no value anywhere.
pub(crate) fn fits(values: &[f64; PARTS + 1], share: f64, found: f64, noise: f64) -> bool {
    let known = values.iter().filter(|value| value.is_finite());
    let [least, most] = known.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], &value| {
        [minimum(least, value), maximum(most, value)]
    });
    let allowed = TELLING * (most - least) + maximum(ROUNDING * maximum(least.abs(), most.abs()), noise);
    least > most && !found.is_finite() || (interpolated(values, share) - found).abs() <= allowed
}

/// True if the excess is so far below zero in all places that what they do not tell of it does not reach zero: a reaction that hardly changes has nothing but rounding errors between them.
pub(crate) fn stays_away(values: &[f64; PARTS + 1], share: f64, found: f64) -> bool {
    let most = values.iter().fold(found, |most, &value| maximum(most, value));
    (interpolated(values, share) - found).abs() <= INTERPOLATION_ERROR * -most
}

/// True if the excess begins to rise from zero where the piece begins: it is nothing there beside what it is in the next places, and grows from each to the next.
pub(crate) fn begins_at_once(values: &[f64; PARTS + 1]) -> bool {
    let [begin, first, second, third, ..] = *values;
    begin.abs() <= TELLING * first && first < second && second < third
}

/// Two places between which others do not tell the excess: it is nearer to zero there than those were compared with, and varies by less than a tenth of what it varies by in all. Up to the place `end`, which is none
/// behind a place where it holds.
pub(crate) fn doubtful(values: &[f64; PARTS + 1], end: usize) -> Option<[usize; 2]> {
    let range = |values: &[f64]| {
        let [least, most] = values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], &value| {
            [minimum(least, value), maximum(most, value)]
        });
        most - least
    };
    let whole = range(values);
    let is_near = |place: usize| values[place] > -TELLING / INTERPOLATION_ERROR * whole;
    let from = (0..end).find(|&place| is_near(place) && is_near(place + 1))?;
    let to = (from + 1..=end).take_while(|&place| is_near(place)).last()?;
    let window = [from.saturating_sub(1), (to + 1).min(end)];
    (range(&values[window[0]..=window[1]]) < INTERPOLATION_ERROR * whole).then_some(window)
}

/// What the values in the six places about a share say of it.
fn interpolated(values: &[f64; PARTS + 1], share: f64) -> f64 {
    const NEIGHBOURS: usize = 6;
    let first = ((share * PARTS as f64) as usize).saturating_sub(NEIGHBOURS / 2 - 1).min(PARTS + 1 - NEIGHBOURS);
    let place = |index: usize| (first + index) as f64 / PARTS as f64;
    let weight = |index: usize| {
        let others = (0..NEIGHBOURS).filter(|other| *other != index);
        others.fold(1.0, |weight, other| weight * (share - place(other)) / (place(index) - place(other)))
    };
    (0..NEIGHBOURS).fold(0.0, |sum, index| sum + weight(index) * values[first + index])
}

/// Looks through a step at whose beginning the comparison can begin to hold (`armed`), or holds; `values` are those of the excess in `PARTS` + 1 places.
pub(crate) fn first(
    values: &[f64; PARTS + 1],
    armed: bool,
    strict: bool,
    range: Reach,
    excess: &mut impl FnMut(f64) -> f64,
) -> Onset {
    let holds = |value: f64| if strict { value > 0.0 } else { value >= 0.0 };
    let share = |place: usize| place as f64 / PARTS as f64;
    let mut armed = armed;
    // A peak about a place reaches back to the one before.
    for place in (1..=PARTS).take_while(|place| share(place.saturating_sub(2)) < range.limit) {
        let now = values[place];
        if !armed {
            // At the beginning the value may be a rounding error, and stay one.
            armed = now < -range.noise;
            continue;
        }
        if holds(now) {
            let before = (share(place - 1), values[place - 1]);
            if before.0 >= range.limit {
                break;
            }
            let after =
                if share(place) > range.limit { (range.limit, excess(range.limit)) } else { (share(place), now) };
            if !holds(after.1) {
                break;
            }
            return Onset { begin: Some(turn(&holds, before, after, range.spacing, excess)), armed: false };
        }
        for [from, to] in peaks(values, place).into_iter().flatten() {
            if let Some(top) = summit(&holds, share(from), share(to), excess) {
                let before = (share(from), values[from]);
                return Onset { begin: Some(turn(&holds, before, top, range.spacing, excess)), armed: false };
            }
        }
    }
    Onset { begin: None, armed }
}

/// Between which places there may be a value of zero that none of those up to this one shows: about the one before, and next to the ends, beyond which there is no other.
fn peaks(values: &[f64; PARTS + 1], place: usize) -> [Option<[usize; 2]>; 3] {
    let bend = |middle: usize| (2.0 * values[middle] - values[middle - 1] - values[middle + 1]).abs();
    let inner = place >= 2 && may_cross([values[place - 2], values[place - 1], values[place]]);
    let first = place == 1 && values[0] >= values[1] && values[0] + 0.5 * bend(1) >= 0.0;
    let last = place == PARTS && values[PARTS] >= values[PARTS - 1] && values[PARTS] + 0.5 * bend(PARTS - 1) >= 0.0;
    [first.then_some([0, 1]), inner.then(|| [place - 2, place]), last.then_some([PARTS - 1, PARTS])]
}

/// True if there may be a value of zero between three that are negative, of which the middle one is the largest. The parabola through them reaches no higher than the middle one and an
/// eighth of their second difference, if that is right to a factor of four.
fn may_cross([left, middle, right]: [f64; 3]) -> bool {
    let bend = 2.0 * middle - left - right;
    middle >= left && middle >= right && middle + 0.5 * bend >= 0.0
}

/// The first place between two, at the second of which the comparison holds, where it does; each with its value. By secants that are kept so near the middle that no more places are looked at than halving
/// would take, and one (the ITP method: Oliveira and Takahashi, *ACM Trans. Math. Softw.* 47, 2020): ten where the excess is smooth, instead of fifty. It ends where both places are the same time.
pub(crate) fn turn(
    holds: &impl Fn(f64) -> bool,
    (mut from, mut before): (f64, f64),
    (mut to, mut after): (f64, f64),
    spacing: f64,
    excess: &mut impl FnMut(f64) -> f64,
) -> f64 {
    let whole = to - from;
    // The width that halving would have reached before.
    let mut reach = whole;
    for _ in 0..ROOT_HALVINGS {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        if middle <= from || middle >= to || to - from <= spacing {
            break;
        }
        let secant = to - after * (to - from) / (after - before);
        let shift = CENTRED * (to - from) * (to - from) / whole;
        let towards = if middle > secant { 1.0 } else { -1.0 };
        let truncated = if (middle - secant).abs() > shift { secant + towards * shift } else { middle };
        let radius = reach - half;
        let place = if (truncated - middle).abs() <= radius { truncated } else { middle - towards * radius };
        // No nearer to what is known than rounding errors; what is not a number is halved.
        let least = maximum(SPACINGS * to, 0.5 * spacing);
        let place =
            if place.is_finite() && half > least { minimum(maximum(place, from + least), to - least) } else { middle };
        let value = excess(place);
        if holds(value) {
            (to, after) = (place, value);
        } else {
            (from, before) = (place, value);
        }
        reach *= 0.5;
    }
    to
}

/// A place between two where the comparison holds, with its value, if there is one about the largest value.
fn summit(holds: &impl Fn(f64) -> bool, from: f64, to: f64, excess: &mut impl FnMut(f64) -> f64) -> Option<(f64, f64)> {
    let (place, largest) = largest_between([from, to], SECTIONS, excess);
    holds(largest).then_some((place, largest))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn onset(armed: bool, mut excess: impl FnMut(f64) -> f64) -> Onset {
        let values = std::array::from_fn(|place| excess(place as f64 / PARTS as f64));
        first(&values, armed, true, Reach { limit: 1.0, spacing: 0.0, noise: 0.0 }, &mut excess)
    }

    #[test]
    fn the_first_crossing_is_found_to_the_last_bit() {
        let found = onset(true, |t| t - 0.3).begin.unwrap();
        assert!(found - 0.3 > 0.0 && found - 0.3 < 1e-16);
        // Up at 0.2, down at 0.4, up at 0.9.
        let cubic = |t: f64| (t - 0.2) * (t - 0.4) * (t - 0.9);
        assert!((onset(true, cubic).begin.unwrap() - 0.2).abs() < 1e-15);
        // Already true: it must end first.
        assert!((onset(false, cubic).begin.unwrap() - 0.2).abs() < 1e-15);
        assert!((onset(false, |t| -cubic(t)).begin.unwrap() - 0.4).abs() < 1e-15);
    }

    #[test]
    fn what_is_near_zero_beside_what_is_far_is_doubtful() {
        let values = |of: &dyn Fn(f64) -> f64| std::array::from_fn(|place| of(place as f64 / PARTS as f64));
        // It is above zero between the first two places for a moment, and a thousand times as far from it later: above, or below.
        let moment = |t: f64| 0.03 * (-((t - 0.03) / 0.01).powi(2)).exp() - 0.02;
        assert_eq!(doubtful(&values(&|t| moment(t) + 100.0 * t.powi(4)), 1), Some([0, 1]));
        assert_eq!(doubtful(&values(&|t| moment(t) - 100.0 * t.powi(4)), PARTS), Some([0, 6]));
        for known in [|t: f64| t - 0.3, |t: f64| (7.0 * t).sin() - 0.5, |_: f64| -1.0, |t: f64| -t] {
            assert_eq!(doubtful(&values(&known), PARTS), None);
        }
    }

    /// Halving takes 49 to 54 places for what lies between two of sixteen.
    #[test]
    fn a_crossing_takes_few_places_and_a_jump_no_more_than_halving() {
        let places = |excess: &dyn Fn(f64) -> f64| {
            let mut count = 0;
            let found = onset(true, |t| {
                count += 1;
                excess(t)
            });
            assert!(excess(found.begin.unwrap()) > 0.0);
            count - PARTS - 1
        };
        for root in [0.3, 0.017, 0.77731, 0.999] {
            assert!(places(&|t| t - root) <= 14, "{root}");
            assert!(places(&|t: f64| t.exp() - root.exp()) <= 14, "{root}");
            assert!(places(&|t| (t - root).powi(3)) <= 56, "{root}");
            assert!(places(&|t| if t < root { -1.0 } else { 1e-9 }) <= 56, "{root}");
            assert!(places(&|t| if t < root { f64::NEG_INFINITY } else { 1.0 }) <= 56, "{root}");
        }
    }

    /// A crossing behind the limit is none, one before it is found as without; near the end of a short step after a long time few numbers are left.
    #[test]
    fn what_begins_behind_the_limit_costs_one_place_and_times_that_are_one_are_not_separated() {
        let places = |limit: f64, spacing: f64| {
            let (mut count, excess) = (0, |t: f64| t - 0.3);
            let values = std::array::from_fn(|place| excess(place as f64 / PARTS as f64));
            let found = first(&values, true, true, Reach { limit, spacing, noise: 0.0 }, &mut |t| {
                count += 1;
                excess(t)
            });
            (found.begin, count)
        };
        assert_eq!(places(0.29, 0.0), (None, 1));
        assert_eq!(places(0.2, 0.0), (None, 0));
        let (found, _) = places(0.301, 0.0);
        assert!((found.unwrap() - 0.3).abs() < 1e-15);
        let (found, count) = places(1.0, 1e-6);
        assert!((found.unwrap() - 0.3).abs() <= 1e-6 && found.unwrap() > 0.3 && count <= 6, "{found:?} {count}");
    }

    /// A limit takes nothing away that is before it, peaks between two places included.
    #[test]
    fn what_begins_before_the_limit_is_found_as_without_it() {
        for (centre, height) in
            (1..100).flat_map(|part| [1e-4, 1e-2, 0.1].map(|height| (f64::from(part) / 100.0, height)))
        {
            let mut excess = |t: f64| height * height - (t - centre) * (t - centre);
            let values = std::array::from_fn(|place| excess(place as f64 / PARTS as f64));
            let mut begin =
                |limit: f64| first(&values, true, true, Reach { limit, spacing: 0.0, noise: 0.0 }, &mut excess).begin;
            let Some(all) = begin(1.0) else { continue };
            for limit in (1..50).map(|part| f64::from(part) / 50.0) {
                match begin(limit).filter(|at| *at < limit) {
                    Some(at) => assert!((at - all).abs() < 1e-12, "{centre} {height} {limit}: {at} {all}"),
                    None => assert!(all >= limit - 1e-15, "{centre} {height} {limit}: {all}"),
                }
            }
        }
    }

    #[test]
    fn two_crossings_between_two_places_are_seen_and_a_near_miss_is_none() {
        for (top, width) in [(0.51, 1e-3), (0.3337, 1e-6), (0.97, 3e-3), (0.999, 1e-4), (0.02, 1e-3)] {
            let peak = |height: f64| move |t: f64| height - (t - top) * (t - top);
            let found = onset(true, peak(width * width)).begin.unwrap();
            assert!((found - (top - width)).abs() < 1e-9, "{top} {width} {found}");
            assert_eq!(onset(true, peak(-width * width)), Onset { begin: None, armed: true });
        }
    }

    #[test]
    fn places_too_far_apart_are_seen() {
        let fit = |excess: &dyn Fn(f64) -> f64| {
            let values = std::array::from_fn(|place| excess(place as f64 / PARTS as f64));
            CHECKS.iter().all(|&share| fits(&values, share, excess(share), 0.0))
        };
        assert!(fit(&|t| (6.0 * t).sin()) && fit(&|_| 3.0) && fit(&|t: f64| t.exp() - 2.0) && fit(&|_| f64::NAN));
        for fast in [40.0, 100.5, 1e4] {
            assert!(!fit(&|t| (fast * t).sin()), "{fast}");
        }
        assert!(!fit(&|t| if t < 0.55 { 1.0 } else { -1.0 }));
    }

    #[test]
    fn what_rises_from_zero_begins_at_once() {
        let begins = |excess: &dyn Fn(f64) -> f64| {
            begins_at_once(&std::array::from_fn(|place| excess(place as f64 / PARTS as f64)))
        };
        assert!(begins(&|t| t) && begins(&|t| 1e-9 * t * t * t) && begins(&|t| (3.0 * t).sin()));
        assert!(!begins(&|t| -t) && !begins(&|_| 0.0) && !begins(&|t| 0.1 + t) && !begins(&|t| f64::NAN * t));
    }

    #[test]
    fn what_has_just_begun_to_hold_does_not_begin_again_by_rounding_errors() {
        assert_eq!(onset(false, |t| t - 1e-17), Onset { begin: None, armed: false });
        assert_eq!(onset(false, |t| 0.5 - t), Onset { begin: None, armed: true });
        assert_eq!(onset(true, |_| f64::NAN), Onset { begin: None, armed: true });
    }
}
