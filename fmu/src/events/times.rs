//! Switches that follow from time alone.
//!
//! A load that is turned off at 20 ms jumps at an instant that no motion changes: like a sample time it is known beforehand, to the last bit. A Runge-Kutta step ends at the last floating-point time
//! before it, and the next one begins at the first time after it, so that no stage of either sees the other side. At tolerances alone the steps would find it to a share of themselves.

use super::course::PLACES;
use super::switch::Side;
use crate::integrator::control::{EARLY, shortest};
use crate::machine::Machine;
use crate::model::{Model, State};
use crate::program::{Layout, Program, Steep};

/// So many sides fit into one word.
const WORD: usize = 64;

/// The switching functions that no coordinate, rate, acceleration or reaction moves: their places among the results of the laws.
pub(crate) fn of_time(program: &Program, layout: &Layout) -> Vec<usize> {
    let laws = &program.tapes.laws;
    let mut moves = vec![false; program.registers as usize];
    let solved = layout.positions()..layout.constants();
    moves.iter_mut().take(solved.end).skip(solved.start).for_each(|register| *register = true);
    for instruction in laws.tape.instructions() {
        // A program that is being checked may name registers that there are not.
        let moved = instruction.operands().any(|own| moves.get(own as usize).is_none_or(|moves| *moves));
        for target in instruction.targets() {
            moves.get_mut(target as usize).into_iter().for_each(|register| *register = moved);
        }
    }
    let results = laws.kinds.iter().zip(&laws.tape.results).enumerate();
    let follows = |(_, (kind, result)): &(usize, (&Steep, &u32))| {
        **kind == Steep::Switching && moves.get(**result as usize).is_some_and(|moves| !moves)
    };
    results.filter(follows).map(|(index, _)| index).collect()
}

/// The first switch in time after the beginning of a span: the last time before it and the first one after it, as near to each other as times are.
pub(crate) fn next(model: &Model, machine: &mut Machine, origin: &State, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
    let words = model.time_switches().chunks(WORD);
    let found = words.filter_map(|word| first(model, machine, origin, [from, to], word));
    found.min_by(|one, other| one[1].total_cmp(&other[1]))
}

/// The same of as many functions as fit into one word.
fn first(
    model: &Model,
    machine: &mut Machine,
    origin: &State,
    [from, to]: [f64; 2],
    word: &[usize],
) -> Option<[f64; 2]> {
    let mut sides = |time: f64| sides(model, machine, origin, time, word);
    let (mut before, begin) = (from, sides(from));
    for place in PLACES.into_iter().skip(1) {
        let mut behind = if place < 1.0 { from + place * (to - from) } else { to };
        if sides(behind) == begin {
            before = behind;
            continue;
        }
        let spacing = f64::EPSILON * behind.abs().max(EARLY);
        while behind - before > spacing {
            let middle = before + 0.5 * (behind - before);
            if middle <= before || middle >= behind {
                break;
            }
            *(if sides(middle) == begin { &mut before } else { &mut behind }) = middle;
        }
        return Some([before, behind]);
    }
    None
}

/// The time at which the pieces hold that follow an instant: a little later, if something switches there.
pub(crate) fn after(model: &Model, machine: &mut Machine, state: &State) -> f64 {
    let time = state.time();
    let near = [time - shortest(time), time + shortest(time)];
    let mut words = model.time_switches().chunks(WORD);
    let switches = words.any(|word| {
        let [before, behind] = near.map(|time| sides(model, machine, state, time, word));
        before != behind
    });
    if switches { near[1] } else { time }
}

/// The sides of some functions at a time: which are above, and which are zero.
fn sides(model: &Model, machine: &mut Machine, origin: &State, time: f64, word: &[usize]) -> [u64; 2] {
    let tape = &model.program().tapes.laws.tape;
    machine.load_signals(model, origin, time);
    machine.run(tape);
    let mut found = [0; 2];
    for (bit, &law) in word.iter().enumerate() {
        match Side::of(machine.result(tape, law)) {
            Side::Above => found[0] |= 1 << bit,
            Side::Equal => found[1] |= 1 << bit,
            Side::Below => {}
        }
    }
    found
}
