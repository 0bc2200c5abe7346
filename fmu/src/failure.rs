//! Why there is no solution, in the user's names.

use std::fmt;

use thiserror::Error;

use crate::program::domain::{Domain, Limit};

/// A loop equation that does not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// The joint or driver.
    pub owner: String,
    /// How much is missing [m or rad].
    pub size: f64,
    /// An angle [rad]? Otherwise a length [m].
    pub angular: bool,
}

impl fmt::Display for Gap {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (size, unit) = if self.angular { (self.size, "rad") } else { (1e3 * self.size, "mm") };
        write!(formatter, "{size:.3e} {unit} at `{}`", self.owner)
    }
}

/// A law that has no value.
#[derive(Clone, Debug, PartialEq)]
pub struct Outside {
    /// The argument and its limit.
    pub domain: Domain,
    /// The value that is outside.
    pub value: f64,
}

impl Outside {
    fn help(&self) -> &'static str {
        match self.domain.limit {
            Limit::Distance => "keep the points apart, for example by placing one of them a little aside",
            _ => "keep it where it has one, for example by `max`, `min` or `if`, or end the run before",
        }
    }
}

impl fmt::Display for Outside {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { domain: Domain { place, argument, limit }, value } = self;
        let value = number(*value);
        match limit {
            Limit::Divisor => write!(f, "`{place}` divides by `{argument}`, which is {value} there"),
            Limit::Root => write!(f, "`{place}` takes the square root of `{argument}`, which is {value} there"),
            Limit::Logarithm => write!(f, "`{place}` takes the logarithm of `{argument}`, which is {value} there"),
            Limit::ArcSine => {
                write!(f, "`{place}` takes the arc sine or cosine of `{argument}`, which is {value} there")
            }
            Limit::Base => {
                write!(f, "`{place}` raises `{argument}`, which is {value} there, to a power that is no whole number")
            }
            Limit::Distance => write!(f, "`{place}` acts along the line between {argument}, which meet there"),
            Limit::Value => write!(f, "`{place}` is `{argument}`, which is {value} there"),
            Limit::NotNegative => write!(f, "{place} must not be negative, but `{argument}` is {value}"),
            Limit::Positive => write!(f, "{place} must be positive, but `{argument}` is {value}"),
            Limit::Share => write!(f, "{place} must be from 0 to 1, but `{argument}` is {value}"),
            Limit::NotZero => write!(f, "{place} must not be zero, but `{argument}` is {value}"),
            Limit::AtLeast(least) => {
                write!(f, "{place} must be at least {}, but `{argument}` is {value}", number(*least))
            }
            Limit::AtMost(most) => {
                write!(f, "{place} must be at most {}, but `{argument}` is {value}", number(*most))
            }
        }
    }
}

/// Why the solver cannot go on.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Failure {
    /// No assembly exists, or none was found.
    #[error(
        "the loops cannot be closed: the largest gap is {gap}; check the lengths, or give a better guess of the initial pose"
    )]
    LoopsOpen {
        /// The largest gap.
        gap: Gap,
    },
    /// No assembly was found with a relation that the joints imply only with the parameters of the export.
    #[error(
        "the loops cannot be closed while `{relation}` stays what the joints imply with the parameters of the export: the largest gap is {gap}; with the parameters that were set they may not imply it: write them into the scene and export it again"
    )]
    NotImplied {
        /// What is implied, such as `beam.angle`.
        relation: String,
        /// The largest gap.
        gap: Gap,
    },
    /// The loops close, but not with these values.
    #[error("the initial {} contradict each other{}: {}; give fewer, or make one a guess", if *.velocity { "velocities" } else { "positions" }, if *.loops { " or the loops" } else { "" }, list(.conditions))]
    Contradiction {
        /// Names of the conditions concerned.
        conditions: Vec<String>,
        /// Velocities? Otherwise positions.
        velocity: bool,
        /// Are there loops?
        loops: bool,
    },
    /// The loops cannot be followed from the pose for other values.
    #[error("the loops do not stay closed on the way from the values before to these")]
    WayEnds,
    /// The loops close on another branch than the guess.
    #[error("the loops close, but on another branch than the guess: `{condition}` was guessed {} and becomes {}; give a closer guess", value(*.guess, *.angular), value(*.found, *.angular))]
    OtherBranch {
        /// The guessed variable.
        condition: String,
        /// The guess.
        guess: f64,
        /// What it became.
        found: f64,
        /// An angle?
        angular: bool,
    },
    /// Redundant joints or drivers do not agree with the others.
    #[error("at t = {time} s `{}` repeats what other joints prescribe, but contradicts them by {gap}: the lengths do not repeat each other exactly, or the equations that are imposed have passed a pose in which they depend on each other; change the joint, or remove it", gap.owner)]
    Redundant {
        /// When [s].
        time: f64,
        /// The contradiction.
        gap: Gap,
    },
    /// What is held on one side only cannot be opened or closed so that everything fits.
    #[error("at t = {time} s {}: {why}", list(.names))]
    Contact {
        /// When [s].
        time: f64,
        /// Names of the contacts concerned.
        names: Vec<String>,
        /// What does not fit.
        why: &'static str,
    },
    /// The mechanism is where something keeps it from being: at the start, or after a limit was moved.
    #[error("at t = {time} s the mechanism is beyond `{name}` by {}: begin within it, and move it only where nothing is in the way", value(*.by, *.angular))]
    Beyond {
        /// What holds there.
        name: String,
        /// When [s].
        time: f64,
        /// By how much.
        by: f64,
        /// An angle?
        angular: bool,
    },
    /// Numbers left the range of numbers.
    #[error(
        "at t = {time} s the accelerations are not finite, first that of `{coordinate}`; look for a body there that can move without mass or inertia, and for the law of a load or a driver that divides by zero, itself or its derivatives, grows beyond all numbers, or reads accelerations or reactions and has no solution"
    )]
    NotFinite {
        /// When [s].
        time: f64,
        /// The first coordinate concerned.
        coordinate: String,
    },
    /// A law has no value.
    #[error("at t = {time} s a law has no value: {law}; {}", law.help())]
    NoValue {
        /// When [s].
        time: f64,
        /// The law, and what is wrong with it.
        law: Box<Outside>,
    },
    /// A key has a value that it must not have, with the present parameters.
    #[error("{law}")]
    OutOfRange {
        /// The key, and its value.
        law: Box<Outside>,
    },
    /// A law grows faster than any motion can be followed.
    #[error(
        "at t = {time} s the motion cannot be followed any further, because a law grows beyond all bounds: {law}; keep it smaller, for example by `min`, or end the run before"
    )]
    Boundless {
        /// When [s].
        time: f64,
        /// The law, and its value.
        law: Box<Outside>,
    },
    /// The step became too small to go on.
    #[error("at t = {time} s the motion cannot be followed any further: even the shortest steps miss the tolerance, and `{coordinate}` changes fastest{}", because(.cause))]
    StepUnderflow {
        /// When [s].
        time: f64,
        /// The coordinate that moves most.
        coordinate: String,
        /// Why the last step was rejected, if not for its error.
        cause: Option<Box<Failure>>,
    },
    /// So many steps that it looks like for ever.
    #[error(
        "at t = {time} s the steps have become so short, {pace:.1e} s on average, that it would take more than {most} of them to come to t = {target} s; look for what moves so fast: a very small mass or inertia, a very stiff spring or strong damper, a fast input, or a law that jumps (`sign`, `if`)"
    )]
    TooManySteps {
        /// When [s].
        time: f64,
        /// Mean length of the last steps [s].
        pace: f64,
        /// The next communication point [s].
        target: f64,
        /// More steps than this are too many.
        most: u64,
    },
    /// The computer has taken as long as it may.
    #[error(
        "at t = {time} s the {budget} s that the computer may take for one communication step are over (`time_budget` in the scene's `[solver]`); give more, take shorter communication steps, or ask for a larger tolerance"
    )]
    OutOfTime {
        /// When, in the motion [s].
        time: f64,
        /// How long it may take [s].
        budget: f64,
    },
    /// Whoever waits for the motion wants it to end.
    #[error("at t = {time} s the motion was interrupted; it could go on from there")]
    Interrupted {
        /// When, in the motion [s].
        time: f64,
    },
    /// As much work as a communication step may take.
    #[error(
        "at t = {time} s as much work is done as one communication step may take, and t = {target} s is not reached: so many short steps are much for a mechanism of this size; look for what moves so fast, ask for a larger tolerance, or go on from there in shorter communication steps"
    )]
    TooMuchWork {
        /// When, in the motion [s].
        time: f64,
        /// The communication point that was wanted [s].
        target: f64,
    },
    /// A law in pieces, each of which leads back into the other at once.
    #[error(
        "at t = {time} s a law in pieces (`sign`, `if`, `abs`, `min`, `max`) switches back and forth without end, and `{coordinate}` with it: each side pushes the motion back to the other; use a smooth law, such as `tanh(v/0.01)` for `sign(v)`, or a friction load"
    )]
    SlidingMode {
        /// When [s].
        time: f64,
        /// The coordinate whose acceleration switches most.
        coordinate: String,
    },
    /// Branches of the motion meet, and the rates belong to none of them or to all.
    #[error(
        "at t = {time} s the mechanism is in a singular pose, and its velocities do not say on which branch it goes on: the loop equations of {} depend on each other; give velocities that belong to one branch, or another initial pose", list(.joints)
    )]
    Undecided {
        /// When [s].
        time: f64,
        /// Joints whose loop equations depend on each other.
        joints: Vec<String>,
    },
    /// Branches of the motion meet, and the linear system of accelerations and reactions has no solution, or many.
    #[error(
        "at t = {time} s the mechanism is in a singular pose, where the loop equations of {} depend on each other: they do not determine accelerations and reactions there; leave those out of the outputs, or begin a little aside", list(.joints)
    )]
    Undetermined {
        /// When [s].
        time: f64,
        /// Joints whose loop equations depend on each other.
        joints: Vec<String>,
    },
    /// Redundant joints: the loop equations that are imposed come to depend on each other, in a pose that is not singular.
    #[error(
        "at t = {time} s the loop equations that are imposed of redundant joints come to depend on each other, first those of {}: the mechanism can go on, but only series choose others in every pose, {}, or leave out a joint that repeats others", list(.joints), without_series(*.named)
    )]
    ChoiceDependent {
        /// When [s].
        time: f64,
        /// Joints whose loop equations come to depend on each other.
        joints: Vec<String>,
        /// Has the user named the method?
        named: bool,
    },
    /// Branches of the motion meet ahead, and the method evaluates what does not tell them apart there.
    #[error(
        "at t = {time} s the mechanism comes to a singular pose, where the loop equations of {} depend on each other: only series pass such a pose, {}", list(.joints), without_series(*.named)
    )]
    SingularAhead {
        /// When [s].
        time: f64,
        /// Joints whose loop equations come to depend on each other.
        joints: Vec<String>,
        /// Has the user named the method?
        named: bool,
    },
    /// Branches of the motion meet, and the steps were too short to tell them apart.
    #[error(
        "at t = {time} s the motion has left its branch in a singular pose, where the loop equations of {} depend on each other: the steps were so short there that rounding errors decided; {}; if a stiff spring or damper keeps the steps short, make it less stiff", list(.joints), easier(*.named)
    )]
    BranchLost {
        /// When [s].
        time: f64,
        /// Joints whose loop equations depend on each other there.
        joints: Vec<String>,
        /// Has the user named the method?
        named: bool,
    },
    /// Branches of the motion meet ahead, and no step passes there.
    #[error(
        "at t = {time} s the mechanism comes to a singular pose, where the loop equations of {} depend on each other, and rounding errors leave no step that passes it; ask for a larger tolerance; if a stiff spring or damper keeps the steps short, make it less stiff", list(.joints)
    )]
    NotPassed {
        /// When [s].
        time: f64,
        /// Joints whose loop equations come to depend on each other.
        joints: Vec<String>,
    },
    /// The loops come apart during the motion.
    #[error(
        "at t = {time} s the loops cannot be kept closed: {gap} are missing; ask for a smaller tolerance, or shorter steps (`max_step`)"
    )]
    Drift {
        /// When [s].
        time: f64,
        /// The largest gap.
        gap: Gap,
    },
    /// The motion has come to the end of what the loops permit.
    #[error(
        "at t = {time} s the mechanism locks up: the loops at {} are at the end of their reach, and the motion cannot go on; change the lengths or the drivers", list(.joints)
    )]
    EndOfReach {
        /// When [s].
        time: f64,
        /// Joints whose loop equations have come to depend on each other.
        joints: Vec<String>,
    },
    /// Drivers come to a singular pose and turn back in it.
    #[error(
        "at t = {time} s the drivers turn back in a singular pose, where the loop equations of {} depend on each other: nothing says on which branch the mechanism goes on; let them go through the pose, or turn back before it", list(.joints)
    )]
    DriverTurnsBack {
        /// When [s].
        time: f64,
        /// Joints whose loop equations come to depend on each other.
        joints: Vec<String>,
    },
    /// What drives the mechanism moves in no time.
    #[error("at t = {time} s what drives `{}` jumps by {gap}, and the mechanism cannot follow; make the law continuous, for example a steep ramp", gap.owner)]
    DriverJumps {
        /// When [s].
        time: f64,
        /// By how much.
        gap: Gap,
    },
    /// What drives the mechanism is not a number.
    #[error(
        "at t = {time} s what drives `{owner}` has no finite value or rate; look for a division by zero, a root or logarithm of a negative number, the derivative of a root of zero, or a number too large"
    )]
    DriverUndefined {
        /// When [s].
        time: f64,
        /// The joint or driver that cannot follow.
        owner: String,
    },
    /// A driven mechanism cannot go on.
    #[error("at t = {time} s the mechanism locks up: from here on the loops cannot be closed at `{}`; change the lengths or the drivers", gap.owner)]
    LockUp {
        /// When [s].
        time: f64,
        /// The largest gap.
        gap: Gap,
    },
}

impl Failure {
    /// Has the computer only done as much as it may, and could go on from there?
    pub fn is_unfinished(&self) -> bool {
        matches!(self, Self::TooMuchWork { .. } | Self::OutOfTime { .. } | Self::Interrupted { .. })
    }
}

fn list(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// What makes a singular pose easier to pass.
/// Why there is no series, and what helps.
fn without_series(named: bool) -> &'static str {
    if named {
        "and the method is named; leave the choice of the method to the program"
    } else {
        "and there is none along this motion: where the scene has none at all, `cotree show` says why; change the lengths, or the law that has none"
    }
}

fn easier(named: bool) -> &'static str {
    if named {
        "leave the choice of the method to the program, or ask for a larger tolerance"
    } else {
        "ask for a larger tolerance"
    }
}

fn value(value: f64, angular: bool) -> String {
    if angular { format!("{value:.4} rad ({:.2} deg)", value.to_degrees()) } else { format!("{value:.6} m") }
}

fn because(cause: &Option<Box<Failure>>) -> String {
    cause.as_ref().map_or_else(String::new, |cause| format!(": {cause}"))
}

/// A number that reads back the same, and is not hundreds of digits long.
pub(crate) fn number(value: f64) -> String {
    let plain = value == 0.0 || !value.is_finite() || (1e-5..1e15).contains(&value.abs());
    if plain { value.to_string() } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let found = [0.0, -0.25, 1e300, 1e-300, 5e5, f64::INFINITY].map(number);
        assert_eq!(found, ["0", "-0.25", "1e300", "1e-300", "500000", "inf"]);
    }
}
