//! The profile of a contact: a chain of lines and arcs, and the same moved outwards by the radius of the disc that touches it.
//!
//! Seen along the chain with the free side on the left, an arc that turns right is convex, and so is a corner at which the chain turns right: about it the moved chain is an arc. Where it turns left the
//! moved chain has a corner, which the disc reaches on both of its features at once.

use std::f64::consts::PI;

use super::{Mechanism, Part};
use crate::diagnostic::Span;

/// Corners that are closer together than this share of the profile are one.
const SAME: f64 = 1e-9;
/// Tangents whose directions differ by less \[rad\] are the same.
const SMOOTH: f64 = 1e-9;
/// An arc is as many chords where crossings are looked for.
const CHORDS: usize = 16;

/// A corner of a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct ContourCorner {
    /// From the first point of the contact, in the axes of its body \[m\].
    pub at: [f64; 2],
    /// What leads to it: an arc with this radius \[m\], positive if it turns left, or a line.
    pub arc: Option<f64>,
    /// Where it stands in the file.
    pub span: Span,
}

/// What a disc touches.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// In their order, with the free side on the left; of an outline an arc that leads to the first one comes from the last.
    pub corners: Vec<ContourCorner>,
    /// True for an outline, whose last corner leads to the first.
    pub closed: bool,
    /// The radius of the disc \[m\].
    pub radius: f64,
}

/// A line or an arc of a moved profile, seen from its middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    pub at: [f64; 2],
    /// Towards the free side.
    pub normal: [f64; 2],
    /// Positive where it is convex \[1/m\].
    pub curvature: f64,
    /// From its middle to its ends \[m\].
    pub half: f64,
    /// Its ends before it is moved.
    pub ends: [[f64; 2]; 2],
    /// What goes on before it and behind it.
    pub joints: [FeatureJoint; 2],
}

/// What is at an end of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeatureJoint {
    /// Another feature with the same tangent.
    Smooth(usize),
    /// A concave corner.
    Concave,
    /// Nothing.
    Free,
}

/// What is wrong with a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Flaw {
    pub span: Span,
    pub message: String,
    pub label: &'static str,
    pub help: String,
}

/// A line or an arc between two corners.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: [f64; 2],
    to: [f64; 2],
    /// Its radius, positive if it turns left; none for a line.
    arc: Option<f64>,
}

impl Piece {
    fn chord(&self) -> f64 {
        length(minus(self.to, self.from))
    }

    /// Half of the angle by which it turns, positive to the left.
    fn half_turn(&self) -> f64 {
        self.arc.map_or(0.0, |radius| (0.5 * self.chord() / radius).clamp(-1.0, 1.0).asin())
    }

    /// The direction of its chord.
    fn direction(&self) -> f64 {
        let [x, y] = minus(self.to, self.from);
        y.atan2(x)
    }

    fn tangents(&self) -> [f64; 2] {
        let (direction, half) = (self.direction(), self.half_turn());
        [direction - half, direction + half]
    }

    /// Its middle, and its normal there.
    fn middle(&self) -> ([f64; 2], [f64; 2]) {
        let (sine, cosine) = self.direction().sin_cos();
        let normal = [-sine, cosine];
        let centre = [0, 1].map(|axis| 0.5 * (self.from[axis] + self.to[axis]));
        // An arc that turns left is on the right of its chord.
        let height = self.arc.map_or(0.0, |radius| radius * (1.0 - self.half_turn().cos()));
        (along(centre, normal, -height), normal)
    }

    fn feature(&self, radius: f64, joints: [FeatureJoint; 2]) -> Feature {
        let (middle, normal) = self.middle();
        let (curvature, half) = match self.arc {
            None => (0.0, 0.5 * self.chord()),
            // The free side is on the left: there an arc that turns left has its centre.
            Some(arc) => (-1.0 / (arc - radius), self.half_turn() * (arc - radius)),
        };
        Feature { at: along(middle, normal, radius), normal, curvature, half, ends: [self.from, self.to], joints }
    }

    /// Places along it, for a look at crossings.
    fn chords(&self) -> Vec<[f64; 2]> {
        let Some(arc) = self.arc else { return vec![self.from, self.to] };
        let (start, turn) = (self.tangents()[0], 2.0 * self.half_turn());
        let place = |number: usize| {
            let angle = turn * number as f64 / CHORDS as f64;
            let (chord, direction) = (2.0 * arc * (0.5 * angle).sin(), start + 0.5 * angle);
            along(self.from, [direction.cos(), direction.sin()], chord)
        };
        (0..=CHORDS).map(place).collect()
    }
}

impl Contour {
    /// The profile run through backwards, with its free side on the other side.
    pub fn reversed(mut self) -> Contour {
        let count = self.corners.len();
        let leads: Vec<Option<f64>> = self.corners.iter().map(|corner| corner.arc).collect();
        self.corners.reverse();
        for (index, corner) in self.corners.iter_mut().enumerate() {
            // What has led from the corner that is now before it.
            corner.arc = leads[(count - index) % count].map(|radius| -radius);
        }
        self
    }

    /// An outline may end with its first corner once more: what leads there leads to that.
    pub fn close(&mut self) {
        let [first, .., last] = &mut self.corners[..] else { return };
        if first.at == last.at && first.arc.is_none() {
            (first.arc, first.span) = (last.arc, last.span);
            self.corners.pop();
        }
    }

    fn pieces(&self) -> Vec<(Piece, Span)> {
        let count = self.corners.len();
        let first = usize::from(!self.closed);
        let piece = |index: usize| {
            let (before, corner) = (&self.corners[(index + count - 1) % count], &self.corners[index]);
            (Piece { from: before.at, to: corner.at, arc: corner.arc }, corner.span)
        };
        let mut all: Vec<_> = (first..count).map(piece).collect();
        if self.closed {
            // It begins at its first corner.
            all.rotate_left(1);
        }
        all
    }

    /// Everything that is wrong with it.
    pub fn flaws(&self) -> Vec<Flaw> {
        let pieces = self.pieces();
        let size = self.size();
        let mut flaws = Vec::new();
        for (piece, span) in &pieces {
            flaws.extend(self.flaw_of_piece(piece, *span, size));
        }
        if !flaws.is_empty() {
            return flaws;
        }
        for (index, turn) in self.turns(&pieces) {
            let (at, span) = (pieces[index].0.to, pieces[index].1);
            let [x, y] = at;
            if turn.abs() > PI - SMOOTH {
                flaws.push(Flaw {
                    span,
                    message: format!("goes back on itself at [{x}, {y}]"),
                    label: "goes back",
                    help: "move this corner or the next one: the profile needs a free side".to_owned(),
                });
            } else if turn < -SMOOTH && self.radius == 0.0 {
                flaws.push(Flaw {
                    span,
                    message: format!("has a convex corner at [{x}, {y}], where a point has no normal"),
                    label: "convex corner",
                    help: "give the point a `radius`, such as `radius = \"1 mm\"`, round the corner by an arc, or write the other `side`".to_owned(),
                });
            }
        }
        flaws.extend(self.crossing(&pieces));
        flaws
    }

    fn flaw_of_piece(&self, piece: &Piece, span: Span, size: f64) -> Option<Flaw> {
        let chord = piece.chord();
        let [x, y] = piece.to;
        // What is not a number is not larger.
        let is_long = chord > SAME * size;
        if !is_long {
            return Some(Flaw {
                span,
                message: format!("has the corner [{x}, {y}] twice in a row"),
                label: "again",
                help: "remove one of them".to_owned(),
            });
        }
        let arc = piece.arc?;
        if 2.0 * arc.abs() < chord {
            return Some(Flaw {
                span,
                message: format!(
                    "has an arc of radius {} m to [{x}, {y}], but its ends are {chord} m apart",
                    arc.abs()
                ),
                label: "too small a radius",
                help: format!("give it at least half of that: {} m", 0.5 * chord),
            });
        }
        (arc > 0.0 && arc <= self.radius).then(|| Flaw {
            span,
            message: format!(
                "has a concave arc of radius {arc} m to [{x}, {y}], into which the disc of radius {} m does not fit",
                self.radius
            ),
            label: "concave",
            help: "make the arc larger, the disc smaller, or write the other `side`".to_owned(),
        })
    }

    /// The angle by which the profile turns at each corner within it, with the piece before it.
    fn turns(&self, pieces: &[(Piece, Span)]) -> Vec<(usize, f64)> {
        let count = pieces.len();
        let last = if self.closed { count } else { count.saturating_sub(1) };
        let turn = |index: usize| {
            let [before, after] = [pieces[index].0.tangents()[1], pieces[(index + 1) % count].0.tangents()[0]];
            let (sine, cosine) = (after - before).sin_cos();
            (index, sine.atan2(cosine))
        };
        (0..last).map(turn).collect()
    }

    /// Where it crosses itself.
    fn crossing(&self, pieces: &[(Piece, Span)]) -> Option<Flaw> {
        let chords: Vec<(usize, Vec<[f64; 2]>)> =
            pieces.iter().enumerate().map(|(index, (piece, _))| (index, piece.chords())).collect();
        let segments: Vec<(usize, [f64; 2], [f64; 2])> = chords
            .iter()
            .flat_map(|(index, places)| places.windows(2).map(move |pair| (*index, pair[0], pair[1])))
            .collect();
        let count = segments.len();
        for first in 0..count {
            for second in first + 1..count {
                let follow = second == first + 1 || self.closed && first == 0 && second == count - 1;
                let (a, b) = (&segments[first], &segments[second]);
                if !follow && cross([a.1, a.2], [b.1, b.2]) {
                    let [x, y] = pieces[b.0].0.to;
                    return Some(Flaw {
                        span: pieces[b.0].1,
                        message: format!("crosses or touches itself on the way to [{x}, {y}]"),
                        label: "crosses",
                        help: "give the corners in the order in which they follow each other; two profiles are two contacts".to_owned(),
                    });
                }
            }
        }
        None
    }

    /// The largest distance between the sides of what it lies in.
    fn size(&self) -> f64 {
        let all = || self.corners.iter().map(|corner| corner.at);
        let [x, y] = [0, 1].map(|axis| {
            let most = all().fold(f64::NEG_INFINITY, |most, at| most.max(at[axis]));
            most - all().fold(f64::INFINITY, |least, at| least.min(at[axis]))
        });
        x.max(y)
    }

    /// The lines and arcs of the moved profile: of one without flaws.
    pub fn features(&self) -> Vec<Feature> {
        let pieces = self.pieces();
        let turns = self.turns(&pieces);
        let rounds = |index: usize| turns.iter().any(|(at, turn)| *at == index && *turn < -SMOOTH);
        let has_ends = !self.closed && self.radius > 0.0;
        // The place of each piece among the features: arcs about convex corners are between them, and about the ends of a profile.
        let mut places = Vec::with_capacity(pieces.len());
        let mut next = usize::from(has_ends);
        for index in 0..pieces.len() {
            places.push(next);
            next += 1 + usize::from(rounds(index));
        }
        let total = next + usize::from(has_ends);
        let joint = |index: usize, turn: Option<f64>, other: usize| match turn {
            _ if rounds(index) || turn.is_some_and(|turn| turn.abs() <= SMOOTH) => FeatureJoint::Smooth(other),
            Some(_) => FeatureJoint::Concave,
            None if has_ends => FeatureJoint::Smooth(other),
            None => FeatureJoint::Free,
        };
        let turn_at = |index: usize| turns.iter().find(|(at, _)| *at == index).map(|(_, turn)| *turn);
        let mut all = Vec::with_capacity(total);
        let count = pieces.len();
        if has_ends {
            all.push(self.end(
                pieces[0].0.from,
                pieces[0].0.tangents()[0] + PI,
                [FeatureJoint::Free, FeatureJoint::Smooth(1)],
            ));
        }
        for (index, (piece, _)) in pieces.iter().enumerate() {
            let before = (index + count - 1) % count;
            let is_first = index == 0 && !self.closed;
            let joints = [
                joint(before, if is_first { None } else { turn_at(before) }, (places[index] + total - 1) % total),
                joint(index, turn_at(index), (places[index] + 1) % total),
            ];
            let joints = if is_first && !has_ends { [FeatureJoint::Free, joints[1]] } else { joints };
            all.push(piece.feature(self.radius, joints));
            if let Some(turn) = turn_at(index).filter(|_| rounds(index)) {
                let normal = piece.tangents()[1] + 0.5 * PI + 0.5 * turn;
                let (before, behind) = (places[index], (places[index] + 2) % total);
                let joints = [before, behind].map(FeatureJoint::Smooth);
                all.push(self.corner(piece.to, (normal, -0.5 * turn), joints));
            }
        }
        if has_ends {
            let last = pieces[count - 1].0;
            all.push(self.end(last.to, last.tangents()[1], [FeatureJoint::Smooth(total - 2), FeatureJoint::Free]));
        }
        all
    }

    /// An arc about a corner.
    fn corner(&self, at: [f64; 2], (normal, half): (f64, f64), joints: [FeatureJoint; 2]) -> Feature {
        let normal = [normal.cos(), normal.sin()];
        let (curvature, half) = (1.0 / self.radius, half * self.radius);
        Feature { at: along(at, normal, self.radius), normal, curvature, half, ends: [at, at], joints }
    }

    /// The half circle about an end, from one side of the profile to the other.
    fn end(&self, at: [f64; 2], normal: f64, joints: [FeatureJoint; 2]) -> Feature {
        self.corner(at, (normal, 0.5 * PI), joints)
    }

    /// In how many places a disc may touch it at once: one if it is convex, else two and one more where a gap is as wide as the disc.
    pub fn most_places(&self) -> usize {
        let pieces = self.pieces();
        let turns = self.turns(&pieces);
        let arcs = pieces.iter().map(|(piece, _)| 2.0 * piece.half_turn());
        let all: Vec<f64> = turns.iter().map(|(_, turn)| *turn).chain(arcs).collect();
        let is_convex = all.iter().all(|turn| *turn <= SMOOTH);
        let turned: f64 = all.iter().sum();
        if is_convex && (self.closed || turned >= -PI - SMOOTH) { 1 } else { 3 }
    }

    /// Its course as places, for a picture.
    pub fn places(&self) -> Vec<[f64; 2]> {
        let pieces = self.pieces();
        let first = pieces.first().map(|(piece, _)| piece.from);
        first.into_iter().chain(pieces.iter().flat_map(|(piece, _)| piece.chords().into_iter().skip(1))).collect()
    }
}

impl Part {
    /// The profile that it touches, if it has one.
    pub fn contour(&self) -> Option<&Contour> {
        self.values
            .iter()
            .find_map(|(_, value)| if let super::KeyValue::Contour(contour) = value { Some(contour) } else { None })
    }
}

impl Mechanism {
    /// The first part that touches a profile.
    pub fn first_at_profile(&self) -> Option<&Part> {
        self.parts().find(|part| part.contour().is_some())
    }
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn along(from: [f64; 2], direction: [f64; 2], by: f64) -> [f64; 2] {
    [from[0] + direction[0] * by, from[1] + direction[1] * by]
}

fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

/// True if two straight pieces have a place in common.
fn cross([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let side = |from: [f64; 2], to: [f64; 2], at: [f64; 2]| {
        let ([ux, uy], [vx, vy]) = (minus(to, from), minus(at, from));
        ux * vy - uy * vx
    };
    let within = |from: [f64; 2], to: [f64; 2], at: [f64; 2]| {
        (0..2).all(|axis| at[axis] >= from[axis].min(to[axis]) && at[axis] <= from[axis].max(to[axis]))
    };
    let [one, two, three, four] = [side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)];
    if one * two < 0.0 && three * four < 0.0 {
        return true;
    }
    let on = [(one, a, b, c), (two, a, b, d), (three, c, d, a), (four, c, d, b)];
    on.into_iter().any(|(side, from, to, at)| side == 0.0 && within(from, to, at))
}
