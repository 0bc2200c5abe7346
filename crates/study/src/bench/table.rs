//! The measurement as a table for people.

use std::fmt;

use cotree::cells;
use cotree::columns::aligned;
use cotree_fmu::instance::Inaccuracy;

use super::runs::TOO_LONG;
use super::{BUSY, Bench, Reference, Run, TOLERANCES};

impl fmt::Display for Bench {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [start, stop] = self.span;
        writeln!(f, "{} from {start} s to {stop} s, compared at {} times", self.name, self.points)?;
        write_reference(f, &self.reference)?;
        if self.share < BUSY {
            let share = 100.0 * self.share;
            writeln!(
                f,
                "warning: the machine is busy, this program had {share:.0} % of a processor: times may be too long"
            )?;
        }
        if self.attainable > TOLERANCES[TOLERANCES.len() - 1] {
            let attainable = self.attainable;
            writeln!(
                f,
                "warning: rounding errors leave a relative accuracy of about {attainable:.0e}, at smaller tolerances too"
            )?;
            writeln!(f, "{}", Inaccuracy::ROUNDING)?;
        }
        let mut rows =
            vec![cells!["method", "tolerance", "time [ms]", "error", "steps", "evaluations", "factors", "loops"]];
        rows[0].extend(self.energy_kept.then(|| "energy".to_owned()));
        rows.extend(self.runs.iter().map(row));
        write!(f, "\n{}", aligned(&rows, 0, "  "))?;
        write_problems(f, &self.runs)?;
        writeln!(
            f,
            "\nError: largest of any output at any of the times, relative to its largest value; < where it may be the reference's own."
        )?;
        writeln!(
            f,
            "Loops: largest residual of the loop equations. Time: {}, the fastest of several runs on one thread.",
            self.clock
        )
    }
}

fn write_reference(f: &mut fmt::Formatter<'_>, reference: &Reference) -> fmt::Result {
    let Reference { method, tolerance, error, other, confirmed } = reference;
    write!(f, "reference: {method} at {tolerance:.0e}, error {}", about(*error))?;
    match other {
        Some(other) => {
            let verdict = if *confirmed { "confirmed" } else { "NOT CONFIRMED" };
            let distance = about(other.distance);
            writeln!(f, "; {verdict}: {} at {:.0e} differs from it by {distance}", other.method, other.tolerance)?;
        }
        None => writeln!(f, "; NOT CONFIRMED: no other method ends in time")?,
    }
    if other.is_some() && !confirmed {
        writeln!(f, "The methods end up with different motions: compare times, but not errors.")?;
    }
    Ok(())
}

fn power(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.0e}") }
}

fn about(error: f64) -> String {
    if error == 0.0 { "below rounding".to_owned() } else { format!("about {error:.0e}") }
}

/// Why methods have no result: the first reason of each.
fn write_problems(f: &mut fmt::Formatter<'_>, runs: &[Run]) -> fmt::Result {
    let mut told = Vec::new();
    for run in runs {
        if let Err(problem) = &run.result
            && problem != TOO_LONG
            && !told.contains(&run.method)
        {
            told.push(run.method);
            writeln!(f, "\n{} at {:.0e}: {problem}", run.method, run.tolerance)?;
        }
    }
    Ok(())
}

fn row(run: &Run) -> Vec<String> {
    let mut row = cells![run.method, format!("{:.0e}", run.tolerance)];
    match &run.result {
        Err(problem) => row.extend(cells![if problem == TOO_LONG { "too slow" } else { "no result" }]),
        Ok(own) => {
            let error = match own.error {
                0.0 => "<1e-16".to_owned(),
                error => format!("{}{error:.1e}", if own.resolved { "" } else { "<" }),
            };
            let time = own.cpu_seconds.map_or_else(|| "-".to_owned(), |seconds| format!("{:.3}", 1e3 * seconds));
            let residual = power(own.constraint_residual);
            row.extend(cells![time, error, own.steps, own.evaluations, own.factorisations, residual]);
            row.extend(own.energy_drift.map(power));
        }
    }
    row
}
