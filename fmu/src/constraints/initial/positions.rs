//! The first consistent pose, or why there is none.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::level::Level;
use super::{Family, Wanted, column_scale, first, fulfilled};
use crate::constraints::projection::largest_gap;
use crate::failure::{Failure, LoopGap};
use crate::linalg::least_squares::{ResidualFunction, solve};
use crate::machine::Machine;
use crate::math::Random;
use crate::model::{Model, State};
use crate::program::{Condition, Role};

/// Longest Newton step, relative to the scales: longer ones jump between assemblies.
const LONGEST_NEWTON_STEP: f64 = 0.5;
/// Sizes of the random disturbances that lead out of a pose where Newton's method stands still.
const DISTURBANCES: [f64; 7] = [1e-3, 1e-2, 0.1, 0.3, 0.6, 1.0, 2.0];
/// Disturbances tried of each size; as many poses that are turned at random are tried where none next to the guess closes the loops.
const TRIES: usize = 6;
/// A mechanism that turned over has moved at least this much [rad].
const TURNED: f64 = 0.5;
/// Where the drivers are followed to another time: the first part of the way and the shortest one, and how many there may be.
const FIRST_PART: f64 = 1e-3;
const SHORTEST_PART_OF_GUESS: f64 = 1e-9;
const MOST_PARTS: usize = 100_000;
/// In no part, and in no part of a change of parameters or inputs, does the pose end further from where it was going, in units of the scales.
pub(crate) const ASTRAY: f64 = 0.05;

/// Positions as unknowns: those of the coordinates and of the integrated inputs.
pub(super) struct Positions<'a>(Level<'a>);

impl<'a> Positions<'a> {
    pub fn new(model: &'a Model, machine: &'a mut Machine, state: &'a mut State) -> Self {
        let (layout, tapes, initial) = (model.layout(), &model.program().tapes, &model.program().initial);
        let family = Family {
            loops: (&tapes.constraint, &tapes.jacobian),
            conditions: (&initial.positions, &initial.position, &initial.position_jacobian),
        };
        let columns = (layout.positions()..layout.rates()).chain(layout.followers()..layout.follower_rates());
        Self(Level::new(model, machine, state, family, columns, |_| true))
    }

    fn attempt(&mut self, wanted: Wanted, x: &mut Vec<f64>) -> Vec<f64> {
        self.0.wanted = wanted;
        solve(&mut self.0, x, LONGEST_NEWTON_STEP)
    }

    /// Leaves a consistent pose in the state.
    pub fn assemble(mut self) -> Result<(), Failure> {
        let initial = &self.0.model.program().initial;
        if self.0.is_found(&initial.found_positions) {
            return Ok(());
        }
        let mut guess = first(self.0.model, &initial.first_positions);
        self.0.given.substitute(self.0.model, &mut guess);
        // What is linear may be far away: there is only one solution to jump to.
        self.0.wanted = Wanted::LINEAR;
        solve(&mut self.0, &mut guess, f64::INFINITY);
        self.attempt(Wanted::CONDITIONS, &mut guess);
        let mut known = guess.clone();
        let r = self.attempt(Wanted::KNOWN, &mut known);
        // In a folded pose Newton's method does not see how what is known can change.
        if !fulfilled(&r) && !self.close(Wanted::KNOWN, &mut guess.clone()) {
            // Without substitution all that contradict each other share what is left.
            let shared = self.attempt(Wanted { substituted: false, ..Wanted::KNOWN }, &mut known);
            return Err(self.contradiction(if fulfilled(&shared) { &r } else { &shared }));
        }
        let found = match self.near(&guess) {
            Ok(found) => found,
            Err(failure) => {
                // The best pose is shown where there is none that closes the loops.
                let best = self.0.state.clone();
                let found = self.along_the_drivers(&guess).or_else(|| self.far(&guess));
                let Some(found) = found.or_else(|| self.along_the_changes()).or_else(|| self.turned(&guess)) else {
                    self.0.state.copy_from(&best);
                    return Err(failure);
                };
                found
            }
        };
        self.0.load(&found);
        Ok(())
    }

    /// Leaves the pose in the state to which the change of time, parameters and inputs leads from another one.
    pub fn lead(mut self, pose: &State) -> Result<(), Failure> {
        let found = self.led(pose).ok_or(Failure::WayEnds)?;
        self.0.load(&found);
        Ok(())
    }

    /// The pose next to a guess.
    fn near(&mut self, guess: &[f64]) -> Result<Vec<f64>, Failure> {
        let mut x = guess.to_vec();
        if !self.close(Wanted::ALL, &mut x) {
            return Err(self.explain(guess, &x));
        }
        self.turn_back(guess, &mut x);
        self.same_branch(guess, &x)?;
        Ok(x)
    }

    /// The pose next to where the linear loops lead from a guess: in one step, however many turns away, for they have one solution.
    fn far(&mut self, guess: &[f64]) -> Option<Vec<f64>> {
        let mut x = guess.to_vec();
        self.0.given.find_linear_loops(self.0.model);
        self.0.wanted = Wanted { loops: true, ..Wanted::LINEAR };
        solve(&mut self.0, &mut x, f64::INFINITY);
        // A step of Newton's method is shorter than the way was: the loops did not lead away.
        let led = x.iter().zip(guess).any(|(x, guess)| (x - guess).abs() > LONGEST_NEWTON_STEP);
        if led { self.near(&x).ok() } else { None }
    }

    /// The pose nearest to a guess of those to which turned poses lead, if it is as guessed: where the guess is a folded pose Newton's method stands still on its way.
    fn turned(&mut self, guess: &[f64]) -> Option<Vec<f64>> {
        let (mut random, mut nearest) = (Random::new(2), None::<(f64, Vec<f64>)>);
        for _ in 0..TRIES * DISTURBANCES.len() {
            // By half a turn at most.
            let mut x = self.disturbed(Wanted::ALL, guess, PI, &mut random);
            if !fulfilled(&self.attempt(Wanted::ALL, &mut x)) {
                continue;
            }
            self.turn_back(guess, &mut x);
            let apart = longest(&x, guess);
            if nearest.as_ref().is_none_or(|(least, _)| apart < *least) && self.same_branch(guess, &x).is_ok() {
                nearest = Some((apart, x));
            }
        }
        nearest.map(|(_, x)| x)
    }

    /// A pose with every unknown moved at random. What is known stays: no step of the search would put it back.
    fn disturbed(&self, wanted: Wanted, x: &[f64], size: f64, random: &mut Random) -> Vec<f64> {
        let moved = |(column, x): (usize, &f64)| {
            let moved = x + size * random.symmetric();
            let known = wanted.substitute(column, &self.0.given);
            known.map_or(moved, |known| known / column_scale(self.0.model, column))
        };
        x.iter().enumerate().map(moved).collect()
    }

    /// The pose to which the drivers lead from where the scene starts: the guess belongs there.
    fn along_the_drivers(&mut self, guess: &[f64]) -> Option<Vec<f64>> {
        let span = [self.0.model.program().experiment.start, self.0.state.time()];
        if span[0] == span[1] {
            return None;
        }
        self.0.state.set_time(span[0]);
        let first = self.near(guess).ok().or_else(|| self.far(guess));
        let set = |level: &mut Level, time| level.state.set_time(time);
        let found = first.and_then(|first| self.follow(first, span, FIRST_PART, set));
        self.0.state.set_time(span[1]);
        found
    }

    /// The pose to which a change of what can be set leads from the one that the program was made with: the guesses belong there. Guesses that change themselves are
    /// to fit.
    fn along_the_changes(&mut self) -> Option<Vec<f64>> {
        let exported = self.0.exported()?;
        let found = self.led(&exported)?;
        let before = self.0.targets(&exported);
        let values = self.values(&found);
        let (values, targets) = values.split_at(before.len());
        let fits = |(index, condition): (usize, &Condition)| {
            condition.known || targets[index] == before[index] || !is_far(condition, values[index], targets[index])
        };
        self.conditions().iter().enumerate().all(fits).then_some(found)
    }

    /// The pose to which a change of time, parameters and inputs leads from a consistent one.
    fn led(&mut self, from: &State) -> Option<Vec<f64>> {
        let (to, first) = (self.0.state.clone(), self.0.unknowns(from));
        let set = |level: &mut Level, share| level.set_between([from, &to], share);
        let found = self.follow(first, [0.0, 1.0], 1.0, set);
        set(&mut self.0, 1.0);
        found
    }

    /// Follows the loops from a pose at one place of a way to another place, in parts so short that the motion goes straight on in each, the first one a share of the way. `set`
    /// makes the state that of a place.
    fn follow(
        &mut self,
        mut x: Vec<f64>,
        [mut time, until]: [f64; 2],
        first: f64,
        set: impl Fn(&mut Level, f64),
    ) -> Option<Vec<f64>> {
        let whole = until - time;
        let (mut part, mut rates) = (whole * first, vec![0.0; x.len()]);
        for _ in 0..MOST_PARTS {
            let last = (until - time).abs() <= part.abs();
            let next = if last { until } else { time + part };
            let span = next - time;
            set(&mut self.0, next);
            let ahead: Vec<f64> = x.iter().zip(&rates).map(|(x, rate)| x + span * rate).collect();
            let mut found = ahead.clone();
            let r = self.attempt(Wanted::ALL, &mut found);
            self.0.given.substitute(self.0.model, &mut found);
            let (missed, moved) = (longest(&found, &ahead), longest(&found, &x));
            // Written so that NaN is astray.
            if fulfilled(&r) && missed <= ASTRAY && moved <= TURNED {
                if last {
                    return Some(found);
                }
                rates = found.iter().zip(&x).map(|(found, x)| (found - x) / span).collect();
                (x, time) = (found, next);
                part *= if missed < 0.25 * ASTRAY && moved < 0.5 * TURNED { 2.0 } else { 1.0 };
            } else {
                part *= 0.5;
                if part.abs() < SHORTEST_PART_OF_GUESS * whole.abs() {
                    return None;
                }
            }
        }
        None
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
                let mut trial = self.disturbed(wanted, &start, size, &mut random);
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
            return self.open(best);
        }
        let frees = |index: &usize| {
            let wanted = Wanted { without: Some(*index), ..Wanted::ALL };
            fulfilled(&self.attempt(wanted, &mut closed.clone()))
        };
        let culprits: Vec<usize> = known.iter().copied().filter(frees).collect();
        let culprits = if culprits.is_empty() { known } else { culprits };
        self.0.wanted = Wanted::ALL;
        self.0.load(best);
        let conditions = culprits.into_iter().map(|index| self.conditions()[index].name.clone()).collect();
        self.contradicting(conditions)
    }

    /// No assembly was found. Where other parameters than those of the export may have taken away what the joints implied, that is the reason.
    fn open(&mut self, best: &[f64]) -> Failure {
        let gap = self.gap(best);
        let program = self.0.model.program();
        let implied = program.constraints.iter().find(|row| row.implied);
        let exported = program.parameters.iter().map(|parameter| parameter.start);
        match implied.filter(|_| !exported.eq(self.0.state.parameters().iter().copied())) {
            Some(row) => Failure::NotImplied { relation: row.owner.clone(), gap },
            None => Failure::LoopsOpen { gap },
        }
    }

    fn conditions(&self) -> &'a [Condition] {
        &self.0.model.program().initial.positions
    }

    fn contradiction(&self, r: &[f64]) -> Failure {
        self.contradicting(names(self.conditions(), r))
    }

    fn contradicting(&self, conditions: Vec<String>) -> Failure {
        Failure::Contradiction { conditions, velocity: false, loops: !self.0.model.program().constraints.is_empty() }
    }

    fn gap(&mut self, x: &[f64]) -> LoopGap {
        self.0.load(x);
        let mut residuals = vec![0.0; self.0.model.program().constraints.len()];
        self.0.machine.evaluate(&self.0.model.program().tapes.constraint, &mut residuals);
        let rows: Vec<usize> = (0..residuals.len()).collect();
        largest_gap(self.0.model, &rows, &residuals)
    }

    /// Takes back whole turns of angles.
    fn turn_back(&mut self, guess: &[f64], x: &mut [f64]) {
        self.0.wanted = Wanted::ALL;
        let mut r = Vec::new();
        for index in 0..self.0.model.coordinates() {
            let found = x[index];
            let turns = ((found - guess[index]) / TAU).round();
            if turns != 0.0 && column_scale(self.0.model, index) == 1.0 {
                x[index] = found - turns * TAU;
                self.0.residuals(x, &mut r);
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
            let far = is_far(condition, found, target);
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
        self.0.load(x);
        let tape = &self.0.model.program().initial.position;
        self.0.machine.run(tape);
        tape.results(self.0.machine.registers()).collect()
    }

    /// Sign of the determinant of the active loop equations and known conditions; 0 if it has none.
    fn orientation(&mut self, x: &[f64]) -> f64 {
        let inactive: Vec<bool> =
            self.0.model.program().constraints.iter().map(|constraint| constraint.role != Role::Imposed).collect();
        let known = self.conditions().iter().filter(|condition| condition.known).count();
        let size = x.len();
        let active = inactive.iter().filter(|inactive| !**inactive).count();
        if active + known != size || size > 500 || known == size {
            return 0.0;
        }
        let mut entries = Vec::new();
        self.0.wanted = Wanted { substituted: false, ..Wanted::ALL };
        self.0.jacobian(x, &mut entries);
        let mut matrix = nalgebra::DMatrix::zeros(inactive.len() + known, size);
        entries.iter().for_each(|&(row, column, value)| matrix[(row, column)] += value);
        let rows: Vec<usize> = (0..inactive.len()).filter(|&row| inactive[row]).collect();
        let determinant: f64 = matrix.remove_rows_at(&rows).lu().determinant();
        if determinant.is_finite() { crate::math::sign(determinant) } else { 0.0 }
    }
}

/// The largest difference of two poses.
fn longest(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).fold(0.0, |most, (one, other)| crate::math::maximum(most, (one - other).abs()))
}

/// Is an angle so far from its guess that it was not meant?
fn is_far(condition: &Condition, found: f64, target: f64) -> bool {
    condition.angular && wrapped(found - target).abs() > FRAC_PI_2
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
