//! Writes new values into the text of a scene. The rest of the text, with its comments, is unchanged.

use cotree::scene::quantity::Value;
use cotree::scene::{EditError, Quantity, Scene};

/// The text of a scene with these values \[SI\] of parameters, inputs and initial values: name, value, unit.
///
/// # Errors
/// A value that the text does not have, or does not say in one place.
pub fn with_values(scene: &Scene, values: &[(String, f64, String)]) -> Result<String, EditError> {
    let changes = values.iter().map(|(name, value, unit)| {
        let number = format!("{value:?}");
        let is_bare = unit.is_empty() || unit == "1";
        let table = table(scene, name);
        if table == "inputs" && written(scene, name).is_none() {
            return Err(EditError::Text(format!("the scene gives no `start` of `{name}` that could be changed")));
        }
        Ok((format!("{table}.{name}"), if is_bare { number } else { format!("\"{number} {unit}\"") }))
    });
    let changed = scene.replaced(&changes.collect::<Result<Vec<_>, _>>()?).map_err(|error| match error {
        EditError::Scene(faults) => {
            EditError::Text(format!("the scene cannot be written with these values:\n{}", faults.render(false, 100)))
        }
        error @ (EditError::Text(_) | EditError::Unknown(_)) => error,
    })?;
    check(&changed, values)?;
    Ok(changed.source.files().next().map(|(_, text)| text.to_owned()).unwrap_or_default())
}

/// The table that gives the value of a name.
fn table(scene: &Scene, name: &str) -> &'static str {
    match name {
        _ if scene.parameters.iter().any(|parameter| parameter.name.text == name) => "parameters",
        _ if scene.inputs.iter().any(|input| input.name.text == name) => "inputs",
        _ => "initial",
    }
}

/// The value of a name, as it is written.
fn written<'s>(scene: &'s Scene, name: &str) -> Option<&'s Quantity> {
    let parameter =
        scene.parameters.iter().find(|parameter| parameter.name.text == name).map(|parameter| &parameter.value);
    let input = || scene.inputs.iter().find(|input| input.name.text == name).and_then(|input| input.start.as_ref());
    let line = || scene.initial.iter().find(|line_data| line_data.variable.text == name).map(|line| &line.value);
    parameter.or_else(input).or_else(line)
}

/// Whoever reads the new text finds the new values.
fn check(changed: &Scene, values: &[(String, f64, String)]) -> Result<(), EditError> {
    for (name, value, _) in values {
        let number = match written(changed, name).map(|found| &found.value) {
            Some(Value::Number(number)) => Some(*number),
            Some(Value::Text(text)) => text.split(' ').next().and_then(|number| number.parse().ok()),
            None => None,
        };
        if number != Some(*value) {
            return Err(EditError::Text(format!("the value of `{name}` cannot be changed where it is written")));
        }
    }
    Ok(())
}
