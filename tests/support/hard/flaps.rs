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

/// Somewhat out of rest against the rocker: the spring rings.
pub fn flap(seed: u64) -> Case {
    ringing("stiff flap at change points", seed, [3.0, 6.0], 1e-3)
}

/// Springs so stiff that steps follow their ringing past the poses; only the acceleration of the rocker makes them ring.
pub fn very_stiff(seed: u64) -> Case {
    ringing("very stiff flap at change points", seed, [7.0, 8.5], 0.0)
}

/// Powers of ten of the stiffness. The free coordinates are the crank's angle and what the spring is wound up by, times the frequency of its ringing: of the flap's
/// own angle rounding would be what rings.
fn ringing(family: &'static str, seed: u64, powers: [f64; 2], out_of_rest: f64) -> Case {
    let bars = turning(seed);
    let mut random = Random(seed);
    let stiffness = 10.0_f64.powf(random.between(powers[0], powers[1]));
    let frequency = (stiffness / INERTIA).sqrt();
    let twist = random.between(-0.2, 0.2);
    let chain = Loop::of(&bars);
    let arms = [bars.crank, bars.coupler, bars.rocker];
    let mut inertias: Vec<[f64; 2]> = arms.iter().zip(bars.masses).map(|(l, m)| [m, m * l * l / 12.0]).collect();
    inertias.push([MASS, INERTIA]);
    let pose = |q: &[Jet]| {
        let [crank, coupler, rocker] = chain.arms(q[0]);
        let ([c, s], [x, y]) = (rocker.direction, rocker.tip);
        let (sine, cosine) = (Jet::constant(twist) + Jet::constant(1.0 / frequency) * q[1]).sin_cos();
        let flap = [x, y, c * cosine - s * sine, s * cosine + c * sine];
        vec![crank.middle(), coupler.middle(), rocker.middle(), flap]
    };
    let spring = |_: f64, q: &[f64], _: &[f64]| vec![0.0, -INERTIA * q[1]];
    let exact = ClosedForm { inertias, pose, force: spring, gravity: bars.gravity };
    let rocker = exact.motion(2, &[vec![bars.angle, 0.0], vec![bars.omega, 0.0]]);
    let start = [rocker[2] + twist + out_of_rest, rocker[5]];
    let wound_up = start[0] - rocker[2] - twist;
    let states = exact.states([vec![bars.angle, frequency * wound_up], vec![bars.omega, 0.0]], &TIMES);
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
    Case::new(family, scene, 2.0, vec![bars.law()]).against(reference).within(1000.0, 1e-8)
}
