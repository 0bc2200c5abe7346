//! The motion of small mechanisms against what mechanics says about it.

use crate::support::*;
use cotree_fmu::failure::Failure;
use cotree_fmu::instance::InstanceError;

/// The pendulum by the classical Runge-Kutta method with small steps.
fn pendulum_reference(mut angle: f64, mut rate: f64, torque: impl Fn(f64) -> f64, from: f64, to: f64) -> [f64; 2] {
    let steps = 20_000;
    let h = (to - from) / f64::from(steps);
    for step in 0..steps {
        let t = from + f64::from(step) * h;
        let f = |t: f64, [q, v]: [f64; 2]| [v, torque(t) - 9.81 * q.sin()];
        let along = |k: [f64; 2], h: f64| [angle + h * k[0], rate + h * k[1]];
        let k1 = f(t, [angle, rate]);
        let k2 = f(t + 0.5 * h, along(k1, 0.5 * h));
        let k3 = f(t + 0.5 * h, along(k2, 0.5 * h));
        let k4 = f(t + h, along(k3, h));
        let mean = |i: usize| (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0;
        (angle, rate) = (angle + h * mean(0), rate + h * mean(1));
    }
    [angle, rate]
}

#[test]
fn the_pendulum_swings_as_the_reference_does() {
    let [angle, rate] = pendulum_reference(1.0, 0.0, |_| 0.0, 0.0, 3.0);
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let mut instance = unstarted(pendulum());
        instance.setup(0.0, None, Some(tolerance)).expect("possible");
        instance.initialise().expect("consistent");
        instance.step_to(3.0).expect("regular");
        let errors = [value(&mut instance, "arm.angle") - angle, value(&mut instance, "arm.omega") - rate];
        assert!(errors.iter().all(|error| error.abs() < 100.0 * tolerance + 1e-12), "{errors:?} at {tolerance}");
    }
}

#[test]
fn energy_is_kept_and_outputs_agree_with_the_state() {
    let mut instance = started(pendulum());
    let energy = value(&mut instance, "energy");
    for step in 1..=1000 {
        instance.step_to(f64::from(step) * 0.01).expect("regular");
        assert!((value(&mut instance, "energy") - energy).abs() < 1e-6);
    }
    let angle = value(&mut instance, "arm.angle");
    let alpha = value(&mut instance, "arm.alpha");
    assert!((alpha + 9.81 * angle.sin()).abs() < 1e-12);
    assert_eq!(value(&mut instance, "tangential"), alpha);
    assert_eq!(value(&mut instance, "time"), 10.0);
}

#[test]
fn inputs_with_derivatives_act_as_polynomials_between_communication_points() {
    let mut instance = unstarted(pendulum());
    let torque = instance.variable("torque").expect("there");
    instance.initialise().expect("consistent");
    instance.set(torque, 2.0).expect("input");
    instance.set_derivative(torque, 1, -3.0).expect("input");
    instance.set_derivative(torque, 2, 4.0).expect("input");
    instance.step_to(0.7).expect("regular");
    let law = |t: f64| 2.0 - 3.0 * t + 2.0 * t * t;
    let [angle, rate] = pendulum_reference(1.0, 0.0, law, 0.0, 0.7);
    assert!((value(&mut instance, "arm.angle") - angle).abs() < 1e-7);
    assert!((value(&mut instance, "torque") - law(0.7)).abs() < 1e-14);
    // Set again without derivatives: constant from here.
    instance.set(torque, 1.0).expect("input");
    instance.step_to(1.4).expect("regular");
    let [angle, _] = pendulum_reference(angle, rate, |_| 1.0, 0.7, 1.4);
    assert!((value(&mut instance, "arm.angle") - angle).abs() < 1e-6);
    assert_eq!(value(&mut instance, "torque"), 1.0);
}

#[test]
fn the_slider_crank_keeps_its_energy_and_its_loop_closed() {
    let mut instance = started(slider_crank());
    let energy = value(&mut instance, "energy.kinetic");
    for step in 1..=2000 {
        instance.step_to(f64::from(step) * 5e-3).expect("regular");
        let change = value(&mut instance, "energy.kinetic") / energy - 1.0;
        assert!(change.abs() < 1e-6, "{change} at step {step}");
        assert!(value(&mut instance, "constraint.position").abs() < 1e-10);
        assert!(value(&mut instance, "slider.x") > 0.9, "on the branch of the guess");
    }
    assert!(value(&mut instance, "crank.angle") > 10.0, "it turns");
}

#[test]
fn work_of_a_force_becomes_kinetic_energy() {
    let mut instance = started(slider_crank());
    let before = value(&mut instance, "energy.kinetic");
    let x = value(&mut instance, "slider.x");
    set(&mut instance, "force", 2.5);
    for step in 1..=300 {
        instance.step_to(f64::from(step) * 5e-3).expect("regular");
        let work = 2.5 * (value(&mut instance, "slider.x") - x);
        assert!((value(&mut instance, "energy.kinetic") - before - work).abs() < 1e-6);
    }
}

/// Coupler and rocker angles of the four-bar by elementary geometry, on the branch of the guess.
fn four_bar_pose(crank: f64) -> [f64; 2] {
    let [a, b, c, d] = FOUR_BAR;
    let (x, y) = (d - a * crank.cos(), -a * crank.sin());
    let diagonal = x.hypot(y);
    let coupler = y.atan2(x) + ((b * b + diagonal * diagonal - c * c) / (2.0 * b * diagonal)).acos();
    let (px, py) = (a * crank.cos() + b * coupler.cos() - d, a * crank.sin() + b * coupler.sin());
    [coupler, py.atan2(px)]
}

fn near_pose(instance: &mut cotree_fmu::instance::Instance, crank: f64) {
    let expected = four_bar_pose(crank);
    for (name, expected) in ["coupler.angle", "rocker.angle"].into_iter().zip(expected) {
        let difference = value(instance, name) - expected;
        assert!(difference.sin().abs() < 1e-9 && difference.cos() > 0.0, "{name}: {difference} at crank {crank}");
    }
}

#[test]
fn a_driven_four_bar_follows_its_crank() {
    let mut instance = started(four_bar(Drive::Time, true));
    for step in 1..=200 {
        let t = f64::from(step) * 0.05;
        instance.step_to(t).expect("a crank and rocker");
        near_pose(&mut instance, SPEED * t);
    }
}

#[test]
fn one_long_step_of_a_driven_mechanism_ends_on_the_same_branch() {
    let mut instance = started(four_bar(Drive::Time, false));
    instance.step_to(7.77).expect("sub-steps");
    near_pose(&mut instance, SPEED * 7.77);
    assert!(instance.statistics().steps > 5);
}

#[test]
fn rates_accelerations_and_power_of_a_driven_mechanism_are_right() {
    let mut instance = started(four_bar(Drive::Time, false));
    set(&mut instance, "load", 3.0);
    let rate = |t: f64| {
        let h = 1e-5;
        let [before, after] = [t - h, t + h].map(|t| four_bar_pose(SPEED * t)[1]);
        (after - before) / (2.0 * h)
    };
    for step in 1..=20 {
        let t = f64::from(step) * 0.13;
        instance.step_to(t).expect("regular");
        let omega = value(&mut instance, "rocker.omega");
        let alpha = value(&mut instance, "rocker.alpha");
        assert!((omega - rate(t)).abs() < 1e-7);
        assert!((alpha - (rate(t + 1e-3) - rate(t - 1e-3)) / 2e-3).abs() < 1e-4);
        // Power of the motor and of the load go into the rocker's kinetic energy.
        let power = value(&mut instance, "motor.torque") * SPEED + 3.0 * omega;
        assert!((power - ROCKER * omega * alpha).abs() < 1e-9);
    }
}

#[test]
fn followers_integrate_their_input_exactly() {
    let mut instance = started(four_bar(Drive::Velocity, false));
    let drive = instance.variable("crank_drive").expect("there");
    instance.set(drive, 1.5).expect("input");
    instance.set_derivative(drive, 1, -0.4).expect("input");
    instance.set_derivative(drive, 2, 0.6).expect("input");
    instance.step_to(2.0).expect("regular");
    let expected = 0.1 + 1.5 * 2.0 - 0.4 * 2.0 + 0.6 * 8.0 / 6.0;
    assert!((value(&mut instance, "crank.angle") - expected).abs() < 1e-14);
    assert!((value(&mut instance, "crank.omega") - (1.5 - 0.8 + 1.2)).abs() < 1e-14);
    near_pose(&mut instance, expected);

    let mut instance = started(four_bar(Drive::Acceleration, false));
    set(&mut instance, "crank_drive", 0.8);
    instance.step_to(1.0).expect("regular");
    set(&mut instance, "crank_drive", -0.3);
    instance.step_to(2.5).expect("regular");
    let expected = 0.1 + 0.4 + 0.8 * 1.5 - 0.15 * 2.25;
    assert!((value(&mut instance, "crank.angle") - expected).abs() < 1e-14);
    assert!((value(&mut instance, "crank.omega") - (0.8 - 0.45)).abs() < 1e-14);
    near_pose(&mut instance, expected);
}

#[test]
fn a_jump_of_a_prescribed_position_is_followed_on_the_branch() {
    let mut instance = started(four_bar(Drive::Position, false));
    for (step, crank) in [0.4, 1.9, -1.0, 3.0].into_iter().enumerate() {
        set(&mut instance, "crank_drive", crank);
        instance.step_to(0.01 * (step as f64 + 1.0)).expect("reachable");
        near_pose(&mut instance, crank);
        assert!(value(&mut instance, "rocker.omega").abs() < 1e-12, "the crank stands still");
    }
}

#[test]
fn a_jump_that_the_loops_cannot_follow_is_told_as_a_jump() {
    let mut instance = started(four_bar(Drive::Position, false));
    set(&mut instance, "crank_drive", 0.4);
    instance.step_to(0.01).expect("reachable");
    set(&mut instance, "ground_length", 50.0);
    let failure = instance.step_to(0.02).expect_err("out of reach");
    let InstanceError::Jump { jumps, cause } = &failure else { panic!("{failure:?}") };
    assert!(matches!(cause, Failure::LockUp { .. }), "{cause}");
    assert!(matches!(&jumps[..], [(name, _, to)] if name == "ground_length" && *to == 50.0), "{failure}");
    assert!(failure.to_string().starts_with("`ground_length` jumped from "), "{failure}");
    assert_eq!(value(&mut instance, "time"), 0.01);
}

#[test]
fn a_change_of_a_length_closes_the_loop_again() {
    let mut instance = started(slider_crank());
    instance.step_to(0.5).expect("regular");
    set(&mut instance, "crank_length", 0.6);
    instance.step_to(1.0).expect("regular");
    assert!(value(&mut instance, "constraint.position").abs() < 1e-10);
    assert!(value(&mut instance, "slider.x") > 0.8);
}

#[test]
fn a_lock_up_names_the_joint_and_leaves_the_state_alone() {
    let mut instance = started(four_bar(Drive::Time, false));
    instance.step_to(0.25).expect("regular");
    // Too far apart to turn any further than some angle.
    set(&mut instance, "ground_length", 5.8);
    let mut t = 0.25;
    let failure = loop {
        t += 0.1;
        match instance.step_to(t) {
            Ok(()) => assert!(t < 5.0, "must lock up"),
            Err(failure) => break failure,
        }
    };
    let InstanceError::Solver(Failure::EndOfReach { time, joints }) = failure else { panic!("{failure:?}") };
    assert_eq!(joints, ["rocker_pin"]);
    // Locked when the distance between crank pin and ground pivot is coupler + rocker.
    let crank: f64 = ((1.0 + 5.8_f64.powi(2) - 5.5_f64.powi(2)) / (2.0 * 5.8)).acos();
    assert!((time - crank / SPEED).abs() < 1e-6, "{time}");
    assert!((instance.time() - (t - 0.1)).abs() < 1e-12);
    assert!(instance.step_to(t).is_err());
}

#[test]
fn a_redundant_joint_that_does_not_fit_is_named() {
    let mut program = four_bar(Drive::Time, true);
    // The spare equation becomes one that never holds: a length is zero.
    let length = program.layout().parameters() as u32;
    program.tapes.constraint.results[2] = length;
    let mut instance = unstarted(program);
    let failure = instance.initialise().expect_err("cannot be closed");
    assert!(
        matches!(&failure, InstanceError::Solver(Failure::LoopsOpen { gap }) if gap.owner == "spare_pin"),
        "{failure}"
    );
}

#[test]
fn a_start_in_a_singular_pose_names_the_joint() {
    // As long as they are: crank and rocker, coupler and ground. At crank angle 0 all bars lie in one line.
    let mut program = four_bar(Drive::Time, false);
    program.constants[..3].copy_from_slice(&[1.0, 3.0, 1.0]);
    program.parameters[0].start = 3.0;
    program.initial = cotree_fmu::program::Initial::default();
    let failure = started(program).step_to(0.1).expect_err("not determined");
    let InstanceError::Solver(Failure::SingularAhead { time, joints, .. }) = failure else { panic!("{failure:?}") };
    assert_eq!((time, joints), (0.0, vec!["rocker_pin".to_owned()]));
}

#[test]
fn mechanisms_without_coordinates_only_let_time_pass() {
    let mut program = pendulum();
    program.coordinates.clear();
    program.variables.truncate(4);
    program.tapes = Default::default();
    program.initial = Default::default();
    program.registers = program.layout().constants() as u32 + program.constants.len() as u32;
    let mut instance = started(program);
    for step in 1..=10 {
        instance.step_to(f64::from(step)).expect("nothing to solve");
    }
    assert_eq!(value(&mut instance, "time"), 10.0);
}

#[test]
fn accelerations_that_are_not_finite_are_an_error_with_a_name() {
    let mut program = pendulum();
    program.parameters[0].start = 0.0;
    // length / gravity instead of gravity / length.
    edit(&mut program.tapes.parameters, |code| (code[0].a, code[0].b) = (code[0].b, code[0].a));
    let mut instance = started(program);
    let failure = instance.step_to(1.0).expect_err("infinite");
    let expected = Failure::NotFinite { time: 0.0, coordinate: "arm.angle".into() };
    assert_eq!(failure, InstanceError::Solver(expected));
    let omega = instance.variable("tangential").expect("there");
    assert!(instance.get(omega).is_err());
    assert_eq!(instance.time(), 0.0);
}
