//! The scene with other values: everything else in its text stays as it is, comments too.

use std::path::Path;

use cotree::diagnostic::suggest;
use cotree::scene::quantity::Value;
use cotree::scene::{Faults, Quantity, Scene, spliced};

/// Why a scene cannot be written with other values.
#[derive(Debug, thiserror::Error)]
pub enum RewriteError {
    /// The scene was not read from a text, or a part gives the value.
    #[error("the scene does not say where `{name}` is written")]
    Nowhere {
        /// The name.
        name: String,
    },
    /// An input without a value.
    #[error("the scene gives no `start` of `{name}` that could be changed")]
    NoStart {
        /// The input.
        name: String,
    },
    /// The scene has no such value.
    #[error("the scene does not give `{name}`; {known}")]
    Unknown {
        /// The name.
        name: String,
        /// What may have been meant.
        known: String,
    },
    /// Two names are of one place.
    #[error("two of the names are the same value")]
    Twice,
    /// The scene is at fault with the values.
    #[error("the scene cannot be written with these values:\n{}", .0.render(false, 100))]
    Scene(Faults),
    /// Whoever reads the text finds another value.
    #[error("the value of `{name}` cannot be changed where it is written")]
    Unchanged {
        /// The name.
        name: String,
    },
}

/// The text of a scene with these values \[SI\] of parameters, inputs and initial values: name, value, unit.
///
/// # Errors
/// A value that the text does not have, or does not say in one place.
pub fn with_values(scene: &Scene, values: &[(String, f64, String)]) -> Result<String, RewriteError> {
    let text = &scene.source.text;
    let mut changes = Vec::new();
    for (name, value, unit) in values {
        let own = written(scene, name)?;
        let old = text.get(own.span.start..own.span.end).filter(|old| !old.is_empty());
        let old = old.ok_or_else(|| RewriteError::Nowhere { name: name.clone() })?;
        let number = format!("{value:?}");
        let new = if unit.is_empty() || unit == "1" { number.clone() } else { format!("{number} {unit}") };
        let is_bare = matches!(own.value, Value::Text(_)) && !old.starts_with(['"', '\'']);
        let new = match is_bare || new == number {
            true => new,
            false => format!("\"{new}\""),
        };
        changes.push((own.span, new));
    }
    let changed = spliced(text, changes).ok_or(RewriteError::Twice)?;
    check(scene, &changed, values)?;
    Ok(changed)
}

/// The value of a name, as it is written.
fn written<'s>(scene: &'s Scene, name: &str) -> Result<&'s Quantity, RewriteError> {
    if let Some(parameter) = scene.parameters.iter().find(|own| own.name.text == name) {
        return Ok(&parameter.value);
    }
    if let Some(input) = scene.inputs.iter().find(|own| own.name.text == name) {
        return input.start.as_ref().ok_or_else(|| RewriteError::NoStart { name: name.to_owned() });
    }
    let line = scene.initial.iter().find(|own| own.variable.text == name);
    line.map(|line| &line.value).ok_or_else(|| {
        let names = scene.parameters.iter().map(|own| own.name.text.as_str());
        RewriteError::Unknown { name: name.to_owned(), known: suggest::known(name, names) }
    })
}

/// Whoever reads the new text finds the new values.
fn check(scene: &Scene, changed: &str, values: &[(String, f64, String)]) -> Result<(), RewriteError> {
    let read = Scene::from_bytes(Path::new(&scene.source.name), changed.as_bytes().to_vec());
    let read = read.map_err(RewriteError::Scene)?;
    for (name, value, _) in values {
        let own = written(&read, name)?;
        let number = match &own.value {
            Value::Number(number) => Some(*number),
            Value::Text(text) => text.split(' ').next().and_then(|number| number.parse().ok()),
        };
        if number != Some(*value) {
            return Err(RewriteError::Unchanged { name: name.clone() });
        }
    }
    Ok(())
}
