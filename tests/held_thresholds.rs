//! Events whose comparisons are held at their threshold, or compare what joints hold: how often they happen, when, and what the search for them costs.

use crate::one_sided::integrate_to_events;
use crate::support::run;
use cotree_fmu::instance::Instance;
use cotree_fmu::math::Random;
use cotree_fmu::program::Engine;

const ENGINES: [Option<Engine>; 3] = [None, Some(Engine::Dop853), Some(Engine::Radau)];

/// How often an event has happened.
fn count(instance: &Instance, event: &str) -> u32 {
    instance.events().find(|(name, _)| *name == event).unwrap_or_else(|| panic!("no event {event}")).1
}

/// One cart that brakes catches another one at a distance, which the coupling then holds.
#[derive(Clone, Copy, Debug)]
struct Catch {
    masses: [f64; 2],
    speed: f64,
    brake: f64,
    reach: f64,
    held_for: f64,
    /// Where both are on the rail.
    offset: f64,
}

impl Catch {
    fn random(seed: u64) -> Self {
        let mut random = Random::new(seed);
        Self {
            masses: [0.2 + random.unit(), 0.2 + 2.0 * random.unit()],
            speed: 2.0 + random.unit(),
            brake: 0.1 + 0.1 * random.unit(),
            reach: 0.05 + 0.3 * random.unit(),
            held_for: 0.2 + 0.5 * random.unit(),
            offset: [0.0, -0.37, 41.3, 1e3][seed as usize % 4],
        }
    }

    fn scene(&self, coupling: &str, near: &str) -> String {
        let Self { masses: [a, b], speed, brake, reach, held_for, offset } = self;
        let from = offset + 1.0;
        format!(
            r#"
name = "catch"
[bodies]
a = {{ mass = {a}, inertia = 1 }}
b = {{ mass = {b}, inertia = 1 }}
[joints]
rail_a = {{ type = "prismatic", between = ["ground", "a"], axis = [1, 0] }}
rail_b = {{ type = "prismatic", between = ["ground", "b"], axis = [1, 0] }}
coupling = {{ type = "{coupling}", between = ["a", "b"], engaged = false }}
[loads.brake]
type = "force"
on = "a"
vector = [{}, 0]
[events.couple_up]
when = "{near} < {reach}"
engage = ["coupling"]
[events.drop]
when = "t > events.couple_up.time + {held_for}"
release = ["coupling"]
[initial]
"rail_a.s" = {offset}
"rail_a.v" = {speed}
"rail_b.s" = {from}
"rail_b.v" = 0
[outputs]
variables = ["rail_a.s", "rail_a.v", "rail_b.s", "rail_b.v", "coupling.engaged"]
[experiment]
stop = 3
"#,
            -brake
        )
    }

    /// When they meet, and positions and speeds of both at a time behind the release.
    fn right(&self, time: f64) -> (f64, [f64; 4]) {
        let Self { masses: [a, b], speed, brake, reach, held_for, offset } = *self;
        let (deceleration, way) = (brake / a, 1.0 - reach);
        let meets = (speed - (speed * speed - 2.0 * deceleration * way).sqrt()) / deceleration;
        let together = a * (speed - deceleration * meets) / (a + b);
        let slower = brake / (a + b);
        let released = together - slower * held_for;
        let moved = together * held_for - 0.5 * slower * held_for * held_for;
        let rest = time - meets - held_for;
        let first = offset + way + moved + released * rest - 0.5 * deceleration * rest * rest;
        let second = offset + 1.0 + moved + released * rest;
        (meets, [first, released - deceleration * rest, second, released])
    }
}

/// A coupling that holds the distance at which it engages does so once, is released when it is meant to, and both go on as closed forms say.
fn catches(seeds: std::ops::Range<u64>) {
    let mut runs = 0;
    for seed in seeds {
        let catch = Catch::random(seed);
        for (coupling, near) in
            [("weld", "b.x - a.x"), ("distance", "hypot(b.x - a.x, b.y - a.y)"), ("weld", "rail_b.s - rail_a.s")]
        {
            let model = run::model(&catch.scene(coupling, near));
            for engine in ENGINES {
                let mut instance = run::started(&model, engine, 3.0, 1e-9);
                let (meets, right) = catch.right(2.0);
                for step in 1..=8 {
                    instance.step_to(0.25 * f64::from(step)).unwrap_or_else(|error| panic!("{catch:?}: {error}"));
                }
                let what = format!("{catch:?} {coupling} {near} by {engine:?}");
                assert_eq!(count(&instance, "couple_up"), 1, "{what}");
                let time = run::value(&mut instance, "events.couple_up.time");
                assert!((time - meets).abs() < 1e-8, "{what}: {time}, not {meets}");
                let time = run::value(&mut instance, "events.drop.time");
                assert!((time - meets - catch.held_for).abs() < 1e-8, "{what}: {time}");
                for (name, right) in ["rail_a.s", "rail_a.v", "rail_b.s", "rail_b.v"].into_iter().zip(right) {
                    let found = run::value(&mut instance, name);
                    assert!((found - right).abs() < 1e-7, "{what}: {name} is {found}, not {right}");
                }
                runs += 1;
            }
        }
    }
    eprintln!("{runs} catches");
}

#[test]
fn what_engages_at_a_threshold_that_it_then_holds_does_so_once() {
    catches(0..4);
}

#[test]
#[ignore = "60 of them: .ci/nightly"]
fn many_catches_happen_once() {
    catches(0..60);
}

/// An importer that integrates, with steps of its own and errors of its own, enters event mode for what happens, and not for what is held at its threshold.
#[test]
fn an_integrator_outside_sees_each_catch_once() {
    for seed in 0..4 {
        let catch = Catch::random(seed);
        let mut outside = Instance::new(run::model(&catch.scene("weld", "b.x - a.x")));
        outside.setup(0.0, None, Some(1e-8)).unwrap();
        let entered = integrate_to_events(&mut outside, 2.0, 5e-3);
        assert_eq!(count(&outside, "couple_up"), 1, "{catch:?}: {entered}");
        assert!(entered <= 12, "{catch:?}: {entered}");
        let (_, right) = catch.right(2.0);
        for (name, right) in ["rail_a.s", "rail_a.v", "rail_b.s", "rail_b.v"].into_iter().zip(right) {
            let found = run::value(&mut outside, name);
            assert!((found - right).abs() < 1e-6, "{catch:?}: {name} is {found}, not {right}");
        }
    }
}

/// A slider-crank with an event that compares something, and nothing else.
fn watched(when: &str) -> String {
    format!(
        r#"
name = "watchdog"
gravity = [0, -9.81]
[bodies.crank]
mass = 0.3
inertia = 3e-4
points = {{ a = [-0.05, 0], b = [0.05, 0] }}
[bodies.rod]
mass = 0.5
inertia = 4e-3
points = {{ b = [-0.2, 0], c = [0.2, 0] }}
[bodies.slider]
mass = 0.4
inertia = 1e-4
[joints]
A = {{ type = "revolute", between = ["ground", "crank.a"] }}
B = {{ type = "revolute", between = ["crank.b", "rod.b"] }}
C = {{ type = "revolute", between = ["rod.c", "slider"] }}
G = {{ type = "prismatic", between = ["ground", "slider"], axis = [1, 0] }}
[initial]
"crank.angle" = "40 deg"
"rod.angle" = {{ guess = "-10 deg" }}
[events.watch]
when = "{when}"
stop = true
[outputs]
variables = ["crank.angle"]
[experiment]
stop = 1
"#
    )
}

/// What joints hold is zero but for rounding errors: a comparison of it is as cheap as one that is far from its threshold, which costs twenty evaluations a step, and does not happen.
#[test]
fn comparisons_of_what_joints_hold_cost_no_more_than_others() {
    let work = |when: &str, engine: Option<Engine>, tolerance: f64| {
        let mut instance = run::started(&run::model(&watched(when)), engine, 1.0, tolerance);
        instance.step_to(1.0).unwrap_or_else(|error| panic!("{when} by {engine:?} at {tolerance}: {error}"));
        assert_eq!(count(&instance, "watch"), 0, "{when} by {engine:?} at {tolerance}");
        instance.statistics().work as f64
    };
    for engine in ENGINES {
        for tolerance in [1e-6, 1e-9] {
            let usual = work("slider.x > 1", engine, tolerance);
            for held in ["constraint.position > 1e-5", "constraint.position > 1e-4", "1e3*constraint.position > 0.5"] {
                let ratio = work(held, engine, tolerance) / usual;
                assert!(ratio < 5.0, "{held} by {engine:?} at {tolerance}: {ratio}");
            }
        }
    }
}

/// A sliding ladder leaves the wall where sin(angle) falls to two thirds of what it was; until then the gap is rounding errors of metres.
#[test]
fn the_gap_of_a_wall_is_watched_at_the_cost_of_a_length() {
    let ladder = |when: &str| {
        format!(
            r#"
name = "ladder"
gravity = [0, -9.81]
[bodies.ladder]
mass = 10
inertia = "10*16/12"
points = {{ foot = [-2, 0], top = [2, 0] }}
[joints.sole]
type = "contact"
between = ["ground", "ladder.foot"]
axis = [1, 0]
[joints.wall]
type = "contact"
between = ["ground", "ladder.top"]
axis = [0, -1]
[initial]
"ladder.angle" = "110 deg"
"ladder.x" = "-2*cos(110[deg])"
"ladder.y" = "2*sin(110[deg])"
[events.leaves]
when = "{when}"
once = true
stop = false
set = {{ seen = 1 }}
[sampled.n]
period = 1e6
[sampled.n.values]
seen = {{ start = 0 }}
[outputs]
variables = ["ladder.angle", "wall.gap"]
[experiment]
stop = 1.2
"#
        )
    };
    let run = |when: &str, stop: f64| {
        let mut instance = run::started(&run::model(&ladder(when)), None, 1.2, 1e-9);
        instance.step_to(stop).unwrap();
        instance
    };
    let [held, usual] = ["wall.gap > 1e-4", "ladder.x > 10"].map(|when| run(when, 0.84).statistics().work as f64);
    assert!(held < 5.0 * usual, "{held} {usual}");
    let mut instance = run("wall.gap > 1e-4", 1.0);
    assert_eq!(count(&instance, "leaves"), 1);
    let at = run::value(&mut instance, "events.leaves.time");
    assert!((run::value(&mut run("wall.gap > 1e-4", at), "wall.gap") - 1e-4).abs() < 1e-9);
}

/// A comparison that jumps a million times in a step is refused by its name.
#[test]
fn a_comparison_that_jumps_everywhere_is_refused_by_name() {
    let mut instance = run::started(&run::model(&watched("floor(1e7*slider.x) - 1e7*slider.x > 0.5")), None, 1.0, 1e-6);
    let told = instance.step_to(1.0).unwrap_err().to_string();
    assert!(told.contains("`watch`") && told.contains("discontinuous"), "{told}");
}

/// A sample time that is the stop but for rounding errors, on either side: implicit runs end there, and the value sampled last is the one at that time. The block follows v' = -4 s(k T).
#[test]
fn runs_end_at_a_sample_time_that_is_the_stop_time_but_for_rounding() {
    let (mut beyond, mut before) = (0, 0);
    for (period, number) in (1..40).flat_map(|number| [0.05, 0.1, 0.07, 1.0 / 3.0].map(|period| (period, number))) {
        let tick = period * f64::from(number);
        for stop in [tick.next_down(), tick.next_up()] {
            if number > 12 && (stop * 1e4).round() / 1e4 != stop {
                continue;
            }
            (beyond, before) = if tick > stop { (beyond + 1, before) } else { (beyond, before + 1) };
            sampled_block(period, number, stop);
        }
    }
    assert!(beyond > 10 && before > 10);
}

fn sampled_block(period: f64, number: i32, stop: f64) {
    let scene = format!(
        r#"
name = "block"
[bodies]
block = {{ mass = 1 }}
[joints.rail]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
limits = {{ max = 50 }}
[loads.push]
type = "force"
on = "block"
vector = ["u", 0]
[sampled.controller]
period = {period:?}
[sampled.controller.values]
u = {{ start = 0, next = "-4*rail.s", unit = "N" }}
[initial]
"rail.s" = 1
"rail.v" = 0
[outputs]
variables = ["rail.s", "rail.v", "u"]
[experiment]
stop = {stop:?}
"#
    );
    let model = run::model(&scene);
    let [mut position, mut rate] = [1.0, 0.0];
    for _ in 0..number {
        let push = -4.0 * position;
        position += period * rate + 0.5 * period * period * push;
        rate += period * push;
    }
    for engine in ENGINES {
        let mut instance = run::started(&model, engine, stop, 1e-8);
        let done = instance.step_to(stop);
        done.unwrap_or_else(|error| panic!("{period} {number} {stop:?} by {engine:?}: {error}"));
        assert!(instance.time() >= stop);
        for (name, right) in [("rail.s", position), ("rail.v", rate), ("u", -4.0 * position)] {
            let found = run::value(&mut instance, name);
            let error = (found - right).abs() / (1.0 + right.abs());
            assert!(error < 1e-7, "{period} {number} {stop:?} by {engine:?}: {name} is {found}, not {right}");
        }
    }
}

/// The block of TOML in docs/machines.md that begins so.
fn pattern(begin: &str) -> String {
    let page = run::file("docs/machines.md");
    let found = page.split("```toml\n").find(|block| block.starts_with(begin)).expect("the pattern");
    found.split("```").next().expect("an end").to_owned()
}

/// How often the events of a scene happen within a time, by every method.
fn happen(text: &str, stop: f64, expected: &[(&str, u32)]) {
    for engine in ENGINES {
        let mut instance = run::started(&run::model(text), engine, stop, 1e-8);
        instance.step_to(stop).unwrap_or_else(|error| panic!("{engine:?}: {error}\n{text}"));
        for &(event, times) in expected {
            assert_eq!(count(&instance, event), times, "{event} by {engine:?}\n{text}");
        }
    }
}

#[test]
fn events_of_the_pages_and_models_happen_as_often_as_they_say() {
    let cart = format!(
        "name = \"cart\"\n[ground.points]\nwall = [-1, 0]\n[bodies.cart]\nmass = 1\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"cart\"]\naxis = [1, 0]\n[loads.spring]\ntype = \"spring\"\nbetween = [\"ground.wall\", \"cart\"]\nstiffness = 100\nlength = 1\n[initial]\n\"rail.s\" = 0\n\"rail.v\" = 8\n{}",
        pattern("[events.release]")
    );
    // Taut by 60 N at 0.6 m after asin(0.75)/10 s, it goes on with sqrt(64 - 36) m/s: at 2 m after 0.349 s.
    happen(&cart, 0.34, &[("release", 1), ("too_far", 0)]);
    let stopped = run::started(&run::model(&cart), None, 0.4, 1e-8).step_to(0.4).expect_err("an end").to_string();
    assert!(stopped.contains("`too_far` has ended the run at t = 0.349381339"), "{stopped}");
    let hand = format!(
        "name = \"hand\"\n[ground.points]\ntable = [3.14159, 0]\n[bodies.hand]\nmass = 1\ninertia = 0.1\npoints = {{ tip = [0.1, 0] }}\n[bodies.part]\nmass = 0.5\ninertia = 0.01\n[bodies.table]\nmass = 1\ninertia = 0.1\n[joints.table_pin]\ntype = \"revolute\"\nbetween = [\"ground.table\", \"table\"]\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"hand\"]\naxis = [1, 0]\n[joints.bed]\ntype = \"prismatic\"\nbetween = [\"ground\", \"part\"]\naxis = [1, 0]\n[loads.pull]\ntype = \"force\"\non = \"hand\"\nvector = [\"sin(t/1[s])*1[N]\", 0]\n[initial]\n\"rail.s\" = 0\n\"rail.v\" = 0.2\n\"bed.s\" = 0.4\n{}",
        pattern("[joints.grip]")
    );
    happen(&hand, 5.0, &[("grab", 1), ("drop", 1)]);
    // As long as nothing has been grabbed its time is negative: what waits for less than that happens at the start, too, and releases nothing.
    happen(&run::scene_of("gripper"), 3.0, &[("close", 1), ("open", 2)]);
    happen(&run::scene_of("balancing_cart"), 2.0, &[("release", 1), ("fallen", 0)]);
}
