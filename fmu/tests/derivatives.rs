//! Derivatives along directions and along the motion, against differences of what an importer can see.

use crate::support::*;
use cotree_fmu::instance::{DERIVATIVE_ORDER, Instance, InstanceError, Snapshot};
use cotree_fmu::program::{Program, Source};

/// Derivatives agree with differences to this much, relative to 1 or to the value.
const AGREE: f64 = 1e-7;

fn calculated(program: &Program) -> Vec<usize> {
    let sources = program.variables.iter().enumerate();
    let calculated = |source| !matches!(source, Source::Time | Source::Parameter(_) | Source::Input(_));
    sources.filter(|(_, variable)| calculated(variable.source)).map(|(index, _)| index).collect()
}

fn values(instance: &mut Instance, variables: &[usize]) -> Vec<f64> {
    variables.iter().map(|&variable| instance.get(variable).expect("defined")).collect()
}

fn along(instance: &mut Instance, known: usize, unknowns: &[usize]) -> Vec<f64> {
    instance.begin_direction();
    instance.add_direction(known, 1.0).expect("independent");
    instance.differentiate().expect("regular");
    unknowns.iter().map(|&unknown| instance.derivative(unknown).expect("calculated")).collect()
}

/// Derivatives of an order by time, of a run from a saved state to that time.
fn by_time(instance: &mut Instance, start: &Snapshot, time: f64, unknowns: &[usize], order: i32) -> Vec<f64> {
    instance.restore(start).expect("own state");
    instance.step_to(time).expect("regular");
    instance.differentiate_motion(order).expect("regular");
    unknowns.iter().map(|&unknown| instance.motion_derivative(unknown, order).expect("calculated")).collect()
}

/// Central differences of fourth order of the values after `change`.
fn differences(mut values_at: impl FnMut(f64) -> Vec<f64>, h: f64) -> Vec<f64> {
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| values_at(k * h));
    (0..a.len()).map(|i| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * h)).collect()
}

fn assert_agree(program: &Program, unknowns: &[usize], exact: &[f64], found: &[f64], what: &str) {
    for ((&unknown, exact), difference) in unknowns.iter().zip(exact).zip(found) {
        let name = &program.variables[unknown].name;
        let close = (exact - difference).abs() <= AGREE * exact.abs().max(1.0);
        assert!(close, "{}: d {name} / d {what} = {exact}, by differences {difference}", program.name);
    }
}

/// By parameters and inputs, from the instance's present state.
fn check_settable(program: &Program, instance: &mut Instance) {
    let unknowns = calculated(program);
    for (known, variable) in program.variables.iter().enumerate() {
        if instance.check_set(known, 0.5).is_err() {
            continue;
        }
        let exact = along(instance, known, &unknowns);
        let saved = instance.save();
        let before = match (variable.initial, variable.source) {
            (Some(parameter), _) => instance.state().parameters()[parameter as usize],
            _ => instance.get(known).expect("defined"),
        };
        let at = |change: f64| {
            instance.set(known, before + change).expect("permitted");
            let values = values(instance, &unknowns);
            instance.restore(&saved).expect("own state");
            values
        };
        assert_agree(program, &unknowns, &exact, &differences(at, 1e-3), &variable.name);
    }
}

#[test]
fn derivatives_by_inputs_and_parameters_are_exact_while_running() {
    let drives = [Drive::Time, Drive::Position, Drive::Velocity, Drive::Acceleration];
    let programs = [pendulum(), slider_crank()].into_iter().chain(drives.map(|drive| four_bar(drive, true)));
    for program in programs {
        let mut instance = unstarted(program.clone());
        instance.setup(0.0, None, Some(1e-12)).expect("possible");
        instance.initialise().expect("consistent");
        let input = program.variables.iter().position(|variable| matches!(variable.source, Source::Input(_)));
        instance.set(input.expect("all have one"), 0.3).expect("permitted");
        instance.step_to(0.2).expect("regular");
        check_settable(&program, &mut instance);
    }
}

/// The pendulum and the slider-crank with initial values that can be set.
fn with_initial_values() -> [Program; 2] {
    let mut slider_crank = slider_crank();
    let angle = initial_parameter(&mut slider_crank, "crank.angle");
    assert!(angle.is_some());
    let mut pendulum = pendulum();
    initial_parameter(&mut pendulum, "arm.angle");
    [pendulum, slider_crank]
}

#[test]
fn derivatives_before_the_start_go_through_the_assembly() {
    for program in
        with_initial_values().into_iter().chain([four_bar(Drive::Time, true), four_bar(Drive::Velocity, false)])
    {
        let mut instance = unstarted(program.clone());
        check_settable(&program, &mut instance);
    }
}

#[test]
fn derivatives_by_states_are_taken_at_fixed_other_states() {
    for program in [pendulum(), slider_crank()] {
        let unknowns = calculated(&program);
        let mut instance = unstarted(program.clone());
        instance.initialise_exchange().expect("offered");
        let mut states = vec![0.0; instance.state_count()];
        instance.states(&mut states).expect("consistent");
        for (index, variable) in program.variables.iter().enumerate() {
            let place = match variable.source {
                Source::Coordinate(i) => 2 * i as usize,
                Source::Rate(i) => 2 * i as usize + 1,
                _ => continue,
            };
            let exact = along(&mut instance, index, &unknowns);
            let at = |change: f64| {
                let mut moved = states.clone();
                moved[place] += change;
                instance.set_states(&moved).expect("finite");
                values(&mut instance, &unknowns)
            };
            let found = differences(at, 1e-3);
            instance.set_states(&states).expect("finite");
            assert_agree(&program, &unknowns, &exact, &found, &variable.name);
        }
    }
}

#[test]
fn a_direction_is_a_sum_and_refuses_what_does_not_move_by_itself() {
    let mut instance = started(slider_crank());
    let index = |name| instance.variable(name).expect("there");
    let (force, crank, rod, alpha) = (index("force"), index("crank.angle"), index("rod.omega"), index("crank.alpha"));
    let single: f64 = [(force, 2.0), (crank, -0.5), (rod, 3.0)]
        .map(|(known, share)| share * along(&mut instance, known, &[alpha])[0])
        .iter()
        .sum();
    instance.begin_direction();
    for (known, share) in [(force, 2.0), (crank, -0.5), (rod, 1.0), (rod, 2.0)] {
        instance.add_direction(known, share).expect("independent");
    }
    instance.differentiate().expect("regular");
    let together = instance.derivative(alpha).expect("calculated");
    assert!((single - together).abs() < 1e-12 * together.abs().max(1.0));

    assert!(matches!(instance.add_direction(alpha, 1.0), Err(InstanceError::NotIndependent { .. })));
    assert!(matches!(instance.add_direction(99, 1.0), Err(InstanceError::UnknownVariable { .. })));
    assert!(matches!(instance.derivative(force), Err(InstanceError::NotCalculated { .. })));
    let mut driven = started(four_bar(Drive::Time, false));
    let rocker = driven.variable("rocker.angle").expect("there");
    assert!(driven.add_direction(rocker, 1.0).is_err(), "a driven mechanism has no states");
}

#[test]
fn derivatives_by_time_are_those_of_the_motion() {
    let drives = [Drive::Time, Drive::Position, Drive::Velocity, Drive::Acceleration];
    for program in [pendulum(), slider_crank()].into_iter().chain(drives.map(|drive| four_bar(drive, false))) {
        let unknowns = calculated(&program);
        let mut instance = unstarted(program.clone());
        instance.setup(0.0, None, Some(1e-13)).expect("possible");
        instance.initialise().expect("consistent");
        for (index, variable) in program.variables.iter().enumerate() {
            if matches!(variable.source, Source::Input(_)) {
                instance.set(index, 0.3).expect("input");
                instance.set_derivative(index, 1, 0.7).expect("input");
                instance.set_derivative(index, 2, -0.4).expect("input");
            }
        }
        let start = instance.save();
        let at = |time: f64| {
            instance.restore(&start).expect("own state");
            instance.step_to(0.2 + time).expect("regular");
            values(&mut instance, &unknowns)
        };
        let found = differences(at, 2e-3);
        let exact = by_time(&mut instance, &start, 0.2, &unknowns, 1);
        assert_agree(&program, &unknowns, &exact, &found, "t");
        for order in 2..=DERIVATIVE_ORDER {
            let at = |time: f64| by_time(&mut instance, &start, 0.2 + time, &unknowns, order - 1);
            let found = differences(at, 2e-3);
            let exact = by_time(&mut instance, &start, 0.2, &unknowns, order);
            assert_agree(&program, &unknowns, &exact, &found, &format!("t^{order}"));
        }
    }
}

#[test]
fn derivatives_do_not_disturb_the_run() {
    for program in [slider_crank(), four_bar(Drive::Velocity, true)] {
        let (mut plain, mut observed) = (started(program.clone()), started(program.clone()));
        let input = plain.variable(if program.is_driven() { "crank_drive" } else { "force" });
        let input = input.expect("there");
        for step in 1..=20_u32 {
            for instance in [&mut plain, &mut observed] {
                instance.set(input, f64::from(step % 4) * 0.2).expect("input");
            }
            along(&mut observed, input, &calculated(&program));
            observed.differentiate_motion(3).expect("regular");
            values(&mut observed, &calculated(&program));
            for instance in [&mut plain, &mut observed] {
                instance.step_to(f64::from(step) * 0.02).expect("regular");
            }
            assert_eq!(plain.state(), observed.state());
        }
    }
}
