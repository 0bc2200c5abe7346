//! What a call ends with: exceptions, and columns of numbers.

use cotree::Faults;
use cotree_study::analysis::{Failure, StudyError};
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt, PyOSError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    cotree._cotree,
    SceneError,
    PyException,
    "A scene is at fault; `faults` has every fault with its places."
);
create_exception!(
    cotree._cotree,
    RunError,
    PyException,
    "The numbers do not work out; `results` has what comes before."
);

/// Every fault as JSON, which the Python side turns into objects.
pub fn scene_error(faults: &Faults) -> PyErr {
    SceneError::new_err((faults.render(false, 100), faults.to_json().to_string()))
}

/// An argument that makes no sense.
pub fn wrong(message: impl Into<String>) -> PyErr {
    PyValueError::new_err(message.into())
}

/// A file that cannot be written.
pub fn file_error(error: impl ToString) -> PyErr {
    PyOSError::new_err(error.to_string())
}

pub fn study_error(error: StudyError) -> PyErr {
    match error {
        StudyError::Scene(faults) => scene_error(&faults),
        StudyError::Analysis(error @ Failure::Unknown(_)) => wrong(error.to_string()),
        StudyError::Analysis(error) => RunError::new_err(error.to_string()),
    }
}

/// Why a run ended early; `None` if the user wants to stop.
pub fn run_error(error: cotree::run::RunError) -> Option<String> {
    match error {
        cotree::run::RunError::Output(_) => None,
        other => Some(other.to_string()),
    }
}

pub fn interrupted() -> PyErr {
    PyKeyboardInterrupt::new_err(())
}
