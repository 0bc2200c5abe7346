//! What is wrong with an argument of the command line.

use cotree::compile::QuantityError;
use cotree::model::ValueError;
use cotree::run::SettingError;
use cotree_study::analysis::SetError;
use thiserror::Error;

/// What is wrong with a `NAME=VALUE`.
#[derive(Debug, Error)]
pub enum AssignmentError {
    /// It has no `=`.
    #[error("write name=value")]
    Form,
    /// Nothing that can be set has that name.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The value cannot be read.
    #[error(transparent)]
    Quantity(#[from] QuantityError),
    /// The variable cannot have the value.
    #[error(transparent)]
    Value(#[from] ValueError),
    /// A study cannot set it.
    #[error(transparent)]
    Study(#[from] SetError),
}

/// A mode that is not written as a name and a word.
#[derive(Debug, Error)]
#[error("--mode {0}: write NAME=WORD, such as NAME=open, NAME=closed or NAME=sticks")]
pub struct ModeForm(pub String);
