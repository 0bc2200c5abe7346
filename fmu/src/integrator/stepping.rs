//! From one communication point to the next.
//!
//! Must: results do not depend on the communication points beyond the tolerance; a change of an input or parameter acts from
//! its communication point on and never before; nothing is evaluated after the stop time. Desirable: as few evaluations as possible.
//! So, while nothing changes, steps have their natural length and communication points are read from the dense output; after a change the
//! step that went too far is forgotten; and when changes come at every communication point, steps end exactly there.

use super::accuracy::{Accuracy, Masses};
use super::control::Horizon;
use super::explicit::Explicit;
use super::implicit::Implicit;
use super::memory::{Memory, room};
use super::taylor::Taylor;
use crate::constraints::domains::{out_of_range, undefined};
use crate::constraints::initial::ASTRAY;
use crate::constraints::projection::Projection;
use crate::context::{Context, Settings, Statistics};
use crate::failure::Failure;
use crate::integrator::stiffness::{Advance, Engines};
use crate::machine::Machine;
use crate::model::{Model, State, motion as range};
use crate::motion::Run;
use crate::program::Engine;
use crate::singular::dependence::is_singular;
use crate::taylor::{CLOSED, Jet};

/// Shortest part of a change that is followed.
const SHORTEST_PART_OF_CHANGE: f64 = 1e-4;

/// Moves states of one model. Everything is allocated here; nothing allocates while stepping.
#[derive(Clone, Debug)]
pub struct Stepper {
    explicit: Explicit,
    implicit: Implicit,
    taylor: Option<Box<Taylor>>,
    projection: Projection,
    work: State,
    reprojection: Reprojection,
    statistics: Statistics,
    masses: Option<Masses>,
    accuracy: Accuracy,
    /// For the motion of a driven mechanism between times that somebody else chooses.
    carried: Option<Box<Carried>>,
}

/// A motion from one time to another.
#[derive(Clone, Debug)]
struct Carried {
    run: Run,
    memory: Memory,
    state: State,
}

impl Carried {
    fn new(model: &Model, state: &State) -> Self {
        let (run, memory) = beginning(model, state);
        Self { run, memory, state: state.clone() }
    }
}

/// The beginning of a run.
pub(crate) fn beginning(model: &Model, state: &State) -> (Run, Memory) {
    (Run::new(model, state, room(model)), Memory::new(model))
}

/// Storage for closing the loops after a change.
#[derive(Clone, Debug)]
struct Reprojection {
    reached: State,
    trial: State,
}

impl Stepper {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let work = model.default_state(0.0);
        Self {
            explicit: Explicit::new(model),
            implicit: Implicit::new(model),
            // On the heap: an importer's thread may have a small stack, and storage moves through several frames.
            taylor: Taylor::new(model).map(Box::new),
            projection: Projection::new(model),
            reprojection: Reprojection { reached: work.clone(), trial: work.clone() },
            carried: model.is_driven().then(|| Box::new(Carried::new(model, &work))),
            work,
            statistics: Statistics::default(),
            masses: Masses::new(model),
            accuracy: Accuracy::new(model),
        }
    }

    /// Storage for implicit steps, whether the program asks for them or not.
    pub fn permit_implicit(&mut self, model: &Model) {
        if !self.implicit.is_allocated(model) {
            self.implicit = Implicit::allocate(model);
        }
    }

    /// What has been done so far.
    pub fn statistics(&self) -> Statistics {
        Statistics { projections: self.projection.count(), ..self.statistics }
    }

    /// How accurate the motion can be at all.
    pub(crate) fn accuracy(&mut self) -> &mut Accuracy {
        &mut self.accuracy
    }

    /// To be called when the continuation was replaced by another one.
    pub fn forget(&mut self) {
        self.accuracy.forget_steps();
        self.explicit.forget();
        self.implicit.forget();
        if let Some(taylor) = &mut self.taylor {
            taylor.forget();
        }
    }

    /// The run of a driven mechanism that has last brought it to a time that somebody else chose.
    pub(crate) fn carried(&self) -> Option<&Run> {
        self.carried.as_ref().map(|carried| &carried.run)
    }

    /// Closes the loops at a state whose time, parameters or inputs have changed, but not yet its motion. On failure the state stays as it was.
    pub fn reproject(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        before: &State,
        state: &mut State,
        settings: &Settings,
    ) -> Result<(), Failure> {
        if before.time() < state.time()
            && let Some(mut carried) = self.carried.take()
        {
            carried.state.copy_from(before);
            let done = self.carry(model, machine, &mut carried, state, settings);
            self.carried = Some(carried);
            return done;
        }
        let Self { projection, reprojection, statistics, .. } = self;
        let context = &mut Context { model, machine, projection, statistics, settings };
        reprojection.close(context, before, state)
    }

    /// Moves a driven mechanism to the later time of a state, in steps of its own, so that they stay on the branch. Inputs go along straight lines.
    fn carry(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        Carried { run, memory, state: moved }: &mut Carried,
        state: &mut State,
        settings: &Settings,
    ) -> Result<(), Failure> {
        let span = state.time() - moved.time();
        if moved.constant_between_instants() != state.constant_between_instants() {
            run.keep(moved);
            moved.registers_mut()[model.layout().constant_between_instants()]
                .copy_from_slice(state.constant_between_instants());
            self.reproject(model, machine, run.before(), moved, settings)?;
        }
        for index in 0..model.program().inputs.len() {
            let [[from, ..], [to, ..]] = [&*moved, &*state].map(|state| state.input_polynomial(index));
            moved.set_input_polynomial(index, [from, (to - from) / span, 0.0]);
        }
        model.follow(moved.registers_mut());
        run.start(model, moved);
        memory.start();
        self.forget();
        self.step_to(model, machine, moved, (run, memory), state.time(), settings)?;
        // The rates are those of the inputs' own polynomials.
        machine.load(model, state);
        machine.load_positions(model, moved.positions());
        self.projection.rates(model, machine, moved.rates_mut(), settings.tolerance)?;
        state.registers_mut()[range(model.layout())].copy_from_slice(&moved.registers()[range(model.layout())]);
        Ok(())
    }

    /// How far the loops have come apart at a state, relative to the scales: in positions, or in rates relative to those. The state must be in
    /// the registers.
    pub fn gap(&mut self, model: &Model, machine: &mut Machine, state: &State) -> f64 {
        self.projection.gap(model, machine, state)
    }

    /// Closes all loops at a state, those that hold on one side only in its mode: its positions, and nothing else.
    pub(crate) fn close_positions(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        state: &mut State,
    ) -> Result<(), Failure> {
        machine.load(model, state);
        self.projection.positions(model, machine, state.positions_mut(), CLOSED, f64::INFINITY)?;
        Ok(())
    }

    /// Closes the rates of all loops at a state, those that hold on one side only in its mode.
    pub(crate) fn close_rates(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        state: &mut State,
    ) -> Result<(), Failure> {
        machine.load(model, state);
        self.projection.rates_exactly(model, machine, state.rates_mut())
    }

    /// Looks at the beginning of a run before its first step, so that the steps need no storage for it.
    pub(crate) fn prepare(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        (run, memory): (&mut Run, &Memory),
        settings: &Settings,
    ) {
        let Self { taylor, projection, statistics, .. } = self;
        let context = &mut Context { model, machine, projection, statistics, settings };
        match (settings.engine, taylor) {
            (Engine::Taylor, Some(taylor)) => {
                context.machine.load(model, &run.signals.origin);
                taylor.prepare(context, run, &memory.taylor);
            }
            _ if is_singular(context, run) => {
                run.singular.pose = Some(run.last.end_time);
            }
            _ => {}
        }
    }

    /// Signals, q and v at the time of a state within the last step, of which there is a polynomial.
    pub fn catch_up(&mut self, model: &Model, machine: &mut Machine, state: &mut State, run: &Run) {
        let time = state.time();
        model.advance_signals(&run.signals.origin, time, state.registers_mut());
        if let Some(taylor) = &mut self.taylor {
            taylor.interpolate(run, time, &mut state.registers_mut()[range(model.layout())]);
        }
        if model.is_driven() {
            machine.load(model, state);
            self.work.copy_from(state);
            // Where that fails the polynomial is what is known.
            if self.projection.tighten(model, machine, &mut self.work).is_ok() {
                state.copy_from(&self.work);
            }
        }
    }

    /// The state at a time within the last step, as far as its polynomial tells; not in order to go on from there.
    pub(crate) fn interpolate(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        (run, memory): (&Run, &mut Memory),
        (time, state): (f64, &mut State),
        settings: &Settings,
    ) -> Result<(), Failure> {
        let Self { explicit, implicit, taylor, projection, statistics, masses, accuracy, .. } = self;
        let context = &mut Context { model, machine, projection, statistics, settings };
        let mut engines =
            Engines { taylor: taylor.as_deref_mut(), explicit, implicit, masses: masses.as_mut(), accuracy, memory };
        read(context, run, time, state, |context, run, motion| engines.read(context, run, time, motion))
    }

    /// The series whose polynomial the last step is, if it is one and nothing is to be corrected where it is read.
    pub(crate) fn series(&self, model: &Model, run: &Run, memory: &Memory, settings: &Settings) -> Option<&Taylor> {
        let is_series = settings.engine == Engine::Taylor && run.last.order > 0 && !memory.implicit.is_last();
        self.taylor.as_deref().filter(|_| is_series && !model.is_driven())
    }

    /// Accelerations and multipliers where the last step ends, if its series has found them with the limits of friction.
    pub(crate) fn solved_at_end(
        &self,
        model: &Model,
        run: &Run,
        memory: &Memory,
        settings: &Settings,
        values: &mut [f64],
    ) -> bool {
        self.series(model, run, memory, settings).is_some_and(|taylor| taylor.solved_at_end(values))
    }

    /// Something has changed at the end of the last step, or within it: the run begins anew at this state. A step of the implicit method is taken again up to here, for its polynomial is of a
    /// lower order than its end.
    pub(crate) fn begin_anew(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        (run, memory): (&mut Run, &mut Memory),
        state: &mut State,
        settings: &Settings,
    ) {
        let Self { explicit, implicit, taylor, projection, statistics, masses, accuracy, .. } = self;
        let context = &mut Context { model, machine, projection, statistics, settings };
        let mut engines =
            Engines { taylor: taylor.as_deref_mut(), explicit, implicit, masses: masses.as_mut(), accuracy, memory };
        engines.end_at_change(context, run, state);
        run.restart(model, state);
        let unseen = engines.memory.taylor.unseen;
        engines.memory.forget();
        engines.memory.taylor.unseen = unseen;
        engines.forget_steps();
    }

    /// Moves a state to a later time. On failure the state stays as it was, but where the computer may not do more: then it has come as far as that.
    pub fn step_to(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        state: &mut State,
        (run, memory): (&mut Run, &mut Memory),
        target: f64,
        settings: &Settings,
    ) -> Result<(), Failure> {
        let mut advance = self.set_out(model, machine, state, (run, memory), target, settings)?;
        let mut advanced = Ok(());
        while run.last.end_time < target {
            if let Err(failure) = self.take_one(model, machine, (run, memory), settings, &mut advance) {
                advanced = Err(failure);
                break;
            }
        }
        self.arrive(model, machine, state, (run, memory), settings, (target, advanced))
    }

    /// Prepares the steps to a later time. On failure the state stays as it was.
    pub(crate) fn set_out(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        state: &State,
        (run, memory): (&mut Run, &mut Memory),
        target: f64,
        settings: &Settings,
    ) -> Result<Advance, Failure> {
        let Self { explicit, implicit, taylor, projection, work, reprojection, statistics, masses, accuracy, .. } =
            self;
        let context = &mut Context { model, machine, projection, statistics, settings };
        // What nobody has asked for until now is not reported any more, but for what makes the motion inexact.
        accuracy.note_passages(run.take_passages(state.time()));
        let exact = run.signals.changed && run.signals.changed_before;
        work.copy_from(state);
        let mut engines =
            Engines { taylor: taylor.as_deref_mut(), explicit, implicit, masses: masses.as_mut(), accuracy, memory };
        if run.signals.changed {
            engines.end_at_change(context, run, work);
            // In the zone of a singular pose a projection would take the motion off its branch; the next step begins with one outside.
            context.machine.load(model, work);
            if let Some(failure) = out_of_range(model, context.machine) {
                return Err(failure);
            }
            let closed =
                run.in_zone(work.time()) && context.projection.gap(model, context.machine, work) <= settings.tolerance;
            if !closed {
                reprojection.close(context, &run.signals.before, work)?;
            }
            run.restart(model, work);
            engines.memory.forget();
            engines.forget_steps();
        }
        let limit = if exact { target } else { settings.limit().max(target) };
        context.machine.load(model, &run.signals.origin);
        Ok(engines.set_out(context, run, Horizon { target, limit }))
    }

    /// Takes one of these steps.
    pub(crate) fn take_one(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        (run, memory): (&mut Run, &mut Memory),
        settings: &Settings,
        advance: &mut Advance,
    ) -> Result<(), Failure> {
        let Self { explicit, implicit, taylor, projection, statistics, masses, accuracy, .. } = self;
        let context = &mut Context { model, machine, projection, statistics, settings };
        let mut engines =
            Engines { taylor: taylor.as_deref_mut(), explicit, implicit, masses: masses.as_mut(), accuracy, memory };
        engines.take_one(context, run, advance)
    }

    /// Reads the state at the time that the steps lead to, unless they have failed.
    pub(crate) fn arrive(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        state: &mut State,
        (run, memory): (&mut Run, &mut Memory),
        settings: &Settings,
        (target, advanced): (f64, Result<(), Failure>),
    ) -> Result<(), Failure> {
        let Self { explicit, implicit, taylor, projection, work, statistics, masses, accuracy, .. } = self;
        let context = &mut Context { model, machine, projection, statistics, settings };
        let mut engines =
            Engines { taylor: taylor.as_deref_mut(), explicit, implicit, masses: masses.as_mut(), accuracy, memory };
        // What is done so far is kept where the computer may not do more.
        let (target, unfinished) = match advanced {
            Err(failure) if failure.is_unfinished() && run.last.end_time > work.time() => {
                (run.last.end_time, Err(failure))
            }
            advanced => (target, Ok(advanced?)),
        };
        read(context, run, target, work, |context, run, motion| engines.read(context, run, target, motion))?;
        if !model.is_driven() {
            engines.tighten(context, run, work);
        }
        if model.active().len() < model.program().constraints.len() {
            context.machine.load(model, work);
            context.projection.check(model, context.machine, settings.tolerance)?;
        }
        if run.last.undefined || model.is_driven() {
            context.machine.load(model, work);
            if let Some(failure) = undefined(model, context.machine) {
                return Err(failure);
            }
        }
        state.copy_from(work);
        run.signals.pass();
        unfinished
    }

    /// The series that the next step of a run begins with, and its order, if it takes one.
    pub(crate) fn begun(&mut self, run: &Run, memory: &Memory, settings: &Settings) -> Option<(&mut Jet, usize, f64)> {
        let is_series = settings.engine == Engine::Taylor && !memory.is_stiff();
        self.taylor.as_deref_mut().filter(|_| is_series)?.begun(run, settings.tolerance)
    }

    /// The series, if the model has one.
    pub(crate) fn jet(&mut self) -> Option<&mut Jet> {
        self.taylor.as_deref_mut().map(Taylor::jet)
    }

    /// The end of the next step of the series, and its length, as far as they can be told.
    pub(crate) fn foresee(&mut self, run: &Run, settings: &Settings) -> Option<[f64; 2]> {
        self.taylor.as_deref_mut()?.foresee(run, settings)
    }
}

/// The state at a communication point that the last step has reached. `motion` writes (q, v) and says whether it must be projected.
fn read(
    context: &mut Context,
    run: &Run,
    target: f64,
    state: &mut State,
    mut motion: impl FnMut(&mut Context, &Run, &mut [f64]) -> bool,
) -> Result<(), Failure> {
    state.copy_from(&run.signals.origin);
    context.model.advance_signals(&run.signals.origin, target, state.registers_mut());
    let range = range(context.model.layout());
    let open = motion(context, run, &mut state.registers_mut()[range]);
    let Context { model, machine, projection, settings, .. } = context;
    if model.is_driven() {
        machine.load(model, state);
        projection.tighten(model, machine, state)?;
    } else if open && !model.active().is_empty() {
        machine.load(model, state);
        // What is left of a loop would be taken for a gap that opens or closes.
        let is_exact = model.program().instants.contacts.is_some();
        let tolerance = if is_exact { settings.tolerance.min(CLOSED) } else { settings.tolerance };
        projection.positions(model, machine, state.positions_mut(), tolerance, f64::INFINITY)?;
        projection.rates(model, machine, state.rates_mut(), tolerance)?;
    }
    Ok(())
}

impl Reprojection {
    /// Closes the loops again after a change of parameters or inputs, in parts small enough to stay on the branch. `state` comes
    /// with the changes and the old motion.
    fn close(&mut self, context: &mut Context, before: &State, state: &mut State) -> Result<(), Failure> {
        if context.model.active().is_empty() {
            return Ok(());
        }
        let Context { model, machine, projection, settings, .. } = context;
        self.reached.copy_from(before);
        let (mut done, mut part) = (0.0, 1.0_f64);
        while done < 1.0 {
            let share = f64::min(done + part, 1.0);
            self.change(model, before, state, share);
            machine.load(model, &self.trial);
            match projection.positions(model, machine, self.trial.positions_mut(), settings.tolerance, ASTRAY) {
                Ok(_) => {
                    self.reached.copy_from(&self.trial);
                    (done, part) = (share, 2.0 * part);
                }
                Err(failure) => {
                    part *= 0.5;
                    if part < SHORTEST_PART_OF_CHANGE {
                        return Err(lock_up(failure));
                    }
                }
            }
        }
        projection.rates(model, machine, self.reached.rates_mut(), settings.tolerance)?;
        state.copy_from(&self.reached);
        Ok(())
    }

    /// The trial: the motion reached, with a share of the change of the signals.
    fn change(&mut self, model: &Model, before: &State, after: &State, share: f64) {
        self.trial.copy_from(&self.reached);
        let signals = model.layout().positions();
        let ends = before.registers().iter().zip(after.registers()).take(signals);
        for (place, (from, to)) in self.trial.registers_mut().iter_mut().zip(ends) {
            *place = if share < 1.0 { from + share * (to - from) } else { *to };
        }
    }
}

/// The same failure as the user of a changed mechanism sees it.
fn lock_up(failure: Failure) -> Failure {
    match failure {
        Failure::Drift { time, gap } => Failure::LockUp { time, gap },
        other => other,
    }
}
