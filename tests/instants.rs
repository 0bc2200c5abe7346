//! Sampled values and events: against recurrences and closed forms, by every method, whoever asks when.

use std::sync::Arc;

use crate::support::ROOT;
use crate::support::exchange::integrate;
use crate::support::run::{RUBBING, RUBBING_IN_DRIVEN, compiled, model, models, scene_of, sound, started, value};

use cotree::compile::compile;
use cotree::diagnostic::Faults;
use cotree::scene::{Body, Event, Joint, Load, Sampled, Scene};
use cotree_fmu::instance::{Instance, InstanceError};
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use cotree_study::analysis::{LinearisedAt, Study};
use cotree_study::motion::MotionRequest;

const METHODS: [Engine; 3] = [Engine::Taylor, Engine::Dop853, Engine::Radau];

/// A block of 2 kg on a rail, held at 0.3 m by a sampled controller with an integral and a bound.
const SERVO: &str = r#"
name = "servo"
[bodies.block]
mass = 2.0
inertia = 0.1
[joints.rail]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[sampled.controller]
period = "20 ms"
[sampled.controller.values]
error = { start = "0.3 - rail.s", next = "0.3 - rail.s" }
sum   = { start = 0, next = "sum + 0.02*new(error)" }
push  = { start = 0, next = "max(-3, min(3, 40*new(error) + 30*new(sum) - 12*rail.v))", unit = "N" }
[loads.drive]
type = "force"
on = "block"
vector = ["push", 0]
[initial]
"rail.s" = 0.05
"rail.v" = 0.1
[outputs]
variables = ["rail.s", "rail.v", "push", "sum"]
[experiment]
stop = "2 s"
tolerance = 1e-10
"#;

/// Place, rate, force and sum at a time: between ticks the force is constant.
fn servo_at(time: f64) -> [f64; 4] {
    let (mut s, mut v, mut sum) = (0.05_f64, 0.1_f64, 0.0_f64);
    let mut tick = 0;
    loop {
        let now = 0.02 * f64::from(tick);
        let error = 0.3 - s;
        sum += 0.02 * error;
        let push = (40.0 * error + 30.0 * sum - 12.0 * v).clamp(-3.0, 3.0);
        let next = f64::min(0.02 * f64::from(tick + 1), time);
        let dt = next - now;
        (s, v) = (s + dt * (v + dt * push / 4.0), v + dt * push / 2.0);
        tick += 1;
        if time < 0.02 * f64::from(tick) {
            return [s, v, push, sum];
        }
    }
}

const SERVO_VALUES: [&str; 4] = ["rail.s", "rail.v", "push", "sum"];

#[test]
fn a_sampled_controller_follows_its_recurrence_by_every_method() {
    for engine in METHODS {
        let mut servo = started(&model(SERVO), Some(engine), 2.0, 1e-11);
        for time in [0.005, 0.0317, 0.5, 1.0001, 1.99] {
            servo.step_to(time).unwrap();
            for (name, expected) in SERVO_VALUES.iter().zip(servo_at(time)) {
                let found = value(&mut servo, name);
                assert!((found - expected).abs() < 1e-9, "{engine:?}: {name} at {time} s is {found}, not {expected}");
            }
        }
    }
}

/// Communication points, saved states and restored ones change no bit.
#[test]
fn ticks_do_not_depend_on_who_asks_when() {
    let scenes = [SERVO.to_owned(), LATCH.to_owned()];
    for (scene, engine) in scenes.iter().flat_map(|scene| METHODS.map(|engine| (scene, engine))) {
        let model = model(scene);
        let end = |step: f64, saved_at: f64| {
            let mut run = started(&model, Some(engine), 2.0, 1e-8);
            let (mut saved, mut time) = (None, 0.0);
            while time < 1.9 {
                time = f64::min(time + step, 1.9);
                run.step_to(time).unwrap();
                if saved.is_none() && (time > saved_at || time == 1.9) {
                    saved = Some(run.save());
                }
            }
            let registers = run.state().registers().to_vec();
            let bytes = saved.unwrap().to_bytes().unwrap();
            run.restore(&cotree_fmu::instance::Snapshot::from_bytes(&model, &bytes).unwrap()).unwrap();
            if run.time() < 1.9 {
                run.step_to(1.9).unwrap();
            }
            assert_eq!(run.state().registers(), registers, "{engine:?}: restored");
            registers
        };
        let whole = end(1.9, 0.0);
        for step in [1e-3, 0.013, 0.02, 0.25] {
            assert_eq!(end(step, 0.41), whole, "{engine:?}: steps of {step} s");
        }
    }
}

/// A spring holds a block that is pulled more and more; it gives way at 60 N.
const LATCH: &str = r#"
name = "latch"
[bodies.block]
mass = 2.0
inertia = 0.1
[joints.rail]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[sampled.count]
period = 1e3
offset = 1e3
values.n = 0
[loads.spring]
type = "spring"
between = ["ground", "block"]
stiffness = 200.0
length = "1 m"
[loads.pull]
type = "force"
on = "block"
vector = ["50*t", 0]
[events.release]
when = "spring.force < -60"
remove = ["spring"]
[events.passes]
when = "rail.v > 0.3"
set = { n = "n + 1" }
[initial]
"rail.s" = 1.0
"rail.v" = 0.0
[outputs]
variables = ["rail.s", "rail.v", "n", "events.release.time", "spring.force"]
[experiment]
stop = "2 s"
"#;

/// Stretch of the spring and its rate: x'' = 25 t - 100 x from rest.
fn stretched(time: f64) -> [f64; 2] {
    [0.25 * time - 0.025 * (10.0 * time).sin(), 0.25 - 0.25 * (10.0 * time).cos()]
}

#[test]
fn a_latch_opens_where_its_force_says_by_every_method() {
    // 60 N are 0.3 m.
    let (mut from, mut to) = (0.5_f64, 1.5_f64);
    for _ in 0..80 {
        let middle = 0.5 * (from + to);
        *(if stretched(middle)[0] < 0.3 { &mut from } else { &mut to }) = middle;
    }
    let [x, v] = stretched(to);
    let free = |time: f64| {
        let cubic = |t: f64| 25.0 * t * t * t / 6.0;
        let rate = |t: f64| 12.5 * t * t;
        [1.0 + x + (v - rate(to)) * (time - to) + cubic(time) - cubic(to), v - rate(to) + rate(time)]
    };
    for engine in METHODS {
        let mut latch = started(&model(LATCH), Some(engine), 2.0, 1e-11);
        latch.step_to(1.0).unwrap();
        assert_eq!(value(&mut latch, "events.release.time"), -1.0);
        latch.step_to(1.9).unwrap();
        let found = value(&mut latch, "events.release.time");
        assert!((found - to).abs() < 1e-9, "{engine:?}: opens at {found}, not {to}");
        let [place, rate] = free(1.9);
        assert!((value(&mut latch, "rail.s") - place).abs() < 1e-9, "{engine:?}");
        assert!((value(&mut latch, "rail.v") - rate).abs() < 1e-9, "{engine:?}");
        assert_eq!(value(&mut latch, "spring.force"), 0.0);
        // The rate is 0.5 at most with the spring, each 0.6283 s: it passes 0.3 upwards twice before the latch opens, and once behind it.
        assert_eq!(latch.events().collect::<Vec<_>>(), [("release", 1), ("passes", 3)]);
        assert_eq!(value(&mut latch, "n"), 3.0, "{engine:?}");
    }
}

/// A pendulum that passes the vertical is counted each time, and its largest swing is seen though it only just exceeds the request.
fn swinging(threshold: f64) -> Scene {
    Scene::new("swing")
        .gravity([0.0, -9.81])
        .body("bob", Body::new().mass(1.0).inertia(0.0).point("eye", [0.0, 0.5]))
        .joint("pin", Joint::revolute("ground", "bob.eye"))
        .sampled("counted", Sampled::every(1e6).offset(1e6).value("passed", 0.0, "passed").value("high", 0.0, "high"))
        .event("middle", Event::when("pin.angle > 0").set("passed", "passed + 1"))
        .event("top", Event::when(&format!("pin.angle > {threshold}")).set("high", "high + 1"))
        .initial("bob.angle", -0.4)
        .initial("bob.omega", 0.0)
}

#[test]
fn every_passage_is_counted_however_short_it_is() {
    for (over, expected) in [(1e-5, 4.0), (1e-8, 4.0), (-1e-8, 0.0)] {
        let scene = swinging(0.4 - over);
        let program = sound(compile(&scene)).program;
        let mut run = Instance::new(Arc::new(Model::new(program).unwrap()));
        run.setup(0.0, None, Some(1e-12)).unwrap();
        run.initialise().unwrap();
        // The period is 1.4331 s.
        run.step_to(5.2).unwrap();
        assert_eq!(value(&mut run, "passed"), 4.0);
        assert_eq!(value(&mut run, "high"), expected, "{over:e} above the top");
    }
}

/// A comparison that has ceased to hold begins to hold again where an input lets it, wherever in a step of the solver that is.
#[test]
fn an_input_that_jumps_lets_an_event_happen_again() {
    let scene = Scene::new("wave")
        .input("level", 0.0)
        .body("disc", Body::new().mass(1.0).inertia(1.0))
        .joint("axle", Joint::revolute("ground", "disc"))
        .sampled("counted", Sampled::every(1e6).offset(1e6).value("n", 0.0, "n"))
        .event("above", Event::when("sin(t) > level").set("n", "n + 1"))
        .initial("disc.angle", 0.0)
        .initial("disc.omega", 0.0);
    let program = sound(compile(&scene)).program;
    let mut run = Instance::new(Arc::new(Model::new(program).unwrap()));
    run.setup(0.0, None, Some(1e-6)).unwrap();
    run.initialise().unwrap();
    let level = run.variable("level").unwrap();
    run.step_to(1.0).unwrap();
    assert_eq!(value(&mut run, "n"), 1.0);
    // It has ceased at pi; the level falls below sin(4).
    run.step_to(4.0).unwrap();
    assert_eq!(value(&mut run, "n"), 1.0);
    run.set(level, -0.9).unwrap();
    run.step_to(4.01).unwrap();
    assert_eq!(value(&mut run, "n"), 2.0);
    // It holds all the time: nothing begins.
    run.set(level, -2.0).unwrap();
    run.step_to(9.0).unwrap();
    assert_eq!(value(&mut run, "n"), 2.0);
}

#[test]
fn samplers_that_tick_together_see_the_same_values() {
    let scene = Scene::new("two")
        .body("disc", Body::new().mass(1.0).inertia(1.0))
        .joint("axle", Joint::revolute("ground", "disc"))
        .sampled("fast", Sampled::every("0.1 s").value("a", 1.0, "b + 1"))
        .sampled("slow", Sampled::every("0.3 s").value("b", 2.0, "a + 10"))
        .load("hold", Load::torque("ground", "disc", "1[N.m]*a"))
        .event("end", Event::when("t >= 1.05").stop())
        .initial("disc.angle", 0.0)
        .initial("disc.omega", 0.0);
    let program = sound(compile(&scene)).program;
    let mut run = Instance::new(Arc::new(Model::new(program).unwrap()));
    run.setup(0.0, None, Some(1e-9)).unwrap();
    run.initialise().unwrap();
    let (mut a, mut b) = (3.0, 11.0);
    assert_eq!([value(&mut run, "a"), value(&mut run, "b")], [a, b], "the ticks at the start");
    for tick in 1..=10 {
        run.step_to(0.1 * f64::from(tick) + 0.01).unwrap();
        (a, b) = (b + 1.0, if tick % 3 == 0 { a + 10.0 } else { b });
        assert_eq!([value(&mut run, "a"), value(&mut run, "b")], [a, b], "tick {tick}");
    }
    let ended = run.step_to(2.0).expect_err("the run ends");
    assert!(ended.is_end() && (run.time() - 1.05).abs() < 1e-12, "{ended} {}", run.time());
    assert!(run.step_to(2.0).expect_err("it has ended").is_end());
}

#[test]
fn an_integrator_outside_lets_ticks_and_events_happen() {
    let model = model(SERVO);
    let mut outside = Instance::new(model);
    outside.setup(0.0, None, None).unwrap();
    integrate(&mut outside, 0.99, 1e-3).unwrap();
    let mut states = [0.0; 2];
    outside.states(&mut states).unwrap();
    let [s, v, push, _] = servo_at(0.99);
    assert!((states[0] - s).abs() < 1e-10 && (states[1] - v).abs() < 1e-10, "{states:?}, not {s}, {v}");
    assert!((value(&mut outside, "push") - push).abs() < 1e-9);
    let next = outside.handle_event().unwrap().next.unwrap();
    assert!((next - 1.0).abs() < 1e-12);
    outside.set_time(1.03).unwrap();
    let passed = outside.handle_event().expect_err("a tick was left out");
    assert!(matches!(passed, InstanceError::Passed { .. }) && passed.to_string().contains("nextEventTime"), "{passed}");
}

#[test]
fn the_description_says_what_changes_at_events_only() {
    let description = compiled(LATCH).description;
    let named = |name: &str| description.variables.iter().find(|own| own.name == name).unwrap();
    for name in ["n", "events.release.time"] {
        assert_eq!(named(name).variability.name(), "discrete");
    }
    assert_eq!(named("rail.s").variability.name(), "continuous");
    assert!(description.variables.iter().all(|own| !own.name.contains("presence")));
    assert_eq!(description.indicators, 2);
}

#[test]
fn values_that_are_held_cannot_be_set_and_are_inputs_of_linear_systems() {
    let mut servo = started(&model(SERVO), None, 2.0, 1e-9);
    let push = servo.variable("push").unwrap();
    assert!(matches!(servo.set(push, 1.0), Err(InstanceError::Calculated { .. })));
    let mut study = sound(Study::new(&sound(Scene::from_toml(SERVO))));
    let system = study.linearize(&LinearisedAt::Times(vec![0.05])).unwrap();
    let point = &system.points[0];
    let place = point.inputs.iter().position(|input| input.name == "push").unwrap();
    assert!((point.b[(1, place)] - 0.5).abs() < 1e-12, "{}", point.b);
    assert!(study.set("push", |_| Ok(1.0)).is_err());
    let rest = study.equilibrium().expect_err("it goes on").to_string();
    assert!(rest.contains("sampler `controller`"), "{rest}");
    // They have derivatives, and are none of what can be varied.
    assert!(study.sensitivities(&["rail.s".to_owned()], &[0.5]).is_ok());
    let unknown = study.sensitivities(&["push".to_owned()], &[0.5]).expect_err("held").to_string();
    assert!(unknown.contains("`push`"), "{unknown}");
}

#[test]
fn a_part_brings_what_it_samples() {
    let folder = tempfile::tempdir().unwrap();
    let ended = SERVO.replace(
        "[initial]",
        "[events.far]\nwhen = \"rail.s > 0.31\"\nset = { sum = \"sum/2 + 0*events.far.time\" }\n[initial]",
    );
    std::fs::write(folder.path().join("servo.toml"), ended).unwrap();
    let whole = folder.path().join("both.toml");
    let both = "name = \"both\"\n[parts]\nleft = { file = \"servo.toml\" }\nright = { file = \"servo.toml\" }\n";
    std::fs::write(&whole, both).unwrap();
    let program = sound(compile(&sound(Scene::read(&whole)))).program;
    let names: Vec<&str> = program.instants.events.iter().map(|event| event.name.as_str()).collect();
    assert_eq!(names, ["left_far", "right_far"]);
    let mut run = Instance::new(Arc::new(Model::new(program).unwrap()));
    run.setup(0.0, None, Some(1e-10)).unwrap();
    run.initialise().unwrap();
    run.step_to(0.1317).unwrap();
    let [s, _, push, sum] = servo_at(0.1317);
    for part in ["left", "right"] {
        for (name, expected) in [("rail.s", s), ("push", push), ("sum", sum), ("events", -1.0)] {
            let name = if name == "events" { format!("events.{part}_far.time") } else { format!("{part}_{name}") };
            assert!((value(&mut run, &name) - expected).abs() < 1e-9, "{name}");
        }
    }
}

fn fault(text: &str) -> String {
    let faults: Faults = Scene::from_toml(text).and_then(|scene| compile(&scene)).expect_err("a fault");
    faults.render(false, 400)
}

#[test]
fn what_is_wrong_with_instants_is_said() {
    let servo = |from: &str, to: &str| fault(&SERVO.replace(from, to));
    let circle = servo("sum + 0.02*new(error)", "sum + new(push)");
    assert!(circle.contains("in a cycle: `sum` -> `push` -> `sum`"), "{circle}");
    assert_eq!(circle.matches("×").count(), 1, "what follows from the circle is no fault of its own: {circle}");
    let far = servo("0.02*new(error)", "0.02*new(eror)");
    assert!(far.contains("`new(eror)`") && far.contains("`error`"), "{far}");
    let start = servo("start = \"0.3 - rail.s\"", "start = \"push\"");
    assert!(start.contains("whose start value is found at the same time"), "{start}");
    let period = servo("\"20 ms\"", "\"-20 ms\"");
    assert!(period.contains("must be positive"), "{period}");
    let unit = servo("unit = \"N\"", "unit = \"m\"");
    assert!(unit.contains("`m`") && unit.contains("N"), "{unit}");
    let driver =
        SERVO.replace("[loads.drive]", "[drivers.d]\ndisplacement = \"push\"\njoint = \"rail\"\n[loads.drive]");
    assert!(fault(&driver).contains("sampled value `push`"), "{}", fault(&driver));
    let signal = driver
        .replace("\"push\"\njoint", "\"gain\"\njoint")
        .replace("[drivers.d]", "[signals]\ngain = \"2*push\"\n[drivers.d]");
    assert!(fault(&signal).contains("the sampled value `push` (in signal `gain`)"), "{}", fault(&signal));
    let begun = SERVO.replace("start = \"0.3 - rail.s\"", "start = \"twice\"");
    let begun = fault(&begun.replace("[loads.drive]", "[signals]\ntwice = \"2*sum\"\n[loads.drive]"));
    assert!(begun.contains("the sampled value `sum` (in signal `twice`)"), "{begun}");
    let named = servo("[sampled.controller", "[sampled.con-troller");
    assert!(named.contains("cannot be the name of a sampler"), "{named}");
    let twice = SERVO.replace("[loads.drive]", "[inputs]\nsum = 0\n[loads.drive]");
    assert!(fault(&twice).contains("as input and as sampled value"), "{}", fault(&twice));
    let latch = |from: &str, to: &str| fault(&LATCH.replace(from, to));
    let none = latch("when = \"rail.v > 0.3\"", "when = \"rail.v\"");
    assert!(none.contains("expected `<`, `<=`, `>` or `>=`") || none.contains("`<`, `<=`, `>`"), "{none}");
    let bare = latch("rail.v > 0.3", "rail.v > 0.3 m/s");
    assert!(bare.contains("the unit of a number in an expression must be in brackets"), "{bare}");
    assert!(bare.contains("write `0.3[m]`"), "{bare}");
    for second in ["and rail.s < 2", "or rail.s < 2", "< 3"] {
        let two = latch("rail.v > 0.3", &format!("rail.v > 0.3 {second}"));
        assert!(two.contains("only one comparison") && two.contains("`min(a, b) > 0`"), "{two}");
    }
    let body = latch("remove = [\"spring\"]", "remove = [\"block\"]");
    assert!(body.contains("the body `block`") && body.contains("only joints, drivers and loads"), "{body}");
    let nothing = latch("remove = [\"spring\"]", "");
    assert!(nothing.contains("event `release` has no effect"), "{nothing}");
    let set = latch("set = { n", "set = { m");
    assert!(set.contains("neither a sampled value nor a state"), "{set}");
    let units = latch("rail.v > 0.3", "rail.v > 0.3[kg]");
    assert!(units.contains("compared with"), "{units}");
}

/// Bare numbers are in the unit of the value, at the start, at ticks and at events.
#[test]
fn bare_numbers_of_sampled_values_are_in_their_unit() {
    let scene = SERVO
        .replace("[loads.drive]", "gap = { start = 7, next = 5, unit = \"mm\" }\n[events.late]\nwhen = \"t > 0.051\"\nset = { gap = 3 }\n[loads.drive]")
        .replace("period = \"20 ms\"", "period = \"20 ms\"\noffset = \"10 ms\"");
    let mut run = started(&model(&scene), None, 2.0, 1e-9);
    for (time, expected) in [(0.005, 7e-3), (0.045, 5e-3), (0.06, 3e-3)] {
        run.step_to(time).unwrap();
        assert_eq!(value(&mut run, "gap"), expected, "at {time} s");
    }
}

#[test]
fn a_mass_that_only_an_event_needs_must_be_given() {
    let driven = SERVO.replace("mass = 2.0\ninertia = 0.1\n", "").replace(
        "[loads.drive]\ntype = \"force\"\non = \"block\"\nvector = [\"push\", 0]",
        "[drivers.move]\njoint = \"rail\"\ndisplacement = \"0.1[m/s3]*t^3\"\n[events.hard]\nwhen = \"move.force > 3\"\nstop = true",
    );
    let driven = driven.replace("\"rail.s\" = 0.05\n\"rail.v\" = 0.1\n", "");
    let needed = fault(&driven);
    assert!(needed.contains("body `block` has no `mass`: event `hard` needs it"), "{needed}");
}

/// Nothing of it is in the programs of scenes that do not use it.
#[test]
fn scenes_without_instants_have_none() {
    for name in models() {
        let scene = scene_of(&name);
        let words = ["[sampled", "[events", "\nperiod ", "\nlimits ", "backlash", "unilateral"];
        let sticks = RUBBING.contains(&name.as_str()) && name != RUBBING_IN_DRIVEN;
        if sticks || words.iter().any(|own| scene.contains(own)) {
            continue;
        }
        let Ok(compiled) = Scene::from_toml(&scene).and_then(|scene| compile(&scene)) else { continue };
        assert!(compiled.program.instants == cotree_fmu::program::Instants::default(), "{name}");
    }
}

/// A cart and a pole in two coordinates, by Runge-Kutta steps that end at every tick and at the release of the tether.
struct Cart {
    /// s, v, theta, omega.
    state: [f64; 4],
    push: f64,
    lean: f64,
    sum: f64,
    released: Option<f64>,
}

impl Cart {
    fn rates(&self, [s, v, theta, omega]: [f64; 4]) -> [f64; 4] {
        let (cart, pole, half) = (1.5, 0.3, 0.4);
        let inertia = pole * (2.0 * half) * (2.0 * half) / 12.0 + pole * half * half;
        let (sin, cos) = theta.sin_cos();
        let tether = if self.released.is_none() { -6.0 * s } else { 0.0 };
        let push = self.push + tether - 0.4 * v + pole * half * cos * omega * omega;
        let turn = -pole * 9.81 * half * cos;
        let coupling = -pole * half * sin;
        let determinant = (cart + pole) * inertia - coupling * coupling;
        let acceleration = (inertia * push - coupling * turn) / determinant;
        let alpha = ((cart + pole) * turn - coupling * push) / determinant;
        [v, acceleration, omega, alpha]
    }

    fn stepped(&self, h: f64) -> [f64; 4] {
        let moved = |rates: [f64; 4], h: f64| std::array::from_fn(|i| self.state[i] + h * rates[i]);
        let first = self.rates(self.state);
        let second = self.rates(moved(first, 0.5 * h));
        let third = self.rates(moved(second, 0.5 * h));
        let fourth = self.rates(moved(third, h));
        std::array::from_fn(|i| self.state[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]))
    }

    /// Moves on by a whole number of steps.
    fn advance(&mut self, from: f64, steps: usize, h: f64) {
        let release = 86_f64.to_radians();
        for step in 0..steps {
            let end = self.stepped(h);
            if self.released.is_some() || end[2] <= release {
                self.state = end;
                continue;
            }
            let (mut before, mut after) = (0.0, h);
            for _ in 0..60 {
                let middle = 0.5 * (before + after);
                *(if self.stepped(middle)[2] > release { &mut after } else { &mut before }) = middle;
            }
            self.state = self.stepped(after);
            self.released = Some(from + step as f64 * h + after);
            self.state = self.stepped(h - after);
        }
    }

    fn tick(&mut self) {
        let lean = std::f64::consts::FRAC_PI_2 - self.state[2];
        self.sum += 0.02 * lean;
        let push = 55.0 * lean + 30.0 * self.sum + 11.0 * (lean - self.lean) / 0.02;
        self.push = (push + 2.0 * self.state[0] + 4.0 * self.state[1]).clamp(-15.0, 15.0);
        self.lean = lean;
    }

    fn row(&self) -> [f64; 7] {
        let [s, v, theta, omega] = self.state;
        let tether = if self.released.is_none() { -6.0 * s } else { 0.0 };
        [s, v, theta, omega, self.push, tether, self.released.unwrap_or(-1.0)]
    }
}

#[test]
fn the_balancing_cart_follows_its_equations_in_two_coordinates() {
    let theta = 78_f64.to_radians();
    let lean = std::f64::consts::FRAC_PI_2 - theta;
    let mut cart = Cart { state: [0.0, 0.0, theta, 0.0], push: 0.0, lean, sum: 0.0, released: None };
    let mut rows = vec![cart.row()];
    // Ticks at 5 ms, 25 ms, ..., rows at 20 ms, 40 ms, ...
    for row in 0..200 {
        let begin = 0.02 * f64::from(row);
        cart.advance(begin, 100, 5e-5);
        cart.tick();
        cart.advance(begin + 0.005, 300, 5e-5);
        rows.push(cart.row());
    }
    let file = std::path::Path::new(ROOT).join("models/balancing_cart/expected.csv");
    if std::env::var_os("COTREE_WRITE_EXPECTED").is_some() {
        let names = "rail.s,rail.v,pole.angle,pole.omega,push,tether.force,events.release.time";
        let line = |(index, row): (usize, &[f64; 7])| {
            let digits = |value: &f64| format!("{value:.14e}").parse::<f64>().unwrap().to_string();
            let time = digits(&(0.02 * index as f64));
            format!("{time},{}\n", row.iter().map(digits).collect::<Vec<_>>().join(","))
        };
        let table: String = rows.iter().enumerate().map(line).collect();
        std::fs::write(&file, format!("time,{names}\n{table}")).unwrap();
    }
    let text = std::fs::read_to_string(&file).unwrap();
    let stored =
        text.lines().skip(1).map(|line| line.split(',').skip(1).map(|own| own.parse::<f64>().unwrap()).collect());
    let stored: Vec<Vec<f64>> = stored.collect();
    assert_eq!(stored.len(), rows.len());
    let mut run = started(&model(&scene_of("balancing_cart")), None, 4.0, 1e-12);
    let names = ["rail.s", "rail.v", "pole.angle", "pole.omega", "push", "tether.force", "events.release.time"];
    for (index, (row, stored)) in rows.iter().zip(&stored).enumerate() {
        if index > 0 {
            run.step_to(0.02 * index as f64).unwrap();
        }
        for ((name, expected), stored) in names.iter().zip(row).zip(stored) {
            let found = value(&mut run, name);
            let close = |other: f64| (other - expected).abs() < 1e-10 * (1.0 + expected.abs());
            assert!(
                close(found) && close(*stored),
                "{name} in row {index} is {found}, stored as {stored}, not {expected}"
            );
        }
    }
}

/// What has happened before a pose depends on the way there.
#[test]
fn figures_of_a_stroke_refuse_events() {
    let latch = LATCH.replace("[sampled.count]\nperiod = 1e3\noffset = 1e3\nvalues.n = 0\n", "");
    let latch = latch.replace("[events.passes]\nwhen = \"rail.v > 0.3\"\nset = { n = \"n + 1\" }\n", "");
    let latch = latch.replace("\"n\", ", "");
    let figures = |text: &str| {
        let request = MotionRequest {
            input: Some("rail".into()),
            range: Some([0.5, 1.0]),
            speed: Some(0.1),
            ..MotionRequest::default()
        };
        cotree_study::motion::study(&Scene::from_toml(text).unwrap(), &request)
    };
    let refused = figures(&latch).expect_err("an event").to_string();
    assert!(refused.contains("event `release`") && refused.contains("without `[events]`"), "{refused}");
    let (before, _) = latch.split_once("[events.release]").unwrap();
    let without = figures(&format!("{before}[initial]\n\"rail.s\" = 1.0"));
    assert!(without.is_ok(), "{without:?}");
}

/// The sine turns many times between any two places that a search evaluates.
#[test]
fn a_comparison_that_jumps_everywhere_is_refused_by_its_name() {
    let text = format!("{SERVO}\n[events.noise]\nwhen = \"sin(1e15*t) > 1.5\"\nset = {{ push = 0 }}\n");
    let mut instance = started(&model(&text), None, 1.0, 1e-10);
    instance.limit_work(20_000_000);
    let failure = instance.step_to(0.1).unwrap_err();
    assert!(failure.to_string().contains("`noise`"), "{failure}");
    let again = instance.step_to(0.1).unwrap_err();
    assert!(again.to_string().contains("`noise`"), "{again}");
}

/// Nothing accelerates an arm and a part, so that only the search for events limits steps: the 15 mm in which they meet are found whenever the run ends, and if it never does.
#[test]
fn a_motion_without_accelerations_is_searched_in_short_steps() {
    let model = model(&scene_of("gripper"));
    for stop in [Some(2.0), Some(1e3), Some(1e7), None] {
        for engine in [None, Some(Engine::Dop853), Some(Engine::Radau)] {
            let mut instance = Instance::new(model.clone());
            instance.setup(0.0, stop, Some(1e-9)).unwrap();
            engine.into_iter().for_each(|engine| instance.set_engine(engine).unwrap());
            instance.initialise().unwrap();
            instance.step_to(2.0).unwrap();
            let found = value(&mut instance, "part.x");
            assert!((found - 1.0879486232299613).abs() < 1e-8, "{found} with {engine:?} until {stop:?}");
        }
    }
}
