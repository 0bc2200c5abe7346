//! `modelDescription.xml` of FMI 3.0 for Co-Simulation and Model Exchange.
//!
//! After the variables of the program come those of this version alone: derivatives of the inputs that a driver follows, event indicators, time. Everything
//! is named by its value reference, which is its place counted from 1, and what depends on what counts time and parameters among what is known (2.4.8).

use std::collections::HashSet;
use std::io;

use cotree_fmu::fmi3::references::{INPUT_ORDERS, References, reference};
use cotree_fmu::fmi3::token;
use cotree_fmu::instance::DERIVATIVE_ORDER;

use super::number;
use super::{
    Attributes, Out, dependencies, document, element, experiment, header, initial, leaf, log_categories, moved, named,
    units, values,
};
use crate::export::description::{Causality, Description, ScalarVariable};
use crate::model::Unit;

/// The standard's names where it has one (2.4.5).
const LOG_CATEGORIES: [(&str, &str); 3] = [
    ("logEvents", "start, end, and singular configurations that are crossed"),
    ("logSolver", "what the solver does"),
    ("logStatusError", "why a call failed"),
];

/// The document. The same description gives the same bytes: it has no date.
pub fn model_description(description: &Description) -> io::Result<Vec<u8>> {
    let model = Fmi3Description::new(description);
    let identity = ("instantiationToken", token(&description.guid));
    document("fmiModelDescription", header(description, "3.0", identity), |out| {
        if description.exchange_with_rates {
            let completed = ("needsCompletedIntegratorStep", "true".to_owned());
            leaf(out, "ModelExchange", model.common().into_iter().chain([completed]).collect())?;
        }
        leaf(out, "CoSimulation", model.capabilities())?;
        units(out, model.added.iter().chain(&description.variables).map(|variable| &variable.unit))?;
        log_categories(out, LOG_CATEGORIES)?;
        leaf(out, "DefaultExperiment", experiment(description))?;
        element(out, "ModelVariables", vec![], |out| model.variables(out))?;
        element(out, "ModelStructure", vec![], |out| model.structure(out))
    })
}

/// A description with what this version adds to it.
struct Fmi3Description<'a> {
    description: &'a Description,
    references: References,
    /// Variables of this version alone, in the order of their value references.
    added: Vec<ScalarVariable>,
    /// The value reference of time.
    time: usize,
    /// Places of the states that an event may move.
    moved: HashSet<usize>,
}

impl<'a> Fmi3Description<'a> {
    fn new(description: &'a Description) -> Self {
        let Description { variables, followed, indicators, .. } = description;
        let references = References::new(variables.len(), followed.clone(), *indicators);
        let mut derivatives: Vec<ScalarVariable> =
            followed.iter().flat_map(|&input| derivatives(&variables[input])).collect();
        derivatives.extend((1..=*indicators).map(|number| {
            let about = "changes sign where a law switches to another piece";
            let name = format!("event_indicator_{number}");
            ScalarVariable::new(name, about.to_owned(), Unit::default(), Causality::Local)
        }));
        let time = variables.iter().position(|variable| variable.causality == Causality::Independent);
        let independent = || ScalarVariable::new("time".into(), "time".into(), Unit::time(), Causality::Independent);
        derivatives.extend(time.is_none().then(independent));
        for variable in &mut derivatives {
            // Names of the scene come first.
            while variables.iter().any(|other| other.name == variable.name) {
                variable.name.push('_');
            }
        }
        Self {
            description,
            added: derivatives,
            time: time.map_or(references.time(), reference),
            references,
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
        if let Some(sources) = &self.description.sources {
            return vec![
                ("modelIdentifier", self.description.identifier.clone()),
                ("canBeInstantiatedOnlyOncePerProcess", "true".to_owned()),
                ("fixedInternalStepSize", number(sources.solver_step)),
            ];
        }
        let own_steps = self.description.own_steps;
        let can = [
            ("canHandleVariableCommunicationStepSize", true),
            ("providesIntermediateUpdate", true),
            ("mightReturnEarlyFromDoStep", own_steps),
            ("canReturnEarlyAfterIntermediateUpdate", own_steps),
            ("hasEventMode", true),
        ];
        let mut attributes = self.common();
        attributes.extend(can.into_iter().filter(|(_, can)| *can).map(|(name, _)| (name, "true".to_owned())));
        attributes.push(("maxOutputDerivativeOrder", DERIVATIVE_ORDER.to_string()));
        attributes
    }

    fn variables(&self, out: &mut Out) -> io::Result<()> {
        let Description { variables, followed, .. } = self.description;
        for (place, variable) in variables.iter().chain(&self.added).enumerate() {
            if self.is_left_out(place) {
                continue;
            }
            let index = place.checked_sub(variables.len());
            let derivative_of = match (index, variable.causality) {
                // The rate of an input is followed by its derivative.
                (Some(index), Causality::Input { .. }) if index % INPUT_ORDERS == 0 => {
                    Some(followed[index / INPUT_ORDERS])
                }
                (Some(_), Causality::Input { .. }) => Some(place - 1),
                _ => variable.derivative_of,
            };
            let mut attributes = named(reference(place), variable);
            attributes.extend(initial(variable));
            // Event indicators are for Model Exchange.
            let intermediate = variable.flows() && index.is_none();
            attributes.extend(intermediate.then(|| ("intermediateUpdate", "true".into())));
            attributes.extend(values(variable));
            attributes.extend(derivative_of.map(|state| ("derivative", reference(state).to_string())));
            attributes.extend(self.moved.contains(&place).then(|| ("reinit", "true".into())));
            let [_, element] = variable.kind.elements();
            leaf(out, element, attributes)?;
        }
        Ok(())
    }

    /// Sources have no event indicators; time keeps its value reference.
    fn is_left_out(&self, place: usize) -> bool {
        let mut indicators = (0..self.description.indicators).map(|index| self.references.indicator(index));
        self.description.sources.is_some() && indicators.any(|indicator| indicator == reference(place))
    }

    fn structure(&self, out: &mut Out) -> io::Result<()> {
        let description = self.description;
        let variables = &description.variables;
        for place in description.outputs() {
            self.unknown(out, "Output", place, &variables[place].all_dependencies)?;
        }
        for place in description.derivatives() {
            self.unknown(out, "ContinuousStateDerivative", place, &variables[place].all_dependencies)?;
        }
        for place in description.initial_unknowns() {
            leaf(out, "InitialUnknown", vec![("valueReference", reference(place).to_string())])?;
        }
        if description.sources.is_some() {
            return Ok(());
        }
        (0..description.indicators).try_for_each(|index| {
            leaf(out, "EventIndicator", vec![("valueReference", self.references.indicator(index).to_string())])
        })
    }

    fn unknown(&self, out: &mut Out, element: &str, place: usize, on: &[usize]) -> io::Result<()> {
        let mut attributes = vec![("valueReference", reference(place).to_string())];
        attributes.extend(dependencies(on, |place| self.known(place)));
        leaf(out, element, attributes)
    }

    /// The value references of something known: with an input its derivatives.
    fn known(&self, place: usize) -> Vec<usize> {
        if place == self.description.time() {
            return vec![self.time];
        }
        let followed = self.description.followed.iter().position(|&input| input == place);
        let derivatives = followed
            .into_iter()
            .flat_map(|input| (1..=INPUT_ORDERS).map(move |order| self.references.input_derivative(input, order)));
        std::iter::once(reference(place)).chain(derivatives).collect()
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
        let about = format!("{which} time derivative of `{}`", input.name);
        ScalarVariable::new(name, about, unit.clone(), Causality::Input { start: 0.0, min: None, max: None })
    });
    orders.collect()
}
