//! Communication points: when they come must not matter, and saved states go on bit for bit.

use crate::support::*;
use cotree_fmu::instance::{Instance, InstanceError, Snapshot};

fn final_state(mut instance: Instance, points: impl Iterator<Item = f64>) -> Instance {
    points.for_each(|t| instance.step_to(t).expect("regular"));
    instance
}

fn grid(stop: f64, steps: u32) -> impl Iterator<Item = f64> {
    (1..=steps).map(move |step| if step == steps { stop } else { stop * f64::from(step) / f64::from(steps) })
}

fn bits(instance: &Instance) -> Vec<u64> {
    instance.state().registers().iter().map(|value| value.to_bits()).collect()
}

#[test]
fn results_do_not_depend_on_communication_points() {
    for program in [pendulum(), slider_crank()] {
        let reference = final_state(started(program.clone()), grid(2.0, 1));
        for steps in [3, 100, 2000] {
            let other = final_state(started(program.clone()), grid(2.0, steps));
            for (a, b) in reference.state().positions().iter().zip(other.state().positions()) {
                assert!((a - b).abs() < 1e-6, "{steps} steps: {a} and {b}");
            }
        }
    }
}

#[test]
fn fine_communication_points_cost_no_evaluations() {
    let coarse = final_state(started(pendulum()), grid(10.0, 10)).statistics();
    let fine = final_state(started(pendulum()), grid(10.0, 10_000)).statistics();
    assert!(fine.steps <= coarse.steps + 1);
    assert!(fine.evaluations <= coarse.evaluations + 4 * fine.steps, "{fine:?} {coarse:?}");
}

#[test]
fn changing_inputs_cost_one_step_for_each_communication_point() {
    let mut instance = started(pendulum());
    for step in 1..=1000 {
        let t = f64::from(step) * 1e-3;
        set(&mut instance, "torque", t.sin());
        instance.step_to(t).expect("regular");
    }
    let done = instance.statistics();
    assert!(done.steps <= 1002 && done.rejected <= 5, "{done:?}");
}

#[test]
fn setting_the_same_value_changes_nothing() {
    let plain = final_state(started(pendulum()), grid(1.0, 50));
    let mut instance = started(pendulum());
    for t in grid(1.0, 50) {
        set(&mut instance, "torque", 0.0);
        set(&mut instance, "gravity", 9.81);
        instance.step_to(t).expect("regular");
    }
    assert_eq!(bits(&instance), bits(&plain));
}

/// A run with changes of inputs at some points.
fn eventful(instance: &mut Instance, steps: std::ops::Range<u32>) {
    for step in steps {
        let input = if instance.variable("torque").is_some() { "torque" } else { "force" };
        if step % 7 == 0 || (20..25).contains(&step) {
            set(instance, input, f64::from(step % 5));
        }
        instance.step_to(f64::from(step + 1) * 0.01).expect("regular");
    }
}

#[test]
fn a_saved_state_goes_on_bit_for_bit() {
    for program in [pendulum(), slider_crank()] {
        for split in [1, 13, 21, 22, 40] {
            let mut plain = started(program.clone());
            eventful(&mut plain, 0..60);

            let mut instance = started(program.clone());
            eventful(&mut instance, 0..split);
            let saved = instance.save();
            let bytes = saved.to_bytes().expect("can be written");
            eventful(&mut instance, split..60);
            assert_eq!(bits(&instance), bits(&plain), "saving changes nothing");
            instance.restore(&saved).expect("own state");
            eventful(&mut instance, split..60);
            assert_eq!(bits(&instance), bits(&plain), "going back");

            let mut other = started(program.clone());
            let read = Snapshot::from_bytes(other.model(), &bytes).expect("same model");
            assert_eq!(read, saved);
            other.restore(&read).expect("same model");
            eventful(&mut other, split..60);
            assert_eq!(bits(&other), bits(&plain), "another instance");
        }
    }
}

#[test]
fn a_state_can_be_saved_between_a_change_and_its_step() {
    let mut instance = started(slider_crank());
    eventful(&mut instance, 0..10);
    set(&mut instance, "crank_length", 0.55);
    let saved = instance.save();
    instance.step_to(0.2).expect("regular");
    let expected = bits(&instance);
    let mut other = started(slider_crank());
    other.restore(&saved).expect("same model");
    other.step_to(0.2).expect("regular");
    assert_eq!(bits(&other), expected);
}

#[test]
fn damaged_and_foreign_states_are_refused() {
    let mut instance = started(slider_crank());
    let bytes = instance.save().to_bytes().expect("can be written");
    for place in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x10;
        assert!(Snapshot::from_bytes(instance.model(), &damaged).is_err());
        assert!(Snapshot::from_bytes(instance.model(), &bytes[..place]).is_err());
    }
    let mut other = started(pendulum());
    assert!(Snapshot::from_bytes(other.model(), &bytes).is_err());
    assert_eq!(other.restore(&instance.save()), Err(InstanceError::ForeignState));
}

#[test]
fn reset_is_a_fresh_start() {
    let mut instance = started(pendulum());
    set(&mut instance, "gravity", 3.0);
    eventful(&mut instance, 0..30);
    instance.reset();
    instance.setup(0.0, None, None).expect("possible");
    instance.initialise().expect("consistent");
    eventful(&mut instance, 0..30);
    let mut fresh = started(pendulum());
    eventful(&mut fresh, 0..30);
    assert_eq!(bits(&instance), bits(&fresh));
}

#[test]
fn nothing_is_evaluated_after_the_stop_time() {
    let mut instance = unstarted(pendulum());
    instance.setup(0.0, Some(1.0), None).expect("possible");
    instance.initialise().expect("consistent");
    let mut t = 0.0;
    for _ in 0..10 {
        t += 0.1;
        instance.step_to(t).expect("rounding is no overrun");
    }
    assert!(matches!(instance.step_to(1.1), Err(InstanceError::Stop { .. })));
    assert!((instance.time() - 1.0).abs() < 1e-12);
}

#[test]
fn impossible_steps_values_and_experiments_are_refused() {
    let mut instance = started(pendulum());
    for t in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(instance.step_to(t), Err(InstanceError::Step { .. })));
    }
    let index = |name| instance.variable(name).expect("there");
    let (gravity, length, torque, energy) = (index("gravity"), index("length"), index("torque"), index("energy"));
    assert!(matches!(instance.set(gravity, f64::NAN), Err(InstanceError::NotANumber { .. })));
    assert!(matches!(instance.set(length, 2.0), Err(InstanceError::Fixed { .. })));
    assert!(matches!(instance.set(torque, 101.0), Err(InstanceError::OutOfRange { .. })));
    assert!(matches!(instance.set(energy, 1.0), Err(InstanceError::Calculated { .. })));
    assert!(matches!(instance.set(99, 1.0), Err(InstanceError::UnknownVariable { index: 99 })));
    assert!(matches!(instance.get(99), Err(InstanceError::UnknownVariable { index: 99 })));
    assert!(matches!(instance.set_derivative(torque, 0, 1.0), Err(InstanceError::Derivative { .. })));
    assert!(matches!(instance.set_derivative(torque, 3, 1.0), Err(InstanceError::Derivative { .. })));
    assert!(matches!(instance.set_derivative(gravity, 1, 1.0), Err(InstanceError::Derivative { .. })));
    assert!(matches!(instance.set_derivative(torque, 1, f64::NAN), Err(InstanceError::NotANumber { .. })));
    assert!(matches!(instance.setup(0.0, None, None), Err(InstanceError::Phase { running: true })));
    instance.reset();
    assert!(matches!(instance.step_to(1.0), Err(InstanceError::Phase { running: false })));
    assert!(matches!(instance.set(length, 0.05), Err(InstanceError::OutOfRange { .. })));
    for (start, stop, tolerance) in
        [(f64::NAN, None, None), (1.0, Some(0.0), None), (0.0, Some(f64::NAN), None), (0.0, None, Some(0.0))]
    {
        assert!(matches!(instance.setup(start, stop, tolerance), Err(InstanceError::Experiment { .. })));
    }
}

/// The step fails, the state stays, and without a limit in reach nothing is different.
#[test]
fn the_computer_takes_no_longer_than_it_may() {
    let programs = [pendulum(), slider_crank(), four_bar(Drive::Time, false)];
    for program in programs {
        let limited = |budget: f64| {
            let mut limited = program.clone();
            limited.experiment.budget = budget;
            started(limited)
        };
        let mut instance = limited(1e-9);
        let before = bits(&instance);
        let error = instance.step_to(1.0).expect_err("no time at all").to_string();
        assert!(error.contains("time_budget") && error.contains("at t = "), "{error}");
        assert_eq!(bits(&instance), before);
        let (free, patient) = (final_state(started(program.clone()), grid(1.0, 10)), limited(1e6));
        assert_eq!(bits(&free), bits(&final_state(patient, grid(1.0, 10))));
    }
}
