//! A body that is pulled: the pose next to the present one in which one of its points is nearest to a place.
//!
//! Unknowns are the coordinates, what drivers integrate, and what is released: parameters and inputs that prescribe something. The loops are kept closed; of all small
//! motions that bring the point nearer the smallest is taken, in the scales of the unknowns. A step is short against the distance from poses where branches meet:
//! none can lead over to another branch.
//!
//! The runtime for browsers in `tools/web` takes this file in, so that it needs nothing of this package.

mod plane;

use std::collections::HashMap;
use std::sync::Arc;

use cotree_fmu::machine::Machine;
use cotree_fmu::math::{maximum, minimum, sin_cos};
use cotree_fmu::model::{Model, State};
use cotree_fmu::program::{Program, Source};

use plane::{Basis, length};

/// Longest step, in the scales of the unknowns: an angle of nine degrees.
const LONGEST: f64 = 0.15;
/// A step is so long against the distance from a singular pose.
const SHARE: f64 = 0.5;
/// So near to a singular pose nothing is pulled any nearer.
const NEAR: f64 = 1e-3;
/// Steps of one pull.
const STEPS: usize = 60;
/// Newton steps that close the loops.
const CLOSING: usize = 8;
/// A step that cannot be taken is halved so often.
const HALVINGS: usize = 10;
/// What counts as closed, and as arrived, relative to the scales.
const CLOSED: f64 = 1e-10;
/// The point comes no nearer: a share of what it could.
const IDLE: f64 = 1e-4;
/// Against what it was: the motion of a point that comes to a dead point.
const DEAD: f64 = 0.02;
/// Less than this of a unit of motion is none.
const STILL: f64 = 1e-9;
/// Of the least squares, relative to their trace: directions in which the point hardly moves are left alone.
const DAMPING: f64 = 1e-6;

/// How a pull has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PullEnd {
    /// The point is there, or as near as its path comes.
    Near = 0,
    /// It is on its way: steps ran out.
    OnItsWay = 1,
    /// A dead point: no motion takes it farther that way.
    DeadPoint = 2,
    /// Branches of the motion meet: beyond it would not be certain which is meant.
    Singular = 3,
    /// Nothing moves the point.
    Fixed = 4,
    /// Nothing moves at all: no freedom is left.
    Held = 5,
}

struct Unknown {
    register: usize,
    scale: f64,
}

/// A body and the pose that it is pulled in.
pub struct Grip {
    model: Arc<Model>,
    machine: Machine,
    state: State,
    unknowns: Vec<Unknown>,
    /// Registers of the body's place and angle.
    body: [usize; 3],
    tangents: Vec<f64>,
    /// The most that the point has moved with the unknowns, and the most across that.
    most: [f64; 2],
}

/// Where a point is, and how it moves along each free direction.
struct Point {
    at: [f64; 2],
    rates: Vec<[f64; 2]>,
}

impl Grip {
    /// `positions` are the coordinates of the pose, `released` the places of parameters and inputs that are free, each with whether it is an angle, and `body` those of the
    /// body's place and angle.
    ///
    /// # Errors
    /// Why the body cannot be pulled.
    pub fn new(
        model: Arc<Model>,
        mut state: State,
        positions: &[f64],
        released: &[(usize, bool)],
        body: [usize; 3],
    ) -> Result<Self, String> {
        let program = model.program();
        if positions.len() != program.coordinates.len() {
            return Err("the configuration has another number of coordinates".to_owned());
        }
        state.positions_mut().copy_from_slice(positions);
        state.rates_mut().fill(0.0);
        let unknowns = unknowns(&model, released)?;
        let fixed = program.coordinates.len();
        let mut registers = [0; 3];
        for (register, variable) in registers.iter_mut().zip(body) {
            *register = place(&model, variable).ok_or("the body has no point that could be pulled")?;
        }
        let mut machine = Machine::new(&model);
        machine.load(&model, &state);
        let tangents = vec![0.0; machine.registers().len()];
        let mut grip = Self { model, machine, state, unknowns, body: registers, tangents, most: [0.0; 2] };
        // What is released follows the pose, not the pose what is released.
        grip.close(fixed..grip.unknowns.len(), f64::INFINITY);
        match grip.close(0..grip.unknowns.len(), f64::INFINITY) {
            Some(_) => Ok(grip),
            None => Err("the loops do not close in this configuration".to_owned()),
        }
    }

    /// The same pose at another time.
    pub fn set_time(&mut self, time: f64) {
        let place = self.model.layout().time();
        self.state.registers_mut()[place] = time;
    }

    /// The pose with the time, the parameters and the inputs of another state.
    pub fn at_the_values_of(&self, other: &State) -> State {
        let mut pose = other.clone();
        pose.positions_mut().copy_from_slice(self.state.positions());
        pose.follower_positions_mut().copy_from_slice(self.state.follower_positions());
        pose
    }

    /// Values of variables in this pose, at rest; not a number for what only a motion has.
    pub fn values(&mut self, variables: &[u32], values: &mut [f64]) {
        self.machine.load(&self.model, &self.state);
        self.machine.run(&self.model.program().tapes.outputs);
        for (value, &variable) in values.iter_mut().zip(variables) {
            let register = place(&self.model, variable as usize);
            *value = register.map_or(f64::NAN, |register| self.machine.registers()[register]);
        }
    }

    /// Pulls a point of the body, in the body's axes, to a place.
    pub fn pull(&mut self, point: [f64; 2], target: [f64; 2]) -> PullEnd {
        let reach = self.model.program().length;
        let mut basis = self.basis(0..self.unknowns.len());
        for _ in 0..STEPS {
            let free = basis.rest(self.unknowns.len());
            if free.is_empty() {
                return PullEnd::Held;
            }
            let Point { at, rates } = self.point(point, &free);
            let missing = [(target[0] - at[0]) / reach, (target[1] - at[1]) / reach];
            let distance = length(&missing);
            let rates: Vec<[f64; 2]> = rates.iter().map(|rate| rate.map(|one| one / reach)).collect();
            let speeds = speeds(&rates);
            self.most = [0, 1].map(|axis| maximum(self.most[axis], speeds[axis]));
            let gain = length(&rates.iter().map(|[x, y]| x * missing[0] + y * missing[1]).collect::<Vec<f64>>());
            if distance <= CLOSED {
                return PullEnd::Near;
            }
            if gain <= IDLE * distance * self.most[0] {
                return self.stop(speeds, 1.0);
            }
            let along = least(&rates, missing);
            let step: Vec<f64> = (0..self.unknowns.len())
                .map(|place| free.iter().zip(&along).map(|(way, share)| way[place] * share).sum())
                .collect();
            let near = basis.smallest;
            let longest = minimum(LONGEST, SHARE * near);
            match self.step(&step, longest, (point, target, distance * reach), near) {
                Some(next) => basis = next,
                None if near < 2.0 * NEAR => return PullEnd::Singular,
                None => return self.stop(speeds, 4.0),
            }
        }
        PullEnd::OnItsWay
    }

    /// What stops the point that comes no nearer: it moves no more, or no more in both directions in which it has moved.
    fn stop(&self, speeds: [f64; 2], share: f64) -> PullEnd {
        let [most, across] = self.most;
        if most <= STILL {
            return PullEnd::Fixed;
        }
        let is_dead = |axis: usize| speeds[axis] <= share * DEAD * self.most[axis];
        if is_dead(0) || across > DEAD * most && is_dead(1) { PullEnd::DeadPoint } else { PullEnd::Near }
    }

    /// A step that brings the point nearer, shorter than wanted if it must be; the basis of the pose that it leads to.
    fn step(
        &mut self,
        step: &[f64],
        longest: f64,
        (point, target, before): ([f64; 2], [f64; 2], f64),
        near: f64,
    ) -> Option<Basis> {
        let full = length(step);
        let from = self.state.clone();
        let mut share = minimum(1.0, longest / full);
        for _ in 0..HALVINGS {
            self.shift(0..step.len(), step, share);
            let moved = self.close(0..step.len(), SHARE * share * full);
            if moved.is_some() {
                let Point { at, .. } = self.point(point, &[]);
                let basis = self.basis(0..step.len());
                let nearer = length(&[target[0] - at[0], target[1] - at[1]]) < before;
                if nearer && (basis.smallest >= NEAR || basis.smallest > near) {
                    return Some(basis);
                }
            }
            self.state.copy_from(&from);
            share *= 0.5;
        }
        self.machine.load(&self.model, &self.state);
        None
    }

    /// Closes the loops by the smallest motion of some unknowns; how far they moved, or none if they do not close within reach.
    fn close(&mut self, some: std::ops::Range<usize>, reach: f64) -> Option<f64> {
        let mut moved = 0.0;
        for _ in 0..CLOSING {
            let gaps = self.gaps();
            let largest = gaps.iter().map(|gap| gap.abs()).fold(0.0, maximum);
            if largest <= CLOSED {
                return Some(moved);
            }
            if !largest.is_finite() || some.is_empty() {
                return None;
            }
            let basis = self.basis(some.clone());
            let correction = basis.solve(&gaps);
            moved += length(&correction);
            self.shift(some.clone(), &correction, -1.0);
            if moved > reach {
                return None;
            }
        }
        None
    }

    /// Moves some unknowns.
    fn shift(&mut self, some: std::ops::Range<usize>, step: &[f64], share: f64) {
        for (unknown, step) in self.unknowns[some].iter().zip(step) {
            self.state.registers_mut()[unknown.register] += share * step * unknown.scale;
        }
        self.model.follow(self.state.registers_mut());
        self.machine.load(&self.model, &self.state);
    }

    /// The gaps of the loops, relative to their scales.
    fn gaps(&mut self) -> Vec<f64> {
        let program = self.model.program();
        self.machine.load(&self.model, &self.state);
        let mut gaps = vec![0.0; program.constraints.len()];
        self.machine.evaluate(&program.tapes.constraint, &mut gaps);
        gaps.iter_mut().zip(&program.constraints).for_each(|(gap, constraint)| *gap /= constraint.scale);
        gaps
    }

    /// What the loops hold, of some unknowns, as an orthonormal basis.
    fn basis(&mut self, some: std::ops::Range<usize>) -> Basis {
        let model = Arc::clone(&self.model);
        let program = model.program();
        self.machine.load(&model, &self.state);
        let mut rows = vec![vec![0.0; some.len()]; program.constraints.len()];
        let mut column = vec![0.0; program.constraints.len()];
        for (place, unknown) in some.enumerate() {
            let scale = self.unknowns[unknown].scale;
            self.along(&[(self.unknowns[unknown].register, scale)]);
            self.machine.differentiate(&program.tapes.constraint, &mut self.tangents, &mut column);
            for ((row, value), constraint) in rows.iter_mut().zip(&column).zip(&program.constraints) {
                row[place] = value / constraint.scale;
            }
        }
        let sizes = sizes(program, &rows);
        Basis::new(rows, &sizes, model.active().len())
    }

    /// Seeds the tangents with a direction, and brings those of what depends on parameters up to date.
    fn along(&mut self, direction: &[(usize, f64)]) {
        self.tangents.fill(0.0);
        direction.iter().for_each(|&(register, rate)| self.tangents[register] = rate);
        self.machine.differentiate(&self.model.program().tapes.parameters, &mut self.tangents, &mut []);
    }

    /// A point of the body, and its rates along some directions of the unknowns.
    fn point(&mut self, [x, y]: [f64; 2], ways: &[Vec<f64>]) -> Point {
        let model = Arc::clone(&self.model);
        let outputs = &model.program().tapes.outputs;
        self.machine.load(&model, &self.state);
        self.machine.run(outputs);
        let [left, up, angle] = self.body.map(|register| self.machine.registers()[register]);
        let (sine, cosine) = sin_cos(angle);
        let arm = [cosine * x - sine * y, sine * x + cosine * y];
        let rates = ways.iter().map(|way| {
            let seeds: Vec<(usize, f64)> =
                self.unknowns.iter().zip(way).map(|(unknown, way)| (unknown.register, way * unknown.scale)).collect();
            self.along(&seeds);
            self.machine.differentiate(outputs, &mut self.tangents, &mut []);
            let [vx, vy, omega] = self.body.map(|register| self.tangents[register]);
            [vx - omega * arm[1], vy + omega * arm[0]]
        });
        let rates = rates.collect();
        Point { at: [left + arm[0], up + arm[1]], rates }
    }
}

/// What a row of a loop is small against: the largest row of its joint. Both of a pin are not small but where branches meet or nothing can turn.
fn sizes(program: &Program, rows: &[Vec<f64>]) -> Vec<f64> {
    let owners = program.constraints.iter().map(|constraint| constraint.owner.as_str());
    let mut largest: HashMap<&str, f64> = HashMap::new();
    for (owner, row) in owners.clone().zip(rows) {
        let size = largest.entry(owner).or_default();
        *size = maximum(*size, length(row));
    }
    owners.map(|owner| largest.get(owner).copied().unwrap_or_default()).collect()
}

/// Coordinates, what drivers integrate, and what is released.
fn unknowns(model: &Model, released: &[(usize, bool)]) -> Result<Vec<Unknown>, String> {
    let (program, layout) = (model.program(), model.layout());
    let coordinates = program.coordinates.iter().map(|coordinate| coordinate.scale).zip(layout.positions()..);
    let followers = program.followers.iter().map(|follower| follower.scale).zip(layout.followers()..);
    let released = released.iter().map(|&(variable, angle)| {
        let source = program.variables.get(variable).map(|variable| variable.source);
        let register = match source {
            Some(Source::Parameter(index)) => layout.parameters() + index as usize,
            Some(Source::Input(index)) => layout.inputs() + index as usize,
            _ => return Err("only parameters and inputs can be released".to_owned()),
        };
        Ok(Unknown { register, scale: if angle { 1.0 } else { program.length } })
    });
    let known = coordinates.chain(followers).map(|(scale, register)| Ok(Unknown { register, scale }));
    known.chain(released).collect()
}

/// The register that has a variable once the outputs have been computed.
fn place(model: &Model, variable: usize) -> Option<usize> {
    let (program, layout) = (model.program(), model.layout());
    match program.variables.get(variable)?.source {
        Source::Time => Some(layout.time()),
        Source::Parameter(index) => Some(layout.parameters() + index as usize),
        Source::Discrete(index) => Some(layout.discrete() + index as usize),
        Source::Input(index) => Some(layout.inputs() + index as usize),
        Source::Output { result, accelerated: false } => {
            program.tapes.outputs.results.get(result as usize).map(|&register| register as usize)
        }
        Source::Coordinate(index) => Some(layout.positions() + index as usize),
        Source::Output { accelerated: true, .. } | Source::Rate(_) | Source::Acceleration(_) => None,
    }
}

/// How far a point moves at most with a unit of motion, and across that.
fn speeds(rates: &[[f64; 2]]) -> [f64; 2] {
    let sum = |of: fn(&[f64; 2]) -> f64| rates.iter().map(of).sum::<f64>();
    let (a, b, c) = (sum(|[x, _]| x * x), sum(|[x, y]| x * y), sum(|[_, y]| y * y));
    let (middle, half) = (0.5 * (a + c), length(&[0.5 * (a - c), b]));
    [(middle + half).sqrt(), maximum(middle - half, 0.0).sqrt()]
}

/// The smallest motion along the free directions that adds what is missing, as far as they can.
fn least(rates: &[[f64; 2]], [x, y]: [f64; 2]) -> Vec<f64> {
    let sum = |of: fn(&[f64; 2]) -> f64| rates.iter().map(of).sum::<f64>();
    let (a, b, c) = (sum(|[x, _]| x * x), sum(|[x, y]| x * y), sum(|[_, y]| y * y));
    let damping = DAMPING * (a + c);
    let (a, c) = (a + damping, c + damping);
    let size = a * c - b * b;
    let [u, v] = [(c * x - b * y) / size, (a * y - b * x) / size];
    rates.iter().map(|[x, y]| x * u + y * v).collect()
}
