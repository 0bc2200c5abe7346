//! What grows without bound: at dead points of the input rates do, and where branches of the motion cross joint forces may, if the input moves on at constant speed. There is no
//! largest value then, only figures of the rest.

use serde::Serialize;

use super::SpecialPlaces;
use super::samples::{Samples, ValueAt};

/// Figures leave out this share of the way on either side: a convention, as a peak is as large as one comes close.
const LEFT_OUT: f64 = 0.02;
/// Values are compared in so many times the distance, twice.
const FARTHER: f64 = 4.0;
/// Changes below this share of the largest value are none.
const CHANGE: f64 = 1e-6;

/// Where a quantity grows without bound, and how near to there its figures come.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unbounded {
    /// The inputs.
    pub at: Vec<f64>,
    pub distance: f64,
}

/// What figures are made of: all samples, or those that are not next to where they grow without bound.
pub(super) struct Figured {
    pieces: Vec<Samples>,
    pub unbounded: Option<Unbounded>,
}

impl Figured {
    pub fn of(samples: &Samples, places: &SpecialPlaces) -> Figured {
        let places: Vec<SideOfPlace> = SideOfPlace::all(places).filter(|place| place.is_pole(samples)).collect();
        if places.is_empty() {
            return Figured { pieces: vec![samples.clone()], unbounded: None };
        }
        let near = LEFT_OUT * samples.span();
        let distance = |index: usize| {
            places.iter().filter_map(|place| place.distance(samples, index)).fold(f64::INFINITY, f64::min)
        };
        let is_far: Vec<bool> = (0..samples.values().len()).map(|index| distance(index) >= near).collect();
        let far = is_far.iter().enumerate().filter(|(_, is_far)| **is_far).map(|(index, _)| distance(index));
        let mut at: Vec<f64> = places.iter().map(|place| place.input).collect();
        at.dedup();
        let unbounded = Some(Unbounded { at, distance: far.fold(f64::INFINITY, f64::min) });
        Figured { pieces: samples.pieces(&is_far), unbounded }
    }

    pub fn max(&self) -> ValueAt {
        self.extreme(Samples::max, |a, b| a > b)
    }

    pub fn min(&self) -> ValueAt {
        self.extreme(Samples::min, |a, b| a < b)
    }

    fn extreme(&self, of: fn(&Samples) -> ValueAt, beats: fn(f64, f64) -> bool) -> ValueAt {
        let found =
            self.pieces.iter().map(of).reduce(|best, piece| if beats(piece.value, best.value) { piece } else { best });
        found.unwrap_or(ValueAt { input: f64::NAN, value: f64::NAN })
    }

    pub fn mean(&self) -> f64 {
        let whole: f64 = self.pieces.iter().map(Samples::span).sum();
        match &self.pieces[..] {
            [all] => all.mean(),
            pieces => pieces.iter().map(|piece| piece.mean() * piece.span()).sum::<f64>() / whole,
        }
    }

    pub fn rms(&self) -> f64 {
        match &self.pieces[..] {
            [all] => all.rms(),
            _ => self.map(|value| value * value).mean().sqrt(),
        }
    }

    fn map(&self, of: fn(f64) -> f64) -> Figured {
        Figured { pieces: self.pieces.iter().map(|piece| piece.map(of)).collect(), unbounded: self.unbounded.clone() }
    }
}

/// One side of a special place.
struct SideOfPlace {
    input: f64,
    /// 1.0: the samples above it.
    side: f64,
}

impl SideOfPlace {
    fn all(places: &SpecialPlaces) -> impl Iterator<Item = SideOfPlace> {
        let sides = match places {
            SpecialPlaces::Ordinary => Vec::new(),
            SpecialPlaces::Folds(folds) => {
                folds.iter().zip([1.0, -1.0]).filter_map(|(at, side)| Some(((*at)?, side))).collect()
            }
            SpecialPlaces::Crossings(inputs) => {
                inputs.iter().flat_map(|input| [(*input, 1.0), (*input, -1.0)]).collect()
            }
        };
        sides.into_iter().map(|(input, side)| SideOfPlace { input, side })
    }

    /// How far a sample is from there; none on the other side.
    fn distance(&self, samples: &Samples, index: usize) -> Option<f64> {
        let way = self.side * (samples.input(index) - self.input);
        let way = if samples.is_periodic() { way.rem_euclid(std::f64::consts::TAU) } else { way };
        (way > 0.0).then_some(way)
    }

    /// Do values change more from near to nearer than from far to near? Those of a power series of the root of the distance do not.
    fn is_pole(&self, samples: &Samples) -> bool {
        let next_to = |wanted: f64| {
            let distances =
                (0..samples.values().len()).filter_map(|index| Some((index, self.distance(samples, index)?)));
            distances.min_by(|a, b| (a.1 - wanted).abs().total_cmp(&(b.1 - wanted).abs()))
        };
        let Some((nearest, distance)) = next_to(0.0) else { return false };
        let values = [FARTHER, FARTHER * FARTHER].map(|times| next_to(times * distance).map(|(index, _)| index));
        let [Some(near), Some(far)] = values else { return false };
        let [nearest, near, far] = [nearest, near, far].map(|index| samples.values()[index]);
        let least = CHANGE * samples.values().iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let [nearer, farther] = [(nearest - near).abs(), (near - far).abs()];
        nearer > farther && nearer > least
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// A range between folds, as the motion samples it.
    fn range(of: impl Fn(f64) -> f64) -> Samples {
        let [first, last] = [1e-3, 0.999];
        let step = (last - first) / 720.0;
        Samples::new([first, step], (0..=720).map(|index| of(first + step * f64::from(index))).collect(), false)
    }

    #[test]
    fn what_grows_is_told_from_what_is_steep() {
        let folds = SpecialPlaces::Folds([Some(0.0), Some(1.0)]);
        for power in [-0.5, -1.0, -1.5] {
            let figured = Figured::of(&range(|x| 3.0 - x.powf(power)), &folds);
            let unbounded = figured.unbounded.clone().unwrap();
            assert_eq!(unbounded.at, [0.0], "{power}");
            assert!((unbounded.distance - 0.02).abs() < 2e-3, "{unbounded:?}");
            assert!((figured.min().value - (3.0 - unbounded.distance.powf(power))).abs() < 1e-9, "{power}");
        }
        for bounded in [|x: f64| x.sqrt(), |x: f64| 5.0 - 2.0 * x.sqrt() + x, |x: f64| x * x, |_| 4.0] {
            let all = range(bounded);
            let figured = Figured::of(&all, &folds);
            assert_eq!((figured.unbounded.as_ref(), figured.max(), figured.rms()), (None, all.max(), all.rms()));
        }
    }

    #[test]
    fn figures_of_a_turn_leave_out_both_sides() {
        let step = TAU / 720.0;
        let turn = (0..720).map(|index| 1.0 / (step * (f64::from(index) + 0.5)).sin()).collect();
        let figured =
            Figured::of(&Samples::new([0.5 * step, step], turn, true), &SpecialPlaces::Crossings(vec![0.0, PI]));
        let Unbounded { at, distance } = figured.unbounded.clone().unwrap();
        assert_eq!(at, [0.0, PI]);
        assert!(distance >= 0.02 * TAU && distance < 0.02 * TAU + step, "{distance}");
        assert!((figured.max().value - 1.0 / distance.sin()).abs() < 1e-9, "{:?}", figured.max());
        // The integral of 1/sin^2 is -cot.
        let mean_square = (2.0 / distance.tan() - 0.0) / (PI - 2.0 * distance);
        assert!((figured.rms() / mean_square.sqrt() - 1.0).abs() < 1e-3, "{}", figured.rms());
    }
}
