//! Motion by Taylor series: against the models' expected motion, the explicit method, itself at other communication points, and the energy.

use crate::support::run;

use std::sync::Arc;

use crate::counting::allocations;
use cotree_fmu::instance::{Instance, Snapshot};
use cotree_fmu::model::Model;
use cotree_fmu::program::arm_form::{ArmForm, Given};
use cotree_fmu::program::{Engine, Program};
use run::{compiled, distance, file, model, models, motion, scene_of, started};

#[test]
fn every_dynamic_model_moves_as_expected() {
    let mut moved = Vec::new();
    for name in models() {
        let program = compiled(&scene_of(&name)).program;
        // Series know nothing of friction that sticks and of ropes over pulleys: tests/dry_friction.rs, tests/barrier.rs and tests/gallery.rs have these models. What is expected of the valve train is known to 2e-9:
        // tests/lifting_cams.rs has it.
        if program.is_driven()
            || ["barrier", "chain_hoist", "clutch_start", "stick_slip", "valve_train", "worm_hoist"]
                .contains(&name.as_str())
        {
            continue;
        }
        assert_eq!(program.engine, Engine::Taylor, "{name}");
        let text = file(&format!("models/{name}/expected.csv"));
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().expect("a header").split(',').skip(1).collect();
        let rows: Vec<Vec<f64>> =
            lines.map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
        let model = Arc::new(Model::new(program).expect("a sound program"));
        let mut instance = started(&model, Some(Engine::Taylor), rows.last().expect("rows")[0], 1e-13);
        let variables: Vec<usize> = names.iter().map(|name| instance.variable(name).expect("an output")).collect();
        for row in &rows {
            if row[0] > instance.time() {
                instance.step_to(row[0]).expect("regular");
            }
            for (column, &variable) in variables.iter().enumerate() {
                let size = rows.iter().fold(1.0, |size: f64, row| size.max(row[column + 1].abs()));
                let error = (instance.get(variable).expect("defined") - row[column + 1]).abs() / size;
                assert!(error < 1e-9, "{name} {} at {}: {error}", names[column], row[0]);
            }
        }
        assert_eq!(instance.statistics().fallbacks, 0, "{name}");
        moved.push(name);
    }
    assert!(moved.len() >= 7, "{moved:?}");
}

#[test]
fn results_do_not_depend_on_the_communication_step() {
    for name in ["bench_slider_crank", "andrews", "cart_pole", "vibration"] {
        let model = model(&scene_of(name));
        let stop = 0.2 * model.program().experiment.stop;
        let run = |points: u32| {
            let mut instance = started(&model, Some(Engine::Taylor), stop, 1e-9);
            (1..=points).for_each(|k| instance.step_to(stop * f64::from(k) / f64::from(points)).expect("regular"));
            (motion(&instance), instance.statistics().steps)
        };
        let (once, steps) = run(1);
        for points in [7, 1000] {
            let (often, others) = run(points);
            assert_eq!(others, steps, "{name}: communication points cost no steps");
            assert!(distance(&often, &once) == 0.0, "{name} at {points}: {}", distance(&often, &once));
        }
    }
}

#[test]
fn both_engines_agree_and_the_error_follows_the_tolerance() {
    for name in ["slider_crank", "andrews", "double_pendulum", "pendulum", "cart_pole", "vibration"] {
        let model = model(&scene_of(name));
        let stop = 0.3 * model.program().experiment.stop;
        let run = |engine, tolerance| {
            let mut instance = started(&model, Some(engine), stop, tolerance);
            instance.step_to(stop).expect("regular");
            motion(&instance)
        };
        let reference = run(Engine::Dop853, 1e-13);
        for tolerance in [1e-5, 1e-8, 1e-11] {
            let error = distance(&run(Engine::Taylor, tolerance), &reference);
            assert!(error < 2e3 * tolerance, "{name} at {tolerance}: {error}");
        }
    }
}

#[test]
fn a_changing_input_acts_alike_in_both_engines() {
    let model = Arc::new(Model::new(compiled(&scene_of("cart_pole")).program).expect("a sound program"));
    let run = |engine| {
        let mut instance = started(&model, Some(engine), 1.0, 1e-11);
        let input = instance
            .model()
            .program()
            .variables
            .iter()
            .position(|variable| matches!(variable.source, cotree_fmu::program::Source::Input(_)));
        let input = input.expect("the force is an input");
        for step in 1..=100_u32 {
            instance.set(input, f64::from(step % 7) - 3.0).expect("an input");
            instance.set_derivative(input, 1, 2.0).expect("an input");
            instance.step_to(0.01 * f64::from(step)).expect("regular");
        }
        (motion(&instance), instance.statistics().steps)
    };
    let ((series, steps), (explicit, _)) = (run(Engine::Taylor), run(Engine::Dop853));
    assert!(distance(&series, &explicit) < 1e-9, "{}", distance(&series, &explicit));
    // The first change is followed by a step of natural length, which the second one cuts.
    assert!(steps <= 102, "{steps} steps for 100 changes");
}

#[test]
fn energy_is_kept() {
    let text = scene_of("double_pendulum");
    let model = model(&text);
    let mut instance = started(&model, Some(Engine::Taylor), 50.0, 1e-11);
    let energy = instance.variable("energy.total").expect("an output");
    let before = instance.get(energy).expect("defined");
    for step in 1..=100 {
        instance.step_to(0.5 * f64::from(step)).expect("regular");
        let drift = instance.get(energy).expect("defined") - before;
        assert!(drift.abs() < 1e-8 * before.abs().max(1.0), "{drift} at {}", instance.time());
    }
}

#[test]
fn a_saved_run_goes_on_with_the_same_bits() {
    let model = Arc::new(Model::new(compiled(&scene_of("bench_slider_crank")).program).expect("a sound program"));
    let mut instance = started(&model, Some(Engine::Taylor), 2.0, 1e-8);
    instance.step_to(0.7).expect("regular");
    let snapshot = instance.save();
    instance.step_to(1.9).expect("regular");
    let once = motion(&instance);
    instance.restore(&snapshot).expect("own state");
    instance.step_to(1.9).expect("regular");
    assert_eq!(motion(&instance), once);
}

/// Driven, sliding on a turning axis, with laws of every kind: a pendulum on a slide whose axis a driver turns.
const LAWS: &str = r#"
format = 1
name = "laws"
[parameters]
k = { value = 30, tunable = true }
[bodies.beam]
mass = 1
inertia = 0.1
points = { end = [0.5, 0] }
[bodies.block]
mass = 0.5
inertia = 0.02
points = { eye = [0, -0.1] }
[bodies.bob]
mass = 0.3
inertia = 0.01
points = { top = [0, 0.4] }
[joints.pivot]
type = "revolute"
between = ["ground", "beam"]
[joints.slide]
type = "prismatic"
between = ["beam", "block"]
axis = [1, 0]
damping = 0.3
[joints.eye]
type = "revolute"
between = ["block.eye", "bob.top"]
damping = 0.05
[drivers.turn]
joint = "pivot"
angle = "0.2 + 0.5*sin(2*t) + 0.1*t^2"
[loads.pull]
type = "actuator"
between = ["ground", "block"]
force = "-k*(length - 0.3) - 0.5*tanh(3*rate) + exp(-t)"
[loads.turner]
type = "torque"
on = "bob"
value = "0.1*atan(1.5*bob.omega) - 0.2*sin(bob.angle)^3 + 0.05*sqrt(1 + bob.omega^2)*cos(3*t)/(2 + cos(bob.angle))"
[loads.drag]
type = "force"
on = "bob"
frame = "body"
vector = ["-0.2*bob.vx", "0.1*log(2 + 3*bob.y^2)"]
[initial]
"slide.s" = 0.4
"slide.v" = 0.1
"bob.angle" = 0.3
"bob.omega" = 1
[experiment]
stop = 3
"#;

#[test]
fn laws_drivers_and_slides_move_alike_in_both_engines() {
    for coordinates in ["recommended", "absolute", "joint"] {
        let text = LAWS.replace("[parameters]", &format!("[coordinates]\npreset = \"{coordinates}\"\n[parameters]"));
        let model = model(&text);
        assert_eq!(model.program().engine, Engine::Taylor, "{coordinates}");
        let run = |engine| {
            let mut instance = started(&model, Some(engine), 3.0, 1e-11);
            instance.step_to(1.0).expect("regular");
            let k = instance.variable("k").expect("a parameter");
            instance.set(k, 50.0).expect("tunable");
            instance.step_to(3.0).expect("regular");
            (motion(&instance), instance.statistics().fallbacks)
        };
        let ((series, fallbacks), (explicit, _)) = (run(Engine::Taylor), run(Engine::Dop853));
        assert!(distance(&series, &explicit) < 1e-8, "{coordinates}: {}", distance(&series, &explicit));
        assert_eq!(fallbacks, 0, "{coordinates}");
    }
}

/// Laws in pieces: corners in positions and rates, jumps in rates and in time, conditions with `if` in one another.
#[test]
fn laws_in_pieces_move_alike_in_both_engines() {
    let laws = [
        "0.1*abs(bob.omega)",
        "-0.3*max(0, bob.angle - 0.1) - 0.02*min(max(bob.omega, -0.05), 0.4)",
        "if(bob.omega > 0, 0.05, -0.03)",
        "if(t < 0.7, 0.1, if(bob.angle > 0, -0.1, 0.2*t))",
        "0.05*sign(bob.angle) + 0.1*abs(bob.omega - 0.2)",
        "if(bob.angle > 0, if(bob.omega > 0, 0.05, -0.1), 0)",
    ];
    for law in laws {
        let model = model(&LAWS.replace("0.1*atan(1.5*bob.omega)", law));
        assert_eq!(model.program().engine, Engine::Taylor, "{law}");
        let run = |engine, tolerance| {
            let mut instance = started(&model, Some(engine), 3.0, tolerance);
            instance.step_to(3.0).expect("regular");
            (motion(&instance), instance.statistics())
        };
        let (explicit, _) = run(Engine::Dop853, 1e-11);
        for tolerance in [1e-5, 1e-8, 1e-11] {
            let (series, statistics) = run(Engine::Taylor, tolerance);
            let error = distance(&series, &explicit);
            assert!(error < f64::max(30.0 * tolerance, 1e-8), "{law} at {tolerance}: {error}");
            assert_eq!(statistics.fallbacks, 0, "{law}: {statistics:?}");
        }
    }
}

/// Dry friction written as a law that jumps, where the motion comes to rest: nothing follows it, and that is said at once. The block slows
/// down in half swings about 0.2 and -0.2: 1.3, -0.9, 0.5, -0.1, where the spring cannot move it any more.
#[test]
fn a_law_that_jumps_forth_and_back_is_named() {
    let text = "format = 1\nname = \"dry\"\n[bodies.block]\nmass = 1\ninertia = 1\n\
        [joints.way]\ntype = \"prismatic\"\nbetween = [\"ground\", \"block\"]\naxis = [1, 0]\n\
        [loads.dry]\ntype = \"force\"\non = \"block\"\nvector = [\"-10*block.x - 2*sign(block.vx)\", \"0\"]\n\
        [initial]\n\"block.x\" = 1.3\n[experiment]\nstop = 5\n";
    let model = model(text);
    assert_eq!(model.program().engine, Engine::Taylor);
    let mut instance = started(&model, Some(Engine::Taylor), 5.0, 1e-8);
    let rest = 3.0 * std::f64::consts::PI / 10.0_f64.sqrt();
    instance.step_to(rest - 1e-6).expect("it still moves");
    let [x, v] = motion(&instance)[..] else { panic!("one coordinate") };
    assert!((x + 0.1).abs() < 1e-7 && v.abs() < 1e-4, "{x} {v}");
    let failure = instance.step_to(5.0).expect_err("it cannot go on").to_string();
    assert!(failure.contains("`way.s`") && failure.contains("chatters"), "{failure}");
    assert!(instance.statistics().evaluations < 1000, "{:?}", instance.statistics());
}

fn block(way: &str, law: &str, start: f64) -> String {
    let [x, y] = if way == "x" { [law, "0"] } else { ["0", law] };
    let axis = if way == "x" { "[1, 0]" } else { "[0, 1]" };
    format!(
        "format = 1\nname = \"block\"\ngravity = [0, -9.81]\n[bodies.block]\nmass = 1\ninertia = 1\n\
        [joints.way]\ntype = \"prismatic\"\nbetween = [\"ground\", \"block\"]\naxis = {axis}\n\
        [loads.law]\ntype = \"force\"\non = \"block\"\nvector = [\"{x}\", \"{y}\"]\n\
        [initial]\n\"block.{way}\" = {start}\n[experiment]\nstop = 3\n"
    )
}

/// The end of a run to many communication points, by series and step by step.
fn by_both(text: &str) -> [Vec<f64>; 2] {
    let model = model(text);
    assert_eq!(model.program().engine, Engine::Taylor);
    [(Engine::Taylor, 1e-8), (Engine::Dop853, 1e-10)].map(|(engine, tolerance)| {
        let mut instance = started(&model, Some(engine), 3.0, tolerance);
        (1..=300).for_each(|point| instance.step_to(0.01 * f64::from(point)).expect("regular"));
        motion(&instance)
    })
}

/// The coefficients of tanh(v/1e-3) tell nothing of the turn where v is large: short steps, too, must look at their end.
#[test]
fn a_steep_law_is_not_stepped_over() {
    let [series, explicit] = by_both(&block("x", "30*sin(3*t) - 10*tanh(block.vx/1e-3)", 0.0));
    assert!(distance(&series, &explicit) < 1e-6, "{series:?} {explicit:?}");
}

/// Two pieces end where the mass leaves the ground, and the rounding errors of one make the other go there and back.
#[test]
fn pieces_that_end_together_are_left_together() {
    let damped = "max(0, -1e7*block.y - 6000*block.vy*max(0, min(1, -block.y/1e-5)))";
    for start in [0.1, 0.07, 0.123] {
        let [series, explicit] = by_both(&block("y", damped, start));
        assert!(distance(&series, &explicit) < 1e-6, "{start}: {series:?} {explicit:?}");
    }
}

/// A mass that bounces on a one-sided spring: v = 0 at the top again and again, energy is kept.
#[test]
fn a_bouncing_mass_keeps_its_height() {
    let text = "format = 1\nname = \"ball\"\ngravity = [0, -10]\n[bodies.ball]\nmass = 1\ninertia = 1\n\
        [joints.way]\ntype = \"prismatic\"\nbetween = [\"ground\", \"ball\"]\naxis = [0, 1]\n\
        [loads.mat]\ntype = \"force\"\non = \"ball\"\nvector = [\"0\", \"1e4*max(0, -ball.y)\"]\n\
        [initial]\n\"ball.y\" = 0.8\n[experiment]\nstop = 20\n";
    let model = model(text);
    assert_eq!(model.program().engine, Engine::Taylor);
    let mut instance = started(&model, Some(Engine::Taylor), 20.0, 1e-10);
    instance.step_to(20.0).expect("regular");
    // Free flight sqrt(2 h/g) each way; below, half a swing about the sagged point.
    let (g, k, h) = (10.0, 1e4_f64, 0.8);
    let (omega, sag) = (k.sqrt(), g / k);
    let speed = (2.0_f64 * g * h).sqrt();
    let amplitude = (sag * sag + speed * speed / k).sqrt();
    let contact = (std::f64::consts::PI + 2.0 * (sag / amplitude).asin()) / omega;
    let period = 2.0 * speed / g + contact;
    // Time since the last top.
    let phase = 20.0_f64 % period;
    let down = phase.min(period - phase);
    assert!(down < speed / g, "the test looks at free flight");
    let expected = h - 0.5 * g * down * down;
    let height = motion(&instance)[0];
    assert!((height - expected).abs() < 1e-8, "{height} instead of {expected}: {:?}", instance.statistics());
    assert_eq!(instance.statistics().fallbacks, 0);
}

/// A force that grows by 1 N every half second: x'' = n while n/2 <= t < (n + 1)/2.
#[test]
fn a_law_with_steps_is_followed_from_step_to_step() {
    let text = "format = 1\ndimension = 1\nname = \"stairs\"\n[bodies.block]\nmass = 1\n\
        [loads.push]\ntype = \"force\"\non = \"block\"\nvector = [\"floor(2*t)\"]\n\
        [initial]\n\"block.x\" = 0\n\"block.vx\" = 0\n[experiment]\nstop = 5.25\n";
    let model = model(text);
    assert_eq!(model.program().engine, Engine::Taylor);
    let mut instance = started(&model, Some(Engine::Taylor), 5.25, 1e-10);
    instance.step_to(5.25).expect("regular");
    let (mut x, mut v) = (0.0, 0.0);
    for n in 0..=10 {
        let (a, h) = (f64::from(n), if n < 10 { 0.5 } else { 0.25 });
        x += h * (v + 0.5 * h * a);
        v += h * a;
    }
    assert!(distance(&motion(&instance), &[x, v]) < 1e-12, "{:?} {x} {v}", motion(&instance));
}

#[test]
fn steps_that_go_up_and_down_are_those_of_the_explicit_method() {
    let text = LAWS.replace("0.1*atan(1.5*bob.omega)", "0.1*floor(3*bob.angle)");
    let model = model(&text);
    assert_eq!(model.program().engine, Engine::Taylor);
    let run = |engine, tolerance| {
        let mut instance = started(&model, Some(engine), 1.0, tolerance);
        instance.step_to(1.0).expect("regular");
        motion(&instance)
    };
    let (series, explicit) = (run(Engine::Taylor, 1e-10), run(Engine::Dop853, 1e-11));
    assert!(distance(&series, &explicit) < 1e-6, "{}", distance(&series, &explicit));
}

/// sqrt(v^2 + v^2 sin^2) has no series where v = 0, which is where the motion begins.
#[test]
fn a_state_without_a_series_is_left_by_the_explicit_method() {
    let text = LAWS
        .replace("sqrt(1 + bob.omega^2)", "sqrt(bob.omega^2 + bob.omega^2*sin(bob.angle)^2)")
        .replace("\"bob.omega\" = 1", "\"bob.omega\" = 0");
    let model = model(&text);
    let run = |engine| {
        let mut instance = started(&model, Some(engine), 0.2, 1e-10);
        instance.step_to(1e-6).unwrap_or_else(|error| panic!("{engine:?}: {error}"));
        // Nothing of the series that there is not stays behind.
        let saved = instance.save().to_bytes().expect("a state");
        assert!(Snapshot::from_bytes(&model, &saved).is_ok(), "{engine:?}");
        instance.step_to(0.2).unwrap_or_else(|error| panic!("{engine:?}: {error}"));
        (motion(&instance), instance.statistics())
    };
    let ((series, statistics), (explicit, _)) = (run(Engine::Taylor), run(Engine::Dop853));
    assert!(statistics.fallbacks >= 1 && statistics.steps > statistics.fallbacks, "{statistics:?}");
    assert!(distance(&series, &explicit) < 1e-8, "{}", distance(&series, &explicit));
}

#[test]
fn stepping_does_not_allocate() {
    let model = model(LAWS);
    let mut instance = started(&model, Some(Engine::Taylor), 1.0, 1e-8);
    let before = allocations();
    (1..=100).for_each(|step| instance.step_to(0.01 * f64::from(step)).expect("regular"));
    assert_eq!(allocations(), before);
}

/// The series of a thrown body ends at order 2, and there may be no stop time.
#[test]
fn a_motion_whose_series_ends_is_exact() {
    let text = "format = 1\nname = \"thrown\"\ngravity = [0, -10]\n[bodies.stone]\nmass = 1\ninertia = 1\n\
        [initial]\n\"stone.vx\" = 3\n\"stone.vy\" = 20\n\"stone.omega\" = 0.5\n[experiment]\nstop = 4\n";
    let model = model(text);
    let mut instance = Instance::new(model.clone());
    instance.setup(0.0, None, None).expect("no stop time");
    instance.initialise().expect("consistent");
    for time in [0.5, 4.0, 1000.0] {
        instance.step_to(time).expect("regular");
        let read = |instance: &mut Instance, name| {
            let variable = instance.variable(name).expect("a variable");
            instance.get(variable).expect("defined")
        };
        for (name, expected) in [("stone.x", 3.0 * time), ("stone.y", 20.0 * time - 5.0 * time * time)] {
            let found = read(&mut instance, name);
            assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{name} at {time}: {found}");
        }
        let snapshot = instance.save();
        instance.restore(&snapshot).expect("what is saved can be restored");
    }
    assert_eq!((instance.statistics().fallbacks, instance.statistics().rejected), (0, 0));
}

/// Ways to damage an arm form.
type Damage = fn(&mut ArmForm);

#[test]
fn a_damaged_arm_form_is_refused() {
    let sound = compiled(LAWS).program;
    assert_eq!(sound.check(), Ok(()));
    let damages: [Damage; 14] = [
        |form| form.coordinates.truncate(1),
        |form| form.coordinates[0] = form.coordinates[1],
        |form| form.frames[0].inertia = 10_000,
        |form| form.frames[1].unknown = Some(7),
        |form| form.products[0].frame = 99,
        |form| form.coupling[0].from = 99,
        |form| form.loads[0].arm = 99,
        |form| form.pushes[0].unknown = 99,
        |form| form.tape.slots += 1000,
        |form| form.tape.given[0].1 = Given::Input(99, 0),
        |form| form.tape.given[0].1 = Given::Follower(99, 1),
        |form| form.tape.signals.reverse(),
        |form| form.tape.terms.clear(),
        |form| form.coefficients.results.clear(),
    ];
    let is_refused = |program: &Program| {
        program.check().is_err_and(|error| error.to_string().starts_with("the arm form is damaged: "))
    };
    for (index, damage) in damages.into_iter().enumerate() {
        let mut damaged = sound.clone();
        damage(damaged.arms.as_mut().expect("an arm form"));
        assert!(is_refused(&damaged), "damage {index}: {:?}", damaged.check());
    }
    assert!(is_refused(&Program { arms: None, ..sound }));
}
