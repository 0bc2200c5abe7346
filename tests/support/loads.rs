//! The given loads of a system in absolute coordinates: gravity, springs, dampers, forces, torques; and its energy.

use super::absolute::{At, Body, Joint, JointKind, Load, State, System, turned};
use nalgebra::{DVector, Vector2};

pub fn cross(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

impl System {
    /// All given loads on the bodies' coordinates: gravity, loads and damping in joints.
    pub fn applied(&self, state: &State) -> DVector<f64> {
        let mut sum = Loads { state, on: DVector::zeros(3 * self.bodies.len()) };
        for (i, body) in self.bodies.iter().enumerate() {
            sum.force(At { body: Some(i), local: Vector2::zeros() }, body.mass * self.gravity);
        }
        for joint in &self.joints {
            sum.damp(joint);
        }
        for load in &self.loads {
            sum.load(load);
        }
        sum.on
    }

    pub fn kinetic_energy(&self, state: &State) -> f64 {
        state.v.component_mul(&self.masses()).dot(&state.v) / 2.0
    }

    /// Gravity (zero at the origin) and springs.
    pub fn potential_energy(&self, state: &State) -> f64 {
        let weight = |(i, body): (usize, &Body)| -body.mass * self.gravity.dot(&State::vector(&state.q, i));
        let spring = |load: &Load| match *load {
            Load::Spring { between, stiffness, length, .. } => {
                stiffness * (state.line(between).1 - length).powi(2) / 2.0
            }
            Load::TorsionSpring { between, stiffness, angle, .. } => {
                stiffness * (state.angle(between[1]) - state.angle(between[0]) - angle).powi(2) / 2.0
            }
            Load::Force { .. } | Load::Torque { .. } => 0.0,
        };
        self.bodies.iter().enumerate().map(weight).sum::<f64>() + self.loads.iter().map(spring).sum::<f64>()
    }
}

/// The sum of the loads on the bodies' coordinates.
struct Loads<'a> {
    state: &'a State,
    on: DVector<f64>,
}

impl Loads<'_> {
    fn force(&mut self, at: At, force: Vector2<f64>) {
        if let Some(body) = at.body {
            self.on[3 * body] += force.x;
            self.on[3 * body + 1] += force.y;
            self.on[3 * body + 2] += cross(self.state.world(at.body, at.local), force);
        }
    }

    /// On the second point, at once its opposite on the first, both in one line or at one place.
    fn pair(&mut self, between: [At; 2], force: Vector2<f64>) {
        self.force(between[1], force);
        self.force(between[0], -force);
    }

    fn torque(&mut self, between: [Option<usize>; 2], torque: f64) {
        for (body, sign) in between.into_iter().zip([-1.0, 1.0]) {
            if let Some(body) = body {
                self.on[3 * body + 2] += sign * torque;
            }
        }
    }

    fn damp(&mut self, joint: &Joint) {
        let (state, between) = (self.state, joint.between);
        match joint.kind {
            JointKind::Revolute => self.torque(joint.bodies(), revolute_damping(joint, state)),
            JointKind::Prismatic { axis, .. } => {
                let first = between[0].body;
                let along = state.world(first, axis);
                let force = -joint.damping * slide(joint, axis, state).1 * along;
                // The force acts at the second point; the first body feels it there too.
                let gap = state.position(between[1]) - state.position(between[0]);
                self.pair(between, force);
                self.torque([first, None], cross(gap, force));
            }
            JointKind::Weld { .. } => {}
        }
    }

    fn load(&mut self, load: &Load) {
        let state = self.state;
        match *load {
            Load::Force { on, vector, in_body } => {
                self.force(on, if in_body { state.world(on.body, vector) } else { vector });
            }
            Load::Torque { between, value } => self.torque(between, value),
            Load::Spring { between, .. } => self.pair(between, line_force(load, state) * state.line(between).0),
            Load::TorsionSpring { between, .. } => self.torque(between, torsion(load, state)),
        }
    }
}

fn revolute_damping(joint: &Joint, state: &State) -> f64 {
    let [a, b] = joint.bodies();
    -joint.damping * (state.omega(b) - state.omega(a))
}

/// Displacement of a prismatic joint and its rate, as the first body sees it.
pub fn slide(joint: &Joint, axis: Vector2<f64>, state: &State) -> (f64, f64) {
    let [a, b] = joint.between;
    let along = state.world(a.body, axis);
    let gap = state.position(b) - state.position(a);
    let gap_rate = state.velocity(b) - state.velocity(a);
    (along.dot(&gap), along.dot(&gap_rate) + state.omega(a.body) * turned(along).dot(&gap))
}

/// What a spring pushes its points apart with.
pub fn line_force(load: &Load, state: &State) -> f64 {
    let &Load::Spring { between, stiffness, length, damping } = load else {
        return 0.0;
    };
    let (_, now, rate) = state.line(between);
    -stiffness * (now - length) - damping * rate
}

/// What a torsion spring turns its second body with.
pub fn torsion(load: &Load, state: &State) -> f64 {
    let &Load::TorsionSpring { between: [a, b], stiffness, angle, damping } = load else {
        return 0.0;
    };
    -stiffness * (state.angle(b) - state.angle(a) - angle) - damping * (state.omega(b) - state.omega(a))
}
