//! `modelDescription.xml` of FMI 2.0 for Co-Simulation and Model Exchange.

use std::io;

use cotree_fmu::instance::DERIVATIVE_ORDER;

use super::{
    Attributes, Out, document, element, experiment, header, initial, leaf, log_categories, moved, named, units, values,
};
use crate::export::description::{Causality, Description, ScalarVariable};

/// Names of the log categories that the runtime uses, and what is logged under them.
const LOG_CATEGORIES: [(&str, &str); 3] = [
    ("events", "start, end, and singular configurations that are crossed"),
    ("solver", "what the solver does"),
    ("errors", "why a call failed"),
];

/// The document. The same description gives the same bytes: it has no date.
pub fn model_description(description: &Description) -> io::Result<Vec<u8>> {
    let mut head = header(description, "2.0", ("guid", description.guid.clone()));
    head.extend(description.exchange.map(|indicators| ("numberOfEventIndicators", indicators.to_string())));
    document("fmiModelDescription", head, |out| {
        if description.exchange.is_some() {
            leaf(out, "ModelExchange", common(description))?;
        }
        match &description.sources {
            Some(sources) => element(out, "CoSimulation", of_sources(description), |out| {
                element(out, "SourceFiles", vec![], |out| {
                    leaf(out, "File", vec![("name", sources.compiled.to_owned())])
                })
            })?,
            None => leaf(out, "CoSimulation", capabilities(description))?,
        }
        units(out, description.variables.iter().map(|variable| &variable.unit))?;
        log_categories(out, LOG_CATEGORIES)?;
        leaf(out, "DefaultExperiment", experiment(description))?;
        element(out, "ModelVariables", vec![], |out| {
            let moved = moved(description, description.exchange.is_some());
            let variables = description.variables.iter().enumerate();
            variables.into_iter().try_for_each(|(index, variable)| scalar(out, index, variable, moved.contains(&index)))
        })?;
        structure(out, description)
    })
}

fn capabilities(description: &Description) -> Attributes {
    let flags = [
        ("canHandleVariableCommunicationStepSize", "true".to_owned()),
        ("canInterpolateInputs", "true".to_owned()),
        ("maxOutputDerivativeOrder", DERIVATIVE_ORDER.to_string()),
        ("canRunAsynchronuously", "false".to_owned()), // spelt like this in the standard
    ];
    common(description).into_iter().chain(flags).collect()
}

/// What the solver in C can do.
fn of_sources(description: &Description) -> Attributes {
    let flags = [
        ("needsExecutionTool", "false"),
        ("canHandleVariableCommunicationStepSize", "false"),
        ("canBeInstantiatedOnlyOncePerProcess", "true"),
        ("canNotUseMemoryManagementFunctions", "true"),
    ];
    let identifier = ("modelIdentifier", description.identifier.clone());
    std::iter::once(identifier).chain(flags.map(|(name, value)| (name, value.to_owned()))).collect()
}

/// What both interfaces can do.
fn common(description: &Description) -> Attributes {
    let flags = [
        ("needsExecutionTool", "false"),
        ("canBeInstantiatedOnlyOncePerProcess", "false"),
        ("canNotUseMemoryManagementFunctions", "true"),
        ("canGetAndSetFMUstate", "true"),
        ("canSerializeFMUstate", "true"),
        ("providesDirectionalDerivative", "true"),
    ];
    let mut attributes = vec![("modelIdentifier", description.identifier.clone())];
    attributes.extend(flags.map(|(name, value)| (name, value.to_owned())));
    attributes
}

fn scalar(out: &mut Out, index: usize, variable: &ScalarVariable, moved: bool) -> io::Result<()> {
    let mut attributes = named(index, variable);
    // The standard permits none for inputs.
    attributes.extend(initial(variable).filter(|_| !matches!(variable.causality, Causality::Input { .. })));
    element(out, "ScalarVariable", attributes, |out| {
        let mut attributes = values(variable);
        attributes.extend(variable.derivative_of.map(|state| ("derivative", ordinal(state))));
        attributes.extend(moved.then(|| ("reinit", "true".to_string())));
        let [element, _] = variable.kind.elements();
        leaf(out, element, attributes)
    })
}

fn structure(out: &mut Out, description: &Description) -> io::Result<()> {
    element(out, "ModelStructure", vec![], |out| {
        unknowns(out, "Outputs", description, &description.outputs(), true)?;
        unknowns(out, "Derivatives", description, &description.derivatives(), true)?;
        // Without dependencies: on everything known.
        unknowns(out, "InitialUnknowns", description, &description.initial_unknowns(), false)
    })
}

/// A list of unknowns; none at all if empty: the schema wants at least one.
fn unknowns(
    out: &mut Out,
    list: &str,
    description: &Description,
    indices: &[usize],
    dependencies: bool,
) -> io::Result<()> {
    if indices.is_empty() {
        return Ok(());
    }
    element(out, list, vec![], |out| {
        indices.iter().try_for_each(|&index| {
            let on = dependencies
                .then(|| super::dependencies(&description.variables[index].dependencies, |on| vec![on + 1]));
            let index = ("index", ordinal(index));
            leaf(out, "Unknown", std::iter::once(index).chain(on.flatten()).collect())
        })
    })
}

/// The standard counts variables from 1.
fn ordinal(index: usize) -> String {
    (index + 1).to_string()
}
