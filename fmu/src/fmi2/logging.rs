//! Messages to the importer.

use std::ffi::{CStr, CString};

use super::types::{fmi2CallbackLogger, fmi2ComponentEnvironment, fmi2Status};

/// The declared log categories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Changes of mode.
    Events,
    /// What the solver did.
    Solver,
    /// Why a call failed.
    Errors,
}

impl Category {
    const ALL: [Self; 3] = [Self::Events, Self::Solver, Self::Errors];

    fn name(self) -> &'static CStr {
        match self {
            Self::Events => c"events",
            Self::Solver => c"solver",
            Self::Errors => c"errors",
        }
    }

    fn parse(name: &CStr) -> Option<Self> {
        Self::ALL.into_iter().find(|category| category.name() == name)
    }
}

/// Where messages go. Errors are told from the beginning, the rest when the importer asks for it.
pub struct Logger {
    callback: fmi2CallbackLogger,
    environment: fmi2ComponentEnvironment,
    instance: CString,
    enabled: [bool; 3],
}

impl Logger {
    pub fn new(
        callback: fmi2CallbackLogger,
        environment: fmi2ComponentEnvironment,
        instance: CString,
        all: bool,
    ) -> Self {
        Self { callback, environment, instance, enabled: [all, all, true] }
    }

    /// Switches categories; all of them if none is named. An unknown name changes nothing.
    pub fn switch(&mut self, on: bool, names: &[&CStr]) -> Result<(), String> {
        let mut categories = Vec::new();
        for name in names {
            let category = Category::parse(name);
            categories.push(category.ok_or_else(|| {
                format!("`{}` is not a log category; there are events, solver and errors", name.to_string_lossy())
            })?);
        }
        let chosen = if names.is_empty() { &Category::ALL[..] } else { &categories };
        chosen.iter().for_each(|&category| self.enabled[category as usize] = on);
        Ok(())
    }

    pub fn is_enabled(&self, category: Category) -> bool {
        self.enabled[category as usize]
    }

    /// Passes one finished message on.
    pub fn log(&self, status: fmi2Status, category: Category, message: &str) {
        let (Some(callback), true) = (self.callback, self.is_enabled(category)) else {
            return;
        };
        // The callback takes the message for a printf format, and C strings end at a zero byte.
        let finished = message.trim_end().replace('%', "%%").replace('\0', " ");
        let Ok(finished) = CString::new(finished) else {
            return;
        };
        // SAFETY: the importer gave this function for this purpose and keeps it alive as long as the instance; all strings end with zero
        // and outlive the call; the format has no directive, so no further argument is read.
        unsafe {
            callback(self.environment, self.instance.as_ptr(), status, category.name().as_ptr(), finished.as_ptr());
        }
    }
}
