//! Random mechanisms that are consistent by construction: the bodies are placed first, the joints are put where they close, and
//! the velocities are projected on what joints and drivers permit.

use super::absolute::{At, Body, Driver, Joint, JointKind, Load, State, System};
use super::loads::slide;
use super::scene_text::scene_text;
use super::variables::{Variables, variables};
use nalgebra::{DVector, Rotation2, Vector2};
use std::f64::consts::PI;

/// What kind of mechanism to make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Each body hangs from the one before.
    Chain,
    /// Each body hangs from any body before it or from the ground; some float free.
    Tree,
    /// A tree with one or two loops; all constraints are independent.
    Loops,
    /// Loops and drivers; all constraints are independent.
    Driven,
    /// Loops with a joint that repeats what others already hold: reactions are not unique.
    Redundant,
}

/// A mechanism in a random state, as a scene and solved in absolute coordinates.
pub struct Case {
    pub scene: String,
    pub expected: Variables,
    pub system: System,
    pub state: State,
}

/// The mechanism of a seed; the same seed gives the same mechanism on every machine.
pub fn random_case(seed: u64, family: Family) -> Case {
    let mut random = Random(seed);
    loop {
        let (system, state) = Draft::new(&mut random, family).finish(family);
        if well_posed(&system, &state, family) {
            let expected = variables(&system, &state, 0.0);
            let scene = scene_text(&format!("random_{seed}"), &system, &state, &expected);
            return Case { scene, expected, system, state };
        }
    }
}

/// Is every constraint clearly independent of the others, or (redundant family) clearly a repetition?
fn well_posed(system: &System, state: &State, family: Family) -> bool {
    let jacobian = system.constraints(state, 0.0).jacobian;
    let (rows, columns) = jacobian.shape();
    if rows == 0 {
        return family != Family::Redundant;
    }
    let values = jacobian.singular_values();
    let clear = |s: &f64| *s > 0.05;
    let vague = values.iter().any(|s| !clear(s) && *s > 1e-10);
    let rank = values.iter().filter(|s| clear(s)).count();
    let looped = !matches!(family, Family::Loops | Family::Driven) || system.joints.len() > system.bodies.len();
    let free = rank < columns || family == Family::Driven;
    looped && free && !vague && (rank < rows) == (family == Family::Redundant)
}

pub use super::hard::random::Random;

impl Random {
    /// Uniform in `low..high`.
    pub fn number(&mut self, low: f64, high: f64) -> f64 {
        self.between(low, high)
    }

    /// Uniform in `0..n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.number(0.0, n as f64) as usize).min(n - 1)
    }

    pub fn chance(&mut self, probability: f64) -> bool {
        self.number(0.0, 1.0) < probability
    }

    pub fn vector(&mut self, size: f64) -> Vector2<f64> {
        Vector2::new(self.number(-size, size), self.number(-size, size))
    }
}

/// A mechanism in the making.
struct Draft<'a> {
    random: &'a mut Random,
    system: System,
    state: State,
}

impl<'a> Draft<'a> {
    /// Bodies anywhere, joined as the family says, with a few loads.
    fn new(random: &'a mut Random, family: Family) -> Self {
        let count =
            if family == Family::Chain || family == Family::Tree { 1 + random.below(6) } else { 3 + random.below(4) };
        let body = |random: &mut Random| Body { mass: random.number(0.5, 3.0), inertia: random.number(0.05, 0.5) };
        let system = System {
            gravity: random.vector(10.0),
            bodies: (0..count).map(|_| body(random)).collect(),
            ..System::default()
        };
        let size = [1.0, 1.0, PI];
        let q = DVector::from_fn(3 * count, |i, _| random.number(-size[i % 3], size[i % 3]));
        let v = DVector::from_fn(3 * count, |_, _| random.number(-2.0, 2.0));
        let mut draft = Draft { random, system, state: State { q, v } };
        for child in 0..count {
            draft.hang(child, family);
        }
        match family {
            Family::Chain | Family::Tree => {}
            Family::Loops | Family::Driven => draft.close_loops(),
            Family::Redundant => draft.repeat_joint(),
        }
        for _ in 0..draft.random.below(5) {
            draft.load();
        }
        draft
    }

    fn finish(mut self, family: Family) -> (System, State) {
        if family == Family::Driven {
            self.drive();
        }
        self.state.v = self.system.permitted_velocity(&self.state, 0.0);
        (self.system, self.state)
    }

    /// Joins a body to one before it.
    fn hang(&mut self, child: usize, family: Family) {
        if family == Family::Tree && self.random.chance(0.1) {
            return;
        }
        let parent =
            if family == Family::Chain { child.checked_sub(1) } else { self.random.below(child + 1).checked_sub(1) };
        let kind = self.random.number(0.0, 1.0);
        let weld = if family == Family::Loops || family == Family::Driven { 0.05 } else { 0.15 };
        if kind < weld {
            self.weld(parent, Some(child));
        } else if kind < 0.35 {
            self.prismatic(parent, Some(child));
        } else {
            self.revolute(parent, Some(child));
        }
    }

    /// One or two more joints between bodies that are not joined directly, as long as a freedom is left.
    fn close_loops(&mut self) {
        for _ in 0..1 + self.random.below(2) {
            let [a, b] = self.two_bodies();
            let joined = self.system.joints.iter().any(|j| j.bodies() == [a, b] || j.bodies() == [b, a]);
            let held = self.system.constraints(&self.state, 0.0).gamma.len();
            if joined || held + 2 >= 3 * self.system.bodies.len() {
                continue;
            }
            if self.random.chance(0.3) { self.prismatic(a, b) } else { self.revolute(a, b) }
        }
    }

    /// A second joint that permits the very motion of an existing one.
    fn repeat_joint(&mut self) {
        let i = self.random.below(self.system.joints.len());
        let mut twin = self.system.joints[i].clone();
        if let JointKind::Prismatic { axis, .. } = twin.kind {
            twin.between[0].local += self.random.number(-0.5, 0.5) * axis;
        }
        self.system.joints.push(twin);
    }

    /// Two different bodies; at most one is the ground.
    fn two_bodies(&mut self) -> [Option<usize>; 2] {
        let choices = self.system.bodies.len() + 1;
        let first = self.random.below(choices);
        let second = (first + 1 + self.random.below(choices - 1)) % choices;
        [first.checked_sub(1), second.checked_sub(1)]
    }

    /// The body's own name for a place in the world.
    fn at(&self, body: Option<usize>, world: Vector2<f64>) -> At {
        let centre = body.map_or(Vector2::zeros(), |b| Vector2::new(self.state.q[3 * b], self.state.q[3 * b + 1]));
        At { body, local: Rotation2::new(-self.state.angle(body)) * (world - centre) }
    }

    fn relative_angle(&self, a: Option<usize>, b: Option<usize>) -> f64 {
        self.state.angle(b) - self.state.angle(a)
    }

    /// Half of all joints name the child first.
    fn shuffled(&mut self, a: Option<usize>, b: Option<usize>) -> [Option<usize>; 2] {
        if self.random.chance(0.5) { [a, b] } else { [b, a] }
    }

    fn join(&mut self, between: [At; 2], kind: JointKind) {
        let damping = if self.random.chance(0.3) { self.random.number(0.0, 1.0) } else { 0.0 };
        self.system.joints.push(Joint { between, kind, damping });
    }

    fn revolute(&mut self, a: Option<usize>, b: Option<usize>) {
        let pin = self.random.vector(1.0);
        let between = self.shuffled(a, b).map(|body| self.at(body, pin));
        self.join(between, JointKind::Revolute);
    }

    fn weld(&mut self, a: Option<usize>, b: Option<usize>) {
        let spot = self.random.vector(1.0);
        let [a, b] = self.shuffled(a, b);
        let angle = self.relative_angle(a, b);
        self.join([self.at(a, spot), self.at(b, spot)], JointKind::Weld { angle });
    }

    fn prismatic(&mut self, a: Option<usize>, b: Option<usize>) {
        let [a, b] = self.shuffled(a, b);
        let (start, direction) = (self.random.vector(1.0), Rotation2::new(self.random.number(-PI, PI)));
        let end = start + self.random.number(-1.0, 1.0) * (direction * Vector2::x());
        let axis = Rotation2::new(-self.state.angle(a)) * (direction * Vector2::x());
        let angle = self.relative_angle(a, b);
        self.join([self.at(a, start), self.at(b, end)], JointKind::Prismatic { axis, angle });
    }

    fn load(&mut self) {
        let between = self.two_bodies();
        let ends = between.map(|body| {
            let place = self.random.vector(1.0);
            self.at(body, place)
        });
        let on = self.random.below(self.system.bodies.len());
        let load = match self.random.below(4) {
            0 => Load::Force {
                on: At { body: Some(on), ..ends[0] },
                vector: self.random.vector(5.0),
                in_body: self.random.chance(0.5),
            },
            1 => Load::Torque { between, value: self.random.number(-5.0, 5.0) },
            2 => Load::TorsionSpring {
                between,
                stiffness: self.random.number(0.0, 20.0),
                angle: self.random.number(-PI, PI),
                damping: self.random.number(0.0, 1.0),
            },
            _ => Load::Spring {
                between: ends,
                stiffness: self.random.number(0.0, 50.0),
                length: self.random.number(0.1, 1.0),
                damping: self.random.number(0.0, 2.0),
            },
        };
        let too_short = matches!(load, Load::Spring { between, .. } if self.state.line(between).1 < 0.3);
        if !too_short {
            self.system.loads.push(load);
        }
    }

    /// One driver, of a point or of a joint.
    fn drive(&mut self) {
        let driven = self.random.below(self.system.joints.len());
        let joint = &self.system.joints[driven];
        let (between, state) = (joint.bodies(), &self.state);
        let (rate, acceleration) = (self.random.number(-2.0, 2.0), self.random.number(-3.0, 3.0));
        let driver = match joint.kind {
            JointKind::Revolute if self.random.chance(0.8) => {
                let start = state.angle(between[1]) - state.angle(between[0]);
                Driver::Angle { between, motion: [start, rate, acceleration] }
            }
            JointKind::Prismatic { axis, .. } if self.random.chance(0.8) => {
                let start = slide(joint, axis, state).0;
                Driver::Displacement { joint: driven, motion: [start, rate, acceleration] }
            }
            _ => {
                let body = self.random.below(self.system.bodies.len());
                let on = At { body: Some(body), local: self.random.vector(0.5) };
                Driver::Position { on, motion: [state.position(on), self.random.vector(1.0), self.random.vector(2.0)] }
            }
        };
        self.system.drivers.push(driver);
    }
}
