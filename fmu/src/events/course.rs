//! The course of one argument along a step: its extremes, and where a law of it may be steep.

use super::Steep;

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
/// Sections of an interval in which an extreme is sought: the last is 1e-8 of the first.
const SECTIONS: usize = 40;
/// (sqrt 5 - 1)/2
const GOLDEN: f64 = 0.618_033_988_749_894_8;
/// Halvings of an interval in which an edge is sought.
const HALVINGS: usize = 30;
/// An exponential that grows by no more than exp of this to its largest value shows before or after.
const RISEN: f64 = 2.0;
/// What falls below this share of what it is at both ends of a step may be steep in between.
const FALLEN: f64 = 0.3;

/// A place within a step where a law may be steep although its ends do not tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Suspect {
    /// Which argument.
    pub law: usize,
    /// Where, in steps.
    pub place: f64,
    /// The argument at the start of the step, and there.
    start: f64,
    extreme: f64,
}

/// Arguments along a step: the values at [`PLACES`], and one of them anywhere.
pub(super) trait Course {
    fn sample(&self, index: usize) -> f64;
    fn value(&mut self, place: f64) -> f64;
}

impl Steep {
    /// Where a law with this argument may be steep, while it is not at the ends of the step. `layer` is [`super::half_width`].
    pub(super) fn suspect(self, law: usize, course: &mut impl Course, layer: f64) -> Option<Suspect> {
        let (start, end) = (course.sample(0), course.sample(PLACES.len() - 1));
        let found = |(place, extreme): (f64, f64)| Suspect { law, place, start, extreme };
        match self {
            Self::Growing => above(course, 1.0, |deepest| deepest + RISEN).map(found),
            Self::Singular if start == 0.0 => None,
            Self::Singular => {
                let side = start.signum();
                let level = FALLEN * f64::min(side * start, (side * end).abs());
                above(course, -side, |_| -level).map(found)
            }
            Self::Saturating | Self::Switching => {
                let width = if self == Self::Saturating { layer } else { 0.0 };
                // Below both ends, or above both.
                let [lowest, highest] = [f64::min(start, end), f64::max(start, end)];
                let below = edge_below(lowest, width).and_then(|edge| above(course, -1.0, |_| -edge));
                below.or_else(|| edge_below(-highest, width).and_then(|edge| above(course, 1.0, |_| -edge))).map(found)
            }
        }
    }

    /// Where the effect of a suspect begins that is so many times what may be overlooked, in steps.
    pub(super) fn begin(self, suspect: &Suspect, course: &mut impl Course, layer: f64, excess: f64) -> f64 {
        let Suspect { start, extreme, place, .. } = *suspect;
        let side = if extreme > start { 1.0 } else { -1.0 };
        let level = match self {
            Self::Growing => extreme - libm::log(excess) - 1.0,
            Self::Singular => FALLEN * start,
            Self::Saturating => -side * edge_below(-side * start, layer).unwrap_or(0.0),
            Self::Switching => 0.0,
        };
        let outside = |value: f64| side * value < side * level;
        let last = PLACES.iter().enumerate().rev().find(|&(index, at)| *at < place && outside(course.sample(index)));
        let Some((_, &(mut before))) = last else { return 0.5 * place };
        let mut after = place;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before + after);
            if outside(course.value(middle)) {
                before = middle;
            } else {
                after = middle;
            }
        }
        if before > 0.0 { before } else { 0.5 * place }
    }
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

/// The highest of the peaks within the step that the argument times a sign has, and where, if it is above a level that the deepest values on both sides
/// of it say.
fn above(course: &mut impl Course, sign: f64, level: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
    let points = std::array::from_fn::<_, { PLACES.len() }, _>(|index| (PLACES[index], sign * course.sample(index)));
    let mut best: Option<(usize, f64)> = None;
    for index in 1..PLACES.len() - 1 {
        let [before, at, after] = [points[index - 1], points[index], points[index + 1]];
        if at.1 >= before.1 && at.1 > after.1 {
            // Where the parabola through three places is far below, so is the argument.
            let most = 2.0 * peak([before, at, after]) - at.1;
            if best.is_none_or(|(_, highest)| most > highest) {
                best = Some((index, most));
            }
        }
    }
    let (index, most) = best?;
    let deepest = |points: &[(f64, f64)]| points.iter().fold(f64::INFINITY, |least, point| least.min(point.1));
    let level = level(deepest(&points[..index]).max(deepest(&points[index + 1..])));
    if most <= level {
        return None;
    }
    let (place, value) = largest(points[index - 1].0, points[index + 1].0, |place| sign * course.value(place));
    let (place, value) = if value > points[index].1 { (place, value) } else { points[index] };
    (value > level).then_some((place, sign * value))
}

/// The largest value of the parabola through three points whose middle one is the highest.
fn peak([(x0, y0), (x1, y1), (x2, y2)]: [(f64, f64); 3]) -> f64 {
    let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
    let curvature = (right - left) / (x2 - x0);
    let slope = (left * (x2 - x1) + right * (x1 - x0)) / (x2 - x0);
    if curvature < 0.0 { y1 - 0.25 * slope * slope / curvature } else { y1 }
}

/// By golden sections.
fn largest(mut from: f64, mut to: f64, mut value: impl FnMut(f64) -> f64) -> (f64, f64) {
    let (mut left, mut right) = (to - GOLDEN * (to - from), from + GOLDEN * (to - from));
    let (mut at_left, mut at_right) = (value(left), value(right));
    for _ in 0..SECTIONS {
        if at_left > at_right {
            (to, right, at_right) = (right, left, at_left);
            left = to - GOLDEN * (to - from);
            at_left = value(left);
        } else {
            (from, left, at_left) = (left, right, at_right);
            right = from + GOLDEN * (to - from);
            at_right = value(right);
        }
    }
    if at_left > at_right { (left, at_left) } else { (right, at_right) }
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
        kind.suspect(0, &mut Known(argument), LAYER)
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
    fn a_divisor_is_suspected_where_it_is_small() {
        let found = find(Steep::Singular, |at| -(at - 0.4) * (at - 0.4) - 1e-6).expect("nearly zero");
        assert!((found.place - 0.4).abs() < 1e-6);
        assert!(find(Steep::Singular, |at| 1.0 + (at - 0.4) * (at - 0.4)).is_none());
        assert!(find(Steep::Singular, |at| 1.0 - 0.9 * at).is_none());
    }

    #[test]
    fn a_layer_is_suspected_where_the_argument_turns_round_in_it_or_behind_it() {
        let turning = |least: f64| move |at: f64| least + 4000.0 * (at - 0.4) * (at - 0.4);
        assert!(find(Steep::Saturating, turning(LAYER + 1.0)).is_none());
        for least in [LAYER - 1.0, 0.0, -LAYER - 1.0] {
            let found = find(Steep::Saturating, turning(least)).expect("in the layer");
            assert!((found.place - 0.4).abs() < 1e-6);
            let begin = Steep::Saturating.begin(&found, &mut Known(turning(least)), LAYER, 1.0);
            assert!((turning(least)(begin) - LAYER).abs() < 1e-3, "{least}: {begin}");
            assert!(find(Steep::Saturating, |at| -turning(least)(at)).is_some());
        }
        // Both sides are seen from the ends.
        assert!(find(Steep::Saturating, |at| 1000.0 - 3000.0 * at).is_none());
        assert!(find(Steep::Switching, |at| 1.0 - 3.0 * at).is_none());
        assert!(find(Steep::Switching, |at| (at - 0.4) * (at - 0.4) - 1e-4).is_some());
    }
}
