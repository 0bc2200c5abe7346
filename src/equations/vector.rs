//! Planar vectors by frames. Every vector of the equations is a sum of parts fixed in frames (one for each independent
//! angle); parts of one frame are added before any sine or cosine is taken. A product of two vectors is then a sum over
//! *pairs* of frames: within one frame it is a constant of the motion.

use std::collections::BTreeMap;

use super::form::{Coefficient, LinearForm};
use crate::expr::{Arena, Expr};

/// Index of a frame; 0 is the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameId(usize);

impl FrameId {
    pub const WORLD: FrameId = FrameId(0);
}

#[derive(Clone, Debug)]
pub struct MovingFrame {
    pub unit: [Expr; 2],
    /// omega, linear in the rates.
    pub rate: LinearForm<Expr>,
    /// alpha, linear in the accelerations.
    pub acceleration: LinearForm<Expr>,
    /// omega as one expression.
    pub omega: Expr,
    /// Its angle, without constants.
    pub angle: Expr,
}

#[derive(Clone, Debug)]
pub struct Frames(Vec<MovingFrame>);

impl Default for Frames {
    fn default() -> Self {
        let world = MovingFrame {
            unit: [Expr::ONE, Expr::ZERO],
            rate: LinearForm::default(),
            acceleration: LinearForm::default(),
            omega: Expr::ZERO,
            angle: Expr::ZERO,
        };
        Frames(vec![world])
    }
}

impl Frames {
    pub fn push(&mut self, frame: MovingFrame) -> FrameId {
        self.0.push(frame);
        FrameId(self.0.len() - 1)
    }

    /// A frame that is none of these, the index-th of its kind.
    pub fn other(&self, index: usize) -> FrameId {
        FrameId(self.0.len() + index)
    }

    pub fn iter(&self) -> impl Iterator<Item = (FrameId, &MovingFrame)> {
        self.0.iter().enumerate().map(|(index, frame)| (FrameId(index), frame))
    }

    pub fn get(&self, id: FrameId) -> &MovingFrame {
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

/// Pairs of expressions by what they belong to; pairs of zeros are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts<K>(BTreeMap<K, [Expr; 2]>);

/// A vector: for each frame, components in the axes of that frame.
pub type Vector = Parts<FrameId>;

/// A scalar that depends on the pose through differences of frame angles: sum of C cos(g - f) + S sin(g - f).
pub type Scalar = Parts<(FrameId, FrameId)>;

impl<K> Default for Parts<K> {
    fn default() -> Self {
        Parts(BTreeMap::new())
    }
}

impl<K: Ord + Copy> Parts<K> {
    fn one(key: K, pair: [Expr; 2]) -> Self {
        if pair == [Expr::ZERO; 2] { Parts::default() } else { Parts(BTreeMap::from([(key, pair)])) }
    }

    fn add(&mut self, arena: &mut Arena, key: K, [a, b]: [Expr; 2]) {
        let entry = self.0.entry(key).or_insert([Expr::ZERO; 2]);
        *entry = [arena.merge(entry[0], a), arena.merge(entry[1], b)];
        if *entry == [Expr::ZERO; 2] {
            self.0.remove(&key);
        }
    }
}

impl<K: Ord + Copy> Coefficient for Parts<K> {
    fn zero() -> Self {
        Parts::default()
    }

    fn accumulate(&mut self, arena: &mut Arena, other: &Self) {
        for (&key, &pair) in &other.0 {
            self.add(arena, key, pair);
        }
    }

    fn scaled(&self, arena: &mut Arena, factor: Expr) -> Self {
        if factor == Expr::ZERO {
            return Parts::default();
        }
        Parts(
            self.0
                .iter()
                .map(|(&key, &[a, b])| (key, [arena.multiply(factor, a), arena.multiply(factor, b)]))
                .collect(),
        )
    }

    fn is_zero(&self) -> bool {
        self.0.is_empty()
    }
}

impl Vector {
    pub fn x() -> Self {
        Vector::one(FrameId::WORLD, [Expr::ONE, Expr::ZERO])
    }

    pub fn y() -> Self {
        Vector::one(FrameId::WORLD, [Expr::ZERO, Expr::ONE])
    }

    pub fn fixed(frame: FrameId, components: [Expr; 2]) -> Self {
        Vector::one(frame, components)
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
        Parts(self.0.iter().map(|(&frame, &[x, y])| (frame, [arena.negate(y), x])).collect())
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

impl Scalar {
    pub fn plain(value: Expr) -> Self {
        Scalar::one((FrameId::WORLD, FrameId::WORLD), [value, Expr::ZERO])
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
        self.add(arena, key, [cosine, sine]);
    }
}
