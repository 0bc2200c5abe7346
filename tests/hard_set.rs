//! Motion through singular poses, and other hard cases: no run leaves its branch, and what cannot be decided is an error that says so.
//! `examples/hard_set.rs` runs the whole set.

mod support;

use std::f64::consts::PI;
use std::sync::Arc;

use cotree::pipeline::compile;
use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use support::hard::{Case, FourBar, Outcome, Points, cases, neutral};

/// Those that take long are for the example.
const LONG: [&str; 4] = ["1000 s", "10 000 rpm for 60 s", "four-bars side by side, 5-100", "Jansen's leg, 1000 turns"];

#[test]
fn no_run_leaves_its_branch() {
    let mut runs = 0;
    for case in cases(1).into_iter().filter(|case| !LONG.contains(&case.family)) {
        let model = case.model().unwrap_or_else(|fault| panic!("{}: {fault}", case.family));
        for &tolerance in case.tolerances.iter().step_by(2) {
            for points in [Points::Even(50), Points::Uneven(40)] {
                let outcome = case.run(&model, None, tolerance, points);
                let run = format!("{}, {} at {tolerance:e}, {points:?}", case.family, case.scene.name.text);
                match outcome {
                    Outcome::Passed(figures) => {
                        assert!(figures.residual < tolerance.max(1e-11), "{run}: {figures:?}");
                        // Only a friction-free mechanism keeps its energy. Rates may be wrong by the tolerance at every step.
                        let most = 100.0 * tolerance + 1e-8;
                        assert!(!case.conservative || figures.drift < most, "{run}: {figures:?}");
                    }
                    Outcome::Refused(_) => assert!(case.refusal.is_some(), "{run}"),
                    other => panic!("{run}: {other:?}"),
                }
                runs += 1;
            }
        }
    }
    assert!(runs > 250, "{runs}");
}

/// Wherever a run is saved, it goes on with the same bits: in the same instance after it has gone elsewhere, and in another one.
#[test]
fn a_run_saved_anywhere_goes_on_with_the_same_bits() {
    const POINTS: u32 = 80;
    let time = |point: u32| 0.05 * f64::from(point);
    let (model, mut instance) = parallelogram(1e-8);
    let (mut saved, mut states) = (vec![instance.save()], vec![instance.state()]);
    for point in 1..=POINTS {
        instance.step_to(time(point)).expect("the motion goes on");
        saved.push(instance.save());
        states.push(instance.state());
    }
    let mut other = Instance::new(model);
    other.setup(0.0, Some(4.0), Some(1e-8)).expect("times");
    other.initialise().expect("consistent");
    for (point, state) in (1..).zip(&saved[..saved.len() - 1]) {
        for instance in [&mut instance, &mut other] {
            instance.restore(state).expect("its own state");
            for point in point..=u32::min(point + 10, POINTS) {
                instance.step_to(time(point)).expect("the motion goes on");
                let expected = states[point as usize].registers();
                assert_eq!(instance.state().registers(), expected, "at {} s", time(point));
            }
        }
    }
}

fn get_variable(instance: &mut Instance, name: &str) -> f64 {
    let variable = instance.variable(name).expect("an output");
    instance.get(variable).expect("defined")
}

/// The parallelogram, whose flat poses are where the crank's angle is a multiple of pi.
fn parallelogram(tolerance: f64) -> (Arc<Model>, Instance) {
    let bars = FourBar { angle: 1.0, omega: 6.0, ..FourBar::new(1.0, 2.0, 1.0, 2.0) };
    let scene = bars.scene("parallelogram").input("torque", 0.0).stop(4.0);
    let scene = scene.load("motor", cotree::scene::Load::torque("ground", "crank", "torque"));
    let outputs = ["crank.angle", "coupler.angle", "energy.total", "constraint.position"];
    let scene = outputs.into_iter().fold(scene, |scene, name| scene.output(name));
    let compiled = compile(&scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    let model = Arc::new(Model::new(compiled.program).expect("a sound program"));
    let mut instance = Instance::new(model.clone());
    instance.setup(0.0, Some(4.0), Some(tolerance)).expect("times");
    instance.initialise().expect("consistent");
    (model, instance)
}

#[test]
fn every_passage_is_told_and_is_where_the_bars_are_in_line() {
    let (model, mut instance) = parallelogram(1e-10);
    let turns = |instance: &mut Instance| (get_variable(instance, "crank.angle") / PI).floor();
    let mut passages = Vec::new();
    let (mut crossings, mut before) = (0, turns(&mut instance));
    for step in 1..=400 {
        instance.step_to(0.01 * f64::from(step)).expect("the motion goes on");
        passages.extend(instance.take_passages());
        let now = turns(&mut instance);
        crossings += usize::from(now != before);
        before = now;
    }
    assert!(crossings >= 4, "{crossings}");
    // The last step may have passed a pose beyond the stop time.
    passages.retain(|passage| passage.time <= 4.0);
    assert_eq!(passages.len(), crossings, "{passages:?}");
    for passage in &passages {
        assert!(!passage.joints.is_empty() && passage.to_string().contains(&passage.joints[0]), "{passage}");
        // A communication point in the very pose.
        let mut other = Instance::new(model.clone());
        other.setup(0.0, Some(4.0), Some(1e-10)).expect("times");
        other.initialise().expect("consistent");
        other.step_to(passage.time).expect("the polynomial serves it");
        let angle = get_variable(&mut other, "crank.angle");
        assert!(angle.sin().abs() < 0.02, "{passage}: {angle}");
        assert!(get_variable(&mut other, "constraint.position") < 1e-10);
    }
}

/// Steps that end at communication points, in the zone too, because an input changes at each of them.
#[test]
fn a_torque_that_changes_at_every_point_leaves_nothing_behind() {
    for (tolerance, points) in [(1e-4, 400), (1e-8, 400), (1e-8, 4000), (1e-12, 1000)] {
        let (model, mut instance) = parallelogram(tolerance);
        let input = model.program().variables.iter().position(|variable| variable.name == "torque").expect("an input");
        for step in 1..=points {
            let torque = if step % 2 == 0 { 0.3 } else { -0.3 };
            instance.set(input, torque).expect("an input");
            let time = 4.0 * f64::from(step) / f64::from(points);
            instance.step_to(time).unwrap_or_else(|error| panic!("{tolerance:e}, {points}: {error}"));
            let coupler = get_variable(&mut instance, "coupler.angle");
            assert!(coupler.sin().abs() < 1e-2 && coupler.cos() > 0.0, "{tolerance:e}, {points}: {coupler} at {time}");
        }
    }
}

/// A start in the flat pose goes on as the motion does that has just come there.
#[test]
fn a_start_in_the_pose_goes_on_like_the_motion_through_it() {
    let tolerance = 1e-11;
    for seed in 0..6 {
        let bars = neutral(seed);
        let outputs = ["crank.angle", "coupler.angle", "rocker.angle", "crank.omega", "coupler.omega", "rocker.omega"];
        let motion = |instance: &mut Instance| outputs.map(|name| get_variable(instance, name));
        let started = |scene: cotree::scene::Scene| {
            let scene = outputs.into_iter().fold(scene, |scene, name| scene.output(name)).stop(20.0);
            let program = compile(&scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100))).program;
            let mut instance = Instance::new(Arc::new(Model::new(program).expect("a sound program")));
            instance.setup(0.0, Some(20.0), Some(tolerance)).expect("times");
            instance.initialise().expect("consistent");
            instance
        };
        let mut through = started(bars.scene("through"));
        let mut time = 0.0;
        let passage = loop {
            time += 0.01;
            through.step_to(time).expect("the motion goes on");
            if let Some(passage) = through.take_passages().into_iter().find(|passage| passage.time > time) {
                break passage.time;
            }
            assert!(time < 15.0, "{seed}: no passage in {bars:?}");
        };
        through.step_to(passage).expect("served from the polynomial");
        let pose = motion(&mut through);
        let scene = bars.scene_from("again", [pose[0], pose[1], pose[2]], pose[3]);
        let mut again = started(scene.initial(outputs[4], pose[4]).initial(outputs[5], pose[5]));
        for step in 1..=30 {
            let after = 0.01 * f64::from(step);
            again.step_to(after).unwrap_or_else(|error| panic!("{seed}: {error}"));
            through.step_to(passage + after).expect("the motion goes on");
            let (expected, found) = (motion(&mut through), motion(&mut again));
            for ((expected, found), name) in expected.iter().zip(&found).zip(outputs) {
                let error = (expected - found).abs() / expected.abs().max(1.0);
                assert!(error < 1e-4, "{seed}: {name} {found} instead of {expected}, {after} s after the pose");
            }
        }
    }
}

fn refusal(family: &str) -> Vec<String> {
    let cases: Vec<Case> = cases(1).into_iter().filter(|case| case.family == family).collect();
    assert!(!cases.is_empty());
    let refused = |case: &Case| match case.run(&case.model().expect("a model"), None, 1e-8, Points::Even(10)) {
        Outcome::Refused(message) => message,
        other => panic!("{other:?}"),
    };
    cases.iter().map(refused).collect()
}

#[test]
fn what_cannot_be_decided_is_refused_with_names() {
    for message in refusal("start in the pose, undecided") {
        assert!(message.contains("`rocker_pin`") && message.contains("branch"), "{message}");
    }
}

#[test]
fn the_end_of_reach_is_an_error_that_names_the_joint() {
    for message in refusal("lock-up") {
        // The crank's tip is then as far from the rocker's pivot as coupler and rocker reach.
        let angle = ((1.0 + 1.2_f64.powi(2) - 1.5_f64.powi(2)) / (2.0 * 1.2)).acos();
        let time = message.split("t = ").nth(1).and_then(|rest| rest.split(' ').next()).and_then(|t| t.parse().ok());
        assert!(time.is_some_and(|time: f64| (time - (angle - 1.0)).abs() < 1e-6), "{message}");
        assert!(message.contains("`rocker_pin`"), "{message}");
    }
}

#[test]
fn a_redundant_rod_is_named_and_changes_nothing() {
    let case = cases(1).into_iter().find(|case| case.family == "five-link with a redundant rod").expect("the case");
    let compiled = compile(&case.scene).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    let redundant: Vec<_> = compiled.program.constraints.iter().filter(|constraint| !constraint.active).collect();
    assert_eq!(redundant.len(), 1);
    assert!(redundant[0].owner.starts_with("high_") || redundant[0].owner.starts_with("low_"), "{redundant:?}");
    let warnings = compiled.warnings.map(|warnings| warnings.render(false, 100)).unwrap_or_default();
    let said = format!("{} {warnings}", compiled.summary);
    assert!(said.contains("redundant") && said.contains("not unique") && said.contains(&redundant[0].owner), "{said}");
}
