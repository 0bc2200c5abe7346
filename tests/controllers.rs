//! Signals with a memory: controllers, filters and delays against closed forms, matrix exponentials and recurrences, by every method.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::sensitivities::check as check_sensitivities;
use crate::support::ROOT;
use crate::support::exchange::integrate;
use crate::support::run::{compiled, model, scene_of, sound, started, value};

use cotree::compile::compile;
use cotree::diagnostic::Faults;
use cotree::scene::{Body, Driver, Scene, Signal, State};
use cotree_fmu::instance::Instance;
use cotree_fmu::program::Engine;
use cotree_study::analysis::{LinearisedAt, Study};
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

const METHODS: [Engine; 3] = [Engine::Taylor, Engine::Dop853, Engine::Radau];

/// Something that moves beside the signals.
const WHEEL: &str = r#"
name = "signals"
[bodies.wheel]
mass = 1.0
inertia = 0.5
[joints.axle]
type = "revolute"
between = ["ground", "wheel"]
[initial]
"wheel.angle" = 0.0
"wheel.omega" = 1.0
[experiment]
stop = "3 s"
tolerance = 1e-12
"#;

fn beside_a_wheel(signals: &str, outputs: &str) -> String {
    format!("{WHEEL}{signals}\n[outputs]\nvariables = [{outputs}]\n")
}

/// y and y' of y'' = w^2 (u - y) - 2 d w y' at rest at the start, with u constant, as a multiple of the way.
fn second_order(w: f64, d: f64, time: f64) -> [f64; 2] {
    let decay = (-d * w * time).exp();
    let (even, odd) = if d < 1.0 {
        let own = w * (1.0 - d * d).sqrt();
        ((own * time).cos(), (own * time).sin() / own)
    } else if d > 1.0 {
        let own = w * (d * d - 1.0).sqrt();
        ((own * time).cosh(), (own * time).sinh() / own)
    } else {
        (1.0, time)
    };
    [1.0 - decay * (even + d * w * odd), decay * w * w * odd]
}

#[test]
fn filters_step_as_their_closed_forms_by_every_method() {
    let kinds = [("slow", "damping = 0.3", 0.3), ("even", "damping = 1", 1.0), ("wide", "damping = 2.5", 2.5)];
    let flat = ("flat", "", FRAC_1_SQRT_2);
    let of = |(name, damping, _): (&str, &str, f64)| {
        format!("[signals.{name}]\ntype = \"filter\"\ninput = 2\nstart = 0.5\ncutoff = \"4 rad/s\"\n{damping}\n")
    };
    let first = "[signals.first]\ntype = \"filter\"\ninput = 2\nstart = 0.5\ntime = \"0.4 s\"\n";
    let signals: String = kinds.into_iter().chain([flat]).map(of).chain([first.to_owned()]).collect();
    let names = "\"slow\", \"even\", \"wide\", \"flat\", \"first\", \"slow.rate\", \"flat.value\"";
    let model = model(&beside_a_wheel(&signals, names));
    for engine in METHODS {
        let mut run = started(&model, Some(engine), 3.0, 1e-12);
        for time in [0.0, 0.07, 0.4, 1.3, 3.0] {
            if time > 0.0 {
                run.step_to(time).unwrap();
            }
            let mut check = |name: &str, expected: f64| {
                let found = value(&mut run, name);
                assert!((found - expected).abs() < 1e-9, "{engine:?}: {name} at {time} s is {found}, not {expected}");
            };
            for (name, _, damping) in kinds.into_iter().chain([flat]) {
                check(name, 0.5 + 1.5 * second_order(4.0, damping, time)[0]);
            }
            check("first", 2.0 - 1.5 * (-time / 0.4).exp());
            check("slow.rate", 1.5 * second_order(4.0, 0.3, time)[1]);
            check("flat.value", 0.5 + 1.5 * second_order(4.0, FRAC_1_SQRT_2, time)[0]);
        }
    }
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|factor| factor as f64).product()
}

/// Padé's approximation [n - 1/n] of exp(-s) in companion form: what it gives of a unit step at a time.
fn pade_step(n: usize, time: f64) -> f64 {
    let of = |top: usize, k: usize| {
        factorial(2 * n - 1 - k) * factorial(top) / (factorial(2 * n - 1) * factorial(k) * factorial(top - k))
    };
    let lead = of(n, n);
    let mut system = DMatrix::zeros(n + 1, n + 1);
    (0..n - 1).for_each(|row| system[(row, row + 1)] = 1.0);
    (0..n).for_each(|k| system[(n - 1, k)] = -of(n, k) / lead);
    system[(n - 1, n)] = 1.0;
    let mut start = DVector::zeros(n + 1);
    start[n] = 1.0;
    let now = (system * time).exp() * start;
    (0..n).map(|k| now[k] * of(n - 1, k) * (-1.0_f64).powi(k as i32) / lead).sum()
}

#[test]
fn delays_step_as_their_approximations_by_every_method() {
    let orders = [1, 2, 4, 7];
    let of = |order: &usize| {
        format!("[signals.d{order}]\ntype = \"delay\"\ninput = 2\nstart = 0.5\ntime = \"0.3 s\"\norder = {order}\n")
    };
    let names: Vec<String> = orders.iter().map(|order| format!("\"d{order}\"")).collect();
    let model = model(&beside_a_wheel(&orders.iter().map(of).collect::<String>(), &names.join(", ")));
    for engine in METHODS {
        let mut run = started(&model, Some(engine), 3.0, 1e-12);
        for time in [0.05, 0.3, 0.45, 1.5] {
            run.step_to(time).unwrap();
            for order in orders {
                let expected = 0.5 + 1.5 * pade_step(order, time / 0.3);
                let found = value(&mut run, &format!("d{order}"));
                assert!(
                    (found - expected).abs() < 1e-8,
                    "{engine:?}, order {order}: {found} at {time}, not {expected}"
                );
            }
        }
    }
}

/// The errors that docs/machines.md gives, at a product of frequency and time of one: what comes of a sine when all else has died away.
#[test]
fn a_delay_of_a_sine_is_as_exact_as_is_said() {
    for (order, error) in [(1, 3.5e-1), (2, 1.3e-2), (3, 1.4e-4), (4, 7e-7), (5, 2.2e-9)] {
        let signal = format!("[signals.late]\ntype = \"delay\"\ninput = \"sin(2*t)\"\ntime = 0.5\norder = {order}\n");
        let mut run = started(&model(&beside_a_wheel(&signal, "\"late\"")), None, 40.0, 1e-12);
        let mut largest = 0.0_f64;
        for step in 0..60 {
            let time = 36.0 + 0.06 * f64::from(step);
            run.step_to(time).unwrap();
            largest = largest.max((value(&mut run, "late") - (2.0 * (time - 0.5)).sin()).abs());
        }
        assert!(largest < error && largest > 0.8 * error, "order {order}: {largest}");
    }
}

/// A block of 2 kg on a rail with friction, moved by a controller of what it is given.
fn servo(controller: &str) -> String {
    format!(
        r#"
name = "servo"
[bodies.block]
mass = 2.0
inertia = 0.1
[joints.rail]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
damping = 1.5
[parameters]
kp = "40 N/m"
ki = "25 N/m/s"
kd = "9 N.s/m"
[inputs]
wanted = {{ start = "0.3 m" }}
[signals.push]
type = "pid"
error = "wanted - rail.s"
{controller}
[loads.drive]
type = "force"
on = "block"
vector = ["push", 0]
[initial]
"rail.s" = 0.05
"rail.v" = 0.1
[outputs]
variables = ["rail.s", "rail.v", "push"]
[experiment]
stop = "2 s"
tolerance = 1e-12
"#
    )
}

const LINEAR: &str = "proportional = \"kp\"\nintegral = \"ki\"\nderivative = \"kd\"\nfilter = \"30 ms\"\nstart = \"0.7 N\"\nbefore = \"0.1 m\"\n";

/// s, v, integral part, filtered error: the loop as a matrix.
fn loop_at(time: f64) -> DVector<f64> {
    let (kp, ki, kd, filter, mass, damping) = (40.0, 25.0, 9.0, 0.03, 2.0, 1.5);
    let stiff = kp + kd / filter;
    // Of s, v, z, x and 1, with e = 0.3 - s.
    #[rustfmt::skip]
    let system = DMatrix::from_row_slice(5, 5, &[
        0.0, 1.0, 0.0, 0.0, 0.0,
        -stiff / mass, -damping / mass, 1.0 / mass, -kd / filter / mass, 0.3 * stiff / mass,
        -ki, 0.0, 0.0, 0.0, 0.3 * ki,
        -1.0 / filter, 0.0, 0.0, -1.0 / filter, 0.3 / filter,
        0.0, 0.0, 0.0, 0.0, 0.0,
    ]);
    (system * time).exp() * DVector::from_vec(vec![0.05, 0.1, 0.7, 0.1, 1.0])
}

#[test]
fn a_controlled_block_is_a_matrix_exponential_by_every_method() {
    let model = model(&servo(LINEAR));
    for engine in METHODS {
        let mut run = started(&model, Some(engine), 2.0, 1e-12);
        for time in [0.0, 0.01, 0.3, 1.1, 2.0] {
            if time > 0.0 {
                run.step_to(time).unwrap();
            }
            let now = loop_at(time);
            let error = 0.3 - now[0];
            let push = 40.0 * error + now[2] + 9.0 * (error - now[3]) / 0.03;
            let values = [("rail.s", now[0]), ("rail.v", now[1]), ("push", push), ("push.integral", now[2])];
            for (name, expected) in values {
                let found = value(&mut run, name);
                assert!((found - expected).abs() < 2e-9, "{engine:?}: {name} at {time} s is {found}, not {expected}");
            }
        }
    }
}

/// The loop with limits by Runge-Kutta steps that halve where both halves disagree: s, v, integral part, filtered error.
fn limited(mut y: [f64; 4], from: f64, to: f64, tracking: f64) -> [f64; 4] {
    let rates = |[s, v, z, x]: [f64; 4]| {
        let error = 0.3 - s;
        let slope = (error - x) / 0.03;
        let wanted = 40.0 * error + z + 9.0 * slope;
        let push = wanted.clamp(-2.0, 3.0);
        [v, (push - 1.5 * v) / 2.0, 25.0 * error + (push - wanted) / tracking, slope]
    };
    let step = |y: [f64; 4], h: f64| -> [f64; 4] {
        let moved = |rates: [f64; 4], h: f64| std::array::from_fn(|i| y[i] + h * rates[i]);
        let first = rates(y);
        let second = rates(moved(first, 0.5 * h));
        let third = rates(moved(second, 0.5 * h));
        let fourth = rates(moved(third, h));
        std::array::from_fn(|i| y[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]))
    };
    let (mut time, mut h) = (from, 1e-3_f64);
    while time < to {
        h = h.min(to - time);
        let (whole, halves) = (step(y, h), step(step(y, 0.5 * h), 0.5 * h));
        let error = (0..4).map(|i| (whole[i] - halves[i]).abs()).fold(0.0, f64::max);
        if error > 1e-13 && h > 1e-9 {
            h *= 0.5;
        } else {
            (y, time, h) = (halves, time + h, 2.0 * h);
        }
    }
    y
}

#[test]
fn an_integral_gives_way_at_a_limit_by_every_method() {
    for (tracking, key) in [(40.0 / 25.0, ""), (0.2, "tracking = \"0.2 s\"\n")] {
        let model = model(&servo(&format!("{LINEAR}min = \"-2 N\"\nmax = \"3 N\"\n{key}")));
        for engine in METHODS {
            let mut run = started(&model, Some(engine), 2.0, 1e-12);
            let (mut y, mut from, mut bounded) = ([0.05, 0.1, 0.7, 0.1], 0.0, 0);
            for time in [0.02, 0.1, 0.35, 0.9, 2.0] {
                y = limited(y, from, time, tracking);
                from = time;
                run.step_to(time).unwrap();
                let error = 0.3 - y[0];
                let wanted = 40.0 * error + y[2] + 9.0 * (error - y[3]) / 0.03;
                bounded += usize::from(!(-2.0..=3.0).contains(&wanted));
                for (name, expected) in
                    [("rail.s", y[0]), ("rail.v", y[1]), ("push", wanted.clamp(-2.0, 3.0)), ("push.integral", y[2])]
                {
                    let found = value(&mut run, name);
                    let close = (found - expected).abs() < 2e-8;
                    assert!(close, "{engine:?}, {tracking} s: {name} at {time} s is {found}, not {expected}");
                }
            }
            assert!(bounded > 0, "no limit was reached");
        }
    }
}

/// s, v, output, integral, derivative, error of the last tick: with friction the block is a matrix exponential between ticks.
fn sampled_at(time: f64, filter: f64) -> [f64; 3] {
    let period = 0.02;
    let (mut s, mut v, mut z, mut slope, mut last) = (0.05_f64, 0.1_f64, 0.7_f64, 0.0_f64, 0.1_f64);
    let block = nalgebra::Matrix3::new(0.0, 1.0, 0.0, 0.0, -0.75, 0.5, 0.0, 0.0, 0.0);
    let mut tick = 0;
    loop {
        let error = 0.3 - s;
        slope = (filter * slope + 9.0 * (error - last)) / (filter + period);
        let wanted = 40.0 * error + z + slope;
        let push = wanted.clamp(-2.0, 3.0);
        z += period * 25.0 * error + period / 0.2 * (push - wanted);
        last = error;
        let end = f64::min(period * f64::from(tick + 1), time);
        let next = (block * (end - period * f64::from(tick))).exp() * nalgebra::Vector3::new(s, v, push);
        (s, v) = (next.x, next.y);
        tick += 1;
        if time < period * f64::from(tick) {
            return [s, v, push];
        }
    }
}

#[test]
fn a_sampled_controller_is_its_recurrence_by_every_method() {
    for (filter, key) in [(0.03, "filter = \"30 ms\"\n"), (0.0, "")] {
        let keys = LINEAR.replace("filter = \"30 ms\"\n", key);
        let keys = format!("{keys}min = \"-2 N\"\nmax = \"3 N\"\ntracking = \"0.2 s\"\nperiod = \"20 ms\"\n");
        let model = model(&servo(&keys));
        for engine in METHODS {
            let mut run = started(&model, Some(engine), 2.0, 1e-12);
            for time in [0.005, 0.0317, 0.5, 1.0001, 1.99] {
                run.step_to(time).unwrap();
                for (name, expected) in ["rail.s", "rail.v", "push"].iter().zip(sampled_at(time, filter)) {
                    let found = value(&mut run, name);
                    assert!((found - expected).abs() < 1e-9, "{engine:?}: {name} at {time} is {found}, not {expected}");
                }
            }
        }
    }
}

/// Before its first tick a sampled controller gives its start, within its limits; a tracking time below the period is the period.
#[test]
fn a_sampled_controller_begins_with_its_start_and_never_tracks_faster_than_it_ticks() {
    let keys = |tracking: &str| {
        format!(
            "proportional = \"kp\"\nintegral = \"ki\"\nstart = \"7 N\"\nmax = \"3 N\"\ntracking = \"{tracking}\"\nperiod = \"20 ms\"\noffset = \"50 ms\"\n"
        )
    };
    let end = |tracking: &str| {
        let mut run = started(&model(&servo(&keys(tracking))), None, 2.0, 1e-10);
        run.step_to(0.04).unwrap();
        assert_eq!(value(&mut run, "push"), 3.0);
        run.step_to(1.5).unwrap();
        ["rail.s", "push", "push.integral"].map(|name| value(&mut run, name))
    };
    assert_eq!(end("20 ms"), end("1 ms"));
    assert_ne!(end("20 ms"), end("40 ms"));
}

/// A filter with a unit of its own may depend on itself: y' = (1 - y - y)/T.
#[test]
fn a_filter_hears_of_itself() {
    let of = |unit: &str| {
        let filter = format!("[signals.fed]\ntype = \"filter\"\ninput = \"rest\"\ntime = 0.5\n{unit}\n");
        beside_a_wheel(&format!("{filter}[signals.rest]\nvalue = \"1 - fed\"\n"), "\"fed\", \"rest\"")
    };
    let mut run = started(&model(&of("unit = \"1\"")), None, 3.0, 1e-12);
    run.step_to(0.8).unwrap();
    let expected = 0.5 * (1.0 - (-2.0 * 0.8 / 0.5_f64).exp());
    assert!((value(&mut run, "fed") - expected).abs() < 1e-10);
    assert!((value(&mut run, "rest") - 1.0 + expected).abs() < 1e-10);
    let fault = fault(&of(""));
    assert!(fault.contains("signals depend on each other") && fault.contains("its `unit`"), "{fault}");
}

/// Two sampled controllers, one within the other, see the same values at a tick, and both those before it.
#[test]
fn a_cascade_sees_what_was_before_the_tick() {
    let keys = "proportional = \"3 s^-1\"\nperiod = \"20 ms\"\n";
    let outer =
        format!("[signals.speed]\ntype = \"pid\"\nerror = \"wanted - rail.s\"\nunit = \"m/s\"\n{keys}[signals.push]");
    let inner = "proportional = \"12 N.s/m\"\nperiod = \"20 ms\"\n";
    let text = servo(inner).replace("[signals.push]", &outer).replace(
        "type = \"pid\"\nerror = \"wanted - rail.s\"\nproportional = \"12",
        "type = \"pid\"\nerror = \"speed - rail.v\"\nproportional = \"12",
    );
    let (mut s, mut v, mut speed) = (0.05_f64, 0.1_f64, 0.0_f64);
    let block = nalgebra::Matrix3::new(0.0, 1.0, 0.0, 0.0, -0.75, 0.5, 0.0, 0.0, 0.0);
    let mut run = started(&model(&text), None, 2.0, 1e-12);
    for tick in 1..=60 {
        let push = 12.0 * (speed - v);
        speed = 3.0 * (0.3 - s);
        let next = (block * 0.02).exp() * nalgebra::Vector3::new(s, v, push);
        (s, v) = (next.x, next.y);
        run.step_to(0.02 * f64::from(tick) - 1e-9).unwrap();
        assert!((value(&mut run, "push") - push).abs() < 1e-8, "tick {tick}");
    }
}

#[test]
fn sensitivities_go_through_controllers_filters_and_delays() {
    let chain = "[signals.seen]\ntype = \"delay\"\ninput = \"rail.s\"\ntime = \"40 ms\"\norder = 3\n[signals.even]\ntype = \"filter\"\ninput = \"wanted\"\ncutoff = \"9 rad/s\"\n[signals.push]";
    let text = servo(LINEAR).replace("[signals.push]", chain).replace("wanted - rail.s", "even - seen");
    check_sensitivities(&text, &["kp", "ki", "kd", "wanted", "push.integral", "rail.v"], 0.8, 1e-3, 1e-8);
}

#[test]
fn the_linear_system_and_the_rest_have_the_states() {
    let text = servo(LINEAR)
        .replace("[initial]", "[loads.weight]\ntype = \"force\"\non = \"block\"\nvector = [\"-6 N\", 0]\n[initial]");
    let scene = Scene::from_toml(&text).unwrap();
    let system = Study::new(&scene).unwrap().linearize(&LinearisedAt::Times(vec![0.0])).unwrap();
    let names: Vec<&str> = system.points[0].states.iter().map(|state| state.name.as_str()).collect();
    assert_eq!(names, ["rail.s", "rail.v", "push.integral", "push.error"]);
    let rest = Study::new(&scene).unwrap().equilibrium().unwrap();
    for (name, expected) in [("rail.s", 0.3), ("push.integral", 6.0)] {
        let found = rest.value(name).unwrap();
        assert!((found - expected).abs() < 1e-9, "{name} rests at {found}, not {expected}");
    }
}

#[test]
fn an_integrator_outside_has_the_states_of_signals() {
    let text = servo(LINEAR);
    let mut outside = Instance::new(model(&text));
    outside.setup(0.0, None, None).unwrap();
    integrate(&mut outside, 0.3, 2e-4).unwrap();
    let mut states = [0.0; 4];
    outside.states(&mut states).unwrap();
    for (found, expected) in states.iter().zip(loop_at(0.3).iter()) {
        assert!((found - expected).abs() < 1e-7, "{states:?}");
    }
    let description = compiled(&text).description;
    let units = ["push.integral", "push.error", "der(push.integral)"].map(|name| {
        let own = description.variables.iter().find(|variable| variable.name == name).unwrap();
        own.unit.si.clone()
    });
    assert_eq!(units.map(|unit| unit.to_string()), ["N", "m", "N/s"]);
}

/// The signals of a part have the name of the part in front, and so have their states.
#[test]
fn a_part_brings_its_signals() {
    let folder = tempfile::tempdir().unwrap();
    let text = servo(LINEAR).replace("\"rail.v\", \"push\"]", "\"rail.v\", \"push\", \"push.integral\"]");
    std::fs::write(folder.path().join("servo.toml"), text).unwrap();
    let whole = folder.path().join("both.toml");
    std::fs::write(
        &whole,
        "name = \"both\"\n[parts]\nleft = { file = \"servo.toml\" }\nright = { file = \"servo.toml\", at = [0, 1] }\n",
    )
    .unwrap();
    let program = sound(compile(&sound(Scene::read(&whole)))).program;
    let mut run = Instance::new(std::sync::Arc::new(cotree_fmu::model::Model::new(program).unwrap()));
    run.setup(0.0, None, Some(1e-12)).unwrap();
    run.initialise().unwrap();
    run.step_to(0.3).unwrap();
    for part in ["left", "right"] {
        assert!((value(&mut run, &format!("{part}_push.integral")) - loop_at(0.3)[2]).abs() < 1e-9);
    }
}

/// What is built in Rust is what is written, and a driven mechanism has signals beside it.
#[test]
fn signals_are_built_in_rust() {
    let scene = Scene::new("driven")
        .body("crank", Body::new().point("tip", [0.3, 0.0]))
        .revolute("axle", "ground", "crank")
        .driver("motor", Driver::angle("axle", "3*t"))
        .signal("smooth", Signal::filter("crank.omega").with("time", "0.5 s").unit("rad/s"))
        .signal("late", Signal::delay("crank.angle", "0.2 s").with("order", 5))
        .signal("drive", Signal::pid("crank.omega - smooth").with("integral", 2))
        .state("used", State::new(0.0, "late"))
        .output("smooth")
        .output("drive")
        .output("used");
    let program = sound(compile(&scene)).program;
    let mut run = Instance::new(std::sync::Arc::new(cotree_fmu::model::Model::new(program).unwrap()));
    run.setup(0.0, None, Some(1e-12)).unwrap();
    run.initialise().unwrap();
    run.step_to(2.0).unwrap();
    let decay = (-4.0_f64).exp();
    assert!((value(&mut run, "smooth") - 3.0 * (1.0 - decay)).abs() < 1e-9);
    assert!((value(&mut run, "drive") - 3.0 * (1.0 - decay)).abs() < 1e-9);
    // The delay of a ramp ends 0.2 s behind it, and the integral of what came before the ramp is its own.
    assert!((value(&mut run, "used") - 1.5 * 1.8 * 1.8).abs() < 1e-4);
}

fn fault(text: &str) -> String {
    let faults: Faults = Scene::from_toml(text).and_then(|scene| compile(&scene)).expect_err("a fault");
    faults.render(false, 400)
}

#[test]
fn what_is_wrong_with_keys_of_signals_is_said() {
    let filter = |keys: &str| fault(&beside_a_wheel(&format!("[signals.slow]\ntype = \"filter\"\n{keys}"), "\"slow\""));
    let pid = |keys: &str| fault(&servo(keys));
    let cases = [
        (filter("input = 1\n"), "filter `slow` has neither of `time` or `cutoff`"),
        (filter("input = 1\ntime = 1\ncutoff = 1\n"), "has both of `time` or `cutoff`"),
        (filter("input = 1\ntime = 1\ndamping = 1\n"), "has `damping`, but is a first-order filter"),
        (filter("input = 1\ntime = -1\n"), "`time` of filter `slow` must be positive"),
        (filter("time = 1\n"), "filter `slow` has no `input`"),
        (filter("input = 1\ncutoff = \"3 Hz\"\n"), "`Hz` does not say whether"),
        (filter("input = \"energy.kinetic\"\ntime = 1\n"), "`energy.kinetic`, a sum over the whole system"),
        (filter("input = \"3[N]*t/1[s]\"\nstart = \"2 m\"\ntime = 1\n"), "`start` of filter `slow`"),
        (filter("input = 1\ntime = \"1 m\"\n"), "must be a time"),
        (filter("input = 1\ntime = 1\nfast = 2\n"), "no key `fast`"),
        (pid(""), "has no gain"),
        (pid("derivative = \"kd\"\n"), "has a derivative, but no `filter`"),
        (pid("integral = \"ki\"\nmax = \"2 N\"\n"), "neither `tracking` nor `proportional`"),
        (
            pid("integral = \"ki\"\nproportional = \"-kp\"\nmax = \"2 N\"\n"),
            "`tracking` (`proportional/integral` unless it is given",
        ),
        (pid("proportional = \"kp\"\nmin = 3\nmax = 2\n"), "`max - min` of pid `push`"),
        (pid("proportional = \"kp\"\noffset = 2\n"), "has `offset`, but is not sampled"),
        (pid("proportional = \"kp\"\nintegral = \"kp\"\n"), "`integral` of pid `push` gives an output"),
        (pid("proportional = \"kp\"\nbefore = \"2 N\"\nintegral = \"ki\"\n"), "`before` of pid `push`"),
        (fault(&servo("proportional = \"kp\"\n").replace("\"pid\"", "\"pdi\"")), "did you mean `pid`"),
        (
            fault(&beside_a_wheel("[signals.late]\ntype = \"delay\"\ninput = 1\ntime = 1\norder = 2.5\n", "\"late\"")),
            "not an integer from 1 to 10",
        ),
        (
            fault(
                &servo("integral = \"ki\"\n")
                    .replace("[initial]", "[drivers.x]\njoint = \"rail\"\ndisplacement = \"push/100[N/m]\"\n[initial]"),
            ),
            "cannot depend on a state",
        ),
    ];
    for (found, expected) in cases {
        assert!(found.contains(expected), "{expected} is not in\n{found}");
    }
}

/// The bucket of the excavator in one coordinate, with oil, filter, delay and controller: angle, rate, both pressures, course and its rate, three of the delay.
struct Arm {
    state: [f64; 9],
    opening: f64,
    integral: f64,
    slope: f64,
    last: f64,
}

const HINGE: Vector2<f64> = Vector2::new(0.0, 0.0);
const PIN: Vector2<f64> = Vector2::new(0.4, -0.05);
const FOOT: Vector2<f64> = Vector2::new(-1.0, 0.3);

fn turned(angle: f64, x: f64, y: f64) -> Vector2<f64> {
    Vector2::new(angle.cos() * x - angle.sin() * y, angle.sin() * x + angle.cos() * y)
}

/// The same turned by a quarter: its rate by the angle.
fn quarter(way: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-way.y, way.x)
}

impl Arm {
    /// Eye of the cylinder and angle of the rocker and the link where the bucket has an angle: two circles meet above.
    fn pose(bucket: f64) -> [f64; 2] {
        let ear = PIN + turned(bucket, 0.12, 0.27);
        let way = ear - HINGE;
        let along = (0.45_f64.powi(2) - 0.5_f64.powi(2) + way.norm_squared()) / (2.0 * way.norm());
        let across = (0.45_f64.powi(2) - along * along).sqrt();
        let eye = HINGE + way.normalize() * along + quarter(way.normalize()) * across;
        [eye.y.atan2(eye.x), (ear - eye).y.atan2((ear - eye).x)]
    }

    /// Rates of the angles of rocker and link by that of the bucket, and the rates of these rates by the square of it.
    fn ratios(bucket: f64, [rocker, link]: [f64; 2]) -> [Vector2<f64>; 2] {
        let (a, b, c) = (turned(rocker, 0.45, 0.0), turned(link, 0.5, 0.0), turned(bucket, 0.12, 0.27));
        // hinge + a + b = pin + c, differentiated once and twice.
        let system = Matrix2::from_columns(&[quarter(a), quarter(b)]).try_inverse().unwrap();
        let first = system * quarter(c);
        let second = system * (a * first.x * first.x + b * first.y * first.y - c);
        [first, second]
    }

    fn rates(&self, y: [f64; 9]) -> [f64; 9] {
        let [bucket, omega, cap, rod, course, slope, p0, p1, p2] = y;
        let angles = Arm::pose(bucket);
        let [first, second] = Arm::ratios(bucket, angles);
        let (rocker, link) = (turned(angles[0], 0.45, 0.0), turned(angles[1], 0.5, 0.0));
        let com = turned(bucket, 0.05, -0.35);
        // Ways of the mass centres by the angle of the bucket, and their rates.
        let ways =
            [quarter(rocker) * 0.5 * first.x, quarter(rocker) * first.x + quarter(link) * 0.5 * first.y, quarter(com)];
        let bends = [
            quarter(rocker) * 0.5 * second.x - rocker * 0.5 * first.x * first.x,
            quarter(rocker) * second.x - rocker * first.x * first.x + quarter(link) * 0.5 * second.y
                - link * 0.5 * first.y * first.y,
            -com,
        ];
        let masses = [14.0, 11.0, 150.0];
        let turns = [(0.3, first.x, second.x), (0.25, first.y, second.y), (11.0, 1.0, 0.0)];
        let mut mass: f64 = turns.iter().map(|(inertia, ratio, _)| inertia * ratio * ratio).sum();
        let mut bend: f64 = turns.iter().map(|(inertia, ratio, bend)| inertia * ratio * bend).sum();
        let mut torque = -40.0 * omega;
        for ((m, way), own) in masses.iter().zip(&ways).zip(&bends) {
            mass += m * way.norm_squared();
            bend += m * way.dot(own);
            torque -= m * 9.81 * way.y;
        }
        let reach = HINGE + rocker - FOOT;
        let lever = reach.normalize().dot(&(quarter(rocker) * first.x));
        let (length, speed) = (reach.norm(), lever * omega);
        torque += (cap * 40e-4 - rod * 25e-4) * lever;
        let root = |left: f64| 5e-7 * self.opening * left.sqrt();
        let (into, out) = match self.opening > 0.0 {
            true => (root(14e6 - cap), root(rod - 0.2e6)),
            false => (root(cap - 0.2e6), root(14e6 - rod)),
        };
        let leak = 4e-11 * (cap - rod);
        let cap_rate = 1.2e9 * (into - leak - 40e-4 * speed) / (8e-4 + 40e-4 * (length - 1.0));
        let rod_rate = 1.2e9 * (25e-4 * speed + leak - out) / (1.5e-3 - 25e-4 * (length - 1.0));
        let wanted = -40_f64.to_radians();
        let curve = 25.0 * (wanted - course) - 10.0 * slope;
        // Padé's [2/3] in companion form, in thirties of a millisecond.
        let late = (bucket - p0 - 0.6 * p1 - 3.0 / 20.0 * p2) * 60.0 / 0.03;
        [omega, (torque - bend * omega * omega) / mass, cap_rate, rod_rate, slope, curve, p1 / 0.03, p2 / 0.03, late]
    }

    fn measured(&self) -> f64 {
        self.state[6] - 0.4 * self.state[7] + self.state[8] / 20.0
    }

    fn tick(&mut self) {
        let error = self.measured() - self.state[4];
        self.slope = (0.04 * self.slope + 0.04 * (error - self.last)) / 0.06;
        let wanted = 4.0 * error + self.integral + self.slope;
        self.opening = wanted.clamp(-0.6, 0.6);
        self.integral += 0.02 * 1.5 * error + 0.02 / (4.0 / 1.5) * (self.opening - wanted);
        self.last = error;
    }

    fn advance(&mut self, steps: usize, h: f64) {
        for _ in 0..steps {
            let moved = |rates: [f64; 9], h: f64| std::array::from_fn(|i| self.state[i] + h * rates[i]);
            let first = self.rates(self.state);
            let second = self.rates(moved(first, 0.5 * h));
            let third = self.rates(moved(second, 0.5 * h));
            let fourth = self.rates(moved(third, h));
            self.state = std::array::from_fn(|i| {
                self.state[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i])
            });
        }
    }

    fn row(&self) -> [f64; 8] {
        let [bucket, omega, cap, rod, course, ..] = self.state;
        let length = (HINGE + turned(Arm::pose(bucket)[0], 0.45, 0.0) - FOOT).norm();
        [bucket, omega, length, cap, rod, course, self.measured(), self.opening]
    }
}

#[test]
fn the_arm_of_an_excavator_follows_its_equations_in_one_coordinate() {
    const NAMES: [&str; 8] = [
        "bucket.angle",
        "bucket.omega",
        "cylinder.length",
        "cylinder.cap_pressure",
        "cylinder.rod_pressure",
        "course",
        "measured",
        "opening",
    ];
    let mut state = [0.0; 9];
    (state[2], state[3]) = (2.5e6, 4.1e6);
    let mut arm = Arm { state, opening: 0.0, integral: 0.0, slope: 0.0, last: 0.0 };
    let mut rows = Vec::new();
    for _ in 0..200 {
        arm.tick();
        rows.push(arm.row());
        arm.advance(1000, 2e-5);
    }
    arm.tick();
    rows.push(arm.row());
    let file = std::path::Path::new(ROOT).join("models/excavator_arm/expected.csv");
    if std::env::var_os("COTREE_WRITE_EXPECTED").is_some() {
        let line = |(index, row): (usize, &[f64; 8])| {
            let digits = |value: &f64| format!("{value:.14e}").parse::<f64>().unwrap().to_string();
            let time = digits(&(0.02 * index as f64));
            format!("{time},{}\n", row.iter().map(digits).collect::<Vec<_>>().join(","))
        };
        let table: String = rows.iter().enumerate().map(line).collect();
        std::fs::write(&file, format!("time,{}\n{table}", NAMES.join(","))).unwrap();
    }
    let text = std::fs::read_to_string(&file).unwrap();
    let numbers = |line: &str| line.split(',').skip(1).map(|own| own.parse::<f64>().unwrap()).collect::<Vec<_>>();
    let stored: Vec<Vec<f64>> = text.lines().skip(1).map(numbers).collect();
    assert_eq!(stored.len(), rows.len());
    let mut run = started(&model(&scene_of("excavator_arm")), None, 4.0, 1e-12);
    let largest = |place: usize| rows.iter().map(|row| row[place].abs()).fold(0.0, f64::max);
    let sizes: Vec<f64> = (0..NAMES.len()).map(largest).collect();
    for (index, (row, stored)) in rows.iter().zip(&stored).enumerate() {
        if index > 0 {
            run.step_to(0.02 * index as f64).unwrap();
        }
        for (place, name) in NAMES.iter().enumerate() {
            let (found, expected) = (value(&mut run, name), row[place]);
            let close = |other: f64| (other - expected).abs() < 1e-8 * sizes[place];
            assert!(
                close(found) && close(stored[place]),
                "{name} in row {index} is {found}, stored as {}, not {expected}",
                stored[place]
            );
        }
    }
}
