//! The independent reference that other tests lean on must itself be right.

use crate::support::absolute::{At, Body, Joint, JointKind, Load, State, System};
use crate::support::loads::cross;
use crate::support::random::{Family, random_case};
use nalgebra::{DVector, Matrix2, Vector2};
use std::collections::BTreeMap;

const FAMILIES: [Family; 5] = [Family::Chain, Family::Tree, Family::Loops, Family::Driven, Family::Redundant];

fn at(body: Option<usize>, x: f64) -> At {
    At { body, local: Vector2::new(x, 0.0) }
}

/// Two bars of length 2a and 2b hanging from each other.
fn double_pendulum(a: f64, b: f64) -> System {
    let pin = |between| Joint { between, kind: JointKind::Revolute, damping: 0.0 };
    System {
        gravity: Vector2::new(0.0, -9.81),
        bodies: vec![Body { mass: 1.5, inertia: 0.2 }, Body { mass: 0.7, inertia: 0.1 }],
        joints: vec![pin([at(None, 0.0), at(Some(0), -a)]), pin([at(Some(0), a), at(Some(1), -b)])],
        ..System::default()
    }
}

fn close(name: &str, value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance * (1.0 + expected.abs()), "{name}: {value} instead of {expected}");
}

#[test]
fn double_pendulum_agrees_with_lagrange() {
    let (a, b, [t1, t2], [w1, w2]) = (0.4, 0.3, [0.3_f64, -1.1_f64], [1.7, -0.6]);
    let system = double_pendulum(a, b);
    let arm = |angle: f64, length: f64| Vector2::new(angle.cos(), angle.sin()) * length;
    let (c1, c2) = (arm(t1, a), arm(t1, 2.0 * a) + arm(t2, b));
    let mut state = State {
        q: DVector::from_vec(vec![c1.x, c1.y, t1, c2.x, c2.y, t2]),
        v: DVector::from_vec(vec![0.0, 0.0, w1, 0.0, 0.0, w2]),
    };
    state.v = DVector::from_vec({
        let side = |angle: f64, length: f64| Vector2::new(-angle.sin(), angle.cos()) * length;
        let (v1, v2) = (side(t1, a) * w1, side(t1, 2.0 * a) * w1 + side(t2, b) * w2);
        vec![v1.x, v1.y, w1, v2.x, v2.y, w2]
    });
    let (m1, m2, g) = (system.bodies[0].mass, system.bodies[1].mass, 9.81);
    let coupling = m2 * 2.0 * a * b;
    let mass = Matrix2::new(
        system.bodies[0].inertia + m1 * a * a + m2 * 4.0 * a * a,
        coupling * (t1 - t2).cos(),
        coupling * (t1 - t2).cos(),
        system.bodies[1].inertia + m2 * b * b,
    );
    let load = Vector2::new(
        -coupling * (t1 - t2).sin() * w2 * w2 - (m1 * a + m2 * 2.0 * a) * g * t1.cos(),
        coupling * (t1 - t2).sin() * w1 * w1 - m2 * b * g * t2.cos(),
    );
    let expected = mass.lu().solve(&load).expect("the mass matrix is regular");
    let solution = system.solve(&state, 0.0);
    close("alpha 1", solution.acceleration[2], expected[0], 1e-13);
    close("alpha 2", solution.acceleration[5], expected[1], 1e-13);
    // The elbow carries the lower bar: m2 (a2 - g).
    close("elbow fx", solution.joints[1][0], m2 * solution.acceleration[3], 1e-13);
    close("elbow fy", solution.joints[1][1], m2 * (solution.acceleration[4] + g), 1e-13);
}

#[test]
fn random_states_close_and_move_as_joints_and_drivers_permit() {
    for (family, seed) in FAMILIES.into_iter().flat_map(|family| (0..40).map(move |seed| (family, seed))) {
        let case = random_case(seed, family);
        let constraints = case.system.constraints(&case.state, 0.0);
        let rate = &constraints.jacobian * &case.state.v + &constraints.rate;
        assert!(constraints.residual.amax() < 1e-13, "{family:?} {seed}: gap {}", constraints.residual.amax());
        assert!(rate.amax() < 1e-12, "{family:?} {seed}: gap rate {}", rate.amax());
    }
}

/// Along q + v h + a h^2/2 the constraints must stay closed up to the third order of h: a check of J and gamma without either.
#[test]
fn accelerations_keep_the_joints_closed() {
    for (family, seed) in FAMILIES.into_iter().flat_map(|family| (0..40).map(move |seed| (family, seed))) {
        let case = random_case(seed, family);
        let acceleration = case.system.solve(&case.state, 0.0).acceleration;
        let gap = |h: f64| {
            let q = &case.state.q + &case.state.v * h + &acceleration * (h * h / 2.0);
            let constraints = case.system.constraints(&State { q, v: case.state.v.clone() }, h);
            constraints.residual.amax()
        };
        let (h, floor) = (1e-3, 1e-12);
        assert!(gap(h / 4.0) <= gap(h) / 40.0 + floor, "{family:?} {seed}: {} {}", gap(h), gap(h / 4.0));
    }
}

/// Newton and Euler for each body, with the named reactions as plain forces on its points.
#[test]
fn named_reactions_balance_every_body() {
    for (family, seed) in
        [Family::Chain, Family::Tree, Family::Loops].into_iter().flat_map(|f| (0..40).map(move |s| (f, s)))
    {
        let case = random_case(seed, family);
        let (system, state, values) = (&case.system, &case.state, &case.expected);
        let mut load = system.applied(state);
        for (i, joint) in system.joints.iter().enumerate() {
            let value = |quantity: &str| values.get(&format!("j{i}.{quantity}")).copied().unwrap_or(0.0);
            let force = match joint.kind {
                JointKind::Prismatic { axis, .. } => {
                    state.world(joint.between[0].body, Vector2::new(-axis.y, axis.x)) * value("fn")
                }
                _ => Vector2::new(value("fx"), value("fy")),
            };
            // The joint's load acts on both bodies at one place: the second point.
            let place = state.position(joint.between[1]);
            for (body, sign) in joint.bodies().into_iter().zip([-1.0, 1.0]) {
                let Some(k) = body.map(|b| 3 * b) else {
                    continue;
                };
                let arm = place - Vector2::new(state.q[k], state.q[k + 1]);
                load[k] += sign * force.x;
                load[k + 1] += sign * force.y;
                load[k + 2] += sign * (cross(arm, force) + value("torque"));
            }
        }
        let acceleration = load.component_div(&system.masses());
        for b in 0..system.bodies.len() {
            for (c, name) in ["ax", "ay", "alpha"].iter().enumerate() {
                close(
                    &format!("{family:?} {seed} b{b}.{name}"),
                    acceleration[3 * b + c],
                    values[&format!("b{b}.{name}")],
                    1e-9,
                );
            }
        }
    }
}

/// Classical Runge-Kutta steps, without projection.
fn advance(system: &System, state: &State, h: f64, steps: usize) -> State {
    let rate = |s: &State| (s.v.clone(), system.solve(s, 0.0).acceleration);
    let moved = |s: &State, (q, v): &(DVector<f64>, DVector<f64>), h: f64| State { q: &s.q + q * h, v: &s.v + v * h };
    let mut now = state.clone();
    for _ in 0..steps {
        let k1 = rate(&now);
        let k2 = rate(&moved(&now, &k1, h / 2.0));
        let k3 = rate(&moved(&now, &k2, h / 2.0));
        let k4 = rate(&moved(&now, &k3, h));
        let mean =
            |a: &DVector<f64>, b: &DVector<f64>, c: &DVector<f64>, d: &DVector<f64>| (a + (b + c) * 2.0 + d) / 6.0;
        now = moved(&now, &(mean(&k1.0, &k2.0, &k3.0, &k4.0), mean(&k1.1, &k2.1, &k3.1, &k4.1)), h);
    }
    now
}

#[test]
fn energy_stays_without_damping_and_external_loads() {
    for seed in 0..20 {
        let mut case = random_case(seed, Family::Loops);
        for joint in &mut case.system.joints {
            joint.damping = 0.0;
        }
        case.system.loads.retain(|load| !matches!(load, Load::Force { .. } | Load::Torque { .. }));
        for load in &mut case.system.loads {
            if let Load::Spring { damping, .. } | Load::TorsionSpring { damping, .. } = load {
                *damping = 0.0;
            }
        }
        let energy = |state: &State| case.system.kinetic_energy(state) + case.system.potential_energy(state);
        let later = advance(&case.system, &case.state, 1e-4, 100);
        close(&format!("energy, seed {seed}"), energy(&later), energy(&case.state), 1e-9);
    }
}

#[test]
fn a_damped_joint_takes_out_its_power() {
    for seed in 0..20 {
        let mut case = random_case(seed, Family::Loops);
        case.system.loads.clear();
        case.system.gravity = Vector2::zeros();
        let power =
            case.state.v.dot(&case.system.masses().component_mul(&case.system.solve(&case.state, 0.0).acceleration));
        let values: BTreeMap<_, _> = crate::support::variables::variables(&case.system, &case.state, 0.0);
        let lost: f64 = case
            .system
            .joints
            .iter()
            .enumerate()
            .map(|(i, joint)| {
                let rate =
                    values.get(&format!("j{i}.omega")).or(values.get(&format!("j{i}.v"))).copied().unwrap_or(0.0);
                joint.damping * rate * rate
            })
            .sum();
        close(&format!("power, seed {seed}"), power, -lost, 1e-11);
    }
}

#[test]
fn scene_texts_are_complete_and_repeatable() {
    for (family, seed) in FAMILIES.into_iter().flat_map(|family| (0..20).map(move |seed| (family, seed))) {
        let case = random_case(seed, family);
        let table: toml::Table =
            case.scene.parse().unwrap_or_else(|fault| panic!("{family:?} {seed}: {fault}\n{}", case.scene));
        let count = |key: &str| table.get(key).and_then(|t| t.as_table()).map_or(0, |t| t.len());
        assert_eq!(count("bodies"), case.system.bodies.len());
        assert_eq!(count("joints"), case.system.joints.len());
        assert_eq!(count("drivers"), case.system.drivers.len());
        assert_eq!(count("loads"), case.system.loads.len());
        assert_eq!(count("initial"), 6 * case.system.bodies.len());
        assert_eq!(case.scene, random_case(seed, family).scene);
    }
}
