//! One step of a driven mechanism: prediction, correction by Newton's method, and whether what was found is on the same branch.
//!
//! It is if for every block of the loop equations (1) the determinant keeps its sign and, within a factor of two, its size, so that steps shrink with the
//! distance to a singular pose; (2) the correction is much shorter than the way to another solution, which is about the distance to
//! singularity; (3) rates go on as the accelerations say. A crossing of branches shows in (1) alone: the determinant changes its sign, and its
//! size hardly. An avoided crossing fails (3) as well, and where the mechanism locks up there is no step at all.

use super::path::{Directions, Path};
use super::regularity::Monitor;
use crate::constraints::loops::Loops;
use crate::constraints::projection::open_row;
use crate::context::Context;
use crate::failure::Failure;
use crate::math::maximum;
use crate::model::{Model, State};

/// Within this distance of a singular pose a step may cross it: there it is decided whether branches meet, down to defects of 1e-13 of a
/// length. Rounding errors of the rates are then still 1e-10.
pub(super) const NEAR: f64 = 1e-6;
/// Blocks that are singular in the same pose come near it together.
const TOGETHER: f64 = 10.0;
/// Rule 1.
const RATIO: [f64; 2] = [0.5, 2.0];
/// Rule 2, in units of the distance to singularity: the other solution is one or two of these away.
const CORRECTION: f64 = 0.02;
/// Rule 3, what the change of rates over the step would move, in the same units.
const BEND: f64 = 0.1;
/// A step that uses up only this share of rules 2 and 3, and this much of rule 1, may be twice as long.
const EASY: f64 = 0.2;
const EASY_RATIO: [f64; 2] = [0.75, 1.4];
/// Newton steps.
const ITERATIONS: usize = 8;
/// A Newton step is this much shorter than the one before.
const CONTRACTION: f64 = 0.25;
/// Rounding errors of a correction, relative to the coordinates.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Corrections that become no shorter are rounding errors if they are as small as this.
const STAGNANT: f64 = 1e-9;
/// How well the loops are closed where nothing can be corrected, relative to their scales.
const CLOSED: f64 = 1e-12;

/// Why a step is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rejection {
    /// No solution is found, or it may be on another branch.
    Branch,
    /// A redundant equation does not hold.
    Redundant(usize),
}

/// Storage for steps along a path.
#[derive(Clone, Debug)]
pub(super) struct Corrector {
    loops: Loops,
    monitor: Monitor,
    directions: Directions,
    start: State,
    end: State,
    /// First and second derivative along the path at the start, first derivative at the end.
    slope: Vec<f64>,
    curvature: Vec<f64>,
    end_slope: Vec<f64>,
    /// What of the change of the first derivative the second does not explain.
    bend: Vec<f64>,
    /// How far the prediction has been corrected.
    moved: Vec<f64>,
    residuals: Vec<f64>,
}

impl Corrector {
    pub fn new(model: &Model) -> Self {
        let zeros = vec![0.0; model.coordinates()];
        let loops = Loops::new(model);
        let state = model.default_state(0.0);
        Self {
            monitor: Monitor::new(&loops),
            loops,
            directions: Directions::new(model),
            start: state.clone(),
            end: state,
            slope: zeros.clone(),
            curvature: zeros.clone(),
            end_slope: zeros.clone(),
            bend: zeros.clone(),
            moved: zeros,
            residuals: vec![0.0; model.program().constraints.len()],
        }
    }

    /// Where the last attempt ended.
    pub fn end(&self) -> &State {
        &self.end
    }

    /// The least distance of any block to singularity at the start.
    pub fn distance(&self) -> f64 {
        self.monitor.weakest().map_or(1.0, |block| self.monitor.start_distance(block))
    }

    /// A step starts here.
    pub fn begin(&mut self, context: &mut Context, path: Path, state: &State) -> Result<(), Failure> {
        let Context { model, machine, statistics, .. } = context;
        self.start.copy_from(state);
        machine.load(model, state);
        self.loops.factor_regular(model, machine)?;
        statistics.evaluations += 1;
        self.monitor.record_start(model, &self.loops);
        self.directions.slope(path, (model, machine), &mut self.loops, &mut self.slope);
        self.directions.curvature(path, (model, machine), &mut self.loops, &mut self.curvature);
        Ok(())
    }

    /// A step of length h from s, its end in `end`. Is a longer one likely to succeed?
    pub fn attempt(
        &mut self,
        context: &mut Context,
        path: Path,
        [s, h]: [f64; 2],
        crossing: bool,
    ) -> Result<bool, Rejection> {
        self.predict(context.model, path, [s, h]);
        if !self.correct(context) {
            return Err(Rejection::Branch);
        }
        let Context { model, machine, settings, .. } = context;
        self.monitor.record_end(model, &self.loops);
        self.directions.slope(path, (model, machine), &mut self.loops, &mut self.end_slope);
        let easy = self.judge(model, h, crossing).ok_or(Rejection::Branch)?;
        self.consistent(model, settings.tolerance)?;
        if let Path::Time(_) = path {
            self.end.rates_mut().copy_from_slice(&self.end_slope);
        }
        Ok(easy)
    }

    /// How far ahead branches meet: where they cross, the determinant of the weakest block is zero in proportion to the time that is left, where they
    /// touch in proportion to its square. Nothing far from a singular pose, or if it comes no closer.
    pub fn meeting(&mut self, context: &mut Context, path: Path, [s, h]: [f64; 2]) -> Option<[f64; 2]> {
        let block = self.monitor.weakest().filter(|&block| self.monitor.start_distance(block) < NEAR)?;
        self.predict(context.model, path, [s, h]);
        let Context { model, machine, .. } = context;
        machine.load(model, &self.end);
        self.loops.factor(model, machine).ok()?;
        self.monitor.record_end(model, &self.loops);
        let ratio = self.monitor.ratio(block);
        (0.0 < ratio && ratio < 1.0).then(|| [h / (1.0 - ratio), h / (1.0 - ratio.sqrt())])
    }

    /// The end of a step so short that the prediction is as good as any correction. False if it leaves the loops open.
    pub fn extrapolate(&mut self, context: &mut Context, path: Path, [s, h]: [f64; 2]) -> bool {
        self.residuals(context, path, [s, h]);
        if let Path::Time(_) = path {
            let rates = self.end.rates_mut().iter_mut();
            let slopes = self.slope.iter().zip(&self.curvature);
            rates.zip(slopes).for_each(|(rate, (slope, curvature))| *rate = slope + h * curvature);
        }
        let constraints = &context.model.program().constraints;
        context.model.active().iter().all(|&row| self.residuals[row].abs() <= CLOSED * constraints[row].scale)
    }

    /// The time at the end of a step, and by how much the prediction leaves the loops open there.
    pub fn residuals(&mut self, context: &mut Context, path: Path, [s, h]: [f64; 2]) -> (f64, &[f64]) {
        self.predict(context.model, path, [s, h]);
        let Context { model, machine, .. } = context;
        machine.load(model, &self.end);
        machine.evaluate(&model.program().tapes.constraint, &mut self.residuals);
        (self.end.time(), &self.residuals)
    }

    /// Closes the loops at a state inside a step. False if it is not where the step would have it.
    pub fn settle(&mut self, context: &mut Context, state: &mut State) -> bool {
        self.end.copy_from(state);
        let corrected = self.correct(context);
        let Context { model, machine, settings, .. } = context;
        self.monitor.record_start(model, &self.loops);
        if self.distance() < NEAR {
            // So close to a singular pose the polynomial is better than any correction.
            return true;
        }
        self.monitor.record_end(model, &self.loops);
        let close = |block| self.largest(model, block, &self.moved) <= CORRECTION * self.monitor.distance(block);
        if !(corrected && (0..self.loops.blocks()).all(close)) || self.consistent(model, settings.tolerance).is_err() {
            return false;
        }
        self.directions.slope(Path::Time(state), (model, machine), &mut self.loops, &mut self.end_slope);
        state.copy_from(&self.end);
        state.rates_mut().copy_from_slice(&self.end_slope);
        true
    }

    /// Rates at a state whose loops are closed.
    pub fn rates(&mut self, context: &mut Context, state: &mut State) -> Result<(), Failure> {
        let Context { model, machine, .. } = context;
        machine.load(model, state);
        self.loops.factor_regular(model, machine)?;
        self.directions.slope(Path::Time(state), (model, machine), &mut self.loops, &mut self.end_slope);
        state.rates_mut().copy_from_slice(&self.end_slope);
        Ok(())
    }

    /// The end as the derivatives at the start have it.
    fn predict(&mut self, model: &Model, path: Path, [s, h]: [f64; 2]) {
        self.end.copy_from(&self.start);
        path.signals(model, s + h, &mut self.end);
        let derivatives = self.slope.iter().zip(&self.curvature);
        for (q, (slope, curvature)) in self.end.positions_mut().iter_mut().zip(derivatives) {
            *q += h * (slope + 0.5 * h * curvature);
        }
    }

    /// Newton's method at the end, to rounding errors: near a singular pose what is left open in the loops would be a defect of length. The loops are factored there.
    fn correct(&mut self, context: &mut Context) -> bool {
        let Context { model, machine, statistics, .. } = context;
        let scales = || model.program().coordinates.iter().map(|coordinate| coordinate.scale);
        self.moved.fill(0.0);
        machine.load(model, &self.end);
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            if self.loops.factor(model, machine).is_err() {
                return false;
            }
            statistics.evaluations += 1;
            machine.evaluate(&model.program().tapes.constraint, &mut self.residuals);
            let correction = self.loops.solve(&self.residuals);
            let (mut size, mut largest) = (0.0, 1.0);
            for ((correction, q), scale) in correction.iter().zip(self.end.positions()).zip(scales()) {
                size = maximum(size, correction.abs() / scale);
                largest = maximum(largest, q.abs() / scale);
            }
            // Written so that NaN is a failure too.
            let (settled, contracts) = (size <= ROUNDING * largest, size <= CONTRACTION * last);
            if !settled && !contracts {
                return size <= STAGNANT * largest;
            }
            for ((q, moved), correction) in self.end.positions_mut().iter_mut().zip(&mut self.moved).zip(correction) {
                *q -= correction;
                *moved += correction;
            }
            machine.load_positions(model, self.end.positions());
            if settled {
                return true;
            }
            last = size;
        }
        false
    }

    /// Is the end on the branch of the start, and would it be at the end of a longer step?
    fn judge(&mut self, model: &Model, h: f64, crossing: bool) -> Option<bool> {
        let derivatives = self.slope.iter().zip(&self.curvature);
        for ((bend, end), (slope, curvature)) in self.bend.iter_mut().zip(&self.end_slope).zip(derivatives) {
            *bend = end - (slope + h * curvature);
        }
        let mut easy = true;
        for block in 0..self.loops.blocks() {
            let (ratio, distance) = (self.monitor.ratio(block), self.monitor.distance(block));
            let crosses = crossing && self.monitor.start_distance(block) < TOGETHER * NEAR;
            let size = if crosses { ratio.abs() } else { ratio };
            let correction = self.largest(model, block, &self.moved) / (CORRECTION * distance);
            let bend = h * self.largest(model, block, &self.bend) / (BEND * distance);
            // Written so that NaN is a rejection.
            let stays = (RATIO[0]..=RATIO[1]).contains(&size) && correction <= 1.0 && bend <= 1.0;
            if !stays {
                return None;
            }
            easy &= EASY_RATIO[0] < size && size < EASY_RATIO[1] && correction <= EASY && bend <= EASY;
        }
        Some(easy)
    }

    /// The largest of some values of a block's coordinates, in units of their scales.
    fn largest(&self, model: &Model, block: usize, values: &[f64]) -> f64 {
        let columns = self.loops.columns(block).iter();
        let sizes = columns.map(|&column| values[column].abs() / model.program().coordinates[column].scale);
        sizes.fold(0.0, maximum)
    }

    /// Loop equations that are not imposed hold by themselves.
    fn consistent(&self, model: &Model, tolerance: f64) -> Result<(), Rejection> {
        open_row(model, &self.residuals, tolerance).map_or(Ok(()), |row| Err(Rejection::Redundant(row)))
    }
}
