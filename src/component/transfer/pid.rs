//! Controller with a proportional, an integral and a filtered derivative part, continuous or sampled.
//!
//! Where it is at a limit its integral gives way at the rate (limited - wanted)/tracking (Åström, Hägglund, Advanced PID Control, 2006, section 3.5); the sampled one is the
//! recurrence of Åström, Wittenmark, Computer-Controlled Systems, 1997, section 8.5, with the derivative by backward differences.

use super::{Flaw, Inner, Like, Transfer, TransferKeys, TransferParts, gain};
use crate::expr::Unary;
use crate::model::measure::{ANYTHING, TIME};
use crate::model::{Formula, Range};
use crate::scene::key::{Form, Key};

pub(crate) const PID: Transfer = Transfer {
    name: "pid",
    about: "a PID controller, with saturation and anti-windup",
    equations: "u = sat(w), w = proportional error + z + derivative (error - x)/filter, sat: within min and max; z' = integral error + (u - w)/tracking; filter x' = error - x",
    hears: Key::required(
        "error",
        Form::Law(ANYTHING),
        "the control error: setpoint minus actual value",
        "give the control error: `error = \"wanted - BODY.angle\"`",
    ),
    keys: &[
        gain("proportional", "proportional gain: output per error"),
        gain("integral", "integral gain: output per error and time"),
        gain("derivative", "derivative gain: output per rate of the error"),
        Key::default(
            "filter",
            Form::Constant(TIME, Range::Positive),
            "time constant of the filter of the derivative part",
            "required with `derivative`, unless the controller is sampled",
        ),
        gain("min", "lower limit of the output (saturation)"),
        gain("max", "upper limit of the output (saturation)"),
        Key::default(
            "tracking",
            Form::Constant(TIME, Range::Positive),
            "anti-windup: the tracking time constant of the integral part at a limit; if sampled, at least the period",
            "`proportional/integral`",
        ),
        Key::default("start", Form::Constant(ANYTHING, Range::Any), "the integral part at the start", "0"),
        Key::default(
            "before",
            Form::Constant(ANYTHING, Range::Any),
            "the error before the start, for the first derivative",
            "0",
        ),
        Key::default(
            "period",
            Form::Constant(TIME, Range::Positive),
            "the sample time, if it is sampled: its output changes at sample times only",
            "it is continuous",
        ),
        Key::default("offset", Form::Constant(TIME, Range::Any), "the time of the first sample, if it is sampled", "0"),
    ],
    terms: &[
        ("proportional", Like::Gain(0)),
        ("integral", Like::Gain(1)),
        ("derivative", Like::Gain(-1)),
        ("min", Like::Given),
        ("max", Like::Given),
        ("start", Like::Given),
        ("before", Like::Heard),
    ],
    sampled_by: Some("period"),
    made,
};

/// What its integral needs at a limit, as messages call it: without a proportional part nothing says how fast it gives way.
const DEFAULT_TRACKING: &str =
    "`tracking` (`proportional/integral` unless it is given, such as `tracking = \"0.1 s\"`)";

fn made(given: &TransferKeys<'_>) -> Result<TransferParts, Flaw> {
    let there = |key: &str| given.value(key).is_some();
    if !["proportional", "integral", "derivative"].into_iter().any(there) {
        let help = "give one of the gains `proportional`, `integral` and `derivative`";
        return Err(Flaw::new("error", "has no gain: its output would be zero", help));
    }
    let limited = there("min") || there("max");
    let winds_up = limited && there("integral");
    if winds_up && !there("tracking") && !there("proportional") {
        let help = "give the anti-windup time constant: `tracking = \"0.1 s\"`";
        return Err(Flaw::new(
            "integral",
            "has limits and an integral, but neither `tracking` nor `proportional`",
            help,
        ));
    }
    let mut made = match given.value("period") {
        Some(period) => sampled(given, &period, winds_up),
        None => continuous(given, winds_up)?,
    };
    if winds_up && !there("tracking") {
        made.positive.push((DEFAULT_TRACKING, "proportional", tracking(given)));
    }
    if let (Some(least), Some(most)) = (given.value("min"), given.value("max")) {
        made.size = Some(least.clone().of(Unary::Abs).larger(most.clone().of(Unary::Abs)));
        made.positive.push(("`max - min`", "max", most - least));
    }
    Ok(made)
}

fn continuous(given: &TransferKeys<'_>, winds_up: bool) -> Result<TransferParts, Flaw> {
    if given.value("offset").is_some() {
        let help = "give `period`, the sample time, or remove it";
        return Err(Flaw::new("offset", "has `offset`, but is not sampled", help));
    }
    let mut states = Vec::new();
    let mut wanted = proportional(given);
    if given.value("integral").is_some() {
        wanted = wanted + given.state(0);
        states.push(Inner::new("integral", "integral part of", given.value_or("start", 0.0), Formula::Number(0.0)));
    }
    if let Some(derivative) = given.value("derivative") {
        let Some(filter) = given.value("filter") else {
            let help = "give the time constant of its filter, short compared with the motion: `filter = \"5 ms\"`";
            return Err(Flaw::new("derivative", "has a derivative, but no `filter`", help));
        };
        let slow = given.state(states.len());
        let slope = (given.heard.clone() - slow) / filter;
        wanted = wanted + derivative * slope.clone();
        let before = given.value_or("before", 0.0);
        states.push(Inner { unit: Like::Heard, ..Inner::new("error", "filtered error of", before, slope) });
    }
    let output = within(given, wanted.clone());
    if let Some(integral) = given.value("integral") {
        let grows = integral * given.heard.clone();
        let gives_way = (output.clone() - wanted) / tracking(given);
        states[0].next = if winds_up { grows + gives_way } else { grows };
    }
    Ok(TransferParts::of_states(output, states))
}

fn sampled(given: &TransferKeys<'_>, period: &Formula, winds_up: bool) -> TransferParts {
    let zero = || Formula::Number(0.0);
    let mut sampled = vec![Inner::new("output", "its output:", zero(), zero())];
    let mut wanted = proportional(given);
    if let Some(integral) = given.value("integral") {
        let integral_value = given.sampled(1);
        wanted = wanted + integral_value.clone();
        let next = integral_value + integral * period.clone() * given.heard.clone();
        sampled.push(Inner::new("integral", "integral part of", given.value_or("start", 0.0), next));
    }
    if let Some(derivative) = given.value("derivative") {
        let place = sampled.len();
        let (slope, last) = (given.sampled(place), given.sampled(place + 1));
        let filter = given.value_or("filter", 0.0);
        let change = derivative * (given.heard.clone() - last);
        let next = (filter.clone() * slope + change) / (filter + period.clone());
        wanted = wanted + next.clone();
        let before = given.value_or("before", 0.0);
        sampled.push(Inner::new("derivative", "derivative part of", zero(), next));
        let error = Inner::new("error", "error at the last sample of", before, given.heard.clone());
        sampled.push(Inner { unit: Like::Heard, ..error });
    }
    let output = within(given, wanted.clone());
    if winds_up {
        let share = period.clone() / tracking(given).larger(period.clone());
        sampled[1].next = sampled[1].next.clone() + share * (output.clone() - wanted);
    }
    sampled[0].next = output;
    sampled[0].start = within(given, given.value_or("start", 0.0));
    let ticks = Some([period.clone(), given.value_or("offset", 0.0)]);
    TransferParts { sampled, ticks, ..TransferParts::of_states(given.sampled(0), Vec::new()) }
}

fn proportional(given: &TransferKeys<'_>) -> Formula {
    given.value("proportional").map_or(Formula::Number(0.0), |gain| gain * given.heard.clone())
}

/// The time constant with which the integral gives way at a limit.
fn tracking(given: &TransferKeys<'_>) -> Formula {
    given.value("tracking").unwrap_or_else(|| given.value_or("proportional", 0.0) / given.value_or("integral", 0.0))
}

fn within(given: &TransferKeys<'_>, wanted: Formula) -> Formula {
    let below = given.value("max").map_or(wanted.clone(), |most| wanted.smaller(most));
    given.value("min").map_or(below.clone(), |least| below.larger(least))
}
