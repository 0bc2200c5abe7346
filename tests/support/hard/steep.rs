//! Steep laws: dry friction, stops, bumps in time and in position. Each motion has one coordinate x, whose acceleration is written out here a second time and
//! integrated by Gragg's method, piece by piece.

use std::f64::consts::PI;

use cotree::scene::{Body, Driver, Joint, Load, Scene};

use super::pieces::Pieces;
use super::reference::Reference;
use super::{COMPARED_TOLERANCES, Case, Random};

const TIMES: u32 = 10;

/// A scene whose variables `names` are the coordinate and its rate.
fn case(
    family: &'static str,
    scene: Scene,
    motion: ([&str; 2], f64),
    start: [f64; 2],
    law: impl Fn(f64, f64, f64) -> f64,
) -> Case {
    let whole = Pieces { switches: |_: f64, _: &[f64]| [], law: |t: f64, y: &[f64], []: [bool; 0]| law(t, y[0], y[1]) };
    case_in_pieces(family, scene, motion, start, &whole)
}

/// The same with a law in pieces.
fn case_in_pieces<const N: usize>(
    family: &'static str,
    scene: Scene,
    (names, stop): ([&str; 2], f64),
    start: [f64; 2],
    pieces: &Pieces<impl Fn(f64, &[f64]) -> [f64; N], impl Fn(f64, &[f64], [bool; N]) -> f64>,
) -> Case {
    motion_of_one(family, scene, (names, stop), start, |times| pieces.states(start, times))
}

/// The same with a reference that is found otherwise: coordinate and rate at each of the times, which ascend; nothing if the laws switch back and forth.
pub(super) fn motion_of_one(
    family: &'static str,
    scene: Scene,
    (names, stop): ([&str; 2], f64),
    start: [f64; 2],
    states: impl FnOnce(&[f64]) -> Option<Vec<Vec<f64>>>,
) -> Case {
    let times: Vec<f64> = (1..=TIMES).map(|k| stop * f64::from(k) / f64::from(TIMES)).collect();
    let scene = scene.initial(names[0], start[0]).initial(names[1], start[1]);
    let case = Case::new(family, scene, stop, vec![]).driven();
    match states(&times) {
        Some(values) => {
            let names = names.map(String::from).into();
            case.against(Reference { names, times, values }).within(1000.0, 1e-7)
        }
        None => case.refused("chatters").at(&COMPARED_TOLERANCES),
    }
}

pub(super) const BLOCK: [&str; 2] = ["block.x", "block.vx"];

/// How far behind the block the wall is, which its spring is fixed to: the block never comes there \[m\].
const WALL: f64 = 5.0;

/// A block on a guide.
fn guide(name: &str, seed: u64, mass: f64) -> Scene {
    Scene::new(&format!("{name}_{seed}")).ground_point("wall", [-WALL, 0.0]).body("block", Body::new().mass(mass))
}

pub(super) fn smooth_guide(name: &str, seed: u64) -> Scene {
    guide(name, seed, 1.0).prismatic("guide", "ground", "block", [1.0, 0.0])
}

pub(super) fn push(scene: Scene, law: &str) -> Scene {
    let force: [cotree::scene::Quantity; 2] = [law.into(), 0.0.into()];
    scene.load("push", Load::force("block", force))
}

pub(super) fn spring(scene: Scene, stiffness: f64) -> Scene {
    scene.load("spring", Load::spring("ground.wall", "block", stiffness).free(WALL))
}

/// Between two numbers, by their logarithms.
pub(super) fn size(random: &mut Random, low: f64, high: f64) -> f64 {
    random.between(low.ln(), high.ln()).exp()
}

fn dry(random: &mut Random) -> [f64; 2] {
    [size(random, 1.0, 10.0), size(random, 1e-3, 1e-2)]
}

fn sliding([coulomb, velocity]: [f64; 2]) -> Joint {
    Joint::prismatic("ground", "block", [1.0, 0.0]).friction(coulomb, velocity)
}

/// A block on a belt, held by a spring: it sticks and slips.
pub fn belt(seed: u64) -> Case {
    let mut random = Random(seed);
    let (friction, mass, k) = (dry(&mut random), size(&mut random, 0.3, 3.0), size(&mut random, 30.0, 500.0));
    let (speed, x) = (random.between(0.05, 0.5), random.between(0.05, 0.4));
    let [coulomb, velocity] = friction;
    let scene = guide("belt", seed, mass)
        .body("belt", Body::new().mass(1.0))
        .prismatic("track", "ground", "belt", [1.0, 0.0])
        .joint("contact", Joint::prismatic("belt", "block", [1.0, 0.0]).friction(coulomb, velocity))
        .driver("motor", Driver::displacement("track", format!("{speed}*t").as_str()));
    let law = move |_: f64, x: f64, v: f64| (-k * x - coulomb * ((v - speed) / velocity).tanh()) / mass;
    case("steep: belt", spring(scene, k), (BLOCK, 3.0), [x, 0.0], law)
}

/// A block on a spring comes to rest by friction.
pub fn rest(seed: u64) -> Case {
    let mut random = Random(seed);
    let (friction, mass, k) = (dry(&mut random), size(&mut random, 0.3, 3.0), size(&mut random, 30.0, 500.0));
    let x = random.between(0.2, 0.6);
    let scene = guide("rest", seed, mass).joint("guide", sliding(friction));
    let law = move |_: f64, x: f64, v: f64| (-k * x - friction[0] * (v / friction[1]).tanh()) / mass;
    case("steep: block on spring", spring(scene, k), (BLOCK, 3.0), [x, 0.0], law)
}

/// A block that slides on the ground and on a belt at once.
pub fn two_contacts(seed: u64) -> Case {
    let mut random = Random(seed);
    let (below, [coulomb, velocity]) = (dry(&mut random), dry(&mut random));
    let (k, speed, x) = (size(&mut random, 30.0, 500.0), random.between(-0.5, 0.5), random.between(0.1, 0.6));
    let scene = guide("two", seed, 1.0).joint("guide", sliding(below));
    let scene = push(scene, &format!("-{coulomb}*tanh((block.vx-({speed}))/{velocity})"));
    let law = move |_: f64, x: f64, v: f64| {
        -k * x - below[0] * (v / below[1]).tanh() - coulomb * ((v - speed) / velocity).tanh()
    };
    case("steep: two contacts", spring(scene, k), (BLOCK, 3.0), [x, 0.0], law)
}

const DISC: [&str; 2] = ["disc.angle", "disc.omega"];

/// A flywheel stopped by a brake that closes at some time, then driven on.
pub fn brake(seed: u64) -> Case {
    let mut random = Random(seed);
    let ([torque, velocity], inertia) = (dry(&mut random), size(&mut random, 0.3, 1.0));
    let (omega, closes, drive) = (random.between(1.0, 8.0), random.between(0.2, 0.8), random.between(-1.5, 1.5));
    let scene = Scene::new(&format!("brake_{seed}"))
        .body("disc", Body::new().mass(1.0).inertia(inertia))
        .revolute("axle", "ground", "disc");
    let brake = format!("if(t < {closes}, 0, -{torque}*tanh(disc.omega/{velocity})) + ({drive})*{torque}*sin(3*t)");
    let scene = scene.load("brake", Load::torque("ground", "disc", brake.as_str()));
    let law = move |t: f64, y: &[f64], [closed]: [bool; 1]| {
        let grip = if closed { -torque * (y[1] / velocity).tanh() } else { 0.0 };
        (grip + drive * torque * (3.0 * t).sin()) / inertia
    };
    let pieces = Pieces { switches: |t: f64, _: &[f64]| [t - closes], law };
    case_in_pieces("steep: brake", scene, (DISC, 3.0), [0.0, omega], &pieces)
}

/// A pendulum with friction in its joint.
pub fn pendulum(seed: u64) -> Case {
    let mut random = Random(seed);
    let (torque, velocity) = (size(&mut random, 0.1, 2.0), size(&mut random, 1e-3, 1e-2));
    let angle = random.between(-1.2, 1.2);
    let scene = Scene::new(&format!("pendulum_{seed}"))
        .gravity([0.0, -9.81])
        .body("disc", Body::new().mass(1.0).inertia(0.1).point("pin", [-0.5, 0.0]))
        .joint("pin", Joint::revolute("ground", "disc.pin").friction(torque, velocity));
    let law = move |_: f64, x: f64, v: f64| (-9.81 * 0.5 * x.cos() - torque * (v / velocity).tanh()) / 0.35;
    case("steep: pendulum", scene, (DISC, 3.0), [angle, 0.0], law)
}

/// A narrow push at some time, on a spring.
pub fn bump_in_time(seed: u64) -> Case {
    let mut random = Random(seed);
    let (center, width) = (random.between(0.3, 2.5), size(&mut random, 3e-4, 1e-2));
    let (force, k) = (size(&mut random, 0.1, 1.0) / width, size(&mut random, 5.0, 50.0));
    let (x, v) = (random.between(0.1, 0.4), random.between(-1.0, 1.0));
    let scene = push(smooth_guide("instant", seed), &format!("{force}*exp(-((t-{center})/{width})^2/2)"));
    let law = move |t: f64, x: f64, _: f64| -k * x + force * (-((t - center) / width).powi(2) / 2.0).exp();
    case("steep: bump in time", spring(scene, k), (BLOCK, 3.0), [x, v], law)
}

/// A motion at some velocity across a narrow law of position, of one of three shapes.
pub fn bump_in_position(seed: u64) -> Case {
    let mut random = Random(seed);
    let (center, width) = (random.between(0.3, 2.0), size(&mut random, 3e-4, 1e-2));
    let v = random.between(1.0, 3.0);
    let force = size(&mut random, 0.01, 0.3) * v * v / width / 2.5;
    let u = format!("(block.x-{center})/{width}");
    let shape: (String, fn(f64) -> f64) = match seed % 3 {
        0 => (format!("exp(-({u})^2/2)"), |u| (-u * u / 2.0).exp()),
        1 => (format!("1/(1+({u})^2)"), |u| 1.0 / (1.0 + u * u)),
        _ => (format!("(1-tanh({u})^2)"), |u| 1.0 - u.tanh().powi(2)),
    };
    let scene = push(smooth_guide("place", seed), &format!("{force}*{}", shape.0));
    let law = move |_: f64, x: f64, _: f64| force * shape.1((x - center) / width);
    case("steep: bump in position", scene, (BLOCK, 3.0), [0.0, v], law)
}

/// Pushes again and again, each narrow.
pub fn train(seed: u64) -> Case {
    let mut random = Random(seed);
    let (period, width) = (random.between(0.1, 0.4), size(&mut random, 3e-3, 5e-2));
    let force = size(&mut random, 1.0, 5.0);
    let scene = push(smooth_guide("train", seed), &format!("{force}*exp(-(sin({PI}*t/{period})/{width})^2)"));
    let law = move |t: f64, _: f64, _: f64| force * (-((PI * t / period).sin() / width).powi(2)).exp();
    case("steep: train of bumps", scene, (BLOCK, 3.0), [0.0, 0.0], law)
}

/// Narrow bumps on the way of a block, one after the other.
pub fn train_in_position(seed: u64) -> Case {
    let mut random = Random(7300 + seed);
    let (period, width) = (random.between(0.1, 0.4), size(&mut random, 3e-3, 5e-2));
    let (force, v) = (random.between(1.0, 3.0), random.between(1.0, 2.0));
    let scene = push(smooth_guide("washboard", seed), &format!("{force}*exp(-(sin({PI}*block.x/{period})/{width})^2)"));
    let law = move |_: f64, x: f64, _: f64| force * (-((PI * x / period).sin() / width).powi(2)).exp();
    case("steep: train of bumps in position", scene, (BLOCK, 3.0), [0.0, v], law)
}

/// Short pushes in pieces, by time or by the place of a second block that moves like time: nothing acts between them.
pub fn pulses(seed: u64) -> Case {
    let mut random = Random(7400 + seed);
    let (rate, level, shift) = (random.between(8.0, 80.0), random.between(0.5, 0.99), random.between(0.0, 3.0));
    let (force, v) = (random.between(1.0, 5.0) / (1.0 - level), random.between(1.0, 2.0));
    let by_time = seed.is_multiple_of(2);
    let variable = if by_time { "t" } else { "clock.x" };
    let scene = smooth_guide("pulses", seed).initial("block.x", 0.0).initial("block.vx", v);
    let scene = push(scene, &format!("{force}*max(0, sin({rate}*{variable}+{shift})-{level})"));
    let clock = |scene: Scene| {
        let scene = scene.body("clock", Body::new().mass(1.0)).prismatic("hand", "ground", "clock", [1.0, 0.0]);
        scene.initial("clock.x", 0.0).initial("clock.vx", 1.0)
    };
    let pulses = Pulses { rate, level, shift };
    let times: Vec<f64> = (1..=TIMES).map(|k| 0.3 * f64::from(k)).collect();
    let motion = |&time: &f64| {
        let [x, rate] = pulses.integrals(time);
        vec![v * time + force * x, v + force * rate]
    };
    let reference =
        Reference { names: BLOCK.map(String::from).into(), values: times.iter().map(motion).collect(), times };
    let scene = if by_time { scene } else { clock(scene) };
    // Each of some 70 corners costs a Runge-Kutta step some tolerances; a pulse is more than 1e-3.
    Case::new("steep: train of pulses", scene, 3.0, vec![]).driven().against(reference).within(1e4, 1e-6)
}

/// max(0, sin(rate t + shift) - level)
struct Pulses {
    rate: f64,
    level: f64,
    shift: f64,
}

impl Pulses {
    /// The second and the first integral from zero.
    fn integrals(&self, time: f64) -> [f64; 2] {
        let Self { rate, level, shift } = *self;
        let (rise, fall) = (level.asin(), PI - level.asin());
        let once = |t: f64| -(rate * t + shift).cos() / rate - level * t;
        let twice = |t: f64| -(rate * t + shift).sin() / (rate * rate) - level * t * t / 2.0;
        let (mut sums, mut turn) = ([0.0; 2], -1.0);
        loop {
            let [from, to] = [rise, fall].map(|angle| ((angle + 2.0 * PI * turn - shift) / rate).clamp(0.0, time));
            if from >= time {
                return sums;
            }
            let gained = once(to) - once(from);
            sums[0] += twice(to) - twice(from) - once(from) * (to - from) + gained * (time - to);
            sums[1] += gained;
            turn += 1.0;
        }
    }
}

/// A force that changes by a logistic law, in position or in time; far from the change the exponential is beyond all numbers.
pub fn logistic(seed: u64) -> Case {
    let mut random = Random(seed);
    let (center, width) = (random.between(0.3, 1.5), size(&mut random, 3e-4, 1e-2));
    let (force, v) = (size(&mut random, 1.0, 5.0), random.between(1.0, 3.0));
    let (variable, in_time) = if seed.is_multiple_of(2) { ("block.x", false) } else { ("t", true) };
    let scene = push(smooth_guide("logistic", seed), &format!("-{force}/(1+exp(({variable}-{center})/{width})) + 1"));
    let law =
        move |t: f64, x: f64, _: f64| 1.0 - force / (1.0 + (((if in_time { t } else { x }) - center) / width).exp());
    case("steep: logistic", scene, (BLOCK, 3.0), [0.0, v], law)
}

/// Thrown against a stop: in full, or so that it hardly touches it.
pub fn stop(seed: u64) -> Case {
    let mut random = Random(seed);
    let (pull, k, v) = (random.between(1.0, 5.0), size(&mut random, 1e3, 1e6), random.between(1.0, 3.0));
    let touch = if seed.is_multiple_of(2) { size(&mut random, 1e-5, 1e-3) } else { random.between(0.02, 0.1) };
    let edge = v * v / (2.0 * pull) - touch;
    let scene = push(smooth_guide("stop", seed), &format!("-{pull} - {k}*max(0, block.x-{edge})"));
    let states = |times: &[f64]| Some(times.iter().map(|&time| stopped([pull, k, v, edge], time).to_vec()).collect());
    motion_of_one("steep: stop", scene, (BLOCK, 2.0 * v / pull), [0.0, v], states)
}

/// Place and velocity: a throw, half an oscillation about a place in the stop, and the throw backwards.
fn stopped([pull, k, v, edge]: [f64; 4], time: f64) -> [f64; 2] {
    let touch = v * v / (2.0 * pull) - edge;
    let (meets, frequency) = ((2.0 * pull * touch).sqrt(), k.sqrt());
    let arrival = (v - meets) / pull;
    let leaving = arrival + 2.0 * (meets / frequency).atan2(pull / k) / frequency;
    let phase = frequency * (time - arrival);
    let thrown = |from: f64, v: f64, time: f64| [from + time * (v - 0.5 * pull * time), v - pull * time];
    match time {
        _ if time < arrival => thrown(0.0, v, time),
        _ if time < leaving => [
            edge + pull / k * (phase.cos() - 1.0) + meets / frequency * phase.sin(),
            meets * phase.cos() - pull / frequency * phase.sin(),
        ],
        _ => thrown(edge, -meets, time - leaving),
    }
}

/// A law in two pieces of the velocity, with a jump, and one with a corner. A block that is pushed back from both sides is refused.
pub fn pieces(seed: u64) -> Case {
    let mut random = Random(seed);
    let (force, rate, v) = (size(&mut random, 1.0, 10.0), random.between(2.0, 6.0), random.between(0.5, 2.0));
    let law =
        format!("if(block.vx > 0, -{force}, {}) + {}*sin({rate}*t) - min(0, 3*block.x)", force / 3.0, 4.0 * force);
    let scene = push(smooth_guide("pieces", seed), &law);
    let law = move |t: f64, y: &[f64], [on, ahead]: [bool; 2]| {
        let spring = if ahead { 0.0 } else { -3.0 * y[0] };
        (if on { -force } else { force / 3.0 }) + 4.0 * force * (rate * t).sin() + spring
    };
    let pieces = Pieces { switches: |_: f64, y: &[f64]| [y[1], y[0]], law };
    case_in_pieces("steep: if and min", scene, (BLOCK, 3.0), [0.0, v], &pieces)
}

/// A block drawn past the point where its spring is fixed: within a short way the spring turns round.
pub fn anchor(seed: u64) -> Case {
    let mut random = Random(seed);
    let (aside, k, free) = (size(&mut random, 1e-5, 1e-2), size(&mut random, 5.0, 50.0), random.between(0.1, 0.5));
    let (x, v) = (random.between(-0.5, -0.1), random.between(1.0, 3.0));
    let scene = smooth_guide("anchor", seed).ground_point("anchor", [0.5, aside]);
    let scene = scene.load("spring", Load::spring("ground.anchor", "block", k).free(free));
    let law = move |_: f64, x: f64, _: f64| {
        let length = (x - 0.5).hypot(aside);
        -k * (length - free) * (x - 0.5) / length
    };
    case("steep: spring past its anchor", scene, (BLOCK, 2.0), [x, v], law)
}
