//! Do loop equations that are left out hold where drivers lead? Where a run starts they repeat others; along the prescribed motion drivers may contradict them.
//!
//! The motion is followed in short parts. A part that no pose closes is halved; what stays open however short it is, while the independent equations close next to where the
//! motion was going, is contradicted. In a pose where more equations than usual depend on each other nothing is said: the independent ones do not tell where the motion goes.

use cotree_fmu::constraints::poses::{Loops, rows_of, scaled};
use cotree_fmu::linalg::least_squares::ResidualFunction;
use cotree_fmu::linalg::singular_values::svd;
use cotree_fmu::machine::Machine;
use cotree_fmu::math;
use cotree_fmu::model::{Model, State};
use nalgebra::{DMatrix, DVector};

use super::closing::close;
use super::nearby::CLOSED;

/// Into so many parts the experiment is divided.
const PARTS: f64 = 200.0;
/// The shortest piece of such a part, as a share of it.
const FINEST: f64 = 1e-5;
/// Equations hold that are open by less than this, relative to their scales: lengths may be typed with few digits.
const OPEN: f64 = 1e-6;
/// A pose further from where the motion was going may be on another branch.
const NEAR: f64 = 0.3;
/// The equations that count are further from depending on each other than this in a regular pose.
const REGULAR: f64 = 1e-3;
/// An equation takes part in a contradiction with at least this share of the largest one.
const SHARE: f64 = 0.1;
/// With more coordinates the motion is not followed: each pose would take too long.
const LARGEST: usize = 400;

/// Loop equations that cannot all hold along the motion that drivers prescribe.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// Until when they all hold, and a time at which they do not \[s\].
    pub times: [f64; 2],
    /// The one that is open most then.
    pub row: usize,
    /// By how much \[m or rad\].
    pub gap: f64,
    /// Those that cannot all hold.
    pub rows: Vec<usize>,
}

/// The first contradiction within the experiment, from a consistent state on. `kept`: the independent loop equations; `all`: these and those that they imply at the start.
pub fn first_contradiction(model: &Model, state: &State, kept: &[usize], all: &[usize]) -> Option<Contradiction> {
    if kept.len() == all.len() || model.mechanical() > LARGEST {
        return None;
    }
    let mut course = Course { model, machine: Machine::new(model), start: state, kept, all };
    if course.stands_still() { None } else { course.follow() }
}

/// What comes of a part of the way.
enum Part {
    /// All hold at its end, in this pose.
    Holds(Vec<f64>),
    /// This one is open by so much there, where the independent ones hold.
    Open(usize, f64),
    /// No pose was found near enough.
    Lost,
}

struct Course<'a> {
    model: &'a Model,
    machine: Machine,
    start: &'a State,
    kept: &'a [usize],
    all: &'a [usize],
}

impl Course<'_> {
    fn at(&self, time: f64) -> State {
        let mut state = self.start.clone();
        self.model.advance_signals(self.start, time, state.registers_mut());
        state
    }

    fn loops<'b>(&'b mut self, state: &'b mut State, only: &'b [usize]) -> Loops<'b> {
        Loops { model: self.model, machine: &mut self.machine, state, only: Some(only) }
    }

    /// Does no equation depend on time, as far as some times tell?
    fn stands_still(&mut self) -> bool {
        let x = scaled(self.model, self.start);
        let [from, until] = self.span();
        let mut residuals = |share: f64| {
            let (mut state, mut r) = (self.at(from + share * (until - from)), Vec::new());
            let all = self.all;
            self.loops(&mut state, all).residuals(&x, &mut r);
            r
        };
        let here = residuals(0.0);
        [0.137, 0.619, 1.0].into_iter().all(|share| residuals(share) == here)
    }

    fn span(&self) -> [f64; 2] {
        [self.start.time(), self.model.program().experiment.stop]
    }

    fn follow(&mut self) -> Option<Contradiction> {
        let [mut time, until] = self.span();
        let longest = (until - time) / PARTS;
        let (mut x, mut part) = (scaled(self.model, self.start), longest);
        let mut rates = vec![0.0; x.len()];
        let mut found: Option<(f64, usize, f64)> = None;
        while time < until {
            let next = math::minimum(time + part, until);
            let ahead: Vec<f64> = x.iter().zip(&rates).map(|(x, rate)| x + (next - time) * rate).collect();
            match self.part(next, &ahead) {
                Part::Holds(there) => {
                    rates = there.iter().zip(&x).map(|(there, x)| (there - x) / (next - time)).collect();
                    (x, time) = (there, next);
                    if found.is_none_or(|(open, ..)| open <= time) {
                        (found, part) = (None, math::minimum(2.0 * part, longest));
                    }
                    continue;
                }
                Part::Open(row, gap) => _ = found.get_or_insert((next, row, gap)),
                Part::Lost => found = None,
            }
            part *= 0.5;
            // Written so that NaN ends the search.
            let long = part >= FINEST * longest;
            if !long {
                let (open, row, gap) = found?;
                let rows = self.taking_part(time, &x, row)?;
                return Some(Contradiction { times: [time, open], row, gap, rows });
            }
        }
        None
    }

    /// The pose at a time near where the motion was going.
    fn part(&mut self, time: f64, ahead: &[f64]) -> Part {
        let mut state = self.at(time);
        let (kept, all) = (self.kept, self.all);
        let near = |x: &[f64]| x.iter().zip(ahead).all(|(x, ahead)| (x - ahead).abs() <= NEAR);
        let (mut x, mut r) = (ahead.to_vec(), Vec::new());
        let closed = close(&mut self.loops(&mut state, kept), &mut x) <= CLOSED && near(&x);
        self.loops(&mut state, all).residuals(&x, &mut r);
        let most = (0..all.len()).max_by(|&a, &b| r[a].abs().total_cmp(&r[b].abs()));
        if closed && most.is_none_or(|most| r[most].abs() <= OPEN) {
            return Part::Holds(x);
        }
        // Where the independent ones depend on each other, the others tell.
        let mut with_all = ahead.to_vec();
        if close(&mut self.loops(&mut state, all), &mut with_all) <= CLOSED && near(&with_all) {
            return Part::Holds(with_all);
        }
        match most {
            Some(most) if closed => {
                let scale = self.model.program().constraints[all[most]].scale;
                Part::Open(all[most], r[most].abs() * scale)
            }
            _ => Part::Lost,
        }
    }

    /// The loop equations on which one depends in a pose, and that one. None unless the pose is regular.
    fn taking_part(&mut self, time: f64, x: &[f64], row: usize) -> Option<Vec<usize>> {
        let mut state = self.at(time);
        let all = self.all;
        self.loops(&mut state, all).load(x);
        let (model, columns) = (self.model, self.model.mechanical());
        let dense = |rows: &[usize]| {
            let sparse = rows_of(model, &state, rows);
            DMatrix::from_fn(columns, rows.len(), |column, row| sparse[row].get(&column).copied().unwrap_or_default())
        };
        let svd = svd(dense(self.kept), true, true);
        let regular = svd.singular_values.min() > REGULAR;
        let target: DVector<f64> = dense(&[row]).column(0).into_owned();
        let shares = svd.solve(&target, REGULAR).ok().filter(|_| regular)?;
        let least = SHARE * shares.amax();
        let others = self.kept.iter().zip(shares.iter()).filter(|(_, share)| share.abs() > least);
        let mut rows: Vec<usize> = others.map(|(&other, _)| other).chain([row]).collect();
        rows.sort_unstable();
        rows.dedup();
        Some(rows)
    }
}
