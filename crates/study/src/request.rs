//! Errors in the request of a fit or an optimisation.

use cotree::compile::QuantityError;
use cotree::run::MeasureError;
use thiserror::Error;

/// Measured values are fewer than what they are to determine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{values} measured values cannot determine {quantities} quantities and their errors")]
pub struct TooFew {
    /// How many values were measured.
    pub values: usize,
    /// How many quantities are varied.
    pub quantities: usize,
}

/// Why a text is no goal.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct GoalError(pub String);

cotree::diagnostic::from_messages!(GoalError as GoalError: MeasureError);

/// Why a limit makes no sense.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct LimitError(pub String);

cotree::diagnostic::from_messages!(LimitError as LimitError: GoalError, QuantityError);

/// One thing that is wrong with a request.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{0}")]
pub struct RequestFault(pub String);

cotree::diagnostic::from_messages!(RequestFault as RequestFault: TooFew);
