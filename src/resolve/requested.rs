//! The variables and expressions that are asked for.

use std::collections::{HashMap, HashSet};

use crate::component::body::{POINT_VARIABLES as POINT, VARIABLES as BODY};
use crate::component::{ENERGIES, RESIDUALS, Section};
use crate::diagnostic::Faults;
use crate::diagnostic::span::Text;
use crate::model::{Dimension, Quantity, Unit};
use crate::scene::Requested;
use crate::scene::model::{Scene, Signal};

impl Scene {
    /// The same scene with every variable that it has among its outputs, after those that it asks for.
    pub fn with_every_output(&self) -> Scene {
        let mut scene = self.clone();
        scene.outputs.variables = self.requested(&Requested::Everything).0;
        scene
    }

    /// The names of the variables and the expressions that are asked for.
    pub(super) fn requested(&self, requested: &Requested) -> (Vec<Text>, Vec<&Signal>) {
        let more = match requested {
            Requested::Own => Vec::new(),
            Requested::Also(names) => names.iter().filter(|name| !self.names_a_value(name)).cloned().collect(),
            Requested::Everything => self.every_variable(),
            Requested::These(names) => return self.these(names),
        };
        let mut there: HashSet<&str> = self.outputs.variables.iter().map(|variable| variable.text.as_str()).collect();
        let more = more.iter().filter(|name| there.insert(name)).map(|name| Text::from(name.as_str()));
        (self.outputs.variables.iter().cloned().chain(more).collect(), self.outputs.expressions.iter().collect())
    }

    /// These outputs alone, each once: an expression of the scene, or else a variable. Where the scene names one, a fault is shown there.
    fn these(&self, names: &[String]) -> (Vec<Text>, Vec<&Signal>) {
        let mut there = HashSet::new();
        let (mut variables, mut expressions) = (Vec::new(), Vec::new());
        for name in names.iter().filter(|name| there.insert(name.as_str())) {
            match self.outputs.expressions.iter().find(|expression| expression.name.text == *name) {
                Some(expression) => expressions.push(expression),
                None => {
                    let declared = self.outputs.variables.iter().find(|variable| variable.text == *name);
                    variables.push(declared.cloned().unwrap_or_else(|| Text::from(name.as_str())));
                }
            }
        }
        (variables, expressions)
    }

    /// Is this the name of an expression, a parameter or an input?
    fn names_a_value(&self, name: &str) -> bool {
        self.outputs.expressions.iter().any(|expression| expression.name.text == name)
            || self.parameters.iter().any(|parameter| parameter.name.text == name)
            || self.inputs.iter().any(|input| input.name.text == name)
    }

    fn every_variable(&self) -> Vec<String> {
        let of = |(owner, has): (String, Vec<Quantity>)| {
            let known = has.into_iter().filter(|&quantity| self.knows(quantity));
            known.map(|quantity| quantity.of(&owner)).collect::<Vec<_>>()
        };
        let states = self.states.iter().map(|state| state.name.text.clone());
        let states = states.chain(self.discrete_names());
        states.chain(self.owners().into_iter().flat_map(of)).collect()
    }

    /// The variables of the scene, its outputs, its states and its signals, with their units.
    ///
    /// # Errors
    /// Everything that is wrong with the scene.
    pub fn variables(&self) -> Result<HashMap<String, Unit>, Faults> {
        let laws = self.outputs.expressions.iter().chain(&self.signals).map(|expression| expression.name.text.as_str());
        let discrete = self.discrete_names();
        let named = laws.chain(self.states.iter().map(|state| state.name.text.as_str()));
        let named = named.chain(discrete.iter().map(String::as_str));
        let outputs = self.resolve_asking(&Requested::these(named))?.outputs;
        let of_parts = self.owners().into_iter().flat_map(|(owner, has)| {
            has.into_iter().map(move |quantity| (quantity.of(&owner), Unit::of(&quantity.measure(), None)))
        });
        Ok(of_parts.chain(outputs.into_iter().map(|output| (output.name, output.unit))).collect())
    }

    /// Sampled values, and when events happened.
    fn discrete_names(&self) -> Vec<String> {
        let sampled = self.sampled_values().map(|(_, value)| value.name.text.clone());
        sampled.chain(self.events.iter().map(|event| format!("events.{}.time", event.name.text))).collect()
    }

    fn owners(&self) -> Vec<(String, Vec<Quantity>)> {
        let mut owners: Vec<(String, Vec<Quantity>)> = Vec::new();
        for body in &self.bodies {
            owners.push((body.name.text.clone(), BODY.to_vec()));
            let points = body.entries("points").iter().map(|(name, _)| format!("{}.{}", body.name.text, name.text));
            owners.extend(points.map(|point| (point, POINT.to_vec())));
        }
        for (section, parts) in
            [(Section::Joints, &self.joints), (Section::Drivers, &self.drivers), (Section::Loads, &self.loads)]
        {
            let known = parts.iter().filter_map(|part| Some((part.name.text.clone(), self.of_part(part, section)?.1)));
            owners.extend(known);
        }
        owners.extend([("energy".to_owned(), ENERGIES.to_vec()), ("constraint".to_owned(), RESIDUALS.to_vec())]);
        owners
    }

    fn knows(&self, quantity: Quantity) -> bool {
        self.dimension == Dimension::Two || quantity.is_on_a_line()
    }
}
