//! Time events of laws: comparisons that change over at a time which no motion moves.
//!
//! A load that is switched off at 20 ms jumps at a time that is known beforehand to the last bit, as a sample time is. A Runge-Kutta step ends there, and the next one begins there; the stages of the
//! one see the law as it is before the jump, those of the other as it is after it. To find such a jump by the error of a step would take a share of the tolerance of every step.
//!
//! Which comparisons do so: [`crate::program::time_switches`].

use super::control::{EARLY, shortest};
use crate::events::switch::SwitchSign;
use crate::machine::Machine;
use crate::model::{Model, State};

/// If a comparison changes over where a step begins: the first time after that. Two that do so within the shortest step do so together.
pub(crate) fn at_start(model: &Model, machine: &mut Machine, origin: &State, time: f64) -> Option<f64> {
    let span = [time - shortest(time), time + shortest(time)];
    let found = words(model).filter_map(|word| change(model, machine, origin, span, (word, Keeps::Late)));
    found.map(|[_, behind]| behind.max(time)).max_by(f64::total_cmp)
}

/// The first change of a comparison after a step has begun: the last time before it, and the first one at which a side is another one, where the step ends.
pub(crate) fn ahead(model: &Model, machine: &mut Machine, origin: &State, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
    let span = [from + shortest(from), to];
    let found = words(model).filter_map(|word| change(model, machine, origin, span, (word, Keeps::Early)));
    found.min_by(|one, other| one[1].total_cmp(&other[1]))
}

/// So many comparisons at a time that their sides are the bits of a word.
fn words(model: &Model) -> impl Iterator<Item = &[usize]> {
    model.time_switches().chunks(u64::BITS as usize)
}

/// Which sides a search keeps to.
#[derive(Clone, Copy, PartialEq)]
enum Keeps {
    /// Those at the beginning: it comes to the first change.
    Early,
    /// Those at the end: it comes to the last one.
    Late,
}

/// Two neighbouring times between which the sides that are kept to begin or end, if some comparison changes over in a span.
fn change(
    model: &Model,
    machine: &mut Machine,
    origin: &State,
    [mut before, mut behind]: [f64; 2],
    (word, keeps): (&[usize], Keeps),
) -> Option<[f64; 2]> {
    let mut sides = |time: f64| sides(model, machine, origin, time, word);
    // Written so that NaN is no span.
    let is_span = before < behind;
    let ends = is_span.then(|| [sides(before), sides(behind)]).filter(|[begin, end]| begin != end)?;
    let spacing = f64::EPSILON * behind.abs().max(EARLY);
    while behind - before > spacing {
        let middle = before + 0.5 * (behind - before);
        if middle <= before || middle >= behind {
            break;
        }
        let is_before = match keeps {
            Keeps::Early => sides(middle) == ends[0],
            Keeps::Late => sides(middle) != ends[1],
        };
        *(if is_before { &mut before } else { &mut behind }) = middle;
    }
    Some([before, behind])
}

/// The sides of some comparisons at a time: which are above, and which are equal.
fn sides(model: &Model, machine: &mut Machine, origin: &State, time: f64, word: &[usize]) -> [u64; 2] {
    let tape = &model.program().tapes.laws.tape;
    machine.load_signals(model, origin, time);
    machine.run(tape);
    let mut found = [0; 2];
    for (bit, &law) in word.iter().enumerate() {
        match SwitchSign::of(machine.result(tape, law)) {
            SwitchSign::Above => found[0] |= 1 << bit,
            SwitchSign::Equal => found[1] |= 1 << bit,
            SwitchSign::Below => {}
        }
    }
    found
}
