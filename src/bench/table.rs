//! The measurement as a table for people.

use std::fmt;

use super::{Bench, Run};

impl fmt::Display for Bench {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [start, stop] = self.span;
        let reference = &self.reference;
        writeln!(f, "{} from {start} s to {stop} s", self.name)?;
        write!(
            f,
            "reference: {} at {:.0e}, error about {:.0e}",
            reference.method, reference.tolerance, reference.error
        )?;
        match &reference.confirmed {
            Some(other) => {
                writeln!(f, "; {} at {:.0e} differs from it by {:.0e}", other.method, other.tolerance, other.distance)?;
            }
            None => writeln!(f, "; not confirmed: no other method ends in time")?,
        }
        let energy = if self.energy_kept { "energy" } else { "" };
        let head = ["method", "tolerance", "time [ms]", "error", "steps", "evaluations", "factors", "loops", energy];
        writeln!(f, "\n{}", head.map(|title| format!("{title:>12}")).concat().trim_end())?;
        self.runs.iter().try_for_each(|run| write_run(f, run))?;
        writeln!(
            f,
            "\nError: largest of any output, relative to its largest value; < where it is not told apart from the reference's."
        )?;
        writeln!(f, "Loops: largest residual of the loop equations. Time: the fastest of several runs on one thread.")
    }
}

fn write_run(f: &mut fmt::Formatter<'_>, run: &Run) -> fmt::Result {
    let Some(measured) = &run.result else {
        return writeln!(f, "{:>12}{:>12.0e}{:>12}", run.method, run.tolerance, "too slow");
    };
    let error = format!("{}{:.1e}", if measured.resolved { "" } else { "<" }, measured.error);
    write!(
        f,
        "{:>12}{:>12.0e}{:>12.3}{error:>12}{:>12}{:>12}{:>12}{:>12.0e}",
        run.method,
        run.tolerance,
        1e3 * measured.cpu_seconds,
        measured.steps,
        measured.evaluations,
        measured.factorisations,
        measured.constraint_residual
    )?;
    match measured.energy_drift {
        Some(drift) => writeln!(f, "{drift:>12.0e}"),
        None => writeln!(f),
    }
}
