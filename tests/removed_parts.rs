//! Events that remove contacts, ropes, stops, brakes, freewheels and joints with friction: what they held moves freely from then on, by every method, against closed forms.

use crate::support::run;
use cotree_fmu::program::Engine;

const ENGINES: [Option<Engine>; 3] = [None, Some(Engine::Dop853), Some(Engine::Radau)];

/// Bodies, each held by something that an event removes at 0.5 s; `removed` are those that it does remove.
fn scene(removed: &str) -> String {
    format!(
        r#"
name = "removed"
gravity = [0, -10]
[ground.points]
peg = [3, 0]
[bodies.lift]
mass = 1
inertia = 1
[bodies.disc]
mass = 1
inertia = 1
[bodies.sled]
mass = 2
inertia = 1
[bodies.hung]
mass = 1
inertia = 1
[bodies.wheel]
mass = 1
inertia = 1
[joints.rail]
type = "prismatic"
between = ["ground", "lift"]
axis = [0, 1]
limits = {{ min = 0 }}
friction = {{ coulomb = 2 }}
[joints.pin]
type = "revolute"
between = ["ground", "disc"]
friction = {{ coulomb = 1, mu = 0.2, radius = "10 mm" }}
[joints.guide]
type = "prismatic"
between = ["ground", "sled"]
axis = [1, 0]
friction = {{ mu = 0.5 }}
[joints.rope]
type = "rope"
between = ["ground.peg", "hung"]
length = 2
[joints.shaft]
type = "revolute"
between = ["ground.peg", "wheel"]
[joints.hold]
type = "brake"
between = ["ground", "wheel"]
level = "1 N.m"
[joints.ratchet]
type = "one_way"
between = ["ground", "wheel"]
[loads]
turn = {{ type = "torque", on = "disc", value = "3 N.m" }}
back = {{ type = "torque", on = "wheel", value = "-3 N.m" }}
push = {{ type = "force", on = "sled", vector = ["4 N", 0] }}
[events.gone]
when = "t > 0.5"
remove = [{removed}]
[initial]
"hung.x" = 3
"hung.y" = -2
[outputs]
variables = ["lift.y", "disc.y", "disc.omega", "sled.x", "sled.y", "hung.y", "wheel.omega", "pin.sliding"]
[experiment]
stop = "1 s"
"#
    )
}

/// Rest or the motion so far until 0.5 s, then free fall and what the loads do.
#[test]
fn what_held_is_gone() {
    let all = ["rail", "pin", "guide", "rope", "hold", "ratchet"];
    // Each by itself, then all of them.
    let several = all.iter().map(|own| vec![*own]).chain([all.to_vec()]);
    for removed in several {
        let names: Vec<String> = removed.iter().map(|own| format!("\"{own}\"")).collect();
        let model = run::model(&scene(&names.join(", ")));
        let gone = |name: &str| removed.contains(&name);
        for engine in ENGINES {
            let mut instance = run::started(&model, engine, 1.0, 1e-9);
            for time in [0.25, 0.5, 0.75, 1.0] {
                instance.step_to(time).unwrap();
                let free = f64::max(time - 0.5, 0.0);
                let fall = |name: &str| if gone(name) { -5.0 * free * free } else { 0.0 };
                // The pin rubs with 1 + 0.2*0.01*10 N.m.
                let driven = if gone("pin") { 1.98 * (time - free) + 3.0 * free } else { 1.98 * time };
                let wheel = match (gone("hold"), gone("ratchet")) {
                    (_, false) => 0.0,
                    (false, true) => -2.0 * free,
                    (true, true) => -3.0 * free,
                };
                let right = [
                    ("lift.y", fall("rail")),
                    ("disc.y", fall("pin")),
                    ("disc.omega", driven),
                    ("sled.y", fall("guide")),
                    ("sled.x", if gone("guide") { free * free } else { 0.0 }),
                    ("hung.y", -2.0 + fall("rope")),
                    ("wheel.omega", wheel),
                ];
                for (name, right) in right {
                    let found = run::value(&mut instance, name);
                    let told = format!("{name} at {time} by {engine:?} without {removed:?}");
                    assert!((found - right).abs() < 1e-8, "{told}: {found}, not {right}");
                }
            }
            assert_eq!(run::value(&mut instance, "pin.sliding"), if gone("pin") { 0.0 } else { 1.0 });
        }
    }
}

/// A box slides on a floor with friction until that is taken away: then it falls, and nothing brakes it.
#[test]
fn a_floor_with_friction_is_taken_away() {
    let text = "name = \"gone\"\ngravity = [0, -10]\n[bodies.box]\nmass = 1\ninertia = 1\n[joints.pad]\ntype = \"contact\"\nbetween = [\"ground\", \"box\"]\naxis = [1, 0]\nfriction = { mu = 0.4 }\n\
                [events.gone]\nwhen = \"t > 0.5\"\nremove = [\"pad\"]\n[initial]\n\"box.vx\" = 3\n[experiment]\nstop = \"1 s\"\n";
    let model = run::model(text);
    for engine in ENGINES {
        let mut instance = run::started(&model, engine, 1.0, 1e-9);
        for time in [0.25, 0.5, 1.0] {
            instance.step_to(time).unwrap();
            let free = f64::max(time - 0.5, 0.0);
            let right = [("box.vx", 3.0 - 4.0 * (time - free)), ("box.y", -5.0 * free * free)];
            for (name, right) in right {
                let found = run::value(&mut instance, name);
                assert!((found - right).abs() < 1e-8, "{name} at {time} by {engine:?}: {found}, not {right}");
            }
        }
    }
}

/// A ball that bounces on a floor which is taken away in mid-flight falls on.
#[test]
fn a_floor_is_taken_away_while_nothing_touches_it() {
    let text = "name = \"gone\"\ngravity = [0, -10]\n[bodies.ball]\nmass = 1\ninertia = 1\n[joints.pad]\ntype = \"contact\"\nbetween = [\"ground\", \"ball\"]\naxis = [1, 0]\nrestitution = 0.5\n\
                [events.gone]\nwhen = \"t > 0.2\"\nremove = [\"pad\"]\n[initial]\n\"ball.y\" = 0.2\n\"ball.vy\" = -8\n[experiment]\nstop = \"2 s\"\n";
    // It strikes with sqrt(8^2 + 2*10*0.2) m/s and rebounds with half of that.
    let model = run::model(text);
    let strikes = 68.0_f64.sqrt();
    let at = (strikes - 8.0) / 10.0;
    for engine in ENGINES {
        let mut instance = run::started(&model, engine, 2.0, 1e-9);
        for time in [0.1, 1.0, 2.0] {
            instance.step_to(time).unwrap();
            let flight = time - at;
            let right = 0.5 * strikes * flight - 5.0 * flight * flight;
            let found = run::value(&mut instance, "ball.y");
            assert!((found - right).abs() < 1e-8, "{time} by {engine:?}: {found}, not {right}");
        }
    }
}
