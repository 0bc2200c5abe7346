//! The measurement as a table for people.

use cotree::report::data::{Cell, Report, Table};
use cotree::row;
use cotree_fmu::instance::Inaccuracy;

use super::{BUSY, Bench, BenchError, BenchRun, Reference, TOLERANCES};

impl Bench {
    pub fn report(&self) -> Report {
        let mut columns = row!["method", "tolerance", "time [ms]", "error", "steps", "evaluations", "factors", "loops"];
        columns.extend(self.energy_kept.then(|| "energy".into()));
        let table = Table { left: 0, ..Table::new(columns, self.runs.iter().map(row)) };
        let mut notes = problems(&self.runs);
        notes.extend(row![
            "\nError: largest of any output at any of the times, relative to its largest value; < where it may be the reference's own.",
            format!("Loops: largest residual of the loop equations. Time: {}, the fastest of several runs on one thread.", self.clock),
        ]);
        Report { tables: vec![table], notes, ..Report::new(self.title()) }
    }

    fn title(&self) -> Vec<Cell> {
        let [start, stop] = self.span;
        let mut lines = row![format!("{} from {start} s to {stop} s, compared at {} times", self.name, self.points)];
        lines.extend(reference(&self.reference));
        if self.share < BUSY {
            let share = 100.0 * self.share;
            lines.extend(row![format!(
                "warning: the machine is busy (this program had {share:.0} % of a processor): times may be too long"
            )]);
        }
        if self.attainable > TOLERANCES[TOLERANCES.len() - 1] {
            let attainable = self.attainable;
            let warning = format!(
                "warning: rounding errors leave a relative accuracy of about {attainable:.0e}, at smaller tolerances too"
            );
            lines.extend(row![warning, Inaccuracy::ROUNDING]);
        }
        lines
    }
}

fn reference(reference: &Reference) -> Vec<Cell> {
    let Reference { method, tolerance, error, other, confirmed } = reference;
    let known = format!("reference: {method} at {tolerance:.0e}, error {}", about(*error));
    let Some(other) = other else { return row![format!("{known}; NOT CONFIRMED: no other method finished in time")] };
    let verdict = if *confirmed { "confirmed" } else { "NOT CONFIRMED" };
    let distance = about(other.distance);
    let verdict =
        format!("{known}; {verdict}: {} at {:.0e} differs from it by {distance}", other.method, other.tolerance);
    let apart = "The methods give different motions: compare times only, not errors.";
    if *confirmed { row![verdict] } else { row![verdict, apart] }
}

fn power(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.0e}") }
}

fn about(error: f64) -> String {
    if error == 0.0 { "below rounding".to_owned() } else { format!("about {error:.0e}") }
}

/// Why methods have no result: the first reason of each.
fn problems(runs: &[BenchRun]) -> Vec<Cell> {
    let mut told = Vec::new();
    let first = runs.iter().filter_map(|run| {
        let problem = run
            .result
            .as_ref()
            .err()
            .filter(|problem| **problem != BenchError::TooLong && !told.contains(&run.method))?;
        told.push(run.method);
        Some(format!("\n{} at {:.0e}: {problem}", run.method, run.tolerance).into())
    });
    first.collect()
}

fn row(run: &BenchRun) -> Vec<Cell> {
    let mut row = row![run.method, format!("{:.0e}", run.tolerance)];
    match &run.result {
        Err(problem) => row.extend(row![if *problem == BenchError::TooLong { "too slow" } else { "no result" }]),
        Ok(converged) => {
            let error = match converged.error {
                0.0 => "<1e-16".to_owned(),
                error => format!("{}{error:.1e}", if converged.resolved { "" } else { "<" }),
            };
            let time = converged.cpu_seconds.map_or_else(|| "-".to_owned(), |seconds| format!("{:.3}", 1e3 * seconds));
            let residual = power(converged.constraint_residual);
            row.extend(row![time, error, converged.steps, converged.evaluations, converged.factorisations, residual]);
            row.extend(converged.energy_drift.map(|drift| power(drift).into()));
        }
    }
    row
}
