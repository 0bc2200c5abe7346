//! What is wrong with an argument of the command line.

use cotree::compile::QuantityError;
use cotree::model::ValueError;
use cotree::run::SettingError;
use cotree_study::analysis::SetError;
use thiserror::Error;

/// What is wrong with a `NAME=VALUE`.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct AssignmentError(pub String);

cotree::diagnostic::from_messages!(AssignmentError as AssignmentError: SettingError, QuantityError, ValueError, SetError);

/// A mode that is not written as a name and a word.
#[derive(Debug, Error)]
#[error("--mode {0}: write NAME=WORD, such as NAME=open, NAME=closed or NAME=sticks")]
pub struct ModeForm(pub String);
