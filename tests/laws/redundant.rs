//! Mechanisms with more joints than they need, in a consistent state.

use std::f64::consts::PI;

use cotree::formulate::formulate;
use nalgebra::{DVector, Rotation2, Vector2};

use super::mechanism;
use crate::support::absolute::{At, Body, Joint, JointKind, State, System};
use crate::support::random::{Case, Random};
use crate::support::scene_text::scene_text;
use crate::support::variables::variables;

/// A platform on three to five parallel cranks, of which it needs two.
pub fn parallel_cranks(seed: u64) -> Case {
    let mut random = Random(seed);
    let (count, length) = (3 + random.below(3), random.number(0.5, 1.0));
    let (angle, omega) = (random.number(-PI, PI), random.number(1.0, 3.0));
    let arm = Rotation2::new(angle) * Vector2::new(length, 0.0);
    let body = |random: &mut Random| Body { mass: random.number(0.5, 3.0), inertia: random.number(0.05, 0.5) };
    let mut system = System { gravity: random.vector(10.0), bodies: vec![body(&mut random)], ..System::default() };
    let (mut q, mut v) = (vec![arm.x, arm.y, 0.0], vec![-omega * arm.y, omega * arm.x, 0.0]);
    for crank in 1..=count {
        let pin = Vector2::new(crank as f64, 0.0) + random.vector(0.4);
        system.bodies.push(body(&mut random));
        q.extend([pin.x + 0.5 * arm.x, pin.y + 0.5 * arm.y, angle]);
        v.extend([-0.5 * omega * arm.y, 0.5 * omega * arm.x, omega]);
        let [foot, head] = [-0.5, 0.5].map(|x| At { body: Some(crank), local: Vector2::new(x * length, 0.0) });
        let [ground, platform] = [None, Some(0)].map(|body| At { body, local: pin });
        for between in [[ground, foot], [head, platform]] {
            system.joints.push(Joint { between, kind: JointKind::Revolute, damping: 0.0 });
        }
    }
    case(seed, system, State { q: DVector::from_vec(q), v: DVector::from_vec(v) })
}

/// A carriage on two or three rails side by side, with a pendulum.
pub fn double_guides(seed: u64) -> Case {
    let mut random = Random(seed);
    let (tilt, rails) = (random.number(-PI, PI), 2 + random.below(2));
    let along = Rotation2::new(tilt) * Vector2::x();
    let body = |random: &mut Random| Body { mass: random.number(0.5, 3.0), inertia: random.number(0.05, 0.5) };
    let bodies = vec![body(&mut random), body(&mut random)];
    let mut system = System { gravity: random.vector(10.0), bodies, ..System::default() };
    let (centre, angle, speed) = (random.vector(1.0), random.number(-PI, PI), random.number(-2.0, 2.0));
    let to_carriage = |world: Vector2<f64>| Rotation2::new(-angle) * (world - centre);
    for _ in 0..rails {
        let (start, shift) = (random.vector(1.0), random.number(-1.0, 1.0));
        let between =
            [At { body: None, local: start }, At { body: Some(0), local: to_carriage(start + shift * along) }];
        system.joints.push(Joint { between, kind: JointKind::Prismatic { axis: along, angle }, damping: 0.0 });
    }
    let (pin, turn, omega) = (random.vector(1.0), random.number(-PI, PI), random.number(-3.0, 3.0));
    let arm = random.vector(0.5);
    let bob = At { body: Some(1), local: Rotation2::new(-turn) * -arm };
    let between = [At { body: Some(0), local: to_carriage(pin) }, bob];
    system.joints.push(Joint { between, kind: JointKind::Revolute, damping: 0.0 });
    let (there, rate) = (pin + arm, speed * along);
    let q = vec![centre.x, centre.y, angle, there.x, there.y, turn];
    let v = vec![rate.x, rate.y, 0.0, rate.x - omega * arm.y, rate.y + omega * arm.x, omega];
    case(seed, system, State { q: DVector::from_vec(q), v: DVector::from_vec(v) })
}

fn case(seed: u64, system: System, state: State) -> Case {
    let expected = variables(&system, &state, 0.0);
    let scene = scene_text(&format!("redundant_{seed}"), &system, &state, &expected);
    Case { scene, expected, system, state }
}

/// A platform on cranks can be assembled in other ways too, in which it cannot move: those say nothing of the motion.
#[test]
fn parallel_cranks_move_whatever_other_assemblies_they_have() {
    for seed in 100..260 {
        let mechanism = mechanism(&parallel_cranks(seed).scene);
        let formulated = formulate(&mechanism, &[]).unwrap_or_else(|faults| panic!("{seed}: {}", faults[0].message));
        assert_eq!(formulated.mobility(), 1, "{seed}");
    }
}
