//! Values given by name: of parameters, constant inputs and initial values.

use std::collections::HashMap;

use crate::diagnostic::suggest;
use crate::export::description::{Causality, Description, ScalarVariable};
use crate::model::ValueError;

/// Why a name or a value cannot be given to a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct SettingError(pub String);

impl SettingError {
    /// Why a variable cannot have that value \[SI\].
    pub fn of_value(value: f64, cause: &ValueError) -> Self {
        SettingError(format!("{value:?} {cause}"))
    }
}

/// The inputs of a scene by name: tables may have thousands of columns.
pub struct Inputs<'a> {
    places: HashMap<&'a str, usize>,
}

impl<'a> Inputs<'a> {
    pub fn new(description: &'a Description) -> Self {
        let variables = description.variables.iter().enumerate();
        let inputs = variables.filter(|(_, variable)| matches!(variable.causality, Causality::Input { .. }));
        Inputs { places: inputs.map(|(index, variable)| (variable.name.as_str(), index)).collect() }
    }

    /// The input of that name.
    ///
    /// # Errors
    /// There is none; what may have been meant.
    pub fn find(&self, name: &str) -> Result<usize, SettingError> {
        let mut names: Vec<&str> = self.places.keys().copied().collect();
        names.sort_by_key(|name| self.places[name]);
        let unknown =
            || SettingError(format!("the scene has no input `{name}`; {known}", known = suggest::known(name, names)));
        self.places.get(name).copied().ok_or_else(unknown)
    }
}

/// The variable of that name that can be set before a run.
///
/// # Errors
/// There is none; what may have been meant.
pub fn settable(description: &Description, name: &str) -> Result<usize, SettingError> {
    let can_be_set = |variable: &&ScalarVariable| variable.causality.range().is_some() || variable.start.is_some();
    let found = description.variables.iter().position(|variable| variable.name == name && can_be_set(&variable));
    found.ok_or_else(|| {
        let is_calculated =
            |variable: &&ScalarVariable| variable.name == name && variable.causality == Causality::CalculatedParameter;
        if let Some(variable) = description.variables.iter().find(is_calculated) {
            return SettingError(format!(
                "`{name}` cannot be set: it is calculated from other parameters ({about}); set these, or give `{name}` a number in the scene",
                about = variable.description
            ));
        }
        let variables = description.variables.iter().filter(can_be_set);
        let names: Vec<&str> = variables.map(|variable| variable.name.as_str()).collect();
        SettingError(format!(
            "the scene has no parameter or input `{name}`; {known}",
            known = suggest::known(name, names)
        ))
    })
}

/// May the variable have that value \[SI\]?
///
/// # Errors
/// Why not.
pub fn permitted(variable: &ScalarVariable, value: f64) -> Result<(), ValueError> {
    variable.unit.permit(value, variable.causality.range().map_or([None; 2], |(_, bounds)| bounds))
}
