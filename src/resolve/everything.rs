//! Every variable of a scene as an output.

use std::collections::HashMap;

use super::variables::of_part;
use crate::component::body::{POINT_VARIABLES as POINT, VARIABLES as BODY};
use crate::component::{ENERGIES, RESIDUALS, Section};
use crate::diagnostic::Faults;
use crate::diagnostic::span::Text;
use crate::model::{Dimension, Quantity, Unit};
use crate::scene::model::Scene;

impl Scene {
    /// The same scene with every variable that it has among its outputs, after those that it asks for.
    pub fn with_every_output(&self) -> Scene {
        let mut scene = self.clone();
        let asked = |scene: &Scene, name: &str| scene.outputs.variables.iter().any(|known| known.text == name);
        for state in self.states.iter().filter(|state| !asked(self, &state.name.text)) {
            scene.outputs.variables.push(Text::from(state.name.text.as_str()));
        }
        for (owner, has) in self.owners() {
            for quantity in has.into_iter().filter(|&quantity| self.knows(quantity)) {
                let name = quantity.of(&owner);
                if !asked(&scene, &name) {
                    scene.outputs.variables.push(Text::from(name.as_str()));
                }
            }
        }
        scene
    }

    /// The variables of the scene, its outputs, its states and its signals, with their units.
    ///
    /// # Errors
    /// Everything that is wrong with the scene.
    pub fn variables(&self) -> Result<HashMap<String, Unit>, Faults> {
        let laws = self.outputs.expressions.iter().chain(&self.signals).map(|own| own.name.text.as_str());
        let named = laws.chain(self.states.iter().map(|own| own.name.text.as_str()));
        let own = self.reporting(named).resolve()?.mechanism.outputs;
        let of_parts = self.owners().into_iter().flat_map(|(owner, has)| {
            has.into_iter().map(move |quantity| (quantity.of(&owner), Unit::of(&quantity.measure(), None)))
        });
        Ok(of_parts.chain(own.into_iter().map(|output| (output.name, output.unit))).collect())
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
            let known = parts.iter().filter_map(|part| Some((part.name.text.clone(), of_part(part, section)?.1)));
            owners.extend(known);
        }
        owners.extend([("energy".to_owned(), ENERGIES.to_vec()), ("constraint".to_owned(), RESIDUALS.to_vec())]);
        owners
    }

    fn knows(&self, quantity: Quantity) -> bool {
        self.dimension == Dimension::Two || quantity.is_on_a_line()
    }
}
