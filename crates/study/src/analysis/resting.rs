//! A study whose motion starts in static equilibrium.

use std::collections::HashMap;

use cotree::compile::{Compiled, compile_resolved};
use cotree::expr::{Symbol, Values};
use cotree::model::{Formula, Variable};
use cotree::scene::{Faults, Resolved};

use super::study::{Study, StudyError};

impl Study {
    /// Begins the motion of this study at rest.
    ///
    /// # Errors
    /// The equations cannot be formulated, or no equilibrium is found.
    pub fn begin_at_rest(&mut self) -> Result<(), StudyError> {
        let known = self.warnings.clone();
        let (values, states): (HashMap<Variable, f64>, Vec<f64>) = self.rest(|formulated, _, equilibrium| {
            let mut values = HashMap::new();
            for variable in formulated.equations.system.mechanism.pose() {
                let value = formulated.equations.variable(variable);
                let arena = &formulated.equations.system.arena;
                // What joints and drivers hold needs no guess.
                if arena.symbols([value]).iter().any(|symbol| matches!(symbol, Symbol::Coordinate(..))) {
                    let value = arena.evaluate(&[value], &|symbol| equilibrium.point.value(symbol))[0];
                    values.insert(variable, value);
                }
            }
            Ok((values, equilibrium.point.states().to_vec()))
        })?;
        // Those of the equations come again with the program.
        self.warnings = known;
        self.written = None;
        self.mechanism = self.mechanism.posed(|variable| values.get(&variable).copied());
        for (state, value) in self.mechanism.states.iter_mut().zip(states) {
            state.start = Formula::Number(value);
        }
        Ok(())
    }

    /// The program of this study; what was set is its default.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn compiled(&self) -> Result<Compiled, Faults> {
        let resolved = Resolved {
            mechanism: self.mechanism.clone(),
            outputs: self.outputs.clone(),
            warnings: self.warnings.clone(),
        };
        compile_resolved(resolved, &self.source).map(|(compiled, _)| compiled)
    }
}
