//! What a call ends with: exceptions, and columns of numbers.

use std::borrow::Cow;
use std::ffi::CString;

use cotree::run::{Logged, What};
use cotree::{Faults, Severity};
use cotree_fmu::instance::Inaccuracy;
use cotree_study::analysis::{AnalysisFailure, StudyError};
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt, PyOSError, PyRuntimeWarning, PyValueError};
use pyo3::prelude::*;

use crate::request::Value;

create_exception!(
    cotree._cotree,
    SceneError,
    PyException,
    "A scene has errors; `faults` has each of them with its positions."
);
create_exception!(cotree._cotree, RunError, PyException, "The solver failed; `results` has the motion before.");

/// Every fault as JSON, which the Python side turns into objects.
pub fn scene_error(faults: &Faults) -> PyErr {
    SceneError::new_err((faults.render(false, 100), faults.to_json().to_string()))
}

/// An argument that makes no sense.
pub fn wrong(message: impl ToString) -> PyErr {
    PyValueError::new_err(message.to_string())
}

/// Numbers that do not work out.
pub fn failed(error: impl ToString) -> PyErr {
    RunError::new_err(error.to_string())
}

/// A file that cannot be written.
pub fn file_error(error: impl ToString) -> PyErr {
    PyOSError::new_err(error.to_string())
}

/// Why a study has no result. The scene has none of these faults by itself: it was compiled when it was read. With values that were set they are those of the run.
pub fn study_error(error: StudyError, settings: &[(String, Value)]) -> PyErr {
    match error {
        StudyError::Scene(faults) => unlike_the_scene(&faults, settings).unwrap_or_else(|| scene_error(&faults)),
        StudyError::Analysis(error @ (AnalysisFailure::Unknown(_) | AnalysisFailure::Followed { .. })) => wrong(error),
        StudyError::Analysis(error) => RunError::new_err(error.to_string()),
    }
}

/// Faults that a scene has with other values than its own; none where nothing was set.
pub fn unlike_the_scene(faults: &Faults, settings: &[(String, Value)]) -> Option<PyErr> {
    let set: Vec<String> = settings.iter().map(|(name, value)| format!("`{name}` is {value}")).collect();
    let told: Vec<&str> = faults
        .list
        .iter()
        .filter(|fault| fault.severity == Severity::Error)
        .map(|fault| fault.message.as_str())
        .collect();
    (!set.is_empty()).then(|| RunError::new_err(format!("{}; {}", told.join("; "), set.join(", "))))
}

/// Why a run ended early; `None` if the user wants to stop.
pub fn run_error(error: cotree::run::RunError) -> Option<String> {
    match error {
        cotree::run::RunError::Output(_) => None,
        other => Some(other.to_string()),
    }
}

/// Something that has happened: when, to what, in a word, and the impulse of an impact.
pub type LogRow = (f64, String, Cow<'static, str>, Option<f64>);

/// What has happened in a run, as rows of a table.
pub fn log_rows(log: impl IntoIterator<Item = Logged>) -> Vec<LogRow> {
    let row = |Logged { time, name, what }| {
        let impulse = if let What::Impact { impulse, .. } = what { Some(impulse) } else { None };
        (time, name, Cow::Borrowed(what.word()), impulse)
    };
    log.into_iter().map(row).collect()
}

/// That rounding errors are larger than the tolerance; `of` says in which runs.
pub fn warn(py: Python<'_>, of: &str, inaccuracy: &Inaccuracy) -> PyResult<()> {
    let text =
        CString::new(format!("{of}{inaccuracy}; {}", inaccuracy.help())).map_err(|error| wrong(error.to_string()))?;
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)
}

/// What is odd in a text but no error.
pub fn warn_of(py: Python<'_>, faults: &Faults) -> PyResult<()> {
    faults.list.iter().try_for_each(|fault| {
        let text =
            CString::new(format!("{}; {}", fault.message, fault.help)).map_err(|error| wrong(error.to_string()))?;
        PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)
    })
}

pub fn interrupted() -> PyErr {
    PyKeyboardInterrupt::new_err(())
}
