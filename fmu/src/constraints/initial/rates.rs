//! Rates that fit the pose, or why there are none.

use super::given::Given;
use super::{FULFILLED, Family, Wanted, column_scale, first};
use crate::constraints::projection::largest_gap;
use crate::failure::Failure;
use crate::linalg::least_squares::{Entry, Equations, solve};
use crate::machine::Machine;
use crate::model::{Model, State};
use crate::program::FollowerOrder;

/// Rates as unknowns: v, and the rates of followers whose acceleration is prescribed.
pub(super) struct Rates<'a> {
    model: &'a Model,
    machine: &'a mut Machine,
    state: &'a mut State,
    given: Given,
    wanted: Wanted,
}

impl Equations for Rates<'_> {
    fn residuals(&mut self, x: &[f64], r: &mut Vec<f64>) {
        self.load(x);
        self.family().residuals(self.model, self.machine, (self.wanted, &self.given), r);
    }

    fn jacobian(&mut self, x: &[f64], entries: &mut Vec<Entry>) {
        self.load(x);
        self.family().jacobian(self.model, self.machine, (self.wanted, &self.given), entries);
        let n = self.model.coordinates();
        entries.retain(|&(_, column, _)| column < n || self.free(column - n));
    }
}

impl<'a> Rates<'a> {
    pub fn new(model: &'a Model, machine: &'a mut Machine, state: &'a mut State) -> Self {
        let (layout, initial) = (model.layout(), &model.program().initial);
        machine.load(model, state);
        let conditions = (&initial.velocities[..], &initial.velocity, &initial.velocity_jacobian);
        let unknowns =
            [layout.rates()..layout.accelerations(), layout.follower_rates()..layout.follower_accelerations()];
        let given = Given::new(model, machine, conditions, unknowns);
        Self { model, machine, state, given, wanted: Wanted::ALL }
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
        let value = |unknown: usize| {
            let known = self.wanted.substitute(unknown, &self.given);
            known.unwrap_or_else(|| x[unknown] * column_scale(self.model, unknown))
        };
        self.state.rates_mut().iter_mut().enumerate().for_each(|(index, place)| *place = value(index));
        for index in 0..self.model.program().followers.len() {
            if !self.free(index) {
                continue;
            }
            self.state.follower_rates_mut()[index] = value(n + index);
        }
        self.machine.load(self.model, self.state);
    }

    pub fn solve(mut self) -> Result<(), Failure> {
        let mut from = first(self.model, &self.model.program().initial.first_rates);
        self.given.substitute(self.model, &mut from);
        let mut x = from.clone();
        let r = solve(&mut self, &mut x, f64::INFINITY);
        let speed = x.iter().fold(1.0, |largest: f64, x| largest.max(x.abs()));
        let holds = |r: &[f64]| r.iter().all(|r| r.abs() <= FULFILLED * speed);
        if holds(&r) {
            self.load(&x);
            return Ok(());
        }
        self.wanted = Wanted::LOOPS;
        let r = solve(&mut self, &mut from.clone(), f64::INFINITY);
        if !r.iter().all(|r| r.abs() <= FULFILLED * speed) {
            return Err(self.conflict(&r));
        }
        let conditions = &self.model.program().initial.velocities;
        let frees = |index: &usize| {
            self.wanted = Wanted { without: Some(*index), ..Wanted::ALL };
            holds(&solve(&mut self, &mut from.clone(), f64::INFINITY))
        };
        let culprits: Vec<usize> = (0..conditions.len()).filter(frees).collect();
        let culprits = if culprits.is_empty() { (0..conditions.len()).collect() } else { culprits };
        let conditions = culprits.into_iter().map(|index| conditions[index].name.clone()).collect();
        let loops = !self.model.program().constraints.is_empty();
        Err(Failure::Contradiction { conditions, velocity: true, loops })
    }

    /// Drivers whose rates the loops cannot follow.
    fn conflict(&self, r: &[f64]) -> Failure {
        let scales = self.model.program().constraints.iter().map(|constraint| constraint.scale);
        let residuals: Vec<f64> = r.iter().zip(scales).map(|(r, scale)| r * scale).collect();
        let rows: Vec<usize> = (0..residuals.len()).collect();
        Failure::LockUp { time: self.state.time(), gap: largest_gap(self.model, &rows, &residuals) }
    }
}
