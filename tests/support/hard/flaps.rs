//! Stiff, undamped springs where branches of a motion cross: a four-bar with change points whose rocker carries a flap.

use cotree::scene::{Body, Load};

use super::closed_form::ClosedForm;
use super::dyad::Loop;
use super::four_bar::{FourBar, neutral};
use super::reference::Reference;
use super::{Case, Random};
use crate::support::jet::Jet;

const MASS: f64 = 0.1;
const INERTIA: f64 = 0.05;
const TIMES: [f64; 4] = [0.5, 1.0, 1.5, 2.0];

/// A change-point four-bar whose crank can turn all the way round.
pub fn turning(seed: u64) -> FourBar {
    (0..).map(|k| neutral(1_000 * seed + k)).find(|bars| Loop::of(bars).turns()).expect("one in four can")
}

/// Crank and flap are the free coordinates: the rocker follows from the crank.
pub fn flap(seed: u64) -> Case {
    let bars = turning(seed);
    let mut random = Random(seed);
    let stiffness = 10.0_f64.powf(random.between(3.0, 6.0));
    let twist = random.between(-0.2, 0.2);
    let chain = Loop::of(&bars);
    let arms = [bars.crank, bars.coupler, bars.rocker];
    let mut inertias: Vec<[f64; 2]> = arms.iter().zip(bars.masses).map(|(l, m)| [m, m * l * l / 12.0]).collect();
    inertias.push([MASS, INERTIA]);
    let pose = |q: &[Jet]| {
        let [crank, coupler, rocker] = chain.arms(q[0]);
        let (s, c) = q[1].sin_cos();
        vec![crank.middle(), coupler.middle(), rocker.middle(), [rocker.tip[0], rocker.tip[1], c, s]]
    };
    // The spring sees the flap's angle against the rocker's.
    let spring = |_: f64, q: &[f64], _: &[f64]| {
        let rocker = |direction: f64| chain.arms(Jet([q[0], direction, 0.0]))[2].direction;
        let [c, s] = rocker(1.0);
        let ratio = c.0[0] * s.0[1] - s.0[0] * c.0[1];
        let off = q[1] - s.0[0].atan2(c.0[0]) - twist;
        let moment = stiffness * (off - std::f64::consts::TAU * (off / std::f64::consts::TAU).round());
        vec![moment * ratio, -moment]
    };
    let exact = ClosedForm { inertias, pose, force: spring, gravity: bars.gravity };
    let still = |angle: f64, omega: f64| exact.motion(2, &[vec![angle, 0.0], vec![omega, 0.0]]);
    let rocker = still(bars.angle, bars.omega);
    // Somewhat out of rest against the rocker: the spring rings.
    let start = [rocker[2] + twist + 1e-3, rocker[5]];
    let states = exact.states([vec![bars.angle, start[0]], vec![bars.omega, start[1]]], &TIMES);
    let values = states.iter().map(|state| {
        let motions = [0, 2, 3].map(|body| exact.motion(body, state));
        motions.iter().flat_map(|motion| [motion[2], motion[5]]).collect()
    });
    let names = ["crank", "rocker", "flap"].iter().flat_map(|body| [format!("{body}.angle"), format!("{body}.omega")]);
    let reference = Reference { names: names.collect(), times: TIMES.into(), values: values.collect() };
    let scene = bars
        .scene(&format!("ringing_flap_{seed}"))
        .body("flap", Body::new().mass(MASS).inertia(INERTIA))
        .revolute("hinge", "rocker.b", "flap")
        .load("spring", Load::torsion_spring("rocker", "flap", stiffness).free(twist))
        .initial("flap.angle", start[0])
        .initial("flap.omega", start[1]);
    // Each change point multiplies rounding errors, those of the reference too.
    Case::new("stiff flap at change points", scene, 2.0, vec![bars.law()]).against(reference).within(1000.0, 1e-8)
}
