//! Model Exchange: an integrator outside gives what the one inside gives, and the loops stay closed.

use crate::support::*;
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::program::Program;

/// Classical Runge-Kutta steps by an importer; returns the number of events asked for.
fn integrate(instance: &mut Instance, steps: u32, h: f64) -> u32 {
    let n = instance.state_count();
    let mut events = 0;
    for step in 0..steps {
        let t = f64::from(step) * h;
        let mut start = vec![0.0; n];
        instance.states(&mut start).expect("consistent");
        let (mut sum, mut slope) = (vec![0.0; n], vec![0.0; n]);
        for (share, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let point: Vec<f64> = start.iter().zip(&slope).map(|(x, k)| x + share * h * k).collect();
            instance.set_time(t + share * h).expect("finite");
            instance.set_states(&point).expect("finite");
            instance.state_derivatives(&mut slope).expect("regular");
            sum.iter_mut().zip(&slope).for_each(|(sum, k)| *sum += weight * k / 6.0);
        }
        let end: Vec<f64> = start.iter().zip(&sum).map(|(x, k)| x + h * k).collect();
        instance.set_states(&end).expect("finite");
        if instance.complete_step().expect("regular") {
            events += 1;
            assert!(instance.close_loops().expect("regular"), "an event was asked for");
            assert!(!instance.complete_step().expect("regular"), "the loops are closed now");
        }
    }
    events
}

fn exchange(program: Program, tolerance: f64) -> Instance {
    let mut instance = unstarted(program);
    instance.setup(0.0, None, Some(tolerance)).expect("possible");
    instance.initialise_exchange().expect("offered");
    instance
}

#[test]
fn both_interfaces_agree() {
    for program in [pendulum(), slider_crank(), four_bar(Drive::Time, true)] {
        let mut outside = exchange(program.clone(), 1e-8);
        integrate(&mut outside, 2000, 5e-4);
        let mut inside = started(program.clone());
        inside.step_to(1.0).expect("regular");
        for (index, variable) in program.variables.iter().enumerate() {
            let (a, b) = (outside.get(index).expect("defined"), inside.get(index).expect("defined"));
            assert!((a - b).abs() < 1e-6 * b.abs().max(1.0), "{}: {a} outside, {b} inside", variable.name);
        }
    }
}

/// An importer that takes no events gives its states back as they were.
fn ignore(instance: &mut Instance, steps: u32, h: f64) -> f64 {
    instance.setup(0.0, None, Some(1e-2)).expect("possible");
    instance.initialise_exchange().expect("offered");
    assert_eq!(integrate(instance, steps, h), 0, "a drift within the coarsest tolerance");
    value(instance, "constraint.position").abs()
}

/// Each event restarts the importer's solver: it is asked for where the errors of many steps have added up.
#[test]
fn loops_that_come_apart_are_closed_at_few_events() {
    let (steps, h) = (4000, 1e-2);
    let mut instance = exchange(slider_crank(), 1e-9);
    let events = integrate(&mut instance, steps, h);
    assert!((1..=steps / 100).contains(&events), "{events} events");
    let open = ignore(&mut unstarted(slider_crank()), steps, h);
    let closed = value(&mut instance, "constraint.position").abs();
    assert!(closed < 0.5 * open, "{closed:e} m apart, and {open:e} m where no event is handled");
    assert_eq!(integrate(&mut exchange(slider_crank(), 1e-2), 100, 1e-3), 0, "fine steps do not drift");
}

#[test]
fn a_changed_length_closes_the_loops_again() {
    let mut instance = exchange(slider_crank(), 1e-9);
    set(&mut instance, "crank_length", 0.55);
    assert!(value(&mut instance, "constraint.position").abs() > 1e-3, "the loop is open");
    assert!(instance.close_loops().expect("closes"));
    assert!(value(&mut instance, "constraint.position").abs() < 1e-9);
}

#[test]
fn a_driven_mechanism_follows_time_back_and_forth() {
    let mut instance = exchange(four_bar(Drive::Time, false), 1e-9);
    let rocker = |instance: &mut Instance, time: f64| {
        instance.set_time(time).expect("finite");
        value(instance, "rocker.angle")
    };
    let early = rocker(&mut instance, 0.1);
    assert!(!instance.complete_step().expect("regular"));
    let late = rocker(&mut instance, 0.4);
    assert!((rocker(&mut instance, 0.1) - early).abs() < 1e-9 && (late - early).abs() > 1e-3);
    assert_eq!(rocker(&mut instance, 0.4), late, "values do not depend on what was asked before");
}

#[test]
fn it_is_not_offered_when_a_driver_follows_an_input() {
    for drive in [Drive::Position, Drive::Velocity, Drive::Acceleration] {
        let mut instance = unstarted(four_bar(drive, false));
        assert_eq!(instance.initialise_exchange(), Err(InstanceError::NoExchange));
        instance.initialise().expect("still for Co-Simulation");
    }
}
