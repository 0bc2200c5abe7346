//! Back onto the loop equations: positions by Newton's method, rates by one linear step.
//!
//! The motion is corrected in the metric of the mass matrix (the tapes `project_position` and `project_velocity`); where drivers determine it there is one correction only.

use super::initial::FULFILLED;
use crate::constraints::reciprocals::is_within;
use crate::failure::{Failure, LoopGap};
use crate::linalg::SPACINGS;
use crate::machine::Machine;
use crate::model::{Model, State};
use crate::tape::Tape;
use crate::taylor::CLOSED;

/// The loops are kept closed this much better than the tolerance on the motion.
const LOOP_TOLERANCE: f64 = 1e-3;
/// Loop equations that are not imposed may differ by the tolerance on the motion, but not by more or less than this, relative to their scale: what counts as closed at the
/// start, and lengths that are typed with few digits.
const CONSISTENT: [f64; 2] = [FULFILLED, 1e-6];
/// Rounding errors of what drivers determine are divided by the distance from a singular pose: nearer than this they are larger than the errors of steps.
const NEAR_SINGULAR: f64 = 3e-4;
/// What is as good as closed, in units of what is left alone.
const TIGHT: f64 = 10.0;
/// Newton steps.
const PROJECTION_STEPS: usize = 8;
/// A Newton step must reduce the gap to this fraction.
const CONTRACTION: f64 = 0.5;

/// Storage for projections.
#[derive(Clone, Debug)]
pub struct Projection {
    /// Residuals of all m loop equations, then n corrections.
    step: Vec<f64>,
    /// Rates of zero.
    rest: Vec<f64>,
    count: u64,
}

/// Which of the two equations.
#[derive(Clone, Copy)]
enum Level {
    Position,
    Rate,
}

impl Level {
    fn residual(self, model: &Model) -> &Tape {
        let tapes = &model.program().tapes;
        match self {
            Self::Position => &tapes.constraint,
            Self::Rate => &tapes.constraint_rate,
        }
    }

    fn correction(self, model: &Model) -> &Tape {
        let tapes = &model.program().tapes;
        match self {
            Self::Position => &tapes.project_position,
            Self::Rate => &tapes.project_velocity,
        }
    }

    fn load(self, model: &Model, machine: &mut Machine, x: &[f64]) {
        match self {
            Self::Position => machine.load_positions(model, x),
            Self::Rate => machine.load_rates(model, x),
        }
    }
}

impl Projection {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let size = model.program().constraints.len() + model.coordinates();
        Self { step: vec![0.0; size], rest: vec![0.0; model.coordinates()], count: 0 }
    }

    /// Projections so far that moved something.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Corrects q, and leaves it in the registers together with everything else that is there. Returns the largest movement relative to
    /// the scales of the coordinates; fails when it would be more than `reach`.
    pub fn positions(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        q: &mut [f64],
        tolerance: f64,
        reach: f64,
    ) -> Result<f64, Failure> {
        self.positions_along(model, machine, q, tolerance, reach, &mut |_| ())
    }

    /// The same, with each correction bent by `bend` first, which must leave the loop equations closed to first order: where the metric of the
    /// mass matrix alone would stretch stiff springs.
    pub fn positions_along(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        q: &mut [f64],
        tolerance: f64,
        reach: f64,
        bend: &mut dyn FnMut(&mut [f64]),
    ) -> Result<f64, Failure> {
        // Rounding of q itself makes a gap.
        let noise = SPACINGS * largest(model, q);
        let idle = CLOSED.max(noise);
        let goal = idle.max(LOOP_TOLERANCE * tolerance);
        let moved = self.newton(model, machine, Level::Position, q, [idle, goal, reach], bend)?;
        self.consistent(model, machine, tolerance)?;
        Ok(moved)
    }

    /// Corrects v at the positions in the registers, and leaves it there.
    pub fn rates(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        v: &mut [f64],
        tolerance: f64,
    ) -> Result<(), Failure> {
        let size = 1.0 + largest(model, v);
        let goal = CLOSED.max(LOOP_TOLERANCE * tolerance) * size;
        self.newton(model, machine, Level::Rate, v, [CLOSED * size, goal, f64::INFINITY], &mut |_| ())?;
        Ok(())
    }

    /// Corrects v at the positions in the registers by a step, however little is open: where a mechanism is held with little leverage, as near a dead centre, what is left open is divided by that and moves it.
    pub fn rates_exactly(&mut self, model: &Model, machine: &mut Machine, v: &mut [f64]) -> Result<(), Failure> {
        let goal = CLOSED * (1.0 + largest(model, v));
        self.newton(model, machine, Level::Rate, v, [0.0, goal, f64::INFINITY], &mut |_| ())?;
        Ok(())
    }

    /// Closes positions and rates of a driven mechanism to rounding errors, from a state that is as close to its motion as steps are. So near to a singular
    /// pose that rounding errors would move it further than that it is left alone. The state must be in the registers.
    ///
    /// # Errors
    /// The loops do not close there.
    pub fn tighten(&mut self, model: &Model, machine: &mut Machine, state: &mut State) -> Result<(), Failure> {
        machine.run(&model.program().tapes.acceleration);
        let mut rows = model.program().tapes.reciprocal_pivots.iter();
        if rows.any(|&register| is_within(machine.registers()[register as usize], NEAR_SINGULAR)) {
            return Ok(());
        }
        let noise = SPACINGS * largest(model, state.positions());
        let (closed, size) = (TIGHT * CLOSED.max(noise), 1.0 + largest(model, state.rates()));
        let limits = [noise, closed, f64::INFINITY];
        self.newton(model, machine, Level::Position, state.positions_mut(), limits, &mut |_| ())?;
        let limits = [noise, TIGHT * CLOSED * size, f64::INFINITY];
        self.newton(model, machine, Level::Rate, state.rates_mut(), limits, &mut |_| ())?;
        Ok(())
    }

    /// Takes out of a change of rates what would open the loops, at the positions in the registers.
    pub fn flatten(&mut self, model: &Model, machine: &mut Machine, change: &mut [f64]) {
        let m = model.program().constraints.len();
        let tape = &model.program().tapes.project_velocity;
        // Twice, for the first time leaves rounding errors divided by the distance from a singular pose.
        for _ in 0..2 {
            machine.load_rates(model, change);
            machine.evaluate(tape, &mut self.step);
            change.iter_mut().zip(&self.step[m..]).for_each(|(change, step)| *change += step);
            // What the rates of drivers make is no part of the change.
            machine.load_rates(model, &self.rest);
            machine.evaluate(tape, &mut self.step);
            change.iter_mut().zip(&self.step[m..]).for_each(|(change, step)| *change -= step);
        }
    }

    /// The larger of the relative gaps of positions and of rates, at the state in the registers.
    pub fn gap(&mut self, model: &Model, machine: &mut Machine, state: &State) -> f64 {
        let mut relative = |level: Level, size: f64| {
            machine.evaluate(level.residual(model), &mut self.step);
            self.residual(model) / size
        };
        let position = relative(Level::Position, 1.0);
        crate::math::maximum(position, relative(Level::Rate, 1.0 + largest(model, state.rates())))
    }

    fn newton(
        &mut self,
        model: &Model,
        machine: &mut Machine,
        level: Level,
        x: &mut [f64],
        [idle, goal, reach]: [f64; 3],
        bend: &mut dyn FnMut(&mut [f64]),
    ) -> Result<f64, Failure> {
        level.load(model, machine, x);
        if model.active().is_empty() {
            return Ok(0.0);
        }
        let m = model.program().constraints.len();
        let mut moved = 0.0;
        for iteration in 0..PROJECTION_STEPS {
            machine.evaluate(level.correction(model), &mut self.step);
            let before = self.residual(model);
            if before <= if iteration == 0 { idle } else { goal } {
                return Ok(moved);
            }
            self.count += u64::from(iteration == 0);
            bend(&mut self.step[m..]);
            x.iter_mut().zip(&self.step[m..]).for_each(|(x, step)| *x += step);
            moved += largest(model, &self.step[m..]);
            level.load(model, machine, x);
            machine.evaluate(level.residual(model), &mut self.step[..m]);
            let after = self.residual(model);
            if after <= goal && moved <= reach {
                return Ok(moved);
            }
            // Written so that NaN is a failure too.
            let contracts = after <= CONTRACTION * before && moved <= reach;
            if !contracts {
                break;
            }
        }
        Err(self.drift(model, machine))
    }

    /// The largest residual of the active equations, relative to their scales; NaN if one is.
    fn residual(&self, model: &Model) -> f64 {
        let constraints = &model.program().constraints;
        let sizes = model.active().iter().map(|&row| self.step[row].abs() / constraints[row].scale);
        sizes.fold(0.0, crate::math::maximum)
    }

    fn drift(&self, model: &Model, machine: &Machine) -> Failure {
        Failure::Drift { time: time(model, machine), gap: largest_gap(model, model.active(), &self.step) }
    }

    /// Do the loop equations that are not imposed hold at the state in the registers?
    pub fn check(&mut self, model: &Model, machine: &mut Machine, tolerance: f64) -> Result<(), Failure> {
        let count = model.program().constraints.len();
        if model.active().len() == count {
            return Ok(());
        }
        machine.evaluate(&model.program().tapes.constraint, &mut self.step[..count]);
        self.consistent(model, machine, tolerance)
    }

    /// Loop equations that are not imposed must hold by themselves.
    fn consistent(&mut self, model: &Model, machine: &mut Machine, tolerance: f64) -> Result<(), Failure> {
        let count = model.program().constraints.len();
        if model.active().len() == count {
            return Ok(());
        }
        if model.active().is_empty() {
            machine.evaluate(&model.program().tapes.constraint, &mut self.step[..count]);
        }
        match open_row(model, &self.step, tolerance) {
            Some(row) => {
                Err(Failure::Redundant { time: time(model, machine), gap: largest_gap(model, &[row], &self.step) })
            }
            None => Ok(()),
        }
    }
}

/// Do the loop equations that are not imposed hold at a state that satisfies the others?
///
/// # Errors
/// One of them does not.
pub fn check_redundant(model: &Model, state: &State) -> Result<(), Failure> {
    let mut machine = Machine::new(model);
    machine.load(model, state);
    let mut residuals = vec![0.0; model.program().constraints.len()];
    machine.evaluate(&model.program().tapes.constraint, &mut residuals);
    match open_row(model, &residuals, FULFILLED) {
        Some(row) => Err(Failure::Redundant { time: state.time(), gap: largest_gap(model, &[row], &residuals) }),
        None => Ok(()),
    }
}

/// The first loop equation that is not imposed and does not hold.
pub(super) fn open_row(model: &Model, residuals: &[f64], tolerance: f64) -> Option<usize> {
    let [least, most] = CONSISTENT;
    let limit = tolerance.clamp(least, most);
    let constraints = model.program().constraints.iter().zip(residuals);
    // Written so that NaN does not hold.
    let holds = |size: f64| size <= limit;
    constraints.into_iter().position(|(row, residual)| !row.is_imposed() && !holds(residual.abs() / row.scale))
}

/// The largest of some loop equations' residuals, relative to their scales.
pub(crate) fn largest_gap(model: &Model, rows: &[usize], residuals: &[f64]) -> LoopGap {
    let constraints = &model.program().constraints;
    let size = |row: usize| residuals[row].abs() / constraints[row].scale;
    let row = rows.iter().copied().max_by(|&a, &b| size(a).total_cmp(&size(b)));
    row.map_or_else(
        || LoopGap { owner: model.program().name.clone(), size: 0.0, angular: false },
        |row| LoopGap {
            owner: constraints[row].owner.clone(),
            size: residuals[row].abs(),
            angular: constraints[row].is_angle(),
        },
    )
}

/// The largest of values of the mechanism's coordinates, relative to their scales.
fn largest(model: &Model, values: &[f64]) -> f64 {
    let coordinates = model.program().coordinates.iter().take(model.mechanical());
    values
        .iter()
        .zip(coordinates)
        .fold(0.0, |largest, (value, coordinate)| crate::math::maximum(largest, value.abs() / coordinate.scale))
}

fn time(model: &Model, machine: &Machine) -> f64 {
    machine.registers()[model.layout().time()]
}
