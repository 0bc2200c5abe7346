//! What values of keys must keep to, whatever the parameters are.

use cotree_fmu::program::domain::Limit;

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
    /// From zero to one.
    Share,
    /// One and more.
    FromOne,
}

impl Range {
    /// What the runtime sees to; nothing where every number will do.
    pub fn limit(self) -> Option<Limit> {
        match self {
            Self::Any => None,
            Self::NotNegative => Some(Limit::NotNegative),
            Self::Positive => Some(Limit::Positive),
            Self::NotZero => Some(Limit::NotZero),
            Self::Share => Some(Limit::Share),
            Self::FromOne => Some(Limit::AtLeast(1.0)),
        }
    }

    /// May a number be this? Not a number may not.
    pub fn permits(self, value: f64) -> bool {
        self.limit().map_or(value.is_finite(), |limit| limit.allows(value))
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
    pub limit: Limit,
}
