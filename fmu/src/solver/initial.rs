//! The first consistent state: what is known holds, what is guessed picks the assembly, the loops give the rest.
//!
//! Unknown positions are q and the positions of followers; all start from zero. First all conditions are met as well as they can be,
//! loops open; from that guessed pose the loops are closed with the smallest movement. Rates follow from linear equations,
//! the smallest that serve.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::failure::{Failure, Gap};
use super::least_squares::{Entry, Equations, solve};
use super::poses::Random;
use super::projection::largest_gap;
use crate::machine::Machine;
use crate::model::{Model, State};
use crate::program::{Condition, FollowerOrder, SparseTape};
use crate::tape::Tape;

/// What counts as fulfilled, relative to the scales.
pub(crate) const FULFILLED: f64 = 1e-9;
/// Longest Newton step, relative to the scales: longer ones jump between assemblies.
const REACH: f64 = 0.5;
/// Sizes of the random disturbances that lead out of a pose where Newton's method stands still.
const DISTURBANCES: [f64; 7] = [1e-3, 1e-2, 0.1, 0.3, 0.6, 1.0, 2.0];
/// Disturbances tried of each size.
const TRIES: usize = 6;
/// A mechanism that turned over has moved at least this much [rad].
const TURNED: f64 = 0.5;

/// Solves for positions and rates. Time, parameters and inputs are taken from the state.
pub fn solve_initial(model: &Model, state: &mut State) -> Result<(), Failure> {
    model.follow(state.registers_mut());
    let mut machine = Machine::new(model);
    Positions::new(model, &mut machine, state, Wanted::ALL).assemble()?;
    Rates::new(model, &mut machine, state).solve()
}

/// Which equations are imposed.
#[derive(Clone, Copy)]
struct Wanted {
    loops: bool,
    known: bool,
    guesses: bool,
    /// A known condition that is left out.
    without: Option<usize>,
}

impl Wanted {
    const ALL: Self = Self { loops: true, known: true, guesses: false, without: None };
    const CONDITIONS: Self = Self { loops: false, guesses: true, ..Self::ALL };
    const KNOWN: Self = Self { loops: false, ..Self::ALL };
    const LOOPS: Self = Self { known: false, ..Self::ALL };

    fn includes(&self, index: usize, condition: &Condition) -> bool {
        self.without != Some(index) && if condition.known { self.known } else { self.guesses }
    }
}

/// One family of equations: the loops and the conditions, at the level of positions or of rates.
struct Family<'a> {
    loops: (&'a Tape, &'a SparseTape),
    conditions: (&'a [Condition], &'a Tape, &'a SparseTape),
}

impl Family<'_> {
    fn residuals(&self, model: &Model, machine: &mut Machine, wanted: Wanted, r: &mut Vec<f64>) {
        r.clear();
        if wanted.loops {
            machine.run(self.loops.0);
            let scales = model.program().constraints.iter().map(|constraint| constraint.scale);
            r.extend(self.loops.0.results(machine.registers()).zip(scales).map(|(phi, scale)| phi / scale));
        }
        let (conditions, tape, _) = self.conditions;
        machine.run(tape);
        for (index, condition) in conditions.iter().enumerate() {
            if wanted.includes(index, condition) {
                let [value, target] = [index, index + conditions.len()].map(|result| machine.result(tape, result));
                r.push((value - target) / condition.scale);
            }
        }
    }

    fn jacobian(&self, model: &Model, machine: &mut Machine, wanted: Wanted, entries: &mut Vec<Entry>) {
        entries.clear();
        let mut rows = 0;
        if wanted.loops {
            rows = model.program().constraints.len();
            let scale = |row: usize| Some((row, model.program().constraints[row].scale));
            self.append(model, machine, self.loops.1, scale, entries);
        }
        let (conditions, _, jacobian) = self.conditions;
        let places: Vec<_> = (conditions.iter().enumerate())
            .map(|(index, condition)| {
                let place = rows;
                let included = wanted.includes(index, condition);
                rows += usize::from(included);
                included.then_some((place, condition.scale))
            })
            .collect();
        self.append(model, machine, jacobian, |row| places[row], entries);
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

/// Positions as unknowns.
struct Positions<'a> {
    model: &'a Model,
    machine: &'a mut Machine,
    state: &'a mut State,
    wanted: Wanted,
}

impl Equations for Positions<'_> {
    fn residuals(&mut self, x: &[f64], r: &mut Vec<f64>) {
        self.load(x);
        self.family().residuals(self.model, self.machine, self.wanted, r);
    }

    fn jacobian(&mut self, x: &[f64], entries: &mut Vec<Entry>) {
        self.load(x);
        self.family().jacobian(self.model, self.machine, self.wanted, entries);
    }
}

impl<'a> Positions<'a> {
    fn new(model: &'a Model, machine: &'a mut Machine, state: &'a mut State, wanted: Wanted) -> Self {
        Self { model, machine, state, wanted }
    }

    fn family(&self) -> Family<'a> {
        let (tapes, initial) = (&self.model.program().tapes, &self.model.program().initial);
        Family {
            loops: (&tapes.constraint, &tapes.jacobian),
            conditions: (&initial.positions, &initial.position, &initial.position_jacobian),
        }
    }

    fn load(&mut self, x: &[f64]) {
        let (n, scale) = (self.model.coordinates(), |column| column_scale(self.model, column));
        let q = self.state.positions_mut().iter_mut().enumerate();
        q.for_each(|(column, place)| *place = x[column] * scale(column));
        let followers = self.state.follower_positions_mut().iter_mut().enumerate();
        followers.for_each(|(index, place)| *place = x[n + index] * scale(n + index));
        self.machine.load(self.model, self.state);
    }

    fn attempt(&mut self, wanted: Wanted, x: &mut Vec<f64>) -> Vec<f64> {
        self.wanted = wanted;
        solve(self, x, REACH)
    }

    /// Leaves a consistent pose in the state.
    fn assemble(mut self) -> Result<(), Failure> {
        let mut guess = vec![0.0; self.model.coordinates() + self.model.program().followers.len()];
        self.attempt(Wanted::CONDITIONS, &mut guess);
        let mut known = guess.clone();
        let r = self.attempt(Wanted::KNOWN, &mut known);
        if !fulfilled(&r) {
            return Err(self.contradiction(&r));
        }
        let mut x = guess.clone();
        if !self.close(Wanted::ALL, &mut x) {
            return Err(self.explain(&guess, &x));
        }
        self.turn_back(&guess, &mut x);
        self.same_branch(&guess, &x)?;
        self.load(&x);
        Ok(())
    }

    /// Closes the loops from x, or from a pose nearby if Newton's method stands still there. Otherwise x is the best pose found.
    fn close(&mut self, wanted: Wanted, x: &mut Vec<f64>) -> bool {
        let start = x.clone();
        let r = self.attempt(wanted, x);
        if fulfilled(&r) {
            return true;
        }
        let norm = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
        let mut best = norm(&r);
        let mut random = Random::new(1);
        for size in DISTURBANCES {
            for _ in 0..TRIES {
                let mut trial: Vec<f64> = start.iter().map(|x| x + size * random.symmetric()).collect();
                let r = self.attempt(wanted, &mut trial);
                if norm(&r) < best || best.is_nan() {
                    best = norm(&r);
                    x.clone_from(&trial);
                }
                if fulfilled(&r) {
                    return true;
                }
            }
        }
        false
    }

    /// Why the loops do not close: because of known values, or anyway?
    fn explain(&mut self, guess: &[f64], best: &[f64]) -> Failure {
        let known: Vec<usize> = (0..self.conditions().len()).filter(|&index| self.conditions()[index].known).collect();
        let mut closed = guess.to_vec();
        if known.is_empty() || !self.close(Wanted::LOOPS, &mut closed) {
            return Failure::LoopsOpen { gap: self.gap(best) };
        }
        let frees = |index: &usize| {
            let wanted = Wanted { without: Some(*index), ..Wanted::ALL };
            fulfilled(&self.attempt(wanted, &mut closed.clone()))
        };
        let culprits: Vec<usize> = known.iter().copied().filter(frees).collect();
        let culprits = if culprits.is_empty() { known } else { culprits };
        let conditions = culprits.into_iter().map(|index| self.conditions()[index].name.clone()).collect();
        Failure::Contradiction { conditions, velocity: false }
    }

    fn conditions(&self) -> &'a [Condition] {
        &self.model.program().initial.positions
    }

    fn contradiction(&self, r: &[f64]) -> Failure {
        Failure::Contradiction { conditions: names(self.conditions(), r), velocity: false }
    }

    fn gap(&mut self, x: &[f64]) -> Gap {
        self.load(x);
        let mut residuals = vec![0.0; self.model.program().constraints.len()];
        self.machine.evaluate(&self.model.program().tapes.constraint, &mut residuals);
        let rows: Vec<usize> = (0..residuals.len()).collect();
        largest_gap(self.model, &rows, &residuals)
    }

    /// Takes back whole turns of angles.
    fn turn_back(&mut self, guess: &[f64], x: &mut [f64]) {
        self.wanted = Wanted::ALL;
        let mut r = Vec::new();
        for index in 0..self.model.coordinates() {
            let found = x[index];
            let turns = ((found - guess[index]) / TAU).round();
            if turns != 0.0 && column_scale(self.model, index) == 1.0 {
                x[index] = found - turns * TAU;
                self.residuals(x, &mut r);
                if !fulfilled(&r) {
                    x[index] = found;
                }
            }
        }
    }

    /// Is the pose found on the branch that was guessed?
    fn same_branch(&mut self, guess: &[f64], x: &[f64]) -> Result<(), Failure> {
        let turned_over = self.orientation(guess) * self.orientation(x) < 0.0;
        let before = self.values(guess);
        let after = self.values(x);
        let k = self.conditions().len();
        for (index, condition) in self.conditions().iter().enumerate().filter(|(_, condition)| !condition.known) {
            let (target, found) = (after[k + index], after[index]);
            let far = condition.angular && wrapped(found - target).abs() > FRAC_PI_2;
            let moved = (found - before[index]).abs() / condition.scale > TURNED;
            if far || (turned_over && moved) {
                let (condition, angular) = (condition.name.clone(), condition.angular);
                return Err(Failure::OtherBranch { condition, guess: target, found, angular });
            }
        }
        Ok(())
    }

    /// Values and targets of all conditions.
    fn values(&mut self, x: &[f64]) -> Vec<f64> {
        self.load(x);
        let tape = &self.model.program().initial.position;
        self.machine.run(tape);
        tape.results(self.machine.registers()).collect()
    }

    /// Sign of the determinant of the active loop equations and known conditions; 0 if it has none.
    fn orientation(&mut self, x: &[f64]) -> f64 {
        let inactive: Vec<bool> =
            self.model.program().constraints.iter().map(|constraint| !constraint.active).collect();
        let known = self.conditions().iter().filter(|condition| condition.known).count();
        let size = x.len();
        if self.model.active().len() + known != size || size > 500 || known == size {
            return 0.0;
        }
        let mut entries = Vec::new();
        self.wanted = Wanted::ALL;
        self.jacobian(x, &mut entries);
        let mut matrix = nalgebra::DMatrix::zeros(inactive.len() + known, size);
        entries.iter().for_each(|&(row, column, value)| matrix[(row, column)] += value);
        let rows: Vec<usize> = (0..inactive.len()).filter(|&row| inactive[row]).collect();
        let determinant: f64 = matrix.remove_rows_at(&rows).lu().determinant();
        if determinant.is_finite() { crate::math::sign(determinant) } else { 0.0 }
    }
}

/// An angle between -pi and pi.
fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// Names of the known conditions that do not hold.
fn names(conditions: &[Condition], r: &[f64]) -> Vec<String> {
    let known = conditions.iter().filter(|condition| condition.known);
    known.zip(r).filter(|(_, r)| !fulfilled(&[**r])).map(|(condition, _)| condition.name.clone()).collect()
}

/// Rates as unknowns: v, and the rates of followers whose acceleration is prescribed.
struct Rates<'a> {
    model: &'a Model,
    machine: &'a mut Machine,
    state: &'a mut State,
    wanted: Wanted,
}

impl Equations for Rates<'_> {
    fn residuals(&mut self, x: &[f64], r: &mut Vec<f64>) {
        self.load(x);
        self.family().residuals(self.model, self.machine, self.wanted, r);
    }

    fn jacobian(&mut self, x: &[f64], entries: &mut Vec<Entry>) {
        self.load(x);
        self.family().jacobian(self.model, self.machine, self.wanted, entries);
        let n = self.model.coordinates();
        entries.retain(|&(_, column, _)| column < n || self.free(column - n));
    }
}

impl<'a> Rates<'a> {
    fn new(model: &'a Model, machine: &'a mut Machine, state: &'a mut State) -> Self {
        Self { model, machine, state, wanted: Wanted::ALL }
    }

    fn family(&self) -> Family<'a> {
        let (tapes, initial) = (&self.model.program().tapes, &self.model.program().initial);
        Family {
            loops: (&tapes.constraint_rate, &tapes.jacobian),
            conditions: (&initial.velocities, &initial.velocity, &initial.velocity_jacobian),
        }
    }

    /// Is the rate of that follower an unknown?
    fn free(&self, follower: usize) -> bool {
        self.model.program().followers[follower].order == FollowerOrder::Acceleration
    }

    fn load(&mut self, x: &[f64]) {
        let n = self.model.coordinates();
        for (column, place) in self.state.rates_mut().iter_mut().enumerate() {
            *place = x[column] * column_scale(self.model, column);
        }
        for index in 0..self.model.program().followers.len() {
            if !self.free(index) {
                continue;
            }
            self.state.follower_rates_mut()[index] = x[n + index] * column_scale(self.model, n + index);
        }
        self.machine.load(self.model, self.state);
    }

    fn solve(mut self) -> Result<(), Failure> {
        let size = self.model.coordinates() + self.model.program().followers.len();
        let mut x = vec![0.0; size];
        let r = solve(&mut self, &mut x, f64::INFINITY);
        let speed = x.iter().fold(1.0, |largest: f64, x| largest.max(x.abs()));
        let holds = |r: &[f64]| r.iter().all(|r| r.abs() <= FULFILLED * speed);
        if holds(&r) {
            self.load(&x);
            return Ok(());
        }
        self.wanted = Wanted::LOOPS;
        let r = solve(&mut self, &mut vec![0.0; size], f64::INFINITY);
        if !r.iter().all(|r| r.abs() <= FULFILLED * speed) {
            return Err(self.conflict(&r));
        }
        let conditions = &self.model.program().initial.velocities;
        let frees = |index: &usize| {
            self.wanted = Wanted { without: Some(*index), ..Wanted::ALL };
            holds(&solve(&mut self, &mut vec![0.0; size], f64::INFINITY))
        };
        let culprits: Vec<usize> = (0..conditions.len()).filter(frees).collect();
        let culprits = if culprits.is_empty() { (0..conditions.len()).collect() } else { culprits };
        let conditions = culprits.into_iter().map(|index| conditions[index].name.clone()).collect();
        Err(Failure::Contradiction { conditions, velocity: true })
    }

    /// Drivers whose rates the loops cannot follow.
    fn conflict(&self, r: &[f64]) -> Failure {
        let scales = self.model.program().constraints.iter().map(|constraint| constraint.scale);
        let residuals: Vec<f64> = r.iter().zip(scales).map(|(r, scale)| r * scale).collect();
        let rows: Vec<usize> = (0..residuals.len()).collect();
        Failure::LockUp { time: self.state.time(), gap: largest_gap(self.model, &rows, &residuals) }
    }
}
