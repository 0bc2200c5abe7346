//! The description of an FMU: plain data, written as `modelDescription.xml` by [`super::xml`].

use std::collections::HashMap;
use std::sync::Arc;

use crate::model::{Credits, Experiment, Unit};

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

/// A variable of type Real.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalarVariable {
    /// The structured name, unique.
    pub name: String,
    /// One line; may be empty.
    pub description: String,
    /// Its unit; the empty unit if it is not known or a pure number.
    pub unit: Unit,
    /// What it is to the importer.
    pub causality: Causality,
    /// Its initial value, if it is calculated and that can be set.
    pub start: Option<Start>,
    /// Index of the variable whose derivative it is.
    pub derivative_of: Option<usize>,
    /// For a derivative, the place of its state among the states.
    pub state: Option<usize>,
    /// Indices of the inputs and states that it depends on while simulating.
    pub dependencies: Arc<[usize]>,
    /// The same with the parameters, and [`Description::time`] if it depends on time: what FMI 3.0 counts as known.
    pub all_dependencies: Arc<[usize]>,
}

/// The initial value of a calculated variable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// It holds.
    Exact(f64),
    /// A guess that picks the assembly.
    Approximate(f64),
}

/// What a variable is to the importer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Causality {
    /// Set before the simulation, or if tunable during it.
    Parameter {
        /// May it change after initialisation?
        tunable: bool,
        /// Default value, SI.
        start: f64,
        /// Smallest permitted value, SI.
        min: Option<f64>,
        /// Largest permitted value, SI.
        max: Option<f64>,
    },
    /// Follows parameters that can be set.
    CalculatedParameter {
        /// May these change after initialisation?
        tunable: bool,
    },
    /// Set at communication points.
    Input {
        /// Value until it is set, SI.
        start: f64,
        /// Smallest permitted value, SI.
        min: Option<f64>,
        /// Largest permitted value, SI.
        max: Option<f64>,
    },
    /// Asked for by the scene.
    Output,
    /// Readable, but not asked for.
    Local,
    /// Time.
    Independent,
}

impl Causality {
    /// The word for it in the standard.
    pub fn name(self) -> &'static str {
        match self {
            Causality::Parameter { .. } => "parameter",
            Causality::CalculatedParameter { .. } => "calculatedParameter",
            Causality::Input { .. } => "input",
            Causality::Output => "output",
            Causality::Local => "local",
            Causality::Independent => "independent",
        }
    }

    /// When its value may change.
    pub fn variability(self) -> &'static str {
        match self {
            Causality::Parameter { tunable: false, .. } | Causality::CalculatedParameter { tunable: false } => "fixed",
            Causality::Parameter { tunable: true, .. } | Causality::CalculatedParameter { tunable: true } => "tunable",
            _ => "continuous",
        }
    }

    /// Of what the importer sets: its default, and the smallest and the largest value permitted, SI.
    pub fn range(self) -> Option<(f64, [Option<f64>; 2])> {
        match self {
            Causality::Parameter { start, min, max, .. } | Causality::Input { start, min, max } => {
                Some((start, [min, max]))
            }
            Causality::CalculatedParameter { .. } | Causality::Output | Causality::Local | Causality::Independent => {
                None
            }
        }
    }

    /// Is its value computed along the motion?
    pub fn follows_motion(self) -> bool {
        matches!(self, Causality::Output | Causality::Local)
    }
}

impl Description {
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
        wanted.extend(self.indices(|variable| matches!(variable.causality, Causality::CalculatedParameter { .. })));
        for derivative in self.derivatives() {
            wanted.push(derivative);
            wanted.extend(self.variables[derivative].derivative_of);
        }
        wanted.retain(|&index| {
            let variable = &self.variables[index];
            variable.causality.range().is_none() && !matches!(variable.start, Some(Start::Exact(_)))
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
