//! What is held on one side only or sticks, at an instant: who touches, what an impact does, and what is open or closed, sticks or slips after it.
//!
//! Every mode is the same symmetric matrix: the discrete variable that is 1 while a contact is closed, or something sticks, multiplies its loop equation (see [`crate::program::Contacts`]). So the tapes of
//! the program serve all modes, and a change of mode is a number in the state. Nothing here remembers anything but storage.
//!
//! A freewheel is a contact of rates: what must not be negative is the rate of its gap. Open it has no gap (it touches wherever it is), and its rate is its indicator; closed it is held where it
//! stands, for which its gap counts from a discrete variable that is set anew at every instant at which it is open; what sticks is held in the same way. So a closed freewheel is a closed contact, which
//! drifts no more than others, an open one counts in no projection, and being caught is an impact without a rebound.

use super::ahead::{Ahead, TIMES_AHEAD};
use super::engage::Joining;
use super::islands::Division;
use super::modes::{Choices, MOST_TRIALS};
use crate::constraints::reciprocals::{is_within, read};
use crate::failure::Failure;
use crate::machine::{CANCELLED, Machine};
use crate::math::maximum;
use crate::model::{Model, State};
use crate::program::{Contact, Contacts, Coordinate, Instants, Slip};
use crate::tape::Tape;
use crate::taylor::TapeAlong;

/// What is open no further than this share of its scale touches: an instant is found to rounding errors of the motion. A rate is zero within the same share of the rates before an impact, and
/// of those that the accelerations give it.
pub(crate) const TOUCHING: f64 = 1e-11;
/// Forces within a step are known to so many tolerances of what is usual.
pub(crate) const FOUND: f64 = 10.0;
/// Loop equations that are so close to depending on each other hold something twice: what sticks does so in one of several places, of which rounding errors would choose. A share of the size of a row
/// before elimination, in the measure of the mass: in SI units a pivot of wheels of 50 g is larger than that of wheels of a ton by the ratio of their masses.
const TWICE: f64 = 1e-6;
/// Impacts at one instant that follow each other: as often a ball between two others loses its speed to rounding errors.
const MOST_ROUNDS: usize = 1000;
/// A flight that is lower than rounding errors of a gap has no end that can be found: its time is this many times the root of 8 eps L / a.
const SHORTEST_FLIGHT: f64 = 10.0;

/// Impulses at an instant that have changed the rates.
#[derive(Clone, Debug)]
pub struct Impact {
    /// The discrete variables, with what is closed, sticks and slips while they act.
    pub discrete: Vec<f64>,
    /// True for contacts that rebound.
    pub rebounds: Vec<bool>,
    /// True for contacts and friction that could be in another mode.
    pub undecided: Vec<bool>,
}

/// Storage, and the values at the state that was last looked at.
#[derive(Clone, Debug)]
pub(crate) struct ContactValues {
    pub gaps: Vec<f64>,
    pub rates: Vec<f64>,
    /// The gaps along a step, if they have polynomials.
    pub gaps_along: Option<TapeAlong>,
    /// If there is friction: the rates of sliding along a step, and whether the ratios of static to kinetic limits stay as they are within one.
    pub rates_along: Option<TapeAlong>,
    pub has_constant_ratios: bool,
    /// How long each gap seems to stay open, in steps.
    pub flights: Vec<f64>,
    pub accelerations: Vec<f64>,
    /// Of what slips: its level at rest by that while it slips.
    pub restitutions: Vec<f64>,
    /// The sums whose sizes press.
    pub sums: Vec<f64>,
    /// The same without accelerations and reactions.
    at_rest: Vec<f64>,
    pub locks: Vec<f64>,
    /// 1 / r^2 of the loop equations, and the sizes of r^2 before elimination.
    reciprocals: Vec<f64>,
    row_sizes: Vec<f64>,
    /// Changes of rates, then multipliers, of an impact.
    pub(super) change: Vec<f64>,
    /// a, then lambda.
    pub(super) solved: Vec<f64>,
    /// By how much the rate of each loop equation has to fall.
    pub(super) requested: Vec<f64>,
    /// What is undecided, and by which islands it is decided.
    pub(super) choices: Choices,
    pub(super) division: Division,
    /// Where a mode leads.
    pub(super) ahead: Ahead,
    /// True for contacts that have hit in the last impact.
    pub hit: Vec<bool>,
    /// True for contacts that take part in the last impact.
    pub pressing: Vec<bool>,
    /// The impacts of the present instant, one after the other, if they are recorded.
    pub impacts: Option<Vec<Impact>>,
    /// Rates before the impact.
    pub(super) before: Vec<f64>,
    pub(super) rest: Vec<f64>,
    /// The discrete variables, with all modes, before something was tried, and before all.
    pub(super) kept: Vec<f64>,
    began: Vec<f64>,
    /// The tolerance of the motion.
    tolerance: f64,
    /// True if what is held in the present mode is held twice.
    pub(super) twice: bool,
    /// How often accelerations have been found or an impact tried.
    pub trials: u64,
    /// Who touches; who has been found to open, or to slip.
    touches: Vec<bool>,
    leaves: Vec<bool>,
    dead: Vec<bool>,
    /// Who touches, while only some of them collide.
    touching: Vec<bool>,
    /// True for open contacts whose gaps others keep at zero (see [`super::redundant`]).
    pub redundant: Vec<bool>,
    /// Accelerations to compare others with.
    pub(super) reference: Vec<f64>,
    /// Joints that engage, and rates that are set.
    pub joining: Joining,
}

impl ContactValues {
    pub fn new(model: &Model) -> Self {
        let (program, count) = (model.program(), model.program().instants.contacts().len());
        let (n, m) = (program.coordinates.len(), program.constraints.len());
        let results = |of: fn(&Contacts) -> usize| program.instants.contacts.as_ref().map_or(0, of);
        let (sums, locks) = (results(|data| data.pressing.results.len()), results(|data| data.locks.results.len()));
        let zeros = || vec![0.0; count];
        let along = |tape: fn(&Contacts) -> &Tape, wanted: fn(&Contacts) -> bool| {
            let data = program.instants.contacts.as_ref().filter(|data| wanted(data))?;
            TapeAlong::new(model.layout(), tape(data))
        };
        let has_friction = |data: &Contacts| data.all.iter().any(|contact| contact.slip.is_some());
        Self {
            rates_along: along(|data| &data.rates, has_friction),
            has_constant_ratios: along(|data| &data.restitutions, has_friction)
                .is_some_and(|ratios| (0..count).all(|index| ratios.is_constant(index))),
            gaps: zeros(),
            rates: zeros(),
            flights: zeros(),
            gaps_along: along(|data| &data.gaps, |_| true),
            accelerations: zeros(),
            restitutions: zeros(),
            sums: vec![0.0; sums],
            at_rest: vec![0.0; sums],
            locks: vec![0.0; locks],
            reciprocals: vec![0.0; program.tapes.reciprocal_pivots.len()],
            row_sizes: vec![0.0; results(|data| data.row_sizes.results.len())],
            change: vec![0.0; n + m],
            solved: vec![0.0; n + m],
            requested: vec![0.0; m],
            choices: Choices::with_capacity(count + sums),
            division: Division::new(model, count + sums),
            ahead: Ahead::new(model, count),
            hit: vec![false; count],
            pressing: vec![false; count],
            impacts: None,
            before: zeros(),
            rest: vec![0.0; n],
            kept: vec![0.0; program.discrete.len()],
            began: vec![0.0; program.discrete.len()],
            tolerance: 0.0,
            twice: false,
            trials: 0,
            touches: vec![false; count],
            leaves: vec![false; count],
            dead: vec![false; count],
            touching: vec![false; count],
            redundant: vec![false; count],
            reference: vec![0.0; n],
            joining: Joining::new(program),
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
    pub fn watch(&mut self, data: &Contacts, machine: &mut Machine, state: &State) {
        machine.evaluate(&data.gaps, &mut self.gaps);
        machine.evaluate(&data.rates, &mut self.rates);
        if data.all.iter().any(|contact| contact.of_rate) {
            machine.evaluate(&data.accelerations, &mut self.accelerations);
        }
        for index in open_freewheels(data, state) {
            (self.gaps[index], self.rates[index]) = (self.rates[index], self.accelerations[index]);
        }
    }

    /// What is held wherever it stands would be held where it stands now.
    fn follow(&mut self, model: &Model, machine: &mut Machine, state: &mut State) {
        let Some(data) = &model.program().instants.contacts else { return };
        if data.all.iter().all(|contact| contact.state.place.is_none()) {
            return;
        }
        machine.load(model, state);
        machine.evaluate(&data.gaps, &mut self.gaps);
        for (index, contact) in data.all.iter().enumerate() {
            if let Some(place) = contact.state.place.filter(|_| !is_closed(data, state, index)) {
                state.discrete_mut()[place as usize] += self.gaps[index];
            }
        }
    }

    /// Lets what touches collide, and decides what is closed and what sticks afterwards. `turns` says which have been found to change here: open ones touch, wherever the method has taken them to
    /// within its tolerance, closed ones open if both fit, and what sticks slips; then the signs of what presses.
    ///
    /// # Errors
    /// No mode fits, or too many are possible at once.
    pub fn resolve(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        (state, [tolerance, shortest]): (&mut State, [f64; 2]),
        turns: impl Fn(usize) -> bool,
    ) -> Result<(), Failure> {
        let Some(data) = &model.program().instants.contacts else { return Ok(()) };
        self.follow(model, machine, state);
        self.began.copy_from_slice(state.discrete());
        self.measure(model, machine, state);
        machine.evaluate(&data.restitutions, &mut self.restitutions);
        self.hit.fill(false);
        self.dead.fill(false);
        self.impacts.iter_mut().for_each(Vec::clear);
        self.tolerance = tolerance;
        self.before.copy_from_slice(&self.rates);
        let context = &mut Place { model, data, machine, state };
        for index in 0..self.gaps.len() {
            let (closed, is_contact) = (context.is_closed(index), context.slip(index).is_none());
            let is_near = self.gaps[index] <= TOUCHING * context.scale(index);
            self.touches[index] = is_contact && (closed || turns(index) || is_near);
            self.leaves[index] = closed && turns(index);
        }
        self.check_joining(context)?;
        if self.comes(context) || self.joining.any {
            self.collide_all(context)?;
            self.end_bounces(context, shortest)?;
        }
        self.end_joining(context);
        self.decide(context, turns)
    }

    /// True if anything that touches and is open comes nearer.
    fn comes(&self, context: &Place) -> bool {
        let hits = |index: usize| {
            let touches = self.touches[index] && !context.is_closed(index);
            touches && self.rates[index] < -self.least_rate(context, index)
        };
        (0..self.gaps.len()).any(hits)
    }

    /// What touches collides at once. Where no such impulses exist, those that move apart take no part, or a freewheel and a rebounding stop collide one after the other: then as often as what
    /// touches still comes nearer. Without friction, and with one restitution, those that do not move apart always have impulses, which take energy (Glocker 2001, section 8).
    fn collide_all(&mut self, context: &mut Place) -> Result<(), Failure> {
        let Err(failure) = self.collide(context) else { return Ok(()) };
        self.touching.copy_from_slice(&self.touches);
        for _ in 0..MOST_ROUNDS {
            self.measure(context.model, context.machine, context.state);
            self.before.copy_from_slice(&self.rates);
            for index in 0..self.touches.len() {
                self.touches[index] = self.touching[index] && self.rates[index] <= self.least_rate(context, index);
            }
            let done = self.collide(context).or_else(|failure| {
                self.leave_freewheels(context).then_some(()).ok_or(failure)?;
                self.collide(context)
            });
            self.touches.copy_from_slice(&self.touching);
            if done.is_err() {
                return Err(failure);
            }
            if !self.comes(context) {
                return Ok(());
            }
        }
        Err(failure)
    }

    /// Open freewheels take no part for now; false if there are none.
    fn leave_freewheels(&mut self, context: &Place) -> bool {
        let mut any = false;
        for index in 0..self.touches.len() {
            if self.touches[index] && context.data.all[index].of_rate && !context.is_closed(index) {
                (self.touches[index], any) = (false, true);
            }
        }
        any
    }

    /// True if something has hit, or is in another mode than before.
    pub fn has_changed(&self, data: &Contacts, state: &State, index: usize) -> bool {
        let contact = &data.all[index];
        let same = |place: u32| self.began[place as usize] == state.discrete()[place as usize];
        self.hit[index]
            || !same(contact.state.closed)
            || contact.state.direction.is_some_and(|direction| !same(direction))
    }

    /// Newton's law: those that hit leave with their share of the speed, and whoever touches does not go in. Coulomb's law for impulses: what rubs there sticks, or slips against no more than mu
    /// times the impulse that presses. Which impulses press, and what slips, is found by trial (Glocker 2001, section 8). `dead` ones do not rebound.
    fn collide(&mut self, context: &mut Place) -> Result<(), Failure> {
        self.kept.copy_from_slice(context.state.discrete());
        self.rest.copy_from_slice(context.state.rates());
        self.list_of_impact(context);
        let found =
            self.by_islands(context, Self::find_impact, Self::is_impact_of_all, |values, index| values.rates[index])?;
        if found {
            self.keep_impulses(context);
            self.record(context);
            (0..self.pressing.len()).for_each(|index| self.pressing[index] = context.is_closed(index));
        }
        context.state.discrete_mut().copy_from_slice(&self.kept);
        if found { Ok(()) } else { Err(context.failure_of(self, NO_IMPACT)) }
    }

    /// Tries impulses up to those that solve an impact, and leaves the rates after it; of a part of what collides at once the modes only. False if none do.
    fn find_impact(&mut self, context: &mut Place) -> Result<bool, Failure> {
        let trials = self.choices.trials();
        if trials > MOST_TRIALS {
            return Err(context.failure_of(self, TOO_MANY));
        }
        for trial in 0..trials {
            if self.choices.set(trial, context.data, context.state.discrete_mut()) && !self.is_joined_twice(context) {
                self.strike(context);
                let found = self.is_impact(context) && self.is_joined_idle(context);
                if !found || self.division.is_part {
                    context.state.rates_mut().copy_from_slice(&self.rest);
                }
                if found {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// The impact in the modes that islands have been found to have.
    fn is_impact_of_all(&mut self, context: &mut Place) -> bool {
        self.strike(context);
        let found = self.is_impact(context);
        if !found {
            context.state.rates_mut().copy_from_slice(&self.rest);
        }
        found
    }

    /// Records the impact that has been tried last, if they are recorded.
    fn record(&mut self, context: &Place) {
        let Some(impacts) = &mut self.impacts else { return };
        let count = self.gaps.len();
        impacts.push(Impact {
            discrete: context.state.discrete().to_vec(),
            rebounds: (0..count).map(|index| rebounds(context, &self.before, &self.dead, index)).collect(),
            undecided: (0..count).map(|index| self.choices.includes(index)).collect(),
        });
    }

    /// Who takes part in an impact. A level that does not follow from reactions has no impulse.
    fn list_of_impact(&mut self, context: &mut Place) {
        self.choices.clear();
        for index in (0..self.gaps.len()).filter(|&index| self.touches[index]) {
            // What a joint that engages takes along needs no impulse: with friction it may have one in which it jams, too.
            self.choices.contact(index, !self.joining.any);
        }
        for index in 0..self.gaps.len() {
            let data = context.data;
            let Some(slip) = &data.all[index].slip else { continue };
            let touches = slip.on.is_none_or(|on| self.touches[on as usize]);
            if !slip.follows || !touches {
                data.all[index].slips(context.state.discrete_mut(), None);
                continue;
            }
            let rate = self.before[index];
            let is_slow = rate.abs() <= self.least_rate(context, index);
            let likely = if is_slow { [0.0, 1.0, -1.0] } else { [rate.signum(), 0.0, -rate.signum()] };
            match self.joining.any {
                true => self.choices.joined(index, likely),
                false => self.choices.slip(index, likely),
            }
            for &sign in &data.all[index].state.signs {
                self.choices.sign(index, sign, context.state.discrete()[sign as usize]);
            }
        }
    }

    /// The rates after an impact of those that are closed.
    fn strike(&mut self, context: &mut Place) {
        self.trials += 1;
        self.requested.fill(0.0);
        for (index, contact) in context.data.all.iter().enumerate() {
            let is_back = rebounds(context, &self.before, &self.dead, index);
            let share = if is_back { self.restitutions[index] } else { 0.0 };
            self.requested[contact.constraint as usize] = (1.0 + share) * self.before[index];
        }
        self.ask_joining(context);
        self.apply_impulses(context);
        let Place { model, data, machine, .. } = context;
        if self.sums.is_empty() {
            return;
        }
        let n = model.coordinates();
        for (values, factor) in [(&mut self.at_rest, 0.0), (&mut self.sums, 1.0)] {
            self.solved.iter_mut().zip(&self.change).for_each(|(solved, change)| *solved = factor * change);
            machine.load_accelerations(model, &self.solved[..n]);
            machine.load_reactions(model, &self.solved[n..]);
            machine.evaluate(&data.pressing, values);
        }
        // Only what follows from impulses counts.
        self.sums.iter_mut().zip(&self.at_rest).for_each(|(sum, rest)| *sum -= rest);
    }

    /// True if every impulse presses, nobody who touches goes in further than it may, what slips does so against its friction, and no energy has come from anywhere: sum of impulse x mean rate is
    /// not positive.
    fn is_impact(&self, context: &Place) -> bool {
        let multipliers = &self.change[context.model.coordinates()..];
        let concerned = || self.choices.concerned();
        let joined = self.joined(context);
        let largest =
            concerned().fold(joined.impulse, |most, index| maximum(most, context.force(index, multipliers).abs()));
        let fastest = concerned().fold(joined.rate, |most, index| maximum(most, self.before[index].abs()));
        let (mut energy, mut size) = (joined.work, joined.impulse * fastest);
        if !joined.is_sound || !context.state.rates().iter().all(|rate| rate.is_finite()) {
            return false;
        }
        for index in concerned() {
            let (rate, impulse) = (self.rates[index], context.force(index, multipliers));
            if !rate.is_finite() || !impulse.is_finite() {
                return false;
            }
            let fits = match (context.slip(index), context.is_closed(index)) {
                (None, true) => impulse >= -CANCELLED * largest,
                (None, false) => rate >= -CANCELLED * fastest,
                (Some(_), sticks) => {
                    let level = context.level(index, multipliers);
                    let direction = context.direction(index);
                    let holds = if sticks { impulse.abs() <= level + CANCELLED * largest } else { true };
                    holds && level >= -CANCELLED * largest && direction * rate >= -CANCELLED * fastest
                }
            };
            if !fits {
                return false;
            }
            energy += 0.5 * impulse * (rate + self.before[index]);
            size += impulse.abs() * fastest;
        }
        energy <= CANCELLED * size && self.have_signs(context, largest) && self.is_joined_held(context, fastest)
    }

    /// True if what presses has the signs that are assumed.
    fn have_signs(&self, context: &Place, largest: f64) -> bool {
        let rubbing = context.data.all.iter().enumerate();
        let rubbing = rubbing.filter_map(|(index, contact)| Some((index, contact, contact.slip.as_ref()?)));
        rubbing.into_iter().filter(|(index, ..)| self.is_concerned(*index)).all(|(_, contact, slip)| {
            let sums = self.sums[slip.sums as usize..].iter();
            contact.state.signs.iter().zip(sums).all(|(&sign, sum)| {
                context.state.discrete()[sign as usize] * sum >= -CANCELLED * maximum(largest, sum.abs())
            })
        })
    }

    fn keep_impulses(&mut self, context: &Place) {
        self.keep_joining(context);
        let multipliers = &self.change[context.model.coordinates()..];
        for index in self.choices.concerned().filter(|&index| context.slip(index).is_none()) {
            let impulse = context.force(index, multipliers);
            if context.is_closed(index) && impulse > 0.0 && self.before[index] < 0.0 {
                self.hit[index] = true;
                self.kept[context.data.all[index].state.impulse as usize] = impulse;
            }
        }
    }

    /// A series of ever shorter bounces ends here where the next flight would last less than the share `shortest` of the time in which a fall takes a scale: what is left out is lower than the square of
    /// that, and the impulse of the closing keeps what the flights would have kept.
    fn end_bounces(&mut self, context: &mut Place, shortest: f64) -> Result<(), Failure> {
        self.accelerate_after(context);
        for index in 0..self.gaps.len() {
            let (rate, acceleration, scale) = (self.rates[index], self.accelerations[index], context.scale(index));
            let fall = (scale / acceleration.abs()).sqrt();
            let shortest = maximum(shortest, SHORTEST_FLIGHT * (8.0 * f64::EPSILON).sqrt()) * fall;
            let flies = self.hit[index] || self.leaves_by_impact(context, index);
            self.dead[index] = flies && acceleration < 0.0 && 2.0 * rate < shortest * acceleration.abs();
        }
        if (0..self.gaps.len()).any(|index| self.dead[index] && self.hit[index]) {
            // The same impact again, from the rates before it.
            self.impacts.iter_mut().for_each(|impacts| drop(impacts.pop()));
            context.state.rates_mut().copy_from_slice(&self.rest);
            self.collide_all(context)?;
        }
        if (0..self.gaps.len()).any(|index| self.dead[index] && self.leaves_by_impact(context, index)) {
            self.bring_to_rest(context);
        }
        Ok(())
    }

    /// True for what touches and moves apart after an impact of something else.
    fn leaves_by_impact(&self, context: &Place, index: usize) -> bool {
        let is_contact = context.slip(index).is_none() && !context.data.all[index].of_rate;
        is_contact && self.touches[index] && self.rates[index] > self.least_rate(context, index)
    }

    /// Accelerations after an impact, as far as its rates tell them: whoever moves apart is open, whoever has hit without a rebound is closed.
    fn accelerate_after(&mut self, context: &mut Place) {
        for index in 0..self.gaps.len() {
            let opens = self.leaves_by_impact(context, index);
            let stays = self.pressing[index] && self.hit[index] && self.rates[index] <= self.least_rate(context, index);
            if opens || stays {
                context.close(index, stays);
            }
        }
        self.accelerate(context);
        context.state.discrete_mut().copy_from_slice(&self.kept);
    }

    /// Impacts that pass a motion from one contact to another and back, as a rocking block's, end here where the flights between them would be too short: what moves apart by less rests, and what
    /// touches without a rebound goes on resting. What the impulses would take until then is taken at once, whichever sign that has.
    fn bring_to_rest(&mut self, context: &mut Place) {
        for index in 0..self.gaps.len() {
            let is_contact = context.slip(index).is_none() && self.touches[index];
            let rests = self.rates[index].abs() <= self.least_rate(context, index);
            if is_contact {
                context.close(index, rests || self.dead[index]);
            }
        }
        self.before.copy_from_slice(&self.rates);
        self.rest.copy_from_slice(context.state.rates());
        self.strike(context);
        if context.state.rates().iter().all(|rate| rate.is_finite()) {
            self.choices.clear();
            self.record(context);
        }
        context.state.discrete_mut().copy_from_slice(&self.kept);
        if !context.state.rates().iter().all(|rate| rate.is_finite()) {
            // Together they hold something twice: they go on one after the other.
            context.state.rates_mut().copy_from_slice(&self.rest);
            self.measure(context.model, context.machine, context.state);
        }
    }

    /// Which of those that touch and do not move apart are closed, and what sticks or slips. What has been found to slip does so, unless no such mode fits: what only touches its level stays.
    fn decide(&mut self, context: &mut Place, turns: impl Fn(usize) -> bool) -> Result<(), Failure> {
        self.measure(context.model, context.machine, context.state);
        self.kept.copy_from_slice(context.state.discrete());
        self.halt(context, &turns);
        self.redundant.fill(false);
        if self.choose(context, &turns)? {
            return Ok(());
        }
        let slips = |(index, contact): (usize, &Contact)| contact.slip.is_some() && turns(index);
        let any_slips = context.data.all.iter().enumerate().any(slips);
        if any_slips && self.choose(context, |_| false).unwrap_or(false) {
            return Ok(());
        }
        self.list_of_modes(context, &turns);
        context.state.discrete_mut().copy_from_slice(&self.kept);
        Err(context.failure(&self.choices, NO_MODE))
    }

    /// What has been found to turn has no rate here, to within the errors of the method: neither has what moves with it. Then rounding errors tell what rests.
    fn halt(&mut self, context: &mut Place, turns: impl Fn(usize) -> bool) {
        if self.has_impact() {
            return;
        }
        for index in 0..self.rates.len() {
            let direction = context.direction(index);
            let turned = direction != 0.0 && turns(index) && context.rubs(index);
            if turned && self.rates[index].abs() > self.least_rate(context, index) {
                self.rest.copy_from_slice(context.state.rates());
                context.slide(index, Some(0.0));
                self.stop_closed(context);
                context.slide(index, Some(direction));
            }
        }
    }

    /// Takes the rates of everything that is closed away, as an impact without restitution would, unless they are more than the errors of the method.
    fn stop_closed(&mut self, context: &mut Place) {
        self.trials += 1;
        let errors = self.found();
        for (index, contact) in context.data.all.iter().enumerate() {
            let closed = context.is_closed(index);
            self.requested[contact.constraint as usize] = if closed { self.rates[index] } else { 0.0 };
        }
        self.apply_impulses(context);
        // Where a slider turns while its crank goes on, the change of what moves with it is no error.
        let is_error = |(change, coordinate): (&f64, &Coordinate)| change.abs() <= errors * coordinate.scale;
        if !self.change.iter().zip(&context.model.program().coordinates).all(is_error) {
            context.state.rates_mut().copy_from_slice(&self.rest);
            self.find_rates(context);
        }
    }

    /// Changes the rates by the impulses that take those of `asked` away from the constraints.
    pub(super) fn apply_impulses(&mut self, context: &mut Place) {
        let Place { model, data, machine, state } = context;
        machine.load(model, state);
        machine.load_reactions(model, &self.requested);
        machine.evaluate(&data.impact, &mut self.change);
        for (rate, change) in state.rates_mut().iter_mut().zip(&self.change) {
            *rate += change;
        }
        self.find_rates(context);
    }

    /// The rates of gaps and frictions in the present state.
    pub(super) fn find_rates(&mut self, context: &mut Place) {
        context.machine.load(context.model, context.state);
        context.machine.evaluate(&context.data.rates, &mut self.rates);
    }

    /// The modes in which what is open does not go in, what is closed presses, what sticks does so by no more than its level, and what begins to slip goes on. Of several that fit where margins
    /// are zero, it is the one that the motion does not leave: the rates of these margins tell (see [`Ahead`]). One with redundant constraints is taken only where no other fits. False if none fits.
    fn choose(&mut self, context: &mut Place, turns: impl Fn(usize) -> bool) -> Result<bool, Failure> {
        self.list_of_modes(context, turns);
        self.by_islands(context, Self::find_mode, Self::is_mode_of_all, |values, index| values.accelerations[index])
    }

    /// Tries all modes of what is undecided, and leaves the one that is chosen. False if none fits.
    fn find_mode(&mut self, context: &mut Place) -> Result<bool, Failure> {
        if self.choices.trials() > MOST_TRIALS {
            return Err(context.failure(&self.choices, TOO_MANY));
        }
        let mut found = Found::default();
        self.try_modes(context, false, &mut found);
        if found.best.is_none() && found.redundant {
            self.try_modes(context, true, &mut found);
        }
        if let Some(mode) = found.best {
            return self.accept(context, mode, &found).map(|()| true);
        }
        context.state.discrete_mut().copy_from_slice(&self.kept);
        if found.locked { Err(context.jam(&self.choices, found.jammed)) } else { Ok(false) }
    }

    /// True if the modes of all islands fit together.
    fn is_mode_of_all(&mut self, context: &mut Place) -> bool {
        self.accelerate(context);
        self.is_mode(context, false)
    }

    /// Tries all modes, those with redundant constraints or the others, up to one that lasts.
    fn try_modes(&mut self, context: &mut Place, redundant: bool, found: &mut Found) {
        let trials = self.choices.trials();
        // Where something begins to push or to move, it is less than rounding errors of what is usual.
        for (begins, trial) in
            [true, false].into_iter().flat_map(|begins| (0..trials).map(move |trial| (begins, trial)))
        {
            found.tried[usize::from(begins)] = trial + 1;
            if !self.choices.set(trial, context.data, context.state.discrete_mut()) {
                continue;
            }
            self.accelerate(context);
            found.jams[usize::from(begins)] |= self.is_locked() && self.is_mode(context, begins);
            if !self.fits(context, begins) || self.twice && self.any_sticks(context) {
                continue;
            }
            if self.twice != redundant {
                found.redundant |= self.twice;
                continue;
            }
            if self.is_locked() {
                found.locked = true;
                found.jammed = self.locks.iter().position(|&lock| lock.is_nan() || lock <= 0.0);
                continue;
            }
            if !self.is_idle_held(context) {
                continue;
            }
            let mode = Mode { trial, begins, lasts: self.lasts(context), moving: self.count_moving(context) };
            if found.best.is_none_or(|best| mode.is_better(&best)) {
                found.best = Some(mode);
            }
            if mode.lasts == TIMES_AHEAD && mode.moving == 0 {
                found.is_present = found.best.is_some_and(|best| best.trial == trial);
                return;
            }
        }
    }

    /// Takes a mode that fits, unless friction that locks permits another motion.
    fn accept(&mut self, context: &mut Place, mode: Mode, found: &Found) -> Result<(), Failure> {
        let Mode { trial, begins, .. } = mode;
        if !found.is_present {
            self.choices.set(trial, context.data, context.state.discrete_mut());
            self.accelerate(context);
        }
        self.find_redundant(context);
        self.check_determinate(context)?;
        if self.locks.is_empty() || self.any_sticks(context) {
            return Ok(());
        }
        let (pass, trials) = (usize::from(begins), self.choices.trials());
        let mut locked = found.locked || found.jams[pass];
        for other in found.tried[pass]..trials {
            if self.choices.set(other, context.data, context.state.discrete_mut()) {
                self.accelerate(context);
                locked |= self.is_locked() && self.is_mode(context, begins);
            }
        }
        if found.tried[pass] < trials {
            self.choices.set(trial, context.data, context.state.discrete_mut());
            self.accelerate(context);
        }
        if locked { Err(context.failure(&self.choices, TWO_MOTIONS)) } else { Ok(()) }
    }

    /// True if other parts hold everything that neither sticks nor slips, or takes its full share at rest: it would be held twice if it stuck, too.
    pub(super) fn is_idle_held(&mut self, context: &mut Place) -> bool {
        let count = self.gaps.len();
        let idle = |choices: &Self, context: &Place, index: usize| {
            let (is_slip, direction) = (context.slip(index).is_some(), context.direction(index));
            is_slip
                && choices.choices.includes(index)
                && context.rubs(index)
                && !context.is_closed(index)
                && direction.abs() != 1.0
        };
        if !(0..count).any(|index| idle(self, context, index)) {
            return true;
        }
        let mut all_held = true;
        for index in 0..count {
            if idle(self, context, index) {
                all_held &= self.is_held(context, index);
            }
        }
        self.accelerate(context);
        all_held
    }

    /// What is undecided.
    fn list_of_modes(&mut self, context: &mut Place, turns: impl Fn(usize) -> bool) {
        let count = self.gaps.len();
        let all = &context.data.all;
        if all.iter().any(|contact| contact.slip.is_some()) {
            // With what sticks as it is: against what it slips next.
            self.accelerate(context);
        }
        self.choices.clear();
        for index in (0..count).filter(|&index| all[index].slip.is_none()) {
            context.close(index, false);
            if self.touches[index] && self.rests(context, index) {
                self.choices.contact(index, !self.leaves[index]);
            }
        }
        // What sticks, and has not been found to slip, slips in the last modes only: between its two levels both fit.
        for place in 0..2 * count {
            let (index, data) = (place % count, context.data);
            let Some(slip) = &data.all[index].slip else { continue };
            if (place < count) == self.stays(&data.all[index], turns(index)) {
                continue;
            }
            let rubs = slip.on.is_none_or(|on| self.choices.includes(on as usize));
            let direction = context.direction(index);
            let rests =
                self.rests(context, index) || turns(index) && direction != 0.0 && !self.is_pushed(context, index);
            let discrete = context.state.discrete_mut();
            if !rubs || !rests {
                data.all[index].slips(discrete, rubs.then_some(self.rates[index].signum()));
            } else if direction != 0.0 {
                self.choices.rest(index, [-direction.signum(), direction.signum()], self.restitutions[index]);
            } else if turns(index) {
                let multiplier = self.solved[context.model.coordinates() + data.all[index].constraint as usize];
                self.choices.slips(index, [multiplier.signum(), -multiplier.signum()], self.restitutions[index]);
            } else {
                self.choices.rest(index, [1.0, -1.0], self.restitutions[index]);
            }
            for (place, &sign) in data.all[index].state.signs.iter().enumerate().filter(|_| rubs) {
                let turned = turns(count + slip.sums as usize + place);
                let value = self.kept[sign as usize];
                self.choices.sign(index, sign, if turned { -value } else { value });
            }
        }
    }

    /// True if impulses have changed rates at this instant.
    fn has_impact(&self) -> bool {
        self.joining.any || self.hit.contains(&true)
    }

    /// True for what does not move: what has been held does not until an impact, however well the method knows its rate within a step.
    fn rests(&self, context: &Place, index: usize) -> bool {
        let is_held = self.kept[context.data.all[index].state.closed as usize] != 0.0 && !self.has_impact();
        is_held || self.rates[index].abs() <= self.least_rate(context, index)
    }

    /// True for what an impact has given another rate: it has come to rest just before that, and moves on.
    fn is_pushed(&self, context: &Place, index: usize) -> bool {
        let change = (self.rates[index] - self.before[index]).abs();
        self.hit.contains(&true) && change > self.least_rate(context, index)
    }

    /// True for what has stuck or been closed, and has not been found to change.
    fn stays(&self, contact: &Contact, turns: bool) -> bool {
        self.kept[contact.state.closed as usize] != 0.0 && !turns
    }

    /// How many frictions at rest begin to slide. Between its two limits friction at rest may stay there or slide: it stays as long as any way of sharing the load permits. Without a larger limit at rest, or alone,
    /// there is nothing to choose from, and none are counted.
    fn count_moving(&self, context: &Place) -> usize {
        let frictions = || self.choices.concerned().filter(|&index| context.slip(index).is_some());
        let shares = frictions().nth(1).is_some() && frictions().any(|index| self.restitutions[index] != 1.0);
        let size = self.accelerations.iter().fold(0.0, |most, value| maximum(most, value.abs()));
        let begins = |index: &usize| {
            let slides = context.rubs(*index) && !context.is_closed(*index) && self.rests(context, *index);
            slides && self.accelerations[*index].abs() > CANCELLED * maximum(size, context.scale(*index))
        };
        if shares { frictions().filter(begins).count() } else { 0 }
    }

    /// True if the mode fits, where accelerations that are against it are rounding errors: those of what other parts hold.
    fn fits(&mut self, context: &mut Place, begins: bool) -> bool {
        if self.is_mode(context, begins) {
            return true;
        }
        if !begins || self.twice || !self.is_mode(context, false) {
            return false;
        }
        (0..self.gaps.len()).all(|index| {
            let against = self.choices.includes(index) && self.is_against(context, index);
            let held = !against || self.is_held(context, index);
            if against {
                self.accelerate(context);
            }
            held
        })
    }

    /// True for what begins to move against its mode.
    fn is_against(&self, context: &Place, index: usize) -> bool {
        let margin = self.margin(context, index, &self.sizes(context));
        margin.is_some_and(|margin| margin.moves && margin.value < -CANCELLED * margin.begins)
    }

    /// True if what is open does not go in, what is closed presses, and friction obeys its law, within rounding errors: of the accelerations that there are if something may only begin to move, else
    /// of usual ones.
    pub(super) fn is_mode(&self, context: &Place, begins: bool) -> bool {
        let sizes = self.sizes(context);
        let holds = self.choices.concerned().any(|index| context.is_closed(index));
        let fits = |index: usize| match self.margin(context, index, &sizes) {
            Some(margin) if self.is_idle(context, index) => holds && margin.value >= -CANCELLED * margin.size,
            Some(margin) if self.leaves[index] && margin.moves => margin.value >= -self.slack(context, index),
            Some(margin) => margin.value >= -CANCELLED * if begins { margin.begins } else { margin.size },
            None => true,
        };
        let is_number = self.solved.iter().all(|value| value.is_finite());
        is_number && self.choices.concerned().all(fits) && self.have_signs(context, sizes.force)
    }

    /// The largest force and acceleration of those concerned.
    pub(super) fn sizes(&self, context: &Place) -> Sizes {
        let multipliers = &self.solved[context.model.coordinates()..];
        let concerned = || self.choices.concerned();
        Sizes {
            force: concerned().fold(0.0, |most, index| maximum(most, context.force(index, multipliers).abs())),
            acceleration: concerned().fold(0.0, |most, index| maximum(most, self.accelerations[index].abs())),
        }
    }

    /// What must not be negative of something in the present mode: none of what does not rub because its contact is open.
    pub(super) fn margin(&self, context: &Place, index: usize, sizes: &Sizes) -> Option<Margin> {
        let multipliers = &self.solved[context.model.coordinates()..];
        let (force, acceleration) = (context.force(index, multipliers), self.accelerations[index]);
        let (scale, direction) = (context.scale(index), context.direction(index));
        let presses = |value: f64| Some(Margin { value, size: sizes.force, begins: sizes.force, moves: false });
        let moves = |value: f64| Some(Margin { value, size: scale, begins: sizes.acceleration, moves: true });
        match (context.slip(index), context.is_closed(index)) {
            (None, true) => presses(force),
            (None, false) => moves(acceleration),
            (Some(_), _) if !context.rubs(index) => None,
            (Some(_), true) => presses(self.restitutions[index] * context.level(index, multipliers) - force.abs()),
            (Some(_), false) if self.is_idle(context, index) => moves(-acceleration.abs()),
            (Some(_), false) => moves(direction * acceleration),
        }
    }

    /// True for friction that neither sticks nor slips although it could: other parts hold it.
    pub(super) fn is_idle(&self, context: &Place, index: usize) -> bool {
        context.slip(index).is_some() && !context.is_closed(index) && context.direction(index) == 0.0
    }

    /// What has been found to slip is where the method has its force, to within the tolerance.
    pub(super) fn slack(&self, context: &Place, index: usize) -> f64 {
        let size = self.accelerations.iter().fold(0.0, |most, value| maximum(most, value.abs()));
        self.found() * maximum(size, context.scale(index))
    }

    /// The share to which an instant that was found knows forces and accelerations.
    pub(super) fn found(&self) -> f64 {
        maximum(CANCELLED, FOUND * self.tolerance)
    }

    /// True where friction permits no accelerations that follow from it steadily.
    fn is_locked(&self) -> bool {
        // What is not a number is not positive.
        !self.locks.iter().all(|&lock| lock > 0.0)
    }

    fn any_sticks(&self, context: &Place) -> bool {
        self.choices.concerned().any(|index| context.slip(index).is_some() && context.is_closed(index))
    }

    /// Accelerations and reactions in the present mode, the second derivatives of the gaps, what presses and what must be positive.
    pub(super) fn accelerate(&mut self, context: &mut Place) {
        self.trials += 1;
        let Place { model, data, machine, state } = context;
        machine.load(model, state);
        machine.evaluate(&model.program().tapes.acceleration, &mut self.solved);
        read(model, machine, &mut self.reciprocals);
        machine.evaluate(&data.row_sizes, &mut self.row_sizes);
        let mut pivots = self.reciprocals.iter().zip(&self.row_sizes);
        // A row of zeros leaves no number.
        self.twice =
            pivots.any(|(reciprocal, size)| is_within(reciprocal * size, TWICE) || (reciprocal * size).is_nan());
        machine.load_accelerations(model, &self.solved[..model.coordinates()]);
        machine.load_reactions(model, &self.solved[model.coordinates()..]);
        machine.evaluate(&data.accelerations, &mut self.accelerations);
        machine.evaluate(&data.pressing, &mut self.sums);
        machine.evaluate(&data.locks, &mut self.locks);
    }

    /// A rate of a gap that is rounding errors.
    pub(super) fn least_rate(&self, context: &Place, index: usize) -> f64 {
        let fastest = self.before.iter().chain(&self.rates).fold(0.0, |most, rate| maximum(most, rate.abs()));
        TOUCHING * maximum(fastest, context.scale(index))
    }
}

/// A mode that fits.
#[derive(Clone, Copy)]
struct Mode {
    trial: usize,
    /// True if it fits at the accelerations that there are.
    begins: bool,
    /// How many looks ahead it passes.
    lasts: u32,
    /// How many frictions begin to slide in it.
    moving: usize,
}

impl Mode {
    fn is_better(&self, other: &Self) -> bool {
        self.lasts > other.lasts || self.lasts == other.lasts && self.moving < other.moving
    }
}

/// What has come of trying modes.
#[derive(Default)]
struct Found {
    best: Option<Mode>,
    /// True if a mode fits but for friction that locks, or with redundant constraints.
    locked: bool,
    /// The first friction that does, by number among all frictions.
    jammed: Option<usize>,
    redundant: bool,
    /// The number of combinations tried, and whether friction locks in one that fits: with margins of usual accelerations, then with those of the present ones.
    tried: [usize; 2],
    jams: [bool; 2],
    /// True if the best one was the last to be tried: its accelerations are at hand.
    is_present: bool,
}

/// The largest of those concerned.
pub(super) struct Sizes {
    pub force: f64,
    pub acceleration: f64,
}

/// What must not be negative: a reaction, what a friction could hold more, or an acceleration if it `moves`.
pub(super) struct Margin {
    pub value: f64,
    /// A usual size, and that of what there is at the instant.
    pub size: f64,
    begins: f64,
    pub moves: bool,
}

/// Where something is decided.
pub(super) struct Place<'a> {
    pub model: &'a Model,
    pub data: &'a Contacts,
    pub(super) machine: &'a mut Machine,
    pub state: &'a mut State,
}

const TOO_MANY: &str =
    "more than 32768 combinations of contacts (open or closed) and friction (stick or slip) are possible at once";
const NO_IMPACT: &str =
    "no impulses solve their impact: with the loops their constraints are redundant, or friction would add energy";
const NO_MODE: &str = "no active set (open or closed, stick or slip) is consistent with the motion: with the loops their constraints are redundant, or friction locks the moving mechanism";
const TWO_MOTIONS: &str = "the motion is not unique (Painleve paradox): for rigid bodies with Coulomb friction both sliding and jamming are possible; reduce the friction";
pub(super) const PRELOADED: &str = "joints hold it on its supports already, so that its load on them, and with it the friction and the motion, is not determined for rigid bodies; leave the direction of the load free in one of the joints, or let the support give by a spring";
pub(super) const INDETERMINATE: &str = "they are redundant supports (statically indeterminate) with different friction: the load on each, and with it the motion, is not determined for rigid bodies; use one coefficient, fewer supports, or springs";
const LOCKS: &str = "friction jams the mechanism while it moves (self-locking): the normal force and its friction increase each other without bound; reduce the friction, or change the direction of the normal force";

impl Place<'_> {
    pub(super) fn scale(&self, index: usize) -> f64 {
        self.model.program().constraints[self.data.all[index].constraint as usize].scale
    }

    pub(super) fn slip(&self, index: usize) -> Option<&Slip> {
        self.data.all[index].slip.as_ref()
    }

    pub(super) fn is_closed(&self, index: usize) -> bool {
        is_closed(self.data, self.state, index)
    }

    /// True unless its contact is open.
    pub(super) fn rubs(&self, index: usize) -> bool {
        self.slip(index).is_some_and(|slip| slip.on.is_none_or(|on| self.is_closed(on as usize)))
    }

    pub(super) fn direction(&self, index: usize) -> f64 {
        direction(self.data, self.state, index)
    }

    /// Along the gap or the slip, from the multipliers of all loop equations.
    fn force(&self, index: usize, multipliers: &[f64]) -> f64 {
        let held = -multipliers[self.data.all[index].constraint as usize];
        held - self.direction(index) * self.level(index, multipliers)
    }

    /// Against which something slips; zero for a contact.
    fn level(&self, index: usize, multipliers: &[f64]) -> f64 {
        self.slip(index).map_or(0.0, |slip| multipliers[slip.level as usize])
    }

    pub(super) fn close(&mut self, index: usize, closed: bool) {
        self.state.discrete_mut()[self.data.all[index].state.closed as usize] = f64::from(u8::from(closed));
    }

    /// How a friction slides or sticks, as [`Contact::slips`] sets it.
    pub(super) fn mode(&self, index: usize) -> Option<f64> {
        let direction = self.direction(index);
        if self.is_closed(index) { Some(0.0) } else { (direction != 0.0).then_some(direction) }
    }

    pub(super) fn slide(&mut self, index: usize, mode: Option<f64>) {
        self.data.all[index].slips(self.state.discrete_mut(), mode);
    }

    /// A failure of an impact, in which joints may engage.
    pub(super) fn failure_of(&self, values: &ContactValues, why: &'static str) -> Failure {
        let joining = values.joining.names(self.model.program()).map(str::to_owned);
        let contacts = values.choices.concerned().map(|index| self.data.all[index].name.clone());
        Failure::Contact { time: self.state.time(), names: joining.chain(contacts).collect(), why }
    }

    /// Friction that locks: the one that does, then what was to be decided.
    fn jam(&self, choices: &Choices, jammed: Option<usize>) -> Failure {
        let frictions = (0..self.data.all.len()).filter(|&index| self.data.all[index].slip.is_some());
        let jammed = jammed.and_then(|number| frictions.into_iter().nth(number));
        let others = choices.concerned().filter(|index| Some(*index) != jammed);
        let names = jammed.into_iter().chain(others).map(|index| self.data.all[index].name.clone()).collect();
        Failure::Contact { time: self.state.time(), names, why: LOCKS }
    }

    pub(super) fn failure(&self, choices: &Choices, why: &'static str) -> Failure {
        let names = choices.concerned().map(|index| self.data.all[index].name.clone()).collect();
        Failure::Contact { time: self.state.time(), names, why }
    }
}

/// True for a contact that an impact throws back.
fn rebounds(context: &Place, before: &[f64], dead: &[bool], index: usize) -> bool {
    context.slip(index).is_none() && before[index] < 0.0 && !dead[index]
}

/// Freewheels that are open in a state.
fn open_freewheels(data: &Contacts, state: &State) -> impl Iterator<Item = usize> {
    (0..data.all.len()).filter(|&index| data.all[index].of_rate && !is_closed(data, state, index))
}

impl Instants {
    /// True if nothing can happen but that contacts without friction close and open.
    pub(crate) fn has_gaps_only(&self) -> bool {
        let is_gap = |contact: &Contact| contact.slip.is_none() && !contact.of_rate;
        let contacts = self.contacts();
        !contacts.is_empty() && self.occasions() == contacts.len() && contacts.iter().all(is_gap)
    }
}

/// True while a contact is closed in a state, or something sticks.
pub(crate) fn is_closed(data: &Contacts, state: &State, index: usize) -> bool {
    state.discrete()[data.all[index].state.closed as usize] != 0.0
}

/// 1 or -1 while something slips that way in a state, else 0.
pub(crate) fn direction(data: &Contacts, state: &State, index: usize) -> f64 {
    data.all[index].state.direction.map_or(0.0, |direction| state.discrete()[direction as usize])
}
