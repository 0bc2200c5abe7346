//! The accelerations at the three nodes of an implicit step in one pass of their kernel, and four columns of their Jacobian in another.

use super::radau::Nodes;
use crate::context::Context;
use crate::integrator::right_hand_side::{Derivative, RightHandSide};
use crate::linalg::lane::{Lane, WIDTH, ZERO, splat};
use crate::machine::Machine;
use crate::model::{Model, State, motion as range};
use crate::tape::{LANE_DIRECTIONS, Lanes, Tape};

/// Storage; by default, none.
#[derive(Clone, Debug, Default)]
pub(crate) struct Batched {
    /// The states at the nodes, side by side; the last one twice.
    registers: Vec<Lane>,
    /// Derivatives along four directions.
    tangents: Vec<Lane>,
    /// Derivatives along some directions, at the nodes; none if one Jacobian serves all of them.
    several: Vec<Lanes>,
    /// Registers that the kernel reads besides q and v: what may change with time, and what may not.
    signals: Vec<usize>,
    constants: Vec<usize>,
    /// Those of q and v, counted from q on, that the kernel reads.
    directions: Vec<usize>,
}

/// (q, v)' with the signals continued from `origin`, at three points at once.
pub(crate) struct States<'a> {
    motion: RightHandSide<'a>,
    batched: &'a mut Batched,
    /// The times that the signals are for.
    times: Option<[f64; 3]>,
}

impl Batched {
    /// Storage for a model; has each node its own Jacobian?
    pub fn new(model: &Model, each: bool) -> Self {
        let (program, layout) = (model.program(), model.layout());
        let size = program.registers as usize;
        // What is judged beside the accelerations may depend on parameters alone: then no instruction of the kernel writes it.
        let judged = program.tapes.reciprocal_pivots.iter();
        let judged = judged.map(|&register| register as usize);
        let read = read(&program.tapes.acceleration, judged, size);
        let moving = range(layout);
        let is_signal =
            |register: &usize| *register == layout.time() || (layout.inputs()..layout.positions()).contains(register);
        let (signals, others) = read.into_iter().partition::<Vec<_>, _>(is_signal);
        let (moved, constants) = others.into_iter().partition::<Vec<_>, _>(|register| moving.contains(register));
        let directions = moved.into_iter().map(|register| register - moving.start).collect();
        Self {
            registers: vec![ZERO; size],
            tangents: vec![ZERO; size],
            several: vec![[ZERO; LANE_DIRECTIONS]; if each { size } else { 0 }],
            signals,
            constants,
            directions,
        }
    }

    /// The derivative for the stages of a step; parameters are those in the machine.
    pub fn states<'a>(&'a mut self, context: &'a mut Context<'_>, origin: &'a State) -> States<'a> {
        for &register in &self.constants {
            self.registers[register] = splat(context.machine.registers()[register]);
        }
        States { motion: RightHandSide::new(context, origin), batched: self, times: None }
    }

    /// Registers as the last pass at the nodes has left them.
    pub fn registers(&self) -> &[Lane] {
        &self.registers
    }

    /// Derivatives of the accelerations by q and by v, row by row, at the state in the machine.
    pub fn differentiate(&mut self, model: &Model, machine: &mut Machine, by_q: &mut [f64], by_v: &mut [f64]) {
        let (n, first) = (model.coordinates(), model.layout().positions());
        let tape = &model.program().tapes.acceleration;
        by_q.fill(0.0);
        by_v.fill(0.0);
        for four in self.directions.chunks(WIDTH) {
            let seeds = || four.iter().enumerate();
            seeds().for_each(|(place, direction)| self.tangents[first + direction][place] = 1.0);
            machine.run_tangents(tape, &mut self.tangents);
            seeds().for_each(|(place, direction)| self.tangents[first + direction][place] = 0.0);
            for (place, &direction) in seeds() {
                let matrix = if direction < n { &mut *by_q } else { &mut *by_v };
                let column = matrix.iter_mut().skip(direction % n).step_by(n);
                column.zip(&tape.results).for_each(|(entry, &row)| *entry = self.tangents[row as usize][place]);
            }
        }
    }
}

impl Derivative for States<'_> {
    fn evaluate(&mut self, time: f64, y: &[f64], derivative: &mut [f64]) {
        self.motion.evaluate(time, y, derivative);
    }
}

impl Nodes for States<'_> {
    fn evaluate_nodes(&mut self, times: [f64; 3], points: &[Lane], derivatives: &mut [Lane]) {
        self.load(times, points);
        self.motion.model.program().tapes.acceleration.run_lanes(&mut self.batched.registers);
        self.read(points, derivatives);
        self.motion.statistics.evaluations += 3;
    }

    fn differentiate_nodes(
        &mut self,
        times: [f64; 3],
        points: &[Lane],
        derivatives: &mut [Lane],
        jacobians: &mut [Lane],
    ) {
        self.load(times, points);
        let Self { motion: RightHandSide { model, .. }, batched, .. } = self;
        let (n, first) = (model.coordinates(), model.layout().positions());
        let tape = &model.program().tapes.acceleration;
        let Batched { registers, several, directions, .. } = &mut **batched;
        jacobians.fill(ZERO);
        if directions.is_empty() {
            // What depends on time alone has slopes all the same.
            tape.run_lanes(registers);
        }
        for some in directions.chunks(LANE_DIRECTIONS) {
            let seeds = || some.iter().enumerate();
            seeds().for_each(|(place, direction)| several[first + direction][place] = splat(1.0));
            tape.run_lanes_tangents(registers, several);
            seeds().for_each(|(place, direction)| several[first + direction][place] = ZERO);
            for (place, &direction) in seeds() {
                let column = jacobians[direction / n * n * n..].iter_mut().skip(direction % n).step_by(n);
                let rows = column.take(n).zip(&tape.results);
                rows.for_each(|(entry, &row)| *entry = several[row as usize][place]);
            }
        }
        self.read(points, derivatives);
        self.motion.statistics.evaluations += 3;
    }
}

impl States<'_> {
    /// Brings the states at the nodes into the registers.
    fn load(&mut self, times: [f64; 3], points: &[Lane]) {
        let Self { motion: RightHandSide { model, machine, origin, .. }, batched, times: known } = self;
        let Batched { registers, signals, .. } = &mut **batched;
        if !signals.is_empty() && *known != Some(times) {
            for (place, time) in times.into_iter().enumerate() {
                machine.load_signals(model, origin, time);
                signals.iter().for_each(|&register| registers[register][place] = machine.registers()[register]);
            }
            signals.iter().for_each(|&register| registers[register][3] = registers[register][2]);
            *known = Some(times);
        }
        registers[range(model.layout())].copy_from_slice(points);
    }

    /// What the kernel has left there.
    fn read(&self, points: &[Lane], derivatives: &mut [Lane]) {
        let Self { motion: RightHandSide { model, .. }, batched, .. } = self;
        let (rates, accelerations) = derivatives.split_at_mut(model.coordinates());
        rates.copy_from_slice(&points[rates.len()..]);
        let results = &model.program().tapes.acceleration.results;
        accelerations.iter_mut().zip(results).for_each(|(a, &row)| *a = batched.registers[row as usize]);
    }
}

/// Registers that a tape and others read and that it does not write before, in ascending order.
fn read(tape: &Tape, others: impl Iterator<Item = usize>, size: usize) -> Vec<usize> {
    let (mut read, mut written) = (vec![false; size], vec![false; size]);
    for instruction in tape.instructions() {
        for register in instruction.operands().map(|register| register as usize) {
            read[register] |= !written[register];
        }
        instruction.targets().for_each(|register| written[register as usize] = true);
    }
    for register in tape.results.iter().map(|&register| register as usize).chain(others) {
        read[register] |= !written[register];
    }
    (0..size).filter(|&register| read[register]).collect()
}
