//! Small mechanisms written by hand, register by register, for the tests of the runtime.
#![allow(dead_code, reason = "every test binary uses its own part")]

use std::sync::Arc;

use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::*;
use cotree_fmu::tape::{Instruction, Operation, Tape};

/// Places reserved for constants.
const CONSTANTS: u32 = 32;

/// Writes tapes over one register file; scratch registers are never used twice.
pub struct Writer {
    layout: Layout,
    constants: Vec<f64>,
    next: u32,
    instructions: Vec<Instruction>,
}

impl Writer {
    pub fn new(layout: Layout) -> Self {
        let next = layout.constants() as u32 + CONSTANTS;
        Self { layout, constants: Vec::new(), next, instructions: Vec::new() }
    }

    pub fn constant(&mut self, value: f64) -> u32 {
        self.constants.push(value);
        assert!(self.constants.len() <= CONSTANTS as usize);
        self.layout.constants() as u32 + self.constants.len() as u32 - 1
    }

    pub fn op(&mut self, operation: Operation, a: u32, b: u32) -> u32 {
        self.next += 1;
        self.instructions.push(Instruction { operation, target: self.next - 1, a, b, c: 0 });
        self.next - 1
    }
    pub fn add(&mut self, a: u32, b: u32) -> u32 {
        self.op(Operation::Add, a, b)
    }
    pub fn sub(&mut self, a: u32, b: u32) -> u32 {
        self.op(Operation::Subtract, a, b)
    }
    pub fn mul(&mut self, a: u32, b: u32) -> u32 {
        self.op(Operation::Multiply, a, b)
    }
    pub fn div(&mut self, a: u32, b: u32) -> u32 {
        self.op(Operation::Divide, a, b)
    }
    pub fn neg(&mut self, a: u32) -> u32 {
        self.op(Operation::Negate, a, 0)
    }
    /// Sine and cosine.
    pub fn sin_cos(&mut self, a: u32) -> [u32; 2] {
        let (sine, cosine) = (self.next, self.next + 1);
        self.next += 2;
        self.instructions.push(Instruction { operation: Operation::SinCos, target: sine, a, b: 0, c: cosine });
        [sine, cosine]
    }
    /// Sum of products.
    pub fn dot(&mut self, pairs: &[(u32, u32)]) -> u32 {
        let products: Vec<u32> = pairs.iter().map(|&(a, b)| self.mul(a, b)).collect();
        products.into_iter().reduce(|sum, product| self.add(sum, product)).expect("at least one product")
    }
    /// Solves a symmetric definite or saddle-point system by elimination without pivoting.
    pub fn solve(&mut self, mut matrix: Vec<Vec<u32>>, mut right: Vec<u32>) -> Vec<u32> {
        let n = right.len();
        for k in 0..n {
            let pivot = matrix[k].clone();
            for i in k + 1..n {
                let factor = self.div(matrix[i][k], pivot[k]);
                for (entry, &above) in matrix[i].iter_mut().zip(&pivot).skip(k + 1) {
                    let product = self.mul(factor, above);
                    *entry = self.sub(*entry, product);
                }
                let product = self.mul(factor, right[k]);
                right[i] = self.sub(right[i], product);
            }
        }
        for k in (0..n).rev() {
            for j in k + 1..n {
                let product = self.mul(matrix[k][j], right[j]);
                right[k] = self.sub(right[k], product);
            }
            right[k] = self.div(right[k], matrix[k][k]);
        }
        right
    }
    pub fn tape(&mut self, results: Vec<u32>) -> Tape {
        Tape { instructions: std::mem::take(&mut self.instructions), results }
    }
    /// Completes a program.
    pub fn finish(mut self, mut program: Program) -> Program {
        self.constants.resize(CONSTANTS as usize, 0.0);
        program.constants = self.constants;
        program.registers = self.next;
        program
    }
}

pub fn parameter(name: &str, start: f64, tunable: bool) -> Parameter {
    Parameter { name: name.into(), start, min: None, max: None, tunable }
}

pub fn input(name: &str, start: f64) -> Input {
    Input { name: name.into(), start, min: None, max: None }
}

fn coordinate(name: &str) -> Coordinate {
    Coordinate { name: name.into(), scale: 1.0 }
}

fn constraint(owner: &str) -> Constraint {
    Constraint { owner: owner.into(), scale: 1.0, angular: false, active: true }
}

pub fn condition(name: &str, known: bool) -> Condition {
    Condition { name: name.into(), known, angular: true, scale: 1.0 }
}

pub fn variable(name: &str, source: Source) -> Variable {
    Variable { name: name.into(), source, initial: None }
}

fn output(result: u32, accelerated: bool) -> Source {
    Source::Output { result, accelerated }
}

fn empty(name: &str, motion: Motion) -> Program {
    Program {
        name: name.into(),
        guid: format!("{{{name}}}"),
        experiment: Experiment { start: 0.0, stop: 10.0, step: 1e-3, tolerance: 1e-8, max_step: f64::INFINITY },
        parameters: Vec::new(),
        inputs: Vec::new(),
        followers: Vec::new(),
        coordinates: Vec::new(),
        constraints: Vec::new(),
        motion,
        blocks: Vec::new(),
        length: 1.0,
        variables: Vec::new(),
        constants: Vec::new(),
        registers: 0,
        tapes: Tapes::default(),
        initial: Initial::default(),
        engine: cotree_fmu::program::Engine::Dop853,
        automatic: true,
        arms: None,
    }
}

/// Conditions whose values are registers and whose targets are constants.
pub fn conditions(
    writer: &mut Writer,
    list: &[(Condition, u32, f64)],
    column: impl Fn(u32) -> u32,
) -> (Vec<Condition>, Tape, SparseTape) {
    let values = list.iter().map(|item| item.1);
    let targets: Vec<u32> = list.iter().map(|item| writer.constant(item.2)).collect();
    let one = writer.constant(1.0);
    let tape = writer.tape(values.chain(targets).collect());
    let entries: Vec<_> = list.iter().enumerate().map(|(row, item)| (row as u32, column(item.1))).collect();
    let results = vec![one; entries.len()];
    let sparse = SparseTape { entries, tape: writer.tape(results) };
    (list.iter().map(|item| item.0.clone()).collect(), tape, sparse)
}

/// A mathematical pendulum of 1 kg: angle'' = -gravity / length sin(angle) + torque / length^2, from 1 rad at rest.
pub fn pendulum() -> Program {
    let mut program = empty("pendulum", Motion::Dynamic);
    program.parameters = vec![parameter("gravity", 9.81, true), parameter("length", 1.0, false)];
    program.parameters[1].min = Some(0.1);
    program.inputs = vec![input("torque", 0.0)];
    program.inputs[0].max = Some(100.0);
    program.coordinates = vec![coordinate("arm.angle")];
    let layout = program.layout();
    let mut w = Writer::new(layout);
    let [gravity, length] = [layout.parameters() as u32, layout.parameters() as u32 + 1];
    let [torque, q, v, a] =
        [layout.inputs(), layout.positions(), layout.rates(), layout.accelerations()].map(|place| place as u32);

    let stiffness = w.div(gravity, length);
    let inertia = w.mul(length, length);
    program.tapes.parameters = w.tape(vec![]);

    let [sine, _] = w.sin_cos(q);
    let restoring = w.mul(stiffness, sine);
    let drive = w.div(torque, inertia);
    let acceleration = w.sub(drive, restoring);
    program.tapes.acceleration = w.tape(vec![acceleration]);

    let [_, cosine] = w.sin_cos(q);
    let half = w.constant(0.5);
    let square = w.mul(v, v);
    let kinetic = w.dot(&[(half, square)]);
    let potential = w.mul(stiffness, cosine);
    let energy = w.sub(kinetic, potential);
    let tangential = w.mul(a, length);
    program.tapes.outputs = w.tape(vec![energy, tangential]);
    program.variables = vec![
        variable("time", Source::Time),
        variable("gravity", Source::Parameter(0)),
        variable("length", Source::Parameter(1)),
        variable("torque", Source::Input(0)),
        variable("arm.angle", Source::Coordinate(0)),
        variable("arm.omega", Source::Rate(0)),
        variable("arm.alpha", Source::Acceleration(0)),
        variable("energy", output(0, false)),
        variable("tangential", output(1, true)),
    ];
    let (list, tape, jacobian) = conditions(&mut w, &[(condition("arm.angle", true), q, 1.0)], |_| 0);
    (program.initial.positions, program.initial.position, program.initial.position_jacobian) = (list, tape, jacobian);
    w.finish(program)
}

/// The slider-crank of McPhee (1998), Eqs. (48)-(62): two angles, one loop equation, no gravity; the force on the slider is an
/// input. The crank's length is a parameter.
pub fn slider_crank() -> Program {
    let mut program = empty("slider_crank", Motion::Dynamic);
    program.parameters = vec![parameter("crank_length", 0.5, true)];
    program.inputs = vec![input("force", 0.0)];
    program.coordinates = vec![coordinate("crank.angle"), coordinate("rod.angle")];
    program.constraints = vec![constraint("wrist_pin")];
    let layout = program.layout();
    let mut w = Writer::new(layout);
    let [a, force, q, v] =
        [layout.parameters(), layout.inputs(), layout.positions(), layout.rates()].map(|place| place as u32);
    let [b, i1, m1, i2, m2, m3, l7] = [1.5, 0.04, 2.0, 0.6, 3.0, 1.0, 0.75].map(|value| w.constant(value));
    let zero = w.constant(0.0);
    let half = w.constant(0.5);

    let square = w.mul(a, a);
    let quarter = {
        let l5 = w.mul(half, a);
        w.mul(l5, l5)
    };
    let m23 = w.add(m2, m3);
    let m11 = w.dot(&[(m1, quarter), (m23, square)]);
    let m11 = w.add(i1, m11);
    let (l7_square, b_square) = (w.mul(l7, l7), w.mul(b, b));
    let m22 = w.dot(&[(m2, l7_square), (m3, b_square)]);
    let m22 = w.add(i2, m22);
    let coupling = w.dot(&[(m2, l7), (m3, b)]);
    let coupling = w.mul(coupling, a);
    program.tapes.parameters = w.tape(vec![]);

    struct Pose {
        phi: u32,
        phi_q: [u32; 2],
        m12: u32,
        cosine: u32,
        gradient: [u32; 2],
    }
    let pose = |w: &mut Writer| {
        let ([s1, c1], [s2, c2]) = (w.sin_cos(q), w.sin_cos(q + 1));
        let phi = w.dot(&[(a, s1), (b, c2)]);
        let j1 = w.mul(a, c1);
        let j2 = w.mul(b, s2);
        let j2 = w.neg(j2);
        let first = w.mul(s1, c2);
        let second = w.mul(c1, s2);
        let sine = w.sub(first, second);
        let m12 = w.mul(coupling, sine);
        let cosine = w.dot(&[(c1, c2), (s1, s2)]);
        let g1 = w.mul(a, s1);
        let g2 = w.mul(b, c2);
        Pose { phi, phi_q: [j1, j2], m12, cosine, gradient: [g1, g2] }
    };
    let system = |p: &Pose| {
        let [j1, j2] = p.phi_q;
        vec![vec![m11, p.m12, j1], vec![p.m12, m22, j2], vec![j1, j2, zero]]
    };

    let p = pose(&mut w);
    program.tapes.constraint = w.tape(vec![p.phi]);
    let p = pose(&mut w);
    program.tapes.jacobian = SparseTape { entries: vec![(0, 0), (0, 1)], tape: w.tape(p.phi_q.to_vec()) };
    let p = pose(&mut w);
    let rate = w.dot(&[(p.phi_q[0], v), (p.phi_q[1], v + 1)]);
    program.tapes.constraint_rate = w.tape(vec![rate]);

    let gamma = |w: &mut Writer, p: &Pose| {
        let (w1, w2) = (w.mul(v, v), w.mul(v + 1, v + 1));
        let gamma = w.dot(&[(p.gradient[0], w1), (p.gradient[1], w2)]);
        (gamma, w1, w2)
    };
    let p = pose(&mut w);
    let (g, _, _) = gamma(&mut w, &p);
    program.tapes.gamma = w.tape(vec![g]);

    let p = pose(&mut w);
    let (g, w1, w2) = gamma(&mut w, &p);
    let k = w.mul(coupling, p.cosine);
    let q1 = w.mul(k, w2);
    let q2 = w.mul(k, w1);
    let f1 = w.mul(force, p.gradient[0]);
    let f2 = w.mul(force, p.gradient[1]);
    let q1 = w.sub(q1, f1);
    let q2 = w.neg(q2);
    let q2 = w.sub(q2, f2);
    let solution = w.solve(system(&p), vec![q1, q2, g]);
    program.tapes.acceleration = w.tape(solution);

    let p = pose(&mut w);
    let right = w.neg(p.phi);
    let solution = w.solve(system(&p), vec![zero, zero, right]);
    program.tapes.project_position = w.tape(vec![p.phi, solution[0], solution[1]]);
    let p = pose(&mut w);
    let rate = w.dot(&[(p.phi_q[0], v), (p.phi_q[1], v + 1)]);
    let right = w.neg(rate);
    let solution = w.solve(system(&p), vec![zero, zero, right]);
    program.tapes.project_velocity = w.tape(vec![rate, solution[0], solution[1]]);

    let p = pose(&mut w);
    let [w1, w2, w12] = [w.mul(v, v), w.mul(v + 1, v + 1), w.mul(v, v + 1)];
    let (t1, t2, t12) = (w.mul(m11, w1), w.mul(m22, w2), w.mul(p.m12, w12));
    let diagonal = w.add(t1, t2);
    let kinetic = w.dot(&[(half, diagonal)]);
    let kinetic = w.add(kinetic, t12);
    let ([_, c1], [s2, _]) = (w.sin_cos(q), w.sin_cos(q + 1));
    let crank = w.mul(a, c1);
    let rod = w.mul(b, s2);
    let slider = w.sub(crank, rod);
    program.tapes.outputs = w.tape(vec![kinetic, slider, p.phi, layout.reactions() as u32]);
    program.variables = vec![
        variable("time", Source::Time),
        variable("crank_length", Source::Parameter(0)),
        variable("force", Source::Input(0)),
        variable("crank.angle", Source::Coordinate(0)),
        variable("rod.angle", Source::Coordinate(1)),
        variable("crank.omega", Source::Rate(0)),
        variable("rod.omega", Source::Rate(1)),
        variable("energy.kinetic", output(0, false)),
        variable("slider.x", output(1, false)),
        variable("constraint.position", output(2, false)),
        variable("cylinder.fn", output(3, true)),
        variable("crank.alpha", Source::Acceleration(0)),
    ];
    let positions = [(condition("crank.angle", true), q, 0.6), (condition("rod.angle", false), q + 1, -1.5)];
    let initial = &mut program.initial;
    (initial.positions, initial.position, initial.position_jacobian) =
        conditions(&mut w, &positions, |register| register - q);
    (initial.velocities, initial.velocity, initial.velocity_jacobian) =
        conditions(&mut w, &[(condition("crank.omega", true), v, 4.0)], |register| register - v);
    w.finish(program)
}

/// What turns the crank of the four-bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    Time,
    Position,
    Velocity,
    Acceleration,
}

/// Lengths of the four-bar: crank, coupler, rocker, ground.
pub const FOUR_BAR: [f64; 4] = [1.0, 3.0, 2.5, 3.5];
/// Moment of inertia of its rocker.
pub const ROCKER: f64 = 0.7;
/// Speed of its crank if driven by time.
pub const SPEED: f64 = 2.0;

/// A four-bar with a driven crank: coupler and rocker angles, two loop equations. The rocker has an inertia and a load torque;
/// the driver's torque follows from the reactions. With `redundant`, a copy of the first equation is listed as inactive.
pub fn four_bar(drive: Drive, redundant: bool) -> Program {
    let mut program = empty("four_bar", Motion::Kinematic);
    program.parameters = vec![parameter("ground_length", FOUR_BAR[3], true)];
    program.inputs = vec![input("load", 0.0), input("crank_drive", 0.0)];
    program.coordinates = vec![coordinate("coupler.angle"), coordinate("rocker.angle")];
    program.constraints = vec![constraint("rocker_pin"), constraint("rocker_pin")];
    program.blocks = vec![Block { rows: vec![0, 1], columns: vec![0, 1] }];
    if redundant {
        program.constraints.push(Constraint { active: false, ..constraint("spare_pin") });
    }
    let order = match drive {
        Drive::Velocity => Some(FollowerOrder::Velocity),
        Drive::Acceleration => Some(FollowerOrder::Acceleration),
        Drive::Time | Drive::Position => None,
    };
    program.followers.extend(order.map(|order| Follower { name: "motor".into(), input: 1, order, scale: 1.0 }));
    let layout = program.layout();
    let mut w = Writer::new(layout);
    let register = |place: usize| place as u32;
    let [q, v] = [layout.positions(), layout.rates()].map(register);
    let ground = register(layout.parameters());
    let [crank, coupler, rocker] = [0, 1, 2].map(|index| w.constant(FOUR_BAR[index]));
    let [speed, zero, inertia] = [SPEED, 0.0, ROCKER].map(|value| w.constant(value));

    // Angle of the crank, its rate and its acceleration.
    let driven = |w: &mut Writer| match drive {
        Drive::Time => [w.mul(speed, 0), speed, zero],
        Drive::Position => {
            [layout.inputs(), layout.input_rates(), layout.input_accelerations()].map(|place| register(place) + 1)
        }
        Drive::Velocity | Drive::Acceleration => {
            [layout.followers(), layout.follower_rates(), layout.follower_accelerations()].map(register)
        }
    };
    // (sine, cosine) times length of the three moving bars.
    let bars = |w: &mut Writer, angle: u32| {
        [(crank, angle), (coupler, q), (rocker, q + 1)].map(|(length, angle)| {
            let [sine, cosine] = w.sin_cos(angle);
            [w.mul(length, sine), w.mul(length, cosine)]
        })
    };
    let extend = |mut rows: Vec<u32>| {
        if redundant {
            rows.push(rows[0]);
        }
        rows
    };

    let [angle, _, _] = driven(&mut w);
    let [[s1, c1], [s2, c2], [s3, c3]] = bars(&mut w, angle);
    let x = w.add(c1, c2);
    let x = w.sub(x, c3);
    let x = w.sub(x, ground);
    let y = w.add(s1, s2);
    let y = w.sub(y, s3);
    program.tapes.constraint = w.tape(extend(vec![x, y]));

    let [angle, _, _] = driven(&mut w);
    let [[s1, c1], [s2, c2], [s3, c3]] = bars(&mut w, angle);
    let (minus_s1, minus_s2, minus_c3) = (w.neg(s1), w.neg(s2), w.neg(c3));
    let mut entries = vec![(0, 0), (0, 1), (1, 0), (1, 1)];
    let mut results = vec![minus_s2, s3, c2, minus_c3];
    if order.is_some() {
        entries.extend([(0, 2), (1, 2)]);
        results.extend([minus_s1, c1]);
    }
    if redundant {
        entries.extend([(2, 0), (2, 1)]);
        results.extend([minus_s2, s3]);
        if order.is_some() {
            entries.push((2, 2));
            results.push(minus_s1);
        }
    }
    program.tapes.jacobian = SparseTape { entries, tape: w.tape(results) };

    let [angle, omega, _] = driven(&mut w);
    let [[s1, c1], [s2, c2], [s3, c3]] = bars(&mut w, angle);
    let x = w.dot(&[(s1, omega), (s2, v)]);
    let third = w.mul(s3, v + 1);
    let x = w.sub(third, x);
    let y = w.dot(&[(c1, omega), (c2, v)]);
    let third = w.mul(c3, v + 1);
    let y = w.sub(y, third);
    program.tapes.constraint_rate = w.tape(extend(vec![x, y]));

    let [angle, omega, alpha] = driven(&mut w);
    let [[s1, c1], [s2, c2], [s3, c3]] = bars(&mut w, angle);
    let squares = [w.mul(omega, omega), w.mul(v, v), w.mul(v + 1, v + 1)];
    let x = w.dot(&[(s1, alpha), (c1, squares[0]), (c2, squares[1])]);
    let third = w.mul(c3, squares[2]);
    let x = w.sub(x, third);
    let y = w.dot(&[(s1, squares[0]), (s2, squares[1])]);
    let third = w.mul(s3, squares[2]);
    let y = w.sub(y, third);
    let tangential = w.mul(c1, alpha);
    let y = w.sub(y, tangential);
    program.tapes.gamma = w.tape(extend(vec![x, y]));

    let inertial = w.mul(inertia, register(layout.accelerations()) + 1);
    let moment = w.sub(register(layout.inputs()), inertial);
    program.tapes.inverse = Some(w.tape(vec![zero, moment]));

    let [angle, omega, _] = driven(&mut w);
    let [[s1, c1], _, _] = bars(&mut w, angle);
    let lambda = register(layout.reactions());
    let first = w.mul(s1, lambda);
    let second = w.mul(c1, lambda + 1);
    let torque = w.sub(second, first);
    program.tapes.outputs = w.tape(vec![angle, omega, torque]);
    program.variables = vec![
        variable("time", Source::Time),
        variable("ground_length", Source::Parameter(0)),
        variable("load", Source::Input(0)),
        variable("crank_drive", Source::Input(1)),
        variable("coupler.angle", Source::Coordinate(0)),
        variable("rocker.angle", Source::Coordinate(1)),
        variable("coupler.omega", Source::Rate(0)),
        variable("rocker.omega", Source::Rate(1)),
        variable("rocker.alpha", Source::Acceleration(1)),
        variable("crank.angle", output(0, false)),
        variable("crank.omega", output(1, false)),
        variable("motor.torque", output(2, true)),
    ];
    let mut positions =
        vec![(condition("coupler.angle", false), q, 0.6), (condition("rocker.angle", false), q + 1, 1.2)];
    if order.is_some() {
        positions.push((condition("crank.angle", true), register(layout.followers()), 0.1));
    }
    let initial = &mut program.initial;
    let column = |r: u32| if r >= q { r - q } else { 2 };
    (initial.positions, initial.position, initial.position_jacobian) = conditions(&mut w, &positions, column);
    w.finish(program)
}

/// An instance that is ready to step from time 0.
pub fn started(program: Program) -> Instance {
    let mut instance = unstarted(program);
    instance.initialise().expect("consistent");
    instance
}

/// An instance that is set up for time 0.
pub fn unstarted(program: Program) -> Instance {
    let mut instance = Instance::new(Arc::new(Model::new(program).expect("a sound program")));
    instance.setup(0.0, None, None).expect("a possible experiment");
    instance
}

/// The value of a variable by name.
pub fn value(instance: &mut Instance, name: &str) -> f64 {
    let index = instance.variable(name).expect("known name");
    instance.get(index).expect("defined")
}

/// Sets a variable by name.
pub fn set(instance: &mut Instance, name: &str, value: f64) {
    let index = instance.variable(name).expect("known name");
    instance.set(index, value).expect("permitted");
}

/// Lets an initial value be set under the name of its variable: its target, a constant so far, becomes a parameter. Returns the parameter.
pub fn initial_parameter(program: &mut Program, name: &str) -> Option<u32> {
    let row = program.initial.positions.iter().position(|condition| condition.name == name)?;
    let before = program.layout();
    let target = program.initial.position.results[program.initial.positions.len() + row];
    let value = program.constants[target as usize - before.constants()];
    let place = program.parameters.len() as u32;
    program.parameters.push(parameter(name, value, false));
    shift(program, before.inputs() as u32);
    let conditions = program.initial.positions.len();
    program.initial.position.results[conditions + row] = before.inputs() as u32;
    program.variables.iter_mut().find(|variable| variable.name == name)?.initial = Some(place);
    Some(place)
}

/// Makes room for one more register at `from`.
fn shift(program: &mut Program, from: u32) {
    let (tapes, initial) = (&mut program.tapes, &mut program.initial);
    let every = [
        &mut tapes.parameters,
        &mut tapes.constraint,
        &mut tapes.jacobian.tape,
        &mut tapes.constraint_rate,
        &mut tapes.gamma,
        &mut tapes.acceleration,
        &mut tapes.project_position,
        &mut tapes.project_velocity,
        &mut tapes.indicators,
        &mut tapes.outputs,
        &mut initial.position,
        &mut initial.position_jacobian.tape,
        &mut initial.velocity,
        &mut initial.velocity_jacobian.tape,
    ];
    let moved = |register: &mut u32| *register += u32::from(*register >= from);
    for tape in every.into_iter().chain(&mut tapes.inverse) {
        tape.results.iter_mut().for_each(moved);
        for instruction in &mut tape.instructions {
            let Instruction { target, a, b, c, .. } = instruction;
            [target, a, b, c].into_iter().for_each(moved);
        }
    }
    program.registers += 1;
}
