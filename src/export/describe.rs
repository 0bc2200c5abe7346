//! The description of an FMU from the table of variables.

use std::collections::HashMap;
use std::sync::Arc;

use cotree_fmu::program::Source;

use super::description::{Causality, Description, ScalarVariable, Start};
use super::terminals::terminals;
use crate::formulate::Formulated;
use crate::model::{Mechanism, identifier};
use crate::program::TableRow;

/// The description of a formulated scene.
pub fn describe(formulated: &Formulated, guid: &str) -> Description {
    let mechanism = &formulated.equations.system.mechanism;
    let program = &formulated.lowered.program;
    let rows = &formulated.lowered.table.rows;
    let mut changing = Changing { rows, known: HashMap::new() };
    let followed = places(program.followed_inputs(), rows);
    let mut variables: Vec<ScalarVariable> =
        rows.iter().map(|row| variable((mechanism, program.mechanical()), &mut changing, row)).collect();
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
        exchange: program.offers_exchange().then_some(program.tapes.indicators.results.len()),
        exchange_with_rates: program.offers_exchange_with_rates(),
        indicators: program.tapes.indicators.results.len(),
        moves_states: !program.is_driven() && program.constraints.iter().any(|constraint| constraint.is_imposed()),
        own_steps: program.has_own_steps(),
        followed,
        variables,
        terminals: terminals(mechanism, rows),
    }
}

/// The places of inputs.
fn places(inputs: Vec<usize>, rows: &[TableRow]) -> Vec<usize> {
    let inputs = inputs.into_iter().map(|input| Source::Input(input as u32));
    inputs.filter_map(|source| rows.iter().position(|row| row.source == source)).collect()
}

/// What is said of an input that a driver follows.
fn with_derivatives(description: &str) -> String {
    const FOLLOWED: &str = "a driver follows it: unless its derivatives are set they are backward differences of its values at communication points";
    if description.is_empty() { FOLLOWED.to_owned() } else { format!("{description}; {FOLLOWED}") }
}

/// The states and inputs among what variables depend on: found once for a list, because many variables share a long one.
struct Changing<'a> {
    rows: &'a [TableRow],
    known: HashMap<*const usize, Arc<[usize]>>,
}

impl Changing<'_> {
    fn among(&mut self, places: &Arc<[usize]>) -> Arc<[usize]> {
        let Self { rows, known } = self;
        let changes = |place: &usize| rows.get(*place).is_some_and(|row| !matches!(row.source, Source::Parameter(_)));
        let found = known.entry(places.as_ptr()).or_insert_with(|| match places.iter().all(changes) {
            true => places.clone(),
            false => places.iter().copied().filter(changes).collect(),
        });
        found.clone()
    }
}

fn variable((mechanism, mechanical): (&Mechanism, usize), changing: &mut Changing, row: &TableRow) -> ScalarVariable {
    let causality = match (row.source, row.calculated) {
        (_, Some(tunable)) => Causality::CalculatedParameter { tunable },
        (Source::Parameter(index), _) => {
            let parameter = &mechanism.parameters[index as usize];
            Causality::Parameter {
                tunable: parameter.tunable,
                start: parameter.value,
                min: parameter.min,
                max: parameter.max,
            }
        }
        (Source::Input(index), _) => {
            let input = &mechanism.inputs[index as usize];
            Causality::Input { start: input.start, min: input.min, max: input.max }
        }
        (Source::Time, _) => Causality::Independent,
        _ if row.output => Causality::Output,
        _ => Causality::Local,
    };
    ScalarVariable {
        name: row.name.clone(),
        description: match (row.description.is_empty(), row.source) {
            (true, Source::Parameter(_)) => format!("parameter `{}` of the scene", row.name),
            (true, Source::Input(_)) => format!("input `{}` of the scene", row.name),
            _ => row.description.clone(),
        },
        unit: row.unit.clone(),
        causality,
        start: row.start.map(|start| match start.known {
            true => Start::Exact(start.value),
            false => Start::Approximate(start.value),
        }),
        derivative_of: row.derivative_of,
        // Continuous states are q and v of each coordinate in turn, then those of the scene.
        state: row.derivative_of.and(match row.source {
            Source::Rate(index) => Some(2 * index as usize),
            Source::Acceleration(index) if (index as usize) < mechanical => Some(2 * index as usize + 1),
            Source::Acceleration(index) => Some(mechanical + index as usize),
            _ => None,
        }),
        dependencies: changing.among(&row.dependencies),
        all_dependencies: row.dependencies.clone(),
    }
}
