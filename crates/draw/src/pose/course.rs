//! Ropes and bands over pulleys at the start: tangents and arcs.

use std::f64::consts::TAU;

use cotree::component::{Glyph, IconStroke};
use cotree::model::{Part, Station};

use super::PoseValues;
use crate::alike::Alike;
use crate::drawing::DrawnSpring;

/// Chords of an arc of one turn.
const CHORDS: f64 = 36.0;

/// A circle of a course: its body, its centre, its radius with the sign of its side.
struct Circle {
    body: Option<usize>,
    centre: [f64; 2],
    radius: f64,
}

impl Circle {
    /// Where a tangent with this direction touches it.
    fn touched(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.centre[0] + self.radius * y, self.centre[1] - self.radius * x]
    }
}

/// The direction of the tangent of two circles; that of their centres where they have none.
fn tangent(first: &Circle, second: &Circle) -> [f64; 2] {
    let [x, y] = [second.centre[0] - first.centre[0], second.centre[1] - first.centre[1]];
    let (square, across) = (x * x + y * y, second.radius - first.radius);
    if square == 0.0 {
        return [1.0, 0.0];
    }
    let along = (square - across * across).max(0.0).sqrt();
    [(along * x + across * y) / square, (along * y - across * x) / square]
}

fn thread(length: f64) -> Vec<IconStroke> {
    vec![IconStroke::open(vec![[0.0, 0.0], [length, 0.0]])]
}

impl PoseValues<'_> {
    /// The straight parts and arcs of a part over pulleys, its sign on the last straight part.
    pub(super) fn course(&mut self, part: &Part, glyph: Glyph) -> Vec<DrawnSpring> {
        let stations = part.stations().unwrap_or_default();
        let circles: Vec<Circle> = stations.iter().map(|station| self.circle(station)).collect();
        let tangents: Vec<[f64; 2]> = circles.windows(2).map(|pair| tangent(&pair[0], &pair[1])).collect();
        let mut drawn = Vec::new();
        let mut push = |name: &str, [first, second]: [&Circle; 2], ends: [[f64; 2]; 2], glyph: Glyph| {
            let between = [first.body, second.body];
            drawn.push(DrawnSpring::alone(name.to_owned(), between, ends, glyph));
        };
        for (number, pair) in circles.windows(2).enumerate() {
            let ends = [&pair[0], &pair[1]].map(|circle| circle.touched(tangents[number]));
            let is_last = number + 1 == tangents.len();
            push(
                if is_last { &part.name } else { "" },
                [&pair[0], &pair[1]],
                ends,
                if is_last { glyph } else { thread },
            );
        }
        for (circle, pair) in circles.iter().skip(1).zip(tangents.windows(2)) {
            let points = arc(circle, [pair[0], pair[1]]);
            points.windows(2).for_each(|ends| push("", [circle, circle], [ends[0], ends[1]], thread));
        }
        drawn
    }

    fn circle(&mut self, station: &Station) -> Circle {
        let body = station.at.body().map(|body| body.0);
        Circle { body, centre: self.at(station.at), radius: self.number(&station.radius) }
    }
}

/// Points along an arc from one tangent to the next.
fn arc(circle: &Circle, [before, after]: [[f64; 2]; 2]) -> Vec<[f64; 2]> {
    if circle.radius == 0.0 {
        return Vec::new();
    }
    let side = circle.radius.signum();
    let [sine, cosine] = [before[0] * after[1] - before[1] * after[0], before[0] * after[0] + before[1] * after[1]];
    let wrap = (side * sine).angle_over(cosine).rem_euclid(TAU);
    let chords = (CHORDS * wrap / TAU).ceil().max(1.0) as usize;
    let point = |chord: usize| {
        let (sine, cosine) = (side * wrap * chord as f64 / chords as f64).sine_and_cosine();
        circle.touched([cosine * before[0] - sine * before[1], sine * before[0] + cosine * before[1]])
    };
    (0..=chords).map(point).collect()
}
