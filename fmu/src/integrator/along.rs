//! Steps of DOP853 along the branch of a linkage through a pose where its branches cross: its coordinates are functions of one of them, which replace its loop
//! equations. Nothing is divided by the distance from the pose, however short the steps are.

use super::control::{Attempt, Integrator, Progress, Trial};
use super::explicit::dop853::{Dop853, interpolate, next_step};
use super::explicit::{COURSE, tolerate};
use super::right_hand_side::Derivative;
use super::run::Run;
use crate::context::{Context, Statistics};
use crate::failure::Failure;
use crate::linalg::dense::Lu;
use crate::machine::Machine;
use crate::math;
use crate::model::{Model, State};
use crate::singular::curve::Curve;
use crate::singular::detect::Course;

/// Halvings to the time of the pose within a step.
const HALVINGS: usize = 60;

/// Storage for steps along a branch.
#[derive(Clone, Debug)]
pub(crate) struct Along {
    method: Dop853,
    next: Vec<f64>,
    tolerances: Vec<f64>,
    /// Is the derivative where the step begins known?
    known: bool,
    system: System,
}

/// \[M J^T; J 0\] {a; -lambda} = {f; gamma} with the equations of the branch among the rows of J.
#[derive(Clone, Debug)]
struct System {
    motion: Vec<f64>,
    values: Vec<[f64; 3]>,
    unit: Vec<f64>,
    forces: Vec<f64>,
    column: Vec<f64>,
    right: Vec<f64>,
    matrix: Lu,
}

/// (q, v)' on a branch.
struct OnBranch<'a> {
    model: &'a Model,
    machine: &'a mut Machine,
    statistics: &'a mut Statistics,
    origin: &'a State,
    curve: &'a Curve,
    system: &'a mut System,
}

impl Along {
    pub fn new(model: &Model) -> Self {
        let n = model.coordinates();
        let most = model.program().linkages.iter().map(|linkage| linkage.rows.len()).max();
        // Without linkages there are no such steps.
        let rows = most.map_or(0, |_| model.active().len());
        let size = most.map_or(0, |_| 2 * n);
        let system = System {
            motion: vec![0.0; size],
            values: vec![[0.0; 3]; most.unwrap_or(0)],
            unit: vec![0.0; size / 2],
            forces: vec![0.0; size / 2],
            column: vec![0.0; size / 2],
            right: vec![0.0; size / 2 + rows],
            matrix: Lu::new(size / 2 + rows),
        };
        Self { method: Dop853::new(size), next: vec![0.0; size], tolerances: vec![0.0; size], known: false, system }
    }

    /// To be called when the next step does not begin where this method left the last one.
    pub fn forget(&mut self) {
        self.known = false;
    }

    /// Tries a step to a time; its error in units of the tolerance. No number if it left the branch as far as that is known.
    fn solve(&mut self, context: &mut Context, run: &mut Run, end: f64) -> Option<f64> {
        let (time, h) = (run.last.end_time, end - run.last.end_time);
        let Self { method, next, tolerances, system, .. } = self;
        let Run { signals, last, curve, .. } = run;
        let curve = curve.as_ref()?;
        method.attempt(&mut OnBranch::new(context, &signals.origin, curve, system), time, &last.end, h, next);
        tolerate(context, [&last.end, next], tolerances);
        let error = method.error(h, tolerances);
        // Written so that NaN is rejected too.
        let small = error <= 1.0;
        if !small {
            return Some(error);
        }
        curve.put(next, &mut system.values);
        method.finish(&mut OnBranch::new(context, &signals.origin, curve, system), end, next);
        method.dense(
            &mut OnBranch::new(context, &signals.origin, curve, system),
            time,
            &last.end,
            h,
            next,
            &mut last.dense,
        );
        last.start_time = time;
        let finite = method.last().iter().chain(&*next).chain(&last.dense).all(|value| value.is_finite());
        finite.then_some(error)
    }

    /// Notes the pose if the step just tried passes it; false if the branches do not meet there.
    fn note_passage(&mut self, context: &Context, run: &mut Run, h: f64) -> bool {
        let Some(curve) = &run.curve else { return false };
        let (parameter, pose) = (curve.parameter, curve.pose);
        let is_before = |value: f64| (value < pose) == (run.last.end[parameter] < pose);
        if is_before(self.next[parameter]) {
            return true;
        }
        let (mut low, mut high) = (0.0, 1.0);
        let motion = &mut self.system.motion;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            interpolate(&run.last.dense, middle, motion);
            *(if is_before(motion[parameter]) { &mut low } else { &mut high }) = middle;
        }
        interpolate(&run.last.dense, high, motion);
        curve.put(motion, &mut self.system.values);
        run.note_passage(context.model, run.last.end_time + high * h, motion)
    }
}

impl Integrator for Along {
    const COURSE: Course = COURSE;

    fn begin(&mut self, context: &mut Context, run: &mut Run) -> Result<Option<Progress>, Failure> {
        let time = run.last.end_time;
        let Self { method, tolerances, system, .. } = self;
        let Run { signals, last, curve, .. } = run;
        let Some(curve) = curve.as_ref() else { return Ok(Some(Progress::Declined)) };
        if !self.known {
            curve.put(&mut last.end, &mut system.values);
            method.begin(&mut OnBranch::new(context, &signals.origin, curve, system), time, &last.end);
            self.known = true;
        }
        if last.natural == 0.0 {
            tolerate(context, [&last.end, &last.end], tolerances);
            let mut f = OnBranch::new(context, &signals.origin, curve, system);
            last.natural = method.starting_step(&mut f, time, &last.end, tolerances);
        }
        Ok(None)
    }

    fn attempt(&mut self, context: &mut Context, run: &mut Run, attempt: &Attempt) -> Trial {
        let (end, h) = (attempt.end, attempt.end - run.last.end_time);
        let error = self.solve(context, run, end).unwrap_or(f64::NAN);
        // Written so that NaN is rejected too.
        let small = error <= 1.0;
        if !small || !self.note_passage(context, run, h) {
            return Trial::Rejected { shorter: next_step(h, error, true).min(0.5 * h), cause: None };
        }
        self.method.roll();
        run.last.end_time = end;
        run.last.end.copy_from_slice(&self.next);
        let proposed = next_step(h, error, attempt.rejected);
        Trial::Accepted {
            next: if attempt.is_cut() && !attempt.rejected { proposed.max(attempt.natural) } else { proposed },
        }
    }

    fn lose_pose(&mut self, _: &mut Context, _: &mut Run) -> Progress {
        Progress::Stepped
    }

    fn first(&self) -> &[f64] {
        self.method.first()
    }
}

impl<'a> OnBranch<'a> {
    fn new(context: &'a mut Context<'_>, origin: &'a State, curve: &'a Curve, system: &'a mut System) -> Self {
        Self { model: context.model, machine: context.machine, statistics: context.statistics, origin, curve, system }
    }

    /// The matrix and the right-hand side at the motion in the registers.
    fn assemble(&mut self) -> Option<f64> {
        let program = self.model.program();
        let System { motion, values, unit, forces, column, right, matrix } = &mut *self.system;
        let (n, size) = (unit.len(), right.len());
        let entries = matrix.matrix();
        let tape = program.tapes.inverse.as_ref()?;
        // f, and the columns of M, of f - M a.
        unit.fill(0.0);
        self.machine.load_accelerations(self.model, unit);
        self.machine.evaluate(tape, forces);
        for index in 0..n {
            unit[index] = 1.0;
            self.machine.load_accelerations(self.model, unit);
            self.machine.evaluate(tape, column);
            unit[index] = 0.0;
            for (row, (force, rest)) in forces.iter().zip(&*column).enumerate() {
                entries[row * size + index] = force - rest;
            }
        }
        right[..n].copy_from_slice(forces);
        let replaced = self.curve.rows(self.model);
        let row_of = |row: usize| self.model.active().iter().position(|active| *active == row).map(|place| n + place);
        let mut put = |row: usize, column: usize, value: f64| {
            entries[row * size + column] = value;
            entries[column * size + row] = value;
        };
        let jacobian = &program.tapes.jacobian;
        self.machine.run(&jacobian.tape);
        for (entry, &(row, column)) in jacobian.entries.iter().enumerate() {
            if !replaced.contains(&row)
                && (column as usize) < n
                && let Some(place) = row_of(row as usize)
            {
                put(place, column as usize, self.machine.result(&jacobian.tape, entry));
            }
        }
        self.machine.run(&program.tapes.gamma);
        for (place, &row) in self.model.active().iter().enumerate() {
            right[n + place] = self.machine.result(&program.tapes.gamma, row);
        }
        let rate = motion[n + self.curve.parameter];
        for ((&row, &other), [_, slope, second]) in replaced.iter().zip(&self.curve.others).zip(&*values) {
            let place = row_of(row as usize)?;
            put(place, other, 1.0);
            put(place, self.curve.parameter, -slope);
            right[place] = second * rate * rate;
        }
        Some(entries.iter().fold(0.0, |largest, entry| math::maximum(largest, entry.abs())))
    }

    /// Solves for the accelerations; false if there are none.
    fn solve(&mut self) -> bool {
        let Some(largest) = self.assemble() else { return false };
        let System { right, matrix, .. } = &mut *self.system;
        let regular = matrix.factor(largest).is_ok();
        if regular {
            matrix.solve(right);
        }
        regular
    }
}

impl Derivative for OnBranch<'_> {
    fn evaluate(&mut self, time: f64, y: &[f64], derivative: &mut [f64]) {
        let n = self.model.coordinates();
        self.statistics.evaluations += 1;
        self.system.motion.copy_from_slice(y);
        self.curve.put(&mut self.system.motion, &mut self.system.values);
        self.machine.load_signals(self.model, self.origin, time);
        self.machine.load_motion(self.model, &self.system.motion);
        if !self.solve() {
            return derivative.fill(f64::NAN);
        }
        derivative[..n].copy_from_slice(&self.system.motion[n..]);
        derivative[n..].copy_from_slice(&self.system.right[..n]);
    }
}
