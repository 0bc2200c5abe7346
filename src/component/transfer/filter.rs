//! Low pass of first or second order.

use super::{Flaw, Inner, Like, START, Transfer, TransferKeys, TransferParts};
use crate::model::measure::{ANGULAR_VELOCITY, ANYTHING, NUMBER, TIME};
use crate::model::{Formula, Range};
use crate::scene::key::{Form, Key};

pub(crate) const FILTER: Transfer = Transfer {
    name: "filter",
    about: "a low-pass filter of its input",
    equations: "time y' = input - y, or y'' = cutoff^2 (input - y) - 2 damping cutoff y'",
    hears: Key::required("input", Form::Law(ANYTHING), "its input: a law", "give its input: `input = \"BODY.omega\"`"),
    keys: &[
        Key::one_of("time", Form::Constant(TIME, Range::Positive), "the time constant of a first-order filter"),
        Key::one_of(
            "cutoff",
            Form::Constant(ANGULAR_VELOCITY, Range::Positive),
            "the cutoff angular frequency of a second-order filter",
        ),
        Key::default(
            "damping",
            Form::Constant(NUMBER, Range::Positive),
            "the damping ratio, with `cutoff`",
            "1/sqrt(2), maximally flat",
        ),
        START,
    ],
    terms: &[("input", Like::Given), ("start", Like::Given)],
    sampled_by: None,
    made,
};

fn made(given: &TransferKeys<'_>) -> Result<TransferParts, Flaw> {
    let (value, start) = (given.state(0), given.value_or("start", 0.0));
    let left = given.heard.clone() - value.clone();
    let of = |rate| Inner::new("value", "its output:", start, rate);
    let Some(cutoff) = given.value("cutoff") else {
        if given.value("damping").is_some() {
            let help = "remove it, or give `cutoff` instead of `time`: a second-order filter";
            return Err(Flaw::new("damping", "has `damping`, but is a first-order filter", help));
        }
        let time = given.value_or("time", f64::NAN);
        return Ok(TransferParts::of_states(value, vec![of(left / time)]));
    };
    let (rate, damping) = (given.state(1), given.value_or("damping", std::f64::consts::FRAC_1_SQRT_2));
    let curve = cutoff.clone() * (cutoff * left - Formula::Number(2.0) * damping * rate.clone());
    let slope = Inner { unit: Like::Rate, ..Inner::new("rate", "rate of", Formula::Number(0.0), curve) };
    Ok(TransferParts::of_states(value, vec![of(rate), slope]))
}
