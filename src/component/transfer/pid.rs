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
    about: "a controller: what makes an error vanish",
    equations: "u = proportional error + z + derivative (error - x)/filter, within min and max; z' = integral error + (u - what is wanted)/tracking; filter x' = error - x",
    hears: Key::required(
        "error",
        Form::Law(ANYTHING),
        "what is to vanish: what is wanted less what is",
        "say what is to vanish: `error = \"wanted - BODY.angle\"`",
    ),
    keys: &[
        gain("proportional", "what it gives by the error"),
        gain("integral", "what it gives by the error and the time"),
        gain("derivative", "what it gives by the rate of the error"),
        Key::default(
            "filter",
            Form::Constant(TIME, Range::Positive),
            "the time constant with which its derivative follows",
            "must be given with `derivative`, unless it is sampled",
        ),
        gain("min", "the least that it gives"),
        gain("max", "the most that it gives"),
        Key::default(
            "tracking",
            Form::Constant(TIME, Range::Positive),
            "the time constant with which its integral gives way at a limit; if it is sampled, the period at least",
            "`proportional/integral`",
        ),
        Key::default("start", Form::Constant(ANYTHING, Range::Any), "its integral part at the start", "0"),
        Key::default(
            "before",
            Form::Constant(ANYTHING, Range::Any),
            "the error before the start: its derivative counts from there",
            "0",
        ),
        Key::default(
            "period",
            Form::Constant(TIME, Range::Positive),
            "from tick to tick, if it is sampled: what it gives changes at ticks only",
            "it is continuous",
        ),
        Key::default("offset", Form::Constant(TIME, Range::Any), "the first tick, if it is sampled", "0"),
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
        let help = "give `proportional`, `integral` or `derivative`, each the gain of its part";
        return Err(Flaw::new("error", "has no gain: it would give nothing", help));
    }
    let limited = there("min") || there("max");
    let winds_up = limited && there("integral");
    if winds_up && !there("tracking") && !there("proportional") {
        let help = "give the time in which its integral gives way at a limit: `tracking = \"0.1 s\"`";
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
        let help = "give `period`, from tick to tick, or remove it";
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
            let help = "give the time constant with which it follows, short beside the motion: `filter = \"5 ms\"`";
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
    let mut sampled = vec![Inner::new("output", "what it gives:", zero(), zero())];
    let mut wanted = proportional(given);
    if let Some(integral) = given.value("integral") {
        let own = given.sampled(1);
        wanted = wanted + own.clone();
        let next = own + integral * period.clone() * given.heard.clone();
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
        let error = Inner::new("error", "error at the last tick of", before, given.heard.clone());
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
