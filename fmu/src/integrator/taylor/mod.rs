//! Integration of Eqs. (22) by Taylor series, each step from the loop-closed state that the last one left.
//!
//! The polynomial of a step is its dense output. Its length follows from its last coefficients (Jorba & Zou, 2005). A step is rejected
//! if the loops do not stay closed along it, or if its end does not accelerate as the equations there demand. Where a series does not exist (a law
//! that is not analytic at this very state), the step is declined, and another method takes it.

mod laws;
mod memory;
mod passage;
mod propose;
mod step;

use super::control::{Horizon, Progress, take_step};
use crate::context::{Context, Settings};
use crate::events::Layers;
use crate::failure::Failure;
use crate::machine::Machine;
use crate::model::Model;
use crate::motion::Run;
use crate::motion::last_step::LONGEST_STEP;
use crate::singular::dependence::{begins_near, is_close};
use crate::singular::detect::Guard;
use crate::taylor::{Changes, FrictionAlong, Jet};
pub(crate) use memory::TaylorMemory;
use propose::{SERIES_GROWTH, is_near, order_of};
pub(crate) use propose::{order_for, share};

/// Storage for Taylor series.
#[derive(Clone, Debug)]
pub struct Taylor {
    jet: Box<Jet>,
    /// The other series of a mechanism with contacts, with storage for its changes: that of a flight, or that of all contacts.
    other: Option<(Box<Jet>, Changes)>,
    /// True if the mechanism has no loops, whatever is closed.
    is_open: bool,
    layers: Layers,
    next: Vec<f64>,
    /// (q, v) where the series begins, on the loops.
    closed: Vec<f64>,
    /// The last start with the loops closed tightly.
    begun: Begun,
    /// Series of q, order 2, on branches that are left at once.
    left: Vec<f64>,
    /// Accelerations at the end of a step, and those that are demanded there.
    residuals: Vec<f64>,
    guard: Guard,
    changes: Changes,
    /// The discrete variables that are 0 while a loop equation does not hold, one for each loop equation of the series; none where it always holds.
    masks: Vec<Option<u32>>,
    /// Does what the jet holds begin at the end of the last step?
    known: Start,
    /// Has it been begun with the loops closed tightly?
    tight: bool,
    /// That of the run whose step is being taken.
    memory: TaylorMemory,
}

/// Whether there is a series at the end of the last step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Start {
    Unknown,
    Regular,
    /// There is one, but rounding errors may spoil it.
    Near,
    Singular,
}

/// What a start with the loops closed tightly has ended with: it can be begun again, with the same bits, where the jet has looked elsewhere since.
#[derive(Clone, Debug)]
struct Begun {
    time: f64,
    /// (q, v) of the pose that the series are of.
    motion: Vec<f64>,
    /// How close loop equations are to depending on each other at the end of the step.
    next: Vec<f64>,
}

/// What comes of a state that the last step has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// It is on the loops.
    Closed,
    /// It must still be projected.
    Open,
}

impl Taylor {
    /// Storage for a model with an arm form.
    pub fn new(model: &Model) -> Option<Self> {
        let size = 2 * model.coordinates();
        let jet = Jet::boxed(model)?;
        let layers = Layers::new(model.program().arms.as_ref()?.tape.steep_laws());
        let guard = Guard::new(jet.groups());
        let changes = jet.changes();
        let other = jet.of_flight(model).map(|jet| {
            let changes = jet.changes();
            (jet, changes)
        });
        let all = &model.program().instants.masks;
        let mask = |row: u32| all.iter().find(|(constraint, _)| *constraint == row).map(|(_, mask)| *mask);
        let masks = model.program().arms.as_ref()?.rows.iter().map(|row| mask(row.constraint)).collect();
        Some(Self {
            is_open: jet.is_open(),
            jet,
            other,
            layers,
            next: vec![0.0; size],
            closed: vec![0.0; size],
            begun: Begun { time: f64::NAN, motion: vec![0.0; size], next: guard.next.clone() },
            left: vec![0.0; model.coordinates()],
            residuals: vec![0.0; size],
            guard,
            changes,
            masks,
            known: Start::Unknown,
            tight: false,
            memory: TaylorMemory::default(),
        })
    }

    /// Are there laws of positions or rates?
    pub fn has_laws(&self) -> bool {
        self.jet.has_laws()
    }

    /// About what a step costs, in instructions of a tape.
    pub fn cost(&self) -> f64 {
        self.jet.cost()
    }

    /// Numbers in the dense output of a step.
    pub fn dense_length(model: &Model) -> usize {
        model.program().arms.as_ref().map_or(0, |form| Jet::room(model, form))
    }

    /// Takes parameters and modes over, with the series that are made for these.
    fn update(&mut self, registers: &[f64]) {
        if let Some((other, changes)) =
            self.other.as_mut().filter(|(other, _)| other.flies(registers) == other.is_of_flight())
        {
            other.force_like(&self.jet);
            std::mem::swap(&mut self.jet, other);
            std::mem::swap(&mut self.changes, changes);
        }
        self.jet.update(registers);
    }

    /// To be called when the next step does not begin where this method left the last one.
    pub fn forget(&mut self) {
        self.known = Start::Unknown;
    }

    /// How many times rounding errors are multiplied where the last step ends, and the coordinate; none in a singular pose.
    pub(crate) fn amplification(&mut self, context: &mut Context, run: &Run) -> Option<(f64, Option<usize>)> {
        if self.jet.is_held() {
            self.known = Start::Unknown;
            self.begin(context, run);
        }
        if !matches!(self.known, Start::Regular | Start::Near) {
            let Context { model, machine, .. } = context;
            machine.load_signals(model, &run.signals.origin, run.last.end_time);
            self.update(machine.registers());
            self.known = Start::Unknown;
            self.jet.probe(model, machine.registers(), &run.last.end).ok()?;
        }
        Some(self.jet.amplification())
    }

    /// Takes one step, or declines it where there is no series to step along.
    pub fn advance(
        &mut self,
        context: &mut Context,
        (run, memory): (&mut Run, &mut TaylorMemory),
        horizon: Horizon,
    ) -> Result<Progress, Failure> {
        self.memory = *memory;
        let done = self.go_on(context, run, horizon);
        *memory = self.memory;
        done
    }

    fn go_on(&mut self, context: &mut Context, run: &mut Run, horizon: Horizon) -> Result<Progress, Failure> {
        self.take_back(run, context.settings.tolerance);
        self.begin(context, run);
        match self.known {
            // Pivots may be small beside each other because of units, as of lengths of 1e-12 m beside angles, and the pose is not singular.
            Start::Singular => self.leave(context, run).or_else(|failure| match is_close(context, run) {
                true => Err(failure),
                false => Ok(Progress::Declined),
            }),
            // Next to a pose that steps have come to: what is evaluated there does not know the branch.
            Start::Near if run.in_zone(run.last.end_time) => self.leave(context, run),
            Start::Near => self.leave(context, run).or_else(|_| {
                // Too slow to be left: it is followed like any other motion.
                self.next.copy_from_slice(&run.last.end);
                self.jet.force(self.memory.branches);
                let begun = self.start(context, run, run.last.end_time, true);
                self.known = begun.map_or(Start::Singular, |_| Start::Regular);
                self.guard.roll();
                Ok(Progress::Stepped)
            }),
            Start::Unknown | Start::Regular => take_step(self, context, run, horizon),
        }
    }

    /// (q, v) at the target, from the end of the last step or from its polynomial.
    pub fn read(
        &mut self,
        context: &mut Context,
        (run, memory): (&Run, &TaylorMemory),
        target: f64,
        motion: &mut [f64],
    ) -> Reading {
        if run.last.end_time == target {
            if self.is_open {
                motion.copy_from_slice(&run.last.end);
                return Reading::Closed;
            }
            self.prepare(context, run, memory);
            let regular = matches!(self.known, Start::Regular | Start::Near);
            motion.copy_from_slice(if regular { &self.closed } else { &run.last.end });
            return if regular { Reading::Closed } else { Reading::Open };
        }
        self.interpolate(run, target, motion);
        Reading::Closed
    }

    /// (q, v) at the target, from the polynomial.
    pub fn interpolate(&mut self, run: &Run, target: f64, motion: &mut [f64]) {
        self.jet.evaluate(&run.last.dense, run.last.order as usize, target - run.last.start_time, motion);
    }

    /// The polynomial of one coordinate in the last step, up to its order.
    pub(crate) fn coordinate(&self, run: &Run, index: usize, coefficients: &mut [f64]) {
        self.jet.coordinate(&run.last.dense, run.last.order as usize, index, coefficients);
    }

    /// The polynomial of the reaction of a loop equation in the last step; false if none is kept.
    pub(crate) fn reaction(&self, run: &Run, constraint: u32, coefficients: &mut [f64]) -> bool {
        self.jet.reaction(&run.last.dense, run.last.order as usize, constraint, coefficients)
    }

    /// The polynomials of the friction whose limit is the multiplier of a row, in the last step.
    pub(crate) fn friction<'a>(&self, run: &'a Run, row: u32) -> Option<FrictionAlong<'a>> {
        self.jet.friction(&run.last.dense, row, run.last.order as usize)
    }

    /// Accelerations and multipliers where the last step ends, if friction depends on them and a series has been begun there.
    pub(crate) fn solved_at_end(&self, values: &mut [f64]) -> bool {
        let is_known = self.jet.is_solved_with_friction() && self.known == Start::Regular;
        if is_known {
            self.jet.solved(values);
        }
        is_known
    }

    /// Begins a series at the end of the last step, on the loops, if that has not been done.
    pub(crate) fn prepare(&mut self, context: &mut Context, run: &Run, memory: &TaylorMemory) {
        self.memory = *memory;
        self.begin(context, run);
    }

    /// The series that the next step begins with, the order that it will have, and what one step may be wrong by, if it is known to be regular.
    pub(crate) fn begun(&mut self, run: &Run, tolerance: f64) -> Option<(&mut Jet, usize, f64)> {
        (self.known == Start::Regular).then_some((&mut *self.jet, order_of(run, tolerance), share(tolerance)))
    }

    /// The series.
    pub(crate) fn jet(&mut self) -> &mut Jet {
        &mut self.jet
    }

    /// Begins anew where a batch has the beginning of the series but not all orders that the step may need.
    fn take_back(&mut self, run: &Run, tolerance: f64) {
        if self.jet.is_held() && (is_near(run) || self.jet.known_orders() < order_of(run, tolerance)) {
            self.known = Start::Unknown;
        }
    }

    /// The end of the next step, as far as it can be told, and how long it is: of one that nothing shortens.
    pub(crate) fn foresee(&mut self, run: &Run, settings: &Settings) -> Option<[f64; 2]> {
        self.jet.forget_beginning();
        if is_near(run) || run.following().is_some() {
            return None;
        }
        let tolerance = share(settings.tolerance);
        let longest = (SERIES_GROWTH * run.last.natural).min(LONGEST_STEP).min(settings.max_step);
        let end = run.last.end_time + self.natural_length(order_of(run, settings.tolerance), tolerance).min(longest);
        Some([end, end - run.last.end_time])
    }

    fn begin(&mut self, context: &mut Context, run: &Run) {
        if self.known == Start::Unknown {
            self.next.copy_from_slice(&run.last.end);
            self.jet.force(self.memory.branches);
            // Only what the run remembers counts: what the guard holds may come from another run.
            self.guard.start.fill(0.0);
            self.known = match self.start(context, run, run.last.end_time, self.memory.series == Some(true)) {
                Some(_) if self.memory.series.is_none() && begins_near(context, run) => Start::Near,
                Some(_) => Start::Regular,
                None => Start::Singular,
            };
            self.guard.roll();
        }
    }

    /// Starts a series at `next`; returns how far the loops were open there.
    fn start(&mut self, context: &mut Context, run: &Run, time: f64, tightly: bool) -> Option<f64> {
        let Context { model, machine, settings, .. } = context;
        model.forget_integrals(&mut self.next);
        machine.load_signals(model, &run.signals.origin, time);
        if self.known == Start::Unknown {
            // Parameters change at communication points only.
            self.update(machine.registers());
            self.jet.forget_beginning();
        }
        self.jet.least_rate = settings.least_rate;
        let found = self.jet.begin_found(time, &self.next);
        let open = match found {
            Some(open) => open,
            None => self.jet.place(model, machine.registers(), &self.next).ok()?,
        };
        self.jet.reciprocal_pivots(&mut self.guard.next);
        self.tight = tightly || self.guard.arrives();
        self.begun.time = f64::NAN;
        if self.tight {
            if self.jet.is_held() {
                self.jet.place(model, machine.registers(), &self.next).ok()?;
            }
            // The series must come from the matrix of the very pose in which the loops are closed.
            self.jet.close_tightly();
            self.take_closed(model);
            self.begun.time = time;
            self.begun.motion.copy_from_slice(&self.closed);
            self.begun.next.copy_from_slice(&self.guard.next);
            self.begin_closed(model, machine)?;
        } else {
            if found.is_none() {
                self.jet.find_accelerations();
            }
            self.take_closed(model);
        }
        (open.is_finite() && self.closed.iter().all(|value| value.is_finite())).then_some(open)
    }

    /// Begins the series again that the last start has left at this time with the loops closed tightly, after the jet has looked elsewhere. False if there is none.
    fn start_again(&mut self, context: &mut Context, run: &Run, time: f64) -> bool {
        let Context { model, machine, .. } = context;
        if self.begun.time != time {
            return false;
        }
        model.forget_integrals(&mut self.next);
        machine.load_signals(model, &run.signals.origin, time);
        self.update(machine.registers());
        self.guard.next.copy_from_slice(&self.begun.next);
        self.closed.copy_from_slice(&self.begun.motion);
        self.begin_closed(model, machine).is_some()
    }

    /// Begins the series of the pose in which the loops have been closed, and closes them there.
    fn begin_closed(&mut self, model: &Model, machine: &Machine) -> Option<()> {
        self.jet.place(model, machine.registers(), &self.closed).ok()?;
        self.jet.close_tightly();
        self.jet.find_accelerations();
        self.take_closed(model);
        Some(())
    }

    fn take_closed(&mut self, model: &Model) {
        let (q, v) = self.closed.split_at_mut(model.coordinates());
        self.jet.coordinates(0, q);
        self.jet.coordinates(1, v);
    }
}
