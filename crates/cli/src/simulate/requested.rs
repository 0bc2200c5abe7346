//! Which variables are reported, and in which units.

use cotree::compile::Compiled;
use cotree::diagnostic::suggest;
use cotree::scene::{Requested, Scene};

use super::super::failure::Failure;
use super::SimulateCommand;

/// The variables that are asked for beside the outputs of the scene.
pub fn also(options: &SimulateCommand) -> Requested {
    Requested::also(named(options))
}

/// The variables of which derivatives are asked for, and those that are to cross a value: in place of the outputs of the scene, if there are any.
pub fn derived(options: &SimulateCommand, scene: &Scene) -> Requested {
    let crossed = options.crossing.iter().filter_map(|text| text.split('=').next()).map(str::trim);
    let names = named(options).chain(crossed);
    let is_set = |name: &str| {
        scene.parameters.iter().any(|parameter| parameter.name.text == name)
            || scene.inputs.iter().any(|input| input.name.text == name)
    };
    match options.variables.is_empty() {
        true => Requested::also(names),
        // Parameters and inputs are among the variables of every program.
        false => Requested::these(names.filter(|name| !is_set(name))),
    }
}

fn named(options: &SimulateCommand) -> impl Iterator<Item = &str> {
    let names = options.variables.iter().chain(&options.x).chain(&options.y);
    names.map(String::as_str).filter(|name| *name != "time")
}

/// What is reported: indices of variables of the description.
pub fn reported(options: &SimulateCommand, compiled: &Compiled) -> Result<Vec<usize>, Failure> {
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
