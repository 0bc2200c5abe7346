//! A body guided by two dyads: its pose as a function of the input.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::dyad::Dyad;
use crate::poses::Pose;
use crate::{Point, cross, dot, polar};

/// A body that two dyads guide. The first one is the input: a bar turns, a slider is moved along its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linkage {
    /// The dyad of the input.
    pub first: Dyad,
    /// The other one.
    pub second: Dyad,
}

/// Which of the two ways in which the body fits onto both dyads.
pub type Side = f64;

/// `x cos phi + y sin phi = z` for the angle of the body.
struct Equation {
    vector: Point,
    value: f64,
}

impl Linkage {
    /// With the other dyad for an input.
    #[must_use]
    pub fn swapped(&self) -> Linkage {
        Linkage { first: self.second, second: self.first }
    }

    /// Can the first dyad be the input? A slot's line would have to be turned by hand.
    pub fn has_input(&self) -> bool {
        !matches!(self.first, Dyad::Slot { .. })
    }

    /// The input at a pose: the angle of the bar \[rad\], or the place of the slider along its line \[m\].
    pub fn input(&self, pose: &Pose) -> f64 {
        match self.first {
            Dyad::Bar { moving, ground, .. } => (pose.carry(moving) - ground).arg(),
            Dyad::Slider { moving, normal, .. } => cross(normal, pose.carry(moving)),
            Dyad::Slot { .. } => pose.angle,
        }
    }

    /// The point of the body that the input moves.
    pub fn moved(&self) -> Point {
        match self.first {
            Dyad::Bar { moving, .. } | Dyad::Slider { moving, .. } => moving,
            Dyad::Slot { .. } => Point::new(0.0, 0.0),
        }
    }

    /// Where the input takes that point.
    pub fn pin(&self, input: f64) -> Point {
        match self.first {
            Dyad::Bar { ground, length, .. } => ground + polar(length, input),
            Dyad::Slider { normal, offset, .. } => normal * Point::new(offset, input),
            Dyad::Slot { ground, .. } => ground,
        }
    }

    fn equation(&self, pin: Point) -> Equation {
        let from = self.moved();
        match self.second {
            Dyad::Bar { moving, ground, length } => {
                let (bar, to) = (moving - from, ground - pin);
                // to . R bar = (|to|^2 + |bar|^2 - length^2) / 2
                let value = 0.5 * (to.norm_sqr() + bar.norm_sqr() - length * length);
                Equation { vector: to * bar.conj(), value }
            }
            Dyad::Slider { moving, normal, offset } => {
                Equation { vector: normal * (moving - from).conj(), value: offset - dot(normal, pin) }
            }
            Dyad::Slot { ground, normal, offset } => {
                let to = ground - pin;
                Equation { vector: to * normal.conj(), value: offset - dot(normal, from) }
            }
        }
    }

    /// The pose at an input and on a side; none where the dyads do not reach each other.
    pub fn pose(&self, input: f64, side: Side) -> Option<Pose> {
        let pin = self.pin(input);
        let Equation { vector, value } = self.equation(pin);
        let cosine = value / vector.norm();
        if cosine.is_nan() || cosine.abs() > 1.0 {
            return None;
        }
        let angle = vector.arg() + side * cosine.acos();
        Some(Pose { at: pin - polar(1.0, angle) * self.moved(), angle })
    }

    /// The sine of the angle that is zero where both sides meet: dead points of this input.
    pub fn sine(&self, pose: &Pose) -> f64 {
        let vector = self.equation(pose.carry(self.moved())).vector;
        cross(vector, pose.turn()) / vector.norm()
    }

    /// The side on which a pose is: 1 or -1.
    pub fn side(&self, pose: &Pose) -> Side {
        if self.sine(pose) < 0.0 { -1.0 } else { 1.0 }
    }

    /// The transmission angle at a pose \[rad\], at most a right one.
    ///
    /// Between body and second bar; between body and normal of the slider, from a right angle; for a slot: between its line and the way to its point.
    pub fn transmission(&self, pose: &Pose) -> f64 {
        let from = self.moved();
        match self.second {
            Dyad::Bar { moving, ground, .. } => {
                let place = pose.carry(moving);
                let (body, bar) = (place - pose.carry(from), ground - place);
                (cross(body, bar) / (body.norm() * bar.norm())).abs().min(1.0).asin()
            }
            Dyad::Slider { .. } | Dyad::Slot { .. } => self.sine(pose).abs().min(1.0).asin(),
        }
    }

    /// Inputs in the middle of what the input cannot reach, as far as they are between places that it reaches: none if it is free.
    pub fn gaps(&self) -> Vec<f64> {
        let out_of_reach = |input: &f64| {
            let Equation { vector, value } = self.equation(self.pin(*input));
            value.abs() > vector.norm()
        };
        self.extremes().into_iter().filter(out_of_reach).collect()
    }

    /// Inputs at which the dyads are nearest to each other, or farthest away.
    pub fn extremes(&self) -> Vec<f64> {
        match (self.first, self.second) {
            (Dyad::Bar { ground, .. }, Dyad::Bar { ground: other, .. } | Dyad::Slot { ground: other, .. }) => {
                let along = (other - ground).arg();
                vec![along, along + PI]
            }
            (Dyad::Bar { .. }, Dyad::Slider { normal, .. }) => vec![normal.arg(), normal.arg() + PI],
            (Dyad::Slider { normal, .. }, Dyad::Bar { ground, .. } | Dyad::Slot { ground, .. }) => {
                vec![cross(normal, ground)]
            }
            (Dyad::Slider { .. }, Dyad::Slider { .. }) | (Dyad::Slot { .. }, _) => Vec::new(),
        }
    }

    /// Can the input turn fully?
    pub fn turns_fully(&self) -> bool {
        matches!(self.first, Dyad::Bar { .. }) && self.gaps().is_empty()
    }

    /// Lengths of ground, first bar, body between the pins, second bar; where there is a slider or a slot, of what there is.
    pub fn lengths(&self) -> [Option<f64>; 4] {
        let bar = |dyad: &Dyad| match *dyad {
            Dyad::Bar { moving, ground, length } => (Some(moving), Some(ground), Some(length)),
            Dyad::Slider { moving, .. } => (Some(moving), None, None),
            Dyad::Slot { ground, .. } => (None, Some(ground), None),
        };
        let ((a, a0, first), (b, b0, second)) = (bar(&self.first), bar(&self.second));
        let between = |one: Option<Point>, other: Option<Point>| Some((other? - one?).norm());
        [between(a0, b0), first, between(a, b), second]
    }

    /// The largest distance of two points of one link, the ground included; with `tracer` the body's origin is one of its points \[m\].
    pub fn size(&self, tracer: bool) -> f64 {
        let arm = |dyad: &Dyad| match *dyad {
            Dyad::Bar { moving, .. } | Dyad::Slider { moving, .. } if tracer => Some(moving.norm()),
            Dyad::Bar { .. } | Dyad::Slider { .. } | Dyad::Slot { .. } => None,
        };
        let arms = [arm(&self.first), arm(&self.second)];
        self.lengths().into_iter().chain(arms).flatten().fold(0.0, f64::max)
    }

    /// A point's place on the coupler curve: at an input, and on a side.
    pub fn trace(&self, point: Point, input: f64, side: Side) -> Option<Point> {
        self.pose(input, side).map(|pose| pose.carry(point))
    }

    /// The inputs that can be reached on both sides of the loop around a pose: from where to where; none if the input is free.
    pub fn range(&self, near: f64) -> Option<[f64; 2]> {
        let [low, high] = [-1.0, 1.0].map(|direction| self.end_of_motion(near, direction));
        Some([near - low?, near + high?])
    }

    /// How far the input goes in a direction until a dead point; none if it never ends.
    fn end_of_motion(&self, from: f64, direction: f64) -> Option<f64> {
        let turns = matches!(self.first, Dyad::Bar { .. });
        let gaps = self.gaps();
        let reaches = |way: f64| {
            let Equation { vector, value } = self.equation(self.pin(from + direction * way));
            value.abs() <= vector.norm()
        };
        let mut bad = if turns {
            let ahead = gaps.iter().map(|gap| (direction * (gap - from)).rem_euclid(2.0 * PI));
            ahead.min_by(f64::total_cmp)?
        } else {
            let ahead = gaps.iter().map(|gap| direction * (gap - from)).filter(|way| *way > 0.0);
            match ahead.min_by(f64::total_cmp) {
                Some(way) => way,
                None => (0..60).map(|i| 1e-3 * 2f64.powi(i)).find(|way| !reaches(*way))?,
            }
        };
        let mut good = 0.0;
        for _ in 0..100 {
            let middle = 0.5 * (good + bad);
            if reaches(middle) { good = middle } else { bad = middle }
        }
        Some(good)
    }

    /// All of the closed curve on which a pose is, in so many steps: inputs and sides, in the order in which they are passed.
    pub fn circuit(&self, near: &Pose, steps: usize) -> Vec<(f64, Side)> {
        let (input, side) = (self.input(near), self.side(near));
        let part = |step: usize| 2.0 * PI * step as f64 / steps as f64;
        match self.range(input) {
            None => (0..steps).map(|step| (part(step), side)).collect(),
            Some([low, high]) => {
                let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
                let at = |step: usize| {
                    let angle = part(step) + 0.5 * part(1);
                    (middle - half * angle.cos(), if angle < PI { side } else { -side })
                };
                (0..steps).map(at).collect()
            }
        }
    }

    /// The smallest transmission angle \[rad\] over a way of the input on a side, from one input to another.
    pub fn smallest_transmission(&self, [from, to]: [f64; 2], side: Side) -> f64 {
        const STEPS: usize = 64;
        let turns = matches!(self.first, Dyad::Bar { .. });
        let (low, high) = (from.min(to), from.max(to));
        let inside = self
            .extremes()
            .into_iter()
            .map(|extreme| if turns { extreme + ((low - extreme) / (2.0 * PI)).ceil() * 2.0 * PI } else { extreme });
        let even = (0..=STEPS).map(|step| low + (high - low) * step as f64 / STEPS as f64);
        let all = inside.filter(|value| (low..=high).contains(value)).chain(even);
        let angle = |input| self.pose(input, side).map_or(0.0, |pose| self.transmission(&pose));
        all.map(angle).fold(FRAC_PI_2, f64::min)
    }
}
