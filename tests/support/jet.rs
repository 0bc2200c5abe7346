//! A number with its first two derivatives along a line: derivatives without formulas.

use std::ops::{Add, Mul, Sub};

/// f, f' and f'' along a straight line through the coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Jet(pub [f64; 3]);

impl Jet {
    pub fn constant(value: f64) -> Jet {
        Jet([value, 0.0, 0.0])
    }

    /// g(f) from g, g' and g'' at f.
    fn chain(self, [g, g1, g2]: [f64; 3]) -> Jet {
        let Jet([_, d, dd]) = self;
        Jet([g, g1 * d, g1 * dd + g2 * d * d])
    }

    pub fn sin_cos(self) -> (Jet, Jet) {
        let (s, c) = self.0[0].sin_cos();
        (self.chain([s, c, -s]), self.chain([c, -s, -c]))
    }

    pub fn inverse(self) -> Jet {
        let one = 1.0 / self.0[0];
        self.chain([one, -one * one, 2.0 * one * one * one])
    }

    pub fn sqrt(self) -> Jet {
        let root = self.0[0].sqrt();
        self.chain([root, 0.5 / root, -0.25 / (root * root * root)])
    }
}

impl Add for Jet {
    type Output = Jet;
    fn add(self, other: Jet) -> Jet {
        Jet([0, 1, 2].map(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Jet {
    type Output = Jet;
    fn sub(self, other: Jet) -> Jet {
        self + Jet::constant(-1.0) * other
    }
}

impl Mul for Jet {
    type Output = Jet;
    fn mul(self, other: Jet) -> Jet {
        let (Jet([a, a1, a2]), Jet([b, b1, b2])) = (self, other);
        Jet([a * b, a1 * b + a * b1, a2 * b + 2.0 * a1 * b1 + a * b2])
    }
}
