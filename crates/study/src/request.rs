//! What is wrong with what a fit or an optimisation is asked for.

use cotree::compile::QuantityError;
use cotree::model::ValueError;
use cotree::run::{Measure, MeasureError};
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
    /// A term is empty.
    #[error("a measure is missing, such as peak(motor.torque)")]
    NoMeasure,
    /// A term is no measure.
    #[error(transparent)]
    Measure(#[from] MeasureError),
    /// The time of an extreme.
    #[error("`{0}` is discontinuous where another extreme becomes the largest, and cannot be optimized")]
    Jumps(Measure),
}

/// Why a limit makes no sense.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LimitError {
    /// It has no sign.
    #[error("write a condition such as \"max(ram.s) <= 120 mm\", with <=, >= or =")]
    NoSign,
    /// Nothing stands behind the sign.
    #[error("the number after the sign is missing")]
    NoBound,
    /// What is limited cannot be read.
    #[error(transparent)]
    Goal(#[from] GoalError),
    /// Measures of different units are added.
    #[error("measures in `{first}` and in `{other}` cannot be added")]
    Units {
        /// The unit of the first one.
        first: String,
        /// Another unit.
        other: String,
    },
    /// The bound cannot be read.
    #[error(transparent)]
    Bound(#[from] QuantityError),
    /// The bound is infinite or NaN.
    #[error("the number must be finite")]
    NotFinite,
}

/// One thing that is wrong with a request.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RequestFault {
    /// There is no experiment.
    #[error("nothing was measured")]
    NothingMeasured,
    /// Each experiment has a table.
    #[error("{experiments} experiments with {tables} tables")]
    Tables {
        /// How many experiments there are.
        experiments: usize,
        /// How many tables there are.
        tables: usize,
    },
    /// A fault of one of several experiments.
    #[error("experiment {number}: {cause}")]
    Experiment {
        /// From 1.
        number: usize,
        /// The fault.
        cause: Box<RequestFault>,
    },
    /// A table without columns of outputs.
    #[error("the table has no column but `time`")]
    NoColumn,
    /// A column in which nothing was measured.
    #[error("the column `{column}` has no value")]
    EmptyColumn {
        /// The column.
        column: String,
    },
    /// A column of something else than an output.
    #[error("the column `{column}` is not an output; {known}")]
    NoOutput {
        /// The column.
        column: String,
        /// What may have been meant.
        known: String,
    },
    /// A column in another kind of unit.
    #[error("the column `{column}` is in `{unit}`, but the variable in `{si}`")]
    ColumnUnit {
        /// The column.
        column: String,
        /// Its unit.
        unit: String,
        /// The SI unit of the output.
        si: String,
    },
    /// Times of a table that are outside the experiment.
    #[error(
        "{count} of {all} times, the first {first:?} s, are outside the experiment, {start:?} s to {stop:?} s; remove these rows, or change the times of the experiment"
    )]
    Times {
        /// How many there are.
        count: usize,
        /// How many times the table has.
        all: usize,
        /// The first of them \[s\].
        first: f64,
        /// The start of the experiment \[s\].
        start: f64,
        /// Its end \[s\].
        stop: f64,
    },
    /// A standard deviation of a column that is in no table.
    #[error("there is no column `{name}`; {known}")]
    UnknownColumn {
        /// The name.
        name: String,
        /// What may have been meant.
        known: String,
    },
    /// A standard deviation or a bound that cannot be read.
    #[error("`{name}={text}`: {cause}")]
    Quantity {
        /// The column or the quantity.
        name: String,
        /// As it is written.
        text: String,
        /// What is wrong with it.
        cause: QuantityError,
    },
    /// A bound outside those of the scene.
    #[error("`{name}={text}`: {cause}")]
    Bound {
        /// The quantity.
        name: String,
        /// As it is written.
        text: String,
        /// What is wrong with it.
        cause: ValueError,
    },
    /// A standard deviation that is not above zero.
    #[error("`{name}={text}`: a standard deviation must be positive")]
    Deviation {
        /// The column.
        name: String,
        /// As it is written.
        text: String,
    },
    /// Too few measured values.
    #[error(transparent)]
    TooFew(#[from] TooFew),
    /// No quantity is varied.
    #[error("nothing is varied")]
    NothingVaried,
    /// A quantity is named more than once.
    #[error("`{name}` is varied twice")]
    VariedTwice {
        /// The quantity.
        name: String,
    },
    /// An experiment sets what is varied to something else than the first experiment.
    #[error("`{name}` is varied, but set to {here:?} {unit} here and to {first:?} {unit} in the first one")]
    Differs {
        /// The quantity.
        name: String,
        /// Its value here, SI.
        here: f64,
        /// Its value in the first experiment, SI.
        first: f64,
        /// The SI unit.
        unit: String,
    },
    /// No room between two bounds.
    #[error("`{name}`: {low:?} {unit} is not below {high:?} {unit}")]
    Empty {
        /// The quantity.
        name: String,
        /// The lower bound, SI.
        low: f64,
        /// The upper bound, SI.
        high: f64,
        /// The SI unit.
        unit: String,
    },
    /// The scene has a value outside the bounds.
    #[error("`{name}` starts at {start:?} {unit}, outside {low:?}..{high:?} {unit}; set it")]
    Start {
        /// The quantity.
        name: String,
        /// The value of the scene, SI.
        start: f64,
        /// The lower bound, SI.
        low: f64,
        /// The upper bound, SI.
        high: f64,
        /// The SI unit.
        unit: String,
    },
    /// Something is measured that is not there.
    #[error("`{name}` is not a {what}; {known}")]
    NotMeasured {
        /// The name.
        name: String,
        /// What it could be: an output, or a figure of the turn.
        what: &'static str,
        /// What may have been meant.
        known: String,
    },
    /// A limit that makes no sense.
    #[error("`{limit}`: {cause}")]
    Limit {
        /// The limit.
        limit: String,
        /// What is wrong with it.
        cause: LimitError,
    },
    /// Several starts, but quantities without bounds between which these could be.
    #[error(
        "{names}: several starts need bounds: write NAME=LOW..HIGH, or search from the scene's values only (1 start)"
    )]
    OpenBounds {
        /// The quantities.
        names: String,
    },
    /// None or too many starts.
    #[error("{starts} starts, but must be 1 to {most}")]
    Starts {
        /// How many are asked for.
        starts: usize,
        /// How many there can be.
        most: usize,
    },
    /// Too many quantities.
    #[error("{count} quantities are varied, but at most {most} can be")]
    Quantities {
        /// How many there are.
        count: usize,
        /// How many there can be.
        most: usize,
    },
    /// Columns whose squares have no sum.
    #[error("columns in `{first}` and in `{other}` have no common sum of squares: use `fit`, which weighs them")]
    Squares {
        /// The unit of the first column.
        first: String,
        /// Another unit.
        other: String,
    },
}
