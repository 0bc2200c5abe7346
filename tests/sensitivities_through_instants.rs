//! Derivatives through impacts, openings and closings, events and ticks: closed forms, sixth-order differences of whole runs, and what is refused.

use crate::dry_friction::STICK_SLIP;
use crate::sensitivities::{check, refused};

use cotree::Scene;
use cotree::report::csv::CsvTable;
use cotree::scene::Requested;
use cotree_study::analysis::{FeatureKind, Study};
use cotree_study::fit::{FitRequest, Vary, fit};

/// A ball that is dropped; its height, rate and the impulse of the last impact are known until it rests.
const BALL: &str = r#"
name = "ball"
gravity = [0, -9.81]
[parameters]
share = 0.8
drop = 1.0
weight = 2.0
level = 0.0
[bodies.ball]
mass = "weight"
[ground.points]
pad = [0, "level"]
[joints.rail]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
[joints.pad]
type = "contact"
between = ["ground.pad", "ball"]
axis = [1, 0]
restitution = "share"
[initial]
"rail.s" = "drop"
"rail.v" = 0.0
[outputs]
variables = ["ball.y", "ball.vy", "pad.gap", "pad.impulse"]
[experiment]
stop = "3 s"
tolerance = 1e-11
"#;

#[test]
fn a_ball_follows_its_closed_form() {
    let names = ["share", "drop", "weight", "level"].map(str::to_owned);
    let found = Study::new(&Scene::from_toml(BALL).unwrap()).unwrap().sensitivities(&names, &[1.0, 1.7]).unwrap();
    let (g, e, m) = (9.81_f64, 0.8_f64, 2.0_f64);
    // After k impacts with first time T: begin = T (1 + 2 (e + ... + e^(k-1))), rate g T e^k; T = sqrt(2 (drop - floor)/g).
    for (row, (time, impacts)) in [(1.0_f64, 1), (1.7, 2)].into_iter().enumerate() {
        let height = |e: f64, drop: f64, floor: f64| {
            let fall = (2.0 * (drop - floor) / g).sqrt();
            let flights: f64 = (1..impacts).map(|flight| 2.0 * e.powi(flight)).sum();
            let (since, rate) = (time - fall * (1.0 + flights), g * fall * e.powi(impacts));
            [floor + rate * since - 0.5 * g * since * since, rate - g * since, m * (1.0 + e) * rate / e]
        };
        let own = height(e, 1.0, 0.0);
        for (output, own) in [0, 1, 3].into_iter().zip(own) {
            assert!((found.values[row][output] - own).abs() < 1e-10, "{row} {output}: {own}");
        }
        let step = 1e-5;
        let slope = |at: &dyn Fn(f64) -> [f64; 3]| {
            let (up, down) = (at(step), at(-step));
            std::array::from_fn::<f64, 3, _>(|place| (up[place] - down[place]) / (2.0 * step))
        };
        let exact = [
            slope(&|by| height(e + by, 1.0, 0.0)),
            slope(&|by| height(e, 1.0 + by, 0.0)),
            [0.0, 0.0, own[2] / m],
            slope(&|by| height(e, 1.0, by)),
        ];
        for (column, exact) in exact.iter().enumerate() {
            for (place, output) in [0, 1, 3].into_iter().enumerate() {
                let value = found.derivatives[row][(output, column)];
                assert!(
                    (value - exact[place]).abs() < 2e-8 * exact[place].abs().max(1.0),
                    "{row} {output} {column}: {value} {exact:?}"
                );
            }
        }
    }
}

#[test]
fn a_ball_comes_to_rest_on_its_pad_whatever_it_bounces() {
    check(BALL, &["share", "drop"], 2.2, 1e-4, 1e-8);
    let names = ["share", "drop", "weight", "level"].map(str::to_owned);
    let found = Study::new(&Scene::from_toml(BALL).unwrap()).unwrap().sensitivities(&names, &[5.0]).unwrap();
    for column in 0..names.len() {
        let [height, rate] = [0, 1].map(|output| found.derivatives[0][(output, column)]);
        let right = if column == 3 { 1.0 } else { 0.0 };
        assert!((height - right).abs() < 1e-12 && rate.abs() < 1e-12, "{column}: {height} {rate}");
    }
}

/// A stone that is thrown along a rough floor: it bounces with friction, slides, and stops.
const STONE: &str = r#"
name = "stone"
gravity = [0, -9.81]
[parameters]
mu = 0.2
share = 0.6
drop = 0.5
speed = 6.0
weight = 2.0
[bodies.stone]
mass = "weight"
[joints.carriage]
type = "prismatic"
between = ["ground", "sledge"]
axis = [1, 0]
[bodies.sledge]
mass = 0
inertia = 0
[joints.lift]
type = "prismatic"
between = ["sledge", "stone"]
axis = [0, 1]
[joints.floor]
type = "contact"
between = ["ground", "stone"]
axis = [1, 0]
restitution = "share"
friction = { mu = "mu" }
[initial]
"stone.x" = 0.0
"stone.y" = "drop"
"stone.vx" = "speed"
"stone.vy" = 0.0
[outputs]
variables = ["stone.x", "stone.vx", "stone.y", "stone.vy"]
[experiment]
stop = "5 s"
tolerance = 1e-11
"#;

/// Height and rate of a ball that is dropped.
fn bounce(e: f64, drop: f64, time: f64) -> [f64; 2] {
    let g = 9.81_f64;
    let fall = (2.0 * drop / g).sqrt();
    if time >= fall * (1.0 + e) / (1.0 - e) {
        return [0.0; 2];
    }
    let (mut begin, mut rate) = (-fall, g * fall);
    while time >= begin + 2.0 * rate / g {
        (begin, rate) = (begin + 2.0 * rate / g, e * rate);
    }
    [rate * (time - begin) - 0.5 * g * (time - begin).powi(2), rate - g * (time - begin)]
}

/// The momentum balance holds whatever the floor does: while it slides, m vx = m speed - mu P and m vy = P - m g t, so vx = speed - mu (vy + g t) and x = speed t - mu (y - drop + g t^2/2), through all bounces and behind their end.
fn thrown([mu, e, drop, speed]: [f64; 4], time: f64) -> [f64; 4] {
    let g = 9.81_f64;
    let at = time.min(speed / (mu * g));
    let ([y, vy], [height, rate]) = (bounce(e, drop, time), bounce(e, drop, at));
    [speed * at - mu * (height - drop + 0.5 * g * at * at), speed - mu * (rate + g * at), y, vy]
}

#[test]
fn a_stone_bounces_slides_and_stops_with_friction() {
    let names = ["mu", "share", "drop", "speed", "weight"].map(str::to_owned);
    let times = [0.3, 0.5, 1.0, 1.24, 1.28, 2.0, 2.9, 4.0];
    let found = Study::new(&Scene::from_toml(STONE).unwrap()).unwrap().sensitivities(&names, &times).unwrap();
    let here = [0.2, 0.6, 0.5, 6.0];
    for (row, &time) in times.iter().enumerate() {
        for (output, right) in thrown(here, time).into_iter().enumerate() {
            assert!((found.values[row][output] - right).abs() < 1e-9, "{time} {output}: {right}");
        }
        for column in 0..5 {
            let exact: [f64; 4] = std::array::from_fn(|output| {
                let at = |by: f64| {
                    let mut values = here;
                    values.iter_mut().skip(column).take(1).for_each(|value| *value += by);
                    thrown(values, time)[output]
                };
                let step = 1e-4;
                (8.0 * (at(step) - at(-step)) - at(2.0 * step) + at(-2.0 * step)) / (12.0 * step)
            });
            for (output, exact) in exact.into_iter().enumerate() {
                let value = found.derivatives[row][(output, column)];
                assert!(
                    (value - exact).abs() < 1e-6 * exact.abs().max(1.0),
                    "{time} {output} {column}: {value}, not {exact}"
                );
            }
        }
    }
}

/// A coefficient of friction and a speed are found from where the closed form says that the stone is, from its first bounce to rest.
#[test]
fn friction_is_fitted_through_bounces() {
    let times: Vec<f64> = (0..80).map(|step| 0.05 * f64::from(step)).collect();
    let seen = times.iter().map(|&time| thrown([0.2, 0.6, 0.5, 6.0], time)[0]).collect();
    let table = CsvTable::new(vec!["stone.x".to_owned()], times, vec![seen]).unwrap();
    let guessed = STONE.replace("mu = 0.2", "mu = 0.27").replace("speed = 6.0", "speed = 5.5");
    let vary = ["mu", "speed"].iter().map(|name| Vary::read(name).unwrap()).collect();
    let mut study = Study::asking(&Scene::from_toml(&guessed).unwrap(), &Requested::these(["stone.x"])).unwrap();
    let request = FitRequest { tables: vec![table], vary, deviations: Vec::new() };
    let found = fit(std::slice::from_mut(&mut study), &request).unwrap();
    for (quantity, right) in found.quantities.iter().zip([0.2, 6.0]) {
        assert!((quantity.value - right).abs() < 1e-7, "{}, not {right}", quantity.value);
    }
}

/// Arms whose pins rub in proportion to their reactions strike their stops.
#[test]
fn arms_with_friction_in_their_pins_strike_their_stops() {
    let rough = ARMS
        .replace("weight = 1.2", "weight = 1.2\nmu = 0.15")
        .replace(
            "between = [\"ground\", \"upper.root\"]",
            "between = [\"ground\", \"upper.root\"]\nfriction = { mu = \"mu\", radius = 0.02 }",
        )
        .replace(
            "between = [\"upper.tip\", \"lower.root\"]",
            "between = [\"upper.tip\", \"lower.root\"]\nfriction = { mu = \"mu\", radius = 0.01 }",
        );
    check(&rough, &["mu", "share", "weight", "length"], 0.5, 1e-4, 1e-6);
}

/// A hand that slides by takes a part from its two feet, or pushes it down on them: with friction, and with a mass that counts.
const TAKEN: &str = r#"
name = "taken"
gravity = [0, -9.81]
[parameters]
mu = 0.25
heavy = 0.7
pull = 25.0
late = 0.2
lift = 0.4
[bodies]
hand = { mass = 1.0, inertia = 0.01, points = { t = [0, -0.1] } }
part = { mass = "heavy", inertia = 0.005, points = { l = [-0.1, -0.05], r = [0.1, -0.05], top = [0, 0.05] } }
[joints]
fl = { type = "contact", between = ["ground", "part.l"], axis = [1, 0], friction = { mu = "mu" } }
fr = { type = "contact", between = ["ground", "part.r"], axis = [1, 0], friction = { mu = "mu" } }
guide = { type = "prismatic", between = ["ground", "hand"], axis = [1, 0.3] }
grip = { type = "weld", between = ["hand.t", "part.top"], engaged = false }
[loads.up]
type = "force"
on = "hand"
vector = [1.0, "pull"]
[events.grab]
when = "t > late"
engage = ["grip"]
once = true
[initial]
"guide.s" = 0.2
"guide.v" = "lift"
"part.x" = 0
"part.y" = 0.05
"part.angle" = 0
"part.vx" = 1.1
"part.vy" = 0
"part.omega" = 0
[outputs]
variables = ["part.x", "part.y", "part.vx", "hand.y", "grip.impulse_x", "grip.impulse_y", "grip.lost_energy"]
[experiment]
stop = 0.6
tolerance = 1e-12
"#;

#[test]
fn derivatives_go_through_a_grip_of_what_lies_on_feet() {
    check(TAKEN, &["mu", "heavy", "pull", "late", "lift"], 0.5, 1e-4, 1e-6);
    // At rest, and with a hand at rest, other values lift it or press it down.
    let still = TAKEN
        .replace("axis = [1, 0.3]", "axis = [0, 1]")
        .replace("\"part.vx\" = 1.1", "\"part.vx\" = 0")
        .replace("[1.0, \"pull\"]", "[0.0, \"9.81 + pull - 25\"]")
        .replace("lift = 0.4", "lift = 0");
    let message = refused(&still, "lift", 0.5);
    assert!(message.contains("derivatives differ on both sides"), "{message}");
}

/// Two arms that swing between stops.
const ARMS: &str = r#"
name = "arms"
gravity = [0, -9.81]
[parameters]
stop = "35 deg"
share = 0.7
length = 0.5
weight = 1.2
[bodies.upper]
mass = 2.0
inertia = 0.1
points = { root = [-0.4, 0], tip = ["length", 0] }
[bodies.lower]
mass = "weight"
inertia = 0.04
points = { root = [-0.3, 0.05] }
[joints.shoulder]
type = "revolute"
between = ["ground", "upper.root"]
[joints.elbow]
type = "revolute"
between = ["upper.tip", "lower.root"]
limits = { min = "-20 deg", max = "stop", restitution = "share" }
[initial]
"upper.angle" = -0.3
"upper.omega" = 0.0
"elbow.angle" = 0.2
"elbow.omega" = -1.0
[outputs]
variables = ["upper.angle", "upper.omega", "lower.angle", "lower.y", "elbow.impulse", "elbow.stop"]
[experiment]
stop = "0.9 s"
tolerance = 1e-12
"#;

#[test]
fn arms_strike_their_stops_again_and_again() {
    let names = ["stop", "share", "length", "weight", "upper.angle", "elbow.omega"];
    check(ARMS, &names, 0.9, 1e-4, 1e-7);
    // By Runge-Kutta steps, and without a rebound: it stays at the stop until it is pulled away.
    let explicit = ARMS.replace("[experiment]", "[solver]\nmethod = \"explicit\"\n[experiment]");
    check(&explicit, &["stop", "upper.angle"], 0.6, 1e-4, 1e-6);
    let plastic = ARMS.replace("share = 0.7", "share = 0.0");
    check(&plastic, &["stop", "length", "weight", "upper.angle"], 0.9, 1e-4, 1e-7);
}

/// A slider-crank whose motor runs it against a stop of its guide.
#[test]
fn a_slider_crank_strikes_a_stop() {
    let text = crate::support::fine::model("end_stop");
    check(&text, &["travel", "restitution", "torque", "crank.angle"], 0.5, 1e-4, 1e-7);
}

/// A stone in a sling: the rope becomes taut, with a part of the impact coming back.
const SLING: &str = r#"
name = "sling"
gravity = [0, -9.81]
[parameters]
length = 1.2
share = 0.4
push = 1.5
[bodies.stone]
mass = 0.7
[bodies.post]
mass = 2.0
inertia = 0.3
points = { top = [0, 0.8], foot = [0, 0] }
[joints.base]
type = "revolute"
between = ["ground", "post.foot"]
[joints.cord]
type = "rope"
between = ["post.top", "stone"]
length = "length"
restitution = "share"
[loads.root]
type = "torsion_spring"
between = ["ground", "post"]
stiffness = 60.0
angle = 0.0
[initial]
"post.angle" = 0.1
"post.omega" = 0.0
"stone.x" = 0.5
"stone.y" = 0.9
"stone.vx" = "push"
"stone.vy" = 0.5
"stone.angle" = 0.0
"stone.omega" = 0.0
[outputs]
variables = ["stone.x", "stone.y", "post.angle", "post.omega", "cord.impulse"]
[experiment]
stop = "1 s"
tolerance = 1e-12
"#;

#[test]
fn a_rope_becomes_taut() {
    check(SLING, &["length", "share", "push", "post.angle"], 0.56, 1e-5, 1e-6);
}

/// A box on a table that shakes harder and harder: it lifts off, flies and falls back without a rebound.
const TABLE: &str = r#"
name = "table"
gravity = [0, -9.81]
[parameters]
height = 0.012
weight = 0.9
rate = 24.0
[bodies.table]
mass = 5.0
[bodies.box]
mass = "weight"
[joints.guide]
type = "prismatic"
between = ["ground", "table"]
axis = [0, 1]
[joints.rail]
type = "prismatic"
between = ["ground", "box"]
axis = [0, 1]
[joints.top]
type = "contact"
between = ["table", "box"]
axis = [1, 0]
[loads.shaker]
type = "force"
on = "table"
vector = [0, "58[N] + 20000[N/m]*(height*1[m]*sin(rate*t*1[1/s]) - table.y) - 300[N.s/m]*table.vy"]
[initial]
"guide.s" = 0.0
"guide.v" = 0.0
"rail.s" = 0.0
"rail.v" = 0.0
[outputs]
variables = ["table.y", "box.y", "box.vy", "top.fn"]
[experiment]
stop = "0.6 s"
tolerance = 1e-12
"#;

#[test]
fn a_box_lifts_off_a_shaking_table_and_lands() {
    check(TABLE, &["height"], 0.42, 1e-6, 1e-6);
    check(TABLE, &["weight", "rate"], 0.42, 1e-5, 1e-6);
}

/// A block that a computer holds in place, with a bound and an integral.
const SERVO: &str = r#"
name = "servo"
[parameters]
gain = 60.0
goal = "0.25 m"
rhythm = "12 ms"
first = "3 ms"
[bodies.block]
mass = 1.5
[joints.rail]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[sampled.controller]
period = "rhythm"
offset = "first"
[sampled.controller.values]
error = { start = "goal - rail.s", next = "goal - rail.s", unit = "m" }
sum = { start = 0, next = "sum + rhythm*new(error)/1[m.s]" }
push = { start = 0, next = "min(7[N], gain*1[N/m]*new(error) + 90[N]*new(sum) - 9[N.s/m]*rail.v)", unit = "N" }
[loads.drive]
type = "force"
on = "block"
vector = ["push", 0]
[loads.drag]
type = "spring"
between = ["ground", "block.hook"]
stiffness = 5.0
length = 0.3
[initial]
"rail.s" = 0.05
"rail.v" = 0.0
[outputs]
variables = ["rail.s", "rail.v", "push", "sum"]
[experiment]
stop = "0.5 s"
tolerance = 1e-12
"#;

#[test]
fn a_sampled_controller_passes_its_derivatives_from_tick_to_tick() {
    let text = SERVO.replace("mass = 1.5", "mass = 1.5\npoints = { hook = [0, 0.2] }");
    check(&text, &["gain", "goal", "rail.s"], 0.5, 1e-5, 1e-7);
    // The ticks themselves move with the period, and with the first one.
    check(&text, &["rhythm", "first"], 0.4, 1e-6, 1e-5);
}

/// A mass on a spring that lets go at a force, counts what it passes, and pushes harder from then on.
const LATCH: &str = r#"
name = "latch"
gravity = [0, -9.81]
[parameters]
grip = "20 N"
stiffness = "300 N/m"
line = 0.3
[bodies.block]
mass = 1.0
points = { hook = [0, 0] }
[bodies.hammer]
mass = 0.4
inertia = 0.02
points = { root = [0, 0.3], head = [0, -0.1] }
[joints.rail]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
[joints.pin]
type = "revolute"
between = ["block", "hammer.root"]
[loads.band]
type = "spring"
between = ["ground.post", "block.hook"]
stiffness = "stiffness"
length = 0.1
[ground.points]
post = [0.2, 0.1]
[sampled.memory]
period = 1e3
offset = 1e3
values.passed = { start = "0.4 m", next = "passed", unit = "m" }
[events.release]
when = "band.force > grip"
remove = ["band"]
[events.line]
when = "rail.s > line*1[m]"
set = { passed = "0.1[m] + rail.v*0.3[s] + hammer.omega*0.01[m.s]" }
[loads.motor]
type = "force"
on = "block"
vector = ["30[N/m]*passed + 12[N]", 0]
[initial]
"rail.s" = 0.2
"rail.v" = 0.0
"hammer.angle" = 0.4
"hammer.omega" = 0.0
[outputs]
variables = ["rail.s", "rail.v", "hammer.angle", "passed", "events.line.time", "events.release.time"]
[experiment]
stop = "0.8 s"
tolerance = 1e-12
"#;

#[test]
fn events_remove_and_set_what_derivatives_go_through() {
    check(LATCH, &["grip", "stiffness", "line", "hammer.angle"], 0.8, 1e-4, 1e-7);
    // A joint is removed, too: the hammer flies off.
    let thrown = LATCH.replace("remove = [\"band\"]", "remove = [\"band\", \"pin\"]");
    check(&thrown, &["grip", "stiffness", "hammer.angle"], 0.6, 1e-4, 1e-7);
}

#[test]
fn what_has_no_derivatives_is_refused_by_name() {
    // Dropped at once onto two pads: a tilted start would strike one of them first.
    let twins = BALL
        .replace("[ground.points]", "[bodies.other]\nmass = 1.0\n[joints.second_rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"other\"]\naxis = [0, 1]\n[joints.second_pad]\ntype = \"contact\"\nbetween = [\"ground.pad\", \"other\"]\naxis = [1, 0]\n[ground.points]")
        .replace("\"rail.v\" = 0.0", "\"rail.v\" = 0.0\n\"second_rail.s\" = \"drop\"\n\"second_rail.v\" = 0.0");
    let message = refused(&twins, "share", 1.0);
    assert!(
        message.contains("`pad`") && message.contains("`second_pad`") && message.contains("at the same time"),
        "{message}"
    );
    // A tick at the instant of an impact.
    let ticking = BALL.replace(
        "[initial]",
        "[sampled.eye]\nperiod = \"sqrt(2*drop*1[m]/9.81[m/s2])\"\noffset = \"sqrt(2*drop*1[m]/9.81[m/s2])\"\nvalues.seen = { start = \"0 m\", next = \"ball.y\", unit = \"m\" }\n[initial]",
    );
    let message = refused(&ticking, "share", 1.0);
    assert!(
        message.contains("`pad`") && message.contains("a sample time of `eye`") && message.contains("at the same time"),
        "{message}"
    );
    // Beside drivers that determine the motion.
    let driven = SERVO
        .replace("mass = 1.5", "mass = 1.5\npoints = { hook = [0, 0.2] }")
        .replace("\"rail.s\" = 0.05\n\"rail.v\" = 0.0\n", "")
        .replace(
            "[loads.drive]",
            "[drivers.move]\njoint = \"rail\"\ndisplacement = \"0.1[m]*sin(t*1[rad/s])\"\n[loads.drive]",
        );
    let message = refused(&driven, "gain", 0.1);
    assert!(message.contains("drivers determine the motion"), "{message}");
    // It begins with an impact.
    let falling = BALL.replace("drop = 1.0", "drop = 0.0").replace("\"rail.v\" = 0.0", "\"rail.v\" = -1.0");
    let message = refused(&falling, "weight", 0.1);
    assert!(message.contains("starts with an impact of `pad`"), "{message}");
    // A ball that is thrown up just to a ceiling touches it.
    let ceiling = BALL
        .replace(
            "type = \"contact\"\nbetween = [\"ground.pad\", \"ball\"]\naxis = [1, 0]",
            "type = \"contact\"\nbetween = [\"ground.pad\", \"ball\"]\naxis = [-1, 0]",
        )
        .replace("level = 0.0", "level = 1.25")
        .replace("drop = 1.0", "drop = 0.0")
        .replace("\"rail.v\" = 0.0", "\"rail.v\" = \"sqrt(2*9.81[m/s2]*1.25[m])*(1 + 1e-13)\"");
    let message = refused(&ceiling, "weight", 1.0);
    assert!(message.contains("`pad`") && message.contains("touched without being crossed"), "{message}");
}

/// The fastest moment is the one just after the first impact: e g T, with T^2 = 2 drop/g.
#[test]
fn peaks_and_crossings_count_impacts() {
    let (g, e, fall) = (9.81_f64, 0.8_f64, (2.0 / 9.81_f64).sqrt());
    let mut study = Study::new(&Scene::from_toml(BALL).unwrap()).unwrap();
    let to = ["share".to_owned(), "drop".to_owned()];
    let found = study.features(&to, &[0.0, 1.0], &[("ball.vy".to_owned(), 0.0), ("ball.y".to_owned(), 0.3)]).unwrap();
    let named = |name: &str, kind: FeatureKind| {
        let all = found.features.iter().filter(|own| own.output.0 == name && own.kind == kind);
        all.map(|own| (own.time, own.value, own.changes.clone().unwrap())).collect::<Vec<_>>()
    };
    let fastest = &named("ball.vy", FeatureKind::Largest)[0];
    let near = |one: f64, other: f64| assert!((one - other).abs() < 1e-7, "{one} {other}");
    near(fastest.0, fall);
    near(fastest.1, e * g * fall);
    near(fastest.2.value[0], g * fall);
    near(fastest.2.value[1], e * g * fall / 2.0);
    near(fastest.2.time[0], 0.0);
    near(fastest.2.time[1], fall / 2.0);
    // The rate jumps over zero at the impact, and passes it at the top: T (1 + e).
    let zeros = named("ball.vy", FeatureKind::Crossing);
    let times: Vec<f64> = zeros.iter().map(|own| own.0).collect();
    near(times[times.len() - 2], fall);
    near(times[times.len() - 1], fall * (1.0 + e));
    near(zeros[zeros.len() - 1].2.time[0], fall);
    near(zeros[zeros.len() - 1].2.time[1], fall * (1.0 + e) / 2.0);
    // Down through 0.3 m: t = sqrt(2 (drop - 0.3)/g); its time does not know of the share.
    let down = &named("ball.y", FeatureKind::Crossing)[0];
    near(down.2.time[0], 0.0);
    near(down.2.time[1], 1.0 / (g * (2.0_f64 * 0.7 / g).sqrt()));
}

#[test]
fn values_are_fitted_through_impacts() {
    // A table of heights with 0.8 is fitted from 0.7: the same bounces, other times.
    let scene = Scene::from_toml(BALL).unwrap();
    let times: Vec<f64> = (0..100).map(|step| 0.02 * f64::from(step)).collect();
    let mut study = Study::new(&scene).unwrap();
    let to = ["share".to_owned(), "drop".to_owned()];
    let measured: Vec<f64> = study.sensitivities(&to, &times).unwrap().values.iter().map(|row| row[0]).collect();
    // A few steps of Gauss and Newton, in which the derivatives lead there only if they are right.
    let mut own = [0.78, 1.02];
    for _ in 0..8 {
        let found = study.varying(&to, |varying| varying.at(&own, &times)).unwrap();
        let rows = found.len();
        let gap = nalgebra::DVector::from_fn(rows, |row, _| measured[row] - found[row].0[0]);
        let slopes = nalgebra::DMatrix::from_fn(rows, 2, |row, column| found[row].1[(0, column)]);
        let normal = slopes.transpose() * &slopes;
        let step = normal.lu().solve(&(slopes.transpose() * gap)).unwrap();
        let share = (0.02 / step.amax()).min(1.0);
        own = [own[0] + share * step[0], own[1] + share * step[1]];
    }
    assert!((own[0] - 0.8).abs() < 1e-9 && (own[1] - 1.0).abs() < 1e-9, "{own:?}");
}

/// A block that is pushed off on a rough floor comes to rest v^2/(2 mu g) away, and stays there.
#[test]
fn what_slides_to_rest_stays_where_that_is() {
    let text = r#"
name = "shove"
gravity = [0, -9.81]
[parameters]
mu = 0.3
push = "1.4 m/s"
[bodies.block]
mass = 2.0
[joints.slide]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
friction = { mu = "mu" }
[initial]
"slide.s" = 0.0
"slide.v" = "push"
[outputs]
variables = ["slide.s", "slide.v", "slide.force"]
[experiment]
stop = "2 s"
tolerance = 1e-11
"#;
    let names = ["mu", "push"].map(str::to_owned);
    let found = Study::new(&Scene::from_toml(text).unwrap()).unwrap().sensitivities(&names, &[0.2, 0.9]).unwrap();
    let (g, mu, v) = (9.81, 0.3, 1.4);
    let exact = [[[-0.5 * g * 0.04, 0.2], [-g * 0.2, 1.0]], [[-v * v / (2.0 * mu * mu * g), v / (mu * g)], [0.0, 0.0]]];
    for (row, exact) in exact.iter().enumerate() {
        for (output, exact) in exact.iter().enumerate() {
            for (column, exact) in exact.iter().enumerate() {
                let value = found.derivatives[row][(output, column)];
                assert!((value - exact).abs() < 1e-8, "{row} {output} {column}: {value}, {exact}");
            }
        }
    }
    // Nothing holds it at the start with another push.
    let resting = text.replace("push = \"1.4 m/s\"", "push = \"0 m/s\"");
    let message = refused(&resting, "push", 0.1);
    assert!(message.contains("would start to slide"), "{message}");
    check(&resting, &["mu"], 0.5, 1e-4, 1e-9);
}

/// A block that a belt takes along until its spring pulls it off: sticks and slips, with a level at rest of its own.
#[test]
fn stick_and_slip_pass_their_derivatives_on() {
    let text = [
        ("mu = 0.25, static = 1.6", "mu = \"mu\", static = \"static\""),
        ("\"80 N/m\"", "\"stiffness\""),
        ("0.2*t", "speed*t"),
        ("\"block.x\" = 0.0", "\"block.x\" = 0.03"),
        ("\"slide.v\" = 0.0", "\"block.vx\" = 0.05"),
        ("\"slide.mode\", ", ""),
        (
            "[ground.points]",
            "[parameters]\nmu = 0.25\nstatic = 1.6\nstiffness = \"80 N/m\"\nspeed = \"0.2 m/s\"\n[ground.points]",
        ),
        ("tolerance = 1e-10", "tolerance = 1e-11"),
    ];
    let text = &text.into_iter().fold(STICK_SLIP.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    });
    check(text, &["mu", "stiffness"], 0.1, 1e-4, 1e-7);
    for time in [0.44, 1.0, 1.4, 3.3] {
        check(text, &["mu", "static", "stiffness", "speed"], time, 1e-4, 1e-7);
    }
    let explicit = text.replace("[experiment]", "[solver]\nmethod = \"implicit\"\n[experiment]");
    check(&explicit, &["mu", "stiffness"], 1.0, 1e-4, 1e-5);
}

/// Pins by the size of what they carry, a long guide by the signs of its two ends, and a limit that is reached while others rub by levels of their own.
#[test]
fn linkages_that_rub_pass_their_derivatives_on() {
    let slider_crank = |pin: &str, guide: &str, more: &str| {
        format!(
            r#"
name = "press"
gravity = [0, -9.81]
[parameters]
mu = 0.12
length = "0.1 m"
pull = "3 N.m"
[bodies.crank]
mass = 1.0
inertia = 0.01
points = {{ tip = ["length", 0] }}
[bodies.rod]
mass = 0.8
inertia = 0.008
points = {{ big = [-0.15, 0], small = [0.15, 0] }}
[bodies.slider]
mass = 2.0
inertia = 0.01
points = {{ pin = [0, 0.03] }}
[joints.main]
type = "revolute"
between = ["ground", "crank"]
{pin}
[joints.big]
type = "revolute"
between = ["crank.tip", "rod.big"]
{pin}
[joints.small]
type = "revolute"
between = ["rod.small", "slider.pin"]
[joints.guide]
type = "prismatic"
between = ["ground", "slider"]
axis = [1, 0]
{guide}
{more}
[loads.motor]
type = "torque"
on = "crank"
value = "pull*sin(3*t) - 1"
[initial]
"crank.angle" = 0.4
"crank.omega" = 2.0
"rod.angle" = {{ guess = -0.1 }}
[outputs]
variables = ["crank.angle", "crank.omega", "slider.x", "main.fx", "guide.fn"]
[experiment]
stop = 2.0
tolerance = 1e-11
"#
        )
    };
    let pins = slider_crank("friction = { mu = \"mu\", radius = 0.02 }", "", "");
    let guide = slider_crank("", "friction = { mu = \"mu\", length = 0.08 }", "");
    let stop = slider_crank("", "friction = { coulomb = \"10[N]*mu\" }\nlimits = { min = 0.3, restitution = 0.5 }", "");
    // The stop ends a series of bounces after 1.67 s.
    let both = slider_crank("", "friction = { mu = \"mu\" }\nlimits = { min = 0.3, restitution = 0.5 }", "");
    for text in [&pins, &guide, &stop, &both] {
        for time in [0.3, 1.1, 1.6] {
            check(text, &["mu", "length", "pull", "crank.omega"], time, 1e-5, 1e-6);
        }
    }
}

/// A ratchet that lets a wheel turn one way only: caught where it stands, let go where it is driven on.
#[test]
fn a_freewheel_passes_its_derivatives_on() {
    let text = r#"
name = "ratchet"
[parameters]
push = "2 N.m"
drag = 0.3
weight = 0.2
[bodies.wheel]
mass = 1.0
inertia = "weight"
[bodies.rim]
mass = 1.0
inertia = 0.5
[joints.pin]
type = "revolute"
between = ["ground", "wheel"]
[joints.bearing]
type = "revolute"
between = ["ground", "rim"]
[joints.wheel_and_rim]
type = "one_way"
between = ["wheel", "rim"]
[loads.motor]
type = "torque"
on = "wheel"
value = "push*sin(4*t) - drag*wheel.omega"
[loads.brake]
type = "torque"
on = "rim"
value = "-drag*rim.omega"
[initial]
"wheel.angle" = 0.0
"wheel.omega" = 0.5
"rim.angle" = 0.0
"rim.omega" = 1.0
[outputs]
variables = ["wheel.angle", "wheel.omega", "rim.angle", "rim.omega"]
[experiment]
stop = 4.0
tolerance = 1e-11
"#;
    for time in [0.4, 1.5, 3.7] {
        check(text, &["push", "drag", "weight", "rim.omega"], time, 1e-5, 1e-6);
    }
}

/// An arm that grips a flying disc where it is then, is struck while it carries it, and lets it go; a state is reset on the way.
const GRIPPED: &str = r#"
name = "gripped"
gravity = [0, -9.81]
[parameters]
reach = 0.1
speed = 2.0
heavy = 0.5
blow = 0.4
[bodies]
arm = { mass = 1, inertia = 0.1, com = [0.5, 0], points = { o = [0, 0], tip = [1, 0] } }
disc = { mass = "heavy", inertia = 0.002 }
[joints]
pin = { type = "revolute", between = ["ground", "arm.o"] }
grip = { type = "weld", between = ["arm.tip", "disc"], engaged = false }
[states]
turned = { start = 0, rate = "arm.omega" }
[events.catch]
when = "(disc.x - arm.tip.x)^2 + (disc.y - arm.tip.y)^2 < reach^2"
engage = ["grip"]
set = { turned = "0.5*turned + disc.x" }
once = true
[events.strike]
when = "turned > 0.05"
set = { "arm.omega" = "blow*arm.omega" }
once = true
[events.drop]
when = "arm.angle > -1.4"
release = ["grip"]
once = true
[initial]
"pin.angle" = "-90 deg"
"pin.omega" = 0
"disc.x" = -0.6
"disc.y" = -0.95
"disc.angle" = 0.1
"disc.vx" = "speed"
"disc.vy" = 1
"disc.omega" = 3
[outputs]
variables = ["arm.angle", "arm.omega", "disc.x", "disc.y", "disc.omega", "turned", "grip.impulse_x", "grip.impulse_torque", "grip.lost_energy"]
[experiment]
stop = "0.7 s"
tolerance = 1e-12
"#;

#[test]
fn derivatives_go_through_joints_that_engage() {
    for end in [0.3, 0.38, 0.7] {
        check(GRIPPED, &["reach", "speed", "heavy", "blow", "disc.y"], end, 1e-4, 1e-7);
    }
    let explicit = GRIPPED.replace("[experiment]", "[solver]\nmethod = \"explicit\"\n[experiment]");
    check(&explicit, &["reach", "heavy"], 0.7, 1e-4, 1e-6);
}

#[test]
fn a_run_that_an_event_ends_has_the_derivatives_of_its_end() {
    let scene = BALL.replace("[outputs]", "[events.low]\nwhen = \"ball.y < 0.5\"\nstop = true\n[outputs]");
    let names = ["drop", "weight"].map(str::to_owned);
    let mut study = Study::new(&Scene::from_toml(&scene).unwrap()).unwrap();
    let (found, end) = study.sensitivities_to_end(&names, &[0.1, 0.2, 1.0]).unwrap();
    // It falls by drop - 0.5: t = sqrt(2 (drop - 0.5) / g), and its rate is -g t.
    let g = 9.81_f64;
    let (time, end) = ((1.0 / g).sqrt(), end.unwrap());
    assert!((end.event.as_str(), found.times.len()) == ("low", 3) && (end.time - time).abs() < 1e-9, "{end:?}");
    assert_eq!(found.times[2], end.time);
    assert!((end.changes[0] - 1.0 / (g * time)).abs() < 1e-8 && end.changes[1].abs() < 1e-12, "{end:?}");
    let last = &found.derivatives[2];
    assert!(last[(0, 0)].abs() < 1e-8 && (last[(1, 0)] + 1.0 / time).abs() < 1e-8, "{last}");
    assert!((found.derivatives[1][(0, 0)] - 1.0).abs() < 1e-9, "at fixed time");
    let refused = study.sensitivities(&names, &[1.0]).unwrap_err().to_string();
    assert!(refused.contains("event `low` has ended the run"), "{refused}");
}

#[test]
fn rows_of_inputs_over_time_have_derivatives() {
    let scene = r#"
name = "cart"
dimension = 1
[inputs]
push = { start = 0.0, unit = "N" }
[bodies.c]
mass = 2.0
[loads.f]
type = "force"
on = "c"
vector = ["push"]
[initial]
"c.x" = 0.0
[outputs]
variables = ["c.x"]
[experiment]
stop = 2.0
tolerance = 1e-10
"#;
    let times = vec![0.2, 0.5, 1.0, 1.0, 1.6];
    let table = CsvTable::new(vec!["push".to_owned()], times.clone(), vec![vec![1.0, 3.0, 2.0, -1.0, 4.0]]).unwrap();
    let mut study = Study::new(&Scene::from_toml(scene).unwrap()).unwrap();
    study.set_inputs(table.clone()).unwrap();
    let names: Vec<String> = (0..5).map(|row| format!("push[{row}]")).collect();
    let found = study.sensitivities(&names, &[2.0]).unwrap();
    // x is the second integral of push/m, so its derivative is that of what is 1 in the row and straight from there to 0 in the rows beside it.
    for (column, derivative) in found.derivatives[0].iter().enumerate() {
        let unit = (0..5).map(|row| f64::from(u8::from(row == column))).collect();
        let unit = CsvTable::new(vec!["push".to_owned()], times.clone(), vec![unit]).unwrap();
        let steps = 200_000;
        let exact: f64 = (0..steps)
            .map(|step| (f64::from(step) + 0.5) * 2.0 / f64::from(steps))
            .map(|time| (2.0 - time) * unit.at(0, time).0)
            .sum::<f64>();
        let exact = exact * 2.0 / f64::from(steps) / 2.0;
        assert!((derivative - exact).abs() < 1e-8, "{column}: {derivative} {exact}");
    }
    study.set("push[4]", |_| Ok(0.0)).unwrap();
    let other = study.sensitivities(&names, &[2.0]).unwrap();
    let by_row = 4.0 * found.derivatives[0][(0, 4)];
    assert!((found.values[0][0] - other.values[0][0] - by_row).abs() < 1e-9, "it is linear in the rows");
    let refused = study.sensitivities(&["push[5]".to_owned()], &[2.0]).unwrap_err().to_string();
    assert!(refused.contains("`push[5]`: the table of inputs has the rows 0 to 4"), "{refused}");
}
