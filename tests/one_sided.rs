//! What is a unilateral constraint: limits, contacts, ropes, and joints that events remove, against closed forms and other formulations.

use std::f64::consts::{PI, TAU};

use crate::support::ROOT;
use crate::support::exchange::integrate;
use crate::support::run::{model, scene_of, started, value};

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::instance::{Instance, Snapshot};
use cotree_fmu::program::Engine;

const METHODS: [Engine; 3] = [Engine::Taylor, Engine::Dop853, Engine::Radau];

fn ball(restitution: f64) -> String {
    format!(
        r#"
name = "ball"
gravity = [0, -9.81]
[bodies.ball]
mass = 2.0
[joints.rail]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
[joints.pad]
type = "contact"
between = ["ground", "ball"]
axis = [1, 0]
restitution = {restitution}
[initial]
"rail.s" = 1.0
"rail.v" = 0.0
[outputs]
variables = ["ball.y", "ball.vy", "pad.gap", "pad.fn", "pad.mode", "pad.impulse", "energy.total"]
[experiment]
stop = "8 s"
tolerance = 1e-10
"#
    )
}

/// Height and velocity of a ball that is dropped from 1 m, by its parabolas.
fn bounced(restitution: f64, time: f64) -> [f64; 2] {
    let g = 9.81_f64;
    let first = (2.0 / g).sqrt();
    if time < first {
        return [1.0 - 0.5 * g * time * time, -g * time];
    }
    let (mut begin, mut speed) = (first, restitution * g * first);
    while 2.0 * speed / g > 1e-7 {
        let flight = 2.0 * speed / g;
        if time < begin + flight {
            let since = time - begin;
            return [since * (speed - 0.5 * g * since), speed - g * since];
        }
        (begin, speed) = (begin + flight, restitution * speed);
    }
    [0.0, 0.0]
}

#[test]
fn a_ball_bounces_and_comes_to_rest() {
    for (restitution, engine) in
        [0.0, 0.3, 0.8, 0.99].into_iter().flat_map(|share| METHODS.map(|engine| (share, engine)))
    {
        // Nothing but the smallest steps of the implicit method follows a fall without any scale.
        if engine == Engine::Radau {
            continue;
        }
        let mut run = started(&model(&ball(restitution)), Some(engine), 8.0, 1e-10);
        for time in [0.3, 0.7, 1.3, 2.0, 3.1, 4.05, 6.0, 8.0] {
            run.step_to(time).unwrap();
            let [y, v] = bounced(restitution, time);
            let found = ["ball.y", "ball.vy"].map(|name| value(&mut run, name));
            assert!(
                (found[0] - y).abs() < 1e-10 && (found[1] - v).abs() < 1e-9,
                "{engine:?} {restitution} {time}: {found:?}"
            );
            let (mode, force) = (value(&mut run, "pad.mode"), value(&mut run, "pad.fn"));
            let rests = y == 0.0 && v == 0.0;
            assert_eq!(mode, f64::from(u8::from(rests)), "{restitution} {time}");
            assert!((force - if rests { 2.0 * 9.81 } else { 0.0 }).abs() < 1e-12);
        }
        let happened = run.events().map(|(_, count)| count).sum::<u32>();
        assert!(happened < if restitution < 0.9 { 90 } else { 700 }, "{restitution}: {happened} impacts");
    }
}

#[test]
fn nothing_is_lost_at_a_restitution_of_one() {
    let mut run = started(&model(&ball(1.0)), None, 1000.0, 1e-10);
    let energy = value(&mut run, "energy.total");
    run.step_to(1000.0).unwrap();
    assert!((value(&mut run, "energy.total") / energy - 1.0).abs() < 1e-11);
    assert!((value(&mut run, "pad.impulse") / (2.0 * 2.0 * (2.0 * 9.81_f64).sqrt()) - 1.0).abs() < 1e-11);
}

/// A slider-crank whose slider runs against a stop.
const STOPPED: &str = r#"
name = "stopped"
gravity = [0, -9.81]
[bodies.crank]
mass = 1.0
inertia = 0.004
points = { inner = [-0.1, 0], outer = [0.1, 0] }
[bodies.rod]
mass = 2.0
inertia = 0.05
points = { big = [-0.25, 0], small = [0.25, 0] }
[bodies.slider]
mass = 1.5
[joints.pivot]
type = "revolute"
between = ["ground", "crank.inner"]
[joints.crank_pin]
type = "revolute"
between = ["crank.outer", "rod.big"]
[joints.wrist]
type = "revolute"
between = ["rod.small", "slider"]
[joints.guide]
type = "prismatic"
between = ["ground", "slider"]
axis = [1, 0]
limits = { max = "0.63 m", restitution = 0.6 }
[initial]
"crank.angle" = START_ANGLE
"crank.omega" = START_RATE
"rod.angle" = { guess = "-24 deg" }
[outputs]
variables = ["crank.angle", "crank.omega", "guide.s", "guide.v", "guide.stop", "guide.impulse", "guide.mode"]
[experiment]
stop = "1.2 s"
tolerance = 1e-11
"#;

fn slider_crank(angle: f64, rate: f64) -> String {
    STOPPED.replace("START_ANGLE", &format!("{angle:?}")).replace("START_RATE", &format!("{rate:?}"))
}

/// One freedom: an impact turns every velocity around, with the share that the stop leaves. So runs without the stop, put together, are the run with it.
#[test]
fn a_stop_of_one_freedom_turns_the_motion_around() {
    let free = |angle, rate| {
        slider_crank(angle, rate)
            .replace("limits = { max = \"0.63 m\", restitution = 0.6 }\n", "")
            .replace(", \"guide.stop\", \"guide.impulse\", \"guide.mode\"", "")
    };
    let (mut begin, mut start) = (0.0, [1.5_f64, 15.0]);
    let mut pieces = Vec::new();
    while begin < 1.2 {
        let model = model(&free(start[0], start[1]));
        let mut run = started(&model, None, 2.0, 1e-12);
        let mut time = 0.0;
        while begin + time < 1.2 {
            time += 1e-3;
            run.step_to(time).unwrap();
            if value(&mut run, "guide.s") > 0.63 && value(&mut run, "guide.v") > 0.0 {
                break;
            }
        }
        let at = |time: f64| {
            let mut run = started(&model, None, 2.0, 1e-12);
            run.step_to(time).unwrap();
            ["guide.s", "crank.angle", "crank.omega"].map(|name| value(&mut run, name))
        };
        let [mut from, mut to] = [time - 1e-3, time];
        for _ in 0..50 {
            let middle = 0.5 * (from + to);
            *(if at(middle)[0] > 0.63 { &mut to } else { &mut from }) = middle;
        }
        pieces.push((begin, start));
        let [_, angle, rate] = at(to);
        (begin, start) = (begin + to, [angle, -0.6 * rate]);
    }
    assert!(pieces.len() > 2, "{pieces:?}");
    for engine in METHODS {
        let mut run = started(&model(&slider_crank(1.5, 15.0)), Some(engine), 1.2, 1e-11);
        for time in [0.1, 0.33, 0.6, 0.9, 1.2] {
            run.step_to(time).unwrap();
            let (begin, start) = *pieces.iter().rfind(|(begin, _)| *begin < time).unwrap();
            let mut piece = started(&model(&free(start[0], start[1])), None, 2.0, 1e-12);
            piece.step_to(time - begin).unwrap();
            for name in ["crank.angle", "crank.omega", "guide.s"] {
                let (found, expected) = (value(&mut run, name), value(&mut piece, name));
                assert!(
                    (found - expected).abs() < 1e-8 * (1.0 + expected.abs()),
                    "{engine:?} {name} {time}: {found} {expected}"
                );
            }
        }
    }
}

/// Communication points and saved states change no bit.
#[test]
fn impacts_do_not_depend_on_who_asks_when() {
    for (scene, engine) in [slider_crank(1.5, 15.0), ball(0.8)]
        .iter()
        .flat_map(|scene| [Engine::Taylor, Engine::Dop853].map(|engine| (scene, engine)))
    {
        let model = model(scene);
        let end = |step: f64| {
            let mut run = started(&model, Some(engine), 2.0, 1e-9);
            let (mut time, mut saved) = (0.0, None);
            while time < 1.15 {
                time = f64::min(time + step, 1.15);
                run.step_to(time).unwrap();
                if saved.is_none() && time > 0.5 {
                    saved = Some(run.save().to_bytes().unwrap());
                }
            }
            let registers = run.state().registers().to_vec();
            if let Some(bytes) = saved {
                run.restore(&Snapshot::from_bytes(&model, &bytes).unwrap()).unwrap();
                if run.time() < 1.15 {
                    run.step_to(1.15).unwrap();
                }
                assert_eq!(run.state().registers(), registers, "restored");
            }
            registers
        };
        let whole = end(1.15);
        for step in [1e-3, 0.013, 0.25] {
            assert_eq!(end(step), whole, "{engine:?}: steps of {step} s");
        }
    }
}

/// Two links with stops between them, in two angles: kinetic energy 1/2 w M w, and an impulse along the difference of the angles.
struct Links {
    state: [f64; 4],
    limits: [f64; 2],
    restitution: f64,
}

const MASS: [f64; 2] = [1.2, 0.7];
const LENGTH: [f64; 2] = [0.5, 0.4];

impl Links {
    fn masses(&self, [a, b]: [f64; 2]) -> [f64; 3] {
        let own = |link: usize| MASS[link] * LENGTH[link] * LENGTH[link] / 3.0;
        [own(0) + MASS[1] * LENGTH[0] * LENGTH[0], 0.5 * MASS[1] * LENGTH[0] * LENGTH[1] * (a - b).cos(), own(1)]
    }

    fn rates(&self, [a, b, u, v]: [f64; 4]) -> [f64; 4] {
        let [aa, ab, bb] = self.masses([a, b]);
        let swing = 0.5 * MASS[1] * LENGTH[0] * LENGTH[1] * (a - b).sin();
        let first = -swing * v * v - (0.5 * MASS[0] + MASS[1]) * LENGTH[0] * 9.81 * a.cos();
        let second = swing * u * u - 0.5 * MASS[1] * LENGTH[1] * 9.81 * b.cos();
        let determinant = aa * bb - ab * ab;
        [u, v, (bb * first - ab * second) / determinant, (aa * second - ab * first) / determinant]
    }

    fn stepped(&self, h: f64) -> [f64; 4] {
        let y = self.state;
        let along = |k: [f64; 4], share: f64| std::array::from_fn(|i| y[i] + share * h * k[i]);
        let one = self.rates(y);
        let two = self.rates(along(one, 0.5));
        let three = self.rates(along(two, 0.5));
        let four = self.rates(along(three, 1.0));
        std::array::from_fn(|i| y[i] + h / 6.0 * (one[i] + 2.0 * two[i] + 2.0 * three[i] + four[i]))
    }

    fn beyond(&self, state: [f64; 4]) -> bool {
        let angle = state[1] - state[0];
        angle < self.limits[0] || angle > self.limits[1]
    }

    fn collide(&mut self) {
        let [a, b, u, v] = self.state;
        let [aa, ab, bb] = self.masses([a, b]);
        let determinant = aa * bb - ab * ab;
        let give = [(-bb - ab) / determinant, (aa + ab) / determinant];
        let impulse = -(1.0 + self.restitution) * (v - u) / (give[1] - give[0]);
        self.state = [a, b, u + give[0] * impulse, v + give[1] * impulse];
    }

    /// Steps of 0.1 ms; one that goes beyond a limit ends there.
    fn go_to(&mut self, from: f64, to: f64) {
        let steps = ((to - from) / 1e-4).round() as usize;
        for _ in 0..steps {
            let mut left = 1e-4;
            while left > 0.0 && self.beyond(self.stepped(left)) {
                let [mut inside, mut outside] = [0.0, left];
                for _ in 0..60 {
                    let middle = 0.5 * (inside + outside);
                    *(if self.beyond(self.stepped(middle)) { &mut outside } else { &mut inside }) = middle;
                }
                self.state = self.stepped(inside);
                left -= outside;
                self.collide();
            }
            self.state = self.stepped(left);
        }
    }
}

fn links(state: [f64; 4], limits: [f64; 2], restitution: f64, coordinates: &str) -> String {
    let [a, b, u, v] = state;
    format!(
        r#"
name = "links"
gravity = [0, -9.81]
[bodies.upper]
mass = 1.2
inertia = "1.2*0.5^2/12"
points = {{ top = [-0.25, 0], end = [0.25, 0] }}
[bodies.lower]
mass = 0.7
inertia = "0.7*0.4^2/12"
points = {{ top = [-0.2, 0] }}
[joints.shoulder]
type = "revolute"
between = ["ground", "upper.top"]
[joints.elbow]
type = "revolute"
between = ["upper.end", "lower.top"]
limits = {{ min = {:?}, max = {:?}, restitution = {restitution} }}
[initial]
"upper.angle" = {a:?}
"lower.angle" = {b:?}
"upper.omega" = {u:?}
"lower.omega" = {v:?}
[outputs]
variables = ["upper.angle", "lower.angle", "upper.omega", "lower.omega", "elbow.stop", "elbow.mode"]
[coordinates]
preset = "{coordinates}"
[experiment]
stop = "1.5 s"
tolerance = 1e-11
"#,
        limits[0], limits[1]
    )
}

#[test]
fn two_links_collide_as_their_equations_in_two_angles_say() {
    for (case, (state, limits, restitution)) in [
        ([-1.0, -0.8, 0.0, 0.0], [-0.5, 0.9], 0.7),
        ([-2.2, -1.9, 1.0, -3.0], [-0.4, 0.4], 0.3),
        ([0.3, 0.1, -2.0, 4.0], [-1.2, 0.3], 0.95),
    ]
    .into_iter()
    .enumerate()
    {
        let coordinates = ["recommended", "absolute", "joint"][case];
        let model = model(&links(state, limits, restitution, coordinates));
        for engine in METHODS {
            let mut own = Links { state, limits, restitution };
            let mut run = started(&model, Some(engine), 1.5, 1e-11);
            for step in 1..=6 {
                let time = 0.2 * f64::from(step);
                own.go_to(time - 0.2, time);
                run.step_to(time).unwrap();
                for (name, expected) in
                    ["upper.angle", "lower.angle", "upper.omega", "lower.omega"].iter().zip(own.state)
                {
                    let found = value(&mut run, name);
                    assert!(
                        (found - expected).abs() < 2e-7 * (1.0 + expected.abs()),
                        "{case} {engine:?} {name} {time}: {found} {expected}"
                    );
                }
            }
        }
    }
}

/// A plate that falls flat on both of its feet keeps level, and rests on both.
#[test]
fn two_contacts_at_once_share_an_impact() {
    let plate = r#"
name = "plate"
gravity = [0, -9.81]
[bodies.plate]
mass = 3.0
inertia = 0.4
points = { left = [-0.4, -0.1], right = [0.2, -0.1] }
[joints.left]
type = "contact"
between = ["ground", "plate.left"]
axis = [1, 0]
restitution = 0.5
[joints.right]
type = "contact"
between = ["ground", "plate.right"]
axis = [1, 0]
restitution = 0.5
[initial]
"plate.x" = 0
"plate.y" = 0.6
"plate.angle" = 0
"plate.vx" = 0.3
"plate.vy" = 0
"plate.omega" = 0
[outputs]
variables = ["plate.y", "plate.angle", "plate.x", "left.fn", "right.fn", "left.impulse", "right.impulse"]
[experiment]
stop = "4 s"
tolerance = 1e-10
"#;
    let mut run = started(&model(plate), None, 4.0, 1e-10);
    run.step_to(0.4).unwrap();
    let speed = (2.0_f64 * 9.81 * 0.5).sqrt();
    let [left, right] = ["left.impulse", "right.impulse"].map(|name| value(&mut run, name));
    assert!(
        (left + right - 3.0 * 1.5 * speed).abs() < 1e-9 && (0.4 * left - 0.2 * right).abs() < 1e-9,
        "{left} {right}"
    );
    run.step_to(4.0).unwrap();
    let found = ["plate.y", "plate.angle", "left.fn", "right.fn", "plate.x"].map(|name| value(&mut run, name));
    let expected = [0.1, 0.0, 9.81, 2.0 * 9.81, 1.2];
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}

/// A ball on a rope: it falls freely until that is taut, swings as on a rod, and its rope pulls and never pushes.
#[test]
fn a_rope_catches_a_ball() {
    let rope = r#"
name = "rope"
gravity = [0, -9.81]
[bodies.ball]
mass = 0.5
inertia = 0.01
[joints.rope]
type = "rope"
between = ["ground", "ball"]
length = "1 m"
[initial]
"ball.x" = 0.6
"ball.y" = 0
"ball.angle" = 0
"ball.vx" = 0
"ball.vy" = 0
"ball.omega" = 0
[outputs]
variables = ["ball.x", "ball.y", "ball.vx", "ball.vy", "rope.gap", "rope.stop", "rope.mode", "energy.total"]
[experiment]
stop = "2 s"
tolerance = 1e-11
"#;
    let mut run = started(&model(rope), None, 2.0, 1e-11);
    let fall = (2.0_f64 * 0.8 / 9.81).sqrt();
    run.step_to(fall - 1e-3).unwrap();
    assert_eq!(value(&mut run, "rope.mode"), 0.0);
    run.step_to(fall + 1e-9).unwrap();
    // What was along the rope is gone: v = g t (0, -1) without its part along (0.6, -0.8).
    let along = 0.8 * 9.81 * fall;
    for (name, expected) in [("ball.vx", -0.6 * along), ("ball.vy", -9.81 * fall + 0.8 * along), ("rope.gap", 0.0)] {
        assert!((value(&mut run, name) - expected).abs() < 1e-6, "{name}");
    }
    let energy = value(&mut run, "energy.total");
    for step in 1..=15 {
        run.step_to(fall + 0.1 * f64::from(step)).unwrap();
        assert!((value(&mut run, "energy.total") - energy).abs() < 1e-9);
        assert!(value(&mut run, "rope.gap") > -1e-10 && value(&mut run, "rope.stop") <= 0.0);
        let [x, y, vx, vy] = ["ball.x", "ball.y", "ball.vx", "ball.vy"].map(|name| value(&mut run, name));
        if value(&mut run, "rope.mode") == 1.0 {
            // m v^2 / L + m g cos
            let pull = 0.5 * (vx * vx + vy * vy - 9.81 * y);
            assert!((value(&mut run, "rope.stop") + pull).abs() < 1e-8, "{x} {y}");
        }
    }
}

/// A sling that an event lets go: until then the run is that of the scene without the event, afterwards the shot flies along its parabola.
#[test]
fn what_an_event_removes_holds_no_longer() {
    let thrown = |event: &str| {
        format!(
            r#"
name = "thrown"
gravity = [0, -9.81]
[bodies.beam]
mass = 4.0
inertia = 1.3
points = {{ pivot = [0.3, 0], tip = [-1, 0], tail = [1, 0] }}
[bodies.shot]
mass = 1.0
inertia = 0.01
[joints.pivot]
type = "revolute"
between = ["ground", "beam.pivot"]
[joints.HOLD]
[initial]
"beam.angle" = 0.7
"beam.omega" = 2.0
INITIAL
{event}
[outputs]
variables = ["beam.angle", "beam.omega", "shot.x", "shot.y", "shot.vx", "shot.vy"]
[experiment]
stop = "1 s"
tolerance = 1e-11
"#
        )
    };
    let release = "[events.release]\nwhen = \"beam.angle > 0.9\"\nremove = [\"hold\"]\n";
    let pinned =
        ("hold]\ntype = \"revolute\"\nbetween = [\"beam.tip\", \"shot\"]", "\"shot.angle\" = 0\n\"shot.omega\" = 1");
    let slung = (
        "hold]\ntype = \"distance\"\nbetween = [\"beam.tip\", \"shot\"]\nlength = 0.4",
        "\"shot.angle\" = 0\n\"shot.omega\" = 1\n\"shot.y\" = { guess = -1.3 }\n\"shot.x\" = -0.9\n\"shot.vx\" = 0",
    );
    for (hold, initial) in [pinned, slung] {
        let scene = |event: &str| thrown(event).replace("HOLD]", hold).replace("INITIAL", initial);
        let (with, without) = (model(&scene(release)), model(&scene("")));
        for engine in [Engine::Dop853, Engine::Radau] {
            let [mut one, mut other] = [&with, &without].map(|model| started(model, Some(engine), 1.0, 1e-11));
            let mut time = 0.0;
            while value(&mut other, "beam.angle") < 0.9 {
                time += 0.02;
                other.step_to(time).unwrap();
            }
            let [mut from, mut to] = [time - 0.02, time];
            for _ in 0..45 {
                let middle = 0.5 * (from + to);
                let mut trial = started(&without, Some(engine), 1.0, 1e-11);
                trial.step_to(middle).unwrap();
                *(if value(&mut trial, "beam.angle") > 0.9 { &mut to } else { &mut from }) = middle;
            }
            let mut held = started(&without, Some(engine), 1.0, 1e-11);
            held.step_to(to).unwrap();
            let [x, y, vx, vy] = ["shot.x", "shot.y", "shot.vx", "shot.vy"].map(|name| value(&mut held, name));
            let flight = 1.0 - to;
            one.step_to(1.0).unwrap();
            for (name, expected) in [
                ("shot.x", x + vx * flight),
                ("shot.y", y + vy * flight - 0.5 * 9.81 * flight * flight),
                ("shot.vx", vx),
                ("shot.vy", vy - 9.81 * flight),
            ] {
                let found = value(&mut one, name);
                assert!(
                    (found - expected).abs() < 1e-7 * (1.0 + expected.abs()),
                    "{engine:?} {name}: {found} {expected}"
                );
            }
        }
    }
}

/// A classical Runge-Kutta step of an importer.
fn importer_step(instance: &mut Instance, start: &[f64], time: f64, h: f64) {
    let (mut sum, mut slope) = (vec![0.0; start.len()], vec![0.0; start.len()]);
    for (share, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
        let point: Vec<f64> = start.iter().zip(&slope).map(|(x, k)| x + share * h * k).collect();
        instance.set_time(time + share * h).unwrap();
        instance.set_states(&point).unwrap();
        instance.state_derivatives(&mut slope).unwrap();
        sum.iter_mut().zip(&slope).for_each(|(sum, k)| *sum += weight * k / 6.0);
    }
    let end: Vec<f64> = start.iter().zip(&sum).map(|(x, k)| x + h * k).collect();
    instance.set_states(&end).unwrap();
}

/// An importer that ends a step where an indicator passes zero, as far as numbers tell, lets impacts happen there.
pub fn integrate_to_events(instance: &mut Instance, stop: f64, h: f64) -> usize {
    instance.initialise_exchange().unwrap();
    let (mut states, mut events) = (vec![0.0; instance.state_count()], 0);
    let count = instance.model().program().indicators();
    let indicators = |instance: &mut Instance| {
        let mut values = vec![0.0; count];
        instance.indicators(&mut values).unwrap();
        values
    };
    let mut before = indicators(instance);
    while instance.time() < stop - 1e-12 {
        let (time, whole) = (instance.time(), h.min(stop - instance.time()));
        instance.states(&mut states).unwrap();
        let passes = |instance: &mut Instance, step: f64| {
            importer_step(instance, &states, time, step);
            indicators(instance).iter().zip(&before).any(|(after, before)| *before < 0.0 && *after >= 0.0)
        };
        let mut passed = passes(instance, whole);
        if passed {
            let [mut from, mut to] = [0.0, whole];
            for _ in 0..50 {
                let middle = 0.5 * (from + to);
                *(if passes(instance, middle) { &mut to } else { &mut from }) = middle;
            }
            passed = passes(instance, to);
        }
        if instance.complete_step().unwrap() || passed {
            instance.handle_event().unwrap();
            events += 1;
        }
        before = indicators(instance);
    }
    events
}

/// An integrator outside that looks for events lets impacts happen, and comes to rest at a stop.
#[test]
fn an_integrator_outside_sees_impacts() {
    let model_of = model(&slider_crank(1.5, 15.0));
    let mut inside = started(&model_of, None, 1.2, 1e-11);
    inside.step_to(0.9).unwrap();
    let mut outside = Instance::new(model_of);
    outside.setup(0.0, None, None).unwrap();
    integrate_to_events(&mut outside, 0.9, 2e-4);
    for name in ["crank.angle", "crank.omega", "guide.impulse"] {
        let (found, expected) = (value(&mut outside, name), value(&mut inside, name));
        assert!((found - expected).abs() < 1e-7 * (1.0 + expected.abs()), "{name}: {found} {expected}");
    }
    let mut rests = Instance::new(model(&scene_of("end_stop")));
    rests.setup(0.0, None, None).unwrap();
    let events = integrate_to_events(&mut rests, 1.5, 1e-3);
    let [angle, mode] = ["crank.angle", "guide.mode"].map(|name| value(&mut rests, name));
    assert!((angle + 0.546_121_293).abs() < 1e-8 && mode == 1.0 && events < 100, "{angle} {mode} {events}");
}

/// A limit that is moved to where the mechanism has been already is refused, not jumped to.
#[test]
fn a_limit_cannot_be_moved_into_the_mechanism() {
    let scene =
        ball(0.5).replace("[bodies.ball]", "[parameters]\nlevel = { value = \"0 m\", tunable = true }\n[bodies.ball]");
    let model = model(&scene.replace("restitution = 0.5", "restitution = 0.5\nradius = \"level\""));
    let mut run = started(&model, None, 8.0, 1e-10);
    run.step_to(0.2).unwrap();
    let level = run.variable("level").unwrap();
    run.set(level, 0.5).unwrap();
    run.step_to(0.3).unwrap();
    assert!(value(&mut run, "ball.y") > 0.5 && value(&mut run, "pad.gap") < 0.1);
    run.set(level, 0.9).unwrap();
    let refused = run.step_to(0.35).expect_err("the ball is below").to_string();
    assert!(refused.contains("beyond `pad`"), "{refused}");
}

/// The two links as a part, turned and mirrored: what the elbow may do is mirrored with it.
#[test]
fn limits_and_contacts_of_a_part_are_turned_and_mirrored_with_it() {
    let folder = std::env::temp_dir().join(format!("cotree-placed-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let state = [-1.0, -0.8, 0.0, 0.0];
    let limits = [-0.5, 0.9];
    let text = links(state, limits, 0.7, "recommended");
    std::fs::write(folder.join("links.toml"), text.replace("[coordinates]\npreset = \"recommended\"\n", "")).unwrap();
    let whole = "name = \"whole\"\ngravity = [0, -9.81]\n[parts.arm]\nfile = \"links.toml\"\nmirror = true\n[outputs]\nvariables = [\"arm_upper.angle\", \"arm_lower.omega\", \"arm_elbow.mode\"]\n[experiment]\nstop = 1.5\ntolerance = 1e-11\n";
    std::fs::write(folder.join("whole.toml"), whole).unwrap();
    let scene = Scene::read(folder.join("whole.toml")).map_err(|faults| faults.render(false, 100)).unwrap();
    let compiled = compile(&scene).map_err(|faults| faults.render(false, 100)).unwrap();
    let placed = std::sync::Arc::new(cotree_fmu::model::Model::new(compiled.program).unwrap());
    let [mut one, mut other] = [started(&placed, None, 1.5, 1e-11), started(&model(&text), None, 1.5, 1e-11)];
    for step in 1..=6 {
        let time = 0.2 * f64::from(step);
        one.step_to(time).unwrap();
        other.step_to(time).unwrap();
        let pairs = [("arm_upper.angle", "upper.angle"), ("arm_lower.omega", "lower.omega")];
        for (placed, alone) in pairs {
            let (found, expected) = (value(&mut one, placed), -value(&mut other, alone));
            assert!(
                (found - expected).abs() < 1e-7 * (1.0 + expected.abs()),
                "{placed} at {time} s: {found} {expected}"
            );
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}

/// Where bounces become shorter than the steps of an integrator outside, it goes on bouncing at the stop, but not through it.
#[test]
fn an_integrator_outside_stays_at_a_stop() {
    let mut outside = Instance::new(model(&scene_of("end_stop")));
    outside.setup(0.0, None, None).unwrap();
    integrate(&mut outside, 1.5, 1e-4).unwrap();
    let angle = value(&mut outside, "crank.angle");
    assert!((angle + 0.546_121_293).abs() < 1e-2, "{angle}");
}

fn fault(text: &str) -> String {
    let faults = Scene::from_toml(text).and_then(|scene| compile(&scene)).expect_err("a fault");
    faults.to_string()
}

#[test]
fn what_is_wrong_with_limits_is_said() {
    let limits = |limits: &str| {
        links([-1.0, -0.8, 0.0, 0.0], [-0.5, 0.9], 0.7, "recommended")
            .replace("limits = { min = -0.5, max = 0.9, restitution = 0.7 }", &format!("limits = {limits}"))
    };
    for (text, expected) in [
        ("{ restitution = 0.5 }", "neither `min` nor `max`"),
        ("{ min = 0.5, max = 0.4 }", "`min` must be below `max`"),
        ("{ min = -0.5, restitution = 1.5 }", "must be from 0 to 1"),
        ("{ min = \"1 m\" }", "angle"),
        ("{ min = 0.3 }", "the start is beyond `elbow.min`"),
    ] {
        let found = fault(&limits(text));
        assert!(found.contains(expected), "{text}: {found}");
    }
    let driven = slider_crank(1.5, 15.0)
        .replace("\"crank.omega\" = 15.0\n", "")
        .replace("\"crank.angle\" = 1.5\n", "")
        .replace("[initial]", "[drivers.motor]\njoint = \"pivot\"\nangle = \"1.5 + 3*t\"\n[initial]");
    let driven = fault(&driven);
    assert!(driven.contains("a prescribed motion cannot stop"), "{driven}");
    let unknown = fault(&ball(0.5).replace("\"pad.mode\"", "\"rail.mode\""));
    assert!(unknown.contains("`rail.mode`"), "{unknown}");
}

/// A disc inside of a circle does what its centre does on a rope; where it would leave a hill it does: at two thirds of the height of its start over the middle.
#[test]
fn discs_touch_circles_inside_and_outside() {
    let ball = |joint: &str, [x, y]: [f64; 2]| {
        format!(
            "name = \"ball\"\ngravity = [0, -9.81]\n[bodies.ball]\nmass = 0.5\ninertia = 0.01\n[joints.own]\nbetween = [\"ground\", \"ball\"]\n{joint}\n[initial]\n\"ball.x\" = {x:?}\n\"ball.y\" = {y:?}\n\"ball.angle\" = 0\n\"ball.vx\" = 0\n\"ball.vy\" = 0\n\"ball.omega\" = 0\n[outputs]\nvariables = [\"ball.x\", \"ball.y\", \"ball.vx\", \"ball.vy\", \"own.gap\", \"own.impulse\", \"own.mode\"]\n[experiment]\nstop = 2\ntolerance = 1e-11\n"
        )
    };
    let bowl = ball("type = \"contact\"\ncircle = 1.2\nradius = 0.2\nside = \"inside\"\nrestitution = 0.4", [0.6, 0.0]);
    let bowl = bowl.replace("\"own.gap\"", "\"own.fn\", \"own.gap\"");
    let rope = ball("type = \"rope\"\nlength = 1.0\nrestitution = 0.4", [0.6, 0.0])
        .replace("\"own.gap\"", "\"own.stop\", \"own.gap\"");
    let [mut inside, mut held] = [&bowl, &rope].map(|text| started(&model(text), None, 2.0, 1e-11));
    for step in 1..=8 {
        inside.step_to(0.25 * f64::from(step)).unwrap();
        held.step_to(0.25 * f64::from(step)).unwrap();
        for name in ["ball.x", "ball.y", "ball.vx", "ball.vy", "own.gap", "own.mode"] {
            let (found, expected) = (value(&mut inside, name), value(&mut held, name));
            assert!((found - expected).abs() < 1e-9, "{name}: {found} {expected}");
        }
        assert!((value(&mut inside, "own.fn") + value(&mut held, "own.stop")).abs() < 1e-7);
        assert!(value(&mut inside, "own.impulse") >= 0.0 && value(&mut inside, "own.fn") >= 0.0);
    }
    let (sine, cosine) = 0.3_f64.sin_cos();
    let hill = ball("type = \"contact\"\ncircle = 0.8\nradius = 0.2", [sine, cosine]);
    let mut run = started(&model(&hill), None, 2.0, 1e-11);
    let mut last = 1.0;
    for step in 1..2000 {
        run.step_to(1e-3 * f64::from(step)).unwrap();
        if value(&mut run, "own.mode") == 0.0 {
            break;
        }
        last = value(&mut run, "ball.y");
    }
    let left = 2.0 / 3.0 * cosine;
    let [y, vy] = ["ball.y", "ball.vy"].map(|name| value(&mut run, name));
    assert!(y < left && last > left && last - y < -2e-3 * vy, "{last} {y} {left}");
    // It flies with the speed of its fall.
    let [vx, vy] = ["ball.vx", "ball.vy"].map(|name| value(&mut run, name));
    assert!((vx * vx + vy * vy - 2.0 * 9.81 * (cosine - y)).abs() < 1e-8);
    assert!((vx - left.sqrt() * 9.81_f64.sqrt() * left).abs() < 1e-8, "{vx}");
}

/// Two free discs: momentum stays, the speed along the line of their centres comes back with its share.
#[test]
fn two_moving_discs_collide() {
    let scene = r#"
name = "discs"
[bodies]
first = { mass = 2.0, inertia = 0.1 }
second = { mass = 0.5, inertia = 0.02 }
[joints.own]
type = "contact"
between = ["first", "second"]
circle = 0.3
radius = 0.2
restitution = 0.6
[initial]
"first.x" = 0
"first.y" = 0
"first.angle" = 0
"first.vx" = 1
"first.vy" = 0.2
"first.omega" = 3
"second.x" = 2
"second.y" = 0.1
"second.angle" = 0
"second.vx" = -1
"second.vy" = 0.2
"second.omega" = -2
[outputs]
variables = ["first.x", "first.y", "first.vx", "first.vy", "second.x", "second.y", "second.vx", "second.vy", "first.omega", "second.omega", "own.impulse"]
[experiment]
stop = 2
tolerance = 1e-11
"#;
    // They approach at 2 m/s along x with 0.1 m between their lines.
    let along = (0.25_f64 - 0.01).sqrt();
    let time = (2.0 - along) / 2.0;
    let normal = [along / 0.5, 0.1 / 0.5];
    let impulse = 1.6 * 2.0 * normal[0] / (1.0 / 2.0 + 1.0 / 0.5);
    let mut run = started(&model(scene), None, 2.0, 1e-11);
    run.step_to(2.0).unwrap();
    for (name, expected) in [
        ("first.vx", 1.0 - impulse * normal[0] / 2.0),
        ("first.vy", 0.2 - impulse * normal[1] / 2.0),
        ("second.vx", -1.0 + impulse * normal[0] / 0.5),
        ("second.vy", 0.2 + impulse * normal[1] / 0.5),
        ("second.x", 2.0 - time + (-1.0 + impulse * normal[0] / 0.5) * (2.0 - time)),
        ("first.omega", 3.0),
        ("second.omega", -2.0),
        ("own.impulse", impulse),
    ] {
        let found = value(&mut run, name);
        assert!((found - expected).abs() < 1e-9, "{name}: {found} {expected}");
    }
}

#[test]
fn what_is_wrong_with_a_circle_is_said() {
    let touching = |keys: &str| ball(0.5).replace("axis = [1, 0]\nrestitution = 0.5", keys);
    for (keys, expected) in [
        ("axis = [1, 0]\ncircle = 2", "circle"),
        ("restitution = 0.5", "axis"),
        ("circle = 2\nside = \"left\"", "it touches a circle"),
        ("axis = [1, 0]\nside = \"inside\"", "it touches a line"),
        ("circle = 0.2\nradius = 0.3\nside = \"inside\"", "does not fit"),
    ] {
        let found = fault(&touching(keys));
        assert!(found.contains(expected), "{keys}: {found}");
    }
}

/// A block at rest at a stop, under a force that is zero at the start: what follows says whether it leaves the stop.
#[test]
fn a_force_that_begins_at_zero_leaves_a_stop_or_presses_it() {
    let block = |force: &str, limits: &str| {
        format!(
            "name = \"block\"\n[bodies.block]\nmass = 2.0\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"block\"]\naxis = [1, 0]\n{limits}\n[loads.push]\ntype = \"force\"\non = \"block\"\nvector = [\"{force}\", 0]\n[initial]\n\"rail.s\" = 0\n\"rail.v\" = 0\n[outputs]\nvariables = [\"rail.s\", \"rail.v\", \"rail.stop\", \"rail.mode\"]\n[experiment]\nstop = \"2 s\"\ntolerance = 1e-10\n"
        )
    };
    for (force, sign) in [("3*sin(2*t)", 1.0), ("-3*sin(2*t)", -1.0)] {
        for (limits, side) in [("limits = { min = 0 }", 1.0), ("limits = { max = 0 }", -1.0)] {
            for engine in [Engine::Taylor, Engine::Dop853] {
                let mut run = started(&model(&block(force, limits)), Some(engine), 2.0, 1e-10);
                run.step_to(1.0).unwrap();
                let leaves = sign * side > 0.0;
                let free = [1.5 * (0.5 - 2.0_f64.sin() / 4.0), 0.75 * (1.0 - 2.0_f64.cos())].map(|own| sign * own);
                let [s, v] = if leaves { free } else { [0.0, 0.0] };
                let stop = if leaves { 0.0 } else { -sign * 3.0 * 2.0_f64.sin() };
                for (name, expected) in [("rail.s", s), ("rail.v", v), ("rail.stop", stop)] {
                    let found = value(&mut run, name);
                    assert!((found - expected).abs() < 1e-9, "{force} {limits} {engine:?} {name}: {found} {expected}");
                }
            }
        }
    }
}

/// A start that goes into what it touches is an impact.
#[test]
fn a_start_into_a_stop_is_an_impact() {
    let scene = ball(0.5).replace("\"rail.s\" = 1.0\n\"rail.v\" = 0.0", "\"rail.s\" = 0.0\n\"rail.v\" = -2.0");
    let mut run = started(&model(&scene), None, 8.0, 1e-10);
    assert_eq!(value(&mut run, "ball.vy"), 1.0);
    run.step_to(0.1).unwrap();
    assert!((value(&mut run, "ball.y") - (0.1 - 0.5 * 9.81 * 0.01)).abs() < 1e-12);
}

/// What drivers move cannot be stopped: a limit of the joint that they move, too.
#[test]
fn limits_of_a_driven_joint_are_refused_as_what_they_are() {
    let links = links([-1.0, -0.8, 0.0, 0.0], [-0.5, 0.9], 0.7, "recommended");
    let driven = links
        .replace("\"lower.angle\" = -0.8\n", "")
        .replace("\"lower.omega\" = 0.0\n", "")
        .replace("[initial]", "[drivers.motor]\njoint = \"elbow\"\nangle = \"0.2*t\"\n[initial]");
    let found = fault(&driven);
    assert!(found.contains("a prescribed motion cannot stop") && !found.contains("conflicts"), "{found}");
}

/// The crank of `end_stop` in its angle alone, theta'' = (T - J' omega^2 / 2) / J, by Runge-Kutta steps that end at impacts.
struct Crank {
    state: [f64; 2],
    rests: bool,
}

impl Crank {
    /// Place of the slider, its rate by the angle, and the inertia that the crank sees.
    fn seen(angle: f64) -> [f64; 3] {
        let (crank, rod): (f64, f64) = (0.2, 0.5);
        let (sine, cosine) = angle.sin_cos();
        let low = -crank * sine / rod;
        let across = (1.0 - low * low).sqrt();
        let turn = -crank * cosine / (rod * across);
        let slide = -crank * sine - rod * low * turn;
        let centre = [-crank * sine - 0.5 * rod * low * turn, crank * cosine + 0.5 * rod * across * turn];
        let inertia =
            0.04 / 12.0 + 0.01 + 2.0 * (centre[0] * centre[0] + centre[1] * centre[1]) + 0.5 / 12.0 * turn * turn;
        [crank * cosine + rod * across, slide, inertia + 1.5 * slide * slide]
    }

    fn rates([angle, omega]: [f64; 2]) -> [f64; 2] {
        const STEP: f64 = 1e-3;
        let inertia = |share: f64| Crank::seen(angle + share * STEP)[2];
        let slope = (8.0 * (inertia(1.0) - inertia(-1.0)) - inertia(2.0) + inertia(-2.0)) / (12.0 * STEP);
        [omega, (4.0 - 0.1 * omega - 0.5 * slope * omega * omega) / inertia(0.0)]
    }

    fn stepped(&self, h: f64) -> [f64; 2] {
        let y = self.state;
        let along = |k: [f64; 2], share: f64| [y[0] + share * h * k[0], y[1] + share * h * k[1]];
        let one = Crank::rates(y);
        let two = Crank::rates(along(one, 0.5));
        let three = Crank::rates(along(two, 0.5));
        let four = Crank::rates(along(three, 1.0));
        std::array::from_fn(|i| y[i] + h / 6.0 * (one[i] + 2.0 * two[i] + 2.0 * three[i] + four[i]))
    }

    fn go_on(&mut self, time: f64) {
        let beyond = |state: [f64; 2]| Crank::seen(state[0])[0] > 0.66;
        for _ in 0..(time / 2e-5).round() as usize {
            let mut left = 2e-5;
            while !self.rests && left > 0.0 && beyond(self.stepped(left)) {
                let [mut inside, mut outside] = [0.0, left];
                for _ in 0..50 {
                    let middle = 0.5 * (inside + outside);
                    *(if beyond(self.stepped(middle)) { &mut outside } else { &mut inside }) = middle;
                }
                self.state = self.stepped(inside);
                left -= outside;
                self.state[1] *= -0.6;
                self.rests = self.state[1].abs() < 1e-6;
            }
            if !self.rests {
                self.state = self.stepped(left);
            }
        }
    }
}

#[test]
fn the_end_stop_follows_its_equation_in_one_angle() {
    let folder = format!("{ROOT}/models/end_stop");
    let expected = std::fs::read_to_string(format!("{folder}/expected.csv")).unwrap();
    let mut rows = expected.lines();
    assert_eq!(rows.next(), Some("time,crank.angle,crank.omega,guide.s,guide.v,guide.stop,guide.mode"));
    let mut run = started(&model(&scene_of("end_stop")), None, 3.0, 1e-10);
    let mut own = Crank { state: [-150.0_f64.to_radians(), 0.0], rests: false };
    let mut time = 0.0;
    for row in rows {
        let row: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        if row[0] > 0.0 {
            own.go_on(row[0] - time);
            time = row[0];
            run.step_to(time).unwrap();
        }
        let [angle, omega] = if own.rests { [own.state[0], 0.0] } else { own.state };
        let [place, slide, _] = Crank::seen(angle);
        let stop = if own.rests { 4.0 / slide } else { 0.0 };
        let expected = [angle, omega, place, slide * omega, -stop.abs(), f64::from(u8::from(own.rests))];
        let names = ["crank.angle", "crank.omega", "guide.s", "guide.v", "guide.stop", "guide.mode"];
        for ((name, expected), stored) in names.iter().zip(expected).zip(&row[1..]) {
            let found = value(&mut run, name);
            let close = |other: f64| (other - expected).abs() < 2e-7 * (1.0 + expected.abs());
            assert!(
                close(found) && close(*stored),
                "{name} at {time} s: {found}, stored {stored}, expected {expected}"
            );
        }
    }
}

/// A crank that turns evenly takes steps of many turns, or of whole ones, in whose ends it seems to rest: between lines it is thrown to and fro, in closed form.
#[test]
fn what_turns_many_times_in_a_step_is_caught() {
    let (low, high) = (-(0.95f64.asin()), PI + 0.95f64.asin());
    for turns in [1.0, 2.0, 2.180_41, 5.0, 24.0, 37.0, 133.0] {
        for by_turns in [false, true] {
            let text = format!(
                "name = \"crank\"\n[ground.points]\nline = [0, -0.95]\n[bodies.crank]\nmass = 1\ninertia = 1\npoints = {{ tip = [1, 0] }}\n[joints.pivot]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank\"]\n[joints.pad]\ntype = \"contact\"\nbetween = [\"ground.line\", \"crank.tip\"]\naxis = [1, 0]\nrestitution = 1\n[initial]\n\"crank.angle\" = \"90 deg\"\n\"crank.omega\" = {}\n[outputs]\nvariables = [\"crank.angle\"]\n[experiment]\nstop = 0.9\ntolerance = 1e-9\n",
                TAU * turns
            );
            let mut run = started(&model(&text), None, 0.9, 1e-9);
            if by_turns {
                let mut time = 0.0;
                while time + 1.0 / turns < 0.9 {
                    time += 1.0 / turns;
                    run.step_to(time).unwrap();
                }
            }
            run.step_to(0.9).unwrap();
            let way = (PI / 2.0 - low + TAU * turns * 0.9).rem_euclid(2.0 * (high - low));
            let expected = if way < high - low { low + way } else { 2.0 * high - low - way };
            let found = value(&mut run, "crank.angle");
            assert!((found - expected).abs() < 1e-7, "{turns} {by_turns}: {found}, not {expected}");
        }
    }
}

#[test]
fn inputs_follow_their_ramps_behind_an_impact() {
    let text = r#"
name = "wall"
[inputs]
ramp = { start = 1.0, unit = "N" }
[bodies.block]
mass = 2.0
[joints.rail]
type = "prismatic"
between = ["ground", "block"]
axis = [1, 0]
limits = { max = 0.3, restitution = 0.5 }
[loads.push]
type = "force"
on = "block"
vector = ["ramp", 0]
[initial]
"rail.s" = 0.0
"rail.v" = 0.0
[outputs]
variables = ["rail.s", "rail.v"]
[experiment]
stop = 1.6
tolerance = 1e-10
"#;
    // The force is 1 + 0.4 t: s = t^2/4 + t^3/30 up to the impact, and from there on the same motion with -0.5 of its rate.
    let [s, v] = [|t: f64| t * t / 4.0 + t.powi(3) / 30.0, |t: f64| t / 2.0 + t * t / 10.0];
    let mut hit = 1.0;
    (0..30).for_each(|_| hit -= (s(hit) - 0.3) / v(hit));
    for method in METHODS {
        for parts in [1, 7, 160] {
            let model = model(text);
            let mut run = started(&model, Some(method), 1.6, 1e-10);
            let ramp = run.variable("ramp").unwrap();
            run.set_derivative(ramp, 1, 0.4).unwrap();
            (1..=parts).for_each(|part| run.step_to(1.6 * f64::from(part) / f64::from(parts)).unwrap());
            let exact = 0.3 + s(1.6) - s(hit) - 1.5 * v(hit) * (1.6 - hit);
            let found = value(&mut run, "rail.s");
            assert!((found - exact).abs() < 1e-8, "{method:?} in {parts} parts: {found}, not {exact}");
        }
    }
}
