//! Planar vectors by frames. Every vector of the equations is a sum of parts fixed in frames (one for each independent
//! angle); parts of one frame are added before any sine or cosine is taken. A product of two vectors is then a sum over
//! *pairs* of frames: within one frame it is a constant of the motion.

use std::collections::BTreeMap;

use super::form::{Coefficient, Form};
use crate::expr::{Arena, Expr};

/// Index of a frame; 0 is the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameId(usize);

impl FrameId {
    pub const WORLD: FrameId = FrameId(0);
}

#[derive(Clone, Debug)]
pub struct Frame {
    pub unit: [Expr; 2],
    /// omega, linear in the rates.
    pub rate: Form<Expr>,
    /// alpha, linear in the accelerations.
    pub acceleration: Form<Expr>,
    /// omega as one expression.
    pub omega: Expr,
    /// Its angle, without constants.
    pub angle: Expr,
}

#[derive(Clone, Debug)]
pub struct Frames(Vec<Frame>);

impl Default for Frames {
    fn default() -> Self {
        let world = Frame {
            unit: [Expr::ONE, Expr::ZERO],
            rate: Form::default(),
            acceleration: Form::default(),
            omega: Expr::ZERO,
            angle: Expr::ZERO,
        };
        Frames(vec![world])
    }
}

impl Frames {
    pub fn push(&mut self, frame: Frame) -> FrameId {
        self.0.push(frame);
        FrameId(self.0.len() - 1)
    }

    /// A frame that is none of these, the index-th of its kind.
    pub fn other(&self, index: usize) -> FrameId {
        FrameId(self.0.len() + index)
    }

    pub fn iter(&self) -> impl Iterator<Item = (FrameId, &Frame)> {
        self.0.iter().enumerate().map(|(index, frame)| (FrameId(index), frame))
    }

    pub fn get(&self, id: FrameId) -> &Frame {
        &self.0[id.0]
    }

    /// cos and sin of (angle of g - angle of f).
    fn relative(&self, arena: &mut Arena, f: FrameId, g: FrameId) -> [Expr; 2] {
        let ([cf, sf], [cg, sg]) = (self.get(f).unit, self.get(g).unit);
        let (cc, ss) = (arena.multiply(cf, cg), arena.multiply(sf, sg));
        let (cs, sc) = (arena.multiply(cf, sg), arena.multiply(sf, cg));
        [arena.add(cc, ss), arena.subtract(cs, sc)]
    }
}

/// A vector: for each frame, components in the axes of that frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vector(BTreeMap<FrameId, [Expr; 2]>);

impl Vector {
    pub fn x() -> Self {
        Vector(BTreeMap::from([(FrameId::WORLD, [Expr::ONE, Expr::ZERO])]))
    }

    pub fn y() -> Self {
        Vector(BTreeMap::from([(FrameId::WORLD, [Expr::ZERO, Expr::ONE])]))
    }

    pub fn fixed(frame: FrameId, components: [Expr; 2]) -> Self {
        if components == [Expr::ZERO; 2] { Vector::default() } else { Vector(BTreeMap::from([(frame, components)])) }
    }

    /// Its parts: frame and components in the axes of that frame.
    pub fn parts(&self) -> impl Iterator<Item = (FrameId, [Expr; 2])> {
        self.0.iter().map(|(&frame, &components)| (frame, components))
    }

    pub fn frames(&self) -> impl Iterator<Item = FrameId> {
        self.0.keys().copied()
    }

    /// Turned by +90 degrees: k x self.
    pub fn turned(&self, arena: &mut Arena) -> Self {
        Vector(self.0.iter().map(|(&frame, &[x, y])| (frame, [arena.negate(y), x])).collect())
    }

    pub fn dot(&self, arena: &mut Arena, other: &Vector) -> Scalar {
        self.product(arena, other, |arena, [a, b], [c, d]| {
            let (ac, bd) = (arena.multiply(a, c), arena.multiply(b, d));
            let (bc, ad) = (arena.multiply(b, c), arena.multiply(a, d));
            let minus_ad = arena.negate(ad);
            [arena.merge(ac, bd), arena.merge(bc, minus_ad)]
        })
    }

    /// (self x other) . k
    pub fn cross(&self, arena: &mut Arena, other: &Vector) -> Scalar {
        let turned = self.turned(arena);
        turned.dot(arena, other)
    }

    fn product(
        &self,
        arena: &mut Arena,
        other: &Vector,
        pair: impl Fn(&mut Arena, [Expr; 2], [Expr; 2]) -> [Expr; 2],
    ) -> Scalar {
        let mut scalar = Scalar::zero();
        for (&f, &a) in &self.0 {
            for (&g, &b) in &other.0 {
                let [cosine, sine] = pair(arena, a, b);
                // The dot product is symmetric; the sine term changes sign with the order of the frames.
                let (key, sine) = if f <= g { ((f, g), sine) } else { ((g, f), arena.negate(sine)) };
                scalar.add_pair(arena, key, [cosine, sine]);
            }
        }
        scalar
    }
}

impl Coefficient for Vector {
    fn zero() -> Self {
        Vector::default()
    }

    fn accumulate(&mut self, arena: &mut Arena, other: &Self) {
        for (&frame, &[x, y]) in &other.0 {
            let entry = self.0.entry(frame).or_insert([Expr::ZERO; 2]);
            *entry = [arena.merge(entry[0], x), arena.merge(entry[1], y)];
            if *entry == [Expr::ZERO; 2] {
                self.0.remove(&frame);
            }
        }
    }

    fn scaled(&self, arena: &mut Arena, factor: Expr) -> Self {
        if factor == Expr::ZERO {
            return Vector::default();
        }
        Vector(self.0.iter().map(|(&f, &[x, y])| (f, [arena.multiply(factor, x), arena.multiply(factor, y)])).collect())
    }

    fn is_zero(&self) -> bool {
        self.0.is_empty()
    }
}

/// A scalar that depends on the pose through differences of frame angles: sum of C cos(g - f) + S sin(g - f).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scalar(BTreeMap<(FrameId, FrameId), [Expr; 2]>);

impl Scalar {
    pub fn plain(value: Expr) -> Self {
        let mut scalar = Scalar::default();
        if value != Expr::ZERO {
            scalar.0.insert((FrameId::WORLD, FrameId::WORLD), [value, Expr::ZERO]);
        }
        scalar
    }

    pub fn total(&self, arena: &mut Arena, frames: &Frames) -> Expr {
        let mut total = Expr::ZERO;
        for (&(f, g), &[cosine, sine]) in &self.0 {
            let [c, s] = frames.relative(arena, f, g);
            let (cosine, sine) = (arena.multiply(cosine, c), arena.multiply(sine, s));
            let both = arena.add(cosine, sine);
            total = arena.add(total, both);
        }
        total
    }

    fn add_pair(&mut self, arena: &mut Arena, (f, g): (FrameId, FrameId), [cosine, sine]: [Expr; 2]) {
        // Within one frame the angle between is zero, whichever frame it is.
        let (key, sine) = if f == g { ((FrameId::WORLD, FrameId::WORLD), Expr::ZERO) } else { ((f, g), sine) };
        let entry = self.0.entry(key).or_insert([Expr::ZERO; 2]);
        *entry = [arena.merge(entry[0], cosine), arena.merge(entry[1], sine)];
        if *entry == [Expr::ZERO; 2] {
            self.0.remove(&key);
        }
    }
}

impl Coefficient for Scalar {
    fn zero() -> Self {
        Scalar::default()
    }

    fn accumulate(&mut self, arena: &mut Arena, other: &Self) {
        for (&key, &pair) in &other.0 {
            self.add_pair(arena, key, pair);
        }
    }

    fn scaled(&self, arena: &mut Arena, factor: Expr) -> Self {
        if factor == Expr::ZERO {
            return Scalar::default();
        }
        Scalar(self.0.iter().map(|(&k, &[c, s])| (k, [arena.multiply(factor, c), arena.multiply(factor, s)])).collect())
    }

    fn is_zero(&self) -> bool {
        self.0.is_empty()
    }
}
