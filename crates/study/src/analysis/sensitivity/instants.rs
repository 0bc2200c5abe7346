//! Derivatives through events: impacts, opening and closing contacts, state events and sample times.
//!
//! Between them the motion is smooth, in the mode and with the discrete variables of the moment. One run of the motion goes ahead and says what happens, and when; the derivatives follow it up to
//! there, and jump with it.

use cotree::expr::Order;
use cotree_fmu::instance::{Happening, InstanceError};
use cotree_fmu::program::Program;
use nalgebra::{DMatrix, RowDVector};

use super::super::variation::{ColumnBlock, Numbers, RowBlock};
use super::super::{AnalysisFailure, OperatingPoint};
use super::EarlyEnd;
use super::corner::Switched;
use super::step::{At, DifferentiatedMotion, read, sides, switches};

/// The time just before an instant is so many roundings earlier.
const ROUNDINGS: f64 = 64.0;

/// What happens next in a motion.
struct NextInstant {
    time: f64,
    happened: Vec<Happening>,
    /// The event that ends the motion there.
    ends: Option<String>,
}

impl DifferentiatedMotion<'_> {
    /// What happens at the start, before the derivatives are followed.
    pub(super) fn begin_instants(&mut self, numbers: &Numbers) -> Result<(), AnalysisFailure> {
        let Some(guide) = &mut self.guide else { return Ok(()) };
        let (happened, state, time) = (guide.take_record(), guide.state(), guide.time());
        let refused = |what: String| AnalysisFailure::NoDerivative { time, what };
        let contacts = self.model.program().instants.contacts();
        let struck = contacts.iter().find(|contact| state.discrete()[contact.state.impulse as usize] != 0.0);
        if let Some(contact) = struck {
            return Err(refused(format!("the motion starts with an impact of `{}`", contact.name)));
        }
        let first = self.parameters + 1 + self.driven.inputs().len();
        let program = self.model.program();
        let of_scene = following(program).filter(|&place| place < program.instants.begin.results.len()).count();
        for row in [RowBlock::Loops, RowBlock::Starts, RowBlock::StartRates] {
            let block = numbers.block(row, ColumnBlock::Signals);
            if block.columns(first, of_scene).iter().any(|entry| *entry != 0.0) {
                return Err(refused("the start depends on values that sample times and events change".to_owned()));
            }
        }
        let changes = [self.positions.as_slice(), self.rates.as_slice()];
        self.variational.begin_discrete(&self.motion, changes).map_err(|error| refused(error.to_string()))?;
        if happened.is_empty() {
            return Ok(());
        }
        let moves = self.pass(&happened)?;
        match moves.iter().all(|change| *change == 0.0) {
            true => Ok(()),
            false => Err(refused(
                "a sample time at the start depends on the varied quantity, and would move before the start".to_owned(),
            )),
        }
    }

    /// How rows change at a time with the parameters alone, given their derivatives by all signals.
    pub(super) fn by_parameters_alone(&self, signals: &DMatrix<f64>, time: f64) -> DMatrix<f64> {
        let mut by_parameters = signals.columns(0, self.parameters).into_owned();
        for (mut column, row) in by_parameters.column_iter_mut().zip(&self.rows) {
            row.iter().for_each(|row| column.scale_mut(self.driven.share(*row, time, false)[0]));
        }
        by_parameters
    }

    /// The same by each of them and by the discrete variables that follow from it.
    pub(super) fn by_parameters(&self, signals: &DMatrix<f64>, time: f64) -> DMatrix<f64> {
        let by_parameters = self.by_parameters_alone(signals, time);
        let following: Vec<usize> = following(self.model.program()).collect();
        if following.is_empty() {
            return by_parameters;
        }
        let (count, all) = (self.model.program().discrete.len(), self.variational.discrete_values());
        let change = |row: usize, column: usize| all[column * count + following[row]];
        let changes = DMatrix::from_fn(following.len(), self.parameters, change);
        by_parameters + signals.columns(signals.ncols() - following.len(), following.len()) * changes
    }

    /// Runs to the end of a motion without knots, or to the event that ends it, through everything that happens in it.
    pub(super) fn run_through(
        &mut self,
        times: &[f64],
        [end, span]: [f64; 2],
        most: u64,
        report: &mut impl FnMut(At),
    ) -> Result<(), AnalysisFailure> {
        let mut due = times;
        while let Some(NextInstant { time, happened, ends }) = self.next_instant(end)? {
            let (now, later) = due.split_at(due.partition_point(|&due_time| due_time < time));
            self.run_smoothly(now, [time, span], most, &mut *report)?;
            let changes = self.pass_instant(time, &happened)?;
            if let Some(event) = ends {
                report(self.at_end(&changes)?);
                self.ended = Some(EarlyEnd { event, time, changes });
                return Ok(());
            }
            due = later;
        }
        self.run_smoothly(due, [end, span], most, report)
    }

    /// The outputs at the event that ends the motion, and their derivatives along with it, whose time moves with the parameters: q_p + v t_p, v_p + a t_p.
    fn at_end(&mut self, moves: &[f64]) -> Result<At, AnalysisFailure> {
        let point = OperatingPoint::moving(&self.model, &self.motion.state())?;
        let along = |changes: &DMatrix<f64>, order: Order| {
            changes + self.values(&point, order) * RowDVector::from_row_slice(moves)
        };
        let (positions, rates) = (along(&self.positions, Order::Velocity), along(&self.rates, Order::Acceleration));
        read(&mut self.variational, &mut self.motion, &self.outputs, [&positions, &rates], Some(moves))
    }

    /// What happens next, up to a time.
    fn next_instant(&mut self, end: f64) -> Result<Option<NextInstant>, AnalysisFailure> {
        let Some(guide) = &mut self.guide else { return Ok(None) };
        while guide.time() < end {
            let moved = guide.step_towards(end);
            let happened = guide.take_record();
            let ends = match moved {
                Err(InstanceError::Ended { event, .. }) if !happened.is_empty() => Some(event),
                moved => moved.map(|_| None)?,
            };
            if let Some(first) = happened.first() {
                return Ok(Some(NextInstant { time: first.time(), happened, ends }));
            }
        }
        Ok(None)
    }

    /// The derivatives jump with the motion; how its time changes with each parameter.
    fn pass_instant(&mut self, time: f64, happened: &[Happening]) -> Result<Vec<f64>, AnalysisFailure> {
        let changes = self.pass(happened)?;
        let before = time - ROUNDINGS * f64::EPSILON * time.abs();
        self.switched.push(Switched { times: [before, time], changes: changes.clone() });
        Ok(changes)
    }

    /// Takes the derivatives over what has happened, and goes on from there.
    fn pass(&mut self, happened: &[Happening]) -> Result<Vec<f64>, AnalysisFailure> {
        let Some(guide) = &self.guide else { return Ok(Vec::new()) };
        let time = guide.time();
        self.motion = guide.without_instants();
        let state = [self.positions.as_mut_slice(), self.rates.as_mut_slice()];
        let moves = self.variational.pass(&self.model, happened, state, self.tolerance);
        let moves = moves.map_err(|error| AnalysisFailure::NoDerivative { time, what: error.to_string() })?;
        self.go_on_anew()?;
        self.reach();
        self.check_corners(time)?;
        Ok(moves)
    }

    /// Refuses to go on from the very corner of a law that the motion does not leave, but a changed value would: derivatives differ on both sides.
    fn check_corners(&self, time: f64) -> Result<(), AnalysisFailure> {
        if self.sides.iter().all(Option::is_some) {
            return Ok(());
        }
        let point = OperatingPoint::moving(&self.model, &self.motion.state())?;
        let numbers = self.variation.at(&self.formulated.equations, &point)?;
        let (rates, accelerations) = (self.values(&point, Order::Velocity), self.values(&point, Order::Acceleration));
        let of = |column: ColumnBlock| numbers.block(RowBlock::Switches, column);
        let changes = of(ColumnBlock::Positions) * &self.positions
            + of(ColumnBlock::Rates) * &self.rates
            + self.by_parameters(&of(ColumnBlock::Signals), time);
        let speeds = of(ColumnBlock::Positions) * rates + of(ColumnBlock::Rates) * accelerations;
        let by_time = of(ColumnBlock::Signals).columns(self.parameters, 1 + self.driven.inputs().len()).into_owned();
        let stays = |switch: &usize| {
            let moves = changes.row(*switch).iter().any(|change| *change != 0.0);
            let still = speeds[*switch] == 0.0 && by_time.row(*switch).iter().all(|by| *by == 0.0);
            self.sides[*switch].is_none() && still && moves
        };
        if (0..self.sides.len()).any(|switch| stays(&switch)) {
            let what =
                "a law starts at a corner, where its derivatives differ on both sides; start away from it".to_owned();
            return Err(AnalysisFailure::NoDerivative { time, what });
        }
        Ok(())
    }

    /// Laws may be others from here on.
    pub(super) fn go_on_anew(&mut self) -> Result<(), AnalysisFailure> {
        self.begun = None;
        if !self.sides.is_empty() {
            self.sides = sides(&switches(&mut self.motion)?);
        }
        Ok(())
    }
}

/// The discrete variables that follow from the motion: those of the scene, and the places where something sticks or is caught. What says whether a part is there is 1 or 0, whatever varies.
pub(super) fn following(program: &Program) -> impl Iterator<Item = usize> {
    let is_removed = |place: &usize| {
        program.instants.events.iter().any(|event| event.removes.iter().any(|&removed| removed as usize == *place))
    };
    let places = program.instants.contacts().iter().filter_map(|contact| contact.state.place);
    let of_scene = (0..program.instants.begin.results.len()).filter(move |place| !is_removed(place));
    of_scene.chain(places.map(|place| place as usize))
}
