//! What is held on one side only, at an instant: who touches, what an impact does, and what is open or closed after it.
//!
//! Every mode is the same symmetric matrix: the parameter that is 1 while a contact is closed multiplies its loop equation (see [`crate::program::Contacts`]). So the tapes of the program serve
//! all modes, and opening or closing is a number in the state. Nothing here remembers anything but storage.
//!
//! A freewheel is a contact of rates: what must not be negative is the rate of its gap. Open it has no gap (it touches wherever it is), and its rate is its indicator; closed it is held where it
//! stands, for which its gap counts from a held value that is set anew at every instant at which it is open. So a closed freewheel is a closed contact, which drifts no more than others, an
//! open one counts in no projection, and being caught is an impact without a rebound.

use crate::failure::Failure;
use crate::machine::Machine;
use crate::math::maximum;
use crate::model::{Model, State};
use crate::program::Contacts as Data;

/// What is open no further than this share of its scale touches: an instant is found to rounding errors of the motion.
pub(crate) const TOUCHING: f64 = 1e-11;
/// A rate is zero within this share of the rates before an impact, and of those that the accelerations give it.
pub(crate) const RESTING: f64 = 1e-11;
/// What must not be negative may be by this share of its size.
const ROUNDING: f64 = 1e-9;
/// More contacts than these are not decided at once: all their modes are tried.
const MOST_AT_ONCE: usize = 8;
/// A flight that is lower than rounding errors of a gap has no end that can be found: its time is this many times the root of 8 eps L / a.
const SHORTEST_FLIGHT: f64 = 10.0;

/// Storage, and the values at the state that was last looked at.
#[derive(Clone, Debug)]
pub(crate) struct Contacts {
    pub gaps: Vec<f64>,
    pub rates: Vec<f64>,
    accelerations: Vec<f64>,
    restitutions: Vec<f64>,
    /// Changes of rates, then multipliers, of an impact.
    change: Vec<f64>,
    /// a, then lambda.
    solved: Vec<f64>,
    /// By how much the rate of each loop equation has to fall.
    asked: Vec<f64>,
    /// Contacts that take part in an impact, or are undecided.
    concerned: Vec<usize>,
    /// True for contacts that have hit in the last impact.
    pub hit: Vec<bool>,
    /// Rates before the impact.
    before: Vec<f64>,
    rest: Vec<f64>,
    /// Who was closed before the impact, and who does not rebound.
    modes: Vec<bool>,
    /// Who touches, and whose reaction has fallen to zero.
    touches: Vec<bool>,
    leaves: Vec<bool>,
    dead: Vec<bool>,
}

impl Contacts {
    pub fn new(model: &Model) -> Self {
        let (program, count) = (model.program(), model.program().instants.contacts().len());
        let (n, m) = (program.coordinates.len(), program.constraints.len());
        let zeros = || vec![0.0; count];
        Self {
            gaps: zeros(),
            rates: zeros(),
            accelerations: zeros(),
            restitutions: zeros(),
            change: vec![0.0; n + m],
            solved: vec![0.0; n + m],
            asked: vec![0.0; m],
            concerned: Vec::with_capacity(count),
            hit: vec![false; count],
            before: zeros(),
            rest: vec![0.0; n],
            modes: vec![false; count],
            touches: vec![false; count],
            leaves: vec![false; count],
            dead: vec![false; count],
        }
    }

    /// Gaps and their rates; an open freewheel has no gap.
    pub fn measure(&mut self, model: &Model, machine: &mut Machine, state: &State) {
        let Some(data) = &model.program().instants.contacts else { return };
        machine.load(model, state);
        machine.evaluate(&data.gaps, &mut self.gaps);
        machine.evaluate(&data.rates, &mut self.rates);
        open_freewheels(data, state).for_each(|index| self.gaps[index] = 0.0);
    }

    /// What must not be negative of everything that is open, and its rate: gaps, or the rates of freewheels. Reads the state in the registers, and its accelerations if there are freewheels.
    pub fn watch(&mut self, data: &Data, machine: &mut Machine, state: &State) {
        machine.evaluate(&data.gaps, &mut self.gaps);
        machine.evaluate(&data.rates, &mut self.rates);
        if data.all.iter().any(|contact| contact.caught.is_some()) {
            machine.evaluate(&data.accelerations, &mut self.accelerations);
        }
        for index in open_freewheels(data, state) {
            (self.gaps[index], self.rates[index]) = (self.rates[index], self.accelerations[index]);
        }
    }

    /// Open freewheels would be held where they stand now.
    fn follow(&mut self, model: &Model, machine: &mut Machine, state: &mut State) {
        let Some(data) = &model.program().instants.contacts else { return };
        machine.load(model, state);
        machine.evaluate(&data.gaps, &mut self.gaps);
        for (index, contact) in data.all.iter().enumerate() {
            let caught = contact.caught.filter(|_| !is_closed(data, state, index));
            if let Some(caught) = caught {
                state.parameters_mut()[caught as usize] += self.gaps[index];
            }
        }
    }

    /// Lets what touches collide, and decides what is closed afterwards. `turns` says which have been found to change here: open ones touch, wherever the method has taken them to within its
    /// tolerance, and closed ones open if both fit.
    ///
    /// # Errors
    /// No mode fits, or too many contacts are undecided at once.
    pub fn resolve(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        (state, tolerance): (&mut State, f64),
        turns: impl Fn(usize) -> bool,
    ) -> Result<(), Failure> {
        let Some(data) = &model.program().instants.contacts else { return Ok(()) };
        self.follow(model, machine, state);
        self.measure(model, machine, state);
        machine.evaluate(&data.restitutions, &mut self.restitutions);
        self.hit.fill(false);
        self.dead.fill(false);
        self.before.copy_from_slice(&self.rates);
        let context = &mut Place { model, data, machine, state };
        for index in 0..self.gaps.len() {
            let closed = context.is_closed(index);
            self.touches[index] = closed || turns(index) || self.gaps[index] <= TOUCHING * context.scale(index);
            self.leaves[index] = closed && turns(index);
        }
        let hits = |index: usize| {
            let comes = self.rates[index] < -self.least_rate(context, index);
            comes && self.touches[index] && !context.is_closed(index)
        };
        if (0..self.gaps.len()).any(hits) {
            self.collide(context)?;
            self.end_bounces(context, tolerance)?;
        }
        self.decide(context)
    }

    /// Newton's law: those that hit leave with their share of the speed, and whoever touches does not go in. Which impulses press is found by trial, as there is but one set of them that fits
    /// (Glocker 2001, section 8). `dead` ones do not rebound.
    fn collide(&mut self, context: &mut Place) -> Result<(), Failure> {
        self.concerned.clear();
        self.concerned.extend((0..self.gaps.len()).filter(|&index| self.touches[index]));
        if self.concerned.len() > MOST_AT_ONCE {
            return Err(context.failure(&self.concerned, TOO_MANY));
        }
        let count = self.concerned.len();
        (0..self.modes.len()).for_each(|index| self.modes[index] = context.is_closed(index));
        self.rest.copy_from_slice(context.state.rates());
        for trial in (0..1_usize << count).rev() {
            for (place, &index) in self.concerned.iter().enumerate() {
                context.close(index, trial >> place & 1 == 1);
            }
            self.strike(context);
            if self.is_impact(context) {
                self.keep_impulses(context);
                context.restore(&self.modes);
                return Ok(());
            }
            context.state.rates_mut().copy_from_slice(&self.rest);
        }
        context.restore(&self.modes);
        Err(context.failure(&self.concerned, NO_IMPACT))
    }

    /// The rates after an impact of those that are closed.
    fn strike(&mut self, context: &mut Place) {
        self.asked.fill(0.0);
        for &index in &self.concerned {
            let (rate, row) = (self.before[index], context.data.all[index].constraint as usize);
            let rebounds = rate < 0.0 && !self.dead[index];
            let share = if rebounds { self.restitutions[index] } else { 0.0 };
            self.asked[row] = (1.0 + share) * rate;
        }
        let Place { model, data, machine, state } = context;
        machine.load(model, state);
        machine.load_reactions(model, &self.asked);
        machine.evaluate(&data.impact, &mut self.change);
        for (rate, change) in state.rates_mut().iter_mut().zip(&self.change) {
            *rate += change;
        }
        machine.load(model, state);
        machine.evaluate(&data.rates, &mut self.rates);
    }

    /// True if every impulse presses, nobody who touches goes in further than it may, and no energy has come from anywhere: sum of impulse x mean rate is not positive.
    fn is_impact(&self, context: &Place) -> bool {
        let impulses = &self.change[context.model.coordinates()..];
        let impulse = |index: usize| -impulses[context.data.all[index].constraint as usize];
        let largest = self.concerned.iter().fold(0.0, |most, &index| maximum(most, impulse(index).abs()));
        let fastest = self.concerned.iter().fold(0.0, |most, &index| maximum(most, self.before[index].abs()));
        let (mut energy, mut size) = (0.0, 0.0);
        for &index in &self.concerned {
            let (rate, impulse) = (self.rates[index], impulse(index));
            if !rate.is_finite() || !impulse.is_finite() {
                return false;
            }
            let fits = match context.is_closed(index) {
                true => impulse >= -ROUNDING * largest,
                false => rate >= -ROUNDING * fastest,
            };
            if !fits {
                return false;
            }
            energy += 0.5 * impulse * (rate + self.before[index]);
            size += impulse.abs() * fastest;
        }
        energy <= ROUNDING * size
    }

    fn keep_impulses(&mut self, context: &mut Place) {
        let n = context.model.coordinates();
        for &index in &self.concerned {
            let impulse = -self.change[n + context.data.all[index].constraint as usize];
            if context.is_closed(index) && impulse > 0.0 && self.before[index] < 0.0 {
                self.hit[index] = true;
                context.state.parameters_mut()[context.data.all[index].closed as usize + 1] = impulse;
            }
        }
    }

    /// A series of ever shorter bounces ends here where the next flight would last less than `tolerance` of the time in which a fall takes a scale: what is left out is lower than the square of
    /// that, and the impulse of the closing keeps what the flights would have kept.
    fn end_bounces(&mut self, context: &mut Place, tolerance: f64) -> Result<(), Failure> {
        self.accelerate(context);
        for index in (0..self.gaps.len()).filter(|&index| self.hit[index]) {
            let (rate, acceleration, scale) = (self.rates[index], self.accelerations[index], context.scale(index));
            let fall = (scale / acceleration.abs()).sqrt();
            let shortest = maximum(tolerance, SHORTEST_FLIGHT * (8.0 * f64::EPSILON).sqrt()) * fall;
            self.dead[index] = acceleration < 0.0 && 2.0 * rate < shortest * acceleration.abs();
        }
        if self.dead.contains(&true) {
            // The same impact again, from the rates before it.
            context.state.rates_mut().copy_from_slice(&self.rest);
            self.collide(context)?;
        }
        Ok(())
    }

    /// Which of those that touch and do not move apart are closed: the only modes in which what is open does not go in, and what is closed presses.
    fn decide(&mut self, context: &mut Place) -> Result<(), Failure> {
        self.measure(context.model, context.machine, context.state);
        self.concerned.clear();
        for index in 0..self.gaps.len() {
            context.close(index, false);
            if self.touches[index] && self.rates[index].abs() <= self.least_rate(context, index) {
                self.concerned.push(index);
            }
        }
        let count = self.concerned.len();
        if count > MOST_AT_ONCE {
            return Err(context.failure(&self.concerned, TOO_MANY));
        }
        // Where something begins to push or to move, it is less than rounding errors of what is usual.
        for begins in [true, false] {
            for trial in 0..1_usize << count {
                for (place, &index) in self.concerned.iter().enumerate() {
                    context.close(index, (trial >> place & 1 == 1) == self.leaves[index]);
                }
                self.accelerate(context);
                if self.is_mode(context, begins) {
                    return Ok(());
                }
            }
        }
        Err(context.failure(&self.concerned, NO_MODE))
    }

    /// True if what is open does not go in, and what is closed presses, within rounding errors: of the accelerations that there are if something may only begin to move, else of usual ones.
    fn is_mode(&self, context: &Place, begins: bool) -> bool {
        let reactions = &self.solved[context.model.coordinates()..];
        let reaction = |index: usize| reactions[context.data.all[index].constraint as usize];
        let largest = self.concerned.iter().fold(0.0, |most, &index| maximum(most, reaction(index).abs()));
        let fastest = self.concerned.iter().fold(0.0, |most, &index| maximum(most, self.accelerations[index].abs()));
        self.solved.iter().all(|value| value.is_finite())
            && self.concerned.iter().all(|&index| match context.is_closed(index) {
                true => reaction(index) <= ROUNDING * largest,
                false => self.accelerations[index] >= -ROUNDING * if begins { fastest } else { context.scale(index) },
            })
    }

    /// Accelerations and reactions in the present mode, and the second derivatives of the gaps.
    fn accelerate(&mut self, context: &mut Place) {
        let Place { model, data, machine, state } = context;
        machine.load(model, state);
        machine.evaluate(&model.program().tapes.acceleration, &mut self.solved);
        machine.load_accelerations(model, &self.solved[..model.coordinates()]);
        machine.evaluate(&data.accelerations, &mut self.accelerations);
    }

    /// A rate of a gap that is rounding errors.
    fn least_rate(&self, context: &Place, index: usize) -> f64 {
        let fastest = self.before.iter().chain(&self.rates).fold(0.0, |most, rate| maximum(most, rate.abs()));
        RESTING * maximum(fastest, context.scale(index))
    }
}

/// Where something is decided.
struct Place<'a> {
    model: &'a Model,
    data: &'a Data,
    machine: &'a mut Machine,
    state: &'a mut State,
}

const TOO_MANY: &str = "more than eight contacts are undecided at once";
const NO_IMPACT: &str = "no impulses fit their impact: together with the loops they hold something twice";
const NO_MODE: &str = "neither open nor closed fits the motion: together with the loops they hold something twice";

impl Place<'_> {
    fn scale(&self, index: usize) -> f64 {
        self.model.program().constraints[self.data.all[index].constraint as usize].scale
    }

    fn is_closed(&self, index: usize) -> bool {
        is_closed(self.data, self.state, index)
    }

    fn close(&mut self, index: usize, closed: bool) {
        self.state.parameters_mut()[self.data.all[index].closed as usize] = f64::from(u8::from(closed));
    }

    fn restore(&mut self, modes: &[bool]) {
        modes.iter().enumerate().for_each(|(index, &closed)| self.close(index, closed));
    }

    fn failure(&self, concerned: &[usize], why: &'static str) -> Failure {
        let names = concerned.iter().map(|&index| self.data.all[index].name.clone()).collect();
        Failure::Contact { time: self.state.time(), names, why }
    }
}

/// Freewheels that are open in a state.
fn open_freewheels(data: &Data, state: &State) -> impl Iterator<Item = usize> {
    (0..data.all.len()).filter(|&index| data.all[index].caught.is_some() && !is_closed(data, state, index))
}

/// True while a contact is closed in a state.
pub(crate) fn is_closed(data: &Data, state: &State, index: usize) -> bool {
    state.parameters()[data.all[index].closed as usize] != 0.0
}
