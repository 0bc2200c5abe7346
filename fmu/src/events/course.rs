//! The course of one argument along a step: its extremes, and where a law of it may be steep.

use crate::math::{self, largest_between};
use crate::program::Steep;

/// Where an argument is looked at, in steps: evenly, and closer and closer to both ends, where a narrow extreme may lie as well.
pub(super) const PLACES: [f64; 19] = [
    0.0,
    1.0 / 512.0,
    1.0 / 256.0,
    1.0 / 128.0,
    1.0 / 64.0,
    1.0 / 32.0,
    1.0 / 16.0,
    0.125,
    0.25,
    0.375,
    0.5,
    0.625,
    0.75,
    0.875,
    0.9375,
    1.0 - 1.0 / 32.0,
    1.0 - 1.0 / 128.0,
    1.0 - 1.0 / 512.0,
    1.0,
];
/// Sections of an interval in which an extreme is sought: the last is 1e-8 of the first, the root of rounding errors, and the extreme value right to these.
pub(crate) const SECTIONS: usize = 40;
/// Halvings of an interval in which an edge is sought.
pub(super) const EDGE_HALVINGS: usize = 30;
/// An exponential that grows by no more than exp of this to its largest value shows before or after.
const RISEN: f64 = 2.0;
/// What a law divides by, or takes the root of, shows before or after if it falls to no less than one part in so many: a pole is as far from the time axis then as
/// half of the way to it. (150 let a pulse 1/(1 + (t/w)^2) slip through `explicit` at 1e-4.)
pub(super) const DEEP: f64 = 5.0;
/// A step that comes so many times nearer to a switch, and goes back, may have been behind it: its dense output has stages of its own.
const RETURNS_FROM: f64 = 2.0;
/// Places that tell by how much an argument varies at all, and by how much it does before one looks closer: a parabola with a root varies by more than 9 at
/// them, a quartic with two by more than 2.7.
pub(super) const ROUGH_PLACES: [usize; 5] = [0, 8, 10, 12, PLACES.len() - 1];
const VARIED: f64 = 2.5;
/// Where a layer is looked at that a step passes from one side to the other: not in its middle, where odd functions vanish.
const ASIDE: f64 = 0.5;

/// A peak rises over the highest of three samples by no more than so many times what their parabola does: that of a square of a quartic, by 2.4 times.
const BEYOND: f64 = 4.0;

/// A place within a step where a law may be steep although its ends do not tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Suspect {
    /// Which argument.
    pub law: usize,
    /// Where, in steps.
    pub place: f64,
    /// Places that tell what this one does not: next to a pole, where odd functions have a value, and the samples on both sides, where a root may be on another
    /// branch.
    also: [Option<f64>; 3],
    /// The argument at the start of the step, and there.
    start: f64,
    extreme: f64,
}

impl Suspect {
    /// By how much the step is wrong here, in units of what may be overlooked: infinity if only the other places tell.
    pub(crate) fn excess(&self, mut excess: impl FnMut(f64) -> f64) -> f64 {
        let here = excess(self.place);
        let elsewhere = here <= 1.0 && self.also.into_iter().flatten().any(|place| excess(place) > 1.0);
        if elsewhere { f64::INFINITY } else { here }
    }
}

/// Arguments along a step: the values at [`PLACES`], and one of them anywhere.
pub(super) trait Course {
    fn sample(&self, index: usize) -> f64;
    fn value(&mut self, place: f64) -> f64;
}

impl Steep {
    /// The first place after another one where a law with this argument may be steep, while it is not at the ends of the step. `layer` is
    /// [`super::half_width`].
    pub(super) fn suspect(self, law: usize, course: &mut impl Course, layer: f64, after: f64) -> Option<Suspect> {
        let start = course.sample(0);
        let found = match self {
            Self::Growing => [rise(course, after), alone(passage(course, layer, after))],
            Self::Saturating => {
                let towards =
                    |course: &mut _| above(course, -start.signum(), |deepest| f64::max(deepest + RISEN, -layer), after);
                let turn = turn(course, layer, after).or_else(|| towards(course));
                [turn, passage(course, RISEN, after)].map(alone)
            }
            Self::Switching => {
                let returns = start * course.sample(PLACES.len() - 1) > 0.0;
                [alone(turn(course, 0.0, after)), returns.then(|| least(course, RETURNS_FROM, after)).flatten()]
            }
            Self::Vanishing => [least(course, DEEP, after), zero(course, after)],
        };
        let first = found.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        first.map(|(place, extreme, also)| Suspect { law, place, also, start, extreme })
    }

    /// Where the effect of a suspect begins that is so many times what may be overlooked, in steps.
    pub(super) fn begin(self, suspect: &Suspect, course: &mut impl Course, layer: f64, excess: f64) -> f64 {
        let Suspect { start, extreme, place, .. } = *suspect;
        let side = if extreme > start { 1.0 } else { -1.0 };
        let level = match self {
            Self::Growing => extreme - side * (libm::log(excess) + 1.0),
            Self::Saturating => -side * edge_below(-side * start, layer).unwrap_or(0.0),
            Self::Switching => 0.0,
            Self::Vanishing => start / DEEP,
        };
        let outside = |value: f64| side * value < side * level;
        let last = PLACES.iter().enumerate().rev().find(|&(index, at)| *at < place && outside(course.sample(index)));
        let Some((_, &before)) = last else { return 0.5 * place };
        let [before, _] = crossing(course, [before, place], level);
        if before > 0.0 { before } else { 0.5 * place }
    }
}

/// Where, the value there, and [`Suspect::also`].
type Found = (f64, f64, [Option<f64>; 3]);

fn alone(found: Option<(f64, f64)>) -> Option<Found> {
    found.map(|(place, extreme)| (place, extreme, [None; 3]))
}

/// Where an argument comes to a layer, or behind it, that it is below or above at both ends of a step.
fn turn(course: &mut impl Course, width: f64, after: f64) -> Option<(f64, f64)> {
    let (start, end) = (course.sample(0), course.sample(PLACES.len() - 1));
    let [lowest, highest] = [f64::min(start, end), f64::max(start, end)];
    let below = edge_below(lowest, width).and_then(|edge| above(course, -1.0, |_| -edge, after));
    below.or_else(|| edge_below(-highest, width).and_then(|edge| above(course, 1.0, |_| -edge, after)))
}

/// Where an argument passes a layer that it has been outside of, and will be again. Both sides may look alike: those of sech^2 = 1 - tanh^2 do, and
/// those of the slope of a logistic law.
fn passage(course: &mut impl Course, width: f64, after: f64) -> Option<(f64, f64)> {
    let outside = |index: &usize| course.sample(*index).abs() > width;
    let (first, last) = ((0..PLACES.len()).find(outside)?, (0..PLACES.len()).rev().find(outside)?);
    let index = change(course, (first + 1, last), after, |before, behind| before * behind < 0.0)?;
    Some(level(course, [PLACES[index - 1], PLACES[index]], ASIDE * course.sample(index - 1).signum()))
}

/// Where an argument rises so far above what it is before or behind that its exponential is much larger there than elsewhere, and where that is e times less: a
/// stage may lie next to the peak, and the polynomial know of it there alone.
fn rise(course: &mut impl Course, after: f64) -> Option<Found> {
    let (place, extreme) = above(course, 1.0, |deepest| deepest + RISEN, after)?;
    let flank = level(course, [last_place(place), place], extreme - 1.0).0;
    Some((place, extreme, [Some(flank), None, None]))
}

/// Where an argument is one part in `depth` of what it is on both sides, where it is twice that, and the samples beside it.
fn least(course: &mut impl Course, depth: f64, after: f64) -> Option<Found> {
    let sign = course.sample(0).signum();
    let (place, extreme) = above(course, -sign, |deepest| deepest / depth, after)?;
    let flank = (sign * extreme > 0.0).then(|| level(course, [last_place(place), place], 2.0 * extreme).0);
    Some((place, extreme, [flank, Some(last_place(place)).filter(|place| *place > 0.0), next_place(place)]))
}

/// Where an argument changes sign, between two samples or twice between them.
fn zero(course: &mut impl Course, after: f64) -> Option<Found> {
    let differ = |before: f64, behind: f64| before * behind < 0.0 || (before != 0.0 && behind == 0.0);
    let once = change(course, (1, PLACES.len() - 1), after, differ).map(|index| [PLACES[index - 1], PLACES[index]]);
    let twice = turn(course, 0.0, after).map(|(extreme, _)| [last_place(extreme), extreme]);
    let [before, behind] = once.into_iter().chain(twice).min_by(|a, b| a[1].total_cmp(&b[1]))?;
    let (place, value) = level(course, [before, behind], 0.0);
    Some((place, value, [Some(behind).filter(|behind| *behind < 1.0), None, None]))
}

/// The number of the first sample, of those with these numbers, that differs so from the one before.
fn change(
    course: &impl Course,
    (first, last): (usize, usize),
    after: f64,
    differs: impl Fn(f64, f64) -> bool,
) -> Option<usize> {
    let changes = |index: &usize| differs(course.sample(index - 1), course.sample(*index));
    (first..=last).filter(|index| PLACES[index - 1] >= after).find(changes)
}

/// Where an argument comes to a level that it passes, or reaches, between two places: the last place before, and the first behind.
fn crossing(course: &mut impl Course, [mut before, mut behind]: [f64; 2], level: f64) -> [f64; 2] {
    let end = course.value(behind);
    let falls = end < level || (end == level && course.value(before) > level);
    for _ in 0..EDGE_HALVINGS {
        let middle = 0.5 * (before + behind);
        let value = course.value(middle);
        *(if value == level || (value < level) == falls { &mut behind } else { &mut before }) = middle;
    }
    [before, behind]
}

/// The place behind such a crossing, and the value there.
fn level(course: &mut impl Course, places: [f64; 2], level: f64) -> (f64, f64) {
    let [_, place] = crossing(course, places, level);
    (place, course.value(place))
}

/// The sample before a place, and the one behind it unless that is the end of the step.
fn last_place(place: f64) -> f64 {
    PLACES.into_iter().rev().find(|sample| *sample < place).unwrap_or(0.0)
}

fn next_place(place: f64) -> Option<f64> {
    PLACES.into_iter().find(|sample| *sample > place).filter(|sample| *sample < 1.0)
}

/// Does an argument vary so much at the [`ROUGH_PLACES`] that it may nearly vanish between them?
pub(super) fn varies(values: impl Iterator<Item = f64> + Clone) -> bool {
    let sign = values.clone().next().unwrap_or_default().signum();
    let [least, most] = values.fold([f64::INFINITY, 0.0], |[least, most], value| {
        [math::minimum(least, sign * value), math::maximum(most, sign * value)]
    });
    // Written so that NaN varies.
    let steady = VARIED * least >= most;
    !steady
}

/// The next edge of a layer below a value.
fn edge_below(value: f64, width: f64) -> Option<f64> {
    if value > width {
        Some(width)
    } else if value > -width {
        Some(-width)
    } else {
        None
    }
}

/// The first peak that the argument times a sign has within the step after a place, and where, if it is above a level that the deepest values on both
/// sides of it say.
fn above(course: &mut impl Course, sign: f64, level: impl Fn(f64) -> f64, after: f64) -> Option<(f64, f64)> {
    let points = std::array::from_fn::<_, { PLACES.len() }, _>(|index| (PLACES[index], sign * course.sample(index)));
    let deepest = |points: &[(f64, f64)], end: f64| points.iter().map(|point| point.1).fold(end, f64::min);
    let last = PLACES.len() - 1;
    (0..=last).filter(|index| PLACES[index.saturating_sub(1)] >= after).find_map(|index| {
        let at = points[index];
        let [before, behind] = [points[index.saturating_sub(1)], points[last.min(index + 1)]];
        let level_here = level(deepest(&points[..index], at.1).max(deepest(&points[index + 1..], at.1)));
        let middle = index.clamp(1, last - 1);
        let (place, top) = peak([points[middle - 1], points[middle], points[middle + 1]]);
        // Where the parabola through three places is far below, so is the argument; what is so steep at an end may have its peak next to it.
        let rises = at.1 + BEYOND * (top - at.1) > level_here;
        let peaks = if index == middle {
            at.1 >= before.1 && at.1 > behind.1 && rises
        } else {
            at.1 > level(f64::min(before.1, behind.1)) || (rises && before.0 < place && place < behind.0)
        };
        if !peaks {
            return None;
        }
        let (place, value) = largest_between([before.0, behind.0], SECTIONS, |place| sign * course.value(place));
        let (place, value) = if value > at.1 { (place, value) } else { at };
        (value > level_here).then_some((place, sign * value))
    })
}

/// Where the parabola through three points is largest, and its value there; the second point if it is nowhere.
fn peak([(x0, y0), (x1, y1), (x2, y2)]: [(f64, f64); 3]) -> (f64, f64) {
    let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let curvature = (right - left) / (x2 - x0);
    let slope = (left * (x2 - x1) + right * (x1 - x0)) / (x2 - x0);
    if curvature < 0.0 { (x1 - 0.5 * slope / curvature, y1 - 0.25 * slope * slope / curvature) } else { (x1, y1) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYER: f64 = 10.0;

    struct Known<F>(F);

    impl<F: Fn(f64) -> f64> Course for Known<F> {
        fn sample(&self, index: usize) -> f64 {
            (self.0)(PLACES[index])
        }

        fn value(&mut self, place: f64) -> f64 {
            (self.0)(place)
        }
    }

    fn find(kind: Steep, argument: impl Fn(f64) -> f64) -> Option<Suspect> {
        kind.suspect(0, &mut Known(argument), LAYER, 0.0)
    }

    #[test]
    fn a_narrow_bump_is_found_wherever_it_is() {
        for place in [0.003, 0.04, 0.17, 0.3001, 0.5, 0.77, 0.96, 0.995] {
            for width in [1e-2, 1e-3, 1e-5] {
                let argument = |at: f64| -0.5 * ((at - place) / width).powi(2);
                let seen = f64::max(argument(0.0), argument(1.0)) > -RISEN;
                let found = find(Steep::Growing, argument);
                assert_eq!(found.is_none(), seen, "{place} {width}");
                let Some(found) = found else { continue };
                assert!((found.place - place).abs() < 1e-2 * width, "{place} {width}: {found:?}");
                // exp(-1/2 z^2) is 1e-4/e there.
                let begin = Steep::Growing.begin(&found, &mut Known(argument), LAYER, 1e4);
                let expected = place - width * (2.0 * (1e4_f64.ln() + 1.0)).sqrt();
                assert!(expected < 0.0 || (begin - expected).abs() < 1e-6, "{place} {width}: {begin}");
                assert!(begin > 0.0 && begin < place);
            }
        }
    }

    #[test]
    fn a_layer_is_suspected_where_the_argument_turns_round_in_it_or_behind_it() {
        let turning = |least: f64| move |at: f64| least + 4000.0 * (at - 0.4) * (at - 0.4);
        assert!(find(Steep::Saturating, turning(LAYER + 1.0)).is_none());
        // Where it goes through the layer, that comes first.
        let through = 0.4 - ((LAYER + 1.0 + ASIDE) / 4000.0).sqrt();
        for (least, place) in [(LAYER - 1.0, 0.4), (0.0, 0.4), (-LAYER - 1.0, through)] {
            let found = find(Steep::Saturating, turning(least)).expect("in the layer");
            assert!((found.place - place).abs() < 1e-6);
            let begin = Steep::Saturating.begin(&found, &mut Known(turning(least)), LAYER, 1.0);
            assert!((turning(least)(begin) - LAYER).abs() < 1e-3, "{least}: {begin}");
            assert!(find(Steep::Saturating, |at| -turning(least)(at)).is_some());
        }
        // Both sides are seen from the ends.
        assert!(find(Steep::Switching, |at| 1.0 - 3.0 * at).is_none());
        assert!(find(Steep::Switching, |at| (at - 0.4) * (at - 0.4) - 1e-4).is_some());
    }

    #[test]
    fn a_layer_is_suspected_where_a_step_passes_it() {
        for kind in [Steep::Saturating, Steep::Growing] {
            for (slope, from) in [(-3e3, 1e3), (3e5, -1e5)] {
                let argument = |at: f64| from + slope * at;
                let found = find(kind, argument).expect("both sides may look alike");
                assert!((argument(found.place).abs() - ASIDE).abs() < 1e-3, "{kind:?} {slope}: {found:?}");
                let begin = kind.begin(&found, &mut Known(argument), LAYER, 1e4);
                assert!(begin < found.place && argument(begin).abs() > 5.0, "{kind:?} {slope}: {begin}");
            }
            assert!(find(kind, |at| 2.0 - 30.0 * at).is_none(), "seen from where it begins");
        }
    }

    #[test]
    fn an_argument_is_suspected_where_it_nearly_vanishes() {
        for place in [0.001, 0.003, 0.17, 0.3001, 0.5, 0.77, 0.995, 0.9991] {
            let square = |least: f64| move |at: f64| (at - place) * (at - place) + least;
            for sign in [1.0, -1.0] {
                let found = find(Steep::Vanishing, |at| sign * square(1e-12)(at)).expect("a root that turns round");
                assert!((found.place - place).abs() < 1e-6, "{place}: {found:?}");
                let begin = Steep::Vanishing.begin(&found, &mut Known(|at| sign * square(1e-12)(at)), LAYER, 1e4);
                assert!((begin - place * (1.0 - 1.0 / DEEP.sqrt())).abs() < 0.01 * place, "{place}: {begin}");
            }
            assert!(find(Steep::Vanishing, square(0.2)).is_none());
            let through = find(Steep::Vanishing, |at| place - at).expect("a divisor that changes sign");
            assert!((through.place - place).abs() < 1e-8, "{place}: {through:?}");
        }
        // There and back.
        let both = |at: f64| (at - 0.3) * (at - 0.9) * (at - 0.3) * (at - 0.9) + 1e-10;
        let first = find(Steep::Vanishing, both).expect("there");
        let second = Steep::Vanishing.suspect(0, &mut Known(both), LAYER, first.place).expect("and back");
        assert!((first.place - 0.3).abs() < 1e-4 && (second.place - 0.9).abs() < 1e-4);
    }

    #[test]
    fn what_may_nearly_vanish_varies_at_a_few_places() {
        let at_few =
            |argument: &dyn Fn(f64) -> f64| varies(ROUGH_PLACES.map(|index| argument(PLACES[index])).into_iter());
        for place in 1..100 {
            let place = f64::from(place) / 100.0;
            assert!(at_few(&|at| (at - place) * (at - place)), "{place}");
            for other in 1..100 {
                let other = f64::from(other) / 100.0;
                let product = |at: f64| (at - place) * (at - other);
                assert!(at_few(&|at| product(at) * product(at)), "{place} {other}");
            }
        }
        assert!(!at_few(&|at| 1.0 + at) && !at_few(&|at| at - 2.0) && at_few(&|at| at - 0.4) && at_few(&|_| f64::NAN));
    }

    #[test]
    fn one_bump_after_the_other_is_found() {
        // exp(-(sin/w)^2) has three within the step, sech^2 of a sine five.
        let train = |at: f64| -((3.0 * std::f64::consts::PI * (at + 0.11)).sin() / 0.02).powi(2);
        let waves = |at: f64| 300.0 * (5.0 * std::f64::consts::PI * (at + 0.11)).sin();
        for (kind, argument, count) in
            [(Steep::Growing, &train as &dyn Fn(f64) -> f64, 3), (Steep::Saturating, &waves, 5)]
        {
            let (mut places, mut after) = (Vec::new(), 0.0);
            while let Some(suspect) = kind.suspect(0, &mut Known(argument), LAYER, after) {
                after = suspect.place;
                if argument(after).abs() < 1.0 {
                    places.push(after);
                }
            }
            assert_eq!(places.len(), count, "{kind:?}: {places:?}");
            assert!(places.is_sorted(), "{places:?}");
        }
    }
}
