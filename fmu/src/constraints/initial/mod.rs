//! The first consistent state: what is known holds, what is guessed picks the assembly, the loops give the rest.
//!
//! Coordinates that are known themselves are substituted: they keep their bits, however far away they are. Conditions that are linear are fulfilled in one step.
//! Unknown positions are q and the positions of followers; all start from zero, or where the program says. First all conditions are met as well as they can be,
//! loops open; from that guessed pose the loops are closed with the smallest movement. Rates follow from linear equations,
//! the smallest that serve.

mod given;
mod level;
mod positions;
mod rates;
pub(crate) mod tangent;

use crate::failure::Failure;
use crate::linalg::least_squares::Entry;
use crate::machine::Machine;
use crate::model::{Model, State};
use crate::program::{Condition, SparseTape};
use crate::tape::Tape;
use given::Given;
pub(crate) use positions::ASTRAY;
use positions::Positions;
use rates::Rates;

/// What counts as fulfilled, relative to the scales.
pub(crate) const FULFILLED: f64 = 1e-9;

/// Solves for positions and rates. Time, parameters and inputs are taken from the state.
pub fn solve_initial(model: &Model, state: &mut State) -> Result<(), Failure> {
    solve(model, state, |positions| positions.assemble())
}

/// The same; the pose is the one to which the change of time, parameters and inputs leads from a consistent pose, whatever the guesses say.
pub(crate) fn solve_from(model: &Model, state: &mut State, pose: &State) -> Result<(), Failure> {
    solve(model, state, |positions| positions.lead(pose))
}

fn solve(model: &Model, state: &mut State, pose: impl FnOnce(Positions) -> Result<(), Failure>) -> Result<(), Failure> {
    model.follow(state.registers_mut());
    let mut machine = Machine::new(model);
    pose(Positions::new(model, &mut machine, state))?;
    Rates::new(model, &mut machine, state).solve()
}

/// Which equations are imposed.
#[derive(Clone, Copy)]
struct Wanted {
    loops: bool,
    known: bool,
    guesses: bool,
    /// Only what is linear?
    linear: bool,
    /// Are known coordinates no unknowns?
    substituted: bool,
    /// A known condition that is left out.
    without: Option<usize>,
}

impl Wanted {
    const ALL: Self =
        Self { loops: true, known: true, guesses: false, linear: false, substituted: true, without: None };
    const LINEAR: Self = Self { loops: false, guesses: true, linear: true, ..Self::ALL };
    const CONDITIONS: Self = Self { loops: false, guesses: true, ..Self::ALL };
    const KNOWN: Self = Self { loops: false, ..Self::ALL };
    const LOOPS: Self = Self { known: false, ..Self::ALL };

    fn includes(&self, index: usize, condition: &Condition, given: &Given) -> bool {
        let wanted = if condition.known { self.known } else { self.guesses };
        wanted && self.without != Some(index) && (!self.linear || given.is_linear(index))
    }

    fn includes_loop(&self, row: usize, given: &Given) -> bool {
        self.loops && (!self.linear || given.is_linear_loop(row))
    }

    /// The value of an unknown that is substituted.
    fn substitute(&self, unknown: usize, given: &Given) -> Option<f64> {
        let imposed = |condition: &usize| self.known && self.substituted && self.without != Some(*condition);
        given.condition(unknown).filter(imposed).map(|condition| given.target(condition))
    }
}

/// One family of equations: the loops and the conditions, at the level of positions or of rates.
struct Family<'a> {
    loops: (&'a Tape, &'a SparseTape),
    conditions: (&'a [Condition], &'a Tape, &'a SparseTape),
}

impl Family<'_> {
    fn residuals(&self, model: &Model, machine: &mut Machine, (wanted, given): (Wanted, &Given), r: &mut Vec<f64>) {
        r.clear();
        if wanted.loops {
            machine.run(self.loops.0);
            let scales = model.program().constraints.iter().map(|constraint| constraint.scale);
            let values = self.loops.0.results(machine.registers()).zip(scales).enumerate();
            r.extend(
                values.map(|(row, (phi, scale))| if wanted.includes_loop(row, given) { phi / scale } else { 0.0 }),
            );
        }
        let (conditions, tape, _) = self.conditions;
        machine.run(tape);
        for (index, condition) in conditions.iter().enumerate() {
            if wanted.includes(index, condition, given) {
                let [value, target] = [index, index + conditions.len()].map(|result| machine.result(tape, result));
                r.push((value - target) / condition.scale);
            }
        }
    }

    fn jacobian(
        &self,
        model: &Model,
        machine: &mut Machine,
        (wanted, given): (Wanted, &Given),
        entries: &mut Vec<Entry>,
    ) {
        entries.clear();
        let mut rows = 0;
        if wanted.loops {
            rows = model.program().constraints.len();
            let scale =
                |row: usize| wanted.includes_loop(row, given).then(|| (row, model.program().constraints[row].scale));
            self.append(model, machine, self.loops.1, scale, entries);
        }
        let (conditions, _, jacobian) = self.conditions;
        let places: Vec<_> = (conditions.iter().enumerate())
            .map(|(index, condition)| {
                let place = rows;
                let included = wanted.includes(index, condition, given);
                rows += usize::from(included);
                included.then_some((place, condition.scale))
            })
            .collect();
        self.append(model, machine, jacobian, |row| places[row], entries);
        entries.retain(|&(_, unknown, _)| wanted.substitute(unknown, given).is_none());
    }

    fn append(
        &self,
        model: &Model,
        machine: &mut Machine,
        sparse: &SparseTape,
        place: impl Fn(usize) -> Option<(usize, f64)>,
        entries: &mut Vec<Entry>,
    ) {
        machine.run(&sparse.tape);
        for (&(row, column), value) in sparse.entries.iter().zip(sparse.tape.results(machine.registers())) {
            if let Some((row, scale)) = place(row as usize) {
                let column = column as usize;
                entries.push((row, column, value * column_scale(model, column) / scale));
            }
        }
    }
}

/// Where the search begins, relative to the scales.
fn first(model: &Model, values: &[f64]) -> Vec<f64> {
    let size = model.coordinates() + model.program().followers.len();
    (0..size).map(|column| values.get(column).map_or(0.0, |value| value / column_scale(model, column))).collect()
}

/// Natural size of an unknown: a coordinate, or a follower's position.
fn column_scale(model: &Model, column: usize) -> f64 {
    let (coordinates, followers) = (&model.program().coordinates, &model.program().followers);
    match coordinates.get(column) {
        Some(coordinate) => coordinate.scale,
        None => followers[column - coordinates.len()].scale,
    }
}

fn fulfilled(r: &[f64]) -> bool {
    r.iter().all(|r| r.abs() <= FULFILLED)
}
