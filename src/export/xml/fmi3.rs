//! `modelDescription.xml` of FMI 3.0 for Co-Simulation and Model Exchange.
//!
//! After the variables of the program come those of this version alone: derivatives of inputs, time, event indicators. Everything is named by its
//! value reference, and what depends on what counts time and parameters among what is known (2.4.8).

use std::collections::HashSet;
use std::io;

use cotree_fmu::fmi3::references::{INPUT_ORDERS, References};
use cotree_fmu::fmi3::token;
use cotree_fmu::instance::DERIVATIVE_ORDER;

use super::{
    Attributes, Out, dependencies, document, element, experiment, header, initial, leaf, log_categories, moved, named,
    units, values,
};
use crate::export::description::{Causality, Description, ScalarVariable};
use crate::mechanism::Unit;

/// The standard's names where it has one (2.4.5).
const LOG_CATEGORIES: [(&str, &str); 3] = [
    ("logEvents", "begin, end, and singular poses that are passed"),
    ("logSolver", "what the solver does"),
    ("logStatusError", "why a call failed"),
];

/// The document. The same description gives the same bytes: it has no date.
pub fn model_description(description: &Description) -> io::Result<Vec<u8>> {
    let model = Model::new(description);
    let identity = ("instantiationToken", token(&description.guid));
    document("fmiModelDescription", header(description, "3.0", identity), |out| {
        if description.exchange_with_rates {
            let completed = ("needsCompletedIntegratorStep", "true".to_owned());
            leaf(out, "ModelExchange", model.common().into_iter().chain([completed]).collect())?;
        }
        leaf(out, "CoSimulation", model.capabilities())?;
        units(out, model.own.iter().chain(&description.variables).map(|variable| &variable.unit))?;
        log_categories(out, LOG_CATEGORIES)?;
        leaf(out, "DefaultExperiment", experiment(description))?;
        element(out, "ModelVariables", vec![], |out| model.variables(out))?;
        element(out, "ModelStructure", vec![], |out| model.structure(out))
    })
}

/// A description with what this version adds to it.
struct Model<'a> {
    description: &'a Description,
    references: References,
    /// Inputs, in the order of the program.
    inputs: Vec<usize>,
    /// Variables of this version alone, in the order of their value references.
    own: Vec<ScalarVariable>,
    /// The value reference of time.
    time: usize,
    /// States that an event may move.
    moved: HashSet<usize>,
}

impl<'a> Model<'a> {
    fn new(description: &'a Description) -> Self {
        let variables = &description.variables;
        let inputs: Vec<usize> = (0..variables.len())
            .filter(|&index| matches!(variables[index].causality, Causality::Input { .. }))
            .collect();
        let references = References::new(variables.len(), inputs.len(), description.indicators);
        let mut own: Vec<ScalarVariable> = inputs.iter().flat_map(|&input| derivatives(&variables[input])).collect();
        let time = variables.iter().position(|variable| variable.causality == Causality::Independent);
        own.push(plain("time", "time", Unit::time(), Causality::Independent));
        own.extend((1..=description.indicators).map(|number| {
            let about = "changes its sign where a law changes over to another piece";
            plain(&format!("event_indicator_{number}"), about, Unit::default(), Causality::Local)
        }));
        for variable in &mut own {
            // Names of the scene come first.
            while variables.iter().any(|other| other.name == variable.name) {
                variable.name.push('_');
            }
        }
        Self {
            description,
            references,
            inputs,
            own,
            time: time.unwrap_or(references.time()),
            moved: moved(description, description.exchange_with_rates),
        }
    }

    /// What both interfaces can do.
    fn common(&self) -> Attributes {
        let can = [
            "canGetAndSetFMUState",
            "canSerializeFMUState",
            "providesDirectionalDerivatives",
            "providesAdjointDerivatives",
        ];
        let mut attributes = vec![("modelIdentifier", self.description.identifier.clone())];
        attributes.extend(can.map(|name| (name, "true".to_owned())));
        attributes
    }

    fn capabilities(&self) -> Attributes {
        let can = [
            "canHandleVariableCommunicationStepSize",
            "providesIntermediateUpdate",
            "mightReturnEarlyFromDoStep",
            "canReturnEarlyAfterIntermediateUpdate",
            "hasEventMode",
        ];
        let mut attributes = self.common();
        attributes.extend(can.map(|name| (name, "true".to_owned())));
        attributes.push(("maxOutputDerivativeOrder", DERIVATIVE_ORDER.to_string()));
        attributes
    }

    fn variables(&self, out: &mut Out) -> io::Result<()> {
        let variables = &self.description.variables;
        for (index, variable) in variables.iter().enumerate() {
            self.variable(out, index, variable, variable.derivative_of)?;
        }
        for (place, variable) in self.own.iter().enumerate() {
            let reference = variables.len() + place;
            match variable.causality {
                Causality::Independent if reference != self.time => {}
                Causality::Input { .. } => {
                    let order = place % INPUT_ORDERS;
                    let before = if order == 0 { self.inputs[place / INPUT_ORDERS] } else { reference - 1 };
                    self.variable(out, reference, variable, Some(before))?;
                }
                _ => self.variable(out, reference, variable, None)?,
            }
        }
        Ok(())
    }

    fn variable(
        &self,
        out: &mut Out,
        reference: usize,
        variable: &ScalarVariable,
        derivative_of: Option<usize>,
    ) -> io::Result<()> {
        let mut attributes = named(reference, variable);
        attributes.extend(initial(variable));
        let is_indicator = reference > self.references.time();
        attributes.extend(
            (variable.causality.follows_motion() && !is_indicator).then(|| ("intermediateUpdate", "true".into())),
        );
        attributes.extend(values(variable));
        attributes.extend(derivative_of.map(|state| ("derivative", state.to_string())));
        attributes.extend(self.moved.contains(&reference).then(|| ("reinit", "true".into())));
        leaf(out, "Float64", attributes)
    }

    fn structure(&self, out: &mut Out) -> io::Result<()> {
        let description = self.description;
        let variables = &description.variables;
        for index in description.outputs() {
            self.unknown(out, "Output", index, &variables[index].all_dependencies)?;
        }
        for index in description.derivatives() {
            self.unknown(out, "ContinuousStateDerivative", index, &variables[index].all_dependencies)?;
        }
        for index in description.initial_unknowns() {
            // Time is among what everything is found from.
            let known: Vec<usize> =
                variables[index].initial_dependencies.iter().copied().chain([description.time()]).collect();
            self.unknown(out, "InitialUnknown", index, &known)?;
        }
        (0..description.indicators).try_for_each(|index| {
            leaf(out, "EventIndicator", vec![("valueReference", self.references.indicator(index).to_string())])
        })
    }

    fn unknown(&self, out: &mut Out, element: &str, index: usize, on: &[usize]) -> io::Result<()> {
        let mut attributes = vec![("valueReference", index.to_string())];
        attributes.extend(dependencies(on, |place| self.known(place)));
        leaf(out, element, attributes)
    }

    /// The value references of something known: with an input its derivatives.
    fn known(&self, place: usize) -> Vec<usize> {
        if place == self.description.time() {
            return vec![self.time];
        }
        let input = self.inputs.iter().position(|&input| input == place);
        let orders = 1..=INPUT_ORDERS;
        let derivatives = input
            .into_iter()
            .flat_map(|input| orders.clone().map(move |order| self.references.input_derivative(input, order)));
        std::iter::once(place).chain(derivatives).collect()
    }
}

/// The derivatives of an input, which keep to no bounds.
fn derivatives(input: &ScalarVariable) -> Vec<ScalarVariable> {
    let mut unit = input.unit.clone();
    let known = !unit.si.is_empty();
    let orders = (1..=INPUT_ORDERS).map(|order| {
        unit = if known { unit.per_second() } else { Unit::default() };
        let (name, which) = match order {
            1 => (format!("der({})", input.name), "first"),
            _ => (format!("der({},{order})", input.name), "second"),
        };
        let about = format!("{which} derivative of `{}` by time", input.name);
        plain(&name, &about, unit.clone(), Causality::Input { start: 0.0, min: None, max: None })
    });
    orders.collect()
}

/// A variable without anything special.
fn plain(name: &str, description: &str, unit: Unit, causality: Causality) -> ScalarVariable {
    ScalarVariable {
        name: name.to_owned(),
        description: description.to_owned(),
        unit,
        causality,
        start: None,
        derivative_of: None,
        state: None,
        dependencies: [].into(),
        all_dependencies: [].into(),
        initial_dependencies: [].into(),
    }
}
