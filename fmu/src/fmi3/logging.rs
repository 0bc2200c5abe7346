//! Messages in the form of FMI 3.0.

use std::ffi::{CStr, CString};

use super::types::{fmi3InstanceEnvironment, fmi3LogMessageCallback, fmi3Status};
use crate::fmi::logging::{Category, LogSeverity, Logger, Sink};

/// The standard's names (2.4.5) where it has one.
pub fn name(category: Category) -> &'static CStr {
    match category {
        Category::Events => c"logEvents",
        Category::Solver => c"logSolver",
        Category::Errors => c"logStatusError",
    }
}

/// The importer's function, and what it is called with.
struct Callback {
    function: fmi3LogMessageCallback,
    environment: fmi3InstanceEnvironment,
}

/// Errors are logged from the beginning, the rest when the importer asks for it: nobody has to run a model again to learn why it did not start.
pub fn logger(function: fmi3LogMessageCallback, environment: fmi3InstanceEnvironment, all: bool) -> Logger {
    Logger::new(Box::new(Callback { function, environment }), [all, all, true])
}

impl Sink for Callback {
    fn pass(&self, severity: LogSeverity, category: Category, message: &str) {
        let Some(function) = self.function else { return };
        let status = match severity {
            LogSeverity::Fine => fmi3Status::fmi3OK,
            LogSeverity::Warning => fmi3Status::fmi3Warning,
            LogSeverity::Discard => fmi3Status::fmi3Discard,
            LogSeverity::Error => fmi3Status::fmi3Error,
        };
        // A single # begins the name of a variable, and C strings end at a zero byte.
        let Ok(finished) = CString::new(message.replace('#', "##").replace('\0', " ")) else { return };
        // SAFETY: the importer gave this function for this purpose and keeps it alive as long as the instance; both strings end with zero and
        // outlive the call.
        unsafe { function(self.environment, status, name(category).as_ptr(), finished.as_ptr()) };
    }
}
