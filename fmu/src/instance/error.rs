//! Why an instance refuses, in the user's names.

use thiserror::Error;

use super::crossing::Crossing;
use crate::failure::{Failure, LoopGap, number};
use crate::program::Program;
use crate::program::seal::FrameError;

/// Why an instance refuses.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum InstanceError {
    /// No variable has that index.
    #[error("there is no variable with value reference {index}")]
    UnknownVariable {
        /// The index.
        index: usize,
    },
    /// The variable is calculated.
    #[error("`{name}` is calculated: only parameters, inputs and initial values can be set")]
    Calculated {
        /// The variable.
        name: String,
    },
    /// A fixed parameter or an initial value after initialisation.
    #[error("`{name}` can only be set before the simulation starts")]
    Fixed {
        /// The parameter.
        name: String,
    },
    /// Derivatives are for inputs, of order 1 and 2.
    #[error("derivative {order} of `{name}` cannot be set: only derivatives 1 and 2 of inputs can")]
    Derivative {
        /// The variable.
        name: String,
        /// The order asked for.
        order: i32,
    },
    /// Derivatives are with respect to what can change by itself.
    #[error("there is no derivative with respect to `{name}`: it is neither an input nor a parameter nor a state")]
    NotIndependent {
        /// The variable.
        name: String,
    },
    /// Only what is calculated has a derivative.
    #[error("`{name}` is not calculated: it has no derivative")]
    NotCalculated {
        /// The variable.
        name: String,
    },
    /// The derivative is not a number.
    #[error("at t = {time} s `{name}` has no finite derivative")]
    NoDerivative {
        /// The variable.
        name: String,
        /// When [s].
        time: f64,
    },
    /// Model Exchange knows no rates of inputs.
    #[error(
        "no Model Exchange: a driver follows an input whose rate the importer does not provide, or integrates an input; use Co-Simulation"
    )]
    NoExchange,
    /// Where profiles are touched is searched for in each step of the method.
    #[error(
        "no Model Exchange: `{name}` touches a profile, and where it does is searched for within the solver's own steps; use Co-Simulation"
    )]
    AtProfile {
        /// The contact.
        name: String,
    },
    /// An array of the wrong length.
    #[error("an array of {found} values instead of {expected}")]
    Count {
        /// Length found.
        found: usize,
        /// Length expected.
        expected: usize,
    },
    /// NaN or infinite.
    #[error("`{name}` cannot be set to {value}: it must be a finite number")]
    NotANumber {
        /// The variable.
        name: String,
        /// The value.
        value: f64,
    },
    /// Outside the bounds of the scene.
    #[error("`{name}` cannot be set to {}: {}", number(*.value), bounds(*.min, *.max))]
    OutOfRange {
        /// The variable.
        name: String,
        /// The value.
        value: f64,
        /// Smallest permitted value.
        min: Option<f64>,
        /// Largest permitted value.
        max: Option<f64>,
    },
    /// The value of an output is not a number.
    #[error("at t = {time} s `{name}` has no finite value")]
    Undefined {
        /// The variable.
        name: String,
        /// When [s].
        time: f64,
    },
    /// Impossible start, stop or tolerance.
    #[error("the experiment is impossible: {reason}")]
    Experiment {
        /// What is wrong.
        reason: &'static str,
    },
    /// A step that does not go forward to a finite time.
    #[error("a step from t = {} s to {} s is impossible", number(*.from), number(*.to))]
    Step {
        /// Time now [s].
        from: f64,
        /// Time asked for [s].
        to: f64,
    },
    /// Beyond the stop time.
    #[error("a step to t = {} s goes beyond the stop time {} s", number(*.to), number(*.stop))]
    Stop {
        /// Time asked for [s].
        to: f64,
        /// Stop time [s].
        stop: f64,
    },
    /// Wrong order of calls.
    #[error("the simulation {}", if *.running { "has already been initialised" } else { "has not been initialised" })]
    Phase {
        /// Is it running?
        running: bool,
    },
    /// The loops cannot follow a jump.
    #[error("{}; {cause}; change it in smaller steps, or give its rate as well", jumped(.jumps))]
    Jump {
        /// What has jumped since the last step: name, value before, value now.
        jumps: Vec<(String, f64, f64)>,
        /// What happens then.
        cause: Failure,
    },
    /// There is no start with what was set.
    #[error("with {} the mechanism cannot start: {cause}", instead(.set))]
    Start {
        /// What is not as in the scene: name, default, value now.
        set: Vec<(String, f64, f64)>,
        /// Why not.
        cause: Failure,
    },
    /// Branches of the motion cross, and the importer integrates.
    #[error("at t = {:.6} s the mechanism is in a singular configuration, where the loops at {} lose a constraint, and an external integrator does not know the branch; use Co-Simulation", .0.time, list(&.0.joints))]
    Crossing(Crossing),
    /// The importer's steps have taken the loops too far apart.
    #[error(
        "at t = {time} s the loops have drifted too far apart to be closed again, first at `{}`: the steps of the importer's solver are too long for this motion; use shorter steps, a solver with step size control and a smaller tolerance, or Co-Simulation; if that fails there too, the mechanism locks", gap.owner
    )]
    Apart {
        /// When [s].
        time: f64,
        /// What is left open.
        gap: LoopGap,
    },
    /// Ticks that cannot be told apart.
    #[error("the period of sampler `{sampler}` is {} s: it must be longer than the shortest step", number(*.period))]
    Period {
        /// The sampler.
        sampler: String,
        /// What it is now [s].
        period: f64,
    },
    /// An event has ended the run.
    #[error("event `{event}` has ended the run at t = {time} s")]
    Ended {
        /// The event.
        event: String,
        /// When [s].
        time: f64,
    },
    /// In Model Exchange a tick has been left out.
    #[error(
        "there is a time event (sample time) at t = {time} s, but the importer has advanced to t = {now} s: it must stop at `nextEventTime`"
    )]
    Passed {
        /// When they change [s].
        time: f64,
        /// The time now [s].
        now: f64,
    },
    /// A saved state of something else.
    #[error("this state was saved by another model")]
    ForeignState,
    /// Saved bytes cannot be read.
    #[error("the saved state cannot be read: {0}")]
    Frame(#[from] FrameError),
    /// The solver gives up.
    #[error(transparent)]
    Solver(#[from] Failure),
}

impl InstanceError {
    /// Has a variable no value at this instant, while the motion goes on?
    pub fn is_without_value(&self) -> bool {
        matches!(self, Self::Undefined { .. } | Self::Solver(Failure::Undetermined { .. }))
    }

    /// True if an event of the scene has ended the run, so that nothing is wrong.
    pub fn is_end(&self) -> bool {
        matches!(self, Self::Ended { .. })
    }

    /// True if modes of contacts or friction do not fit each other, or the loops that they close: errors of the method may have decided between them.
    pub(super) fn is_of_modes(&self) -> bool {
        matches!(self, Self::Solver(Failure::Contact { .. } | Failure::SingularAhead { .. }))
    }

    /// Has the computer only done as much as it may in one step, and could go on from there?
    pub fn is_unfinished(&self) -> bool {
        matches!(self, Self::Solver(failure) if failure.is_unfinished())
    }

    /// Is it about numbers that the model has no answer for, and not about the call?
    pub fn is_numerical(&self) -> bool {
        matches!(
            self,
            Self::Solver(_)
                | Self::Undefined { .. }
                | Self::NoDerivative { .. }
                | Self::NotANumber { .. }
                | Self::Jump { .. }
        )
    }
}

fn list(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn jumped(jumps: &[(String, f64, f64)]) -> String {
    let one =
        |(name, from, to): &(String, f64, f64)| format!("`{name}` jumped from {} to {}", number(*from), number(*to));
    jumps.iter().map(one).collect::<Vec<_>>().join(", ")
}

fn instead(set: &[(String, f64, f64)]) -> String {
    const MOST: usize = 5;
    let one = |(name, default, now): &(String, f64, f64)| {
        format!("`{name}` = {} instead of {}", number(*now), number(*default))
    };
    let further = set.len().saturating_sub(MOST);
    let more = (further > 0).then(|| format!("{further} other changes"));
    set.iter().take(MOST).map(one).chain(more).collect::<Vec<_>>().join(", ")
}

fn bounds(min: Option<f64>, max: Option<f64>) -> String {
    match (min, max) {
        (Some(min), Some(max)) => format!("it must lie between {} and {}", number(min), number(max)),
        (Some(min), None) => format!("it must be at least {}", number(min)),
        (None, Some(max)) => format!("it must be at most {}", number(max)),
        (None, None) => "it has no bounds".to_owned(),
    }
}

impl InstanceError {
    /// Why nobody else can integrate a program.
    pub(crate) fn no_exchange(program: &Program) -> Self {
        match program.instants.contours().first() {
            Some(contour) => InstanceError::AtProfile { name: contour.name.clone() },
            None => InstanceError::NoExchange,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_few_changes_are_named() {
        let set: Vec<_> = (0..8).map(|index| (format!("p{index}"), 1.0, 0.5)).collect();
        assert_eq!(instead(&set[..2]), "`p0` = 0.5 instead of 1, `p1` = 0.5 instead of 1");
        assert!(instead(&set).ends_with("`p4` = 0.5 instead of 1, 3 other changes"));
    }
}
