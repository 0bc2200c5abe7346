//! Levels of brakes and clutches that follow states, sampled values and the motion, by every method, against closed forms.

use crate::support::run;
use cotree::scene::Scene;
use cotree_fmu::program::Engine;

const ENGINES: [Option<Engine>; 3] = [None, Some(Engine::Dop853), Some(Engine::Radau)];

/// A wheel of inertia 2 on a bearing, with a brake of this level and with more tables.
fn wheel(level: &str, more: &str) -> String {
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
