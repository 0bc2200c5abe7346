//! Messages in the form of FMI 2.0.

use std::ffi::{CStr, CString};

use thiserror::Error;

use super::types::{fmi2CallbackLogger, fmi2ComponentEnvironment, fmi2Status};
use crate::fmi::logging::{Category, Logger, Severity, Sink};

fn name(category: Category) -> &'static CStr {
    match category {
        Category::Events => c"events",
        Category::Solver => c"solver",
        Category::Errors => c"errors",
    }
}

/// The importer's function, and what it is called with.
struct Callback {
    function: fmi2CallbackLogger,
    environment: fmi2ComponentEnvironment,
    instance: CString,
}

/// Errors are logged from the beginning, the rest when the importer asks for it.
pub fn logger(
    function: fmi2CallbackLogger,
    environment: fmi2ComponentEnvironment,
    instance: CString,
    all: bool,
) -> Logger {
    Logger::new(Box::new(Callback { function, environment, instance }), [all, all, true])
}

/// A name that is that of no category.
#[derive(Debug, Error)]
#[error("`{0}` is not a log category; there are events, solver and errors")]
pub struct UnknownCategory(String);

/// The categories of these names.
pub fn categories(names: &[&CStr]) -> Result<Vec<Category>, UnknownCategory> {
    let known = |wanted: &&CStr| {
        let found = Category::ALL.into_iter().find(|category| name(*category) == *wanted);
        found.ok_or_else(|| UnknownCategory(wanted.to_string_lossy().into_owned()))
    };
    names.iter().map(known).collect()
}

impl Sink for Callback {
    fn pass(&self, severity: Severity, category: Category, message: &str) {
        let Some(function) = self.function else { return };
        let status = match severity {
            Severity::Fine => fmi2Status::fmi2OK,
            Severity::Warning => fmi2Status::fmi2Warning,
            Severity::Discard => fmi2Status::fmi2Discard,
            Severity::Error => fmi2Status::fmi2Error,
        };
        // The callback takes the message for a printf format, and C strings end at a zero byte.
        let Ok(finished) = CString::new(message.replace('%', "%%").replace('\0', " ")) else {
            return;
        };
        // SAFETY: the importer gave this function for this purpose and keeps it alive as long as the instance; all strings end with zero
        // and outlive the call; the format has no directive, so no further argument is read.
        unsafe {
            function(self.environment, self.instance.as_ptr(), status, name(category).as_ptr(), finished.as_ptr());
        }
    }
}
