//! Which variables are reported, and in which units.

use cotree::compile::Compiled;
use cotree::diagnostic::{Text, suggest};
use cotree::scene::Scene;

use super::super::failure::Failure;
use super::Simulate;

/// The scene with the variables that are asked for among its outputs.
pub fn with_outputs(options: &Simulate, scene: Scene) -> Scene {
    let names = options.variables.iter().chain(&options.x).chain(&options.y);
    names.map(String::as_str).filter(|name| *name != "time").fold(scene, with_output)
}

/// The scene with the variables that are asked for instead of its outputs, if there are any.
pub fn with_these_outputs(options: &Simulate, mut scene: Scene) -> Scene {
    if !options.variables.is_empty() {
        scene.outputs.variables.clear();
        scene.outputs.chosen = true;
        scene.outputs.expressions.retain(|own| options.variables.contains(&own.name.text));
    }
    with_outputs(options, scene)
}

/// The scene with a variable among its outputs.
pub fn with_output(mut scene: Scene, name: &str) -> Scene {
    let is_named = scene.outputs.variables.iter().any(|known| known.text == name)
        || scene.outputs.expressions.iter().any(|known| known.name.text == name)
        || scene.parameters.iter().any(|known| known.name.text == name)
        || scene.inputs.iter().any(|known| known.name.text == name);
    if !is_named {
        scene.outputs.variables.push(Text::from(name));
    }
    scene
}

/// What is reported: indices of variables of the description.
pub fn reported(options: &Simulate, compiled: &Compiled) -> Result<Vec<usize>, Failure> {
    if options.variables.is_empty() {
        return Ok(compiled.reported());
    }
    let mut found = Vec::new();
    for name in options.variables.iter().chain(&options.x).chain(&options.y).filter(|name| *name != "time") {
        let index = index(compiled, name)?;
        if !found.contains(&index) {
            found.push(index);
        }
    }
    Ok(found)
}

fn index(compiled: &Compiled, name: &str) -> Result<usize, Failure> {
    let variables = &compiled.description.variables;
    variables.iter().position(|variable| variable.name == *name).ok_or_else(|| {
        let known = suggest::known(name, variables.iter().map(|variable| variable.name.as_str()).collect::<Vec<_>>());
        Failure::Usage(format!("there is no variable `{name}`; {known}"))
    })
}
