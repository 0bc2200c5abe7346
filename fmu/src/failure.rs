//! Why there is no solution, in the user's names.

use std::fmt;

use thiserror::Error;

use crate::program::domain::{Domain, Limit};

/// A loop equation that does not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopGap {
    /// The joint or driver.
    pub owner: String,
    /// How much is missing [m or rad].
    pub size: f64,
    /// An angle [rad]? Otherwise a length [m].
    pub angular: bool,
}

impl fmt::Display for LoopGap {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.size.is_finite() {
            return write!(formatter, "undetermined at `{}`", self.owner);
        }
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
            Limit::Distance => "keep the points apart, for example by moving one of them slightly aside",
            _ => "keep the argument in its domain, for example by `max`, `min` or `if`, or stop the run before",
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
                write!(f, "`{place}` raises `{argument}`, which is {value} there, to a power that is not an integer")
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
        "the loops cannot be closed: the largest gap is {gap}; check the lengths, or give a better guess of the initial configuration"
    )]
    LoopsOpen {
        /// The largest gap.
        gap: LoopGap,
    },
    /// No assembly was found with a relation that the joints imply only with the parameters of the export.
    #[error(
        "the loops cannot be closed with a constant `{relation}`, which the joints imply for the parameters of the export: the largest gap is {gap}; write the new parameters into the scene and export it again"
    )]
    NotImplied {
        /// What is implied, such as `beam.angle`.
        relation: String,
        /// The largest gap.
        gap: LoopGap,
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
    #[error("the loops do not stay closed while the values change from the previous to these")]
    WayEnds,
    /// The loops close on another branch than the guess.
    #[error("the loops close in another assembly mode than guessed: the guess of `{condition}` is {}, but it becomes {}; give a closer guess", value(*.guess, *.angular), value(*.found, *.angular))]
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
    #[error("at t = {time} s the redundant constraint `{}` contradicts the other joints by {gap}: the lengths do not match exactly, or the mechanism has crossed a configuration in which the imposed loop equations are dependent; correct the lengths, or remove the joint", gap.owner)]
    Redundant {
        /// When [s].
        time: f64,
        /// The contradiction.
        gap: LoopGap,
    },
    /// A joint engages beside the pose that it is to hold.
    #[error(
        "at t = {time} s a joint engages beside its named pose, by {gap}; let the event compare what is off, or let the joint engage where it stands: `at = \"here\"`"
    )]
    Beside {
        /// When [s].
        time: f64,
        /// By how much.
        gap: LoopGap,
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
    #[error("at t = {time} s the mechanism is beyond `{name}` by {}: start within this limit, and do not move the limit into the mechanism", value(*.by, *.angular))]
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
        "at t = {time} s the accelerations are not finite, first that of `{coordinate}`; check for a moving body without mass or inertia, and for a law whose value or derivatives divide by zero, overflow, or read accelerations or reactions and have no solution"
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
        "at t = {time} s the integration fails, because a law is unbounded: {law}; bound it, for example by `min`, or stop the run before"
    )]
    Boundless {
        /// When [s].
        time: f64,
        /// The law, and its value.
        law: Box<Outside>,
    },
    /// The step became too small to go on.
    #[error("at t = {time} s the integration fails: the shortest possible steps miss the tolerance, and `{coordinate}` changes fastest{}", because(.cause))]
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
        "at t = {time} s the step size is {pace:.1e} s on average, so that t = {target} s would take more than {most} steps; check for a very small mass or inertia, a very stiff spring or strong damper, a fast input, or a discontinuous law (`sign`, `if`)"
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
        "at t = {time} s one communication step has used its computing time of {budget} s (`time_budget` in `[solver]`); increase it, use shorter communication steps, or a larger tolerance"
    )]
    OutOfTime {
        /// When, in the motion [s].
        time: f64,
        /// How long it may take [s].
        budget: f64,
    },
    /// Whoever waits for the motion wants it to end.
    #[error("at t = {time} s the run was interrupted; it can continue from there")]
    Interrupted {
        /// When, in the motion [s].
        time: f64,
    },
    /// As much work as a communication step may take.
    #[error(
        "at t = {time} s the limit of steps for one communication step of a mechanism of this size is reached before t = {target} s; check for very fast motions, use a larger tolerance, or shorter communication steps"
    )]
    TooMuchWork {
        /// When, in the motion [s].
        time: f64,
        /// The communication point that was wanted [s].
        target: f64,
    },
    /// A comparison that nothing tells between any two times.
    #[error(
        "at t = {time} s the comparison of the event `{event}` is discontinuous everywhere, so that the time at which it becomes true cannot be found; compare a quantity that changes continuously, or round to fewer digits"
    )]
    EventJumps {
        /// When, in the motion [s].
        time: f64,
        /// The event.
        event: String,
    },
    /// A law in pieces, each of which leads back into the other at once.
    #[error(
        "at t = {time} s a piecewise law (`sign`, `if`, `abs`, `min`, `max`) chatters, and `{coordinate}` with it: each piece drives the motion back to the other; for friction that sticks use `friction` of a joint or a `brake`, otherwise a smooth law, such as `tanh(v/0.01)` for `sign(v)`"
    )]
    SlidingMode {
        /// When [s].
        time: f64,
        /// The coordinate whose acceleration switches most.
        coordinate: String,
    },
    /// Branches of the motion meet, and the rates belong to none of them or to all.
    #[error(
        "at t = {time} s the mechanism is in a singular configuration, where the loop equations of {} are dependent, and its velocities do not determine the branch; give velocities that belong to one branch, or another initial configuration", list(.joints)
    )]
    Undecided {
        /// When [s].
        time: f64,
        /// Joints whose loop equations depend on each other.
        joints: Vec<String>,
    },
    /// Branches of the motion meet, and the linear system of accelerations and reactions has no solution, or many.
    #[error(
        "at t = {time} s the mechanism is in a singular configuration, where the loop equations of {} are dependent and do not determine accelerations and reactions; remove these from the outputs, or start slightly aside", list(.joints)
    )]
    Undetermined {
        /// When [s].
        time: f64,
        /// Joints whose loop equations depend on each other.
        joints: Vec<String>,
    },
    /// Redundant joints: the loop equations that are imposed come to depend on each other, in a pose that is not singular.
    #[error(
        "at t = {time} s the imposed loop equations of redundant joints become dependent, first those of {}; only Taylor series can choose other equations there, {}, or remove a redundant joint", list(.joints), without_series(*.named)
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
        "at t = {time} s the mechanism reaches a singular configuration, where the loop equations of {} are dependent; only Taylor series can cross it, {}", list(.joints), without_series(*.named)
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
        "at t = {time} s the motion has left its branch in a singular configuration, where the loop equations of {} are dependent: the steps were so short that rounding errors decided; {}; if a stiff spring or damper keeps the steps short, make it less stiff", list(.joints), easier(*.named)
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
        "at t = {time} s the mechanism reaches a singular configuration, where the loop equations of {} are dependent, and rounding errors leave no step that crosses it; use a larger tolerance; if a stiff spring or damper keeps the steps short, make it less stiff", list(.joints)
    )]
    NotPassed {
        /// When [s].
        time: f64,
        /// Joints whose loop equations come to depend on each other.
        joints: Vec<String>,
    },
    /// The loops come apart during the motion.
    #[error(
        "at t = {time} s the loops cannot be kept closed: the gap is {gap}; use a smaller tolerance, or shorter steps (`max_step`)"
    )]
    Drift {
        /// When [s].
        time: f64,
        /// The largest gap.
        gap: LoopGap,
    },
    /// The motion has come to the end of what the loops permit.
    #[error(
        "at t = {time} s the mechanism locks: the loops at {} are at a limit position (dead point), and the driven motion cannot continue; change the lengths or the drivers", list(.joints)
    )]
    EndOfReach {
        /// When [s].
        time: f64,
        /// Joints whose loop equations have come to depend on each other.
        joints: Vec<String>,
    },
    /// Drivers come to a singular pose and turn back in it.
    #[error(
        "at t = {time} s the drivers reverse in a singular configuration, where the loop equations of {} are dependent: the branch of the motion after it is not determined; let the drivers go through this configuration, or reverse before it", list(.joints)
    )]
    DriverTurnsBack {
        /// When [s].
        time: f64,
        /// Joints whose loop equations come to depend on each other.
        joints: Vec<String>,
    },
    /// What drives the mechanism moves in no time.
    #[error("at t = {time} s the law of the driver of `{}` jumps by {gap}, and the mechanism cannot follow; make the law continuous, for example a short ramp", gap.owner)]
    DriverJumps {
        /// When [s].
        time: f64,
        /// By how much.
        gap: LoopGap,
    },
    /// What drives the mechanism is not a number.
    #[error(
        "at t = {time} s the law of the driver of `{owner}` has no finite value or rate; check for a division by zero, a root or logarithm of a negative number, the derivative of a root of zero, or a number too large"
    )]
    DriverUndefined {
        /// When [s].
        time: f64,
        /// The joint or driver that cannot follow.
        owner: String,
    },
    /// A driven mechanism cannot go on.
    #[error("at t = {time} s the mechanism locks: from here on the loops cannot be closed at `{}`; change the lengths or the drivers", gap.owner)]
    LockUp {
        /// When [s].
        time: f64,
        /// The largest gap.
        gap: LoopGap,
    },
}

impl Failure {
    /// Has the computer only done as much as it may, and could go on from there?
    pub fn is_unfinished(&self) -> bool {
        matches!(self, Self::TooMuchWork { .. } | Self::OutOfTime { .. } | Self::Interrupted { .. })
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() {
        return "the mechanism".to_owned();
    }
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// What makes a singular pose easier to pass.
/// Why there is no series, and what helps.
fn without_series(named: bool) -> &'static str {
    if named {
        "and the scene names another method; remove `method` from `[solver]`"
    } else {
        "and this motion has none (`cotree show` says why if the whole scene has none); change the lengths, or the law that has none"
    }
}

fn easier(named: bool) -> &'static str {
    if named { "remove `method` from `[solver]`, or use a larger tolerance" } else { "use a larger tolerance" }
}

fn value(value: f64, angular: bool) -> String {
    if angular { format!("{value:.4} rad ({:.2} deg)", value.to_degrees()) } else { format!("{value:.6} m") }
}

fn because(cause: &Option<Box<Failure>>) -> String {
    cause.as_ref().map_or_else(String::new, |cause| format!(": {cause}"))
}

/// A number that reads back the same, and is not hundreds of digits long.
pub(crate) fn number(value: f64) -> String {
    if value.is_nan() {
        return "not a number".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "infinite" } else { "negative and infinite" }.to_owned();
    }
    let plain = value == 0.0 || (1e-5..1e15).contains(&value.abs());
    if plain { value.to_string() } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let found = [0.0, -0.25, 1e300, 1e-300, 5e5, f64::INFINITY, f64::NAN].map(number);
        assert_eq!(found, ["0", "-0.25", "1e300", "1e-300", "500000", "infinite", "not a number"]);
    }

    #[test]
    fn a_gap_without_a_value_and_no_names_are_words() {
        let gap = LoopGap { owner: "table".to_owned(), size: f64::NAN, angular: false };
        assert_eq!(gap.to_string(), "undetermined at `table`");
        let message = Failure::Contact { time: 1.0, names: Vec::new(), why: "it has no mode" }.to_string();
        assert_eq!(message, "at t = 1 s the mechanism: it has no mode");
    }
}
