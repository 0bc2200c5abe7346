//! Joints that engage at an instant, and rates that an event sets: an impact along loop equations that are no choice.
//!
//! Each is a loop equation that has just begun to hold, J v+ = 0 for a joint and b v+ = value for a rate, with an impulse of either sign. What touches at that instant takes part, by the trials of
//! [`super::contact`], in all of which these equations hold.

use super::contact::{ContactValues, Place};
use crate::constraints::initial::FULFILLED;
use crate::failure::{Failure, LoopGap};
use crate::machine::{CANCELLED, Machine};
use crate::math::maximum;
use crate::model::{Model, State};
use crate::program::{Program, Role};

/// Storage.
#[derive(Clone, Debug)]
pub(crate) struct Joining {
    /// Of each loop equation: true if it begins to hold at this instant by an event.
    rows: Vec<bool>,
    /// True if any does.
    pub any: bool,
    /// What an event finds: the discrete variables before it.
    before: Vec<f64>,
    /// The rates of all loop equations before an impact.
    rates: Vec<f64>,
}

impl Joining {
    pub fn new(program: &Program) -> Self {
        let m = program.constraints.len();
        Self { rows: vec![false; m], any: false, before: vec![0.0; program.discrete.len()], rates: vec![0.0; m] }
    }

    /// To be called before events write.
    pub fn begin(&mut self, state: &State) {
        self.before.copy_from_slice(state.discrete());
    }

    /// To be called when what begins to hold has had its impact.
    pub fn end(&mut self) {
        self.any = false;
    }

    /// True for a discrete variable that an event has just changed from 0.
    pub fn has_begun(&self, state: &State, place: usize) -> bool {
        self.before[place] == 0.0 && state.discrete()[place] != 0.0
    }

    /// Finds what begins to hold, after events have written.
    ///
    /// # Errors
    /// A joint is not in the pose in which it engages.
    pub fn find(&mut self, model: &Model, machine: &mut Machine, state: &State) -> Result<(), Failure> {
        let program = model.program();
        (self.any, _) = (false, self.rows.fill(false));
        for (row, place) in program.masks_by_event() {
            if self.has_begun(state, place) {
                (self.any, self.rows[row]) = (true, true);
            }
        }
        if !self.any {
            return Ok(());
        }
        machine.load(model, state);
        machine.evaluate(&program.tapes.constraint, &mut self.rates);
        let off = self.rates.iter().zip(&program.constraints).zip(&self.rows).find(|((size, row), joins)| {
            let engages = matches!(row.role, Role::Engaging { .. });
            // What is not a number is off.
            let fits = size.abs() <= FULFILLED * row.scale;
            **joins && engages && !fits
        });
        match off {
            None => Ok(()),
            Some(((size, row), _)) => {
                let gap = LoopGap { owner: row.owner.clone(), size: size.abs(), angular: row.is_angle() };
                Err(Failure::Beside { time: state.time(), gap })
            }
        }
    }

    /// The joints and rates that begin to hold.
    pub fn names<'m>(&'m self, program: &'m Program) -> impl Iterator<Item = &'m str> {
        let mut last = "";
        let joining = program.constraints.iter().zip(&self.rows).filter(|(_, joins)| **joins);
        joining.map(|(row, _)| row.owner.as_str()).filter(move |owner| std::mem::replace(&mut last, owner) != *owner)
    }
}

impl ContactValues {
    /// By how much the rates of loop equations fall that begin to hold: to nothing, or to what an event sets.
    pub(super) fn ask_joining(&mut self, context: &mut Place) {
        let Place { model, machine, state, .. } = context;
        let program = model.program();
        if !self.joining.any {
            return;
        }
        machine.load(model, state);
        machine.evaluate(&program.tapes.constraint_rate, &mut self.joining.rates);
        for (row, constraint) in program.constraints.iter().enumerate().filter(|(row, _)| self.joining.rows[*row]) {
            let set = match constraint.role {
                Role::Set { value, .. } => state.discrete()[value as usize],
                Role::Engaging { .. } | Role::Imposed | Role::Repeating | Role::LeftOut | Role::Contact => 0.0,
            };
            self.requested[row] = self.joining.rates[row] + set;
        }
    }

    /// The largest impulse and the largest rate of what begins to hold, and half the work of these impulses: none of what adds energy by itself.
    pub(super) fn joined(&self, context: &Place) -> Joined {
        let mut joined = Joined { impulse: 0.0, rate: 0.0, work: 0.0, is_sound: true };
        if !self.joining.any {
            return joined;
        }
        let (program, n) = (context.model.program(), context.model.coordinates());
        for (row, constraint) in program.constraints.iter().enumerate().filter(|(row, _)| self.joining.rows[*row]) {
            let (impulse, before) = (self.change[n + row], self.joining.rates[row]);
            joined.is_sound &= impulse.is_finite();
            joined.impulse = maximum(joined.impulse, impulse.abs());
            joined.rate = maximum(joined.rate, before.abs());
            let sets = matches!(constraint.role, Role::Set { .. });
            joined.work += if sets { f64::NEG_INFINITY } else { -0.5 * impulse * before };
        }
        joined
    }

    /// Keeps the impulses of what has begun to hold, and the energy that those of each joint take: half of impulse times rate before, since nothing is left of that.
    pub(super) fn keep_joining(&mut self, context: &Place) {
        if !self.joining.any {
            return;
        }
        let (program, n) = (context.model.program(), context.model.coordinates());
        let joining = || program.constraints.iter().enumerate().filter(|(row, _)| self.joining.rows[*row]);
        for (_, constraint) in joining() {
            if let Role::Engaging { lost, .. } = constraint.role {
                self.kept[lost as usize] = 0.0;
            }
        }
        for (row, constraint) in joining() {
            let change = self.change[n + row];
            match constraint.role {
                Role::Engaging { impulse, lost } => {
                    self.kept[impulse as usize] = change;
                    self.kept[lost as usize] += 0.5 * change * self.joining.rates[row];
                }
                Role::Set { impulse, .. } => self.kept[impulse as usize] = change,
                Role::Imposed | Role::Repeating | Role::LeftOut | Role::Contact => {}
            }
        }
    }

    /// Looks whether what begins to hold is independent of everything that cannot give way: contacts open, and friction has a limit.
    ///
    /// # Errors
    /// It is held already.
    pub(super) fn check_joining(&mut self, context: &mut Place) -> Result<(), Failure> {
        if !self.joining.any {
            return Ok(());
        }
        self.kept.copy_from_slice(context.state.discrete());
        self.choices.clear();
        let data = context.data;
        for (index, contact) in data.all.iter().enumerate() {
            match contact.slip {
                Some(_) => context.slide(index, None),
                None => context.close(index, false),
            }
        }
        let is_held = self.are_redundant(context);
        context.state.discrete_mut().copy_from_slice(&self.kept);
        if is_held { Err(context.failure_of(self, HELD_TWICE)) } else { Ok(()) }
    }

    /// True if the loop equations of the present mode depend on each other.
    pub(super) fn are_redundant(&mut self, context: &mut Place) -> bool {
        self.accelerate(context);
        self.twice || !self.solved.iter().all(|value| value.is_finite())
    }

    /// True where something begins to hold if the mode of an impact has redundant equations: their impulses would be rounding errors. Another mode has the same motion.
    pub(super) fn is_joined_twice(&mut self, context: &mut Place) -> bool {
        self.joining.any && self.are_redundant(context)
    }

    /// True unless something begins to hold and what is closed or sticks in its impact has another rate than requested: impulses of equations that depend on each other may be any numbers.
    pub(super) fn is_joined_held(&self, context: &Place, fastest: f64) -> bool {
        let is_held = |index: usize| {
            let requested = self.requested[context.data.all[index].constraint as usize];
            let off = self.rates[index] - (self.before[index] - requested);
            !context.is_closed(index) || off.abs() <= CANCELLED * maximum(fastest, context.scale(index))
        };
        !self.joining.any || self.choices.concerned().all(is_held)
    }

    /// True if everything that takes no share of an impact in which something begins to hold, and yet neither slides nor sticks, is held by other parts.
    pub(super) fn is_joined_idle(&mut self, context: &mut Place) -> bool {
        !self.joining.any || self.is_idle_held(context)
    }

    /// The impact is over: rates that have been set are free again.
    pub(super) fn end_joining(&mut self, context: &mut Place) {
        if !self.joining.any {
            return;
        }
        let program = context.model.program();
        for &(row, place) in &program.instants.masks {
            if matches!(program.constraints[row as usize].role, Role::Set { .. }) {
                context.state.discrete_mut()[place as usize] = 0.0;
            }
        }
    }
}

/// What the impulses of joints that engage, and of rates that are set, are together.
pub(super) struct Joined {
    pub impulse: f64,
    pub rate: f64,
    pub work: f64,
    pub is_sound: bool,
}

const HELD_TWICE: &str = "what engages or is set there is held already, by the loops, by drivers or by what is engaged: its constraints are redundant in this configuration";
