//! Every variable of a scene as an output.

use super::variables::{BODY, ENERGIES, POINT, RESIDUALS, of_driver, of_joint, of_load, on_a_line, words};
use crate::mechanism::{Dimension, Quantity};
use crate::scene::model::Scene;
use crate::scene::span::Text;

impl Scene {
    /// The same scene with every variable that it has among its outputs, after those that it asks for.
    pub fn with_every_output(&self) -> Scene {
        let mut scene = self.clone();
        for (owner, has) in self.owners() {
            for &quantity in has.iter().filter(|&&quantity| self.knows(quantity)) {
                let name = format!("{owner}.{}", words(quantity).0);
                let asked = scene.outputs.variables.iter().any(|known| known.text == name);
                if !asked {
                    scene.outputs.variables.push(Text::from(name.as_str()));
                }
            }
        }
        scene
    }

    /// What has variables, with the variables.
    fn owners(&self) -> Vec<(String, &'static [Quantity])> {
        let mut owners: Vec<(String, &'static [Quantity])> = Vec::new();
        for body in &self.bodies {
            owners.push((body.name.text.clone(), BODY));
            let points = body.points.iter().map(|point| (format!("{}.{}", body.name.text, point.name.text), POINT));
            owners.extend(points);
        }
        owners.extend(self.joints.iter().map(|joint| (joint.name.text.clone(), of_joint(&joint.kind).1)));
        owners.extend(self.drivers.iter().map(|driver| (driver.name.text.clone(), of_driver(&driver.kind))));
        owners.extend(self.loads.iter().map(|load| (load.name.text.clone(), of_load(&load.kind).1)));
        owners.extend([("energy".to_owned(), ENERGIES), ("constraint".to_owned(), RESIDUALS)]);
        owners
    }

    fn knows(&self, quantity: Quantity) -> bool {
        self.dimension == Dimension::Two || on_a_line(quantity)
    }
}
