//! Where laws have values: what they need of the arguments of divisions, roots and logarithms.

use serde::{Deserialize, Serialize};

use crate::tape::Tape;

/// Arguments of laws that must stay within limits, each a result of a tape.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DomainTape {
    /// What each result is.
    pub domains: Vec<Domain>,
    /// Computes the arguments.
    pub tape: Tape,
}

/// An argument, and what it must be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Domain {
    /// The key in the scene, such as `loads.push.vector`.
    pub place: String,
    /// As the scene writes it.
    pub argument: String,
    /// What it must be.
    pub limit: Limit,
}

/// What an argument must be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Limit {
    /// A divisor: not zero.
    Divisor,
    /// Of a square root: not negative.
    Root,
    /// Of a logarithm: positive.
    Logarithm,
    /// Of an arc sine or cosine: between -1 and 1.
    ArcSine,
    /// The base of a power that is no whole number: not negative.
    Base,
    /// The distance of two points that a force acts between: not zero.
    Distance,
    /// The value of a whole law: finite.
    Value,
    /// A key that must be zero or more.
    NotNegative,
    /// A key that must be more than zero.
    Positive,
    /// A key that must not be zero.
    NotZero,
    /// A key that must be from zero to one.
    Share,
    /// A calculated parameter with a smallest value.
    AtLeast(f64),
    /// A calculated parameter with a largest value.
    AtMost(f64),
}

impl Limit {
    /// Has the law a value there? Not where the argument is no number.
    pub fn allows(self, argument: f64) -> bool {
        match self {
            // 1/(1 + exp a) is zero where exp a is beyond all numbers.
            Self::Divisor => !argument.is_nan() && argument != 0.0,
            Self::NotZero => argument.is_finite() && argument != 0.0,
            Self::Root | Self::Base | Self::NotNegative => argument >= 0.0,
            Self::Share => (0.0..=1.0).contains(&argument),
            Self::Logarithm | Self::Distance | Self::Positive => argument > 0.0,
            Self::AtLeast(least) => argument.is_finite() && argument >= least,
            Self::AtMost(most) => argument.is_finite() && argument <= most,
            Self::ArcSine => argument.abs() <= 1.0,
            Self::Value => argument.is_finite(),
        }
    }

    /// Where an argument comes to its limit on the way from one value to another.
    pub fn passed(self, from: f64, to: f64) -> Option<f64> {
        let through = self == Self::Divisor && from * to < 0.0;
        if through { Some(0.0) } else { (!self.allows(to)).then_some(to) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_outside_every_limit() {
        let limits = [Limit::Divisor, Limit::Root, Limit::Logarithm, Limit::ArcSine, Limit::Base, Limit::Value];
        for limit in limits.into_iter().chain([Limit::Distance, Limit::NotNegative, Limit::Positive, Limit::NotZero]) {
            assert!(limit.allows(0.5) && !limit.allows(f64::NAN), "{limit:?}");
        }
        assert!(Limit::Divisor.allows(f64::INFINITY) && !Limit::NotZero.allows(f64::INFINITY));
        assert!(!Limit::Divisor.allows(-0.0) && !Limit::Logarithm.allows(0.0) && Limit::Root.allows(0.0));
        assert_eq!(Limit::Divisor.passed(1e-3, -1e-3), Some(0.0));
        assert_eq!(Limit::Root.passed(1e-3, -1e-3), Some(-1e-3));
        assert_eq!(Limit::Root.passed(1e-3, 0.0), None);
    }
}
