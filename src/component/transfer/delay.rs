//! What was heard some time ago, by Padé's approximation.
//!
//! The states are the coefficients of shifted Legendre polynomials by which the last `time` of what was heard is written (Voelker, Eliasmith 2018, Neural
//! Computation 30, Eq. 2.5 and 2.8; Padé's [order - 1/order]). They have the unit and the size of what is heard, whatever the order, and their sum is what was heard at the beginning of
//! that time: so a jump does not pass at once, as it does in the approximation [order/order].

use super::{Flaw, Inner, Like, START, Transfer, TransferKeys, TransferParts};
use crate::model::measure::{ANYTHING, NUMBER, TIME};
use crate::model::{Formula, Range};
use crate::scene::constant;
use crate::scene::key::{Form, Key};

/// The order without `order`: up to frequencies of 1/time its error is 7e-7.
const ORDER: f64 = 4.0;
/// From there on states have coefficients that cost more digits than the order brings.
const MOST: f64 = 10.0;

pub(crate) const DELAY: Transfer = Transfer {
    name: "delay",
    about: "a time delay: its input some time ago",
    equations: "y(t) = input(t - time), by a Padé approximation [order - 1/order]",
    hears: Key::required("input", Form::Law(ANYTHING), "its input: a law", "give its input: `input = \"BODY.angle\"`"),
    keys: &[
        Key::required("time", Form::Constant(TIME, Range::Positive), "the delay", "give the delay: `time = \"20 ms\"`"),
        Key::default(
            "order",
            Form::Constant(NUMBER, Range::Positive),
            "number of states of the approximation, an integer from 1 to 10",
            "4",
        ),
        Key { about: "its input before the start", ..START },
    ],
    terms: &[("input", Like::Given), ("start", Like::Given)],
    sampled_by: None,
    made,
};

fn made(given: &TransferKeys<'_>) -> Result<TransferParts, Flaw> {
    let order = constant::number(&given.value_or("order", ORDER));
    let Some(order) = order.filter(|order| order.fract() == 0.0 && (1.0..=MOST).contains(order)) else {
        let help = "write a number: `order = 4`; docs/machines.md has the accuracy of each order";
        return Err(Flaw::new("order", "has an `order` that is not an integer from 1 to 10", help));
    };
    let order = order as usize;
    let time = given.value_or("time", f64::NAN);
    let states = (0..order).map(|row| {
        let heard = signed(row % 2 == 0, given.heard.clone());
        let part = |column: usize| signed(column <= row && (row - column) % 2 == 1, given.state(column));
        let sum = (0..order).map(part).fold(heard, |sum, index| sum + index);
        let rate = Formula::Number((2 * row + 1) as f64) * sum / time.clone();
        let start = if row == 0 { given.value_or("start", 0.0) } else { Formula::Number(0.0) };
        Inner::new(&format!("legendre_{row}"), "state of the delay", start, rate)
    });
    let output = (1..order).fold(given.state(0), |sum, index| sum + given.state(index));
    Ok(TransferParts::of_states(output, states.collect()))
}

fn signed(positive: bool, formula: Formula) -> Formula {
    if positive { formula } else { constant::negate(formula) }
}
