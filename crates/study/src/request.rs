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
pub enum GoalError {
    /// What stands before a measure is no number.
    #[error("`{text}` is not a weight: write a number")]
    Weight {
        /// As it is written.
        text: String,
    },
    /// Anything else, as a message.
    #[error("{0}")]
    Other(String),
}

cotree::diagnostic::from_messages!(GoalError as GoalError::Other: MeasureError);

/// Why a limit makes no sense.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LimitError {
    /// Measures of different units are added.
    #[error("measures in `{first}` and in `{other}` cannot be added")]
    Units {
        /// The unit of the first one.
        first: String,
        /// Another unit.
        other: String,
    },
    /// Anything else, as a message.
    #[error("{0}")]
    Other(String),
}

cotree::diagnostic::from_messages!(LimitError as LimitError::Other: GoalError, QuantityError);

/// One thing that is wrong with a request.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RequestFault {
    /// Each experiment has a table.
    #[error("{experiments} experiments with {tables} tables")]
    Tables {
        /// How many experiments there are.
        experiments: usize,
        /// How many tables there are.
        tables: usize,
    },
    /// A column in which nothing was measured.
    #[error("the column `{column}` has no value")]
    EmptyColumn {
        /// The column.
        column: String,
    },
    /// A quantity is named more than once.
    #[error("`{name}` is varied twice")]
    VariedTwice {
        /// The quantity.
        name: String,
    },
    /// Columns whose squares have no sum.
    #[error("columns in `{first}` and in `{other}` have no common sum of squares: use `fit`, which weighs them")]
    Squares {
        /// The unit of the first column.
        first: String,
        /// Another unit.
        other: String,
    },
    /// Anything else, as a message.
    #[error("{0}")]
    Other(String),
}

cotree::diagnostic::from_messages!(RequestFault as RequestFault::Other: TooFew);
