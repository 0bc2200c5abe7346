//! The variational equations from one step to the next.

use std::sync::Arc;

use cotree::equations::MotionVariable;
use cotree::expr::{Order, Values};
use cotree::formulate::Formulated;
use cotree_fmu::instance::{self, Instance, Snapshot, Variational};
use cotree_fmu::model::{Model, State};
use nalgebra::{DMatrix, DVector};

use super::super::driven::{DrivenInputs, InputRow};
use super::super::point::OperatingPoint;
use super::super::variation::{ColumnBlock, Numbers, RowBlock, Variation};
use super::super::{AnalysisFailure, SetError, decompose};
use super::collocation::SMALLEST;
use super::corner::Switched;
use super::event::SwitchCrossing;
use super::rule::{NODES, Rule};
use super::start::{check_repeated, start, still_repeat};
use super::{Differentiated, EarlyEnd, VariedQuantity};

/// The motion is computed that much more accurately than its derivatives.
const FINER: f64 = 1e-2;
/// So are the series of the derivatives.
const CLOSER: f64 = 0.1;
/// No finer than this.
const FINEST: f64 = 1e-13;
/// Steps of the derivatives: so many, and so many more for each step of the motion. Ten of them for each are asked for in tests; where it is more than this they run away.
const FREE_STEPS: u64 = 1000;
const DEAREST: u64 = 100;
/// Derivatives are rounding errors below this share of the scale of the coordinates over the parameter: those of what nothing depends on, and of laws that a
/// parameter does not move yet. However short a step is, their last coefficients are as large as the others.
const ROUNDING: f64 = 1e-13;
/// The first step is this share of the run.
const FIRST: f64 = 1e-2;
/// Where steps have become that short: a pose whose smallest singular value is below this share of the largest.
const SINGULAR: f64 = 1e-4;
/// The shortest step, as a share of the run.
const SHORTEST: f64 = 1e-10;
/// Signs of switching functions are looked at so often in a step of the motion.
const LOOKS: usize = 4;
/// A step by series that was not good enough is made that much shorter.
const SHORTER: f64 = 0.6;

/// The outputs at a time and their derivatives: a row for each output, a column for each parameter.
pub type At = (DVector<f64>, DMatrix<f64>);

/// The motion and its derivatives at a time.
pub struct DifferentiatedMotion<'f> {
    pub(super) formulated: &'f Formulated,
    pub(super) variation: &'f Variation,
    pub(super) driven: DrivenInputs,
    /// The rows of inputs over time that are varied: one for each parameter.
    pub(super) rows: Vec<Option<InputRow>>,
    pub(super) model: Arc<Model>,
    /// The motion at the time that the derivatives belong to; nothing happens in it by itself.
    pub(super) motion: Instance,
    /// The motion with all that happens in it, ahead of the derivatives; none if nothing ever happens.
    pub(super) guide: Option<Instance>,
    pub(super) variational: Variational,
    /// The variables that the outputs are.
    pub(super) outputs: Vec<usize>,
    pub(super) parameters: usize,
    /// q_p and v_p: a column for each parameter.
    pub(super) positions: DMatrix<f64>,
    pub(super) rates: DMatrix<f64>,
    /// Their scale, by parameter, to which errors are relative: the largest of them so far, and no less than what rounding errors make of it. A motion that comes to rest ends
    /// with derivatives that are small.
    pub(super) reached: Vec<f64>,
    /// Steps that were tried, and the points at which they evaluated derivatives.
    pub(super) tried: u64,
    pub(super) points: u64,
    /// On which side of zero the switching functions are.
    pub(super) sides: Vec<Option<bool>>,
    /// From here on the signs are those after the last crossing \[s\].
    pub(super) clear: f64,
    /// Laws that have switched.
    pub(super) switched: Vec<Switched>,
    /// The event that has ended the motion.
    pub(super) ended: Option<EarlyEnd>,
    pub(super) rule: &'static Rule,
    pub(super) tolerance: f64,
    kinematic: bool,
    /// Series that have begun already, if the derivatives are still where they did.
    pub(super) begun: Option<Begun>,
    before: Before,
}

/// The time at which series begin, and how long a step they permit; none where there are none \[s\].
#[derive(Clone, Copy)]
pub(super) struct Begun {
    time: f64,
    length: Option<f64>,
}

/// Where a step by series begins.
struct Before {
    motion: Snapshot,
    positions: DMatrix<f64>,
    rates: DMatrix<f64>,
}

impl<'f> DifferentiatedMotion<'f> {
    /// Begins at the start of the experiment, with these values changed \[SI\].
    pub fn new(
        differentiated: &'f Differentiated,
        (varied, driven): (&[VariedQuantity], DrivenInputs),
        changed: &[(&str, f64)],
        from: Option<&State>,
    ) -> Result<Self, AnalysisFailure> {
        let Differentiated { formulated, variation, model, .. } = differentiated;
        let (program, model) = (model.program(), Arc::clone(model));
        let (experiment, kinematic) = (program.experiment, program.is_driven());
        let (program_coordinates, mechanical) = (program.coordinates.len(), program.mechanical());
        let mut motion = Instance::new(Arc::clone(&model));
        let finer = (experiment.tolerance * FINER).max(FINEST);
        motion.setup(experiment.start, None, Some(finer))?;
        motion.record_instants();
        for (name, value) in changed {
            let variable = model.program().variables.iter().position(|variable| variable.name == *name);
            let unknown = || AnalysisFailure::Unknown(vec![SetError(format!("`{name}` cannot be set"))]);
            motion.set(variable.ok_or_else(unknown)?, *value)?;
        }
        if let Some(pose) = from {
            motion.start_from(pose.clone())?;
        }
        driven.set(&mut motion, experiment.start, false)?;
        motion.initialise()?;
        let guide = (!program.instants.is_empty()).then(|| motion.clone());
        let mut motion = if guide.is_some() { motion.without_instants() } else { motion };
        let empty = DMatrix::zeros(program_coordinates, varied.len());
        let scale = model
            .program()
            .coordinates
            .iter()
            .take(mechanical)
            .fold(0.0, |most: f64, coordinate| most.max(coordinate.scale));
        let size = |varied: &VariedQuantity| if varied.start == 0.0 { scale } else { scale / varied.start.abs() };
        let least = ROUNDING / experiment.tolerance.max(SMALLEST);
        let places: Vec<instance::Varied> = varied.iter().map(|varied| varied.place).collect();
        let rows = formulated.lowered.table.rows.iter().enumerate();
        let mut course = DifferentiatedMotion {
            formulated,
            variation,
            driven,
            rows: varied.iter().map(|varied| varied.row).collect(),
            before: Before { motion: motion.save(), positions: empty.clone(), rates: empty.clone() },
            begun: None,
            motion,
            guide,
            variational: Variational::new(&model, &places, (experiment.tolerance * CLOSER).max(FINEST)),
            outputs: rows.filter(|(_, row)| row.is_output()).map(|(place, _)| place).collect(),
            parameters: varied.len(),
            model,
            positions: empty.clone(),
            rates: empty,
            reached: varied.iter().map(|varied| least * size(varied)).collect(),
            tried: 0,
            points: 0,
            sides: Vec::new(),
            clear: f64::NEG_INFINITY,
            switched: Vec::new(),
            ended: None,
            rule: Rule::shared(),
            tolerance: experiment.tolerance,
            kinematic,
        };
        course.begin()?;
        Ok(course)
    }

    /// Takes over how inputs change with their rows from a time on.
    fn vary_inputs(&mut self, time: f64, stops: bool) {
        for (column, row) in self.rows.iter().enumerate() {
            if let Some(row) = *row {
                self.variational.vary_input(column, time, self.driven.share(row, time, stops));
            }
        }
    }

    fn begin(&mut self) -> Result<(), AnalysisFailure> {
        self.vary_inputs(self.motion.time(), false);
        let mut point = OperatingPoint::moving(&self.model, &self.motion.state())?;
        // What holds wherever it stands holds nothing of the start.
        for contact in self.model.program().instants.contacts().iter().filter(|contact| contact.state.place.is_some()) {
            point.set_discrete((contact.state.closed as usize, 0.0));
        }
        let numbers = self.variation.at(&self.formulated.equations, &point)?;
        let mechanical = self.formulated.equations.coordinates.len();
        let speeds = self.values(&point, Order::Velocity).rows(0, mechanical).into_owned();
        let refused = |what: String| AnalysisFailure::NoDerivative { time: point.time(), what };
        let by = |row: RowBlock| self.by_parameters_alone(&numbers.block(row, ColumnBlock::Signals), point.time());
        let (positions, changes) = start(&numbers, by, &speeds).map_err(|error| refused(error.to_string()))?;
        check_repeated(&numbers, &by(RowBlock::Repeated), &positions).map_err(|_| {
            refused(
                "redundant joints are compatible for these values only: a changed mechanism cannot be assembled".into(),
            )
        })?;
        self.sides = sides(&numbers.values(RowBlock::Switches));
        (self.positions, self.rates) = (positions, changes);
        self.reach();
        self.begin_instants(&numbers)
    }

    /// Takes note of how large the derivatives are.
    pub(super) fn reach(&mut self) {
        let mechanical = self.formulated.equations.coordinates.len();
        for (column, reached) in self.reached.iter_mut().enumerate() {
            // States count relative to their sizes.
            let scales = self.model.program().coordinates.iter().map(|coordinate| coordinate.scale).enumerate();
            let units: Vec<f64> = scales.map(|(index, scale)| if index < mechanical { 1.0 } else { scale }).collect();
            let size = |matrix: &DMatrix<f64>| {
                let column = matrix.column(column);
                column.iter().zip(&units).map(|(entry, unit)| entry.abs() / unit).fold(0.0, f64::max)
            };
            *reached = reached.max(size(&self.positions)).max(size(&self.rates));
        }
    }

    /// q, v or a of the coordinates.
    pub(super) fn values(&self, point: &OperatingPoint, order: Order) -> DVector<f64> {
        let layout = self.formulated.equations.motion_layout();
        DVector::from_fn(self.model.coordinates(), |index, _| match (layout.variable(index), order) {
            (MotionVariable::State(_), Order::Position) => 0.0,
            (variable, order) => point.value(variable.symbol(order)),
        })
    }

    /// Moves a motion on to a time, and varies the loops there.
    pub(super) fn at(
        &self,
        motion: &mut Instance,
        time: f64,
    ) -> Result<(OperatingPoint, Numbers<'_>), AnalysisFailure> {
        move_on(motion, time)?;
        let point = OperatingPoint::moving(&self.model, &motion.state())?;
        let numbers = self.variation.at(&self.formulated.equations, &point)?;
        Ok((point, numbers))
    }

    /// How much work it was so far: steps of the motion, and points at which derivatives were evaluated.
    pub fn work(&self) -> u64 {
        let motion = self.motion.statistics();
        motion.steps + motion.rejected + self.points
    }

    /// Hands over the outputs at these times and their derivatives; no more than so much work may be done for them.
    pub fn run(&mut self, times: &[f64], most: u64, mut report: impl FnMut(At)) -> Result<(), AnalysisFailure> {
        let begin = self.motion.time();
        let end = times.last().copied().unwrap_or(begin);
        let mut due = times;
        for knot in self.driven.knots([begin, end]) {
            let (now, later) = due.split_at(due.partition_point(|&time| time < knot));
            self.run_through(now, [knot, end - begin], most, &mut report)?;
            if self.ended.is_some() {
                return Ok(());
            }
            self.pass_knot(knot, knot == end)?;
            due = later;
        }
        self.run_through(due, [end, end - begin], most, &mut report)
    }

    /// Sets the inputs anew where they bend or jump. That happens at the same time for all parameters: q_p and v_p go on as they are.
    fn pass_knot(&mut self, time: f64, stops: bool) -> Result<(), AnalysisFailure> {
        self.driven.set(&mut self.motion, time, stops)?;
        self.guide.as_mut().map_or(Ok(()), |guide| self.driven.set(guide, time, stops))?;
        self.vary_inputs(time, stops);
        self.go_on_anew()
    }

    /// Runs to the end of a motion without knots in which nothing happens; `span` is how long all of it is.
    pub(super) fn run_smoothly(
        &mut self,
        times: &[f64],
        [end, span]: [f64; 2],
        most: u64,
        mut report: impl FnMut(At),
    ) -> Result<(), AnalysisFailure> {
        let begin = self.motion.time();
        let (begun, mut due) = times.split_at(if self.kinematic { times.len() } else { until(times, begin) });
        for &time in begun {
            move_on(&mut self.motion, time)?;
            let state = [&self.positions, &self.rates];
            report(read(&mut self.variational, &mut self.motion, &self.outputs, state, None)?);
        }
        if self.kinematic {
            return move_on(&mut self.motion, end);
        }
        let mut length = span * FIRST;
        loop {
            let time = self.motion.time();
            let left = end - time;
            if left <= 0.0 {
                return Ok(());
            }
            if length < span * SHORTEST {
                return Err(self.stuck(
                    "the step size becomes too small: a law has a very steep gradient or is not smooth".to_owned(),
                ));
            }
            self.check_work(most)?;
            // The method that takes the motion's steps while it is stiff has none for its derivatives.
            let by_series = !self.motion.is_stiff() && self.continue_series([end, span], &mut due, &mut report)?;
            if !by_series {
                length = self.advance(length.min(left), &mut due, &mut report)?;
            }
        }
    }

    /// Fails when the derivatives cost too much.
    fn check_work(&self, most: u64) -> Result<(), AnalysisFailure> {
        if self.tried > FREE_STEPS + DEAREST * self.motion.statistics().steps {
            return Err(self.stuck(format!(
                "they take more than {DEAREST} times the steps of the motion: a law has a very steep gradient or is not smooth; use a larger tolerance"
            )));
        }
        if self.work() > most {
            let what = format!("they exceed the limit of {most} steps");
            return Err(AnalysisFailure::NoDerivative { time: self.motion.time(), what });
        }
        Ok(())
    }

    /// Takes a step by series, if there are some. It counts if the accelerations at its end are those that the equations give there, in the motion and in its derivatives.
    fn continue_series(
        &mut self,
        [last, span]: [f64; 2],
        due: &mut &[f64],
        report: &mut impl FnMut(At),
    ) -> Result<bool, AnalysisFailure> {
        let begin = self.motion.time();
        let begun = self.begun.take().filter(|begun| begun.time == begin);
        let mut length = match begun {
            Some(begun) => begun.length,
            None => self.begin_series(last)?,
        };
        let shortest = (last - begin).min(span * SHORTEST);
        self.motion.save_into(&mut self.before.motion);
        self.before.positions.copy_from(&self.positions);
        self.before.rates.copy_from(&self.rates);
        while let Some(tried) = length.filter(|length| *length >= shortest) {
            let end = if tried < last - begin { begin + tried } else { last };
            (self.tried, self.points) = (self.tried + 1, self.points + 1);
            let (now, later) = due.split_at(until(due, end));
            let found = self.follow_series(now, end)?;
            let next = self.begin_series(last)?;
            if next.is_some() && self.variational.defect(end - begin) <= 1.0 {
                self.begun = Some(Begun { time: end, length: next });
                found.into_iter().for_each(report);
                *due = later;
                self.reach();
                return Ok(true);
            }
            self.motion.restore(&self.before.motion)?;
            self.positions.copy_from(&self.before.positions);
            self.rates.copy_from(&self.before.rates);
            // Where the series cannot begin again another method goes on.
            length = self.begin_series(last)?.map(|_| SHORTER * tried).filter(|_| next.is_some());
        }
        Ok(false)
    }

    /// Begins the series at the present time; says how long a step they permit.
    fn begin_series(&mut self, last: f64) -> Result<Option<f64>, AnalysisFailure> {
        let state = [self.positions.as_slice(), self.rates.as_slice()];
        let left = last - self.motion.time();
        Ok(self.variational.begin(&mut self.motion, state, &self.reached, left)?)
    }

    /// Moves on along the series to the end of a step; gives the outputs at these times in it.
    fn follow_series(&mut self, due: &[f64], end: f64) -> Result<Vec<At>, AnalysisFailure> {
        let Self { variational, motion, outputs, positions, rates, .. } = self;
        let begin = motion.time();
        let mut found = Vec::with_capacity(due.len());
        for &time in due {
            move_on(motion, time)?;
            variational.continued(time - begin, [positions.as_mut_slice(), rates.as_mut_slice()]);
            found.push(read(variational, motion, outputs, [positions, rates], None)?);
        }
        move_on(motion, end)?;
        variational.continued(end - begin, [positions.as_mut_slice(), rates.as_mut_slice()]);
        Ok(found)
    }

    /// Why the steps are so short: most likely a singular pose is near, which the motion itself passes; otherwise this.
    fn stuck(&self, otherwise: String) -> AnalysisFailure {
        let time = self.motion.time();
        let here = self.at(&mut self.motion.clone(), time);
        match here.and_then(|(_, numbers)| is_singular(&numbers)) {
            Err(failure) => failure,
            Ok(true) => singular_pose(time),
            Ok(false) => AnalysisFailure::NoDerivative { time, what: otherwise },
        }
    }

    /// True if the loop equations count in the present pose as the program imposes them.
    pub(super) fn counts_as_imposed(&self) -> Result<bool, AnalysisFailure> {
        let (_, numbers) = self.at(&mut self.motion.clone(), self.motion.time())?;
        counts_as_imposed(&numbers)
    }

    /// Tries a step; gives the length of the next.
    fn advance(&mut self, length: f64, due: &mut &[f64], report: &mut impl FnMut(At)) -> Result<f64, AnalysisFailure> {
        let begin = self.motion.time();
        if let Some(crossing) = self.next_crossing(begin + length)? {
            let before = crossing.time - begin;
            if before > f64::EPSILON * crossing.time.abs().max(1.0) {
                let Some(tried) = self.attempt(before)?.filter(|tried| tried.excess <= 1.0) else {
                    return Ok(0.5 * before);
                };
                self.accept(&tried, before, due, report)?;
            }
            self.cross(&crossing)?;
            return Ok(length);
        }
        let Some(tried) = self.attempt(length)? else { return Ok(0.5 * length) };
        let factor = (0.9 * tried.excess.max(1e-30).powf(-1.0 / (NODES - 1) as f64)).clamp(0.3, 2.0);
        if tried.excess <= 1.0 {
            self.accept(&tried, length, due, report)?;
        }
        Ok(length * factor)
    }

    /// The first crossing of a switching function up to a time. Where laws switch the motion takes steps of its own: signs are looked at in each of them, so that none passes
    /// unseen, however soon the next one follows.
    fn next_crossing(&self, end: f64) -> Result<Option<SwitchCrossing>, AnalysisFailure> {
        if self.sides.is_empty() {
            return Ok(None);
        }
        let mut motion = self.motion.clone();
        let (mut sides, mut last) = (self.sides.clone(), motion.time().max(self.clear));
        while last < end {
            move_on(&mut motion, last.next_up())?;
            let [from, to] = [last, motion.end_of_step().min(end)];
            for look in 1..=LOOKS {
                let time = if look < LOOKS { from + (to - from) * look as f64 / LOOKS as f64 } else { to };
                move_on(&mut motion, time)?;
                if let Some(crossing) = self.first_crossing(&mut sides, &switches(&mut motion)?, [last, time])? {
                    return Ok(Some(crossing));
                }
                last = time;
            }
        }
        Ok(None)
    }
}

/// How many of these times come no later than a time.
pub(super) fn until(times: &[f64], end: f64) -> usize {
    times.partition_point(|&time| time <= end)
}

/// Moves a motion on to a time, not before its own.
pub(super) fn move_on(motion: &mut Instance, time: f64) -> Result<(), AnalysisFailure> {
    if time > motion.time() {
        motion.step_to(time)?;
    }
    motion.take_passages().first().map_or(Ok(()), |passage| Err(singular_pose(passage.time)))
}

/// The outputs at the time of a motion, with these q_p and v_p, along with which the time may move; not a number where one has no value or no derivative.
pub(super) fn read(
    variational: &mut Variational,
    motion: &mut Instance,
    outputs: &[usize],
    [positions, rates]: [&DMatrix<f64>; 2],
    moves: Option<&[f64]>,
) -> Result<At, AnalysisFailure> {
    let mut derivatives = DMatrix::zeros(outputs.len(), positions.ncols());
    let state = [positions.as_slice(), rates.as_slice()];
    variational.outputs(motion, state, moves, outputs, derivatives.as_mut_slice())?;
    let values = outputs.iter().map(|&output| motion.reading(output)).collect::<Result<_, _>>()?;
    Ok((DVector::from_vec(values), derivatives))
}

/// The switching functions of the laws.
pub(super) fn switches(motion: &mut Instance) -> Result<DVector<f64>, AnalysisFailure> {
    let program = motion.model().program();
    let (laws, all) = (program.tapes.indicators.results.len(), program.indicators());
    let mut values = vec![0.0; all];
    motion.indicators(&mut values)?;
    // Those of what happens at instants come after them.
    values.truncate(laws);
    Ok(DVector::from_vec(values))
}

/// True if the loop equations count in a pose as the program imposes them: with other lengths than its own some may depend on others, or repeat them no more.
pub(in super::super) fn counts_as_imposed(numbers: &Numbers) -> Result<bool, AnalysisFailure> {
    Ok(!is_singular(numbers)? && still_repeat(numbers)?)
}

/// True if loop equations nearly depend on each other.
fn is_singular(numbers: &Numbers) -> Result<bool, AnalysisFailure> {
    let jacobian = numbers.block(RowBlock::Loops, ColumnBlock::Positions);
    if jacobian.is_empty() {
        return Ok(false);
    }
    let parts = decompose::svd(jacobian, false, false)?;
    Ok(parts.singular_values.min() < SINGULAR * parts.singular_values.max())
}

fn singular_pose(time: f64) -> AnalysisFailure {
    let what = "the motion crosses a singular configuration, where changed lengths separate the branches".to_owned();
    AnalysisFailure::NoDerivative { time, what }
}

/// On which side of zero values are; none for zero.
pub(super) fn sides(values: &DVector<f64>) -> Vec<Option<bool>> {
    values.iter().map(|&value| (value != 0.0).then_some(value > 0.0)).collect()
}
