//! The description of an FMU from the table of variables.

use cotree_fmu::program::Source;

use super::description::{Description, ScalarVariable};
use super::terminals::terminals;
use crate::formulate::Formulated;
use crate::model::identifier;
use crate::program::TableRow;

/// The description of a formulated scene.
pub fn describe(formulated: &Formulated, guid: &str) -> Description {
    let mechanism = &formulated.equations.system.mechanism;
    let program = &formulated.lowered.program;
    let rows = &formulated.lowered.table.rows;
    let followed = places(program.followed_inputs(), rows);
    let mut variables: Vec<ScalarVariable> = rows.iter().map(|row| row.variable.clone()).collect();
    for place in places(program.inputs_with_rates(), rows) {
        variables[place].description = with_derivatives(&variables[place].description);
    }
    Description {
        model_name: mechanism.name.clone(),
        identifier: identifier(&mechanism.name),
        guid: guid.to_string(),
        description: mechanism.description.clone(),
        credits: mechanism.credits.clone(),
        experiment: mechanism.experiment,
        exchange: program.offers_exchange().then_some(program.indicators()),
        exchange_with_rates: program.offers_exchange_with_rates(),
        at_profile: mechanism.first_at_profile().map(|part| part.name.clone()),
        indicators: program.indicators(),
        moves_states: !program.is_driven() && program.constraints.iter().any(|constraint| constraint.is_imposed()),
        own_steps: program.has_own_steps(),
        followed,
        variables,
        terminals: terminals(mechanism, &formulated.outputs, rows),
        sources: None,
    }
}

/// The places of inputs.
fn places(inputs: Vec<usize>, rows: &[TableRow]) -> Vec<usize> {
    let inputs = inputs.into_iter().map(|input| Source::Input(input as u32));
    inputs.filter_map(|source| rows.iter().position(|row| row.source == source)).collect()
}

/// What is said of an input that a driver follows.
fn with_derivatives(description: &str) -> String {
    const FOLLOWED: &str = "prescribes a motion: derivatives that are not set are backward differences of its values at communication points";
    if description.is_empty() { FOLLOWED.to_owned() } else { format!("{description}; {FOLLOWED}") }
}
