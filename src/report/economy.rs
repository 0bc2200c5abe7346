//! Only what the scene needs: what was left out of the model and why, and what each output costs.

use cotree_fmu::program::{Motion, Source};
use serde::Serialize;

use crate::formulate::Formulated;
use crate::lower::{Cost, kernel_cost};
use crate::mechanism::Dimension;

/// The place of mass among the exponents of a unit.
const MASS: usize = 0;

/// What was left out, and what the outputs cost.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Economy {
    /// What other scenes need and this one does not.
    pub left_out: Vec<LeftOut>,
    /// What it costs to compute each output at a communication point, alone.
    pub outputs: Vec<OutputCost>,
    /// The same for all outputs together: what they share counts once.
    pub together: usize,
}

/// Something that the model does not have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// What.
    pub part: &'static str,
    /// Why.
    pub reason: String,
}

/// The cost of an output.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutputCost {
    /// Its name.
    pub name: String,
    /// Operations for each value that is read.
    pub operations: usize,
    /// Does it need the accelerations or reactions at the communication point?
    pub accelerated: bool,
}

impl Economy {
    /// What a mechanism that has been formulated does without.
    pub fn of(formulated: &Formulated) -> Self {
        let own = &formulated.equations;
        let asked = || formulated.lowered.table.rows.iter().filter(|row| row.output);
        let outputs = asked().map(|row| OutputCost {
            name: row.name.clone(),
            operations: operations(kernel_cost(own, &[row.value])),
            accelerated: match row.source {
                Source::Output { accelerated, .. } => accelerated,
                Source::Acceleration(_) => true,
                _ => false,
            },
        });
        let values: Vec<_> = asked().map(|row| row.value).collect();
        Self {
            left_out: left_out(formulated),
            outputs: outputs.collect(),
            together: operations(kernel_cost(own, &values)),
        }
    }
}

fn operations(cost: Cost) -> usize {
    cost.operations + cost.pairs
}

fn left_out(formulated: &Formulated) -> Vec<LeftOut> {
    let mechanism = formulated.equations.system.mechanism;
    let program = &formulated.lowered.program;
    let mut list = Vec::new();
    let mut leave = |when: bool, part: &'static str, reason: &str| {
        if when {
            list.push(LeftOut { part, reason: reason.into() });
        }
    };
    let kinematic = program.motion == Motion::Kinematic;
    let open = !program.constraints.iter().any(|constraint| constraint.active);
    let outputs = || formulated.lowered.table.rows.iter().filter(|row| row.output);
    let massive = outputs().any(|row| row.unit.exponents[MASS] != 0);
    let accelerated =
        outputs().any(|row| matches!(row.source, Source::Output { accelerated: true, .. } | Source::Acceleration(_)));
    leave(mechanism.dimension == Dimension::One, "rotation", "the masses are on a line, which has no angles");
    leave(
        open,
        "loop equations",
        "no chord of the trees holds anything: nothing is projected, and there is no multiplier",
    );
    leave(kinematic, "integrator", "drivers and loops determine the motion: positions follow from the loop equations");
    leave(
        kinematic && !accelerated && !massive,
        "masses and forces",
        "drivers and loops determine the motion, and no output is a force or an acceleration",
    );
    leave(!kinematic && !program.automatic, "choice of the method", "the scene names one");
    leave(program.inputs.is_empty(), "inputs", "the scene has none: one step may serve many communication points");
    leave(
        !kinematic && !accelerated,
        "accelerations at communication points",
        "no output is an acceleration or a reaction",
    );
    leave(
        program.tapes.outputs.results.is_empty(),
        "output kernel",
        "all outputs are coordinates, inputs or parameters",
    );
    list
}
