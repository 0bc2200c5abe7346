//! Motion by the implicit method: against the other engines, closed forms and published numbers, and when the choice falls on it.

use crate::counting::allocations;
use crate::support::random::{Family, random_case};
use crate::support::run::{distance, file, model, models, motion, scene_of, started, value};
use cotree_fmu::machine::Machine;
use cotree_fmu::program::Engine;

/// Outputs at 10 s with a stiffness of 1e9 N/m, computed in quadruple precision in two formulations.
const REFERENCE: [(&str, f64); 4] = [
    ("crank.tip.x", -4.985_188_606_910_933_6e-1),
    ("crank.tip.y", -3.845_706_092_844_658e-2),
    ("slider.x", 7.008_647_536_978_751e-1),
    ("follower.x", 1.000_864_728_452_879_5),
];

fn stiff() -> String {
    file("benches/scenes/stiff_slider_crank.toml")
}

/// A mass on a rail with the force of van der Pol's oscillator.
fn van_der_pol(damping: f64) -> String {
    format!(
        r#"format = 1
name = "van_der_pol"
[parameters]
c = {{ value = {damping}, unit = "N.s/m" }}
k = {{ value = 1, unit = "N/m" }}
l = "1 m"
[bodies.m]
mass = 1
[joints.rail]
type = "prismatic"
between = ["ground", "m"]
axis = [1, 0]
[loads.law]
type = "force"
on = "m"
vector = ["c*(1 - (m.x/l)^2)*m.vx - k*m.x", 0]
[initial]
"m.x" = 2
"m.vx" = 0
[experiment]
stop = 300
tolerance = 1e-6
"#
    )
}

#[test]
fn the_models_and_random_mechanisms_move_as_with_the_explicit_method() {
    let mut scenes: Vec<(String, String, f64)> = Vec::new();
    for name in
        ["andrews", "bench_slider_crank", "cart_pole", "double_pendulum", "pendulum", "quick_return", "vibration"]
    {
        scenes.push((name.into(), scene_of(name), if name == "andrews" { 0.01 } else { 0.3 }));
    }
    for family in [Family::Chain, Family::Tree, Family::Loops, Family::Redundant] {
        for seed in 0..4 {
            scenes.push((format!("{family:?} {seed}"), random_case(seed, family).scene, 0.1));
        }
    }
    let mut compared = 0;
    for (name, text, stop) in scenes {
        let model = model(&text);
        if model.is_driven() {
            continue;
        }
        let run = |engine, tolerance| {
            let mut instance = started(&model, Some(engine), stop, tolerance);
            instance.step_to(stop).map(|()| motion(&instance)).unwrap_or_else(|error| panic!("{name}: {error}"))
        };
        let exact = run(Engine::Dop853, 1e-12);
        for tolerance in [1e-4, 1e-7] {
            let error = distance(&run(Engine::Radau, tolerance), &exact);
            assert!(error < 100.0 * tolerance, "{name} at {tolerance}: {error}");
        }
        compared += 1;
    }
    assert!(compared > 15, "{compared}");
}

/// At four random states, and along four directions, every kernel of the models has the bits that it has alone.
#[test]
fn kernels_at_four_points_have_the_bits_of_one_after_the_other() {
    let mut seed = 0_u32;
    let mut random = || {
        seed += 1;
        (f64::from(seed) * 12.9898).sin() * 3.0
    };
    let bits = |value: f64| if value.is_nan() { f64::NAN.to_bits() } else { value.to_bits() };
    let mut compared = 0;
    for name in models() {
        let model = model(&scene_of(&name));
        let (layout, tapes) = (model.layout(), &model.program().tapes);
        let mut machine = Machine::new(&model);
        machine.load(&model, &model.default_state(0.0));
        for tape in [&tapes.acceleration, &tapes.constraint, &tapes.gamma, &tapes.outputs] {
            let files: [Vec<f64>; 4] = std::array::from_fn(|_| {
                let mut file = machine.registers().to_vec();
                file[layout.positions()..layout.constants()].fill_with(&mut random);
                file
            });
            let lanes: Vec<[f64; 4]> = (0..files[0].len()).map(|i| std::array::from_fn(|k| files[k][i])).collect();
            let mut directions = vec![[0.0; 4]; lanes.len()];
            directions[layout.positions()..layout.constants()].fill_with(|| std::array::from_fn(|_| random()));
            let (mut points, mut tangents, mut point) = (lanes.clone(), directions.clone(), files[0].clone());
            tape.run_lanes(&mut points);
            tape.run_tangents(&mut point, &mut tangents);
            for (k, file) in files.iter().enumerate() {
                let (mut alone, mut first) = (file.clone(), files[0].clone());
                let mut along: Vec<f64> = directions.iter().map(|lane| lane[k]).collect();
                tape.run(&mut alone);
                tape.run_tangent(&mut first, &mut along);
                let same =
                    |lanes: &[[f64; 4]], alone: &[f64]| lanes.iter().zip(alone).all(|(a, b)| bits(a[k]) == bits(*b));
                assert!(same(&points, &alone) && same(&tangents, &along), "{name}");
            }
            compared += tape.instructions().len();
        }
    }
    assert!(compared > 1000, "{compared}");
}

#[test]
fn the_stiff_slider_crank_ends_where_quadruple_precision_puts_it() {
    let model = model(&stiff());
    for engine in [None, Some(Engine::Radau)] {
        let mut instance = started(&model, engine, 10.0, 1e-6);
        instance.step_to(10.0).expect("regular");
        for (name, expected) in REFERENCE {
            let error = (value(&mut instance, name) - expected).abs();
            assert!(error < 1e-6, "{engine:?} {name}: {error}");
        }
        let work = instance.statistics();
        // Series would need 69 000 steps.
        assert!(work.steps < 7_500 && work.evaluations < 150_000 && work.jacobians > 1000, "{work:?}");
    }
}

#[test]
fn forces_of_stiff_springs_are_right_between_the_steps() {
    let model = model(&stiff());
    let [mut implicit, mut series] = [(Engine::Radau, 1e-8), (Engine::Taylor, 1e-10)]
        .map(|(engine, tolerance)| started(&model, Some(engine), 0.3, tolerance));
    let mut largest: f64 = 0.0;
    for point in 1..=300 {
        let time = f64::from(point) * 1e-3;
        implicit.step_to(time).expect("regular");
        series.step_to(time).expect("regular");
        let [found, expected] = [&mut implicit, &mut series].map(|instance| value(instance, "coupling.force"));
        assert!((found - expected).abs() < 0.05, "{time}: {found} instead of {expected}");
        largest = largest.max(expected.abs());
    }
    assert!(largest > 20.0 && implicit.statistics().steps < 3000, "{largest} {:?}", implicit.statistics());
}

#[test]
fn only_stiff_motion_changes_the_engine() {
    let run = |text: &str, stop: f64, tolerance: f64| {
        let model = model(text);
        let mut instance = started(&model, None, stop, tolerance);
        instance.step_to(stop).expect("regular");
        instance.statistics()
    };
    assert!(run(&stiff(), 1.0, 1e-6).jacobians > 100);
    // Without a damper the spring's vibration is part of the motion: series stay.
    let undamped = stiff().replace("value = 1e9", "value = 1e7").replace("\"2*sqrt(stiffness*0.375)\"", "0");
    assert_eq!(run(&undamped, 1.0, 1e-8).factorisations, 0);
    for name in ["bench_slider_crank", "double_pendulum", "vibration", "andrews"] {
        let stop = if name == "andrews" { 0.03 } else { 5.0 };
        assert_eq!(run(&scene_of(name), stop, 1e-8).factorisations, 0, "{name}");
    }
}

/// Oil holds the steps of series back, but implicit ones are shorter still: the trial of them ends. It went on from 1e-4 to 1e-7, with three to seven times as many steps.
#[test]
fn implicit_steps_that_are_no_longer_are_given_up() {
    let lever = model(&scene_of("hydraulic_lever"));
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
        let [auto, series] = [None, Some(Engine::Taylor)].map(|engine| {
            let mut instance = started(&lever, engine, 1.5, tolerance);
            instance.step_to(1.5).unwrap();
            let statistics = instance.statistics();
            (statistics.steps, statistics.factorisations)
        });
        assert!(auto.1 > 0 && auto.1 < 20, "{tolerance:e}: there was no trial, or a long one: {auto:?}");
        assert!(auto.0 < series.0 + 20, "{tolerance:e}: {auto:?} steps, {series:?} by series");
    }
}

/// Two masses on a rail: one on a soft spring, the other coupled to it by this law (its stretch is d, its rate w).
fn coupled(law: &str) -> String {
    let law = law.replace('d', "(b.x-a.x-l)").replace('w', "(b.vx-a.vx)");
    let body = |name: &str, mass: f64, load: &str| {
        format!(
            "[bodies.{name}]\nmass={mass}\n[joints.rail_{name}]\ntype=\"prismatic\"\nbetween=[\"ground\", \"{name}\"]\naxis=[1, 0]\n\
             [loads.on_{name}]\ntype=\"force\"\non=\"{name}\"\nvector=[\"{load}\", 0]\n"
        )
    };
    format!(
        "format=1\nname=\"coupled\"\n[parameters]\nl=\"1 m\"\nk=\"100 N/m\"\n{}{}[initial]\n\"a.x\"=0.3\n\"b.x\"=1.35\n\"a.vx\"=0\n\"b.vx\"=0.1\n\
         [experiment]\nstop=5\ntolerance=1e-6\n",
        body("a", 1.0, &format!("{law} - k*a.x")),
        body("b", 0.5, &format!("-({law})")),
    )
}

/// A stiff spring behind a soft start, and a damper that hardly lets anything move.
#[test]
fn motion_that_becomes_stiff_and_motion_that_is_from_the_start_meet_the_tolerance() {
    let soft_start = coupled("d*(100 + 1e7/(1 + exp(-20*(t-1)))) + w*(1 + 4000/(1 + exp(-20*(t-1))))");
    let damper = coupled("1e5*w");
    for (text, reference) in [(soft_start, Engine::Dop853), (damper, Engine::Radau)] {
        let model = model(&text);
        let run = |engine, tolerance| {
            let mut instance = started(&model, engine, 5.0, tolerance);
            let mut motions = Vec::new();
            for point in 1..=50 {
                instance.step_to(0.1 * f64::from(point)).expect("regular");
                motions.push(motion(&instance));
            }
            (motions, instance.statistics())
        };
        let (exact, _) = run(Some(reference), 1e-11);
        for tolerance in [1e-3, 1e-4, 1e-6, 1e-8] {
            let (chosen, work) = run(None, tolerance);
            let worst = chosen.iter().zip(&exact).map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
            assert!(worst < 5.0 * tolerance, "{tolerance:e}: {worst:e}");
            assert!(work.jacobians > 0 && work.evaluations < 10_000, "{tolerance:e}: {work:?}");
        }
    }
}

#[test]
fn relaxation_oscillations_take_few_steps() {
    let model = model(&van_der_pol(100.0));
    let run = |engine, tolerance| {
        let mut instance = started(&model, engine, 300.0, tolerance);
        instance.step_to(300.0).expect("regular");
        (motion(&instance), instance.statistics())
    };
    let (exact, many) = run(Some(Engine::Dop853), 1e-9);
    let (implicit, few) = run(Some(Engine::Radau), 1e-6);
    let (chosen, work) = run(None, 1e-6);
    assert!(
        distance(&implicit, &exact) < 1e-4 && distance(&chosen, &exact) < 1e-4,
        "{exact:?} {implicit:?} {chosen:?}"
    );
    assert!(few.evaluations * 10 < many.evaluations, "{few:?} {many:?}");
    assert!(work.jacobians > 0 && work.evaluations * 5 < many.evaluations, "{work:?} {many:?}");
}

#[test]
fn saved_states_go_on_bit_for_bit_and_communication_points_do_not_matter() {
    let model = model(&stiff());
    for engine in [None, Some(Engine::Radau)] {
        let mut instance = started(&model, engine, 1.0, 1e-6);
        let (mut saved, mut ends) = (instance.save(), Vec::new());
        for point in 1..=100 {
            instance.step_to(f64::from(point) * 0.01).expect("regular");
            if point == 37 {
                saved = instance.save();
            }
        }
        ends.push(motion(&instance));
        let mut other = started(&model, engine, 1.0, 1e-6);
        other.restore(&saved).expect("own state");
        for point in 38..=100 {
            other.step_to(f64::from(point) * 0.01).expect("regular");
        }
        assert_eq!(
            motion(&other).iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
            ends[0].iter().map(|x| x.to_bits()).collect::<Vec<_>>()
        );
        let mut once = started(&model, engine, 1.0, 1e-6);
        once.step_to(1.0).expect("regular");
        assert!(distance(&motion(&once), &ends[0]) < 1e-6);
        assert_eq!(once.statistics().steps, instance.statistics().steps);
    }
}

#[test]
fn nothing_allocates_while_stepping() {
    let model = model(&stiff());
    for engine in [None, Some(Engine::Radau)] {
        let mut instance = started(&model, engine, 1.0, 1e-6);
        let before = allocations();
        for point in 1..=50 {
            instance.step_to(f64::from(point) * 0.01).expect("regular");
        }
        assert_eq!(allocations(), before);
        assert!(instance.statistics().jacobians > 0);
    }
}

#[test]
fn a_scene_may_ask_for_the_implicit_method() {
    let model = model(&(stiff() + "[solver]\nmethod = \"implicit\"\n"));
    assert_eq!((model.program().engine, model.program().automatic), (Engine::Radau, false));
}
