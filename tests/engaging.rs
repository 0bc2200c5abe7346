//! Joints that events engage and release, and rates that they set: closed forms, momenta and lost energies, by every method.

use crate::support::run;
use cotree::scene::Scene;
use cotree_fmu::instance::Instance;
use cotree_fmu::math::Random;
use cotree_fmu::program::Engine;
use std::collections::BTreeSet;

const ENGINES: [Option<Engine>; 3] = [None, Some(Engine::Dop853), Some(Engine::Radau)];

fn refused(text: &str) -> String {
    let compiled = Scene::from_toml(text).and_then(|scene| cotree::compile::compile(&scene));
    compiled.err().unwrap_or_else(|| panic!("is compiled: {text}")).to_string()
}

/// A scene that reports these variables.
fn reporting(text: &str, names: &[&str]) -> String {
    let names: BTreeSet<&str> = names.iter().copied().filter(|name| !name.starts_with("events.")).collect();
    let names: Vec<String> = names.into_iter().map(|name| format!("\"{name}\"")).collect();
    format!("{text}\n[outputs]\nvariables = [{}]\n", names.join(", "))
}

/// Checks values at times, by each method.
fn check(text: &str, values: &[(f64, &str, f64)], tolerance: f64) {
    let names: Vec<&str> = values.iter().map(|(_, name, _)| *name).collect();
    let model = run::model(&reporting(text, &names));
    for engine in ENGINES {
        let mut instance = run::started(&model, engine, 4.0, 1e-10);
        for &(time, name, right) in values {
            if time > instance.time() {
                instance.step_to(time).unwrap();
            }
            let found = run::value(&mut instance, name);
            assert!((found - right).abs() < tolerance, "{name} at {time} by {engine:?}: {found}, not {right}");
        }
    }
}

/// Two carts on a rail; the second stands, the first comes from the left.
pub fn carts(coupling: &str, more: &str) -> String {
    format!(
        r#"
name = "carts"
[bodies]
a = {{ mass = 3, inertia = 0.1 }}
b = {{ mass = 1, inertia = 0.1 }}
[joints]
rail_a = {{ type = "prismatic", between = ["ground", "a"], axis = [1, 0] }}
rail_b = {{ type = "prismatic", between = ["ground", "b"], axis = [1, 0] }}
coupling = {coupling}
[initial]
"rail_a.s" = 0
"rail_a.v" = 2
"rail_b.s" = 1
"rail_b.v" = 0
[experiment]
stop = 2
{more}"#
    )
}

pub const MEET: &str = "[events.meet]\nwhen = \"rail_b.s - rail_a.s < 0.2\"\nengage = [\"coupling\"]\nonce = true\n";

/// They meet at 0.4 s, 0.2 m apart, and go on with 3/4 of the speed; the impulse on the second is 1.5 N.s. At 1 s they are released, and nothing pushes them apart.
#[test]
fn carts_couple_where_they_meet() {
    for coupling in [
        r#"{ type = "distance", between = ["a", "b"], engaged = false }"#,
        r#"{ type = "weld", between = ["a", "b"], engaged = false }"#,
    ] {
        let text = carts(coupling, &format!("{MEET}[events.part]\nwhen = \"t > 1\"\nrelease = [\"coupling\"]\n"));
        let is_rod = coupling.contains("distance");
        let [impulse, force] =
            if is_rod { ["coupling.impulse", "coupling.force"] } else { ["coupling.impulse_x", "coupling.fx"] };
        let values = [
            (0.3, "rail_a.v", 2.0),
            (0.3, "coupling.engaged", 0.0),
            (0.3, impulse, 0.0),
            (0.6, "events.meet.time", 0.4),
            (0.6, "rail_a.v", 1.5),
            (0.6, "rail_b.v", 1.5),
            (0.6, "rail_b.s", 1.3),
            (0.6, "coupling.engaged", 1.0),
            (0.6, impulse, 1.5),
            (0.6, force, 0.0),
            (1.5, "coupling.engaged", 0.0),
            (1.5, "rail_b.s", 2.65),
        ];
        check(&text, &values, 1e-11);
    }
}

/// A coupling in its named pose: at an event that finds it there, and beside it.
#[test]
fn a_named_pose_must_be_there() {
    let rod = r#"{ type = "distance", between = ["a", "b"], length = 0.2, engaged = false, at = "named" }"#;
    check(&carts(rod, MEET), &[(1.0, "rail_b.v", 1.5), (1.0, "rail_b.s", 1.9)], 1e-9);
    let model = run::model(&carts(&rod.replace("0.2", "0.25"), MEET));
    let told = run::started(&model, None, 2.0, 1e-9).step_to(1.0).unwrap_err().to_string();
    assert!(
        told.contains("beside its named pose") && told.contains("5.000e1 mm") && told.contains("`coupling`"),
        "{told}"
    );
}

/// Two joints that engage at one instant have one impact, in whatever order events and joints are written; a state that was saved before it holds the same pose to the last bit.
#[test]
fn joints_that_engage_together_have_one_impact() {
    let third = "[bodies.c]\nmass = 2\ninertia = 0.1\n[joints.rail_c]\ntype = \"prismatic\"\nbetween = [\"ground\", \"c\"]\naxis = [1, 0]\n";
    let rods = "[joints.first]\ntype = \"distance\"\nbetween = [\"a\", \"b\"]\nengaged = false\n[joints.second]\ntype = \"distance\"\nbetween = [\"c\", \"b\"]\nengaged = false\n";
    let [one, other] =
        ["first", "second"].map(|rod| format!("[events.of_{rod}]\nwhen = \"t > 0.25\"\nengage = [\"{rod}\"]\n"));
    let start = "\"rail_c.s\" = 2\n\"rail_c.v\" = -1\n[experiment]";
    let scene = |events: &str| {
        let text = carts(
            "{ type = \"distance\", between = [\"a\", \"b\"], length = 9, engaged = false }",
            &format!("{third}{rods}{events}"),
        );
        reporting(&text.replace("[experiment]", start), &["rail_a.v", "rail_b.v", "rail_c.v", "rail_a.s", "rail_c.s"])
    };
    let together = "[events.both]\nwhen = \"t > 0.25\"\nengage = [\"second\", \"first\"]\n".to_owned();
    for events in [format!("{one}{other}"), format!("{other}{one}"), together] {
        let model = run::model(&scene(&events));
        for engine in ENGINES {
            let mut instance = run::started(&model, engine, 4.0, 1e-10);
            instance.step_to(0.2).unwrap();
            let saved = instance.save();
            instance.step_to(1.0).unwrap();
            for name in ["rail_a.v", "rail_b.v", "rail_c.v"] {
                let found = run::value(&mut instance, name);
                assert!((found - (3.0 * 2.0 - 2.0) / 6.0).abs() < 1e-11, "{name} by {engine:?}: {found}");
            }
            let apart = run::value(&mut instance, "rail_c.s") - run::value(&mut instance, "rail_a.s");
            assert!((apart - (2.0 - 0.25 * 3.0)).abs() < 1e-9, "{engine:?}: {apart}");
            let end = run::motion(&instance);
            instance.restore(&saved).unwrap();
            instance.step_to(1.0).unwrap();
            assert_eq!(run::motion(&instance), end, "{engine:?}: restored");
        }
    }
}

/// Rates that agree exchange nothing: the run is that of a coupling from the start, under a load.
#[test]
fn engaging_at_rest_is_no_impact() {
    let push = "[loads.push]\ntype = \"force\"\non = \"a\"\nvector = [\"if(t < 0.5, 0, 4)\", 0]\n";
    let later = "[events.meet]\nwhen = \"t > 0.5\"\nengage = [\"coupling\"]\n";
    let rod = r#"{ type = "distance", between = ["a", "b"], engaged = false }"#;
    let text = carts(rod, &format!("{push}{later}")).replace("\"rail_a.v\" = 2", "\"rail_a.v\" = 0");
    // 4 N move 4 kg, and 1 N of it passes through the rod, which pushes.
    let values =
        [(1.5, "coupling.impulse", 0.0), (1.5, "rail_a.v", 1.0), (1.5, "rail_b.v", 1.0), (1.5, "coupling.force", 1.0)];
    check(&text, &values, 1e-11);
}

/// What is engaged is not engaged again, what is open is not released; the second engagement holds the new distance.
#[test]
fn a_second_engagement_holds_the_new_pose() {
    let more = "[events.meet]\nwhen = \"t > 0.1\"\nengage = [\"coupling\"]\n[events.again]\nwhen = \"t > 0.2\"\nengage = [\"coupling\"]\n\
                [events.part]\nwhen = \"t > 0.3\"\nrelease = [\"coupling\"]\n[events.more]\nwhen = \"t > 0.35\"\nrelease = [\"coupling\"]\n\
                set = { \"rail_b.v\" = 4 }\n[events.last]\nwhen = \"t > 0.5\"\nengage = [\"coupling\"]\n";
    let rod = r#"{ type = "distance", between = ["a", "b"], engaged = false }"#;
    let apart = 0.8 + 0.15 * (4.0 - 1.5);
    let values = [
        (0.05, "coupling.length", 0.9),
        (0.25, "rail_a.s", 0.2 + 0.15 * 1.5),
        (0.25, "rail_b.s", 1.0 + 0.15 * 1.5),
        (0.25, "coupling.length", 0.8),
        (0.25, "coupling.impulse", 1.5),
        (0.4, "rail_a.v", 1.5),
        (0.4, "rail_b.v", 4.0),
        (0.6, "rail_a.v", (3.0 * 1.5 + 4.0) / 4.0),
        (0.6, "coupling.impulse", -1.875),
        (1.9, "rail_a.s", 0.2 + 0.4 * 1.5 + 1.4 * 2.125),
        (1.9, "rail_b.s", 0.2 + 0.4 * 1.5 + 1.4 * 2.125 + apart),
    ];
    check(&carts(rod, more), &values, 1e-10);
}

/// Two events at one instant: the carts have their impact and are free again.
#[test]
fn engaged_and_released_at_one_instant_is_an_impact() {
    let more = "[events.meet]\nwhen = \"t > 0.3\"\nengage = [\"coupling\"]\n[events.part]\nwhen = \"t > 0.3\"\nrelease = [\"coupling\"]\n\
                [loads.brake]\ntype = \"force\"\non = \"b\"\nvector = [\"if(t < 0.3, 0, -1)\", 0]\n";
    let rod = r#"{ type = "distance", between = ["a", "b"], engaged = false }"#;
    let values = [
        (1.3, "coupling.engaged", 0.0),
        (1.3, "rail_a.v", 1.5),
        (1.3, "rail_b.v", 0.5),
        (1.3, "coupling.impulse", 1.5),
    ];
    check(&carts(rod, more), &values, 1e-10);
}

/// A table under a constant torque and a detent every 60 degrees, held for 0.2 s each.
#[test]
fn a_detent_stops_a_table() {
    let text = r#"
name = "table"
[bodies.table]
mass = 1
inertia = 2
[joints]
pin = { type = "revolute", between = ["ground", "table"] }
hold = { type = "lock", joint = "pin", engaged = false }
[loads.drive]
type = "torque"
on = "table"
value = "4 N.m"
[sampled.count]
period = "1000 s"
values = { target = { start = "pi/3" } }
[events.catch]
when = "pin.angle > target"
engage = ["hold"]
set = { target = "target + pi/3" }
[events.let_go]
when = "t > events.catch.time + 0.2"
release = ["hold"]
[experiment]
stop = 4
"#;
    let step = std::f64::consts::PI / 3.0;
    // 2 w' = 4.
    let [turn, speed] = [step.sqrt(), 2.0 * step.sqrt()];
    let values = [
        (turn + 0.1, "table.angle", step),
        (turn + 0.1, "table.omega", 0.0),
        (turn + 0.1, "hold.torque", -4.0),
        (turn + 0.1, "hold.impulse", -2.0 * speed),
        (2.0 * turn + 0.3, "table.angle", 2.0 * step),
        (2.0 * turn + 0.5, "table.angle", 2.0 * step + 0.1 * 0.1),
        (2.0 * turn + 0.5, "hold.torque", 0.0),
    ];
    check(text, &values, 1e-9);
}

/// An arm and a flying disc that it grips at its tip, where the disc is then.
pub fn catch(more: &str) -> String {
    format!(
        r#"
name = "catch"
gravity = [0, -9.81]
[bodies]
arm = {{ mass = 1, inertia = 0.1, com = [0.5, 0], points = {{ o = [0, 0], tip = [1, 0] }} }}
disc = {{ mass = 0.5, inertia = 0.002 }}
[joints]
pin = {{ type = "revolute", between = ["ground", "arm.o"] }}
grip = {{ type = "weld", between = ["arm.tip", "disc"], engaged = false }}
[events.catch]
when = "hypot(disc.x - arm.tip.x, disc.y - arm.tip.y) < 0.1"
engage = ["grip"]
once = true
[initial]
"pin.angle" = "-90 deg"
"pin.omega" = 0
"disc.x" = -0.6
"disc.y" = -0.95
"disc.angle" = 0
"disc.vx" = 2
"disc.vy" = 1
"disc.omega" = 3
[experiment]
stop = 1
{more}"#
    )
}

/// About the pin the angular momentum stays at the catch, and afterwards the energy; the impulse of the grip is what the disc gets.
#[test]
fn a_caught_disc_keeps_the_angular_momentum() {
    let names = [
        "disc.x",
        "disc.y",
        "disc.vx",
        "disc.vy",
        "disc.omega",
        "arm.omega",
        "arm.tip.x",
        "arm.tip.y",
        "energy.total",
        "grip.engaged",
        "grip.impulse_x",
        "grip.impulse_y",
        "grip.impulse_torque",
    ];
    let model = run::model(&reporting(&catch(""), &names));
    for engine in ENGINES {
        let mut instance = run::started(&model, engine, 1.0, 1e-11);
        instance.step_to(0.2501132621).unwrap();
        let momentum = |instance: &mut Instance| {
            let mut get = |name: &str| run::value(instance, name);
            let disc =
                0.5 * (get("disc.x") * get("disc.vy") - get("disc.y") * get("disc.vx")) + 0.002 * get("disc.omega");
            disc + (0.1 + 0.25) * get("arm.omega")
        };
        let before = momentum(&mut instance);
        let rates = ["disc.vx", "disc.vy", "disc.omega"].map(|name| run::value(&mut instance, name));
        instance.step_to(0.2501132622).unwrap();
        assert_eq!(run::value(&mut instance, "grip.engaged"), 1.0);
        assert!((momentum(&mut instance) - before).abs() < 1e-8, "{before}");
        let impulses =
            ["grip.impulse_x", "grip.impulse_y", "grip.impulse_torque"].map(|name| run::value(&mut instance, name));
        let after = ["disc.vx", "disc.vy", "disc.omega"].map(|name| run::value(&mut instance, name));
        for (place, inertia) in [0.5, 0.5].into_iter().enumerate() {
            let gained = inertia * (after[place] - rates[place]);
            assert!((gained - impulses[place]).abs() < 1e-8, "{place}: {gained}, {impulses:?}");
        }
        // The torque of the impulse acts about the disc's centre, whose point it is.
        assert!((0.002 * (after[2] - rates[2]) - impulses[2]).abs() < 1e-8, "{impulses:?} {after:?} {rates:?}");
        assert!((run::value(&mut instance, "arm.omega") - 1.2564651752212208).abs() < 1e-7);
        let energy = run::value(&mut instance, "energy.total");
        let apart = ["disc.x", "arm.tip.x", "disc.y", "arm.tip.y"].map(|name| run::value(&mut instance, name));
        instance.step_to(1.0).unwrap();
        assert!((run::value(&mut instance, "energy.total") - energy).abs() < 1e-9);
        let later = ["disc.x", "arm.tip.x", "disc.y", "arm.tip.y"].map(|name| run::value(&mut instance, name));
        let distance = |at: [f64; 4]| f64::hypot(at[0] - at[1], at[2] - at[3]);
        assert!((distance(apart) - 0.1).abs() < 1e-8 && (distance(later) - distance(apart)).abs() < 1e-10);
    }
}

/// A double pendulum whose upper arm is stopped: about the elbow the lower one keeps its angular momentum.
#[test]
fn a_rate_is_set_by_an_impulse_along_it() {
    let text = r#"
name = "stopped"
gravity = [0, -9.81]
[bodies]
upper = { mass = 1, inertia = 0.02, com = [0.25, 0], points = { o = [0, 0], e = [0.5, 0] } }
lower = { mass = 1, inertia = 0.02, com = [0.25, 0], points = { e = [0, 0] } }
[joints]
p1 = { type = "revolute", between = ["ground", "upper.o"] }
p2 = { type = "revolute", between = ["upper.e", "lower.e"] }
[events.stop]
when = "t > 0.3"
set = { "upper.omega" = "-0.5*upper.omega" }
[initial]
"upper.angle" = 0
"upper.omega" = 0
"lower.angle" = 0.3
"lower.omega" = 0
[experiment]
stop = 1
"#;
    let names = ["upper.omega", "lower.omega", "upper.angle", "lower.angle"];
    let model = run::model(&reporting(text, &names));
    for engine in ENGINES {
        let mut instance = run::started(&model, engine, 1.0, 1e-11);
        instance.step_to(0.3 - 1e-12).unwrap();
        let before = names.map(|name| run::value(&mut instance, name));
        instance.step_to(0.3 + 1e-12).unwrap();
        let after = names.map(|name| run::value(&mut instance, name));
        assert!((after[0] + 0.5 * before[0]).abs() < 1e-9, "{before:?} {after:?}");
        let lower = (0.02 + 0.25 * 0.25) * (after[1] - before[1]);
        let carried = 0.25 * 0.5 * (before[2] - before[3]).cos() * (after[0] - before[0]);
        assert!((lower + carried).abs() < 1e-9, "{before:?} {after:?}");
    }
}

/// Both rates of an event are set together; positions, driven rates and rates of loads are refused.
#[test]
fn rates_that_cannot_be_set_are_refused() {
    let rod = r#"{ type = "distance", between = ["a", "b"], engaged = false }"#;
    let both = "[events.kick]\nwhen = \"t > 0.3\"\nset = { \"rail_a.v\" = 5, \"b.vx\" = \"-rail_a.v\" }\n";
    check(&carts(rod, &format!("{MEET}{both}")), &[(0.32, "rail_a.v", 5.0), (0.32, "rail_b.v", -2.0)], 1e-10);
    for (set, told) in [
        ("\"rail_a.s\" = 1", "a position, which cannot change at once"),
        ("\"a.ax\" = 1", "a result of the motion"),
        ("\"a.vy\" = 1", "which drivers or joints prescribe"),
        ("\"nobody.vx\" = 1", "does not exist"),
        ("\"rail_a.v\" = \"1 rad\"", "unit"),
    ] {
        let told_now = refused(&carts(rod, &format!("{MEET}[events.kick]\nwhen = \"t > 0.3\"\nset = {{ {set} }}\n")));
        assert!(told_now.contains(told), "{set}: {told_now}");
    }
    // Two rates that a coupling ties are one rate.
    let tied = "[events.kick]\nwhen = \"t > 0.6\"\nset = { \"rail_a.v\" = 5, \"b.vx\" = 1 }\n";
    let model = run::model(&carts(rod, &format!("{MEET}{tied}")));
    let told = run::started(&model, None, 2.0, 1e-9).step_to(1.0).unwrap_err().to_string();
    assert!(told.contains("`rail_a.v`") && told.contains("`b.vx`"), "{told}");
}

/// What cannot engage is refused by name.
#[test]
fn what_cannot_engage_is_refused() {
    let rod = r#"{ type = "distance", between = ["a", "b"], engaged = false }"#;
    let event = |change: &str| {
        format!(
            "[events.meet]\nwhen = \"t > 0.3\"\n{change}\n[loads.push]\ntype = \"force\"\non = \"a\"\nvector = [1, 0]\n"
        )
    };
    for (change, told) in [
        ("engage = [\"push\"]", "only joints can be engaged"),
        ("release = [\"couplin\"]", "did you mean `coupling`"),
        ("engage = [\"a\"]", "only joints can be engaged"),
        ("engage = [\"coupling\"]\nrelease = [\"coupling\"]", "both engages and releases `coupling`"),
    ] {
        let told_now = refused(&carts(rod, &event(change)));
        assert!(told_now.contains(told), "{change}: {told_now}");
    }
    let gear = r#"{ type = "cam", between = ["a", "b"] }"#;
    assert!(refused(&carts(gear, &event("engage = [\"coupling\"]"))).contains("cannot be engaged"));
    let rough = r#"{ type = "revolute", between = ["a", "b"], engaged = false, damping = 1 }"#;
    assert!(refused(&carts(rough, MEET)).contains("engages by an event, and has `damping`"));
    let bare = r#"{ type = "distance", between = ["a", "b"] }"#;
    assert!(refused(&carts(bare, MEET)).contains("length"));
}

/// A lock holds the only freedom under a load without a drift.
#[test]
fn a_lock_does_not_drift() {
    let text = carts(
        r#"{ type = "lock", joint = "rail_a", engaged = false }"#,
        "[events.hold]\nwhen = \"t > 0.5\"\nengage = [\"coupling\"]\n[loads.push]\ntype = \"force\"\non = \"a\"\nvector = [5, 0]\n",
    );
    let model = run::model(&reporting(&text.replace("stop = 2", "stop = 1000"), &["rail_a.s", "coupling.force"]));
    for engine in ENGINES {
        let mut instance = run::started(&model, engine, 1000.0, 1e-8);
        instance.step_to(1.0).unwrap();
        let held = run::value(&mut instance, "rail_a.s");
        instance.step_to(1000.0).unwrap();
        assert!((run::value(&mut instance, "rail_a.s") - held).abs() < 1e-12);
        assert!((run::value(&mut instance, "coupling.force") + 5.0).abs() < 1e-11);
    }
}

/// Two joints at one instant are one impact, whatever their order; a contact at rest takes its share.
#[test]
fn a_stop_takes_its_share_of_an_engagement() {
    // The second cart rests against a stop behind it: the first pushes it there, and both stand.
    let more = format!(
        "{MEET}[joints.stop]\ntype = \"prismatic\"\nbetween = [\"ground\", \"b\"]\naxis = [1, 0]\nlimits = {{ max = 1 }}\n"
    );
    let rod = r#"{ type = "distance", between = ["a", "b"], engaged = false }"#;
    let text = carts(rod, &more)
        .replace("rail_b = { type = \"prismatic\", between = [\"ground\", \"b\"], axis = [1, 0] }\n", "")
        .replace("rail_b.s", "stop.s")
        .replace("rail_b.v", "stop.v");
    check(&text, &[(1.0, "rail_a.v", 0.0), (1.0, "stop.v", 0.0), (1.0, "stop.s", 1.0)], 1e-10);
}

/// Random chains of bodies that are caught by random joints: linear and angular momentum stay, and energy is lost.
fn momenta(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let mut random = Random::new(seed);
        let mut number = |scale: f64| scale * random.symmetric();
        let mut text = format!("name = \"momenta{seed}\"\n[bodies]\n");
        for body in ["a", "b", "c"] {
            let (mass, inertia) = (1.0 + number(0.5), 0.3 + number(0.2));
            text += &format!(
                "{body} = {{ mass = {mass:?}, inertia = {inertia:?}, points = {{ p = [{:?}, {:?}], q = [{:?}, {:?}] }} }}\n",
                number(0.5),
                number(0.5),
                number(0.5),
                number(0.5)
            );
        }
        let kind = ["weld", "revolute", "distance", "prismatic", "slot", "lock"][(seed % 6) as usize];
        let ends = if kind == "lock" { "between = [\"b\", \"c\"]" } else { "between = [\"b.q\", \"c.p\"]" };
        let axis = if ["prismatic", "slot"].contains(&kind) {
            format!(", axis = [{:?}, 1.0]", number(1.0))
        } else {
            String::new()
        };
        text += &format!(
            "[joints]\nab = {{ type = \"revolute\", between = [\"a.p\", \"b.p\"] }}\nbc = {{ type = \"{kind}\", {ends}{axis}, engaged = false }}\n"
        );
        text += "[events.catch]\nwhen = \"t > 0.2\"\nengage = [\"bc\"]\n[experiment]\nstop = 1\n[initial]\n";
        for (body, x) in [("a", 0.0), ("c", 3.0)] {
            text += &format!(
                "\"{body}.x\" = {:?}\n\"{body}.y\" = {:?}\n\"{body}.angle\" = {:?}\n",
                x + number(0.5),
                number(0.5),
                number(1.0)
            );
            text += &format!(
                "\"{body}.vx\" = {:?}\n\"{body}.vy\" = {:?}\n\"{body}.omega\" = {:?}\n",
                number(1.0),
                number(1.0),
                number(2.0)
            );
        }
        text += &format!("\"b.angle\" = {:?}\n\"b.omega\" = {:?}\n", number(1.0), number(2.0));
        let bodies = ["a", "b", "c"]
            .iter()
            .flat_map(|body| ["x", "y", "vx", "vy", "omega"].map(|word| format!("{body}.{word}")));
        let names: Vec<String> = bodies.chain(["energy.kinetic", "bc.engaged"].map(str::to_owned)).collect();
        let model = run::model(&reporting(&text, &names.iter().map(String::as_str).collect::<Vec<_>>()));
        let mut instance = run::started(&model, None, 1.0, 1e-12);
        let inertias: Vec<[f64; 2]> = ["a", "b", "c"]
            .iter()
            .map(|body| {
                let line = text.lines().find(|line| line.starts_with(&format!("{body} = "))).unwrap();
                let value = |key: &str| {
                    line.split(&format!("{key} = ")).nth(1).unwrap().split([',', ' ']).next().unwrap().parse().unwrap()
                };
                [value("mass"), value("inertia")]
            })
            .collect();
        let momentum = |instance: &mut Instance| {
            let mut sum = [0.0; 3];
            for (body, [mass, inertia]) in ["a", "b", "c"].iter().zip(&inertias) {
                let [x, y, vx, vy, omega] =
                    ["x", "y", "vx", "vy", "omega"].map(|word| run::value(instance, &format!("{body}.{word}")));
                sum[0] += mass * vx;
                sum[1] += mass * vy;
                sum[2] += mass * (x * vy - y * vx) + inertia * omega;
            }
            sum
        };
        let begin = momentum(&mut instance);
        let energy = run::value(&mut instance, "energy.kinetic");
        for time in [0.1, 0.3, 0.9] {
            instance.step_to(time).unwrap();
            for (found, right) in momentum(&mut instance).iter().zip(begin) {
                assert!((found - right).abs() < 1e-12 * (1.0 + right.abs()) * 10.0, "{seed} {kind}: {found} {right}");
            }
        }
        assert!(run::value(&mut instance, "energy.kinetic") <= energy + 1e-9, "{seed} {kind}");
        assert_eq!(run::value(&mut instance, "bc.engaged"), 1.0);
    }
}

#[test]
fn momenta_stay() {
    momenta(0..24);
}

#[test]
#[ignore = "500 of them: .ci/nightly"]
fn many_momenta_stay() {
    momenta(0..500);
}

/// Guides hold two of the three constraints of a weld between their carts: one is left, and the coupling is that of a rod.
#[test]
fn a_weld_of_guided_carts_has_one_constraint() {
    let weld = r#"{ type = "weld", between = ["a", "b"], engaged = false }"#;
    let text = carts(weld, MEET);
    check(&text, &[(1.0, "rail_b.v", 1.5), (1.0, "coupling.impulse_x", 1.5), (1.0, "coupling.impulse_y", 0.0)], 1e-11);
    let scene = Scene::from_toml(&text).unwrap();
    let compiled = cotree::compile::compile(&scene).unwrap();
    let told = compiled.warnings.map(|warnings| warnings.to_string()).unwrap_or_default();
    assert!(told.contains("`coupling` holds 1 of its 3 constraints"), "{told}");
}

/// A pendulum whose hinge holds two of a weld's three constraints in every pose, though not always the same two: the angle is left, and the arm stands from then on as a lock would hold it.
#[test]
fn a_weld_of_a_pendulum_is_a_lock() {
    let pendulum = |detent: &str| {
        format!(
            r#"
name = "detent"
gravity = [0, -9.81]
[bodies.arm]
mass = 2
inertia = 0.1
points = {{ pin = [-0.5, 0] }}
[joints.hinge]
type = "revolute"
between = ["ground", "arm.pin"]
[joints.detent]
{detent}
engaged = false
[initial]
"hinge.angle" = 0.3
"hinge.omega" = 0.5
[events.catch]
when = "t > 0.4"
engage = ["detent"]
[experiment]
stop = 1
"#
        )
    };
    let reports = ["hinge.angle", "hinge.omega", "hinge.fy", "detent.engaged"];
    let [weld, lock] =
        ["type = \"weld\"\nbetween = [\"ground\", \"arm\"]", "type = \"lock\"\njoint = \"hinge\""].map(|detent| {
            let model = run::model(&reporting(&pendulum(detent), &reports));
            let mut instance = run::started(&model, None, 1.0, 1e-11);
            instance.step_to(0.8).unwrap();
            reports.map(|name| run::value(&mut instance, name))
        });
    assert_eq!((weld[1].abs() < 1e-12, weld[3]), (true, 1.0));
    assert!((weld[0] - lock[0]).abs() < 1e-10 && (weld[2] - lock[2]).abs() < 1e-8, "{weld:?} {lock:?}");
}

/// A flywheel at 10 rad/s engages with a second wheel or a slide at rest, by whatever couples a turn to a turn or a way. With the inertias 0.2 and 0.1 kg.m2 and the ratio r the second wheel gets the impulse P = r 10/(1/0.1 + r^2/0.2), and P r 10/2 of the energy
/// are lost; with a mass of 2 kg likewise.
#[test]
fn gears_belts_racks_and_screws_engage() {
    let couplings = [
        ("gear", "between = [\"fly\", \"wheel\"]\nratio = -0.5", -0.5, 0.1),
        ("belt", "between = [\"fly\", \"wheel\"]\nfirst_radius = 0.1\nsecond_radius = 0.2", 0.5, 0.1),
        (
            "belt",
            "between = [\"fly\", \"wheel\"]\nfirst_radius = 0.1\nsecond_radius = 0.2\nrun = \"crossed\"",
            -0.5,
            0.1,
        ),
        ("rack", "between = [\"fly\", \"slide\"]\nradius = 0.1\naxis = [1, 0]", 0.1, 2.0),
        ("rack", "between = [\"fly\", \"slide\"]\nradius = 0.1\naxis = [1, 0]\ncarrier = \"ground.off\"", 0.1, 2.0),
        ("screw", "between = [\"fly\", \"slide\"]\nlead = 0.6283185307179586\naxis = [1, 0]", 0.1, 2.0),
    ];
    for (kind, keys, ratio, second) in couplings {
        let text = format!(
            r#"
name = "engages"
[ground.points]
off = [0.3, 1]
[bodies.fly]
mass = 1
inertia = 0.2
[bodies.wheel]
mass = 1
inertia = 0.1
[bodies.slide]
mass = 2
inertia = 0.1
[joints.fly_pin]
type = "revolute"
between = ["ground.off", "fly"]
[joints.wheel_pin]
type = "revolute"
between = ["ground", "wheel"]
[joints.guide]
type = "prismatic"
between = ["ground", "slide"]
axis = [1, 0]
[joints.coupling]
type = "{kind}"
{keys}
engaged = false
[initial]
"fly_pin.angle" = 0.4
"fly_pin.omega" = 10
"wheel_pin.angle" = -0.7
"wheel_pin.omega" = 0
"guide.s" = 0.2
"guide.v" = 0
[events.catch]
when = "t > 0.3"
engage = ["coupling"]
[events.let_go]
when = "t > 0.6"
release = ["coupling"]
[experiment]
stop = 1
"#
        );
        let impulse = ratio * 10.0 / (1.0 / second + ratio * ratio / 0.2);
        let [fast, slow] = [10.0 - ratio * impulse / 0.2, impulse / second];
        let turns = second == 0.1;
        let [place, rate] = if turns { ["wheel_pin.angle", "wheel_pin.omega"] } else { ["guide.s", "guide.v"] };
        let start = if turns { -0.7 } else { 0.2 };
        let values = [
            (0.2, "fly_pin.omega", 10.0),
            (0.2, rate, 0.0),
            (0.5, "fly_pin.omega", fast),
            (0.5, "fly_pin.angle", 3.4 + 0.2 * fast),
            (0.5, rate, slow),
            (0.5, place, start + 0.2 * slow),
            (0.5, "coupling.impulse", impulse),
            (0.5, "coupling.lost_energy", 0.5 * impulse * ratio * 10.0),
            (0.9, "coupling.engaged", 0.0),
            (0.9, rate, slow),
        ];
        check(&text, &values, 1e-10);
    }
}

/// A sun and a planet on a carrier that turns with them mesh where they stand: momentum about the pin is kept, and the relation of the angles from then on.
#[test]
fn gears_engage_on_a_carrier_that_turns() {
    let text = r#"
name = "planetary"
[bodies.arm]
mass = 2
inertia = 0.3
points = { end = [0.5, 0] }
[bodies.sun]
mass = 1
inertia = 0.1
[bodies.planet]
mass = 0.5
inertia = 0.02
[joints.arm_pin]
type = "revolute"
between = ["ground", "arm"]
[joints.sun_pin]
type = "revolute"
between = ["ground", "sun"]
[joints.planet_pin]
type = "revolute"
between = ["arm.end", "planet"]
[joints.mesh]
type = "gear"
between = ["sun", "planet"]
carrier = "arm"
ratio = -2
engaged = false
[initial]
"arm_pin.angle" = 0.3
"arm_pin.omega" = 1.5
"sun_pin.angle" = 0.1
"sun_pin.omega" = 4
"planet_pin.angle" = -0.6
"planet_pin.omega" = 0.5
[events.catch]
when = "t > 0.25"
engage = ["mesh"]
[experiment]
stop = 1
"#;
    let names = [
        "arm.omega",
        "sun.omega",
        "planet.omega",
        "arm.angle",
        "sun.angle",
        "planet.angle",
        "energy.kinetic",
        "mesh.lost_energy",
    ];
    let model = run::model(&reporting(text, &names));
    let mut instance = run::started(&model, None, 1.0, 1e-11);
    let mut at = |time: f64| {
        instance.step_to(time).unwrap();
        names.map(|name| run::value(&mut instance, name))
    };
    let [before, after, later] = [0.2, 0.3, 0.9].map(&mut at);
    let momentum = |all: [f64; 8]| (0.3 + 0.5 * 0.25) * all[0] + 0.1 * all[1] + 0.02 * all[2];
    let relation = |all: [f64; 8]| all[5] - all[3] + 2.0 * (all[4] - all[3]);
    assert!((momentum(before) - momentum(after)).abs() < 1e-12, "{before:?} {after:?}");
    assert!((before[6] - after[6] - after[7]).abs() < 1e-12 && after[7] > 0.01, "{before:?} {after:?}");
    assert!((after[2] - after[0] + 2.0 * (after[1] - after[0])).abs() < 1e-12, "{after:?}");
    assert!((relation(later) - relation(after)).abs() < 1e-11, "{after:?} {later:?}");
}

/// The event that releases asks for the time of the one that engages: before that has happened it holds, so it happens at the start, where it releases nothing, and again when it is meant to.
#[test]
fn a_release_that_waits_for_the_engagement_releases_nothing_before_it() {
    let part = "[events.part]\nwhen = \"t > events.meet.time + 0.25\"\nrelease = [\"coupling\"]\n";
    let rod = r#"{ type = "distance", between = ["a", "b"], engaged = false }"#;
    let values = [
        (0.3, "events.part.time", 0.0),
        (0.5, "coupling.engaged", 1.0),
        (0.5, "events.meet.time", 0.4),
        (0.7, "events.part.time", 0.65),
        (0.7, "coupling.engaged", 0.0),
    ];
    check(&carts(rod, &format!("{MEET}{part}")), &values, 1e-11);
}

/// A rod between two arms on one line with their pins would hold what the loop holds in that pose already: refused with its name and the time, and not closed.
#[test]
fn what_engages_in_a_singular_pose_is_refused() {
    let text = r#"
name = "singular"
[ground.points]
far = [2, 0]
[bodies.left]
mass = 1
inertia = 0.1
points = { tip = [1, 0] }
[bodies.right]
mass = 1
inertia = 0.1
points = { tip = [-1, 0] }
[joints.a]
type = "revolute"
between = ["ground", "left"]
[joints.b]
type = "revolute"
between = ["ground.far", "right"]
[joints.hook]
type = "revolute"
between = ["left.tip", "right.tip"]
engaged = false
[initial]
"a.angle" = 0
"a.omega" = 1
"b.angle" = 0
"b.omega" = -0.5
[events.catch]
when = "t > 0"
engage = ["hook"]
[experiment]
stop = 1
"#;
    let model = run::model(text);
    let told = run::started(&model, None, 1.0, 1e-9).step_to(0.5).unwrap_err().to_string();
    assert!(told.contains("`hook`") && told.contains("constraints are redundant"), "{told}");
}
