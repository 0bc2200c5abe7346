//! A scene whose motion begins where its mechanism rests.

use cotree::expr::{Symbol, Values};
use cotree::model::{BodyId, Dimension, Mechanism, Owner, Place, Quantity, Unit, Variable};
use cotree::scene::{Scene, Text};

use super::study::{Study, StudyError};

impl Study {
    /// The scene of this study with its start at rest; what was set is then its default.
    ///
    /// # Errors
    /// The equations cannot be formulated, or no equilibrium is found.
    pub fn resting(&mut self, mut scene: Scene) -> Result<Scene, StudyError> {
        let values = self.rest(|formulated, _, equilibrium| {
            let mechanism = &*formulated.equations.system.mechanism.clone();
            let mut values = Vec::new();
            for variable in pose(mechanism) {
                let value = formulated.equations.variable(variable);
                let arena = &formulated.equations.system.arena;
                // What joints and drivers hold needs no guess.
                if arena.symbols([value]).iter().any(|symbol| matches!(symbol, Symbol::Coordinate(..))) {
                    let value = arena.evaluate(&[value], &|symbol| equilibrium.point.value(symbol))[0];
                    values.push((mechanism.variable_name(variable), value));
                }
            }
            Ok(values)
        })?;
        scene.initial.clear();
        Ok(self.settled(values.into_iter().fold(scene, |scene, (name, value)| scene.guess(&name, value))))
    }

    /// The scene of this study; what was set is its default.
    pub fn settled(&self, mut scene: Scene) -> Scene {
        adopt(&mut scene, self.mechanism());
        scene
    }
}

/// The positions of all bodies.
pub(super) fn pose(mechanism: &Mechanism) -> Vec<Variable> {
    let quantities: &[Quantity] = match mechanism.dimension {
        Dimension::One => &[Quantity::X],
        Dimension::Two => &[Quantity::X, Quantity::Y, Quantity::Angle],
    };
    let owners = (0..mechanism.bodies.len()).map(|body| Owner::Place(Place::Centre(BodyId(body))));
    owners.flat_map(|owner| quantities.iter().map(move |&quantity| Variable { owner, quantity })).collect()
}

/// Makes the values of a mechanism's parameters and inputs those of the scene.
fn adopt(scene: &mut Scene, mechanism: &Mechanism) {
    let unit = |unit: &Unit| (!unit.si.is_empty()).then(|| Text::from(unit.si.as_str()));
    for own in &mut scene.parameters {
        // Calculated ones follow those that are set.
        let Some(set) = mechanism.parameters.iter().find(|set| set.name == own.name.text) else { continue };
        (own.value, own.unit) = (set.value.into(), unit(&set.unit));
        (own.min, own.max) = (set.min.map(Into::into), set.max.map(Into::into));
    }
    for (own, set) in scene.inputs.iter_mut().zip(&mechanism.inputs) {
        (own.start, own.unit) = (Some(set.start.into()), unit(&set.unit));
        (own.min, own.max) = (set.min.map(Into::into), set.max.map(Into::into));
    }
}
