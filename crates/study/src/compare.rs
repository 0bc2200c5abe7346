//! Comparison of trees: equations, operations, time and condition numbers of one mechanism in several coordinates.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use cotree::expr::Expr;
use cotree::formulate::{Formulated, formulate_written};
use cotree::model::{CoordinateChoice, Experiment, Mechanism, Output};
use cotree::report::data::{Cell, Report, Table};
use cotree::row;
use cotree::scene::{Faults, Scene};
use cotree_fmu::machine::Machine;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use cotree_fmu::program::check::ProgramError;
use cotree_fmu::tape::{Operation, Tape};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::analysis::{dense, saddle};
use crate::bench;
use crate::bench::runs::{BenchSubject, Budget, POINTS};

/// The choices that every scene has; the scene's own is added if it is another one.
const CHOICES: [(&str, CoordinateChoice); 3] = [
    ("absolute", CoordinateChoice::Absolute),
    ("joint", CoordinateChoice::Joint),
    ("recommended", CoordinateChoice::Recommended),
];

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoordinateComparison {
    pub kernel: &'static str,
    pub choices: Vec<Choice>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// `absolute`, `joint`, `recommended`, or `chosen` for the scene's own trees.
    pub name: &'static str,
    pub used: bool,
    /// The figures, or why these trees do not work.
    #[serde(flatten)]
    pub figures: CostOrFault,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum CostOrFault {
    Good(ChoiceCost),
    Bad { fault: String },
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ChoiceCost {
    pub coordinates: usize,
    pub loop_equations: usize,
    pub operations: Operations,
    /// Time of one evaluation, the median of repeated runs \[ns\].
    pub nanoseconds: f64,
    /// The method: `series`, `explicit`, `implicit`.
    pub method: &'static str,
    /// Time of the whole experiment at its tolerance, processor time on one thread \[s\]; `None` if it fails or takes too long.
    pub run_seconds: Option<f64>,
    pub steps: Option<u64>,
    /// Condition number at the start of \[M J^T; J 0\], or of J for a kinematic model, rows and columns scaled; `None` if
    /// singular.
    pub condition: Option<f64>,
    /// The same of M; `None` if singular or if there are no masses.
    pub mass_condition: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Operations {
    pub additions: usize,
    pub multiplications: usize,
    pub divisions: usize,
    pub square_roots: usize,
    pub sine_cosine_pairs: usize,
    pub others: usize,
}

/// Formulates a mechanism in all coordinates and measures each.
pub fn compare(mechanism: &Mechanism, outputs: &[Output]) -> CoordinateComparison {
    let is_preset = CHOICES.iter().any(|(_, choice)| *choice == mechanism.coordinates);
    let chosen = (!is_preset).then(|| ("chosen", mechanism.coordinates.clone()));
    let choices: Vec<Choice> = CHOICES
        .into_iter()
        .chain(chosen)
        .map(|(name, coordinates)| {
            let used = coordinates == mechanism.coordinates;
            Choice { name, used, figures: figures(&Mechanism { coordinates, ..mechanism.clone() }, outputs) }
        })
        .collect();
    CoordinateComparison { kernel: ACCELERATION, choices }
}

const ACCELERATION: &str = "accelerations and reactions";

fn figures(mechanism: &Mechanism, outputs: &[Output]) -> CostOrFault {
    match formulate_written(mechanism, outputs) {
        Ok(formulated) => match cost(formulated) {
            Ok(cost) => CostOrFault::Good(cost),
            Err(fault) => CostOrFault::Bad { fault: fault.to_string() },
        },
        Err(faults) => {
            let messages: Vec<String> = faults.into_iter().map(|fault| fault.message).collect();
            CostOrFault::Bad { fault: messages.join("; ") }
        }
    }
}

fn cost(mut formulated: Formulated) -> Result<ChoiceCost, ProgramError> {
    let model = Model::new(formulated.lowered.program.clone())?;
    let kernel = &model.program().tapes.acceleration;
    let mut machine = Machine::new(&model);
    machine.load(&model, &formulated.state);
    let nanoseconds = time(&mut machine, kernel);
    let operations = count(kernel);
    let method = match model.program().engine {
        Engine::Taylor => "series",
        Engine::Dop853 => "explicit",
        Engine::Radau => "implicit",
    };
    let dynamic = !model.is_driven();
    let whole = whole_run(Arc::new(model), formulated.equations.system.mechanism.experiment);
    let (condition, mass_condition) = conditions(&mut formulated, dynamic);
    Ok(ChoiceCost {
        coordinates: formulated.equations.coordinates.len(),
        loop_equations: formulated.equations.constraints.iter().filter(|row| !row.is_trivial()).count(),
        operations,
        nanoseconds,
        method,
        run_seconds: whole.map(|(seconds, _)| seconds),
        steps: whole.map(|(_, steps)| steps),
        condition,
        mass_condition,
    })
}

/// Processor time and steps of the whole experiment, by the method that the model chooses.
fn whole_run(model: Arc<Model>, experiment: Experiment) -> Option<(f64, u64)> {
    let subject = BenchSubject { model: &model, variables: &[], experiment };
    let found = subject.run(None, experiment.tolerance, Budget::Run, &subject.even(POINTS)).ok()?;
    let (fastest, _) = subject.time(None, experiment.tolerance)?;
    Some((fastest.as_secs_f64(), found.instance.statistics().steps))
}

/// Counts instructions; a multiplication with an addition or subtraction counts as both.
pub fn count(tape: &Tape) -> Operations {
    let mut counts = Operations::default();
    for instruction in tape.instructions() {
        match instruction.operation {
            Operation::Add | Operation::Subtract | Operation::Negate => counts.additions += 1,
            Operation::Multiply => counts.multiplications += 1,
            Operation::MultiplyAdd | Operation::MultiplySubtract | Operation::SubtractProduct => {
                counts.additions += 1;
                counts.multiplications += 1;
            }
            Operation::Divide => counts.divisions += 1,
            Operation::SquareRoot => counts.square_roots += 1,
            Operation::SinCos => counts.sine_cosine_pairs += 1,
            Operation::Copy => {}
            _ => counts.others += 1,
        }
    }
    counts
}

/// The median of runs that are long enough for the clock.
fn time(machine: &mut Machine, tape: &Tape) -> f64 {
    const RUNS: usize = 15;
    const SHORTEST: f64 = 2e5;
    let mut measure = |repeats: usize| {
        let start = Instant::now();
        for _ in 0..repeats {
            black_box(&mut *machine).run(tape);
        }
        start.elapsed().as_secs_f64() * 1e9
    };
    let mut repeats = 16;
    while measure(repeats) < SHORTEST && repeats < 1 << 20 {
        repeats *= 2;
    }
    let mut runs: Vec<f64> = (0..RUNS).map(|_| measure(repeats) / repeats as f64).collect();
    runs.sort_by(f64::total_cmp);
    runs[RUNS / 2]
}

/// Of the equations that are solved for accelerations, and of the mass matrix.
fn conditions(formulated: &mut Formulated, dynamic: bool) -> (Option<f64>, Option<f64>) {
    let mass = dynamic.then(|| formulated.equations.dynamics().mass.clone());
    let Formulated { equations, state, redundant, .. } = formulated;
    let (n, values) = (equations.coordinates.len(), |exprs: &[Expr]| equations.system.arena.evaluate(exprs, state));
    let active = equations.constraints.iter().enumerate().filter(|(index, _)| !redundant.contains(index));
    let jacobian = dense(active.map(|(_, row)| &row.jacobian), n, values);
    let Some(mass) = mass.map(|mass| dense(&mass, n, values)) else { return (condition(jacobian), None) };
    (condition(saddle(&mass, &jacobian.transpose(), &jacobian)), condition(mass))
}

/// Largest over smallest singular value, after rows and columns have been scaled to largest entries of about 1 (Ruiz).
fn condition(mut matrix: DMatrix<f64>) -> Option<f64> {
    const ROUNDS: usize = 40;
    for _ in 0..ROUNDS {
        let factor = |largest: f64| if largest > 0.0 { largest.sqrt().recip() } else { 1.0 };
        let rows: Vec<f64> = matrix.row_iter().map(|row| factor(row.amax())).collect();
        let columns: Vec<f64> = matrix.column_iter().map(|column| factor(column.amax())).collect();
        for (row, by_row) in rows.iter().enumerate() {
            for (column, by_column) in columns.iter().enumerate() {
                matrix[(row, column)] *= by_row * by_column;
            }
        }
    }
    if matrix.is_empty() || !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let singular = matrix.svd(false, false).singular_values;
    let (largest, smallest) = (singular.max(), singular.min());
    (smallest > f64::EPSILON * largest).then(|| largest / smallest)
}

fn row(choice: &Choice) -> Vec<Cell> {
    let mut row = row![format!("{}{}", choice.name, if choice.used { " *" } else { "" })];
    match &choice.figures {
        CostOrFault::Bad { fault } => row.push(fault.into()),
        CostOrFault::Good(cost) => {
            let known = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
            let condition = |number: Option<f64>| known(number.map(|number| format!("{number:.1}")));
            let operations = cost.operations;
            row.extend(row![
                cost.coordinates,
                cost.loop_equations,
                operations.additions,
                operations.multiplications,
                operations.divisions
            ]);
            row.extend(row![
                operations.square_roots,
                operations.sine_cosine_pairs,
                operations.others,
                format!("{:.1}", cost.nanoseconds)
            ]);
            row.extend(row![condition(cost.condition), condition(cost.mass_condition), cost.method]);
            row.push(known(cost.steps.map(|steps| steps.to_string())).into());
            row.push(known(cost.run_seconds.map(|run| format!("{:.3}", 1e3 * run))).into());
        }
    }
    row
}

impl CoordinateComparison {
    pub fn report(&self) -> Report {
        let mut columns = row!["trees", "coordinates", "loops", "+", "*", "/", "sqrt", "sin,cos", "other", "ns"];
        columns.extend(row!["condition", "cond. of M", "method", "steps", "run [ms]"]);
        let heading = Some(format!("cost of the {}", self.kernel).into());
        let table = Table { heading, ..Table::new(columns, self.choices.iter().map(row)) };
        let used =
            "  * used by the scene; conditions at the start, rows and columns scaled; `-`: singular or not there";
        let run = format!(
            "  method, steps, run: what integrates the experiment at its tolerance, and its {}; series have unknowns of their own (`cotree show`)",
            bench::clock::NAME
        );
        Report { tables: vec![table], notes: row![used, run], ..Report::new(row![]) }
    }
}

/// What the scene costs in other coordinates.
///
/// # Errors
/// Everything that is wrong with the scene; trees that do not work are part of the comparison.
pub fn comparison(scene: &Scene) -> Result<CoordinateComparison, Faults> {
    let resolved = scene.resolve()?;
    Ok(compare(&resolved.mechanism, &resolved.outputs))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cotree_fmu::tape::Instruction;

    #[test]
    fn every_operation_is_counted_once() {
        let instruction = |operation| Instruction { operation, target: 0, a: 0, b: 0, c: 0 };
        let operations = [
            Operation::Add,
            Operation::MultiplyAdd,
            Operation::Divide,
            Operation::SinCos,
            Operation::Tangent,
            Operation::Copy,
        ];
        let tape = Tape::new(operations.map(instruction).into(), vec![]);
        let expected = Operations {
            additions: 2,
            multiplications: 1,
            divisions: 1,
            square_roots: 0,
            sine_cosine_pairs: 1,
            others: 1,
        };
        assert_eq!(count(&tape), expected);
    }

    #[test]
    fn condition_numbers_do_not_depend_on_units() {
        let matrix = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 3.0]);
        let scaled = DMatrix::from_row_slice(2, 2, &[4.0e8, 1.0e2, 1.0e2, 3.0e-4]);
        let (a, b) = (condition(matrix).unwrap(), condition(scaled).unwrap());
        assert!((a - b).abs() < 1e-6 * a, "{a} {b}");
        // [1 r; r 1] with r = 1 / sqrt 12
        let r = 12.0_f64.sqrt().recip();
        assert!((a - (1.0 + r) / (1.0 - r)).abs() < 1e-6 * a, "{a}");
        assert_eq!(condition(DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0])), None);
        assert_eq!(condition(DMatrix::zeros(0, 0)), None);
    }
}
