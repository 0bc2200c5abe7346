//! A run of a program written by hand: a mass on a spring, pushed by an input. x'' = push - stiffness x.

use std::sync::Arc;

use cotree::export::description::{Causality, Description, ScalarVariable};
use cotree::model::{Experiment, Unit};
use cotree::report::csv::CsvTable;
use cotree::run::{Run, RunError};
use cotree_fmu::model::Model;
use cotree_fmu::program as data;
use cotree_fmu::tape::{Instruction, Operation, Tape};

const STIFFNESS: usize = 1;
const PUSH: usize = 2;

fn program() -> data::Program {
    // Registers: time, stiffness, push, its rate, its acceleration, q, v, a, scratch.
    let instruction = |operation, target, a, b| Instruction { operation, target, a, b, c: 0 };
    let instructions = vec![instruction(Operation::Multiply, 8, 1, 5), instruction(Operation::Subtract, 9, 2, 8)];
    let acceleration = Tape::new(instructions, vec![9]);
    let variable = |name: &str, source| data::Variable { name: name.into(), source, initial: None };
    data::Program {
        name: "mass".into(),
        guid: "mass".into(),
        experiment: data::Experiment {
            start: 0.0,
            stop: 1.0,
            step: 0.1,
            tolerance: 1e-9,
            max_step: f64::INFINITY,
            budget: f64::INFINITY,
        },
        parameters: vec![data::Parameter {
            name: "stiffness".into(),
            start: 1.0,
            min: Some(0.0),
            max: None,
            tunable: false,
        }],
        discrete: Vec::new(),
        inputs: vec![data::Input { name: "push".into(), start: 0.0, min: None, max: None }],
        followers: vec![],
        coordinates: vec![data::Coordinate { name: "mass.x".into(), scale: 1.0 }],
        states: 0,
        instants: Default::default(),
        constraints: vec![],
        length: 1.0,
        variables: vec![
            variable("time", data::Source::Time),
            variable("stiffness", data::Source::Parameter(0)),
            variable("push", data::Source::Input(0)),
            variable("mass.x", data::Source::Coordinate(0)),
            variable("mass.ax", data::Source::Acceleration(0)),
        ],
        constants: vec![],
        registers: 10,
        tapes: data::Tapes { acceleration, ..data::Tapes::default() },
        initial: data::Initial::default(),
        engine: data::Engine::Dop853,
        automatic: true,
        arms: None,
        masses: None,
    }
}

fn description() -> Description {
    let causalities = [
        Causality::Independent,
        Causality::Parameter { start: 1.0, min: Some(0.0), max: None },
        Causality::Input { start: 0.0, min: None, max: None },
        Causality::Output,
        Causality::Output,
    ];
    let variables = program()
        .variables
        .into_iter()
        .zip(causalities)
        .map(|(variable, causality)| ScalarVariable::new(variable.name, String::new(), Unit::default(), causality));
    Description {
        model_name: "mass".into(),
        identifier: "mass".into(),
        guid: "mass".into(),
        description: String::new(),
        credits: Vec::new(),
        experiment: Experiment { start: 0.0, stop: 1.0, step: 0.1, tolerance: 1e-9 },
        exchange: None,
        exchange_with_rates: false,
        at_profile: None,
        indicators: 0,
        own_steps: true,
        followed: Vec::new(),
        moves_states: false,
        variables: variables.collect(),
        terminals: vec![],
        sources: None,
    }
}

/// Time, position, acceleration at every communication point.
fn simulate(settings: Vec<(usize, f64)>, table: Option<&CsvTable>, step: f64) -> Result<Vec<[f64; 3]>, RunError> {
    let description = description();
    let run = Run {
        description: &description,
        experiment: Experiment { step, ..description.experiment },
        settings,
        inputs: table.map(|table| (table, vec![PUSH])),
        reported: description.reported(),
    };
    let mut rows = vec![];
    run.start(Arc::new(Model::new(program()).unwrap()), |time, values| {
        rows.push([time, values[0], values[1]]);
        Ok(())
    })?;
    Ok(rows)
}

#[test]
fn a_constant_push_swings() {
    let rows = simulate(vec![(STIFFNESS, 4.0), (PUSH, 2.0)], None, 0.1).unwrap();
    assert_eq!(rows.len(), 11);
    for [time, x, a] in rows {
        let exact = 0.5 * (1.0 - (2.0 * time).cos());
        assert!((x - exact).abs() < 1e-8, "at {time}: {x} instead of {exact}");
        assert!((a - (2.0 - 4.0 * x)).abs() < 1e-12);
    }
}

/// Without a spring the position is the double integral of the push: here of a ramp up to 0.35 s, a jump there, and a
/// constant.
#[test]
fn rows_of_the_table_need_not_be_communication_points() {
    let table = CsvTable::parse("time,push\n0,0\n0.35,0.7\n0.35,3\n1,3\n").unwrap();
    for step in [0.1, 1.0, 0.03] {
        let rows = simulate(vec![(STIFFNESS, 0.0)], Some(&table), step).unwrap();
        for [time, x, _] in rows {
            let corner: f64 = 0.35;
            let exact = if time <= corner {
                time.powi(3) / 3.0
            } else {
                let after = time - corner;
                corner.powi(3) / 3.0 + corner.powi(2) * after + 1.5 * after.powi(2)
            };
            assert!((x - exact).abs() < 1e-8, "step {step}, at {time}: {x} instead of {exact}");
        }
    }
}

#[test]
fn what_the_instance_refuses_names_the_variable() {
    let error = simulate(vec![(STIFFNESS, -1.0)], None, 0.1).unwrap_err();
    assert!(error.to_string().contains("`stiffness`"), "{error}");
}
