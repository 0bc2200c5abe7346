//! Functions whose last digits are the same on every platform: those of the standard library are the platform's own.

/// Numbers with such functions.
pub(crate) trait Alike {
    fn sine(self) -> f64;
    fn cosine(self) -> f64;
    fn sine_and_cosine(self) -> (f64, f64);
    /// The angle of a vector, of which this is the y.
    fn angle_over(self, x: f64) -> f64;
    /// The length of a vector.
    fn length_with(self, other: f64) -> f64;
    fn decimal_logarithm(self) -> f64;
    fn cube_root(self) -> f64;
}

impl Alike for f64 {
    fn sine(self) -> f64 {
        libm::sin(self)
    }

    fn cosine(self) -> f64 {
        libm::cos(self)
    }

    fn sine_and_cosine(self) -> (f64, f64) {
        libm::sincos(self)
    }

    fn angle_over(self, x: f64) -> f64 {
        libm::atan2(self, x)
    }

    fn length_with(self, other: f64) -> f64 {
        libm::hypot(self, other)
    }

    fn decimal_logarithm(self) -> f64 {
        libm::log10(self)
    }

    fn cube_root(self) -> f64 {
        libm::cbrt(self)
    }
}
