//! Levels of brakes and clutches that follow states, sampled values and the motion, by every method, against closed forms.

use crate::support::one_freedom_with_friction::Moving;
use crate::support::run;
use cotree::scene::Scene;
use cotree_fmu::math::Random;
use cotree_fmu::program::Engine;

const ENGINES: [Option<Engine>; 3] = [None, Some(Engine::Dop853), Some(Engine::Radau)];

/// A wheel of inertia 2 on a bearing, with a brake of this level and with more tables.
pub fn wheel(level: &str, more: &str) -> String {
    format!(
        r#"
name = "braked"
[bodies.wheel]
mass = 1
inertia = 2
[joints]
axle = {{ type = "revolute", between = ["ground", "wheel"] }}
brake = {{ type = "brake", between = ["ground", "wheel"], level = "{level}" }}
[experiment]
stop = "2 s"
{more}"#
    )
}

/// Values at these times, by each method.
fn check(text: &str, name: &str, times: &[f64], exact: impl Fn(f64) -> f64) {
    let model = run::model(text);
    for engine in ENGINES {
        let mut instance = run::started(&model, engine, 2.0, 1e-9);
        for &time in times {
            instance.step_to(time).unwrap();
            let (found, right) = (run::value(&mut instance, name), exact(time));
            assert!((found - right).abs() < 1e-7, "{name} at {time} by {engine:?}: {found}, not {right}");
        }
    }
}

/// A pressure that rises with time, p' = 1: 2 w' = -4 p, so w = 1 - t^2 until 1 s; then the wheel stands.
#[test]
fn a_state_presses_the_brake() {
    let more = "[states]\np = { start = 0, rate = \"1[1/s]\" }\n[initial]\n\"wheel.omega\" = 1";
    check(&wheel("4[N.m]*p", more), "wheel.omega", &[0.3, 0.9, 1.2, 2.0], |t: f64| (1.0 - t * t).max(0.0));
}

/// It holds 3 N.m until the controller opens it, at the tick at 0.9 s.
#[test]
fn a_sampled_value_opens_the_brake_at_its_tick() {
    let more = "[sampled.controller]\nperiod = \"0.3 s\"\nvalues = { on = { start = 1, next = \"if(t > 0.8, 0, 1)\" } }\n\
                [loads.pull]\ntype = \"torque\"\non = \"wheel\"\nvalue = \"3 N.m\"";
    check(&wheel("5[N.m]*on", more), "wheel.omega", &[0.5, 0.95, 1.5, 2.0], |t| 1.5 * (t - 0.9).max(0.0));
}

/// A level that grows with the speed, 2 w' = -(1 + 4 w): w = (w0 + 1/4) exp(-2 t) - 1/4 until rest, at ln(1 + 4 w0)/2.
#[test]
fn the_motion_sets_the_level() {
    let more = "[initial]\n\"wheel.omega\" = 3";
    let exact = |t: f64| (3.25 * (-2.0 * t).exp() - 0.25).max(0.0);
    check(&wheel("1[N.m] + 4[N.m.s]*abs(wheel.omega)", more), "wheel.omega", &[0.4, 1.2, 1.5], exact);
}

/// A level that switches with the position: 2 N.m from half a turn on. 2 w' = 0, then w w' = -1 per radian: it stops at pi + w0^2/2.
#[test]
fn a_level_jumps_where_its_law_does() {
    let more = "[initial]\n\"wheel.omega\" = 4";
    let text = wheel("if(wheel.angle < pi, 0, 2)", more);
    let begins = std::f64::consts::PI / 4.0;
    let exact = |t: f64| 4.0 - (t - begins).max(0.0);
    check(&text, "wheel.omega", &[0.5, 0.8, 1.5, 2.0], exact);
}

/// What the level itself decides, it may not read.
#[test]
fn accelerations_and_forces_are_refused() {
    for law in ["5[N.s2]*wheel.alpha", "brake.torque", "axle.fx*1[m]"] {
        let text = wheel(law, "");
        let refused = Scene::from_toml(&text).and_then(|scene| cotree::compile::compile(&scene));
        let faults = refused.err().unwrap_or_else(|| panic!("{law} is a level"));
        assert_eq!(faults.list[0].code, "scene::load_depends", "{faults}");
        assert!(faults.list[0].message.contains("`level` of joint `brake`"), "{faults}");
    }
}

/// An event resets a state while the wheel is braked: p' = 1, but 0 again at 0.5 s: 2 w' = -4 p, so w falls by t^2 from either start.
#[test]
fn an_event_sets_a_state() {
    let more = "[states]\np = { start = 0, rate = \"1[1/s]\" }\n[initial]\n\"wheel.omega\" = 1\n\
                [events.vent]\nwhen = \"t > 0.5\"\nset = { p = \"p - 0.5\" }";
    let exact = |t: f64| f64::max(1.0 - if t < 0.5 { t * t } else { 0.25 + (t - 0.5) * (t - 0.5) }, 0.0);
    check(&wheel("4[N.m]*p", more), "wheel.omega", &[0.3, 0.7, 1.2, 2.0], exact);
    check(&wheel("4[N.m]*p", more), "p", &[0.3, 0.49, 0.75, 2.0], |t| if t < 0.5 { t } else { t - 0.5 });
}

/// A sled on a floor whose coefficient of friction falls with the time: v' = -10 (0.5 - 0.1 t), and with a ratio that falls it slips under a load once static x mu N is less than that.
#[test]
fn coefficients_of_friction_follow_laws() {
    let sled = |friction: &str, more: &str| {
        format!(
            "name = \"sled\"\ngravity = [0, -10]\n[bodies.sled]\nmass = 1\ninertia = 1\n[joints.guide]\ntype = \"prismatic\"\n\
             between = [\"ground\", \"sled\"]\naxis = [1, 0]\nfriction = {friction}\n[experiment]\nstop = 2\n{more}"
        )
    };
    let falling = sled("{ mu = \"0.5 - 0.1*t\" }", "[initial]\n\"guide.v\" = 8");
    check(&falling, "guide.v", &[0.4, 1.0, 1.6], |t| 8.0 - 5.0 * t + 0.5 * t * t);
    let pull = "[loads.pull]\ntype = \"force\"\non = \"sled\"\nvector = [6, 0]";
    let held = sled("{ mu = 0.5, static = \"max(1, 1.7 - 0.5*t)\" }", pull);
    // It slips at 1 s, where 5 (1.7 - 0.5 t) is 6.
    check(&held, "guide.v", &[0.5, 0.9, 1.5, 2.0], |t| (t - 1.0).max(0.0));
    let coulomb = sled("{ coulomb = \"2 + 3*abs(guide.v)\" }", "[initial]\n\"guide.v\" = 2");
    check(&coulomb, "guide.v", &[0.2, 0.4, 0.6], |t| (8.0 / 3.0 * (-3.0 * t).exp() - 2.0 / 3.0).max(0.0));
}

/// Of a law that becomes negative the run says which one, and its value.
#[test]
fn a_negative_friction_limit_ends_the_run() {
    for (law, name) in [("12[N.m/s]*(0.5[s] - t)", "joints.brake.level"), ("-1[N.m/s]*t", "joints.brake.level")] {
        let model = run::model(&wheel(law, "[initial]\n\"wheel.omega\" = 9"));
        for engine in ENGINES {
            let mut instance = run::started(&model, engine, 2.0, 1e-9);
            let told =
                (1..=20).find_map(|step| instance.step_to(0.1 * f64::from(step)).err()).expect("an end").to_string();
            assert!(told.contains(name) && told.contains("must not be negative") && told.contains("is -"), "{told}");
        }
    }
    // Rounding errors of a state that decays to zero are none.
    let decays = "[states]\np = { start = 1, rate = \"-50[1/s]*p\" }\n[initial]\n\"wheel.omega\" = 9";
    let model = run::model(&wheel("1[N.m]*p", decays));
    ENGINES.iter().for_each(|&engine| run::started(&model, engine, 2.0, 1e-9).step_to(2.0).unwrap());
}

/// Of a level that falls at rest (it slips once the load exceeds it) and one that rises while it slides (nothing happens before it stands).
#[test]
fn a_level_falls_at_rest_and_rises_while_it_slides() {
    let pull = "[loads.pull]\ntype = \"torque\"\non = \"wheel\"\nvalue = \"3 N.m\"";
    let falls = |t: f64| 1.5 * (t - 0.8).max(0.0);
    check(&wheel("if(t < 0.8, 5, 0)", pull), "wheel.omega", &[0.4, 0.9, 2.0], falls);
    // Without a load it stays at rest.
    check(&wheel("max(1 - t, 0)", ""), "wheel.omega", &[0.5, 1.5, 2.0], |_| 0.0);
    // 2 w' = -(1 + 40 t): w = 6 - t/2 - 10 t^2, to rest at 0.75 s.
    let rises = "[initial]\n\"wheel.omega\" = 6";
    check(&wheel("1 + 40*t", rises), "wheel.omega", &[0.3, 0.7, 0.9], |t: f64| {
        if t < 0.75 { 6.0 - 0.5 * t - 10.0 * t * t } else { 0.0 }
    });
}

/// A sample at the instant at which the wheel stops: it acts first. The brake stands at 1 s, where the controller opens it under a load.
#[test]
fn a_sample_at_the_instant_of_sticking_acts_first() {
    let more = "[sampled.controller]\nperiod = 1\nvalues = { on = { start = 1, next = \"if(t > 0.5, 0, 1)\" } }\n\
                [loads.pull]\ntype = \"torque\"\non = \"wheel\"\nvalue = \"2 N.m\"\n[initial]\n\"wheel.omega\" = 1";
    // 2 w' = 2 - 4 until 1 s, then 2 w' = 2.
    check(&wheel("4[N.m]*on", more), "wheel.omega", &[0.5, 1.0, 1.5], |t| if t < 1.0 { 1.0 - t } else { t - 1.0 });
}

/// A belt that slips by Euler and Eytelwein: 2 P r tanh(mu wrap/2) on the second pulley.
#[test]
fn a_belt_slips_at_its_wrap() {
    let scene = |friction: &str| {
        format!(
            "name = \"belt\"\n[ground]\npoints = {{ far = [1, 0] }}\n[bodies]\na = {{ mass = 1, inertia = 1 }}\nb = {{ mass = 1, inertia = 2 }}\n\
             [joints]\npa = {{ type = \"revolute\", between = [\"ground\", \"a\"] }}\npb = {{ type = \"revolute\", between = [\"ground.far\", \"b\"] }}\n\
             band = {{ type = \"belt\", between = [\"a\", \"b\"], first_radius = 0.1, second_radius = 0.2, friction = {friction} }}\n\
             [loads.motor]\ntype = \"torque\"\non = \"a\"\nvalue = 30\n[experiment]\nstop = 1"
        )
    };
    let limit = 2.0 * 50.0 * 0.2 * f64::tanh(0.5 * 0.4 * 2.5);
    let by_wrap = scene("{ mu = 0.4, wrap = 2.5, pretension = 50 }");
    check(&by_wrap, "b.omega", &[0.3, 1.0], |t| 0.5 * limit * t);
    check(&by_wrap, "a.omega", &[0.3, 1.0], |t| (30.0 - 0.5 * limit) * t);
    check(&scene(&format!("{{ coulomb = {limit:?} }}")), "b.omega", &[1.0], |t| 0.5 * limit * t);
    for (friction, told) in [
        ("{ mu = 0.4 }", "needs its angle of wrap"),
        ("{ mu = 0.4, wrap = 2, pretension = 5, coulomb = 1 }", "remove `coulomb`"),
        ("{ wrap = 2, pretension = 5 }", "needs its angle of wrap"),
    ] {
        let faults = Scene::from_toml(&scene(friction)).and_then(|scene| cotree::compile::compile(&scene)).unwrap_err();
        assert!(faults.to_string().contains(told), "{faults}");
    }
}

/// A wheel under a torque that changes, whose brake has a level of time, angle and rate: against one equation of motion with steps of its own. Returns how many of the runs stick.
fn random_levels(seeds: std::ops::Range<u64>) -> usize {
    let mut sticking = 0;
    for seed in seeds {
        let mut random = Random::new(seed);
        let mut between = |low: f64, high: f64| low + (high - low) * random.unit();
        let (size, frequency, mean) = (between(3.0, 9.0), between(2.0, 9.0), between(-2.0, 2.0));
        let [base, by_time, of_time] = [between(0.2, 2.0), between(0.0, 2.0), between(1.0, 7.0)];
        let [by_rate, by_angle] = [between(0.0, 0.8), between(0.0, 3.0)];
        let (ratio, start) = (1.0 + between(0.0, 0.8), between(-2.0, 2.0));
        let torque = move |t: f64| mean + size * (frequency * t).sin();
        let level = move |t: f64, s: f64, v: f64| {
            base + by_time * (of_time * t).sin().powi(2) + by_rate * v.abs() + by_angle * s * s
        };
        let moving = Moving {
            slides: Box::new(move |t, s, v, direction| (torque(t) - direction * level(t, s, v)) / 2.0),
            rests: Box::new(move |t, s| [torque(t), ratio * level(t, s, 0.0)]),
            stops: [f64::NEG_INFINITY, f64::INFINITY],
            restitution: 0.0,
            rates: [f64::NEG_INFINITY, f64::INFINITY],
            jumps: Vec::new(),
        };
        let law = format!(
            "{base:?} + {by_time:?}*sin({of_time:?}*t)^2 + {by_rate:?}*abs(axle.omega) + {by_angle:?}*axle.angle^2"
        );
        let text = format!(
            r#"
name = "bearing"
[bodies.wheel]
mass = 1
inertia = 2
[joints.axle]
type = "revolute"
between = ["ground", "wheel"]
friction = {{ coulomb = "{law}", static = {ratio:?} }}
[loads.drive]
type = "torque"
on = "wheel"
value = "{mean:?} + {size:?}*sin({frequency:?}*t)"
[initial]
"axle.angle" = 0
"axle.omega" = {start:?}
"#
        );
        let model = run::model(&text);
        let mut state = [0.0, 0.0, start];
        let mut instances = Vec::new();
        for engine in ENGINES {
            for tolerance in [1e-6, 1e-8, 1e-10] {
                instances.push((run::started(&model, engine, 2.0, tolerance), engine, tolerance));
            }
        }
        let mut sticks = false;
        for time in [0.5, 1.0, 1.5, 2.0] {
            state = moving.run(state, time);
            sticks |= state[2] == 0.0;
            for (instance, engine, tolerance) in &mut instances {
                instance.step_to(time).unwrap();
                for (name, right) in [("axle.angle", state[1]), ("axle.omega", state[2])] {
                    let error = (run::value(instance, name) - right).abs();
                    assert!(
                        error < 100.0 * *tolerance,
                        "{seed}: {name} at {time}, {engine:?} at {tolerance:e}: {error:e} off {right}\n{text}"
                    );
                }
            }
        }
        sticking += usize::from(sticks);
    }
    sticking
}

#[test]
fn random_levels_move_as_one_equation() {
    assert!(random_levels(0..12) > 2);
}

#[test]
#[ignore = "1000 of them: .ci/nightly"]
fn a_thousand_random_levels_move_as_one_equation() {
    assert!(random_levels(0..1000) > 200);
}

/// A bar of length l about a large pin, with the share mu R m l / (I + m l^2) of its friction in the force that causes it. In SI units.
const INERTIA: f64 = 1e-5;
const LENGTH: f64 = 0.1;
const PIN_RADIUS: f64 = 0.1;

fn bar_on_a_pin(mu: f64, omega: f64) -> String {
    format!(
        r#"
name = "pin"
gravity = [0.0, -9.81]
[bodies.bar]
mass = 1.0
inertia = {INERTIA:?}
points = {{ top = [-{LENGTH:?}, 0] }}
[joints.hinge]
type = "revolute"
between = ["ground", "bar.top"]
friction = {{ mu = {mu:?}, radius = {PIN_RADIUS:?} }}
[initial]
"bar.angle" = "-30 deg"
"bar.omega" = {omega:?}
[outputs]
variables = ["bar.alpha"]
[experiment]
stop = "1 ms"
"#
    )
}

/// (I + m l^2) alpha + m g l cos(angle) + sign(omega) mu R |N(alpha)| = 0 by bisection: below a share of one the left side grows with alpha.
fn acceleration_on_a_pin(mu: f64, omega: f64) -> f64 {
    let (sine, cosine) = (-30.0_f64).to_radians().sin_cos();
    let left = |alpha: f64| {
        let normal = (9.81 * sine - LENGTH * omega * omega).hypot(LENGTH * alpha + 9.81 * cosine);
        (INERTIA + LENGTH * LENGTH) * alpha + 9.81 * LENGTH * cosine + omega.signum() * mu * PIN_RADIUS * normal
    };
    let (mut low, mut high) = (-1e9, 1e9);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        (low, high) = if left(middle) > 0.0 { (low, middle) } else { (middle, high) };
    }
    0.5 * (low + high)
}

#[test]
fn a_pin_moves_on_its_own_friction_up_to_a_share_of_one() {
    for (mu, omega) in [(0.5, 3.0), (0.8, 3.0), (0.9, 3.0), (0.92, 3.0), (0.96, 3.0), (0.98, -20.0), (0.9999, 3.0)] {
        let model = run::model(&bar_on_a_pin(mu, omega));
        for engine in [None, Some(Engine::Dop853), Some(Engine::Radau)] {
            let mut instance = run::started(&model, engine, 1e-3, 1e-11);
            let (found, right) = (run::value(&mut instance, "bar.alpha"), acceleration_on_a_pin(mu, omega));
            assert!((found - right).abs() <= 1e-10 * right.abs(), "mu {mu} by {engine:?}: {found}, not {right}");
        }
    }
}

#[test]
fn a_pin_that_jams_is_named() {
    let mut instance = cotree_fmu::instance::Instance::new(run::model(&bar_on_a_pin(1.2, 3.0)));
    instance.setup(0.0, Some(1e-3), Some(1e-9)).expect("times");
    let message = instance.initialise().expect_err("no motion").to_string();
    assert!(message.contains("self-locking") && message.contains("hinge"), "{message}");
}
