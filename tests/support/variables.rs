//! The values of a solved system under the names that scenes, results and FMUs use.
//!
//! Bodies are `b0`, `b1`, ..., joints `j0`, drivers `d0`, loads `l0`; the points of joint `j0` are `j0a` and `j0b`.

use super::absolute::{At, Driver, JointKind, Load, State, System, turned};
use super::loads::{line_force, slide, torsion};
use nalgebra::Vector2;
use std::collections::BTreeMap;

/// Value by name.
pub type Variables = BTreeMap<String, f64>;

/// Every point that an element uses, with its name within its body or the ground.
pub fn points(system: &System) -> Vec<(String, At)> {
    let joints = system.joints.iter().enumerate().map(|(i, joint)| (format!("j{i}"), joint.between));
    let springs = system.loads.iter().enumerate().filter_map(|(i, load)| match *load {
        Load::Spring { between, .. } => Some((format!("l{i}"), between)),
        _ => None,
    });
    let pairs = joints.chain(springs).flat_map(|(name, [a, b])| [(format!("{name}a"), a), (format!("{name}b"), b)]);
    let forces = system.loads.iter().enumerate().filter_map(|(i, load)| match *load {
        Load::Force { on, .. } => Some((format!("l{i}"), on)),
        _ => None,
    });
    let paths = system.drivers.iter().enumerate().filter_map(|(i, driver)| match *driver {
        Driver::Position { on, .. } => Some((format!("d{i}"), on)),
        _ => None,
    });
    pairs.chain(forces).chain(paths).collect()
}

/// `ground` or `b3`.
pub fn owner(body: Option<usize>) -> String {
    body.map_or("ground".into(), |b| format!("b{b}"))
}

/// All variables of the naming table at one state.
pub fn variables(system: &System, state: &State, t: f64) -> Variables {
    let solution = system.solve(state, t);
    let a = &solution.acceleration;
    let mut values = Named::default();
    for i in 0..system.bodies.len() {
        let k = 3 * i;
        values.add(&format!("b{i}"), &["x", "y", "angle"], &[state.q[k], state.q[k + 1], state.q[k + 2]]);
        values.add(&format!("b{i}"), &["vx", "vy", "omega"], &[state.v[k], state.v[k + 1], state.v[k + 2]]);
        values.add(&format!("b{i}"), &["ax", "ay", "alpha"], &[a[k], a[k + 1], a[k + 2]]);
    }
    for (name, at) in points(system).into_iter().filter(|(_, at)| at.body.is_some()) {
        let (p, v, a) = (state.position(at), state.velocity(at), state.acceleration(at, a));
        values.add(
            &format!("{}.{name}", owner(at.body)),
            &["x", "y", "vx", "vy", "ax", "ay"],
            &[p.x, p.y, v.x, v.y, a.x, a.y],
        );
    }
    values.joints(system, state, a, &solution.joints);
    values.drivers(system, &solution.drivers);
    values.loads(system, state);
    let (kinetic, potential) = (system.kinetic_energy(state), system.potential_energy(state));
    values.add("energy", &["kinetic", "potential", "total"], &[kinetic, potential, kinetic + potential]);
    values.0
}

#[derive(Default)]
struct Named(Variables);

impl Named {
    fn add(&mut self, owner: &str, quantities: &[&str], values: &[f64]) {
        for (quantity, value) in quantities.iter().zip(values) {
            self.0.insert(format!("{owner}.{quantity}"), *value);
        }
    }

    fn joints(&mut self, system: &System, state: &State, a: &nalgebra::DVector<f64>, loads: &[Vec<f64>]) {
        for (i, (joint, loads)) in system.joints.iter().zip(loads).enumerate() {
            let name = format!("j{i}");
            match joint.kind {
                JointKind::Revolute => {
                    let [first, second] = joint.bodies();
                    let alpha = |body: Option<usize>| body.map_or(0.0, |b| a[3 * b + 2]);
                    let relative = |value: &dyn Fn(Option<usize>) -> f64| value(second) - value(first);
                    let motion = [relative(&|b| state.angle(b)), relative(&|b| state.omega(b)), relative(&alpha)];
                    self.add(&name, &["angle", "omega", "alpha"], &motion);
                    self.add(&name, &["fx", "fy"], loads);
                }
                JointKind::Prismatic { axis, .. } => {
                    let (s, v) = slide(joint, axis, state);
                    self.add(&name, &["s", "v", "a"], &[s, v, slide_acceleration(joint.between, axis, state, a)]);
                    self.add(&name, &["fn", "torque"], loads);
                }
                JointKind::Weld { .. } => self.add(&name, &["fx", "fy", "torque"], loads),
            }
        }
    }

    fn drivers(&mut self, system: &System, efforts: &[Vec<f64>]) {
        for (i, (driver, effort)) in system.drivers.iter().zip(efforts).enumerate() {
            // All generated drivers are read at time zero: their rate is the second entry of the motion.
            let (quantities, power): (&[&str], f64) = match driver {
                Driver::Angle { motion, .. } => (&["torque"], effort[0] * motion[1]),
                Driver::Displacement { motion, .. } => (&["force"], effort[0] * motion[1]),
                Driver::Position { motion, .. } => (&["fx", "fy"], effort[0] * motion[1].x + effort[1] * motion[1].y),
            };
            self.add(&format!("d{i}"), quantities, effort);
            self.add(&format!("d{i}"), &["power"], &[power]);
        }
    }

    fn loads(&mut self, system: &System, state: &State) {
        for (i, load) in system.loads.iter().enumerate() {
            let name = format!("l{i}");
            match *load {
                Load::Spring { between, .. } => {
                    let (_, length, rate) = state.line(between);
                    self.add(&name, &["length", "rate", "force"], &[length, rate, line_force(load, state)]);
                }
                Load::TorsionSpring { between: [a, b], .. } => {
                    let (angle, omega) = (state.angle(b) - state.angle(a), state.omega(b) - state.omega(a));
                    self.add(&name, &["angle", "omega", "torque"], &[angle, omega, torsion(load, state)]);
                }
                Load::Force { .. } | Load::Torque { .. } => {}
            }
        }
    }
}

/// Second derivative of a prismatic joint's displacement, as the first body sees it.
fn slide_acceleration([first, second]: [At; 2], axis: Vector2<f64>, state: &State, a: &nalgebra::DVector<f64>) -> f64 {
    let along = state.world(first.body, axis);
    let normal = turned(along);
    let (omega, alpha) = (state.omega(first.body), first.body.map_or(0.0, |b| a[3 * b + 2]));
    let gap = state.position(second) - state.position(first);
    let rate = state.velocity(second) - state.velocity(first);
    let acceleration = state.acceleration(second, a) - state.acceleration(first, a);
    along.dot(&acceleration) + 2.0 * omega * normal.dot(&rate) + alpha * normal.dot(&gap)
        - omega * omega * along.dot(&gap)
}
