//! Rates that fit the pose, or why there are none.

use super::level::Level;
use super::{FULFILLED, Family, Wanted, first};
use crate::constraints::projection::largest_gap;
use crate::failure::Failure;
use crate::linalg::least_squares::solve;
use crate::machine::Machine;
use crate::model::{Model, State};
use crate::program::FollowerOrder;

/// Rates as unknowns: v, and the rates of integrated inputs whose acceleration is prescribed.
pub(super) struct Rates<'a>(Level<'a>);

impl<'a> Rates<'a> {
    pub fn new(model: &'a Model, machine: &'a mut Machine, state: &'a mut State) -> Self {
        let (layout, program) = (model.layout(), model.program());
        let (tapes, initial) = (&program.tapes, &program.initial);
        let family = Family {
            loops: (&tapes.constraint_rate, &tapes.jacobian),
            conditions: (&initial.velocities, &initial.velocity, &initial.velocity_jacobian),
        };
        let columns =
            (layout.rates()..layout.accelerations()).chain(layout.follower_rates()..layout.follower_accelerations());
        let free = |column: usize| {
            let follower = column.checked_sub(model.coordinates());
            follower.is_none_or(|index| program.followers[index].order == FollowerOrder::Acceleration)
        };
        Self(Level::new(model, machine, state, family, columns, free))
    }

    pub fn solve(mut self) -> Result<(), Failure> {
        let initial = &self.0.model.program().initial;
        if self.0.is_found(&initial.found_rates) {
            return Ok(());
        }
        let mut from = first(self.0.model, &initial.first_rates);
        self.0.given.substitute(self.0.model, &mut from);
        let mut x = from.clone();
        let r = solve(&mut self.0, &mut x, f64::INFINITY);
        let speed = x.iter().take(self.0.model.mechanical()).fold(1.0, |largest: f64, x| largest.max(x.abs()));
        let holds = |r: &[f64]| r.iter().all(|r| r.abs() <= FULFILLED * speed);
        if holds(&r) {
            self.0.load(&x);
            return Ok(());
        }
        self.0.wanted = Wanted::LOOPS;
        let r = solve(&mut self.0, &mut from.clone(), f64::INFINITY);
        if !r.iter().all(|r| r.abs() <= FULFILLED * speed) {
            return Err(self.conflict(&r));
        }
        let conditions = &self.0.model.program().initial.velocities;
        let frees = |index: &usize| {
            self.0.wanted = Wanted { without: Some(*index), ..Wanted::ALL };
            holds(&solve(&mut self.0, &mut from.clone(), f64::INFINITY))
        };
        let culprits: Vec<usize> = (0..conditions.len()).filter(frees).collect();
        let culprits = if culprits.is_empty() { (0..conditions.len()).collect() } else { culprits };
        let conditions = culprits.into_iter().map(|index| conditions[index].name.clone()).collect();
        let loops = !self.0.model.program().constraints.is_empty();
        Err(Failure::Contradiction { conditions, velocity: true, loops })
    }

    /// Drivers whose rates the loops cannot follow, or that have none.
    fn conflict(&self, r: &[f64]) -> Failure {
        let scales = self.0.model.program().constraints.iter().map(|constraint| constraint.scale);
        let residuals: Vec<f64> = r.iter().zip(scales).map(|(r, scale)| r * scale).collect();
        let rows: Vec<usize> = (0..residuals.len()).collect();
        let (time, gap) = (self.0.state.time(), largest_gap(self.0.model, &rows, &residuals));
        match gap.size.is_finite() {
            true => Failure::LockUp { time, gap },
            false => Failure::DriverUndefined { time, owner: gap.owner },
        }
    }
}
