//! Small mechanisms written by hand, register by register, for the tests of the runtime.
#![allow(dead_code, unused_imports, reason = "every test binary uses its own part")]

mod four_bar;
mod pendulum;
mod slider_crank;
mod writer;

use std::sync::Arc;

use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::*;
use cotree_fmu::tape::{Instruction, Tape};

pub use four_bar::*;
pub use pendulum::pendulum;
pub use slider_crank::slider_crank;
pub use writer::Writer;

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
    Constraint { owner: owner.into(), scale: 1.0, measure: GapMeasure::Length, role: Role::Imposed, implied: false }
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

fn empty(name: &str) -> Program {
    Program {
        name: name.into(),
        guid: format!("{{{name}}}"),
        experiment: Experiment {
            start: 0.0,
            stop: 10.0,
            step: 1e-3,
            tolerance: 1e-8,
            max_step: f64::INFINITY,
            budget: f64::INFINITY,
        },
        parameters: Vec::new(),
        discrete: Vec::new(),
        inputs: Vec::new(),
        followers: Vec::new(),
        coordinates: Vec::new(),
        states: 0,
        instants: Default::default(),
        constraints: Vec::new(),
        length: 1.0,
        variables: Vec::new(),
        constants: Vec::new(),
        registers: 0,
        tapes: Tapes::default(),
        initial: Initial::default(),
        engine: cotree_fmu::program::Engine::Dop853,
        automatic: true,
        arms: None,
        masses: None,
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
    for tape in every {
        tape.results.iter_mut().for_each(moved);
        edit(tape, |code| {
            for Instruction { target, a, b, c, .. } in code {
                [target, a, b, c].into_iter().for_each(moved);
            }
        });
    }
    program.registers += 1;
}

/// Changes the instructions of a tape.
pub fn edit(tape: &mut Tape, change: impl FnOnce(&mut [Instruction])) {
    let mut instructions = tape.instructions().to_vec();
    change(&mut instructions);
    *tape = Tape::new(instructions, std::mem::take(&mut tape.results));
}
