//! What values of keys must keep to, whatever the parameters are.

use super::Formula;

/// Which values a number may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Every finite one.
    Any,
    /// Zero and more.
    NotNegative,
    /// More than zero.
    Positive,
    /// All but zero.
    NotZero,
}

impl Range {
    /// May a number be this? Not a number may not.
    pub fn permits(self, value: f64) -> bool {
        match self {
            Self::Any => value.is_finite(),
            Self::NotNegative => value >= 0.0,
            Self::Positive => value > 0.0,
            Self::NotZero => value != 0.0 && !value.is_nan(),
        }
    }
}

/// A value that parameters can move out of its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// What the user calls it, such as "`mass` of body `bar`".
    pub name: String,
    /// Constants and parameters only.
    pub value: Formula,
    /// What it must be.
    pub range: Range,
}
