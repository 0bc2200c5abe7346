//! Starts far away: known angles of hundreds of radians, distances of kilometres.

use std::f64::consts::TAU;

use cotree::scene::{Body, Scene};

use super::closed_form::ClosedForm;
use super::dyad::Loop;
use super::flaps::turning;
use super::four_bar::bar;
use super::reference::Reference;
use super::{Case, Random};
use crate::support::jet::Jet;

const TIMES: [f64; 3] = [0.5, 1.0, 2.0];

/// A crank that has turned many times before, in a four-bar two kilometres off the origin.
pub fn loop_far_away(seed: u64) -> Case {
    let bars = turning(seed);
    let mut random = Random(seed);
    let [x, y] = [random.between(-2000.0, 2000.0), random.between(-2000.0, 2000.0)];
    let turns = (80.0 * random.between(-1.0, 1.0)).round() * TAU;
    let chain = Loop::of(&bars);
    let arms = [bars.crank, bars.coupler, bars.rocker];
    let inertias = arms.iter().zip(bars.masses).map(|(l, m)| [m, m * l * l / 12.0]).collect();
    let pose = |q: &[Jet]| chain.arms(q[0]).map(|arm| arm.middle()).to_vec();
    let force = |_: f64, _: &[f64], _: &[f64]| vec![0.0];
    let exact = ClosedForm { inertias, pose, force, gravity: bars.gravity };
    let states = exact.states([vec![bars.angle], vec![bars.omega]], &TIMES);
    let values = states.iter().map(|state| {
        let motions = [0, 1, 2].map(|body| exact.motion(body, state));
        motions.iter().flat_map(|motion| [motion[2], motion[5]]).collect()
    });
    const NAMES: [&str; 3] = ["crank", "coupler", "rocker"];
    let names = NAMES.iter().flat_map(|body| [format!("{body}.angle"), format!("{body}.omega")]).collect();
    let reference = Reference { names, times: TIMES.into(), values: values.collect() };
    let mut scene = Scene::new(&format!("far_loop_{seed}"))
        .gravity([0.0, -bars.gravity])
        .ground_point("near", [x, y])
        .ground_point("far", [x + bars.base, y]);
    for ((body, length), mass) in NAMES.into_iter().zip(arms).zip(bars.masses) {
        scene = scene.body(body, bar(mass, length));
    }
    let [coupler, rocker] = bars.angles();
    let scene = scene
        .revolute("crank_pivot", "ground.near", "crank.a")
        .revolute("crank_pin", "crank.b", "coupler.a")
        .revolute("rocker_pin", "coupler.b", "rocker.b")
        .revolute("rocker_pivot", "rocker.a", "ground.far")
        .initial("crank.angle", bars.angle + turns)
        .initial("crank.omega", bars.omega)
        .guess("coupler.angle", coupler)
        .guess("rocker.angle", rocker);
    // At two kilometres a rounding error is 1e-12 of a bar, and change points multiply it.
    Case::new("loop far away", scene, 2.0, vec![bars.law()]).against(reference).within(1000.0, 1e-7)
}

/// A carriage on rails kilometres away, with a pendulum that has turned many times.
pub fn carriage_far_away(seed: u64) -> Case {
    let mut random = Random(seed);
    let (mass, bob, length) = (random.between(0.5, 3.0), random.between(0.2, 2.0), random.between(0.3, 1.5));
    let (x, angle) = (random.between(-2000.0, 2000.0), random.between(-500.0, 500.0));
    let (vx, omega) = (random.between(-5.0, 5.0), random.between(-6.0, 6.0));
    let inertia = bob * length * length / 12.0;
    let pose = |q: &[Jet]| {
        let ((s, c), half, zero) = (q[1].sin_cos(), Jet::constant(0.5 * length), Jet::constant(0.0));
        vec![[q[0], zero, Jet::constant(1.0), zero], [q[0] + half * c, half * s, c, s]]
    };
    let force = |_: f64, _: &[f64], _: &[f64]| vec![0.0, 0.0];
    let exact = ClosedForm { inertias: vec![[mass, 0.0], [bob, inertia]], pose, force, gravity: 9.81 };
    // Only the distance from the start matters.
    let states = exact.states([vec![0.0, angle], vec![vx, omega]], &TIMES);
    let values = states.iter().map(|[q, v]| vec![x + q[0], v[0], q[1], v[1]]).collect();
    let names = ["carriage.x", "carriage.vx", "bob.angle", "bob.omega"].map(String::from).into();
    let reference = Reference { names, times: TIMES.into(), values };
    let scene = Scene::new(&format!("far_carriage_{seed}"))
        .gravity([0.0, -9.81])
        .body("carriage", Body::new().mass(mass))
        .body("bob", bar(bob, length))
        .prismatic("rail", "ground", "carriage", [1.0, 0.0])
        .revolute("eye", "carriage", "bob.a")
        .initial("carriage.x", x)
        .initial("carriage.vx", vx)
        .initial("bob.angle", angle)
        .initial("bob.omega", omega);
    // Angles of 500 rad are known to 1e-13.
    Case::new("carriage far away", scene, 2.0, vec![]).against(reference).within(1000.0, 1e-8)
}
