//! Methods that a scene names: what is steep, or switches, is felt by each of them.

use crate::support::hard::families::Family;
use crate::support::hard::{Case, Outcome, Points};
use crate::support::run;
use cotree_fmu::program::Engine;

fn member(family: &str, seed: u64) -> Case {
    (Family::named(family).member)(seed)
}

fn run(case: &Case, engine: Option<Engine>, tolerance: f64, step: f64) -> (String, Outcome) {
    let model = case.expect_model();
    let outcome = case.run(&model, engine, tolerance, Points::Every(step));
    (format!("{} at {tolerance:e}, {engine:?}: {outcome:?}", case.scene.name.text), outcome)
}

/// Members that were wrong without a word: all stages behind a switch, or one of the dense output in it, or next to a peak; ends in the faint outskirts of a layer.
#[test]
fn what_is_steep_is_felt_by_each_method() {
    use Engine::{Dop853, Radau};
    let members = [
        ("steep: stop", 20, Dop853, 1e-11, 0.000209),
        ("steep: stop", 42, Dop853, 1e-6, 0.00238),
        ("steep: stop", 42, Dop853, 1e-10, 0.1594),
        ("steep: stop", 118, Dop853, 1e-6, 0.010275947598493818),
        ("steep: train of bumps", 2, Dop853, 1e-4, 0.0992),
        ("steep: train of bumps", 44, Dop853, 1e-5, 0.0036),
        ("steep: train of bumps in position", 38, Dop853, 1e-7, 0.00204),
        ("steep: root that turns round", 59, Dop853, 1e-5, 0.17305303920657),
        ("steep: bump in position", 41, Radau, 1e-9, 0.15703081918029502),
        ("steep: if and min", 5, Radau, 1e-7, 0.000565),
        ("steep: if and min", 5, Radau, 1e-10, 0.01108),
        ("steep: if and min", 22, Radau, 1e-9, 0.00136),
        ("steep: if and min", 22, Radau, 1e-12, 0.9710412986629242),
    ];
    for (family, seed, engine, tolerance, step) in members {
        let (said, outcome) = run(&member(family, seed), Some(engine), tolerance, step);
        assert!(matches!(outcome, Outcome::Passed(_)), "{said}");
    }
}

/// 1/(1 + exp a) is zero, and so are its derivatives, where exp a is beyond all numbers.
#[test]
fn implicit_steps_go_where_an_exponential_has_no_number() {
    for seed in 0..12 {
        for tolerance in [1e-4, 1e-6, 1e-9, 1e-11] {
            let (said, outcome) = run(&member("steep: logistic", seed), Some(Engine::Radau), tolerance, 0.31);
            assert!(matches!(outcome, Outcome::Passed(_)), "{said}");
        }
    }
}

/// A torque jumps every two milliseconds, and a change point lies between two jumps, or just behind one: what series do not pass, the explicit method does from the jump on,
/// and nothing creeps up to a pose until rounding errors choose the branch.
#[test]
fn change_points_next_to_jumps_of_a_torque_are_passed_or_refused() {
    let passed = [(38, 1e-9), (44, 1e-9), (56, 1e-9), (44, 1e-8)];
    let judged = [(33, 1e-11), (70, 1e-10), (292, 1e-10)];
    for (seed, tolerance) in passed {
        let (said, outcome) = run(&member("torque that jumps every 2 ms", seed), None, tolerance, 0.157);
        assert!(matches!(outcome, Outcome::Passed(_)), "{said}");
    }
    for (seed, tolerance) in judged {
        for step in [0.015104120660071862, 0.07305583733517937, 0.4613840806122308] {
            let (said, outcome) = run(&member("torque that jumps every 2 ms", seed), None, tolerance, step);
            let refused = matches!(&outcome, Outcome::Failed(why) if why.contains("singular configuration"));
            assert!(refused || matches!(outcome, Outcome::Passed(_)), "{said}");
        }
    }
}

/// A thousand changes within implicit steps: each went on from a polynomial of a lower order than the steps, 20 000 tolerances off at 1e-12 after all of them.
#[test]
fn changes_within_implicit_steps_do_not_add_up_errors() {
    let case = member("torque that jumps every 2 ms", 6);
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
        let (said, outcome) = run(&case, Some(Engine::Radau), tolerance, 0.0006);
        assert!(matches!(outcome, Outcome::Passed(figures) if figures.error < 3.0 * tolerance), "{said}");
    }
}

/// Next to a change point a method that is named goes no further, whatever keeps its steps short there: jumps of a torque, the switch of a law, a loop far away. Before, rounding
/// errors chose the branch of some of these.
#[test]
fn named_methods_refuse_change_points_and_lose_no_branch() {
    let jumps = "torque that jumps every 2 ms";
    let members = [
        ("switch near a change point", [0, 2, 11, 13, 14, 18].as_slice()),
        ("loop far away", [2, 5, 33].as_slice()),
        (jumps, [0, 1, 3, 4, 9].as_slice()),
    ];
    let (mut passed, mut refused) = (0, 0);
    for (family, seeds) in members {
        let tolerances = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];
        let runs = seeds.iter().flat_map(|seed| tolerances.map(|tolerance| (seed, tolerance)));
        for ((&seed, tolerance), engine) in runs.flat_map(|run| [Engine::Dop853, Engine::Radau].map(|own| (run, own))) {
            let (said, outcome) = run(&member(family, seed), Some(engine), tolerance, 0.0131);
            match outcome {
                Outcome::Passed(_) => passed += 1,
                Outcome::Failed(why) if why.contains("and the scene names another method") => refused += 1,
                _ => panic!("{said}"),
            }
        }
    }
    assert!(refused > 60, "{passed} runs passed, {refused} were refused");
}

/// A block of 1 kg under dry friction of 2 N and this force.
fn block(force: &str, method: &str) -> Result<[f64; 2], String> {
    let scene = format!(
        r#"
format = 1
name = "block"
[bodies.block]
mass = 1.0
[joints.guide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[loads.push]
type = "force"
on = "block"
vector = ["{force} - 2*if(guide.v < 0, -1, 1)", 0]
[initial]
"guide.v" = 0.3
[solver]
method = "{method}"
"#
    );
    end(&scene, [3.0, 1e-8], ["guide.s", "guide.v"])
}

/// A block of 1 kg on a spring, whose friction of 5 N is written as a law of the load's own rate.
fn with_own_rate(method: &str) -> Result<[f64; 2], String> {
    let scene = run::block_with_law(
        "-5*sign(rate)",
        &format!("[initial]\n\"guide.s\" = 0.33\n[solver]\nmethod = \"{method}\"\n"),
    );
    end(&scene, [3.0, 1e-8], ["guide.s", "guide.v"])
}

/// It loses 0.1 m of amplitude per half period, and is stuck after the third, at 0.94 s: the law chatters from there on, and friction that sticks is named.
#[test]
fn a_law_of_the_own_rate_chatters_where_it_would_stick() {
    for method in ["auto", "explicit", "implicit"] {
        let why = with_own_rate(method).expect_err(method);
        let reason = why.contains("chatters, and `guide.s` with it") && why.contains("`friction` of a joint");
        assert!(reason && why.contains("t = 0.942"), "{method}: {why}");
    }
}

/// Variables of a scene at a time, by a tolerance.
fn end<const N: usize>(scene: &str, [time, tolerance]: [f64; 2], names: [&str; N]) -> Result<[f64; N], String> {
    let mut instance = run::started(&run::model(scene), None, time, tolerance);
    instance.step_to(time).map_err(|error| error.to_string())?;
    Ok(names.map(|name| run::value(&mut instance, name)))
}

/// Dry friction holds what a force of less than 2 N pushes: no step has an end then. Under 20 N it changes its sign and the motion goes on.
#[test]
fn a_law_that_pushes_to_and_fro_is_refused_by_each_method() {
    for method in ["auto", "explicit", "implicit"] {
        for force in ["0", "1.9*sin(5*t)", "1.5 - 80*guide.s"] {
            let why = block(force, method).expect_err(force);
            let reason = why.contains("chatters, and `guide.s` with it");
            assert!(reason, "{method}, {force}: {why}");
        }
        let [place, rate] = block("20*sin(5*t)", method).unwrap_or_else(|why| panic!("{method}: {why}"));
        let [other_place, other_rate] = block("20*sin(5*t)", "auto").expect("passed");
        let apart = (place - other_place).abs().max((rate - other_rate).abs());
        assert!(apart < 3e-7, "{method}: {place} {rate}, {other_place} {other_rate}");
    }
}

/// 0.02 x'' = -2 x - 0.2 tanh(x'/1e-4), with 1e5 s as the unit of time: rates of 1e-5 rad/s, in whose layer no step may count as still. x(1.5) = 0.0240285 by scipy's
/// Radau at 1e-11.
#[test]
fn what_is_slow_is_as_accurate_as_what_is_fast() {
    for (method, stop) in [("auto", 1.5e5), ("auto", 1.0), ("explicit", 1.5e5), ("implicit", 1.5e5)] {
        let scene = format!(
            r#"
format = 1
name = "slow"
[bodies.wheel]
mass = 1
inertia = 0.02
[joints.axle]
type = "revolute"
between = ["ground", "wheel"]
friction = {{ coulomb = 2e-11, velocity = 1e-9 }}
[loads.spring]
type = "torsion_spring"
between = ["ground", "wheel"]
stiffness = 2e-10
[initial]
"wheel.angle" = 1
[experiment]
stop = {stop}
[solver]
method = "{method}"
"#
        );
        for tolerance in [1e-3, 1e-5] {
            let [angle] = end(&scene, [1.5e5, tolerance], ["wheel.angle"]).unwrap_or_else(|why| panic!("{why}"));
            assert!((angle - 0.0240285).abs() < 100.0 * tolerance.min(1e-5), "{method}, {tolerance:e}: {angle}");
        }
    }
}
