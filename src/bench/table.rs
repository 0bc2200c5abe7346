//! The measurement as a table for people.

use std::fmt;

use super::runs::TOO_LONG;
use super::{Bench, LOOPS, Run};

impl fmt::Display for Bench {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [start, stop] = self.span;
        let reference = &self.reference;
        writeln!(f, "{} from {start} s to {stop} s", self.name)?;
        write!(f, "reference: {} at {:.0e}, error {}", reference.method, reference.tolerance, about(reference.error))?;
        match &reference.other {
            Some(other) => {
                let verdict = if reference.confirmed { "confirmed" } else { "NOT CONFIRMED" };
                let distance = about(other.distance);
                writeln!(f, "; {verdict}: {} at {:.0e} differs from it by {distance}", other.method, other.tolerance)?;
            }
            None if reference.method == LOOPS => {
                writeln!(
                    f,
                    "; drivers and loops determine the motion: nothing is integrated, and there is no other method"
                )?;
            }
            None => writeln!(f, "; not confirmed: no other method ends in time")?,
        }
        if reference.other.is_some() && !reference.confirmed {
            writeln!(f, "The methods end up with different motions: compare times, but not errors.")?;
        }
        let energy = if self.energy_kept { "energy" } else { "" };
        let head = ["method", "tolerance", "time [ms]", "error", "steps", "evaluations", "factors", "loops", energy];
        writeln!(f, "\n{}", head.map(|title| format!("{title:>12}")).concat().trim_end())?;
        self.runs.iter().try_for_each(|run| write_run(f, run))?;
        write_problems(f, &self.runs)?;
        writeln!(
            f,
            "\nError: largest of any output, relative to its largest value; < where it is not told apart from the reference's;"
        )?;
        writeln!(f, "none where every digit is the reference's.")?;
        writeln!(f, "Loops: largest residual of the loop equations. Time: the fastest of several runs on one thread.")
    }
}

/// A small number by its power of ten.
fn power(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.0e}") }
}

/// An error in words.
fn about(error: f64) -> String {
    if error == 0.0 { "none".to_owned() } else { format!("about {error:.0e}") }
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
        0.0 => "none".to_owned(),
        error => format!("{}{error:.1e}", if measured.resolved { "" } else { "<" }),
    };
    write!(
        f,
        "{:>12}{:>12.0e}{:>12.3}{error:>12}{:>12}{:>12}{:>12}{:>12}",
        run.method,
        run.tolerance,
        1e3 * measured.cpu_seconds,
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
