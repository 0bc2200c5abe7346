//! The description of an FMU: plain data, written as `modelDescription.xml` by [`super::xml`].

use std::collections::HashMap;

use crate::model::{Credits, Experiment, Unit};
pub use crate::program::{Causality, ScalarVariable, StartValue, Type, Variability};

/// An FMU's description.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The scene's name.
    pub model_name: String,
    /// A C identifier: names the shared library; see [`crate::model::identifier`].
    pub identifier: String,
    /// What the runtime expects at instantiation.
    pub guid: String,
    /// One line; may be empty.
    pub description: String,
    /// Who made the model, and how it may be used.
    pub credits: Credits,
    pub experiment: Experiment,
    /// Number of event indicators, if somebody else can integrate the model: Model Exchange.
    pub exchange: Option<usize>,
    /// Can somebody else integrate it who also tells the rates of inputs, as FMI 3.0 lets him?
    pub exchange_with_rates: bool,
    /// The contact with a profile for which there is no Model Exchange.
    pub at_profile: Option<String>,
    pub indicators: usize,
    /// May an event of Model Exchange move the states? It closes the loops.
    pub moves_states: bool,
    /// Has Co-Simulation steps of its own, at the ends of which a communication step may end?
    pub own_steps: bool,
    /// Places of the inputs that a driver follows: their rates are needed, too.
    pub followed: Vec<usize>,
    /// Every variable; its place is its value reference in FMI 2.0, and one less than that in FMI 3.0.
    pub variables: Vec<ScalarVariable>,
    /// What can be connected together.
    pub terminals: Vec<Terminal>,
    /// The solver in C, if the FMU has sources.
    pub sources: Option<SourceSolver>,
}

/// A solver of fixed step as C source. It offers Co-Simulation only.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceSolver {
    /// The communication step, of which others must be multiples \[s\].
    pub step: f64,
    /// The step of the solver \[s\].
    pub solver_step: f64,
    /// The file in `sources/` that is compiled.
    pub compiled: &'static str,
}

/// Variables that belong to one part of the mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct Terminal {
    /// The part's name; unique.
    pub name: String,
    /// Its variables.
    pub members: Vec<Member>,
}

/// A variable of a terminal.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// What it is called there; unique.
    pub name: String,
    /// Its place among the variables.
    pub variable: usize,
    /// Does it add up to zero with others where it is connected?
    pub flow: Flow,
}

/// How a variable of a terminal is connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// It is the same at all ends.
    None,
    /// A force or torque on the mechanism.
    In,
    /// A force or torque of the mechanism.
    Out,
}

impl Description {
    /// Makes it the description of an FMU with sources, which say of themselves what they do otherwise than the runtime.
    pub fn offer_sources(&mut self, solver: SourceSolver, has_events: bool) {
        let gap = if self.description.is_empty() { "" } else { "; " };
        let events = if has_events { "; events are tested at the ends of steps" } else { "" };
        self.description += &format!("{gap}C sources with a fixed step of {} s{events}", solver.solver_step);
        (self.exchange, self.exchange_with_rates, self.own_steps) = (None, false, false);
        self.sources = Some(solver);
    }

    /// What is reported if nobody says more: the outputs, or everything computed if the scene names none.
    pub fn reported(&self) -> Vec<usize> {
        let outputs = self.outputs();
        if !outputs.is_empty() {
            return outputs;
        }
        let variables = self.variables.iter().enumerate();
        variables.filter(|(_, variable)| variable.causality == Causality::Local).map(|(index, _)| index).collect()
    }

    /// The unit of each variable.
    pub fn units(&self) -> HashMap<&str, &Unit> {
        self.variables.iter().map(|variable| (variable.name.as_str(), &variable.unit)).collect()
    }

    /// Stands for time in lists of dependencies.
    pub fn time(&self) -> usize {
        self.variables.len()
    }

    /// Indices of the outputs.
    pub fn outputs(&self) -> Vec<usize> {
        self.indices(|variable| variable.causality == Causality::Output)
    }

    /// Indices of the derivatives, in the order of the states.
    pub fn derivatives(&self) -> Vec<usize> {
        let mut derivatives = self.indices(|variable| variable.derivative_of.is_some());
        derivatives.sort_by_key(|&index| self.variables[index].state);
        derivatives
    }

    /// Indices of what must be solved for at initialisation: calculated parameters, and the calculated or guessed ones among outputs, states
    /// and derivatives.
    pub fn initial_unknowns(&self) -> Vec<usize> {
        let mut wanted = self.outputs();
        wanted.extend(self.indices(|variable| matches!(variable.causality, Causality::CalculatedParameter)));
        for derivative in self.derivatives() {
            wanted.push(derivative);
            wanted.extend(self.variables[derivative].derivative_of);
        }
        wanted.retain(|&index| {
            let variable = &self.variables[index];
            variable.causality.range().is_none() && !matches!(variable.start, Some(StartValue::Exact(_)))
        });
        wanted.sort_unstable();
        wanted.dedup();
        wanted
    }

    fn indices(&self, wanted: impl Fn(&ScalarVariable) -> bool) -> Vec<usize> {
        self.variables.iter().enumerate().filter(|(_, variable)| wanted(variable)).map(|(index, _)| index).collect()
    }
}

/// Does a name follow the structured naming convention: C identifiers, joined by dots?
pub fn is_structured(name: &str) -> bool {
    name.split('.').all(|part| {
        part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structured_names() {
        assert!(is_structured("rod.small_end.x"));
        for flat in ["", "größe", "a..b", "2nd", "a b", "crank.", ".x"] {
            assert!(!is_structured(flat), "{flat}");
        }
    }
}
