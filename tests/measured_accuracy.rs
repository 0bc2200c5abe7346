//! What accuracy costs is measured within a budget of work, whatever the motion does.

use crate::support::run;

use cotree_page::accuracy;
use run::{compiled, scene_of};

/// A wheel whose bearing drives it, faster and faster: its speed grows by a factor of 10^17 in each second.
const RUNAWAY: &str = r#"
format = 1
name = "runaway"
gravity = [0, -9.81]
[parameters]
drag = -4.0
[bodies.wheel]
mass = 1.0
inertia = 0.05
points = { hub = [0.22, 0] }
[joints.bearing]
type = "revolute"
between = ["ground", "wheel.hub"]
damping = "drag"
[initial]
"wheel.angle" = 0.3
[outputs]
variables = ["wheel.angle", "wheel.omega"]
[experiment]
stop = 2.0
step = 0.01
"#;

#[test]
fn motion_that_grows_without_bound_is_measured_at_its_beginning_only() {
    let accuracy = accuracy::of(&compiled(RUNAWAY)).expect("a measurement");
    let [start, stop] = accuracy.span;
    assert!(accuracy.growing && start == 0.0 && stop > 0.1 && stop < 1.5, "{accuracy:?}");
    let work: u64 = accuracy.measurements.iter().map(|measurement| measurement.statistics.evaluations).sum();
    assert!(work < 200_000, "{work}");
}

#[test]
fn calm_motion_is_measured_as_a_whole() {
    for model in ["slider_crank", "double_pendulum", "quick_return"] {
        let compiled = compiled(&scene_of(model));
        let accuracy = accuracy::of(&compiled).expect("a measurement");
        assert!(!accuracy.growing, "{model}: {accuracy:?}");
        assert_eq!(accuracy.span, [compiled.description.experiment.start, compiled.description.experiment.stop]);
    }
}

/// A part of 2^-100 of the experiment is nothing next to a start that is not zero: the measurement never ended.
#[test]
fn an_experiment_may_begin_at_any_time() {
    for start in [-1.3, 1e-9, 1.0, 1e6] {
        let scene = RUNAWAY
            .replace("drag = -4.0", "drag = 0.1")
            .replace("stop = 2.0", &format!("start = {start:?}\nstop = {:?}", start + 2.0));
        let accuracy = accuracy::of(&compiled(&scene)).expect("a measurement");
        assert_eq!(accuracy.span, [start, start + 2.0]);
    }
}

/// Work per second exceeded all numbers, and the measurement never ended.
#[test]
fn an_experiment_may_be_as_short_as_numbers_permit() {
    for stop in [1e-250, 1e-280, 1e-300, 1e-307] {
        let scene = RUNAWAY.replace("stop = 2.0\nstep = 0.01", &format!("stop = {stop:e}\nstep = {stop:e}"));
        let accuracy = accuracy::of(&compiled(&scene)).expect("a measurement");
        assert_eq!((accuracy.span, accuracy.growing), ([0.0, stop], false));
    }
}
