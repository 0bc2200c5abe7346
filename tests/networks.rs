//! Random networks of first order on four-bars and open chains, which they drive and hear of, against absolute coordinates; their derivatives against differences.

use std::fmt::Write;
use std::sync::Arc;

use crate::sensitivities::check as check_sensitivities;
use crate::support::absolute::{At, Body, Joint, JointKind, Load, State, System};
use crate::support::random::Random;
use crate::support::run::{sound, started, value};

use cotree::compile::compile;
use cotree::scene::Scene;
use cotree_fmu::model::Model;
use cotree_fmu::program::Engine;
use nalgebra::{DMatrix, DVector, Vector2};

const METHODS: [Engine; 3] = [Engine::Taylor, Engine::Dop853, Engine::Radau];
const STOP: f64 = 1.0;
/// Error of what the program gives at a tolerance of 1e-10, beside one and the value.
const LIMIT: f64 = 2e-9;

/// Bars that hang from each other, the last one held by the ground or free, with states that turn them.
struct Network {
    bars: Vec<Bar>,
    /// Where the ground holds the end of the last bar.
    held: Option<Vector2<f64>>,
    /// The rate of the first bar.
    omega: f64,
    states: Vec<Node>,
}

struct Bar {
    length: f64,
    mass: f64,
    angle: f64,
    damping: f64,
}

/// z' = -decay z + angle sin(a) + rate omega + push sin(pace t) + link tanh(z of another) + twist tanh(z times another), with the angle and rate of one bar; a torque on the
/// bar behind a joint, back on the one before it.
struct Node {
    decay: f64,
    bar: usize,
    angle: f64,
    rate: f64,
    push: f64,
    pace: f64,
    link: f64,
    twist: f64,
    others: [usize; 2],
    joint: usize,
    torque: f64,
}

impl Network {
    /// A four-bar for an even seed, an open chain of two to four bars for an odd one; with one to five states.
    fn random(seed: u64) -> Network {
        let mut random = Random(seed.wrapping_mul(0x51_7cc1));
        loop {
            let found = Network::drawn(&mut random, seed.is_multiple_of(2));
            if found.is_far_from_folded() {
                return found;
            }
        }
    }

    fn drawn(random: &mut Random, closed: bool) -> Network {
        // Numbers with so few digits are the same in the text of a scene.
        let round = |value: f64| (1e4 * value).round() / 1e4;
        let number = |random: &mut Random, low: f64, high: f64| round(random.number(low, high));
        let count = if closed { 3 } else { 2 + random.below(3) };
        let mut bar = || Bar {
            length: number(random, 0.3, 1.0),
            mass: number(random, 0.4, 1.5),
            angle: number(random, -3.0, 3.0),
            damping: number(random, 0.1, 0.5),
        };
        let bars: Vec<Bar> = (0..count).map(|_| bar()).collect();
        let omega = number(random, -3.0, 3.0);
        let size = 1 + random.below(5);
        let mut node = || Node {
            bar: random.below(count),
            joint: random.below(count),
            others: [random.below(size), random.below(size)],
            decay: number(random, 0.2, 8.0),
            angle: number(random, -3.0, 3.0),
            rate: number(random, -2.0, 2.0),
            push: number(random, -4.0, 4.0),
            pace: number(random, 0.5, 9.0),
            link: number(random, -2.0, 2.0),
            twist: number(random, -1.5, 1.5),
            torque: number(random, -1.5, 1.5),
        };
        let states = (0..size).map(|_| node()).collect();
        let end: Vector2<f64> = bars.iter().map(|bar| turned(bar.angle) * bar.length).sum();
        Network { bars, held: closed.then(|| end.map(round)), omega, states }
    }

    /// True for a chain, and for a four-bar whose bars are far from one line and close at the angles that they have.
    fn is_far_from_folded(&self) -> bool {
        let Some(held) = self.held else { return true };
        let ways: Vec<Vector2<f64>> = self.bars.iter().map(|bar| turned(bar.angle) * bar.length).collect();
        let lengths = [ways[0].norm(), ways[1].norm(), ways[2].norm(), held.norm()];
        // The four-bar passes no pose in which all bars are in line unless lengths in pairs make the same sum.
        let [a, b, c, d] = lengths;
        let gaps =
            [a + b - c - d, a + c - b - d, a + d - b - c, a - b - c - d, b - a - c - d, c - a - b - d, d - a - b - c];
        ways[1].perp(&ways[2]).abs() > 0.3 * b * c && gaps.iter().all(|gap| gap.abs() > 0.1) && d > 0.3
    }

    fn system(&self) -> System {
        let at = |body: usize, side: f64| At {
            body: Some(body),
            local: Vector2::new(side * self.bars[body].length / 2.0, 0.0),
        };
        let fixed = |place: Vector2<f64>| At { body: None, local: place };
        let pin = |between: [At; 2], damping: f64| Joint { between, kind: JointKind::Revolute, damping };
        let first = |body: usize| if body == 0 { fixed(Vector2::zeros()) } else { at(body - 1, 1.0) };
        let mut joints: Vec<Joint> =
            (0..self.bars.len()).map(|body| pin([first(body), at(body, -1.0)], self.bars[body].damping)).collect();
        joints.extend(self.held.map(|held| pin([fixed(held), at(self.bars.len() - 1, 1.0)], 0.0)));
        let body = |bar: &Bar| Body { mass: bar.mass, inertia: bar.mass * bar.length * bar.length / 12.0 };
        let bodies = self.bars.iter().map(body).collect();
        System { gravity: Vector2::new(0.0, -9.81), bodies, joints, ..System::default() }
    }

    /// Where it begins: the bars as they hang together, the ends of four-bars moved together; the first bar turns.
    fn start(&self, system: &System) -> State {
        let (mut q, mut end) = (Vec::new(), Vector2::zeros());
        for bar in &self.bars {
            let way: Vector2<f64> = turned(bar.angle) * bar.length;
            let middle = end + way / 2.0;
            q.extend([middle.x, middle.y, bar.angle]);
            end += way;
        }
        let count = q.len();
        let mut state = State { q: DVector::from_vec(q), v: DVector::zeros(count) };
        // The first bar stays where it is.
        for _ in 0..20 {
            let now = system.constraints(&state, 0.0);
            state.q -= solved(&with_first(&now.jacobian), &now.residual.clone().push(0.0));
        }
        let now = system.constraints(&state, 0.0);
        let mut turning = DVector::zeros(now.residual.len() + 1);
        turning[now.residual.len()] = self.omega;
        if self.held.is_some() {
            state.v = solved(&with_first(&now.jacobian), &turning);
        } else {
            state.v = self.as_one_body(&state);
        }
        state
    }

    /// Rates of a chain whose bars but the first do not turn.
    fn as_one_body(&self, state: &State) -> DVector<f64> {
        let tip = crate::support::absolute::turned(turned(self.bars[0].angle) * self.bars[0].length) * self.omega;
        let mut v = DVector::zeros(state.q.len());
        for body in 0..self.bars.len() {
            let part = if body == 0 { 0.5 } else { 1.0 };
            (v[3 * body], v[3 * body + 1]) = (part * tip.x, part * tip.y);
        }
        v[2] = self.omega;
        v
    }

    fn rates(&self, pose: &State, z: &[f64], time: f64) -> Vec<f64> {
        let rate = |(own, z_own): (&Node, &f64)| {
            let (angle, omega) = (pose.angle(Some(own.bar)), pose.omega(Some(own.bar)));
            let [first, second] = own.others.map(|other| z[other]);
            -own.decay * z_own
                + own.angle * angle.sin()
                + own.rate * omega
                + own.push * (own.pace * time).sin()
                + own.link * first.tanh()
                + own.twist * (z_own * second).tanh()
        };
        self.states.iter().zip(z).map(rate).collect()
    }

    fn begin(&self) -> Vec<f64> {
        (0..self.states.len()).map(|index| 0.1 * index as f64 - 0.15).collect()
    }

    /// The angles and rates of the bars and the states at the end, in absolute coordinates.
    fn reference(&self) -> Vec<f64> {
        let system = self.system();
        let start = self.start(&system);
        let size = start.q.len();
        let pose = |y: &DVector<f64>| State { q: y.rows(0, size).into_owned(), v: y.rows(size, size).into_owned() };
        let rate = |y: &DVector<f64>, time: f64| {
            let (now, z) = (pose(y), &y.as_slice()[2 * size..]);
            let torque = |(own, z): (&Node, &f64)| Load::Torque {
                between: [own.joint.checked_sub(1), Some(own.joint)],
                value: own.torque * z,
            };
            let loads = self.states.iter().zip(z).map(torque).collect();
            let a = System { loads, ..system.clone() }.solve(&now, time).acceleration;
            let all = now.v.iter().chain(a.iter()).copied().chain(self.rates(&now, z, time));
            DVector::from_iterator(y.len(), all)
        };
        let all = start.q.iter().chain(start.v.iter()).copied().chain(self.begin());
        let mut y = DVector::from_vec(all.collect());
        let (mut time, mut h) = (0.0, 0.01_f64);
        while time < STOP {
            h = h.min(STOP - time);
            let (next, error) = extrapolated(&rate, &y, time, h);
            if error > 1e-12 && h > 1e-5 {
                h *= 0.6;
                continue;
            }
            (y, time) = (next, time + h);
            h *= if error < 1e-14 { 1.5 } else { 1.0 };
            let held = projected(&system, pose(&y));
            y.rows_mut(0, size).copy_from(&held.q);
            y.rows_mut(size, size).copy_from(&held.v);
        }
        let bars = (0..self.bars.len()).flat_map(|body| [y[3 * body + 2], y[size + 3 * body + 2]]);
        bars.chain(y.iter().skip(2 * size).copied()).collect()
    }

    fn names(&self) -> Vec<String> {
        let bars = (0..self.bars.len()).flat_map(|body| [format!("b{body}.angle"), format!("b{body}.omega")]);
        bars.chain((0..self.states.len()).map(|index| format!("z{index}"))).collect()
    }

    /// The scene; the torques of the states are parameters, so that derivatives can be asked for.
    fn scene(&self) -> String {
        let system = self.system();
        let start = self.start(&system);
        let mut text = String::from("name = \"network\"\ngravity = [0, -9.81]\n[parameters]\n");
        for (index, node) in self.states.iter().enumerate() {
            writeln!(text, "k{index} = {:?}", node.torque).unwrap();
        }
        text += "[states]\n";
        for (index, (node, begin)) in self.states.iter().zip(self.begin()).enumerate() {
            let Node { decay, bar, angle, rate, push, pace, link, twist, others: [first, second], .. } = node;
            writeln!(
                text,
                "z{index} = {{ start = {begin:?}, rate = \"-{decay:?}*z{index} + ({angle:?})*sin(b{bar}.angle) + ({rate:?})*b{bar}.omega + ({push:?})*sin({pace:?}*t) + ({link:?})*tanh(z{first}) + ({twist:?})*tanh(z{index}*z{second})\" }}"
            )
            .unwrap();
        }
        if let Some(held) = self.held {
            writeln!(text, "[ground.points]\nend = [{:?}, {:?}]", held.x, held.y).unwrap();
        }
        for (index, bar) in self.bars.iter().enumerate() {
            let Bar { length, mass, damping, .. } = bar;
            let (half, inertia) = (length / 2.0, mass * length * length / 12.0);
            let before = if index == 0 { "ground".to_owned() } else { format!("b{}.q", index - 1) };
            writeln!(
                text,
                "[bodies.b{index}]\nmass = {mass:?}\ninertia = {inertia:?}\npoints = {{ p = [-{half:?}, 0], q = [{half:?}, 0] }}\n[joints.j{index}]\ntype = \"revolute\"\nbetween = [\"{before}\", \"b{index}.p\"]\ndamping = {damping:?}"
            )
            .unwrap();
        }
        if self.held.is_some() {
            let last = self.bars.len() - 1;
            writeln!(text, "[joints.end]\ntype = \"revolute\"\nbetween = [\"ground.end\", \"b{last}.q\"]").unwrap();
        }
        for (index, node) in self.states.iter().enumerate() {
            let before = node.joint.checked_sub(1).map_or("ground".to_owned(), |before| format!("b{before}"));
            let joint = node.joint;
            writeln!(text, "[loads.t{index}]\ntype = \"torsion_actuator\"\nbetween = [\"{before}\", \"b{joint}\"]\ntorque = \"k{index}*z{index}\"").unwrap();
        }
        text += "[initial]\n";
        for index in 0..self.bars.len() {
            let known = index == 0 || self.held.is_none();
            let (angle, omega) = (start.q[3 * index + 2], start.v[3 * index + 2]);
            match known {
                true => writeln!(text, "\"b{index}.angle\" = {angle:?}\n\"b{index}.omega\" = {omega:?}").unwrap(),
                false => writeln!(text, "\"b{index}.angle\" = {{ guess = {angle:?} }}").unwrap(),
            }
        }
        let names: Vec<String> = self.names().iter().map(|name| format!("\"{name}\"")).collect();
        writeln!(text, "[outputs]\nvariables = [{}]", names.join(", ")).unwrap();
        text
    }
}

/// How fast everything changes, at a time.
type Rate<'r> = &'r dyn Fn(&DVector<f64>, f64) -> DVector<f64>;

fn turned(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.cos(), angle.sin())
}

/// A row more, of the first bar's angle.
fn with_first(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let mut more = jacobian.clone().insert_row(jacobian.nrows(), 0.0);
    more[(jacobian.nrows(), 2)] = 1.0;
    more
}

/// The least x with a x = b.
fn solved(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let square = (a * a.transpose()).lu().solve(b).expect("rows that are independent");
    a.transpose() * square
}

/// The nearest state that closes the loops, and rates that keep them closed.
fn projected(system: &System, mut state: State) -> State {
    for _ in 0..2 {
        let now = system.constraints(&state, 0.0);
        state.q -= solved(&now.jacobian, &now.residual);
    }
    let now = system.constraints(&state, 0.0);
    state.v -= solved(&now.jacobian, &(&now.jacobian * &state.v));
    state
}

/// A step by Gragg's midpoint rule, extrapolated to its limit (Bulirsch, Stoer 1966; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.9): order 12,
/// and how far order 10 is from it, beside one and the values.
fn extrapolated(rate: Rate<'_>, y: &DVector<f64>, time: f64, h: f64) -> (DVector<f64>, f64) {
    let first = rate(y, time);
    let mut last: Vec<DVector<f64>> = Vec::new();
    for row in 1..=6 {
        let parts = 2 * row;
        let part = h / f64::from(parts);
        let (mut before, mut now) = (y.clone(), y + &first * part);
        for step in 1..parts {
            let next = &before + rate(&now, time + part * f64::from(step)) * (2.0 * part);
            (before, now) = (now, next);
        }
        let mut own = vec![now];
        for (column, coarse) in last.iter().enumerate() {
            let ratio = f64::from(row) / f64::from(row - 1 - column as i32);
            let best = &own[column] + (&own[column] - coarse) / (ratio * ratio - 1.0);
            own.push(best);
        }
        last = own;
    }
    let gap = last[5].zip_map(&last[4], |best, other| (best - other).abs() / (1.0 + best.abs())).max();
    (last.swap_remove(5), gap)
}

fn check(seed: u64) {
    let network = Network::random(seed);
    let text = network.scene();
    let program = sound(Scene::from_toml(&text).and_then(|scene| compile(&scene))).program;
    let engine = METHODS[(seed / 2 % 3) as usize];
    let mut run = started(&Arc::new(Model::new(program).unwrap()), Some(engine), STOP, 1e-10);
    run.step_to(STOP).unwrap();
    for (name, expected) in network.names().iter().zip(network.reference()) {
        let found = value(&mut run, name);
        let close = (found - expected).abs() < LIMIT * (1.0 + expected.abs());
        assert!(close, "network {seed}, {engine:?}: {name} is {found}, not {expected}\n{text}");
    }
}

#[test]
fn networks_agree_with_absolute_coordinates() {
    (0..6).for_each(check);
}

#[test]
#[ignore = "a hundred of them: .ci/nightly"]
fn a_hundred_networks_agree_with_absolute_coordinates() {
    (0..100).for_each(check);
}

/// By the torques and by where the motion and the states begin.
fn check_derivatives(seed: u64) {
    let text = Network::random(seed).scene();
    check_sensitivities(&text, &["k0", "z0", "b0.angle", "b0.omega"], 0.6, 1e-3, 1e-7);
}

#[test]
fn derivatives_of_networks_agree_with_differences() {
    [2, 3].into_iter().for_each(check_derivatives);
}

#[test]
#[ignore = "many: .ci/nightly"]
fn derivatives_of_thirty_networks_agree_with_differences() {
    (0..30).for_each(check_derivatives);
}
