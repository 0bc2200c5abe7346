//! Messages in the form of FMI 2.0.

use std::ffi::{CStr, CString};

use super::types::{fmi2CallbackLogger, fmi2ComponentEnvironment, fmi2Status};
use crate::fmi::logging::{Category, LogSeverity, Logger, Sink};

pub fn name(category: Category) -> &'static CStr {
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

impl Sink for Callback {
    fn pass(&self, severity: LogSeverity, category: Category, message: &str) {
        let Some(function) = self.function else { return };
        let status = match severity {
            LogSeverity::Fine => fmi2Status::fmi2OK,
            LogSeverity::Warning => fmi2Status::fmi2Warning,
            LogSeverity::Discard => fmi2Status::fmi2Discard,
            LogSeverity::Error => fmi2Status::fmi2Error,
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
