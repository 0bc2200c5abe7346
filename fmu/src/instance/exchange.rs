//! Model Exchange: the importer integrates. It moves time and the states q and v as it likes; the loops are closed again at events.
//!
//! States are q and v of each coordinate in turn, then those of the scene. A driven mechanism has none: its pose follows from time, continued from the
//! last completed step.

use super::snapshot::Phase;
use super::{Computed, Handled, Instance, InstanceError};
use crate::constraints::domains::undefined;
use crate::failure::Failure;

impl Instance {
    /// Solves for the initial state and hands the integration over to the importer.
    pub fn initialise_exchange(&mut self) -> Result<(), InstanceError> {
        if !self.model.program().offers_exchange() {
            return Err(InstanceError::no_exchange(self.model.program()));
        }
        self.initialise_exchange_with_rates()
    }

    /// The same for an importer that also tells the rates of inputs.
    pub fn initialise_exchange_with_rates(&mut self) -> Result<(), InstanceError> {
        if !self.model.program().offers_exchange_with_rates() {
            return Err(InstanceError::no_exchange(self.model.program()));
        }
        self.initialise()?;
        self.now.phase = Phase::Exchange;
        if let Err(failure) = self.check_modes() {
            self.now.phase = Phase::Initial { solved: true };
            return Err(failure);
        }
        if self.model.is_driven() {
            return Ok(());
        }
        match self.watch.begin(&self.model, &self.now.state) {
            None => Ok(()),
            Some(crossing) => {
                self.now.phase = Phase::Initial { solved: true };
                Err(InstanceError::Crossing(crossing))
            }
        }
    }

    /// Number of continuous states.
    pub fn state_count(&self) -> usize {
        if self.model.is_driven() { 0 } else { self.model.mechanical() + self.model.coordinates() }
    }

    /// Sets the time.
    pub fn set_time(&mut self, time: f64) -> Result<(), InstanceError> {
        if !time.is_finite() {
            return Err(InstanceError::NotANumber { name: "time".to_owned(), value: time });
        }
        if time != self.time() {
            self.invalidate();
            self.now.state.registers_mut()[self.model.layout().time()] = time;
        }
        Ok(())
    }

    /// Sets the continuous states.
    pub fn set_states(&mut self, states: &[f64]) -> Result<(), InstanceError> {
        self.check_count(states.len())?;
        if let Some(place) = states.iter().position(|value| !value.is_finite()) {
            let name = self.model.program().coordinates[self.coordinate_of(place)].name.clone();
            return Err(InstanceError::NotANumber { name, value: states[place] });
        }
        self.computed = Computed::default();
        self.now.at_start = false;
        if states.is_empty() {
            return Ok(());
        }
        let mechanical = self.model.mechanical();
        let (pairs, scene_states) = states.split_at(2 * mechanical);
        for (index, pair) in pairs.chunks_exact(2).enumerate() {
            self.now.state.positions_mut()[index] = pair[0];
            self.now.state.rates_mut()[index] = pair[1];
        }
        self.now.state.rates_mut()[mechanical..].copy_from_slice(scene_states);
        Ok(())
    }

    /// The continuous states.
    pub fn states(&mut self, states: &mut [f64]) -> Result<(), InstanceError> {
        self.check_count(states.len())?;
        self.reproject()?;
        let state = &self.now.state;
        // A driven mechanism has none.
        if states.is_empty() {
            return Ok(());
        }
        interleave(self.model.mechanical(), [state.positions(), state.rates()], states);
        Ok(())
    }

    /// Derivatives of the continuous states.
    pub fn state_derivatives(&mut self, derivatives: &mut [f64]) -> Result<(), InstanceError> {
        self.check_count(derivatives.len())?;
        if !derivatives.is_empty() {
            self.accelerate()?;
            let derivatives_of = [self.now.state.rates(), self.accelerations.accelerations()];
            interleave(self.model.mechanical(), derivatives_of, derivatives);
        }
        Ok(())
    }

    /// Natural sizes of the continuous states.
    pub fn nominals(&self, nominals: &mut [f64]) -> Result<(), InstanceError> {
        self.check_count(nominals.len())?;
        for (place, nominal) in nominals.iter_mut().enumerate() {
            *nominal = self.model.program().coordinates[self.coordinate_of(place)].scale;
        }
        Ok(())
    }

    /// Event indicators: they change sign where the accelerations, or the rates that drivers prescribe, have a step or a corner.
    pub fn indicators(&mut self, indicators: &mut [f64]) -> Result<(), InstanceError> {
        let tape = &self.model.program().tapes.indicators;
        let expected = self.model.program().indicators();
        if indicators.len() != expected {
            return Err(InstanceError::Count { found: indicators.len(), expected });
        }
        let (laws, events) = indicators.split_at_mut(tape.results.len());
        if !laws.is_empty() {
            self.load()?;
            self.machine.evaluate(&self.model.program().tapes.indicators, laws);
        }
        self.excesses(events)
    }

    /// True if something is due after an accepted step of the importer's integrator, or the loops must be closed.
    ///
    /// # Errors
    /// The step has gone through a pose in which branches of the motion cross: what comes after it means nothing.
    pub fn complete_step(&mut self) -> Result<bool, InstanceError> {
        self.load()?;
        if let Some(failure) = undefined(&self.model, &mut self.machine) {
            return Err(InstanceError::Solver(failure));
        }
        let due = self.is_due()?;
        if !due {
            self.check_modes()?;
        }
        if self.model.is_driven() {
            self.adopt();
            return Ok(due);
        }
        if let Some(crossing) = self.watch.step(&self.model, &self.now.state, self.now.tolerance) {
            return Err(InstanceError::Crossing(crossing));
        }
        self.load()?;
        let gap = self.stepper.gap(&self.model, &mut self.machine, &self.now.state);
        // The gap of a redundant contact is the drift of the loops that hold it, and must not be taken for its opening.
        let apart = match self.holds_redundant() {
            true => gap > self.now.tolerance,
            false => self.now.drift.is_due(gap, self.now.tolerance),
        };
        Ok(due || apart)
    }

    /// At an event: closes the loops, and lets happen what is due.
    pub fn handle_event(&mut self) -> Result<Handled, InstanceError> {
        let closed = self.close_loops()?;
        self.shown.copy_from(&self.now.state);
        self.handle_instants()?;
        self.check_modes()?;
        if self.instants.is_some() {
            // What has opened or closed makes other poses singular.
            self.watch.resume(&self.model, &self.now.state);
        }
        let [before, after] = [&self.shown, &self.now.state].map(|state| (state.positions(), state.rates()));
        let moved = closed || before != after;
        Ok(Handled { moved, next: self.next_event_time()?, ended: self.is_ended() })
    }

    /// Closes the loops. Says whether the states have changed.
    pub fn close_loops(&mut self) -> Result<bool, InstanceError> {
        self.reproject()?;
        if self.model.is_driven() {
            self.adopt();
            return Ok(false);
        }
        let settings = self.settings();
        let before = if self.now.run.is_changed() { self.now.run.before() } else { &self.now.state };
        self.shown.copy_from(&self.now.state);
        let reprojected = self.stepper.reproject(&self.model, &mut self.machine, before, &mut self.shown, &settings);
        reprojected.map_err(|failure| match failure {
            Failure::LockUp { time, gap } | Failure::Drift { time, gap } if !self.now.run.is_changed() => {
                InstanceError::Apart { time, gap }
            }
            other => self.explained(other),
        })?;
        let moved = self.shown != self.now.state;
        self.now.at_start &= !moved;
        self.now.state.copy_from(&self.shown);
        self.now.run.keep(&self.now.state);
        self.now.drift.close();
        self.watch.resume(&self.model, &self.now.state);
        self.computed = Computed::default();
        Ok(moved)
    }

    /// Takes the pose of the present time over as the one to continue from.
    fn adopt(&mut self) {
        if self.is_shown() {
            self.now.state.copy_from(&self.shown);
        }
        self.now.run.keep(&self.now.state);
    }

    /// The coordinate of a continuous state.
    fn coordinate_of(&self, place: usize) -> usize {
        let mechanical = self.model.mechanical();
        if place < 2 * mechanical { place / 2 } else { place - mechanical }
    }

    fn check_count(&self, found: usize) -> Result<(), InstanceError> {
        let expected = self.state_count();
        if found == expected { Ok(()) } else { Err(InstanceError::Count { found, expected }) }
    }
}

/// Pairs of positions and rates, or of their derivatives, for each coordinate of the mechanism; then the rates of what follows them.
fn interleave(mechanical: usize, [positions, rates]: [&[f64]; 2], states: &mut [f64]) {
    let (pairs, scene_states) = states.split_at_mut(2 * mechanical);
    for (pair, (position, rate)) in pairs.chunks_exact_mut(2).zip(positions.iter().zip(rates)) {
        pair.copy_from_slice(&[*position, *rate]);
    }
    scene_states.copy_from_slice(&rates[mechanical..]);
}
