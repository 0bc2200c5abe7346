//! The measurement as a table for people.

use std::fmt;

use cotree_fmu::instance::Inaccuracy;

use super::runs::TOO_LONG;
use super::{BUSY, Bench, LOOPS, Reference, Run, TOLERANCES};

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
        let energy = if self.energy_kept { "energy" } else { "" };
        let head = ["method", "tolerance", "time [ms]", "error", "steps", "evaluations", "factors", "loops", energy];
        writeln!(f, "\n{}", head.map(|title| format!("{title:>12}")).concat().trim_end())?;
        self.runs.iter().try_for_each(|run| write_run(f, run))?;
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
        None if *method == LOOPS => {
            writeln!(
                f,
                "; drivers and loops determine the motion: nothing is integrated, and there is no other method"
            )?;
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

fn write_run(f: &mut fmt::Formatter<'_>, run: &Run) -> fmt::Result {
    let measured = match &run.result {
        Ok(measured) => measured,
        Err(problem) => {
            let why = if problem == TOO_LONG { "too slow" } else { "no result" };
            return writeln!(f, "{:>12}{:>12.0e}{:>12}", run.method, run.tolerance, why);
        }
    };
    let error = match measured.error {
        0.0 => "<1e-16".to_owned(),
        error => format!("{}{error:.1e}", if measured.resolved { "" } else { "<" }),
    };
    let time = measured.cpu_seconds.map_or_else(|| "-".to_owned(), |seconds| format!("{:.3}", 1e3 * seconds));
    write!(
        f,
        "{:>12}{:>12.0e}{time:>12}{error:>12}{:>12}{:>12}{:>12}{:>12}",
        run.method,
        run.tolerance,
        measured.steps,
        measured.evaluations,
        measured.factorisations,
        power(measured.constraint_residual)
    )?;
    match measured.energy_drift {
        Some(drift) => writeln!(f, "{:>12}", power(drift)),
        None => writeln!(f),
    }
}
